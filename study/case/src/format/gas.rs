//! Section `[gas]` of a case file and its species: number, sizes, masses and laws of collision.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::json;

use super::restitution::RestitutionSpec;

/// Gas: its dimension, its particles, and their contacts.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct GasSpec {
    /// Disks in the plane (2) or spheres in space (3).
    #[serde(default = "two")]
    #[schemars(range(min = 2, max = 3))]
    pub dimension: u64,
    /// Number of particles. Left out where species, a start file or `box.width_over_critical_length` say it.
    #[schemars(range(min = 1, max = 2_000_000_000))]
    pub number: Option<u64>,
    /// Diameter of a particle. Default 1 in reduced units.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub diameter: Option<f64>,
    /// Mass of a particle. Default 1 in reduced units.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub mass: Option<f64>,
    /// Granular temperature T = m <v^2>/D at the start, an energy. Default 1 in reduced units.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub temperature: Option<f64>,
    /// Root of the mean squared speed at the start; it replaces `temperature`.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub rms_speed: Option<f64>,
    /// Normal restitution: a constant from 0 to 1, where 1 is elastic, a constant with elastic
    /// contacts below a threshold of speed, a viscoelastic law, or the Delta model, whose contacts
    /// also heat.
    #[serde(default)]
    pub restitution: RestitutionSpec,
    /// Tangential restitution, from -1 (smooth) to 1 (perfectly rough). Without it particles are
    /// smooth and do not spin.
    #[schemars(range(min = -1.0, max = 1.0))]
    pub tangential_restitution: Option<f64>,
    /// Moment of inertia over mass times squared radius. Default: 1/2 for disks, 2/5 for spheres.
    #[schemars(extend("exclusiveMinimum" = 0.0, "maximum" = 1.0))]
    pub reduced_inertia: Option<f64>,
    /// Volume of a gas without positions; an area in the plane.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub volume: Option<f64>,
    /// Particles `F_N` that each simulated one stands for, in a gas without positions; below 1,
    /// several stand for one. Numbers of particles are those that are simulated, and `volume / F_N`
    /// is their share of the volume. Default 1.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub particles_per_simulator: Option<f64>,
    /// Effect of density on collision rates in a gas without positions.
    #[serde(default)]
    pub pair_correlation: PairCorrelationSpec,
    /// Mean free path in the uniform box: all diameters are scaled so that it is this. For `dsmc-boltzmann` alone.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub mean_free_path: Option<f64>,
}

fn two() -> u64 {
    2
}

impl GasSpec {
    /// Returns the volume of the simulated gas \[length^D\]: `volume` over the particles per
    /// simulator.
    pub fn simulated_volume(&self) -> Option<f64> {
        Some(self.volume? / self.particles_per_simulator.unwrap_or(1.0))
    }
}

/// Effect of density on collision rates, by the contact value of the pair correlation.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum PairCorrelationSpec {
    /// No effect of density: the Boltzmann equation.
    #[default]
    Boltzmann,
    /// Contact values of mixtures: the Enskog equation.
    Enskog,
}

/// One species of particles.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SpeciesSpec {
    /// A name for tables and plots, of one species alone. Default: its number.
    #[schemars(length(min = 1))]
    pub name: Option<String>,
    /// Number of particles; this, `share` or `number_density`.
    #[schemars(range(min = 0, max = 2_000_000_000))]
    pub number: Option<u64>,
    /// Share of the particles `gas.number` that are of this species.
    #[schemars(extend("exclusiveMinimum" = 0.0, "maximum" = 1.0))]
    pub share: Option<f64>,
    /// Particles per volume, in a gas without positions; the number is the nearest whole one.
    #[schemars(range(min = 0.0))]
    pub number_density: Option<f64>,
    /// Diameter of a particle.
    #[serde(default = "super::unit")]
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub diameter: f64,
    /// Mass of a particle.
    #[serde(default = "super::unit")]
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub mass: f64,
    /// Granular temperature at the start. Default: that of the gas.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub temperature: Option<f64>,
    /// The species is so rare that the others do not notice it, and it does not meet itself.
    #[serde(default)]
    pub tracer: bool,
}

