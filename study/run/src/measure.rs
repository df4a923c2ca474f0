//! What can be measured, and how a measurement is added: one file in [`crate::measures`] and one line in its list.
//!
//! A [`Measure`] is the description: its name in case files, its options, when it looks, which tables and verdicts follow.
//! A [`Probe`] is the measurement on one engine of one replica: it observes collisions, looks at moments, and keeps a record.

use std::any::Any;
use std::cell::OnceCell;

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use stosszahl_case::format::DifferBeyond;
use stosszahl_model::{Interrupt, Moments, Observer, Particles, Simulation};
use stosszahl_results::frames::Frame;
use stosszahl_results::{Snapshot, Table, Verdict};

use crate::judge::Rule;
use crate::plan::{EnginePlan, Plan};
use crate::power::Spread;

/// A measurement, before it is made.
pub trait Measure: Sync {
    /// Its name: the table `[measure.NAME]` of a case file asks for it and holds its options.
    fn name(&self) -> &'static str;

    /// What it measures, in one sentence.
    fn about(&self) -> &'static str;

    /// JSON Schema of its options.
    fn schema(&self) -> schemars::Schema;

    /// Reads its options.
    ///
    /// # Errors
    /// [`BadOption`] names the first key that cannot be read.
    fn read(&self, plan: &Plan) -> Result<(), BadOption>;

    /// Whether it is made in this case although the case does not name it.
    fn by_default(&self, _plan: &Plan) -> bool {
        false
    }

    /// Whether it is right in a uniform shear flow, where velocities are relative to the flow and images move.
    fn knows_shear(&self) -> bool {
        false
    }

    /// Checks the options of a case and whether the measurement makes sense there.
    ///
    /// # Errors
    /// [`BadOption`] names the key below `[measure.NAME]`.
    fn check(&self, plan: &Plan) -> Result<(), BadOption> {
        self.read(plan)
    }

    /// Times at which its probe looks, in the unit of time of the case, in any order.
    fn times(&self, _plan: &Plan) -> Vec<f64> {
        Vec::new()
    }

    /// What it asks of the engines beyond a look at them.
    fn needs(&self, _plan: &Plan) -> Needs {
        Needs::default()
    }

    /// Memory that the record of its probe takes in the end, for each particle or simulator \[bytes\].
    fn kept_per_particle(&self, _plan: &Plan) -> f64 {
        0.0
    }

    /// What of that comes with the last look, after all others have looked \[bytes\].
    fn kept_last_per_particle(&self, _plan: &Plan) -> f64 {
        0.0
    }

    /// Memory that the record of its probe takes for each look, whatever the number of particles, where there may be many looks \[bytes\].
    fn kept_per_look(&self, _plan: &Plan) -> f64 {
        64.0
    }

    /// What it takes whatever their number, where that may be much \[bytes\].
    fn kept(&self, _plan: &Plan) -> f64 {
        0.0
    }

    /// Whether it looks at all particles at once, so that they are gathered. Most add them up where they are.
    fn gathers(&self, _plan: &Plan) -> bool {
        false
    }

    /// Memory that it takes while it looks, beside what it keeps \[bytes\].
    fn working(&self, _plan: &Plan) -> f64 {
        0.0
    }

    /// Memory that its figures take when the report is made, where that may be much \[bytes\].
    fn figures(&self, _plan: &Plan) -> f64 {
        0.0
    }

    /// Whether it looks at a replica, by its number from 0: [`Probe::begin`] and [`Probe::sample`] are not called in others.
    fn looks_at(&self, _plan: &Plan, _replica: u64) -> bool {
        true
    }

    /// The measurement on one engine of one replica; none where tables come from the records of other measures.
    fn probe(&self, _plan: &Plan, _engine: &EnginePlan) -> Box<dyn Probe> {
        Box::new(Recorder::new((), |(), _| {}))
    }

    /// Tables of all engines and replicas.
    fn tables(&self, _plan: &Plan, _runs: &Runs<'_>) -> Vec<Table> {
        Vec::new()
    }

