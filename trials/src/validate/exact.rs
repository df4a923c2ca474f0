//! Test of exact dynamics of elastic disks: conservation, time reversal, equation of state,
//! structure.

use std::f64::consts::PI;
use std::time::Instant;

use stosszahl_analysis::energy::Virial;
use stosszahl_analysis::equilibrium::long_waves_fluctuate;
use stosszahl_analysis::statistics::Estimate;
use stosszahl_ed::{DissipationRule, EventDrivenEngine};
use stosszahl_model::Budget;
use stosszahl_model::samples::{EqualDisks, UNIT, particles_of};

use super::gas::{columns, exact, start};
use super::{bulk, contact, over_seeds};
use crate::gas::{disks as unit_disks, disordered, relaxed};
use crate::table::{RowPlace, mean};
use crate::{Done, TrialError, TrialLog};

/// Compressibility factor Z of hard disks by packing fraction, from the ten-term virial series of
/// Kolafa & Rottner, Mol. Phys. 104, 3435 (2006).
const COMPRESSIBILITY: [(f64, f64); 3] = [(0.1, 1.2361), (0.25, 1.7916), (0.5, 4.107)];
/// Number of disks in the test of the equation of state.
const DISKS: usize = 10_000;

/// Measures the compressibility factor Z of elastic disks from the virial, and the collision rate
/// over `4 (Z - 1)/√π`, its value by Z. Standard errors are those of ten blocks of collisions.
fn equation_of_state(packing: f64, collisions: u64) -> Result<[Estimate; 2], TrialError> {
    let mut now = start(DISKS, packing, 2, 20.0)?;
    let (mut factors, mut quotients) = (Vec::new(), Vec::new());
    for _ in 0..10 {
        let (mut gas, mut virial) = (exact(&now, 1.0)?, Virial::default());
        gas.advance(f64::INFINITY, Budget::Collisions(collisions), &mut virial)?;
        now = gas.particles();
        let factor = virial.compressibility_factor::<EqualDisks>(DISKS, 1.0, now.time);
        let rate = 2.0 * collisions as f64 / DISKS as f64 / now.time;
        factors.push(factor);
        quotients.push(rate / (4.0 * (factor - 1.0) / PI.sqrt()));
        now.time = 0.0;
    }
    Ok([mean(factors)?, mean(quotients)?])
}

fn place_text(setting: &str, packing: f64, began: Instant) -> RowPlace {
    let seconds = began.elapsed().as_secs_f64();
    RowPlace::new("exact", "event-driven", setting, packing, seconds)
}

/// Returns the largest distance of disks from their start after a number of collisions, a reversal
/// of all velocities and the same time back \[length\].
fn reversed(disks: usize, packing: f64, collisions: u64) -> Result<f64, TrialError> {
    let start = disordered(disks, packing, 3)?;
    let before = particles_of(&UNIT, &start);
    let mut gas = exact(&before, 1.0)?;
    gas.advance(f64::INFINITY, Budget::Collisions(collisions), &mut ())?;
    let mut turned = gas.particles();
    for particle in &mut turned.all {
        particle.velocity = -particle.velocity;
    }
    let mut back = exact(&turned, 1.0)?;
    back.advance(2.0 * turned.time, Budget::Unlimited, &mut ())?;
    let (before, after) = (columns(&before).0, columns(&back.particles()).0);
    let pairs = before.into_iter().zip(after);
    let off = pairs.map(|(a, b)| start.domain.distance(a, b));
    Ok(off.fold(0.0, f64::max))
}

/// Tests exact dynamics: conservation, reversal, equation of state against the literature,
/// structure, bulk viscosity and contact values.
pub(super) fn test_exact(log: &mut TrialLog) -> Done {
    mechanics(log)?;
    state(log)?;
    structure(log)?;
    bulk::test_bulk(log)?;
    contact::test_contact(log)
}

fn mechanics(log: &mut TrialLog) -> Done {
    let began = Instant::now();
    let collisions = if log.effort.quick {
        1_000_000
    } else {
        5_000_000
    };
    let state = relaxed(disordered(10_000, 0.25, 1)?, 10.0)?;
    let scene = unit_disks(1.0)?;
    let (first, momentum) = (state.temperature(&scene), state.momentum(&scene));
    let mut engine =
        EventDrivenEngine::<EqualDisks>::new(scene.clone(), DissipationRule::Scene, state)?;
    engine.advance(f64::INFINITY, collisions, &mut ())?;
    let state = engine.state();
    let drift = (state.temperature(&scene) / first - 1.0).abs();
    // Momentum lost, over that of all disks at the thermal speed.
    let lost = (state.momentum(&scene) - momentum).norm() / 1e4;
    let here = place_text("10 000 disks", 0.25, began);
    let what = format!("drift of K over {collisions:.0e} collisions");
    log.add(here.exact(what, 0.0, drift, 1e-11));
    log.add(here.exact("drift of the momentum a disk", 0.0, lost, 1e-11));
    log.add(here.exact("deepest overlap", 0.0, engine.worst_overlap(), 1e-11));
    let began = Instant::now();
    let off = reversed(2000, 0.25, 2000)?;
    let here = place_text("2000 disks", 0.25, began);
    log.add(here.exact("off after reversal of 2000 collisions, d", 0.0, off, 1e-9));
    Ok(())
}

fn state(log: &mut TrialLog) -> Done {
    // Error of Z, which falls with the root of the number of collisions, at most half of the
    // tolerance.
    let (collisions, tolerance) = if log.effort.quick {
        (100_000, 0.006)
    } else {
        (800_000, 0.002)
    };
    for (packing, expected) in COMPRESSIBILITY {
        let began = Instant::now();
        let [factor, rate] = equation_of_state(packing, collisions)?;
        let here = place_text("10 000 disks", packing, began);
        let within = Some(tolerance * expected);
        log.claim(&here, "Z (Kolafa & Rottner 2006)", expected, factor, within);
        let what = "collision rate/(4 (Z - 1)/√π)";
        log.claim(&here, what, 1.0, rate, Some(0.5 * tolerance));
    }
    Ok(())
}

/// Tests density fluctuations of long waves against the compressibility of the hard-disk fluid.
/// Wave numbers up to k d = 0.6 count, where structure changes S(k) by less than a tenth.
fn structure(log: &mut TrialLog) -> Done {
    let began = Instant::now();
    let seeds = if log.effort.quick { 32 } else { 200 };
    let (found, _) = over_seeds(0..seeds, |seed| {
        let gas = start(2000, 0.25, seed, 40.0)?;
        let lengths = [gas.lengths[0], gas.lengths[1]];
        Ok(long_waves_fluctuate(&columns(&gas).0, lengths, 1.0, 0.25).statistic)
    })?;
    let here = place_text("2000 disks", 0.25, began);
    let what = "S(k d < 0.6) over the compressibility";
    log.claim(&here, what, 1.0, mean(found)?, Some(0.1));
    Ok(())
}
