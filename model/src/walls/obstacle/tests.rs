use super::*;
use nalgebra::vector;
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

fn specular() -> Rebound {
    Rebound::Restitutive {
        restitution: 1.0,
        slip: 1.0,
    }
}

fn refused(outline: ObstacleShape) -> ObstacleError {
    Obstacle::new(outline, specular()).expect_err("is no obstacle")
}

#[test]
fn what_is_no_obstacle_is_refused() {
    let origin = vector![0.0, 0.0];
    let centre = vector![1.0, 1.0];
    for radius in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let error = refused(ObstacleShape::Circle { centre, radius });
        assert!(matches!(
            error,
            ObstacleError::Invalid(InvalidValue {
                quantity: "radius",
                ..
            })
        ));
    }
    let error = refused(ObstacleShape::Segment {
        ends: [origin, vector![f64::NAN, 0.0]],
    });
    assert!(matches!(error, ObstacleError::Invalid(_)), "{error}");
    let error = refused(ObstacleShape::Segment {
        ends: [centre, centre],
    });
    assert!(
        matches!(error, ObstacleError::Degenerate { edge: 0, .. }),
        "{error}"
    );
    let error = refused(ObstacleShape::Polyline {
        points: vec![origin],
    });
    assert!(matches!(
        error,
        ObstacleError::TooFewPoints { least: 2, .. }
    ));
    let error = refused(ObstacleShape::Polygon {
        points: vec![origin, centre],
    });
    assert!(matches!(
        error,
        ObstacleError::TooFewPoints { least: 3, .. }
    ));
    // A bow tie, a spike, a line that returns to its middle, and one that runs along itself.
    let bow_tie = vec![
        origin,
        vector![1.0, 1.0],
        vector![1.0, 0.0],
        vector![0.0, 1.0],
    ];
    let spike = vec![
        origin,
        vector![2.0, 0.0],
        vector![1.0, 0.0],
        vector![1.0, 1.0],
    ];
    for points in [bow_tie, spike] {
        let error = refused(ObstacleShape::Polygon { points });
        assert!(
            matches!(error, ObstacleError::SelfTouching { .. }),
            "{error}"
        );
    }
    let returns = vec![
        origin,
        vector![2.0, 0.0],
        vector![1.0, 1.0],
        vector![1.0, 0.0],
    ];
    let error = refused(ObstacleShape::Polyline { points: returns });
    assert!(
        matches!(error, ObstacleError::SelfTouching { edges: [0, 2], .. }),
        "{error}"
    );
    let law = Rebound::Restitutive {
        restitution: 1.5,
        slip: 1.0,
    };
    let error = Obstacle::new(
        ObstacleShape::Circle {
            centre,
            radius: 1.0,
        },
        law,
    )
    .expect_err("a law");
    assert!(error.to_string().contains("restitution is 1.5"), "{error}");
}

#[test]
fn closed_lines_and_sharp_corners_are_obstacles() {
    let corner = 1.0_f64.to_radians();
    let wedge = vec![
        vector![0.0, 0.0],
        vector![1.0, 0.0],
        vector![corner.cos(), corner.sin()],
    ];
    let solid = Obstacle::new(
        ObstacleShape::Polygon {
            points: wedge.clone(),
        },
        specular(),
    );
    let solid = solid.expect("a wedge of one degree");
    assert!((solid.area() - 0.5 * corner.sin()).abs() < 1e-16);
    assert_eq!(solid.features().len(), 6);
    let mut ring = wedge;
    ring.push(ring[0]);
    let ring = Obstacle::new(ObstacleShape::Polyline { points: ring }, specular());
    assert_eq!(ring.expect("closed").features().len(), 6);
}

