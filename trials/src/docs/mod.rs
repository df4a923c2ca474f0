//! Generated results in README and `docs/`: blocks of Markdown, pictures and tables, each from
//! named runs of a named commit.
//!
//! A block stands between `<!-- docs NAME: commit C, date D, statistics ed=1 dsmc=1 -->` and `<!--
//! end of NAME -->`. [`ENTRIES`] lists its runs and the functions that format its tables. With
//! `--check` cheap blocks are regenerated and compared number by number within their standard
//! errors (`compare`). Costly blocks are checked by statistics versions: a block fails once an
//! engine behind it has a newer version. Hand-typed blocks are checked in the same way; their first
//! line names the cases of their numbers. An empty block is reported but is no fault.
//!
//! A long table is a file `docs/data/NAME.csv`. The block then shows counts, deviating rows and a
//! link ([`DataTable`]). A check regenerates this text from the file.

mod accuracy;
mod block;
mod compare;
mod course;
mod data;
mod entries;
mod gases;
mod map;
mod papers;
mod results;
mod table_file;
mod tables;
mod verdicts;

use std::fs;
use std::path::Path;
use std::process::Command;

use clap::Args;
use stosszahl_model::snapshot::write_whole;
use stosszahl_results::{FinishedPoints, Table};

use crate::terminal::say;
use crate::{Done, TrialError};

pub use block::{Head, PageBlock, find_block, is_open, names as block_names, outside, replace};
pub use compare::differences;
pub use data::{DataMaker, DataTable, FOLDER as DATA, Made, ROWS_OF_A_PAGE, generated_rows};
pub use entries::{DocsEntry, ENTRIES, EngineVersion, EntrySource};
use entries::{VERSIONS, versions};
pub use results::{run_bundled, run_papers};
pub use table_file::unfounded;

/// Options of `stosszahl-trials docs`, which regenerates or checks documentation blocks.
#[derive(Clone, Debug, Args)]
pub struct Docs {
    /// Documentation block to make; may be repeated [default: the cheap ones].
    #[arg(value_name = "NAME", value_parser = names())]
    pub name: Vec<String>,
    /// Change nothing, and report outdated or differing blocks.
    #[arg(long)]
    pub check: bool,
    /// Make all documentation blocks, also those that take hours of a core.
    #[arg(long, conflicts_with_all = ["check", "name"])]
    pub costly: bool,
    /// Use of stored numbers instead of new runs.
    #[command(flatten)]
    pub stored: DocsStored,
}

/// Sources of stored numbers that `stosszahl-trials docs` may use instead of new runs.
#[derive(Clone, Copy, Debug, Args)]
pub struct DocsStored {
    /// Run nothing: regenerate the text of blocks whose table is a file in docs/data from that
    /// file.
    #[arg(long, conflicts_with_all = ["check", "name", "costly", "resume"])]
    pub from_files: bool,
    /// Resume runs in results/docs that were stopped, and use those that are complete.
    #[arg(long, conflicts_with = "check")]
    pub resume: bool,
}

/// Path of the repository root, at compile time.
pub const ROOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/..");

/// Returns the names of all documentation blocks as possible values of the command line.
pub(crate) fn names() -> clap::builder::PossibleValuesParser {
    ENTRIES
        .iter()
        .map(|entry| entry.name)
        .collect::<Vec<_>>()
        .into()
}

/// Runs `stosszahl-trials docs`: regenerates documentation blocks, or checks them.
pub(crate) fn command(asked: &Docs) -> Done {
    let root = Path::new(ROOT);
    if asked.stored.from_files {
        return rewrite(root);
    }
    let chosen = ENTRIES.iter().filter(|entry| match &asked.name[..] {
        [] => asked.check || asked.costly || entry.is_cheap,
        names => names.iter().any(|name| name == entry.name),
    });
    let mut faults = 0;
    for entry in chosen {
        let place = format!("{} in {}", entry.name, entry.file);
        if !asked.check {
            make(root, entry, asked.stored.resume)?;
            say(&format!("made  {place}"));
        } else if is_open(&fs::read_to_string(root.join(entry.file))?, entry.name) {
            say(&format!("open  {place}: not made yet"));
        } else {
            faults += print_faults(&place, &check_block(root, entry)?);
        }
    }
    if asked.check && asked.name.is_empty() {
        let mut names = Vec::new();
        for file in pages(root)? {
            let page = fs::read_to_string(root.join(&file))?;
            for (name, mut found) in stale_typed(&page) {
                found.extend(unfounded(root, &page, &name));
                faults += print_faults(&format!("{name} in {file}, typed in"), &found);
            }
            names.extend(block_names(&page));
        }
        for file in strays(root, &names)? {
            faults += print_faults(&file, &["no block has this name".to_owned()]);
        }
    }
    match faults {
        0 => Ok(()),
        some => Err(TrialError::failed(format!(
            "{some} faults; `stosszahl-trials docs NAME` makes a block again, and CHANGELOG says why its numbers moved"
        ))),
    }
}

