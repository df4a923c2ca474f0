//! Fields of a flow on a grid: density, velocity, temperatures, pressure and collision rate, with
//! standard errors.
//!
//! Particles are summed into cells at sample times, and collisions as they happen. The run is cut
//! into **blocks** of equal time, and everything is kept for each block, so that a window of time
//! can be chosen afterwards: from when the flow is steady ([`crate::steady`]), or a moment of its
//! development. A field is a quotient of sums over the window. Its standard error is that of blocks
//! that are longer than the flow remembers, and at least that of the replicas
//! ([`crate::time_average`]).
//!
//! Densities and pressures are of the part of a cell in which centres of particles can be, which
//! obstacles make smaller. Wholly covered cells have zeros.
//!
//! The velocity that is subtracted in a temperature is that of the cell over the whole window: that
//! of one sample would hide a part 1/n of the thermal motion, n being the number of particles in
//! the cell.

use std::ops::Range;

use serde::{Deserialize, Serialize};
use stosszahl_model::InvalidValue;
use stosszahl_model::sum::SparseSums;

use crate::Error;
use crate::time_average::TimeErrors;

/// Grid of cells over the first two axes of a box; cells extend over the whole third axis.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct FieldGrid {
    lengths: [f64; 2],
    counts: [usize; 2],
    depth: f64,
}

impl FieldGrid {
    /// Creates a grid of `counts` cells along the sides `lengths` of a box of a `depth` (1 in the
    /// plane).
    ///
    /// # Errors
    /// [`Error::Invalid`] unless all are positive and finite.
    pub fn new(lengths: [f64; 2], counts: [usize; 2], depth: f64) -> Result<Self, Error> {
        for side in [lengths[0], lengths[1], depth] {
            InvalidValue::unless_positive("side of the box of a field", side)?;
        }
        for count in counts {
            let name = "number of cells of a field along an axis";
            InvalidValue::require(count > 0, name, 0.0, "at least 1")?;
        }
        Ok(Self {
            lengths,
            counts,
            depth,
        })
    }

    /// Returns the number of cells along each axis.
    pub fn counts(&self) -> [usize; 2] {
        self.counts
    }

    /// Returns the number of cells of the grid.
    pub fn cells(&self) -> usize {
        self.counts[0] * self.counts[1]
    }

    /// Returns the side lengths of a cell along both axes \[length\].
    pub fn width(&self) -> [f64; 2] {
        [0, 1].map(|axis| self.lengths[axis] / self.counts[axis] as f64)
    }

    /// Returns the volume of a cell: its area times the depth of the box \[length^D\].
    pub fn cell_volume(&self) -> f64 {
        let [x, y] = self.width();
        x * y * self.depth
    }

    /// Returns the centre of the cell with a given index \[length\]; the index runs fastest along
    /// the first axis.
    pub fn centre(&self, cell: usize) -> [f64; 2] {
        let [x, y] = self.width();
        let column = cell % self.counts[0];
        let row = cell / self.counts[0];
        [(column as f64 + 0.5) * x, (row as f64 + 0.5) * y]
    }

    /// Returns the index of the cell that contains a position. Positions that rounding puts outside
    /// the box belong to the cell at the edge.
    #[inline]
    pub fn cell(&self, x: f64, y: f64) -> usize {
        let place = |axis: usize, at: f64| {
            let count = self.counts[axis];
            ((at / self.lengths[axis] * count as f64).max(0.0) as usize).min(count - 1)
        };
        place(0, x) + self.counts[0] * place(1, y)
    }
}

/// Particle as seen by the field sums: position, velocity, mass, rotational energy and weight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sighting {
    /// Position of the particle along the first two axes \[length\].
    pub position: [f64; 2],
    /// Velocity of the particle \[length/time\]; zero beyond the dimension.
    pub velocity: [f64; 3],
    /// Mass of the particle \[mass\].
    pub mass: f64,
    /// Twice the rotational energy of the particle, I w^2 \[energy\].
    pub twice_spin_energy: f64,
    /// Weight: number of particles of the gas that the particle stands for.
    pub weight: f64,
}

