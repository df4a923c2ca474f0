//! Monte Carlo schemes to validate, as data: their parameters, their resolutions, and their claims.
//!
//! To add one, add an entry to [`METHODS`]. Quantities that a scheme does not claim are measured
//! and stated, too.

use stosszahl_dsmc::{Neighbourhood, Parameters, PartnerDisplacement, Scheme};

use crate::gas::PLAIN;

/// Quantity by which a Monte Carlo scheme is validated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SchemeQuantity {
    /// Collision rate per disk in an elastic gas, over Enskog's.
    CollisionRate,
    /// Pressure p/(nT) of an elastic gas from the momentum flux, over that of hard disks.
    Pressure,
    /// Self-diffusion coefficient of an elastic gas, over Enskog's.
    Diffusion,
    /// Shear viscosity of an elastic gas over Enskog's, from the decay of a shear wave.
    Viscosity,
    /// Energy of transverse velocity modes in an elastic gas, over T.
    Transverse,
    /// Energy of longitudinal velocity modes in an elastic gas, over T.
    Longitudinal,
    /// Structure factor S(k → 0) of an elastic gas, over the compressibility of hard disks.
    Compressibility,
    /// Kinetic energy of the homogeneously cooling gas, over Haff's law.
    Cooling,
    /// Fourth cumulant a2 of the velocities of the homogeneously cooling gas.
    Cumulant,
    /// Growth of shear modes in a cooling gas larger than the critical length.
    Growth,
    /// Extrapolated results at vanishing simulator weight, cell size or time step.
    Limit,
}

/// Resolution at which a Monte Carlo scheme is validated: cell size and simulators per disk.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SchemeSetting {
    /// Cells of two diameters with one simulator per disk, as in Luding, Müller & McNamara (1998).
    Single,
    /// Cells of two diameters with eight simulators per disk.
    Eight,
    /// Cell size and simulators per disk of the scheme's refined setting, [`Method::refined`].
    Refined,
    /// Default cells and time steps of the scheme, with four simulators per disk.
    Own,
}

impl SchemeSetting {
    /// Resolutions at which all schemes are validated, from coarse to fine.
    pub const ALL: [Self; 3] = [Self::Single, Self::Eight, Self::Refined];

    /// Returns the name of the resolution in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Single => "single",
            Self::Eight => "eight",
            Self::Refined => "refined",
            Self::Own => "own",
        }
    }
}

/// Monte Carlo scheme under validation, with its numerical parameters and its claims.
#[derive(Clone, Copy, Debug)]
pub struct Method {
    /// Name of the scheme on the command line and in tables.
    pub name: &'static str,
    /// True for the default scheme: the validation fails if one of its claims does.
    pub default: bool,
    /// Numerical parameters of the scheme, except cell size and simulators per disk, which the
    /// resolution sets.
    pub parameters: Parameters,
    /// Cell size over the diameter, and simulators per disk, at the refined resolution.
    pub refined: (f64, u32),
    /// Quantities that the scheme claims at each resolution, in the order of
    /// [`SchemeSetting::ALL`]. In its own cells it claims those of eight simulators.
    pub claims: [&'static [SchemeQuantity]; 3],
}

impl Method {
    /// Returns the numerical parameters of the scheme at a resolution.
    pub fn parameters_at(&self, setting: SchemeSetting) -> Parameters {
        let (cell, simulators) = match setting {
            SchemeSetting::Single => (2.0, 1),
            SchemeSetting::Eight => (2.0, 8),
            SchemeSetting::Refined => self.refined,
            SchemeSetting::Own => {
                return Parameters {
                    simulators_per_particle: 4,
                    ..Parameters::for_scheme(self.parameters.scheme)
                };
            }
        };
        Parameters {
            cell_size: Some(cell),
            simulators_per_particle: simulators,
            ..self.parameters
        }
    }

    /// Returns true if the scheme claims a quantity at a resolution.
    pub fn claims(&self, setting: SchemeSetting, quantity: SchemeQuantity) -> bool {
        let place = match setting {
            SchemeSetting::Single => 0,
            SchemeSetting::Eight | SchemeSetting::Own => 1,
            SchemeSetting::Refined => 2,
        };
        self.claims[place].contains(&quantity)
    }

