//! `stosszahl frontier`.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::thread;

use serde::Serialize;
use stosszahl_model::snapshot::write_whole;

use super::FrontierError;
use super::front::{Measured, rows};
use super::measure::{Task, Workshop};
use super::orders::orders;
use super::page::{self, Page};
use super::plan::{PATIENCE, TESTS, plan};
use super::quantity::{Kind, Quantity, measured as measured_case, quantities};
use super::recommend::{Choice, Engines, Target, choose, finer_that_fails, nearest, test};
use super::reference::{self, Cache, References};
use super::setting::{self, Setting};
use crate::arguments::FrontierArguments;
use crate::case::Velocities;
use crate::setup::Setup;
use crate::words::{duration, percent, share, time};

/// Files of the folder.
const TABLE: &str = "frontier.csv";
const ORDERS: &str = "orders.csv";
const PAGE: &str = "frontier.html";
const WORDS: &str = "recommendation.md";

/// What the options mean.
struct Options {
    kinds: Vec<Kind>,
    target: f64,
    budget: f64,
    folder: PathBuf,
    cache: PathBuf,
    threads: usize,
    tests: u64,
}

impl Options {
    fn new(arguments: &FrontierArguments) -> Result<Self, FrontierError> {
        let refuse = |option, found: &str, allowed| FrontierError::Option {
            option,
            found: found.to_owned(),
            allowed,
        };
        let target = &arguments.target_error;
        let budget = &arguments.budget;
        if arguments.threads == Some(0) {
            return Err(refuse("threads", "0", "is 1 or more"));
        }
        let folder = arguments.out.clone().unwrap_or_else(|| {
            let name = arguments.case.case.file_stem();
            let mut name = name.unwrap_or_else(|| "case".as_ref()).to_owned();
            name.push("-frontier");
            Path::new("results").join(name)
        });
        let kinds = if arguments.quantity.is_empty() {
            vec![Kind::Energy]
        } else {
            arguments.quantity.clone()
        };
        Ok(Self {
            kinds,
            target: share(target).ok_or_else(|| {
                refuse(
                    "target-error",
                    target,
                    "is a share such as 1% or 0.01, above 0 and below 1",
                )
            })?,
            budget: duration(budget).ok_or_else(|| {
                refuse(
                    "budget",
                    budget,
                    "is a time such as 90s, 10m or 1h, above 0 and at most a year",
                )
            })?,
            cache: arguments.cache.clone().unwrap_or_else(|| folder.clone()),
            folder,
            threads: arguments
                .threads
                .unwrap_or_else(|| thread::available_parallelism().map_or(1, usize::from)),
            tests: arguments.tests,
        })
    }
}

/// Refuses a case whose runs have no spread, or that is many cases.
fn check(setups: &[Setup]) -> Result<&Setup, FrontierError> {
    let [setup] = setups else {
        return Err(FrontierError::Case {
            found: format!("the case has a sweep of {} points", setups.len()),
            expected: "one point: fix the swept keys with --set",
        });
    };
    if setup.case.start.velocities == Velocities::File {
        return Err(FrontierError::Case {
            found: "start.velocities = \"file\" gives all replicas one start".into(),
            expected: "replicas with a spread: start.velocities = \"maxwellian\"",
        });
    }
    Ok(setup)
}

fn make(folder: &Path) -> Result<(), FrontierError> {
    fs::create_dir_all(folder).map_err(|source| FrontierError::Folder {
        path: folder.to_owned(),
        source,
    })
}

/// The folders, before any work: the results must be a new or empty one, or replaced on purpose.
fn open(options: &Options, force: bool) -> Result<(), FrontierError> {
    let folder = &options.folder;
    let full = fs::read_dir(folder).is_ok_and(|mut entries| entries.next().is_some());
    if full && !force {
        return Err(FrontierError::Exists {
            path: folder.clone(),
        });
    }
    make(folder)?;
    make(&options.cache)
}

fn table<R: Serialize>(path: &Path, rows: &[R]) -> Result<(), FrontierError> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    for row in rows {
        writer.serialize(row)?;
    }
    let bytes = writer
        .into_inner()
        .map_err(|error| csv::Error::from(error.into_error()))?;
    Ok(write_whole(path, &bytes)?)
}

