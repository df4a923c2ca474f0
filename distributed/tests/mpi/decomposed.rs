//! One gas that several processes hold has the tables of one process.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{ExitCode, Output};

use stosszahl::command_line;

use crate::support::{
    Scratch, appears, done, ends, job, kill, processes, said, scripted, slow_down, started,
    succeeds, tables,
};

/// A gas that flows into a channel.
const CHANNEL: &str = r#"
format = 2
title = "a channel"
replicas = 2
[gas]
dimension = 3
number = 8000
temperature = 0.5
restitution = 0.9
mean_free_path = 1
[box]
size = [16, 8, 0.25]
[walls]
left = "open"
right = "open"
bottom = { temperature = 0.5 }
top = { temperature = 0.5 }
[[inflow]]
face = "left"
velocity = [2.2567, 0, 0]
[start]
velocity = [2.2567, 0, 0]
[run]
until = 1
samples = 4
[engine.dsmc-boltzmann]
cell_size = 0.25
[measure.fields]
cells = [8, 4]
blocks = 2
"#;

/// Neighbourhoods of cells, and partners across cells.
const BOX: &str = r#"
format = 2
title = "a box"
replicas = 1
[gas]
number = 4000
restitution = 0.9
[box]
packing_fraction = 0.2
[start]
equilibration = 0
[run]
until = 0.5
samples = 2
[engine.dsmc-enskog]
simulators_per_particle = 2
[engine.dsmc-contact-point]
simulators_per_particle = 2
[measure.impact_parameters]
[measure.structure_factor]
"#;

/// Disks from a file.
const FROM_FILE: &str = r#"
format = 2
title = "disks from a file"
replicas = 2
[gas]
[box]
[start]
placement = "file"
file = "start.csv"
[run]
until = 50
[engine.ed]
[engine.dsmc-boltzmann]
"#;

#[test]
fn tables_are_the_same_bytes_for_any_number_of_processes() {
    for case in [CHANNEL, BOX] {
        let scratch = Scratch::new(case);
        let wanted = scratch.alone();
        for (ranks, threads) in [("1", "2"), ("2", "1"), ("3", "1")] {
            let out = scratch.out(ranks);
            let arguments = ["run", &scratch.case, "--out", &out, "--threads", threads];
            let ranks = ranks.parse().expect("a number");
            succeeds(job(ranks, &[], &arguments));
            assert!(tables(Path::new(&out)) == wanted, "{ranks} ranks");
        }
    }
}

/// Mixture with all measures that do not identify single particles.
const MEASURED: &str = r#"
format = 2
title = "a mixture"
replicas = 1
[gas]
number = 40000
restitution = 0.9
[[species]]
share = 0.5
[[species]]
share = 0.5
diameter = 0.5
[box]
packing_fraction = 0.2
[start]
equilibration = 0
[run]
until = 0.004
samples = 2
[engine.dsmc-boltzmann]
simulators_per_particle = 1
[measure.snapshots]
times = []
[measure.frames]
number = 0
[measure.fields]
cells = [8, 4]
blocks = 2
[measure.boundaries]
[measure.structure_factor]
largest_wave_number = 2
[measure.pair_correlation]
range = 2
[measure.spectra]
largest_wave_number = 2
[measure.velocity_distribution]
bins = 20
[measure.species]
"#;

/// Measures of structure: those of pairs of species need all particles at one place.
const STRUCTURE: &str = "[measure.structure_factor]\nlargest_wave_number = 2\n\
                         [measure.pair_correlation]\nrange = 2\n";

/// The same measures, made at no time.
const NO_STRUCTURE: &str =
    "[measure.structure_factor]\ntimes = []\n[measure.pair_correlation]\ntimes = []\n";

/// Measures that sample at many more times.
const OFTEN: &str =
    "[measure.displacement]\n[measure.intermediate_scattering]\nwave_numbers = [1, 2]\n";

/// Number of bytes that the first process of a job has received, by its message.
fn received(output: &Output) -> f64 {
    let text = said(output);
    let line = text.lines().find(|line| line.starts_with("rank 0: "));
    let (before, _) = line
        .and_then(|line| line.split_once(" bytes received"))
        .expect("a line");
    let number = before.rsplit(' ').next().expect("a number");
    number.parse().expect("a number")
}

