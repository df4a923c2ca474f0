//! Figures of result tables as charts: grouping of rows into panels and curves, and their styles.
//!
//! Every engine has one colour and one marker in all charts. Where the curves of one engine differ
//! in another key, such as time, colours follow a second, ordered scale from dark to bright.

use std::fmt::Write as _;

use serde_json::Value;
use stosszahl_results::{
    AxisScale, Figure, PointMark, Role, Table, TableCell, engine_rank, engine_title,
};

use crate::chart::{Chart, ChartAxis, ChartCurve, ChartPoint, Marker, Stroke};
use crate::draw::Plot;
use crate::map::{Map, with_obstacles};
use crate::words::{number, spread};

/// Largest number of panels of a figure; of more, an even selection is drawn.
pub(crate) const PANELS: usize = 9;
/// Largest number of curves of one engine in a panel; of more, an even selection is drawn.
const CURVES: usize = 8;
/// Number of colours of the ordered scale in the style sheet.
const SHADES: usize = 7;

/// Figure drawn from a table: legend, panels and caption.
pub(crate) struct Drawn {
    /// Legend entries of the figure, one for each kind of curve.
    pub legend: Vec<ChartCurve>,
    /// Panels of the figure, in the order of the page.
    pub panels: Vec<Panel>,
    /// True if all panels have the same range of the vertical axis.
    pub common: bool,
    /// Caption of the figure, with a note on data that are left out.
    pub note: String,
}

/// Panel of a figure: a chart or map, drawn for the page.
#[derive(Clone, Debug)]
pub(crate) struct Panel {
    /// Title of the panel; empty if it needs none.
    pub title: String,
    /// SVG drawing of the panel, in its size on the report page.
    pub plot: Plot,
    /// Chart or map that the drawing of the panel shows.
    pub subject: Subject,
}

/// Chart or map of a panel, from which it can be drawn in another size.
#[derive(Clone, Debug)]
pub(crate) enum Subject {
    /// Chart with curves or histograms.
    Chart(Chart),
    /// Map of a quantity over the plane, with colours and obstacles.
    Map {
        /// Map with its values by cell.
        map: Map,
        /// Values at the lower and upper end of the colour bar.
        range: (f64, f64),
        /// Obstacles of the case, as JSON.
        obstacles: Vec<Value>,
    },
}

impl Panel {
    /// Adds the obstacles of the case to the drawing of a map; a chart is unchanged.
    pub(crate) fn add_obstacles(&mut self, all: &[Value]) {
        if let Subject::Map { obstacles, .. } = &mut self.subject {
            *obstacles = all.to_vec();
            with_obstacles(&mut self.plot, all);
        }
    }
}

impl Drawn {
    /// Joins several figures into one, with all their panels and a common legend.
    pub(crate) fn join(all: Vec<Self>) -> Self {
        let mut joined = Self {
            legend: Vec::new(),
            panels: Vec::new(),
            common: false,
            note: String::new(),
        };
        for one in all {
            add_to_legend(&mut joined.legend, &one.legend);
            joined.panels.extend(one.panels);
        }
        joined
    }
}

/// Adds curves to a legend, without their points, unless the legend has them already.
fn add_to_legend<'a>(
    legend: &mut Vec<ChartCurve>,
    curves: impl IntoIterator<Item = &'a ChartCurve>,
) {
    for curve in curves {
        if !legend.iter().any(|one| one.label == curve.label) {
            legend.push(ChartCurve {
                points: vec![],
                ..curve.clone()
            });
        }
    }
}

/// Returns the colour of an engine, a CSS value.
pub fn engine_colour(engine: &str) -> String {
    engine_rank(engine).map_or("var(--ink)".into(), |rank| format!("var(--engine-{rank})"))
}

/// Returns the marker shape of an engine.
pub fn engine_marker(engine: &str) -> Marker {
    Marker::ALL[engine_rank(engine).unwrap_or(0) % Marker::ALL.len()]
}

/// Group of table rows with equal values in the key columns.
struct Group<'a> {
    keys: Vec<&'a TableCell>,
    rows: Vec<&'a [TableCell]>,
}

