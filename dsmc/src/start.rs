//! Start of a DSMC engine from a state, and resumption from a checkpoint: checks, grid, tiles and
//! placement of simulators.

use std::borrow::Cow;
use std::marker::PhantomData;

use stosszahl_model::interrupt::Interruption;
use stosszahl_model::random::{Purpose, Streams};
use stosszahl_model::walls::WallLedger;
use stosszahl_model::{
    Domain, Field, ParticleModel, Restitution, Shear, Sizes, Space, State, Surface, VectorOf,
};

use crate::boundary::{
    BoundaryConditions, GridBoundaries, Ledgers, MOST_SIMULATORS, Transfer, enter,
};
use crate::checkpoint::DsmcCheckpoint;
use crate::cross_cell::{self, ContactDistance, Rates};
use crate::density::{Density, DensityInput};
use crate::engine::{Constants, DsmcEngine};
use crate::grid::Grid;
use crate::parameters::{DsmcError, Parameters};
use crate::particle::{DisplacementTracking, SimulatorOf, is_good};
use crate::random_counts::draw_whole;
use crate::replicate_start;
use crate::scheme::{PartnerDisplacement, PartnerSelection, Scheme};
use crate::start_means::Means;
use crate::start_stream::StartStream;
use crate::tally::{CellCount, CollisionCounters, EnergyUnit, StepBounds};
use crate::threads::Pool;
use crate::tile::{SendBuffer, Tile};

/// Target number of simulators per tile: with its working copy a tile fits a second-level cache of
/// 2 MB.
const PER_TILE: usize = 8192;

/// Target number of simulators per tile for cross-cell schemes; too small tiles need many ghost
/// cells.
const PER_TILE_ACROSS: usize = 3072;
/// Least number of tiles for cross-cell schemes, so that all threads have tiles of each colour.
const TILES_ACROSS: usize = 25;

impl<P> DsmcEngine<P>
where
    P: ParticleModel,
{
    /// Starts an engine in a periodic box from a state of particles, without tracking
    /// displacements.
    ///
    /// # Errors
    /// As [`EngineSetup::start`].
    pub fn new(
        scene: &P,
        parameters: Parameters,
        state: &State<P>,
        streams: Streams,
    ) -> Result<Self, DsmcError> {
        Self::setup(scene, parameters, streams).start(state)
    }
}

impl<P, F> DsmcEngine<P, F>
where
    P: ParticleModel,
    F: DisplacementTracking<P::Space>,
{
    /// Returns the setup of an engine in a periodic box.
    pub fn setup(scene: &P, parameters: Parameters, streams: Streams) -> EngineSetup<'_, P, F> {
        EngineSetup {
            scene,
            parameters,
            boundaries: Cow::Owned(BoundaryConditions::default()),
            streams,
            tracking: PhantomData,
        }
    }
}

/// Setup of an engine: all that it needs besides its particles.
///
/// ```
/// # use stosszahl_dsmc::{DsmcEngine, Parameters, Scheme, Untracked};
/// # use stosszahl_model::initial::Arrangement;
/// # use stosszahl_model::random::Streams;
/// # use stosszahl_model::samples::{disks, placed_disks, square};
/// # let scene = disks(0.9);
/// # let state = placed_disks(Arrangement::Disordered, 100, square(100, 0.1), 1)?;
/// let parameters = Parameters::for_scheme(Scheme::Boltzmann);
/// let setup = DsmcEngine::<_, Untracked>::setup(&scene, parameters, Streams::new(1, 0));
/// let engine = setup.start(&state)?;
/// # assert_eq!(engine.simulators() % state.bodies.len(), 0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct EngineSetup<'a, P: ParticleModel, F: DisplacementTracking<P::Space>> {
    scene: &'a P,
    parameters: Parameters,
    boundaries: Cow<'a, BoundaryConditions<P::Space>>,
    streams: Streams,
    tracking: PhantomData<F>,
}

