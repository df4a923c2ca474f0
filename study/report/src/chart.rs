//! Charts as inline SVG: curves with error bars, histograms, theory, reference lines.
//!
//! Written here and not with a plotting library: the charts of reports need a few hundred lines, the libraries that were
//! tried doubled the time to build the program, counted clip paths globally and drew legends over data. Colours are
//! custom properties of the style sheet, so a chart follows the light or dark scheme. Legends are HTML.

use std::fmt::Write as _;

use maud::{Markup, html};
use stosszahl_results::Scale;

use crate::scale::{Frame, Tick, extent, shows};

/// Width and height of a chart, and room around its frame: left, right, top, bottom.
pub(crate) const WIDTH: f64 = 440.0;
const HEIGHT: f64 = 310.0;
pub(crate) const LEFT: f64 = 62.0;
pub(crate) const RIGHT: f64 = 14.0;
pub(crate) const TOP: f64 = 10.0;
pub(crate) const BOTTOM: f64 = 46.0;
/// Points of a curve that are drawn as marks; a curve of more is a line.
const MARKS: usize = 60;
/// Points of a line that are drawn.
const VERTICES: usize = 600;

/// An axis of a chart.
#[derive(Clone, Debug, PartialEq)]
pub struct ChartAxis {
    /// Label, with symbol and unit.
    pub label: String,
    /// Scale.
    pub scale: Scale,
    /// Range of the data where it is wider than that of this chart, as in panels that share their axes.
    pub span: Option<(f64, f64)>,
    /// Names of the positions 1, 2, 3 and so on, in place of numbers.
    pub names: Vec<String>,
}

impl ChartAxis {
    /// An axis around its data.
    pub fn new(label: impl Into<String>, scale: Scale) -> Self {
        Self {
            label: label.into(),
            scale,
            span: None,
            names: Vec::new(),
        }
    }

    fn frame(&self, data: Option<(f64, f64)>) -> Frame {
        if !self.names.is_empty() {
            let ends = (0.5, self.names.len() as f64 + 0.5);
            return Frame::around(Scale::Linear, ends, true);
        }
        Frame::around(self.scale, self.span.or(data).unwrap_or((1.0, 1.0)), false)
    }

    fn ticks(&self, frame: &Frame) -> Vec<Tick> {
        if self.names.is_empty() {
            return frame.ticks();
        }
        let named = self.names.iter().zip(1..);
        named
            .map(|(name, place)| (frame.clamped(f64::from(place)), Some(name.clone())))
            .collect()
    }
}

/// Mark of a data point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Marker {
    /// Disk.
    Circle,
    /// Square.
    Square,
    /// Triangle.
    Triangle,
    /// Diamond.
    Diamond,
    /// Triangle on its tip.
    Inverted,
}

impl Marker {
    /// All of them, in the order of use.
    pub const ALL: [Self; 5] = [
        Self::Circle,
        Self::Square,
        Self::Triangle,
        Self::Diamond,
        Self::Inverted,
    ];

    fn path(self, path: &mut String, x: f64, y: f64) {
        // Writing to a string cannot fail.
        let _ = match self {
            Self::Circle => write!(path, "M{:.1} {y:.1}a3 3 0 1 0 6 0a3 3 0 1 0-6 0", x - 3.0),
            Self::Square => write!(path, "M{:.1} {:.1}h5.2v5.2h-5.2z", x - 2.6, y - 2.6),
            Self::Triangle => write!(path, "M{x:.1} {:.1}l3.4 6h-6.8z", y - 3.8),
            Self::Diamond => write!(path, "M{x:.1} {:.1}l3.6 3.6l-3.6 3.6l-3.6-3.6z", y - 3.6),
            Self::Inverted => write!(path, "M{x:.1} {:.1}l3.4-6h-6.8z", y + 3.8),
        };
    }
}

/// How the points of a curve are joined.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stroke {
    /// Not at all.
    None,
    /// By a thin line, a guide to the eye between marks.
    Thin,
    /// By a solid line.
    Solid,
    /// By a dashed line, for theory.
    Dashed,
    /// By the outline of bars from each point to its `end`.
    Bars,
}

/// A data point.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Point {
    /// Abscissa.
    pub x: f64,
    /// Where the bar of a histogram ends.
    pub end: f64,
    /// Ordinate.
    pub y: f64,
    /// Standard error of the ordinate.
    pub error: Option<f64>,
}

impl Point {
    /// A point without an error.
    pub fn new(x: f64, y: f64) -> Self {
        Self {
            x,
            end: x,
            y,
            error: None,
        }
    }
}

