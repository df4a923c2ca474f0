//! Free area: the part of a rectangle in which the centres of particles can be next to obstacles,
//! by numerical integration.
//!
//! The centre of a particle keeps a clearance from an obstacle, so each obstacle takes the area of
//! its shape, grown by that clearance: disks of a larger radius, solids with a strip along each
//! edge and a disk at each corner. Along a line across the rectangle the union of all of them is a
//! set of intervals in closed form. Their length is integrated along the rectangle, piece by piece
//! between all ends of shapes, by Gauss's rule with eight points, which is halved until it no
//! longer changes.

use nalgebra::{Vector2, vector};

use super::feature::{Feature, Round};
use super::obstacle::{Obstacle, ObstacleShape};

/// Largest error of one piece of the integral of the free area, over the area of the rectangle.
const TOLERANCE: f64 = 1e-10;
/// Largest number of halvings of an interval of integration.
const HALVINGS: u32 = 24;
/// Largest number of shapes that are integrated at once; a rectangle with more is divided, so that
/// the time grows with their number.
const MOST_SHAPES: usize = 12;
/// Largest number of successive divisions of a rectangle.
const DIVISIONS: u32 = 40;
/// Positive nodes and weights of Gauss's rule with eight points on \[-1, 1\].
const GAUSS: [[f64; 2]; 4] = [
    [0.183_434_642_495_649_8, 0.362_683_783_378_362],
    [0.525_532_409_916_329, 0.313_706_645_877_887_3],
    [0.796_666_477_413_626_7, 0.222_381_034_453_374_5],
    [0.960_289_856_497_536_3, 0.101_228_536_290_376_3],
];

/// Area that obstacles in a box leave to the centres of particles that keep a clearance from them.
///
/// ```
/// use nalgebra::vector;
/// use stosszahl_model::walls::{FreeArea, Obstacle, ObstacleShape, Rebound};
/// let law = Rebound::Restitutive { restitution: 1.0, slip: 1.0 };
/// let disk = Obstacle::new(ObstacleShape::Circle { centre: vector![2.0, 2.0], radius: 0.5 }, law)?;
/// let area = FreeArea::new(&[disk], [4.0, 4.0], [true, true], 0.5);
/// assert!((area.rectangle_between([0.0, 0.0], [4.0, 4.0]) - (16.0 - std::f64::consts::PI)).abs() < 1e-9);
/// # Ok::<(), stosszahl_model::walls::ObstacleError>(())
/// ```
#[derive(Clone, Debug)]
pub struct FreeArea {
    shapes: Vec<Shape>,
}

impl FreeArea {
    /// Creates the free area of a box of the given sides \[length\] with obstacles, for centres
    /// that stay `clearance` away from them \[length\]. Periodic images of obstacles count too.
    pub fn new(
        obstacles: &[Obstacle],
        lengths: [f64; 2],
        periodic: [bool; 2],
        clearance: f64,
    ) -> Self {
        let steps = |axis: usize| if periodic[axis] { -1..=1 } else { 0..=0 };
        let own: Vec<Shape> = (obstacles.iter())
            .flat_map(|obstacle| Shape::grown_parts(obstacle, clearance))
            .collect();
        let mut shapes = Vec::new();
        for x in steps(0) {
            for y in steps(1) {
                let by = vector![f64::from(x) * lengths[0], f64::from(y) * lengths[1]];
                let images = own.iter().map(|shape| shape.moved(by));
                shapes.extend(images.filter(|shape| shape.meets([0.0, 0.0], lengths)));
            }
        }
        Self { shapes }
    }

    /// Computes the free area of the rectangle between its lower left and its upper right corner
    /// \[length^2\].
    pub fn rectangle_between(&self, low: [f64; 2], high: [f64; 2]) -> f64 {
        let shapes: Vec<&Shape> = self.shapes.iter().collect();
        free(&shapes, low, high, DIVISIONS)
    }
}

/// Disk or polygon, as part of an obstacle that is grown by the clearance.
#[derive(Clone, Debug)]
enum Shape {
    Circle {
        centre: Vector2<f64>,
        radius: f64,
    },
    /// Polygon; a point is inside by the even-odd rule.
    Solid(Vec<Vector2<f64>>),
}

