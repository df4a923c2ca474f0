//! Runs all replicas of a case, with checkpoints, to the same bytes wherever it is stopped.

use std::fs;
use std::time::Instant;

use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use stosszahl_dsmc::homogeneous::{
    Bird, Checkpoint, Contacts, Displacement, Engine, Gas, Grains, LowRank, Motion, Paths,
    Selection, Slots, Sticking, Tally, Tracers, moments_by, size_distribution, time_averaged,
};
use stosszahl_model::random::{Purpose, Streams};
use stosszahl_model::{Clusters, Free, Plane, Scene, Smooth, Space, Species, VectorOf, Volume};

use super::case;
use super::law::Law;
use super::plan::Plan;
use super::record::{self, Due, Moment, Record, Sample, schedule};
use crate::progress::JobProgress;
use crate::run::{CHECKPOINTS, Control, Place, RunError};

/// Collisions between two checks of the clock, for each particle, and at least.
const LEG: f64 = 1.0;
const LEAST_LEG: u64 = 200_000;

/// One replica, finished.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Finished {
    /// What was measured.
    pub record: Record,
    /// What was done.
    pub tally: Tally,
    /// Bytes held for particles, selection and paths.
    pub bytes: usize,
    /// Computing time \[s\].
    pub seconds: f64,
}

type Mixed<S> = Scene<S, Smooth, Law, Species, Free>;
type Sticky<S> = Scene<S, Smooth, Law, Clusters, Free>;

/// Runs all replicas of a case on the current thread pool; continues from checkpoints where there are some.
///
/// # Errors
/// [`RunError`]; checkpoints stay.
pub fn run(plan: &Plan, place: Place<'_>) -> Result<Vec<Finished>, RunError> {
    let path = place.folder.join(CHECKPOINTS);
    fs::create_dir_all(&path).map_err(|source| RunError::Folder { path, source })?;
    let jobs = place.progress.jobs(plan.case.replicas);
    jobs.par_iter()
        .enumerate()
        .map(|(number, progress)| {
            let job = Replica {
                plan,
                place,
                number,
                progress,
            };
            job.run().map_err(|source| RunError::Replica {
                replica: number,
                part: "gas".to_owned(),
                source: Box::new(source),
            })
        })
        .collect()
}

/// One replica that is to be run.
struct Replica<'a> {
    plan: &'a Plan,
    place: Place<'a>,
    number: usize,
    progress: &'a JobProgress,
}

/// A replica on its way.
#[derive(Serialize, Deserialize)]
#[serde(bound(
    serialize = "E: Serialize, V: Serialize",
    deserialize = "E: Deserialize<'de>, V: Deserialize<'de>"
))]
struct Progress<E, V> {
    /// `None` once finished: the record is all that is kept.
    engine: Option<E>,
    /// Velocities at the start, where their correlation is measured.
    start: Option<Vec<V>>,
    next: usize,
    finished: Finished,
}

