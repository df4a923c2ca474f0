//! The page of one results folder.

use std::fmt::Write as _;
use std::path::Path;

use maud::{DOCTYPE, Markup, PreEscaped, html};
use serde_json::Value;

use super::figures::{
    self, Figure, engine_name, engines, number, same, window_name, windows, with_error,
};
use super::optional;
use super::plot::map::Map;
use super::plot::{Curve, Mark, Stroke};
use super::viewer::{self, Frames};
use super::{REPORT_FILE, ReportError, Results, SIZE_LIMIT, origin};
use crate::manifest::{Manifest, TimeDefinition, Units, Verdict, VerdictKind};
use crate::tables::{
    ComparisonRow, DissipationRow, EnergyRow, ImpactParameterRow, ImpactSummaryRow,
    PairCorrelationRow, ReplicaRow, Row, StructureFactorRow,
};

/// Style sheet of all pages.
const STYLE: &str = include_str!("style.css");
/// Tables with more rows than this are folded.
const LONG: usize = 24;
/// The study that the figures retell.
const STUDY: &str = "S. Luding, M. Müller and S. McNamara, The validity of “molecular chaos” in granular flows (1997)";

/// Builds the page of a results folder.
pub(crate) fn build(folder: &Path, results: &Results) -> Result<String, ReportError> {
    let mut counter = Counter::default();
    let before = html! {
        (head(&results.manifest.title))
        (summary(results))
        (plots(results, &mut counter))
    };
    let after = html! { (tables(results)) (provenance(&results.manifest)) };
    let used = before.0.len() + after.0.len() + STYLE.len() + viewer::SCRIPT.len() + 16_384;
    let frames = viewer::frames(folder, results, SIZE_LIMIT.saturating_sub(used))?;
    Ok(document(
        &results.manifest.title,
        &html! { (before) (snapshots(&frames, results, &mut counter)) (after) },
        (!frames.data.is_empty()).then_some(viewer::SCRIPT),
    ))
}

/// Numbers figures and tables through the page.
#[derive(Debug, Default)]
pub(crate) struct Counter {
    /// Figures so far.
    figures: usize,
    /// Panels so far.
    panels: usize,
}

/// A whole page around its content.
pub(crate) fn document(title: &str, content: &Markup, script: Option<&str>) -> String {
    let policy = "default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'";
    html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                meta http-equiv="Content-Security-Policy" content=(policy);
                title { (title) }
                style { (PreEscaped(STYLE)) }
            }
            body {
                main { (content) }
                @if let Some(script) = script { script { (PreEscaped(script)) } }
            }
        }
    }
    .into_string()
}

/// Title of the page.
fn head(title: &str) -> Markup {
    html! {
        h1 { (title) }
        nav {
            a href="#verdict" { "Verdict" }
            a href="#plots" { "Plots" }
            a href="#snapshots" { "Snapshots" }
            a href="#tables" { "Tables" }
            a href="#provenance" { "Case and provenance" }
        }
    }
}

/// A number that the manifest holds under `name`, among the derived quantities or anywhere in the case.
fn quantity(manifest: &Manifest, name: &str) -> Option<f64> {
    /// Searches a value and everything inside it.
    fn search(value: &Value, name: &str) -> Option<f64> {
        match value {
            Value::Object(map) => map
                .get(name)
                .and_then(Value::as_f64)
                .or_else(|| map.values().find_map(|inner| search(inner, name))),
            Value::Array(list) => list.iter().find_map(|inner| search(inner, name)),
            _ => None,
        }
    }
    manifest
        .derived
        .get(name)
        .copied()
        .or_else(|| search(&manifest.case, name))
}

