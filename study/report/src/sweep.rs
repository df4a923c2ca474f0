//! The page of a sweep: first what was measured against what was swept, as a curve or a map, then a list of the points, and each
//! figure at all points.

use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::path::Path;

use maud::{Markup, html};
use serde_json::Value;
use stosszahl_results::{
    Axis, Cell, Column, Figure, MANIFEST_FILE, Mark, REPORT_FILE, Role, SWEEP_TABLE, Scale, Stored,
    Sweep, SweepPoint, Table, Verdict, VerdictKind, headlines,
};

use crate::figure::{Drawn, draw};
use crate::page;
use crate::sheet::sheet;
use crate::words::number;
use crate::{Guard, Report, ReportError, run, summary};

/// The table in which engines are compared.
const QUOTIENTS: &str = "comparison";
/// Name of the column that says which point a row is of.
const POINT: &str = "point";

/// Builds the page of a sweep and rewrites the reports of its finished points.
pub(crate) fn build(folder: &Path, sweep: &Sweep, guard: Guard<'_>) -> Result<Report, ReportError> {
    let mut points = Vec::new();
    for point in &sweep.points {
        let inside = folder.join(&point.name);
        let stored = Stored::read(&inside)?;
        if let Some(stored) = &stored {
            run::build(&inside, stored)?.write(&inside, guard)?;
        }
        points.push(stored);
    }
    let finished = points.iter().flatten().count();
    let keys = keys(sweep);
    let all: Vec<(Table, &Figure, String)> = (common(&points).into_iter())
        .map(|(like, figure, file)| (gather(sweep, &points, &keys, like, figure), figure, file))
        .collect();
    // What answers the question of a sweep: the comparison of engines, or else what is measured first, against the swept keys.
    let drawn = |(table, figure, file): &(Table, &Figure, String)| {
        let (table, figure) = trend(table, &keys, figure)?;
        Some((
            table.name.clone(),
            draw(&table, &figure)?,
            figure,
            file.clone(),
        ))
    };
    let trends: Vec<_> = all.iter().filter_map(drawn).collect();
    let answer = trends
        .iter()
        .position(|one| one.0 == QUOTIENTS)
        .unwrap_or(0);
    let (first, others): (Vec<_>, Vec<_>) =
        (trends.iter().zip(0..)).partition(|one| one.1 == answer);
    let mut drawings: Vec<(String, Vec<u8>)> = Vec::new();
    let mut next = |drawn: &Drawn, figure: &Figure, file: String| {
        drawings.push((file, sheet(&figure.title, drawn).into_bytes()));
        page::figure(drawings.len(), &figure.title, &figure.caption, drawn)
    };
    let content = html! {
        h1 { (sweep.title) }
        p.lead { "A sweep of " (sweep.points.len()) " points, of which " (finished) " are finished. Each point has a report of its own." }
        (page::warnings(&changed(sweep, &points)))
        (tally(&points))
        @for ((_, drawn, figure, file), _) in &first { (next(drawn, figure, file.clone())) }
        (overview(sweep, &points, &keys))
        @if !others.is_empty() { h2 { "Against what was swept" } }
        @for ((_, drawn, figure, file), _) in &others { (next(drawn, figure, file.clone())) }
        h2 { "At each point" }
        @for (table, figure, file) in &all {
            @let figure = at_each(figure);
            @let file = file.replace(".svg", "-at-each-point.svg");
            @if let Some(drawn) = draw(table, &figure) { (next(&drawn, &figure, file)) }
        }
        (page::case_file(&sweep.case_text))
    };
    let summary = summary::summary(sweep, &points, &keys);
    drawings.push((SWEEP_TABLE.to_owned(), summary.to_csv()?));
    Ok(Report {
        page: page::document(&sweep.title, &content, None),
        beside: drawings,
    })
}

/// The swept keys.
fn keys(sweep: &Sweep) -> Vec<&String> {
    let points = sweep.points.iter();
    let keys: BTreeSet<&String> = points.flat_map(|point| point.values.keys()).collect();
    keys.into_iter().collect()
}

/// The tables of all finished points, each with its figures, which have a panel for each point.
pub(crate) fn at_each_point(
    folder: &Path,
    sweep: &Sweep,
) -> Result<Vec<(Table, Figure)>, ReportError> {
    let read = |point: &SweepPoint| Stored::read(&folder.join(&point.name));
    let points: Vec<Option<Stored>> = sweep.points.iter().map(read).collect::<Result<_, _>>()?;
    let keys = keys(sweep);
    let drawn = common(&points).into_iter();
    let drawn = drawn.map(|(like, figure, _)| {
        let gathered = gather(sweep, &points, &keys, like, figure);
        (gathered, at_each(figure))
    });
    Ok(drawn.collect())
}

/// The tables and figures of the first finished point, and the names of their drawings.
fn common(points: &[Option<Stored>]) -> Vec<(&Table, &Figure, String)> {
    let tables = points
        .iter()
        .flatten()
        .next()
        .map_or(&[][..], |stored| &stored.tables);
    tables
        .iter()
        .flat_map(|table| {
            let figures = table.figures.iter().zip(table.drawings());
            figures.map(move |(figure, file)| (table, figure, file))
        })
        .collect()
}

