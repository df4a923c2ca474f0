//! The Monte Carlo engine, against kinetic theory and the conservation laws.

use stosszahl_dsmc::{
    BoundaryConditions, DsmcEngine, Neighbourhood, Parameters, PartnerDisplacement, Scheme,
    SimulatorStart, simulate,
};
use stosszahl_model::equation_of_state;
use stosszahl_model::initial::Arrangement;
use stosszahl_model::random::Streams;
use stosszahl_model::samples::{EqualDisks, FallingDisks, UNIT, disks, law, particles_of};
use stosszahl_model::{Budget, Collision, Observer, ParticleSpec, Plane, State};
use stosszahl_theory::cooling;

use crate::support::{as_kinds, gas, kinds};

const PARAMETERS: Parameters = Parameters {
    scheme: Scheme::Enskog(Neighbourhood::Mean),
    displacement: PartnerDisplacement::None,
    cell_size: Some(20.0),
    simulators_per_particle: 1,
    copies: SimulatorStart::Independent,
    steps_per_cell_crossing: 4.0,
    max_contact_value: 10.0,
};

/// Observer that counts collisions in bins of |b|/d and sums the quantities that theory knows.
#[derive(Default)]
struct Sums {
    bins: [f64; 10],
    square: f64,
}

impl Observer for Sums {
    fn on_collisions(&mut self, batch: &[Collision]) {
        for collision in batch {
            let b = collision.impact_square().sqrt();
            self.bins[((10.0 * b) as usize).min(9)] += 1.0;
            self.square += collision.relative_velocity.norm_squared();
        }
    }
}

fn engine(
    restitution: f64,
    count: usize,
    packing: f64,
    seed: u64,
    parameters: Parameters,
) -> DsmcEngine<EqualDisks> {
    let state = gas(Arrangement::Disordered, count, packing, seed);
    DsmcEngine::new(
        &disks(restitution),
        parameters,
        &state,
        Streams::new(seed, 0),
    )
    .expect("an engine")
}

/// Elastic, chi of the mean density: rate, <g^2> = 6 T and P(b/d) = 1 of kinetic theory. Sixteen
/// gases of 20 000 disks; z = 4 standard errors of the measured mean, and the error must be small
/// enough to see 0.5 %. Cells of 60 d hold 1146 disks: the start's hard-disk order, which takes
/// (1 - S(0))/N of the pairs of a cell, is below a tenth of a percent.
#[test]
fn elastic_rate_speeds_and_impact_parameters_are_those_of_theory() {
    for scheme in [Scheme::Boltzmann, Scheme::Enskog(Neighbourhood::Mean)] {
        let mut rates = Vec::new();
        let mut squares = Vec::new();
        let mut bins = [0.0; 10];
        for seed in 0..16 {
            let parameters = Parameters {
                scheme,
                cell_size: Some(60.0),
                ..PARAMETERS
            };
            let mut gas = engine(1.0, 20_000, 0.25, seed, parameters);
            let mut sums = Sums::default();
            assert!(gas.advance(5.0, u64::MAX, &mut sums));
            let tally = gas.tally();
            // Only a speed that grew within the step can exceed the sum of the two largest.
            assert!(tally.majorant_violations * 1000 < tally.trials, "{tally:?}");
            let theory =
                equation_of_state::collision_rate(0.25, scheme.contact_value::<Plane>(0.25), 0.0);
            rates.push(2.0 * tally.collisions as f64 / 20_000.0 / 5.0 / theory);
            squares.push(sums.square / tally.collisions as f64 / 6.0);
            for (sum, bin) in bins.iter_mut().zip(sums.bins) {
                *sum += bin;
            }
        }
        for (name, values) in [("rate", rates), ("<g^2>", squares)] {
            let (mean, error) = crate::support::mean_and_error(&values);
            assert!(error < 0.005 / 4.0, "{name}: error {error} too wide");
            assert!(
                (mean - 1.0).abs() < 4.0 * error,
                "{name} over theory {mean} +- {error} ({scheme:?})"
            );
        }
        let total: f64 = bins.iter().sum();
        let chi_squared: f64 = bins
            .iter()
            .map(|n| (n - total / 10.0).powi(2) / (total / 10.0))
            .sum();
        // 9 degrees of freedom: 27.88 is exceeded once in a thousand.
        assert!(chi_squared < 27.88, "P(b/d): chi^2 = {chi_squared}");
    }
}