/// Sums over the particles of one species in one cell and time block.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct CellSums {
    number: f64,
    mass: f64,
    momentum: [f64; 3],
    /// Sum of m v² over the particles \[energy\].
    square: f64,
    /// Sum of I w² over the particles, twice the rotational energy \[energy\].
    spin: f64,
}

impl CellSums {
    #[inline]
    fn add(&mut self, particle: &Sighting) {
        let Sighting {
            velocity,
            mass,
            weight,
            twice_spin_energy,
            ..
        } = *particle;
        let heavy = mass * weight;
        self.number += weight;
        self.mass += heavy;
        for (sum, component) in self.momentum.iter_mut().zip(velocity) {
            *sum += heavy * component;
        }
        self.square += heavy * velocity.iter().map(|v| v * v).sum::<f64>();
        self.spin += twice_spin_energy * weight;
    }

    fn merge(&mut self, other: &Self) {
        self.number += other.number;
        self.mass += other.mass;
        for (sum, more) in self.momentum.iter_mut().zip(other.momentum) {
            *sum += more;
        }
        self.square += other.square;
        self.spin += other.spin;
    }
}

/// Sums over the collisions in one cell and time block.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
struct Contacts {
    /// Number of pair collisions.
    count: f64,
    /// Sum over collisions of the transferred momentum times the centre distance \[energy\].
    virial: f64,
}

/// Sums over one run from which fields are computed, by time block, species and cell.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FieldSums {
    grid: FieldGrid,
    species: usize,
    /// Duration of a time block \[time\]; block b ends at (b + 1) times this duration.
    block: f64,
    samples: Vec<u64>,
    sums: Vec<CellSums>,
    contacts: Vec<Contacts>,
}

/// Sums over all particles at one time, by species and cell. Particles come in the groups of
/// [`stosszahl_model::sum`].
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct FieldSample {
    grid: FieldGrid,
    parts: SparseSums<CellSums>,
}

impl FieldSample {
    /// Adds a particle of a species to the sums of its cell, within the particle group that
    /// [`Self::close`] ends.
    #[inline]
    pub fn add(&mut self, species: usize, particle: &Sighting) {
        let [x, y] = particle.position;
        let place = species * self.grid.cells() + self.grid.cell(x, y);
        self.parts.sum_at(place).add(particle);
    }

    /// Ends the group of particles added since the last call; `group` is its number in the sums of
    /// [`stosszahl_model::sum`].
    pub fn close(&mut self, group: u32) {
        self.parts.close(group);
    }

    /// Adds the sums over the particles of another sample.
    pub fn merge(&mut self, other: Self) {
        self.parts.merge(other.parts);
    }
}

/// Degrees of freedom of a particle: numbers of velocity and spin components.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Freedom {
    /// Number of velocity components.
    pub dimension: usize,
    /// Number of spin components; 0 for smooth particles.
    pub rotations: usize,
}

/// Values of all fields in one cell or one set of cells.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Values {
    /// Number density: particles per free volume (area in the plane) \[1/length^D\].
    pub number_density: f64,
    /// Mean velocity of the cell, weighted with the masses \[length/time\].
    pub velocity: [f64; 3],
    /// Translational temperature, m <(v - u)^2>/D \[energy\].
    pub temperature: f64,
    /// Temperature of rotation, I <w^2> over the number of spin components \[energy\]; the mean
    /// spin is part of it.
    pub spin_temperature: f64,
    /// Pressure of the cell: n T + (momentum transferred in collisions)/(D V) \[energy/length^D\].
    pub pressure: f64,
    /// Collisions per particle and time \[1/time\].
    pub collision_rate: f64,
}

impl Values {
    /// Returns the eight field values as an array, for arithmetic.
    pub fn list(&self) -> [f64; 8] {
        let [u, v, w] = self.velocity;
        [
            self.number_density,
            u,
            v,
            w,
            self.temperature,
            self.spin_temperature,
            self.pressure,
            self.collision_rate,
        ]
    }

    fn from_list(list: [f64; 8]) -> Self {
        let [n, u, v, w, t, r, p, c] = list;
        Self {
            number_density: n,
            velocity: [u, v, w],
            temperature: t,
            spin_temperature: r,
            pressure: p,
            collision_rate: c,
        }
    }
}

