//! Contents of panels for print: curves, histograms, theory, reference lines, maps and obstacles.

use serde_json::Value;

use crate::chart::{Chart, ChartCurve, ChartPoint, Stroke};
use crate::map::{Map, STEPS, step_colour};
use crate::scale::AxisRange;
use crate::words::spread;

use super::canvas::{Area, Canvas, Colour, Pen, Segment};
use super::style::{CurveStyle, THIN};

/// Largest number of points along a drawn line; longer curves are thinned.
const VERTICES: usize = 1200;
/// Smallest distance between neighbouring markers of a curve \[pt\].
const MARK_SPACE: f64 = 5.5;

/// Chart with its position on the page, for drawing its curves.
pub(crate) struct PlacedChart<'a> {
    /// Chart whose curves are drawn.
    pub chart: &'a Chart,
    /// Ranges of the horizontal and vertical axis.
    pub axes: [AxisRange; 2],
    /// Area of the frame of the panel.
    pub area: Area,
}

impl PlacedChart<'_> {
    /// Returns the position of a data point on the page \[pt\]; `None` if it cannot be drawn.
    pub fn place(&self, x: f64, y: f64) -> Option<[f64; 2]> {
        let [x, y] = [self.axes[0].position_of(x)?, self.axes[1].position_of(y)?];
        // Far outside is drawn like infinity.
        Some(self.area.at([x, y].map(|place| place.clamp(-50.0, 50.0))))
    }

    /// Returns the vertices of a curve on the page \[pt\]. A step has two; `None` interrupts the
    /// line.
    fn joints(&self, curve: &ChartCurve) -> Vec<Option<[f64; 2]>> {
        let mut joints = Vec::new();
        for point in spread(&curve.points, VERTICES) {
            joints.push(self.place(point.x, point.y));
            if point.end > point.x {
                joints.push(self.place(point.end, point.y));
            }
        }
        joints
    }

    /// Returns the points of a curve that get markers and error bars: along a line, those not too
    /// close to the one before.
    fn marked<'c>(&self, curve: &'c ChartCurve) -> Vec<&'c ChartPoint> {
        let mut last = [f64::NEG_INFINITY; 2];
        let all = curve.points.iter().filter(|point| {
            let Some([x, y]) = self.middle(point) else {
                return false;
            };
            let apart = (x - last[0]).hypot(y - last[1]) >= MARK_SPACE;
            // Without a line each point is shown.
            let shown = apart || curve.stroke == Stroke::None;
            if shown {
                last = [x, y];
            }
            shown
        });
        all.collect()
    }

    /// Returns the position of the marker of a point \[pt\]: the middle of its step.
    fn middle(&self, point: &ChartPoint) -> Option<[f64; 2]> {
        let [from, to] = [point.x, point.end].map(|x| self.place(x, point.y));
        let (from, to) = (from?, to?);
        Some([0.5 * (from[0] + to[0]), from[1]])
    }

    /// Returns both ends of the error bar of a point \[pt\]; `None` without an error.
    fn error_bar(&self, point: &ChartPoint) -> Option<[[f64; 2]; 2]> {
        let error = point
            .error
            .filter(|error| error.is_finite() && *error > 0.0)?;
        let [low, high] = [point.y - error, point.y + error].map(|end| {
            let share = self.axes[1].clamped(end);
            self.area.at([0.0, share])[1]
        });
        let [x, _] = self.middle(point)?;
        let inside = (self.area.left - 0.1..=self.area.right + 0.1).contains(&x);
        inside.then_some([[x, low], [x, high]])
    }

    /// Draws lines, bars and error bars of all curves, clipped by the frame.
    pub fn lines(&self, canvas: &mut Canvas, style: impl Fn(&str) -> CurveStyle) {
        for (label, level) in &self.chart.lines {
            let y = self.area.at([0.0, self.axes[1].clamped(*level)])[1];
            let line = vec![
                Segment::Move([self.area.left, y]),
                Segment::Line([self.area.right, y]),
            ];
            if let Some(pen) = style(label).pen {
                canvas.stroke(line, pen);
            }
        }
        for curve in &self.chart.curves {
            let style = style(&curve.label);
            if curve.stroke == Stroke::Bars {
                canvas.path(self.bars(curve), style.bars, style.pen);
            } else if let Some(pen) = style.pen {
                canvas.stroke(self.area.cut_line(&self.joints(curve)), pen);
            }
            let mut errors = Vec::new();
            for point in self.marked(curve) {
                if let Some([low, high]) = self.error_bar(point) {
                    errors.extend([Segment::Move(low), Segment::Line(high)]);
                }
            }
            canvas.stroke(errors, style.error());
        }
    }

    /// Returns the path of the histogram bars of a curve, from zero, clipped by the frame.
    fn bars(&self, curve: &ChartCurve) -> Vec<Segment> {
        let foot = self.area.at([0.0, self.axes[1].clamped(0.0)])[1];
        let bar = |point: &ChartPoint| {
            let ends = [
                self.place(point.x, point.y)?,
                self.place(point.end, point.y)?,
            ];
            let [[left, top], [right, _]] = ends.map(|end| self.area.clamp(end));
            Some([
                Segment::Move([left, foot]),
                Segment::Line([left, top]),
                Segment::Line([right, top]),
                Segment::Line([right, foot]),
            ])
        };
        curve.points.iter().filter_map(bar).flatten().collect()
    }

    /// Draws the markers of all curves.
    pub fn markers(&self, canvas: &mut Canvas, style: impl Fn(&str) -> CurveStyle) {
        for curve in &self.chart.curves {
            let style = style(&curve.label);
            let marked = self.marked(curve);
            let places = marked.iter().filter_map(|point| self.middle(point));
            for at in places.filter(|at| self.area.holds(*at, 0.1)) {
                if let Some((path, fill)) = style.mark(at) {
                    canvas.path(path, Some(fill), Some(Pen::solid(THIN, style.colour)));
                }
            }
        }
    }

    /// Returns true if a curve, marker or reference line of the chart is drawn in an area.
    pub fn meets(&self, area: &Area) -> bool {
        let crossed = |from: [f64; 2], to: [f64; 2]| area.cut(from, to).is_some();
        let levels = self.chart.lines.iter().any(|(_, level)| {
            let y = self.area.at([0.0, self.axes[1].clamped(*level)])[1];
            (area.top..=area.bottom).contains(&y)
        });
        let curve = |curve: &ChartCurve| {
            let joints = self.joints(curve);
            let line = joints.windows(2).any(|pair| match pair {
                [Some(from), Some(to)] => crossed(*from, *to),
                _ => false,
            });
            let points = joints.iter().flatten().any(|at| area.holds(*at, 0.0));
            let marked = self.marked(curve);
            let bars = marked.iter().filter_map(|point| self.error_bar(point));
            let errors = bars.clone().any(|[from, to]| crossed(from, to));
            let filled = curve.stroke == Stroke::Bars
                && self.bars(curve).chunks(4).any(|bar| match bar {
                    [Segment::Move(foot), _, Segment::Line([right, top]), ..] => {
                        let [left, low] = *foot;
                        left < area.right
                            && *right > area.left
                            && top.min(low) < area.bottom
                            && top.max(low) > area.top
                    }
                    _ => false,
                });
            (line && curve.stroke != Stroke::None) || points || errors || filled
        };
        levels || self.chart.curves.iter().any(curve)
    }
}

