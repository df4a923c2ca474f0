//! Maps of a quantity over the plane as coloured cells with a colour bar, drawn as SVG.

use std::fmt::Write as _;

use maud::html;
use serde_json::{Value, json};
use stosszahl_results::AxisScale;

use crate::chart::short;
use crate::draw::{BOTTOM, LEFT, Plot, TOP, WIDTH, axes};
use crate::scale::AxisRange;

/// Margin right of the map, for the colour bar \[px\].
const RIGHT: f64 = 84.0;
/// Width of the map inside its frame \[px\].
const MAP_WIDTH: f64 = WIDTH - LEFT - RIGHT;
/// Smallest and largest height of the map inside its frame \[px\].
const HEIGHTS: [f64; 2] = [90.0, 380.0];
/// Colours of the colour bar from lowest to highest value (viridis), between which others are
/// interpolated.
const COLOURS: [[f64; 3]; 6] = [
    [68.0, 1.0, 84.0],
    [65.0, 68.0, 135.0],
    [42.0, 120.0, 142.0],
    [34.0, 168.0, 132.0],
    [122.0, 209.0, 81.0],
    [253.0, 231.0, 37.0],
];
/// Number of colour steps of the colour bar.
pub(crate) const STEPS: usize = 48;

/// Map of a quantity over the plane: cells, labels and units.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Map {
    /// Labels of the horizontal and vertical axis.
    pub labels: [String; 2],
    /// Label of the colour bar: the quantity.
    pub value: String,
    /// Units of both axes and of the colour bar; `1` for pure numbers.
    pub units: [String; 3],
    /// Scale of the colours: linear or logarithmic.
    pub scale: AxisScale,
    /// Cells of the map: coordinates `x` and `y` of the centre, and the value.
    pub cells: Vec<[f64; 3]>,
}

impl Map {
    /// Returns smallest and largest value of the map; `None` without values.
    pub fn range(&self) -> Option<(f64, f64)> {
        crate::scale::extent(self.scale, self.cells.iter().map(|cell| cell[2]))
    }

    /// Returns lower and upper end of both axes, around all cells.
    pub fn ends(&self) -> [(f64, f64); 2] {
        self.edges().map(|edges| (edges[0], edges[edges.len() - 1]))
    }

    /// Returns height over width of the map, within the limits of a page.
    pub fn aspect(&self) -> f64 {
        let [x, y] = self.ends();
        let aspect = (y.1 - y.0) / (x.1 - x.0);
        aspect.clamp(HEIGHTS[0] / MAP_WIDTH, HEIGHTS[1] / MAP_WIDTH)
    }

    fn edges(&self) -> [Vec<f64>; 2] {
        [0, 1].map(|axis| edges(self.cells.iter().map(|cell| cell[axis])))
    }

    /// Returns the cells that can be coloured: colour step, and positions of the left, right,
    /// bottom and top edges from 0 to 1 along the axes.
    pub fn coloured_cells(&self, bar: &AxisRange) -> Vec<(usize, [f64; 4])> {
        let edges = self.edges();
        let frames = self
            .ends()
            .map(|ends| AxisRange::range_around(AxisScale::Linear, ends, true));
        let shown = self
            .cells
            .iter()
            .filter(|cell| bar.position_of(cell[2]).is_some());
        let placed = shown.map(|cell| {
            let around = |axis: usize| {
                let after = edges[axis].partition_point(|edge| *edge <= cell[axis]);
                let after = after.clamp(1, edges[axis].len() - 1);
                [after - 1, after].map(|edge| frames[axis].clamped(edges[axis][edge]))
            };
            let ([left, right], [bottom, top]) = (around(0), around(1));
            let step = ((bar.clamped(cell[2]) * STEPS as f64) as usize).min(STEPS - 1);
            (step, [left, right, bottom, top])
        });
        placed.collect()
    }

    /// Draws the map as SVG, with colours for values from `low` to `high`.
    pub fn plot(&self, (low, high): (f64, f64), description: String) -> Plot {
        let [x, y] = self
            .ends()
            .map(|ends| AxisRange::range_around(AxisScale::Linear, ends, true));
        let (width, height) = (MAP_WIDTH, MAP_WIDTH * self.aspect());
        let bar = AxisRange::range_around(self.scale, (low, high), high > low);
        // All cells of one colour form one path.
        let mut paths = vec![String::new(); STEPS];
        for (step, [left, right, bottom, top]) in self.coloured_cells(&bar) {
            let [left, right] = [left, right].map(|place| place * width);
            let [top, bottom] = [top, bottom].map(|place| (1.0 - place) * height);
            // Writing to a string cannot fail.
            let _ = write!(
                paths[step],
                "M{left:.1} {top:.1}H{right:.1}V{bottom:.1}H{left:.1}z"
            );
        }
        let content = html! {
            g.cells transform=(format!("translate({LEFT} {TOP})")) {
                @for (step, path) in paths.iter().enumerate().filter(|(_, path)| !path.is_empty()) {
                    path d=(path) fill=(colour(step)) stroke=(colour(step)) {}
                }
            }
            (axes([width, height], &[x.ticks(), y.ticks()], [&self.labels[0], &self.labels[1]], false))
            g.cells transform=(format!("translate({} {TOP})", LEFT + width + 14.0)) {
                @for step in 0..STEPS {
                    @let part = height / STEPS as f64;
                    rect x="0" width="12" y=(format!("{:.1}", height - (step + 1) as f64 * part)) height=(format!("{:.1}", part + 0.4)) fill=(colour(step)) {}
                }
                @for (place, label) in bar.ticks() {
                    text.tick x="17" y=(format!("{:.1}", (1.0 - place) * height + 3.7)) { (label.unwrap_or_default()) }
                }
            }
        };
        Plot {
            description,
            height: height + TOP + BOTTOM,
            content,
            data: self.data([x.ends(), y.ends()], [LEFT, TOP, width, height]),
        }
    }

