//! The page of a sweep: a list of the points, each figure at all points, and trends with the swept key.

use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::path::Path;

use maud::{Markup, html};
use serde_json::Value;
use stosszahl_results::{
    Axis, Cell, Column, Figure, MANIFEST_FILE, Mark, REPORT_FILE, Role, Scale, Stored, Sweep, Table,
};

use crate::figure::draw;
use crate::page;
use crate::words::number;
use crate::{Report, ReportError, run};

/// Name of the column that says which point a row is of.
const POINT: &str = "point";

/// Builds the page of a sweep and rewrites the reports of its finished points.
pub(crate) fn build(folder: &Path, sweep: &Sweep) -> Result<Report, ReportError> {
    let mut points = Vec::new();
    for point in &sweep.points {
        let inside = folder.join(&point.name);
        let stored = Stored::read(&inside)?;
        if let Some(stored) = &stored {
            run::build(&inside, stored)?.write(&inside)?;
        }
        points.push(stored);
    }
    let finished = points.iter().flatten().count();
    let keys: BTreeSet<&String> = sweep
        .points
        .iter()
        .flat_map(|point| point.values.keys())
        .collect();
    let keys: Vec<&String> = keys.into_iter().collect();
    let mut count = 0;
    let content = html! {
        h1 { (sweep.title) }
        p.lead { "A sweep of " (sweep.points.len()) " points, of which " (finished) " are finished. Each point has a report of its own." }
        (overview(sweep, &points, &keys))
        @for (table, figure) in common(&points) { (over_points(sweep, &points, &keys, (table, figure), &mut count)) }
        (page::case_file(&sweep.case_text))
    };
    Ok(Report {
        page: page::document(&sweep.title, &content, None),
        drawings: Vec::new(),
    })
}

/// The tables and figures of the first finished point.
fn common(points: &[Option<Stored>]) -> Vec<(&Table, &Figure)> {
    let tables = points
        .iter()
        .flatten()
        .next()
        .map_or(&[][..], |stored| &stored.tables);
    tables
        .iter()
        .flat_map(|table| table.figures.iter().map(move |figure| (table, figure)))
        .collect()
}

fn text(value: Option<&Value>) -> String {
    match value {
        None => "–".to_owned(),
        Some(Value::String(text)) => text.clone(),
        Some(Value::Number(value)) => value
            .as_f64()
            .map_or(value.to_string(), |value| number(value, 5)),
        Some(other) => other.to_string(),
    }
}

/// List of the points with their values, first verdicts and links.
fn overview(sweep: &Sweep, points: &[Option<Stored>], keys: &[&String]) -> Markup {
    html! {
        h2 { "Points" }
        div.scroll { table {
            thead { tr {
                th.text scope="col" { "point" }
                @for key in keys { th scope="col" { (key) } }
                th.text scope="col" { "verdict" }
            } }
            tbody { @for (point, stored) in sweep.points.iter().zip(points) { tr {
                td.text { @if stored.is_some() { a href=(link(&point.name)) { (point.name) } } @else { (point.name) } }
                @for key in keys { td { (text(point.values.get(*key))) } }
                td.text.long {
                    @match stored.as_ref().map(|stored| stored.manifest.verdicts.first()) {
                        Some(Some(verdict)) => { (page::kind(verdict.kind)) " " (verdict.topic) ": " (verdict.sentence) }
                        Some(None) => "–",
                        None => { "not finished: no " code { (MANIFEST_FILE) } }
                    }
                }
            } } }
        } }
    }
}

/// A relative link to the report of a point; characters with a meaning in links are encoded.
fn link(name: &str) -> String {
    let mut address = String::from("./");
    for byte in name.bytes() {
        if byte.is_ascii_alphanumeric() || b"-._~/".contains(&byte) {
            address.push(char::from(byte));
        } else {
            // Writing to a string cannot fail.
            let _ = write!(address, "%{byte:02X}");
        }
    }
    address + "/" + REPORT_FILE
}

