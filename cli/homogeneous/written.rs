//! A case of a gas without positions as written: the keys, their types, their ranges and their defaults.
//!
//! As in the paired case, the doc comments are the descriptions of the JSON Schema, and ranges and `x-allowed` sentences are
//! read from it. Relations between keys are in [`super::validate`].

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A case file of the kind "homogeneous": one gas without positions, and what is measured on it.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Written {
    /// Version of the case format. The only one is 1.
    #[expect(
        dead_code,
        reason = "the version is checked before anything else is read"
    )]
    #[schemars(extend("const" = 1, "x-allowed" = "the only format is 1"))]
    pub format: u64,
    /// Kind of the case.
    #[expect(dead_code, reason = "the kind is checked before anything else is read")]
    #[schemars(extend("const" = "homogeneous", "x-allowed" = "this is a gas without positions, whose kind is \"homogeneous\""))]
    pub kind: String,
    /// What the case shows, in one line.
    #[schemars(extend("minLength" = 1, "x-allowed" = "a title is a text of at least one character"))]
    pub title: String,
    /// Seed of every random stream.
    #[serde(default = "one")]
    #[schemars(extend("minimum" = 0, "x-allowed" = "a seed is a whole number from 0 to 9223372036854775807"))]
    pub seed: u64,
    /// Number of independent runs, each with its own initial state; error bars come from their spread.
    #[serde(default = "four")]
    #[schemars(extend("minimum" = 1, "maximum" = 1_000_000, "x-allowed" = "a number of replicas is a whole number from 1 to 1000000"))]
    pub replicas: u64,
    /// The gas: dimension, volume, collisions.
    pub gas: Gas,
    /// The species, one block each. This, `power_law` or `continuous` says what the gas consists of.
    pub species: Option<Vec<Species>>,
    /// Very many species by a power law: mass k, diameter `k^(1/D)`, number `N k^-exponent`, k = 1, 2, 3 and so on.
    pub power_law: Option<PowerLaw>,
    /// Every particle with its own size, drawn from a continuous distribution.
    pub continuous: Option<Continuous>,
    /// Restitution of single pairs of species, in place of `gas.restitution`.
    #[serde(default)]
    pub pair: Vec<Pair>,
    /// Particles of one species are monomers that may stick together and break.
    pub sticking: Option<Sticking>,
    /// What keeps particles that stick and break in motion. Without this table the gas cools freely.
    pub heating: Option<Heating>,
    /// How pairs are selected.
    #[serde(default)]
    pub engine: Engine,
    /// How long to run and when to sample.
    pub run: Run,
    /// What is measured besides temperatures, fourth cumulants and collisions.
    #[serde(default)]
    pub measure: Measure,
    /// How the gas is compared with theory.
    #[serde(default)]
    pub verdict: Verdict,
    /// Parameter sweeps. Each block maps dotted keys to lists of values and stands for their product.
    #[serde(default)]
    #[expect(dead_code, reason = "sweeps are expanded before the points are read")]
    #[schemars(
        with = "Vec<BTreeMap<String, Vec<serde_json::Value>>>",
        extend("x-allowed" = "each [[sweep]] block holds quoted dotted keys, such as \"gas.restitution\" = [0.9, 1], each with a list of at least one value")
    )]
    pub sweep: Vec<BTreeMap<String, Vec<toml::Value>>>,
}

fn one() -> u64 {
    1
}

fn four() -> u64 {
    4
}

fn unit() -> f64 {
    1.0
}

/// The gas: dimension, volume, collisions.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Gas {
    /// Disks in the plane (2) or spheres in space (3).
    #[serde(default = "three")]
    #[schemars(extend("minimum" = 2, "maximum" = 3, "x-allowed" = "the dimension is 2 or 3"))]
    pub dimension: u64,
    /// Volume of the gas; an area in the plane.
    #[schemars(extend("exclusiveMinimum" = 0.0, "x-allowed" = "a volume lies above 0"))]
    pub volume: f64,
    /// Restitution: a constant from 0 to 1, where 1 is elastic, or a viscoelastic law.
    #[schemars(extend("x-allowed" = "a restitution is a number from 0 to 1, or a table such as { viscoelastic = 0.3 }"))]
    pub restitution: Restitution,
    /// How density raises collision rates.
    #[serde(default)]
    #[schemars(extend("x-allowed" = "contact values are \"dilute\" or \"dense\""))]
    pub contact_values: ContactValues,
}

fn three() -> u64 {
    3
}

