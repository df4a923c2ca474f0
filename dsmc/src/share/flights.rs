//! What processes tell each other after a flight.

use serde::{Deserialize, Serialize};
use stosszahl_model::{Collision, Physics};

use super::{Share, all_gather, read, write};
use crate::boundary::Ledgers;
use crate::engine::Engine;
use crate::grid::{OFFSETS, offset};
use crate::simulator::{Follow, SimulatorOf};
use crate::tally::{Stock, Tally};
use crate::tile::{Left, Traveller};

/// What one process learns from another.
#[derive(Serialize, Deserialize)]
#[serde(bound = "")]
struct Sent<P: Physics, F: Follow<P::Space>> {
    leaving: Vec<Leaving<P, F>>,
    /// Of the tiles of the sender, for the first process.
    counted: Vec<Counted<P>>,
}

/// A simulator that crossed a border: from which tile, to which of those next to it, and from which cell.
#[derive(Serialize, Deserialize)]
#[serde(bound = "")]
struct Leaving<P: Physics, F: Follow<P::Space>> {
    tile: u32,
    offset: u8,
    source: u32,
    simulator: SimulatorOf<P, F>,
}

/// What a tile has counted in a step.
#[derive(Serialize, Deserialize)]
#[serde(bound = "")]
struct Counted<P: Physics> {
    tile: u32,
    tally: Tally,
    ledgers: Option<Box<Ledgers<P::Space>>>,
    log: Vec<Collision>,
}

/// What all processes learn in each step.
#[derive(Serialize, Deserialize)]
#[serde(bound = "")]
struct News<P: Physics, F: Follow<P::Space>> {
    stock: Stock<P::Space>,
    simulators: usize,
    ends: bool,
    pauses: bool,
    far: Vec<(u32, u32, SimulatorOf<P, F>)>,
}

impl<P: Physics, F: Follow<P::Space>> Engine<P, F> {
    /// After a flight: sends what left own tiles to the owners of those it enters, what tiles have counted to the first process, and
    /// to all what the next step follows.
    pub(crate) fn exchange_with_others(&mut self) {
        let Some(mut share) = self.share.take() else {
            return;
        };
        let (to, from) = share.after_flights();
        let messages: Vec<_> = (to.into_iter())
            .map(|rank| {
                let sent = Sent {
                    leaving: self.leaving(&share, rank),
                    counted: if rank == 0 {
                        self.counted()
                    } else {
                        Vec::new()
                    },
                };
                (rank, write(&sent))
            })
            .collect();
        // What left own tiles, and is still here.
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
            let sent: Sent<P, F> = read(&bytes);
            self.enter(&sent.leaving);
            for one in sent.counted {
                let tile = &mut self.tiles[one.tile as usize];
                tile.tally = one.tally;
                tile.ledgers = one.ledgers;
                tile.log.extend(one.log);
            }
        }
        self.tell_all(&mut share, simulators);
        share.since += 1;
        self.share = Some(share);
    }

    /// What left own tiles for those of another process.
    fn leaving(&self, share: &Share<P::Space>, rank: usize) -> Vec<Leaving<P, F>> {
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

    /// What own tiles have counted in a step.
    fn counted(&mut self) -> Vec<Counted<P>> {
        let own = self.tiles.iter_mut().enumerate();
        let own = own.filter(|(_, tile)| tile.is_here);
        own.map(|(number, tile)| Counted {
            tile: number as u32,
            tally: tile.tally,
            ledgers: tile.ledgers.clone(),
            log: tile.log.drain(..).collect(),
        })
        .collect()
    }

    /// Takes what left tiles of another process, tile after tile.
    fn enter(&mut self, leaving: &[Leaving<P, F>]) {
        for of_tile in leaving.chunk_by(|one, next| one.tile == next.tile) {
            let leavers: Vec<(u8, Traveller<P, F>)> = of_tile
                .iter()
                .map(|one| {
                    let left = Left {
                        source: one.source,
                        simulator: one.simulator,
                    };
                    (one.offset, left)
                })
                .collect();
            self.arriving[of_tile[0].tile as usize].fill(&leavers);
        }
    }

    /// All processes learn the stock, and who flew farther than to the next tile.
    fn tell_all(&mut self, share: &mut Share<P::Space>, simulators: usize) {
        let mut stock = Stock::default();
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
        };
        self.far.retain(|(to, _)| share.is_mine(*to as usize));
        let all = all_gather(&*share.ranks, write(&news));
        let (mut stock, mut simulators) = (Stock::default(), 0);
        for (rank, bytes) in all.iter().enumerate() {
            let news: News<P, F> = read(bytes);
            stock.add(&news.stock);
            simulators += news.simulators;
            share.ends |= news.ends;
            share.pauses |= news.pauses;
            let far = news
                .far
                .into_iter()
                .filter(|(to, ..)| share.is_mine(*to as usize));
            if rank != share.me() {
                self.far
                    .extend(far.map(|(to, source, simulator)| (to, Left { source, simulator })));
            }
        }
        share.stock = stock;
        if self.surroundings.is_some() {
            self.simulators = simulators;
        }
    }
}

impl<S: stosszahl_model::Space> Share<S> {
    /// To whom this process sends after a flight, and from whom something comes: its neighbours, and the first process.
    fn after_flights(&self) -> (Vec<usize>, Vec<usize>) {
        let mut to = self.near.clone();
        if self.me() == 0 {
            return (to, (1..self.ranks.size()).collect());
        }
        if !to.contains(&0) {
            to.insert(0, 0);
        }
        (to, self.near.clone())
    }
}