/// Mean fields of one set of cells over a time window, with their standard errors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeasuredFields {
    /// Mean fields of the set of cells.
    pub values: Values,
    /// Standard errors of the fields; NaN if fewer than two time blocks have particles in the set
    /// of cells.
    pub errors: Values,
}

/// Mean fields of several sets of cells over a time window, with errors.
#[derive(Clone, Debug, PartialEq)]
pub struct FieldAverages {
    /// Mean fields of each set of cells, in the order of the sets.
    pub places: Vec<MeasuredFields>,
    /// Number of independent parts into which the runs were cut for the error of each field, in the
    /// order of [`Values::list`]; see [`TimeErrors::parts`].
    pub parts: [usize; 8],
}

/// Choice of the cells that are averaged together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CellAveraging {
    /// Every cell is a set of its own.
    Cells,
    /// Profile along x: all cells with equal first coordinate are a set.
    X,
    /// Profile along y: all cells with equal second coordinate are a set.
    Y,
}

impl FieldSums {
    /// Creates empty sums for `blocks` blocks of the given length of time.
    ///
    /// # Errors
    /// [`Error::Invalid`] without a species, a block, or a positive length of time.
    pub fn new(grid: FieldGrid, species: usize, blocks: usize, block: f64) -> Result<Self, Error> {
        InvalidValue::unless_positive("length of a block", block)?;
        for (quantity, found) in [("number of species", species), ("number of blocks", blocks)] {
            InvalidValue::require(found > 0, quantity, 0.0, "at least 1")?;
        }
        Ok(Self {
            grid,
            species,
            block,
            samples: vec![0; blocks],
            sums: vec![CellSums::default(); blocks * species * grid.cells()],
            contacts: vec![Contacts::default(); blocks * grid.cells()],
        })
    }

    /// Returns the grid of cells of the sums.
    pub fn grid(&self) -> &FieldGrid {
        &self.grid
    }

    /// Returns the number of species with sums of their own.
    pub fn species(&self) -> usize {
        self.species
    }

    /// Returns the number of time blocks.
    pub fn blocks(&self) -> usize {
        self.samples.len()
    }

    /// Returns an empty sample for the particles at one time, to be filled and added.
    pub fn sample(&self) -> FieldSample {
        FieldSample {
            grid: self.grid,
            parts: SparseSums::new(self.species * self.grid.cells()),
        }
    }

    /// Adds the particle sums of one sample time to a time block.
    pub fn add_sample(&mut self, block: usize, sample: FieldSample) {
        let Some(samples) = self.samples.get_mut(block) else {
            return;
        };
        *samples += 1;
        let places = self.species * self.grid.cells();
        let sums = &mut self.sums[block * places..][..places];
        sample.parts.in_order(|place, part| sums[place].merge(part));
    }

    /// Adds a collision, given its time, position \[length\] and virial \[energy\]; it stands for
    /// `weight` collisions.
    #[inline]
    pub fn collision(&mut self, time: f64, position: [f64; 2], virial: f64, weight: f64) {
        let block = ((time / self.block).max(0.0) as usize).min(self.samples.len() - 1);
        let place = block * self.grid.cells() + self.grid.cell(position[0], position[1]);
        let contacts = &mut self.contacts[place];
        contacts.count += weight;
        contacts.virial += weight * virial;
    }

    /// Adds up the sums of a set of cells over some time blocks, for one species or for all.
    fn gather(
        &self,
        blocks: Range<usize>,
        species: Option<usize>,
        cells: &[usize],
        free_shares: &[f64],
    ) -> Gathered {
        let share = |cell: &usize| free_shares.get(*cell).copied().unwrap_or(1.0);
        let mut all = Gathered {
            volume: self.grid.cell_volume() * cells.iter().map(share).sum::<f64>(),
            ..Gathered::default()
        };
        let count = self.grid.cells();
        for block in blocks {
            all.samples += self.samples[block];
            all.duration += self.block;
            for kind in 0..self.species {
                if species.is_some_and(|wanted| wanted != kind) {
                    continue;
                }
                let first = (block * self.species + kind) * count;
                for &cell in cells {
                    all.sums.merge(&self.sums[first + cell]);
                }
            }
            for &cell in cells {
                let contacts = &self.contacts[block * count + cell];
                all.contacts.count += contacts.count;
                all.contacts.virial += contacts.virial;
            }
        }
        all
    }
}

