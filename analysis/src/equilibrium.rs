//! Tests whether an elastic gas has forgotten the lattice of its initial state.
//!
//! Three tests, each with its false-alarm probability: impact parameters are uniform; no Bragg peak
//! of the lattice is left; density fluctuations of long wavelength are those of the fluid. The last
//! matters most: they relax slowest, and a lattice has none.

use std::f64::consts::TAU;
use stosszahl_model::equation_of_state;

use nalgebra::Vector2;
use serde::{Deserialize, Serialize};
use statrs::distribution::{ContinuousCDF, FisherSnedecor};

use crate::modes::Modes;
use crate::statistics::uniform_test;
use crate::structure_factor::bragg_peaks;

/// Probability with which each test of equilibration fails a gas in equilibrium.
pub const FALSE_ALARM: f64 = 1e-3;

/// Outcome of one test of equilibration.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct EquilibriumTest {
    /// Name of the equilibration test.
    pub name: String,
    /// Test statistic: chi-squared, or a ratio of means; NaN if the sample is too small.
    pub statistic: f64,
    /// Probability of a statistic at least so extreme in equilibrium; `None` if it is unknown.
    pub p_value: Option<f64>,
    /// True if the gas passed the test; `None` if the sample is too small to decide, or the test
    /// does not apply.
    pub passed: Option<bool>,
    /// Result of the test as a sentence, with its numbers.
    pub detail: String,
}

/// Tests by chi-squared whether impact parameters are uniform, P(b/d) = 1. At least 1000 collisions
/// per bin are needed, to see deviations of 10 %.
pub fn impact_uniform(bins: &[u64]) -> EquilibriumTest {
    let name = "uniform impact parameters".to_owned();
    let total: u64 = bins.iter().sum();
    let wide = total < 1000 * bins.len() as u64;
    match uniform_test(bins) {
        Ok(test) => EquilibriumTest {
            name,
            statistic: test.statistic,
            p_value: Some(test.p_value),
            passed: if wide {
                None
            } else {
                Some(test.p_value > FALSE_ALARM)
            },
            detail: format!(
                "chi-squared of {total} collisions in {} bins{}",
                bins.len(),
                if wide { ": too few to tell" } else { "" }
            ),
        },
        Err(error) => EquilibriumTest {
            name,
            statistic: f64::NAN,
            p_value: None,
            passed: None,
            detail: format!("too few collisions ({total}) to tell: {error}"),
        },
    }
}

/// Tests whether the lattice of the start has melted: Bragg peaks at `reciprocal` against wave
/// vectors of about equal length in other directions.
///
/// In a fluid S at a wave vector is exponentially distributed around the mean of its ring, so the
/// ratio of the two means follows the F distribution with (2 m, 2 M) degrees of freedom.
pub fn lattice_forgotten(
    positions: &[Vector2<f64>],
    lengths: [f64; 2],
    reciprocal: &[[i32; 2]],
    packing_fraction: f64,
) -> EquilibriumTest {
    let name = "no Bragg peak of the start".to_owned();
    if packing_fraction >= equation_of_state::FREEZING {
        return EquilibriumTest {
            name,
            statistic: f64::NAN,
            p_value: None,
            passed: None,
            detail: format!(
                "no meaning at packing {packing_fraction}: from {} on the crystal is the equilibrium",
                equation_of_state::FREEZING
            ),
        };
    }
    let ring = ring_around(lengths, reciprocal);
    let peaks = bragg_peaks(positions, lengths, reciprocal);
    let background = bragg_peaks(positions, lengths, &ring);
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    let ratio = mean(&peaks) / mean(&background);
    let freedom = [2.0 * peaks.len() as f64, 2.0 * background.len() as f64];
    let p_value = FisherSnedecor::new(freedom[0], freedom[1])
        .ok()
        .map(|f| f.sf(ratio));
    EquilibriumTest {
        name,
        statistic: ratio,
        p_value,
        passed: p_value.map(|p| p > FALSE_ALARM),
        detail: format!(
            "S at {} lattice peaks over S at {} other directions",
            peaks.len(),
            background.len()
        ),
    }
}

/// Returns up to 60 wave vectors, as reciprocal indices, of nearly the length of the given ones, in
/// other directions.
fn ring_around(lengths: [f64; 2], reciprocal: &[[i32; 2]]) -> Vec<[i32; 2]> {
    let mut ring: Vec<[i32; 2]> = Vec::new();
    for &[x, y] in reciprocal {
        let k = [f64::from(x) / lengths[0], f64::from(y) / lengths[1]];
        let length = k[0].hypot(k[1]);
        // Whole turns would include the negatives, which have the same S.
        for step in 0..20 {
            let angle = std::f64::consts::PI * (f64::from(step) + 0.37) / 20.0;
            let index = [
                (length * angle.cos() * lengths[0]).round() as i32,
                (length * angle.sin() * lengths[1]).round() as i32,
            ];
            let negative = index.map(|n| -n);
            let taken = |known: &[[i32; 2]]| known.contains(&index) || known.contains(&negative);
            if index != [0, 0] && !taken(&ring) && !taken(reciprocal) {
                ring.push(index);
            }
        }
    }
    ring
}

