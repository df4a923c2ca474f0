//! Parts of the page that stand only where the case asks for them.

use maud::{Markup, html};

use super::figures::{
    Figure, curve, engine_name, engines, number, ordered, same, theory, window_name, with_error,
};
use super::page::{Column, table};
use super::plot::{Axis, Chart, Point, Stroke};
use crate::tables::{
    DisplacementRow, ErrorBudgetRow, Mark, PairImpactRow, PartialTemperatureRow, SteadyRow,
};

/// Table of the quarters of a driven run.
pub(crate) fn steady(rows: &[SteadyRow]) -> Markup {
    let lines: Vec<Vec<String>> = rows
        .iter()
        .map(|row| {
            vec![
                engine_name(&row.engine),
                window_name((row.window_start, row.window_end)),
                with_error(row.temperature_ratio, row.temperature_ratio_se),
                row.theory_ratio
                    .map_or_else(|| "–".to_owned(), |ratio| number(ratio, 5)),
            ]
        })
        .collect();
    let columns: [Column; 4] = [
        ("engine", true),
        ("quarter of the run", true),
        ("T/T(0)", false),
        ("theory", false),
    ];
    html! {
        p {
            "Mean temperature over quarters of the run. Where the gas has settled the last two agree; the value of theory is that "
            "at which Enskog’s dissipation equals the heating."
        }
        (table("Quarters of the run", &columns, &lines))
    }
}

/// Table of the sources of error.
pub(crate) fn error_budget(rows: &[ErrorBudgetRow]) -> Markup {
    let value = |number_of: Option<f64>| number_of.map_or_else(|| "–".to_owned(), |x| number(x, 3));
    let lines: Vec<Vec<String>> = rows
        .iter()
        .map(|row| {
            let mark = match row.mark {
                Mark::Green => "● green",
                Mark::Amber => "◐ amber",
                Mark::Red => "○ red",
            };
            vec![
                engine_name(&row.engine),
                row.source.clone(),
                format!("{} {}", value(row.value), row.unit),
                value(row.estimate.map(|share| 100.0 * share)),
                mark.to_owned(),
                row.reason.clone(),
            ]
        })
        .collect();
    let columns: [Column; 6] = [
        ("engine", true),
        ("source", true),
        ("measured", true),
        ("estimate, %", false),
        ("mark", true),
        ("why", true),
    ];
    html! {
        p {
            "Rough estimates of the error of each numerical choice: green up to 1 %, amber up to 5 %, red beyond or unknown. "
            "They say what to refine next; " code { "stosszahl frontier" } " measures errors."
        }
        (table("Error budget", &columns, &lines))
    }
}

/// Mean squared displacement against the time since its start.
pub(crate) fn displacement(rows: &[DisplacementRow]) -> Option<Figure> {
    let names = engines(rows.iter().map(|row| &row.engine));
    let mut curves = Vec::new();
    let first = names.first()?;
    let law = ordered(rows.iter().filter_map(|row| {
        (row.engine == *first).then_some(Point {
            x: row.elapsed_over_t0,
            y: row.theory_over_d2?,
            error: None,
        })
    }));
    let has_law = !law.is_empty();
    if has_law {
        curves.push(theory("Enskog’s theory", law));
    }
    let mut notes = Vec::new();
    for name in &names {
        curves.push(curve(name, Stroke::Thin, rows, |row| {
            (row.engine == *name).then_some(Point {
                x: row.elapsed_over_t0,
                y: row.displacement_square_over_d2,
                error: row.displacement_square_over_d2_se,
            })
        }));
        let last = rows
            .iter()
            .filter(|row| row.engine == *name)
            .max_by(|a, b| a.elapsed_over_t0.total_cmp(&b.elapsed_over_t0));
        notes.extend(last.map(|row| {
            let value = with_error(
                Some(row.displacement_square_over_d2),
                row.displacement_square_over_d2_se,
            );
            format!("{} {value}", engine_name(name))
        }));
    }
    let mut caption = format!(
        "Mean squared displacement of the disks, in squared diameters, against the time since the start of its \
         measurement, both logarithmic. At the end: {}. ",
        notes.join(", ")
    );
    if has_law {
        caption += "The dashed line is theory in first Sonine order: ballistic at first, diffusive in a steady gas later, \
                    and as the logarithm of time in a gas that cools.";
    }
    Figure {
        title: "Mean squared displacement".to_owned(),
        panels: vec![(
            String::new(),
            Chart {
                x: Axis::logarithmic("t / t₀ since the start of the measurement"),
                y: Axis::logarithmic("<R²> / d²"),
                curves,
                level: None,
            },
        )],
        caption,
    }
    .drawable()
}

