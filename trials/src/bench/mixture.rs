//! Speed of Monte Carlo collisions without positions: a highly polydisperse cooling gas of spheres,
//! the case of Table I of Bodrova & Osinsky (2024).

use clap::builder::PossibleValue;
use clap::{Args, ValueEnum};
use stosszahl_dsmc::homogeneous::{
    AliasTableSelection, Bird, HomogeneousEngine, LowRank, PairCorrelationFactor, SelectionMethod,
};

use super::{BenchWork, Speed, timed};
use crate::TrialError;
use crate::gas::{Spheres, spheres, without_positions};

/// Options of `stosszahl-trials bench mixture`, the benchmark of a polydisperse gas without
/// positions.
#[derive(Clone, Debug, Args)]
pub struct BenchMixture {
    /// Algorithm that selects colliding pairs.
    #[arg(long, value_enum, default_value_t = SelectionArgument::AliasTables)]
    pub selection: SelectionArgument,
    /// Number of monomers; there are k^-3 times as many spheres of mass k.
    #[arg(long, value_name = "N", default_value_t = 1_000_000, value_parser = clap::value_parser!(u32).range(1..=1_000_000_000))]
    pub monomers: u32,
    /// Rounding of the numbers of spheres of each mass: down (100 sizes for a million monomers) or
    /// to the nearest (125 sizes).
    #[arg(long, value_enum, default_value_t = CountRounding::Down)]
    pub counts: CountRounding,
    /// Coefficient of restitution of the spheres.
    #[arg(long, value_name = "R", default_value_t = 0.5)]
    pub restitution: f64,
    /// Pair collisions to time [default: all until the end time].
    #[arg(long, value_name = "M")]
    pub collisions: Option<u64>,
    /// End time of the benchmark, in units of the monomers' diameter over thermal speed.
    #[arg(long, value_name = "T", default_value_t = 100.0)]
    pub until: f64,
    /// Seed of the start and of the collisions.
    #[arg(long, value_name = "S", default_value_t = 1)]
    pub seed: u64,
    /// Print the measured speed as one JSON object.
    #[arg(long)]
    pub json: bool,
}

/// Algorithm that selects colliding pairs, by its name in case files.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum SelectionArgument {
    /// Alias tables over groups of similar speed and size: the fastest.
    AliasTables,
    /// Low-rank products of the weights of size classes, found in trees.
    LowRank,
    /// Bird's method with a single majorant for all pairs.
    SingleMajorant,
}

/// Rounding of the numbers of spheres of each mass to whole numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum CountRounding {
    /// Rounding of the numbers of spheres down to whole numbers.
    Down,
    /// Rounding of the numbers of spheres to the nearest whole numbers.
    Nearest,
}

impl BenchWork for BenchMixture {
    fn measure_speed(&self) -> Result<Speed, TrialError> {
        match self.selection {
            SelectionArgument::AliasTables => self.measure_by::<AliasTableSelection>(),
            SelectionArgument::LowRank => self.measure_by::<LowRank>(),
            SelectionArgument::SingleMajorant => self.measure_by::<Bird>(),
        }
    }
}

impl BenchMixture {
    fn measure_by<S: SelectionMethod<Spheres>>(&self) -> Result<Speed, TrialError> {
        let monomers = f64::from(self.monomers);
        let kinds: Vec<(f64, f64, usize)> = (1_u32..=2000)
            .map(|k| {
                let mass = f64::from(k);
                let share = monomers / (mass * mass * mass);
                let count = match self.counts {
                    // Slack for a whole share that rounding puts just below itself.
                    CountRounding::Down => (share + 1e-9).floor(),
                    CountRounding::Nearest => share.round(),
                };
                (mass.cbrt(), mass, count as usize)
            })
            .take_while(|kind| kind.2 > 0)
            .collect();
        let sizes = kinds.len();
        let particles: usize = kinds.iter().map(|kind| kind.2).sum();
        let scene = spheres(&kinds, self.restitution)?;
        // Number density 0.1 of monomers, temperature one.
        let extent = (monomers / 0.1, particles);
        let mut engine: HomogeneousEngine<_, S> = without_positions(
            scene,
            PairCorrelationFactor::Dilute,
            extent,
            |_| 1.0,
            self.seed,
        )?;
        let most = self.collisions.unwrap_or(u64::MAX);
        let (ended, seconds, _) = timed(|| engine.advance(self.until, most, &mut ()));
        ended?;
        let tally = engine.tally();
        let collisions = tally.collisions;
        let each = |count: u64| count as f64 / collisions.max(1) as f64;
        let selection = self.selection.to_possible_value();
        let bytes = engine.memory_bytes() as f64 / particles as f64;
        Ok(Speed::default()
            .with("selection", selection.as_ref().map(PossibleValue::get_name))
            .with("particles", particles)
            .with("sizes", sizes)
            .with("seconds", seconds)
            .with("collisions", collisions)
            .with("collisions_per_second", collisions as f64 / seconds)
            .with("trials_per_collision", each(tally.trials))
            .with("proposals_per_collision", each(tally.proposals))
            .with("rebuilds", tally.rebuilds)
            .with("time", engine.time())
            .with("final_energy", engine.gas().kinetic_energy())
            .with("bytes_per_particle", bytes))
    }
}
