//! Measure `snapshots`: files with all particles of chosen replicas at chosen times. Formats are
//! extended XYZ (OVITO, ASE), LAMMPS dump, GSD, H5MD, and CSV for gases without positions.

mod gsd;
mod h5md;
mod lammps;
mod quantity;
#[cfg(test)]
mod tests;
mod tilted_box;
mod xyz;

use std::fmt::Write as _;

use serde::{Deserialize, Serialize};
use stosszahl_model::{Particles, Shear};
use stosszahl_results::{SNAPSHOTS, Snapshot};

use self::quantity::{ParticleQuantity, written};
use self::tilted_box::TiltedBox;
use super::selection::{Replicas, check_engines, is_named};
use crate::measure::{self, BadOption, Measure, Probe, ReplicaRecords, SampleProbe, described};
use crate::plan::{CasePlan, EnginePlan, UnitScale};

/// Approximate length of a line of a snapshot file \[bytes\]: four numbers with all digits in the
/// plane.
const LINE: f64 = 100.0;

/// Measure `snapshots` that writes all particles at chosen times.
pub struct SnapshotMeasure;

/// Largest number of snapshots of one engine that an interval may lead to.
const MOST: f64 = 10_000.0;

/// Options of `[measure.snapshots]`: times, engines, replicas, quantities and formats.
#[derive(Clone, Debug, Default, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct SnapshotOptions {
    /// Times of the snapshots. Default: the end of the run.
    pub times: Option<Vec<f64>>,
    /// Time between two snapshots, from the start on, in place of `times`.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub interval: Option<f64>,
    /// Engines whose particles are written, by name. Default: all.
    pub engines: Option<Vec<String>>,
    /// Replicas whose particles are written, by number from 0, or "all". Default: \[0\].
    pub replicas: Replicas,
    /// Quantities of particles that are written next to positions. Default: `velocity`, `radius`
    /// and `mass`, and the others where particles differ in them.
    pub quantities: Option<Vec<ParticleQuantity>>,
    /// File formats of a gas with positions, each in files of its own: extended XYZ, text dumps of
    /// LAMMPS (`.dump`), GSD, H5MD (`.h5`). Default: \["xyz"\].
    pub formats: Option<Vec<SnapshotFormat>>,
}

/// File format of snapshots of gases with positions.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum SnapshotFormat {
    /// Extended XYZ: OVITO, ASE; the report shows it. All digits.
    Xyz,
    /// Text dump of LAMMPS: LAMMPS, OVITO, ASE, `MDAnalysis`. All digits.
    Lammps,
    /// GSD of the schema hoomd: HOOMD-blue, OVITO, freud, `MDAnalysis`. Single precision.
    Gsd,
    /// H5MD, groups and arrays of HDF5: `MDAnalysis`, h5py. All digits.
    H5md,
}

impl SnapshotFormat {
    /// Returns the file name extension of the format, without the dot.
    fn ending(self) -> &'static str {
        match self {
            Self::Xyz => "xyz",
            Self::Lammps => "dump",
            Self::Gsd => "gsd",
            Self::H5md => "h5",
        }
    }
}

impl SnapshotOptions {
    /// Returns the file name extensions of a snapshot, without the dot, one for each format that is
    /// written.
    fn endings(&self, plan: &CasePlan) -> Vec<&'static str> {
        if plan.has_box() {
            self.formats().iter().map(|one| one.ending()).collect()
        } else {
            vec!["csv"]
        }
    }

    fn formats(&self) -> &[SnapshotFormat] {
        self.formats.as_deref().unwrap_or(&[SnapshotFormat::Xyz])
    }
}

/// Snapshot files of one engine and replica, in the order of time.
type Records = Vec<SnapshotFiles>;

/// Snapshot files of one engine at one time, one for each format.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct SnapshotFiles {
    /// Number of the replica, from 0.
    replica: u64,
    /// Contents of the files, in the order of the formats.
    files: Vec<serde_bytes::ByteBuf>,
}