impl<'a, P, F> EngineSetup<'a, P, F>
where
    P: ParticleModel,
    F: DisplacementTracking<P::Space>,
{
    /// Sets the boundary conditions of the box: walls, open faces, obstacles, and weights of
    /// simulators.
    #[must_use]
    pub fn between(self, boundaries: &'a BoundaryConditions<P::Space>) -> Self {
        let boundaries = Cow::Borrowed(boundaries);
        Self { boundaries, ..self }
    }

    /// Starts the engine from a state of particles.
    ///
    /// With several simulators per particle, the first set has the state's own positions and
    /// velocities, and further sets are made as [`crate::SimulatorStart`] says.
    ///
    /// # Errors
    /// [`DsmcError`] if a parameter or a number of the state has no meaning, or if boundaries are
    /// inconsistent with the box, the scheme or each other.
    pub fn start(&self, state: &State<P>) -> Result<DsmcEngine<P, F>, DsmcError> {
        self.parameters.check_values()?;
        if self.parameters.simulators_per_particle > 1 && !self.boundaries.obstacles.is_empty() {
            return Err(DsmcError::Boundary {
                scheme: self.parameters.scheme.name(),
                what: "several simulators of each particle from one state, and obstacles",
                allowed: "a state for each simulator, as a copy that is moved would go through bodies",
            });
        }
        let (scene, streams) = (self.scene, self.streams);
        let simulators =
            replicate_start::simulators::<P, F>(scene, &self.parameters, state, streams);
        self.begin(state, simulators, state.bodies.len())
    }

    /// Starts the engine with several simulators per particle from as many independent states.
    /// Needed where a state may not be shifted and rotated, as between walls and in a flow.
    ///
    /// # Errors
    /// As [`Self::start`], and unless there is a state for each simulator of a particle, all with
    /// equal numbers, times and boxes.
    pub fn start_sets(&self, sets: &[State<P>]) -> Result<DsmcEngine<P, F>, DsmcError> {
        self.parameters.check_values()?;
        let wanted = self.parameters.simulators_per_particle as usize;
        let alike = |a: &State<P>, b: &State<P>| {
            a.bodies.len() == b.bodies.len() && a.time == b.time && a.domain == b.domain
        };
        let first = match sets {
            [first, others @ ..]
                if sets.len() == wanted && others.iter().all(|set| alike(first, set)) =>
            {
                first
            }
            _ => {
                return Err(DsmcError::UnequalStarts {
                    found: sets.len(),
                    wanted,
                });
            }
        };
        let simulators = replicate_start::coarse_of_sets::<P, F>(self.scene, sets);
        let checked = simulators.len();
        self.begin(first, simulators, checked)
    }

    /// Starts the engine from simulators in the order of memory. The first `checked` of them must
    /// lie where boundaries allow.
    fn begin(
        &self,
        state: &State<P>,
        simulators: Vec<SimulatorOf<P, F>>,
        checked: usize,
    ) -> Result<DsmcEngine<P, F>, DsmcError> {
        let (domain, count) = (state.domain, simulators.len());
        let checkpoint = DsmcCheckpoint {
            simulators,
            ..self.fresh((state.time, &domain), count)
        };
        let mut engine = self.build(domain, checkpoint, Some(checked))?;
        engine.update_step_bounds();
        Ok(engine)
    }

    /// Creates the engine of a start without its simulators, which
    /// [`take_start`](DsmcEngine::take_start) adds.
    ///
    /// # Errors
    /// As [`Self::start_sets`]; [`DsmcError::BadWeights`] unless weights are uniform.
    pub(crate) fn before_start(
        &self,
        start: &dyn StartStream,
        domain: Domain<P::Space>,
    ) -> Result<DsmcEngine<P, F>, DsmcError> {
        self.parameters.check_values()?;
        let (found, wanted) = (
            start.sets(),
            self.parameters.simulators_per_particle as usize,
        );
        if found != wanted {
            return Err(DsmcError::UnequalStarts { found, wanted });
        }
        if !self.boundaries.weights.factors().is_empty() {
            return Err(DsmcError::BadWeights {
                found: "weights of regions".into(),
                allowed: "uniform weights, where particles are made one after the other",
            });
        }
        let fresh = self.fresh((0.0, &domain), start.particles() * start.sets());
        self.build(domain, fresh, None)
    }

    /// Resumes the engine from a checkpoint of a run started with an equal setup, cells and tiles,
    /// and continues to the same bytes.
    ///
    /// # Errors
    /// As [`Self::start`].
    pub fn resume(
        &self,
        domain: Domain<P::Space>,
        checkpoint: DsmcCheckpoint<P, F>,
    ) -> Result<DsmcEngine<P, F>, DsmcError> {
        let domain = displaced_images(domain, checkpoint.offset)?;
        self.build(domain, checkpoint, None)
    }

    fn fresh(&self, from: (f64, &Domain<P::Space>), count: usize) -> DsmcCheckpoint<P, F> {
        fresh(self.scene, &self.parameters, from, count, &self.boundaries)
    }

    /// Builds the engine from a checkpoint. `fresh`: for a start, the number of particles in its
    /// state.
    fn build(
        &self,
        domain: Domain<P::Space>,
        checkpoint: DsmcCheckpoint<P, F>,
        fresh: Option<usize>,
    ) -> Result<DsmcEngine<P, F>, DsmcError> {
        let (parameters, streams) = (self.parameters, self.streams);
        check_choices(self.scene, parameters, &domain, &self.boundaries)?;
        let copies = parameters.simulators_per_particle as usize;
        let scene = self
            .scene
            .with_sizes(self.scene.sizes().repeat_sizes(copies));
        let DsmcCheckpoint {
            time,
            mut simulators,
            stock,
            unit,
            tally,
            arm,
            mut ledgers,
            means,
            factors,
            offset: _,
        } = checkpoint;
        let boundaries = &self.boundaries.with_factors(&factors);
        check_numbers::<P, F>(&scene, &simulators)?;
        let (weight, sizes) = (1.0 / copies as f64, scene.sizes());
        let averages = means.averages();
        let [mean_diameter, _, mean_mass, ball] = averages;
        let volume = boundaries.free_volume(&domain, 0.5 * mean_diameter);
        // An inflow may be denser than the gas.
        let packing_fraction = means
            .packing_fraction(weight / volume)
            .max(boundaries.densest(scene.sizes()));
        let radius = parameters.partner_radius::<P::Space>(packing_fraction, mean_diameter);
        let grid = create_grid(
            &parameters,
            domain,
            parameters.cells(&domain, packing_fraction, mean_diameter),
            means.expected(packing_fraction * volume / weight),
            [2.0 * sizes.largest_radius(), radius],
        );
        let means_of_all = [0.5 * mean_diameter, mean_mass];
        let surroundings = GridBoundaries::new(&scene, boundaries, &grid, means_of_all, time)?;
        let gas = DensityInput {
            limit: parameters.max_contact_value,
            counts: grid.counts(),
            cell: grid.cell_volume(),
            width: grid.narrowest(),
            diameter: mean_diameter,
            simulators_per_particle: copies as f64,
            unit: weight * P::Space::particle_volume(sizes.largest_radius()),
            packing_fraction,
            bounded: [0, 1, 2].map(|axis| !domain.is_periodic(axis)),
            is_plain: sizes.are_equal() && surroundings.is_none(),
        };
        let mut density = Density::new(parameters.scheme, &gas);
        if let Some(surroundings) = &surroundings {
            leave_room(surroundings, &grid, &mut density)?;
            let entry = Entry {
                scene: &scene,
                surroundings,
                grid: &grid,
                streams,
                weight,
                time,
            };
            simulators = entry.place::<F>(simulators, fresh, &mut ledgers)?;
        }
        let mut engine = DsmcEngine {
            rates: (parameters.scheme.partners() == PartnerSelection::AroundContact)
                .then(|| Rates::new(&density, &gas, ball, means.spread::<P>(sizes), radius)),
            density,
            arm,
            constants: constants::<P::Space>(&parameters, packing_fraction, weight, averages),
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
            halo_copies: Pool::default(),
            held_step: None,
            counts_cells: false,
            time,
            stock,
            unit,
            tally,
            ledgers,
            surroundings,
            means,
            stop: Interruption::default(),
            pause: None,
            share: None,
        };
        engine.fill(&simulators);
        Ok(engine)
    }
}

