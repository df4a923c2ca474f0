//! Hard cases of exact disks: restitution zero, contact laws at their limits, and gases mostly or
//! completely at rest.

use stosszahl_model::Viscoelastic;
use stosszahl_model::samples::{UNIT, smooth_particles, state};

use super::gas::{RunEnd, StressGas, disordered};
use crate::{Done, TrialLog};

trials! {
    "plastic" => plastic,
        "restitution exactly 0: 200 disks at packings 0.05, 0.3 and 0.6, without and with contact time",
        "the end, or the typed error of a collapse; energy balance, momentum, exclusion; with contact time no error";
    "viscoelastic" => viscoelastic,
        "400 viscoelastic disks at packing 0.5 whose restitution at thermal speeds is 0.998, 0.4 and 0.02",
        "no collapse, as slow contacts are elastic; energy balance, momentum, exclusion";
    "contact-times" => contact_times,
        "300 disks, restitution 0.5, packing 0.4, contact times of 0, 5e-324 and infinity",
        "0 gives the bits of the gas without one; infinity lets each disk lose energy in its first contact only";
    "one-moves" => one_moves,
        "100 disks of which one moves, packing 0.1 and 0.6, restitution 1, 0.5 and 0",
        "energy balance, momentum, exclusion, no error unless it is a collapse";
    "rest" => rest,
        "disks all at rest, asked for a time, for 1e300 and for ever",
        "the time is reached without an event; for ever leaves the clock where it is";
}

fn plastic(log: &mut TrialLog) -> Done {
    for packing in [0.05, 0.3, 0.6] {
        let gas = disordered(200, packing, 0.0, 3)?;
        about!(log; "packing {packing}");
        gas.check(log, 100.0, 2_000_000, RunEnd::TimeOrCollapse, 20_000)?;
        about!(log; "packing {packing} with contact time");
        let timed = gas.with_contact_time(1e-4);
        timed.check(log, 100.0, 2_000_000, RunEnd::Time, 1000)?;
    }
    Ok(())
}

fn viscoelastic(log: &mut TrialLog) -> Done {
    for strength in [0.04, 1.0, 4.0] {
        let law = Viscoelastic::new(strength)?;
        let equal = disordered(400, 0.5, 1.0, 10)?.start;
        let bodies = equal.bodies.iter().map(|b| (b.position, b.velocity));
        about!(log; "strength {strength}");
        StressGas::new(smooth_particles(law, UNIT), state(equal.domain, bodies))
            .holds(log, 200_000)?;
    }
    Ok(())
}

fn contact_times(log: &mut TrialLog) -> Done {
    const COLLISIONS: u64 = 5000;
    let gas = disordered(300, 0.4, 0.5, 11)?;
    let run = |gas: &StressGas<_>| gas.run_until(f64::INFINITY, COLLISIONS);
    let plain = run(&gas)?.end.state.bodies;
    for contact_time in [0.0, 5e-324] {
        let timed = run(&gas.clone().with_contact_time(contact_time))?;
        let same = timed.end.state.bodies == plain;
        must!(log, same; "contact time {contact_time:e}: not the gas without one");
    }
    let endless = gas.with_contact_time(f64::INFINITY);
    let course = run(&endless)?;
    log.about("for ever");
    endless.audit(log, &course);
    let inelastic = course.end.tally.collisions - course.end.tally.elastic_contacts;
    must!(log, (1..=150).contains(&inelastic); "{inelastic} inelastic contacts of 300 disks");
    endless.survives_kills(log, COLLISIONS, 1)?;
    found_in_gas!(log; "{inelastic} inelastic of {} collisions", course.collisions());
    Ok(())
}

fn one_moves(log: &mut TrialLog) -> Done {
    for packing in [0.1, 0.6] {
        for restitution in [1.0, 0.5, 0.0] {
            let mut gas = disordered(100, packing, restitution, 12)?;
            for body in &mut gas.start.bodies[1..] {
                body.velocity.fill(0.0);
            }
            about!(log; "packing {packing}, r = {restitution}");
            gas.check(log, 50.0, 2_000_000, RunEnd::TimeOrCollapse, 20_000)?;
        }
    }
    Ok(())
}

fn rest(log: &mut TrialLog) -> Done {
    for packing in [0.05, 0.6] {
        let mut gas = disordered(50, packing, 0.5, 2)?;
        for body in &mut gas.start.bodies {
            body.velocity.fill(0.0);
        }
        for until in [0.0, 1.0, 1e300, f64::INFINITY] {
            let mut engine = gas.engine(gas.start.clone().into())?;
            let reached = engine.advance(until, u64::MAX, &mut ())?;
            let expected = if until.is_finite() { until } else { 0.0 };
            let (time, same) = (engine.time(), engine.state().bodies == gas.start.bodies);
            let good = reached && time == expected && same && engine.tally().collisions == 0;
            must!(log, good; "asked for {until}: reached {reached}, time {time}, unmoved {same}");
        }
        gas.survives_kills(log, 10, 1)?;
    }
    log.found("50 disks at two packings, four times each");
    Ok(())
}
