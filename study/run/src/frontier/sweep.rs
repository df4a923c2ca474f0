//! Measurement of a whole frontier: reference, settings, Pareto front, orders, recommendations, and
//! their descriptions.

use std::fs;
use std::sync::Mutex;
use std::sync::atomic::AtomicU64;

use stosszahl_case::CaseFile;
use stosszahl_case::format::{PlacementSpec, VelocitiesSpec};
use stosszahl_results::{
    Figure, FigureAxis, PointMark, Table, TableCell, format_duration, format_percent,
};

use super::budget::{PATIENCE, TESTS, shared};
use super::front::{self, FrontierRow, MeasuredSetting, largest, rows};
use super::kept_runs::KeptRuns;
use super::measure::{Runner, Task, Workshop};
use super::orders::{self, OrderRow, OrderVerdict, orders};
use super::quantity::{FrontierQuantity, QuantityKind, measured as measured_case, quantities};
use super::recommend::{Choice, EngineGroup, SettingSearch};
use super::reference::{self, Cache, References};
use super::setting::{RunSetting, settings_around};
use super::{Frontier, FrontierError, FrontierOptions, WordTable};
use crate::check::Planned;
use crate::plan::CasePlan;

/// Plans a case for a frontier. Returns an error for sweeps, cases other than smooth disks in a
/// periodic box, and starts that give all replicas one state.
pub(super) fn check_frontier(file: &CaseFile) -> Result<CasePlan, FrontierError> {
    let refuse = |found: String, expected| Err(FrontierError::Case { found, expected });
    let [point] = &file.points[..] else {
        let found = format!("the case has a sweep of {} points", file.points.len());
        return refuse(found, "one point: fix the swept keys with --set");
    };
    let plan = Planned::new(file, point)?.plan;
    if !plan.is_disk_fluid() {
        let found = "the case has walls, spin, spheres or no positions";
        return refuse(found.into(), "smooth disks in a periodic box");
    }
    let one = plan.case.start.placement == PlacementSpec::File;
    if one && plan.case.start.velocities == VelocitiesSpec::FILE {
        let found = "positions and velocities of start.file give all replicas one start";
        let expected = "replicas with a spread: start.placement = \"disordered\" or start.velocities = \"maxwellian\"";
        return refuse(found.into(), expected);
    }
    Ok(CasePlan::new(&measured_case(&plan.case), &plan.folder)?)
}

/// Creates or opens the results folder and the reference folder of a frontier, before any run.
fn open(plan: &CasePlan, options: &FrontierOptions<'_>) -> Result<KeptRuns, FrontierError> {
    let kept = KeptRuns::open(plan, options)?;
    fs::create_dir_all(&options.cache).map_err(|source| FrontierError::Folder {
        path: options.cache.clone(),
        source,
    })?;
    Ok(kept)
}

/// Measurement of a frontier in progress.
struct Sweep<'a> {
    options: &'a FrontierOptions<'a>,
    workshop: &'a Workshop<'a>,
    quantities: Vec<FrontierQuantity>,
    references: References,
    measured: Vec<MeasuredSetting>,
    /// Settings that were not measured, each with the reason.
    left_out: Vec<(String, String)>,
}

impl<'a> Sweep<'a> {
    /// Finds the reference values and measures all settings that the budget allows.
    fn new(
        options: &'a FrontierOptions<'a>,
        workshop: &'a Workshop<'a>,
        cache: &Cache,
    ) -> Result<Self, FrontierError> {
        let plan = workshop.plan;
        let quantities = quantities(plan);
        let settings = settings_around(plan);
        let shares = shared(plan, &settings, options.budget);
        let references =
            reference::find_references(workshop, &quantities, shares.reference, cache)?;
        let (mut tasks, mut left_out) = (Vec::new(), Vec::new());
        for (setting, repetitions) in settings.into_iter().zip(shares.repetitions) {
            match repetitions {
                Some(repetitions) => tasks.push(Task {
                    setting,
                    replicas: 0..repetitions,
                }),
                None => left_out.push((setting.label(plan), "too costly for the budget".into())),
            }
        }
        let (outcomes, mut measured) = (workshop.run(&tasks)?, Vec::new());
        for (Task { setting, .. }, outcome) in tasks.into_iter().zip(outcomes) {
            match outcome {
                Ok(samples) => measured.push(MeasuredSetting::new(
                    setting,
                    plan,
                    &samples,
                    &quantities,
                    &references.values,
                )),
                Err(reason) => left_out.push((RunSetting::label(&setting, plan), reason)),
            }
        }
        Ok(Self {
            options,
            workshop,
            quantities,
            references,
            measured,
            left_out,
        })
    }

