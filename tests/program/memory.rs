//! The memory that `check` states is what the process takes.

use std::fs;

use crate::support::program::{TestFolder, overridden};
use stosszahl::study;

/// Factor by which the estimate may differ from the measured memory, either way.
const FACTOR: f64 = 1.3;
const MIB: f64 = 1_048_576.0;

/// Case of exact disks that are written after every leg.
const EXACT: &str = "[gas]\nnumber = 150000\nrestitution = 0.9\n[box]\npacking_fraction = 0.1\n[start]\nequilibration = 0\n\
                     [run]\nuntil = 0.001\nsamples = 4\ncheckpoint_seconds = 0.001\n[engine.ed]\n";
const CONTACT_POINT: &str = "[gas]\nnumber = 50000\nrestitution = 0.9\n[box]\npacking_fraction = 0.1\n[start]\nequilibration = 0\n\
                             [run]\nuntil = 0.001\nsamples = 4\ncheckpoint_seconds = 0.001\n\
                             [engine.dsmc-contact-point]\nsimulators_per_particle = 4\n";
const FLOW: &str = "[gas]\nnumber = 60000\nrestitution = 0.9\n[box]\nsize = [700, 700]\n[walls]\nbottom = \"specular\"\n\
                    top = { temperature = 1 }\n[run]\nuntil = 0.02\nsamples = 20\ncheckpoint_seconds = 0.001\n\
                    [engine.dsmc-boltzmann]\n[measure.fields]\ncells = [150, 150]\nblocks = 10\n";

/// Cases with peaks of some 100 MiB, of which the program itself is little; checkpoints are written
/// after every leg. Each has its name, the replicas and threads that it is run with, and its text.
const LARGE: [(&str, &[[usize; 2]], &str); 12] = [
    ("exact dynamics", &[[1, 1], [3, 1], [6, 3]], EXACT),
    (
        "exact dynamics, one gas in strips",
        &[[1, 1], [1, 2], [1, 4]],
        "[gas]\nnumber = 150000\nrestitution = 0.9\n[box]\npacking_fraction = 0.2\n[start]\nequilibration = 0\n\
         [run]\nuntil = 0.4\nsamples = 4\n[engine.ed]\n",
    ),
    (
        "lattices of a wide box",
        &[[3, 1]],
        "[gas]\nnumber = 20000\nrestitution = 0.9\n[box]\npacking_fraction = 0.001\n[start]\nequilibration = 0\n\
         [run]\nuntil = 0.001\n[engine.ed]\n",
    ),
    (
        "several simulators for each particle",
        &[[1, 1], [6, 3]],
        CONTACT_POINT,
    ),
    (
        "several simulators, pairs within cells",
        &[[1, 1]],
        "[gas]\nnumber = 50000\nrestitution = 0.9\n[box]\npacking_fraction = 0.1\n[start]\nequilibration = 0\n\
         [run]\nuntil = 0.001\ncheckpoint_seconds = 0.001\n[engine.dsmc-boltzmann]\nsimulators_per_particle = 4\n",
    ),
    (
        "velocities and places of the start",
        &[[1, 1]],
        "[gas]\nnumber = 100000\nrestitution = 0.9\n[box]\npacking_fraction = 0.1\n[start]\nequilibration = 0\n\
         [run]\nuntil = 0.001\nsamples = 4\ncheckpoint_seconds = 0.001\n[engine.ed]\n[measure.velocity_autocorrelation]\n\
         [measure.displacement]\n",
    ),
    (
        "five snapshots",
        &[[1, 1]],
        "[gas]\nnumber = 60000\nrestitution = 0.9\n[box]\npacking_fraction = 0.1\n[start]\nequilibration = 0\n\
         [run]\nuntil = 0.001\nsamples = 4\ncheckpoint_seconds = 0.001\n[engine.ed]\n[measure.snapshots]\n\
         times = [0, 2e-4, 4e-4, 6e-4, 1e-3]\n",
    ),
    ("a flow with fields", &[[1, 1]], FLOW),
    (
        "many samples",
        &[[1, 1], [3, 1]],
        "[gas]\nnumber = 10\nrestitution = 0.9\n[box]\npacking_fraction = 0.1\n[start]\nequilibration = 0\n\
         [run]\nuntil = 1\nsamples = 100000\n[engine.ed]\n",
    ),
    (
        "many samples of a flow",
        &[[1, 1]],
        "[gas]\nnumber = 10\nrestitution = 0.9\n[box]\nsize = [20, 20]\n[walls]\nbottom = \"specular\"\ntop = { temperature = 1 }\n\
         [run]\nuntil = 1\nsamples = 100000\n[engine.ed]\n",
    ),
    (
        "a wide lattice of wave numbers",
        &[[1, 1]],
        "[gas]\nnumber = 1000\nrestitution = 0.9\n[box]\npacking_fraction = 0.1\n[start]\nequilibration = 0\n\
         [run]\nuntil = 0.001\n[engine.ed]\n[measure.structure_factor]\ntimes = [0]\nlargest_wave_number = 1000\n",
    ),
    (
        "displacements without positions",
        &[[1, 1], [3, 2]],
        "[gas]\ndimension = 3\nnumber = 250000\nvolume = 5e6\nrestitution = 0.9\n\
         [run]\nuntil = 20\nfirst_sample = 5\ncheckpoint_seconds = 0.001\n[measure.displacement]\n",
    ),
];

