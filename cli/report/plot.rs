//! Plots as inline SVG. This module and its child are the only ones that name the plotting library.
//!
//! The library draws axes, curves and markers. Ranges, tick steps and error bars are decided here: an error bar is a
//! plain stroke that is cut at the frame, which stays readable where forty of them stand side by side and where the
//! lower end of one would be negative on a logarithmic axis. Legends are HTML above the plot, so they cannot cover
//! data. Colours are custom properties of the page's style sheet, so a plot follows the light or dark scheme.

pub(crate) mod map;

use std::fmt::Write as _;

use kuva::backend::svg::SvgBackend;
use kuva::plot::annotations::ReferenceLine;
use kuva::plot::line::{LinePlot, LineStyle};
use kuva::plot::scatter::{MarkerShape, ScatterPlot};
use kuva::render::layout::{Layout, TickFormat};
use kuva::render::plots::Plot;
use kuva::render::render::render_multiple;
use kuva::render::theme::Theme;

/// Width, height and left margin of a plot that takes half the page \[px\].
const HALF: [f64; 3] = [520.0, 360.0, 74.0];
/// The same of a plot that takes a third of the page; letters then keep their size.
const THIRD: [f64; 3] = [360.0, 330.0, 62.0];

/// Scale of an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Scale {
    /// Equal steps.
    Linear,
    /// Equal factors.
    Logarithmic,
}

/// An axis: label with symbol and unit, scale, and what is known of its range.
#[derive(Clone, Debug)]
pub(crate) struct Axis {
    /// Label.
    pub label: String,
    /// Scale.
    pub scale: Scale,
    /// Fixed range; found from the data otherwise.
    pub range: Option<(f64, f64)>,
    /// Range of the data, where it is wider than that of this plot.
    pub span: Option<(f64, f64)>,
    /// Names of the positions 1, 2, 3 and so on, in place of numbers.
    pub names: Vec<String>,
}

impl Axis {
    /// A linear axis.
    pub fn linear(label: &str) -> Self {
        Self {
            label: label.to_owned(),
            scale: Scale::Linear,
            range: None,
            span: None,
            names: Vec::new(),
        }
    }

    /// A logarithmic axis.
    pub fn logarithmic(label: &str) -> Self {
        Self {
            scale: Scale::Logarithmic,
            ..Self::linear(label)
        }
    }

    /// Fixes the range.
    pub fn over(self, low: f64, high: f64) -> Self {
        Self {
            range: Some((low, high)),
            ..self
        }
    }

    /// Whether a value has a place on the axis.
    ///
    /// The library draws everything below 1e-10 of a logarithmic axis at 1e-10, and no measured quantity reaches
    /// 1e100, where the arithmetic of the ticks would overflow.
    fn shows(&self, value: f64) -> bool {
        value.abs() < 1e100 && (self.scale == Scale::Linear || value >= 1e-10)
    }
}

/// Mark of a data point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Mark {
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

impl Mark {
    /// All marks, in the order of use.
    pub const ALL: [Self; 5] = [
        Self::Circle,
        Self::Square,
        Self::Triangle,
        Self::Diamond,
        Self::Inverted,
    ];

    /// The library's mark.
    fn shape(self) -> MarkerShape {
        match self {
            Self::Circle => MarkerShape::Circle,
            Self::Square => MarkerShape::Square,
            Self::Triangle => MarkerShape::Triangle,
            Self::Diamond => MarkerShape::Diamond,
            Self::Inverted => MarkerShape::TriangleDown,
        }
    }
}

/// Stroke that joins the points.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Stroke {
    /// No line.
    None,
    /// Thin line, a guide to the eye between marks.
    Thin,
    /// Solid line.
    Solid,
    /// Dashed line, for theory.
    Dashed,
}

/// A data point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Point {
    /// Abscissa.
    pub x: f64,
    /// Ordinate.
    pub y: f64,
    /// Standard error of the ordinate.
    pub error: Option<f64>,
}

/// Points of one kind.
#[derive(Clone, Debug)]
pub(crate) struct Curve {
    /// Name in the legend.
    pub label: String,
    /// Colour, a CSS value.
    pub colour: String,
    /// Mark of the points, if any.
    pub mark: Option<Mark>,
    /// Line that joins them.
    pub stroke: Stroke,
    /// Points, by increasing abscissa.
    pub points: Vec<Point>,
}

