//! Parts of the page that stand only where the case asks for them.

use maud::{Markup, html};

use super::figures::{
    Figure, curve, engine_name, engines, number, ordered, theory, window_name, with_error,
};
use super::page::{Column, table};
use super::plot::{Axis, Chart, Point, Stroke};
use crate::tables::{DisplacementRow, ErrorBudgetRow, Mark, SteadyRow};

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
