//! Tables `energy.csv` and `replicas.csv` of the whole gas against time, and the averages in their
//! rows.

use nalgebra::Vector3;
use stosszahl_results::{Figure, FigureAxis, Table, TableEstimate, table};

use super::super::gas_series::{self, GasSample, GasSeries};
use super::super::row_columns::{AddColumn, RowColumns};
use super::super::species_record::{against, measured, temperature_error};
use super::{energy_ratio, has_changing_number, has_energies_apart, two_temperature_theory};
use crate::measure::ReplicaRecords;
use crate::plan::{CasePlan, EnginePlan};
use crate::theory::homogeneous;

/// Averages of the whole gas of one engine over replicas, at one sample time. Energies and
/// temperatures are in the case's unit of energy.
pub(crate) struct GasRow {
    /// Sample time of the row, in the case's unit of time.
    pub time: f64,
    /// Number of particles of the gas, averaged over replicas.
    pub particles: TableEstimate,
    /// Collisions per particle since the start; each pair collision counts for both partners.
    pub collisions: TableEstimate,
    /// Translational kinetic energy over that at the start, K/K(0).
    pub energy_ratio: TableEstimate,
    /// Translational, rotational and gravitational energy of the gas.
    parts: [TableEstimate; 3],
    energy: TableEstimate,
    temperature: TableEstimate,
    spin_temperature: TableEstimate,
    fourth_cumulant: TableEstimate,
    replicas: usize,
}

/// Returns the mean number of collisions per particle since the start. The count is per initial
/// particle with aggregation, else per present one; it is NaN with tracers.
fn collisions_per_particle(plan: &CasePlan, series: &GasSeries, sample: usize) -> f64 {
    if plan.gas.species.iter().any(|one| one.tracer) {
        return f64::NAN;
    }
    let counted = if plan.case.aggregation.is_some() {
        0
    } else {
        sample
    };
    2.0 * series[sample].collisions / series[counted].total().number.max(f64::MIN_POSITIVE)
}

/// Returns the standard error of K/K(0) in one replica from the spread over independent particles.
/// `None` if particles are correlated or their number changes.
fn single_error(plan: &CasePlan, series: &GasSeries, sample: usize) -> Option<f64> {
    if plan.has_box() || plan.case.aggregation.is_some() {
        return None;
    }
    let (mut sum, mut square) = (0.0, 0.0);
    for (share, species) in series[sample].species.iter().zip(&plan.gas.species) {
        if !species.tracer {
            let cumulant = share.fourth_cumulant(plan.gas.dimension);
            let relative = temperature_error(plan.gas.dimension, share.number, cumulant);
            sum += share.translation;
            square += (share.translation * relative).powi(2);
        }
    }
    (sum > 0.0).then(|| square.sqrt() / sum * energy_ratio(plan, series, sample))
}

/// Computes the table rows of the whole gas for one engine, one for each sample time that all
/// replicas have.
pub(crate) fn rows(plan: &CasePlan, engine: &EnginePlan, all_series: &[&GasSeries]) -> Vec<GasRow> {
    if all_series.is_empty() {
        return Vec::new();
    }
    let freedom = gas_series::freedom(plan);
    let curves = (!plan.has_box())
        .then(|| homogeneous::curves(plan).ok())
        .flatten();
    let rough = two_temperature_theory(plan, engine).ok().flatten();
    let samples = gas_series::shortest(all_series);
    let row = |index: usize| {
        let time = all_series[0][index].time;
        let of = |value: &dyn Fn(&GasSample) -> f64| {
            measured(all_series, |series| value(&series[index]), None)
        };
        let energy = |value: &dyn Fn(&GasSample) -> f64| of(value).times(plan.scale.energy);
        let curve = curves.and_then(|curves| curves.at.get(index));
        let law = plan
            .has_box()
            .then(|| plan.haff_ratio(time * plan.rate_ratio(engine)))
            .flatten();
        let ratio = measured(
            all_series,
            |series| energy_ratio(plan, series, index),
            all_series
                .first()
                .and_then(|series| single_error(plan, series, index)),
        );
        let collisions = measured(
            all_series,
            |series| collisions_per_particle(plan, series, index),
            None,
        );
        let expected = rough.and_then(|all| all.get(index));
        let spin = |sample: &GasSample| {
            let spin = sample.total().spin_temperature(freedom);
            spin.unwrap_or(f64::NAN)
        };
        let translation = expected.map(|expected| expected.translation);
        let cooled = law.map(|law| law * plan.gas.temperature);
        GasRow {
            time,
            particles: of(&|sample| sample.total().number),
            collisions: against(collisions, curve.map(|curve| curve.collisions)),
            energy_ratio: match law {
                Some(law) => ratio.against(Some(law)),
                None => against(ratio, curve.map(|curve| curve.energy_ratio)),
            },
            parts: [
                energy(&|sample| sample.total().translation),
                energy(&|sample| sample.total().rotation),
                energy(&|sample| sample.potential),
            ],
            energy: energy(&GasSample::energy),
            temperature: of(&|sample| sample.total().temperature(freedom))
                .against(translation.or(cooled))
                .times(plan.scale.energy),
            spin_temperature: of(&spin)
                .against(expected.map(|expected| expected.rotation))
                .times(plan.scale.energy),
            fourth_cumulant: of(&|sample| sample.total().fourth_cumulant(plan.gas.dimension)),
            replicas: all_series.len(),
        }
    };
    (0..samples).map(row).collect()
}

