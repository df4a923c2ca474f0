//! Several ordinary processes and one results folder (`run --join`), and runs in parts
//! (`run --part`, `merge`): the bytes of one process.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::process::{Child, Output, Stdio};
use std::thread;
use std::time::Duration;

use rand::{RngExt, SeedableRng};
use stosszahl::model::Interrupt;
use stosszahl::model::random::Stream;
use stosszahl::results::Existing;
use stosszahl::study::{self, Progress, RunOptions};

use crate::folders::{self, all_files};
use crate::support::part::part_of;
use crate::support::program::{CLUSTERS, Columns, TestFolder, assert_same, overridden};

/// Two points of some replicas, each of some tenths of a second.
fn case() -> String {
    let fewer = folders::CASE
        .replace("number = 150", "number = 100")
        .replace("replicas = 6", "replicas = 5");
    format!("{fewer}[[sweep]]\n\"gas.restitution\" = [0.8, 0.9]\n")
}

const JOIN: &str = "run case.toml --join --threads 1 --quiet --out out";

fn start(work: &TestFolder, line: &str) -> Child {
    let mut command = work.command(line);
    let child = command.stdout(Stdio::piped()).stderr(Stdio::piped());
    child.spawn().expect("the program starts")
}

fn require_end(child: Child) {
    let Output { status, stderr, .. } = child.wait_with_output().expect("an end");
    assert!(status.success(), "{}", String::from_utf8_lossy(&stderr));
}

/// Returns the folder of a run by one process.
fn alone(work: &TestFolder) -> std::path::PathBuf {
    if !work.path("alone").exists() {
        work.done("run case.toml --threads 1 --quiet --out alone");
    }
    work.path("alone")
}

/// Checks that the folder has the tables of one process, the same files, and no remains of several.
fn require_same(work: &TestFolder) {
    let (alone, out) = (alone(work), work.path("out"));
    assert_eq!(all_files(&alone), all_files(&out));
    for point in points(&alone) {
        assert_same(&point, &out.join(point.file_name().expect("a name")));
    }
    assert!(!out.join("claims").exists());
    let list = |folder: &Path| {
        let text = fs::read_to_string(folder.join("run.files")).expect("a list");
        let mut names: Vec<String> = text.lines().map(str::to_owned).collect();
        names.retain(|name| !name.contains("checkpoints/"));
        names.sort();
        names.dedup();
        names
    };
    assert_eq!(list(&alone), list(&out));
}

fn points(folder: &Path) -> Vec<std::path::PathBuf> {
    let entries = fs::read_dir(folder).expect("a folder").flatten();
    let paths = entries.map(|entry| entry.path());
    paths
        .filter(|path| path.join("manifest.json").exists())
        .collect()
}

#[test]
fn several_processes_do_what_one_does() {
    let work = TestFolder::new(&case());
    for count in [1, 2, 4] {
        let children: Vec<Child> = (0..count).map(|_| start(&work, JOIN)).collect();
        children.into_iter().for_each(require_end);
        require_same(&work);
        let said = work.done("run case.toml --join --out out");
        assert!(said.out.contains("complete already"), "{}", said.out);
        require_same(&work);
        fs::remove_dir_all(work.path("out")).expect("removed");
    }
}

/// Kills one process or some or all at a random moment, again and again, and resumes; returns the
/// number of kills.
fn kill_and_go_on(work: &TestFolder, seed: u64) -> usize {
    let mut stream = Stream::seed_from_u64(seed);
    let count = [1, 2, 4][stream.random_range(0..3)];
    let _ = fs::remove_dir_all(work.path("out"));
    let mut children: Vec<Child> = (0..count).map(|_| start(work, JOIN)).collect();
    let mut kills = 0;
    for _ in 0..stream.random_range(1..=3) {
        thread::sleep(Duration::from_millis(stream.random_range(20..600)));
        let killed = match stream.random_range(0..3) {
            0 => 1,
            1 => children.len().div_ceil(2),
            _ => children.len(),
        };
        for mut child in children.drain(..killed) {
            kills += usize::from(child.try_wait().expect("a state").is_none());
            let _ = child.kill();
            let _ = child.wait();
        }
        children.extend((0..stream.random_range(1..=killed)).map(|_| start(work, JOIN)));
    }
    children.into_iter().for_each(require_end);
    require_same(work);
    kills
}