    /// Returns the numbers of the map as JSON: axis ranges, position of the frame in the drawing,
    /// and cells.
    fn data(&self, [x, y]: [[f64; 2]; 2], frame: [f64; 4]) -> Value {
        let shown = |axis: usize| -> Vec<Option<f64>> {
            let known = self
                .cells
                .iter()
                .filter(|cell| cell.iter().all(|value| value.is_finite()));
            known.map(|cell| short(cell[axis])).collect()
        };
        json!({
            "map": true, "frame": frame, "value": self.value,
            "x": { "label": self.labels[0], "range": x }, "y": { "label": self.labels[1], "range": y },
            "cells": [shown(0), shown(1), shown(2)],
        })
    }
}

/// Draws the obstacles of a case over a map of its plane: disks, polylines and polygons.
pub(crate) fn with_obstacles(plot: &mut Plot, obstacles: &[Value]) {
    let number = |value: &Value| value.as_f64().unwrap_or(f64::NAN);
    let range = |axis: &str| [0, 1].map(|end| number(&plot.data[axis]["range"][end]));
    let [left, top, width, height] = [0, 1, 2, 3].map(|part| number(&plot.data["frame"][part]));
    let ([x0, x1], [y0, y1]) = (range("x"), range("y"));
    let [across, up] = [width / (x1 - x0), height / (y1 - y0)];
    let place = |point: &Value| {
        let [x, y] = [0, 1].map(|axis| number(&point[axis]));
        [left + (x - x0) * across, top + (y1 - y) * up]
    };
    let path = |points: &Value, close: &str| {
        let mut path = String::new();
        for (at, point) in points.as_array().into_iter().flatten().enumerate() {
            let [x, y] = place(point);
            // Writing to a string cannot fail.
            let _ = write!(path, "{}{x:.1} {y:.1}", if at == 0 { 'M' } else { 'L' });
        }
        path + close
    };
    let content = html! {
        (plot.content)
        g.obstacles { @for one in obstacles {
            @if one["circle"].is_object() {
                @let [x, y] = place(&one["circle"]["centre"]);
                @let radius = number(&one["circle"]["radius"]);
                ellipse cx=(format!("{x:.1}")) cy=(format!("{y:.1}")) rx=(format!("{:.1}", radius * across)) ry=(format!("{:.1}", radius * up)) {}
            }
            @if one["polygon"].is_array() { path d=(path(&one["polygon"], "z")) {} }
            @if one["polyline"].is_array() { path.open d=(path(&one["polyline"], "")) {} }
        } }
    };
    plot.content = content;
}

/// Returns cell edges, halfway between neighbouring coordinates of cell centres.
fn edges(places: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut places: Vec<f64> = places.filter(|place| place.is_finite()).collect();
    places.sort_by(f64::total_cmp);
    places.dedup();
    let (Some(first), Some(last)) = (places.first().copied(), places.last().copied()) else {
        return vec![0.0, 1.0];
    };
    let half = |a: usize, b: usize| match (places.get(a), places.get(b)) {
        (Some(a), Some(b)) => 0.5 * (b - a),
        _ => 0.5,
    };
    let mut edges = vec![first - half(0, 1)];
    edges.extend(places.windows(2).map(|pair| 0.5 * (pair[0] + pair[1])));
    edges.push(last + half(places.len().wrapping_sub(2), places.len() - 1));
    edges
}

fn colour(step: usize) -> String {
    let [red, green, blue] = step_colour(step);
    format!("rgb({red:.0} {green:.0} {blue:.0})")
}

/// Returns the colour of a step of the colour bar: red, green and blue from 0 to 255.
pub(crate) fn step_colour(step: usize) -> [f64; 3] {
    let place = step as f64 / (STEPS - 1) as f64 * (COLOURS.len() - 1) as f64;
    let below = (place as usize).min(COLOURS.len() - 2);
    let share = place - below as f64;
    let mix = |i: usize| COLOURS[below][i] + share * (COLOURS[below + 1][i] - COLOURS[below][i]);
    [mix(0), mix(1), mix(2)]
}
