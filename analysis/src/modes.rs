//! Density and velocity amplitudes of single Fourier modes by direct sums, for the noise of a gas
//! and the growth or decay of its shear waves.
//!
//! For N points with velocities `v_j` and the wave vector k of the periodic box, the amplitudes are
//!
//! ```text
//! rho(k) = Σ_j exp(-i k · r_j),   p(k) = Σ_j v_j exp(-i k · r_j)
//! ```
//!
//! and p is split along k (longitudinal: sound) and across it (transverse: shear). Divided by N and
//! the temperature over mass T, the squared amplitudes are 1 on average in thermal equilibrium, at
//! every k, whatever the density does: velocities are independent of places. That holds to 1/N;
//! [`equilibrium_energy`] has the rest.
//!
//! # Design
//!
//! Each point's phases along the two axes are raised to the powers that the modes ask for by
//! repeated multiplication, so a mode costs one complex product and three sums a point, and no
//! sine. The powers round by some 1e-16 each, a few 1e-15 at the tenth. A density lattice and a
//! fast Fourier transform, as in [`structure_factor`](crate::structure_factor), lost: it would have
//! a window and aliasing to correct, and a few hundred modes are all that a test of noise wants.

use std::f64::consts::TAU;

use nalgebra::{Vector2, vector};
use rustfft::num_complex::Complex;
use serde::{Deserialize, Serialize};
use stosszahl_model::sum::Totals;
use stosszahl_model::{Particle, ParticleReduction};

use crate::Error;
use crate::error::{Seen, check_lengths, check_positions};

/// Largest magnitude of a reciprocal index.
pub const LARGEST_INDEX: u32 = 10_000;

/// Number of points processed together, so that their powers of phases stay in the cache.
const BLOCK: usize = 64;

/// Number of partial sums, for SIMD, within a block of points.
const LANES: usize = 8;

/// Density and velocity amplitudes of one Fourier mode, sums over the points.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Amplitude {
    /// Density amplitude Σ exp(-i k · r): real and imaginary part.
    pub density: [f64; 2],
    /// Longitudinal velocity amplitude Σ (v · k/|k|) exp(-i k · r) \[length/time\]: real and
    /// imaginary part.
    pub longitudinal: [f64; 2],
    /// Transverse velocity amplitude Σ (v · t) exp(-i k · r), t being k/|k| turned by a quarter to
    /// the left \[length/time\]: real and imaginary part.
    pub transverse: [f64; 2],
}

/// Squared density and velocity amplitudes of one Fourier mode, over the number of points.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Power {
    /// Structure factor S(k) = |rho|²/N of the points. Times the weight of a point, this is S(k) of
    /// the particles.
    pub density: f64,
    /// Squared longitudinal velocity amplitude |`p_par`|²/N: T/m in equilibrium \[length²/time²\].
    pub longitudinal: f64,
    /// Squared transverse velocity amplitude |`p_perp`|²/N: T/m in equilibrium \[length²/time²\].
    pub transverse: f64,
}

fn square([re, im]: [f64; 2]) -> f64 {
    re * re + im * im
}

impl Amplitude {
    /// Computes the squared amplitudes of the mode over the number of points.
    pub fn power(&self, points: usize) -> Power {
        let scale = 1.0 / points.max(1) as f64;
        Power {
            density: scale * square(self.density),
            longitudinal: scale * square(self.longitudinal),
            transverse: scale * square(self.transverse),
        }
    }
}

/// Computes the wave vector \[1/length\] of a pair of reciprocal indices in a box with sides
/// `lengths`.
pub(crate) fn wave_vector(lengths: [f64; 2], index: [i32; 2]) -> Vector2<f64> {
    vector![
        TAU * f64::from(index[0]) / lengths[0],
        TAU * f64::from(index[1]) / lengths[1]
    ]
}

/// Computes the expected squared amplitude of either velocity component of one mode in thermal
/// equilibrium, over N times the temperature `Σ v²/(2 N)`: `1 + (1 - S(k))/(N - 1)`.
///
/// With the total momentum fixed at zero, two velocities have the covariance -T/(N - 1) per
/// component, and the pairs of a mode sum to `N S(k) - N`.
pub fn equilibrium_energy(points: usize, structure_factor: f64) -> f64 {
    1.0 + (1.0 - structure_factor) / points.saturating_sub(1).max(1) as f64
}

