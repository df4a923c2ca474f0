//! Logging of events in an engine that simulates one strip of a decomposed gas, for the comparison
//! with neighbouring strips.

use stosszahl_model::{ParticleModel, Plane, SpinOf};

use crate::calendar::Calendar;
use crate::cells::NONE;
use crate::collapse::ContactInfo;
use crate::engine::EventDrivenEngine;
use crate::record::{DiskRecord, VOID};
use crate::strip_log::{SEAM, SeamRecord, WallImpulse, above, mixed};

impl<P, Q> EventDrivenEngine<P, Q>
where
    P: ParticleModel<Space = Plane>,
    Q: Calendar,
{
    /// Returns true if the current time window of the strip has logged more contacts than its
    /// limit.
    pub(crate) fn has_most_contacts(&self) -> bool {
        let window = self.window.as_ref();
        window.is_some_and(|window| window.contacts.len() as u64 > window.most[1])
    }

    /// Returns true if the current time window of the strip has more events or contacts than its
    /// limit, so that the strip stops.
    pub(crate) fn is_log_full(&self) -> bool {
        let window = self.window.as_ref();
        self.has_most_contacts() || window.is_some_and(|window| window.events > window.most[0])
    }

    /// Stores the row of a disk and the work counters just before its event, in the log of the
    /// strip's time window.
    #[inline(always)]
    pub(crate) fn log_before(&mut self, disk: u32) {
        let row = self.disks.home(disk)[1];
        if let Some(window) = &mut self.window {
            window.near = window.is_near[usize::from(row)];
            window.owns = true;
            if window.near {
                window.tally = self.tally;
                window.row = i32::from(row);
                window.owns = window.place.owns(row);
            }
        }
    }

    /// Logs the disks that an event has changed, with their new states, in the log of the strip's
    /// time window.
    #[inline(always)]
    pub(crate) fn log_after(&mut self, changed: [u32; 2]) {
        if let Some(window) = &mut self.window {
            window.events += 1;
            if window.near {
                self.log_near(changed);
            } else {
                window.latest = self.now;
            }
        }
    }

    /// Logs an event so near the boundary of a strip that it may matter to the neighbouring strip:
    /// hashes by row, and records of changed disks in the rows next to the boundary.
    #[cold]
    #[inline(never)]
    fn log_near(&mut self, changed: [u32; 2]) {
        let Some(mut window) = self.window.take() else {
            return;
        };
        if window.owns {
            window.latest = self.now;
        } else {
            self.tally = window.tally;
            window.twice += 1;
        }
        let who = changed[0];
        let changed = changed.into_iter().filter(|&disk| disk != NONE);
        for disk in changed.clone() {
            let row = self.disks.home(disk)[1];
            window.is_foreign[usize::from(row)] |= !window.place.owns(row);
        }
        for edge in window.edges.iter_mut().flatten() {
            let above = |row: i32| above(row, edge.row, window.place.around);
            if let Ok(place) = usize::try_from(above(window.row) + window.place.halo)
                && let Some(sum) = edge.rows.get_mut(place)
            {
                *sum = mixed(mixed(*sum, self.now.to_bits()), u64::from(who));
            }
            for disk in changed.clone() {
                let row = above(i32::from(self.disks.home(disk)[1]));
                if (-SEAM..SEAM).contains(&row) {
                    let is_beyond = (row < 0) != (above(window.row) < 0);
                    edge.seam.push(self.trace(disk, is_beyond));
                }
            }
        }
        self.window = Some(window);
    }

    /// Logs a cell crossing of a disk in the core of a strip.
    #[cold]
    pub(crate) fn log_crossing(&mut self) {
        if let Some(window) = &mut self.window
            && window.owns
        {
            window.idle.push(self.now);
            window.idled += 1;
        }
    }

    /// Logs a collision of two disks in the core of a strip, with whether their approach was
    /// negligible.
    #[cold]
    pub(crate) fn log_contact(&mut self, latest: &ContactInfo, is_negligible: Option<bool>) {
        if let Some(window) = &mut self.window
            && window.owns
        {
            window.idle.clear();
            window.log(latest, is_negligible);
        }
    }

    /// Logs a contact of a disk with a wall or obstacle in the core of a strip. If the run has an
    /// end time (`ends`), it counts as progress.
    #[cold]
    pub(crate) fn log_rebound(
        &mut self,
        latest: &ContactInfo,
        is_negligible: Option<bool>,
        ends: bool,
        given: WallImpulse,
    ) {
        if let Some(window) = &mut self.window
            && window.owns
        {
            if ends {
                window.idle.clear();
            }
            window.idle.push(latest.now);
            window.idled += 1;
            window.log(latest, is_negligible);
            window.given.push(given);
        }
    }

    /// Returns the record of a disk after an event near a strip boundary: its current state for
    /// comparison with the neighbouring strip. With `is_beyond`, it includes a hash of the disks
    /// around.
    fn trace(&self, who: u32, is_beyond: bool) -> SeamRecord<SpinOf<P>> {
        let disk = &self.disks.all[who as usize];
        // A partner that has collided since may be anywhere, and counts as absent.
        let is_lost = |partner: &DiskRecord| partner.count != disk.partner_count;
        let partner = self.disks.all.get(disk.partner as usize);
        let (partner, partner_count) = if partner.is_some_and(is_lost) {
            (NONE, VOID)
        } else {
            (disk.partner, disk.partner_count)
        };
        SeamRecord {
            time: self.now,
            disk: who,
            home: disk.home,
            position: disk.position,
            velocity: disk.velocity,
            spin: self.spin(who),
            contact: disk.contact,
            partner,
            partner_count,
            count: disk.count,
            last_contact: self.last_contact.get(who as usize).copied(),
            rebounds: self.rebounds.get(who as usize).copied(),
            winding: self.image_flags.get(who as usize).copied(),
            candidates: if is_beyond {
                self.candidates_of(who)
            } else {
                0
            },
        }
    }

    /// Returns a hash of numbers and states of the disks in the 3 by 3 cells around a disk.
    fn candidates_of(&self, who: u32) -> u64 {
        self.disks.disks_around(who).fold(0, |sum, (number, disk)| {
            let real = [
                disk.position[0],
                disk.position[1],
                disk.velocity[0],
                disk.velocity[1],
                disk.clock,
                disk.contact,
            ];
            let real = real.map(f64::to_bits).into_iter();
            real.fold(mixed(sum, u64::from(number)), mixed)
        })
    }
}
