//! Uniform shear flow: energy balance of collisions, stress of dilute gases, density windows, and
//! bytes of resumed runs.

use stosszahl_dsmc::{
    BoundaryConditions, CellGas, CheckpointSource, Neighbourhood, Parameters, PartnerDisplacement,
    Scheme, resume, simulate,
};
use stosszahl_model::random::Streams;
use stosszahl_model::samples::{ideal_particles, law};
use stosszahl_model::{
    Budget, Collision, Observer, ParticleSpec, Particles, Rough, Simulation, Volume,
};

/// Shear flow of particles of diameter one in a cube or square: rate, dimension, packing fraction,
/// number.
#[derive(Clone, Copy)]
struct Flow {
    rate: f64,
    dimension: usize,
    packing: f64,
    count: usize,
}

impl Flow {
    /// Side of the box \[diameters\].
    fn side(self) -> f64 {
        let ball = if self.dimension == 2 {
            std::f64::consts::PI / 4.0
        } else {
            std::f64::consts::PI / 6.0
        };
        (self.count as f64 * ball / self.packing).powf(1.0 / self.dimension as f64)
    }

    /// Random positions and velocities of temperature one, without net momentum.
    fn start(self) -> Particles {
        ideal_particles(self.dimension, self.side(), self.count, 7)
    }

    fn grains(self, restitution: f64) -> ParticleSpec {
        ParticleSpec {
            shear_rate: Some(self.rate),
            ..ParticleSpec::equal(0.5, 1.0, law(restitution))
        }
    }
}

fn parameters(scheme: Scheme) -> Parameters {
    Parameters {
        displacement: PartnerDisplacement::None,
        ..Parameters::for_scheme(scheme)
    }
}

fn gas<'a>(
    grains: &'a ParticleSpec,
    scheme: Scheme,
    boundaries: &'a BoundaryConditions<Volume>,
) -> CellGas<'a> {
    CellGas {
        grains,
        parameters: parameters(scheme),
        boundaries,
        streams: Streams::new(5, 0),
        displacements: false,
    }
}

/// Sums over particles: energy, and momentum fluxes xx, yy, zz, xy.
fn moments(gas: &dyn Simulation) -> (f64, [f64; 4]) {
    let (mut energy, mut fluxes) = (0.0, [0.0; 4]);
    gas.visit_particles(&mut |one| {
        let v = one.velocity;
        energy += one.weight * (0.5 * one.mass * v.norm_squared() + one.spin_energy);
        for (flux, product) in fluxes
            .iter_mut()
            .zip([v.x * v.x, v.y * v.y, v.z * v.z, v.x * v.y])
        {
            *flux += one.weight * one.mass * product;
        }
    });
    (energy, fluxes)
}

/// Energy dissipated in collisions, momentum transfer yx, and number of collisions.
#[derive(Default)]
struct Losses {
    lost: f64,
    transfer: f64,
    collisions: u64,
}

impl Observer for Losses {
    fn on_collisions(&mut self, batch: &[Collision]) {
        for one in batch {
            self.lost += one.weight * one.energy_lost();
            self.transfer += one.weight * one.momentum_transfer[(1, 0)];
            self.collisions += 1;
        }
    }
}

/// Collisions of a step change the energy by dissipation and by the work of the flow over the
/// contact distance, `-a r_y Δp_x` each. The energy just before and after them follows from values
/// half a flight away: `c_x` changes by `-a c_y t`. Tolerance: some 10^4 terms, each rounded to
/// 1e-16 of a particle's energy, with random signs, times a hundred for other orders of summation.
#[test]
fn collisions_take_what_they_tell() {
    let schemes = [
        (Scheme::Boltzmann, false),
        (Scheme::FreeVolume, false),
        (Scheme::Enskog(Neighbourhood::Cells(2)), true),
        (Scheme::Enskog(Neighbourhood::Mean), true),
        (Scheme::Esmc(Neighbourhood::Cells(1)), true),
        (Scheme::StochasticDisks { stiffness: 1.0 }, true),
        (Scheme::CONTACT_POINT, true),
    ];
    for dimension in [2, 3] {
        let flow = Flow {
            rate: 0.7,
            dimension,
            packing: 0.2,
            count: 3000,
        };
        for (scheme, feels) in schemes {
            let boundaries = BoundaryConditions::default();
            let grains = flow.grains(0.8);
            let mut engine =
                simulate(&gas(&grains, scheme, &boundaries), &[flow.start()]).expect("an engine");
            let mut work = 0.0;
            for step in 1..=20 {
                let (before, fluxes) = moments(&*engine);
                let (begin, end) = (engine.time(), 1e-3 * f64::from(step));
                let mut losses = Losses::default();
                assert!(engine.advance(end, Budget::Leg, &mut losses).expect("time"));
                let steps = engine.work_counters().numbers["steps"];
                assert_eq!(steps, f64::from(step), "one step at a time");
                let turn = flow.rate * 0.5 * (end - begin);
                // Of the energy: -turn c_x c_y + turn^2 c_y^2/2.
                let just_before = before - turn * fluxes[3] + 0.5 * turn * turn * fluxes[1];
                let (after, fluxes) = moments(&*engine);
                let just_after = after + turn * fluxes[3] + 0.5 * turn * turn * fluxes[1];
                let supplied = -flow.rate * losses.transfer;
                let found = just_after - just_before;
                let expected = supplied - losses.lost;
                assert!(
                    (found - expected).abs() < 1e-10 * before,
                    "{scheme:?} in {dimension}D: {found:e} instead of {expected:e}"
                );
                work += losses.transfer.abs();
            }
            assert_eq!(work > 0.0, feels, "{scheme:?}");
        }
    }
}

