//! Elastic twin of exact dynamics: a companion run from the same start without dissipation,
//! compared at equal numbers of collisions per particle.
//!
//! Partners meet again in every dense gas. The elastic gas at the same packing shows what of this
//! is density and excluded area, and what is dissipation. Its trajectory does not depend on the
//! scale of velocities, so the two gases are compared at equal numbers of collisions per particle.

use std::mem;

use serde::{Deserialize, Serialize};
use serde_bytes::ByteBuf;
use stosszahl_analysis::contact_value::FluxWindow;
use stosszahl_analysis::contacts::ContactSums;
use stosszahl_ed::{DiskBoundaries, DissipationRule, EventDrivenError};
use stosszahl_model::{Budget, Failure, Interrupt, ParticleSpec, Particles, Simulation};

use super::WindowSums;
use crate::plan::{CasePlan, EnginePlan};

/// Memory of the engine of an elastic twin per disk \[bytes\].
pub(super) const BYTES_PER_DISK: f64 = 260.0;

/// Weight, in collisions per disk, of the theoretical collision rate in the estimate of the twin's
/// rate.
const PRIOR: f64 = 0.25;

/// Sums of the elastic twin in one time window of the gas: contact statistics and flux.
pub(super) type TwinWindow = (ContactSums, FluxWindow);

/// Elastic twin of one replica in progress: exact disks from the same start, without dissipation.
pub(super) struct ElasticTwin {
    gas: Box<dyn Simulation>,
    /// Time of the gas at the start of the twin \[time\].
    start: f64,
    /// Theoretical collision rate of all disks together, the prior of the twin's measured rate
    /// \[1/time\].
    expected: f64,
    /// Sums of the twin over collisions and pairs since they were last moved to the time windows.
    sums: WindowSums,
}

/// Checkpoint data of an elastic twin.
#[derive(Serialize, Deserialize)]
pub(super) struct SavedTwin {
    engine: ByteBuf,
    start: f64,
    expected: f64,
    sums: WindowSums,
}

/// Returns true if exact disks of a case have an elastic twin: they are smooth and inelastic, in a
/// uniform gas.
pub(super) fn has_twin(plan: &CasePlan, engine: &EnginePlan) -> bool {
    engine.is_exact() && plan.is_disk_fluid() && !plan.is_elastic()
}

impl ElasticTwin {
    /// Creates the elastic twin of disks at their start. `expected` is the theoretical collision
    /// rate of all disks together at temperature 1 \[1/time\].
    ///
    /// # Errors
    /// [`EventDrivenError`] if the disks overlap.
    pub(super) fn new(
        grains: &ParticleSpec,
        start: &Particles,
        expected: f64,
    ) -> Result<Self, EventDrivenError> {
        let periodic = DiskBoundaries::periodic();
        let gas = stosszahl_ed::simulate(grains, DissipationRule::Elastic, &periodic, start)?;
        let always = [f64::NEG_INFINITY, f64::INFINITY];
        let mut sums = WindowSums::new(&[always], start, start.temperature());
        sums.contacts.sample_gas(start.time, start);
        Ok(Self {
            gas,
            start: start.time,
            expected: expected * start.temperature().sqrt(),
            sums,
        })
    }

    /// Moves out the sums since the last call: over pairs at a sample, or over the collisions
    /// between two samples.
    pub(super) fn take_sums(&mut self) -> TwinWindow {
        let flux = self.sums.flux.windows[0].take_sums();
        (mem::take(&mut self.sums.contacts.windows[0].1), flux)
    }

    /// Advances the twin until it has had the given number of collisions per particle on average.
    /// The end is a time, predicted from its collision rate so far, so that the twin is sampled
    /// between collisions.
    ///
    /// # Errors
    /// [`Failure`] if the twin cannot be advanced.
    pub(super) fn follow(&mut self, collisions: u64, stop: &Interrupt) -> Result<(), Failure> {
        self.gas.set_stop_flag(stop);
        let left = collisions.saturating_sub(self.gas.work_counters().collisions);
        self.advance(left as f64)?;
        if !self.gas.is_interrupted() {
            let (time, temperature) = (self.gas.time(), self.gas.temperature());
            self.sums.synchronise(time, temperature);
        }
        Ok(())
    }

    /// Advances the twin by the mean time of some collisions, in segments between checkpoints, so
    /// that a checkpoint resumes to the same bytes.
    fn advance(&mut self, collisions: f64) -> Result<(), Failure> {
        let (done, passed) = (
            self.gas.work_counters().collisions,
            self.gas.time() - self.start,
        );
        // As if some collisions at the rate of theory had been before.
        let prior = PRIOR * self.gas.particle_count() as f64;
        let rate = (done as f64 + prior) / (passed + prior / self.expected);
        let until = self.gas.time() + collisions / rate;
        while until.is_finite() && until > self.gas.time() && !self.gas.is_interrupted() {
            if self.gas.advance(until, Budget::Leg, &mut self.sums)? {
                break;
            }
        }
        Ok(())
    }

    /// Samples the local temperatures of the twin and its pairs near contact.
    pub(super) fn sample_twin(&mut self) {
        let particles = self.gas.particles();
        self.sums.contacts.sample_gas(particles.time, &particles);
    }

    /// Collects the checkpoint data of the twin.
    ///
    /// # Errors
    /// [`Failure`] if memory does not suffice.
    pub(super) fn save(&self) -> Result<SavedTwin, Failure> {
        Ok(SavedTwin {
            engine: ByteBuf::from(self.gas.save_checkpoint()?),
            start: self.start,
            expected: self.expected,
            sums: self.sums.clone(),
        })
    }

    /// Resumes the elastic twin of a case from its checkpoint data.
    ///
    /// # Errors
    /// [`EventDrivenError`] if the checkpoint is damaged.
    pub(super) fn load(
        grains: &ParticleSpec,
        count: usize,
        saved: SavedTwin,
    ) -> Result<Self, EventDrivenError> {
        let (periodic, never) = (DiskBoundaries::periodic(), Interrupt::default());
        let elastic = DissipationRule::Elastic;
        let bytes = &saved.engine;
        let gas = stosszahl_ed::resume(grains, count, elastic, &periodic, bytes, &never)?;
        Ok(Self {
            gas,
            start: saved.start,
            expected: saved.expected,
            sums: saved.sums,
        })
    }
}