/// Description of the table column of collisions per particle.
const COLLISIONS: &str = "Collisions of a particle since the start, two for each pair collision: of a particle of \
    the start where particles aggregate; empty with tracers";

/// Description of the table column of the energy ratio K/K(0).
const RATIO: &str = "Kinetic energy of translation over that of the start, K/K(0), without tracers; theory is \
    Haff's law with its Sonine factor, (1 + (1 + 3 a2/16) t/t0)^-2, at the collision rate that \
    the scheme sets, or kinetic equations of the species";

/// Description of the table column of the potential energy in gravity.
const HEIGHT: &str =
    "Energy of height along axes that end at walls or openings; zero at the origin";

/// Description of the table column of the granular temperature.
const TEMPERATURE: &str =
    "Granular temperature, m <(v - u)^2>/D with the mean velocity u of all particles";

/// Returns the columns of the table `energy.csv`, limited to quantities that the gas has.
fn columns(plan: &CasePlan) -> RowColumns<GasRow> {
    let (apart, spins) = (has_energies_apart(plan), plan.is_rough());
    let counted = has_changing_number(plan);
    // Theory of a gas without positions has an error.
    let (law, collisions): (AddColumn, AddColumn) = if plan.has_box() {
        (Table::with_theory, Table::estimate)
    } else {
        (Table::with_theory_error, Table::with_theory_error)
    };
    let mut columns = RowColumns::<GasRow>::new();
    columns.column(
        counted,
        Table::estimate,
        ["particles", "1", "Number of particles"],
        |row| row.particles,
    );
    columns.column(
        true,
        collisions,
        ["collisions_per_particle", "1", COLLISIONS],
        |row| row.collisions,
    );
    columns.column(true, law, ["energy_ratio", "1", RATIO], |row| {
        row.energy_ratio
    });
    columns.column(
        apart,
        Table::value,
        [
            "translational_energy",
            "energy",
            "Energy of translation, of all particles",
        ],
        |row| row.parts[0],
    );
    columns.column(
        spins,
        Table::value,
        ["rotational_energy", "energy", "Energy of rotation"],
        |row| row.parts[1],
    );
    columns.column(
        has_height(plan),
        Table::value,
        ["potential", "energy", HEIGHT],
        |row| row.parts[2],
    );
    columns.column(
        apart,
        Table::estimate,
        ["energy", "energy", "Sum of all energies"],
        |row| row.energy,
    );
    columns.column(
        true,
        Table::with_theory,
        ["temperature", "energy", TEMPERATURE],
        |row| row.temperature,
    );
    columns.column(
        spins,
        Table::with_theory,
        [
            "spin_temperature",
            "energy",
            "Temperature of rotation, I <w^2> for each rotation",
        ],
        |row| row.spin_temperature,
    );
    columns.column(
        has_cumulant(plan),
        Table::estimate,
        [
            "fourth_cumulant",
            "1",
            "Fourth cumulant a2 of the velocities; zero for a Maxwellian",
        ],
        |row| row.fourth_cumulant,
    );
    columns
}

/// Returns true if gravity acts, so that particles have a potential energy.
fn has_height(plan: &CasePlan) -> bool {
    plan.gravity() != Vector3::zeros()
}

/// Returns true if the gas is uniform and does not aggregate, so that the fourth cumulant of all
/// velocities describes the thermal motion.
fn has_cumulant(plan: &CasePlan) -> bool {
    plan.is_uniform() && plan.case.aggregation.is_none()
}

