//! Runs over several processes against runs in one: the same tables, also after processes or whole
//! jobs were killed.
//!
//! Each wait has a limit: `timeout` kills a job that hangs, and its message fails the test.

use std::fs;
use std::path::Path;
use std::thread;
use std::time::Duration;

use crate::support::{
    Scratch, appears, done, ends, job, kill, processes, said, scripted, slow_down, started,
    succeeds, tables,
};

/// A sweep of three points and six replicas each, with a prepared start, exact dynamics and Monte
/// Carlo.
const SWEEP: &str = r#"
format = 2
title = "a sweep"
replicas = 6
[gas]
number = 400
restitution = 0.9
[box]
packing_fraction = 0.2
[start]
equilibration = 10
[run]
until = 20
samples = 8
checkpoint_seconds = 0.001
[engine.ed]
[engine.dsmc-boltzmann]
[measure.impact_parameters]
[[sweep]]
"gas.restitution" = [0.7, 0.8, 0.9]
"#;

/// Disks from a file: forty replicas, which take so long that no process is left without one.
const FROM_FILE: &str = r#"
format = 2
title = "disks from a file"
replicas = 40
[gas]
[box]
[start]
placement = "file"
file = "start.csv"
[run]
until = 50000
[engine.ed]
[engine.dsmc-boltzmann]
"#;

#[test]
fn tables_are_the_same_bytes_for_any_number_of_processes_and_threads() {
    let scratch = Scratch::new(SWEEP);
    let wanted = scratch.alone();
    for (ranks, threads) in [(1, "2"), (2, "1"), (3, "2"), (4, "1"), (8, "1")] {
        let out = scratch.out(&format!("{ranks}-{threads}"));
        let arguments = ["run", &scratch.case, "--out", &out, "--threads", threads];
        succeeds(job(ranks, &[], &arguments));
        assert!(tables(Path::new(&out)) == wanted, "{ranks} ranks");
    }
}

/// Moments spread over the run by the golden ratio \[ms\].
fn moments(count: u32) -> impl Iterator<Item = Duration> {
    (1..=count).map(|number| {
        let share = (f64::from(number) * 0.618_034).fract();
        Duration::from_millis((1500.0 * share) as u64)
    })
}

#[test]
#[ignore = "signals processes at moments; a busy machine moves them: distributed/test.sh --include-ignored"]
fn a_killed_process_is_replaced_by_others() {
    let scratch = Scratch::new(SWEEP);
    let wanted = scratch.alone();
    for (number, moment) in moments(3).enumerate() {
        let out = scratch.out(&format!("lost-{number}"));
        let arguments = [
            "run",
            &scratch.case,
            "--out",
            &out,
            "--threads",
            "1",
            "--lost-after",
            "3",
        ];
        let child = started(job(3, &["--enable-recovery"], &arguments));
        let ids = processes(&out, 3);
        // Open MPI cannot do without a process that dies while MPI starts.
        appears(&out, "run.json");
        thread::sleep(moment);
        kill("-KILL", ids[1 + number % 2]);
        let output = child.wait_with_output().expect("an end");
        assert!(output.status.success(), "{}", said(&output));
        assert!(tables(Path::new(&out)) == wanted, "after {moment:?}");
    }
}

/// A process that hangs for a while is lost, and what it sends later is ignored.
#[test]
#[ignore = "signals processes at moments; a busy machine moves them: distributed/test.sh --include-ignored"]
fn a_process_that_stands_still_holds_nobody_up() {
    let scratch = Scratch::new(SWEEP);
    let wanted = scratch.alone();
    let out = scratch.out("slow");
    let arguments = [
        "run",
        &scratch.case,
        "--out",
        &out,
        "--threads",
        "1",
        "--lost-after",
        "2",
    ];
    let child = started(job(2, &["--enable-recovery"], &arguments));
    let ids = processes(&out, 2);
    thread::sleep(Duration::from_millis(700));
    kill("-STOP", ids[1]);
    appears(&out, "report.html");
    kill("-CONT", ids[1]);
    let output = child.wait_with_output().expect("an end");
    ends(&output);
    assert!(tables(Path::new(&out)) == wanted);
}

