//! The page of a sweep: the points overlaid, and the trend with the swept key.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::Path;

use maud::{Markup, html};
use serde_json::Value;

use super::figures::{
    Figure, engine_colour, engine_mark, engine_name, engines, impact_points, number, shade, spread,
    window_name, windows, with_error,
};
use super::page::{self, Counter, IMPACT_COLUMNS, impact_cells, last_window};
use super::plot::{Axis, Chart, Curve, Mark, Point, Stroke};
use super::{REPORT_FILE, ReportError, Results, read, write_whole};
use crate::manifest::{MANIFEST_FILE, SWEEP_FILE, Sweep, SweepPoint};

/// A point of the sweep with its results, if it is finished.
struct Finished<'a> {
    /// The point.
    point: &'a SweepPoint,
    /// Its results.
    results: Option<Results>,
}

/// Points that share all keys but one.
struct Block {
    /// The key that differs.
    key: String,
    /// Keys that the points share.
    shared: BTreeMap<String, Value>,
    /// Places of the points in the sweep, by the value of the key.
    members: Vec<usize>,
}

/// Builds the page of a sweep and rewrites the reports of its finished points.
pub(crate) fn build(folder: &Path) -> Result<String, ReportError> {
    let sweep: Sweep = read::json(&folder.join(SWEEP_FILE))?;
    let mut points = Vec::new();
    for point in &sweep.points {
        let inside = folder.join(&point.folder);
        let results = if inside.join(MANIFEST_FILE).exists() {
            let results = Results::read(&inside)?;
            write_whole(&inside.join(REPORT_FILE), &page::build(&inside, &results)?)?;
            Some(results)
        } else {
            None
        };
        points.push(Finished { point, results });
    }
    let finished = points
        .iter()
        .filter(|point| point.results.is_some())
        .count();
    let mut counter = Counter::default();
    let content = html! {
        h1 { (sweep.title) }
        p.lead {
            "A sweep of " (points.len()) " points, of which " (finished) " are finished. Every point has a report of its own."
        }
        @let unequal: Vec<&str> = points.iter().filter(|point| {
            point.results.iter().any(|r| r.manifest.start.iter().any(|start| !start.equilibrated))
        }).map(|point| point.point.name.as_str()).collect();
        @if !unequal.is_empty() {
            div.warnings role="alert" {
                strong { "The start was not in equilibrium" } " in some replica of: " (unequal.join(", ")) "."
            }
        }
        h2 { "Points" }
        (overview(&points))
        @for block in blocks(&sweep.points) { (section(&block, &points, &mut counter)) }
        h2 { "Impact parameter of all points" }
        (summaries(&points))
        h2 { "Case file" }
        (page::case_file(&sweep.case_text))
    };
    Ok(page::document(&sweep.title, &content, None))
}

/// A value of a key as text.
fn text(value: &Value) -> String {
    match value {
        Value::String(text) => text.clone(),
        Value::Number(value) => value
            .as_f64()
            .map_or(value.to_string(), |value| number(value, 5)),
        other => other.to_string(),
    }
}

/// The blocks of a sweep, one for each key and each choice of the other keys. How long a point runs (`run.*`) and the shape of its box (`box.*`) go along
/// with what it is and makes no blocks.
fn blocks(points: &[SweepPoint]) -> Vec<Block> {
    let physical = |key: &String| !key.starts_with("run.") && !key.starts_with("box.");
    let mut keys: Vec<&String> = points
        .iter()
        .flat_map(|point| point.values.keys())
        .filter(|key| physical(key))
        .collect();
    keys.sort();
    keys.dedup();
    let mut blocks: Vec<Block> = Vec::new();
    for key in keys {
        for (place, point) in points.iter().enumerate() {
            if !point.values.contains_key(key) {
                continue;
            }
            let mut shared = point.values.clone();
            shared.retain(|other, _| other != key && physical(other));
            match blocks
                .iter_mut()
                .find(|block| block.key == *key && block.shared == shared)
            {
                Some(block) => block.members.push(place),
                None => blocks.push(Block {
                    key: key.clone(),
                    shared,
                    members: vec![place],
                }),
            }
        }
    }
    blocks.retain(|block| {
        block.members.iter().any(|place| {
            points[*place].values[&block.key] != points[block.members[0]].values[&block.key]
        })
    });
    for block in &mut blocks {
        let value = |place: &usize| {
            points[*place].values[&block.key]
                .as_f64()
                .unwrap_or(f64::INFINITY)
        };
        block.members.sort_by(|a, b| value(a).total_cmp(&value(b)));
    }
    blocks
}

