//! SVG drawing of charts for report pages: axes, curves, markers and legends.
//!
//! The alternative of a plotting library lost: static figures of reports take a few hundred lines
//! here. The libraries that were tried doubled the build time, numbered clip paths globally and
//! drew legends over data.

use std::fmt::Write as _;

use maud::{Markup, html};
use serde_json::Value;

use crate::chart::{Chart, ChartCurve, ChartPoint, Stroke};
use crate::scale::{AxisRange, Tick};

/// Width of a chart on the page \[px\].
pub(crate) const WIDTH: f64 = 440.0;
/// Height of a chart on the page \[px\].
pub(crate) const HEIGHT: f64 = 310.0;
/// Margin left of a chart's frame, for the vertical axis \[px\].
pub(crate) const LEFT: f64 = 62.0;
/// Margin right of a chart's frame \[px\].
pub(crate) const RIGHT: f64 = 14.0;
/// Margin above a chart's frame \[px\].
pub(crate) const TOP: f64 = 10.0;
/// Margin below a chart's frame, for the horizontal axis \[px\].
pub(crate) const BOTTOM: f64 = 46.0;
/// Largest number of points that get markers; a longer curve is drawn as a line.
const MARKS: usize = 60;
/// Largest number of points along a drawn line; longer curves are thinned.
const VERTICES: usize = 600;

/// Returns width and height of the area inside a chart's frame \[px\].
pub(crate) fn chart_size() -> [f64; 2] {
    [WIDTH - LEFT - RIGHT, HEIGHT - TOP - BOTTOM]
}

/// Chart or map drawn as SVG, with its numbers.
#[derive(Clone, Debug)]
pub(crate) struct Plot {
    /// Text description of the drawing for screen readers.
    pub description: String,
    /// Height of the drawing \[px\], for the width [`WIDTH`].
    pub height: f64,
    /// Content of the drawing's SVG element.
    pub content: Markup,
    /// Numbers of the drawing as JSON, for the interactive chart.
    pub data: Value,
}

impl Plot {
    /// Returns the drawing as an SVG element of a page.
    pub fn inline(&self) -> Markup {
        html! {
            svg.plot viewBox=(format!("0 0 {WIDTH} {:.0}", self.height)) role="img" aria-label=(self.description) { (self.content) }
        }
    }

    /// Returns the drawing as an SVG element nested in another one, at a position \[px\].
    pub fn placed(&self, x: f64, y: f64) -> Markup {
        html! {
            svg.plot x=(format!("{x:.0}")) y=(format!("{y:.0}")) width=(WIDTH) height=(format!("{:.0}", self.height)) { (self.content) }
        }
    }
}

/// Draws frame, grid, ticks and axis labels around an area of the given size \[px\].
pub(crate) fn axes(
    [width, height]: [f64; 2],
    [x_ticks, y_ticks]: &[Vec<Tick>; 2],
    [x_label, y_label]: [&str; 2],
    grid: bool,
) -> Markup {
    let (mut lines, mut strokes) = (String::new(), String::new());
    for (place, label) in x_ticks {
        let at = place * width;
        let length = if label.is_some() { 5 } else { 3 };
        // Writing to a string cannot fail.
        let _ = write!(strokes, "M{at:.1} {height:.1}v-{length}");
        if label.is_some() {
            let _ = write!(lines, "M{at:.1} 0V{height:.1}");
        }
    }
    for (place, label) in y_ticks {
        let at = (1.0 - place) * height;
        let length = if label.is_some() { 5 } else { 3 };
        let _ = write!(strokes, "M0 {at:.1}h{length}");
        if label.is_some() {
            let _ = write!(lines, "M0 {at:.1}H{width:.1}");
        }
    }
    let labelled = |ticks: &[Tick]| -> Vec<(f64, String)> {
        let named = ticks
            .iter()
            .filter_map(|(place, label)| Some((*place, label.clone()?)));
        named.collect()
    };
    // Labels that would overlap are left out.
    let mut free = f64::NEG_INFINITY;
    let mut below = labelled(x_ticks);
    below.retain(|(place, label)| {
        let half = 3.4 * label.chars().count() as f64;
        let fits = place * width - half > free;
        if fits {
            free = place * width + half + 2.0;
        }
        fits
    });
    html! {
        g transform=(format!("translate({LEFT} {TOP})")) {
            @if grid { path.grid d=(lines) {} }
            path.axis d=(format!("M0 0H{width:.1}V{height:.1}H0z{strokes}")) {}
            @for (place, label) in &below {
                text.tick x=(format!("{:.1}", place * width)) y=(format!("{:.1}", height + 15.0)) text-anchor="middle" { (label) }
            }
            @for (place, label) in labelled(y_ticks) {
                text.tick x="-6" y=(format!("{:.1}", (1.0 - place) * height + 3.7)) text-anchor="end" { (label) }
            }
            text.label x=(format!("{:.1}", width / 2.0)) y=(format!("{:.1}", height + 37.0)) text-anchor="middle" { (x_label) }
            text.label text-anchor="middle" transform=(format!("translate(-47 {:.1}) rotate(-90)", height / 2.0)) { (y_label) }
        }
    }
}

impl Chart {
    /// Draws the chart as SVG; `description` is its text for screen readers.
    pub(crate) fn plot(&self, description: String) -> Plot {
        let (x, y) = self.frames();
        let ticks = [self.x.ticks(&x), self.y.ticks(&y)];
        let canvas = Canvas {
            x,
            y,
            size: chart_size(),
        };
        Plot {
            description,
            height: HEIGHT,
            content: canvas.chart(
                self,
                &axes(canvas.size, &ticks, [&self.x.label, &self.y.label], true),
            ),
            data: self.data(),
        }
    }
}

