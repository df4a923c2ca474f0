//! The log of a strip of a gas: what its neighbours need to count and to check. See [`crate::strips`].

use std::ops::Range;

use nalgebra::Vector2;
use stosszahl_model::{Physics, Plane, SpinOf};

use crate::cells::Cell;
use crate::checkpoint::Tally;
use crate::collapse::ContactInfo;
use crate::image_flags::ImageFlags;

/// Rows of cells on each side of an edge whose history two strips must agree on. What an event reads farther away is compared by
/// [`SeamRecord::candidates`].
pub(crate) const SEAM: i32 = 1;

/// Where the rows of cells of a strip lie.
#[derive(Clone, Debug)]
pub(crate) struct StripRows {
    /// Rows that are its own.
    pub(crate) core: Range<i32>,
    /// Rows that it simulates with them on each side where there is a neighbour.
    pub(crate) halo: i32,
    /// Whether there is one below and above.
    pub(crate) neighbours: [bool; 2],
    /// Rows in the box, if it is periodic across the strips.
    pub(crate) around: Option<i32>,
}

impl StripRows {
    /// All its rows.
    pub(crate) fn rows(&self) -> impl Iterator<Item = u16> {
        let beyond = |side: usize| i32::from(self.neighbours[side]) * self.halo;
        let rows = self.core.start - beyond(0)..self.core.end + beyond(1);
        let around = self.around;
        rows.map(move |row| around.map_or(row, |rows| row.rem_euclid(rows)) as u16)
    }

    /// Whether a row is its own.
    pub(crate) fn owns(&self, row: u16) -> bool {
        self.core.contains(&i32::from(row))
    }
}

/// A boundary between two strips, before a row of cells.
#[derive(Clone, Debug)]
pub(crate) struct Edge<S> {
    /// The row.
    pub(crate) row: i32,
    /// All that happened in the seam.
    pub(crate) seam: Vec<SeamRecord<S>>,
    /// A number for what happened in each row, from the farthest below the edge that is simulated to the farthest above.
    pub(crate) rows: Vec<u64>,
}

/// What an event has made of a disk.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SeamRecord<S> {
    pub(crate) time: f64,
    pub(crate) disk: u32,
    pub(crate) home: Cell,
    pub(crate) position: Vector2<f64>,
    pub(crate) velocity: Vector2<f64>,
    pub(crate) spin: S,
    pub(crate) contact: f64,
    pub(crate) partner: u32,
    pub(crate) partner_count: u16,
    pub(crate) count: u16,
    /// Time of its last contact, where that is kept.
    pub(crate) last_contact: Option<f64>,
    pub(crate) rebounds: Option<u32>,
    pub(crate) winding: Option<ImageFlags>,
    /// A number for all disks in the cells around it, if the event was that of a disk on the other side of the edge.
    pub(crate) candidates: u64,
}

/// A contact of a disk, with another or with what stands in the box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct LoggedContact {
    /// Own time of the engine.
    pub(crate) now: f64,
    /// The disk whose event it was, and the other or [`NONE`].
    pub(crate) pair: [u32; 2],
}

/// What a wall or an obstacle has given, by the number of its account.
#[derive(Clone, Copy, Debug)]
pub(crate) struct WallImpulse {
    pub(crate) ledger: usize,
    pub(crate) momentum: Vector2<f64>,
    pub(crate) energy: f64,
}

/// The log of a strip.
#[derive(Debug)]
pub(crate) struct StripLog<P: Physics> {
    /// Events in the rows of its core count here; those in its halos are simulated twice.
    pub(crate) place: StripRows,
    /// The lower and the upper edge of the core, where there is a neighbour.
    pub(crate) edges: [Option<Edge<SpinOf<P>>>; 2],
    pub(crate) contacts: Vec<LoggedContact>,
    pub(crate) given: Vec<WallImpulse>,
    /// When disks crossed from cell to cell, or touched walls without end, since the last sign of progress.
    pub(crate) idle: Vec<f64>,
    /// Those and all before.
    pub(crate) idled: u64,
    /// Events in all, and those that count elsewhere.
    pub(crate) events: u64,
    pub(crate) twice: u64,
    /// Time that it took, which decides where the strips of the next one meet.
    pub(crate) seconds: f64,
    /// Whether disks hardly approached in some contact.
    pub(crate) is_negligible: bool,
    /// Time of the last event that counts.
    pub(crate) latest: f64,
    /// Events, contacts that count, at which the log is full.
    pub(crate) most: [u64; 2],
    /// Whether the events of a row can be of interest to neighbours.
    pub(crate) is_near: Vec<bool>,
    /// Whether a disk in a row may not be right: in halos, and in the empty rows beyond that disks have flown to.
    pub(crate) is_foreign: Vec<bool>,
    /// Whether those of the present row can; then, before its event: the row, whether it counts here, and what was done.
    pub(crate) near: bool,
    pub(crate) row: i32,
    pub(crate) owns: bool,
    pub(crate) tally: Tally,
}

impl<P: Physics<Space = Plane>> StripLog<P> {
    pub(crate) fn new(place: &StripRows, rows_in_box: usize) -> Self {
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
            is_negligible: false,
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
    pub(crate) fn renew(&mut self, place: &StripRows) {
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

impl<P: Physics> StripLog<P> {
    pub(crate) fn log(&mut self, latest: &ContactInfo, is_negligible: Option<bool>) {
        self.contacts.push(LoggedContact {
            now: latest.now,
            pair: latest.pair,
        });
        self.is_negligible |= is_negligible.unwrap_or(false);
    }
}
/// How far a row is above an edge: 0 is the first row above it, -1 the first below. With rows in a periodic box.
pub(crate) fn above(row: i32, edge: i32, around: Option<i32>) -> i32 {
    let steps = row - edge;
    match around {
        Some(rows) if 2 * steps >= rows => steps - rows,
        Some(rows) if 2 * steps < -rows => steps + rows,
        _ => steps,
    }
}

/// Mixes a number into another, so that different sequences have different results.
pub(crate) fn mixed(sum: u64, number: u64) -> u64 {
    (sum.rotate_left(23) ^ number).wrapping_mul(0x9e37_79b9_7f4a_7c15)
}
