//! Domain-decomposed DSMC gas behind the common interface `Simulation`: one gas, several processes.
//!
//! The root process drives the gas ([`simulate_distributed`]); the others serve it ([`serve_domain`]). While the
//! gas advances each process holds its part. Reductions over particles ([`Simulation::reduce_particles`]) and
//! checkpoints involve all processes. Any other access to the particles, and kicks, gather all
//! simulators in the root process.

use std::path::Path;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};
use stosszahl_model::snapshot::Fingerprint;
use stosszahl_model::sum::{ReductionFactory, Totals};
use stosszahl_model::{
    BoundaryFlux, Budget, DynReduction, Failure, Interrupt, InvalidValue, Observer, Particle,
    ParticleModel, Particles, Simulation, Vector as _, WorkCounters,
};

use super::begin::{CellGas, CheckpointSource, Keep, Pending, StartSource, begin};
use super::cells::{CellSimulation, CheckpointContent};
use super::others::{Others, RootCommand};
use crate::decomposition::{
    Ranks, ShardLocation, all_gather, all_reduce, broadcast, from_bytes, reduce, to_bytes,
};
use crate::features::PROCESSES;
use crate::parameters::DsmcError;
use crate::particle::DisplacementTracking;
use crate::start_stream::StartStream;

/// Start of a decomposed gas.
#[derive(Clone, Copy)]
pub enum DomainStart<'a> {
    /// States that the root process holds, and sends to the others in parts.
    States(&'a [Particles]),
    /// Stream of particles of which each process keeps its own.
    Stream(&'a dyn StartStream),
}

/// Starts a gas that is decomposed over several processes. The root process calls it; the other
/// processes call [`serve_domain`].
///
/// # Errors
/// As [`super::simulate`]; if another process cannot hold its part; and
/// [`DsmcError::OneProcess`].
pub fn simulate_distributed(
    gas: &CellGas<'_>,
    start: DomainStart<'_>,
    ranks: &Arc<dyn Ranks>,
) -> Result<Box<dyn Simulation>, DsmcError> {
    let source = match start {
        DomainStart::States(states) => StartSource::Start(states),
        DomainStart::Stream(stream) => StartSource::Stream(stream),
    };
    lead(gas, source, ranks)
}

/// Resumes a gas from a checkpoint, decomposed over several processes. The root process calls it;
/// the other processes call [`serve_domain`]. The checkpoint may come from any number of processes;
/// each process reads its part of a sharded checkpoint.
///
/// # Errors
/// As [`super::resume`]; if another process cannot hold its part; and [`DsmcError::OneProcess`].
pub fn resume_distributed(
    gas: &CellGas<'_>,
    left: CheckpointSource<'_>,
    ranks: &Arc<dyn Ranks>,
) -> Result<Box<dyn Simulation>, DsmcError> {
    lead(gas, StartSource::Checkpoint(left), ranks)
}

fn lead(
    gas: &CellGas<'_>,
    source: StartSource<'_>,
    ranks: &Arc<dyn Ranks>,
) -> Result<Box<dyn Simulation>, DsmcError> {
    if !PROCESSES {
        return Err(DsmcError::OneProcess);
    }
    let led = if let Some(rate) = gas.grains.shear_rate {
        let allowed = "no shear flow where several processes hold one gas";
        Err(InvalidValue::new("shear rate", rate, allowed).into())
    } else if gas.boundaries.weights.follows() {
        Err(DsmcError::BadWeights {
            found: "weights that follow the number".into(),
            allowed: "weights of given factors, where several processes hold one gas",
        })
    } else {
        begin(gas, source, &Lead(ranks.clone()))
    };
    let header = led.as_ref().ok().map(|led| &led.header);
    broadcast(&**ranks, to_bytes(&header));
    let led = led?;
    share_errors(&**ranks, Ok(()))?;
    (led.gas)()
}

/// Exchanges errors between all processes: returns the error of this process, else that of the
/// first process with one.
fn share_errors(ranks: &dyn Ranks, mine: Result<(), DsmcError>) -> Result<(), DsmcError> {
    let why = mine.as_ref().err().map(ToString::to_string);
    let all = all_gather(ranks, to_bytes(&why));
    mine?;
    let mut all = all
        .iter()
        .map(|bytes| from_bytes::<Option<String>>(bytes))
        .enumerate();
    match all.find_map(|(rank, why)| Some(DsmcError::Elsewhere { rank, why: why? })) {
        Some(error) => Err(error),
        None => Ok(()),
    }
}

/// Serves a part of a gas that the root process drives, until the root process drops the gas. All
/// arguments but the start must equal those of the root process; the gas starts with `count`
/// particles in a box of sides `lengths`. `make` creates the reductions that the root process asks
/// for.
///
/// # Errors
/// [`DsmcError`] if the gas cannot start in this or another process; [`DsmcError::OneProcess`]
/// without the feature `processes`.
///
/// # Panics
/// If the root process asks for a sum that `make` does not know.
pub fn serve_domain(
    gas: &CellGas<'_>,
    count: usize,
    lengths: [f64; 3],
    start: Option<&dyn StartStream>,
    ranks: &Arc<dyn Ranks>,
    interrupt: &Interrupt,
    make: ReductionFactory,
) -> Result<(), DsmcError> {
    if !PROCESSES {
        return Err(DsmcError::OneProcess);
    }
    let Some(header) = from_bytes::<Option<GasHeader>>(&broadcast(&**ranks, Vec::new())) else {
        // The root process could not start the gas and reports why.
        return Ok(());
    };
    let source = StartSource::Checkpoint(CheckpointSource {
        count,
        lengths,
        checkpoint: &header.kept,
        beside: header.beside.as_ref(),
    });
    let served = match start.filter(|_| header.is_streamed) {
        None if header.is_streamed => Err(DsmcError::Start {
            why: "the start of the root process is not known here".into(),
        }),
        start => begin(
            gas,
            source,
            &Serve(ranks.clone(), interrupt.clone(), make, start),
        ),
    };
    match served {
        Ok(served) => {
            share_errors(&**ranks, Ok(()))?;
            served()
        }
        Err(error) => share_errors(&**ranks, Err(error)),
    }
}

/// Factory of the gas in the root process, which drives the engines of all processes.
struct Lead(Arc<dyn Ranks>);

/// Gas of the root process, and the data that the other processes need.
struct Led<'a> {
    gas: Box<dyn FnOnce() -> Result<Box<dyn Simulation>, DsmcError> + 'a>,
    header: GasHeader,
}

