//! One engine of one replica, from the initial state to the last sample.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::Path;
use std::time::Instant;

use serde::{Deserialize, Serialize};
use stosszahl_analysis::energy::EnergySample;
use stosszahl_dsmc::{Engine as MonteCarlo, Follow, Followed, Unfollowed};
use stosszahl_ed::Dissipation;
use stosszahl_model::random::Streams;
use stosszahl_model::{Drive, Plane, Sizes, State, snapshot};

use super::gas::{Exact, ExactCheckpoint, Gas};
use super::record::{Moment, Record, Structure, partial_temperatures, schedule};
use super::{Control, RunError};
use crate::case::{Dsmc, Engine, EventDriven, Scheme};
use crate::dispatch::Planar;
use crate::setup::Setup;

/// What was done, in numbers that do not depend on the machine.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Work {
    /// Pair collisions, of simulators where those collide.
    pub collisions: u64,
    /// Largest memory of the engine between legs \[bytes\].
    pub bytes: usize,
    /// Named numbers.
    pub numbers: BTreeMap<String, f64>,
}

/// A job on its way.
#[derive(Serialize, Deserialize)]
pub(super) struct Progress<C> {
    /// `None` once finished: the record is all that is kept.
    engine: Option<C>,
    next: usize,
    pub(super) record: Record,
    pub(super) seconds: f64,
    pub(super) work: Option<Work>,
}

/// A finished job.
#[derive(Clone, Debug)]
pub struct Finished {
    /// What was measured.
    pub record: Record,
    /// What was done.
    pub work: Work,
    /// Computing time \[s\].
    pub seconds: f64,
}

/// Runs one engine of one replica.
pub(super) fn run_engine<P: Planar>(
    setup: &Setup,
    scene: &P,
    engine: &Engine,
    start: &State<P>,
    streams: Streams,
    control: &Control<'_, ()>,
    snapshots: Option<&Path>,
) -> Result<Finished, RunError> {
    // All engines of a replica draw the same kicks.
    let noise = setup.drive()?.map(|drive| (drive, streams));
    match engine {
        Engine::Ed(EventDriven {
            contact_time,
            collision_limit,
        }) => {
            let dissipation = if *contact_time > 0.0 {
                Dissipation::ContactTime(contact_time * setup.time)
            } else {
                Dissipation::Scene
            };
            let begin = |checkpoint: Option<ExactCheckpoint<P>>| {
                let checkpoint = checkpoint.unwrap_or_else(|| ExactCheckpoint {
                    gas: start.clone().into(),
                    origin: Vec::new(),
                });
                let ExactCheckpoint { gas, origin } = checkpoint;
                Ok(Exact {
                    scene: scene.clone(),
                    dissipation,
                    limit: *collision_limit,
                    gas,
                    origin,
                    bytes: 0,
                })
            };
            follow(setup, engine, noise, begin, &control.with(), snapshots)
        }
        Engine::Dsmc(dsmc) => {
            let parameters = setup.dsmc_parameters(dsmc);
            let streams = streams.branch(scheme_number(dsmc));
            // Which of the two is decided by the case, so a checkpoint is always of the same kind.
            if schedule(setup)
                .iter()
                .any(|moment| moment.displacement.is_some())
            {
                let begin = begin_dsmc::<P, Followed>(scene, parameters, start, streams);
                follow(setup, engine, noise, begin, &control.with(), snapshots)
            } else {
                let begin = begin_dsmc::<P, Unfollowed>(scene, parameters, start, streams);
                follow(setup, engine, noise, begin, &control.with(), snapshots)
            }
        }
    }
}

/// How a Monte Carlo gas begins, or goes on from a checkpoint.
fn begin_dsmc<P: Planar, F: Follow<Plane>>(
    scene: &P,
    parameters: stosszahl_dsmc::Parameters,
    start: &State<P>,
    streams: Streams,
) -> impl FnOnce(Option<stosszahl_dsmc::Checkpoint<P, F>>) -> Result<MonteCarlo<P, F>, RunError> {
    move |checkpoint| {
        Ok(match checkpoint {
            Some(gas) => MonteCarlo::resume(scene, parameters, start.domain, gas, streams)?,
            None => MonteCarlo::start(scene, parameters, start, streams)?,
        })
    }
}

