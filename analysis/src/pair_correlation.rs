//! Pair correlation function g(r): the number of neighbours at a distance over that of independent
//! points, by cell lists.
//!
//! g(r) is the number of pairs found at distance r over the number expected of as many independent
//! points:
//!
//! ```text
//! g(r) = pairs(r .. r + Δr) / [½ N (N - 1) A(r .. r + Δr) / (L_x L_y)]
//! ```
//!
//! A is the area of the annulus; in space, the volume of the shell. A point is no neighbour of
//! itself, so each has N - 1 possible partners and not N. With this normalisation independent
//! points have g = 1 on average at every finite N. Hard disks have g = 0 below one diameter d; at
//! contact g is the factor of their collision frequency (D. Enskog, 1922; M. P. Allen & D. J.
//! Tildesley, *Computer Simulation of Liquids*, section 2.6).
//!
//! Distances are those of the nearest periodic image, so the range is refused beyond half the
//! shortest side of the box. There a second image of a point would be missing from the count.

mod by_cells;
mod partial;

use std::f64::consts::PI;

use nalgebra::{SVector, Vector2, Vector3};
use serde::{Deserialize, Serialize};
use stosszahl_model::{Interrupt, InvalidValue, Particle, ParticleReduction, random};

use self::by_cells::{Histogram, count_by_cells};
pub use self::partial::of_species;
use crate::Error;
use crate::error::{Seen, check_lengths, check_positions};

/// One distance bin of a pair correlation function.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Bin {
    /// Area-weighted mean distance in the bin, in diameters: ⅔ (b³ - a³) / (b² - a²) for a bin from
    /// a to b.
    pub r_over_d: f64,
    /// Value of g(r): pairs found over pairs expected of independent points.
    pub g: f64,
    /// Number of pairs found in the bin, each counted once. A pair with only one centre counts
    /// half.
    pub pairs: u64,
}

/// Pair correlation function in bins of equal width, from distance 0 to the range.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PairCorrelation {
    /// Bins in rising order; bin i holds the distances r with i ≤ r · bins / range < i + 1.
    pub bins: Vec<Bin>,
}

/// Measures g(r) of points in a periodic box in the plane.
///
/// `lengths`, `diameter` and `range` are lengths in the unit of the positions, which are taken
/// modulo the box. The diameter is only the unit of the distances reported. The range ends the last
/// of the `bins`.
///
/// # Errors
/// [`Error::LengthInvalid`], [`Error::Invalid`], [`Error::HistogramInvalid`];
/// [`Error::RangeInvalid`] when the range is not positive or above half the shortest side;
/// [`Error::PointsTooFew`] below two points; [`Error::PositionInvalid`]; [`Error::Interrupted`].
///
/// ```
/// use nalgebra::Vector2;
/// use stosszahl_analysis::pair_correlation::of_disks;
/// use stosszahl_model::Interrupt;
///
/// // Two pairs, each 1 apart, one of them across the edge. Of 6 pairs, 6 · 3 pi / 100 are expected in 1 ..= 2.
/// let points = [(0.5, 1.0), (9.5, 1.0), (5.0, 5.0), (5.0, 6.0)].map(|(x, y)| Vector2::new(x, y));
/// let correlation = of_disks(&points, [10.0, 10.0], 1.0, 3.0, 3, &Interrupt::default())?;
/// let pairs: Vec<u64> = correlation.bins.iter().map(|bin| bin.pairs).collect();
/// assert_eq!(pairs, [0, 2, 0]);
/// assert!((correlation.bins[1].g - 2.0 / (0.18 * std::f64::consts::PI)).abs() < 1e-14);
/// assert!((correlation.bins[1].r_over_d - 14.0 / 9.0).abs() < 1e-15);
/// # Ok::<(), stosszahl_analysis::Error>(())
/// ```
pub fn of_disks(
    positions: &[Vector2<f64>],
    lengths: [f64; 2],
    diameter: f64,
    range: f64,
    bins: usize,
    interrupt: &Interrupt,
) -> Result<PairCorrelation, Error> {
    measure(positions, lengths, diameter, range, bins, interrupt)
}

