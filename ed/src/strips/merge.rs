//! Merge of the event logs of all strips in order of time: work counters, wall ledgers, signs of
//! collapse, and the collisions passed to observers.

use std::iter;

use stosszahl_model::threads::each_of;
use stosszahl_model::{Collision, ParticleModel, Plane, Recorder};

use crate::calendar::Calendar;
use crate::cells::NONE;
use crate::collapse::{CollapseDetector, PATIENCE};
use crate::engine::EventDrivenEngine;
use crate::strip_log::{LoggedContact, SEAM, StripEdge, StripLog};

/// Returns how far wrong events came into the halos at a boundary between two strips, as a fraction
/// of the halo beyond the row that both strips compare.
pub(super) fn entered<S>(lower: &StripEdge<S>, upper: &StripEdge<S>) -> f64 {
    let halo = lower.rows.len() / 2;
    let parts = |row: &usize| lower.rows[*row] != upper.rows[*row];
    // Wrong rows of the upper strip are far below the edge, those of the lower strip far above it.
    let below = (0..halo).rev().find(parts).map_or(0, |row| row + 1);
    let above = (halo..2 * halo).find(parts).map_or(0, |row| 2 * halo - row);
    below.max(above) as f64 / (halo - SEAM as usize) as f64
}

/// Approximate number of contacts in one span of time into which the logs are divided for sorting.
const PART: usize = 512;

/// Contact with the index of the strip in whose core it happened.
type Logged = (usize, LoggedContact);

/// Logged contacts of all strips, in spans of time. Mostly a few contacts are needed in order of
/// time: only their spans are sorted. Simultaneous contacts are ordered by their disks.
struct Logs<'a> {
    /// Part of each strip's log in each span of time; simultaneous contacts are in the same span.
    parts: Vec<Vec<&'a [LoggedContact]>>,
    /// Number of contacts before each span of time, and the total number at the end.
    begins: Vec<usize>,
}

