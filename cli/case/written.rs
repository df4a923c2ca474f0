//! A case file as written: the keys, their types, their ranges and their defaults.
//!
//! The doc comments here are the descriptions in the JSON Schema, and the ranges and `x-allowed` sentences
//! are read from that schema when a case is checked, so the documentation, the schema and the check have one
//! source. Relations between keys are not here: they are in [`super::validate`].

// Every field states its meaning once, as the schema description; types repeat nothing.
use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

mod monte_carlo;

pub use monte_carlo::{
    Boltzmann, ContactPoint, Copies, Displacement, Enskog, Esmc, FreeVolume, Inelastic, Mean,
    Neighbourhood, StochasticDisks,
};

/// A case file: one gas, one start, and the engines that run from it.
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
    /// Kind of the case. Without this key it is "paired".
    #[expect(dead_code, reason = "the kind is checked before anything else is read")]
    #[schemars(extend("const" = "paired", "x-allowed" = "this is the paired case, whose kind is \"paired\""))]
    pub kind: Option<String>,
    /// What the case shows, in one line.
    #[schemars(extend("minLength" = 1, "x-allowed" = "a title is a text of at least one character"))]
    pub title: String,
    /// Units of the lengths, masses and energies in the case.
    #[serde(default)]
    #[schemars(extend("x-allowed" = "the units are \"reduced\" or \"si\""))]
    pub units: Units,
    /// Seed of every random stream.
    #[serde(default = "one")]
    #[schemars(extend("minimum" = 0, "x-allowed" = "a seed is a whole number from 0 to 9223372036854775807"))]
    pub seed: u64,
    /// Number of independent runs, each with its own initial state; error bars come from their spread.
    #[serde(default = "four")]
    #[schemars(extend("minimum" = 1, "maximum" = 1_000_000, "x-allowed" = "a number of replicas is a whole number from 1 to 1000000"))]
    pub replicas: u64,
    /// The gas: how many disks, how dense, how dissipative.
    pub gas: Gas,
    /// The box that holds the gas.
    #[serde(default, rename = "box")]
    pub domain: Domain,
    /// The initial state that all engines share.
    #[serde(default)]
    pub start: Start,
    /// How long to run and when to sample.
    pub run: Run,
    /// Random kicks that keep the gas in motion. Without this table the gas cools freely.
    pub drive: Option<Drive>,
    /// The engines to run. A table that is present is run; at least one must be.
    #[schemars(extend("x-allowed" = "at least one engine: [engine.ed], [engine.dsmc-boltzmann], [engine.dsmc-free-volume], [engine.dsmc-enskog], [engine.dsmc-esmc], [engine.dsmc-stochastic-disks] or [engine.dsmc-contact-point]"))]
    pub engine: Engines,
    /// What is measured besides the energy and the collision rate.
    #[serde(default)]
    pub measure: Measure,
    /// How the engines are compared.
    #[serde(default)]
    pub verdict: Verdict,
    /// How accurate the Monte Carlo engines must be. Their simulators per disk and steps are then chosen by the program.
    pub accuracy: Option<Accuracy>,
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

/// Units of the lengths, masses and energies in a case. Times are always in units of `t0`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Units {
    /// Diameter, mass and temperature default to 1.
    #[default]
    Reduced,
    /// Metres, kilograms, seconds, joules; diameter, mass and temperature must be given.
    Si,
}

/// The gas: how many disks, how dense, how dissipative.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Gas {
    /// Number of disks. Left out when they come from a file.
    #[schemars(extend("minimum" = 2, "maximum" = 1_000_000_000, "x-allowed" = "a number of disks is a whole number from 2 to 1000000000"))]
    pub disks: Option<u64>,
    /// Covered fraction of the box area. Left out when the disks come from a file.
    #[schemars(extend("exclusiveMinimum" = 0.0, "maximum" = 0.9069, "x-allowed" = "a packing fraction lies above 0 and at most 0.9069 (close packing)"))]
    pub packing_fraction: Option<f64>,
    /// Restitution: a constant from 0 to 1, where 1 is elastic, or a viscoelastic law.
    #[schemars(extend("x-allowed" = "a restitution is a number from 0 to 1, or a table such as { viscoelastic = 0.3 }"))]
    pub restitution: Restitution,
    /// Disks of several species, in place of `diameter` and `mass`; they are placed at random.
    #[serde(default)]
    #[schemars(extend("x-allowed" = "disks of several species are disordered, have no gas.diameter and gas.mass and no start file, and their shares add up to 1"))]
    pub species: Vec<GasSpecies>,
    /// Diameter of a disk. Default 1 in reduced units; required in SI units [m].
    #[schemars(extend("exclusiveMinimum" = 0.0, "x-allowed" = "a diameter lies above 0"))]
    pub diameter: Option<f64>,
    /// Mass of a disk. Default 1 in reduced units; required in SI units [kg].
    #[schemars(extend("exclusiveMinimum" = 0.0, "x-allowed" = "a mass lies above 0"))]
    pub mass: Option<f64>,
    /// Granular temperature at the start, an energy. Default 1 in reduced units; in SI units [J], this or
    /// `rms_speed` is required. Left out when the velocities come from a file.
    #[schemars(extend("exclusiveMinimum" = 0.0, "x-allowed" = "a temperature is an energy above 0"))]
    pub temperature: Option<f64>,
    /// Root of the mean squared speed at the start, `sqrt(2 T/m)`; it replaces `temperature`.
    #[schemars(extend("exclusiveMinimum" = 0.0, "x-allowed" = "a root mean squared speed lies above 0"))]
    pub rms_speed: Option<f64>,
}

