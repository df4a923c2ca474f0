//! Error type of the crate, and checks of positions and box lengths that several measurements
//! share.

use nalgebra::{SVector, Vector3};
use serde::{Deserialize, Serialize};
use stosszahl_model::InvalidValue;

/// Error of a measurement or statistical test with invalid input.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The counts of a chi-squared test come in different numbers of observed and expected bins.
    #[error("{observed} observed bins cannot be compared with {expected} expected ones")]
    BinsDiffer {
        /// Number of bins of the observed counts.
        observed: usize,
        /// Number of bins of the expected counts.
        expected: usize,
    },
    /// A chi-squared test has no degree of freedom left.
    #[error("{bins} bins with {fitted} fitted parameters leave no degree of freedom; at least {} are needed", fitted + 2)]
    BinsTooFew {
        /// Number of bins of the chi-squared test.
        bins: usize,
        /// Number of parameters that were fitted to the counts of the chi-squared test.
        fitted: usize,
    },
    /// An observed count of a chi-squared test is negative or not finite.
    #[error("bin {bin} holds the observed count {found}; a count is finite and not negative")]
    ObservedInvalid {
        /// Index of the bin with the invalid observed count.
        bin: usize,
        /// Invalid observed count.
        found: f64,
    },
    /// An expected count is too small for the chi-squared distribution to hold; bins must be
    /// merged.
    #[error("bin {bin} expects {found} counts; merge bins until each expects at least {allowed}")]
    ExpectedTooSmall {
        /// Index of the bin with the small expected count.
        bin: usize,
        /// Expected count that is too small.
        found: f64,
        /// Smallest expected count allowed in a bin.
        allowed: f64,
    },
    /// Observed and expected counts of a chi-squared test have different totals.
    #[error("{observed} observed counts in all against {expected} expected; the totals must agree")]
    TotalsDiffer {
        /// Sum of the observed counts over all bins.
        observed: f64,
        /// Sum of the expected counts over all bins.
        expected: f64,
    },
    /// A side of the periodic box is not a positive finite length.
    #[error("side {axis} of the box has length {found}; it must be positive and finite")]
    LengthInvalid {
        /// Axis of the invalid side, from 0.
        axis: usize,
        /// Invalid length of the side \[length\].
        found: f64,
    },
    /// A parameter is out of its range.
    #[error(transparent)]
    Invalid(#[from] InvalidValue),
    /// The largest wave-number shell of a structure factor is zero, or no shells are requested.
    #[error("the largest wave number must be at least 1")]
    WaveNumberInvalid,
    /// The lattice of the structure factor would have too many sites.
    #[error("a density lattice of {} by {} sites exceeds the {allowed} sites allowed", sites[0], sites[1])]
    LatticeTooLarge {
        /// Number of lattice sites along each axis that the structure factor would need.
        sites: [usize; 2],
        /// Largest total number of lattice sites allowed.
        allowed: usize,
    },
    /// A measurement has too few points.
    #[error("{found} points; at least {needed} are needed")]
    PointsTooFew {
        /// Number of points of the measurement.
        found: usize,
        /// Smallest number of points needed.
        needed: usize,
    },
    /// A position has a coordinate that is infinite or not a number.
    #[error("point {index} lies at ({}, {}, {}); positions must be finite", found[0], found[1], found[2])]
    PositionInvalid {
        /// Index of the point with the invalid position.
        index: usize,
        /// Invalid position \[length\]; 0 beyond the dimension.
        found: [f64; 3],
    },
    /// The range of a pair correlation function is not positive, or exceeds half the shortest side
    /// of the box.
    #[error(
        "the range {found} must be positive and at most {allowed}, half the shortest side of the box"
    )]
    RangeInvalid {
        /// Requested range of distances \[length\].
        found: f64,
        /// Largest range allowed: half the shortest side of the box \[length\].
        allowed: f64,
    },
    /// A pair of reciprocal indices is zero or too large for a Fourier mode.
    #[error("the mode ({}, {}) is none; indices are at most {allowed} in magnitude, and not both zero", found[0], found[1])]
    ModeInvalid {
        /// Invalid pair of reciprocal indices.
        found: [i32; 2],
        /// Largest magnitude allowed for a reciprocal index.
        allowed: u32,
    },
    /// A least-squares fit has too few usable values.
    #[error(
        "{found} usable values; the fit needs at least {needed}, finite and with errors above zero"
    )]
    FitImpossible {
        /// Number of usable values for the fit.
        found: usize,
        /// Smallest number of usable values that the fit needs.
        needed: usize,
    },
    /// A histogram was requested with zero bins, or with more bins than the counts have.
    #[error("a histogram of {found} bins; expected 1 to {}", i32::MAX)]
    HistogramInvalid {
        /// Requested number of bins.
        found: usize,
    },
    /// The measurement was interrupted.
    #[error("interrupted")]
    Interrupted,
}

/// Checks that all sides of a box are positive and finite, and returns an error otherwise.
pub(crate) fn check_lengths(lengths: impl AsRef<[f64]>) -> Result<(), Error> {
    for (axis, &found) in lengths.as_ref().iter().enumerate() {
        if !is_positive(found) {
            return Err(Error::LengthInvalid { axis, found });
        }
    }
    Ok(())
}

/// Checks that there are at least `needed` points and that all positions are finite, and returns an
/// error otherwise.
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

/// Count and validity check of points that are added one by one, possibly in several processes.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub(crate) struct Seen {
    /// Number of points with a finite position.
    pub(crate) count: usize,
    /// Example of a position that is not finite; `None` if all are finite.
    bad: Option<[f64; 3]>,
}

impl Seen {
    /// Counts a point and returns true if its position is finite; otherwise [`Self::check`] will
    /// fail.
    #[inline]
    pub(crate) fn is_good(&mut self, position: Vector3<f64>) -> bool {
        let is_good = position.iter().all(|part| part.is_finite());
        if !is_good {
            self.bad.get_or_insert(position.into());
        }
        is_good
    }

    /// Adds the points that another process or thread has counted.
    pub(crate) fn merge(&mut self, other: &Self) {
        self.count += other.count;
        self.bad = self.bad.or(other.bad);
    }

    /// Returns an error if there were fewer than `needed` points, or a position that is not finite.
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
