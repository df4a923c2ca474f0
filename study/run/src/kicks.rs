//! Kicks of a stochastic drive, applied to the particles of an engine.

use nalgebra::Vector3;
use stosszahl_model::random::Streams;
use stosszahl_model::{
    Drive, Free, Invalid, Law, Monodisperse, Polydisperse, Scene, SizeDistribution, Sizes, Smooth,
    Space,
};

use crate::plan::{Plan, PlanError, in_space};

/// Drive of one replica; all its engines draw the same kicks.
pub(crate) struct StochasticDrive {
    drive: Drive,
    sizes: Which,
    dimension: usize,
    streams: Streams,
}

enum Which {
    Equal(Monodisperse),
    Each(Polydisperse),
}

impl StochasticDrive {
    /// Creates the drive of a case; `None` without one.
    pub(crate) fn new(plan: &Plan, streams: Streams) -> Result<Option<Self>, PlanError> {
        let Some(drive) = plan.drive()? else {
            return Ok(None);
        };
        let sizes = if let SizeDistribution::Equal(one) = &plan.grains.sizes {
            Which::Equal(*one)
        } else {
            let failed = |error: Invalid| PlanError::new("drive", error.found, error.allowed);
            Which::Each(Polydisperse::new(plan.radii_and_masses()).map_err(failed)?)
        };
        Ok(Some(Self {
            drive,
            sizes,
            dimension: plan.dimension,
            streams,
        }))
    }

    /// Velocity changes of one kick for each simulator \[length/time\], where each stands for
    /// `weight` particles.
    pub(crate) fn changes(&self, number: u64, simulators: usize, weight: f64) -> Vec<Vector3<f64>> {
        let copies = (1.0 / weight).round().max(1.0) as usize;
        in_space!(self.dimension, S => match &self.sizes {
            Which::Equal(sizes) => self.draw::<S, _>(*sizes, number, simulators, copies),
            Which::Each(sizes) => {
                self.draw::<S, _>(sizes.repeated(copies), number, simulators, copies)
            }
        })
    }

    fn draw<S: Space, Z: Sizes>(
        &self,
        sizes: Z,
        number: u64,
        simulators: usize,
        copies: usize,
    ) -> Vec<Vector3<f64>> {
        let scene = Scene {
            space: S::default(),
            surface: Smooth,
            restitution: Law::ELASTIC,
            sizes,
            field: Free,
        };
        let streams = &self.streams;
        let kicks = self
            .drive
            .kicks(&scene, simulators, copies, number, streams);
        kicks.iter().map(stosszahl_model::Vector::spatial).collect()
    }
}