impl Replica<'_> {
    /// The place where choices of the case become types.
    fn run(&self) -> Result<Finished, RunError> {
        if self.plan.case.dimension == 2 {
            self.in_space(Plane)
        } else {
            self.in_space(Volume)
        }
    }

    fn in_space<S: Space>(&self, space: S) -> Result<Finished, RunError> {
        if self.plan.case.sticking.is_some() {
            return self.sticking(space);
        }
        let scene = Scene {
            space,
            surface: Smooth,
            restitution: self.plan.law.clone(),
            sizes: self.plan.species.clone(),
            field: Free,
        };
        match self.plan.case.selection {
            case::Selection::Own => self.bouncing::<S, Slots>(&scene),
            case::Selection::LowRank => self.bouncing::<S, LowRank>(&scene),
            case::Selection::Bird => self.bouncing::<S, Bird>(&scene),
        }
    }

    fn bouncing<S: Space, Pick: Selection<Mixed<S>>>(
        &self,
        scene: &Mixed<S>,
    ) -> Result<Finished, RunError> {
        let tracers = self.plan.tracer.map(|kind| Tracers { kind });
        if self.plan.case.measure.displacement {
            self.mixed::<S, Pick, Followed<S>>(scene, tracers)
        } else {
            self.mixed::<S, Pick, ()>(scene, tracers)
        }
    }

    fn streams(&self) -> Streams {
        Streams::new(self.plan.case.seed, self.number as u64)
    }

    fn mixed<S: Space, Pick, M>(
        &self,
        scene: &Mixed<S>,
        tracers: Option<Tracers>,
    ) -> Result<Finished, RunError>
    where
        Pick: Selection<Mixed<S>>,
        M: Trace<Mixed<S>>,
    {
        let plan = self.plan;
        let follow = Follow {
            replica: self,
            schedule: schedule(plan),
            begin: || {
                let gas = Gas::maxwellian(
                    scene.clone(),
                    plan.contact(),
                    plan.case.volume,
                    plan.particles(),
                    |kind| plan.temperature_of(kind),
                    &mut self.streams().at(Purpose::Velocities, [0, 0]),
                )?;
                let motion = M::begin(plan, &gas);
                let engine: Engine<Mixed<S>, Pick, M, Option<Tracers>> =
                    Engine::new(gas, motion, tracers, self.streams())?;
                let asked = plan.case.measure.velocity_correlation;
                let start = asked.then(|| engine.gas().alive().map(|p| p.velocity).collect());
                Ok((engine, start))
            },
            scene: scene.clone(),
        };
        follow.run(|engine, start, moment, record| {
            let time = moment.time;
            if moment.asks(Due::Sample) {
                let now = engine.time();
                let displacement = engine.motion().displacement().map(|paths| (paths, now));
                let groups = moments_by(engine.gas(), |kind| plan.group(kind), displacement, start);
                record.samples.push(sample(engine, time, groups));
            }
            if time == plan.case.run.until {
                record.time_averaged = averaged(plan, engine);
            }
        })
    }

    fn sticking<S: Space>(&self, space: S) -> Result<Finished, RunError> {
        let monomer = &self.plan.groups[0];
        let clusters = Clusters::new(
            0.5 * monomer.diameter,
            monomer.mass,
            self.plan.case.dimension,
            Vec::new(),
        );
        let clusters = clusters.ok_or(RunError::Gas(unusable("monomer")))?;
        let scene = Scene {
            space,
            surface: Smooth,
            restitution: self.plan.law.clone(),
            sizes: clusters,
            field: Free,
        };
        match self.plan.case.selection {
            case::Selection::Own => self.sticky::<S, Slots>(&scene),
            case::Selection::LowRank => self.sticky::<S, LowRank>(&scene),
            case::Selection::Bird => self.sticky::<S, Bird>(&scene),
        }
    }

    fn sticky<S: Space, Pick: Selection<Sticky<S>>>(
        &self,
        scene: &Sticky<S>,
    ) -> Result<Finished, RunError> {
        let plan = self.plan;
        let rule = plan.sticking().ok().flatten();
        let contacts = rule.ok_or(RunError::Gas(unusable("threshold")))?;
        let follow = Follow {
            replica: self,
            schedule: schedule(plan),
            begin: || {
                let gas = Gas::maxwellian(
                    scene.clone(),
                    plan.contact(),
                    plan.case.volume,
                    plan.particles(),
                    |_| plan.groups[0].temperature,
                    &mut self.streams().at(Purpose::Velocities, [0, 0]),
                )?;
                let engine: Engine<Sticky<S>, Pick, (), Sticking> =
                    Engine::new(gas, (), contacts, self.streams())?;
                Ok((engine, None))
            },
            scene: scene.clone(),
        };
        follow.run(|engine, _, moment, record| {
            let time = moment.time;
            if moment.asks(Due::Sample) {
                let groups = moments_by(engine.gas(), |_| 0, None, None);
                let mut sample = sample(engine, time, groups);
                sample.clusters = Some(clusters(engine, record.heated));
                record.samples.push(sample);
            }
            if !(moment.asks(Due::Sizes) || moment.asks(Due::Steady)) {
                return;
            }
            let sizes = size_distribution(engine.gas());
            if moment.asks(Due::Sizes) {
                record.sizes.push((time, sizes.iter().copied().collect()));
            }
            if moment.asks(Due::Steady) {
                let from = plan.case.measure.steady.map_or(0.0, |steady| steady.from);
                let late = time > 0.5 * (from + plan.case.run.until);
                let half = &mut record.steady[usize::from(late)];
                half.times += 1;
                for (monomers, count) in sizes {
                    *half.sizes.entry(monomers).or_default() += count;
                }
            }
        })
    }
}

/// What a check of the plan has excluded.
fn unusable(name: &'static str) -> stosszahl_dsmc::homogeneous::GasError {
    stosszahl_dsmc::homogeneous::GasError::BadNumber {
        name,
        value: f64::NAN,
        allowed: "a finite number above 0",
    }
}

