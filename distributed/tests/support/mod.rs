//! What the tests over several processes share. Each wait has a limit: `timeout` kills a job that hangs, and its exit code 124
//! fails the test.

#![allow(dead_code, reason = "each file of tests uses what it needs")]

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// Most seconds of a job.
pub const LIMIT: &str = "100";
/// The command.
pub const PROGRAM: &str = env!("CARGO_BIN_EXE_stosszahl-mpi");

/// A job of some processes.
pub fn job(ranks: usize, mpirun: &[&str], arguments: &[&str]) -> Command {
    let mut command = Command::new("timeout");
    command.args([LIMIT, "mpirun", "--allow-run-as-root", "--oversubscribe"]);
    // Two cores for eight processes: who waits must not spin.
    command.args(["--mca", "mpi_yield_when_idle", "1"]);
    command.args(mpirun);
    command.args(["-n", &ranks.to_string(), PROGRAM]);
    command.args(arguments);
    command
}

/// What came of a job.
pub fn done(mut command: Command) -> Output {
    let output = command.output().expect("mpirun starts");
    assert_ne!(output.status.code(), Some(124), "hangs: {}", said(&output));
    output
}

/// All that it said.
pub fn said(output: &Output) -> String {
    let both = [&output.stdout, &output.stderr];
    both.map(|text| String::from_utf8_lossy(text)).join("\n")
}

/// A job that ends well.
pub fn succeeds(command: Command) {
    let output = done(command);
    assert!(output.status.success(), "{}", said(&output));
}

/// All tables of a folder; no checkpoint may be left.
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
                .is_some_and(|end| end == "csv" || end == "xyz")
            {
                let name = path.strip_prefix(folder).expect("inside").to_owned();
                all.insert(name, fs::read(&path).expect("a table"));
            }
        }
    }
    assert!(all.len() > 2, "{:?}", all.keys());
    all
}

/// A case in a folder of its own.
pub struct Scratch {
    folder: tempfile::TempDir,
    pub case: String,
}

impl Scratch {
    /// Of a case.
    pub fn new(case: &str) -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("case.toml");
        fs::write(&path, case).expect("a case");
        let case = path.to_str().expect("a name").to_owned();
        Self { folder, case }
    }

    /// A results folder.
    pub fn out(&self, name: &str) -> String {
        let path = self.folder.path().join(name);
        path.to_str().expect("a name").to_owned()
    }

    /// The tables of a run in one process.
    pub fn alone(&self) -> BTreeMap<PathBuf, Vec<u8>> {
        alone(&self.case, &[], &self.out("alone"))
    }
}

/// The tables of a run of a case in one process, with more arguments.
pub fn alone(case: &str, more: &[&str], out: &str) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut arguments = vec!["stosszahl", "run", case, "--out", out, "--quiet"];
    arguments.extend(more);
    let code = stosszahl::commands::execute(clap::Parser::parse_from(arguments));
    assert_eq!(code, std::process::ExitCode::SUCCESS);
    tables(Path::new(out))
}