impl Shape {
    /// Returns the parts of an obstacle that is grown by a clearance \[length\]: its solid, strips
    /// along edges, and disks at corners.
    fn grown_parts(obstacle: &Obstacle, clearance: f64) -> Vec<Self> {
        let mut parts = Vec::new();
        if let ObstacleShape::Polygon { points } = obstacle.outline() {
            parts.push(Self::Solid(points.clone()));
        }
        for feature in obstacle.features() {
            match feature {
                Feature::Round(Round { centre, radius }) if radius + clearance > 0.0 => {
                    parts.push(Self::Circle {
                        centre: *centre,
                        radius: radius + clearance,
                    });
                }
                Feature::Edge(edge) if clearance > 0.0 => {
                    let [from, to] = [edge.from, edge.from + edge.along * edge.length];
                    let aside = vector![-edge.along.y, edge.along.x] * clearance;
                    let strip = vec![from - aside, to - aside, to + aside, from + aside];
                    parts.push(Self::Solid(strip));
                }
                _ => {}
            }
        }
        parts
    }

    fn moved(&self, by: Vector2<f64>) -> Self {
        match self {
            Self::Circle { centre, radius } => Self::Circle {
                centre: centre + by,
                radius: *radius,
            },
            Self::Solid(points) => Self::Solid(points.iter().map(|point| point + by).collect()),
        }
    }

    /// Returns true if the bounding box of the shape overlaps the rectangle between two corners.
    fn meets(&self, low: [f64; 2], high: [f64; 2]) -> bool {
        let overlaps = |axis: usize| {
            let (least, most) = match self {
                Self::Circle { centre, radius } => (centre[axis] - radius, centre[axis] + radius),
                Self::Solid(points) => points
                    .iter()
                    .map(|point| point[axis])
                    .fold((f64::INFINITY, f64::NEG_INFINITY), |(least, most), x| {
                        (least.min(x), most.max(x))
                    }),
            };
            least < high[axis] && most > low[axis]
        };
        overlaps(0) && overlaps(1)
    }

    /// Adds the positions along the first axis at which the shape begins or ends, has a corner, or
    /// crosses one of two heights: there the integrand is not smooth.
    fn add_stops(&self, heights: [f64; 2], stops: &mut Vec<f64>) {
        match self {
            Self::Circle { centre, radius } => {
                stops.extend([centre.x - radius, centre.x + radius]);
                for height in heights {
                    let half = (radius.powi(2) - (height - centre.y).powi(2)).sqrt();
                    if half > 0.0 {
                        stops.extend([centre.x - half, centre.x + half]);
                    }
                }
            }
            Self::Solid(points) => {
                for (a, b) in polygon_sides(points) {
                    stops.push(a.x);
                    let crossed = heights.map(|y| a.x + (b.x - a.x) * (y - a.y) / (b.y - a.y));
                    stops.extend(crossed.into_iter().filter(|x| x.is_finite()));
                }
            }
        }
    }

    /// Adds the intervals along the second axis that the shape covers at a position along the
    /// first.
    fn add_intervals(&self, x: f64, intervals: &mut Vec<[f64; 2]>) {
        match self {
            Self::Circle { centre, radius } => {
                let half = (radius.powi(2) - (x - centre.x).powi(2)).sqrt();
                if half > 0.0 {
                    intervals.push([centre.y - half, centre.y + half]);
                }
            }
            Self::Solid(points) => {
                let crosses = |(a, b): &(Vector2<f64>, Vector2<f64>)| (a.x <= x) != (b.x <= x);
                let height = |(a, b): (Vector2<f64>, Vector2<f64>)| {
                    a.y + (b.y - a.y) * (x - a.x) / (b.x - a.x)
                };
                let mut heights: Vec<f64> =
                    polygon_sides(points).filter(crosses).map(height).collect();
                heights.sort_by(f64::total_cmp);
                intervals.extend(heights.chunks_exact(2).map(|pair| [pair[0], pair[1]]));
            }
        }
    }
}

/// Returns the sides of a polygon, each as its first and its last corner.
fn polygon_sides(
    points: &[Vector2<f64>],
) -> impl Iterator<Item = (Vector2<f64>, Vector2<f64>)> + '_ {
    let next = points.iter().cycle().skip(1);
    points.iter().zip(next).map(|(a, b)| (*a, *b))
}