/// Averages of fields over replicas and a time window.
#[derive(Clone, Debug)]
pub struct ParticleAverages<'a> {
    /// Sums of each replica of the run.
    pub replicas: &'a [&'a FieldSums],
    /// Index range of the time blocks in the window.
    pub blocks: Range<usize>,
    /// Numbers of velocity and spin components of the particles.
    pub freedom: Freedom,
    /// Free share of each cell, in which centres of particles can be; densities are per free
    /// volume. Empty if all cells are free.
    pub free_shares: &'a [f64],
}

impl ParticleAverages<'_> {
    /// Averages the fields of one species, or of all together. For one species, pressure and
    /// collision rate are zero, since collisions are counted for all species.
    pub fn fields(&self, species: Option<usize>, along: CellAveraging) -> FieldAverages {
        let groups = self.groups(along);
        let totals: Vec<Gathered> = (groups.iter())
            .map(|cells| self.total(species, cells))
            .collect();
        let all = species.is_none();
        let values: Vec<Values> = (totals.iter())
            .map(|total| total.values(total.drift(), self.freedom, all))
            .collect();
        let lists: Vec<[f64; 8]> = values.iter().map(Values::list).collect();
        let found = TimeErrors::new(self.size(), &lists, |place, replica, blocks| {
            let part = self.part(replica, blocks, species, &groups[place])?;
            // Noise of the velocity of a single block must not count as noise of the temperature.
            let mut list = part.values(totals[place].drift(), self.freedom, all).list();
            // Without a particle only the density is defined.
            if list[0] <= 0.0 {
                list[1..].fill(f64::NAN);
            }
            Some(list)
        });
        let both = values.into_iter().zip(&found.standard_errors);
        FieldAverages {
            places: both
                .map(|(values, errors)| MeasuredFields {
                    values,
                    errors: Values::from_list(*errors),
                })
                .collect(),
            parts: found.parts,
        }
    }

    /// Computes numbers derived from the fields of some cells, with standard errors. They are
    /// computed from the sums of all replicas and blocks, and again block by block.
    pub fn derived<const N: usize>(
        &self,
        cells: &[usize],
        of: impl Fn(&[Values]) -> [f64; N],
    ) -> ([f64; N], TimeErrors<N>) {
        let totals: Vec<Gathered> = (cells.iter())
            .map(|&cell| self.total(None, &[cell]))
            .collect();
        let values = |parts: &[Gathered]| -> Vec<Values> {
            let both = parts.iter().zip(&totals);
            both.map(|(part, total)| part.values(total.drift(), self.freedom, true))
                .collect()
        };
        let found = of(&values(&totals));
        let errors = TimeErrors::new(self.size(), &[found], |_, replica, blocks| {
            let parts: Option<Vec<Gathered>> = (cells.iter())
                .map(|&cell| self.part(replica, blocks.clone(), None, &[cell]))
                .collect();
            Some(of(&values(&parts?)))
        });
        (found, errors)
    }

    /// Returns the number of replicas and the number of time blocks in the window.
    fn size(&self) -> [usize; 2] {
        [self.replicas.len(), self.blocks.len()]
    }

    /// Returns the sets of cells over which fields are averaged.
    fn groups(&self, along: CellAveraging) -> Vec<Vec<usize>> {
        let Some(first) = self.replicas.first() else {
            return Vec::new();
        };
        let [columns, rows] = first.grid.counts;
        match along {
            CellAveraging::Cells => (0..columns * rows).map(|cell| vec![cell]).collect(),
            CellAveraging::X => (0..columns)
                .map(|x| (0..rows).map(|y| x + columns * y).collect())
                .collect(),
            CellAveraging::Y => (0..rows)
                .map(|y| (0..columns).map(|x| x + columns * y).collect())
                .collect(),
        }
    }

    /// Adds up the sums of some cells over all replicas and all time blocks of the window.
    fn total(&self, species: Option<usize>, cells: &[usize]) -> Gathered {
        let mut total = Gathered::default();
        for replica in self.replicas {
            let blocks = self.blocks.clone();
            total.merge(&replica.gather(blocks, species, cells, self.free_shares));
        }
        total
    }

    /// Adds up the sums of some cells over some time blocks of one replica; `None` without a
    /// sample.
    fn part(
        &self,
        replica: usize,
        blocks: Range<usize>,
        species: Option<usize>,
        cells: &[usize],
    ) -> Option<Gathered> {
        let first = self.blocks.start;
        let blocks = first + blocks.start..first + blocks.end;
        let part = self.replicas[replica].gather(blocks, species, cells, self.free_shares);
        (part.samples > 0).then_some(part)
    }
}

