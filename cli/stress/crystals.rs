//! Near close packing.

use nalgebra::vector;
use stosszahl_model::State;
use stosszahl_model::kinetic::CLOSE_PACKING;

use super::gas::{ENERGY, Gas, OVERLAP};
use super::starts::{at_rest, domain, unit_disks, warm};
use super::{Case, Effort, Findings, Trouble};
use crate::bench::Disks;

pub(super) const CASES: &[Case] = &[
    Case::new(
        "crystal-0.90",
        "hexagonal crystal of 400 disks at packing 0.90; 2e5 collisions, 1e7 long",
        "no overlap beyond 1e-11 d, energy to 1e-11, Z = 2/(0.9069/phi - 1) + 1.90 within 1 % (and 4 standard errors)",
        |effort, findings| crystal(effort, findings, 0.90),
    ),
    Case::new(
        "crystal-0.9068",
        "hexagonal crystal of 400 disks at packing 0.9068, gaps of 5e-5 d; 2e5 collisions, 1e7 long",
        "no overlap beyond 1e-11 d, energy to 1e-11, Z = 2/(0.9069/phi - 1) + 1.90 within 1 % (and 4 standard errors)",
        |effort, findings| crystal(effort, findings, 0.9068),
    ),
];

/// Disks along either side.
const SIDE: usize = 20;

/// A Maxwellian crystal whose rows and columns fit the box exactly.
pub(super) fn hexagonal(packing_fraction: f64, restitution: f64) -> Result<Gas<Disks>, Trouble> {
    let spacing = (CLOSE_PACKING / packing_fraction).sqrt();
    let height = 0.75_f64.sqrt() * spacing;
    let positions: Vec<_> = (0..SIDE * SIDE)
        .map(|index| {
            let (row, column) = (index / SIDE, index % SIDE);
            let offset = if row % 2 == 0 { 0.25 } else { 0.75 };
            vector![
                (column as f64 + offset) * spacing,
                (row as f64 + 0.5) * height
            ]
        })
        .collect();
    let scene = unit_disks(restitution)?;
    let mut start: State<Disks> = at_rest(
        domain(SIDE as f64 * spacing, SIDE as f64 * height)?,
        &positions,
    );
    warm(&scene, &mut start, 1);
    Ok(Gas::new(scene, start))
}

fn crystal(effort: Effort, findings: &mut Findings, packing: f64) -> Result<(), Trouble> {
    const BLOCKS: usize = 10;
    let collisions = effort
        .collisions
        .unwrap_or(if effort.long { 10_000_000 } else { 200_000 });
    let gas = hexagonal(packing, 1.0)?;
    // The lattice is forgotten in the first fifth: 200 collisions of each disk.
    let begin = gas.run(f64::INFINITY, collisions / 5, collisions, |_, _| ())?;
    gas.audit(findings, "melting", &begin);
    let settled = Gas::new(gas.scene, begin.end.state);
    let (mut seen, mut values) = ((settled.start.time, 0.0), Vec::new());
    let count = settled.start.bodies.len() as f64;
    let temperature = settled.start.temperature(&settled.scene);
    let rest = collisions - collisions / 5;
    let block = (rest / BLOCKS as u64).max(1);
    let course = settled.run(f64::INFINITY, rest, block, |end, ledger| {
        let (time, virial) = (end.state.time, ledger.virial);
        // Z = 1 + sum(|impulse| d)/(2 N T t)
        values.push(1.0 + (virial - seen.1) / (2.0 * count * temperature * (time - seen.0)));
        seen = (time, virial);
        findings.progress(ledger.collisions as f64 / rest as f64, "");
    })?;
    settled.audit(findings, "crystal", &course);
    let blocks = values.len() as f64;
    let mean = values.iter().sum::<f64>() / blocks;
    let variance = values.iter().map(|z| (z - mean).powi(2)).sum::<f64>() / (blocks - 1.0);
    let error = (variance / blocks).sqrt();
    // Alder, Hoover & Young, J. Chem. Phys. 49, 3688 (1968), doi:10.1063/1.1670653; the next term is 0.67 times
    // (0.9069/phi - 1), below 1e-4 of Z here.
    let theory = 2.0 / (CLOSE_PACKING / packing - 1.0) + 1.90;
    findings.found(format!(
        "{} collisions, Z = {mean:.2} +- {error:.2}, theory {theory:.2}, energy {:.1e} (allowed {ENERGY:.0e}), overlap {:.1e} d \
         (allowed {OVERLAP:.0e})",
        course.ledger.collisions,
        settled.energy_error(&course),
        course.overlap
    ));
    // 1 % for the 400 disks and the terms left out; 4 standard errors are a false alarm in 500 with ten blocks
    // (Student, 9 degrees of freedom: 0.3 %), and the start is fixed. An error bar as wide as the effect would say nothing.
    findings.at_most(
        "Z off theory",
        (mean / theory - 1.0).abs(),
        0.01 + 4.0 * error / mean,
    );
    findings.at_most("standard error of Z over Z", error / mean, 0.01);
    settled.survives_kills(findings, "crystal", 20_000, 1)
}
