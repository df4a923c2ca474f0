//! Execution of the commands of the program, and what they print.

use std::io::{self, IsTerminal, Write as _};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::slice;
use std::time::Duration;

use crate::BUNDLE;
use crate::case::CaseFile;
use crate::case::format::parse_share;
use crate::report::{Listed, Listing, ReportError, listing, write_report};
use crate::results::{
    Existing, Manifest, changed_files, format_duration, format_rough, format_significant,
    quantity_title, write_file,
};
use crate::study::cost::EngineCost;
use crate::study::frontier::{self, FrontierError, frontier};
use crate::study::plan::{available_memory, available_threads};
use crate::study::run::needed_memory;
use crate::study::{self, RunError, RunOptions, check_case};
use clap::CommandFactory as _;

use crate::arguments::{Arguments, CaseArguments, Command, FrontierArguments, InitArguments};
use crate::error::CommandError;
use crate::run::{merge, run_on_threads};
pub(crate) use crate::terminal::say;
use crate::terminal::{listen, note};

use crate::init as template;
use crate::progress::Display;
use crate::reference;
use crate::reproduce::reproduce;
use crate::terminal::beside;

/// File name of the report page of a frontier, in its results folder.
const PAGE: &str = "frontier.html";
/// Longest time that `check` spends on measuring speeds \[s\].
const MEASURING: f64 = 10.0;

/// Prints help and version texts, or why arguments were refused, and returns the exit code.
pub fn tell(asked: &clap::Error) -> ExitCode {
    let printed = asked.print().and_then(|()| io::stdout().flush());
    match printed {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => ended(Err(error.into())),
        _ => ExitCode::from(u8::try_from(asked.exit_code()).unwrap_or(2)),
    }
}

/// Executes a parsed command line and returns its exit code.
pub fn execute(arguments: Arguments) -> ExitCode {
    let done = match arguments.command {
        Command::Run { run, joining, part } => {
            read(&run.case).and_then(|file| run_on_threads(&run, &file, &joining, part))
        }
        Command::Merge(arguments) => merge(&arguments),
        Command::Check { case, no_timing } => outline(&case, no_timing),
        Command::Cases { name } => cases(name.as_deref()),
        Command::Init(arguments) => init(&arguments),
        Command::Report { folder } => rebuild_report(&folder),
        Command::Figure(arguments) => crate::figure::figure(&arguments),
        Command::Schema => schema(),
        Command::Completions { shell } => completions(shell),
        Command::Reference { folders } => print_reference(&folders),
        Command::Manual { folder } => manual(&folder),
        Command::Frontier { frontier, joining } => read(&frontier.case)
            .and_then(|file| measure_frontier(&frontier, &file, joining.lost_after())),
        Command::Reproduce(arguments) => reproduce(&arguments),
    };
    ended(done)
}

/// Prints the error of a command, if there is one, and returns its exit code.
pub fn ended(done: Result<(), CommandError>) -> ExitCode {
    let Err(error) = done else {
        return ExitCode::SUCCESS;
    };
    match &error {
        CommandError::Case(error)
        | CommandError::Run(RunError::Case(error))
        | CommandError::Frontier(FrontierError::Invalid(error)) => {
            note(&error.report(io::stderr().is_terminal()));
        }
        // What was asked for is no error.
        CommandError::OutOfTime => {}
        _ => print_error(&error),
    }
    ExitCode::from(error.exit_code())
}

/// Prints an error and its chain of causes, each cause once.
fn print_error(error: &CommandError) {
    let mut said = error.to_string();
    note(&format!("error: {said}"));
    let mut cause = std::error::Error::source(error);
    while let Some(deeper) = cause {
        let text = deeper.to_string();
        if !said.contains(&text) {
            note(&format!("  because: {text}"));
            said.push_str(&text);
        }
        cause = deeper.source();
    }
}

/// Reads a case from a file, or the bundled case of that name.
///
/// # Errors
/// [`CommandError::Case`] if it is refused.
pub fn read(arguments: &CaseArguments) -> Result<CaseFile, CommandError> {
    let file = BUNDLE.read_case(&study::format(), &arguments.case, &arguments.overrides())?;
    for text in &file.notes {
        note(text);
    }
    Ok(file)
}

