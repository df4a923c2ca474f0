//! Numbers at the ends of their range.

use stosszahl_ed::{Engine, EngineError};
use stosszahl_model::Vector;

use super::gas::{Gas, OVERLAP};
use super::starts::{disordered, domain, state, unit_disks};
use super::{Case, Effort, Findings, Trouble};

pub(super) const CASES: &[Case] = &[
    Case::new(
        "speeds",
        "a gas with its velocities times 2^k, k from -1023 to 1023: 1e-308 to 1e307",
        "refused with a typed error, or the bits of the gas at speed one; never NaN",
        speeds,
    ),
    Case::new(
        "subnormal",
        "velocities and offsets of 5e-324 and 1e-310, one alone and a whole gas",
        "refused with a typed error, or: numbers stay finite, contacts at finite times or none, no overlap",
        subnormal,
    ),
    Case::new(
        "no-numbers",
        "NaN, infinities and 1e200 among positions and velocities; times of NaN and before the present",
        "a typed error that names the disk; a time that is none ends at once",
        no_numbers,
    ),
    Case::new(
        "lonely-mover",
        "one moving disk that can never collide, asked for a time of 1e300",
        "an end: the time reached or a typed error",
        lonely,
    )
    .within(5),
];

fn speeds(_: Effort, findings: &mut Findings) -> Result<(), Trouble> {
    const COLLISIONS: u64 = 2000;
    let gas = disordered(60, 0.4, 0.9, 5)?;
    let known = gas.run(f64::INFINITY, COLLISIONS, COLLISIONS, |_, _| ())?;
    let (mut handled, mut refused) = (Vec::new(), Vec::new());
    for power in [
        -1023, -800, -600, -540, -500, -498, -100, -1, 1, 100, 498, 500, 540, 600, 1000, 1023,
    ] {
        let mut scaled = gas.clone();
        let factor = 2.0_f64.powi(power);
        for body in &mut scaled.start.bodies {
            body.velocity *= factor;
        }
        let what = format!("velocities times 2^{power}");
        findings.guard(&what, |findings| {
            let course = match scaled.run(f64::INFINITY, COLLISIONS, COLLISIONS, |_, _| ()) {
                Err(EngineError::BadNumber { .. }) => {
                    refused.push(power);
                    return Ok(());
                }
                ended => ended?,
            };
            handled.push(power);
            let bodies = || course.end.state.bodies.iter();
            let finite = bodies().all(|b| b.position.square().is_finite());
            findings.require(finite, || format!("{what}: a place that is no number"));
            findings.at_most(&format!("{what}: overlap"), course.overlap, OVERLAP);
            let same = bodies()
                .zip(&known.end.state.bodies)
                .all(|(a, b)| a.position == b.position && a.velocity == b.velocity * factor);
            // A power of two rounds nothing until velocities are subnormal.
            findings.require(power < -1000 || same, || {
                format!(
                    "{what}: other places or velocities after {} collisions",
                    course.ledger.collisions
                )
            });
            Ok(())
        });
    }
    // 1e-150 is 2^-498, 1e150 is 2^498: these at least are within what an engine may be asked.
    findings.require(handled.contains(&-100) && handled.contains(&100), || {
        "ordinary speeds were refused".to_owned()
    });
    findings.found(format!(
        "handled 2^k for k = {handled:?}, refused {refused:?}"
    ));
    Ok(())
}

