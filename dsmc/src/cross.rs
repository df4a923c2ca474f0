//! The place for schemes in which partners are in different cells, or in different tiles.
//!
//! After all tiles are arranged, [`sweep_colours`] visits each of them once together with its neighbours, so that a
//! scheme may change any simulator of a cell of the tile *and* of the cells around it, up to the far side of the next
//! tiles. Tiles are coloured so that no two of one colour share a neighbour; colours follow each other, and the
//! tiles of one are treated by all threads at once. Who collides with whom then does not depend on the number of
//! threads. It does depend on the tiles, unless a scheme takes care that the order of its cells does not matter.
//!
//! Which tile a cell belongs to and where its simulators lie is asked of [`Around`]. All of it is safe code: each
//! tile is behind a lock that is always free, because the colouring says so, and the tests say that it does.

#![cfg_attr(not(test), expect(dead_code, reason = "for schemes to come"))]

use std::sync::{Mutex, MutexGuard, PoisonError};

use rayon::prelude::*;
use stosszahl_model::Physics;

use crate::grid::{Grid, OFFSETS, offset};
use crate::simulator::{Follow, SimulatorOf};
use crate::tally::Tally;
use crate::tile::Tile;

/// A scheme that collides simulators of different cells.
pub(crate) trait CrossCell<P: Physics, F: Follow<P::Space>>: Sync {
    /// Collides all pairs whose first partner is in the tile `centre` of [`Around`], and adds what it did to the tally
    /// of that tile.
    fn collide(&self, around: &mut Around<'_, '_, P, F>);
}

/// A tile, and the tiles around it.
pub(crate) struct Around<'a, 'b, P: Physics, F: Follow<P::Space>> {
    grid: &'a Grid<P::Space>,
    /// Number of the tile in the middle.
    pub(crate) centre: usize,
    /// By their number; each once.
    tiles: Vec<(usize, MutexGuard<'a, &'b mut Tile<P, F>>)>,
}

impl<P: Physics, F: Follow<P::Space>> Around<'_, '_, P, F> {
    /// Which of the tiles at hand a cell belongs to, and where its simulators begin and end there. `None` if it is
    /// farther away than the next tile.
    pub(crate) fn find(&self, cell: [u32; 3]) -> Option<(usize, std::ops::Range<usize>)> {
        let (number, local) = self.grid.locate(cell);
        let at = self.tiles.iter().position(|(known, _)| *known == number)?;
        let starts = &self.tiles[at].1.starts;
        Some((at, starts[local] as usize..starts[local + 1] as usize))
    }

    /// The simulators of a cell.
    pub(crate) fn members(&self, cell: [u32; 3]) -> Option<&[SimulatorOf<P, F>]> {
        let (at, range) = self.find(cell)?;
        self.tiles[at].1.simulators.get(range)
    }

    /// Two different simulators, each by its tile at hand and its place there, as [`Self::find`] tells them.
    pub(crate) fn pair(
        &mut self,
        first: (usize, usize),
        second: (usize, usize),
    ) -> Option<[&mut SimulatorOf<P, F>; 2]> {
        if first.0 == second.0 {
            let tile = &mut self.tiles.get_mut(first.0)?.1;
            return tile.simulators.get_disjoint_mut([first.1, second.1]).ok();
        }
        let [one, other] = self.tiles.get_disjoint_mut([first.0, second.0]).ok()?;
        Some([
            one.1.simulators.get_mut(first.1)?,
            other.1.simulators.get_mut(second.1)?,
        ])
    }

    /// The cells of the tile in the middle, by their coordinates.
    pub(crate) fn cells(&self) -> impl Iterator<Item = [u32; 3]> + use<P, F> {
        let centre = self.tiles.iter().find(|(known, _)| *known == self.centre);
        let (first, sides) = centre.map_or(([0; 3], [0; 3]), |(_, tile)| {
            (tile.place.first, tile.place.sides)
        });
        (0..sides[2]).flat_map(move |z| {
            (0..sides[1]).flat_map(move |y| {
                (0..sides[0]).map(move |x| [first[0] + x, first[1] + y, first[2] + z])
            })
        })
    }

