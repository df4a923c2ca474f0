//! Spectra of the hydrodynamic fields of disks in a periodic box: density, flow across and along
//! the wave vector, and temperature, averaged over shells of wave vectors.
//!
//! For N points with masses `m_j` and velocities `v_j` relative to the mean flow, with the mean
//! mass m and the temperature `T = Σ m_j v_j²/(2 N)` of the moment, the amplitudes at the wave
//! vector k are
//!
//! ```text
//! density       rho(k)   = Σ_j exp(-i k · r_j)
//! flow          p(k)     = Σ_j m_j v_j exp(-i k · r_j)
//! temperature   theta(k) = Σ_j (m_j v_j²/2 - T) exp(-i k · r_j)
//! ```
//!
//! and the spectra are
//!
//! ```text
//! S_nn = <|rho|²>/N,   S_perp = <|p_perp|²>/(N m T),   S_par = <|p_par|²>/(N m T),   S_TT = <|theta|²>/(N T²)
//! ```
//!
//! (T. P. C. van Noije, M. H. Ernst, R. Brito & J. A. G. Orza, *Physical Review Letters* **79**,
//! 411 (1997), doi:10.1103/PhysRevLett.79.411). The last three are 1 in thermal equilibrium at
//! every k, but for 1/N, whatever the density does: velocities are then independent of places, and
//! the energy of a disk has the variance T². That holds for any number of points for each disk: a
//! point of w disks has the noise of a point. The flow of the disks then has w times these spectra,
//! and `w S_nn` is the structure factor of the disks.

use nalgebra::{Vector2, vector};
use serde::{Deserialize, Serialize};
use stosszahl_model::{Grouping, Particle};

use crate::Error;
use crate::flow::{AddUp, flows, thermal};
use crate::modes::{Amplitudes, ModeWeights, Modes, wave_vector};
use crate::structure_factor::half_plane;

/// Wave vectors of a box in shells, the wave numbers |k| `L_x`/2π that round to the same integer.
#[derive(Clone, Debug, PartialEq)]
pub struct Shells {
    lengths: [f64; 2],
    modes: Modes,
    /// Number of modes up to the end of each shell; modes are sorted by shell.
    ends: Vec<usize>,
}

/// Spectra of density, flow and temperature in one shell of wave numbers: means over its modes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Spectrum {
    /// Spectrum of the density, `S_nn = <|rho|²>/N`.
    pub density: f64,
    /// Spectrum of the flow perpendicular to k (shear), `S_perp = <|p_perp|²>/(N m T)`.
    pub transverse: f64,
    /// Spectrum of the flow along k (sound), `S_par = <|p_par|²>/(N m T)`.
    pub longitudinal: f64,
    /// Spectrum of the temperature, `S_TT = <|theta|²>/(N T²)`.
    pub temperature: f64,
}

/// Spectra of one configuration of the gas, by shell, and the shear amplitude of each mode.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Spectra {
    /// Spectra of each shell, in the order of the shells.
    pub shells: Vec<Spectrum>,
    /// Shear amplitude of each mode, `p_perp/sqrt(N m T)` as real and imaginary part: its square is
    /// `S_perp` of the mode. Empty in a gas at rest.
    pub shear: Vec<[f64; 2]>,
}

/// Disk as seen by the spectra: position, velocity and mass.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpectrumDisk {
    /// Position of the centre \[length\].
    pub position: Vector2<f64>,
    /// Velocity of the centre \[length/time\].
    pub velocity: Vector2<f64>,
    /// Mass of the disk \[mass\].
    pub mass: f64,
}

