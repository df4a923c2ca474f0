//! Steps that are too long, majorants that are too small, and one simulator that is far too fast.

use nalgebra::vector;
use stosszahl_model::State;

use super::gas::{
    Setup, Sums, audit, audit_shared, domain, engine, random, scattered, setups, uniform, warm,
};
use super::{Case, Effort, Findings, Trouble};
use crate::bench::Disks;

pub(super) const CASES: &[Case] = &[
    Case::new(
        "violations",
        "400 disks of speed one along x, packing 0.3, some ten collisions of each in one step: the fastest pairs are made within the \
         step; every scheme",
        "violations of the majorant are counted (stochastic disks need no majorant and have none); energy and momentum",
        violations,
    ),
    Case::new(
        "long-step",
        "200 of 400 disks in a cluster at packing 0.8, steps held at 1, 10 and 100 times the engine's own; every scheme",
        "the tally tells: `busiest_cell` is more than twice that of an even gas; energy and momentum",
        long_step,
    ),
    Case::new(
        "hot-one",
        "one of 200 disks with a million times the thermal speed, until it has shared its energy; every scheme",
        "an end; energy and momentum; the energy is shared",
        hot_one,
    ),
];

fn violations(_: Effort, findings: &mut Findings) -> Result<(), Trouble> {
    let mut start = uniform(400, 0.3, 5)?;
    for (index, body) in start.bodies.iter_mut().enumerate() {
        body.velocity = vector![if index % 2 == 0 { 1.0 } else { -1.0 }, 0.0];
    }
    for setup in setups() {
        let mut engine = engine(setup, 1.0, &start)?;
        let before = Sums::of(&engine.state());
        // A mean free time is about one half.
        engine.hold_step(5.0);
        engine.advance(f64::INFINITY, 5, &mut ());
        audit(findings, setup.name, &engine, before, true);
        let violations = engine.tally().majorant_violations;
        findings.require(setup.is_stochastic_disks() == (violations == 0), || {
            format!("{}: {violations} violations", setup.name)
        });
        findings.found(format!(
            "{}: {violations} in {} trials",
            setup.name,
            engine.tally().trials
        ));
    }
    Ok(())
}

/// Busiest cell in steps of `times` the engine's own.
fn held(
    findings: &mut Findings,
    setup: Setup,
    start: &State<Disks>,
    times: f64,
) -> Result<f64, Trouble> {
    let mut own = engine(setup, 1.0, start)?;
    own.advance(f64::INFINITY, 1, &mut ());
    let step = own.time();
    let mut engine = engine(setup, 1.0, start)?;
    let before = Sums::of(&engine.state());
    engine.hold_step(times * step);
    engine.advance(f64::INFINITY, 4, &mut ());
    audit(
        findings,
        &format!("{} x {times}", setup.name),
        &engine,
        before,
        true,
    );
    Ok(engine.tally().busiest_cell)
}

fn long_step(_: Effort, findings: &mut Findings) -> Result<(), Trouble> {
    let side = 80.0;
    let mut stream = random(6);
    let mut places = scattered(200, [30.0; 2], [14.0; 2], &mut stream);
    places.extend(scattered(200, [0.0; 2], [side; 2], &mut stream));
    let start = warm(domain(side, side)?, &places, 6)?;
    for setup in setups() {
        let mut found = Vec::new();
        for times in [1.0, 10.0, 100.0] {
            found.push(held(findings, setup, &start, times)?);
        }
        let mut even = engine(setup, 1.0, &uniform(400, 0.2, 6)?)?;
        even.advance(f64::INFINITY, 20, &mut ());
        let usual = even.tally().busiest_cell;
        for busiest in &found[1..] {
            findings.require(*busiest >= 2.0 * usual, || {
                format!("{}: busiest cell {busiest}, usually {usual}", setup.name)
            });
        }
        let [own, ten, hundred] = [found[0], found[1], found[2]];
        findings.found(format!(
            "{}: {usual:.1} without a cluster, {own:.1}, {ten:.1}, {hundred:.1}",
            setup.name
        ));
    }
    Ok(())
}

fn hot_one(_: Effort, findings: &mut Findings) -> Result<(), Trouble> {
    const HOT: f64 = 1e6;
    let mut start = uniform(200, 0.2, 7)?;
    start.bodies[0].velocity = vector![0.6 * HOT, 0.8 * HOT];
    for setup in setups() {
        let mut engine = engine(setup, 1.0, &start)?;
        let before = Sums::of(&engine.state());
        // Once shared, the energy gives a speed of 7e4 and mean free times of 2e-5.
        let reached = engine.advance(1e-4, 1_000_000, &mut ());
        findings.require(reached, || {
            format!("{}: no end in {} steps", setup.name, engine.tally().steps)
        });
        // The hot one is in few pairs, but these have all the energy.
        audit_shared(findings, setup.name, &engine, before, true, 1.0);
        let fastest = engine
            .state()
            .bodies
            .iter()
            .map(|body| body.velocity.norm())
            .fold(0.0, f64::max);
        findings.at_most(&format!("{}: fastest", setup.name), fastest, 0.9 * HOT);
        findings.found(format!(
            "{}: fastest {fastest:.1e} after {} steps",
            setup.name,
            engine.tally().steps
        ));
    }
    Ok(())
}
