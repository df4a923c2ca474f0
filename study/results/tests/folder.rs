//! Results folders from the outside: write access, removal of files, and completeness.
#![allow(clippy::unwrap_used, reason = "a test may stop at what it cannot read")]

use std::fs;
use std::path::Path;

use serde_json::{Value, json};
use stosszahl_results::{
    Existing, Folder, Keys, MANIFEST_FILE, Manifest, ResultsError, RunId, Snapshot, Stored, Table,
    TableCell, TableEstimate,
};

const KEYS: Keys<'static> = Keys {
    ignored: &["run.checkpoint_seconds"],
    output: &["title", "verdict"],
};

fn case(seed: u64, title: &str) -> Value {
    json!({"title": title, "seed": seed, "verdict": {"tolerance": 0.02}, "run": {"until": 5.0, "checkpoint_seconds": 30.0}})
}

fn id(case: &Value) -> Vec<RunId> {
    vec![RunId::new("", case, KEYS, &[]).unwrap()]
}

fn table(seed: u64) -> Table {
    let mut table = Table::new("energy", "Energy")
        .key("engine", "", "The engine")
        .key("time", "time unit", "When")
        .with_theory("energy_ratio", "1", "K/K(0)")
        .note("replicas", "1", "Replicas");
    let estimate = TableEstimate {
        value: Some(0.1 * seed as f64),
        standard_error: Some(f64::NAN),
        ..TableEstimate::default()
    };
    table.add(("ed", 1e-7, estimate, 3_u64));
    table
}

fn manifest() -> Manifest {
    Manifest {
        snapshots: vec![Snapshot {
            engine: "ed".into(),
            replica: 0,
            time: 1.0,
            file: "snapshots/ed-0.xyz".into(),
            blake3: String::new(),
        }],
        ..Manifest::default()
    }
}

/// Runs a case into a folder, whole or only its first half.
fn run(
    path: &Path,
    existing: Existing,
    seed: u64,
    title: &str,
    whole: bool,
) -> Result<bool, ResultsError> {
    let folder = Folder::open(path, existing, &[], id(&case(seed, title)))?;
    let place = folder.places().next().unwrap();
    if place.is_complete()? {
        return Ok(false);
    }
    place.write("checkpoints/replica-0-ed.snapshot", b"state")?;
    place.claim("checkpoints/replica-0-ed.stopped.xyz")?;
    place.write("snapshots/ed-0.xyz", format!("{seed}").as_bytes())?;
    if whole {
        place.finish(manifest(), &[table(seed)])?;
        place.remove_checkpoints()?;
    }
    Ok(true)
}

fn names(path: &Path) -> Vec<String> {
    let entries = fs::read_dir(path).unwrap().flatten();
    let mut names: Vec<String> = entries
        .map(|e| e.file_name().into_string().unwrap())
        .collect();
    names.sort();
    names
}

#[test]
fn tables_are_written_as_before_and_read_back_the_same() {
    let written = table(3);
    let bytes = written.to_csv().unwrap();
    let text = "engine,time,energy_ratio,energy_ratio_se,energy_ratio_theory,replicas\ned,1e-7,0.30000000000000004,,,3\n";
    assert_eq!(String::from_utf8(bytes).unwrap(), text);
    let place = tempfile::tempdir().unwrap();
    assert!(run(place.path(), Existing::Refuse, 3, "a", true).unwrap());
    let stored = Stored::read(place.path()).unwrap().unwrap();
    let mut expected = written;
    expected.rows[0][3] = TableCell::Empty;
    assert_eq!(stored.tables, [expected]);
    assert!(stored.changed.is_empty());
}

