//! Random sequential placement of particles in a box, outside walls and obstacles, with a cell list
//! for overlaps.

use std::ops::Range;

use rand::{Rng, RngExt};
use stosszahl_model::{Interrupt, Space, Vector};

use crate::plan::{CasePlan, Confinement, Region};
use crate::start::error::{PlacementFailed, StartError};

/// Exclusion rule for initial positions: between particles, and at walls and obstacles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ExclusionRule {
    /// Point particles: their centres lie anywhere in the box outside obstacles.
    Points,
    /// Particles that overlap neither walls nor obstacles, but may overlap each other.
    Surfaces,
    /// Particles that overlap neither walls nor obstacles nor each other.
    Grains,
}

impl ExclusionRule {
    /// Rule of the start of a case.
    pub(crate) fn of_start(plan: &CasePlan) -> Self {
        match (plan.keeps_apart(), plan.keeps_clear()) {
            (true, _) => Self::Grains,
            (false, true) => Self::Surfaces,
            (false, false) => Self::Points,
        }
    }
}

/// Largest number of trial positions for placing one particle.
const MOST_TRIALS: usize = 1_000_000;

/// Random placement in progress: positions of the particles placed so far, in a cell list.
pub(crate) struct RandomPlacement<'a, S: Space> {
    count: usize,
    radius: &'a dyn Fn(usize) -> f64,
    confinement: &'a Confinement<S>,
    region: Option<Region>,
    size: S::Vector,
    room: ExclusionRule,
    counts: [usize; 3],
    cells: Vec<Vec<(S::Vector, f64)>>,
    trials: u64,
}

impl<'a, S: Space> RandomPlacement<'a, S> {
    /// Creates an empty placement in a box, or in a region of it, for particles with given radii.
    pub(crate) fn new(
        count: usize,
        radius: &'a dyn Fn(usize) -> f64,
        confinement: &'a Confinement<S>,
        region: Option<Region>,
        room: ExclusionRule,
    ) -> Self {
        let size = confinement.domain.lengths();
        let largest = (0..count).map(radius).fold(0.0, f64::max);
        // Cells as fine as a diameter, but not many more than particles.
        let most = (2.0 * count as f64).powf(1.0 / S::DIMENSION as f64).ceil() as usize + 1;
        let counts = [0, 1, 2].map(|axis| {
            if axis < S::DIMENSION && room == ExclusionRule::Grains && largest > 0.0 {
                ((size[axis] / (2.0 * largest)).floor() as usize).clamp(1, most)
            } else {
                1
            }
        });
        Self {
            count,
            radius,
            confinement,
            region,
            size,
            room,
            counts,
            cells: vec![Vec::new(); counts.iter().product()],
            trials: 0,
        }
    }

    /// Draws a position for each particle, the largest particles first, while there is space for
    /// them.
    pub(crate) fn place_all(
        mut self,
        stream: &mut impl Rng,
        interrupt: &Interrupt,
        look: &mut dyn FnMut(usize, S::Vector),
    ) -> Result<(), StartError> {
        for run in self.runs() {
            for index in run {
                look(index, self.find_place(index, stream, interrupt)?);
            }
        }
        Ok(())
    }

    /// Runs of consecutive particles of one radius, the largest first.
    fn runs(&self) -> Vec<Range<usize>> {
        let mut runs: Vec<Range<usize>> = Vec::new();
        for index in 0..self.count {
            match runs.last_mut() {
                Some(run) if (self.radius)(run.start) == (self.radius)(index) => run.end += 1,
                _ => runs.push(index..index + 1),
            }
        }
        runs.sort_by(|a, b| (self.radius)(b.start).total_cmp(&(self.radius)(a.start)));
        runs
    }

    fn cell(&self, position: S::Vector) -> [usize; 3] {
        [0, 1, 2].map(|axis| {
            if axis < S::DIMENSION {
                let place = position[axis] / self.size[axis] * self.counts[axis] as f64;
                (place as usize).min(self.counts[axis] - 1)
            } else {
                0
            }
        })
    }

    fn number(&self, [x, y, z]: [usize; 3]) -> usize {
        x + self.counts[0] * (y + self.counts[1] * z)
    }

    fn find_place(
        &mut self,
        particle: usize,
        stream: &mut impl Rng,
        interrupt: &Interrupt,
    ) -> Result<S::Vector, StartError> {
        let radius = (self.radius)(particle);
        for _ in 0..MOST_TRIALS {
            self.trials += 1;
            if interrupt.is_raised_at(self.trials) {
                return Err(StartError::Interrupted);
            }
            let mut trial = S::Vector::default();
            for axis in 0..S::DIMENSION {
                let [low, high] = self.centre_range(axis, radius);
                trial[axis] = low + (high - low) * stream.random::<f64>();
            }
            if self.is_free(trial, radius) {
                if self.room == ExclusionRule::Grains {
                    let cell = self.number(self.cell(trial));
                    self.cells[cell].push((trial, radius));
                }
                return Ok(trial);
            }
        }
        let count = self.count;
        Err(StartError::PlacementFailed(PlacementFailed {
            particle,
            count,
            trials: MOST_TRIALS,
        }))
    }

    /// Returns the range of the centre of a particle along an axis \[length\].
    fn centre_range(&self, axis: usize, radius: f64) -> [f64; 2] {
        let edge = |side: usize| self.clearance(axis, side, radius);
        let (low, high) = (edge(0), self.size[axis] - edge(1));
        let Some(region) = self.region else {
            return [low, high];
        };
        let margin = if self.room == ExclusionRule::Points {
            0.0
        } else {
            radius
        };
        let inner = [region.low[axis] + margin, region.high[axis] - margin];
        [inner[0].max(low), inner[1].min(high)]
    }

    /// Returns the smallest allowed distance of a particle's centre from a face \[length\].
    fn clearance(&self, axis: usize, side: usize, radius: f64) -> f64 {
        let wall = self.confinement.walls.wall(axis, side);
        match (wall, self.room) {
            (Some(_), ExclusionRule::Points) => self.confinement.wall(axis, side),
            // Slightly more, so that rounding makes no particle touch a wall.
            (Some(_), _) => self.confinement.wall(axis, side) + radius * (1.0 + 1e-9),
            (None, _) => 0.0,
        }
    }

    fn is_free(&self, trial: S::Vector, radius: f64) -> bool {
        let reach = if self.room == ExclusionRule::Points {
            0.0
        } else {
            radius * (1.0 + 1e-9)
        };
        let body = self.confinement.body_at(trial, reach);
        let blocked = body.is_some_and(|(_, depth)| depth > 0.0);
        if blocked || self.room != ExclusionRule::Grains {
            return !blocked;
        }
        let home = self.cell(trial);
        let around = |axis: usize| {
            let (centre, count) = (home[axis], self.counts[axis]);
            let reach = if count < 3 {
                0..count
            } else {
                centre + count - 1..centre + count + 2
            };
            reach.map(move |cell| cell % count)
        };
        around(2).all(|z| {
            around(1).all(|y| {
                around(0).all(|x| {
                    let cell = &self.cells[self.number([x, y, z])];
                    cell.iter().all(|&(other, far)| {
                        let apart = self.confinement.domain.displacement(trial, other);
                        apart.square() > (radius + far).powi(2)
                    })
                })
            })
        })
    }
}
