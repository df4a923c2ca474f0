//! One gas on many processors, with the bytes of one.
//!
//! The box is cut into strips of rows of cells. Each thread simulates one strip and a halo of rows on each side, alone, for a window of
//! time, from a copy. What comes in through the outer edge of a halo is missing, so that its events are wrong, first
//! there, then farther in. When all strips have reached the end of the window, the histories of neighbours are compared event by event in a seam
//! of four rows at the edge between them. Where they agree, the events of the rows below the edge in one strip and above it in the other
//! together are those of one engine for the whole gas; where they do not, the window is done again, shorter.
//!
//! *Why that is exact.* An event changes and reads disks at most two rows from its own, as a disk looks for partners in the
//! cells next to its own and next to those of the partner that it has just met. Join the lower strip's history below the seam, that of
//! both in it, and the upper strip's above it. Each event in this whole was computed by a strip from what the whole has in the rows that
//! the event read: below the seam and in its lower half by the lower strip, which has these rows right if it has the seam right, and above that by
//! the upper one. So the first event at which the whole could part from the history of one engine does not exist. Disks keep their order
//! in each strip, so that simultaneous events come in the same order.
//!
//! What depends on the order of all events (observers, accounts of walls, signs of collapse) is fed from logs that are merged by time.
//! Whatever is unusual in a window, be it an error, an interrupt or the end of a budget, makes the engine drop the window and go on alone.
//!
//! The method has no bound of speeds in it, which dense gases would not obey: there, news travel at the speed of sound. The
//! length of windows follows from how far wrong events have come into the halos.

mod cut;
mod merge;
mod window;

use rayon::prelude::*;
use stosszahl_model::{Collision, Observer, Physics, Plane, Recorder};

use crate::calendar::{Calendar, rate};
use crate::engine::Engine;
use crate::events::Goal;
use cut::Place;
use window::SEAM;
pub(crate) use window::{Given, Window};

/// Rows in a halo at the least: the seam, and as many again as wrong events may come into.
const LEAST_HALO: i32 = 6;

/// Cost of a window, in collisions of each disk: cutting, logs, calendars.
const COST: f64 = 0.06;

/// Collisions of each disk in a window, for each row of the halo beyond the seam: the first guess, and the least that pays in all.
const FIRST_REACH: f64 = 0.02;
const WORTH: f64 = 0.08;

/// Share of these rows that wrong events may enter; most growth from a window to the next.
const ENTERED: f64 = 0.6;
const GROWTH: f64 = 1.3;

/// What is left of it after a window that was wrong, and how many of these in a row are enough.
const AFTER_WRONG: f64 = 0.6;
const MOST_RETRIES: u32 = 8;

/// Most collisions in a window for each disk: they are logged.
const MOST_LOGGED: f64 = 4.0;
const MOST_OBSERVED: f64 = 1.0;

/// Share of the collisions that are left, less some standard deviations, that a window aims at.
const AIM: f64 = 0.99;
const DEVIATIONS: f64 = 5.0;

/// How a gas is spread over threads, and what came of it. Nothing in a result depends on it.
#[derive(Clone, Copy, Debug, Default)]
pub struct Spread {
    /// Strips, each for a thread; fewer than two are none.
    pub strips: usize,
    /// Windows that were kept.
    pub windows: u64,
    /// Windows that were done again, as histories did not agree.
    pub retries: u64,
    /// Events in the windows that were kept, each once.
    pub events: u64,
    /// Events in them that were simulated by a neighbour too.
    pub twice: u64,
    /// Events in windows that were not kept.
    pub lost: u64,
    /// Collisions of each disk that a window may have for each row of the halo beyond the seam; 0 if not known yet.
    reach: f64,
}

/// What came of a window.
enum Outcome {
    /// It is right, and wrong events came this far into a halo.
    Kept(f64),
    /// Wrong events came through a halo.
    Wrong,
    /// More collisions than were wanted.
    TooMany,
    /// Something that an engine alone has to see.
    Unusual,
}

/// Keeps all collisions.
struct Keep {
    looks: bool,
    all: Vec<Collision>,
}

impl Observer for Keep {
    fn looks(&self) -> bool {
        self.looks
    }

    fn collisions(&mut self, batch: &[Collision]) {
        self.all.extend_from_slice(batch);
    }
}

