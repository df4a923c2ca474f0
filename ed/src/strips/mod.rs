//! Parallel simulation of one gas by domain decomposition into strips, with the bytes of one
//! engine.
//!
//! The box is cut into strips of rows of cells. Each thread simulates one strip and a halo of rows
//! on each side, alone, for a window of time. Disks that would enter through the outer edge of a
//! halo are missing, so that its events are wrong, first there, then farther in.
//!
//! At the end of the window the histories of neighbouring strips are compared disk by disk in a
//! seam of two rows, one on each side of the edge between them.
//!
//! - Where they agree, the events of the rows below the edge in one strip and above it in the other
//!   together are those of one engine for the whole gas. Each strip then gets new halos from its
//!   neighbours.
//! - Where they do not agree, the gas returns to the state at which it was joined last. It repeats
//!   the windows since then in the same strips, and the wrong window in a shorter form.
//!
//! *Exactness.* An event changes a disk, and perhaps its partner in an adjacent cell. It reads the
//! cells around both, before and after. It counts for the strip that owns the row of its disk.
//!
//! Take the strip below an edge: it has all rows below the edge, and the first row above it, where
//! its history is that of the upper strip. That is all that the event reads, unless it changes a
//! disk above the edge. Then it also reads the second row, as candidates of that disk, and these
//! are compared in both strips. So each event was computed from correct data by the strip that
//! counts it, and the other strip's result is compared where it continues from the event.
//!
//! Join the lower strip's history of disks below the edge and the upper strip's history of those
//! above it. There is no first event at which the joined history could differ from that of one
//! engine. A disk has one number in all strips, so that simultaneous events have one order.
//!
//! What depends on the order of all events (observers, accounts of walls, signs of collapse) is fed
//! from logs that are merged by time. Whatever is unusual in a window, be it an error, an interrupt
//! or the end of a budget, makes the engine drop the window and continue alone.
//!
//! The method needs no upper bound of speeds. Dense gases would violate one, because in them
//! information travels at the speed of sound. The length of windows follows from how far wrong
//! events have come into the halos, which is about the root of the number of collisions.

mod cut;
mod merge;
#[cfg(test)]
mod tests;

use std::iter;
use std::time::Instant;

use stosszahl_model::interrupt::Interruption;
use stosszahl_model::threads::each_of;
use stosszahl_model::walls::WallLedger;
use stosszahl_model::{Collision, Field, Interrupt, Observer, ParticleModel, Plane, Recorder};

use crate::calendar::{Buckets, Calendar, rate};
use crate::checkpoint::{EventCounters, EventDrivenCheckpoint};
use crate::collapse::CollapseDetector;
use crate::engine::EventDrivenEngine;
use crate::error::EventDrivenError;
use crate::events::{Goal, Leap};
use crate::strip_log::{SEAM, StripLog, StripRows};
use cut::{HaloExchange, LEAST_HALO};

/// Overhead of one time window in strips, in units of the work for one collision per disk: halos,
/// logs and idle threads.
const COST: f64 = 0.009;

/// Initial estimate of the halo width for a time window of one collision per disk, in rows of cells
/// beyond the row that neighbouring strips compare.
const FIRST_DEPTH: f64 = 20.0;

/// Factor by which the estimated halo width shrinks after a window in which wrong events did not
/// come far.
const DECAY: f64 = 0.97;

/// Least number of collisions per disk in an advance for which strips are faster than one thread.
const WORTH_STRIPS: f64 = 0.08;
/// Least number of collisions per disk for which one more time window in strips is faster than one
/// thread.
const WORTH: f64 = 0.03;

/// Largest number of disks from whose predicted contacts the collision rate is estimated.
const ASKED: usize = 10_000;

/// Number of time windows after which the strips are joined to a committed state; the gas returns
/// there if a later window is wrong.
const MOST_BEHIND: usize = 4;

