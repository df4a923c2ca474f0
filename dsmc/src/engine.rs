//! The engine: how steps follow each other.

use serde::{Deserialize, Serialize};
use stosszahl_model::random::{Purpose, Streams};
use stosszahl_model::{
    Body, Domain, Free, Observe, Physics, Restitution, Sizes, Smooth, Space, State, Vector,
    VectorOf,
};

use crate::across::{self, Arm, Rates};
use crate::collide::{Kernel, covered};
use crate::density::{Density, Gas};
use crate::grid::Grid;
use crate::parameters::{Displacement, EngineError, Parameters};
use crate::simulator::{Follow, SimulatorOf, Unfollowed, is_good};
use crate::start;
use crate::sweep::{Pool, is_parallel, sweep};
use crate::tally::{Stock, Tally, Unit};
use crate::tile::{Arrivals, Outbox, Tile, Traveller};

/// Simulators that a tile is to hold: with its working copy it fits the second cache, 2 MB here; the larger a tile,
/// the fewer leave it.
const PER_TILE: usize = 8192;

/// Everything needed to continue a run to the same bytes.
#[derive(Debug, Serialize, Deserialize)]
#[serde(bound = "")]
pub struct Checkpoint<P: Physics, F: Follow<P::Space> = Unfollowed> {
    time: f64,
    /// In the order of their cells.
    simulators: Vec<SimulatorOf<P, F>>,
    stock: Stock<P::Space>,
    unit: Unit,
    tally: Tally,
    arm: Arm,
}

/// What of the gas never changes.
struct Constants {
    /// Particles for each simulator.
    weight: f64,
    /// Mean free path of the mean density \[length\], for the step.
    mean_free_path: f64,
    moment_ratio: f64,
    /// Radius around a point within which all simulators are equally likely partners \[length\].
    partner_radius: f64,
    /// How far beyond its own cells work on a tile reaches \[length\].
    reach: f64,
    /// Mean radius of the particles \[length\].
    mean_radius: f64,
}

/// Direct Simulation Monte Carlo of smooth particles in a periodic box.
///
/// `F` says whether it follows how far simulators come ([`crate::Followed`]) or not.
pub struct Engine<P: Physics, F: Follow<P::Space> = Unfollowed> {
    /// The scene, with the sizes of all simulators.
    scene: P,
    parameters: Parameters,
    streams: Streams,
    constants: Constants,
    grid: Grid<P::Space>,
    density: Density<P::Space>,
    /// Collisions across cells: their rates, and how far partners are sought.
    rates: Option<Rates<P::Space>>,
    arm: Arm,
    simulators: usize,
    tiles: Vec<Tile<P, F>>,
    /// What leaves tiles in the present flight, and what left them in the last.
    departing: Vec<Outbox<P, F>>,
    arriving: Vec<Outbox<P, F>>,
    far: Vec<(u32, Traveller<P, F>)>,
    pool: Pool<P, F>,
    held_step: Option<f64>,
    time: f64,
    stock: Stock<P::Space>,
    unit: Unit,
    tally: Tally,
}

impl<P> Engine<P>
where
    P: Physics<Surface = Smooth, Field = Free>,
{
    /// [`Engine::start`] where displacements are not followed.
    ///
    /// # Errors
    /// As [`Engine::start`].
    pub fn new(
        scene: &P,
        parameters: Parameters,
        state: &State<P>,
        streams: Streams,
    ) -> Result<Self, EngineError> {
        Self::start(scene, parameters, state, streams)
    }
}

