//! Homogeneous mixtures of any number of species: cooling and diffusion for Maxwellian velocities.

use std::f64::consts::PI;

use stosszahl_model::{InvalidValue, Restitution};

use super::component::Component;
use super::contact::{self, ContactValues};
use super::error::TheoryError;
use super::integrate::{Integrator, Tolerance};

/// Number of quadrature nodes over the normal approach speeds of colliding pairs.
const NODES: i32 = 40;

/// Kinetic equations of a homogeneous mixture whose species have Maxwellian velocities.
///
/// For the pair (k, i) let `S^2 = T_k/m_k + T_i/m_i` be the variance of a component of the relative
/// velocity and `nu_ki = n_i d_ki^(D-1) chi_ki (Omega_D sqrt(2/pi)/D) S (1 + e) m_i/(m_k + m_i)`,
/// `Omega_2 = 2 pi`, `Omega_3 = 4 pi`. Then velocities of species k decay at the rate
/// `nu_k = sum_i nu_ki`, and temperatures as `dT_k/dt = -T_k sum_i 2 nu_ki (1 - (1 + e) theta/2)`,
/// `theta = (T_k m_i + T_i m_k)/(T_k (m_k + m_i))`: Garzó & Dufty, Phys. Rev. E 60, 5706 (1999),
/// doi:10.1103/PhysRevE.60.5706, in three dimensions. Where restitution depends on the approach
/// speed g, `1 + e` and `(1 + e)^2` stand for their means with the weight `g^3 exp(-g^2/(2 S^2))`,
/// which for viscoelastic spheres are the series of Bodrova & Osinsky (2024).
#[derive(Clone, Debug)]
pub struct MaxwellianMixture<R> {
    dimension: usize,
    components: Vec<Component>,
    law: R,
    /// Collision rate factors `n_i d^(D-1) chi Omega_D sqrt(2/pi)/D` as rows of a matrix: row of
    /// the particle's species k, column of the partner's species i.
    rates: Vec<f64>,
    /// Quadrature nodes over the normal approach speed, for averages of the restitution. Each has
    /// the speed over S, the standard deviation of a component of the relative velocity, and a
    /// weight; weights add up to 1.
    nodes: Vec<(f64, f64)>,
    /// True if the coefficient of restitution does not depend on speed.
    constant: bool,
}

/// Velocity decay, cooling and collision rate of one species at given temperatures.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SpeciesRates {
    /// Decay rate of the velocity correlation of the species, `nu_k` \[1/time\].
    pub velocity: f64,
    /// Cooling rate of the species, `xi_k = -d ln T_k/dt` \[1/time\].
    pub cooling: f64,
    /// Collision rate of one particle of the species \[1/time\].
    pub collisions: f64,
}

impl<R: Restitution> MaxwellianMixture<R> {
    /// Creates a mixture in two or three dimensions; `law.between([k, i], g)` is the restitution of
    /// a pair of species at normal approach speed g.
    ///
    /// # Errors
    /// [`TheoryError::Invalid`] if there is no component, the dimension is another, a mass or
    /// diameter is not above zero, a density negative, or the gas packed too densely for its
    /// contact values.
    pub fn new(
        dimension: usize,
        components: Vec<Component>,
        law: R,
        contact: ContactValues,
    ) -> Result<Self, TheoryError> {
        let check = |name, value: f64, good: bool, allowed| {
            InvalidValue::require(good && value.is_finite(), name, value, allowed)
        };
        let d = dimension as f64;
        check("dimension", d, (2..=3).contains(&dimension), "2 or 3")?;
        let count = components.len();
        check("number of species", count as f64, count > 0, "at least 1")?;
        for component in &components {
            let Component {
                mass,
                diameter,
                density,
            } = *component;
            check("mass", mass, mass > 0.0, "above 0")?;
            check("diameter", diameter, diameter > 0.0, "above 0")?;
            check("density", density, density >= 0.0, "0 or more")?;
        }
        let values = contact::values(dimension, &components, contact)?;
        let sphere = if dimension == 2 { 2.0 * PI } else { 4.0 * PI };
        let mut rates = Vec::with_capacity(count * count);
        for (k, hit) in components.iter().enumerate() {
            for (i, partner) in components.iter().enumerate() {
                let distance = 0.5 * (hit.diameter + partner.diameter);
                rates.push(
                    partner.density
                        * distance.powi(dimension as i32 - 1)
                        * values[k * count + i]
                        * sphere
                        * (2.0 / PI).sqrt()
                        / d,
                );
            }
        }
        // With y = g^2/(2 S^2), the weight is y exp(-y) dy. Trapezoidal in u with y = exp(u -
        // exp(-u)), which decays doubly exponentially on both sides: exact to rounding for smooth
        // laws and for powers of g.
        let mut nodes: Vec<(f64, f64)> = (0..NODES)
            .map(|node| {
                let u = -3.5 + 7.5 * f64::from(node) / f64::from(NODES - 1);
                let y = (u - (-u).exp()).exp();
                ((2.0 * y).sqrt(), y * y * (-y).exp() * (1.0 + (-u).exp()))
            })
            .collect();
        let sum: f64 = nodes.iter().map(|node| node.1).sum();
        for node in &mut nodes {
            node.1 /= sum;
        }
        let constant = (0..count as u32).all(|k| {
            (0..count as u32).all(|i| {
                let at = |g| law.pair_restitution([k, i], g);
                let first = at(0.1);
                [0.0, 1e-6, 1.0, 50.0].iter().all(|&g| at(g) == first)
            })
        });
        Ok(Self {
            dimension,
            components,
            law,
            rates,
            nodes,
            constant,
        })
    }