    /// Files of all particles at some times, with what the manifest says of them.
    fn snapshots(&self, _plan: &Plan, _runs: &Runs<'_>) -> Vec<(Snapshot, String)> {
        Vec::new()
    }

    /// Frames for the player of the report.
    fn frames(&self, _plan: &Plan, _runs: &Runs<'_>) -> Vec<FrameFile> {
        Vec::new()
    }

    /// How many verdicts it makes that compare, at most: they share the chance of a false alarm of the case.
    fn tests(&self, _plan: &Plan) -> usize {
        0
    }

    /// How far the replicas lie apart of what these verdicts compare, as far as that is known before a run.
    fn spreads(&self, _plan: &Plan) -> Vec<Spread> {
        Vec::new()
    }

    /// What follows, the most important first. `tables` are those of this measure.
    fn verdicts(&self, _plan: &Plan, _runs: &Runs<'_>, _tables: &[Table]) -> Vec<Verdict> {
        Vec::new()
    }
}

/// Frames of one engine, and the file that holds them.
#[derive(Clone, Debug, PartialEq)]
pub struct FrameFile {
    /// Engine.
    pub engine: String,
    /// Path of the file, relative to the results folder.
    pub file: String,
    /// The frames, by time.
    pub frames: Vec<Frame>,
}

/// What measurements ask of engines, which keep nothing that nobody looks at.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Needs {
    /// That displacements can be followed.
    pub displacements: bool,
    /// Particles of each species whose whole trajectories are kept, in gases without positions.
    pub trajectories: usize,
}

/// An option that cannot be.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{key}: {allowed}")]
pub struct BadOption {
    /// The key below the table of the measure; empty for the table itself.
    pub key: String,
    /// What is allowed.
    pub allowed: String,
}

/// A measurement on one engine of one replica.
pub trait Probe: Send {
    /// What observes collisions, if anything does.
    fn observer(&mut self) -> Option<&mut dyn Observer> {
        None
    }

    /// Called once before the engine moves, with the gas at the start.
    fn begin(&mut self, _moment: &mut Moment<'_>) {}

    /// Called wherever the run stops: at each time at which any measure looks, before they do, and after each kick.
    fn stop(&mut self, _stop: &Stop) {}

    /// Called at each of the times of the measure, and only there.
    fn sample(&mut self, _moment: &mut Moment<'_>) {}

    /// The record so far, for a checkpoint.
    ///
    /// # Errors
    /// If it cannot be written, which is an error of the program.
    fn save(&self) -> Result<Vec<u8>, postcard::Error>;

    /// Goes on from a record.
    ///
    /// # Errors
    /// If it cannot be read: the checkpoint is damaged.
    fn load(&mut self, bytes: &[u8]) -> Result<(), postcard::Error>;

    /// The record, for [`Runs::find`].
    fn record(&self) -> &dyn Any;
}

/// A place where a run stops.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stop {
    /// When [engine time].
    pub time: f64,
    /// Granular temperature of the gas, by [`Simulation::temperature`].
    pub temperature: f64,
    /// After a kick: the temperature before it.
    pub kicked_from: Option<f64>,
}

/// The options of a measure in a case: those of its table, or the defaults.
///
/// # Errors
/// [`BadOption`] names the first key that cannot be read.
pub fn options<O: DeserializeOwned>(plan: &Plan, name: &str) -> Result<O, BadOption> {
    let table = plan.case.measure.get(name).cloned().unwrap_or_default();
    let read = |table: toml::Table| toml::Value::Table(table).try_into::<O>();
    read(table.clone()).map_err(|error| {
        // Each option has a default, so the one that fails alone is the bad one.
        let alone = |key: &str| {
            table
                .get(key)
                .map(|value| [(key.to_owned(), value.clone())])
        };
        let bad = table.keys().find_map(|key| {
            let failed = read(alone(key)?.into_iter().collect()).err()?;
            Some((key.clone(), failed))
        });
        let (key, error) = bad.unwrap_or((String::new(), error));
        BadOption {
            key,
            allowed: error.message().trim().to_owned(),
        }
    })
}

/// The same of options that are checked.
pub fn chosen<O: DeserializeOwned + Default>(plan: &Plan, name: &str) -> O {
    options(plan, name).unwrap_or_default()
}

/// It has no options.
#[derive(Default, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
#[schemars(rename = "Options")]
pub struct NoOptions {}

/// Of the replicas after the first, the share at which a measure looks.
pub(crate) fn share_of_others(measure: &dyn Measure, plan: &Plan) -> f64 {
    let others = 1..plan.case.replicas;
    let all = others.clone().count().max(1);
    others.filter(|&one| measure.looks_at(plan, one)).count() as f64 / all as f64
}

/// Refuses a measure, or one of its options, with what is allowed.
///
/// # Errors
/// [`BadOption`] unless `good`.
pub fn require(good: bool, key: &str, allowed: impl Into<String>) -> Result<(), BadOption> {
    good.then_some(()).ok_or_else(|| BadOption {
        key: key.to_owned(),
        allowed: allowed.into(),
    })
}

/// The name of a measure, what it measures in one sentence, and the type of its options.
macro_rules! described {
    ($name:expr, $about:expr, $options:ty) => {
        fn name(&self) -> &'static str {
            $name
        }

        fn about(&self) -> &'static str {
            $about
        }

