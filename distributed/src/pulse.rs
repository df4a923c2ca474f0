//! The pulse of the processes that hold one gas. One that stands still would make all others wait for ever; the job is ended.
//!
//! A thread of its own beats, so that work of hours between two exchanges has a pulse.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use mpi::Tag;
use mpi::traits::{Communicator as _, Destination as _, Source as _};
use stosszahl::commands::note;
use stosszahl::dsmc::Ranks as _;

use crate::link::{BEAT, listened};
use crate::world::World;

/// Time between two looks for whether it is the end.
const LOOK: Duration = Duration::from_millis(2);
/// The tag of beats.
const BEATS: Tag = 1;

/// What a beat says.
const LIVES: u8 = 0;
const LEAVES: u8 = 1;

/// A process that is listened to.
struct Peer {
    rank: i32,
    heard: Instant,
    has_left: bool,
}

/// The pulse of this process, until it is dropped.
pub struct Pulse {
    is_over: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Pulse {
    /// Beats, and ends the job if nothing is heard of another process for `patience`.
    pub fn start(world: &Arc<World>, patience: Duration) -> Self {
        let is_over = Arc::new(AtomicBool::new(false));
        let (world, over) = (world.clone(), is_over.clone());
        let thread =
            (world.size() > 1).then(|| thread::spawn(move || beat(&world, patience, &over)));
        Self { is_over, thread }
    }
}

impl Drop for Pulse {
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
        tell(world, &peers, if ends { LEAVES } else { LIVES });
        if ends {
            return;
        }
        listen(world, &mut peers);
        let silent = |one: &&Peer| !one.has_left && one.heard.elapsed() > patience;
        if let Some(Peer { rank, .. }) = peers.iter().find(silent) {
            note(&format!(
                "error: rank {rank} stands still: nothing was heard of it for {} s; the job ends, and --resume goes on from the last checkpoint",
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

/// Beats of one byte are sent at once, and not waited for.
fn tell(world: &World, peers: &[Peer], what: u8) {
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
            peer.has_left = what == LEAVES;
        }
    }
}
