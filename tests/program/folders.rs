//! Several processes and one results folder: one writes, the other is refused; results are never
//! mixed, also when a folder is moved or removed while it is written. Checkpoints that are damaged
//! or swapped give the same bytes, or are refused by name.
//!
//! Checks of each pair of processes hold for any order of events. A process that ends with 0 has
//! left the bytes of a run that was alone. A refused process says why, and the folder has no file
//! of the other.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Output, Stdio};
use std::thread;
use std::time::Duration;

use rand::{RngExt, SeedableRng};
use stosszahl::case::CaseFile;
use stosszahl::model::Interrupt;
use stosszahl::model::random::Stream;
use stosszahl::results::{Existing, half_written};
use stosszahl::study::{self, RunOptions};

use crate::resume::run;
use crate::support::part::part_of;
use crate::support::program::{TestFolder, assert_same, files, overridden};

/// A case of some tenths of a second, with files of all sorts.
pub(crate) const CASE: &str = r#"# What do two processes do with one folder?
format = 2
title = "a small comparison"
seed = 5
replicas = 6
[gas]
number = 150
restitution = 0.8
[box]
packing_fraction = 0.25
[start]
equilibration = 5
[run]
until = 6
checkpoint_seconds = 0.01
[engine.ed]
[engine.dsmc-enskog]
simulators_per_particle = 2
[measure.structure_factor]
times = [0, 6]
[measure.snapshots]
times = [6]
"#;

/// Case of two processes that work in one folder.
#[derive(Clone, Copy, Debug)]
enum Pair {
    /// Two runs of different seeds begin at once.
    AtOnce,
    /// Two runs of different seeds begin at once, and each may replace existing results.
    BothReplace,
    /// The folder of the first is moved, and the second begins under its name.
    Moved,
    /// The folder of the first is removed, and the second begins under its name.
    Removed,
    /// The list of files, which is the lock, is removed; the second resumes the same run.
    ListRemoved,
    /// Two frontiers of one case begin at once.
    Frontiers,
    /// A frontier and a run begin at once.
    FrontierAndRun,
    /// A frontier is killed, and the same command is given again.
    FrontierKilled,
}

const PAIRS: [Pair; 8] = [
    Pair::AtOnce,
    Pair::BothReplace,
    Pair::Moved,
    Pair::Removed,
    Pair::ListRemoved,
    Pair::Frontiers,
    Pair::FrontierAndRun,
    Pair::FrontierKilled,
];

/// Messages of the process that is not allowed to write.
const TOLD: [&str; 6] = [
    "another process is writing here",
    "exists; use --resume",
    "no longer the folder that the run began in",
    "belongs to another run",
    "is no results folder",
    // The folder was removed while a file was being written.
    "No such file or directory",
];

pub(crate) const FRONTIER: &str =
    "frontier case.toml --out out --budget 1s --tests 1 --threads 1 --until 1";

fn start(work: &TestFolder, line: &str) -> Child {
    let mut command = work.command(line);
    let child = command.stdout(Stdio::piped()).stderr(Stdio::piped());
    child.spawn().expect("the program starts")
}

fn run_line(seed: u64, out: &str) -> String {
    format!("run case.toml --threads 1 --quiet --seed {seed} --out {out}")
}

/// Waits for two processes; returns which of them succeeded, and checks that a failed one was told
/// why.
fn ends(children: [Child; 2]) -> [bool; 2] {
    children.map(|child| {
        let Output { status, stderr, .. } = child.wait_with_output().expect("an end");
        let said = String::from_utf8_lossy(&stderr);
        assert!(!said.contains("panicked"), "{said}");
        let is_told = TOLD.iter().any(|words| said.contains(words));
        assert!(status.success() || is_told, "{:?}: {said}", status.code());
        status.success()
    })
}

/// Returns all files below a folder, by their names in it, except hidden ones that a kill left
/// half-written.
pub(crate) fn all_files(folder: &Path) -> BTreeSet<PathBuf> {
    let mut all = BTreeSet::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(one) = folders.pop() {
        for entry in fs::read_dir(one).expect("a folder").flatten() {
            let path = entry.path();
            if path.is_dir() {
                folders.push(path);
            } else if half_written(&entry.file_name().to_string_lossy()).is_none() {
                all.insert(path.strip_prefix(folder).expect("inside").to_owned());
            }
        }
    }
    all
}

