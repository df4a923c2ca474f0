//! Disks in their cell lists: flight, cell crossings, line of centres, and the search for the next
//! contact of a disk in the cells around it.

use std::hint::select_unpredictable;
use std::iter;

use nalgebra::Vector2;
use stosszahl_model::{Field, Plane, Sizes, memory};

use crate::calendar::EventTimes;
use crate::cell_list_walk::CellListWalk;
use crate::cells::{self, CellCoordinates, CellLists, NONE, line_of};
use crate::contact::Candidates;
use crate::frames::{CellFrames, Still};
use crate::grid_hierarchy::{self, GridHierarchy, Nearby};
use crate::motion::FlightMotion;
use crate::prefetch_plan::PrefetchPlan;
use crate::record::{DiskRecord, FIRST, VOID};
use crate::sliding_rows::SlidingRows;

/// All disks of a gas with their law of flight, and the cell lists in which they are found.
pub(crate) struct DiskSystem<F> {
    pub(crate) all: Vec<DiskRecord>,
    /// Law of free flight of disks: straight, under gravity, or in a shear flow.
    pub(crate) motion: FlightMotion<F>,
    pub(crate) cells: CellLists,
    /// Rows of cells that slide over each other with a shear flow.
    pub(crate) rows: SlidingRows,
    /// Hierarchy of coarser grids for larger disks, if sizes differ much; `None` in a shear flow.
    pub(crate) levels: Option<GridHierarchy>,
    /// Number of times that the collision count of some disk overflowed and restarted.
    pub(crate) recounts: u64,
}

/// Number of disk records that fit into a usual second-level cache, one cache line each.
const NEAR: usize = 20_000;

impl<F: Field<Plane>> DiskSystem<F> {
    /// Creates the system of disks from their records and from cell lists that already contain
    /// them.
    pub(crate) fn from_grid(
        all: Vec<DiskRecord>,
        motion: FlightMotion<F>,
        cells: CellLists,
    ) -> Self {
        Self {
            all,
            motion,
            cells,
            rows: SlidingRows::none(),
            levels: None,
            recounts: 0,
        }
    }

    #[inline]
    pub(crate) fn home(&self, who: u32) -> CellCoordinates {
        self.all[who as usize].home
    }

    /// Returns the grid of the hierarchy whose cell lists contain a disk, and the memory index of
    /// the disk's cell there.
    #[inline(always)]
    fn listed(&mut self, who: u32) -> (&mut CellLists, usize) {
        let home = self.home(who);
        match &mut self.levels {
            Some(levels) if levels.level_of(who) > 0 => {
                let level = levels.level_of(who);
                let grid = levels.coarse_mut(level);
                let place = grid.place(GridHierarchy::parent(home, level), 1, 1);
                (grid, place)
            }
            _ => {
                let place = self.cells.place(home, 1, 1);
                (&mut self.cells, place)
            }
        }
    }

    pub(crate) fn enter(&mut self, who: u32) {
        let (grid, place) = self.listed(who);
        self.all[who as usize].next = grid.set_first(place, who);
    }

    fn leave(&mut self, who: u32) {
        let next = self.all[who as usize].next;
        let (grid, place) = self.listed(who);
        let mut before = grid.first(place);
        if before == who {
            grid.set_first(place, next);
            return;
        }
        while self.all[before as usize].next != who {
            before = self.all[before as usize].next;
        }
        self.all[before as usize].next = next;
    }

