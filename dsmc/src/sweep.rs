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

/// Does a piece of work for each item, by one thread or all, and returns the results in the order of the items.
///
/// What is shared out are numbers, and the work is behind a pointer: so the code of the pool is compiled once, not for each
/// engine and each kind of work. An item should be worth some thousand simulators.
pub(crate) fn each_of<T: Send, R: Send>(
    parallel: bool,
    items: impl Iterator<Item = T>,
    work: impl Fn(usize, T) -> R + Sync,
) -> Vec<R> {
    if !parallel {
        let items = items.enumerate();
        return items.map(|(number, item)| work(number, item)).collect();
    }
    let items: Vec<Mutex<(Option<T>, Option<R>)>> =
        items.map(|item| Mutex::new((Some(item), None))).collect();
    each_number(items.len(), &|number| {
        // Always free: each number comes once.
        let mut slot = items[number].lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(item) = slot.0.take() {
            slot.1 = Some(work(number, item));
        }
    });
    let results = items.into_iter();
    results
        .filter_map(|slot| slot.into_inner().unwrap_or_else(PoisonError::into_inner).1)
        .collect()
}

fn each_number(count: usize, work: &(dyn Fn(usize) + Sync)) {
    (0..count).into_par_iter().for_each(work);
}

/// Does the work for every tile, each with the outbox of its own. With one thread, or little to do, in their order.
pub(crate) fn sweep<P: Physics, F: Follow<P::Space>>(
    parallel: bool,
    tiles: &mut [Tile<P, F>],
    outboxes: &mut [Outbox<P, F>],
    pool: &Pool<P, F>,
    work: impl Fn(&mut Tile<P, F>, &mut Outbox<P, F>, &mut Scratch<P, F>) + Sync,
) {
    // Runs of neighbouring tiles, several for each thread: some take longer.
    let run = if parallel {
        tiles.len().div_ceil(16 * rayon::current_num_threads())
    } else {
        tiles.len()
    };
    let runs = tiles
        .chunks_mut(run.max(1))
        .zip(outboxes.chunks_mut(run.max(1)));
    each_of(parallel, runs, |_, (tiles, outboxes)| {
        pool.with(|scratch| {
            for (tile, outbox) in tiles.iter_mut().zip(outboxes) {
                if tile.is_here {
                    let began = Instant::now();
                    work(tile, outbox, scratch);
                    tile.seconds += began.elapsed().as_secs_f64();
                }
            }
        });
    });
}