impl<P, F> Engine<P, F>
where
    P: Physics<Surface = Smooth, Field = Free>,
    F: Follow<P::Space>,
{
    /// Starts from a state of particles.
    ///
    /// With several simulators per particle, the first set has the state's own positions and velocities, and further sets
    /// are made as [`crate::Copies`] says.
    ///
    /// # Errors
    /// [`EngineError`] if a parameter or a number of the state has no meaning.
    pub fn start(
        scene: &P,
        parameters: Parameters,
        state: &State<P>,
        streams: Streams,
    ) -> Result<Self, EngineError> {
        parameters.check()?;
        let simulators = start::simulators::<P, F>(scene, &parameters, state, streams);
        let checkpoint = Checkpoint {
            time: state.time,
            simulators,
            stock: Stock::default(),
            unit: Unit::of(0.0),
            tally: Tally::default(),
            arm: Arm::default(),
        };
        let mut engine = Self::resume(scene, parameters, state.domain, checkpoint, streams)?;
        engine.take_stock();
        Ok(engine)
    }

    /// Goes on from a checkpoint of a run that was started with the same arguments.
    ///
    /// # Errors
    /// As [`Engine::new`].
    pub fn resume(
        scene: &P,
        parameters: Parameters,
        domain: Domain<P::Space>,
        checkpoint: Checkpoint<P, F>,
        streams: Streams,
    ) -> Result<Self, EngineError> {
        parameters.check()?;
        let inelastic = parameters.displacement == Displacement::Inelastic;
        if inelastic {
            check_displacement(scene, &domain)?;
        }
        let copies = parameters.simulators_per_disk as usize;
        let scene = scene.with_sizes(scene.sizes().repeated(copies));
        let Checkpoint {
            time,
            simulators,
            stock,
            unit,
            tally,
            arm,
        } = checkpoint;
        check_numbers::<P, F>(&simulators)?;
        let weight = 1.0 / copies as f64;
        let sizes = scene.sizes();
        let dimension = P::Space::DIMENSION as i32;
        let [mut first, mut lower, mut upper, mut covered] = [0.0; 4];
        // In the order of the sizes, which unlike that of the simulators is the same after a restart.
        for index in 0..simulators.len() {
            let radius = sizes.radius(sizes.tag(index));
            first += 2.0 * radius;
            lower += (2.0 * radius).powi(dimension - 1);
            upper += (2.0 * radius).powi(dimension);
            covered += P::Space::ball(radius);
        }
        let packing_fraction = weight * covered / domain.volume();
        let (mean_diameter, moment_ratio) = if upper > 0.0 {
            (first / simulators.len() as f64, lower / upper)
        } else {
            (2.0 * sizes.largest_radius(), 1.0)
        };
        let counts = parameters.cells(&domain, packing_fraction, mean_diameter);
        let radius = parameters.partner_radius::<P::Space>(packing_fraction, mean_diameter);
        let reach = across::reach(
            parameters.scheme,
            2.0 * sizes.largest_radius(),
            radius,
            (0..P::Space::DIMENSION)
                .map(|axis| domain.lengths()[axis] / counts[axis] as f64)
                .fold(0.0, f64::max),
        );
        let grid = Grid::new(domain, counts, simulators.len(), PER_TILE, reach);
        let gas = Gas {
            limit: parameters.largest_contact_value,
            counts: grid.counts(),
            cell: grid.cell_volume(),
            width: (0..P::Space::DIMENSION)
                .map(|axis| grid.width()[axis])
                .fold(f64::MAX, f64::min),
            diameter: mean_diameter,
            simulators_per_particle: copies as f64,
            unit: weight * P::Space::ball(sizes.largest_radius()),
            packing_fraction,
        };
        let density = Density::new(parameters.scheme, &gas);
        let rates = parameters.scheme.is_across().then(|| {
            let ball = covered / simulators.len().max(1) as f64;
            Rates::new(density.unit(), ball, gas.limit, P::Sizes::UNIFORM)
        });
        let mut engine = Self {
            density,
            rates,
            arm,
            constants: Constants {
                weight,
                mean_free_path: parameters
                    .mean_free_path::<P::Space>(packing_fraction, mean_diameter),
                moment_ratio,
                partner_radius: radius,
                reach,
                mean_radius: 0.5 * mean_diameter,
            },
            scene,
            parameters,
            streams,
            grid,
            simulators: simulators.len(),
            tiles: Vec::new(),
            departing: Vec::new(),
            arriving: Vec::new(),
            far: Vec::new(),
            pool: Pool::default(),
            held_step: None,
            time,
            stock,
            unit,
            tally,
        };
        engine.fill(&simulators);
        Ok(engine)
    }

    /// Distributes simulators among the tiles; those of a cell keep their order.
    fn fill(&mut self, simulators: &[SimulatorOf<P, F>]) {
        let places = self.grid.places();
        let mut sorted: Vec<(u32, u16, u32)> = simulators
            .iter()
            .enumerate()
            .map(|(index, simulator)| {
                let (tile, cell) = self.grid.locate(self.grid.cell_at(simulator.position));
                (tile as u32, cell as u16, index as u32)
            })
            .collect();
        sorted.sort_unstable();
        let mut rest = &sorted[..];
        let mut members = Vec::new();
        self.tiles.clear();
        for (number, place) in places.into_iter().enumerate() {
            let end = rest.partition_point(|(tile, ..)| *tile as usize == number);
            members.clear();
            members.extend(
                rest[..end]
                    .iter()
                    .map(|&(_, cell, index)| (cell, simulators[index as usize])),
            );
            rest = &rest[end..];
            let mut tile = Tile::new(place);
            tile.take(&members);
            self.tiles.push(tile);
        }
        let boxes = || (0..self.tiles.len()).map(|_| Outbox::default()).collect();
        (self.departing, self.arriving) = (boxes(), boxes());
        self.pool = Pool::default();
    }

    /// Advances by whole steps to the time `until` (the last step is shortened to end there exactly), or
    /// for `most_steps`. True if the time was reached.
    pub fn advance(&mut self, until: f64, most_steps: u64, watch: &mut impl Observe<P>) -> bool {
        let mut left = most_steps;
        let Some(mut step) = self.next_step(self.time, until, left) else {
            return until <= self.time;
        };
        self.fly_only(0.5 * step);
        loop {
            left -= 1;
            let end = if step >= until - self.time {
                until
            } else {
                self.time + step
            };
            let next = self.next_step(end, until, left);
            // The half flights between two collisions are one flight.
            let flight = 0.5 * (step + next.unwrap_or(0.0));
            self.step(step, flight, watch);
            self.time = end;
            let Some(next) = next else { break };
            step = next;
        }
        self.settle();
        until <= self.time
    }

    /// The gas at the present time: one body for each simulator, in the order of the sizes of
    /// [`Engine::scene`].
    pub fn state(&self) -> State<P> {
        let origin = VectorOf::<P>::default();
        let mut bodies = vec![Body::new(origin, origin); self.simulators];
        for (order, simulator) in self.ordered().enumerate() {
            bodies[P::Sizes::index(simulator.tag, order)] =
                Body::new(simulator.position, simulator.velocity);
        }
        State {
            time: self.time,
            domain: *self.grid.domain(),
            bodies,
        }
    }

    /// All simulators, in the order of the numbers of their cells.
    fn ordered(&self) -> impl Iterator<Item = &SimulatorOf<P, F>> {
        let [columns, rows, layers] = self.grid.counts();
        let cells = (0..layers)
            .flat_map(move |z| (0..rows).flat_map(move |y| (0..columns).map(move |x| [x, y, z])));
        cells.flat_map(|cell| {
            let (tile, local) = self.grid.locate(cell);
            self.tiles[tile].members(local)
        })
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
        for (order, simulator) in self.ordered().enumerate() {
            ways[P::Sizes::index(simulator.tag, order)] = F::way(simulator.mark);
        }
        ways
    }

    /// Adds to the velocity of each simulator, in the order of [`Engine::state`]; further simulators stay as they
    /// are.
    pub fn kick(&mut self, changes: &[VectorOf<P>]) {
        let [columns, rows, layers] = self.grid.counts();
        let mut order = 0;
        for z in 0..layers {
            for y in 0..rows {
                for x in 0..columns {
                    let (tile, cell) = self.grid.locate([x, y, z]);
                    for simulator in self.tiles[tile].members_mut(cell) {
                        let index = P::Sizes::index(simulator.tag, order);
                        if let Some(&change) = changes.get(index) {
                            simulator.velocity += change;
                        }
                        order += 1;
                    }
                }
            }
        }
        self.take_stock();
    }

    /// Everything needed to go on from here.
    pub fn checkpoint(&self) -> Checkpoint<P, F> {
        Checkpoint {
            time: self.time,
            simulators: self.ordered().copied().collect(),
            stock: self.stock,
            unit: self.unit,
            tally: self.tally,
            arm: self.arm.clone(),
        }
    }

    /// What was done so far.
    pub fn tally(&self) -> Tally {
        self.tally
    }

    /// The present time.
    pub fn time(&self) -> f64 {
        self.time
    }

    /// Number of simulators.
    pub fn simulators(&self) -> usize {
        self.simulators
    }

    /// Particles for each simulator.
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

    /// Memory that the engine holds, all included \[bytes\].
    pub fn bytes(&self) -> usize {
        let boxes = self.departing.iter().chain(&self.arriving);
        size_of::<Self>()
            + self.tiles.iter().map(Tile::bytes).sum::<usize>()
            + boxes
                .map(|outbox| size_of::<Outbox<P, F>>() + outbox.bytes())
                .sum::<usize>()
            + self.far.capacity() * size_of::<(u32, Traveller<P, F>)>()
            + self.pool.bytes()
            + self.density.bytes()
            + self.rates.as_ref().map_or(0, Rates::bytes)
            + self.grid.bytes()
    }

    /// Groups the cells in tiles that hold about so many simulators. It changes speed and memory, and of results only those
    /// of schemes whose partners are in different cells: their tiles collide one after the other.
    pub fn retile(&mut self, simulators_per_tile: usize) {
        let simulators: Vec<_> = self.ordered().copied().collect();
        let counts = self.grid.counts().map(|count| count as usize);
        let domain = *self.grid.domain();
        self.grid = Grid::new(
            domain,
            counts,
            self.simulators,
            simulators_per_tile.max(1),
            self.constants.reach,
        );
        self.fill(&simulators);
    }

    /// Takes steps of this length from now on \[time\], whatever the gas does: whether it is short enough is then the
    /// caller's concern. Not part of a checkpoint.
    pub fn hold_step(&mut self, length: f64) {
        self.held_step = (length > 0.0).then_some(length);
    }

    /// The length of the step that begins at the time `from`, unless that is the end or no step is left.
    fn next_step(&self, from: f64, until: f64, steps_left: u64) -> Option<f64> {
        let left = until - from;
        if left.is_nan() || left <= 0.0 || steps_left == 0 {
            return None;
        }
        let step = self.held_step.unwrap_or_else(|| self.step_length());
        // Equal last steps instead of a long and a tiny one.
        let steps = (left / step).ceil();
        if steps <= 1.0 {
            return Some(left);
        }
        let step = if steps.is_finite() {
            left / steps
        } else {
            step
        };
        // What the clock shows after it, which rounds, less what it shows before: positions and clock do not
        // drift apart. Where the step is too short for the clock, its least.
        let end = (from + step).max(from.next_up());
        Some(end - from)
    }

    /// What the gas allows, as it was before the last collisions: the fastest simulator crosses a cell in several
    /// steps, and a mean free time lasts as many.
    fn step_length(&self) -> f64 {
        let width = self.grid.width();
        // Partners across cells are sought afresh in every step, so that nothing hangs on the crossing of a cell.
        let axes = if self.parameters.scheme.is_across() {
            0
        } else {
            P::Space::DIMENSION
        };
        let crossing = (0..axes)
            .map(|axis| width[axis] / self.stock.speeds[axis])
            .fold(f64::MAX, f64::min);
        let degrees = P::Space::DIMENSION * self.simulators.max(1);
        let temperature = self.stock.twice_energy(self.unit) / degrees as f64;
        // The mean mass is one in the program's units.
        let mean_speed = P::Space::MEAN_SPEED * temperature.sqrt();
        let step = crossing.min(self.constants.mean_free_path / mean_speed);
        // A gas at rest: any step, that can be added to another.
        (step / self.parameters.steps_per_crossing).min(1e150)
    }

    /// Speeds and energy of the present state, for the length of the next step.
    fn take_stock(&mut self) {
        let sizes = self.scene.sizes();
        let mut total = 0.0;
        for simulator in self.ordered() {
            total += sizes.mass(simulator.tag) * simulator.velocity.square();
        }
        let unit = Unit::of(total);
        let mut stock = Stock::default();
        for simulator in self.ordered() {
            let v = simulator.velocity;
            let twice_energy = sizes.mass(simulator.tag) * v.square();
            stock.note(v, v, twice_energy, unit.inverse());
        }
        (self.stock, self.unit) = (stock, unit);
    }
}

