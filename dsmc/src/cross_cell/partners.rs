//! The search for a partner around a point.

use std::ops::Range;

use rand::{Rng, RngExt};
use stosszahl_model::{Physics, Sizes, Space, Vector, VectorOf};

use super::halo_copy::HaloCopy;
use super::lanes::{LANES, LINES, Lanes};
use super::search_ranges::{Ranges, WIDEST};
use super::search_target::{Aim, Block};
use crate::extrema::smaller;
use crate::grid::Grid;

/// Draws before all simulators around are looked at one by one, and the number of them up to which none is drawn.
const DRAWS: u32 = 12;

/// Runs of simulators around that are looked at once, for one within the radius and for the nearest.
const RUNS: usize = 32;

/// Simulators that were gathered up to which none is drawn before all are looked at.
const FEW: u64 = 128;

/// Square of a distance that somebody has who is hidden, or nobody.
const ANYWHERE: f64 = 1e290;

/// Fewest simulators around, on average, where some are drawn before all are looked at, and the least share of them that is within the
/// radius: less is where sizes differ, and in space.
const MANY: f64 = 24.0;
const LEAST_SHARE: f64 = 0.3;

/// How many are drawn then, at most, and from how many lines of cells.
const DRAWN_FIRST: usize = 5;
const DRAWN_LINES: usize = 8;

/// Finds partners in a patch.
pub(super) struct Search<'a, P: Physics, L> {
    grid: &'a Grid<P::Space>,
    lanes: L,
    radius: f64,
    /// Whether there are so many around that some are drawn first.
    pub(super) draws: bool,
    /// How many cells on each side hold all within the radius, at least one, and how many more do where sizes differ.
    near: i64,
    shift: i64,
    /// Narrowest side of a cell.
    narrowest: f64,
    runs: Vec<Range<usize>>,
    /// Squares of the distances of those that are looked at together.
    squares: [[f64; LANES]; RUNS],
}

impl<'a, P: Physics, L: Lanes> Search<'a, P, L> {
    /// `radius`: within which all simulators are equally likely; `in_cell`: how many are in a cell, on average.
    pub(super) fn new(
        grid: &'a Grid<P::Space>,
        lanes: L,
        radius: f64,
        ranges: Ranges,
        in_cell: f64,
    ) -> Self {
        // In cells: what is within the radius, and what is around.
        let side = 2 * ranges.block() + 1;
        let within = P::Space::ball(radius) / grid.cell_volume();
        let around = (side * side) as f64;
        let has_many = in_cell * around >= MANY && within >= LEAST_SHARE * around;
        Self {
            grid,
            lanes,
            radius,
            draws: P::Space::DIMENSION == 2 && side <= DRAWN_LINES && has_many,
            near: ranges.near as i64,
            shift: ranges.shift as i64,
            narrowest: grid.narrowest(),
            runs: Vec::new(),
            squares: [[0.0; LANES]; RUNS],
        }
    }

    /// A simulator other than `who`, at whose contact point, which is in a cell, it is sought: any within the radius, all equally
    /// likely; if there is none, the nearest in the cells around; none if nobody is within a few cells. `pick`: a random number
    /// from 0 to 2^32, for the choice among few.
    #[inline(always)]
    pub(super) fn partner(
        &mut self,
        patch: &mut HaloCopy<P>,
        aim: Aim<VectorOf<P>>,
        cell: usize,
        who: usize,
        mut pick: u64,
        stream: &mut impl Rng,
    ) -> Option<usize> {
        if !patch.is_narrow() {
            let cells = (self.near + self.shift) as usize;
            if self.draws {
                let block = Block::around::<P::Space>(patch.strides(), cell, cells);
                let drawn = self.drawn(patch, aim, block, who, pick, stream);
                if drawn.is_some() {
                    return drawn;
                }
                pick = stream.random::<u64>() >> 32;
            }
            // Nearly always.
            let is_next = cells == 1 && P::Space::DIMENSION == 2 && patch.is_plain();
            if is_next {
                let found = self.closest_of_few(patch, aim, cell, who, pick);
                if found.is_some() {
                    return found;
                }
            }
            let hidden = patch.hide(who);
            let found = self.closest_around(patch, aim, cell, cells, pick);
            patch.show(who, hidden);
            if found.is_some() {
                return found;
            }
        }
        self.partner_around(patch, aim, who, stream)
    }