/// Haff's cooling law, with cells of 60 d, no displacement, and chi of the mean density: `K/K_0` =
/// 0.2510 at `t_0` (Sonine correction included) within 0.0015.
#[test]
fn homogeneous_cooling_follows_haff() {
    let haff = cooling::haff_time(0.25, 0.8, equation_of_state::contact_value(0.25));
    let ratios: Vec<f64> = (0..12)
        .map(|seed| {
            let mut gas = engine(
                0.8,
                40_000,
                0.25,
                seed,
                Parameters {
                    cell_size: Some(60.0),
                    ..PARAMETERS
                },
            );
            assert!(gas.advance(haff, u64::MAX, &mut ()));
            gas.state().temperature(gas.scene())
        })
        .collect();
    let (mean, error) = crate::support::mean_and_error(&ratios);
    println!("K/K0 at t0: {mean:.5} +- {error:.5}");
    assert!(error < 0.0004, "error {error} too wide");
    assert!(
        (mean - 0.2510).abs() < 0.0015,
        "K/K0 at t0 {mean} +- {error}"
    );
}

#[test]
fn elastic_gas_conserves_energy_and_momentum() {
    for displacement in [PartnerDisplacement::None, PartnerDisplacement::Diameter] {
        let parameters = Parameters {
            scheme: Scheme::Enskog(Neighbourhood::Cells(2)),
            displacement,
            cell_size: None,
            ..PARAMETERS
        };
        let mut gas = engine(1.0, 2000, 0.25, 1, parameters);
        let before = gas.state();
        gas.advance(20.0, u64::MAX, &mut ());
        let after = gas.state();
        let energy = after.kinetic_energy(gas.scene()) / before.kinetic_energy(gas.scene());
        // 3e4 collisions: a random walk of roundings of 1e-16 on 2e3 disks.
        assert!((energy - 1.0).abs() < 1e-13, "{energy}");
        assert!(after.momentum(gas.scene()).norm() < 1e-11);
        assert!(gas.tally().collisions > 20_000);
    }
}

/// Creates equal disks that carry their index, so that each can be tracked through a sort.
fn followed(count: usize) -> FallingDisks {
    kinds(1.0, vec![(0.5, 1.0, 1); count])
}

/// Pressure from the momentum that the displacement carries, from positions before and after each
/// step: for elastic disks Z - 1 = (pi/2) n d^2 chi at the measured rate, that is omega = 4 (Z -
/// 1)/sqrt(pi) with d = m = T = 1.
#[test]
fn displacement_carries_the_collisional_pressure_of_hard_disks() {
    let (count, steps) = (5000, 100);
    let mut values = Vec::new();
    for seed in 0..6 {
        let parameters = Parameters {
            displacement: PartnerDisplacement::Diameter,
            cell_size: Some(10.0),
            // Short steps, so that hardly a disk collides twice in one.
            steps_per_cell_crossing: 100.0,
            ..PARAMETERS
        };
        let start = as_kinds(&gas(Arrangement::Disordered, count, 0.25, seed));
        let mut engine =
            DsmcEngine::new(&followed(count), parameters, &start, Streams::new(seed, 0))
                .expect("an engine");
        let mut carried = 0.0;
        for _ in 0..steps {
            let before = engine.state();
            engine.advance(1e9, 1, &mut ());
            let after = engine.state();
            let step = after.time - before.time;
            for (a, b) in before.bodies.iter().zip(&after.bodies) {
                let moved = after.domain.displacement(b.position, a.position);
                let flown = (a.velocity + b.velocity) * (0.5 * step);
                carried += b.velocity.dot(&(moved - flown));
            }
        }
        let rate = 2.0 * engine.tally().collisions as f64 / count as f64 / engine.time();
        let excess = carried / (2.0 * count as f64 * engine.time());
        values.push(excess * 4.0 / std::f64::consts::PI.sqrt() / rate);
    }
    let (mean, error) = crate::support::mean_and_error(&values);
    // Of displaced partners one in a hundred collides again within its step, and is then counted
    // with the wrong flight: a percent of a percent.
    assert!(
        error < 0.01 && (mean - 1.0).abs() < 4.0 * error,
        "{mean} +- {error}"
    );
}

