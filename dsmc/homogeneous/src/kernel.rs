//! Collision kernel of a homogeneous gas: the collision rate of a pair of given radii over its
//! relative speed, dilute or with Enskog's contact values.

use std::f64::consts::PI;
use stosszahl_model::equation_of_state;

use serde::{Deserialize, Serialize};

/// Contact value χ of the pair correlation by which density raises collision rates: none or
/// Enskog's.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum PairCorrelationFactor {
    /// Contact value 1 for all pairs: the Boltzmann gas.
    Dilute,
    /// Contact values of Enskog's theory for a mixture: Santos, Yuste & López de Haro, Mol. Phys.
    /// 96, 1 (1999) in the plane, with the equal-disk value of [`equation_of_state::contact_value`]; Boublík
    /// (1970) and Mansoori et al. (1971) in space.
    Enskog,
}

/// Collision kernel of a homogeneous gas: the collision rate of a pair over its relative speed,
/// `k(a, b) = sum_st M_st a^s b^t`, for radii a and b.
///
/// For one unordered pair, `k g` is its rate \[1/time\]: `2 chi (a + b) g/V` in two dimensions and
/// `pi chi (a + b)^2 g/V` in three. Both contact values of [`PairCorrelationFactor`] leave k a
/// polynomial of degree two with non-negative coefficients. In two dimensions `chi (a + b)` is a
/// sum of `a + b` and `a b`; in three, `chi (a + b)^2` is one of `(a + b)^2`, `a b (a + b)` and
/// `a^2 b^2`. So the selection of pairs by products of one-particle weights (rank 2 or 3) is exact
/// for dense gases too.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct CollisionKernel {
    coefficients: [[f64; 3]; 3],
}

impl CollisionKernel {
    /// Creates the collision kernel of a dilute gas of hard disks or spheres in a volume
    /// \[length^D\], with contact values of one.
    pub fn dilute(dimension: usize, volume: f64) -> Self {
        let mut coefficients = [[0.0; 3]; 3];
        if dimension == 2 {
            coefficients[0][1] = 2.0 / volume;
        } else {
            coefficients[0][2] = PI / volume;
            coefficients[1][1] = 2.0 * PI / volume;
        }
        Self { coefficients }.symmetric()
    }

    /// Creates the collision kernel of a dense gas with Enskog's contact values. `moments[k]` is
    /// the sum over all particles of (2 a)^k, with radii a.
    pub fn dense(dimension: usize, volume: f64, moments: [f64; 4]) -> Self {
        let mut coefficients = [[0.0; 3]; 3];
        if dimension == 2 {
            let packing = PI / 4.0 * moments[2] / volume;
            let point = 1.0 / (1.0 - packing);
            let difference = equation_of_state::contact_value(packing) - point;
            coefficients[0][1] = 2.0 * point / volume;
            // 2 d_i d_j M_1/((d_i + d_j) M_2) times (a + b) is 4 a b M_1/M_2.
            coefficients[1][1] = 8.0 * difference * moments[1] / moments[2] / volume;
        } else {
            let packing = PI / 6.0 * moments[3] / volume;
            let surface = PI / 6.0 * moments[2] / volume;
            let free = 1.0 - packing;
            coefficients[0][2] = PI / volume / free;
            coefficients[1][1] = 2.0 * PI / volume / free;
            // d_i d_j/(d_i + d_j) is 2 a b/(a + b).
            coefficients[1][2] = 6.0 * PI / volume * surface / (free * free);
            coefficients[2][2] = 8.0 * PI / volume * surface * surface / (free * free * free);
        }
        Self { coefficients }.symmetric()
    }

    /// Creates the collision kernel of a gas with the given particle radii \[length\] in a volume
    /// \[length^D\].
    pub fn of_gas(
        contact: PairCorrelationFactor,
        dimension: usize,
        volume: f64,
        radii: impl Iterator<Item = f64>,
    ) -> Self {
        match contact {
            PairCorrelationFactor::Dilute => Self::dilute(dimension, volume),
            PairCorrelationFactor::Enskog => {
                let mut moments = [0.0; 4];
                for radius in radii {
                    let d = 2.0 * radius;
                    for (sum, power) in moments.iter_mut().zip([1.0, d, d * d, d * d * d]) {
                        *sum += power;
                    }
                }
                Self::dense(dimension, volume, moments)
            }
        }
    }

