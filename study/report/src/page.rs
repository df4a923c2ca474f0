//! Building blocks of HTML report pages: the document, tables, figures, verdicts.

use maud::{DOCTYPE, Markup, PreEscaped, html};
use serde_json::{Value, json};
use stosszahl_results::{Role, Table, TableCell, VerdictKind, VerdictText};

use crate::draw::sign;
use crate::figure::{Drawn, cell_text};
use crate::words::with_error;

/// CSS colours of pages and drawings.
pub(crate) const PALETTE: &str = include_str!("palette.css");
/// CSS style of drawings.
pub(crate) const PLOT: &str = include_str!("plot.css");
/// CSS style sheet of all pages.
const STYLE: &str = include_str!("style.css");
/// JavaScript library for interactive charts (uPlot), with its style and licence.
const LIBRARY: [&str; 3] = [
    include_str!("../vendor/uplot/uPlot.iife.min.js"),
    include_str!("../vendor/uplot/uPlot.min.css"),
    include_str!("../vendor/uplot/LICENSE"),
];
/// JavaScript that makes figures interactive.
const FIGURES: &str = include_str!("figures.js");
/// Largest number of table rows shown on a page; the file has all rows.
const ROWS: usize = 300;
/// Largest number of lines of a case file that are shown without collapsing.
const LINES: usize = 60;

/// Column of a list on a page: its name, and true if it holds words.
pub type ListColumn<'a> = (&'a str, bool);

/// Builds a whole HTML page around its content, without any external resource. Scripts are included
/// only if the content needs them.
pub(crate) fn document(title: &str, content: &Markup, scripts: &[&str]) -> String {
    // Saved pictures are drawn from data inside the page.
    let policy = "default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'; img-src data: blob:";
    let interactive = content.0.contains("class=\"interactive\"");
    let [library, library_style, licence] = LIBRARY;
    let page = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                meta http-equiv="Content-Security-Policy" content=(policy);
                title { (title) }
                @if interactive { style { (PreEscaped(library_style)) } }
                style { (PreEscaped(PALETTE)) (PreEscaped(STYLE)) }
                style id="drawing" { (PreEscaped(PLOT)) }
            }
            body {
                main { (content) }
                @if interactive {
                    script { "/*!\n" (PreEscaped(licence)) "*/\n" (PreEscaped(library)) }
                    script { (PreEscaped(FIGURES)) }
                }
                @for script in scripts { script { (PreEscaped(script)) } }
            }
        }
    };
    page.into_string()
}

/// Embeds data for a script in a page, as JSON that cannot close the element around it.
pub(crate) fn data(value: &Value) -> Markup {
    PreEscaped(value.to_string().replace('<', "\\u003c"))
}

