//! All claims about accuracy, the parts of `stosszahl-trials validate`: literature values, both
//! engines, gases without positions and hard cases.

use std::time::Instant;
use stosszahl_model::equation_of_state;
use stosszahl_theory::cooling::{fourth_cumulant, haff_time};
use stosszahl_theory::transport;

use super::schemes::METHODS;
use super::subject::{ClaimEffort, ContactPoint, ExactDynamics, claims};
use super::{cooling, elastic, exact, spheres, unstable};
use crate::stress::StressEngine;
use crate::table::RowPlace;
use crate::trial::ENDLESS;
use crate::{Done, Effort, TrialLog};

trials! {
    "literature" => literature,
        "do closed forms give printed numbers?", "to their rounding", ENDLESS;
    "exact" => exact::test_exact,
        "does exact dynamics conserve and reverse, and are its equation of state, structure and contact values those of hard disks?",
        "every claim", ENDLESS;
    "engines" => engines,
        "are an elastic gas and a cooling one of both engines those of kinetic theory?", "every claim", ENDLESS;
    "homogeneous" => spheres::test_spheres,
        "do gases without positions cool as theory says in two and three dimensions, and is a published mixture found again?",
        "every claim", ENDLESS;
    "stress" => suites, "do the hard cases of all engines hold?", "no fault in any", ENDLESS;
    "monte-carlo" => monte_carlo,
        "does the default scheme hold what it claims of cooling, and without --quick of its elastic gas?",
        "no claim fails; some may stay open", ENDLESS;
}

/// Compares published numbers with those of the program, within the rounding of each.
#[expect(clippy::unnecessary_wraps, reason = "as every trial")]
fn literature(log: &mut TrialLog) -> Done {
    let began = Instant::now();
    let chi = equation_of_state::contact_value(0.25);
    // d = 1 mm, packing 0.25, r = 0.8 and a root mean squared speed of 0.2047 m/s, in 1/s. The
    // speed is itself rounded to four digits, which moves 1/t0 by 0.15 %.
    let luding = 0.2047 / 2.0_f64.sqrt() / (0.001 * haff_time(0.25, 0.8, chi));
    let length = transport::critical_length(0.25, chi, 0.8);
    let cumulant = fourth_cumulant(2, 0.8);
    let rate = "1/t0 in 1/s (Luding, Müller & McNamara 1998)";
    let modes = "critical length of shear modes in d, r = 0.8, Enskog theory in first Sonine order";
    let contact = "contact value (Henderson 1975)";
    for (what, packing, value, rounding, found) in [
        (rate, 0.25, 23.24, 0.04, luding),
        (modes, 0.25, 17.3, 0.09, length),
        (
            contact,
            0.25,
            1.5833,
            0.0001,
            equation_of_state::henderson(0.25),
        ),
        (
            "a2 of disks, r = 0.8 (van Noije & Ernst 1998)",
            0.0,
            -0.0219,
            0.0001,
            cumulant,
        ),
    ] {
        let seconds = began.elapsed().as_secs_f64();
        let here = RowPlace::new("literature", "theory", "closed form", packing, seconds);
        log.add(here.exact(what, value, found, rounding));
    }
    Ok(())
}

fn engines(log: &mut TrialLog) -> Done {
    let more = if log.effort.quick { 1 } else { 4 };
    // Enough seeds for errors below half of the tolerances.
    let exact = ClaimEffort {
        elastic: (1000, 40 * more),
        cooling: (400, 1000 * more),
    };
    let simulated = ClaimEffort {
        elastic: (1000, 8 * more),
        cooling: (400, 32 * more),
    };
    claims(&ExactDynamics, exact, log)?;
    claims(&ContactPoint, simulated, log)
}

fn monte_carlo(log: &mut TrialLog) -> Done {
    log.effort.methods = METHODS.iter().filter(|m| m.default).copied().collect();
    cooling::test_cooling(log)?;
    if !log.effort.quick {
        elastic::test_elastic(log)?;
        unstable::test_unstable(log)?;
    }
    Ok(())
}

/// Runs all hard cases, and records for each the claim that it has no faults.
#[expect(clippy::unnecessary_wraps, reason = "as every trial")]
fn suites(log: &mut TrialLog) -> Done {
    for (name, engine) in [
        ("stress ed", StressEngine::Ed),
        ("stress dsmc", StressEngine::Dsmc),
        ("stress mixture", StressEngine::Mixture),
    ] {
        for trial in engine.cases() {
            let report = trial.run_trial(&Effort::default());
            let here = RowPlace::new("stress", name, trial.name, 0.0, report.seconds);
            log.add(here.exact("faults", 0.0, report.faults.len() as f64, 0.5));
        }
    }
    Ok(())
}
