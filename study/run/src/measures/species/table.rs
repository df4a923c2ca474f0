//! Table `species.csv` of each species against time, with its columns and figures.

use stosszahl_results::{Figure, FigureAxis, Table, table};

use super::super::row_columns::{AddColumn, RowColumns};
use super::super::species_record::{self as record, against_time, has_correlation};
use super::super::tau;
use super::SpeciesRow;
use crate::plan::CasePlan;

/// Returns the columns of `species.csv`, limited to quantities that the gas has.
fn columns(plan: &CasePlan) -> RowColumns<SpeciesRow> {
    let (several, homogeneous) = (plan.gas.species.len() > 1, !plan.has_box());
    let displaced = homogeneous && record::has_displacement(plan);
    let counted = homogeneous && tau::rate(plan).is_some();
    let (theory, cumulant): (AddColumn, AddColumn) = if homogeneous {
        (Table::with_theory_error, Table::with_theory_error)
    } else {
        (Table::with_theory, Table::estimate)
    };
    let mut columns = RowColumns::<SpeciesRow>::new();
    columns.column(
        true,
        Table::value,
        ["particles", "1", "Number of particles"],
        |row| row.particles,
    );
    columns.column(counted, Table::with_theory, ["tau_1", "1", TAU], |row| {
        row.tau
    });
    columns.column(
        true,
        theory,
        ["temperature", "energy", TEMPERATURE],
        |row| row.temperature,
    );
    columns.column(
        several,
        Table::with_theory,
        [
            "ratio_to_first",
            "1",
            "Temperature over that of the first species",
        ],
        |row| row.ratio_to_first,
    );
    columns.column(
        plan.is_rough(),
        Table::estimate,
        [
            "spin_temperature",
            "energy",
            "Temperature of rotation, I <w^2> for each rotation",
        ],
        |row| row.spin_temperature,
    );
    columns.column(
        plan.is_uniform(),
        cumulant,
        ["fourth_cumulant", "1", CUMULANT],
        |row| row.fourth_cumulant,
    );
    columns.column(
        displaced,
        theory,
        [
            "mean_squared_displacement",
            "length^2",
            "Mean squared displacement",
        ],
        |row| row.displacement,
    );
    columns.column(
        has_correlation(plan),
        theory,
        ["velocity_correlation", "1", CORRELATION],
        |row| row.correlation,
    );
    columns.column(
        displaced,
        theory,
        ["diffusion_coefficient", "length^2/time", DIFFUSION],
        |row| row.diffusion,
    );
    columns.column(
        displaced,
        theory,
        ["velocity_relaxation_time", "time", RELAXATION],
        |row| row.relaxation,
    );
    columns
}

/// Description of the table column of the velocity correlation.
const CORRELATION: &str =
    "Correlation of the velocity with that of the start, <v(0) . v(t)>/<v(0)^2>";

/// Description of the table column of the self-diffusion coefficient.
const DIFFUSION: &str =
    "Diffusion coefficient <R . v>/D: half the growth of the displacement over D";

/// Description of the table column of `tau_1`, the collisions per particle within species 1.
const TAU: &str = "Collisions of a particle of species 1 with its like since the start, as its temperature T1 gives them in a Maxwellian gas: \
    d tau_1 = 4 n1 d1^2 chi sqrt(pi T1/m1) dt in space, 2 n1 d1 chi sqrt(pi T1/m1) dt in the plane";

/// Description of the table column of the species' temperature.
const TEMPERATURE: &str = "Temperature T = m <v^2>/D, in a flow about the mean velocity of the species; theory by Enskog's equations";

/// Description of the table column of the species' fourth cumulant.
const CUMULANT: &str = "Fourth cumulant a2 of the velocities, zero for Maxwellian ones; theory is empty in the first order";

/// Description of the table column of the velocity relaxation time.
const RELAXATION: &str = "Relaxation time of the velocity, m/T of the diffusion coefficient; empty where masses differ in a group";

