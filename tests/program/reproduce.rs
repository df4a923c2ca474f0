//! Papers: a tiny one from its file to its verdicts, refusals that name the line, and the bundled
//! ones, whose runs, points, tables and columns must exist.

use std::fs;
use std::path::{Path, PathBuf};

use crate::support::program::{CASES, COOLING, TestFolder};
use stosszahl::case::PaperFile;
use stosszahl::reproduction::{ReproduceOptions, Reproduction};

/// A paper of two claims that hold, one that does not, one that is corrected, one that has no
/// number, and one for full runs only.
const PAPER: &str = r#"format = 1
title = "A tiny paper"
source = "Nobody (2000)"
[run.cooling]
case = "case.toml"
set = { replicas = 4 }
quick = { "gas.number" = 200 }
[run.weak]
case = "case.toml"
set = { "gas.restitution" = 0.95, replicas = 4, "run.until" = 1 }
[[figure]]
name = "1"
title = "Energy"
run = "cooling"
tables = ["energy.1"]
missing = "the third curve"
[[figure.claim]]
claim = "Energy of the start"
table = "energy"
column = "energy_ratio"
where = { engine = "ed", time = 0 }
value = 1
within = 1e-9
[[figure.claim]]
claim = "Energy falls"
table = "energy"
column = "energy_ratio"
where = { engine = "ed", time = 10 }
over = { where = { time = 1 } }
below = 0.5
[[figure.claim]]
claim = "Planted"
table = "energy"
column = "energy_ratio"
where = { engine = "ed", time = 1 }
value = 0.9
margin = 0.2
corrected = 0.27
correction = "A number that was made up."
[[figure.claim]]
claim = "Beyond the end"
table = "energy"
column = "energy_ratio"
where = { engine = "ed", time = 50 }
above = 0
[[figure]]
name = "Table I"
title = "Weak dissipation"
run = "weak"
[[figure.claim]]
claim = "About as much energy is left at the same share of Haff's time"
table = "energy"
column = "energy_ratio"
where = { engine = "ed", time = 1 }
over = { run = "cooling" }
above = 0.8
quick = false
[[figure.claim]]
claim = "Replicas are averaged"
run = "cooling"
table = "replicas"
column = "energy_ratio"
where = { engine = "ed" }
along = "time"
values = [[0, 1]]
within = 1e-9
"#;

/// Returns the verdicts of `claims.csv`, by claim and relation.
fn verdicts(work: &TestFolder, file: &str) -> Vec<[String; 3]> {
    let mut reader = csv::Reader::from_path(work.path(file)).expect("a table");
    let names = reader.headers().expect("names").clone();
    let column = |name: &str| names.iter().position(|one| one == name).expect("a column");
    let columns = ["claim", "relation", "verdict"].map(column);
    let rows = reader.records().map(|row| row.expect("a row"));
    rows.map(|row| columns.map(|column| row[column].to_owned()))
        .collect()
}

#[test]
fn a_tiny_paper_is_made_again() {
    let work = TestFolder::new(COOLING);
    work.write("paper.toml", PAPER);
    let said = work.done("reproduce paper.toml --out out --threads 1");
    assert!(
        said.out.contains("7 claims: 5 agree, 1 differ, 1 void"),
        "{}",
        said.out
    );
    let found = verdicts(&work, "out/claims.csv");
    let of = |claim: &str| -> Vec<(&str, &str)> {
        let own = found.iter().filter(|one| one[0] == claim);
        own.map(|one| (one[1].as_str(), one[2].as_str())).collect()
    };
    assert_eq!(of("Energy of the start"), [("equal", "agree")]);
    assert_eq!(of("Energy falls"), [("below", "agree")]);
    assert_eq!(of("Planted"), [("equal", "differ"), ("corrected", "agree")]);
    assert_eq!(of("Beyond the end"), [("above", "void")]);
    assert_eq!(
        of("About as much energy is left at the same share of Haff's time"),
        [("above", "agree")]
    );
    assert_eq!(of("Replicas are averaged"), [("equal", "agree")]);
    let page = work.text("out/report.html");
    for word in [
        "A tiny paper",
        "Nobody (2000)",
        "the third curve",
        "A number that was made up.",
        "./cooling/report.html",
        "./weak/report.html",
        "≠ differ",
        "<svg",
        "Table I",
    ] {
        assert!(page.contains(word), "no {word}");
    }
    assert!(work.path("out/cooling/report.html").exists());

    // Finished runs are kept, and the output is equal.
    let kept = fs::read(work.path("out/cooling/manifest.json")).expect("a manifest");
    let again = work.done("reproduce paper.toml --out out --threads 2");
    assert_eq!(again.out, said.out);
    assert_eq!(
        fs::read(work.path("out/cooling/manifest.json")).expect("a manifest"),
        kept
    );
    assert_eq!(verdicts(&work, "out/claims.csv"), found);

    // One figure has its own files; its claims still share the false-alarm rate of the whole paper.
    let one = work.done("reproduce paper.toml --out out --figure 1");
    assert!(
        one.out.contains("5 claims: 3 agree, 1 differ, 1 void"),
        "{}",
        one.out
    );
    assert_eq!(verdicts(&work, "out/figure-1-claims.csv"), found[..5]);
    assert!(work.path("out/figure-1-report.html").exists());
    assert_eq!(work.text("out/report.html"), page);

    // Runs of another kind and other files do not mix with these.
    work.refused(
        "reproduce paper.toml --out out --quick",
        &["out", "another paper or demand", "--out"],
    );
    work.write("note", "kept");
    work.refused("reproduce paper.toml --out .", &["not empty", "--out"]);
    let quick = work.done("reproduce paper.toml --out small --quick --figure 1");
    assert!(quick.out.contains("5 claims"), "{}", quick.out);
    assert!(
        !work.path("small/weak").exists(),
        "a figure needs its own runs only"
    );
}

