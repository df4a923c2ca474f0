//! Sweeps over all tiles, by one thread or all.

use std::time::Instant;

use stosszahl_model::ParticleModel;

use crate::particle::DisplacementTracking;
use crate::threads::{Pool, each_of};
use crate::tile::{Scratch, SendBuffer, Tile};

/// Runs the work for every tile with its outbox: in parallel, or in order with one thread or little
/// work.
pub(crate) fn sweep<P: ParticleModel, F: DisplacementTracking<P::Space>>(
    parallel: bool,
    tiles: &mut [Tile<P, F>],
    outboxes: &mut [SendBuffer<P, F>],
    pool: &Pool<Scratch<P, F>>,
    work: impl Fn(&mut Tile<P, F>, &mut SendBuffer<P, F>, &mut Scratch<P, F>) + Sync,
) {
    // Runs of adjacent tiles, several for each thread, because some take longer.
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
