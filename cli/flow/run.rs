//! Runs all replicas of a flow, with checkpoints, to the same bytes wherever it is stopped.

use std::collections::BTreeMap;
use std::fs;
use std::time::Instant;

use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use stosszahl_analysis::fields::Fields;
use stosszahl_dsmc::{Boundaries, Clearance, Inflow, Weights};
use stosszahl_ed::Dissipation;
use stosszahl_model::random::Streams;
use stosszahl_model::walls::Obstacle;
use stosszahl_model::{Physics, Plane, Space, Volume};

use super::FlowError;
use super::case::{Along, MonteCarlo};
use super::gas::{Chance, Exact, Gas, Ledger};
use super::obstacles;
use super::plan::Plan;
use super::scene::{Visit, with_scene};
use super::start::{self, Room};
use crate::progress::JobProgress;
use crate::run::{CHECKPOINTS, Control, Place, RunError};

/// The whole gas at one time. Energies are sums over all grains.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Sample {
    /// When.
    pub time: f64,
    /// Pair collisions so far, times what each stands for.
    pub collisions: f64,
    /// Energy in the field, sum of -m a . r.
    pub potential: f64,
    /// By species.
    pub species: Vec<Share>,
}

/// What one species has of the gas.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Share {
    /// Number of grains.
    pub number: f64,
    /// Mass.
    pub mass: f64,
    /// Momentum.
    pub momentum: [f64; 3],
    /// Sum of m v^2/2.
    pub translation: f64,
    /// Sum of I w^2/2.
    pub rotation: f64,
}

/// What was measured in one run.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Record {
    /// The course of the whole gas.
    pub series: Vec<Sample>,
    /// Fields in blocks of time.
    pub fields: Fields,
    /// What boundaries gave until the end of each block.
    pub ledgers: Vec<Ledger>,
    /// Work of the engine, in numbers that do not depend on the machine.
    pub work: BTreeMap<String, f64>,
    /// Pair collisions of simulators.
    pub collisions: u64,
    /// Computing time \[s\].
    pub seconds: f64,
}

/// One replica: its engines, in the order of the plan.
#[derive(Clone, Debug)]
pub struct Replica {
    /// Records of the engines.
    pub engines: Vec<Record>,
}

/// Runs all replicas on the current thread pool; continues from checkpoints where there are some.
///
/// # Errors
/// [`RunError`]; checkpoints stay.
pub fn run(plan: &Plan, place: Place<'_>) -> Result<Vec<Replica>, RunError> {
    let path = place.folder.join(CHECKPOINTS);
    fs::create_dir_all(&path).map_err(|source| RunError::Folder { path, source })?;
    with_scene(plan, AllReplicas { plan, place })
}

struct AllReplicas<'a> {
    plan: &'a Plan,
    place: Place<'a>,
}

impl Visit for AllReplicas<'_> {
    type Output = Result<Vec<Replica>, RunError>;

    fn plane<P: Physics<Space = Plane>>(self, scene: P) -> Self::Output {
        self.all(|job| job.in_plane(&scene))
    }

    fn space<P: Physics<Space = Volume>>(self, scene: P) -> Self::Output {
        self.all(|job| job.in_space(&scene))
    }
}

impl AllReplicas<'_> {
    fn all(
        &self,
        one: impl Fn(&Job<'_>) -> Result<Record, RunError> + Sync,
    ) -> Result<Vec<Replica>, RunError> {
        let names = self.plan.engines();
        let replicas = self.plan.flow.replicas as usize;
        let jobs = self.place.progress.jobs(replicas * names.len());
        (0..replicas)
            .into_par_iter()
            .map(|replica| {
                let engines = names
                    .par_iter()
                    .zip(&jobs[replica * names.len()..])
                    .map(|(&engine, progress)| {
                        let job = Job {
                            plan: self.plan,
                            place: self.place,
                            replica,
                            engine,
                            progress,
                        };
                        one(&job).map_err(|source| RunError::Replica {
                            replica,
                            part: engine.to_owned(),
                            source: Box::new(source),
                        })
                    })
                    .collect::<Result<Vec<_>, _>>()?;
                Ok(Replica { engines })
            })
            .collect()
    }
}

/// One engine of one replica.
struct Job<'a> {
    plan: &'a Plan,
    place: Place<'a>,
    replica: usize,
    engine: &'static str,
    progress: &'a JobProgress,
}

/// A job on its way.
#[derive(Serialize, Deserialize)]
struct Progress<C> {
    /// `None` once finished: the record is all that is kept.
    engine: Option<C>,
    /// Samples taken.
    next: u64,
    record: Record,
}