/// Prints the bundled cases with their questions, or the text of one of them.
fn cases(name: Option<&str>) -> Result<(), CommandError> {
    let Some(name) = name else {
        let all = BUNDLE.cases();
        let widest = all.iter().map(|one| one.name.len()).max().unwrap_or(0);
        for one in all {
            say(&beside(
                &format!("{:<widest$}  ", one.name),
                &one.question(),
            ))?;
        }
        return Ok(());
    };
    let found = BUNDLE.named(name);
    let found = found.ok_or_else(|| CommandError::NoBundledCase(name.to_owned()))?;
    Ok(say(found.text.trim_end())?)
}

/// Writes a new case file from a template; checks first that the case passes `check`.
fn init(arguments: &InitArguments) -> Result<(), CommandError> {
    let path = &arguments.file;
    if path.exists() && !arguments.force {
        return Err(CommandError::FileExists(path.clone()));
    }
    let text = template::text(arguments);
    check_case(&study::format().from_text(path, &text, &[])?)?;
    write_file(path, text.as_bytes())?;
    let name = path.display();
    say(&format!(
        "{name}\nnext: stosszahl check {name}, then stosszahl run {name}"
    ))?;
    Ok(())
}

fn schema() -> Result<(), CommandError> {
    Ok(say(&format!("{:#}", study::format().json()))?)
}

fn completions(shell: clap_complete::Shell) -> Result<(), CommandError> {
    let mut text = Vec::new();
    clap_complete::generate(shell, &mut Arguments::command(), "stosszahl", &mut text);
    Ok(say(String::from_utf8_lossy(&text).trim_end())?)
}

fn print_reference(folders: &[PathBuf]) -> Result<(), CommandError> {
    let page = if folders.is_empty() {
        reference::keys(study::format().json())
    } else {
        let read = |folder: &PathBuf| {
            Manifest::read(folder)?.ok_or_else(|| ReportError::NoResults {
                folder: folder.clone(),
            })
        };
        let manifests: Vec<Manifest> = folders.iter().map(read).collect::<Result<_, _>>()?;
        reference::columns(&manifests)
    };
    Ok(say(page.trim_end())?)
}

fn manual(folder: &Path) -> Result<(), CommandError> {
    std::fs::create_dir_all(folder)
        .and_then(|()| clap_mangen::generate_to(Arguments::command(), folder))
        .map_err(|source| CommandError::Folder {
            path: folder.to_owned(),
            source,
        })
}

/// Rebuilds the report of a results folder, and names the files that are not in its manifest.
fn rebuild_report(folder: &Path) -> Result<(), CommandError> {
    let page = write_report(folder)?;
    for file in changed_files(folder)? {
        note(&format!(
            "warning: {} is not the file that the run wrote, and the report shows it as it is; `stosszahl run CASE --resume` makes it again",
            file.display()
        ));
    }
    Ok(say(&page.display().to_string())?)
}

fn outline(arguments: &CaseArguments, no_timing: bool) -> Result<(), CommandError> {
    let file = read(arguments)?;
    let threads = available_threads();
    let mut planned = check_case(&file)?;
    let mut paces = None;
    if !no_timing {
        let (stop, display) = (listen("stopped"), Display::new());
        let options = RunOptions {
            out: None,
            existing: Existing::Refuse,
            threads: None,
            ignore_memory_limit: false,
            stop: &stop,
            progress: &display,
            commit: "",
        };
        planned = study::choose_resolutions(&file, planned, &options, threads)?;
        // No measurement of a case that does not fit into memory.
        let needed = needed_memory(&planned, threads);
        if available_memory().is_none_or(|free| needed < free) {
            paces = Some(study::run::measured_time::paces(
                &planned, threads, MEASURING,
            )?);
        }
    }
    let outlines = planned.iter().enumerate().map(|(number, planned)| {
        let mut outline = planned.outline(threads);
        if let Some(paces) = &paces {
            outline.cost.pace.clone_from(&paces[number]);
        }
        outline
    });
    let outlines: Vec<_> = outlines.collect();
    let (about, mut seconds) = (if paces.is_some() { "about" } else { "roughly" }, 0.0);
    for (number, outline) in outlines.iter().enumerate() {
        if number == 0 {
            say(&file.title())?;
            if let Some(question) = file.question() {
                say(&question)?;
            }
        }
        if !outline.point.is_empty() {
            say(&format!("\n{}", outline.point))?;
        }
        for quantity in &outline.derived {
            let text = format!(
                "  {:<50} {} {}",
                quantity_title(&quantity.name),
                format_significant(quantity.value, 6),
                Some(&*quantity.unit)
                    .filter(|unit| *unit != "1")
                    .unwrap_or_default()
            );
            say(text.trim_end())?;
        }
        say(&format!("  engines: {}", outline.engines.join(", ")))?;
        say(&format!("  measures: {}", outline.measures.join(", ")))?;
        say(&format!("  headline: verdict on {}", outline.leading))?;
        say(&format!(
            "  {} replicas, about {:.2} GiB of memory and {about} {} on {threads} threads",
            outline.replicas,
            outline.cost.bytes / 1_073_741_824.0,
            format_duration(outline.cost.seconds(threads))
        ))?;
        let cost = &outline.cost;
        for (one, [seconds, _]) in cost.engines.iter().zip(&cost.pace.engines) {
            say(&format!("    {}", engine_cost(one, about, *seconds)))?;
        }
        for choice in &outline.choices {
            say(&format!("  choice: {choice}"))?;
        }
        for power in &outline.power {
            say(&format!("  power: {power}"))?;
        }
        for warning in &outline.warnings {
            say(&format!("  warning: {warning}"))?;
        }
        for unknown in outline.unknown.iter().filter(|_| paces.is_none()) {
            say(&format!("  not in the guess: {unknown}"))?;
        }
        seconds += outline.cost.seconds(threads);
    }
    if outlines.len() > 1 {
        let points = outlines.len();
        say(&format!(
            "\n{points} points, {about} {} in all",
            format_duration(seconds)
        ))?;
    }
    let needed = needed_memory(&planned, threads);
    if let Some(available) = available_memory().filter(|free| needed > *free) {
        let refused = RunError::Memory { needed, available };
        say(&format!("  warning: `run` refuses this here: {refused}"))?;
    }
    Ok(())
}

