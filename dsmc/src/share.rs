//! One gas that several processes hold: who holds which tiles, and what they tell each other.
//!
//! The box is cut into blocks of tiles, one for each process ([`owners`]). A tile is treated by its owner as if there were nobody
//! else; what leaves it for a tile of another process goes there after the flight. Random streams are addressed by step and
//! cell, the order within cells is that of the cells they came from, and sums do not depend on the order of
//! adding. So a gas has the same bytes for any number of processes, one included.
//!
//! In each step a process sends ([`flights`]): what crosses its borders, to its neighbours; and to all the stock
//! that the next step follows, what was counted, and who flew farther than to the next tile. What it sends where
//! partners are sought across cells is in [`partners`].

mod flights;
mod owners;
mod partners;
mod ranks;
mod shards;

use std::sync::Arc;

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use stosszahl_model::{Physics, Space};

use crate::across::margin;
use crate::across::shared::colours;
use crate::engine::{Constants, Engine};
use crate::grid::{Grid, OFFSETS, offset};
use crate::simulator::{Follow, SimulatorOf};
use crate::start::Checkpoint;
use crate::tally::Stock;
use crate::tile::{Outbox, Tile};

pub(crate) use partners::see_no_more;
pub use ranks::{Ranks, all_gather as gather_from_all, broadcast as from_first};
pub(crate) use ranks::{all_gather, all_reduce, broadcast, gather, reduce};
pub use shards::{Beside, shard_name};
pub(crate) use shards::{Shard, read_all};

/// How much dearer the dearest process may be than the mean before tiles change hands, and fewest steps between.
const UNEVEN: f64 = 1.1;
const STEPS_BETWEEN: u64 = 50;

/// Whether a gas may be held by several processes. Where that is left out, what is done only then is not compiled, for each engine anew.
pub(crate) const PROCESSES: bool = cfg!(feature = "processes");

/// The part of a gas that this process holds.
pub(crate) struct Share<S: Space> {
    pub(crate) ranks: Arc<dyn Ranks>,
    /// The owner of each tile.
    pub(crate) owners: Vec<u32>,
    /// Other processes with tiles next to own ones.
    near: Vec<usize>,
    /// Which other processes see each tile: its owner, and those with tiles next to it.
    seers: Vec<Vec<Seer>>,
    /// Of which tiles work around them changes what another process sees.
    tells: Vec<bool>,
    /// For each colour of tiles: to whom changes may have to be told, and who may tell some.
    colours: Vec<[Vec<usize>; 2]>,
    /// Whether any process was asked to stop, or to pause, as all know it since the last step.
    pub(crate) ends: bool,
    pub(crate) pauses: bool,
    /// Of all processes, since the last exchange.
    pub(crate) stock: Stock<S>,
    /// Steps since tiles changed hands.
    since: u64,
    /// Whether the first process holds all tiles for a while.
    pub(crate) is_united: bool,
}

/// A process that sees a tile of another.
struct Seer {
    rank: u32,
    /// Which cells of it; all, if nothing is said.
    cells: Option<Vec<bool>>,
}

impl Seer {
    fn sees(&self, cell: u32) -> bool {
        (self.cells.as_ref()).is_none_or(|cells| cells[cell as usize])
    }
}

/// What an arranged tile holds.
#[derive(Serialize, Deserialize)]
#[serde(bound = "")]
pub(crate) struct Content<P: Physics, F: Follow<P::Space>> {
    tile: u32,
    counts: Vec<u32>,
    simulators: Vec<SimulatorOf<P, F>>,
}

/// A value as bytes.
pub(crate) fn write<T: Serialize>(value: &T) -> Vec<u8> {
    postcard::to_stdvec(value).expect("all types here have a length")
}

/// A value from the bytes that another process wrote.
///
/// # Panics
/// If they are of another program, which is an error of whoever connects the processes.
pub(crate) fn read<T: DeserializeOwned>(bytes: &[u8]) -> T {
    postcard::from_bytes(bytes).expect("the bytes of the same program")
}

