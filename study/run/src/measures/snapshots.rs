//! All particles of chosen replicas at chosen times, in the units of the case: as extended XYZ, which OVITO and ASE read, and as CSV of
//! gases without positions.

use std::fmt::Write as _;

use serde::Deserialize;
use stosszahl_model::{Particle, Particles};
use stosszahl_results::{SNAPSHOTS, Snapshot};

use super::selection::{Replicas, check_engines, is_named};
use crate::measure::{self, BadOption, Measure, Probe, ReplicaRecords, SampleProbe, described};
use crate::plan::{CasePlan, EnginePlan, UnitScale};

/// Length of a line, about: four numbers of all their digits in the plane.
const LINE: f64 = 100.0;

/// Measure that writes all particles at chosen times.
pub struct SnapshotMeasure;

/// Most snapshots of one engine that an interval may ask for.
const MOST: f64 = 10_000.0;

/// Options: times, engines, replicas and quantities.
#[derive(Clone, Debug, Default, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct SnapshotOptions {
    /// Times. Default: the end of the run.
    pub times: Option<Vec<f64>>,
    /// Time between two, from the start on, in place of `times`.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub interval: Option<f64>,
    /// Names of engines. Default: all.
    pub engines: Option<Vec<String>>,
    /// Numbers of replicas, from 0, or "all". Default: \[0\].
    pub replicas: Replicas,
    /// Quantity that is written next to positions. Default: `velocity`, `radius` and `mass`, and the others where particles differ in them.
    pub quantities: Option<Vec<ParticleQuantity>>,
}

/// A quantity of each particle.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ParticleQuantity {
    /// Velocity \[length/time\].
    Velocity,
    /// Radius \[length\].
    Radius,
    /// Mass.
    Mass,
    /// Angular velocity \[1/time\].
    AngularVelocity,
    /// Number of the species, from 0.
    Species,
    /// Number of particles that it stands for.
    Weight,
}

impl ParticleQuantity {
    const ALL: [Self; 6] = [
        Self::Velocity,
        Self::Radius,
        Self::Mass,
        Self::AngularVelocity,
        Self::Species,
        Self::Weight,
    ];

    /// Its name in CSV, and the property of extended XYZ: its name, type and width.
    fn described(self) -> (&'static str, &'static str) {
        match self {
            Self::Velocity => ("velocity", "velo:R:3"),
            Self::Radius => ("radius", "radius:R:1"),
            Self::Mass => ("mass", "mass:R:1"),
            Self::AngularVelocity => ("angular_velocity", "angular_velocity:R:3"),
            // "species" would be names of elements to OVITO and ASE.
            Self::Species => ("species", "type:I:1"),
            Self::Weight => ("weight", "weight:R:1"),
        }
    }

    /// Whether it says more than that all particles are alike.
    fn tells(self, particles: &Particles) -> bool {
        let mut all = particles.all.iter();
        match self {
            Self::Velocity | Self::Radius | Self::Mass => true,
            Self::AngularVelocity => all.any(|one| one.spin.norm_squared() > 0.0),
            Self::Species => all.any(|one| one.species > 0),
            Self::Weight => all.any(|one| one.weight != particles.all[0].weight),
        }
    }

    /// Its numbers in units of which one engine unit is `scale`, each after `mark`.
    fn write(self, text: &mut String, mark: char, one: &Particle, scale: UnitScale) {
        let vector = |text: &mut String, all: nalgebra::Vector3<f64>| {
            for number in &all {
                let _ = write!(text, "{mark}{number}");
            }
        };
        // Writing to a string cannot fail.
        let _ = match self {
            Self::Velocity => return vector(text, one.velocity * scale.speed()),
            Self::AngularVelocity => return vector(text, one.spin / scale.time()),
            Self::Radius => write!(text, "{mark}{}", one.radius * scale.length),
            Self::Mass => write!(text, "{mark}{}", one.mass * scale.mass),
            Self::Species => write!(text, "{mark}{}", one.species),
            Self::Weight => write!(text, "{mark}{}", one.weight),
        };
    }
}

/// Returns the quantities to write: those asked for, or those in which particles differ.
fn written(asked: Option<&[ParticleQuantity]>, particles: &Particles) -> Vec<ParticleQuantity> {
    let all = ParticleQuantity::ALL.into_iter();
    match asked {
        Some(asked) => all.filter(|one| asked.contains(one)).collect(),
        None => all.filter(|one| one.tells(particles)).collect(),
    }
}

/// The snapshots taken, each with the number of its replica.
type Texts = Vec<(u64, String)>;

/// Units of a snapshot file.
#[derive(Clone, Copy)]
struct SnapshotUnits {
    scale: UnitScale,
    /// Unit of time of the case over Haff's time t0; none of a gas that does not cool.
    time_over_t0: Option<f64>,
    /// Third side of the box of disks: a mean diameter \[length of the case\], or 1 of points.
    depth: f64,
    /// Shear rate of the flow \[1/engine time\]; 0 without a flow.
    shear_rate: f64,
}

