//! Contacts that rounding decides: grazing, touching at the start, resting on each other.

use nalgebra::{Vector2, vector};
use rand::RngExt;

use super::gas::{Gas, OVERLAP, random};
use super::starts::{domain, mixture, state, unit_disks};
use super::{Case, Effort, Findings, Trouble};
use crate::bench::Disks;
use crate::dispatch::Planar;

pub(super) const CASES: &[Case] = &[
    Case::new(
        "grazing",
        "impact parameters d (1 +- e), e from 1e-15 to 1e-6, in 40 directions each",
        "contact if b < d and none if b > d beyond rounding; no overlap; energy exact",
        grazing,
    ),
    Case::new(
        "touching",
        "pairs at a distance of d and its two neighbours among the numbers, at rest, approaching, receding, sliding",
        "at once one contact of those that approach, none of the others; no overlap; energy exact",
        touching,
    ),
    Case::new(
        "overlapping",
        "starts that overlap: within what rounding may do, and beyond",
        "overlaps beyond rounding are found with their pair; those within it do no harm and do not deepen",
        overlapping,
    ),
    Case::new(
        "resting",
        "pairs that meet with restitution 0 and then fly on together for 1e6 diameters",
        "no error, and no overlap beyond 1e-10 d however long they fly",
        resting,
    ),
    Case::new(
        "drifting",
        "a gas with restitution 0.5 and 1 at a speed of 1e3 and 1e5 past the box",
        "the collisions of the gas at rest, as far as rounding at that speed lets them be the same; no overlap",
        drifting,
    ),
];

fn grazing(_: Effort, findings: &mut Findings) -> Result<(), Trouble> {
    const SIDE: f64 = 9.0;
    const AHEAD: f64 = 3.0;
    let mut stream = random(1);
    // The contact is decided by the sign of b^2 - g^2 c = g^2 (d^2 - beta^2), a difference of terms of size g^2 s^2 at the
    // distance s, each rounded by a few parts in 2^53; positions are rounded to 2^-53 of the box.
    let distance = 1.0 + AHEAD * AHEAD;
    let band = 8.0 * f64::EPSILON * (distance + SIDE);
    let (mut hits, mut misses, mut open) = (0, 0, 0);
    for power in -30..=-12 {
        let off = 10.0_f64.powf(0.5 * f64::from(power));
        for side in [-1.0, 1.0] {
            for trial in 0..40 {
                let angle: f64 = if trial < 4 {
                    f64::from(trial) * std::f64::consts::FRAC_PI_2
                } else {
                    stream.random_range(0.0..std::f64::consts::TAU)
                };
                let along = if trial < 4 {
                    [
                        vector![1.0, 0.0],
                        vector![0.0, 1.0],
                        vector![-1.0, 0.0],
                        vector![0.0, -1.0],
                    ][trial as usize]
                } else {
                    vector![angle.cos(), angle.sin()]
                };
                let across = vector![-along[1], along[0]];
                let target = vector![4.2, 4.7];
                let from = target - along * AHEAD + across * (1.0 + side * off);
                let bodies = [(target.into(), [0.0; 2]), (from.into(), along.into())];
                let gas = Gas::new(unit_disks(1.0)?, state(domain(SIDE, SIDE)?, bodies));
                let what = format!(
                    "b = d (1 {} {off:.1e}), angle {angle:.2}",
                    if side > 0.0 { "+" } else { "-" }
                );
                // Up to closest approach, where a contact that was missed is deepest, and beyond.
                let middle = gas.run(AHEAD, 10, 10, |_, _| ())?;
                findings.at_most(
                    &format!("{what}: overlap at closest approach"),
                    middle.overlap,
                    band,
                );
                let course = gas.run(AHEAD + 1.5, 10, 10, |_, _| ())?;
                gas.audit(findings, &what, &course);
                let hit = course.ledger.collisions;
                if off <= band {
                    open += 1;
                    findings.require(hit <= 1, || format!("{what}: {hit} contacts"));
                } else if side < 0.0 {
                    hits += hit;
                    findings.require(hit == 1, || format!("{what}: {hit} contacts"));
                    // Contact is sqrt(2 e) d before the closest approach; its error is that of e over sqrt(2 e).
                    let expected = AHEAD - (2.0 * off - off * off).sqrt();
                    let error = (course.ledger.first.unwrap_or(f64::NAN) - expected).abs();
                    findings.at_most(
                        &format!("{what}: time of contact off"),
                        error,
                        band / (2.0 * off).sqrt() + band,
                    );
                } else {
                    misses += 1;
                    findings.require(hit == 0, || format!("{what}: {hit} contacts"));
                }
            }
        }
    }
    findings.found(format!(
        "{hits} contacts, {misses} misses, {open} within rounding (e <= {band:.1e})"
    ));
    let bodies = [([4.2, 4.7], [0.0; 2]), ([1.2, 5.7 - 1e-13], [1.0, 0.0])];
    Gas::new(unit_disks(1.0)?, state(domain(SIDE, SIDE)?, bodies))
        .survives_kills(findings, "grazing", 2, 1)
}

