//! The one interface of all engines: what a measurement, a program or another language drives.
//!
//! [`Simulation`] is object-safe and knows no type of a scene. Engines are instantiated for their physics inside their own
//! crates and chosen at run time, once for each leg of a run: one virtual call for 10^5 to 10^8 collisions. So crates build
//! side by side, and a new measurement instantiates nothing.

use std::collections::BTreeMap;
use std::error::Error;
use std::fmt;
use std::path::Path;

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

use crate::exact::Exact;
use crate::images::Images;
use crate::interrupt::Interrupt;
use crate::observer::Observer;
use crate::particle::Particle;
use crate::physics::Physics;
use crate::recent_contacts::RecentContacts;
use crate::sizes::Sizes as _;
use crate::snapshot::Fingerprint;
use crate::space::{Space, Vector as _, Volume};
use crate::state::State;
use crate::sum::{Adds, Sum};
use crate::walls::Ledger;

/// All particles at one time. This is what measurements see and what engines start from.
#[derive(Clone, Debug, PartialEq)]
pub struct Particles {
    /// Time \[time\].
    pub time: f64,
    /// 2 or 3.
    pub dimension: usize,
    /// Sides of the box \[length\]; beyond the dimension, and without positions, zero.
    pub lengths: [f64; 3],
    /// Whether the box is periodic, by axis; true beyond the dimension.
    pub periodic: [bool; 3],
    /// The particles; their indices mean the same particle at all times, unless particles come and go.
    pub all: Vec<Particle>,
}

impl Particles {
    /// Granular temperature T = <m v^2>/D \[energy\]; 0 for none.
    pub fn temperature(&self) -> f64 {
        self.moments().temperature(self.dimension)
    }

    /// Moments of their velocities.
    pub fn moments(&self) -> Moments {
        let mut moments = Moments::default();
        for particle in &self.all {
            Adds::add(&mut moments, particle);
        }
        moments
    }

    /// The map of periodic images, without shear; there are none along axes without a length.
    pub fn images(&self) -> Images<Volume> {
        let periodic = [0, 1, 2].map(|axis| self.periodic[axis] && self.lengths[axis] > 0.0);
        Images::new(self.lengths.into(), periodic)
    }

    /// Area or volume of the box \[length^D\].
    pub fn volume(&self) -> f64 {
        self.lengths[..self.dimension].iter().product()
    }
}

/// Moments of velocities. Their sums are exact, so that they do not depend on the order of particles, nor on who adds which.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Moments {
    count: Exact,
    second: Exact,
    fourth: Exact,
}

impl Moments {
    /// Moments of the bodies of a state.
    pub fn of_state<P: Physics>(scene: &P, state: &State<P>) -> Self {
        let (sizes, mut moments) = (scene.sizes(), Self::default());
        for (index, body) in state.bodies.iter().enumerate() {
            moments.add(1.0, sizes.mass(sizes.tag(index)) * body.velocity.square());
        }
        moments
    }

    /// Adds so many particles of a `m v^2`.
    pub fn add(&mut self, weight: f64, square: f64) {
        self.count.add(weight);
        self.second.add(weight * square);
        self.fourth.add(weight * square * square);
    }

    /// `<m v^2>` and `<m^2 v^4>`; 0 for none.
    pub fn means(&self) -> [f64; 2] {
        let count = self.count.value();
        let count = if count > 0.0 { count } else { 1.0 };
        [&self.second, &self.fourth].map(|sum| sum.value() / count)
    }

    /// Granular temperature T = <m v^2>/D \[energy\]; 0 for none.
    pub fn temperature(&self, dimension: usize) -> f64 {
        self.means()[0] / dimension as f64
    }
}

impl Adds for Moments {
    const NAME: &'static str = "moments";

    fn add(&mut self, particle: &Particle) {
        let square = particle.mass * particle.velocity.norm_squared();
        self.add(particle.weight, square);
    }

