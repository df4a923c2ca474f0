//! Obstacles inside the box in two dimensions (disks, segments, polylines and polygons): shapes,
//! checks, contact times and overlaps.

use crate::{InvalidValue, format_short};
use nalgebra::Vector2;
use parry2d_f64::bounding_volume::{Aabb, BoundingVolume};
use parry2d_f64::math::{Pose, Vector};
use parry2d_f64::partitioning::{Bvh, BvhBuildStrategy};
use parry2d_f64::query::ClosestPoints;
use parry2d_f64::query::details::closest_points_segment_segment;
use parry2d_f64::shape::Segment;
use parry2d_f64::utils::point_in_poly2d;
use serde::{Deserialize, Serialize};

use super::feature::{Feature, FlyingParticle, Hit, Round, StraightEdge};
use super::rebound::Rebound;

/// Half the thickness of all lines of obstacles, and the least radius used for particles, relative
/// to the largest coordinate. So a point that has just rebounded is on the side it came from, in
/// spite of rounding.
const HAIR: f64 = 1e-10;

/// Least length of an edge, and least distance of edges that do not meet, relative to the largest
/// coordinate.
const FINEST: f64 = 1e-8;

/// Least sine of the angle between two edges that fold back at a corner.
const SHARPEST: f64 = 1e-6;

/// Shape of an obstacle that particles rebound from: circle, straight plate, polyline or polygon.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ObstacleShape {
    /// Solid disk.
    Circle {
        /// Centre of the disk \[length\].
        centre: Vector2<f64>,
        /// Radius of the disk \[length\].
        radius: f64,
    },
    /// Thin straight plate, touched from both sides.
    Segment {
        /// End points of the plate \[length\].
        ends: [Vector2<f64>; 2],
    },
    /// Thin bent plate, touched from both sides; closed if the last point is the first.
    Polyline {
        /// Corners of the bent plate, in order \[length\].
        points: Vec<Vector2<f64>>,
    },
    /// Solid with straight edges, convex or not, whose edges touch only at their ends.
    Polygon {
        /// Corners of the solid, in either order \[length\].
        points: Vec<Vector2<f64>>,
    },
}

impl ObstacleShape {
    /// Returns the shape displaced by a vector \[length\].
    #[must_use]
    pub fn moved(&self, by: Vector2<f64>) -> Self {
        let all = |points: &[Vector2<f64>]| points.iter().map(|point| point + by).collect();
        match self {
            Self::Circle { centre, radius } => Self::Circle {
                centre: centre + by,
                radius: *radius,
            },
            Self::Segment { ends } => Self::Segment {
                ends: ends.map(|end| end + by),
            },
            Self::Polyline { points } => Self::Polyline {
                points: all(points),
            },
            Self::Polygon { points } => Self::Polygon {
                points: all(points),
            },
        }
    }
}

/// Error why an obstacle is invalid.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ObstacleError {
    /// A polyline or polygon has too few points.
    #[error("{found} points; a {shape} has at least {least}")]
    TooFewPoints {
        /// Name of the shape with too few points: polyline or polygon.
        shape: &'static str,
        /// Number of points of the shape, which is too small.
        found: usize,
        /// Least number of points that the shape needs.
        least: usize,
    },
    /// A number of the obstacle is outside its allowed range.
    #[error(transparent)]
    Invalid(#[from] InvalidValue),
    /// An edge of the obstacle has no length, or too little.
    #[error("edge {edge} has the length {length:e}; allowed are lengths above {least:e}")]
    Degenerate {
        /// Number of the edge that is too short, from 0.
        edge: usize,
        /// Length of the edge that is too short \[length\].
        length: f64,
        /// Least allowed length of an edge \[length\].
        least: f64,
    },
    /// Two edges of the obstacle touch each other away from a common corner.
    #[error("edges {} and {} touch near ({}, {}); allowed are edges that meet at their ends only, one after the other", edges[0], edges[1], format_short(place[0]), format_short(place[1]))]
    SelfTouching {
        /// Numbers of the two edges that touch, from 0.
        edges: [usize; 2],
        /// Point where the two edges touch \[length\].
        place: [f64; 2],
    },
    /// The obstacle reaches beyond the box.
    #[error("reaches from ({}, {}) to ({}, {}); allowed is the box of {} x {}", format_short(bounds[0][0]), format_short(bounds[0][1]), format_short(bounds[1][0]), format_short(bounds[1][1]), format_short(lengths[0]), format_short(lengths[1]))]
    Outside {
        /// Lower left and upper right corner of the obstacle's bounding box \[length\].
        bounds: [[f64; 2]; 2],
        /// Sides of the box, which the obstacle exceeds \[length\].
        lengths: [f64; 2],
    },
}

