//! Acceptance tests of candidate pairs between cells, one implementation for each collision scheme.

use rand::{Rng, RngExt};
use stosszahl_model::{ParticleModel, Sizes, Space, VectorOf};

use super::lanes::SimdBackend;
use super::partners::Search;
use super::rate::Rates;
use super::search_ranges::radius_spread;
use super::search_target::Aim;
use super::tile_collider::{Candidate, Cell, Line, TileCollider, pair_share};
use crate::boundary::GridBoundaries;
use crate::density::FreeVolumeFactors;
use crate::grid::Grid;
use crate::particle::{DisplacementTracking, covered};
use crate::within_cell::CollisionContext;

/// Acceptance rule for the candidate pairs of a collision scheme.
///
/// Not closures: the compiler might not inline them into the loop, and then they would lack its
/// vector instructions.
pub(super) trait CandidateRule<P: ParticleModel, F: DisplacementTracking<P::Space>> {
    /// Prepares the rule for a line of cells, before its candidates are drawn.
    fn begin(&mut self, worker: &TileCollider<'_, '_, '_, P, F>, line: Line, columns: usize);

    /// Returns a majorant in a cell of n chi times the size factor of a pair \[1/length^D\].
    fn most(
        &self,
        worker: &TileCollider<'_, '_, '_, P, F>,
        cell: &Cell<P::Space>,
        column: usize,
    ) -> f64;

    /// Tests one candidate pair and executes its collision if accepted. Returns `false` if the run
    /// was interrupted.
    fn meet(
        &mut self,
        worker: &mut TileCollider<'_, '_, '_, P, F>,
        cell: &mut Cell<P::Space>,
        trial: &Candidate<VectorOf<P>>,
        stream: &mut impl Rng,
    ) -> bool;
}

/// Acceptance rule of the contact-point scheme: partners are sought around the point of contact.
/// The rate is Enskog's for the density around the simulator or around the point halfway.
pub(super) struct AroundPoints<'a, P: ParticleModel, L> {
    rates: &'a Rates<P::Space>,
    search: Search<'a, P, L>,
    /// Largest offset in cells, along each axis, of the point halfway to contact, if the density is
    /// counted around it; else `None`. Larger offsets, due to rounding, are clamped.
    farthest: Option<[i64; 3]>,
    /// Largest number of neighbours around any point halfway to contact, for each cell of the line,
    /// in units of the largest particle.
    most_others: Vec<f64>,
    /// Scratch memory for the neighbour counts of a line of cells.
    work: Vec<f32>,
    /// Cell and radius of the last candidate, with its cached collision rate and majorant; for
    /// unequal sizes.
    last: ((usize, f64), OfSize),
}

/// Collision rate and majorant for particles of one radius in one cell, cached between candidates.
#[derive(Clone, Copy, Default)]
struct OfSize {
    n_chi: f64,
    /// Majorant over partners of all sizes of cross section times chi, relative to equal particles
    /// at the contact distance.
    ceiling: f64,
}

impl<'a, P: ParticleModel, L> AroundPoints<'a, P, L> {
    pub(super) fn new(
        kernel: &CollisionContext<'_, P>,
        rates: &'a Rates<P::Space>,
        search: Search<'a, P, L>,
        halfway: bool,
    ) -> Self {
        Self {
            rates,
            search,
            farthest: halfway.then(|| steps_within(kernel.grid, kernel.mean_radius)),
            most_others: Vec::new(),
            work: Vec::new(),
            last: Default::default(),
        }
    }

    /// Returns collision rate and majorant for particles of one radius in a cell; they are cached,
    /// as consecutive candidates often agree.
    #[inline(always)]
    fn of_size(
        &mut self,
        kernel: &CollisionContext<'_, P>,
        cell: &Cell<P::Space>,
        radius: f64,
    ) -> OfSize {
        let who = (cell.local, radius);
        if self.last.0 != who {
            let largest = kernel.scene.sizes().largest_radius();
            let diameters = [2.0 * radius, 2.0 * largest];
            let of_size = OfSize {
                n_chi: (self.rates).at(cell.units, cell.crowding, radius / largest),
                ceiling: pair_share(kernel, cell.packing, diameters, diameters[1]),
            };
            self.last = (who, of_size);
        }
        self.last.1
    }