#[test]
fn processes_that_are_killed_are_gone_on_with() {
    let work = TestFolder::new(&case());
    let kills: usize = (0..3).map(|seed| kill_and_go_on(&work, seed)).sum();
    // A single process resumes where several were killed.
    fs::remove_dir_all(work.path("out")).expect("removed");
    let mut children = [0, 1].map(|_| start(&work, JOIN));
    while !work.path("out/run.json").exists() {
        thread::sleep(Duration::from_millis(5));
    }
    thread::sleep(Duration::from_millis(100));
    for child in &mut children {
        let _ = child.kill();
        let _ = child.wait();
    }
    work.done("run case.toml --threads 2 --quiet --out out --resume");
    require_same(&work);
    println!("{kills} kills");
}

/// Long form, run by `cargo test --release --test program join -- --ignored`.
#[test]
#[ignore = "takes some minutes: cargo long-tests"]
fn processes_are_killed_at_fifty_moments() {
    let work = TestFolder::new(&case());
    let seeds = part_of(50);
    let mut kills = 0;
    for seed in seeds.clone() {
        let more = kill_and_go_on(&work, 100 + seed as u64);
        println!("chain {seed}: {more} kills");
        kills += more;
    }
    println!("{kills} kills in chains {seeds:?}");
    assert!(kills > seeds.len() / 2, "{kills}");
}

/// Progress that records the parts of replicas that a process begins to work on.
#[derive(Default)]
struct Begun(std::sync::Mutex<Vec<(usize, usize)>>);

impl Progress for Begun {
    fn tell_share(&self, point: usize, part: usize, share: f64, _collisions: u64) {
        let mut begun = self.0.lock().expect("no panic");
        if share < 1.0 && !begun.contains(&(point, part)) {
            begun.push((point, part));
        }
    }
}

/// No replica is executed by two processes while both are alive.
#[test]
fn each_replica_is_done_once() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = overridden(Path::new("case.toml"), &case(), &[]);
    let begun: Vec<Begun> = (0..3).map(|_| Begun::default()).collect();
    thread::scope(|scope| {
        for progress in &begun {
            scope.spawn(|| {
                let stop = Interrupt::default();
                let options = RunOptions {
                    out: Some(folder.path().join("out")),
                    existing: Existing::Refuse,
                    threads: Some(1),
                    ignore_memory_limit: false,
                    stop: &stop,
                    progress,
                    commit: "",
                };
                let done = study::run_joined(&file, &options, Duration::from_mins(10));
                assert_eq!(done.expect("a run").points.len(), 2);
            });
        }
    });
    let mut all: Vec<(usize, usize)> = Vec::new();
    for one in begun {
        all.extend(one.0.into_inner().expect("no panic"));
    }
    let count = all.len();
    all.sort_unstable();
    all.dedup();
    assert_eq!(all.len(), count, "a part was done twice");
    assert!(count > 10, "{count}");
}

/// A run that does not share its folder and one that does exclude each other; another case is
/// refused.
#[test]
fn one_that_works_alone_and_one_that_joins_do_not_meet() {
    let work = TestFolder::new(&case());
    let long = "run case.toml --out out --set run.until=1e6 --threads 1";
    for (first, second) in [("", " --join"), (" --join", " --resume")] {
        let mut child = start(&work, &format!("{long}{first}"));
        while !work.path("out/run.json").exists() {
            assert!(child.try_wait().expect("a state").is_none());
            thread::sleep(Duration::from_millis(5));
        }
        let said = work.say(&format!("{long}{second}"));
        assert_eq!(said.code, Some(2), "{}", said.err);
        assert!(said.err.contains("another process"), "{}", said.err);
        if first.contains("join") {
            work.refused(
                &format!("{long} --join --seed 8"),
                &["seed: 5 there, 8 here"],
            );
        }
        child.kill().expect("killed");
        child.wait().expect("ended");
        fs::remove_dir_all(work.path("out")).expect("removed");
    }
    work.refused(&format!("{JOIN} --force"), &["cannot be used with"]);
    work.refused("run case.toml --lost-after 5", &["--join"]);
}

