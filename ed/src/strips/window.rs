//! What a strip writes down while it runs alone: what others need to count and to check.

use std::ops::Range;

use nalgebra::Vector2;
use stosszahl_model::{Physics, Plane, SpinOf};

use super::cut::{Place, Scratch};
use crate::calendar::Calendar;
use crate::cells::{Cell, NONE};
use crate::checkpoint::Tally;
use crate::engine::Engine;
use crate::progress::Latest;

/// Rows of cells on each side of an edge whose history two strips must agree on. An event in one row changes and reads
/// what is at most two rows away.
pub(super) const SEAM: i32 = 2;

/// A boundary between two strips, before a row of cells.
#[derive(Clone, Debug)]
pub(super) struct Edge<S> {
    /// The row.
    pub(super) row: i32,
    /// All that happened in the seam.
    pub(super) seam: Vec<Trace<S>>,
    /// A number for what happened in each row, from the farthest below the edge that is simulated to the farthest above.
    pub(super) rows: Vec<u64>,
}

/// What an event has made of a disk.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Trace<S> {
    time: f64,
    disk: u32,
    home: Cell,
    position: Vector2<f64>,
    velocity: Vector2<f64>,
    spin: S,
    contact: f64,
    partner: Option<u32>,
    partner_count: u16,
}

/// A contact of a disk, with another or with what stands in the box.
#[derive(Clone, Copy, Debug)]
pub(super) struct Contact {
    /// Own time of the engine.
    pub(super) now: f64,
    /// Speed of approach.
    pub(super) approach: f64,
    /// The disk whose event it was, and the other or [`NONE`], by their numbers in the strip: to look up others would take
    /// longer than all else here.
    pub(super) pair: [u32; 2],
}

/// What a wall or an obstacle has given, by the number of its account.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Given {
    pub(crate) ledger: usize,
    pub(crate) momentum: Vector2<f64>,
    pub(crate) energy: f64,
}

/// The log of a strip.
#[derive(Debug)]
pub(crate) struct Window<P: Physics> {
    /// Number in the whole gas of each disk here, in ascending order.
    pub(super) numbers: Vec<u32>,
    /// For the next window.
    pub(super) scratch: Scratch,
    /// Rows whose events count here; those around them are simulated twice.
    pub(super) core: Range<i32>,
    /// Rows around the core on each side.
    halo: i32,
    /// Rows in the box, if it is periodic across the strips.
    around: Option<i32>,
    /// The lower and the upper edge of the core, where there is a neighbour.
    pub(super) edges: [Option<Edge<SpinOf<P>>>; 2],
    pub(super) contacts: Vec<Contact>,
    pub(super) given: Vec<Given>,
    /// When disks crossed from cell to cell, or touched walls without end, since the last sign of progress.
    pub(super) idle: Vec<f64>,
    /// Those and all before.
    pub(super) idled: u64,
    /// Events in all, and those that count elsewhere.
    pub(super) events: u64,
    pub(super) twice: u64,
    /// Time of the last event that counts.
    pub(super) latest: f64,
    /// Events, contacts that count, at which the log is full.
    pub(super) most: [u64; 2],
    /// Whether the events of a row can be of interest to neighbours.
    is_near: Vec<bool>,
    /// Whether those of the present row can; then, before its event: the row, whether it counts here, and what was done.
    near: bool,
    row: i32,
    owns: bool,
    tally: Tally,
}

impl<P: Physics<Space = Plane>> Window<P> {
    pub(super) fn new(
        numbers: Vec<u32>,
        place: &Place,
        rows_in_box: u16,
        most: [u64; 2],
        mut contacts: Vec<Contact>,
    ) -> Self {
        contacts.clear();
        let Place {
            core,
            halo,
            neighbours,
            around,
        } = place.clone();
        let rows = [core.start, core.end];
        let edge = |side: usize| {
            neighbours[side].then(|| Edge {
                row: rows[side],
                seam: Vec::new(),
                rows: vec![0; 2 * halo as usize],
            })
        };
        let mut window = Self {
            numbers,
            scratch: Scratch::default(),
            edges: [edge(0), edge(1)],
            core,
            halo,
            around,
            contacts,
            given: Vec::new(),
            idle: Vec::new(),
            idled: 0,
            events: 0,
            twice: 0,
            latest: f64::NEG_INFINITY,
            most,
            is_near: Vec::new(),
            near: false,
            row: 0,
            owns: true,
            tally: Tally::default(),
        };
        let is_near = |row: i32| {
            let mut edges = window.edges.iter().flatten();
            // A partner is in the next row at the most.
            edges.any(|edge| above(row, edge.row, around).abs() <= halo + 1)
                || !window.core.contains(&row)
        };
        window.is_near = (0..i32::from(rows_in_box)).map(is_near).collect();
        window
    }