/// A plot.
#[derive(Clone, Debug)]
pub(crate) struct Chart {
    /// Horizontal axis.
    pub x: Axis,
    /// Vertical axis.
    pub y: Axis,
    /// Curves, drawn in this order.
    pub curves: Vec<Curve>,
    /// Ordinate of a horizontal reference line.
    pub level: Option<f64>,
}

impl Chart {
    /// Whether nothing could be drawn.
    pub fn is_empty(&self) -> bool {
        self.curves
            .iter()
            .all(|curve| !curve.points.iter().any(|point| self.shows(point)))
    }

    /// Whether a point has a place in the plot.
    fn shows(&self, point: &Point) -> bool {
        self.x.shows(point.x) && self.y.shows(point.y)
    }

    /// The range of the ordinates, so that plots that stand side by side can share it.
    pub fn ordinates(&self) -> Option<(f64, f64)> {
        let points = || {
            self.curves
                .iter()
                .flat_map(|curve| &curve.points)
                .filter(|p| self.shows(p))
        };
        let (low, high) = extent(points().map(|point| point.y).chain(self.level))?;
        // A single huge error bar must not flatten everything else.
        let reach = 1.5 * (high - low).max(0.1 * high.abs());
        let ends = points().flat_map(|point| {
            let error = point
                .error
                .filter(|error| error.is_finite())
                .unwrap_or(0.0)
                .min(reach);
            [point.y - error, point.y + error]
        });
        extent(ends.chain([low, high]).filter(|value| self.y.shows(*value)))
    }

    /// Draws the plot for one of `columns` columns; `number` makes the identifiers in the SVG unique on the page.
    pub fn svg(&self, number: usize, columns: usize, description: &str) -> String {
        let size = if columns > 2 { THIRD } else { HALF };
        let points = self
            .curves
            .iter()
            .flat_map(|curve| &curve.points)
            .filter(|p| self.shows(p));
        let abscissae = extent(points.map(|point| point.x)).unwrap_or((1.0, 1.0));
        let (x_range, x_step) = frame(&self.x, abscissae);
        let (y_range, y_step) = frame(&self.y, self.ordinates().unwrap_or((1.0, 1.0)));
        let mut plots = Vec::new();
        for curve in &self.curves {
            let shown: Vec<Point> = curve
                .points
                .iter()
                .copied()
                .filter(|point| self.shows(point))
                .collect();
            draw(curve, &shown, y_range, &mut plots);
        }
        let mut layout = Layout::new(x_range, y_range)
            .with_width(size[0])
            .with_height(size[1])
            .with_theme(theme())
            .with_x_label(self.x.label.clone())
            .with_y_label(self.y.label.clone())
            .with_label_size(15)
            .with_tick_size(12)
            .with_tick_length(4.0)
            .with_axis_line("box")
            .with_grid_line_width(0.6)
            .with_x_axis_min(x_range.0)
            .with_x_axis_max(x_range.1)
            .with_y_axis_min(y_range.0)
            .with_y_axis_max(y_range.1)
            .with_x_tick_format(labels(&self.x, x_range, x_step))
            .with_y_tick_format(labels(&self.y, y_range, y_step))
            .with_force_margins(size[2], 22.0);
        if let Some(step) = x_step {
            layout = layout.with_x_tick_step(step);
        } else {
            layout = layout.with_log_x();
        }
        if let Some(step) = y_step {
            layout = layout.with_y_tick_step(step);
        } else {
            layout = layout.with_log_y();
        }
        layout.show_legend = false;
        if let Some(level) = self.level.filter(|level| self.y.shows(*level)) {
            let line = ReferenceLine::horizontal(level)
                .with_color("var(--ink)")
                .with_stroke_width(1.2)
                .with_dasharray("6 4");
            layout = layout.with_reference_line(line);
        }
        let scene = render_multiple(plots, layout);
        embed(
            &SvgBackend::new().render_scene(&scene),
            size,
            number,
            description,
        )
    }
}