/// What was run, in one sentence.
fn statement(results: &Results) -> String {
    let manifest = &results.manifest;
    let mut text = match quantity(manifest, "particles") {
        Some(count) => format!("A gas of N = {count:.0} hard disks"),
        None => "A gas of hard disks".to_owned(),
    };
    let mut properties = Vec::new();
    if let Some(value) = quantity(manifest, "packing_fraction") {
        properties.push(format!("packing fraction {}", number(value, 4)));
    }
    if let Some(value) = quantity(manifest, "restitution") {
        properties.push(format!("restitution coefficient {}", number(value, 4)));
    }
    if !properties.is_empty() {
        let _ = write!(text, " with {}", properties.join(" and "));
    }
    let last = results
        .energy
        .iter()
        .flatten()
        .map(|row| row.time_over_t0)
        .max_by(f64::total_cmp);
    let reference = match manifest.t0.definition {
        TimeDefinition::Haff => "Haff’s cooling time",
        TimeDefinition::MeanFreeTime => "the mean free time of the start",
    };
    let unit = match manifest.units {
        Units::Si => " s",
        Units::Reduced => " in units of the case",
    };
    text += " was followed";
    if let Some(last) = last {
        let _ = write!(text, " up to t/t₀ = {}", number(last, 4));
    }
    let _ = write!(
        text,
        ", where t₀ = {}{unit} is {reference}. ",
        number(manifest.t0.seconds_or_units, 4)
    );
    let names: Vec<String> = names(results)
        .iter()
        .map(|name| engine_name(name))
        .collect();
    let replicas = manifest.replicas;
    if replicas == 1 {
        text += "A single replica was run, so no standard errors can be given";
    } else {
        let _ = write!(
            text,
            "The standard errors come from {replicas} independent replicas"
        );
    }
    match names.as_slice() {
        [] => text.push('.'),
        [one] => {
            let _ = write!(text, "; the engine is {one}.");
        }
        several => {
            let _ = write!(
                text,
                "; in each of them the engines {} start from one and the same initial state.",
                list(several)
            );
        }
    }
    text
}

/// Items joined as in a sentence.
fn list(items: &[String]) -> String {
    match items {
        [] => String::new(),
        [one] => one.clone(),
        [first @ .., last] => format!("{} and {last}", first.join(", ")),
    }
}

/// The engines of the run.
fn names(results: &Results) -> Vec<String> {
    let listed = results.manifest.engines.iter().map(|work| &work.engine);
    engines(listed.chain(results.energy.iter().flatten().map(|row| &row.engine)))
}

/// Statement, verdicts and warnings.
fn summary(results: &Results) -> Markup {
    let manifest = &results.manifest;
    let unequal: Vec<String> = manifest
        .start
        .iter()
        .filter(|start| !start.equilibrated)
        .map(|start| start.replica.to_string())
        .collect();
    let urgent = manifest
        .verdicts
        .iter()
        .filter(|verdict| verdict.kind == VerdictKind::Warning);
    let urgent: Vec<_> = urgent.collect();
    html! {
        section id="verdict" {
            p.lead { (statement(results)) }
            @if manifest.verdicts.len() > urgent.len() {
                (verdict_list(&manifest.verdicts))
            } @else {
                p.absent { "The manifest of this run holds no verdict." }
            }
            @if !manifest.choices.is_empty() {
                p { "The resolution of the Monte Carlo engines was chosen by a pilot." }
                ul { @for choice in &manifest.choices { li { (choice) } } }
            }
            @if !(unequal.is_empty() && urgent.is_empty() && manifest.warnings.is_empty()) {
                div.warnings role="alert" {
                    strong { "Warnings" }
                    ul {
                        @if !unequal.is_empty() {
                            li {
                                strong { "The start was not in equilibrium" }
                                " in replica " (list(&unequal)) " of " (manifest.start.len())
                                ". The differences below may come from the start; see "
                                a href="#start" { "the tests of the start" } "."
                            }
                        }
                        @for verdict in &urgent {
                            li { strong { (verdict.topic) } ": " (verdict.sentence) }
                        }
                        @for warning in &manifest.warnings { li { (warning) } }
                    }
                }
            }
        }
    }
}

