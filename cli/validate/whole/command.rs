//! The command line of the whole validation.

use std::fmt::Write as _;
use std::path::Path;
use std::time::Instant;

use stosszahl_model::snapshot::write_whole;

use super::Chapter;
use crate::arguments::ValidateAll;
use crate::validate::ValidateError;
use crate::validate::table::{Row, Verdict, line, markdown};
use crate::words::duration;

/// What came of the parts that were asked for.
#[derive(Default)]
struct Findings {
    rows: Vec<Row>,
    /// Claims that passed, that do not hold, and that a part which need not resolve everything has left open.
    passed: usize,
    failed: usize,
    open: usize,
    /// Parts that were not run, or not to the end, with the reason.
    missing: Vec<String>,
}

impl Findings {
    fn add(&mut self, chapter: Chapter, rows: Vec<Row>) {
        for row in rows.iter().filter(|row| row.default) {
            match row.verdict {
                Verdict::Pass => self.passed += 1,
                Verdict::Unresolved if !chapter.resolves() => self.open += 1,
                Verdict::Fail | Verdict::Unresolved => self.failed += 1,
                Verdict::Measured => {}
            }
        }
        self.rows.extend(rows);
    }

    /// Whether all is well.
    fn holds(&self) -> bool {
        self.failed == 0 && self.missing.is_empty() && self.passed > 0
    }

    /// The last line: how many claims hold, and the word.
    fn verdict(&self) -> String {
        let word = if self.holds() {
            "pass"
        } else if self.failed == 0 && self.passed > 0 {
            "incomplete"
        } else {
            "FAIL"
        };
        let Self {
            passed,
            failed,
            open,
            missing,
            ..
        } = self;
        format!(
            "{} claims: {passed} hold, {failed} do not, {open} open; {} parts missing: {word}",
            passed + failed + open,
            missing.len()
        )
    }

    fn page(&self, quick: bool) -> String {
        let mut text = String::from("# What holds\n\n");
        let command = if quick {
            "stosszahl validate --quick"
        } else {
            "stosszahl validate"
        };
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "Written by `{command}`, version {}. A claim passes if the value is within its tolerance and the standard error at \
             most half of that; with a wider error it is unresolved, and what is not claimed is measured. Starts and streams \
             have fixed seeds, so only times differ between two runs.\n",
            env!("CARGO_PKG_VERSION")
        );
        text += &markdown(&self.rows);
        for missing in &self.missing {
            let _ = writeln!(text, "\nMissing: {missing}.");
        }
        let _ = writeln!(text, "\n{}", self.verdict());
        text
    }

    fn write(&self, path: Option<&Path>, quick: bool) -> Result<(), ValidateError> {
        match path {
            Some(path) => Ok(write_whole(path, self.page(quick).as_bytes())?),
            None => Ok(()),
        }
    }
}

/// Runs the parts asked for, tells each row, writes the page, and says whether everything holds.
///
/// # Errors
/// [`ValidateError`] if an option has no meaning, the page cannot be written, or a claim does not hold. A part that cannot be
/// measured is a claim that does not hold.
pub fn command(arguments: &ValidateAll, say: impl Fn(&str) + Sync) -> Result<(), ValidateError> {
    let budget = match &arguments.budget {
        None => f64::INFINITY,
        Some(text) => duration(text).ok_or_else(|| ValidateError::Budget {
            found: text.clone(),
        })?,
    };
    let chapters = if arguments.part.is_empty() {
        &Chapter::ALL[..]
    } else {
        &arguments.part
    };
    let began = Instant::now();
    let mut findings = Findings::default();
    // Before the work, not after it.
    findings.write(arguments.out.as_deref(), arguments.quick)?;
    for chapter in chapters {
        let passed = began.elapsed().as_secs_f64();
        if passed > budget {
            findings.missing.push(format!(
                "{}: the time was up after {passed:.0} s",
                chapter.name()
            ));
            continue;
        }
        match chapter.run(arguments.quick, &|row| say(&line(row))) {
            Ok(rows) => findings.add(*chapter, rows),
            Err(trouble) => findings
                .missing
                .push(format!("{}: {trouble}", chapter.name())),
        }
        findings.write(arguments.out.as_deref(), arguments.quick)?;
    }
    findings.write(arguments.out.as_deref(), arguments.quick)?;
    say(&findings.verdict());
    if findings.holds() {
        return Ok(());
    }
    Err(ValidateError::Whole {
        failed: findings.failed,
        claims: findings.passed + findings.failed + findings.open,
        missing: findings.missing.len(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::validate::table::Place;
    use stosszahl_analysis::statistics::Estimate;

    fn row(found: f64, error: f64) -> Row {
        let place = Place {
            part: "engines",
            scheme: "a".into(),
            setting: "b".into(),
            packing: 0.25,
            seconds: 1.0,
            default: true,
        };
        let found = Estimate {
            value: found,
            standard_error: Some(error),
            replicas: 4,
        };
        place.row("rate", 1.0, found, Some(0.01))
    }

    fn verdict(chapter: Chapter, rows: &[Row], missing: bool) -> (bool, String) {
        let mut findings = Findings::default();
        findings.add(chapter, rows.to_vec());
        if missing {
            findings.missing.push("stress: the time was up".into());
        }
        (findings.holds(), findings.verdict())
    }

    #[test]
    fn all_is_well_only_if_every_claim_of_every_part_holds() {
        let (good, wrong, wide) = (row(1.0, 0.001), row(1.1, 0.001), row(1.0, 0.02));
        let word = |chapter, rows: &[Row], missing| {
            let (holds, text) = verdict(chapter, rows, missing);
            assert_eq!(holds, text.ends_with(": pass"), "{text}");
            text.rsplit(' ').next().map(str::to_owned)
        };
        let engines = Chapter::Engines;
        assert_eq!(
            word(engines, std::slice::from_ref(&good), false).as_deref(),
            Some("pass")
        );
        assert_eq!(
            word(engines, &[good.clone(), wrong], false).as_deref(),
            Some("FAIL")
        );
        assert_eq!(
            word(engines, &[good.clone(), wide.clone()], false).as_deref(),
            Some("FAIL")
        );
        assert_eq!(
            word(engines, std::slice::from_ref(&good), true).as_deref(),
            Some("incomplete")
        );
        assert_eq!(word(engines, &[], false).as_deref(), Some("FAIL"));
        let open = word(Chapter::MonteCarlo, &[good, wide], false);
        assert_eq!(open.as_deref(), Some("pass"));
    }
}