/// Power law of very many species: mass k, diameter `k^(1/D)`, number `N k^-exponent`, k = 1, 2, 3
/// and on.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PowerLaw {
    /// Number N of particles of mass 1.
    #[schemars(range(min = 1, max = 1_000_000_000))]
    pub monomers: u64,
    /// The exponent.
    #[schemars(range(min = 0.0, max = 20.0))]
    pub exponent: f64,
    /// Largest mass. Default: where the number falls to zero.
    #[schemars(range(min = 1, max = 100_000))]
    pub largest_mass: Option<u64>,
    /// Rounding of numbers to whole ones.
    #[serde(default)]
    pub rounding: Rounding,
}

/// Rounding of numbers of particles to whole ones.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Rounding {
    /// Numbers of particles rounded down.
    Down,
    /// Numbers of particles rounded to the nearest whole number.
    #[default]
    Nearest,
}

/// Particles of individual sizes from a continuous distribution.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PolydisperseSpec {
    /// Number of particles.
    #[schemars(range(min = 2, max = 100_000_000))]
    pub number: u64,
    /// Distribution of the diameters.
    pub distribution: DiameterDistribution,
    /// Mean diameter.
    #[serde(default = "super::unit")]
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub mean_diameter: f64,
    /// Standard deviation of the diameters over their mean.
    #[schemars(extend("exclusiveMinimum" = 0.0, "maximum" = 2.0))]
    pub relative_width: f64,
    /// Mass of a particle of diameter 1; masses grow as the power D of the diameter.
    #[serde(default = "super::unit")]
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub unit_mass: f64,
    /// Groups of like size, equally many particles in each, for which temperatures are measured and
    /// theory is solved.
    #[serde(default = "twelve")]
    #[schemars(range(min = 1, max = 200))]
    pub groups: u64,
}

fn twelve() -> u64 {
    12
}

/// Distribution of the diameters of particles.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum DiameterDistribution {
    /// Uniform distribution of diameters, from the mean less to the mean plus `sqrt(3)` standard
    /// deviations.
    Uniform,
    /// Log-normal distribution: the logarithm of the diameter is normally distributed.
    LogNormal,
}

/// Restitution of a pair of species.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PairSpec {
    /// The two species, counted from 1.
    #[schemars(extend("items" = json!({"type": "integer", "minimum": 1})))]
    pub species: [u64; 2],
    /// Normal restitution of the pair.
    pub restitution: RestitutionSpec,
}

/// Rule of aggregation and fragmentation: when particles stick together or break. Without
/// thresholds every pair that meets sticks.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AggregationSpec {
    /// Energy below which pairs stick. Default: they always stick unless they break.
    #[schemars(range(min = 0.0))]
    pub aggregate_below: Option<f64>,
    /// Relative speed below which pairs stick, whatever their masses, in place of `aggregate_below`.
    #[schemars(range(min = 0.0))]
    pub aggregate_below_speed: Option<f64>,
    /// Part of the relative motion that is compared with `aggregate_below` or its speed.
    #[serde(default)]
    pub aggregate_energy_part: EnergyPart,
    /// Energy above which pairs with three monomers or more break into monomers. Default: they
    /// never break.
    #[schemars(range(min = 0.0))]
    pub fragment_above: Option<f64>,
    /// Relative speed above which they break, whatever their masses, in place of `fragment_above`.
    #[schemars(range(min = 0.0))]
    pub fragment_above_speed: Option<f64>,
    /// Part of the relative motion that is compared with `fragment_above` or its speed.
    #[serde(default)]
    pub fragment_energy_part: EnergyPart,
    /// Test that comes first where both hold.
    #[serde(default)]
    pub check_first: FirstTest,
    /// Factor of the relative speed in breaking.
    #[serde(default = "super::unit")]
    #[schemars(range(min = 0.0, max = 1.0))]
    pub fragment_speed_factor: f64,
}

impl AggregationSpec {
    /// Returns true if some colliding pairs do not stick together.
    pub fn may_bounce(&self) -> bool {
        self.aggregate_below.is_some() || self.aggregate_below_speed.is_some() || self.breaks()
    }

    /// Returns true if some colliding pairs break into monomers.
    pub fn breaks(&self) -> bool {
        self.fragment_above.is_some() || self.fragment_above_speed.is_some()
    }
}

/// Part of the kinetic energy of the relative motion of a pair.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum EnergyPart {
    /// All of the energy of the relative motion, `mu g^2/2`.
    #[default]
    Full,
    /// Energy of the motion along the line of centres, `mu (g . e)^2/2`.
    Normal,
}

/// Test of a colliding pair that comes first where both apply.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum FirstTest {
    /// Test for aggregation first.
    #[default]
    Aggregation,
    /// Test for fragmentation first.
    Fragmentation,
}