/// Results of undisturbed runs.
struct Alone<'a> {
    work: &'a TestFolder,
}

impl Alone<'_> {
    /// Returns the folder of a run of a seed, made at the first request.
    fn of(&self, seed: u64) -> PathBuf {
        let name = format!("alone-{seed}");
        if !self.work.path(&name).exists() {
            self.work.done(&run_line(seed, &name));
        }
        self.work.path(&name)
    }

    /// Checks that the folder has the run of this seed, all of it and nothing else.
    fn require(&self, folder: &Path, seed: u64) {
        assert_same(&self.of(seed), folder);
        assert_eq!(all_files(&self.of(seed)), all_files(folder));
        let manifest = fs::read_to_string(folder.join("manifest.json")).expect("a manifest");
        let manifest: serde_json::Value = serde_json::from_str(&manifest).expect("JSON");
        assert_eq!(manifest["seed"], seed);
    }
}

/// Waits until a process has written a file into a folder, or has ended.
fn wait_for(child: &mut Child, path: &Path) {
    while !path.exists() && child.try_wait().expect("a child").is_none() {
        thread::sleep(Duration::from_millis(1));
    }
}

/// Removes a folder into which a process still writes.
fn remove(folder: &Path) {
    while fs::remove_dir_all(folder).is_err() && folder.exists() {}
}

/// Runs two processes in one folder; returns true if the one that must wait or stop was told.
fn try_pair(work: &TestFolder, pair: Pair, stream: &mut Stream) -> bool {
    let (alone, out, aside) = (Alone { work }, work.path("out"), work.path("aside"));
    remove(&out);
    remove(&aside);
    let pause = Duration::from_millis(stream.random_range(0..150));
    let both = |lines: [&str; 2]| {
        let first = start(work, lines[0]);
        thread::sleep(pause / 10);
        ends([first, start(work, lines[1])])
    };
    match pair {
        Pair::AtOnce => {
            let ended = both([&run_line(5, "out"), &run_line(6, "out")]);
            assert_eq!(ended.iter().filter(|&&well| well).count(), 1, "{ended:?}");
            alone.require(&out, if ended[0] { 5 } else { 6 });
            true
        }
        Pair::BothReplace => {
            let lines = [5, 6].map(|seed| run_line(seed, "out") + " --force");
            let ended = both([&lines[0], &lines[1]]);
            match ended {
                [true, false] => alone.require(&out, 5),
                [false, true] => alone.require(&out, 6),
                // Runs one after the other.
                [true, true] => {
                    let seed = [5, 6]
                        .into_iter()
                        .find(|&seed| files(&alone.of(seed)) == files(&out));
                    alone.require(&out, seed.expect("the results of one"));
                }
                [false, false] => panic!("both were refused"),
            }
            ended != [true, true]
        }
        Pair::Moved | Pair::Removed => {
            let mut first = start(work, &run_line(5, "out"));
            wait_for(&mut first, &out.join("run.json"));
            thread::sleep(pause);
            if matches!(pair, Pair::Moved) {
                fs::rename(&out, &aside).expect("moved");
            } else {
                remove(&out);
            }
            let [first, second] = ends([first, start(work, &run_line(6, "out"))]);
            assert!(second, "no other process is there");
            alone.require(&out, 6);
            if aside.exists() {
                if !first {
                    work.done(&(run_line(5, "aside") + " --resume"));
                }
                alone.require(&aside, 5);
            }
            !first
        }
        Pair::ListRemoved => {
            let mut first = start(work, &run_line(5, "out"));
            wait_for(&mut first, &out.join("run.json"));
            thread::sleep(pause);
            let _ = fs::remove_file(out.join("run.files"));
            let second = start(work, &(run_line(5, "out") + " --resume"));
            let [first, second] = ends([first, second]);
            assert!(second, "the first has let go");
            alone.require(&out, 5);
            !first
        }
        Pair::Frontiers => {
            let ended = both([FRONTIER, FRONTIER]);
            assert!(ended.contains(&true), "{ended:?}");
            require_frontier(work);
            ended != [true, true]
        }
        Pair::FrontierAndRun => {
            let ended = both([FRONTIER, &run_line(5, "out")]);
            assert_eq!(ended.iter().filter(|&&well| well).count(), 1, "{ended:?}");
            if ended[0] {
                require_frontier(work);
            } else {
                alone.require(&out, 5);
            }
            true
        }
        Pair::FrontierKilled => {
            let mut first = start(work, FRONTIER);
            wait_for(&mut first, &out.join("runs.journal"));
            thread::sleep(pause);
            let _ = first.kill();
            let _ = first.wait();
            let kept = fs::metadata(out.join("runs.journal")).map_or(0, |file| file.len());
            work.done(FRONTIER);
            require_frontier(work);
            kept > 0
        }
    }
}