/// One species of disks.
#[derive(Clone, Copy, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct GasSpecies {
    /// Share of the disks that are of this species.
    #[schemars(extend("exclusiveMinimum" = 0.0, "maximum" = 1.0, "x-allowed" = "a share of the disks lies above 0 and at most at 1, and all shares together are 1"))]
    pub share: f64,
    /// Diameter of a disk; in SI units \[m\].
    #[schemars(extend("exclusiveMinimum" = 0.0, "x-allowed" = "a diameter lies above 0"))]
    pub diameter: f64,
    /// Mass of a disk; in SI units \[kg\].
    #[schemars(extend("exclusiveMinimum" = 0.0, "x-allowed" = "a mass lies above 0"))]
    pub mass: f64,
}

/// Normal restitution as written.
#[derive(Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum Restitution {
    /// The same restitution at every approach speed.
    Constant(#[schemars(extend("minimum" = 0.0, "maximum" = 1.0))] f64),
    /// Restitution that falls with the approach speed.
    Viscoelastic(Viscoelastic),
}

/// Viscoelastic disks.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Viscoelastic {
    /// Dissipation strength `(A kappa^(2/5))^(1/2)`, speeds in units of the thermal speed `sqrt(T/m)` at the
    /// start.
    #[schemars(extend("exclusiveMinimum" = 0.0, "x-allowed" = "a viscoelastic dissipation strength lies above 0"))]
    pub viscoelastic: f64,
}

/// The box that holds the gas.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Domain {
    /// Height over width, `Ly/Lx`.
    #[schemars(extend("exclusiveMinimum" = 0.0, "x-allowed" = "an aspect ratio lies above 0"))]
    pub aspect_ratio: f64,
    /// What happens at the edges of the box.
    #[schemars(extend("x-allowed" = "the only boundary is \"periodic\""))]
    pub boundary: Boundary,
}

impl Default for Domain {
    fn default() -> Self {
        Self {
            aspect_ratio: 1.0,
            boundary: Boundary::Periodic,
        }
    }
}

/// What happens at the edges of the box.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Boundary {
    /// A disk that leaves on one side enters on the other.
    #[default]
    Periodic,
}

/// The initial state that all engines share.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Start {
    /// How the disks are placed.
    #[schemars(extend("x-allowed" = "a placement is \"disordered\", \"square\", \"hexagonal\" or \"file\""))]
    pub placement: Placement,
    /// File with the positions, `.csv` or `.xyz`, relative to the case file; only with placement = "file".
    #[schemars(extend("minLength" = 1, "x-allowed" = "a start file is a .csv or .xyz file, and is given only and always with placement = \"file\""))]
    pub file: Option<String>,
    /// Where the velocities come from.
    #[schemars(extend("x-allowed" = "velocities are \"maxwellian\", or \"file\" with placement = \"file\""))]
    pub velocities: Velocities,
    /// Length of the elastic equilibration before `t = 0`; 0 means none.
    #[schemars(extend("minimum" = 0.0, "x-allowed" = "a number of collisions per particle is at least 0"))]
    pub collisions_per_particle: f64,
    /// Give up equilibrating here. Default: four times `collisions_per_particle`, and at least 200.
    #[schemars(extend("minimum" = 0.0, "x-allowed" = "the most collisions per particle are at least start.collisions_per_particle"))]
    pub most_collisions_per_particle: Option<f64>,
}

impl Default for Start {
    fn default() -> Self {
        Self {
            placement: Placement::Disordered,
            file: None,
            velocities: Velocities::Maxwellian,
            collisions_per_particle: 10.0,
            most_collisions_per_particle: None,
        }
    }
}

