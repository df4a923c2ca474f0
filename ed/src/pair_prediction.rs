//! Prediction of the next contacts of two disks that have just collided, for both at once in the
//! two lanes of a SIMD vector.

use std::hint::select_unpredictable;

use nalgebra::Vector2;
use stosszahl_model::{Field, Plane, Sizes, memory};
use wide::f64x2;

use crate::cell_list_walk::CellListWalk;
use crate::cells::{NONE, line_of};
use crate::disk::DiskSystem;

/// Number of columns, and of rows, in the block of cells around two adjacent cells.
const SIDE: usize = 4;

/// Bit mask of the nine cells around one disk, among the 16 cells around a pair; to be shifted to
/// the first of the nine.
const AROUND_ONE: u32 = 0x0777;

impl<F: Field<Plane>> DiskSystem<F> {
    /// Predicts the next contacts of two disks at the same clock, in the same cell or adjacent
    /// ones. Returns the number of candidates tested, or `None` if the disks must be predicted
    /// separately.
    ///
    /// For two disks that separate, the contacts equal those of separate predictions, bit by bit.
    /// Most disks near one are also near the other, so that they are read and advanced once for the
    /// two lanes of a vector. A disk near only one of them has the position NaN for the other, and
    /// never touches it.
    #[inline(always)]
    pub(crate) fn predict_pair<S: Sizes>(
        &mut self,
        first: u32,
        second: u32,
        sizes: &S,
        tags: &[S::Tag],
    ) -> Option<u64> {
        if F::SHEARED {
            return self.predict_sliding_pair(first, second, sizes, tags);
        }
        if (!S::UNIFORM && self.hierarchical()) || self.cells.wide() {
            return None;
        }
        let homes = [self.home(first), self.home(second)];
        let (columns, right) = self.cells.around_both(homes[0], homes[1], 0)?;
        let (rows, up) = self.cells.around_both(homes[0], homes[1], 1)?;
        let one = AROUND_ONE << (right[0] + SIDE * up[0]);
        let other = AROUND_ONE << (right[1] + SIDE * up[1]);
        let (any, shared) = (one | other, one & other);
        let hidden = [self.hide(first), self.hide(second)];
        let mut lists: CellListWalk = CellListWalk::new();
        for (row, up) in rows.into_iter().enumerate() {
            for (column, right) in columns.into_iter().enumerate() {
                let cell = SIDE * row + column;
                let first = self.cells.first((right + up) as usize);
                memory::prefetch_next(&self.all, line_of(first));
                lists.open(first, cell, any >> cell & 1 == 1);
            }
        }
        for (place, first) in hidden.into_iter().rev() {
            self.cells.set_first(place, first);
        }

        let (a, b) = (&self.all[first as usize], &self.all[second as usize]);
        let width = self.cells.width();
        let frames = StillPair {
            x: relative_to_columns([a.position[0], b.position[0]], width[0], right),
            y: relative_to_columns([a.position[1], b.position[1]], width[1], up),
        };
        self.earliest_of_pair(lists, &frames, shared, [first, second], sizes, tags)
    }

