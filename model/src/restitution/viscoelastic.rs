//! Viscoelastic restitution, which falls with the approach speed, by a series and its Padé form.

use super::normal_law::Restitution;
use crate::invalid::InvalidValue;

/// Viscoelastic law of spheres: restitution falls with the approach speed g as a function of v* =
/// strength * g^(1/10).
///
/// With the material constants of Brilliantov et al., Phys. Rev. E 53, 5382 (1996),
/// doi:10.1103/PhysRevE.53.5382, strength = (A kappa^(2/5))^(1/2) in units of \[speed\]^(-1/10). Up
/// to v* = 0.5 the series eps = 1 + sum `h_n` v*^n (Schwager & Pöschel 1998, with the contact
/// ending when the force vanishes) is used, exact there to 1e-7. Beyond v* = 0.5 it is the Padé
/// form of Müller & Pöschel, Phys. Rev. E 84, 021302 (2011), doi:10.1103/PhysRevE.84.021302, off by
/// at most 8e-3. The two meet with a step of 4e-4 at v* = 0.5.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Viscoelastic(f64);

/// Coefficients `h_1` ... `h_20` of the series of the restitution in powers of v*.
const SERIES: [f64; 20] = [
    0.0,
    -1.153_448_9,
    0.0,
    0.798_266_56,
    4.0 / 15.0,
    -0.522_882_57,
    -0.461_379_54,
    0.348_742_68,
    0.452_351_05,
    -0.146_431_47,
    -0.367_728_3,
    -0.043_248_983,
    0.281_804_23,
    0.147_852_59,
    -0.179_442_06,
    -0.178_466_03,
    0.065_933_589,
    0.171_358_62,
    0.025_249_822,
    -0.137_923_5,
];

impl Viscoelastic {
    /// Creates the viscoelastic law with a strength \[speed^(-1/10)\].
    ///
    /// # Errors
    /// [`InvalidValue`] unless it is positive and finite.
    pub fn new(strength: f64) -> Result<Self, InvalidValue> {
        InvalidValue::unless_positive("viscoelastic strength", strength).map(Self)
    }

    /// Returns the strength of the viscoelastic dissipation \[speed^(-1/10)\].
    pub fn strength(self) -> f64 {
        self.0
    }
}

impl Restitution for Viscoelastic {
    // Never inlined: its power and its polynomials would crowd the loops of engines whose law is
    // constant.
    #[inline(never)]
    fn normal_restitution(&self, approach: f64) -> f64 {
        let v = self.0 * approach.powf(0.1);
        if v <= 0.5 {
            1.0 + v * SERIES.iter().rev().fold(0.0, |sum, h| sum * v + h)
        } else {
            let above = 1.0 + 0.501_086 * v;
            let below = 1.0 + v * (0.501_086 + v * (1.153_45 + v * (0.577_977 + v * 0.532_178)));
            above / below
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Exact values of the contact equation, integrated independently.
    #[test]
    fn viscoelastic_restitution_matches_the_integrated_contact() {
        // Tolerances: the stated accuracy of series and Padé form.
        for (v, exact, tolerance) in [
            (0.1, 0.988_547_44, 1e-7),
            (0.3, 0.902_851_77, 1e-7),
            (0.5, 0.760_037_16, 1e-6),
            (0.7, 0.600_772_27, 3e-3),
            (1.0, 0.393_930_60, 5e-3),
            (2.0, 0.092_999_59, 9e-3),
        ] {
            let law = Viscoelastic::new(v).expect("positive");
            let found = law.normal_restitution(1.0);
            assert!((found - exact).abs() < tolerance, "v* = {v}: {found}");
        }
        let law = Viscoelastic::new(0.4).expect("positive");
        assert_eq!(law.normal_restitution(0.0), 1.0);
    }

    #[test]
    fn a_strength_is_positive() {
        assert!(Viscoelastic::new(0.0).is_err());
        assert!(Viscoelastic::new(f64::INFINITY).is_err());
    }
}
