//! Search for a collision partner around a point in a halo copy: random draws where cells are full,
//! SIMD distance tests, else the nearest particle.

use std::ops::Range;

use rand::{Rng, RngExt};
use stosszahl_model::{ParticleModel, Sizes, Space, Vector, VectorOf};

use super::halo_copy::HaloCopy;
use super::lanes::{LANES, LINES, SimdBackend};
use super::search_ranges::{Ranges, WIDEST};
use super::search_target::{Aim, Block};
use crate::extrema::smaller;
use crate::grid::Grid;

/// Number of random draws of a partner before all candidates are tested; up to as many candidates,
/// none is drawn.
const DRAWS: u32 = 12;

/// Largest number of lines of cells whose particles are tested together.
const RUNS: usize = 32;

/// Number of gathered candidates up to which the distances of all are tested, without random draws.
const FEW: u64 = 128;

/// Squared distance that stands for infinity, of masked particles and empty SIMD lanes
/// \[length^2\].
const ANYWHERE: f64 = 1e290;

/// Least mean number of candidates in the search block for which some are drawn at random before
/// all are tested.
const MANY: f64 = 24.0;
/// Least fraction of the search block's area within the radius for which candidates are drawn at
/// random first; it is smaller for unequal sizes and in three dimensions.
const LEAST_SHARE: f64 = 0.3;

/// Largest number of random draws from a search block before all candidates are tested.
const DRAWN_FIRST: usize = 5;
/// Largest number of lines of cells in a search block from which candidates are drawn at random.
const DRAWN_LINES: usize = 8;

/// Search for collision partners in a halo copy, around the contact point of a simulator.
pub(super) struct Search<'a, P: ParticleModel, L> {
    grid: &'a Grid<P::Space>,
    lanes: L,
    radius: f64,
    /// True if cells hold so many candidates that some are drawn at random before all are tested.
    pub(super) draws: bool,
    /// Number of cells on each side of the contact point that contain the search radius; at least
    /// one.
    near: i64,
    /// Number of further cells on each side that unequal sizes require in the search.
    shift: i64,
    /// Least side of a cell of the grid \[length\].
    narrowest: f64,
    runs: Vec<Range<usize>>,
    /// Squared distances from their target points of the particles tested together \[length^2\].
    squares: [[f64; LANES]; RUNS],
}

impl<'a, P: ParticleModel, L: SimdBackend> Search<'a, P, L> {
    /// Prepares a search for partners. Those within `radius` of the contact point are equally
    /// likely \[length\]; `in_cell` is the mean number of simulators in a cell.
    pub(super) fn new(
        grid: &'a Grid<P::Space>,
        lanes: L,
        radius: f64,
        ranges: Ranges,
        in_cell: f64,
    ) -> Self {
        // Volumes in units of a cell: within the radius, and of the block searched.
        let side = 2 * ranges.block() + 1;
        let within = P::Space::particle_volume(radius) / grid.cell_volume();
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

    /// Draws a partner for the simulator `who` around its contact point in `cell`: any within the
    /// search radius with equal chance, else the nearest. `None` if no simulator is within a few
    /// cells. `pick` is a random number from 0 to 2^32.
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
            // The common case.
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

    /// Draws simulators at random from a block of cells, and returns the first within the search
    /// radius of the contact point; `None` if none of a few is.
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
        // Cumulative counts by line, side by side so that all are compared at once.
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

    /// Finds a partner in the 3 by 3 cells around a contact point in two dimensions: any within the
    /// search radius, chosen by the random number `pick`, else the nearest. `None` if there is
    /// none, or too many to test together.
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
        // Lane of the searching particle.
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
        // Branch-free, because the condition is unpredictable.
        let skip = (pick * u64::from(seen.near.count_ones())) >> 32;
        let drawn = self.lanes.bit_after(seen.near, skip as u32) as usize;
        let number = if seen.near > 0 { drawn } else { seen.nearest };
        let found = begins[(number / LANES).min(LINES - 1)] + number % LANES;
        let is_whole = runs.iter().all(|(_, run)| run.count <= LANES);
        (is_whole & (seen.square < ANYWHERE)).then_some(found)
    }

    /// Finds a partner in the cells up to `cells` away from a contact point: any within the search
    /// radius, chosen by the random number `pick`, else the nearest. `None` if there is none, or
    /// too many lines of cells. For unequal sizes, cells within the radius of the target points are
    /// tried first.
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

    /// Finds a partner in a block of cells: any within the search radius of its target point,
    /// chosen by the random number `pick`, else the nearest whose squared distance is below
    /// `farthest` \[length^2\].
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
        // For each lane: the least square, the run it came from, and the number within the radius.
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
        // The particle's number replaces the last bits of its squared distance, so that the minimum
        // is found without a branch. Non-negative floats sort as integers, and the last seven or
        // eight bits do not matter.
        let numbers = (RUNS * LANES) as u64 - 1;
        for lane in 0..LANES {
            let number = found[lane] * LANES as u64 + lane as u64;
            best[lane] = f64::from_bits((best[lane].to_bits() & !numbers) | number);
        }
        // Halving takes three comparisons in sequence instead of eight.
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

    /// Returns the index of the simulator within the search radius that follows `skip` others.
    /// `runs` holds the first index of each line of cells tested.
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
            // The lane is the number of lanes whose cumulative count is at most `skip`;
            // branch-free.
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

    /// Picks a partner among the gathered simulators by testing all: any within the search radius
    /// with equal chance, else the nearest.
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

    /// Returns the simulators gathered for the search, without the simulator `who` itself and its
    /// images.
    fn others(&self, patch: &HaloCopy<P>, who: usize) -> impl Iterator<Item = usize> {
        let own = patch.home(who);
        let all = self.runs.iter().cloned().flatten();
        all.filter(move |&index| patch.home(index) != own)
    }

    /// Draws a partner among the gathered simulators: any within the search radius of its target
    /// point, all with equal chance; `None` if there is none.
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
        // Reservoir sampling: each candidate replaces the previous one with decreasing chance, so
        // all are equally likely.
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

    /// Returns the gathered simulator nearest to its target point, if within `reach` of it
    /// \[length\].
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

    /// Returns the index in the halo copy of the gathered simulator with a number, counted over all
    /// lines of cells.
    fn nth(&self, number: u32) -> usize {
        let mut number = number as usize;
        for run in &self.runs {
            if number < run.len() {
                return run.start + number;
            }
            number -= run.len();
        }
        // Unreachable: the number is below the total length.
        0
    }

    /// Gathers the lines of cells within `cells` cells of the target point, and more for unequal
    /// sizes. Returns the number of simulators in them.
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