fn touching(_: Effort, findings: &mut Findings) -> Result<(), Trouble> {
    let mut tried = 0;
    for distance in [1.0 - f64::EPSILON / 2.0, 1.0, 1.0 + f64::EPSILON] {
        // Along the axes from the origin, where the distance is exact, and elsewhere.
        for direction in [[1.0, 0.0], [0.0, 1.0], [0.6, 0.8], [-0.8, 0.6]] {
            for origin in [[0.0, 0.0], [3.3, 4.4]] {
                for (name, normal, sliding, contacts) in [
                    ("at rest", 0.0, 0.0, 0),
                    ("approaching", 1.0, 0.0, 1),
                    ("approaching askew", 0.3, 1.0, 1),
                    ("approaching slowly", 1e-9, 0.0, 1),
                    ("receding", -1.0, 0.0, 0),
                    ("receding askew", -0.3, 1.0, 0),
                ] {
                    tried += 1;
                    let velocity = [
                        -normal * direction[0] - sliding * direction[1],
                        -normal * direction[1] + sliding * direction[0],
                    ];
                    let other = [
                        origin[0] + distance * direction[0],
                        origin[1] + distance * direction[1],
                    ];
                    let bodies = [(origin, [0.0; 2]), (other, velocity)];
                    let gas = Gas::new(unit_disks(1.0)?, state(domain(12.0, 12.0)?, bodies));
                    let what = format!(
                        "{name}, distance 1 {:+.0e}, from {origin:?} along {direction:?}",
                        distance - 1.0
                    );
                    let course = gas.run(1.0, 10, 10, |_, _| ())?;
                    gas.audit(findings, &what, &course);
                    findings.require(
                        course.stopped.is_none() && course.ledger.collisions == contacts,
                        || {
                            format!(
                                "{what}: {} contacts, {:?}",
                                course.ledger.collisions, course.stopped
                            )
                        },
                    );
                    // A gap of the rounding of positions, 1e-15, at the normal speed.
                    if let Some(time) = course.ledger.first {
                        findings.at_most(&format!("{what}: time of contact"), time, 4e-15 / normal);
                    }
                    gas.survives_kills(findings, &what, 2, 1)?;
                }
            }
        }
    }
    findings.found(format!("{tried} pairs"));
    Ok(())
}

fn overlapping(_: Effort, findings: &mut Findings) -> Result<(), Trouble> {
    // Disks 0 and 3 of four.
    let four = |depth: f64| -> Result<Gas<Disks>, Trouble> {
        let bodies = [
            ([0.3, 5.0], [0.0, 0.0]),
            ([4.0, 2.0], [0.0, 0.1]),
            ([4.0, 4.0], [0.0, 0.0]),
            ([9.3 + depth, 5.0], [1.0, 0.0]),
        ];
        Ok(Gas::new(
            unit_disks(1.0)?,
            state(domain(10.0, 10.0)?, bodies),
        ))
    };
    // What the runner of cases refuses: deeper than 1e-9.
    for depth in [2e-9, 1e-6, 1e-3, 0.5, 0.999] {
        let gas = four(depth)?;
        match gas.overlap(&gas.start, 1e-9) {
            Some(overlap) => {
                findings.require(overlap.pair == [0, 3], || {
                    format!("depth {depth}: pair {:?}", overlap.pair)
                });
                // Positions up to 10 are rounded to 2e-15.
                findings.at_most(
                    &format!("depth {depth}: depth off"),
                    (overlap.depth - depth).abs(),
                    1e-14,
                );
            }
            None => findings.fault(format!("depth {depth}: not found")),
        }
    }
    // What it takes must run: between unit disks, and between disks of a hundredth.
    for depth in [1e-16, 1e-15, 1e-13, 1e-11, 0.9e-9] {
        let gas = four(depth)?;
        findings.require(gas.overlap(&gas.start, 1e-9).is_none(), || {
            format!("depth {depth}: refused")
        });
        heals(findings, &format!("depth {depth}"), &gas, depth);
        let small = mixture(vec![(0.005, 1e-4), (0.005, 1e-4), (0.5, 1.0)], 1.0)?;
        let bodies = [
            ([1.0, 1.0], [0.0; 2]),
            ([1.01 - depth, 1.0], [-1.0, 0.0]),
            ([5.0, 5.0], [0.0; 2]),
        ];
        let gas = Gas::new(small, state(domain(8.0, 8.0)?, bodies));
        heals(
            findings,
            &format!("small disks, depth {depth}"),
            &gas,
            depth,
        );
    }
    findings.found("five depths found with their pair, five within tolerance run");
    Ok(())
}

