//! Event loop of the engine: takes events from the calendar in order of time and executes them. It
//! is compiled twice, for any processor and for those with AVX2.

use stosszahl_model::{Field, Observer, ParticleModel, Plane, Recorder, Sizes};

use crate::calendar::Calendar;
use crate::cells::NONE;
use crate::engine::EventDrivenEngine;
use crate::error::EventDrivenError;

/// Number of events between two checks of the interrupt: an event takes up to a millisecond if
/// sizes of disks differ much.
const BETWEEN_LOOKS: u32 = 256;

/// End of an event loop: a time, and a number of collisions.
pub(crate) struct Goal {
    /// Engine time up to which events are executed, inclusive.
    pub(crate) end: f64,
    /// True if `end` is a finite time to be reached; false if only collisions are counted.
    pub(crate) ends: bool,
    /// Number of collisions since the start of the run at which the loop ends, if before `end`.
    pub(crate) last: u64,
}

/// Method to advance an engine faster than event by event, to the same bytes: in parallel strips.
pub(crate) trait Leap<P: ParticleModel, Q: Calendar> {
    /// Advances an engine in parallel towards a goal, as far as this pays; the event loop does the
    /// rest. True if the time of the goal was reached before its number of collisions.
    fn leap_towards(
        &mut self,
        engine: &mut EventDrivenEngine<P, Q>,
        goal: &Goal,
        recorder: &mut Recorder<'_>,
    ) -> bool;

    /// Frees the data kept for the next parallel advance, because the engine now advances without
    /// it.
    fn drop_kept(&mut self);
}

/// Advance without parallel strips: event by event only.
struct Alone;

impl<P: ParticleModel, Q: Calendar> Leap<P, Q> for Alone {
    fn leap_towards(
        &mut self,
        _: &mut EventDrivenEngine<P, Q>,
        _: &Goal,
        _: &mut Recorder<'_>,
    ) -> bool {
        false
    }

    fn drop_kept(&mut self) {}
}