/// What is kept of the paths of particles.
trait Trace<P: Grains>: Motion<P> {
    /// Begins to follow the particles of a gas.
    fn begin(plan: &Plan, gas: &Gas<P>) -> Self;

    /// Displacements, where they are kept.
    fn displacement(&self) -> Option<&Displacement<P>> {
        None
    }

    /// Whole paths, where some are kept.
    fn paths(&self) -> Option<&Paths<P>> {
        None
    }
}

impl<P: Grains> Trace<P> for () {
    fn begin(_plan: &Plan, _gas: &Gas<P>) {}
}

/// Displacements of all particles, and whole paths of some.
type Followed<S> = (Displacement<Mixed<S>>, Option<Paths<Mixed<S>>>);

impl<S: Space> Trace<Mixed<S>> for Followed<S> {
    fn begin(plan: &Plan, gas: &Gas<Mixed<S>>) -> Self {
        let displacement = Displacement::new(gas.count(), 0.0);
        if plan.lags().is_empty() {
            return (displacement, None);
        }
        let chosen: Vec<u32> = chosen(plan, gas).into_iter().flatten().collect();
        (displacement, Some(Paths::new(gas.count(), &chosen, 0.0)))
    }
    fn displacement(&self) -> Option<&Displacement<Mixed<S>>> {
        Some(&self.0)
    }
    fn paths(&self) -> Option<&Paths<Mixed<S>>> {
        self.1.as_ref()
    }
}

/// Particles whose whole paths are kept, the first ones of each group.
fn chosen<S: Space>(plan: &Plan, gas: &Gas<Mixed<S>>) -> Vec<Vec<u32>> {
    let mut lists = vec![Vec::new(); plan.groups.len()];
    for (index, particle) in gas.alive().enumerate() {
        let list: &mut Vec<u32> = &mut lists[plan.group(particle.tag)];
        if list.len() < plan.case.measure.paths {
            list.push(index as u32);
        }
    }
    lists
}

/// Displacements averaged over time, by group and lag; empty where no paths are kept.
fn averaged<S: Space, Pick, M, C>(
    plan: &Plan,
    engine: &Engine<Mixed<S>, Pick, M, C>,
) -> Vec<Vec<f64>>
where
    Pick: Selection<Mixed<S>>,
    M: Trace<Mixed<S>>,
    C: Contacts<Mixed<S>>,
{
    let Some(paths) = engine.motion().paths() else {
        return Vec::new();
    };
    let lags: Vec<f64> = plan.lags().iter().map(|lag| lag * plan.time).collect();
    let velocities: Vec<VectorOf<Mixed<S>>> = engine.gas().alive().map(|p| p.velocity).collect();
    let mut path = 0;
    chosen(plan, engine.gas())
        .into_iter()
        .map(|list| {
            let mut sums = vec![0.0; lags.len()];
            for &index in &list {
                let mut corners = paths.corners(path).to_vec();
                path += 1;
                if let Some(&(since, place)) = corners.last() {
                    let end = engine.time();
                    corners.push((end, place + velocities[index as usize] * (end - since)));
                }
                for (sum, &lag) in sums.iter_mut().zip(&lags) {
                    *sum += time_averaged(&corners, lag);
                }
            }
            let count = list.len().max(1) as f64;
            sums.iter().map(|sum| sum / count).collect()
        })
        .collect()
}

fn sample<P: Grains, S: Selection<P>, M: Motion<P>, C: Contacts<P>>(
    engine: &Engine<P, S, M, C>,
    time: f64,
    groups: Vec<stosszahl_dsmc::homogeneous::Moments>,
) -> Sample {
    Sample {
        time,
        particles: engine.gas().count(),
        collisions: engine.tally().collisions,
        energy: engine.gas().kinetic_energy(),
        groups,
        clusters: None,
    }
}

fn clusters<S: Space, Pick: Selection<Sticky<S>>>(
    engine: &Engine<Sticky<S>, Pick, (), Sticking>,
    heated: f64,
) -> record::Clusters {
    let sizes = size_distribution(engine.gas());
    let (mut monomers, mut squares) = (0.0, 0.0);
    for &(size, count) in &sizes {
        monomers += f64::from(size) * count as f64;
        squares += f64::from(size) * f64::from(size) * count as f64;
    }
    record::Clusters {
        single: sizes
            .first()
            .filter(|&&(size, _)| size == 1)
            .map_or(0, |&(_, count)| count),
        largest: sizes.last().map_or(0, |&(size, _)| size),
        mean_by_mass: squares / f64::max(monomers, 1.0),
        ledger: engine.contacts().ledger,
        heated,
    }
}

