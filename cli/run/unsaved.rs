//! Runs that keep nothing on disk: starts and engines one by one, for sweeps of numerical choices.

use std::marker::PhantomData;
use std::sync::Mutex;
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

use stosszahl_model::State;
use stosszahl_model::random::Streams;

use super::job::{self, Finished};
use super::{Control, Fingerprint, RunError, prepare};
use crate::case::Engine;
use crate::dispatch::Planar;
use crate::progress::JobProgress;
use crate::setup::Setup;

/// Nobody stops a run that keeps nothing: it is short.
static NEVER: AtomicBool = AtomicBool::new(false);
/// Nor is there a checkpoint that it could identify.
static NOTHING: Fingerprint = [0; 32];

/// A case whose replicas are run without files. Replica r gives the numbers that it gives in [`super::run`].
pub(crate) struct Unsaved<'a> {
    /// The case.
    pub(crate) setup: &'a Setup,
    /// Which replica.
    pub(crate) replica: u64,
}

impl Unsaved<'_> {
    fn streams(&self) -> Streams {
        Streams::new(self.setup.case.seed, self.replica)
    }

    fn control<T>() -> Control<'static, T> {
        Control {
            path: None,
            fingerprint: &NOTHING,
            interval: Duration::MAX,
            last: Mutex::new(Instant::now()),
            stop: &NEVER,
            progress: JobProgress::silent(),
            content: PhantomData,
        }
    }

    /// The start, equilibrated.
    ///
    /// # Errors
    /// [`RunError`] if it cannot be made.
    pub(crate) fn start<P: Planar>(&self, scene: &P) -> Result<State<P>, RunError> {
        let control = Self::control();
        let done = prepare::prepare(self.setup, scene, self.streams(), &control)?;
        Ok(done.state().clone())
    }

    /// One engine from a start to the end of the case.
    ///
    /// # Errors
    /// [`RunError`] if the engine cannot start or go on, or a measurement cannot be made.
    pub(crate) fn run<P: Planar>(
        &self,
        scene: &P,
        engine: &Engine,
        start: &State<P>,
    ) -> Result<Finished, RunError> {
        let control = Self::control();
        job::run_engine(
            self.setup,
            scene,
            engine,
            start,
            self.streams(),
            &control,
            None,
        )
    }
}