/// Computes the free area of a rectangle between shapes \[length^2\]; `divisions` limits its
/// further divisions.
fn free(shapes: &[&Shape], low: [f64; 2], high: [f64; 2], divisions: u32) -> f64 {
    let [width, height] = [high[0] - low[0], high[1] - low[1]];
    if width <= 0.0 || height <= 0.0 {
        return 0.0;
    }
    let near: Vec<&Shape> = (shapes.iter().copied())
        .filter(|shape| shape.meets(low, high))
        .collect();
    if near.is_empty() {
        return width * height;
    }
    if near.len() > MOST_SHAPES && divisions > 0 {
        let axis = usize::from(height > width);
        let (mut end, mut begin) = (high, low);
        end[axis] = 0.5 * (low[axis] + high[axis]);
        begin[axis] = end[axis];
        return free(&near, low, end, divisions - 1) + free(&near, begin, high, divisions - 1);
    }
    let line = Line {
        shapes: &near,
        low: low[1],
        high: high[1],
    };
    let mut stops = vec![low[0], high[0]];
    for shape in &near {
        shape.add_stops([low[1], high[1]], &mut stops);
    }
    stops.retain(|x| (low[0]..=high[0]).contains(x));
    stops.sort_by(f64::total_cmp);
    let pieces = stops.windows(2).filter(|ends| ends[1] > ends[0]);
    let tolerance = TOLERANCE * width * height;
    pieces
        .map(|ends| line.integral([ends[0], ends[1]], tolerance))
        .sum()
}

/// Lines across a rectangle, along the second axis, with the shapes that they may cross.
struct Line<'a> {
    shapes: &'a [&'a Shape],
    low: f64,
    high: f64,
}

impl Line<'_> {
    /// Returns the free length of the line at a position along the first axis \[length\].
    fn free(&self, x: f64) -> f64 {
        let mut intervals = Vec::with_capacity(self.shapes.len());
        for shape in self.shapes {
            shape.add_intervals(x, &mut intervals);
        }
        intervals.sort_by(|a, b| a[0].total_cmp(&b[0]));
        let (mut length, mut top) = (0.0, self.low);
        for [from, to] in intervals {
            length += (from.min(self.high) - top).max(0.0);
            top = top.max(to);
        }
        length + (self.high - top).max(0.0)
    }

    /// Integrates the free length of lines between two positions along the first axis \[length^2\].
    /// With the position as `middle - half cos(a)` the root at the end of a disk becomes smooth.
    fn integral(&self, ends: [f64; 2], tolerance: f64) -> f64 {
        let (middle, half) = (0.5 * (ends[0] + ends[1]), 0.5 * (ends[1] - ends[0]));
        let value = |angle: f64| half * angle.sin() * self.free(middle - half * angle.cos());
        let all = [0.0, std::f64::consts::PI];
        integrate_by_halves(&value, all, gauss_rule(&value, all), tolerance, HALVINGS)
    }
}

/// Integrates a function between two ends by Gauss's rule with eight points.
fn gauss_rule(value: &impl Fn(f64) -> f64, [from, to]: [f64; 2]) -> f64 {
    let (middle, half) = (0.5 * (from + to), 0.5 * (to - from));
    let pair = |[node, weight]: [f64; 2]| {
        weight * (value(middle - half * node) + value(middle + half * node))
    };
    half * GAUSS.into_iter().map(pair).sum::<f64>()
}

