//! Resolved plan of a case: input of engines, measurements and theory.

use std::borrow::Cow;
use std::fmt::Display;
use std::path::PathBuf;
use std::sync::{Arc, OnceLock};

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};
use stosszahl_case::Case;
use stosszahl_case::format::{FaceSpec, SelectionSpec, TimeUnit};
use stosszahl_dsmc::homogeneous::HomogeneousError;
use stosszahl_dsmc::{SimulatorWeights, WallClearance};
use stosszahl_model::initial::{StartFile, VelocityDistribution};
use stosszahl_model::{Failure, Grouping, Law, MessageUnits, ParticleSpec, SizeDistribution};
use stosszahl_theory::{Moment, Temperatures, TheoryError};

use super::theory_curves::TheoryCurves;

/// Resolved plan: a case with all quantities that follow from it.
#[derive(Clone, Debug)]
pub struct CasePlan {
    /// Case with the values that a sweep point and the command line set.
    pub case: Case,
    /// Gas at the start: particles, box, packing and temperature.
    pub gas: GasPlan,
    /// Sizes of the engine units of length, mass and energy.
    pub scale: UnitScale,
    /// Characteristic times, and the unit of time of the case.
    pub clock: ClockPlan,
    /// Engines, in the order in which they are run and compared.
    pub engines: Vec<EnginePlan>,
    /// Predictions of kinetic theory, each computed on first use.
    pub theory: TheoryCache,
    /// Choices of the program and warnings, in words for the user.
    pub notes: PlanNotes,
    /// Folder of the case file, to which the path of the start file is relative.
    pub folder: PathBuf,
}

/// Gas of a plan at the start, in engine units.
#[derive(Clone, Debug)]
pub struct GasPlan {
    /// Dimension of space: 2 or 3.
    pub dimension: usize,
    /// Species in the order of their particles; one in a gas of equal particles. Particles of
    /// individual sizes are one species in a box, and several size groups without one.
    pub species: Vec<SpeciesPlan>,
    /// Index of the species of each particle, if particles are not sorted by species.
    pub species_numbers: Option<Arc<[u32]>>,
    /// Number of particle kinds of the engines in all species together, if each particle is a kind
    /// (radius, mass) of its own.
    pub kinds_in_groups: Option<usize>,
    /// Size groups of particles for theory: the species, or several groups of like size for each,
    /// one species after the other.
    pub classes: Vec<SizeGroup>,
    /// Particle properties in the form of the engines: sizes, contact laws and external field.
    pub particles: ParticleSpec,
    /// Law of normal restitution of colliding pairs.
    pub law: Law,
    /// Coefficient of restitution: the constant one, or that at the mean approach speed of the
    /// start.
    pub restitution: f64,
    /// Sides of the box \[length\]; zero without a box and beyond the dimension.
    pub lengths: [f64; 3],
    /// Volume of the gas \[length^D\] to which number densities refer. In a box with obstacles, it
    /// is the volume in which centres of particles can be.
    pub volume: f64,
    /// Packing fraction: share of the volume not under obstacles that particles cover; tracers
    /// cover nothing.
    pub packing_fraction: f64,
    /// Contact value chi of Enskog's theory at the packing fraction of the plan.
    pub contact_value: f64,
    /// Granular temperature of the start \[energy\]; 1 in thermal units.
    pub temperature: f64,
    /// Distribution of the initial velocities, if they are drawn at random.
    pub velocities: VelocityDistribution,
    /// Start file, if there is one: positions in the box and velocities in engine units, in a
    /// periodic box without drift. Velocities without positions are in the order of species.
    pub file: Option<StartFile>,
}

/// Characteristic times of the gas at the start, and the unit of time of its case.
#[derive(Clone, Copy, Debug)]
pub struct ClockPlan {
    /// Unit of time of the case \[engine time\]. Times in case files and tables are engine times
    /// divided by it.
    pub time: f64,
    /// Name of the unit of time of the case.
    pub time_unit: TimeUnit,
    /// Haff's cooling time of the start \[engine time\]; infinite in an elastic gas.
    pub haff_time: f64,
    /// Mean free time of the start \[engine time\].
    pub mean_free_time: f64,
}

/// Predictions of kinetic theory for a plan, each computed on first use.
#[derive(Clone, Debug, Default)]
pub struct TheoryCache {
    /// Theory of a gas without positions at the sample times.
    pub curves: OnceLock<Result<TheoryCurves, TheoryError>>,
    /// Steady state of a self-heating gas, from [`CasePlan::steady_state`].
    pub(super) steady_state: OnceLock<Option<Moment>>,
    /// Temperatures of the species, from [`CasePlan::partial_temperatures`].
    pub(super) partial_temperatures: OnceLock<Option<Vec<Vec<f64>>>>,
    /// Temperatures of a homogeneous rough gas at the sample times: at Enskog's collision rate, and
    /// at that of a dilute gas.
    pub(crate) rough_temperatures: [OnceLock<Result<Option<Vec<Temperatures>>, TheoryError>>; 2],
}

