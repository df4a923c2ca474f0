//! The command `reproduce`: papers, their figures, and verdicts on their claims.

use std::path::{Path, PathBuf};

use crate::BUNDLE;
use crate::case::{Bundled, PaperFile};
use crate::report::figure_name;
use crate::reproduction::{ReproduceOptions, Reproduction};
use crate::results::{Existing, format_duration};
use crate::study::RunOptions;
use crate::study::plan::available_threads;

use crate::arguments::ReproduceArguments;
use crate::error::CommandError;
use crate::progress::Display;
use crate::terminal::{line, listen, note, say};

/// Message printed when a reproduction was stopped.
const STOPPED: &str = "stopped; the same command goes on from the checkpoints";

/// Returns the text of the bundled case of a name; `None` if there is none.
fn bundled_case(name: &str) -> Option<String> {
    BUNDLE.named(name).map(|one| one.text.to_owned())
}

/// Parses a bundled paper.
fn bundled_paper(one: Bundled) -> Result<PaperFile, CommandError> {
    let path = PathBuf::from(format!("{}.toml", one.name));
    Ok(PaperFile::from_text(&path, one.text)?)
}

/// Reproduces the figures and claims of a paper, or lists the bundled papers.
///
/// # Errors
/// [`CommandError`] of the paper, its cases, its runs, or its page.
pub fn reproduce(arguments: &ReproduceArguments) -> Result<(), CommandError> {
    let Some(asked) = &arguments.paper else {
        return list(arguments);
    };
    let (name, file) = read(asked)?;
    let demand = ReproduceOptions {
        figure: arguments.figure.as_deref(),
        quick: arguments.quick,
    };
    let reproduction = Reproduction::new(&file, demand, &bundled_case)?;
    let (stop, display) = (listen(STOPPED), Display::new());
    let options = RunOptions {
        out: None,
        existing: Existing::Refuse,
        threads: arguments.threads.map(usize::from),
        ignore_memory_limit: arguments.ignore_memory_limit,
        stop: &stop,
        progress: &display,
        commit: env!("STOSSZAHL_COMMIT"),
    };
    let folder = arguments.out.clone().unwrap_or_else(|| {
        let quick = if arguments.quick { "-quick" } else { "" };
        Path::new("results").join(format!("{name}{quick}"))
    });
    if let Err(error) = reproduction.run_cases(&folder, &options, arguments.force) {
        let error = CommandError::from(error);
        if error.is_interruption() {
            note(STOPPED);
        }
        return Err(error);
    }
    let judged = reproduction.judge(&folder)?;
    let page = reproduction.write(&folder, &judged)?;
    for one in &judged.outcomes {
        let (figure, verdict) = (figure_name(one.figure), &one.verdict);
        let said = format!("{figure}: {}. {}", verdict.topic, verdict.sentence);
        say(&line(one.verdict.kind.name(), &said))?;
    }
    say(&judged.count())?;
    Ok(say(&page.display().to_string())?)
}

/// Reads a paper from a file, or a bundled one; returns its name, too.
fn read(asked: &Path) -> Result<(String, PaperFile), CommandError> {
    let name = asked.file_stem().unwrap_or(asked.as_os_str());
    let name = name.to_string_lossy().into_owned();
    if asked.is_file() {
        return Ok((name, PaperFile::read(asked)?));
    }
    let found = BUNDLE
        .papers()
        .into_iter()
        .find(|one| asked == Path::new(one.name));
    let Some(found) = found else {
        if asked.exists() {
            return Ok((name, PaperFile::read(asked)?));
        }
        return Err(CommandError::NoBundledPaper(asked.display().to_string()));
    };
    Ok((found.name.to_owned(), bundled_paper(found)?))
}

/// Prints the bundled papers with their figures, running times and missing parts.
fn list(arguments: &ReproduceArguments) -> Result<(), CommandError> {
    let threads = arguments
        .threads
        .map_or_else(available_threads, usize::from);
    for (number, one) in BUNDLE.papers().into_iter().enumerate() {
        let file = bundled_paper(one)?;
        let planned = |quick| {
            let demand = ReproduceOptions {
                figure: None,
                quick,
            };
            Reproduction::new(&file, demand, &bundled_case)
        };
        let (full, quick) = (planned(false)?, planned(true)?);
        if number > 0 {
            say("")?;
        }
        say(&format!("{}: {}", one.name, file.paper.title))?;
        say(&format!("  {}", file.paper.source))?;
        say(&format!(
            "  roughly {} on {threads} threads, quick runs {}",
            format_duration(full.seconds(threads)),
            format_duration(quick.seconds(threads))
        ))?;
        let both = full.outline(threads).into_iter();
        let both = both.zip(quick.outline(threads));
        for (full, quick) in both {
            let figure = full.figure;
            let said = format!(
                "{}; {} claims, {} in quick runs; roughly {}, quick {}",
                figure.title,
                full.claims,
                quick.claims,
                format_duration(full.seconds),
                format_duration(quick.seconds)
            );
            say(&line(&format!("  {}", figure_name(&figure.name)), &said))?;
            if let Some(missing) = &figure.missing {
                say(&line("", &format!("not here: {missing}")))?;
            }
        }
    }
    Ok(())
}