/// Returns the columns of a table of a frontier that do not depend on the time that runs took.
pub(crate) fn untimed(folder: &Path) -> Vec<Vec<String>> {
    let mut reader = csv::Reader::from_path(folder.join("frontier.csv")).expect("a table");
    let names = reader.headers().expect("names").clone();
    let timed = ["core_seconds", "wall_seconds", "on_front"];
    let rows = reader.records().map(|row| {
        let row = row.expect("a row");
        let cells = names
            .iter()
            .zip(&row)
            .filter(|(name, _)| !timed.contains(name));
        cells.map(|(_, cell)| cell.to_owned()).collect()
    });
    rows.collect()
}

fn require_frontier(work: &TestFolder) {
    let alone = work.path("alone-frontier");
    if !alone.exists() {
        work.done(&FRONTIER.replace("--out out", "--out alone-frontier"));
    }
    assert_eq!(untimed(&alone), untimed(&work.path("out")));
    assert!(!work.path("out/manifest.json").exists());
}

fn try_pairs(tries: std::ops::Range<usize>) -> usize {
    let work = TestFolder::new(CASE);
    let mut told = 0;
    for number in tries {
        let pair = PAIRS[number % PAIRS.len()];
        let mut stream = Stream::seed_from_u64(number as u64);
        let was_told = try_pair(&work, pair, &mut stream);
        told += usize::from(was_told);
    }
    told
}

#[test]
fn two_processes_never_mix_their_results() {
    let told = try_pairs(0..PAIRS.len());
    assert!(told > PAIRS.len() / 2, "{told}");
}

/// Long form, run by `cargo test --release --test program folders -- --ignored`.
#[test]
#[ignore = "takes some ten minutes: cargo long-tests"]
fn two_hundred_pairs_never_mix_their_results() {
    let tries = part_of(200);
    let (told, all) = (try_pairs(tries.clone()), tries.len());
    println!("{told} of {all} pairs had one that was told");
    assert!(told > all / 2, "{told} of {all}");
}

/// A frontier of another target and budget begins with the runs that are kept; one of another case
/// is refused.
#[test]
fn a_frontier_begins_with_the_runs_that_are_kept() {
    let work = TestFolder::new(CASE);
    work.done(FRONTIER);
    let kept = fs::read(work.path("out/runs.journal")).expect("a journal");
    let table = untimed(&work.path("out"));
    let said = work.done(FRONTIER);
    assert_eq!(
        fs::read(work.path("out/runs.journal")).expect("a journal"),
        kept
    );
    assert_eq!(untimed(&work.path("out")), table);
    assert!(said.out.contains("(0 made now)"), "{}", said.out);
    work.done(&format!("{FRONTIER} --budget 2s").replace("--budget 1s ", ""));
    let more = fs::read(work.path("out/runs.journal")).expect("a journal");
    assert!(more.len() > kept.len() && more.starts_with(&kept));
    work.refused(&format!("{FRONTIER} --seed 9"), &["seed: 5 there, 9 here"]);
    let mut damaged = kept.clone();
    damaged[200] ^= 1;
    work.write("out/runs.journal", damaged);
    work.refused(FRONTIER, &["runs.journal", "another hash of entry 0"]);
    work.done(&format!("{FRONTIER} --force"));
    assert_eq!(untimed(&work.path("out")), table);
}

