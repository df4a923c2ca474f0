//! The two engines, as a run of a flow sees them.

use std::collections::BTreeMap;

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use stosszahl_analysis::fields::{Fields, Sighting};
use stosszahl_dsmc::{Transfer, Unfollowed};
use stosszahl_ed::Dissipation;
use stosszahl_model::walls::Book;
use stosszahl_model::{
    Collision, Domain, Observe, Physics, Plane, Sizes, Space, Surface, Vector, VectorOf,
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
    /// Grains that a simulator stands for.
    fn weight(&self) -> f64;
    fn books(&self) -> Ledger;
    fn checkpoint(&self) -> Self::Checkpoint;
    fn work(&self) -> BTreeMap<String, f64>;
}

/// Name of the entry of splitting and merging.
pub(super) const BALANCE: &str = "splitting and merging";

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

impl Entry {
    fn of_transfer<S: Space>(name: impl Into<String>, transfer: &Transfer<S>) -> Self {
        Self {
            name: name.into(),
            grains: transfer.particles,
            momentum: components::<S>(transfer.momentum),
            energy: transfer.energy,
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
struct Watch<'a, S: Space> {
    fields: &'a mut Fields,
    domain: Domain<S>,
    /// Whether momentum is carried over the distance of the partners, as it is not where they are points.
    carries: bool,
}

impl<P: Physics> Observe<P> for Watch<'_, P::Space> {
    fn collision(&mut self, collision: &Collision<VectorOf<P>>) {
        let at = self.domain.wrap(collision.position);
        let virial = if self.carries {
            collision.virial()
        } else {
            0.0
        };
        self.fields
            .collision(collision.time, [at[0], at[1]], virial, collision.weight);
    }
}

/// Simulator steps in one leg of a Monte Carlo run, and fewest steps.
const LEG_SIMULATOR_STEPS: u64 = 5_000_000;
const LEAST_STEPS: u64 = 20;

/// Monte Carlo.
pub(super) struct Chance<P: Physics> {
    pub(super) engine: stosszahl_dsmc::Engine<P, Unfollowed>,
    /// Whether collisions carry momentum over the distance of the partners.
    pub(super) carries: bool,
}

impl<P: Physics> Gas for Chance<P> {
    type Space = P::Space;
    type Checkpoint = stosszahl_dsmc::Checkpoint<P, Unfollowed>;

    fn leg(&mut self, until: f64, fields: &mut Fields) -> Result<bool, RunError> {
        let simulators = self.engine.simulators().max(1) as u64;
        let steps = (LEG_SIMULATOR_STEPS / simulators).max(LEAST_STEPS);
        let mut watch = Watch {
            fields,
            domain: *self.engine.grid().domain(),
            carries: self.carries,
        };
        Ok(self.engine.advance(until, steps, &mut watch))
    }

    fn visit(&self, mut look: impl FnMut(u32, &Sighting, f64)) {
        let scene = self.engine.scene();
        let sizes = scene.sizes();
        let down = scene.field();
        self.engine.visit(|position, velocity, spin, tag, weight| {
            let mass = sizes.mass(tag);
            let energy = scene.surface().spin_energy(mass, sizes.radius(tag), spin);
            let sighting = Sighting {
                position: [position[0], position[1]],
                velocity: components::<P::Space>(velocity),
                mass,
                twice_spin_energy: 2.0 * energy,
                weight,
            };
            look(
                sizes.kind(tag),
                &sighting,
                height_energy::<P>(down, mass, position),
            );
        });
    }

    fn time(&self) -> f64 {
        self.engine.time()
    }

    fn collisions(&self) -> u64 {
        self.engine.tally().collisions
    }

    fn weight(&self) -> f64 {
        self.engine.weight()
    }

    fn books(&self) -> Ledger {
        let books = self.engine.books();
        let mut entries = Vec::new();
        for (axis, names) in super::case::FACES.iter().enumerate() {
            for (side, name) in names.iter().enumerate() {
                let wall = &books.walls[axis][side];
                if wall.contacts > 0.0 {
                    entries.push(Entry::of_book(*name, wall));
                }
                let open = &books.open[axis][side];
                if open.particles != 0.0 {
                    entries.push(Entry::of_transfer(format!("out through {name}"), open));
                }
            }
        }
        for (index, obstacle) in books.obstacles.iter().enumerate() {
            entries.push(Entry::of_book(format!("obstacle {}", index + 1), obstacle));
        }
        for (index, inflow) in books.inflows.iter().enumerate() {
            entries.push(Entry::of_transfer(format!("inflow {}", index + 1), inflow));
        }
        if books.balanced > 0 {
            entries.push(Entry::of_transfer(BALANCE, &books.balance));
        }
        Ledger { entries }
    }

