//! A gas that several processes hold, behind the common interface.
//!
//! The first process drives the gas as any other ([`simulate_among`]); the others do what it does ([`serve`]). While the gas
//! advances each holds its part. Sums over particles are made by all
//! ([`Simulation::add_up`]), and checkpoints written by all. Whoever looks at particles in another way or kicks them makes the first
//! process gather all.

use std::path::Path;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};
use stosszahl_model::snapshot::Fingerprint;
use stosszahl_model::sum::{Make, Totals};
use stosszahl_model::{
    BoundaryFlux, Budget, Failure, Interrupt, Invalid, Observer, Particle, Particles, Physics,
    Simulation, Sum, Vector as _, Work,
};

use super::begin::{Gas, Keep, Left, Shards, Source, begin};
use super::cells::{Cells, Kept};
use super::others::{Command, Others};
use crate::decomposition::{Beside, Ranks, all_gather, all_reduce, broadcast, read, reduce, write};
use crate::features::PROCESSES;
use crate::parameters::EngineError;
use crate::particle::Follow;

/// [`super::simulate`] of a gas that all of these processes hold. This is the first of them; the others [`serve`].
///
/// # Errors
/// As [`super::simulate`]; if another process cannot hold its part; and [`EngineError::OneProcess`].
pub fn simulate_among(
    gas: &Gas<'_>,
    starts: &[Particles],
    ranks: &Arc<dyn Ranks>,
) -> Result<Box<dyn Simulation>, EngineError> {
    lead(gas, Source::Start(starts), ranks)
}

/// [`super::resume`] of a gas that all of these processes hold. This is the first of them; the others [`serve`]. The checkpoint is
/// that of a gas in any number of processes; each reads its part of one in shards.
///
/// # Errors
/// As [`super::resume`]; if another process cannot hold its part; and [`EngineError::OneProcess`].
pub fn resume_among(
    gas: &Gas<'_>,
    left: Left<'_>,
    ranks: &Arc<dyn Ranks>,
) -> Result<Box<dyn Simulation>, EngineError> {
    lead(gas, Source::Checkpoint(left), ranks)
}

fn lead(
    gas: &Gas<'_>,
    source: Source<'_>,
    ranks: &Arc<dyn Ranks>,
) -> Result<Box<dyn Simulation>, EngineError> {
    if !PROCESSES {
        return Err(EngineError::OneProcess);
    }
    let led = if let Some(rate) = gas.grains.shear_rate {
        let allowed = "no shear flow where several processes hold one gas";
        Err(Invalid::new("shear rate", rate, allowed).into())
    } else if gas.boundaries.weights.follows() {
        Err(EngineError::BadWeights {
            found: "weights that follow the number".into(),
            allowed: "weights of given factors, where several processes hold one gas",
        })
    } else {
        begin(gas, source, &Lead(ranks.clone()))
    };
    let brief = led.as_ref().ok().map(|led| &led.brief);
    broadcast(&**ranks, write(&brief));
    let led = led?;
    agree(&**ranks, Ok(()))?;
    (led.gas)()
}

/// Whether all processes can go on; what hinders this one, or the first that something hinders.
fn agree(ranks: &dyn Ranks, mine: Result<(), EngineError>) -> Result<(), EngineError> {
    let why = mine.as_ref().err().map(ToString::to_string);
    let all = all_gather(ranks, write(&why));
    mine?;
    let mut all = all
        .iter()
        .map(|bytes| read::<Option<String>>(bytes))
        .enumerate();
    match all.find_map(|(rank, why)| Some(EngineError::Elsewhere { rank, why: why? })) {
        Some(error) => Err(error),
        None => Ok(()),
    }
}

/// Holds a part of a gas that another process drives, with everything but the start as there, until that lets go of it. The gas
/// started with `count` particles in a box of these sides. `make` knows all sums that the first process asks for.
///
/// # Errors
/// [`EngineError`] if it cannot be made here or elsewhere; [`EngineError::OneProcess`] without the feature `processes`.
///
/// # Panics
/// If the first process asks for a sum that `make` does not know.
pub fn serve(
    gas: &Gas<'_>,
    count: usize,
    lengths: [f64; 3],
    ranks: &Arc<dyn Ranks>,
    interrupt: &Interrupt,
    make: Make,
) -> Result<(), EngineError> {
    if !PROCESSES {
        return Err(EngineError::OneProcess);
    }
    let Some(brief) = read::<Option<Brief>>(&broadcast(&**ranks, Vec::new())) else {
        // It could not be made there, which is said there.
        return Ok(());
    };
    let source = Source::Checkpoint(Left {
        count,
        lengths,
        checkpoint: &brief.kept,
        beside: brief.beside.as_ref(),
    });
    match begin(gas, source, &Serve(ranks.clone(), interrupt.clone(), make)) {
        Ok(served) => {
            agree(&**ranks, Ok(()))?;
            served()
        }
        Err(error) => agree(&**ranks, Err(error)),
    }
}

/// The first process keeps an engine that others help with.
struct Lead(Arc<dyn Ranks>);

