//! Cutting a gas into strips, and putting it together again: both take disks out of other gases, with all that is known
//! about them.

use std::ops::Range;

use rayon::prelude::*;
use stosszahl_model::{Physics, Plane, Sizes, SpinOf, memory};

use super::window::Window;
use crate::calendar::Calendar;
use crate::cells::NONE;
use crate::checkpoint::Tally;
use crate::contact::Candidates;
use crate::disk::{Disk, Disks, VOID};
use crate::engine::Engine;
use crate::progress::Progress;
use crate::windings::Winding;

/// Where the rows of cells of a strip lie.
#[derive(Clone, Debug)]
pub(super) struct Place {
    /// Rows that are its own.
    pub(super) core: Range<i32>,
    /// Rows that it simulates with them on each side where there is a neighbour.
    pub(super) halo: i32,
    /// Whether there is one below and above.
    pub(super) neighbours: [bool; 2],
    /// Rows in the box, if it is periodic across the strips.
    pub(super) around: Option<i32>,
}

impl Place {
    /// All its rows.
    fn rows(&self) -> Vec<u16> {
        let beyond = |side: usize| i32::from(self.neighbours[side]) * self.halo;
        let rows = self.core.start - beyond(0)..self.core.end + beyond(1);
        rows.map(|row| self.around.map_or(row, |rows| row.rem_euclid(rows)) as u16)
            .collect()
    }
}

/// A gas that disks are taken from, in the rows where it is right.
struct Source<'a, P: Physics<Space = Plane>, Q: Calendar> {
    engine: &'a Engine<P, Q>,
    /// Numbers of its disks in the whole gas; empty if it is the whole.
    numbers: &'a [u32],
    rows: Range<i32>,
}

impl<P: Physics<Space = Plane>, Q: Calendar> Source<'_, P, Q> {
    fn number(&self, disk: u32) -> u32 {
        if self.numbers.is_empty() {
            disk
        } else {
            self.numbers[disk as usize]
        }
    }
}

/// The strips of a gas, or itself if there are none.
fn sources<'a, P: Physics<Space = Plane>, Q: Calendar>(
    whole: &'a Engine<P, Q>,
    strips: &'a [Engine<P, Q>],
) -> Vec<Source<'a, P, Q>> {
    let strip = |engine: &'a Engine<P, Q>| {
        let window = engine.window.as_ref()?;
        Some(Source {
            engine,
            numbers: &window.numbers,
            rows: window.core.clone(),
        })
    };
    let mut sources: Vec<_> = strips.iter().filter_map(strip).collect();
    if sources.is_empty() {
        sources.push(Source {
            engine: whole,
            numbers: &[],
            rows: 0..i32::from(whole.disks.cells.counts()[1]),
        });
    }
    sources
}

/// Memory for what is needed while disks are taken.
#[derive(Debug, Default)]
pub(super) struct Scratch {
    /// The disks that are taken from each source, in ascending order.
    listed: Vec<Vec<u32>>,
    /// All of them, as source and number there, in the order of their numbers in the whole gas.
    order: Vec<(u8, u32)>,
    /// For each disk of each source, its place in that order, or [`NONE`].
    here: Vec<Vec<u32>>,
}

/// What a strip that is not needed any more leaves: its memory.
pub(super) struct Spare<P: Physics<Space = Plane>> {
    disks: Option<Disks<P::Field>>,
    numbers: Vec<u32>,
    scratch: Scratch,
}

impl<P: Physics<Space = Plane>> Spare<P> {
    /// None.
    fn nothing() -> Self {
        Self {
            disks: None,
            numbers: Vec::new(),
            scratch: Scratch::default(),
        }
    }
}

/// The disks of some rows.
pub(super) struct Taken<P: Physics<Space = Plane>> {
    /// Their numbers in the whole gas, in ascending order.
    numbers: Vec<u32>,
    scratch: Scratch,
    disks: Disks<P::Field>,
    tags: Vec<<P::Sizes as Sizes>::Tag>,
    names: Vec<u32>,
    spins: Vec<SpinOf<P>>,
    last_contact: Vec<f64>,
    rebounds: Vec<u32>,
    windings: Vec<Winding>,
}

