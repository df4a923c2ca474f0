//! Which curves belong together, in which colours, and what the caption says of them.
//!
//! Every engine has one colour and one mark in all plots. Where a panel belongs to one engine, its curves are times,
//! and these run through a second, ordered scale from dark to bright.

use std::fmt::Write as _;

use super::plot::{Axis, Chart, Curve, Mark, Point, Stroke, power};
use crate::tables::{
    ComparisonRow, EnergyRow, ImpactParameterRow, ImpactSummaryRow, PairCorrelationRow, SteadyRow,
    StructureFactorRow,
};

/// Label of the time axis.
pub(crate) const TIME: &str = "t / t₀";
/// Curves that one panel shows at most.
const CURVES: usize = 6;
/// Colours of the ordered scale in the style sheet.
const SHADES: usize = 7;

/// One numbered figure.
#[derive(Debug)]
pub(crate) struct Figure {
    /// What is plotted, in a few words.
    pub title: String,
    /// Panels with their titles; a single panel has none.
    pub panels: Vec<(String, Chart)>,
    /// What is seen and how to read it.
    pub caption: String,
}

impl Figure {
    /// Keeps the figure only if there is something to draw.
    pub(crate) fn drawable(mut self) -> Option<Self> {
        self.panels.retain(|(_, chart)| !chart.is_empty());
        (!self.panels.is_empty()).then_some(self)
    }
}

/// Name of an engine as the page writes it.
pub(crate) fn engine_name(engine: &str) -> String {
    match engine {
        "ed" => "ED".to_owned(),
        "dsmc" => "DSMC".to_owned(),
        "dsmc-boltzmann" => "DSMC Boltzmann".to_owned(),
        "dsmc-esmc" => "ESMC".to_owned(),
        other => match other.strip_prefix("dsmc-") {
            Some(scheme) => {
                let mut letters = scheme.chars();
                let first = letters.next().map(char::to_uppercase);
                let name: String = first.into_iter().flatten().chain(letters).collect();
                format!("DSMC {}", if scheme == "enskog" { &name } else { scheme })
            }
            None => other.to_owned(),
        },
    }
}

/// Place of an engine in every list.
fn rank(engine: &str) -> usize {
    const ORDER: [&str; 7] = [
        "ed",
        "dsmc-boltzmann",
        "dsmc-free-volume",
        "dsmc-enskog",
        "dsmc-esmc",
        "dsmc-stochastic-disks",
        "dsmc-contact-point",
    ];
    // Flows have one Monte Carlo engine, which has no scheme in its name.
    let known = (ORDER.iter())
        .position(|known| *known == engine || (engine == "dsmc" && *known == "dsmc-boltzmann"));
    known.unwrap_or(ORDER.len())
}

/// Colour of an engine.
pub(crate) fn engine_colour(engine: &str) -> String {
    format!("var(--engine-{})", rank(engine))
}

/// Mark of an engine.
pub(crate) fn engine_mark(engine: &str) -> Mark {
    Mark::ALL[rank(engine) % Mark::ALL.len()]
}

/// The engines that occur, ED first.
pub(crate) fn engines<'a>(names: impl Iterator<Item = &'a String>) -> Vec<String> {
    let mut found: Vec<String> = Vec::new();
    for name in names {
        if !found.contains(name) {
            found.push(name.clone());
        }
    }
    found.sort_by_key(|name| (rank(name), name.clone()));
    found
}

/// Colour number `place` of `count` in the ordered scale.
pub(crate) fn shade(place: usize, count: usize) -> String {
    let last = count.saturating_sub(1).max(1);
    format!("var(--shade-{})", (place * (SHADES - 1) + last / 2) / last)
}

/// Whether two times are the same up to rounding.
pub(crate) fn same(a: f64, b: f64) -> bool {
    a == b || (a - b).abs() <= 1e-9 * a.abs().max(b.abs())
}

/// The distinct values, increasing.
pub(crate) fn distinct(values: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut found: Vec<f64> = values.filter(|value| value.is_finite()).collect();
    found.sort_by(f64::total_cmp);
    found.dedup_by(|a, b| same(*a, *b));
    found
}