/// Refusals come from one process, once, and all end.
#[test]
fn refusals_are_said_once() {
    let scratch = Scratch::new(&SWEEP.replace("number = 400", "number = -4"));
    let out = scratch.out("refused");
    let output = done(job(3, &[], &["run", &scratch.case, "--out", &out]));
    let text = said(&output);
    assert_eq!(output.status.code(), Some(2), "{text}");
    assert_eq!(text.matches("gas.number").count(), 1, "{text}");
    let output = done(job(3, &[], &["run", &scratch.case, "--nonsense"]));
    let text = said(&output);
    assert_eq!(output.status.code(), Some(2), "{text}");
    assert_eq!(text.matches("unexpected argument").count(), 1, "{text}");
}

/// A case that only rank 0 can read is run, as the others get its text.
#[test]
fn only_the_root_needs_the_case() {
    let scratch = Scratch::new(SWEEP);
    let wanted = scratch.alone();
    let out = scratch.out("hidden");
    // The others are in a folder without it.
    let (folder, _) = scratch.case.rsplit_once('/').expect("a folder");
    let words = format!("if [ $OMPI_COMM_WORLD_RANK = 0 ]; then cd {folder}; else cd /; fi");
    succeeds(scripted(
        3,
        &scratch,
        &words,
        &["run", "case.toml", "--out", &out],
    ));
    assert!(tables(Path::new(&out)) == wanted);
}

/// A start file that only rank 0 has is refused by name, with the rank that lacks it.
#[test]
fn all_need_the_start_file() {
    let scratch = Scratch::new(FROM_FILE);
    let disks = (0..16).map(|disk| format!("{},{}\n", 2 * (disk % 4) + 1, 2 * (disk / 4) + 1));
    let text = format!("# box: 8 8\nx,y\n{}", disks.collect::<String>());
    fs::write(scratch.out("start.csv"), text).expect("a start file");
    let out = scratch.out("hidden");
    let (folder, _) = scratch.case.rsplit_once('/').expect("a folder");
    let words = format!("if [ $OMPI_COMM_WORLD_RANK = 1 ]; then cd /; else cd {folder}; fi");
    for way in [&[][..], &["--one-gas"]] {
        let arguments = [&["run", "case.toml", "--out", &out], way].concat();
        let output = done(scripted(3, &scratch, &words, &arguments));
        let text = said(&output);
        assert!(!output.status.success(), "{text}");
        assert!(
            text.contains("rank 1: ") && text.contains("start.csv"),
            "{text}"
        );
        assert_eq!(text.matches("error:").count(), 1, "{text}");
    }
}

/// Returns a script that makes the writes of a rank fail beyond 8 blocks, as a full disk does: a
/// limit of the size of files.
fn full_disk(rank: usize) -> String {
    format!("if [ $OMPI_COMM_WORLD_RANK = {rank} ]; then trap '' XFSZ; ulimit -f 8; fi")
}

/// A full disk on one of the processes ends the run with the name of the file; the run resumes when
/// there is room again.
#[test]
fn a_process_that_cannot_write_ends_the_run() {
    let scratch = Scratch::new(SWEEP);
    let wanted = scratch.alone();
    for rank in [0, 1] {
        let out = scratch.out(&format!("full-{rank}"));
        let arguments = ["run", &scratch.case, "--out", &out, "--threads", "1"];
        let output = done(scripted(3, &scratch, &full_disk(rank), &arguments));
        let text = said(&output);
        assert_eq!(output.status.code(), Some(1), "{text}");
        assert!(
            text.contains("checkpoints/replica") && text.contains("File too large"),
            "{text}"
        );
        assert_eq!(text.matches("error:").count(), 1, "{text}");
        let arguments = ["run", &scratch.case, "--out", &out, "--resume"];
        succeeds(job(2, &[], &arguments));
        assert!(tables(Path::new(&out)) == wanted, "rank {rank}");
    }
}

/// A slow process, which has the processor only now and then, is no lost one.
#[test]
fn a_slow_process_is_waited_for() {
    let scratch = Scratch::new(SWEEP);
    let wanted = scratch.alone();
    let out = scratch.out("slow");
    let child = started(job(
        3,
        &[],
        &["run", &scratch.case, "--out", &out, "--threads", "1"],
    ));
    slow_down(processes(&out, 3)[1]);
    let output = child.wait_with_output().expect("an end");
    assert!(output.status.success(), "{}", said(&output));
    assert!(tables(Path::new(&out)) == wanted);
}
