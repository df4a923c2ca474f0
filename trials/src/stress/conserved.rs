//! Hard cases of Monte Carlo collisions: conservation of momentum, energy and angular momentum over
//! long runs.

use nalgebra::{Vector2, vector};
use stosszahl_model::State;
use stosszahl_model::samples::EqualDisks;

use super::schemes::{each, engine, rounding, setups, uniform, warm};
use crate::gas::{domain, random, scattered};
use crate::{Done, TrialLog};

trials! {
    "conservation" => conservation,
        "32 disks with a mean velocity of one, packing 0.3, restitution 1 and 0.9, 1e4 steps (long: 1e6); every scheme",
        "momentum to rounding, and energy too if elastic: no drift";
    "angular-momentum" => angular,
        "a cloud of 100 disks, packing 0.2, in the middle of a box of 200 d whose sides it does not reach, 40 steps of 0.05; every scheme",
        "conserved to rounding by stochastic disks, which collide along the line between them; by no other scheme";
}

fn conservation(log: &mut TrialLog) -> Done {
    let steps = if log.effort.long { 1_000_000 } else { 10_000 };
    let mut start = uniform(32, 0.3, 12)?;
    for body in &mut start.bodies {
        body.velocity += vector![0.6, -0.8];
    }
    let [momentum, energy] = each(log, &[1.0, 0.9], &start, |log, run| {
        run.steps(steps);
        log.progress(0.0, run.setup.name);
        Ok(())
    })?;
    found!(log; "{steps} steps: energy to {energy:.1e}, momentum to {momentum:.1e}");
    Ok(())
}

/// Returns the angular momentum of disks about a point, and the sum of |r| |v| for distances r from
/// it, as its scale.
fn angular_momentum(state: &State<EqualDisks>, about: Vector2<f64>) -> [f64; 2] {
    let mut sums = [0.0; 2];
    for body in &state.bodies {
        let arm = body.position - about;
        sums[0] += arm.perp(&body.velocity);
        sums[1] += arm.norm() * body.velocity.norm();
    }
    sums
}

fn angular(log: &mut TrialLog) -> Done {
    let side = 200.0;
    let places = scattered(100, [90.0; 2], [20.0; 2], &mut random(13));
    let start = warm(domain(side, side)?, places, 13)?;
    let middle = vector![0.5 * side, 0.5 * side];
    for mut setup in setups() {
        // Sets of simulators that are moved at random would fill the box.
        setup.parameters.simulators_per_particle = 1;
        setup.parameters.cell_size = Some(4.0);
        let mut engine = engine(setup, 1.0, &start)?;
        let [before, size] = angular_momentum(&engine.state(), middle);
        engine.hold_step(0.05);
        engine.advance(f64::INFINITY, 40, &mut ());
        let [after, _] = angular_momentum(&engine.state(), middle);
        let off = (after - before).abs() / size;
        let collisions = engine.tally().collisions;
        log.about(setup.name);
        if setup.is_stochastic_disks() {
            // Flights of positions of 100, rounded to 1e-14, in each step.
            log.at_most("off", off, rounding(100, collisions, 0.02) + 40.0 * 1e-14);
        } else {
            must!(log, off > 1e-6; "off by {off:.1e} only");
        }
        must!(log, collisions > 0; "no collision");
        found_in_gas!(log; "{off:.1e} in {collisions} collisions");
    }
    Ok(())
}
