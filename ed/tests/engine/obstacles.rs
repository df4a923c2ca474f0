//! Disks around obstacles: their description, and hard cases.

use nalgebra::{Vector2, vector};
use stosszahl_ed::{DiskBoundaries, DissipationRule, EventDrivenEngine};
use stosszahl_model::samples::{disks, grains, law, species};
use stosszahl_model::walls::{Obstacle, ObstacleShape, Wall};
use stosszahl_model::{Rebound, Scene, Smooth};

use crate::support::{alone, bounces, closed, down, follow_plain, gas, obstacle, rough, walled};

/// An obstacle that reaches to the edge of a periodic box stands on the other side too, for disks
/// that come from there.
#[test]
fn obstacles_are_seen_across_the_periodic_boundary() {
    let mut boundaries = DiskBoundaries::periodic();
    boundaries.obstacles.push(obstacle(ObstacleShape::Circle {
        centre: vector![0.5, 5.0],
        radius: 0.5,
    }));
    // Disk against the disk from the left, across the boundary.
    let state = alone(&boundaries, [8.0, 8.0], [6.0, 5.0], [1.0, 0.0]);
    let scene = grains(1.0, 1.0, Smooth, down(0.0));
    let mut engine =
        EventDrivenEngine::<_>::between(scene, DissipationRule::Scene, state, &boundaries)
            .expect("an engine");
    engine.advance(2.5, u64::MAX, &mut ()).expect("a contact");
    let body = engine.state().bodies[0];
    assert_eq!(body.velocity, vector![-1.0, 0.0]);
    assert!((body.position - vector![6.5, 5.0]).norm() < 1e-15);
    assert_eq!(engine.ledgers()[4].contacts, 1.0);
    assert_eq!(engine.ledgers()[4].momentum, vector![-2.0, 0.0]);
    // Disk inside the disk, across the boundary.
    let inside = alone(&boundaries, [8.0, 8.0], [7.8, 5.0], [1.0, 0.0]);
    let scene = grains(1.0, 1.0, Smooth, down(0.0));
    let error =
        EventDrivenEngine::<_>::between(scene, DissipationRule::Scene, inside, &boundaries).err();
    let error = error.expect("an overlap").to_string();
    assert!(
        error.contains("disk 0") && error.contains("obstacle 0"),
        "{error}"
    );
}

/// A thin plate across the box parts it in two, for disks of any energy: none gets through, in 1e5
/// contacts.
#[test]
fn nothing_goes_through_a_thin_plate() {
    let mut boundaries = closed();
    boundaries.obstacles.push(obstacle(ObstacleShape::Polyline {
        points: vec![
            vector![0.0, 5.0],
            vector![4.0, 6.0],
            vector![8.0, 4.5],
            vector![16.0, 5.0],
        ],
    }));
    for weight in [0.0, 0.3] {
        let scene = grains(1.0, 1.0, rough(1.0), down(weight));
        let state = gas(&scene, &boundaries, [16.0, 10.0], 50, 2);
        let height = |at: &Vector2<f64>| {
            let ends = [[0.0, 5.0], [4.0, 6.0], [8.0, 4.5], [16.0, 5.0]];
            let piece = ends
                .windows(2)
                .find(|ends| at[0] <= ends[1][0])
                .expect("in the box");
            let share = (at[0] - piece[0][0]) / (piece[1][0] - piece[0][0]);
            at[1] - piece[0][1] - share * (piece[1][1] - piece[0][1])
        };
        let above: Vec<bool> = state
            .bodies
            .iter()
            .map(|body| height(&body.position) > 0.0)
            .collect();
        assert!(above.contains(&true) && above.contains(&false));
        let mut engine =
            EventDrivenEngine::<_>::between(scene, DissipationRule::Scene, state, &boundaries)
                .expect("an engine");
        for _ in 0..20 {
            engine
                .advance(f64::INFINITY, 10_000, &mut ())
                .expect("contacts");
            assert!(engine.worst_overlap() < 1e-12);
        }
        let state = engine.state();
        for (body, &above) in state.bodies.iter().zip(&above) {
            assert_eq!(height(&body.position) > 0.0, above);
        }
        assert!(engine.ledgers()[4].contacts > 10_000.0);
    }
}

