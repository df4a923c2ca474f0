//! Engine of the Direct Simulation Monte Carlo: its data, read access to gas and counters, and
//! changes from outside.

use stosszahl_model::random::Streams;
use stosszahl_model::{
    Interrupt, ParticleModel, ParticleState, Sizes, Space, SpinOf, State, VectorOf,
};

use crate::boundary::{GridBoundaries, Ledgers};
use crate::cross_cell::{ContactDistance, HaloCopy, Rates};
use crate::decomposition::Subdomain;
use crate::density::Density;
use crate::grid::Grid;
use crate::parameters::Parameters;
use crate::particle::{DisplacementTracking, SimulatorOf, Untracked};
use crate::pause::Pause;
use crate::scheme::PartnerSelection;
use crate::start_means::Means;
use crate::tally::{CellCount, CollisionCounters, EnergyUnit, StepBounds};
use crate::threads::Pool;
use crate::tile::{Migrant, Scratch, SendBuffer, Tile};
use stosszahl_model::interrupt::Interruption;

/// Constants of a gas during a run: weight, packing fraction, mean free path and mean particle.
pub(crate) struct Constants {
    /// Number of particles per simulator.
    pub(crate) weight: f64,
    /// Packing fraction of the initial state or of the densest inflow, whichever is larger.
    pub(crate) packing_fraction: f64,
    /// Mean free path at the packing fraction of the run \[length\], from which the time step is
    /// chosen.
    pub(crate) mean_free_path: f64,
    pub(crate) moment_ratio: f64,
    /// Radius around the point of contact within which all simulators are equally likely partners
    /// \[length\].
    pub(crate) partner_radius: f64,
    /// Mean radius of the particles \[length\].
    pub(crate) mean_radius: f64,
    /// Mean mass of the particles \[mass\].
    pub(crate) mean_mass: f64,
}

/// Assigns to each simulator its index in the state; simulators of equal size form consecutive
/// blocks there.
struct SimulatorIndices {
    /// Next free index in the block of each size; empty if simulators store their own index.
    next: Vec<usize>,
}

impl SimulatorIndices {
    /// Returns the index in the state of a simulator with a size tag, which is the `order`-th
    /// visited.
    fn index<Z: Sizes>(&mut self, sizes: &Z, tag: Z::Tag, order: usize) -> usize {
        match self.next.get_mut(sizes.block_of(tag) as usize) {
            Some(next) => {
                *next += 1;
                *next - 1
            }
            None => Z::index_of(tag, order),
        }
    }
}

/// Engine of the Direct Simulation Monte Carlo of smooth or rough particles in a box.
///
/// `F` selects whether displacements are tracked ([`crate::Tracked`]) or not.
pub struct DsmcEngine<P: ParticleModel, F: DisplacementTracking<P::Space> = Untracked> {
    /// Particle model, with the sizes of all simulators.
    pub(crate) scene: P,
    pub(crate) parameters: Parameters,
    pub(crate) streams: Streams,
    pub(crate) constants: Constants,
    pub(crate) grid: Grid<P::Space>,
    pub(crate) density: Density<P::Space>,
    /// Local collision rates of the contact-point scheme; `None` for other schemes.
    pub(crate) rates: Option<Rates<P::Space>>,
    pub(crate) arm: ContactDistance,
    pub(crate) simulators: usize,
    pub(crate) tiles: Vec<Tile<P, F>>,
    /// For each tile, simulators that leave it in the current free flight.
    pub(crate) departing: Vec<SendBuffer<P, F>>,
    /// For each tile, simulators that left it in the last free flight, to be delivered to other
    /// tiles.
    pub(crate) arriving: Vec<SendBuffer<P, F>>,
    pub(crate) far: Vec<(u32, Migrant<P, F>)>,
    pub(crate) pool: Pool<Scratch<P, F>>,
    /// Pool of memory for halo copies of tiles, for cross-cell schemes.
    pub(crate) halo_copies: Pool<HaloCopy<P>>,
    pub(crate) held_step: Option<f64>,
    pub(crate) counts_cells: bool,
    pub(crate) time: f64,
    pub(crate) stock: StepBounds<P::Space>,
    pub(crate) unit: EnergyUnit,
    pub(crate) tally: CollisionCounters,
    pub(crate) ledgers: Ledgers<P::Space>,
    /// Walls, obstacles, inflows and weights of the box; `None` if it is periodic.
    pub(crate) surroundings: Option<GridBoundaries<P>>,
    pub(crate) means: Means,
    /// State of the stop flag, and whether it has broken off a time step.
    pub(crate) stop: Interruption,
    /// Pause in the middle of a free flight; `None` if there is none, or once the gas was changed.
    pub(crate) pause: Option<Pause>,
    /// Subdomain that this process holds; `None` if one process holds the whole gas.
    pub(crate) share: Option<Subdomain<P::Space>>,
}