/// Replicas whose gas cannot be advanced are executed once too, and left out of all tables.
#[test]
fn replicas_that_cannot_go_on_are_kept() {
    let work = TestFolder::new(&case());
    // Many samples, because the limit is checked at samples.
    let often = "--set run.samples_per_decade=60";
    work.done(&format!(
        "run case.toml --threads 1 --quiet --out free {often}"
    ));
    // Exact dynamics of each replica, by point: pair collisions of 100 disks.
    let counts = points(&work.path("free")).into_iter().map(|point| {
        let table = Columns::read(&point, "replicas");
        let mut last: BTreeMap<String, f64> = BTreeMap::new();
        let rows = table.texts("replica").iter().zip(table.texts("engine"));
        for ((replica, engine), count) in rows.zip(table.numbers("collisions_per_particle")) {
            if engine == "ed" {
                last.insert(replica.clone(), 50.0 * count);
            }
        }
        last.into_values().fold(f64::INFINITY, f64::min)
    });
    // A limit that at least one replica of each point does not reach.
    let limit = counts.fold(0.0, f64::max).round() + 1.0;
    let set = format!("{often} --set engine.ed.collision_limit={limit}");
    work.done(&format!("run case.toml --threads 1 --out alone {set}"));
    let line = format!("{JOIN} {set}");
    let children: Vec<Child> = (0..2).map(|_| start(&work, &line)).collect();
    children.into_iter().for_each(require_end);
    require_same(&work);
    let warnings = |folder: &Path| {
        let manifest = fs::read_to_string(folder.join("manifest.json")).expect("a manifest");
        let manifest: serde_json::Value = serde_json::from_str(&manifest).expect("JSON");
        manifest["warnings"].clone()
    };
    let mut failed = 0;
    for point in points(&work.path("alone")) {
        let out = work.path("out").join(point.file_name().expect("a name"));
        assert_eq!(warnings(&point), warnings(&out));
        let said = warnings(&point).to_string();
        failed += said.matches("is left out of all tables").count();
    }
    assert!(failed > 0, "no replica failed at {limit} collisions");
}

/// Processes that share a frontier, of which one is killed, leave the tables of one, but for times.
#[test]
fn several_processes_measure_one_frontier() {
    let work = TestFolder::new(folders::CASE);
    let line = folders::FRONTIER;
    work.done(&line.replace("--out out", "--out alone"));
    let mut children: Vec<Child> = (0..3)
        .map(|_| start(&work, &format!("{line} --join")))
        .collect();
    while !work.path("out/run.json").exists() {
        thread::sleep(Duration::from_millis(5));
    }
    thread::sleep(Duration::from_millis(200));
    children[0].kill().expect("killed");
    children.remove(0).wait().expect("ended");
    children.into_iter().for_each(require_end);
    assert_eq!(
        folders::untimed(&work.path("alone")),
        folders::untimed(&work.path("out"))
    );
    assert!(work.path("out/frontier.html").exists() && !work.path("out/claims").exists());
    // A single process begins with all runs that are kept.
    let said = work.done(line);
    assert!(said.out.contains("(0 made now)"), "{}", said.out);
}

#[test]
fn parts_are_merged_to_the_bytes_of_one_run() {
    for (text, count) in [(&*case(), 3), (CLUSTERS, 2)] {
        let work = TestFolder::new(text);
        let parts: Vec<String> = (1..=count)
            .map(|part| format!("results/case-part-{part}-of-{count}"))
            .collect();
        for part in 2..=count {
            let said = work.done(&format!("run case.toml --threads 1 --part {part}/{count}"));
            assert!(
                said.out
                    .contains(&format!("part {part} of {count} is done")),
                "{}",
                said.out
            );
        }
        work.refused(
            &format!("merge --out out {}", parts[1..].join(" ")),
            &["no folder has replica 0"],
        );
        assert!(!work.path("out").exists());
        work.done(&format!("run case.toml --threads 2 --part 1/{count}"));
        work.done(&format!("run case.toml --part 1/{count} --resume"));
        // Merging does not need the case file.
        fs::rename(work.path("case.toml"), work.path("other.toml")).expect("moved");
        work.done(&format!("merge --out out --quiet {}", parts.join(" ")));
        fs::rename(work.path("other.toml"), work.path("case.toml")).expect("moved");
        alone(&work);
        assert_eq!(all_files(&work.path("alone")), all_files(&work.path("out")));
        if work.path("alone/manifest.json").exists() {
            assert_same(&work.path("alone"), &work.path("out"));
        }
        for point in points(&work.path("alone")) {
            assert_same(
                &point,
                &work.path("out").join(point.file_name().expect("a name")),
            );
        }
        work.done(&format!(
            "run case.toml --part 1/{count} --seed 9 --out foreign"
        ));
        work.refused(
            &format!("merge --out again {} foreign", parts.join(" ")),
            &["belongs to another run", "seed: 9 there"],
        );
        work.refused("merge alone", &["expected a folder that"]);
        for part in ["0/3", "4/3", "2", "a/b"] {
            work.refused(&format!("run case.toml --part {part}"), &["expected K/N"]);
        }
    }
}
