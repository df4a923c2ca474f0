//! Segments (legs) of a run: stops within them, and checkpoints at these.

use nalgebra::{Vector3, vector};
use stosszahl_ed::{DiskBoundaries, DissipationRule, resume, simulate};
use stosszahl_model::samples::{UNIT, disks, law, particles_of};
use stosszahl_model::walls::Wall;
use stosszahl_model::{
    Budget, EachCollision, Interrupt, ParticleSpec, Particles, Rebound, Simulation,
};

use crate::support::{gas, walled};

/// Gas of disks, and the scene of its engines.
struct Case {
    grains: ParticleSpec,
    boundaries: DiskBoundaries,
    start: Particles,
}

impl Case {
    fn new(count: usize, side: f64, boundaries: DiskBoundaries) -> Self {
        let state = gas(&disks(0.9), &boundaries, [side; 2], count, 3);
        Self {
            grains: ParticleSpec::equal(0.5, 1.0, law(0.9)),
            boundaries,
            start: particles_of(&UNIT, &state),
        }
    }

    fn begin(&self) -> Box<dyn Simulation> {
        let dissipation = DissipationRule::ContactTime(1e-6);
        simulate(&self.grains, dissipation, &self.boundaries, &self.start).expect("an engine")
    }

    fn resume(&self, checkpoint: &[u8], interrupt: &Interrupt) -> Box<dyn Simulation> {
        resume(
            &self.grains,
            self.start.all.len(),
            DissipationRule::ContactTime(1e-6),
            &self.boundaries,
            checkpoint,
            interrupt,
        )
        .expect("a checkpoint")
    }
}

/// Returns three cases: some hundred disks, of which a segment has more collisions than these
/// tests; as many in a closed box that heats them; and forty in so thin a gas that the engine
/// restarts because of long own times.
fn cases() -> [Case; 3] {
    let diffuse = Wall::still(Rebound::Diffuse { temperature: 1.0 });
    let heated = walled([None, Some([Wall::specular(), diffuse])]);
    [
        Case::new(300, 40.0, DiskBoundaries::periodic()),
        Case::new(300, 40.0, heated),
        Case::new(40, 2000.0, DiskBoundaries::periodic()),
    ]
}

/// Times at which the gas stops, some in each mean free time.
fn stops(case: &Case) -> Vec<f64> {
    let free = case.start.lengths[0].powi(2) / (2.0 * case.start.all.len() as f64);
    (1..=40)
        .map(|number| 0.37 * free * f64::from(number))
        .collect()
}

fn advance(gas: &mut dyn Simulation, until: f64) {
    while !gas.advance(until, Budget::Leg, &mut ()).expect("time") {}
}

/// Stops change nothing: a gas that is sampled has the bits and the work of one that is not.
#[test]
fn stops_change_nothing() {
    for (number, case) in cases().iter().enumerate() {
        let stops = stops(case);
        let (mut straight, mut seen) = (case.begin(), case.begin());
        let last = stops[stops.len() - 1];
        advance(&mut *straight, last);
        let mut before = seen.particles();
        for &stop in &stops {
            advance(&mut *seen, stop);
            let now = seen.particles();
            assert_eq!(now.time, stop);
            assert_eq!(seen.velocity_moments().means(), now.moments().means());
            assert!(now.all != before.all, "case {number} stands");
            before = now;
        }
        let least = 4 * case.start.all.len() as u64;
        assert!(straight.work_counters().collisions > least, "case {number}");
        assert_eq!(
            straight.work_counters(),
            seen.work_counters(),
            "case {number}"
        );
        assert_eq!(straight.particles(), seen.particles(), "case {number}");
        assert_eq!(
            straight.boundary_fluxes(),
            seen.boundary_fluxes(),
            "case {number}"
        );
    }
}