    /// Where the tile in the middle counts what was done.
    pub(crate) fn tally(&mut self) -> Option<&mut Tally> {
        let centre = self.centre;
        let known = |(number, _): &&mut (usize, _)| *number == centre;
        self.tiles
            .iter_mut()
            .find(known)
            .map(|(_, tile)| &mut tile.tally)
    }
}

/// Lets a scheme visit each tile once, with its neighbours.
pub(crate) fn sweep_colours<P: Physics, F: Follow<P::Space>>(
    parallel: bool,
    grid: &Grid<P::Space>,
    tiles: &mut [Tile<P, F>],
    scheme: &impl CrossCell<P, F>,
) {
    let locks: Vec<Mutex<&mut Tile<P, F>>> = tiles.iter_mut().map(Mutex::new).collect();
    let visit = |tile: &[u32; 3]| {
        scheme.collide(&mut Around {
            grid,
            centre: grid.tile_number(*tile),
            // Never waits: no other tile of this colour has one of these next to it.
            tiles: neighbourhood(grid, *tile)
                .into_iter()
                .map(|number| {
                    let lock = &locks[number];
                    (number, lock.lock().unwrap_or_else(PoisonError::into_inner))
                })
                .collect(),
        });
    };
    for colour in colours(grid.tiles()) {
        if parallel {
            colour.par_iter().for_each(visit);
        } else {
            colour.iter().for_each(visit);
        }
    }
}

/// The numbers of a tile and of its neighbours, each once, ascending.
fn neighbourhood<S: stosszahl_model::Space>(grid: &Grid<S>, tile: [u32; 3]) -> Vec<usize> {
    let mut numbers: Vec<usize> = (0..OFFSETS)
        .map(|number| grid.tile_number(grid.neighbour(tile, offset(number))))
        .collect();
    numbers.sort_unstable();
    numbers.dedup();
    numbers
}

/// The tiles of each colour, for `tiles` tiles along each axis of a periodic box.
fn colours(tiles: [u32; 3]) -> Vec<Vec<[u32; 3]>> {
    let along = tiles.map(ring_colours);
    let number = |axis: usize| along[axis].iter().max().map_or(1, |most| most + 1);
    let mut classes = vec![Vec::new(); number(0) * number(1) * number(2)];
    for z in 0..tiles[2] {
        for y in 0..tiles[1] {
            for x in 0..tiles[0] {
                let [i, j, k] = [
                    along[0][x as usize],
                    along[1][y as usize],
                    along[2][z as usize],
                ];
                classes[i + number(0) * (j + number(1) * k)].push([x, y, z]);
            }
        }
    }
    classes
}