/// Notes of a plan for the user.
#[derive(Clone, Debug, Default)]
pub struct PlanNotes {
    /// Warnings for the user, such as coarse resolutions and limits that apply.
    pub warnings: Vec<String>,
    /// Choices of the program for the case, with their reasons.
    pub choices: Vec<String>,
}

/// Species of the plan: its particles in the units of the engines.
#[derive(Clone, Debug, PartialEq)]
pub struct SpeciesPlan {
    /// Name of the species in tables: as given in the case, or its number from 1.
    pub name: String,
    /// Number of particles of the species.
    pub count: usize,
    /// Radius of the particles \[length\]; the mean if they differ.
    pub radius: f64,
    /// Mass of the particles \[mass\]; the mean if they differ.
    pub mass: f64,
    /// Granular temperature of the species at the start \[energy\].
    pub temperature: f64,
    /// True if the species is in the tracer limit.
    pub tracer: bool,
}

/// Group of particles of like size and mass, for theory.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SizeGroup {
    /// Number of particles of the group.
    pub count: usize,
    /// Mass of a particle \[mass\]; the mean if they differ.
    pub mass: f64,
    /// Diameter of a particle \[length\]; the mean if they differ.
    pub diameter: f64,
    /// Granular temperature of the group at the start \[energy\].
    pub temperature: f64,
    /// Number density of the group \[1/length^D\]; 0 for tracers.
    pub density: f64,
}

/// Sizes of the engine units in units of the case.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UnitScale {
    /// Engine unit of length in units of the case.
    pub length: f64,
    /// Engine unit of mass in units of the case.
    pub mass: f64,
    /// Engine unit of energy in units of the case.
    pub energy: f64,
}

impl UnitScale {
    /// Scale 1 of engines that compute in the units of the case.
    pub const CASE: Self = Self {
        length: 1.0,
        mass: 1.0,
        energy: 1.0,
    };

    /// Returns the engine unit of speed in units of the case.
    pub fn speed(self) -> f64 {
        (self.energy / self.mass).sqrt()
    }

    /// Returns the engine unit of time in units of the case.
    pub fn time(self) -> f64 {
        self.length / self.speed()
    }
}

/// Plan of one engine of a case: name, kind and parameters.
#[derive(Clone, Debug)]
pub struct EnginePlan {
    /// Name of the engine: `ed`, `dsmc-contact-point`, `dsmc-homogeneous` and so on.
    pub name: &'static str,
    /// Kind of the engine, with its parameters.
    pub kind: EngineKind,
    /// Contact of particles with walls and obstacles: with their centre, or with their surface.
    pub clearance: WallClearance,
    /// Weights of simulators by region of the box.
    pub weights: SimulatorWeights,
}

/// Kind of an engine, with its parameters.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum EngineKind {
    /// Exact event-driven dynamics of disks.
    EventDriven {
        /// Contact time of the TC model \[engine time\]; 0 without it.
        contact_time: f64,
        /// Largest number of collisions of the run; `None` without a limit.
        collision_limit: Option<u64>,
        /// Largest collision rate per particle, on average over all particles \[1/engine time\];
        /// `None` without a limit.
        collision_rate_limit: Option<f64>,
    },
    /// Monte Carlo in cells, with its parameters.
    MonteCarlo(stosszahl_dsmc::Parameters),
    /// Monte Carlo without positions, with its selection of pairs.
    Homogeneous(SelectionSpec),
}

impl EnginePlan {
    /// Returns true if this engine runs exact event-driven dynamics.
    pub fn is_exact(&self) -> bool {
        matches!(self.kind, EngineKind::EventDriven { .. })
    }

    /// Returns the parameters of Monte Carlo in cells; `None` for other engines.
    pub fn parameters(&self) -> Option<&stosszahl_dsmc::Parameters> {
        match &self.kind {
            EngineKind::MonteCarlo(parameters) => Some(parameters),
            _ => None,
        }
    }

    /// Returns the number of simulators per particle; 1 in exact dynamics.
    pub fn copies(&self) -> usize {
        self.parameters()
            .map_or(1, |parameters| parameters.simulators_per_particle as usize)
    }
}

impl CasePlan {
    /// Converts the case as it is run to JSON.
    pub(crate) fn case_json(&self) -> serde_json::Value {
        serde_json::to_value(&self.case).expect("a case has keys of text only")
    }