/// Measures g(r) of points in a periodic box in space, as [`of_disks`] in the plane.
///
/// # Errors
/// As [`of_disks`].
pub fn of_spheres(
    positions: &[Vector3<f64>],
    lengths: [f64; 3],
    diameter: f64,
    range: f64,
    bins: usize,
    interrupt: &Interrupt,
) -> Result<PairCorrelation, Error> {
    measure(positions, lengths, diameter, range, bins, interrupt)
}

/// Measures g(r) in D dimensions. Private and generic, so that it is compiled with the optimisation
/// level of this crate.
fn measure<const D: usize>(
    positions: &[SVector<f64, D>],
    lengths: [f64; D],
    diameter: f64,
    range: f64,
    bins: usize,
    interrupt: &Interrupt,
) -> Result<PairCorrelation, Error> {
    check_range(&lengths, range, bins)?;
    InvalidValue::unless_positive("diameter", diameter)?;
    check_positions(positions, 2)?;
    let mut histogram = Histogram::new(lengths, range, bins);
    let all = |&position| (position, true);
    let points: Vec<_> = positions.iter().map(all).collect();
    count_by_cells(&points, &mut histogram, interrupt)?;
    let pairs = like_pairs(positions.len(), positions.len());
    Ok(correlation(
        &lengths,
        diameter,
        range,
        pairs,
        histogram.bins(),
    ))
}

/// Returns the number of pairs with a centre among `points` points. A pair of two centres counts
/// once, a pair with one centre half.
fn like_pairs(centres: usize, points: usize) -> f64 {
    0.5 * centres as f64 * (points as f64 - 1.0)
}

fn check_range(lengths: &[f64], range: f64, bins: usize) -> Result<(), Error> {
    check_lengths(lengths)?;
    let allowed = lengths.iter().copied().fold(f64::INFINITY, f64::min) / 2.0;
    if !(range > 0.0 && range <= allowed) {
        return Err(Error::RangeInvalid {
            found: range,
            allowed,
        });
    }
    if bins == 0 || i32::try_from(bins).is_err() {
        return Err(Error::HistogramInvalid { found: bins });
    }
    Ok(())
}

/// Computes g(r): neighbours counted in each bin over the number expected of independent points.
/// Each pair counts as two neighbours.
fn correlation(
    lengths: &[f64],
    diameter: f64,
    range: f64,
    pairs: f64,
    neighbours: &[u64],
) -> PairCorrelation {
    let width = range / neighbours.len() as f64;
    let pairs_per_volume = pairs / lengths.iter().product::<f64>();
    let bins = neighbours.iter().enumerate().map(|(i, &neighbours)| {
        let pairs = 0.5 * neighbours as f64;
        let (inner, outer) = (i as f64 * width, (i + 1) as f64 * width);
        let (volume, radius) = shell(lengths.len(), inner, outer);
        Bin {
            r_over_d: radius / diameter,
            g: pairs / (pairs_per_volume * volume),
            pairs: neighbours / 2,
        }
    });
    PairCorrelation {
        bins: bins.collect(),
    }
}

/// Reduction that counts the pairs of a gas by distance, strip by strip of its box
/// ([`stosszahl_model::Simulation::reduce_neighbourhoods`]). Neighbours of chosen centres are
/// counted among the particles in and near the strip.
///
/// Where particles stand for less than one of the gas, only as many of them are centres as there
/// are particles of the gas, chosen by a hash of their positions. Then m simulators per particle
/// have m squared times as many pairs as the gas, of which a share of 2/m is counted. Those are
/// still more than exact dynamics has, so that the error is smaller.
#[derive(Serialize, Deserialize)]
pub struct PairCounts {
    lengths: Vec<f64>,
    range: f64,
    /// Number and validity of the points of all strips so far.
    seen: Seen,
    /// Number of centres: points whose neighbours are counted.
    centres: usize,
    /// Number of neighbours of all centres, by distance bin.
    neighbours: Vec<u64>,
    /// Points of the current strip: position, and whether the point is a centre.
    #[serde(skip)]
    open: Vec<(Vector3<f64>, bool)>,
    #[serde(skip)]
    interrupt: Interrupt,
    #[serde(skip)]
    is_broken_off: bool,
}