/// Normal restitution as written.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(untagged)]
pub enum Restitution {
    /// The same restitution at every approach speed.
    Constant(#[schemars(extend("minimum" = 0.0, "maximum" = 1.0))] f64),
    /// Restitution that falls with the approach speed.
    Viscoelastic(Viscoelastic),
}

/// Viscoelastic particles.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Viscoelastic {
    /// Dissipation strength `(A kappa^(2/5))^(1/2)` \[speed^(-1/10)\].
    #[schemars(extend("exclusiveMinimum" = 0.0, "x-allowed" = "a viscoelastic dissipation strength lies above 0"))]
    pub viscoelastic: f64,
}

/// How density raises collision rates.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ContactValues {
    /// Not at all: the Boltzmann equation.
    #[default]
    Dilute,
    /// By the contact values of mixtures: the Enskog equation.
    Dense,
}

/// One species.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Species {
    /// Number of particles; this or `density`.
    #[schemars(extend("minimum" = 0, "maximum" = 2_000_000_000, "x-allowed" = "a species has either a count, a whole number from 0 to 2000000000, or a density"))]
    pub count: Option<u64>,
    /// Particles per volume; the count is the nearest whole number.
    #[schemars(extend("minimum" = 0.0, "x-allowed" = "a density is 0 or more, and stands in place of a count"))]
    pub density: Option<f64>,
    /// Mass of a particle.
    #[serde(default = "unit")]
    #[schemars(extend("exclusiveMinimum" = 0.0, "x-allowed" = "a mass lies above 0"))]
    pub mass: f64,
    /// Diameter of a particle.
    #[serde(default = "unit")]
    #[schemars(extend("exclusiveMinimum" = 0.0, "x-allowed" = "a diameter lies above 0"))]
    pub diameter: f64,
    /// Granular temperature `T = m <v^2>/D` at the start, an energy.
    #[serde(default = "unit")]
    #[schemars(extend("exclusiveMinimum" = 0.0, "x-allowed" = "a temperature is an energy above 0"))]
    pub temperature: f64,
    /// The species is so rare that the others do not notice it, and it does not meet itself: the tracer limit, for whatever
    /// number of tracers the statistics asks for.
    #[serde(default)]
    #[schemars(extend("x-allowed" = "tracer is true for one species at most, which has a count, and is not the only one"))]
    pub tracer: bool,
}

/// Very many species by a power law.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PowerLaw {
    /// Number N of particles of mass 1.
    #[schemars(extend("minimum" = 1, "maximum" = 1_000_000_000, "x-allowed" = "a number of monomers is a whole number from 1 to 1000000000"))]
    pub monomers: u64,
    /// The exponent.
    #[schemars(extend("minimum" = 0.0, "maximum" = 20.0, "x-allowed" = "the exponent lies from 0 to 20"))]
    pub exponent: f64,
    /// Largest mass. Default: where the number falls to zero.
    #[schemars(extend("minimum" = 1, "maximum" = 100_000, "x-allowed" = "the largest mass is a whole number from 1 to 100000; it is needed where the numbers do not fall to zero before"))]
    pub largest_mass: Option<u64>,
    /// How numbers become whole.
    #[serde(default)]
    #[schemars(extend("x-allowed" = "numbers are rounded \"down\" or to the \"nearest\""))]
    pub rounding: Rounding,
    /// Granular temperature of every species at the start.
    #[serde(default = "unit")]
    #[schemars(extend("exclusiveMinimum" = 0.0, "x-allowed" = "a temperature is an energy above 0"))]
    pub temperature: f64,
}

/// How numbers of particles become whole.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Rounding {
    /// Down.
    Down,
    /// To the nearest.
    #[default]
    Nearest,
}

