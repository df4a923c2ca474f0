//! HTML page of a sweep: measured against swept quantities as curves or maps, then the list of
//! points, and each figure at all points.

use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::path::Path;

use maud::{Markup, html};
use serde_json::Value;
use stosszahl_results::{
    AxisScale, ComparedNumber, Figure, FigureAxis, MANIFEST_FILE, PointMark, REPORT_FILE, Role,
    RunQuestion, SWEEP_FILE, SWEEP_TABLE, Stored, Sweep, SweepPoint, Table, TableCell, TableColumn,
    VerdictKind, VerdictText, headlines,
};

use crate::archive::{self, Archive};
use crate::discoveries::{Numbers, corrected};
use crate::figure::{Drawn, draw};
use crate::page;
use crate::sheet::sheet;
use crate::words;
use crate::{Guard, Report, ReportError, run, summary};

/// Name of the table column that holds the name of the sweep point.
const POINT: &str = "point";

/// Builds the HTML page of a sweep and rewrites the reports of its finished points.
pub(crate) fn build(folder: &Path, sweep: &Sweep, guard: Guard<'_>) -> Result<Report, ReportError> {
    let mut archive = Archive::new(&sweep.title);
    archive.add_file(folder, SWEEP_FILE)?;
    let mut points = Vec::new();
    for point in &sweep.points {
        let inside = folder.join(&point.name);
        let stored = Stored::read(&inside)?;
        if let Some(stored) = &stored {
            let report = run::build(&inside, stored)?;
            report.write(&inside, guard)?;
            let name = format!("{}/", point.name);
            run::add_to_archive(
                &mut archive,
                folder,
                &name,
                &stored.manifest,
                &report.beside,
            )?;
        }
        points.push(stored);
    }
    let finished = points.iter().flatten().count();
    let keys = keys(sweep);
    let question = question(&points);
    let [first, others, each] = figures(sweep, &points, &keys);
    let numbers = corrections(&points);
    let mut drawings: Vec<(String, Vec<u8>)> = Vec::new();
    let mut next = |drawn: &Drawn, figure: &Figure, file: String| {
        drawings.push((file, sheet(&figure.title, drawn).into_bytes()));
        page::figure(drawings.len(), &figure.title, &figure.caption, drawn)
    };
    let summary = summary::summary(sweep, &points, &keys, &numbers).to_csv()?;
    archive.add(SWEEP_TABLE, &summary);
    let content = html! {
        h1 { (sweep.title) }
        @if !question.text.is_empty() { p.lead { (question.text) } }
        p.lead { "A sweep of " (sweep.points.len()) " points, of which " (finished) " are finished. Each point has a report of its own." }
        (page::warnings(&changed_table_warnings(sweep, &points)))
        (verdict_counts(&points, &numbers))
        @for (file, figure, drawn) in first { (next(&drawn, &figure, file)) }
        (overview(sweep, &points, &keys, &numbers))
        @if !others.is_empty() { h2 { "Against what was swept" } }
        @for (file, figure, drawn) in others { (next(&drawn, &figure, file)) }
        h2 { "At each point" }
        @for (file, figure, drawn) in each { (next(&drawn, &figure, file)) }
        (page::case_file(&sweep.case_text))
    };
    for (name, bytes) in &drawings {
        archive.add(name, bytes);
    }
    let content = html! { (content) h2 { "Files" } (archive.section()) };
    drawings.push((SWEEP_TABLE.to_owned(), summary));
    Ok(Report {
        page: page::document(&sweep.title, &content, &[archive::SCRIPT]),
        beside: drawings,
    })
}

/// Makes the summary table of a sweep from the points that are finished.
pub(crate) fn table(folder: &Path, sweep: &Sweep) -> Result<Table, ReportError> {
    let points = stored_points(folder, sweep)?;
    let numbers = corrections(&points);
    Ok(summary::summary(sweep, &points, &keys(sweep), &numbers))
}

/// Reads the points of a sweep; `None` for those that are not finished.
fn stored_points(folder: &Path, sweep: &Sweep) -> Result<Vec<Option<Stored>>, ReportError> {
    let read = |point: &SweepPoint| Ok(Stored::read(&folder.join(&point.name))?);
    sweep.points.iter().map(read).collect()
}

/// Figure of a sweep: name of its file, description, and drawing.
pub(crate) type Named = (String, Figure, Drawn);

/// Reads the points of a sweep and draws its figures, in the order of its page.
pub(crate) fn drawn(folder: &Path, sweep: &Sweep) -> Result<Vec<Named>, ReportError> {
    let points = stored_points(folder, sweep)?;
    let all = figures(sweep, &points, &keys(sweep));
    Ok(all.into_iter().flatten().collect())
}

