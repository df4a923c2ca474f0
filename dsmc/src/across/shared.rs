//! Sweeps in which each tile is worked on together with those next to it.
//!
//! Tiles are coloured so that no two of one colour share a neighbour; colours follow each other, and the tiles of
//! one are treated by all threads at once. Who collides with whom then does not depend on the number of threads. Each tile
//! is behind a lock that is always free, because the colouring says so.

use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Instant;

use serde::{Deserialize, Serialize};
use stosszahl_model::{Collision, Physics, Space, SpinOf, Surface, Vector, VectorOf};

use crate::grid::{Grid, OFFSETS, offset, offset_number};
use crate::share::{PROCESSES, Share};
use crate::simulator::{Follow, SimulatorOf};
use crate::sweep::each_of;
use crate::tile::Tile;

/// A tile, and those next to it.
pub(super) struct Around<'a, 'b, P: Physics, F: Follow<P::Space>> {
    grid: &'a Grid<P::Space>,
    /// Coordinates of the tile in the middle.
    middle: [u32; 3],
    /// Each once.
    tiles: Vec<MutexGuard<'a, &'b mut Tile<P, F>>>,
    /// Which of them is at each offset.
    slots: [u8; OFFSETS],
    /// Their numbers among all tiles, and whether other processes see them.
    numbers: Vec<u32>,
    seen: Vec<bool>,
    /// What other processes are to know of those.
    changes: Vec<ChangeOf<P>>,
}

/// A simulator of a tile has another velocity and spin: the number of the tile, of its cell there, and its place in the cell.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(crate) struct Change<V, W> {
    pub(crate) tile: u32,
    pub(crate) cell: u32,
    place: u32,
    velocity: V,
    spin: W,
}

/// A change in a physics.
pub(crate) type ChangeOf<P> = Change<VectorOf<P>, SpinOf<P>>;

/// Where a simulator is: which of the tiles at hand, and its place in it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct At {
    pub(super) tile: u32,
    pub(super) index: u32,
}

impl<'a, 'b, P: Physics, F: Follow<P::Space>> Around<'a, 'b, P, F> {
    fn new(
        grid: &'a Grid<P::Space>,
        locks: &'a [Mutex<&'b mut Tile<P, F>>],
        middle: [u32; 3],
        share: Option<&Share<P::Space>>,
    ) -> Self {
        let number = |step: usize| grid.tile_number(grid.neighbour(middle, offset(step)));
        let mut numbers: Vec<usize> = (0..OFFSETS).map(number).collect();
        numbers.sort_unstable();
        numbers.dedup();
        let mut slots = [0; OFFSETS];
        for (step, slot) in slots.iter_mut().enumerate() {
            *slot = numbers.partition_point(|&other| other < number(step)) as u8;
        }
        let seen = |&number: &usize| share.is_some_and(|share| share.is_seen(number));
        Self {
            grid,
            middle,
            slots,
            seen: numbers.iter().map(seen).collect(),
            numbers: numbers.iter().map(|&number| number as u32).collect(),
            tiles: numbers
                .into_iter()
                .map(|number| lock(&locks[number]))
                .collect(),
            changes: Vec::new(),
        }
    }

    /// What other processes are to know.
    pub(super) fn changes(self) -> Vec<ChangeOf<P>> {
        self.changes
    }

    /// The log of the tile in the middle, which is empty.
    pub(super) fn take_log(&mut self) -> Vec<Collision> {
        let middle = self.middle() as usize;
        std::mem::take(&mut self.tiles[middle].log)
    }

    /// The tile in the middle, as one of those at hand.
    pub(super) fn middle(&self) -> u32 {
        u32::from(self.slots[OFFSETS / 2])
    }

    /// The tile in the middle.
    #[inline(always)]
    pub(super) fn home(&self) -> &Tile<P, F> {
        self.tile(self.middle())
    }

    /// Which of the tiles at hand a cell belongs to, and its number there. Cells beyond the next tiles belong to none.
    #[inline]
    pub(super) fn find(&self, cell: [u32; 3]) -> Option<(u32, usize)> {
        let owner = self.grid.owner(cell);
        let step = offset_number(self.grid.tiles(), self.middle, owner)?;
        let slot = u32::from(self.slots[step]);
        Some((slot, self.tiles[slot as usize].number(cell)))
    }

    /// One of the tiles at hand.
    #[inline(always)]
    pub(super) fn tile(&self, slot: u32) -> &Tile<P, F> {
        &self.tiles[slot as usize]
    }

    /// A copy of a simulator.
    #[inline(always)]
    pub(super) fn read(&self, at: At) -> SimulatorOf<P, F> {
        self.tile(at.tile).simulators[at.index as usize]
    }

    /// Notes collisions in a cell, and their virial, where somebody wants to know.
    pub(super) fn count(&mut self, tile: u32, cell: usize, collisions: f64, virial: f64) {
        if let Some(count) = self.tiles[tile as usize].counts.get_mut(cell) {
            count.collisions += collisions;
            count.virial += virial;
        }
    }

    /// Gives a simulator another velocity and spin.
    #[inline(always)]
    pub(super) fn set(&mut self, at: At, velocity: VectorOf<P>, spin: SpinOf<P>) {
        let slot = at.tile as usize;
        let simulator = &mut self.tiles[slot].simulators[at.index as usize];
        (simulator.velocity, simulator.spin) = (velocity, spin);
        if self.seen[slot] {
            let cell = self.grid.cell_at(simulator.position);
            let tile = &self.tiles[slot];
            let cell = tile.number(cell);
            self.changes.push(Change {
                tile: self.numbers[slot],
                cell: cell as u32,
                place: at.index - tile.starts[cell],
                velocity,
                spin,
            });
        }
    }
}

