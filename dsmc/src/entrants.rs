//! Simulators of a start stream on their way into the tiles of an engine.

use nalgebra::Vector3;
use stosszahl_model::{ParticleModel, Sizes, Space, Surface};

use crate::engine::DsmcEngine;
use crate::parameters::DsmcError;
use crate::particle::{DisplacementTracking, Simulator, SimulatorOf};
use crate::start::check_number;
use crate::start_stream::StartStream;

/// Simulator on its way into a tile.
struct Entrant<P: ParticleModel, F: DisplacementTracking<P::Space>> {
    tile: u32,
    /// Cell in the tile.
    cell: u16,
    /// Index in the start.
    index: u32,
    simulator: SimulatorOf<P, F>,
}

impl<P: ParticleModel, F: DisplacementTracking<P::Space>> DsmcEngine<P, F> {
    /// Counts the simulators of a start in each tile.
    ///
    /// # Errors
    /// [`DsmcError`] if a simulator cannot be placed.
    pub(crate) fn count_start(&self, start: &dyn StartStream) -> Result<Vec<usize>, DsmcError> {
        let mut counts = vec![0; self.tiles.len()];
        self.visit_entrants(start, &mut |entrant| counts[entrant.tile as usize] += 1)?;
        Ok(counts)
    }

    /// Makes all simulators of a start in turn, and puts those of own tiles into them. `room`:
    /// expected number of the latter. Returns their number.
    ///
    /// # Errors
    /// [`DsmcError`] if a simulator cannot be placed.
    pub(crate) fn take_start(
        &mut self,
        start: &dyn StartStream,
        room: usize,
    ) -> Result<usize, DsmcError> {
        let mut kept: Vec<Entrant<P, F>> = Vec::with_capacity(room);
        self.visit_entrants(start, &mut |entrant| {
            if self.tiles[entrant.tile as usize].is_here {
                kept.push(entrant);
            }
        })?;
        kept.sort_unstable_by_key(|one| one.index);
        let failed = |why| DsmcError::Start { why };
        let mut rest = kept.iter_mut().peekable();
        start
            .visit_velocities(&mut |index, velocity| {
                if let Some(one) = rest.next_if(|one| one.index as usize == index) {
                    one.simulator.velocity = P::Space::from_components(|axis| velocity[axis]);
                }
            })
            .map_err(failed)?;
        if <P::Surface as Surface<P::Space>>::ROUGH {
            let mut rest = kept.iter_mut().peekable();
            start
                .visit_spins(&mut |index, spin| {
                    if let Some(one) = rest.next_if(|one| one.index as usize == index) {
                        one.simulator.spin = <P::Surface as Surface<P::Space>>::spin_of(spin);
                    }
                })
                .map_err(failed)?;
        }
        for one in &kept {
            check_number::<P, F>(&self.scene, one.index as usize, &one.simulator)?;
        }
        kept.sort_unstable_by_key(|one| (one.tile, one.cell, one.index));
        let count = kept.len();
        let mut members = Vec::new();
        // From the last tile, so that memory returns to the system as tiles take it.
        while let Some(tile) = kept.last().map(|last| last.tile) {
            let first = kept.partition_point(|one| one.tile < tile);
            members.clear();
            members.extend(kept[first..].iter().map(|one| (one.cell, one.simulator)));
            self.tiles[tile as usize].take(&members);
            kept.truncate(first);
            kept.shrink_to_fit();
        }
        Ok(count)
    }

    /// Calls `look` with every simulator of a start, at rest at its place.
    fn visit_entrants(
        &self,
        start: &dyn StartStream,
        look: &mut dyn FnMut(Entrant<P, F>),
    ) -> Result<(), DsmcError> {
        let (sizes, domain) = (self.scene.sizes(), self.grid.domain());
        let mut refused = None;
        let mut visit = |index: usize, position: Vector3<f64>| -> Result<(), DsmcError> {
            let mut simulator = Simulator {
                position: domain.wrap(P::Space::from_components(|axis| position[axis])),
                tag: sizes.tag_of(index),
                ..SimulatorOf::<P, F>::default()
            };
            check_number::<P, F>(&self.scene, index, &simulator)?;
            if let Some(surroundings) = &self.surroundings {
                surroundings.check_place::<F>(&self.scene, index, &simulator, self.time)?;
                surroundings.fold(&mut simulator.position, sizes.radius(simulator.tag));
            }
            let (tile, cell) = self.grid.locate(self.grid.cell_at(simulator.position));
            look(Entrant {
                tile: tile as u32,
                cell: cell as u16,
                index: index as u32,
                simulator,
            });
            Ok(())
        };
        let done = start.visit_positions(&mut |index, position| {
            if refused.is_none() {
                refused = visit(index, position).err();
            }
        });
        refused.map_or(Ok(()), Err)?;
        done.map_err(|why| DsmcError::Start { why })
    }
}
