//! Hard cases of contacts between exact disks that rounding decides: grazing, touching at the
//! start, resting on each other.

use std::f64::consts::{FRAC_PI_2, TAU};

use nalgebra::{Vector2, vector};
use rand::RngExt;
use stosszahl_model::samples::state;

use super::gas::{OVERLAP, Planar, StressGas, disordered, few};
use crate::gas::{domain, mixture, random};
use crate::{Done, TrialLog};

trials! {
    "grazing" => grazing,
        "impact parameters d (1 +- e), e from 1e-15 to 1e-6, in 40 directions each",
        "contact if b < d and none if b > d beyond rounding; no overlap; energy exact";
    "touching" => touching,
        "pairs at a distance of d and its two neighbours among the numbers, at rest, approaching, receding, sliding",
        "at once one contact of those that approach, none of the others; no overlap; energy exact";
    "overlapping" => overlapping,
        "starts that overlap: within what rounding may do, and beyond",
        "overlaps beyond rounding are found with their pair; those within it do no harm and do not deepen";
    "resting" => resting,
        "pairs that meet with restitution 0 and then fly on together for 1e6 diameters",
        "no error, and no overlap beyond 1e-10 d however long they fly";
    "drifting" => drifting,
        "a gas with restitution 0.5 and 1 at a speed of 1e3 and 1e5 past the box",
        "the collisions of the gas at rest, as far as rounding at that speed lets them be the same; no overlap";
}

fn grazing(log: &mut TrialLog) -> Done {
    const SIDE: f64 = 9.0;
    const AHEAD: f64 = 3.0;
    let mut stream = random(1);
    // The contact is decided by the sign of b^2 - g^2 c = g^2 (d^2 - beta^2), a difference of terms
    // of size g^2 s^2 at the distance s, each rounded by a few parts in 2^53; positions are rounded
    // to 2^-53 of the box.
    let distance = 1.0 + AHEAD * AHEAD;
    let band = 8.0 * f64::EPSILON * (distance + SIDE);
    let (mut hits, mut misses, mut open) = (0, 0, 0);
    let axes = [[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]];
    for power in -30..=-12 {
        let off = 10.0_f64.powf(0.5 * f64::from(power));
        for (side, sign) in [(-1.0, '-'), (1.0, '+')] {
            for trial in 0..40 {
                let (angle, along) = if let Some(&axis) = axes.get(trial) {
                    (trial as f64 * FRAC_PI_2, Vector2::from(axis))
                } else {
                    let angle: f64 = stream.random_range(0.0..TAU);
                    (angle, vector![angle.cos(), angle.sin()])
                };
                let across = vector![-along[1], along[0]];
                let target = vector![4.2, 4.7];
                let from = target - along * AHEAD + across * (1.0 + side * off);
                let bodies = [(target.into(), [0.0; 2]), (from.into(), along.into())];
                let gas = few(1.0, [SIDE; 2], bodies)?;
                about!(log; "b = d (1 {sign} {off:.1e}), angle {angle:.2}");
                // Closest approach, where a missed contact is deepest.
                let middle = gas.run_until(AHEAD, 10)?;
                log.at_most("overlap at closest approach", middle.overlap, band);
                let course = gas.run_until(AHEAD + 1.5, 10)?;
                gas.audit(log, &course);
                let hit = course.collisions();
                if off <= band {
                    open += 1;
                    must!(log, hit <= 1; "{hit} contacts");
                } else if side < 0.0 {
                    hits += hit;
                    must!(log, hit == 1; "{hit} contacts");
                    // Contact is sqrt(2 e) d before the closest approach; its error is that of e
                    // over sqrt(2 e).
                    let expected = AHEAD - (2.0 * off - off * off).sqrt();
                    let error = (course.ledger.first.unwrap_or(f64::NAN) - expected).abs();
                    log.at_most(
                        "time of contact off",
                        error,
                        band / (2.0 * off).sqrt() + band,
                    );
                } else {
                    misses += 1;
                    must!(log, hit == 0; "{hit} contacts");
                }
            }
        }
    }
    found!(log; "{hits} contacts, {misses} misses, {open} within rounding (e <= {band:.1e})");
    let bodies = [([4.2, 4.7], [0.0; 2]), ([1.2, 5.7 - 1e-13], [1.0, 0.0])];
    log.about("grazing");
    few(1.0, [SIDE; 2], bodies)?.survives_kills(log, 2, 1)
}

