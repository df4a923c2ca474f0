//! Trait of a simulation method under validation, and the claims about its elastic and cooling
//! gases.
//!
//! A [`CollisionMethod`] simulates a gas of equal disks and returns its temperature, its a2 and its
//! collisions. The claims use nothing else of the method. Tests of the validation therefore replace
//! it by a method with a planted fault.

use stosszahl_analysis::relaxation::unbiased_cumulant;
use stosszahl_analysis::statistics::Estimate;
use stosszahl_analysis::windows::{CollisionWindow, CollisionWindows};
use stosszahl_dsmc::Parameters;
use stosszahl_model::{Particles, Plane, Simulation, equation_of_state};
use stosszahl_theory::cooling;

use super::gas::{advance, energy, exact, monte_carlo, start};
use super::over_seeds;
use super::schemes::CONTACT_POINT;
use super::small_gas;
use crate::table::{RowPlace, mean};
use crate::{Done, TrialError, TrialLog};

/// Elastic collisions per disk before a gas is observed.
const EQUILIBRATE: f64 = 20.0;
/// Number of bins in the distribution of impact parameters.
const BINS: usize = 20;

/// Gas of equal disks that a method under validation simulates, with its sample times.
#[derive(Clone, Debug, PartialEq)]
pub struct ObservedGas {
    /// Number of disks of the gas under validation.
    pub disks: usize,
    /// Packing fraction of the gas under validation.
    pub packing: f64,
    /// Coefficient of restitution of the gas under validation.
    pub restitution: f64,
    /// Elastic collisions per disk before the gas is observed.
    pub equilibrate: f64,
    /// Sample times in rising order, in units of the diameter over the initial thermal speed.
    pub times: Vec<f64>,
}

/// Observations of a simulated gas: temperatures, fourth cumulants and collisions.
#[derive(Clone, Debug, PartialEq)]
pub struct GasCourse {
    /// Temperatures of the gas at the sample times, over the initial temperature.
    pub temperatures: Vec<f64>,
    /// Fourth cumulants a2 of the gas at the sample times, corrected for the finite number of
    /// particles.
    pub cumulants: Vec<f64>,
    /// Collision statistics from the start to the last sample time.
    pub window: CollisionWindow,
}

/// Simulation method under validation: exact dynamics, or a Monte Carlo scheme.
pub trait CollisionMethod: Sync {
    /// Returns the name of the simulation method in tables.
    fn table_name(&self) -> String;

    /// Simulates a gas from an equilibrium start that depends on the seed, and returns the
    /// observations.
    ///
    /// # Errors
    ///
    /// [`TrialError`] if the gas cannot be created or simulated.
    fn follow_gas(&self, gas: &ObservedGas, seed: u64) -> Result<GasCourse, TrialError>;
}

/// Runs a simulation to the sample times of a gas, and returns temperatures, cumulants and
/// collisions.
fn observed(gas: &ObservedGas, mut engine: Box<dyn Simulation>) -> Result<GasCourse, TrialError> {
    let end = gas.times.last().copied().unwrap_or(0.0);
    let mut windows = CollisionWindows::new(&[[0.0, end]], BINS, gas.disks, 0.0, 1.0);
    let (mut temperatures, mut cumulants) = (Vec::new(), Vec::new());
    for &time in &gas.times {
        advance(&mut *engine, time, &mut windows)?;
        let sample = energy(&engine.particles());
        windows.synchronise(time, sample.temperature);
        temperatures.push(sample.temperature);
        cumulants.push(unbiased_cumulant(
            sample.fourth_cumulant,
            engine.particle_count(),
        ));
    }
    let window = windows.windows.swap_remove(0);
    Ok(GasCourse {
        temperatures,
        cumulants,
        window,
    })
}