        fn schema(&self) -> schemars::Schema {
            schemars::schema_for!($options)
        }

        fn read(&self, plan: &$crate::plan::Plan) -> Result<(), $crate::measure::BadOption> {
            $crate::measure::options::<$options>(plan, $name).map(drop)
        }
    };
}
pub(crate) use described;

/// The three methods of a probe that keeps all it knows in its field `record`.
macro_rules! keeps_record {
    () => {
        fn save(&self) -> Result<Vec<u8>, postcard::Error> {
            postcard::to_stdvec(&self.record)
        }

        fn load(&mut self, bytes: &[u8]) -> Result<(), postcard::Error> {
            self.record = postcard::from_bytes(bytes)?;
            Ok(())
        }

        fn record(&self) -> &dyn std::any::Any {
            &self.record
        }
    };
}
pub(crate) use keeps_record;

/// A probe that only looks: at the times of its measure, and at the start too where that is asked for.
pub struct Recorder<R, F> {
    record: R,
    look: F,
    from_start: bool,
}

impl<R, F: FnMut(&mut R, &mut Moment<'_>) + Send> Recorder<R, F> {
    /// From an empty record, to which each look adds.
    pub fn new(record: R, look: F) -> Self {
        Self {
            record,
            look,
            from_start: false,
        }
    }

    /// The same, with a look at the start.
    pub fn from_start(record: R, look: F) -> Self {
        Self {
            from_start: true,
            ..Self::new(record, look)
        }
    }
}

impl<R, F> Probe for Recorder<R, F>
where
    R: Serialize + DeserializeOwned + Send + 'static,
    F: FnMut(&mut R, &mut Moment<'_>) + Send,
{
    fn begin(&mut self, moment: &mut Moment<'_>) {
        if self.from_start {
            self.sample(moment);
        }
    }

    fn sample(&mut self, moment: &mut Moment<'_>) {
        (self.look)(&mut self.record, moment);
    }

    keeps_record!();
}

/// A moment of a run.
pub struct Moment<'a> {
    /// When, in the unit of time of the case.
    pub time: f64,
    /// Number of the replica, from 0.
    pub replica: u64,
    /// The gas.
    pub simulation: &'a mut dyn Simulation,
    /// Kinetic energy that a thermostat has put in since the start \[energy\].
    pub heated: f64,
    /// Breaks long work off; what a probe leaves then is thrown away.
    pub interrupt: Interrupt,
    particles: OnceCell<Particles>,
    moments: OnceCell<Moments>,
}

