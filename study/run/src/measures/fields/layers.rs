//! `boundary_layers.csv`: how far walls slow a flow down that goes along them.

use stosszahl_analysis::fields::{Along, Fields as Sums, measure};
use stosszahl_results::{Axis, Estimate, Figure, Table, table};

use super::tables::{estimates, units};
use super::{Options, channel};
use crate::measures::course::{self, Window};
use crate::plan::{EnginePlan, Plan};

/// Place of the velocity along the channel among the quantities of a cell.
const SPEED: usize = 1;

/// The empty table.
pub(super) fn table() -> Table {
    let table = table! {
        "boundary_layers", "The layers that the walls of a channel slow down, at one place along it and in one window of time";
        key "engine", "", "Engine";
        key "window_start", "time", "Start of the window";
        key "window_end", "time", "End of the window";
        key "x", "length", "Place along the channel";
        estimate "centre_velocity", "sqrt(energy/mass)", "Mean velocity u_c along the channel in the middle fifth of its height";
        estimate "displacement_thickness", "length",
            "Displacement thickness of a layer, the integral of 1 - u/u_c over the height of the channel, for one of its two walls";
        estimate "slip", "1", "Mean velocity in the cells at the walls over u_c";
    };
    let figure = Figure::curves(
        "Boundary layers",
        Axis::linear("x", "x"),
        Axis::linear("displacement_thickness", "displacement thickness"),
    );
    let caption = "Displacement thickness of the layers at the walls: the integral of 1 − u/u_c from a wall to the middle. Layers have \
                   met where it no longer grows.";
    table.figure(
        figure
            .by(&["engine"])
            .panels(&["window_start"])
            .caption(caption),
    )
}

/// Whether the fields of a case are those of a channel, and fine enough.
pub(super) fn has_layers(plan: &Plan, options: &Options) -> bool {
    channel::is_channel(&plan.case) && options.cells[1] >= channel::FEWEST_ROWS as u64
}

/// Adds an engine in a window.
pub(super) fn fill(
    table: &mut Table,
    plan: &Plan,
    engine: &EnginePlan,
    sums: &[&Sums],
    window: &Window,
) {
    let Some(first) = sums.first() else {
        return;
    };
    let [columns, rows] = Options::of(plan).cells.map(|count| count as usize);
    let length = plan.scale.length;
    let freedom = course::freedom(plan);
    let found = measure(sums, window.blocks.clone(), None, Along::Cells, freedom);
    let height = plan.lengths[1] * length;
    for column in 0..columns {
        let across: Vec<Estimate> = (0..rows)
            .map(|row| estimates(&found[column + columns * row], units(plan))[SPEED])
            .collect();
        let place = first.grid().centre(column)[0] * length;
        table.add((engine.name, window.times, place, layer(&across, height)));
    }
}

/// Velocity in the middle, displacement thickness and slip of the velocities across a channel.
///
/// With `S = sum u_j`, the mean M over the middle and cells of the width `H/J` the thickness is `(H - (H/J) S/M)/2`; its error is
/// that of cells without correlations.
fn layer(across: &[Estimate], height: f64) -> [Estimate; 3] {
    let count = across.len();
    let middle = channel::middle(count);
    let (width, few) = (height / count as f64, middle.len() as f64);
    let value = |one: &Estimate| one.value.unwrap_or(f64::NAN);
    let sum: f64 = across.iter().map(value).sum();
    let centre = across[middle.clone()].iter().map(value).sum::<f64>() / few;
    let edges = 0.5 * (value(&across[0]) + value(&across[count - 1]));
    // Derivatives by the velocity of each cell.
    let in_middle = |cell: usize| {
        if middle.contains(&cell) {
            1.0 / few
        } else {
            0.0
        }
    };
    let at_edge = |cell: usize| {
        if cell == 0 || cell == count - 1 {
            0.5
        } else {
            0.0
        }
    };
    let with_error = |value: f64, derivative: &dyn Fn(usize) -> f64| {
        let square = |(cell, one): (usize, &Estimate)| {
            one.standard_error
                .map(|error| (derivative(cell) * error).powi(2))
        };
        let squares: Option<f64> = across.iter().enumerate().map(square).sum();
        Estimate::of(value, squares.map(f64::sqrt))
    };
    [
        with_error(centre, &in_middle),
        with_error(0.5 * (height - width * sum / centre), &|cell| {
            0.5 * width * (sum / centre * in_middle(cell) - 1.0) / centre
        }),
        with_error(edges / centre, &|cell| {
            (at_edge(cell) - edges / centre * in_middle(cell)) / centre
        }),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Poiseuille's profile `u = 4 y (1 - y)`, by the means over cells: the layer of one wall is a sixth of the height.
    #[test]
    fn the_layer_of_a_parabola_is_a_sixth_of_the_height() {
        let count = 1000;
        let integral = |y: f64| 2.0 * y * y - 4.0 / 3.0 * y * y * y;
        let cell = |j: usize| {
            let [a, b] = [j, j + 1].map(|edge| edge as f64 / count as f64);
            Estimate::of(3.0 * (integral(b) - integral(a)) * count as f64, Some(0.1))
        };
        let across: Vec<Estimate> = (0..count).map(cell).collect();
        let [centre, thickness, slip] = layer(&across, 2.0);
        // The mean over the middle fifth: 3 (integral from 2/5 to 3/5)/(1/5).
        let middle = 15.0 * (integral(0.6) - integral(0.4));
        let value = |one: Estimate| one.value.expect("a value");
        assert!((value(centre) - middle).abs() < 1e-12);
        assert!((value(thickness) - (1.0 - 2.0 / middle)).abs() < 1e-12);
        assert!(value(slip) < 0.01);
        // Independent errors of 0.1 in each of the 200 cells in the middle.
        let error = centre.standard_error.expect("an error");
        assert!((error - 0.1 / 200.0_f64.sqrt()).abs() < 1e-12);
    }

    /// Errors are those of the velocities carried over: by differences of the whole function.
    #[test]
    fn errors_are_carried_over() {
        let speeds = [0.3, 0.8, 1.1, 1.0, 0.7, 0.2];
        let errors = [0.02, 0.01, 0.03, 0.02, 0.01, 0.04];
        let of = |speeds: [f64; 6]| {
            let all = speeds.iter().zip(errors);
            let all: Vec<Estimate> = all.map(|(u, e)| Estimate::of(*u, Some(e))).collect();
            layer(&all, 3.0)
        };
        let found = of(speeds);
        for (quantity, found) in found.iter().enumerate() {
            let mut square = 0.0;
            for cell in 0..6 {
                let moved = |by: f64| {
                    let mut moved = speeds;
                    moved[cell] += by;
                    of(moved)[quantity].value.expect("a value")
                };
                square += ((moved(1e-6) - moved(-1e-6)) / 2e-6 * errors[cell]).powi(2);
            }
            let error = found.standard_error.expect("an error");
            // Central differences of a step of 1e-6 are good to 1e-9.
            assert!(
                (error / square.sqrt() - 1.0).abs() < 1e-7,
                "{quantity}: {error}"
            );
        }
    }
}
