//! A valid case of a gas without positions.

use std::path::Path;
use std::sync::OnceLock;

use serde::Serialize;

use super::validate;
use super::written::Written;
pub use super::written::{
    ContactValues, Distribution, EnergyPart, FirstTest, Restitution, Rounding, Selection, TimeUnit,
};
use crate::case::{Form, Kind, Problem, Schema};

/// A valid case. Times are in the unit that `run.time_unit` names, all else in the case's own units.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Case {
    /// What the case shows, in one line.
    pub title: String,
    /// Seed of every random stream.
    pub seed: u64,
    /// Number of independent runs, at least 1.
    pub replicas: usize,
    /// Dimension, 2 or 3.
    pub dimension: usize,
    /// Volume, above 0.
    pub volume: f64,
    /// Restitution, but for the pairs below.
    pub restitution: Restitution,
    /// Restitution of single pairs of species, counted from 0.
    pub pairs: Vec<([usize; 2], Restitution)>,
    /// How density raises collision rates.
    pub contact_values: ContactValues,
    /// What the gas consists of.
    pub content: Content,
    /// When particles stick together or break.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sticking: Option<Sticking>,
    /// Time between two scalings of all velocities to the energy of the start, above 0; none lets the gas cool.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub heating_interval: Option<f64>,
    /// How pairs are selected.
    pub selection: Selection,
    /// How long to run and when to sample.
    pub run: Run,
    /// What is measured.
    pub measure: Measure,
    /// Largest deviation from theory that counts as agreement, above 0.
    pub tolerance: f64,
    /// Orders of the Sonine expansion in theory; none leaves them to the program.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sonine_orders: Option<usize>,
}

/// What a gas consists of.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Content {
    /// The species listed, one after the other.
    Species(Vec<Species>),
    /// As many species as the power law has.
    PowerLaw {
        /// Number of particles of mass 1.
        monomers: u64,
        /// The exponent.
        exponent: f64,
        /// Largest mass, if it is not where the numbers fall to zero.
        largest_mass: Option<u64>,
        /// How numbers become whole.
        rounding: Rounding,
        /// Temperature of all at the start.
        temperature: f64,
    },
    /// Every particle with its own size.
    Continuous {
        /// Number of particles.
        particles: usize,
        /// Distribution of the diameters.
        distribution: Distribution,
        /// Mean diameter.
        mean_diameter: f64,
        /// Standard deviation over the mean.
        relative_width: f64,
        /// Mass of a particle of diameter 1.
        unit_mass: f64,
        /// Temperature of all at the start.
        temperature: f64,
        /// Groups of like size.
        groups: usize,
    },
}

/// One species.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Species {
    /// Number of particles.
    pub count: usize,
    /// Mass of a particle, above 0.
    pub mass: f64,
    /// Diameter of a particle, above 0.
    pub diameter: f64,
    /// Temperature at the start, above 0.
    pub temperature: f64,
    /// Whether it leaves no trace.
    pub tracer: bool,
}

/// When particles stick together or break.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Sticking {
    /// Energy below which pairs stick; none lets all stick.
    pub stick_below: Option<f64>,
    /// What is compared with it.
    pub stick_part: EnergyPart,
    /// Energy above which pairs break; none lets none break.
    pub break_above: Option<f64>,
    /// What is compared with it.
    pub break_part: EnergyPart,
    /// Which test comes first.
    pub first: FirstTest,
    /// Factor of the relative speed in breaking, from 0 to 1.
    pub speed_kept_in_breaking: f64,
}

/// How long to run and when to sample.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Run {
    /// Unit of the times.
    pub time_unit: TimeUnit,
    /// End of the run, above 0.
    pub until: f64,
    /// First sample after the start, above 0 and below `until`.
    pub first_sample: f64,
    /// Samples in each factor of ten of time, at least 1.
    pub samples_per_decade: usize,
    /// Seconds of computing between two checkpoints, above 0.
    pub checkpoint_seconds: f64,
}

/// What is measured besides temperatures, fourth cumulants and collisions.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Measure {
    /// Mean squared displacements.
    pub displacement: bool,
    /// Correlation of the velocities with those of the start.
    pub velocity_correlation: bool,
    /// Particles of each species whose whole paths are kept.
    pub paths: usize,
    /// When the sizes of clusters are counted, rising; empty where none stick.
    pub size_distribution_times: Vec<f64>,
    /// Where the steady state begins and which clusters the power law is fitted to, where particles stick and break.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub steady: Option<Steady>,
}

/// How a steady state of sticking and breaking is measured.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Steady {
    /// From when on.
    pub from: f64,
    /// Smallest and largest number of monomers of the fitted power law.
    pub fit_monomers: [u32; 2],
}

impl Case {
    /// Times of the samples: 0, then a logarithmic grid from the first sample on, and last the end of the run exactly.
    pub fn sample_times(&self) -> Vec<f64> {
        std::iter::once(0.0)
            .chain(logarithmic(
                self.run.first_sample,
                self.run.until,
                self.run.samples_per_decade,
            ))
            .collect()
    }

    /// Lags of the displacements averaged over time: as the samples, up to a tenth of the run, beyond which a path has too
    /// few independent starts.
    pub fn lags(&self) -> Vec<f64> {
        let last = 0.1 * self.run.until;
        if self.measure.paths == 0 || self.run.first_sample >= last {
            return Vec::new();
        }
        logarithmic(self.run.first_sample, last, self.run.samples_per_decade).collect()
    }
}

/// A logarithmic grid, and last the end exactly; a point that all but coincides with the end is left out.
fn logarithmic(first: f64, until: f64, per_decade: usize) -> impl Iterator<Item = f64> {
    (0..)
        .map(move |i| first * 10_f64.powf(f64::from(i) / per_decade as f64))
        .take_while(move |&time| time < until * (1.0 - 1e-9))
        .chain(std::iter::once(until))
}

impl Form for Case {
    const KIND: Kind = Kind::Homogeneous;

    fn schema() -> &'static Schema {
        static SCHEMA: OnceLock<Schema> = OnceLock::new();
        SCHEMA.get_or_init(Schema::of::<Written>)
    }

    fn from_table(table: &toml::Table, _folder: &Path) -> Result<Self, Problem> {
        validate::case(table)
    }
}