/// Steady dilute flow in blocks, each with time averages of `a/nu_0`, `nu_0 = n T/eta_0`, and of
/// `P/(n T)`: xx, yy, zz, -xy.
fn steady_state(flow: Flow, restitution: f64, blocks: usize) -> Vec<[f64; 5]> {
    let boundaries = BoundaryConditions::default();
    let grains = flow.grains(restitution);
    let gas = gas(&grains, Scheme::Boltzmann, &boundaries);
    let mut engine = simulate(&gas, &[flow.start()]).expect("an engine");
    let volume = flow.side().powi(flow.dimension as i32);
    let density = flow.count as f64 / volume;
    // nu_0/sqrt(T): 2 n d sqrt(pi) or 16/5 n d^2 sqrt(pi).
    let factor = if flow.dimension == 2 { 2.0 } else { 3.2 };
    let unit = factor * density * std::f64::consts::PI.sqrt();
    // Fifteen units of 1/nu_0 for relaxation, and ten for each block.
    let mut until = 15.0 / unit;
    let mut advance = |engine: &mut Box<dyn Simulation>, time: f64| {
        until += time;
        while !engine.advance(until, Budget::Leg, &mut ()).expect("time") {}
    };
    advance(&mut engine, 0.0);
    let samples = 40_u32;
    let mut all = Vec::new();
    for _ in 0..blocks {
        let mut sums = [0.0; 5];
        for _ in 0..samples {
            advance(&mut engine, 10.0 / unit / f64::from(samples));
            let (energy, [xx, yy, zz, xy]) = moments(&*engine);
            let thermal = 2.0 * energy / flow.dimension as f64;
            let temperature = thermal / flow.count as f64;
            let reduced = flow.rate / (unit * temperature.sqrt());
            let row = [
                reduced,
                xx / thermal,
                yy / thermal,
                zz / thermal,
                -xy / thermal,
            ];
            for (sum, value) in sums.iter_mut().zip(row) {
                *sum += value / f64::from(samples);
            }
        }
        all.push(sums);
    }
    all
}

/// Stress and temperature of dilute sheared gases against an independent Boltzmann Monte Carlo
/// simulation, whose own error is 0.5 %. Tolerance: 1 % of n T, for both errors and that of cells
/// and steps. Five standard errors of the blocks must be below that: a value that is 2 % off then
/// passes by chance at most once in 10^4 times.
#[test]
fn dilute_sheared_gases_have_the_stress_of_the_boltzmann_equation() {
    let rows = [
        (2, 0.9, [0.330, 1.097, 0.903, 0.0, 0.295]),
        (2, 0.7, [0.623, 1.261, 0.739, 0.0, 0.439]),
        (3, 0.8, [0.532, 1.298, 0.834, 0.868, 0.439]),
    ];
    for (dimension, restitution, known) in rows {
        let mut flow = Flow {
            rate: 1.0,
            dimension,
            packing: 0.005,
            count: 6000,
        };
        let volume = flow.side().powi(dimension as i32);
        let factor = if dimension == 2 { 2.0 } else { 3.2 };
        // The rate keeps the temperature near that of the start.
        flow.rate = known[0] * factor * flow.count as f64 / volume * std::f64::consts::PI.sqrt();
        let blocks = steady_state(flow, restitution, 12);
        for (index, known) in known.into_iter().enumerate() {
            let values: Vec<f64> = blocks.iter().map(|block| block[index]).collect();
            let count = values.len() as f64;
            let mean = values.iter().sum::<f64>() / count;
            let squares: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
            let error = (squares / (count - 1.0) / count).sqrt();
            println!(
                "{dimension}D r {restitution} [{index}]: {mean:.4} ± {error:.4}, known {known}"
            );
            assert!(error < 0.002, "{error}");
            assert!((mean - known).abs() < 0.01, "{mean} ± {error}, {known}");
        }
    }
}

