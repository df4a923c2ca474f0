//! What the validator asks of a method, whatever it is, and what it claims of the answers.
//!
//! A [`Subject`] follows a gas of equal disks and tells its temperature, its a2 and its collisions. The claims know nothing
//! else of it, so that a method with a planted fault can be put in its place: the tests of the validator do that.

use std::time::Instant;

use stosszahl_analysis::relaxation::unbiased_cumulant;
use stosszahl_analysis::windows::{Window, Windows};
use stosszahl_dsmc::{Parameters, Scheme, Unfollowed};
use stosszahl_ed as ed;
use stosszahl_model::{Plane, State, kinetic, transport};

use super::gas::{energy, monte_carlo, start};
use super::{cooling, over_seeds};
use crate::gas::{Disks, PLAIN, disks};
use crate::table::{Place, mean};
use crate::{Done, Findings, Trouble};

/// Elastic collisions of each disk before a gas is followed.
const EQUILIBRATE: f64 = 20.0;
/// Bins of the impact parameter.
const BINS: usize = 20;

/// A gas to follow.
#[derive(Clone, Debug, PartialEq)]
pub struct Gas {
    /// Number of disks.
    pub disks: usize,
    /// Packing fraction.
    pub packing: f64,
    /// Coefficient of restitution.
    pub restitution: f64,
    /// Elastic collisions of each disk before it is followed.
    pub equilibrate: f64,
    /// Rising times, in units of the diameter over the thermal speed of the start.
    pub times: Vec<f64>,
}

/// What a gas did.
#[derive(Clone, Debug, PartialEq)]
pub struct Course {
    /// Temperatures at the times; one at the start.
    pub temperatures: Vec<f64>,
    /// a2 at the times, without the bias of a finite number.
    pub cumulants: Vec<f64>,
    /// Collisions from the start to the last time.
    pub window: Window,
}

/// A method that makes disks collide.
pub trait Subject: Sync {
    /// Its name in tables.
    fn name(&self) -> String;

    /// Follows a gas in equilibrium from a start of its own, which the seed decides.
    ///
    /// # Errors
    /// [`Trouble`] if it cannot be made or followed.
    fn follow(&self, gas: &Gas, seed: u64) -> Result<Course, Trouble>;
}

/// Observes a gas that `advance` takes to each time.
fn observed(
    gas: &Gas,
    mut advance: impl FnMut(f64, &mut Windows) -> Result<State<Disks>, Trouble>,
) -> Result<Course, Trouble> {
    let end = gas.times.last().copied().unwrap_or(0.0);
    let mut windows = Windows::new(&[[0.0, end]], BINS, gas.disks, 0.0, 1.0);
    let (mut temperatures, mut cumulants) = (Vec::new(), Vec::new());
    for &time in &gas.times {
        let state = advance(time, &mut windows)?;
        let sample = energy(&state);
        windows.synchronise(time, sample.temperature);
        temperatures.push(sample.temperature);
        cumulants.push(unbiased_cumulant(
            sample.fourth_cumulant,
            state.bodies.len(),
        ));
    }
    let window = windows.windows.swap_remove(0);
    Ok(Course {
        temperatures,
        cumulants,
        window,
    })
}

/// Exact event-driven dynamics.
#[derive(Clone, Copy, Debug)]
pub struct Exact;

impl Subject for Exact {
    fn name(&self) -> String {
        "event-driven".into()
    }

    fn follow(&self, gas: &Gas, seed: u64) -> Result<Course, Trouble> {
        let mut checkpoint: ed::Checkpoint<Disks> =
            start(gas.disks, gas.packing, seed, gas.equilibrate)?.into();
        // The start may be a little off T = 1 for rounding only; energies are told over it all the same.
        let law = disks(gas.restitution)?;
        observed(gas, |time, windows| {
            let mut engine =
                ed::Engine::<Disks>::new(law.clone(), ed::Dissipation::Scene, checkpoint.clone())?;
            engine.advance(time, u64::MAX, windows)?;
            checkpoint = engine.checkpoint();
            Ok(checkpoint.state.clone())
        })
    }
}

/// A Monte Carlo scheme with its numerical choices.
#[derive(Clone, Copy, Debug)]
pub struct Simulated(pub Parameters);

impl Subject for Simulated {
    fn name(&self) -> String {
        self.0.scheme.name().into()
    }

    fn follow(&self, gas: &Gas, seed: u64) -> Result<Course, Trouble> {
        let state = start(gas.disks, gas.packing, seed, gas.equilibrate)?;
        let mut engine = monte_carlo::<Unfollowed>(&state, gas.restitution, self.0, seed)?;
        observed(gas, |time, windows| {
            engine.advance(time, u64::MAX, windows);
            Ok(engine.state())
        })
    }
}

/// The default Monte Carlo scheme.
#[derive(Clone, Copy, Debug)]
pub struct ContactPoint {
    /// Simulators for each disk; none for as many as the scheme says are enough.
    pub copies: Option<u32>,
}

impl Subject for ContactPoint {
    fn name(&self) -> String {
        "contact-point".into()
    }

    fn follow(&self, gas: &Gas, seed: u64) -> Result<Course, Trouble> {
        let scheme = Scheme::ContactPoint { radius: None };
        let enough = Parameters::enough_for_chaos::<Plane>(scheme, gas.packing, 1.0, gas.disks);
        let parameters = Parameters {
            scheme,
            simulators_per_disk: self.copies.unwrap_or(enough),
            steps_per_crossing: 8.0,
            largest_contact_value: 100.0,
            ..PLAIN
        };
        Simulated(parameters).follow(gas, seed)
    }
}