/// Colours on a ring of `count`, of which equal ones are at least three apart: groups of three, and of four for what
/// is left. Rings of up to five have as many colours as tiles.
fn ring_colours(count: u32) -> Vec<usize> {
    let count = count as usize;
    if count <= 5 {
        return (0..count).collect();
    }
    let (fours, threes) = (count % 3, count / 3 - count % 3);
    let groups = [vec![3; threes], vec![4; fours]].concat();
    groups.into_iter().flat_map(|length| 0..length).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulator::{Simulator, Unfollowed};
    use nalgebra::{Vector2, vector};
    use stosszahl_model::{Constant, Domain, Free, Monodisperse, Plane, Scene, Smooth};

    #[test]
    fn equal_colours_on_a_ring_are_three_apart() {
        for count in 1..200 {
            let colours = ring_colours(count);
            assert_eq!(colours.len(), count as usize);
            assert!(colours.iter().max() < Some(&5));
            for (i, first) in colours.iter().enumerate() {
                for (j, second) in colours.iter().enumerate().skip(i + 1) {
                    let apart = (j - i).min(colours.len() - (j - i));
                    assert!(first != second || apart >= 3, "{count}: {i} and {j}");
                }
            }
        }
    }

    /// No two tiles of a colour share a neighbour, and each tile has one colour; for all small boxes.
    #[test]
    fn tiles_of_a_colour_share_no_neighbour() {
        for (nx, ny) in (1..13).flat_map(|nx| (1..13).map(move |ny| (nx, ny))) {
            let domain = Domain::<Plane>::periodic(vector![1.0, 1.0]).expect("a box");
            let grid = Grid::new(domain, [nx, ny, 1], nx * ny, 1);
            assert_eq!(grid.tiles(), [nx as u32, ny as u32, 1]);
            let mut all = Vec::new();
            for colour in colours(grid.tiles()) {
                let mut taken = Vec::new();
                for tile in &colour {
                    let near = neighbourhood(&grid, *tile);
                    assert!(near.iter().all(|number| !taken.contains(number)));
                    taken.extend(near);
                    all.push(grid.tile_number(*tile));
                }
            }
            all.sort_unstable();
            assert!(all.into_iter().eq(0..nx * ny), "{nx} by {ny}");
        }
    }

    type Disks = Scene<Plane, Smooth, Constant, Monodisperse, Free>;

    /// Exchanges the velocity of each first member with that of the first member of the next cell up and right.
    struct Exchange {
        counts: [u32; 3],
    }

    impl CrossCell<Disks, Unfollowed> for Exchange {
        fn collide(&self, around: &mut Around<'_, '_, Disks, Unfollowed>) {
            for cell in around.cells() {
                let next = [
                    (cell[0] + 1) % self.counts[0],
                    (cell[1] + 1) % self.counts[1],
                    0,
                ];
                let ((at, range), (to, other)) = around
                    .find(cell)
                    .zip(around.find(next))
                    .expect("a neighbour");
                assert_eq!(around.members(cell).expect("here").len(), range.len());
                if let Some([a, b]) = around.pair((at, range.start), (to, other.start)) {
                    std::mem::swap(&mut a.velocity, &mut b.velocity);
                }
                around.tally().expect("the tile").trials += 1;
            }
        }
    }

    #[test]
    fn all_cells_are_visited_once_with_any_number_of_threads() {
        let side = 12_usize;
        let domain = Domain::<Plane>::periodic(vector![12.0, 12.0]).expect("a box");
        let grid = Grid::new(domain, [side, side, 1], side * side, 4);
        let run = |threads: usize| {
            let mut tiles: Vec<Tile<Disks, Unfollowed>> =
                grid.places().into_iter().map(Tile::new).collect();
            for tile in &mut tiles {
                let place = tile.place;
                let members: Vec<_> = (0..tile.cells() as u32)
                    .map(|cell| {
                        let x = place.first[0] + cell % place.sides[0];
                        let y = place.first[1] + cell / place.sides[0];
                        let simulator = Simulator {
                            position: vector![f64::from(x) + 0.5, f64::from(y) + 0.5],
                            velocity: vector![f64::from(grid.number([x, y, 0])), 0.0],
                            tag: (),
                            mark: (),
                        };
                        (cell as u16, simulator)
                    })
                    .collect();
                tile.take(&members);
            }
            let pool = rayon::ThreadPoolBuilder::new()
                .num_threads(threads)
                .build()
                .expect("threads");
            let scheme = Exchange {
                counts: grid.counts(),
            };
            pool.install(|| sweep_colours(threads > 1, &grid, &mut tiles, &scheme));
            let visits: u64 = tiles.iter().map(|tile| tile.tally.trials).sum();
            assert_eq!(visits, 144);
            let all = tiles.iter().flat_map(|tile| &tile.simulators);
            all.map(|simulator| simulator.velocity)
                .collect::<Vec<Vector2<f64>>>()
        };
        let alone = run(1);
        assert_eq!(alone, run(2));
        assert_eq!(alone, run(3));
        // Nothing was lost.
        let mut numbers: Vec<u32> = alone.iter().map(|v| v[0] as u32).collect();
        numbers.sort_unstable();
        assert!(numbers.into_iter().eq(0..144));
    }
}