    /// Any simulator within the radius, all equally likely, as the first of a few drawn in a block of cells that is within it.
    #[inline(always)]
    fn drawn(
        &self,
        patch: &HaloCopy<P>,
        aim: Aim<VectorOf<P>>,
        block: Block,
        who: usize,
        pick: u64,
        stream: &mut impl Rng,
    ) -> Option<usize> {
        let Block { first, sides } = block;
        let column = patch.strides()[1];
        // How many there are up to each line, side by side, so that all are compared at once.
        let (mut sums, mut starts) = ([u32::MAX; DRAWN_LINES], [0_u32; DRAWN_LINES]);
        let mut all = 0;
        for line in 0..sides[1] {
            let members = patch.members(first + column * line, sides[0]);
            starts[line] = (members.start as u32).wrapping_sub(all);
            all += members.len() as u32;
            sums[line] = all;
        }
        if all == 0 {
            return None;
        }
        let limit = self.radius * self.radius;
        let mut number = pick;
        for _ in 0..DRAWN_FIRST {
            let slot = ((number * u64::from(all)) >> 32) as u32;
            let line = sums.iter().filter(|&&sum| sum <= slot).count();
            let index = starts[line].wrapping_add(slot) as usize;
            if index != who && self.distance_square(patch, aim, index) < limit {
                return Some(index);
            }
            number = stream.random::<u64>() >> 32;
        }
        None
    }

    /// A simulator other than `who`, as [`Self::partner`] says, from the cells next to one in the plane; none if there is nobody, or there
    /// are too many to be looked at together.
    #[inline(always)]
    fn closest_of_few(
        &self,
        patch: &HaloCopy<P>,
        aim: Aim<VectorOf<P>>,
        cell: usize,
        who: usize,
        pick: u64,
    ) -> Option<usize> {
        let limit = self.radius * self.radius;
        let runs = [0, 1, 2].map(|line| patch.run(cell, line));
        let begins = runs.map(|(begin, _)| begin);
        // The number of who looks.
        let mut but = LINES * LANES;
        for (line, (begin, run)) in runs.iter().enumerate() {
            let lane = who.wrapping_sub(*begin);
            but = if lane < run.count {
                LANES * line + lane
            } else {
                but
            };
        }
        let point = [aim.point[0], aim.point[1]];
        let seen = (self.lanes).look(&runs.map(|(_, run)| run), point, limit, but);
        // Without a branch, which nobody could foresee.
        let skip = (pick * u64::from(seen.near.count_ones())) >> 32;
        let drawn = self.lanes.bit_after(seen.near, skip as u32) as usize;
        let number = if seen.near > 0 { drawn } else { seen.nearest };
        let found = begins[(number / LANES).min(LINES - 1)] + number % LANES;
        let is_whole = runs.iter().all(|(_, run)| run.count <= LANES);
        (is_whole & (seen.square < ANYWHERE)).then_some(found)
    }

    /// The same in the cell and those so many around it, if there is somebody, and not too many; whoever looks is hidden. Where sizes
    /// differ, most of these cells are within the radius of no point of the aim.
    #[inline(always)]
    fn closest_around(
        &mut self,
        patch: &HaloCopy<P>,
        aim: Aim<VectorOf<P>>,
        cell: usize,
        cells: usize,
        pick: u64,
    ) -> Option<usize> {
        if !P::Sizes::UNIFORM && self.shift > 0 {
            let block = patch.block_within(aim, self.radius, cells);
            let limit = self.radius * self.radius;
            let found = self.closest(patch, aim, block, limit, pick);
            if found.is_some() {
                return found;
            }
        }
        let block = Block::around::<P::Space>(patch.strides(), cell, cells);
        self.closest(patch, aim, block, ANYWHERE, pick)
    }