/// The verdicts that are not warnings.
pub(crate) fn verdict_list(verdicts: &[Verdict]) -> Markup {
    html! {
        ul.verdicts {
            @for verdict in verdicts.iter().filter(|v| v.kind != VerdictKind::Warning) {
                @let (class, word) = match verdict.kind {
                    VerdictKind::Agree => ("agree", "✓ agree"),
                    VerdictKind::Differ => ("differ", "≠ differ"),
                    VerdictKind::Undecided => ("undecided", "? undecided"),
                    VerdictKind::Warning => ("warning", "! warning"),
                };
                li {
                    span.kind.(class) { (word) }
                    span { strong { (verdict.topic) } ": " (verdict.sentence) }
                }
            }
        }
    }
}

/// A note in the place of a table that is missing or empty.
fn absent<R: Row>(rows: Option<&Vec<R>>) -> Markup {
    html! {
        @match rows {
            None => p.absent {
                "The file " code { (R::FILE) } " was not found in this folder. It is written by " (origin::<R>()) "."
            },
            Some(rows) if rows.is_empty() => p.absent {
                "The file " code { (R::FILE) } " holds no rows. They are written by " (origin::<R>()) "."
            },
            Some(_) => p.absent {
                "The file " code { (R::FILE) } " holds no value that could be drawn."
            },
        }
    }
}

/// All figures.
fn plots(results: &Results, counter: &mut Counter) -> Markup {
    let theory = results
        .manifest
        .derived
        .get("fourth_cumulant_theory")
        .copied();
    let theory = theory.filter(|value| value.is_finite());
    let energy = results.energy.as_ref();
    let summary = results.summary.as_deref().unwrap_or_default();
    html! {
        section id="plots" {
            h2 { "Energy" }
            div.pair {
                (figure(energy.and_then(|rows| figures::energy(rows, results.steady.as_deref())), counter)
                    .unwrap_or_else(|| absent::<EnergyRow>(energy)))
                (figure(results.comparison.as_ref().and_then(|rows| figures::quotient(rows)), counter)
                    .unwrap_or_else(|| absent::<ComparisonRow>(results.comparison.as_ref())))
            }
            @if let Some(rows) = &results.partial {
                h2 { "Species" }
                (figure(optional::partial_temperatures(rows), counter).unwrap_or_else(|| absent(Some(rows))))
                @if let Some(pairs) = &results.pair_impact {
                    (figure(optional::pair_impact(pairs), counter).unwrap_or_else(|| absent(Some(pairs))))
                }
            }
            @if let Some(rows) = &results.displacements {
                h2 { "Diffusion" }
                (figure(optional::displacement(rows), counter).unwrap_or_else(|| absent(Some(rows))))
            }
            h2 { "Impact parameter" }
            (figure(results.impact.as_ref().and_then(|rows| figures::impact(rows, summary)), counter)
                .unwrap_or_else(|| absent::<ImpactParameterRow>(results.impact.as_ref())))
            h2 { "Structure" }
            (figure(results.structure.as_ref().and_then(|rows| figures::structure(rows)), counter)
                .unwrap_or_else(|| absent::<StructureFactorRow>(results.structure.as_ref())))
            div.pair {
                div {
                    (figure(results.pair.as_ref().and_then(|rows| figures::pair(rows)), counter)
                        .unwrap_or_else(|| absent::<PairCorrelationRow>(results.pair.as_ref())))
                }
                div {
                    (figure(energy.and_then(|rows| figures::cumulant(rows, theory)), counter)
                        .unwrap_or_else(|| absent::<EnergyRow>(energy)))
                }
            }
        }
    }
}

