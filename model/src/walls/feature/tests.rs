use super::*;
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

use crate::walls::{Obstacle, ObstacleShape, Rebound};
use parry2d_f64::math::{Pose, Vector};
use parry2d_f64::query::{Ray, RayCast, ShapeCastOptions, cast_shapes};
use parry2d_f64::shape::{Ball, Capsule};

type Stream = Xoshiro256PlusPlus;

fn specular() -> Rebound {
    Rebound::Restitutive {
        restitution: 1.0,
        slip: 1.0,
    }
}

fn obstacle(outline: ObstacleShape) -> Obstacle {
    Obstacle::new(outline, specular()).expect("an obstacle")
}

fn random(stream: &mut Stream, scale: f64) -> Vector2<f64> {
    let mut number = || stream.random_range(-scale..scale);
    vector![number(), number()]
}

/// Against parry's closed form for two balls, at gaps from 1e-6 on where it has 1e-13; grazing
/// hits, whose discriminant is below 1e-6, are left out, as their times are the roots of rounding.
#[test]
fn a_disc_is_hit_when_parry_says() {
    let mut stream = Stream::seed_from_u64(1);
    let mut hits = 0;
    for _ in 0..20_000 {
        let (radius, own) = (stream.random_range(0.1..1.0), stream.random_range(0.0..1.0));
        let angle = stream.random_range(0.0..std::f64::consts::TAU);
        let gap = 10.0_f64.powf(stream.random_range(-6.0..0.5));
        let position = vector![angle.cos(), angle.sin()] * (radius + own + gap);
        let velocity = random(&mut stream, 1.0);
        let aside = position.perp(&velocity) / velocity.norm() / (radius + own);
        if (aside.abs() - 1.0).abs() < 1e-6 {
            continue;
        }
        let ours = obstacle(ObstacleShape::Circle {
            centre: vector![0.0, 0.0],
            radius,
        })
        .first_contact(position, velocity, vector![0.0, 0.0], own, f64::INFINITY);
        let theirs = cast_shapes(
            &Pose::from_translation(position.into()),
            velocity.into(),
            &Ball::new(own),
            &Pose::identity(),
            Vector::ZERO,
            &Ball::new(radius),
            ShapeCastOptions::default(),
        )
        .expect("balls are supported")
        .map(|hit| hit.time_of_impact);
        assert_eq!(ours.is_some(), theirs.is_some());
        if let (Some(ours), Some(theirs)) = (ours, theirs) {
            hits += 1;
            assert!((ours.time - theirs).abs() < 1e-10 * (1.0 + theirs));
            let contact = position + velocity * ours.time;
            assert!((contact - ours.normal * (radius + own)).norm() < 1e-12);
        }
    }
    assert!(hits > 5_000);
}

/// A segment is for a disk what a capsule is for a point: against parry's closed form for a ray and
/// a capsule, which has 3e-15.
#[test]
fn a_segment_is_hit_as_a_capsule_by_a_ray() {
    let mut stream = Stream::seed_from_u64(2);
    let mut hits = 0;
    for _ in 0..20_000 {
        let ends = [random(&mut stream, 1.0), random(&mut stream, 1.0)];
        let own = 10.0_f64.powf(stream.random_range(-3.0..0.0));
        let position = random(&mut stream, 3.0);
        let velocity = random(&mut stream, 1.0);
        let segment = obstacle(ObstacleShape::Segment { ends });
        if segment.clearance(position) < own + 1e-6 {
            continue;
        }
        let ours = segment.first_contact(position, velocity, vector![0.0, 0.0], own, f64::INFINITY);
        let capsule = Capsule::new(ends[0].into(), ends[1].into(), own);
        let ray = Ray::new(position.into(), velocity.into());
        let theirs = capsule.cast_local_ray(&ray, f64::MAX, true);
        let closest = {
            let steps = (0..4000).map(|step| position + velocity * (f64::from(step) * 0.01));
            steps
                .map(|at| segment.clearance(at))
                .fold(f64::MAX, f64::min)
        };
        match (ours, theirs) {
            (Some(ours), Some(theirs)) => {
                hits += 1;
                let off = (ours.time - theirs).abs() * velocity.norm();
                let sine = (ours.normal.dot(&velocity) / velocity.norm()).abs();
                assert!(off < 1e-13 / sine, "{ours:?} {theirs}");
            }
            (None, None) => {}
            (ours, theirs) => assert!((closest - own).abs() < 1e-3, "{ours:?} {theirs:?}"),
        }
    }
    assert!(hits > 1_000, "{hits}");
}

