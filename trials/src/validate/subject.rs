//! Interface of a method under validation, and the claims about its results.
//!
//! A [`CollisionMethod`] follows a gas of equal disks and returns its temperature, its a2 and its
//! collisions. The claims know nothing else of it, so that a method with a planted fault can be put
//! in its place: the tests of the validator do that.

use stosszahl_analysis::relaxation::unbiased_cumulant;
use stosszahl_analysis::statistics::Estimate;
use stosszahl_analysis::windows::{CollisionWindow, CollisionWindows};
use stosszahl_dsmc::Parameters;
use stosszahl_model::{Particles, Plane, Simulation, kinetic, transport};

use super::gas::{advance, energy, exact, monte_carlo, start};
use super::over_seeds;
use super::schemes::CONTACT_POINT;
use super::small_gas;
use crate::table::{RowPlace, mean};
use crate::{Done, TrialError, TrialLog};

/// Elastic collisions of each disk before a gas is followed.
const EQUILIBRATE: f64 = 20.0;
/// Number of bins of the impact parameter.
const BINS: usize = 20;

/// Gas to follow.
#[derive(Clone, Debug, PartialEq)]
pub struct ObservedGas {
    /// Number of disks.
    pub disks: usize,
    /// Packing fraction of the gas.
    pub packing: f64,
    /// Coefficient of restitution.
    pub restitution: f64,
    /// Elastic collisions of each disk before the gas is followed.
    pub equilibrate: f64,
    /// Rising times, in units of the diameter over the thermal speed of the start.
    pub times: Vec<f64>,
}

/// Results of following a gas.
#[derive(Clone, Debug, PartialEq)]
pub struct GasCourse {
    /// Temperatures at the times, over the temperature of the start.
    pub temperatures: Vec<f64>,
    /// a2 at the times, without the bias of a finite number.
    pub cumulants: Vec<f64>,
    /// Collisions from the start to the last time.
    pub window: CollisionWindow,
}

/// Method by which disks collide: exact dynamics, or a Monte Carlo scheme.
pub trait CollisionMethod: Sync {
    /// Returns the name in tables.
    fn table_name(&self) -> String;

    /// Follows a gas from an equilibrium start, which the seed decides.
    ///
    /// # Errors
    /// [`TrialError`] if it cannot be made or followed.
    fn follow_gas(&self, gas: &ObservedGas, seed: u64) -> Result<GasCourse, TrialError>;
}

/// Follows a gas and observes it.
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
    /// Follows the gas with a subject from some seeds; returns the courses, and the seconds that all
    /// took.
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

/// Exact event-driven dynamics.
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

/// Monte Carlo scheme with its numerical choices.
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

/// The default Monte Carlo scheme with as many simulators for each disk as it says are enough.
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

/// Amount of work of the claims of a subject.
#[derive(Clone, Copy, Debug)]
pub struct ClaimEffort {
    /// Number of disks and of seeds of the elastic gas.
    pub elastic: (usize, u64),
    /// Number of disks and of seeds of the cooling gas.
    pub cooling: (usize, u64),
}

/// Packing of the elastic gas, where every correction for density counts.
const DENSE: f64 = 0.25;
/// Packing and restitution of the cooling gas: so dilute that recollisions of exact disks do not
/// count, in a box of less than the 477 d in which shear modes grow.
const DILUTE: f64 = 0.01;
const RESTITUTION: f64 = 0.8;
/// Time for which the elastic gas is followed, in mean free times.
const ELASTIC_TIME: f64 = 20.0;
/// Sample times of the cooling gas, over `t_0`.
const COOLING_TIMES: [f64; 2] = [1.0, 3.0];

/// Mean over courses; courses without a value are left out.
fn mean_over(
    courses: &[GasCourse],
    of: impl Fn(&GasCourse) -> Option<f64>,
) -> Result<Estimate, TrialError> {
    mean(courses.iter().filter_map(of))
}

/// Follows gases with a subject; returns their courses, and the place of its rows.
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

/// Tests elastic disks at packing 0.25: the rate of Enskog's theory within 1 %, colliding pairs
/// with `<g²>` = 6 T/m and uniform impact parameters as in molecular chaos, constant energy, a
/// Maxwellian.
fn elastic(subject: &dyn CollisionMethod, work: ClaimEffort, log: &mut TrialLog) -> Done {
    let enskog = kinetic::collision_rate(DENSE, kinetic::contact_value(DENSE), 0.0);
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

/// Tests homogeneous cooling of dilute disks with r = 0.8: K by Haff's law with the relaxation of
/// a2 within 1 %, a2 of the Boltzmann equation.
fn cooling(subject: &dyn CollisionMethod, work: ClaimEffort, log: &mut TrialLog) -> Done {
    let haff = kinetic::haff_time(DILUTE, RESTITUTION, kinetic::contact_value(DILUTE));
    let times = COOLING_TIMES.map(|time| time * haff).to_vec();
    let gas = (DILUTE, RESTITUTION);
    let (courses, here) = courses(subject, "cooling", work.cooling, gas, times)?;
    for (index, time) in COOLING_TIMES.into_iter().enumerate() {
        let law = transport::relaxing_haff_law(RESTITUTION, time);
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

/// Tests all claims on a subject.
///
/// # Errors
/// [`TrialError`] if a gas cannot be made or followed.
pub fn claims(subject: &dyn CollisionMethod, work: ClaimEffort, log: &mut TrialLog) -> Done {
    elastic(subject, work, log)?;
    cooling(subject, work, log)
}