/// An engine at its start, and the velocities that it starts with where they are needed later.
type Begun<E, V> = Result<(E, Option<Vec<V>>), RunError>;

/// What is saved of a replica.
type Kept<P, S, M, C> = Progress<Checkpoint<P, S, M, C>, VectorOf<P>>;

/// One replica that is followed through its schedule.
struct Follow<'a, P, B> {
    replica: &'a Replica<'a>,
    schedule: Vec<Moment>,
    begin: B,
    scene: P,
}

impl<P: Grains, B> Follow<'_, P, B> {
    fn run<S: Selection<P>, M: Motion<P>, C: Contacts<P>>(
        self,
        measure: impl Fn(&Engine<P, S, M, C>, Option<&[VectorOf<P>]>, &Moment, &mut Record),
    ) -> Result<Finished, RunError>
    where
        B: FnOnce() -> Begun<Engine<P, S, M, C>, VectorOf<P>>,
    {
        let Replica {
            plan,
            place,
            number,
            progress,
        } = self.replica;
        let seconds = plan.case.run.checkpoint_seconds;
        let control: Control<'_, Kept<P, S, M, C>> =
            Control::new(*place, *number, "gas", seconds, progress);
        let streams = self.replica.streams();
        let (mut engine, start, mut next, mut finished) = match control.load()? {
            Some(Progress {
                engine: None,
                finished,
                ..
            }) => {
                control.tell(1.0, 0);
                return Ok(finished);
            }
            Some(Progress {
                engine: Some(checkpoint),
                start,
                next,
                finished,
            }) => (
                Engine::resume(self.scene, checkpoint, streams),
                start,
                next,
                finished,
            ),
            None => {
                let (engine, start) = (self.begin)()?;
                let nothing = Finished {
                    record: Record::default(),
                    tally: Tally::default(),
                    bytes: 0,
                    seconds: 0.0,
                };
                (engine, start, 0, nothing)
            }
        };
        let energy = engine_energy(plan);
        let mut began = Instant::now();
        let leg = ((LEG * engine.gas().count() as f64) as u64).max(LEAST_LEG);
        while let Some(moment) = self.schedule.get(next) {
            let before = engine.tally().collisions;
            let until = moment.time * plan.time;
            engine.advance(until, leg, &mut ())?;
            let collisions = engine.tally().collisions - before;
            if engine.time() >= until {
                if moment.asks(Due::Heating) {
                    let now = engine.gas().kinetic_energy();
                    // A gas of one cluster at rest cannot be heated.
                    if now > 0.0 {
                        engine.scale_velocities((energy / now).sqrt())?;
                        finished.record.heated += energy - now;
                    }
                }
                measure(&engine, start.as_deref(), moment, &mut finished.record);
                next += 1;
            }
            control.tell(share(plan, engine.time()), collisions);
            finished.tally = *engine.tally();
            finished.bytes = finished.bytes.max(engine.bytes());
            finished.seconds += began.elapsed().as_secs_f64();
            began = Instant::now();
            if next < self.schedule.len() {
                control.pause_with(|| Progress {
                    engine: Some(engine.checkpoint()),
                    start: start.clone(),
                    next,
                    finished: finished.clone(),
                })?;
            }
        }
        control.save(&Progress {
            engine: None,
            start: None,
            next,
            finished: finished.clone(),
        })?;
        control.tell(1.0, 0);
        Ok(finished)
    }
}

/// Kinetic energy of the start.
fn engine_energy(plan: &Plan) -> f64 {
    let groups = plan.groups.iter();
    let twice: f64 = groups
        .map(|group| group.count as f64 * group.temperature)
        .sum();
    0.5 * plan.case.dimension as f64 * twice
}

/// The share of a run that is done: collisions grow about as the logarithm of time in a gas that cools.
fn share(plan: &Plan, time: f64) -> f64 {
    let unit = plan.haff_time.min(1e3 * plan.case.run.until * plan.time);
    (time / unit).ln_1p() / (plan.case.run.until * plan.time / unit).ln_1p()
}
