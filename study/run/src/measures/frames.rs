//! Measure `frames`: positions of the particles of replica 0 at many times, for the player of the
//! report.

use serde::{Deserialize, Serialize};
use stosszahl_model::sum::Totals;
use stosszahl_model::{Collision, Observer, Particle, ParticleReduction, Simulation};
use stosszahl_results::frames::{Crowd, Dot, FRAMES, LastCollision, ParticleFrame, keeps};

use crate::measure::{
    self, BadOption, FrameFile, Measure, Probe, ReplicaRecords, SampleContext, described,
    keeps_record,
};
use crate::plan::{CasePlan, EnginePlan};

/// Measure `frames` of coarse particle positions for the player of the report.
pub struct FrameMeasure;

/// Largest number of particles in the last frame, which readers can enlarge.
const LAST: usize = 150_000;
/// Memory of one particle in a frame \[bytes\].
const BYTES: f64 = 8.0;

/// Options of `[measure.frames]`: number of frames, and of particles in each.
#[derive(Clone, Debug, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct FrameOptions {
    /// Number of frames, taken at times at which the run is sampled, the first and the last among
    /// them; 0 for none.
    #[schemars(range(max = 1000))]
    pub number: usize,
    /// Largest number of particles in a frame, a fair sample of all; the last frame has up to
    /// 150 000.
    #[schemars(range(min = 1, max = 150_000))]
    pub particles: usize,
}

impl Default for FrameOptions {
    fn default() -> Self {
        Self {
            number: 40,
            particles: 10_000,
        }
    }
}

/// Last collision of a particle: index of the partner, and impact parameter over the contact
/// distance.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct Last {
    partner: u32,
    impact: f32,
}

impl Last {
    /// Placeholder before the first collision of a particle.
    const NONE: Self = Self {
        partner: Collision::ANONYMOUS,
        impact: 0.0,
    };
}

/// Converts a particle to the input of a frame, without its last collision.
fn dot(particle: &Particle) -> Dot {
    Dot {
        position: [particle.position.x, particle.position.y],
        velocity: [particle.velocity.x, particle.velocity.y],
        radius: particle.radius,
        weight: particle.weight,
        met: None,
    }
}

/// Frames so far, and the last collision of each particle; without collisions if particles are not
/// tracked.
#[derive(Default, Serialize, Deserialize)]
struct Record {
    frames: Vec<ParticleFrame>,
    last: Vec<Last>,
}

impl Observer for Record {
    fn on_collisions(&mut self, batch: &[Collision]) {
        for collision in batch {
            let impact = collision.impact_square().sqrt() as f32;
            let [a, b] = collision.pair;
            for (who, partner) in [(a, b), (b, a)] {
                if let Some(last) = self.last.get_mut(who as usize) {
                    *last = Last { partner, impact };
                }
            }
        }
    }
}

impl Record {
    /// Selects the particles of a frame of disks that are visited in the order of their indices.
    /// Lengths and speeds are in engine units, as only their ratios matter.
    fn chosen(&self, gas: &dyn Simulation, most: usize) -> (Crowd, Vec<(u64, Dot)>) {
        let (mut crowd, mut sum) = (Crowd::default(), 0.0);
        let mut energies = Vec::with_capacity(gas.particle_count());
        gas.visit_particles(&mut |one| {
            crowd.add(one.weight, one.radius, one.velocity.xy().into());
            let energy = 0.5 * one.mass * one.velocity.norm_squared();
            sum += one.weight * energy;
            energies.push(energy);
        });
        let mean = (sum / crowd.particles).max(f64::MIN_POSITIVE);
        let met = |number: usize| {
            let last = self.last.get(number)?;
            Some(LastCollision {
                partner: energies.get(last.partner as usize)? / mean,
                impact: f64::from(last.impact),
            })
        };
        let share = crowd.kept_share(most);
        let (mut number, mut kept) = (0, Vec::new());
        gas.visit_particles(&mut |one| {
            if keeps(number as u64, one.weight, share) {
                let met = met(number);
                kept.push((number as u64, Dot { met, ..dot(one) }));
            }
            number += 1;
        });
        (crowd, kept)
    }
}

/// Probe that takes the particle frames of one engine and replica.
struct Camera {
    record: Record,
    /// Largest number of particles in all frames but the last.
    most: usize,
    /// Time of the last frame, the end of the run.
    until: f64,
    /// True if last collisions are recorded, because the engine tracks particles and their number
    /// is constant.
    follows: bool,
    sides: [f64; 2],
    periodic: [bool; 2],
}

/// Selects the particles of a frame of a gas without tracked particles. They are numbered by
/// groups, and only sampled ones are gathered.
fn chosen(gas: &dyn Simulation, most: usize) -> (Crowd, Vec<(u64, Dot)>) {
    let mut looks = FrameReduction {
        crowd: Crowd::default(),
        totals: Totals::new(2),
    };
    gas.reduce_particles(&mut looks);
    let sums = looks.totals.values();
    let crowd = Crowd {
        particles: sums[0],
        squares: sums[1],
        ..looks.crowd
    };
    let mut sample = ChosenParticles {
        share: crowd.kept_share(most),
        open: Vec::new(),
        seen: 0,
        kept: Vec::new(),
    };
    gas.reduce_particles(&mut sample);
    (crowd, sample.kept)
}

/// Reduction over all particles that samples the particles of a frame and sums their totals.
#[derive(Serialize, Deserialize)]
pub(super) struct FrameReduction {
    crowd: Crowd,
    /// Totals over all particles, such as sums of weights and of weighted squared speeds.
    totals: Totals,
}