/// How much work the claims of a subject take.
#[derive(Clone, Copy, Debug)]
pub struct Work {
    /// Disks and seeds of the elastic gas.
    pub elastic: (usize, u64),
    /// Disks and seeds of the cooling gas.
    pub cooling: (usize, u64),
}

/// Packing of the elastic gas, where every correction for density counts.
const DENSE: f64 = 0.25;
/// Packing and restitution of the cooling gas: so dilute that recollisions of exact disks do not count, in a box of less than
/// the 477 d in which shear modes grow.
const DILUTE: f64 = 0.01;
const RESTITUTION: f64 = 0.8;
/// How long the elastic gas is followed, in mean free times.
const ELASTIC_TIME: f64 = 20.0;
/// When the cooling gas is looked at, over `t_0`.
const COOLING_TIMES: [f64; 2] = [1.0, 3.0];

/// The mean over courses; a course that has no answer counts for nothing.
fn over(
    courses: &[Course],
    of: impl Fn(&Course) -> Option<f64>,
) -> Result<stosszahl_analysis::statistics::Estimate, Trouble> {
    mean(courses.iter().filter_map(of))
}

/// Elastic disks at packing 0.25: the rate of Enskog's theory within 1 %, colliding pairs with `<g²>` = 6 T/m and uniform impact
/// parameters as molecular chaos has them, an unchanged energy, a Maxwellian.
fn elastic(subject: &dyn Subject, work: Work, log: &mut Findings) -> Done {
    let began = Instant::now();
    let (disks, seeds) = work.elastic;
    let enskog = kinetic::collision_rate(DENSE, kinetic::contact_value(DENSE), 0.0);
    let gas = Gas {
        disks,
        packing: DENSE,
        restitution: 1.0,
        equilibrate: EQUILIBRATE,
        times: vec![ELASTIC_TIME / enskog],
    };
    let (courses, _) = over_seeds(0..seeds, |seed| subject.follow(&gas, seed))?;
    let here = Place::new(
        "engines",
        subject.name(),
        "elastic",
        DENSE,
        began.elapsed().as_secs_f64(),
    );
    let chaos = |course: &Course| course.window.dissipation(enskog, disks);
    // Pairs of N disks of momentum zero are fewer than N²/2 by 1/N and faster by half of that.
    let few = 1.0 / disks as f64;
    let rate = over(&courses, |course| {
        Some(chaos(course)?.rate / (1.0 - few).sqrt())
    })?;
    let square = over(&courses, |course| Some(chaos(course)?.speed * (1.0 - few)))?;
    let slope = over(&courses, |course| course.window.slope())?;
    let energy = over(&courses, |course| course.temperatures.first().copied())?;
    let cumulant = over(&courses, |course| course.cumulants.first().copied())?;
    log.add(here.row("collision rate/Enskog", 1.0, rate, Some(0.01)));
    log.add(here.row("<g²> of colliding pairs/(6 T/m)", 1.0, square, Some(0.01)));
    log.add(here.row("slope of P(b/d)", 0.0, slope, Some(0.02)));
    // 1e-9: a hundred thousand collisions, each of a few roundings.
    log.add(here.row("K/K(0)", 1.0, energy, Some(1e-9)));
    log.add(here.row("a2", 0.0, cumulant, Some(0.03)));
    Ok(())
}

/// Homogeneous cooling of dilute disks with r = 0.8: K by Haff's law with the relaxation of a2 within 1 %, a2 of the Boltzmann
/// equation.
fn cooling(subject: &dyn Subject, work: Work, log: &mut Findings) -> Done {
    let began = Instant::now();
    let (disks, seeds) = work.cooling;
    let haff = kinetic::haff_time(DILUTE, RESTITUTION, kinetic::contact_value(DILUTE));
    let gas = Gas {
        disks,
        packing: DILUTE,
        restitution: RESTITUTION,
        equilibrate: EQUILIBRATE,
        times: COOLING_TIMES.map(|time| time * haff).to_vec(),
    };
    let (courses, _) = over_seeds(0..seeds, |seed| subject.follow(&gas, seed))?;
    let here = Place::new(
        "engines",
        subject.name(),
        "cooling",
        DILUTE,
        began.elapsed().as_secs_f64(),
    );
    for (index, time) in COOLING_TIMES.into_iter().enumerate() {
        let law = transport::relaxing_haff_law(RESTITUTION, time);
        let ratio = over(&courses, |course| {
            Some(course.temperatures.get(index)? / law)
        })?;
        log.add(here.row(format!("K/Haff at t/t0 = {time}"), 1.0, ratio, Some(0.01)));
    }
    let found = over(&courses, |course| course.cumulants.last().copied())?;
    let what = format!("a2 at t/t0 = {}", COOLING_TIMES[1]);
    log.add(here.row(what, cooling::cumulant()?, found, Some(0.01)));
    Ok(())
}

/// All claims on a subject.
///
/// # Errors
/// [`Trouble`] if a gas cannot be made or followed.
pub fn claims(subject: &dyn Subject, work: Work, log: &mut Findings) -> Done {
    elastic(subject, work, log)?;
    cooling(subject, work, log)
}
