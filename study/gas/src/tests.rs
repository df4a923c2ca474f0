use nalgebra::Vector3;
use stosszahl_model::walls::Vibration;
use stosszahl_model::{Budget, Collision, Interrupt, Observer, Particles, Volume};

use super::*;

/// Observer that asks for a pause at its first collision.
struct Enough<'a>(&'a Interrupt);

impl Observer for Enough<'_> {
    fn on_collisions(&mut self, _batch: &[Collision]) {
        self.0.raise();
    }
}

/// Advances to a time with a pause wherever the engine makes one, at most `most` times; returns the
/// number of pauses.
fn with_pauses(engine: &mut dyn Simulation, until: f64, most: usize) -> Result<usize, GasError> {
    let mut pauses = 0;
    loop {
        let pause = Interrupt::default();
        if pauses < most {
            engine.set_pause_flag(&pause);
        }
        let before = engine.time();
        if engine.advance(until, Budget::Unlimited, &mut Enough(&pause))? {
            return Ok(pauses);
        }
        pauses += 1;
        let time = engine.time();
        assert!(time > before && time < until && !engine.is_interrupted());
        // Reading the gas in a pause changes nothing.
        assert_eq!(engine.particles().all.len(), engine.particle_count());
    }
}

fn wall(rebound: Rebound, vibration: Option<Vibration>) -> Face<Volume> {
    Face::Wall(Wall {
        vibration,
        ..Wall::still(rebound)
    })
}

#[test]
fn a_paused_gas_goes_on_to_the_same_bytes() -> Result<(), GasError> {
    let until = 4.0;
    let periodic = Gas::disks(300).packing_fraction(0.25).restitution(0.9);
    // Walls that draw random numbers, and walls that move.
    let bounded = periodic
        .clone()
        .walls(
            0,
            [
                wall(Rebound::Diffuse { temperature: 2.0 }, None),
                wall(
                    Rebound::Restitutive {
                        restitution: 0.9,
                        slip: 0.5,
                    },
                    Some(Vibration::new(0.1, 0.7)?),
                ),
            ],
        )
        .gravity([-0.1, 0.0]);
    for gas in [periodic.build()?, bounded.build()?] {
        let mut schemes = 0;
        for scheme in Scheme::ALL {
            // Not all schemes go with walls.
            let Ok(mut paused) = MonteCarlo::from_state(&gas, scheme) else {
                assert!(gas.grains.is_bounded, "{}", scheme.name());
                continue;
            };
            schemes += 1;
            let mut alone = MonteCarlo::from_state(&gas, scheme)?;
            let pauses = with_pauses(&mut *paused, until, usize::MAX)?;
            alone.advance(until, &mut ())?;
            let enough = if scheme == Scheme::Collisionless {
                0
            } else {
                10
            };
            assert!(pauses >= enough, "{}: {pauses} pauses", scheme.name());
            assert_eq!(paused.particles(), alone.particles(), "{}", scheme.name());
            assert_eq!(paused.work_counters(), alone.work_counters());
        }
        assert!(schemes >= 4);
        let (mut paused, mut alone) = (EventDriven::new(&gas)?, EventDriven::new(&gas)?);
        // Exact dynamics checks for a pause every 50000 collisions.
        let until = if gas.grains.is_bounded { 400.0 } else { until };
        let pauses = with_pauses(&mut *paused, until, 2)?;
        alone.advance(until, &mut ())?;
        assert!(pauses > 0 || !gas.grains.is_bounded);
        assert_eq!(paused.particles(), alone.particles());
    }
    let spheres = Gas::spheres(300).restitution(0.9).build()?;
    let (mut paused, mut alone) = (MonteCarlo::new(&spheres)?, MonteCarlo::new(&spheres)?);
    assert!(with_pauses(&mut *paused, 20.0, usize::MAX)? >= 10);
    alone.advance(20.0, &mut ())?;
    assert_eq!(paused.particles(), alone.particles());
    Ok(())
}

#[test]
fn what_is_done_in_a_pause_counts() -> Result<(), GasError> {
    let gas = Gas::disks(300).packing_fraction(0.25).build()?;
    let mut chaos = MonteCarlo::from_state(&gas, Scheme::CONTACT_POINT)?;
    let pause = Interrupt::default();
    chaos.set_pause_flag(&pause);
    chaos.advance(1e3, &mut Enough(&pause))?;
    let middle = chaos.time();
    chaos.scale_velocities(2.0)?;
    chaos.set_pause_flag(&Interrupt::default());
    chaos.advance(middle + 1.0, &mut ())?;
    assert_eq!(chaos.time(), middle + 1.0);
    // Rounding of some 1e4 collisions.
    let ratio = chaos.temperature() / gas.temperature();
    assert!((ratio / 4.0 - 1.0).abs() < 1e-10, "{ratio}");
    Ok(())
}

