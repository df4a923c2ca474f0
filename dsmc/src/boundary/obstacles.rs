//! Obstacles of a run, with their periodic images.

use std::f64::consts::PI;

use nalgebra::{Vector2, vector};
use stosszahl_model::walls::{Hit, Obstacle, ObstacleShape, Obstacles};
use stosszahl_model::{Domain, Space};

use super::convex::{ConvexPolygon, CutLine};
use crate::parameters::DsmcError;

type Point = Vector2<f64>;

/// Smallest number of corners of a polygon that replaces a disk.
const LEAST_CORNERS: f64 = 4.0;

/// Depth of overlap with an obstacle, over the box sides, that counts as rounding.
const SLACK: f64 = 1e-9;

/// Obstacles in the box, with the periodic images that reach into it.
pub(crate) struct ObstacleMap {
    all: Obstacles,
    /// Index of the obstacle of which each entry of `all` is an image.
    originals: Vec<usize>,
    /// Number of obstacles without images.
    count: usize,
    /// Bounding box of each obstacle, widened by the largest particle \[length\].
    bounds: Vec<[Vector2<f64>; 2]>,
    slack: f64,
}

impl ObstacleMap {
    /// Places obstacles in a box, for centres that stay at most `largest` away; `None` without
    /// obstacles.
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

    /// Number of obstacles, without their images.
    pub(crate) fn count(&self) -> usize {
        self.count
    }

    /// First contact in a flight through the box before `limit`, the feature touched, and the
    /// number of the obstacle.
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

    /// Number of the obstacle that a particle overlaps; `None` if it overlaps none.
    pub(crate) fn overlapped(&self, place: [f64; 2], radius: f64) -> Option<usize> {
        let image = self.all.overlapped(place.into(), radius, self.slack)?;
        Some(self.originals[image])
    }

    /// Returns true if the rectangle between two corners is farther than `reach` along some axis
    /// from every obstacle.
    pub(crate) fn are_far_from(&self, corners: [[f64; 2]; 2], reach: [f64; 2]) -> bool {
        self.bounds.iter().all(|[least, most]| {
            (0..2).any(|axis| {
                corners[0][axis] - reach[axis] > most[axis]
                    || corners[1][axis] + reach[axis] < least[axis]
            })
        })
    }

    /// Numbers of the obstacles that may come closer than `clearance` to the rectangle between two
    /// corners; `None` if it is free.
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

    /// Edges of all obstacles; disks are replaced by inscribed polygons at most `sagitta` from the
    /// circle.
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

    /// Returns true if no obstacle blocks the line of sight between two points. `images`: shifts
    /// that bring each part of the line into the box.
    pub(super) fn sees(&self, [from, to]: [Point; 2], images: &[Point]) -> bool {
        images.iter().all(|shift| {
            let hit = (self.all).first_contact(from + shift, to - from, Point::zeros(), 0.0, 1.0);
            hit.is_none()
        })
    }
}

/// Region closed to particle centres: some obstacles, widened by a clearance.
pub(super) struct ClosedRegion<'a> {
    all: &'a ObstacleMap,
    near: &'a [usize],
    clearance: f64,
}

impl<'a> ClosedRegion<'a> {
    /// Creates the closed region of the obstacles with the numbers `near`.
    pub(super) fn new(all: &'a ObstacleMap, near: &'a [usize], clearance: f64) -> Self {
        Self {
            all,
            near,
            clearance,
        }
    }

    /// Distance of a point from the closed region \[length\]; negative inside.
    fn gap(&self, point: Point) -> f64 {
        let near = self
            .near
            .iter()
            .map(|&number| &self.all.all.obstacle_list()[number]);
        let distances = near.map(|obstacle| obstacle.clearance(point));
        distances.fold(f64::INFINITY, f64::min) - self.clearance
    }

    /// Returns true if the closed region has straight edges only.
    fn is_straight(&self) -> bool {
        let mut near = self
            .near
            .iter()
            .map(|&number| &self.all.all.obstacle_list()[number]);
        self.clearance == 0.0
            && near.all(|obstacle| !matches!(obstacle.outline(), ObstacleShape::Circle { .. }))
    }

    /// Area of the part of a region that is open to particle centres \[length^2\]; no edge crosses
    /// the region. A region open in part is quartered up to `depth` times, and the last pieces are
    /// cut by the tangent. `look` is called with points and their distances from the region closed
    /// to centres \[length\].
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
