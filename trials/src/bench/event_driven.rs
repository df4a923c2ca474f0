//! Event-driven disks.

use clap::{Args, ValueEnum};
use stosszahl_ed::{Checkpoint, Dissipation, Engine, Tally};
use stosszahl_model::initial::Arrangement;
use stosszahl_model::kinetic;

use super::{Speed, Work, timed};
use crate::Trouble;
use crate::gas::{Disks, disks, fluid};

/// `stosszahl-trials bench ed`.
#[derive(Clone, Debug, Args)]
pub struct BenchEd {
    /// Number of disks.
    #[arg(long, value_name = "N", default_value_t = 10_000, value_parser = clap::value_parser!(u32).range(2..))]
    pub disks: u32,
    /// Packing fraction.
    #[arg(long, value_name = "P", default_value_t = 0.25)]
    pub packing_fraction: f64,
    /// Coefficient of restitution while timing.
    #[arg(long, value_name = "R", default_value_t = 1.0)]
    pub restitution: f64,
    /// Arrangement of the start.
    #[arg(long, value_enum, default_value_t = BenchStart::Disordered)]
    pub start: BenchStart,
    /// Elastic collisions per particle before timing.
    #[arg(long, value_name = "C", default_value_t = 10.0)]
    pub equilibrate: f64,
    /// Pair collisions to time [default: 5 for each disk, at least a million].
    #[arg(long, value_name = "M")]
    pub collisions: Option<u64>,
    /// Time only until this time, in units of t0 (Haff's time; mean free times of an elastic gas).
    #[arg(long, value_name = "T")]
    pub until: Option<f64>,
    /// Print one JSON object.
    #[arg(long)]
    pub json: bool,
}

/// How disks are arranged before they are equilibrated.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum BenchStart {
    /// In no order: random sequential addition, a molten lattice above packing 0.45.
    Disordered,
    /// On a hexagonal lattice.
    Hexagonal,
}

impl BenchEd {
    /// The equilibrated gas.
    fn start(&self) -> Result<Checkpoint<Disks>, Trouble> {
        let check = |name, value, good: bool, allowed| {
            let refused = || Trouble::BadNumber {
                name,
                value,
                allowed,
            };
            good.then_some(()).ok_or_else(refused)
        };
        let (packing, each) = (self.packing_fraction, self.equilibrate);
        let good = packing > 0.0 && packing <= kinetic::CLOSE_PACKING;
        check(
            "packing-fraction",
            packing,
            good,
            "above 0 and at most 0.9069",
        )?;
        check("equilibrate", each, (0.0..1e9).contains(&each), "0 or more")?;
        let count = self.disks as usize;
        // The box of a hexagonal crystal of about as many disks in equal columns and rows, so that it fits up to close
        // packing; square otherwise.
        let (arrangement, aspect) = match self.start {
            BenchStart::Disordered => (Arrangement::Disordered, 1.0),
            BenchStart::Hexagonal => {
                let rows = 2.0 * ((count as f64).sqrt() / 2.0).round().max(1.0);
                let columns = (count as f64 / rows).ceil();
                (Arrangement::Hexagonal, 0.75_f64.sqrt() * rows / columns)
            }
        };
        let start = fluid(arrangement, count, packing, aspect, 1)?;
        let mut engine = Engine::<Disks>::new(disks(1.0)?, Dissipation::Elastic, start)?;
        let collisions = (0.5 * each * count as f64).ceil() as u64;
        engine.advance(f64::INFINITY, collisions, &mut ())?;
        let mut gas = engine.checkpoint();
        gas.state.time = 0.0;
        Ok(gas)
    }
}

impl Work for BenchEd {
    /// Times the next collisions, or those until a time in units of `t_0` after the start; making the engine and its
    /// checkpoint is included.
    fn measure(&self) -> Result<Speed, Trouble> {
        let (restitution, packing) = (self.restitution, self.packing_fraction);
        let scene = disks(restitution)?;
        let mut gas = self.start()?;
        let all = if self.until.is_some() {
            u64::MAX / 2
        } else {
            (5 * u64::from(self.disks)).max(1_000_000)
        };
        let collisions = self.collisions.unwrap_or(all);
        let chi = kinetic::contact_value(packing.min(0.999 * kinetic::CLOSE_PACKING));
        let unit = if restitution < 1.0 {
            kinetic::haff_time(packing, restitution, chi)
        } else {
            1.0 / kinetic::collision_rate(packing, chi, 0.0)
        };
        let until = self.until.map_or(f64::INFINITY, |time| time * unit);
        let before = gas.tally;
        let (bytes, seconds, cpu) = timed(|| -> Result<usize, Trouble> {
            let mut engine = Engine::<Disks>::new(scene, Dissipation::Scene, gas.clone())?;
            engine.advance(until, collisions, &mut ())?;
            gas = engine.checkpoint();
            Ok(engine.bytes())
        });
        let after = gas.tally;
        let done = after.collisions - before.collisions;
        let each =
            |count: fn(&Tally) -> u64| (count(&after) - count(&before)) as f64 / done.max(1) as f64;
        let (rate, cpu_rate) = (done as f64 / seconds, done as f64 / cpu);
        let memory = bytes? as f64 / f64::from(self.disks);
        let predictions = each(|tally| tally.predictions);
        let pushes = each(|tally| tally.pushes);
        let crossings = each(|tally| tally.crossings);
        let stale = each(|tally| tally.stale);
        let broken = each(|tally| tally.broken);
        Ok(Speed {
            words: format!(
                "{} disks at packing {packing}, restitution {restitution}: {rate:.4e} collisions/s of wall time, \
                 {cpu_rate:.4e} of CPU time ({done} in {seconds:.2} s); {memory:.0} bytes/disk; each collision \
                 {predictions:.2} predictions, {pushes:.2} pushes, {crossings:.2} crossings, {stale:.2} stale, \
                 {broken:.2} broken",
                self.disks
            ),
            values: vec![
                ("collisions", done.into()),
                ("seconds", seconds.into()),
                ("collisions_per_second", rate.into()),
                ("collisions_per_cpu_second", cpu_rate.into()),
                ("bytes_per_disk", memory.into()),
                ("predictions_per_collision", predictions.into()),
                ("pushes_per_collision", pushes.into()),
                ("crossings_per_collision", crossings.into()),
                ("stale_per_collision", stale.into()),
                ("broken_per_collision", broken.into()),
            ],
        })
    }

    fn json(&self) -> bool {
        self.json
    }
}