impl<'a> Moment<'a> {
    /// A moment of a gas, the first replica of it.
    pub fn new(time: f64, simulation: &'a mut dyn Simulation) -> Self {
        Self {
            time,
            replica: 0,
            simulation,
            heated: 0.0,
            interrupt: Interrupt::default(),
            particles: OnceCell::new(),
            moments: OnceCell::new(),
        }
    }

    /// The same with the moments of its velocities, which are known.
    #[must_use]
    pub(crate) fn with_moments(self, moments: Moments) -> Self {
        Self {
            moments: moments.into(),
            ..self
        }
    }

    /// All particles, gathered once for all probes that look.
    pub fn particles(&self) -> &Particles {
        self.particles.get_or_init(|| self.simulation.particles())
    }

    /// Moments of the velocities, added up once for all probes that look.
    pub fn moments(&self) -> &Moments {
        self.moments.get_or_init(|| self.simulation.moments())
    }

    /// Granular temperature \[energy\].
    pub fn temperature(&self) -> f64 {
        self.moments().temperature(self.simulation.dimension())
    }
}

/// What one engine of one replica left.
pub struct Finished {
    /// The probes of the measures of the case, in their order.
    pub probes: Vec<Box<dyn Probe>>,
    /// What was done.
    pub work: stosszahl_model::Work,
    /// Largest memory of the engine \[bytes\].
    pub bytes: usize,
    /// Computing time \[s\].
    pub seconds: f64,
}

impl Finished {
    /// The record of a type that some measure keeps; none if that measure is not made.
    pub fn record<R: 'static>(&self) -> Option<&R> {
        let mut records = self.probes.iter().map(|probe| probe.record());
        records.find_map(|record| record.downcast_ref())
    }
}

/// Rule of a case with one of its margins.
fn rule(plan: &Plan, level: f64, margin: f64) -> Rule {
    let differ_beyond = match plan.case.verdict.differ_beyond {
        DifferBeyond::Zero => 0.0,
        DifferBeyond::Margin => margin,
    };
    Rule {
        level,
        margin,
        differ_beyond,
    }
}

/// All engines and replicas of a case, as one measure sees them.
pub struct Runs<'a> {
    /// Position of the measure among those of the case.
    pub measure: usize,
    /// Chance of a false difference that each verdict has: an equal share of `verdict.family_wise_error_rate`, by Bonferroni over all
    /// verdicts of the point.
    pub level: f64,
    /// By engine, then by replica.
    pub finished: &'a [Vec<Finished>],
}

impl<'a> Runs<'a> {
    /// Rule of relative differences in a case.
    pub fn rule(&self, plan: &Plan) -> Rule {
        rule(plan, self.level, plan.case.verdict.tolerance)
    }

    /// Rule of numbers that are zero under chaos, in their own unit.
    pub fn absolute_rule(&self, plan: &Plan) -> Rule {
        rule(plan, self.level, plan.case.verdict.absolute_tolerance)
    }

    /// The records of all replicas of an engine, by its position in the plan.
    ///
    /// # Panics
    /// If the probe keeps another type of record, which is an error of the program.
    pub fn records<R: 'static>(&self, engine: usize) -> Vec<&'a R> {
        let record = |one: &'a Finished| one.probes[self.measure].record().downcast_ref();
        let all = self.finished[engine].iter().map(record);
        all.map(|record| record.expect("the record of this probe"))
            .collect()
    }

    /// Each engine with the records of its replicas.
    pub fn each<'p, R: 'static>(
        &self,
        plan: &'p Plan,
    ) -> impl Iterator<Item = (&'p EnginePlan, Vec<&'a R>)> {
        let engines = plan.engines.iter().enumerate();
        engines.map(|(index, engine)| (engine, self.records(index)))
    }

    /// The records of a type that another measure keeps, of all replicas of an engine; none if that measure is not made.
    pub fn find<R: 'static>(&self, engine: usize) -> Vec<&'a R> {
        let finished = self.finished.get(engine).into_iter().flatten();
        finished.filter_map(Finished::record).collect()
    }
}
