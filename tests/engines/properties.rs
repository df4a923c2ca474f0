//! Properties of the event-driven engine in random gases.
//!
//! The gases are the same in every run: proptest draws them from a fixed seed and keeps no files. A
//! gas that fails is shrunk to fewer disks, larger boxes and slower motion before it is shown.

use std::f64::consts::{FRAC_PI_4, TAU};

use nalgebra::{Vector2, vector};
use proptest::prelude::*;
use proptest::test_runner::TestCaseError;
use rand::{RngExt, SeedableRng};
use stosszahl::ed::{
    DissipationRule, EventDrivenCheckpoint, EventDrivenEngine, EventDrivenError, plain,
};
use stosszahl::model::random::Stream;
use stosszahl::model::samples::{DiskMixture, mixture, state};
use stosszahl::model::{Collision, Domain, Observer, Plane, Sizes, State};

use crate::draws::drawn;

/// Numbers from which a random gas is made.
#[derive(Clone, Debug)]
struct Recipe {
    disks: usize,
    packing: f64,
    aspect: f64,
    restitution: f64,
    /// Largest over smallest diameter; 1 for equal disks.
    spread: f64,
    seed: u64,
}

fn recipes() -> impl Strategy<Value = Recipe> {
    (
        1..40_usize,
        0.01..0.7_f64,
        prop_oneof![Just(1.0), 0.2..5.0_f64],
        prop_oneof![Just(1.0), Just(0.0), 0.0..1.0_f64],
        prop_oneof![Just(1.0), 1.0..20.0_f64],
        any::<u64>(),
    )
        .prop_map(
            |(disks, packing, aspect, restitution, spread, seed)| Recipe {
                disks,
                packing,
                aspect,
                restitution,
                spread,
                seed,
            },
        )
}

/// Tests a property on a number of gases, always the same ones.
fn check(gases: u32, property: impl Fn(Recipe) -> Result<(), TestCaseError>) {
    drawn(gases, 1, &recipes(), property);
}

/// Creates a gas without overlap: disks grow together from random points while overlapping ones
/// push each other away, to the largest size at which none overlap, and the box is scaled so that
/// the mean diameter is one.
fn brew(recipe: &Recipe) -> Option<(DiskMixture, State<DiskMixture>)> {
    let mut stream = Stream::seed_from_u64(recipe.seed);
    let count = recipe.disks;
    let shapes: Vec<f64> = (0..count)
        .map(|_| 0.5 * recipe.spread.powf(-stream.random::<f64>()))
        .collect();
    let area: f64 = shapes.iter().map(|r| 4.0 * FRAC_PI_4 * r * r).sum::<f64>() / recipe.packing;
    let width = (area / recipe.aspect).sqrt();
    let domain = Domain::<Plane>::periodic(vector![width, area / width]).ok()?;
    let lengths = domain.lengths();
    let mut places: Vec<Vector2<f64>> = (0..count)
        .map(|_| {
            vector![
                lengths[0] * stream.random::<f64>(),
                lengths[1] * stream.random::<f64>()
            ]
        })
        .collect();
    let gap = |places: &[Vector2<f64>], i: usize, j: usize| {
        domain.distance(places[i], places[j]) / (shapes[i] + shapes[j])
    };
    for _ in 0..400 {
        for i in 0..count {
            for j in 0..i {
                // A little further than contact, or they would still overlap by rounding.
                let missing = 1.02 - gap(&places, i, j);
                if missing > 0.0 {
                    let line = domain.displacement(places[i], places[j]);
                    let push = if line.norm() > 0.0 {
                        line.normalize()
                    } else {
                        vector![1.0, 0.0]
                    };
                    let step = push * (0.5 * missing * (shapes[i] + shapes[j]));
                    places[i] = domain.wrap(places[i] + step);
                    places[j] = domain.wrap(places[j] - step);
                }
            }
        }
    }
    let fit = (0..count)
        .flat_map(|i| (0..i).map(move |j| (i, j)))
        .map(|(i, j)| gap(&places, i, j))
        .fold(1.0, f64::min)
        * (1.0 - 1e-12);
    let radii: Vec<f64> = shapes.iter().map(|r| r * fit).collect();
    let largest = radii.iter().copied().fold(0.0, f64::max);
    // Disks pressed together in one spot, or wider than the box.
    if fit < 0.1 || 2.0 * largest * 1.001 >= lengths.min() {
        return None;
    }
    let sizes = radii.iter().map(|&r| (r, 4.0 * r * r));
    let scene = mixture(recipe.restitution, sizes);
    let bodies = places.into_iter().map(|at| {
        let (angle, speed) = (TAU * stream.random::<f64>(), 0.1 + stream.random::<f64>());
        (at, vector![angle.cos(), angle.sin()] * speed)
    });
    Some((scene, state(domain, bodies)))
}