    /// The same in a block of cells, nearer than the root of a square.
    #[inline(always)]
    fn closest(
        &mut self,
        patch: &HaloCopy<P>,
        aim: Aim<VectorOf<P>>,
        block: Block,
        farthest: f64,
        pick: u64,
    ) -> Option<usize> {
        let Block { first, sides } = block;
        let lines = sides[1] * sides[2];
        if lines > RUNS {
            return None;
        }
        let limit = self.radius * self.radius;
        // In each lane: the least square, in which run it was found, and how many are within the radius.
        let (mut best, mut found) = ([f64::MAX; LANES], [0_u64; LANES]);
        let mut near = [0_u64; LANES];
        let mut runs = [0_u32; RUNS];
        let mut count = 0;
        let [_, column, layer] = patch.strides();
        for line in 0..lines {
            let begin = first + line % sides[1] * column + line / sides[1] * layer;
            let members = patch.members(begin, sides[0]);
            let mut begin = members.start;
            while begin < members.end {
                if count == RUNS {
                    return None;
                }
                let squares = patch.squares(aim, begin, members.end);
                let run = count as u64;
                for lane in 0..LANES {
                    let square = squares[lane];
                    near[lane] += u64::from(square < limit);
                    found[lane] = if square < best[lane] {
                        run
                    } else {
                        found[lane]
                    };
                    best[lane] = smaller(square, best[lane]);
                }
                self.squares[count] = squares;
                runs[count] = begin as u32;
                count += 1;
                begin += LANES;
            }
        }
        let near: u64 = near.iter().sum();
        if near > 1 {
            return self.pick(&runs[..count], (pick * near) >> 32);
        }
        // Squares of distances and the numbers of simulators in one word each, so that the least is found without a branch:
        // squares are not negative, so that their bits have their order, and the last seven or eight are none that matter.
        let numbers = (RUNS * LANES) as u64 - 1;
        for lane in 0..LANES {
            let number = found[lane] * LANES as u64 + lane as u64;
            best[lane] = f64::from_bits((best[lane].to_bits() & !numbers) | number);
        }
        // Half against half, so that three comparisons follow each other and not eight.
        let mut left = LANES;
        while left > 1 {
            left /= 2;
            for lane in 0..left {
                best[lane] = smaller(best[lane], best[lane + left]);
            }
        }
        let best = best[0];
        if best >= farthest {
            return None;
        }
        let number = (best.to_bits() & numbers) as usize;
        Some(runs[number / LANES] as usize + number % LANES)
    }

    /// The one within the radius of where it is sought that comes after so many others, of runs that begin there.
    #[inline(always)]
    fn pick(&self, runs: &[u32], mut skip: u64) -> Option<usize> {
        let limit = self.radius * self.radius;
        for (&begin, squares) in runs.iter().zip(&self.squares) {
            let near = squares.map(|square| u64::from(square < limit));
            let all: u64 = near.iter().sum();
            if skip >= all {
                skip -= all;
                continue;
            }
            // As many lanes come before it as have no more than those to be skipped up to them; without a branch.
            let (mut up_to, mut before) = (0, 0);
            for near in near {
                up_to += near;
                before += usize::from(up_to <= skip);
            }
            return Some(begin as usize + before);
        }
        None
    }

    #[inline(never)]
    fn partner_around(
        &mut self,
        patch: &HaloCopy<P>,
        aim: Aim<VectorOf<P>>,
        who: usize,
        stream: &mut impl Rng,
    ) -> Option<usize> {
        let total = self.gather(patch, aim, self.near);
        if u64::from(total) <= FEW {
            let found = self.look(patch, aim, who, stream);
            if found.is_some() {
                return found;
            }
        } else {
            if self.radius > 0.0
                && let Some(found) = self.draw(patch, aim, who, total, stream)
            {
                return Some(found);
            }
            return self.nearest(patch, aim, who, f64::INFINITY);
        }
        for cells in self.near + 1..=WIDEST {
            self.gather(patch, aim, cells);
            let reach = cells as f64 * self.narrowest;
            let found = self.nearest(patch, aim, who, reach);
            if found.is_some() {
                return found;
            }
        }
        None
    }