/// At most `most` of the items, evenly spread, the first and the last among them.
pub(crate) fn spread<T: Clone>(items: &[T], most: usize) -> Vec<T> {
    match (items.len(), most) {
        (_, 0) => Vec::new(),
        (count, most) if count <= most => items.to_vec(),
        (count, 1) => vec![items[count - 1].clone()],
        (count, most) => (0..most)
            .map(|i| items[(i * (count - 1) + (most - 1) / 2) / (most - 1)].clone())
            .collect(),
    }
}

/// A number with about `digits` significant digits.
pub(crate) fn number(value: f64, digits: usize) -> String {
    if !value.is_finite() {
        return "–".to_owned();
    }
    if value == 0.0 {
        return "0".to_owned();
    }
    let exponent = value.abs().log10().floor();
    let sign = if value < 0.0 { "−" } else { "" };
    let size = value.abs();
    // Zeros at the end of a fraction are dropped.
    let fraction = |size: f64, decimals: f64| {
        let text = format!("{size:.*}", decimals.max(0.0) as usize);
        if text.contains('.') {
            text.trim_end_matches('0').trim_end_matches('.').to_owned()
        } else {
            text
        }
    };
    let decimals = digits as f64 - 1.0;
    if (-3.0..6.0).contains(&exponent) {
        format!("{sign}{}", fraction(size, decimals - exponent))
    } else {
        let mantissa = fraction(size / 10_f64.powf(exponent), decimals);
        format!("{sign}{mantissa}·{}", power(exponent))
    }
}

/// A value with its standard error, both to the second significant digit of the error.
pub(crate) fn with_error(value: Option<f64>, error: Option<f64>) -> String {
    let Some(value) = value.filter(|value| value.is_finite()) else {
        return "–".to_owned();
    };
    match error.filter(|error| error.is_finite() && *error > 0.0) {
        None => number(value, 4),
        Some(error) => {
            let decimals = (1.0 - error.log10().floor()).clamp(0.0, 12.0) as usize;
            if decimals > 7 || value.abs() >= 1e6 {
                return format!("{} ± {}", number(value, 5), number(error, 2));
            }
            format!("{value:.decimals$} ± {error:.decimals$}").replace('-', "−")
        }
    }
}

/// Points of the rows of one engine.
pub(crate) fn curve<R>(
    engine: &str,
    stroke: Stroke,
    rows: &[R],
    point: impl Fn(&R) -> Option<Point>,
) -> Curve {
    Curve {
        label: engine_name(engine),
        colour: engine_colour(engine),
        mark: Some(engine_mark(engine)),
        stroke,
        points: ordered(rows.iter().filter_map(point)),
    }
}

/// The points by increasing abscissa.
pub(crate) fn ordered(points: impl Iterator<Item = Point>) -> Vec<Point> {
    let mut points: Vec<Point> = points.collect();
    points.sort_by(|a, b| a.x.total_cmp(&b.x));
    points
}

/// A dashed curve of theory.
pub(crate) fn theory(label: &str, points: Vec<Point>) -> Curve {
    Curve {
        label: label.to_owned(),
        colour: "var(--ink)".to_owned(),
        mark: None,
        stroke: Stroke::Dashed,
        points,
    }
}

