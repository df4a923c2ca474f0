//! Search for overlapping disks in an initial state, by bounding-volume hierarchies of the library
//! `parry`.

use nalgebra::Vector2;
use parry2d_f64::bounding_volume::{Aabb, BoundingVolume};
use parry2d_f64::math::{Pose, Vector};
use parry2d_f64::partitioning::{Bvh, BvhBuildStrategy, BvhNode};
use parry2d_f64::query::details::contact_ball_ball;
use parry2d_f64::shape::Ball;

use crate::domain::Domain;
use crate::space::Plane;

/// Pair of disks that overlap, with the depth of the overlap.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Overlap {
    /// Indices of the two disks, the smaller first; equal where a disk overlaps its own periodic
    /// image.
    pub pair: [usize; 2],
    /// Depth of the overlap of the two disks \[length\].
    pub depth: f64,
}

/// Returns the overlapping pair of disks with the smallest indices, if any overlaps by more than
/// `tolerance` \[length\].
///
/// A bounding-volume hierarchy over all disks is compared with itself and with each periodic image
/// that reaches into the box, along the axes that are periodic; the distance of a candidate pair is
/// parry's ball-ball contact, a closed form. Cost N log N for any mixture of sizes.
pub fn first_overlap(
    positions: &[Vector2<f64>],
    radius: impl Fn(usize) -> f64,
    domain: &Domain<Plane>,
    tolerance: f64,
) -> Option<Overlap> {
    let around = |centre: Vector2<f64>, radius: f64| {
        let reach = Vector::new(radius, radius);
        let centre: Vector = centre.into();
        Aabb::new(centre - reach, centre + reach)
    };
    let leaves: Vec<Aabb> = positions
        .iter()
        .enumerate()
        .map(|(index, &centre)| around(centre, radius(index)))
        .collect();
    let tree = Bvh::from_leaves(BvhBuildStrategy::Binned, &leaves);
    let all = tree.root_aabb();
    let depth = |first: usize, shifted: Vector2<f64>, second: usize| {
        let between: Vector = (positions[second] - shifted).into();
        let contact = contact_ball_ball(
            &Pose::from_translation(between),
            &Ball::new(radius(first)),
            &Ball::new(radius(second)),
            0.0,
        );
        contact.map_or(0.0, |contact| -contact.dist)
    };
    let shifts = [0, 1].map(|axis| {
        if domain.is_periodic(axis) {
            &[-1.0, 0.0, 1.0][..]
        } else {
            &[0.0]
        }
    });
    // Fast test of the tree against itself, which only says whether there is an overlap; nearly
    // always there is none.
    let meets = |one: &BvhNode, other: &BvhNode| one.intersects(other);
    let is_inside = tree.leaf_pairs(&tree, meets).any(|(first, second)| {
        let [first, second] = [first, second].map(|leaf| leaf as usize);
        first < second && depth(first, positions[first], second) > tolerance
    });
    let mut found: Option<Overlap> = None;
    for (first, &centre) in positions.iter().enumerate() {
        // Pairs are seen from both sides, so the smallest first index comes first.
        if found.is_some() {
            break;
        }
        let own = radius(first);
        // Images beyond one box length, needed only for disks wider than the box.
        for &shift_x in shifts[0] {
            for &shift_y in shifts[1] {
                let shifted = centre + domain.images().image([shift_x, shift_y, 0.0]).position;
                let image = shift_x != 0.0 || shift_y != 0.0;
                if !image && !is_inside {
                    continue;
                }
                let bounds = around(shifted, own);
                if !all.intersects(&bounds) {
                    continue;
                }
                for candidate in tree.intersect_aabb(&bounds) {
                    let second = candidate as usize;
                    if second < first || (second == first && !image) {
                        continue;
                    }
                    let depth = depth(first, shifted, second);
                    if depth > tolerance && found.is_none_or(|known| second < known.pair[1]) {
                        found = Some(Overlap {
                            pair: [first, second],
                            depth,
                        });
                    }
                }
            }
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::vector;
    use rand::{RngExt, SeedableRng};

    /// parry and the hierarchy against all pairs on random disks of unequal size.
    #[test]
    fn agrees_with_all_pairs() {
        let mut stream = crate::random::Stream::seed_from_u64(5);
        let domain = Domain::<Plane>::periodic(vector![10.0, 7.0]).expect("positive");
        let mut with_overlap = 0;
        for _ in 0..300 {
            let count = stream.random_range(1..12_usize);
            let positions: Vec<_> = (0..count)
                .map(|_| vector![10.0 * stream.random::<f64>(), 7.0 * stream.random::<f64>()])
                .collect();
            let radii: Vec<f64> = (0..count)
                .map(|_| 0.1 + 0.9 * stream.random::<f64>())
                .collect();
            let plain = (0..count)
                .flat_map(|i| (i + 1..count).map(move |j| [i, j]))
                .find(|&[i, j]| domain.distance(positions[i], positions[j]) < radii[i] + radii[j]);
            let found = first_overlap(&positions, |i| radii[i], &domain, 0.0);
            assert_eq!(found.map(|overlap| overlap.pair), plain);
            with_overlap += usize::from(plain.is_some());
        }
        assert!(
            (50..250).contains(&with_overlap),
            "{with_overlap} of 300 overlap"
        );
    }

    #[test]
    fn contact_is_no_overlap_and_own_image_is() {
        let domain = Domain::<Plane>::periodic(vector![4.0, 4.0]).expect("positive");
        assert_eq!(
            first_overlap(
                &[vector![1.0, 1.0], vector![2.0, 1.0]],
                |_| 0.5,
                &domain,
                1e-12
            ),
            None
        );
        let across = first_overlap(
            &[vector![0.2, 1.0], vector![3.4, 1.0]],
            |_| 0.5,
            &domain,
            1e-12,
        );
        let across = across.expect("an overlap across the boundary");
        assert_eq!(across.pair, [0, 1]);
        assert!((across.depth - 0.2).abs() < 1e-14);
        let own =
            first_overlap(&[vector![0.5, 0.5]], |_| 2.5, &domain, 1e-12).expect("its own image");
        assert_eq!(own.pair, [0, 0]);
    }
}