fn touching(log: &mut TrialLog) -> Done {
    let motions = [
        ("at rest", 0.0, 0.0, 0),
        ("approaching", 1.0, 0.0, 1),
        ("approaching askew", 0.3, 1.0, 1),
        ("approaching slowly", 1e-9, 0.0, 1),
        ("receding", -1.0, 0.0, 0),
        ("receding askew", -0.3, 1.0, 0),
    ];
    let mut tried = 0;
    for distance in [1.0 - f64::EPSILON / 2.0, 1.0, 1.0 + f64::EPSILON] {
        // Along the axes from the origin, where the distance is exact, and along other directions.
        for [x, y] in [[1.0, 0.0], [0.0, 1.0], [0.6, 0.8], [-0.8, 0.6]] {
            for origin in [[0.0, 0.0], [3.3, 4.4]] {
                for (name, normal, sliding, contacts) in motions {
                    tried += 1;
                    let velocity = [-normal * x - sliding * y, -normal * y + sliding * x];
                    let other = [origin[0] + distance * x, origin[1] + distance * y];
                    let gas = few(1.0, [12.0; 2], [(origin, [0.0; 2]), (other, velocity)])?;
                    let apart = distance - 1.0;
                    about!(log; "{name}, distance 1 {apart:+.0e}, from {origin:?} along [{x}, {y}]");
                    let course = gas.run_until(1.0, 10)?;
                    gas.audit(log, &course);
                    let good = course.stopped.is_none() && course.collisions() == contacts;
                    must!(log, good; "{}", course.ended());
                    // A gap of the rounding of positions, 1e-15, at the normal speed.
                    if let Some(time) = course.ledger.first {
                        log.at_most("time of contact", time, 4e-15 / normal);
                    }
                    gas.survives_kills(log, 2, 1)?;
                }
            }
        }
    }
    found!(log; "{tried} pairs");
    Ok(())
}

fn overlapping(log: &mut TrialLog) -> Done {
    // Disks 0 and 3 of four.
    let four = |depth: f64| {
        let bodies = [
            ([0.3, 5.0], [0.0, 0.0]),
            ([4.0, 2.0], [0.0, 0.1]),
            ([4.0, 4.0], [0.0, 0.0]),
            ([9.3 + depth, 5.0], [1.0, 0.0]),
        ];
        few(1.0, [10.0; 2], bodies)
    };
    // Depths beyond 1e-9, which the runner of cases refuses.
    for depth in [2e-9, 1e-6, 1e-3, 0.5, 0.999] {
        let gas = four(depth)?;
        about!(log; "depth {depth}");
        let Some(overlap) = gas.overlap(&gas.start, 1e-9) else {
            log.fault("not found");
            continue;
        };
        must!(log, overlap.pair == [0, 3]; "pair {:?}", overlap.pair);
        // Positions up to 10 are rounded to 2e-15.
        log.at_most("depth off", (overlap.depth - depth).abs(), 1e-14);
    }
    // Depths that the runner of cases accepts: between unit disks, and between disks of a
    // hundredth.
    for depth in [1e-16, 1e-15, 1e-13, 1e-11, 0.9e-9] {
        let gas = four(depth)?;
        about!(log; "depth {depth}");
        must!(log, gas.overlap(&gas.start, 1e-9).is_none(); "refused");
        check_overlap_bounded(log, &gas, depth);
        let small = mixture(vec![(0.005, 1e-4), (0.005, 1e-4), (0.5, 1.0)], 1.0)?;
        let bodies = [
            (vector![1.0, 1.0], vector![0.0, 0.0]),
            (vector![1.01 - depth, 1.0], vector![-1.0, 0.0]),
            (vector![5.0, 5.0], vector![0.0, 0.0]),
        ];
        about!(log; "small disks, depth {depth}");
        check_overlap_bounded(
            log,
            &StressGas::new(small, state(domain(8.0, 8.0)?, bodies)),
            depth,
        );
    }
    log.found("five depths found with their pair, five within tolerance run");
    Ok(())
}

