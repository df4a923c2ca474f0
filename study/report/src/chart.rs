//! Charts of a report: curves with error bars, histograms, theory, reference lines, and the ranges
//! of their axes.
//!
//! Colours are custom properties of the style sheet, so a chart follows the light or dark scheme.
//! Legends are HTML.

use std::fmt::Write as _;

use serde_json::{Value, json};
use stosszahl_results::AxisScale;

use crate::scale::{AxisRange, Tick, extent, shows};

/// Axis of a chart: label, scale, and range.
#[derive(Clone, Debug, PartialEq)]
pub struct ChartAxis {
    /// Label of the axis: symbol or words.
    pub label: String,
    /// Unit of the axis; `1` for pure numbers.
    pub unit: String,
    /// Scale of the axis: linear or logarithmic.
    pub scale: AxisScale,
    /// Range of the axis that the data need, if it is wider than the data of this chart, as in
    /// panels with common axes.
    pub span: Option<(f64, f64)>,
    /// Names at the positions 1, 2, 3 and so on of the axis, in place of numbers.
    pub names: Vec<String>,
}

impl ChartAxis {
    /// Creates an axis whose range follows from the data.
    pub fn new(label: impl Into<String>, scale: AxisScale) -> Self {
        Self {
            label: label.into(),
            unit: String::new(),
            scale,
            span: None,
            names: Vec::new(),
        }
    }

    fn frame(&self, data: Option<(f64, f64)>, exact: bool) -> AxisRange {
        if !self.names.is_empty() {
            let ends = (0.5, self.names.len() as f64 + 0.5);
            return AxisRange::range_around(AxisScale::Linear, ends, true);
        }
        AxisRange::range_around(self.scale, self.span.or(data).unwrap_or((1.0, 1.0)), exact)
    }

    /// Returns the ticks of the axis with their labels.
    pub(crate) fn ticks(&self, frame: &AxisRange) -> Vec<Tick> {
        if self.names.is_empty() {
            return frame.ticks();
        }
        let named = self.names.iter().zip(1..);
        named
            .map(|(name, place)| (frame.clamped(f64::from(place)), Some(name.clone())))
            .collect()
    }
}

/// Shape of the marker of data points in a chart.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Marker {
    /// Filled circle.
    Circle,
    /// Filled square.
    Square,
    /// Filled triangle.
    Triangle,
    /// Filled diamond.
    Diamond,
    /// Triangle with its tip down.
    Inverted,
}

impl Marker {
    /// All marker shapes, in the order in which curves use them.
    pub const ALL: [Self; 5] = [
        Self::Circle,
        Self::Square,
        Self::Triangle,
        Self::Diamond,
        Self::Inverted,
    ];

    /// Returns the name of the marker shape in the JSON data of a figure.
    fn name(self) -> &'static str {
        match self {
            Self::Circle => "circle",
            Self::Square => "square",
            Self::Triangle => "triangle",
            Self::Diamond => "diamond",
            Self::Inverted => "inverted",
        }
    }

    /// Adds the marker at a position to an SVG path.
    pub(crate) fn path(self, path: &mut String, x: f64, y: f64) {
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

/// Line style of a curve.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stroke {
    /// No line: markers only.
    None,
    /// Thin solid line, a guide to the eye between markers.
    Thin,
    /// Solid line of normal width.
    Solid,
    /// Dashed line, for theory.
    Dashed,
    /// Histogram bars from zero, each from the `x` of a point to its `end`.
    Bars,
}

impl Stroke {
    /// Returns the CSS class of the line; `None` without a line. A curve of `many` points has no
    /// markers, so its line is thicker.
    pub(crate) fn class(self, many: bool) -> Option<&'static str> {
        match self {
            Self::None => None,
            Self::Thin if !many => Some("thin"),
            Self::Thin | Self::Solid => Some("solid"),
            Self::Dashed => Some("dashed"),
            Self::Bars => Some("bars"),
        }
    }
}

/// Data point of a curve, with its error and its theoretical value.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ChartPoint {
    /// Abscissa, in the unit of the horizontal axis.
    pub x: f64,
    /// Abscissa at which the bar or step of a histogram ends; equal to `x` for a point without
    /// width.
    pub end: f64,
    /// Ordinate, in the unit of the vertical axis.
    pub y: f64,
    /// Standard error of the ordinate; `None` if there is none.
    pub error: Option<f64>,
    /// Theoretical value of the ordinate; `None` if there is none.
    pub theory: Option<f64>,
}

/// Curve of a chart: points, markers, line and colour.
#[derive(Clone, Debug, PartialEq)]
pub struct ChartCurve {
    /// Name of the curve in the legend.
    pub label: String,
    /// Colour of the curve, a CSS value.
    pub colour: String,
    /// Marker of the data points; `None` without markers.
    pub marker: Option<Marker>,
    /// Line style between the data points.
    pub stroke: Stroke,
    /// Data points of the curve, by increasing abscissa.
    pub points: Vec<ChartPoint>,
}

/// Text label at a position of a chart.
#[derive(Clone, Debug, PartialEq)]
pub struct Word {
    /// Text of the label.
    pub text: String,
    /// Abscissa of the label.
    pub x: f64,
    /// Ordinate of the label.
    pub y: f64,
}