    fn merge(&mut self, other: Self) {
        self.count.merge(&other.count);
        self.second.merge(&other.second);
        self.fourth.merge(&other.fourth);
    }
}

/// How far [`Simulation::advance`] may go before the time is reached.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Budget {
    /// To the time, however long that takes.
    Unlimited,
    /// One leg: some seconds of work, counted in collisions or time steps. A leg is a function of the checkpoint before it, so
    /// that a run that was stopped between two legs goes on to the same bytes.
    Leg,
    /// This number of pair collisions; Monte Carlo in cells stops at the end of the time step in which they are reached.
    Collisions(u64),
}

/// Collisions between two looks at [`Simulation::pause_on`], of engines that go from collision to collision.
const BETWEEN_PAUSES: u64 = 50_000;

/// Spends a budget of collisions at once, or, where a pause may be asked for, in slices after which it is looked at. `advance` has a
/// number of collisions, and returns what came of them and whether the budget was all that ended them.
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

/// What was done, in numbers that do not depend on the machine.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Work {
    /// Pair collisions, of simulators where those collide.
    pub collisions: u64,
    /// Named numbers, such as predictions per collision.
    pub numbers: BTreeMap<String, f64>,
}

/// What one boundary has given to the gas so far.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct BoundaryFlux {
    /// Its name: a face, an obstacle, an inflow.
    pub name: String,
    /// Contacts with it, or particles through it; negative where particles left.
    pub particles: f64,
    /// Momentum.
    pub momentum: [f64; 3],
    /// Kinetic energy, with that of rotation.
    pub energy: f64,
}

impl BoundaryFlux {
    /// What a wall or an obstacle gave.
    pub fn of_ledger<S: Space>(name: impl Into<String>, ledger: &Ledger<S>) -> Self {
        Self {
            name: name.into(),
            particles: ledger.contacts,
            momentum: ledger.momentum.spatial().into(),
            energy: ledger.energy,
        }
    }
}

/// Clusters of a gas whose particles stick and break.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Census {
    /// Number of clusters by number of monomers, rising.
    pub sizes: Vec<(u32, u64)>,
    /// What sticking and breaking did so far, by name.
    pub ledger: BTreeMap<String, f64>,
}

/// An engine that cannot start or go on, whatever its own error says.
#[derive(Debug)]
pub struct Failure(Box<dyn Error + Send + Sync>);

impl Failure {
    /// Wraps the error of an engine.
    pub fn new(error: impl Error + Send + Sync + 'static) -> Self {
        Self(Box::new(error))
    }

    /// The error of an engine, if it is of this type.
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

/// A gas under way, whatever moves it.
///
/// Measurements that an engine cannot make are `None`.
pub trait Simulation: Send {
    /// The present time.
    fn time(&self) -> f64;

    /// 2 or 3.
    fn dimension(&self) -> usize;

    /// Number of particles, or of simulators.
    fn count(&self) -> usize;

    /// Number of particles that a simulator stands for, in the mean; 1 in exact dynamics.
    fn weight(&self) -> f64;

    /// Advances to a time, or until the budget is spent. True if the time was reached; never if it was interrupted.
    ///
    /// # Errors
    /// [`Failure`] if the gas cannot go on, as in inelastic collapse; it then stands at that moment.
    fn advance(
        &mut self,
        until: f64,
        budget: Budget,
        observer: &mut dyn Observer,
    ) -> Result<bool, Failure>;

    /// Lets [`Self::advance`] end early once this is raised, which it looks at several times a second.
    fn stop_on(&mut self, interrupt: &Interrupt);

    /// Lets [`Self::advance`] end early once this is raised, between two collisions or steps: the gas is then whole and can go
    /// on. It changes no number: the next advance to the same time ends with the bytes of one that was not paused, unless something
    /// else is done with the gas in between. A checkpoint of a paused Monte Carlo gas goes on with other random numbers.
    fn pause_on(&mut self, pause: &Interrupt);