/// Every particle with its own size.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Continuous {
    /// Number of particles.
    #[schemars(extend("minimum" = 2, "maximum" = 100_000_000, "x-allowed" = "a number of particles is a whole number from 2 to 100000000"))]
    pub particles: u64,
    /// Distribution of the diameters.
    #[schemars(extend("x-allowed" = "a distribution is \"uniform\" or \"log-normal\""))]
    pub distribution: Distribution,
    /// Mean diameter.
    #[serde(default = "unit")]
    #[schemars(extend("exclusiveMinimum" = 0.0, "x-allowed" = "a mean diameter lies above 0"))]
    pub mean_diameter: f64,
    /// Standard deviation of the diameters over their mean.
    #[schemars(extend("exclusiveMinimum" = 0.0, "maximum" = 2.0, "x-allowed" = "a relative width lies above 0 and at most at 2; at most at 0.57 where the distribution is uniform"))]
    pub relative_width: f64,
    /// Mass of a particle of diameter 1; masses grow as the power D of the diameter.
    #[serde(default = "unit")]
    #[schemars(extend("exclusiveMinimum" = 0.0, "x-allowed" = "a mass lies above 0"))]
    pub unit_mass: f64,
    /// Granular temperature at the start, the same for all sizes.
    #[serde(default = "unit")]
    #[schemars(extend("exclusiveMinimum" = 0.0, "x-allowed" = "a temperature is an energy above 0"))]
    pub temperature: f64,
    /// Groups of like size, equally many particles in each, for which temperatures are told and theory is solved.
    #[serde(default = "twelve")]
    #[schemars(extend("minimum" = 1, "maximum" = 200, "x-allowed" = "the groups are a whole number from 1 to 200, at most half as many as particles"))]
    pub groups: u64,
}

/// A distribution of diameters.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Distribution {
    /// Equal chances from the mean less to the mean plus `sqrt(3)` standard deviations.
    Uniform,
    /// The logarithm of the diameter is normally distributed.
    LogNormal,
}

fn twelve() -> u64 {
    12
}

/// Restitution of a pair of species.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Pair {
    /// The two species, counted from 1.
    #[schemars(extend("minItems" = 2, "maxItems" = 2, "items" = serde_json::json!({"type": "integer", "minimum": 1}), "x-allowed" = "a pair names two of the [[species]], counted from 1, and each pair once"))]
    pub species: [u64; 2],
    /// Restitution: a constant from 0 to 1, where 1 is elastic, or a viscoelastic law.
    #[schemars(extend("x-allowed" = "a restitution is a number from 0 to 1, or a table such as { viscoelastic = 0.3 }"))]
    pub restitution: Restitution,
}

/// When particles stick together or break. Without thresholds every pair that meets sticks.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Sticking {
    /// Energy below which pairs stick. Default: they always stick unless they break.
    #[schemars(extend("minimum" = 0.0, "x-allowed" = "a threshold is an energy of 0 or more"))]
    pub stick_below: Option<f64>,
    /// Part of the energy of the relative motion that is compared with `stick_below`.
    #[serde(default)]
    #[schemars(extend("x-allowed" = "the part of an energy is \"full\" or \"normal\""))]
    pub stick_part: EnergyPart,
    /// Energy above which pairs with three monomers or more break into monomers. Default: they never break.
    #[schemars(extend("minimum" = 0.0, "x-allowed" = "a threshold is an energy of 0 or more"))]
    pub break_above: Option<f64>,
    /// Part of the energy of the relative motion that is compared with `break_above`.
    #[serde(default)]
    #[schemars(extend("x-allowed" = "the part of an energy is \"full\" or \"normal\""))]
    pub break_part: EnergyPart,
    /// Which test comes first where both hold.
    #[serde(default)]
    #[schemars(extend("x-allowed" = "the first test is \"stick\" or \"break\""))]
    pub first: FirstTest,
    /// Factor of the relative speed in breaking.
    #[serde(default = "unit")]
    #[schemars(extend("minimum" = 0.0, "maximum" = 1.0, "x-allowed" = "the speed kept in breaking is a factor from 0 to 1"))]
    pub speed_kept_in_breaking: f64,
}

/// What keeps particles that stick and break in motion.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Heating {
    /// Time between two scalings of all velocities to the kinetic energy of the start.
    #[schemars(extend("exclusiveMinimum" = 0.0, "x-allowed" = "the interval of the heating lies above 0 and below run.until, for at most 10000000 scalings, and needs sticking.break_above"))]
    pub interval: f64,
}

/// A part of the energy of the relative motion.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum EnergyPart {
    /// All of it, `mu g^2/2`.
    #[default]
    Full,
    /// That of the motion along the line of centres, `mu (g . e)^2/2`.
    Normal,
}

/// Which test comes first.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum FirstTest {
    /// Sticking.
    #[default]
    Stick,
    /// Breaking.
    Break,
}

/// How pairs are selected.
#[derive(Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Engine {
    /// The selection of pairs; all are exact.
    #[schemars(extend("x-allowed" = "a selection is \"own\", \"low-rank\" or \"bird\""))]
    pub selection: Selection,
}

/// A selection of pairs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Selection {
    /// Groups of like speed and size in alias tables: the fastest.
    #[default]
    Own,
    /// Products of the weights of size classes, found in trees (Bodrova & Osinsky 2024).
    LowRank,
    /// Bird's single majorant.
    Bird,
}