#[test]
fn a_start_of_ones_own_is_checked() -> Result<(), GasError> {
    let describe = || Gas::disks(2).packing_fraction(0.1).restitution(0.5);
    let gas = describe().build()?;
    let again = describe().start_from(gas.particles.clone()).build()?;
    assert_eq!(again.particles, gas.particles);
    assert_eq!(again.volume, gas.volume);
    let refused = |change: &dyn Fn(&mut Particles)| {
        let mut particles = gas.particles.clone();
        change(&mut particles);
        let made = describe().start_from(particles).build();
        assert!(matches!(made, Err(GasError::Start { .. })));
    };
    refused(&|one| one.all[0].velocity.y = f64::NAN);
    refused(&|one| one.dimension = 3);
    refused(&|one| one.time = f64::INFINITY);
    refused(&|one| one.all.clear());
    refused(&|one| one.all.push(one.all[0]));
    refused(&|one| one.all.truncate(1));
    let mixed = describe()
        .and(3, 1.0, 2.0)
        .start_from(gas.particles.clone());
    assert!(matches!(mixed.build(), Err(GasError::Start { .. })));
    Ok(())
}

#[test]
fn images_are_taken_into_a_periodic_box_and_refused_beyond_walls() -> Result<(), GasError> {
    let specular = || {
        wall(
            Rebound::Restitutive {
                restitution: 1.0,
                slip: 1.0,
            },
            None,
        )
    };
    let describe = || Gas::disks(2).box_size([8.0, 4.0]);
    let mut start = describe().build()?.particles;
    start.all[0].position = Vector3::new(-3.0, 17.0, 0.0);
    start.all[1].position = Vector3::new(2.0, 4.0, 0.0);
    let gas = describe().start_from(start.clone()).build()?;
    let places: Vec<_> = gas.particles.all.iter().map(|one| one.position).collect();
    let inside = [Vector3::new(5.0, 1.0, 0.0), Vector3::new(2.0, 0.0, 0.0)];
    assert_eq!(places, inside);
    let walled = describe()
        .walls(1, [specular(), specular()])
        .start_from(start)
        .build();
    let said = walled
        .err()
        .map(|error| error.to_string())
        .unwrap_or_default();
    assert!(
        said.contains("particle 0 at 17 along axis 1 of a box of 4"),
        "{said}"
    );
    Ok(())
}

#[test]
fn a_box_is_given_once() {
    let both = Gas::disks(10).packing_fraction(0.1).box_size([9.0, 9.0]);
    assert!(matches!(both.build(), Err(GasError::Unfit { .. })));
}

#[test]
fn no_gas_is_larger_than_memory() {
    // At least 128 bytes each: half a terabyte.
    for gas in [Gas::disks(4_000_000_000), Gas::spheres(4_000_000_000)] {
        assert!(matches!(gas.build(), Err(GasError::Memory { .. })));
    }
}

#[test]
fn times_that_cannot_be_reached_are_refused() -> Result<(), GasError> {
    let refused = |engine: &mut EventDriven, until: f64| {
        let before = engine.particles();
        let said = engine.advance(until, &mut ());
        assert!(matches!(said, Err(GasError::Time { .. })), "{until}");
        assert_eq!(engine.particles(), before);
    };
    let elastic = Gas::disks(100).build()?;
    let mut exact = EventDriven::new(&elastic)?;
    exact.advance(1.0, &mut ())?;
    exact.advance(1.0, &mut ())?;
    for until in [
        0.5,
        -1.0,
        f64::NAN,
        f64::INFINITY,
        f64::NEG_INFINITY,
        1e308,
        1e16,
    ] {
        refused(&mut exact, until);
    }
    let mut chaos = MonteCarlo::from_state(&elastic, Scheme::Collisionless)?;
    assert!(chaos.advance(1e308, &mut ()).is_err());
    // A cooling gas, or one at rest, reaches any time below the limit of cases.
    let mut cooling = MonteCarlo::new(&Gas::spheres(100).restitution(0.5).build()?)?;
    assert!(cooling.advance(1e101, &mut ()).is_err());
    cooling.advance(1e20, &mut ())?;
    let mut start = elastic.particles.clone();
    start.all.iter_mut().for_each(|one| one.velocity *= 0.0);
    let still = Gas::disks(100).start_from(start).build()?;
    let mut still = EventDriven::new(&still)?;
    still.advance(1e20, &mut ())?;
    assert_eq!((cooling.time(), still.time()), (1e20, 1e20));
    Ok(())
}