/// The report says which tables are not those of the manifest.
#[test]
fn a_report_names_tables_that_were_changed() {
    let work = TestFolder::new(CASE);
    work.done("run case.toml --out out --replicas 1 --until 1 --set measure={}");
    let said = work.done("report out");
    assert!(said.err.is_empty(), "{}", said.err);
    let table = work.text("out/energy.csv");
    let changed = table.replacen(",1.0,", ",0.9,", 1);
    assert_ne!(table, changed);
    work.write("out/energy.csv", changed);
    let said = work.done("report out");
    assert!(
        said.err
            .contains("out/energy.csv is not the file that the run wrote"),
        "{}",
        said.err
    );
    let sweep = "run case.toml --out sweep --replicas 1 --until 1 --set measure={}";
    work.write(
        "case.toml",
        format!("{CASE}[[sweep]]\n\"gas.restitution\" = [0.8, 0.9]\n"),
    );
    let more = "--set measure.structure_factor.times=[1] --set measure.snapshots.times=[1]";
    work.done(&sweep.replace("--set measure={}", more));
    // Drawings of tables that the new run has not are gone.
    work.done(&format!("{sweep} --force"));
    work.done(&sweep.replace("sweep", "fresh"));
    assert_eq!(
        all_files(&work.path("sweep")),
        all_files(&work.path("fresh"))
    );
    let point = fs::read_dir(work.path("sweep"))
        .expect("a folder")
        .flatten();
    let point = point
        .map(|entry| entry.path())
        .find(|path| path.join("energy.csv").exists());
    let table = point.expect("a point").join("energy.csv");
    let text = fs::read_to_string(&table)
        .expect("a table")
        .replacen(",1.0,", ",0.9,", 1);
    fs::write(&table, text).expect("written");
    let said = work.done("report sweep");
    assert!(
        said.err
            .contains("energy.csv is not the file that the run wrote"),
        "{}",
        said.err
    );
    assert!(
        work.text("sweep/report.html")
            .contains("is not the file that the run wrote")
    );
}

/// Folders of stopped runs, of which files are damaged and swapped.
struct Stopped {
    file: CaseFile,
    folder: tempfile::TempDir,
    /// Folders of one case, stopped after different numbers of legs, so that each replica is in
    /// progress in one of them.
    partial: Vec<PathBuf>,
    /// Files of checkpoints in these, and in folders of another seed.
    kept: Vec<PathBuf>,
}

/// Copies a folder.
fn copy(from: &Path, to: &Path) {
    for file in all_files(from) {
        let path = to.join(&file);
        fs::create_dir_all(path.parent().expect("a folder")).expect("made");
        fs::copy(from.join(&file), path).expect("copied");
    }
}

/// Returns the files of checkpoints of a results folder.
fn checkpoints(folder: &Path) -> Vec<PathBuf> {
    let is_inside = |path: &PathBuf| {
        let parent = path.parent().and_then(Path::file_name);
        parent.is_some_and(|name| name == "checkpoints")
    };
    let files = all_files(folder).into_iter().filter(is_inside);
    files.map(|file| folder.join(file)).collect()
}

