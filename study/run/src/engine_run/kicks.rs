//! Random kicks of a thermal bath (white noise or Langevin), applied to the particles of an engine.

use stosszahl_model::random::Streams;
use stosszahl_model::{Bath, Failure, Simulation, SizeDistribution};

use crate::plan::{CasePlan, PlanError};

/// Thermal bath of one replica, whose kicks are equal for all engines.
pub(crate) struct StochasticDrive {
    bath: Bath,
    /// Time between two kicks of the bath, in the unit of time of the case.
    interval: f64,
    masses: Masses,
    dimension: usize,
    streams: Streams,
}

/// Masses of the particles by index, from which kicks are scaled.
enum Masses {
    Equal(f64),
    Each(Vec<f64>),
    /// Masses are read from the engine at each kick, because particles come and go.
    Changing,
}

impl StochasticDrive {
    /// Creates the thermal bath of a case; `None` if the case has none.
    pub(crate) fn new(plan: &CasePlan, streams: Streams) -> Result<Option<Self>, PlanError> {
        let Some((bath, interval)) = plan.bath()? else {
            return Ok(None);
        };
        let masses = if let SizeDistribution::Equal(one) = &plan.gas.particles.sizes {
            Masses::Equal(one.mass)
        } else if plan.case.is_open() {
            Masses::Changing
        } else {
            let pairs = plan.radii_and_masses().into_iter();
            Masses::Each(pairs.map(|(_, mass)| mass).collect())
        };
        Ok(Some(Self {
            bath,
            interval,
            masses,
            dimension: plan.gas.dimension,
            streams,
        }))
    }

    /// Returns the time of a kick by its number, in the unit of time of the case: the middle of its
    /// interval.
    pub(crate) fn time(&self, number: u64) -> f64 {
        (number as f64 + 0.5) * self.interval
    }

    /// Applies the kick with this number to all particles of an engine.
    pub(crate) fn act(&self, gas: &mut dyn Simulation, number: u64) -> Result<(), Failure> {
        if let Some(factor) = self.bath.damping() {
            gas.scale_velocities(factor)?;
        }
        let count = gas.particle_count();
        let copies = (1.0 / gas.mean_weight()).round().max(1.0) as usize;
        let draw = |copies, mass: &dyn Fn(usize) -> f64| {
            (self.bath).kicks(self.dimension, count, copies, mass, number, &self.streams)
        };
        let changes = match &self.masses {
            Masses::Equal(mass) => draw(copies, &|_| *mass),
            Masses::Each(masses) => draw(copies, &|index| masses[index % masses.len()]),
            Masses::Changing => {
                let all = gas.particles().all;
                draw(1, &|index| all[index].mass)
            }
        };
        gas.add_velocities(&changes)
    }
}