/// How the disks are placed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Placement {
    /// At random, without overlap.
    Disordered,
    /// On a square lattice.
    Square,
    /// On a hexagonal lattice.
    Hexagonal,
    /// As in `start.file`.
    File,
}

/// Where the initial velocities come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Velocities {
    /// Drawn from a Maxwell distribution.
    Maxwellian,
    /// As in `start.file`.
    File,
}

/// How long to run and when to sample.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Run {
    /// End of the run, in units of `t0`: Haff's time, or the mean free time of an elastic gas.
    #[schemars(extend("exclusiveMinimum" = 0.0, "maximum" = 1e12, "x-allowed" = "the end of the run lies above 0 and at most at 1e12, in units of t0"))]
    pub until: f64,
    /// First sample after `t = 0`, in units of `t0`. Default: `until/1000`.
    #[schemars(extend("exclusiveMinimum" = 0.0, "x-allowed" = "the first sample lies above 0 and below run.until, in units of t0"))]
    pub first_sample: Option<f64>,
    /// Samples in each factor of ten of time.
    #[serde(default = "twelve")]
    #[schemars(extend("minimum" = 1, "maximum" = 1000, "x-allowed" = "the samples per decade are a whole number from 1 to 1000"))]
    pub samples_per_decade: u64,
    /// Seconds of computing between two checkpoints.
    #[serde(default = "thirty")]
    #[schemars(extend("exclusiveMinimum" = 0.0, "x-allowed" = "the seconds between checkpoints lie above 0"))]
    pub checkpoint_seconds: f64,
}

fn twelve() -> u64 {
    12
}

fn thirty() -> f64 {
    30.0
}

/// Random kicks that keep the gas in motion.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Drive {
    /// Energy that each disk gains on average, in units of the temperature of the start and `t0`. A gas that gains
    /// about 2 keeps the temperature of its start; the steady temperature grows as the power 2/3.
    #[schemars(extend("exclusiveMinimum" = 0.0, "maximum" = 1e12, "x-allowed" = "a heating lies above 0 and at most at 1e12, in temperatures of the start per t0"))]
    pub heating: f64,
    /// Time between two kicks, in units of `t0`.
    #[schemars(extend("exclusiveMinimum" = 0.0, "x-allowed" = "the interval of the kicks lies above 0 and below run.until, in units of t0, for at most 1000000000 kicks"))]
    pub interval: f64,
}

/// The engines to run.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Engines {
    /// Exact event-driven hard disks.
    pub ed: Option<EventDriven>,
    /// Monte Carlo collisions at the dilute rate.
    #[serde(rename = "dsmc-boltzmann")]
    pub boltzmann: Option<Boltzmann>,
    /// Monte Carlo collisions at the rate of the free volume in each cell.
    #[serde(rename = "dsmc-free-volume")]
    pub free_volume: Option<FreeVolume>,
    /// Monte Carlo collisions at the rate of Enskog's theory, with the packing around each cell.
    #[serde(rename = "dsmc-enskog")]
    pub enskog: Option<Enskog>,
    /// Monte Carlo collisions with partners from the cell of the point of contact (Montanero and Santos).
    #[serde(rename = "dsmc-esmc")]
    pub esmc: Option<Esmc>,
    /// Monte Carlo collisions of overlapping disks along their line of centres (Donev, Alder and Garcia).
    #[serde(rename = "dsmc-stochastic-disks")]
    pub stochastic_disks: Option<StochasticDisks>,
    /// Monte Carlo collisions at the rate of Enskog's theory with partners around the point of contact: the one to
    /// compare with exact disks.
    #[serde(rename = "dsmc-contact-point")]
    pub contact_point: Option<ContactPoint>,
}

/// Exact event-driven hard disks.
#[derive(Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct EventDriven {
    /// Contact time of the TC model, in units of `t0`: a disk that collides again sooner does so elastically.
    /// 0 switches it off.
    #[schemars(extend("minimum" = 0.0, "x-allowed" = "a contact time is at least 0, in units of t0"))]
    pub contact_time: f64,
    /// Most collisions in one run, as a safety limit. Default: none.
    #[schemars(extend("minimum" = 1.0, "maximum" = 9_007_199_254_740_992.0, "x-allowed" = "a collision limit is a whole number from 1 to 9007199254740992"))]
    pub collision_limit: Option<f64>,
}