impl ObservedGas {
    /// Simulates the gas by a method with several seeds. Returns the observations, and the summed
    /// computing time \[s\].
    pub(super) fn follow_all(
        &self,
        subject: &dyn CollisionMethod,
        seeds: u64,
    ) -> Result<(Vec<GasCourse>, f64), TrialError> {
        over_seeds(0..seeds, |seed| subject.follow_gas(self, seed))
    }

    fn start(&self, seed: u64) -> Result<Particles, TrialError> {
        start(self.disks, self.packing, seed, self.equilibrate)
    }
}

/// Exact event-driven dynamics as a method under validation.
#[derive(Clone, Copy, Debug)]
pub struct ExactDynamics;

impl CollisionMethod for ExactDynamics {
    fn table_name(&self) -> String {
        "event-driven".into()
    }

    fn follow_gas(&self, gas: &ObservedGas, seed: u64) -> Result<GasCourse, TrialError> {
        observed(gas, exact(&gas.start(seed)?, gas.restitution)?)
    }
}

/// Monte Carlo scheme with given numerical parameters, as a method under validation.
#[derive(Clone, Copy, Debug)]
pub struct Simulated(pub Parameters);

impl CollisionMethod for Simulated {
    fn table_name(&self) -> String {
        self.0.scheme.name().into()
    }

    fn follow_gas(&self, gas: &ObservedGas, seed: u64) -> Result<GasCourse, TrialError> {
        let start = gas.start(seed)?;
        observed(gas, monte_carlo(&start, gas.restitution, self.0, seed)?)
    }
}

/// Default Monte Carlo scheme as a method under validation, with as many simulators per disk as it
/// recommends for molecular chaos.
#[derive(Clone, Copy, Debug)]
pub struct ContactPoint;

impl CollisionMethod for ContactPoint {
    fn table_name(&self) -> String {
        CONTACT_POINT.name.into()
    }

    fn follow_gas(&self, gas: &ObservedGas, seed: u64) -> Result<GasCourse, TrialError> {
        let Parameters { scheme, .. } = CONTACT_POINT.parameters;
        let parameters = Parameters {
            simulators_per_particle: Parameters::enough_for_chaos::<Plane>(
                scheme,
                gas.packing,
                1.0,
                gas.disks,
            ),
            ..CONTACT_POINT.parameters
        };
        Simulated(parameters).follow_gas(gas, seed)
    }
}

/// Number of disks and of seeds in the gases that test a method's claims.
#[derive(Clone, Copy, Debug)]
pub struct ClaimEffort {
    /// Number of disks and number of seeds of the elastic gas.
    pub elastic: (usize, u64),
    /// Number of disks and number of seeds of the cooling gas.
    pub cooling: (usize, u64),
}

/// Packing fraction of the elastic gas, at which all density corrections matter.
const DENSE: f64 = 0.25;
/// Packing fraction of the cooling gas. Recollisions of exact disks are negligible, and the box is
/// smaller than the 477 d at which shear modes grow.
const DILUTE: f64 = 0.01;
const RESTITUTION: f64 = 0.8;
/// Duration of the elastic gas's observation, in mean free times.
const ELASTIC_TIME: f64 = 20.0;
/// Times at which the cooling gas is sampled, in units of Haff's time `t_0`.
const COOLING_TIMES: [f64; 2] = [1.0, 3.0];

/// Averages a quantity over observed gases; gases without a value are left out.
fn mean_over(
    courses: &[GasCourse],
    of: impl Fn(&GasCourse) -> Option<f64>,
) -> Result<Estimate, TrialError> {
    mean(courses.iter().filter_map(of))
}

/// Simulates gases with a method under validation. Returns the observations, and the common part of
/// their table rows.
fn courses(
    subject: &dyn CollisionMethod,
    setting: &str,
    (disks, seeds): (usize, u64),
    (packing, restitution): (f64, f64),
    times: Vec<f64>,
) -> Result<(Vec<GasCourse>, RowPlace), TrialError> {
    let gas = ObservedGas {
        disks,
        packing,
        restitution,
        equilibrate: EQUILIBRATE,
        times,
    };
    let (courses, seconds) = gas.follow_all(subject, seeds)?;
    let place = RowPlace::new("engines", subject.table_name(), setting, packing, seconds);
    Ok((courses, place))
}

