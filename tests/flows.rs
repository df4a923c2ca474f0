//! Cases of flows: what is refused, and what a run leaves, through the program and the library.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::process::{Command, Output};
use std::sync::atomic::AtomicBool;

use serde_json::Value;
use stosszahl::case::CaseFile;
use stosszahl::flow::case::Flow;
use stosszahl::flow::plan::Plan;
use stosszahl::flow::run;
use stosszahl::progress::Progress;
use stosszahl::run::Place;

/// Rough disks that fall past an obstacle between walls of all sorts, by both engines.
const BOTH: &str = r#"# Do a few rough disks fall?
format = 1
kind = "flow"
title = "a test"
seed = 3
replicas = 2

[[species]]
name = "small"
number = 60

[[species]]
number = 20
diameter = 1.5
mass = 2

[box]
size = [20, 20]

[walls]
left = { restitution = 0.9, slip = 0.5 }
right = "specular"
bottom = { restitution = 0.9, vibration = { amplitude = 0.2, period = 0.5 } }
top = { temperature = 2, sliding = [0.5, 0] }

[gravity]
acceleration = [0, -0.5]

[contact]
restitution = 0.9
tangential_restitution = 0.2

[[obstacle]]
disc = { centre = [10, 10], radius = 2 }

[[obstacle]]
polyline = [[2, 5], [6, 4]]
temperature = 1

[run]
until = 20
samples = 40
blocks = 10
checkpoint_seconds = 1e-9

[fields]
cells = [4, 5]
windows = [[0, 4]]

[engine.ed]
contact_time = 1e-4

[engine.dsmc]
scheme = "enskog"
simulators_per_grain = 4
"#;

/// Spheres that flow through a channel with regions of unlike weights.
const CHANNEL: &str = r#"# Do a few spheres flow?
format = 1
kind = "flow"
title = "a test of a channel"
replicas = 2

[[species]]
number = 2000

[box]
size = [8, 4, 0.5]

[walls]
left = "open"
right = "open"
bottom = { restitution = 0.8, slip = 0 }
top = { restitution = 0.8, slip = 0 }

[contact]
restitution = 0.6
tangential_restitution = 0

[[inflow]]
face = "left"
velocity = [2, 0, 0]

[start]
temperature = 0.5
mean_free_path = 1
velocity = [2, 0, 0]

[run]
until = 20
samples = 40
blocks = 10

[fields]
cells = [16, 8]

[engine.dsmc]
weights = { along = "x", factors = [1, 0.7] }
"#;

