//! Viscoelastic restitution from the material constants of spheres: elastic modulus, Poisson's
//! ratio and viscosities.

use super::viscoelastic::Viscoelastic;
use crate::invalid::InvalidValue;

/// Material constants of viscoelastic spheres: Young's modulus, Poisson's ratio, and viscosities of
/// shear and of bulk.
///
/// Spheres of radii `R_1` and `R_2` that overlap by x push each other apart with the force
/// `rho (x^(3/2) + (3/2) A x^(1/2) dx/dt)`, `rho = 2 Y R_eff^(1/2)/(3 (1 - nu^2))`, as Hertz and
/// Brilliantov et al., Phys. Rev. E 53, 5382 (1996), doi:10.1103/PhysRevE.53.5382, found. The
/// dissipative time A is that of Goldobin et al. (2015) in Bodrova & Osinsky (2024), Eq. A2:
/// `A = (1 + nu)/((1 - nu) Y) ((4/3) eta_1 (1 - nu + nu^2) + eta_2 (1 - 2 nu)^2)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Material {
    young_modulus: f64,
    poisson_ratio: f64,
    viscosities: [f64; 2],
}

impl Material {
    /// Creates material constants: Young's modulus Y \[energy/length^3\], Poisson's ratio nu, and
    /// the viscosities of shear `eta_1` and of bulk `eta_2` \[energy time/length^3\].
    ///
    /// # Errors
    /// [`InvalidValue`] unless the modulus is positive, the ratio above -1 and at most 1/2, and
    /// viscosities are at least zero and make a dissipative time above zero.
    pub fn new(
        young_modulus: f64,
        poisson_ratio: f64,
        viscosities: [f64; 2],
    ) -> Result<Self, InvalidValue> {
        InvalidValue::unless_positive("Young's modulus", young_modulus)?;
        let is_ratio = poisson_ratio > -1.0 && poisson_ratio <= 0.5;
        let allowed = "numbers above -1 and at most 0.5";
        InvalidValue::require(is_ratio, "Poisson's ratio", poisson_ratio, allowed)?;
        for viscosity in viscosities {
            let is_viscosity = viscosity >= 0.0 && viscosity.is_finite();
            let allowed = "finite numbers, at least 0";
            InvalidValue::require(is_viscosity, "viscosity", viscosity, allowed)?;
        }
        let material = Self {
            young_modulus,
            poisson_ratio,
            viscosities,
        };
        InvalidValue::unless_positive("dissipative time of a material", material.time())?;
        Ok(material)
    }

    /// Returns the dissipative time A of the material \[time\].
    pub fn time(&self) -> f64 {
        let (nu, [shear, bulk]) = (self.poisson_ratio, self.viscosities);
        let viscosity = 4.0 / 3.0 * shear * (1.0 - nu + nu * nu) + bulk * (1.0 - 2.0 * nu).powi(2);
        (1.0 + nu) / ((1.0 - nu) * self.young_modulus) * viscosity
    }

