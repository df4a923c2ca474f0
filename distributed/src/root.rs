//! Root process, which holds the results folder: it distributes the pieces of a run or the runs of
//! a frontier, and executes some itself.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};
use std::sync::mpsc::channel;
use std::sync::{Mutex, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use stosszahl::commands::note;
use stosszahl::study::Progress;
use stosszahl::study::crew::{Crew, Work};

use crate::link::{Link, News};
use crate::messages::{ToOther, ToRoot, read, write};

/// Time between two checks for news or for an order.
const LOOK: Duration = Duration::from_millis(5);
/// Time between two lines of progress.
const LINE: Duration = Duration::from_secs(10);

/// The other processes, from the view of the root.
pub struct Others<'a> {
    /// Link to the others. Behind a lock, as only one thread listens.
    link: &'a Mutex<Link>,
    /// Number of all processes.
    size: i32,
    /// True if a process was lost, or has left.
    is_short: AtomicBool,
    /// State of each process, by rank.
    known: Mutex<BTreeMap<i32, Other>>,
    /// Number of the next order.
    next: AtomicU64,
}

impl<'a> Others<'a> {
    /// Creates the view of the others of this many processes.
    pub fn new(link: &'a Mutex<Link>, size: i32) -> Self {
        Self {
            link,
            size,
            is_short: AtomicBool::new(false),
            known: Mutex::new((1..size).map(|rank| (rank, Other::default())).collect()),
            next: AtomicU64::new(0),
        }
    }

    /// Sends a message to all others.
    pub fn tell(&self, message: &ToOther) {
        let link = self.link.lock().unwrap_or_else(PoisonError::into_inner);
        (1..self.size).for_each(|rank| link.send(rank, write(message)));
    }

    /// Collects news of processes that were lost, or have left, since the last order was executed:
    /// reports take time, and no thread listens then.
    pub fn hear_who_is_gone(&self) {
        let link = self.link.lock().unwrap_or_else(PoisonError::into_inner);
        while let Some(news) = link.next(Duration::ZERO) {
            let is_gone = match news {
                News::Lost(_) => true,
                News::Message(_, bytes) => matches!(read(&bytes), Some(ToRoot::Leaves)),
            };
            self.is_short.fetch_or(is_gone, Ordering::SeqCst);
        }
    }

    /// Returns true if no process was lost or has left.
    pub fn are_all_there(&self) -> bool {
        !self.is_short.load(Ordering::SeqCst)
    }
}

impl Progress for Others<'_> {
    fn note(&self, text: &str) {
        note(text);
    }
}

/// State of another process.
#[derive(Default)]
struct Other {
    /// Number of further orders that it can take.
    free: usize,
    /// Orders that it holds, by their number.
    held: BTreeMap<u64, Vec<u8>>,
    is_gone: bool,
}

impl Crew for Others<'_> {
    fn work(&self, work: &dyn Work, slots: usize, here: &(dyn Fn(&[u8]) + Sync)) {
        let link = self.link.lock().unwrap_or_else(PoisonError::into_inner);
        let mut known = self.known.lock().unwrap_or_else(PoisonError::into_inner);
        let mut desk = Desk {
            others: &mut known,
            next: &self.next,
            work,
            link: &link,
            is_short: &self.is_short,
            collisions: 0,
        };
        let (records, coming) = channel::<(Vec<u8>, Vec<u8>)>();
        let at_work = AtomicUsize::new(0);
        thread::scope(|scope| {
            for _ in 0..slots {
                scope.spawn(|| {
                    while !work.is_finished() {
                        match work.next() {
                            Some(order) => {
                                at_work.fetch_add(1, Ordering::SeqCst);
                                here(&order);
                                at_work.fetch_sub(1, Ordering::SeqCst);
                            }
                            None => thread::sleep(LOOK),
                        }
                    }
                });
            }
            // Tables take their time, and orders must not wait for them.
            scope.spawn(|| {
                for (order, record) in coming {
                    work.take(&order, &record);
                }
            });
            let (began, mut told) = (Instant::now(), Instant::now());
            while !work.is_finished() {
                if let Some(news) = desk.link.next(LOOK)
                    && let Some((order, record)) = desk.hear(news)
                {
                    let _ = records.send((order, record));
                }
                desk.hand_out();
                if told.elapsed() >= LINE {
                    told = Instant::now();
                    let here = at_work.load(Ordering::SeqCst);
                    note(&desk.line(here, began.elapsed()));
                }
            }
            drop(records);
        });
    }
}

