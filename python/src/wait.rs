//! Work without Python's lock, while the calling thread looks for Ctrl-C.

use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, SyncSender, channel, sync_channel};
use std::thread;
use std::time::{Duration, Instant};

use pyo3::prelude::*;
use stosszahl_model::Interrupt;

/// Time between two looks.
const LOOK: Duration = Duration::from_millis(50);
/// Time after a first Ctrl-C from which a second one breaks the work off.
const PATIENCE: Duration = Duration::from_secs(1);

/// Two ways to ask for an end.
#[derive(Clone, Debug, Default)]
pub struct Stop {
    /// At the next good moment.
    pub soon: Interrupt,
    /// Within a fraction of a second, in the middle of whatever it is.
    pub now: Interrupt,
}

/// Messages of the work to Python. The work goes on while Python hears the last one, and learns how that ended with the next.
pub struct Messages<M> {
    send: SyncSender<M>,
    answers: Receiver<bool>,
    waits: bool,
    has_failed: bool,
}

impl<M> Messages<M> {
    /// Sends a message once the one before was heard; false, and nothing is sent any more, if Python failed over that.
    pub fn send(&mut self, message: M) -> bool {
        self.has_failed |= self.waits && !self.answers.recv().unwrap_or(false);
        self.waits = !self.has_failed && self.send.send(message).is_ok();
        self.waits
    }
}

/// Does work on another thread. What it sends is heard on this one, with Python's lock; so is, between messages, `idle`.
///
/// A failure of `hear` is told to the work with its next message, so that it always learns of it at the same place. Ctrl-C, and a
/// failure of `idle`, ask the work to stop soon; a second Ctrl-C, to stop now. The error is returned when it has ended.
///
/// # Errors
/// Those of `hear`, `idle`, and `KeyboardInterrupt`; and what the work ended with is then lost.
pub fn wait<T: Send, M: Send>(
    py: Python<'_>,
    stop: &Stop,
    work: impl FnOnce(Messages<M>) -> T + Send,
    mut hear: impl FnMut(Python<'_>, M) -> PyResult<()> + Send,
    mut idle: impl FnMut(Python<'_>) -> PyResult<()> + Send,
) -> PyResult<T> {
    py.detach(|| {
        thread::scope(|scope| {
            let (send, receive) = sync_channel(1);
            let (answer, answers): (Sender<bool>, _) = channel();
            let messages = Messages {
                send,
                answers,
                waits: false,
                has_failed: false,
            };
            let worker = scope.spawn(move || work(messages));
            let mut failed: Option<(PyErr, Instant)> = None;
            let mut looked = Instant::now();
            loop {
                match receive.recv_timeout(LOOK) {
                    Ok(message) => {
                        let heard = Python::attach(|py| hear(py, message));
                        // Work that has ended needs no answer.
                        let _ = answer.send(heard.is_ok());
                        if let Err(error) = heard {
                            failed.get_or_insert((error, Instant::now()));
                        }
                    }
                    Err(RecvTimeoutError::Timeout) => {}
                    Err(RecvTimeoutError::Disconnected) => break,
                }
                if looked.elapsed() < LOOK {
                    continue;
                }
                looked = Instant::now();
                let seen = Python::attach(|py| {
                    py.check_signals()?;
                    failed.as_ref().map_or_else(|| idle(py), |_| Ok(()))
                });
                if let Err(error) = seen {
                    stop.soon.raise();
                    let (_, since) = failed.get_or_insert((error, Instant::now()));
                    if since.elapsed() >= PATIENCE {
                        stop.now.raise();
                    }
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
