//! Subdomain of a process: the tiles of a gas that it owns, the processes that need their ghost
//! cells, and tile data in messages.

use std::sync::Arc;

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use stosszahl_model::{ParticleModel, Space};

use super::bytes::{from_bytes, to_bytes};
use super::ranks::Ranks;
use crate::cross_cell::colours;
use crate::grid::{Grid, OFFSETS, offset};
use crate::particle::{DisplacementTracking, SimulatorOf};
use crate::tally::StepBounds;
use crate::tile::Tile;

/// Subdomain of the gas that this process holds, with owners of all tiles, neighbouring processes,
/// and reduced statistics.
pub(crate) struct Subdomain<S: Space> {
    pub(crate) ranks: Arc<dyn Ranks>,
    /// Rank of the process that owns each tile.
    pub(crate) owners: Vec<u32>,
    /// Ranks of the other processes that own tiles adjacent to tiles of this process.
    pub(super) near: Vec<usize>,
    /// For each tile, the other processes that own it or read its ghost cells.
    pub(super) seers: Vec<Vec<GhostReader>>,
    /// For each tile: true if collisions in it and its neighbours can change ghost cells of another
    /// process.
    pub(super) tells: Vec<bool>,
    /// For each colour of tiles: ranks of processes to which velocity changes are sent, and from
    /// which they come.
    pub(super) colours: Vec<[Vec<usize>; 2]>,
    /// True if any process was asked to stop, as all processes know since the last time step.
    pub(crate) ends: bool,
    /// True if any process was asked to pause, as all processes know since the last time step.
    pub(crate) pauses: bool,
    /// Largest speeds and kinetic energy over all processes, as of the last time step.
    pub(crate) stock: StepBounds<S>,
    /// Number of time steps since tiles last changed owners.
    pub(super) since: u64,
    /// True while the root process holds all tiles of the gas.
    pub(crate) is_united: bool,
}

/// Process that reads ghost cells of a tile, and which cells.
pub(super) struct GhostReader {
    pub(super) rank: u32,
    /// Cells of the tile that the process reads, true or false for each; `None` for all.
    cells: Option<Vec<bool>>,
}

impl GhostReader {
    pub(super) fn sees(&self, cell: u32) -> bool {
        (self.cells.as_ref()).is_none_or(|cells| cells[cell as usize])
    }
}

/// Content of a sorted tile as sent between processes: numbers of simulators by cell, and the
/// simulators.
#[derive(Serialize, Deserialize)]
#[serde(bound = "")]
pub(crate) struct TileData<P: ParticleModel, F: DisplacementTracking<P::Space>> {
    pub(super) tile: u32,
    pub(super) counts: Vec<u32>,
    pub(super) simulators: Vec<SimulatorOf<P, F>>,
}

impl<S: Space> Subdomain<S> {
    pub(super) fn new(ranks: Arc<dyn Ranks>, tiles: usize) -> Self {
        Self {
            ranks,
            owners: vec![0; tiles],
            near: Vec::new(),
            seers: Vec::new(),
            tells: Vec::new(),
            colours: Vec::new(),
            ends: false,
            pauses: false,
            stock: StepBounds::default(),
            since: 0,
            is_united: true,
        }
    }

    pub(crate) fn me(&self) -> usize {
        self.ranks.rank()
    }

    pub(super) fn is_mine(&self, tile: usize) -> bool {
        self.owners[tile] as usize == self.me()
    }

    /// Sends one message, `to(rank)`, to each neighbouring process, and returns the messages
    /// received from them.
    pub(crate) fn with_near<T: Serialize + DeserializeOwned>(
        &self,
        mut to: impl FnMut(usize) -> T,
    ) -> Vec<T> {
        let messages = self.near.iter().map(|&rank| (rank, to_bytes(&to(rank))));
        let came = self.ranks.exchange(messages.collect(), &self.near);
        came.iter().map(|bytes| from_bytes(bytes)).collect()
    }

    /// Returns the entry of the process `rank` among those that read a tile; `None` if it does not
    /// read the tile.
    pub(super) fn seer(&self, tile: usize, rank: usize) -> Option<&GhostReader> {
        let mut seers = self.seers[tile].iter();
        seers.find(|seer| seer.rank as usize == rank)
    }