impl<P, Q> EventDrivenEngine<P, Q>
where
    P: ParticleModel<Space = Plane>,
    Q: Calendar,
{
    /// Advances the gas to the absolute time `until` \[time\], or by `most_collisions` collisions,
    /// whichever comes first. True if the time was reached.
    ///
    /// # Errors
    /// [`EventDrivenError::InelasticCollapse`]; the engine then stands at the moment of collapse.
    /// [`EventDrivenError::NoCollisions`] and [`EventDrivenError::BadTime`] if the time cannot be
    /// reached.
    pub fn advance(
        &mut self,
        until: f64,
        most_collisions: u64,
        observer: &mut dyn Observer,
    ) -> Result<bool, EventDrivenError> {
        self.advance_with(&mut Alone, until, most_collisions, observer)
    }

    /// Advances the gas to the absolute time `until` \[time\], or by a number of collisions, with
    /// the parallel method `leaps` where it pays.
    pub(crate) fn advance_with(
        &mut self,
        leaps: &mut impl Leap<P, Q>,
        until: f64,
        most_collisions: u64,
        observer: &mut dyn Observer,
    ) -> Result<bool, EventDrivenError> {
        if until.is_nan() {
            return Err(EventDrivenError::BadTime { until });
        }
        let mut recorder = Recorder::new(observer);
        self.progress.reset_idle();
        let last = self.tally.collisions.saturating_add(most_collisions);
        while self.tally.collisions < last && !self.stop.has_ended() {
            if self.tally.collisions >= self.refresh || self.now >= self.horizon {
                leaps.drop_kept();
                self.rebase_epoch(until)?;
            }
            if self.advance_segment(leaps, until, last.min(self.refresh), &mut recorder)? {
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// Advances the gas until a time, the collision number `last`, or the next restart of the
    /// engine. True if the time was reached.
    fn advance_segment(
        &mut self,
        leaps: &mut impl Leap<P, Q>,
        until: f64,
        last: u64,
        recorder: &mut Recorder<'_>,
    ) -> Result<bool, EventDrivenError> {
        let goal = Goal {
            end: (until - self.epoch) * self.speed,
            ends: until.is_finite(),
            last,
        };
        let there = leaps.leap_towards(self, &goal, recorder) || {
            leaps.drop_kept();
            self.run_events(&goal, recorder)?
        };
        if there {
            // A gas without events stays where it is rather than move for an infinite time.
            if goal.ends {
                self.stop_at(until, goal.end)?;
            }
            return Ok(true);
        }
        self.time = self.present(until);
        Ok(false)
    }

    /// Executes events one by one up to a goal or to the next restart of the engine. True if no
    /// further event comes before the time of the goal.
    ///
    /// The result has the same bits on every processor: products and sums are never contracted.
    pub(crate) fn run_events(
        &mut self,
        goal: &Goal,
        recorder: &mut Recorder<'_>,
    ) -> Result<bool, EventDrivenError> {
        self.recall_events();
        if !P::Field::SHEARED {
            return self.run_between_steps(goal, recorder);
        }
        loop {
            let (step, seam) = self.disks.rows.next_step();
            let next = Goal {
                end: goal.end.min(step),
                ..*goal
            };
            if !self.run_between_steps(&next, recorder)? {
                return Ok(false);
            }
            if step > goal.end {
                return Ok(true);
            }
            if self.stop.ends() {
                return Ok(false);
            }
            self.now = self.now.max(step);
            self.step_rows(seam)?;
        }
    }

    /// Executes events one by one up to a goal before the next step of sliding rows, with the
    /// version of the loop for this processor.
    fn run_between_steps(
        &mut self,
        goal: &Goal,
        recorder: &mut Recorder<'_>,
    ) -> Result<bool, EventDrivenError> {
        #[cfg(target_arch = "x86_64")]
        if std::arch::is_x86_feature_detected!("avx2") {
            #[allow(unsafe_code, reason = "the compiler does not see the question before")]
            // SAFETY: the processor has these instructions.
            return unsafe { self.events_with_avx2(goal, recorder) };
        }
        self.events(goal, recorder)
    }

    /// Executes [`Self::events`] compiled for processors with AVX2, where instructions of three
    /// operands copy fewer numbers. Functions called here and not inlined must not return a pair,
    /// or the compiler inlines nothing.
    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2")]
    fn events_with_avx2(
        &mut self,
        goal: &Goal,
        recorder: &mut Recorder<'_>,
    ) -> Result<bool, EventDrivenError> {
        self.events(goal, recorder)
    }

    /// Executes events one by one up to a goal: the loop behind [`Self::run_events`].
    #[inline(always)]
    fn events(
        &mut self,
        goal: &Goal,
        recorder: &mut Recorder<'_>,
    ) -> Result<bool, EventDrivenError> {
        let &Goal { end, ends, last } = goal;
        let width = self.disks.cells.width();
        let logs = self.window.is_some();
        let mut events: u32 = 0;
        while self.tally.collisions < last && self.now < self.horizon {
            events = events.wrapping_add(1);
            if events.is_multiple_of(BETWEEN_LOOKS) && (self.stop.ends() || self.is_log_full()) {
                break;
            }
            let Some(entry) = self.calendar.pop(end, &self.disks) else {
                return Ok(true);
            };
            let disk = &self.disks.all[entry.disk as usize];
            // Had the disk left its cell before its contact, that would have come up before.
            if entry.time != disk.contact {
                let (exit, axis) = self.disks.motion.exit(disk, width);
                if entry.time != exit {
                    self.stale += 1;
                    continue;
                }
                debug_assert!(exit < disk.contact, "a contact was missed");
                self.now = entry.time;
                if logs {
                    self.log_before(entry.disk);
                }
                self.cross(entry.disk, axis)?;
                if logs {
                    self.log_after([entry.disk, NONE]);
                }
                continue;
            }
            self.now = entry.time;
            let (partner, partner_count) = (disk.partner, disk.partner_count);
            if logs {
                self.log_before(entry.disk);
            }
            let mut touched = [entry.disk, NONE];
            match self.disks.all.get(partner as usize) {
                Some(other) if other.count == partner_count => {
                    touched[1] = partner;
                    self.collide(entry.disk, partner, recorder)?;
                }
                Some(_) => {
                    self.tally.broken += 1;
                    self.enter_flight(entry.disk);
                    self.disks.advance(entry.disk, entry.time);
                    self.predict(entry.disk);
                }
                None => {
                    let what = partner - self.disks.all.len() as u32;
                    self.rebound(entry.disk, what, ends)?;
                }
            }
            if logs {
                self.log_after(touched);
            }
        }
        Ok(false)
    }

    /// Sets the clock to a time without an event; an error if disks would lose the precision of
    /// their positions by then.
    fn stop_at(&mut self, until: f64, end: f64) -> Result<(), EventDrivenError> {
        let moving = || self.disks.all.iter().any(|disk| disk.velocity.amax() > 0.0);
        let diameter = 2.0 * self.scene.sizes().largest_radius();
        // Only a disk that is alone can fly so far without an event.
        if end * f64::EPSILON > diameter && moving() {
            return Err(EventDrivenError::BadTime { until });
        }
        self.now = self.now.max(end);
        // The next event comes before a fresh start, as it would have without a stop.
        self.horizon = self.horizon.max(self.now.next_up());
        self.time = self.time.max(until);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Buckets;
    use crate::disk::tests::lattice;

    /// Both loops give the same bits, as far as the processor has both.
    #[test]
    fn both_loops_give_the_same_bits() {
        let (mut either, mut plain) = (lattice::<Buckets>(30), lattice::<Buckets>(30));
        let last = 50_000;
        let goal = Goal {
            end: f64::INFINITY,
            ends: false,
            last,
        };
        either
            .run_events(&goal, &mut Recorder::new(&mut ()))
            .expect("time");
        plain.recall_events();
        plain
            .events(&goal, &mut Recorder::new(&mut ()))
            .expect("time");
        assert_eq!(either.tally(), plain.tally());
        assert_eq!(either.tally().collisions, last);
        assert_eq!(either.state().bodies, plain.state().bodies);
    }
}
