//! Common interface of all engines, the trait [`Simulation`], for measurements, programs and other
//! languages.
//!
//! [`Simulation`] is object-safe and knows no type of a scene. Engines are instantiated for their
//! physics inside their own crates and chosen at run time, once for each leg of a run: one virtual
//! call for 10^5 to 10^8 collisions. So crates build side by side, and a new measurement
//! instantiates nothing.

use std::collections::BTreeMap;
use std::error::Error;
use std::fmt;
use std::path::Path;

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

use crate::exact::ExactSum;
use crate::images::{Images, Shear, wrapped};
use crate::interrupt::Interrupt;
use crate::observer::Observer;
use crate::particle::Particle;
use crate::physics::ParticleModel;
use crate::recent_contacts::RecentContacts;
use crate::sizes::Sizes as _;
use crate::snapshot::Fingerprint;
use crate::space::{Space, Vector as _, Volume};
use crate::state::State;
use crate::sum::{DynReduction, ParticleReduction};
use crate::walls::WallLedger;

/// All particles of a gas at one time, with box and dimension: the input of measurements and the
/// initial state of engines.
#[derive(Clone, Debug, PartialEq)]
pub struct Particles {
    /// Time of the gas at which the particles have this state \[time\].
    pub time: f64,
    /// Number of space dimensions, 2 or 3.
    pub dimension: usize,
    /// Sides of the box \[length\]; beyond the dimension, and without positions, zero.
    pub lengths: [f64; 3],
    /// True for each axis along which the box is periodic, and for axes beyond the dimension.
    pub periodic: [bool; 3],
    /// Particles by index; an index means the same particle at all times, unless particles come and
    /// go.
    pub all: Vec<Particle>,
}

impl Particles {
    /// Returns the granular temperature T = <m v^2>/D of the particles \[energy\]; 0 without
    /// particles.
    pub fn temperature(&self) -> f64 {
        self.moments().temperature(self.dimension)
    }

    /// Returns the second and fourth moments of the particles' velocities.
    pub fn moments(&self) -> VelocityMoments {
        let mut moments = VelocityMoments::default();
        for particle in &self.all {
            ParticleReduction::add_particle(&mut moments, particle);
        }
        moments
    }

    /// Returns the map of periodic images of the box, without shear; axes without a length have
    /// none.
    pub fn images(&self) -> Images<Volume> {
        let periodic = [0, 1, 2].map(|axis| self.periodic[axis] && self.lengths[axis] > 0.0);
        Images::new(self.lengths.into(), periodic)
    }

    /// Returns the displacement of the periodic image above along the first axis, from 0 to the
    /// width of the box \[length\], in a uniform shear flow given at time 0. 0 without a flow or
    /// positions.
    pub fn shear_offset(&self, shear: Option<Shear>) -> f64 {
        let [width, height, _] = self.lengths;
        match shear {
            Some(shear) if width > 0.0 => {
                wrapped(shear.offset + shear.rate * height * self.time, width)
            }
            _ => 0.0,
        }
    }

    /// Returns the area or volume of the box \[length^D\].
    pub fn volume(&self) -> f64 {
        self.lengths[..self.dimension].iter().product()
    }
}

/// Second and fourth moments of particle velocities, as exact sums, which do not depend on the
/// order in which particles are added.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct VelocityMoments {
    count: ExactSum,
    second: ExactSum,
    fourth: ExactSum,
}

impl VelocityMoments {
    /// Computes the velocity moments of the particles of a state.
    pub fn of_state<P: ParticleModel>(scene: &P, state: &State<P>) -> Self {
        let (sizes, mut moments) = (scene.sizes(), Self::default());
        for (index, body) in state.bodies.iter().enumerate() {
            moments.add(
                1.0,
                sizes.mass(sizes.tag_of(index)) * body.velocity.square(),
            );
        }
        moments
    }

    /// Adds `weight` particles with `m v^2 = square` \[energy\] to the moments.
    pub fn add(&mut self, weight: f64, square: f64) {
        self.count.add(weight);
        self.second.add(weight * square);
        self.fourth.add(weight * square * square);
    }

    /// Returns the means `<m v^2>` and `<m^2 v^4>`; 0 without particles.
    pub fn means(&self) -> [f64; 2] {
        let count = self.count.value();
        let count = if count > 0.0 { count } else { 1.0 };
        [&self.second, &self.fourth].map(|sum| sum.value() / count)
    }

    /// Returns the granular temperature T = <m v^2>/D \[energy\]; 0 without particles.
    pub fn temperature(&self, dimension: usize) -> f64 {
        self.means()[0] / dimension as f64
    }
}

impl ParticleReduction for VelocityMoments {
    const NAME: &'static str = "moments";

    fn add_particle(&mut self, particle: &Particle) {
        let square = particle.mass * particle.velocity.norm_squared();
        self.add(particle.weight, square);
    }

    fn merge_sum(&mut self, other: Self) {
        self.count.merge(&other.count);
        self.second.merge(&other.second);
        self.fourth.merge(&other.fourth);
    }
}

