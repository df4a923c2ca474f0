//! All particles of the first replica at chosen times, as extended XYZ in the units of the case: what OVITO and ASE read.

use std::fmt::Write as _;

use serde::Deserialize;
use stosszahl_case::Kind;
use stosszahl_model::Particles;
use stosszahl_results::{SNAPSHOTS, Snapshot};

use crate::measure::{self, BadOption, Measure, Probe, Recorder, Runs, described};
use crate::plan::{EnginePlan, Plan, Scale};

/// Length of a line, about: four numbers of all their digits in the plane.
const LINE: f64 = 100.0;

/// Snapshots.
pub struct Snapshots;

/// Most snapshots of one engine that an interval may ask for.
const MOST: f64 = 10_000.0;

/// When, and of which engines.
#[derive(Clone, Debug, Default, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Options {
    /// Times. Default: the end of the run.
    pub times: Option<Vec<f64>>,
    /// Time between two, from the start on, in place of `times`.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub interval: Option<f64>,
    /// Names of engines. Default: all.
    pub engines: Option<Vec<String>>,
}

/// The snapshots taken.
type Texts = Vec<String>;

/// The extended XYZ format in units of which one engine unit is `scale`; `time` is in the unit of time of the case.
pub fn extended_xyz(particles: &Particles, scale: Scale, engine: &str, time: f64) -> String {
    let (length, speed) = (scale.length, scale.speed());
    let [x, y, z] = particles.lengths.map(|side| side * length);
    let depth = if particles.dimension == 2 { 1.0 } else { z };
    let spins = particles
        .all
        .iter()
        .any(|one| one.spin.norm_squared() > 0.0);
    let kinds = particles.all.iter().any(|one| one.species > 0);
    let periodic = [0, 1, 2].map(|axis| {
        let is_periodic = axis < particles.dimension && particles.periodic[axis];
        if is_periodic { "T" } else { "F" }
    });
    let mut text = String::with_capacity(100 * particles.all.len());
    // Writing to a string cannot fail.
    let _ = writeln!(text, "{}", particles.all.len());
    let _ = writeln!(
        text,
        "Lattice=\"{x} 0 0 0 {y} 0 0 0 {depth}\" Properties=id:I:1:pos:R:3:velo:R:3:radius:R:1:mass:R:1{}{} pbc=\"{}\" Time={} TimeOverT0={time} Engine={engine}",
        if spins { ":angular_velocity:R:3" } else { "" },
        if kinds { ":type:I:1" } else { "" },
        periodic.join(" "),
        particles.time * scale.time(),
    );
    for (index, one) in particles.all.iter().enumerate() {
        let (at, v) = (one.position * length, one.velocity * speed);
        let (radius, mass) = (one.radius * length, one.mass * scale.mass);
        let _ = write!(
            text,
            "{index} {} {} {} {} {} {} {radius} {mass}",
            at[0], at[1], at[2], v[0], v[1], v[2]
        );
        if spins {
            let w = one.spin / scale.time();
            let _ = write!(text, " {} {} {}", w[0], w[1], w[2]);
        }
        if kinds {
            let _ = write!(text, " {}", one.species);
        }
        text.push('\n');
    }
    text
}

impl Measure for Snapshots {
    described!(
        "snapshots",
        "All particles of the first replica at chosen times, as extended XYZ.",
        Options
    );

    fn by_default(&self, plan: &Plan) -> bool {
        plan.kind == Kind::Comparison
    }

    fn check(&self, plan: &Plan) -> Result<(), BadOption> {
        let placed = plan.kind != Kind::Homogeneous;
        measure::require(placed, "", "a gas with positions, in a box")?;
        let options: Options = measure::options(plan, self.name())?;
        if let Some(interval) = options.interval {
            let alone = options.times.is_none();
            measure::require(alone, "interval", "either times or an interval, not both")?;
            let most = plan.case.run.until / interval <= MOST;
            let allowed =
                format!("an interval that gives at most {MOST} snapshots until the end of the run");
            measure::require(interval > 0.0 && most, "interval", allowed)?;
        }
        for (index, name) in options.engines.iter().flatten().enumerate() {
            let names: Vec<&str> = plan.engines.iter().map(|engine| engine.name).collect();
            let allowed = format!("engines of the case, {}", names.join(", "));
            measure::require(
                names.contains(&&**name),
                &format!("engines[{index}]"),
                allowed,
            )?;
        }
        measure::require_times(plan, "times", options.times.as_deref().unwrap_or_default())
    }

    fn times(&self, plan: &Plan) -> Vec<f64> {
        let options = measure::chosen::<Options>(plan, self.name());
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

    fn kept_per_particle(&self, plan: &Plan) -> f64 {
        LINE * self.times(plan).len() as f64
    }

    fn only_first_replica(&self) -> bool {
        true
    }

    fn probe(&self, plan: &Plan, engine: &EnginePlan) -> Box<dyn Probe> {
        let (name, scale) = (engine.name, plan.scale);
        let engines = measure::chosen::<Options>(plan, self.name()).engines;
        let is_asked = engines.is_none_or(|names| names.iter().any(|one| one == name));
        Box::new(Recorder::new(Texts::new(), move |texts, moment| {
            if is_asked {
                texts.push(extended_xyz(moment.particles(), scale, name, moment.time));
            }
        }))
    }

    fn snapshots(&self, plan: &Plan, runs: &Runs<'_>) -> Vec<(Snapshot, String)> {
        let times = self.times(plan);
        let mut files = Vec::new();
        for (engine, records) in runs.each::<Texts>(plan) {
            let texts = records.into_iter().take(1).flatten();
            for (index, (text, &time)) in texts.zip(&times).enumerate() {
                let snapshot = Snapshot {
                    engine: engine.name.to_owned(),
                    time,
                    file: format!("{SNAPSHOTS}/{}-{index}.xyz", engine.name),
                    blake3: String::new(),
                };
                files.push((snapshot, text.clone()));
            }
        }
        files
    }
}