impl PairCounts {
    /// Creates empty pair counts for a box in the plane or in space; `interrupt` stops the counting
    /// in this process.
    ///
    /// # Errors
    /// As [`of_disks`].
    pub fn new(
        lengths: &[f64],
        range: f64,
        bins: usize,
        interrupt: &Interrupt,
    ) -> Result<Self, Error> {
        check_range(lengths, range, bins)?;
        Ok(Self {
            lengths: lengths.to_vec(),
            range,
            seen: Seen::default(),
            centres: 0,
            neighbours: vec![0; bins],
            open: Vec::new(),
            interrupt: interrupt.clone(),
            is_broken_off: false,
        })
    }

    /// Computes g(r) from all pairs added so far.
    ///
    /// # Errors
    /// As [`of_disks`]; [`Error::PointsTooFew`] without a centre, too.
    pub fn correlation(&self, diameter: f64) -> Result<PairCorrelation, Error> {
        InvalidValue::unless_positive("diameter", diameter)?;
        self.seen.check(2)?;
        if self.centres == 0 {
            return Err(Error::PointsTooFew {
                found: 0,
                needed: 1,
            });
        }
        if self.is_broken_off {
            return Err(Error::Interrupted);
        }
        let Self { lengths, range, .. } = self;
        Ok(correlation(
            lengths,
            diameter,
            *range,
            like_pairs(self.centres, self.seen.count),
            &self.neighbours,
        ))
    }

    fn count<const D: usize>(&mut self, lengths: [f64; D]) {
        let mut histogram = Histogram::new(lengths, self.range, self.neighbours.len());
        let open = self.open.drain(..);
        let points: Vec<(SVector<f64, D>, bool)> = open
            .map(|(place, is_centre)| (SVector::from_fn(|axis, _| place[axis]), is_centre))
            .collect();
        let counted = count_by_cells(&points, &mut histogram, &self.interrupt);
        self.is_broken_off |= counted.is_err();
        for (sum, more) in self.neighbours.iter_mut().zip(histogram.bins()) {
            *sum += more;
        }
    }
}

impl ParticleReduction for PairCounts {
    const NAME: &'static str = "pairs";

    fn add_particle(&mut self, particle: &Particle) {
        let Particle {
            position, weight, ..
        } = *particle;
        self.seen.count += usize::from(weight > 0.0);
        let is_centre = weight > random::unit_hash(position.into_iter());
        self.centres += usize::from(is_centre);
        if self.seen.is_good(position) {
            self.open.push((position, is_centre));
        }
    }

    fn close_group(&mut self, _strip: u32) {
        match *self.lengths {
            [x, y] => self.count([x, y]),
            [x, y, z] => self.count([x, y, z]),
            _ => {}
        }
    }

    fn merge_sum(&mut self, other: Self) {
        self.seen.merge(&other.seen);
        self.centres += other.centres;
        for (sum, more) in self.neighbours.iter_mut().zip(other.neighbours) {
            *sum += more;
        }
    }
}

/// Returns the volume of the shell between two radii (its area in the plane), and the mean distance
/// of its points from the centre.
fn shell(dimension: usize, inner: f64, outer: f64) -> (f64, f64) {
    if dimension == 2 {
        let squares = outer * outer - inner * inner;
        let radius = 2.0 / 3.0 * (outer.powi(3) - inner.powi(3)) / squares;
        (PI * squares, radius)
    } else {
        let cubes = outer.powi(3) - inner.powi(3);
        let radius = 3.0 / 4.0 * (outer.powi(4) - inner.powi(4)) / cubes;
        (4.0 / 3.0 * PI * cubes, radius)
    }
}

