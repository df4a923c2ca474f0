//! The thermostat: scaling of velocities, or a bath of random kicks.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::Case;

/// Thermostat of the gas: scaling of velocities, or a bath of random kicks.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ThermostatSpec {
    /// Kind of the thermostat.
    pub kind: ThermostatKind,
    /// Time between two scalings or kicks. Default of "langevin": a fifth of the time in which
    /// collisions and drag change a velocity.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub interval: Option<f64>,
    /// Energy that each particle gains on average by "white-noise", in temperatures of the start
    /// for each unit of time.
    #[schemars(extend("exclusiveMinimum" = 0.0, "maximum" = 1e12))]
    pub heating: Option<f64>,
    /// Rate gamma at which "langevin" damps velocities, one over the unit of time.
    #[schemars(extend("exclusiveMinimum" = 0.0, "maximum" = 1e12))]
    pub drag: Option<f64>,
    /// Temperature of the bath of "langevin", an energy. Default: that of the start.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub bath_temperature: Option<f64>,
}

/// Way in which `[thermostat]` acts on the velocities.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ThermostatKind {
    /// Scaling of all velocities to the energy of the start, in gases without positions or in a
    /// periodic box.
    Rescaling,
    /// White noise: independent random kicks, in any box.
    WhiteNoise,
    /// Langevin bath: drag and random kicks of a bath at rest with a temperature, in any box.
    Langevin,
}

impl Case {
    /// Returns the thermostat if it is a bath: white noise or Langevin.
    pub fn bath(&self) -> Option<&ThermostatSpec> {
        self.thermostat
            .as_ref()
            .filter(|one| one.kind != ThermostatKind::Rescaling)
    }

    /// Returns the time between two scalings of all velocities; `None` without scaling.
    pub fn rescaling(&self) -> Option<f64> {
        let thermostat = self.thermostat.as_ref()?;
        thermostat
            .interval
            .filter(|_| thermostat.kind == ThermostatKind::Rescaling)
    }
}
