//! Tests of densities and their windows.

use super::*;
use stosszahl_model::{Plane, Volume};

/// Properties of a gas with cells of size 2 whose particles cover `unit`.
fn gas(counts: [u32; 3], unit: f64) -> DensityInput {
    DensityInput {
        limit: 10.0,
        counts,
        cell: 4.0,
        width: 2.0,
        // Three cells on a side of triangular weights.
        diameter: 5.0,
        simulators_per_particle: 64.0,
        unit,
        packing_fraction: 0.25,
        bounded: [false; 3],
        is_plain: true,
    }
}

/// Window sums computed line by line against a plain sum over all cells around.
fn check<S: Space>(counts: [u32; 3], scheme: Scheme, weighing: DensityKernel) {
    let areas: Vec<f32> = (0..counts.iter().product())
        .map(|i| (i * i % 5) as f32)
        .collect();
    let gas = gas(counts, 0.1);
    let columns = counts[0] as usize;
    for (parallel, offset) in [(false, 0), (true, 0), (true, 3)] {
        let mut density = Density::<S>::new(scheme, &gas);
        assert_eq!(density.weighing(), weighing);
        density.slide(offset);
        density.update(parallel, &|line, values| {
            values.copy_from_slice(&areas[line * columns..(line + 1) * columns]);
        });
        let [nx, ny, nz] = counts.map(|count| count as usize);
        let deep = if S::DIMENSION == 2 { 2..3 } else { 0..5 };
        let weight = |away: [usize; 3]| match weighing {
            DensityKernel::Flat => 1,
            DensityKernel::Triangle => (3 - away[0]) * (3 - away[1]),
        };
        let away = |x: usize, y: usize, z: usize| [x, y, z].map(|at| at.abs_diff(2));
        let cubes = deep
            .clone()
            .flat_map(|z| (0..25).map(move |i| [i % 5, i / 5, z]));
        let all: usize = cubes.clone().map(|[x, y, z]| weight(away(x, y, z))).sum();
        let squares: usize = cubes.map(|[x, y, z]| weight(away(x, y, z)).pow(2)).sum();
        assert!((density.mean_weight() - squares as f64 / all as f64).abs() < 1e-14);
        assert_eq!(density.cells_around(), all as f64);
        assert_eq!(density.share_of([1, 2, 0]), weight([1, 2, 0]) as f64);
        for cell in 0..areas.len() {
            let at = [cell % nx, cell / nx % ny, cell / nx / ny];
            let mut plain = 0.0;
            for z in deep.clone() {
                let row = (at[2] + z + nz - 2) % nz;
                for y in 0..5 {
                    for x in 0..5 {
                        let line = (at[1] + y + ny - 2) % ny;
                        // Rows above the box are displaced to the right, those below to the left.
                        let image = match at[1] + y {
                            above if above >= ny + 2 => nx - offset,
                            0 | 1 => offset,
                            _ => 0,
                        };
                        let column = (at[0] + x + nx - 2 + image) % nx;
                        let area = areas[column + nx * (line + ny * row)];
                        plain += weight(away(x, y, z)) as f64 * f64::from(area);
                    }
                }
            }
            let packing = plain * 0.1 / 4.0 / all as f64;
            let found = density.contact_value(at.map(|at| at as u32), 0.0);
            assert!((found.2 - packing).abs() < 1e-14);
            assert!((found.0 - S::contact_value(packing)).abs() < 1e-12);
        }
    }
}

/// Units without one simulator of the cell, and their maximum, against sums over all simulators
/// around.
#[test]
fn others_are_all_but_one() {
    let counts = [7, 6, 1];
    let mut density = Density::<Plane>::new(Scheme::CONTACT_POINT, &gas(counts, 0.1));
    let number = |x: i64, y: i64| (x.rem_euclid(7) + 7 * y.rem_euclid(6)) as usize;
    let held = |cell: usize| cell * cell % 5 + 1;
    density.update(false, &|line, values| {
        for (x, value) in values.iter_mut().enumerate() {
            *value = held(x + 7 * line) as f32;
        }
    });
    let mut expected = Vec::new();
    for (y, x) in (0..6).flat_map(|y| (0..7).map(move |x| (y, x))) {
        let cell = [x as u32, y as u32, 0];
        let mut most = 0.0;
        for (right, up) in (-2..=2).flat_map(|right| (-2..=2).map(move |up| (right, up))) {
            let mut others = 0;
            for (dx, dy) in (-2..=2_i64).flat_map(|dx| (-2..=2_i64).map(move |dy| (dx, dy))) {
                let there = number(x + right + dx, y + up + dy);
                let but_one = usize::from(there == number(x, y));
                others += (3 - dx.abs()) * (3 - dy.abs()) * (held(there) - but_one) as i64;
            }
            assert_eq!(density.others(cell, [right, up, 0]), others as f64);
            most = larger(most, others as f64);
        }
        expected.push(most);
    }
    for (y, part) in (0..6).flat_map(|y| [(y, 0..7), (y, 3..5)]) {
        let mut most = vec![f64::NAN; part.len()];
        let first = [part.start as u32, y as u32, 0];
        density.most_others(first, [2, 2, 0], &mut Vec::new(), &mut most);
        assert_eq!(most, expected[7 * y..][part]);
    }
}

#[test]
fn neighbourhood_packing_is_the_plain_sum() {
    let flat = Scheme::Enskog(Neighbourhood::Cells(2));
    check::<Plane>([7, 5, 1], flat, DensityKernel::Flat);
    check::<Volume>([5, 7, 6], flat, DensityKernel::Flat);
    check::<Plane>([7, 5, 1], Scheme::CONTACT_POINT, DensityKernel::Triangle);
}

#[test]
fn crowded_cells_are_limited_and_say_so() {
    let gas = gas([2, 1, 1], Plane::particle_volume(0.5));
    let density = Density::<Plane>::new(Scheme::FreeVolume, &gas);
    let (chi, limited, packing) = density.contact_value([0; 3], 2.0);
    let known = std::f64::consts::FRAC_PI_4 / 2.0;
    assert!(!limited && (packing - known).abs() < 1e-15);
    assert!((chi - 1.0 / (1.0 - known / 0.82)).abs() < 1e-14);
    let (chi, limited, _) = density.contact_value([1, 0, 0], 5.0);
    assert_eq!((chi, limited), (10.0, true));
}
