//! The two engines, as a run of a flow sees them.

use std::collections::BTreeMap;

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use stosszahl_analysis::fields::{Fields, Sighting};
use stosszahl_dsmc::Unfollowed;
use stosszahl_ed::Dissipation;
use stosszahl_model::walls::Book;
use stosszahl_model::{
    Collision, Observe, Physics, Plane, Sizes, Space, Surface, Vector, VectorOf,
};

use crate::run::RunError;

/// What the loop asks of an engine.
pub(super) trait Gas: Sized {
    type Space: Space;
    type Checkpoint: Serialize + DeserializeOwned;

    /// Advances by one leg, which is a function of the checkpoint before it; true if the time was reached.
    fn leg(&mut self, until: f64, fields: &mut Fields) -> Result<bool, RunError>;
    /// Shows all grains, with the number of their species.
    fn visit(&self, look: impl FnMut(u32, &Sighting, f64));
    fn time(&self) -> f64;
    /// Pair collisions of simulators.
    fn collisions(&self) -> u64;
    fn books(&self) -> Ledger;
    fn checkpoint(&self) -> Self::Checkpoint;
    fn work(&self) -> BTreeMap<String, f64>;
}

/// Mass, momentum and energy that came from outside, by what gave them.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Ledger {
    /// One entry for each face that is no periodic one, each obstacle, inflow and, with weights, their balance.
    pub entries: Vec<Entry>,
}

/// What one boundary gave to the gas.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Entry {
    /// Its name.
    pub name: String,
    /// Contacts with it, or grains through it; fewer than none if they left.
    pub grains: f64,
    /// Momentum.
    pub momentum: [f64; 3],
    /// Kinetic energy, of rotation too.
    pub energy: f64,
}

impl Entry {
    fn of_book<S: Space>(name: impl Into<String>, book: &Book<S>) -> Self {
        Self {
            name: name.into(),
            grains: book.contacts,
            momentum: components::<S>(book.momentum),
            energy: book.energy,
        }
    }
}

/// The components of a vector; zero beyond the dimension.
pub(super) fn components<S: Space>(vector: S::Vector) -> [f64; 3] {
    [0, 1, 2].map(|axis| {
        if axis < S::DIMENSION {
            vector[axis]
        } else {
            0.0
        }
    })
}

/// Puts collisions into the fields.
struct Watch<'a> {
    fields: &'a mut Fields,
}

impl<P: Physics> Observe<P> for Watch<'_> {
    fn collision(&mut self, collision: &Collision<VectorOf<P>>) {
        let at = collision.position;
        self.fields.collision(
            collision.time,
            [at[0], at[1]],
            collision.virial(),
            collision.weight,
        );
    }
}