/// Groups table rows by their values in some columns, in order of occurrence.
fn groups<'a>(rows: &[&'a [TableCell]], columns: &[usize]) -> Vec<Group<'a>> {
    let mut places = std::collections::HashMap::new();
    let mut groups: Vec<Group<'a>> = Vec::new();
    for row in rows {
        let keys: Vec<&TableCell> = columns.iter().map(|column| &row[*column]).collect();
        let place = *places.entry(format!("{keys:?}")).or_insert(groups.len());
        if place == groups.len() {
            groups.push(Group { keys, rows: vec![] });
        }
        groups[place].rows.push(row);
    }
    groups
}

/// Formats the cell of a column as text of a title or legend.
pub(crate) fn cell_text(column: &str, cell: &TableCell) -> String {
    match cell {
        TableCell::Text(text) if column.starts_with("engine") => engine_title(text).to_owned(),
        TableCell::Text(text) => text.clone(),
        TableCell::Number(value) => number(*value, 5),
        TableCell::Count(count) => count.to_string(),
        TableCell::Empty => "–".to_owned(),
    }
}

/// Formats the title of a group of rows from the values of its key columns.
fn title(table: &Table, columns: &[usize], keys: &[&TableCell]) -> String {
    let mut words: Vec<String> = Vec::new();
    let mut engines: Vec<String> = Vec::new();
    for (&column, cell) in columns.iter().zip(keys) {
        let name = &*table.columns[column].name;
        let text = cell_text(name, cell);
        match name.rsplit_once('_') {
            _ if name.starts_with("engine") => engines.push(text),
            Some((of, "start" | "low")) => words.push(format!("{} {text}", of.replace('_', " "))),
            Some((_, "end" | "high")) if !words.is_empty() => {
                if let Some(last) = words.last_mut() {
                    last.push_str(" to ");
                    last.push_str(&text);
                }
            }
            _ => words.push(format!("{} {text}", name.replace('_', " "))),
        }
    }
    if !engines.is_empty() {
        words.insert(0, engines.join(" / "));
    }
    words.join(", ")
}

/// Returns the engine of a group of rows, which decides its colour. For a comparison of two
/// engines, it is the one compared with exact dynamics, or the first if neither is exact.
fn engine<'a>(table: &Table, columns: &[usize], keys: &[&'a TableCell]) -> Option<&'a str> {
    let named = columns
        .iter()
        .zip(keys)
        .filter_map(|(column, cell)| match cell {
            TableCell::Text(text) if table.columns[*column].name.starts_with("engine") => {
                Some(text.as_str())
            }
            _ => None,
        });
    let mut found = None;
    for name in named {
        if found.is_none_or(|found| found == "ed") {
            found = Some(name);
        }
    }
    found
}

/// Returns true if a group of rows compares two engines of which neither is exact.
fn of_others(table: &Table, columns: &[usize], keys: &[&TableCell]) -> bool {
    let named = columns.iter().zip(keys);
    let engines = named.filter(|(column, _)| table.columns[**column].name.starts_with("engine"));
    let exact = |cell: &&TableCell| matches!(cell, TableCell::Text(text) if text == "ed");
    engines.clone().count() > 1 && !engines.map(|(_, cell)| *cell).any(|cell| exact(&cell))
}

/// Returns the indices of the columns with the given names; names that the table lacks are left
/// out.
fn find_columns(table: &Table, names: &[impl AsRef<str>]) -> Vec<usize> {
    names
        .iter()
        .filter_map(|name| table.find_column(name.as_ref()))
        .collect()
}

/// Draws a figure of a table, as its description says; `None` if there is nothing to draw.
pub(crate) fn draw(table: &Table, figure: &Figure) -> Option<Drawn> {
    let rows: Vec<&[TableCell]> = table.rows.iter().map(Vec::as_slice).collect();
    let panels = find_columns(table, &figure.panels);
    match figure.mark {
        PointMark::Map => maps(table, figure, &rows, panels),
        _ => curves(table, figure, &rows, &panels),
    }
}

fn left_out(shown: usize, all: usize) -> String {
    if shown < all {
        format!(" Drawn are {shown} of {all} panels.")
    } else {
        String::new()
    }
}

