//! The verdict in words.

mod driven;
mod species;

use stosszahl_analysis::compare::Verdict as Test;

use crate::export::{Tables, theory_quotients};
use crate::manifest::{Verdict, VerdictKind};
use crate::run::{Finished, Replica};
use crate::setup::{Setup, TimeUnit};
use crate::tables::{ComparisonRow, DissipationRow, ImpactSummaryRow};

/// An engine's name as a reader says it.
fn title(engine: &str) -> String {
    match engine {
        "ed" => "ED".to_owned(),
        other => other
            .strip_prefix("dsmc-")
            .map_or_else(|| other.to_owned(), |scheme| format!("DSMC ({scheme})")),
    }
}

pub(crate) fn with_error(value: f64, error: Option<f64>) -> String {
    match error {
        Some(error) => format!("{value:.4} ± {error:.4}"),
        None => format!("{value:.4} (error unknown)"),
    }
}

/// Everything that the tables say, most important first.
pub fn verdicts(setup: &Setup, replicas: &[Replica], tables: &Tables) -> Vec<Verdict> {
    let mut list = Vec::new();
    list.extend(start(replicas));
    let mut pairs: Vec<(&str, &str)> = Vec::new();
    for row in &tables.comparison {
        if !pairs.contains(&(&row.engine_a, &row.engine_b)) {
            pairs.push((&row.engine_a, &row.engine_b));
        }
    }
    for (a, b) in pairs {
        let rows: Vec<&ComparisonRow> = tables
            .comparison
            .iter()
            .filter(|row| row.engine_a == a && row.engine_b == b)
            .collect();
        if setup.time_unit == TimeUnit::MeanFreeTime {
            // Elastic engines keep their energy, each by itself; what can differ is how often they collide.
            list.extend((a == "ed").then(|| split(setup, tables, a, b)).flatten());
            continue;
        }
        let verdict = pair(setup, &title(a), &title(b), &rows);
        let differ = verdict.kind == VerdictKind::Differ;
        list.push(verdict);
        if a == "ed" && differ {
            list.extend(split(setup, tables, a, b));
        }
    }
    for (index, engine) in setup.case.engines.iter().enumerate() {
        let runs: Vec<&Finished> = replicas
            .iter()
            .map(|replica| &replica.engines[index])
            .collect();
        list.extend(theory(setup, &title(engine.name()), &runs));
        list.extend(driven::verdicts(setup, &title(engine.name()), &runs));
        list.extend(species::verdicts(setup, &title(engine.name()), &runs));
    }
    for engine in &setup.case.engines {
        let rows: Vec<&ImpactSummaryRow> = tables
            .impact_summary
            .iter()
            .filter(|row| row.engine == engine.name())
            .collect();
        list.push(impact(setup, &title(engine.name()), &rows));
    }
    list
}

/// A start that is not equilibrated is said first.
fn start(replicas: &[Replica]) -> Option<Verdict> {
    let bad: Vec<String> = replicas
        .iter()
        .enumerate()
        .filter(|(_, replica)| !replica.start.equilibrated)
        .map(|(index, replica)| {
            let failed: Vec<&str> = replica
                .start
                .tests
                .iter()
                .filter(|test| test.passed == Some(false))
                .map(|test| test.name.as_str())
                .collect();
            let why = if failed.is_empty() {
                "no elastic collisions asked for or possible".into()
            } else {
                failed.join(", ")
            };
            format!("replica {index} ({why})")
        })
        .collect();
    (!bad.is_empty()).then(|| Verdict {
        topic: "start".into(),
        sentence: format!(
            "The start is not equilibrated in {}; early differences may be its memory.",
            bad.join("; ")
        ),
        kind: VerdictKind::Warning,
    })
}

fn test_of(row: &ComparisonRow) -> Test {
    [Test::Agree, Test::Higher, Test::Lower, Test::Undecided]
        .into_iter()
        .find(|test| test.name() == row.verdict)
        .unwrap_or(Test::Undecided)
}

fn pair(setup: &Setup, a: &str, b: &str, rows: &[&ComparisonRow]) -> Verdict {
    let times: Vec<f64> = rows.iter().map(|row| row.time_over_t0).collect();
    let tests: Vec<Test> = rows.iter().map(|row| test_of(row)).collect();
    let last = rows[rows.len() - 1];
    let quotient = with_error(last.quotient, last.quotient_se);
    let course = course(&times, &tests, "more", "less");
    let sentence = format!(
        "Energy of {a} against {b}: {course}. At t/t0 = {} the quotient of the energies is {quotient}. (Paired t tests over \
         replicas, chance of any false alarm {}.)",
        last.time_over_t0, setup.case.verdict.false_alarm
    );
    Verdict {
        topic: format!("energy, {a} against {b}"),
        sentence,
        kind: kind(&tests),
    }
}

/// Agreement at all times, some difference, or neither.
fn kind(tests: &[Test]) -> VerdictKind {
    if tests
        .iter()
        .any(|test| matches!(test, Test::Higher | Test::Lower))
    {
        VerdictKind::Differ
    } else if tests.iter().all(|test| *test == Test::Agree) {
        VerdictKind::Agree
    } else {
        VerdictKind::Undecided
    }
}

