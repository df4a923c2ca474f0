//! `stosszahl frontier` and the error budget, from the command line.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

const CASE: &str = "format = 2
title = \"A small gas\"
seed = 3
replicas = 1
[gas]
number = 100
restitution = 0.8
[box]
packing_fraction = 0.25
[run]
until = 1
[engine.ed]
[engine.dsmc-enskog]
cell_size = 2.0
";

/// Writes a case file into a folder.
fn case(folder: &Path, text: &str) -> PathBuf {
    let path = folder.join("small.toml");
    fs::write(&path, text).expect("written");
    path
}

fn stosszahl(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_stosszahl"))
        .args(arguments)
        .output()
        .expect("the program runs")
}

fn text(path: &Path) -> &str {
    path.to_str().expect("a path in UTF-8")
}

/// Returns a table without the columns that timings decide.
fn untimed(path: &Path) -> Vec<Vec<String>> {
    let mut reader = csv::Reader::from_path(path).expect("a table");
    let names = reader.headers().expect("names").clone();
    let timed = ["core_seconds", "wall_seconds", "on_front"];
    let rows = reader.records().map(|row| {
        let row = row.expect("a row");
        let cells = names.iter().zip(&row);
        let kept = cells.filter(|(name, _)| !timed.contains(name));
        kept.map(|(_, cell)| cell.to_owned()).collect()
    });
    rows.collect()
}

/// Two sweeps of a case give the same tables but for timings, whatever the threads, and whether the
/// reference is made or found; a reference that was changed is refused.
#[test]
fn sweeps_repeat_and_changed_references_are_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let case = case(folder.path(), CASE);
    let [first, second] = ["first", "second"].map(|name| folder.path().join(name));
    let sweep = |out: &Path, threads: &str, more: &[&str]| {
        let common = [
            "frontier",
            text(&case),
            "--budget",
            "3s",
            "--tests",
            "2",
            "--out",
            text(out),
            "--threads",
            threads,
        ];
        stosszahl(&[&common, more].concat())
    };
    let done = sweep(&first, "1", &["--target-error", "20%"]);
    assert!(
        done.status.success(),
        "{}",
        String::from_utf8_lossy(&done.stderr)
    );
    let said = String::from_utf8(done.stdout).expect("text");
    assert!(
        said.contains("Exact dynamics: for 20 % in energy, the cheapest setting is"),
        "{said}"
    );
    let done = sweep(
        &second,
        "2",
        &["--target-error", "20%", "--cache", text(&first)],
    );
    assert!(
        done.status.success(),
        "{}",
        String::from_utf8_lossy(&done.stderr)
    );
    let said = String::from_utf8(done.stdout).expect("text");
    assert!(said.contains("(0 made now)"), "{said}");
    let table = untimed(&first.join("frontier.csv"));
    assert!(table.len() > 100, "{}", table.len());
    assert_eq!(table, untimed(&second.join("frontier.csv")));
    let [a, b] = [&first, &second].map(|out| fs::read(out.join("orders.csv")).expect("orders"));
    assert_eq!(a, b);
    assert!(first.join("recommendation.md").exists());
    let page = fs::read_to_string(first.join("frontier.html")).expect("a page");
    assert!(page.contains("<svg") && !page.contains("NaN"));
    let files = fs::read_dir(&first).expect("files");
    let mut paths = files.map(|entry| entry.expect("a file").path());
    let kept = paths.find(|path| path.extension().is_some_and(|end| end == "snapshot"));
    let kept = kept.expect("a kept reference");
    let mut bytes = fs::read(&kept).expect("bytes");
    let last = bytes.len() - 1;
    bytes[last] ^= 1;
    fs::write(&kept, bytes).expect("written");
    let done = sweep(&second, "2", &["--cache", text(&first), "--force"]);
    assert_eq!(done.status.code(), Some(2));
    let said = String::from_utf8(done.stderr).expect("text");
    assert!(
        said.contains("hash") && said.contains("remove the file"),
        "{said}"
    );
}

#[test]
fn what_cannot_be_swept_is_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = case(folder.path(), CASE);
    let out = folder.path().join("out");
    let refused = |path: &Path, more: &[&str], words: &str| {
        let common = ["frontier", text(path), "--out", text(&out)];
        let done = stosszahl(&[&common, more].concat());
        assert_eq!(done.status.code(), Some(2), "{more:?}");
        let said = String::from_utf8(done.stderr).expect("text");
        assert!(said.contains(words), "{more:?}: {said}");
        assert!(!out.exists(), "{more:?} left a folder");
    };
    refused(
        &path,
        &["--target-error", "2"],
        "--target-error 2: allowed is a share",
    );
    refused(
        &path,
        &["--budget", "soon"],
        "invalid value 'soon' for '--budget <TIME>'",
    );
    refused(&path, &["--threads", "0"], "0 is not in 1..=1024");
    let swept = CASE.to_owned() + "[[sweep]]\n\"gas.restitution\" = [0.8, 0.9]\n";
    let path = case(folder.path(), &swept);
    refused(&path, &[], "a sweep of 2 points");
    let full = folder.path().join("full");
    fs::create_dir(&full).expect("a folder");
    fs::write(full.join("mine.txt"), "mine").expect("written");
    let path = case(folder.path(), CASE);
    let done = stosszahl(&["frontier", text(&path), "--out", text(&full)]);
    assert_eq!(done.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&done.stderr).contains("is no results folder"));
}