#[derive(Clone, Copy, Debug, Default)]
struct Gathered {
    samples: u64,
    duration: f64,
    volume: f64,
    sums: CellSums,
    contacts: Contacts,
}

impl Gathered {
    fn merge(&mut self, other: &Self) {
        self.samples += other.samples;
        self.duration += other.duration;
        self.volume = other.volume;
        self.sums.merge(&other.sums);
        self.contacts.count += other.contacts.count;
        self.contacts.virial += other.contacts.virial;
    }

    fn drift(&self) -> [f64; 3] {
        if self.sums.mass > 0.0 {
            self.sums.momentum.map(|p| p / self.sums.mass)
        } else {
            [0.0; 3]
        }
    }

    /// Computes the fields from the sums, with temperatures relative to the velocity `about`.
    fn values(&self, about: [f64; 3], freedom: Freedom, with_collisions: bool) -> Values {
        let CellSums {
            number,
            mass,
            momentum,
            square,
            spin,
        } = self.sums;
        if self.samples == 0 || number <= 0.0 || self.volume <= 0.0 {
            return Values::default();
        }
        let per_sample = number / self.samples as f64;
        let mut thermal = square;
        for (p, u) in momentum.iter().zip(about) {
            thermal += mass * u * u - 2.0 * p * u;
        }
        let temperature = thermal / (freedom.dimension as f64 * number);
        let number_density = per_sample / self.volume;
        let mut values = Values {
            number_density,
            velocity: self.drift(),
            temperature,
            spin_temperature: if freedom.rotations > 0 {
                spin / (freedom.rotations as f64 * number)
            } else {
                0.0
            },
            ..Values::default()
        };
        if with_collisions && self.duration > 0.0 {
            let rate = 1.0 / self.duration;
            values.collision_rate = 2.0 * self.contacts.count * rate / per_sample;
            values.pressure = number_density * temperature
                + self.contacts.virial * rate / (freedom.dimension as f64 * self.volume);
        }
        values
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};
    use rand_xoshiro::Xoshiro256PlusPlus;

