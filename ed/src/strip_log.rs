//! Log of a strip of a gas, from which neighbouring strips count and check events. See
//! [`crate::strips`].

use std::ops::Range;

use nalgebra::Vector2;
use stosszahl_model::{ParticleModel, Plane, SpinOf};

use crate::cells::CellCoordinates;
use crate::checkpoint::EventCounters;
use crate::collapse::ContactInfo;
use crate::image_flags::ImageFlags;

/// Rows of cells on each side of an edge whose history two strips must agree on. Data that an event
/// reads farther away are compared by [`SeamRecord::candidates`].
pub(crate) const SEAM: i32 = 1;

/// Rows of cells of a strip.
#[derive(Clone, Debug)]
pub(crate) struct StripRows {
    /// Rows that the strip owns.
    pub(crate) core: Range<i32>,
    /// Number of rows of the halo on each side with a neighbouring strip.
    pub(crate) halo: i32,
    /// True if the strip has a neighbouring strip: below, above.
    pub(crate) neighbours: [bool; 2],
    /// Number of rows in the box, if it is periodic across the strips.
    pub(crate) around: Option<i32>,
}

impl StripRows {
    /// Returns all rows of the strip, including halos.
    pub(crate) fn rows(&self) -> impl Iterator<Item = u16> {
        let beyond = |side: usize| i32::from(self.neighbours[side]) * self.halo;
        let rows = self.core.start - beyond(0)..self.core.end + beyond(1);
        let around = self.around;
        rows.map(move |row| around.map_or(row, |rows| row.rem_euclid(rows)) as u16)
    }

    /// Returns true if the strip owns a row.
    pub(crate) fn owns(&self, row: u16) -> bool {
        self.core.contains(&i32::from(row))
    }
}

/// Boundary between two strips, before a row of cells.
#[derive(Clone, Debug)]
pub(crate) struct StripEdge<S> {
    /// Number of the row.
    pub(crate) row: i32,
    /// All records of the seam.
    pub(crate) seam: Vec<SeamRecord<S>>,
    /// Hash of the events in each row, from the farthest below the edge that is simulated to the
    /// farthest above.
    pub(crate) rows: Vec<u64>,
}

/// State of a disk after an event.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SeamRecord<S> {
    pub(crate) time: f64,
    pub(crate) disk: u32,
    pub(crate) home: CellCoordinates,
    pub(crate) position: Vector2<f64>,
    pub(crate) velocity: Vector2<f64>,
    pub(crate) spin: S,
    pub(crate) contact: f64,
    pub(crate) partner: u32,
    pub(crate) partner_count: u16,
    pub(crate) count: u16,
    /// Time of the last contact of the disk, where that is kept.
    pub(crate) last_contact: Option<f64>,
    pub(crate) rebounds: Option<u32>,
    pub(crate) winding: Option<ImageFlags>,
    /// Hash of all disks in the cells around the disk, if the event belongs to a disk on the other
    /// side of the edge.
    pub(crate) candidates: u64,
}

/// Contact of a disk, with another or with a wall or obstacle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct LoggedContact {
    /// Engine time of the contact.
    pub(crate) now: f64,
    /// Disk whose event the contact is, and its partner; [`NONE`] for a wall or obstacle.
    pub(crate) pair: [u32; 2],
}

/// Momentum and energy that a wall or an obstacle has given, by the number of its ledger.
#[derive(Clone, Copy, Debug)]
pub(crate) struct WallImpulse {
    pub(crate) ledger: usize,
    pub(crate) momentum: Vector2<f64>,
    pub(crate) energy: f64,
}

/// Events of one strip in one window of time, for comparison with its neighbours and for the merge.
#[derive(Debug)]
pub(crate) struct StripLog<P: ParticleModel> {
    /// Rows of the strip. Events in its core count; events in its halos are copies from neighbours.
    pub(crate) place: StripRows,
    /// Lower and upper edge of the core; `None` without a neighbouring strip.
    pub(crate) edges: [Option<StripEdge<SpinOf<P>>>; 2],
    pub(crate) contacts: Vec<LoggedContact>,
    pub(crate) given: Vec<WallImpulse>,
    /// Times at which disks crossed from cell to cell, or touched walls without end, since the last
    /// sign of progress.
    pub(crate) idle: Vec<f64>,
    /// Number of such crossings and contacts, including all before.
    pub(crate) idled: u64,
    /// Number of events in all.
    pub(crate) events: u64,
    /// Number of events that count in another strip.
    pub(crate) twice: u64,
    /// Computing time of the window \[s\], which decides the boundaries of the next strips.
    pub(crate) seconds: f64,
    /// True if disks approached negligibly in some contact.
    pub(crate) is_negligible: bool,
    /// Engine time of the last event that counts.
    pub(crate) latest: f64,
    /// Numbers of events, and of contacts that count, at which the log is full.
    pub(crate) most: [u64; 2],
    /// True for rows whose events may matter to neighbours.
    pub(crate) is_near: Vec<bool>,
    /// True for rows with disks that may be wrong: in halos, and in the empty rows beyond them that
    /// disks have entered.
    pub(crate) is_foreign: Vec<bool>,
    /// True if events of the current row may matter to neighbours.
    pub(crate) near: bool,
    /// Row of the disk before its event.
    pub(crate) row: i32,
    /// True if the event is in the core of the strip, which counts it.
    pub(crate) owns: bool,
    /// Work done before the event.
    pub(crate) tally: EventCounters,
}

impl<P: ParticleModel<Space = Plane>> StripLog<P> {
    pub(crate) fn new(place: &StripRows, rows_in_box: usize) -> Self {
        let rows = [place.core.start, place.core.end];
        let edge = |side: usize| {
            place.neighbours[side].then(|| StripEdge {
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
            tally: EventCounters::default(),
        };
        let is_near = |row: i32| {
            let mut edges = window.edges.iter().flatten();
            // A partner is at most in the next row.
            edges.any(|edge| above(row, edge.row, place.around).abs() <= place.halo + 1)
                || !place.core.contains(&row)
        };
        window.is_near = (0..rows_in_box as i32).map(is_near).collect();
        for row in place.rows().filter(|row| !place.owns(*row)) {
            window.is_foreign[usize::from(row)] = true;
        }
        window
    }

    /// Empties the log, for a strip with the rows `place`.
    pub(crate) fn renew(&mut self, place: &StripRows) {
        let rows_in_box = self.is_near.len();
        let mut contacts = std::mem::take(&mut self.contacts);
        contacts.clear();
        *self = Self {
            contacts,
            ..Self::new(place, rows_in_box)
        };
    }

    /// Returns true if the current event is in the core of the strip, which counts it.
    pub(crate) fn owns(&self) -> bool {
        self.owns
    }
}

impl<P: ParticleModel> StripLog<P> {
    pub(crate) fn log(&mut self, latest: &ContactInfo, is_negligible: Option<bool>) {
        self.contacts.push(LoggedContact {
            now: latest.now,
            pair: latest.pair,
        });
        self.is_negligible |= is_negligible.unwrap_or(false);
    }
}
/// Distance of a row above an edge, in rows: 0 is the first row above it, -1 the first below.
/// `around` is the number of rows in a periodic box.
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
