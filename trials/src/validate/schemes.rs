//! Schemes to validate, as data: their parameters, their refinement, and their claims.
//!
//! To add one, add an entry to [`METHODS`]. Quantities that a scheme does not claim are measured
//! and stated, too.

use stosszahl_dsmc::{Neighbourhood, Parameters, PartnerDisplacement, Scheme};

use crate::gas::PLAIN;

/// Quantity measured of a scheme.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SchemeQuantity {
    /// Collision rate of a disk in an elastic gas, over Enskog's.
    CollisionRate,
    /// Pressure p/(nT) of an elastic gas from the flux of momentum, over the pressure of hard
    /// disks.
    Pressure,
    /// Self-diffusion of an elastic gas over Enskog's.
    Diffusion,
    /// Shear viscosity of an elastic gas over Enskog's, from the decay of a shear wave.
    Viscosity,
    /// Energy of transverse velocity modes over T.
    Transverse,
    /// Energy of longitudinal velocity modes over T.
    Longitudinal,
    /// Structure factor S(k → 0), over the compressibility of hard disks.
    Compressibility,
    /// Energy of the homogeneously cooling gas over Haff's law.
    Cooling,
    /// Fourth cumulant a2 of the cooling gas.
    Cumulant,
    /// Growth of shear modes of an unstable gas.
    Growth,
    /// Limit of vanishing weight, cell or step.
    Limit,
}

/// Resolution of a scheme.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SchemeSetting {
    /// Cells of two diameters, one simulator for each disk: those of Luding, Müller & McNamara
    /// (1998).
    Single,
    /// Cells of two diameters, eight simulators for each disk.
    Eight,
    /// Cells and simulators of the scheme's refined setting, [`Method::refined`].
    Refined,
    /// Default cells and time steps, with four simulators for each disk.
    Own,
}

impl SchemeSetting {
    /// Settings of all schemes, from coarse to fine.
    pub const ALL: [Self; 3] = [Self::Single, Self::Eight, Self::Refined];

    /// Returns the name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Single => "single",
            Self::Eight => "eight",
            Self::Refined => "refined",
            Self::Own => "own",
        }
    }
}

/// Scheme and its claims.
#[derive(Clone, Copy, Debug)]
pub struct Method {
    /// Name on the command line and in tables.
    pub name: &'static str,
    /// True if the command fails if a claim of the scheme does.
    pub default: bool,
    /// Numerical parameters of the scheme; the setting gives cells and simulators.
    pub parameters: Parameters,
    /// Side of a cell over the diameter, and simulators for each disk, at the refined setting.
    pub refined: (f64, u32),
    /// Claims at each setting, in the order of [`SchemeSetting::ALL`]; in its own cells the scheme
    /// claims what it claims with eight simulators.
    pub claims: [&'static [SchemeQuantity]; 3],
}

impl Method {
    /// Returns the numerical parameters at a setting.
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

    /// Returns true if the scheme claims a quantity at a setting.
    pub fn claims(&self, setting: SchemeSetting, quantity: SchemeQuantity) -> bool {
        let place = match setting {
            SchemeSetting::Single => 0,
            SchemeSetting::Eight | SchemeSetting::Own => 1,
            SchemeSetting::Refined => 2,
        };
        self.claims[place].contains(&quantity)
    }

    /// Creates a scheme that claims nothing, in cells of two diameters or finer ones.
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

    /// Returns this scheme with partners a diameter apart, which gives it a pressure.
    const fn displaced(mut self) -> Self {
        self.parameters.displacement = PartnerDisplacement::Diameter;
        self
    }

    /// Returns this scheme with half a diameter for a cell and 64 simulators for each disk at the
    /// refined setting.
    const fn finer(mut self) -> Self {
        self.refined = (0.5, 64);
        self
    }

    /// Returns this scheme with claims.
    const fn claiming(mut self, claims: [&'static [SchemeQuantity]; 3]) -> Self {
        self.claims = claims;
        self
    }
}

use SchemeQuantity::{
    CollisionRate, Cooling, Cumulant, Diffusion, Limit, Longitudinal, Pressure, Transverse,
    Viscosity,
};

/// Scheme with Enskog's rate at the mean density.
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

/// Default scheme, contact-point.
pub const CONTACT_POINT: Method = {
    let scheme = Scheme::ContactPoint { radius: None };
    let mut method = Method::new("contact-point", scheme, 8.0).finer();
    method.default = true;
    method.parameters.max_contact_value = 100.0;
    method.claiming([DENSE, DENSE, ALL])
};

/// All schemes that are validated.
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