    /// Sets the owners of all tiles, and derives neighbouring processes and ghost readers. `margin`
    /// is the number of ghost cells around a tile; `None` for pairs within cells.
    pub(super) fn own(&mut self, grid: &Grid<S>, owners: Vec<u32>, margin: Option<usize>) {
        let me = self.me();
        let mut near: Vec<usize> = (0..owners.len())
            .filter(|&tile| owners[tile] as usize == me)
            .flat_map(|tile| tiles_around(grid, tile))
            .map(|tile| owners[tile] as usize)
            .filter(|&owner| owner != me)
            .collect();
        near.sort_unstable();
        near.dedup();
        (self.near, self.owners) = (near, owners);
        self.seers = (0..self.owners.len())
            .map(|tile| {
                let all = tiles_around(grid, tile).map(|other| self.owners[other]);
                let mut seers: Vec<u32> = all.filter(|&owner| owner as usize != me).collect();
                seers.sort_unstable();
                seers.dedup();
                let is_near = || tiles_around(grid, tile).any(|other| self.is_mine(other));
                let margin = margin.filter(|_| !seers.is_empty() && is_near());
                let seers = seers.into_iter().map(|rank| GhostReader {
                    rank,
                    cells: margin
                        .filter(|_| self.owners[tile] != rank)
                        .map(|margin| near_cells(grid, tile, margin, &self.owners, rank)),
                });
                seers.collect()
            })
            .collect();
        self.tells = (0..self.owners.len())
            .map(|tile| tiles_around(grid, tile).any(|other| !self.seers[other].is_empty()))
            .collect();
        let sorted = |mut list: Vec<usize>| {
            list.sort_unstable();
            list.dedup();
            list
        };
        self.colours = colours(grid)
            .iter()
            .map(|group| {
                let (mut to, mut from) = (Vec::new(), Vec::new());
                for &tile in group {
                    let owner = self.owners[tile as usize] as usize;
                    for other in tiles_around(grid, tile as usize) {
                        if owner == me {
                            to.extend(self.seers[other].iter().map(|seer| seer.rank as usize));
                        } else if tiles_around(grid, other).any(|next| self.is_mine(next)) {
                            from.push(owner);
                        }
                    }
                }
                [sorted(to), sorted(from)]
            })
            .collect();
    }
}

/// Returns the numbers of a tile and of its adjacent tiles; in narrow boxes some repeat.
pub(crate) fn tiles_around<S: Space>(
    grid: &Grid<S>,
    tile: usize,
) -> impl Iterator<Item = usize> + '_ {
    let place = grid.place_of(tile);
    (0..OFFSETS).map(move |number| grid.tile_number(grid.neighbour(place, offset(number))))
}

/// Marks the cells of a tile that are at most `margin` cells from a tile of the process `rank`.
fn near_cells<S: Space>(
    grid: &Grid<S>,
    tile: usize,
    margin: usize,
    owners: &[u32],
    rank: u32,
) -> Vec<bool> {
    let place = grid.tile_place(grid.place_of(tile));
    let sides = place.sides.map(|side| side as usize);
    let mut near = vec![false; sides.iter().product()];
    for step in (0..OFFSETS).map(offset) {
        if owners[grid.tile_number(grid.neighbour(place.tile, step))] != rank {
            continue;
        }
        let [columns, rows, layers] = [0, 1, 2].map(|axis| match step[axis] {
            -1 => 0..margin.min(sides[axis]),
            1 => sides[axis].saturating_sub(margin)..sides[axis],
            _ => 0..sides[axis],
        });
        for z in layers {
            for y in rows.clone() {
                let line = sides[0] * (y + sides[1] * z);
                near[line + columns.start..line + columns.end].fill(true);
            }
        }
    }
    near
}

impl<P: ParticleModel, F: DisplacementTracking<P::Space>> Tile<P, F> {
    pub(super) fn content(&mut self, number: usize) -> TileData<P, F> {
        TileData {
            tile: number as u32,
            counts: self.counts_of_cells(),
            simulators: std::mem::take(&mut self.simulators),
        }
    }

    /// Returns the data of those cells of the tile that another process reads.
    pub(super) fn part(&self, number: usize, seer: &GhostReader) -> TileData<P, F> {
        let mut content = TileData {
            tile: number as u32,
            counts: vec![0; self.cells()],
            simulators: Vec::new(),
        };
        for cell in (0..self.cells()).filter(|&cell| seer.sees(cell as u32)) {
            let members = self.members(cell);
            content.counts[cell] = members.len() as u32;
            content.simulators.extend_from_slice(members);
        }
        content
    }

    fn counts_of_cells(&self) -> Vec<u32> {
        self.starts
            .windows(2)
            .map(|ends| ends[1] - ends[0])
            .collect()
    }

    /// Returns the computing cost of the tile in a time step: the measured time \[s\], or an
    /// estimate before any step.
    pub(super) fn cost(&self) -> f64 {
        if self.seconds > 0.0 {
            self.seconds
        } else {
            self.guess(self.simulators.len())
        }
    }

    /// Estimates the computing cost of a tile with this number of simulators, before any time step
    /// \[s\].
    pub(super) fn guess(&self, simulators: usize) -> f64 {
        1e-9 * (simulators + self.cells()) as f64
    }

    pub(super) fn hold(&mut self, content: TileData<P, F>) {
        self.starts.clear();
        self.starts.push(0);
        let mut sum = 0;
        for count in content.counts {
            sum += count;
            self.starts.push(sum);
        }
        self.simulators = content.simulators;
    }

    /// Removes all simulators from the tile and frees their memory.
    pub(super) fn empty(&mut self) {
        self.simulators = Vec::new();
        self.codes = Vec::new();
        self.starts = Vec::new();
    }
}