impl Job<'_> {
    fn streams(&self) -> Streams {
        Streams::new(self.plan.flow.seed, self.replica as u64)
    }

    /// Grains keep their distance where exact dynamics needs it; then in both engines, which share the start.
    fn room(&self) -> Room {
        if self.plan.flow.engine.ed.is_some() {
            Room::Grains
        } else {
            Room::Points
        }
    }

    fn in_plane<P: Physics<Space = Plane>>(&self, scene: &P) -> Result<Record, RunError> {
        let obstacles = obstacles::of(&self.plan.flow).map_err(FlowError::from)?;
        let flow = &self.plan.flow;
        let exact = flow.engine.ed.filter(|_| self.engine == "ed");
        let Some(exact) = exact else {
            return self.monte_carlo(scene, obstacles);
        };
        let boundaries = stosszahl_ed::Boundaries {
            walls: self.plan.walls().map_err(FlowError::from)?,
            obstacles,
            streams: self.streams().branch(ED),
        };
        let dissipation = if exact.contact_time > 0.0 {
            Dissipation::ContactTime(exact.contact_time)
        } else {
            Dissipation::Scene
        };
        self.follow(|checkpoint| {
            let gas = match checkpoint {
                Some(gas) => gas,
                None => self
                    .start(0, scene, &boundaries.walls, &boundaries.obstacles)?
                    .into(),
            };
            Ok(Exact {
                scene: scene.clone(),
                dissipation,
                boundaries,
                gas,
            })
        })
    }

    fn in_space<P: Physics<Space = Volume>>(&self, scene: &P) -> Result<Record, RunError> {
        self.monte_carlo(scene, Vec::new())
    }

    /// The start of a set of simulators; that of number 0 is the start of exact dynamics too.
    fn start<P: Physics>(
        &self,
        set: u64,
        scene: &P,
        walls: &stosszahl_model::Walls<P::Space>,
        obstacles: &[Obstacle],
    ) -> Result<stosszahl_model::State<P>, RunError> {
        let streams = match set {
            0 => self.streams(),
            _ => self.streams().branch(SETS).branch(set),
        };
        let state = start::make(self.plan, scene, walls, obstacles, self.room(), &streams);
        Ok(state.map_err(FlowError::from)?)
    }

    fn monte_carlo<P: Physics>(
        &self,
        scene: &P,
        obstacles: Vec<Obstacle>,
    ) -> Result<Record, RunError> {
        let plan = self.plan;
        let flow = &plan.flow;
        let written = flow.engine.dsmc.clone().unwrap_or_default();
        let parameters = plan.parameters(&written);
        let boundaries = Boundaries {
            walls: plan.walls().map_err(FlowError::from)?,
            clearance: if plan.walls_act_on_centres(&written) {
                Clearance::Centre
            } else {
                Clearance::Radius
            },
            inflows: inflows::<P::Space>(plan),
            weights: weights(&written)?,
            obstacles,
        };
        let streams = self.streams().branch(DSMC);
        self.follow(|checkpoint| {
            let engine = if let Some(gas) = checkpoint {
                let size = Plan::vector::<P::Space>(&flow.domain.size);
                let domain = boundaries.walls.domain(size);
                let domain = domain
                    .ok_or(start::StartError::Box)
                    .map_err(FlowError::from)?;
                stosszahl_dsmc::Engine::resume_between(
                    scene,
                    parameters,
                    domain,
                    gas,
                    &boundaries,
                    streams,
                )?
            } else {
                // The first set is the start of exact dynamics; the others are starts of the same gas.
                let sets = (0..written.simulators_per_grain)
                    .map(|set| self.start(set, scene, &boundaries.walls, &boundaries.obstacles))
                    .collect::<Result<Vec<_>, _>>()?;
                stosszahl_dsmc::Engine::start_sets(scene, parameters, &sets, &boundaries, streams)?
            };
            Ok(Chance {
                engine,
                carries: written.scheme.carries(),
            })
        })
    }

    fn follow<G: Gas>(
        &self,
        begin: impl FnOnce(Option<G::Checkpoint>) -> Result<G, RunError>,
    ) -> Result<Record, RunError> {
        let plan = self.plan;
        let run = &plan.flow.run;
        let control: Control<'_, Progress<G::Checkpoint>> = Control::new(
            self.place,
            self.replica,
            self.engine,
            run.checkpoint_seconds,
            self.progress,
        );
        let (mut gas, mut next, mut record) = match control.load()? {
            Some(Progress {
                engine: None,
                record,
                ..
            }) => {
                control.tell(1.0, 0);
                return Ok(record);
            }
            Some(Progress {
                engine,
                next,
                record,
            }) => (begin(engine)?, next, record),
            None => (begin(None)?, 0, self.empty_record()?),
        };
        let per_block = run.samples / run.blocks;
        let mut began = Instant::now();
        let mut lap = || {
            let passed = began.elapsed().as_secs_f64();
            began = Instant::now();
            passed
        };
        if next == 0 {
            let first = sample(plan, &gas, None, &mut record.fields);
            record.series.push(first);
            next = 1;
        }
        while next <= run.samples {
            let before = gas.collisions();
            let until = plan.sample_time(next);
            if gas.leg(until, &mut record.fields)? {
                let block = ((next - 1) / per_block) as usize;
                let taken = sample(plan, &gas, Some(block), &mut record.fields);
                record.series.push(taken);
                if next.is_multiple_of(per_block) {
                    record.ledgers.push(gas.books());
                }
                next += 1;
            }
            let share = gas.time() / run.until;
            control.tell(share, gas.collisions() - before);
            if next <= run.samples {
                record.seconds += lap();
                control.pause_with(|| Progress {
                    engine: Some(gas.checkpoint()),
                    next,
                    record: record.clone(),
                })?;
            }
        }
        record.seconds += lap();
        record.work = gas.work();
        record.collisions = gas.collisions();
        control.save(&Progress {
            engine: None,
            next,
            record: record.clone(),
        })?;
        control.tell(1.0, 0);
        Ok(record)
    }

    fn empty_record(&self) -> Result<Record, RunError> {
        let plan = self.plan;
        let blocks = plan.flow.run.blocks as usize;
        Ok(Record {
            series: Vec::new(),
            fields: Fields::new(plan.grid()?, plan.kinds.len(), blocks, plan.block())?,
            ledgers: Vec::new(),
            work: BTreeMap::new(),
            collisions: 0,
            seconds: 0.0,
        })
    }
}

