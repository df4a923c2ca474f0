//! Parts of the page that stand only where the case asks for them.

use maud::{Markup, html};

use super::figures::{engine_name, number, window_name, with_error};
use super::page::{Column, table};
use crate::tables::SteadyRow;

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