/// Returns the largest resident memory of the program while it runs a case \[bytes\], as the system
/// counts it.
fn peak(work: &TestFolder, line: &str) -> f64 {
    let mut child = work.command(line);
    let child = child
        .stdout(std::process::Stdio::null())
        .stderr(std::process::Stdio::null());
    let mut child = child.spawn().expect("the program starts");
    let status = format!("/proc/{}/status", child.id());
    let mut most: f64 = 0.0;
    loop {
        // The peak only grows, so the last reading before the end counts.
        let text = fs::read_to_string(&status).unwrap_or_default();
        let line = text.lines().find_map(|line| line.strip_prefix("VmHWM:"));
        let kibibytes = line.and_then(|line| line.trim().strip_suffix(" kB")?.parse::<f64>().ok());
        most = most.max(1024.0 * kibibytes.unwrap_or(0.0));
        if let Some(status) = child.try_wait().expect("a state") {
            assert!(status.success(), "{status}");
            return most;
        }
        std::thread::sleep(std::time::Duration::from_millis(2));
    }
}

#[cfg(target_os = "linux")]
#[test]
fn the_estimate_is_what_the_process_takes() {
    let small = "format = 2\ntitle = \"small\"\n[gas]\nnumber = 10\nrestitution = 0.9\n[box]\npacking_fraction = 0.1\n\
                 [run]\nuntil = 0.001\n[engine.ed]\n";
    let program = peak(&TestFolder::new(small), "run case.toml --threads 1") / MIB;
    let mut wrong = Vec::new();
    for (name, runs, text) in LARGE {
        let mut alone = 0.0;
        for &[replicas, threads] in runs {
            let text = format!("format = 2\ntitle = \"{name}\"\nreplicas = {replicas}\n{text}");
            let work = TestFolder::new(&text);
            let file = overridden(&work.path("case.toml"), &text, &[]);
            let planned = study::check_case(&file).expect("a plan");
            let told = planned[0].outline(threads).cost.bytes / MIB;
            let found = peak(&work, &format!("run case.toml --force --threads {threads}")) / MIB;
            let line = format!(
                "{name}, {replicas} replicas on {threads} threads: {told:.0} MiB told, {found:.0} MiB found"
            );
            println!("{line}");
            // Upper bound of the measured memory: threads have their peaks at once by chance.
            // Together they take at most the stated memory, and that is at most the peak of a
            // thread for each thread, besides the program.
            let most = if threads == 1 {
                alone = found;
                found
            } else {
                program + threads as f64 * (alone - program)
            };
            if found > FACTOR * told || told > FACTOR * most {
                wrong.push(line);
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong:?}");
}

/// Cases larger than the memory of the machine are refused before anything is allocated; `run`
/// names the option that starts them anyway.
#[test]
fn what_does_not_fit_is_refused() {
    let text = "format = 2\ntitle = \"too large\"\nreplicas = 2\n[gas]\ndimension = 3\nnumber = 2000000000\nvolume = 1e11\n\
                restitution = 0.9\n[run]\nuntil = 1\n[measure.displacement]\n";
    let work = TestFolder::new(text);
    work.refused("run case.toml", &["GiB", "--ignore-memory-limit"]);
    assert!(!work.path("results").exists());
}