/// Obstacle in the box: its shape, and the law by which particles rebound from it.
#[derive(Clone, Debug, PartialEq)]
pub struct Obstacle {
    outline: ObstacleShape,
    rebound: Rebound,
    features: Vec<Feature>,
    bounds: [Vector2<f64>; 2],
    hair: f64,
}

impl Obstacle {
    /// Creates an obstacle from a shape and a law of rebound.
    ///
    /// # Errors
    /// [`ObstacleError`] if the shape has parts without length, or touches itself, or a number is
    /// out of range.
    pub fn new(outline: ObstacleShape, rebound: Rebound) -> Result<Self, ObstacleError> {
        rebound.check_values()?;
        let points = check_numbers(&outline)?;
        let features = match &outline {
            ObstacleShape::Circle { centre, radius } => vec![Feature::Round(Round {
                centre: *centre,
                radius: *radius,
            })],
            ObstacleShape::Segment { ends } => polyline_features(&points, ends[..].iter(), true)?,
            ObstacleShape::Polyline { points: given } => {
                polyline_features(&points, given.iter(), true)?
            }
            ObstacleShape::Polygon { points: given } => {
                let closed = given.iter().chain(&given[..1]);
                // Counter-clockwise, so that the outside is to the right.
                if signed_area(given) > 0.0 {
                    polyline_features(&points, closed, false)?
                } else {
                    let backwards: Vec<_> = closed.copied().rev().collect();
                    polyline_features(&points, backwards.iter(), false)?
                }
            }
        };
        let bounds = (features.iter().map(Feature::bounds))
            .reduce(|a, b| [a[0].inf(&b[0]), a[1].sup(&b[1])])
            .unwrap_or_default();
        Ok(Self {
            hair: HAIR * largest_coordinate(&points),
            outline,
            rebound,
            features,
            bounds,
        })
    }

    /// Returns the shape of the obstacle.
    pub fn outline(&self) -> &ObstacleShape {
        &self.outline
    }

    /// Returns the law by which particles rebound from the obstacle.
    pub fn rebound(&self) -> &Rebound {
        &self.rebound
    }

    /// Returns the edges, corners and disks of the obstacle's shape.
    pub fn features(&self) -> &[Feature] {
        &self.features
    }

    /// Returns the radius used for a particle of the given radius at contacts with the obstacle
    /// \[length\]: at least a tiny fraction of the obstacle's extent.
    #[inline]
    pub fn taken(&self, radius: f64) -> f64 {
        radius.max(self.hair)
    }