/// Computes the constants of a gas from its parameters, packing fraction, weight of a simulator, and
/// averages over its particles: diameter, ratio of moments, mass and volume.
fn constants<S: Space>(
    parameters: &Parameters,
    packing_fraction: f64,
    weight: f64,
    [mean_diameter, moment_ratio, mean_mass, _]: [f64; 4],
) -> Constants {
    Constants {
        packing_fraction,
        weight,
        mean_free_path: parameters.mean_free_path::<S>(packing_fraction, mean_diameter),
        moment_ratio,
        partner_radius: parameters.partner_radius::<S>(packing_fraction, mean_diameter),
        mean_radius: 0.5 * mean_diameter,
        mean_mass,
    }
}

impl<P, F> DsmcEngine<P, F>
where
    P: ParticleModel,
    F: DisplacementTracking<P::Space>,
{
    /// Rebuilds all tiles from a list of simulators; the order of simulators within a cell is kept.
    pub(crate) fn fill(&mut self, simulators: &[SimulatorOf<P, F>]) {
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
            if self.counts_cells {
                tile.counts = vec![CellCount::default(); tile.cells()];
            }
            if let Some(surroundings) = &self.surroundings {
                tile.is_even = surroundings.is_even(&self.grid, &tile.place);
                tile.split_cells = (0..tile.cells())
                    .filter(|&cell| surroundings.split_cell(tile.cell_at(cell)).is_some())
                    .collect();
                let [inflows, obstacles] = surroundings.numbers();
                tile.ledgers = Some(Box::new(Ledgers::with_counts(inflows, obstacles)));
            }
            self.tiles.push(tile);
        }
        let boxes = || {
            (0..self.tiles.len())
                .map(|_| SendBuffer::default())
                .collect()
        };
        (self.departing, self.arriving) = (boxes(), boxes());
        self.pool = Pool::default();
        self.halo_copies = Pool::default();
    }
}