/// Largest k d, wave number times diameter, at which S(k) is taken as S(0): hard-disk structure
/// changes it by less than a tenth.
const LONG_WAVE: f64 = 0.6;
/// Largest number of waves along a side of a square box at which a mode still counts as long.
const LONGEST_WAVES: f64 = 24.0;
/// Largest number of Fourier modes examined. Of more modes, every n-th is taken; the mean of 129 to
/// 256 modes is known to 9 % or better.
const MOST_MODES: usize = 256;

/// Tests density fluctuations of long wavelength against the compressibility of the fluid, S(0) =
/// 1/(d(phi Z)/d phi).
///
/// A perfect lattice has S = 0 there, a forgotten one S(0). The start is called forgotten when the
/// mean S is at least half of S(0). The standard error of the mean over M independent exponential
/// modes is S(0)/sqrt(M), and the test needs it small enough to put that threshold 3.1 standard
/// errors (false alarm 1e-3) away.
pub fn long_waves_fluctuate(
    positions: &[Vector2<f64>],
    lengths: [f64; 2],
    diameter: f64,
    packing_fraction: f64,
) -> EquilibriumTest {
    let name = "long waves of the fluid".to_owned();
    // In a wide box the longest waves only: those that are forgotten last.
    let widest = TAU * LONGEST_WAVES / (lengths[0] * lengths[1]).sqrt();
    let longest = Modes::band(lengths, [0.0, widest.min(LONG_WAVE / diameter)], MOST_MODES);
    let modes = longest.as_ref().map_or(0, |modes| modes.indices().len());
    let expected = equation_of_state::structure_factor_at_zero(packing_fraction);
    // 0.5 of S(0) must be 3.09 standard errors away.
    if modes < 39 || packing_fraction >= equation_of_state::FREEZING {
        let detail = if modes < 39 {
            format!("{modes} modes up to k d = {LONG_WAVE} are too few to tell")
        } else {
            format!("no meaning at packing {packing_fraction}: not a fluid")
        };
        return EquilibriumTest {
            name,
            statistic: f64::NAN,
            p_value: None,
            passed: None,
            detail,
        };
    }
    let count = modes as f64;
    let sums = longest.and_then(|modes| modes.sums(positions, |_| [1.0]));
    let powers = sums.map(|sums| sums.iter().map(|[sum]| sum.norm_sqr()).sum::<f64>());
    let ratio = powers.unwrap_or(f64::NAN) / (positions.len() as f64 * count * expected);
    EquilibriumTest {
        name,
        statistic: ratio,
        p_value: None,
        passed: Some(ratio > 0.5),
        detail: format!(
            "S over S(0) = {expected:.4} of the fluid, mean of {count} modes: {ratio:.3} +- {:.3}; a lattice has 0, at least 0.5 is asked",
            ratio / count.sqrt()
        ),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_xoshiro::Xoshiro256PlusPlus;
    use stosszahl_model::initial::{Arrangement, place_disks};
    use stosszahl_model::random::Streams;
    use stosszahl_model::{Domain, Interrupt, Plane};

    fn placed(arrangement: Arrangement) -> (Vec<Vector2<f64>>, Vec<[i32; 2]>, [f64; 2]) {
        let side = (4096.0 * std::f64::consts::FRAC_PI_4 / 0.25_f64).sqrt();
        let domain = Domain::<Plane>::periodic([side, side].into()).expect("a box");
        let (streams, never) = (Streams::new(1, 0), Interrupt::default());
        let placement =
            place_disks(arrangement, 4096, 1.0, &domain, &streams, &never).expect("placed");
        (placement.positions, placement.reciprocal, [side, side])
    }

    #[test]
    fn lattices_are_remembered_and_disorder_is_not() {
        for arrangement in [Arrangement::Square, Arrangement::Hexagonal] {
            let (positions, reciprocal, lengths) = placed(arrangement);
            let bragg = lattice_forgotten(&positions, lengths, &reciprocal, 0.25);
            assert_eq!(bragg.passed, Some(false), "{bragg:?}");
            let waves = long_waves_fluctuate(&positions, lengths, 1.0, 0.25);
            assert_eq!(waves.passed, Some(false), "{waves:?}");
            let (positions, _, _) = placed(Arrangement::Disordered);
            let bragg = lattice_forgotten(&positions, lengths, &reciprocal, 0.25);
            assert_eq!(bragg.passed, Some(true), "{bragg:?}");
            let waves = long_waves_fluctuate(&positions, lengths, 1.0, 0.25);
            assert_eq!(waves.passed, Some(true), "{waves:?}");
        }
    }

    #[test]
    fn impact_parameters_too_few_uniform_and_not() {
        assert_eq!(impact_uniform(&[3; 20]).passed, None);
        let mut stream = Xoshiro256PlusPlus::seed_from_u64(3);
        let mut bins = [0; 20];
        for _ in 0..100_000 {
            bins[stream.random_range(0..20)] += 1;
        }
        assert_eq!(impact_uniform(&bins).passed, Some(true));
        bins[19] += 500;
        assert_eq!(impact_uniform(&bins).passed, Some(false));
    }
}
