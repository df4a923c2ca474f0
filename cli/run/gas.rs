//! The two kinds of engine, as the job loop sees them.

use std::collections::BTreeMap;

use nalgebra::{Vector2, vector};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use stosszahl_analysis::windows::Windows;
use stosszahl_dsmc::Follow;
use stosszahl_ed::Dissipation;
use stosszahl_model::random::Streams;
use stosszahl_model::{Drive, Plane, State};

use super::{RunError, leg_collisions};
use crate::dispatch::Planar;

/// Simulator steps in one leg of a Monte Carlo run, and fewest steps.
const LEG_SIMULATOR_STEPS: u64 = 5_000_000;
const LEAST_STEPS: u64 = 20;

/// What the job loop asks of an engine.
pub(super) trait Gas: Sized {
    type Physics: Planar;
    type Checkpoint: Serialize + DeserializeOwned;

    /// Advances by one leg, which is a function of the checkpoint before it; true if the time was reached.
    fn leg(&mut self, until: f64, watch: &mut Windows) -> Result<bool, RunError>;
    fn state(&self) -> State<Self::Physics>;
    fn time(&self) -> f64;
    fn scene(&self) -> &Self::Physics;
    fn collisions(&self) -> u64;
    fn weight(&self) -> f64;
    /// Follows displacements from now on.
    fn follow_displacements(&mut self);
    /// Their mean square \[length^2\]; 0 unless they are followed.
    fn mean_squared_displacement(&self) -> f64;
    /// Gives each disk or simulator its kick.
    fn kick(&mut self, drive: Drive, number: u64, streams: Streams);
    fn checkpoint(&self) -> Self::Checkpoint;
    fn work(&self) -> BTreeMap<String, f64>;
    /// Memory of the engine in or after the last leg.
    fn bytes(&self) -> usize;
}

/// Exact dynamics, between two legs.
pub(super) struct Exact<P: Planar> {
    pub(super) scene: P,
    pub(super) dissipation: Dissipation,
    pub(super) limit: Option<u64>,
    pub(super) gas: stosszahl_ed::Checkpoint<P>,
    pub(super) origin: Vec<Vector2<f64>>,
    pub(super) bytes: usize,
}

/// Everything needed to continue a run of exact dynamics.
#[derive(Serialize, Deserialize)]
#[serde(bound = "")]
pub(super) struct ExactCheckpoint<P: Planar> {
    pub(super) gas: stosszahl_ed::Checkpoint<P>,
    /// Where each disk was when displacements began; empty unless they are followed.
    pub(super) origin: Vec<Vector2<f64>>,
}

impl<P: Planar> Gas for Exact<P> {
    type Physics = P;
    type Checkpoint = ExactCheckpoint<P>;

