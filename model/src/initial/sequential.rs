//! Random sequential addition: disks are placed one by one at random positions without overlap.

use nalgebra::{Vector2, vector};
use rand::{Rng, RngExt};

use crate::domain::Domain;
use crate::interrupt::Interrupt;
use crate::space::Plane;

/// Packing fraction up to which random sequential addition is used. It jams at 0.547 (Feder 1980);
/// at 0.45 about a hundred trials a disk are needed.
pub const SEQUENTIAL_LIMIT: f64 = 0.45;

/// Places equal disks one by one at uniformly random positions where they overlap no other; `None`
/// if a disk finds no position in 10^6 trials (a small box may jam early), or if interrupted.
pub fn sequential_addition(
    count: usize,
    diameter: f64,
    domain: &Domain<Plane>,
    stream: &mut impl Rng,
    interrupt: &Interrupt,
) -> Option<Vec<Vector2<f64>>> {
    place_in_order(&vec![0.5 * diameter; count], domain, stream, interrupt)
}

/// Places disks of the given radii one by one at random positions without overlap: large disks
/// first, which would find no room among small ones. Returns positions in the order of the radii;
/// `None` if a disk finds no room.
pub fn sequential_addition_of(
    radii: &[f64],
    domain: &Domain<Plane>,
    stream: &mut impl Rng,
    interrupt: &Interrupt,
) -> Option<Vec<Vector2<f64>>> {
    let mut order: Vec<usize> = (0..radii.len()).collect();
    order.sort_by(|&a, &b| radii[b].total_cmp(&radii[a]));
    let sorted: Vec<f64> = order.iter().map(|&index| radii[index]).collect();
    let found = place_in_order(&sorted, domain, stream, interrupt)?;
    let mut positions = vec![Vector2::zeros(); radii.len()];
    for (index, position) in order.into_iter().zip(found) {
        positions[index] = position;
    }
    Some(positions)
}

/// Places disks one by one at random positions without overlap, in the order of `radii`; `None` if
/// one finds no room, or if interrupted.
fn place_in_order(
    radii: &[f64],
    domain: &Domain<Plane>,
    stream: &mut impl Rng,
    interrupt: &Interrupt,
) -> Option<Vec<Vector2<f64>>> {
    const MOST_TRIALS: usize = 1_000_000;
    let count = radii.len();
    let diameter = 2.0
        * radii
            .iter()
            .fold(0.0, |most: f64, &radius| most.max(radius));
    let lengths = domain.lengths();
    // Cells about as wide as a diameter, but never many more than disks.
    let most = (2.0 * count as f64).sqrt().ceil() as usize + 1;
    let cells = [0, 1].map(|axis| ((lengths[axis] / diameter).floor() as usize).clamp(1, most));
    let cell_of = |position: Vector2<f64>| {
        [0, 1].map(|axis| {
            let cell = (position[axis] / lengths[axis] * cells[axis] as f64) as usize;
            cell.min(cells[axis] - 1)
        })
    };
    let mut grid: Vec<Vec<u32>> = vec![Vec::new(); cells[0] * cells[1]];
    let mut positions: Vec<Vector2<f64>> = Vec::with_capacity(count);
    let mut trials = 0;
    for (index, radius) in radii.iter().enumerate() {
        let mut place = None;
        for _ in 0..MOST_TRIALS {
            trials += 1;
            if interrupt.is_raised_at(trials) {
                return None;
            }
            let trial = vector![
                stream.random::<f64>() * lengths[0],
                stream.random::<f64>() * lengths[1]
            ];
            let [x, y] = cell_of(trial);
            let neighbours = |centre: usize, size: usize| {
                let reach = if size < 3 {
                    0..size
                } else {
                    centre + size - 1..centre + size + 2
                };
                reach.map(move |cell| cell % size)
            };
            let free = neighbours(y, cells[1]).all(|row| {
                neighbours(x, cells[0]).all(|column| {
                    grid[row * cells[0] + column].iter().all(|&other| {
                        let other = other as usize;
                        domain.distance(trial, positions[other]) > radius + radii[other]
                    })
                })
            });
            if free {
                place = Some((trial, y * cells[0] + x));
                break;
            }
        }
        let (position, cell) = place?;
        grid[cell].push(index as u32);
        positions.push(position);
    }
    Some(positions)
}

#[cfg(test)]
mod tests {
    use std::convert::Infallible;

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
            let found = sequential_addition(count, 1.0, &domain, &mut stream, &interrupt);
            assert!(interrupt.is_raised(), "{count} disks were placed before");
            assert!(found.is_none());
            // Each trial draws two numbers.
            assert!(stream.after <= 2 * 1024, "{}", stream.after);
        }
    }
}