/// Words that a spreadsheet would compute are behind an apostrophe in the file, and read back
/// unchanged; numbers stay numbers, also negative ones.
#[test]
fn words_of_a_table_are_no_formulas() {
    let words = ["=1+1", "+1", "-x", "@sum", "'=1", "'x", "a=b", "ed", "\t=1"];
    let mut written = Table::new("energy", "Energy")
        .key("engine", "", "The engine")
        .note("value", "1", "A number");
    for word in words {
        written.add((word, -1.5));
    }
    let text = String::from_utf8(written.to_csv().unwrap()).unwrap();
    let lines: Vec<&str> = text.lines().skip(1).collect();
    let expected = [
        "'=1+1", "'+1", "'-x", "'@sum", "''=1", "'x", "a=b", "ed", "'\t=1",
    ];
    for (line, expected) in lines.iter().zip(expected) {
        assert_eq!(*line, format!("{expected},-1.5"));
    }
    let place = tempfile::tempdir().unwrap();
    let folder = Folder::open(place.path(), Existing::Refuse, &[], id(&case(7, "a"))).unwrap();
    let finished = folder.places().next().unwrap();
    finished
        .finish(Manifest::default(), &[written.clone()])
        .unwrap();
    drop(folder);
    let stored = Stored::read(place.path()).unwrap().unwrap();
    assert_eq!(stored.tables, [written]);
}

#[test]
fn a_row_that_does_not_fit_is_an_error() {
    let mut table = table(1);
    table.add("ed");
    assert!(matches!(
        table.to_csv(),
        Err(ResultsError::Length {
            line: 3,
            found: 1,
            expected: 6,
            ..
        })
    ));
}

#[test]
fn a_second_process_is_refused_while_one_writes() {
    let place = tempfile::tempdir().unwrap();
    let path = place.path().join("results");
    let open = |existing| Folder::open(&path, existing, &[], id(&case(7, "a")));
    let first = open(Existing::Refuse).unwrap();
    for existing in [Existing::Resume, Existing::Replace] {
        assert!(matches!(open(existing), Err(ResultsError::Locked { .. })));
    }
    drop(first);
    assert!(open(Existing::Resume).is_ok());
}

/// A folder moved, removed or replaced during a run is detected before each write, and its
/// replacement is left untouched.
#[cfg(unix)]
#[test]
fn a_folder_that_was_moved_or_removed_is_not_written() {
    type Change = fn(&Path);
    let aside = |path: &Path| path.with_file_name("aside");
    let moved: Change = |path| fs::rename(path, path.with_file_name("aside")).unwrap();
    let removed: Change = |path| fs::remove_dir_all(path).unwrap();
    let list_removed: Change = |path| fs::remove_file(path.join("run.files")).unwrap();
    for (change, replaced) in [
        (moved, false),
        (moved, true),
        (removed, false),
        (removed, true),
        (list_removed, false),
        (list_removed, true),
    ] {
        let place = tempfile::tempdir().unwrap();
        let path = place.path().join("results");
        let first = Folder::open(&path, Existing::Refuse, &[], id(&case(7, "a"))).unwrap();
        let run_place = first.places().next().unwrap();
        run_place
            .write("checkpoints/replica-0-ed.snapshot", b"state")
            .unwrap();
        run_place.write("snapshots/ed-0.xyz", b"7").unwrap();
        first.require_same().unwrap();
        change(&path);
        let second = replaced.then(|| {
            let seed = if path.exists() { 7 } else { 8 };
            let existing = [Existing::Refuse, Existing::Resume][usize::from(path.exists())];
            let second = Folder::open(&path, existing, &[], id(&case(seed, "a"))).unwrap();
            let place = second.places().next().unwrap();
            place
                .write("checkpoints/replica-0-ed.snapshot", b"other")
                .unwrap();
            second
        });
        let before = path.exists().then(|| names(&path));
        let is_moved = |done: Result<(), ResultsError>| {
            let error = done.unwrap_err();
            assert!(
                matches!(error, ResultsError::Moved { .. }) && error.is_system(),
                "{error}"
            );
        };
        is_moved(first.require_same());
        is_moved(run_place.write("energy.csv", b"first"));
        is_moved(run_place.claim("figures/a.svg").map(drop));
        is_moved(run_place.remove_checkpoints());
        is_moved(run_place.finish(Manifest::default(), &[table(7)]).map(drop));
        assert_eq!(path.exists().then(|| names(&path)), before);
        if second.is_some() {
            let there = fs::read(path.join("checkpoints/replica-0-ed.snapshot")).unwrap();
            assert_eq!(there, b"other");
        }
        if aside(&path).exists() {
            drop((first, second));
            let found = Folder::open(&aside(&path), Existing::Resume, &[], id(&case(7, "a")));
            found.expect("the moved folder goes on");
        }
    }
}