/// Limit of work of one call of [`Simulation::advance`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Budget {
    /// No limit: the call ends when the time is reached.
    Unlimited,
    /// One leg of a run, the segment between two checkpoints: some seconds of work, counted in
    /// collisions or time steps. A leg is a function of the checkpoint before it, so that a run
    /// stopped between two legs resumes to the same bytes.
    Leg,
    /// Largest number of pair collisions; Monte Carlo in cells stops at the end of the time step in
    /// which it is reached.
    Collisions(u64),
}

/// Number of collisions between two checks of [`Simulation::set_pause_flag`], in engines that go
/// from collision to collision.
const BETWEEN_PAUSES: u64 = 50_000;

/// Advances by a budget of collisions at once or, if there is a pause flag, in slices with a check
/// after each. `advance` gets a number of collisions, and returns its outcome and true if only that
/// number ended it.
pub fn in_slices<T>(
    mut budget: u64,
    pause: Option<&Interrupt>,
    mut advance: impl FnMut(u64) -> (T, bool),
) -> T {
    loop {
        let slice = budget.min(pause.map_or(u64::MAX, |_| BETWEEN_PAUSES));
        let (outcome, goes_on) = advance(slice);
        budget -= slice;
        if !goes_on || budget == 0 || pause.is_none_or(Interrupt::is_raised) {
            return outcome;
        }
    }
}

/// Work counters of an engine, in numbers that do not depend on the machine.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct WorkCounters {
    /// Number of pair collisions since the start; of simulators in Monte Carlo.
    pub collisions: u64,
    /// Further work counters by name, such as predictions per collision.
    pub numbers: BTreeMap<String, f64>,
}

/// Momentum and energy that one boundary (wall, obstacle, opening or inflow) has given to the gas
/// so far.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct BoundaryFlux {
    /// Name of the face, obstacle or inflow.
    pub name: String,
    /// Number of contacts with the boundary, or of particles through it; negative where particles
    /// left.
    pub particles: f64,
    /// Momentum that the boundary has given to the gas \[mass length/time\].
    pub momentum: [f64; 3],
    /// Kinetic energy that the boundary has given to the gas, rotation included \[energy\].
    pub energy: f64,
}

impl BoundaryFlux {
    /// Creates the boundary flux of a wall or an obstacle from its ledger.
    pub fn of_ledger<S: Space>(name: impl Into<String>, ledger: &WallLedger<S>) -> Self {
        Self {
            name: name.into(),
            particles: ledger.contacts,
            momentum: ledger.momentum.spatial().into(),
            energy: ledger.energy,
        }
    }
}

/// Cluster sizes of a gas whose particles aggregate and break, with the counters of these events.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Census {
    /// Numbers of clusters: pairs of monomer number and number of such clusters, sizes rising.
    pub sizes: Vec<(u32, u64)>,
    /// Counters and energies of aggregation and fragmentation so far, by name.
    pub ledger: BTreeMap<String, f64>,
}

/// Error of any engine that cannot start or continue, without the engine's type.
#[derive(Debug)]
pub struct Failure(Box<dyn Error + Send + Sync>);

impl Failure {
    /// Wraps the error of an engine, whatever its type.
    pub fn new(error: impl Error + Send + Sync + 'static) -> Self {
        Self(Box::new(error))
    }

    /// Returns the wrapped error if it is of the type `E`; `None` otherwise.
    pub fn downcast_ref<E: Error + 'static>(&self) -> Option<&E> {
        self.0.downcast_ref()
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

impl Error for Failure {
    fn source(&self) -> Option<&(dyn Error + 'static)> {
        self.0.source()
    }
}

/// Common interface of all engines: a gas that is advanced in time, observed and saved.
///
/// Measurements that an engine cannot make are `None`.
pub trait Simulation: Send {
    /// Returns the current time of the gas \[time\].
    fn time(&self) -> f64;

    /// Returns the number of space dimensions, 2 or 3.
    fn dimension(&self) -> usize;

    /// Returns the number of particles, or of simulators in Monte Carlo.
    fn particle_count(&self) -> usize;

    /// Returns the mean number of particles that a simulator stands for; 1 in event-driven
    /// dynamics.
    fn mean_weight(&self) -> f64;

    /// Advances the gas to a time, or until the budget of work is spent. True if the time was
    /// reached; never if it was interrupted.
    ///
    /// # Errors
    /// [`Failure`] if the gas cannot be advanced, as in inelastic collapse; its state is then that
    /// of this moment.
    fn advance(
        &mut self,
        until: f64,
        budget: Budget,
        observer: &mut dyn Observer,
    ) -> Result<bool, Failure>;

    /// Sets an interrupt that breaks off [`Self::advance`]; it is checked several times a second.
    fn set_stop_flag(&mut self, interrupt: &Interrupt);

    /// Sets a pause flag that ends [`Self::advance`] early, between two collisions or steps: the
    /// gas is then consistent and can be advanced again. A pause changes no number: the next
    /// advance to the same time ends with the bytes of a run without a pause, unless the gas is
    /// changed in between. A checkpoint of a paused Monte Carlo gas continues with other random
    /// numbers.
    fn set_pause_flag(&mut self, pause: &Interrupt);

