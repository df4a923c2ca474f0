//! Work on another thread without Python's global lock, while the calling thread checks for Ctrl-C.

use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, SyncSender, channel, sync_channel};
use std::thread;
use std::time::{Duration, Instant};

use pyo3::prelude::*;
use stosszahl_model::Interrupt;

/// Time between two checks for Ctrl-C.
const LOOK: Duration = Duration::from_millis(50);
/// Time after a first Ctrl-C from which a second one stops the work at once.
const PATIENCE: Duration = Duration::from_secs(1);

/// Pair of interrupts for work started from Python: a gentle one and an immediate one.
#[derive(Clone, Debug, Default)]
pub struct PyInterrupt {
    /// Gentle interrupt: stop at the next checkpoint, or at another point where state is
    /// consistent.
    pub soon: Interrupt,
    /// Immediate interrupt: stop within a fraction of a second, whatever the work.
    pub now: Interrupt,
}

/// Channel of messages from the work to Python. The work continues while Python handles a message,
/// and learns of a failure with the next one.
pub struct Messages<M> {
    send: SyncSender<M>,
    answers: Receiver<bool>,
    waits: bool,
    has_failed: bool,
}

impl<M> Messages<M> {
    /// Sends a message once Python has handled the previous one. Returns false, and sends no more,
    /// if Python failed on that one.
    pub fn send(&mut self, message: M) -> bool {
        self.has_failed |= self.waits && !self.answers.recv().unwrap_or(false);
        self.waits = !self.has_failed && self.send.send(message).is_ok();
        self.waits
    }
}

/// Runs `work` on another thread. Its messages are handled by `hear` on the calling thread, with
/// Python's lock; between messages `idle` is called.
///
/// The work learns of a failure of `hear` with its next message, so always at the same place.
/// Ctrl-C, and a failure of `idle`, ask the work to stop soon; a second Ctrl-C, to stop now. The
/// error is returned when it has ended.
///
/// # Errors
/// Those of `hear`, `idle`, and `KeyboardInterrupt`; and what the work ended with is then lost.
pub fn wait<T: Send, M: Send>(
    py: Python<'_>,
    stop: &PyInterrupt,
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
                        // The answer may fail: the work has ended.
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