    /// Moves a disk into the next cell along `axis` at engine time `now`. Returns whether it went
    /// forward, and whether it crossed the boundary of the box.
    #[inline(always)]
    pub(crate) fn cross(&mut self, who: u32, axis: usize, now: f64) -> (bool, bool) {
        self.leave(who);
        let width = self.cells.width()[axis];
        let disk = &mut self.all[who as usize];
        self.motion.advance(disk, now);
        let forward = self.motion.goes_forward(disk, axis, width);
        disk.position[axis] += select_unpredictable(forward, -width, width);
        let (next, around) = self.cells.beyond(disk.home[axis], axis, forward);
        if F::SHEARED && axis == 1 {
            let place = disk.position[0];
            let (column, place) = self.rows.cross(disk.home, place, forward, now);
            (disk.home[0], disk.position[0]) = (column, place);
            let slip = self.rows.slip();
            disk.velocity[0] += select_unpredictable(forward, -slip, slip);
        }
        disk.home[axis] = next;
        self.enter(who);
        (forward, around)
    }

    /// Returns the position of a disk at an engine time, relative to the corner of its cell
    /// \[length\].
    #[inline]
    fn position_at(&self, who: u32, time: f64) -> Vector2<f64> {
        self.motion.position_at(&self.all[who as usize], time)
    }

    /// Returns the velocity of a disk at an engine time; in a shear flow, the peculiar velocity.
    #[inline]
    pub(crate) fn velocity(&self, who: u32, time: f64) -> Vector2<f64> {
        let disk = &self.all[who as usize];
        let mut velocity = self.motion.velocity(disk, time);
        if F::SHEARED {
            velocity[0] -= self.rows.flow(self.motion.position_at(disk, time)[1]);
        }
        velocity
    }

    /// Returns the work of the shear flow on a disk of mass one during its flight from its clock to
    /// `time`: the integral of `-a c_x c_y`, with shear rate a and peculiar velocity c.
    #[inline(always)]
    pub(crate) fn work_of_flight(&self, who: u32, time: f64) -> f64 {
        let disk = &self.all[who as usize];
        let (flight, rate) = (time - disk.clock, self.rows.rate());
        let along = disk.velocity[0] - self.rows.flow(disk.position[1]);
        let across = disk.velocity[1];
        -rate * (along - 0.5 * rate * across * flight) * across * flight
    }

    /// Moves a disk along its free flight to an engine time.
    #[inline(always)]
    pub(crate) fn advance(&mut self, who: u32, time: f64) {
        self.motion.advance(&mut self.all[who as usize], time);
    }

    /// Moves a disk to its contact at an engine time, raises its collision count, and erases its
    /// predicted contact.
    #[inline(always)]
    pub(crate) fn meet(&mut self, who: u32, time: f64) {
        let disk = &mut self.all[who as usize];
        self.motion.advance(disk, time);
        disk.contact = f64::INFINITY;
        disk.count = disk.count.wrapping_add(1);
        if disk.count == VOID {
            self.count_again(who);
        }
    }

    /// Restarts the overflowed collision count of a disk, and voids contacts predicted with it at
    /// the old counts.
    #[cold]
    fn count_again(&mut self, who: u32) {
        self.recounts += 1;
        self.all[who as usize].count = FIRST;
        for disk in &mut self.all {
            if disk.partner == who {
                disk.partner_count = VOID;
            }
        }
    }

    /// Returns the position of a disk in the box at an engine time \[length\]; it may lie a little
    /// outside, modulo the sides of the box.
    pub(crate) fn wrapped_position(&self, who: u32, time: f64) -> Vector2<f64> {
        let mut place = self.cells.corner(self.home(who)) + self.position_at(who, time);
        if F::SHEARED {
            place[0] += self.rows.way(self.home(who)[1], time);
        }
        place
    }

    /// Returns the line of centres of two touching disks at the same clock, from `second` to
    /// `first` \[length\], and the velocity of the first's sliding row less that of the second's.
    /// If two periodic images touch, the one that approaches counts.
    #[inline(always)]
    pub(crate) fn line(&self, first: u32, second: u32, distance: f64) -> (Vector2<f64>, f64) {
        let (one, other) = (&self.all[first as usize], &self.all[second as usize]);
        if F::SHEARED {
            return self.sheared_line(one, other, distance);
        }
        let line = one.position - other.position + self.cells.corner_offset(one.home, other.home);
        let line = if self.cells.narrow() {
            let relative = one.velocity - other.velocity;
            let images = self.cells.images_of(line);
            cells::approached(images.map(|line| (line, relative, 0.0)), distance).0
        } else {
            line
        };
        debug_assert!(
            (line.norm() - distance).abs() <= 1e-6 * distance + 2e-9,
            "disks {first} and {second} collide at a distance of {}, not {distance}",
            line.norm()
        );
        (line, 0.0)
    }

