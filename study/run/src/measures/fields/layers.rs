//! Table `boundary_layers.csv`: displacement thickness and slip of the flow at the walls of a
//! channel.

use stosszahl_analysis::fields::FieldGrid;
use stosszahl_results::{Figure, FigureAxis, Table, table};

use super::view::View;
use super::{FieldOptions, channel};
use crate::measures::time_blocks::TimeBlocks;
use crate::plan::{CasePlan, EnginePlan};

/// Creates the table `boundary_layers.csv` without rows.
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
        FigureAxis::linear("x", "x"),
        FigureAxis::linear("displacement_thickness", "displacement thickness"),
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

/// Returns true if the case is a channel whose fields have enough rows of cells for boundary
/// layers.
pub(super) fn has_layers(plan: &CasePlan, options: &FieldOptions) -> bool {
    channel::is_channel(&plan.case) && options.cells[1] >= channel::FEWEST_ROWS as u64
}

/// Adds the rows of one engine in one time window to the table of boundary layers.
pub(super) fn fill(
    table: &mut Table,
    plan: &CasePlan,
    engine: &EnginePlan,
    grid: &FieldGrid,
    (window, view): (&TimeBlocks, &View<'_>),
) {
    let [columns, rows] = grid.counts();
    let (length, speed) = (plan.scale.length, plan.scale.speed());
    let height = plan.gas.lengths[1] * length;
    for column in 0..columns {
        let across: Vec<usize> = (0..rows).map(|row| column + columns * row).collect();
        let [centre, thickness, slip] = view.derived(&across, |cells| {
            let speeds: Vec<f64> = cells.iter().map(|cell| cell.velocity[0]).collect();
            boundary_layer(&speeds, height)
        });
        let place = grid.centre(column)[0] * length;
        let found = [centre.times(speed), thickness, slip];
        table.add((engine.name, window.times, place, found));
    }
}

/// Computes velocity in the middle, displacement thickness and slip from the velocities across a
/// channel of a height.
///
/// With `S = sum u_j`, the mean M over the middle and cells of the width `H/J` the thickness is
/// `(H - (H/J) S/M)/2`.
fn boundary_layer(across: &[f64], height: f64) -> [f64; 3] {
    let count = across.len();
    let middle = channel::middle(count);
    let (width, few) = (height / count as f64, middle.len() as f64);
    let centre = across[middle].iter().sum::<f64>() / few;
    let sum: f64 = across.iter().sum();
    let edges = 0.5 * (across[0] + across[count - 1]);
    let thickness = 0.5 * (height - width * sum / centre);
    [centre, thickness, edges / centre]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Poiseuille's profile `u = 4 y (1 - y)`, by the means over cells: the layer of one wall is a
    /// sixth of the height.
    #[test]
    fn the_layer_of_a_parabola_is_a_sixth_of_the_height() {
        let count = 1000;
        let integral = |y: f64| 2.0 * y * y - 4.0 / 3.0 * y * y * y;
        let cell = |j: usize| {
            let [a, b] = [j, j + 1].map(|edge| edge as f64 / count as f64);
            3.0 * (integral(b) - integral(a)) * count as f64
        };
        let across: Vec<f64> = (0..count).map(cell).collect();
        let [centre, thickness, slip] = boundary_layer(&across, 2.0);
        // The mean over the middle fifth: 3 (integral from 2/5 to 3/5)/(1/5).
        let middle = 15.0 * (integral(0.6) - integral(0.4));
        assert!((centre - middle).abs() < 1e-12);
        assert!((thickness - (1.0 - 2.0 / middle)).abs() < 1e-12);
        assert!(slip < 0.01);
    }
}