fn subnormal(_: Effort, findings: &mut Findings) -> Result<(), Trouble> {
    let mut refused = 0;
    for tiny in [5e-324, 1e-310, 1e-300] {
        for (what, bodies) in [
            (
                "slow approach",
                [([0.0, 0.0], [0.0; 2]), ([2.0, 0.0], [-tiny, 0.0])],
            ),
            (
                "slow approach in contact",
                [([0.0, 0.0], [0.0; 2]), ([1.0, 0.0], [-tiny, tiny])],
            ),
            (
                "offset",
                [([0.0, tiny], [0.0; 2]), ([2.0, 0.0], [-1.0, 0.0])],
            ),
            (
                "offset in contact",
                [([tiny, tiny], [1.0, 0.0]), ([1.0, 0.0], [-1.0, -tiny])],
            ),
            (
                "slow turn",
                [([0.0, 0.0], [1.0, tiny]), ([3.0, 0.0], [-1.0, -tiny])],
            ),
        ] {
            let what = format!("{what} {tiny:e}");
            let gas = Gas::new(unit_disks(1.0)?, state(domain(9.0, 9.0)?, bodies));
            let course = match gas.run(3.0, 100, 100, |_, _| ()) {
                Err(EngineError::BadNumber { .. }) => {
                    refused += 1;
                    continue;
                }
                ended => ended?,
            };
            findings.require(course.reached, || {
                format!(
                    "{what}: {} collisions, {:?}",
                    course.ledger.collisions, course.stopped
                )
            });
            let end = &course.end.state;
            let finite = end
                .bodies
                .iter()
                .all(|b| b.position.square().is_finite() && b.velocity.square().is_finite());
            findings.require(finite, || format!("{what}: a number that is not finite"));
            findings.at_most(&format!("{what}: overlap"), course.overlap, OVERLAP);
            gas.survives_kills(findings, &what, 3, 1)?;
        }
        let mut gas = disordered(40, 0.4, 0.8, 2)?;
        for body in &mut gas.start.bodies {
            body.velocity *= tiny;
        }
        findings.guard(&format!("gas at {tiny:e}"), |findings| {
            let course = match gas.run(1e300, 1000, 1000, |_, _| ()) {
                Err(EngineError::BadNumber { .. }) => {
                    refused += 1;
                    return Ok(());
                }
                ended => ended?,
            };
            let finite = course
                .end
                .state
                .bodies
                .iter()
                .all(|b| b.position.square().is_finite());
            findings.require(finite, || {
                format!("gas at {tiny:e}: a number that is not finite")
            });
            findings.at_most(
                &format!("gas at {tiny:e}: overlap"),
                course.overlap,
                OVERLAP,
            );
            findings.found(format!(
                "gas at {tiny:e}: {} collisions, {:?}",
                course.ledger.collisions, course.stopped
            ));
            Ok(())
        });
    }
    findings.found(format!("{refused} refused"));
    Ok(())
}

fn no_numbers(_: Effort, findings: &mut Findings) -> Result<(), Trouble> {
    let gas = disordered(20, 0.3, 1.0, 1)?;
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e200, f64::MAX] {
        for axis in 0..2 {
            for velocity in [false, true] {
                let mut start = gas.start.clone();
                let body = &mut start.bodies[7];
                let vector = if velocity {
                    &mut body.velocity
                } else {
                    &mut body.position
                };
                vector[axis] = bad;
                let made = Engine::<_>::new(gas.scene.clone(), gas.dissipation, start);
                let named = matches!(made, Err(EngineError::BadNumber { disk: 7, .. }));
                findings.require(named, || {
                    format!("{bad} on axis {axis}, velocity {velocity}: not refused by its disk")
                });
            }
        }
    }
    let mut engine = gas.engine(gas.start.clone().into())?;
    engine.advance(1.0, u64::MAX, &mut ())?;
    for until in [f64::NAN, -1.0, 0.5, f64::NEG_INFINITY] {
        // At most a few collisions: a time that is none must not mean for ever.
        let before = engine.state();
        let ended = engine.advance(until, 5, &mut ());
        let after = engine.state();
        let still = after.time == before.time && after.bodies == before.bodies;
        findings.require(still, || {
            format!(
                "asked for {until} at time 1: {ended:?}, time {}",
                after.time
            )
        });
    }
    findings.found("20 bad numbers, 4 bad times");
    Ok(())
}

fn lonely(_: Effort, findings: &mut Findings) -> Result<(), Trouble> {
    let bodies = [([1.0, 1.0], [1.0, 0.3])];
    let gas = Gas::new(unit_disks(1.0)?, state(domain(5.0, 5.0)?, bodies));
    // First as far as ought to be no question.
    let course = gas.run(1e5, 10, 10, |_, _| ())?;
    findings.require(course.reached, || {
        format!("until 1e5: {:?}", course.stopped)
    });
    let course = gas.run(1e300, 10, 10, |_, _| ())?;
    findings.found(format!(
        "time {:e}, {:?}",
        course.end.state.time, course.stopped
    ));
    Ok(())
}
