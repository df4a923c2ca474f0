//! Hard cases of exact disks that collide at the same time.

use nalgebra::Vector2;
use rand::RngExt;
use stosszahl_model::State;
use stosszahl_model::samples::EqualDisks;

use super::gas::{StressGas, few};
use crate::gas::random;
use crate::{Done, TrialError, TrialLog};

trials! {
    "lattice-ties" => lattices,
        "square lattices whose disks all move and meet at the same instants, in four patterns, spacings of 1.5 and 1.1 d",
        "same bits however the disks are numbered; energy, momentum, exclusion";
    "cradle" => cradles,
        "rows of 5 and 12 disks at rest with gaps of 0, 1e-15, 1e-12 and 1e-6, hit at one end and at both",
        "velocities are exchanged along the row: what hits one end leaves at the other; same bits however the disks are numbered";
    "triple" => triples,
        "two, four and six disks that meet one in the middle at once, restitution 1, 0.8 and 0.3",
        "same bits however the disks are numbered; energy, momentum, exclusion";
}

/// Counts of the gases that were run with several numberings of their disks, and of their
/// collisions in one numbering.
#[derive(Default)]
struct Sum {
    gases: usize,
    collisions: u64,
}

impl Sum {
    /// Runs a gas with its disks numbered in several orders. Checks that the disks are bitwise
    /// equal at the end, with equal numbers of collisions.
    fn add(
        &mut self,
        log: &mut TrialLog,
        gas: &StressGas<EqualDisks>,
        until: f64,
    ) -> Result<State<EqualDisks>, TrialError> {
        const MOST: u64 = 10_000;
        let course = gas.run_until(until, MOST)?;
        must!(log, course.stopped.is_none(); "{}", course.ended());
        gas.audit(log, &course);
        let (end, collisions) = (course.end.state, course.ledger.collisions);
        let count = gas.start.bodies.len();
        let mut stream = random(7);
        for trial in 0..6 {
            let mut order: Vec<usize> = (0..count).collect();
            if trial == 0 {
                order.reverse();
            } else {
                // Random permutation by Fisher and Yates.
                for last in (1..count).rev() {
                    order.swap(last, stream.random_range(0..=last));
                }
            }
            // Numbering in which disk `i` is `order[i]`.
            let mut other = gas.clone();
            for (body, &name) in gas.start.bodies.iter().zip(&order) {
                other.start.bodies[name] = *body;
            }
            let other = other.run_until(until, MOST)?;
            let found = other.collisions();
            must!(log, collisions == found; "{collisions} collisions in one numbering, {found} in another");
            let off = |i: usize| {
                let (a, b) = (&end.bodies[i], &other.end.state.bodies[order[i]]);
                if bits(a.position) == bits(b.position) && bits(a.velocity) == bits(b.velocity) {
                    return 0.0;
                }
                let apart = gas.start.domain.distance(a.position, b.position);
                apart
                    .max((a.velocity - b.velocity).norm())
                    .max(f64::MIN_POSITIVE)
            };
            let off = (0..count).map(off).fold(0.0, f64::max);
            log.at_most("difference in another numbering", off, 0.0);
            if off > 0.0 {
                break;
            }
        }
        gas.survives_kills(log, 200, 1)?;
        self.gases += 1;
        self.collisions += collisions;
        Ok(end)
    }

    fn say(&self, log: &mut TrialLog) {
        let Self { gases, collisions } = self;
        found!(log; "{gases} gases in 7 numberings each, {collisions} collisions");
    }
}

fn bits(vector: Vector2<f64>) -> [u64; 2] {
    // Zero of one sign, for a bitwise comparison.
    [vector[0] + 0.0, vector[1] + 0.0].map(f64::to_bits)
}