/// Checkpoint of a gas without its simulators, and where these come from.
#[derive(Serialize, Deserialize)]
struct GasHeader {
    kept: Vec<u8>,
    /// Location of the shards; `None` if there are none.
    beside: Option<ShardLocation>,
    /// True if each process makes its simulators from the stream of the start.
    is_streamed: bool,
}

impl<'a> Keep<'a> for Lead {
    type Kept = Led<'a>;
    const SHARES: bool = true;
    fn keep_engine<P: ParticleModel, F: DisplacementTracking<P::Space>>(
        &self,
        mut cells: CellSimulation<P, F>,
        pending: Pending<'a>,
    ) -> Result<Led<'a>, DsmcError> {
        let (shards, beside) = match &pending {
            Pending::Shards(list, beside) => (list.clone(), Some(beside.clone())),
            Pending::None | Pending::Start(_) => (Vec::new(), None),
        };
        let kept = to_bytes(&CheckpointContent {
            gas: cells.engine.without_simulators(),
            follows: cells.follows,
            shards,
        });
        let is_streamed = matches!(pending, Pending::Start(_));
        let ranks = self.0.clone();
        let gas = move || -> Result<Box<dyn Simulation>, DsmcError> {
            begin_among(&mut cells, &ranks, pending)?;
            cells.others = Some(Others(ranks.clone()));
            Ok(Box::new(Among {
                cells: Mutex::new(cells),
                ranks,
            }))
        };
        Ok(Led {
            gas: Box::new(gas),
            header: GasHeader {
                kept,
                beside,
                is_streamed,
            },
        })
    }
}

