//! Dilute hard particles for the Monte Carlo engine: cells of half a mean free path and a constant step.

use clap::Args;
use rand::RngExt;
use stosszahl_dsmc::{Engine, Parameters, Scheme};
use stosszahl_model::random::{Purpose, Streams};
use stosszahl_model::{Constant, Domain, Plane, Space, State, VectorOf, Volume};

use super::{Speed, Work, timed};
use crate::Trouble;
use crate::gas::{PLAIN, Particles, UNIT, particles, warm};

/// `stosszahl-trials bench dsmc`.
#[derive(Clone, Debug, Args)]
pub struct BenchDsmc {
    /// Disks in the plane (2) or spheres in space (3).
    #[arg(long, value_name = "D", default_value_t = 2, value_parser = clap::value_parser!(u8).range(2..=3))]
    pub dimension: u8,
    /// Number of simulators, about: cells are filled equally.
    #[arg(long, value_name = "N", default_value_t = 1_000_000, value_parser = clap::value_parser!(u32).range(2..))]
    pub simulators: u32,
    /// Simulators for each cell.
    #[arg(long, value_name = "C", default_value_t = 10.0)]
    pub per_cell: f64,
    /// Pair collisions for each simulator and step.
    #[arg(long, value_name = "R", default_value_t = 0.07)]
    pub collisions_per_step: f64,
    /// Steps to time.
    #[arg(long, value_name = "S", default_value_t = 50, value_parser = clap::value_parser!(u64).range(1..))]
    pub steps: u64,
    /// Threads [default: all cores].
    #[arg(long, value_name = "T")]
    pub threads: Option<usize>,
    /// No collisions; all else as with them.
    #[arg(long)]
    pub free_flight: bool,
    /// Print one JSON object.
    #[arg(long)]
    pub json: bool,
}

impl Work for BenchDsmc {
    fn measure(&self) -> Result<Speed, Trouble> {
        for (name, value) in [
            ("per-cell", self.per_cell),
            ("collisions-per-step", self.collisions_per_step),
        ] {
            if !(1e-6..=1e6).contains(&value) {
                let allowed = "from 1e-6 to 1e6";
                return Err(Trouble::BadNumber {
                    name,
                    value,
                    allowed,
                });
            }
        }
        if self.threads == Some(0) {
            let (name, value, allowed) = ("threads", 0.0, "1 or more");
            return Err(Trouble::BadNumber {
                name,
                value,
                allowed,
            });
        }
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(self.threads.unwrap_or(0))
            .build()?;
        pool.install(|| match self.dimension {
            2 => self.measure_in::<Plane>(),
            _ => self.measure_in::<Volume>(),
        })
    }

    fn json(&self) -> bool {
        self.json
    }
}

impl BenchDsmc {
    fn measure_in<S: Space>(&self) -> Result<Speed, Trouble> {
        /// Steps before timing: tiles get their room.
        const WARM_UP: u64 = 5;
        // With the mean free path l/phi, a cell holds phi (l/2 phi)^D over the volume of a particle.
        let path = S::mean_free_path(1.0, 1.0);
        let dimension = S::DIMENSION as f64;
        let power = (0.5 * path).powf(dimension) / (S::ball(0.5) * self.per_cell);
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
        let mut engine = Engine::new(&scene, parameters, &state, Streams::new(1, 0))?;
        drop(state);
        engine.hold_step(2.0 * self.collisions_per_step / theory);
        engine.advance(f64::INFINITY, WARM_UP, &mut ());
        let (tally, time, steps) = (engine.tally(), engine.time(), self.steps);
        let (_, seconds, cpu) = timed(|| engine.advance(f64::INFINITY, steps, &mut ()));
        let collisions = (engine.tally().collisions - tally.collisions) as f64;
        let trials = (engine.tally().trials - tally.trials) as f64 / collisions.max(1.0);
        let done = simulators as f64 * steps as f64;
        let rate = 2.0 * collisions / simulators as f64 / (engine.time() - time) / theory;
        let (speed, cpu_speed) = (done / seconds, done / cpu);
        let (each_second, each_step) = (collisions / seconds, collisions / done);
        let memory = engine.bytes() as f64 / simulators as f64;
        let cells = engine.grid().cells();
        let threads = rayon::current_num_threads();
        Ok(Speed {
            words: format!(
                "{simulators} simulators in {cells} cells, {dimension} dimensions, {threads} threads: {speed:.4e} \
                 particle-steps/s of wall time, {cpu_speed:.4e} of CPU time ({steps} steps in {seconds:.2} s); \
                 {each_second:.4e} collisions/s, {each_step:.4} a simulator and step, {rate:.4} of theory's rate, \
                 {trials:.2} trials each; {memory:.1} bytes/simulator"
            ),
            values: vec![
                ("simulators", simulators.into()),
                ("cells", cells.into()),
                ("steps", steps.into()),
                ("seconds", seconds.into()),
                ("cpu_seconds", cpu.into()),
                ("particle_steps_per_second", speed.into()),
                ("particle_steps_per_cpu_second", cpu_speed.into()),
                ("collisions_per_second", each_second.into()),
                ("collisions_per_step", each_step.into()),
                ("collision_rate_over_theory", rate.into()),
                ("trials_per_collision", trials.into()),
                ("bytes_per_simulator", memory.into()),
            ],
        })
    }
}

/// An ideal gas at temperature one in a box with the given side.
fn start<S: Space>(
    count: usize,
    side: f64,
) -> Result<(Particles<S>, State<Particles<S>>), Trouble> {
    let scene: Particles<S> = particles(Constant::ELASTIC, UNIT);
    let mut lengths = VectorOf::<Particles<S>>::default();
    for axis in 0..S::DIMENSION {
        lengths[axis] = side;
    }
    let domain = Domain::periodic(lengths)?;
    let mut stream = Streams::new(1, 0).at(Purpose::Placement, [0, 0]);
    let places = (0..count).map(|_| {
        let mut position = lengths;
        for axis in 0..S::DIMENSION {
            position[axis] = side * stream.random::<f64>();
        }
        position
    });
    let state = warm(&scene, domain, places, 1);
    Ok((scene, state))
}
