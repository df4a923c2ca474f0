use super::*;
use crate::statistics::RunningMoments;
use crate::structure_factor::direct_sum;
use rand::{RngExt, SeedableRng};
use rand_distr::{Distribution, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;

const LENGTHS: [f64; 2] = [20.0, 13.0];

fn gas(points: usize, seed: u64) -> (Vec<Vector2<f64>>, Vec<Vector2<f64>>) {
    let mut stream = Xoshiro256PlusPlus::seed_from_u64(seed);
    let places = (0..points)
        .map(|_| {
            vector![
                LENGTHS[0] * stream.random::<f64>(),
                LENGTHS[1] * stream.random::<f64>()
            ]
        })
        .collect();
    let velocities = (0..points)
        .map(|_| {
            let [x, y]: [f64; 2] = [0, 1].map(|_| StandardNormal.sample(&mut stream));
            vector![x, y]
        })
        .collect();
    (places, velocities)
}

/// Modes are the sums of sines of the whole phase. Powers of rounded phases: index times 2e-16 for
/// each of 150 points.
#[test]
fn powers_of_phases_are_the_plain_sums() {
    let (places, velocities) = gas(150, 1);
    let indices = vec![[1, 0], [0, 2], [-3, 4], [7, -5], [12, 1]];
    let modes = Modes::new(LENGTHS, indices.clone()).unwrap();
    let found = modes.measure(&places, &velocities).unwrap();
    for (index, amplitude) in indices.into_iter().zip(found) {
        let k = wave_vector(LENGTHS, index);
        let [mut along, mut across] = [[0.0; 2]; 2];
        for (place, velocity) in places.iter().zip(&velocities) {
            let (sine, cosine) = k.dot(place).sin_cos();
            let parts = [velocity.dot(&k), k[0] * velocity[1] - k[1] * velocity[0]];
            for (sum, part) in [&mut along, &mut across].into_iter().zip(parts) {
                sum[0] += part * cosine / k.norm();
                sum[1] -= part * sine / k.norm();
            }
        }
        for axis in [0, 1] {
            assert!((amplitude.longitudinal[axis] - along[axis]).abs() < 1e-11);
            assert!((amplitude.transverse[axis] - across[axis]).abs() < 1e-11);
        }
        let density = direct_sum(&places, LENGTHS, index[0], index[1]);
        assert!((amplitude.power(150).density - density).abs() < 1e-11);
    }
}

/// Independent positions and velocities have energies of one at every k, within z = 4.4 standard
/// errors (false alarm 1e-5 each), which are small enough to see 3 %. Fixing the momentum at zero
/// takes 1/N of them back where S = 1.
#[test]
fn thermal_modes_have_unit_energy() {
    let modes = Modes::band(LENGTHS, [0.3, 4.0], 40).unwrap();
    assert!((20..=40).contains(&modes.indices().len()));
    let [mut along, mut across] = [RunningMoments::default(); 2];
    for seed in 0..1000 {
        let (places, velocities) = gas(100, seed);
        for amplitude in modes.measure(&places, &velocities).unwrap() {
            along.add(amplitude.power(100).longitudinal);
            across.add(amplitude.power(100).transverse);
        }
    }
    for moments in [along, across] {
        let [mean, error] = [moments.mean().unwrap(), moments.standard_error().unwrap()];
        assert!(
            error < 0.03 / 4.4 && (mean - 1.0).abs() < 4.4 * error,
            "{mean} {error}"
        );
    }
    // Four points: <Σ_ij v_i v_j phases> with covariances 1 - 1/N and -1/N, over T = 1 - 1/N.
    let expected = equilibrium_energy(4, 0.25);
    let pairs = 4.0 * 0.25 - 4.0;
    assert!((expected - (4.0 * 0.75 - 0.25 * pairs) / (4.0 * 0.75)).abs() < 1e-15);
}

/// A shear wave is found in its own mode alone: on a lattice there are no correlations to disturb
/// it.
#[test]
fn a_wave_is_found_where_it_was_put() {
    let places: Vec<_> = (0..800)
        .map(|i| vector![f64::from(i % 40) * 0.5, f64::from(i / 40) * 0.65])
        .collect();
    let modes = Modes::new(LENGTHS, vec![[2, 0], [1, -1], [0, 3]]).unwrap();
    let changes = shear_waves(&modes, &places, 0.3).unwrap();
    for amplitude in modes.measure(&places, &changes).unwrap() {
        assert!((amplitude.transverse[0] / 400.0 - 0.3).abs() < 1e-13);
        assert!(amplitude.transverse[1].abs() < 1e-11);
        assert!(amplitude.longitudinal[0].abs() < 1e-11);
    }
}

#[test]
fn meaningless_modes_are_refused() {
    for index in [[0, 0], [10_001, 3]] {
        let error = Modes::new(LENGTHS, vec![index]).unwrap_err();
        assert!(matches!(error, Error::ModeInvalid { .. }), "{error}");
    }
    assert!(
        Modes::band(LENGTHS, [0.5, 0.1], 9)
            .unwrap()
            .indices()
            .is_empty()
    );
    let modes = Modes::new(LENGTHS, vec![[1, 0]]).unwrap();
    assert!(modes.measure(&[], &[]).is_err());
    assert!(shear_waves(&modes, &[vector![f64::NAN, 0.0]], 1.0).is_err());
}