    fn search(&self) -> SettingSearch<'_> {
        SettingSearch {
            measured: &self.measured,
            quantities: &self.quantities,
            references: &self.references.values,
            error: self.options.target,
            kinds: &self.options.kinds,
            disks: self.workshop.plan.count(),
        }
    }

    /// Describes the measurement of the frontier and its reference.
    fn provenance(&self, cache: &Cache) -> String {
        let plan = self.workshop.plan;
        let of = format!(
            "{} settings of {} disks at packing {}, restitution {}, up to t = {} in the unit of time of the case.",
            self.measured.len(),
            plan.count(),
            plan.gas.packing_fraction,
            plan.gas.restitution,
            plan.case.run.until
        );
        let against = if self.references.runs == 0 {
            "Reference: theory, which is exact here.".to_owned()
        } else {
            format!(
                "Reference: {} runs of exact dynamics ({} made now), seed {}, version {}, fingerprint {}, kept as {}.",
                self.references.runs,
                self.references.made,
                plan.case.seed,
                env!("CARGO_PKG_VERSION"),
                cache.fingerprint(),
                cache.path.file_name().unwrap_or_default().display()
            )
        };
        format!("{of} {against}")
    }

    /// Describes which of the recommended settings meets the target at the least CPU time.
    fn headline(&self, choices: &[Option<Choice>]) -> String {
        let target = format!(
            "{} in {}",
            format_percent(self.options.target),
            names(&self.options.kinds)
        );
        let mut found: Vec<&Choice> = choices.iter().flatten().collect();
        found.sort_by(|a, b| a.core_seconds.total_cmp(&b.core_seconds));
        let words = |choice: &Choice| {
            format!(
                "{}, {} of it in {} of core time",
                self.measured[choice.index].label,
                replicas(choice.replicas),
                format_duration(choice.core_seconds)
            )
        };
        match found[..] {
            [] => format!("No setting is sure to keep {target}."),
            [only] => format!("Only one engine keeps {target}: {}.", words(only)),
            [least, next, ..] => format!(
                "{target} costs least by {}; the next engine takes {}.",
                words(least),
                words(next)
            ),
        }
    }

    /// Tests the recommended setting of each class of engines, and describes the outcome.
    fn recommendations(&self, choices: [Option<Choice>; 2]) -> Result<Vec<String>, FrontierError> {
        // Time is kept for tests of what there is to test.
        let count = choices.iter().flatten().count().max(1);
        let share = TESTS * self.options.budget / count as f64;
        let said = EngineGroup::ALL.into_iter().zip(choices);
        said.map(|(engines, choice)| match choice {
            Some(choice) => self.recommendation(engines, &choice, share),
            None => Ok(self.describe_unmet_target(engines)),
        })
        .collect()
    }

    /// Tests a recommended setting, and describes the prediction and the outcome.
    fn recommendation(
        &self,
        engines: EngineGroup,
        choice: &Choice,
        share: f64,
    ) -> Result<String, FrontierError> {
        let (search, tests) = (self.search(), self.options.tests);
        let tested = search.test(self.workshop, choice, tests, share)?;
        let one = &self.measured[choice.index];
        let wanted = format_percent(search.error);
        let predicted = format!(
            "{}: for {wanted} in {}, the cheapest setting is {} with {}: predicted {} of core time, {:.1} MiB and an error of {}.",
            engines.name(),
            names(search.kinds),
            one.label,
            replicas(choice.replicas),
            format_duration(choice.core_seconds),
            one.bytes as f64 / f64::from(1 << 20),
            format_percent(choice.error),
        );
        let found = format!(
            "On fresh seeds {} of {} tests were within {wanted}; found {} of core time and an error of {}.",
            tested.kept,
            tested.tests,
            format_duration(tested.core_seconds),
            format_percent(tested.error),
        );
        let finer = search.finer_that_fails(choice).map(|(finer, error)| {
            format!(
                " Its errors cancel: the finer {} is off by {}, so this holds for this case alone.",
                finer.label,
                format_percent(error)
            )
        });
        Ok(format!("{predicted} {found}{}", finer.unwrap_or_default()))
    }

    /// Describes why no setting of a class of engines meets the target.
    fn describe_unmet_target(&self, engines: EngineGroup) -> String {
        let search = self.search();
        let least = search.nearest(engines).map(|(one, errors)| {
            let error = errors.map(format_percent).join(" ± ");
            format!(
                "; the least biased is {}, whose systematic error is {error}",
                one.label
            )
        });
        format!(
            "{}: no setting is sure to keep {} in {}{}.",
            engines.name(),
            format_percent(search.error),
            names(search.kinds),
            least.unwrap_or_default()
        )
    }
}