/// Declares that the processes `ranks` hold a new gas together; each reads its own tiles from a
/// sharded checkpoint.
fn begin_among<P: ParticleModel, F: DisplacementTracking<P::Space>>(
    cells: &mut CellSimulation<P, F>,
    ranks: &Arc<dyn Ranks>,
    pending: Pending<'_>,
) -> Result<(), DsmcError> {
    let engine = &mut cells.engine;
    engine.distribute_among(ranks.clone());
    match pending {
        Pending::None => Ok(()),
        Pending::Shards(list, beside) => {
            let read = engine.read_shards(&list, &beside);
            share_errors(&**ranks, read)
        }
        Pending::Start(start) => {
            let own = match engine.start_parts(start) {
                Ok(own) => share_errors(&**ranks, Ok(())).map(|()| own)?,
                Err(error) => return share_errors(&**ranks, Err(error)),
            };
            engine.unite_step_bounds(own)
        }
    }
}

/// Computes the sum of squared displacements over the simulators of all processes. All processes
/// must call it.
fn all_ways<P: ParticleModel, F: DisplacementTracking<P::Space>>(
    ranks: &dyn Ranks,
    cells: &CellSimulation<P, F>,
) -> Totals {
    all_reduce(ranks, cells.squared_ways(), |sum, more| sum.merge(&more))
}

/// Reduces a sum over the particles of all processes to the root process; with neighbours up to the
/// distance `reach`, if given \[length\]. All processes must call it.
fn add_all<P: ParticleModel, F: DisplacementTracking<P::Space>>(
    cells: &CellSimulation<P, F>,
    reach: Option<f64>,
    sum: &mut dyn DynReduction,
    ranks: &dyn Ranks,
) {
    match reach {
        Some(reach) => add_strip(cells, reach, sum, ranks),
        None => cells.reduce_particles(sum),
    }
    reduce(ranks, sum);
}

/// Distributes all positions by equal strips of the first axis, one for each process, and adds the
/// simulators in and near the strip of this process to a sum. All processes must call it.
fn add_strip<P: ParticleModel, F: DisplacementTracking<P::Space>>(
    cells: &CellSimulation<P, F>,
    reach: f64,
    sum: &mut dyn DynReduction,
    ranks: &dyn Ranks,
) {
    let (me, size) = (ranks.rank(), ranks.size());
    let length = cells.engine.grid().domain().lengths().spatial().x;
    let width = length / size as f64;
    // Slightly more, for rounding.
    let far = (0.5 * width + reach) * (1.0 + 1e-9);
    let is_near = |x: f64, strip: usize| {
        let apart = (x - (strip as f64 + 0.5) * width).abs();
        apart.min(length - apart) <= far
    };
    let wide = ((far / width) as usize + 1).min(size / 2);
    // Runs of equal weight; those near the strip come first.
    let mut strips: Vec<Vec<(f64, Vec<Vector3<f64>>)>> = vec![vec![(0.0, Vec::new())]; size];
    for tile in cells.engine.tiles_here() {
        cells.engine.each_in(tile, |simulator, weight| {
            let position = simulator.position.spatial();
            let own = ((position.x / width).max(0.0) as usize).min(size - 1);
            match strips[own].last_mut() {
                Some((same, run)) if *same == weight => run.push(position),
                _ => strips[own].push((weight, vec![position])),
            }
            for step in 1..=wide {
                let [left, right] = [(own + size - step) % size, (own + step) % size];
                if is_near(position.x, left) {
                    strips[left][0].1.push(position);
                }
                if right != left && is_near(position.x, right) {
                    strips[right][0].1.push(position);
                }
            }
        });
    }
    let own = std::mem::take(&mut strips[me]);
    let others: Vec<usize> = (0..size).filter(|&rank| rank != me).collect();
    let messages = others.iter().map(|&rank| (rank, to_bytes(&strips[rank])));
    let came = ranks.exchange(messages.collect(), &others);
    let came = came
        .iter()
        .flat_map(|bytes| from_bytes::<Vec<(f64, Vec<Vector3<f64>>)>>(bytes));
    for (weight, run) in own.into_iter().chain(came) {
        for position in run {
            sum.add_particle(&Particle {
                position,
                weight,
                ..Particle::at_rest(0.0, 0.0)
            });
        }
    }
    sum.close_group(me as u32);
}