/// Adds the library's plots of one curve.
fn draw(curve: &Curve, points: &[Point], y_range: (f64, f64), plots: &mut Vec<Plot>) {
    let colour = || curve.colour.clone();
    for point in points {
        if let Some(error) = point
            .error
            .filter(|error| error.is_finite() && *error > 0.0)
        {
            let low = (point.y - error).clamp(y_range.0, y_range.1);
            let high = (point.y + error).clamp(y_range.0, y_range.1);
            let bar = LinePlot::new()
                .with_data([(point.x, low), (point.x, high)])
                .with_color(colour())
                .with_stroke_width(1.2);
            plots.push(Plot::Line(bar));
        }
    }
    let pairs = || points.iter().map(|point| (point.x, point.y));
    if curve.stroke != Stroke::None && points.len() > 1 {
        let width = if curve.stroke == Stroke::Thin {
            1.0
        } else {
            1.8
        };
        let style = if curve.stroke == Stroke::Dashed {
            LineStyle::Dashed
        } else {
            LineStyle::Solid
        };
        let line = LinePlot::new()
            .with_data(pairs())
            .with_color(colour())
            .with_stroke_width(width)
            .with_line_style(style);
        plots.push(Plot::Line(line));
    }
    if let Some(mark) = curve.mark {
        let marks = ScatterPlot::new()
            .with_data(pairs())
            .with_color(colour())
            .with_size(3.4)
            .with_marker(mark.shape());
        plots.push(Plot::Scatter(marks));
    }
}

/// Turns the library's SVG into one that scales with the page and stands inside HTML.
fn embed(svg: &str, [width, height, _]: [f64; 3], number: usize, description: &str) -> String {
    let body = svg.split_once('>').map_or(svg, |(_, body)| body);
    // The library numbers its clip paths by a counter that never restarts.
    let mut text = String::with_capacity(svg.len());
    for (place, part) in body.split("kuva-clip-").enumerate() {
        if place == 0 {
            text.push_str(part);
        } else {
            let _ = write!(text, "frame-{number}");
            text.push_str(part.trim_start_matches(|c: char| c.is_ascii_digit()));
        }
    }
    let label = maud::html! { (description) }.into_string();
    format!(
        "<svg class=\"plot\" viewBox=\"0 0 {width} {height}\" role=\"img\" aria-label=\"{label}\" fill=\"var(--ink)\">{text}"
    )
}

/// Colours of the frame, taken from the page.
fn theme() -> Theme {
    let ink = || "var(--ink)".to_owned();
    Theme {
        background: "none".to_owned(),
        axis_color: ink(),
        grid_color: "var(--grid)".to_owned(),
        tick_color: ink(),
        text_color: ink(),
        font_family: Some("system-ui, sans-serif".to_owned()),
        ..Theme::light()
    }
}

/// Smallest and largest of the finite values.
fn extent(values: impl Iterator<Item = f64>) -> Option<(f64, f64)> {
    values
        .filter(|value| value.is_finite())
        .fold(None, |range, value| {
            let (low, high): (f64, f64) = range.unwrap_or((value, value));
            Some((low.min(value), high.max(value)))
        })
}

/// The range of an axis around the data, and the step of its ticks when it is linear.
fn frame(axis: &Axis, data: (f64, f64)) -> ((f64, f64), Option<f64>) {
    if !axis.names.is_empty() {
        return ((0.5, axis.names.len() as f64 + 0.5), Some(1.0));
    }
    let (low, high) = axis.range.or(axis.span).unwrap_or(data);
    match axis.scale {
        Scale::Logarithmic => {
            let (mut low, mut high) = (low, high);
            if axis.range.is_none() {
                (low, high) = (low / 1.25, high * 1.25);
            }
            // A power of ten close by is worth a little room: it gets a label.
            let (below, above) = (
                10_f64.powf(low.log10().floor()),
                10_f64.powf(high.log10().ceil()),
            );
            if axis.range.is_none() && low / below < 1.6 {
                low = below;
            }
            if axis.range.is_none() && above / high < 1.6 {
                high = above;
            }
            while high / low < 6.0 {
                (low, high) = (low / 1.3, high * 1.3);
            }
            ((low, high), None)
        }
        Scale::Linear if axis.range.is_some() => ((low, high), Some(step(high - low))),
        Scale::Linear => {
            // A single value gets a frame of a fifth of its size.
            let least = if high > low { 1e-6 } else { 0.2 };
            let span = (high - low).max(least * high.abs()).max(1e-9);
            let floor = if low >= 0.0 { 0.0 } else { f64::NEG_INFINITY };
            let (low, high) = ((low - 0.06 * span).max(floor), high + 0.06 * span);
            let step = step(high - low);
            // Whole half steps keep the frame near the data and the ticks inside it.
            let half = 0.5 * step;
            let (low, high) = ((low / half).floor() * half, (high / half).ceil() * half);
            ((low, high), Some(step))
        }
    }
}

