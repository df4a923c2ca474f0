//! Worker process, which executes pieces of a run, or runs of a frontier, for the root.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, channel};
use std::sync::{Mutex, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use stosszahl::case::CaseFile;
use stosszahl::model::Interrupt;
use stosszahl::results::Existing;
use stosszahl::study::crew::{self, Hand};
use stosszahl::study::plan::available_threads;
use stosszahl::study::{Options, Progress, frontier};

use crate::arguments::Command;
use crate::link::{Link, News, ROOT};
use crate::messages::{ToOther, ToRoot, read, write};

/// Time between two checks for news.
const LOOK: Duration = Duration::from_millis(20);
/// Time between two reports of the progress.
const REPORT: Duration = Duration::from_secs(1);

/// Number of collisions that are not yet reported.
#[derive(Default)]
struct Notes(AtomicU64);

impl Progress for Notes {
    fn tell(&self, _point: usize, _part: usize, _share: f64, collisions: u64) {
        self.0.fetch_add(collisions, Ordering::Relaxed);
    }
}

/// Executes orders until the root ends the work; returns true if all processes then close MPI
/// together.
pub fn serve(link: &Link, command: &Command, stop: &Interrupt) -> bool {
    let said = match first(link) {
        First::Case(file) => match file {
            Ok(file) => {
                let notes = Notes::default();
                let work = |hand: &dyn Hand| help(link, hand, &notes, stop);
                // Planning may take long, while the root must be heard.
                let done = match command {
                    Command::Run { run, .. } => {
                        let options = Options {
                            out: None,
                            existing: Existing::Refuse,
                            threads: run.threads.map(usize::from),
                            force_memory: run.force_memory,
                            stop,
                            progress: &notes,
                            commit: "",
                        };
                        crew::assist(&file, &options, work).map_err(|error| error.to_string())
                    }
                    Command::Frontier { frontier: own, .. } => {
                        let threads = own.threads.map_or_else(available_threads, usize::from);
                        frontier::assist(&file, threads, stop, work)
                            .map_err(|error| error.to_string())
                    }
                };
                match done {
                    Ok(together) => return together,
                    Err(error) => error,
                }
            }
            Err(error) => error,
        },
        First::End(together) => return together,
        First::Nothing => return false,
    };
    link.send(ROOT, write(&ToRoot::Failed(said)));
    loop {
        match link.next(LOOK) {
            Some(News::Lost(_)) => return false,
            Some(News::Message(_, bytes)) => {
                if let Some(ToOther::End { together }) = read(&bytes) {
                    return together;
                }
            }
            None => {}
        }
    }
}

/// First message of the root.
enum First {
    Case(Result<CaseFile, String>),
    End(bool),
    /// The root was lost before.
    Nothing,
}

fn first(link: &Link) -> First {
    loop {
        match link.next(LOOK) {
            Some(News::Lost(_)) => return First::Nothing,
            Some(News::Message(_, bytes)) => match read(&bytes) {
                Some(ToOther::Case(case)) => return First::Case(case.read()),
                Some(ToOther::End { together }) => return First::End(together),
                _ => return First::Case(Err("rank 0 runs another version".to_owned())),
            },
            None => {}
        }
    }
}

/// Executes orders, as many at once as there are slots.
fn help(link: &Link, hand: &dyn Hand, notes: &Notes, stop: &Interrupt) -> bool {
    let (give, orders) = channel::<(u64, Vec<u8>)>();
    let (done, records) = channel::<(u64, Vec<u8>)>();
    let orders = Mutex::new(orders);
    link.send(ROOT, write(&ToRoot::Ready(hand.slots())));
    thread::scope(|scope| {
        for _ in 0..hand.slots() {
            let (orders, done) = (&orders, done.clone());
            scope.spawn(move || {
                while let Some((number, order)) = take(orders) {
                    if done.send((number, hand.work(&order))).is_err() {
                        return;
                    }
                }
            });
        }
        let mut reported = Instant::now();
        let mut has_left = false;
        let together = loop {
            match link.next(LOOK) {
                Some(News::Message(_, bytes)) => match read(&bytes) {
                    Some(ToOther::Order(number, order)) => {
                        let _ = give.send((number, order));
                    }
                    Some(ToOther::End { together }) => break together,
                    _ => {}
                },
                Some(News::Lost(_)) => break false,
                None => {}
            }
            for (number, record) in records.try_iter() {
                // What was broken off is no record.
                if !stop.is_raised() {
                    link.send(ROOT, write(&ToRoot::Record(number, record)));
                }
            }
            if stop.is_raised() && !has_left {
                has_left = true;
                link.send(ROOT, write(&ToRoot::Leaves));
            }
            if reported.elapsed() >= REPORT {
                reported = Instant::now();
                let more = notes.0.swap(0, Ordering::Relaxed);
                link.send(ROOT, write(&ToRoot::Progress(more)));
            }
        };
        // Work in progress is discarded; checkpoints are written.
        stop.raise();
        drop(give);
        together
    })
}

fn take(orders: &Mutex<Receiver<(u64, Vec<u8>)>>) -> Option<(u64, Vec<u8>)> {
    let orders = orders.lock().unwrap_or_else(PoisonError::into_inner);
    orders.recv().ok()
}