impl<P, F> Engine<P, F>
where
    P: Physics<Surface = Smooth, Field = Free>,
    F: Follow<P::Space>,
{
    /// Collisions of a step, and the flight after them.
    fn step(&mut self, step: f64, flight: f64, watch: &mut impl Observe<P>) {
        let parallel = is_parallel(self.simulators);
        let across = self.parameters.scheme.is_across();
        let around = self.density.looks_around();
        if around || across {
            self.settle();
        }
        if around {
            self.look_around(parallel);
        }
        let unit = Unit::of(self.stock.twice_energy(self.unit));
        let kernel = Kernel {
            scene: &self.scene,
            grid: &self.grid,
            density: &self.density,
            displacement: self.parameters.displacement,
            weight: self.constants.weight,
            moment_ratio: self.constants.moment_ratio,
            partner_radius: self.constants.partner_radius,
            mean_radius: self.constants.mean_radius,
            step,
            time: self.time + 0.5 * step,
            streams: self.streams.bundle(Purpose::Collisions, self.tally.steps),
            units: unit.inverse(),
            looks: looks::<P, _>(watch),
        };
        if let Some(rates) = &self.rates {
            let (tiles, arm, tally) = (&mut self.tiles, &mut self.arm, &mut self.tally);
            for collision in kernel.collide_across(parallel, tiles, rates, arm, tally) {
                watch.collision(&collision);
            }
            self.fly_only(flight);
            self.close_step(unit);
            return;
        }
        let arrivals = Arrivals {
            boxes: &self.arriving,
            far: &self.far,
        };
        let (scene, grid) = (&self.scene, &self.grid);
        sweep(
            parallel,
            &mut self.tiles,
            &mut self.departing,
            &self.pool,
            |tile, outbox, scratch| {
                if around {
                    scratch.sorted.clear();
                    scratch.sorted.extend_from_slice(&tile.simulators);
                } else {
                    tile.arrange(grid, &arrivals, scratch);
                }
                kernel.collide(tile, &mut scratch.sorted);
                tile.fly(scene, grid, flight, scratch, outbox);
            },
        );
        self.exchange();
        for tile in &mut self.tiles {
            self.tally.add(&tile.tally);
            for collision in tile.log.drain(..) {
                watch.collision(&collision);
            }
        }
        self.close_step(unit);
    }

    /// Adds up what the next step follows.
    fn close_step(&mut self, unit: Unit) {
        self.stock = Stock::default();
        self.unit = unit;
        for tile in &self.tiles {
            self.stock.add(&tile.stock);
        }
        self.tally.steps += 1;
    }

    /// A flight from arranged tiles, with no collisions before.
    fn fly_only(&mut self, duration: f64) {
        let (scene, grid) = (&self.scene, &self.grid);
        sweep(
            is_parallel(self.simulators),
            &mut self.tiles,
            &mut self.departing,
            &self.pool,
            |tile, outbox, scratch| {
                scratch.sorted.clear();
                scratch.sorted.extend_from_slice(&tile.simulators);
                tile.fly(scene, grid, duration, scratch, outbox);
            },
        );
        self.exchange();
    }

    /// Arranges all tiles, so that each holds its simulators by cell.
    fn settle(&mut self) {
        let grid = &self.grid;
        let arrivals = Arrivals {
            boxes: &self.arriving,
            far: &self.far,
        };
        sweep(
            is_parallel(self.simulators),
            &mut self.tiles,
            &mut self.departing,
            &self.pool,
            |tile, _, scratch| {
                tile.arrange(grid, &arrivals, scratch);
                tile.settle(scratch);
            },
        );
    }

    /// Turns what departed into what arrives.
    fn exchange(&mut self) {
        std::mem::swap(&mut self.departing, &mut self.arriving);
        self.far.clear();
        for outbox in &mut self.arriving {
            self.far.append(&mut outbox.far);
        }
        let order = |(tile, traveller): &(u32, Traveller<P, F>)| (*tile, traveller.source);
        self.far.sort_by_key(order);
    }

    /// Lets the density see all cells.
    fn look_around(&mut self, parallel: bool) {
        let (grid, tiles, sizes) = (&self.grid, &self.tiles, self.scene.sizes());
        let rows = grid.counts()[1];
        self.density.update(parallel, |line, values| {
            let line = line as u32;
            let mut x = 0;
            while x < values.len() {
                let cell = [x as u32, line % rows, line / rows];
                let (tile, first) = grid.locate(cell);
                let tile = &tiles[tile];
                for local in 0..tile.place.sides[0] as usize {
                    values[x] = covered::<P, F>(sizes, tile.members(first + local)) as f32;
                    x += 1;
                }
            }
        });
    }
}

