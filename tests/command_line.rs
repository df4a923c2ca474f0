//! The program as a user runs it: results, refusals, threads, kills and continuations.

#[allow(dead_code, unused_imports, reason = "each test file uses its own part")]
mod support;

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::fs;
use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::thread::sleep;
use std::time::Duration;

use rand::{RngExt, SeedableRng};
use stosszahl::model::random::Stream;
use support::bad_cases::{BAD_CASES, Content};

const CASE: &str = r#"
format = 1
title = "a small paired case"
seed = 5
replicas = 3

[gas]
disks = 900
packing_fraction = 0.25
restitution = 0.8

[run]
until = 20
checkpoint_seconds = 0.01

[engine.ed]
[engine.dsmc-free-volume]
[engine.dsmc-enskog]
simulators_per_disk = 2

[measure]
structure_times = [0, 20]
snapshot_times = [20]
"#;

/// The small case with its disks in `start.csv`.
fn case_from_file() -> String {
    CASE.replace("disks = 900\npacking_fraction = 0.25\n", "")
        .replace(
            "[run]",
            "[start]\nplacement = \"file\"\nfile = \"start.csv\"\n\n[run]",
        )
}

fn stosszahl(folder: &Path) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_stosszahl"));
    command.current_dir(folder).stdin(Stdio::null());
    command
}

fn run(folder: &Path, arguments: &[&str]) -> Output {
    stosszahl(folder)
        .args(arguments)
        .output()
        .expect("the program starts")
}

fn text(output: &[u8]) -> String {
    String::from_utf8_lossy(output).into_owned()
}

/// Names and bytes of all tables and snapshots of a results folder.
fn tables(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut found = BTreeMap::new();
    for folder in [folder.to_owned(), folder.join("snapshots")] {
        for entry in fs::read_dir(&folder).expect("a results folder") {
            let path = entry.expect("an entry").path();
            let ending = path.extension().and_then(|ending| ending.to_str());
            if matches!(ending, Some("csv" | "xyz")) {
                let name = path
                    .file_name()
                    .expect("a name")
                    .to_string_lossy()
                    .into_owned();
                found.insert(name, fs::read(&path).expect("bytes"));
            }
        }
    }
    found
}

fn assert_same(a: &Path, b: &Path) {
    let (first, second) = (tables(a), tables(b));
    assert!(first.len() >= 9, "{:?}", first.keys());
    assert_eq!(
        first.keys().collect::<Vec<_>>(),
        second.keys().collect::<Vec<_>>()
    );
    for (name, bytes) in &first {
        assert!(
            bytes == &second[name],
            "{name} differs between {} and {}",
            a.display(),
            b.display()
        );
    }
}

