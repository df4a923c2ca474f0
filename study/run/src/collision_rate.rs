//! Limit of the collisions of a particle in a unit of time, in exact dynamics: a gas that comes to rest collides ever more often, and a run
//! of it would never end.

use serde::{Deserialize, Serialize};
use stosszahl_model::{Failure, RecentContacts, Simulation};

use crate::plan::{EngineKind, EnginePlan, Plan};
use crate::words::short;

/// Collisions over which a rate is taken that ends a run: of each particle, and of all.
const OF_EACH: f64 = 1000.0;
const OF_ALL: u64 = 2_000_000;
/// Collisions of all over which it is taken for the progress.
const OF_ALL_TOLD: u64 = 100_000;
/// Share of the limit from which it is told.
const TOLD: f64 = 0.01;
/// Most particles that are named.
const NAMED: usize = 8;

/// Collisions and time since a look at them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct RateWindow {
    /// Begin \[engine time\], and collisions until then.
    time: f64,
    collisions: u64,
}

/// More collisions in a unit of time than the case allows.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error(
    "{} collisions of a particle in a unit of time, on average since time {}; allowed are up to {} \
     (engine.ed.collision_rate_limit); {activity}. Particles at rest on each other collide without end: end the run before they come to rest, \
     keep them in motion (a wall with a temperature or a vibration), or give a longer engine.ed.contact_time; a larger \
     engine.ed.collision_rate_limit lets the run go on",
    digits(*rate), short(*since), digits(*limit)
)]
pub struct CollisionRateError {
    /// Collisions of a particle in a unit of time of the case.
    rate: f64,
    /// The limit.
    limit: f64,
    /// Begin of the time over which it was taken, in the unit of time of the case.
    since: f64,
    /// Particles that make up most of them.
    activity: String,
}

impl RateWindow {
    /// Looks at a gas after a leg: what takes the time, in words, if that is notable. The gas has no other numbers whether this is called
    /// or not.
    ///
    /// # Errors
    /// [`CollisionRateError`] if the rate of enough collisions is above the limit of the engine.
    pub(crate) fn look(
        &mut self,
        plan: &Plan,
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
        let found = self.measure(gas.count(), gas.work().collisions, gas.time());
        let Some((rate, is_whole)) = found.filter(|(rate, _)| *rate > TOLD * limit) else {
            return Ok(None);
        };
        let activity = activity(plan, gas.recent_contacts());
        let rate = rate * plan.time;
        let limit = limit * plan.time;
        if is_whole && rate > limit {
            return Err(Failure::new(CollisionRateError {
                rate,
                limit,
                since: begin / plan.time,
                activity,
            }));
        }
        Ok(Some(format!(
            "{} collisions of a particle in a unit of time, where {} end the run; {activity}",
            digits(rate),
            digits(limit)
        )))
    }
}

impl RateWindow {
    /// Collisions of a particle \[1/engine time\] since the begin of the window, and whether these are enough to end a run, at which the next
    /// window begins; none of few collisions.
    fn measure(&mut self, particles: usize, collisions: u64, time: f64) -> Option<(f64, bool)> {
        let since = collisions.saturating_sub(self.collisions);
        if since < OF_ALL_TOLD {
            return None;
        }
        // Of a particle, as each collision is one of two.
        let each = 2.0 * since as f64 / particles as f64;
        let rate = each / (time - self.time).max(f64::MIN_POSITIVE);
        let is_whole = since >= OF_ALL && each >= OF_EACH;
        if is_whole {
            *self = Self { time, collisions };
        }
        Some((rate, is_whole))
    }
}

/// A rate in few digits.
fn digits(rate: f64) -> String {
    if rate < 1e4 {
        short(rate)
    } else {
        format!("{rate:.1e}")
    }
}

/// Particles of the latest contacts, and where they are, in words.
fn activity(plan: &Plan, recent: Option<RecentContacts>) -> String {
    let Some(recent) = recent.filter(|recent| !recent.busiest.is_empty()) else {
        return "it is not known of which".to_owned();
    };
    let place = recent.place.map(|one| short(one * plan.scale.length));
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
        // 2 C/(N t), which is told but ends nothing yet.
        assert_eq!(window.measure(10, 200_000, 0.5), Some((80_000.0, false)));
        // Four collisions of each of a million particles are few.
        assert_eq!(window.measure(1_000_000, OF_ALL, 1.0), Some((4.0, false)));
        assert_eq!(window.measure(10, OF_ALL, 2.0), Some((2e5, true)));
        // From there on anew; a time that stands still has a rate, too.
        assert_eq!(window.measure(10, OF_ALL + 1, 3.0), None);
        let found = window.measure(10, 2 * OF_ALL, 2.0);
        assert!(found.is_some_and(|(rate, is_whole)| is_whole && rate > 1e300));
    }
}
