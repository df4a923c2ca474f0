//! Hard cases of exact disks with numbers at the ends of the floating-point range.

use stosszahl_ed::{EventDrivenEngine, EventDrivenError};
use stosszahl_model::Vector;
use stosszahl_model::samples::EqualDisks;

use super::gas::{OVERLAP, StressGas, StressRun, disordered, few};
use crate::{Done, TrialError, TrialLog};

trials! {
    "speeds" => speeds,
        "a gas with its velocities times 2^k, k from -1023 to 1023: 1e-308 to 1e307",
        "refused with a typed error, or the bits of the gas at speed one; never NaN";
    "subnormal" => subnormal,
        "velocities and offsets of 5e-324 and 1e-310, one alone and a whole gas",
        "refused with a typed error, or: numbers stay finite, contacts at finite times or none, no overlap";
    "no-numbers" => no_numbers,
        "NaN, infinities and 1e200 among positions and velocities; times of NaN and before the present",
        "a typed error that names the disk; a time that is none ends at once";
    "lonely-mover" => lonely,
        "one moving disk that can never collide, asked for a time of 1e300",
        "an end: the time reached or a typed error", 5;
}

/// Runs a gas of exact disks, and checks that positions stay finite and disks do not overlap.
/// `None` if the engine rejects a number.
fn finite(
    log: &mut TrialLog,
    gas: &StressGas<EqualDisks>,
    until: f64,
    collisions: u64,
) -> Result<Option<StressRun<EqualDisks>>, TrialError> {
    let course = match gas.run_until(until, collisions) {
        Err(EventDrivenError::BadNumber { .. }) => return Ok(None),
        ended => ended?,
    };
    let mut bodies = course.end.state.bodies.iter();
    let finite = bodies.all(|b| b.position.square().is_finite() && !b.velocity.square().is_nan());
    must!(log, finite; "a number that is not finite");
    log.at_most("overlap", course.overlap, OVERLAP);
    Ok(Some(course))
}

fn speeds(log: &mut TrialLog) -> Done {
    const COLLISIONS: u64 = 2000;
    let gas = disordered(60, 0.4, 0.9, 5)?;
    let known = gas.run_until(f64::INFINITY, COLLISIONS)?.end.state.bodies;
    let (mut handled, mut refused) = (Vec::new(), Vec::new());
    for power in [
        -1023, -800, -600, -540, -500, -498, -100, -1, 1, 100, 498, 500, 540, 600, 1000, 1023,
    ] {
        let mut scaled = gas.clone();
        let factor = 2.0_f64.powi(power);
        for body in &mut scaled.start.bodies {
            body.velocity *= factor;
        }
        about!(log; "velocities times 2^{power}");
        log.guard(|log| {
            let Some(course) = finite(log, &scaled, f64::INFINITY, COLLISIONS)? else {
                refused.push(power);
                return Ok(());
            };
            handled.push(power);
            let mut pairs = course.end.state.bodies.iter().zip(&known);
            let same =
                pairs.all(|(a, b)| a.position == b.position && a.velocity == b.velocity * factor);
            // A power of two rounds nothing until velocities are subnormal.
            must!(log, power < -1000 || same; "other places or velocities after {}", course.ended());
            Ok(())
        });
    }
    // Speeds within what an engine must handle: 1e-150 is 2^-498, 1e150 is 2^498.
    let ordinary = handled.contains(&-100) && handled.contains(&100);
    must!(log, ordinary; "ordinary speeds were refused");
    found!(log; "handled 2^k for k = {handled:?}, refused {refused:?}");
    Ok(())
}

fn subnormal(log: &mut TrialLog) -> Done {
    let mut refused = 0;
    for tiny in [5e-324, 1e-310, 1e-300] {
        for (what, one, other) in [
            ("slow approach", [0.0; 4], [2.0, 0.0, -tiny, 0.0]),
            (
                "slow approach in contact",
                [0.0; 4],
                [1.0, 0.0, -tiny, tiny],
            ),
            ("offset", [0.0, tiny, 0.0, 0.0], [2.0, 0.0, -1.0, 0.0]),
            (
                "offset in contact",
                [tiny, tiny, 1.0, 0.0],
                [1.0, 0.0, -1.0, -tiny],
            ),
            ("slow turn", [0.0, 0.0, 1.0, tiny], [3.0, 0.0, -1.0, -tiny]),
        ] {
            about!(log; "{what} {tiny:e}");
            let gas = few(
                1.0,
                [9.0; 2],
                [one, other].map(|[x, y, u, v]| ([x, y], [u, v])),
            )?;
            let Some(course) = finite(log, &gas, 3.0, 100)? else {
                refused += 1;
                continue;
            };
            must!(log, course.reached; "{}", course.ended());
            let mut bodies = course.end.state.bodies.iter();
            let good = bodies.all(|b| b.velocity.square().is_finite());
            must!(log, good; "a velocity that is not finite");
            gas.survives_kills(log, 3, 1)?;
        }
        let mut gas = disordered(40, 0.4, 0.8, 2)?;
        for body in &mut gas.start.bodies {
            body.velocity *= tiny;
        }
        about!(log; "gas at {tiny:e}");
        log.guard(|log| {
            match finite(log, &gas, 1e300, 1000)? {
                Some(course) => log.found_in_gas(&course.ended()),
                None => refused += 1,
            }
            Ok(())
        });
    }
    found!(log; "{refused} refused");
    Ok(())
}

fn no_numbers(log: &mut TrialLog) -> Done {
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
                let made = EventDrivenEngine::<_>::new(gas.scene.clone(), gas.dissipation, start);
                let named = matches!(made, Err(EventDrivenError::BadNumber { disk: 7, .. }));
                must!(log, named; "{bad} on axis {axis}, velocity {velocity}: not refused by its disk");
            }
        }
    }
    let mut engine = gas.engine(gas.start.clone().into())?;
    engine.advance(1.0, u64::MAX, &mut ())?;
    for until in [f64::NAN, -1.0, 0.5, f64::NEG_INFINITY] {
        // End times without meaning leave the state as it is; the limit of five collisions keeps a
        // failing engine from an endless loop.
        let before = engine.state();
        let ended = engine.advance(until, 5, &mut ());
        let after = engine.state();
        let still = after.time == before.time && after.bodies == before.bodies;
        must!(log, still; "asked for {until} at time 1: {ended:?}, time {}", after.time);
    }
    log.found("20 bad numbers, 4 bad times");
    Ok(())
}

fn lonely(log: &mut TrialLog) -> Done {
    let gas = few(1.0, [5.0; 2], [([1.0, 1.0], [1.0, 0.3])])?;
    // Moderate end time, which no engine may refuse.
    let course = gas.run_until(1e5, 10)?;
    must!(log, course.reached; "until 1e5: {}", course.ended());
    let course = gas.run_until(1e300, 10)?;
    found!(log; "time {:e}, {:?}", course.end.state.time, course.stopped);
    Ok(())
}
