//! Migration of simulators between processes, and global reductions of statistics and counters,
//! after each free-flight phase.

use serde::{Deserialize, Serialize};
use stosszahl_model::{Collision, ParticleModel};

use super::bytes::{from_bytes, to_bytes};
use super::ranks::all_reduce;
use super::subdomain::Subdomain;
use crate::engine::DsmcEngine;
use crate::features::PROCESSES;
use crate::grid::{OFFSETS, offset};
use crate::particle::{DisplacementTracking, SimulatorOf};
use crate::tally::{StepBounds, StepCounters};
use crate::tile::{DepartedSimulator, Migrant};

/// Message from one process to a neighbouring process after a free-flight phase: migrating
/// simulators and collision logs.
#[derive(Serialize, Deserialize)]
#[serde(bound = "")]
struct Sent<P: ParticleModel, F: DisplacementTracking<P::Space>> {
    leaving: Vec<Leaving<P, F>>,
    /// Logged collisions of the sender's tiles, for observers in the root process, with tile
    /// numbers.
    logs: Vec<(u32, Vec<Collision>)>,
}

/// Simulator that migrates to another process: its old tile, the offset to the adjacent tile it
/// enters, and the cell it started from.
#[derive(Serialize, Deserialize)]
#[serde(bound = "")]
struct Leaving<P: ParticleModel, F: DisplacementTracking<P::Space>> {
    tile: u32,
    offset: u8,
    source: u32,
    simulator: SimulatorOf<P, F>,
}

/// Data that all processes reduce in each time step: statistics, counters, stop flags, and
/// simulators that flew beyond adjacent tiles.
#[derive(Serialize, Deserialize)]
#[serde(bound = "")]
struct News<P: ParticleModel, F: DisplacementTracking<P::Space>> {
    stock: StepBounds<P::Space>,
    simulators: usize,
    ends: bool,
    pauses: bool,
    /// Simulators that flew beyond adjacent tiles, with target tile and source cell. Simulators of
    /// one cell come from one process and keep their order.
    far: Vec<(u32, u32, SimulatorOf<P, F>)>,
    counts: StepCounters,
}

impl<P: ParticleModel, F: DisplacementTracking<P::Space>> News<P, F> {
    fn add(&mut self, other: Self) {
        self.stock.add(&other.stock);
        self.simulators += other.simulators;
        self.ends |= other.ends;
        self.pauses |= other.pauses;
        self.far.extend(other.far);
        self.counts.merge(&other.counts);
    }
}

impl<P: ParticleModel, F: DisplacementTracking<P::Space>> DsmcEngine<P, F> {
    /// Exchanges migrating simulators with neighbouring processes after a free flight, sends
    /// collision logs to the root process if `looks`, and reduces statistics. Returns the counters
    /// `counts` summed over all processes.
    pub(crate) fn exchange_with_others(
        &mut self,
        counts: StepCounters,
        looks: bool,
    ) -> StepCounters {
        if !PROCESSES {
            return counts;
        }
        let Some(mut share) = self.share.take() else {
            return counts;
        };
        let (to, from) = share.after_flights(looks);
        let messages: Vec<_> = (to.into_iter())
            .map(|rank| {
                let sent = Sent {
                    leaving: self.leaving(&share, rank),
                    logs: if rank == 0 && looks {
                        self.logs()
                    } else {
                        Vec::new()
                    },
                };
                (rank, to_bytes(&sent))
            })
            .collect();
        // Simulators that stay in this process.
        let tiles = self.tiles.iter().zip(&self.arriving);
        let own = tiles.filter(|(tile, _)| tile.is_here);
        let simulators = own
            .map(|(tile, outbox)| tile.simulators.len() + outbox.near())
            .sum::<usize>()
            + self.far.len();
        for (tile, outbox) in self.tiles.iter().zip(&mut self.arriving) {
            if !tile.is_here {
                outbox.fill(&[]);
            }
        }
        for bytes in share.ranks.exchange(messages, &from) {
            let sent: Sent<P, F> = from_bytes(&bytes);
            self.enter(&sent.leaving);
            for (tile, log) in sent.logs {
                self.tiles[tile as usize].log.extend(log);
            }
        }
        let counts = self.tell_all(&mut share, simulators, counts);
        share.since += 1;
        self.share = Some(share);
        counts
    }

