//! Domain decomposition of a disk gas into strips: cuts the gas, exchanges halos between strips,
//! balances their load, and joins the gas again.
//!
//! A disk has one number in all strips: each strip has room for all disks, but holds only some of
//! them. So disks and their lists are copied unchanged.

use stosszahl_model::threads::{self, each_of};
use stosszahl_model::{Field, ParticleModel, Plane, SpinOf, memory};

use crate::calendar::{Calendar, CalendarEntry, EventTimes};
use crate::cells::{NONE, line_of};
use crate::checkpoint::EventCounters;
use crate::collapse::CollapseDetector;
use crate::contact::Candidates;
use crate::disk::DiskSystem;
use crate::engine::EventDrivenEngine;
use crate::image_flags::ImageFlags;
use crate::record::DiskRecord;
use crate::strip_log::{SEAM, StripLog, StripRows};

/// Least width of a halo in rows of cells: the row that neighbouring strips compare, and four rows
/// in which events may be wrong.
pub(super) const LEAST_HALO: i32 = 5;

/// Returns the rows of cells at which `strips` strips of equal height begin and end; `None` if the
/// box has too few rows.
pub(super) fn equal_cuts(rows: i32, strips: usize) -> Option<Vec<i32>> {
    let strips = strips as i64;
    let cuts: Vec<i32> = (0..=strips)
        .map(|number| (i64::from(rows) * number / strips) as i32)
        .collect();
    widest_halo(&cuts).map(|_| cuts)
}

/// Returns boundaries of strips, as rows of cells, moved half-way towards equal work of all strips;
/// unchanged if a strip would get too few rows.
pub(super) fn better_cuts(cuts: &[i32], work: &[f64]) -> Vec<i32> {
    let each = work.iter().sum::<f64>() / work.len() as f64;
    let mut better = cuts.to_vec();
    let mut below = 0.0;
    for (strip, &its) in work.iter().enumerate() {
        let height = f64::from(cuts[strip + 1] - cuts[strip]);
        // Boundaries within this strip, if its work is uniform over its rows.
        for number in 1..work.len() {
            let beyond = each * number as f64 - below;
            if beyond >= 0.0 && beyond < its {
                let best = f64::from(cuts[strip]) + height * beyond / its;
                better[number] = (0.5 * (best + f64::from(cuts[number]))).round() as i32;
            }
        }
        below += its;
    }
    if widest_halo(&better).is_some() {
        better
    } else {
        cuts.to_vec()
    }
}

/// Returns half the number of strips, but at least two; `None` for two strips.
pub(super) fn fewer(strips: usize) -> Option<usize> {
    (strips > 2).then(|| (strips / 2).max(2))
}

/// Returns the boundaries of `strips` strips, selected from those of more strips.
pub(super) fn fewer_cuts(cuts: &[i32], strips: usize) -> Vec<i32> {
    let before = cuts.len() - 1;
    (0..=strips)
        .map(|number| cuts[number * before / strips])
        .collect()
}

/// Returns the largest width of halos in rows of cells such that no row is in more than two strips,
/// and none twice in one; `None` if that is too narrow.
pub(super) fn widest_halo(cuts: &[i32]) -> Option<i32> {
    let least = cuts.windows(2).map(|cut| cut[1] - cut[0]).min()?;
    let widest = least / 2 - SEAM;
    (widest >= LEAST_HALO).then_some(widest)
}

/// Calls `visit` for each disk in some rows of cells, cell by cell. The first disk of a cell is
/// prefetched 64 cells before its turn, and the second 32.
fn visit_rows<F: Field<Plane>>(
    disks: &DiskSystem<F>,
    rows: impl Iterator<Item = u16>,
    mut visit: impl FnMut(u32, &DiskRecord),
) {
    let columns = disks.cells.counts()[0];
    let cells = rows.flat_map(|row| (0..columns).map(move |column| [column, row]));
    let firsts = cells.map(|cell| disks.cells.first(disks.cells.place(cell, 1, 1)));
    let firsts: Vec<u32> = firsts.filter(|&first| first != NONE).collect();
    for (number, &first) in firsts.iter().enumerate() {
        if let Some(&disk) = firsts.get(number + 64) {
            memory::prefetch(&disks.all, disk as usize);
        }
        if let Some(&disk) = firsts.get(number + 32) {
            memory::prefetch(&disks.all, line_of(disks.all[disk as usize].next));
        }
        let mut who = first;
        while who != NONE {
            let disk = &disks.all[who as usize];
            visit(who, disk);
            who = disk.next;
        }
    }
}