#[test]
fn clearance_is_the_distance_from_the_surface() {
    let hollow = Obstacle::new(
        ObstacleShape::Polygon {
            points: vec![
                vector![0.0, 0.0],
                vector![4.0, 0.0],
                vector![4.0, 4.0],
                vector![2.0, 1.0],
                vector![0.0, 4.0],
            ],
        },
        specular(),
    )
    .expect("a polygon");
    // No corner where it is hollow.
    assert_eq!(hollow.features().len(), 9);
    assert_eq!(hollow.area(), 10.0);
    assert_eq!(hollow.clearance(vector![2.0, 0.5]), -0.5);
    assert_eq!(hollow.clearance(vector![2.0, -0.5]), 0.5);
    assert_eq!(hollow.clearance(vector![-3.0, -4.0]), 5.0);
    assert!(hollow.clearance(vector![2.0, 3.0]) > 0.0);
    assert!(hollow.overlaps(vector![2.0, -0.5], 0.6, 1e-9));
    assert!(!hollow.overlaps(vector![2.0, -0.5], 0.5, 1e-9));
    assert!(hollow.overlaps(vector![2.0, 0.5], 0.0, 1e-9));
    assert_eq!(hollow.bounds(), [vector![0.0, 0.0], vector![4.0, 4.0]]);
    assert!(hollow.check_inside(vector![4.0, 4.0]).is_ok());
    let error = hollow
        .check_inside(vector![4.0, 3.0])
        .expect_err("too large");
    assert!(
        error.to_string().contains("allowed is the box of 4 x 3"),
        "{error}"
    );
}

/// The hierarchy finds the contacts that a loop over all obstacles finds.
#[test]
fn many_obstacles_are_hit_as_each_of_them() {
    let mut stream = Xoshiro256PlusPlus::seed_from_u64(5);
    let mut number = |low: f64, high: f64| stream.random_range(low..high);
    let all: Vec<Obstacle> = (0..40)
        .map(|which| {
            let centre = vector![number(0.0, 10.0), number(0.0, 10.0)];
            let outline = if which % 2 == 0 {
                ObstacleShape::Circle {
                    centre,
                    radius: number(0.05, 0.4),
                }
            } else {
                let to = centre + vector![number(-0.5, 0.5), number(-0.5, 0.5)];
                ObstacleShape::Segment { ends: [centre, to] }
            };
            Obstacle::new(outline, specular()).expect("an obstacle")
        })
        .collect();
    let many = Obstacles::new(all.clone());
    let mut hits = 0;
    for round in 0..5000 {
        let position = vector![number(0.0, 10.0), number(0.0, 10.0)];
        let velocity = vector![number(-1.0, 1.0), number(-1.0, 1.0)];
        let pull = if round % 2 == 0 { 0.0 } else { -1.0 };
        let acceleration = vector![0.0, pull];
        let radius = [0.0, 0.1][round / 2 % 2];
        let plain = all
            .iter()
            .enumerate()
            .filter_map(|(number, obstacle)| {
                let hit = obstacle.first_contact(position, velocity, acceleration, radius, 2.0)?;
                Some((number, hit))
            })
            .min_by(|a, b| a.1.time.total_cmp(&b.1.time));
        let found = many.first_contact(position, velocity, acceleration, radius, 2.0);
        assert_eq!(found.is_some(), plain.is_some());
        if let (Some((one, hit)), Some((other, same))) = (found, plain) {
            assert_eq!(one, other);
            // The bracket of a root depends on what was found before, and the last digit on the
            // bracket.
            assert!((hit.time - same.time).abs() < 1e-14 * (1.0 + same.time));
        }
        let overlapped = all
            .iter()
            .position(|one| one.overlaps(position, radius, 1e-9));
        assert_eq!(many.overlapped(position, radius, 1e-9), overlapped);
        hits += usize::from(found.is_some());
    }
    assert!(hits > 1000);
    assert!(
        Obstacles::new(Vec::new())
            .first_contact(
                vector![0.0, 0.0],
                vector![1.0, 0.0],
                vector![0.0, 0.0],
                0.1,
                1.0
            )
            .is_none()
    );
}