/// Set of Fourier modes of a periodic box, given by their reciprocal indices.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Modes {
    lengths: [f64; 2],
    indices: Vec<[i32; 2]>,
    /// Largest magnitude of the reciprocal indices along each axis.
    reach: [usize; 2],
}

impl Modes {
    /// Creates the modes `k = 2π (n_x/L_x, n_y/L_y)` of a box with sides `lengths`, one for each
    /// pair of indices n.
    ///
    /// # Errors
    /// [`Error::LengthInvalid`]; [`Error::ModeInvalid`] for n = 0 and for indices beyond ten
    /// thousand.
    pub fn new(lengths: [f64; 2], indices: Vec<[i32; 2]>) -> Result<Self, Error> {
        check_lengths(lengths)?;
        let mut reach = [0; 2];
        for &index in &indices {
            if index == [0, 0] || index.iter().any(|n| n.unsigned_abs() > LARGEST_INDEX) {
                return Err(Error::ModeInvalid {
                    found: index,
                    allowed: LARGEST_INDEX,
                });
            }
            for axis in [0, 1] {
                reach[axis] = reach[axis].max(index[axis].unsigned_abs() as usize);
            }
        }
        Ok(Self {
            lengths,
            indices,
            reach,
        })
    }

    /// Returns the modes with wave numbers |k| from `range[0]` up to but not including `range[1]`
    /// \[1/length\], one of each pair ±k. Of more than `most` modes, modes at equal steps in the
    /// order of their indices are taken.
    ///
    /// # Errors
    /// As [`Modes::new`].
    pub fn band(lengths: [f64; 2], range: [f64; 2], most: usize) -> Result<Self, Error> {
        check_lengths(lengths)?;
        let limit = i64::from(LARGEST_INDEX);
        let [width, height] =
            lengths.map(|length| ((range[1] * length / TAU).ceil() as i64).clamp(0, limit) as i32);
        let mut indices = Vec::new();
        for n_y in 0..=height {
            let first = if n_y == 0 { 1 } else { -width };
            for n_x in first..=width {
                if (range[0]..range[1]).contains(&wave_vector(lengths, [n_x, n_y]).norm()) {
                    indices.push([n_x, n_y]);
                }
            }
        }
        let stride = indices.len().div_ceil(most.max(1)).max(1);
        Self::new(lengths, indices.into_iter().step_by(stride).collect())
    }

    /// Returns the pairs of reciprocal indices of the modes.
    pub fn indices(&self) -> &[[i32; 2]] {
        &self.indices
    }

    /// Returns the wave number |k| of each mode \[1/length\].
    pub fn wave_numbers(&self) -> impl Iterator<Item = f64> + '_ {
        let lengths = self.lengths;
        self.indices
            .iter()
            .map(move |&index| wave_vector(lengths, index).norm())
    }

    /// Computes `Σ_j w_j exp(-i k · r_j)` of all modes, in their order, for several weights w of
    /// each point at once; `weights` gives the weights of a point by its index.
    ///
    /// # Errors
    /// [`Error::PointsTooFew`], [`Error::PositionInvalid`].
    pub fn sums<const W: usize>(
        &self,
        positions: &[Vector2<f64>],
        mut weights: impl FnMut(usize) -> [f64; W],
    ) -> Result<Vec<[Complex<f64>; W]>, Error> {
        check_positions(positions, 1)?;
        let mut sums = vec![[Complex::new(0.0, 0.0); W]; self.indices.len()];
        let mut powers = self.reach.map(|reach| Powers::new(reach + 1));
        for (block, places) in positions.chunks(BLOCK).enumerate() {
            for (axis, powers) in powers.iter_mut().enumerate() {
                powers.raise(places, axis, self.lengths[axis]);
            }
            // Zero beyond the last point.
            let mut lanes = [[0.0; BLOCK]; W];
            for slot in 0..places.len() {
                for (lane, weight) in lanes.iter_mut().zip(weights(block * BLOCK + slot)) {
                    lane[slot] = weight;
                }
            }
            for (&index, sum) in self.indices.iter().zip(&mut sums) {
                add_block(&powers, index, &lanes, sum);
            }
        }
        Ok(sums)
    }

    /// Computes density and velocity amplitudes of all modes, in their order. Velocities beyond the
    /// number of positions are ignored, and missing ones are zero.
    ///
    /// # Errors
    /// [`Error::PointsTooFew`], [`Error::PositionInvalid`].
    pub fn measure(
        &self,
        positions: &[Vector2<f64>],
        velocities: &[Vector2<f64>],
    ) -> Result<Vec<Amplitude>, Error> {
        // Weights of a point: one and its velocity, zero if that is missing.
        let sums = self.sums(positions, |point| {
            let velocity = velocities.get(point).copied().unwrap_or_default();
            [1.0, velocity[0], velocity[1]]
        })?;
        let split = self.indices.iter().zip(sums).map(|(&index, sum)| {
            let [density, along_x, along_y] = sum;
            let k = wave_vector(self.lengths, index).normalize();
            let parts = |number: Complex<f64>| [number.re, number.im];
            Amplitude {
                density: parts(density),
                longitudinal: parts(along_x * k[0] + along_y * k[1]),
                transverse: parts(along_y * k[0] - along_x * k[1]),
            }
        });
        Ok(split.collect())
    }
}

