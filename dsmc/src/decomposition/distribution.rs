//! Distribution of the tiles of a gas among processes: scatter, load balancing, and gather in the
//! root process.

use std::sync::Arc;

use serde::{Deserialize, Serialize};
use stosszahl_model::ParticleModel;

use super::bytes::{from_bytes, to_bytes};
use super::owners;
use super::ranks::{Ranks, all_gather, broadcast, gather};
use super::subdomain::{Subdomain, TileData};
use crate::checkpoint::DsmcCheckpoint;
use crate::cross_cell::margin;
use crate::engine::{Constants, DsmcEngine};
use crate::features::PROCESSES;
use crate::particle::DisplacementTracking;
use crate::tile::{SendBuffer, Tile};

/// Load imbalance above which tiles change owners: largest over mean cost of a process.
const UNEVEN: f64 = 1.1;
/// Least number of time steps between two redistributions of tiles among processes.
pub(super) const STEPS_BETWEEN: u64 = 50;

/// State of the gas without its simulators, and the owner of each tile: broadcast by the root
/// process before tiles are scattered.
#[derive(Serialize, Deserialize)]
#[serde(bound = "")]
struct GasHeader<P: ParticleModel, F: DisplacementTracking<P::Space>> {
    gas: DsmcCheckpoint<P, F>,
    simulators: usize,
    owners: Vec<u32>,
}

impl<P: ParticleModel, F: DisplacementTracking<P::Space>> DsmcEngine<P, F> {
    /// Declares that several processes, `ranks`, hold the gas. Each has made the engine from the
    /// same arguments; the root process holds all tiles until [`Self::scatter_tiles`].
    pub fn distribute_among(&mut self, ranks: Arc<dyn Ranks>) {
        self.share = Some(Subdomain::new(ranks, self.tiles.len()));
    }

    /// Returns true if this process holds all tiles of the gas.
    pub fn is_whole(&self) -> bool {
        self.share.as_ref().is_none_or(|share| share.is_united)
    }

    /// Returns the number of ghost cells that collisions need on each side of a tile; `None` for
    /// schemes with pairs within cells.
    pub(super) fn margin(&self) -> Option<usize> {
        let Constants {
            mean_radius,
            partner_radius,
            ..
        } = self.constants;
        let scheme = self.parameters.scheme;
        let is_across = scheme.is_cross_cell();
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

    /// Sends each tile from the root process to the process that owns it. All processes must call
    /// it; does nothing if tiles are scattered already.
    pub fn scatter_tiles(&mut self) {
        if !PROCESSES {
            return;
        }
        let Some(mut share) = self.share.take_if(|share| share.is_united) else {
            return;
        };
        let ranks = share.ranks.clone();
        let header = (share.me() == 0).then(|| {
            let costs: Vec<f64> = self.tiles.iter().map(Tile::cost).collect();
            GasHeader {
                gas: self.without_simulators(),
                simulators: self.simulators,
                owners: owners::bisect(self.grid.tiles(), &costs, ranks.size()),
            }
        });
        let bytes = header.map_or_else(Vec::new, |header| to_bytes(&header));
        let header: GasHeader<P, F> = from_bytes(&broadcast(&*ranks, bytes));
        self.take_over(header.gas);
        self.simulators = header.simulators;
        share.own(&self.grid, header.owners, self.margin());
        let others: Vec<usize> = (1..ranks.size()).collect();
        let came = if share.me() == 0 {
            let messages = others.iter().map(|&rank| {
                let own = self.tiles.iter_mut().enumerate();
                let own = own.filter(|(number, _)| share.owners[*number] as usize == rank);
                let contents: Vec<_> = own.map(|(number, tile)| tile.content(number)).collect();
                (rank, to_bytes(&contents))
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
            .flat_map(|bytes| from_bytes::<Vec<TileData<P, F>>>(bytes))
        {
            self.tiles[content.tile as usize].hold(content);
        }
        self.share = Some(share);
    }

    /// Divides the tiles among the processes by the number of simulators in each, before any of them
    /// are there.
    pub(super) fn divide(&mut self, share: &mut Subdomain<P::Space>, counts: &[usize]) {
        self.simulators = counts.iter().sum();
        let tiles = self.tiles.iter().zip(counts);
        let costs: Vec<f64> = tiles.map(|(tile, &count)| tile.guess(count)).collect();
        let owners = owners::bisect(self.grid.tiles(), &costs, share.ranks.size());
        share.own(&self.grid, owners, self.margin());
        self.part_with(share);
    }

    /// Empties the tiles that other processes own, and restarts the measurement of costs.
    pub(super) fn part_with(&mut self, share: &mut Subdomain<P::Space>) {
        for (number, tile) in self.tiles.iter_mut().enumerate() {
            tile.is_here = share.is_mine(number);
            if !tile.is_here {
                tile.empty();
            }
            tile.seconds = 0.0;
        }
        for outbox in self.departing.iter_mut().chain(&mut self.arriving) {
            *outbox = SendBuffer::default();
        }
        (share.is_united, share.since) = (false, 0);
    }

    /// Collects all tiles, sorted, in the root process. All processes must call it; does nothing if
    /// the root process holds them already.
    pub fn gather_tiles(&mut self) {
        let Some(mut share) = self.share.take_if(|share| !share.is_united) else {
            return;
        };
        let own = self.tiles.iter_mut().enumerate();
        let own = own.filter(|(_, tile)| tile.is_here && share.me() > 0);
        let contents: Vec<_> = own.map(|(number, tile)| tile.content(number)).collect();
        let came = gather(&*share.ranks, to_bytes(&contents));
        for content in came
            .iter()
            .skip(1)
            .flat_map(|bytes| from_bytes::<Vec<TileData<P, F>>>(bytes))
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

    /// Balances the load: moves tiles between processes if their measured costs differ much and
    /// enough steps have passed.
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

    fn even_out(&mut self, share: &mut Subdomain<P::Space>) {
        let ranks = share.ranks.clone();
        let own = self.tiles.iter_mut().enumerate();
        let own = own.filter(|(_, tile)| tile.is_here);
        let seconds: Vec<(u32, f64)> = own
            .map(|(number, tile)| (number as u32, std::mem::take(&mut tile.seconds)))
            .collect();
        let all = all_gather(&*ranks, to_bytes(&seconds));
        let mut costs = vec![0.0; self.tiles.len()];
        let mut sums = Vec::new();
        for bytes in &all {
            let some: Vec<(u32, f64)> = from_bytes(bytes);
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
        // The gain must be worth the move.
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
            (rank, to_bytes(&contents))
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
            .flat_map(|bytes| from_bytes::<Vec<TileData<P, F>>>(bytes))
        {
            self.tiles[content.tile as usize].hold(content);
        }
    }
}