/// Energy against time; `steady` holds the quarters of a driven run.
pub(crate) fn energy(rows: &[EnergyRow], steady: Option<&[SteadyRow]>) -> Option<Figure> {
    let level = steady.and_then(|rows| rows.iter().find_map(|row| row.theory_ratio));
    let names = engines(rows.iter().map(|row| &row.engine));
    let mut curves: Vec<Curve> = Vec::new();
    let law = ordered(rows.iter().filter_map(|row| {
        row.haff_ratio.map(|y| Point {
            x: row.time_over_t0,
            y,
            error: None,
        })
    }));
    let has_law = !law.is_empty();
    if has_law {
        curves.push(theory("Haff’s law (1 + t/t₀)⁻²", law));
    }
    for name in &names {
        curves.push(curve(name, Stroke::Thin, rows, |row| {
            (row.engine == *name).then_some(Point {
                x: row.time_over_t0,
                y: row.energy_ratio,
                error: row.energy_ratio_se,
            })
        }));
    }
    let mut caption =
        "Kinetic energy over its initial value against time, both logarithmic. ".to_owned();
    if let Some(last) = rows
        .iter()
        .map(|row| row.time_over_t0)
        .max_by(f64::total_cmp)
    {
        let at_end: Vec<&EnergyRow> = rows
            .iter()
            .filter(|row| same(row.time_over_t0, last))
            .collect();
        let mut parts: Vec<String> = names
            .iter()
            .filter_map(|name| at_end.iter().find(|row| row.engine == *name))
            .map(|row| {
                format!(
                    "{} {}",
                    engine_name(&row.engine),
                    number(row.energy_ratio, 3)
                )
            })
            .collect();
        if let Some(law) = at_end.iter().find_map(|row| row.haff_ratio) {
            parts.push(format!("Haff’s law {}", number(law, 3)));
        }
        let _ = write!(
            caption,
            "At the last time, t/t₀ = {}, the ratio is: {}. ",
            number(last, 3),
            parts.join(", ")
        );
    }
    if has_law {
        caption += "Points above the dashed line cool more slowly than a homogeneous gas.";
    }
    if let Some(level) = level {
        let _ = write!(
            caption,
            "The dashed line at {} is where Enskog’s theory balances heating and dissipation.",
            number(level, 4)
        );
    }
    let title = if steady.is_some() {
        "Energy of the driven gas"
    } else {
        "Cooling"
    };
    Figure {
        title: title.to_owned(),
        panels: vec![(
            String::new(),
            Chart {
                x: Axis::logarithmic(TIME),
                y: Axis::logarithmic("K(t) / K(0)"),
                curves,
                level,
            },
        )],
        caption,
    }
    .drawable()
}

/// Quotient of energies against time.
pub(crate) fn quotient(rows: &[ComparisonRow]) -> Option<Figure> {
    let with_ed = rows
        .iter()
        .any(|row| row.engine_a == "ed" || row.engine_b == "ed");
    let mut pairs: Vec<(String, String)> = Vec::new();
    for row in rows {
        let pair = (row.engine_a.clone(), row.engine_b.clone());
        if !pairs.contains(&pair) && (!with_ed || pair.0 == "ed" || pair.1 == "ed") {
            pairs.push(pair);
        }
    }
    let mut curves = Vec::new();
    let mut notes = Vec::new();
    for (a, b) in &pairs {
        let other = if a == "ed" { b } else { a };
        let of_pair = |row: &&ComparisonRow| row.engine_a == *a && row.engine_b == *b;
        let label = format!("{} / {}", engine_name(a), engine_name(b));
        curves.push(Curve {
            label: label.clone(),
            ..curve(other, Stroke::Thin, rows, |row| {
                of_pair(&row).then_some(Point {
                    x: row.time_over_t0,
                    y: row.quotient,
                    error: row.quotient_se,
                })
            })
        });
        let last = rows
            .iter()
            .filter(of_pair)
            .max_by(|a, b| a.time_over_t0.total_cmp(&b.time_over_t0));
        if let Some(last) = last {
            let z = last
                .z
                .map_or(String::new(), |z| format!(", z = {}", number(z, 2)));
            notes.push(format!(
                "{label} ends at {}{z}",
                with_error(Some(last.quotient), last.quotient_se)
            ));
        }
    }
    Figure {
        title: "Quotient of energies".to_owned(),
        panels: vec![(
            String::new(),
            Chart { x: Axis::logarithmic(TIME), y: Axis::linear("quotient of K"), curves, level: Some(1.0) },
        )],
        caption: format!(
            "Energy of one engine over that of the other at the same time, with standard errors. {}. Above the \
             dashed line at one, the first engine has kept more energy.",
            notes.join("; ")
        ),
    }
    .drawable()
}

/// A time window.
pub(crate) type Window = (f64, f64);

/// The distinct windows, by their start.
pub(crate) fn windows(windows: impl Iterator<Item = Window>) -> Vec<Window> {
    let mut found: Vec<Window> = windows
        .filter(|w| w.0.is_finite() && w.1.is_finite())
        .collect();
    found.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
    found.dedup_by(|a, b| same(a.0, b.0) && same(a.1, b.1));
    found
}

/// A window in words.
pub(crate) fn window_name((start, end): Window) -> String {
    format!("t/t₀ {} to {}", number(start, 3), number(end, 3))
}