/// Creates the table `species.csv` from the rows of each engine.
pub(super) fn species(plan: &CasePlan, engines: &[(&'static str, Vec<SpeciesRow>)]) -> Table {
    let columns = columns(plan);
    let table = table! {
        "species", "Each species, or the particles of like size, in time, means over the replicas.";
        key "engine", "", "Engine";
        key "time", "time", "Time since the start";
        key "species", "1", "Number of the species, from 1";
        key "species_name", "", "Name of the species";
        note "mass", "mass", "Mass of a particle";
        note "diameter", "length", "Diameter of a particle";
    };
    let mut table = columns.add_to(table).note("replicas", "1", "Replicas");
    table.figures = if plan.has_box() {
        figures_in_box(plan)
    } else {
        homogeneous_figures(plan)
    };
    for (engine, rows) in engines {
        for row in rows {
            let species = &plan.gas.species[row.species];
            let found = columns.estimates(row);
            let named = (row.species + 1, &*species.name);
            let about = (
                species.mass * plan.scale.mass,
                2.0 * species.radius * plan.scale.length,
            );
            table.add((*engine, row.time, named, about, found, row.replicas));
        }
    }
    table
}

/// Returns the figures of species in a box: temperatures over that of the first species. A flow has
/// its own scale.
fn figures_in_box(plan: &CasePlan) -> Vec<Figure> {
    let title = "Temperatures of the species";
    if plan.is_uniform() && !plan.is_rough() {
        let x = FigureAxis::logarithmic("time", "time");
        let y = FigureAxis::linear("ratio_to_first", "T of the species over that of the first");
        return vec![Figure::curves(title, x, y).by(&["engine", "species_name"])];
    }
    let x = FigureAxis::linear("time", "time");
    let y = FigureAxis::linear("temperature", "granular temperature");
    let figure = Figure::curves(title, x, y)
        .by(&["species_name"])
        .panels(&["engine"]);
    vec![figure.caption("Each about its own mean velocity.")]
}

/// Returns the figures of species without positions, against logarithmic time.
fn homogeneous_figures(plan: &CasePlan) -> Vec<Figure> {
    let mut figures = Vec::new();
    let several = plan.gas.species.len() > 1;
    for (shown, title, y, caption) in [
        (
            several,
            "Temperatures of the species",
            FigureAxis::logarithmic("temperature", "T"),
            "Temperatures m<v²>/D. Energy is not shared alike in a gas that cools: light particles become the coldest, and in \
             the end all temperatures fall together.",
        ),
        (
            true,
            "Fourth cumulant",
            FigureAxis::linear("fourth_cumulant", "a₂"),
            "Fourth cumulant of the velocities, D<v⁴>/((D + 2)<v²>²) − 1: zero for Maxwellian velocities.",
        ),
        (
            several && record::has_displacement(plan),
            "Mean squared displacement",
            FigureAxis::logarithmic("mean_squared_displacement", "<R²>"),
            "Mean squared displacement since the start: ballistic at first, then ever slower as the gas cools.",
        ),
        (
            record::has_displacement(plan),
            "Diffusion coefficient",
            FigureAxis::logarithmic("diffusion_coefficient", "<R·v>/D"),
            "Diffusion coefficient <R·v>/D, by which the mean squared displacement grows: from zero while particles fly freely, \
             then T τᵥ/m, which falls as the root of the temperature.",
        ),
        (
            has_correlation(plan),
            "Velocity correlation",
            FigureAxis::linear("velocity_correlation", "<v(0)·v(t)>/<v(0)²>"),
            "Correlation of the velocities with those of the start.",
        ),
    ] {
        let figure = || against_time(title, y, caption).by(&["species_name"]);
        figures.extend(shown.then(figure));
    }
    if several && tau::rate(plan).is_some() && record::has_displacement(plan) {
        let figure = against_time(
            "Mean squared displacement against collisions",
            FigureAxis::logarithmic("mean_squared_displacement", "<R²>"),
            "Mean squared displacement against the collisions of a particle of species 1 with its like, τ₁: of power 2 while \
             particles fly freely, of power 1 where diffusion is normal on the clock of the collisions.",
        );
        figures.push(Figure {
            x: FigureAxis::logarithmic("tau_1", "τ₁"),
            ..figure.by(&["species_name"])
        });
    }
    figures
}