    /// Returns the simulators that left tiles of this process for tiles of the process `rank`.
    fn leaving(&self, share: &Subdomain<P::Space>, rank: usize) -> Vec<Leaving<P, F>> {
        let mut leaving = Vec::new();
        for (number, tile) in self.tiles.iter().enumerate() {
            if !tile.is_here || share.seer(number, rank).is_none() {
                continue;
            }
            for step in 0..OFFSETS {
                let to = self.grid.neighbour(tile.place.tile, offset(step));
                if share.owners[self.grid.tile_number(to)] as usize == rank {
                    let some = self.arriving[number].towards(step).iter();
                    leaving.extend(some.map(|one| Leaving {
                        tile: number as u32,
                        offset: step as u8,
                        source: one.source,
                        simulator: one.simulator,
                    }));
                }
            }
        }
        leaving
    }

    /// Takes the logged collisions out of the tiles of this process, with tile numbers.
    fn logs(&mut self) -> Vec<(u32, Vec<Collision>)> {
        let own = self.tiles.iter_mut().enumerate();
        let own = own.filter(|(_, tile)| tile.is_here && !tile.log.is_empty());
        own.map(|(number, tile)| (number as u32, tile.log.drain(..).collect()))
            .collect()
    }

    /// Delivers simulators that left tiles of another process to their new tiles, tile after tile.
    fn enter(&mut self, leaving: &[Leaving<P, F>]) {
        for of_tile in leaving.chunk_by(|one, next| one.tile == next.tile) {
            let leavers: Vec<(u8, Migrant<P, F>)> = of_tile
                .iter()
                .map(|one| {
                    let left = DepartedSimulator {
                        source: one.source,
                        simulator: one.simulator,
                    };
                    (one.offset, left)
                })
                .collect();
            self.arriving[of_tile[0].tile as usize].fill(&leavers);
        }
    }

    /// Reduces statistics, counters and stop flags over all processes, and distributes simulators
    /// that flew beyond adjacent tiles. `simulators` is the number in this process.
    fn tell_all(
        &mut self,
        share: &mut Subdomain<P::Space>,
        simulators: usize,
        counts: StepCounters,
    ) -> StepCounters {
        let mut stock = StepBounds::default();
        self.tiles
            .iter()
            .filter(|tile| tile.is_here)
            .for_each(|tile| stock.add(&tile.stock));
        let far = self
            .far
            .iter()
            .filter(|(to, _)| !share.is_mine(*to as usize));
        let news = News::<P, F> {
            stock,
            simulators,
            ends: self.stop.interrupt().is_raised(),
            pauses: self.stop.is_paused(),
            far: far
                .map(|&(to, one)| (to, one.source, one.simulator))
                .collect(),
            counts,
        };
        self.far.retain(|(to, _)| share.is_mine(*to as usize));
        let all = all_reduce(&*share.ranks, news, News::add);
        share.ends |= all.ends;
        share.pauses |= all.pauses;
        share.stock = all.stock;
        let far = all.far.into_iter();
        let mine = far.filter(|(to, ..)| share.is_mine(*to as usize));
        self.far.extend(
            mine.map(|(to, source, simulator)| (to, DepartedSimulator { source, simulator })),
        );
        if self.surroundings.is_some() {
            self.simulators = all.simulators;
        }
        all.counts
    }
}

impl<S: stosszahl_model::Space> Subdomain<S> {
    /// Returns the ranks to send to and to receive from after a free flight: neighbouring
    /// processes, and the root process if collisions are logged (`looks`).
    fn after_flights(&self, looks: bool) -> (Vec<usize>, Vec<usize>) {
        let mut to = self.near.clone();
        if !looks {
            return (to, self.near.clone());
        }
        if self.me() == 0 {
            return (to, (1..self.ranks.size()).collect());
        }
        if !to.contains(&0) {
            to.insert(0, 0);
        }
        (to, self.near.clone())
    }
}
