//! Positions of the first replica at many times, for the player of the report.

use serde::Deserialize;
use stosszahl_case::Kind;
use stosszahl_model::Particles;
use stosszahl_results::frames::{Dot, FRAMES, Frame};

use crate::measure::{self, BadOption, FrameFile, Measure, Probe, Recorder, Runs, described};
use crate::plan::{EnginePlan, Plan};

/// Frames.
pub struct Frames;

/// Particles of the last frame, which is looked at closely.
const LAST: usize = 150_000;
/// Bytes of a particle in a frame.
const BYTES: f64 = 7.0;

/// How many, and of how many particles.
#[derive(Clone, Debug, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Options {
    /// Frames, taken at times at which the run is sampled, the first and the last among them; 0 for none.
    #[schemars(range(max = 1000))]
    pub number: usize,
    /// Particles in each frame at most, a fair sample of all; the last frame has up to 150 000.
    #[schemars(range(min = 1, max = 150_000))]
    pub particles: usize,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            number: 40,
            particles: 10_000,
        }
    }
}

/// A frame of some particles at a time of the case; lengths and speeds are those of the engine, as only their ratios matter.
fn frame(particles: &Particles, time: f64, most: usize) -> Frame {
    let dots: Vec<Dot> = (particles.all.iter())
        .map(|one| Dot {
            position: [one.position[0], one.position[1]],
            velocity: [one.velocity[0], one.velocity[1]],
            radius: one.radius,
            weight: one.weight,
        })
        .collect();
    let sides = [particles.lengths[0], particles.lengths[1]];
    let periodic = [particles.periodic[0], particles.periodic[1]];
    Frame::new(time, sides, periodic, &dots, most)
}

impl Measure for Frames {
    described!(
        "frames",
        "Positions and velocities of the first replica at many times, coarse, for the player of the report.",
        Options
    );

    fn by_default(&self, plan: &Plan) -> bool {
        plan.kind != Kind::Homogeneous && plan.case.gas.dimension == 2
    }

    fn check(&self, plan: &Plan) -> Result<(), BadOption> {
        let options: Options = measure::options(plan, self.name())?;
        let planar = plan.kind != Kind::Homogeneous && plan.case.gas.dimension == 2;
        measure::require(planar, "", "a gas with positions, in a box in the plane")?;
        measure::require(
            options.number <= 1000,
            "number",
            "a number of frames up to 1000",
        )?;
        let good = (1..=LAST).contains(&options.particles);
        measure::require(
            good,
            "particles",
            format!("a number of particles from 1 to {LAST}"),
        )
    }

    fn times(&self, plan: &Plan) -> Vec<f64> {
        let number = measure::chosen::<Options>(plan, self.name()).number;
        // Where others look: an engine that stops more often has other digits.
        let all = plan.sample_times();
        let place = |frame: usize| frame * (all.len() - 1) / (number - 1).max(1);
        match number {
            0 => Vec::new(),
            1 => all.last().copied().into_iter().collect(),
            number if all.len() <= number => all,
            number => (0..number).map(|frame| all[place(frame)]).collect(),
        }
    }

    fn kept_per_particle(&self, plan: &Plan) -> f64 {
        // A frame shows a sample of so many at the most, and the last one may show all.
        let most = measure::chosen::<Options>(plan, self.name()).particles;
        let share = (most as f64 / plan.count().max(1) as f64).min(1.0);
        let frames = self.times(plan).len() as f64;
        BYTES * (share * frames).max(frames.min(1.0))
    }

    fn looks_at(&self, _plan: &Plan, replica: u64) -> bool {
        replica == 0
    }

    fn probe(&self, plan: &Plan, _engine: &EnginePlan) -> Box<dyn Probe> {
        let most = measure::chosen::<Options>(plan, self.name()).particles;
        let until = plan.case.run.until;
        Box::new(Recorder::new(Vec::<Frame>::new(), move |frames, moment| {
            let most = if moment.time < until { most } else { LAST };
            frames.push(frame(moment.particles(), moment.time, most));
        }))
    }

    fn frames(&self, plan: &Plan, runs: &Runs<'_>) -> Vec<FrameFile> {
        let engines = runs.each::<Vec<Frame>>(plan);
        let files = engines.filter_map(|(engine, records)| {
            let frames = records.first().filter(|frames| !frames.is_empty())?;
            Some(FrameFile {
                engine: engine.name.to_owned(),
                file: format!("{FRAMES}/{}.bin", engine.name),
                frames: (*frames).clone(),
            })
        });
        files.collect()
    }
}
