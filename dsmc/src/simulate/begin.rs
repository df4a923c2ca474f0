//! Start and resumption of DSMC gases in cells: selects the engine type for dimension, sizes,
//! roughness and displacements.

use nalgebra::Vector3;
use stosszahl_model::random::Streams;
use stosszahl_model::{
    Domain, InvalidValue, Particle, ParticleModel, ParticleSpec, ParticleState, Particles,
    Simulation, SizeDistribution, Smooth, Space, State, Surface, Volume,
};

use super::cells::{CellSimulation, CheckpointContent};
use super::field::scene_of;
use crate::boundary::BoundaryConditions;
use crate::decomposition::{Shard, ShardLocation, read_all};
use crate::engine::DsmcEngine;
use crate::parameters::{DsmcError, Parameters};
use crate::particle::{DisplacementTracking, Tracked, Untracked};
use crate::start_stream::StartStream;

/// Settings of a DSMC gas in cells: particles, numerical parameters and boundaries; everything but
/// its initial state.
#[derive(Clone, Debug)]
pub struct CellGas<'a> {
    /// Sizes, masses and collision law of the particles.
    pub grains: &'a ParticleSpec,
    /// Collision scheme and numerical parameters.
    pub parameters: Parameters,
    /// Boundary conditions of the box; in two dimensions the third axis is ignored.
    pub boundaries: &'a BoundaryConditions<Volume>,
    /// Random streams of the run, by seed and replica.
    pub streams: Streams,
    /// True if displacements shall be measured; for smooth particles in a periodic box only.
    pub displacements: bool,
}

/// Starts a DSMC gas from particles in a box, as a [`Simulation`].
///
/// Several simulators per particle start from one state as [`crate::SimulatorStart`] says, or from
/// as many independent states, where a state may not be shifted and rotated.
///
/// # Errors
/// [`DsmcError`] if the arguments are inconsistent; [`DsmcError::NoSpheres`] and
/// [`DsmcError::NoRough`] without the features `spheres` and `rough`.
pub fn simulate(gas: &CellGas<'_>, starts: &[Particles]) -> Result<Box<dyn Simulation>, DsmcError> {
    begin(gas, StartSource::Start(starts), &Alone)
}

/// Starts cell-based Monte Carlo from particles that are made one after the other.
///
/// # Errors
/// As [`simulate`]; [`DsmcError::Start`] if a particle cannot be made.
pub fn simulate_stream(
    gas: &CellGas<'_>,
    start: &dyn StartStream,
) -> Result<Box<dyn Simulation>, DsmcError> {
    begin(gas, StartSource::Stream(start), &Alone)
}

/// Checkpoint from which a gas resumes, with the particle number and box of its start.
#[derive(Clone, Copy, Debug)]
pub struct CheckpointSource<'a> {
    /// Number of particles at the start.
    pub count: usize,
    /// Sides of the box \[length\]; the third is 0 for disks.
    pub lengths: [f64; 3],
    /// Bytes of the checkpoint, by [`Simulation::save_checkpoint`] or
    /// [`Simulation::checkpoint_in_shards`].
    pub checkpoint: &'a [u8],
    /// Location of the checkpoint's shards; `None` for a checkpoint without shards.
    pub beside: Option<&'a ShardLocation>,
}

/// Resumes a DSMC gas from a checkpoint, as a [`Simulation`].
///
/// # Errors
/// As [`simulate`]; [`DsmcError::Checkpoint`] if the bytes are not of this engine, and
/// [`DsmcError::Shard`] if a shard cannot be used.
pub fn resume(
    gas: &CellGas<'_>,
    left: CheckpointSource<'_>,
) -> Result<Box<dyn Simulation>, DsmcError> {
    begin(gas, StartSource::Checkpoint(left), &Alone)
}

/// Destination of a new engine: this process alone, or one of several processes.
pub(super) trait Keep<'a> {
    type Kept;
    /// True if simulators in shards or of a stream are left to the processes that own their tiles.
    const SHARES: bool;
    fn keep_engine<P: ParticleModel, F: DisplacementTracking<P::Space>>(
        &self,
        cells: CellSimulation<P, F>,
        pending: Pending<'a>,
    ) -> Result<Self::Kept, DsmcError>;
}

/// Simulators that a new engine does not have yet.
pub(super) enum Pending<'a> {
    /// None: the engine has all.
    None,
    /// Unread shards and their location.
    Shards(Vec<Shard>, ShardLocation),
    /// Start that is not made yet.
    Start(&'a dyn StartStream),
}

/// Factory of a gas that this process holds and drives alone.
struct Alone;

impl Keep<'_> for Alone {
    type Kept = Box<dyn Simulation>;
    const SHARES: bool = false;
    fn keep_engine<P: ParticleModel, F: DisplacementTracking<P::Space>>(
        &self,
        mut cells: CellSimulation<P, F>,
        pending: Pending<'_>,
    ) -> Result<Self::Kept, DsmcError> {
        if let Pending::Start(start) = pending {
            let room = start.particles() * start.sets();
            cells.engine.simulators = cells.engine.take_start(start, room)?;
            cells.engine.update_step_bounds();
        }
        Ok(Box::new(cells))
    }
}

