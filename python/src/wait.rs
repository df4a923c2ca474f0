//! Work without Python's lock, while the calling thread looks for Ctrl-C.

use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, sync_channel};
use std::thread;
use std::time::{Duration, Instant};

use pyo3::prelude::*;
use stosszahl_model::Interrupt;

/// Time between two looks.
const LOOK: Duration = Duration::from_millis(50);
/// Messages that may wait for Python; then the work waits too.
const WAITING: usize = 4;

/// Two ways to ask for an end.
#[derive(Clone, Debug, Default)]
pub struct Stop {
    /// At the next good moment.
    pub soon: Interrupt,
    /// Within a fraction of a second, in the middle of whatever it is.
    pub now: Interrupt,
}

/// Does work on another thread. What it sends is heard on this one, with Python's lock; so is, between messages, `idle`.
/// When either fails, or on Ctrl-C, the work is asked to stop soon, and once `grace` has passed, now; the error is returned
/// when it has ended.
///
/// # Errors
/// Those of `hear`, `idle`, and `KeyboardInterrupt`; and what the work ended with is then lost.
pub fn wait<T: Send, M: Send>(
    py: Python<'_>,
    stop: &Stop,
    grace: Duration,
    work: impl FnOnce(SyncSender<M>) -> T + Send,
    mut hear: impl FnMut(Python<'_>, M) -> PyResult<()> + Send,
    mut idle: impl FnMut(Python<'_>) -> PyResult<()> + Send,
) -> PyResult<T> {
    py.detach(|| {
        thread::scope(|scope| {
            let (send, receive): (_, Receiver<M>) = sync_channel(WAITING);
            let worker = scope.spawn(move || work(send));
            let mut failed: Option<(PyErr, Instant)> = None;
            let mut looked = Instant::now();
            loop {
                let heard = match receive.recv_timeout(LOOK) {
                    Ok(message) if failed.is_none() => Python::attach(|py| hear(py, message)),
                    Ok(_) | Err(RecvTimeoutError::Timeout) => Ok(()),
                    Err(RecvTimeoutError::Disconnected) => break,
                };
                let looks = looked.elapsed() >= LOOK && failed.is_none();
                let heard = heard.and_then(|()| {
                    if !looks {
                        return Ok(());
                    }
                    looked = Instant::now();
                    Python::attach(|py| py.check_signals().and_then(|()| idle(py)))
                });
                if let Err(error) = heard {
                    stop.soon.raise();
                    failed = Some((error, Instant::now()));
                }
                if failed
                    .as_ref()
                    .is_some_and(|(_, since)| since.elapsed() >= grace)
                {
                    stop.now.raise();
                }
            }
            let done = worker.join();
            match (failed, done) {
                (Some((error, _)), _) => Err(error),
                (None, Ok(done)) => Ok(done),
                (None, Err(panic)) => std::panic::resume_unwind(panic),
            }
        })
    })
}
