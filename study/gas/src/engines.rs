//! Engines that run a [`Gas`] in custom programs: exact event-driven dynamics, and Monte Carlo.

use std::ops::{Deref, DerefMut};

use stosszahl_dsmc::homogeneous::{HomogeneousSettings, PairCorrelationFactor, PairSelection};
use stosszahl_dsmc::{
    BoundaryConditions, Parameters, PartnerDisplacement, PartnerSelection, Scheme,
};
use stosszahl_ed::DissipationRule;
use stosszahl_model::initial::VelocityDistribution;
use stosszahl_model::{Budget, Interrupt, Observer, ParticleSpec, Particles, Simulation};

use crate::memory::{RUNNING, need_memory};
use crate::reach::check_time;
use crate::{Gas, GasError};

impl Gas {
    /// Returns the rule by which collisions of exact dynamics lose energy (all, or not within the
    /// contact time).
    fn dissipation(&self) -> DissipationRule {
        if self.contact_time > 0.0 {
            DissipationRule::ContactTime(self.contact_time)
        } else {
            DissipationRule::Scene
        }
    }
}

/// Exact event-driven dynamics of a gas of disks. It is a [`Simulation`], by `Deref`.
pub struct EventDriven {
    gas: Gas,
    simulation: Box<dyn Simulation>,
    collides: bool,
}

impl EventDriven {
    /// Creates exact event-driven dynamics of a gas.
    ///
    /// # Errors
    /// [`GasError`] if the gas has no positions, or open faces, or disks that overlap.
    pub fn new(gas: &Gas) -> Result<Self, GasError> {
        Ok(Self {
            simulation: exact(gas, &gas.grains, &gas.particles, gas.dissipation())?,
            gas: gas.clone(),
            collides: true,
        })
    }

    /// Runs elastic collisions until each disk has had the given number on average, then restores
    /// the temperature and resets the time. Shear is off meanwhile.
    ///
    /// # Errors
    /// [`GasError`] if the gas cannot be run, or its shear flow has begun.
    pub fn equilibrate(&mut self, collisions_per_particle: f64) -> Result<(), GasError> {
        self.equilibrate_unless(collisions_per_particle, &Interrupt::default())?;
        Ok(())
    }

    /// Equilibrates as [`Self::equilibrate`]. If the interrupt is raised meanwhile, the gas is
    /// unchanged and the result is false.
    ///
    /// # Errors
    /// As [`Self::equilibrate`].
    pub fn equilibrate_unless(
        &mut self,
        collisions_per_particle: f64,
        interrupt: &Interrupt,
    ) -> Result<bool, GasError> {
        let mut particles = self.simulation.particles();
        let (time, temperature) = (particles.time, particles.temperature());
        if particles.shear_offset(self.gas.grains.shear()) != 0.0 {
            return Err(GasError::Unfit {
                what: "equilibration of a shear flow that has begun",
                instead: "equilibrate before the first advance",
            });
        }
        let at_rest = ParticleSpec {
            shear_rate: None,
            ..self.gas.grains.clone()
        };
        let mut elastic = exact(&self.gas, &at_rest, &particles, DissipationRule::Elastic)?;
        let pairs = 0.5 * collisions_per_particle * elastic.particle_count() as f64;
        elastic.set_stop_flag(interrupt);
        elastic.advance(f64::INFINITY, Budget::Collisions(pairs as u64), &mut ())?;
        // The advance ends at a collision. The state is taken one mean free time later, at no
        // particular event.
        let (passed, collisions) = (elastic.time() - time, elastic.work_counters().collisions);
        if collisions > 0 && !elastic.is_interrupted() {
            let free = 0.5 * passed * elastic.particle_count() as f64 / collisions as f64;
            elastic.advance(elastic.time() + free, Budget::Unlimited, &mut ())?;
        }
        if elastic.is_interrupted() {
            return Ok(false);
        }
        let factor = (temperature / elastic.temperature()).sqrt();
        if factor.is_finite() && factor > 0.0 {
            elastic.scale_velocities(factor)?;
        }
        particles = elastic.particles();
        particles.time = time;
        let dissipation = self.gas.dissipation();
        self.simulation = exact(&self.gas, &self.gas.grains, &particles, dissipation)?;
        Ok(true)
    }
}

/// Creates exact dynamics of given particles, with given contact laws, in the box of a gas.
fn exact(
    gas: &Gas,
    grains: &ParticleSpec,
    particles: &Particles,
    dissipation: DissipationRule,
) -> Result<Box<dyn Simulation>, GasError> {
    if particles.lengths[0] <= 0.0 {
        return Err(GasError::Unfit {
            what: "exact dynamics of a gas without positions",
            instead: "use Monte Carlo, or a gas of disks",
        });
    }
    need_memory(particles.all.len(), RUNNING)?;
    let boundaries = stosszahl_ed::DiskBoundaries {
        walls: gas.walls.in_plane(),
        obstacles: Vec::new(),
        streams: gas.streams.branch(1),
    };
    let simulation = stosszahl_ed::simulate(grains, dissipation, &boundaries, particles)?;
    Ok(simulation)
}

