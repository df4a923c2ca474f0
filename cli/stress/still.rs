//! Restitution zero and laws at their limits, and gases most or all of which is at rest.

use stosszahl_model::{Scene, State, Viscoelastic};

use super::gas::Gas;
use super::starts::{disordered, unit_disks};
use super::{Case, Effort, Findings, Trouble};

pub(super) const CASES: &[Case] = &[
    Case::new(
        "plastic",
        "restitution exactly 0: 200 disks at packings 0.05, 0.3 and 0.6, without and with contact time",
        "the end, or the typed error of a collapse; energy balance, momentum, exclusion; with contact time no error",
        plastic,
    ),
    Case::new(
        "viscoelastic",
        "400 viscoelastic disks at packing 0.5 whose restitution at thermal speeds is 0.998, 0.4 and 0.02",
        "no collapse, as slow contacts are elastic; energy balance, momentum, exclusion",
        viscoelastic,
    ),
    Case::new(
        "contact-times",
        "300 disks, restitution 0.5, packing 0.4, contact times of 0, 5e-324 and infinity",
        "0 gives the bits of the gas without one; infinity lets each disk lose energy in its first contact only",
        contact_times,
    ),
    Case::new(
        "one-moves",
        "100 disks of which one moves, packing 0.1 and 0.6, restitution 1, 0.5 and 0",
        "energy balance, momentum, exclusion, no error unless it is a collapse",
        one_moves,
    ),
    Case::new(
        "rest",
        "disks all at rest, asked for a time, for 1e300 and for ever",
        "the time is reached without an event; for ever leaves the clock where it is",
        rest,
    ),
];

/// Runs until a time; a collapse is a result, too.
fn ends(
    findings: &mut Findings,
    what: &str,
    gas: &Gas<crate::bench::Disks>,
    until: f64,
) -> Result<(), Trouble> {
    let course = gas.run(until, 2_000_000, 100_000, |_, _| ())?;
    let collapsed = matches!(
        course.stopped,
        Some(stosszahl_ed::EngineError::InelasticCollapse { .. })
    );
    findings.require(course.reached || collapsed, || {
        format!(
            "{what}: {} collisions and no end, {:?}",
            course.ledger.collisions, course.stopped
        )
    });
    gas.audit(findings, what, &course);
    findings.found(format!(
        "{what}: {} collisions{}",
        course.ledger.collisions,
        if collapsed { ", then collapse" } else { "" }
    ));
    gas.survives_kills(findings, what, course.ledger.collisions.clamp(1, 20_000), 1)
}

fn plastic(_: Effort, findings: &mut Findings) -> Result<(), Trouble> {
    for packing in [0.05, 0.3, 0.6] {
        let gas = disordered(200, packing, 0.0, 3)?;
        ends(findings, &format!("packing {packing}"), &gas, 100.0)?;
        let what = format!("packing {packing} with contact time");
        let gas = gas.with_contact_time(1e-4);
        let course = gas.run(100.0, 2_000_000, 100_000, |_, _| ())?;
        findings.require(course.reached, || {
            format!(
                "{what}: {} collisions and no end, {:?}",
                course.ledger.collisions, course.stopped
            )
        });
        gas.audit(findings, &what, &course);
        findings.found(format!("{what}: {} collisions", course.ledger.collisions));
    }
    Ok(())
}

fn viscoelastic(_: Effort, findings: &mut Findings) -> Result<(), Trouble> {
    for strength in [0.04, 1.0, 4.0] {
        let unit = unit_disks(1.0)?;
        let scene = Scene {
            space: unit.space,
            surface: unit.surface,
            restitution: Viscoelastic::new(strength).ok_or(Trouble::NoStart("no strength"))?,
            sizes: unit.sizes,
            field: unit.field,
        };
        let equal = disordered(400, 0.5, 1.0, 10)?.start;
        let start = State {
            time: 0.0,
            domain: equal.domain,
            bodies: equal
                .bodies
                .iter()
                .map(|b| stosszahl_model::Body::new(b.position, b.velocity))
                .collect(),
        };
        Gas::new(scene, start).holds(findings, &format!("strength {strength}"), 200_000)?;
    }
    Ok(())
}

fn contact_times(_: Effort, findings: &mut Findings) -> Result<(), Trouble> {
    const COLLISIONS: u64 = 5000;
    let gas = disordered(300, 0.4, 0.5, 11)?;
    let plain = gas
        .run(f64::INFINITY, COLLISIONS, 1000, |_, _| ())?
        .end
        .state
        .bodies;
    for contact_time in [0.0, 5e-324] {
        let timed = gas.clone().with_contact_time(contact_time);
        let course = timed.run(f64::INFINITY, COLLISIONS, 1000, |_, _| ())?;
        let same = course.end.state.bodies == plain;
        findings.require(same, || {
            format!("contact time {contact_time:e}: not the gas without one")
        });
    }
    let endless = gas.with_contact_time(f64::INFINITY);
    let course = endless.run(f64::INFINITY, COLLISIONS, 1000, |_, _| ())?;
    endless.audit(findings, "for ever", &course);
    let inelastic = course.end.tally.collisions - course.end.tally.elastic_contacts;
    findings.require((1..=150).contains(&inelastic), || {
        format!("{inelastic} inelastic contacts of 300 disks")
    });
    endless.survives_kills(findings, "for ever", COLLISIONS, 1)?;
    findings.found(format!(
        "for ever: {inelastic} inelastic of {} collisions",
        course.ledger.collisions
    ));
    Ok(())
}

fn one_moves(_: Effort, findings: &mut Findings) -> Result<(), Trouble> {
    for packing in [0.1, 0.6] {
        for restitution in [1.0, 0.5, 0.0] {
            let mut gas = disordered(100, packing, restitution, 12)?;
            for body in &mut gas.start.bodies[1..] {
                body.velocity.fill(0.0);
            }
            ends(
                findings,
                &format!("packing {packing}, r = {restitution}"),
                &gas,
                50.0,
            )?;
        }
    }
    Ok(())
}

fn rest(_: Effort, findings: &mut Findings) -> Result<(), Trouble> {
    for packing in [0.05, 0.6] {
        let mut gas = disordered(50, packing, 0.5, 2)?;
        for body in &mut gas.start.bodies {
            body.velocity.fill(0.0);
        }
        for until in [0.0, 1.0, 1e300, f64::INFINITY] {
            let mut engine = gas.engine(gas.start.clone().into())?;
            let reached = engine.advance(until, u64::MAX, &mut ())?;
            let time = if until.is_finite() { until } else { 0.0 };
            let same = engine.state().bodies == gas.start.bodies;
            findings.require(
                reached && engine.time() == time && same && engine.tally().collisions == 0,
                || {
                    format!(
                        "asked for {until}: reached {reached}, time {}, unmoved {same}",
                        engine.time()
                    )
                },
            );
        }
        gas.survives_kills(findings, "rest", 10, 1)?;
    }
    findings.found("50 disks at two packings, four times each");
    Ok(())
}