/// Points of one kind.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    /// Name in the legend.
    pub label: String,
    /// Colour, a CSS value.
    pub colour: String,
    /// Mark of the points, if any.
    pub marker: Option<Marker>,
    /// How they are joined.
    pub stroke: Stroke,
    /// The points, by increasing abscissa.
    pub points: Vec<Point>,
}

/// A word at a place.
#[derive(Clone, Debug, PartialEq)]
pub struct Word {
    /// The word.
    pub text: String,
    /// Abscissa.
    pub x: f64,
    /// Ordinate.
    pub y: f64,
}

/// A chart.
#[derive(Clone, Debug, PartialEq)]
pub struct Chart {
    /// Horizontal axis.
    pub x: ChartAxis,
    /// Vertical axis.
    pub y: ChartAxis,
    /// Curves, drawn in this order.
    pub curves: Vec<Curve>,
    /// Horizontal reference lines with their labels.
    pub lines: Vec<(String, f64)>,
    /// Words beside points.
    pub words: Vec<Word>,
}

impl Chart {
    /// A chart without curves.
    pub fn new(x: ChartAxis, y: ChartAxis) -> Self {
        Self {
            x,
            y,
            curves: Vec::new(),
            lines: Vec::new(),
            words: Vec::new(),
        }
    }

    fn points(&self) -> impl Iterator<Item = &Point> {
        let all = self.curves.iter().flat_map(|curve| &curve.points);
        all.filter(|point| shows(self.x.scale, point.x) && shows(self.y.scale, point.y))
    }

    /// Whether nothing could be drawn.
    pub fn is_empty(&self) -> bool {
        self.points().next().is_none()
    }

    fn abscissae(&self) -> Option<(f64, f64)> {
        let both = self.points().flat_map(|point| [point.x, point.end]);
        extent(self.x.scale, both)
    }

    fn ordinates(&self) -> Option<(f64, f64)> {
        let scale = self.y.scale;
        let bars = self.curves.iter().any(|curve| curve.stroke == Stroke::Bars);
        let fixed = self.lines.iter().map(|line| line.1);
        let fixed = fixed.chain((bars && scale == Scale::Linear).then_some(0.0));
        let (low, high) = extent(scale, self.points().map(|point| point.y).chain(fixed))?;
        // A single huge error bar must not flatten everything else.
        let reach = 1.5 * (high - low).max(0.1 * high.abs());
        let ends = self.points().flat_map(|point| {
            let error = point.error.filter(|error| error.is_finite());
            let error = error.unwrap_or(0.0).min(reach);
            [point.y - error, point.y + error]
        });
        extent(scale, ends.chain([low, high]))
    }

    /// Gives charts that stand side by side the same axes.
    pub fn share_axes(charts: &mut [Self]) {
        let unite = |ranges: &mut dyn Iterator<Item = (f64, f64)>| {
            ranges.reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)))
        };
        let x = unite(&mut charts.iter().filter_map(Self::abscissae));
        let y = unite(&mut charts.iter().filter_map(Self::ordinates));
        for chart in charts {
            (chart.x.span, chart.y.span) = (x, y);
        }
    }

    /// Draws the chart; `description` is for those who cannot see it.
    pub fn svg(&self, description: &str) -> Markup {
        let (x, y) = (
            self.x.frame(self.abscissae()),
            self.y.frame(self.ordinates()),
        );
        let (width, height) = (WIDTH - LEFT - RIGHT, HEIGHT - TOP - BOTTOM);
        let canvas = Canvas {
            x,
            y,
            size: [width, height],
        };
        let words = self.words.iter().filter_map(|word| {
            let (x, y) = canvas.place(word.x, word.y)?;
            Some((x, y, &word.text))
        });
        svg(
            HEIGHT,
            description,
            &html! {
                (axes([width, height], [&self.x.ticks(&x), &self.y.ticks(&y)], [&self.x.label, &self.y.label], true))
                svg x=(LEFT) y=(TOP) width=(width) height=(height) {
                    @for (_, level) in &self.lines {
                        @let at = height * (1.0 - y.clamped(*level));
                        path.level d=(format!("M0 {at:.1}H{width:.1}")) {}
                    }
                    @for curve in &self.curves { (canvas.strokes(curve)) }
                }
                g transform=(format!("translate({LEFT} {TOP})")) {
                    @for curve in &self.curves { (canvas.marks(curve)) }
                    @for (x, y, text) in words { text.word x=(format!("{x:.1}")) y=(format!("{y:.1}")) { (text) } }
                }
            },
        )
    }
}

