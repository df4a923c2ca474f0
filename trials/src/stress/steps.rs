//! Hard cases of Monte Carlo schemes: too long time steps, too small majorants, one far too fast
//! simulator, restitution zero, and cooling through many decades.

use nalgebra::vector;
use stosszahl_dsmc::{DsmcError, PartnerDisplacement};
use stosszahl_model::equation_of_state;
use stosszahl_theory::transport::critical_length;

use super::schemes::{ConservedSums, SchemeRun, each, engine, setups, uniform, warm};
use crate::gas::{domain, random, scattered};
use crate::table::mean;
use crate::{Done, TrialError, TrialLog};

trials! {
    "violations" => violations,
        "400 disks of speed one along x, packing 0.3, some ten collisions of each in one step: the fastest pairs are made within the \
         step; every scheme",
        "violations of the majorant are counted (stochastic disks need no majorant and have none; other schemes across cells raise \
         theirs within the step, and may have none); energy and momentum";
    "long-step" => long_step,
        "200 of 400 disks in a cluster at packing 0.8, steps held at 1, 10 and 100 times the engine's own; every scheme",
        "the tally tells: `busiest_cell` is more than twice that of an even gas; energy and momentum";
    "hot-one" => hot_one,
        "one of 200 disks with a million times the thermal speed, until it has shared its energy; every scheme",
        "an end; energy and momentum; the energy is shared";
    "plastic" => plastic,
        "restitution 0: 200 disks at packing 0.3, 300 steps; every scheme; 1e-300 and 5e-324 where it divides",
        "energy never grows, momentum, no endless loop; the displacement d (1 + r)/(2r) is refused with a typed error";
    "deep-cooling" => deep,
        "100 disks, restitution 0.8, packing 0.1, in a box that shear modes cannot grow in, to 1e-24 of the temperature",
        "as many collisions for each decade in the last six as in the first, to 6 standard errors; steps follow the gas; momentum";
}

fn violations(log: &mut TrialLog) -> Done {
    let mut start = uniform(400, 0.3, 5)?;
    for (index, body) in start.bodies.iter_mut().enumerate() {
        body.velocity = vector![if index % 2 == 0 { 1.0 } else { -1.0 }, 0.0];
    }
    each(log, &[1.0], &start, |log, run| {
        // A mean free time is about one half.
        run.engine.hold_step(5.0);
        run.steps(5);
        let (violations, trials) = (run.tally().majorant_violations, run.tally().trials);
        let good = if run.setup.parameters.scheme.is_cross_cell() {
            violations == 0 || !run.setup.is_stochastic_disks()
        } else {
            violations > 0
        };
        must!(log, good; "{violations} violations");
        found_in_gas!(log; "{violations} in {trials} trials");
        Ok(())
    })?;
    Ok(())
}

fn long_step(log: &mut TrialLog) -> Done {
    let side = 80.0;
    let mut stream = random(6);
    let mut places = scattered(200, [30.0; 2], [14.0; 2], &mut stream);
    places.extend(scattered(200, [0.0; 2], [side; 2], &mut stream));
    let start = warm(domain(side, side)?, places, 6)?;
    for setup in setups() {
        let mut own = engine(setup, 1.0, &start)?;
        own.advance(f64::INFINITY, 1, &mut ());
        let mut busiest = [0.0; 3];
        for (times, busiest) in [1.0, 10.0, 100.0].into_iter().zip(&mut busiest) {
            about!(log; "{} x {times}", setup.name);
            let mut run = SchemeRun::new(setup, 1.0, &start)?;
            run.engine.hold_step(times * own.time());
            run.steps(4);
            run.audit(log);
            *busiest = run.tally().busiest_cell;
        }
        let mut even = engine(setup, 1.0, &uniform(400, 0.2, 6)?)?;
        even.advance(f64::INFINITY, 20, &mut ());
        let usual = even.tally().busiest_cell;
        let [own, ten, hundred] = busiest;
        log.about(setup.name);
        let seen = ten.min(hundred) >= 2.0 * usual;
        must!(log, seen; "busiest cells {ten} and {hundred}, usually {usual}");
        found_in_gas!(log; "{usual:.1} without a cluster, {own:.1}, {ten:.1}, {hundred:.1}");
    }
    Ok(())
}