impl<'a> Logs<'a> {
    fn new(logs: &[&'a [LoggedContact]]) -> Self {
        let all: usize = logs.iter().map(|log| log.len()).sum();
        let longest = logs.iter().max_by_key(|log| log.len());
        let longest = longest.copied().unwrap_or_default();
        let parts = 1 + all / PART;
        let times = (1..parts).map(|part| longest[longest.len() * part / parts].now);
        let times: Vec<f64> = iter::once(f64::NEG_INFINITY)
            .chain(times)
            .chain(iter::once(f64::INFINITY))
            .collect();
        let bounds: Vec<Vec<usize>> = each_of(true, times.iter(), |_, &time| {
            let before = |log: &&[LoggedContact]| log.partition_point(|its| its.now < time);
            logs.iter().map(before).collect()
        });
        let part = |bounds: &[Vec<usize>]| {
            let ranges = bounds[0].iter().zip(&bounds[1]);
            let ranges = ranges.map(|(begin, end)| *begin..*end);
            logs.iter()
                .zip(ranges)
                .map(|(log, its)| &log[its])
                .collect()
        };
        Self {
            parts: bounds.windows(2).map(part).collect(),
            begins: bounds.iter().map(|bound| bound.iter().sum()).collect(),
        }
    }

    fn len(&self) -> usize {
        self.begins[self.parts.len()]
    }

    /// Returns the logged contact of all strips with the given index in order of time.
    fn nth(&self, index: usize) -> LoggedContact {
        let number = self.begins.partition_point(|begin| *begin <= index) - 1;
        let (part, index) = (&self.parts[number], index - self.begins[number]);
        let times = part.iter().copied().flatten().map(|its| its.now);
        let mut times: Vec<f64> = times.collect();
        let time = *times.select_nth_unstable_by(index, f64::total_cmp).1;
        let mut before = 0;
        let simultaneous = part.iter().map(|log| {
            let begin = log.partition_point(|its| its.now < time);
            before += begin;
            &log[begin..log.partition_point(|its| its.now <= time)]
        });
        let simultaneous = merge_logs(simultaneous.collect());
        simultaneous[index - before].1
    }

    /// Returns the last contact in order of time for which `counts` is true, with the index of its
    /// strip.
    fn last(&self, counts: impl Fn(&LoggedContact) -> bool) -> Option<Logged> {
        let has_some =
            |part: &&Vec<&[LoggedContact]>| part.iter().any(|log| log.iter().any(&counts));
        let part = self.parts.iter().rev().find(has_some)?;
        let mut contacts = merge_logs(part.clone()).into_iter().rev();
        contacts.find(|(_, contact)| counts(contact))
    }

    /// Returns the contacts of all strips in order of time, sorted by all threads, one list for
    /// each span.
    fn merge_contacts(&self) -> Vec<Vec<Logged>> {
        each_of(true, self.parts.iter(), |_, part| merge_logs(part.clone()))
    }
}

/// Merges the logs of several strips into one list in order of time.
fn merge_logs(mut logs: Vec<&[LoggedContact]>) -> Vec<Logged> {
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

/// Adds counters, ledgers and collisions of all strips to the engine of the whole gas. Returns
/// false and changes nothing if the engine alone would have stopped, as at a collapse.
pub(super) fn merge<P: ParticleModel<Space = Plane>, Q: Calendar>(
    whole: &mut EventDrivenEngine<P, Q>,
    strips: &[EventDrivenEngine<P, Q>],
    observed: &[Vec<Collision>],
    ends: bool,
    recorder: &mut Recorder<'_>,
) -> bool {
    let windows: Vec<&StripLog<P>> = (strips.iter())
        .filter_map(|strip| strip.window.as_deref())
        .collect();
    let idled: u64 = windows.iter().map(|window| window.idled).sum();
    if whole.progress.idle() + idled > PATIENCE {
        return false;
    }
    let logs: Vec<_> = windows.iter().map(|its| &its.contacts[..]).collect();
    let logs = Logs::new(&logs);
    let mut progress = whole.progress.clone();
    let before = whole.tally.contacts();
    let counts: Vec<u64> =
        CollapseDetector::counts(before + 1, before + logs.len() as u64).collect();
    let contact = |_, &number: &u64| (number, logs.nth((number - before - 1) as usize));
    for (number, contact) in each_of(true, counts.iter(), contact) {
        // Negligible approach speeds need a single engine.
        let latest = whole.latest(contact.pair, contact.now);
        if progress.usual_collision(number, &latest) {
            return false;
        }
    }
    let last = logs.last(|contact| ends || contact.pair[1] != NONE);
    let idle = windows.iter().enumerate().map(|(strip, window)| {
        let counts = |time: &&f64| match last {
            Some((its, _)) if its == strip => true,
            Some((_, last)) => **time > last.now,
            None => true,
        };
        window.idle.iter().filter(counts).count() as u64
    });
    let before = if last.is_some() { 0 } else { progress.idle() };
    progress.set_idle(before + idle.sum::<u64>());
    whole.progress = progress;

    let mut given: Vec<_> = windows.iter().map(|window| window.given.iter()).collect();
    let gives = given.iter().any(|given| given.len() > 0);
    if recorder.looks() || gives {
        let contacts = logs.merge_contacts();
        let contacts = contacts.iter().flatten();
        if recorder.looks() {
            pass_collisions(contacts.clone(), observed, recorder);
        }
        for (strip, contact) in contacts {
            if contact.pair[1] == NONE
                && let Some(given) = given[*strip].next()
            {
                whole.account_for(given);
            }
        }
    }
    for strip in strips {
        whole.tally.add(&strip.tally);
        whole.stale += strip.stale;
    }
    let latest = windows.iter().map(|window| window.latest);
    whole.now = latest.fold(whole.now, f64::max);
    true
}
/// Passes the collisions of all strips to an observer, in order of time.
fn pass_collisions<'a>(
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

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_xoshiro::Xoshiro256PlusPlus;

    /// Contacts found among many, some of them simultaneous, are those of a merge of all at once.
    #[test]
    fn contacts_are_found_where_merging_puts_them() {
        let mut stream = Xoshiro256PlusPlus::seed_from_u64(11);
        for (strips, most, times) in [(1, 20, 5), (2, 5000, 400), (3, 2000, 9), (4, 3, 100)] {
            let logs: Vec<Vec<LoggedContact>> = (0..strips)
                .map(|strip| {
                    let count = stream.random_range(0..most);
                    let mut times: Vec<u32> =
                        (0..count).map(|_| stream.random_range(0..times)).collect();
                    times.sort_unstable();
                    let contact = |(number, &time): (usize, &u32)| {
                        let disk = (strips * number + strip) as u32 ^ 1;
                        let partner = if time % 7 == 0 { disk } else { NONE };
                        LoggedContact {
                            now: f64::from(time),
                            pair: [disk, partner],
                        }
                    };
                    times.iter().enumerate().map(contact).collect()
                })
                .collect();
            let logs: Vec<&[LoggedContact]> = logs.iter().map(Vec::as_slice).collect();
            let all = merge_logs(logs.clone());
            let found = Logs::new(&logs);
            assert_eq!(found.len(), all.len());
            assert_eq!(found.merge_contacts().concat(), all);
            for (index, (_, contact)) in all.iter().enumerate() {
                assert_eq!(found.nth(index), *contact);
            }
            for counts in [
                |_: &LoggedContact| true,
                |its: &LoggedContact| its.pair[1] != NONE,
            ] {
                let last = all.iter().rev().find(|(_, contact)| counts(contact));
                assert_eq!(found.last(counts), last.copied());
            }
        }
    }
}
