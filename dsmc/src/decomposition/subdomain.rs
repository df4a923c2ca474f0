//! Subdomain: the tiles of a gas that one process holds, and the processes that read their ghost
//! cells.

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

/// Subdomain of the gas that this process holds.
pub(crate) struct Subdomain<S: Space> {
    pub(crate) ranks: Arc<dyn Ranks>,
    /// Owner of each tile, by rank.
    pub(crate) owners: Vec<u32>,
    /// Ranks of the processes with tiles adjacent to own tiles.
    pub(super) near: Vec<usize>,
    /// Other processes that read each tile: its owner, and the owners of adjacent tiles.
    pub(super) seers: Vec<Vec<GhostReader>>,
    /// For each tile: true if collisions around it change ghost cells of another process.
    pub(super) tells: Vec<bool>,
    /// For each colour of tiles: ranks that may need changes, and ranks that may send some.
    pub(super) colours: Vec<[Vec<usize>; 2]>,
    /// True if any process was asked to stop, as all know since the last step.
    pub(crate) ends: bool,
    /// True if any process was asked to pause, as all know since the last step.
    pub(crate) pauses: bool,
    /// Largest speeds and energy over all processes, since the last exchange.
    pub(crate) stock: StepBounds<S>,
    /// Number of steps since tiles changed owners.
    pub(super) since: u64,
    /// True if the root process holds all tiles for the time being.
    pub(crate) is_united: bool,
}

/// A process that holds ghost cells of this tile.
pub(super) struct GhostReader {
    pub(super) rank: u32,
    /// Cells of the tile that the process reads; `None` for all.
    cells: Option<Vec<bool>>,
}

impl GhostReader {
    pub(super) fn sees(&self, cell: u32) -> bool {
        (self.cells.as_ref()).is_none_or(|cells| cells[cell as usize])
    }
}

/// Contents of a sorted tile: particle numbers by cell, and simulators.
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

    /// Exchanges one message with each neighbour process, and returns the messages received.
    pub(crate) fn with_near<T: Serialize + DeserializeOwned>(
        &self,
        mut to: impl FnMut(usize) -> T,
    ) -> Vec<T> {
        let messages = self.near.iter().map(|&rank| (rank, to_bytes(&to(rank))));
        let came = self.ranks.exchange(messages.collect(), &self.near);
        came.iter().map(|bytes| from_bytes(bytes)).collect()
    }

    /// Reader of a tile with this rank, if that process reads it.
    pub(super) fn seer(&self, tile: usize, rank: usize) -> Option<&GhostReader> {
        let mut seers = self.seers[tile].iter();
        seers.find(|seer| seer.rank as usize == rank)
    }

    /// Sets new owners. `margin`: number of ghost cells around a tile, for cross-cell schemes.
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

/// Numbers of a tile and its neighbours.
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

    /// Contents of the cells that another process reads.
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

    /// Cost of the tile: measured time \[s\], or an estimate before any step.
    pub(super) fn cost(&self) -> f64 {
        if self.seconds > 0.0 {
            self.seconds
        } else {
            self.guess(self.simulators.len())
        }
    }

    /// Estimated cost of a tile with this number of simulators, before any step \[s\].
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

    /// Drops all simulators.
    pub(super) fn empty(&mut self) {
        self.simulators = Vec::new();
        self.codes = Vec::new();
        self.starts = Vec::new();
    }
}