/// Displacements farther than the box would lead anywhere, and near restitution 0 they are no numbers.
fn check_displacement<P: Physics>(scene: &P, domain: &Domain<P::Space>) -> Result<(), EngineError> {
    let restitution = scene.restitution().normal(1.0);
    if restitution <= 0.0 {
        return Err(EngineError::NoDisplacement);
    }
    let side = (0..P::Space::DIMENSION)
        .map(|axis| domain.lengths()[axis])
        .fold(f64::MAX, f64::min);
    let diameter = 2.0 * scene.sizes().largest_radius();
    let displacement = diameter * 0.5 * (1.0 + restitution) / restitution;
    if displacement <= side.max(diameter) {
        Ok(())
    } else {
        Err(EngineError::FarDisplacement {
            restitution,
            displacement,
            side,
        })
    }
}

fn looks<P: Physics, W: Observe<P>>(_watch: &W) -> bool {
    W::LOOKS
}

fn check_numbers<P: Physics, F: Follow<P::Space>>(
    simulators: &[SimulatorOf<P, F>],
) -> Result<(), EngineError> {
    let dimension = P::Space::DIMENSION;
    let bad = simulators.iter().position(|simulator| {
        !is_good(dimension, simulator.position) || !is_good(dimension, simulator.velocity)
    });
    bad.map_or(Ok(()), |index| {
        let list = |vector: VectorOf<P>| (0..dimension).map(|axis| vector[axis]).collect();
        Err(EngineError::BadNumber {
            simulator: index,
            position: list(simulators[index].position),
            velocity: list(simulators[index].velocity),
        })
    })
}