/// A gas resumes from a checkpoint at any stop to the same bytes, wherever that is in a leg; also
/// after kicks, which end a leg, and with displacements.
#[test]
fn a_checkpoint_at_a_stop_is_the_gas() {
    for (number, case) in cases().iter().enumerate() {
        let never = Interrupt::default();
        let (mut whole, mut broken) = (case.begin(), case.begin());
        for gas in [&mut whole, &mut broken] {
            assert!(gas.track_displacements());
        }
        for (stop, &until) in stops(case).iter().enumerate() {
            advance(&mut *whole, until);
            advance(&mut *broken, until);
            if stop == 20 {
                let kicks: Vec<Vector3<f64>> = (0..whole.particle_count())
                    .map(|disk| vector![0.1 * (disk % 7) as f64, -0.2, 0.0])
                    .collect();
                whole.add_velocities(&kicks).expect("velocities");
                broken.add_velocities(&kicks).expect("velocities");
            }
            if stop % 3 != 1 {
                let bytes = broken.save_checkpoint().expect("memory");
                broken = case.resume(&bytes, &never);
                assert_eq!(broken.save_checkpoint().expect("memory"), bytes);
            }
            let name = format!("case {number}, stop {stop}");
            assert_eq!(broken.time(), until, "{name}");
            assert_eq!(broken.particles(), whole.particles(), "{name}");
            assert_eq!(broken.displacements(), whole.displacements(), "{name}");
            assert_eq!(broken.work_counters(), whole.work_counters(), "{name}");
            assert_eq!(broken.boundary_fluxes(), whole.boundary_fluxes(), "{name}");
        }
    }
}

/// A leg ends after a number of collisions, wherever the gas has stopped before.
#[test]
fn legs_end_where_counts_say() {
    let case = &cases()[1];
    let ends = |stops: &[f64]| {
        let mut gas = case.begin();
        for &stop in stops {
            assert!(gas.advance(stop, Budget::Leg, &mut ()).expect("time"));
        }
        assert!(!gas.advance(1e9, Budget::Leg, &mut ()).expect("time"));
        (gas.work_counters().collisions, gas.particles())
    };
    let straight = ends(&[]);
    assert_eq!(straight.0, 100_000);
    assert_eq!(ends(&stops(case)), straight);
}

/// Resuming from a checkpoint can be interrupted while the leg is repeated; the checkpoint is then
/// unchanged.
#[test]
fn going_on_can_be_interrupted() {
    let case = &cases()[0];
    let mut gas = case.begin();
    for stop in stops(case) {
        advance(&mut *gas, stop);
    }
    let bytes = gas.save_checkpoint().expect("memory");
    let interrupt = Interrupt::default();
    interrupt.raise();
    let mut again = case.resume(&bytes, &interrupt);
    assert!(again.is_interrupted());
    assert!(!again.advance(1e9, Budget::Leg, &mut ()).expect("an end"));
    assert_eq!(again.save_checkpoint().expect("memory"), bytes);
}

/// An advance in a leg that is interrupted leaves the checkpoint at the stop before it.
#[test]
fn an_interrupted_leg_leaves_its_last_stop() {
    let case = &cases()[0];
    let mut gas = case.begin();
    advance(&mut *gas, 1.0);
    let bytes = gas.save_checkpoint().expect("memory");
    let interrupt = Interrupt::default();
    gas.set_stop_flag(&interrupt);
    let mut raise = EachCollision(|_: &_| interrupt.raise());
    assert!(!gas.advance(1e9, Budget::Leg, &mut raise).expect("an end"));
    assert!(gas.is_interrupted());
    assert_eq!(gas.save_checkpoint().expect("memory"), bytes);
}

/// A stop between the time of a fresh start, since own times are long, and the next event, where
/// the clock already shows more than that time, changes nothing.
#[test]
fn a_stop_before_a_fresh_start_changes_nothing() {
    let case = Case::new(3, 300.0, DiskBoundaries::periodic());
    let (mut straight, mut seen) = (case.begin(), case.begin());
    for stop in 1..=4000 {
        advance(&mut *seen, 5.0 * f64::from(stop));
    }
    advance(&mut *straight, 20_000.0);
    assert!(straight.work_counters().collisions > 0);
    assert_eq!(straight.particles(), seen.particles());
}