/// What it begins with, and what others must know.
struct Led {
    gas: Box<dyn FnOnce() -> Result<Box<dyn Simulation>, EngineError>>,
    brief: Brief,
}

/// A gas without its simulators, and where they are if they are in shards.
#[derive(Serialize, Deserialize)]
struct Brief {
    kept: Vec<u8>,
    beside: Option<Beside>,
}

impl Keep for Lead {
    type Kept = Led;
    const SHARES: bool = true;
    fn keep<P: Physics, F: Follow<P::Space>>(&self, mut cells: Cells<P, F>, shards: Shards) -> Led {
        let kept = write(&Kept {
            gas: cells.engine.without_simulators(),
            follows: cells.follows,
            shards: shards.as_ref().map_or_else(Vec::new, |all| all.0.clone()),
        });
        let beside = shards.as_ref().map(|all| all.1.clone());
        let ranks = self.0.clone();
        let gas = move || -> Result<Box<dyn Simulation>, EngineError> {
            begin_among(&mut cells, &ranks, shards)?;
            cells.others = Some(Others(ranks.clone()));
            Ok(Box::new(Among {
                cells: Mutex::new(cells),
                ranks,
            }))
        };
        Led {
            gas: Box::new(gas),
            brief: Brief { kept, beside },
        }
    }
}

/// From now on several processes hold the gas; of one in shards each reads its part.
fn begin_among<P: Physics, F: Follow<P::Space>>(
    cells: &mut Cells<P, F>,
    ranks: &Arc<dyn Ranks>,
    shards: Shards,
) -> Result<(), EngineError> {
    cells.engine.share(ranks.clone());
    let Some((list, beside)) = shards else {
        return Ok(());
    };
    let read = cells.engine.read_shards(&list, &beside);
    agree(&**ranks, read)
}

/// Squared displacements in all processes.
fn all_ways<P: Physics, F: Follow<P::Space>>(ranks: &dyn Ranks, cells: &Cells<P, F>) -> Totals {
    all_reduce(ranks, cells.squared_ways(), |sum, more| sum.merge(&more))
}

/// Adds what all processes hold to a sum of the first, with neighbours up to a distance, if there is one.
fn add_all<P: Physics, F: Follow<P::Space>>(
    cells: &Cells<P, F>,
    reach: Option<f64>,
    sum: &mut dyn Sum,
    ranks: &dyn Ranks,
) {
    match reach {
        Some(reach) => add_strip(cells, reach, sum, ranks),
        None => cells.add_up(sum),
    }
    reduce(ranks, sum);
}

/// Deals out positions by equal strips of the first axis, one for each process, and adds those of the own strip and near it to a sum.
fn add_strip<P: Physics, F: Follow<P::Space>>(
    cells: &Cells<P, F>,
    reach: f64,
    sum: &mut dyn Sum,
    ranks: &dyn Ranks,
) {
    let (me, size) = (ranks.rank(), ranks.size());
    let length = cells.engine.grid().domain().lengths().spatial().x;
    let width = length / size as f64;
    // A little more, for rounding.
    let far = (0.5 * width + reach) * (1.0 + 1e-9);
    let is_near = |x: f64, strip: usize| {
        let apart = (x - (strip as f64 + 0.5) * width).abs();
        apart.min(length - apart) <= far
    };
    let wide = ((far / width) as usize + 1).min(size / 2);
    // Runs of equal weight, of which the first are near.
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
    let messages = others.iter().map(|&rank| (rank, write(&strips[rank])));
    let came = ranks.exchange(messages.collect(), &others);
    let came = came
        .iter()
        .flat_map(|bytes| read::<Vec<(f64, Vec<Vector3<f64>>)>>(bytes));
    for (weight, run) in own.into_iter().chain(came) {
        for position in run {
            sum.add(&Particle {
                position,
                weight,
                ..Particle::of(0.0, 0.0)
            });
        }
    }
    sum.close(me as u32);
}

/// Another process does as it is told.
struct Serve(Arc<dyn Ranks>, Interrupt, Make);

impl Keep for Serve {
    type Kept = Box<dyn FnOnce() -> Result<(), EngineError>>;
    const SHARES: bool = true;
    fn keep<P: Physics, F: Follow<P::Space>>(
        &self,
        mut cells: Cells<P, F>,
        shards: Shards,
    ) -> Self::Kept {
        let Self(ranks, interrupt, make) = self;
        let (ranks, make) = (ranks.clone(), *make);
        cells.engine.stop_on(interrupt);
        Box::new(move || {
            begin_among(&mut cells, &ranks, shards)?;
            loop {
                let engine = &mut cells.engine;
                match read(&broadcast(&*ranks, Vec::new())) {
                    Command::Advance(until, steps, true) => {
                        engine.advance(until, steps, &mut Looks);
                    }
                    Command::Advance(until, steps, false) => {
                        engine.advance(until, steps, &mut ());
                    }
                    Command::Unite => engine.unite(),
                    Command::AddUp(reach, name, empty) => {
                        let sum = make(&name, &empty);
                        let mut sum = sum.expect("a sum that this program makes");
                        add_all(&cells, reach, &mut *sum, &*ranks);
                    }
                    Command::Follow => {
                        cells.follow_displacements();
                    }
                    Command::Ways => {
                        all_ways(&*ranks, &cells);
                    }
                    Command::Write(stem, beside) => {
                        // What hinders this process is said by the first.
                        let _ = engine.write_shards(&stem, &beside);
                    }
                    Command::End => return Ok(()),
                }
            }
        })
    }
}

