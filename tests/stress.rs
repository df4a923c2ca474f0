//! The hard cases of `stosszahl stress ed`, the short ones.

use std::process::Command;

use stosszahl::stress::{Effort, cases};

/// What the program prints and its exit code.
fn program(arguments: &[&str]) -> (String, String, Option<i32>) {
    let done = Command::new(env!("CARGO_BIN_EXE_stosszahl"))
        .args(["stress", "ed"])
        .args(arguments)
        .output()
        .expect("the program runs");
    let text = |bytes| String::from_utf8(bytes).expect("text");
    (text(done.stdout), text(done.stderr), done.status.code())
}

#[test]
fn command_runs_lists_and_refuses() {
    let (json, _, code) = program(&["--case", "rest,line-above", "--json"]);
    assert_eq!(code, Some(0));
    let reports: serde_json::Value = serde_json::from_str(&json).expect("JSON");
    let names: Vec<_> = reports
        .as_array()
        .expect("a list")
        .iter()
        .map(|report| &report["name"])
        .collect();
    assert_eq!(names, ["rest", "line-above"]);
    let (text, _, code) = program(&["--case", "rest"]);
    assert_eq!(code, Some(0));
    assert!(
        text.starts_with("pass  rest") && text.contains("1 of 1 hard cases passed"),
        "{text}"
    );
    let (list, _, _) = program(&["--list"]);
    assert!(cases().iter().all(|case| list.contains(case.required)));
    let (_, error, code) = program(&["--case", "grasing"]);
    assert_eq!(code, Some(2));
    assert!(
        error.contains("--case grasing: allowed are") && error.contains("grazing"),
        "{error}"
    );
}

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

/// `docs/stress.md` has the table of the cases.
#[test]
fn every_case_is_documented() {
    let page = include_str!("../docs/stress.md");
    for case in cases() {
        let row = format!("| `{}` | {} | {} |", case.name, case.tried, case.required);
        assert!(page.contains(&row), "docs/stress.md lacks the row\n{row}");
    }
}