fn shapes(stream: &mut Stream) -> Vec<Obstacle> {
    let corner = 1.0_f64.to_radians();
    vec![
        obstacle(ObstacleShape::Circle {
            centre: random(stream, 0.5),
            radius: stream.random_range(0.05..0.8),
        }),
        obstacle(ObstacleShape::Segment {
            ends: [random(stream, 1.0), random(stream, 1.0)],
        }),
        obstacle(ObstacleShape::Polyline {
            points: vec![
                vector![-1.0, 0.3],
                vector![0.0, -0.4],
                vector![0.2, 0.9],
                vector![1.0, 0.8],
            ],
        }),
        // Not convex, clockwise.
        obstacle(ObstacleShape::Polygon {
            points: vec![
                vector![-1.0, -1.0],
                vector![-0.8, 1.0],
                vector![0.0, 0.1],
                vector![0.9, 1.0],
                vector![1.0, -0.7],
            ],
        }),
        // A blade of one degree.
        obstacle(ObstacleShape::Polygon {
            points: vec![
                vector![-1.0, 0.0],
                vector![1.0, 0.0],
                vector![1.0, 2.0 * corner.tan()],
            ],
        }),
    ]
}

/// Parabolas against all shapes: the surface is touched at the time that is found, and at no time
/// before, sampled at two thousand. Positions are rounded to some 1e-15, and a particle that
/// approaches slowly is off by the square root of that at most between two samples that see it.
#[test]
fn parabolas_hit_first_then() {
    let mut stream = Stream::seed_from_u64(3);
    let (mut hits, mut missed, mut corners) = (0, 0, 0);
    for round in 0..3000 {
        for shape in shapes(&mut stream) {
            let own = [0.0, 0.05, 0.3][round % 3];
            let flight = FlyingParticle {
                position: random(&mut stream, 3.0),
                velocity: random(&mut stream, 2.0),
                acceleration: random(&mut stream, 2.0) * [1e-3, 1.0, 1.0][round % 3],
            };
            let taken = shape.taken(own);
            if shape.clearance(flight.position) < taken + 1e-9 {
                continue;
            }
            let limit = 8.0;
            let found = shape.first_contact(
                flight.position,
                flight.velocity,
                flight.acceleration,
                own,
                limit,
            );
            let end = found.map_or(limit, |hit| hit.time);
            for step in 0..2000 {
                let time = end * f64::from(step) / 2000.0;
                let clear = shape.clearance(flight.position_at(time)) - taken;
                assert!(
                    clear > -1e-13,
                    "{shape:?} {flight:?} {found:?} {time} {clear}"
                );
            }
            let Some(hit) = found else {
                missed += 1;
                continue;
            };
            hits += 1;
            let (at, velocity) = (flight.position_at(hit.time), flight.velocity_at(hit.time));
            assert!((shape.clearance(at) - taken).abs() < 1e-13 * (1.0 + flight.position.amax()));
            assert!(velocity.dot(&hit.normal) <= 1e-12);
            assert!((hit.normal.norm() - 1.0).abs() < 1e-15);
            let foot = at - hit.normal * taken;
            assert!(shape.clearance(foot).abs() < 1e-12);
            let edge = shape.features().iter().any(|feature| {
                matches!(feature, Feature::Edge(_))
                    && feature.first_contact(&flight, taken, limit) == Some(hit)
            });
            corners += usize::from(!edge);
        }
    }
    assert!(
        hits > 1500 && missed > 5000 && corners > 400,
        "{hits} {missed} {corners}"
    );
}