fn hot_one(log: &mut TrialLog) -> Done {
    const HOT: f64 = 1e6;
    let mut start = uniform(200, 0.2, 7)?;
    start.bodies[0].velocity = vector![0.6 * HOT, 0.8 * HOT];
    for setup in setups() {
        log.about(setup.name);
        let mut run = SchemeRun::new(setup, 1.0, &start)?;
        // Once shared, the energy gives a speed of 7e4 and mean free times of 2e-5.
        let reached = run.engine.advance(1e-4, 1_000_000, &mut ());
        let steps = run.tally().steps;
        must!(log, reached; "no end in {steps} steps");
        // Only few pairs contain the hot simulator, but they have all the energy.
        run.audit_shared(log, 1.0);
        let end = run.engine.state();
        let speeds = end.bodies.iter().map(|body| body.velocity.norm());
        let fastest = speeds.fold(0.0, f64::max);
        log.at_most("fastest", fastest, 0.9 * HOT);
        found_in_gas!(log; "fastest {fastest:.1e} after {steps} steps");
    }
    Ok(())
}

fn plastic(log: &mut TrialLog) -> Done {
    let start = uniform(200, 0.3, 8)?;
    let (mut refused, mut collisions) = (0, 0);
    for restitution in [0.0, 1e-300, 5e-324] {
        for setup in setups() {
            about!(log; "{}, r = {restitution:e}", setup.name);
            if setup.parameters.displacement == PartnerDisplacement::Inelastic {
                let error = engine(setup, restitution, &start).err();
                let typed = match error.as_ref().and_then(TrialError::downcast_ref) {
                    Some(DsmcError::NoDisplacement) => restitution == 0.0,
                    Some(DsmcError::FarDisplacement { .. }) => restitution > 0.0,
                    _ => false,
                };
                must!(log, typed; "{error:?}");
                refused += 1;
                continue;
            }
            // Restitution next to zero matters only where it divides.
            if restitution > 0.0 {
                continue;
            }
            log.guard(|log| {
                let mut run = SchemeRun::new(setup, restitution, &start)?;
                let mut last = run.before.energy;
                for _ in 0..10 {
                    run.steps(30);
                    let now = ConservedSums::of(&run.engine.state()).energy;
                    // Rounding of sums of equally many numbers in another order.
                    log.at_most("energy grown", now / last - 1.0, 3e-14);
                    last = now;
                }
                run.audit(log);
                collisions += run.tally().collisions;
                Ok(())
            });
        }
    }
    found!(log; "{collisions} collisions, refused {refused} times");
    Ok(())
}

fn deep(log: &mut TrialLog) -> Done {
    const RESTITUTION: f64 = 0.8;
    const PACKING: f64 = 0.1;
    let start = uniform(100, PACKING, 9)?;
    let side = start.domain.lengths()[0];
    let critical = critical_length(
        PACKING,
        equation_of_state::contact_value(PACKING),
        RESTITUTION,
    );
    must!(log, side < critical; "a box of {side:.1} d, in which shear modes from {critical:.1} d grow");
    each(log, &[RESTITUTION], &start, |log, run| {
        let count = run.engine.simulators() as f64;
        let first = run.before.energy;
        // Collisions per simulator until each decade.
        let mut passed: Vec<f64> = Vec::new();
        let mut energy = first;
        while passed.len() < 24 && run.tally().steps < 200_000 {
            run.steps(1);
            energy = ConservedSums::of(&run.engine.state()).energy;
            while energy < first * 0.1_f64.powi(passed.len() as i32 + 1) {
                passed.push(2.0 * run.tally().collisions as f64 / count);
            }
        }
        let (steps, time) = (run.tally().steps, run.engine.time());
        if passed.len() < 24 {
            log.fault(format!(
                "T/T(0) = {:.1e} after {steps} steps",
                energy / first
            ));
            return Ok(());
        }
        let decades = |from: usize| mean(passed[from..from + 7].windows(2).map(|p| p[1] - p[0]));
        let [early, late] = [decades(1)?, decades(17)?];
        let [one, other] = [early, late].map(|part| part.standard_error.unwrap_or(f64::NAN));
        let error = one.hypot(other);
        // Of twelve decades the scatter has ten degrees of freedom: Student's t exceeds 6 once in
        // 1e4.
        let differ = (early.value - late.value).abs() / error;
        log.at_most(
            "early and late decades differ, in standard errors",
            differ,
            6.0,
        );
        found_in_gas!(log; "{:.1} and {:.1} (error {error:.1}) collisions a decade, {steps} steps, time {time:.1e}",
            early.value, late.value);
        Ok(())
    })?;
    Ok(())
}