/// Monte Carlo dynamics (DSMC) of a gas: in cells, or without positions. It is a [`Simulation`], by
/// `Deref`.
pub struct MonteCarlo {
    gas: Gas,
    simulation: Box<dyn Simulation>,
    collides: bool,
}

impl MonteCarlo {
    /// Creates Monte Carlo of a gas without positions, such as [`Gas::spheres`].
    ///
    /// # Errors
    /// [`GasError`] if the gas spins or falls.
    pub fn new(gas: &Gas) -> Result<Self, GasError> {
        need_memory(gas.particles.all.len(), RUNNING)?;
        let temperature = match gas.particles.temperature() {
            // Nothing moves yet: a gas without positions draws its velocities itself.
            0.0 => 1.0,
            known => known,
        };
        let simulation = HomogeneousSettings {
            dimension: gas.particles.dimension,
            grains: &gas.grains,
            count: gas.particles.all.len(),
            volume: gas.volume,
            contact: PairCorrelationFactor::Enskog,
            temperatures: &[temperature],
            velocities: VelocityDistribution::MAXWELLIAN,
            pick: PairSelection::AliasTables,
            tracer: None,
            sticking: None,
            displacements: true,
            paths: (0, &[]),
            streams: gas.streams,
        }
        .simulate()?;
        Ok(Self {
            gas: gas.clone(),
            simulation,
            collides: true,
        })
    }

    /// Creates Monte Carlo in cells from the microstate of a gas, with one simulator for each
    /// particle and the defaults of a scheme.
    ///
    /// # Errors
    /// [`GasError`] if scheme and gas do not go together.
    pub fn from_state(gas: &Gas, scheme: Scheme) -> Result<Self, GasError> {
        Self::with(gas, Self::defaults(gas, scheme))
    }

    /// Returns the default Monte Carlo parameters for a gas: those of the scheme, but without
    /// displacement of partners if there are walls or shear.
    pub fn defaults(gas: &Gas, scheme: Scheme) -> Parameters {
        let defaults = Parameters::for_scheme(scheme);
        if gas.grains.is_bounded || gas.grains.shear_rate.is_some() {
            return Parameters {
                displacement: PartnerDisplacement::None,
                ..defaults
            };
        }
        defaults
    }

    /// Creates Monte Carlo in cells from the microstate of a gas, with custom parameters.
    ///
    /// # Errors
    /// As [`Self::from_state`].
    pub fn with(gas: &Gas, parameters: Parameters) -> Result<Self, GasError> {
        need_memory(gas.particles.all.len(), RUNNING)?;
        let boundaries = BoundaryConditions {
            walls: gas.walls.clone(),
            clearance: parameters.scheme.properties().clearance,
            ..BoundaryConditions::default()
        };
        let parts = stosszahl_dsmc::CellGas {
            grains: &gas.grains,
            parameters,
            boundaries: &boundaries,
            streams: gas.streams.branch(2),
            displacements: !gas.grains.is_bounded && gas.grains.shear_rate.is_none(),
        };
        let starts = std::slice::from_ref(&gas.particles);
        Ok(Self {
            simulation: stosszahl_dsmc::simulate(&parts, starts)?,
            gas: gas.clone(),
            collides: parameters.scheme.partners() != PartnerSelection::None,
        })
    }
}

/// Implements the methods that both engines of this crate have.
macro_rules! is_a_simulation {
    ($engine:ty) => {
        impl $engine {
            /// Returns the current gas, with one particle for each simulator. Another engine can
            /// start from it.
            pub fn state(&self) -> Gas {
                Gas {
                    particles: self.simulation.particles(),
                    ..self.gas.clone()
                }
            }

            /// Advances the gas to a time; the observer receives all collisions until then.
            ///
            /// # Errors
            /// [`GasError::Time`] for a time that is past or infinite, or so far that it would take
            /// years; [`GasError::Failure`] if the gas cannot be advanced, as in inelastic
            /// collapse, and again until velocities change.
            pub fn advance(
                &mut self,
                until: f64,
                observer: &mut dyn Observer,
            ) -> Result<(), GasError> {
                check_time(&self.gas, &*self.simulation, self.collides, until)?;
                self.simulation
                    .advance(until, Budget::Unlimited, observer)?;
                Ok(())
            }
        }

        impl Deref for $engine {
            type Target = dyn Simulation;

            fn deref(&self) -> &Self::Target {
                &*self.simulation
            }
        }

        impl DerefMut for $engine {
            fn deref_mut(&mut self) -> &mut Self::Target {
                &mut *self.simulation
            }
        }
    };
}

is_a_simulation!(EventDriven);
is_a_simulation!(MonteCarlo);
