//! Start in parts: each process makes all simulators in turn and keeps those of its tiles.

use stosszahl_model::{ParticleModel, Sizes, Vector as _};

use super::bytes::{from_bytes, to_bytes};
use super::ranks::{Ranks, all_reduce, broadcast, gather};
use super::subdomain::Subdomain;
use crate::engine::DsmcEngine;
use crate::parameters::DsmcError;
use crate::particle::DisplacementTracking;
use crate::start_stream::StartStream;
use crate::tally::{EnergyUnit, StepBounds};

/// Number of energies that the root process adds at once.
const ENERGIES: usize = 1 << 20;

impl<P: ParticleModel, F: DisplacementTracking<P::Space>> DsmcEngine<P, F> {
    /// Makes the simulators of each process. Collective call; errors of any process reach all by
    /// the caller. Returns the number of simulators of this process.
    pub(crate) fn start_parts(&mut self, start: &dyn StartStream) -> Result<usize, DsmcError> {
        let Some(mut share) = self.share.take() else {
            return Ok(0);
        };
        let made = self.start_part(&mut share, start);
        self.share = Some(share);
        made
    }

    fn start_part(
        &mut self,
        share: &mut Subdomain<P::Space>,
        start: &dyn StartStream,
    ) -> Result<usize, DsmcError> {
        let counted = (share.me() == 0).then(|| self.count_start(start));
        let counted = counted.transpose();
        let told = counted.as_ref().ok().and_then(Option::as_ref);
        let told = broadcast(&*share.ranks, to_bytes(&told));
        counted?;
        let Some(counts) = from_bytes::<Option<Vec<usize>>>(&told) else {
            // The root process reports why.
            return Ok(0);
        };
        self.divide(share, &counts);
        let own = counts.iter().zip(&self.tiles);
        let own = own.filter(|(_, tile)| tile.is_here).map(|(count, _)| count);
        self.take_start(start, own.sum())
    }

    /// Computes largest speeds and energy of a start of which this process has `own` simulators,
    /// with the bits of [`Self::update_step_bounds`] in one process. Collective call.
    ///
    /// # Errors
    /// [`DsmcError::UnequalParts`] if processes made different starts.
    pub(crate) fn unite_step_bounds(&mut self, own: usize) -> Result<(), DsmcError> {
        let Some(share) = &self.share else {
            return Ok(());
        };
        let ranks = &*share.ranks;
        let (found, wanted) = (
            all_reduce(ranks, own, |sum, more| *sum += more),
            self.simulators,
        );
        if found != wanted {
            return Err(DsmcError::UnequalParts { found, wanted });
        }
        let total = self.energy_in_order(ranks);
        let unit: EnergyUnit =
            from_bytes(&broadcast(ranks, to_bytes(&EnergyUnit::for_total(total))));
        let mut stock = StepBounds::default();
        let sizes = self.scene.sizes();
        for simulator in self.tiles.iter().flat_map(|tile| &tile.simulators) {
            let v = simulator.velocity;
            stock.add_cell(v, v, sizes.mass(simulator.tag) * v.square(), unit.inverse());
        }
        self.stock = all_reduce(ranks, stock, |sum, more| sum.add(&more));
        self.unit = unit;
        Ok(())
    }

    /// Sum of m v^2 over all processes \[energy\], added by the root process in the order of cells;
    /// not the sum in other processes.
    fn energy_in_order(&self, ranks: &dyn Ranks) -> f64 {
        let sizes = self.scene.sizes();
        let rounds = self.simulators.div_ceil(ENERGIES).max(1);
        let cells_at_once = self.grid.cells().div_ceil(rounds);
        let mut cells = self.cells_in_order();
        let mut total = 0.0;
        for _ in 0..rounds {
            let mut own = Vec::new();
            for cell in cells.by_ref().take(cells_at_once) {
                let (tile, local) = self.grid.locate(cell);
                if self.tiles[tile].is_here {
                    let number = self.grid.number(cell);
                    let members = self.tiles[tile].members(local).iter();
                    own.extend(
                        members.map(|one| (number, sizes.mass(one.tag) * one.velocity.square())),
                    );
                }
            }
            let came = gather(ranks, to_bytes(&own));
            let mut all: Vec<(u32, f64)> = came
                .iter()
                .flat_map(|some| from_bytes::<Vec<(u32, f64)>>(some))
                .collect();
            // Simulators of a cell are in one process, in their order.
            all.sort_by_key(|one| one.0);
            for (_, twice_energy) in all {
                total += twice_energy;
            }
        }
        total
    }
}