/// Chart with axes, curves, reference lines and labels.
#[derive(Clone, Debug, PartialEq)]
pub struct Chart {
    /// Horizontal axis of the chart.
    pub x: ChartAxis,
    /// Vertical axis of the chart.
    pub y: ChartAxis,
    /// Curves of the chart, in drawing order.
    pub curves: Vec<ChartCurve>,
    /// Horizontal reference lines: label and ordinate.
    pub lines: Vec<(String, f64)>,
    /// Text labels next to points.
    pub words: Vec<Word>,
}

impl Chart {
    /// Creates a chart without curves from its two axes.
    pub fn new(x: ChartAxis, y: ChartAxis) -> Self {
        Self {
            x,
            y,
            curves: Vec::new(),
            lines: Vec::new(),
            words: Vec::new(),
        }
    }

    fn points(&self) -> impl Iterator<Item = &ChartPoint> {
        let all = self.curves.iter().flat_map(|curve| &curve.points);
        all.filter(|point| shows(self.x.scale, point.x) && shows(self.y.scale, point.y))
    }

    /// Returns true if the chart has no point to draw.
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
        let fixed = fixed.chain((bars && scale == AxisScale::Linear).then_some(0.0));
        let (low, high) = extent(scale, self.points().map(|point| point.y).chain(fixed))?;
        // A single huge error bar must not flatten all other data.
        let reach = 1.5 * (high - low).max(0.1 * high.abs());
        let ends = self.points().flat_map(|point| {
            let error = point.error.filter(|error| error.is_finite());
            let error = error.unwrap_or(0.0).min(reach);
            [point.y - error, point.y + error]
        });
        extent(scale, ends.chain([low, high]))
    }

    /// Gives adjacent charts common axes. Charts that would use less than a quarter of a common
    /// vertical axis keep their own, so that small effects are visible. Returns true if vertical
    /// axes are common.
    pub fn share_axes(charts: &mut [Self]) -> bool {
        fn unite(ranges: &[(f64, f64)]) -> Option<(f64, f64)> {
            let all = ranges.iter().copied();
            all.reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)))
        }
        let of = |range: fn(&Self) -> Option<(f64, f64)>| -> Vec<(f64, f64)> {
            charts.iter().filter_map(range).collect()
        };
        let (across, upwards) = (of(Self::abscissae), of(Self::ordinates));
        let (x, y) = (unite(&across), unite(&upwards));
        let logarithmic = charts
            .first()
            .is_some_and(|chart| chart.y.scale == AxisScale::Logarithmic);
        let size = |(low, high): (f64, f64)| {
            if logarithmic {
                (high / low).log10()
            } else {
                high - low
            }
        };
        let common = y.is_none_or(|y| upwards.iter().all(|one| size(*one) >= 0.25 * size(y)));
        for chart in charts {
            chart.x.span = x;
            chart.y.span = if common { y } else { None };
        }
        common
    }

    /// Computes the ranges of the horizontal and vertical axis.
    pub(crate) fn frames(&self) -> (AxisRange, AxisRange) {
        // Steps and bars end at the end of the axis.
        let steps = self.points().any(|point| point.end > point.x);
        (
            self.x.frame(self.abscissae(), steps),
            self.y.frame(self.ordinates(), false),
        )
    }

    /// Returns the numbers of the chart as JSON, for the script that makes it interactive.
    pub(crate) fn data(&self) -> Value {
        let (x, y) = self.frames();
        let axis = |axis: &ChartAxis, frame: AxisRange| {
            json!({
                "label": axis.label,
                "logarithmic": axis.scale == AxisScale::Logarithmic,
                "range": frame.ends(),
                "names": axis.names,
            })
        };
        let curves: Vec<Value> = self.curves.iter().map(ChartCurve::data).collect();
        let lines: Vec<Value> = (self.lines.iter())
            .map(|(label, y)| json!({ "label": label, "y": y }))
            .collect();
        let words: Vec<Value> = (self.words.iter())
            .map(|word| json!({ "text": word.text, "x": word.x, "y": word.y }))
            .collect();
        json!({
            "x": axis(&self.x, x), "y": axis(&self.y, y), "curves": curves, "lines": lines, "words": words,
        })
    }
}

impl ChartCurve {
    /// Returns the numbers of the curve as columns of JSON; columns without numbers are left out.
    fn data(&self) -> Value {
        let points = || {
            self.points
                .iter()
                .filter(|point| point.x.is_finite() && point.y.is_finite())
        };
        let column = |value: &dyn Fn(&ChartPoint) -> Option<f64>| -> Value {
            let all: Vec<Option<f64>> =
                points().map(|point| value(point).and_then(short)).collect();
            if all.iter().any(Option::is_some) {
                json!(all)
            } else {
                Value::Null
            }
        };
        json!({
            "label": self.label,
            "colour": self.colour,
            "marker": self.marker.map(Marker::name),
            "stroke": self.stroke.class(false),
            "x": column(&|point| Some(point.x)),
            "end": column(&|point| (point.end != point.x).then_some(point.end)),
            "y": column(&|point| Some(point.y)),
            "error": column(&|point| point.error),
            "theory": column(&|point| point.theory),
        })
    }
}

/// Rounds a number to nine significant digits for a page; `None` for a number that is not finite,
/// which JSON lacks.
pub(crate) fn short(value: f64) -> Option<f64> {
    format!("{value:.8e}")
        .parse()
        .ok()
        .filter(|value: &f64| value.is_finite())
}
