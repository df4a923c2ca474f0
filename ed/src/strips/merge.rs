//! What depends on the order of all events, from the logs of strips.

use std::iter;

use rayon::prelude::*;
use stosszahl_model::{Collision, Physics, Plane, Recorder};

use super::window::{Contact, Edge, SEAM, Window};
use crate::calendar::Calendar;
use crate::cells::NONE;
use crate::engine::Engine;
use crate::progress::{PATIENCE, Progress};

/// How far wrong events came into the halos at an edge, over the rows of a halo beyond the seam.
pub(super) fn entered<S>(lower: &Edge<S>, upper: &Edge<S>) -> f64 {
    let halo = lower.rows.len() / 2;
    let parts = |row: &usize| lower.rows[*row] != upper.rows[*row];
    // The upper strip is wrong far below the edge, and the lower one far above.
    let below = (0..halo).rev().find(parts).map_or(0, |row| row + 1);
    let above = (halo..2 * halo).find(parts).map_or(0, |row| 2 * halo - row);
    below.max(above) as f64 / (halo - SEAM as usize) as f64
}

/// Contacts that a thread merges at a time.
const PART: usize = 4096;

/// A contact, and the strip in whose core it was.
type Logged = (usize, Contact);

/// The contacts of all strips in the order of time, simultaneous ones by their disks; in parts, which threads merge side by side.
fn in_time<P: Physics>(windows: &[&Window<P>]) -> Vec<Vec<Logged>> {
    let logs = || windows.iter().map(|window| window.contacts.as_slice());
    let longest = logs().max_by_key(|log| log.len()).unwrap_or_default();
    let parts = 1 + logs().map(<[_]>::len).sum::<usize>() / PART;
    // Simultaneous contacts are in the same part.
    let times = (1..parts).map(|part| longest[longest.len() * part / parts].now);
    let begins = |time: f64| logs().map(move |log| log.partition_point(|its| its.now < time));
    let begins: Vec<Vec<usize>> = iter::once(vec![0; windows.len()])
        .chain(times.map(|time| begins(time).collect()))
        .chain(iter::once(logs().map(<[_]>::len).collect()))
        .collect();
    let part = |bounds: &[Vec<usize>]| {
        let range = |(begin, end): (&usize, &usize)| *begin..*end;
        let ranges = bounds[0].iter().zip(&bounds[1]).map(range);
        merged(logs().zip(ranges).map(|(log, range)| &log[range]).collect())
    };
    begins.par_windows(2).map(part).collect()
}

/// Logs as one.
fn merged(mut logs: Vec<&[Contact]>) -> Vec<Logged> {
    let mut all = Vec::with_capacity(logs.iter().map(|log| log.len()).sum());
    loop {
        let mut first: Option<Logged> = None;
        for (strip, log) in logs.iter().enumerate() {
            let Some(&contact) = log.first() else {
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
        let Some(first) = first else {
            return all;
        };
        logs[first.0] = &logs[first.0][1..];
        all.push(first);
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
        let contacts = in_time(&windows);
        let mut progress = self.progress.clone();
        let before = self.tally.contacts();
        // Where each part begins, and where the last ends.
        let mut begins = vec![0];
        begins.extend(contacts.iter().scan(0, |end, part| {
            *end += part.len();
            Some(*end)
        }));
        let all = begins[contacts.len()] as u64;
        for number in Progress::counts(before + 1, before + all) {
            let index = (number - before - 1) as usize;
            let part = begins.partition_point(|begin| *begin <= index) - 1;
            let (_, contact) = contacts[part][index - begins[part]];
            // What is feeble is left to an engine alone.
            let latest = self.latest(contact.pair, contact.now);
            if progress.usual_collision(number, &latest) {
                return false;
            }
        }
        let contacts = || contacts.iter().flatten();
        let last = contacts()
            .rev()
            .find(|(_, contact)| ends || contact.pair[1] != NONE)
            .map(|(strip, contact)| (*strip, contact.now));
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
                    && let Some(given) = given[*strip].next()
                {
                    self.account_for(given);
                }
            }
        }
        for strip in strips {
            self.tally.add(&strip.tally);
            self.stale += strip.stale;
        }
        let latest = windows.iter().map(|window| window.latest);
        self.now = latest.fold(self.now, f64::max);
        true
    }
}

/// Shows the collisions of all strips to an observer.
fn observe<'a>(
    contacts: impl Iterator<Item = &'a Logged>,
    observed: &[Vec<Collision>],
    recorder: &mut Recorder<'_>,
) {
    let mut next: Vec<_> = observed.iter().map(|strip| strip.iter()).collect();
    for (strip, contact) in contacts {
        if contact.pair[1] != NONE
            && let Some(collision) = next[*strip].next()
        {
            recorder.record(|| *collision);
        }
    }
}