impl<P: Physics<Space = Plane>> Taken<P> {
    /// Takes the disks of some rows out of the strips of a gas, or out of itself if there are none.
    pub(super) fn new<Q: Calendar>(
        whole: &Engine<P, Q>,
        strips: &[Engine<P, Q>],
        rows: &[u16],
        spare: Spare<P>,
    ) -> Self {
        let sources = sources(whole, strips);
        let Spare {
            disks: spare,
            mut numbers,
            mut scratch,
        } = spare;
        scratch.list(&sources, rows);
        let Scratch { order, here, .. } = &scratch;
        numbers.clear();
        numbers.par_extend(
            (order.par_iter()).map(|&(source, disk)| sources[usize::from(source)].number(disk)),
        );
        let (mut all, mut cells) = match spare {
            Some(Disks { all, mut cells, .. }) => {
                cells.clear();
                (all, cells)
            }
            None => (memory::reserved(order.len()), whole.disks.cells.emptied()),
        };
        all.clear();
        all.par_extend((order.par_iter().zip(0..order.len() as u32)).map(
            |(&(source, old), new)| {
                let source = usize::from(source);
                moved(&sources[source], old, &here[source], &numbers, new)
            },
        ));
        for (source, here) in sources.iter().zip(here) {
            let right = |row: &&u16| source.rows.contains(&i32::from(**row));
            let rows: Vec<u16> = rows.iter().filter(right).copied().collect();
            let number = |disk: u32| here[disk as usize];
            cells.copy_rows(&source.engine.disks.cells, &rows, number);
        }
        let origins = Origins {
            sources: &sources,
            order,
        };
        Self {
            disks: Disks::of(all, whole.disks.motion, cells),
            tags: origins.gather(true, |engine, disk| engine.tags[disk]),
            names: origins.gather(true, |engine, disk| engine.names[disk]),
            spins: origins.gather(!whole.spins.is_empty(), |engine, disk| engine.spins[disk]),
            last_contact: origins.gather(!whole.last_contact.is_empty(), |engine, disk| {
                engine.last_contact[disk]
            }),
            rebounds: origins.gather(!whole.rebounds.is_empty(), |engine, disk| {
                engine.rebounds[disk]
            }),
            windings: origins.gather(!whole.windings.is_empty(), |engine, disk| {
                engine.windings[disk]
            }),
            numbers,
            scratch,
        }
    }
}

/// Where disks are taken from, in order.
struct Origins<'a, P: Physics<Space = Plane>, Q: Calendar> {
    sources: &'a [Source<'a, P, Q>],
    order: &'a [(u8, u32)],
}

impl<P: Physics<Space = Plane>, Q: Calendar> Origins<'_, P, Q> {
    /// Something of each disk, if there is such a thing.
    fn gather<T: Send>(
        &self,
        is_there: bool,
        of: impl Fn(&Engine<P, Q>, usize) -> T + Send + Sync,
    ) -> Vec<T> {
        if !is_there {
            return Vec::new();
        }
        let each = self.order.par_iter();
        each.map(|&(source, disk)| of(self.sources[usize::from(source)].engine, disk as usize))
            .collect()
    }
}