    /// Returns the viscoelastic law between two spheres of these radii and masses: of strength `(A
    /// kappa^(2/5))^(1/2)`, `kappa = (3/2)^(3/2) Y R_eff^(1/2)/((1 - nu^2) m_eff)`, `R_eff = R_1
    /// R_2/(R_1 + R_2)`, `m_eff = m_1 m_2/(m_1 + m_2)` (Eqs. A3 to A5 of Bodrova & Osinsky, whose
    /// effective diameter is twice this radius).
    ///
    /// # Errors
    /// [`InvalidValue`] unless radii, masses and the strength are positive and finite.
    pub fn law_between(
        &self,
        radii: [f64; 2],
        masses: [f64; 2],
    ) -> Result<Viscoelastic, InvalidValue> {
        let effective = |[a, b]: [f64; 2]| 1.0 / (1.0 / a + 1.0 / b);
        let radius = InvalidValue::unless_positive("effective radius", effective(radii))?;
        let mass = InvalidValue::unless_positive("effective mass", effective(masses))?;
        let stiffness = self.young_modulus / (1.0 - self.poisson_ratio.powi(2));
        let kappa = 1.5_f64.powf(1.5) * stiffness * radius.sqrt() / mass;
        Viscoelastic::new((self.time() * kappa.powf(0.4)).sqrt())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Restitution;

    /// Restitution of the contact itself: `m_eff x'' = -rho (x^(3/2) + (3/2) A x^(1/2) x')` from
    /// x = 0 until the force vanishes.
    fn integrated(rho: f64, time: f64, mass: f64, approach: f64) -> f64 {
        let force = |x: f64, v: f64| {
            let root = x.max(0.0).sqrt();
            -rho / mass * (root * root * root + 1.5 * time * root * v)
        };
        // A contact lasts some 3 (m^2/(rho^2 g))^(1/5).
        let step = 1e-4 * (mass * mass / (rho * rho * approach)).powf(0.2);
        let (mut x, mut v) = (0.0, approach);
        loop {
            let (k1, l1) = (v, force(x, v));
            let (k2, l2) = (
                v + 0.5 * step * l1,
                force(x + 0.5 * step * k1, v + 0.5 * step * l1),
            );
            let (k3, l3) = (
                v + 0.5 * step * l2,
                force(x + 0.5 * step * k2, v + 0.5 * step * l2),
            );
            let (k4, l4) = (v + step * l3, force(x + step * k3, v + step * l3));
            x += step / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
            v += step / 6.0 * (l1 + 2.0 * l2 + 2.0 * l3 + l4);
            if v < 0.0 && x <= -1.5 * time * v {
                return -v / approach;
            }
        }
    }

    #[test]
    fn the_law_is_that_of_the_contact() {
        let material = Material::new(3e4, 0.3, [40.0, 25.0]).expect("a material");
        // Eq. A2 by hand: 1.3/(0.7 * 3e4) (4/3 * 40 * 0.79 + 25 * 0.16).
        assert!((material.time() - 1.3 / 2.1e4 * (160.0 / 3.0 * 0.79 + 4.0)).abs() < 1e-15);
        for (radii, masses) in [([0.5, 0.5], [1.0, 1.0]), ([0.5, 1.5], [1.0, 20.0])] {
            let radius = radii[0] * radii[1] / (radii[0] + radii[1]);
            let mass = masses[0] * masses[1] / (masses[0] + masses[1]);
            let rho = 2.0 * 3e4 * f64::sqrt(radius) / (3.0 * (1.0 - 0.09));
            let law = material.law_between(radii, masses).expect("a law");
            for approach in [0.01, 0.1] {
                let found = law.normal_restitution(approach);
                let exact = integrated(rho, material.time(), mass, approach);
                // The series is exact to 1e-7; steps of 1e-4 of a contact miss its end, where the
                // speed hardly changes, by less.
                assert!(law.strength() * approach.powf(0.1) < 0.5);
                assert!((0.8..0.97).contains(&exact), "{exact} shows little");
                assert!((found - exact).abs() < 1e-5, "{found} {exact}");
            }
        }
    }

    #[test]
    fn impossible_materials_are_refused() {
        for (modulus, ratio, viscosities) in [
            (0.0, 0.3, [1.0, 1.0]),
            (1.0, -1.0, [1.0, 1.0]),
            (1.0, 0.6, [1.0, 1.0]),
            (1.0, 0.3, [-1.0, 5.0]),
            (1.0, 0.3, [0.0, 0.0]),
            (1.0, 0.3, [f64::INFINITY, 0.0]),
            (f64::NAN, 0.3, [1.0, 1.0]),
        ] {
            assert!(Material::new(modulus, ratio, viscosities).is_err());
        }
        let steel = Material::new(1.0, 0.3, [1.0, 1.0]).expect("a material");
        assert!(steel.law_between([0.5, 0.0], [1.0, 1.0]).is_err());
    }
}