/// Units of the numbers in a snapshot file.
#[derive(Clone, Copy)]
struct SnapshotUnits {
    scale: UnitScale,
    /// Unit of time of the case over Haff's time t0; `None` for a gas that does not cool.
    time_over_t0: Option<f64>,
    /// Third side of the box in a snapshot of disks: a mean diameter \[length of the case\], or 1
    /// for points.
    depth: f64,
    /// Shear flow of the gas at time 0 \[engine units\]; `None` without shear.
    shear: Option<Shear>,
}

impl SnapshotUnits {
    fn new(plan: &CasePlan) -> Self {
        let depth = 2.0 * plan.mean_radius() * plan.scale.length;
        Self {
            scale: plan.scale,
            time_over_t0: plan.cooling_time().map(|t0| plan.clock.time / t0),
            depth: if depth > 0.0 { depth } else { 1.0 },
            shear: plan.gas.particles.shear(),
        }
    }
}

/// Content of a snapshot file: particles, time and units.
struct Content<'a> {
    particles: &'a Particles,
    quantities: Vec<ParticleQuantity>,
    units: SnapshotUnits,
    domain: TiltedBox,
    engine: &'a str,
    /// Time of the snapshot, in the unit of time of the case.
    time: f64,
    /// Number of the snapshot of the engine, from 0.
    index: usize,
}

impl<'a> Content<'a> {
    fn new(
        particles: &'a Particles,
        asked: Option<&[ParticleQuantity]>,
        units: SnapshotUnits,
        engine: &'a str,
        time: f64,
    ) -> Self {
        Self {
            particles,
            quantities: written(asked, particles),
            units,
            domain: TiltedBox::of(particles, units),
            engine,
            time,
            index: 0,
        }
    }

    fn file(&self, format: SnapshotFormat) -> Vec<u8> {
        match format {
            SnapshotFormat::Xyz => xyz::xyz(self).into_bytes(),
            SnapshotFormat::Lammps => lammps::dump(self).into_bytes(),
            SnapshotFormat::Gsd => gsd::gsd(self),
            SnapshotFormat::H5md => h5md::h5md(self),
        }
    }
}

/// Formats all quantities of particles as extended XYZ, in the units of the case.
pub fn extended_xyz(particles: &Particles, plan: &CasePlan, engine: &str) -> String {
    let (time, units) = (particles.time / plan.clock.time, SnapshotUnits::new(plan));
    xyz::xyz(&Content::new(particles, None, units, engine, time))
}

/// Formats the particles of a gas without positions as CSV, with a column for each number of a
/// particle.
fn csv(particles: &Particles, asked: Option<&[ParticleQuantity]>, scale: UnitScale) -> String {
    let quantities = written(asked, particles);
    let mut text = String::with_capacity(LINE as usize * particles.all.len());
    text.push_str("id");
    for one in &quantities {
        let name = one.name();
        let _ = if one.is_vector() {
            write!(text, ",{name}_x,{name}_y,{name}_z")
        } else {
            write!(text, ",{name}")
        };
    }
    text.push('\n');
    for (index, one) in particles.all.iter().enumerate() {
        let _ = write!(text, "{index}");
        for quantity in &quantities {
            for number in quantity.numbers(one, scale).as_slice() {
                let _ = write!(text, ",{number}");
            }
        }
        text.push('\n');
    }
    text
}

impl Measure for SnapshotMeasure {
    described!(
        "snapshots",
        "All particles at chosen times, as extended XYZ, dumps of LAMMPS, GSD or H5MD; velocities of gases without positions, as CSV.",
        SnapshotOptions
    );

    fn knows_shear(&self) -> bool {
        true
    }

    fn by_default(&self, plan: &CasePlan) -> bool {
        plan.is_uniform_box()
    }

    fn check_options(&self, plan: &CasePlan) -> Result<(), BadOption> {
        let options: SnapshotOptions = measure::options(plan, self.name())?;
        if let Some(interval) = options.interval {
            let alone = options.times.is_none();
            measure::require(alone, "interval", "either times or an interval, not both")?;
            let most = plan.case.run.until / interval <= MOST;
            let allowed =
                format!("an interval that gives at most {MOST} snapshots until the end of the run");
            measure::require(interval > 0.0 && most, "interval", allowed)?;
        }
        check_engines(plan, options.engines.as_deref())?;
        options.replicas.check_replicas(plan)?;
        if let Some(formats) = &options.formats {
            let allowed = "a gas with positions; snapshots of one without are CSV";
            measure::require(plan.has_box(), "formats", allowed)?;
            let twice = |at: usize| formats[..at].contains(&formats[at]);
            let once = !formats.is_empty() && !(0..formats.len()).any(twice);
            let allowed = "one or more of \"xyz\", \"lammps\", \"gsd\" and \"h5md\", each once";
            measure::require(once, "formats", allowed)?;
        }
        let none = options.quantities.is_some_and(|all| all.is_empty());
        let told = !none || plan.has_box();
        let allowed = "one or more of a gas without positions";
        measure::require(told, "quantities", allowed)
    }

