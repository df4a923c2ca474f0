//! How an engine starts, stops and goes on.

use serde::{Deserialize, Serialize};
use stosszahl_model::random::Streams;
use stosszahl_model::{Domain, Physics, Restitution, Sizes, Space, State, Surface, VectorOf};

use crate::across::{self, Arm, Rates};
use crate::boundary::{Books, Boundaries};
use crate::copies;
use crate::density::{Density, Gas};
use crate::engine::{Constants, Engine};
use crate::grid::Grid;
use crate::parameters::{Displacement, EngineError, Parameters};
use crate::simulator::{Follow, SimulatorOf, Unfollowed, is_good};
use crate::sweep::Pool;
use crate::tally::{Stock, Tally, Unit};
use crate::tile::{Outbox, Tile};

/// Simulators that a tile is to hold: with its working copy it fits the second cache, 2 MB here; the larger a tile,
/// the fewer leave it.
const PER_TILE: usize = 8192;

/// The same for partners across cells: there the spread of velocities around a tile bounds how fast partners approach, and a
/// wide tile holds many flows.
const PER_TILE_ACROSS: usize = 256;

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
    books: Books<P::Space>,
}

impl<P> Engine<P>
where
    P: Physics,
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
    P: Physics,
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
        Self::start_between(scene, parameters, state, &Boundaries::default(), streams)
    }

    /// [`Engine::start`] in a box whose faces are as told.
    ///
    /// # Errors
    /// As [`Engine::start`], and if boundaries do not fit the box, the scheme or each other.
    pub fn start_between(
        scene: &P,
        parameters: Parameters,
        state: &State<P>,
        boundaries: &Boundaries<P::Space>,
        streams: Streams,
    ) -> Result<Self, EngineError> {
        parameters.check()?;
        let simulators = copies::simulators::<P, F>(scene, &parameters, state, streams);
        let checkpoint = Checkpoint {
            time: state.time,
            simulators,
            stock: Stock::default(),
            unit: Unit::of(0.0),
            tally: Tally::default(),
            arm: Arm::default(),
            books: Books::default(),
        };
        let domain = state.domain;
        let mut engine =
            Self::resume_between(scene, parameters, domain, checkpoint, boundaries, streams)?;
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
        let boundaries = Boundaries::default();
        Self::resume_between(scene, parameters, domain, checkpoint, &boundaries, streams)
    }

    /// [`Engine::resume`] in a box whose faces are as told.
    ///
    /// # Errors
    /// As [`Engine::start_between`].
    pub fn resume_between(
        scene: &P,
        parameters: Parameters,
        domain: Domain<P::Space>,
        checkpoint: Checkpoint<P, F>,
        boundaries: &Boundaries<P::Space>,
        streams: Streams,
    ) -> Result<Self, EngineError> {
        parameters.check()?;
        boundaries.check(&domain, parameters.scheme)?;
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
            books,
        } = checkpoint;
        check_numbers::<P, F>(&scene, &simulators)?;
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
        let grid = grid(
            &parameters,
            domain,
            counts,
            simulators.len(),
            [2.0 * sizes.largest_radius(), radius],
        );
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
            books,
        };
        engine.fill(&simulators);
        Ok(engine)
    }

    /// Distributes simulators among the tiles; those of a cell keep their order.
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
            self.tiles.push(tile);
        }
        let boxes = || (0..self.tiles.len()).map(|_| Outbox::default()).collect();
        (self.departing, self.arriving) = (boxes(), boxes());
        self.pool = Pool::default();
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
            books: self.books.clone(),
        }
    }
}

/// The cells and tiles of a run, for partners at most so far apart: contact distance, and radius around it.
fn grid<S: Space>(
    parameters: &Parameters,
    domain: Domain<S>,
    counts: [usize; 3],
    simulators: usize,
    [diameter, radius]: [f64; 2],
) -> Grid<S> {
    let widest = (0..S::DIMENSION)
        .map(|axis| domain.lengths()[axis] / counts[axis] as f64)
        .fold(0.0, f64::max);
    let reach = across::reach(parameters.scheme, diameter, radius, widest);
    let per_tile = if reach > 0.0 {
        PER_TILE_ACROSS
    } else {
        PER_TILE
    };
    Grid::new(domain, counts, simulators, per_tile, reach)
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

fn check_numbers<P: Physics, F: Follow<P::Space>>(
    scene: &P,
    simulators: &[SimulatorOf<P, F>],
) -> Result<(), EngineError> {
    let dimension = P::Space::DIMENSION;
    let bad = simulators.iter().position(|simulator| {
        // Of a particle with the radius one: the square of its spin, or nothing.
        let turning = scene.surface().spin_energy(1.0, 1.0, simulator.spin);
        !is_good(dimension, simulator.position)
            || !is_good(dimension, simulator.velocity)
            || !turning.is_finite()
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