    fn checkpoint(&self) -> Self::Checkpoint {
        self.engine.checkpoint()
    }

    fn work(&self) -> BTreeMap<String, f64> {
        let tally = self.engine.tally();
        let over = |a: f64, b: u64| a / b.max(1) as f64;
        [
            ("steps", tally.steps as f64),
            ("simulators", self.engine.simulators() as f64),
            (
                "trials_per_collision",
                over(tally.trials as f64, tally.collisions),
            ),
            (
                "majorant_violations_per_trial",
                over(tally.majorant_violations as f64, tally.trials),
            ),
            (
                "grains_laid_to_rest_on_walls",
                self.engine.books().rests as f64,
            ),
        ]
        .map(|(name, number)| (name.to_owned(), number))
        .into()
    }
}

/// Energy of a grain in the field, zero at the origin.
fn height_energy<P: Physics>(field: &P::Field, mass: f64, position: VectorOf<P>) -> f64 {
    use stosszahl_model::Field;
    -mass * field.acceleration().inner(&position)
}

/// Collisions in one leg of event-driven dynamics, for each disk, and at least.
const LEG_COLLISIONS: u64 = 4;
const LEAST_COLLISIONS: u64 = 100_000;

/// Exact dynamics, between two legs.
pub(super) struct Exact<P: Physics<Space = Plane>> {
    pub(super) scene: P,
    pub(super) dissipation: Dissipation,
    pub(super) boundaries: stosszahl_ed::Boundaries,
    pub(super) gas: stosszahl_ed::Checkpoint<P>,
}

impl<P: Physics<Space = Plane>> Gas for Exact<P> {
    type Space = Plane;
    type Checkpoint = stosszahl_ed::Checkpoint<P>;

    fn leg(&mut self, until: f64, fields: &mut Fields) -> Result<bool, RunError> {
        let disks = self.gas.state.bodies.len() as u64;
        let leg = (LEG_COLLISIONS * disks).max(LEAST_COLLISIONS);
        let mut engine = stosszahl_ed::Engine::<P>::between(
            self.scene.clone(),
            self.dissipation,
            self.gas.clone(),
            &self.boundaries,
        )?;
        let mut watch = Watch {
            fields,
            domain: self.gas.state.domain,
            carries: true,
        };
        let reached = engine.advance(until, leg, &mut watch);
        self.gas = engine.checkpoint();
        Ok(reached?)
    }

    fn visit(&self, mut look: impl FnMut(u32, &Sighting, f64)) {
        let (sizes, surface) = (self.scene.sizes(), self.scene.surface());
        for (index, body) in self.gas.state.bodies.iter().enumerate() {
            let tag = sizes.tag(index);
            let mass = sizes.mass(tag);
            let sighting = Sighting {
                position: [body.position[0], body.position[1]],
                velocity: components::<Plane>(body.velocity),
                mass,
                twice_spin_energy: 2.0 * surface.spin_energy(mass, sizes.radius(tag), body.spin),
                weight: 1.0,
            };
            let energy = height_energy::<P>(self.scene.field(), mass, body.position);
            look(sizes.kind(tag), &sighting, energy);
        }
    }

    fn time(&self) -> f64 {
        self.gas.state.time
    }

    fn collisions(&self) -> u64 {
        self.gas.tally.collisions
    }

    fn weight(&self) -> f64 {
        1.0
    }

    fn books(&self) -> Ledger {
        // The four faces, then the obstacles.
        let faces = super::case::FACES.iter().take(2).flatten();
        let names = faces
            .map(|name| (*name).to_owned())
            .chain((1..).map(|number| format!("obstacle {number}")));
        let touched = names
            .zip(&self.gas.books)
            .filter(|(_, book)| book.contacts > 0.0);
        Ledger {
            entries: touched
                .map(|(name, book)| Entry::of_book(name, book))
                .collect(),
        }
    }

    fn checkpoint(&self) -> Self::Checkpoint {
        self.gas.clone()
    }

    fn work(&self) -> BTreeMap<String, f64> {
        let tally = self.gas.tally;
        let each = |count: u64| count as f64 / tally.collisions.max(1) as f64;
        [
            ("predictions_per_collision", each(tally.predictions)),
            ("calendar_pushes_per_collision", each(tally.pushes)),
            ("cell_crossings_per_collision", each(tally.crossings)),
            (
                "share_of_collisions_made_elastic",
                each(tally.elastic_contacts),
            ),
        ]
        .map(|(name, number)| (name.to_owned(), number))
        .into()
    }
}