/// Temperatures of the species over that of the first, against time.
pub(crate) fn partial_temperatures(rows: &[PartialTemperatureRow]) -> Option<Figure> {
    let names = engines(rows.iter().map(|row| &row.engine));
    let first = names.first()?;
    let last = rows.iter().map(|row| row.species).max()?;
    let panels = (2..=last)
        .map(|species| {
            let own = || rows.iter().filter(move |row| row.species == species);
            let mut curves = Vec::new();
            let law = ordered(own().filter(|row| row.engine == *first).filter_map(|row| {
                Some(Point {
                    x: row.time_over_t0,
                    y: row.ratio_to_first_theory?,
                    error: None,
                })
            }));
            if !law.is_empty() {
                curves.push(theory("Enskog’s equations", law));
            }
            for name in &names {
                curves.push(curve(name, Stroke::None, rows, |row| {
                    (row.engine == *name && row.species == species).then_some(Point {
                        x: row.time_over_t0,
                        y: row.ratio_to_first,
                        error: row.ratio_to_first_se,
                    })
                }));
            }
            let title = if last > 2 {
                format!("species {species}")
            } else {
                String::new()
            };
            let chart = Chart {
                x: Axis::logarithmic(super::figures::TIME),
                y: Axis::linear(&format!("T{species} / T1")),
                curves,
                level: None,
            };
            (title, chart)
        })
        .collect();
    Figure {
        title: "Partial temperatures".to_owned(),
        panels,
        caption: "Temperature of each species over that of the first, against the logarithm of time. Unlike disks do not share \
                  their energy alike in a gas that cools."
            .to_owned(),
    }
    .drawable()
}

/// Impact parameters by kind of pair in the first window.
pub(crate) fn pair_impact(rows: &[PairImpactRow]) -> Option<Figure> {
    let first = rows.first()?;
    let names = engines(rows.iter().map(|row| &row.engine));
    let window = (first.window_start, first.window_end);
    let mut pairs: Vec<(u64, u64)> = rows
        .iter()
        .map(|row| (row.species_a, row.species_b))
        .collect();
    pairs.sort_unstable();
    pairs.dedup();
    let panels = pairs
        .into_iter()
        .map(|pair| {
            let curves = names.iter().map(|name| {
                curve(name, Stroke::None, rows, |row| {
                    let here = same(row.window_start, window.0)
                        && same(row.window_end, window.1)
                        && (row.species_a, row.species_b) == pair;
                    (here && row.engine == *name).then_some(Point {
                        x: 0.5 * (row.bin_low + row.bin_high),
                        y: row.density,
                        error: row.density_se,
                    })
                })
            });
            let chart = Chart {
                x: Axis::linear("b / d").over(0.0, 1.0),
                y: Axis::linear("P(b/d)"),
                curves: curves.collect(),
                level: Some(1.0),
            };
            (format!("species {} and {}", pair.0, pair.1), chart)
        })
        .collect();
    Figure {
        title: "Impact parameters by kind of pair".to_owned(),
        panels,
        caption: format!(
            "Distribution of the impact parameter over the distance at contact in the window {}, for each kind of pair. It is \
             uniform under molecular chaos.",
            window_name(window)
        ),
    }
    .drawable()
}
