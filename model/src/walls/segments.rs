//! Distance of straight segments in the plane.

use nalgebra::Vector2;

/// Returns a point of the first segment that is at most `margin` \[length\] away from the second;
/// `None` if they are farther apart. Segments are given by their ends.
pub(super) fn place_of_touch(
    first: [Vector2<f64>; 2],
    second: [Vector2<f64>; 2],
    margin: f64,
) -> Option<Vector2<f64>> {
    // Sides of one segment on which the ends of the other are.
    let sides = |[from, to]: [Vector2<f64>; 2], ends: [Vector2<f64>; 2]| {
        ends.map(|end| (to - from).perp(&(end - from)))
    };
    let differ =
        |sides: [f64; 2]| (sides[0] > 0.0 && sides[1] < 0.0) || (sides[0] < 0.0 && sides[1] > 0.0);
    let ends = sides(second, first);
    if differ(ends) && differ(sides(first, second)) {
        let share = ends[0] / (ends[0] - ends[1]);
        return Some(first[0] + (first[1] - first[0]) * share);
    }
    // Segments that do not cross are closest at an end.
    let of_first = first.map(|end| (end, nearest(second, end)));
    let of_second = second.map(|end| (nearest(first, end), end));
    let pairs = of_first.into_iter().chain(of_second);
    let apart = pairs.map(|(here, there)| ((here - there).norm(), here));
    let closest = apart.min_by(|a, b| a.0.total_cmp(&b.0));
    closest.and_then(|(distance, place)| (distance <= margin).then_some(place))
}

/// Returns the point of a segment that is closest to a point.
fn nearest([from, to]: [Vector2<f64>; 2], point: Vector2<f64>) -> Vector2<f64> {
    let along = to - from;
    let length = along.norm();
    if length <= 0.0 {
        return from;
    }
    // By the unit vector: a square could overflow.
    let unit = along / length;
    let way = (point - from).dot(&unit);
    if way >= length {
        to
    } else {
        from + unit * way.max(0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::vector;
    use parry2d_f64::math::{Pose, Vector};
    use parry2d_f64::query::{ClosestPoints, details::closest_points_segment_segment};
    use parry2d_f64::shape::Segment;
    use rand::{RngExt, SeedableRng};

    /// Against parry, an independent implementation, on random segments and on a grid, where many
    /// touch, are parallel or share an end. Distances that are the margin up to rounding are left
    /// out.
    #[test]
    fn segments_touch_when_parry_says() {
        let mut stream = crate::random::Stream::seed_from_u64(3);
        let mut counts = [0; 2];
        for round in 0..20_000 {
            let mut number = || {
                let number: f64 = stream.random_range(-3.0..3.0);
                if round % 2 == 0 {
                    number
                } else {
                    number.round()
                }
            };
            let mut point = || vector![number(), number()];
            let (first, second) = ([point(), point()], [point(), point()]);
            let margin = stream.random_range(0.0..0.5);
            let theirs = |margin: f64| {
                let segment = |ends: [Vector2<f64>; 2]| {
                    let [from, to] = ends.map(|end| Vector::new(end[0], end[1]));
                    Segment::new(from, to)
                };
                let pose = Pose::identity();
                let (one, other) = (segment(first), segment(second));
                match closest_points_segment_segment(&pose, &one, &other, margin) {
                    ClosestPoints::WithinMargin(..) | ClosestPoints::Intersecting => true,
                    ClosestPoints::Disjoint => false,
                }
            };
            let expected = theirs(margin + 1e-9);
            if expected != theirs(margin - 1e-9) {
                continue;
            }
            let ours = place_of_touch(first, second, margin);
            assert_eq!(ours.is_some(), expected, "{first:?} {second:?} {margin}");
            counts[usize::from(expected)] += 1;
            if let Some(place) = ours {
                assert!((place - nearest(first, place)).norm() < 1e-12);
                assert!((place - nearest(second, place)).norm() < margin + 1e-12);
            }
        }
        assert!(counts[0] > 1000 && counts[1] > 1000, "{counts:?}");
    }
}