    /// Returns true if disks are listed in a hierarchy of several grids, by their sizes.
    #[inline]
    pub(crate) fn hierarchical(&self) -> bool {
        self.levels.is_some()
    }

    /// Returns true if two touching disks slide along each other: their normal approach is slower
    /// than rounding of the line of centres allows to tell. `b` is r . g of separation and relative
    /// velocity.
    #[cold]
    fn is_sliding(&self, first: u32, second: u32, b: f64, distance: f64) -> bool {
        let own = &self.all[first as usize];
        let relative = own.velocity - self.motion.velocity(&self.all[second as usize], own.clock);
        let speed = relative.norm() + self.rows.slip().abs();
        -b <= 8.0 * f64::EPSILON * distance * speed
    }

    /// Returns the test [`Self::is_sliding`] as a function of a candidate of the disk `who` and its
    /// b = r . g.
    #[inline(always)]
    pub(crate) fn slides<S: Sizes>(
        &self,
        who: u32,
        sizes: &S,
        tags: &[S::Tag],
    ) -> impl Fn(u32, f64) -> bool {
        move |other, b| {
            let radii = [who, other].map(|disk| sizes.radius(tags[disk as usize]));
            self.is_sliding(who, other, b, radii[0] + radii[1])
        }
    }

    /// Opens the linked lists of the nine cells around the cell `home`. A cell's number is 4 row +
    /// column, each 0 for the one before, 1 for its own, 2 for the next.
    #[inline(always)]
    pub(crate) fn open(&self, home: CellCoordinates, time: f64) -> CellListWalk {
        let mut lists = CellListWalk::new();
        if F::SHEARED {
            self.open_sliding(&mut lists, home, time, [true; 3]);
            return lists;
        }
        let (x, y) = self.cells.cells_around(home);
        for (row, up) in y.into_iter().enumerate() {
            for (column, right) in x.into_iter().enumerate() {
                let first = self.cells.first((right + up) as usize);
                lists.open(first, 4 * row + column, true);
            }
        }
        lists
    }

    /// Returns all disks in the 3 by 3 cells around a disk, the disk included, with their numbers.
    pub(crate) fn disks_around(&self, who: u32) -> impl Iterator<Item = (u32, &DiskRecord)> {
        let mut lists = self.open(self.home(who), 0.0);
        iter::from_fn(move || lists.next(&self.all)).map(|(number, _, disk)| (number, disk))
    }

    /// Opens the linked lists of the three cells that come into reach when a disk has entered
    /// `home` along an axis: those one step further, forward or backward.
    #[inline(always)]
    fn open_beyond(
        &self,
        home: CellCoordinates,
        (axis, forward): (usize, bool),
        time: f64,
    ) -> CellListWalk {
        let mut lists = CellListWalk::new();
        if F::SHEARED {
            self.open_beyond_sliding(&mut lists, home, (axis, forward), time);
            return lists;
        }
        let [along, across] = if axis == 0 { [1, 4] } else { [4, 1] };
        let places = self.cells.across(home, axis, 1, forward);
        for (step, place) in places.into_iter().enumerate() {
            let cell = 2 * usize::from(forward) * along + step * across;
            lists.open(self.cells.first(place as usize), cell, true);
        }
        lists
    }