pub(crate) fn text(value: Option<&Value>) -> String {
    match value {
        None => "–".to_owned(),
        Some(Value::String(text)) => text.clone(),
        Some(Value::Number(value)) => value
            .as_f64()
            .map_or(value.to_string(), |value| number(value, 5)),
        Some(other) => other.to_string(),
    }
}

/// The conclusion of a point that comes first.
fn conclusion(stored: &Stored) -> Option<&Verdict> {
    headlines(&stored.manifest.verdicts).first().copied()
}

/// Warnings of the tables of points that are not those of their manifests.
fn changed(sweep: &Sweep, points: &[Option<Stored>]) -> Vec<Markup> {
    let both = sweep.points.iter().zip(points);
    let files = both.flat_map(|(point, stored)| {
        let files = stored.iter().flat_map(|stored| &stored.changed);
        files.map(|file| html! { code { (point.name) "/" (file) } " is not the file that the run wrote." })
    });
    files.collect()
}

/// At how many points the first conclusion is of each kind.
fn tally(points: &[Option<Stored>]) -> Markup {
    let mut kinds: Vec<(VerdictKind, usize)> = Vec::new();
    for verdict in points.iter().flatten().filter_map(conclusion) {
        match kinds.iter_mut().find(|one| one.0 == verdict.kind) {
            Some(one) => one.1 += 1,
            None => kinds.push((verdict.kind, 1)),
        }
    }
    html! {
        @if !kinds.is_empty() {
            p.headline { @for (kind, count) in &kinds { (page::kind(*kind)) " at " (count) @if *count == 1 { " point. " } @else { " points. " } } }
        }
    }
}

/// A key that a narrow screen may break after its dots and low lines.
fn breakable(key: &str) -> Markup {
    html! { @for part in key.split_inclusive(['.', '_']) { (part) wbr; } }
}

/// List of the points with their values, first verdicts and links.
fn overview(sweep: &Sweep, points: &[Option<Stored>], keys: &[&String]) -> Markup {
    html! {
        h2 { "Points" }
        p { "A number leads to the report of the point." }
        div.scroll { table.points {
            thead { tr {
                th.text scope="col" { "point" }
                @for key in keys { th scope="col" { (breakable(key)) } }
                th.text scope="col" { "verdict" }
            } }
            tbody { @for ((point, stored), number) in sweep.points.iter().zip(points).zip(1..) { tr {
                td.text { @if stored.is_some() { a href=(link(&point.name)) title=(point.name) { (number) } } @else { (number) } }
                @for key in keys { td { (text(point.values.get(*key))) } }
                td.text.long {
                    @match stored.as_ref().map(conclusion) {
                        Some(Some(verdict)) => { (page::kind(verdict.kind)) " " (verdict.sentence) }
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
    like: &Table,
    figure: &Figure,
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

/// A figure with a panel for each point.
fn at_each(figure: &Figure) -> Figure {
    let engines = || {
        figure
            .panels
            .iter()
            .filter(|name| name.starts_with("engine"))
            .cloned()
    };
    let mut all = figure.clone();
    all.panels = vec![POINT.into()];
    if figure.mark == Mark::Map {
        all.panels.extend(engines());
    } else {
        all.curves.splice(0..0, engines());
    }
    let last = if figure.panels.is_empty() {
        ""
    } else {
        " Of each point the last rows are drawn."
    };
    all.title = format!("{}, at each point", figure.title).into();
    all.caption = format!("{}{last}", figure.caption).into();
    all
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
    // How long and how often a point runs, what is measured, and the shape of its box go along with what it is.
    let along = |key: &str| {
        key.starts_with("run.")
            || key.starts_with("measure.")
            || ["box.size", "box.aspect_ratio", "replicas", "seed"].contains(&key)
    };
    let varied = keys.iter().filter(|key| !along(key) && distinct(key) > 1);
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
    let mut others = varied.iter().filter(|key| **key != swept);
    // Two keys with several values each span a map.
    if let [one, other] = varied[..]
        && [one, other].iter().all(|key| distinct(key) > 2)
        && let Some(map) = map(all, figure, &curves, [one, other])
    {
        return Some((
            Table {
                rows,
                ..all.clone()
            },
            map,
        ));
    }
    let trend = Figure {
        title: format!("{} at the end, against {swept}", figure.y.label).into(),
        caption: "The last value of each point.".into(),
        x: Axis {
            column: swept.to_owned().into(),
            label: swept.to_owned().into(),
            scale: Scale::Linear,
        },
        panels: others
            .by_ref()
            .map(|key| (*key).to_owned().into())
            .collect(),
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

/// A map over two swept keys; none if they are no numbers.
fn map(all: &Table, figure: &Figure, curves: &[usize], keys: [&str; 2]) -> Option<Figure> {
    for key in keys {
        let column = all.find(key)?;
        all.rows
            .iter()
            .all(|row| row[column].number().is_some())
            .then_some(())?;
    }
    let [x, y] = keys.map(|key| Axis {
        column: key.to_owned().into(),
        label: key.to_owned().into(),
        scale: Scale::Linear,
    });
    Some(Figure {
        title: format!(
            "{} at the end, over {} and {}",
            figure.y.label, keys[0], keys[1]
        )
        .into(),
        caption: "The last value of each point.".into(),
        x,
        y,
        panels: Vec::new(),
        curves: (curves.iter())
            .map(|key| all.columns[*key].name.clone())
            .collect(),
        mark: Mark::Map,
        lines: Vec::new(),
        colour: Some(figure.y.clone()),
    })
}
