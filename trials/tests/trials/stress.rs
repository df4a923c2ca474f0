//! Hard cases of `stosszahl-trials stress` in their short form.

use std::collections::BTreeSet;
use std::process::Command;

use stosszahl_trials::Effort;
use stosszahl_trials::stress::StressEngine;

/// Runs `stosszahl-trials stress`; returns standard output, standard error and the exit code.
fn program(engine: &str, arguments: &[&str]) -> (String, String, Option<i32>) {
    let done = Command::new(env!("CARGO_BIN_EXE_stosszahl-trials"))
        .args(["stress", engine])
        .args(arguments)
        .output()
        .expect("the program runs");
    let text = |bytes| String::from_utf8(bytes).expect("text");
    (text(done.stdout), text(done.stderr), done.status.code())
}

#[test]
fn command_runs_lists_and_refuses() {
    let (json, _, code) = program("ed", &["--case", "rest,line-above", "--json"]);
    assert_eq!(code, Some(0));
    let reports: serde_json::Value = serde_json::from_str(&json).expect("JSON");
    let names: Vec<_> = reports
        .as_array()
        .expect("a list")
        .iter()
        .map(|report| &report["name"])
        .collect();
    assert_eq!(names, ["rest", "line-above"]);
    let (text, _, code) = program("ed", &["--case", "rest"]);
    assert_eq!(code, Some(0));
    assert!(
        text.starts_with("pass  rest") && text.contains("1 of 1 hard cases passed"),
        "{text}"
    );
    let (list, _, _) = program("ed", &["--list"]);
    assert!(
        StressEngine::Ed
            .cases()
            .iter()
            .all(|trial| list.contains(trial.required))
    );
    let (_, error, code) = program("ed", &["--case", "grasing"]);
    assert_eq!(code, Some(2));
    assert!(
        error.contains("--case grasing: allowed are") && error.contains("grazing"),
        "{error}"
    );
    let (list, _, _) = program("dsmc", &["--list"]);
    let known = StressEngine::Dsmc.cases();
    assert!(known.iter().all(|case| list.contains(case.required)));
    let (_, error, code) = program("dsmc", &["--case", "grazing"]);
    assert_eq!(code, Some(2));
    assert!(error.contains("deep-cooling"), "{error}");
    let (json, _, code) = program("dsmc", &["--case", "angular-momentum", "--json"]);
    assert_eq!(code, Some(0));
    assert!(json.contains("\"name\": \"angular-momentum\""), "{json}");
}

/// Runs the short form of all cases of an engine.
fn check_cases(engine: StressEngine) {
    let mut names = BTreeSet::new();
    for case in engine.cases() {
        assert!(
            names.insert(case.name),
            "{}: two cases of a name",
            case.name
        );
        let report = case.run_trial(&Effort::default());
        assert!(report.passed(), "{report}");
    }
}

#[test]
fn hard_cases_of_exact_disks_hold() {
    check_cases(StressEngine::Ed);
}

#[test]
fn hard_cases_of_cells_hold() {
    check_cases(StressEngine::Dsmc);
}

#[test]
fn hard_cases_without_positions_hold() {
    check_cases(StressEngine::Mixture);
}

#[test]
fn hard_cases_of_boundaries_hold() {
    check_cases(StressEngine::Walls);
}

/// The table of `docs/development/stress.md` has all cases.
#[test]
fn every_case_is_documented() {
    let page = include_str!("../../../docs/development/stress.md");
    let engines = [StressEngine::Ed, StressEngine::Dsmc, StressEngine::Walls];
    for case in engines.map(StressEngine::cases).concat() {
        let row = format!("| `{}` | {} | {} |", case.name, case.tried, case.required);
        assert!(
            page.contains(&row),
            "docs/development/stress.md lacks the row\n{row}"
        );
    }
}