/// The SVG element of a chart or a map.
pub(crate) fn svg(height: f64, description: &str, content: &Markup) -> Markup {
    html! {
        svg.plot viewBox=(format!("0 0 {WIDTH} {height:.0}")) role="img" aria-label=(description) { (content) }
    }
}

/// Frame, grid, ticks and labels around an area of a size.
pub(crate) fn axes(
    [width, height]: [f64; 2],
    [x_ticks, y_ticks]: [&[Tick]; 2],
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
    // Labels that would run into each other are left out.
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

/// The area inside the frame.
struct Canvas {
    x: Frame,
    y: Frame,
    size: [f64; 2],
}

impl Canvas {
    fn place(&self, x: f64, y: f64) -> Option<(f64, f64)> {
        let (x, y) = (self.x.place(x)?, self.y.place(y)?);
        // Far outside is as good as infinitely far, and short to write.
        let near = |place: f64| place.clamp(-50.0, 50.0);
        Some((near(x) * self.size[0], (1.0 - near(y)) * self.size[1]))
    }

    /// Lines, bars and error bars, which the frame cuts.
    fn strokes(&self, curve: &Curve) -> Markup {
        let (mut line, mut errors) = (String::new(), String::new());
        let mut joined = false;
        let thinned = crate::words::spread(&curve.points, VERTICES);
        for point in &thinned {
            let Some((x, y)) = self.place(point.x, point.y) else {
                joined = false;
                continue;
            };
            // Writing to a string cannot fail.
            if curve.stroke == Stroke::Bars {
                let end = self.place(point.end, point.y).map_or(x, |place| place.0);
                let foot = (1.0 - self.y.clamped(0.0)) * self.size[1];
                let _ = write!(line, "M{x:.1} {foot:.1}V{y:.1}H{end:.1}V{foot:.1}");
            } else {
                let _ = write!(line, "{}{x:.1} {y:.1}", if joined { 'L' } else { 'M' });
            }
            joined = true;
        }
        for point in crate::words::spread(&curve.points, MARKS) {
            let error = point
                .error
                .filter(|error| error.is_finite() && *error > 0.0);
            let end = if curve.stroke == Stroke::Bars {
                point.end
            } else {
                point.x
            };
            if let (Some(error), Some((x, _)), Some((other, _))) = (
                error,
                self.place(point.x, point.y),
                self.place(end, point.y),
            ) {
                let at = |y: f64| (1.0 - self.y.clamped(y)) * self.size[1];
                let (low, high) = (at(point.y - error), at(point.y + error));
                let _ = write!(errors, "M{:.1} {low:.1}V{high:.1}", 0.5 * (x + other));
            }
        }
        let class = match curve.stroke {
            Stroke::None => None,
            Stroke::Thin if curve.points.len() > MARKS => Some("solid"),
            Stroke::Thin => Some("thin"),
            Stroke::Solid => Some("solid"),
            Stroke::Dashed => Some("dashed"),
            Stroke::Bars => Some("bars"),
        };
        html! {
            @if let (Some(class), false) = (class, line.is_empty()) {
                path.(class) d=(line) style=(format!("stroke:{0};fill:{0}", curve.colour)) {}
            }
            @if !errors.is_empty() { path.error d=(errors) style=(format!("stroke:{}", curve.colour)) {} }
        }
    }

    /// Marks, which the frame does not cut.
    fn marks(&self, curve: &Curve) -> Markup {
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

/// The sign of a curve in a legend.
pub fn swatch(curve: &Curve) -> Markup {
    let mut mark = String::new();
    if let Some(marker) = curve.marker {
        marker.path(&mut mark, 17.0, 6.0);
    }
    let class = match curve.stroke {
        Stroke::None => None,
        Stroke::Thin => Some("thin"),
        Stroke::Solid => Some("solid"),
        Stroke::Dashed => Some("dashed"),
        Stroke::Bars => Some("bars"),
    };
    let line = if curve.stroke == Stroke::Bars {
        "M4 11V2H30V11z"
    } else {
        "M1 6H33"
    };
    html! {
        svg viewBox="0 0 34 12" aria-hidden="true" {
            @if let Some(class) = class { path.(class) d=(line) style=(format!("stroke:{0};fill:{0}", curve.colour)) {} }
            @if !mark.is_empty() { path d=(mark) style=(format!("fill:{}", curve.colour)) {} }
        }
    }
}