impl<P, Q> Engine<P, Q>
where
    P: Physics<Space = Plane>,
    Q: Calendar,
{
    /// Spreads the gas over this many strips, one for each thread of the present thread pool, if it is large enough. The bytes of
    /// all results are those of one strip.
    pub fn spread_over(&mut self, strips: usize) {
        self.spread.strips = strips;
    }

    /// What spreading has cost so far.
    pub fn spread(&self) -> Spread {
        self.spread
    }

    /// The rows of each strip, if the box has enough. The wider the halo, the longer a window may be, and the more is done twice: the
    /// cost 2 h/H + c/(k (h - s)) of strips of H rows is least at h = s + sqrt(c H/2k).
    fn places(&self) -> Option<Vec<Place>> {
        let cells = &self.disks.cells;
        let rows = i32::from(cells.counts()[1]);
        let strips = self.spread.strips.min(usize::from(u8::MAX)) as i32;
        if self.disks.hierarchical() || cells.narrow() {
            return None;
        }
        let least = rows / strips;
        let best = (COST * f64::from(least) / (2.0 * self.spread.reach)).sqrt();
        // No row is in more than two strips, and none twice in one.
        let most = least / 2 - SEAM;
        if most < LEAST_HALO {
            return None;
        }
        let halo = (SEAM + best.min(1e6) as i32).clamp(LEAST_HALO, most);
        let around = cells.is_periodic(1).then_some(rows);
        let place = |number: i32| {
            let edge =
                |number: i32| (i64::from(rows) * i64::from(number) / i64::from(strips)) as i32;
            let has = |side: bool| around.is_some() || side;
            Place {
                core: edge(number)..edge(number + 1),
                halo,
                neighbours: [has(number > 0), has(number < strips - 1)],
                around,
            }
        };
        Some((0..strips).map(place).collect())
    }

    /// Goes towards a goal in strips, as far as that pays.
    pub(crate) fn leap(&mut self, goal: &Goal, recorder: &mut Recorder<'_>) {
        if ((goal.last - self.tally.collisions) as f64) < WORTH * self.names.len() as f64 {
            return;
        }
        if self.spread.reach == 0.0 {
            self.spread.reach = FIRST_REACH;
        }
        let end = goal.end.min(self.horizon.next_down());
        let mut rate = self.rate_to_come();
        let mut strips: Vec<Self> = Vec::new();
        let mut spare: Vec<Self> = Vec::new();
        let (mut now, mut retries) = (self.now, 0);
        while retries < MOST_RETRIES
            && now < end
            && let Some(places) = self.places()
            && let Some(window) = self.window(&places[0], goal.last, rate, end - now, recorder)
        {
            let until = if window < end - now {
                now + window
            } else {
                end
            };
            let left = goal.last - self.tally.collisions;
            let most = [self.most_events(places.len()), left];
            let looks = recorder.looks();
            let mut old: Vec<Option<Self>> = spare.drain(..).map(Some).collect();
            old.resize_with(places.len(), || None);
            let run = |(place, spare): (&Place, Option<Self>)| {
                let mut keep = Keep {
                    looks,
                    all: Vec::new(),
                };
                let mut strip = cut::strip(&*self, &strips, place, now, most, spare);
                let goal = Goal {
                    end: until,
                    ends: goal.ends,
                    last: u64::MAX,
                };
                let ended = strip.run(&goal, &mut Recorder::new(&mut keep));
                let ended = ended.unwrap_or(false) || strip.has_most_contacts();
                ((strip, keep.all), ended)
            };
            let done: Vec<_> = places.par_iter().zip(old).map(run).collect();
            let (done, ended): (Vec<_>, Vec<bool>) = done.into_iter().unzip();
            let (done, observed): (Vec<_>, Vec<_>) = done.into_iter().unzip();
            let outcome = if ended.contains(&false) {
                Outcome::Unusual
            } else {
                Self::examine(&done, left)
            };
            rate = self
                .learn(&outcome, &done, [now, until], places[0].halo)
                .unwrap_or(rate);
            match outcome {
                Outcome::Kept(_) if self.merge(&done, &observed, goal.ends, recorder) => {
                    if strips.is_empty() {
                        cut::empty(self);
                    }
                    spare = std::mem::replace(&mut strips, done);
                    (now, retries) = (until, 0);
                }
                Outcome::Wrong | Outcome::TooMany => {
                    spare = done;
                    retries += 1;
                }
                _ => break,
            }
        }
        drop(spare);
        if !strips.is_empty() {
            cut::join(self, strips);
            self.calendar = Q::new(&self.disks, now);
        }
    }

    /// Events of a strip that are too many for a gas that goes on as usual.
    fn most_events(&self, strips: usize) -> u64 {
        200 * (self.names.len() / strips) as u64 + 1_000_000
    }

    /// Collisions in the unit of own time, within a factor of two, from the contacts that are known now.
    fn rate_to_come(&self) -> f64 {
        let contacts = self.disks.all.iter().map(|disk| disk.contact - self.now);
        let waits: Vec<f64> = contacts.filter(|wait| wait.is_finite()).collect();
        if waits.is_empty() {
            return 0.0;
        }
        // Both of two disks may know.
        0.75 * rate(waits)
    }

    /// Length of the next window, in own time, within what is left; `None` if it does not pay.
    fn window(
        &self,
        place: &Place,
        last: u64,
        rate: f64,
        left: f64,
        recorder: &Recorder<'_>,
    ) -> Option<f64> {
        let disks = self.names.len() as f64;
        let to_go = (last - self.tally.collisions) as f64;
        let logged = if recorder.looks() {
            MOST_OBSERVED
        } else {
            MOST_LOGGED
        };
        let collisions = (self.spread.reach * f64::from(place.halo - SEAM))
            .min(logged)
            .min(AIM * (to_go - DEVIATIONS * to_go.sqrt()) / disks)
            .min(left * rate / disks);
        (collisions >= WORTH && rate.is_finite()).then(|| collisions * disks / rate)
    }

    /// Compares the histories of neighbours.
    fn examine(strips: &[Self], left: u64) -> Outcome {
        let windows: Vec<&Window<P>> = strips
            .iter()
            .filter_map(|strip| strip.window.as_deref())
            .collect();
        if strips.iter().any(|strip| strip.disks.recounts > 0) {
            return Outcome::Unusual;
        }
        if strips.iter().any(Self::has_most_contacts) {
            return Outcome::TooMany;
        }
        let mut entered = 0.0_f64;
        for (number, below) in windows.iter().enumerate() {
            let above = windows[(number + 1) % windows.len()];
            let (Some(lower), Some(upper)) = (&below.edges[1], &above.edges[0]) else {
                continue;
            };
            if lower.seam != upper.seam {
                return Outcome::Wrong;
            }
            entered = entered.max(merge::entered(lower, upper));
        }
        let collisions: u64 = strips.iter().map(|strip| strip.tally.collisions).sum();
        if collisions > left {
            return Outcome::TooMany;
        }
        Outcome::Kept(entered)
    }

    /// Chooses the next windows from the present one, and counts. The collisions in the unit of time.
    fn learn(
        &mut self,
        outcome: &Outcome,
        strips: &[Self],
        [begin, end]: [f64; 2],
        halo: i32,
    ) -> Option<f64> {
        let (mut events, mut twice, mut rate) = (0, 0, 0.0);
        for strip in strips {
            let Some(window) = &strip.window else {
                continue;
            };
            events += window.events;
            twice += window.twice;
            let end = if strip.has_most_contacts() {
                strip.now
            } else {
                end
            };
            rate += window.contacts.len() as f64 / (end - begin);
        }
        let collisions = rate * (end - begin) / self.names.len() as f64;
        let spread = &mut self.spread;
        match *outcome {
            Outcome::Kept(entered) => {
                spread.windows += 1;
                spread.events += events - twice;
                spread.twice += twice;
                let reach = collisions / f64::from(halo - SEAM) * ENTERED / entered.max(1e-3);
                spread.reach = reach.min(GROWTH * spread.reach);
            }
            Outcome::Wrong => {
                spread.retries += 1;
                spread.lost += events;
                let reach = collisions / f64::from(halo - SEAM);
                spread.reach = AFTER_WRONG * reach.min(spread.reach);
            }
            Outcome::TooMany | Outcome::Unusual => spread.lost += events,
        }
        (!matches!(outcome, Outcome::Unusual)).then_some(rate)
    }
}
