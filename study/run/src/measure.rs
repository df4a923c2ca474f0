//! Traits of measurements: [`Measure`] and [`Probe`]. A new measurement is one file in
//! [`crate::measures`] and one line in its list.
//!
//! A [`Measure`] is the description: its name in case files, options, sample times, tables and
//! verdicts. A [`Probe`] is the measurement on one engine of one replica: it observes collisions,
//! samples the gas, and keeps a record.

use std::any::Any;
use std::cell::OnceCell;
use std::sync::OnceLock;

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use stosszahl_case::format::DifferBeyond;
use stosszahl_model::{Interrupt, InvalidValue, Observer, Particles, Simulation, VelocityMoments};
use stosszahl_results::frames::ParticleFrame;
use stosszahl_results::{Snapshot, Table, VerdictText};

use crate::judge::VerdictRule;
use crate::judge::power::ReplicaSpread;
use crate::plan::{CasePlan, EnginePlan};

/// Description of a measurement: its name, options, sample times, tables and verdicts.
pub trait Measure: Sync {
    /// Returns the name of the measure: the table `[measure.NAME]` of a case file requests it and
    /// holds its options.
    fn name(&self) -> &'static str;

    /// Describes the measured quantity in one sentence.
    fn about(&self) -> &'static str;

    /// Returns the JSON Schema of the measure's options.
    fn options_schema(&self) -> schemars::Schema;

    /// Parses the measure's options in a case, to check them.
    ///
    /// # Errors
    /// [`BadOption`] names the first key that cannot be read.
    fn read_options(&self, plan: &CasePlan) -> Result<(), BadOption>;

    /// Returns true if the measure is made by default, without a table in the case.
    fn by_default(&self, _plan: &CasePlan) -> bool {
        false
    }

    /// Returns true if the measure supports a uniform shear flow, in which velocities are relative
    /// to the flow and periodic images move.
    fn knows_shear(&self) -> bool {
        false
    }

    /// Checks the options of a case, and whether the measure applies to it.
    ///
    /// # Errors
    /// [`BadOption`] names the key below `[measure.NAME]`.
    fn check_options(&self, plan: &CasePlan) -> Result<(), BadOption> {
        self.read_options(plan)
    }

    /// Returns the sample times of the probe, in the unit of time of the case, in any order.
    fn sample_times(&self, _plan: &CasePlan) -> Vec<f64> {
        Vec::new()
    }

    /// Returns the data that engines must keep for the probe, in addition to read access to
    /// particles.
    fn engine_needs(&self, _plan: &CasePlan) -> Needs {
        Needs::default()
    }

    /// Returns the final memory of the probe's record per particle or simulator \[bytes\].
    fn kept_per_particle(&self, _plan: &CasePlan) -> f64 {
        0.0
    }

    /// Returns the part of the final memory per particle or simulator that the last sample adds,
    /// after all other samples \[bytes\].
    fn kept_last_per_particle(&self, _plan: &CasePlan) -> f64 {
        0.0
    }

    /// Returns the memory of the probe's record per sample that does not depend on the number of
    /// particles \[bytes\]; it matters for measures with many samples.
    fn kept_per_look(&self, _plan: &CasePlan) -> f64 {
        64.0
    }

    /// Returns the further final memory of the probe's record, in addition to that per particle and
    /// per sample: histograms, cells and rows \[bytes\]. It is 0 if it is small.
    fn kept_bytes(&self, _plan: &CasePlan) -> f64 {
        0.0
    }

    /// Returns true if the probe needs all particles gathered in one process. Most probes use
    /// reductions over particles instead.
    fn gathers_particles(&self, _plan: &CasePlan) -> bool {
        false
    }

    /// Returns the memory that the probe needs only while it samples \[bytes\].
    fn working_bytes(&self, _plan: &CasePlan) -> f64 {
        0.0
    }