/// Returns the question of the first finished point; an empty one if no point is finished.
fn question(points: &[Option<Stored>]) -> RunQuestion {
    let first = points.iter().flatten().next();
    let question = first.map(|stored| stored.manifest.question.clone());
    question.unwrap_or_default()
}

/// Draws the figures of a sweep in three lists: figures of its question against the swept keys, all
/// other figures against the swept keys, and each figure at all points.
fn figures(sweep: &Sweep, points: &[Option<Stored>], keys: &[&String]) -> [Vec<Named>; 3] {
    let question = question(points);
    let all: Vec<(Table, &Figure, String)> = (first_figures(points).into_iter())
        .map(|(like, figure, file)| {
            (
                rows_at_all_points(sweep, points, keys, like, figure),
                figure,
                file,
            )
        })
        .collect();
    let answers = |table: &Table, figure: &Figure| {
        table.name == question.table && figure.y.column == question.column
    };
    // The answer to the question against the swept keys: as a map where two keys span one, and as
    // curves with error bars.
    let drawn = |(table, figure, file): &(Table, &Figure, String)| {
        let (rows, trend, map) = trend_figure(table, keys, figure)?;
        let leads = answers(table, figure);
        let curves = map.is_none() || leads;
        // If there is a map, it gets the name of the figure.
        let of_curves = match map {
            Some(_) => file.replace(".svg", "-curves.svg"),
            None => file.clone(),
        };
        let map = map.map(|map| (map, file.clone()));
        let trend = curves.then_some((trend, of_curves));
        let drawn = [map, trend].into_iter().flatten();
        let drawn = drawn.filter_map(|(figure, file)| {
            let drawn = draw(&rows, &figure)?;
            Some((file, figure, drawn))
        });
        Some((leads, drawn.collect::<Vec<Named>>()))
    };
    let mut trends: Vec<_> = all.iter().filter_map(drawn).collect();
    if !trends.iter().any(|one| one.0)
        && let Some(first) = trends.first_mut()
    {
        first.0 = true;
    }
    let (first, others): (Vec<_>, Vec<_>) = trends.into_iter().partition(|one| one.0);
    let flat = |some: Vec<(bool, Vec<Named>)>| some.into_iter().flat_map(|one| one.1).collect();
    let each = all.iter().filter_map(|(table, figure, file)| {
        let figure = at_each(figure);
        let drawn = draw(table, &figure)?;
        Some((file.replace(".svg", "-at-each-point.svg"), figure, drawn))
    });
    [flat(first), flat(others), each.collect()]
}

/// Returns the swept keys of all points, sorted.
fn keys(sweep: &Sweep) -> Vec<&String> {
    let points = sweep.points.iter();
    let keys: BTreeSet<&String> = points.flat_map(|point| point.values.keys()).collect();
    keys.into_iter().collect()
}

/// Returns the tables of all finished points joined, with each figure in one panel per point.
pub(crate) fn at_each_point(
    folder: &Path,
    sweep: &Sweep,
) -> Result<Vec<(Table, Figure)>, ReportError> {
    let read = |point: &SweepPoint| Stored::read(&folder.join(&point.name));
    let points: Vec<Option<Stored>> = sweep.points.iter().map(read).collect::<Result<_, _>>()?;
    let keys = keys(sweep);
    let drawn = first_figures(&points).into_iter();
    let drawn = drawn.map(|(like, figure, _)| {
        let gathered = rows_at_all_points(sweep, &points, &keys, like, figure);
        (gathered, at_each(figure))
    });
    Ok(drawn.collect())
}