    /// Returns the position of a disk in its cell, relative to the corners of the columns and of
    /// the rows around: for each axis before, own, after, and unused.
    #[inline(always)]
    fn relative_positions(&self, position: Vector2<f64>) -> [[f64; 4]; 2] {
        let width = self.cells.width();
        [0, 1].map(|axis| {
            let here = position[axis];
            [here + width[axis], here, here - width[axis], 0.0]
        })
    }

    /// Searches the cells around a disk, which must be advanced to the current time, for an earlier
    /// contact than the one predicted for it; with `beyond`, only the three cells ahead along an
    /// axis. Returns the number of candidates tested.
    #[inline(always)]
    pub(crate) fn search<S: Sizes>(
        &mut self,
        candidates: &mut Candidates,
        who: u32,
        beyond: Option<(usize, bool)>,
        sizes: &S,
        tags: &[S::Tag],
    ) -> u64 {
        if self.cells.wide() {
            return self.search_far(candidates, who, beyond, sizes, tags);
        }
        if !S::UNIFORM
            && let Some(levels) = &self.levels
        {
            let mut found = (None, 0);
            if levels.level_of(who) == 0 {
                found = self.search_cells::<S, false>(candidates, who, beyond, sizes, tags);
                self.expect_first(who, found.0);
            }
            let others = self.search_levels(candidates, who, sizes, tags);
            self.expect_first(who, others.0);
            return found.1 + others.1;
        }
        let (found, predictions) =
            self.search_cells::<S, false>(candidates, who, beyond, sizes, tags);
        self.expect_first(who, found);
        predictions
    }

    /// Searches the wide cells of a dilute gas around a disk for an earlier contact than the one
    /// predicted for it. Returns the number of candidates tested.
    #[cold]
    #[inline(never)]
    fn search_far<S: Sizes>(
        &mut self,
        candidates: &mut Candidates,
        who: u32,
        beyond: Option<(usize, bool)>,
        sizes: &S,
        tags: &[S::Tag],
    ) -> u64 {
        let (found, predictions) =
            self.search_cells::<S, true>(candidates, who, beyond, sizes, tags);
        self.expect_first(who, found);
        predictions
    }

    /// Stores the contact found for the disk `who`, if any: `found` holds the wait from the disk's
    /// clock \[engine time\] and the partner.
    #[inline(always)]
    pub(crate) fn expect_first(&mut self, who: u32, found: Option<(f64, u32)>) {
        if let Some((wait, partner)) = found {
            // An overlap by rounding gives a time just before now.
            let contact = self.all[who as usize].clock + wait.max(0.0);
            self.expect_contact(who, contact, partner);
        }
    }

    /// Stores the next predicted contact of the disk `who`: its engine time and its partner. A
    /// partner beyond all disks is a wall, an obstacle or none.
    #[inline(always)]
    pub(crate) fn expect_contact(&mut self, who: u32, contact: f64, partner: u32) {
        let known = (partner as usize) < self.all.len();
        let other = select_unpredictable(known, partner, who);
        let count = self.all[other as usize].count;
        let disk = &mut self.all[who as usize];
        disk.contact = contact;
        disk.partner = partner;
        disk.partner_count = select_unpredictable(known, count, VOID);
    }

    /// Returns the earliest contact of a disk, if before its predicted one, with disks of the
    /// finest grid, as wait and partner, and the number of candidates tested. `FAR` is true for
    /// wide cells.
    #[inline(always)]
    fn search_cells<S: Sizes, const FAR: bool>(
        &self,
        candidates: &mut Candidates,
        who: u32,
        beyond: Option<(usize, bool)>,
        sizes: &S,
        tags: &[S::Tag],
    ) -> (Option<(f64, u32)>, u64) {
        let home = self.home(who);
        let lists = match beyond {
            None => self.open(home, self.all[who as usize].clock),
            Some(way) => self.open_beyond(home, way, self.all[who as usize].clock),
        };
        self.earliest::<S, FAR>(lists, candidates, who, sizes, tags)
    }