#[test]
fn another_seed_is_another_run_and_the_message_names_it() {
    let place = tempfile::tempdir().unwrap();
    run(place.path(), Existing::Refuse, 7, "a", true).unwrap();
    let error = run(place.path(), Existing::Resume, 99, "a", true).unwrap_err();
    assert!(
        error.to_string().contains("seed: 7 there, 99 here"),
        "{error}"
    );
    assert!(matches!(
        run(place.path(), Existing::Refuse, 7, "a", true),
        Err(ResultsError::Exists { .. })
    ));
    assert!(
        !run(place.path(), Existing::Resume, 7, "a", true).unwrap(),
        "it is complete"
    );
}

#[test]
fn tables_of_another_run_are_not_complete() {
    let place = tempfile::tempdir().unwrap();
    run(place.path(), Existing::Refuse, 7, "a", true).unwrap();
    let other = tempfile::tempdir().unwrap();
    run(other.path(), Existing::Refuse, 8, "a", true).unwrap();
    for file in ["energy.csv", "manifest.json", "snapshots/ed-0.xyz"] {
        let before = fs::read(place.path().join(file)).unwrap();
        fs::copy(other.path().join(file), place.path().join(file)).unwrap();
        if file == "energy.csv" {
            assert_eq!(
                Stored::read(place.path()).unwrap().unwrap().changed,
                ["energy.csv"]
            );
        }
        assert!(
            run(place.path(), Existing::Resume, 7, "a", true).unwrap(),
            "{file} is of another run"
        );
        assert_eq!(fs::read(place.path().join(file)).unwrap(), before);
    }
}

#[test]
fn a_change_of_the_output_continues_a_run_but_not_a_finished_one() {
    let place = tempfile::tempdir().unwrap();
    run(place.path(), Existing::Refuse, 7, "a", false).unwrap();
    run(place.path(), Existing::Resume, 7, "b", true).unwrap();
    let error = run(place.path(), Existing::Resume, 7, "c", true).unwrap_err();
    assert!(matches!(error, ResultsError::Changed { .. }));
    assert!(
        error.to_string().contains("title: \"b\" there, \"c\" here"),
        "{error}"
    );
}

#[test]
fn force_removes_what_the_run_wrote_and_nothing_else() {
    let place = tempfile::tempdir().unwrap();
    let path = place.path();
    run(path, Existing::Refuse, 7, "a", false).unwrap();
    for ours in [
        "checkpoints/replica-0-ed.stopped.xyz",
        "checkpoints/.replica-0-ed.snapshot.x0Y1z2",
        "snapshots/.ed-0.xyz.a1b2c3",
    ] {
        fs::write(path.join(ours), "x").unwrap();
    }
    for theirs in [
        "species.csv",
        "snapshots/mine.xyz",
        "snapshots/.mine.xyz.a1b2c3",
        ".notes.a1b2c3",
    ] {
        fs::write(path.join(theirs), "x").unwrap();
    }
    Folder::open(path, Existing::Replace, &[], id(&case(8, "a"))).unwrap();
    assert_eq!(
        names(path),
        [
            ".notes.a1b2c3",
            "run.files",
            "run.json",
            "snapshots",
            "species.csv"
        ]
    );
    assert_eq!(
        names(&path.join("snapshots")),
        [".mine.xyz.a1b2c3", "mine.xyz"]
    );
}

#[test]
fn a_list_that_leads_outside_removes_nothing_there() {
    let place = tempfile::tempdir().unwrap();
    let path = place.path().join("results");
    fs::write(place.path().join("precious"), "x").unwrap();
    run(&path, Existing::Refuse, 7, "a", true).unwrap();
    let precious = place.path().join("precious");
    fs::write(
        path.join("run.files"),
        format!("../precious\n{}\nenergy.csv\nman", precious.display()),
    )
    .unwrap();
    Folder::open(&path, Existing::Replace, &[], id(&case(7, "a"))).unwrap();
    assert!(precious.exists() && !path.join("energy.csv").exists());
    assert!(
        path.join("manifest.json").exists(),
        "the line was cut, so nothing was written under it"
    );
}

