//! Tables `fields.csv` and `profiles.csv` of the measure `fields`: their columns, figures and rows.

use stosszahl_analysis::fields::{CellAveraging, FieldGrid};
use stosszahl_results::{
    AxisScale, Figure, FigureAxis, PointMark, Role, Table, TableColumn, table,
};

use super::FieldOptions;
use super::view::{self, View};
use crate::measures::time_blocks::TimeBlocks;
use crate::measures::{PARTS, fewest_parts};
use crate::plan::{CasePlan, EnginePlan};
use crate::theory::flow;

/// Adds a figure of each field quantity to a table; `figure` creates it from the vertical axis.
fn with_figures(mut table: Table, figure: impl Fn(FigureAxis) -> Figure) -> Table {
    let one = |column: &TableColumn| Figure {
        title: column.meaning.clone(),
        ..figure(FigureAxis {
            column: column.name.clone(),
            label: column.name.clone(),
            scale: AxisScale::Linear,
        })
    };
    let values = table
        .columns
        .iter()
        .filter(|column| column.role == Role::Value);
    table.figures = values.map(one).collect();
    table
}

/// Creates the table `fields.csv` without rows.
pub(super) fn cells(options: &FieldOptions) -> Table {
    let table = table! {
        "fields", "Fields in one cell and window of time";
        key "engine", "", "Engine";
        key "window_start", "time", "Start of the window";
        key "window_end", "time", "End of the window";
        key "x", "length", "Centre of the cell along the first axis";
        key "y", "length", "Centre of the cell along the second axis";
        estimate "number_density", "1/length^D", "Particles per volume (area in the plane) in which their centres can be";
        estimate "velocity_x", "sqrt(energy/mass)", "Mean velocity along the first axis";
        estimate "velocity_y", "sqrt(energy/mass)", "Mean velocity along the second axis";
        estimate "temperature", "energy", "Granular temperature";
        estimate "spin_temperature", "energy", "Temperature of rotation; zero for smooth particles";
        estimate "pressure", "energy/length^D", "Pressure: n T, and what collisions carry; zero for one of several species";
        estimate "collision_rate", "1/time", "Collisions that a particle takes part in, per time";
        note "parts", "1", PARTS;
    };
    if options.cells.contains(&1) {
        return table;
    }
    with_figures(table, |colour| {
        let axes = ["x", "y"].map(|name| FigureAxis::linear(name, name));
        let [x, y] = axes;
        let figure = Figure::curves("", x, y)
            .by(&[])
            .panels(&["engine", "window_start"]);
        Figure {
            mark: PointMark::Map,
            colour: Some(colour),
            ..figure
        }
    })
}

/// Creates the table `profiles.csv` without rows.
pub(super) fn profiles(options: &FieldOptions) -> Table {
    let table = table! {
        "profiles", "A profile in one window of time";
        key "engine", "", "Engine";
        key "window_start", "time", "Start of the window";
        key "window_end", "time", "End of the window";
        key "along", "", "Axis of the profile: `x` or `y`; the other ones are averaged over";
        key "species", "", "Species, or `all`";
        key "at", "length", "Place along the axis";
        estimate "number_density", "1/length^D", "Particles per volume (area in the plane) in which their centres can be";
        theory "number_density_theory", "1/length^D", "The same by theory; empty where there is none";
        estimate "velocity_x", "sqrt(energy/mass)", "Mean velocity along the first axis";
        estimate "velocity_y", "sqrt(energy/mass)", "Mean velocity along the second axis";
        estimate "temperature", "energy", "Granular temperature";
        estimate "spin_temperature", "energy", "Temperature of rotation; zero for smooth particles";
        estimate "pressure", "energy/length^D", "Pressure: n T, and what collisions carry; zero for one of several species";
        note "parts", "1", PARTS;
    };
    if options.cells == [1, 1] {
        return table;
    }
    with_figures(table, |quantity| {
        Figure::curves("", FigureAxis::linear("at", "place"), quantity)
            .caption("Averages over the other axis and a window of time; bars are standard errors from blocks of time and replicas.")
            .by(&["engine", "species"])
            .panels(&["along", "window_start"])
    })
}

/// Adds the rows of all cells of one engine in one time window to the table of fields.
pub(super) fn fill_cells(
    table: &mut Table,
    plan: &CasePlan,
    engine: &EnginePlan,
    grid: &FieldGrid,
    (window, view): (&TimeBlocks, &View<'_>),
) {
    for (cell, found) in view
        .fields(None, CellAveraging::Cells)
        .into_iter()
        .enumerate()
    {
        let place = grid.centre(cell).map(|x| x * plan.scale.length);
        let parts = fewest_parts(&found);
        table.add((engine.name, window.times, place, found, parts));
    }
}

/// Adds the rows of both profiles of one engine in one time window to the table of profiles.
pub(super) fn fill_profiles(
    table: &mut Table,
    plan: &CasePlan,
    engine: &EnginePlan,
    grid: &FieldGrid,
    (window, view): (&TimeBlocks, &View<'_>),
) {
    let unit = view::units(plan)[view::DENSITY];
    let column = flow::column(plan, engine).ok().flatten();
    let column = column.filter(|_| window.steady);
    let kinds = plan.gas.species.len();
    let species = std::iter::once(None).chain((0..kinds).filter(|_| kinds > 1).map(Some));
    for species in species {
        let name = species.map_or("all", |index| plan.gas.species[index].name.as_str());
        for (axis, along) in [CellAveraging::X, CellAveraging::Y].into_iter().enumerate() {
            let width = grid.width()[axis];
            for (place, found) in view.fields(species, along).into_iter().enumerate() {
                let at = (place as f64 + 0.5) * width;
                let ends = [at - 0.5 * width, at + 0.5 * width];
                let theory = column.as_ref().filter(|_| axis == 1);
                let theory = theory.map(|column| flow::density(plan, column, species, ends));
                let mut found = found.to_vec();
                found[0].theory = theory.map(|theory| theory * unit);
                // Profiles have no collision rate.
                found.pop();
                let (at, parts) = (at * plan.scale.length, fewest_parts(&found));
                let axis = ["x", "y"][axis];
                table.add((engine.name, window.times, axis, name, at, found, parts));
            }
        }
    }
}