    fn sample_times(&self, plan: &CasePlan) -> Vec<f64> {
        let options = measure::chosen::<SnapshotOptions>(plan, self.name());
        let until = plan.case.run.until;
        match (options.times, options.interval) {
            (Some(times), _) => times,
            (None, Some(interval)) => {
                // What is a whole number of intervals but for rounding is one.
                let last = (until / interval * (1.0 + 1e-12)) as u64;
                let at = |number| (number as f64 * interval).min(until);
                (0..=last).map(at).collect()
            }
            (None, None) => vec![until],
        }
    }

    fn kept_per_particle(&self, plan: &CasePlan) -> f64 {
        let options = measure::chosen::<SnapshotOptions>(plan, self.name());
        LINE * (self.sample_times(plan).len() * options.formats().len()) as f64
    }

    fn gathers_particles(&self, plan: &CasePlan) -> bool {
        !self.sample_times(plan).is_empty()
    }

    fn kept_last_per_particle(&self, plan: &CasePlan) -> f64 {
        if self.sample_times(plan).is_empty() {
            0.0
        } else {
            let options = measure::chosen::<SnapshotOptions>(plan, self.name());
            LINE * options.formats().len() as f64
        }
    }

    fn looks_at(&self, plan: &CasePlan, replica: u64) -> bool {
        let options = measure::chosen::<SnapshotOptions>(plan, self.name());
        options.replicas.has(replica)
    }

    fn new_probe(&self, plan: &CasePlan, engine: &EnginePlan) -> Box<dyn Probe> {
        let (name, units) = (engine.name, SnapshotUnits::new(plan));
        let placed = plan.has_box();
        let options = measure::chosen::<SnapshotOptions>(plan, self.name());
        let is_asked = is_named(options.engines.as_deref(), name);
        Box::new(SampleProbe::new(Records::new(), move |records, moment| {
            if !is_asked {
                return;
            }
            let (all, asked) = (moment.particles(), options.quantities.as_deref());
            let files: Vec<Vec<u8>> = if placed {
                let content = Content {
                    index: records.len(),
                    ..Content::new(all, asked, units, name, moment.time)
                };
                let formats = options.formats().iter();
                formats.map(|&format| content.file(format)).collect()
            } else {
                vec![csv(all, asked, units.scale).into_bytes()]
            };
            records.push(SnapshotFiles {
                replica: moment.replica,
                files: files.into_iter().map(Into::into).collect(),
            });
        }))
    }

    fn snapshot_files(
        &self,
        plan: &CasePlan,
        runs: &ReplicaRecords<'_>,
    ) -> Vec<(Snapshot, Vec<u8>)> {
        let times = self.sample_times(plan);
        let endings = measure::chosen::<SnapshotOptions>(plan, self.name()).endings(plan);
        let mut files = Vec::new();
        for (engine, records) in runs.each::<Records>(plan) {
            let name = engine.name;
            for record in records {
                for (index, (taken, &time)) in record.iter().zip(&times).enumerate() {
                    let number = match taken.replica {
                        0 => format!("{index}"),
                        other => format!("{index}-replica-{other}"),
                    };
                    for (bytes, ending) in taken.files.iter().zip(&endings) {
                        let snapshot = Snapshot {
                            engine: name.to_owned(),
                            replica: taken.replica,
                            time,
                            file: format!("{SNAPSHOTS}/{name}-{number}.{ending}"),
                            blake3: String::new(),
                        };
                        files.push((snapshot, bytes.to_vec()));
                    }
                }
            }
        }
        files
    }
}
