//! Progress display of long work on standard error: bars on a terminal, plain lines elsewhere.

use std::io::{IsTerminal, Write as _};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use crate::study::{Progress, ProgressEstimate};
use crate::terminal::note;
use indicatif::{MultiProgress, ProgressBar, ProgressStyle};

/// Number of steps of a progress bar.
const STEPS: u64 = 10_000;
/// Time between two progress lines when standard error is no terminal.
const LINE: Duration = Duration::from_secs(10);

/// Progress display of the points of a run, as bars or lines.
pub struct Display {
    shows: bool,
    terminal: Option<MultiProgress>,
    points: Mutex<Vec<Option<Point>>>,
}

/// Progress of one point of a sweep, or of the only point.
struct Point {
    name: String,
    work: ProgressEstimate,
    collisions: u64,
    began: Instant,
    shown: Instant,
    bar: Option<ProgressBar>,
    /// Description of what slows a part of the run down, such as its busiest particles, if it was
    /// not shown yet.
    activity: Option<String>,
}

impl Default for Display {
    fn default() -> Self {
        Self::new()
    }
}

impl Display {
    /// Creates a progress display on standard error.
    pub fn new() -> Self {
        Self {
            shows: true,
            terminal: std::io::stderr().is_terminal().then(MultiProgress::new),
            points: Mutex::default(),
        }
    }

    /// Creates a progress display that shows nothing.
    pub fn silent() -> Self {
        Self {
            shows: false,
            terminal: None,
            points: Mutex::default(),
        }
    }

    /// Calls `act` with the progress of a point that has begun; does nothing for other points.
    fn with(&self, number: usize, act: impl FnOnce(&mut Point)) {
        let mut points = self.points.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(Some(point)) = points.get_mut(number) {
            act(point);
        }
    }
}

impl Progress for Display {
    fn begin_point(&self, number: usize, name: &str, work: ProgressEstimate) {
        let bar = self.terminal.as_ref().map(|all| {
            let template = "{msg} {wide_bar} {percent:>3} %  {elapsed} of about {duration}";
            let style = ProgressStyle::with_template(template);
            let bar = all.add(ProgressBar::new(STEPS));
            bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
            bar.set_message(name.to_owned());
            bar
        });
        let now = Instant::now();
        let mut points = self.points.lock().unwrap_or_else(PoisonError::into_inner);
        if points.len() <= number {
            points.resize_with(number + 1, || None);
        }
        points[number] = Some(Point {
            name: name.to_owned(),
            work,
            collisions: 0,
            began: now,
            shown: now,
            bar,
            activity: None,
        });
    }

    fn tell_share(&self, number: usize, part: usize, share: f64, collisions: u64) {
        self.with(number, |point| {
            point.work.record_share(part, share, Instant::now());
            point.collisions += collisions;
            let done = point.work.done_share();
            if let Some(bar) = &point.bar {
                bar.set_position((done * STEPS as f64) as u64);
                if point.shown.elapsed() >= LINE
                    && let Some(activity) = point.activity.take()
                {
                    point.shown = Instant::now();
                    bar.println(format!("{}: {activity}", point.name));
                }
            } else if self.shows && point.shown.elapsed() >= LINE {
                point.shown = Instant::now();
                // Errors are ignored, because a closed standard error must not end the run.
                let activity = point.activity.take();
                let activity = activity.map_or_else(String::new, |text| format!("; {text}"));
                let _ = writeln!(
                    std::io::stderr(),
                    "{}: {:.0} % after {} s, {:.2e} collisions{activity}",
                    point.name,
                    100.0 * done,
                    point.began.elapsed().as_secs(),
                    point.collisions as f64
                );
            }
        });
    }

    fn tell_activity(&self, number: usize, _part: usize, activity: &str) {
        self.with(number, |point| point.activity = Some(activity.to_owned()));
    }

    fn end_point(&self, number: usize) {
        self.with(number, |point| {
            if let Some(bar) = &point.bar {
                bar.finish_and_clear();
            }
        });
    }

    fn show_note(&self, text: &str) {
        if self.shows {
            note(text);
        }
    }
}