/// Initial limit for how far wrong events may come into a halo, as a fraction of its width: one
/// window in some hundreds is then wrong.
const ENTERED: f64 = 0.6;
/// Factor on the permitted depth of wrong events in a halo after a rejected time window.
const ENTERED_AFTER_WRONG: f64 = 0.8;
/// Factor on the permitted depth of wrong events in a halo after an accepted time window.
const ENTERED_GROWTH: f64 = 1.002;

/// Largest number of rejected time windows in a row; after that the gas advances without strips.
const MOST_RETRIES: u32 = 8;

/// Largest number of collisions per disk in a time window without observer, which limits the memory
/// of logs.
const MOST_LOGGED: f64 = 4.0;
/// Largest number of collisions per disk in a time window with an observer.
const MOST_OBSERVED: f64 = 1.0;

/// Fraction of the remaining collisions of an advance that a time window may use, after subtraction
/// of [`DEVIATIONS`] standard deviations.
const AIM: f64 = 0.99;
/// Number of standard deviations of the number of collisions by which a time window stays below the
/// remaining collisions.
const DEVIATIONS: f64 = 5.0;

/// Domain decomposition of a gas into parallel strips: number, cuts, adaptive parameters and work
/// counters. Results do not depend on any of them.
#[derive(Clone, Debug)]
pub struct StripSettings {
    /// Number of strips, one for each thread; fewer than two mean no decomposition.
    pub strips: usize,
    /// Number of time windows accepted, because the histories of neighbouring strips agreed.
    pub windows: u64,
    /// Number of time windows rejected and repeated, for example because the histories of
    /// neighbouring strips did not agree.
    pub retries: u64,
    /// Number of events in accepted time windows; an event that two strips simulated counts once.
    pub events: u64,
    /// Number of events in accepted time windows that two strips simulated.
    pub twice: u64,
    /// Number of events in rejected time windows, all strips together.
    pub lost: u64,
    /// Halo width that a time window of one collision per disk needs, in rows of cells beyond the
    /// row that neighbouring strips compare; for n collisions per disk it is √n times as wide.
    depth: f64,
    /// Permitted depth of wrong events in a halo, as a fraction of its width beyond the row that
    /// neighbouring strips compare.
    entered: f64,
    /// Collision rate of the gas, in collisions per unit of engine time: of the last time window,
    /// or estimated.
    rate: f64,
    /// Rows of cells at which strips begin, and where the last one ends; empty if not yet chosen.
    cuts: Vec<i32>,
}

impl Default for StripSettings {
    fn default() -> Self {
        Self {
            strips: 0,
            windows: 0,
            retries: 0,
            events: 0,
            twice: 0,
            lost: 0,
            depth: FIRST_DEPTH,
            entered: ENTERED,
            rate: 0.0,
            cuts: Vec::new(),
        }
    }
}

/// Clock and counters of the whole gas when its strips were last joined, and the time windows
/// simulated since: the gas returns there if a window is wrong.
struct CommittedState {
    /// Time windows since the strips were last joined: rows of cells of each strip, and end in
    /// engine time.
    windows: Vec<(Vec<StripRows>, f64)>,
    now: f64,
    tally: EventCounters,
    ledgers: Vec<WallLedger<Plane>>,
    progress: CollapseDetector,
}

impl CommittedState {
    /// Creates the committed state of an engine at the current time, with no time windows after it.
    fn new<P: ParticleModel<Space = Plane>, Q: Calendar>(engine: &EventDrivenEngine<P, Q>) -> Self {
        Self {
            windows: Vec::new(),
            now: engine.now,
            tally: engine.tally,
            ledgers: engine.ledgers.clone(),
            progress: engine.progress.clone(),
        }
    }
}