    /// Returns the first contact of a particle in straight or parabolic flight with the obstacle
    /// before `limit` \[time\]; for a particle that has just rebounded, the next one.
    ///
    /// ```
    /// use nalgebra::vector;
    /// use stosszahl_model::walls::{Obstacle, ObstacleShape, Rebound};
    /// let law = Rebound::Restitutive { restitution: 1.0, slip: 1.0 };
    /// let disk = Obstacle::new(ObstacleShape::Circle { centre: vector![5.0, 0.0], radius: 1.0 }, law)?;
    /// let zero = vector![0.0, 0.0];
    /// let hit = disk.first_contact(zero, vector![2.0, 0.0], zero, 0.5, f64::INFINITY).expect("a hit");
    /// assert_eq!((hit.time, hit.normal), (1.75, vector![-1.0, 0.0]));
    /// # Ok::<(), stosszahl_model::walls::ObstacleError>(())
    /// ```
    pub fn first_contact(
        &self,
        position: Vector2<f64>,
        velocity: Vector2<f64>,
        acceleration: Vector2<f64>,
        radius: f64,
        limit: f64,
    ) -> Option<Hit> {
        let flight = FlyingParticle {
            position,
            velocity,
            acceleration,
        };
        let radius = self.taken(radius);
        let mut first: Option<Hit> = None;
        for feature in &self.features {
            let limit = first.map_or(limit, |hit| hit.time);
            first = feature.first_contact(&flight, radius, limit).or(first);
        }
        first
    }

    /// Returns the distance of a point from the obstacle's surface \[length\]; negative inside a
    /// solid.
    pub fn clearance(&self, point: Vector2<f64>) -> f64 {
        if let ObstacleShape::Circle { centre, radius } = &self.outline {
            return (point - centre).norm() - radius;
        }
        let distances = (self.features.iter()).map(|feature| feature.distance(point));
        let distance = distances.fold(f64::INFINITY, f64::min);
        if self.holds(point) {
            -distance
        } else {
            distance
        }
    }

    /// Returns true if a point is inside the obstacle, a disk or polygon.
    pub fn holds(&self, point: Vector2<f64>) -> bool {
        match &self.outline {
            ObstacleShape::Circle { centre, radius } => (point - centre).norm() < *radius,
            ObstacleShape::Segment { .. } | ObstacleShape::Polyline { .. } => false,
            ObstacleShape::Polygon { points } => {
                let points: Vec<Vector> = points.iter().map(|&point| point.into()).collect();
                point_in_poly2d(point.into(), &points)
            }
        }
    }

    /// Returns true if a particle overlaps the obstacle by more than `tolerance` \[length\].
    pub fn overlaps(&self, position: Vector2<f64>, radius: f64, tolerance: f64) -> bool {
        radius - self.clearance(position) > tolerance
    }

    /// Returns the bounding box of the obstacle: lower left and upper right corner \[length\].
    pub fn bounds(&self) -> [Vector2<f64>; 2] {
        self.bounds
    }

    /// Returns the area that the obstacle takes from the gas \[length^2\].
    pub fn area(&self) -> f64 {
        match &self.outline {
            ObstacleShape::Circle { radius, .. } => std::f64::consts::PI * radius * radius,
            ObstacleShape::Segment { .. } | ObstacleShape::Polyline { .. } => 0.0,
            ObstacleShape::Polygon { points } => signed_area(points).abs(),
        }
    }

    /// Checks that the obstacle is inside a box of the given side lengths, edges included.
    ///
    /// # Errors
    /// [`ObstacleError::Outside`] if it is not.
    pub fn check_inside(&self, lengths: Vector2<f64>) -> Result<(), ObstacleError> {
        let [least, most] = self.bounds;
        if least.min() >= 0.0 && most[0] <= lengths[0] && most[1] <= lengths[1] {
            return Ok(());
        }
        Err(ObstacleError::Outside {
            bounds: [least.into(), most.into()],
            lengths: lengths.into(),
        })
    }
}

/// Many obstacles with a bounding-volume hierarchy of their features, for contacts of particles
/// that fly for a limited time.
pub struct Obstacles {
    all: Vec<Obstacle>,
    /// Obstacle number and feature number of each leaf of the hierarchy.
    leaves: Vec<[u32; 2]>,
    tree: Bvh,
    hair: f64,
}