#[test]
fn paired_case_gives_tables_and_a_report() {
    let folder = tempfile::tempdir().expect("a folder");
    fs::write(folder.path().join("small.toml"), CASE).expect("a case");
    let output = run(folder.path(), &["run", "small.toml"]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    assert!(
        text(&output.stdout).contains("ED against DSMC (enskog)"),
        "{}",
        text(&output.stdout)
    );
    let results = folder.path().join("results/small");
    let header = |name: &str| {
        let table = fs::read_to_string(results.join(name)).expect("a table");
        table.lines().next().unwrap_or_default().to_owned()
    };
    assert_eq!(
        header("energy.csv"),
        "engine,time,time_over_t0,collisions_per_particle,energy_ratio,energy_ratio_se,haff_ratio,fourth_cumulant,fourth_cumulant_se,replicas"
    );
    assert_eq!(
        header("comparison.csv"),
        "engine_a,engine_b,time_over_t0,energy_ratio_a,energy_ratio_b,quotient,quotient_se,z,verdict"
    );
    assert_eq!(
        header("structure_factor.csv"),
        "engine,time_over_t0,k,structure_factor,structure_factor_se,modes"
    );
    assert_eq!(
        header("pair_correlation.csv"),
        "engine,time_over_t0,r_over_d,g,g_se"
    );
    assert_eq!(
        header("impact_parameter.csv"),
        "engine,window_start,window_end,bin_low,bin_high,count,density,density_se"
    );
    assert_eq!(
        header("impact_parameter_summary.csv"),
        "engine,window_start,window_end,collisions,slope,slope_se,mean_b_over_d,chi_squared,degrees_of_freedom,p_value,verdict"
    );
    assert!(results.join("manifest.json").exists() && !results.join("checkpoints").exists());
    let report = fs::read(results.join("report.html")).expect("a report");
    // All engines begin with the same energy and the same disks.
    let energy = fs::read_to_string(results.join("energy.csv")).expect("a table");
    assert_eq!(
        energy
            .lines()
            .filter(|line| line.contains(",0.0,0.0,0.0,1.0,"))
            .count(),
        3,
        "{energy}"
    );

    let output = run(folder.path(), &["report", "results/small"]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    assert!(report == fs::read(results.join("report.html")).expect("a report"));
}

#[test]
fn results_are_neither_overwritten_nor_mistaken() {
    let folder = tempfile::tempdir().expect("a folder");
    fs::write(folder.path().join("small.toml"), CASE).expect("a case");
    let results = folder.path().join("results/small");
    let output = run(folder.path(), &["run", "small.toml"]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    // A finished run is not mistaken for another.
    let output = run(folder.path(), &["run", "small.toml", "--resume"]);
    assert!(output.status.success() && text(&output.stderr).contains("is complete"));
    let output = run(
        folder.path(),
        &["run", "small.toml", "--resume", "--seed", "6"],
    );
    assert_eq!(output.status.code(), Some(2));
    assert!(
        text(&output.stderr).contains("another run"),
        "{}",
        text(&output.stderr)
    );

    // What is there is not overwritten, and what is not ours is not replaced.
    let output = run(folder.path(), &["run", "small.toml"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(
        text(&output.stderr).contains("--force"),
        "{}",
        text(&output.stderr)
    );
    let output = run(
        folder.path(),
        &["run", "small.toml", "--force", "--until", "1"],
    );
    assert!(output.status.success(), "{}", text(&output.stderr));
    fs::create_dir(folder.path().join("diary")).expect("a folder");
    fs::write(folder.path().join("diary/today"), "dear").expect("a file");
    let output = run(
        folder.path(),
        &["run", "small.toml", "--force", "--out", "diary"],
    );
    assert_eq!(output.status.code(), Some(2));
    assert!(folder.path().join("diary/today").exists());
    // Nor is what somebody put beside the results lost, nor the case itself.
    fs::write(results.join("notes.txt"), "dear").expect("a file");
    fs::copy(folder.path().join("small.toml"), results.join("small.toml")).expect("a copy");
    let output = run(
        folder.path(),
        &["run", "results/small/small.toml", "--force", "--until", "1"],
    );
    assert_eq!(output.status.code(), Some(2), "{}", text(&output.stderr));
    assert!(
        text(&output.stderr).contains("would be replaced"),
        "{}",
        text(&output.stderr)
    );
    let output = run(
        folder.path(),
        &["run", "small.toml", "--force", "--until", "1"],
    );
    assert!(output.status.success(), "{}", text(&output.stderr));
    assert!(results.join("notes.txt").exists() && results.join("small.toml").exists());
}

#[test]
fn one_and_two_threads_give_the_same_bytes() {
    let folder = tempfile::tempdir().expect("a folder");
    fs::write(folder.path().join("small.toml"), CASE).expect("a case");
    for threads in ["1", "2"] {
        let output = run(
            folder.path(),
            &["run", "small.toml", "--threads", threads, "--out", threads],
        );
        assert!(output.status.success(), "{}", text(&output.stderr));
    }
    assert_same(&folder.path().join("1"), &folder.path().join("2"));
    let output = run(
        folder.path(),
        &["run", "small.toml", "--seed", "6", "--out", "other"],
    );
    assert!(output.status.success());
    assert_ne!(
        tables(&folder.path().join("1")),
        tables(&folder.path().join("other"))
    );
}

/// Ten kills at random moments, each continued; one of ten is an interrupt that the program hears. Moments are
/// drawn with a fixed seed; what the program was doing at them is the machine's choice.
#[test]
fn killed_and_resumed_runs_give_the_same_bytes() {
    let folder = tempfile::tempdir().expect("a folder");
    fs::write(folder.path().join("case.toml"), CASE).expect("a case");
    let larger = ["--set", "gas.disks=12000", "--replicas", "2"];
    let output = stosszahl(folder.path())
        .args(["run", "case.toml", "--out", "whole"])
        .args(larger)
        .output();
    assert!(output.expect("the program starts").status.success());
    let mut stream = Stream::seed_from_u64(10);
    let mut kills = 0;
    let mut mode: &[&str] = &[];
    while kills < 10 {
        let mut child = stosszahl(folder.path())
            .args(["run", "case.toml", "--out", "pieces"])
            .args(larger)
            .args(mode)
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .expect("the program starts");
        mode = &["--resume"];
        sleep(Duration::from_millis(stream.random_range(60..200)));
        if kills == 4 {
            let sent = Command::new("kill")
                .args(["-INT", &child.id().to_string()])
                .status();
            assert!(sent.expect("kill").success());
            let code = child.wait().expect("an end").code();
            assert!(matches!(code, Some(130 | 0)), "{code:?}");
        } else {
            child.kill().expect("a kill");
            child.wait().expect("an end");
        }
        kills += 1;
        if folder.path().join("pieces/manifest.json").exists() {
            break;
        }
    }
    assert!(
        kills >= 5,
        "the run was over after {kills} kills: make it longer"
    );
    let output = stosszahl(folder.path())
        .args(["run", "case.toml", "--out", "pieces", "--resume"])
        .args(larger)
        .output();
    let output = output.expect("the program starts");
    assert!(output.status.success(), "{}", text(&output.stderr));
    assert_same(&folder.path().join("whole"), &folder.path().join("pieces"));
}

#[test]
fn resume_refuses_another_case_and_an_empty_place() {
    let folder = tempfile::tempdir().expect("a folder");
    fs::write(folder.path().join("case.toml"), CASE).expect("a case");
    let output = run(folder.path(), &["run", "case.toml", "--resume"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(
        text(&output.stderr).contains("nothing to resume"),
        "{}",
        text(&output.stderr)
    );
    let mut child = stosszahl(folder.path())
        .args(["run", "case.toml", "--set", "gas.disks=20000"])
        .stderr(Stdio::null())
        .spawn()
        .expect("the program starts");
    sleep(Duration::from_millis(700));
    child.kill().expect("a kill");
    child.wait().expect("an end");
    let output = run(
        folder.path(),
        &["run", "case.toml", "--resume", "--seed", "77"],
    );
    assert_eq!(output.status.code(), Some(2), "{}", text(&output.stderr));
    assert!(
        text(&output.stderr).contains("another run"),
        "{}",
        text(&output.stderr)
    );
}

/// Through the binary: exit code 2, nothing on standard output, no results folder left.
#[test]
fn bad_cases_leave_nothing_behind() {
    assert!(BAD_CASES.len() >= 25);
    for bad in BAD_CASES {
        let folder = tempfile::tempdir().expect("a folder");
        let name = format!("{}.toml", bad.name.replace(' ', "-"));
        let path = folder.path().join(&name);
        if let Some(bytes) = bad.bytes() {
            fs::write(&path, bytes).expect("a case");
        } else if matches!(bad.content, Content::Directory) {
            fs::create_dir(&path).expect("a folder");
        }
        let mut command = stosszahl(folder.path());
        command.args(["run", &name]);
        for one in bad.overrides {
            command.args(["--set", one]);
        }
        let output = command.output().expect("the program starts");
        let said = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{}: {said}", bad.name);
        assert!(output.stdout.is_empty(), "{}", bad.name);
        assert!(
            said.contains(&name) || said.contains("--set"),
            "{}: {said}",
            bad.name
        );
        assert!(!folder.path().join("results").exists(), "{}", bad.name);
    }
}

/// Start files that are damaged, or do not fit the case.
#[test]
fn bad_start_files_are_named() {
    let case = case_from_file();
    for (start, fragments) in [
        (
            "# box: 10 10\nx,y\n1,1\n1.5,1\n",
            &["start.csv", "disks 0 and 1", "overlap by 0.5"][..],
        ),
        (
            "# box: 10 10\nx,y\n1,1\nNaN,1\n",
            &["start.csv:4", "NaN", "finite"],
        ),
        (
            "# box: 10 10\nx,y\n1,1\nwest,1\n",
            &["start.csv:4", "west", "finite"],
        ),
        ("# box: 10\nx,y\n1,1\n", &["start.csv:1", "# box: Lx Ly"]),
        (
            "# box: 0.5 10\nx,y\n0.2,1\n0.2,5\n",
            &["disks 0 and 0", "overlap"],
        ),
        ("# box: 10 10\nx,y\n0.2,1\n", &["one disk", "at least two"]),
        (
            "# box: 10 10\nx,y\n1,1\n31.2,1\n",
            &["disks 0 and 1", "overlap by 0.8"],
        ),
        (
            "# box: 10 10\nx,y,radius\n1,1,-1\n",
            &["start.csv:3", "radius", "above zero"],
        ),
        ("# box: 10 10\nx,y\n", &["start.csv", "at least one"]),
        ("", &["start.csv:1", "# box: Lx Ly"]),
    ] {
        let folder = tempfile::tempdir().expect("a folder");
        fs::write(folder.path().join("case.toml"), &case).expect("a case");
        fs::write(folder.path().join("start.csv"), start).expect("a start");
        let output = run(folder.path(), &["run", "case.toml"]);
        let said = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{start}: {said}");
        for fragment in fragments {
            assert!(said.contains(fragment), "{start}: {said} lacks {fragment}");
        }
        assert!(!folder.path().join("results").exists());
    }
    // A gas cannot be given a lattice that does not fit, nor a box narrower than a disk.
    let folder = tempfile::tempdir().expect("a folder");
    fs::write(folder.path().join("case.toml"), CASE).expect("a case");
    for (set, fragment) in [
        ("gas.packing_fraction=0.9", "do not fit"),
        ("box.aspect_ratio=1e-9", "one disk is wide"),
    ] {
        let output = run(
            folder.path(),
            &[
                "run",
                "case.toml",
                "--set",
                set,
                "--set",
                "start.placement=hexagonal",
            ],
        );
        assert_eq!(output.status.code(), Some(2));
        assert!(
            text(&output.stderr).contains(fragment),
            "{}",
            text(&output.stderr)
        );
        assert!(!folder.path().join("results").exists());
    }
}

/// A gas in which nothing ever collides ends like any other.
#[test]
fn parallel_flight_is_no_endless_preparation() {
    let folder = tempfile::tempdir().expect("a folder");
    fs::write(
        folder.path().join("start.csv"),
        "# box: 10 10\nx,y,vx,vy\n1,1,1,0\n4,5,-1,0\n7,9,0,0\n",
    )
    .expect("a start");
    let case = case_from_file()
        .replace("placement", "velocities = \"file\"\nplacement")
        .replace("replicas = 3", "replicas = 1");
    fs::write(folder.path().join("case.toml"), case).expect("a case");
    let output = run(folder.path(), &["run", "case.toml"]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    assert!(
        text(&output.stdout).contains("not equilibrated"),
        "{}",
        text(&output.stdout)
    );
}

/// A collapse ends the run with an error that names the cluster, and the state stays, readable by others.
#[test]
fn a_collapse_keeps_the_state() {
    let folder = tempfile::tempdir().expect("a folder");
    let case = "format = 1\ntitle = \"Collapse\"\nseed = 1\nreplicas = 1\n\
        [gas]\ndisks = 1000\npacking_fraction = 0.5\nrestitution = 0.1\n\
        [run]\nuntil = 100\n[engine.ed]\n";
    fs::write(folder.path().join("case.toml"), case).expect("a case");
    let output = run(folder.path(), &["run", "case.toml", "--out", "results"]);
    assert_eq!(output.status.code(), Some(1));
    let error = text(&output.stderr);
    assert!(error.contains("inelastic collapse at time"), "{error}");
    let state = folder
        .path()
        .join("results/checkpoints/replica-0-ed.stopped.xyz");
    assert!(error.contains("replica-0-ed.stopped.xyz"), "{error}");
    let state = fs::read_to_string(state).expect("a state");
    assert_eq!(state.lines().count(), 1002);
}

/// A mixture from a file, with its own velocities, as CSV and as the program's own snapshot.
#[test]
fn mixture_from_a_file_runs_in_both_engines() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut start = "# box: 30 30\nx,y,radius,mass\n".to_owned();
    for i in 0..225 {
        let (radius, mass) = if i % 2 == 0 {
            (0.5, 1.0)
        } else {
            (0.25, 0.125)
        };
        let (x, y) = (2 * (i % 15) + 1, 2 * (i / 15) + 1);
        writeln!(start, "{x},{y},{radius},{mass}").expect("a string");
    }
    fs::write(folder.path().join("start.csv"), start).expect("a start");
    let case = case_from_file();
    fs::write(folder.path().join("case.toml"), &case).expect("a case");
    let output = run(
        folder.path(),
        &["run", "case.toml", "--out", "first", "--until", "2"],
    );
    assert!(output.status.success(), "{}", text(&output.stderr));
    // The end of one run is a start for another.
    let again = case.replace("start.csv", "first/snapshots/ed-0.xyz");
    let again = again.replace(
        "placement",
        "velocities = \"file\"\ncollisions_per_particle = 0\nplacement",
    );
    let again = again.replace("replicas = 3", "replicas = 1");
    fs::write(folder.path().join("again.toml"), again).expect("a case");
    let output = run(folder.path(), &["run", "again.toml", "--until", "2"]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    assert!(
        text(&output.stdout).contains("not equilibrated"),
        "{}",
        text(&output.stdout)
    );
}

#[test]
fn check_schema_and_help_teach() {
    let folder = tempfile::tempdir().expect("a folder");
    fs::write(folder.path().join("case.toml"), CASE).expect("a case");
    let checked = run(folder.path(), &["check", "case.toml"]);
    assert!(checked.status.success());
    for word in [
        "mean_free_path",
        "t0",
        "cell_width",
        "simulators_per_cell",
        "memory",
        "roughly",
        "collisions",
    ] {
        assert!(
            text(&checked.stdout).contains(word),
            "{word} in {}",
            text(&checked.stdout)
        );
    }
    assert!(!folder.path().join("results").exists());
    let schema = run(folder.path(), &["schema"]);
    let schema: serde_json::Value = serde_json::from_slice(&schema.stdout).expect("JSON");
    assert!(schema["properties"]["gas"].is_object());
    assert!(text(&run(folder.path(), &["--help"]).stdout).contains("cases/quick.toml"));
    assert!(text(&run(folder.path(), &["run", "--help"]).stdout).contains("--resume"));
    assert_eq!(
        run(folder.path(), &["run", "case.toml", "--threads", "0"])
            .status
            .code(),
        Some(2)
    );
    assert_eq!(
        run(folder.path(), &["report", "nowhere"]).status.code(),
        Some(2)
    );
}

/// The work is what it is said to be, and numbers out of range are refused with what is allowed.
#[test]
fn bench_dsmc_measures_the_work_that_was_asked_for() {
    let folder = tempfile::tempdir().expect("a folder");
    for (dimension, free) in [("2", false), ("3", false), ("2", true)] {
        let mut arguments = vec!["bench", "dsmc", "--dimension", dimension, "--json"];
        arguments.extend(["--simulators", "30000", "--steps", "10", "--threads", "2"]);
        arguments.extend(free.then_some("--free-flight"));
        let output = run(folder.path(), &arguments);
        assert!(output.status.success(), "{}", text(&output.stderr));
        let found: serde_json::Value = serde_json::from_slice(&output.stdout).expect("an object");
        let number = |key: &str| found[key].as_f64().expect(key);
        assert!(number("particle_steps_per_second") > 0.0);
        // Of few simulators, the working memory of two threads is a good part.
        assert!(number("bytes_per_simulator") < 200.0);
        assert_eq!(number("collisions_per_second") > 0.0, !free);
        // 2e4 collisions: 0.7 % of spread, and as much by the ideal gas of the start; z = 4.
        let expected = if free { 0.0 } else { 1.0 };
        assert!((number("collision_rate_over_theory") - expected).abs() < 0.04);
        assert!((number("collisions_per_step") - 0.07 * expected).abs() < 0.003);
    }
    let output = run(folder.path(), &["bench", "dsmc", "--per-cell", "0"]);
    assert_eq!(output.status.code(), Some(2), "{}", text(&output.stderr));
    assert!(text(&output.stderr).contains("allowed"));
}