impl Shells {
    /// Creates shells with the given numbers, in rising order, from one mode of each pair ±k. A
    /// shell has `most` modes at most: of more, modes at equal steps in the order of their indices
    /// are taken. Shells without modes are left out.
    ///
    /// # Errors
    /// [`Error::LengthInvalid`]; [`Error::WaveNumberInvalid`] for the shell 0 and without shells;
    /// [`Error::ModeInvalid`] for shells beyond ten thousand.
    pub fn new(lengths: [f64; 2], numbers: &[usize], most: usize) -> Result<Self, Error> {
        crate::error::check_lengths(lengths)?;
        let mut numbers = numbers.to_vec();
        numbers.sort_unstable();
        numbers.dedup();
        let (Some(&first), Some(&largest)) = (numbers.first(), numbers.last()) else {
            return Err(Error::WaveNumberInvalid);
        };
        if first == 0 {
            return Err(Error::WaveNumberInvalid);
        }
        let limit = crate::modes::LARGEST_INDEX;
        if largest > limit as usize {
            let found = [i32::try_from(largest).unwrap_or(i32::MAX), 0];
            return Err(Error::ModeInvalid {
                found,
                allowed: limit,
            });
        }
        let mut of_shells = vec![Vec::new(); numbers.len()];
        for mode in half_plane(lengths, largest) {
            if let Ok(shell) = numbers.binary_search(&mode.shell) {
                of_shells[shell].push(mode.index);
            }
        }
        let (mut indices, mut ends) = (Vec::new(), Vec::new());
        for shell in of_shells.into_iter().filter(|shell| !shell.is_empty()) {
            let stride = shell.len().div_ceil(most.max(1));
            indices.extend(shell.into_iter().step_by(stride));
            ends.push(indices.len());
        }
        let modes = Modes::new(lengths, indices)?;
        Ok(Self {
            lengths,
            modes,
            ends,
        })
    }

    /// Returns the modes of all shells, one shell after the other.
    pub fn modes(&self) -> &Modes {
        &self.modes
    }

    /// Returns the modes of each shell, as index ranges into [`Self::modes`].
    pub fn ranges(&self) -> impl Iterator<Item = std::ops::Range<usize>> + '_ {
        let starts = std::iter::once(&0).chain(&self.ends);
        starts.zip(&self.ends).map(|(&start, &end)| start..end)
    }

    /// Computes the mean wave number |k| `L_x`/2π of each shell.
    pub fn wave_numbers(&self) -> Vec<f64> {
        let unit = self.lengths[0] / std::f64::consts::TAU;
        let all: Vec<f64> = self.modes.wave_numbers().map(|k| k * unit).collect();
        self.ranges().map(|range| mean(&all[range])).collect()
    }

    /// Measures the spectra of density, flow and temperature of one configuration of disks. Flow
    /// and temperature spectra are zero if all disks are at rest.
    ///
    /// # Errors
    /// [`Error::PointsTooFew`], [`Error::PositionInvalid`].
    pub fn measure(&self, disks: &[SpectrumDisk]) -> Result<Spectra, Error> {
        self.measure_gas(&mut |sum| {
            for disk in disks {
                sum.add_particle(&Particle {
                    position: disk.position.push(0.0),
                    velocity: disk.velocity.push(0.0),
                    ..Particle::at_rest(0.0, disk.mass)
                });
            }
            sum.close_group(0);
        })
    }

    /// Measures the spectra of density, flow and temperature of a gas by a reduction over its
    /// particles. Flow and temperature spectra are zero in a gas at rest.
    ///
    /// # Errors
    /// [`Error::PointsTooFew`], [`Error::PositionInvalid`].
    pub fn measure_gas(&self, reduce_particles: &mut AddUp<'_>) -> Result<Spectra, Error> {
        let all = Grouping::new(1, None);
        let flows = flows(all, reduce_particles);
        let (flow, thermal) = (flows[0], thermal(all, &flows, reduce_particles)[0]);
        let temperature = 0.5 * thermal.twice_energy / flow.number.max(f64::MIN_POSITIVE);
        let weighing = ModeWeights::Fields {
            flow: flow.velocity.xy(),
            temperature,
        };
        let mut amplitudes = Amplitudes::new(self.modes.clone(), weighing);
        reduce_particles(&mut amplitudes);
        let (points, sums) = amplitudes.sums()?;
        // Each point counts once here, whatever it stands for.
        let count = points as f64;
        let mass = flow.mass / flow.number * count;
        let moving = temperature > 0.0;
        let over = |unit: f64| if moving { 1.0 / unit } else { 0.0 };
        let (of_flow, of_energy) = (over(mass * temperature), over(count * temperature.powi(2)));
        let all: Vec<(Spectrum, [f64; 2])> = (self.modes.indices().iter().zip(sums.chunks(4)))
            .map(|(&index, sums)| {
                let [density, x, y, energy] = [0, 1, 2, 3].map(|number| sums[number]);
                let k = wave_vector(self.lengths, index).normalize();
                let (along, across) = (x * k[0] + y * k[1], y * k[0] - x * k[1]);
                let spectrum = Spectrum {
                    density: density.norm_sqr() / count,
                    transverse: across.norm_sqr() * of_flow,
                    longitudinal: along.norm_sqr() * of_flow,
                    temperature: energy.norm_sqr() * of_energy,
                };
                let shear = across * of_flow.sqrt();
                (spectrum, [shear.re, shear.im])
            })
            .collect();
        let shells = self.ranges().map(|range| {
            let of = |part: fn(&Spectrum) -> f64| {
                let parts: Vec<f64> = all[range.clone()].iter().map(|one| part(&one.0)).collect();
                mean(&parts)
            };
            Spectrum {
                density: of(|one| one.density),
                transverse: of(|one| one.transverse),
                longitudinal: of(|one| one.longitudinal),
                temperature: of(|one| one.temperature),
            }
        });
        Ok(Spectra {
            shells: shells.collect(),
            shear: if moving {
                all.iter().map(|one| one.1).collect()
            } else {
                Vec::new()
            },
        })
    }
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len().max(1) as f64
}