fn curves(
    table: &Table,
    figure: &Figure,
    rows: &[&[TableCell]],
    panels: &[usize],
) -> Option<Drawn> {
    let plan = Curves::new(table, figure, rows)?;
    let mut drawn: Vec<(String, Chart)> = Vec::new();
    for group in groups(rows, panels) {
        let chart = plan.chart(&group.rows, engine(table, panels, &group.keys));
        if !chart.is_empty() {
            drawn.push((title(table, panels, &group.keys), chart));
        }
    }
    let all = drawn.len();
    let (titles, mut charts): (Vec<String>, Vec<Chart>) =
        spread(&drawn, PANELS).into_iter().unzip();
    let common = Chart::share_axes(&mut charts);
    let mut legend: Vec<ChartCurve> = Vec::new();
    let named = charts.iter().flat_map(|chart| &chart.curves);
    let named = named.filter(|curve| !curve.label.is_empty() && !curve.points.is_empty());
    add_to_legend(&mut legend, named);
    for line in &figure.lines {
        legend.push(ChartCurve {
            label: line.label.to_string(),
            colour: "var(--ink)".into(),
            marker: None,
            stroke: Stroke::Dashed,
            points: vec![],
        });
    }
    let panels: Vec<Panel> = titles
        .into_iter()
        .zip(charts)
        .map(|(title, chart)| {
            let description = format!(
                "{} {title}: {} against {}",
                figure.title, chart.y.label, chart.x.label
            );
            Panel {
                title,
                plot: chart.plot(description),
                subject: Subject::Chart(chart),
            }
        })
        .collect();
    let own = if common {
        ""
    } else {
        " Each panel has a vertical axis of its own."
    };
    (!panels.is_empty()).then(|| Drawn {
        note: plan.caption_text(rows) + &left_out(panels.len(), all) + own,
        common,
        legend,
        panels,
    })
}

/// Curves of a figure: their table, columns and key columns.
struct Curves<'a> {
    table: &'a Table,
    figure: &'a Figure,
    x: usize,
    y: usize,
    /// Indices of the key columns that distinguish engines.
    engines: Vec<usize>,
    /// Indices of other key columns with more than one value, which distinguish curves of one
    /// engine.
    others: Vec<usize>,
    /// Values, in the key columns that do not distinguish engines, for which curves are drawn.
    values: Vec<String>,
    /// Number of all values in the key columns that do not distinguish engines, drawn or not.
    all: usize,
    several: bool,
    /// Names at the positions of the horizontal axis, if its values are words.
    names: Vec<String>,
}

impl<'a> Curves<'a> {
    fn new(table: &'a Table, figure: &'a Figure, rows: &[&[TableCell]]) -> Option<Self> {
        let (x, y) = (
            table.find_column(&figure.x.column)?,
            table.find_column(&figure.y.column)?,
        );
        let keys = find_columns(table, &figure.curves);
        let (engines, others): (Vec<usize>, Vec<usize>) = keys
            .into_iter()
            .partition(|column| table.columns[*column].name.starts_with("engine"));
        let mut others = others;
        others.retain(|column| groups(rows, &[*column]).len() > 1);
        let values: Vec<String> = groups(rows, &others)
            .iter()
            .map(|group| title(table, &others, &group.keys))
            .collect();
        let words = rows.iter().any(|row| matches!(row[x], TableCell::Text(_)));
        let names = groups(rows, &[x]);
        let names = names.iter().filter(|_| words);
        Some(Self {
            several: groups(rows, &engines).len() > 1,
            names: names
                .map(|group| cell_text(&table.columns[x].name, group.keys[0]))
                .collect(),
            all: values.len(),
            values: spread(&values, CURVES),
            table,
            figure,
            x,
            y,
            engines,
            others,
        })
    }

    /// Writes the caption of the figure: the quantity, the meaning of bars and dashed lines, and
    /// the data that are left out.
    fn caption_text(&self, rows: &[&[TableCell]]) -> String {
        let column = &self.table.columns[self.y];
        let mut note = String::new();
        if !column.meaning.is_empty() {
            let _ = write!(note, " Plotted: {}.", column.meaning.trim_end_matches('.'));
        }
        let some = |place: usize| rows.iter().any(|row| row[place].number().is_some());
        if self.companion(Role::StandardError).is_some_and(some) {
            let replicas = self.table.find_column("replicas");
            let counts =
                replicas.map(|place| rows.iter().filter_map(move |row| row[place].number()));
            let counts: Vec<f64> = counts.into_iter().flatten().collect();
            let least = counts.iter().copied().fold(f64::INFINITY, f64::min);
            let most = counts.iter().copied().fold(0.0, f64::max);
            let over = match () {
                () if counts.is_empty() => String::new(),
                () if least == most => format!(" over {most} replicas"),
                () => format!(" over {least} to {most} replicas"),
            };
            let _ = write!(note, " Bars: standard error{over}.");
        }
        let mut dashed: Vec<&str> = self.figure.lines.iter().map(|line| &*line.label).collect();
        if self.companion(Role::Theory).is_some_and(some) {
            dashed.push("theory");
        }
        if !dashed.is_empty() {
            let _ = write!(note, " Dashed: {}.", dashed.join(", "));
        }
        if self.values.len() < self.all {
            let _ = write!(
                note,
                " Drawn are {} of {} curves of each panel.",
                self.values.len(),
                self.all
            );
        }
        note
    }

