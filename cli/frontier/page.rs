//! The report of a frontier: plots of error against cost, the front in a table, and the orders.

use std::fmt::Write as _;

use maud::{Markup, PreEscaped, html};

use super::front::{FrontierRow, largest};
use super::orders::{OrderRow, Verdict};
use super::quantity::Kind;
use crate::report::figures::{engine_colour, engine_mark, engine_name, engines};
use crate::report::page::{Column, document, swatch, table};
use crate::report::plot::{Axis, Chart, Curve, Label, Point, Stroke};
use crate::words::{percent, time};

/// What the report is made of.
pub(crate) struct Page<'a> {
    /// Title of the case.
    pub(crate) title: &'a str,
    /// All rows.
    pub(crate) rows: &'a [FrontierRow],
    /// All sequences.
    pub(crate) orders: &'a [OrderRow],
    /// Provenance, what was left out, recommendations.
    pub(crate) sentences: &'a [String],
    /// The target error.
    pub(crate) target: f64,
}

impl Page<'_> {
    /// Rows of the worst quantity of a kind.
    fn of(&self, kind: Kind) -> Vec<&FrontierRow> {
        let name = largest(kind);
        self.rows
            .iter()
            .filter(|row| row.quantity == name)
            .collect()
    }

    /// The front of a kind, by cost.
    fn front(&self, kind: Kind) -> Vec<&FrontierRow> {
        let mut front = self.of(kind);
        front.retain(|row| row.on_front);
        front.sort_by(|a, b| a.core_seconds.total_cmp(&b.core_seconds));
        front
    }
}

/// The plot of one kind, with its labels: single runs of all settings as marks, the front as a line.
fn chart(page: &Page<'_>, kind: Kind) -> Option<(Chart, Vec<Label>)> {
    let rows = page.of(kind);
    let names = engines(
        rows.iter()
            .map(|row| row.engine.to_owned())
            .collect::<Vec<_>>()
            .iter(),
    );
    let point = |row: &FrontierRow| Point {
        x: row.core_seconds,
        y: row.error,
        error: None,
    };
    let mut curves: Vec<Curve> = names
        .iter()
        .map(|name| Curve {
            label: engine_name(name),
            colour: engine_colour(name),
            mark: Some(engine_mark(name)),
            stroke: Stroke::None,
            points: rows
                .iter()
                .filter(|row| row.replicas == 1 && row.engine == name)
                .map(|row| Point {
                    // Half the range, for the bars are symmetric.
                    error: Some(0.5 * (row.error_high - row.error_low)),
                    ..point(row)
                })
                .collect(),
        })
        .collect();
    let front = page.front(kind);
    curves.push(Curve {
        label: "front, with replicas".to_owned(),
        colour: "var(--ink)".to_owned(),
        mark: None,
        stroke: Stroke::Solid,
        points: front.iter().map(|row| point(row)).collect(),
    });
    let labels = front.iter().zip(1..).map(|(row, place)| Label {
        text: place.to_string(),
        x: row.core_seconds,
        y: 0.8 * row.error,
    });
    let chart = Chart {
        x: Axis::logarithmic("core time [s]"),
        y: Axis::logarithmic(&format!("error of {}", kind.name())),
        curves,
        level: Some(page.target),
    };
    let labels = labels.collect();
    (!chart.is_empty()).then_some((chart, labels))
}

const FRONT: [Column; 7] = [
    ("number", false),
    ("setting", true),
    ("replicas", false),
    ("core time", false),
    ("error", false),
    ("systematic", false),
    ("statistical, one run", false),
];

fn front_cells(row: &FrontierRow, place: usize) -> Vec<String> {
    vec![
        place.to_string(),
        row.setting.clone(),
        row.replicas.to_string(),
        time(row.core_seconds),
        format!(
            "{} ({} to {})",
            percent(row.error),
            percent(row.error_low),
            percent(row.error_high)
        ),
        format!(
            "{} ± {}",
            percent(row.systematic_error),
            percent(row.systematic_error_se)
        ),
        percent(row.statistical_error),
    ]
}

