//! Check of the time that a gas shall be advanced to.

use stosszahl_model::walls::{Face, Rebound, Vibration};
use stosszahl_model::{Law, Restitution as _, Simulation, format_short};

use crate::{Gas, GasError};

/// Largest number of collisions and box crossings in one advance, estimated from rates: years of
/// work for any machine.
const MOST_EVENTS: f64 = 1e15;

/// Latest time that a gas can be advanced to \[time\], as in cases.
const LATEST: f64 = 1e100;

/// Checks the time that a gas shall be advanced to: not past, finite, and reachable with the work
/// that a machine can do.
///
/// # Errors
/// [`GasError::Time`]
pub(crate) fn check_time(
    gas: &Gas,
    engine: &dyn Simulation,
    collides: bool,
    until: f64,
) -> Result<(), GasError> {
    let now = engine.time();
    let refused = |allowed: String| {
        Err(GasError::Time {
            now,
            until,
            allowed,
        })
    };
    if !until.is_finite() {
        return refused("finite times".into());
    }
    if until < now {
        return refused(format!("the present time {} or later", format_short(now)));
    }
    if until > LATEST {
        return refused(format!("times up to {LATEST:e}"));
    }
    if collides && cools(gas) {
        // Collisions become rarer as it cools, and few are left.
        return Ok(());
    }
    let rate = events_per_time(gas, engine);
    if rate * (until - now) > MOST_EVENTS {
        let last = now + MOST_EVENTS / rate;
        return refused(format!(
            "times up to about {}, when this gas has had {MOST_EVENTS:e} collisions",
            format_short(last)
        ));
    }
    Ok(())
}

/// Returns true if the gas cools freely: collisions dissipate energy, and nothing adds any.
fn cools(gas: &Gas) -> bool {
    let law = &gas.grains.restitution;
    let may_add = law.max_added_speed() > 0.0 || matches!(law, Law::Pairs(_));
    let dissipates = !law.is_elastic() || gas.grains.rough.is_some();
    let is_still = gas.grains.gravity.is_none() && gas.grains.shear_rate.is_none();
    dissipates && !may_add && is_still && wall_speed_squared(gas) == 0.0
}

/// Returns the squared speed that walls can give to particles, over that of a unit mass at
/// temperature one; 0 without moving or hot walls.
fn wall_speed_squared(gas: &Gas) -> f64 {
    let faces = (0..gas.particles.dimension).flat_map(|axis| [(axis, 0), (axis, 1)]);
    let given = faces.map(|(axis, side)| match gas.walls.face(axis, side) {
        Face::Wall(wall) => {
            let thermal = match wall.rebound {
                Rebound::Diffuse { temperature } => temperature,
                Rebound::Restitutive { .. } => 0.0,
            };
            let shaken = wall.vibration.as_ref().map_or(0.0, Vibration::speed);
            thermal
                .max(wall.sliding.norm_squared())
                .max(shaken * shaken)
        }
        _ => 0.0,
    });
    given.fold(0.0, f64::max)
}

/// Estimates the rate of collisions of all particles and of box crossings \[1/time\], at the
/// temperature of the gas or of its walls.
fn events_per_time(gas: &Gas, engine: &dyn Simulation) -> f64 {
    let all = &gas.particles;
    let (count, dimension) = (engine.particle_count() as f64, all.dimension as i32);
    let sum = |of: fn(&stosszahl_model::Particle) -> f64| all.all.iter().map(of).sum::<f64>();
    let mean = |of| sum(of) / all.all.len().max(1) as f64;
    let (diameter, mass) = (2.0 * mean(|one| one.radius), mean(|one| one.mass));
    let side = gas.volume.powf(1.0 / f64::from(dimension));
    let fall = gas.grains.gravity.map_or(0.0, |pull| pull.norm() * side);
    let square = (engine.temperature() / mass)
        .max(wall_speed_squared(gas))
        .max(fall);
    let rate = count * diameter.powi(dimension - 1) / gas.volume;
    count * square.sqrt() * (rate + 1.0 / side)
}
