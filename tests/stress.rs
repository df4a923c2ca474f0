//! The hard cases of `stosszahl stress ed`, the short ones.

use stosszahl::stress::{Effort, cases};

/// Every case passes; all are run, so that one failure does not hide another.
#[test]
fn every_short_case_passes() {
    let mut failed = Vec::new();
    for case in cases() {
        let report = case.run(Effort::default());
        println!("{report}");
        if !report.passed() {
            failed.push(report.to_string());
        }
    }
    assert!(
        failed.is_empty(),
        "{} fail:\n{}",
        failed.len(),
        failed.join("\n")
    );
}

/// Names are what the command line asks for.
#[test]
fn names_differ() {
    let mut names: Vec<_> = cases().iter().map(|case| case.name).collect();
    let count = names.len();
    names.sort_unstable();
    names.dedup();
    assert_eq!(names.len(), count);
}