/// Where displacements are followed, disks carry the number of their species, and the engine is
/// that of any sizes. Of one species it must do what the engine of equal disks does: the same bits,
/// of every scheme, also with the density halfway to the contact.
#[test]
fn one_species_is_a_gas_of_equal_disks() {
    let state = gas(Arrangement::Disordered, 400, 0.25, 3);
    let start = particles_of(&UNIT, &state);
    let grains = ParticleSpec::equal(0.5, 1.0, law(0.8));
    let schemes = Scheme::ALL.map(|scheme| (scheme, 2));
    for (scheme, simulators_per_particle) in
        [(Scheme::CONTACT_POINT, 16)].into_iter().chain(schemes)
    {
        let parameters = Parameters {
            simulators_per_particle,
            ..Parameters::for_scheme(scheme)
        };
        let after = |displacements: bool| {
            let parts = stosszahl_dsmc::CellGas {
                grains: &grains,
                parameters,
                boundaries: &BoundaryConditions::default(),
                streams: Streams::new(7, 0),
                displacements,
            };
            let mut gas = simulate(&parts, std::slice::from_ref(&start)).expect("a gas");
            let reached = gas.advance(3.0, Budget::Unlimited, &mut ());
            assert!(reached.expect("an advance"));
            let mut particles = gas.particles();
            // Species stand copy by copy, equal disks cell by cell.
            (particles.all).sort_by(|a, b| a.position[0].total_cmp(&b.position[0]));
            (particles, gas.work_counters())
        };
        let (plain, species) = (after(false), after(true));
        let is_idle = scheme == Scheme::Collisionless;
        assert!(is_idle || plain.1.collisions > 400, "{scheme:?}");
        assert_eq!(plain.1, species.1, "{scheme:?}");
        assert!(plain.0 == species.0, "{scheme:?}");
    }
}

/// Disks of different sizes continue to the same bits too, though their order in memory is another
/// one then.
#[test]
fn mixtures_continue_to_the_same_bits() {
    let start = as_kinds(&gas(Arrangement::Disordered, 900, 0.3, 8));
    let sizes = (0..900).map(|i| match i % 3 {
        0 => (0.5, 1.0, 1),
        _ => (0.17, 0.04, 1),
    });
    let scene = kinds(1.0, sizes);
    for scheme in [
        Scheme::FreeVolume,
        Scheme::Enskog(Neighbourhood::Cells(2)),
        PARAMETERS.scheme,
    ] {
        let parameters = Parameters {
            scheme,
            displacement: PartnerDisplacement::Diameter,
            cell_size: None,
            ..PARAMETERS
        };
        let streams = Streams::new(8, 0);
        let mut whole = DsmcEngine::new(&scene, parameters, &start, streams).expect("an engine");
        whole.advance(1e9, 40, &mut ());
        let mut rest = DsmcEngine::setup(&scene, parameters, streams)
            .resume(start.domain, whole.checkpoint())
            .expect("an engine");
        for engine in [&mut whole, &mut rest] {
            engine.advance(1e9, 40, &mut ());
        }
        assert_eq!(whole.state().bodies, rest.state().bodies);
        assert!(whole.tally().collisions > 200);
        let energy = |state: &State<_>| state.kinetic_energy(&scene);
        assert!((energy(&whole.state()) / energy(&start) - 1.0).abs() < 1e-12);
    }
}

#[test]
fn checkpoints_continue_to_the_same_bits() {
    for simulators_per_particle in [1, 3] {
        let parameters = Parameters {
            scheme: Scheme::FreeVolume,
            displacement: PartnerDisplacement::Diameter,
            cell_size: None,
            simulators_per_particle,
            ..PARAMETERS
        };
        let mut whole = engine(0.8, 1500, 0.25, 6, parameters);
        assert!(!whole.advance(50.0, 40, &mut ()));
        let mut rest = DsmcEngine::setup(&disks(0.8), parameters, Streams::new(6, 0))
            .resume(whole.state().domain, whole.checkpoint())
            .expect("an engine");
        for gas in [&mut whole, &mut rest] {
            assert!(gas.advance(50.0, u64::MAX, &mut ()));
        }
        assert_eq!(whole.state().bodies, rest.state().bodies);
        assert_eq!(whole.tally(), rest.tally());
    }
}

#[test]
fn several_simulators_keep_energy_and_momentum_of_the_start() {
    let gas = engine(
        0.8,
        1000,
        0.25,
        6,
        Parameters {
            simulators_per_particle: 5,
            ..PARAMETERS
        },
    );
    let state = gas.state();
    assert_eq!(state.bodies.len(), 5000);
    assert!((state.temperature(gas.scene()) - 1.0).abs() < 1e-12);
    assert!(state.momentum(gas.scene()).norm() < 1e-10);
    assert_eq!(gas.weight(), 0.2);
}

#[test]
fn meaningless_parameters_are_refused() {
    let state = gas(Arrangement::Disordered, 10, 0.1, 1);
    for parameters in [
        Parameters {
            simulators_per_particle: 0,
            ..PARAMETERS
        },
        Parameters {
            cell_size: Some(-1.0),
            ..PARAMETERS
        },
        Parameters {
            steps_per_cell_crossing: f64::NAN,
            ..PARAMETERS
        },
        Parameters {
            max_contact_value: 0.5,
            ..PARAMETERS
        },
    ] {
        let error = DsmcEngine::new(&disks(1.0), parameters, &state, Streams::new(1, 0))
            .err()
            .expect("refused");
        assert!(error.to_string().contains("allowed"), "{error}");
    }
}
