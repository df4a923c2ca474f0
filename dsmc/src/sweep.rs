//! Sweeps that process all tiles one after the other, by one thread or by all threads.

use std::time::Instant;

use stosszahl_model::ParticleModel;
use stosszahl_model::threads::{each_of, piece};

use crate::particle::DisplacementTracking;
use crate::threads::Pool;
use crate::tile::{Scratch, SendBuffer, Tile};

/// Calls `work` for every tile with its send buffer and working memory: in parallel, or in order by
/// one thread.
pub(crate) fn sweep<P: ParticleModel, F: DisplacementTracking<P::Space>>(
    parallel: bool,
    tiles: &mut [Tile<P, F>],
    outboxes: &mut [SendBuffer<P, F>],
    pool: &Pool<Scratch<P, F>>,
    work: impl Fn(&mut Tile<P, F>, &mut SendBuffer<P, F>, &mut Scratch<P, F>) + Sync,
) {
    let run = if parallel {
        piece(tiles.len())
    } else {
        tiles.len().max(1)
    };
    let runs = tiles.chunks_mut(run).zip(outboxes.chunks_mut(run));
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