/// Regenerates the text of all blocks that have a table file, from these files.
fn rewrite(root: &Path) -> Done {
    for file in pages(root)? {
        let path = root.join(&file);
        let mut page = fs::read_to_string(&path)?;
        for name in block_names(&page) {
            let text = table_file::text_of_file(root, &name)?;
            let made = text.zip(find_block(&page, &name));
            let made = made.and_then(|(text, block)| replace(&page, &block.head, &text));
            if let Some(made) = made.filter(|made| *made != page) {
                page = made;
                write_whole(&path, page.as_bytes())?;
                say(&format!("made  {name} in {file}"));
            }
        }
    }
    Ok(())
}

/// Prints the faults of a documentation block, and returns their number.
fn print_faults(place: &str, found: &[String]) -> usize {
    say(&format!(
        "{}  {place}",
        if found.is_empty() { "pass" } else { "FAIL" }
    ));
    for fault in found {
        say(&format!("      {fault}"));
    }
    found.len()
}

/// Returns the paths of README and of all pages in `docs`, relative to the repository root and
/// sorted.
///
/// # Errors
/// The folder cannot be read.
pub fn pages(root: &Path) -> Result<Vec<String>, TrialError> {
    let mut all = vec!["README.md".to_owned()];
    for entry in fs::read_dir(root.join("docs"))? {
        let name = entry?.file_name().to_string_lossy().into_owned();
        if Path::new(&name)
            .extension()
            .is_some_and(|ending| ending == "md")
        {
            all.push(format!("docs/{name}"));
        }
    }
    all.sort();
    Ok(all)
}

/// Returns the hand-typed blocks of a page, which no command generates, each with the reasons why
/// its numbers are outdated.
pub fn stale_typed(page: &str) -> Vec<(String, Vec<String>)> {
    let mut names = block_names(page);
    names.retain(|name| ENTRIES.iter().all(|entry| entry.name != name));
    let look = |name: String| {
        let found = match find_block(page, &name) {
            None => vec!["its first line cannot be read".to_owned()],
            Some(block) if block.head.typed.is_none() => {
                vec![
                    "no entry makes it, and its first line names no case that it was typed from"
                        .to_owned(),
                ]
            }
            Some(block) => outdated(&block.head, &versions(&VERSIONS)),
        };
        (name, found)
    };
    names.into_iter().map(look).collect()
}

/// Lists the engines of a block whose statistics version has changed since, as sentences.
fn outdated(head: &Head, now: &[(String, u32)]) -> Vec<String> {
    let old = head.statistics.iter().filter_map(|(engine, then)| {
        let version = now.iter().find(|one| one.0 == *engine);
        let word = version.map_or("none".to_owned(), |one| one.1.to_string());
        (word != then.to_string()).then(|| {
            format!("it rests on statistics {then} of {engine}, which are {word} by now: to be made again")
        })
    });
    old.collect()
}

/// Runs the case of a documentation block, and writes the block and its files.
fn make(root: &Path, entry: &DocsEntry, resume: bool) -> Done {
    let (results, commit) = run_entry(root, entry, resume)?;
    let made = entry.made(&results)?;
    // The page may have changed meanwhile.
    let path = root.join(entry.file);
    let text = fs::read_to_string(&path)?;
    let head = Head {
        name: entry.name.to_owned(),
        date: date(root, &commit),
        commit,
        statistics: entry.statistics(),
        typed: None,
    };
    for (file, content) in &made.files {
        write(&root.join(file), content)?;
    }
    let text = replace(&text, &head, &made.text)
        .ok_or_else(|| TrialError::failed(format!("{}: no block {}", entry.file, entry.name)))?;
    Ok(write_whole(&path, text.as_bytes())?)
}