impl SnapshotUnits {
    fn new(plan: &CasePlan) -> Self {
        let depth = 2.0 * plan.mean_radius() * plan.scale.length;
        Self {
            scale: plan.scale,
            time_over_t0: plan.cooling_time().map(|t0| plan.time / t0),
            depth: if depth > 0.0 { depth } else { 1.0 },
            shear_rate: plan.grains.shear_rate.unwrap_or(0.0),
        }
    }
}

/// Writes all quantities in the extended XYZ format, in the units of the case of a plan.
pub fn extended_xyz(particles: &Particles, plan: &CasePlan, engine: &str) -> String {
    let time = particles.time / plan.time;
    xyz(particles, None, SnapshotUnits::new(plan), engine, time)
}

fn xyz(
    particles: &Particles,
    asked: Option<&[ParticleQuantity]>,
    units: SnapshotUnits,
    engine: &str,
    time: f64,
) -> String {
    let scale = units.scale;
    let [x, y, z] = particles.lengths.map(|side| side * scale.length);
    // The second vector of the lattice leads to the image above, which slides in a shear flow.
    let slid = particles.shear_offset(units.shear_rate) * scale.length;
    let depth = if particles.dimension == 2 {
        units.depth
    } else {
        z
    };
    let over_t0 = units.time_over_t0.map(|unit| time * unit);
    let over_t0 = over_t0.map_or_else(String::new, |time| format!(" TimeOverT0={time}"));
    let periodic = [0, 1, 2].map(|axis| {
        let is_periodic = axis < particles.dimension && particles.periodic[axis];
        if is_periodic { "T" } else { "F" }
    });
    let quantities = written(asked, particles);
    let mut text = String::with_capacity(LINE as usize * particles.all.len());
    let mut properties = String::from("id:I:1:pos:R:3");
    for one in &quantities {
        let _ = write!(properties, ":{}", one.described().1);
    }
    let _ = writeln!(text, "{}", particles.all.len());
    let _ = writeln!(
        text,
        "Lattice=\"{x} 0 0 {slid} {y} 0 0 0 {depth}\" Properties={properties} pbc=\"{}\" Time={}{over_t0} Engine={engine}",
        periodic.join(" "),
        particles.time * scale.time(),
    );
    for (index, one) in particles.all.iter().enumerate() {
        let at = one.position * scale.length;
        let _ = write!(text, "{index} {} {} {}", at[0], at[1], at[2]);
        for quantity in &quantities {
            quantity.write(&mut text, ' ', one, scale);
        }
        text.push('\n');
    }
    text
}

/// A gas without positions: a column for each number.
fn csv(particles: &Particles, asked: Option<&[ParticleQuantity]>, scale: UnitScale) -> String {
    let quantities = written(asked, particles);
    let mut text = String::with_capacity(LINE as usize * particles.all.len());
    text.push_str("id");
    for one in &quantities {
        let (name, property) = one.described();
        let _ = if property.ends_with(":3") {
            write!(text, ",{name}_x,{name}_y,{name}_z")
        } else {
            write!(text, ",{name}")
        };
    }
    text.push('\n');
    for (index, one) in particles.all.iter().enumerate() {
        let _ = write!(text, "{index}");
        for quantity in &quantities {
            quantity.write(&mut text, ',', one, scale);
        }
        text.push('\n');
    }
    text
}

impl Measure for SnapshotMeasure {
    described!(
        "snapshots",
        "All particles at chosen times, as extended XYZ; velocities of gases without positions, as CSV.",
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
        LINE * self.sample_times(plan).len() as f64
    }

    fn gathers_particles(&self, plan: &CasePlan) -> bool {
        !self.sample_times(plan).is_empty()
    }

    fn kept_last_per_particle(&self, plan: &CasePlan) -> f64 {
        if self.sample_times(plan).is_empty() {
            0.0
        } else {
            LINE
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
        let quantities = options.quantities;
        Box::new(SampleProbe::new(Texts::new(), move |texts, moment| {
            if is_asked {
                let (all, asked) = (moment.particles(), quantities.as_deref());
                let text = if placed {
                    xyz(all, asked, units, name, moment.time)
                } else {
                    csv(all, asked, units.scale)
                };
                texts.push((moment.replica, text));
            }
        }))
    }

    fn snapshot_files(
        &self,
        plan: &CasePlan,
        runs: &ReplicaRecords<'_>,
    ) -> Vec<(Snapshot, String)> {
        let times = self.sample_times(plan);
        let ending = if plan.has_box() { "xyz" } else { "csv" };
        let mut files = Vec::new();
        for (engine, records) in runs.each::<Texts>(plan) {
            let name = engine.name;
            for record in records {
                for (index, ((replica, text), &time)) in record.iter().zip(&times).enumerate() {
                    let number = match replica {
                        0 => format!("{index}"),
                        other => format!("{index}-replica-{other}"),
                    };
                    let snapshot = Snapshot {
                        engine: name.to_owned(),
                        replica: *replica,
                        time,
                        file: format!("{SNAPSHOTS}/{name}-{number}.{ending}"),
                        blake3: String::new(),
                    };
                    files.push((snapshot, text.clone()));
                }
            }
        }
        files
    }
}