/// Outcome of the comparison of neighbouring strips after a time window.
enum Outcome {
    /// The time window is accepted; wrong events came this far into a halo, as a fraction of its
    /// width.
    Kept(f64),
    /// The time window is rejected: wrong events crossed a halo, and event histories of
    /// neighbouring strips differ at their boundary.
    Wrong,
    /// The time window had more collisions than the log or the advance allows.
    TooMany,
    /// Something happened that only an engine without strips can process, such as signs of
    /// collapse.
    Unusual,
}

/// Observer that stores all collisions, if `looks` is true.
struct Keep {
    looks: bool,
    all: Vec<Collision>,
}

impl Observer for Keep {
    fn is_active(&self) -> bool {
        self.looks
    }

    fn on_collisions(&mut self, batch: &[Collision]) {
        self.all.extend_from_slice(batch);
    }
}

/// Strips of a gas: their settings, and one engine for each.
struct Strips<P: ParticleModel, Q: Calendar> {
    settings: StripSettings,
    /// Engines of the strips, kept from one advance to the next; empty after an advance without
    /// strips.
    strips: Vec<EventDrivenEngine<P, Q>>,
}

/// Event-driven engine whose gas may be decomposed into strips, one for each thread, with the same
/// bytes as without.
pub struct StripedEngine<P: ParticleModel, Q: Calendar = Buckets> {
    engine: EventDrivenEngine<P, Q>,
    strips: Strips<P, Q>,
}

impl<P, Q> StripedEngine<P, Q>
where
    P: ParticleModel<Space = Plane>,
    Q: Calendar,
{
    /// Creates an engine that decomposes its gas into `strips` strips, one for each thread of the
    /// current pool, if the gas is large enough.
    pub fn new(engine: EventDrivenEngine<P, Q>, strips: usize) -> Self {
        let settings = StripSettings {
            strips,
            ..StripSettings::default()
        };
        Self::with_settings(engine, settings)
    }

    /// Creates an engine that decomposes its gas by given settings, as taken from an earlier
    /// engine.
    pub(crate) fn with_settings(
        mut engine: EventDrivenEngine<P, Q>,
        settings: StripSettings,
    ) -> Self {
        engine.parallel = settings.strips > 1;
        let strips = Vec::new();
        Self {
            engine,
            strips: Strips { settings, strips },
        }
    }

    /// Advances the gas to the time `until` \[time\] or by a number of collisions, like
    /// [`EventDrivenEngine::advance`].
    ///
    /// # Errors
    /// As [`EventDrivenEngine::advance`].
    pub fn advance(
        &mut self,
        until: f64,
        most_collisions: u64,
        observer: &mut dyn Observer,
    ) -> Result<bool, EventDrivenError> {
        let strips = &mut self.strips;
        (self.engine).advance_with(strips, until, most_collisions, observer)
    }

    /// Sets the number of strips for the advances that follow.
    pub fn spread_over(&mut self, strips: usize) {
        if strips != self.strips.settings.strips {
            self.strips.settings.cuts.clear();
            self.strips.drop_kept();
        }
        self.strips.settings.strips = strips;
        self.engine.parallel = strips > 1;
    }

    /// Returns the settings of the strips, with the counters of their work so far.
    pub fn settings(&self) -> &StripSettings {
        &self.strips.settings
    }

    /// Returns the engine of the whole gas. It advances only through [`Self::advance`].
    pub fn engine(&self) -> &EventDrivenEngine<P, Q> {
        &self.engine
    }

    /// Returns the engine of the whole gas, which advances alone from now on.
    pub fn into_engine(self) -> EventDrivenEngine<P, Q> {
        self.engine
    }

    /// Sets an interrupt that breaks off an advance, as [`EventDrivenEngine::set_stop_flag`] does.
    pub fn set_stop_flag(&mut self, interrupt: &Interrupt) {
        self.engine.set_stop_flag(interrupt);
    }

    /// Sets the interrupt of an advance together with its state.
    pub(crate) fn set_interruption(&mut self, stop: Interruption) {
        self.engine.stop = stop;
    }

    /// Frees the memory of the strips, and returns a checkpoint from which the run resumes.
    pub(crate) fn land(&mut self) -> EventDrivenCheckpoint<P> {
        self.strips.drop_kept();
        self.engine.checkpoint()
    }

    /// Returns the memory that the engine and its strips occupy \[bytes\].
    pub fn memory_bytes(&self) -> usize {
        let strips = self
            .strips
            .strips
            .iter()
            .map(EventDrivenEngine::memory_bytes);
        self.engine.memory_bytes() + strips.sum::<usize>()
    }
}