/// Builds an HTML table that scrolls if it is wider than the page.
pub fn table(columns: &[ListColumn<'_>], rows: &[Vec<String>]) -> Markup {
    let class = |words: bool| words.then_some("text");
    let cell_class = |words: bool, cell: &str| match words {
        true if cell.chars().count() > 40 => Some("text long"),
        words => class(words),
    };
    html! {
        div.scroll { table {
            thead { tr { @for (name, words) in columns { th class=[class(*words)] scope="col" { (name) } } } }
            tbody { @for row in rows { tr {
                @for (cell, (_, words)) in row.iter().zip(columns) {
                    td class=[cell_class(*words, cell)] { (cell) }
                }
            } } }
        } }
    }
}

/// Builds the HTML of a figure: legend, panels, caption, and the data for the interactive chart.
pub(crate) fn figure(number: usize, title: &str, caption: &str, drawn: &Drawn) -> Markup {
    let arrangement = match drawn.panels.len() {
        1 => "one",
        2 | 4 => "two",
        _ => "many",
    };
    let title = title.trim_end_matches('.');
    let panels: Vec<Value> = (drawn.panels.iter())
        .map(|panel| json!({ "title": panel.title, "plot": panel.plot.data }))
        .collect();
    let behind =
        json!({ "title": title, "number": number, "common": drawn.common, "panels": panels });
    html! {
        figure.interactive {
            @if !drawn.legend.is_empty() {
                div.legend { @for curve in &drawn.legend {
                    span data-curve=(curve.label) {
                        svg viewBox="0 0 34 12" aria-hidden="true" { (sign(curve)) } (curve.label)
                    }
                } }
            }
            div.panels.(arrangement) { @for panel in &drawn.panels {
                div.panel { @if !panel.title.is_empty() { h4 { (panel.title) } } (panel.plot.inline()) }
            } }
            figcaption { b { "Figure " (number) ". " (title) "." } " " (caption) (drawn.note) }
            script type="application/json" { (data(&behind)) }
        }
    }
}

/// Builds a collapsed HTML table of a result table, with the meaning of its columns.
pub(crate) fn folded(source: &Table) -> Markup {
    // A standard error is shown in the cell of its value.
    let places: Vec<usize> = (0..source.columns.len())
        .filter(|place| *place == 0 || source.columns[*place].role != Role::StandardError)
        .collect();
    let error = |place: usize| {
        let next = source.columns.get(place + 1)?;
        (next.role == Role::StandardError).then_some(place + 1)
    };
    let cell = |row: &[TableCell], place: usize| match (row[place].number(), error(place)) {
        (Some(value), Some(error)) => with_error(value, row[error].number()),
        _ => cell_text(&source.columns[place].name, &row[place]),
    };
    let columns: Vec<ListColumn<'_>> = places
        .iter()
        .map(|place| {
            (
                &*source.columns[*place].name,
                source.columns[*place].unit.is_empty(),
            )
        })
        .collect();
    let rows: Vec<Vec<String>> = (source.rows.iter().take(ROWS))
        .map(|row| places.iter().map(|place| cell(row, *place)).collect())
        .collect();
    let count = source.rows.len();
    html! {
        details {
            summary { "Table " code { (source.file()) } ", " (count) @if count == 1 { " row" } @else { " rows" } }
            p { (source.about) @if count > ROWS { " The first " (ROWS) " rows; the file has all." } }
            (table(&columns, &rows))
            dl { @for column in &source.columns {
                dt { code { (column.name) } @if !["", "1"].contains(&&*column.unit) { " [" (column.unit) "]" } }
                dd { (column.meaning) }
            } }
        }
    }
}

/// Builds the HTML list of verdicts, each with its kind as a word in a colour.
pub(crate) fn verdicts(verdicts: &[&VerdictText]) -> Markup {
    html! {
        ul.verdicts { @for verdict in verdicts {
            li {
                (kind(verdict.kind))
                span { strong { (verdict.topic) } ": " (unbroken(&verdict.sentence)) }
            }
        } }
    }
}

/// Builds the HTML of the verdict that answers the question of a case.
pub(crate) fn headline(verdict: &VerdictText) -> Markup {
    html! { p.headline {
        (kind(verdict.kind)) " "
        // Informative numbers need the topic, which names the quantity.
        @if verdict.kind == VerdictKind::Note { (verdict.topic) ": " }
        (unbroken(&verdict.sentence))
    } }
}

/// Inserts non-breaking spaces, so that numbers stay on one line with their errors and units.
pub(crate) fn unbroken(sentence: &str) -> String {
    sentence
        .replace(" ± ", "\u{a0}±\u{a0}")
        .replace(" %", "\u{a0}%")
}

/// Builds the HTML of the kind of a verdict: a word with a symbol, in its colour.
pub(crate) fn kind(kind: VerdictKind) -> Markup {
    let sign = match kind {
        VerdictKind::Agree => "✓",
        VerdictKind::Differ => "≠",
        VerdictKind::Undecided => "?",
        VerdictKind::Warning => "!",
        VerdictKind::Note => "·",
        VerdictKind::Void => "∅",
    };
    html! { span.kind.(kind.name()) { (sign) " " (kind.name()) } }
}

/// Builds the HTML box of warnings; empty without any.
pub(crate) fn warnings(warnings: &[Markup]) -> Markup {
    html! {
        @if !warnings.is_empty() {
            div.warnings role="alert" { strong { "Warnings" } ul { @for warning in warnings { li { (warning) } } } }
        }
    }
}

/// Builds the HTML of a case file, collapsed if it is long.
pub(crate) fn case_file(text: &str) -> Markup {
    html! {
        h2 { "Case file" }
        @if text.lines().count() > LINES {
            details { summary { "Case file, " (text.lines().count()) " lines" } pre { (text) } }
        } @else { pre { (text) } }
    }
}
