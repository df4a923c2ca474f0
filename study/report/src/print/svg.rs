//! SVG output of a drawing: plain paths, text as outlines, no external resources.

use std::fmt::Write as _;

use maud::{Markup, PreEscaped, html};

use super::canvas::{Canvas, Colour, Item, Pen, Segment, Text};
use super::font::Fonts;

/// Length of one point \[mm\].
pub(crate) const POINT: f64 = 25.4 / 72.0;

/// Writes a drawing as an SVG file whose unit is the point; `title` describes it.
pub(crate) fn write(canvas: &Canvas, fonts: &Fonts, title: &str) -> String {
    let [width, height] = canvas.size;
    let view = format!(
        "0 0 {} {}",
        format_coordinate(width),
        format_coordinate(height)
    );
    let millimetres = |length: f64| format!("{}mm", format_coordinate(length * POINT));
    let page = html! {
        svg xmlns="http://www.w3.org/2000/svg" width=(millimetres(width)) height=(millimetres(height)) viewBox=(view) role="img"
            aria-label=(title) fill="none" stroke-linejoin="round" {
            title { (title) } "\n"
            rect width=(format_coordinate(width)) height=(format_coordinate(height)) fill="#ffffff" {} "\n"
            @for item in &canvas.items { (one(item, fonts)) "\n" }
        }
    };
    format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n{}\n",
        page.into_string()
    )
}

fn one(item: &Item, fonts: &Fonts) -> Markup {
    match item {
        Item::Path {
            segments,
            fill,
            pen,
        } => html! {
            path d=(path_data(segments, |at| at)) fill=[fill.map(hex)] stroke=[pen.map(|pen| hex(pen.colour))]
                stroke-width=[pen.map(|pen| format_coordinate(pen.width))] stroke-dasharray=[pen.and_then(dashes)] {}
        },
        Item::Text(text) => {
            // The words are kept for readers of the file, and for screen readers.
            let words: String = text.glyphs.iter().map(|glyph| glyph.letter).collect();
            html! { path aria-label=(words) d=(text_outlines(text, fonts)) fill="#000000" {} }
        }
    }
}

/// Returns the glyph outlines of a line of text as the data of one SVG path.
fn text_outlines(text: &Text, fonts: &Fonts) -> PreEscaped<String> {
    let mut path = String::new();
    for glyph in &text.glyphs {
        let segments = fonts.outline(glyph.font, glyph.id);
        path += &path_data(&segments, |[x, y]| {
            let along = glyph.at[0] + glyph.size * x;
            let above = glyph.at[1] + glyph.size * y;
            if text.upwards {
                [text.at[0] - above, text.at[1] - along]
            } else {
                [text.at[0] + along, text.at[1] - above]
            }
        })
        .0;
    }
    PreEscaped(path)
}

/// Returns the data of an SVG path, with each point transformed by `place`.
fn path_data(segments: &[Segment], place: impl Fn([f64; 2]) -> [f64; 2]) -> PreEscaped<String> {
    let pair = |at: [f64; 2]| {
        let [x, y] = place(at).map(format_coordinate);
        format!("{x} {y}")
    };
    let mut path = String::new();
    for segment in segments {
        // Writing to a string cannot fail.
        let _ = match segment {
            Segment::Move(at) => write!(path, "M{}", pair(*at)),
            Segment::Line(at) => write!(path, "L{}", pair(*at)),
            Segment::Curve(one, two, at) => {
                write!(path, "C{} {} {}", pair(*one), pair(*two), pair(*at))
            }
            Segment::Close => write!(path, "Z"),
        };
    }
    PreEscaped(path)
}

fn dashes(pen: Pen) -> Option<String> {
    let lengths: Vec<String> = pen.dash.iter().copied().map(format_coordinate).collect();
    (!lengths.is_empty()).then(|| lengths.join(" "))
}

fn hex([red, green, blue]: Colour) -> String {
    format!("#{red:02x}{green:02x}{blue:02x}")
}

/// Formats a coordinate \[pt\] with two decimals, which is 4 µm, without trailing zeros.
fn format_coordinate(value: f64) -> String {
    let text = format!("{value:.2}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" {
        "0".into()
    } else {
        text.into()
    }
}
