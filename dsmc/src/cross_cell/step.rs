//! Collision phase of one time step for schemes whose partners are in different cells: bounds,
//! coloured sweep, and reports of all tiles.

use stosszahl_model::threads::each_of;
use stosszahl_model::{ParticleModel, Sizes, Vector};

use super::arm::ContactDistance;
use super::coloured_sweep::sweep_around;
use super::halo_copy::HaloCopy;
use super::peers::TilePeers;
use super::rate::Rates;
use super::report::{TileBounds, TileReport};
use super::search_ranges::ranges;
use super::tile_collider::TileCollider;
use super::tile_collisions::bounds_around;
use crate::features::PROCESSES;
use crate::particle::{DisplacementTracking, covered};
use crate::scheme::PartnerSelection;
use crate::tally::{CollisionCounters, StepBounds};
use crate::threads::Pool;
use crate::tile::Tile;
use crate::within_cell::CollisionContext;

impl<P> CollisionContext<'_, P>
where
    P: ParticleModel,
{
    /// Collides all pairs of a time step whose partners may be in different cells; all tiles must
    /// be sorted. Returns the report of each tile, whose log holds the collisions for observers.
    pub(crate) fn collide_across<F: DisplacementTracking<P::Space>>(
        &self,
        tiles: &mut [Tile<P, F>],
        peers: Option<&dyn TilePeers<P, F>>,
        rates: Option<&Rates<P::Space>>,
        arm: &mut ContactDistance,
        total: &mut CollisionCounters,
        patches: &Pool<HaloCopy<P>>,
    ) -> Vec<(u32, TileReport)> {
        let parallel = self.parallel;
        let mut bounds = each_of(parallel, tiles.iter_mut(), |_, tile| self.bounds(tile));
        let grid = self.grid;
        let learnt = &*arm;
        let scheme = self.density.scheme();
        let (sizes, radius) = (self.scene.sizes(), self.partner_radius);
        let ranges = ranges::<P>(scheme, grid, sizes, self.mean_radius, radius, arm.longest());
        if PROCESSES && let Some(peers) = peers {
            for (number, known) in peers.see_around(tiles, &bounds) {
                bounds[number] = known;
            }
        }
        let mut reports = sweep_around(parallel, grid, tiles, peers, |number, around| {
            patches.with(|patch| {
                let bounds = bounds_around(grid, &bounds, number);
                TileCollider::new(self, rates, learnt, bounds, around, patch).collide(ranges)
            })
        });
        if PROCESSES && let Some(peers) = peers {
            reports = peers.all_reports(grid, reports, self.looks);
            peers.see_no_more(tiles);
        }
        arm.learn(reports.iter().map(|(_, report)| &report.distances));
        for (_, report) in &reports {
            total.add(&report.tally);
        }
        reports
    }

    /// Computes bounds of a tile before collisions: the largest contact value χ, and for the next
    /// time step the largest speeds and the kinetic energy.
    fn bounds<F: DisplacementTracking<P::Space>>(&self, tile: &mut Tile<P, F>) -> TileBounds {
        let mut bounds = TileBounds { chi: 0.0 };
        let mut stock = StepBounds::default();
        if tile.starts.is_empty() {
            // A tile of another process, beyond the ghost cells.
            return bounds;
        }
        let sizes = self.scene.sizes();
        if self.density.scheme().partners() == PartnerSelection::ContactCell {
            for cell in 0..tile.cells() {
                let own = covered::<P>(sizes, tile.members(cell).iter().map(|member| member.tag));
                let (chi, ..) = self.density.contact_value(tile.cell_at(cell), own);
                bounds.chi = bounds.chi.max(chi);
            }
        }
        for simulator in &tile.simulators {
            let velocity = simulator.velocity;
            let twice_energy = sizes.mass(simulator.tag) * velocity.square();
            stock.add_cell(velocity, velocity, twice_energy, self.units);
        }
        tile.stock = stock;
        bounds
    }
}