/// Largest normal over whole relative speed at which rounding decides a contact, see [`Laws`].
const GRAZING: f64 = 1e-6;

/// Observer that checks the laws of every collision.
#[derive(Default)]
struct Laws {
    lost: f64,
    last: f64,
    count: u64,
    fault: Option<String>,
}

impl Observer for Laws {
    fn on_collisions(&mut self, batch: &[Collision]) {
        for collision in batch {
            let approach = -collision.relative_velocity.dot(&collision.line);
            // A contact that grazes is where the square root of a difference of terms of 1e-14
            // says, so its line is turned by up to 1e-7; velocities of order one are rounded
            // besides.
            let rounding =
                (GRAZING * collision.relative_velocity.norm() + 1e-14) * collision.line.norm();
            if approach < -rounding {
                self.fault = Some(format!("a receding pair collides: {collision:?}"));
            }
            if collision.time < self.last {
                self.fault = Some(format!(
                    "time goes back from {} to {}",
                    self.last, collision.time
                ));
            }
            self.last = collision.time;
            self.lost += collision.energy_lost();
            self.count += 1;
        }
    }
}

fn engine(
    scene: &DiskMixture,
    from: impl Into<EventDrivenCheckpoint<DiskMixture>>,
) -> Result<EventDrivenEngine<DiskMixture>, TestCaseError> {
    EventDrivenEngine::new(scene.clone(), DissipationRule::Scene, from)
        .map_err(|error| TestCaseError::fail(error.to_string()))
}

/// Runs a number of collisions, or ends if there are none for long; returns the collisions.
fn run(
    engine: &mut EventDrivenEngine<DiskMixture>,
    collisions: u64,
    watch: &mut impl Observer,
) -> Result<(), TestCaseError> {
    let until = engine.time() + 1000.0;
    match engine.advance(until, collisions, watch) {
        // Collapse is an allowed end of such a gas.
        Ok(_) | Err(EventDrivenError::InelasticCollapse { .. }) => Ok(()),
        Err(error) => Err(TestCaseError::fail(error.to_string())),
    }
}

/// Energy, momentum, exclusion, order of time. Tolerance: a thousand collisions, each rounding
/// numbers of the size of the whole energy or momentum by a few parts in 1e16, all to one side.
#[test]
fn conservation() {
    const TOLERANCE: f64 = 1e-12;
    check(1000, |recipe| {
        let Some((scene, start)) = brew(&recipe) else {
            return Err(TestCaseError::reject("no place"));
        };
        let energy = start.kinetic_energy(&scene);
        let momentum = start.momentum(&scene);
        let scale: f64 = (0..start.bodies.len())
            .map(|i| scene.sizes.mass(i as u32) * start.bodies[i].velocity.norm())
            .sum();
        let mut engine = engine(&scene, start)?;
        let (mut laws, mut last) = (Laws::default(), energy);
        for _ in 0..4 {
            run(&mut engine, 250, &mut laws)?;
            let state = engine.state();
            let now = state.kinetic_energy(&scene);
            prop_assert!(
                now <= last * (1.0 + TOLERANCE),
                "the energy grows from {last} to {now}"
            );
            prop_assert!(
                (now + laws.lost - energy).abs() <= TOLERANCE * energy,
                "{now} + {} is not {energy}",
                laws.lost
            );
            let drift = (state.momentum(&scene) - momentum).norm();
            prop_assert!(
                drift <= TOLERANCE * scale,
                "the momentum changes by {drift:e}"
            );
            // Places are rounded to 1e-15 of the box, flights are of the order of the box.
            let worst = engine.worst_overlap();
            prop_assert!(worst < 1e-12, "overlap {worst:e}");
            prop_assert_eq!(&laws.fault, &None);
            last = now;
        }
        Ok(())
    });
}

