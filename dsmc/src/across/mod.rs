//! Collisions between partners in different cells.
//!
//! Three schemes draw a partner by where it is, not by its cell ([`crate::Scheme`] has their laws and limits): the line of
//! centres is drawn first, and the partner from where it then has to be. All tiles are arranged; then each is worked on
//! together with its neighbours, colour after colour ([`shared`]), and the pairs of a tile one after the other.

mod arm;
mod kernel;
mod overlap;
mod partners;
mod rate;
mod shared;
mod speeds;
#[cfg(test)]
mod tests;

use rayon::prelude::*;
use stosszahl_model::{Collision, Physics, Sizes, Vector};

pub(crate) use arm::Arm;
pub(crate) use rate::{Rates, Spread};
pub(crate) use speeds::Speeds;

use crate::collide::Kernel;
use crate::density::Scheme;
use crate::simulator::Follow;
use crate::tally::Tally;
use crate::tile::Tile;
use arm::Distances;
use speeds::Near;

/// What the cells of a tile have in common, before the collisions of a step.
#[derive(Clone, Copy)]
struct Bounds {
    /// Most simulators in a cell.
    crowd: u32,
    /// Largest chi of a cell.
    chi: f64,
}

/// What the collisions around a tile leave.
#[derive(Default)]
struct Report {
    tally: Tally,
    distances: Distances,
    log: Vec<Collision>,
}

/// How far beyond its own cells work on a tile reaches, at most \[length\]; zero for pairs within cells. `cell`: widest side
/// of a cell.
pub(crate) fn reach(scheme: Scheme, diameter: f64, radius: f64, cell: f64) -> f64 {
    match scheme {
        Scheme::ContactPoint { .. } => {
            Arm::LONGEST * diameter + radius.max(partners::WIDEST as f64 * cell) + cell
        }
        Scheme::Esmc(_) | Scheme::StochasticDisks { .. } => diameter + cell,
        _ => 0.0,
    }
}

impl<P> Kernel<'_, P>
where
    P: Physics,
{
    /// Collides all pairs of a step; all tiles are arranged. Returns the collisions that somebody wants to look at.
    pub(crate) fn collide_across<F: Follow<P::Space>>(
        &self,
        parallel: bool,
        tiles: &mut [Tile<P, F>],
        rates: &Rates<P::Space>,
        arm: &mut Arm,
        total: &mut Tally,
    ) -> Vec<Collision> {
        let bounds = |tile: &mut Tile<P, F>| self.bounds(tile);
        let bounds: Vec<_> = if parallel {
            tiles.par_iter_mut().map(bounds).collect()
        } else {
            tiles.iter_mut().map(bounds).collect()
        };
        let grid = self.grid;
        let learnt = &*arm;
        let mut reports = shared::sweep_around(parallel, grid, tiles, |number, around| {
            let worker = kernel::Worker {
                kernel: self,
                rates,
                arm: learnt,
                bounds: kernel::around(grid, &bounds, number),
                near: Near::nobody(),
                around,
                report: Report::default(),
            };
            worker.collide()
        });
        arm.learn(reports.iter().map(|report| &report.distances));
        for report in &reports {
            total.add(&report.tally);
        }
        reports
            .iter_mut()
            .flat_map(|report| report.log.drain(..))
            .collect()
    }

    /// Takes stock of a tile.
    fn bounds<F: Follow<P::Space>>(&self, tile: &mut Tile<P, F>) -> Bounds {
        let needs_chi = matches!(self.density.scheme(), Scheme::Esmc(_));
        let mut bounds = Bounds { crowd: 0, chi: 0.0 };
        let mut stock = crate::tally::Stock::default();
        let sizes = self.scene.sizes();
        for cell in 0..tile.cells() {
            let members = tile.members(cell);
            bounds.crowd = bounds.crowd.max(members.len() as u32);
            if needs_chi {
                let own = crate::collide::covered::<P, F>(sizes, members);
                let (chi, ..) = self.density.contact_value(tile.cell_at(cell), own);
                bounds.chi = bounds.chi.max(chi);
            }
            for member in members {
                let v = member.velocity;
                stock.note(v, v, sizes.mass(member.tag) * v.square(), self.units);
            }
        }
        tile.stock = stock;
        if self.density.scheme().bounds_trials() {
            let (place, starts, simulators) = (&tile.place, &tile.starts, &tile.simulators);
            tile.speeds
                .look::<P, F>(self.grid, place, starts, simulators);
        }
        bounds
    }
}