/// A sweep on its way.
struct Sweep<'a> {
    options: &'a Options,
    workshop: &'a Workshop<'a>,
    quantities: Vec<Quantity>,
    references: References,
    measured: Vec<Measured>,
    /// Settings that were not measured, with the reason.
    left_out: Vec<(String, String)>,
}

impl<'a> Sweep<'a> {
    /// Finds the reference and measures all settings that the plan has time for.
    fn new(
        options: &'a Options,
        workshop: &'a Workshop<'a>,
        cache: &Cache,
    ) -> Result<Self, FrontierError> {
        let setup = workshop.setup;
        let quantities = quantities(&setup.case);
        let settings = setting::around(setup);
        let plan = plan(setup, &settings, options.budget);
        let references = reference::find(workshop, &quantities, plan.reference, cache)?;
        let mut sweep = Self {
            options,
            workshop,
            quantities,
            references,
            measured: Vec::new(),
            left_out: Vec::new(),
        };
        let mut tasks = Vec::new();
        for (setting, repetitions) in settings.into_iter().zip(plan.repetitions) {
            match repetitions {
                Some(repetitions) => tasks.push(Task {
                    setting,
                    replicas: 0..repetitions,
                }),
                None => sweep.leave_out(&setting, "too costly for the budget".into()),
            }
        }
        let outcomes = workshop.run(&tasks)?;
        for (task, outcome) in tasks.into_iter().zip(outcomes) {
            match outcome {
                Ok(samples) => sweep.measured.push(Measured::new(
                    task.setting,
                    setup.disks,
                    &samples,
                    &sweep.quantities,
                    &sweep.references.values,
                )),
                Err(reason) => sweep.leave_out(&task.setting, reason),
            }
        }
        Ok(sweep)
    }

    fn leave_out(&mut self, setting: &Setting, reason: String) {
        let label = setting.label(self.workshop.setup.disks);
        self.left_out.push((label, reason));
    }

    fn target(&self) -> Target<'_> {
        Target {
            error: self.options.target,
            kinds: &self.options.kinds,
            disks: self.workshop.setup.disks,
            tests: self.options.tests,
        }
    }

    /// What was measured against what, and what was left out.
    fn provenance(&self, cache: &Cache) -> Vec<String> {
        let setup = self.workshop.setup;
        let of = format!(
            "{} settings of {} disks at packing {:.4}, restitution {:.4}, up to t/t0 = {}.",
            self.measured.len(),
            setup.disks,
            setup.packing_fraction,
            setup.restitution,
            setup.case.run.until
        );
        let against = if self.references.runs == 0 {
            "Reference: theory, which is exact here.".to_owned()
        } else {
            format!(
                "Reference: {} runs of exact dynamics ({} made now), seed {}, version {}, fingerprint {}, kept in {}.",
                self.references.runs,
                self.references.made,
                setup.case.seed,
                env!("CARGO_PKG_VERSION"),
                &cache.fingerprint()[..16],
                cache.path().display()
            )
        };
        let left_out = self.left_out.iter();
        let left_out = left_out.map(|(label, reason)| format!("Left out: {label}: {reason}."));
        [format!("{of} {against}")]
            .into_iter()
            .chain(left_out)
            .collect()
    }

    /// Chooses a setting for each engine, tests it, and says what came of it.
    fn recommendations(&self) -> Result<Vec<String>, FrontierError> {
        let references = &self.references.values;
        let choices = Engines::ALL.map(|engines| {
            let target = self.target();
            choose(
                engines,
                &self.measured,
                &self.quantities,
                references,
                &target,
            )
        });
        // Time is kept for tests of what there is to test.
        let count = choices.iter().flatten().count().max(1);
        let share = TESTS * self.options.budget / count as f64;
        let said = Engines::ALL.into_iter().zip(choices);
        said.map(|(engines, choice)| match choice {
            Some(choice) => self.recommendation(engines, &choice, share),
            None => Ok(self.unmet(engines)),
        })
        .collect()
    }

    /// Tests a choice, and says what was predicted and found.
    fn recommendation(
        &self,
        engines: Engines,
        choice: &Choice,
        share: f64,
    ) -> Result<String, FrontierError> {
        let target = self.target();
        let tested = test(
            self.workshop,
            choice,
            &self.measured,
            &self.quantities,
            &self.references.values,
            &target,
            share,
        )?;
        let one = &self.measured[choice.index];
        let predicted = format!(
            "{}: for {} in {}, the cheapest setting is **{}** with {} replicas: predicted {} of core time, {:.1} MiB and an error \
             of {}.",
            engines.name(),
            percent(target.error),
            names(target.kinds),
            one.label,
            choice.replicas,
            time(choice.core_seconds),
            one.bytes as f64 / f64::from(1 << 20),
            percent(choice.error),
        );
        let found = format!(
            "On fresh seeds {} of {} tests were within {}; found {} of core time and an error of {}.",
            tested.kept,
            tested.tests,
            percent(target.error),
            time(tested.core_seconds),
            percent(tested.error),
        );
        let finer = finer_that_fails(choice, &self.measured, &self.quantities, &target);
        let finer = finer.map(|(finer, error)| {
            format!(
                " Its errors cancel: the finer {} is off by {}, so this holds for this case alone.",
                finer.label,
                percent(error)
            )
        });
        Ok(format!("{predicted} {found}{}", finer.unwrap_or_default()))
    }

    /// The sentence on an engine that cannot meet the target.
    fn unmet(&self, engines: Engines) -> String {
        let target = self.target();
        let least = nearest(engines, &self.measured, &self.quantities, &target);
        let least = least.map(|(index, [error, uncertainty])| {
            format!(
                "; the least biased is {}, whose systematic error is {} ± {}",
                self.measured[index].label,
                percent(error),
                percent(uncertainty)
            )
        });
        format!(
            "{}: no setting is sure to keep {} in {}{}.",
            engines.name(),
            percent(target.error),
            names(target.kinds),
            least.unwrap_or_default()
        )
    }
}