/// How long to run and when to sample.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Run {
    /// Unit of the times in this file.
    #[serde(default)]
    #[schemars(extend("x-allowed" = "the unit of time is \"case\", \"haff\" or \"mean-free-time\"; an elastic gas has no time of Haff"))]
    pub time_unit: TimeUnit,
    /// End of the run.
    #[schemars(extend("exclusiveMinimum" = 0.0, "maximum" = 1e15, "x-allowed" = "the end of the run lies above 0 and at most at 1e15"))]
    pub until: f64,
    /// First sample after `t = 0`. Default: `until/1000`.
    #[schemars(extend("exclusiveMinimum" = 0.0, "x-allowed" = "the first sample lies above 0 and below run.until"))]
    pub first_sample: Option<f64>,
    /// Samples in each factor of ten of time.
    #[serde(default = "ten")]
    #[schemars(extend("minimum" = 1, "maximum" = 1000, "x-allowed" = "the samples per decade are a whole number from 1 to 1000"))]
    pub samples_per_decade: u64,
    /// Seconds of computing between two checkpoints.
    #[serde(default = "sixty")]
    #[schemars(extend("exclusiveMinimum" = 0.0, "x-allowed" = "the seconds between checkpoints lie above 0"))]
    pub checkpoint_seconds: f64,
}

fn ten() -> u64 {
    10
}

fn sixty() -> f64 {
    60.0
}

/// Unit of the times in a case.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum TimeUnit {
    /// That of the lengths, masses and energies of the case.
    #[default]
    Case,
    /// Haff's time of the start: twice the energy over the rate of its loss.
    Haff,
    /// The mean time between two collisions of a particle at the start.
    MeanFreeTime,
}

/// What is measured besides temperatures, fourth cumulants and collisions.
#[derive(Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Measure {
    /// Measure mean squared displacements.
    #[schemars(extend("x-allowed" = "displacement is true or false; particles that stick have none"))]
    pub displacement: bool,
    /// Measure the correlation of the velocities with those of the start.
    #[schemars(extend("x-allowed" = "velocity_correlation is true or false; particles that stick have none"))]
    pub velocity_correlation: bool,
    /// Particles of each species whose whole paths are kept, for displacements averaged over time.
    #[schemars(extend("minimum" = 0, "maximum" = 1_000_000, "x-allowed" = "the number of paths is a whole number from 0 to 1000000, and measure.displacement is true; particles that stick have none"))]
    pub paths: u64,
    /// Times at which the distribution of cluster sizes is measured. Default: the end of the run.
    #[schemars(extend(
        "items" = serde_json::json!({"type": "number", "minimum": 0.0}),
        "x-allowed" = "times of size distributions are a rising list of times from 0 to run.until, and need [sticking]"
    ))]
    pub size_distribution_times: Option<Vec<f64>>,
    /// Time from which on averages over the steady state of sticking and breaking are taken. Default: half of the run.
    #[schemars(extend("minimum" = 0.0, "x-allowed" = "the steady state begins at a time from 0 to below run.until, and needs sticking.break_above"))]
    pub steady_from: Option<f64>,
    /// Smallest and largest number of monomers of the clusters to whose steady numbers a power law is fitted. Default: 2
    /// and 20.
    #[schemars(extend("minItems" = 2, "maxItems" = 2, "items" = serde_json::json!({"type": "integer", "minimum": 1}), "x-allowed" = "the range of a fit is [smallest, largest], two numbers of monomers from 1 on, the first the smaller by a factor 2, and needs sticking.break_above"))]
    pub fit_monomers: Option<[u64; 2]>,
}

/// How the gas is compared with theory.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Verdict {
    /// Largest deviation from theory that counts as agreement.
    #[schemars(extend("exclusiveMinimum" = 0.0, "exclusiveMaximum" = 1.0, "x-allowed" = "a tolerance lies above 0 and below 1"))]
    pub tolerance: f64,
    /// Orders of the Sonine expansion of the velocities in theory: 1 for Maxwellian species. Default: as many as are quick, from 6
    /// for three species to 1 for many.
    #[schemars(extend("minimum" = 1, "maximum" = 12, "x-allowed" = "the Sonine orders are a whole number from 1 to 12; their cost grows as the fourth power, and as the square of the number of species"))]
    pub sonine_orders: Option<u64>,
}

impl Default for Verdict {
    fn default() -> Self {
        Self {
            tolerance: 0.02,
            sonine_orders: None,
        }
    }
}