/// Draws the coloured cells of a map, and the obstacles over them.
pub(crate) fn draw_map(
    canvas: &mut Canvas,
    map: &Map,
    bar: &AxisRange,
    obstacles: &[Value],
    area: &Area,
) {
    let mut paths = vec![Vec::new(); STEPS];
    for (step, [left, right, bottom, top]) in map.coloured_cells(bar) {
        let ([left, bottom], [right, top]) = (area.at([left, bottom]), area.at([right, top]));
        let cell = Area {
            left,
            top,
            right,
            bottom,
        };
        paths[step].extend(cell.outline());
    }
    for (step, path) in paths.into_iter().enumerate() {
        // A thin line of the same colour closes the seams that viewers show between cells.
        let colour = cell_colour(step);
        canvas.path(path, Some(colour), Some(Pen::solid(0.25, colour)));
    }
    draw_obstacles(canvas, map, obstacles, area);
}

/// Draws the colour bar of a map, with its lowest colour at the lower end.
pub(crate) fn draw_bar(canvas: &mut Canvas, area: &Area) {
    for step in 0..STEPS {
        let [bottom, top] = [step, step + 1].map(|end| end as f64 / STEPS as f64);
        let part = Area {
            top: area.at([0.0, top])[1],
            bottom: area.at([0.0, bottom])[1],
            ..*area
        };
        let colour = cell_colour(step);
        canvas.path(part.outline(), Some(colour), Some(Pen::solid(0.25, colour)));
    }
}

fn cell_colour(step: usize) -> Colour {
    step_colour(step).map(|part| part.round() as u8)
}

/// Draws the obstacles of a case over a map: disks, polygons and polylines.
fn draw_obstacles(canvas: &mut Canvas, map: &Map, obstacles: &[Value], area: &Area) {
    let grey = [85, 85, 85];
    let ends = map.ends();
    let number = |value: &Value| value.as_f64().unwrap_or(f64::NAN);
    let place = |x: f64, y: f64| {
        let share = |axis: usize, value: f64| {
            let (low, high) = ends[axis];
            (value - low) / (high - low)
        };
        area.at([share(0, x), share(1, y)])
    };
    let corners = |points: &Value| -> Vec<[f64; 2]> {
        let points = points.as_array().into_iter().flatten();
        let placed = points.map(|point| place(number(&point[0]), number(&point[1])));
        placed
            .filter(|[x, y]| x.is_finite() && y.is_finite())
            .collect()
    };
    for one in obstacles {
        let disk = &one["circle"];
        let mut closed = corners(&one["polygon"]);
        if disk.is_object() {
            let [x, y] = [0, 1].map(|axis| number(&disk["centre"][axis]));
            let radius = number(&disk["radius"]);
            // Between its corners it is 0.1 % of the radius too small.
            let around = (0..72).map(|step| {
                let (sin, cos) = (f64::from(step) * std::f64::consts::PI / 36.0).sin_cos();
                place(x + radius * cos, y + radius * sin)
            });
            closed = around
                .filter(|[x, y]| x.is_finite() && y.is_finite())
                .collect();
        }
        let mut path: Vec<Segment> = (closed.iter().enumerate())
            .map(|(place, at)| match (place, area.clamp(*at)) {
                (0, at) => Segment::Move(at),
                (_, at) => Segment::Line(at),
            })
            .collect();
        if !path.is_empty() {
            path.push(Segment::Close);
        }
        canvas.path(path, Some(grey), Some(Pen::solid(THIN, [51, 51, 51])));
        let open: Vec<Option<[f64; 2]>> = corners(&one["polyline"]).into_iter().map(Some).collect();
        canvas.stroke(area.cut_line(&open), Pen::solid(1.2, grey));
    }
}
