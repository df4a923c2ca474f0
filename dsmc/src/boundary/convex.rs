//! Convex polygons in the plane: clipping by a line, area and centroid, convex hull.

use nalgebra::Vector2;

type Point = Vector2<f64>;

/// Directed straight line that divides the plane: points of non-negative `height` are in front of
/// it.
#[derive(Clone, Copy, Debug)]
pub(super) struct CutLine {
    point: Point,
    normal: Point,
}

impl CutLine {
    /// Creates the line through two points; its front side is on the left, seen from the first to
    /// the second.
    pub(super) fn through([from, to]: [Point; 2]) -> Self {
        let along = (to - from).normalize();
        Self {
            point: from,
            normal: Point::new(-along[1], along[0]),
        }
    }

    /// Creates the line through a point; its front side is in the direction of the unit vector
    /// `normal`.
    pub(super) fn facing(point: Point, normal: Point) -> Self {
        Self { point, normal }
    }

    /// Returns the signed distance of a point from the line \[length\]; negative behind it.
    #[inline]
    pub(super) fn height(&self, point: Point) -> f64 {
        (point - self.point).dot(&self.normal)
    }

    /// Returns the dividing line with its front and back sides exchanged.
    fn reversed(&self) -> Self {
        Self::facing(self.point, -self.normal)
    }
}

/// Convex polygon, as corners in counter-clockwise order. With fewer than three corners its area is
/// zero.
#[derive(Clone, Debug, Default)]
pub(super) struct ConvexPolygon(Vec<Point>);

impl ConvexPolygon {
    /// Creates the rectangle with sides along the axes between its lower left and upper right
    /// corner.
    pub(super) fn rectangle(low: Point, high: Point) -> Self {
        Self(vec![
            low,
            Point::new(high[0], low[1]),
            high,
            Point::new(low[0], high[1]),
        ])
    }

    /// Creates the convex hull of points.
    pub(super) fn hull(points: &[Point]) -> Self {
        let mut sorted = points.to_vec();
        sorted.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
        let half = |points: &mut dyn Iterator<Item = &Point>| {
            let mut chain: Vec<Point> = Vec::new();
            for &point in points {
                while let [.., a, b] = chain[..]
                    && (b - a).perp(&(point - a)) <= 0.0
                {
                    chain.pop();
                }
                chain.push(point);
            }
            chain.pop();
            chain
        };
        let mut corners = half(&mut sorted.iter());
        corners.extend(half(&mut sorted.iter().rev()));
        Self(corners)
    }

    /// Returns the corners of the polygon in counter-clockwise order.
    pub(super) fn corners(&self) -> &[Point] {
        &self.0
    }

    /// Returns the sides of the polygon, each as its first and its last corner.
    fn sides(&self) -> impl Iterator<Item = [Point; 2]> + '_ {
        let next = self.0.iter().cycle().skip(1);
        self.0.iter().zip(next).map(|(&from, &to)| [from, to])
    }

    /// Returns the part of the polygon in front of a line.
    pub(super) fn in_front_of(&self, line: &CutLine) -> Self {
        let mut corners = Vec::with_capacity(self.0.len() + 1);
        for [from, to] in self.sides() {
            let [here, there] = [from, to].map(|point| line.height(point));
            if here >= 0.0 {
                corners.push(from);
            }
            if (here < 0.0) != (there < 0.0) {
                corners.push(from + (to - from) * (here / (here - there)));
            }
        }
        if corners.len() < 3 {
            corners.clear();
        }
        Self(corners)
    }

    /// Cuts the polygon at a line: returns the parts behind it and in front of it.
    pub(super) fn cut(&self, line: &CutLine) -> [Self; 2] {
        [self.in_front_of(&line.reversed()), self.in_front_of(line)]
    }

    /// Returns the area \[length^2\] and the centroid of the polygon.
    pub(super) fn area_and_centroid(&self) -> (f64, Point) {
        let Some(&origin) = self.0.first() else {
            return (0.0, Point::zeros());
        };
        let (mut twice, mut moment) = (0.0, Point::zeros());
        for [from, to] in self.sides().map(|ends| ends.map(|end| end - origin)) {
            let triangle = from.perp(&to);
            twice += triangle;
            moment += (from + to) * triangle;
        }
        if twice <= 0.0 {
            return (0.0, origin);
        }
        (0.5 * twice, origin + moment / (3.0 * twice))
    }

    /// Returns the largest distance of a corner of the polygon from a point \[length\].
    pub(super) fn radius_around(&self, point: Point) -> f64 {
        let distances = self.0.iter().map(|corner| (corner - point).norm());
        distances.fold(0.0, f64::max)
    }

    /// Returns the length of the part of a segment that is inside the polygon and farther than
    /// `margin` from its sides \[length\].
    pub(super) fn length_inside(&self, [from, to]: [Point; 2], margin: f64) -> f64 {
        let (mut begin, mut end) = (0.0_f64, 1.0_f64);
        for side in self.sides() {
            if side[0] == side[1] {
                continue;
            }
            let line = CutLine::through(side);
            let [here, there] = [from, to].map(|point| line.height(point) - margin);
            match (here > 0.0, there > 0.0) {
                (false, false) => return 0.0,
                (true, true) => {}
                (true, false) => end = end.min(here / (here - there)),
                (false, true) => begin = begin.max(here / (here - there)),
            }
        }
        (end - begin).max(0.0) * (to - from).norm()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::vector;

    /// Checks corners and areas against values computed by hand.
    #[test]
    fn a_rectangle_is_cut_into_two_parts() {
        let all = ConvexPolygon::rectangle(vector![1.0, 2.0], vector![3.0, 3.0]);
        let line = CutLine::through([vector![1.0, 2.0], vector![3.0, 3.0]]);
        let [behind, front] = all.cut(&line).map(|part| part.area_and_centroid());
        assert!((behind.0 - 1.0).abs() < 1e-15 && (front.0 - 1.0).abs() < 1e-15);
        assert!((front.1 - vector![5.0 / 3.0, 8.0 / 3.0]).norm() < 1e-15);
        assert!(line.height(front.1) > 0.0 && line.height(behind.1) < 0.0);
        let beyond = CutLine::facing(vector![4.0, 0.0], vector![1.0, 0.0]);
        assert!(all.in_front_of(&beyond).corners().is_empty());
        assert_eq!(all.cut(&beyond)[0].area_and_centroid().0, 2.0);
    }

    #[test]
    fn a_hull_holds_all_points() {
        let square = [[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]];
        let inside = [[1.0, 1.0], [0.5, 1.5], [1.0, 0.0]];
        let points: Vec<Point> = (inside.iter().chain(&square))
            .map(|&at| at.into())
            .collect();
        let hull = ConvexPolygon::hull(&points);
        assert_eq!((hull.corners().len(), hull.area_and_centroid().0), (4, 4.0));
        assert_eq!(hull.radius_around(vector![0.0, 0.0]), 8.0_f64.sqrt());
        // Half of the segment is inside, none along a side, and a quarter deeper than 0.5.
        let segment = [vector![1.0, 1.0], vector![1.0, 3.0]];
        assert_eq!(hull.length_inside(segment, 0.0), 1.0);
        assert_eq!(hull.length_inside(segment, 0.5), 0.5);
        let side = [vector![0.0, 0.0], vector![2.0, 0.0]];
        assert_eq!(hull.length_inside(side, 1e-12), 0.0);
    }
}