    /// Creates a Monte Carlo scheme that claims nothing, with a refined resolution of one diameter
    /// and 16 simulators per disk.
    const fn new(name: &'static str, scheme: Scheme, steps_per_cell_crossing: f64) -> Self {
        Self {
            name,
            default: false,
            parameters: Parameters {
                scheme,
                steps_per_cell_crossing,
                ..PLAIN
            },
            refined: (1.0, 16),
            claims: [&[]; 3],
        }
    }

    /// Displaces the scheme's collision partners by one diameter, which gives it a collisional
    /// pressure.
    const fn displaced(mut self) -> Self {
        self.parameters.displacement = PartnerDisplacement::Diameter;
        self
    }

    /// Sets the scheme's refined resolution to cells of half a diameter and 64 simulators per disk.
    const fn finer(mut self) -> Self {
        self.refined = (0.5, 64);
        self
    }

    /// Sets the quantities that the scheme claims at each resolution.
    const fn claiming(mut self, claims: [&'static [SchemeQuantity]; 3]) -> Self {
        self.claims = claims;
        self
    }
}

use SchemeQuantity::{
    CollisionRate, Cooling, Cumulant, Diffusion, Limit, Longitudinal, Pressure, Transverse,
    Viscosity,
};

/// Enskog scheme with the collision rate at the mean density of the gas.
const MEAN: Scheme = Scheme::Enskog(Neighbourhood::Mean);
const CELLS: &[SchemeQuantity] = &[CollisionRate, Transverse, Longitudinal];
const NOISE: &[SchemeQuantity] = &[Transverse, Longitudinal];
const DENSE: &[SchemeQuantity] = &[CollisionRate, Pressure, Transverse, Longitudinal];
const ALL: &[SchemeQuantity] = &[
    CollisionRate,
    Pressure,
    Diffusion,
    Viscosity,
    Transverse,
    Longitudinal,
    Cooling,
    Cumulant,
    Limit,
];

/// Contact-point scheme under validation, the default Monte Carlo scheme, with its claims.
pub const CONTACT_POINT: Method = {
    let scheme = Scheme::ContactPoint { radius: None };
    let mut method = Method::new("contact-point", scheme, 8.0).finer();
    method.default = true;
    method.parameters.max_contact_value = 100.0;
    method.claiming([DENSE, DENSE, ALL])
};

/// All Monte Carlo schemes under validation.
pub const METHODS: &[Method] = &[
    // chi = 1: the Boltzmann equation of a dilute gas, measured against Enskog's to show what
    // density does.
    Method::new("boltzmann", Scheme::Boltzmann, 4.0),
    // That of Luding, Müller & McNamara (1998).
    Method::new("free-volume", Scheme::FreeVolume, 4.0).displaced(),
    // Enskog's rate in cells, without and with the displacement that gives it a pressure.
    Method::new("enskog", MEAN, 4.0).claiming([CELLS, CELLS, &[]]),
    Method::new("enskog-displaced", MEAN, 4.0).displaced(),
    Method::new("esmc", Scheme::Esmc(Neighbourhood::Cells(2)), 8.0).finer(),
    // A fluid of penetrable disks, soft and stiff. Its cells are always one diameter wide.
    Method::new("stochastic-disks", stochastic(1.0), 20.0).claiming([NOISE, &[], &[]]),
    Method::new("stochastic-disks-stiff", stochastic(4.0), 40.0).claiming([NOISE, &[], &[]]),
    CONTACT_POINT,
];

const fn stochastic(stiffness: f64) -> Scheme {
    Scheme::StochasticDisks { stiffness }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    #[test]
    fn names_are_unique_and_one_scheme_is_the_default() {
        let names: BTreeSet<_> = METHODS.iter().map(|method| method.name).collect();
        assert_eq!(names.len(), METHODS.len());
        assert_eq!(METHODS.iter().filter(|method| method.default).count(), 1);
    }
}