/// Worker process: executes the commands of the root process.
struct Serve<'a>(
    Arc<dyn Ranks>,
    Interrupt,
    ReductionFactory,
    Option<&'a dyn StartStream>,
);

impl<'a> Keep<'a> for Serve<'a> {
    type Kept = Box<dyn FnOnce() -> Result<(), DsmcError> + 'a>;
    const SHARES: bool = true;
    fn keep_engine<P: ParticleModel, F: DisplacementTracking<P::Space>>(
        &self,
        mut cells: CellSimulation<P, F>,
        pending: Pending<'a>,
    ) -> Result<Self::Kept, DsmcError> {
        let Self(ranks, interrupt, make, start) = self;
        let (ranks, make) = (ranks.clone(), *make);
        // The checkpoint of a gas that starts from a stream has no simulators.
        let pending = start.map_or(pending, Pending::Start);
        cells.engine.set_stop_flag(interrupt);
        Ok(Box::new(move || {
            begin_among(&mut cells, &ranks, pending)?;
            loop {
                let engine = &mut cells.engine;
                match from_bytes(&broadcast(&*ranks, Vec::new())) {
                    RootCommand::Advance(until, steps, true) => {
                        engine.advance(until, steps, &mut Looks);
                    }
                    RootCommand::Advance(until, steps, false) => {
                        engine.advance(until, steps, &mut ());
                    }
                    RootCommand::Unite => engine.gather_tiles(),
                    RootCommand::AddUp(reach, name, empty) => {
                        let sum = make(&name, &empty);
                        let mut sum = sum.expect("a sum that this program makes");
                        add_all(&cells, reach, &mut *sum, &*ranks);
                    }
                    RootCommand::DisplacementTracking => {
                        cells.track_displacements();
                    }
                    RootCommand::Ways => {
                        all_ways(&*ranks, &cells);
                    }
                    RootCommand::Write(stem, beside) => {
                        // The root process reports errors of this process.
                        let _ = engine.write_shards(&stem, &beside);
                    }
                    RootCommand::End => return Ok(()),
                }
            }
        }))
    }
}

/// Observer in a process other than the root. It ignores collisions, but makes the engine log them,
/// so that the root process can merge and show them.
struct Looks;

impl Observer for Looks {
    fn on_collisions(&mut self, _batch: &[stosszahl_model::Collision]) {}
}

/// Domain-decomposed gas in the root process, as a [`Simulation`].
struct Among<P: ParticleModel, F: DisplacementTracking<P::Space>> {
    /// Engine of the root process, behind a lock because read access may gather all tiles.
    cells: Mutex<CellSimulation<P, F>>,
    ranks: Arc<dyn Ranks>,
}

impl<P: ParticleModel, F: DisplacementTracking<P::Space>> Among<P, F> {
    /// Locks the engine without gathering tiles, for data that the root process always has.
    fn part(&self) -> MutexGuard<'_, CellSimulation<P, F>> {
        self.cells.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Commands all processes to reduce a sum over particles, and adds up their results.
    fn add_by_all(&self, reach: Option<f64>, sum: &mut dyn DynReduction) {
        RootCommand::AddUp(reach, sum.kind_name().to_owned(), sum.save_bytes()).give(&*self.ranks);
        add_all(&self.part(), reach, sum, &*self.ranks);
    }

    /// Locks the engine after all simulators were gathered in the root process.
    fn whole(&self) -> MutexGuard<'_, CellSimulation<P, F>> {
        let mut cells = self.part();
        if !cells.engine.is_whole() {
            RootCommand::Unite.give(&*self.ranks);
            cells.engine.gather_tiles();
        }
        cells
    }
}

