//! What a strip writes down while it runs alone: what others need to count and to check.

use nalgebra::Vector2;
use stosszahl_model::{Physics, Plane, SpinOf};

use super::cut::Place;
use crate::calendar::Calendar;
use crate::cells::{Cell, NONE};
use crate::checkpoint::Tally;
use crate::disk::{Disk, VOID};
use crate::engine::Engine;
use crate::progress::Latest;
use crate::windings::Winding;

/// Rows of cells on each side of an edge whose history two strips must agree on. What an event reads farther away is compared by
/// [`Trace::candidates`].
pub(super) const SEAM: i32 = 1;

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
    partner: u32,
    partner_count: u16,
    count: u16,
    /// Time of its last contact, where that is kept.
    last_contact: Option<f64>,
    rebounds: Option<u32>,
    winding: Option<Winding>,
    /// A number for all disks in the cells around it, if the event was that of a disk on the other side of the edge.
    candidates: u64,
}

/// A contact of a disk, with another or with what stands in the box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Contact {
    /// Own time of the engine.
    pub(super) now: f64,
    /// The disk whose event it was, and the other or [`NONE`].
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
    /// Events in the rows of its core count here; those in its halos are simulated twice.
    pub(super) place: Place,
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
    /// Time that it took, which decides where the strips of the next one meet.
    pub(super) seconds: f64,
    /// Whether disks hardly approached in some contact.
    pub(super) is_feeble: bool,
    /// Time of the last event that counts.
    pub(super) latest: f64,
    /// Events, contacts that count, at which the log is full.
    pub(super) most: [u64; 2],
    /// Whether the events of a row can be of interest to neighbours.
    is_near: Vec<bool>,
    /// Whether a disk in a row may not be right: in halos, and in the empty rows beyond that disks have flown to.
    pub(super) is_foreign: Vec<bool>,
    /// Whether those of the present row can; then, before its event: the row, whether it counts here, and what was done.
    near: bool,
    row: i32,
    owns: bool,
    tally: Tally,
}

impl<P: Physics<Space = Plane>> Window<P> {
    pub(super) fn new(place: &Place, rows_in_box: usize) -> Self {
        let rows = [place.core.start, place.core.end];
        let edge = |side: usize| {
            place.neighbours[side].then(|| Edge {
                row: rows[side],
                seam: Vec::new(),
                rows: vec![0; 2 * place.halo as usize],
            })
        };
        let mut window = Self {
            edges: [edge(0), edge(1)],
            place: place.clone(),
            contacts: Vec::new(),
            given: Vec::new(),
            idle: Vec::new(),
            idled: 0,
            events: 0,
            twice: 0,
            seconds: 0.0,
            is_feeble: false,
            latest: f64::NEG_INFINITY,
            most: [u64::MAX; 2],
            is_near: Vec::new(),
            is_foreign: vec![false; rows_in_box],
            near: false,
            row: 0,
            owns: true,
            tally: Tally::default(),
        };
        let is_near = |row: i32| {
            let mut edges = window.edges.iter().flatten();
            // A partner is in the next row at the most.
            edges.any(|edge| above(row, edge.row, place.around).abs() <= place.halo + 1)
                || !place.core.contains(&row)
        };
        window.is_near = (0..rows_in_box as i32).map(is_near).collect();
        for row in place.rows().filter(|row| !place.owns(*row)) {
            window.is_foreign[usize::from(row)] = true;
        }
        window
    }

    /// Becomes the empty log of another place.
    pub(super) fn renew(&mut self, place: &Place) {
        let rows_in_box = self.is_near.len();
        let mut contacts = std::mem::take(&mut self.contacts);
        contacts.clear();
        *self = Self {
            contacts,
            ..Self::new(place, rows_in_box)
        };
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
                window.owns = window.place.owns(row);
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
    pub(crate) fn log_contact(&mut self, latest: &Latest, is_feeble: Option<bool>) {
        if let Some(window) = &mut self.window
            && window.owns
        {
            window.idle.clear();
            window.log(latest, is_feeble);
        }
    }

    /// A contact with a wall, which is a sign of progress if there is a time to be reached.
    #[cold]
    pub(crate) fn log_rebound(
        &mut self,
        latest: &Latest,
        is_feeble: Option<bool>,
        ends: bool,
        given: Given,
    ) {
        if let Some(window) = &mut self.window
            && window.owns
        {
            if ends {
                window.idle.clear();
            }
            window.idle.push(latest.now);
            window.idled += 1;
            window.log(latest, is_feeble);
            window.given.push(given);
        }
    }

    /// What is now known of a disk.
    fn trace(&self, who: u32, is_beyond: bool) -> Trace<SpinOf<P>> {
        let disk = &self.disks.all[who as usize];
        // One that has collided since may be anywhere, and is as good as none.
        let is_lost = |partner: &Disk| partner.count != disk.partner_count;
        let partner = self.disks.all.get(disk.partner as usize);
        let (partner, partner_count) = if partner.is_some_and(is_lost) {
            (NONE, VOID)
        } else {
            (disk.partner, disk.partner_count)
        };
        Trace {
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
            winding: self.windings.get(who as usize).copied(),
            candidates: if is_beyond {
                self.candidates_of(who)
            } else {
                0
            },
        }
    }

    /// A number for the disks in the cells around one: who they are, and what is known of them.
    fn candidates_of(&self, who: u32) -> u64 {
        self.disks.around(who).fold(0, |sum, (number, disk)| {
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

impl<P: Physics> Window<P> {
    fn log(&mut self, latest: &Latest, is_feeble: Option<bool>) {
        self.contacts.push(Contact {
            now: latest.now,
            pair: latest.pair,
        });
        self.is_feeble |= is_feeble.unwrap_or(false);
    }
}
