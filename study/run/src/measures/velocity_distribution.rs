//! Measure `velocity_distribution`: histograms of velocities over the thermal speed, with tails and
//! cumulants.

use serde::Deserialize;
use stosszahl_analysis::velocities::{Bins, VelocityHistogram, VelocityQuantity};
use stosszahl_results::{Figure, FigureAxis, PointMark, Table, table};
use stosszahl_theory::cooling;

use super::mean_over_replicas;
use super::structure_factor::structure_times;
use crate::measure::{self, BadOption, Measure, Probe, ReplicaRecords, SampleProbe, described};
use crate::plan::{CasePlan, EnginePlan};

/// Measure `velocity_distribution` over the thermal speed, with cumulants.
pub struct VelocityDistributionMeasure;

/// Quantity whose distribution is measured: components or speed.
#[derive(Clone, Copy, Debug, Default, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Counted {
    /// Velocity components, with their sign.
    #[default]
    Component,
    /// Speed: the magnitude of the velocity.
    Speed,
}

/// Options of `[measure.velocity_distribution]`: times and bins.
#[derive(Clone, Debug, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct VelocityDistributionOptions {
    /// Times at which velocity distributions are measured. Default: the start and the end of the
    /// run.
    pub times: Option<Vec<f64>>,
    /// Quantity whose distribution is measured: components or speed.
    pub quantity: Counted,
    /// Number of bins of the histogram.
    pub bins: u64,
    /// Largest magnitude over the thermal speed sqrt(2 T/m).
    pub range: f64,
}

impl Default for VelocityDistributionOptions {
    fn default() -> Self {
        Self {
            times: None,
            quantity: Counted::Component,
            bins: 100,
            range: 5.0,
        }
    }
}

impl VelocityDistributionOptions {
    fn bins(&self, plan: &CasePlan) -> Bins {
        Bins {
            quantity: match self.quantity {
                Counted::Component => VelocityQuantity::Component,
                Counted::Speed => VelocityQuantity::Speed,
            },
            dimension: plan.gas.dimension,
            number: self.bins as usize,
            range: self.range,
        }
    }
}

/// Velocity histograms of one replica, by time, then by species; `None` for species at rest.
type Record = Vec<(f64, Vec<Option<VelocityHistogram>>)>;

/// Computes the theoretical fourth cumulant in first Sonine order: for one species with constant
/// restitution that cools freely from a Maxwellian, or is driven and steady. `None` if no theory
/// applies.
fn theory(plan: &CasePlan, time: f64) -> Option<f64> {
    let (dimension, r) = (plan.gas.dimension, plan.gas.law.constant()?);
    let alone = if plan.has_box() {
        plan.has_theory()
    } else {
        plan.gas.classes.len() == 1 && plan.case.aggregation.is_none()
    };
    if !alone {
        return None;
    }
    if plan.case.bath().is_some() {
        return Some(plan.fourth_cumulant());
    }
    if r == 1.0 {
        return Some(0.0);
    }
    let passed = plan
        .time_over_haff(time)
        .filter(|_| plan.case.thermostat.is_none())?;
    // Collisions of a particle in which the thermal speed falls to 1/e.
    let collisions = 2.0 * dimension as f64 / (1.0 - r * r);
    let exponent = cooling::cumulant_relaxation(dimension, r) * collisions;
    let last = cooling::fourth_cumulant(dimension, r);
    Some(last * -(-exponent * passed.ln_1p()).exp_m1())
}

impl Measure for VelocityDistributionMeasure {
    described!(
        "velocity_distribution",
        "Distribution of velocities over the thermal speed, with tails, and the cumulants a2 and a3.",
        VelocityDistributionOptions
    );

    fn check_options(&self, plan: &CasePlan) -> Result<(), BadOption> {
        let options: VelocityDistributionOptions = measure::options(plan, self.name())?;
        let VelocityDistributionOptions { bins, range, .. } = options;
        let allowed = "a whole number from 2 to 10000";
        measure::require((2..=10_000).contains(&bins), "bins", allowed)?;
        let allowed = "a number of thermal speeds from 0.1 to 100";
        measure::require((0.1..=100.0).contains(&range), "range", allowed)
    }

    fn sample_times(&self, plan: &CasePlan) -> Vec<f64> {
        structure_times(
            plan,
            measure::chosen::<VelocityDistributionOptions>(plan, self.name()).times,
        )
    }