    /// Returns the earliest contact of a disk, if before its predicted one, with disks in all grids
    /// of the hierarchy, as wait and partner, and the number of candidates tested. Pairs of two
    /// disks of the finest level are left to [`Self::search_cells`].
    fn search_levels<S: Sizes>(
        &self,
        candidates: &mut Candidates,
        who: u32,
        sizes: &S,
        tags: &[S::Tag],
    ) -> (Option<(f64, u32)>, u64) {
        let own = &self.all[who as usize];
        let radius = sizes.radius(tags[who as usize]);
        let mut limit = own.contact - own.clock;
        let mut best = None;
        let mut predictions = 0;
        self.around_levels(who, own.clock, radius, false, |other, separation| {
            let distance = radius + sizes.radius(tags[other as usize]);
            let relative = own.velocity - self.velocity(other, own.clock);
            let until_its_own = self.all[other as usize].contact - own.clock;
            let square = distance * distance;
            candidates.add(other, separation, relative, square, until_its_own);
            predictions += 1;
            let found = candidates.earliest(limit, |_, b| self.is_sliding(who, other, b, distance));
            if let Some((time, _)) = found {
                limit = time;
                best = found;
            }
        });
        (best, predictions)
    }

    /// Calls `visit` for each disk near the disk `who` in any grid of the hierarchy, with the
    /// separation from that disk to `who`. If `who` is of the finest level, others of that level
    /// are visited only if `smallest`.
    fn around_levels(
        &self,
        who: u32,
        time: f64,
        radius: f64,
        smallest: bool,
        mut visit: impl FnMut(u32, Vector2<f64>),
    ) {
        let Some(levels) = &self.levels else { return };
        let (home, level) = (self.home(who), levels.level_of(who));
        let at = self.position_at(who, time);
        let mut look = |nearby: Nearby| {
            let mut other = levels.grid(&self.cells, nearby.level).first(nearby.place);
            while other != NONE {
                let disk = &self.all[other as usize];
                let shift =
                    grid_hierarchy::shift(&self.cells, home, self.home(other), nearby.boxes);
                visit(other, at - self.motion.position_at(disk, time) - shift);
                other = disk.next;
            }
        };
        if level > 0 || smallest {
            levels.nine(&self.cells, home, level, &mut look);
        }
        for above in levels.above(level) {
            levels.nine(&self.cells, home, above, &mut look);
        }
        levels.ring(&self.cells, home, level, radius, &mut look);
    }

    /// Returns the earliest contact of a disk with the disks of open cell lists, if before its
    /// predicted one, and the number of candidates tested.
    #[inline(always)]
    pub(crate) fn earliest<S: Sizes, const FAR: bool>(
        &self,
        lists: CellListWalk,
        candidates: &mut Candidates,
        who: u32,
        sizes: &S,
        tags: &[S::Tag],
    ) -> (Option<(f64, u32)>, u64) {
        let own = &self.all[who as usize];
        let mut limit = own.contact - own.clock;
        let mut best = None;
        let looked = self.gather::<S, FAR>(lists, candidates, who, sizes, tags, |candidates| {
            let found = candidates.earliest(limit, self.slides(who, sizes, tags));
            if let Some((time, _)) = found {
                limit = time;
                best = found;
            }
        });
        (best, looked)
    }

    /// Tests all disks of open cell lists as candidates of the disk `who`; `spend` evaluates the
    /// buffer whenever it is full, and at the end. Innermost loop of the engine. Returns the number
    /// of candidates tested. The disk itself is a candidate too, but never touches itself. `FAR` is
    /// true for wide cells.
    #[inline(always)]
    pub(crate) fn gather<S: Sizes, const FAR: bool>(
        &self,
        lists: CellListWalk,
        candidates: &mut Candidates,
        who: u32,
        sizes: &S,
        tags: &[S::Tag],
        spend: impl FnMut(&mut Candidates),
    ) -> u64 {
        let own = &self.all[who as usize];
        if F::SHEARED {
            let frames = self.sliding(own.home, own.position, own.clock);
            self.gather_in::<S, FAR>(&frames, lists, candidates, who, sizes, tags, spend)
        } else {
            let frames = Still(self.relative_positions(own.position));
            self.gather_in::<S, FAR>(&frames, lists, candidates, who, sizes, tags, spend)
        }
    }