fn lattices(log: &mut TrialLog) -> Done {
    const SIDE: usize = 8;
    /// Function that returns the velocity of the disk in a column and row of a square lattice.
    type Pattern = fn(usize, usize) -> [f64; 2];
    let patterns: [(&str, Pattern); 4] = [
        ("columns towards each other", |x, _| [alternating(x), 0.0]),
        ("chessboard along x", |x, y| [alternating(x + y), 0.0]),
        ("chessboard along the diagonal", |x, y| {
            [alternating(x + y); 2]
        }),
        ("fours into their middle", |x, y| {
            [alternating(x), alternating(y)]
        }),
    ];
    let mut sum = Sum::default();
    for spacing in [1.5, 1.1] {
        for restitution in [1.0, 0.75] {
            for (name, velocity) in patterns {
                let bodies = (0..SIDE * SIDE).map(|index| {
                    let (x, y) = (index % SIDE, index / SIDE);
                    let at = [(x as f64 + 0.5) * spacing, (y as f64 + 0.5) * spacing];
                    (at, velocity(x, y))
                });
                let gas = few(restitution, [SIDE as f64 * spacing; 2], bodies)?;
                about!(log; "{name}, spacing {spacing}, r = {restitution}");
                sum.add(log, &gas, 3.0)?;
            }
        }
    }
    sum.say(log);
    Ok(())
}

fn alternating(number: usize) -> f64 {
    if number.is_multiple_of(2) { 1.0 } else { -1.0 }
}

fn cradles(log: &mut TrialLog) -> Done {
    let mut sum = Sum::default();
    // Along x, and along a direction in which the row is not exact.
    let directions = [[1.0, 0.0], [0.6, 0.8]];
    let rows = [5_usize, 12].into_iter().flat_map(|count| {
        let gaps = [0.0, 1e-15, 1e-12, 1e-6].into_iter();
        gaps.flat_map(move |gap| directions.map(|direction| (count, gap, direction)))
    });
    for (count, gap, direction) in rows {
        for both in [false, true] {
            about!(log; "{count} disks, gap {gap:.0e}, along {direction:?}, both ends {both}");
            let place = |along: f64| direction.map(|part| 20.0 + along * part);
            let move_at = |speed: f64| direction.map(|part| speed * part);
            let last = (count - 1) as f64 * (1.0 + gap);
            let mut bodies: Vec<_> = (0..count)
                .map(|i| (place(i as f64 * (1.0 + gap)), [0.0; 2]))
                .collect();
            bodies.push((place(-2.0), move_at(1.0)));
            if both {
                bodies.push((place(last + 2.0), move_at(-1.0)));
            }
            let end = sum.add(log, &few(1.0, [60.0; 2], bodies)?, 2.0)?;
            // Equal disks on a line exchange velocities, whatever the order of their contacts: both
            // ends rebound, or the last of the row flies on.
            let speed = |who: usize| {
                let v = end.bodies[who].velocity;
                v[0] * direction[0] + v[1] * direction[1]
            };
            let (last, first) = if both {
                (count + 1, -1.0)
            } else {
                (count - 1, 0.0)
            };
            // Off the axes the row is rounded by 1e-14 across: each contact turns the velocity by
            // that and adds up to the next over one diameter, so 2^12 times.
            let tolerance = if direction[1] == 0.0 { 1e-13 } else { 1e-9 };
            let off = (speed(last) - 1.0).abs().max((speed(count) - first).abs());
            log.at_most("speeds off", off, tolerance);
        }
    }
    sum.say(log);
    Ok(())
}

fn triples(log: &mut TrialLog) -> Done {
    let mut sum = Sum::default();
    for around in [2_usize, 4, 6] {
        for restitution in [1.0, 0.8, 0.3] {
            // Middle, edge and corner of a cell.
            for middle in [[10.4, 10.3], [10.0, 10.0], [0.0, 0.0]] {
                let mut bodies = vec![(middle, [0.0; 2])];
                for number in 0..around {
                    let angle = std::f64::consts::TAU * number as f64 / around as f64;
                    let (y, x) = angle.sin_cos();
                    // Exact zeros on the axes, where sin and cos are rounded.
                    let [x, y] = [x, y].map(|c: f64| if c.abs() < 1e-9 { 0.0 } else { c });
                    bodies.push(([middle[0] + 2.5 * x, middle[1] + 2.5 * y], [-x, -y]));
                }
                about!(log; "{around} around {middle:?}, r = {restitution}");
                sum.add(log, &few(restitution, [20.0; 2], bodies)?, 6.0)?;
            }
        }
    }
    sum.say(log);
    Ok(())
}