/// Points of the distribution of the impact parameter of one engine in one window.
pub(crate) fn impact_points(
    rows: &[ImpactParameterRow],
    engine: &str,
    window: Window,
) -> Vec<Point> {
    ordered(
        rows.iter()
            .filter(|row| {
                row.engine == engine
                    && same(row.window_start, window.0)
                    && same(row.window_end, window.1)
            })
            .map(|row| Point {
                x: 0.5 * (row.bin_low + row.bin_high),
                y: row.density,
                error: row.density_se,
            }),
    )
}

/// Distribution of the impact parameter, one panel for each engine.
pub(crate) fn impact(rows: &[ImpactParameterRow], summary: &[ImpactSummaryRow]) -> Option<Figure> {
    let all = windows(rows.iter().map(|row| (row.window_start, row.window_end)));
    let shown = spread(&all, CURVES);
    let mut panels = Vec::new();
    for name in engines(rows.iter().map(|row| &row.engine)) {
        let curves = shown.iter().enumerate().map(|(place, window)| Curve {
            label: window_name(*window),
            colour: shade(place, shown.len()),
            mark: Some(Mark::ALL[place % Mark::ALL.len()]),
            stroke: Stroke::Thin,
            points: impact_points(rows, &name, *window),
        });
        panels.push((
            engine_name(&name),
            Chart {
                x: Axis::linear("b / d").over(0.0, 1.0),
                y: Axis::linear("P(b/d)"),
                curves: curves.collect(),
                level: Some(1.0),
            },
        ));
    }
    share_ordinates(&mut panels);
    let mut caption = "Distribution of the impact parameter b over the diameter d of colliding pairs in each time \
                       window, with standard errors. Molecular chaos means the dashed line at one: head-on \
                       (b = 0) and grazing (b = d) collisions are equally frequent. "
        .to_owned();
    let steepest = summary
        .iter()
        .filter(|row| row.engine == "ed")
        .filter_map(|row| {
            row.slope
                .filter(|slope| slope.is_finite())
                .map(|slope| (slope, row))
        });
    if let Some((slope, row)) = steepest.max_by(|a, b| a.0.abs().total_cmp(&b.0.abs())) {
        let _ = write!(
            caption,
            "The steepest window of ED is {} with a slope of {}. ",
            window_name((row.window_start, row.window_end)),
            with_error(Some(slope), row.slope_se)
        );
    }
    caption += &selection("windows", shown.len(), all.len());
    Figure {
        title: "Impact parameter".to_owned(),
        panels,
        caption,
    }
    .drawable()
}

/// Says that only some curves are drawn.
fn selection(what: &str, shown: usize, all: usize) -> String {
    if shown < all {
        format!("Drawn are {shown} of {all} {what}; the table has them all.")
    } else {
        String::new()
    }
}

/// Gives panels that stand side by side the same vertical range.
pub(crate) fn share_ordinates(panels: &mut [(String, Chart)]) {
    let ranges: Vec<(f64, f64)> = panels
        .iter()
        .filter_map(|(_, chart)| chart.ordinates())
        .collect();
    let low = ranges.iter().map(|range| range.0).min_by(f64::total_cmp);
    let high = ranges.iter().map(|range| range.1).max_by(f64::total_cmp);
    if let (Some(low), Some(high)) = (low, high) {
        for (_, chart) in panels {
            chart.y.span = Some((low, high));
        }
    }
}

