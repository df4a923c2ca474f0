//! Maps: a quantity over the plane as coloured cells, with a colour bar.

use std::fmt::Write as _;

use maud::html;
use serde_json::{Value, json};
use stosszahl_results::AxisScale;

use crate::chart::short;
use crate::draw::{BOTTOM, LEFT, Plot, TOP, WIDTH, axes};
use crate::scale::AxisRange;

/// Margin on the right, for the colour bar \[px\].
const RIGHT: f64 = 84.0;
/// Smallest and largest height of the map \[px\].
const HEIGHTS: [f64; 2] = [90.0, 380.0];
/// Colours of the bar, lowest first (viridis).
const COLOURS: [[f64; 3]; 6] = [
    [68.0, 1.0, 84.0],
    [65.0, 68.0, 135.0],
    [42.0, 120.0, 142.0],
    [34.0, 168.0, 132.0],
    [122.0, 209.0, 81.0],
    [253.0, 231.0, 37.0],
];
/// Number of colour steps.
const STEPS: usize = 48;

/// Map of a quantity over the plane.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Map {
    /// Labels of the axes.
    pub labels: [String; 2],
    /// Label of the colour bar.
    pub value: String,
    /// Scale of the colours.
    pub scale: AxisScale,
    /// Coordinates `x`, `y` and the quantity there.
    pub cells: Vec<[f64; 3]>,
}

impl Map {
    /// Smallest and largest value; `None` without values.
    pub fn range(&self) -> Option<(f64, f64)> {
        crate::scale::extent(self.scale, self.cells.iter().map(|cell| cell[2]))
    }

    /// Draws the map with colours from `low` to `high`.
    pub fn plot(&self, (low, high): (f64, f64), description: String) -> Plot {
        let edges = [0, 1].map(|axis| edges(self.cells.iter().map(|cell| cell[axis])));
        let ends = edges
            .each_ref()
            .map(|edges| (edges[0], edges[edges.len() - 1]));
        let width = WIDTH - LEFT - RIGHT;
        let aspect = (ends[1].1 - ends[1].0) / (ends[0].1 - ends[0].0);
        let height = (width * aspect).clamp(HEIGHTS[0], HEIGHTS[1]);
        let frame = |ends| AxisRange::range_around(AxisScale::Linear, ends, true);
        let (x, y) = (frame(ends[0]), frame(ends[1]));
        let bar = AxisRange::range_around(self.scale, (low, high), high > low);
        // All cells of one colour form one path.
        let mut paths = vec![String::new(); STEPS];
        let shown = self
            .cells
            .iter()
            .filter(|cell| bar.position_of(cell[2]).is_some());
        for cell in shown {
            let around = |axis: usize| {
                let after = edges[axis].partition_point(|edge| *edge <= cell[axis]);
                let after = after.clamp(1, edges[axis].len() - 1);
                (edges[axis][after - 1], edges[axis][after])
            };
            let ((left, right), (bottom, top)) = (around(0), around(1));
            let share = bar.clamped(cell[2]);
            let step = ((share * STEPS as f64) as usize).min(STEPS - 1);
            let (left, right) = (x.clamped(left) * width, x.clamped(right) * width);
            let (top, bottom) = (y.clamped(top), y.clamped(bottom));
            let (top, bottom) = ((1.0 - top) * height, (1.0 - bottom) * height);
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

    /// Numbers of the map in JSON: axis ranges, position of the frame in the drawing, and cells.
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

/// Cell edges, halfway between distinct neighbouring coordinates.
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
    let place = step as f64 / (STEPS - 1) as f64 * (COLOURS.len() - 1) as f64;
    let below = (place as usize).min(COLOURS.len() - 2);
    let share = place - below as f64;
    let mix = |i: usize| COLOURS[below][i] + share * (COLOURS[below + 1][i] - COLOURS[below][i]);
    format!("rgb({:.0} {:.0} {:.0})", mix(0), mix(1), mix(2))
}