    /// Lets [`Self::advance`] share its work among this many threads of the present thread pool, where that pays. No number depends
    /// on it. Monte Carlo uses all threads of the pool in any case.
    fn use_threads(&mut self, _threads: usize) {}

    /// Whether the interrupt broke an advance off. The gas is then in the middle of it, so that nothing that it shows has a
    /// meaning, and it advances no further: what goes on is the last checkpoint.
    fn is_interrupted(&self) -> bool;

    /// Shows each particle once, in the order of the engine's own storage; exact dynamics in that of indices.
    fn visit(&self, look: &mut dyn FnMut(&Particle));

    /// The gas at the present time, in the order of indices.
    fn particles(&self) -> Particles;

    /// Adds all particles to an empty sum, wherever they are.
    fn add_up(&self, sum: &mut dyn Sum) {
        self.visit(&mut |particle| sum.add(particle));
        sum.close(0);
    }

    /// Adds all particles to an empty sum that also looks at neighbours up to a distance `reach`: strip by strip of the box, which are
    /// groups. Those of weight zero are not of the strip, but near it. Only positions and weights are shown.
    fn add_up_near(&self, _reach: f64, sum: &mut dyn Sum) {
        self.add_up(sum);
    }

    /// Moments of the velocities.
    fn moments(&self) -> Moments {
        let mut moments = Moments::default();
        self.add_up(&mut moments);
        moments
    }

    /// Granular temperature T = <m v^2>/D \[energy\]; 0 for none.
    fn temperature(&self) -> f64 {
        self.moments().temperature(self.dimension())
    }

    /// Adds to the velocity of each particle, in the order of [`Self::particles`]; particles beyond the list stay as they are.
    ///
    /// # Errors
    /// [`Failure`] if a velocity is no finite number afterwards.
    fn kick(&mut self, changes: &[Vector3<f64>]) -> Result<(), Failure>;

    /// Multiplies all velocities.
    ///
    /// # Errors
    /// [`Failure`] unless the factor is positive and finite.
    fn scale_velocities(&mut self, factor: f64) -> Result<(), Failure>;

    /// Everything that is needed to go on to the same bytes, but what the constructor is given.
    ///
    /// # Errors
    /// [`Failure`] if memory does not suffice.
    fn checkpoint(&self) -> Result<Vec<u8>, Failure>;

    /// The same of a gas that several processes hold, with its particles in files that each of them writes for itself: their names
    /// begin with the path `stem`, and they are of this run. None, and nothing is written, where one process holds all.
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

    /// What was done so far.
    fn work(&self) -> Work;

    /// Latest contacts, of engines that go from contact to contact; none where they are not known.
    fn recent_contacts(&self) -> Option<RecentContacts> {
        None
    }

    /// Memory held \[bytes\].
    fn bytes(&self) -> usize;

    /// Measures displacements from now on; false if this engine cannot.
    fn follow_displacements(&mut self) -> bool {
        false
    }

    /// How far each particle has come since then, across the edges of the box, in the order of [`Self::particles`].
    fn displacements(&self) -> Option<Vec<Vector3<f64>>> {
        None
    }

    /// Mean square of these displacements; none without particles.
    fn mean_squared_displacement(&self) -> Option<f64> {
        let all = self.displacements().filter(|all| !all.is_empty())?;
        let squares = all.iter().map(Vector3::norm_squared);
        Some(squares.sum::<f64>() / all.len() as f64)
    }

    /// Displacements averaged over time, for the given particles and lags: `<|R(t + lag) - R(t)|^2>` of each, summed over
    /// particles, and their squares summed.
    fn time_averaged_displacements(
        &self,
        _particles: &[u32],
        _lags: &[f64],
    ) -> Option<Vec<[f64; 2]>> {
        None
    }

    /// What walls, obstacles, openings and inflows have given so far; empty where there are none.
    fn boundaries(&self) -> Vec<BoundaryFlux> {
        Vec::new()
    }

    /// Clusters, where particles stick and break.
    fn census(&self) -> Option<Census> {
        None
    }
}
