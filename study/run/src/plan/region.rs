//! Region of the box in which the particles of a start are placed, and its checks.

use std::f64::consts::PI;

use stosszahl_results::format_number;

use super::data::{CasePlan, PlanError};

/// Packing fractions at which random sequential addition of equal disks and of spheres jams: Feder
/// 1980; Torquato, Uche & Stillinger 2006.
const JAMMED: [f64; 2] = [0.547, 0.384];
/// Key of the start region in a case file.
const KEY: &str = "start.region";

/// Region of the start: a rectangle or cuboid, in engine units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Region {
    /// Lower corner of the region \[length\]; 0 beyond the dimension.
    pub low: [f64; 3],
    /// Upper corner of the region \[length\]; 0 beyond the dimension.
    pub high: [f64; 3],
}

impl Region {
    /// Returns the area or volume of the region \[length^D\].
    pub fn volume(&self, dimension: usize) -> f64 {
        (0..dimension)
            .map(|axis| self.high[axis] - self.low[axis])
            .product()
    }
}

impl CasePlan {
    /// Returns the region in which the start is placed; `None` for the whole box.
    pub fn region(&self) -> Option<Region> {
        let corners = self.case.start.region.as_ref()?;
        let corner = |list: &[f64]| {
            [0, 1, 2].map(|axis| {
                list.get(axis)
                    .map_or(0.0, |place| place / self.scale.length)
            })
        };
        Some(Region {
            low: corner(&corners[0]),
            high: corner(&corners[1]),
        })
    }

    /// Computes the packing fraction in the start region, without the area of obstacles; `None`
    /// without a region.
    ///
    /// # Errors
    /// [`PlanError`] if bodies cannot be.
    pub fn packing_of_region(&self) -> Result<Option<f64>, PlanError> {
        let Some(region) = self.region() else {
            return Ok(None);
        };
        let whole = Region {
            low: [0.0; 3],
            high: self.gas.lengths,
        };
        let [open, all] = [region, whole].map(|one| {
            let share = self.uncovered_share(&one);
            share.map(|share| share * one.volume(self.gas.dimension))
        });
        Ok(Some(self.gas.packing_fraction * all? / open?))
    }

    /// Checks that the start region lies inside the box and has space for the particles.
    pub(super) fn check_region(&self) -> Result<(), PlanError> {
        let Some(region) = self.region() else {
            return Ok(());
        };
        let unit = self.scale.length;
        let axes = 0..self.gas.dimension;
        let inside = |axis: usize| {
            let most = self.gas.lengths[axis] * (1.0 + 1e-12);
            region.low[axis] >= 0.0 && region.high[axis] <= most
        };
        let sides: Vec<String> = (self.gas.lengths[..self.gas.dimension].iter())
            .map(|side| format_number(side * unit))
            .collect();
        let allowed = format!("a region inside the box of {}", sides.join(" x "));
        PlanError::require(axes.clone().all(inside), KEY, "", allowed)?;
        if !(self.keeps_apart() || self.keeps_clear()) {
            return Ok(());
        }
        let radii = self.gas.species.iter().map(|one| one.radius);
        let widest = 2.0 * radii.fold(0.0, f64::max);
        let narrowest = axes.map(|axis| region.high[axis] - region.low[axis]);
        let narrowest = narrowest.fold(f64::INFINITY, f64::min);
        let found = format!("a side of {}", format_number(narrowest * unit));
        let allowed = format!(
            "sides longer than the widest particle, {}, as whole particles lie in the region",
            format_number(widest * unit)
        );
        PlanError::require(narrowest > widest * (1.0 + 1e-9), KEY, found, allowed)?;
        let bodies = "a region with room outside the bodies of [[obstacle]]";
        let Some(packing) = self.packing_of_region()?.filter(|one| one.is_finite()) else {
            return Err(PlanError::new(KEY, "bodies cover all of it", bodies));
        };
        if !self.keeps_apart() {
            return Ok(());
        }
        // Unequal particles jam later, by how unequal they are.
        let most = match (self.gas.classes.len(), self.gas.dimension) {
            (1, 2) => JAMMED[0],
            (1, _) => JAMMED[1],
            (_, 2) => PI / 4.0,
            _ => PI / 6.0,
        };
        let found = format!(
            "particles cover {} of what is free in the region",
            format_number(packing)
        );
        let allowed = format!(
            "at most {most:.3}, where random addition jams: a larger region, or fewer or smaller particles"
        );
        PlanError::require(packing <= most, KEY, found, allowed)
    }

    /// Adds the note that theory is of a gas in the whole box, not in the start region.
    pub(super) fn notable_region(&self, list: &mut Vec<String>) {
        if let Ok(Some(packing)) = self.packing_of_region() {
            list.push(format!(
                "start.region: the gas begins in a part of the box, of which it covers {}; t0, mean free time and all theory are of the \
                 gas spread over the whole box",
                format_number(packing)
            ));
        }
    }
}
