//! `fields.csv` and `profiles.csv`.

use stosszahl_analysis::fields::{Along, Fields as Sums, Measured, Values, measure};
use stosszahl_results::{Axis, Column, Estimate, Figure, Mark, Role, Scale, Table, table};

use super::Options;
use crate::measures::course::{self, Window};
use crate::plan::{EnginePlan, Plan};
use crate::theory::flow;

/// Places of the quantities of the tables in [`Values::list`].
const PLACES: [usize; 7] = [0, 1, 2, 4, 5, 6, 7];

/// Units of the quantities, in their order.
pub(super) fn units(plan: &Plan) -> [f64; 7] {
    let (scale, speed, energy) = (plan.scale, plan.scale.speed(), plan.scale.energy);
    let volume = scale.length.powi(plan.dimension as i32);
    let density = 1.0 / volume;
    [
        density,
        speed,
        speed,
        energy,
        energy,
        energy / volume,
        plan.time,
    ]
}

/// A figure of each quantity of a table, from its meaning and axis.
fn with_figures(mut table: Table, figure: impl Fn(Axis) -> Figure) -> Table {
    let one = |column: &Column| Figure {
        title: column.meaning.clone(),
        ..figure(Axis {
            column: column.name.clone(),
            label: column.name.clone(),
            scale: Scale::Linear,
        })
    };
    let values = table
        .columns
        .iter()
        .filter(|column| column.role == Role::Value);
    table.figures = values.map(one).collect();
    table
}

/// The empty table of the cells.
pub(super) fn cells(options: &Options) -> Table {
    let table = table! {
        "fields", "Fields in one cell and window of time";
        key "engine", "", "Engine";
        key "window_start", "time", "Start of the window";
        key "window_end", "time", "End of the window";
        key "x", "length", "Centre of the cell along the first axis";
        key "y", "length", "Centre of the cell along the second axis";
        estimate "number_density", "1/length^D", "Particles per volume (area in the plane)";
        estimate "velocity_x", "sqrt(energy/mass)", "Mean velocity along the first axis";
        estimate "velocity_y", "sqrt(energy/mass)", "Mean velocity along the second axis";
        estimate "temperature", "energy", "Granular temperature";
        estimate "spin_temperature", "energy", "Temperature of rotation; zero for smooth particles";
        estimate "pressure", "energy/length^D", "Pressure: n T, and what collisions carry; zero for one of several species";
        estimate "collision_rate", "1/time", "Collisions that a particle takes part in, per time";
    };
    if options.cells.contains(&1) {
        return table;
    }
    with_figures(table, |colour| {
        let axes = ["x", "y"].map(|name| Axis::linear(name, name));
        let [x, y] = axes;
        let figure = Figure::curves("", x, y)
            .by(&[])
            .panels(&["engine", "window_start"]);
        Figure {
            mark: Mark::Map,
            colour: Some(colour),
            ..figure
        }
    })
}

/// The empty table of the profiles.
pub(super) fn profiles(options: &Options) -> Table {
    let table = table! {
        "profiles", "A profile in one window of time";
        key "engine", "", "Engine";
        key "window_start", "time", "Start of the window";
        key "window_end", "time", "End of the window";
        key "along", "", "Axis of the profile: `x` or `y`; the other ones are averaged over";
        key "species", "", "Species, or `all`";
        key "at", "length", "Place along the axis";
        estimate "number_density", "1/length^D", "Particles per volume (area in the plane)";
        theory "theory_number_density", "1/length^D", "The same by theory; empty where there is none";
        estimate "velocity_x", "sqrt(energy/mass)", "Mean velocity along the first axis";
        estimate "velocity_y", "sqrt(energy/mass)", "Mean velocity along the second axis";
        estimate "temperature", "energy", "Granular temperature";
        estimate "spin_temperature", "energy", "Temperature of rotation; zero for smooth particles";
        estimate "pressure", "energy/length^D", "Pressure: n T, and what collisions carry; zero for one of several species";
    };
    if options.cells == [1, 1] {
        return table;
    }
    with_figures(table, |quantity| {
        Figure::curves("", Axis::linear("at", "place"), quantity)
            .caption("Averages over the other axis and a window of time; bars are standard errors from blocks of time.")
            .by(&["engine", "species"])
            .panels(&["along", "window_start"])
    })
}

/// The quantities of a cell in the units of the case.
pub(super) fn estimates(found: &Measured, units: [f64; 7]) -> [Estimate; 7] {
    std::array::from_fn(|quantity| {
        let of = |values: &Values| values.list()[PLACES[quantity]] * units[quantity];
        let error = found
            .errors
            .as_ref()
            .map(of)
            .filter(|error| error.is_finite());
        Estimate::of(of(&found.values), error)
    })
}

/// Adds the cells of an engine in a window.
pub(super) fn fill_cells(
    table: &mut Table,
    plan: &Plan,
    engine: &EnginePlan,
    sums: &[&Sums],
    window: &Window,
) {
    let Some(first) = sums.first() else {
        return;
    };
    let (units, freedom) = (units(plan), course::freedom(plan));
    let found = measure(sums, window.blocks.clone(), None, Along::Cells, freedom);
    for (cell, found) in found.iter().enumerate() {
        let place = first.grid().centre(cell).map(|x| x * plan.scale.length);
        table.add((engine.name, window.times, place, estimates(found, units)));
    }
}

/// Adds the profiles of an engine in a window.
pub(super) fn fill_profiles(
    table: &mut Table,
    plan: &Plan,
    engine: &EnginePlan,
    sums: &[&Sums],
    window: &Window,
) {
    let Some(first) = sums.first() else {
        return;
    };
    let (units, freedom) = (units(plan), course::freedom(plan));
    let column = flow::column(plan, engine).ok().flatten();
    let column = column.filter(|_| window.steady);
    let kinds = plan.species.len();
    let species = std::iter::once(None).chain((0..kinds).filter(|_| kinds > 1).map(Some));
    for species in species {
        let name = species.map_or("all", |index| plan.species[index].name.as_str());
        for (axis, along) in [Along::X, Along::Y].into_iter().enumerate() {
            let width = first.grid().width()[axis];
            let found = measure(sums, window.blocks.clone(), species, along, freedom);
            for (place, found) in found.iter().enumerate() {
                let at = (place as f64 + 0.5) * width;
                let ends = [at - 0.5 * width, at + 0.5 * width];
                let theory = column.as_ref().filter(|_| axis == 1);
                let theory = theory.map(|column| flow::density(plan, column, species, ends));
                let mut found = estimates(found, units).to_vec();
                found[0].theory = theory.map(|theory| theory * units[0]);
                // Profiles have no collision rate.
                found.pop();
                let at = at * plan.scale.length;
                table.add((engine.name, window.times, ["x", "y"][axis], name, at, found));
            }
        }
    }
}