    /// Tests all disks of open cell lists as candidates of the disk `who`, with positions and
    /// velocities in the `frames` of the cells. Returns the number of candidates tested.
    #[expect(clippy::too_many_arguments, reason = "two callers, a few lines above")]
    #[inline(always)]
    fn gather_in<S: Sizes, const FAR: bool>(
        &self,
        frames: &impl CellFrames,
        mut lists: CellListWalk,
        candidates: &mut Candidates,
        who: u32,
        sizes: &S,
        tags: &[S::Tag],
        mut spend: impl FnMut(&mut Candidates),
    ) -> u64 {
        let own = &self.all[who as usize];
        let (velocity, clock) = (own.velocity, own.clock);
        let radius = sizes.radius(tags[who as usize]);
        let distance = |other: u32| {
            if S::UNIFORM {
                2.0 * radius
            } else {
                radius + sizes.radius(tags[other as usize])
            }
        };
        loop {
            let mut more = false;
            while !more && let Some((other, cell, disk)) = lists.next(&self.all) {
                let position = self.motion.position_at(disk, clock);
                let separation = frames.separation(cell, position);
                let relative = frames.relative(cell, velocity - self.motion.velocity(disk, clock));
                let square = distance(other) * distance(other);
                let until_its_own = disk.contact - clock;
                more = if FAR {
                    candidates.add_far(other, separation, relative, square, until_its_own)
                } else {
                    candidates.add(other, separation, relative, square, until_its_own)
                };
            }
            spend(candidates);
            if !more {
                return lists.followed();
            }
        }
    }

    /// Returns the deepest overlap of a disk with any other disk at an engine time \[length\]; 0
    /// without overlap. `distance` gives the contact distance to a disk.
    pub(crate) fn overlap(
        &self,
        who: u32,
        time: f64,
        radius: f64,
        distance: impl Fn(u32) -> f64,
    ) -> f64 {
        if self.levels.is_some() {
            let mut worst = 0.0_f64;
            self.around_levels(who, time, radius, true, |other, apart| {
                if other != who {
                    worst = worst.max(distance(other) - apart.norm());
                }
            });
            return worst;
        }
        let lists = self.open(self.home(who), time);
        let at = self.position_at(who, time);
        if F::SHEARED {
            let frames = self.sliding(self.home(who), at, time);
            self.overlap_in(&frames, lists, who, time, distance)
        } else {
            let frames = Still(self.relative_positions(at));
            self.overlap_in(&frames, lists, who, time, distance)
        }
    }

    /// Returns the deepest overlap of a disk with the disks of open cell lists \[length\], with
    /// positions in the `frames` of the cells; 0 without overlap.
    fn overlap_in(
        &self,
        frames: &impl CellFrames,
        mut lists: CellListWalk,
        who: u32,
        time: f64,
        distance: impl Fn(u32) -> f64,
    ) -> f64 {
        let mut worst = 0.0_f64;
        while let Some((other, cell, disk)) = lists.next(&self.all) {
            if other != who {
                let apart = frames.separation(cell, self.motion.position_at(disk, time));
                worst = worst.max(distance(other) - apart.norm());
            }
        }
        worst
    }

    /// Returns the memory that disks and cell lists occupy \[bytes\].
    pub(crate) fn memory_bytes(&self) -> usize {
        self.all.capacity() * size_of::<DiskRecord>()
            + self.cells.memory_bytes()
            + self.levels.as_ref().map_or(0, GridHierarchy::memory_bytes)
    }
}