/// Cells of two diameters at packing 0.25 hold 1.27 disks and are almost three mean free paths
/// wide: the budget says so, and that one replica has no error.
#[test]
fn runs_carry_an_error_budget() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = case(folder.path(), CASE);
    let out = folder.path().join("out");
    let done = stosszahl(&["run", text(&path), "--out", text(&out)]);
    assert!(
        done.status.success(),
        "{}",
        String::from_utf8_lossy(&done.stderr)
    );
    let mut table = csv::Reader::from_path(out.join("error_budget.csv")).expect("a table");
    let rows: Vec<Vec<String>> = table
        .records()
        .map(|row| row.expect("a row").iter().map(str::to_owned).collect())
        .collect();
    let find = |engine: &str, source: &str| {
        let row = rows.iter().find(|row| row[0] == engine && row[1] == source);
        row.unwrap_or_else(|| panic!("{engine}, {source}: {rows:?}"))
    };
    let number = |cell: &str| cell.parse::<f64>().expect("a number");
    let cell = find("dsmc-enskog", "cell");
    // Cells fit the box of 17.72 d: 8 of 2.215 d; the mean free path is 0.7017 d.
    assert!((number(&cell[2]) - 2.215 / 0.7017).abs() < 0.01, "{cell:?}");
    assert_eq!(cell[5], "red");
    let few = find("dsmc-enskog", "simulators per cell");
    assert!((number(&few[2]) - 100.0 / 64.0).abs() < 1e-12, "{few:?}");
    assert_eq!(few[5], "red");
    assert_eq!(find("dsmc-enskog", "limited cells")[5], "green");
    let beyond = find("dsmc-enskog", "majorant");
    assert!(
        (0.0..0.1).contains(&number(&beyond[2])) && beyond[5] != "red",
        "{beyond:?}"
    );
    assert_eq!(find("ed", "replicas")[5], "red");
    let page = fs::read_to_string(out.join("report.html")).expect("a page");
    assert!(page.contains("error_budget.csv"));
}

/// A pilot chooses simulators and steps, the same for any number of threads, and says why; an
/// invalid target is refused, and so is a gas without theory.
#[test]
fn accuracy_is_chosen_by_a_pilot() {
    let folder = tempfile::tempdir().expect("a folder");
    let asking = CASE.replace(
        "[engine.dsmc-enskog]\ncell_size = 2.0",
        "[engine.dsmc-contact-point]",
    ) + "[accuracy]\ntarget = \"10%\"\n";
    let path = case(folder.path(), &asking);
    let runs = ["1", "2"].map(|threads| {
        let out = folder.path().join(threads);
        let done = stosszahl(&[
            "run",
            text(&path),
            "--out",
            text(&out),
            "--threads",
            threads,
            "--verbose",
        ]);
        assert!(
            done.status.success(),
            "{}",
            String::from_utf8_lossy(&done.stderr)
        );
        let said = String::from_utf8(done.stdout).expect("text");
        assert!(said.contains("note       dsmc-contact-point: "), "{said}");
        let manifest = fs::read(out.join("manifest.json")).expect("a manifest");
        let manifest: serde_json::Value = serde_json::from_slice(&manifest).expect("JSON");
        let page = fs::read_to_string(out.join("report.html")).expect("a page");
        assert!(page.contains("because a pilot of"));
        let energy = fs::read(out.join("energy.csv")).expect("a table");
        (manifest["choices"].to_string(), energy)
    });
    assert_eq!(runs[0], runs[1]);
    assert!(
        runs[0].0.contains("sure to be within 10 %"),
        "{}",
        runs[0].0
    );
    let refused = |content: &str, words: &[&str]| {
        let path = case(folder.path(), content);
        let done = stosszahl(&["check", text(&path)]);
        assert_eq!(done.status.code(), Some(2));
        let said = String::from_utf8(done.stderr).expect("text");
        assert!(words.iter().all(|word| said.contains(word)), "{said}");
    };
    let much = asking.replace("10%", "much");
    refused(&much, &["accuracy.target", "a share in quotes"]);
    let driven = asking + "[thermostat]\nkind = \"white-noise\"\nheating = 1\ninterval = 0.1\n";
    refused(&driven, &["a driven gas"]);
}