/// Engines of one replica draw different numbers.
const ED: u64 = 1;
const DSMC: u64 = 2;

/// Sets of simulators begin with different numbers.
const SETS: u64 = 3;

/// Looks at all grains: for the course of the gas and, in a block of time, for the fields.
fn sample<G: Gas>(plan: &Plan, gas: &G, block: Option<usize>, fields: &mut Fields) -> Sample {
    let mut sample = Sample {
        time: gas.time(),
        collisions: gas.collisions() as f64 * gas.weight(),
        potential: 0.0,
        species: vec![Share::default(); plan.kinds.len()],
    };
    if let Some(block) = block {
        fields.begin_sample(block);
    }
    gas.visit(|species, grain, height_energy| {
        let species = species as usize % plan.kinds.len();
        let share = &mut sample.species[species];
        share.number += grain.weight;
        share.mass += grain.weight * grain.mass;
        let mut square = 0.0;
        for (sum, component) in share.momentum.iter_mut().zip(grain.velocity) {
            *sum += grain.weight * grain.mass * component;
            square += component * component;
        }
        share.translation += 0.5 * grain.weight * grain.mass * square;
        share.rotation += 0.5 * grain.weight * grain.twice_spin_energy;
        sample.potential += grain.weight * height_energy;
        if let Some(block) = block {
            fields.add(block, species, grain);
        }
    });
    sample
}

/// The streams that flow in.
fn inflows<S: Space>(plan: &Plan) -> Vec<Inflow<S>> {
    let flow = &plan.flow;
    // The first grain of each species in the order of the state.
    let firsts: Vec<usize> = (0..plan.kinds.len())
        .map(|species| plan.kinds[..species].iter().map(|kind| kind.count).sum())
        .collect();
    let one = |inflow: &super::case::Inflow, species: usize| {
        let (axis, side) = inflow.face.place();
        let uniform = plan.kinds[species].count as f64 / plan.volume;
        let temperature = inflow.temperature.unwrap_or(flow.start.temperature);
        Inflow {
            axis,
            side,
            density: (inflow.number_density.as_ref())
                .map_or(uniform, |densities| densities[species]),
            velocity: Plan::vector::<S>(&inflow.velocity),
            temperature,
            spin_temperature: inflow.spin_temperature.unwrap_or(temperature),
            like: firsts[species],
        }
    };
    flow.inflow
        .iter()
        .flat_map(|inflow| (0..plan.kinds.len()).map(move |species| one(inflow, species)))
        .collect()
}

/// The weights of regions.
fn weights(dsmc: &MonteCarlo) -> Result<Weights, RunError> {
    Ok(match &dsmc.weights {
        None => Weights::uniform(),
        Some(weights) => {
            let axis = usize::from(weights.along == Along::Y);
            Weights::along(axis, weights.factors.clone())?
        }
    })
}