#[test]
fn a_lost_snapshot_is_an_error_at_the_end_and_made_again_later() {
    let place = tempfile::tempdir().unwrap();
    let folder = Folder::open(place.path(), Existing::Refuse, &[], id(&case(7, "a"))).unwrap();
    let run_place = folder.places().next().unwrap();
    assert_eq!(
        run_place.missing(["snapshots/ed-0.xyz"]),
        ["snapshots/ed-0.xyz"]
    );
    let error = run_place.finish(manifest(), &[table(7)]).unwrap_err();
    assert!(matches!(error, ResultsError::Lost { .. }));
    drop(folder);
    run(place.path(), Existing::Resume, 7, "a", true).unwrap();
    fs::remove_file(place.path().join("snapshots/ed-0.xyz")).unwrap();
    assert!(run(place.path(), Existing::Resume, 7, "a", true).unwrap());
    assert!(place.path().join("snapshots/ed-0.xyz").exists());
}

#[test]
fn the_bytes_of_a_start_file_count() {
    let place = tempfile::tempdir().unwrap();
    let file = place.path().join("start.csv");
    let run = |text: &str| {
        fs::write(&file, text).unwrap();
        RunId::new("", &case(7, "a"), KEYS, &[&file]).unwrap()
    };
    let (a, b) = (
        run("# box: 10 10\nx,y\n1,1\n"),
        run("# box: 10 12\nx,y\n1,1\n"),
    );
    assert_ne!(a.numbers, b.numbers);
    let results = place.path().join("results");
    Folder::open(&results, Existing::Refuse, &[], vec![a]).unwrap();
    let error = Folder::open(&results, Existing::Resume, &[], vec![b]).unwrap_err();
    assert!(
        error.to_string().contains("files that the case reads"),
        "{error}"
    );
}

#[test]
fn how_often_a_run_is_saved_does_not_matter() {
    let mut often = case(7, "a");
    often["run"]["checkpoint_seconds"] = json!(1.0);
    assert_eq!(id(&often)[0].output, id(&case(7, "a"))[0].output);
    let (a, b) = (&id(&case(7, "a"))[0], &id(&case(7, "b"))[0]);
    assert!(a.numbers == b.numbers && a.output != b.output);
}

#[test]
fn folders_of_others_are_left_alone() {
    let place = tempfile::tempdir().unwrap();
    let open = |existing| Folder::open(place.path(), existing, &[], id(&case(7, "a")));
    assert!(matches!(
        open(Existing::Resume),
        Err(ResultsError::NothingToResume { .. })
    ));
    fs::write(place.path().join("thesis.tex"), "x").unwrap();
    for existing in [Existing::Refuse, Existing::Replace] {
        assert!(matches!(
            open(existing),
            Err(ResultsError::NotResults { .. })
        ));
    }
    assert_eq!(names(place.path()), ["thesis.tex"]);
    let old = r#"{"program":"stosszahl","version":"0.1.0","runs":{"":"00"}}"#;
    fs::write(place.path().join("run.json"), old).unwrap();
    let error = open(Existing::Replace).unwrap_err();
    assert!(
        error
            .to_string()
            .contains("has format 1, this program knows format 2"),
        "{error}"
    );
}

#[test]
fn an_input_inside_is_not_removed() {
    let place = tempfile::tempdir().unwrap();
    run(place.path(), Existing::Refuse, 7, "a", true).unwrap();
    let input = place.path().join("snapshots/ed-0.xyz");
    let error = Folder::open(
        place.path(),
        Existing::Replace,
        &[&input],
        id(&case(7, "a")),
    )
    .unwrap_err();
    assert!(matches!(error, ResultsError::InputInside { .. }) && input.exists());
}