#[cfg(test)]
#[allow(
    clippy::unwrap_used,
    reason = "in a test, an unexpected error is a failure"
)]
mod tests {
    use super::by_cells::sides;
    use super::*;
    use crate::statistics::{Estimate, student_t_test};
    use proptest::prelude::*;
    use proptest::test_runner::RngSeed;
    use rand::{RngExt, SeedableRng};
    use rand_xoshiro::Xoshiro256PlusPlus;

    /// Measures the pair correlation of points without an interrupt, for tests.
    fn measure<const D: usize>(
        positions: &[SVector<f64, D>],
        lengths: [f64; D],
        diameter: f64,
        range: f64,
        bins: usize,
    ) -> Result<PairCorrelation, Error> {
        let never = Interrupt::default();
        super::measure(positions, lengths, diameter, range, bins, &never)
    }

    /// Counts all pairs of points by distance, one by one, as a reference for tests.
    fn all_pairs<const D: usize>(
        positions: &[SVector<f64, D>],
        lengths: [f64; D],
        range: f64,
        bins: usize,
    ) -> Vec<u64> {
        let mut found = vec![0; bins];
        for (i, one) in positions.iter().enumerate() {
            for other in &positions[..i] {
                let mut squared = 0.0;
                for (axis, &length) in lengths.iter().enumerate() {
                    let apart = one[axis] - other[axis];
                    let apart = apart - length * (apart / length).round();
                    squared += apart * apart;
                }
                if squared < range * range {
                    let bin = (f64::sqrt(squared) * (bins as f64 / range)) as usize;
                    found[bin.min(bins - 1)] += 1;
                }
            }
        }
        found
    }

    fn pairs(correlation: &PairCorrelation) -> Vec<u64> {
        correlation.bins.iter().map(|bin| bin.pairs).collect()
    }

    /// Returns a strategy that draws coordinates in units of the side: at random, in a tight
    /// cluster, on cell edges, and on or beyond the edge of the box.
    fn coordinate() -> impl Strategy<Value = f64> {
        prop_oneof![
            0.0_f64..1.0,
            -1.5_f64..2.5,
            0.32_f64..0.34,
            (0_u32..=20).prop_map(|i| f64::from(i) / 20.0),
            prop_oneof![
                Just(0.0),
                Just(-0.0),
                Just(1.0),
                Just(-1e-18),
                Just(1.0 - f64::EPSILON / 2.0)
            ],
        ]
    }

    proptest! {
        #![proptest_config(ProptestConfig { rng_seed: RngSeed::Fixed(31), failure_persistence: None, ..ProptestConfig::default() })]

        /// Tests that cell lists and a loop over all pairs count the same pairs, exactly.
        #[test]
        fn cells_match_all_pairs(
            fractions in prop::collection::vec((coordinate(), coordinate()), 2..120),
            lengths in prop_oneof![Just([10.0, 10.0]), Just([10.0, 4.0]), Just([3.7, 11.3]), Just([1e4, 0.5])],
            part in prop_oneof![Just(1.0), Just(2.0 / 3.0), Just(0.5), Just(0.4), Just(0.2), 0.01_f64..1.0],
            bins in 1_usize..40,
        ) {
            let positions: Vec<_> = fractions.iter().map(|f| Vector2::new(f.0 * lengths[0], f.1 * lengths[1])).collect();
            let range = part * lengths[0].min(lengths[1]) / 2.0;
            let found = measure(&positions, lengths, 1.0, range, bins).unwrap();
            prop_assert_eq!(pairs(&found), all_pairs(&positions, lengths, range, bins));
        }
    }

    #[test]
    fn cells_match_all_pairs_on_many_points() {
        // Half the points at random, half in clusters, with enough cells that most are not
        // neighbours.
        let mut stream = Xoshiro256PlusPlus::seed_from_u64(32);
        let positions: Vec<_> = (0..3000_u32)
            .map(|i| {
                let spread = if i.is_multiple_of(2) { 50.0 } else { 2.0 };
                let centre = f64::from(i % 7) * 7.0;
                Vector2::new(
                    centre + spread * stream.random::<f64>(),
                    centre + spread * stream.random::<f64>(),
                )
            })
            .collect();
        for range in [1.0, 2.5, 12.0, 25.0] {
            let found = measure(&positions, [50.0; 2], 1.0, range, 50).unwrap();
            assert_eq!(pairs(&found), all_pairs(&positions, [50.0; 2], range, 50));
        }
    }

