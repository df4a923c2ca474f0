//! Benchmarks with the work defined: what `stosszahl bench` and `cargo bench` time.

use std::time::Instant;

use cpu_time::ProcessTime;
use nalgebra::vector;
use serde::Serialize;
use stosszahl_ed::{Checkpoint, Dissipation, Engine, EngineError, Tally};
use stosszahl_model::initial::{self, Arrangement, PlacementError};
use stosszahl_model::random::{Purpose, Streams};
use stosszahl_model::{
    Body, Constant, Domain, Free, Monodisperse, Plane, Scene, Smooth, State, kinetic,
};

mod monte_carlo;

pub use monte_carlo::{MonteCarlo, MonteCarloSpeed};

/// Smooth equal disks of diameter and mass one.
pub type Disks = Scene<Plane, Smooth, Constant, Monodisperse, Free>;

/// Why a benchmark cannot run.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum BenchError {
    /// A number out of range.
    #[error("--{name} {value}: allowed is {allowed}")]
    BadNumber {
        /// Which.
        name: &'static str,
        /// What was found.
        value: f64,
        /// What is allowed.
        allowed: &'static str,
    },
    /// The disks do not fit.
    #[error(transparent)]
    Placement(#[from] PlacementError),
    /// The engine cannot go on.
    #[error(transparent)]
    Engine(#[from] EngineError),
    /// The Monte Carlo engine cannot start.
    #[error(transparent)]
    MonteCarlo(#[from] stosszahl_dsmc::EngineError),
}

/// The scene of unit disks with a normal contact law.
pub fn unit_disks(restitution: Constant) -> Disks {
    Scene {
        space: Plane,
        surface: Smooth,
        restitution,
        sizes: Monodisperse {
            radius: 0.5,
            mass: 1.0,
        },
        field: Free,
    }
}

/// A piece of work for the event-driven engine.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EventDriven {
    /// Number of disks.
    pub disks: usize,
    /// Packing fraction.
    pub packing_fraction: f64,
    /// Coefficient of restitution while timing.
    pub restitution: f64,
    /// Arrangement of the start.
    pub arrangement: Arrangement,
    /// Elastic collisions per particle before timing.
    pub equilibrate: f64,
}

/// What was measured.
#[derive(Clone, Debug, Serialize)]
pub struct Speed {
    /// Pair collisions timed.
    pub collisions: u64,
    /// Wall time \[s\].
    pub seconds: f64,
    /// Pair collisions a second of wall time.
    pub collisions_per_second: f64,
    /// Pair collisions a second of this process's CPU time.
    pub collisions_per_cpu_second: f64,
    /// Memory of the engine, all included, for each disk.
    pub bytes_per_disk: f64,
    /// Candidate pairs predicted, for each collision.
    pub predictions_per_collision: f64,
    /// Events put into the calendar, for each collision.
    pub pushes_per_collision: f64,
    /// Cell boundaries crossed, for each collision.
    pub crossings_per_collision: f64,
    /// Stale events, for each collision.
    pub stale_per_collision: f64,
    /// Contacts whose partner had collided meanwhile, for each collision.
    pub broken_per_collision: f64,
}

/// An equilibrated gas, ready to be timed any number of times.
pub struct Prepared {
    work: EventDriven,
    scene: Disks,
    gas: Checkpoint<Disks>,
}

impl EventDriven {
    /// Makes the start and equilibrates it.
    ///
    /// # Errors
    /// [`BenchError`] if a number is out of range or the disks do not fit.
    pub fn prepare(self) -> Result<Prepared, BenchError> {
        let check = |name, value: f64, good: bool, allowed| {
            if good {
                Ok(())
            } else {
                Err(BenchError::BadNumber {
                    name,
                    value,
                    allowed,
                })
            }
        };
        let packing = self.packing_fraction;
        let close = kinetic::CLOSE_PACKING;
        check(
            "packing-fraction",
            packing,
            packing > 0.0 && packing <= close,
            "above 0 and at most 0.9069",
        )?;
        let each = self.equilibrate;
        check("equilibrate", each, (0.0..1e9).contains(&each), "0 or more")?;
        let law = Constant::new(self.restitution).ok_or(BenchError::BadNumber {
            name: "restitution",
            value: self.restitution,
            allowed: "from 0 to 1",
        })?;
        let scene = unit_disks(law);
        // The box of a hexagonal crystal, so that it fits up to close packing; square otherwise.
        let aspect = if self.arrangement == Arrangement::Hexagonal {
            crystal_aspect(self.disks)
        } else {
            1.0
        };
        let state = gas(self.arrangement, self.disks, packing, aspect, 1)?;
        let mut prepared = Prepared {
            work: self,
            scene,
            gas: state.into(),
        };
        let collisions = (0.5 * each * self.disks as f64).ceil() as u64;
        prepared.advance(Dissipation::Elastic, f64::INFINITY, collisions)?;
        prepared.gas.state.time = 0.0;
        Ok(prepared)
    }
}

/// A Maxwellian gas of unit disks at temperature one, `aspect` the height over width of its box.
///
/// # Errors
/// [`BenchError`] if the disks do not fit, or the box is no box.
pub fn gas(
    arrangement: Arrangement,
    disks: usize,
    packing_fraction: f64,
    aspect: f64,
    seed: u64,
) -> Result<State<Disks>, BenchError> {
    let area = disks as f64 * std::f64::consts::FRAC_PI_4 / packing_fraction;
    let width = (area / aspect).sqrt();
    let domain = Domain::periodic(vector![width, area / width]).ok_or(BenchError::BadNumber {
        name: "packing-fraction",
        value: packing_fraction,
        allowed: "one that gives a finite box",
    })?;
    let streams = Streams::new(seed, 0);
    let placement = initial::place(arrangement, disks, 1.0, &domain, &streams)?;
    let bodies = placement
        .positions
        .into_iter()
        .map(|at| Body::new(at, vector![0.0, 0.0]))
        .collect();
    let mut state = State {
        time: 0.0,
        domain,
        bodies,
    };
    let mut stream = streams.at(Purpose::Velocities, [0, 0]);
    initial::maxwellian(&unit_disks(Constant::ELASTIC), &mut state, 1.0, &mut stream);
    Ok(state)
}

/// Height over width of the box of a hexagonal crystal of about so many disks in equal columns and rows.
fn crystal_aspect(disks: usize) -> f64 {
    let rows = 2.0 * ((disks as f64).sqrt() / 2.0).round().max(1.0);
    let columns = (disks as f64 / rows).ceil();
    0.75_f64.sqrt() * rows / columns
}

impl Prepared {
    /// Advances; wall and CPU seconds, and the bytes that the engine held.
    fn advance(
        &mut self,
        dissipation: Dissipation,
        until: f64,
        collisions: u64,
    ) -> Result<(f64, f64, usize), EngineError> {
        let (began, cpu) = (Instant::now(), ProcessTime::now());
        let mut engine = Engine::<Disks>::new(self.scene.clone(), dissipation, self.gas.clone())?;
        engine.advance(until, collisions, &mut ())?;
        self.gas = engine.checkpoint();
        Ok((
            began.elapsed().as_secs_f64(),
            cpu.elapsed().as_secs_f64(),
            engine.bytes(),
        ))
    }

    /// Times the next collisions, or those until a time in units of `t_0` after the start; everything that a run does
    /// between them is included.
    ///
    /// # Errors
    /// [`BenchError::Engine`], as a collapse.
    pub fn time(&mut self, collisions: u64, until: Option<f64>) -> Result<Speed, BenchError> {
        let work = self.work;
        let chi = kinetic::contact_value(work.packing_fraction.min(0.999 * kinetic::CLOSE_PACKING));
        let unit = if work.restitution < 1.0 {
            kinetic::haff_time(work.packing_fraction, work.restitution, chi)
        } else {
            1.0 / kinetic::collision_rate(work.packing_fraction, chi, 0.0)
        };
        let until = until.map_or(f64::INFINITY, |time| time * unit);
        let before = self.gas.tally;
        let (seconds, cpu, bytes) = self.advance(Dissipation::Scene, until, collisions)?;
        let after = self.gas.tally;
        let done = after.collisions - before.collisions;
        let each =
            |count: fn(&Tally) -> u64| (count(&after) - count(&before)) as f64 / done.max(1) as f64;
        Ok(Speed {
            collisions: done,
            seconds,
            collisions_per_second: done as f64 / seconds,
            collisions_per_cpu_second: done as f64 / cpu,
            bytes_per_disk: bytes as f64 / work.disks as f64,
            predictions_per_collision: each(|tally| tally.predictions),
            pushes_per_collision: each(|tally| tally.pushes),
            crossings_per_collision: each(|tally| tally.crossings),
            stale_per_collision: each(|tally| tally.stale),
            broken_per_collision: each(|tally| tally.broken),
        })
    }
}
