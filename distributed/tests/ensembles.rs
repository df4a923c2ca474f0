//! Runs over several processes against runs in one: the same tables, also after processes or whole jobs were killed.
//!
//! Each wait has a limit: `timeout` kills a job that hangs, and its exit code 124 fails the test.

mod support;

use std::fs;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use support::{LIMIT, PROGRAM, Scratch, done, job, said, succeeds, tables};

/// A sweep of three points and six replicas each, with a prepared start, exact dynamics and Monte Carlo.
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

/// The processes of a job that belong to this folder, the root first.
fn processes(out: &str, wanted: usize) -> Vec<u32> {
    let began = Instant::now();
    loop {
        let mut found = Vec::new();
        for entry in fs::read_dir("/proc").expect("/proc").flatten() {
            let Some(id) = entry.file_name().to_str().and_then(|id| id.parse().ok()) else {
                continue;
            };
            let read = |name: &str| fs::read(entry.path().join(name)).unwrap_or_default();
            let line = String::from_utf8_lossy(&read("cmdline")).into_owned();
            if line.starts_with(PROGRAM) && line.contains(out) {
                let environment = String::from_utf8_lossy(&read("environ")).into_owned();
                let rank = environment.split('\0').find_map(|one| {
                    let rank = one.strip_prefix("OMPI_COMM_WORLD_RANK=")?;
                    rank.parse::<u32>().ok()
                });
                found.extend(rank.map(|rank| (rank, id)));
            }
        }
        if found.len() >= wanted {
            found.sort_unstable();
            return found.into_iter().map(|(_, id)| id).collect();
        }
        assert!(began.elapsed() < Duration::from_secs(30), "{found:?}");
        thread::sleep(Duration::from_millis(5));
    }
}

fn kill(signal: &str, process: u32) {
    let _ = Command::new("kill")
        .args([signal, &process.to_string()])
        .status();
}

/// Waits for a file of a results folder.
fn appears(out: &str, name: &str) {
    let (path, began) = (Path::new(out).join(name), Instant::now());
    while !path.exists() {
        assert!(began.elapsed() < Duration::from_mins(1), "no {name}");
        thread::sleep(Duration::from_millis(5));
    }
}

fn started(mut command: Command) -> Child {
    command.stdout(Stdio::piped()).stderr(Stdio::piped());
    command.spawn().expect("mpirun starts")
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

#[test]
#[ignore = "signals processes at moments; a busy machine moves them: distributed/test.sh --include-ignored"]
fn a_killed_job_goes_on_with_another_number_of_processes() {
    let scratch = Scratch::new(SWEEP);
    let wanted = scratch.alone();
    let out = scratch.out("killed");
    for (ranks, moment) in [2, 3, 1, 4].into_iter().zip(moments(4)) {
        let mut arguments = vec!["run", &scratch.case, "--out", &out, "--threads", "1"];
        if Path::new(&out).join("run.json").exists() {
            arguments.push("--resume");
        }
        let child = started(job(ranks, &[], &arguments));
        let ids = processes(&out, ranks);
        thread::sleep(moment);
        for id in ids {
            kill("-KILL", id);
        }
        let output = child.wait_with_output().expect("an end");
        assert_ne!(output.status.code(), Some(124), "{}", said(&output));
    }
    succeeds(job(
        3,
        &[],
        &["run", &scratch.case, "--out", &out, "--resume"],
    ));
    assert!(tables(Path::new(&out)) == wanted);
}

/// A process that stands still for a while is lost, and what it sends later is ignored.
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
    assert_ne!(output.status.code(), Some(124), "{}", said(&output));
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

/// A case that only rank 0 can read is run, as the others get its text; a start file that only rank 0 has is refused by name.
#[test]
fn only_the_root_needs_the_case() {
    let scratch = Scratch::new(SWEEP);
    let wanted = scratch.alone();
    let out = scratch.out("hidden");
    let script = scratch.out("hide.sh");
    // The case has another name for each rank.
    let text = format!(
        "exec {PROGRAM} run {}.$OMPI_COMM_WORLD_RANK --out {out}\n",
        scratch.case
    );
    fs::write(&script, text).expect("a script");
    fs::copy(&scratch.case, format!("{}.0", scratch.case)).expect("a copy");
    let mut command = Command::new("timeout");
    command.args([LIMIT, "mpirun", "--allow-run-as-root", "--oversubscribe"]);
    command.args(["-n", "3", "sh", &script]);
    succeeds(command);
    assert!(tables(Path::new(&out)) == wanted);
}

/// A full disk on one of the processes: the run ends with the name of the file.
#[test]
fn a_process_that_cannot_write_ends_the_run() {
    let scratch = Scratch::new(SWEEP);
    let out = scratch.out("full");
    let script = scratch.out("full.sh");
    // Files of rank 1 may have no more than 8 blocks: what a full disk does to a checkpoint.
    let text = format!(
        "if [ $OMPI_COMM_WORLD_RANK = 1 ]; then trap '' XFSZ; ulimit -f 8; fi\n\
         exec {PROGRAM} run {} --out {out} --threads 1\n",
        scratch.case
    );
    fs::write(&script, text).expect("a script");
    let mut command = Command::new("timeout");
    command.args([LIMIT, "mpirun", "--allow-run-as-root", "--oversubscribe"]);
    command.args(["-n", "3", "bash", &script]);
    let output = done(command);
    let text = said(&output);
    assert_eq!(output.status.code(), Some(1), "{text}");
    assert!(
        text.contains("checkpoints/replica-") && text.contains("File too large"),
        "{text}"
    );
    assert_eq!(text.matches("error:").count(), 1, "{text}");
    // With room again it goes on.
    let wanted = scratch.alone();
    succeeds(job(
        2,
        &[],
        &["run", &scratch.case, "--out", &out, "--resume"],
    ));
    assert!(tables(Path::new(&out)) == wanted);
}
