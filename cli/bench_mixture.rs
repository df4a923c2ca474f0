//! `stosszahl bench mixture`: a highly polydisperse cooling gas of spheres, the case of Table I of Bodrova & Osinsky (2024).

use std::time::Instant;

use clap::{Args, ValueEnum};
use serde::Serialize;
use stosszahl_dsmc::homogeneous::{
    Bird, Bounce, Contact, Engine, Gas, GasError, LowRank, Selection, Slots,
};
use stosszahl_model::random::{Purpose, Streams};
use stosszahl_model::{Constant, Free, Kind, Scene, Smooth, Species, Volume};

/// `stosszahl bench mixture`.
#[derive(Clone, Debug, Args)]
pub struct BenchMixture {
    /// How pairs are selected.
    #[arg(long, value_enum, default_value_t = Pick::Own)]
    pub selection: Pick,
    /// Number of monomers; there are k^-3 times as many spheres of mass k.
    #[arg(long, value_name = "N", default_value_t = 1_000_000, value_parser = clap::value_parser!(u32).range(1..=1_000_000_000))]
    pub monomers: u32,
    /// How numbers that are not whole become so: down (100 sizes for a million monomers) or to the nearest (125 sizes).
    #[arg(long, value_enum, default_value_t = Counts::Down)]
    pub counts: Counts,
    /// Coefficient of restitution.
    #[arg(long, value_name = "R", default_value_t = 0.5)]
    pub restitution: f64,
    /// Pair collisions to time [default: until the time].
    #[arg(long, value_name = "M")]
    pub collisions: Option<u64>,
    /// Time to reach, in units of the monomers' diameter over thermal speed.
    #[arg(long, value_name = "T", default_value_t = 100.0)]
    pub until: f64,
    /// Seed of the start and of the run.
    #[arg(long, value_name = "S", default_value_t = 1)]
    pub seed: u64,
    /// Print one JSON object.
    #[arg(long)]
    pub json: bool,
}

/// How pairs are selected.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Pick {
    /// Bird's single majorant.
    Bird,
    /// Products of the weights of size classes, found in trees.
    LowRank,
    /// Groups of like speed and size in alias tables.
    Own,
}

/// How numbers of particles become whole.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Counts {
    /// Down.
    Down,
    /// To the nearest.
    Nearest,
}

/// What was measured.
#[derive(Clone, Debug, Serialize)]
pub struct Speed {
    /// Name of the selection.
    pub selection: &'static str,
    /// Number of particles.
    pub particles: usize,
    /// Number of sizes.
    pub sizes: usize,
    /// Wall time \[s\], from the first to the last collision, fitting of bounds included.
    pub seconds: f64,
    /// Pair collisions.
    pub collisions: u64,
    /// Pairs that were looked at, for each collision.
    pub trials_per_collision: f64,
    /// Proposals, those of empty places included, for each collision.
    pub proposals_per_collision: f64,
    /// Times that all bounds were fitted.
    pub rebuilds: u64,
    /// Time that was reached.
    pub time: f64,
    /// (1/2) sum m v^2 at the end.
    pub final_energy: f64,
    /// Memory of particles and selection, for each particle.
    pub bytes_per_particle: f64,
}

type Spheres = Scene<Volume, Smooth, Constant, Species, Free>;

/// Makes the gas and times it.
///
/// # Errors
/// [`GasError`] if a number is out of range.
pub fn measure(work: &BenchMixture) -> Result<Speed, GasError> {
    match work.selection {
        Pick::Bird => timed::<Bird>(work),
        Pick::LowRank => timed::<LowRank>(work),
        Pick::Own => timed::<Slots>(work),
    }
}

fn timed<S: Selection<Spheres>>(work: &BenchMixture) -> Result<Speed, GasError> {
    let refuse = |name, value, allowed| GasError::BadNumber {
        name,
        value,
        allowed,
    };
    let law = Constant::new(work.restitution)
        .ok_or_else(|| refuse("--restitution", work.restitution, "from 0 to 1"))?;
    let monomers = f64::from(work.monomers);
    let kinds: Vec<Kind> = (1_u32..=2000)
        .map(|k| {
            let mass = f64::from(k);
            let share = monomers / (mass * mass * mass);
            let count = match work.counts {
                // A share that is whole must not fall below itself by rounding.
                Counts::Down => (share + 1e-9).floor(),
                Counts::Nearest => share.round(),
            };
            Kind {
                radius: 0.5 * mass.cbrt(),
                mass,
                count: count as usize,
            }
        })
        .take_while(|kind| kind.count > 0)
        .collect();
    let sizes = kinds.len();
    let species =
        Species::new(kinds).ok_or_else(|| refuse("--monomers", monomers, "from 1 to 1e9"))?;
    let particles = species.count();
    let scene = Scene {
        space: Volume,
        surface: Smooth,
        restitution: law,
        sizes: species,
        field: Free,
    };
    let streams = Streams::new(work.seed, 0);
    let mut start = streams.at(Purpose::Velocities, [0, 0]);
    // A tenth of a monomer for each unit of volume, temperature one.
    let volume = monomers / 0.1;
    let gas = Gas::maxwellian(
        scene,
        Contact::Dilute,
        volume,
        particles,
        |_| 1.0,
        &mut start,
    )?;
    let mut engine: Engine<Spheres, S> = Engine::new(gas, (), Bounce, streams)?;
    let began = Instant::now();
    engine.advance(work.until, work.collisions.unwrap_or(u64::MAX), &mut ())?;
    let seconds = began.elapsed().as_secs_f64();
    let tally = engine.tally();
    let each = |count: u64| count as f64 / tally.collisions.max(1) as f64;
    Ok(Speed {
        selection: S::NAME,
        particles,
        sizes,
        seconds,
        collisions: tally.collisions,
        trials_per_collision: each(tally.trials),
        proposals_per_collision: each(tally.proposals),
        rebuilds: tally.rebuilds,
        time: engine.time(),
        final_energy: engine.gas().kinetic_energy(),
        bytes_per_particle: engine.bytes() as f64 / particles as f64,
    })
}

/// The measurement in words.
pub fn words(speed: &Speed) -> String {
    format!(
        "{} particles of {} sizes, selection {}: {} collisions to time {:.4} in {:.2} s ({:.4e}/s); each {:.3} pairs \
         looked at, {:.3} proposals; energy {:.6e}; {:.1} bytes/particle",
        speed.particles,
        speed.sizes,
        speed.selection,
        speed.collisions,
        speed.time,
        speed.seconds,
        speed.collisions as f64 / speed.seconds,
        speed.trials_per_collision,
        speed.proposals_per_collision,
        speed.final_energy,
        speed.bytes_per_particle
    )
}