impl SpectrumDisk {
    /// Creates a disk of mass one at a position with a velocity, for tests.
    pub fn unit(position: [f64; 2], velocity: [f64; 2]) -> Self {
        let [x, y] = position;
        Self {
            position: vector![x, y],
            velocity: vector![velocity[0], velocity[1]],
            mass: 1.0,
        }
    }
}

#[cfg(test)]
#[allow(
    clippy::unwrap_used,
    reason = "in a test, an unexpected error is a failure"
)]
mod tests {
    use super::*;
    use crate::statistics::RunningMoments;
    use rand::{RngExt, SeedableRng};
    use rand_distr::{Distribution, StandardNormal};
    use rand_xoshiro::Xoshiro256PlusPlus;

    const LENGTHS: [f64; 2] = [20.0, 13.0];

    /// Creates disks at independent positions, with Maxwellian velocities at the temperature 1 in a
    /// wind, for tests.
    fn gas(count: usize, masses: &[f64], seed: u64) -> Vec<SpectrumDisk> {
        let mut stream = Xoshiro256PlusPlus::seed_from_u64(seed);
        let one = |number: usize| {
            let mass = masses[number % masses.len()];
            let place = LENGTHS.map(|length| length * stream.random::<f64>());
            let [x, y]: [f64; 2] = [0, 1].map(|_| StandardNormal.sample(&mut stream));
            SpectrumDisk {
                position: place.into(),
                velocity: vector![3.0, -1.0] + vector![x, y] / mass.sqrt(),
                mass,
            }
        };
        (0..count).map(one).collect()
    }