const ORDERS: [Column; 8] = [
    ("sequence", true),
    ("settings", false),
    ("quantity", true),
    ("t/t0", false),
    ("order by theory", false),
    ("order found", false),
    ("limit less reference", false),
    ("verdict", true),
];

fn order_cells(row: &OrderRow) -> Vec<String> {
    let found = match (row.found_order, row.found_order_low, row.found_order_high) {
        (Some(order), Some(low), Some(high)) => format!("{order:.1} ({low:.1} to {high:.1})"),
        _ => "-".to_owned(),
    };
    vec![
        row.sequence.to_owned(),
        format!("{}, h ≤ {}", row.settings, row.coarsest),
        row.quantity.to_owned(),
        format!("{:.3}", row.time_over_t0),
        row.order.to_string(),
        found,
        format!(
            "{} ± {}",
            percent(row.limit_error),
            percent(row.limit_error_se)
        ),
        row.verdict.name().to_owned(),
    ]
}

fn section(page: &Page<'_>, kind: Kind, number: usize) -> Markup {
    let Some((chart, labels)) = chart(page, kind) else {
        return html! {};
    };
    let description = format!("error of {} against core time", kind.name());
    let front: Vec<Vec<String>> = page
        .front(kind)
        .iter()
        .zip(1..)
        .map(|(row, place)| front_cells(row, place))
        .collect();
    html! {
        h2 { (kind.name()) }
        figure {
            div.legend { @for curve in &chart.curves { span { (swatch(curve)) (curve.label) } } }
            div.panels.one { div { (PreEscaped(chart.labelled_svg(number, 1, &description, &labels))) } }
            figcaption {
                b { "Figure " (number) ". Error of " (kind.name()) " against core time." }
                " Marks are single runs of each setting, with half the 95 % range of their error; the line is the front of all settings with "
                "1, 4, 16 and 64 replicas, its numbers those of the table. Dashed: the target. Of several times, the one with the largest "
                "error counts."
            }
        }
        (table("Front", &FRONT, &front))
    }
}

/// The whole page.
pub(crate) fn html(page: &Page<'_>) -> String {
    let title = format!("Speed against error: {}", page.title);
    let orders: Vec<Vec<String>> = page.orders.iter().map(order_cells).collect();
    let content = html! {
        h1 { (title) }
        @for sentence in page.sentences { p { (sentence.replace("**", "")) } }
        @for (kind, number) in Kind::ALL.into_iter().zip(1..) { (section(page, kind, number)) }
        h2 { "Orders" }
        (table("Orders", &ORDERS, &orders))
    };
    document(&title, &content, None)
}

fn markdown_table(columns: &[Column], rows: &[Vec<String>]) -> String {
    let line = |cells: Vec<&str>| format!("| {} |\n", cells.join(" | "));
    let mut text = line(columns.iter().map(|column| column.0).collect());
    text += &line(columns.iter().map(|_| "---").collect());
    for row in rows {
        text += &line(row.iter().map(String::as_str).collect());
    }
    text
}

/// The words, the front of the energy, and the orders that do not hold or are not seen, in Markdown.
pub(crate) fn markdown(page: &Page<'_>) -> String {
    let mut text = format!("# Speed against error: {}\n\n", page.title);
    for sentence in page.sentences {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{sentence}\n");
    }
    let front: Vec<Vec<String>> = page
        .front(Kind::Energy)
        .iter()
        .zip(1..)
        .map(|(row, place)| front_cells(row, place))
        .collect();
    let _ = writeln!(
        text,
        "## Front of the energy\n\n{}",
        markdown_table(&FRONT, &front)
    );
    let count = |verdict| {
        page.orders
            .iter()
            .filter(|row| row.verdict == verdict)
            .count()
    };
    let _ = writeln!(
        text,
        "## Orders\n\nOf {} sequences and quantities, the order of theory holds in {}, does not hold in {}, and in {} no error is seen.\n",
        page.orders.len(),
        count(Verdict::Holds),
        count(Verdict::DoesNotHold),
        count(Verdict::NotSeen),
    );
    let seen: Vec<Vec<String>> = page
        .orders
        .iter()
        .filter(|row| row.verdict != Verdict::NotSeen)
        .map(order_cells)
        .collect();
    text + &markdown_table(&ORDERS, &seen)
}