    /// Tests in space that cell lists and a loop over all pairs count the same pairs, and that
    /// independent points have g near 1. Of 2000 points, 20 bins, the outer ones hold thousands of
    /// pairs, of which four errors of counting are allowed.
    #[test]
    fn cells_match_all_pairs_in_space() {
        let mut stream = Xoshiro256PlusPlus::seed_from_u64(34);
        let lengths = [9.0, 12.0, 7.0];
        let positions: Vec<Vector3<f64>> = (0..2000)
            .map(|_| Vector3::from(lengths.map(|side| side * stream.random::<f64>())))
            .collect();
        for range in [1.0, 2.2, 3.5] {
            let found = measure(&positions, lengths, 1.0, range, 20).unwrap();
            assert_eq!(pairs(&found), all_pairs(&positions, lengths, range, 20));
            assert_eq!(in_strips(&positions, lengths, range), found);
            for bin in &found.bins[10..] {
                assert!(
                    (bin.g - 1.0).abs() < 4.0 / (bin.pairs as f64).sqrt(),
                    "{bin:?}"
                );
            }
        }
    }

    /// Measures g(r) with the points cut into three uneven strips, each counted by another sum that
    /// sees all other points as near.
    fn in_strips(positions: &[Vector3<f64>], lengths: [f64; 3], range: f64) -> PairCorrelation {
        let empty = || PairCounts::new(&lengths, range, 20, &Interrupt::default()).unwrap();
        let mut all = empty();
        for strip in [2, 0, 1] {
            let mut own = empty();
            for &position in positions {
                let is_own = (position.x.sqrt() as usize).min(2) == strip;
                ParticleReduction::add_particle(
                    &mut own,
                    &Particle {
                        position,
                        weight: if is_own { 2.0 } else { 0.0 },
                        ..Particle::at_rest(0.5, 1.0)
                    },
                );
            }
            ParticleReduction::close_group(&mut own, strip as u32);
            ParticleReduction::merge_sum(&mut all, own);
        }
        all.correlation(1.0).unwrap()
    }

    /// Measures g(r) by [`PairCounts`] of simulators that stand for less than a particle each.
    fn of_weight(
        positions: &[Vector3<f64>],
        lengths: &[f64],
        range: f64,
        weight: f64,
    ) -> PairCounts {
        let mut pairs = PairCounts::new(lengths, range, 20, &Interrupt::default()).unwrap();
        for &position in positions {
            let particle = Particle {
                position,
                weight,
                ..Particle::at_rest(0.5, 1.0)
            };
            ParticleReduction::add_particle(&mut pairs, &particle);
        }
        ParticleReduction::close_group(&mut pairs, 0);
        pairs
    }

    /// Tests the neighbours of some centres, half of all points in a cluster, against a loop over
    /// all their pairs, exactly.
    #[test]
    fn centres_meet_all_their_neighbours() {
        let mut stream = Xoshiro256PlusPlus::seed_from_u64(35);
        let lengths = [9.0, 12.0, 7.0];
        let positions: Vec<Vector3<f64>> = (0..1500_u32)
            .map(|i| {
                let part = if i.is_multiple_of(2) { 1.0 } else { 0.2 };
                Vector3::from(lengths.map(|side| part * side * stream.random::<f64>()))
            })
            .collect();
        for (dimension, range) in [(2, 1.0), (2, 4.4), (3, 1.0), (3, 3.4)] {
            let flat = |one: &Vector3<f64>| {
                Vector3::from_fn(|i, _| if i < dimension { one[i] } else { 0.0 })
            };
            let positions: Vec<_> = positions.iter().map(flat).collect();
            let pairs = of_weight(&positions, &lengths[..dimension], range, 0.1);
            let (mut centres, mut neighbours) = (0, vec![0; 20]);
            for (i, one) in positions.iter().enumerate() {
                if random::unit_hash(one.iter()) >= 0.1 {
                    continue;
                }
                centres += 1;
                for (_, other) in positions.iter().enumerate().filter(|(j, _)| *j != i) {
                    for (sum, more) in
                        neighbours
                            .iter_mut()
                            .zip(all_pairs(&[*one, *other], lengths, range, 20))
                    {
                        *sum += more;
                    }
                }
            }
            assert!((100..200).contains(&centres), "{centres}");
            assert_eq!((pairs.centres, pairs.neighbours), (centres, neighbours));
        }
    }

