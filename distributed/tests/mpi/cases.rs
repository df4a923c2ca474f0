//! Bundled cases with gases in cells, shortened, over processes. Their tables are those of one
//! process.

use std::path::Path;

use crate::support::{Scratch, alone, job, succeeds, tables};

/// Cases, and settings that make them short.
const CASES: [(&str, &[&str]); 8] = [
    ("quick", &["--until=1", "--replicas=3"]),
    (
        "luding-1998",
        &[
            "--until=1",
            "--replicas=1",
            "--set=gas.number=2500",
            "--set=start.equilibration=1",
        ],
    ),
    ("driven", &["--until=1", "--replicas=3"]),
    (
        "binary-disks",
        &[
            "--until=0.5",
            "--replicas=2",
            "--set=engine.dsmc-contact-point.simulators_per_particle=8",
        ],
    ),
    (
        "kawasaki-1985-channel-gas",
        &[
            "--until=2",
            "--replicas=2",
            "--set=gas.number=4096",
            "--set=run.samples=60",
        ],
    ),
    (
        "kawasaki-1985-sedimentation-1",
        &[
            "--until=2",
            "--replicas=2",
            "--set=gas.number=4000",
            "--set=run.samples=100",
        ],
    ),
    (
        "rough-disks",
        &[
            "--until=1",
            "--replicas=2",
            "--set=gas.number=300",
            "--set=box.size=[150,150]",
        ],
    ),
    (
        "flow-past-disk",
        &[
            "--until=2",
            "--replicas=2",
            "--set=gas.number=8000",
            "--set=run.samples=60",
        ],
    ),
];

/// Layouts: number of processes, and threads of each.
const LAYOUTS: [(usize, usize); 8] = [
    (2, 1),
    (3, 1),
    (4, 1),
    (8, 1),
    (1, 2),
    (2, 2),
    (3, 2),
    (4, 2),
];

/// Compares a case over some layouts with one process.
fn assert_same(number: usize, layouts: &[(usize, usize)]) {
    let (case, short) = CASES[number];
    let scratch = Scratch::new("");
    let wanted = alone(case, short, &scratch.out("alone"));
    for &(ranks, threads) in layouts {
        let name = format!("{ranks}-{threads}");
        let (out, threads) = (scratch.out(&name), threads.to_string());
        let mut arguments = vec!["run", case, "--out", &out, "--threads", &threads];
        arguments.extend(short);
        succeeds(job(ranks, &[], &arguments));
        assert!(tables(Path::new(&out)) == wanted, "{case}: {name}");
    }
}

/// Each case in one layout, so that all layouts come.
#[test]
fn bundled_cases_are_the_same_bytes_over_processes() {
    for number in 0..CASES.len() {
        let layout = LAYOUTS.len() - 1 - number;
        assert_same(number, &LAYOUTS[layout..=layout]);
    }
}

#[test]
#[ignore = "64 jobs, some three minutes: distributed/test.sh --include-ignored"]
fn bundled_cases_are_the_same_bytes_in_all_layouts() {
    for number in 0..CASES.len() {
        assert_same(number, &LAYOUTS);
    }
}