    /// Returns the species of the mixture.
    pub fn components(&self) -> &[Component] {
        &self.components
    }

    /// Returns the dimension of space: 2 or 3.
    pub fn dimension(&self) -> usize {
        self.dimension
    }

    /// Returns the collision rate factor `n_i d^(D-1) chi Omega_D sqrt(2/pi)/D` of particles of
    /// species k with partners of species i.
    pub(super) fn base(&self, k: usize, i: usize) -> f64 {
        self.rates[k * self.components.len() + i]
    }

    /// Returns true if the coefficient of restitution does not depend on speed.
    pub fn is_constant(&self) -> bool {
        self.constant
    }

    /// Returns the quadrature nodes over approach speeds in units of S, for averages with the
    /// weight `y exp(-y)`, `y = g^2/(2 S^2)`.
    pub(super) fn nodes(&self) -> &[(f64, f64)] {
        &self.nodes
    }

    /// Returns the coefficient of restitution of a pair of species at a normal approach speed.
    pub(super) fn between(&self, kinds: [u32; 2], speed: f64) -> f64 {
        self.law.pair_restitution(kinds, speed)
    }

    /// Computes the means of 1 + e and of its square over the collisions of a pair of species, e
    /// being the restitution. `spread` is the standard deviation of a component of the relative
    /// velocity.
    fn restitution_means(&self, kinds: [u32; 2], spread: f64) -> [f64; 2] {
        if self.constant {
            let once = 1.0 + self.law.pair_restitution(kinds, 1.0);
            return [once, once * once];
        }
        let mut sums = [0.0; 2];
        for &(speed, weight) in &self.nodes {
            let once = 1.0 + self.law.pair_restitution(kinds, speed * spread);
            sums[0] += weight * once;
            sums[1] += weight * once * once;
        }
        sums
    }

    /// Computes velocity decay, cooling and collision rate of species k at the given temperatures.
    pub fn rates(&self, k: usize, temperatures: &[f64]) -> SpeciesRates {
        let count = self.components.len();
        let (hit, t) = (&self.components[k], temperatures[k]);
        let mut rates = SpeciesRates::default();
        for (i, (partner, &other)) in self.components.iter().zip(temperatures).enumerate() {
            let base = self.rates[k * count + i];
            if base == 0.0 {
                continue;
            }
            let spread = (t / hit.mass + other / partner.mass).sqrt();
            let [once, twice] = self.restitution_means([k as u32, i as u32], spread);
            let share = partner.mass / (hit.mass + partner.mass);
            let theta = (t * partner.mass + other * hit.mass) / (t * (hit.mass + partner.mass));
            let hits = base * spread;
            rates.velocity += hits * share * once;
            rates.cooling += hits * share * (2.0 * once - twice * theta);
            // sigma <g> is sqrt(2 pi) d S in the plane, 2 sqrt(2 pi) d^2 S in space.
            rates.collisions += 0.5 * hits * self.dimension as f64;
        }
        rates
    }

    /// Computes the rate of collisions of a particle of species k with others of its species
    /// \[1/time\], at their temperature: `4 n d^2 chi sqrt(pi T/m)` in space, `2 n d chi sqrt(pi
    /// T/m)` in the plane.
    pub fn like_collisions(&self, k: usize, temperature: f64) -> f64 {
        let spread = (2.0 * temperature / self.components[k].mass).sqrt();
        0.5 * self.dimension as f64 * self.base(k, k) * spread
    }