    /// Returns the path of the start file of the case; `None` without one.
    pub(crate) fn start_path(&self) -> Option<PathBuf> {
        let name = self.case.start.file.as_ref()?;
        Some(self.folder.join(name))
    }

    /// Returns the number of particles of the gas.
    pub fn count(&self) -> usize {
        self.gas.species.iter().map(|species| species.count).sum()
    }

    /// Converts a time of the case to engine time.
    pub fn engine_time(&self, time: f64) -> f64 {
        time * self.clock.time
    }

    /// Returns the unit of time of the case, in units of its lengths, masses and energies.
    pub fn time_in_case(&self) -> f64 {
        self.clock.time * self.scale.time()
    }

    /// Returns Haff's cooling time of the start \[engine time\]; `None` for a gas that does not
    /// cool.
    pub fn cooling_time(&self) -> Option<f64> {
        Some(self.clock.haff_time).filter(|time| time.is_finite())
    }

    /// Returns the units in which error messages of engines give numbers.
    pub fn message_units(&self) -> MessageUnits {
        MessageUnits {
            length: self.scale.length,
            time: 1.0 / self.clock.time,
            speed: self.scale.speed(),
        }
    }

    /// Converts the numbers in the failure of an engine to the units of the case.
    pub fn told(&self, failure: Failure) -> Failure {
        let units = self.message_units();
        if let Some(error) = failure.downcast_ref::<stosszahl_ed::EventDrivenError>() {
            return Failure::new(error.clone().in_units(&units));
        }
        if let Some(error) = failure.downcast_ref::<stosszahl_dsmc::DsmcError>() {
            return Failure::new(error.clone().in_units(&units));
        }
        match failure.downcast_ref::<HomogeneousError>() {
            Some(&HomogeneousError::BoundExceeded { speed, bound, time }) => {
                Failure::new(HomogeneousError::BoundExceeded {
                    speed: speed * units.speed,
                    bound: bound * units.speed,
                    time: time * units.time,
                })
            }
            _ => failure,
        }
    }

    /// Returns true if particles have positions in a box.
    pub fn has_box(&self) -> bool {
        self.case.has_box()
    }

    /// Returns true if the gas is homogeneous by its setup: no walls, openings, obstacles or
    /// gravity.
    pub fn is_uniform(&self) -> bool {
        self.case.is_uniform()
    }

    /// Returns true for a gas in a periodic box without obstacles or gravity.
    pub fn is_uniform_box(&self) -> bool {
        self.case.is_uniform_box()
    }

    /// Returns true if the mean diameter, the mean mass and the temperature of the start are the
    /// units of the engines.
    pub fn has_thermal_units(&self) -> bool {
        self.case.has_thermal_units()
    }

    /// Returns true for a fluid of smooth disks in a uniform box. Its equation of state, S(k) and
    /// transport are known, so the start can be equilibrated and tested against them.
    pub fn is_disk_fluid(&self) -> bool {
        self.is_uniform_box() && !self.is_rough() && self.gas.dimension == 2
    }

    /// Returns true if the gas is in a uniform shear flow.
    pub fn is_sheared(&self) -> bool {
        self.gas.particles.shear_rate.is_some()
    }

    /// Returns the species of a particle by its index. Indices of simulators continue from one set
    /// of the gas to the next.
    pub fn species_of(&self, index: usize) -> usize {
        let mut place = index % self.count().max(1);
        if let Some(numbers) = &self.gas.species_numbers {
            return numbers[place] as usize;
        }
        for (number, one) in self.gas.species.iter().enumerate() {
            if place < one.count {
                return number;
            }
            place -= one.count;
        }
        0
    }

    /// Returns the names of a pair of species, for tables.
    pub fn pair_name(&self, pair: [usize; 2]) -> String {
        pair.map(|one| self.gas.species[one].name.as_str())
            .join(", ")
    }

    /// Returns, for each of the first two axes, whether the box is periodic along it.
    pub fn periodic(&self) -> [bool; 2] {
        [0, 1].map(|axis| self.is_periodic_along(axis))
    }

    /// Returns true if the box is periodic along an axis.
    pub fn is_periodic_along(&self, axis: usize) -> bool {
        *self.case.walls.face_at(axis, 0) == FaceSpec::default()
    }

    /// Returns the map from the particle kinds of an engine to the species of the plan.
    pub fn grouping(&self) -> Grouping {
        Grouping::new(self.gas.species.len(), self.gas.kinds_in_groups)
    }

    /// Returns the species of each particle kind of an engine.
    pub fn groups(&self) -> Vec<u32> {
        let kinds = self.gas.kinds_in_groups.unwrap_or(self.gas.species.len());
        let group = |kind| self.grouping().group(kind as u32) as u32;
        (0..kinds).map(group).collect()
    }

