//! The engine: what it holds, and what can be asked of it.

use stosszahl_model::random::Streams;
use stosszahl_model::{Body, Interrupt, Physics, Sizes, Space, SpinOf, State, VectorOf};

use crate::boundary::{Ledgers, Surroundings};
use crate::cross_cell::{Arm, HaloCopy, Rates};
use crate::decomposition::Subdomain;
use crate::density::Density;
use crate::grid::Grid;
use crate::parameters::Parameters;
use crate::particle::{Follow, SimulatorOf, Unfollowed};
use crate::pause::Pause;
use crate::start_means::Means;
use crate::tally::{CellCount, Stock, Tally, Unit};
use crate::threads::Pool;
use crate::tile::{Outbox, Scratch, Tile, Traveller};
use stosszahl_model::interrupt::Interruption;

/// What of the gas never changes.
pub(crate) struct Constants {
    /// Particles for each simulator.
    pub(crate) weight: f64,
    /// Packing fraction of the start, or of the densest inflow.
    pub(crate) packing_fraction: f64,
    /// Mean free path of the mean density \[length\], for the step.
    pub(crate) mean_free_path: f64,
    pub(crate) moment_ratio: f64,
    /// Radius around a point within which all simulators are equally likely partners \[length\].
    pub(crate) partner_radius: f64,
    /// Mean radius of the particles \[length\].
    pub(crate) mean_radius: f64,
    /// Mean mass of the particles.
    pub(crate) mean_mass: f64,
}

/// Finds the places of simulators in a state, one after the other: blocks of like ones follow each other.
struct Places {
    /// The next place of each block; empty where there are none.
    next: Vec<usize>,
}

impl Places {
    /// The place of the simulator that comes `order`-th.
    fn index<Z: Sizes>(&mut self, sizes: &Z, tag: Z::Tag, order: usize) -> usize {
        match self.next.get_mut(sizes.block(tag) as usize) {
            Some(next) => {
                *next += 1;
                *next - 1
            }
            None => Z::index(tag, order),
        }
    }
}

/// Direct Simulation Monte Carlo of smooth or rough particles.
///
/// `F` says whether it follows how far simulators come ([`crate::Followed`]) or not.
pub struct Engine<P: Physics, F: Follow<P::Space> = Unfollowed> {
    /// The scene, with the sizes of all simulators.
    pub(crate) scene: P,
    pub(crate) parameters: Parameters,
    pub(crate) streams: Streams,
    pub(crate) constants: Constants,
    pub(crate) grid: Grid<P::Space>,
    pub(crate) density: Density<P::Space>,
    /// Partners around points of contact: their rates, and how far away they are.
    pub(crate) rates: Option<Rates<P::Space>>,
    pub(crate) arm: Arm,
    pub(crate) simulators: usize,
    pub(crate) tiles: Vec<Tile<P, F>>,
    /// What leaves tiles in the present flight, and what left them in the last.
    pub(crate) departing: Vec<Outbox<P, F>>,
    pub(crate) arriving: Vec<Outbox<P, F>>,
    pub(crate) far: Vec<(u32, Traveller<P, F>)>,
    pub(crate) pool: Pool<Scratch<P, F>>,
    /// Halo copies of tiles, of schemes whose partners lie across cells.
    pub(crate) halo_copies: Pool<HaloCopy<P>>,
    pub(crate) held_step: Option<f64>,
    pub(crate) counts_cells: bool,
    pub(crate) time: f64,
    pub(crate) stock: Stock<P::Space>,
    pub(crate) unit: Unit,
    pub(crate) tally: Tally,
    pub(crate) ledgers: Ledgers<P::Space>,
    /// What is at the faces of the box and inside it; none if it is periodic.
    pub(crate) surroundings: Option<Surroundings<P>>,
    pub(crate) means: Means,
    /// Breaks work off.
    pub(crate) stop: Interruption,
    /// The pause in which the gas is; none once something else was done with it.
    pub(crate) pause: Option<Pause>,
    /// The part of the gas that this process holds, if there are several.
    pub(crate) share: Option<Subdomain<P::Space>>,
}