impl<S: Space> Share<S> {
    fn new(ranks: Arc<dyn Ranks>, tiles: usize) -> Self {
        Self {
            ranks,
            owners: vec![0; tiles],
            near: Vec::new(),
            seers: Vec::new(),
            tells: Vec::new(),
            colours: Vec::new(),
            ends: false,
            pauses: false,
            stock: Stock::default(),
            since: 0,
            is_united: true,
        }
    }

    pub(crate) fn me(&self) -> usize {
        self.ranks.rank()
    }

    fn is_mine(&self, tile: usize) -> bool {
        self.owners[tile] as usize == self.me()
    }

    /// Sends to each near process what belongs to it, and returns what came.
    pub(crate) fn with_near<T: Serialize + DeserializeOwned>(
        &self,
        mut to: impl FnMut(usize) -> T,
    ) -> Vec<T> {
        let messages = self.near.iter().map(|&rank| (rank, write(&to(rank))));
        let came = self.ranks.exchange(messages.collect(), &self.near);
        came.iter().map(|bytes| read(bytes)).collect()
    }

    /// Which process that is not this one sees a tile, if that one does.
    fn seer(&self, tile: usize, rank: usize) -> Option<&Seer> {
        let mut seers = self.seers[tile].iter();
        seers.find(|seer| seer.rank as usize == rank)
    }

    /// Notes new owners. Work on a tile looks at cells at most `margin` cells from it.
    fn own(&mut self, grid: &Grid<S>, owners: Vec<u32>, margin: Option<usize>) {
        let me = self.me();
        let mut near: Vec<usize> = (0..owners.len())
            .filter(|&tile| owners[tile] as usize == me)
            .flat_map(|tile| around(grid, tile))
            .map(|tile| owners[tile] as usize)
            .filter(|&owner| owner != me)
            .collect();
        near.sort_unstable();
        near.dedup();
        (self.near, self.owners) = (near, owners);
        self.seers = (0..self.owners.len())
            .map(|tile| {
                let all = around(grid, tile).map(|other| self.owners[other]);
                let mut seers: Vec<u32> = all.filter(|&owner| owner as usize != me).collect();
                seers.sort_unstable();
                seers.dedup();
                let is_near = || around(grid, tile).any(|other| self.is_mine(other));
                let margin = margin.filter(|_| !seers.is_empty() && is_near());
                let seers = seers.into_iter().map(|rank| Seer {
                    rank,
                    cells: margin
                        .filter(|_| self.owners[tile] != rank)
                        .map(|margin| near_cells(grid, tile, margin, &self.owners, rank)),
                });
                seers.collect()
            })
            .collect();
        self.tells = (0..self.owners.len())
            .map(|tile| around(grid, tile).any(|other| !self.seers[other].is_empty()))
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
                    for other in around(grid, tile as usize) {
                        if owner == me {
                            to.extend(self.seers[other].iter().map(|seer| seer.rank as usize));
                        } else if around(grid, other).any(|next| self.is_mine(next)) {
                            from.push(owner);
                        }
                    }
                }
                [sorted(to), sorted(from)]
            })
            .collect();
    }
}

/// A tile and those next to it.
pub(crate) fn around<S: Space>(grid: &Grid<S>, tile: usize) -> impl Iterator<Item = usize> + '_ {
    let place = grid.place_of(tile);
    (0..OFFSETS).map(move |number| grid.tile_number(grid.neighbour(place, offset(number))))
}

/// The cells of a tile that are at most `margin` cells from a tile of a process.
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

impl<P: Physics, F: Follow<P::Space>> Tile<P, F> {
    fn content(&mut self, number: usize) -> Content<P, F> {
        Content {
            tile: number as u32,
            counts: self.counts_of_cells(),
            simulators: std::mem::take(&mut self.simulators),
        }
    }

