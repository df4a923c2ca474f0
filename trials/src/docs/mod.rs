//! Results in README and `docs/` that are made by a command: blocks of Markdown, pictures and tables, each from named runs of a named
//! commit.
//!
//! A block stands between `<!-- docs NAME: commit C, date D, statistics ed=1 dsmc=1 -->` and `<!-- end of NAME -->`. [`ENTRIES`]
//! says for each which bundled case it runs and how its tables become text. With `--check` cheap entries are made again and compared
//! number by number within their errors (`compare`). Of costly ones the statistics versions of the engines are compared: the block
//! is refused once an engine that it rests on gives other means.

mod block;
mod compare;
mod entries;
mod map;
mod picture;
mod results;

use std::fs;
use std::path::Path;
use std::process::Command;

use stosszahl_model::snapshot::write_whole;

use crate::arguments::Docs;
use crate::commands::say;
use crate::{Done, Trouble};

pub use block::{Block, Head, find, replace};
pub use compare::differences;
pub use entries::{ENTRIES, Engine, Entry, Made};
pub use results::Results;

/// The root of the repository.
pub const ROOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/..");

/// Names of all entries, for the command line.
pub(crate) fn names() -> clap::builder::PossibleValuesParser {
    ENTRIES
        .iter()
        .map(|entry| entry.name)
        .collect::<Vec<_>>()
        .into()
}

/// Does what the command line asks: makes blocks anew, or checks them.
pub(crate) fn command(asked: &Docs) -> Done {
    let root = Path::new(ROOT);
    let chosen = ENTRIES.iter().filter(|entry| match &asked.name[..] {
        [] => asked.check || asked.costly || entry.is_cheap,
        names => names.iter().any(|name| name == entry.name),
    });
    let mut faults = 0;
    for entry in chosen {
        let place = format!("{} in {}", entry.name, entry.file);
        if asked.check {
            let found = check(root, entry)?;
            say(&format!(
                "{}  {place}",
                if found.is_empty() { "pass" } else { "FAIL" }
            ));
            for fault in &found {
                say(&format!("      {fault}"));
            }
            faults += found.len();
        } else {
            make(root, entry, asked.resume)?;
            say(&format!("made  {place}"));
        }
    }
    match faults {
        0 => Ok(()),
        some => Err(Trouble::failed(format!(
            "{some} faults; `stosszahl-trials docs NAME` makes a block again, and CHANGELOG says why its numbers moved"
        ))),
    }
}

/// Makes the block of an entry, and its files.
fn make(root: &Path, entry: &Entry, resume: bool) -> Done {
    let path = root.join(entry.file);
    let text = fs::read_to_string(&path)?;
    let (results, commit) = run(root, entry, resume)?;
    let made = (entry.make)(&results)?;
    let head = Head {
        name: entry.name.to_owned(),
        date: date(root, &commit),
        commit,
        statistics: entry.statistics(),
    };
    for (file, content) in &made.files {
        write_whole(&root.join(file), content.as_bytes())?;
    }
    let text = replace(&text, &head, &made.text)
        .ok_or_else(|| Trouble::failed(format!("{}: no block {}", entry.file, entry.name)))?;
    Ok(write_whole(&path, text.as_bytes())?)
}

/// What is wrong with the block of an entry; nothing if all is well.
fn check(root: &Path, entry: &Entry) -> Result<Vec<String>, Trouble> {
    let text = fs::read_to_string(root.join(entry.file))?;
    let stale = stale(&text, entry);
    if !stale.is_empty() || !entry.is_cheap {
        return Ok(stale);
    }
    let (results, _) = run(root, entry, false)?;
    faults(&text, entry, &results)
}

/// Why the block of an entry in a page does not hold any more whatever is found now; nothing if it may hold.
pub fn stale(page: &str, entry: &Entry) -> Vec<String> {
    let Some(block) = find(page, entry.name) else {
        return vec![format!("there is no such block in {}", entry.file)];
    };
    let stale = entry.statistics().into_iter().filter_map(|(engine, now)| {
        let then = block.head.statistics.iter().find(|one| one.0 == engine);
        let then = then.map_or("none".to_owned(), |one| one.1.to_string());
        (then != now.to_string()).then(|| {
            format!("it rests on statistics {then} of {engine}, which are {now} by now: to be made again")
        })
    });
    stale.collect()
}

/// Where the block of an entry in a page parts from results.
///
/// # Errors
/// The results have not what the block shows.
pub fn faults(page: &str, entry: &Entry, results: &Results) -> Result<Vec<String>, Trouble> {
    let there = find(page, entry.name).map_or(String::new(), |block| block.text);
    Ok(differences(&there, &(entry.make)(results)?.text))
}

/// Runs the case of an entry into `results/docs`; its results, and the commit that they are of.
fn run(root: &Path, entry: &Entry, resume: bool) -> Result<(Results, String), Trouble> {
    let out = root.join("results/docs").join(entry.case);
    let commit = git(root, &["rev-parse", "--short=12", "HEAD"]);
    Results::of(entry.case, &[], &out, resume, &commit)
}

/// Day of a commit.
fn date(root: &Path, commit: &str) -> String {
    let commit = commit.split(' ').next().unwrap_or_default();
    git(root, &["show", "--no-patch", "--format=%cs", commit])
}

/// What git says; "unknown" where it says nothing.
fn git(root: &Path, arguments: &[&str]) -> String {
    let output = Command::new("git")
        .current_dir(root)
        .args(arguments)
        .output();
    let said = output.ok().filter(|output| output.status.success());
    let said = said.and_then(|output| String::from_utf8(output.stdout).ok());
    said.map(|text| text.trim().to_owned())
        .filter(|text| !text.is_empty())
        .unwrap_or_else(|| "unknown".to_owned())
}
