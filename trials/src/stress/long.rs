//! Hard cases of exact disks in long runs, and of kills and restarts in gases of every kind.

use super::collapse::hexagonal;
use super::gas::{MOMENTUM, StressGas, disordered};
use crate::{Done, TrialLog};

trials! {
    "elastic-run" => elastic,
        "1000 elastic disks at packing 0.4 in legs of 1e5 collisions; 2e6 collisions, 1e9 long (--collisions)",
        "energy drift at most 1e-10, no overlap beyond 1e-10 d, and at the end the bits of the same gas with a clock at zero";
    "cooling" => cooling,
        "500 disks at packing 0.4, restitution 0.9, contact time 1e-6, until the temperature has fallen by 12 decades",
        "numbers stay finite, no overlap, momentum and energy balance to rounding, temperature never grows";
    "kills" => kills,
        "gases from thin to crystalline, elastic, inelastic and with contact time, cut at 8 (long: 200) sets of random moments each",
        "the bytes of the run that was never killed; the other cases are cut as well";
}

fn elastic(log: &mut TrialLog) -> Done {
    const LEG: u64 = 100_000;
    let collisions = if log.effort.long {
        1_000_000_000
    } else {
        2_000_000
    };
    let collisions = log.effort.collisions.unwrap_or(collisions);
    let gas = disordered(1000, 0.4, 1.0, 5)?;
    let mut shown = 0;
    let course = gas.run_in_legs(f64::INFINITY, collisions, LEG, |end, ledger| {
        if ledger.collisions - shown >= 20_000_000 {
            shown = ledger.collisions;
            let share = ledger.collisions as f64 / collisions as f64;
            log.progress(share, &format!("at time {:.4e}", end.state.time));
        }
        true
    })?;
    must!(log, course.stopped.is_none(); "{}", course.ended());
    let drift = gas.energy_error(&course);
    // 2e6 collisions of each disk: a linear sum of roundings of 1e-16 would be 2e-10, their random
    // walk is 1e-13.
    log.at_most("energy drift", drift, 1e-10);
    log.at_most("overlap over d", course.overlap, 1e-10);
    log.at_most(
        "momentum",
        gas.momentum_error(&course.end.state),
        MOMENTUM * 10.0,
    );
    let time = course.end.state.time;
    let late = StressGas::new(gas.scene.clone(), course.end.state.clone());
    let mut early = late.clone();
    early.start.time = 0.0;
    let end = |gas: StressGas<_>| {
        gas.run_until(f64::INFINITY, LEG)
            .map(|course| course.end.state.bodies)
    };
    must!(log, end(late)? == end(early)?; "at time {time:.3e} the gas moves otherwise than at time zero");
    found!(log; "{} collisions to time {time:.3e}, energy {drift:.1e}, overlap {:.1e} d", course.collisions(), course.overlap);
    gas.survives_kills(log, 40_000, 1)
}

fn cooling(log: &mut TrialLog) -> Done {
    const DECADES: f64 = 1e-12;
    const MOST: u64 = 5_000_000;
    let gas = disordered(500, 0.4, 0.9, 6)?.with_contact_time(1e-6);
    let start = gas.start.temperature(&gas.scene);
    let (mut last, mut grew) = (start, 0.0_f64);
    let course = gas.run_in_legs(f64::INFINITY, MOST, 2000, |end, _| {
        let temperature = end.state.temperature(&gas.scene);
        grew = grew.max(temperature / last - 1.0);
        last = temperature;
        last > DECADES * start
    })?;
    gas.audit(log, &course);
    let reached = last / (DECADES * start);
    log.at_most("temperature over the asked one", reached, 1.0);
    // Two thousand roundings.
    log.at_most("growth of the temperature", grew, 1e-12);
    let collisions = course.collisions();
    // The last collisions still follow the energy law among themselves, at speeds of 1e-6.
    let mut cold = gas.clone();
    cold.start = course.end.state;
    log.about("cold gas");
    cold.holds(log, 2000)?;
    found!(log; "{collisions} collisions to T/T(0) = {:.1e}", last / start);
    log.about("cooling");
    gas.survives_kills(log, 40_000, 1)
}

fn kills(log: &mut TrialLog) -> Done {
    let sets = if log.effort.long { 200 } else { 8 };
    let mut gases = vec![hexagonal(0.88, 1.0)?, hexagonal(0.9, 0.99)?];
    for (packing, restitution) in [(0.01, 1.0), (0.25, 0.8), (0.5, 0.6), (0.69, 1.0)] {
        let gas = disordered(200, packing, restitution, 3)?;
        gases.push(gas.clone().with_contact_time(1e-3));
        gases.push(gas);
    }
    for (number, gas) in gases.iter().enumerate() {
        for seed in 0..sets {
            about!(log; "gas {number}, moments {seed}");
            gas.survives_kills(log, 3000, seed)?;
        }
        log.progress((number + 1) as f64 / gases.len() as f64, "");
    }
    found!(log; "{} gases, {sets} sets of four legs", gases.len());
    Ok(())
}