/// Different schemes of one replica draw different numbers.
fn scheme_number(dsmc: &Dsmc) -> u64 {
    match dsmc.scheme {
        Scheme::Boltzmann { .. } => 1,
        Scheme::FreeVolume { .. } => 2,
        Scheme::Enskog { .. } => 3,
        Scheme::Esmc { .. } => 4,
        Scheme::StochasticDisks { .. } => 5,
        Scheme::ContactPoint { .. } => 6,
    }
}

fn follow<G: Gas>(
    setup: &Setup,
    engine: &Engine,
    noise: Option<(Drive, Streams)>,
    begin: impl FnOnce(Option<G::Checkpoint>) -> Result<G, RunError>,
    control: &Control<'_, Progress<G::Checkpoint>>,
    snapshots: Option<&Path>,
) -> Result<Finished, RunError> {
    let schedule = schedule(setup);
    let loaded = control.load()?;
    let (mut next, mut record, mut seconds, mut gas) = match loaded {
        Some(Progress {
            work: Some(work),
            record,
            seconds,
            ..
        }) => {
            control.tell(1.0, 0);
            return Ok(Finished {
                record,
                work,
                seconds,
            });
        }
        Some(Progress {
            engine,
            next,
            record,
            seconds,
            ..
        }) => (next, Some(record), seconds, begin(engine)?),
        None => (0, None, 0.0, begin(None)?),
    };
    let asked = !setup.case.measure.structure.times.is_empty();
    let mut structure = if asked {
        Some(Structure::new(setup)?)
    } else {
        None
    };
    let mut began = Instant::now();
    let mut lap = || {
        let passed = began.elapsed().as_secs_f64();
        began = Instant::now();
        passed
    };
    if record.is_none() {
        record = Some(Record::new(setup, gas.state().temperature(gas.scene())));
    }
    let mut record = record.expect("just made");
    let mut bytes = gas.bytes();
    while let Some(moment) = schedule.get(next) {
        let before = gas.collisions();
        let kick = kick_after(setup, &record);
        // What is measured at the time of a kick is measured before it.
        let until = kick.map_or(moment.time_over_t0, |kick| kick.min(moment.time_over_t0));
        let reached = gas
            .leg(until * setup.time, &mut record.windows)
            .map_err(|error| stopped(setup, engine, &gas, control.path.as_deref(), error))?;
        bytes = bytes.max(gas.bytes());
        if reached && until == moment.time_over_t0 {
            if moment.displacement == Some(0.0) {
                gas.follow_displacements();
            }
            sample(
                setup,
                engine,
                &gas,
                moment,
                &mut record,
                structure.as_mut(),
                snapshots,
            )?;
            next += 1;
        } else if let (true, Some((drive, streams))) = (reached, noise) {
            kick_now(setup, &mut gas, drive, streams, &mut record);
        }
        control.tell(share(setup, gas.time()), gas.collisions() - before);
        if next < schedule.len() {
            seconds += lap();
            control.pause_with(|| Progress {
                engine: Some(gas.checkpoint()),
                next,
                record: record.clone(),
                seconds,
                work: None,
            })?;
        }
    }
    seconds += lap();
    let work = Work {
        collisions: gas.collisions(),
        bytes,
        numbers: gas.work(),
    };
    control.save(&Progress {
        engine: None,
        next,
        record: record.clone(),
        seconds,
        work: Some(work.clone()),
    })?;
    control.tell(1.0, 0);
    Ok(Finished {
        record,
        work,
        seconds,
    })
}

/// What an engine that cannot go on leaves: its state, beside the checkpoints, and the error that tells where.
fn stopped<G: Gas>(
    setup: &Setup,
    engine: &Engine,
    gas: &G,
    checkpoint: Option<&Path>,
    error: RunError,
) -> RunError {
    let (RunError::EventDriven(_), Some(checkpoint)) = (&error, checkpoint) else {
        return error;
    };
    let RunError::EventDriven(source) = error else {
        return error;
    };
    let path = checkpoint.with_extension("stopped.xyz");
    let time = gas.time() / setup.time;
    let text = extended_xyz(setup, gas.scene(), &gas.state(), engine.name(), time);
    match snapshot::write_whole(&path, text.as_bytes()) {
        Ok(()) => RunError::Stopped { source, path },
        // What stopped it matters more than where it could not be written.
        Err(_) => RunError::EventDriven(source),
    }
}

