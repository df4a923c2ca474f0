//! Measure `time_averaged_displacement`: squared displacements averaged over time along the
//! trajectories of some particles, in a gas without positions.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use stosszahl_analysis::replicas::of_sums;
use stosszahl_model::Grouping;
use stosszahl_results::{Figure, FigureAxis, Table, TableEstimate, table};

use super::species_record::{self as record, against, measured, pairs};
use super::{mean_over_replicas, species};
use crate::measure::{
    self, BadOption, Measure, Needs, Probe, ReplicaRecords, SampleContext, described, keeps_record,
};
use crate::plan::{CasePlan, EnginePlan, logarithmic};
use crate::theory::homogeneous::{self, Theory};

/// Measure of `<|R(t + lag) - R(t)|^2>`, averaged over the times of a trajectory and over
/// trajectories.
pub struct TimeAveragedDisplacement;

const NAME: &str = "time_averaged_displacement";

#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
struct PathOptions {
    /// Number of particles of each species whose whole paths are kept.
    #[schemars(range(min = 1, max = 1_000_000))]
    particles: u64,
}

impl Default for PathOptions {
    fn default() -> Self {
        Self { particles: 1000 }
    }
}

impl Measure for TimeAveragedDisplacement {
    described!(
        NAME,
        "Squared displacement over a lag, averaged over time along whole paths, in a gas without positions.",
        PathOptions
    );

    fn check_options(&self, plan: &CasePlan) -> Result<(), BadOption> {
        species::lasting_only(plan)?;
        let particles = measure::options::<PathOptions>(plan, NAME)?.particles;
        let good = (1..=1_000_000).contains(&particles);
        measure::require(good, "particles", "a whole number from 1 to 1000000")?;
        let allowed = "only with run.first_sample below a tenth of run.until: lags are those of the samples up to there";
        measure::require(!lags(plan).is_empty(), "", allowed)
    }

    fn sample_times(&self, plan: &CasePlan) -> Vec<f64> {
        vec![plan.case.run.until]
    }

    fn engine_needs(&self, plan: &CasePlan) -> Needs {
        Needs {
            displacements: true,
            trajectories: paths(plan),
        }
    }

    fn new_probe(&self, plan: &CasePlan, _engine: &EnginePlan) -> Box<dyn Probe> {
        let lags = lags(plan);
        Box::new(PathProbe {
            grouping: plan.grouping(),
            groups: plan.gas.species.len(),
            paths: paths(plan),
            lags: lags.iter().map(|&lag| plan.engine_time(lag)).collect(),
            record: PathAverages::default(),
        })
    }

    fn result_tables(&self, plan: &CasePlan, runs: &ReplicaRecords<'_>) -> Vec<Table> {
        let mut rows = rows(plan, &runs.records(0));
        compare_with_ensemble(plan, &mut rows, &runs.records(0), &runs.records_of(0));
        vec![table(plan, &rows)]
    }
}

/// Returns the number of trajectories of each species that are stored; 0 without the measure.
fn paths(plan: &CasePlan) -> usize {
    let asked = plan.case.measure.contains_key(NAME) && plan.case.aggregation.is_none();
    let options = asked
        .then(|| measure::options::<PathOptions>(plan, NAME).ok())
        .flatten();
    options.map_or(0, |options| options.particles as usize)
}

/// Returns the lags, in the unit of time of the case. They are spaced as the samples, up to a tenth
/// of the run, beyond which a trajectory has too few independent starts.
fn lags(plan: &CasePlan) -> Vec<f64> {
    let (first, last) = (plan.first_sample(), 0.1 * plan.case.run.until);
    if first >= last {
        return Vec::new();
    }
    logarithmic(first, last, plan.samples_per_decade()).collect()
}

/// Time averages in one replica, by species group and lag: mean over trajectories, and mean of the
/// squares.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PathAverages(Vec<Vec<[f64; 2]>>);

impl PathAverages {
    /// Returns the mean over the trajectories of a species group at a lag, and the mean of the
    /// squares; NaN without trajectories.
    fn average_at(&self, group: usize, lag: usize) -> [f64; 2] {
        let averages = self.0.get(group).and_then(|averages| averages.get(lag));
        averages.copied().unwrap_or([f64::NAN; 2])
    }
}

struct PathProbe {
    grouping: Grouping,
    groups: usize,
    paths: usize,
    /// Lags between two times of a trajectory \[engine time\].
    lags: Vec<f64>,
    record: PathAverages,
}

impl PathProbe {
    /// Returns the indices of the particles of each species group whose trajectories are stored:
    /// its first ones.
    fn chosen(&self, moment: &SampleContext<'_>) -> Vec<Vec<u32>> {
        let mut lists = vec![Vec::new(); self.groups];
        let mut index = 0;
        moment.simulation.visit_particles(&mut |particle| {
            let list = lists.get_mut(self.grouping.group(particle.species));
            if let Some(list) = list.filter(|list| list.len() < self.paths) {
                list.push(index);
            }
            index += 1;
        });
        lists
    }
}

impl Probe for PathProbe {
    fn on_start(&mut self, moment: &mut SampleContext<'_>) {
        moment.simulation.track_displacements();
    }

    fn on_sample(&mut self, moment: &mut SampleContext<'_>) {
        let chosen = self.chosen(moment).into_iter();
        let simulation = &*moment.simulation;
        let averages = chosen.map(|list| {
            let sums = simulation.time_averaged_displacements(&list, &self.lags);
            let count = list.len().max(1) as f64;
            let sums = sums.into_iter().flatten();
            sums.map(|sums| sums.map(|sum| sum / count)).collect()
        });
        self.record = PathAverages(averages.collect());
    }

