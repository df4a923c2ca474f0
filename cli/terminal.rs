//! Terminal output wrapped at its width, and interrupts from signals.

use std::io::{self, IsTerminal, Write as _};
use std::process;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use crate::model::Interrupt;

/// Exit code of a command that was interrupted: 130, as shells use it.
pub(crate) const STOPPED: u8 = 130;
/// Exit code of a run that reached its time limit: 75, a temporary failure in `sysexits.h`.
pub(crate) const OUT_OF_TIME: u8 = 75;
/// Grace period after an interrupt in which a command must end, unless it is saving.
const GRACE: Duration = Duration::from_millis(750);

/// Prints a line to standard output.
pub(crate) fn say(text: &str) -> io::Result<()> {
    match writeln!(io::stdout(), "{text}") {
        // A closed pipe is no error: a reader such as `head` stops early.
        Err(error) if error.kind() == io::ErrorKind::BrokenPipe => Ok(()),
        other => other,
    }
}

/// Prints a line to standard error; errors are ignored.
pub fn note(text: &str) {
    let _ = writeln!(io::stderr(), "{text}");
}

/// Formats a label and a sentence as lines wrapped at the width of the terminal.
pub(crate) fn line(word: &str, text: &str) -> String {
    beside(&format!("{word:<10} "), text)
}

/// Formats a label and the text next to it as lines wrapped at the width of the terminal.
pub(crate) fn beside(left: &str, text: &str) -> String {
    // No wrapping for a file or another program.
    if !io::stdout().is_terminal() {
        return format!("{left}{text}");
    }
    let width = textwrap::termwidth().max(left.len() + 30);
    let indent = " ".repeat(left.len());
    let options = textwrap::Options::new(width).initial_indent(left);
    textwrap::fill(text, options.subsequent_indent(&indent))
}

/// Ignores the signal of the file size limit (`ulimit -f`), so that a write beyond it fails with an
/// error instead of killing the process. A program calls this first.
pub fn outlive_file_limits() {
    #[cfg(unix)]
    {
        use signal_hook::{consts::SIGXFSZ, flag::register};
        // A refused signal handler leaves the default behaviour.
        let _ = register(SIGXFSZ, Arc::default());
    }
}

/// Installs handlers for Ctrl-C and termination signals, and returns the interrupt that they raise.
///
/// Work that checks it ends by itself and saves its state. If it does not end within the grace
/// period, which a save extends, `said` is printed and the process is ended as by a kill;
/// checkpoints survive that. A second signal ends the process at once.
pub fn listen(said: &'static str) -> Interrupt {
    let interrupt = Interrupt::default();
    let asked = interrupt.clone();
    // Without a handler a signal ends the process at once.
    let _ = ctrlc::set_handler(move || {
        if asked.is_raised() {
            process::exit(STOPPED.into());
        }
        let asked = asked.clone();
        thread::spawn(move || end_soon(&asked, said, STOPPED));
    });
    interrupt
}

/// Raises an interrupt, then ends the process with `code` unless the work ends within the grace
/// period. A save extends that period; `said` is printed before the end.
fn end_soon(interrupt: &Interrupt, said: &str, code: u8) {
    interrupt.raise();
    let began = Instant::now();
    while began.elapsed() < GRACE || interrupt.is_held() {
        thread::sleep(Duration::from_millis(20));
    }
    if !said.is_empty() {
        note(said);
    }
    process::exit(code.into());
}

/// Time limit of a run, `--stop-after`: a flag that a timer sets.
pub struct TimeLimit(Arc<AtomicBool>);

impl TimeLimit {
    /// Starts the time limit of a run, if there is one. At its end the interrupt is raised. Work
    /// that does not end within the grace period is ended with the message `said`.
    pub fn start(limit: Option<Duration>, interrupt: &Interrupt, said: &'static str) -> Self {
        let is_reached = Arc::<AtomicBool>::default();
        if let Some(limit) = limit {
            let (interrupt, reached) = (interrupt.clone(), is_reached.clone());
            thread::spawn(move || {
                thread::sleep(limit);
                reached.store(true, Ordering::Relaxed);
                end_soon(&interrupt, said, OUT_OF_TIME);
            });
        }
        Self(is_reached)
    }

    /// Returns true if the time limit was reached.
    pub(crate) fn is_reached(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}