    /// Tests the spectra against plain sums of sines of whole phases, mode by mode. Powers of
    /// phases round to some 1e-15 each, of 150 points.
    #[test]
    fn spectra_are_the_plain_sums() {
        let disks = gas(150, &[1.0, 2.5], 1);
        let shells = Shells::new(LENGTHS, &[5, 1, 2, 5], usize::MAX).unwrap();
        let found = shells.measure(&disks).unwrap();
        let count = disks.len() as f64;
        let mass: f64 = disks.iter().map(|disk| disk.mass).sum();
        let drift = disks
            .iter()
            .map(|d| d.velocity * d.mass)
            .sum::<Vector2<f64>>()
            / mass;
        let energies: Vec<f64> = (disks.iter())
            .map(|d| 0.5 * d.mass * (d.velocity - drift).norm_squared())
            .collect();
        let temperature = mean(&energies);
        let mut all = vec![Vec::new(); 6];
        for n_y in -9..=9_i32 {
            for n_x in -9..=9_i32 {
                let waves = [f64::from(n_x), f64::from(n_y)];
                let shell = waves[0].hypot(waves[1] * LENGTHS[0] / LENGTHS[1]).round() as usize;
                if shell == 0 || shell > 5 {
                    continue;
                }
                let k =
                    vector![waves[0] / LENGTHS[0], waves[1] / LENGTHS[1]] * std::f64::consts::TAU;
                let mut sums = [[0.0; 2]; 4];
                for (disk, energy) in disks.iter().zip(&energies) {
                    let (sine, cosine) = k.dot(&disk.position).sin_cos();
                    let flow = (disk.velocity - drift) * disk.mass;
                    let across = k[0] * flow[1] - k[1] * flow[0];
                    let parts = [
                        1.0,
                        across / k.norm(),
                        flow.dot(&k) / k.norm(),
                        energy - temperature,
                    ];
                    for (sum, part) in sums.iter_mut().zip(parts) {
                        sum[0] += part * cosine;
                        sum[1] -= part * sine;
                    }
                }
                all[shell].push(sums.map(|[re, im]: [f64; 2]| re * re + im * im));
            }
        }
        let numbers = [1, 2, 5];
        assert_eq!(found.shells.len(), numbers.len());
        for (number, found) in numbers.into_iter().zip(&found.shells) {
            let of = |part: usize, unit: f64| {
                let parts: Vec<f64> = all[number].iter().map(|one| one[part] / unit).collect();
                mean(&parts)
            };
            let flow = mass * temperature;
            for (found, plain) in [
                (found.density, of(0, count)),
                (found.transverse, of(1, flow)),
                (found.longitudinal, of(2, flow)),
                (found.temperature, of(3, count * temperature * temperature)),
            ] {
                assert!(
                    (found / plain - 1.0).abs() < 1e-11,
                    "{number}: {found} {plain}"
                );
            }
        }
        let squares: Vec<f64> = found
            .shear
            .iter()
            .map(|[re, im]| re * re + im * im)
            .collect();
        for (range, shell) in shells.ranges().zip(&found.shells) {
            assert!((mean(&squares[range]) / shell.transverse - 1.0).abs() < 1e-13);
        }
    }

    /// Tests that independent positions and velocities have spectra of one at every k, within z =
    /// 4.9 standard errors (false alarm 1e-6 each), which see 2 %. Fixing momentum and energy at
    /// those of the configuration subtracts 1/N = 0.5 % and adds as much.
    #[test]
    fn thermal_noise_has_spectra_of_one() {
        let shells = Shells::new(LENGTHS, &[1, 2, 3, 4, 5], 30).unwrap();
        assert!(shells.ranges().all(|range| (1..=30).contains(&range.len())));
        let mut moments = [RunningMoments::default(); 4];
        for seed in 0..6000 {
            for shell in shells.measure(&gas(200, &[1.0, 3.0], seed)).unwrap().shells {
                let parts = [
                    shell.density,
                    shell.transverse,
                    shell.longitudinal,
                    shell.temperature,
                ];
                for (moments, part) in moments.iter_mut().zip(parts) {
                    moments.add(part);
                }
            }
        }
        for moments in moments {
            let [mean, error] = [moments.mean().unwrap(), moments.standard_error().unwrap()];
            let good = error < 0.02 / 4.9 && (mean - 1.0).abs() < 4.9 * error;
            assert!(good, "{mean} {error}");
        }
    }

    #[test]
    fn meaningless_shells_are_refused() {
        for numbers in [&[][..], &[0, 3]] {
            let error = Shells::new(LENGTHS, numbers, 9).unwrap_err();
            assert_eq!(error, Error::WaveNumberInvalid);
        }
        let error = Shells::new(LENGTHS, &[10_001], 9).unwrap_err();
        assert!(matches!(error, Error::ModeInvalid { .. }), "{error}");
        let shells = Shells::new(LENGTHS, &[3], 5).unwrap();
        assert!(shells.measure(&[]).is_err());
        assert!((shells.wave_numbers()[0] - 3.0).abs() < 0.5);
        let still = [SpectrumDisk::unit([1.0, 2.0], [0.5, 0.0])];
        let found = shells.measure(&still).unwrap();
        assert!(found.shear.is_empty() && found.shells[0].transverse == 0.0);
        assert!((found.shells[0].density - 1.0).abs() < 1e-15);
    }
}
