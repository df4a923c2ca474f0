//! Curve styles for print that differ in colour and in grey: markers, filled or open, and dashes.

use crate::chart::{ChartCurve, Marker, Stroke};
use crate::sheet::on_paper;

use super::canvas::{BLACK, Colour, Pen, Segment, WHITE};

/// Line width of frames and ticks \[pt\].
pub(crate) const FRAME: f64 = 0.6;
/// Line width of curves whose values are read off, such as theory \[pt\].
const LINE: f64 = 0.9;
/// Line width of error bars, marker outlines, and lines between markers \[pt\].
pub(crate) const THIN: f64 = 0.6;
/// Half the width of a data marker \[pt\].
pub(crate) const MARKER: f64 = 1.8;
/// Dash patterns of lines without markers \[pt\], in the order of use.
const DASHES: [&[f64]; 8] = [
    &[],
    &[4.0, 2.0],
    &[1.0, 1.5],
    &[6.0, 1.6, 1.0, 1.6],
    &[2.0, 1.2],
    &[8.0, 2.0],
    &[6.0, 1.6, 1.0, 1.6, 1.0, 1.6],
    &[8.0, 2.0, 2.0, 2.0],
];

/// Largest number of theory curves with dashes and legend entries of their own.
const SEPARATE: usize = 3;

/// Style of one curve in all panels and in the legend.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct CurveStyle {
    /// Name of the curve in the legend.
    pub label: String,
    /// Colour of the lines and markers of the curve.
    pub colour: Colour,
    /// Marker of the curve, and true if it is open.
    pub marker: Option<(Marker, bool)>,
    /// Pen of the curve's line; `None` without a line.
    pub pen: Option<Pen>,
    /// Fill colour of histogram bars.
    pub bars: Option<Colour>,
}

impl CurveStyle {
    /// Returns the pen of the curve's error bars.
    pub fn error(&self) -> Pen {
        Pen::solid(THIN, self.colour)
    }

    /// Returns the marker at a point: its path and its fill colour.
    pub fn mark(&self, at: [f64; 2]) -> Option<(Vec<Segment>, Colour)> {
        let (marker, open) = self.marker?;
        let fill = if open { WHITE } else { self.colour };
        Some((outline(marker, at), fill))
    }
}

/// Assigns a style to each curve of a legend, different from all others.
pub(crate) fn styles(legend: &[ChartCurve]) -> Vec<CurveStyle> {
    let bars = legend
        .iter()
        .filter(|one| one.stroke == Stroke::Bars)
        .count();
    let many = theories(legend) > SEPARATE;
    let (mut dashed, mut lines, mut steps, mut markers) = (0, 0, 0, Vec::new());
    let style = |curve: &ChartCurve| {
        let colour = print_colour(&curve.colour);
        let marker = match curve.stroke {
            Stroke::Dashed | Stroke::Bars => None,
            // Steps have markers at their middles.
            Stroke::Solid => {
                steps += 1;
                let number = engine_number(&curve.colour).unwrap_or(steps - 1);
                Some(Marker::ALL[number % Marker::ALL.len()])
            }
            Stroke::None | Stroke::Thin => curve.marker,
        };
        let marker = marker.map(|marker| {
            let before = markers.iter().filter(|one| **one == marker).count();
            markers.push(marker);
            (marker, before % 2 == 1)
        });
        let next = |count: &mut usize, first: usize| {
            let dash = DASHES[first + *count % (DASHES.len() - first)];
            *count += 1;
            dash
        };
        let pen = match curve.stroke {
            Stroke::None => None,
            _ if marker.is_some() => Some(Pen::solid(THIN, colour)),
            stroke => Some(Pen {
                width: LINE,
                colour,
                dash: match stroke {
                    Stroke::Dashed if many && is_theory(curve) => DASHES[1],
                    // Theory is never solid.
                    Stroke::Dashed => next(&mut dashed, 1),
                    _ => next(&mut lines, 0),
                },
            }),
        };
        CurveStyle {
            label: curve.label.clone(),
            colour,
            marker,
            pen,
            // Several histograms would hide each other.
            bars: (curve.stroke == Stroke::Bars && bars == 1).then(|| light(colour)),
        }
    };
    legend.iter().map(style).collect()
}

/// Returns the index of the engine that has this CSS colour, which decides its marker in all
/// figures.
fn engine_number(css: &str) -> Option<usize> {
    let number = css.strip_prefix("var(--engine-")?;
    number.strip_suffix(')')?.parse().ok()
}

/// Returns true if a curve is the theory that belongs to one of several measured curves.
fn is_theory(curve: &ChartCurve) -> bool {
    curve.stroke == Stroke::Dashed && curve.label.starts_with("theory, ")
}

fn theories(legend: &[ChartCurve]) -> usize {
    legend.iter().filter(|curve| is_theory(curve)).count()
}

