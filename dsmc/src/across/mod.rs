//! Collisions between partners in different cells.
//!
//! Three schemes draw a partner by where it is, not by its cell ([`crate::Scheme`] has their laws and limits): the line of
//! centres is drawn first, and the partner from where it then has to be. All tiles are arranged; then each is worked on
//! together with its neighbours, colour after colour ([`shared`]), and the pairs of a tile one after the other.

mod arm;
mod extents;
mod kernel;
mod lanes;
mod missing;
mod overlap;
mod partners;
mod patch;
mod rate;
pub(crate) mod shared;
mod trials;

#[cfg(test)]
mod tests;

use serde::{Deserialize, Serialize};
use stosszahl_model::{Collision, Physics, Sizes, Vector};

pub(crate) use arm::{Arm, Distances};
pub(crate) use patch::Patch;
pub(crate) use rate::{Rates, Spread};

use crate::collide::{Kernel, covered};
use crate::density::Scheme;
use crate::grid::Grid;
use crate::share::{PROCESSES, Share, see_no_more};
use crate::simulator::Follow;
use crate::sweep::{Pool, each_of};
use crate::tally::Tally;
use crate::tile::Tile;
use extents::Ranges;

/// What the cells of a tile have in common, before the collisions of a step.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(crate) struct Bounds {
    /// Largest chi of a cell.
    chi: f64,
}

/// What the collisions around a tile leave.
#[derive(Default)]
pub(crate) struct Report {
    pub(crate) tally: Tally,
    pub(crate) distances: Distances,
    pub(crate) log: Vec<Collision>,
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
    /// Collides all pairs of a step; all tiles are arranged. Returns what was done around each tile, by its number; the log of each holds the
    /// collisions that somebody wants to look at.
    pub(crate) fn collide_across<F: Follow<P::Space>>(
        &self,
        tiles: &mut [Tile<P, F>],
        share: Option<&Share<P::Space>>,
        rates: Option<&Rates<P::Space>>,
        arm: &mut Arm,
        total: &mut Tally,
        pool: &Pool<P, F>,
    ) -> Vec<(u32, Report)> {
        let parallel = self.parallel;
        let mut bounds = each_of(parallel, tiles.iter_mut(), |_, tile| self.bounds(tile));
        let grid = self.grid;
        let learnt = &*arm;
        let scheme = self.density.scheme();
        let (sizes, radius) = (self.scene.sizes(), self.partner_radius);
        let ranges = ranges::<P>(scheme, grid, sizes, self.mean_radius, radius, arm.longest());
        if PROCESSES && let Some(share) = share {
            for (number, known) in share.see_around(tiles, &bounds) {
                bounds[number] = known;
            }
        }
        let mut reports = shared::sweep_around(parallel, grid, tiles, share, |number, around| {
            pool.with(|scratch| {
                let bounds = kernel::around(grid, &bounds, number);
                let patch = &mut scratch.patch;
                kernel::Worker::new(self, rates, learnt, bounds, around, patch).collide(ranges)
            })
        });
        if PROCESSES && let Some(share) = share {
            reports = share.all_reports(grid, reports, self.looks);
            see_no_more(tiles);
        }
        arm.learn(reports.iter().map(|(_, report)| &report.distances));
        for (_, report) in &reports {
            total.add(&report.tally);
        }
        reports
    }

    /// Takes stock of a tile.
    fn bounds<F: Follow<P::Space>>(&self, tile: &mut Tile<P, F>) -> Bounds {
        let mut bounds = Bounds { chi: 0.0 };
        let mut stock = crate::tally::Stock::default();
        if tile.starts.is_empty() {
            // Of another process, and not next to what is here.
            return bounds;
        }
        let sizes = self.scene.sizes();
        if matches!(self.density.scheme(), Scheme::Esmc(_)) {
            for cell in 0..tile.cells() {
                let own = covered::<P>(sizes, tile.members(cell).iter().map(|member| member.tag));
                let (chi, ..) = self.density.contact_value(tile.cell_at(cell), own);
                bounds.chi = bounds.chi.max(chi);
            }
        }
        for simulator in &tile.simulators {
            let velocity = simulator.velocity;
            let twice_energy = sizes.mass(simulator.tag) * velocity.square();
            stock.note(velocity, velocity, twice_energy, self.units);
        }
        tile.stock = stock;
        bounds
    }
}

/// How many cells beyond those of a tile work on it looks at, at most, with the radius of partners that are equally likely.
pub(crate) fn margin<P: Physics>(
    scheme: Scheme,
    grid: &Grid<P::Space>,
    sizes: &P::Sizes,
    mean_radius: f64,
    radius: f64,
) -> usize {
    ranges::<P>(scheme, grid, sizes, mean_radius, radius, Arm::LONGEST).margin()
}

/// How far from a simulator its partners are, in cells; `radius`: within which all are equally likely \[length\]; `arm`: of where
/// they are sought, in contact distances.
fn ranges<P: Physics>(
    scheme: Scheme,
    grid: &Grid<P::Space>,
    sizes: &P::Sizes,
    mean_radius: f64,
    radius: f64,
    arm: f64,
) -> Ranges {
    let narrowest = grid.narrowest();
    let cells = |distance: f64| (distance / narrowest).ceil() as usize;
    // More cells than all are not needed, however far: in an empty box partners may be anywhere.
    let all = grid.counts().into_iter().max().unwrap_or(1) as usize;
    let largest = sizes.largest_radius();
    let longest = largest + mean_radius;
    if let Scheme::ContactPoint { .. } = scheme {
        let spread = if sizes.are_equal() {
            0.0
        } else {
            mean_radius.max(largest - mean_radius)
        };
        Ranges {
            point: cells(arm * longest),
            near: cells(radius).clamp(1, all),
            far: partners::WIDEST as usize,
            shift: cells(arm * spread).min(all),
        }
    } else {
        Ranges {
            point: cells(longest),
            ..Ranges::default()
        }
    }
}