    /// Sets the number of threads among which [`Self::advance`] may divide its work, where that is
    /// faster. Results do not depend on it. Monte Carlo always uses all threads of the pool.
    fn use_threads(&mut self, _threads: usize) {}

    /// Returns true if the interrupt broke off an advance. The state of the gas is then invalid,
    /// and it advances no further: a run resumes from the last checkpoint.
    fn is_interrupted(&self) -> bool;

    /// Calls `look` for every particle, in storage order (event-driven: in index order).
    fn visit_particles(&self, look: &mut dyn FnMut(&Particle));

    /// Returns all particles of the gas at the current time, in the order of indices.
    fn particles(&self) -> Particles;

    /// Adds all particles of the gas to an empty reduction, on all processes.
    fn reduce_particles(&self, sum: &mut dyn DynReduction) {
        self.visit_particles(&mut |particle| sum.add_particle(particle));
        sum.close_group(0);
    }

    /// Adds all particles to an empty reduction that also needs neighbours up to a distance `reach`
    /// \[length\], with one group for each strip of the box. Particles of weight zero are not in
    /// the strip, but near it. Only positions and weights are given.
    fn reduce_neighbourhoods(&self, _reach: f64, sum: &mut dyn DynReduction) {
        self.reduce_particles(sum);
    }

    /// Returns the second and fourth moments of the particles' velocities.
    fn velocity_moments(&self) -> VelocityMoments {
        let mut moments = VelocityMoments::default();
        self.reduce_particles(&mut moments);
        moments
    }

    /// Returns the granular temperature T = <m v^2>/D of the gas \[energy\]; 0 without particles.
    fn temperature(&self) -> f64 {
        self.velocity_moments().temperature(self.dimension())
    }

    /// Adds a velocity change \[length/time\] to each particle, in the order of
    /// [`Self::particles`]; particles beyond the list do not change.
    ///
    /// # Errors
    /// [`Failure`] if a velocity is no finite number afterwards.
    fn add_velocities(&mut self, changes: &[Vector3<f64>]) -> Result<(), Failure>;

    /// Multiplies the velocities of all particles by `factor`.
    ///
    /// # Errors
    /// [`Failure`] unless the factor is positive and finite.
    fn scale_velocities(&mut self, factor: f64) -> Result<(), Failure>;

    /// Returns a checkpoint as bytes: all data, besides the arguments of the constructor, from
    /// which a run resumes to the same bytes.
    ///
    /// # Errors
    /// [`Failure`] if memory does not suffice.
    fn save_checkpoint(&self) -> Result<Vec<u8>, Failure>;

    /// Writes the checkpoint of a gas that several processes hold: each writes its particles into a
    /// file, whose name begins with the path `stem` and which carries the fingerprint `run`.
    /// Returns the rest as bytes. `None`, with nothing written, if one process holds the whole gas.
    ///
    /// # Errors
    /// [`Failure`] if a process cannot write its file.
    fn checkpoint_in_shards(
        &self,
        _stem: &Path,
        _run: &Fingerprint,
    ) -> Result<Option<Vec<u8>>, Failure> {
        Ok(None)
    }

    /// Returns the work counters of the engine since the start of the run.
    fn work_counters(&self) -> WorkCounters;

    /// Returns statistics of the latest contacts, in engines that go from contact to contact;
    /// `None` if they are unknown.
    fn recent_contacts(&self) -> Option<RecentContacts> {
        None
    }

    /// Returns the memory that the engine occupies \[bytes\].
    fn memory_bytes(&self) -> usize;

    /// Starts to measure displacements from now on; false if this engine cannot.
    fn track_displacements(&mut self) -> bool {
        false
    }

    /// Returns the displacement of each particle since [`Self::track_displacements`], unwrapped
    /// across periodic faces, in the order of [`Self::particles`] \[length\]; `None` if not
    /// measured.
    fn displacements(&self) -> Option<Vec<Vector3<f64>>> {
        None
    }

    /// Returns the mean of the squared [`Self::displacements`] \[length^2\]; `None` without
    /// particles or if not measured.
    fn mean_squared_displacement(&self) -> Option<f64> {
        let all = self.displacements().filter(|all| !all.is_empty())?;
        let squares = all.iter().map(Vector3::norm_squared);
        Some(squares.sum::<f64>() / all.len() as f64)
    }

    /// Returns time-averaged squared displacements of the given particles for each lag: `<|R(t +
    /// lag) - R(t)|^2>` of each particle, summed over particles, and the sum of their squares.
    /// `None` if not recorded.
    fn time_averaged_displacements(
        &self,
        _particles: &[u32],
        _lags: &[f64],
    ) -> Option<Vec<[f64; 2]>> {
        None
    }

    /// Returns the momentum and energy that each wall, obstacle, opening and inflow has given to
    /// the gas so far; empty without them.
    fn boundary_fluxes(&self) -> Vec<BoundaryFlux> {
        Vec::new()
    }

    /// Returns the cluster sizes if particles aggregate and break; `None` otherwise.
    fn cluster_sizes(&self) -> Option<Census> {
        None
    }
}
