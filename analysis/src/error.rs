//! Error type of the crate, and the checks that several measurements share.

use nalgebra::{SVector, Vector3};
use serde::{Deserialize, Serialize};
use stosszahl_model::InvalidValue;

/// Error of a measurement or a test, with the numbers that it refused.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// Observed and expected counts come in different numbers of bins.
    #[error("{observed} observed bins cannot be compared with {expected} expected ones")]
    BinsDiffer {
        /// Number of observed bins.
        observed: usize,
        /// Number of expected bins.
        expected: usize,
    },
    /// No degree of freedom is left.
    #[error("{bins} bins with {fitted} fitted parameters leave no degree of freedom; at least {} are needed", fitted + 2)]
    BinsTooFew {
        /// Number of bins.
        bins: usize,
        /// Number of parameters fitted to the same counts.
        fitted: usize,
    },
    /// An observed count is negative or not finite.
    #[error("bin {bin} holds the observed count {found}; a count is finite and not negative")]
    ObservedInvalid {
        /// Index of the bin.
        bin: usize,
        /// Observed count of the bin.
        found: f64,
    },
    /// An expected count is too small for the chi-squared distribution to hold; merge bins.
    #[error("bin {bin} expects {found} counts; merge bins until each expects at least {allowed}")]
    ExpectedTooSmall {
        /// Index of the bin.
        bin: usize,
        /// Expected count of the bin.
        found: f64,
        /// Smallest expected count allowed.
        allowed: f64,
    },
    /// Observed and expected counts have different totals.
    #[error("{observed} observed counts in all against {expected} expected; the totals must agree")]
    TotalsDiffer {
        /// Sum of the observed counts.
        observed: f64,
        /// Sum of the expected counts.
        expected: f64,
    },
    /// A side of the box is not a positive finite length.
    #[error("side {axis} of the box has length {found}; it must be positive and finite")]
    LengthInvalid {
        /// Axis of the side, from 0.
        axis: usize,
        /// Length of the side.
        found: f64,
    },
    /// A number is out of range.
    #[error(transparent)]
    Invalid(#[from] InvalidValue),
    /// The largest shell is zero, or there are no shells.
    #[error("the largest wave number must be at least 1")]
    WaveNumberInvalid,
    /// The lattice of the structure factor would have too many sites.
    #[error("a density lattice of {} by {} sites exceeds the {allowed} sites allowed", sites[0], sites[1])]
    LatticeTooLarge {
        /// Lattice sites along each axis.
        sites: [usize; 2],
        /// Largest number of sites in all.
        allowed: usize,
    },
    /// Too few points to measure on.
    #[error("{found} points; at least {needed} are needed")]
    PointsTooFew {
        /// Number of points found.
        found: usize,
        /// Smallest number of points allowed.
        needed: usize,
    },
    /// A position is infinite or not a number.
    #[error("point {index} lies at ({}, {}, {}); positions must be finite", found[0], found[1], found[2])]
    PositionInvalid {
        /// Index of the point.
        index: usize,
        /// Position found; 0 beyond the dimension.
        found: [f64; 3],
    },
    /// The range of distances is not positive, or reaches beyond the nearest periodic image.
    #[error(
        "the range {found} must be positive and at most {allowed}, half the shortest side of the box"
    )]
    RangeInvalid {
        /// Range found \[length\].
        found: f64,
        /// Largest range allowed \[length\].
        allowed: f64,
    },
    /// A pair of reciprocal indices that is no mode.
    #[error("the mode ({}, {}) is none; indices are at most {allowed} in magnitude, and not both zero", found[0], found[1])]
    ModeInvalid {
        /// Reciprocal indices found.
        found: [i32; 2],
        /// Largest magnitude of an index.
        allowed: u32,
    },
    /// A fit has too few usable values.
    #[error(
        "{found} usable values; the fit needs at least {needed}, finite and with errors above zero"
    )]
    FitImpossible {
        /// Number of usable values.
        found: usize,
        /// Smallest number of usable values that the fit needs.
        needed: usize,
    },
    /// A histogram without bins was requested, or with more than are counted.
    #[error("a histogram of {found} bins; expected 1 to {}", i32::MAX)]
    HistogramInvalid {
        /// Number of bins.
        found: usize,
    },
    /// The measurement was interrupted.
    #[error("interrupted")]
    Interrupted,
}

/// Refuses a box with a side that is not positive and finite.
pub(crate) fn check_lengths(lengths: impl AsRef<[f64]>) -> Result<(), Error> {
    for (axis, &found) in lengths.as_ref().iter().enumerate() {
        if !is_positive(found) {
            return Err(Error::LengthInvalid { axis, found });
        }
    }
    Ok(())
}

/// Refuses fewer points than needed, and positions that are not finite.
pub(crate) fn check_positions<const D: usize>(
    positions: &[SVector<f64, D>],
    needed: usize,
) -> Result<(), Error> {
    if positions.len() < needed {
        return Err(Error::PointsTooFew {
            found: positions.len(),
            needed,
        });
    }
    match positions
        .iter()
        .position(|r| !r.iter().all(|part| part.is_finite()))
    {
        Some(index) => Err(Error::PositionInvalid {
            index,
            found: [0, 1, 2].map(|axis| positions[index].get(axis).copied().unwrap_or(0.0)),
        }),
        None => Ok(()),
    }
}

/// Number and validity of the points of a sum, which are added one by one in several processes.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub(crate) struct Seen {
    /// Number of points that count.
    pub(crate) count: usize,
    /// A position that is not finite, if there is one.
    bad: Option<[f64; 3]>,
}

impl Seen {
    /// Returns true if a position is finite; otherwise [`Self::check`] refuses all.
    #[inline]
    pub(crate) fn is_good(&mut self, position: Vector3<f64>) -> bool {
        let is_good = position.iter().all(|part| part.is_finite());
        if !is_good {
            self.bad.get_or_insert(position.into());
        }
        is_good
    }

    /// Adds the points of another count.
    pub(crate) fn merge(&mut self, other: &Self) {
        self.count += other.count;
        self.bad = self.bad.or(other.bad);
    }

    /// Refuses fewer points than needed, and positions that are not finite, whose index is unknown.
    pub(crate) fn check(&self, needed: usize) -> Result<(), Error> {
        if self.count < needed {
            let found = self.count;
            return Err(Error::PointsTooFew { found, needed });
        }
        let bad = self.bad;
        bad.map_or(Ok(()), |found| {
            Err(Error::PositionInvalid { index: 0, found })
        })
    }
}

/// Returns true if a number is positive and finite.
pub(crate) fn is_positive(number: f64) -> bool {
    number > 0.0 && number.is_finite()
}