/// One figure with its legend, panels and numbered caption.
pub(crate) fn figure(figure: Option<Figure>, counter: &mut Counter) -> Option<Markup> {
    let figure = figure?;
    counter.figures += 1;
    let (arrangement, columns) = match figure.panels.len() {
        1 => ("one", 1),
        3 => ("three", 3),
        _ => ("many", 2),
    };
    let legend = legend(&figure);
    Some(html! {
        figure {
            @if !legend.is_empty() {
                div.legend { @for curve in &legend { span { (swatch(curve)) (curve.label) } } }
            }
            div.panels.(arrangement) {
                @for (title, chart) in &figure.panels {
                    div {
                        @if !title.is_empty() { h4 { (title) } }
                        @let description = format!("{} {title}: {} against {}", figure.title, chart.y.label, chart.x.label);
                        (PreEscaped(chart.svg(next(&mut counter.panels), columns, &description)))
                    }
                }
            }
            figcaption { b { "Figure " (counter.figures) ". " (figure.title) "." } " " (figure.caption) }
        }
    })
}

/// One numbered figure of maps.
pub(crate) fn maps(
    title: &str,
    caption: &str,
    maps: &[(&str, Map)],
    counter: &mut Counter,
) -> Markup {
    counter.figures += 1;
    html! {
        figure {
            div.panels.(if maps.len() == 1 { "one" } else { "many" }) {
                @for (name, map) in maps {
                    div {
                        h4 { (name) }
                        (PreEscaped(map.svg(next(&mut counter.panels), &format!("{title}: {name}"))))
                    }
                }
            }
            figcaption { b { "Figure " (counter.figures) ". " (title) "." } " " (caption) }
        }
    }
}

/// Counts one further.
fn next(counter: &mut usize) -> usize {
    *counter += 1;
    *counter
}

/// One entry for each kind of curve in the panels.
fn legend(figure: &Figure) -> Vec<Curve> {
    let mut entries: Vec<Curve> = Vec::new();
    for curve in figure.panels.iter().flat_map(|(_, chart)| &chart.curves) {
        if !curve.points.is_empty() && !entries.iter().any(|entry| entry.label == curve.label) {
            entries.push(Curve {
                points: Vec::new(),
                ..curve.clone()
            });
        }
    }
    let level = figure.panels.iter().find_map(|(_, chart)| chart.level);
    if let Some(level) = level {
        entries.push(Curve {
            label: format!("{} = {}", figure.panels[0].1.y.label, number(level, 4)),
            colour: "var(--ink)".to_owned(),
            mark: None,
            stroke: Stroke::Dashed,
            points: Vec::new(),
        });
    }
    entries
}

/// The sample of a curve in a legend.
pub(crate) fn swatch(curve: &Curve) -> Markup {
    let width = if curve.stroke == Stroke::Thin {
        "1.2"
    } else {
        "2"
    };
    let dash = (curve.stroke == Stroke::Dashed).then_some("6 4");
    html! {
        svg viewBox="0 0 34 12" aria-hidden="true" style=(format!("color:{}", curve.colour)) fill="currentColor" {
            @if curve.stroke != Stroke::None {
                line x1="0" y1="6" x2="34" y2="6" stroke="currentColor" stroke-width=(width) stroke-dasharray=[dash] {}
            }
            @match curve.mark {
                Some(Mark::Circle) => circle cx="17" cy="6" r="4" {},
                Some(Mark::Square) => rect x="13.5" y="2.5" width="7" height="7" {},
                Some(Mark::Triangle) => path d="M17 1.5 21.5 10h-9z" {},
                Some(Mark::Diamond) => path d="M17 1l5 5-5 5-5-5z" {},
                Some(Mark::Inverted) => path d="M17 10.5 21.5 2h-9z" {},
                None => "",
            }
        }
    }
}

