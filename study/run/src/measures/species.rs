//! A gas without positions species by species, or by groups of like size.

use stosszahl_dsmc::homogeneous::SpeciesMoments;
use stosszahl_results::{Figure, FigureAxis, Table, TableEstimate, table};

use super::gas::{self, CORRELATION, GasRecord, GasSample, against, has_correlation, measured};
use super::tau;
use crate::measure::{self, BadOption, Measure, NoOptions, ReplicaRecords, described};
use crate::plan::CasePlan;
use crate::theory::homogeneous::{self, GroupCurve, Predicted, TheoryPoint};

/// Temperature, displacement, fourth cumulant and velocity correlation of each species of a gas
/// without positions.
pub struct SpeciesMeasure;

/// Correlation of the velocities with the initial velocities, in the table of the species.
pub struct VelocityCorrelation;

impl Measure for SpeciesMeasure {
    described!(
        "species",
        "Temperature, displacement, fourth cumulant and velocity correlation of each species of a gas without positions.",
        NoOptions
    );

    fn by_default(&self, plan: &CasePlan) -> bool {
        !plan.has_box() && plan.case.aggregation.is_none()
    }

    fn check_options(&self, plan: &CasePlan) -> Result<(), BadOption> {
        lasting_only(plan)?;
        self.read_options(plan)
    }

    fn result_tables(&self, plan: &CasePlan, runs: &ReplicaRecords<'_>) -> Vec<Table> {
        vec![table(plan, &rows(plan, &runs.records_of(0)))]
    }
}

impl Measure for VelocityCorrelation {
    described!(
        CORRELATION,
        "Correlation of the velocities with those of the start, as columns of the table of the species.",
        NoOptions
    );

    fn check_options(&self, plan: &CasePlan) -> Result<(), BadOption> {
        lasting_only(plan)?;
        self.read_options(plan)
    }
}

/// Refuses a measurement of particles that last, but in a gas without positions whose particles do
/// not stick.
pub(super) fn lasting_only(plan: &CasePlan) -> Result<(), BadOption> {
    gas::homogeneous_only(plan)?;
    let allowed = "not with [aggregation], as clusters do not last";
    measure::require(plan.case.aggregation.is_none(), "", allowed)
}

/// Row of the table: one species at one time, averaged over all replicas.
pub(super) struct SpeciesRow {
    pub time: f64,
    /// Number of the species, from 0.
    pub species: usize,
    pub tau: TableEstimate,
    pub temperature: TableEstimate,
    pub fourth_cumulant: TableEstimate,
    pub displacement: TableEstimate,
    pub diffusion: TableEstimate,
    pub relaxation: TableEstimate,
    pub correlation: TableEstimate,
}

/// Returns the rows of all species at all sample times.
pub(super) fn rows(plan: &CasePlan, records: &[&GasRecord]) -> Vec<SpeciesRow> {
    let curves = homogeneous::curves(plan).ok();
    let taus = tau::tau_at_samples(plan, records);
    let mut rows = Vec::new();
    for (index, time) in plan.sample_times().into_iter().enumerate() {
        let curve = curves.and_then(|curves| curves.at.get(index));
        let pairs = gas::pairs(records, index);
        let tau = taus.get(index).copied().unwrap_or_default();
        let of = |species| SpeciesRow {
            tau,
            ..row(plan, species, time, &pairs, curve)
        };
        rows.extend((0..plan.species.len()).map(of));
    }
    rows
}

fn row(
    plan: &CasePlan,
    species: usize,
    time: f64,
    pairs: &gas::ReplicaPairs<'_>,
    curve: Option<&TheoryPoint>,
) -> SpeciesRow {
    let none = SpeciesMoments::default();
    let of = |sample: &GasSample| *sample.groups.get(species).unwrap_or(&none);
    let one = pairs.first().map_or(none, |pair| of(pair.0));
    let curve = curve.and_then(|curve| curve.groups.get(species));
    let theory = |value: fn(&GroupCurve) -> Predicted| curve.map(value);
    let temperature = {
        let single = gas::temperature_error(plan, &one) * one.temperature;
        measured(
            pairs,
            |pair| of(pair.0).temperature,
            (one.count > 0).then_some(single),
        )
    };
    let cumulant = measured(pairs, |pair| of(pair.0).fourth_cumulant, None);
    let displacement = gas::has_displacement(plan).then(|| {
        let single = (one.count > 1).then(|| gas::displacement_error(plan, &one));
        let found = measured(pairs, |pair| of(pair.0).displacement, single);
        against(found, theory(|group| group.displacement))
    });
    let [diffusion, relaxation] = diffusion(plan, species, pairs, curve);
    let correlation = has_correlation(plan).then(|| {
        let kept = |pair: &(&GasSample, &GasSample)| {
            of(pair.0).velocity_correlation / of(pair.1).velocity_correlation
        };
        against(
            measured(pairs, kept, None),
            theory(|group| group.correlation),
        )
    });
    // In the first order the cumulant is zero by assumption, which is no prediction.
    let predicted = theory(|group| group.fourth_cumulant).filter(|theory| theory.error.is_some());
    SpeciesRow {
        time,
        species,
        tau: TableEstimate::default(),
        temperature: against(temperature, theory(|group| group.temperature)),
        fourth_cumulant: against(cumulant, predicted),
        displacement: displacement.unwrap_or_default(),
        diffusion,
        relaxation,
        correlation: correlation.unwrap_or_default(),
    }
}

