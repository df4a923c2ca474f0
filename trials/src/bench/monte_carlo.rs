//! Speed of the Monte Carlo engine: dilute hard particles in cells of half a mean free path, with a
//! constant time step.

use clap::Args;
use stosszahl_dsmc::{DsmcEngine, Parameters, Scheme};
use stosszahl_model::random::Streams;
use stosszahl_model::samples::{SmoothParticles, UNIT, ideal_gas, smooth_particles};
use stosszahl_model::{Constant, Domain, InvalidValue, Plane, Space, State, Volume};

use super::{BenchWork, Speed, timed};
use crate::TrialError;
use crate::gas::PLAIN;

/// Options of `stosszahl-trials bench dsmc`, the benchmark of Monte Carlo in cells.
#[derive(Clone, Debug, Args)]
pub struct BenchDsmc {
    /// Dimension of space: disks in the plane (2) or spheres in space (3).
    #[arg(long, value_name = "D", default_value_t = 2, value_parser = clap::value_parser!(u8).range(2..=3))]
    pub dimension: u8,
    /// Approximate number of simulators: all cells are filled equally.
    #[arg(long, value_name = "N", default_value_t = 1_000_000, value_parser = clap::value_parser!(u32).range(2..))]
    pub simulators: u32,
    /// Simulators in each cell.
    #[arg(long, value_name = "C", default_value_t = 10.0)]
    pub per_cell: f64,
    /// Pair collisions per simulator and time step.
    #[arg(long, value_name = "R", default_value_t = 0.07)]
    pub collisions_per_step: f64,
    /// Number of time steps whose duration is measured.
    #[arg(long, value_name = "S", default_value_t = 50, value_parser = clap::value_parser!(u64).range(1..))]
    pub steps: u64,
    /// Threads of the Monte Carlo engine [default: all cores].
    #[arg(long, value_name = "T", value_parser = clap::value_parser!(u16).range(1..))]
    pub threads: Option<u16>,
    /// Move simulators without collisions, with all else unchanged.
    #[arg(long)]
    pub free_flight: bool,
    /// Print the measured speed as one JSON object.
    #[arg(long)]
    pub json: bool,
}

impl BenchWork for BenchDsmc {
    fn measure_speed(&self) -> Result<Speed, TrialError> {
        for (name, value) in [
            ("--per-cell", self.per_cell),
            ("--collisions-per-step", self.collisions_per_step),
        ] {
            InvalidValue::require(
                (1e-6..=1e6).contains(&value),
                name,
                value,
                "from 1e-6 to 1e6",
            )?;
        }
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(self.threads.map_or(0, usize::from))
            .build()?;
        pool.install(|| match self.dimension {
            2 => self.measure_in::<Plane>(),
            _ => self.measure_in::<Volume>(),
        })
    }
}

impl BenchDsmc {
    fn measure_in<S: Space>(&self) -> Result<Speed, TrialError> {
        /// Time steps before timing, in which tiles allocate their memory.
        const WARM_UP: u64 = 5;
        // Volume of a cell over that of a particle: with the mean free path l/phi, a cell holds phi
        // (l/2 phi)^D particles.
        let path = S::mean_free_path(1.0, 1.0);
        let dimension = S::DIMENSION as f64;
        let power = (0.5 * path).powf(dimension) / (S::particle_volume(0.5) * self.per_cell);
        let packing_fraction = power.powf(1.0 / (dimension - 1.0));
        let cell = 0.5 * path / packing_fraction;
        let wanted = f64::from(self.simulators) / self.per_cell;
        let cells = wanted.powf(1.0 / dimension).round().max(1.0);
        let simulators = (self.per_cell * cells.powf(dimension)).round().max(1.0) as usize;
        let (scene, state) = start::<S>(simulators, cell * cells)?;
        let theory = S::collision_rate(packing_fraction, 1.0);
        let parameters = Parameters {
            scheme: if self.free_flight {
                Scheme::Collisionless
            } else {
                Scheme::Boltzmann
            },
            cell_size: Some(cell),
            ..PLAIN
        };
        let mut engine = DsmcEngine::new(&scene, parameters, &state, Streams::new(1, 0))?;
        drop(state);
        engine.hold_step(2.0 * self.collisions_per_step / theory);
        engine.advance(f64::INFINITY, WARM_UP, &mut ());
        let (tally, time, steps) = (engine.tally(), engine.time(), self.steps);
        let (_, seconds, cpu) = timed(|| engine.advance(f64::INFINITY, steps, &mut ()));
        let collisions = (engine.tally().collisions - tally.collisions) as f64;
        let trials = (engine.tally().trials - tally.trials) as f64 / collisions.max(1.0);
        let done = simulators as f64 * steps as f64;
        let rate = 2.0 * collisions / simulators as f64 / (engine.time() - time) / theory;
        let bytes = engine.memory_bytes() as f64 / simulators as f64;
        Ok(Speed::default()
            .with("dimension", S::DIMENSION)
            .with("threads", rayon::current_num_threads())
            .with("simulators", simulators)
            .with("cells", engine.grid().cells())
            .with("steps", steps)
            .with("seconds", seconds)
            .with("cpu_seconds", cpu)
            .with("particle_steps_per_second", done / seconds)
            .with("particle_steps_per_cpu_second", done / cpu)
            .with("collisions_per_second", collisions / seconds)
            .with("collisions_per_step", collisions / done)
            .with("collision_rate_over_theory", rate)
            .with("trials_per_collision", trials)
            .with("bytes_per_simulator", bytes))
    }
}

/// Creates an ideal gas of `count` particles at temperature one in a square or cubic box.
fn start<S: Space>(
    count: usize,
    side: f64,
) -> Result<(SmoothParticles<S>, State<SmoothParticles<S>>), TrialError> {
    let scene: SmoothParticles<S> = smooth_particles(Constant::ELASTIC, UNIT);
    let domain = Domain::periodic(S::from_components(|_| side))?;
    let state = ideal_gas(&scene, domain, 0.0, count, 1.0, 1);
    Ok((scene, state))
}