impl Obstacles {
    /// Builds the bounding-volume hierarchy of all obstacles of a box.
    pub fn new(all: Vec<Obstacle>) -> Self {
        let mut leaves = Vec::new();
        let mut boxes = Vec::new();
        for (number, obstacle) in all.iter().enumerate() {
            for (part, feature) in obstacle.features.iter().enumerate() {
                let [least, most] = feature.bounds();
                boxes.push(Aabb::new(least.into(), most.into()));
                leaves.push([number as u32, part as u32]);
            }
        }
        Self {
            hair: all.iter().map(|obstacle| obstacle.hair).fold(0.0, f64::max),
            tree: Bvh::from_leaves(BvhBuildStrategy::Binned, &boxes),
            all,
            leaves,
        }
    }

    /// Returns all obstacles, in the order given.
    pub fn obstacle_list(&self) -> &[Obstacle] {
        &self.all
    }

    /// Returns the first contact of a particle in flight with any obstacle before `limit` \[time\],
    /// which must be finite, and the number of the obstacle.
    pub fn first_contact(
        &self,
        position: Vector2<f64>,
        velocity: Vector2<f64>,
        acceleration: Vector2<f64>,
        radius: f64,
        limit: f64,
    ) -> Option<(usize, Hit)> {
        if self.leaves.is_empty() {
            return None;
        }
        let flight = FlyingParticle {
            position,
            velocity,
            acceleration,
        };
        let [least, most] = flight.bounds(limit);
        // Reach with a margin against rounding.
        let reach =
            (radius.max(self.hair) * (1.0 + 1e-9)).max(HAIR * largest_coordinate(&[least, most]));
        let reach = Vector::new(reach, reach);
        let (least, most): (Vector, Vector) = (least.into(), most.into());
        let mut first: Option<(usize, Hit)> = None;
        for leaf in self
            .tree
            .intersect_aabb(&Aabb::new(least - reach, most + reach))
        {
            let [number, part] = self.leaves[leaf as usize].map(|index| index as usize);
            let obstacle = &self.all[number];
            let limit = first.map_or(limit, |(_, hit)| hit.time);
            let radius = obstacle.taken(radius);
            if let Some(hit) = obstacle.features[part].first_contact(&flight, radius, limit) {
                first = Some((number, hit));
            }
        }
        first
    }

    /// Returns the number of the first obstacle that a particle overlaps by more than `tolerance`
    /// \[length\].
    pub fn overlapped(&self, position: Vector2<f64>, radius: f64, tolerance: f64) -> Option<usize> {
        let overlaps = |obstacle: &Obstacle| obstacle.overlaps(position, radius, tolerance);
        self.all.iter().position(overlaps)
    }
}

/// Returns the points of a shape; an error if they are too few or a number is invalid.
fn check_numbers(outline: &ObstacleShape) -> Result<Vec<Vector2<f64>>, ObstacleError> {
    let too_few = |shape, found, least| {
        Err(ObstacleError::TooFewPoints {
            shape,
            found,
            least,
        })
    };
    let points = match outline {
        ObstacleShape::Circle { centre, radius } => {
            let is_allowed = *radius > 0.0 && *radius <= 1e100;
            let allowed = "a positive number up to 1e100";
            InvalidValue::require(is_allowed, "radius", *radius, allowed)?;
            vec![*centre]
        }
        ObstacleShape::Segment { ends } => ends.to_vec(),
        ObstacleShape::Polyline { points } if points.len() < 2 => {
            return too_few("polyline", points.len(), 2);
        }
        ObstacleShape::Polygon { points } if points.len() < 3 => {
            return too_few("polygon", points.len(), 3);
        }
        ObstacleShape::Polyline { points } | ObstacleShape::Polygon { points } => points.clone(),
    };
    let numbers = points.iter().flat_map(|point| point.iter());
    let bad = |number: &&f64| number.is_nan() || number.abs() > 1e100;
    if let Some(&value) = numbers.into_iter().find(bad) {
        return Err(InvalidValue::new("a coordinate", value, "a number up to 1e100").into());
    }
    Ok(points)
}

/// Returns the largest absolute coordinate of points \[length\].
fn largest_coordinate(points: &[Vector2<f64>]) -> f64 {
    points.iter().map(Vector2::amax).fold(0.0, f64::max)
}