    fn kept_bytes(&self, plan: &CasePlan) -> f64 {
        let bins = measure::chosen::<VelocityDistributionOptions>(plan, self.name()).bins as usize;
        let each = size_of::<VelocityHistogram>() + bins * size_of::<f64>();
        (self.sample_times(plan).len() * plan.gas.species.len() * each) as f64
    }

    fn new_probe(&self, plan: &CasePlan, _engine: &EnginePlan) -> Box<dyn Probe> {
        let bins = measure::chosen::<VelocityDistributionOptions>(plan, self.name()).bins(plan);
        let grouping = plan.grouping();
        Box::new(SampleProbe::new(Record::new(), move |record, moment| {
            let found = bins.measure(grouping, &mut |sum| moment.simulation.reduce_particles(sum));
            record.push((moment.time, found));
        }))
    }

    fn result_tables(&self, plan: &CasePlan, runs: &ReplicaRecords<'_>) -> Vec<Table> {
        let options = measure::chosen::<VelocityDistributionOptions>(plan, self.name());
        let bins = options.bins(plan);
        let (mut densities, mut cumulants) = (density_table(&options), cumulant_table());
        for (engine, records) in runs.each::<Record>(plan) {
            let times = records.first().map_or(&[][..], |one| one.as_slice());
            for (index, &(time, _)) in times.iter().enumerate() {
                let a2 = theory(plan, time);
                for (number, species) in plan.gas.species.iter().enumerate() {
                    let of = |part: &dyn Fn(&VelocityHistogram) -> f64| {
                        let found = records.iter().map(|record| record[index].1.get(number));
                        mean_over_replicas(found.map(|found| found?.as_ref().map(part)))
                    };
                    let fourth = of(&|found| found.fourth_cumulant).against(a2);
                    cumulants.add((
                        (engine.name, time, &*species.name),
                        fourth,
                        of(&|found| found.sixth_cumulant),
                        of(&|found| found.beyond).value,
                        records.len(),
                    ));
                    for bin in 0..bins.number {
                        let [low, high] = bins.edges(bin);
                        let expected = a2.map(|a2| bins.sonine(bin, a2));
                        densities.add((
                            (engine.name, time, &*species.name),
                            [low, high, 0.5 * (low + high)],
                            of(&|found| found.density[bin]).against(expected),
                            bins.sonine(bin, 0.0),
                        ));
                    }
                }
            }
        }
        vec![densities, cumulants]
    }
}

fn density_table(options: &VelocityDistributionOptions) -> Table {
    let label = match options.quantity {
        Counted::Component => "velocity over thermal speed",
        Counted::Speed => "speed over thermal speed",
    };
    let figure = Figure::curves(
        "Distribution of velocities",
        FigureAxis::linear("c", label),
        FigureAxis::logarithmic("density", "density"),
    );
    table! {
        "velocity_distribution", "Distribution of velocities over the thermal speed sqrt(2 T/m) of the moment.";
        key "engine", "", "Engine";
        key "time", "time", "Time since the start";
        key "species", "", "Name of the species";
        key "c_low", "1", "Lower edge of the bin: a component of the velocity relative to the mean flow of the species, or its magnitude, over sqrt(2 T/m)";
        key "c_high", "1", "Upper edge";
        key "c", "1", "Middle";
        with_theory "density", "1", "Density, of integral one; theory is a Maxwellian with the first Sonine correction by the a2 of theory";
        value "maxwellian", "1", "Density of a Maxwellian, mean over the bin";
    }
    .figure(figure.by(&["engine", "species"]).panels(&["time"]).mark(PointMark::Points))
}

fn cumulant_table() -> Table {
    let figure = Figure::curves(
        "Cumulants of the velocities",
        FigureAxis::linear("time", "time"),
        FigureAxis::linear("a2", "a2"),
    );
    table! {
        "velocity_cumulants", "Cumulants of the distribution of velocities.";
        key "engine", "", "Engine";
        key "time", "time", "Time since the start";
        key "species", "", "Name of the species";
        with_theory "a2", "1", "Fourth cumulant, 4 <c^4>/(D (D + 2)) - 1; theory is first Sonine order of a gas that starts as a Maxwellian, and of the steady state of a driven one";
        estimate "a3", "1", "Sixth cumulant, 1 + 3 a2 - 8 <c^6>/(D (D + 2) (D + 4))";
        value "beyond", "1", "Share of velocities beyond the bins";
        note "replicas", "1", "Replicas";
    }
    .figure(figure.by(&["engine", "species"]).line("Maxwellian", 0.0))
}
