//! Messages between the processes of a run, and the heartbeat by which a lost process is noticed.
//!
//! Only the thread that started MPI talks to it ([`pump`]); all others talk to that thread through
//! a [`Link`]. So no thread that computes ever waits for another process, and a process that
//! computes for an hour still has a heartbeat.

use std::collections::VecDeque;
use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::thread;
use std::time::{Duration, Instant};

use mpi::point_to_point::MatchedReceiveVec as _;
use mpi::topology::SimpleCommunicator;
use mpi::traits::{Communicator as _, Destination as _, Source as _};

/// Rank of the process that holds the results folder.
pub const ROOT: i32 = 0;

/// Time between two checks for messages.
const LOOK: Duration = Duration::from_millis(1);
/// Time between two heartbeats.
pub const BEAT: Duration = Duration::from_millis(500);
/// Largest message of MPI \[bytes\], which counts them with 31 bits.
const MOST: usize = 1 << 30;

/// Mark before the last part of a message.
const LAST: u8 = 0;
/// Mark before a part of a message of which more is to come.
const MORE: u8 = 1;

/// News from another process.
#[derive(Debug)]
pub enum News {
    /// A message, and the rank of its sender.
    Message(i32, Vec<u8>),
    /// A process of which nothing was heard for too long, by its rank. It may be slow or dead; its
    /// messages are ignored from now on.
    Lost(i32),
}

/// Ends of the channels for threads other than that of the pump.
pub struct Link {
    to: Sender<(i32, Vec<u8>)>,
    from: Receiver<News>,
}

/// Ends of the channels for the pump.
pub struct Ends {
    to: Receiver<(i32, Vec<u8>)>,
    from: Sender<News>,
}

#[cfg(test)]
impl Ends {
    /// Sends news to the other end.
    pub fn tell(&self, news: News) {
        let _ = self.from.send(news);
    }
}

/// Creates a link to a pump.
pub fn link() -> (Link, Ends) {
    let (to, outgoing) = channel();
    let (incoming, from) = channel();
    let ends = Ends {
        to: outgoing,
        from: incoming,
    };
    (Link { to, from }, ends)
}

impl Link {
    /// Sends a message; a message to a lost process is dropped.
    pub fn send(&self, rank: i32, message: Vec<u8>) {
        let _ = self.to.send((rank, message));
    }

    /// Returns the next news, if there are some within a time.
    pub fn next(&self, wait: Duration) -> Option<News> {
        match self.from.recv_timeout(wait) {
            Ok(news) => Some(news),
            Err(RecvTimeoutError::Timeout) => None,
            Err(RecvTimeoutError::Disconnected) => {
                thread::sleep(wait);
                None
            }
        }
    }
}

/// Returns the ranks that a process listens to: the root to all others, and the others to the root.
pub fn listened(me: i32, size: i32) -> Range<i32> {
    if me == ROOT { ROOT + 1..size } else { ROOT..1 }
}

/// Process that this one listens to.
struct Peer {
    rank: i32,
    heard: Instant,
    is_lost: bool,
    /// Received parts of a message of which more is to come.
    parts: Vec<u8>,
}

/// Moves messages until `finished` is set and all are sent. A peer of which nothing is heard for
/// `patience` is lost. Returns true if any peer was lost.
pub fn pump(
    world: &SimpleCommunicator,
    ends: &Ends,
    patience: Duration,
    finished: &AtomicBool,
) -> bool {
    let mut peers: Vec<Peer> = listened(world.rank(), world.size())
        .map(|rank| Peer {
            rank,
            heard: Instant::now(),
            is_lost: false,
            parts: Vec::new(),
        })
        .collect();
    let mut beaten: Option<Instant> = None;
    let mut outgoing: VecDeque<(i32, Vec<u8>)> = VecDeque::new();
    loop {
        // Before the last look at the queue, or what comes between would stay.
        let ends_now = finished.load(Ordering::SeqCst);
        outgoing.extend(ends.to.try_iter());
        let mut is_idle = outgoing.is_empty();
        while let Some((rank, message)) = outgoing.pop_front() {
            if peers.iter().any(|peer| peer.rank == rank && !peer.is_lost) {
                send(world, rank, &message);
            }
        }
        if beaten.is_none_or(|last| last.elapsed() >= BEAT) {
            beaten = Some(Instant::now());
            for peer in peers.iter().filter(|peer| !peer.is_lost) {
                send(world, peer.rank, &[]);
            }
        }
        while let Some(probed) = world.any_process().immediate_matched_probe() {
            is_idle = false;
            let (bytes, status): (Vec<u8>, _) = probed.matched_receive_vec();
            let found = peers
                .iter_mut()
                .find(|one| one.rank == status.source_rank());
            let Some(peer) = found.filter(|one| !one.is_lost) else {
                continue;
            };
            peer.heard = Instant::now();
            let Some((&mark, rest)) = bytes.split_first() else {
                continue;
            };
            peer.parts.extend_from_slice(rest);
            // A beat has no content.
            if mark == LAST && !peer.parts.is_empty() {
                let message = std::mem::take(&mut peer.parts);
                let _ = ends.from.send(News::Message(peer.rank, message));
            }
        }
        for peer in &mut peers {
            if !peer.is_lost && peer.heard.elapsed() > patience {
                peer.is_lost = true;
                let _ = ends.from.send(News::Lost(peer.rank));
            }
        }
        if ends_now {
            return peers.iter().any(|peer| peer.is_lost);
        }
        if is_idle {
            thread::sleep(LOOK);
        }
    }
}

/// Sends a message in as many parts as MPI needs.
fn send(world: &SimpleCommunicator, rank: i32, message: &[u8]) {
    let parts = message.len().div_ceil(MOST).max(1);
    for (number, part) in message
        .chunks(MOST)
        .chain(message.is_empty().then_some(&[][..]))
        .enumerate()
    {
        let mark = if number + 1 == parts { LAST } else { MORE };
        let mut bytes = Vec::with_capacity(part.len() + 1);
        bytes.push(mark);
        bytes.extend_from_slice(part);
        world.process_at_rank(rank).send(&bytes[..]);
    }
}