/// Returns the state of a gas at its start, at a time in a box, without its `count` simulators.
pub(crate) fn fresh<P: ParticleModel, F: DisplacementTracking<P::Space>>(
    scene: &P,
    parameters: &Parameters,
    (time, domain): (f64, &Domain<P::Space>),
    count: usize,
    boundaries: &BoundaryConditions<P::Space>,
) -> DsmcCheckpoint<P, F> {
    let copies = parameters.simulators_per_particle as usize;
    let sizes = scene.sizes().repeat_sizes(copies);
    DsmcCheckpoint {
        time,
        offset: (domain.images().shear()).map_or(0.0, |shear| shear.offset),
        simulators: Vec::new(),
        stock: StepBounds::default(),
        unit: EnergyUnit::for_total(0.0),
        tally: CollisionCounters::default(),
        arm: ContactDistance::default(),
        ledgers: Ledgers::default(),
        means: Means::over_simulators::<P>(&sizes, count, &boundaries.inflows),
        factors: Vec::new(),
    }
}

/// Placement of initial simulators in a box with walls and obstacles.
struct Entry<'a, P: ParticleModel> {
    scene: &'a P,
    surroundings: &'a GridBoundaries<P>,
    grid: &'a Grid<P::Space>,
    streams: Streams,
    weight: f64,
    time: f64,
}