/// Runs without an error, and never overlaps deeper than at the start.
fn heals<P: Planar>(findings: &mut Findings, what: &str, gas: &Gas<P>, depth: f64) {
    findings.guard(what, |findings| {
        let course = gas.run(20.0, 1000, 1000, |_, _| ())?;
        findings.require(course.reached, || format!("{what}: {:?}", course.stopped));
        findings.at_most(
            &format!("{what}: overlap later"),
            course.overlap,
            depth + OVERLAP,
        );
        Ok(())
    });
}

fn resting(_: Effort, findings: &mut Findings) -> Result<(), Trouble> {
    /// As in long runs.
    const LONG_OVERLAP: f64 = 1e-10;
    let mut stream = random(3);
    let (mut worst, mut more) = (0.0_f64, 0);
    for _ in 0..24 {
        let angle: f64 = stream.random_range(0.0..std::f64::consts::TAU);
        let along = vector![angle.cos(), angle.sin()];
        // The middle of the pair flies on at a speed of one half.
        let offset = vector![-along[1], along[0]] * stream.random_range(-0.9..0.9);
        let at = vector![20.0, 20.0] - along * 3.0 + offset;
        let bodies = [([20.0, 20.0], [0.0; 2]), (at.into(), along.into())];
        let gas = Gas::new(unit_disks(0.0)?, state(domain(40.0, 40.0)?, bodies));
        let contact = gas.run(f64::INFINITY, 1, 1, |_, _| ())?;
        findings.require(contact.ledger.collisions == 1, || "no contact".to_owned());
        let mut together = gas.clone();
        together.start = contact.end.state;
        let [one, other] = [0, 1].map(|who: usize| together.start.bodies[who]);
        let common: Vector2<f64> = 0.5 * (one.velocity + other.velocity);
        let line = together
            .start
            .domain
            .displacement(one.position, other.position)
            .normalize();
        // What slides would part them; what rounding left along the line stays.
        for body in &mut together.start.bodies {
            body.velocity = common + line * (body.velocity - common).dot(&line);
        }
        let course = together.run(together.start.time + 2e6, 10_000, 10_000, |_, _| ())?;
        findings.require(course.reached, || {
            format!(
                "{} more contacts, {:?}",
                course.ledger.collisions, course.stopped
            )
        });
        more += course.ledger.collisions;
        worst = worst.max(course.overlap);
    }
    findings.at_most("overlap after 1e6 diameters", worst, LONG_OVERLAP);
    findings.found(format!(
        "24 pairs, {more} more contacts, deepest overlap {worst:.1e} d"
    ));
    Ok(())
}

fn drifting(_: Effort, findings: &mut Findings) -> Result<(), Trouble> {
    for restitution in [1.0, 0.5] {
        let gas = super::starts::disordered(40, 0.3, restitution, 8)?;
        let rest = gas.pairs(40)?;
        for speed in [1e3, 1e5] {
            let mut boosted = gas.clone();
            for body in &mut boosted.start.bodies {
                body.velocity += vector![speed, -0.7 * speed];
            }
            let what = format!("r = {restitution}, speed {speed:.0e}");
            let most = if speed > 1e4 { 10 } else { 40 };
            let found = boosted.pairs(most)?;
            // Velocities are rounded to 1e-16 of the speed; two collisions of each disk multiply it by about e^2 each,
            // the longest flight adds its time.
            let tolerance = 1e-16 * speed * 1e4;
            let differ = rest
                .iter()
                .zip(&found)
                .position(|(a, b)| a.1 != b.1 || (a.0 - b.0).abs() > tolerance);
            findings.require(differ.is_none() && found.len() == most, || {
                format!("{what}: collision {differ:?} differs")
            });
            let course = boosted.run(3e4 / speed, 100_000, 10_000, |_, _| ())?;
            findings.require(course.stopped.is_none(), || {
                format!("{what}: {:?}", course.stopped)
            });
            // Positions move by the speed in a unit of time and are as exact as the clock.
            findings.at_most(
                &format!("{what}: overlap"),
                course.overlap,
                OVERLAP + 1e-15 * speed,
            );
            findings.found(format!(
                "{what}: {} collisions, overlap {:.1e}",
                course.ledger.collisions, course.overlap
            ));
            boosted.survives_kills(findings, &what, most as u64, 1)?;
        }
    }
    Ok(())
}