impl<P: ParticleModel, F: DisplacementTracking<P::Space>> Drop for Among<P, F> {
    fn drop(&mut self) {
        RootCommand::End.give(&*self.ranks);
    }
}

impl<P: ParticleModel, F: DisplacementTracking<P::Space>> Simulation for Among<P, F> {
    fn time(&self) -> f64 {
        self.part().time()
    }

    fn dimension(&self) -> usize {
        self.part().dimension()
    }

    fn particle_count(&self) -> usize {
        self.part().particle_count()
    }

    fn mean_weight(&self) -> f64 {
        self.part().mean_weight()
    }

    fn advance(
        &mut self,
        until: f64,
        budget: Budget,
        observer: &mut dyn Observer,
    ) -> Result<bool, Failure> {
        self.part().advance(until, budget, observer)
    }

    fn set_stop_flag(&mut self, interrupt: &Interrupt) {
        self.part().set_stop_flag(interrupt);
    }

    fn set_pause_flag(&mut self, pause: &Interrupt) {
        self.part().set_pause_flag(pause);
    }

    fn is_interrupted(&self) -> bool {
        self.part().is_interrupted()
    }

    fn visit_particles(&self, look: &mut dyn FnMut(&Particle)) {
        self.whole().visit_particles(look);
    }

    fn reduce_particles(&self, sum: &mut dyn DynReduction) {
        self.add_by_all(None, sum);
    }

    fn reduce_neighbourhoods(&self, reach: f64, sum: &mut dyn DynReduction) {
        self.add_by_all(Some(reach), sum);
    }

    fn particles(&self) -> Particles {
        self.whole().particles()
    }

    fn add_velocities(&mut self, changes: &[Vector3<f64>]) -> Result<(), Failure> {
        self.whole().add_velocities(changes)
    }

    fn scale_velocities(&mut self, factor: f64) -> Result<(), Failure> {
        self.whole().scale_velocities(factor)
    }

    fn save_checkpoint(&self) -> Result<Vec<u8>, Failure> {
        self.whole().save_checkpoint()
    }

    fn checkpoint_in_shards(
        &self,
        stem: &Path,
        run: &Fingerprint,
    ) -> Result<Option<Vec<u8>>, Failure> {
        // Other processes may run in other folders.
        let stem = std::path::absolute(stem).map_err(Failure::new)?;
        let name = stem.file_name().unwrap_or_default().to_string_lossy();
        let beside = ShardLocation {
            folder: stem.parent().unwrap_or(&stem).to_owned(),
            run: *run,
        };
        let mut cells = self.part();
        RootCommand::Write(name.to_string(), beside.clone()).give(&*self.ranks);
        let shards = cells.engine.write_shards(&name, &beside);
        let kept = CheckpointContent {
            gas: cells.engine.without_simulators(),
            follows: cells.follows,
            shards: shards.map_err(Failure::new)?,
        };
        postcard::to_stdvec(&kept).map(Some).map_err(Failure::new)
    }

    fn work_counters(&self) -> WorkCounters {
        self.part().work_counters()
    }

    fn memory_bytes(&self) -> usize {
        self.part().memory_bytes()
    }

    fn track_displacements(&mut self) -> bool {
        RootCommand::DisplacementTracking.give(&*self.ranks);
        self.part().track_displacements()
    }

    fn displacements(&self) -> Option<Vec<Vector3<f64>>> {
        self.whole().displacements()
    }

    fn mean_squared_displacement(&self) -> Option<f64> {
        let cells = self.part();
        if !cells.follows {
            return None;
        }
        RootCommand::Ways.give(&*self.ranks);
        let squares = all_ways(&*self.ranks, &cells);
        cells.mean_of(&squares)
    }

    fn boundary_fluxes(&self) -> Vec<BoundaryFlux> {
        self.part().boundary_fluxes()
    }
}