#[test]
fn a_folder_that_cannot_be_is_named() {
    let place = tempfile::tempdir().unwrap();
    let file = place.path().join("file");
    fs::write(&file, "x").unwrap();
    let error = Folder::open(
        &file.join("results"),
        Existing::Refuse,
        &[],
        id(&case(7, "a")),
    )
    .unwrap_err();
    // The request is at fault, not the system: another folder helps.
    assert!(
        !error.is_system() && error.to_string().contains("file/results: cannot be made"),
        "{error}"
    );
}

#[test]
fn points_of_a_sweep_stay_inside() {
    let place = tempfile::tempdir().unwrap();
    for name in ["../up", "/root", "a\nb"] {
        let runs = vec![RunId::new(name, &case(7, "a"), KEYS, &[]).unwrap()];
        assert!(matches!(
            Folder::open(place.path(), Existing::Refuse, &[], runs),
            Err(ResultsError::Name { .. })
        ));
    }
    let runs = ["a", "b"].map(|name| RunId::new(name, &case(7, "a"), KEYS, &[]).unwrap());
    let folder = Folder::open(place.path(), Existing::Refuse, &[], runs.to_vec()).unwrap();
    for point in folder.places() {
        point.write("checkpoints/x.snapshot", b"x").unwrap();
    }
    folder
        .places()
        .next()
        .unwrap()
        .remove_checkpoints()
        .unwrap();
    assert_eq!(names(place.path()), ["b", "run.files", "run.json"]);
}

#[test]
fn manifests_of_other_formats_and_damaged_ones_say_what_they_are() {
    let place = tempfile::tempdir().unwrap();
    assert!(Stored::read(place.path()).unwrap().is_none());
    let file = place.path().join("manifest.json");
    let message = |text: &str| {
        fs::write(&file, text).unwrap();
        Stored::read(place.path()).unwrap_err().to_string()
    };
    assert!(message(r#"{"format": 1}"#).contains("found format 1, this program reads format 2"));
    assert!(message("{}").contains("found format nothing"));
    assert!(message(r#"{"format": 2, "program": {"name": 3}}"#).contains("key program.name"));
    assert!(message("{").contains("line 1"));
    let empty = serde_json::to_string(&Manifest {
        format: 2,
        ..Manifest::default()
    })
    .unwrap();
    assert!(message(&empty).contains("names no table"));
}

#[test]
fn damaged_tables_say_where() {
    let place = tempfile::tempdir().unwrap();
    run(place.path(), Existing::Refuse, 7, "a", true).unwrap();
    let file = place.path().join("energy.csv");
    let text = fs::read_to_string(&file).unwrap();
    let message = |text: &str| {
        fs::write(&file, text).unwrap();
        Stored::read(place.path()).unwrap_err().to_string()
    };
    assert!(
        message(&text.replace("1e-7", "soon"))
            .contains("line 2, column time: found \"soon\"; expected a finite number")
    );
    assert!(message(&text.replace("1e-7", "inf")).contains("expected a finite number"));
    assert!(message(&text.replace("time", "day")).contains("found the columns engine,day"));
    assert!(message(&text.replace("1e-7,", "")).contains("line 2: found 5 cells; expected 6"));
    assert!(message(text.lines().next().unwrap()).contains("found 0 rows; expected 1"));
    fs::remove_file(&file).unwrap();
    assert!(
        Stored::read(place.path())
            .unwrap_err()
            .to_string()
            .contains("energy.csv is missing")
    );
}

#[test]
fn an_unreadable_manifest_is_an_error_and_a_damaged_one_repeats_the_run() {
    let place = tempfile::tempdir().unwrap();
    let again = || run(place.path(), Existing::Resume, 3, "a", true);
    assert!(run(place.path(), Existing::Refuse, 3, "a", true).unwrap());
    assert!(!again().unwrap());
    let file = place.path().join(MANIFEST_FILE);
    fs::write(&file, "{").unwrap();
    assert!(again().unwrap());
    fs::remove_file(&file).unwrap();
    fs::create_dir(&file).unwrap();
    assert!(matches!(again(), Err(ResultsError::System { .. })));
}