/// Structure factor, one panel for each engine.
pub(crate) fn structure(rows: &[StructureFactorRow]) -> Option<Figure> {
    let all = distinct(rows.iter().map(|row| row.time_over_t0));
    let shown = spread(&all, CURVES);
    let names = engines(rows.iter().map(|row| &row.engine));
    let mut panels = Vec::new();
    let mut averaged = false;
    for name in &names {
        let mut curves = Vec::new();
        for (place, time) in shown.iter().enumerate() {
            let of_time: Vec<&StructureFactorRow> = rows
                .iter()
                .filter(|row| row.engine == *name && same(row.time_over_t0, *time))
                .collect();
            let points = structure_points(&of_time);
            averaged |= points.len() < of_time.len();
            curves.push(Curve {
                label: format!("t/t₀ = {}", number(*time, 3)),
                colour: shade(place, shown.len()),
                mark: Some(Mark::ALL[place % Mark::ALL.len()]),
                stroke: Stroke::Thin,
                points,
            });
        }
        panels.push((
            engine_name(name),
            Chart {
                x: Axis::logarithmic("k = L / λ"),
                y: Axis::logarithmic("S(k)"),
                curves,
                level: Some(1.0),
            },
        ));
    }
    share_ordinates(&mut panels);
    let mut caption = "Structure factor against the wave number k, the number of wavelengths λ in the side L. The \
                       dashed line at one is an ideal gas; a rise at small k is the growth of clusters, values \
                       below one are the order of disks that exclude each other. "
        .to_owned();
    if let Some(last) = all.last() {
        let parts: Vec<String> = names
            .iter()
            .filter_map(|name| {
                rows.iter()
                    .filter(|row| {
                        row.engine == *name && same(row.time_over_t0, *last) && row.k > 0.0
                    })
                    .max_by(|a, b| a.structure_factor.total_cmp(&b.structure_factor))
            })
            .map(|row| {
                format!(
                    "{} {} at k = {}",
                    engine_name(&row.engine),
                    number(row.structure_factor, 3),
                    number(row.k, 3)
                )
            })
            .collect();
        let _ = write!(
            caption,
            "Largest value at t/t₀ = {}: {}. ",
            number(*last, 3),
            parts.join(", ")
        );
    }
    if averaged {
        caption +=
            "Neighbouring shells are averaged, weighted by their modes, where they would overlap. ";
    }
    caption += &selection("times", shown.len(), all.len());
    Figure {
        title: "Structure factor".to_owned(),
        panels,
        caption,
    }
    .drawable()
}

/// Points of a structure factor; shells that would overlap on a logarithmic axis are averaged.
fn structure_points(rows: &[&StructureFactorRow]) -> Vec<Point> {
    /// Averages per decade of wave numbers.
    const BINS: f64 = 14.0;
    let mut rows: Vec<&StructureFactorRow> = rows
        .iter()
        .copied()
        .filter(|row| row.k > 0.0 && row.structure_factor.is_finite())
        .collect();
    rows.sort_by(|a, b| a.k.total_cmp(&b.k));
    let mut points = Vec::new();
    let bin = |row: &StructureFactorRow| (row.k.log10() * BINS).floor();
    for group in rows.chunk_by(|a, b| bin(a) == bin(b)) {
        let weight = |row: &StructureFactorRow| row.modes.max(1) as f64;
        let total: f64 = group.iter().map(|row| weight(row)).sum();
        let mean = |value: &dyn Fn(&StructureFactorRow) -> f64| {
            group
                .iter()
                .map(|row| weight(row) * value(row))
                .sum::<f64>()
                / total
        };
        let variance: Option<f64> = group
            .iter()
            .map(|row| {
                row.structure_factor_se
                    .map(|error| (weight(row) * error / total).powi(2))
            })
            .sum();
        points.push(Point {
            x: mean(&|row| row.k),
            y: mean(&|row| row.structure_factor),
            error: variance.map(f64::sqrt),
        });
    }
    points
}

/// Pair correlation function of every engine at its last time.
pub(crate) fn pair(rows: &[PairCorrelationRow]) -> Option<Figure> {
    let mut curves = Vec::new();
    let mut notes = Vec::new();
    let mut last_time = f64::NEG_INFINITY;
    for name in engines(rows.iter().map(|row| &row.engine)) {
        let times = distinct(
            rows.iter()
                .filter(|row| row.engine == name)
                .map(|row| row.time_over_t0),
        );
        let Some(last) = times.last().copied() else {
            continue;
        };
        last_time = last_time.max(last);
        let of_engine = curve(&name, Stroke::Solid, rows, |row| {
            (row.engine == name && same(row.time_over_t0, last)).then_some(Point {
                x: row.r_over_d,
                y: row.g,
                error: row.g_se,
            })
        });
        let of_engine = Curve {
            mark: None,
            ..of_engine
        };
        let highest = of_engine.points.iter().filter(|p| p.y.is_finite());
        if let Some(highest) = highest.max_by(|a, b| a.y.total_cmp(&b.y)) {
            notes.push(format!(
                "{} {} at r/d = {}",
                of_engine.label,
                number(highest.y, 3),
                number(highest.x, 3)
            ));
        }
        curves.push(of_engine);
    }
    let farthest = rows
        .iter()
        .map(|row| row.r_over_d)
        .filter(|r| r.is_finite())
        .fold(1.0, f64::max);
    Figure {
        title: "Pair correlation".to_owned(),
        panels: vec![(
            String::new(),
            Chart { x: Axis::linear("r / d").over(0.0, farthest), y: Axis::linear("g(r)"), curves, level: Some(1.0) },
        )],
        caption: format!(
            "Pair correlation function at the last time, t/t₀ = {}. The dashed line at one is an ideal gas. Highest \
             values: {}. Disks of ED cannot come nearer than r = d, those of DSMC may overlap.",
            number(last_time, 3),
            notes.join(", ")
        ),
    }
    .drawable()
}

