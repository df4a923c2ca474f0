//! The engine behind the common interface: chosen at run time, for any grains of the model.

mod among;
mod refusals;
mod tiles;

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};
use stosszahl_model::random::Streams;
use stosszahl_model::sum::Totals;
use stosszahl_model::walls::FACES;
use stosszahl_model::{
    Body, BoundaryFlux, Budget, Failure, GrainSizes, Grains, Interrupt, Invalid, Observer,
    Particle, Particles, Physics, Simulation, Sizes, Smooth, Space, State, Sum, Surface,
    Vector as _, VectorOf, Volume, Work,
};

use crate::boundary::{Boundaries, Transfer};
use crate::engine::Engine;
use crate::parameters::{EngineError, Parameters};
use crate::share::{Beside, Shard, read_all};
use crate::simulator::{Follow, Followed, Unfollowed};
use crate::start::Checkpoint;
use among::Others;

pub use among::{resume_among, serve, simulate_among};
pub use refusals::{ExpectedGas, check};

/// Simulator steps in one leg, and fewest time steps.
const LEG: u64 = 5_000_000;
const LEAST_LEG: u64 = 20;

/// What a gas in cells is made of, besides its start.
#[derive(Clone, Debug)]
pub struct Gas<'a> {
    /// What particles are.
    pub grains: &'a Grains,
    /// The scheme and its resolution.
    pub parameters: Parameters,
    /// What stands at the faces of the box and in it; of disks, the third axis is ignored.
    pub boundaries: &'a Boundaries<Volume>,
    /// Random streams.
    pub streams: Streams,
    /// Whether displacements can be measured; smooth particles in a periodic box only.
    pub displacements: bool,
}

/// Name of the entry of [`Simulation::boundaries`] that splitting and merging of simulators has.
pub const BALANCE: &str = "splitting and merging";

/// Starts Monte Carlo in cells from particles in a box.
///
/// Several simulators for each particle start as [`crate::Copies`] says from one start; or from as many independent starts as
/// there are simulators for a particle, where a start may not be moved and turned.
///
/// # Errors
/// [`EngineError`] if the parts do not go together.
pub fn simulate(gas: &Gas<'_>, starts: &[Particles]) -> Result<Box<dyn Simulation>, EngineError> {
    begin(gas, Source::Start(starts), &Alone)
}

/// What a gas goes on from; all else must be as it was at the start.
#[derive(Clone, Copy, Debug)]
pub struct Left<'a> {
    /// Number of particles at the start.
    pub count: usize,
    /// Sides of the box.
    pub lengths: [f64; 3],
    /// The bytes of [`Simulation::checkpoint`], or of [`Simulation::checkpoint_in_shards`].
    pub checkpoint: &'a [u8],
    /// Where the shards are, if there are some.
    pub beside: Option<&'a Beside>,
}

/// Goes on from a checkpoint.
///
/// # Errors
/// As [`simulate`]; [`EngineError::Checkpoint`] if the bytes are none of this engine, and [`EngineError::Shard`] if a shard cannot be
/// used.
pub fn resume(gas: &Gas<'_>, left: Left<'_>) -> Result<Box<dyn Simulation>, EngineError> {
    begin(gas, Source::Checkpoint(left), &Alone)
}

/// What becomes of an engine.
trait Keep {
    type Kept;
    /// Whether shards stay where they are, for the processes that hold their tiles.
    const SHARES: bool;
    fn keep<P: Physics, F: Follow<P::Space>>(
        &self,
        cells: Cells<P, F>,
        shards: Shards,
    ) -> Self::Kept;
}

/// Shards that nobody has read, and where they are.
type Shards = Option<(Vec<Shard>, Beside)>;

/// It is driven in this process.
struct Alone;

impl Keep for Alone {
    type Kept = Box<dyn Simulation>;
    const SHARES: bool = false;
    fn keep<P: Physics, F: Follow<P::Space>>(&self, cells: Cells<P, F>, _: Shards) -> Self::Kept {
        Box::new(cells)
    }
}