/// A particle that bounces in a closed line of edges with corners, 30000 times for each radius and
/// pull: it stays inside, keeps its energy, and no contact repeats itself at once.
#[test]
fn rebounds_do_not_leak_or_repeat() {
    let points = vec![
        vector![0.0, 0.0],
        vector![4.0, 0.0],
        vector![4.0, 3.0],
        vector![2.0, 1.5],
        vector![0.5, 3.0],
        vector![0.0, 0.0],
    ];
    let inside = obstacle(ObstacleShape::Polygon {
        points: points[1..].to_vec(),
    });
    let ring = obstacle(ObstacleShape::Polyline { points });
    let disk = obstacle(ObstacleShape::Circle {
        centre: vector![2.5, 0.8],
        radius: 0.2,
    });
    for (own, pull) in [
        (0.0, vector![0.0, 0.0]),
        (0.1, vector![0.0, 0.0]),
        (0.0, vector![0.0, -1.0]),
        (0.1, vector![0.2, -1.0]),
    ] {
        let mut flight = FlyingParticle {
            position: vector![1.0, 0.6],
            velocity: vector![0.7, 1.1],
            acceleration: pull,
        };
        let energy = |flight: &FlyingParticle| {
            0.5 * flight.velocity.norm_squared() - pull.dot(&flight.position)
        };
        let start = energy(&flight);
        let mut repeated = 0;
        for _ in 0..30_000 {
            let hit = [&ring, &disk]
                .into_iter()
                .filter_map(|shape| {
                    shape.first_contact(
                        flight.position,
                        flight.velocity,
                        flight.acceleration,
                        own,
                        f64::INFINITY,
                    )
                })
                .min_by(|a, b| a.time.total_cmp(&b.time))
                .expect("it is shut in");
            // Only in a corner, where it meets the other edge.
            repeated = if hit.time < 1e-12 { repeated + 1 } else { 0 };
            assert!(repeated < 4, "{own} {pull} {flight:?}");
            let velocity = flight.velocity_at(hit.time);
            flight.position = flight.position_at(hit.time);
            flight.velocity = velocity
                - hit.normal * (2.0 * velocity.dot(&hit.normal) / hit.normal.norm_squared());
            assert!(inside.holds(flight.position));
            assert!(ring.clearance(flight.position) > own - 1e-12);
            assert!(disk.clearance(flight.position) > own - 1e-12);
        }
        // A walk of 3e4 steps of some roundings each.
        assert!(
            (energy(&flight) - start).abs() < 1e-12,
            "{}",
            energy(&flight) - start
        );
    }
}

/// Past a disk, a corner and an edge at a distance of 1e-12 more or less than the radius: hit or
/// not, and never lost.
#[test]
fn grazing_is_told_on_both_sides() {
    let still = vector![0.0, 0.0];
    let shapes = [
        obstacle(ObstacleShape::Circle {
            centre: still,
            radius: 0.5,
        }),
        obstacle(ObstacleShape::Segment {
            ends: [vector![-0.5, -1.0], vector![0.0, 0.5]],
        }),
    ];
    for shape in &shapes {
        let pass = |above: f64, pull: f64| {
            // The top of the parabola is at x = 0, at a height of 0.75 + above.
            let height = 0.75 + above - 0.5 * pull.abs() * 9.0;
            let (start, velocity) = (vector![-3.0, height], vector![1.0, 3.0 * pull.abs()]);
            let acceleration = vector![0.0, -pull];
            shape.first_contact(start, velocity, acceleration, 0.25, 10.0)
        };
        for pull in [0.0, 1e-3, 0.1] {
            assert!(pass(1e-12, pull).is_none(), "{shape:?} {pull}");
            let hit = pass(-1e-12, pull).expect("a hit");
            assert!(
                (hit.time - 3.0).abs() < 1e-4 && hit.normal[1] > 0.999,
                "{hit:?}"
            );
        }
    }
    // At rest above, and pulled: lands on top. At rest on top: is there.
    for (height, time) in [(0.75 + 0.125, 0.5), (0.75, 0.0)] {
        let hit =
            shapes[0].first_contact(vector![0.0, height], still, vector![0.0, -1.0], 0.25, 9.0);
        let found = hit.expect("lands").time;
        assert!((found - time).abs() <= f64::EPSILON * time, "{found}");
    }
    // Thrown up from the top comes back after 2 v/g, also when by rounding it is inside.
    for v in [1e-3, 1e-7, 1e-9] {
        for height in [0.75, 0.75 - 1e-16, 0.75 + 1e-16] {
            let hit = shapes[0]
                .first_contact(
                    vector![0.0, height],
                    vector![0.0, v],
                    vector![0.0, -1.0],
                    0.25,
                    9.0,
                )
                .expect("comes back");
            // The height is known to 1e-16, and so the time is to 1e-16/v.
            assert!(
                (hit.time - 2.0 * v).abs() < 4e-16 / v + 1e-15,
                "{v} {height} {hit:?}"
            );
        }
    }
}

#[test]
fn flights_stay_in_their_bounds() {
    let mut stream = Stream::seed_from_u64(4);
    for _ in 0..1000 {
        let flight = FlyingParticle {
            position: random(&mut stream, 1.0),
            velocity: random(&mut stream, 1.0),
            acceleration: random(&mut stream, 1.0),
        };
        let [least, most] = flight.bounds(3.0);
        for step in 0..=300 {
            let at = flight.position_at(0.01 * f64::from(step));
            for axis in 0..2 {
                assert!(at[axis] > least[axis] - 1e-14 && at[axis] < most[axis] + 1e-14);
            }
        }
    }
}