#[test]
fn a_contact_time_lets_a_gas_go_on_that_collapses_for_good_without() -> Result<(), GasError> {
    let describe = || Gas::disks(300).packing_fraction(0.5).restitution(0.3);
    let mut exact = EventDriven::new(&describe().build()?)?;
    let mut say = || match exact.advance(100.0, &mut ()) {
        Err(error) => (exact.time(), error.to_string()),
        Ok(()) => (exact.time(), String::new()),
    };
    let (first, second) = (say(), say());
    assert!(first.1.contains("inelastic collapse") && first.1.contains("contact time"));
    assert_eq!(first, second);
    let mut exact = EventDriven::new(&describe().contact_time(1e-3).build()?)?;
    exact.advance(100.0, &mut ())?;
    assert_eq!(exact.time(), 100.0);
    assert!(describe().contact_time(-1.0).build().is_err());
    assert!(Gas::spheres(10).contact_time(1.0).build().is_err());
    Ok(())
}

/// Sheared gas whose boxes are displaced after some time.
fn sheared() -> GasBuilder {
    let gas = Gas::disks(200).packing_fraction(0.3).restitution(0.9);
    gas.shear_rate(0.7).seed(3)
}

fn enskog() -> Scheme {
    Scheme::named("enskog").expect("a scheme")
}

#[test]
fn a_sheared_gas_goes_on_from_its_state() -> Result<(), GasError> {
    let mut exact = EventDriven::new(&sheared().build()?)?;
    exact.equilibrate(5.0)?;
    assert_eq!(exact.time(), 0.0);
    exact.advance(3.3, &mut ())?;
    let state = exact.state();
    let [width, height, _] = state.particles.lengths;
    let offset = (0.7 * height * 3.3) % width;
    assert!((state.shear_offset() - offset).abs() < 1e-12 * height);
    let rebuilt = sheared().start_from(state.particles.clone()).build()?;
    assert_eq!(rebuilt.particles, state.particles);
    let mut again = EventDriven::new(&rebuilt)?;
    let before = exact.work_counters().collisions;
    exact.advance(3.8, &mut ())?;
    again.advance(3.8, &mut ())?;
    assert!(again.work_counters().collisions > 100);
    assert_eq!(
        exact.work_counters().collisions - before,
        again.work_counters().collisions
    );
    // Rounding of 1e-14, which some ten collisions of a disk raise by a factor of ten each at most.
    let pairs = exact.particles().all.into_iter().zip(again.particles().all);
    let far = pairs.map(|(one, other)| (one.velocity - other.velocity).norm());
    let far = far.fold(0.0, f64::max);
    assert!(far < 1e-4, "{far}");
    // Its state is a start of Monte Carlo too, which starts at the same temperature.
    let mut chaos = MonteCarlo::from_state(&state, enskog())?;
    assert_eq!(chaos.temperature(), state.temperature());
    chaos.advance(3.8, &mut ())?;
    assert!(chaos.work_counters().collisions > 100);
    Ok(())
}

#[test]
fn shear_is_refused_where_it_cannot_be() -> Result<(), GasError> {
    let specular = Rebound::Restitutive {
        restitution: 1.0,
        slip: 1.0,
    };
    let walls = [wall(specular, None), wall(specular, None)];
    for refused in [
        sheared().shear_rate(0.0),
        sheared().shear_rate(f64::NAN),
        sheared().gravity([0.0, -1.0]),
        sheared().walls(0, walls),
        Gas::spheres(100).shear_rate(1.0),
    ] {
        assert!(refused.build().is_err());
    }
    let gas = sheared().build()?;
    assert!(gas.haff_time().is_none());
    let mut exact = EventDriven::new(&gas)?;
    exact.advance(0.3, &mut ())?;
    assert!(matches!(
        exact.equilibrate(1.0),
        Err(GasError::Unfit { .. })
    ));
    // It stays warm, so that no time is reached for free.
    assert!(matches!(
        exact.advance(1e20, &mut ()),
        Err(GasError::Time { .. })
    ));
    Ok(())
}

#[test]
fn a_gas_of_the_delta_model_heats_to_its_steady_state() -> Result<(), GasError> {
    use stosszahl_model::DeltaModel;
    let cold = Gas::disks(200).packing_fraction(0.1).temperature(0.01);
    let gas = cold.law(DeltaModel::new(0.8, 0.1)?).build()?;
    assert!(gas.haff_time().is_none());
    for engine in [
        &mut *EventDriven::new(&gas)? as &mut dyn Simulation,
        &mut *MonteCarlo::from_state(&gas, enskog())?,
    ] {
        engine.advance(400.0, Budget::Unlimited, &mut ())?;
        // T = 0.207 for a Maxwellian; 200 disks fluctuate by 1/sqrt(N) = 7 %, here allowed
        // fivefold.
        let found = engine.temperature();
        assert!((found / 0.207 - 1.0).abs() < 0.35, "{found}");
    }
    Ok(())
}