#[derive(Clone, Copy)]
enum Source<'a> {
    Start(&'a [Particles]),
    Checkpoint(Left<'a>),
}

fn begin<K: Keep>(gas: &Gas<'_>, source: Source<'_>, keep: &K) -> Result<K::Kept, EngineError> {
    let (count, dimension) = match source {
        Source::Start([first, ..]) => (first.all.len(), first.dimension),
        Source::Start([]) => {
            return Err(EngineError::UnequalStarts {
                found: 0,
                wanted: 1,
            });
        }
        Source::Checkpoint(left) => (left.count, if left.lengths[2] > 0.0 { 3 } else { 2 }),
    };
    let begin = Begin { gas, source, keep };
    if dimension == 2 {
        let boundaries = gas.boundaries.in_plane();
        match &gas.grains.sizes {
            GrainSizes::Equal(sizes) if gas.grains.is_plain() && !gas.displacements => {
                begin.make::<_, Unfollowed>(&gas.grains.plain(*sizes), &boundaries)
            }
            _ => begin.any(count, &boundaries),
        }
    } else {
        begin.any(count, gas.boundaries)
    }
}

/// Makes an engine of the types of a scene.
struct Begin<'a, K> {
    gas: &'a Gas<'a>,
    source: Source<'a>,
    keep: &'a K,
}

impl<K: Keep> Begin<'_, K> {
    /// Engines of any grains. Rough ones always carry their displacement: an engine less to compile, for a vector more in each.
    fn any<S: Space>(
        &self,
        count: usize,
        boundaries: &Boundaries<S>,
    ) -> Result<K::Kept, EngineError> {
        let grains = self.gas.grains;
        match grains.rough {
            Some(rough) => self.make::<_, Followed>(&grains.scene(rough, count)?, boundaries),
            None if self.gas.displacements => {
                self.make::<_, Followed>(&grains.scene(Smooth, count)?, boundaries)
            }
            None => self.make::<_, Unfollowed>(&grains.scene(Smooth, count)?, boundaries),
        }
    }

    fn make<P: Physics, F: Follow<P::Space>>(
        &self,
        scene: &P,
        boundaries: &Boundaries<P::Space>,
    ) -> Result<K::Kept, EngineError> {
        let Gas {
            parameters,
            streams,
            ..
        } = *self.gas;
        let domain =
            |lengths: [f64; 3]| (boundaries.walls).domain(P::Space::vector(|axis| lengths[axis]));
        let (engine, follows, shards) = match self.source {
            Source::Start(starts) => {
                let state = |start: &Particles| -> Result<State<P>, Invalid> {
                    Ok(State {
                        time: start.time,
                        domain: domain(start.lengths)?,
                        bodies: start.all.iter().map(body::<P>).collect(),
                    })
                };
                let states = starts.iter().map(state).collect::<Result<Vec<_>, _>>()?;
                let engine = match &states[..] {
                    [one] => Engine::start_between(scene, parameters, one, boundaries, streams),
                    all => Engine::start_sets(scene, parameters, all, boundaries, streams),
                };
                (engine?, false, None)
            }
            Source::Checkpoint(left) => {
                let mut kept: Kept<P, F> = postcard::from_bytes(left.checkpoint)
                    .map_err(|error| EngineError::Checkpoint(error.to_string()))?;
                let shards = match left.beside {
                    _ if kept.shards.is_empty() => None,
                    Some(beside) => Some((kept.shards, beside.clone())),
                    None => {
                        let why = "its shards are not where it is";
                        return Err(EngineError::Checkpoint(why.into()));
                    }
                };
                if let Some((list, beside)) = shards.as_ref().filter(|_| !K::SHARES) {
                    kept.gas.hold(read_all::<P, F>(list, beside)?);
                }
                let domain = domain(left.lengths)?;
                let engine = Engine::resume_between(
                    scene, parameters, domain, kept.gas, boundaries, streams,
                );
                (engine?, kept.follows, shards)
            }
        };
        let cells = Cells::<P, F> {
            engine,
            displacements: self.gas.displacements,
            follows,
            others: None,
        };
        Ok(self.keep.keep(cells, shards))
    }
}

fn body<P: Physics>(particle: &Particle) -> Body<P> {
    let vector = |of: Vector3<f64>| P::Space::vector(|axis| of[axis]);
    Body {
        position: vector(particle.position),
        velocity: vector(particle.velocity),
        spin: <P::Surface as Surface<P::Space>>::spin_of(particle.spin),
    }
}

/// What is written into a checkpoint.
#[derive(Serialize, Deserialize)]
#[serde(bound = "")]
struct Kept<P: Physics, F: Follow<P::Space>> {
    gas: Checkpoint<P, F>,
    follows: bool,
    /// Where the simulators are, if they are not in the gas.
    shards: Vec<Shard>,
}