/// Creates the table `energy.csv` of the whole gas, one row for each engine and sample time.
pub(super) fn energy(plan: &CasePlan, runs: &ReplicaRecords<'_>) -> Table {
    let columns = columns(plan);
    let table = table! {
        "energy", "The whole gas in time, means over the replicas.";
        key "engine", "", "Engine";
        key "time", "time", "Time since the start";
    };
    let mut table = columns.add_to(table).note("replicas", "1", "Replicas");
    table.figures = if has_energies_apart(plan) {
        linear_figures(plan)
    } else {
        logarithmic_figures(plan)
    };
    for (engine, all_series) in runs.each::<GasSeries>(plan) {
        for row in rows(plan, engine, &all_series) {
            table.add((
                (engine.name, row.time),
                columns.estimates(&row),
                row.replicas,
            ));
        }
    }
    table
}

/// Returns the figures of energies and temperatures against linear time, for flows and rough gases.
fn linear_figures(plan: &CasePlan) -> Vec<Figure> {
    let (falls, spins) = (has_height(plan), plan.is_rough());
    let all = [
        (true, "energy", "Energy of all particles"),
        (falls, "translational_energy", "Energy of translation"),
        (falls, "potential", "Energy of height"),
        (spins, "rotational_energy", "Energy of rotation"),
        (true, "temperature", "Granular temperature"),
        (spins, "spin_temperature", "Temperature of rotation"),
    ];
    let curves = |(_, column, title): (bool, &'static str, &'static str)| {
        let x = FigureAxis::linear("time", "time");
        Figure::curves(title, x, FigureAxis::linear(column, title))
    };
    all.into_iter().filter(|one| one.0).map(curves).collect()
}

/// Returns the figures of energies and temperatures against logarithmic time, for a uniform smooth
/// gas.
fn logarithmic_figures(plan: &CasePlan) -> Vec<Figure> {
    let against_time = |title: &'static str, y: FigureAxis| {
        let figure = Figure::curves(title, FigureAxis::logarithmic("time", "time"), y);
        // A gas without positions has one engine.
        if plan.has_box() {
            figure
        } else {
            figure.by(&[])
        }
    };
    let energy = FigureAxis::logarithmic("energy_ratio", "K/K(0)");
    let second = if plan.has_box() {
        against_time(
            "Fourth cumulant",
            FigureAxis::linear("fourth_cumulant", "a2"),
        )
    } else {
        let y = FigureAxis::linear("collisions_per_particle", "collisions per particle");
        against_time("Collisions", y).caption(
            "Collisions that a particle took part in, on average. In a gas that cools by Haff's law they grow as the logarithm \
             of time.",
        )
    };
    vec![against_time("Energy", energy), second]
}

/// Creates the table `replicas.csv` of the whole gas in single replicas, one row for each replica,
/// engine and sample time.
pub(super) fn replicas(plan: &CasePlan, runs: &ReplicaRecords<'_>) -> Table {
    let (freedom, dimension) = (gas_series::freedom(plan), plan.gas.dimension);
    let mut table = table! {
        "replicas", "The whole gas in time, replica by replica.";
        key "replica", "1", "Number of the replica, from zero";
        key "engine", "", "Engine";
        key "time", "time", "Time since the start";
        value "particles", "1", "Number of particles";
        value "collisions", "1", "Pair collisions since the start";
        value "collisions_per_particle", "1", "Collisions of a particle since the start; empty with tracers";
        value "translational_energy", "energy", "Energy of translation, of all particles";
        value "energy_ratio", "1", "K/K(0), without tracers";
        value "temperature", "energy", "Granular temperature";
        value "fourth_cumulant", "1", "Fourth cumulant a2 of the velocities";
    };
    for (engine, all_series) in runs.each::<GasSeries>(plan) {
        for (replica, series) in all_series.into_iter().enumerate() {
            for (index, sample) in series.iter().enumerate() {
                let all = sample.total();
                table.add((
                    (replica, engine.name, sample.time),
                    [all.number, sample.collisions],
                    collisions_per_particle(plan, series, index),
                    all.translation * plan.scale.energy,
                    energy_ratio(plan, series, index),
                    all.temperature(freedom) * plan.scale.energy,
                    all.fourth_cumulant(dimension),
                ));
            }
        }
    }
    table
}
