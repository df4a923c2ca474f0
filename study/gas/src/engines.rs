//! Engines that run a [`Gas`].

use std::ops::{Deref, DerefMut};

use stosszahl_dsmc::homogeneous::{Contact, Homogeneous, Pick};
use stosszahl_dsmc::{Boundaries, Clearance, Parameters, Scheme};
use stosszahl_ed::Dissipation;
use stosszahl_model::{Budget, Interrupt, Observer, Particles, Simulation};

use crate::{Gas, GasError};

/// Exact event-driven dynamics of a gas of disks. It is a [`Simulation`], by `Deref`.
pub struct EventDriven {
    gas: Gas,
    simulation: Box<dyn Simulation>,
}

impl EventDriven {
    /// Starts from a gas.
    ///
    /// # Errors
    /// [`GasError`] if the gas has no positions, or open faces, or disks that overlap.
    pub fn new(gas: &Gas) -> Result<Self, GasError> {
        Ok(Self {
            simulation: exact(gas, &gas.particles, Dissipation::Scene)?,
            gas: gas.clone(),
        })
    }

    /// Runs elastically until each disk has collided this many times, then restores the temperature and sets the time back.
    ///
    /// # Errors
    /// [`GasError`] if the gas cannot be run.
    pub fn equilibrate(&mut self, collisions_per_particle: f64) -> Result<(), GasError> {
        self.equilibrate_unless(collisions_per_particle, &Interrupt::default())?;
        Ok(())
    }

    /// The same, unless the interrupt is raised meanwhile: then the gas stays as it was, and the answer is false.
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
        let mut elastic = exact(&self.gas, &particles, Dissipation::Elastic)?;
        let pairs = 0.5 * collisions_per_particle * elastic.count() as f64;
        elastic.stop_on(interrupt);
        elastic.advance(f64::INFINITY, Budget::Collisions(pairs as u64), &mut ())?;
        if elastic.is_interrupted() {
            return Ok(false);
        }
        let factor = (temperature / elastic.temperature()).sqrt();
        if factor.is_finite() && factor > 0.0 {
            elastic.scale_velocities(factor)?;
        }
        particles = elastic.particles();
        particles.time = time;
        self.simulation = exact(&self.gas, &particles, Dissipation::Scene)?;
        Ok(true)
    }
}

fn exact(
    gas: &Gas,
    particles: &Particles,
    dissipation: Dissipation,
) -> Result<Box<dyn Simulation>, GasError> {
    if particles.lengths[0] <= 0.0 {
        return Err(GasError::Unfit {
            what: "exact dynamics of a gas without positions",
            instead: "use Monte Carlo, or a gas of disks",
        });
    }
    let boundaries = stosszahl_ed::Boundaries {
        walls: gas.walls.in_plane(),
        obstacles: Vec::new(),
        streams: gas.streams.branch(1),
    };
    let simulation = stosszahl_ed::simulate(&gas.grains, dissipation, &boundaries, particles)?;
    Ok(simulation)
}

/// Monte Carlo of a gas: in cells, or without positions. It is a [`Simulation`], by `Deref`.
pub struct MonteCarlo {
    gas: Gas,
    simulation: Box<dyn Simulation>,
}

impl MonteCarlo {
    /// Starts a gas without positions, such as [`Gas::spheres`].
    ///
    /// # Errors
    /// [`GasError`] if the gas spins or falls.
    pub fn new(gas: &Gas) -> Result<Self, GasError> {
        let temperature = match gas.particles.temperature() {
            // Nothing moves yet: a gas without positions draws its velocities itself.
            0.0 => 1.0,
            known => known,
        };
        let simulation = Homogeneous {
            dimension: gas.particles.dimension,
            grains: &gas.grains,
            count: gas.particles.all.len(),
            volume: gas.volume,
            contact: Contact::Enskog,
            temperatures: &[temperature],
            pick: Pick::AliasTables,
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
        })
    }

    /// Starts from the microstate of a gas, one simulator for each particle, with the defaults of a scheme.
    ///
    /// # Errors
    /// [`GasError`] if scheme and gas do not go together.
    pub fn from_state(gas: &Gas, scheme: Scheme) -> Result<Self, GasError> {
        Self::with(gas, Parameters::for_scheme(scheme))
    }

    /// The same with parameters of one's own.
    ///
    /// # Errors
    /// As [`Self::from_state`].
    pub fn with(gas: &Gas, parameters: Parameters) -> Result<Self, GasError> {
        let boundaries = Boundaries {
            walls: gas.walls.clone(),
            clearance: match parameters.scheme {
                Scheme::Boltzmann | Scheme::Collisionless => Clearance::Centre,
                _ => Clearance::Radius,
            },
            ..Boundaries::default()
        };
        let parts = stosszahl_dsmc::Gas {
            grains: &gas.grains,
            parameters,
            boundaries: &boundaries,
            streams: gas.streams.branch(2),
            displacements: !gas.grains.is_bounded,
        };
        let starts = std::slice::from_ref(&gas.particles);
        Ok(Self {
            simulation: stosszahl_dsmc::simulate(&parts, starts)?,
            gas: gas.clone(),
        })
    }
}

