//! Confinement of the start: faces of the box and obstacles, which initial particles must not
//! overlap.

use stosszahl_case::format::FACES;
use stosszahl_model::walls::Obstacle;
use stosszahl_model::{Domain, Space, Walls};

use super::data::{CasePlan, PlanError};

/// Largest overlap, over the diameter, that counts as touching, because of rounding.
const TOUCHES: f64 = 1e-9;

/// Confinement of particles: box, faces and obstacles.
#[derive(Clone, Debug)]
pub(crate) struct Confinement<S: Space> {
    /// Box of the gas, with its sides.
    pub(crate) domain: Domain<S>,
    /// Faces of the box.
    pub(crate) walls: Walls<S>,
    /// Obstacles inside the box.
    pub(crate) obstacles: Vec<Obstacle>,
}

impl<S: Space> Confinement<S> {
    /// Creates the confinement of a case from its plan, in engine units.
    ///
    /// # Errors
    /// [`PlanError`] names the invalid face, body or box.
    pub(crate) fn from_plan(plan: &CasePlan) -> Result<Self, PlanError> {
        let walls = plan.walls::<S>()?;
        let domain = walls
            .domain(S::from_components(|axis| plan.gas.lengths[axis]))
            .map_err(|error| PlanError::new("box", error.found, error.allowed))?;
        Ok(Self {
            domain,
            walls,
            obstacles: plan.obstacles()?,
        })
    }

    /// Returns the displacement of a vibrating wall at time 0 from its face into the box
    /// \[length\]; 0 without a wall.
    pub(crate) fn wall(&self, axis: usize, side: usize) -> f64 {
        let wall = self.walls.wall(axis, side);
        wall.map_or(0.0, |wall| wall.displacement(0.0))
    }

    /// Returns the greatest overlap of a particle with an obstacle \[length\], and the index of the
    /// obstacle.
    pub(crate) fn body_at(&self, place: S::Vector, radius: f64) -> Option<(usize, f64)> {
        let steps = |axis: usize| {
            if self.domain.is_periodic(axis) {
                [0.0, -1.0, 1.0].as_slice()
            } else {
                &[0.0]
            }
        };
        let images = self.domain.images();
        let depth = |obstacle: &Obstacle| {
            let [least, most] = obstacle.bounds();
            let mut deepest = f64::NEG_INFINITY;
            for &right in steps(0) {
                for &up in steps(1) {
                    let at = place + images.image([right, up, 0.0]).position;
                    let near = |axis: usize| {
                        (least[axis] - radius..=most[axis] + radius).contains(&at[axis])
                    };
                    if near(0) && near(1) {
                        deepest = deepest.max(radius - obstacle.clearance([at[0], at[1]].into()));
                    }
                }
            }
            deepest
        };
        let depths = self.obstacles.iter().map(depth).enumerate();
        depths
            .filter(|one| one.1 > f64::NEG_INFINITY)
            .max_by(|a, b| a.1.total_cmp(&b.1))
    }

    /// Returns the wall or obstacle that a particle overlaps, by its key in the case, and the
    /// overlap \[length\].
    pub(crate) fn blocks(&self, place: S::Vector, radius: f64) -> Option<(String, f64)> {
        let deep = |depth: f64| depth > 2.0 * TOUCHES * radius;
        for (axis, names) in FACES.iter().enumerate().take(S::DIMENSION) {
            for (side, name) in names.iter().enumerate() {
                if self.walls.wall(axis, side).is_none() {
                    continue;
                }
                let above = match side {
                    0 => place[axis],
                    _ => self.domain.lengths()[axis] - place[axis],
                };
                let depth = radius - above + self.wall(axis, side);
                if deep(depth) {
                    return Some((format!("walls.{name}"), depth));
                }
            }
        }
        let body = self.body_at(place, radius).filter(|one| deep(one.1));
        body.map(|(index, depth)| (format!("obstacle.{}", index + 1), depth))
    }
}
