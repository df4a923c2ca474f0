//! Run of one engine of one replica, from start to end: one loop over scheduled sample times for
//! every kind of case.
//!
//! A run is cut into segments. A segment is a function of the checkpoint before it, and counts of
//! work, never a clock, determine the cuts. So the results do not depend on where a run is stopped.

mod collision_rate;
mod error;
pub(crate) mod in_memory;
pub(crate) mod kicks;
pub(crate) mod schedule;

use std::collections::BTreeMap;
use std::time::Instant;

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};
use serde_bytes::ByteBuf;
use stosszahl_model::random::Streams;
use stosszahl_model::{
    Budget, Failure, Interrupt, Observer, Particles, Simulation, VelocityMoments, WorkCounters,
};

use crate::control::{Content, Control, Rollback, Set};
use crate::engine_run::collision_rate::RateWindow;
use crate::engine_run::kicks::StochasticDrive;
use crate::engine_run::schedule::{ScheduledEvent, schedule_events};
use crate::engines::rank_group::RankGroup;
use crate::engines::{self, From as Source};
use crate::measure::{CompletedRun, Measure, Needs, Probe, RunStop, SampleContext};
use crate::measures::extended_xyz;
use crate::plan::{CasePlan, EngineKind, EnginePlan};
use crate::start::{Preparation, StartError, StartReport};

pub use error::{Elsewhere, PartError};

/// Creates the equilibrated start of a replica, or resumes from its checkpoint.
///
/// # Errors
/// [`PartError`]; the checkpoint is kept.
pub fn prepare(
    plan: &CasePlan,
    replica: u64,
    control: &Control<'_, Preparation>,
) -> Result<(StartReport, Particles), PartError> {
    let streams = Streams::new(plan.case.seed, replica);
    let interrupt = control.interrupt();
    let mut start = match control.load()? {
        Some(start) => start,
        None => Preparation::new(plan, streams, interrupt)?,
    };
    // An interrupted segment leaves the preparation unchanged.
    let mut rollback = Rollback::default();
    loop {
        match start.leg(plan, streams, interrupt) {
            Ok(true) => break,
            Ok(false) => control.report_progress(start.done_share(plan), 0),
            Err(StartError::Interrupted) => {}
            Err(error) => return Err(error.into()),
        }
        control.pause(&mut rollback, || Ok::<_, PartError>(start.clone()))?;
    }
    control.report_progress(1.0, 0);
    control.finish(|| Ok::<_, PartError>(start.clone()))?;
    let report = start.report().cloned().unwrap_or_default();
    Ok((report, start.particles(plan, streams)?))
}

/// Checkpoint data of an engine run: engine state and records of the probes.
#[derive(Debug, Serialize, Deserialize)]
pub struct Saved {
    /// Checkpoint bytes of the engine; `None` once the run is finished and only records are kept.
    #[serde(with = "serde_bytes")]
    engine: Option<Vec<u8>>,
    /// Set of shards that holds the particles of the engine; `None` without shards.
    set: Option<Set>,
    next: usize,
    kicks: u64,
    heated: f64,
    records: Vec<ByteBuf>,
    seconds: f64,
    bytes: usize,
    collisions: u64,
    numbers: BTreeMap<String, f64>,
    rate: RateWindow,
}

impl Content for Saved {
    fn shard_set(&self) -> Option<Set> {
        self.set
    }
}

/// Run of one engine of one replica: its plan, its measures and its start.
pub struct EngineRun<'a> {
    /// Resolved plan of the case.
    pub plan: &'a CasePlan,
    /// Plan of the engine to run.
    pub engine: &'a EnginePlan,
    /// Measures of the case, in the order of their probes.
    pub measures: &'a [&'static dyn Measure],
    /// Number of the replica, from 0.
    pub replica: u64,
    /// Initial state that the engines share; `None` if each engine makes its own.
    pub start: Option<&'a Particles>,
}

/// State of one engine run in progress: simulation, probes, next scheduled sample.
pub(crate) struct RunState<'a> {
    part: &'a EngineRun<'a>,
    interrupt: &'a Interrupt,
    pub(crate) gas: Box<dyn Simulation>,
    pub(crate) probes: Vec<Box<dyn Probe>>,
    pub(crate) next: usize,
    /// Set of shards of the last checkpoint; `None` without shards.
    set: Option<Set>,
    kicks: u64,
    heated: f64,
    seconds: f64,
    bytes: usize,
    rate: RateWindow,
    began: Instant,
}