/// What is measured besides the energy and the collision rate.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Measure {
    /// Time windows over which impact parameters are gathered, in units of `t0`; or "whole-run" for one
    /// window. Default: 0 to 1, 5, 20, 100, 400 and so on up to the end of the run.
    #[schemars(extend("x-allowed" = "the impact windows are a list of [start, end] in units of t0 with 0 <= start < end <= run.until, or \"whole-run\""))]
    pub impact_windows: Option<Windows>,
    /// Bins of the impact parameter.
    #[schemars(extend("minimum" = 2, "maximum" = 1000, "x-allowed" = "the impact bins are a whole number from 2 to 1000"))]
    pub impact_bins: u64,
    /// Times of the structure factor and of the pair correlation, in units of `t0`. Default: the start and the
    /// end of the run.
    #[schemars(extend(
        "items" = serde_json::json!({"type": "number", "minimum": 0.0}),
        "x-allowed" = "structure times are a list of times from 0 to run.until, in units of t0; none is a time before zero"
    ))]
    pub structure_times: Option<Vec<f64>>,
    /// How a disk is shared among the points of the grid.
    #[schemars(extend("x-allowed" = "a structure assignment is \"nearest-grid-point\" or \"cloud-in-cell\""))]
    pub structure_assignment: Assignment,
    /// Divide out the shape of the assignment.
    #[schemars(extend("x-allowed" = "structure_correction is true or false"))]
    pub structure_correction: bool,
    /// Largest `k = L/wavelength` for which the structure factor is tabulated.
    #[schemars(extend("minimum" = 1, "maximum" = 2048, "x-allowed" = "the largest wave number is a whole number from 1 to 2048"))]
    pub largest_wave_number: u64,
    /// Largest distance of the pair correlation, in diameters.
    #[schemars(extend("exclusiveMinimum" = 1.0, "x-allowed" = "the range of the pair correlation lies above 1, in diameters"))]
    pub pair_correlation_range: f64,
    /// Times at which all positions and velocities are written, in units of `t0`. Default: the end of the run.
    #[schemars(extend(
        "items" = serde_json::json!({"type": "number", "minimum": 0.0}),
        "x-allowed" = "snapshot times are a list of times from 0 to run.until, in units of t0; none is a time before zero"
    ))]
    pub snapshot_times: Option<Vec<f64>>,
    /// Measure the mean squared displacement of the disks.
    #[schemars(extend("x-allowed" = "mean_squared_displacement is true or false"))]
    pub mean_squared_displacement: bool,
    /// Time from which displacements are measured, in units of `t0`. Default: 0.
    #[schemars(extend("minimum" = 0.0, "x-allowed" = "the start of the displacements lies from 0 to below run.until less run.first_sample, in units of t0, and measure.mean_squared_displacement is true"))]
    pub displacement_start: Option<f64>,
}

impl Default for Measure {
    fn default() -> Self {
        Self {
            impact_windows: None,
            impact_bins: 20,
            structure_times: None,
            structure_assignment: Assignment::CloudInCell,
            structure_correction: true,
            largest_wave_number: 64,
            pair_correlation_range: 6.0,
            snapshot_times: None,
            mean_squared_displacement: false,
            displacement_start: None,
        }
    }
}

/// Time windows as written.
#[derive(Deserialize, Serialize, JsonSchema)]
#[serde(untagged)]
pub enum Windows {
    /// One window from the start to the end of the run.
    Whole(WholeRun),
    /// Start and end of each window.
    List(
        #[schemars(extend("minItems" = 1, "items" = serde_json::json!({
            "type": "array", "minItems": 2, "maxItems": 2, "items": {"type": "number", "minimum": 0.0}
        })))]
        Vec<[f64; 2]>,
    ),
}

/// The word that stands for the whole run.
#[derive(Clone, Copy, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum WholeRun {
    /// From the start to the end of the run.
    WholeRun,
}

/// How a disk is shared among the points of a grid.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Assignment {
    /// All of it to the nearest point.
    NearestGridPoint,
    /// Linearly among the four points around it.
    CloudInCell,
}

/// How accurate the Monte Carlo engines must be.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Accuracy {
    /// Largest error of a Monte Carlo engine against Enskog's theory, of the energy at `t0` or the collision rate of an elastic
    /// gas: a share such as "1%". A pilot chooses the fewest simulators per disk and steps that keep it.
    #[schemars(extend("minLength" = 1, "x-allowed" = "a target is a share in quotes, such as \"1%\" or \"0.01\", above 0 and below 1"))]
    pub target: String,
}

/// How the engines are compared.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Verdict {
    /// Chance of any false alarm in one comparison, all times together.
    #[schemars(extend("exclusiveMinimum" = 0.0, "exclusiveMaximum" = 0.5, "x-allowed" = "a chance of a false alarm lies above 0 and below 0.5"))]
    pub false_alarm: f64,
}

impl Default for Verdict {
    fn default() -> Self {
        Self { false_alarm: 0.01 }
    }
}