    /// Some of its cells.
    fn part(&self, number: usize, seer: &Seer) -> Content<P, F> {
        let mut content = Content {
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

    /// What it costs, about: how long it took, or how much there is.
    fn cost(&self) -> f64 {
        if self.seconds > 0.0 {
            self.seconds
        } else {
            self.guess(self.simulators.len())
        }
    }

    /// The same of so many simulators, before any step.
    fn guess(&self, simulators: usize) -> f64 {
        1e-9 * (simulators + self.cells()) as f64
    }

    fn hold(&mut self, content: Content<P, F>) {
        self.starts.clear();
        self.starts.push(0);
        let mut sum = 0;
        for count in content.counts {
            sum += count;
            self.starts.push(sum);
        }
        self.simulators = content.simulators;
    }

    /// Lets go of all simulators.
    fn empty(&mut self) {
        self.simulators = Vec::new();
        self.codes = Vec::new();
        self.starts = Vec::new();
    }
}

/// All that processes need to know of the gas besides its simulators, and who holds what.
#[derive(Serialize, Deserialize)]
#[serde(bound = "")]
struct Brief<P: Physics, F: Follow<P::Space>> {
    gas: Checkpoint<P, F>,
    simulators: usize,
    owners: Vec<u32>,
}

impl<P: Physics, F: Follow<P::Space>> Engine<P, F> {
    /// From now on several processes hold the gas, which they have made of the same scene, parameters and boundaries. What counts
    /// is the gas of the first; it holds all until [`Self::divide`].
    pub fn share(&mut self, ranks: Arc<dyn Ranks>) {
        self.share = Some(Share::new(ranks, self.tiles.len()));
    }

    /// Whether this process holds all of the gas.
    pub fn is_whole(&self) -> bool {
        self.share.as_ref().is_none_or(|share| share.is_united)
    }

    /// How many cells from a tile work on it looks at, at most, where partners are sought across cells.
    fn margin(&self) -> Option<usize> {
        let Constants {
            mean_radius,
            partner_radius,
            ..
        } = self.constants;
        let scheme = self.parameters.scheme;
        let is_across = scheme.is_across();
        is_across.then(|| {
            margin::<P>(
                scheme,
                &self.grid,
                self.scene.sizes(),
                mean_radius,
                partner_radius,
            )
        })
    }

    /// Gives each process its tiles; all of them call it. Nothing happens if they have them.
    pub fn divide(&mut self) {
        if !PROCESSES {
            return;
        }
        let Some(mut share) = self.share.take_if(|share| share.is_united) else {
            return;
        };
        let ranks = share.ranks.clone();
        let brief = (share.me() == 0).then(|| {
            let costs: Vec<f64> = self.tiles.iter().map(Tile::cost).collect();
            Brief {
                gas: self.without_simulators(),
                simulators: self.simulators,
                owners: owners::bisect(self.grid.tiles(), &costs, ranks.size()),
            }
        });
        let bytes = brief.map_or_else(Vec::new, |brief| write(&brief));
        let brief: Brief<P, F> = read(&broadcast(&*ranks, bytes));
        self.take_over(brief.gas);
        self.simulators = brief.simulators;
        share.own(&self.grid, brief.owners, self.margin());
        let others: Vec<usize> = (1..ranks.size()).collect();
        let came = if share.me() == 0 {
            let messages = others.iter().map(|&rank| {
                let own = self.tiles.iter_mut().enumerate();
                let own = own.filter(|(number, _)| share.owners[*number] as usize == rank);
                let contents: Vec<_> = own.map(|(number, tile)| tile.content(number)).collect();
                (rank, write(&contents))
            });
            let messages = messages.collect();
            ranks.exchange(messages, &[]);
            Vec::new()
        } else {
            ranks.exchange(Vec::new(), &[0])
        };
        self.part_with(&mut share);
        for content in came
            .iter()
            .flat_map(|bytes| read::<Vec<Content<P, F>>>(bytes))
        {
            self.tiles[content.tile as usize].hold(content);
        }
        self.share = Some(share);
    }

    /// Keeps nothing of the tiles of others, and none of the times that tiles took.
    fn part_with(&mut self, share: &mut Share<P::Space>) {
        for (number, tile) in self.tiles.iter_mut().enumerate() {
            tile.is_here = share.is_mine(number);
            if !tile.is_here {
                tile.empty();
            }
            tile.seconds = 0.0;
        }
        for outbox in self.departing.iter_mut().chain(&mut self.arriving) {
            *outbox = Outbox::default();
        }
        (share.is_united, share.since) = (false, 0);
    }

    /// Gives the first process all tiles, arranged; all processes call it. Nothing happens if it has them.
    pub fn unite(&mut self) {
        let Some(mut share) = self.share.take_if(|share| !share.is_united) else {
            return;
        };
        let own = self.tiles.iter_mut().enumerate();
        let own = own.filter(|(_, tile)| tile.is_here && share.me() > 0);
        let contents: Vec<_> = own.map(|(number, tile)| tile.content(number)).collect();
        let came = gather(&*share.ranks, write(&contents));
        for content in came
            .iter()
            .skip(1)
            .flat_map(|bytes| read::<Vec<Content<P, F>>>(bytes))
        {
            self.tiles[content.tile as usize].hold(content);
        }
        for tile in &mut self.tiles {
            tile.is_here = share.me() == 0;
            if !tile.is_here {
                tile.empty();
            }
        }
        share.is_united = true;
        self.share = Some(share);
    }

    /// Lets tiles change hands where one process has much more to do than others, by the time that tiles took.
    pub(crate) fn balance(&mut self) {
        if !PROCESSES {
            return;
        }
        let Some(mut share) = self.share.take() else {
            return;
        };
        if share.since >= STEPS_BETWEEN && !share.is_united {
            share.since = 0;
            self.even_out(&mut share);
        }
        self.share = Some(share);
    }

    fn even_out(&mut self, share: &mut Share<P::Space>) {
        let ranks = share.ranks.clone();
        let own = self.tiles.iter_mut().enumerate();
        let own = own.filter(|(_, tile)| tile.is_here);
        let seconds: Vec<(u32, f64)> = own
            .map(|(number, tile)| (number as u32, std::mem::take(&mut tile.seconds)))
            .collect();
        let all = all_gather(&*ranks, write(&seconds));
        let mut costs = vec![0.0; self.tiles.len()];
        let mut sums = Vec::new();
        for bytes in &all {
            let some: Vec<(u32, f64)> = read(bytes);
            sums.push(some.iter().map(|one| one.1).sum::<f64>());
            for (number, seconds) in some {
                costs[number as usize] = seconds;
            }
        }
        let mean = sums.iter().sum::<f64>() / ranks.size() as f64;
        let largest = |sums: &[f64]| sums.iter().copied().fold(0.0, f64::max);
        let owners = owners::bisect(self.grid.tiles(), &costs, ranks.size());
        let mut better = vec![0.0; ranks.size()];
        for (&owner, cost) in owners.iter().zip(&costs) {
            better[owner as usize] += cost;
        }
        // What is gained must be worth the move.
        if largest(&sums) <= UNEVEN * mean || 1.05 * largest(&better) > largest(&sums) {
            return;
        }
        let others: Vec<usize> = (0..ranks.size())
            .filter(|&rank| rank != share.me())
            .collect();
        let moving = |number: usize, rank: usize| owners[number] as usize == rank;
        let messages = others.iter().map(|&rank| {
            let own = self.tiles.iter_mut().enumerate();
            let own = own.filter(|(number, tile)| tile.is_here && moving(*number, rank));
            let contents: Vec<_> = own.map(|(number, tile)| tile.content(number)).collect();
            (rank, write(&contents))
        });
        let came = ranks.exchange(messages.collect(), &others);
        share.own(&self.grid, owners, self.margin());
        for (number, tile) in self.tiles.iter_mut().enumerate() {
            tile.is_here = share.is_mine(number);
            if !tile.is_here {
                tile.empty();
            }
        }
        for content in came
            .iter()
            .flat_map(|bytes| read::<Vec<Content<P, F>>>(bytes))
        {
            self.tiles[content.tile as usize].hold(content);
        }
    }
}

#[cfg(test)]
mod tests;