/// What a series of tests says, in order of time: stretches of equal outcomes after the start.
fn course(times: &[f64], tests: &[Test], more: &str, less: &str) -> String {
    let mut stretches: Vec<(Test, f64, f64)> = Vec::new();
    for (&time, &test) in times.iter().zip(tests).skip(1) {
        match stretches.last_mut() {
            Some((known, _, end)) if *known == test => *end = time,
            _ => stretches.push((test, time, time)),
        }
    }
    let said: Vec<String> = stretches
        .iter()
        .map(|&(test, start, end)| {
            let outcome = match test {
                Test::Agree => "no difference",
                Test::Higher => more,
                Test::Lower => less,
                Test::Undecided => "undecided",
            };
            if start == end {
                format!("{outcome} at t/t0 = {start:.3}")
            } else {
                format!("{outcome} from t/t0 = {start:.3} to {end:.3}")
            }
        })
        .collect();
    said.join(", ")
}

/// A factor of the dissipation identity with its standard error.
type Ratio = fn(&DissipationRow) -> (Option<f64>, Option<f64>);

const TOTAL: Ratio = |row| (row.dissipation_ratio, row.dissipation_ratio_se);
const RATE: Ratio = |row| (row.rate_ratio, row.rate_ratio_se);
const SPEED: Ratio = |row| (row.speed_ratio, row.speed_ratio_se);
const IMPACT: Ratio = |row| (row.impact_ratio, row.impact_ratio_se);
const CORRELATION: Ratio = |row| (row.correlation_ratio, row.correlation_ratio_se);

/// What a difference in cooling is made of, in the last window.
fn split(setup: &Setup, tables: &Tables, a: &str, b: &str) -> Option<Verdict> {
    let last = |engine: &str| tables.dissipation.iter().rfind(|row| row.engine == engine);
    let (first, second): (&DissipationRow, &DissipationRow) = (last(a)?, last(b)?);
    let quotient = |x: Option<f64>, y: Option<f64>| Some(x? / y?);
    let error = |x: Option<f64>, dx: Option<f64>, y: Option<f64>, dy: Option<f64>| {
        let (x, y) = (x?, y?);
        Some((x / y) * ((dx? / x).powi(2) + (dy? / y).powi(2)).sqrt())
    };
    let factor = |of: Ratio| {
        let ((x, dx), (y, dy)) = (of(first), of(second));
        Some(with_error(quotient(x, y)?, error(x, dx, y, dy)))
    };
    let total = factor(TOTAL)?;
    let rate = factor(RATE)?;
    let speed = factor(SPEED)?;
    let impact = factor(IMPACT)?;
    let correlation = factor(CORRELATION)?;
    if setup.time_unit == TimeUnit::MeanFreeTime {
        return Some(Verdict {
            topic: format!("collisions, {} against {}", title(a), title(b)),
            sentence: format!(
                "At t/t0 from {} to {}, disks of {} collide {rate} times as often as those of {}; the squared relative \
                 speed of colliding pairs has the ratio {speed}.",
                first.window_start,
                first.window_end,
                title(a),
                title(b)
            ),
            kind: VerdictKind::Differ,
        });
    }
    Some(Verdict {
        topic: format!(
            "what the difference of {} and {} is made of",
            title(a),
            title(b)
        ),
        sentence: format!(
            "At t/t0 from {} to {}, at the same temperature, {} loses energy {total} times as fast as {}: collision rate \
             {rate}, squared relative speed of colliding pairs {speed}, impact parameters {impact}, correlation of the \
             two {correlation}.",
            first.window_start,
            first.window_end,
            title(a),
            title(b)
        ),
        kind: VerdictKind::Differ,
    })
}

fn theory(setup: &Setup, engine: &str, runs: &[&Finished]) -> Option<Verdict> {
    let quotients = theory_quotients(setup, runs);
    let times = setup.case.sample_times();
    let tests: Vec<Test> = quotients.iter().map(|quotient| quotient.verdict).collect();
    let last = quotients.last()?;
    let end = times[times.len() - 1];
    let value = with_error(last.quotient.value, last.quotient.standard_error);
    let course = course(&times, &tests, "above", "below");
    let sentence = format!(
        "{engine} against Haff's law: {course}; at the end, t/t0 = {end}, K/K_Haff = {value}."
    );
    let kind = kind(&tests);
    Some(Verdict {
        topic: format!("{engine} against theory"),
        sentence,
        kind,
    })
}

fn impact(setup: &Setup, engine: &str, rows: &[&ImpactSummaryRow]) -> Verdict {
    let span = |row: &ImpactSummaryRow| {
        let slope = row.slope.map_or(String::new(), |slope| {
            format!(", slope {}", with_error(slope, row.slope_se))
        });
        format!(
            "{} to {} ({}{slope})",
            row.window_start, row.window_end, row.verdict
        )
    };
    let all: Vec<String> = rows.iter().map(|row| span(row)).collect();
    let broken = rows.iter().any(|row| row.verdict.ends_with("excess"));
    let uniform = rows.iter().all(|row| row.verdict == "uniform");
    let (opening, kind) = if broken {
        (
            format!("The impact parameters of {engine} are not uniform"),
            VerdictKind::Differ,
        )
    } else if uniform {
        (
            format!("The impact parameters of {engine} are uniform in all windows"),
            VerdictKind::Agree,
        )
    } else {
        (
            format!("The impact parameters of {engine} show no departure from uniform"),
            VerdictKind::Undecided,
        )
    };
    Verdict {
        topic: format!("impact parameters, {engine}"),
        sentence: format!(
            "{opening}; windows of t/t0: {}. (Chi-squared, chance of any false alarm {}.)",
            all.join("; "),
            setup.case.verdict.false_alarm
        ),
        kind,
    }
}