impl<P, F> Engine<P, F>
where
    P: Physics,
    F: Follow<P::Space>,
{
    /// The gas at the present time: one body for each simulator, in the order of the sizes of
    /// [`Engine::scene`]; species one after the other in each copy of the gas, as many of each as there are now.
    pub fn state(&self) -> State<P> {
        let origin = VectorOf::<P>::default();
        let mut bodies = vec![Body::new(origin, origin); self.simulators];
        self.each_in_place(|index, simulator, _| {
            bodies[index] = Body {
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

    /// The places of simulators in [`Engine::state`].
    fn places(&self) -> Places {
        let mut counts = Vec::new();
        if !P::Sizes::UNIFORM && !P::Sizes::INDIVIDUAL {
            for simulator in self.ordered() {
                let block = self.scene.sizes().block(simulator.tag) as usize;
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
        Places {
            next: firsts.collect(),
        }
    }

    /// All simulators, in the order of the numbers of their cells.
    pub(crate) fn ordered(&self) -> impl Iterator<Item = &SimulatorOf<P, F>> {
        self.cells_in_order().flat_map(|cell| {
            let (tile, local) = self.grid.locate(cell);
            self.tiles[tile].members(local)
        })
    }

    /// The coordinates of all cells, in the order of their numbers.
    pub(crate) fn cells_in_order(&self) -> impl Iterator<Item = [u32; 3]> + use<P, F> {
        let [columns, rows, layers] = self.grid.counts();
        (0..layers)
            .flat_map(move |z| (0..rows).flat_map(move |y| (0..columns).map(move |x| [x, y, z])))
    }

    /// Shows each simulator, in the order of the numbers of their cells: position, velocity, spin, the tag of its size in
    /// [`Engine::scene`], and how many particles it stands for.
    pub fn visit(
        &self,
        mut each: impl FnMut(VectorOf<P>, VectorOf<P>, SpinOf<P>, <P::Sizes as Sizes>::Tag, f64),
    ) {
        self.each(|simulator, weight| {
            let (position, velocity) = (simulator.position, simulator.velocity);
            each(position, velocity, simulator.spin, simulator.tag, weight);
        });
    }

    /// Shows each simulator and the number of particles that it stands for, in the order of the numbers of their cells.
    pub(crate) fn each(&self, mut look: impl FnMut(&SimulatorOf<P, F>, f64)) {
        for cell in self.cells_in_order() {
            let (tile, local) = self.grid.locate(cell);
            let weight = self.weight_in(self.grid.number(cell));
            for simulator in self.tiles[tile].members(local) {
                look(simulator, weight);
            }
        }
    }

    /// The same, with the place of each in [`Engine::state`].
    pub(crate) fn each_in_place(&self, mut look: impl FnMut(usize, &SimulatorOf<P, F>, f64)) {
        let (mut places, mut order) = (self.places(), 0);
        self.each(|simulator, weight| {
            let index = places.index(self.scene.sizes(), simulator.tag, order);
            look(index, simulator, weight);
            order += 1;
        });
    }

    /// Multiplies all velocities.
    pub fn scale_velocities(&mut self, factor: f64) {
        self.pause = None;
        for cell in self.cells_in_order() {
            let (tile, cell) = self.grid.locate(cell);
            for simulator in self.tiles[tile].members_mut(cell) {
                simulator.velocity = simulator.velocity * factor;
            }
        }
        self.take_stock();
    }

    /// Particles for each simulator in a cell, by its number in [`Engine::grid`].
    pub fn weight_in(&self, cell: u32) -> f64 {
        let factor = self
            .surroundings
            .as_ref()
            .map_or(1.0, |all| all.factor(cell));
        self.constants.weight * factor
    }

    /// The scene with the sizes of all simulators.
    pub fn scene(&self) -> &P {
        &self.scene
    }

    /// Measures displacements from now on.
    pub fn follow_displacements(&mut self) {
        let tiles = self.tiles.iter_mut();
        for simulator in tiles.flat_map(|tile| &mut tile.simulators) {
            simulator.mark = F::Mark::default();
        }
    }

    /// How far simulators have come since the start or [`Self::follow_displacements`], across the edges of the box
    /// \[length\]; in the order of [`Self::state`] and zero unless they are followed. The displacement of partners in
    /// the scheme counts.
    pub fn displacements(&self) -> Vec<VectorOf<P>> {
        let mut ways = vec![VectorOf::<P>::default(); self.simulators];
        self.each_in_place(|index, simulator, _| ways[index] = F::way(simulator.mark));
        ways
    }

    /// Adds to the velocity of each simulator, in the order of [`Engine::state`]; further simulators stay as they
    /// are.
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
        self.take_stock();
    }

    /// Counts collisions by cell from now on.
    pub fn count_cells(&mut self) {
        self.counts_cells = true;
        for tile in &mut self.tiles {
            tile.counts = vec![CellCount::default(); tile.cells()];
        }
    }

    /// What happened in each cell, by its number in [`Engine::grid`], since [`Engine::count_cells`] or the last call: across
    /// cells, in that of the simulator that looked for a partner. Empty if nothing is counted. Not part of a checkpoint.
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

    /// What was done so far.
    pub fn tally(&self) -> Tally {
        self.tally
    }

    /// What boundaries gave to the gas so far.
    pub fn ledgers(&self) -> &Ledgers<P::Space> {
        &self.ledgers
    }

    /// The present time.
    pub fn time(&self) -> f64 {
        self.time
    }

    /// Number of simulators.
    pub fn simulators(&self) -> usize {
        self.simulators
    }

    /// Particles for each simulator, where the factor of its region is one.
    pub fn weight(&self) -> f64 {
        self.constants.weight
    }

    /// Sides of a cell \[length\].
    pub fn cell(&self) -> VectorOf<P> {
        self.grid.width()
    }

    /// The cells and tiles.
    pub fn grid(&self) -> &Grid<P::Space> {
        &self.grid
    }

    /// By how much, at most, the collision rate of [`crate::Scheme::ContactPoint`] falls short of that of exact disks because
    /// of walls: 1.75 phi d/W for each axis with two walls W apart, at a packing fraction phi. Measured in channels of 3 to 20
    /// diameters at packings 0.1 to 0.4 (`tests/channels.rs`): exact disks form layers at walls, which a density taken over
    /// some diameters does not know. None for other schemes, and zero without walls.
    pub fn wall_error(&self) -> Option<f64> {
        let is_contact = matches!(self.parameters.scheme, crate::Scheme::ContactPoint { .. });
        let widths = self
            .surroundings
            .iter()
            .flat_map(|surroundings| (0..P::Space::DIMENSION).map(|axis| surroundings.width(axis)));
        let shares: f64 = widths.map(|width| 1.75 / width).sum();
        is_contact.then_some(self.constants.packing_fraction * shares)
    }

    /// Breaks work off when this is raised, as soon as the cells at work, or some thousand trials within one, are done: a step
    /// of particles of very different sizes may take minutes. What is left is no state of the gas: [`Engine::is_interrupted`].
    pub fn stop_on(&mut self, interrupt: &Interrupt) {
        self.stop.on(interrupt);
    }

    /// Ends [`Engine::advance`] after the present step once this is raised: the gas is then whole, half a step further, and the next
    /// advance to the same time goes on to the same bytes.
    pub fn pause_on(&mut self, pause: &Interrupt) {
        self.stop.pause_on(pause);
    }

    /// Whether the interrupt of [`Engine::stop_on`] broke a step off. The gas is then in the middle of it, so that nothing the engine
    /// shows has a meaning, and [`Engine::advance`] does nothing: to go on, resume from the last checkpoint.
    pub fn is_interrupted(&self) -> bool {
        self.stop.has_ended()
    }

    /// Memory that the engine holds, all included \[bytes\].
    pub fn bytes(&self) -> usize {
        let boxes = self.departing.iter().chain(&self.arriving);
        size_of::<Self>()
            + self.tiles.iter().map(Tile::bytes).sum::<usize>()
            + boxes
                .map(|outbox| size_of::<Outbox<P, F>>() + outbox.bytes())
                .sum::<usize>()
            + self.far.capacity() * size_of::<(u32, Traveller<P, F>)>()
            + self.pool.bytes(Scratch::bytes)
            + self.halo_copies.bytes(HaloCopy::bytes)
            + self.density.bytes()
            + self.surroundings.as_ref().map_or(0, Surroundings::bytes)
            + self.rates.as_ref().map_or(0, Rates::bytes)
            + self.grid.bytes()
    }

    /// Groups the cells in tiles that hold about this number of simulators. It changes speed and memory, and no result of pairs
    /// within cells; across cells, also the order in which pairs collide. Counts by cell begin anew.
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

    /// Takes steps of this length from now on \[time\], whatever the gas does: whether it is short enough is then the
    /// caller's concern. Not part of a checkpoint.
    pub fn hold_step(&mut self, length: f64) {
        self.pause = None;
        self.held_step = (length > 0.0).then_some(length);
    }
}
