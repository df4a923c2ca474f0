//! Heartbeat of the processes that hold one gas: if a process hangs, all others would wait for
//! ever, so the job is ended.
//!
//! A thread of its own beats, so that hours of work between two exchanges do not count as a loss.

use std::ops::Range;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use mpi::Tag;
use mpi::traits::{Communicator as _, Destination as _, Source as _};
use stosszahl::command_line::note;
use stosszahl::dsmc::Ranks as _;

use crate::ROOT;
use crate::world::World;

/// Time between two heartbeats.
const BEAT: Duration = Duration::from_millis(500);
/// Time between two checks for the end.
const LOOK: Duration = Duration::from_millis(2);
/// Tag of heartbeats.
const BEATS: Tag = 1;

/// Heartbeat of a process that is alive.
const ALIVE: u8 = 0;
/// Heartbeat of a process that ends.
const LEAVING: u8 = 1;

/// Process whose heartbeat is watched.
struct Peer {
    rank: i32,
    heard: Instant,
    has_left: bool,
}

/// Returns the ranks that a process listens to: the root to all others, and the others to the root.
fn listened(me: i32, size: i32) -> Range<i32> {
    if me == ROOT { ROOT + 1..size } else { ROOT..1 }
}

/// Heartbeat of this process, until it is dropped.
pub struct Heartbeat {
    is_over: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Heartbeat {
    /// Starts the heartbeat; it ends the job if nothing is heard of another process for `patience`.
    pub fn start(world: &Arc<World>, patience: Duration) -> Self {
        let is_over = Arc::new(AtomicBool::new(false));
        let (world, over) = (world.clone(), is_over.clone());
        let thread =
            (world.size() > 1).then(|| thread::spawn(move || beat(&world, patience, &over)));
        Self { is_over, thread }
    }
}

impl Drop for Heartbeat {
    fn drop(&mut self) {
        self.is_over.store(true, Ordering::SeqCst);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

fn beat(world: &World, patience: Duration, is_over: &AtomicBool) {
    let ranks = listened(world.rank() as i32, world.size() as i32);
    let peer = |rank| Peer {
        rank,
        heard: Instant::now(),
        has_left: false,
    };
    let mut peers: Vec<Peer> = ranks.map(peer).collect();
    loop {
        let ends = is_over.load(Ordering::SeqCst);
        send_heartbeats(world, &peers, if ends { LEAVING } else { ALIVE });
        if ends {
            return;
        }
        listen(world, &mut peers);
        let silent = |one: &&Peer| !one.has_left && one.heard.elapsed() > patience;
        if let Some(Peer { rank, .. }) = peers.iter().find(silent) {
            note(&format!(
                "error: rank {rank} hangs: nothing was heard of it for {} s; the job ends, and --resume continues from the last checkpoint",
                patience.as_secs_f64()
            ));
            world.call(|world| world.abort(1));
        }
        let began = Instant::now();
        while began.elapsed() < BEAT && !is_over.load(Ordering::SeqCst) {
            thread::sleep(LOOK);
        }
    }
}

/// Sends heartbeats of one byte at once, without waiting.
fn send_heartbeats(world: &World, peers: &[Peer], what: u8) {
    for peer in peers.iter().filter(|peer| !peer.has_left) {
        world.call(|world| {
            world.process_at_rank(peer.rank).send_with_tag(&what, BEATS);
        });
    }
}

fn listen(world: &World, peers: &mut [Peer]) {
    loop {
        let came = world.call(|world| {
            let found = world.any_process().immediate_matched_probe_with_tag(BEATS);
            found.map(|(message, _)| message.matched_receive::<u8>())
        });
        let Some((what, status)) = came else {
            return;
        };
        if let Some(peer) = peers
            .iter_mut()
            .find(|one| one.rank == status.source_rank())
        {
            peer.heard = Instant::now();
            peer.has_left = what == LEAVING;
        }
    }
}