/// Steady reduced temperature `T/(m a^2 d^2)` of a dense flow, with its standard error over blocks
/// of time, for simulators so many that the box is one gas without waves.
fn reduced_temperature(flow: Flow, scheme: Scheme, simulators: u32) -> (f64, f64) {
    let boundaries = BoundaryConditions::default();
    let grains = flow.grains(0.7);
    let mut gas = gas(&grains, scheme, &boundaries);
    gas.parameters.simulators_per_particle = simulators;
    let starts = vec![flow.start(); simulators as usize];
    let mut engine = simulate(&gas, &starts).expect("an engine");
    let (blocks, samples) = (10_u32, 12_u32);
    let relaxation = 20.0;
    let mut means = Vec::new();
    for block in 0..blocks {
        let mut mean = 0.0;
        for sample in 0..samples {
            let strain = relaxation + f64::from(block * samples + sample);
            let until = strain / flow.rate;
            while !engine.advance(until, Budget::Leg, &mut ()).expect("time") {}
            let (energy, _) = moments(&*engine);
            mean += 2.0 * energy / (flow.dimension * flow.count) as f64;
        }
        means.push(mean / (f64::from(samples) * flow.rate * flow.rate));
    }
    let count = means.len() as f64;
    let mean = means.iter().sum::<f64>() / count;
    let squares: f64 = means.iter().map(|one| (one - mean).powi(2)).sum();
    (mean, (squares / (count - 1.0) / count).sqrt())
}

/// Schemes whose partners come from other cells, also from those that slide past the edge, have the
/// temperature of Enskog's uniform flow where simulators are many: within 2 % and four standard
/// errors. The error of the difference must be below 1.25 %: a value that is 12 % off then passes at
/// most once in 10^4 times.
#[test]
fn partners_across_cells_have_enskogs_temperature() {
    for (dimension, count, simulators, schemes) in [
        (
            2,
            36,
            32,
            &[Scheme::Esmc(Neighbourhood::Mean), Scheme::CONTACT_POINT][..],
        ),
        (3, 64, 16, &[Scheme::Esmc(Neighbourhood::Mean)]),
    ] {
        let flow = Flow {
            rate: 0.5,
            dimension,
            packing: 0.2,
            count,
        };
        let (known, known_error) =
            reduced_temperature(flow, Scheme::Enskog(Neighbourhood::Mean), simulators);
        for &scheme in schemes {
            let (found, error) = reduced_temperature(flow, scheme, simulators);
            let error = error.hypot(known_error) / known;
            let excess = found / known - 1.0;
            let what =
                format!("{scheme:?} in {dimension}D: {excess:.4} ± {error:.4} of {known:.3}");
            println!("{what}");
            assert!(error < 0.0125, "too wide: {what}");
            assert!(excess.abs() < 0.02 + 4.0 * error, "{what}");
        }
    }
}

/// A run resumed after several stops has the bytes of an uninterrupted one, for smooth and rough
/// particles, in two and three dimensions, within cells and across them.
#[test]
fn resumed_flows_have_the_same_bytes() {
    for scheme in [
        Scheme::Enskog(Neighbourhood::Cells(2)),
        Scheme::Esmc(Neighbourhood::Cells(2)),
        Scheme::CONTACT_POINT,
    ] {
        resume_flows(scheme);
    }
}

fn resume_flows(scheme: Scheme) {
    for dimension in [2, 3] {
        for rough in [None, Some(Rough::new(0.3, 0.4).expect("a surface"))] {
            let flow = Flow {
                rate: -0.4,
                dimension,
                packing: 0.1,
                count: 800,
            };
            let boundaries = BoundaryConditions::default();
            let grains = ParticleSpec {
                rough,
                ..flow.grains(0.9)
            };
            let gas = gas(&grains, scheme, &boundaries);
            let start = [flow.start()];
            let mut through = simulate(&gas, &start).expect("an engine");
            let mut stopped = simulate(&gas, &start).expect("an engine");
            for step in 1..=5 {
                let until = 2.0 * f64::from(step);
                for engine in [&mut through, &mut stopped] {
                    while !engine.advance(until, Budget::Leg, &mut ()).expect("time") {}
                }
                let bytes = stopped.save_checkpoint().expect("bytes");
                let left = CheckpointSource {
                    count: flow.count,
                    lengths: start[0].lengths,
                    checkpoint: &bytes,
                    beside: None,
                };
                stopped = resume(&gas, left).expect("an engine");
            }
            assert!(through.work_counters().collisions > 1000);
            assert!(
                through.save_checkpoint().expect("bytes")
                    == stopped.save_checkpoint().expect("bytes")
            );
        }
    }
}

#[test]
fn displaced_partners_are_refused_in_a_flow() {
    let flow = Flow {
        rate: 0.5,
        dimension: 2,
        packing: 0.1,
        count: 50,
    };
    let boundaries = BoundaryConditions::default();
    let grains = flow.grains(0.9);
    let displaced = CellGas {
        parameters: Parameters::for_scheme(Scheme::FreeVolume),
        ..gas(&grains, Scheme::FreeVolume, &boundaries)
    };
    let error = simulate(&displaced, &[flow.start()]);
    let words = error.map(|_| ()).expect_err("displaced").to_string();
    assert!(words.contains("displacement"), "{words}");
}
