//! Partial pair correlation functions of mixtures, by counting pairs of all species and of two at a
//! time.

use nalgebra::{SVector, Vector3};
use stosszahl_model::{Interrupt, InvalidValue};

use super::by_cells::{Histogram, count_by_cells};
use super::{PairCorrelation, check_range, correlation, like_pairs};
use crate::Error;
use crate::error::check_positions;

/// Measures the partial pair correlations g(r) of the points of several species, in a box in the
/// plane or in space, for all pairs (a, b) of species in the order of
/// [`pair_index`](crate::contact_value::pair_index).
///
/// ```text
/// g_ab(r) = pairs of a and b (r .. r + Δr) / [N_a N_b A(r .. r + Δr) / V]
/// ```
///
/// and `½ N_a (N_a - 1)` in place of `N_a N_b` for pairs of one species. Bins of a pair of species
/// that has no two points are no numbers.
///
/// # Errors
/// As [`of_disks`](super::of_disks), for the points of all species together.
pub fn of_species(
    species: &[Vec<Vector3<f64>>],
    lengths: &[f64],
    diameter: f64,
    range: f64,
    bins: usize,
    interrupt: &Interrupt,
) -> Result<Vec<PairCorrelation>, Error> {
    let all: Vec<Vector3<f64>> = species.iter().flatten().copied().collect();
    check_range(lengths, range, bins)?;
    InvalidValue::unless_positive("diameter", diameter)?;
    check_positions(&all, 2)?;
    let count = |points: &mut dyn Iterator<Item = &Vector3<f64>>| match *lengths {
        [x, y] => neighbours([x, y], range, bins, points, interrupt),
        [x, y, z] => neighbours([x, y, z], range, bins, points, interrupt),
        _ => Ok(vec![0; bins]),
    };
    let alone: Vec<Vec<u64>> = species
        .iter()
        .map(|points| count(&mut points.iter()))
        .collect::<Result<_, Error>>()?;
    let mut found = Vec::new();
    for b in 0..species.len() {
        for a in 0..b {
            // All pairs of both less those of each alone.
            let both = count(&mut species[a].iter().chain(&species[b]))?;
            let unlike = both.iter().zip(alone[a].iter().zip(&alone[b]));
            let unlike: Vec<u64> = unlike.map(|(both, (a, b))| both - a - b).collect();
            let pairs = species[a].len() as f64 * species[b].len() as f64;
            found.push(correlation(lengths, diameter, range, pairs, &unlike));
        }
        let pairs = like_pairs(species[b].len(), species[b].len());
        found.push(correlation(lengths, diameter, range, pairs, &alone[b]));
    }
    Ok(found)
}

/// Counts the neighbours of points by distance bin; each pair counts twice.
fn neighbours<const D: usize>(
    lengths: [f64; D],
    range: f64,
    bins: usize,
    points: &mut dyn Iterator<Item = &Vector3<f64>>,
    interrupt: &Interrupt,
) -> Result<Vec<u64>, Error> {
    let mut histogram = Histogram::new(lengths, range, bins);
    let centre = |place: &Vector3<f64>| (SVector::from_fn(|axis, _| place[axis]), true);
    let points: Vec<(SVector<f64, D>, bool)> = points.map(centre).collect();
    count_by_cells(&points, &mut histogram, interrupt)?;
    Ok(histogram.bins().to_vec())
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_xoshiro::Xoshiro256PlusPlus;

    use super::super::shell;
    use super::*;

    /// Partial `g_ab(r)` of three species against a count over all pairs, in the plane and in
    /// space; a species of one point has no pairs of its own.
    #[test]
    fn partial_correlations_are_those_of_all_pairs() {
        let stream = &mut Xoshiro256PlusPlus::seed_from_u64(21);
        let (range, bins) = (2.0, 4);
        for lengths in [&[6.0, 5.0][..], &[5.0, 6.0, 4.5]] {
            let mut number = || stream.random::<f64>();
            let mut point = || {
                let place = |axis: usize, _| lengths.get(axis).map_or(0.0, |side| side * number());
                Vector3::from_fn(place)
            };
            let species: Vec<Vec<Vector3<f64>>> = [40, 25, 1]
                .map(|count| (0..count).map(|_| point()).collect())
                .into();
            let found = of_species(&species, lengths, 1.0, range, bins, &Interrupt::default())
                .expect("points");
            assert_eq!(found.len(), 6);
            let volume: f64 = lengths.iter().product();
            for b in 0..3 {
                for a in 0..=b {
                    let mut counts = vec![0_u64; bins];
                    for (i, one) in species[a].iter().enumerate() {
                        for (j, other) in species[b].iter().enumerate() {
                            let mut line = one - other;
                            for (axis, side) in lengths.iter().enumerate() {
                                line[axis] -= side * (line[axis] / side).round();
                            }
                            let bin = (line.norm() / range * bins as f64) as usize;
                            if bin < bins && (a != b || j < i) {
                                counts[bin] += 1;
                            }
                        }
                    }
                    let one = &found[crate::contact_value::pair_index([a, b])];
                    let numbers: Vec<u64> = one.bins.iter().map(|bin| bin.pairs).collect();
                    assert_eq!(numbers, counts, "{a} {b}");
                    let [n, m] = [a, b].map(|one| species[one].len() as f64);
                    let pairs = if a == b { 0.5 * n * (n - 1.0) } else { n * m };
                    let (area, _) = shell(lengths.len(), 1.5, 2.0);
                    let expected = counts[3] as f64 / (pairs / volume * area);
                    let last = one.bins[3].g;
                    assert!(pairs == 0.0 && last.is_nan() || (last - expected).abs() < 1e-12);
                }
            }
        }
    }
}
