//! Everything that is claimed about accuracy.

use std::fmt::Write as _;
use std::path::Path;
use std::time::Instant;

use stosszahl_model::snapshot::write_whole;
use stosszahl_model::{kinetic, transport};

use super::schemes::METHODS;
use super::subject::{ContactPoint, Exact, Work, claims};
use super::{cooling, elastic, exact, spheres, standing, unstable};
use crate::arguments::ValidateAll;
use crate::commands::say;
use crate::table::{Place, Row, markdown};
use crate::trial::ENDLESS;
use crate::{Done, Effort, Findings, Trial, Trouble, stress};

trials! {
    "literature" => literature,
        "do closed forms give printed numbers?", "to their rounding", ENDLESS;
    "exact" => exact::run,
        "does exact dynamics conserve and reverse, and are its equation of state and structure those of hard disks?",
        "every claim", ENDLESS;
    "engines" => engines,
        "are an elastic gas and a cooling one of both engines those of kinetic theory?", "every claim", ENDLESS;
    "homogeneous" => spheres::run,
        "do gases without positions cool as theory says in two and three dimensions, and is a published mixture found again?",
        "every claim", ENDLESS;
    "stress" => suites, "do the hard cases of all engines hold?", "no fault in any", ENDLESS;
    "monte-carlo" => monte_carlo,
        "does the default scheme hold what it claims of cooling, and without --quick of its elastic gas?",
        "no claim fails; some may stay open", ENDLESS;
}

/// A printed number: what it is, packing fraction, its value, how far it is rounded, and what the program says.
#[expect(clippy::unnecessary_wraps, reason = "as every trial")]
fn literature(log: &mut Findings) -> Done {
    let began = Instant::now();
    let chi = kinetic::contact_value(0.25);
    // d = 1 mm, packing 0.25, r = 0.8 and a root mean squared speed of 0.2047 m/s, in 1/s. The speed is itself rounded to
    // four digits, which moves 1/t0 by 0.15 %.
    let luding = 0.2047 / 2.0_f64.sqrt() / (0.001 * kinetic::haff_time(0.25, 0.8, chi));
    let length = transport::critical_length(0.25, chi, 0.8);
    let modes = "critical length of shear modes in d, r = 0.8, Enskog theory in first Sonine order";
    for (what, packing, value, rounding, found) in [
        (
            "1/t0 in 1/s (Luding, Müller & McNamara 1998)",
            0.25,
            23.24,
            0.04,
            luding,
        ),
        (modes, 0.25, 17.3, 0.09, length),
        (
            "contact value (Henderson 1975)",
            0.25,
            1.5833,
            0.0001,
            kinetic::henderson(0.25),
        ),
        (
            "a2 of disks, r = 0.8 (van Noije & Ernst 1998)",
            0.0,
            -0.0219,
            0.0001,
            kinetic::fourth_cumulant(2, 0.8),
        ),
    ] {
        let seconds = began.elapsed().as_secs_f64();
        let here = Place::new("literature", "theory", "closed form", packing, seconds);
        log.add(here.exact(what, value, found, rounding));
    }
    Ok(())
}

fn engines(log: &mut Findings) -> Done {
    let more = if log.effort.quick { 1 } else { 4 };
    // As many seeds as make every error less than half of its tolerance.
    let exact = Work {
        elastic: (1000, 40 * more),
        cooling: (400, 1000 * more),
    };
    let simulated = Work {
        elastic: (1000, 8 * more),
        cooling: (400, 32 * more),
    };
    claims(&Exact, exact, log)?;
    claims(&ContactPoint { copies: None }, simulated, log)
}

fn monte_carlo(log: &mut Findings) -> Done {
    log.effort.methods = METHODS.iter().filter(|m| m.default).copied().collect();
    cooling::run(log)?;
    if !log.effort.quick {
        elastic::run(log)?;
        unstable::run(log)?;
    }
    Ok(())
}

/// One claim for each hard case: no faults.
#[expect(clippy::unnecessary_wraps, reason = "as every trial")]
fn suites(log: &mut Findings) -> Done {
    for (name, trials) in [
        ("stress ed", stress::event_driven()),
        ("stress dsmc", stress::monte_carlo()),
        ("stress mixture", stress::mixtures()),
    ] {
        for trial in trials {
            let report = trial.run(&Effort::default());
            let here = Place::new("stress", name, trial.name, 0.0, report.seconds);
            log.add(here.exact("faults", 0.0, report.faults.len() as f64, 0.5));
        }
    }
    Ok(())
}

/// What came of the parts that were asked for.
#[derive(Default)]
struct Whole {
    rows: Vec<Row>,
    /// Parts that were not run, or not to the end, with the reason.
    missing: Vec<String>,
}