/// A smooth collision conserves the angular momentum of a pair about their contact, because the
/// impulse goes through it. It also conserves the tangential part of the relative velocity, and
/// reverses the normal part, shortened by the restitution.
#[test]
fn collisions_of_smooth_disks() {
    check(600, |recipe| {
        let Some((scene, start)) = brew(&recipe) else {
            return Err(TestCaseError::reject("no place"));
        };
        let mut engine = engine(&scene, start)?;
        for _ in 0..30 {
            let mut seen = Seen(None);
            let before = engine.state();
            run(&mut engine, 1, &mut seen)?;
            let after = engine.state();
            let Some(seen) = seen.0 else { break };
            let (relative, line) = (seen.relative_velocity.xy(), seen.line.xy());
            let pair: Vec<usize> = (0..before.bodies.len())
                .filter(|&i| before.bodies[i].velocity != after.bodies[i].velocity)
                .collect();
            // A contact at rest with restitution 0 may leave all as it was.
            let &[i, j] = pair.as_slice() else { continue };
            let swapped = (before.bodies[i].velocity - before.bodies[j].velocity - relative).norm()
                > 1e-12 * relative.norm();
            let sign = if swapped { -1.0 } else { 1.0 };
            let turn = |state: &State<DiskMixture>| {
                // Line of centres of the colliding image; in a narrow box two images may touch.
                let arm = line * sign;
                let [a, b] =
                    [i, j].map(|who| state.bodies[who].velocity * scene.sizes.mass(who as u32));
                0.5 * (arm.perp(&a) - arm.perp(&b))
            };
            let mass = scene.sizes.mass(i as u32) + scene.sizes.mass(j as u32);
            // Distances of order one are rounded to 1e-15 of the box, sides up to a hundred.
            let allowed = 1e-12 * mass * (relative.norm() + 1e-3);
            let change = turn(&after) - turn(&before);
            prop_assert!(
                change.abs() <= allowed,
                "the angular momentum of {pair:?} changes by {change:e}"
            );
            let normal = line.normalize();
            let rebound = (after.bodies[i].velocity - after.bodies[j].velocity) * sign;
            let back = rebound.dot(&normal) + recipe.restitution * relative.dot(&normal);
            prop_assert!(
                back.abs() <= 1e-13 * (1.0 + relative.norm()),
                "restitution off by {back:e}"
            );
            let distance = scene.sizes.radius(i as u32) + scene.sizes.radius(j as u32);
            let gap = line.norm() - distance;
            prop_assert!(gap.abs() <= 1e-12, "contact at a gap of {gap:e}");
        }
        Ok(())
    });
}

struct Seen(Option<Collision>);

impl Observer for Seen {
    fn on_collisions(&mut self, batch: &[Collision]) {
        for collision in batch {
            self.0 = Some(*collision);
        }
    }
}

/// Runs forward, with reversed velocities, and back to the start.
///
/// A collision multiplies differences by up to 1 + 2 flight/diameter. The growth is measured with a
/// second gas displaced by 1e-10, and only as many collisions are tried as leave 1e-16 times the
/// growth below 1e-6.
#[test]
fn elastic_gases_run_backwards() {
    const NUDGE: f64 = 1e-10;
    check(600, |mut recipe| {
        recipe.restitution = 1.0;
        let Some((scene, start)) = brew(&recipe) else {
            return Err(TestCaseError::reject("no place"));
        };
        let mut nudged = start.clone();
        // A displacement of each disk by itself, because scaling or boosting all alike would not
        // separate the gases.
        for (index, body) in nudged.bodies.iter_mut().enumerate() {
            let (sin, cos) = (1.7 * index as f64).sin_cos();
            body.velocity += vector![cos, sin] * NUDGE;
        }
        let mut collisions = 300;
        let (time, reversed) = loop {
            let mut forward = engine(&scene, start.clone())?;
            run(&mut forward, collisions, &mut ())?;
            let mut other = engine(&scene, nudged.clone())?;
            // A gas without collisions stops at the time of the first gas.
            let _ = other.advance(forward.time(), u64::MAX, &mut ());
            let (a, b) = (forward.state(), other.state());
            let apart = furthest(&a, &b);
            if apart * 1e-16 / NUDGE * 100.0 < 1e-8 && apart < 1e-3 {
                break (forward.time(), a);
            }
            if collisions == 0 {
                return Err(TestCaseError::reject("a flight too long"));
            }
            collisions /= 2;
        };
        let mut reversed = reversed;
        reversed.time = 0.0;
        for body in &mut reversed.bodies {
            body.velocity = -body.velocity;
        }
        let mut back = engine(&scene, reversed)?;
        back.advance(time, u64::MAX, &mut ())
            .map_err(|error| TestCaseError::fail(error.to_string()))?;
        let off = furthest(&start, &back.state());
        prop_assert!(
            off < 1e-6,
            "after {collisions} collisions and back off by {off:e}"
        );
        Ok(())
    });
}