/// Integrates a function between two ends by repeated halving, until the halves agree with the
/// `whole` within a tolerance.
fn integrate_by_halves(
    value: &impl Fn(f64) -> f64,
    [from, to]: [f64; 2],
    whole: f64,
    tolerance: f64,
    halvings: u32,
) -> f64 {
    let middle = 0.5 * (from + to);
    let ends = [[from, middle], [middle, to]];
    let parts = ends.map(|ends| gauss_rule(value, ends));
    if (parts[0] + parts[1] - whole).abs() <= tolerance || halvings == 0 {
        return parts[0] + parts[1];
    }
    let half =
        |side: usize| integrate_by_halves(value, ends[side], parts[side], tolerance, halvings - 1);
    half(0) + half(1)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;
    use crate::walls::Rebound;
    use rand::{RngExt, SeedableRng};
    use rand_xoshiro::Xoshiro256PlusPlus;

    fn obstacle(outline: ObstacleShape) -> Obstacle {
        let law = Rebound::Restitutive {
            restitution: 1.0,
            slip: 1.0,
        };
        Obstacle::new(outline, law).expect("an obstacle")
    }

    fn disk(x: f64, y: f64, radius: f64) -> Obstacle {
        obstacle(ObstacleShape::Circle {
            centre: vector![x, y],
            radius,
        })
    }

    fn polygon(points: &[[f64; 2]]) -> Obstacle {
        obstacle(ObstacleShape::Polygon {
            points: points.iter().map(|&point| point.into()).collect(),
        })
    }

    /// Areas in closed form, each to the tolerance of some ten pieces.
    #[test]
    fn areas_are_those_of_closed_forms() {
        let whole = |obstacles: &[Obstacle], periodic, clearance| {
            let area = FreeArea::new(obstacles, [10.0, 8.0], periodic, clearance);
            80.0 - area.rectangle_between([0.0, 0.0], [10.0, 8.0])
        };
        let close = |found: f64, expected: f64| {
            assert!((found - expected).abs() < 1e-7, "{found} {expected}");
        };
        let open = [false; 2];
        close(whole(&[], open, 1.0), 0.0);
        close(whole(&[disk(4.0, 4.0, 2.0)], open, 0.5), 2.5 * 2.5 * PI);
        // Two disks of one radius that overlap have a lens in common.
        let lens = 2.0 * 4.0 * (1.0_f64 / 4.0).acos() - 0.5 * (16.0_f64 - 1.0).sqrt();
        let both = [disk(4.0, 4.0, 2.0), disk(5.0, 4.0, 2.0)];
        close(whole(&both, open, 0.0), 8.0 * PI - lens);
        // The disk at a face reaches over it, into the opposite side if the axis is periodic.
        let edge = [disk(9.0, 4.0, 1.0)];
        close(whole(&edge, [true, false], 1.0), 4.0 * PI);
        let beyond = 4.0 * (0.5_f64).acos() - 3.0_f64.sqrt();
        close(whole(&edge, open, 1.0), 4.0 * PI - beyond);
        // A solid grows by a strip at each edge and a disk at its corners together.
        let square = [polygon(&[[2.0, 2.0], [5.0, 2.0], [5.0, 5.0], [2.0, 5.0]])];
        close(whole(&square, open, 0.0), 9.0);
        close(whole(&square, open, 0.5), 9.0 + 12.0 * 0.5 + 0.25 * PI);
        // The strips of a hollow corner have a square in common.
        let hollow = [
            [1.0, 1.0],
            [5.0, 1.0],
            [5.0, 3.0],
            [3.0, 3.0],
            [3.0, 6.0],
            [1.0, 6.0],
        ];
        let grown = 14.0 + 18.0 * 0.5 + 5.0 * 0.25 * 0.25 * PI - 0.25;
        close(whole(&[polygon(&hollow)], open, 0.5), grown);
        // A plate takes room from centres only.
        let plate = [obstacle(ObstacleShape::Segment {
            ends: [vector![2.0, 2.0], vector![5.0, 6.0]],
        })];
        close(whole(&plate, open, 0.0), 0.0);
        close(whole(&plate, open, 0.5), 5.0 + 0.25 * PI);
    }

    /// Cells of a grid add up to the box, and each is what the plain count of points finds: within
    /// z = 4.9 binomial standard errors, which 160 cells exceed by chance once in 10^4 tests.
    #[test]
    fn cells_are_those_of_a_plain_count() {
        let round: Vec<[f64; 2]> = (0..40)
            .map(|corner| {
                let angle = f64::from(corner) * PI / 20.0;
                let size = if corner % 2 == 0 { 1.2 } else { 0.7 };
                [7.0 + size * angle.cos(), 5.0 + size * angle.sin()]
            })
            .collect();
        let bent = vec![vector![1.0, 7.0], vector![4.0, 5.5], vector![3.0, 7.9]];
        let obstacles = [
            disk(2.0, 1.5, 1.3),
            polygon(&round),
            obstacle(ObstacleShape::Polyline { points: bent }),
            polygon(&[[8.5, 0.1], [9.9, 0.2], [9.0, 3.0]]),
        ];
        let (lengths, clearance) = ([10.0, 8.0], 0.3);
        let area = FreeArea::new(&obstacles, lengths, [false; 2], clearance);
        let mut stream = Xoshiro256PlusPlus::seed_from_u64(5);
        let (points, mut sum) = (2000, 0.0);
        for (x, y) in (0..8).flat_map(|y| (0..20).map(move |x| (x, y))) {
            let low = [0.5 * f64::from(x), f64::from(y)];
            let high = [low[0] + 0.5, low[1] + 1.0];
            let found = area.rectangle_between(low, high);
            sum += found;
            let is_free = || {
                let place = vector![
                    low[0] + 0.5 * stream.random::<f64>(),
                    low[1] + stream.random::<f64>()
                ];
                obstacles
                    .iter()
                    .all(|one| !one.overlaps(place, clearance, 0.0))
            };
            let counted = std::iter::repeat_with(is_free).take(points);
            let share = counted.filter(|&free| free).count() as f64 / points as f64;
            let expected: f64 = 2.0 * found;
            let error = (expected * (1.0 - expected).max(0.0) / points as f64).sqrt();
            let off = (share - expected).abs();
            assert!(
                off <= 4.9 * error + 1e-7,
                "{low:?}: {share} {expected} {error}"
            );
        }
        let whole = area.rectangle_between([0.0; 2], lengths);
        assert!((whole - sum).abs() < 1e-6, "{whole} {sum}");
    }
}
