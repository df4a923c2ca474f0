//! Inelastic collapse: infinitely many collisions in a finite time.

use stosszahl_ed::EngineError;

use super::gas::Gas;
use super::starts::{disordered, domain, state, unit_disks};
use super::{Case, Effort, Findings, Trouble};
use crate::bench::Disks;
use crate::dispatch::Planar;

pub(super) const CASES: &[Case] = &[
    Case::new(
        "line-below",
        "three disks on a line, the outer ones moving in, restitution 0.0715, 0.05 and 0 (below 7 - 4 sqrt 3 = 0.0718)",
        "a typed error that names pair, place, time and collisions; the time of the one-dimensional gas to 1e-3; the state stays; \
         a contact time lets it go on",
        below,
    ),
    Case::new(
        "line-above",
        "three disks on a line, the outer ones moving in, restitution 0.0725 to 1 (above 7 - 4 sqrt 3)",
        "as many collisions as the one-dimensional gas has, and no error",
        above,
    ),
    Case::new(
        "dense-collapse",
        "1000 disks at packing 0.5, restitution 0.1, without and with contact time",
        "a typed error that names a touching pair; the state stays; a contact time lets it go on",
        dense,
    ),
];

/// Gaps and speeds of the three: the left pair meets first.
const GAPS: [f64; 2] = [0.5, 0.6];
const SPEED: f64 = 1.0;

/// Three disks on a line along x in a box so large that images do not matter.
fn line(restitution: f64) -> Result<Gas<Disks>, Trouble> {
    let middle = 20.0;
    let bodies = [
        ([middle - 1.0 - GAPS[0], middle], [SPEED, 0.0]),
        ([middle, middle], [0.0, 0.0]),
        ([middle + 1.0 + GAPS[1], middle], [-SPEED, 0.0]),
    ];
    Ok(Gas::new(
        unit_disks(restitution)?,
        state(domain(40.0, 40.0)?, bodies),
    ))
}

/// Collisions of the three in one dimension and the time of the last: (number, time), the number `None` if there is no
/// end to them.
///
/// With the approach speeds a of the pair that collides and b of the other, a collision makes b + (1 + r) a/2 the next
/// approach speed and -r a the other: pairs take turns, and it ends when the next pair recedes. Only b/a decides, so
/// nothing underflows (McNamara & Young, Phys. Fluids A 4, 496 (1992), doi:10.1063/1.858323).
fn one_dimensional(restitution: f64) -> (Option<u64>, f64) {
    /// Every finite sequence tried here has fewer.
    const MANY: u64 = 10_000;
    let (mut gap, mut other_gap) = (GAPS[0], GAPS[1]);
    let (mut approach, mut other) = (SPEED, SPEED);
    let mut time = 0.0;
    for number in 0..MANY {
        if approach <= 0.0 {
            return (Some(number), time);
        }
        let wait = gap / approach;
        if wait.is_finite() {
            time += wait;
        }
        let left = other_gap - other * wait;
        (gap, other_gap) = (left.max(0.0), 0.0);
        (approach, other) = (
            other + 0.5 * (1.0 + restitution) * approach,
            -restitution * approach,
        );
        // Scaled, as speeds fall below the smallest number and only their ratio and that to the gap matter.
        if approach > 0.0 && approach < 1e-100 {
            return (None, time);
        }
    }
    (None, time)
}

fn below(_: Effort, findings: &mut Findings) -> Result<(), Trouble> {
    for restitution in [0.0715, 0.05, 0.0] {
        let what = format!("r = {restitution}");
        let (number, time) = one_dimensional(restitution);
        findings.require(number.is_none(), || {
            format!("{what}: theory gives {number:?} collisions")
        });
        let gas = line(restitution)?;
        let course = gas.run(5.0, 1_000_000, 100_000, |_, _| ())?;
        match &course.stopped {
            Some(error) => told(findings, &what, &gas, &course.end.state, error, Some(time)),
            None => findings.fault(format!(
                "{what}: no error; {} collisions, energy {:.1e} at time {}",
                course.ledger.collisions,
                course.end.state.kinetic_energy(&gas.scene),
                course.end.state.time
            )),
        }
        gas.audit(findings, &what, &course);
        gas.survives_kills(findings, &what, 100, 1)?;
        let regular = gas.with_contact_time(1e-6);
        let course = regular.run(5.0, 1_000_000, 100_000, |_, _| ())?;
        findings.require(course.reached, || {
            format!(
                "{what} with contact time: {:?} after {} collisions",
                course.stopped, course.ledger.collisions
            )
        });
        regular.audit(findings, &format!("{what} with contact time"), &course);
        findings.found(format!(
            "{what} with contact time: {} collisions",
            course.ledger.collisions
        ));
    }
    Ok(())
}

