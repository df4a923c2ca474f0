//! The engine against its oracle: rough disks, walls, gravity and obstacles, alone and together.

use nalgebra::vector;
use stosszahl_ed::DiskBoundaries;
use stosszahl_model::samples::{disks, grains};
use stosszahl_model::walls::{ObstacleShape, Wall};
use stosszahl_model::{Rebound, Smooth};

use crate::support::{bounces, closed, down, follow_plain, gas, obstacle, rough, vibrates, walled};

#[test]
fn rough_disks() {
    for (tangential, restitution) in [(1.0, 1.0), (0.3, 0.8), (-0.5, 0.9)] {
        let scene = grains(1.0, restitution, rough(tangential), down(0.0));
        let boundaries = DiskBoundaries::periodic();
        let start = gas(&scene, &boundaries, [12.0, 10.0], 50, 1);
        follow_plain(&scene, &boundaries, &start, 150);
    }
}

/// Specular, restitutive with slip, sliding, diffuse and vibrating walls, and slits with one disk
/// or cell across.
#[test]
fn walls() {
    let sliding = Wall {
        sliding: vector![0.7, 0.0],
        ..bounces(0.9, 0.2)
    };
    let diffuse = Wall::still(Rebound::Diffuse { temperature: 2.0 });
    let floor = vibrates(bounces(0.8, 0.5), 0.4, 0.9);
    let all = [
        (closed(), [9.0, 8.0], 30),
        (
            walled([None, Some([sliding, bounces(0.7, -1.0)])]),
            [9.0, 8.0],
            30,
        ),
        (walled([Some([diffuse, diffuse]), None]), [9.0, 8.0], 30),
        (
            walled([None, Some([floor, vibrates(diffuse, 0.7, 0.25)])]),
            [9.0, 8.0],
            25,
        ),
        (
            walled([Some([floor, floor]), Some([floor, floor])]),
            [9.0, 8.0],
            20,
        ),
        (walled([None, Some([sliding, sliding])]), [30.0, 1.05], 12),
        (walled([None, Some([floor, diffuse])]), [30.0, 2.2], 14),
        (closed(), [3.0, 2.5], 2),
    ];
    for (number, (boundaries, lengths, count)) in all.into_iter().enumerate() {
        let scene = disks(0.9);
        let start = gas(&scene, &boundaries, lengths, count, number as u64);
        let rebounds = follow_plain(&scene, &boundaries, &start, 5 * count);
        assert!(rebounds > count / 3, "{rebounds} rebounds");
        let scene = grains(1.0, 0.9, rough(0.5), down(0.0));
        let start = gas(&scene, &boundaries, lengths, count, number as u64);
        follow_plain(&scene, &boundaries, &start, 5 * count);
    }
}

#[test]
fn gravity() {
    let floor = vibrates(bounces(0.8, 0.5), 0.4, 0.9);
    let diffuse = Wall::still(Rebound::Diffuse { temperature: 2.0 });
    let all = [
        (DiskBoundaries::periodic(), 30),
        (closed(), 30),
        (walled([None, Some([floor, Wall::specular()])]), 25),
        (walled([Some([diffuse, floor]), Some([floor, diffuse])]), 25),
    ];
    for (number, (boundaries, count)) in all.into_iter().enumerate() {
        for weight in [1e-3, 1.0, -2.0] {
            let scene = grains(1.0, 0.9, Smooth, down(weight));
            let start = gas(&scene, &boundaries, [9.0, 8.0], count, number as u64);
            follow_plain(&scene, &boundaries, &start, 5 * count);
            let scene = grains(1.0, 0.9, rough(0.5), down(weight));
            let start = gas(&scene, &boundaries, [9.0, 8.0], count, number as u64);
            follow_plain(&scene, &boundaries, &start, 5 * count);
        }
    }
}

/// Discs, thin plates and solids, some of which reach to the edges of the box, with and without
/// gravity and walls.
#[test]
fn obstacles() {
    let all = vec![
        obstacle(ObstacleShape::Circle {
            centre: vector![2.0, 5.0],
            radius: 1.5,
        }),
        obstacle(ObstacleShape::Segment {
            ends: [vector![0.0, 9.0], vector![4.0, 8.0]],
        }),
        obstacle(ObstacleShape::Polyline {
            points: vec![
                vector![6.0, 2.0],
                vector![8.0, 4.0],
                vector![10.0, 2.0],
                vector![12.0, 3.0],
            ],
        }),
        obstacle(ObstacleShape::Polygon {
            points: vec![
                vector![7.0, 7.0],
                vector![11.0, 8.0],
                vector![8.0, 9.0],
                vector![8.0, 8.0],
            ],
        }),
    ];
    for mut boundaries in [DiskBoundaries::periodic(), closed()] {
        boundaries.obstacles.clone_from(&all);
        let scene = disks(0.9);
        let start = gas(&scene, &boundaries, [12.0, 11.0], 30, 3);
        let rebounds = follow_plain(&scene, &boundaries, &start, 150);
        assert!(rebounds > 40, "{rebounds} rebounds");
        for weight in [0.01, 1.0] {
            let scene = grains(1.0, 0.9, rough(0.2), down(weight));
            let start = gas(&scene, &boundaries, [12.0, 11.0], 30, 3);
            let rebounds = follow_plain(&scene, &boundaries, &start, 150);
            assert!(rebounds > 40, "{rebounds} rebounds");
        }
    }
}