/// Returns tables and figures of the first finished point, with the names of their drawings.
fn first_figures(points: &[Option<Stored>]) -> Vec<(&Table, &Figure, String)> {
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

/// Returns the first headline verdict of a point.
fn first_headline(stored: &Stored) -> Option<&VerdictText> {
    headlines(&stored.manifest.verdicts).first().copied()
}

/// Builds warnings about tables whose files differ from the manifests of their points.
fn changed_table_warnings(sweep: &Sweep, points: &[Option<Stored>]) -> Vec<Markup> {
    let both = sweep.points.iter().zip(points);
    let files = both.flat_map(|(point, stored)| {
        let files = stored.iter().flat_map(|stored| &stored.changed);
        files.map(|file| html! { code { (point.name) "/" (file) } " is not the file that the run wrote." })
    });
    files.collect()
}

/// Computes intervals of the compared numbers of all points, corrected for multiple testing.
fn corrections(points: &[Option<Stored>]) -> Numbers {
    let number = |stored: &Option<Stored>| {
        let first = first_headline(stored.as_ref()?)?;
        let sound = first.kind != VerdictKind::Void;
        first.number.clone().filter(|_| sound)
    };
    let numbers: Vec<_> = points.iter().map(number).collect();
    let found = corrected(&numbers);
    numbers
        .into_iter()
        .zip(found)
        .map(|(a, b)| a.zip(b))
        .collect()
}

/// Builds the count of points by verdict, from corrected intervals; void points are listed
/// separately.
fn verdict_counts(points: &[Option<Stored>], numbers: &Numbers) -> Markup {
    let mut kinds: Vec<(VerdictKind, usize)> = Vec::new();
    for (stored, number) in points.iter().zip(numbers) {
        let kind = match (stored, number) {
            (_, Some((_, corrected))) => corrected.kind,
            (Some(stored), None) => match first_headline(stored) {
                Some(verdict) => verdict.kind,
                None => continue,
            },
            (None, None) => continue,
        };
        match kinds.iter_mut().find(|one| one.0 == kind) {
            Some(one) => one.1 += 1,
            None => kinds.push((kind, 1)),
        }
    }
    let first = numbers.iter().flatten().next();
    html! {
        @if !kinds.is_empty() {
            p.headline { @for (kind, count) in &kinds { (page::kind(*kind)) " at " (count) @if *count == 1 { " point. " } @else { " points. " } } }
        }
        @if let Some((number, _)) = first {
            p {
                "Judged is the " (number.quantity) " " (number.place) " at each point. Intervals are corrected for " (numbers.iter().flatten().count())
                " points: of the points that are called agree or differ, a share of " (words::number(number.level, 2))
                " at most is so by chance, on average (Benjamini and Hochberg)."
            }
        }
    }
}

/// Formats the confidence interval of a compared number, in per cent if it is relative.
fn interval(number: &ComparedNumber, ends: Option<[f64; 2]>) -> String {
    let (scale, unit) = if number.relative {
        (100.0, " %")
    } else {
        (1.0, "")
    };
    ends.map_or("–".to_owned(), |[low, high]| {
        let [low, high] = [low, high].map(|end| words::number(scale * end, 3));
        format!("{low} to {high}{unit}")
    })
}

/// Formats a dotted key with line break opportunities after dots and underscores.
fn breakable(key: &str) -> Markup {
    html! { @for part in key.split_inclusive(['.', '_']) { (part) wbr; } }
}

/// Builds the list of sweep points with swept values, first verdicts and links to reports.
fn overview(
    sweep: &Sweep,
    points: &[Option<Stored>],
    keys: &[&String],
    numbers: &Numbers,
) -> Markup {
    let some = numbers.iter().flatten().next().is_some();
    html! {
        h2 { "Points" }
        p { "A number leads to the report of the point." }
        div.scroll { table.points {
            thead { tr {
                th.text scope="col" { "point" }
                @for key in keys { th scope="col" { (breakable(key)) } }
                @if some {
                    th scope="col" { "difference" } th scope="col" { "interval of the point" } th scope="col" { "corrected" }
                    th.text scope="col" { "corrected verdict" }
                }
                th.text scope="col" { "verdict of the point" }
            } }
            tbody { @for (((point, stored), judged), number) in sweep.points.iter().zip(points).zip(numbers).zip(1..) { tr {
                td.text { @if stored.is_some() { a href=(report_link(&point.name)) title=(point.name) { (number) } } @else { (number) } }
                @for key in keys { td { (words::setting(point.values.get(*key))) } }
                @if some {
                    @match judged {
                        Some((number, corrected)) => {
                            td { (interval(number, Some([number.difference; 2])).split(" to").next().unwrap_or("")) @if number.relative { " %" } }
                            td { (interval(number, corrected.own)) } td { (interval(number, corrected.corrected)) }
                            td.text { (page::kind(corrected.kind)) }
                        }
                        None => { td { "–" } td { "–" } td { "–" } td.text { "–" } }
                    }
                }
                td.text.long {
                    @match stored.as_ref().map(first_headline) {
                        Some(Some(verdict)) => { (page::kind(verdict.kind)) " " (verdict.sentence) }
                        Some(None) => "–",
                        None => { "not finished: no " code { (MANIFEST_FILE) } }
                    }
                }
            } } }
        } }
    }
}

/// Returns the relative link to the report of a sweep point, percent-encoded.
fn report_link(name: &str) -> String {
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

/// Gathers the rows of one table at all points; of a figure with panels, only those of the last
/// panel.
fn rows_at_all_points(
    sweep: &Sweep,
    points: &[Option<Stored>],
    keys: &[&String],
    like: &Table,
    figure: &Figure,
) -> Table {
    let column = |name: String, unit: &'static str| TableColumn {
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
        .filter_map(|name| like.find_column(name))
        .collect();
    for (point, stored) in sweep.points.iter().zip(points) {
        let tables = stored.iter().flat_map(|stored| &stored.tables);
        for table in tables.filter(|table| table.name == like.name && table.columns == like.columns)
        {
            let last = table.rows.last();
            let of_last = |row: &&Vec<TableCell>| {
                last.is_some_and(|last| {
                    panels.iter().all(|panel| {
                        table.columns[*panel].name.starts_with("engine")
                            || row[*panel] == last[*panel]
                    })
                })
            };
            for row in table.rows.iter().filter(of_last) {
                let mut cells = vec![TableCell::Text(point.name.clone())];
                cells.extend(keys.iter().map(|key| match point.values.get(*key) {
                    Some(Value::Number(value)) => {
                        value.as_f64().map_or(TableCell::Empty, TableCell::Number)
                    }
                    other => TableCell::Text(words::setting(other)),
                }));
                cells.extend(row.iter().cloned());
                all.rows.push(cells);
            }
        }
    }
    all
}

/// Returns a copy of a figure with one panel per sweep point.
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
    if figure.mark == PointMark::Map {
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

/// Describes a figure of the last value in time of each curve against the swept key with the most
/// values, and its table.
///
/// If two keys have several values, a map is drawn too.
fn trend_figure(
    all: &Table,
    keys: &[&String],
    figure: &Figure,
) -> Option<(Table, Figure, Option<Figure>)> {
    let x = &*figure.x.column;
    if figure.mark == PointMark::Map
        || !(x == "time" || x.starts_with("window") || x.starts_with("lag"))
    {
        return None;
    }
    let x = all.find_column(x)?;
    let distinct = |key: &str| {
        let column = all.find_column(key).unwrap_or(0);
        all.rows
            .iter()
            .map(|row| format!("{:?}", row[column]))
            .collect::<BTreeSet<_>>()
            .len()
    };
    // Duration and number of samples, measures, and the shape of the box are not physical
    // parameters.
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
        .filter_map(|name| all.find_column(name))
        .collect();
    let mut rows: Vec<Vec<TableCell>> = Vec::new();
    for row in &all.rows {
        let same = |other: &&mut Vec<TableCell>| {
            other[0] == row[0] && curves.iter().all(|key| other[*key] == row[*key])
        };
        match rows.iter_mut().find(same) {
            Some(last) if last[x].number() < row[x].number() => last.clone_from(row),
            Some(_) => {}
            None => rows.push(row.clone()),
        }
    }
    let others = varied.iter().filter(|key| **key != swept);
    let others: Vec<_> = others.map(|key| (*key).to_owned().into()).collect();
    // Two keys with several values each span a map.
    let map = match varied[..] {
        [one, other] if [one, other].iter().all(|key| distinct(key) > 2) => {
            map(all, figure, &curves, [one, other])
        }
        _ => None,
    };
    let engines = figure.panels.iter();
    let engines = engines.filter(|name| name.starts_with("engine"));
    let trend = Figure {
        title: format!("{} at the end, against {swept}", figure.y.label).into(),
        caption: "The last value of each point.".into(),
        x: FigureAxis {
            column: swept.to_owned().into(),
            label: swept.to_owned().into(),
            scale: AxisScale::Linear,
        },
        panels: Vec::new(),
        curves: engines
            .chain(&figure.curves)
            .cloned()
            .chain(others)
            .collect(),
        ..figure.clone()
    };
    let table = Table {
        rows,
        ..all.clone()
    };
    Some((table, trend, map))
}

/// Describes a map over two swept keys; `None` unless their values are numbers.
fn map(all: &Table, figure: &Figure, curves: &[usize], keys: [&str; 2]) -> Option<Figure> {
    for key in keys {
        let column = all.find_column(key)?;
        all.rows
            .iter()
            .all(|row| row[column].number().is_some())
            .then_some(())?;
    }
    let [x, y] = keys.map(|key| FigureAxis {
        column: key.to_owned().into(),
        label: key.to_owned().into(),
        scale: AxisScale::Linear,
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
        mark: PointMark::Map,
        lines: Vec::new(),
        colour: Some(figure.y.clone()),
    })
}