    /// Tests boxes far narrower than a cell, or whose area is no number: there are no more cells
    /// than points.
    #[test]
    fn cells_are_few_in_every_box() {
        for (lengths, range) in [
            ([1e9, 1e-3], 4e-4),
            ([1e-150, 1e150], 4e-151),
            ([1e300, 1e300], 1.0),
            ([1e-200, 1e-200], 1e-320),
        ] {
            for points in [0, 1, 2, 1000] {
                let sides = sides(points, lengths, range);
                assert!(
                    sides.iter().product::<usize>() <= points.max(8),
                    "{sides:?}"
                );
            }
        }
        assert_eq!(sides(1000, [1e9, 1e-3], 4e-4)[1..], [1, 1]);
    }

    #[test]
    fn square_lattice_has_known_neighbours() {
        // Neighbours at 1 (4), sqrt 2 (4), 2 (4), sqrt 5 (8) and sqrt 8 (4): half of each per
        // point.
        let positions: Vec<_> = (0..100)
            .map(|i| Vector2::new(f64::from(i % 10), f64::from(i / 10)))
            .collect();
        let found = measure(&positions, [10.0; 2], 1.0, 2.9, 29).unwrap();
        for (bin, count) in pairs(&found).into_iter().enumerate() {
            let per_point = match bin {
                10 | 14 | 20 | 28 => 2,
                22 => 4,
                _ => 0,
            };
            assert_eq!(count, 100 * per_point, "bin {bin}");
        }
    }

    #[test]
    fn distances_are_in_diameters() {
        let positions = [Vector2::new(0.0, 0.0), Vector2::new(0.3, 0.4)];
        let found = measure(&positions, [8.0; 2], 0.25, 4.0, 16).unwrap();
        let wide = measure(&positions, [8.0; 2], 1.0, 4.0, 16).unwrap();
        for (found, wide) in found.bins.iter().zip(&wide.bins) {
            assert_eq!(found.r_over_d, 4.0 * wide.r_over_d);
            assert_eq!((found.g, found.pairs), (wide.g, wide.pairs));
        }
        // The first bin is a disk, with mean distance 2/3 of its radius 1/4.
        assert!((wide.bins[0].r_over_d - 1.0 / 6.0).abs() < 1e-15);
    }

    /// Tests that independent points have g = 1, with pairs normalised by N - 1. Forty bins at z =
    /// 4 raise a false alarm for one seed in 400. With N in place of N - 1, ten points would be off
    /// by 0.1, which errors below 0.025 show at z = 4; many points must agree to 0.02.
    #[test]
    fn independent_points_have_no_correlation() {
        let mut stream = Xoshiro256PlusPlus::seed_from_u64(33);
        for (count, configurations, widest) in [(10, 40_000, 0.025), (2000, 60, 0.005)] {
            let samples: Vec<PairCorrelation> = (0..configurations)
                .map(|_| {
                    let positions: Vec<_> = (0..count)
                        .map(|_| {
                            Vector2::new(
                                40.0 * stream.random::<f64>(),
                                30.0 * stream.random::<f64>(),
                            )
                        })
                        .collect();
                    measure(&positions, [40.0, 30.0], 1.0, 15.0, 20).unwrap()
                })
                .collect();
            for bin in 0..20 {
                let values: Vec<f64> = samples.iter().map(|sample| sample.bins[bin].g).collect();
                let estimate = Estimate::over_replicas(&values).unwrap();
                let z = student_t_test(&values, 1.0).unwrap().normal_z;
                assert!(
                    z.abs() < 4.0,
                    "{count} points, bin {bin}: {estimate:?}, z = {z}"
                );
                assert!(estimate.standard_error.unwrap() < widest, "{estimate:?}");
            }
        }
    }