/// A disk in a wedge of two plates under gravity comes to rest between them, touching both, in the
/// TC model, where that is wide; its place is that of the circle between the two lines. In one of a
/// degree it takes longer, but not for ever.
#[test]
fn a_disk_rests_in_a_wedge() {
    for half in [0.5_f64, 30.0, 60.0] {
        let angle = half.to_radians();
        let mut boundaries = DiskBoundaries::periodic();
        let law = bounces(0.6, 1.0).rebound;
        let tip = vector![100.0, 1.0];
        let side = |sign: f64| tip + vector![sign * angle.sin(), angle.cos()] * 90.0;
        let wedge = ObstacleShape::Polyline {
            points: vec![side(-1.0), tip, side(1.0)],
        };
        boundaries
            .obstacles
            .push(Obstacle::new(wedge, law).expect("a wedge"));
        let rest = 1.0 + 0.5 / angle.sin();
        let state = alone(
            &boundaries,
            [200.0, 100.0],
            [100.002, rest + 0.5],
            [0.0, 0.0],
        );
        let scene = grains(1.0, 0.6, Smooth, down(1.0));
        let mut engine = EventDrivenEngine::<_>::between(
            scene,
            DissipationRule::ContactTime(1e-5),
            state,
            &boundaries,
        )
        .expect("an engine");
        engine.advance(20.0, 1, &mut ()).expect("rest");
        let body = engine.state().bodies[0];
        println!(
            "{half}: {:?} {rest} {:?}",
            body.position.as_slice(),
            engine.tally()
        );
        assert!(engine.worst_overlap() < 1e-12);
        assert!(engine.tally().rebounds < 10_000_000);
        if half < 1.0 {
            // The disk meets the plates within a contact time, and is sent up again with little
            // loss.
            assert!(body.position[1] - rest < 0.45 && body.position[1] > rest - 1e-9);
        } else {
            // Without friction the disk continues to swing a little.
            let hop = 1e-2;
            assert!(
                (body.position[1] - rest).abs() < hop && (body.position[0] - 100.0).abs() < hop
            );
        }
    }
}

/// Diffuse obstacles heat a gas to their temperature.
#[test]
fn a_diffuse_obstacle_heats_the_gas() {
    let mut boundaries = DiskBoundaries::periodic();
    let outline = ObstacleShape::Polygon {
        points: vec![vector![4.0, 4.0], vector![8.0, 4.0], vector![6.0, 8.0]],
    };
    let hot = Rebound::Diffuse { temperature: 2.0 };
    boundaries
        .obstacles
        .push(Obstacle::new(outline, hot).expect("an obstacle"));
    let scene = disks(1.0);
    let state = gas(&scene, &boundaries, [14.0, 14.0], 60, 3);
    let mut engine =
        EventDrivenEngine::<_>::between(scene.clone(), DissipationRule::Scene, state, &boundaries)
            .expect("an engine");
    engine.advance(200.0, u64::MAX, &mut ()).expect("contacts");
    let mut parts = Vec::new();
    for _ in 0..20 {
        let mut sum = 0.0;
        for _ in 0..100 {
            engine
                .advance(engine.time() + 1.0, u64::MAX, &mut ())
                .expect("contacts");
            sum += engine.state().temperature(&scene) / 100.0;
        }
        parts.push(sum);
    }
    let mean = parts.iter().sum::<f64>() / 20.0;
    let variance = parts.iter().map(|part| (part - mean).powi(2)).sum::<f64>() / 19.0;
    let error = (variance / 20.0).sqrt();
    println!("{mean:.4} +- {error:.4}");
    assert!(error < 0.03 && (mean - 2.0).abs() < 4.4 * error);
}

/// Disks of very different sizes, in several grids, between walls, around obstacles and under
/// gravity have the contacts of all pairs.
#[test]
fn very_unequal_disks_find_their_boundaries() {
    let small = |disk: i32| (0.05 + 0.001 * f64::from(disk % 10), 0.1, 1);
    let sizes = species([(1.5, 9.0, 4)].into_iter().chain((4..150).map(small)));
    for weight in [0.0, 0.5] {
        let scene = Scene::new(rough(0.5), law(0.95), sizes.clone(), down(weight));
        for axes in [
            [Some([Wall::specular(); 2]), Some([bounces(0.9, 0.5); 2])],
            [None, Some([bounces(0.9, 0.5); 2])],
            [None, None],
        ] {
            let mut boundaries = walled(axes);
            boundaries.obstacles.push(obstacle(ObstacleShape::Polygon {
                points: vec![vector![4.0, 0.0], vector![6.0, 0.0], vector![5.0, 2.0]],
            }));
            boundaries.obstacles.push(obstacle(ObstacleShape::Circle {
                centre: vector![0.5, 6.0],
                radius: 0.5,
            }));
            let start = gas(&scene, &boundaries, [12.0, 12.0], 150, 5);
            let rebounds = follow_plain(&scene, &boundaries, &start, 250);
            assert!(rebounds > 10, "{rebounds}");
        }
    }
}