impl EngineRun<'_> {
    /// Returns the random streams of the replica.
    pub fn streams(&self) -> Streams {
        Streams::new(self.plan.case.seed, self.replica)
    }

    /// Returns what the measures require of the engine, such as collisions or displacements.
    pub(crate) fn needs(&self) -> Needs {
        let all = self
            .measures
            .iter()
            .map(|measure| measure.engine_needs(self.plan));
        all.fold(Needs::default(), |sum, one| Needs {
            displacements: sum.displacements || one.displacements,
            trajectories: sum.trajectories.max(one.trajectories),
        })
    }

    fn probes(&self) -> Vec<Box<dyn Probe>> {
        let one = |measure: &&dyn Measure| measure.new_probe(self.plan, self.engine);
        self.measures.iter().map(one).collect()
    }

    /// Restores the records of a finished run from its checkpoint.
    ///
    /// # Errors
    /// [`PartError::Record`] if the checkpoint is of another case.
    pub(crate) fn restore(&self, saved: Saved) -> Result<CompletedRun, PartError> {
        let mut probes = self.probes();
        saved.load(&mut probes)?;
        Ok(saved.finished(probes))
    }

    /// Runs the engine to the end of the case, or resumes it from its checkpoint.
    ///
    /// # Errors
    /// [`PartError`]; the checkpoint is kept.
    pub fn run_engine(&self, control: &Control<'_, Saved>) -> Result<CompletedRun, PartError> {
        self.run_in(control, None)
    }

    /// Runs a decomposed gas to the end, together with the processes of `group`.
    ///
    /// # Errors
    /// As [`Self::run_engine`].
    pub(crate) fn run_in(
        &self,
        control: &Control<'_, Saved>,
        group: Option<&RankGroup>,
    ) -> Result<CompletedRun, PartError> {
        let (plan, streams) = (self.plan, self.streams());
        let schedule = schedule_events(plan, self.measures);
        let interrupt = control.interrupt();
        let mut course = if let Some(saved) = control.load()? {
            if saved.engine.is_none() {
                control.report_progress(1.0, 0);
                return self.restore(saved);
            }
            let mut probes = self.probes();
            saved.load(&mut probes)?;
            let engine = saved.engine.as_deref().unwrap_or_default();
            let beside = control.beside().filter(|_| saved.set.is_some());
            let source = Source::Checkpoint(engine, beside.as_ref());
            RunState {
                next: saved.next,
                set: saved.set,
                kicks: saved.kicks,
                heated: saved.heated,
                seconds: saved.seconds,
                bytes: saved.bytes,
                rate: saved.rate,
                ..RunState::new(self, probes, source, interrupt, group)?
            }
        } else {
            RunState::begin(self, interrupt, group)?
        };
        let drive = StochasticDrive::new(plan, streams)?;
        let mut rollback = Rollback::default();
        while let Some(due) = schedule.get(course.next) {
            let before = course.gas.work_counters().collisions;
            control.keep(&mut rollback, || course.save(control))?;
            match course.leg(due, drive.as_ref()) {
                Err(PartError::Interrupted) => {
                    return Err(control.roll_back(&mut rollback)?.into());
                }
                done => done?,
            }
            if let Some(activity) = course.look_at_rate()? {
                control.tell_activity(&activity);
            }
            let time = course.gas.time() / plan.clock.time;
            control.report_progress(
                plan.done_share(time),
                course.gas.work_counters().collisions.saturating_sub(before),
            );
            if course.next < schedule.len() {
                course.record_elapsed();
                control.pause(&mut rollback, || course.save(control))?;
            }
        }
        course.record_elapsed();
        control.report_progress(1.0, 0);
        let finished = CompletedRun {
            work: course.gas.work_counters(),
            probes: course.probes,
            bytes: course.bytes,
            seconds: course.seconds,
        };
        control.finish(|| Ok::<_, PartError>(finished.save()?))?;
        Ok(finished)
    }
}

impl<'a> RunState<'a> {
    /// Begins an engine run at its initial state, and takes the first samples of its probes.
    pub(crate) fn begin(
        part: &'a EngineRun<'a>,
        interrupt: &'a Interrupt,
        group: Option<&RankGroup>,
    ) -> Result<Self, PartError> {
        let source = Source::Start(part.start);
        let mut course = Self::new(part, part.probes(), source, interrupt, group)?;
        for (probe, measure) in course.probes.iter_mut().zip(part.measures) {
            if measure.looks_at(part.plan, part.replica) {
                let mut moment = SampleContext::new(0.0, &mut *course.gas);
                moment.replica = part.replica;
                probe.on_start(&mut moment);
            }
        }
        Ok(course)
    }