    fn abscissa(&self, cell: &TableCell) -> Option<f64> {
        if self.names.is_empty() {
            return cell.number();
        }
        let text = cell_text(&self.table.columns[self.x].name, cell);
        let place = self.names.iter().position(|name| *name == text)?;
        Some(place as f64 + 1.0)
    }

    /// Reads the points of a curve from table rows: abscissa, ordinate, error and theory.
    fn points(
        &self,
        rows: &[&[TableCell]],
        y: usize,
        error: Option<usize>,
        theory: Option<usize>,
    ) -> Vec<ChartPoint> {
        let bars = self.figure.mark == PointMark::Bars;
        let mut points: Vec<ChartPoint> = rows
            .iter()
            .filter_map(|row| {
                let x = self.abscissa(&row[self.x])?;
                let end = row
                    .get(self.x + 1)
                    .filter(|_| bars)
                    .and_then(TableCell::number);
                Some(ChartPoint {
                    x,
                    end: end.unwrap_or(x),
                    y: row[y].number()?,
                    error: error.and_then(|error| row[error].number()),
                    theory: theory.and_then(|theory| row[theory].number()),
                })
            })
            .collect();
        points.sort_by(|a, b| a.x.total_cmp(&b.x));
        points
    }

    /// Returns the index of the column after the ordinate that has a given role for it, such as its
    /// standard error.
    fn companion(&self, role: Role) -> Option<usize> {
        let after = self.table.columns.iter().enumerate().skip(self.y + 1);
        let mut own = after.take_while(|(_, column)| {
            matches!(
                column.role,
                Role::StandardError | Role::Theory | Role::TheoryError
            )
        });
        own.find(|(_, column)| column.role == role)
            .map(|(place, _)| place)
    }

    fn chart(&self, rows: &[&[TableCell]], of_panel: Option<&str>) -> Chart {
        let axis = |axis: &stosszahl_results::FigureAxis, column: usize| ChartAxis {
            unit: self.table.columns[column].unit.to_string(),
            ..ChartAxis::new(&*axis.label, axis.scale)
        };
        let mut chart = Chart::new(axis(&self.figure.x, self.x), axis(&self.figure.y, self.y));
        chart.x.names.clone_from(&self.names);
        chart.lines = self
            .figure
            .lines
            .iter()
            .map(|line| (line.label.to_string(), line.y))
            .collect();
        let keys: Vec<usize> = self.engines.iter().chain(&self.others).copied().collect();
        let theory = self.companion(Role::Theory);
        let has_level = !self.figure.lines.is_empty()
            || theory.is_some_and(|theory| rows.iter().any(|row| row[theory].number().is_some()));
        let mut laws: Vec<ChartCurve> = Vec::new();
        let mut measured = Vec::new();
        for group in groups(rows, &keys) {
            let other = title(self.table, &self.others, &group.keys[self.engines.len()..]);
            let Some(place) = self.values.iter().position(|value| *value == other) else {
                continue;
            };
            let engine = engine(self.table, &keys, &group.keys).or(of_panel);
            let (colour, marker) = match engine {
                // In a pair without the exact engine, neither engine has a colour of its own left.
                Some(engine)
                    if self.others.is_empty() && of_others(self.table, &keys, &group.keys) =>
                {
                    ("var(--ink)".into(), engine_marker(engine))
                }
                Some(engine) if self.others.is_empty() => {
                    (engine_colour(engine), engine_marker(engine))
                }
                Some(engine) if self.several => (
                    engine_colour(engine),
                    Marker::ALL[place % Marker::ALL.len()],
                ),
                None if self.others.is_empty() => ("var(--engine-0)".into(), Marker::Circle),
                _ => (
                    shade(place, self.values.len()),
                    Marker::ALL[place % Marker::ALL.len()],
                ),
            };
            let named = if self.several || self.others.is_empty() {
                keys.clone()
            } else {
                self.others.clone()
            };
            let cells: Vec<&TableCell> = group.keys[keys.len() - named.len()..].to_vec();
            let mut label = title(self.table, &named, &cells);
            if label.is_empty() && theory.is_some() {
                label.push_str("measured");
            }
            if let Some(theory) = theory {
                let points = self.points(&group.rows, theory, None, None);
                if !points.is_empty() && !laws.iter().any(|law| law.points == points) {
                    let name = format!("theory, {label}");
                    laws.push(ChartCurve {
                        label: name,
                        colour: colour.clone(),
                        marker: None,
                        stroke: Stroke::Dashed,
                        points,
                    });
                }
            }
            let (marker, stroke) = match self.figure.mark {
                // Beside a theory the difference matters, so steps need not start from zero.
                PointMark::Bars if has_level => (None, Stroke::Solid),
                PointMark::Bars => (None, Stroke::Bars),
                PointMark::Points => (Some(marker), Stroke::None),
                _ => (Some(marker), Stroke::Thin),
            };
            let companions = [Role::StandardError, Role::Theory].map(|role| self.companion(role));
            let points = self.points(&group.rows, self.y, companions[0], companions[1]);
            measured.push(ChartCurve {
                label,
                colour,
                marker,
                stroke,
                points,
            });
        }
        if let [law] = laws.as_mut_slice() {
            (law.label, law.colour) = ("theory".into(), "var(--ink)".into());
        }
        // Measured curves are drawn above theory.
        chart.curves = laws.into_iter().chain(measured).collect();
        chart
    }
}

