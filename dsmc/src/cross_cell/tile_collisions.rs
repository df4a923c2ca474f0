//! Loop over the cells of a tile that draws and tests candidate pairs, line of cells by line, in
//! batches.

use std::mem::take;

use rand::{Rng, RngExt};
use stosszahl_model::{ParticleModel, Sizes, Space, VectorOf};

use super::change::ChangeOf;
use super::extents::VelocityBox;
use super::lanes::{self, SimdBackend};
use super::partners::Search;
use super::report::{TileBounds, TileReport};
use super::search_ranges::Ranges;
use super::tile_collider::{Candidate, Cell, Line, TileCollider, total};
use super::trials::{AroundPoints, CandidateRule, InCells};
use crate::extrema::smaller;
use crate::grid::Grid;
use crate::particle::DisplacementTracking;
use crate::random_counts::draw_whole;
use crate::scheme::PartnerSelection;

/// Target number of simulators in a piece of a line of cells, for which the number of candidate
/// pairs is drawn at once.
///
/// The number of candidate pairs of a piece is one of the two whole numbers next to its mean, so it
/// varies less than a Poisson number; that moves the collision rate by some tenths of a per cent
/// (`docs/development/monte-carlo.md`).
const SIMULATORS_IN_PIECE: f64 = 5.0;
/// Largest number of cells in a piece of a line of cells.
const LONGEST_PIECE: usize = 8;

/// Number of candidate pairs drawn before the first is tested. Batching lets the CPU overlap
/// independent searches.
const DRAWN: usize = 32;

/// Returns the bounds of the contact value over a tile and its neighbouring tiles.
pub(super) fn bounds_around<S: Space>(
    grid: &Grid<S>,
    bounds: &[TileBounds],
    number: usize,
) -> TileBounds {
    let mut all = bounds[number];
    for other in grid.touching(grid.place_of(number)) {
        all.chi = all.chi.max(bounds[other].chi);
    }
    all
}

