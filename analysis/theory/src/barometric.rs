//! Barometric equilibrium of a gas in a closed column under gravity, from conservation of energy.
//!
//! Elastic particles between specular walls conserve their energy. A column that is uniform at
//! first falls, and its loss of potential energy heats it: with `n` degrees of freedom of a
//! particle, x = m g L/T and the mean height L (1/x - 1/(e^x - 1)) of a barometric profile,
//!
//! `sum N (n T0/2 + m g L/2) = sum N (n T/2 + m g <z>(T))`.
//!
//! Source: Kawasaki, Monte Carlo calculation of the flow of granular materials (California
//! Institute of Technology, 1985), appendix B, corrected. The gas is dilute: particles have no
//! volume here.

use stosszahl_model::InvalidValue;

use super::error::TheoryError;

/// Species in a gas column: mass of a particle and number of particles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Layer {
    /// Mass of one particle of the species \[mass\].
    pub mass: f64,
    /// Number of particles of the species, in any unit.
    pub number: f64,
}

/// Gas in a closed column under gravity, in barometric equilibrium.
#[derive(Clone, Debug, PartialEq)]
pub struct BarometricColumn {
    height: f64,
    gravity: f64,
    temperature: f64,
}

impl BarometricColumn {
    /// Computes the equilibrium of a column that starts uniform, at rest and at the temperature
    /// `start`.
    ///
    /// `freedoms` is the number of degrees of freedom that share the energy: D for smooth
    /// particles, and those of rotation too for perfectly rough ones.
    ///
    /// # Errors
    /// [`TheoryError::Invalid`] unless all numbers are positive and finite.
    pub fn settled(
        layers: &[Layer],
        height: f64,
        gravity: f64,
        start: f64,
        freedoms: usize,
    ) -> Result<Self, TheoryError> {
        let numbers = [
            ("height of the column", height),
            ("gravity", gravity),
            ("temperature of the start", start),
            ("number of degrees of freedom", freedoms as f64),
            ("number of species", layers.len() as f64),
        ];
        let masses = layers
            .iter()
            .flat_map(|layer| [("mass", layer.mass), ("number of particles", layer.number)]);
        for (name, value) in numbers.into_iter().chain(masses) {
            InvalidValue::unless_positive(name, value)?;
        }
        // Energy above that of the start: rising in the temperature, negative at the start, and not
        // at the end of the fall.
        let freedoms = freedoms as f64;
        let gain = |temperature: f64| -> f64 {
            layers
                .iter()
                .map(|layer| {
                    let weight = layer.mass * gravity * height;
                    let fall = weight * (0.5 - mean_height(weight / temperature));
                    layer.number * (0.5 * freedoms * (temperature - start) - fall)
                })
                .sum()
        };
        let heaviest = layers.iter().map(|layer| layer.mass).fold(0.0, f64::max);
        let mut low = start;
        let mut high = start + heaviest * gravity * height / freedoms;
        for _ in 0..200 {
            let middle = 0.5 * (low + high);
            if middle <= low || middle >= high {
                break;
            }
            if gain(middle) < 0.0 {
                low = middle;
            } else {
                high = middle;
            }
        }
        Ok(Self {
            height,
            gravity,
            temperature: 0.5 * (low + high),
        })
    }

    /// Returns the equilibrium temperature of the column \[energy\].
    pub fn temperature(&self) -> f64 {
        self.temperature
    }

    /// Computes the density of particles of one mass at a height, over the density of the uniform
    /// column.
    pub fn density(&self, mass: f64, height: f64) -> f64 {
        let x = mass * self.gravity * self.height / self.temperature;
        x * (-x * height / self.height).exp() / -(-x).exp_m1()
    }

    /// Computes the mean of [`Self::density`] over an interval of heights.
    pub fn mean_density(&self, mass: f64, from: f64, to: f64) -> f64 {
        let x = mass * self.gravity * self.height / self.temperature;
        let [a, b] = [from, to].map(|height| (-x * height / self.height).exp());
        (a - b) / -(-x).exp_m1() * self.height / (to - from)
    }
}

/// Computes the mean height of a barometric profile over the height of the column, 1/x - 1/(e^x -
/// 1), by a series for small x.
fn mean_height(x: f64) -> f64 {
    if x < 1e-2 {
        0.5 - x / 12.0 + x.powi(3) / 720.0
    } else {
        1.0 / x - 1.0 / x.exp_m1()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Known solutions: T/T0 of one species with 6 and 3 degrees of freedom at m g L/T0 = 2 and
    /// 2.5465, densities at floor and ceiling, and of two species in equal numbers with mass ratios
    /// 1 and 10; five digits are known.
    #[test]
    fn settles_at_the_known_temperatures() {
        let one = |freedoms, x| {
            let layer = Layer {
                mass: 1.0,
                number: 1.0,
            };
            BarometricColumn::settled(&[layer], 10.0, 0.1 * x, 1.0, freedoms).expect("a column")
        };
        for (freedoms, x, temperature) in [
            (6, 2.0, 1.09615),
            (6, 2.5465, 1.14564),
            (3, 2.0, 1.17990),
            (3, 2.5465, 1.26689),
        ] {
            let column = one(freedoms, x);
            assert!((column.temperature() - temperature).abs() < 6e-6);
        }
        let column = one(6, 2.0);
        assert!((column.density(1.0, 0.0) - 2.175).abs() < 6e-4);
        assert!((column.density(1.0, 10.0) - 0.351).abs() < 6e-4);
        assert!((column.mean_density(1.0, 0.0, 10.0) - 1.0).abs() < 1e-14);
        let thin = column.mean_density(1.0, 3.0, 3.0 + 1e-6);
        assert!((thin / column.density(1.0, 3.0) - 1.0).abs() < 1e-6);
        assert!((mean_height(0.01) - mean_height(0.009_999_999)).abs() < 1e-9);
    }

    #[test]
    fn refuses_what_is_no_column() {
        let layer = Layer {
            mass: 1.0,
            number: 0.0,
        };
        assert!(BarometricColumn::settled(&[layer], 1.0, 1.0, 1.0, 3).is_err());
        assert!(BarometricColumn::settled(&[], 1.0, 1.0, 1.0, 3).is_err());
    }
}