fn furthest(a: &State<DiskMixture>, b: &State<DiskMixture>) -> f64 {
    a.bodies
        .iter()
        .zip(&b.bodies)
        .map(|(x, y)| a.domain.distance(x.position, y.position))
        .fold(0.0, f64::max)
}

/// Returns true if two disks approach by no more than the rounding of their velocities, as after a
/// contact with restitution 0: the engine lets those rest on each other, all pairs does not.
fn is_at_rest(state: &State<DiskMixture>, pair: [usize; 2]) -> bool {
    let [one, other] = pair.map(|who| state.bodies[who]);
    let line = state
        .domain
        .displacement(one.position, other.position)
        .normalize();
    let approach = (one.velocity - other.velocity).dot(&line).abs();
    approach <= 1e-13 * (one.velocity.norm() + other.velocity.norm())
}

/// The engine's next collision is that of all pairs, asked anew for each, so that differences do
/// not grow.
#[test]
fn next_collision_is_that_of_all_pairs() {
    check(1000, |recipe| {
        let Some((scene, start)) = brew(&recipe) else {
            return Err(TestCaseError::reject("no place"));
        };
        let mut engine = engine(&scene, start)?;
        for number in 0..12 {
            let before = engine.state();
            let mut seen = Seen(None);
            run(&mut engine, 1, &mut seen)?;
            let mut plain_state = before.clone();
            let slow = plain::run_collisions(&scene, &mut plain_state, 1);
            let at_rest = slow
                .first()
                .is_some_and(|event| is_at_rest(&before, event.pair));
            let grazes = seen.0.is_some_and(|collision| {
                let normal = collision.normal_square().sqrt();
                normal <= GRAZING * collision.relative_velocity.norm() + 1e-14
            });
            if at_rest || grazes {
                break;
            }
            match (seen.0, slow.first()) {
                (Some(ours), Some(theirs)) => {
                    let normal = ours.normal_square().sqrt();
                    let fastest = before
                        .bodies
                        .iter()
                        .map(|b| b.velocity.norm())
                        .fold(0.0, f64::max);
                    // Places are rounded to 1e-15 of the box, at most 1e-13; the time is that over
                    // the normal speed, and all fly on for it.
                    let tolerance = 1e-12 * (1.0 + fastest / normal);
                    let error = (ours.time - theirs.time).abs() * normal;
                    prop_assert!(
                        error < 1e-12,
                        "collision {number}: at {} and {theirs:?}",
                        ours.time
                    );
                    let after = engine.state();
                    let apart = furthest(&after, &plain_state);
                    prop_assert!(
                        apart < tolerance,
                        "collision {number}: places {apart:e} apart"
                    );
                    let faster = after
                        .bodies
                        .iter()
                        .zip(&plain_state.bodies)
                        .map(|(a, b)| (a.velocity - b.velocity).norm())
                        .fold(0.0, f64::max);
                    prop_assert!(
                        faster < tolerance * (1.0 + fastest),
                        "collision {number}: velocities {faster:e} apart"
                    );
                }
                // The search of all pairs sees only images near by.
                (_, None) => break,
                (None, Some(theirs)) => {
                    prop_assert!(
                        theirs.time > before.time + 999.0,
                        "collision {number}: none, {theirs:?}"
                    );
                    break;
                }
            }
        }
        Ok(())
    });
}