/// Task queue: sends orders and collects records.
struct Desk<'a> {
    others: &'a mut BTreeMap<i32, Other>,
    next: &'a AtomicU64,
    work: &'a dyn Work,
    link: &'a Link,
    is_short: &'a AtomicBool,
    /// Number of collisions of the other processes.
    collisions: u64,
}

impl Desk<'_> {
    /// Handles news of another process: returns the order and its record, if the news is one.
    fn hear(&mut self, news: News) -> Option<(Vec<u8>, Vec<u8>)> {
        match news {
            News::Lost(rank) => {
                note(&format!(
                    "rank {rank} is lost: nothing was heard of it; others do its work"
                ));
                self.leave(rank);
                None
            }
            News::Message(rank, bytes) => {
                let other = self.others.get_mut(&rank)?;
                match read(&bytes) {
                    Some(ToRoot::Ready(slots)) => other.free = slots,
                    Some(ToRoot::Failed(why)) => {
                        other.is_gone = true;
                        self.work.fail(format!("rank {rank}: {why}"));
                    }
                    Some(ToRoot::Record(number, record)) => {
                        other.free += 1;
                        return Some((other.held.remove(&number)?, record));
                    }
                    Some(ToRoot::Leaves) => {
                        note(&format!(
                            "rank {rank} was asked to stop; others do its work"
                        ));
                        self.leave(rank);
                    }
                    Some(ToRoot::Progress(more)) => self.collisions += more,
                    None => {}
                }
                None
            }
        }
    }

    /// Marks a process as gone, and takes its orders back.
    fn leave(&mut self, rank: i32) {
        self.is_short.store(true, Ordering::SeqCst);
        if let Some(other) = self.others.get_mut(&rank) {
            other.is_gone = true;
            for order in std::mem::take(&mut other.held).into_values() {
                self.work.put_back(&order);
            }
        }
    }

    /// Sends each process as many orders as it can take.
    fn hand_out(&mut self) {
        for (&rank, other) in self.others.iter_mut() {
            while other.free > 0 && !other.is_gone {
                let Some(order) = self.work.next() else {
                    return;
                };
                let number = self.next.fetch_add(1, Ordering::Relaxed);
                let message = ToOther::Order(number, order.clone());
                self.link.send(rank, write(&message));
                other.held.insert(number, order);
                other.free -= 1;
            }
        }
    }

    /// Formats the progress of the run.
    fn line(&self, here: usize, time: Duration) -> String {
        let (what, [done, all]) = self.work.count();
        let busy = self.others.values().filter(|other| !other.held.is_empty());
        let ranks = busy.count() + usize::from(here > 0);
        format!(
            "{done} of {all} {what} after {} s, {ranks} ranks at work, {:.2e} collisions on others",
            time.as_secs(),
            self.collisions as f64
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// MPI is not closed together with a process that was lost after the last order; otherwise the
    /// root would wait for ever.
    #[test]
    fn who_is_lost_after_the_last_piece_is_not_waited_for() {
        for (gone, news) in [
            (true, News::Lost(1)),
            (true, News::Message(1, write(&ToRoot::Leaves))),
            (false, News::Message(1, write(&ToRoot::Progress(3)))),
        ] {
            let (link, ends) = crate::link::link();
            let link = Mutex::new(link);
            let others = Others::new(&link, 2);
            ends.tell(news);
            others.hear_who_is_gone();
            assert_eq!(others.are_all_there(), !gone);
        }
    }
}