/// Collisions are recorded for the first process.
struct Looks;

impl Observer for Looks {
    fn collisions(&mut self, _batch: &[stosszahl_model::Collision]) {}
}

/// A gas that several processes hold, in the first of them.
struct Among<P: Physics, F: Follow<P::Space>> {
    /// Behind a lock, as those who only look make it whole.
    cells: Mutex<Cells<P, F>>,
    ranks: Arc<dyn Ranks>,
}

impl<P: Physics, F: Follow<P::Space>> Among<P, F> {
    /// As it is, for what the first process knows anyway.
    fn part(&self) -> MutexGuard<'_, Cells<P, F>> {
        self.cells.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Has all processes add what they hold to a sum.
    fn add_by_all(&self, reach: Option<f64>, sum: &mut dyn Sum) {
        Command::AddUp(reach, sum.name().to_owned(), sum.save()).give(&*self.ranks);
        add_all(&self.part(), reach, sum, &*self.ranks);
    }

    /// With all simulators here.
    fn whole(&self) -> MutexGuard<'_, Cells<P, F>> {
        let mut cells = self.part();
        if !cells.engine.is_whole() {
            Command::Unite.give(&*self.ranks);
            cells.engine.unite();
        }
        cells
    }
}

impl<P: Physics, F: Follow<P::Space>> Drop for Among<P, F> {
    fn drop(&mut self) {
        Command::End.give(&*self.ranks);
    }
}

impl<P: Physics, F: Follow<P::Space>> Simulation for Among<P, F> {
    fn time(&self) -> f64 {
        self.part().time()
    }

    fn dimension(&self) -> usize {
        self.part().dimension()
    }

    fn count(&self) -> usize {
        self.part().count()
    }

    fn weight(&self) -> f64 {
        self.part().weight()
    }

    fn advance(
        &mut self,
        until: f64,
        budget: Budget,
        observer: &mut dyn Observer,
    ) -> Result<bool, Failure> {
        self.part().advance(until, budget, observer)
    }

    fn stop_on(&mut self, interrupt: &Interrupt) {
        self.part().stop_on(interrupt);
    }

    fn pause_on(&mut self, pause: &Interrupt) {
        self.part().pause_on(pause);
    }

    fn is_interrupted(&self) -> bool {
        self.part().is_interrupted()
    }

    fn visit(&self, look: &mut dyn FnMut(&Particle)) {
        self.whole().visit(look);
    }

    fn add_up(&self, sum: &mut dyn Sum) {
        self.add_by_all(None, sum);
    }

    fn add_up_near(&self, reach: f64, sum: &mut dyn Sum) {
        self.add_by_all(Some(reach), sum);
    }

    fn particles(&self) -> Particles {
        self.whole().particles()
    }

    fn kick(&mut self, changes: &[Vector3<f64>]) -> Result<(), Failure> {
        self.whole().kick(changes)
    }

    fn scale_velocities(&mut self, factor: f64) -> Result<(), Failure> {
        self.whole().scale_velocities(factor)
    }

    fn checkpoint(&self) -> Result<Vec<u8>, Failure> {
        self.whole().checkpoint()
    }

    fn checkpoint_in_shards(
        &self,
        stem: &Path,
        run: &Fingerprint,
    ) -> Result<Option<Vec<u8>>, Failure> {
        // Others may be in other folders.
        let stem = std::path::absolute(stem).map_err(Failure::new)?;
        let name = stem.file_name().unwrap_or_default().to_string_lossy();
        let beside = Beside {
            folder: stem.parent().unwrap_or(&stem).to_owned(),
            run: *run,
        };
        let mut cells = self.part();
        Command::Write(name.to_string(), beside.clone()).give(&*self.ranks);
        let shards = cells.engine.write_shards(&name, &beside);
        let kept = Kept {
            gas: cells.engine.without_simulators(),
            follows: cells.follows,
            shards: shards.map_err(Failure::new)?,
        };
        postcard::to_stdvec(&kept).map(Some).map_err(Failure::new)
    }

    fn work(&self) -> Work {
        self.part().work()
    }

    fn bytes(&self) -> usize {
        self.part().bytes()
    }

    fn follow_displacements(&mut self) -> bool {
        Command::Follow.give(&*self.ranks);
        self.part().follow_displacements()
    }

    fn displacements(&self) -> Option<Vec<Vector3<f64>>> {
        self.whole().displacements()
    }

    fn mean_squared_displacement(&self) -> Option<f64> {
        let cells = self.part();
        if !cells.follows {
            return None;
        }
        Command::Ways.give(&*self.ranks);
        let squares = all_ways(&*self.ranks, &cells);
        cells.mean_of(&squares)
    }

    fn boundaries(&self) -> Vec<BoundaryFlux> {
        self.part().boundaries()
    }
}