/// Returns the indices of the disks in a range of rows of cells.
fn in_rows<F: Field<Plane>>(disks: &DiskSystem<F>, rows: impl Iterator<Item = u16>) -> Vec<u32> {
    let mut numbers = Vec::new();
    visit_rows(disks, rows, |number, _| numbers.push(number));
    numbers
}

/// Disks of some rows of cells with all their data, as one strip passes them to another, in the
/// order of the cell lists.
pub(super) struct Parcel<P: ParticleModel> {
    numbers: Vec<u32>,
    disks: Vec<DiskRecord>,
    spins: Vec<SpinOf<P>>,
    last_contact: Vec<f64>,
    rebounds: Vec<u32>,
    image_flags: Vec<ImageFlags>,
}

impl<P: ParticleModel> Default for Parcel<P> {
    fn default() -> Self {
        Self {
            numbers: Vec::new(),
            disks: Vec::new(),
            spins: Vec::new(),
            last_contact: Vec::new(),
            rebounds: Vec::new(),
            image_flags: Vec::new(),
        }
    }
}

impl<P: ParticleModel<Space = Plane>> Parcel<P> {
    /// Fills the parcel with all disks of some rows of cells of an engine, with their data.
    fn take_rows<Q: Calendar>(
        &mut self,
        from: &EventDrivenEngine<P, Q>,
        rows: impl Iterator<Item = u16>,
    ) {
        self.numbers.clear();
        self.disks.clear();
        visit_rows(&from.disks, rows, |number, disk| {
            self.numbers.push(number);
            self.disks.push(*disk);
        });
        take_rows(&self.numbers, &from.spins, &mut self.spins);
        take_rows(&self.numbers, &from.last_contact, &mut self.last_contact);
        take_rows(&self.numbers, &from.rebounds, &mut self.rebounds);
        take_rows(&self.numbers, &from.image_flags, &mut self.image_flags);
    }

    /// Adds the disks of the parcel to a strip, which must have no disks in these rows of cells.
    fn put_into<Q: Calendar>(&self, strip: &mut EventDrivenEngine<P, Q>) {
        scatter_values(&self.numbers, &self.disks, &mut strip.disks.all);
        scatter_values(&self.numbers, &self.spins, &mut strip.spins);
        scatter_values(&self.numbers, &self.last_contact, &mut strip.last_contact);
        scatter_values(&self.numbers, &self.rebounds, &mut strip.rebounds);
        scatter_values(&self.numbers, &self.image_flags, &mut strip.image_flags);
        // Reverse order, because the list adds at its front.
        for &disk in self.numbers.iter().rev() {
            let place = strip.disks.cells.place(strip.disks.home(disk), 1, 1);
            strip.disks.cells.set_first(place, disk);
            let time = strip.disks.time(disk);
            // Event that is mostly equal to the one the strip knew before.
            strip.calendar.push_once(CalendarEntry { time, disk });
        }
    }
}

/// Copies the values of the listed disks from `all`, with one value for each disk of the gas, to
/// `some`. If `all` is empty, so is `some`.
fn take_rows<T: Copy>(disks: &[u32], all: &[T], some: &mut Vec<T>) {
    some.clear();
    if !all.is_empty() {
        some.extend(disks.iter().map(|&disk| all[disk as usize]));
    }
}

/// Writes the values `some` of the listed disks into `all`, which has one value for each disk of
/// the gas.
fn scatter_values<T: Copy>(disks: &[u32], some: &[T], all: &mut [T]) {
    for (&disk, &its) in disks.iter().zip(some) {
        all[disk as usize] = its;
    }
}