    /// Computes the state of the mixture at given times in rising order, by integration from given
    /// temperatures at time zero: temperatures, displacements, velocity correlations and
    /// collisions.
    ///
    /// `dC_k/dt = D T_k/m_k - nu_k C_k` and `d<R_k^2>/dt = 2 C_k`, which is exact for velocity
    /// correlations that decay exponentially in the number of collisions.
    ///
    /// # Errors
    /// [`TheoryError`] if a temperature is not above zero, the numbers differ, or the integration
    /// fails.
    pub fn evolve(&self, temperatures: &[f64], times: &[f64]) -> Result<Vec<Moment>, TheoryError> {
        self.check_temperatures(temperatures)?;
        let count = self.components.len();
        // Logarithms of temperatures: they fall by many orders, and never below zero.
        let mut start: Vec<f64> = temperatures.iter().map(|t| t.ln()).collect();
        start.extend(vec![0.0; 4 * count]);
        let fastest = (0..count)
            .map(|k| self.rates(k, temperatures).velocity)
            .fold(0.0, f64::max);
        let first = if fastest > 0.0 { 0.01 / fastest } else { 1.0 };
        let mut now = vec![0.0; count];
        let slope = |_: f64, y: &[f64], slope: &mut [f64]| {
            for (t, log) in now.iter_mut().zip(y) {
                *t = log.exp();
            }
            for k in 0..count {
                let rates = self.rates(k, &now);
                let thermal = self.dimension as f64 * now[k] / self.components[k].mass;
                slope[k] = -rates.cooling;
                slope[count + k] = thermal - rates.velocity * y[count + k];
                slope[2 * count + k] = 2.0 * y[count + k];
                slope[3 * count + k] = rates.velocity;
                slope[4 * count + k] = rates.collisions;
            }
        };
        let tolerance = Tolerance {
            relative: 1e-8,
            absolute: 1e-10,
        };
        let mut problem = Integrator::new(slope, 0.0, start, first, tolerance);
        let mut found = Vec::with_capacity(times.len());
        for &time in times {
            let y = problem.advance(time)?;
            found.push(Moment {
                time,
                temperatures: y[..count].iter().map(|log| log.exp()).collect(),
                correlations: y[count..2 * count].to_vec(),
                displacements: y[2 * count..3 * count].to_vec(),
                kept: y[3 * count..4 * count]
                    .iter()
                    .map(|decay| (-decay).exp())
                    .collect(),
                collisions: y[4 * count..].to_vec(),
                fourth_cumulants: vec![0.0; count],
            });
        }
        Ok(found)
    }

    /// Checks that there is one temperature for each species, and that all are above zero.
    pub(super) fn check_temperatures(&self, temperatures: &[f64]) -> Result<(), TheoryError> {
        for &t in temperatures {
            InvalidValue::unless_positive("temperature", t)?;
        }
        let count = temperatures.len();
        let is_right = count == self.components.len();
        let name = "number of temperatures";
        InvalidValue::require(is_right, name, count as f64, "the number of species")?;
        Ok(())
    }

    /// Computes the mean of a quantity over all particles: the values of the species, weighted with
    /// their densities.
    pub fn average(&self, values: &[f64]) -> f64 {
        let total: f64 = self.components.iter().map(|c| c.density).sum();
        let sum: f64 = self
            .components
            .iter()
            .zip(values)
            .map(|(component, value)| component.density * value)
            .sum();
        sum / total
    }
}

/// State of a mixture at one time; all lists have one entry for each species.
#[derive(Clone, Debug, PartialEq)]
pub struct Moment {
    /// Time of the state \[time\].
    pub time: f64,
    /// Temperature of each species, `T_k = m_k <v_k^2>/D` \[energy\].
    pub temperatures: Vec<f64>,
    /// Velocity-displacement correlation of each species, `<R_k . v_k>` \[length^2/time\].
    pub correlations: Vec<f64>,
    /// Mean squared displacement of each species, `<R_k^2>` \[length^2\].
    pub displacements: Vec<f64>,
    /// Normalised velocity autocorrelation of each species, `<v_k(0) . v_k>/<v_k(0)^2>`.
    pub kept: Vec<f64>,
    /// Collisions of one particle of each species since time zero.
    pub collisions: Vec<f64>,
    /// Fourth cumulant of each species, `D <v^4>/((D + 2) <v^2>^2) - 1`.
    pub fourth_cumulants: Vec<f64>,
}