impl<P, F> TileCollider<'_, '_, '_, P, F>
where
    P: ParticleModel,
    F: DisplacementTracking<P::Space>,
{
    /// Executes all collisions of the tile with its neighbours in a time step; returns the report
    /// and velocity changes for other processes. Bits are identical on every processor: products
    /// and sums are never contracted.
    pub(super) fn collide(mut self, ranges: Ranges) -> (TileReport, Vec<ChangeOf<P>>) {
        self.choose_loop(ranges);
        (self.report, self.around.changes())
    }

    fn choose_loop(&mut self, ranges: Ranges) {
        #[cfg(target_arch = "x86_64")]
        if let Some(lanes) = lanes::Avx2::detect() {
            #[allow(unsafe_code, reason = "the compiler does not see the question before")]
            // SAFETY: the processor has these instructions.
            unsafe {
                self.collide_with_avx2(ranges, lanes);
            }
            return;
        }
        self.collide_all(ranges, lanes::Plain);
    }

    /// Runs [`Self::collide_all`] compiled for processors with AVX2, so that inlined code uses four
    /// lanes.
    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2,bmi1,bmi2,lzcnt,popcnt")]
    fn collide_with_avx2(&mut self, ranges: Ranges, lanes: lanes::Avx2) {
        self.collide_all(ranges, lanes);
    }

    /// Draws and tests the candidate pairs of all cells of the tile, with the SIMD implementation
    /// `lanes`.
    #[inline(always)]
    fn collide_all(&mut self, ranges: Ranges, lanes: impl SimdBackend) {
        let kernel = self.kernel;
        let sizes = (kernel.scene.sizes(), kernel.mean_radius);
        self.patch
            .fill(&self.around, kernel.grid, ranges, self.moves, sizes);
        let in_cell = self.around.home().in_cell();
        let search = Search::new(kernel.grid, lanes, kernel.partner_radius, ranges, in_cell);
        let is_halfway = self.is_halfway();
        let mut around_points =
            (self.rates).map(|rates| AroundPoints::new(kernel, rates, search, is_halfway));
        let mut in_cells = InCells::new(kernel, self.bounds.chi, ranges.point);
        let [columns, rows, layers] = self.around.home().place.sides.map(|side| side as usize);
        for number in 0..rows * layers {
            if kernel.stop.is_raised() {
                return;
            }
            let home = self.around.home();
            let cells = columns * number;
            if home.starts[cells] == home.starts[cells + columns] {
                continue;
            }
            let line = Line {
                number,
                row: number % rows,
                layer: number / rows,
            };
            let first = kernel.grid.number(home.cell_at(cells));
            let mut stream = kernel.streams.stream_at(u64::from(first));
            if self.moves {
                self.patch.bound_line([line.row, line.layer]);
            }
            match (kernel.density.scheme().partners(), &mut around_points) {
                (PartnerSelection::AroundContact, Some(trials)) => {
                    self.for_trials(line, columns, &mut stream, trials);
                }
                (PartnerSelection::ContactCell, _) => {
                    self.for_trials(line, columns, &mut stream, &mut in_cells);
                }
                (PartnerSelection::Overlap, _) => {
                    let stiffness = kernel.density.scheme().stiffness();
                    for column in 0..columns {
                        if let Some(mut cell) = self.cell(line, columns, column) {
                            let before = (self.report.tally.collisions, self.report.tally.virial);
                            self.overlapping(cell.at, cell.members.clone(), stiffness, &mut stream);
                            cell.collisions = self.report.tally.collisions - before.0;
                            cell.virial = self.report.tally.virial - before.1;
                            self.close(&cell);
                        }
                    }
                }
                _ => {}
            }
        }
    }

    /// Draws and tests the candidate pairs of one line of cells, piece by piece, by the acceptance
    /// rule `trials`.
    #[inline(always)]
    fn for_trials(
        &mut self,
        line: Line,
        columns: usize,
        stream: &mut impl Rng,
        trials: &mut impl CandidateRule<P, F>,
    ) {
        let kernel = self.kernel;
        trials.begin(self, line, columns);
        let (mut cells, mut drawn) = (take(&mut self.cells), take(&mut self.drawn));
        let home = self.around.home();
        let length =
            (SIMULATORS_IN_PIECE / home.in_cell()).clamp(1.0, LONGEST_PIECE as f64) as usize;
        let pieces = columns.div_ceil(length);
        // Candidate pairs per n chi and per side length of the velocity box: the mean of h(k) is
        // half the sum of the sides times the mean component.
        let largest = 2.0 * kernel.scene.sizes().largest_radius();
        let section = largest.powi(P::Space::DIMENSION as i32 - 1);
        let mean = 0.5 * MEAN_COMPONENT[P::Space::DIMENSION - 2];
        let each = 0.5 * P::Space::SOLID_ANGLE * section * mean * kernel.step;
        let widening = VelocityBox::<P::Space>::flow_widening(kernel.flow.rate, largest);
        for piece in 0..pieces {
            let [from, to] = [piece, piece + 1].map(|piece| columns * piece / pieces);
            // Cumulative expected candidates by cell, side by side so that all are compared at
            // once.
            let (mut sum, mut sums) = (0.0, [f64::MAX; LONGEST_PIECE]);
            let before = cells.len();
            for column in from..to {
                let Some(mut cell) = self.cell(line, columns, column) else {
                    continue;
                };
                cell.extent = self.patch.bounds[column].widened(widening);
                cell.most = trials.most(self, &cell, column);
                cell.rate = cell.most * each * total::<P::Space>(cell.extent.sides());
                sum += cell.rate * cell.members.len() as f64;
                sums[cells.len() - before] = sum;
                cells.push(cell);
            }
            let count = draw_whole(sum, stream);
            self.report.tally.trials += count;
            let mut to_draw = count;
            // Tests are most of the code of an engine and inlined, so only one line calls them.
            loop {
                while to_draw > 0 && drawn.len() < DRAWN {
                    to_draw -= 1;
                    let [who, pick] = two_numbers(stream);
                    // Below the sum even where the product rounds up to it, so that a cell is
                    // found.
                    let at = smaller(sum * (who as f64 * (0.5_f64).powi(32)), sum.next_down());
                    let number = sums.iter().filter(|&&sum| sum <= at).count();
                    let cell = &cells[before + number];
                    let left = ((sums[number] - at) / cell.rate) as usize;
                    let first = cell.members.end - 1 - left.min(cell.members.len() - 1);
                    drawn.push(self.propose(before + number, first, &cell.extent, pick, stream));
                }
                let is_full = drawn.len() == DRAWN && !kernel.stop.is_raised();
                let ends = !is_full && (drawn.len() >= DRAWN / 2 || piece + 1 == pieces);
                if is_full || ends {
                    self.meet_all(&mut cells, &mut drawn, trials, stream);
                }
                if ends {
                    for cell in cells.drain(..) {
                        self.close(&cell);
                    }
                }
                if !is_full {
                    break;
                }
            }
        }
        (self.cells, self.drawn) = (cells, drawn);
    }

    /// Accepts or rejects each candidate pair of a batch by the rule of the scheme, in the order in
    /// which the pairs were drawn, collides the accepted pairs, and empties the batch.
    #[inline(always)]
    fn meet_all(
        &mut self,
        cells: &mut [Cell<P::Space>],
        drawn: &mut Vec<Candidate<VectorOf<P>>>,
        trials: &mut impl CandidateRule<P, F>,
        stream: &mut impl Rng,
    ) {
        for trial in drawn.iter() {
            let mut trial = *trial;
            let cell = &mut cells[trial.cell];
            // The particle has collided since the candidate was drawn.
            if self.patch.velocities[trial.first] != trial.velocity {
                trial = self.direct(trial, &cell.extent);
            }
            if !trials.meet(self, cell, &trial, stream) {
                break;
            }
        }
        drawn.clear();
    }
}

/// Mean absolute component of a random unit vector: 2/π in two dimensions, 1/2 in three.
const MEAN_COMPONENT: [f64; 2] = [std::f64::consts::FRAC_2_PI, 0.5];

/// Draws two random whole numbers from 0 to below 2^32.
#[inline(always)]
fn two_numbers(stream: &mut impl Rng) -> [u64; 2] {
    let both: u64 = stream.random();
    [both >> 32, both & 0xffff_ffff]
}
