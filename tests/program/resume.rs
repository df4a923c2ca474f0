//! A run can be stopped at any moment and continues to the same bytes: every bundled case, every
//! engine, stopped after random legs, with other numbers of threads each time.
//!
//! Nothing here looks at a clock: legs are counted as they are reported, and the run is asked to
//! stop when a count that was drawn with a fixed seed is reached. With several threads it depends
//! on the machine which legs the others have done by then; results must not.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicI64, Ordering};

use crate::support::part::part_of;
use crate::support::program::{
    CLUSTERS, COOLING, MIXTURE, SHRUNKEN, SMALL, TestFolder, assert_same, bundled, manifest,
    overridden,
};
use rand::{RngExt, SeedableRng};
use stosszahl::case::CaseFile;
use stosszahl::model::Interrupt;
use stosszahl::model::random::Stream;
use stosszahl::results::Existing;
use stosszahl::study::{self, Progress, RunOptions};

/// Progress that asks a run to stop when some legs are done.
struct Legs {
    left: AtomicI64,
    stop: Interrupt,
}

impl Legs {
    fn new(count: i64) -> Self {
        let stop = Interrupt::default();
        if count == 0 {
            stop.raise();
        }
        Self {
            left: AtomicI64::new(count),
            stop,
        }
    }
}

impl Progress for Legs {
    fn tell_share(&self, _point: usize, _part: usize, share: f64, _collisions: u64) {
        // A finished part also reports, with a share of 1.
        if share < 1.0 && self.left.fetch_sub(1, Ordering::Relaxed) == 1 {
            self.stop.raise();
        }
    }
}

/// Runs a case until a number of legs are done; returns whether it ended before, and the legs that
/// it did.
pub(crate) fn run(
    file: &CaseFile,
    out: &Path,
    existing: Existing,
    threads: usize,
    legs: i64,
) -> (bool, i64) {
    let progress = Legs::new(legs);
    let options = RunOptions {
        out: Some(out.to_owned()),
        existing,
        threads: Some(threads),
        ignore_memory_limit: false,
        stop: &progress.stop,
        progress: &progress,
        commit: "",
    };
    let ended = match study::run_case(file, &options) {
        Ok(_) => true,
        Err(error) => {
            assert!(error.is_interruption(), "{}: {error}", out.display());
            false
        }
    };
    (ended, legs - progress.left.load(Ordering::Relaxed))
}

/// Runs a case without a stop, and in chains of pieces that are cut with some seeds; returns the
/// number of stops in all.
fn assert_resumes(name: &str, file: &CaseFile, seeds: std::ops::Range<u64>) -> usize {
    let folder = tempfile::tempdir().expect("a folder");
    let whole = folder.path().join("whole");
    let (ended, legs) = run(file, &whole, Existing::Refuse, 1, i64::MAX);
    assert!(ended && legs > 3, "{name}: {legs} legs");
    let mut stops = 0;
    for seed in seeds {
        let out = folder.path().join(format!("pieces-{seed}"));
        let mut stream = Stream::seed_from_u64(seed);
        let mut existing = Existing::Refuse;
        // About five pieces, each with at least some work.
        let longest = (legs / 3).max(2);
        for piece in 0.. {
            assert!(piece < 1000, "{name}: no end");
            let (threads, count) = (stream.random_range(1..=3), stream.random_range(0..=longest));
            let (ended, _) = run(file, &out, existing, threads, count);
            existing = Existing::Resume;
            if ended {
                break;
            }
            stops += 1;
        }
        compare(&whole, &out);
        fs::remove_dir_all(&out).expect("removed");
    }
    assert!(stops > 0, "{name} was never stopped");
    stops
}