fn above(_: Effort, findings: &mut Findings) -> Result<(), Trouble> {
    for restitution in [0.0725, 0.075, 0.08, 0.1, 0.2, 0.5, 0.9, 1.0] {
        let what = format!("r = {restitution}");
        let (number, _) = one_dimensional(restitution);
        let gas = line(restitution)?;
        let course = gas.run(5.0, 1_000_000, 100_000, |_, _| ())?;
        let found = course.ledger.collisions;
        findings.require(course.stopped.is_none() && Some(found) == number, || {
            format!(
                "{what}: {found} collisions, theory {number:?}, {:?}",
                course.stopped
            )
        });
        findings.found(format!("{what}: {found} collisions"));
        gas.audit(findings, &what, &course);
    }
    line(0.0725)?.survives_kills(findings, "r = 0.0725", 40, 1)
}

fn dense(_: Effort, findings: &mut Findings) -> Result<(), Trouble> {
    let gas = disordered(1000, 0.5, 0.1, 4)?;
    let course = gas.run(1e6, 20_000_000, 5_000_000, |_, _| ())?;
    match &course.stopped {
        Some(error) => told(findings, "collapse", &gas, &course.end.state, error, None),
        None => findings.fault(format!(
            "no error in {} collisions",
            course.ledger.collisions
        )),
    }
    gas.audit(findings, "collapse", &course);
    gas.survives_kills(findings, "collapse", 40_000, 1)?;
    gas.with_contact_time(1e-3)
        .holds(findings, "with contact time", 300_000)?;
    Ok(())
}

/// What the error must tell: a pair that touches, where it is, and when.
fn told<P: Planar>(
    findings: &mut Findings,
    what: &str,
    gas: &Gas<P>,
    end: &stosszahl_model::State<P>,
    error: &EngineError,
    predicted: Option<f64>,
) {
    let EngineError::InelasticCollapse {
        time,
        collisions,
        pair,
        ref cluster,
        place,
    } = *error
    else {
        findings.fault(format!("{what}: another error, {error}"));
        return;
    };
    findings.found(format!(
        "{what}: disks {pair:?} after {collisions} collisions at time {time:.6}"
    ));
    findings.require(pair.iter().all(|who| cluster.contains(who)), || {
        format!("{what}: the pair {pair:?} is not of the cluster {cluster:?}")
    });
    let sane = pair[0] != pair[1] && pair.iter().all(|&who| who < end.bodies.len());
    findings.require(sane, || format!("{what}: no pair {pair:?}"));
    if !sane {
        return;
    }
    let at = pair.map(|who| end.bodies[who].position);
    // They touch, and the place is that of one of them, to the rounding of positions in a box of tens of diameters.
    let gap = end.domain.distance(at[0], at[1]) / gas.diameter() - 1.0;
    findings.at_most(&format!("{what}: gap of the pair"), gap.abs(), 1e-9);
    let off = at.map(|at| end.domain.distance(at, place.into()));
    findings.at_most(
        &format!("{what}: place off by"),
        off[0].min(off[1]),
        gas.diameter(),
    );
    findings.at_most(
        &format!("{what}: time off the state's"),
        (time - end.time).abs(),
        1e-9 * end.time,
    );
    if let Some(predicted) = predicted {
        // Gaps shrink by r a collision until they are the rounding of places, 1e-15; from there on waits are that over
        // speeds, which go on falling. An engine that tells the collapse at speeds above 1e-12 is off by less than this.
        findings.at_most(
            &format!("{what}: time off theory's {predicted}"),
            (time - predicted).abs(),
            1e-3,
        );
    }
}
