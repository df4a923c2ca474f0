//! Maps: a field over the plane in filled contours, with arrows of a second one.

use std::fmt::Write as _;
use std::sync::Arc;

use kuva::backend::svg::SvgBackend;
use kuva::plot::contour::ContourPlot;
use kuva::plot::heatmap::ColorMap;
use kuva::plot::quiver::{QuiverPivot, QuiverPlot};
use kuva::render::layout::{Layout, TickFormat};
use kuva::render::plots::Plot;
use kuva::render::render::render_multiple;

use super::{Axis, embed, frame, labels, theme};

/// A field on a grid of places.
#[derive(Clone, Debug)]
pub(crate) struct Map {
    /// Name and unit of the field.
    pub label: String,
    /// Sides of the box.
    pub size: [f64; 2],
    /// Coordinates of the columns and of the rows, rising.
    pub places: [Vec<f64>; 2],
    /// Values, the first axis running fastest; what is not finite is drawn as the least.
    pub values: Vec<f64>,
    /// Arrows, as many as values; none if empty.
    pub arrows: Vec<[f64; 2]>,
}

/// Width of a map and room around it: left with the lower edge, right with the scale, top \[px\].
const WIDTH: f64 = 520.0;
const LEFT: f64 = 74.0;
const RIGHT: f64 = 96.0;
const TOP: f64 = 22.0;
const BOTTOM: f64 = 58.0;

/// Least and largest height of the box on the page \[px\].
const HEIGHTS: [f64; 2] = [110.0, 420.0];

/// Most arrows along an axis.
const ARROWS: usize = 20;

/// Levels of the contours.
const LEVELS: usize = 12;

impl Map {
    /// Whether there is nothing to be drawn: no values, or all the same.
    pub(crate) fn is_empty(&self) -> bool {
        let [low, high] = self.range();
        let [columns, rows] = [self.places[0].len(), self.places[1].len()];
        columns < 2 || rows < 2 || self.values.len() != columns * rows || low >= high
    }

    /// Least and largest value.
    pub(crate) fn range(&self) -> [f64; 2] {
        let finite = self
            .values
            .iter()
            .copied()
            .filter(|value| value.is_finite());
        finite.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], value| {
            [low.min(value), high.max(value)]
        })
    }

    /// Draws it; `number` makes the identifiers in the SVG unique on the page.
    pub(crate) fn svg(&self, number: usize, description: &str) -> String {
        let inner = WIDTH - LEFT - RIGHT;
        let height = (inner * self.size[1] / self.size[0]).clamp(HEIGHTS[0], HEIGHTS[1]);
        let size = [WIDTH, height + TOP + BOTTOM, LEFT];
        let [low, _] = self.range();
        let columns = self.places[0].len();
        let rows: Vec<Vec<f64>> = (self.values.chunks(columns))
            .map(|row| {
                let value = |&value: &f64| if value.is_finite() { value } else { low };
                row.iter().map(value).collect()
            })
            .collect();
        let contours = ContourPlot::new()
            .with_grid(rows, self.places[0].clone(), self.places[1].clone())
            .with_n_levels(LEVELS)
            .with_filled()
            .with_colormap(ColorMap::Viridis)
            .with_legend(self.label.clone());
        let mut plots = vec![Plot::Contour(contours)];
        if let Some(arrows) = self.quiver() {
            plots.push(Plot::Quiver(arrows));
        }
        let axis = |label: &str, end: f64| Axis::linear(label).over(0.0, end);
        let (x, y) = (axis("x", self.size[0]), axis("y", self.size[1]));
        let (x_range, x_step) = frame(&x, (0.0, self.size[0]));
        let (y_range, y_step) = frame(&y, (0.0, self.size[1]));
        let mut layout = Layout::new(x_range, y_range)
            .with_width(size[0])
            .with_height(size[1])
            .with_theme(theme())
            .with_x_label("x")
            .with_y_label("y")
            .with_label_size(15)
            .with_tick_size(12)
            .with_axis_line("box")
            .with_grid_line_width(0.0)
            .with_x_axis_min(x_range.0)
            .with_x_axis_max(x_range.1)
            .with_y_axis_min(y_range.0)
            .with_y_axis_max(y_range.1)
            .with_x_tick_format(labels(&x, x_range, x_step))
            .with_y_tick_format(labels(&y, y_range, y_step));
        layout = layout.with_colorbar_tick_format(scale());
        layout.show_legend = false;
        let scene = render_multiple(plots, layout);
        embed(
            &SvgBackend::new().render_scene(&scene),
            size,
            number,
            description,
        )
    }

    /// The arrows, at most so many along each axis, the longest as long as their distance.
    fn quiver(&self) -> Option<QuiverPlot> {
        if self.arrows.len() != self.values.len() {
            return None;
        }
        let columns = self.places[0].len();
        let stride = |count: usize| count.div_ceil(ARROWS).max(1);
        let (right, up) = (stride(columns), stride(self.places[1].len()));
        let mut plot = QuiverPlot::new()
            .with_color("var(--arrow)")
            .with_pivot(QuiverPivot::Middle)
            .with_auto_scale(0.95)
            .with_clip_to_plot_area();
        for (row, &y) in self.places[1].iter().enumerate().skip(up / 2).step_by(up) {
            for (column, &x) in self.places[0]
                .iter()
                .enumerate()
                .skip(right / 2)
                .step_by(right)
            {
                let [u, v] = self.arrows[column + columns * row];
                plot = plot.with_arrow(x, y, u, v);
            }
        }
        Some(plot)
    }
}

/// Labels of the scale: three significant digits.
fn scale() -> TickFormat {
    TickFormat::Custom(Arc::new(|value: f64| {
        let mut text = String::new();
        let digits = if value == 0.0 {
            0
        } else {
            (2.0 - value.abs().log10().floor()).clamp(0.0, 9.0) as usize
        };
        // Writing to a string cannot fail.
        let _ = write!(text, "{value:.digits$}");
        if text.contains('.') {
            text = text.trim_end_matches('0').trim_end_matches('.').to_owned();
        }
        text.replace('-', "−")
    }))
}
