//! Progress of long work: a bar on a terminal, plain lines elsewhere.

use std::io::{IsTerminal, Write};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, LazyLock, Mutex};
use std::thread;
use std::time::{Duration, Instant};

use indicatif::{MultiProgress, ProgressBar, ProgressStyle};

/// Steps of the bar.
const STEPS: u64 = 10_000;

/// Seconds between plain lines.
const LINE_SECONDS: u64 = 10;

/// Bars of what runs side by side share the terminal.
static BARS: LazyLock<MultiProgress> = LazyLock::new(MultiProgress::new);

#[derive(Debug, Default)]
struct Shared {
    /// Share done of each job, in 1/STEPS.
    shares: Mutex<Vec<Arc<AtomicU64>>>,
    collisions: AtomicU64,
    finished: AtomicBool,
}

/// One job's way to tell how far it is.
#[derive(Clone, Debug)]
pub struct JobProgress {
    share: Arc<AtomicU64>,
    all: Arc<Shared>,
}

impl JobProgress {
    /// Of a job that nobody asks about.
    pub fn silent() -> Self {
        Self {
            share: Arc::default(),
            all: Arc::default(),
        }
    }

    /// Tells the share done, from 0 to 1, and how many collisions have happened since last told.
    pub fn tell(&self, share: f64, collisions: u64) {
        self.share.store(
            (share.clamp(0.0, 1.0) * STEPS as f64) as u64,
            Ordering::Relaxed,
        );
        self.all.collisions.fetch_add(collisions, Ordering::Relaxed);
    }
}

/// Shows the progress of all jobs on standard error until it is dropped.
pub struct Progress {
    all: Arc<Shared>,
    reporter: Option<thread::JoinHandle<()>>,
}

impl Progress {
    /// Begins to show progress under a name.
    pub fn start(name: &str) -> Self {
        let all = Arc::new(Shared::default());
        let (shared, name) = (Arc::clone(&all), name.to_owned());
        let reporter = thread::Builder::new()
            .name("progress".into())
            .spawn(move || show(&shared, &name))
            .ok();
        Self { all, reporter }
    }

    /// Announces jobs.
    pub fn jobs(&self, count: usize) -> Vec<JobProgress> {
        let mut shares = self
            .all
            .shares
            .lock()
            .unwrap_or_else(std::sync::PoisonError::into_inner);
        (0..count)
            .map(|_| {
                let share = Arc::new(AtomicU64::new(0));
                shares.push(Arc::clone(&share));
                JobProgress {
                    share,
                    all: Arc::clone(&self.all),
                }
            })
            .collect()
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.all.finished.store(true, Ordering::Relaxed);
        if let Some(reporter) = self.reporter.take() {
            reporter.thread().unpark();
            // A reporter that failed has nothing left to show.
            let _ = reporter.join();
        }
    }
}

impl Shared {
    fn done(&self) -> u64 {
        let shares = self
            .shares
            .lock()
            .unwrap_or_else(std::sync::PoisonError::into_inner);
        let total: u64 = shares
            .iter()
            .map(|share| share.load(Ordering::Relaxed))
            .sum();
        total / (shares.len() as u64).max(1)
    }
}

fn show(all: &Shared, name: &str) {
    let began = Instant::now();
    let terminal = std::io::stderr().is_terminal();
    let bar = if terminal {
        BARS.add(ProgressBar::new(STEPS))
    } else {
        ProgressBar::hidden()
    };
    if let Ok(style) = ProgressStyle::with_template("{prefix} {wide_bar} {percent:>3}%  {msg}") {
        bar.set_style(style);
    }
    bar.set_prefix(name.to_owned());
    let mut next_line = LINE_SECONDS;
    while !all.finished.load(Ordering::Relaxed) {
        thread::park_timeout(Duration::from_millis(200));
        let done = all.done();
        let seconds = began.elapsed().as_secs_f64();
        let share = done as f64 / STEPS as f64;
        let rate = all.collisions.load(Ordering::Relaxed) as f64 / seconds;
        let left = if share > 0.0 {
            seconds * (1.0 - share) / share
        } else {
            f64::NAN
        };
        let message = format!("{} collisions/s, {} left", short(rate), duration(left));
        bar.set_position(done);
        bar.set_message(message.clone());
        if !terminal && seconds >= next_line as f64 {
            next_line = seconds as u64 + LINE_SECONDS;
            // Losing a line of progress harms nothing.
            let _ = writeln!(
                std::io::stderr(),
                "{name}: {:.1} % done, {message}",
                100.0 * share
            );
        }
    }
    bar.finish_and_clear();
}

/// A number with a metric prefix.
fn short(number: f64) -> String {
    match number {
        n if n >= 1e6 => format!("{:.2} M", n / 1e6),
        n if n >= 1e3 => format!("{:.0} k", n / 1e3),
        n => format!("{n:.0}"),
    }
}

/// Seconds in words.
pub fn duration(seconds: f64) -> String {
    if !seconds.is_finite() {
        return "unknown time".into();
    }
    match seconds {
        s if s < 60.0 => format!("{s:.0} s"),
        s if s < 5400.0 => format!("{:.0} min", s / 60.0),
        s if s < 172_800.0 => format!("{:.1} h", s / 3600.0),
        s => format!("{:.1} days", s / 86_400.0),
    }
}