/// Weights with which particles enter the mode sums of [`Amplitudes`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum ModeWeights {
    /// One weight of 1 for each particle: density amplitudes.
    Density,
    /// Three weights for each particle: 1, the momentum relative to a mean flow, and the energy
    /// relative to that flow less a temperature.
    Fields {
        /// Mean flow that is subtracted from the velocities \[length/time\].
        flow: Vector2<f64>,
        /// Temperature subtracted from the energy of each particle \[energy\].
        temperature: f64,
    },
}

/// Reduction over the particles of a gas that computes [`Modes::sums`].
#[derive(Serialize, Deserialize)]
pub struct Amplitudes {
    modes: Modes,
    weighing: ModeWeights,
    seen: Seen,
    totals: Totals,
    /// Positions and weights of the particles in the current group, not yet added to the sums.
    #[serde(skip)]
    places: Vec<Vector2<f64>>,
    #[serde(skip)]
    weights: Vec<[f64; 4]>,
}

impl Amplitudes {
    /// Creates a reduction with amplitudes of zero.
    pub fn new(modes: Modes, weighing: ModeWeights) -> Self {
        let weights = match weighing {
            ModeWeights::Density => 1,
            ModeWeights::Fields { .. } => 4,
        };
        Self {
            totals: Totals::new(2 * weights * modes.indices.len()),
            modes,
            weighing,
            seen: Seen::default(),
            places: Vec::new(),
            weights: Vec::new(),
        }
    }

    /// Returns the number of points, and for each mode the sum of each weight, one after the other.
    ///
    /// # Errors
    /// [`Error::PointsTooFew`], [`Error::PositionInvalid`].
    pub fn sums(self) -> Result<(usize, Vec<Complex<f64>>), Error> {
        self.seen.check(1)?;
        let parts = self.totals.values();
        let pairs = parts.chunks(2).map(|pair| Complex::new(pair[0], pair[1]));
        Ok((self.seen.count, pairs.collect()))
    }

    /// Adds the current group of particles to the sums, with the first W weights.
    fn flush<const W: usize>(&mut self) {
        let weights = &self.weights;
        let sums = self.modes.sums(&self.places, |point| {
            std::array::from_fn::<_, W, _>(|number| weights[point][number])
        });
        let sums = sums.unwrap_or_default();
        let parts = sums.iter().flatten().flat_map(|sum| [sum.re, sum.im]);
        for (total, part) in self.totals.open().iter_mut().zip(parts) {
            *total += part;
        }
        self.totals.close();
        self.places.clear();
        self.weights.clear();
    }
}

impl ParticleReduction for Amplitudes {
    const NAME: &'static str = "amplitudes";

    fn add_particle(&mut self, particle: &Particle) {
        self.seen.count += 1;
        if !self.seen.is_good(particle.position) {
            return;
        }
        self.places.push(particle.position.xy());
        self.weights.push(match self.weighing {
            ModeWeights::Density => [1.0; 4],
            ModeWeights::Fields { flow, temperature } => {
                let beside = particle.velocity.xy() - flow;
                let energy = 0.5 * particle.mass * beside.norm_squared() - temperature;
                let momentum = beside * particle.mass;
                [1.0, momentum.x, momentum.y, energy]
            }
        });
    }