/// The rows of a table at all points, of which only those of the last panel of a figure.
fn gather(
    sweep: &Sweep,
    points: &[Option<Stored>],
    keys: &[&String],
    (like, figure): (&Table, &Figure),
) -> Table {
    let column = |name: String, unit: &'static str| Column {
        name: name.into(),
        unit: unit.into(),
        meaning: "".into(),
        role: Role::Key,
    };
    let mut columns = vec![column(POINT.into(), "")];
    columns.extend(keys.iter().map(|key| column((*key).clone(), "1")));
    columns.extend(like.columns.iter().cloned());
    let mut all = Table {
        columns,
        rows: vec![],
        figures: vec![],
        ..like.clone()
    };
    let panels: Vec<usize> = figure
        .panels
        .iter()
        .filter_map(|name| like.find(name))
        .collect();
    for (point, stored) in sweep.points.iter().zip(points) {
        let tables = stored.iter().flat_map(|stored| &stored.tables);
        for table in tables.filter(|table| table.name == like.name && table.columns == like.columns)
        {
            let last = table.rows.last();
            let of_last = |row: &&Vec<Cell>| {
                last.is_some_and(|last| {
                    panels.iter().all(|panel| {
                        table.columns[*panel].name.starts_with("engine")
                            || row[*panel] == last[*panel]
                    })
                })
            };
            for row in table.rows.iter().filter(of_last) {
                let mut cells = vec![Cell::Text(point.name.clone())];
                cells.extend(keys.iter().map(|key| match point.values.get(*key) {
                    Some(Value::Number(value)) => value.as_f64().map_or(Cell::Empty, Cell::Number),
                    other => Cell::Text(text(other)),
                }));
                cells.extend(row.iter().cloned());
                all.rows.push(cells);
            }
        }
    }
    all
}

/// One figure at all points side by side, and, for what is measured against time, its last value against the swept keys.
fn over_points(
    sweep: &Sweep,
    points: &[Option<Stored>],
    keys: &[&String],
    like: (&Table, &Figure),
    count: &mut usize,
) -> Markup {
    let figure = like.1;
    let all = gather(sweep, points, keys, like);
    let engines = || {
        figure
            .panels
            .iter()
            .filter(|name| name.starts_with("engine"))
            .cloned()
    };
    let mut side_by_side = figure.clone();
    side_by_side.panels = vec![POINT.into()];
    if figure.mark == Mark::Map {
        side_by_side.panels.extend(engines());
    } else {
        side_by_side.curves.splice(0..0, engines());
    }
    let mut parts = Vec::new();
    if let Some(drawn) = draw(&all, &side_by_side) {
        *count += 1;
        let last = if figure.panels.is_empty() {
            ""
        } else {
            " Of each point the last rows are drawn."
        };
        parts.push(page::figure(
            *count,
            &format!("{}, at each point", figure.title),
            &format!("{}{last}", figure.caption),
            &drawn,
        ));
    }
    if let Some((table, figure)) = trend(&all, keys, figure)
        && let Some(drawn) = draw(&table, &figure)
    {
        *count += 1;
        parts.push(page::figure(*count, &figure.title, &figure.caption, &drawn));
    }
    html! { @if !parts.is_empty() { h2 { (figure.title) } @for part in parts { (part) } } }
}

/// The last value in time of each curve against the swept key that has the most values.
fn trend(all: &Table, keys: &[&String], figure: &Figure) -> Option<(Table, Figure)> {
    let x = &*figure.x.column;
    if figure.mark == Mark::Map
        || !(x == "time" || x.starts_with("window") || x.starts_with("elapsed"))
    {
        return None;
    }
    let x = all.find(x)?;
    let distinct = |key: &str| {
        let column = all.find(key).unwrap_or(0);
        all.rows
            .iter()
            .map(|row| format!("{:?}", row[column]))
            .collect::<BTreeSet<_>>()
            .len()
    };
    // How long a point runs and the shape of its box go along with what it is.
    let varied = keys
        .iter()
        .filter(|key| !key.starts_with("run.") && !key.starts_with("box.") && distinct(key) > 1);
    let varied: Vec<&str> = varied.map(|key| key.as_str()).collect();
    let swept = *varied.iter().max_by_key(|key| distinct(key))?;
    let curves: Vec<usize> = figure
        .panels
        .iter()
        .chain(&figure.curves)
        .filter_map(|name| all.find(name))
        .collect();
    let mut rows: Vec<Vec<Cell>> = Vec::new();
    for row in &all.rows {
        let same = |other: &&mut Vec<Cell>| {
            other[0] == row[0] && curves.iter().all(|key| other[*key] == row[*key])
        };
        match rows.iter_mut().find(same) {
            Some(last) if last[x].number() < row[x].number() => last.clone_from(row),
            Some(_) => {}
            None => rows.push(row.clone()),
        }
    }
    let others = varied.iter().filter(|key| **key != swept);
    let trend = Figure {
        title: format!("{} at the end, against {swept}", figure.y.label).into(),
        caption: "The last value of each point.".into(),
        x: Axis {
            column: swept.to_owned().into(),
            label: swept.to_owned().into(),
            scale: Scale::Linear,
        },
        panels: others.map(|key| (*key).to_owned().into()).collect(),
        curves: figure
            .panels
            .iter()
            .filter(|name| name.starts_with("engine"))
            .chain(&figure.curves)
            .cloned()
            .collect(),
        ..figure.clone()
    };
    Some((
        Table {
            rows,
            ..all.clone()
        },
        trend,
    ))
}