    /// Whether the present event counts here.
    pub(crate) fn owns(&self) -> bool {
        self.owns
    }
}

/// How far a row is above an edge: 0 is the first row above it, -1 the first below. With rows in a periodic box.
fn above(row: i32, edge: i32, around: Option<i32>) -> i32 {
    let steps = row - edge;
    match around {
        Some(rows) if 2 * steps >= rows => steps - rows,
        Some(rows) if 2 * steps < -rows => steps + rows,
        _ => steps,
    }
}

/// Mixes a number into another, so that different sequences have different results.
fn mixed(sum: u64, number: u64) -> u64 {
    (sum.rotate_left(23) ^ number).wrapping_mul(0x9e37_79b9_7f4a_7c15)
}

impl<P, Q> Engine<P, Q>
where
    P: Physics<Space = Plane>,
    Q: Calendar,
{
    /// Whether there were so many contacts that the others need not be known.
    pub(super) fn has_most_contacts(&self) -> bool {
        let window = self.window.as_ref();
        window.is_some_and(|window| window.contacts.len() as u64 > window.most[1])
    }

    /// Whether so much has happened to a strip that it had better stop.
    pub(crate) fn is_log_full(&self) -> bool {
        let window = self.window.as_ref();
        self.has_most_contacts() || window.is_some_and(|window| window.events > window.most[0])
    }

    /// Before an event of a disk.
    #[inline(always)]
    pub(crate) fn log_before(&mut self, disk: u32) {
        let row = self.disks.home(disk)[1];
        if let Some(window) = &mut self.window {
            window.near = window.is_near[usize::from(row)];
            window.owns = true;
            if window.near {
                window.tally = self.tally;
                window.row = i32::from(row);
                window.owns = window.core.contains(&window.row);
            }
        }
    }

    /// After it, with the disks that it has changed.
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

    /// An event that neighbours may be interested in.
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
        let who = window.numbers[changed[0] as usize];
        let changed = changed.into_iter().filter(|&disk| disk != NONE);
        for edge in window.edges.iter_mut().flatten() {
            let above = |row: i32| above(row, edge.row, window.around);
            if let Ok(place) = usize::try_from(above(window.row) + window.halo)
                && let Some(sum) = edge.rows.get_mut(place)
            {
                *sum = mixed(mixed(*sum, self.now.to_bits()), u64::from(who));
            }
            let within = |row: i32| (-SEAM..SEAM).contains(&above(row));
            let row_of = |disk: u32| i32::from(self.disks.home(disk)[1]);
            if within(window.row) || changed.clone().any(|disk| within(row_of(disk))) {
                let traces = changed
                    .clone()
                    .map(|disk| self.trace(disk, &window.numbers));
                edge.seam.extend(traces);
            }
        }
        self.window = Some(window);
    }

    /// A crossing.
    #[cold]
    pub(crate) fn log_crossing(&mut self) {
        if let Some(window) = &mut self.window
            && window.owns
        {
            window.idle.push(self.now);
            window.idled += 1;
        }
    }

    /// A collision.
    #[cold]
    pub(crate) fn log_contact(&mut self, latest: &Latest) {
        if let Some(window) = &mut self.window
            && window.owns
        {
            window.idle.clear();
            window.log(latest);
        }
    }

    /// A contact with a wall, which is a sign of progress if there is a time to be reached.
    #[cold]
    pub(crate) fn log_rebound(&mut self, latest: &Latest, ends: bool, given: Given) {
        if let Some(window) = &mut self.window
            && window.owns
        {
            if ends {
                window.idle.clear();
            }
            window.idle.push(latest.now);
            window.idled += 1;
            window.log(latest);
            window.given.push(given);
        }
    }

    /// What is now known of a disk, by numbers in the whole gas.
    fn trace(&self, who: u32, numbers: &[u32]) -> Trace<SpinOf<P>> {
        let disk = &self.disks.all[who as usize];
        let disks = numbers.len() as u32;
        // What stands in the box has numbers that no disk has.
        let partner = match disk.partner {
            NONE => None,
            partner if partner < disks => Some(numbers[partner as usize]),
            what => Some(NONE - 1 - (what - disks)),
        };
        Trace {
            time: self.now,
            disk: numbers[who as usize],
            home: disk.home,
            position: disk.position,
            velocity: disk.velocity,
            spin: self.spin(who),
            contact: disk.contact,
            partner,
            partner_count: disk.partner_count,
        }
    }
}

impl<P: Physics> Window<P> {
    /// Number in the whole gas of a disk, or [`NONE`].
    pub(super) fn number(&self, disk: u32) -> u32 {
        let number = self.numbers.get(disk as usize);
        number.copied().unwrap_or(NONE)
    }

    fn log(&mut self, latest: &Latest) {
        self.contacts.push(Contact {
            now: latest.now,
            approach: latest.approach,
            pair: latest.pair,
        });
    }
}