/// Monte Carlo in cells behind [`Simulation`].
struct Cells<P: Physics, F: Follow<P::Space>> {
    engine: Engine<P, F>,
    /// Whether displacements can be followed, and are.
    displacements: bool,
    follows: bool,
    /// Other processes that hold parts of the gas, and are to be told what is done with it.
    others: Option<Others>,
}

impl<P: Physics, F: Follow<P::Space>> Cells<P, F> {
    /// [`Engine::advance`] of all processes.
    fn go(&mut self, until: f64, steps: u64, observer: &mut dyn Observer) -> bool {
        if let Some(others) = &self.others {
            others.advance(until, steps, observer.looks());
        }
        self.engine.advance(until, steps, observer)
    }

    /// Squared displacements of the simulators that this process holds, tile by tile.
    fn squared_ways(&self) -> Totals {
        let mut squares = Totals::new(1);
        for tile in self.engine.tiles_here() {
            self.engine.each_in(tile, |simulator, _| {
                squares.open()[0] += F::way(simulator.mark).square();
            });
            squares.close();
        }
        squares
    }

    /// Such sums of all simulators over their number.
    fn mean_of(&self, squares: &Totals) -> Option<f64> {
        let sum: f64 = squares.values().iter().sum();
        (self.count() > 0).then(|| sum / self.count() as f64)
    }

    fn particle(&self, simulator: &crate::simulator::SimulatorOf<P, F>, weight: f64) -> Particle {
        let scene = self.engine.scene();
        let sizes = scene.sizes();
        let (radius, mass) = (sizes.radius(simulator.tag), sizes.mass(simulator.tag));
        Particle {
            position: simulator.position.spatial(),
            velocity: simulator.velocity.spatial(),
            spin: <P::Surface as Surface<P::Space>>::spin_in_space(simulator.spin),
            radius,
            mass,
            spin_energy: scene.surface().spin_energy(mass, radius, simulator.spin),
            species: sizes.kind(simulator.tag),
            weight,
        }
    }
}

impl<P: Physics, F: Follow<P::Space>> Simulation for Cells<P, F> {
    fn time(&self) -> f64 {
        self.engine.time()
    }

    fn dimension(&self) -> usize {
        P::Space::DIMENSION
    }

    fn count(&self) -> usize {
        self.engine.simulators()
    }

    fn weight(&self) -> f64 {
        self.engine.weight()
    }

    fn advance(
        &mut self,
        until: f64,
        budget: Budget,
        observer: &mut dyn Observer,
    ) -> Result<bool, Failure> {
        Ok(match budget {
            Budget::Unlimited => self.go(until, u64::MAX, observer),
            Budget::Leg => {
                let steps = LEG / self.count().max(1) as u64;
                self.go(until, steps.max(LEAST_LEG), observer)
            }
            Budget::Collisions(most) => {
                let last = self.engine.tally().collisions.saturating_add(most);
                while self.engine.tally().collisions < last {
                    if self.go(until, 1, observer) {
                        return Ok(true);
                    }
                    if self.engine.is_interrupted() {
                        return Ok(false);
                    }
                }
                until <= self.time()
            }
        })
    }

    fn stop_on(&mut self, interrupt: &Interrupt) {
        self.engine.stop_on(interrupt);
    }

    fn pause_on(&mut self, pause: &Interrupt) {
        self.engine.pause_on(pause);
    }

    fn is_interrupted(&self) -> bool {
        self.engine.is_interrupted()
    }

    fn visit(&self, look: &mut dyn FnMut(&Particle)) {
        self.engine
            .each(|simulator, weight| look(&self.particle(simulator, weight)));
    }

    fn add_up(&self, sum: &mut dyn Sum) {
        for tile in self.engine.tiles_here() {
            (self.engine).each_in(tile, |simulator, weight| {
                sum.add(&self.particle(simulator, weight));
            });
            sum.close(tile as u32);
        }
    }

    fn add_up_near(&self, _reach: f64, sum: &mut dyn Sum) {
        self.visit(&mut |particle| sum.add(particle));
        sum.close(0);
    }

    fn particles(&self) -> Particles {
        let domain = self.engine.grid().domain();
        let mut all = vec![Particle::of(0.0, 0.0); self.count()];
        self.engine.each_in_place(|index, simulator, weight| {
            all[index] = self.particle(simulator, weight);
        });
        Particles {
            time: self.time(),
            dimension: P::Space::DIMENSION,
            lengths: domain.lengths().spatial().into(),
            periodic: [0, 1, 2].map(|axis| domain.is_periodic(axis)),
            all,
        }
    }