/// What both engines share.
macro_rules! is_a_simulation {
    ($engine:ty) => {
        impl $engine {
            /// The gas as it is now, one particle for each simulator: another engine can start from it.
            pub fn state(&self) -> Gas {
                Gas {
                    particles: self.simulation.particles(),
                    ..self.gas.clone()
                }
            }

            /// Advances to a time; the observer sees all collisions until then.
            ///
            /// # Errors
            /// [`GasError::Failure`] if the gas cannot go on, as in inelastic collapse.
            pub fn advance(
                &mut self,
                until: f64,
                observer: &mut dyn Observer,
            ) -> Result<(), GasError> {
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

#[cfg(test)]
mod tests {
    use super::*;
    use stosszahl_model::Collision;

    /// Asks for a pause at its first collision.
    struct Enough<'a>(&'a Interrupt);

    impl Observer for Enough<'_> {
        fn collisions(&mut self, _batch: &[Collision]) {
            self.0.raise();
        }
    }

    fn paused(engine: &mut dyn Simulation, until: f64) -> Result<f64, GasError> {
        let pause = Interrupt::default();
        engine.pause_on(&pause);
        assert!(!engine.advance(until, Budget::Unlimited, &mut Enough(&pause))?);
        assert!(!engine.is_interrupted());
        let time = engine.time();
        assert!(time > 0.0 && time < until);
        engine.pause_on(&Interrupt::default());
        Ok(time)
    }

    #[test]
    fn a_gas_goes_on_after_a_pause() -> Result<(), GasError> {
        let gas = Gas::disks(300).packing_fraction(0.25).build()?;
        let (mut alone, mut exact) = (EventDriven::new(&gas)?, EventDriven::new(&gas)?);
        let until = paused(&mut *exact, 1e4)? + 1.0;
        exact.advance(until, &mut ())?;
        alone.advance(until, &mut ())?;
        assert_eq!(exact.particles(), alone.particles());
        let mut chaos = MonteCarlo::from_state(&gas, Scheme::CONTACT_POINT)?;
        let mut spheres = MonteCarlo::new(&Gas::spheres(300).build()?)?;
        for engine in [&mut chaos, &mut spheres] {
            let before = engine.temperature();
            let until = paused(&mut **engine, 1e4)? + 1.0;
            engine.advance(until, &mut ())?;
            assert_eq!(engine.time(), until);
            // Rounding of some 1e5 collisions.
            assert!((engine.temperature() / before - 1.0).abs() < 1e-10);
        }
        Ok(())
    }

    #[test]
    fn a_start_of_ones_own_is_checked() -> Result<(), GasError> {
        let describe = || Gas::disks(2).packing_fraction(0.1).restitution(0.5);
        let gas = describe().build()?;
        let again = describe().start_from(gas.particles.clone()).build()?;
        assert_eq!(again.particles, gas.particles);
        assert_eq!(again.volume, gas.volume);
        let refused = |change: &dyn Fn(&mut Particles)| {
            let mut particles = gas.particles.clone();
            change(&mut particles);
            let made = describe().start_from(particles).build();
            assert!(matches!(made, Err(GasError::Start { .. })));
        };
        refused(&|one| one.all[1].position.x = 2.0 * one.lengths[0]);
        refused(&|one| one.all[0].velocity.y = f64::NAN);
        refused(&|one| one.dimension = 3);
        refused(&|one| one.time = f64::INFINITY);
        refused(&|one| one.all.clear());
        let mixed = describe()
            .and(3, 1.0, 2.0)
            .start_from(gas.particles.clone());
        assert!(matches!(mixed.build(), Err(GasError::Start { .. })));
        Ok(())
    }
}