/// Removes disks from the cell lists of a strip; `numbers` must hold all disks of the cells
/// concerned.
fn remove_disks<F: Field<Plane>>(disks: &mut DiskSystem<F>, numbers: &[u32]) {
    for &number in numbers {
        let place = disks.cells.place(disks.home(number), 1, 1);
        disks.cells.set_first(place, NONE);
        disks.all[number as usize] = DiskRecord::absent();
    }
}

/// Creates the engine of one strip: copies the disks of its rows of cells from the whole gas at
/// engine time `now`.
pub(super) fn strip<P: ParticleModel<Space = Plane>, Q: Calendar>(
    whole: &EventDrivenEngine<P, Q>,
    place: &StripRows,
    now: f64,
) -> EventDrivenEngine<P, Q> {
    let mut rows = vec![false; usize::from(whole.disks.cells.counts()[1])];
    for row in place.rows() {
        rows[usize::from(row)] = true;
    }
    let all = &whole.disks.all;
    let mut disks = memory::reserved(all.len());
    disks.extend(all.iter().map(|disk| {
        if rows[usize::from(disk.home[1])] {
            *disk
        } else {
            DiskRecord::absent()
        }
    }));
    let mut cells = whole.disks.cells.emptied();
    cells.copy_rows(&whole.disks.cells, place.rows());
    let disks = DiskSystem::from_grid(disks, whole.disks.motion, cells);
    EventDrivenEngine {
        scene: whole.scene.clone(),
        dissipation: whole.dissipation,
        domain: whole.domain,
        calendar: Q::new(&disks, now),
        knows_events: true,
        disks,
        tags: whole.tags.clone(),
        names: whole.names.clone(),
        spins: whole.spins.clone(),
        last_contact: whole.last_contact.clone(),
        rebounds: whole.rebounds.clone(),
        image_flags: whole.image_flags.clone(),
        surroundings: whole.surroundings.clone(),
        ledgers: Vec::new(),
        candidates: Candidates::new(),
        speed: whole.speed,
        epoch: whole.epoch,
        now,
        time: whole.time,
        tally: EventCounters::default(),
        shear_work: whole.shear_work,
        stale: 0,
        refresh: u64::MAX,
        horizon: f64::INFINITY,
        progress: CollapseDetector::new(0),
        unit: whole.unit,
        stop: whole.stop.clone(),
        parallel: false,
        window: Some(Box::new(StripLog::new(place, rows.len()))),
    }
}

/// Parcels of disks that strips send to each other, indexed by sender; their memory is reused in
/// all time windows.
pub(super) type HaloExchange<P> = Vec<Vec<Parcel<P>>>;

/// Gives each strip new rows of cells and fills its halos with current disks. A strip keeps the
/// rows of its old core; all others come from the strip that had them in its core.
pub(super) fn renew<P: ParticleModel<Space = Plane>, Q: Calendar>(
    strips: &mut [EventDrivenEngine<P, Q>],
    places: &[StripRows],
    parcels: &mut HaloExchange<P>,
) {
    let windows = strips.iter().filter_map(|strip| strip.window.as_ref());
    let old: Vec<StripRows> = windows.map(|window| window.place.clone()).collect();
    let from = &*strips;
    parcels.resize_with(places.len(), Vec::new);
    let parcels_of = parcels.iter_mut().zip(places);
    each_of(true, parcels_of, |number, (parcels, place)| {
        parcels.resize_with(from.len(), Parcel::default);
        for (its, parcel) in parcels.iter_mut().enumerate() {
            let theirs = |row: &u16| its != number && old[its].owns(*row);
            parcel.take_rows(&from[its], place.rows().filter(theirs));
        }
    });
    let renewed = strips
        .iter_mut()
        .zip(&*parcels)
        .zip(places.iter().zip(&old));
    each_of(true, renewed, |_, ((strip, parcels), (place, old))| {
        let mut gone = Vec::new();
        if let Some(window) = &mut strip.window {
            // Rows of the old core that go to other strips.
            for row in old.core.clone() {
                window.is_foreign[row as usize] = true;
            }
            for row in place.rows().filter(|row| old.owns(*row)) {
                window.is_foreign[usize::from(row)] = false;
            }
            let rows = (0..).zip(&window.is_foreign).filter(|(_, its)| **its);
            gone = in_rows(&strip.disks, rows.map(|(row, _)| row));
            remove_disks(&mut strip.disks, &gone);
        }
        for parcel in parcels {
            parcel.put_into(strip);
        }
        // Cancelled events of disks that have left; the calendar would return to them.
        gone.retain(|&disk| strip.disks.all[disk as usize].is_absent());
        for disk in gone {
            let time = f64::INFINITY;
            strip.calendar.push(CalendarEntry { time, disk });
        }
        (strip.tally, strip.stale) = (EventCounters::default(), 0);
        if let Some(window) = &mut strip.window {
            window.renew(place);
        }
    });
}