    /// Returns the memory of the measure's figures in the report, if it may be large \[bytes\].
    fn figure_bytes(&self, _plan: &CasePlan) -> f64 {
        0.0
    }

    /// Returns the collisions in companion gases that the probe simulates while it samples, over
    /// those of the engine: work in addition to the engine's own.
    fn companion_share(&self, _plan: &CasePlan, _engine: &EnginePlan) -> f64 {
        0.0
    }

    /// Returns true if the probe samples a replica, by its number from 0. In other replicas
    /// [`Probe::on_start`] and [`Probe::on_sample`] are not called.
    fn looks_at(&self, _plan: &CasePlan, _replica: u64) -> bool {
        true
    }

    /// Creates the probe of one engine and replica. By default the probe keeps no record, for
    /// measures whose tables use the records of other measures.
    fn new_probe(&self, _plan: &CasePlan, _engine: &EnginePlan) -> Box<dyn Probe> {
        Box::new(SampleProbe::new((), |(), _| {}))
    }

    /// Builds the tables of the measure over all engines and replicas.
    fn result_tables(&self, _plan: &CasePlan, _runs: &ReplicaRecords<'_>) -> Vec<Table> {
        Vec::new()
    }

    /// Returns the snapshot files of all particles at chosen times, each with its entry in the
    /// manifest.
    fn snapshot_files(
        &self,
        _plan: &CasePlan,
        _runs: &ReplicaRecords<'_>,
    ) -> Vec<(Snapshot, Vec<u8>)> {
        Vec::new()
    }

    /// Returns the particle frames for the player of the report.
    fn player_frames(&self, _plan: &CasePlan, _runs: &ReplicaRecords<'_>) -> Vec<FrameFile> {
        Vec::new()
    }

    /// Returns the largest number of verdicts of the measure that test a comparison; all such
    /// verdicts share the error probability of the case.
    fn test_count(&self, _plan: &CasePlan) -> usize {
        0
    }

    /// Returns the spread of the compared quantities over replicas, as far as it is known before a
    /// run.
    fn quantity_spreads(&self, _plan: &CasePlan) -> Vec<ReplicaSpread> {
        Vec::new()
    }

    /// Decides the verdicts of the measure, the most important first. `tables` are the tables of
    /// this measure.
    fn result_verdicts(
        &self,
        _plan: &CasePlan,
        _runs: &ReplicaRecords<'_>,
        _tables: &[Table],
    ) -> Vec<VerdictText> {
        Vec::new()
    }
}

/// File of particle frames of one engine, for the player of the report.
#[derive(Clone, Debug, PartialEq)]
pub struct FrameFile {
    /// Name of the engine whose particles the frames show.
    pub engine: String,
    /// Path of the frames file, relative to the results folder.
    pub file: String,
    /// Particle frames in the order of time.
    pub frames: Vec<ParticleFrame>,
}

/// Data that an engine must keep for measurements, such as displacements.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Needs {
    /// True if displacements of particles must be tracked.
    pub displacements: bool,
    /// Number of particles of each species whose whole trajectories are stored, in gases without
    /// positions.
    pub trajectories: usize,
}

/// Error of an option of a measure: its key and the allowed values.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{key}: {allowed}")]
pub struct BadOption {
    /// Key of the option inside the table of the measure; empty for the table itself.
    pub key: String,
    /// Description of the allowed values.
    pub allowed: String,
}

/// Measurement on one engine of one replica: it observes collisions, samples the gas and keeps a
/// record.
pub trait Probe: Send {
    /// Returns the observer of collisions; `None` if the probe needs none.
    fn collision_observer(&mut self) -> Option<&mut dyn Observer> {
        None
    }

