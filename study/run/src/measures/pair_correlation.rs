//! Measure `pair_correlation`: the pair correlation function g(r) of disks and of spheres in a
//! periodic box.

use serde::Deserialize;
use stosszahl_analysis::pair_correlation::{PairCorrelation, PairCounts, of_species};
use stosszahl_results::{Figure, FigureAxis, Table, table};

use super::structure_factor::{
    ByTime, SpeciesOf, WithPairs, by_time, mean_diameter, require_periodic, species_pairs,
    structure_times,
};
use crate::measure::{self, BadOption, Measure, Probe, ReplicaRecords, SampleProbe, described};
use crate::plan::{CasePlan, EnginePlan};

/// Measure `pair_correlation` of the function g(r).
pub struct PairCorrelations;

/// Largest number of distance bins of g(r).
const MOST_BINS: f64 = 1e5;

/// Options of `[measure.pair_correlation]`: times, range and bins.
#[derive(Clone, Debug, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct PairCorrelationOptions {
    /// Times at which g(r) is measured. Default: the start and the end of the run.
    pub times: Option<Vec<f64>>,
    /// Largest distance of g(r), in mean diameters.
    pub range: f64,
    /// Width of the bins, in mean diameters. g(r) of inelastic particles has a cusp at contact,
    /// `sqrt(r - d)`; the value at contact itself is in `contact_values.csv` of the measure
    /// `contacts`.
    pub bin_width: f64,
}

impl Default for PairCorrelationOptions {
    fn default() -> Self {
        Self {
            times: None,
            range: 6.0,
            bin_width: 0.05,
        }
    }
}

/// Pair correlation g(r) at each time; `None` at a time without two particles.
type Record = ByTime<Found>;

/// Pair correlation functions at one time, of all particles and of each pair of species.
type Found = WithPairs<PairCorrelation>;

impl Measure for PairCorrelations {
    described!(
        "pair_correlation",
        "Pair correlation g(r): neighbours at a distance, over those of an ideal gas.",
        PairCorrelationOptions
    );

    fn by_default(&self, plan: &CasePlan) -> bool {
        plan.is_uniform_box() && !plan.is_rough()
    }

    fn check_options(&self, plan: &CasePlan) -> Result<(), BadOption> {
        require_periodic(plan)?;
        let options: PairCorrelationOptions = measure::options(plan, self.name())?;
        let allowed = "a range above 1, in diameters";
        let good = options.range > 1.0 && options.range.is_finite();
        measure::require(good, "range", allowed)?;
        let width = options.bin_width;
        let good = width > 0.0 && width <= options.range && options.range / width <= MOST_BINS;
        let allowed = "a width above 0 and up to the range, in diameters; 100 000 bins at most";
        measure::require(good, "bin_width", allowed)
    }

    fn gathers_particles(&self, plan: &CasePlan) -> bool {
        plan.gas.species.len() > 1
    }

    fn sample_times(&self, plan: &CasePlan) -> Vec<f64> {
        structure_times(
            plan,
            measure::chosen::<PairCorrelationOptions>(plan, self.name()).times,
        )
    }

    fn new_probe(&self, plan: &CasePlan, _engine: &EnginePlan) -> Box<dyn Probe> {
        let d = mean_diameter(plan);
        let PairCorrelationOptions {
            range, bin_width, ..
        } = measure::chosen(plan, self.name());
        let (range, width) = (range * d, bin_width * d);
        let sides = plan.gas.lengths[..plan.gas.dimension].to_vec();
        let species = SpeciesOf::new(plan);
        Box::new(SampleProbe::new(Record::new(), move |record, moment| {
            let range = sides
                .iter()
                .fold(range, |range, side| range.min(0.499_999 * side));
            let bins = ((range / width).round() as usize).max(1);
            let found =
                PairCounts::new(&sides, range, bins, &moment.interrupt).and_then(|mut pairs| {
                    moment.simulation.reduce_neighbourhoods(range, &mut pairs);
                    let all = pairs.correlation(d)?;
                    let places = species.places(moment);
                    let pairs = if places.is_empty() {
                        Vec::new()
                    } else {
                        of_species(&places, &sides, d, range, bins, &moment.interrupt)?
                    };
                    Ok(WithPairs { all, pairs })
                });
            record.push((moment.time, found.ok()));
        }))
    }

    fn result_tables(&self, plan: &CasePlan, runs: &ReplicaRecords<'_>) -> Vec<Table> {
        let figure = Figure::curves(
            "Pair correlation",
            FigureAxis::linear("r_over_d", "r/d"),
            FigureAxis::linear("g", "g(r)"),
        );
        let table = table! {
            "pair_correlation", "Pair correlation by distance.";
            key "engine", "", "Engine";
            key "time", "time", "Time since the start";
            key "r_over_d", "1", "Distance of the centres over the mean diameter";
            estimate "g", "1", "Pair correlation g(r); one for an ideal gas";
        }
        .figure(figure.panels(&["time"]).line("ideal gas", 1.0).caption(
            "Of Monte Carlo with several simulators for each particle all simulators are neighbours. At t = 0 they are copies of the exact start, \
             so that pairs of two copies are among them.",
        ));
        let mut tables = vec![by_time(table, plan, runs, |found: &Found| {
            let bins = found.all.bins.iter();
            bins.map(|bin| (bin.r_over_d, bin.g, ())).collect()
        })];
        let named = species_pairs(plan);
        if !named.is_empty() {
            let table = table! {
                "partial_pair_correlation", "Partial pair correlations of the pairs of species, by distance.";
                key "engine", "", "Engine";
                key "time", "time", "Time since the start";
                key "species_a", "1", "Number of one species, from 1";
                key "species_b", "1", "Number of the other, not below the first";
                key "pair", "", "Names of both species";
                key "r_over_d", "1", "Distance of the centres over the mean diameter";
                estimate "g", "1", "Partial pair correlation g_ab(r), of one simulator for each particle; one for an ideal gas";
            }
            .figure(
                Figure::curves(
                    "Partial pair correlations",
                    FigureAxis::linear("r_over_d", "r/d"),
                    FigureAxis::linear("g", "g_ab(r)"),
                )
                .by(&["engine", "pair"])
                .panels(&["time"])
                .line("ideal gas", 1.0)
                .caption("One simulator for each particle."),
            );
            tables.push(by_time(table, plan, runs, |found: &Found| {
                let pairs = named.iter().zip(&found.pairs);
                let rows = pairs.flat_map(|(named, one)| {
                    let bins = one.bins.iter();
                    bins.map(|bin| ((named.0, named.1.clone(), bin.r_over_d), bin.g, ()))
                });
                rows.collect()
            }));
        }
        tables
    }
}
