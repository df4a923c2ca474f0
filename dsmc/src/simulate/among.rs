//! A gas that several processes hold, behind the common interface.
//!
//! The first process drives the gas as any other ([`simulate_among`]); the others do what it does ([`serve`]). While the gas
//! advances each holds its part. Whoever looks at particles, kicks them or writes a checkpoint makes the first process gather all.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};
use stosszahl_model::{
    BoundaryFlux, Budget, Failure, Interrupt, Observer, Particle, Particles, Physics, Simulation,
    Work,
};

use super::{Cells, Gas, Keep, Kept, Source, begin};
use crate::parameters::EngineError;
use crate::share::{Ranks, all_gather, broadcast, read, write};
use crate::simulator::Follow;

/// What the first process tells the others.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(super) enum Command {
    /// Until when, for how many steps, and whether collisions are looked at.
    Advance(f64, u64, bool),
    /// The first process is to hold all.
    Unite,
    /// The gas is let go of.
    End,
}

impl Command {
    pub(super) fn give(self, ranks: &dyn Ranks) {
        broadcast(ranks, write(&self));
    }
}

/// [`super::simulate`] of a gas that all of these processes hold. This is the first of them; the others [`serve`].
///
/// # Errors
/// As [`super::simulate`]; and if another process cannot hold its part.
pub fn simulate_among(
    gas: &Gas<'_>,
    starts: &[Particles],
    ranks: &Arc<dyn Ranks>,
) -> Result<Box<dyn Simulation>, EngineError> {
    lead(gas, Source::Start(starts), ranks)
}

/// [`super::resume`] of a gas that all of these processes hold. This is the first of them; the others [`serve`]. The checkpoint is
/// that of a gas in any number of processes.
///
/// # Errors
/// As [`super::resume`]; and if another process cannot hold its part.
pub fn resume_among(
    gas: &Gas<'_>,
    count: usize,
    lengths: [f64; 3],
    checkpoint: &[u8],
    ranks: &Arc<dyn Ranks>,
) -> Result<Box<dyn Simulation>, EngineError> {
    let source = Source::Checkpoint {
        count,
        lengths,
        bytes: checkpoint,
    };
    lead(gas, source, ranks)
}

fn lead(
    gas: &Gas<'_>,
    source: Source<'_>,
    ranks: &Arc<dyn Ranks>,
) -> Result<Box<dyn Simulation>, EngineError> {
    let led = if gas.boundaries.weights.follows() {
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
    match answers(&**ranks, None) {
        None => Ok((led.gas)()),
        Some(error) => Err(error),
    }
}

/// What hinders the first process that something hinders, as all tell each other.
fn answers(ranks: &dyn Ranks, mine: Option<&str>) -> Option<EngineError> {
    let all = all_gather(ranks, write(&mine));
    let mut all = all
        .iter()
        .map(|bytes| read::<Option<String>>(bytes))
        .enumerate();
    all.find_map(|(rank, why)| Some(EngineError::Elsewhere { rank, why: why? }))
}

/// Holds a part of a gas that another process drives, with everything but the start as there, until that lets go of it. The gas
/// started with `count` particles in a box of these sides.
///
/// # Errors
/// [`EngineError`] if it cannot be made here or elsewhere.
pub fn serve(
    gas: &Gas<'_>,
    count: usize,
    lengths: [f64; 3],
    ranks: &Arc<dyn Ranks>,
    interrupt: &Interrupt,
) -> Result<(), EngineError> {
    let Some(bytes) = read::<Option<Vec<u8>>>(&broadcast(&**ranks, Vec::new())) else {
        // It could not be made there, which is said there.
        return Ok(());
    };
    let source = Source::Checkpoint {
        count,
        lengths,
        bytes: &bytes,
    };
    let served = begin(gas, source, &Serve(ranks.clone(), interrupt.clone()));
    let why = served.as_ref().err().map(ToString::to_string);
    match answers(&**ranks, why.as_deref()) {
        None => {
            served?();
            Ok(())
        }
        Some(error) => Err(error),
    }
}

/// The first process keeps an engine that others help with.
struct Lead(Arc<dyn Ranks>);

/// What it begins with, and what others must know.
struct Led {
    gas: Box<dyn FnOnce() -> Box<dyn Simulation>>,
    brief: Vec<u8>,
}

impl Keep for Lead {
    type Kept = Led;
    fn keep<P: Physics, F: Follow<P::Space>>(&self, mut cells: Cells<P, F>) -> Led {
        let brief = write(&Kept {
            gas: cells.engine.without_simulators(),
            follows: cells.follows,
        });
        let ranks = self.0.clone();
        let gas = move || -> Box<dyn Simulation> {
            cells.engine.share(ranks.clone());
            cells.others = Some(ranks.clone());
            Box::new(Among {
                cells: Mutex::new(cells),
                ranks,
            })
        };
        Led {
            gas: Box::new(gas),
            brief,
        }
    }
}

/// Another process does as it is told.
struct Serve(Arc<dyn Ranks>, Interrupt);

impl Keep for Serve {
    type Kept = Box<dyn FnOnce()>;
    fn keep<P: Physics, F: Follow<P::Space>>(&self, mut cells: Cells<P, F>) -> Self::Kept {
        let Self(ranks, interrupt) = self;
        let ranks = ranks.clone();
        cells.engine.stop_on(interrupt);
        Box::new(move || {
            let engine = &mut cells.engine;
            engine.share(ranks.clone());
            loop {
                match read(&broadcast(&*ranks, Vec::new())) {
                    Command::Advance(until, steps, true) => {
                        engine.advance(until, steps, &mut Looks);
                    }
                    Command::Advance(until, steps, false) => {
                        engine.advance(until, steps, &mut ());
                    }
                    Command::Unite => engine.unite(),
                    Command::End => break,
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

    fn work(&self) -> Work {
        self.part().work()
    }

    fn bytes(&self) -> usize {
        self.part().bytes()
    }

    fn follow_displacements(&mut self) -> bool {
        self.whole().follow_displacements()
    }

    fn displacements(&self) -> Option<Vec<Vector3<f64>>> {
        self.whole().displacements()
    }

    fn boundaries(&self) -> Vec<BoundaryFlux> {
        self.part().boundaries()
    }
}