/// Compares two results folders, and those of the points of a sweep.
fn compare(whole: &Path, pieces: &Path) {
    let inside = |folder: &Path| -> Vec<PathBuf> {
        let entries = fs::read_dir(folder)
            .expect("a folder")
            .map(|entry| entry.expect("one").path());
        entries
            .filter(|path| path.join("manifest.json").exists())
            .collect()
    };
    if whole.join("manifest.json").exists() {
        return assert_same(whole, pieces);
    }
    let points = inside(whole);
    assert!(!points.is_empty());
    for point in points {
        assert_same(&point, &pieces.join(point.file_name().expect("a name")));
    }
}

/// Reads a bundled case in its small form, of which two points stand for a sweep.
fn small(name: &str, set: &str) -> CaseFile {
    let text = fs::read_to_string(bundled(name)).expect("a case");
    let set: Vec<&str> = set.split(' ').chain(["replicas=2"]).collect();
    let mut file = overridden(&bundled(name), &text, &set);
    file.points.truncate(2);
    file
}

#[test]
fn every_bundled_case_resumes_to_the_same_bytes() {
    for (number, (name, set)) in SHRUNKEN.iter().enumerate() {
        let seed = number as u64;
        let stops = assert_resumes(name, &small(name, set), seed..seed + 1);
        println!("{name}: {stops} stops");
    }
}

/// The small cases, which together have all measures, and each engine that the box allows.
#[test]
fn every_engine_resumes_to_the_same_bytes() {
    for (number, (name, text)) in SMALL.iter().enumerate() {
        let file = overridden(Path::new("case.toml"), text, &["replicas=2"]);
        assert_resumes(name, &file, 100 + number as u64..101 + number as u64);
    }
    let periodic = "format = 2\ntitle = \"all engines\"\nreplicas = 2\n[gas]\nnumber = 150\nrestitution = 0.9\n\
                    [box]\npacking_fraction = 0.1\n[run]\nuntil = 2\n[engine.ed]\n[engine.dsmc-boltzmann]\nsimulators_per_particle = 2\n\
                    [engine.dsmc-free-volume]\nsimulators_per_particle = 2\n[engine.dsmc-enskog]\nsimulators_per_particle = 2\n\
                    [engine.dsmc-esmc]\nsimulators_per_particle = 2\n[engine.dsmc-stochastic-disks]\n\
                    [engine.dsmc-contact-point]\n[measure.displacement]\n[measure.velocity_autocorrelation]\n";
    assert_resumes(
        "all engines",
        &overridden(Path::new("case.toml"), periodic, &[]),
        200..201,
    );
    for selection in ["alias-tables", "low-rank", "single-majorant"] {
        for text in [MIXTURE, CLUSTERS] {
            let set = format!("engine.dsmc-homogeneous.selection={selection}");
            let short = ["run.until=20", "measure={}", "replicas=2", set.as_str()];
            let file = overridden(Path::new("case.toml"), text, &short);
            assert_resumes(selection, &file, 300..301);
        }
    }
}

/// Stops before the first leg, and many in a row, lose nothing.
#[test]
fn stops_without_a_leg_between_lose_nothing() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = overridden(
        Path::new("case.toml"),
        COOLING,
        &["replicas=1", "run.until=1"],
    );
    let [whole, pieces] = ["whole", "pieces"].map(|name| folder.path().join(name));
    let (_, legs) = run(&file, &whole, Existing::Refuse, 1, i64::MAX);
    let mut existing = Existing::Refuse;
    let mut runs = 0;
    while !run(&file, &pieces, existing, 1, i64::from(runs % 2)).0 {
        existing = Existing::Resume;
        runs += 1;
        assert!(i64::from(runs) < 4 * legs + 100, "no end");
    }
    assert!(runs > 10, "{runs}");
    assert_same(&whole, &pieces);
}