    /// Returns the local collision rate n chi \[1/length^D\] for a number of neighbours, without
    /// the simulator itself.
    #[inline(always)]
    fn n_chi(&self, others: f64) -> f64 {
        self.rates.at(others, FreeVolumeFactors::NONE, 1.0)
    }
}

impl<P: ParticleModel, F: DisplacementTracking<P::Space>, L: SimdBackend> CandidateRule<P, F>
    for AroundPoints<'_, P, L>
{
    #[inline(always)]
    fn begin(&mut self, worker: &TileCollider<'_, '_, '_, P, F>, line: Line, columns: usize) {
        if let Some(farthest) = self.farthest {
            self.most_others.resize(columns, 0.0);
            let first = worker.cell_of(line, 0);
            let (work, most) = (&mut self.work, &mut self.most_others);
            (worker.kernel.density).most_others(first, farthest, work, most);
        }
    }

    #[inline(always)]
    fn most(
        &self,
        _: &TileCollider<'_, '_, '_, P, F>,
        cell: &Cell<P::Space>,
        column: usize,
    ) -> f64 {
        match self.farthest {
            Some(_) => self.n_chi(self.most_others[column]),
            None => cell.ceiling * self.rates.most(cell.units, cell.crowding),
        }
    }

    #[inline(always)]
    fn meet(
        &mut self,
        worker: &mut TileCollider<'_, '_, '_, P, F>,
        cell: &mut Cell<P::Space>,
        trial: &Candidate<VectorOf<P>>,
        stream: &mut impl Rng,
    ) -> bool {
        let kernel = worker.kernel;
        let sizes = kernel.scene.sizes();
        if let Some(farthest) = self.farthest {
            let middle = trial.position + trial.normal * (0.5 * trial.distance);
            let step = worker.patch.steps_to(cell.at, middle);
            let step = [0, 1, 2].map(|axis| step[axis].clamp(-farthest[axis], farthest[axis]));
            let others = kernel.density.others(cell.at, step);
            if stream.random::<f64>() * cell.most >= self.n_chi(others) {
                return true;
            }
        }
        // The majorant of this particle's size is tested before a partner is sought.
        let mut ceiling = cell.ceiling;
        if !sizes.are_equal() {
            let of_size = self.of_size(kernel, cell, sizes.radius(worker.patch.tag(trial.first)));
            ceiling = of_size.ceiling;
            if stream.random::<f64>() * cell.most >= ceiling * of_size.n_chi {
                return true;
            }
            // A search for a large particle's partner among small ones may test ten thousands.
            if kernel.stop.is_raised() {
                return false;
            }
        }
        let (normal, distance) = (trial.normal, trial.distance);
        // Beyond a wall there are no partners.
        if !kernel.has_room(trial.position + normal * distance) {
            return true;
        }
        let reach = worker.arm.reach(cell.class);
        let aim = Aim {
            point: trial.position + normal * (reach * distance),
            along: normal * reach,
        };
        let there = worker.patch.cell_of(aim.point);
        // No partner there is fast enough.
        let spread = radius_spread(sizes, kernel.mean_radius);
        let speed = trial.threshold - trial.along - spread * worker.approach_by_flow(normal).abs();
        if worker.patch.is_slow(there, normal, speed) {
            return true;
        }
        worker.report.tally.searches += 1;
        let found =
            (self.search).partner(worker.patch, aim, there, trial.first, trial.pick, stream);
        let Some(second) = found else {
            worker.report.tally.missed += 1;
            return true;
        };
        if let Some(arm) = worker.try_pair(cell, trial, second, ceiling, stream) {
            worker.report.distances.note(cell.class, arm);
        }
        true
    }
}

