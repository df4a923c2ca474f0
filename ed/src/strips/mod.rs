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

use crate::calendar::Calendar;
use crate::engine::Engine;
use crate::events::Goal;
use cut::Place;
use window::SEAM;
pub(crate) use window::Window;

/// Share of the rows of a strip in each of its halos.
const HALO: f64 = 0.045;

/// Rows in a halo at the least: the seam, and as many again as wrong events may come into.
const LEAST_HALO: i32 = 6;

/// At the most: windows are long enough then.
const MOST_HALO: i32 = 24;

/// First window, in rows of the halo over the way of a typical disk.
const FIRST_PACE: f64 = 0.1;

/// Share of the halo that wrong events may enter; most change of the window after that.
const ENTERED: f64 = 0.6;
const MOST_CHANGE: f64 = 1.5;

/// Least collisions in a window, for each disk: cutting and joining costs about a tenth of a collision.
const WORTH: f64 = 0.05;

/// Most collisions in a window for each disk: they are logged.
const MOST_LOGGED: f64 = 4.0;
const MOST_OBSERVED: f64 = 1.0;

/// Share of the collisions that are left, less some standard deviations, that a window aims at.
const AIM: f64 = 0.99;
const DEVIATIONS: f64 = 5.0;

/// Windows done again in a row after which the engine goes on alone.
const MOST_RETRIES: u32 = 6;

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
    /// Length of a window, in the time that a typical disk takes for the way of the halo; 0 if not known yet.
    pace: f64,
    /// Collisions of a disk in the time that it takes for its diameter; 0 if not known yet.
    rate: f64,
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

    /// The rows of each strip, if the box has enough.
    fn places(&self) -> Option<Vec<Place>> {
        let cells = &self.disks.cells;
        let rows = i32::from(cells.counts()[1]);
        let strips = self.spread.strips.min(usize::from(u8::MAX)) as i32;
        if self.disks.hierarchical() || cells.narrow() {
            return None;
        }
        let least = rows / strips;
        let halo = ((f64::from(least) * HALO) as i32).clamp(LEAST_HALO, MOST_HALO);
        // No row is in more than two strips, and none twice in one.
        if least < 2 * halo + 2 * SEAM {
            return None;
        }
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
        let Some(places) = self.places() else { return };
        let end = goal.end.min(self.horizon.next_down());
        let mut strips: Vec<Self> = Vec::new();
        let (mut now, mut retries) = (self.now, 0);
        while retries < MOST_RETRIES && now < end {
            let Some(window) = self.window_until(goal.last, end - now, places[0].halo, recorder)
            else {
                break;
            };
            let until = if window < end - now {
                now + window
            } else {
                end
            };
            let left = goal.last - self.tally.collisions;
            let most = [
                200 * self.names.len() as u64 / places.len() as u64 + 1_000_000,
                left,
            ];
            let looks = recorder.looks();
            let run = |place: &Place| {
                let mut keep = Keep {
                    looks,
                    all: Vec::new(),
                };
                let mut strip = cut::strip(&*self, &strips, place, now, most);
                let goal = Goal {
                    end: until,
                    ends: goal.ends,
                    last: u64::MAX,
                };
                let ended = strip.run(&goal, &mut Recorder::new(&mut keep));
                let ended = ended.unwrap_or(false) || strip.has_most_contacts();
                ((strip, keep.all), ended)
            };
            let done: Vec<_> = places.par_iter().map(run).collect();
            let (done, ended): (Vec<_>, Vec<bool>) = done.into_iter().unzip();
            let (done, observed): (Vec<_>, Vec<_>) = done.into_iter().unzip();
            let outcome = if ended.contains(&false) {
                Outcome::Unusual
            } else {
                self.examine(&done, left)
            };
            self.learn(&outcome, &done, [now, until], places[0].halo);
            match outcome {
                Outcome::Kept(_) if self.merge(&done, &observed, goal.ends, recorder) => {
                    if strips.is_empty() {
                        cut::empty(self);
                    }
                    (strips, now, retries) = (done, until, 0);
                }
                Outcome::Wrong | Outcome::TooMany => retries += 1,
                _ => break,
            }
        }
        if !strips.is_empty() {
            cut::join(self, strips);
            self.calendar = Q::new(&self.disks, now);
        }
    }

    /// Length of the next window, in own time, within what is left; `None` if it does not pay.
    fn window_until(
        &mut self,
        last: u64,
        left: f64,
        halo: i32,
        recorder: &Recorder<'_>,
    ) -> Option<f64> {
        let disks = self.names.len() as f64;
        if self.unit <= 0.0 {
            return None;
        }
        if self.spread.pace == 0.0 {
            self.spread.pace = FIRST_PACE;
        }
        let window = left.min(self.spread.pace * self.way(halo));
        // Collisions in the unit of time.
        let rate = self.spread.rate * disks / self.unit;
        if rate == 0.0 {
            return Some(window);
        }
        let collisions = (last - self.tally.collisions) as f64;
        let safe = AIM * (collisions - DEVIATIONS * collisions.sqrt());
        let logged = if recorder.looks() {
            MOST_OBSERVED
        } else {
            MOST_LOGGED
        };
        let window = window.min(safe / rate).min(logged * disks / rate);
        (window * rate >= WORTH * disks).then_some(window)
    }

    /// Own time in which a typical disk flies as far as the halo is wide.
    fn way(&self, halo: i32) -> f64 {
        let diameter = 2.0 * self.largest_radius();
        self.unit * f64::from(halo) * self.disks.cells.width()[1] / diameter
    }

    /// Compares the histories of neighbours.
    fn examine(&self, strips: &[Self], left: u64) -> Outcome {
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

    /// Chooses the next windows from the present one, and counts.
    fn learn(&mut self, outcome: &Outcome, strips: &[Self], [begin, end]: [f64; 2], halo: i32) {
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
        let way = self.way(halo);
        let disks = self.names.len() as f64;
        let spread = &mut self.spread;
        match *outcome {
            Outcome::Kept(entered) => {
                spread.windows += 1;
                spread.events += events - twice;
                spread.twice += twice;
                let change = (ENTERED / entered.max(1e-3)).min(MOST_CHANGE);
                let pace = (end - begin) / way * change;
                // A window that was shorter for other reasons does not say that it has to be.
                spread.pace = if change < 1.0 {
                    pace
                } else {
                    pace.max(spread.pace)
                };
            }
            Outcome::Wrong => {
                spread.retries += 1;
                spread.pace = (end - begin) / way / MOST_CHANGE;
                spread.lost += events;
            }
            Outcome::TooMany | Outcome::Unusual => spread.lost += events,
        }
        if !matches!(outcome, Outcome::Unusual) {
            spread.rate = rate / disks * self.unit;
        }
    }
}