/// Sums over the particles are made by the processes that hold them. The tables have equal bytes,
/// and the first process receives at most 0.55 of the bytes of all particles.
///
/// In these few steps no tile changes its process. Each of some sixty further samples would send as
/// many bytes again, and tiles change their process three times at most. Measures that identify
/// single particles do gather them, and so does the structure of pairs of species.
#[test]
fn looks_at_a_gas_gather_no_particles() {
    let gas = 40_000.0 * 32.0;
    assert!(MEASURED.contains(STRUCTURE));
    let mixture = MEASURED.replace(STRUCTURE, NO_STRUCTURE);
    let (before, species) = MEASURED.split_once("[[species]]").expect("species");
    let (_, after) = species.split_once("[box]").expect("a box");
    let single = format!("{before}[box]{after}").replace("[measure.species]\n", "");
    let often = format!("{mixture}{OFTEN}");
    for (case, limit) in [
        (mixture, 0.55 * gas),
        (often, 8.0 * gas),
        (single, 0.55 * gas),
    ] {
        let scratch = Scratch::new(&case);
        let wanted = scratch.alone();
        assert!(wanted.len() > 9, "{:?}", wanted.keys());
        for ranks in [1, 2, 3, 4, 8] {
            let out = scratch.out(&ranks.to_string());
            let bytes = received(&held(ranks, &scratch, &out));
            assert!(tables(Path::new(&out)) == wanted, "{ranks} ranks");
            assert!(bytes < limit, "{ranks} ranks: {bytes} of {limit}");
        }
    }
    let gathers = Scratch::new(&format!("{MEASURED}[measure.velocity_autocorrelation]\n"));
    let output = held(2, &gathers, &gathers.out("gathers"));
    assert!(received(&output) > 8.0 * gas, "{}", said(&output));
}

/// Returns a job in which some processes hold each gas.
fn held(ranks: usize, scratch: &Scratch, out: &str) -> Output {
    let arguments = ["run", &scratch.case, "--threads", "1", "--out", out];
    let output = done(job(ranks, &[], &arguments));
    assert!(output.status.success(), "{}", said(&output));
    output
}

#[test]
fn refusals_end_all_processes() {
    let scratch = Scratch::new(&BOX.replace("restitution = 0.9", "restitution = 9"));
    let out = scratch.out("refused");
    let output = done(job(3, &[], &["run", &scratch.case, "--out", &out]));
    let text = said(&output);
    assert_eq!(output.status.code(), Some(2), "{text}");
    assert_eq!(text.matches("gas.restitution").count(), 1, "{text}");
    let output = done(job(3, &[], &["run", &scratch.case, "--nonsense"]));
    let text = said(&output);
    assert_eq!(output.status.code(), Some(2), "{text}");
    assert_eq!(text.matches("unexpected argument").count(), 1, "{text}");
}

/// A process that hangs ends the job, with its number; so does the first.
#[test]
fn a_process_that_hangs_ends_the_job() {
    let scratch =
        Scratch::new(&CHANNEL.replace("until = 1\n", "until = 40\ncheckpoint_seconds = 0.1\n"));
    for rank in [0, 1] {
        let out = scratch.out(&format!("still-{rank}"));
        let arguments = ["run", &scratch.case, "--out", &out];
        let arguments = [&arguments[..], &["--threads", "1", "--rank-timeout", "2"]].concat();
        let child = started(job(3, &[], &arguments));
        let ids = processes(&out, 3);
        appears(&out, "checkpoints");
        kill("-STOP", ids[rank]);
        let output = child.wait_with_output().expect("an end");
        let text = said(&output);
        ends(&output);
        assert!(!output.status.success(), "{text}");
        assert!(
            text.contains(&format!("error: rank {rank} hangs")),
            "{text}"
        );
    }
}

/// A slow process, which has the processor only now and then, does not end the job.
#[test]
fn a_slow_process_is_waited_for() {
    let scratch = Scratch::new(CHANNEL);
    let wanted = scratch.alone();
    let out = scratch.out("slow");
    let arguments = ["run", &scratch.case, "--out", &out, "--threads", "1"];
    let child = started(job(2, &[], &arguments));
    slow_down(processes(&out, 2)[1]);
    let output = child.wait_with_output().expect("an end");
    assert!(output.status.success(), "{}", said(&output));
    assert!(tables(Path::new(&out)) == wanted);
}

/// Only the first process reads the case; all write their parts of checkpoints. The full disk of
/// any (a limit of the size of files) ends the run with its number.
#[test]
fn a_full_disk_of_any_process_ends_the_run() {
    let case = CHANNEL.replace("until = 1\n", "until = 1\ncheckpoint_seconds = 0.01\n");
    let scratch = Scratch::new(&case);
    let wanted = scratch.alone();
    let (folder, _) = scratch.case.rsplit_once('/').expect("a folder");
    for rank in [0, 1] {
        let out = scratch.out(&format!("full-{rank}"));
        let words = format!(
            "if [ $OMPI_COMM_WORLD_RANK = 0 ]; then cd {folder}; else cd /; fi\n\
             if [ $OMPI_COMM_WORLD_RANK = {rank} ]; then trap '' XFSZ; ulimit -f 8; fi"
        );
        let name = format!("full-{rank}");
        let arguments = ["run", "case.toml", "--out", &name];
        let arguments = [&arguments[..], &["--threads", "1"]].concat();
        let output = done(scripted(2, &scratch, &words, &arguments));
        let text = said(&output);
        assert_eq!(output.status.code(), Some(1), "{text}");
        assert!(text.contains(&format!("process {rank}: ")), "{text}");
        assert!(
            text.contains(".shard") && text.contains("File too large"),
            "{text}"
        );
        assert_eq!(text.matches("error:").count(), 1, "{text}");
        let arguments = ["run", &scratch.case, "--out", &out, "--resume"];
        succeeds(job(3, &[], &arguments));
        assert!(tables(Path::new(&out)) == wanted, "rank {rank}");
    }
}