/// Returns the area of a polygon \[length^2\], positive if its corners are counter-clockwise.
fn signed_area(points: &[Vector2<f64>]) -> f64 {
    let next = points.iter().cycle().skip(1);
    let origin = points[0];
    let twice = (points.iter().zip(next)).map(|(a, b)| (a - origin).perp(&(b - origin)));
    0.5 * twice.sum::<f64>()
}

/// Returns the edges and corners of a polyline through points, as features that particles can
/// touch.
fn polyline_features<'a>(
    all: &[Vector2<f64>],
    points: impl Iterator<Item = &'a Vector2<f64>>,
    both_sides: bool,
) -> Result<Vec<Feature>, ObstacleError> {
    let points: Vec<Vector2<f64>> = points.copied().collect();
    let least = FINEST * largest_coordinate(all);
    let mut edges = Vec::with_capacity(points.len());
    for (edge, ends) in points.windows(2).enumerate() {
        let along = ends[1] - ends[0];
        let length = along.norm();
        if length <= least {
            return Err(ObstacleError::Degenerate {
                edge,
                length,
                least,
            });
        }
        edges.push(StraightEdge {
            from: ends[0],
            along: along / length,
            length,
            both_sides,
        });
    }
    let closed = points.first() == points.last();
    check_touching(&points, &edges, closed, least)?;
    let mut features: Vec<Feature> = edges.iter().copied().map(Feature::Edge).collect();
    let corner = |centre: &Vector2<f64>| {
        Feature::Round(Round {
            centre: *centre,
            radius: 0.0,
        })
    };
    let joints = edges.iter().zip(edges.iter().cycle().skip(1));
    for (joint, (before, after)) in joints.enumerate() {
        let last = joint + 1 == edges.len();
        // Corners: in a hollow of a solid only the edges are touched.
        if both_sides || before.along.perp(&after.along) > 0.0 {
            features.push(corner(&points[joint + 1]));
        }
        if last && !closed {
            features.push(corner(&points[0]));
        }
    }
    Ok(features)
}

/// Checks that the edges of an obstacle touch only where one ends and the next begins.
fn check_touching(
    points: &[Vector2<f64>],
    edges: &[StraightEdge],
    closed: bool,
    least: f64,
) -> Result<(), ObstacleError> {
    let count = edges.len();
    let refuse = |first: usize, second: usize, place: Vector2<f64>| {
        Err(ObstacleError::SelfTouching {
            edges: [first.min(second), first.max(second)],
            place: place.into(),
        })
    };
    let segment = |edge: usize| Segment::new(points[edge].into(), points[edge + 1].into());
    let aabb = |edge: usize| segment(edge).local_aabb().loosened(least);
    let boxes: Vec<Aabb> = (0..count).map(aabb).collect();
    let tree = Bvh::from_leaves(BvhBuildStrategy::Binned, &boxes);
    for (first, around) in boxes.iter().enumerate() {
        let mut others: Vec<u32> = tree.intersect_aabb(around).collect();
        others.sort_unstable();
        for second in others.into_iter().map(|leaf| leaf as usize) {
            if second <= first {
                continue;
            }
            let follows = second == first + 1;
            if follows || (closed && first == 0 && second + 1 == count) {
                let (before, after) = if follows {
                    (first, second)
                } else {
                    (second, first)
                };
                let turn = [edges[before].along, edges[after].along];
                let folded = turn[0].dot(&turn[1]) < 0.0 && turn[0].perp(&turn[1]).abs() < SHARPEST;
                if folded {
                    return refuse(first, second, points[after]);
                }
                if count > 2 || !closed {
                    continue;
                }
            }
            let (one, other) = (segment(first), segment(second));
            let closest = closest_points_segment_segment(&Pose::identity(), &one, &other, least);
            if let ClosestPoints::WithinMargin(place, _) = closest {
                return refuse(first, second, place.into());
            }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests;
