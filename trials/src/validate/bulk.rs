//! Test of the bulk viscosity of elastic disks at short lags, over Enskog's, against the theory of
//! three disks.

use stosszahl_analysis::helfand::Helfand;
use stosszahl_model::{Budget, Collision, Observer, equation_of_state};
use stosszahl_theory::ElasticDisks;

use super::gas::{exact, start};
use super::over_seeds;
use crate::table::{RowPlace, mean};
use crate::{Done, TrialLog};
use stosszahl_theory::three_disks::bulk_viscosity;

/// Number of disks in the bulk-viscosity test.
const DISKS: usize = 256;
/// Packing fraction of the disks in the bulk-viscosity test.
const PACKING: f64 = 0.1;
/// Smallest lag of the Helfand moments \[d sqrt(m/T)\]; all lags are multiples.
const LAG_STEP: f64 = 0.5;
/// Number of lags of the Helfand moments.
const LAG_COUNT: usize = 3;
/// Integration steps of the three-disk theory per smallest lag.
const STEPS: usize = 10;

/// Observer that accumulates the Helfand moments of the bulk viscosity from collisions.
struct Moments(Helfand);

impl Observer for Moments {
    fn on_collisions(&mut self, batch: &[Collision]) {
        for collision in batch {
            self.0.collide(collision);
        }
    }
}

pub(super) fn test_bulk(log: &mut TrialLog) -> Done {
    // A sum of many small steps over a lag t has its square known from a time T to 2 sqrt(t/(3 T)).
    let (replicas, duration, tolerance, samples) = if log.effort.quick {
        (8, 800.0, 0.07, 1_000_000)
    } else {
        (64, 3000.0, 0.01, 20_000_000)
    };
    let fluid = ElasticDisks {
        packing_fraction: PACKING,
        contact_value: equation_of_state::contact_value(PACKING),
    };
    let area = DISKS as f64 * 0.25 * std::f64::consts::PI / PACKING;
    let (found, seconds) = over_seeds(0..replicas, |seed| {
        let before = start(DISKS, PACKING, 100 + seed, 20.0)?;
        let velocities = before.all.iter().map(|one| one.velocity.xy());
        let mut moments = Moments(Helfand::new(
            before.time,
            velocities,
            1.0,
            area,
            LAG_STEP,
            LAG_COUNT,
        ));
        let mut gas = exact(&before, 1.0)?;
        let end = before.time + duration;
        gas.advance(end, Budget::Unlimited, &mut moments)?;
        moments.0.advance(end);
        Ok(moments.0.moments())
    })?;
    let lags: Vec<f64> = (0..=LAG_COUNT * STEPS)
        .map(|step| step as f64 * LAG_STEP / STEPS as f64)
        .collect();
    let corrections = bulk_viscosity(&lags, samples, 1);
    let rate = equation_of_state::collision_rate(PACKING, fluid.contact_value, 0.0);
    for lag in [1, LAG_COUNT] {
        // The moment over a lag is the mean of its slopes up to there.
        let slopes = &corrections[..=lag * STEPS];
        let sum: f64 = slopes.iter().map(|one| one.value).sum();
        let ends = 0.5 * (slopes[0].value + slopes[lag * STEPS].value);
        let correction = (sum - ends) / (lag * STEPS) as f64;
        let time = lags[lag * STEPS];
        let few = 0.5 * std::f64::consts::PI * rate * time / DISKS as f64;
        let expected = 1.0 + PACKING * correction - few;
        let values = found.iter().map(|moments| {
            let one = &moments[lag - 1];
            one.bulk / (one.lag * fluid.bulk_viscosity())
        });
        let here = RowPlace::new("exact", "event-driven", "256 disks", PACKING, seconds);
        let what = format!("bulk viscosity over Enskog's, lag {time} d √(m/T), with three disks");
        log.claim(&here, what, expected, mean(values)?, Some(tolerance));
    }
    Ok(())
}
