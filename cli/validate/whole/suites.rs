//! The hard cases as claims: no fault in any.

use stosszahl_analysis::statistics::Estimate;

use crate::stress::{self, Case, Effort};
use crate::validate::table::{Place, Row};

/// One row for each hard case of a suite: the number of its faults.
fn suite(name: &str, cases: &[Case], say: &dyn Fn(&Row)) -> Vec<Row> {
    cases
        .iter()
        .map(|case| {
            let report = case.run(Effort::default());
            let here = Place {
                part: "stress",
                scheme: name.to_owned(),
                setting: case.name.to_owned(),
                packing: 0.0,
                seconds: report.seconds,
                default: true,
            };
            let faults = Estimate {
                value: report.faults.len() as f64,
                standard_error: Some(0.0),
                replicas: 1,
            };
            let row = here.row("faults", 0.0, faults, Some(0.5));
            say(&row);
            row
        })
        .collect()
}

/// All suites, in their short form.
pub(super) fn all(say: &dyn Fn(&Row)) -> Vec<Row> {
    let mut rows = suite("stress ed", &stress::cases(), say);
    rows.extend(suite("stress dsmc", &stress::dsmc::cases(), say));
    rows.extend(suite("stress mixture", &stress::mixture_cases(), say));
    rows
}
