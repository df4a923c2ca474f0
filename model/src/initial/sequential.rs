//! Random sequential addition: particles are placed one by one at random positions without overlap.

use std::ops::Range;

use nalgebra::Vector2;
use rand::{Rng, RngExt};

use crate::domain::Domain;
use crate::interrupt::Interrupt;
use crate::space::{Plane, Space, Vector as _};

/// Packing fraction up to which random sequential addition is used. It jams at 0.547 (Feder 1980);
/// at 0.45 about a hundred trials a disk are needed.
pub const SEQUENTIAL_LIMIT: f64 = 0.45;

/// Largest number of trial positions for placing one particle.
const MOST_TRIALS: usize = 1_000_000;

/// Part of a box in which the centres of particles may lie.
pub trait FreeSpace<S: Space> {
    /// Returns the range of a particle's centre along an axis \[length\].
    fn centre_range(&self, axis: usize, radius: f64) -> [f64; 2];

    /// Returns true if a particle at `centre` is outside all obstacles.
    fn is_free(&self, centre: S::Vector, radius: f64) -> bool;
}

/// Whole box as free space.
impl<S: Space> FreeSpace<S> for Domain<S> {
    fn centre_range(&self, axis: usize, _radius: f64) -> [f64; 2] {
        [0.0, self.lengths()[axis]]
    }

    fn is_free(&self, _centre: S::Vector, _radius: f64) -> bool {
        true
    }
}

/// Error of random sequential addition.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum AdditionError {
    /// A particle finds no position; a small box may jam early.
    #[error("particle {particle} finds no place in {trials} trials")]
    Jammed {
        /// Index of the particle that finds no position.
        particle: usize,
        /// Number of random positions tried.
        trials: usize,
    },
    /// The placement was interrupted.
    #[error("stopped")]
    Interrupted,
}

/// Random sequential addition of particles with given radii in the free space of a box.
pub struct SequentialAddition<'a, S: Space> {
    /// Number of particles to place.
    pub count: usize,
    /// Radius of each particle by its index \[length\].
    pub radius: &'a dyn Fn(usize) -> f64,
    /// Box of the particles.
    pub domain: &'a Domain<S>,
    /// Part of the box in which centres may lie.
    pub space: &'a dyn FreeSpace<S>,
    /// True if particles must not overlap each other.
    pub excludes: bool,
}

impl<S: Space> SequentialAddition<'_, S> {
    /// Draws a position for each particle and hands it to `look` with the index of the particle.
    /// The largest particles come first: they would find no place among small ones.
    ///
    /// # Errors
    /// [`AdditionError`] if a particle finds no place in 10^6 trials, or after an interrupt.
    pub fn place_all(
        &self,
        stream: &mut impl Rng,
        interrupt: &Interrupt,
        look: &mut dyn FnMut(usize, S::Vector),
    ) -> Result<(), AdditionError> {
        let mut placed = PlacedParticles::new(self);
        for run in self.runs() {
            for index in run {
                look(
                    index,
                    self.find_place(index, &mut placed, stream, interrupt)?,
                );
            }
        }
        Ok(())
    }

    /// Returns the runs of consecutive particles of one radius, the largest first.
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

    fn find_place(
        &self,
        particle: usize,
        placed: &mut PlacedParticles<S>,
        stream: &mut impl Rng,
        interrupt: &Interrupt,
    ) -> Result<S::Vector, AdditionError> {
        let radius = (self.radius)(particle);
        for _ in 0..MOST_TRIALS {
            placed.trials += 1;
            if interrupt.is_raised_at(placed.trials) {
                return Err(AdditionError::Interrupted);
            }
            let mut trial = S::Vector::default();
            for axis in 0..S::DIMENSION {
                let [low, high] = self.space.centre_range(axis, radius);
                trial[axis] = low + (high - low) * stream.random::<f64>();
            }
            let is_free = self.space.is_free(trial, radius);
            if is_free && !self.excludes {
                return Ok(trial);
            }
            if is_free && placed.has_room(trial, radius) {
                placed.add(trial, radius);
                return Ok(trial);
            }
        }
        Err(AdditionError::Jammed {
            particle,
            trials: MOST_TRIALS,
        })
    }
}

/// Particles placed so far, in a cell list.
struct PlacedParticles<S: Space> {
    domain: Domain<S>,
    counts: [usize; 3],
    cells: Vec<Vec<(S::Vector, f64)>>,
    trials: u64,
}