/// Returns the shards of a checkpoint, by their path.
fn shards(out: &str) -> Vec<PathBuf> {
    let folder = fs::read_dir(Path::new(out).join("checkpoints"));
    let paths = folder.into_iter().flatten().flatten().map(|one| one.path());
    let mut all: Vec<PathBuf> = paths
        .filter(|path| path.extension().is_some_and(|end| end == "shard"))
        .collect();
    all.sort();
    all
}

/// A job of three processes that is killed leaves shards. A shard that is missing, short or changed
/// is named, for any number of processes that resume. With all shards unchanged, another number of
/// processes resumes to the same bytes, and so does one process alone.
#[test]
fn shards_that_cannot_be_used_are_named() {
    let case = CHANNEL.replace("until = 1\n", "until = 4\ncheckpoint_seconds = 0.05\n");
    let scratch = Scratch::new(&case);
    let wanted = scratch.alone();
    for alone in [true, false] {
        let out = scratch.out(&format!("shards-{alone}"));
        let arguments = ["run", &scratch.case, "--out", &out];
        let child = started(job(3, &[], &[&arguments[..], &["--threads", "1"]].concat()));
        let ids = processes(&out, 3);
        appears(&out, "checkpoints/replica-0-dsmc-boltzmann.snapshot");
        for &id in &ids {
            kill("-KILL", id);
        }
        let output = child.wait_with_output().expect("an end");
        ends(&output);
        assert!(!output.status.success());
        let resumes = [&arguments[..], &["--resume"]].concat();
        // A kill may leave shards of the next checkpoint.
        let of_second = |path: &&PathBuf| path.to_string_lossy().ends_with("-1.shard");
        let kept: Vec<(PathBuf, Vec<u8>)> = (shards(&out).iter().filter(of_second))
            .map(|path| (path.clone(), fs::read(path).expect("bytes")))
            .collect();
        assert!((1..=2).contains(&kept.len()), "{kept:?}");
        for fault in ["No such file", "bytes of", "another hash"] {
            for (path, whole) in &kept {
                let (half, mut bytes) = (whole.len() / 2, whole.clone());
                match fault {
                    "bytes of" => bytes.truncate(half),
                    _ => bytes[half] ^= 1,
                }
                fs::write(path, bytes).expect("written");
                if fault == "No such file" {
                    fs::remove_file(path).expect("removed");
                }
            }
            for ranks in [1, 2] {
                let output = done(job(ranks, &[], &resumes));
                let text = said(&output);
                assert_eq!(output.status.code(), Some(1), "{text}");
                assert!(text.contains("-1.shard") && text.contains(fault), "{text}");
                assert!(text.contains("of a checkpoint in 3 shards"), "{text}");
            }
            let words = ["stosszahl", "run", &scratch.case, "--out", &out, "--resume"];
            let code = command_line::execute(clap::Parser::parse_from(words));
            assert_eq!(code, ExitCode::from(1));
        }
        for (path, whole) in &kept {
            fs::write(path, whole).expect("written");
        }
        let found = if alone {
            crate::support::alone(&scratch.case, &["--resume"], &out)
        } else {
            succeeds(job(2, &[], &resumes));
            tables(Path::new(&out))
        };
        assert!(found == wanted);
    }
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
    let arguments = ["run", "case.toml", "--out", &out];
    let output = done(scripted(3, &scratch, &words, &arguments));
    let text = said(&output);
    assert!(!output.status.success(), "{text}");
    assert!(
        text.contains("rank 1: ") && text.contains("start.csv"),
        "{text}"
    );
    assert_eq!(text.matches("error:").count(), 1, "{text}");
}

/// A case without a gas in cells has nothing to decompose: the refusal names the command that
/// shares its replicas.
#[test]
fn exact_dynamics_alone_is_refused() {
    let scratch = Scratch::new(&FROM_FILE.replace("[engine.dsmc-boltzmann]\n", ""));
    let text = "# box: 8 8\nx,y\n1,1\n5,5\n";
    fs::write(scratch.out("start.csv"), text).expect("a start file");
    let out = scratch.out("exact");
    let output = done(job(2, &[], &["run", &scratch.case, "--out", &out]));
    let text = said(&output);
    assert_eq!(output.status.code(), Some(2), "{text}");
    assert_eq!(text.matches("stosszahl run --join").count(), 1, "{text}");
    assert!(!Path::new(&out).exists(), "{text}");
}