fn stosszahl(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_stosszahl"))
        .current_dir(folder)
        .args(arguments)
        .output()
        .expect("the program runs")
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// All tables of a results folder.
fn tables(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    fs::read_dir(folder)
        .expect("a folder")
        .map(|entry| entry.expect("an entry").path())
        .filter(|path| path.extension().is_some_and(|ending| ending == "csv"))
        .map(|path| {
            let name = path.file_name().expect("a name").to_string_lossy();
            (name.into_owned(), fs::read(&path).expect("a table"))
        })
        .collect()
}

/// One run of both engines: tables, manifest and report are there, and the report has its maps; the same bytes on one
/// and on two threads.
#[test]
fn a_run_leaves_tables_and_a_report() {
    let folder = tempfile::tempdir().expect("a folder");
    fs::write(folder.path().join("case.toml"), BOTH).expect("a case");
    let check = stosszahl(folder.path(), &["check", "case.toml"]);
    assert!(check.status.success(), "{}", text(&check.stderr));
    assert!(text(&check.stdout).contains("packing_fraction"));
    for threads in ["1", "2"] {
        let done = stosszahl(
            folder.path(),
            &["run", "case.toml", "--out", threads, "--threads", threads],
        );
        assert!(done.status.success(), "{}", text(&done.stderr));
        assert!(
            text(&done.stdout).contains("steady state"),
            "{}",
            text(&done.stdout)
        );
    }
    let one = tables(&folder.path().join("1"));
    let names: Vec<&str> = one.keys().map(String::as_str).collect();
    let expected = [
        "boundaries.csv",
        "fields.csv",
        "profiles.csv",
        "series.csv",
        "species.csv",
    ];
    assert_eq!(names, expected);
    assert!(
        one == tables(&folder.path().join("2")),
        "threads change tables"
    );
    let fields = text(&one["fields.csv"]);
    // Two engines, two windows, twenty cells, and the heading.
    assert_eq!(fields.lines().count(), 1 + 2 * 2 * 20);
    let boundaries = text(&one["boundaries.csv"]);
    for name in ["ed,left", "ed,obstacle 1", "dsmc,top", "dsmc,obstacle 2"] {
        assert!(boundaries.contains(name), "{name}: {boundaries}");
    }
    let manifest = fs::read_to_string(folder.path().join("1/manifest.json")).expect("a manifest");
    let manifest: Value = serde_json::from_str(&manifest).expect("JSON");
    assert_eq!(manifest["kind"], "flow");
    assert_eq!(manifest["engines"].as_array().map(Vec::len), Some(2));
    let report = fs::read_to_string(folder.path().join("1/report.html")).expect("a report");
    for piece in [
        "Fields, ED",
        "Fields, DSMC",
        "granular temperature",
        "obstacle 2",
    ] {
        assert!(report.contains(piece), "{piece}");
    }
    assert!(report.matches("<svg class=\"plot\"").count() > 15);
}

/// Stopped after each checkpoint and continued, through the library: the same record.
#[test]
fn a_run_continues_to_the_same_bytes() {
    for case in [BOTH, CHANNEL] {
        let overrides = [
            "replicas=1".to_owned(),
            "run.checkpoint_seconds=1e-9".to_owned(),
        ];
        let file = CaseFile::<Flow>::from_text(Path::new("case.toml"), case, &overrides);
        let plan = Plan::new(&file.expect("a case").points[0].case).expect("a plan");
        let series = |folder: &Path, stops: bool| {
            let progress = Progress::start("test");
            let stop = AtomicBool::new(stops);
            let mut legs = 0;
            loop {
                let place = Place {
                    folder,
                    fingerprint: &[0; 32],
                    stop: &stop,
                    progress: &progress,
                };
                legs += 1;
                match run::run(&plan, place) {
                    Ok(replicas) => {
                        let engines = replicas.into_iter().flat_map(|replica| replica.engines);
                        let all: Vec<_> = engines
                            .map(|record| (record.series, record.fields, record.ledgers))
                            .collect();
                        return (all, legs);
                    }
                    Err(error) => assert!(error.is_interruption(), "{error}"),
                }
            }
        };
        let (whole, pieces) = (
            tempfile::tempdir().expect("a folder"),
            tempfile::tempdir().expect("a folder"),
        );
        let (expected, _) = series(whole.path(), false);
        let (found, legs) = series(pieces.path(), true);
        assert!(legs >= 30, "{legs} pieces");
        assert!(found == expected, "a stop changes the run");
    }
}

/// Mass that flows in stays, leaves, or is split and merged; weights do not change the flow.
#[test]
fn a_channel_keeps_its_books() {
    let folder = tempfile::tempdir().expect("a folder");
    fs::write(folder.path().join("case.toml"), CHANNEL).expect("a case");
    let done = stosszahl(folder.path(), &["run", "case.toml", "--out", "out"]);
    assert!(done.status.success(), "{}", text(&done.stderr));
    let all = tables(&folder.path().join("out"));
    let boundaries = text(&all["boundaries.csv"]);
    for name in [
        "inflow 1",
        "out through right",
        "splitting and merging",
        "bottom",
    ] {
        assert!(boundaries.contains(name), "{name}: {boundaries}");
    }
    let said = text(&done.stdout);
    for topic in [
        "along the channel",
        "walls of the channel",
        "symmetry",
        "splitting",
    ] {
        assert!(said.contains(topic), "{topic}: {said}");
    }
}

/// What is changed in the first case, into what, and words that the message must have.
const FAULTS: &[(&str, &str, &[&str])] = &[
    (
        "number = 60",
        "number = 0",
        &["species[0].number", "whole number from 1"],
    ),
    ("number = 60", "numbers = 60", &["numbers", "number"]),
    ("size = [20, 20]", "size = [20]", &["box.size", "two sides"]),
    (
        "size = [20, 20]",
        "size = [20, -1]",
        &["box.size", "above 0"],
    ),
    (
        "right = \"specular\"",
        "right = \"mirror\"",
        &["walls.right", "specular"],
    ),
    (
        "right = \"specular\"",
        "right = \"open\"",
        &["walls.right", "exact dynamics keeps"],
    ),
    (
        "right = \"specular\"\n",
        "",
        &["walls.left", "both periodic"],
    ),
    (
        "slip = 0.5 }",
        "slip = 1.5 }",
        &["walls.left.slip", "from -1 to 1"],
    ),
    (
        "left = { restitution = 0.9,",
        "left = {",
        &["walls.left.restitution"],
    ),
    (
        "amplitude = 0.2",
        "amplitude = 15",
        &["amplitude", "half the box"],
    ),
    (
        "sliding = [0.5, 0]",
        "sliding = [0.5, 1]",
        &["walls.top.sliding", "zero across"],
    ),
    (
        "[0, -0.5]",
        "[0, -0.5, 0]",
        &["gravity.acceleration", "as many components"],
    ),
    (
        "tangential_restitution = 0.2",
        "inertia = 0.4",
        &["contact.inertia", "tangential_restitution"],
    ),
    (
        "radius = 2 }",
        "radius = 12 }",
        &["number 1", "allowed is the box"],
    ),
    (
        "[[2, 5], [6, 4]]",
        "[[2, 5], [2, 5]]",
        &["number 2", "length"],
    ),
    (
        "disc = {",
        "polygon = [[1, 1], [2, 1], [2, 2]]\ndisc = {",
        &["obstacle[0]", "exactly one"],
    ),
    (
        "samples = 40",
        "samples = 41",
        &["run.samples", "multiple of run.blocks"],
    ),
    ("[[0, 4]]", "[[0, 40]]", &["fields.windows[0]"]),
    (
        "[engine.ed]\ncontact_time = 1e-4\n\n[engine.dsmc]\nscheme = \"enskog\"\nsimulators_per_grain = 4",
        "[engine]",
        &["engine", "at least one engine"],
    ),
    (
        "[run]",
        "[start]\nmean_free_path = 1\n\n[run]",
        &["start.mean_free_path"],
    ),
    (
        "[run]",
        "[start]\nempty = true\n\n[run]",
        &["start.empty", "inflow"],
    ),
    ("number = 60", "number = 600", &["finds no place"]),
    (
        "scheme = \"enskog\"",
        "scheme = \"contact-point\"",
        &["engine.dsmc.scheme", "obstacles"],
    ),
    ("kind = \"flow\"", "kind = \"flows\"", &["kind", "flow"]),
];

#[test]
fn bad_cases_are_refused_with_key_and_reason() {
    let folder = tempfile::tempdir().expect("a folder");
    for (found, replaced, words) in FAULTS {
        assert!(BOTH.contains(found), "{found}");
        fs::write(
            folder.path().join("case.toml"),
            BOTH.replacen(found, replaced, 1),
        )
        .expect("a case");
        let done = stosszahl(
            folder.path(),
            &["run", "case.toml", "--out", "out", "--force"],
        );
        let said = text(&done.stderr);
        assert!(!done.status.success(), "{replaced} is accepted");
        for word in *words {
            assert!(said.contains(word), "{replaced}: no {word:?} in\n{said}");
        }
        assert!(!said.contains("panicked"), "{said}");
        assert!(!folder.path().join("out/manifest.json").exists());
    }
}

/// Every case of the folder means something.
#[test]
fn the_cases_of_the_folder_are_valid() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("cases");
    let mut count = 0;
    for entry in fs::read_dir(folder).expect("cases") {
        let path = entry.expect("an entry").path();
        if stosszahl::case::Kind::of_file(&path).expect("a kind") != stosszahl::case::Kind::Flow {
            continue;
        }
        count += 1;
        let file = CaseFile::<Flow>::read(&path, &[]).expect("a case");
        assert!(file.source_text.starts_with("# "), "{}", path.display());
        for point in file.points {
            Plan::new(&point.case).expect("a plan");
        }
    }
    assert!(count >= 13, "{count}");
}