    fn symmetric(mut self) -> Self {
        for row in 0..3 {
            for column in 0..row {
                self.coefficients[row][column] = self.coefficients[column][row];
            }
        }
        self
    }

    /// Returns the kernel k(a, b) of two radii: the collision rate of a pair over its relative
    /// speed \[1/length\].
    #[inline]
    pub fn rate_coefficient(&self, a: f64, b: f64) -> f64 {
        let m = &self.coefficients;
        let (sum, product) = (a + b, a * b);
        let squares = sum * sum - 2.0 * product;
        m[0][0]
            + m[0][1] * sum
            + m[1][1] * product
            + m[0][2] * squares
            + m[1][2] * product * sum
            + m[2][2] * product * product
    }

    /// Returns the coefficients `sum_s a^s M_st` of the powers t = 0, 1, 2 of a partner's radius in
    /// the kernel, for a particle of radius `a`.
    #[inline]
    pub(crate) fn partner_weights(&self, a: f64) -> [f64; 3] {
        let m = &self.coefficients;
        [0, 1, 2].map(|t| m[0][t] + a * (m[1][t] + a * m[2][t]))
    }

    /// Returns the coefficients `M_st` of the collision kernel `sum_st M_st a^s b^t`.
    pub fn coefficients(&self) -> &[[f64; 3]; 3] {
        &self.coefficients
    }
}

/// Returns the powers 0, 1 and 2 of a radius.
#[inline]
pub(crate) fn powers(a: f64) -> [f64; 3] {
    [1.0, a, a * a]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Kernels agree with the formulas as printed in the literature. Tolerance: a dozen roundings.
    #[test]
    fn kernels_are_rate_and_contact_value() {
        let volume = 7.0;
        let radii = [0.2, 0.5, 0.5, 0.9];
        let mut moments = [0.0; 4];
        for a in radii {
            for (power, sum) in moments.iter_mut().enumerate() {
                *sum += (2.0_f64 * a).powi(power as i32);
            }
        }
        let chi_plane = |a: f64, b: f64| {
            let packing = PI / 4.0 * moments[2] / volume;
            equation_of_state::mixture_contact_value(
                equation_of_state::contact_value(packing),
                packing,
                [2.0 * a, 2.0 * b],
                moments[1] / moments[2],
            )
        };
        let chi_space = |a: f64, b: f64| {
            let (packing, x) = (
                PI / 6.0 * moments[3] / volume,
                PI / 6.0 * moments[2] / volume,
            );
            let (free, l) = (1.0 - packing, 4.0 * a * b / (2.0 * a + 2.0 * b));
            1.0 / free + 3.0 * l * x / free.powi(2) + 2.0 * l * l * x * x / free.powi(3)
        };
        for a in radii {
            for b in radii {
                let plane = 2.0 * (a + b) / volume;
                let space = PI * (a + b).powi(2) / volume;
                let close = |found: f64, exact: f64| {
                    assert!((found / exact - 1.0).abs() < 4e-15, "{found} {exact}");
                };
                close(
                    CollisionKernel::dilute(2, volume).rate_coefficient(a, b),
                    plane,
                );
                close(
                    CollisionKernel::dilute(3, volume).rate_coefficient(a, b),
                    space,
                );
                close(
                    CollisionKernel::dense(2, volume, moments).rate_coefficient(a, b),
                    plane * chi_plane(a, b),
                );
                let dense = CollisionKernel::dense(3, volume, moments);
                close(dense.rate_coefficient(a, b), space * chi_space(a, b));
                let by_powers: f64 = dense
                    .partner_weights(a)
                    .iter()
                    .zip(powers(b))
                    .map(|(w, p)| w * p)
                    .sum();
                close(by_powers, dense.rate_coefficient(a, b));
            }
        }
    }
}