    /// Finds and stores the next contacts of two disks among the disks of open cell lists, in the
    /// innermost loop of the pair prediction. `shared` is the bit mask of cells around both disks.
    /// Returns the number of candidates tested, or `None` if the disks must be predicted
    /// separately.
    #[inline(always)]
    pub(crate) fn earliest_of_pair<S: Sizes, const RING: usize>(
        &mut self,
        mut lists: CellListWalk<RING>,
        frames: &impl PairFrames,
        shared: u32,
        [first, second]: [u32; 2],
        sizes: &S,
        tags: &[S::Tag],
    ) -> Option<u64> {
        let (a, b) = (&self.all[first as usize], &self.all[second as usize]);
        let clock = a.clock;
        let velocity = [
            f64x2::new([a.velocity[0], b.velocity[0]]),
            f64x2::new([a.velocity[1], b.velocity[1]]),
        ];
        let radii = [
            sizes.radius(tags[first as usize]),
            sizes.radius(tags[second as usize]),
        ];
        let square = |distance: f64x2| distance * distance;
        let uniform = square(f64x2::splat(2.0 * radii[0]));

        let mut limit = f64x2::splat(f64::INFINITY);
        let mut best = f64x2::splat(f64::from_bits(u64::from(NONE)));
        let mut twice = 0;
        while let Some((disk, cell, candidate)) = lists.next(&self.all) {
            twice += u64::from(shared >> cell & 1);
            let position: Vector2<f64> = self.motion.position_at(candidate, clock);
            let speed = self.motion.velocity(candidate, clock);
            let corners = frames.corners(cell);
            let separation = [
                corners[0] - f64x2::splat(position[0]),
                corners[1] - f64x2::splat(position[1]),
            ];
            let relative = [
                frames.along(cell, velocity[0] - f64x2::splat(speed[0])),
                velocity[1] - f64x2::splat(speed[1]),
            ];
            let distance_squared = if S::UNIFORM {
                uniform
            } else {
                let radius = sizes.radius(tags[disk as usize]);
                square(f64x2::new(radii) + f64x2::splat(radius))
            };
            let b = separation[0] * relative[0] + separation[1] * relative[1];
            let c =
                separation[0] * separation[0] + separation[1] * separation[1] - distance_squared;
            let g = relative[0] * relative[0] + relative[1] * relative[1];
            // NaN for disks that miss each other or separate.
            let time = (c / ((b * b - g * c).sqrt() - b)) | b.simd_ge(f64x2::ZERO);
            // No contact after the candidate's own next contact, when that disk searches again.
            let time = time | f64x2::splat(candidate.contact - clock).simd_lt(time);
            let earlier = time.simd_lt(limit);
            limit = lesser_lanes(time, limit);
            best = earlier.bitselect(f64x2::splat(f64::from_bits(u64::from(disk))), best);
        }
        let (limit, best) = (
            limit.to_array(),
            best.to_array().map(|best| best.to_bits() as u32),
        );
        // Sliding of disks that touch is decided by the search of one disk.
        if limit[0] <= 0.0 || limit[1] <= 0.0 {
            return None;
        }
        self.expect_contact(first, clock + limit[0], best[0]);
        self.expect_contact(second, clock + limit[1], best[1]);
        Some(lists.followed() + twice)
    }

    /// Takes a disk out of the linked list of its cell if it is the first there, as it mostly is,
    /// so that the pair search does not test it. Returns the cell's memory index and first disk, to
    /// restore the list.
    #[inline(always)]
    pub(crate) fn hide(&mut self, who: u32) -> (usize, u32) {
        let disk = &self.all[who as usize];
        let place = self.cells.place(disk.home, 1, 1);
        let first = self.cells.first(place);
        let rest = select_unpredictable(first == who, disk.next, first);
        self.cells.set_first(place, rest);
        (place, first)
    }
}

/// Reference frames of the cells around two disks, for separations and relative velocities from
/// both; cells are given by their numbers in the walk.
pub(crate) trait PairFrames {
    /// Returns the positions of both disks relative to the corner of a cell \[length\], x and y
    /// each as a vector of two lanes; NaN for a disk that is not next to the cell.
    fn corners(&self, cell: usize) -> [f64x2; 2];

    /// Returns the relative velocities along x of both disks and a third in the given cell, from
    /// the differences of their velocities in their own frames.
    fn along(&self, cell: usize, difference: f64x2) -> f64x2;
}

/// Reference frames of a block of four by four cells at rest around two disks: positions of the
/// disks relative to the corners of columns, and of rows.
struct StillPair {
    x: [[f64; 2]; SIDE],
    y: [[f64; 2]; SIDE],
}

impl PairFrames for StillPair {
    #[inline(always)]
    fn corners(&self, cell: usize) -> [f64x2; 2] {
        let (column, row) = (cell % SIDE, cell / SIDE % SIDE);
        [f64x2::new(self.x[column]), f64x2::new(self.y[row])]
    }

    #[inline(always)]
    fn along(&self, _cell: usize, difference: f64x2) -> f64x2 {
        difference
    }
}

/// Returns the lesser number in each lane; that of `second` if the first is NaN, on every
/// processor.
#[inline(always)]
fn lesser_lanes(first: f64x2, second: f64x2) -> f64x2 {
    let (first, second) = (first.to_array(), second.to_array());
    let lesser = |lane: usize| {
        if first[lane] < second[lane] {
            first[lane]
        } else {
            second[lane]
        }
    };
    f64x2::new([lesser(0), lesser(1)])
}

/// Returns one coordinate of two disks relative to the corners of four columns (or rows) around
/// both. A disk has three columns around it, from its `begin` on; NaN for the fourth.
#[inline(always)]
fn relative_to_columns(here: [f64; 2], width: f64, begin: [usize; 2]) -> [[f64; 2]; SIDE] {
    let mut relative = [[f64::NAN; 2]; SIDE];
    for of in 0..2 {
        let begin = begin[of] % 2;
        relative[begin][of] = here[of] + width;
        relative[begin + 1][of] = here[of];
        relative[begin + 2][of] = here[of] - width;
    }
    relative
}