    /// Begins the measurement: called once with the gas at the start, before the engine advances.
    fn on_start(&mut self, _moment: &mut SampleContext<'_>) {}

    /// Handles a stop of the run. It is called before the samples at each sample time of any
    /// measure, and after each kick.
    fn on_stop(&mut self, _stop: &RunStop) {}

    /// Samples the gas: called at each sample time of the measure, and only there.
    fn on_sample(&mut self, _moment: &mut SampleContext<'_>) {}

    /// Serializes the probe's record so far, for a checkpoint.
    ///
    /// # Errors
    /// If serialization fails, which is an error of the program.
    fn save_record(&self) -> Result<Vec<u8>, postcard::Error>;

    /// Restores the probe's record from a checkpoint.
    ///
    /// # Errors
    /// If the bytes cannot be read: the checkpoint is damaged.
    fn load_record(&mut self, bytes: &[u8]) -> Result<(), postcard::Error>;

    /// Returns the probe's record, for [`ReplicaRecords::records_of`].
    fn record(&self) -> &dyn Any;
}

/// Stop of an engine run, at a sample time or after a kick of the bath.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RunStop {
    /// Time of the stop \[engine time\].
    pub time: f64,
    /// Granular temperature of the gas at the stop, by [`Simulation::temperature`] \[energy\].
    pub temperature: f64,
    /// Granular temperature before the kick, if the stop follows one \[energy\].
    pub kicked_from: Option<f64>,
}

/// Parses the options of a measure from its table in the case; defaults without a table.
///
/// # Errors
/// [`BadOption`] names the first key that cannot be read.
pub fn options<O: DeserializeOwned>(plan: &CasePlan, name: &str) -> Result<O, BadOption> {
    let table = plan.case.measure.get(name).cloned().unwrap_or_default();
    let read = |table: toml::Table| toml::Value::Table(table).try_into::<O>();
    read(table.clone()).map_err(|error| {
        // Each option has a default, so the one that fails alone is at fault.
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

/// Returns the options of a measure, which were checked before.
pub fn chosen<O: DeserializeOwned + Default>(plan: &CasePlan, name: &str) -> O {
    options(plan, name).unwrap_or_default()
}

/// Measure without options.
#[derive(Default, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct NoOptions {}

/// Returns the share of the replicas after the first that a measure samples.
pub(crate) fn share_of_others(measure: &dyn Measure, plan: &CasePlan) -> f64 {
    let others = 1..plan.case.replicas;
    let all = others.clone().count().max(1);
    others.filter(|&one| measure.looks_at(plan, one)).count() as f64 / all as f64
}

/// Computes the work of an engine with companion gases of its measures, over its own work: for the
/// first replica, and on average for each further one.
pub(crate) fn work_with_companions(
    measures: &[&'static dyn Measure],
    plan: &CasePlan,
    engine: &EnginePlan,
) -> [f64; 2] {
    measures.iter().fold([1.0; 2], |[first, others], measure| {
        let share = measure.companion_share(plan, engine);
        let in_first = f64::from(u8::from(measure.looks_at(plan, 0)));
        [
            first + share * in_first,
            others + share * share_of_others(*measure, plan),
        ]
    })
}

/// Returns an error for a measure or one of its options, with the allowed values, unless `good`.
///
/// # Errors
/// [`BadOption`] unless `good`.
pub fn require(good: bool, key: &str, allowed: impl Into<String>) -> Result<(), BadOption> {
    good.then_some(()).ok_or_else(|| BadOption {
        key: key.to_owned(),
        allowed: allowed.into(),
    })
}

/// Implements `name`, `about`, `options_schema` and `read_options` of a measure from its name, its
/// description, and the type of its options.
macro_rules! described {
    ($name:expr, $about:expr, $options:ty) => {
        fn name(&self) -> &'static str {
            $name
        }

        fn about(&self) -> &'static str {
            $about
        }

        fn options_schema(&self) -> schemars::Schema {
            let mut schema = schemars::schema_for!($options);
            schema.insert("title".into(), "Options".into());
            schema
        }

        fn read_options(
            &self,
            plan: &$crate::plan::CasePlan,
        ) -> Result<(), $crate::measure::BadOption> {
            $crate::measure::options::<$options>(plan, $name).map(drop)
        }
    };
}
pub(crate) use described;

/// Implements `save_record`, `load_record` and `record` of a probe whose state is its field
/// `record`.
macro_rules! keeps_record {
    () => {
        fn save_record(&self) -> Result<Vec<u8>, postcard::Error> {
            postcard::to_stdvec(&self.record)
        }

        fn load_record(&mut self, bytes: &[u8]) -> Result<(), postcard::Error> {
            self.record = postcard::from_bytes(bytes)?;
            Ok(())
        }

        fn record(&self) -> &dyn std::any::Any {
            &self.record
        }
    };
}
pub(crate) use keeps_record;

/// Probe that only samples, at the times of its measure and, on request, at the start.
pub struct SampleProbe<R, F> {
    record: R,
    look: F,
    from_start: bool,
}

impl<R, F: FnMut(&mut R, &mut SampleContext<'_>) + Send> SampleProbe<R, F> {
    /// Creates a probe with an empty record; the function `look` adds a sample to it.
    pub fn new(record: R, look: F) -> Self {
        Self {
            record,
            look,
            from_start: false,
        }
    }

    /// Creates a probe that also samples the gas at the start of the run.
    pub fn from_start(record: R, look: F) -> Self {
        Self {
            from_start: true,
            ..Self::new(record, look)
        }
    }
}

impl<R, F> Probe for SampleProbe<R, F>
where
    R: Serialize + DeserializeOwned + Send + 'static,
    F: FnMut(&mut R, &mut SampleContext<'_>) + Send,
{
    fn on_start(&mut self, moment: &mut SampleContext<'_>) {
        if self.from_start {
            self.on_sample(moment);
        }
    }

    fn on_sample(&mut self, moment: &mut SampleContext<'_>) {
        (self.look)(&mut self.record, moment);
    }

    keeps_record!();
}

/// Context of a sample: the gas at one time, with quantities that are computed once for all probes.
pub struct SampleContext<'a> {
    /// Time of the sample, in the unit of time of the case.
    pub time: f64,
    /// Number of the replica, from 0.
    pub replica: u64,
    /// Simulation of the gas to be sampled.
    pub simulation: &'a mut dyn Simulation,
    /// Kinetic energy added by a thermostat since the start \[energy\].
    pub heated: f64,
    /// Interrupt that ends a long sample, which is then discarded.
    pub interrupt: Interrupt,
    particles: OnceCell<Particles>,
    moments: OnceCell<VelocityMoments>,
}

impl<'a> SampleContext<'a> {
    /// Creates the context of a sample of replica 0.
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

    /// Sets the moments of the velocities, which are then not computed again.
    #[must_use]
    pub(crate) fn with_moments(self, moments: VelocityMoments) -> Self {
        Self {
            moments: moments.into(),
            ..self
        }
    }

    /// Returns all particles, gathered once for all probes.
    pub fn particles(&self) -> &Particles {
        self.particles.get_or_init(|| self.simulation.particles())
    }

    /// Returns the moments of the velocities, computed once for all probes.
    pub fn moments(&self) -> &VelocityMoments {
        self.moments
            .get_or_init(|| self.simulation.velocity_moments())
    }

    /// Returns the granular temperature of the gas \[energy\].
    pub fn temperature(&self) -> f64 {
        self.moments().temperature(self.simulation.dimension())
    }
}

/// Result of one engine of one replica: the probes with their records, and the cost.
pub struct CompletedRun {
    /// Probes of the run, in the order of the measures of the case.
    pub probes: Vec<Box<dyn Probe>>,
    /// Work counters of the engine at the end.
    pub work: stosszahl_model::WorkCounters,
    /// Largest memory of the engine during the run \[bytes\].
    pub bytes: usize,
    /// Computing time of the run \[s\].
    pub seconds: f64,
}

impl CompletedRun {
    /// Returns the record of the type `R` that some probe keeps; `None` if its measure is not made.
    pub fn record<R: 'static>(&self) -> Option<&R> {
        let mut records = self.probes.iter().map(|probe| probe.record());
        records.find_map(|record| record.downcast_ref())
    }
}

/// Returns the decision rule of a case with a given error probability and margin.
fn rule(plan: &CasePlan, level: f64, margin: f64) -> VerdictRule {
    let differ_beyond = match plan.case.verdict.differ_beyond {
        DifferBeyond::Zero => 0.0,
        DifferBeyond::Margin => margin,
    };
    VerdictRule {
        level,
        margin,
        differ_beyond,
    }
}

/// Records of all engines and replicas, as one measure uses them.
pub struct ReplicaRecords<'a> {
    /// Index of this measure among the measures of the case.
    pub measure: usize,
    /// Error probability of each verdict: an equal share of `verdict.family_wise_error_rate`, by
    /// Bonferroni over all verdicts of the point.
    pub level: f64,
    /// Finished runs by engine, then by replica.
    pub finished: &'a [Vec<CompletedRun>],
}

impl<'a> ReplicaRecords<'a> {
    /// Returns the decision rule for relative differences.
    pub fn rule(&self, plan: &CasePlan) -> VerdictRule {
        rule(plan, self.level, plan.case.verdict.tolerance)
    }