impl Stopped {
    /// Runs two points of a sweep, without a stop, and stopped after some legs.
    fn new() -> Self {
        let text = format!("{CASE}[[sweep]]\n\"gas.restitution\" = [0.8, 0.9]\n");
        let set = [
            "gas.number=60",
            "replicas=3",
            "run.until=3",
            "measure.snapshots.times=[3]",
            "measure.structure_factor.times=[3]",
        ];
        let read = |seed: &str| {
            let set: Vec<&str> = set.iter().copied().chain([seed]).collect();
            overridden(Path::new("case.toml"), &text, &set)
        };
        let (file, other) = (read("seed=5"), read("seed=6"));
        let folder = tempfile::tempdir().expect("a folder");
        let whole = folder.path().join("whole");
        let (ended, legs) = run(&file, &whole, Existing::Refuse, 1, i64::MAX);
        assert!(ended);
        let stop = |file: &CaseFile, name: &str, part: i64| {
            let out = folder.path().join(format!("{name}-{part}"));
            assert!(!run(file, &out, Existing::Refuse, 1, legs * part / 16).0);
            out
        };
        let stopped: Vec<PathBuf> = (1..14).map(|part| stop(&file, "stopped", part)).collect();
        let others = [3, 6, 9, 12].map(|part| stop(&other, "other", part));
        let folders = stopped.iter().chain(&others);
        let kept: Vec<PathBuf> = folders.flat_map(|folder| checkpoints(folder)).collect();
        assert!(kept.len() > 20, "{kept:?}");
        Self {
            file,
            folder,
            partial: stopped,
            kept,
        }
    }

    /// Resumes in a folder, and compares the results; returns the message of a refusal.
    fn go_on(&self, out: &Path) -> Result<(), String> {
        let stop = Interrupt::default();
        let options = RunOptions {
            out: Some(out.to_owned()),
            existing: Existing::Resume,
            threads: Some(1),
            ignore_memory_limit: false,
            stop: &stop,
            progress: &(),
            commit: "",
        };
        let done = study::run_case(&self.file, &options);
        done.map_err(|error| error.to_string())?;
        let whole = self.folder.path().join("whole");
        for point in fs::read_dir(&whole).expect("points").flatten() {
            if point.path().join("manifest.json").exists() {
                assert_same(&point.path(), &out.join(point.file_name()));
            }
        }
        Ok(())
    }

    /// Damages or swaps files of a stopped run and resumes it; returns true if it was refused.
    fn try_damage(&self, stream: &mut Stream) -> bool {
        let out = self.folder.path().join("out");
        remove(&out);
        copy(
            &self.partial[stream.random_range(0..self.partial.len())],
            &out,
        );
        let own = checkpoints(&out);
        let mut touched = Vec::new();
        for _ in 0..stream.random_range(1..=3) {
            let target = own[stream.random_range(0..own.len())].clone();
            let Ok(mut bytes) = fs::read(&target) else {
                continue;
            };
            let place = stream.random_range(0..bytes.len().max(1));
            let donor = &self.kept[stream.random_range(0..self.kept.len())];
            match stream.random_range(0..7) {
                0 if bytes.is_empty() => continue,
                0 => bytes[place] ^= 1 << stream.random_range(0..8),
                1 => bytes.truncate(place),
                2 => bytes.extend(vec![7; place]),
                3 => {
                    fs::remove_file(&target).expect("removed");
                    continue;
                }
                4 => {
                    // Two files of the run trade places.
                    let other = &own[stream.random_range(0..own.len())];
                    let Ok(there) = fs::read(other) else {
                        continue;
                    };
                    fs::write(other, &bytes).expect("written");
                    touched.push(other.clone());
                    bytes = there;
                }
                5 => bytes = fs::read(donor).expect("bytes"),
                // The content of another journal behind the header of this one.
                _ => {
                    let other = fs::read(donor).expect("bytes");
                    bytes.extend(&other[40.min(other.len())..]);
                }
            }
            fs::write(&target, bytes).expect("written");
            touched.push(target);
        }
        let Err(said) = self.go_on(&out) else {
            return false;
        };
        let is_named = |path: &PathBuf| said.contains(&*path.to_string_lossy());
        assert!(
            touched.iter().any(is_named),
            "{said} names none of {touched:?}"
        );
        true
    }
}

fn try_damages(tries: std::ops::Range<usize>) -> usize {
    let stopped = Stopped::new();
    let refused = tries.filter(|&number| {
        let mut stream = Stream::seed_from_u64(number as u64);
        stopped.try_damage(&mut stream)
    });
    refused.count()
}

#[test]
fn damaged_and_swapped_checkpoints_are_refused_by_name() {
    let refused = try_damages(0..24);
    assert!((6..24).contains(&refused), "{refused}");
}