    fn new(
        part: &'a EngineRun<'a>,
        probes: Vec<Box<dyn Probe>>,
        source: Source<'_>,
        interrupt: &'a Interrupt,
        group: Option<&RankGroup>,
    ) -> Result<Self, PartError> {
        let (plan, engine, streams) = (part.plan, part.engine, part.streams());
        let group = group.map(|all| (all, part.replica));
        let needs = part.needs();
        let gas = engines::begin(plan, engine, streams, needs, source, interrupt, group)?;
        Ok(Self {
            part,
            interrupt,
            bytes: gas.memory_bytes(),
            gas,
            probes,
            next: 0,
            set: None,
            kicks: 0,
            heated: 0.0,
            seconds: 0.0,
            rate: RateWindow::default(),
            began: Instant::now(),
        })
    }

    /// Advances the gas by one segment towards the next scheduled time, and samples if it is
    /// reached.
    pub(crate) fn leg(
        &mut self,
        due: &ScheduledEvent,
        drive: Option<&StochasticDrive>,
    ) -> Result<(), PartError> {
        let plan = self.part.plan;
        if let EngineKind::EventDriven {
            collision_limit: Some(limit),
            ..
        } = self.part.engine.kind
        {
            let collisions = self.gas.work_counters().collisions;
            if collisions >= limit {
                return Err(PartError::CollisionLimit { collisions });
            }
        }
        // Samples at the time of a kick are taken before the kick.
        let kick = drive.map(|drive| drive.time(self.kicks));
        let until = kick.map_or(due.time, |kick| kick.min(due.time));
        let end = plan.engine_time(until);
        let reached = {
            let observers = self
                .probes
                .iter_mut()
                .filter_map(|probe| probe.collision_observer());
            let mut all = observers.collect::<Vec<&mut dyn Observer>>();
            let gas = &mut self.gas;
            let advanced = gas.advance(end, Budget::Leg, &mut all.as_mut_slice());
            advanced.map_err(|failure| stop_error(self.part, &**gas, plan.told(failure)))?
        };
        if self.gas.is_interrupted() {
            return Err(PartError::Interrupted);
        }
        self.bytes = self.bytes.max(self.gas.memory_bytes());
        if reached && until == due.time {
            self.take_samples(due)?;
            self.next += 1;
        } else if let (true, Some(drive)) = (reached, drive) {
            let before = self.gas.temperature();
            drive.act(&mut *self.gas, self.kicks)?;
            self.kicks += 1;
            self.stop(Some(before));
        }
        Ok(())
    }

    /// Checks the collision rate of exact dynamics. Returns a description of the particles that
    /// collide most if the rate is high.
    fn look_at_rate(&mut self) -> Result<Option<String>, PartError> {
        let (part, gas) = (self.part, &*self.gas);
        let looked = self.rate.check_rate(part.plan, part.engine, gas);
        looked.map_err(|failure| stop_error(part, gas, failure))
    }

    /// Passes time and temperature to the probes when the gas has stopped for a sample or a kick;
    /// returns its velocity moments.
    fn stop(&mut self, kicked_from: Option<f64>) -> VelocityMoments {
        let moments = self.gas.velocity_moments();
        let stop = RunStop {
            time: self.gas.time(),
            temperature: moments.temperature(self.gas.dimension()),
            kicked_from,
        };
        self.probes
            .iter_mut()
            .for_each(|probe| probe.on_stop(&stop));
        moments
    }

    /// Subtracts the mean velocity of the gas. Otherwise the thermostat's scaling would amplify its
    /// rounding error without limit.
    fn remove_drift(&mut self) -> Result<(), PartError> {
        let (mut momentum, mut mass) = (Vector3::<f64>::zeros(), 0.0);
        self.gas.visit_particles(&mut |one| {
            momentum += one.weight * one.mass * one.velocity;
            mass += one.weight * one.mass;
        });
        let count = self.gas.particle_count();
        Ok(self.gas.add_velocities(&vec![-momentum / mass; count])?)
    }

