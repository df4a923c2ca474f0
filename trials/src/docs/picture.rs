//! Panels of curves as SVG.

use std::fmt::Write as _;

/// A curve with its name.
#[derive(Clone, Debug)]
pub(super) struct Curve {
    pub(super) name: String,
    /// By x.
    pub(super) points: Vec<[f64; 2]>,
}

/// Curves over one pair of axes.
#[derive(Clone, Debug)]
pub(super) struct Panel {
    pub(super) title: &'static str,
    pub(super) x: &'static str,
    /// Whether x, and y, are drawn as logarithms.
    pub(super) logarithmic: [bool; 2],
    pub(super) curves: Vec<Curve>,
}

/// Sizes \[pixels\].
const WIDTH: f64 = 360.0;
const HEIGHT: f64 = 300.0;
const LEFT: f64 = 48.0;
const RIGHT: f64 = 8.0;
const TOP: f64 = 28.0;
const BOTTOM: f64 = 40.0;
/// Colours that people with any colour vision tell apart (Okabe & Ito 2008).
const COLOURS: [&str; 5] = ["#0072b2", "#d55e00", "#009e73", "#999999", "#cc79a7"];

/// A picture of panels side by side. It is the same text for the same numbers.
pub(super) fn picture(panels: &[Panel]) -> String {
    let width = WIDTH * panels.len() as f64;
    let mut text = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {HEIGHT}\" font-family=\"sans-serif\" font-size=\"11\">\n\
         <rect width=\"{width}\" height=\"{HEIGHT}\" fill=\"#ffffff\"/>\n"
    );
    for (number, panel) in panels.iter().enumerate() {
        let _ = writeln!(
            text,
            "<g transform=\"translate({} 0)\">",
            WIDTH * number as f64
        );
        draw(panel, &mut text);
        text.push_str("</g>\n");
    }
    text.push_str("</svg>\n");
    text
}

/// An axis: its range, in logarithms where it is drawn so.
struct Axis {
    is_log: bool,
    low: f64,
    high: f64,
}

impl Axis {
    fn of(is_log: bool, values: impl Iterator<Item = f64>) -> Self {
        let scaled = values.map(|value| if is_log { value.log10() } else { value });
        let (low, high) = scaled
            .filter(|value| value.is_finite())
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
                (low.min(value), high.max(value))
            });
        let margin = (0.03 * (high - low)).max(1e-9);
        Self {
            is_log,
            low: low - margin,
            high: high + margin,
        }
    }

    /// Share of the axis at which a value lies.
    fn share(&self, value: f64) -> f64 {
        let value = if self.is_log { value.log10() } else { value };
        (value - self.low) / (self.high - self.low)
    }

    /// Values with a tick: powers of ten, or four to nine round numbers.
    fn ticks(&self) -> Vec<(f64, String)> {
        let range = |step: f64| (self.low / step).ceil() as i64..=(self.high / step).floor() as i64;
        if self.is_log {
            return range(1.0)
                .map(|power| (10_f64.powi(power as i32), format!("1e{power}")))
                .collect();
        }
        let span = self.high - self.low;
        let unit = 10_f64.powf((span / 5.0).log10().floor());
        let steps = [1.0, 2.0, 5.0, 10.0].map(|factor| factor * unit);
        let step = steps
            .into_iter()
            .find(|step| span / step <= 8.0)
            .unwrap_or(10.0 * unit);
        let digits = (-step.log10().floor()).clamp(0.0, 9.0) as usize;
        range(step)
            .map(|number| {
                let value = number as f64 * step;
                (value, format!("{value:.digits$}"))
            })
            .collect()
    }
}

fn draw(panel: &Panel, text: &mut String) {
    let all = || panel.curves.iter().flat_map(|curve| &curve.points);
    let [x, y] =
        [0, 1].map(|axis| Axis::of(panel.logarithmic[axis], all().map(|point| point[axis])));
    let across = |value: f64| LEFT + x.share(value) * (WIDTH - LEFT - RIGHT);
    let up = |value: f64| HEIGHT - BOTTOM - y.share(value) * (HEIGHT - TOP - BOTTOM);
    let (right, bottom) = (WIDTH - RIGHT, HEIGHT - BOTTOM);
    let _ = writeln!(
        text,
        "<text x=\"{LEFT}\" y=\"18\" font-weight=\"bold\">{}</text>\n<text x=\"{}\" y=\"{}\" text-anchor=\"middle\">{}</text>",
        panel.title,
        0.5 * (LEFT + right),
        HEIGHT - 8.0,
        panel.x
    );
    for (value, label) in x.ticks() {
        let at = across(value);
        let _ = writeln!(
            text,
            "<path d=\"M{at:.1} {TOP}V{bottom}\" stroke=\"#e5e5e5\"/><text x=\"{at:.1}\" y=\"{}\" text-anchor=\"middle\">{label}</text>",
            bottom + 14.0
        );
    }
    for (value, label) in y.ticks() {
        let at = up(value);
        let _ = writeln!(
            text,
            "<path d=\"M{LEFT} {at:.1}H{right}\" stroke=\"#e5e5e5\"/><text x=\"{}\" y=\"{:.1}\" text-anchor=\"end\">{label}</text>",
            LEFT - 4.0,
            at + 4.0
        );
    }
    let _ = writeln!(
        text,
        "<path d=\"M{LEFT} {TOP}V{bottom}H{right}\" fill=\"none\" stroke=\"#444444\"/>"
    );
    // The legend stands where fewest points are: below for curves that fall, above for those that rise.
    let rises = panel.curves.first().is_some_and(|curve| {
        curve
            .points
            .first()
            .zip(curve.points.last())
            .is_some_and(|(a, b)| a[1] < b[1])
    }) || !panel.logarithmic[1];
    let first = if rises {
        TOP + 14.0
    } else {
        bottom - 14.0 * panel.curves.len() as f64
    };
    for (number, curve) in panel.curves.iter().enumerate() {
        let colour = COLOURS[number % COLOURS.len()];
        let places = curve
            .points
            .iter()
            .map(|point| format!("{:.1} {:.1}", across(point[0]), up(point[1])));
        let places: Vec<String> = places.collect();
        let line = first + 14.0 * number as f64;
        let _ = writeln!(
            text,
            "<path d=\"M{}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"1.8\"/>\n<text x=\"{}\" y=\"{line}\" fill=\"{colour}\">{}</text>",
            places.join("L"),
            LEFT + 8.0,
            curve.name
        );
    }
}