    /// A drifting Maxwellian whose density and temperature rise along x: fields lie within z = 4.4
    /// of the true ones, with the measured error. That error is the true one, to 20 %, and small
    /// enough to see a change of 3 %.
    #[test]
    fn fields_are_what_was_put_in() {
        let mut stream = Xoshiro256PlusPlus::seed_from_u64(1);
        let grid = FieldGrid::new([4.0, 2.0], [4, 1], 0.5).expect("a grid");
        let blocks = 40;
        let mut fields = FieldSums::new(grid, 2, blocks, 1.0).expect("fields");
        let mut normal = || -> f64 { StandardNormal.sample(&mut stream) };
        for block in 0..blocks {
            for _ in 0..10 {
                let mut sample = fields.sample();
                for column in 0..4 {
                    let temperature = f64::from(1 + column);
                    for number in 0..20 * (1 + column) {
                        let species = number as usize % 2;
                        let mass = 1.0 + species as f64;
                        let spread = (temperature / mass).sqrt();
                        let velocity = [3.0 + spread * normal(), spread * normal(), 0.0];
                        sample.add(
                            species,
                            &Sighting {
                                position: [f64::from(column) + 0.5, 1.0],
                                velocity,
                                mass,
                                twice_spin_energy: 0.5 * temperature * normal().powi(2),
                                weight: 2.0,
                            },
                        );
                    }
                }
                sample.close(0);
                fields.add_sample(block, sample);
            }
            // Each particle collides twice: 40 (1 + column) particles, so as many collisions.
            for column in 0..4 {
                let at = [f64::from(column) + 0.5, 0.3];
                for _ in 0..40 * (1 + column) {
                    fields.collision(block as f64 + 0.5, at, 0.25, 1.0);
                }
            }
        }
        let freedom = Freedom {
            dimension: 2,
            rotations: 1,
        };
        let averages = ParticleAverages {
            replicas: &[&fields],
            blocks: 0..blocks,
            freedom,
            free_shares: &[],
        };
        let found = averages.fields(None, CellAveraging::X).places;
        assert_eq!(found.len(), 4);
        let total = fields.blocks() * 10;
        for (column, cell) in found.iter().enumerate() {
            let level = (1 + column) as f64;
            let errors = cell.errors;
            let n = total as f64 * 20.0 * level;
            let expected = Values {
                number_density: 40.0 * level,
                velocity: [3.0, 0.0, 0.0],
                temperature: level,
                spin_temperature: 0.5 * level,
                pressure: 40.0 * level * level + 0.25 * 40.0 * level / 2.0,
                collision_rate: 2.0,
            };
            let pairs = cell.values.list().into_iter().zip(expected.list());
            for (index, (found, expected)) in pairs.enumerate() {
                let error = errors.list()[index].max(1e-12 * expected.abs());
                assert!(
                    (found - expected).abs() <= 4.4 * error,
                    "{column} {index}: {found} {expected} {error}"
                );
            }
            // 2n squares of variance 2 T^2, with 40 blocks known to 1/sqrt(78) = 11 %.
            let true_error = level * (1.0 / n).sqrt();
            assert!((errors.temperature / true_error - 1.0).abs() < 0.5);
            assert!(errors.temperature < 0.03 * level);
        }
        let heavy = averages.fields(Some(1), CellAveraging::Cells).places;
        assert!((heavy[2].values.temperature / 3.0 - 1.0).abs() < 0.05);
        assert!((heavy[2].values.number_density / 60.0 - 1.0).abs() < 1e-12);

        // Density and pressure are of the free part of a cell, and nothing else is.
        let half = ParticleAverages {
            free_shares: &[0.5; 4],
            ..averages.clone()
        };
        let halves = half.fields(None, CellAveraging::X).places;
        for (free, all) in halves.iter().zip(&found) {
            for (index, factor) in [2.0, 1.0, 1.0, 1.0, 1.0, 1.0, 2.0, 1.0]
                .into_iter()
                .enumerate()
            {
                let [free, all] = [free, all].map(|one| [one.values, one.errors]);
                for (free, all) in free.into_iter().zip(all) {
                    assert_eq!(free.list()[index], factor * all.list()[index], "{index}");
                }
            }
        }
        // A number that is a field of one cell has the error of that cell.
        let (numbers, errors) = averages.derived(&[1], |cells| [cells[0].temperature]);
        assert_eq!(numbers, [found[1].values.temperature]);
        assert_eq!(errors.standard_errors, [[found[1].errors.temperature]]);
    }

    #[test]
    fn empty_cells_and_edges() {
        let grid = FieldGrid::new([1.0, 1.0], [2, 2], 1.0).expect("a grid");
        assert_eq!(grid.cell(1.0, 1.0), 3);
        assert_eq!(grid.cell(-1e-17, 0.75), 2);
        assert_eq!(grid.centre(1), [0.75, 0.25]);
        assert!(FieldGrid::new([1.0, 0.0], [1, 1], 1.0).is_err());
        assert!(FieldGrid::new([1.0, 1.0], [0, 1], 1.0).is_err());
        assert!(FieldSums::new(grid, 1, 0, 1.0).is_err());
        let fields = FieldSums::new(grid, 1, 3, 1.0).expect("fields");
        let freedom = Freedom {
            dimension: 2,
            rotations: 0,
        };
        let averages = ParticleAverages {
            replicas: &[&fields],
            blocks: 0..3,
            freedom,
            free_shares: &[],
        };
        let found = averages.fields(None, CellAveraging::Cells).places;
        assert_eq!(found[0].values, Values::default());
        assert!(found[0].errors.list().iter().all(|error| error.is_nan()));
        // Collision beyond the last block by rounding.
        let mut late = fields;
        late.collision(3.0 + 1e-12, [0.0, 0.0], 1.0, 1.0);
    }
}