impl<P: ParticleModel> Entry<'_, P> {
    /// Places initial simulators between walls and obstacles: the first `fresh` must lie where
    /// boundaries allow, further sets are reflected at walls, and each becomes as many copies as
    /// its weight requires. With `fresh` `None`, simulators keep their number.
    fn place<F: DisplacementTracking<P::Space>>(
        &self,
        simulators: Vec<SimulatorOf<P, F>>,
        fresh: Option<usize>,
        ledgers: &mut Ledgers<P::Space>,
    ) -> Result<Vec<SimulatorOf<P, F>>, DsmcError> {
        let surroundings = self.surroundings;
        let [inflows, obstacles] = surroundings.numbers();
        ledgers.inflows.resize(inflows, Transfer::default());
        ledgers.obstacles.resize(obstacles, WallLedger::default());
        let least = surroundings.least_factor();
        if simulators.len() as f64 > MOST_SIMULATORS * least {
            return Err(DsmcError::BadWeights {
                found: format!("a factor of {least} for {} simulators", simulators.len()),
                allowed: "at most 2^30 simulators after it",
            });
        }
        let volume = self.grid.domain().volume();
        for (number, source) in surroundings.sources().iter().enumerate() {
            source.check_number(number, volume, self.weight * least)?;
        }
        let mut placed = Vec::with_capacity(simulators.len());
        for (index, mut simulator) in simulators.into_iter().enumerate() {
            if fresh.is_some_and(|first| index < first) {
                surroundings.check_place::<F>(self.scene, index, &simulator, self.time)?;
            }
            let radius = self.scene.sizes().radius(simulator.tag);
            surroundings.fold(&mut simulator.position, radius);
            let cell = self.grid.cell_at(simulator.position);
            let factor = surroundings.factor(self.grid.number(cell));
            let copies = if fresh.is_some() && factor != 1.0 {
                let mut stream = self
                    .streams
                    .stream_at(Purpose::Balance, [u64::MAX, index as u64]);
                ledgers.balanced += 1;
                let copies = draw_whole(1.0 / factor, &mut stream);
                let more = self.weight * (copies as f64 * factor - 1.0);
                enter::<P, F>(self.scene, &simulator, more, &mut ledgers.balance);
                copies
            } else {
                1
            };
            placed.extend((0..copies).map(|_| simulator));
        }
        Ok(placed)
    }
}

/// Creates the grid of cells and tiles of a run, for a contact distance `diameter` and a `radius`
/// of the partner search \[length\].
fn create_grid<S: Space>(
    parameters: &Parameters,
    domain: Domain<S>,
    counts: [usize; 3],
    simulators: usize,
    [diameter, radius]: [f64; 2],
) -> Grid<S> {
    let widest = (0..S::DIMENSION)
        .map(|axis| domain.lengths()[axis] / counts[axis] as f64)
        .fold(0.0, f64::max);
    let reach = cross_cell::reach(parameters.scheme, diameter, radius, widest);
    let per_tile = if reach > 0.0 {
        (simulators / TILES_ACROSS).clamp(PER_TILE_ACROSS / 12, PER_TILE_ACROSS)
    } else {
        PER_TILE
    };
    Grid::new(domain, counts, simulators, per_tile, reach)
}

/// Sets the free volume of cells next to walls and obstacles in the local density.
fn leave_room<P: ParticleModel>(
    surroundings: &GridBoundaries<P>,
    grid: &Grid<P::Space>,
    density: &mut Density<P::Space>,
) -> Result<(), DsmcError> {
    surroundings.cut_windows(grid, density);
    surroundings.leave_room(density);
    require_room(surroundings, density.scheme())
}