/// Checks that a gas of exact disks runs without an error, and never overlaps deeper than at the
/// start.
fn check_overlap_bounded<P: Planar>(log: &mut TrialLog, gas: &StressGas<P>, depth: f64) {
    log.guard(|log| {
        let course = gas.run_until(20.0, 1000)?;
        must!(log, course.reached; "{}", course.ended());
        log.at_most("overlap later", course.overlap, depth + OVERLAP);
        Ok(())
    });
}

fn resting(log: &mut TrialLog) -> Done {
    /// Largest allowed overlap of resting disks in long runs, over the diameter.
    const LONG_OVERLAP: f64 = 1e-10;
    let mut stream = random(3);
    let (mut worst, mut more) = (0.0_f64, 0);
    for _ in 0..24 {
        let angle: f64 = stream.random_range(0.0..TAU);
        let along = vector![angle.cos(), angle.sin()];
        // Drift of the pair at a speed of one half.
        let offset = vector![-along[1], along[0]] * stream.random_range(-0.9..0.9);
        let at = vector![20.0, 20.0] - along * 3.0 + offset;
        let mut gas = few(
            0.0,
            [40.0; 2],
            [([20.0; 2], [0.0; 2]), (at.into(), along.into())],
        )?;
        let contact = gas.run_until(f64::INFINITY, 1)?;
        must!(log, contact.collisions() == 1; "no contact");
        gas.start = contact.end.state;
        let [one, other] = [gas.start.bodies[0], gas.start.bodies[1]];
        let common: Vector2<f64> = 0.5 * (one.velocity + other.velocity);
        let line = gas
            .start
            .domain
            .displacement(one.position, other.position)
            .normalize();
        // Removal of the sliding velocity, which would part the pair; rounding along the line
        // stays.
        for body in &mut gas.start.bodies {
            body.velocity = common + line * (body.velocity - common).dot(&line);
        }
        let course = gas.run_until(gas.start.time + 2e6, 10_000)?;
        must!(log, course.reached; "later {}", course.ended());
        more += course.collisions();
        worst = worst.max(course.overlap);
    }
    log.at_most("overlap after 1e6 diameters", worst, LONG_OVERLAP);
    found!(log; "24 pairs, {more} more contacts, deepest overlap {worst:.1e} d");
    Ok(())
}

fn drifting(log: &mut TrialLog) -> Done {
    for restitution in [1.0, 0.5] {
        let gas = disordered(40, 0.3, restitution, 8)?;
        let rest = gas.pairs(40)?;
        for speed in [1e3, 1e5] {
            let mut boosted = gas.clone();
            for body in &mut boosted.start.bodies {
                body.velocity += vector![speed, -0.7 * speed];
            }
            about!(log; "r = {restitution}, speed {speed:.0e}");
            let most = if speed > 1e4 { 10 } else { 40 };
            let found = boosted.pairs(most)?;
            // Velocities are rounded to 1e-16 of the speed; two collisions of each disk multiply it
            // by about e^2 each, the longest flight adds its time.
            let tolerance = 1e-16 * speed * 1e4;
            let mut both = rest.iter().zip(&found);
            let differ = both.position(|(a, b)| a.1 != b.1 || (a.0 - b.0).abs() > tolerance);
            let good = differ.is_none() && found.len() == most;
            must!(log, good; "collision {differ:?} differs");
            let course = boosted.run_until(3e4 / speed, 100_000)?;
            must!(log, course.stopped.is_none(); "{}", course.ended());
            // Positions move by the speed in a unit of time and are as exact as the clock.
            log.at_most("overlap", course.overlap, OVERLAP + 1e-15 * speed);
            let (collisions, overlap) = (course.collisions(), course.overlap);
            found_in_gas!(log; "{collisions} collisions, overlap {overlap:.1e}");
            boosted.survives_kills(log, most as u64, 1)?;
        }
    }
    Ok(())
}