/// Fourth cumulant against time.
pub(crate) fn cumulant(rows: &[EnergyRow], expected: Option<f64>) -> Option<Figure> {
    let names = engines(rows.iter().map(|row| &row.engine));
    let mut curves = Vec::new();
    let times = distinct(
        rows.iter()
            .map(|row| row.time_over_t0)
            .filter(|time| *time > 0.0),
    );
    if let (Some(level), Some(first), Some(last)) = (expected, times.first(), times.last()) {
        let ends = [*first, *last].map(|x| Point {
            x,
            y: level,
            error: None,
        });
        curves.push(theory("theory", ends.to_vec()));
    }
    for name in &names {
        curves.push(curve(name, Stroke::Thin, rows, |row| {
            (row.engine == *name).then_some(Point {
                x: row.time_over_t0,
                y: row.fourth_cumulant,
                error: row.fourth_cumulant_se,
            })
        }));
    }
    let last = times.last().copied().unwrap_or(f64::NAN);
    let values: Vec<String> = names
        .iter()
        .filter_map(|name| {
            rows.iter()
                .find(|row| row.engine == *name && same(row.time_over_t0, last))
        })
        .map(|row| {
            let value = with_error(Some(row.fourth_cumulant), row.fourth_cumulant_se);
            format!("{} {value}", engine_name(&row.engine))
        })
        .collect();
    let mut caption = format!(
        "Fourth cumulant a₂ of the velocity distribution, zero for a Gaussian, against time. At the last time: {}. ",
        values.join(", ")
    );
    if let Some(expected) = expected {
        let _ = write!(
            caption,
            "The dashed line is the homogeneous state of kinetic theory, a₂ = {}.",
            number(expected, 3)
        );
    }
    Figure {
        title: "Velocity distribution".to_owned(),
        panels: vec![(
            String::new(),
            Chart {
                x: Axis::logarithmic(TIME),
                y: Axis::linear("a₂"),
                curves,
                level: None,
            },
        )],
        caption,
    }
    .drawable()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_written_to_the_second_digit_of_their_error() {
        assert_eq!(with_error(Some(1.05234), Some(0.00712)), "1.0523 ± 0.0071");
        assert_eq!(with_error(Some(-0.5), None), "−0.5");
        assert_eq!(with_error(None, Some(1.0)), "–");
        assert_eq!(with_error(Some(1234.0), Some(56.0)), "1234 ± 56");
        assert_eq!(number(f64::NAN, 3), "–");
        assert_eq!(number(1.5e-5, 2), "1.5·10⁻⁵");
        assert_eq!(number(100.0, 3), "100");
        assert_eq!(number(0.30, 3), "0.3");
    }

    #[test]
    fn a_selection_keeps_both_ends() {
        let all: Vec<usize> = (0..30).collect();
        let some = spread(&all, 6);
        assert_eq!((some[0], some[5], some.len()), (0, 29, 6));
        assert_eq!(spread(&all, 1), [29]);
        assert_eq!(shade(0, 1), "var(--shade-0)");
        assert_eq!(shade(5, 6), "var(--shade-6)");
    }

    #[test]
    fn engines_have_names() {
        assert_eq!(engine_name("ed"), "ED");
        assert_eq!(engine_name("dsmc-free-volume"), "DSMC free-volume");
        assert_eq!(engine_name("dsmc-enskog"), "DSMC Enskog");
    }
}