impl<V: Vector, W: Copy> Change<V, W> {
    /// Makes it in the tile, if its cell is held here.
    #[inline]
    fn apply<P, F>(&self, tile: &mut Tile<P, F>)
    where
        P: Physics,
        P::Space: Space<Vector = V>,
        P::Surface: Surface<P::Space, Spin = W>,
        F: Follow<P::Space>,
    {
        let cell = self.cell as usize;
        let index = tile.starts[cell] + self.place;
        if index >= tile.starts[cell + 1] {
            return;
        }
        let simulator = &mut tile.simulators[index as usize];
        (simulator.velocity, simulator.spin) = (self.velocity, self.spin);
    }
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The colour of each tile along an axis: tiles of one colour are at least three apart around the box. Fewer than three
/// tiles get a colour each.
fn ring_colours(count: u32) -> Vec<usize> {
    let regular = if count < 3 { 0 } else { count - count % 3 };
    (0..count)
        .map(|tile| match tile {
            _ if tile < regular => tile % 3,
            _ if regular > 0 => 3 + tile - regular,
            _ => tile,
        } as usize)
        .collect()
}

/// The tiles of each colour, by their number among all.
pub(crate) fn colours<S: Space>(grid: &Grid<S>) -> Vec<Vec<u32>> {
    let counts = grid.tiles();
    let along = counts.map(ring_colours);
    let most = [0, 1, 2].map(|axis: usize| along[axis].iter().max().map_or(1, |most| most + 1));
    let mut groups = vec![Vec::new(); most.iter().product()];
    for number in 0..counts.iter().product::<u32>() {
        let at = grid.place_of(number as usize);
        let [x, y, z] = [0, 1, 2].map(|axis: usize| along[axis][at[axis] as usize]);
        groups[x + most[0] * (y + most[1] * z)].push(number);
    }
    groups
}

/// Works on every tile of this process and around it, colour after colour, and returns what the work returned with the number of the
/// tile, in that order. After each colour, processes tell each other what has changed.
pub(super) fn sweep_around<P: Physics, F: Follow<P::Space>, R: Send>(
    parallel: bool,
    grid: &Grid<P::Space>,
    tiles: &mut [Tile<P, F>],
    share: Option<&Share<P::Space>>,
    work: impl Fn(usize, Around<'_, '_, P, F>) -> (R, Vec<ChangeOf<P>>) + Sync,
) -> Vec<(u32, R)> {
    let mut results = Vec::with_capacity(tiles.len());
    let here: Vec<bool> = tiles.iter().map(|tile| tile.is_here).collect();
    let locks: Vec<Mutex<&mut Tile<P, F>>> = tiles.iter_mut().map(Mutex::new).collect();
    let one = |_, number: &u32| {
        let middle = grid.place_of(*number as usize);
        let around = Around::new(grid, &locks, middle, share);
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
    match share {
        Some(share) if PROCESSES => {
            let apply = |change: ChangeOf<P>| {
                change.apply(&mut lock(&locks[change.tile as usize]));
            };
            colour_by_colour::<P, R, _>(share, &colours, 0, &work_on, &apply, &mut results);
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

/// What work on a tile gives: its number, the result, and what other processes may have to know.
type Done<P, R> = (u32, R, Vec<ChangeOf<P>>);

/// Works on the tiles of a colour and of those that follow it. Each colour is done inside the exchange of the one before, so that
/// nobody waits for a process that has not yet taken what it was told.
fn colour_by_colour<P: Physics, R, W: Fn(&[u32]) -> Vec<Done<P, R>>>(
    share: &Share<P::Space>,
    colours: &[Vec<u32>],
    colour: usize,
    work_on: &W,
    apply: &dyn Fn(ChangeOf<P>),
    results: &mut Vec<(u32, R)>,
) {
    let Some(own) = colours.get(colour) else {
        return;
    };
    // Others wait for what they see.
    let (seen, unseen): (Vec<u32>, Vec<u32>) = own
        .iter()
        .partition(|&&number| share.tells(number as usize));
    let mut changes = Vec::new();
    for (number, result, some) in work_on(&seen) {
        results.push((number, result));
        changes.extend(some);
    }
    let mut inner = Vec::new();
    share.tell_changes::<P>(
        colour,
        &changes,
        &mut || inner = work_on(&unseen),
        &mut |elsewhere| {
            elsewhere.into_iter().for_each(apply);
            colour_by_colour::<P, R, _>(share, colours, colour + 1, work_on, apply, results);
        },
    );
    results.extend(
        inner
            .into_iter()
            .map(|(number, result, _)| (number, result)),
    );
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Tiles of one colour have no neighbour in common, for any number of tiles.
    #[test]
    fn tiles_of_one_colour_share_no_neighbour() {
        for count in 1..40_u32 {
            let colours = ring_colours(count);
            assert!(colours.iter().all(|&colour| colour < 5));
            for one in 0..count {
                for other in 0..count {
                    if one == other || colours[one as usize] != colours[other as usize] {
                        continue;
                    }
                    let apart = (one + count - other) % count;
                    assert!(apart.min(count - apart) >= 3, "{count}: {one}, {other}");
                }
            }
        }
    }
}
