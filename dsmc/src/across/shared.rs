//! Tiles that several threads work on, each around a tile of its own.
//!
//! The one place with `unsafe` in this crate. A worker at a tile reads and writes simulators of that tile and of the tiles
//! next to it, nothing else ([`Around`] refuses other tiles). Tiles of one colour are at least three apart along an axis, so
//! that no two of them have a neighbour in common: what workers of one colour touch never overlaps.

#![allow(unsafe_code, reason = "neighbouring tiles are changed through a shared list")]

use std::marker::PhantomData;

use rayon::prelude::*;
use stosszahl_model::{Physics, VectorOf};

use crate::grid::Grid;
use crate::simulator::{Follow, SimulatorOf};
use crate::tile::Tile;

/// All tiles, to be lent around tiles of one colour.
struct Shared<'a, P: Physics, F: Follow<P::Space>> {
    tiles: *mut Tile<P, F>,
    count: usize,
    owner: PhantomData<&'a mut [Tile<P, F>]>,
}

// SAFETY: tiles are plain data that may be sent to other threads; who touches which is argued above.
unsafe impl<P: Physics, F: Follow<P::Space>> Sync for Shared<'_, P, F> {}

/// A tile and those next to it.
pub(super) struct Around<'a, P: Physics, F: Follow<P::Space>> {
    shared: &'a Shared<'a, P, F>,
    /// Coordinates of the tile, and numbers of tiles along each axis.
    tile: [u32; 3],
    tiles: [u32; 3],
}

/// Where a simulator is: its tile, and its place in it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct At {
    pub(super) tile: u32,
    pub(super) index: u32,
}

impl<P: Physics, F: Follow<P::Space>> Around<'_, P, F> {
    /// Whether a tile is this one or next to it.
    pub(super) fn reaches(&self, tile: [u32; 3]) -> bool {
        (0..3).all(|axis| {
            let count = self.tiles[axis];
            let apart = (tile[axis] + count - self.tile[axis]) % count;
            apart <= 1 || apart + 1 == count
        })
    }

    fn pointer(&self, number: u32) -> *mut Tile<P, F> {
        let [columns, rows, _] = self.tiles;
        let tile = [number % columns, number / columns % rows, number / columns / rows];
        assert!(
            self.reaches(tile) && (number as usize) < self.shared.count,
            "tile {number} is not next to {:?}",
            self.tile
        );
        // SAFETY: the number is in the list.
        unsafe { self.shared.tiles.add(number as usize) }
    }

    /// A tile in reach. No simulator of it may be written while it is borrowed, which `&self` of both leaves to the caller:
    /// all borrows here end before the next write.
    pub(super) fn tile(&self, number: u32) -> &Tile<P, F> {
        // SAFETY: in reach, so that no other thread writes to it.
        unsafe { &*self.pointer(number) }
    }

    /// A copy of a simulator in reach.
    #[inline]
    pub(super) fn read(&self, at: At) -> SimulatorOf<P, F> {
        self.tile(at.tile).simulators[at.index as usize]
    }

    /// Gives a simulator in reach another velocity.
    #[inline]
    pub(super) fn set_velocity(&mut self, at: At, velocity: VectorOf<P>) {
        // SAFETY: in reach, so that no other thread reads or writes it; `&mut self` ends the borrows of this one.
        let tile = unsafe { &mut *self.pointer(at.tile) };
        tile.simulators[at.index as usize].velocity = velocity;
    }
}

/// The colour of each tile along an axis: tiles of one colour are at least three apart around the box. Fewer than three
/// tiles get a colour each.
fn colours(count: u32) -> Vec<u32> {
    let regular = if count < 3 { 0 } else { count - count % 3 };
    (0..count)
        .map(|tile| {
            if tile < regular {
                tile % 3
            } else if regular > 0 {
                3 + tile - regular
            } else {
                tile
            }
        })
        .collect()
}

/// Works on every tile and around it, colour after colour, and returns what the work returned, in that order. The order
/// does not depend on threads.
pub(super) fn sweep_around<P: Physics, F: Follow<P::Space>, R: Send>(
    parallel: bool,
    grid: &Grid<P::Space>,
    tiles: &mut [Tile<P, F>],
    work: impl Fn(usize, Around<'_, P, F>) -> R + Sync,
) -> Vec<R> {
    let counts = grid.tiles();
    let by_axis = counts.map(colours);
    let most = by_axis.each_ref().map(|axis| axis.iter().max().map_or(1, |most| most + 1));
    let mut groups = vec![Vec::new(); most.iter().product::<u32>() as usize];
    let coordinates = |number: u32| {
        let [columns, rows, _] = counts;
        [number % columns, number / columns % rows, number / columns / rows]
    };
    for number in 0..tiles.len() as u32 {
        let at = coordinates(number);
        let [x, y, z] = [0, 1, 2].map(|axis| by_axis[axis][at[axis] as usize]);
        groups[(x + most[0] * (y + most[1] * z)) as usize].push(number);
    }
    let shared = Shared {
        tiles: tiles.as_mut_ptr(),
        count: tiles.len(),
        owner: PhantomData,
    };
    let one = |number: &u32| {
        let around = Around {
            shared: &shared,
            tile: coordinates(*number),
            tiles: counts,
        };
        work(*number as usize, around)
    };
    let mut results = Vec::with_capacity(tiles.len());
    for group in &groups {
        if parallel && group.len() > 1 {
            results.par_extend(group.par_iter().map(one));
        } else {
            results.extend(group.iter().map(one));
        }
    }
    results
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Tiles of one colour have no neighbour in common, for any number of tiles.
    #[test]
    fn tiles_of_one_colour_share_no_neighbour() {
        for count in 1..40_u32 {
            let colours = colours(count);
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