    /// Returns the initial temperature of each particle kind of an engine \[energy\].
    pub fn kind_temperatures(&self) -> Vec<f64> {
        let groups = self.groups().into_iter();
        groups
            .map(|group| self.gas.species[group as usize].temperature)
            .collect()
    }

    /// Returns radius and mass of each particle, by particle index.
    pub fn radii_and_masses(&self) -> Vec<(f64, f64)> {
        match &self.gas.particles.sizes {
            SizeDistribution::Equal(one) => vec![(one.radius, one.mass); self.count()],
            SizeDistribution::Each(all) => all.pairs().to_vec(),
            SizeDistribution::Species(species) => (species.kinds().iter())
                .flat_map(|kind| std::iter::repeat_n((kind.radius, kind.mass), kind.count))
                .collect(),
        }
    }

    /// Returns true if all contacts of particles conserve energy.
    pub fn is_elastic(&self) -> bool {
        let rough = self.gas.particles.rough;
        self.gas.law.is_elastic()
            && rough.is_none_or(|rough| rough.tangential_restitution().abs() == 1.0)
    }

    /// Returns gravity along the axes that end at walls or openings, along which a gas has a
    /// height.
    pub fn gravity(&self) -> Vector3<f64> {
        let all = self.gas.particles.gravity.unwrap_or_default();
        let ends = |axis: usize| *self.case.walls.face_at(axis, 0) != FaceSpec::default();
        Vector3::from_fn(|axis, _| if ends(axis) { all[axis] } else { 0.0 })
    }

    /// Returns true if the particles are rough and spin.
    pub fn is_rough(&self) -> bool {
        self.gas.particles.rough.is_some()
    }

    /// Returns true if the box has walls, openings or obstacles.
    pub fn is_bounded(&self) -> bool {
        self.gas.particles.is_bounded
    }

    /// Returns the plan of the engine with this name, and its index.
    pub fn engine(&self, name: &str) -> Option<(usize, &EnginePlan)> {
        let mut engines = self.engines.iter().enumerate();
        engines.find(|(_, engine)| engine.name == name)
    }
}

/// Quantity derived from a case, such as the mean free path.
#[derive(Clone, Debug, PartialEq)]
pub struct DerivedQuantity {
    /// Name of the derived quantity.
    pub name: String,
    /// Value of the derived quantity, in the units of the case.
    pub value: f64,
    /// Unit of the value; `1` for pure numbers.
    pub unit: Cow<'static, str>,
}

impl DerivedQuantity {
    /// Creates a derived quantity from name, value and unit.
    pub fn new(name: impl Into<String>, value: f64, unit: &'static str) -> Self {
        Self {
            name: name.into(),
            value,
            unit: unit.into(),
        }
    }
}

/// Error of a case whose keys are invalid together, found while it is planned.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{key}: {}allowed: {allowed}", if found.is_empty() { String::new() } else { format!("{found}; ") })]
pub struct PlanError {
    /// Dotted key of the invalid value.
    pub key: String,
    /// Value found; empty if the value as written in the case suffices.
    pub found: String,
    /// Description of the allowed values.
    pub allowed: String,
}

impl PlanError {
    /// Creates the error of a key: value found, and allowed values.
    pub fn new(key: impl Into<String>, found: impl Display, allowed: impl Into<String>) -> Self {
        let found = found.to_string();
        let found = found.parse().map_or(found, stosszahl_model::format_short);
        Self {
            key: key.into(),
            found,
            allowed: allowed.into(),
        }
    }

    /// Creates the error of a key from the message of an engine or the analysis, `FOUND; allowed:
    /// RULE`. A message without the second part is taken as the rule.
    pub fn of_message(key: impl Into<String>, message: &str) -> Self {
        let parts = ["; allowed: ", "; allowed are ", "; allowed is "];
        let parts = parts.iter().find_map(|part| message.split_once(part));
        let (found, allowed) = parts.unwrap_or(("", message));
        Self::new(key, found, allowed)
    }

    /// Returns the error of a key unless the condition `good` holds.
    ///
    /// # Errors
    /// [`PlanError`] if it does not.
    pub fn require(
        good: bool,
        key: impl Into<String>,
        found: impl Display,
        allowed: impl Into<String>,
    ) -> Result<(), Self> {
        good.then_some(())
            .ok_or_else(|| Self::new(key, found, allowed))
    }
}

/// Evaluates an expression with the space type of a dimension known at run time:
/// `in_space!(dimension, S => S::ball(radius))`.
macro_rules! in_space {
    ($dimension:expr, $space:ident => $value:expr) => {
        if $dimension == 2 {
            type $space = stosszahl_model::Plane;
            $value
        } else {
            type $space = stosszahl_model::Volume;
            $value
        }
    };
}
pub(crate) use in_space;
