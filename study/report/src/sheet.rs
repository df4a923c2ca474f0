//! Standalone SVG file of a figure: panels with titles below a legend, in the colours for print.

use maud::{Markup, PreEscaped, html};

use crate::chart::ChartCurve;
use crate::draw::{WIDTH, sign};
use crate::figure::{Drawn, Panel};
use crate::page::{PALETTE, PLOT};

/// Gap between the panels of the figure \[px\].
const GAP: f64 = 16.0;
/// Height of a line of text in the drawing \[px\].
const LINE: f64 = 20.0;
/// Approximate width of a letter of text \[px\].
const LETTER: f64 = 6.6;

/// Builds the standalone SVG file of a figure; `title` is also its text for screen readers.
pub(crate) fn sheet(title: &str, drawn: &Drawn) -> String {
    let columns = match drawn.panels.len() {
        1 => 1,
        2 | 4 => 2,
        _ => 3,
    };
    let width = columns as f64 * (WIDTH + GAP) - GAP;
    let (legend, mut top) = legend(&drawn.legend, width);
    let mut panels: Vec<Markup> = Vec::new();
    for row in drawn.panels.chunks(columns) {
        let titled = row.iter().any(|panel| !panel.title.is_empty());
        let above = if titled { LINE } else { 0.0 };
        for (place, Panel { title, plot, .. }) in row.iter().enumerate() {
            let left = place as f64 * (WIDTH + GAP);
            panels.push(html! {
                @if !title.is_empty() {
                    text x=(format!("{:.0}", left + 0.5 * WIDTH)) y=(format!("{:.0}", top + 14.0))
                        text-anchor="middle" font-size="13" font-weight="600" { (title) }
                }
                (plot.placed(left, top + above))
            });
        }
        let heights = row.iter().map(|panel| panel.plot.height);
        top += above + heights.fold(0.0, f64::max) + GAP;
    }
    let page = html! {
        svg xmlns="http://www.w3.org/2000/svg" viewBox=(format!("0 0 {width:.0} {top:.0}")) width=(format!("{width:.0}"))
            height=(format!("{top:.0}")) font-family="system-ui, 'Noto Sans', 'DejaVu Sans', sans-serif" fill="var(--ink)" {
            title { (title) }
            style { (PreEscaped(PLOT)) }
            rect width="100%" height="100%" fill="var(--paper)" {}
            (legend)
            @for panel in &panels { (panel) }
        }
    };
    on_paper(&page.into_string())
}

/// Draws the legend broken into lines of the given width, and returns its height, too \[px\].
fn legend(curves: &[ChartCurve], width: f64) -> (Markup, f64) {
    let (mut x, mut y) = (6.0, 6.0);
    let mut items: Vec<Markup> = Vec::new();
    for curve in curves {
        let wide = 56.0 + LETTER * curve.label.chars().count() as f64;
        if x > 6.0 && x + wide > width {
            (x, y) = (6.0, y + LINE);
        }
        items.push(html! {
            svg x=(format!("{x:.0}")) y=(format!("{y:.0}")) width="34" height="12" { (sign(curve)) }
            text x=(format!("{:.0}", x + 39.0)) y=(format!("{:.0}", y + 10.0)) font-size="12" { (curve.label) }
        });
        x += wide;
    }
    let end = if curves.is_empty() { 0.0 } else { y + LINE };
    (html! { @for item in &items { (item) } }, end)
}

/// Replaces CSS custom properties by print colours in SVG text, since drawing programs do not know
/// them.
pub(crate) fn on_paper(text: &str) -> String {
    let first = PALETTE.split_once(":root{").map_or("", |(_, rest)| rest);
    let first = first.split_once('}').map_or("", |(block, _)| block);
    let colours = first
        .split(';')
        .filter_map(|one| one.trim().split_once(':'));
    let colours = colours.filter(|(name, _)| name.starts_with("--"));
    colours.fold(text.to_owned(), |text, (name, value)| {
        text.replace(&format!("var({name})"), value)
    })
}

#[cfg(test)]
mod tests {
    use stosszahl_results::AxisScale;

    use super::*;
    use crate::chart::{Chart, ChartAxis};
    use crate::draw::Plot;
    use crate::figure::Subject;

    #[test]
    fn a_sheet_needs_no_style_sheet() {
        let plot = Plot {
            description: "a".into(),
            height: 310.0,
            content: html! { path style="stroke:var(--engine-3)" {} },
            data: serde_json::Value::Null,
        };
        let axis = || ChartAxis::new("x", AxisScale::Linear);
        let panel = |title: &str| Panel {
            title: title.into(),
            plot: plot.clone(),
            subject: Subject::Chart(Chart::new(axis(), axis())),
        };
        let drawn = Drawn {
            legend: vec![],
            panels: ["", "b & c"].map(panel).into(),
            common: true,
            note: String::new(),
        };
        let text = sheet("x < y", &drawn);
        assert!(!text.contains("var("), "{text}");
        assert!(text.contains("stroke:#a2438a") && text.contains("b &amp; c"));
        assert!(
            text.starts_with("<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 896 346\"")
        );
    }
}