fn names(kinds: &[QuantityKind]) -> String {
    let names: Vec<_> = kinds.iter().map(|kind| kind.title()).collect();
    names.join(", ")
}

fn replicas(count: u64) -> String {
    let ending = if count == 1 { "" } else { "s" };
    format!("{count} replica{ending}")
}

/// Measures the frontier of a case; returns its results, and the tables `frontier.csv` and
/// `orders.csv`.
pub(crate) fn sweep(
    file: &CaseFile,
    options: &FrontierOptions<'_>,
) -> Result<(Frontier, [Table; 2]), FrontierError> {
    let plan = check_frontier(file)?;
    let kept = open(&plan, options)?;
    let workshop = Workshop {
        kept: &kept,
        groups: AtomicU64::new(0),
        plan: &plan,
        runner: Runner::new(&plan, options.threads, options.interrupt)?,
        limit: PATIENCE * options.budget,
        spent: Mutex::new(0.0),
        tell: options.tell,
    };
    let cache = Cache::ensemble_file(&plan, &options.cache);
    let sweep = Sweep::new(options, &workshop, &cache)?;
    let references = &sweep.references.values;
    let rows = rows(&sweep.measured, &sweep.quantities, references);
    let orders = orders(&sweep.measured, &sweep.quantities, references);
    let choices = EngineGroup::ALL.map(|engines| sweep.search().choose(engines));
    let headline = sweep.headline(&choices);
    let mut conclusions = sweep.recommendations(choices)?;
    conclusions.push(format!(
        "Core time of everything: {}.",
        format_duration(workshop.spent())
    ));
    let left_out = sweep.left_out.iter();
    let left_out = left_out.map(|(label, reason)| format!("{label}: {reason}."));
    let mut lists: Vec<WordTable> = QuantityKind::ALL
        .into_iter()
        .map(|kind| front_list(&rows, kind))
        .collect();
    lists.push(order_list(&orders));
    let found = Frontier {
        title: plan.case.title.clone(),
        headline,
        conclusions,
        provenance: sweep.provenance(&cache),
        left_out: left_out.collect(),
        figure: figure(&rows, options.target),
        lists,
        held: kept.folder().clone(),
        is_reporter: kept.is_reporter()?,
    };
    Ok((found, [front::table(&rows), orders::table(&orders)]))
}

