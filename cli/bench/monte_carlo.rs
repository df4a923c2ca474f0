//! Dilute hard particles for the Monte Carlo engine: cells of half a mean free path and a constant step.

use std::time::Instant;

use cpu_time::ProcessTime;
use rand::RngExt;
use serde::Serialize;
use stosszahl_dsmc::{Copies, Displacement, Engine, Parameters, Scheme};
use stosszahl_model::random::{Purpose, Streams};
use stosszahl_model::{
    Body, Constant, Domain, Free, Monodisperse, Plane, Scene, Smooth, Space, State, Vector,
    VectorOf, Volume,
};

use super::BenchError;

/// Smooth equal particles in a space.
type Gas<S> = Scene<S, Smooth, Constant, Monodisperse, Free>;

/// A piece of work for the Monte Carlo engine: an elastic Maxwellian gas of equal hard particles without density
/// corrections, in equilibrium, in a square or cubic box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MonteCarlo {
    /// Disks in the plane, or spheres in space.
    pub dimension: usize,
    /// Number of simulators, about: the box has whole cells along each side.
    pub simulators: usize,
    /// Simulators for each cell; the width of a cell is half a mean free path.
    pub per_cell: f64,
    /// Pair collisions for each simulator and step.
    pub collisions_per_step: f64,
    /// Steps to time.
    pub steps: u64,
    /// No collisions; all else is done as with them.
    pub free_flight: bool,
}

/// What was measured.
#[derive(Clone, Debug, Serialize)]
pub struct MonteCarloSpeed {
    /// Number of simulators.
    pub simulators: usize,
    /// Number of cells.
    pub cells: usize,
    /// Steps timed.
    pub steps: u64,
    /// Wall time \[s\].
    pub seconds: f64,
    /// CPU time of all threads \[s\].
    pub cpu_seconds: f64,
    /// Simulators times steps, a second of wall time.
    pub particle_steps_per_second: f64,
    /// Simulators times steps, a second of CPU time.
    pub particle_steps_per_cpu_second: f64,
    /// Pair collisions a second of wall time.
    pub collisions_per_second: f64,
    /// Pair collisions for each simulator and step.
    pub collisions_per_step: f64,
    /// Collision rate over that of kinetic theory.
    pub collision_rate_over_theory: f64,
    /// Pairs tried, for each collision.
    pub trials_per_collision: f64,
    /// Memory of the engine, all included, for each simulator.
    pub bytes_per_simulator: f64,
}

impl MonteCarlo {
    /// Makes the start, runs a few steps to warm up, and times the others.
    ///
    /// # Errors
    /// [`BenchError`] if a number is out of range.
    pub fn time(self) -> Result<MonteCarloSpeed, BenchError> {
        match self.dimension {
            2 => self.time_in::<Plane>(),
            3 => self.time_in::<Volume>(),
            other => Err(BenchError::BadNumber {
                name: "dimension",
                value: other as f64,
                allowed: "2 or 3",
            }),
        }
    }

    fn check(&self) -> Result<(), BenchError> {
        for (name, value) in [
            ("per-cell", self.per_cell),
            ("collisions-per-step", self.collisions_per_step),
        ] {
            if !(1e-6..=1e6).contains(&value) {
                return Err(BenchError::BadNumber {
                    name,
                    value,
                    allowed: "from 1e-6 to 1e6",
                });
            }
        }
        Ok(())
    }

    fn time_in<S: Space>(self) -> Result<MonteCarloSpeed, BenchError> {
        /// Steps before timing: tiles get their room.
        const WARM_UP: u64 = 5;
        self.check()?;
        // With the mean free path l/phi, a cell holds phi (l/2 phi)^D over the volume of a particle.
        let ball = S::ball(0.5);
        let path = S::mean_free_path(1.0, 1.0);
        let dimension = S::DIMENSION as f64;
        let power = (0.5 * path).powf(dimension) / (ball * self.per_cell);
        let packing_fraction = power.powf(1.0 / (dimension - 1.0));
        let cell = 0.5 * path / packing_fraction;
        let wanted = self.simulators as f64 / self.per_cell;
        let cells = wanted.powf(1.0 / dimension).round().max(1.0);
        let simulators = (self.per_cell * cells.powf(dimension)).round().max(1.0) as usize;
        let (scene, state) = start::<S>(simulators, cell * cells)?;
        let theory = S::collision_rate(packing_fraction, 1.0);
        let step = 2.0 * self.collisions_per_step / theory;
        let parameters = Parameters {
            scheme: if self.free_flight {
                Scheme::Collisionless
            } else {
                Scheme::Boltzmann
            },
            displacement: Displacement::None,
            cell_size: Some(cell),
            simulators_per_disk: 1,
            copies: Copies::Independent,
            steps_per_crossing: 4.0,
            largest_contact_value: 10.0,
        };
        let mut engine = Engine::new(&scene, parameters, &state, Streams::new(1, 0))?;
        drop(state);
        engine.hold_step(step);
        engine.advance(f64::INFINITY, WARM_UP, &mut ());
        let (tally, time) = (engine.tally(), engine.time());
        let (began, cpu) = (Instant::now(), ProcessTime::now());
        engine.advance(f64::INFINITY, self.steps, &mut ());
        let (seconds, cpu) = (began.elapsed().as_secs_f64(), cpu.elapsed().as_secs_f64());
        let collisions = (engine.tally().collisions - tally.collisions) as f64;
        let trials = (engine.tally().trials - tally.trials) as f64;
        let done = simulators as f64 * self.steps as f64;
        let rate = 2.0 * collisions / simulators as f64 / (engine.time() - time);
        Ok(MonteCarloSpeed {
            simulators,
            cells: engine.grid().cells(),
            steps: self.steps,
            seconds,
            cpu_seconds: cpu,
            particle_steps_per_second: done / seconds,
            particle_steps_per_cpu_second: done / cpu,
            collisions_per_second: collisions / seconds,
            collisions_per_step: collisions / done,
            collision_rate_over_theory: rate / theory,
            trials_per_collision: trials / collisions.max(1.0),
            bytes_per_simulator: engine.bytes() as f64 / simulators as f64,
        })
    }
}

/// An ideal gas at temperature one in a box with the given side.
fn start<S: Space>(count: usize, side: f64) -> Result<(Gas<S>, State<Gas<S>>), BenchError> {
    let scene = Scene {
        space: S::default(),
        surface: Smooth,
        restitution: Constant::ELASTIC,
        sizes: Monodisperse {
            radius: 0.5,
            mass: 1.0,
        },
        field: Free,
    };
    let origin = VectorOf::<Gas<S>>::default();
    let mut lengths = origin;
    for axis in 0..S::DIMENSION {
        lengths[axis] = side;
    }
    let domain = Domain::periodic(lengths).ok_or(BenchError::BadNumber {
        name: "simulators",
        value: count as f64,
        allowed: "a number that gives a finite box",
    })?;
    let streams = Streams::new(1, 0);
    let mut stream = streams.at(Purpose::Placement, [0, 0]);
    let bodies = (0..count)
        .map(|_| {
            let mut position = origin;
            for axis in 0..S::DIMENSION {
                position[axis] = side * stream.random::<f64>();
            }
            Body::new(position, origin)
        })
        .collect();
    let mut state = State {
        time: 0.0,
        domain,
        bodies,
    };
    let mut stream = streams.at(Purpose::Velocities, [0, 0]);
    stosszahl_model::initial::maxwellian(&scene, &mut state, 1.0, &mut stream);
    debug_assert!(state.momentum(&scene).square() < 1e-6);
    Ok((scene, state))
}