/// List of the points with their values and links.
fn overview(points: &[Finished<'_>]) -> Markup {
    let mut keys: Vec<&String> = points
        .iter()
        .flat_map(|point| point.point.values.keys())
        .collect();
    keys.sort();
    keys.dedup();
    html! {
        div.scroll {
            table {
                thead { tr {
                    th.text scope="col" { "point" }
                    @for key in &keys { th scope="col" { (key) } }
                    th.text scope="col" { "verdict" }
                } }
                tbody {
                    @for point in points {
                        tr {
                            td.text {
                                @if point.results.is_some() {
                                    a href=(page::link_to(&point.point.folder)) { (point.point.name) }
                                } @else { (point.point.name) }
                            }
                            @for key in &keys {
                                td { (point.point.values.get(*key).map_or("–".to_owned(), text)) }
                            }
                            td.text.long {
                                @match &point.results {
                                    Some(results) => (summary(&results.manifest)),
                                    None => { "not finished: " code { (MANIFEST_FILE) } " was not found in " code { (point.point.folder) } },
                                }
                            }
                        }
                    }
                }
            }
        }
    }
}

/// The verdict that tells points apart: on impact parameters where one engine ran alone, else the first.
fn summary(manifest: &crate::manifest::Manifest) -> &str {
    let verdicts = &manifest.verdicts;
    let alone = manifest.engines.len() == 1;
    let impact = verdicts
        .iter()
        .find(|verdict| alone && verdict.topic.starts_with("impact parameters"));
    impact
        .or(verdicts.first())
        .map_or("–", |verdict| verdict.sentence.as_str())
}

/// The figures of one block.
fn section(block: &Block, points: &[Finished<'_>], counter: &mut Counter) -> Markup {
    let fixed: Vec<String> = block
        .shared
        .iter()
        .map(|(key, value)| format!("{key} = {}", text(value)))
        .collect();
    let overlay = page::figure(overlay(block, points), counter);
    let trend = page::figure(trend(block, points), counter);
    html! {
        h2 { "Sweep of " (block.key) @if !fixed.is_empty() { " at " (fixed.join(", ")) } }
        @if overlay.is_none() && trend.is_none() {
            p.absent {
                "No point of this block has " code { "impact_parameter.csv" } " or " code { "impact_parameter_summary.csv" }
                ". They are written by runs that measure the impact parameter in at least one time window."
            }
        } @else {
            div.pair { @if let Some(figure) = overlay { (figure) } @if let Some(figure) = trend { (figure) } }
        }
    }
}

/// The distribution of the impact parameter of every point in its last window.
fn overlay(block: &Block, points: &[Finished<'_>]) -> Option<Figure> {
    let rows = |place: usize| {
        points[place]
            .results
            .as_ref()
            .and_then(|results| results.impact.as_ref())
    };
    let members: Vec<usize> = block
        .members
        .iter()
        .copied()
        .filter(|place| rows(*place).is_some())
        .collect();
    let all = members.iter().filter_map(|place| rows(*place)).flatten();
    let engine = engines(all.map(|row| &row.engine)).first()?.clone();
    let shown = spread(&members, 7);
    let mut curves = Vec::new();
    for (order, place) in shown.iter().enumerate() {
        let rows = rows(*place)?;
        let of_engine = rows.iter().filter(|row| row.engine == engine);
        let all = windows(of_engine.map(|row| (row.window_start, row.window_end)));
        let Some(window) = all.last() else { continue };
        let value = text(&points[*place].point.values[&block.key]);
        curves.push(Curve {
            label: format!("{} = {value}, {}", block.key, window_name(*window)),
            colour: shade(order, shown.len()),
            mark: Some(Mark::ALL[order % Mark::ALL.len()]),
            stroke: Stroke::Thin,
            points: impact_points(rows, &engine, *window),
        });
    }
    let mut caption = format!(
        "Distribution of the impact parameter of {} in the last time window of every point, with standard errors. The \
         dashed line at one is molecular chaos.",
        engine_name(&engine)
    );
    if shown.len() < members.len() {
        let _ = write!(
            caption,
            " Drawn are {} of {} points.",
            shown.len(),
            members.len()
        );
    }
    let chart = Chart {
        x: Axis::linear("b / d").over(0.0, 1.0),
        y: Axis::linear("P(b/d)"),
        curves,
        level: Some(1.0),
    };
    (!chart.is_empty()).then(|| Figure {
        title: format!("Impact parameter against {}", block.key),
        panels: vec![(String::new(), chart)],
        caption,
    })
}

/// Slope of the distribution against the swept key.
fn trend(block: &Block, points: &[Finished<'_>]) -> Option<Figure> {
    let values: Vec<&Value> = block
        .members
        .iter()
        .map(|place| &points[*place].point.values[&block.key])
        .collect();
    let numeric = values.iter().all(|value| value.as_f64().is_some());
    let summary = |place: usize| {
        points[place]
            .results
            .as_ref()
            .and_then(|results| results.summary.as_deref())
    };
    let rows = block
        .members
        .iter()
        .filter_map(|place| summary(*place))
        .flatten();
    let mut curves = Vec::new();
    let mut notes = Vec::new();
    for engine in engines(rows.map(|row| &row.engine)) {
        let mut dots = Vec::new();
        for (order, place) in block.members.iter().enumerate() {
            let Some(row) = summary(*place).and_then(|rows| last_window(rows, &engine)) else {
                continue;
            };
            let x = values[order]
                .as_f64()
                .filter(|_| numeric)
                .unwrap_or(order as f64 + 1.0);
            if let Some(y) = row.slope.filter(|slope| slope.is_finite()) {
                dots.push((
                    Point {
                        x,
                        y,
                        error: row.slope_se,
                    },
                    text(values[order]),
                ));
            }
        }
        if let Some((point, value)) = dots
            .iter()
            .max_by(|a, b| a.0.y.abs().total_cmp(&b.0.y.abs()))
        {
            notes.push(format!(
                "{} {} at {} = {value}",
                engine_name(&engine),
                with_error(Some(point.y), point.error),
                block.key
            ));
        }
        curves.push(Curve {
            label: engine_name(&engine),
            colour: engine_colour(&engine),
            mark: Some(engine_mark(&engine)),
            stroke: Stroke::Thin,
            points: dots.into_iter().map(|(point, _)| point).collect(),
        });
    }
    let mut x = Axis::linear(&block.key);
    if !numeric {
        x.names = values.iter().map(|value| text(value)).collect();
    }
    let chart = Chart {
        x,
        y: Axis::linear("slope of P(b/d)"),
        curves,
        level: Some(0.0),
    };
    (!chart.is_empty()).then(|| Figure {
        title: format!("Slope against {}", block.key),
        panels: vec![(String::new(), chart)],
        caption: format!(
            "Slope of P(b/d) in the last time window against {}, with standard errors. Above the dashed line at zero, \
             grazing collisions prevail. Largest: {}.",
            block.key,
            notes.join(", ")
        ),
    })
}

/// One table of the summaries of all points.
fn summaries(points: &[Finished<'_>]) -> Markup {
    let mut rows = Vec::new();
    for point in points {
        for row in point
            .results
            .iter()
            .filter_map(|results| results.summary.as_ref())
            .flatten()
        {
            let mut line = vec![
                point.point.name.clone(),
                engine_name(&row.engine),
                window_name((row.window_start, row.window_end)),
            ];
            line.extend(impact_cells(row));
            rows.push(line);
        }
    }
    let mut columns = vec![("point", true), ("engine", true), ("window", true)];
    columns.extend(IMPACT_COLUMNS);
    html! {
        @if rows.is_empty() {
            p.absent { "No finished point has " code { "impact_parameter_summary.csv" } "." }
        } @else { (page::table("All summaries", &columns, &rows)) }
    }
}