impl Whole {
    /// Claims that hold, that do not, and that are open: only the part of the default scheme may leave some.
    fn standing(&self) -> [usize; 3] {
        standing(&self.rows, |row| {
            ["cooling", "elastic", "unstable"].contains(&row.part)
        })
    }

    /// Whether all is well.
    fn holds(&self) -> bool {
        let [passed, failed, _] = self.standing();
        failed == 0 && self.missing.is_empty() && passed > 0
    }

    /// The last line: how many claims hold, and the word.
    fn verdict(&self) -> String {
        let [passed, failed, open] = self.standing();
        let word = if self.holds() {
            "pass"
        } else if failed == 0 && passed > 0 {
            "incomplete"
        } else {
            "FAIL"
        };
        let (claims, missing) = (passed + failed + open, self.missing.len());
        format!(
            "{claims} claims: {passed} hold, {failed} do not, {open} open; {missing} parts missing: {word}"
        )
    }

    fn write(&self, path: Option<&Path>, quick: bool) -> Done {
        let Some(path) = path else {
            return Ok(());
        };
        let option = if quick { " --quick" } else { "" };
        let mut text = format!(
            "# What holds\n\nWritten by `stosszahl-trials validate{option}`, version {}. A claim passes if the value is \
             within its tolerance and the standard error at most half of that; with a wider error it is unresolved, and what \
             is not claimed is measured. Starts and streams have fixed seeds, so only times differ between two runs.\n\n",
            env!("CARGO_PKG_VERSION")
        );
        text += &markdown(&self.rows);
        // Writing to a string cannot fail.
        for missing in &self.missing {
            let _ = writeln!(text, "\nMissing: {missing}.");
        }
        let _ = writeln!(text, "\n{}", self.verdict());
        Ok(write_whole(path, text.as_bytes())?)
    }
}

/// Runs the parts asked for, tells each row, writes the page, and says whether everything holds.
///
/// # Errors
/// [`Trouble`] if an option has no meaning, the page cannot be written, or a claim does not hold. A part that cannot be
/// measured is a claim that does not hold.
pub fn command(asked: &ValidateAll) -> Done {
    let budget = match &asked.budget {
        None => f64::INFINITY,
        Some(found) => humantime::parse_duration(found)
            .map_err(|source| Trouble::Budget {
                found: found.clone(),
                source,
            })?
            .as_secs_f64(),
    };
    let effort = Effort {
        quick: asked.quick,
        say: Some(say),
        ..Effort::default()
    };
    let began = Instant::now();
    let mut whole = Whole::default();
    // Before the work, not after it.
    whole.write(asked.out.as_deref(), asked.quick)?;
    for part in Trial::chosen(TRIALS, "part", &asked.part)? {
        let passed = began.elapsed().as_secs_f64();
        if passed > budget {
            let reason = format!("{}: the time was up after {passed:.0} s", part.name);
            whole.missing.push(reason);
        } else {
            let report = part.run(&effort);
            whole.rows.extend(report.rows);
            if !report.faults.is_empty() {
                whole
                    .missing
                    .push(format!("{}: {}", part.name, report.faults.join("; ")));
            }
        }
        whole.write(asked.out.as_deref(), asked.quick)?;
    }
    say(&whole.verdict());
    if whole.holds() {
        return Ok(());
    }
    let ([passed, failed, open], missing) = (whole.standing(), whole.missing.len());
    let claims = passed + failed + open;
    Err(Trouble::Failed(format!(
        "{failed} of {claims} claims do not hold, {missing} parts are missing"
    )))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::table::estimate;

    fn row(part: &'static str, found: f64, error: f64) -> Row {
        let place = Place::new(part, "a", "b", 0.25, 1.0);
        place.row("rate", 1.0, estimate(found, error), Some(0.01))
    }

    #[test]
    fn all_is_well_only_if_every_claim_of_every_part_holds() {
        let word = |part, rows: &[(f64, f64)], missing: bool| {
            let whole = Whole {
                rows: rows
                    .iter()
                    .map(|&(found, error)| row(part, found, error))
                    .collect(),
                missing: missing
                    .then(|| "stress: the time was up".to_owned())
                    .into_iter()
                    .collect(),
            };
            let text = whole.verdict();
            assert_eq!(whole.holds(), text.ends_with(": pass"), "{text}");
            text.rsplit(' ')
                .next()
                .map(str::to_owned)
                .unwrap_or_default()
        };
        let (good, wrong, wide) = ((1.0, 0.001), (1.1, 0.001), (1.0, 0.02));
        assert_eq!(word("engines", &[good], false), "pass");
        assert_eq!(word("engines", &[good, wrong], false), "FAIL");
        assert_eq!(word("engines", &[good, wide], false), "FAIL");
        assert_eq!(word("engines", &[good], true), "incomplete");
        assert_eq!(word("engines", &[], false), "FAIL");
        assert_eq!(word("cooling", &[good, wide], false), "pass");
    }
}
