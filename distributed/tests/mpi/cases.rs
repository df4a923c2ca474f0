//! Ten bundled cases, shortened, over processes: as replicas handed out, and with each gas in all
//! processes. Their tables are those of one process.

use std::path::Path;

use crate::support::{Scratch, alone, job, succeeds, tables};

/// Cases, and settings that make them short.
const CASES: [(&str, &[&str]); 10] = [
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
        "mixture-cooling",
        &[
            "--until=5",
            "--replicas=2",
            "--set=power_law.monomers=1000",
            "--set=gas.volume=1e4",
        ],
    ),
    (
        "aggregation-fragmentation",
        &[
            "--until=20",
            "--replicas=2",
            "--set=gas.volume=1e5",
            "--set=measure.clusters.steady_from=5",
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
        "flow-past-disc",
        &[
            "--until=2",
            "--replicas=2",
            "--set=gas.number=8000",
            "--set=run.samples=60",
        ],
    ),
];

/// Number of processes, and threads of each.
const CREWS: [(usize, usize); 10] = [
    (1, 1),
    (2, 1),
    (3, 1),
    (4, 1),
    (8, 1),
    (1, 2),
    (2, 2),
    (3, 2),
    (4, 2),
    (8, 2),
];

/// Compares a case over some numbers of processes, as replicas and as one gas, with one process.
fn assert_same(number: usize, replicas: &[(usize, usize)], one_gas: &[(usize, usize)]) {
    let (case, short) = CASES[number];
    let scratch = Scratch::new("");
    let wanted = alone(case, short, &scratch.out("alone"));
    let ways = replicas.iter().map(|crew| (crew, None));
    let ways = ways.chain(one_gas.iter().map(|crew| (crew, Some("--one-gas"))));
    for (&(ranks, threads), way) in ways {
        let name = format!("{ranks}-{threads}{}", way.unwrap_or_default());
        let (out, threads) = (scratch.out(&name), threads.to_string());
        let mut arguments = vec!["run", case, "--out", &out, "--threads", &threads];
        arguments.extend(short.iter().chain(&way));
        succeeds(job(ranks, &[], &arguments));
        assert!(tables(Path::new(&out)) == wanted, "{case}: {name}");
    }
}

/// Each case with one crew as replicas and another as one gas, so that all crews come.
#[test]
fn bundled_cases_are_the_same_bytes_over_processes() {
    for number in 0..CASES.len() {
        let other = CREWS.len() - 1 - number;
        assert_same(number, &CREWS[number..=number], &CREWS[other..=other]);
    }
}

#[test]
#[ignore = "200 jobs, eight minutes: distributed/test.sh --include-ignored"]
fn bundled_cases_are_the_same_bytes_over_all_crews() {
    for number in 0..CASES.len() {
        assert_same(number, &CREWS, &CREWS);
    }
}
