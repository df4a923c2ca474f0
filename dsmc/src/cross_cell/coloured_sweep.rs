//! Coloured sweep over the tiles of a box: tiles are processed in parallel, each together with its
//! neighbouring tiles.
//!
//! Tiles are coloured so that no two of one colour share a neighbour. Colours follow each other,
//! and all threads work on the tiles of one colour at once, so the pairs that collide do not depend
//! on the number of threads. Each tile is behind a lock that the colouring keeps free.

use std::sync::Mutex;
use std::time::Instant;

use stosszahl_model::ParticleModel;
use stosszahl_model::threads::each_of;

use super::change::ChangeOf;
use super::colours::colours;
use super::peers::TilePeers;
use super::tile_neighbourhood::{TileNeighbourhood, lock};
use crate::features::PROCESSES;
use crate::grid::Grid;
use crate::particle::DisplacementTracking;
use crate::tile::Tile;

/// Calls `work` for every tile of this process with its neighbouring tiles, colour after colour,
/// and returns the results with tile numbers. After each colour, processes exchange the changes in
/// ghost cells.
pub(super) fn sweep_around<P: ParticleModel, F: DisplacementTracking<P::Space>, R: Send>(
    parallel: bool,
    grid: &Grid<P::Space>,
    tiles: &mut [Tile<P, F>],
    peers: Option<&dyn TilePeers<P, F>>,
    work: impl Fn(usize, TileNeighbourhood<'_, '_, P, F>) -> (R, Vec<ChangeOf<P>>) + Sync,
) -> Vec<(u32, R)> {
    let mut results = Vec::with_capacity(tiles.len());
    let here: Vec<bool> = tiles.iter().map(|tile| tile.is_here).collect();
    let locks: Vec<Mutex<&mut Tile<P, F>>> = tiles.iter_mut().map(Mutex::new).collect();
    let one = |_, number: &u32| {
        let middle = grid.place_of(*number as usize);
        let around = TileNeighbourhood::new(grid, &locks, middle, peers);
        let began = Instant::now();
        let (result, changes) = work(*number as usize, around);
        lock(&locks[*number as usize]).seconds += began.elapsed().as_secs_f64();
        (*number, result, changes)
    };
    let work_on = |some: &[u32]| each_of(parallel && some.len() > 1, some.iter(), one);
    let colours: Vec<Vec<u32>> = colours(grid)
        .into_iter()
        .map(|group| {
            let own = group.into_iter();
            own.filter(|&number| here[number as usize]).collect()
        })
        .collect();
    match peers {
        Some(peers) if PROCESSES => {
            let apply = |change: ChangeOf<P>| {
                change.apply(&mut lock(&locks[change.tile as usize]));
            };
            colour_by_colour::<P, F, R, _>(peers, &colours, 0, &work_on, &apply, &mut results);
        }
        _ => {
            for own in &colours {
                let done = work_on(own).into_iter();
                results.extend(done.map(|(number, result, _)| (number, result)));
            }
        }
    }
    results
}

/// Result of the work on one tile: tile number, result, and velocity changes that other processes
/// need.
type Done<P, R> = (u32, R, Vec<ChangeOf<P>>);

/// Processes the tiles of one colour, and then of all later colours. Each colour runs inside the
/// message exchange of the colour before, so that no process waits for another that has not yet
/// received its messages.
fn colour_by_colour<
    P: ParticleModel,
    F: DisplacementTracking<P::Space>,
    R,
    W: Fn(&[u32]) -> Vec<Done<P, R>>,
>(
    peers: &dyn TilePeers<P, F>,
    colours: &[Vec<u32>],
    colour: usize,
    work_on: &W,
    apply: &dyn Fn(ChangeOf<P>),
    results: &mut Vec<(u32, R)>,
) {
    let Some(own) = colours.get(colour) else {
        return;
    };
    // Tiles that other processes see come first: their changes are waited for.
    let (seen, unseen): (Vec<u32>, Vec<u32>) = own
        .iter()
        .partition(|&&number| peers.tells(number as usize));
    let mut changes = Vec::new();
    for (number, result, some) in work_on(&seen) {
        results.push((number, result));
        changes.extend(some);
    }
    let mut inner = Vec::new();
    peers.tell_changes(
        colour,
        &changes,
        &mut || inner = work_on(&unseen),
        &mut |elsewhere| {
            elsewhere.into_iter().for_each(apply);
            colour_by_colour::<P, F, R, _>(peers, colours, colour + 1, work_on, apply, results);
        },
    );
    results.extend(
        inner
            .into_iter()
            .map(|(number, result, _)| (number, result)),
    );
}
