//! Transport in the fluid of elastic disks by Enskog's theory, split into kinetic and collisional
//! transfer.
//!
//! Units: diameter d, mass m and temperature T are one, so that self-diffusion comes in d
//! sqrt(T/m), viscosities in sqrt(m T)/d and heat conductivity in sqrt(T/m)/d, with Boltzmann's
//! constant one.
//!
//! With the packing fraction phi, the contact value chi and the dilute coefficients
//! `eta_0 = sqrt(m T/pi)/(2 d)` and `lambda_0 = 4 eta_0/m = (2/d) sqrt(T/(pi m))` in first Sonine
//! order,
//!
//! ```text
//! shear viscosity    eta    = (eta_0/chi) (1 + phi chi)² + zeta/2
//! bulk viscosity     zeta   = (16/pi) phi² chi eta_0
//! heat conductivity  lambda = (lambda_0/chi) (1 + 3 phi chi/2)² + zeta/m
//! ```
//!
//! (D. M. Gass, *Journal of Chemical Physics* **54**, 1898 (1971), doi:10.1063/1.1675116; for any
//! dimension S. Chapman & T. G. Cowling, *The Mathematical Theory of Non-Uniform Gases*, chapter
//! 16). All Sonine orders multiply `eta_0` by 1.022 and `lambda_0` by 1.029. The square is that of
//! the sum of a kinetic and a collisional flux: its three terms are the kinetic part, the part of
//! both, and a collisional part, to which the last term belongs.

use std::f64::consts::PI;

use crate::diffusion::self_diffusion;
use crate::transport::{DILUTE_VISCOSITY, VISCOSITY_ORDERS, bulk_viscosity};

/// Heat conductivity of dilute elastic disks in all Sonine orders, over that in first order (Gass
/// 1971).
pub const CONDUCTIVITY_ORDERS: f64 = 1.029;

/// Transport coefficient, split into kinetic, cross and collisional part.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CoefficientParts {
    /// Kinetic part: transport by the motion of disks between collisions.
    pub kinetic: f64,
    /// Cross part: correlation of the kinetic and the collisional flux.
    pub cross: f64,
    /// Collisional part: transport over the distance of two centres in collisions.
    pub collisional: f64,
}

impl CoefficientParts {
    /// Splits `(dilute/chi)(1 + share)²` into kinetic, cross and collisional part, and adds
    /// `beyond` to the collisional one.
    fn new(dilute: f64, contact_value: f64, share: f64, beyond: f64) -> Self {
        let kinetic = dilute / contact_value;
        Self {
            kinetic,
            cross: 2.0 * share * kinetic,
            collisional: share * share * kinetic + beyond,
        }
    }

    /// Returns the whole coefficient: the sum of its three parts.
    pub fn sum(&self) -> f64 {
        self.kinetic + self.cross + self.collisional
    }
}

/// Fluid of elastic disks, whose Enskog transport coefficients are computed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ElasticDisks {
    /// Packing fraction phi of the disks.
    pub packing_fraction: f64,
    /// Contact value chi of the pair correlation function.
    pub contact_value: f64,
}

impl ElasticDisks {
    /// Computes the self-diffusion coefficient \[d sqrt(T/m)\] in three Sonine orders.
    pub fn self_diffusion(&self) -> f64 {
        self_diffusion(self.packing_fraction, self.contact_value)
    }

    /// Computes the shear viscosity \[sqrt(m T)/d\] in Enskog theory.
    ///
    /// ```
    /// use stosszahl_theory::ElasticDisks;
    ///
    /// let dilute = ElasticDisks { packing_fraction: 0.0, contact_value: 1.0 };
    /// let known = 1.022 * 0.5 / std::f64::consts::PI.sqrt();
    /// assert!((dilute.shear_viscosity().sum() - known).abs() < 1e-15);
    /// ```
    pub fn shear_viscosity(&self) -> CoefficientParts {
        let share = self.packing_fraction * self.contact_value;
        let dilute = VISCOSITY_ORDERS * DILUTE_VISCOSITY;
        CoefficientParts::new(
            dilute,
            self.contact_value,
            share,
            0.5 * self.bulk_viscosity(),
        )
    }

    /// Computes the bulk viscosity \[sqrt(m T)/d\] in Enskog theory; it has a collisional part
    /// only.
    pub fn bulk_viscosity(&self) -> f64 {
        bulk_viscosity(self.packing_fraction, self.contact_value, 1.0)
    }

    /// Computes the heat conductivity \[sqrt(T/m)/d\] in Enskog theory.
    pub fn heat_conductivity(&self) -> CoefficientParts {
        let share = 1.5 * self.packing_fraction * self.contact_value;
        let dilute = CONDUCTIVITY_ORDERS * 2.0 / PI.sqrt();
        CoefficientParts::new(dilute, self.contact_value, share, self.bulk_viscosity())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::transport::elastic_viscosity;

    /// In Gass's form, `eta = eta_0 b [1/(b chi) + 1 + 0.8729 b chi] ` and
    /// `lambda = lambda_0 b [1/(b chi) + 3/2 + 0.8718 b chi]` with b = 2 phi, whose numbers have
    /// four digits; and the sum of the viscosity is that of the model.
    #[test]
    fn coefficients_are_those_of_gass() {
        for (phi, chi) in [(1e-3, 1.01), (0.25, 1.58), (0.5, 3.2)] {
            let fluid = ElasticDisks {
                packing_fraction: phi,
                contact_value: chi,
            };
            let b = 2.0 * phi;
            let form = |dilute: f64, cross: f64, last: f64| {
                [1.0 / chi, cross * b, last * b * b * chi].map(|one| one * dilute)
            };
            for (found, known) in [
                (
                    fluid.shear_viscosity(),
                    form(1.022 * DILUTE_VISCOSITY, 1.0, 0.8729),
                ),
                (
                    fluid.heat_conductivity(),
                    form(1.029 * 2.0 / PI.sqrt(), 1.5, 0.8718),
                ),
            ] {
                assert!((found.kinetic / known[0] - 1.0).abs() < 1e-14);
                assert!((found.cross / known[1] - 1.0).abs() < 1e-14);
                // Half a unit of the fourth digit.
                assert!(
                    (found.collisional / known[2] - 1.0).abs() < 0.6e-4,
                    "{found:?}"
                );
            }
            let viscosity = fluid.shear_viscosity().sum();
            assert!((viscosity / elastic_viscosity(phi, chi) - 1.0).abs() < 1e-14);
        }
    }
}
