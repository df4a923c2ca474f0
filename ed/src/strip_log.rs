//! Event log of one strip of a decomposed gas in one time window, from which neighbouring strips
//! count and verify events. See [`crate::strips`].

use std::ops::Range;

use nalgebra::Vector2;
use stosszahl_model::{ParticleModel, Plane, SpinOf};

use crate::cells::CellCoordinates;
use crate::checkpoint::EventCounters;
use crate::collapse::ContactInfo;
use crate::image_flags::ImageFlags;

/// Rows of cells on each side of a boundary between strips in which both strips' event histories
/// must agree. Data that an event reads farther away are compared by [`SeamRecord::candidates`].
pub(crate) const SEAM: i32 = 1;

/// Rows of cells that one strip of a decomposed gas simulates: its own core, and halos.
#[derive(Clone, Debug)]
pub(crate) struct StripRows {
    /// Rows of cells that the strip owns; it counts their events.
    pub(crate) core: Range<i32>,
    /// Width of the halo on each side with a neighbouring strip, in rows of cells.
    pub(crate) halo: i32,
    /// True if the strip has a neighbouring strip below, and above.
    pub(crate) neighbours: [bool; 2],
    /// Number of rows in the box, if it is periodic across the strips; `None` with walls there.
    pub(crate) around: Option<i32>,
}

impl StripRows {
    /// Returns all rows of cells that the strip simulates, core and halos.
    pub(crate) fn rows(&self) -> impl Iterator<Item = u16> {
        let beyond = |side: usize| i32::from(self.neighbours[side]) * self.halo;
        let rows = self.core.start - beyond(0)..self.core.end + beyond(1);
        let around = self.around;
        rows.map(move |row| around.map_or(row, |rows| row.rem_euclid(rows)) as u16)
    }

    /// Returns true if a row of cells is in the core of the strip.
    pub(crate) fn owns(&self, row: u16) -> bool {
        self.core.contains(&i32::from(row))
    }
}

/// Boundary between two strips, with the events logged near it by one of them.
#[derive(Clone, Debug)]
pub(crate) struct StripEdge<S> {
    /// Number of the first row of cells above the boundary between two strips.
    pub(crate) row: i32,
    /// Records of disks after each event in the rows next to the boundary (the seam), in order of
    /// time.
    pub(crate) seam: Vec<SeamRecord<S>>,
    /// Hash of the events in each row of cells, from the farthest simulated row below the boundary
    /// to the farthest above.
    pub(crate) rows: Vec<u64>,
}

/// State of a disk after an event near the boundary between two strips, for comparison of their
/// histories.
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
    /// Time of the last contact of the disk; `None` unless the TC model needs it.
    pub(crate) last_contact: Option<f64>,
    pub(crate) rebounds: Option<u32>,
    pub(crate) winding: Option<ImageFlags>,
    /// Hash of all disks in the cells around the disk, if the event belongs to a disk on the other
    /// side of the strip boundary; else 0.
    pub(crate) candidates: u64,
}

/// Contact of a disk with another disk, a wall or an obstacle, in the log of a strip.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct LoggedContact {
    /// Engine time of the contact.
    pub(crate) now: f64,
    /// Disk whose event the contact was, and its partner; [`NONE`] for a wall or obstacle.
    pub(crate) pair: [u32; 2],
}

/// Momentum and energy that a wall or an obstacle gives to a disk at one contact, with the index of
/// its ledger.
#[derive(Clone, Copy, Debug)]
pub(crate) struct WallImpulse {
    pub(crate) ledger: usize,
    pub(crate) momentum: Vector2<f64>,
    pub(crate) energy: f64,
}

/// Log of the events of one strip in one time window, for comparison with neighbouring strips and
/// for the merge of all logs.
#[derive(Debug)]
pub(crate) struct StripLog<P: ParticleModel> {
    /// Rows of cells of the strip. Events in its core count; events in its halos also happen in
    /// neighbouring strips.
    pub(crate) place: StripRows,
    /// Boundary of the core with the strip below, and with the strip above; `None` without a
    /// neighbour.
    pub(crate) edges: [Option<StripEdge<SpinOf<P>>>; 2],
    pub(crate) contacts: Vec<LoggedContact>,
    pub(crate) given: Vec<WallImpulse>,
    /// Engine times of cell crossings, and of contacts with walls in runs without an end time,
    /// since the last collision: evidence of a lack of progress.
    pub(crate) idle: Vec<f64>,
    /// Number of cell crossings and contacts with walls logged, including those before the last
    /// collision.
    pub(crate) idled: u64,
    /// Number of events of the strip in the time window, halos included.
    pub(crate) events: u64,
    /// Number of events in the halos, which count in a neighbouring strip.
    pub(crate) twice: u64,
    /// Computing time that the strip needed for the time window \[s\], for load balancing.
    pub(crate) seconds: f64,
    /// True if some contact in the window had a negligible approach speed, a sign of inelastic
    /// collapse.
    pub(crate) is_negligible: bool,
    /// Engine time of the last event in the core of the strip.
    pub(crate) latest: f64,
    /// Largest numbers of events, and of contacts in the core, that the log holds before the strip
    /// stops.
    pub(crate) most: [u64; 2],
    /// True for each row of cells near a boundary with another strip, where events may matter to
    /// that strip.
    pub(crate) is_near: Vec<bool>,
    /// True for each row of cells whose disks another strip owns: rows of halos, and rows beyond
    /// them that disks have entered.
    pub(crate) is_foreign: Vec<bool>,
    /// True if the row of the current event is near a boundary with another strip.
    pub(crate) near: bool,
    /// Row of cells that the disk of the current event was in before it.
    pub(crate) row: i32,
    /// True if the current event is in the core of the strip, where it counts.
    pub(crate) owns: bool,
    /// Work counters before the current event, restored if another strip counts it.
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

    /// Empties the log for the next time window of a strip with the rows of cells `place`.
    pub(crate) fn renew(&mut self, place: &StripRows) {
        let rows_in_box = self.is_near.len();
        let mut contacts = std::mem::take(&mut self.contacts);
        contacts.clear();
        *self = Self {
            contacts,
            ..Self::new(place, rows_in_box)
        };
    }

    /// Returns true if the current event is in the core of the strip, where it counts.
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
/// Returns the signed distance of a row of cells from the boundary between two strips: 0 is the
/// first row above it, -1 the first below. `around` is the number of rows of a periodic box.
pub(crate) fn above(row: i32, edge: i32, around: Option<i32>) -> i32 {
    let steps = row - edge;
    match around {
        Some(rows) if 2 * steps >= rows => steps - rows,
        Some(rows) if 2 * steps < -rows => steps + rows,
        _ => steps,
    }
}

/// Returns a hash of the number appended to the sequence with the hash `sum`.
pub(crate) fn mixed(sum: u64, number: u64) -> u64 {
    (sum.rotate_left(23) ^ number).wrapping_mul(0x9e37_79b9_7f4a_7c15)
}
