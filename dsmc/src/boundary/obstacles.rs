//! Obstacles among the cells of a run.

use nalgebra::{Vector2, vector};
use stosszahl_model::walls::{Hit, Obstacle, Obstacles};
use stosszahl_model::{Domain, Space};

use crate::grid::Grid;
use crate::parameters::EngineError;

/// Points along each axis of a cell at which it is asked whether an obstacle takes the place.
const SAMPLES: u32 = 16;

/// Depth in an obstacle, over the sides of the box, that is taken for rounding.
const SLACK: f64 = 1e-9;

/// All that stands in the box, with the periodic images that reach into it.
pub(crate) struct Standing {
    all: Obstacles,
    /// The obstacle that each of them is an image of, and their number.
    originals: Vec<usize>,
    count: usize,
    /// The rectangle around each, wide enough for the largest particle \[length\].
    bounds: Vec<[Vector2<f64>; 2]>,
    slack: f64,
}

impl Standing {
    /// Obstacles in a box, for particles whose centres stay at most `largest` away; none if there are none.
    pub(crate) fn new<S: Space>(
        obstacles: &[Obstacle],
        domain: &Domain<S>,
        largest: f64,
    ) -> Result<Option<Self>, EngineError> {
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
            let wrong = |source| EngineError::Obstacle {
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

    /// The first contact in a flight through the box before `limit`, with what is touched, and the number of the obstacle.
    pub(crate) fn first_contact(
        &self,
        [position, velocity, acceleration]: [Vector2<f64>; 3],
        radius: f64,
        limit: f64,
    ) -> Option<(&Obstacle, usize, Hit)> {
        let (image, hit) =
            self.all
                .first_contact(position, velocity, acceleration, radius, limit)?;
        Some((&self.all.all()[image], self.originals[image], hit))
    }

    /// The obstacle that a particle overlaps, if there is one.
    pub(crate) fn overlapped(&self, place: [f64; 2], radius: f64) -> Option<usize> {
        let image = self.all.overlapped(place.into(), radius, self.slack)?;
        Some(self.originals[image])
    }

    /// Whether the rectangle between two corners is farther from all than a reach along each axis.
    pub(crate) fn are_far_from(&self, corners: [[f64; 2]; 2], reach: [f64; 2]) -> bool {
        self.bounds.iter().all(|[least, most]| {
            (0..2).any(|axis| {
                corners[0][axis] - reach[axis] > most[axis]
                    || corners[1][axis] + reach[axis] < least[axis]
            })
        })
    }

    /// The share of each cell that is left to the centres of particles that stay `clearance` away, by sampling.
    pub(crate) fn rooms<S: Space>(&self, grid: &Grid<S>, clearance: f64) -> Vec<f64> {
        let [columns, rows, layers] = grid.counts();
        let width = grid.width();
        let mut layer = Vec::with_capacity((columns * rows) as usize);
        for y in 0..rows {
            for x in 0..columns {
                let low = [f64::from(x) * width[0], f64::from(y) * width[1]];
                let high = [low[0] + width[0], low[1] + width[1]];
                layer.push(if self.are_far_from([low, high], [0.0; 2]) {
                    1.0
                } else {
                    self.room(low, [width[0], width[1]], clearance)
                });
            }
        }
        layer.repeat(layers as usize)
    }

    /// The share of one cell.
    fn room(&self, low: [f64; 2], width: [f64; 2], clearance: f64) -> f64 {
        let step = |number: u32| (f64::from(number) + 0.5) / f64::from(SAMPLES);
        let places = (0..SAMPLES).flat_map(|y| (0..SAMPLES).map(move |x| [step(x), step(y)]));
        let free = places
            .filter(|at| {
                let place = vector![low[0] + at[0] * width[0], low[1] + at[1] * width[1]];
                self.all.overlapped(place, clearance, 0.0).is_none()
            })
            .count();
        free as f64 / f64::from(SAMPLES * SAMPLES)
    }
}