/// Returns the colour with index `place` out of `count` in the scale from dark to bright, a CSS
/// value.
fn shade(place: usize, count: usize) -> String {
    let last = count.saturating_sub(1).max(1);
    format!("var(--shade-{})", (place * (SHADES - 1) + last / 2) / last)
}

/// Draws a map of a quantity for each panel, with common colours. Keys that would distinguish
/// curves become panels.
fn maps(
    table: &Table,
    figure: &Figure,
    rows: &[&[TableCell]],
    mut panels: Vec<usize>,
) -> Option<Drawn> {
    let (x, y) = (
        table.find_column(&figure.x.column)?,
        table.find_column(&figure.y.column)?,
    );
    let first = || {
        table
            .columns
            .iter()
            .position(|column| column.role == Role::Value)
    };
    let coloured = match &figure.colour {
        Some(axis) => table.find_column(&axis.column)?,
        None => first()?,
    };
    let keys = find_columns(table, &figure.curves);
    panels.extend(
        keys.iter()
            .filter(|key| !figure.panels.contains(&table.columns[**key].name)),
    );
    let scale = figure
        .colour
        .as_ref()
        .map_or(AxisScale::Linear, |axis| axis.scale);
    let name = &table.columns[coloured].name;
    let label = figure.colour.as_ref().map_or(name, |axis| &axis.label);
    let place =
        |row: &&[TableCell]| Some([row[x].number()?, row[y].number()?, row[coloured].number()?]);
    let maps = groups(rows, &panels).into_iter().map(|group| {
        let map = Map {
            labels: [&figure.x, &figure.y].map(|axis| axis.label.to_string()),
            value: label.to_string(),
            units: [x, y, coloured].map(|column| table.columns[column].unit.to_string()),
            scale,
            cells: group.rows.iter().filter_map(place).collect(),
        };
        (title(table, &panels, &group.keys), map)
    });
    let maps: Vec<(String, Map)> = maps.filter(|(_, map)| map.range().is_some()).collect();
    let shown = spread(&maps, PANELS);
    let ranges = shown.iter().filter_map(|(_, map)| map.range());
    let range = ranges.reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)))?;
    let count = shown.len();
    let drawn = shown.into_iter().map(|(of, map)| {
        let comma = if of.is_empty() { "" } else { ", " };
        let title = format!("{label}{comma}{of}");
        let description = format!("{}: {title}", figure.title);
        Panel {
            title,
            plot: map.plot(range, description),
            subject: Subject::Map {
                map,
                range,
                obstacles: Vec::new(),
            },
        }
    });
    Some(Drawn {
        legend: vec![],
        common: true,
        panels: drawn.collect(),
        note: left_out(count, maps.len()),
    })
}