/// Long form, run by `cargo test --release --test program folders -- --ignored`.
#[test]
#[ignore = "takes some minutes: cargo long-tests"]
fn two_hundred_damages_of_checkpoints_are_refused_by_name() {
    let tries = part_of(200);
    let (refused, all) = (try_damages(tries.clone()), tries.len());
    println!("{refused} of {all} were refused, the others gave the same bytes");
    assert!(refused > all / 4, "{refused} of {all}");
}

/// The checkpoint of one replica in the place of that of another is refused with both: standard
/// errors would be too small.
#[test]
fn a_checkpoint_of_another_replica_is_named() {
    let stopped = Stopped::new();
    let out = stopped.folder.path().join("out");
    // Point, replica and part of a checkpoint with this seed.
    let origin = |path: &Path| -> Option<(String, u64, String)> {
        let name = path.file_name()?.to_str()?;
        let (number, part) = name.strip_prefix("replica-")?.split_once('-')?;
        let part = part.strip_suffix(".snapshot")?.to_owned();
        let point = path.parent()?.parent()?.file_name()?.to_str()?;
        let is_own = stopped
            .partial
            .iter()
            .any(|folder| path.starts_with(folder));
        is_own.then_some((point.to_owned(), number.parse().ok()?, part))
    };
    let mut tried = 0;
    for folder in &stopped.partial {
        for target in checkpoints(folder) {
            let Some(there) = origin(&target) else {
                continue;
            };
            let fits = |path: &&PathBuf| {
                origin(path)
                    .is_some_and(|here| here.0 == there.0 && here.1 != there.1 && here.2 == there.2)
            };
            let Some(donor) = stopped.kept.iter().find(fits) else {
                continue;
            };
            copy(folder, &out);
            let inside = target.strip_prefix(folder).expect("inside");
            fs::copy(donor, out.join(inside)).expect("copied");
            let said = stopped.go_on(&out).expect_err("refused");
            let found = origin(donor).map(|(_, replica, part)| {
                format!("holds a checkpoint of {part} of replica {replica}, seed 5")
            });
            let expected = format!("expected one of {} of replica {}, seed 5", there.2, there.1);
            assert!(said.contains(&found.expect("an origin")), "{said}");
            assert!(said.contains(&expected), "{said}");
            remove(&out);
            tried += 1;
        }
    }
    assert!(tried > 3, "{tried}");
}

/// A case that `check` accepts is run to its end, also with measures that the case does not make by
/// itself; no two of its measures write one table.
#[test]
fn measures_that_are_accepted_can_be_written() {
    use crate::support::program::{CHANNEL, CLUSTERS, COOLING, MIXTURE};
    let folder = tempfile::tempdir().expect("a folder");
    let (mut ran, mut refused) = (0, 0);
    for (name, text, until) in [
        ("mixture", MIXTURE, "run.until=2"),
        ("clusters", CLUSTERS, "run.until=2"),
        ("channel", CHANNEL, "run.until=1"),
        ("cooling", COOLING, "run.until=1"),
    ] {
        for measure in study::measures::ALL {
            let own = format!("measure={{{}={{}}}}", measure.name());
            let set = [
                "replicas=1",
                until,
                "run.checkpoint_seconds=1e6",
                own.as_str(),
            ];
            let set: Vec<String> = set.iter().map(|&one| one.to_owned()).collect();
            let file = study::format().from_text(Path::new("case.toml"), text, &set);
            let Ok(file) = file else {
                refused += 1;
                continue;
            };
            let Ok(points) = study::check_case(&file) else {
                refused += 1;
                continue;
            };
            let tables = points[0].tables();
            let names: BTreeSet<&str> = tables.iter().map(|table| &*table.name).collect();
            assert_eq!(names.len(), tables.len(), "{name}: {}", measure.name());
            let out = folder.path().join(format!("{name}-{}", measure.name()));
            assert!(
                run(&file, &out, Existing::Refuse, 1, i64::MAX).0,
                "{name}: {}",
                measure.name()
            );
            ran += 1;
        }
    }
    assert!(ran > 30 && refused > 10, "{ran} ran, {refused} refused");
}