#[derive(Clone, Copy)]
pub(super) enum StartSource<'a> {
    Start(&'a [Particles]),
    Stream(&'a dyn StartStream),
    Checkpoint(CheckpointSource<'a>),
}

pub(super) fn begin<'a, K: Keep<'a>>(
    gas: &CellGas<'_>,
    source: StartSource<'a>,
    keep: &K,
) -> Result<K::Kept, DsmcError> {
    let (count, dimension) = match source {
        StartSource::Start([first, ..]) => (first.all.len(), first.dimension),
        StartSource::Start([]) => {
            return Err(DsmcError::UnequalStarts {
                found: 0,
                wanted: 1,
            });
        }
        StartSource::Stream(start) => (start.particles(), start.dimension()),
        StartSource::Checkpoint(left) => (left.count, if left.lengths[2] > 0.0 { 3 } else { 2 }),
    };
    let begin = Begin { gas, source, keep };
    if dimension == 2 {
        let boundaries = gas.boundaries.in_plane();
        match &gas.grains.sizes {
            SizeDistribution::Equal(sizes) if gas.grains.is_plain() && !gas.displacements => {
                begin.make::<_, Untracked>(&gas.grains.plain(*sizes), &boundaries)
            }
            _ => begin.any(count, &boundaries),
        }
    } else if cfg!(feature = "spheres") {
        begin.any(count, gas.boundaries)
    } else {
        Err(DsmcError::NoSpheres)
    }
}

/// Constructor of an engine whose types depend on the gas.
struct Begin<'g, 'a, K> {
    gas: &'g CellGas<'g>,
    source: StartSource<'a>,
    keep: &'g K,
}

impl<'a, K: Keep<'a>> Begin<'_, 'a, K> {
    /// Makes an engine of any particles. Rough ones always carry displacements: one vector more
    /// each, but one engine type less to compile. Smooth ones do without the feature `untracked`;
    /// collisions are the same.
    fn any<S: Space>(
        &self,
        count: usize,
        boundaries: &BoundaryConditions<S>,
    ) -> Result<K::Kept, DsmcError> {
        let grains = self.gas.grains;
        match grains.rough {
            Some(rough) if cfg!(feature = "rough") => {
                self.make::<_, Tracked>(&scene_of(grains, rough, count)?, boundaries)
            }
            Some(_) => Err(DsmcError::NoRough),
            None if self.gas.displacements || !cfg!(feature = "untracked") => {
                self.make::<_, Tracked>(&scene_of(grains, Smooth, count)?, boundaries)
            }
            None => self.make::<_, Untracked>(&scene_of(grains, Smooth, count)?, boundaries),
        }
    }

    fn make<P: ParticleModel, F: DisplacementTracking<P::Space>>(
        &self,
        scene: &P,
        boundaries: &BoundaryConditions<P::Space>,
    ) -> Result<K::Kept, DsmcError> {
        let CellGas {
            parameters,
            streams,
            ..
        } = *self.gas;
        let shear = self.gas.grains.shear();
        let domain = |lengths: [f64; 3], time: f64| -> Result<Domain<P::Space>, InvalidValue> {
            let lengths = P::Space::from_components(|axis| lengths[axis]);
            (boundaries.walls).domain(lengths)?.in_flow(shear, time)
        };
        let setup = DsmcEngine::<P, F>::setup(scene, parameters, streams).between(boundaries);
        let (engine, follows, pending) = match self.source {
            StartSource::Start(starts) => {
                let state = |start: &Particles| -> Result<State<P>, InvalidValue> {
                    Ok(State {
                        time: start.time,
                        domain: domain(start.lengths, start.time)?,
                        bodies: start.all.iter().map(body::<P>).collect(),
                    })
                };
                let states = starts.iter().map(state).collect::<Result<Vec<_>, _>>()?;
                let engine = match &states[..] {
                    [one] => setup.start(one)?,
                    all => setup.start_sets(all)?,
                };
                (engine, false, Pending::None)
            }
            StartSource::Stream(start) => {
                let domain = domain(start.lengths(), 0.0)?;
                let engine = setup.before_start(start, domain)?;
                (engine, false, Pending::Start(start))
            }
            StartSource::Checkpoint(left) => {
                let mut kept: CheckpointContent<P, F> = postcard::from_bytes(left.checkpoint)
                    .map_err(|error| DsmcError::Checkpoint(error.to_string()))?;
                let pending = match left.beside {
                    _ if kept.shards.is_empty() => Pending::None,
                    Some(beside) if K::SHARES => Pending::Shards(kept.shards, beside.clone()),
                    Some(beside) => {
                        kept.gas.hold(read_all::<P, F>(&kept.shards, beside)?);
                        Pending::None
                    }
                    None => {
                        let why = "its shards are not where it is";
                        return Err(DsmcError::Checkpoint(why.into()));
                    }
                };
                // The checkpoint has the offset of the boxes.
                let domain = domain(left.lengths, 0.0)?;
                let engine = setup.resume(domain, kept.gas)?;
                (engine, kept.follows, pending)
            }
        };
        let cells = CellSimulation::<P, F> {
            engine,
            displacements: self.gas.displacements,
            follows,
            others: None,
        };
        self.keep.keep_engine(cells, pending)
    }
}

fn body<P: ParticleModel>(particle: &Particle) -> ParticleState<P> {
    let vector = |of: Vector3<f64>| P::Space::from_components(|axis| of[axis]);
    ParticleState {
        position: vector(particle.position),
        velocity: vector(particle.velocity),
        spin: <P::Surface as Surface<P::Space>>::spin_of(particle.spin),
    }
}
