//! Restitution zero, and cooling through many decades.

use stosszahl_dsmc::{Displacement, Engine, EngineError};
use stosszahl_model::kinetic;
use stosszahl_model::random::Streams;
use stosszahl_model::transport::critical_length;

use super::gas::{Sums, audit, engine, setups, uniform, unit_disks};
use super::{Case, Effort, Findings, Trouble};

pub(super) const CASES: &[Case] = &[
    Case::new(
        "plastic",
        "restitution 0: 200 disks at packing 0.3, 300 steps; every scheme; 1e-300 and 5e-324 where it divides",
        "energy never grows, momentum, no endless loop; the displacement d (1 + r)/(2r) is refused with a typed error",
        plastic,
    ),
    Case::new(
        "deep-cooling",
        "100 disks, restitution 0.8, packing 0.1, in a box that shear modes cannot grow in, to 1e-24 of the temperature",
        "as many collisions for each decade in the last six as in the first, to 6 standard errors; steps follow the gas; momentum",
        deep,
    ),
];

fn plastic(_: Effort, findings: &mut Findings) -> Result<(), Trouble> {
    let start = uniform(200, 0.3, 8)?;
    let (mut refused, mut collisions) = (0, 0);
    for restitution in [0.0, 1e-300, 5e-324] {
        for setup in setups() {
            let what = format!("{}, r = {restitution:e}", setup.name);
            let inelastic = setup.parameters.displacement == Displacement::Inelastic;
            // What is next to zero differs from it only where it divides.
            if restitution > 0.0 && !inelastic {
                continue;
            }
            if inelastic {
                let scene = unit_disks(restitution)?;
                let streams = Streams::new(1, 0);
                let error = Engine::new(&scene, setup.parameters, &start, streams).err();
                let typed = match error {
                    Some(EngineError::NoDisplacement) => restitution == 0.0,
                    Some(EngineError::FarDisplacement { .. }) => restitution > 0.0,
                    _ => false,
                };
                findings.require(typed, || format!("{what}: {error:?}"));
                refused += 1;
                continue;
            }
            findings.guard(&what.clone(), |findings| {
                let mut engine = engine(setup, restitution, &start)?;
                let before = Sums::of(&engine.state());
                let mut last = before.energy;
                for _ in 0..10 {
                    engine.advance(f64::INFINITY, 30, &mut ());
                    let now = Sums::of(&engine.state()).energy;
                    // Sums of as many numbers in another order.
                    findings.at_most(&format!("{what}: energy grown"), now / last - 1.0, 3e-14);
                    last = now;
                }
                audit(findings, &what, &engine, before, false);
                collisions += engine.tally().collisions;
                Ok(())
            });
        }
    }
    findings.found(format!("{collisions} collisions, refused {refused} times"));
    Ok(())
}

fn deep(_: Effort, findings: &mut Findings) -> Result<(), Trouble> {
    const RESTITUTION: f64 = 0.8;
    const PACKING: f64 = 0.1;
    let start = uniform(100, PACKING, 9)?;
    let side = start.domain.lengths()[0];
    let critical = critical_length(PACKING, kinetic::contact_value(PACKING), RESTITUTION);
    findings.require(side < critical, || {
        format!("a box of {side:.1} d, in which shear modes from {critical:.1} d grow")
    });
    for setup in setups() {
        let mut engine = engine(setup, RESTITUTION, &start)?;
        let before = Sums::of(&engine.state());
        let count = engine.simulators() as f64;
        // Collisions of a simulator until each decade.
        let mut passed = Vec::new();
        let mut energy = before.energy;
        while passed.len() < 24 && engine.tally().steps < 200_000 {
            engine.advance(f64::INFINITY, 1, &mut ());
            energy = Sums::of(&engine.state()).energy;
            while energy < before.energy * 0.1_f64.powi(passed.len() as i32 + 1) {
                passed.push(2.0 * engine.tally().collisions as f64 / count);
            }
        }
        audit(findings, setup.name, &engine, before, false);
        if passed.len() < 24 {
            findings.fault(format!(
                "{}: T/T(0) = {:.1e} after {} steps",
                setup.name,
                energy / before.energy,
                engine.tally().steps
            ));
            continue;
        }
        let [early, late] = [1, 17].map(|first| decades(&passed[first..first + 7]));
        let error = early.1.hypot(late.1);
        // Of twelve decades the scatter has ten degrees of freedom: Student's t exceeds 6 once in 1e4.
        findings.at_most(
            &format!(
                "{}: early and late decades differ, in standard errors",
                setup.name
            ),
            (early.0 - late.0).abs() / error,
            6.0,
        );
        findings.found(format!(
            "{}: {:.1} and {:.1} (error {error:.1}) collisions a decade, {} steps, time {:.1e}",
            setup.name,
            early.0,
            late.0,
            engine.tally().steps,
            engine.time()
        ));
    }
    Ok(())
}

/// Mean and standard error of the differences of successive numbers.
fn decades(passed: &[f64]) -> (f64, f64) {
    let count = (passed.len() - 1) as f64;
    let mean = (passed[passed.len() - 1] - passed[0]) / count;
    let squares = passed
        .windows(2)
        .map(|pair| (pair[1] - pair[0] - mean).powi(2));
    let variance = squares.sum::<f64>() / (count - 1.0);
    (mean, (variance / count).sqrt())
}
