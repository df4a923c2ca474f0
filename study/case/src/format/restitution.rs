//! Laws of normal restitution in the case format: their keys, checks and properties.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::json;

/// Normal restitution.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum RestitutionSpec {
    /// Constant restitution at every approach speed.
    Constant(#[schemars(range(min = 0.0, max = 1.0))] f64),
    /// Delta model: a pair that approaches at the normal speed g separates at `coefficient * g +
    /// 2 * delta`.
    Delta(DeltaModelSpec),
    /// Threshold model: a constant for normal approach speeds from a threshold on; slower contacts
    /// are elastic.
    Threshold(ThresholdModelSpec),
    /// Viscoelastic restitution, which falls with the approach speed.
    Viscoelastic(ViscoelasticSpec),
}

impl Default for RestitutionSpec {
    fn default() -> Self {
        Self::Constant(1.0)
    }
}

impl RestitutionSpec {
    /// Returns a description of the restitution law for a title.
    pub fn title(&self) -> String {
        match self {
            Self::Constant(restitution) => format!("restitution {restitution}"),
            Self::Delta(_) => "delta model".to_owned(),
            Self::Threshold(law) => format!(
                "restitution {}, elastic below speed {}",
                law.coefficient, law.elastic_below
            ),
            Self::Viscoelastic(_) => "viscoelastic".to_owned(),
        }
    }

    /// Returns a coefficient of restitution, from 0 to 1, for estimates that do not depend on the
    /// approach speed.
    pub fn coefficient(&self) -> f64 {
        match self {
            Self::Constant(coefficient) => *coefficient,
            Self::Delta(law) => law.coefficient,
            Self::Threshold(law) => law.coefficient,
            Self::Viscoelastic(_) => 1.0,
        }
    }

    /// Returns true if contacts under this restitution law conserve energy.
    pub fn is_elastic(&self) -> bool {
        *self == Self::Constant(1.0)
    }

    /// Returns true if contacts under this restitution law may add energy.
    pub fn heats(&self) -> bool {
        matches!(self, Self::Delta(_))
    }

    /// Returns true if the restitution follows from material constants, so that it differs between
    /// pairs of species.
    pub fn is_of_material(&self) -> bool {
        matches!(self, Self::Viscoelastic(law) if law.material().is_some())
    }

    /// Checks which keys are given together; returns the allowed combination if they are invalid.
    pub(crate) fn fault(&self) -> Option<&'static str> {
        match self {
            Self::Constant(_) | Self::Delta(_) | Self::Threshold(_) => None,
            Self::Viscoelastic(law) => {
                let constants = [
                    law.young_modulus.is_some(),
                    law.poisson_ratio.is_some(),
                    law.viscosities.is_some(),
                ];
                let is_material = law.viscoelastic.is_none();
                let is_whole = constants.iter().all(|&given| given == is_material);
                (!is_whole).then_some(
                    "{ viscoelastic = STRENGTH }, or the constants of a material: young_modulus, poisson_ratio and viscosities",
                )
            }
        }
    }
}

/// Delta model, whose contacts dissipate and heat (Brito, Risso & Soto 2013): a shaken shallow
/// layer seen from above.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DeltaModelSpec {
    /// Share of the normal approach speed that is kept.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub coefficient: f64,
    /// Speed Delta, in the unit of the case; a contact adds twice this to the normal speed of
    /// separation.
    #[schemars(range(min = 0.0))]
    pub delta: f64,
}

/// Threshold model, whose contacts dissipate above a threshold of the approach speed alone
/// (Ben-Naim, Chen, Doolen & Redner 1999): the simplest law without inelastic collapse.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ThresholdModelSpec {
    /// Share of the normal approach speed that is kept.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub coefficient: f64,
    /// Threshold of the normal approach speed, in the unit of the case; slower contacts are elastic.
    #[schemars(range(min = 0.0))]
    pub elastic_below: f64,
}

/// Viscoelastic particles: their dissipation strength, or the constants of their material.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ViscoelasticSpec {
    /// Dissipation strength `(A kappa^(2/5))^(1/2)`; speeds are in units of the case, which are thermal speeds of the start where
    /// temperature and mass are 1.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub viscoelastic: Option<f64>,
    /// Young's modulus Y, in units of the case: an energy per volume. With it each pair of species
    /// has the strength that follows from its sizes and masses.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub young_modulus: Option<f64>,
    /// Poisson's ratio of the material.
    #[schemars(extend("exclusiveMinimum" = -1.0, "maximum" = 0.5))]
    pub poisson_ratio: Option<f64>,
    /// Viscosities of shear and of bulk of the material, each an energy times a time per volume.
    #[schemars(extend("items" = json!({"type": "number", "minimum": 0.0})))]
    pub viscosities: Option<[f64; 2]>,
}

impl ViscoelasticSpec {
    /// Returns Young's modulus, Poisson's ratio and both viscosities of the material; `None` unless
    /// all are given.
    pub fn material(&self) -> Option<(f64, f64, [f64; 2])> {
        Some((self.young_modulus?, self.poisson_ratio?, self.viscosities?))
    }
}