/// Acceptance rule of the ESMC scheme: partners come from the cell that contains the point of
/// contact.
pub(super) struct InCells {
    /// Largest contact value chi of the tile and its neighbours.
    chi: f64,
    /// Number density that one simulator makes in the cell with the smallest free volume
    /// \[1/length^D\].
    density: f64,
    least: f64,
    /// Largest distance of the point of contact from a simulator, in cells along each axis.
    point: usize,
    /// Index in the halo copy of the first cell of the current line.
    first: usize,
}

impl InCells {
    pub(super) fn new<P: ParticleModel>(
        kernel: &CollisionContext<'_, P>,
        chi: f64,
        point: usize,
    ) -> Self {
        // Cells that walls cut are denser than their number says.
        let least = kernel.surroundings.map_or(1.0, GridBoundaries::least_room);
        Self {
            chi,
            density: kernel.weight / (least * kernel.grid.cell_volume()),
            least,
            point,
            first: 0,
        }
    }
}

impl<P: ParticleModel, F: DisplacementTracking<P::Space>> CandidateRule<P, F> for InCells {
    #[inline(always)]
    fn begin(&mut self, worker: &TileCollider<'_, '_, '_, P, F>, line: Line, _: usize) {
        self.first = worker.patch.own_cell([0, line.row, line.layer]);
    }

    #[inline(always)]
    fn most(
        &self,
        worker: &TileCollider<'_, '_, '_, P, F>,
        cell: &Cell<P::Space>,
        column: usize,
    ) -> f64 {
        let crowd = worker.patch.crowd(self.first + column, self.point);
        cell.ceiling * self.chi * f64::from(crowd) * self.density
    }

    #[inline(always)]
    fn meet(
        &mut self,
        worker: &mut TileCollider<'_, '_, '_, P, F>,
        cell: &mut Cell<P::Space>,
        trial: &Candidate<VectorOf<P>>,
        stream: &mut impl Rng,
    ) -> bool {
        let kernel = worker.kernel;
        let domain = kernel.grid.domain();
        let most = cell.most / (cell.ceiling * self.chi * self.density);
        let slot = (trial.pick as f64 * (0.5_f64).powi(32) * most) as usize;
        let way = trial.normal * trial.distance;
        let point = trial.position + way;
        let patch = &*worker.patch;
        let there = patch.members(patch.cell_of(point), 1);
        let second = there.start + slot;
        if slot >= there.len() || patch.home(second) == patch.home(trial.first) {
            return true;
        }
        if let Some(surroundings) = kernel.surroundings {
            let point = domain.wrap(point);
            if !kernel.has_room(point) {
                return true;
            }
            let room = surroundings.room(kernel.grid.cell_at(point));
            if self.least < room && stream.random::<f64>() * room >= self.least {
                return true;
            }
        }
        // The density is taken halfway: packing of the cell there, or of its neighbourhood.
        let middle = trial.position + way * 0.5;
        let own = if kernel.density.looks_around() {
            0.0
        } else {
            let members = patch.members(patch.cell_of(middle), 1);
            covered::<P>(kernel.scene.sizes(), members.map(|who| patch.tag(who)))
        };
        let middle = kernel.grid.cell_at(domain.wrap(middle));
        let (there, ..) = kernel.density.contact_value(middle, own);
        if self.chi * stream.random::<f64>() < there {
            worker.try_pair(cell, trial, second, cell.ceiling, stream);
        }
        true
    }
}

/// Returns the largest offset, in cells along each axis, of a point at a distance from a position
/// in a cell.
fn steps_within<S: Space>(grid: &Grid<S>, distance: f64) -> [i64; 3] {
    [0, 1, 2].map(|axis| {
        if axis < S::DIMENSION {
            (distance / grid.width()[axis]).ceil() as i64
        } else {
            0
        }
    })
}
