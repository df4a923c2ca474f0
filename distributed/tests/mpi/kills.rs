//! Jobs killed at random moments, one process or all, and resumed by other numbers of processes,
//! leave the tables of one process without a stop.
//!
//! A chain of jobs continues in one folder until a job ends well. Then the tables are compared, and
//! the next chain begins. Only kills that end a job count. Each wait has a limit.

use std::path::Path;
use std::thread;
use std::time::Duration;

use rand::RngExt as _;
use stosszahl::model::random::{Purpose, Streams};

use crate::support::{Scratch, ends, job, kill, processes, said, started, succeeds, tables};

/// Gases that several processes hold: pairs within cells, in neighbourhoods and across cells.
const GASES: &str = r#"
format = 2
title = "a box"
replicas = 2
[gas]
number = 8000
restitution = 0.9
[box]
packing_fraction = 0.2
[start]
equilibration = 0
[run]
until = 2
samples = 4
checkpoint_seconds = 0.05
[engine.dsmc-boltzmann]
simulators_per_particle = 1
[engine.dsmc-enskog]
simulators_per_particle = 1
[engine.dsmc-contact-point]
simulators_per_particle = 1
[measure.impact_parameters]
"#;

/// Most jobs for each kill that ends a job.
const LEGS: usize = 8;

/// Kills jobs of a case until this many were ended by it.
fn assert_survives(case: &str, seed: u64, kills: usize) {
    let scratch = Scratch::new(case);
    let wanted = scratch.alone();
    let mut draw = Streams::new(seed, 0).stream_at(Purpose::Placement, [0, 0]);
    let (mut killed, mut chain) = (0, 0);
    for leg in 0.. {
        assert!(leg < LEGS * kills, "{killed} of {kills} kills ended a job");
        let out = scratch.out(&format!("chain-{chain}"));
        let mut arguments = vec!["run", &scratch.case, "--out", &out, "--threads", "1"];
        if Path::new(&out).join("run.json").exists() {
            arguments.push("--resume");
        }
        if killed == kills {
            succeeds(job(2, &[], &arguments));
            assert!(tables(Path::new(&out)) == wanted, "seed {seed}, at the end");
            return;
        }
        let ranks = draw.random_range(1..=4);
        // One of the processes, or all.
        let victim = draw.random_range(0..=ranks);
        let moment = Duration::from_millis(draw.random_range(0..1500));
        let child = started(job(ranks, &[], &arguments));
        let ids = processes(&out, ranks);
        thread::sleep(moment);
        match ids.get(victim) {
            Some(&id) => kill("-KILL", id),
            None => ids.iter().for_each(|&id| kill("-KILL", id)),
        }
        let output = child.wait_with_output().expect("an end");
        ends(&output);
        if output.status.success() {
            let found = tables(Path::new(&out));
            assert!(found == wanted, "seed {seed}, leg {leg}: {}", said(&output));
            chain += 1;
        } else {
            killed += 1;
        }
    }
}

#[test]
fn gases_killed_at_ten_moments_leave_the_same_bytes() {
    assert_survives(GASES, 2, 10);
}

#[test]
#[ignore = "a hundred and fifty jobs, some five minutes: distributed/test.sh --include-ignored"]
fn jobs_killed_at_many_moments_leave_the_same_bytes() {
    for seed in 3..6 {
        assert_survives(GASES, seed, 50);
    }
}