/// Estimates the diffusion coefficient `<R . v>/D`, half the growth of the displacement over D, and
/// the relaxation time of the velocity: m/T times the coefficient, which has no meaning for
/// particles of unlike masses together.
fn diffusion(
    plan: &CasePlan,
    species: usize,
    pairs: &gas::ReplicaPairs<'_>,
    curve: Option<&GroupCurve>,
) -> [TableEstimate; 2] {
    if !gas::has_displacement(plan) {
        return [TableEstimate::default(); 2];
    }
    let none = SpeciesMoments::default();
    let of = |sample: &GasSample| *sample.groups.get(species).unwrap_or(&none);
    let one = pairs.first().map_or(none, |pair| of(pair.0));
    let d = plan.dimension as f64;
    let single = (one.count > 1).then(|| {
        let spread = one.displacement_velocity_square - one.displacement_velocity.powi(2);
        (spread.max(0.0) / one.count as f64).sqrt() / d
    });
    let found = measured(pairs, |pair| of(pair.0).displacement_velocity / d, single);
    let diffusion = against(found, curve.map(|curve| curve.diffusion));
    let mass = plan.species[species].mass;
    if plan.classes.len() != plan.species.len() {
        return [diffusion, TableEstimate::default()];
    }
    let time =
        |moments: SpeciesMoments| moments.displacement_velocity * mass / (d * moments.temperature);
    let single = single.map(|error| error * mass / one.temperature);
    let found = measured(pairs, |pair| time(of(pair.0)), single);
    [
        diffusion,
        against(found, curve.map(|curve| curve.relaxation)),
    ]
}

fn table(plan: &CasePlan, rows: &[SpeciesRow]) -> Table {
    let mut table = table! {
        "species", "Each species, or the particles of like size, at the sample times";
        key "time", "unit of time", "Time";
        key "species", "1", "Number of the species, from 1";
        key "species_name", "", "Name of the species";
        note "mass", "mass", "Mass of a particle";
        note "diameter", "length", "Diameter of a particle";
        note "count", "1", "Particles in each replica";
        with_theory "tau_1", "1",
            "Collisions of a particle of species 1 with its like since the start, as its temperature T1 gives them in a Maxwellian gas: \
             d tau_1 = 4 n1 d1^2 chi sqrt(pi T1/m1) dt in space, 2 n1 d1 chi sqrt(pi T1/m1) dt in the plane";
        with_theory_error "temperature", "energy", "Temperature T = m <v^2>/D";
        with_theory_error "fourth_cumulant", "1",
            "Fourth cumulant a2 of the velocities, zero for Maxwellian ones; theory is empty in the first order";
        with_theory_error "mean_squared_displacement", "length^2", "Mean squared displacement";
        with_theory_error "velocity_correlation", "1",
            "Correlation of the velocity with that of the start, <v(0) . v(t)>/<v(0)^2>";
        with_theory_error "diffusion_coefficient", "length^2/time", "Diffusion coefficient <R . v>/D: half the growth of the displacement over D";
        with_theory_error "velocity_relaxation_time", "time",
            "Relaxation time of the velocity, m/T of the diffusion coefficient; empty where masses differ in a group";
    };
    for row in rows {
        let species = &plan.species[row.species];
        let about = (species.mass, 2.0 * species.radius, species.count);
        let found = [
            row.temperature,
            row.fourth_cumulant,
            row.displacement,
            row.correlation,
            row.diffusion,
            row.relaxation,
        ];
        let named = (row.species + 1, &*species.name);
        table.add((row.time, named, about, row.tau, found));
    }
    let several = plan.species.len() > 1;
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
            several && gas::has_displacement(plan),
            "Mean squared displacement",
            FigureAxis::logarithmic("mean_squared_displacement", "<R²>"),
            "Mean squared displacement since the start: ballistic at first, then ever slower as the gas cools.",
        ),
        (
            gas::has_displacement(plan),
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
        let figure = || gas::against_time(title, y, caption).by(&["species_name"]);
        table.figures.extend(shown.then(figure));
    }
    if several && tau::rate(plan).is_some() && gas::has_displacement(plan) {
        let figure = gas::against_time(
            "Mean squared displacement against collisions",
            FigureAxis::logarithmic("mean_squared_displacement", "<R²>"),
            "Mean squared displacement against the collisions of a particle of species 1 with its like, τ₁: of power 2 while \
             particles fly freely, of power 1 where diffusion is normal on the clock of the collisions.",
        );
        table.figures.push(Figure {
            x: FigureAxis::logarithmic("tau_1", "τ₁"),
            ..figure.by(&["species_name"])
        });
    }
    table
}