    fn kick(&mut self, changes: &[Vector3<f64>]) -> Result<(), Failure> {
        let flat = |change: &Vector3<f64>| P::Space::vector(|axis| change[axis]);
        let changes: Vec<VectorOf<P>> = changes.iter().map(flat).collect();
        self.engine.kick(&changes);
        Ok(())
    }

    fn scale_velocities(&mut self, factor: f64) -> Result<(), Failure> {
        Invalid::unless_positive("factor of all velocities", factor).map_err(Failure::new)?;
        self.engine.scale_velocities(factor);
        Ok(())
    }

    fn checkpoint(&self) -> Result<Vec<u8>, Failure> {
        let kept = Kept {
            gas: self.engine.checkpoint(),
            follows: self.follows,
            shards: Vec::new(),
        };
        postcard::to_stdvec(&kept).map_err(Failure::new)
    }

    fn work(&self) -> Work {
        let tally = self.engine.tally();
        let over = |a: f64, b: u64| a / b.max(1) as f64;
        let simulators = self.engine.simulators() as u64;
        let numbers = [
            ("steps", tally.steps as f64),
            ("simulators", simulators as f64),
            (
                "trials_per_collision",
                over(tally.trials as f64, tally.collisions),
            ),
            (
                "majorant_violations_per_trial",
                over(tally.majorant_violations as f64, tally.trials),
            ),
            (
                "collisions_per_simulator_and_step",
                over(2.0 * tally.collisions as f64, tally.steps * simulators),
            ),
            (
                "share_of_cells_with_limited_contact_value",
                over(tally.limited_cells as f64, tally.active_cells),
            ),
            (
                "share_of_collisions_in_limited_cells",
                over(tally.limited_collisions as f64, tally.collisions),
            ),
            (
                "collision_separation",
                over(tally.separation, tally.collisions),
            ),
            (
                "most_collisions_per_simulator_in_a_cell_and_step",
                tally.busiest_cell,
            ),
            ("cell_width", self.engine.cell()[0]),
            (
                "particles_laid_to_rest_on_walls",
                self.engine.ledgers().rests as f64,
            ),
        ];
        Work {
            collisions: tally.collisions,
            numbers: numbers
                .map(|(name, number)| (name.to_owned(), number))
                .into(),
        }
    }

    fn bytes(&self) -> usize {
        self.engine.bytes()
    }

    fn follow_displacements(&mut self) -> bool {
        if self.displacements {
            self.engine.follow_displacements();
            self.follows = true;
        }
        self.displacements
    }

    fn displacements(&self) -> Option<Vec<Vector3<f64>>> {
        let all = self.follows.then(|| self.engine.displacements())?;
        Some(all.iter().map(stosszahl_model::Vector::spatial).collect())
    }

    fn mean_squared_displacement(&self) -> Option<f64> {
        let squares = self.follows.then(|| self.squared_ways())?;
        self.mean_of(&squares)
    }

    fn boundaries(&self) -> Vec<BoundaryFlux> {
        let ledgers = self.engine.ledgers();
        let mut entries = Vec::new();
        for (axis, names) in FACES.iter().enumerate() {
            for (side, name) in names.iter().enumerate() {
                let wall = &ledgers.walls[axis][side];
                if wall.contacts > 0.0 {
                    entries.push(BoundaryFlux::of_ledger(*name, wall));
                }
                let open = &ledgers.open[axis][side];
                if open.particles != 0.0 {
                    entries.push(of_transfer(format!("out through {name}"), open));
                }
            }
        }
        for (index, obstacle) in ledgers.obstacles.iter().enumerate() {
            let name = format!("obstacle {}", index + 1);
            entries.push(BoundaryFlux::of_ledger(name, obstacle));
        }
        for (index, inflow) in ledgers.inflows.iter().enumerate() {
            entries.push(of_transfer(format!("inflow {}", index + 1), inflow));
        }
        if ledgers.balanced > 0 {
            entries.push(of_transfer(BALANCE.to_owned(), &ledgers.balance));
        }
        entries
    }
}

fn of_transfer<S: Space>(name: String, transfer: &Transfer<S>) -> BoundaryFlux {
    BoundaryFlux {
        name,
        particles: transfer.particles,
        momentum: transfer.momentum.spatial().into(),
        energy: transfer.energy,
    }
}
