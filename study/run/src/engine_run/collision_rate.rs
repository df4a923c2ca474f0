//! Limit of the collision rate per particle in event-driven dynamics, measured over windows of many
//! collisions. A gas that comes to rest collides ever more often, and its run would never end.

use serde::{Deserialize, Serialize};
use stosszahl_model::{Failure, RecentContacts, Simulation};
use stosszahl_results::{format_number, format_rough};

use crate::plan::{CasePlan, EngineKind, EnginePlan};

/// Fewest collisions per particle in the measuring window of a collision rate that may end a run.
const OF_EACH: f64 = 1000.0;
/// Fewest collisions of all particles in the measuring window of a collision rate that may end a
/// run.
const OF_ALL: u64 = 2_000_000;
/// Fewest collisions of all particles in the measuring window of a collision rate that is reported
/// as high.
const OF_ALL_TOLD: u64 = 100_000;
/// Fraction of the limit above which the collision rate is reported to the user.
const TOLD: f64 = 0.01;
/// Largest number of particles that a report of high collision rates names.
const NAMED: usize = 8;

/// Measuring window of the collision rate: its start, and the collisions before it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct RateWindow {
    /// Start of the measuring window \[engine time\].
    time: f64,
    /// Collisions of the run before the measuring window.
    collisions: u64,
}

/// Formats a measured collision rate, so that a small one can be held against its limit.
fn format_rate(rate: f64) -> String {
    if rate < 1e4 {
        format_number(rate)
    } else {
        format_rough(rate)
    }
}

/// Error of a run whose collision rate exceeds the limit of the case.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error(
    "{} collisions of a particle in a unit of time, on average since time {}; allowed are up to {} \
     (engine.ed.collision_rate_limit); {activity}. Particles at rest on each other collide without end: end the run before they come to rest, \
     keep them in motion (a wall with a temperature or a vibration), or give a longer engine.ed.contact_time; a larger \
     engine.ed.collision_rate_limit lets the run go on",
    format_rate(*rate), format_number(*since), format_number(*limit)
)]
pub struct CollisionRateError {
    /// Measured collisions per particle and unit of time of the case.
    rate: f64,
    /// Largest collision rate that is allowed, in the unit of the rate.
    limit: f64,
    /// Start of the measuring window, in the unit of time of the case.
    since: f64,
    /// Description of the particles that take part in most of the collisions.
    activity: String,
}

impl RateWindow {
    /// Checks the collision rate after a segment of the run. Returns a description of the busiest
    /// particles if the rate is high. The trajectory does not depend on this check.
    ///
    /// # Errors
    /// [`CollisionRateError`] if the rate over enough collisions exceeds the limit of the engine.
    pub(crate) fn check_rate(
        &mut self,
        plan: &CasePlan,
        engine: &EnginePlan,
        gas: &dyn Simulation,
    ) -> Result<Option<String>, Failure> {
        let EngineKind::EventDriven {
            collision_rate_limit: Some(limit),
            ..
        } = engine.kind
        else {
            return Ok(None);
        };
        let begin = self.time;
        let found = self.measure(
            gas.particle_count(),
            gas.work_counters().collisions,
            gas.time(),
        );
        let Some((rate, is_whole)) = found.filter(|(rate, _)| *rate > TOLD * limit) else {
            return Ok(None);
        };
        let activity = busiest_particles(plan, gas.recent_contacts());
        let rate = rate * plan.clock.time;
        let limit = limit * plan.clock.time;
        if is_whole && rate > limit {
            return Err(Failure::new(CollisionRateError {
                rate,
                limit,
                since: begin / plan.clock.time,
                activity,
            }));
        }
        Ok(Some(format!(
            "{} collisions of a particle in a unit of time, where {} end the run; {activity}",
            format_rate(rate),
            format_number(limit)
        )))
    }
}

impl RateWindow {
    /// Measures the collision rate per particle since the start of the measuring window \[1/engine
    /// time\]; `None` for few collisions. Also returns true, and starts the next window, if the
    /// collisions are enough to end a run.
    fn measure(&mut self, particles: usize, collisions: u64, time: f64) -> Option<(f64, bool)> {
        let since = collisions.saturating_sub(self.collisions);
        if since < OF_ALL_TOLD {
            return None;
        }
        // Per particle: each collision counts for two.
        let each = 2.0 * since as f64 / particles as f64;
        let rate = each / (time - self.time).max(f64::MIN_POSITIVE);
        let is_whole = since >= OF_ALL && each >= OF_EACH;
        if is_whole {
            *self = Self { time, collisions };
        }
        Some((rate, is_whole))
    }
}

/// Describes the particles of the latest contacts and their position.
fn busiest_particles(plan: &CasePlan, recent: Option<RecentContacts>) -> String {
    let Some(recent) = recent.filter(|recent| !recent.busiest.is_empty()) else {
        return "it is not known of which".to_owned();
    };
    let place = recent
        .place
        .map(|one| format_number(one * plan.scale.length));
    let names: Vec<String> = (recent.busiest.iter().take(NAMED))
        .map(usize::to_string)
        .collect();
    let more = if recent.busiest.len() > NAMED {
        ", ..."
    } else {
        ""
    };
    format!(
        "half of the last {} contacts are of {} of {} particles ({}{more}), the first near ({}, {})",
        recent.contacts,
        recent.busiest.len(),
        plan.count(),
        names.join(", "),
        place[0],
        place[1]
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rates_are_taken_over_enough_collisions() {
        let mut window = RateWindow::default();
        assert_eq!(window.measure(10, OF_ALL_TOLD - 1, 1.0), None);
        // 2 C/(N t), which is reported but ends nothing yet.
        assert_eq!(window.measure(10, 200_000, 0.5), Some((80_000.0, false)));
        // Four collisions of each of a million particles are few.
        assert_eq!(window.measure(1_000_000, OF_ALL, 1.0), Some((4.0, false)));
        assert_eq!(window.measure(10, OF_ALL, 2.0), Some((2e5, true)));
        // The next window starts there; a window without any time has a rate too.
        assert_eq!(window.measure(10, OF_ALL + 1, 3.0), None);
        let found = window.measure(10, 2 * OF_ALL, 2.0);
        assert!(found.is_some_and(|(rate, is_whole)| is_whole && rate > 1e300));
    }
}
