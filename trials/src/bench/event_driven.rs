//! Speed of the event-driven engine: collisions of hard disks per second after an elastic
//! equilibration (`stosszahl-trials bench ed`).

use clap::{Args, ValueEnum};
use stosszahl_ed::{DissipationRule, EventDrivenCheckpoint, EventDrivenEngine, StripedEngine};
use stosszahl_model::equation_of_state;
use stosszahl_model::initial::Arrangement;
use stosszahl_model::samples::{EqualDisks, state};
use stosszahl_model::{InvalidValue, ParticleModel, Plane, Scene, Shear, Sheared, State};
use stosszahl_theory::cooling;

use super::{BenchWork, Speed, timed};
use crate::TrialError;
use crate::gas::{disks, fluid, relaxed};

/// Options of `stosszahl-trials bench ed`, the benchmark of event-driven disks.
#[derive(Clone, Debug, Args)]
pub struct BenchEd {
    /// Number of hard disks in the benchmark.
    #[arg(long, value_name = "N", default_value_t = 10_000, value_parser = clap::value_parser!(u32).range(2..))]
    pub disks: u32,
    /// Packing fraction of the benchmark's disks.
    #[arg(long, value_name = "P", default_value_t = 0.25)]
    pub packing_fraction: f64,
    /// Coefficient of restitution of the disks while timing.
    #[arg(long, value_name = "R", default_value_t = 1.0)]
    pub restitution: f64,
    /// Arrangement of the benchmark's disks before equilibration.
    #[arg(long, value_enum, default_value_t = BenchStart::Disordered)]
    pub start: BenchStart,
    /// Elastic collisions per disk before timing.
    #[arg(long, value_name = "C", default_value_t = 10.0)]
    pub equilibrate: f64,
    /// Pair collisions to time [default: 5 for each disk, at least a million].
    #[arg(long, value_name = "M")]
    pub collisions: Option<u64>,
    /// Number of threads, each with a strip of the box.
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..))]
    pub threads: u16,
    /// End of the timing instead of a number of collisions, in units of t0 (Haff's time; mean free
    /// times of an elastic gas).
    #[arg(long, value_name = "T")]
    pub until: Option<f64>,
    /// Shear rate of a uniform shear flow, in units of the diameter, the mass and the temperature
    /// of the start.
    #[arg(long, value_name = "A", allow_negative_numbers = true)]
    pub shear_rate: Option<f64>,
    /// Print the measured speed as one JSON object.
    #[arg(long)]
    pub json: bool,
}

/// Arrangement of the benchmark's disks before equilibration.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum BenchStart {
    /// Start from random sequential addition; above packing 0.45, from a molten lattice.
    Disordered,
    /// Start from a hexagonal lattice of disks.
    Hexagonal,
}

impl BenchEd {
    /// Creates the benchmark's disks and equilibrates them by elastic collisions.
    fn start(&self) -> Result<State<EqualDisks>, TrialError> {
        let (packing, each) = (self.packing_fraction, self.equilibrate);
        let good = packing > 0.0 && packing <= equation_of_state::CLOSE_PACKING;
        InvalidValue::require(
            good,
            "--packing-fraction",
            packing,
            "above 0 and at most 0.9069",
        )?;
        InvalidValue::require(
            (0.0..1e9).contains(&each),
            "--equilibrate",
            each,
            "0 or more",
        )?;
        let count = self.disks as usize;
        // The box of a hexagonal crystal of about as many disks in equal columns and rows, so that
        // it fits up to close packing; square otherwise.
        let (arrangement, aspect) = match self.start {
            BenchStart::Disordered => (Arrangement::Disordered, 1.0),
            BenchStart::Hexagonal => {
                let rows = 2.0 * ((count as f64).sqrt() / 2.0).round().max(1.0);
                let columns = (count as f64 / rows).ceil();
                (Arrangement::Hexagonal, 0.75_f64.sqrt() * rows / columns)
            }
        };
        let start = fluid(arrangement, count, packing, aspect, 1)?;
        relaxed(start, each)
    }
}

impl BenchWork for BenchEd {
    /// Measures the collisions per second of event-driven disks, up to a number of collisions or a
    /// time in units of `t_0`. Engine set-up is included.
    fn measure_speed(&self) -> Result<Speed, TrialError> {
        let (scene, start) = (disks(self.restitution)?, self.start()?);
        let Some(rate) = self.shear_rate else {
            return self.time(scene, start);
        };
        let domain = start.domain.sheared(Some(Shear::new(rate)?))?;
        let bodies = start.bodies.iter();
        let sheared = state(domain, bodies.map(|body| (body.position, body.velocity)));
        let field = Sheared::new(rate)?;
        let scene = Scene::new(scene.surface, scene.restitution, scene.sizes, field);
        self.time(scene, sheared)
    }
}

impl BenchEd {
    /// Times the event-driven collisions of one particle model from a given start.
    fn time<P: ParticleModel<Space = Plane>>(
        &self,
        scene: P,
        start: State<P>,
    ) -> Result<Speed, TrialError> {
        let (restitution, packing) = (self.restitution, self.packing_fraction);
        let start = EventDrivenCheckpoint::from(start);
        let threads = usize::from(self.threads);
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()?;
        let all = if self.until.is_some() {
            u64::MAX / 2
        } else {
            (5 * u64::from(self.disks)).max(1_000_000)
        };
        let collisions = self.collisions.unwrap_or(all);
        let chi =
            equation_of_state::contact_value(packing.min(0.999 * equation_of_state::CLOSE_PACKING));
        let unit = if restitution < 1.0 {
            cooling::haff_time(packing, restitution, chi)
        } else {
            1.0 / equation_of_state::collision_rate(packing, chi, 0.0)
        };
        let until = self.until.map_or(f64::INFINITY, |time| time * unit);
        let (engine, seconds, cpu) = timed(|| -> Result<_, TrialError> {
            let engine = EventDrivenEngine::<P>::new(scene, DissipationRule::Scene, start)?;
            let mut engine = StripedEngine::new(engine, threads);
            pool.install(|| engine.advance(until, collisions, &mut ()))?;
            Ok(engine)
        });
        let engine = engine?;
        let (spread, bytes) = (engine.settings(), engine.memory_bytes());
        let (tally, stale) = (engine.engine().tally(), engine.engine().stale());
        let done = tally.collisions;
        let per_event = 1.0 / spread.events.max(1) as f64;
        let each = |count: u64| count as f64 / done.max(1) as f64;
        Ok(Speed::default()
            .with("disks", self.disks)
            .with("packing_fraction", packing)
            .with("restitution", restitution)
            .with("collisions", done)
            .with("seconds", seconds)
            .with("collisions_per_second", done as f64 / seconds)
            .with("collisions_per_cpu_second", done as f64 / cpu)
            .with("bytes_per_disk", bytes as f64 / f64::from(self.disks))
            .with("predictions_per_collision", each(tally.predictions))
            .with("pushes_per_collision", each(tally.pushes))
            .with("crossings_per_collision", each(tally.crossings))
            .with("stale_per_collision", each(stale))
            .with("broken_per_collision", each(tally.broken))
            .with("threads", self.threads)
            .with("windows", spread.windows)
            .with("windows_done_again", spread.retries)
            .with("events_done_twice", spread.twice as f64 * per_event)
            .with("events_lost", spread.lost as f64 * per_event))
    }
}