/// Copies the disks of all strips back into the engine of the whole gas, without filling its
/// calendar.
pub(super) fn join<P: ParticleModel<Space = Plane>, Q: Calendar>(
    whole: &mut EventDrivenEngine<P, Q>,
    strips: &[EventDrivenEngine<P, Q>],
) {
    let owns = |strip: &EventDrivenEngine<P, Q>, disk: usize| {
        let disk = &strip.disks.all[disk];
        let window = strip.window.as_ref();
        !disk.is_absent() && window.is_some_and(|window| window.place.owns(disk.home[1]))
    };
    // Strip whose rows held the disk when the gas was joined last; mostly still right.
    let mut of_row = vec![0_u8; usize::from(whole.disks.cells.counts()[1])];
    for (number, strip) in (0..).zip(strips) {
        let rows = strip.window.iter().flat_map(|its| its.place.core.clone());
        rows.for_each(|row| of_row[row as usize] = number);
    }
    let mut owners = vec![0; whole.disks.all.len()];
    let length = threads::piece(owners.len());
    let disks = whole.disks.all.chunks_mut(length);
    let pieces = disks.zip(owners.chunks_mut(length));
    each_of(true, pieces, |number, (disks, owners)| {
        for (disk, (its, place)) in (number * length..).zip(disks.iter_mut().zip(owners)) {
            let near = of_row[usize::from(its.home[1])];
            let all = 0..strips.len();
            let mut likely = std::iter::once(usize::from(near)).chain(all);
            let owner = likely
                .find(|&strip| owns(&strips[strip], disk))
                .unwrap_or_default();
            debug_assert!(owns(&strips[owner], disk));
            *its = strips[owner].disks.all[disk];
            *place = owner as u8;
        }
    });
    gather_values(&owners, strips, &mut whole.spins, |strip| &strip.spins);
    gather_values(&owners, strips, &mut whole.last_contact, |strip| {
        &strip.last_contact
    });
    gather_values(&owners, strips, &mut whole.rebounds, |strip| {
        &strip.rebounds
    });
    gather_values(&owners, strips, &mut whole.image_flags, |strip| {
        &strip.image_flags
    });
    for strip in strips {
        if let Some(window) = &strip.window {
            let rows = window.place.core.clone().map(|row| row as u16);
            whole.disks.cells.copy_rows(&strip.disks.cells, rows);
        }
    }
}

/// Fills `all`, with one value for each disk, from the lists `of` the strips: each value comes from
/// the strip that owns the disk. Does nothing if `all` is empty.
fn gather_values<E: Sync, T: Copy + Send + Sync>(
    owners: &[u8],
    strips: &[E],
    all: &mut [T],
    of: impl Fn(&E) -> &[T] + Sync,
) {
    let length = threads::piece(all.len());
    let pieces = all.chunks_mut(length).zip(owners.chunks(length));
    each_of(true, pieces, |number, (all, owners)| {
        for (disk, (its, owner)) in (number * length..).zip(all.iter_mut().zip(owners)) {
            *its = of(&strips[usize::from(*owner)])[disk];
        }
    });
}
