//! Obstacles of a DSMC run with their periodic images: contacts, overlaps, lines of sight, and the
//! area free for particle centres.

use std::f64::consts::PI;

use nalgebra::{Vector2, vector};
use stosszahl_model::walls::{Hit, Obstacle, ObstacleShape, Obstacles};
use stosszahl_model::{Domain, Space};

use super::convex::{ConvexPolygon, CutLine};
use crate::parameters::DsmcError;

type Point = Vector2<f64>;

/// Least number of corners of the polygon that replaces a circular obstacle for lines of sight.
const LEAST_CORNERS: f64 = 4.0;

/// Depth of overlap with an obstacle that counts as rounding, relative to the sides of the box.
const SLACK: f64 = 1e-9;

/// Obstacles in the box, with their periodic images that reach into it.
pub(crate) struct ObstacleMap {
    all: Obstacles,
    /// Index of the obstacle of which each entry of `all` is a periodic image, or the obstacle
    /// itself.
    originals: Vec<usize>,
    /// Number of obstacles, without periodic images.
    count: usize,
    /// Bounding box of each obstacle and image, widened by the largest particle radius \[length\].
    bounds: Vec<[Vector2<f64>; 2]>,
    slack: f64,
}

impl ObstacleMap {
    /// Creates the map of obstacles in a box; bounding boxes are widened by the largest particle
    /// radius `largest` \[length\]. `None` without obstacles.
    pub(crate) fn new<S: Space>(
        obstacles: &[Obstacle],
        domain: &Domain<S>,
        largest: f64,
    ) -> Result<Option<Self>, DsmcError> {
        if obstacles.is_empty() {
            return Ok(None);
        }
        let lengths = vector![domain.lengths()[0], domain.lengths()[1]];
        let shifts = |axis: usize| {
            if domain.is_periodic(axis) {
                -1..=1
            } else {
                0..=0
            }
        };
        let (mut all, mut originals, mut bounds) = (Vec::new(), Vec::new(), Vec::new());
        for (number, obstacle) in obstacles.iter().enumerate() {
            let wrong = |source| DsmcError::Obstacle {
                obstacle: number,
                source,
            };
            obstacle.check_inside(lengths).map_err(wrong)?;
            let reach = obstacle.taken(largest);
            let [least, most] = obstacle.bounds();
            for x in shifts(0) {
                for y in shifts(1) {
                    let by = domain
                        .images()
                        .image([f64::from(x), f64::from(y), 0.0])
                        .position;
                    let by = vector![by[0], by[1]];
                    let wide = [least + by.add_scalar(-reach), most + by.add_scalar(reach)];
                    let meets =
                        |axis: usize| wide[1][axis] >= 0.0 && wide[0][axis] <= lengths[axis];
                    if !(meets(0) && meets(1)) {
                        continue;
                    }
                    let outline = obstacle.outline().moved(by);
                    all.push(Obstacle::new(outline, *obstacle.rebound()).map_err(wrong)?);
                    originals.push(number);
                    bounds.push(wide);
                }
            }
        }
        Ok(Some(Self {
            all: Obstacles::new(all),
            originals,
            count: obstacles.len(),
            bounds,
            slack: SLACK * lengths.max(),
        }))
    }

    /// Returns the number of obstacles, without periodic images.
    pub(crate) fn count(&self) -> usize {
        self.count
    }

    /// Returns the first contact of a particle in flight with an obstacle before `limit` \[time\]:
    /// the obstacle, its index, and the feature touched.
    pub(crate) fn first_contact(
        &self,
        [position, velocity, acceleration]: [Vector2<f64>; 3],
        radius: f64,
        limit: f64,
    ) -> Option<(&Obstacle, usize, Hit)> {
        let (image, hit) =
            self.all
                .first_contact(position, velocity, acceleration, radius, limit)?;
        Some((&self.all.obstacle_list()[image], self.originals[image], hit))
    }

    /// Returns the index of the obstacle that a particle overlaps by more than rounding; `None` if
    /// it overlaps none.
    pub(crate) fn overlapped(&self, place: [f64; 2], radius: f64) -> Option<usize> {
        let image = self.all.overlapped(place.into(), radius, self.slack)?;
        Some(self.originals[image])
    }

    /// Returns true if every obstacle is farther than `reach` along some axis from the rectangle
    /// between two corners.
    pub(crate) fn are_far_from(&self, corners: [[f64; 2]; 2], reach: [f64; 2]) -> bool {
        self.bounds.iter().all(|[least, most]| {
            (0..2).any(|axis| {
                corners[0][axis] - reach[axis] > most[axis]
                    || corners[1][axis] + reach[axis] < least[axis]
            })
        })
    }

    /// Returns the indices of the obstacles that may come closer than `clearance` to the rectangle
    /// between two corners; `None` if none do.
    pub(super) fn near(&self, corners: [Point; 2], clearance: f64) -> Option<Vec<usize>> {
        let meets = |[least, most]: &[Point; 2]| {
            (0..2).all(|axis| corners[0][axis] <= most[axis] && corners[1][axis] >= least[axis])
        };
        let bounds = self.bounds.iter().enumerate();
        let near: Vec<usize> = bounds
            .filter_map(|(number, bounds)| meets(bounds).then_some(number))
            .collect();
        let middle = 0.5 * (corners[0] + corners[1]);
        let gap = ClosedRegion::new(self, &near, clearance).gap(middle);
        (gap < (corners[1] - middle).norm()).then_some(near)
    }