/// Formats the estimated cost of one engine in one replica as a line of text.
fn engine_cost(cost: &EngineCost, about: &str, seconds: f64) -> String {
    let tried = match cost.trials_per_collision {
        Some(trials) => format!(", {} trials", format_rough(trials * cost.collisions)),
        None => String::new(),
    };
    format!(
        "{}: about {} collisions{tried}, {:.3} GiB of memory and {about} {} on one thread, in each replica",
        cost.name,
        format_rough(cost.collisions),
        cost.bytes / 1_073_741_824.0,
        format_duration(seconds)
    )
}

/// Measures the frontier of a case, and prints the results. With `join`, it shares the work with
/// other processes.
///
/// # Errors
/// [`CommandError`] of the sweep or of its report.
pub fn measure_frontier(
    arguments: &FrontierArguments,
    file: &CaseFile,
    join: Option<Duration>,
) -> Result<(), CommandError> {
    let target = parse_share(&arguments.target_error).ok_or_else(|| CommandError::Target {
        found: arguments.target_error.clone(),
    })?;
    let folder = arguments.out.clone().unwrap_or_else(|| {
        let name = file.path.file_stem().unwrap_or_else(|| "case".as_ref());
        let mut name = name.to_owned();
        name.push("-frontier");
        Path::new("results").join(name)
    });
    let kinds = match &arguments.quantity[..] {
        [] => vec![frontier::QuantityKind::Energy],
        asked => asked.to_vec(),
    };
    let stop = listen("stopped; the same command goes on with the runs that are kept");
    let options = frontier::FrontierOptions {
        interrupt: &stop,
        join,
        kinds,
        target,
        budget: arguments.budget.as_secs_f64().max(f64::MIN_POSITIVE),
        cache: arguments.cache.clone().unwrap_or_else(|| folder.clone()),
        folder,
        threads: arguments
            .threads
            .map_or_else(available_threads, usize::from),
        tests: arguments.tests,
        force: arguments.force,
        tell: &note,
    };
    let found = frontier(file, &options)?;
    print_frontier(&found)
}

/// Prints the results of a frontier, and writes its report page.
fn print_frontier(found: &frontier::Frontier) -> Result<(), CommandError> {
    say(&found.headline)?;
    for sentence in &found.conclusions {
        say(sentence)?;
    }
    say(&found.provenance)?;
    let lists: Vec<Listing<'_>> = (found.lists.iter())
        .map(|one| (&*one.title, one.columns, &*one.rows))
        .collect();
    let title = format!("Speed against error: {}", found.title);
    let page = listing(&Listed {
        title: &title,
        headline: &found.headline,
        figure: &found.figure,
        lines: &found.conclusions,
        folded: &[
            ("What was measured", slice::from_ref(&found.provenance)),
            ("What was left out", &found.left_out),
        ],
        lists: &lists,
    });
    if found.is_reporter {
        found.held.write(PAGE, page.as_bytes())?;
    }
    let path = found.held.path().join(PAGE);
    Ok(say(&format!("report: {}", path.display()))?)
}