/// Measures the settings around a case, writes tables and the report, says the recommendations and tests them.
///
/// # Errors
/// [`FrontierError`] if an option or the case is refused, the reference cannot be had, or a file cannot be written.
pub fn command(
    arguments: &FrontierArguments,
    setups: &[Setup],
    say: impl Fn(&str) + Sync,
    note: impl Fn(&str) + Sync,
) -> Result<(), FrontierError> {
    let options = Options::new(arguments)?;
    let case = check(setups)?;
    let setup = Setup::new(&measured_case(&case.case))?;
    open(&options, arguments.force)?;
    let workshop = Workshop {
        setup: &setup,
        threads: options.threads,
        limit: PATIENCE * options.budget,
        spent: Mutex::new(0.0),
        tell: &note,
    };
    let cache = Cache::of(&setup, &options.cache);
    let sweep = Sweep::new(&options, &workshop, &cache)?;
    let references = &sweep.references.values;
    let rows = rows(&sweep.measured, &sweep.quantities, references, &Kind::ALL);
    table(&options.folder.join(TABLE), &rows)?;
    let orders = orders(&sweep.measured, &sweep.quantities, references);
    table(&options.folder.join(ORDERS), &orders)?;
    let mut sentences = sweep.provenance(&cache);
    sentences.extend(sweep.recommendations()?);
    sentences.push(format!(
        "Core time of everything: {}.",
        time(workshop.spent())
    ));
    for sentence in &sentences {
        say(&sentence.replace("**", ""));
    }
    let page = Page {
        title: &setup.case.title,
        rows: &rows,
        orders: &orders,
        sentences: &sentences,
        target: options.target,
    };
    let words = page::markdown(&page);
    write_whole(&options.folder.join(WORDS), words.as_bytes())?;
    let path = options.folder.join(PAGE);
    write_whole(&path, page::html(&page).as_bytes())?;
    say(&format!("report: {}", path.display()));
    Ok(())
}

fn names(kinds: &[Kind]) -> String {
    let names: Vec<_> = kinds.iter().map(|kind| kind.name()).collect();
    names.join(", ")
}
