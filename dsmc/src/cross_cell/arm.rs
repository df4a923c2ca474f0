//! Adaptive contact distance of the contact-point scheme, chosen so that the mean momentum transfer
//! distance equals the diameter.
//!
//! Collisions must carry momentum over one contact distance on average, or the pressure is not that
//! of hard particles. Partners drawn around the point of contact lie a little beyond it on average,
//! because the collisions of a simulator thin its neighbourhood: by 2 % of the distance at packing
//! 0.05 and 9 % at 0.5, for one simulator per disk. The point is therefore moved inwards until the
//! mean distance is right. The shift is estimated from the collisions, separately for each packing
//! fraction and for cells beside walls.

use serde::{Deserialize, Serialize};

/// Number of classes of the packing fraction, each a 32nd wide, with a contact distance of their
/// own.
const PACKINGS: usize = 32;

/// Number of classes with an adaptive contact distance: [`PACKINGS`] for whole neighbourhoods, and
/// as many for neighbourhoods cut by walls, where partners are all on one side.
const CLASSES: usize = 2 * PACKINGS;

/// Number of latest collisions over which the mean distance of partners beyond their search point
/// is averaged.
const MEMORY: f64 = 5e4;

/// Weight in collisions of the initial estimate, that partners are at their search point on
/// average.
const PRIOR: f64 = 300.0;

/// Adaptive distance from a simulator to the point around which its partner is sought, for each
/// class of packing fraction: the contact distance, less the mean distance of partners beyond that
/// point.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct ContactDistance {
    /// Mean distance of partners beyond their search point, along the line of centres \[contact
    /// distances\], and the number of collisions it is averaged over, for each class of packing
    /// fraction.
    classes: Vec<[f64; 2]>,
}

/// Partner distances in one time step, for each class of packing fraction: class, sum \[contact
/// distances\] and number of collisions.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(crate) struct Distances(Vec<(u8, f64, f64)>);

/// Returns the class of a packing fraction for the adaptive contact distance. `whole` is false for
/// neighbourhoods cut by walls.
#[inline(always)]
pub(crate) fn class(packing: f64, whole: bool) -> u8 {
    let class = ((packing * PACKINGS as f64) as usize).min(PACKINGS - 1);
    (class + if whole { 0 } else { PACKINGS }) as u8
}

impl Default for ContactDistance {
    fn default() -> Self {
        Self {
            classes: vec![[0.0, PRIOR]; CLASSES],
        }
    }
}

impl Distances {
    /// Adds the distance of two colliding partners along their line of centres \[contact
    /// distances\] to the sum of a class of packing fraction.
    #[inline(always)]
    pub(crate) fn note(&mut self, class: u8, distance: f64) {
        if let Some(entry) = self.0.iter_mut().find(|entry| entry.0 == class) {
            entry.1 += distance;
            entry.2 += 1.0;
        } else {
            self.0.push((class, distance, 1.0));
        }
    }
}

impl ContactDistance {
    /// Returns the distance from a simulator to the point around which its partner is sought
    /// \[contact distances\], for a class of packing fraction.
    #[inline(always)]
    pub(crate) fn reach(&self, class: u8) -> f64 {
        (1.0 - self.classes[usize::from(class)][0]).clamp(Self::SHORTEST, Self::LONGEST)
    }

    /// Returns the largest distance from a simulator to its search point, over all classes of
    /// packing fraction \[contact distances\].
    pub(crate) fn longest(&self) -> f64 {
        (0..CLASSES as u8)
            .map(|class| self.reach(class))
            .fold(0.0, f64::max)
    }

    /// Least distance from a simulator to the point around which its partner is sought \[contact
    /// distances\].
    pub(crate) const SHORTEST: f64 = 0.7;
    /// Largest distance from a simulator to the point around which its partner is sought \[contact
    /// distances\].
    pub(crate) const LONGEST: f64 = 1.1;

    /// Updates the mean distance of partners beyond their search point from the collisions of a
    /// time step, all made with the current distance [`Self::reach`].
    pub(crate) fn learn<'a>(&mut self, steps: impl Iterator<Item = &'a Distances>) {
        let mut sums = [[0.0; 2]; CLASSES];
        for &(class, sum, count) in steps.flat_map(|distances| &distances.0) {
            sums[usize::from(class)][0] += sum;
            sums[usize::from(class)][1] += count;
        }
        for (class, [sum, count]) in sums.into_iter().enumerate() {
            if count > 0.0 {
                let excess = sum / count - self.reach(class as u8);
                let [mean, known] = &mut self.classes[class];
                *known = (*known + count).min(MEMORY.max(count));
                *mean += (excess - *mean) * count / *known;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Partners lie 0.08 beyond the point: the point is drawn in until the mean distance is one.
    #[test]
    fn the_mean_distance_becomes_the_contact_distance() {
        let mut arm = ContactDistance::default();
        let there = class(0.25, true);
        for _ in 0..100 {
            let mut distances = Distances::default();
            for _ in 0..1000 {
                distances.note(there, arm.reach(there) + 0.08);
            }
            arm.learn([&distances].into_iter());
        }
        // Remaining weight of the prior: 300 of 100 300 collisions.
        assert!((arm.reach(there) - 0.92).abs() < 0.08 * 300.0 / 1e5);
        assert_eq!(arm.reach(class(0.5, true)), 1.0);
        assert_eq!(arm.reach(class(0.25, false)), 1.0);
    }
}