    /// Of what was gathered, any simulator within the radius, all equally likely; or else the nearest.
    fn look(
        &self,
        patch: &HaloCopy<P>,
        aim: Aim<VectorOf<P>>,
        who: usize,
        stream: &mut impl Rng,
    ) -> Option<usize> {
        let limit = self.radius * self.radius;
        let (mut best, mut near) = ((f64::MAX, None), 0);
        for index in self.others(patch, who) {
            let square = self.distance_square(patch, aim, index);
            near += u32::from(square < limit);
            if square < best.0 {
                best = (square, Some(index));
            }
        }
        if near > 1 {
            let skip = stream.random_range(0..near) as usize;
            let is_near = |index: &usize| self.distance_square(patch, aim, *index) < limit;
            return self.others(patch, who).filter(is_near).nth(skip);
        }
        best.1
    }

    /// All that were gathered but one.
    fn others(&self, patch: &HaloCopy<P>, who: usize) -> impl Iterator<Item = usize> {
        let own = patch.home(who);
        let all = self.runs.iter().cloned().flatten();
        all.filter(move |&index| patch.home(index) != own)
    }

    /// Any simulator within the radius, all equally likely.
    fn draw(
        &self,
        patch: &HaloCopy<P>,
        aim: Aim<VectorOf<P>>,
        who: usize,
        total: u32,
        stream: &mut impl Rng,
    ) -> Option<usize> {
        let square = self.radius * self.radius;
        let is_near = |index: usize| self.distance_square(patch, aim, index) < square;
        let own = patch.home(who);
        let draws = if total > DRAWS { DRAWS } else { 0 };
        for _ in 0..draws {
            let index = self.nth(stream.random_range(0..total));
            if is_near(index) && patch.home(index) != own {
                return Some(index);
            }
        }
        // Few or none: one after the other replaces the one found before, so that all are equally likely.
        let (mut found, mut near) = (None, 0_u32);
        for index in self.others(patch, who) {
            if is_near(index) {
                near += 1;
                if near == 1 || stream.random_range(0..near) == 0 {
                    found = Some(index);
                }
            }
        }
        found
    }

    /// Of what was gathered, the nearest to its point of the aim, if it is within reach.
    fn nearest(
        &self,
        patch: &HaloCopy<P>,
        aim: Aim<VectorOf<P>>,
        who: usize,
        reach: f64,
    ) -> Option<usize> {
        let mut best = (f64::MAX, None);
        for index in self.others(patch, who) {
            let square = self.distance_square(patch, aim, index);
            if square < best.0 {
                best = (square, Some(index));
            }
        }
        best.1.filter(|_| best.0 <= reach * reach)
    }

    #[inline(always)]
    fn distance_square(&self, patch: &HaloCopy<P>, aim: Aim<VectorOf<P>>, index: usize) -> f64 {
        let position = patch.position(index);
        let mut point = aim.point;
        if let Some(excess) = patch.excess(index) {
            point += aim.along * excess;
        }
        if !patch.is_narrow() {
            return (position - point).square();
        }
        let images = self.grid.domain().images();
        images.nearest(position - point).square()
    }

    /// The simulator with this number in the runs.
    fn nth(&self, number: u32) -> usize {
        let mut number = number as usize;
        for run in &self.runs {
            if number < run.len() {
                return run.start + number;
            }
            number -= run.len();
        }
        // Not reached: the number is below the total length.
        0
    }

    /// Gathers the runs of this many cells on each side of the point of an aim, and as many more as partners of other sizes
    /// need; returns how many simulators they hold.
    fn gather(&mut self, patch: &HaloCopy<P>, aim: Aim<VectorOf<P>>, cells: i64) -> u32 {
        let cells = cells + self.shift;
        let counts = self.grid.counts();
        // Around a narrow box no cell is counted twice.
        let span = [0, 1, 2].map(|axis| {
            if axis >= P::Space::DIMENSION {
                1
            } else if self.grid.domain().is_periodic(axis) {
                (2 * cells + 1).min(i64::from(counts[axis])) as usize
            } else {
                (2 * cells + 1) as usize
            }
        });
        let [_, column, layer] = patch.strides();
        let is_deep = usize::from(P::Space::DIMENSION > 2);
        let first = patch.cell_of(aim.point) - cells as usize * (1 + column + is_deep * layer);
        self.runs.clear();
        let mut total = 0;
        for z in 0..span[2] {
            for y in 0..span[1] {
                let run = patch.members(first + column * y + layer * z, span[0]);
                total += run.len() as u32;
                if !run.is_empty() {
                    self.runs.push(run);
                }
            }
        }
        total
    }
}