    keeps_record!();
}

/// Row of the table of time-averaged displacements: one species at one lag, averaged over all
/// replicas.
pub(super) struct PathRow {
    /// Lag between two times of a trajectory, in the unit of time of the case.
    pub lag: f64,
    /// Index of the species, from 0.
    pub species: usize,
    /// Time-averaged squared displacement over the lag, with its theory \[engine length^2\].
    pub displacement: TableEstimate,
    /// Ergodicity breaking parameter: variance of the time averages of single trajectories over
    /// their squared mean.
    pub breaking: TableEstimate,
    /// Time-averaged squared displacement over that of all particles in the first lag of the run.
    pub over_ensemble: TableEstimate,
}

/// Builds the rows of all species and lags; empty without records.
pub(super) fn rows(plan: &CasePlan, records: &[&PathAverages]) -> Vec<PathRow> {
    if records.is_empty() {
        return Vec::new();
    }
    let lags = lags(plan);
    let engine: Vec<f64> = lags.iter().map(|&lag| plan.engine_time(lag)).collect();
    let theory = homogeneous::curves(plan).ok().and_then(|curves| {
        let until = plan.engine_time(plan.case.run.until);
        let theory = Theory::from_plan(plan).ok()?;
        theory.time_averaged(curves.orders, &engine, until)
    });
    let mut rows = Vec::new();
    for species in 0..plan.gas.species.len() {
        for (index, &lag) in lags.iter().enumerate() {
            let of = |record: &&PathAverages| record.average_at(species, index)[0];
            let theory = theory.as_ref().map(|theory| theory[species][index]);
            let moments = |record: &&PathAverages| {
                let [mean, square] = record.average_at(species, index);
                [1.0, mean, square]
            };
            let moments: Vec<[f64; 3]> = records.iter().map(moments).collect();
            let variance = |[count, mean, square]: [f64; 3]| count * square / (mean * mean) - 1.0;
            rows.push(PathRow {
                lag,
                species,
                displacement: against(measured(records, of, None), theory),
                breaking: mean_over_replicas(of_sums(&moments, variance).into_iter().map(Some)),
                over_ensemble: TableEstimate::default(),
            });
        }
    }
    rows
}

/// Fills in the time-averaged displacements over those of all particles during an equal time from
/// the start, if these were measured. The ratio is one if diffusion does not age.
fn compare_with_ensemble(
    plan: &CasePlan,
    rows: &mut [PathRow],
    records: &[&PathAverages],
    gas: &[&record::SpeciesRecord],
) {
    if !record::has_displacement(plan) {
        return;
    }
    let curves = homogeneous::curves(plan).ok();
    let lags = lags(plan);
    for (index, time) in plan.sample_times().into_iter().enumerate() {
        let Some(lag) = lags.iter().position(|&lag| lag == time) else {
            continue;
        };
        let curve = curves.and_then(|curves| curves.at.get(index));
        for row in rows.iter_mut().filter(|row| row.lag == time) {
            let all = records.iter().zip(pairs(gas, index));
            let both = all.filter_map(|(record, (sample, _))| {
                let ensemble = sample.groups.get(row.species)?.displacement;
                Some([record.average_at(row.species, lag)[0], ensemble])
            });
            let both: Vec<[f64; 2]> = both.collect();
            let group = curve.and_then(|curve| curve.groups.get(row.species));
            let theory = row.displacement.theory.zip(group);
            row.over_ensemble = TableEstimate {
                theory: theory.map(|(averaged, group)| averaged / group.displacement.value),
                ..mean_over_replicas(
                    of_sums(&both, |[averaged, all]| averaged / all)
                        .into_iter()
                        .map(Some),
                )
            };
        }
    }
}

fn table(plan: &CasePlan, rows: &[PathRow]) -> Table {
    let mut table = table! {
        NAME, "Displacement averaged over time along whole paths up to the end of the run";
        key "lag", "unit of time", "Lag";
        key "species", "1", "Number of the species, from 1";
        key "species_name", "", "Name of the species";
        note "mass", "mass", "Mass of a particle";
        with_theory_error "mean_squared_displacement", "length^2",
            "Squared displacement over the lag, averaged over all its starts and over paths";
        note "paths", "1", "Paths in each replica";
        estimate "ergodicity_breaking", "1",
            "Ergodicity breaking parameter: variance over paths of the averages of single paths, over their squared mean";
        with_theory "over_ensemble", "1",
            "The average over the mean squared displacement in the same time since the start, 1 where diffusion does not age; \
             empty without [measure.displacement]";
    };
    for row in rows {
        let species = &plan.gas.species[row.species];
        let paths = species.count.min(paths(plan));
        table.add((
            row.lag,
            (row.species + 1, &*species.name),
            species.mass,
            row.displacement,
            paths,
            row.breaking,
            row.over_ensemble,
        ));
    }
    let figure = record::against_time(
        "Time-averaged displacement",
        FigureAxis::logarithmic("mean_squared_displacement", "δ²"),
        "Squared displacement over a lag, averaged over all its starts in the run and over paths. In a gas that cools it \
         differs from the mean squared displacement since the start: diffusion ages.",
    );
    let breaking = record::against_time(
        "Ergodicity breaking",
        FigureAxis::logarithmic("ergodicity_breaking", "<(δ²)²>/<δ²>² − 1"),
        "Variance of the averages of single paths over their squared mean: zero where one long path tells what all do. It grows \
         with the lag, as ever fewer independent starts fit in the run.",
    );
    for figure in [figure, breaking] {
        table.figures.push(Figure {
            x: FigureAxis::logarithmic("lag", "lag"),
            ..figure.by(&["species_name"])
        });
    }
    table
}
