//! Sweeps: one piece of work for every tile, by one thread or all.

use std::sync::{Mutex, PoisonError};
use std::time::Instant;

use rayon::prelude::*;
use stosszahl_model::Physics;

use crate::simulator::Follow;
use crate::tile::{Outbox, Scratch, Tile};

/// Working memory, lent to the thread that works. Nothing in it outlives the work on a tile.
pub(crate) struct Pool<P: Physics, F: Follow<P::Space>>(Mutex<Vec<Scratch<P, F>>>);

impl<P: Physics, F: Follow<P::Space>> Default for Pool<P, F> {
    fn default() -> Self {
        Self(Mutex::default())
    }
}

impl<P: Physics, F: Follow<P::Space>> Pool<P, F> {
    /// Lends working memory.
    pub(crate) fn with<R>(&self, work: impl FnOnce(&mut Scratch<P, F>) -> R) -> R {
        let pool = || self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let mut scratch = pool().pop().unwrap_or_default();
        let result = work(&mut scratch);
        pool().push(scratch);
        result
    }

    pub(crate) fn bytes(&self) -> usize {
        let pool = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        pool.iter().map(Scratch::bytes).sum()
    }
}

/// Fewest simulators for which threads are worth waking.
const WORTH_THREADS: usize = 20_000;

/// Whether a sweep over this number of simulators is shared among the threads of the present pool.
pub(crate) fn is_parallel(simulators: usize) -> bool {
    simulators >= WORTH_THREADS && rayon::current_num_threads() > 1
}

/// Does the work for every tile, each with the outbox of its own. With one thread, or little to do, in their order.
pub(crate) fn sweep<P: Physics, F: Follow<P::Space>>(
    parallel: bool,
    tiles: &mut [Tile<P, F>],
    outboxes: &mut [Outbox<P, F>],
    pool: &Pool<P, F>,
    work: impl Fn(&mut Tile<P, F>, &mut Outbox<P, F>, &mut Scratch<P, F>) + Sync,
) {
    let several = |tiles: &mut [Tile<P, F>], outboxes: &mut [Outbox<P, F>]| {
        pool.with(|scratch| {
            for (tile, outbox) in tiles.iter_mut().zip(outboxes) {
                if tile.is_here {
                    let began = Instant::now();
                    work(tile, outbox, scratch);
                    tile.seconds += began.elapsed().as_secs_f64();
                }
            }
        });
    };
    if !parallel {
        several(tiles, outboxes);
        return;
    }
    // Runs of neighbouring tiles, several for each thread: some take longer.
    let run = tiles.len().div_ceil(16 * rayon::current_num_threads());
    tiles
        .par_chunks_mut(run)
        .zip(outboxes.par_chunks_mut(run))
        .for_each(|(tiles, outboxes)| several(tiles, outboxes));
}