impl<F: Field<Plane>> EventTimes for DiskSystem<F> {
    fn disks(&self) -> u32 {
        self.all.len() as u32
    }

    #[inline]
    fn time(&self, disk: u32) -> f64 {
        let disk = &self.all[disk as usize];
        let exit = self.motion.exit(disk, self.cells.width()).0;
        if disk.contact <= exit {
            disk.contact
        } else {
            exit
        }
    }

    #[inline]
    fn foresighted(&self) -> bool {
        self.all.len() > NEAR
    }

    #[inline]
    fn expect(&self, disks: &[u32], ahead: usize, end: f64, plan: &mut PrefetchPlan) {
        self.prefetch(disks, ahead, end, plan);
    }

    #[inline]
    fn prefetch_partner(&self, disk: u32) -> usize {
        let line = line_of(self.all[disk as usize].partner);
        memory::prefetch_next(&self.all, line);
        line
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use stosszahl_model::Domain;
    use stosszahl_model::samples::{self, EqualDisks, disks};

    use super::*;
    use crate::record::ABSENT;
    use crate::{Calendar, DissipationRule, EventDrivenEngine};
    use nalgebra::vector;

    /// Creates elastic unit disks in a square periodic box.
    pub(crate) fn gas<Q: Calendar>(
        length: f64,
        bodies: impl IntoIterator<Item = (Vector2<f64>, Vector2<f64>)>,
    ) -> EventDrivenEngine<EqualDisks, Q> {
        let domain = Domain::periodic(vector![length, length]).expect("a box");
        let start = samples::state(domain, bodies);
        EventDrivenEngine::new(disks(1.0), DissipationRule::Elastic, start).expect("an engine")
    }

    /// Creates disks on a square lattice, with speeds of no pattern.
    pub(crate) fn lattice<Q: Calendar>(side: u32) -> EventDrivenEngine<EqualDisks, Q> {
        let body = |index: u32| {
            let place = vector![f64::from(index % side), f64::from(index / side)] * 1.5;
            let angle = f64::from(index) * f64::from(index);
            (place, vector![angle.sin(), angle.cos()])
        };
        gas(1.5 * f64::from(side), (0..side * side).map(body))
    }

    fn engine() -> EventDrivenEngine<EqualDisks> {
        lattice(8)
    }

    /// A contact predicted before its partner counted all the way round is void.
    #[test]
    fn a_count_that_comes_up_again_is_told_from_the_first() {
        let mut disks = engine().disks;
        let before = disks.all[1].count;
        (disks.all[0].partner, disks.all[0].partner_count) = (1, before);
        (disks.all[2].partner, disks.all[2].partner_count) = (3, before);
        for _ in FIRST..=u16::MAX {
            disks.meet(1, 0.0);
            // No prediction may mistake the count for the mark of an absent disk.
            assert!(![VOID, ABSENT].contains(&disks.all[1].count));
        }
        assert_eq!(disks.all[1].count, before);
        assert_ne!(disks.all[0].partner_count, before);
        assert_eq!(disks.all[2].partner_count, before);
    }

    /// Disks whose counts restart collide as before: each of them does so within 20 of its 60 or so
    /// collisions.
    #[test]
    fn counting_anew_changes_nothing() {
        let (mut plain, mut late) = (engine(), engine());
        for disk in &mut late.disks.all {
            let shift = u16::MAX - 20;
            disk.count += shift;
            disk.partner_count += if disk.partner == NONE { 0 } else { shift };
        }
        for engine in [&mut plain, &mut late] {
            engine
                .advance(f64::INFINITY, 2000, &mut ())
                .expect("collisions");
        }
        let counts = late.disks.all.iter().map(|disk| disk.count);
        assert!(
            counts.max().is_some_and(|most| most < 1000),
            "all began anew"
        );
        assert_eq!(plain.tally(), late.tally());
        assert_eq!(plain.state().bodies, late.state().bodies);
    }
}
