//! Prediction of the next event of a disk, its next contact or cell crossing, and execution of cell
//! crossings.

use stosszahl_model::{ParticleModel, Plane, Sizes};

use crate::calendar::{Calendar, CalendarEntry, EventTimes};
use crate::cells::NONE;
use crate::engine::EventDrivenEngine;
use crate::error::EventDrivenError;
use crate::sliding_rows::Seam;
use crate::surroundings::Approach;

impl<P, Q> EventDrivenEngine<P, Q>
where
    P: ParticleModel<Space = Plane>,
    Q: Calendar,
{
    /// Searches for an earlier contact of a disk than its predicted one: with disks in the cells
    /// around, walls and obstacles. With `beyond`, only the cells ahead along an axis. The disk
    /// must be advanced to the current time.
    #[inline(always)]
    pub(crate) fn search(&mut self, who: u32, beyond: Option<(usize, bool)>) {
        self.tally.predictions += self.disks.search(
            &mut self.candidates,
            who,
            beyond,
            self.scene.sizes(),
            &self.tags,
        );
        self.look_at_surroundings(who);
    }

    /// Searches for an earlier contact of a disk with walls and obstacles than its predicted
    /// contact. The disk must be advanced to the current time.
    #[inline(always)]
    pub(crate) fn look_at_surroundings(&mut self, who: u32) {
        if !self.surroundings.is_empty() {
            self.look_at_what_is_near(who);
        }
    }

    fn look_at_what_is_near(&mut self, who: u32) {
        let cells = &self.disks.cells;
        let disk = &self.disks.all[who as usize];
        // The disk searches again from the next cell.
        let exit = self.disks.motion.exit(disk, cells.width()).0;
        let approach = Approach {
            home: self.disks.home(who),
            position: disk.position,
            velocity: disk.velocity,
            acceleration: self.disks.motion.acceleration(),
            radius: self.scene.sizes().radius(self.tags[who as usize]),
            clock: disk.clock,
            limit: disk.contact.min(exit) - disk.clock,
        };
        if let Some((wait, what)) = self.surroundings.first_contact(cells, &approach) {
            let partner = self.disks.all.len() as u32 + what;
            let disk = &mut self.disks.all[who as usize];
            disk.contact = disk.clock + wait.max(0.0);
            disk.partner = partner;
        }
    }

    /// Predicts the next contact of a disk without regard to an earlier prediction. The disk must
    /// be advanced to the current time.
    pub(crate) fn predict_from_scratch(&mut self, who: u32) {
        self.disks.expect_contact(who, f64::INFINITY, NONE);
        self.search(who, None);
    }

    /// Predicts the next contact of a disk without regard to an earlier prediction, and puts its
    /// next event into the calendar. Called so rarely that it is not compiled twice.
    #[inline(never)]
    pub(crate) fn predict(&mut self, who: u32) {
        // The pair search is faster, even where both of its places hold one disk.
        let sizes = self.scene.sizes();
        if let Some(predictions) = self.disks.predict_pair(who, who, sizes, &self.tags) {
            self.tally.predictions += predictions / 2;
            self.look_at_surroundings(who);
        } else {
            self.predict_from_scratch(who);
        }
        self.push_event(who);
    }

    /// Predicts the next contacts of two disks that have just collided, and puts their next events
    /// into the calendar.
    #[inline(always)]
    pub(crate) fn predict_both(&mut self, first: u32, second: u32) {
        let sizes = self.scene.sizes();
        if let Some(predictions) = self.disks.predict_pair(first, second, sizes, &self.tags) {
            self.tally.predictions += predictions;
            self.look_at_surroundings(first);
            self.look_at_surroundings(second);
            self.push_event(first);
            self.push_event(second);
        } else {
            self.predict(first);
            self.predict(second);
        }
    }

    #[inline(always)]
    fn push_event(&mut self, who: u32) {
        let time = self.disks.time(who);
        self.tally.pushes += u64::from(time.is_finite());
        self.calendar.push(CalendarEntry { time, disk: who });
    }

    /// Moves the rows of cells that slide in a shear flow on by one cell, and searches the cells
    /// that come into reach for new contacts.
    pub(crate) fn step_rows(&mut self, seam: Seam) -> Result<(), EventDrivenError> {
        self.disks.rows.step(seam);
        let columns = self.disks.cells.counts()[0];
        let mut disks = Vec::new();
        for row in self.disks.rows.rows_below(seam) {
            for column in 0..columns {
                let home = [column, row];
                let mut who = self.disks.cells.first(self.disks.cells.place(home, 1, 1));
                if who == NONE || !self.disks.has_newest(home, self.now) {
                    continue;
                }
                disks.clear();
                while who != NONE {
                    disks.push(who);
                    who = self.disks.all[who as usize].next;
                }
                for &who in &disks {
                    self.enter_flight(who);
                    self.disks.advance(who, self.now);
                    let (sizes, candidates) = (self.scene.sizes(), &mut self.candidates);
                    self.tally.predictions +=
                        self.disks.search_newest(candidates, who, sizes, &self.tags);
                    self.push_event(who);
                }
            }
        }
        self.count_crossing()
    }

    /// Counts a cell crossing of a disk; an error if there were too many since the last collision.
    #[inline(always)]
    fn count_crossing(&mut self) -> Result<(), EventDrivenError> {
        if let Some(crossings) = self.progress.crossing(self.names.len()) {
            self.time = self.epoch + self.now / self.speed;
            return Err(EventDrivenError::NoCollisions {
                time: self.time,
                crossings,
            });
        }
        Ok(())
    }

    /// Executes a cell crossing: moves a disk into the next cell along `axis`, searches the cells
    /// that come into reach, and puts its next event into the calendar.
    #[inline(always)]
    pub(crate) fn cross(&mut self, who: u32, axis: usize) -> Result<(), EventDrivenError> {
        self.tally.crossings += 1;
        self.enter_flight(who);
        let (forward, around) = self.disks.cross(who, axis, self.now);
        if around {
            if !self.domain.is_periodic(axis) {
                return Err(self.escaped(who, axis, forward));
            }
            if let Some(winding) = self.image_flags.get_mut(who as usize) {
                winding[axis] = winding[axis].wrapping_add(if forward { 1 } else { -1 });
            }
        }
        self.search(who, Some((axis, forward)));
        self.push_event(who);
        if self.window.is_some() {
            self.log_crossing();
            return Ok(());
        }
        self.count_crossing()
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::vector;

    use crate::disk::tests::{gas, lattice};
    use crate::{Buckets, time_to_contact};

    use super::*;

    /// Of two disks in adjacent cells that will touch before either leaves its cell, one has this
    /// contact as its next, or an earlier one. Tested at 400 times of a gas; times of some tens are
    /// rounded to 1e-14.
    #[test]
    fn every_contact_is_known_or_will_be() {
        let mut engine = lattice::<Buckets>(12);
        let (mut known, mut left) = (0, 0);
        for _ in 0..400 {
            engine.advance(f64::INFINITY, 7, &mut ()).expect("time");
            let (disks, now) = (&engine.disks, engine.now);
            let width = disks.cells.width();
            let leaves = |who: usize| disks.motion.exit(&disks.all[who], width).0 - now;
            let count = disks.all.len();
            for (one, other) in (0..count).flat_map(|one| (0..one).map(move |other| (one, other))) {
                let (a, b) = (&disks.all[one], &disks.all[other]);
                let shift = disks.cells.corner_offset(a.home, b.home);
                if (shift.component_div(&width)).amax() > 1.5 {
                    continue;
                }
                let separation =
                    disks.motion.position_at(a, now) - disks.motion.position_at(b, now) + shift;
                let least = leaves(one).min(leaves(other));
                let Some(wait) = time_to_contact(separation, a.velocity - b.velocity, 1.0, least)
                else {
                    continue;
                };
                let first = a.contact.min(b.contact) - now;
                assert!(first <= wait + 1e-12, "{one} and {other}: {first} {wait}");
                known += u32::from(first > wait - 1e-12);
                left += u32::from(first <= wait - 1e-12);
            }
        }
        assert!(known > 5_000 && left > 3_000, "{known} {left}");
    }

    /// A disk falls towards one that a third hits before, or does not.
    #[test]
    fn a_contact_later_than_the_others_own_is_left_to_it() {
        for (velocity, left) in [(-1.0, true), (1.0, false)] {
            let bodies = [
                (vector![10.0, 10.0], vector![0.0, 0.0]),
                (vector![12.0, 10.0], vector![velocity, 0.0]),
                (vector![9.9, 13.0], vector![0.0, -1.0]),
            ];
            let mut engine = gas::<Buckets>(20.0, bodies);
            let disk = |name: u32| engine.names.iter().position(|&its| its == name);
            let [hit, falls] = [0, 2].map(|name| disk(name).expect("a disk") as u32);
            engine.predict_from_scratch(falls);
            let partner = engine.disks.all[falls as usize].partner;
            assert_eq!(partner, if left { NONE } else { hit });
            let known = engine.disks.all[hit as usize].contact.is_finite();
            assert!(known || !left);
        }
    }

    /// The joint search gives to two disks that part what the search for one gives to each, bit by
    /// bit.
    #[test]
    fn two_at_a_time_are_as_one_by_one() {
        let mut engine = lattice::<Buckets>(12);
        let mut compared = 0;
        for round in 0..2000_u32 {
            engine.advance(f64::INFINITY, 3, &mut ()).expect("time");
            let before = engine.checkpoint();
            let first = round % 144;
            let disks = &engine.disks;
            let second = (0..144).find(|&other| {
                let shift = disks
                    .cells
                    .corner_offset(disks.home(first), disks.home(other));
                let [one, two] = [first, other].map(|who| &disks.all[who as usize]);
                let separation = disks.motion.position_at(one, engine.now)
                    - disks.motion.position_at(two, engine.now)
                    + shift;
                shift.component_div(&disks.cells.width()).amax() < 1.5
                    && separation.dot(&(one.velocity - two.velocity)) > 0.0
            });
            let Some(second) = second else { continue };
            let pair = [first, second];
            let forget = |engine: &mut EventDrivenEngine<_, _>| {
                for who in pair {
                    engine.disks.advance(who, engine.now);
                    engine.disks.expect_contact(who, f64::INFINITY, NONE);
                }
            };
            let contact = |engine: &EventDrivenEngine<_, Buckets>, who: u32| {
                let disk = &engine.disks.all[who as usize];
                (disk.contact.to_bits(), disk.partner)
            };
            forget(&mut engine);
            let sizes = engine.scene.sizes();
            let found = engine
                .disks
                .predict_pair(first, second, sizes, &engine.tags);
            assert!(found.is_some());
            let both = pair.map(|who| contact(&engine, who));
            for (who, both) in pair.into_iter().zip(both) {
                forget(&mut engine);
                engine.search(who, None);
                assert_eq!(contact(&engine, who), both);
                compared += u32::from(both.1 != NONE);
            }
            engine =
                EventDrivenEngine::new(engine.scene, engine.dissipation, before).expect("a state");
        }
        assert!(compared > 1000, "{compared}");
    }
}