impl<S: Space> PlacedParticles<S> {
    fn new(addition: &SequentialAddition<'_, S>) -> Self {
        let (count, size) = (addition.count, addition.domain.lengths());
        let largest = (0..count).map(addition.radius).fold(0.0, f64::max);
        // Cells as fine as a diameter, but not many more than particles.
        let most = (2.0 * count as f64).powf(1.0 / S::DIMENSION as f64).ceil() as usize + 1;
        let counts = [0, 1, 2].map(|axis| {
            if axis < S::DIMENSION && addition.excludes && largest > 0.0 {
                ((size[axis] / (2.0 * largest)).floor() as usize).clamp(1, most)
            } else {
                1
            }
        });
        Self {
            domain: *addition.domain,
            counts,
            cells: vec![Vec::new(); counts.iter().product()],
            trials: 0,
        }
    }

    fn cell(&self, position: S::Vector) -> [usize; 3] {
        [0, 1, 2].map(|axis| {
            if axis < S::DIMENSION {
                let share = position[axis] / self.domain.lengths()[axis];
                ((share * self.counts[axis] as f64) as usize).min(self.counts[axis] - 1)
            } else {
                0
            }
        })
    }

    fn number(&self, [x, y, z]: [usize; 3]) -> usize {
        x + self.counts[0] * (y + self.counts[1] * z)
    }

    fn add(&mut self, position: S::Vector, radius: f64) {
        let cell = self.number(self.cell(position));
        self.cells[cell].push((position, radius));
    }

    /// Returns true if a particle at `trial` overlaps none of those placed so far.
    fn has_room(&self, trial: S::Vector, radius: f64) -> bool {
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
                        let apart = self.domain.displacement(trial, other);
                        apart.square() > (radius + far).powi(2)
                    })
                })
            })
        })
    }
}

/// Places disks of given radii one by one at random positions in a periodic box where they overlap
/// no other. Returns positions in the order of the radii.
///
/// # Errors
/// As [`SequentialAddition::place_all`].
pub fn sequential_addition(
    radii: &[f64],
    domain: &Domain<Plane>,
    stream: &mut impl Rng,
    interrupt: &Interrupt,
) -> Result<Vec<Vector2<f64>>, AdditionError> {
    let mut positions = vec![Vector2::zeros(); radii.len()];
    let addition = SequentialAddition {
        count: radii.len(),
        radius: &|index| radii[index],
        domain,
        space: domain,
        excludes: true,
    };
    addition.place_all(stream, interrupt, &mut |index, at| positions[index] = at)?;
    Ok(positions)
}

#[cfg(test)]
mod tests {
    use std::convert::Infallible;

    use nalgebra::vector;
    use rand::{SeedableRng, TryRng};

    use super::*;
    use crate::random::Stream;

    /// Random numbers, one of which raises an interrupt.
    struct Raising {
        stream: Stream,
        left: u64,
        after: u64,
        interrupt: Interrupt,
    }

    impl TryRng for Raising {
        type Error = Infallible;

        fn try_next_u32(&mut self) -> Result<u32, Infallible> {
            Ok(self.try_next_u64()? as u32)
        }

        fn try_next_u64(&mut self) -> Result<u64, Infallible> {
            if self.left == 0 {
                self.interrupt.raise();
                self.after += 1;
            }
            self.left = self.left.saturating_sub(1);
            self.stream.try_next_u64()
        }

        fn try_fill_bytes(&mut self, bytes: &mut [u8]) -> Result<(), Infallible> {
            self.stream.try_fill_bytes(bytes)
        }
    }

    /// Placement ends some thousand trials after it is asked to, also while one disk finds no
    /// place.
    #[test]
    fn it_ends_soon_after_an_interrupt() {
        let domain = Domain::<Plane>::periodic(vector![100.0, 100.0]).expect("a box");
        for count in [6000, 9000] {
            let interrupt = Interrupt::default();
            let mut stream = Raising {
                stream: Stream::seed_from_u64(1),
                left: 30_000,
                after: 0,
                interrupt: interrupt.clone(),
            };
            let found = sequential_addition(&vec![0.5; count], &domain, &mut stream, &interrupt);
            assert!(interrupt.is_raised(), "{count} disks were placed before");
            assert_eq!(found, Err(AdditionError::Interrupted));
            // Each trial draws two numbers.
            assert!(stream.after <= 2 * 1024, "{}", stream.after);
        }
    }
}
