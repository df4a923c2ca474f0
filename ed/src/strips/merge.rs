//! What depends on the order of all events, from the logs of strips.

use stosszahl_model::{Collision, Physics, Plane, Recorder};

use super::window::{Contact, Edge, SEAM, Window};
use crate::calendar::Calendar;
use crate::cells::NONE;
use crate::engine::Engine;
use crate::progress::PATIENCE;

/// How far wrong events came into the halos at an edge, over the rows of a halo beyond the seam.
pub(super) fn entered<S>(lower: &Edge<S>, upper: &Edge<S>) -> f64 {
    let halo = lower.rows.len() / 2;
    let parts = |row: &usize| lower.rows[*row] != upper.rows[*row];
    // The upper strip is wrong far below the edge, and the lower one far above.
    let below = (0..halo).rev().find(parts).map_or(0, |row| row + 1);
    let above = (halo..2 * halo).find(parts).map_or(0, |row| 2 * halo - row);
    below.max(above) as f64 / (halo - SEAM as usize) as f64
}

/// The contacts of all strips, with the number of the strip, in the order of time; simultaneous ones by their disks.
struct InTime<'a> {
    next: Vec<std::slice::Iter<'a, Contact>>,
}

impl<'a> InTime<'a> {
    fn new<P: Physics>(windows: &[&'a Window<P>]) -> Self {
        let next = windows
            .iter()
            .map(|window| window.contacts.iter())
            .collect();
        Self { next }
    }
}

impl<'a> Iterator for InTime<'a> {
    type Item = (usize, &'a Contact);

    fn next(&mut self) -> Option<Self::Item> {
        let mut first: Option<(usize, &Contact)> = None;
        for (strip, next) in self.next.iter().enumerate() {
            let Some(contact) = next.as_slice().first() else {
                continue;
            };
            let is_first = first.is_none_or(|(_, best)| {
                contact.now < best.now
                    || (contact.now == best.now && contact.pair[0] < best.pair[0])
            });
            if is_first {
                first = Some((strip, contact));
            }
        }
        let (strip, contact) = first?;
        self.next[strip].next();
        Some((strip, contact))
    }
}

impl<P, Q> Engine<P, Q>
where
    P: Physics<Space = Plane>,
    Q: Calendar,
{
    /// Takes over what strips have done, but for their disks. False, and nothing is changed, if an engine alone would have stopped.
    pub(super) fn merge(
        &mut self,
        strips: &[Self],
        observed: &[Vec<Collision>],
        ends: bool,
        recorder: &mut Recorder<'_>,
    ) -> bool {
        let windows: Vec<&Window<P>> = (strips.iter())
            .filter_map(|strip| strip.window.as_deref())
            .collect();
        let idled: u64 = windows.iter().map(|window| window.idled).sum();
        if self.progress.idle() + idled > PATIENCE {
            return false;
        }
        let contacts = || InTime::new(&windows);
        let mut progress = self.progress.clone();
        let before = self.tally.contacts();
        let mut last = None;
        for (number, (strip, contact)) in contacts().enumerate() {
            // What is feeble is left to an engine alone.
            let latest = self.latest(contact.pair, contact.now);
            if progress.usual_collision(before + number as u64 + 1, &latest) {
                return false;
            }
            if ends || contact.pair[1] != NONE {
                last = Some((strip, contact.now));
            }
        }
        let idle = windows.iter().enumerate().map(|(strip, window)| {
            let counts = |time: &&f64| match last {
                Some((its, _)) if its == strip => true,
                Some((_, last)) => **time > last,
                None => true,
            };
            window.idle.iter().filter(counts).count() as u64
        });
        let before = if last.is_some() { 0 } else { progress.idle() };
        progress.set_idle(before + idle.sum::<u64>());
        self.progress = progress;

        if recorder.looks() {
            observe(contacts(), observed, recorder);
        }
        let mut given: Vec<_> = windows.iter().map(|window| window.given.iter()).collect();
        if given.iter().any(|given| given.len() > 0) {
            for (strip, contact) in contacts() {
                if contact.pair[1] == NONE
                    && let Some(given) = given[strip].next()
                {
                    self.account_for(given);
                }
            }
        }
        for strip in strips {
            self.tally.add(&strip.tally);
        }
        let latest = windows.iter().map(|window| window.latest);
        self.now = latest.fold(self.now, f64::max);
        true
    }
}

/// Shows the collisions of all strips to an observer.
fn observe(contacts: InTime<'_>, observed: &[Vec<Collision>], recorder: &mut Recorder<'_>) {
    let mut next: Vec<_> = observed.iter().map(|strip| strip.iter()).collect();
    for (strip, contact) in contacts {
        if contact.pair[1] != NONE
            && let Some(collision) = next[strip].next()
        {
            recorder.record(|| *collision);
        }
    }
}