/// A snapshot that is lost between stop and resume is noticed: it is named, or made again.
#[test]
fn a_lost_snapshot_is_not_passed_over() {
    let folder = tempfile::tempdir().expect("a folder");
    let set = ["replicas=1", "measure.snapshots.times=[0, 10]"];
    let file = overridden(Path::new("case.toml"), COOLING, &set);
    let [whole, pieces] = ["whole", "pieces"].map(|name| folder.path().join(name));
    let (_, legs) = run(&file, &whole, Existing::Refuse, 1, i64::MAX);
    assert!(!run(&file, &pieces, Existing::Refuse, 1, legs / 2).0);
    let snapshots = pieces.join("snapshots");
    for entry in fs::read_dir(&snapshots).into_iter().flatten() {
        fs::remove_file(entry.expect("a snapshot").path()).expect("removed");
    }
    assert!(run(&file, &pieces, Existing::Resume, 1, i64::MAX).0);
    assert_same(&whole, &pieces);
}

/// A snapshot that is lost, or changed, after the end is noticed, too.
#[test]
fn a_finished_run_without_its_snapshot_is_not_finished() {
    let work = TestFolder::new(COOLING);
    let line = "run case.toml --out out --replicas 1 --until 1 --set measure.snapshots.times=[0,1]";
    work.done(line);
    work.done(&line.replace("--out out", "--out whole"));
    let snapshots = manifest(&work.path("out")).snapshots;
    assert_eq!(snapshots.len(), 6, "two of each engine");
    assert!(work.text("out/report.html").contains("id=\"snapshots\""));
    let file = format!("out/{}", snapshots[1].file);
    fs::remove_file(work.path(&file)).expect("removed");
    work.done(&format!("{line} --resume"));
    assert_same(&work.path("whole"), &work.path("out"));
    work.write(&file, "0\n\n");
    work.done(&format!("{line} --resume"));
    assert_same(&work.path("whole"), &work.path("out"));
}

/// Checkpoints that are damaged are named, and never taken for others; nothing is lost by that.
#[test]
fn damaged_checkpoints_are_refused_by_the_program() {
    let work = TestFolder::new(COOLING);
    let file = overridden(&work.path("case.toml"), COOLING, &[]);
    let out = work.path("out");
    assert!(!run(&file, &out, Existing::Refuse, 1, 8).0);
    let checkpoints: Vec<PathBuf> = fs::read_dir(out.join("checkpoints"))
        .expect("checkpoints")
        .map(|entry| entry.expect("one").path())
        .collect();
    for (ending, places) in [
        ("snapshot", vec![0, 12, 60, usize::MAX]),
        ("journal", vec![0, 12]),
    ] {
        let of_kind = checkpoints
            .iter()
            .filter(|path| path.extension().is_some_and(|end| end == ending));
        let chosen = of_kind.max().expect("a checkpoint");
        let good = fs::read(chosen).expect("bytes");
        for place in places {
            let mut bytes = good.clone();
            bytes[place.min(good.len() - 1)] ^= 4;
            fs::write(chosen, bytes).expect("written");
            let said = work.say("run case.toml --out out --resume");
            assert!(matches!(said.code, Some(1 | 2)), "{place}: {:?}", said.code);
            let name = chosen.file_name().expect("a name").to_string_lossy();
            assert!(said.err.contains(&*name), "{place}: {}", said.err);
        }
        fs::write(chosen, good).expect("written");
    }
    work.done("run case.toml --out out --resume");
    work.done("run case.toml --out whole");
    assert_same(&work.path("whole"), &out);
}

/// The long form: fifty chains for each bundled case.
/// `cargo test --release --test program resume -- --ignored`.
#[test]
#[ignore = "takes some twenty minutes: cargo long-tests"]
fn every_bundled_case_resumes_from_fifty_chains() {
    let chains = part_of(50);
    let seeds = 1000 + chains.start as u64..1000 + chains.end as u64;
    for (name, set) in SHRUNKEN {
        let stops = assert_resumes(name, &small(name, set), seeds.clone());
        println!("{name}: {stops} stops in chains {chains:?}");
    }
}