    fn leg(&mut self, until: f64, watch: &mut Windows) -> Result<bool, RunError> {
        if self
            .limit
            .is_some_and(|limit| self.gas.tally.collisions >= limit)
        {
            return Err(RunError::CollisionLimit {
                collisions: self.gas.tally.collisions,
            });
        }
        let leg = leg_collisions(self.gas.state.bodies.len());
        let mut engine =
            stosszahl_ed::Engine::<P>::new(self.scene.clone(), self.dissipation, self.gas.clone())?;
        let reached = engine.advance(until, leg, watch);
        self.bytes = engine.bytes();
        // Also where it cannot go on: that state is what one wants to see.
        self.gas = engine.checkpoint();
        Ok(reached?)
    }
    fn state(&self) -> State<P> {
        self.gas.state.clone()
    }
    fn time(&self) -> f64 {
        self.gas.state.time
    }
    fn scene(&self) -> &P {
        &self.scene
    }
    fn collisions(&self) -> u64 {
        self.gas.tally.collisions
    }
    fn weight(&self) -> f64 {
        1.0
    }
    fn follow_displacements(&mut self) {
        let bodies = &self.gas.state.bodies;
        self.gas.windings = vec![[0; 2]; bodies.len()];
        self.origin = bodies.iter().map(|body| body.position).collect();
    }
    fn mean_squared_displacement(&self) -> f64 {
        let sides = self.gas.state.domain.lengths();
        let disks = self.gas.state.bodies.iter().zip(&self.gas.windings);
        let squares = disks.zip(&self.origin).map(|((body, winding), origin)| {
            let turns = vector![f64::from(winding[0]), f64::from(winding[1])];
            (body.position - origin + turns.component_mul(&sides)).norm_squared()
        });
        squares.sum::<f64>() / self.origin.len().max(1) as f64
    }
    fn kick(&mut self, drive: Drive, number: u64, streams: Streams) {
        let bodies = &mut self.gas.state.bodies;
        let kicks = drive.kicks(&self.scene, bodies.len(), 1, number, &streams);
        for (body, kick) in bodies.iter_mut().zip(kicks) {
            body.velocity += kick;
        }
    }
    fn checkpoint(&self) -> Self::Checkpoint {
        ExactCheckpoint {
            gas: self.gas.clone(),
            origin: self.origin.clone(),
        }
    }
    fn work(&self) -> BTreeMap<String, f64> {
        let tally = self.gas.tally;
        let each = |count: u64| count as f64 / tally.collisions.max(1) as f64;
        [
            ("predictions_per_collision", each(tally.predictions)),
            ("calendar_pushes_per_collision", each(tally.pushes)),
            ("cell_crossings_per_collision", each(tally.crossings)),
            ("stale_events_per_collision", each(tally.stale)),
            ("broken_contacts_per_collision", each(tally.broken)),
            (
                "share_of_collisions_made_elastic",
                each(tally.elastic_contacts),
            ),
        ]
        .map(|(name, number)| (name.to_owned(), number))
        .into()
    }
    fn bytes(&self) -> usize {
        self.bytes
    }
}

impl<P: Planar, F: Follow<Plane>> Gas for stosszahl_dsmc::Engine<P, F> {
    type Physics = P;
    type Checkpoint = stosszahl_dsmc::Checkpoint<P, F>;

    fn leg(&mut self, until: f64, watch: &mut Windows) -> Result<bool, RunError> {
        let steps = (LEG_SIMULATOR_STEPS / self.simulators().max(1) as u64).max(LEAST_STEPS);
        Ok(self.advance(until, steps, watch))
    }
    fn state(&self) -> State<P> {
        self.state()
    }
    fn time(&self) -> f64 {
        self.time()
    }
    fn scene(&self) -> &P {
        self.scene()
    }
    fn collisions(&self) -> u64 {
        self.tally().collisions
    }
    fn weight(&self) -> f64 {
        self.weight()
    }
    fn follow_displacements(&mut self) {
        self.follow_displacements();
    }
    fn mean_squared_displacement(&self) -> f64 {
        let all = self.displacements();
        all.iter().map(Vector2::norm_squared).sum::<f64>() / all.len().max(1) as f64
    }
    fn kick(&mut self, drive: Drive, number: u64, streams: Streams) {
        let copies = (1.0 / self.weight()).round() as usize;
        let kicks = drive.kicks(self.scene(), self.simulators(), copies, number, &streams);
        stosszahl_dsmc::Engine::kick(self, &kicks);
    }
    fn checkpoint(&self) -> Self::Checkpoint {
        self.checkpoint()
    }
    fn work(&self) -> BTreeMap<String, f64> {
        let tally = self.tally();
        let over = |a: f64, b: u64| a / b.max(1) as f64;
        let simulators = self.simulators() as u64;
        [
            ("steps", tally.steps as f64),
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
                "collision_separation_over_d",
                over(tally.separation, tally.collisions),
            ),
            (
                "most_collisions_per_simulator_in_a_cell_and_step",
                tally.busiest_cell,
            ),
            ("cell_width_over_d", self.cell()[0]),
        ]
        .map(|(name, number)| (name.to_owned(), number))
        .into()
    }
    fn bytes(&self) -> usize {
        self.bytes()
    }
}