    /// Rescales velocities and takes samples, as far as they are due at this time.
    fn take_samples(&mut self, due: &ScheduledEvent) -> Result<(), PartError> {
        let plan = self.part.plan;
        if due.heating {
            if plan.case.domain.is_some() {
                self.remove_drift()?;
            }
            let (start, now) = (start_energy(plan), kinetic_energy(&*self.gas));
            // A gas of one cluster at rest cannot be heated.
            if now > 0.0 {
                let before = self.gas.temperature();
                self.gas.scale_velocities((start / now).sqrt())?;
                self.heated += start - now;
                self.stop(Some(before));
            }
        }
        if due.measures.is_empty() {
            return Ok(());
        }
        let moments = self.stop(None);
        let mut moment = SampleContext::new(due.time, &mut *self.gas).with_moments(moments);
        moment.replica = self.part.replica;
        moment.heated = self.heated;
        moment.interrupt = self.interrupt.clone();
        for &number in &due.measures {
            if self.part.measures[number].looks_at(self.part.plan, self.part.replica) {
                self.probes[number].on_sample(&mut moment);
            }
            if self.interrupt.is_raised() {
                return Err(PartError::Interrupted);
            }
        }
        Ok(())
    }

    fn record_elapsed(&mut self) {
        self.seconds += self.began.elapsed().as_secs_f64();
        self.began = Instant::now();
    }

    /// Writes the checkpoint of the engine: as shards where possible, into the set that the last
    /// checkpoint does not use.
    fn checkpoint(
        &self,
        control: &Control<'_, Saved>,
    ) -> Result<(Vec<u8>, Option<Set>), PartError> {
        let set = self.set.map_or(Set::A, Set::other);
        if let Some((stem, run)) = control.shards(set)
            && let Some(bytes) =
                (self.gas.checkpoint_in_shards(&stem, run)).map_err(PartError::Shards)?
        {
            return Ok((bytes, Some(set)));
        }
        Ok((self.gas.save_checkpoint()?, None))
    }

    /// Collects the data of a checkpoint: engine state and records of all probes.
    fn save(&mut self, control: &Control<'_, Saved>) -> Result<Saved, PartError> {
        let (engine, set) = self.checkpoint(control)?;
        self.set = set;
        let work = self.gas.work_counters();
        Ok(Saved {
            engine: Some(engine),
            set,
            next: self.next,
            kicks: self.kicks,
            heated: self.heated,
            records: records(&self.probes)?,
            seconds: self.seconds,
            bytes: self.bytes,
            collisions: work.collisions,
            numbers: work.numbers,
            rate: self.rate,
        })
    }
}

/// Creates the error of a gas that cannot continue, with its state for inspection.
fn stop_error(part: &EngineRun<'_>, gas: &dyn Simulation, failure: Failure) -> PartError {
    let state = extended_xyz(&gas.particles(), part.plan, part.engine.name);
    PartError::Stopped { failure, state }
}

/// Serializes the records of all probes.
fn records(probes: &[Box<dyn Probe>]) -> Result<Vec<ByteBuf>, postcard::Error> {
    let saved = probes.iter().map(|probe| probe.save_record());
    saved.map(|record| Ok(ByteBuf::from(record?))).collect()
}

impl CompletedRun {
    /// Collects the checkpoint data of a finished run.
    ///
    /// # Errors
    /// If a record cannot be serialized, which is an error of the program.
    pub(crate) fn save(&self) -> Result<Saved, postcard::Error> {
        Ok(Saved {
            engine: None,
            set: None,
            next: 0,
            kicks: 0,
            heated: 0.0,
            records: records(&self.probes)?,
            seconds: self.seconds,
            bytes: self.bytes,
            collisions: self.work.collisions,
            numbers: self.work.numbers.clone(),
            rate: RateWindow::default(),
        })
    }
}

impl Saved {
    /// Restores the record of each probe from a checkpoint.
    fn load(&self, probes: &mut [Box<dyn Probe>]) -> Result<(), postcard::Error> {
        if probes.len() != self.records.len() {
            return Err(postcard::Error::DeserializeBadEncoding);
        }
        let mut both = probes.iter_mut().zip(&self.records);
        both.try_for_each(|(probe, record)| probe.load_record(record))
    }

    fn finished(self, probes: Vec<Box<dyn Probe>>) -> CompletedRun {
        CompletedRun {
            probes,
            work: WorkCounters {
                collisions: self.collisions,
                numbers: self.numbers,
            },
            bytes: self.bytes,
            seconds: self.seconds,
        }
    }
}

/// Returns the kinetic energy of the gas at the start \[energy\].
fn start_energy(plan: &CasePlan) -> f64 {
    let species = plan.gas.species.iter();
    let twice: f64 = species.map(|one| one.count as f64 * one.temperature).sum();
    0.5 * plan.gas.dimension as f64 * twice
}

fn kinetic_energy(gas: &dyn Simulation) -> f64 {
    let mut twice = 0.0;
    gas.visit_particles(&mut |one| twice += one.weight * one.mass * one.velocity.norm_squared());
    0.5 * twice
}