    /// Returns the decision rule for numbers that vanish under molecular chaos, in their own unit.
    pub fn absolute_rule(&self, plan: &CasePlan) -> VerdictRule {
        rule(plan, self.level, plan.case.verdict.absolute_tolerance)
    }

    /// Returns this measure's records of all replicas of an engine, by the engine's index in the
    /// plan.
    ///
    /// # Panics
    /// If the probe keeps another type of record, which is an error of the program.
    pub fn records<R: 'static>(&self, engine: usize) -> Vec<&'a R> {
        let record = |one: &'a CompletedRun| one.probes[self.measure].record().downcast_ref();
        let all = self.finished[engine].iter().map(record);
        all.map(|record| record.expect("the record of this probe"))
            .collect()
    }

    /// Returns each engine of the plan with this measure's records of its replicas.
    pub fn each<'p, R: 'static>(
        &self,
        plan: &'p CasePlan,
    ) -> impl Iterator<Item = (&'p EnginePlan, Vec<&'a R>)> {
        let engines = plan.engines.iter().enumerate();
        engines.map(|(index, engine)| (engine, self.records(index)))
    }

    /// Returns the records of the type `R` of all replicas of an engine; empty if no measure keeps
    /// them.
    pub fn records_of<R: 'static>(&self, engine: usize) -> Vec<&'a R> {
        let finished = self.finished.get(engine).into_iter().flatten();
        finished.filter_map(CompletedRun::record).collect()
    }
}

/// Returns the empty tables that a run of a case will have, each with its measure, without solving
/// theory for them.
pub(crate) fn empty_tables(
    plan: &CasePlan,
    measures: &[&'static dyn Measure],
) -> Vec<(&'static dyn Measure, Table)> {
    let mut plan = plan.clone();
    // Some tables have rows although there are no records.
    if plan.equal_samples().is_some() {
        plan.case.run.samples = Some(1);
    }
    plan.case.verdict.sonine_orders = Some(1);
    let unsolved = InvalidValue::new("replicas", 0.0, "at least 1");
    plan.theory.curves = OnceLock::from(Err(unsolved.into()));
    let none: Vec<Vec<CompletedRun>> = plan.engines.iter().map(|_| Vec::new()).collect();
    let each = measures.iter().enumerate().flat_map(|(measure, one)| {
        let runs = ReplicaRecords {
            measure,
            level: 1.0,
            finished: &none,
        };
        let tables = one.result_tables(&plan, &runs).into_iter();
        tables.map(move |table| {
            (
                *one,
                Table {
                    rows: Vec::new(),
                    ..table
                },
            )
        })
    });
    each.collect()
}