impl<P, F> DsmcEngine<P, F>
where
    P: ParticleModel,
    F: DisplacementTracking<P::Space>,
{
    /// Returns the state of the gas at the current time, with one body for each simulator, in the
    /// order of the sizes of [`DsmcEngine::scene`]. Within each set of simulators, species follow
    /// each other.
    pub fn state(&self) -> State<P> {
        let origin = VectorOf::<P>::default();
        let mut bodies = vec![ParticleState::new(origin, origin); self.simulators];
        self.each_in_place(|index, simulator, _| {
            bodies[index] = ParticleState {
                position: simulator.position,
                velocity: simulator.velocity,
                spin: simulator.spin,
            };
        });
        State {
            time: self.time,
            domain: *self.grid.domain(),
            bodies,
        }
    }

    /// Prepares the assignment of indices in [`DsmcEngine::state`] to simulators.
    fn places(&self) -> SimulatorIndices {
        let mut counts = Vec::new();
        if !P::Sizes::UNIFORM && !P::Sizes::INDIVIDUAL {
            for simulator in self.ordered() {
                let block = self.scene.sizes().block_of(simulator.tag) as usize;
                if counts.len() <= block {
                    counts.resize(block + 1, 0);
                }
                counts[block] += 1;
            }
        }
        let firsts = counts.iter().scan(0, |sum, count| {
            *sum += count;
            Some(*sum - count)
        });
        SimulatorIndices {
            next: firsts.collect(),
        }
    }

    /// Returns all simulators, in the order of the numbers of their cells.
    pub(crate) fn ordered(&self) -> impl Iterator<Item = &SimulatorOf<P, F>> {
        self.cells_in_order().flat_map(|cell| {
            let (tile, local) = self.grid.locate(cell);
            self.tiles[tile].members(local)
        })
    }

    /// Returns column, row and layer of all cells, in the order of their numbers.
    pub(crate) fn cells_in_order(&self) -> impl Iterator<Item = [u32; 3]> + use<P, F> {
        let [columns, rows, layers] = self.grid.counts();
        (0..layers)
            .flat_map(move |z| (0..rows).flat_map(move |y| (0..columns).map(move |x| [x, y, z])))
    }

    /// Calls `each` with position, velocity, spin, size tag, and weight (particles per simulator)
    /// of every simulator, in the order of cell numbers.
    pub fn visit(
        &self,
        mut each: impl FnMut(VectorOf<P>, VectorOf<P>, SpinOf<P>, <P::Sizes as Sizes>::Tag, f64),
    ) {
        self.each(|simulator, weight| {
            let (position, velocity) = (simulator.position, simulator.velocity);
            each(position, velocity, simulator.spin, simulator.tag, weight);
        });
    }

    /// Calls `look` for each simulator with its weight (particles per simulator), in the order of
    /// cell numbers.
    pub(crate) fn each(&self, mut look: impl FnMut(&SimulatorOf<P, F>, f64)) {
        for cell in self.cells_in_order() {
            let (tile, local) = self.grid.locate(cell);
            let weight = self.weight_in(self.grid.number(cell));
            for simulator in self.tiles[tile].members(local) {
                look(simulator, weight);
            }
        }
    }

    /// Calls `look` for each simulator with its index in [`DsmcEngine::state`] and its weight
    /// (particles per simulator), in the order of cell numbers.
    pub(crate) fn each_in_place(&self, mut look: impl FnMut(usize, &SimulatorOf<P, F>, f64)) {
        let (mut places, mut order) = (self.places(), 0);
        self.each(|simulator, weight| {
            let index = places.index(self.scene.sizes(), simulator.tag, order);
            look(index, simulator, weight);
            order += 1;
        });
    }

    /// Multiplies the velocities of all simulators by a factor.
    pub fn scale_velocities(&mut self, factor: f64) {
        self.pause = None;
        for cell in self.cells_in_order() {
            let (tile, cell) = self.grid.locate(cell);
            for simulator in self.tiles[tile].members_mut(cell) {
                simulator.velocity = simulator.velocity * factor;
            }
        }
        self.update_step_bounds();
    }

    /// Returns the number of particles per simulator in a cell, by its number in
    /// [`DsmcEngine::grid`].
    pub fn weight_in(&self, cell: u32) -> f64 {
        let factor = self
            .surroundings
            .as_ref()
            .map_or(1.0, |all| all.factor(cell));
        self.constants.weight * factor
    }

    /// Returns the particle model, with the sizes of all simulators.
    pub fn scene(&self) -> &P {
        &self.scene
    }

    /// Restarts the measurement of displacements: those of all simulators are zero now.
    pub fn track_displacements(&mut self) {
        let tiles = self.tiles.iter_mut();
        for simulator in tiles.flat_map(|tile| &mut tile.simulators) {
            simulator.mark = F::DisplacementMark::default();
        }
    }

    /// Returns the displacement of each simulator since [`Self::track_displacements`] or the start,
    /// unwrapped across periodic faces \[length\]; in the order of [`Self::state`], and zero unless
    /// tracked. Displacements of partners by the scheme are included.
    pub fn displacements(&self) -> Vec<VectorOf<P>> {
        let mut ways = vec![VectorOf::<P>::default(); self.simulators];
        self.each_in_place(|index, simulator, _| ways[index] = F::displacement_of(simulator.mark));
        ways
    }

    /// Adds a velocity change to each simulator, in the order of [`DsmcEngine::state`]
    /// \[length/time\]. Simulators beyond the list do not change.
    pub fn kick(&mut self, changes: &[VectorOf<P>]) {
        self.pause = None;
        let mut places = self.places();
        let mut order = 0;
        for cell in self.cells_in_order() {
            let (tile, cell) = self.grid.locate(cell);
            for simulator in self.tiles[tile].members_mut(cell) {
                let index = places.index(self.scene.sizes(), simulator.tag, order);
                if let Some(&change) = changes.get(index) {
                    simulator.velocity += change;
                }
                order += 1;
            }
        }
        self.update_step_bounds();
    }

    /// Starts counting collisions and virial separately for each cell.
    pub fn count_cells(&mut self) {
        self.counts_cells = true;
        for tile in &mut self.tiles {
            tile.counts = vec![CellCount::default(); tile.cells()];
        }
    }

    /// Returns the collision counts of each cell, by its number in [`DsmcEngine::grid`], and resets
    /// them. A cross-cell collision counts in the cell of the simulator that searched. Empty unless
    /// [`DsmcEngine::count_cells`] was called. Not part of a checkpoint.
    pub fn take_cell_counts(&mut self) -> Vec<CellCount> {
        if !self.counts_cells {
            return Vec::new();
        }
        let mut all = Vec::with_capacity(self.grid.cells());
        for cell in self.cells_in_order() {
            let (tile, local) = self.grid.locate(cell);
            all.push(std::mem::take(&mut self.tiles[tile].counts[local]));
        }
        all
    }

    /// Returns the counters of steps, collisions and other events since the start of the run.
    pub fn tally(&self) -> CollisionCounters {
        self.tally
    }

    /// Returns the mass, momentum and energy that boundaries have given to the gas since the start.
    pub fn ledgers(&self) -> &Ledgers<P::Space> {
        &self.ledgers
    }

    /// Returns the current time of the gas \[time\].
    pub fn time(&self) -> f64 {
        self.time
    }

    /// Returns the number of simulators.
    pub fn simulators(&self) -> usize {
        self.simulators
    }

    /// Returns the number of particles per simulator where the weight factor is one.
    pub fn weight(&self) -> f64 {
        self.constants.weight
    }

    /// Returns the sides of a cell \[length\].
    pub fn cell(&self) -> VectorOf<P> {
        self.grid.width()
    }

    /// Returns the grid of cells and tiles.
    pub fn grid(&self) -> &Grid<P::Space> {
        &self.grid
    }

    /// Returns a bound of the error that walls make in the collision rate of
    /// [`crate::Scheme::ContactPoint`], relative to exact disks: 1.75 phi d/W for each axis with
    /// two walls W apart, at packing fraction phi. Measured in channels of 3 to 20 diameters at
    /// packings 0.1 to 0.4 (`tests/channels.rs`): exact disks form layers at walls that a density
    /// averaged over some diameters does not resolve. `None` for other schemes; zero without walls.
    pub fn wall_error(&self) -> Option<f64> {
        let is_contact = self.parameters.scheme.partners() == PartnerSelection::AroundContact;
        let widths = self
            .surroundings
            .iter()
            .flat_map(|surroundings| (0..P::Space::DIMENSION).map(|axis| surroundings.width(axis)));
        let shares: f64 = widths.map(|width| 1.75 / width).sum();
        is_contact.then_some(self.constants.packing_fraction * shares)
    }

    /// Sets a stop flag that breaks off [`DsmcEngine::advance`] as soon as the current cells, or
    /// some thousand candidates within one, are done. The gas is then in the middle of a step: see
    /// [`DsmcEngine::is_interrupted`]. Steps of very unequal particles may take minutes.
    pub fn set_stop_flag(&mut self, interrupt: &Interrupt) {
        self.stop.on(interrupt);
    }

    /// Sets a pause flag that ends [`DsmcEngine::advance`] after the current time step. The gas is
    /// then consistent, half a step further, and the next call with the same end time continues to
    /// the same bytes.
    pub fn set_pause_flag(&mut self, pause: &Interrupt) {
        self.stop.set_pause_flag(pause);
    }

    /// Returns true if the stop flag of [`DsmcEngine::set_stop_flag`] broke off a time step. The
    /// state of the gas is then invalid, and [`DsmcEngine::advance`] does nothing; resume from the
    /// last checkpoint.
    pub fn is_interrupted(&self) -> bool {
        self.stop.has_ended()
    }

    /// Returns the memory that the engine occupies \[bytes\].
    pub fn memory_bytes(&self) -> usize {
        let boxes = self.departing.iter().chain(&self.arriving);
        size_of::<Self>()
            + self.tiles.iter().map(Tile::bytes).sum::<usize>()
            + boxes
                .map(|outbox| size_of::<SendBuffer<P, F>>() + outbox.bytes())
                .sum::<usize>()
            + self.far.capacity() * size_of::<(u32, Migrant<P, F>)>()
            + self.pool.lent_bytes(Scratch::bytes)
            + self.halo_copies.lent_bytes(HaloCopy::bytes)
            + self.density.bytes()
            + self
                .surroundings
                .as_ref()
                .map_or(0, GridBoundaries::memory_bytes)
            + self.rates.as_ref().map_or(0, Rates::bytes)
            + self.grid.bytes()
    }

    /// Regroups the cells into tiles of about this many simulators. This changes speed and memory;
    /// it changes results only for cross-cell schemes, by the order of collisions. Counts by cell
    /// restart.
    pub fn retile(&mut self, simulators_per_tile: usize) {
        self.pause = None;
        let simulators: Vec<_> = self.ordered().copied().collect();
        let counts = self.grid.counts().map(|count| count as usize);
        let domain = *self.grid.domain();
        self.grid = Grid::new(
            domain,
            counts,
            self.simulators,
            simulators_per_tile.max(1),
            self.grid.reach(),
        );
        self.fill(&simulators);
    }

    /// Fixes the length of the time step \[time\], also if the gas heats up; the caller must ensure
    /// that it is short enough. Not part of a checkpoint.
    pub fn hold_step(&mut self, length: f64) {
        self.pause = None;
        self.held_step = (length > 0.0).then_some(length);
    }
}
