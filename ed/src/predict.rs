//! What happens to a disk next, and its way from cell to cell.

use stosszahl_model::{Physics, Plane, Sizes};

use crate::calendar::{Agenda, Calendar, Entry};
use crate::cells::NONE;
use crate::engine::Engine;
use crate::error::EngineError;
use crate::surroundings::Approach;

impl<P, Q> Engine<P, Q>
where
    P: Physics<Space = Plane>,
    Q: Calendar,
{
    /// Improves the predicted contact of a disk, which is up to date, by those with disks in the cells
    /// around it, as [`Disks::search`].
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

    /// Improves the predicted contact of a disk, which is up to date, by those with walls and obstacles.
    #[inline(always)]
    fn look_at_surroundings(&mut self, who: u32) {
        if !self.surroundings.is_empty() {
            self.look_at_what_is_near(who);
        }
    }

    fn look_at_what_is_near(&mut self, who: u32) {
        let cells = &self.disks.cells;
        let disk = &self.disks.all[who as usize];
        // From the next cell it looks again.
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

    /// Predicts the next contact of a disk that is up to date, from nothing.
    pub(crate) fn look_around(&mut self, who: u32) {
        let disk = &mut self.disks.all[who as usize];
        disk.contact = f64::INFINITY;
        disk.partner = NONE;
        self.search(who, None);
    }

    /// Predicts the next contact of a disk that is up to date, from nothing, and files it.
    pub(crate) fn predict(&mut self, who: u32) {
        // The search for two is faster even where it does the same for one twice.
        let sizes = self.scene.sizes();
        if let Some(predictions) = self.disks.search_both(who, who, sizes, &self.tags) {
            self.tally.predictions += predictions / 2;
            self.look_at_surroundings(who);
        } else {
            self.look_around(who);
        }
        self.schedule(who);
    }

    /// Predicts the next contacts of two disks that have just collided.
    #[inline]
    pub(crate) fn predict_both(&mut self, first: u32, second: u32) {
        let sizes = self.scene.sizes();
        if let Some(predictions) = self.disks.search_both(first, second, sizes, &self.tags) {
            self.tally.predictions += predictions;
            self.look_at_surroundings(first);
            self.look_at_surroundings(second);
            self.schedule(first);
            self.schedule(second);
        } else {
            self.predict(first);
            self.predict(second);
        }
    }

    #[inline]
    fn schedule(&mut self, who: u32) {
        let time = self.disks.time(who);
        if time.is_finite() {
            self.tally.pushes += 1;
            self.calendar.push(Entry { time, disk: who });
        }
    }

    /// Moves a disk into the next cell and looks at what comes into its reach.
    pub(crate) fn cross(&mut self, who: u32, axis: usize) -> Result<(), EngineError> {
        self.tally.crossings += 1;
        let (forward, around) = self.disks.cross(who, axis, self.now);
        if around {
            if !self.domain.is_periodic(axis) {
                return Err(self.escaped(who, axis, forward));
            }
            if let Some(winding) = self.windings.get_mut(who as usize) {
                winding[axis] = winding[axis].wrapping_add(if forward { 1 } else { -1 });
            }
        }
        self.search(who, Some((axis, forward)));
        self.schedule(who);
        if let Some(crossings) = self.progress.crossing(self.names.len()) {
            self.time = self.epoch + self.now / self.speed;
            return Err(EngineError::NoCollisions {
                time: self.time,
                crossings,
            });
        }
        Ok(())
    }
}