impl<P, Q> Leap<P, Q> for Strips<P, Q>
where
    P: ParticleModel<Space = Plane>,
    Q: Calendar,
{
    /// Advances the gas in strips towards a goal, as far as this is faster than one thread. True if
    /// the time of the goal was reached, with fewer collisions than its limit.
    fn leap_towards(
        &mut self,
        whole: &mut EventDrivenEngine<P, Q>,
        goal: &Goal,
        recorder: &mut Recorder<'_>,
    ) -> bool {
        let Some((mut cuts, end)) = self.prepare(whole, goal) else {
            return false;
        };
        let mut strips = std::mem::take(&mut self.strips);
        let (mut now, mut retries) = (whole.now, 0);
        let mut behind = CommittedState::new(whole);
        let mut parcels = Vec::new();
        while retries < MOST_RETRIES && now < end {
            let places = self.places(whole, &cuts);
            let window = self.window(whole, &places[0], goal.last, recorder);
            let Some(window) = window else {
                // Fewer and higher strips have room for wider halos.
                let ends = self.longest(&places[0]) >= WORTH
                    || Self::window_limit(whole, goal.last) < WORTH;
                let Some(fewer) = cut::fewer(cuts.len() - 1).filter(|_| !ends) else {
                    break;
                };
                if !behind.windows.is_empty() {
                    cut::join(whole, &strips);
                    behind = CommittedState::new(whole);
                }
                strips.clear();
                cuts = cut::fewer_cuts(&cuts, fewer);
                continue;
            };
            let until = if window < end - now {
                now + window
            } else {
                end
            };
            let left = goal.last - whole.tally.collisions;
            Self::give_places(whole, &mut strips, &places, &mut parcels, now);
            let most = [Self::most_events(whole, places.len()), left];
            let to = Goal {
                end: until,
                ends: goal.ends,
                last: u64::MAX,
            };
            let (ended, observed) = Self::run_all(&mut strips, &to, most, recorder.looks());
            let outcome = if ended {
                Self::examine(&strips, left)
            } else {
                Outcome::Unusual
            };
            self.learn(
                whole.names.len(),
                &outcome,
                &strips,
                [now, until],
                places[0].halo,
            );
            match outcome {
                Outcome::Kept(_)
                    if merge::merge(whole, &strips, &observed, goal.ends, recorder) =>
                {
                    behind.windows.push((places, until));
                    (now, retries) = (until, 0);
                    let work = strips.iter().filter_map(|strip| strip.window.as_ref());
                    let work: Vec<f64> = work.map(|window| window.seconds).collect();
                    cuts = cut::better_cuts(&cuts, &work);
                    if behind.windows.len() >= MOST_BEHIND {
                        cut::join(whole, &strips);
                        behind = CommittedState::new(whole);
                    }
                }
                outcome => {
                    strips.clear();
                    strips = Self::catch_up(whole, behind, goal.ends);
                    behind = CommittedState::new(whole);
                    retries += 1;
                    let again = matches!(outcome, Outcome::Wrong | Outcome::TooMany);
                    if !again || whole.stop.ends() {
                        break;
                    }
                }
            }
        }
        if !behind.windows.is_empty() {
            cut::join(whole, &strips);
        }
        self.settings.cuts = cuts;
        let there = now == goal.end && whole.tally.collisions < goal.last;
        if there {
            self.strips = strips;
        }
        there
    }

    fn drop_kept(&mut self) {
        self.strips.clear();
    }
}

