//! `fields.csv` and `profiles.csv`.

use stosszahl_analysis::fields::{Along, Fields as Sums, Measured, Values, measure};
use stosszahl_results::{Axis, Estimate, Figure, Mark, Table};

use super::Options;
use crate::measures::course::{self, Window};
use crate::plan::{EnginePlan, Plan};
use crate::theory::flow;

/// A field: the name of its column, its unit, its meaning, its place in [`Values::list`].
type Quantity = (&'static str, &'static str, &'static str, usize);

const QUANTITIES: [Quantity; 7] = [
    (
        "number_density",
        "1/length^D",
        "Particles per volume (area in the plane)",
        0,
    ),
    (
        "velocity_x",
        "sqrt(energy/mass)",
        "Mean velocity along the first axis",
        1,
    ),
    (
        "velocity_y",
        "sqrt(energy/mass)",
        "Mean velocity along the second axis",
        2,
    ),
    ("temperature", "energy", "Granular temperature", 4),
    (
        "spin_temperature",
        "energy",
        "Temperature of rotation; zero for smooth particles",
        5,
    ),
    (
        "pressure",
        "energy/length^D",
        "Pressure: n T, and what collisions carry; zero for one of several species",
        6,
    ),
    (
        "collision_rate",
        "1/time",
        "Collisions that a particle takes part in, per time",
        7,
    ),
];

/// Profiles have no collision rate.
const OF_PROFILES: usize = 6;

/// Units of the quantities, in their order.
fn units(plan: &Plan) -> [f64; 7] {
    let scale = plan.scale;
    let volume = scale.length.powi(plan.dimension as i32);
    let (speed, energy) = (scale.speed(), scale.energy);
    [
        1.0 / volume,
        speed,
        speed,
        energy,
        energy,
        energy / volume,
        plan.time,
    ]
}

/// The keys that all rows begin with.
fn windowed(table: Table) -> Table {
    table
        .key("engine", "", "Engine")
        .key("window_start", "time", "Start of the window")
        .key("window_end", "time", "End of the window")
}

/// The empty table of the cells.
pub(super) fn cells(options: &Options) -> Table {
    let mut table = windowed(Table::new(
        "fields",
        "Fields in one cell and window of time",
    ))
    .key("x", "length", "Centre of the cell along the first axis")
    .key("y", "length", "Centre of the cell along the second axis");
    for (name, unit, meaning, _) in QUANTITIES {
        table = table.estimate(name, unit, meaning);
    }
    if options.cells.iter().all(|&count| count > 1) {
        for (name, _, meaning, _) in QUANTITIES {
            table = table.figure(Figure {
                curves: Vec::new(),
                panels: vec!["engine".into(), "window_start".into()],
                mark: Mark::Map,
                colour: Some(Axis::linear(name, name)),
                ..Figure::curves(meaning, Axis::linear("x", "x"), Axis::linear("y", "y"))
            });
        }
    }
    table
}

/// The empty table of the profiles.
pub(super) fn profiles(options: &Options) -> Table {
    let mut table = windowed(Table::new("profiles", "A profile in one window of time"))
        .key(
            "along",
            "",
            "Axis of the profile: `x` or `y`; the other ones are averaged over",
        )
        .key("species", "", "Species, or `all`")
        .key("at", "length", "Place along the axis");
    for (name, unit, meaning, place) in QUANTITIES.into_iter().take(OF_PROFILES) {
        table = table.estimate(name, unit, meaning);
        if place == 0 {
            table = table.theory("theory_number_density", unit);
        }
    }
    if options.cells.iter().any(|&count| count > 1) {
        for (name, _, meaning, _) in QUANTITIES.into_iter().take(OF_PROFILES) {
            table = table.figure(Figure {
                caption: "Averages over the other axis and a window of time; bars are standard errors from blocks of time.".into(),
                curves: vec!["engine".into(), "species".into()],
                panels: vec!["along".into(), "window_start".into()],
                ..Figure::curves(meaning, Axis::linear("at", "place"), Axis::linear(name, name))
            });
        }
    }
    table
}

/// One quantity of a cell in the units of the case.
fn estimate(found: &Measured, place: usize, unit: f64) -> Estimate {
    let of = |values: &Values| values.list()[place] * unit;
    Estimate {
        value: Some(of(&found.values)),
        standard_error: found
            .errors
            .as_ref()
            .map(of)
            .filter(|error| error.is_finite()),
        ..Estimate::default()
    }
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
    let (units, length) = (units(plan), plan.scale.length);
    let (freedom, [start, end]) = (course::freedom(plan), window.times);
    let found = measure(sums, window.blocks.clone(), None, Along::Cells, freedom);
    for (cell, found) in found.iter().enumerate() {
        let [x, y] = first.grid().centre(cell);
        let mut row = table
            .row()
            .text(engine.name)
            .number(start)
            .number(end)
            .number(x * length)
            .number(y * length);
        for ((_, _, _, place), unit) in QUANTITIES.into_iter().zip(units) {
            row = row.estimate(estimate(found, place, unit));
        }
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
    let (units, freedom, [start, end]) = (units(plan), course::freedom(plan), window.times);
    let column = flow::column(plan, engine).ok().flatten();
    let column = column.filter(|_| window.steady);
    let kinds = plan.species.len();
    let species = std::iter::once(None).chain((0..kinds).filter(|_| kinds > 1).map(Some));
    for species in species {
        for (axis, along) in [Along::X, Along::Y].into_iter().enumerate() {
            let width = first.grid().width()[axis];
            let found = measure(sums, window.blocks.clone(), species, along, freedom);
            for (place, found) in found.iter().enumerate() {
                let at = (place as f64 + 0.5) * width;
                let ends = [at - 0.5 * width, at + 0.5 * width];
                let theory = column.as_ref().filter(|_| axis == 1);
                let theory = theory.map(|column| flow::density(plan, column, species, ends));
                let name = species.map_or("all", |index| plan.species[index].name.as_str());
                let mut row = table
                    .row()
                    .text(engine.name)
                    .number(start)
                    .number(end)
                    .text(["x", "y"][axis])
                    .text(name)
                    .number(at * plan.scale.length);
                for ((_, _, _, place), unit) in QUANTITIES.into_iter().zip(units).take(OF_PROFILES)
                {
                    row = row.estimate(Estimate {
                        theory: theory.filter(|_| place == 0).map(|theory| theory * unit),
                        ..estimate(found, place, unit)
                    });
                }
            }
        }
    }
}