impl ParticleReduction for FrameReduction {
    const NAME: &'static str = "crowd";

    fn add_particle(&mut self, particle: &Particle) {
        self.crowd.widen(particle.weight, particle.radius);
        let sums = self.totals.open();
        sums[0] += particle.weight;
        sums[1] += particle.weight * particle.velocity.xy().norm_squared();
    }

    fn close_group(&mut self, _group: u32) {
        self.totals.close();
    }

    fn merge_sum(&mut self, other: Self) {
        self.crowd.widen_by(&other.crowd);
        self.totals.merge(&other.totals);
    }
}

/// Reduction over all particles that collects the sampled particles of a frame, with their numbers.
#[derive(Serialize, Deserialize)]
pub(super) struct ChosenParticles {
    share: f64,
    kept: Vec<(u64, Dot)>,
    /// Particles of the current group that may be sampled, with their index in the group.
    #[serde(skip)]
    open: Vec<(u64, Dot)>,
    #[serde(skip)]
    seen: u64,
}

impl ParticleReduction for ChosenParticles {
    const NAME: &'static str = "frame";

    fn add_particle(&mut self, particle: &Particle) {
        self.open.push((self.seen, dot(particle)));
        self.seen += 1;
    }

    fn close_group(&mut self, group: u32) {
        self.seen = 0;
        let numbered = self.open.drain(..);
        let numbered = numbered.map(|(place, dot)| (u64::from(group) << 32 | place, dot));
        let share = self.share;
        let kept = numbered.filter(|(number, dot)| keeps(*number, dot.weight, share));
        self.kept.extend(kept);
    }

    fn merge_sum(&mut self, other: Self) {
        self.kept.extend(other.kept);
    }
}

impl Probe for Camera {
    fn collision_observer(&mut self) -> Option<&mut dyn Observer> {
        (!self.record.last.is_empty()).then_some(&mut self.record)
    }

    fn on_start(&mut self, moment: &mut SampleContext<'_>) {
        if self.follows {
            self.record.last = vec![Last::NONE; moment.simulation.particle_count()];
        }
    }

    fn on_sample(&mut self, moment: &mut SampleContext<'_>) {
        let is_last = moment.time >= self.until;
        let most = if is_last { LAST } else { self.most };
        let gas = &*moment.simulation;
        let (crowd, kept) = if self.follows {
            self.record.chosen(gas, most)
        } else {
            chosen(gas, most)
        };
        let (time, share) = (moment.time, crowd.kept_share(most));
        let frame =
            ParticleFrame::of_particles(time, self.sides, self.periodic, &crowd, share, kept);
        self.record.frames.push(frame);
    }

    keeps_record!();
}

impl Measure for FrameMeasure {
    described!(
        "frames",
        "Positions and velocities of the first replica at many times, coarse, for the player of the report.",
        FrameOptions
    );

    fn knows_shear(&self) -> bool {
        true
    }

    fn by_default(&self, plan: &CasePlan) -> bool {
        plan.has_box() && plan.gas.dimension == 2
    }

    fn check_options(&self, plan: &CasePlan) -> Result<(), BadOption> {
        let options: FrameOptions = measure::options(plan, self.name())?;
        let planar = plan.has_box() && plan.gas.dimension == 2;
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

    fn sample_times(&self, plan: &CasePlan) -> Vec<f64> {
        let number = measure::chosen::<FrameOptions>(plan, self.name()).number;
        // Where others look: Monte Carlo that stops more often has other digits.
        let all = plan.sample_times();
        let place = |frame: usize| frame * (all.len() - 1) / (number - 1).max(1);
        match number {
            0 => Vec::new(),
            1 => all.last().copied().into_iter().collect(),
            number if all.len() <= number => all,
            number => (0..number).map(|frame| all[place(frame)]).collect(),
        }
    }

    fn kept_per_particle(&self, plan: &CasePlan) -> f64 {
        // A frame shows at most this number of simulators, the last frame more.
        let most = measure::chosen::<FrameOptions>(plan, self.name()).particles;
        let copies = plan.engines.iter().map(EnginePlan::copies).min();
        let simulators = (plan.count() * copies.unwrap_or(1)).max(1) as f64;
        let share = |shown: usize| (shown as f64 / simulators).min(1.0);
        let frames = self.sample_times(plan).len() as f64;
        // Beside the frames, the last collision of each.
        BYTES * (share(most) * frames).max(share(LAST) * frames.min(1.0))
            + size_of::<Last>() as f64 * frames.min(1.0)
    }

    fn looks_at(&self, _plan: &CasePlan, replica: u64) -> bool {
        replica == 0
    }

    fn new_probe(&self, plan: &CasePlan, engine: &EnginePlan) -> Box<dyn Probe> {
        Box::new(Camera {
            record: Record::default(),
            most: measure::chosen::<FrameOptions>(plan, self.name()).particles,
            until: plan.case.run.until,
            follows: engine.is_exact() && !self.sample_times(plan).is_empty(),
            sides: [plan.gas.lengths[0], plan.gas.lengths[1]],
            periodic: plan.periodic(),
        })
    }

    fn player_frames(&self, plan: &CasePlan, runs: &ReplicaRecords<'_>) -> Vec<FrameFile> {
        let engines = runs.each::<Record>(plan);
        let files = engines.filter_map(|(engine, records)| {
            let record = records.first().filter(|one| !one.frames.is_empty())?;
            Some(FrameFile {
                engine: engine.name.to_owned(),
                file: format!("{FRAMES}/{}.bin", engine.name),
                frames: record.frames.clone(),
            })
        });
        files.collect()
    }
}
