//! Unlike sizes and masses.

use nalgebra::{Vector2, vector};
use stosszahl_model::State;

use super::gas::{Gas, random};
use super::starts::{Mixture, at_rest, domain, mixture, place_by_trial, warm};
use super::{Case, Effort, Findings, Trouble};

pub(super) const CASES: &[Case] = &[
    Case::new(
        "ratios",
        "size ratio 100 : 1 together with mass ratios 1e6 : 1 and 1 : 1e6, 3 large among 300 small",
        "the collisions of all pairs; energy to 1e-11, momentum, exclusion",
        ratios,
    ),
    Case::new(
        "one-huge",
        "one disk of 100 d among small ones: 20 000 with 1e5 collisions, 1e5 with 1e6 long",
        "energy to 1e-11, momentum, exclusion",
        one_huge,
    ),
];

/// Small disks beside the huge one.
const FEW: usize = 20_000;
const MANY: usize = 100_000;

fn ratios(_: Effort, findings: &mut Findings) -> Result<(), Trouble> {
    for mass in [1e6, 1e-6] {
        // All pairs first, with few enough of them.
        for (large, small, side) in [(1, 12, 130.0), (3, 300, 280.0)] {
            let mut sizes = vec![(50.0, mass); large];
            sizes.extend(vec![(0.5, 1.0); small]);
            let scene = mixture(sizes, 1.0)?;
            let domain = domain(side, 0.9 * side)?;
            let mut stream = random(8);
            let positions =
                place_by_trial(&scene.sizes, large + small, &domain, 100_000, &mut stream)
                    .ok_or(Trouble::NoStart("disks do not fit"))?;
            let mut start: State<Mixture> = at_rest(domain, &positions);
            warm(&scene, &mut start, 8);
            let gas = Gas::new(scene, start);
            let what = format!("{large} large and {small} small, mass ratio {mass:.0e}");
            if large == 1 {
                // A small disk between large ones is like a mirror between mirrors: differences grow by the flight
                // over its own diameter, up to a hundred; one collision of each.
                gas.follows_all_pairs(findings, &what, 6, 1e-8)?;
            }
            gas.holds(findings, &what, 20_000)?;
        }
    }
    Ok(())
}

fn one_huge(effort: Effort, findings: &mut Findings) -> Result<(), Trouble> {
    let (small, collisions) = if effort.long {
        (MANY, 1_000_000)
    } else {
        (FEW, 100_000)
    };
    let collisions = effort.collisions.unwrap_or(collisions);
    let huge = 50.0;
    // Small ones at packing 0.2 beside the huge one, on a square lattice that dynamics forgets.
    let spacing = (std::f64::consts::FRAC_PI_4 / 0.2_f64).sqrt();
    let covered = std::f64::consts::PI * (huge + 1.0) * (huge + 1.0);
    let columns =
        ((small as f64 * spacing * spacing + 1.1 * covered).sqrt() / spacing).ceil() as usize;
    let side = columns as f64 * spacing;
    let domain = domain(side, side)?;
    let middle = vector![0.5 * side, 0.5 * side];
    let mut positions: Vec<Vector2<f64>> = vec![middle];
    positions.extend(
        (0..columns * columns)
            .map(|index| {
                vector![
                    (index % columns) as f64 * spacing,
                    (index / columns) as f64 * spacing
                ]
            })
            .filter(|&at| domain.distance(at, middle) > huge + 0.6)
            .take(small),
    );
    if positions.len() != small + 1 {
        return Err(Trouble::NoStart("small disks do not fit"));
    }
    let mut sizes = vec![(0.5, 1.0); small + 1];
    sizes[0] = (huge, 1e4);
    let scene = mixture(sizes, 1.0)?;
    let mut start: State<Mixture> = at_rest(domain, &positions);
    warm(&scene, &mut start, 9);
    findings.progress(0.0, &format!("{small} small disks"));
    Gas::new(scene, start).holds(findings, &format!("{small} small disks"), collisions)?;
    Ok(())
}