/// Time of the next kick, in units of `t_0`.
fn kick_after(setup: &Setup, record: &Record) -> Option<f64> {
    let number = record.driven.as_ref()?.kicks + 1;
    Some(number as f64 * setup.case.drive?.interval)
}

fn kick_now<G: Gas>(
    setup: &Setup,
    gas: &mut G,
    drive: Drive,
    streams: Streams,
    record: &mut Record,
) {
    let Some(driven) = &mut record.driven else {
        return;
    };
    let before = gas.state().temperature(gas.scene());
    gas.kick(drive, driven.kicks, streams);
    let after = gas.state().temperature(gas.scene());
    let middle = gas.time() - 0.5 * drive.interval();
    driven.kick(middle / (setup.case.run.until * setup.time), before, after);
    record.windows.synchronise(gas.time(), after);
}

/// The share of a run that is done, by the collisions that theory expects.
fn share(setup: &Setup, time: f64) -> f64 {
    setup.expected_collisions(time / setup.time) / setup.expected_collisions(setup.case.run.until)
}

fn sample<G: Gas>(
    setup: &Setup,
    engine: &Engine,
    gas: &G,
    moment: &Moment,
    record: &mut Record,
    structure: Option<&mut Structure<'_>>,
    snapshots: Option<&Path>,
) -> Result<(), RunError> {
    let state = gas.state();
    let energy = EnergySample::new(gas.scene(), &state, gas.collisions());
    record.windows.synchronise(state.time, energy.temperature);
    let time = moment.time_over_t0;
    if moment.energy {
        record.energies.push((time, energy));
        let partial = partial_temperatures(setup, gas.scene(), &state);
        if !partial.is_empty() {
            record.partial.push((time, partial));
        }
    }
    if let Some(elapsed) = moment.displacement.filter(|&elapsed| elapsed > 0.0) {
        let square = gas.mean_squared_displacement();
        record.displacements.push((elapsed, square));
    }
    if let (true, Some(structure)) = (moment.structure, structure) {
        let (factor, pairs) = structure.measure(&state, gas.weight())?;
        record.structure.push((time, factor));
        record.pairs.push((time, pairs));
    }
    if let (true, Some(folder)) = (moment.snapshot, snapshots) {
        let index = setup
            .case
            .measure
            .snapshot_times
            .iter()
            .position(|&known| known == time)
            .unwrap_or(0);
        let text = extended_xyz(setup, gas.scene(), &state, engine.name(), time);
        snapshot::write_whole(
            &folder.join(format!("{}-{index}.xyz", engine.name())),
            text.as_bytes(),
        )?;
    }
    Ok(())
}

/// The extended XYZ format that OVITO and ASE read, in the units of the case.
fn extended_xyz<P: Planar>(
    setup: &Setup,
    scene: &P,
    state: &State<P>,
    engine: &str,
    time: f64,
) -> String {
    let (length, speed) = (setup.scale.length, setup.scale.speed());
    let box_sides = state.domain.lengths() * length;
    let mut text = String::with_capacity(100 * state.bodies.len());
    // Writing to a string cannot fail.
    let _ = writeln!(text, "{}", state.bodies.len());
    let _ = writeln!(
        text,
        "Lattice=\"{} 0 0 0 {} 0 0 0 1\" Properties=id:I:1:pos:R:3:velo:R:3:radius:R:1:mass:R:1 Time={} TimeOverT0={time} Engine={engine}",
        box_sides[0],
        box_sides[1],
        state.time * setup.scale.time(),
    );
    let sizes = scene.sizes();
    for (index, body) in state.bodies.iter().enumerate() {
        let (at, v) = (body.position * length, body.velocity * speed);
        let tag = sizes.tag(index);
        let (radius, mass) = (
            sizes.radius(tag) * length,
            sizes.mass(tag) * setup.scale.mass,
        );
        let _ = writeln!(
            text,
            "{index} {} {} 0 {} {} 0 {radius} {mass}",
            at[0], at[1], v[0], v[1]
        );
    }
    text
}