/// Refuses two walls so close to each other that the collision rate of a cross-cell scheme would be
/// wrong by an unknown amount.
pub(crate) fn require_room<P: ParticleModel>(
    surroundings: &GridBoundaries<P>,
    scheme: Scheme,
) -> Result<(), DsmcError> {
    /// Least distance between two walls for a cross-cell scheme \[mean diameters\].
    const LEAST: f64 = 3.0;
    let mut axes = (0..P::Space::DIMENSION).map(|axis| (axis, surroundings.width(axis)));
    match axes.find(|(_, width)| *width < LEAST) {
        Some((axis, width)) if scheme.partners() == PartnerSelection::AroundContact => {
            let scheme = scheme.name();
            Err(DsmcError::Narrow {
                axis,
                scheme,
                width,
            })
        }
        _ => Ok(()),
    }
}

/// Checks that numerical parameters, boundary conditions and particle sizes are consistent.
pub(crate) fn check_choices<P: ParticleModel>(
    scene: &P,
    parameters: Parameters,
    domain: &Domain<P::Space>,
    boundaries: &BoundaryConditions<P::Space>,
) -> Result<(), DsmcError> {
    parameters.check_values()?;
    boundaries.check_domain(domain, parameters)?;
    if P::Sizes::INDIVIDUAL && boundaries.is_open() {
        return Err(DsmcError::Individuals);
    }
    let is_sheared = scene.field().shear_rate() != 0.0;
    if is_sheared && parameters.displacement != PartnerDisplacement::None {
        let scheme = parameters.scheme.name();
        return Err(DsmcError::Displaced { scheme });
    }
    check_displacement(scene, parameters, domain)
}

/// Returns the box with its periodic images above and below displaced by `offset` \[length\], in a
/// shear flow.
fn displaced_images<S: Space>(domain: Domain<S>, offset: f64) -> Result<Domain<S>, DsmcError> {
    let shear = domain.images().shear();
    Ok(domain.sheared(shear.map(|shear| Shear { offset, ..shear }))?)
}

/// Refuses displacements of partners longer than the box; near restitution 0 they are not finite.
fn check_displacement<P: ParticleModel>(
    scene: &P,
    parameters: Parameters,
    domain: &Domain<P::Space>,
) -> Result<(), DsmcError> {
    if parameters.displacement != PartnerDisplacement::Inelastic {
        return Ok(());
    }
    let restitution = scene.restitution().normal_restitution(1.0);
    if restitution <= 0.0 {
        return Err(DsmcError::NoDisplacement);
    }
    let side = (0..P::Space::DIMENSION)
        .map(|axis| domain.lengths()[axis])
        .fold(f64::MAX, f64::min);
    let diameter = 2.0 * scene.sizes().largest_radius();
    let displacement = diameter * 0.5 * (1.0 + restitution) / restitution;
    if displacement <= side.max(diameter) {
        Ok(())
    } else {
        Err(DsmcError::FarDisplacement {
            restitution,
            displacement,
            side,
        })
    }
}

fn check_numbers<P: ParticleModel, F: DisplacementTracking<P::Space>>(
    scene: &P,
    simulators: &[SimulatorOf<P, F>],
) -> Result<(), DsmcError> {
    let mut all = simulators.iter().enumerate();
    all.try_for_each(|(index, simulator)| check_number::<P, F>(scene, index, simulator))
}

/// Refuses a simulator with numbers that cannot be squared.
pub(crate) fn check_number<P: ParticleModel, F: DisplacementTracking<P::Space>>(
    scene: &P,
    index: usize,
    simulator: &SimulatorOf<P, F>,
) -> Result<(), DsmcError> {
    let dimension = P::Space::DIMENSION;
    // Square of the spin of a particle of unit radius and mass, or zero.
    let turning = scene.surface().spin_energy(1.0, 1.0, simulator.spin);
    if is_good(dimension, simulator.position)
        && is_good(dimension, simulator.velocity)
        && turning.is_finite()
    {
        return Ok(());
    }
    let list = |vector: VectorOf<P>| (0..dimension).map(|axis| vector[axis]).collect();
    Err(DsmcError::BadNumber {
        simulator: index,
        position: list(simulator.position),
        velocity: list(simulator.velocity),
    })
}