/// Builds the table of the largest errors against CPU time: single runs of each engine, and the
/// Pareto front over all numbers of replicas.
fn figure(rows: &[FrontierRow<'_>], target: f64) -> Table {
    const FRONT: &str = "front, with replicas";
    const ERROR_OF: &str = "error_of";
    let shown = |row: &&FrontierRow<'_>| row.name.starts_with("largest-");
    let single = rows.iter().filter(shown).filter(|row| row.replicas == 1);
    let front = rows.iter().filter(shown).filter(|row| row.on_front);
    let count = front.clone().count();
    let rows: Vec<&FrontierRow<'_>> = single.chain(front).collect();
    let mut table = front::table(rows.iter().copied());
    let first = table.rows.len() - count;
    for row in &mut table.rows[first..] {
        row[0] = TableCell::Text(FRONT.to_owned());
    }
    // Panels are named by words.
    if let Some(column) = table.find_column("quantity") {
        table.columns[column].name = ERROR_OF.into();
        for (cells, row) in table.rows.iter_mut().zip(rows) {
            cells[column] = TableCell::Text(row.quantity.kind.title().to_owned());
        }
    }
    let figure = Figure::curves(
        "Error against core time",
        FigureAxis::logarithmic("core_seconds", "core time [s]"),
        FigureAxis::logarithmic("error", "error"),
    );
    let figure = figure.mark(PointMark::Points).panels(&[ERROR_OF]).line("target", target).caption(
        "Marks are single runs of each setting, and the front of all settings with 1, 4, 16 and 64 replicas. Dashed: the \
         target. Of several times, the one with the largest error counts.",
    );
    table.figure(figure)
}

const FRONT: &[(&str, bool)] = &[
    ("number", false),
    ("setting", true),
    ("replicas", false),
    ("core time", false),
    ("error", false),
    ("systematic", false),
    ("statistical, one run", false),
];

/// Returns the Pareto front of one kind of quantity as a list, by cost.
fn front_list(rows: &[FrontierRow<'_>], kind: QuantityKind) -> WordTable {
    let name = largest(kind);
    let mut front: Vec<&FrontierRow<'_>> = rows
        .iter()
        .filter(|row| row.on_front && row.name == name)
        .collect();
    front.sort_by(|a, b| a.core_seconds().total_cmp(&b.core_seconds()));
    let cells = |(row, place): (&&FrontierRow<'_>, u32)| {
        let [low, high] = row.found.total_range(row.replicas).map(format_percent);
        let bias = [row.found.systematic, row.found.systematic_error].map(format_percent);
        vec![
            place.to_string(),
            row.one.label.clone(),
            row.replicas.to_string(),
            format_duration(row.core_seconds()),
            format!("{} ({low} to {high})", format_percent(row.error())),
            bias.join(" ± "),
            format_percent(row.found.statistical),
        ]
    };
    WordTable {
        title: format!("Front: {}", kind.title()),
        columns: FRONT,
        rows: front.iter().zip(1..).map(cells).collect(),
    }
}

const ORDERS: &[(&str, bool)] = &[
    ("sequence", true),
    ("settings", false),
    ("quantity", true),
    ("time", false),
    ("order by theory", false),
    ("order found", false),
    ("limit less reference", false),
    ("verdict", true),
];

fn order_list(orders: &[OrderRow]) -> WordTable {
    let count = |verdict| orders.iter().filter(|row| row.verdict == verdict).count();
    let cells = |row: &OrderRow| {
        let found = row.found.map_or("-".to_owned(), |(order, [low, high])| {
            format!("{order:.1} ({low:.1} to {high:.1})")
        });
        let limit = [row.line.intercept, row.line.intercept_error].map(format_percent);
        vec![
            row.sequence.to_owned(),
            format!("{}, h ≤ {}", row.settings, row.coarsest),
            row.quantity.kind.name().to_owned(),
            format!("{:.3}", row.quantity.time),
            row.order.to_string(),
            found,
            limit.join(" ± "),
            row.verdict.name().to_owned(),
        ]
    };
    WordTable {
        title: format!(
            "Orders: of {} sequences and quantities, the order of theory holds in {}, does not hold in {}, and in {} no error \
             is seen",
            orders.len(),
            count(OrderVerdict::Holds),
            count(OrderVerdict::DoesNotHold),
            count(OrderVerdict::NotSeen),
        ),
        columns: ORDERS,
        rows: orders.iter().map(cells).collect(),
    }
}

/// Formats the recommendations and the lists of a frontier as Markdown.
pub(crate) fn markdown(found: &Frontier) -> String {
    let line = |cells: Vec<&str>| format!("| {} |\n", cells.join(" | "));
    let mut text = format!("# Speed against error: {}\n\n", found.title);
    for sentence in [&found.headline].into_iter().chain(&found.conclusions) {
        text += &[sentence, "\n\n"].concat();
    }
    text += &[&found.provenance, "\n\n"].concat();
    for left_out in &found.left_out {
        text += &["- Left out: ", left_out, "\n"].concat();
    }
    text += "\n";
    for list in found.lists.iter().filter(|list| !list.rows.is_empty()) {
        text += &["## ", &list.title, "\n\n"].concat();
        text += &line(list.columns.iter().map(|column| column.0).collect());
        text += &line(list.columns.iter().map(|_| "---").collect());
        for row in &list.rows {
            text += &line(row.iter().map(String::as_str).collect());
        }
        text += "\n";
    }
    text
}
