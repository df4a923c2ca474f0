//! Displacements of particles without positions, integrated from their velocities between
//! collisions.

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use stosszahl_model::{ParticleModel, VectorOf};

/// Recorder of particle motion in a gas without positions, updated at collisions.
pub trait PathRecord<P: ParticleModel>: Clone + Serialize + DeserializeOwned {
    /// Returns true if motion is recorded, so that every collision needs its exact time.
    fn is_tracked(&self) -> bool;

    /// Records the free flight of a particle with the given velocity until `time`, when it
    /// collides.
    fn record_flight(&mut self, index: u32, velocity: &VectorOf<P>, time: f64);

    /// Returns the memory that the recorded motion occupies \[bytes\].
    fn memory_bytes(&self) -> usize;
}

/// Motion without any record.
impl<P: ParticleModel> PathRecord<P> for () {
    fn is_tracked(&self) -> bool {
        false
    }
    #[inline]
    fn record_flight(&mut self, _index: u32, _velocity: &VectorOf<P>, _time: f64) {}
    fn memory_bytes(&self) -> usize {
        0
    }
}

/// Displacement since the start and time of the last collision of each particle, updated at
/// collisions only.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(bound = "")]
pub struct DisplacementRecord<P: ParticleModel> {
    places: Vec<(VectorOf<P>, f64)>,
}

impl<P: ParticleModel> DisplacementRecord<P> {
    /// Creates a record of `count` particles with zero displacement at `time`.
    pub fn new(count: usize, time: f64) -> Self {
        Self {
            places: vec![(VectorOf::<P>::default(), time); count],
        }
    }

    /// Returns the displacement of a particle since the start at a time after its last collision,
    /// given its current velocity \[length\].
    #[inline]
    pub fn displacement_at(&self, index: usize, velocity: &VectorOf<P>, time: f64) -> VectorOf<P> {
        let (place, since) = self.places[index];
        place + *velocity * (time - since)
    }
}

impl<P: ParticleModel> PathRecord<P> for DisplacementRecord<P> {
    fn is_tracked(&self) -> bool {
        true
    }

    #[inline]
    fn record_flight(&mut self, index: u32, velocity: &VectorOf<P>, time: f64) {
        let (place, since) = &mut self.places[index as usize];
        *place += *velocity * (time - *since);
        *since = time;
    }
    fn memory_bytes(&self) -> usize {
        self.places.capacity() * size_of::<(VectorOf<P>, f64)>()
    }
}

/// Motion whose record is optional, as decided at the start of a run.
impl<P: ParticleModel, M: PathRecord<P>> PathRecord<P> for Option<M> {
    fn is_tracked(&self) -> bool {
        self.as_ref().is_some_and(PathRecord::is_tracked)
    }

    #[inline]
    fn record_flight(&mut self, index: u32, velocity: &VectorOf<P>, time: f64) {
        if let Some(motion) = self {
            motion.record_flight(index, velocity, time);
        }
    }
    fn memory_bytes(&self) -> usize {
        self.as_ref().map_or(0, PathRecord::memory_bytes)
    }
}

impl<P: ParticleModel, A: PathRecord<P>, B: PathRecord<P>> PathRecord<P> for (A, B) {
    fn is_tracked(&self) -> bool {
        self.0.is_tracked() || self.1.is_tracked()
    }

    #[inline]
    fn record_flight(&mut self, index: u32, velocity: &VectorOf<P>, time: f64) {
        self.0.record_flight(index, velocity, time);
        self.1.record_flight(index, velocity, time);
    }
    fn memory_bytes(&self) -> usize {
        self.0.memory_bytes() + self.1.memory_bytes()
    }
}