impl<P, Q> Strips<P, Q>
where
    P: ParticleModel<Space = Plane>,
    Q: Calendar,
{
    /// Returns the boundaries of the strips for an advance to a goal, and the engine time at which
    /// it ends at the latest; `None` if strips are not worth while.
    fn prepare(&mut self, whole: &EventDrivenEngine<P, Q>, goal: &Goal) -> Option<(Vec<i32>, f64)> {
        // Not for sliding rows, which step all at once.
        if self.settings.strips < 2 || P::Field::SHEARED {
            return None;
        }
        let mut worth = WORTH_STRIPS * whole.names.len() as f64;
        if ((goal.last - whole.tally.collisions) as f64) < worth {
            return None;
        }
        // The order of negligible contacts decides whether they are a collapse.
        if whole.progress.is_negligible() {
            return None;
        }
        let cuts = self.cuts(whole)?;
        let end = goal.end.min(whole.horizon.next_down());
        if self.strips.is_empty() {
            // The rate is known within a factor of two.
            self.settings.rate = Self::rate_to_come(whole);
            worth *= 0.5;
        }
        if (end - whole.now) * self.settings.rate < worth {
            return None;
        }
        for strip in &mut self.strips {
            strip.stop = whole.stop.clone();
        }
        Some((cuts, end))
    }

    /// Returns the rows of cells of each strip, with the halo of least cost. A wider halo allows
    /// longer windows but repeats more work: the cost 2 h/H + c (v/(h - s))² of strips of H rows,
    /// with the depth v, is least at h = s + (c v² H)^(1/3).
    fn places(&self, whole: &EventDrivenEngine<P, Q>, cuts: &[i32]) -> Vec<StripRows> {
        let cells = &whole.disks.cells;
        let rows = i32::from(cells.counts()[1]);
        let strips = cuts.len() - 1;
        let height = f64::from(rows) / strips as f64;
        let best = (COST * self.settings.depth.powi(2) * height).cbrt();
        let widest = cut::widest_halo(cuts).unwrap_or(LEAST_HALO);
        let halo = (SEAM + best.min(1e6) as i32).clamp(LEAST_HALO, widest);
        let around = cells.is_periodic(1).then_some(rows);
        let place = |number: usize| {
            let has = |side: bool| around.is_some() || side;
            StripRows {
                core: cuts[number]..cuts[number + 1],
                halo,
                neighbours: [has(number > 0), has(number < strips - 1)],
                around,
            }
        };
        (0..strips).map(place).collect()
    }

    /// Returns the boundaries of as many strips as the settings ask for, or of half as many and so
    /// on down to two, if only these pay; `None` if none do. Existing strips keep their boundaries.
    fn cuts(&self, whole: &EventDrivenEngine<P, Q>) -> Option<Vec<i32>> {
        if !self.strips.is_empty() {
            return Some(self.settings.cuts.clone());
        }
        let cells = &whole.disks.cells;
        if whole.disks.hierarchical() || cells.narrow() || cells.wide() {
            return None;
        }
        let rows = i32::from(cells.counts()[1]);
        let most = self.settings.strips.min(usize::from(u8::MAX));
        let of = |strips: usize| {
            let known = &self.settings.cuts;
            if known.last() == Some(&rows) && known.len() == strips + 1 {
                Some(known.clone())
            } else {
                cut::equal_cuts(rows, strips)
            }
        };
        let numbers = iter::successors(Some(most), |&strips| cut::fewer(strips));
        let pays = |cuts: &Vec<i32>| self.longest(&self.places(whole, cuts)[0]) >= WORTH;
        numbers.filter_map(of).find(pays)
    }

    /// Returns the largest number of collisions per disk in a time window such that wrong events
    /// almost never cross a halo.
    fn longest(&self, place: &StripRows) -> f64 {
        (f64::from(place.halo - SEAM) / self.settings.depth).powi(2)
    }

    /// Returns the largest number of collisions per disk for a time window that almost surely ends
    /// before the run's collision number `last`.
    fn window_limit(whole: &EventDrivenEngine<P, Q>, last: u64) -> f64 {
        let to_go = (last - whole.tally.collisions) as f64;
        AIM * (to_go - DEVIATIONS * to_go.sqrt()) / whole.names.len() as f64
    }

    /// Gives each strip its rows of cells for the next time window, and creates the strips if there
    /// are none. While strips exist, the calendar of the whole gas is empty.
    fn give_places(
        whole: &mut EventDrivenEngine<P, Q>,
        strips: &mut Vec<EventDrivenEngine<P, Q>>,
        places: &[StripRows],
        parcels: &mut HaloExchange<P>,
        now: f64,
    ) {
        if strips.is_empty() {
            whole.forget_events();
            let whole = &*whole;
            let strip = |place| cut::strip(whole, place, now);
            *strips = each_of(true, places.iter(), |_, place| strip(place));
        } else {
            cut::renew(strips, places, parcels);
        }
    }

    /// Advances all strips in parallel to an engine time, one thread each. Returns true if all
    /// reached it, and their collisions if an observer `looks`.
    fn run_all(
        strips: &mut [EventDrivenEngine<P, Q>],
        goal: &Goal,
        most: [u64; 2],
        looks: bool,
    ) -> (bool, Vec<Vec<Collision>>) {
        let run = |strip: &mut EventDrivenEngine<P, Q>| {
            if let Some(window) = &mut strip.window {
                window.most = most;
            }
            let mut keep = Keep {
                looks,
                all: Vec::new(),
            };
            let began = Instant::now();
            let ended = strip.run_events(goal, &mut Recorder::new(&mut keep));
            if let Some(window) = &mut strip.window {
                window.seconds = began.elapsed().as_secs_f64();
            }
            let ended = ended.unwrap_or(false) || strip.has_most_contacts();
            (ended, keep.all)
        };
        let ran = each_of(true, strips.iter_mut(), |_, strip| run(strip));
        let (ended, observed): (Vec<_>, Vec<_>) = ran.into_iter().unzip();
        (!ended.contains(&false), observed)
    }

    /// Repeats the accepted time windows since the last joined state, with the same events, so that
    /// the gas has the state before the first wrong window. Returns the strips if any window was
    /// repeated. An interrupt ends the repetition early, some windows back.
    fn catch_up(
        whole: &mut EventDrivenEngine<P, Q>,
        behind: CommittedState,
        ends: bool,
    ) -> Vec<EventDrivenEngine<P, Q>> {
        let (mut strips, mut parcels) = (Vec::new(), Vec::new());
        let (mut now, mut contacts) = (behind.now, behind.tally.contacts());
        for (places, until) in &behind.windows {
            let goal = Goal {
                end: *until,
                ends,
                last: u64::MAX,
            };
            let is_done = !whole.stop.ends() && {
                Self::give_places(whole, &mut strips, places, &mut parcels, now);
                // Without an observer, which has received all collisions.
                Self::run_all(&mut strips, &goal, [u64::MAX; 2], false).0
            };
            if !is_done {
                debug_assert!(whole.stop.ends(), "only an interrupt is in the way");
                whole.now = behind.now;
                whole.tally = behind.tally;
                whole.ledgers = behind.ledgers;
                whole.progress = behind.progress;
                return Vec::new();
            }
            now = *until;
            contacts += strips.iter().map(|its| its.tally.contacts()).sum::<u64>();
        }
        debug_assert_eq!(contacts, whole.tally.contacts());
        if !strips.is_empty() {
            cut::join(whole, &strips);
        }
        strips
    }

    /// Returns the largest number of events of a strip in one time window; a strip that reaches it
    /// makes no usual progress and stops.
    fn most_events(whole: &EventDrivenEngine<P, Q>, strips: usize) -> u64 {
        200 * (whole.names.len() / strips) as u64 + 1_000_000
    }

    /// Estimates the collision rate of the gas per unit of engine time, within a factor of two,
    /// from the predicted contacts of some disks.
    fn rate_to_come(whole: &EventDrivenEngine<P, Q>) -> f64 {
        let every = 1 + whole.disks.all.len() / ASKED;
        let contacts = whole.disks.all.iter().step_by(every);
        let waits = contacts.map(|disk| disk.contact - whole.now);
        let waits: Vec<f64> = waits.filter(|wait| wait.is_finite()).collect();
        if waits.is_empty() {
            return 0.0;
        }
        // Factor below one, because both partners of a contact may predict it.
        0.75 * every as f64 * rate(waits)
    }

    /// Returns the length of the next time window in engine time; `None` if it is too short to pay.
    /// A last window before the end of an advance may be shorter, which still costs less than one
    /// thread.
    fn window(
        &self,
        whole: &EventDrivenEngine<P, Q>,
        place: &StripRows,
        last: u64,
        recorder: &Recorder<'_>,
    ) -> Option<f64> {
        let rate = self.settings.rate;
        let disks = whole.names.len() as f64;
        let logged = if recorder.looks() {
            MOST_OBSERVED
        } else {
            MOST_LOGGED
        };
        let collisions = (self.longest(place))
            .min(logged)
            .min(Self::window_limit(whole, last));
        (collisions >= WORTH && rate.is_finite()).then(|| collisions * disks / rate)
    }

    /// Compares the event histories of neighbouring strips in the rows next to their boundaries
    /// after a time window, and returns its outcome. `left` is the number of collisions that remain
    /// of the advance.
    fn examine(strips: &[EventDrivenEngine<P, Q>], left: u64) -> Outcome {
        let windows: Vec<&StripLog<P>> = strips
            .iter()
            .filter_map(|strip| strip.window.as_deref())
            .collect();
        let recounts = |strip: &EventDrivenEngine<P, Q>| strip.disks.recounts > 0;
        if strips.iter().any(recounts) || windows.iter().any(|window| window.is_negligible) {
            return Outcome::Unusual;
        }
        if strips.iter().any(EventDrivenEngine::has_most_contacts) {
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

    /// Adapts halo depth, its permitted fraction and the collision rate to the outcome of the last
    /// time window, and updates the counters.
    fn learn(
        &mut self,
        disks: usize,
        outcome: &Outcome,
        strips: &[EventDrivenEngine<P, Q>],
        [begin, end]: [f64; 2],
        halo: i32,
    ) {
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
        let collisions = rate * (end - begin) / disks as f64;
        let rows = f64::from(halo - SEAM);
        // Bound for the last window before an end, which may be very short.
        let root = collisions.max(WORTH).sqrt();
        let settings = &mut self.settings;
        match *outcome {
            Outcome::Kept(entered) => {
                settings.windows += 1;
                settings.events += events - twice;
                settings.twice += twice;
                // A window that ended early gives little information, unless wrong events came far.
                if collisions >= 0.5 * (rows / settings.depth).powi(2) || entered > settings.entered
                {
                    let depth = entered * rows / (settings.entered * root);
                    settings.depth = depth.max(DECAY * settings.depth);
                }
                if settings.entered < ENTERED {
                    settings.entered = ENTERED.min(ENTERED_GROWTH * settings.entered);
                }
            }
            Outcome::Wrong => {
                settings.retries += 1;
                settings.lost += events;
                let entered = settings.entered.min(ENTERED);
                settings.depth = settings.depth.max(rows / root) / entered;
                settings.entered = ENTERED_AFTER_WRONG * entered;
            }
            Outcome::TooMany | Outcome::Unusual => settings.lost += events,
        }
        if !matches!(outcome, Outcome::Unusual) {
            settings.rate = rate;
        }
    }
}
