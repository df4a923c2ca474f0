//! Free space of a case for initial positions: a box or a region of it, outside walls and obstacles.

use rand::Rng;
use stosszahl_model::initial::{AdditionError, FreeSpace, SequentialAddition};
use stosszahl_model::{Interrupt, Space};

use crate::plan::{CasePlan, Confinement, Region};
use crate::start::error::{PlacementFailed, StartError};

/// Exclusion rule for initial positions: between particles, and at walls and obstacles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum ExclusionRule {
    /// Point particles: their centres lie anywhere in the box outside obstacles.
    Points,
    /// Particles that overlap neither walls nor obstacles, but may overlap each other.
    Surfaces,
    /// Particles that overlap neither walls nor obstacles nor each other.
    Grains,
}

/// Free space of a case, with its exclusion rule.
pub(crate) struct StartSpace<'a, S: Space> {
    confinement: &'a Confinement<S>,
    region: Option<Region>,
    rule: ExclusionRule,
}

impl<'a, S: Space> StartSpace<'a, S> {
    /// Returns the free space of a case in its box.
    pub(crate) fn from_plan(plan: &CasePlan, confinement: &'a Confinement<S>) -> Self {
        let rule = match (plan.keeps_apart(), plan.keeps_clear()) {
            (true, _) => ExclusionRule::Grains,
            (false, true) => ExclusionRule::Surfaces,
            (false, false) => ExclusionRule::Points,
        };
        Self {
            confinement,
            region: plan.region(),
            rule,
        }
    }

    /// Draws a position for each of `count` particles, the largest first, and hands it to `look`
    /// with the index of the particle.
    ///
    /// # Errors
    /// [`StartError`] if a particle finds no place, or after an interrupt.
    pub(crate) fn place_all(
        &self,
        count: usize,
        radius: &dyn Fn(usize) -> f64,
        stream: &mut impl Rng,
        interrupt: &Interrupt,
        look: &mut dyn FnMut(usize, S::Vector),
    ) -> Result<(), StartError> {
        let addition = SequentialAddition {
            count,
            radius,
            domain: &self.confinement.domain,
            space: self,
            excludes: self.rule == ExclusionRule::Grains,
        };
        let placed = addition.place_all(stream, interrupt, look);
        placed.map_err(|error| match error {
            AdditionError::Interrupted => StartError::Interrupted,
            AdditionError::Jammed { particle, trials } => {
                StartError::PlacementFailed(PlacementFailed {
                    particle,
                    count,
                    trials,
                })
            }
        })
    }

    /// Returns the smallest allowed distance of a particle's centre from a face \[length\].
    fn clearance(&self, axis: usize, side: usize, radius: f64) -> f64 {
        let wall = self.confinement.walls.wall(axis, side);
        match (wall, self.rule) {
            (Some(_), ExclusionRule::Points) => self.confinement.wall(axis, side),
            // Slightly more, so that rounding makes no particle touch a wall.
            (Some(_), _) => self.confinement.wall(axis, side) + radius * (1.0 + 1e-9),
            (None, _) => 0.0,
        }
    }
}

impl<S: Space> FreeSpace<S> for StartSpace<'_, S> {
    fn centre_range(&self, axis: usize, radius: f64) -> [f64; 2] {
        let edge = |side: usize| self.clearance(axis, side, radius);
        let length = self.confinement.domain.lengths()[axis];
        let (low, high) = (edge(0), length - edge(1));
        let Some(region) = self.region else {
            return [low, high];
        };
        let margin = if self.rule == ExclusionRule::Points {
            0.0
        } else {
            radius
        };
        let inner = [region.low[axis] + margin, region.high[axis] - margin];
        [inner[0].max(low), inner[1].min(high)]
    }

    fn is_free(&self, centre: S::Vector, radius: f64) -> bool {
        let reach = if self.rule == ExclusionRule::Points {
            0.0
        } else {
            radius * (1.0 + 1e-9)
        };
        let body = self.confinement.body_at(centre, reach);
        body.is_none_or(|(_, depth)| depth <= 0.0)
    }
}
