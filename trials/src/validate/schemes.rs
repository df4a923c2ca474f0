//! The schemes that are validated, as data: what they are, how they are refined, and what each claims.
//!
//! To add one, add an entry to [`METHODS`]. Whatever a scheme does not claim is measured all the same and stated.

use stosszahl_dsmc::{Displacement, Neighbourhood, Parameters, Scheme};

use crate::gas::PLAIN;

/// What is measured of a scheme.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// Collisions of a disk in an elastic gas, over Enskog's.
    CollisionRate,
    /// p/(nT) of an elastic gas from the flux of momentum, over that of hard disks.
    Pressure,
    /// Self-diffusion of an elastic gas over Enskog's.
    Diffusion,
    /// Shear viscosity of an elastic gas over Enskog's, from the decay of a shear wave.
    Viscosity,
    /// Energy of transverse velocity modes over T.
    Transverse,
    /// Energy of longitudinal velocity modes over T.
    Longitudinal,
    /// S(k → 0), over the compressibility of hard disks.
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

/// How finely a scheme is resolved.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Setting {
    /// Cells of two diameters, one simulator for each disk: those of Luding, Müller & McNamara (1998).
    Single,
    /// Cells of two diameters, eight simulators for each disk.
    Eight,
    /// As finely as the scheme says.
    Refined,
}

impl Setting {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Single, Self::Eight, Self::Refined];

    /// Its name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Single => "single",
            Self::Eight => "eight",
            Self::Refined => "refined",
        }
    }
}

/// What is claimed at a setting.
pub type Claims = &'static [(Setting, &'static [Quantity])];

/// A scheme and what it is held to.
#[derive(Clone, Copy, Debug)]
pub struct Method {
    /// Its name on the command line and in tables.
    pub name: &'static str,
    /// Whether the command fails if a claim of it does.
    pub default: bool,
    /// Its numerical choices; cells and simulators are those of the setting.
    pub parameters: Parameters,
    /// Side of a cell over the diameter, and simulators for each disk, at the refined setting.
    pub refined: (f64, u32),
    /// What it claims.
    pub claims: Claims,
}

impl Method {
    /// Numerical choices at a setting.
    pub fn at(&self, setting: Setting) -> Parameters {
        let (cell, simulators) = match setting {
            Setting::Single => (2.0, 1),
            Setting::Eight => (2.0, 8),
            Setting::Refined => self.refined,
        };
        Parameters {
            cell_size: Some(cell),
            simulators_per_disk: simulators,
            ..self.parameters
        }
    }

    /// Whether it claims a quantity at a setting.
    pub fn claims(&self, setting: Setting, quantity: Quantity) -> bool {
        self.claims
            .iter()
            .any(|(at, quantities)| *at == setting && quantities.contains(&quantity))
    }
}

/// Enskog's rate with the mean density.
const MEAN: Parameters = Parameters {
    scheme: Scheme::Enskog(Neighbourhood::Mean),
    ..PLAIN
};

use Quantity::{
    CollisionRate, Cooling, Cumulant, Diffusion, Limit, Longitudinal, Pressure, Transverse,
    Viscosity,
};

/// The schemes.
pub const METHODS: &[Method] = &[
    // chi = 1: the Boltzmann equation of a dilute gas, measured against Enskog's to show what density does.
    Method {
        name: "boltzmann",
        default: false,
        parameters: Parameters {
            scheme: Scheme::Boltzmann,
            ..MEAN
        },
        refined: (1.0, 16),
        claims: &[],
    },
    // The paper's.
    Method {
        name: "free-volume",
        default: false,
        parameters: Parameters {
            scheme: Scheme::FreeVolume,
            displacement: Displacement::Diameter,
            ..MEAN
        },
        refined: (1.0, 16),
        claims: &[],
    },
    // Enskog's rate in cells, without and with the displacement that gives it a pressure.
    Method {
        name: "enskog",
        default: false,
        parameters: MEAN,
        refined: (1.0, 16),
        claims: &[
            (Setting::Single, &[CollisionRate, Transverse, Longitudinal]),
            (Setting::Eight, &[CollisionRate, Transverse, Longitudinal]),
        ],
    },
    Method {
        name: "enskog-displaced",
        default: false,
        parameters: Parameters {
            displacement: Displacement::Diameter,
            ..MEAN
        },
        refined: (1.0, 16),
        claims: &[],
    },
    Method {
        name: "esmc",
        default: false,
        parameters: Parameters {
            scheme: Scheme::Esmc(Neighbourhood::Cells(2)),
            steps_per_crossing: 8.0,
            ..MEAN
        },
        refined: (0.5, 64),
        claims: &[],
    },
    // A fluid of penetrable disks, soft and stiff. Its cells are always one diameter wide.
    Method {
        name: "stochastic-disks",
        default: false,
        parameters: Parameters {
            scheme: Scheme::StochasticDisks { stiffness: 1.0 },
            steps_per_crossing: 20.0,
            ..MEAN
        },
        refined: (1.0, 16),
        claims: &[(Setting::Single, &[Transverse, Longitudinal])],
    },
    Method {
        name: "stochastic-disks-stiff",
        default: false,
        parameters: Parameters {
            scheme: Scheme::StochasticDisks { stiffness: 4.0 },
            steps_per_crossing: 40.0,
            ..MEAN
        },
        refined: (1.0, 16),
        claims: &[(Setting::Single, &[Transverse, Longitudinal])],
    },
    Method {
        name: "contact-point",
        default: true,
        parameters: Parameters {
            scheme: Scheme::ContactPoint { radius: None },
            steps_per_crossing: 8.0,
            largest_contact_value: 100.0,
            ..MEAN
        },
        refined: (0.5, 64),
        claims: &[
            (
                Setting::Single,
                &[CollisionRate, Pressure, Transverse, Longitudinal],
            ),
            (
                Setting::Eight,
                &[CollisionRate, Pressure, Transverse, Longitudinal],
            ),
            (
                Setting::Refined,
                &[
                    CollisionRate,
                    Pressure,
                    Diffusion,
                    Viscosity,
                    Transverse,
                    Longitudinal,
                    Cooling,
                    Cumulant,
                    Limit,
                ],
            ),
        ],
    },
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_unique_and_one_scheme_is_the_default() {
        for (index, method) in METHODS.iter().enumerate() {
            assert!(
                METHODS[..index]
                    .iter()
                    .all(|other| other.name != method.name)
            );
        }
        assert_eq!(METHODS.iter().filter(|method| method.default).count(), 1);
    }
}