    fn close_group(&mut self, _group: u32) {
        match self.weighing {
            ModeWeights::Density => self.flush::<1>(),
            ModeWeights::Fields { .. } => self.flush::<4>(),
        }
    }

    fn merge_sum(&mut self, other: Self) {
        self.seen.merge(&other.seen);
        self.totals.merge(&other.totals);
    }
}

/// Powers 0, 1, 2, ... of the phases exp(-2πi x/L) of a block of points along one axis. Real and
/// imaginary parts are stored apart, for SIMD.
struct Powers {
    real: Vec<[f64; BLOCK]>,
    imaginary: Vec<[f64; BLOCK]>,
}

impl Powers {
    fn new(orders: usize) -> Self {
        Self {
            real: vec![[1.0; BLOCK]; orders],
            imaginary: vec![[0.0; BLOCK]; orders],
        }
    }

    fn raise(&mut self, places: &[Vector2<f64>], axis: usize, length: f64) {
        for (slot, place) in places.iter().enumerate() {
            let waves = place[axis] / length;
            let (sine, cosine) = (TAU * (waves - waves.round())).sin_cos();
            let phase = Complex::new(cosine, -sine);
            let mut power = Complex::new(1.0, 0.0);
            for (real, imaginary) in self.real.iter_mut().zip(&mut self.imaginary) {
                real[slot] = power.re;
                imaginary[slot] = power.im;
                power *= phase;
            }
        }
    }
}

/// Adds the weighted phases of one mode over a block of points to `sum`, through one partial sum
/// for each SIMD lane.
fn add_block<const W: usize>(
    powers: &[Powers; 2],
    index: [i32; 2],
    weights: &[[f64; BLOCK]; W],
    sum: &mut [Complex<f64>; W],
) {
    let [x, y] = index.map(|n| n.unsigned_abs() as usize);
    let (x_real, x_imaginary) = (&powers[0].real[x], &powers[0].imaginary[x]);
    let (y_real, y_imaginary) = (&powers[1].real[y], &powers[1].imaginary[y]);
    // A negative index has the conjugate phase.
    let [x_sign, y_sign] = index.map(|n| if n < 0 { -1.0 } else { 1.0 });
    let mut lanes = [[[0.0; LANES]; 2]; W];
    for start in (0..BLOCK).step_by(LANES) {
        for lane in 0..LANES {
            let slot = start + lane;
            let [a, b] = [x_real[slot], x_sign * x_imaginary[slot]];
            let [c, d] = [y_real[slot], y_sign * y_imaginary[slot]];
            let [real, imaginary] = [a * c - b * d, a * d + b * c];
            for (lanes, weights) in lanes.iter_mut().zip(weights) {
                lanes[0][lane] += real * weights[slot];
                lanes[1][lane] += imaginary * weights[slot];
            }
        }
    }
    for (sum, [real, imaginary]) in sum.iter_mut().zip(&lanes) {
        *sum += Complex::new(real.iter().sum(), imaginary.iter().sum());
    }
}

/// Computes velocity changes that add one shear wave for each given mode to a gas: `amplitude t
/// cos(k · r)` with t across k as in [`Amplitude`]. The transverse amplitude of that mode grows by
/// `amplitude N/2` in its real part, except for correlations of the positions.
///
/// # Errors
/// [`Error::PositionInvalid`], [`Error::PointsTooFew`].
pub fn shear_waves(
    modes: &Modes,
    positions: &[Vector2<f64>],
    amplitude: f64,
) -> Result<Vec<Vector2<f64>>, Error> {
    check_positions(positions, 1)?;
    let waves: Vec<_> = modes
        .indices
        .iter()
        .map(|&index| wave_vector(modes.lengths, index))
        .collect();
    let changes = positions.iter().map(|place| {
        waves.iter().fold(Vector2::zeros(), |sum, k| {
            let across = vector![-k[1], k[0]].normalize();
            sum + across * (amplitude * k.dot(place).cos())
        })
    });
    Ok(changes.collect())
}

#[cfg(test)]
#[allow(
    clippy::unwrap_used,
    reason = "in a test, an unexpected error is a failure"
)]
mod tests;
