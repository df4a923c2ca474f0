//! Test of homogeneous cooling against Haff's law, in a box too small for growing shear modes.
//!
//! The gas has 48 disks with r = 0.8 at packing 0.25, in a box of 12.3 d. Shear modes grow in boxes
//! wider than 17.3 d. Few particles have effects of their own. Shear modes below the threshold hold
//! more than their thermal share of the energy, 1/N. A pair of N particles with zero total momentum
//! is faster than two free ones. Both effects scale as 1/N with the number N of simulators, and are
//! below a thousandth with 64 per disk. With one simulator per disk the gas is compared with exact
//! dynamics of 48 disks, which has the same effects.

use stosszahl_analysis::statistics::Estimate;
use stosszahl_theory::cooling;

use super::schemes::{SchemeQuantity, SchemeSetting};
use super::small_gas::{DISKS, EQUILIBRATE, PACKING, RESTITUTION, cumulant, haff_time};
use super::subject::{ExactDynamics, GasCourse, ObservedGas, Simulated};
use crate::table::{RowPlace, against, divided_by, mean};
use crate::{Done, TrialError, TrialLog};

/// Sample times of the cooling gas, in units of Haff's time `t_0`.
const TIMES: [f64; 4] = [1.0, 2.0, 5.0, 10.0];
/// Simulators per disk at which effects of few simulators are below a thousandth.
const MANY: u32 = 64;

/// Returns the cooling gas of 48 disks, with its sample times.
fn small_gas() -> ObservedGas {
    ObservedGas {
        disks: DISKS,
        packing: PACKING,
        restitution: RESTITUTION,
        equilibrate: EQUILIBRATE,
        times: TIMES.map(|time| time * haff_time()).to_vec(),
    }
}

/// Averages the temperature over the replicas at the sample time of index `time`.
fn temperature(courses: &[GasCourse], time: usize) -> Result<Estimate, TrialError> {
    mean(courses.iter().map(|course| course.temperatures[time]))
}

/// Averages the fourth cumulant a2 over sample times and replicas. It is relaxed to 1 - 2^-6.4 at
/// `t_0`, so the mean is 0.3 % too small.
fn mean_cumulant(courses: &[GasCourse]) -> Result<Estimate, TrialError> {
    let cumulants = courses.iter().map(|course| &course.cumulants);
    mean(cumulants.map(|all| all.iter().sum::<f64>() / all.len() as f64))
}

fn law(time: f64) -> f64 {
    cooling::relaxing_haff_law(RESTITUTION, time)
}

/// Tests the cooling of exact disks, and of all Monte Carlo schemes at all settings, against Haff's
/// law.
pub(super) fn test_cooling(log: &mut TrialLog) -> Done {
    let few = if log.effort.quick { 400 } else { 10_000 };
    let many = if log.effort.quick { 16 } else { 400 };
    let gas = small_gas();
    let (exact, seconds) = gas.follow_all(&ExactDynamics, few)?;
    let simplest = cooling::fourth_cumulant(2, RESTITUTION);
    let cumulant = cumulant()?;
    let here =
        RowPlace::new("cooling", "event-driven", "48 disks", PACKING, seconds).only_default(false);
    for (index, time) in TIMES.into_iter().enumerate() {
        let found = divided_by(temperature(&exact, index)?, law(time));
        log.claim(&here, format!("K/Haff at t/t0 = {time}"), 1.0, found, None);
    }
    log.claim(&here, "a2", cumulant, mean_cumulant(&exact)?, None);
    for method in log.effort.methods.clone() {
        for setting in SchemeSetting::ALL {
            let mut parameters = method.parameters_at(setting);
            if setting == SchemeSetting::Refined {
                parameters.simulators_per_particle = parameters.simulators_per_particle.max(MANY);
            }
            let copies = parameters.simulators_per_particle;
            let replicas = (few / u64::from(copies)).max(many);
            let (found, seconds) = gas.follow_all(&Simulated(parameters), replicas)?;
            let name = format!("{} {copies}", setting.name());
            let here = RowPlace::new("cooling", method.name, name, PACKING, seconds);
            let here = here.only_default(method.default);
            let claim = |quantity, tolerance| method.claims(setting, quantity).then_some(tolerance);
            for (index, time) in TIMES.into_iter().enumerate() {
                let own = temperature(&found, index)?;
                let (what, ratio) = if copies == 1 {
                    (
                        "K/K of event-driven",
                        against(own, temperature(&exact, index)?),
                    )
                } else {
                    ("K/Haff", divided_by(own, law(time)))
                };
                let what = format!("{what} at t/t0 = {time}");
                log.claim(
                    &here,
                    what,
                    1.0,
                    ratio,
                    claim(SchemeQuantity::Cooling, 0.01),
                );
            }
            let found = mean_cumulant(&found)?;
            log.claim(
                &here,
                "a2",
                cumulant,
                found,
                claim(SchemeQuantity::Cumulant, 0.002),
            );
            log.claim(&here, "a2, first Sonine order", simplest, found, None);
        }
    }
    Ok(())
}