/// Tests elastic disks at packing 0.25 against kinetic theory: Enskog's collision rate within 1 %,
/// colliding pairs with `<g²>` = 6 T/m and uniform impact parameters, constant energy, Maxwellian
/// velocities.
fn elastic(subject: &dyn CollisionMethod, work: ClaimEffort, log: &mut TrialLog) -> Done {
    let enskog =
        equation_of_state::collision_rate(DENSE, equation_of_state::contact_value(DENSE), 0.0);
    let times = vec![ELASTIC_TIME / enskog];
    let (courses, here) = courses(subject, "elastic", work.elastic, (DENSE, 1.0), times)?;
    let disks = work.elastic.0;
    let chaos = |course: &GasCourse| course.window.dissipation(enskog, disks);
    // Pairs of N disks of momentum zero are fewer than N²/2 by 1/N and faster by half of that.
    let few = 1.0 / disks as f64;
    let rate = mean_over(&courses, |course| {
        Some(chaos(course)?.rate / (1.0 - few).sqrt())
    })?;
    let square = mean_over(&courses, |course| Some(chaos(course)?.speed * (1.0 - few)))?;
    let slope = mean_over(&courses, |course| course.window.slope())?;
    let energy = mean_over(&courses, |course| course.temperatures.first().copied())?;
    let cumulant = mean_over(&courses, |course| course.cumulants.first().copied())?;
    for (what, expected, found, tolerance) in [
        ("collision rate/Enskog", 1.0, rate, 0.01),
        ("<g²> of colliding pairs/(6 T/m)", 1.0, square, 0.01),
        ("slope of P(b/d)", 0.0, slope, 0.02),
        // A hundred thousand collisions, each of a few roundings.
        ("K/K(0)", 1.0, energy, 1e-9),
        ("a2", 0.0, cumulant, 0.03),
    ] {
        log.claim(&here, what, expected, found, Some(tolerance));
    }
    Ok(())
}

/// Tests homogeneous cooling of dilute disks with r = 0.8: the energy by Haff's law with the
/// relaxation of a2 within 1 %, and a2 of the Boltzmann equation.
fn cooling(subject: &dyn CollisionMethod, work: ClaimEffort, log: &mut TrialLog) -> Done {
    let haff = cooling::haff_time(
        DILUTE,
        RESTITUTION,
        equation_of_state::contact_value(DILUTE),
    );
    let times = COOLING_TIMES.map(|time| time * haff).to_vec();
    let gas = (DILUTE, RESTITUTION);
    let (courses, here) = courses(subject, "cooling", work.cooling, gas, times)?;
    for (index, time) in COOLING_TIMES.into_iter().enumerate() {
        let law = cooling::relaxing_haff_law(RESTITUTION, time);
        let ratio = mean_over(&courses, |course| {
            Some(course.temperatures.get(index)? / law)
        })?;
        log.claim(
            &here,
            format!("K/Haff at t/t0 = {time}"),
            1.0,
            ratio,
            Some(0.01),
        );
    }
    let found = mean_over(&courses, |course| course.cumulants.last().copied())?;
    let what = format!("a2 at t/t0 = {}", COOLING_TIMES[1]);
    log.claim(&here, what, small_gas::cumulant()?, found, Some(0.01));
    Ok(())
}

/// Tests all claims on a simulation method: an elastic and a cooling gas.
///
/// # Errors
///
/// [`TrialError`] if a gas cannot be created or simulated.
pub fn claims(subject: &dyn CollisionMethod, work: ClaimEffort, log: &mut TrialLog) -> Done {
    elastic(subject, work, log)?;
    cooling(subject, work, log)
}