/// Lists the faults of a documentation block as sentences; empty if it is up to date.
fn check_block(root: &Path, entry: &DocsEntry) -> Result<Vec<String>, TrialError> {
    let text = fs::read_to_string(root.join(entry.file))?;
    let mut stale = stale(&text, entry);
    stale.extend(unfounded(root, &text, entry.name));
    if !stale.is_empty() || !entry.is_cheap {
        return Ok(stale);
    }
    let (results, _) = run_entry(root, entry, false)?;
    faults(&text, entry, &results)
}

/// Lists the faults of a block's first line that new results cannot cure, such as old statistics
/// versions; empty if there are none.
pub fn stale(page: &str, entry: &DocsEntry) -> Vec<String> {
    let Some(block) = find_block(page, entry.name) else {
        return vec![format!("there is no such block in {}", entry.file)];
    };
    let now = entry.statistics();
    let unnamed = now.iter().filter(|(engine, _)| {
        let named = block.head.statistics.iter();
        !named.clone().any(|one| one.0 == *engine)
    });
    let unnamed =
        unnamed.map(|(engine, _)| format!("its first line has no statistics of {engine}"));
    unnamed.chain(outdated(&block.head, &now)).collect()
}

/// Lists the differences between a block on a page and new results. Numbers may differ within their
/// standard errors.
///
/// # Errors
/// The results lack a number that the block shows.
pub fn faults(
    page: &str,
    entry: &DocsEntry,
    results: &FinishedPoints,
) -> Result<Vec<String>, TrialError> {
    let there = find_block(page, entry.name).map_or(String::new(), |block| block.text);
    Ok(differences(&there, &entry.made(results)?.text))
}

/// Lists the table files in `docs/data` that belong to none of the named blocks.
///
/// # Errors
/// The folder cannot be read.
pub fn strays(root: &Path, names: &[String]) -> Result<Vec<String>, TrialError> {
    let known: Vec<String> = names.iter().map(|name| data::path(name)).collect();
    let mut found = Vec::new();
    for entry in fs::read_dir(root.join(DATA))? {
        let file = format!("{DATA}/{}", entry?.file_name().to_string_lossy());
        if !known.contains(&file) {
            found.push(file);
        }
    }
    found.sort();
    Ok(found)
}

/// Writes a file of a documentation block, and creates its folder if absent.
fn write(path: &Path, content: &str) -> Done {
    if let Some(folder) = path.parent() {
        fs::create_dir_all(folder)?;
    }
    Ok(write_whole(path, content.as_bytes())?)
}

/// Runs the case or the papers of a documentation block into `results/docs`. Returns the results
/// and their commit.
fn run_entry(
    root: &Path,
    entry: &DocsEntry,
    resume: bool,
) -> Result<(FinishedPoints, String), TrialError> {
    let out = root.join("results/docs").join(entry.source.folder());
    let commit = git(root, &["rev-parse", "--short=12", "HEAD"]);
    match entry.source {
        EntrySource::Case(case) => run_bundled(case, &[], &out, resume, &commit),
        EntrySource::Papers => run_papers(&out, resume, &commit),
    }
}

/// Writes the table of claims about accuracy to `data/validation.csv` next to the page, and returns
/// the block of the page.
///
/// # Errors
/// The file cannot be written.
pub(crate) fn claims_block(
    command: &str,
    table: &Table,
    page: &Path,
) -> Result<String, TrialError> {
    let root = Path::new(ROOT);
    let commit = git(root, &["rev-parse", "--short=12", "HEAD"]);
    let head = Head {
        name: "validation".to_owned(),
        date: date(root, &commit),
        commit,
        statistics: versions(&VERSIONS),
        typed: Some(command.to_owned()),
    };
    let made = table_file::claims_block(table)?;
    for (file, content) in &made.files {
        let beside = Path::new(file).strip_prefix("docs")?;
        write(&page.with_file_name("").join(beside), content)?;
    }
    Ok(head.format_block(&made.text))
}

/// Returns the date of a git commit, as YYYY-MM-DD.
fn date(root: &Path, commit: &str) -> String {
    let commit = commit.split(' ').next().unwrap_or_default();
    git(root, &["show", "--no-patch", "--format=%cs", commit])
}

/// Runs git with arguments and returns its output; "unknown" if git fails or prints nothing.
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