/// A tick step of 1, 2 or 5 times a power of ten that divides `span` into four to nine parts.
fn step(span: f64) -> f64 {
    let raw = span / 5.5;
    let power = 10_f64.powf(raw.log10().floor());
    let multiple = [1.0, 2.0, 5.0]
        .into_iter()
        .find(|m| m * power >= raw)
        .unwrap_or(10.0);
    multiple * power
}

/// How tick labels are written.
fn labels(axis: &Axis, (low, high): (f64, f64), step: Option<f64>) -> TickFormat {
    use std::sync::Arc;
    if !axis.names.is_empty() {
        let names = axis.names.clone();
        return TickFormat::Custom(Arc::new(move |value: f64| {
            let place = value.round() as usize;
            names
                .get(place.wrapping_sub(1))
                .cloned()
                .unwrap_or_default()
        }));
    }
    let Some(step) = step else {
        let plain = low > 0.009 && high < 2e4;
        return TickFormat::Custom(Arc::new(move |value: f64| decade(value, plain)));
    };
    let digits = (-step.log10().floor()).clamp(0.0, 9.0) as usize;
    TickFormat::Custom(Arc::new(move |value: f64| {
        minus(&format!("{value:.digits$}"))
    }))
}

/// Writes a tick of a logarithmic axis: as a plain number, or as a power of ten with its factor.
fn decade(value: f64, plain: bool) -> String {
    let exponent = (value.log10() + 1e-9).floor();
    if plain || (0.0..=1.0).contains(&exponent) {
        let digits = (-exponent).max(0.0) as usize;
        return format!("{value:.digits$}");
    }
    let factor = (value / 10_f64.powf(exponent)).round();
    if factor == 1.0 {
        power(exponent)
    } else {
        format!("{factor}\u{b7}{}", power(exponent))
    }
}

/// Ten to the power of a whole number.
pub(crate) fn power(exponent: f64) -> String {
    let raised = format!("{exponent:.0}");
    let raised = raised.chars().map(|c| match c {
        '-' => '\u{207b}',
        '1' => '\u{b9}',
        '2' => '\u{b2}',
        '3' => '\u{b3}',
        digit => char::from_u32(0x2070 + digit.to_digit(10).unwrap_or(0)).unwrap_or(digit),
    });
    "10".chars().chain(raised).collect()
}

/// Sets the sign of a negative number as a minus and drops it from zero.
fn minus(text: &str) -> String {
    match text.strip_prefix('-') {
        Some(rest) if rest.chars().all(|c| c == '0' || c == '.') => rest.to_owned(),
        Some(rest) => format!("\u{2212}{rest}"),
        None => text.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_written_as_one_would_by_hand() {
        assert_eq!(decade(1e-5, false), "10⁻⁵");
        assert_eq!(decade(0.01, true), "0.01");
        assert_eq!(decade(0.2, true), "0.2");
        assert_eq!(decade(1.0, false), "1");
        assert_eq!(decade(1000.0, false), "10³");
        assert_eq!(decade(20_000.0, false), "2·10⁴");
        assert_eq!(minus("-0.00"), "0.00");
        assert_eq!(step(1.0), 0.2);
    }

    #[test]
    fn points_without_a_place_are_left_out() {
        let points = [(0.0, 1.0), (1.0, f64::NAN), (2.0, -1.0), (3.0, 0.5)].map(|(x, y)| Point {
            x,
            y,
            error: Some(1.0),
        });
        let curve = Curve {
            label: String::new(),
            colour: "red".to_owned(),
            mark: Some(Mark::Circle),
            stroke: Stroke::Thin,
            points: points.to_vec(),
        };
        let chart = Chart {
            x: Axis::logarithmic("t"),
            y: Axis::logarithmic("K"),
            curves: vec![curve],
            level: None,
        };
        assert!(!chart.is_empty());
        let svg = chart.svg(1, 1, "x");
        assert!(!svg.contains("NaN") && !svg.contains("inf"));
        assert_eq!(
            svg,
            chart.svg(1, 1, "x"),
            "clip paths must not depend on what was drawn before"
        );
    }
}