/// Coordinate system inside a chart's frame: from values to pixels.
pub(crate) struct Canvas {
    pub x: AxisRange,
    pub y: AxisRange,
    pub size: [f64; 2],
}

impl Canvas {
    /// Draws the curves, reference lines and labels of a chart inside its axes.
    pub fn chart(&self, chart: &Chart, axes: &Markup) -> Markup {
        let [width, height] = self.size;
        let words = chart.words.iter().filter_map(|word| {
            let (x, y) = self.place(word.x, word.y)?;
            Some((x, y, &word.text))
        });
        html! {
            (axes)
            svg x=(LEFT) y=(TOP) width=(width) height=(height) {
                @for (_, level) in &chart.lines {
                    @let at = height * (1.0 - self.y.clamped(*level));
                    path.level d=(format!("M0 {at:.1}H{width:.1}")) {}
                }
                @for curve in &chart.curves { (self.strokes(curve)) }
            }
            g transform=(format!("translate({LEFT} {TOP})")) {
                @for curve in &chart.curves { (self.marks(curve)) }
                @for (x, y, text) in words { text.word x=(format!("{x:.1}")) y=(format!("{y:.1}")) { (text) } }
            }
        }
    }

    fn place(&self, x: f64, y: f64) -> Option<(f64, f64)> {
        let (x, y) = (self.x.position_of(x)?, self.y.position_of(y)?);
        // Far outside is drawn like infinity, and is shorter to write.
        let near = |place: f64| place.clamp(-50.0, 50.0);
        Some((near(x) * self.size[0], (1.0 - near(y)) * self.size[1]))
    }

    /// Draws lines, bars and error bars of a curve, clipped by the frame.
    fn strokes(&self, curve: &ChartCurve) -> Markup {
        let (mut line, mut errors) = (String::new(), String::new());
        let mut joined = false;
        let thinned = crate::words::spread(&curve.points, VERTICES);
        if curve.stroke == Stroke::Bars {
            line = self.bars(&thinned);
        }
        let joints = thinned.iter().filter(|_| curve.stroke != Stroke::Bars);
        for point in joints {
            let Some((x, y)) = self.place(point.x, point.y) else {
                joined = false;
                continue;
            };
            // Writing to a string cannot fail.
            let _ = write!(line, "{}{x:.1} {y:.1}", if joined { 'L' } else { 'M' });
            if point.end > point.x {
                let end = self.place(point.end, point.y).map_or(x, |place| place.0);
                let _ = write!(line, "H{end:.1}");
            }
            joined = true;
        }
        for point in crate::words::spread(&curve.points, MARKS) {
            let error = point
                .error
                .filter(|error| error.is_finite() && *error > 0.0);
            if let (Some(error), Some((x, _)), Some((other, _))) = (
                error,
                self.place(point.x, point.y),
                self.place(point.end, point.y),
            ) {
                let at = |y: f64| (1.0 - self.y.clamped(y)) * self.size[1];
                let (low, high) = (at(point.y - error), at(point.y + error));
                let _ = write!(errors, "M{:.1} {low:.1}V{high:.1}", 0.5 * (x + other));
            }
        }
        let class = curve.stroke.class(curve.points.len() > MARKS);
        html! {
            @if let (Some(class), false) = (class, line.is_empty()) {
                path.(class) d=(line) style=(format!("stroke:{0};fill:{0}", curve.colour)) {}
            }
            @if !errors.is_empty() { path.error d=(errors) style=(format!("stroke:{}", curve.colour)) {} }
        }
    }

    /// Returns the SVG path of histogram bars, drawn upwards from zero.
    fn bars(&self, points: &[ChartPoint]) -> String {
        let mut path = String::new();
        let foot = (1.0 - self.y.clamped(0.0)) * self.size[1];
        for point in points {
            if let (Some((x, y)), Some((end, _))) =
                (self.place(point.x, point.y), self.place(point.end, point.y))
            {
                // Writing to a string cannot fail.
                let _ = write!(path, "M{x:.1} {foot:.1}V{y:.1}H{end:.1}V{foot:.1}");
            }
        }
        path
    }

    /// Draws the markers of a curve, not clipped by the frame.
    fn marks(&self, curve: &ChartCurve) -> Markup {
        let mut path = String::new();
        if let Some(marker) = curve.marker
            && (curve.points.len() <= MARKS || curve.stroke == Stroke::None)
        {
            for point in &curve.points {
                let Some((x, y)) = self.place(point.x, point.y) else {
                    continue;
                };
                if (-0.1..=self.size[0] + 0.1).contains(&x)
                    && (-0.1..=self.size[1] + 0.1).contains(&y)
                {
                    marker.path(&mut path, x, y);
                }
            }
        }
        html! { @if !path.is_empty() { path d=(path) style=(format!("fill:{}", curve.colour)) {} } }
    }
}

/// Draws the legend symbol of a curve, 34 wide and 12 high \[px\].
pub(crate) fn sign(curve: &ChartCurve) -> Markup {
    let mut mark = String::new();
    if let Some(marker) = curve.marker {
        marker.path(&mut mark, 17.0, 6.0);
    }
    let line = if curve.stroke == Stroke::Bars {
        "M4 11V2H30V11z"
    } else {
        "M1 6H33"
    };
    html! {
        @if let Some(class) = curve.stroke.class(false) {
            path.(class) d=(line) style=(format!("stroke:{0};fill:{0}", curve.colour)) {}
        }
        @if !mark.is_empty() { path d=(mark) style=(format!("fill:{}", curve.colour)) {} }
    }
}