/// The snapshots and their viewer.
fn snapshots(frames: &Frames, results: &Results, counter: &mut Counter) -> Markup {
    let shown = frames.times.len();
    html! {
        section id="snapshots" {
            h2 { "Snapshots" }
            @for file in &frames.missing {
                p.absent { "The snapshot " code { (file) } " is named in the manifest but was not found in this folder." }
            }
            @if frames.data.is_empty() && results.manifest.snapshots.is_empty() {
                p.absent { "This run has no snapshots. They are written by a run that asks for snapshots at some of its sample times." }
            } @else if frames.data.is_empty() && frames.available > 0 {
                p.absent { "The snapshots were left out, because a page with a single time would exceed " (SIZE_LIMIT / 1_000_000) " MB. They are in the folder, in extended XYZ format." }
            }
            @if !frames.data.is_empty() {
                @let number = next(&mut counter.figures);
                figure {
                    div.controls {
                        @if shown > 1 {
                            label { "Time " input #viewer-time type="range" min="0" max=(shown - 1) step="1" value=(shown - 1); }
                        }
                        output #viewer-label {}
                        span { "Direction of the velocity:" }
                        span.compass title="Colour of each direction" {}
                        span.hint { "Drag: move. Wheel, after a click: zoom. Double click: whole domain." }
                    }
                    div #viewer {}
                    noscript { p.absent { "The disks are drawn by a script inside this page, and scripts are switched off." } }
                    figcaption {
                        b { "Figure " (number) ". Snapshots." }
                        " Disks of replica 0 at the same time in every engine, drawn to scale; the colour is the direction of the velocity. "
                        "Neighbours of one colour move together. Positions are rounded to 1/65536 of the side."
                        @if shown < frames.available {
                            " Shown are " (shown) " of " (frames.available) " times, so that the page stays below "
                            (SIZE_LIMIT / 1_000_000) " MB; all of them are in the folder."
                        }
                    }
                }
                script #frames type="application/json" { (PreEscaped(&frames.data)) }
            }
        }
    }
}

/// A column of a table on the page: its heading, and whether it holds text.
pub(crate) type Column = (&'static str, bool);

/// A table; a long one is folded.
pub(crate) fn table(name: &str, columns: &[Column], rows: &[Vec<String>]) -> Markup {
    let body = html! {
        div.scroll {
            table {
                thead { tr { @for (heading, text) in columns { th.text[*text] scope="col" { (heading) } } } }
                tbody {
                    @for row in rows {
                        tr {
                            @for (cell, (_, text)) in row.iter().zip(columns) {
                                td.text[*text].long[cell.chars().count() > 60] { (cell) }
                            }
                        }
                    }
                }
            }
        }
    };
    html! {
        @if rows.len() > LONG {
            details { summary { (name) ", " (rows.len()) " rows" } (body) }
        } @else { (body) }
    }
}

/// An optional number in a table.
fn cell(value: Option<f64>, digits: usize) -> String {
    value.map_or_else(|| "–".to_owned(), |value| number(value, digits))
}

/// The tables.
fn tables(results: &Results) -> Markup {
    let manifest = &results.manifest;
    html! {
        section id="tables" {
            h2 { "Tables" }
            h3 { "Comparison of the engines" }
            (comparison(results.comparison.as_ref()))
            h3 { "Impact parameter" }
            (impact_summary(results.summary.as_ref()))
            h3 { "Dissipation identity" }
            (dissipation(results.dissipation.as_ref()))
            @if let Some(rows) = &results.steady {
                h3 { "Steady state" }
                (optional::steady(rows))
            }
            @if let Some(rows) = &results.budget {
                h3 { "Error budget" }
                (optional::error_budget(rows))
            }
            h3 { "Spread of the replicas" }
            (replicas(results.replicas.as_ref()))
            h3 { "Work" }
            (work(manifest))
            h3 id="start" { "Tests of the start" }
            (start(manifest))
            h3 { "Derived quantities" }
            @let derived: Vec<Vec<String>> = manifest.derived.iter()
                .map(|(name, value)| vec![name.replace('_', " "), number(*value, 6)]).collect();
            @if derived.is_empty() {
                p.absent { "The manifest holds no derived quantities." }
            } @else {
                (table("Derived quantities", &[("quantity", true), ("value", false)], &derived))
            }
        }
    }
}

/// Table of the comparison; the last time of every pair stands before the folded rest.
fn comparison(rows: Option<&Vec<ComparisonRow>>) -> Markup {
    let Some(rows) = rows.filter(|rows| !rows.is_empty()) else {
        return absent(rows);
    };
    let columns: [Column; 8] = [
        ("a", true),
        ("b", true),
        ("t/t₀", false),
        ("K/K(0) of a", false),
        ("K/K(0) of b", false),
        ("quotient a/b", false),
        ("z", false),
        ("verdict", true),
    ];
    let line = |row: &ComparisonRow| {
        vec![
            engine_name(&row.engine_a),
            engine_name(&row.engine_b),
            number(row.time_over_t0, 4),
            number(row.energy_ratio_a, 4),
            number(row.energy_ratio_b, 4),
            with_error(Some(row.quotient), row.quotient_se),
            cell(row.z, 3),
            row.verdict.clone(),
        ]
    };
    let lines: Vec<Vec<String>> = rows.iter().map(line).collect();
    let mut last: Vec<&ComparisonRow> = Vec::new();
    for row in rows {
        match last
            .iter_mut()
            .find(|r| r.engine_a == row.engine_a && r.engine_b == row.engine_b)
        {
            Some(found) if found.time_over_t0 < row.time_over_t0 => *found = row,
            Some(_) => {}
            None => last.push(row),
        }
    }
    let last: Vec<Vec<String>> = last.into_iter().map(line).collect();
    html! {
        p { "The quotient of the energies with its standard error, and the normal-equivalent z of a paired t test over the replicas: few replicas make z smaller than the distance from one in standard errors."
            " The verdict takes all times together; agree means that no difference was found and one by a sixth would have been." }
        @if lines.len() > LONG {
            p { "At the last time:" }
            (table("Last time", &columns, &last))
        }
        (table("All times", &columns, &lines))
    }
}

/// Table of the impact parameter.
fn impact_summary(rows: Option<&Vec<ImpactSummaryRow>>) -> Markup {
    let Some(rows) = rows.filter(|rows| !rows.is_empty()) else {
        return absent(rows);
    };
    let lines: Vec<Vec<String>> = rows
        .iter()
        .map(|row| {
            let mut line = vec![
                engine_name(&row.engine),
                window_name((row.window_start, row.window_end)),
            ];
            line.extend(impact_cells(row));
            line
        })
        .collect();
    let mut columns: Vec<Column> = vec![("engine", true), ("window", true)];
    columns.extend(IMPACT_COLUMNS);
    html! {
        p { "A slope of zero and a mean of one half are molecular chaos; p is the probability of so large a χ² if P(b/d) is uniform." }
        (table("All windows", &columns, &lines))
    }
}

/// Columns of the summary of the impact parameter after those that name the row.
pub(crate) const IMPACT_COLUMNS: [Column; 6] = [
    ("collisions", false),
    ("slope of P(b/d)", false),
    ("mean b/d", false),
    ("χ² / degrees of freedom", false),
    ("p", false),
    ("verdict", true),
];

/// Cells for [`IMPACT_COLUMNS`].
pub(crate) fn impact_cells(row: &ImpactSummaryRow) -> Vec<String> {
    vec![
        row.collisions.to_string(),
        with_error(row.slope, row.slope_se),
        cell(row.mean_b_over_d, 4),
        format!("{} / {}", cell(row.chi_squared, 4), row.degrees_of_freedom),
        cell(row.p_value, 2),
        row.verdict.clone(),
    ]
}

/// Table of the dissipation identity.
fn dissipation(rows: Option<&Vec<DissipationRow>>) -> Markup {
    let Some(rows) = rows.filter(|rows| !rows.is_empty()) else {
        return absent(rows);
    };
    let lines: Vec<Vec<String>> = rows
        .iter()
        .map(|row| {
            vec![
                engine_name(&row.engine),
                window_name((row.window_start, row.window_end)),
                row.collisions.to_string(),
                with_error(row.dissipation_ratio, row.dissipation_ratio_se),
                with_error(row.rate_ratio, row.rate_ratio_se),
                with_error(row.speed_ratio, row.speed_ratio_se),
                with_error(row.impact_ratio, row.impact_ratio_se),
                with_error(row.correlation_ratio, row.correlation_ratio_se),
            ]
        })
        .collect();
    let columns = [
        ("engine", true),
        ("window", true),
        ("collisions", false),
        ("dissipation =", false),
        ("rate ×", false),
        ("speed ×", false),
        ("impact ×", false),
        ("correlation", false),
    ];
    html! {
        p {
            "The cooling rate over its value under molecular chaos (Enskog) is a product of four ratios: the collision rate, the "
            "mean squared relative speed of colliding pairs, the mean of 1 − b²/d² over two thirds, and what is left for the "
            "correlation of the last two. All are one in a homogeneous Maxwellian gas under molecular chaos. Clusters and shear change "
            "rate and speed without any correlation of colliding pairs, in Monte Carlo too; impact and correlation test chaos itself."
        }
        (table("All windows", &columns, &lines))
    }
}

/// Smallest and largest energy among the replicas at the last time.
fn replicas(rows: Option<&Vec<ReplicaRow>>) -> Markup {
    let Some(rows) = rows.filter(|rows| !rows.is_empty()) else {
        return absent(rows);
    };
    let mut lines = Vec::new();
    for name in engines(rows.iter().map(|row| &row.engine)) {
        let of_engine = || rows.iter().filter(|row| row.engine == name);
        let Some(last) = of_engine()
            .map(|row| row.time_over_t0)
            .max_by(f64::total_cmp)
        else {
            continue;
        };
        let at_end: Vec<&ReplicaRow> = of_engine()
            .filter(|row| same(row.time_over_t0, last))
            .collect();
        let energies = || {
            at_end
                .iter()
                .map(|row| row.energy_ratio)
                .filter(|value| value.is_finite())
        };
        let mean = |values: &dyn Fn(&ReplicaRow) -> f64| {
            at_end.iter().map(|row| values(row)).sum::<f64>() / at_end.len() as f64
        };
        lines.push(vec![
            engine_name(&name),
            number(last, 4),
            at_end.len().to_string(),
            cell(energies().min_by(f64::total_cmp), 4),
            number(mean(&|row| row.energy_ratio), 4),
            cell(energies().max_by(f64::total_cmp), 4),
            number(mean(&|row| row.collisions_per_particle), 4),
        ]);
    }
    let columns = [
        ("engine", true),
        ("t/t₀", false),
        ("replicas", false),
        ("smallest K/K(0)", false),
        ("mean", false),
        ("largest", false),
        ("collisions per particle", false),
    ];
    html! {
        p { "The energies of the single replicas at the last time; the samples are in " code { (ReplicaRow::FILE) } "." }
        (table("Replicas", &columns, &lines))
    }
}

/// A count, in full if it is whole.
fn count(value: f64) -> String {
    if value.fract() == 0.0 && value.abs() < 1e15 {
        format!("{value:.0}")
    } else {
        number(value, 6)
    }
}

/// Table of the work of each engine.
fn work(manifest: &Manifest) -> Markup {
    if manifest.engines.is_empty() {
        return html! { p.absent { "The manifest holds no work counts." } };
    }
    let mut rows = Vec::new();
    for engine in &manifest.engines {
        let name = engine_name(&engine.engine);
        let mut add = |what: &str, value: String| {
            rows.push(vec![name.clone(), what.to_owned(), value]);
        };
        add("seconds, all replicas", number(engine.wall_seconds, 4));
        add("collisions", engine.collisions.to_string());
        if engine.wall_seconds > 0.0 {
            add(
                "collisions per second",
                number(engine.collisions as f64 / engine.wall_seconds, 3),
            );
        }
        for (what, value) in &engine.work {
            add(&what.replace('_', " "), count(*value));
        }
    }
    html! {
        p { "The whole run took " (number(manifest.wall_seconds, 4)) " s on " (manifest.machine.cores) " cores." }
        (table("Work counts", &[("engine", true), ("quantity", true), ("value", false)], &rows))
    }
}

/// Table of the tests of the start.
fn start(manifest: &Manifest) -> Markup {
    let mut rows = Vec::new();
    for start in &manifest.start {
        for test in &start.tests {
            rows.push(vec![
                start.replica.to_string(),
                test.name.clone(),
                number(test.statistic, 4),
                cell(test.p_value, 3),
                match test.passed {
                    Some(true) => "yes",
                    Some(false) => "no",
                    None => "–",
                }
                .to_owned(),
                test.detail.clone(),
            ]);
        }
    }
    let columns = [
        ("replica", false),
        ("test", true),
        ("statistic", false),
        ("p", false),
        ("passed", true),
        ("detail", true),
    ];
    let passed = manifest
        .start
        .iter()
        .filter(|start| start.equilibrated)
        .count();
    html! {
        @if manifest.start.is_empty() {
            p.absent { "The manifest does not say how the replicas began." }
        } @else {
            @let first = &manifest.start[0];
            p {
                "Placement of replica " (first.replica) ": " (first.placement) ", then "
                (number(first.collisions_per_particle, 4)) " elastic collisions per particle. "
                (passed) " of " (manifest.start.len()) " replicas began in equilibrium."
            }
            @if !rows.is_empty() { (table("Tests of the start", &columns, &rows)) }
        }
    }
}

/// Case file, citation, versions and machine.
fn provenance(manifest: &Manifest) -> Markup {
    let program = &manifest.program;
    html! {
        section id="provenance" {
            h2 { "Case and provenance" }
            h3 { "Case file" }
            (case_file(&manifest.case_text))
            h3 { "How to cite" }
            p {
                "Name the program, its version and the seed, and publish the case file: “computed with "
                (program.name) " " (program.version) ", seed " (manifest.seed) "”. "
                "The comparison follows the study " (STUDY) "."
            }
            h3 { "Versions, seed and machine" }
            (table("Provenance", &[("what", true), ("value", true)], &[
                vec!["program".to_owned(), format!("{} {}", program.name, program.version)],
                vec!["manifest format".to_owned(), manifest.format.to_string()],
                vec!["seed".to_owned(), manifest.seed.to_string()],
                vec!["replicas".to_owned(), manifest.replicas.to_string()],
                vec!["processor".to_owned(), manifest.machine.processor.clone()],
                vec!["cores".to_owned(), manifest.machine.cores.to_string()],
                vec!["system".to_owned(), manifest.machine.system.clone()],
            ]))
        }
        footer {
            p { "This page is complete in itself: it loads nothing, and can be rebuilt from the tables of its folder, which stand beside " code { (REPORT_FILE) } "." }
        }
    }
}

/// A case file, folded when it is long.
pub(crate) fn case_file(text: &str) -> Markup {
    html! {
        @if text.lines().count() > 60 {
            details { summary { "Case file, " (text.lines().count()) " lines" } pre { (text) } }
        } @else { pre { (text) } }
    }
}

/// The last window of a summary of one engine.
pub(crate) fn last_window<'a>(
    rows: &'a [ImpactSummaryRow],
    engine: &str,
) -> Option<&'a ImpactSummaryRow> {
    let of_engine = || rows.iter().filter(|row| row.engine == engine);
    let last = *windows(of_engine().map(|row| (row.window_start, row.window_end))).last()?;
    of_engine().find(|row| same(row.window_start, last.0) && same(row.window_end, last.1))
}

/// A relative link to the report of a point; characters with a meaning in links are encoded.
pub(crate) fn link_to(folder: &str) -> String {
    let mut address = String::from("./");
    for byte in folder.replace('\\', "/").bytes() {
        if byte.is_ascii_alphanumeric() || b"-._~/".contains(&byte) {
            address.push(char::from(byte));
        } else {
            let _ = write!(address, "%{byte:02X}");
        }
    }
    format!("{}/{REPORT_FILE}", address.trim_end_matches('/'))
}