    /// Returns the straight edges of all obstacles as segments; circles are replaced by inscribed
    /// polygons at most `sagitta` from the circle \[length\].
    pub(super) fn edges(&self, sagitta: f64) -> Vec<[Point; 2]> {
        let mut edges = Vec::new();
        for obstacle in self.all.obstacle_list() {
            let points = match obstacle.outline() {
                ObstacleShape::Segment { ends } => ends.to_vec(),
                ObstacleShape::Polyline { points } => points.clone(),
                ObstacleShape::Polygon { points } => [&points[..], &points[..1]].concat(),
                ObstacleShape::Circle { centre, radius } => {
                    let half_angle = (1.0 - sagitta / radius).max(-1.0).acos();
                    let count = (PI / half_angle).ceil().max(LEAST_CORNERS) as u32;
                    let corner = |corner: u32| {
                        let angle = 2.0 * PI * f64::from(corner % count) / f64::from(count);
                        centre + vector![angle.cos(), angle.sin()] * *radius
                    };
                    (0..=count).map(corner).collect()
                }
            };
            edges.extend(points.windows(2).map(|ends| [ends[0], ends[1]]));
        }
        edges
    }

    /// Returns true if no obstacle blocks the line of sight between two points. `images` are shifts
    /// that bring each part of the line into the box.
    pub(super) fn sees(&self, [from, to]: [Point; 2], images: &[Point]) -> bool {
        images.iter().all(|shift| {
            let hit = (self.all).first_contact(from + shift, to - from, Point::zeros(), 0.0, 1.0);
            hit.is_none()
        })
    }
}

/// Region that some obstacles close to particle centres: the obstacles, widened by a clearance.
pub(super) struct ClosedRegion<'a> {
    all: &'a ObstacleMap,
    near: &'a [usize],
    clearance: f64,
}

impl<'a> ClosedRegion<'a> {
    /// Creates the region that the obstacles with the indices `near` close to particle centres;
    /// `clearance` is added on all sides \[length\].
    pub(super) fn new(all: &'a ObstacleMap, near: &'a [usize], clearance: f64) -> Self {
        Self {
            all,
            near,
            clearance,
        }
    }

    /// Returns the distance of a point from the region closed to particle centres \[length\];
    /// negative inside.
    fn gap(&self, point: Point) -> f64 {
        let near = self
            .near
            .iter()
            .map(|&number| &self.all.all.obstacle_list()[number]);
        let distances = near.map(|obstacle| obstacle.clearance(point));
        distances.fold(f64::INFINITY, f64::min) - self.clearance
    }

    /// Returns true if the region closed to particle centres has straight edges only: no clearance
    /// and no circles.
    fn is_straight(&self) -> bool {
        let mut near = self
            .near
            .iter()
            .map(|&number| &self.all.all.obstacle_list()[number]);
        self.clearance == 0.0
            && near.all(|obstacle| !matches!(obstacle.outline(), ObstacleShape::Circle { .. }))
    }

    /// Measures the area of a polygon that is open to particle centres \[length^2\]; no straight
    /// edge crosses it. A polygon that is partly open is quartered up to `depth` times; the last
    /// pieces are cut by the tangent. `look` receives points and their distances from the closed
    /// region \[length\].
    pub(super) fn free_area(
        &self,
        region: &ConvexPolygon,
        depth: u32,
        look: &mut impl FnMut(f64, Point),
    ) -> f64 {
        let (area, middle) = region.area_and_centroid();
        if area <= 0.0 {
            return 0.0;
        }
        let gap = self.gap(middle);
        look(gap, middle);
        if self.is_straight() {
            return if gap > 0.0 { area } else { 0.0 };
        }
        let radius = region.radius_around(middle);
        if gap >= radius {
            return area;
        }
        if gap <= -radius {
            return 0.0;
        }
        if depth == 0 {
            return self.cut_by_tangent(region, middle, gap, 1e-3 * radius);
        }
        let lines = [Point::x(), Point::y()].map(|normal| CutLine::facing(middle, normal));
        let halves = region.cut(&lines[0]);
        let quarters = halves.iter().flat_map(|half| half.cut(&lines[1]));
        quarters
            .map(|quarter| self.free_area(&quarter, depth - 1, look))
            .sum()
    }

    /// Estimates the area of `region` that is open to particle centres \[length^2\], with the
    /// boundary of the closed part replaced by its tangent. The tangent follows from the distance
    /// `gap` of `point`, and its gradient by differences over `step` \[length\].
    fn cut_by_tangent(&self, region: &ConvexPolygon, point: Point, gap: f64, step: f64) -> f64 {
        let slope = |along: Point| {
            (self.gap(point + along * step) - self.gap(point - along * step)) / (2.0 * step)
        };
        let gradient = vector![slope(Point::x()), slope(Point::y())];
        let steepness = gradient.norm();
        // At equal distance from two obstacles there is no tangent.
        if steepness < 0.5 {
            return if gap >= 0.0 {
                region.area_and_centroid().0
            } else {
                0.0
            };
        }
        let normal = gradient / steepness;
        let tangent = CutLine::facing(point - normal * gap, normal);
        region.in_front_of(&tangent).area_and_centroid().0
    }
}