/// Errors of a paper are found before anything is run, with file, line and key.
#[test]
fn errors_of_a_paper_name_its_lines() {
    let work = TestFolder::new(COOLING);
    let cases: &[(&str, &str, &[&str])] = &[
        ("format = 1", "format = 3", &["paper.toml:1:", "format 1"]),
        (
            "case = \"case.toml\"\nset = { replicas = 4 }",
            "case = \"cooling\"",
            &["paper.toml:5:", "run.cooling.case", "bundled"],
        ),
        (
            "\"gas.number\" = 200",
            "\"gas.numbre\" = 200",
            &["paper.toml:7:", "gas.numbre", "did you mean number"],
        ),
        (
            "run = \"cooling\"\ntables",
            "run = \"colling\"\ntables",
            &["paper.toml:14:", "figure.1.run", "cooling, weak"],
        ),
        (
            "[\"energy.1\"]",
            "[\"energy.7\"]",
            &["paper.toml:15:", "figure.1.tables.1", "energy"],
        ),
        (
            "column = \"energy_ratio\"\nwhere = { engine = \"ed\", time = 0 }",
            "column = \"energie\"",
            &["paper.toml:20:", "energie", "energy_ratio"],
        ),
        (
            "table = \"energy\"\ncolumn = \"energy_ratio\"\nwhere = { engine = \"ed\", time = 0 }",
            "table = \"energies\"\ncolumn = \"energy_ratio\"",
            &["paper.toml:19:", "energies", "comparison"],
        ),
        (
            "engine = \"ed\", time = 0",
            "engin = \"ed\"",
            &["paper.toml:21:", "figure.1.claim.1.where", "engine"],
        ),
        (
            "value = 1\nwithin = 1e-9\n[[figure.claim]]\nclaim = \"Energy falls\"",
            "within = 1e-9\n[[figure.claim]]\nclaim = \"Energy falls\"",
            &["paper.toml:17:", "figure.1.claim.1.value"],
        ),
        ("margin = 0.2\n", "", &["figure.1.claim.3.margin"]),
        (
            "name = \"Table I\"",
            "name = \"1\"",
            &["paper.toml:47:", "figure.2.name", "differ"],
        ),
        (
            "over = { run = \"cooling\" }",
            "over = { run = \"cool\" }",
            &["figure.2.claim.1.over.run"],
        ),
        (
            "quick = false",
            "point = { \"gas.restitution\" = 0.5 }",
            &["figure.2.claim.1.point", "0 of 1"],
        ),
        (
            "title = \"Energy\"",
            "titel = \"Energy\"",
            &["paper.toml:13:", "figure.1.titel", "title"],
        ),
    ];
    for (good, bad, words) in cases {
        assert!(PAPER.contains(good), "{good}");
        work.write("paper.toml", PAPER.replacen(good, bad, 1));
        let quick = if bad.contains("numbre") {
            " --quick"
        } else {
            ""
        };
        work.refused(&format!("reproduce paper.toml --out out{quick}"), words);
        assert!(!work.path("out").exists(), "{bad}");
    }
    work.write("paper.toml", PAPER);
    work.refused(
        "reproduce paper.toml --figure 7 --out out",
        &["--figure 7", "1, Table I"],
    );
    work.refused(
        "reproduce unknown-2000",
        &["unknown-2000", "stosszahl reproduce"],
    );
}

/// Returns the files of the papers that come with the program.
fn papers() -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("cases/papers");
    let entries = fs::read_dir(folder).expect("the papers");
    let mut all: Vec<PathBuf> = entries.map(|entry| entry.expect("a file").path()).collect();
    all.sort();
    all
}

/// Every run of every bundled paper is a case that can be planned, and every claim names a point, a
/// table and a column of it; quick or not. Nothing is run.
#[test]
fn bundled_papers_name_what_exists() {
    let bundled =
        |name: &str| fs::read_to_string(Path::new(CASES).join(format!("{name}.toml"))).ok();
    let all = papers();
    assert_eq!(all.len(), 5);
    for path in all {
        let file = PaperFile::read(&path).unwrap_or_else(|error| panic!("{error}"));
        for quick in [false, true] {
            let demand = ReproduceOptions {
                figure: None,
                quick,
            };
            let planned = Reproduction::new(&file, demand, &bundled);
            let planned = planned.unwrap_or_else(|error| panic!("{error}"));
            for figure in planned.outline(2) {
                let known = figure.claims > 0 || figure.figure.missing.is_some();
                assert!(
                    known,
                    "{}: figure {} says nothing",
                    path.display(),
                    figure.figure.name
                );
            }
        }
    }
}

/// Without a paper all papers are listed, with their figures, times, and what is missing.
#[test]
fn papers_are_listed() {
    let work = TestFolder::new(COOLING);
    let list = work.done("reproduce").out;
    for path in papers() {
        let name = path
            .file_stem()
            .expect("a name")
            .to_string_lossy()
            .into_owned();
        assert!(
            list.lines()
                .any(|line| line.starts_with(&format!("{name}: "))),
            "{list}"
        );
        let file = PaperFile::read(&path).unwrap_or_else(|error| panic!("{error}"));
        for figure in &file.paper.figure {
            assert!(list.contains(&figure.title), "{}", figure.title);
            assert!(
                figure
                    .missing
                    .as_ref()
                    .is_none_or(|missing| list.contains(missing))
            );
        }
    }
    assert!(list.contains("roughly"), "{list}");
}