/// Returns the legend entries with their styles, for curves with names. Many theory curves share
/// one entry, since each lies next to the data of its colour.
pub(crate) fn entries(legend: &[ChartCurve], styles: &[CurveStyle]) -> Vec<(Stroke, CurveStyle)> {
    let both = legend.iter().zip(styles);
    let all = both.map(|(curve, style)| (curve.stroke, style.clone()));
    if theories(legend) <= SEPARATE {
        return all.collect();
    }
    let own = legend
        .iter()
        .zip(all)
        .filter(|(curve, _)| !is_theory(curve));
    let theory = CurveStyle {
        label: "theory".into(),
        pen: Some(Pen {
            dash: DASHES[1],
            ..Pen::solid(LINE, BLACK)
        }),
        ..CurveStyle::default()
    };
    let theory = std::iter::once((Stroke::Dashed, theory));
    theory.chain(own.map(|(_, entry)| entry)).collect()
}

/// Converts a CSS colour of the report pages to the colour in print; black if it is unknown.
fn print_colour(css: &str) -> Colour {
    let text = on_paper(css);
    let part = |place: usize| {
        let digits = text.strip_prefix('#')?.get(2 * place..2 * place + 2)?;
        u8::from_str_radix(digits, 16).ok()
    };
    match (part(0), part(1), part(2)) {
        (Some(red), Some(green), Some(blue))
            if css.starts_with("var(--engine") || css.starts_with("var(--shade") =>
        {
            [red, green, blue]
        }
        _ => BLACK,
    }
}

fn light(colour: Colour) -> Colour {
    colour.map(|part| 255 - (255 - part) / 6)
}

/// Returns the outline path of a marker around a point.
fn outline(marker: Marker, [x, y]: [f64; 2]) -> Vec<Segment> {
    let corners = |all: &[[f64; 2]]| {
        let mut path: Vec<Segment> = (all.iter().enumerate())
            .map(|(place, [a, b])| {
                let at = [x + a * MARKER, y + b * MARKER];
                if place == 0 {
                    Segment::Move(at)
                } else {
                    Segment::Line(at)
                }
            })
            .collect();
        path.push(Segment::Close);
        path
    };
    match marker {
        Marker::Circle => circle([x, y], MARKER),
        Marker::Square => corners(&[[-0.88, -0.88], [0.88, -0.88], [0.88, 0.88], [-0.88, 0.88]]),
        Marker::Triangle => corners(&[[0.0, -1.2], [1.1, 0.75], [-1.1, 0.75]]),
        Marker::Diamond => corners(&[[0.0, -1.25], [1.25, 0.0], [0.0, 1.25], [-1.25, 0.0]]),
        Marker::Inverted => corners(&[[0.0, 1.2], [1.1, -0.75], [-1.1, -0.75]]),
    }
}

/// Returns the path of a circle as four cubic curves; the error of its radius is below 0.03 %.
fn circle([x, y]: [f64; 2], radius: f64) -> Vec<Segment> {
    // 4/3 tan(π/8).
    let k = 0.552_284_75 * radius;
    let r = radius;
    vec![
        Segment::Move([x + r, y]),
        Segment::Curve([x + r, y + k], [x + k, y + r], [x, y + r]),
        Segment::Curve([x - k, y + r], [x - r, y + k], [x - r, y]),
        Segment::Curve([x - r, y - k], [x - k, y - r], [x, y - r]),
        Segment::Curve([x + k, y - r], [x + r, y - k], [x + r, y]),
        Segment::Close,
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Curves of one marker, and lines without one, differ without their colours.
    #[test]
    fn curves_differ_in_grey() {
        let curve = |place: usize, stroke: Stroke| ChartCurve {
            label: format!("{place}"),
            colour: format!("var(--engine-{})", place % 8),
            marker: (stroke == Stroke::Thin).then_some(Marker::ALL[place % 5]),
            stroke,
            points: vec![],
        };
        let mut legend: Vec<ChartCurve> = (0..8).map(|place| curve(place, Stroke::Thin)).collect();
        legend.extend((8..15).map(|place| curve(place, Stroke::Dashed)));
        let found = styles(&legend);
        let grey = |style: &CurveStyle| (style.marker, style.pen.map(|pen| pen.dash));
        for (place, one) in found.iter().enumerate() {
            assert!(
                found[..place].iter().all(|other| grey(other) != grey(one)),
                "{one:?}"
            );
        }
        assert!(
            found[8..]
                .iter()
                .all(|one| one.pen.is_some_and(|pen| !pen.dash.is_empty()))
        );
        assert_eq!(entries(&legend, &found).len(), legend.len());
        for curve in &mut legend[8..] {
            curve.label.insert_str(0, "theory, ");
        }
        let shown = entries(&legend, &styles(&legend));
        assert_eq!((shown.len(), &*shown[0].1.label), (9, "theory"));
        assert_eq!(found[0].colour, [0, 0x60, 0xa8]);
        assert_eq!(print_colour("var(--ink)"), BLACK);
    }
}
