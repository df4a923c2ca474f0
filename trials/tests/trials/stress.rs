//! Hard cases of `stosszahl-trials stress` in their short form.

use std::collections::BTreeSet;
use std::process::Command;

use stosszahl_trials::{Effort, TrialRow, stress};

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
        stress::event_driven()
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
    let known = stress::monte_carlo();
    assert!(known.iter().all(|case| list.contains(case.required)));
    let (_, error, code) = program("dsmc", &["--case", "grazing"]);
    assert_eq!(code, Some(2));
    assert!(error.contains("deep-cooling"), "{error}");
    let (json, _, code) = program("dsmc", &["--case", "angular-momentum", "--json"]);
    assert_eq!(code, Some(0));
    assert!(json.contains("\"name\": \"angular-momentum\""), "{json}");
}

/// Defines a test for each case of an engine, and a test that none is left out.
macro_rules! short_cases {
    ($engine:ident, $cases:path, $($test:ident: $name:literal,)+) => {
        mod $engine {
            $(#[test]
            fn $test() {
                let trials = $cases();
                let trial = trials.iter().find(|trial| trial.name == $name);
                let trial = trial.expect("a trial of this name");
                let report = trial.run_trial(&super::Effort::default());
                println!("{report}");
                assert!(report.passed(), "{report}");
            })+

            #[test]
            fn every_case_has_a_test() {
                let mut tested = vec![$($name),+];
                let mut known: Vec<_> = $cases().iter().map(|case| case.name).collect();
                tested.sort_unstable();
                known.sort_unstable();
                assert_eq!(tested, known);
            }
        }
    };
}

short_cases! {
    event_driven, super::stress::event_driven,
    line_below: "line-below",
    line_above: "line-above",
    dense_collapse: "dense-collapse",
    crystal_0_90: "crystal-0.90",
    crystal_0_9068: "crystal-0.9068",
    lattice_ties: "lattice-ties",
    cradle: "cradle",
    triple: "triple",
    grazing: "grazing",
    touching: "touching",
    overlapping: "overlapping",
    resting: "resting",
    drifting: "drifting",
    elastic_run: "elastic-run",
    cooling: "cooling",
    plastic: "plastic",
    viscoelastic: "viscoelastic",
    contact_times: "contact-times",
    one_moves: "one-moves",
    rest: "rest",
    small_boxes: "small-boxes",
    wedge: "wedge",
    long_box: "long-box",
    borders: "borders",
    ratios: "ratios",
    one_huge: "one-huge",
    kills: "kills",
    speeds: "speeds",
    subnormal: "subnormal",
    no_numbers: "no-numbers",
    lonely_mover: "lonely-mover",
}

short_cases! {
    monte_carlo, super::stress::monte_carlo,
    crowded: "crowded",
    packed: "packed",
    one_point: "one-point",
    contrast: "contrast",
    few: "few",
    violations: "violations",
    long_step: "long-step",
    hot_one: "hot-one",
    plastic: "plastic",
    deep_cooling: "deep-cooling",
    free_flight: "free-flight",
    threads: "threads",
    kills: "kills",
    conservation: "conservation",
    angular_momentum: "angular-momentum",
}

short_cases! {
    between_walls, super::stress::walls,
    sharp_corner: "sharp-corner",
    grain_in_a_wedge: "grain-in-a-wedge",
    floor: "floor",
    grazing_walls: "grazing-walls",
    fast_wall: "fast-wall",
    inside_an_obstacle: "inside-an-obstacle",
    empty_channel: "empty-channel",
    supersonic_inflow: "supersonic-inflow",
}

#[test]
fn hard_cases_of_mixtures_hold() {
    for case in stress::mixtures() {
        let report = case.run_trial(&Effort::default());
        assert!(report.passed(), "{report}");
    }
}

fn engines() -> [Vec<TrialRow>; 3] {
    [
        stress::event_driven(),
        stress::monte_carlo(),
        stress::walls(),
    ]
}

/// Names of cases are unique, because the command line selects by name.
#[test]
fn names_differ() {
    for cases in engines() {
        let names: BTreeSet<_> = cases.iter().map(|case| case.name).collect();
        assert_eq!(names.len(), cases.len());
    }
}

/// The table of `docs/development/stress.md` has all cases.
#[test]
fn every_case_is_documented() {
    let page = include_str!("../../../docs/development/stress.md");
    for case in engines().concat() {
        let row = format!("| `{}` | {} | {} |", case.name, case.tried, case.required);
        assert!(
            page.contains(&row),
            "docs/development/stress.md lacks the row\n{row}"
        );
    }
}
