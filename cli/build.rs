//! Build script that sets `STOSSZAHL_COMMIT`: the commit from which the program is built, and
//! whether sources have changed since; empty outside a clone.

use std::path::Path;
use std::process::Command;

/// Source folders and files of the program, relative to the root of the clone.
const SOURCES: [&str; 10] = [
    "Cargo.toml",
    "Cargo.lock",
    "model",
    "ed",
    "dsmc",
    "analysis",
    "study",
    "cli",
    "python/src",
    "distributed/src",
];

fn main() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let root = root.ancestors().find(|path| path.join("model").exists());
    println!(
        "cargo::rustc-env=STOSSZAHL_COMMIT={}",
        root.and_then(commit).unwrap_or_default()
    );
}

fn commit(root: &Path) -> Option<String> {
    let git = |arguments: &[&str]| {
        let done = Command::new("git")
            .current_dir(root)
            .args(arguments)
            .output()
            .ok()?;
        let text = String::from_utf8(done.stdout).ok()?;
        done.status.success().then(|| text.trim().to_owned())
    };
    // Commit of this clone only, not of a folder around the sources.
    let top = git(&["rev-parse", "--show-toplevel"])?;
    if Path::new(&top).canonicalize().ok()? != root.canonicalize().ok()? {
        return None;
    }
    let head = git(&["rev-parse", "--short=12", "HEAD"])?;
    let log = root.join(git(&["rev-parse", "--git-path", "logs/HEAD"])?);
    let sources = SOURCES.map(|path| root.join(path));
    for path in sources.iter().chain([&log]).filter(|path| path.exists()) {
        println!("cargo::rerun-if-changed={}", path.display());
    }
    let changed = git(&[
        &["status", "--porcelain", "--untracked-files=no", "--"],
        &SOURCES[..],
    ]
    .concat())?;
    Some(if changed.is_empty() {
        head
    } else {
        head + ", changed"
    })
}