impl Scratch {
    /// Lists and orders the disks of some rows.
    fn list<P: Physics<Space = Plane>, Q: Calendar>(
        &mut self,
        sources: &[Source<'_, P, Q>],
        rows: &[u16],
    ) {
        self.listed.resize_with(sources.len(), Vec::new);
        self.here.resize_with(sources.len(), Vec::new);
        for (source, listed) in sources.iter().zip(&mut self.listed) {
            listed.clear();
            let mut wanted = vec![false; usize::from(source.engine.disks.cells.counts()[1])];
            let right = |row: &u16| source.rows.contains(&i32::from(*row));
            for row in rows.iter().copied().filter(right) {
                wanted[usize::from(row)] = true;
            }
            if wanted.contains(&true) {
                let disks = source.engine.disks.all.iter().zip(0..);
                let disks = disks.filter(|(disk, _)| wanted[usize::from(disk.home[1])]);
                listed.extend(disks.map(|(_, number)| number));
            }
        }
        self.put_in_order(sources);
        for ((source, here), listed) in sources.iter().zip(&mut self.here).zip(&self.listed) {
            let disks = if listed.is_empty() {
                0
            } else {
                source.engine.disks.all.len()
            };
            here.clear();
            here.resize(disks, NONE);
        }
        for (&(source, old), new) in self.order.iter().zip(0..) {
            self.here[usize::from(source)][old as usize] = new;
        }
    }

    fn put_in_order<P: Physics<Space = Plane>, Q: Calendar>(
        &mut self,
        sources: &[Source<'_, P, Q>],
    ) {
        let listed = &self.listed;
        self.order.clear();
        self.order.reserve(listed.iter().map(Vec::len).sum());
        let number = |source: usize, at: usize| {
            let disk = listed[source].get(at);
            disk.map_or(u32::MAX, |&disk| sources[source].number(disk))
        };
        let mut heads: Vec<(u32, usize, usize)> = (0..listed.len())
            .map(|source| (number(source, 0), source, 0))
            .collect();
        loop {
            heads.sort_unstable();
            let (first, source, mut at) = heads[0];
            if first == u32::MAX {
                return;
            }
            // Disks that follow each other are mostly in the same strip.
            let until = heads.get(1).map_or(u32::MAX, |next| next.0);
            let mut next = first;
            while next < until {
                self.order.push((source as u8, listed[source][at]));
                at += 1;
                next = number(source, at);
            }
            heads[0] = (next, source, at);
        }
    }
}

/// A disk of a source with the numbers that it and others have among those that are taken.
fn moved<P: Physics<Space = Plane>, Q: Calendar>(
    source: &Source<'_, P, Q>,
    old: u32,
    here: &[u32],
    numbers: &[u32],
    new: u32,
) -> Disk {
    let all = &source.engine.disks.all;
    let mut disk = all[old as usize];
    if disk.next != NONE {
        disk.next = here[disk.next as usize];
        debug_assert!(disk.next != NONE, "a list of disks lies in one source");
    }
    let known = all.len() as u32;
    if disk.partner == NONE {
        return disk;
    }
    if disk.partner >= known {
        disk.partner = disk.partner - known + numbers.len() as u32;
    } else if here[disk.partner as usize] != NONE {
        disk.partner = here[disk.partner as usize];
    } else if let Ok(place) = numbers.binary_search(&source.number(disk.partner)) {
        disk.partner = place as u32;
    } else {
        // The partner is beyond: the disk looks anew when they would touch.
        (disk.partner, disk.partner_count) = (new, VOID);
    }
    disk
}

/// Cuts a strip out of a gas, which may be in strips already. It goes on from an own time, and stops when so many events
/// or contacts are logged. A `spare` strip gives its memory.
pub(super) fn strip<P: Physics<Space = Plane>, Q: Calendar>(
    whole: &Engine<P, Q>,
    strips: &[Engine<P, Q>],
    place: &Place,
    now: f64,
    most: [u64; 2],
    spare: Option<Engine<P, Q>>,
) -> Engine<P, Q> {
    let mut old = Spare::nothing();
    let (mut calendar, mut log) = (None, Vec::new());
    if let Some(spare) = spare {
        old.disks = Some(spare.disks);
        calendar = Some(spare.calendar);
        if let Some(window) = spare.window {
            (old.numbers, old.scratch) = (window.numbers, window.scratch);
            log = window.contacts;
        }
    }
    let taken = Taken::new(whole, strips, &place.rows(), old);
    let calendar = match calendar {
        Some(mut calendar) => {
            calendar.renew(&taken.disks, now);
            calendar
        }
        None => Q::new(&taken.disks, now),
    };
    let rows = whole.disks.cells.counts()[1];
    let mut window = Window::new(taken.numbers, place, rows, most, log);
    window.scratch = taken.scratch;
    Engine {
        scene: whole.scene.clone(),
        dissipation: whole.dissipation,
        domain: whole.domain,
        calendar,
        disks: taken.disks,
        tags: taken.tags,
        names: taken.names,
        spins: taken.spins,
        last_contact: taken.last_contact,
        rebounds: taken.rebounds,
        windings: taken.windings,
        surroundings: whole.surroundings.clone(),
        ledgers: Vec::new(),
        candidates: Candidates::new(),
        speed: whole.speed,
        epoch: whole.epoch,
        now,
        time: whole.time,
        tally: Tally::default(),
        stale: 0,
        refresh: u64::MAX,
        horizon: f64::INFINITY,
        progress: Progress::new(0),
        unit: whole.unit,
        stop: whole.stop.clone(),
        spread: super::Spread::default(),
        window: Some(Box::new(window)),
    }
}

/// Puts a gas together from its strips, without its calendar.
pub(super) fn join<P: Physics<Space = Plane>, Q: Calendar>(
    whole: &mut Engine<P, Q>,
    strips: Vec<Engine<P, Q>>,
) {
    let rows: Vec<u16> = (0..whole.disks.cells.counts()[1]).collect();
    let taken = Taken::new(whole, &strips, &rows, Spare::nothing());
    drop(strips);
    whole.disks = taken.disks;
    (whole.tags, whole.names) = (taken.tags, taken.names);
    (whole.spins, whole.last_contact) = (taken.spins, taken.last_contact);
    (whole.rebounds, whole.windings) = (taken.rebounds, taken.windings);
}

/// Frees what the strips have of a gas now.
pub(super) fn empty<P: Physics<Space = Plane>, Q: Calendar>(whole: &mut Engine<P, Q>) {
    whole.forget_events();
    whole.disks.all = Vec::new();
}
