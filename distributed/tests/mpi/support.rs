//! Support for the tests over several processes. Each wait has a limit: `timeout` kills a job that
//! hangs, and its message fails the test.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::thread;
use std::time::{Duration, Instant};

/// Longest job \[s\].
pub const LIMIT: &str = "100";
/// Path of the program.
pub const PROGRAM: &str = env!("CARGO_BIN_EXE_stosszahl-mpi");

/// Returns a job of some processes.
pub fn job(ranks: usize, mpirun: &[&str], arguments: &[&str]) -> Command {
    let mut command = job_of(ranks, mpirun);
    command.arg(PROGRAM).args(arguments);
    command
}

/// Returns a job of some processes in which each runs the script `words`; its arguments are those
/// of the program.
pub fn scripted(ranks: usize, scratch: &Scratch, words: &str, arguments: &[&str]) -> Command {
    let script = scratch.out("script.sh");
    fs::write(&script, format!("{words}\nexec {PROGRAM} \"$@\"\n")).expect("a script");
    let mut command = job_of(ranks, &[]);
    command.args(["bash", &script]).args(arguments);
    command
}

fn job_of(ranks: usize, mpirun: &[&str]) -> Command {
    let mut command = Command::new("timeout");
    command.args(["--verbose", "--kill-after=10", LIMIT, "mpirun"]);
    command.args(["--allow-run-as-root", "--oversubscribe"]);
    // Two cores for eight processes: waiting processes must not spin.
    command.args(["--mca", "mpi_yield_when_idle", "1"]);
    command.args(mpirun);
    command.args(["-n", &ranks.to_string()]);
    command
}

/// Runs a job that ends by itself; returns its output.
pub fn done(mut command: Command) -> Output {
    let output = command.output().expect("mpirun starts");
    ends(&output);
    output
}

/// Checks that a job ended by itself, with any outcome.
pub fn ends(output: &Output) {
    // Check by the message, because the exit code may also be that of a killed process.
    let said = said(output);
    assert!(!said.contains("timeout: sending signal"), "hangs: {said}");
}

/// Returns all output of a job.
pub fn said(output: &Output) -> String {
    let both = [&output.stdout, &output.stderr];
    both.map(|text| String::from_utf8_lossy(text)).join("\n")
}

/// Runs a job that must succeed.
pub fn succeeds(command: Command) {
    let output = done(command);
    assert!(output.status.success(), "{}", said(&output));
}

/// Returns the process ids of a job that belong to this folder, the root first.
pub fn processes(out: &str, wanted: usize) -> Vec<u32> {
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

/// Signals a process.
pub fn kill(signal: &str, process: u32) {
    let _ = Command::new("kill")
        .args([signal, &process.to_string()])
        .status();
}

/// Takes the processor from a process for most of two seconds.
pub fn slow_down(process: u32) {
    for _ in 0..5 {
        kill("-STOP", process);
        thread::sleep(Duration::from_millis(350));
        kill("-CONT", process);
        thread::sleep(Duration::from_millis(50));
    }
}

/// Waits for a file of a results folder.
pub fn appears(out: &str, name: &str) {
    wait_for(name, || Path::new(out).join(name).exists());
}

fn wait_for(name: &str, is_there: impl Fn() -> bool) {
    let began = Instant::now();
    while !is_there() {
        assert!(began.elapsed() < Duration::from_mins(1), "no {name}");
        thread::sleep(Duration::from_millis(5));
    }
}

/// Starts a job.
pub fn started(mut command: Command) -> Child {
    command.stdout(Stdio::piped()).stderr(Stdio::piped());
    command.spawn().expect("mpirun starts")
}

/// Reads all tables of a folder, snapshots and frames; no checkpoint may be left.
pub fn tables(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut all = BTreeMap::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(one) = folders.pop() {
        for entry in fs::read_dir(one).expect("a folder").flatten() {
            let path = entry.path();
            assert!(!path.ends_with("checkpoints"), "checkpoints are left");
            if path.is_dir() {
                folders.push(path);
            } else if path
                .extension()
                .is_some_and(|end| end == "csv" || end == "xyz" || end == "bin")
            {
                let name = path.strip_prefix(folder).expect("inside").to_owned();
                all.insert(name, fs::read(&path).expect("a table"));
            }
        }
    }
    assert!(all.len() > 2, "{:?}", all.keys());
    all
}

/// Case in a folder of its own.
pub struct Scratch {
    folder: tempfile::TempDir,
    pub case: String,
}

impl Scratch {
    /// Creates the folder of a case.
    pub fn new(case: &str) -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("case.toml");
        fs::write(&path, case).expect("a case");
        let case = path.to_str().expect("a name").to_owned();
        Self { folder, case }
    }

    /// Returns the path of a results folder.
    pub fn out(&self, name: &str) -> String {
        let path = self.folder.path().join(name);
        path.to_str().expect("a name").to_owned()
    }

    /// Returns the tables of a run in one process.
    pub fn alone(&self) -> BTreeMap<PathBuf, Vec<u8>> {
        alone(&self.case, &[], &self.out("alone"))
    }
}

/// Returns the tables of a run of a case in one process, with more arguments.
pub fn alone(case: &str, more: &[&str], out: &str) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut arguments = vec!["stosszahl", "run", case, "--out", out, "--quiet"];
    arguments.extend(more);
    let code = stosszahl::command_line::execute(clap::Parser::parse_from(arguments));
    assert_eq!(code, std::process::ExitCode::SUCCESS);
    tables(Path::new(out))
}