    /// Tests that independent simulators of an eighth of a particle, of which an eighth are
    /// centres, have g = 1. 60 configurations of 2000 have 15 000 of 120 000, with a standard error
    /// of 115.
    #[test]
    fn few_centres_have_no_correlation_either() {
        let mut stream = Xoshiro256PlusPlus::seed_from_u64(36);
        let lengths = [40.0, 30.0];
        let mut place = || {
            Vector3::new(
                40.0 * stream.random::<f64>(),
                30.0 * stream.random::<f64>(),
                0.0,
            )
        };
        let samples: Vec<PairCounts> = (0..60)
            .map(|_| {
                let positions: Vec<_> = (0..2000).map(|_| place()).collect();
                of_weight(&positions, &lengths, 15.0, 0.125)
            })
            .collect();
        let centres: usize = samples.iter().map(|pairs| pairs.centres).sum();
        assert!((centres as f64 - 15_000.0).abs() < 4.0 * 115.0, "{centres}");
        for bin in 0..20 {
            let g = |pairs: &PairCounts| pairs.correlation(1.0).unwrap().bins[bin].g;
            let values: Vec<f64> = samples.iter().map(g).collect();
            let estimate = Estimate::over_replicas(&values).unwrap();
            let z = student_t_test(&values, 1.0).unwrap().normal_z;
            assert!(z.abs() < 4.0, "bin {bin}: {estimate:?}, z = {z}");
            assert!(estimate.standard_error.unwrap() < 0.01, "{estimate:?}");
        }
    }

    #[test]
    fn bad_input_is_refused() {
        let two = [Vector2::new(1.0, 1.0), Vector2::new(2.0, 2.0)];
        let bad = [Vector2::new(1.0, 1.0), Vector2::new(f64::INFINITY, 2.0)];
        let allowed = 4.0;
        assert_eq!(
            measure(&two, [8.0, -1.0], 1.0, 1.0, 4),
            Err(Error::LengthInvalid {
                axis: 1,
                found: -1.0
            })
        );
        assert_eq!(
            measure(&two, [8.0; 2], 0.0, 1.0, 4),
            Err(InvalidValue::new("diameter", 0.0, "finite numbers above 0").into())
        );
        for found in [0.0, -1.0, 4.0 + 1e-12, f64::INFINITY] {
            assert_eq!(
                measure(&two, [8.0, 9.0], 1.0, found, 4),
                Err(Error::RangeInvalid { found, allowed })
            );
        }
        assert!(matches!(
            measure(&two, [8.0; 2], 1.0, f64::NAN, 4),
            Err(Error::RangeInvalid { .. })
        ));
        for found in [0, 1 << 31] {
            assert_eq!(
                measure(&two, [8.0; 2], 1.0, 1.0, found),
                Err(Error::HistogramInvalid { found })
            );
        }
        assert_eq!(
            measure(&two[..1], [8.0; 2], 1.0, 1.0, 4),
            Err(Error::PointsTooFew {
                found: 1,
                needed: 2
            })
        );
        assert!(matches!(
            measure(&bad, [8.0; 2], 1.0, 1.0, 4),
            Err(Error::PositionInvalid { index: 1, .. })
        ));
        assert!(measure(&two, [8.0, 9.0], 1.0, allowed, 4).is_ok());
        let none = of_weight(&[Vector3::x(), Vector3::y()], &[8.0, 9.0], 1.0, 1e-300);
        assert_eq!(
            none.correlation(1.0),
            Err(Error::PointsTooFew {
                found: 0,
                needed: 1
            })
        );
        let now = Interrupt::default();
        now.raise();
        let ended = of_disks(&two, [8.0, 9.0], 1.0, allowed, 4, &now);
        assert_eq!(ended, Err(Error::Interrupted));
    }
}
