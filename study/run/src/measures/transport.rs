//! Measure `transport`: transport coefficients of elastic disks by Einstein-Helfand moments and
//! Green-Kubo integrals, against Enskog's theory.

use serde::Deserialize;
use stosszahl_analysis::helfand::{Correlations, Helfand, HelfandMoments};
use stosszahl_model::{Collision, Observer, format_short};
use stosszahl_results::{Figure, FigureAxis, Table, TableEstimate, VerdictText, table};
use stosszahl_theory::ElasticDisks;

use super::mean_over_replicas;
use crate::judge::{Comparison, DifferenceUnit, Finding, VerdictRule, interval_of, title};
use crate::measure::{
    self, BadOption, Measure, Probe, ReplicaRecords, SampleContext, described, keeps_record,
};
use crate::plan::{CasePlan, EnginePlan};

/// Measure `transport` of the transport coefficients of elastic disks.
pub struct TransportMeasure;

/// Default of the largest lag \[mean free times\].
const LAG: f64 = 20.0;
/// Largest allowed lag, as a share of the run.
const LARGEST_SHARE: f64 = 0.25;

/// Options of `[measure.transport]`: lags.
#[derive(Clone, Debug, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct TransportOptions {
    /// Largest lag; coefficients are slopes from half of it on. Default: 20 mean free times, at
    /// most a quarter of the run.
    pub lag: Option<f64>,
    /// Number of lags up to the largest, an even number.
    pub points: u64,
}

impl Default for TransportOptions {
    fn default() -> Self {
        Self {
            lag: None,
            points: 40,
        }
    }
}

impl TransportOptions {
    /// Returns the largest lag of a case, in the unit of time of the case.
    fn lag(&self, plan: &CasePlan) -> f64 {
        let longest = LARGEST_SHARE * plan.case.run.until;
        let usual = LAG * plan.clock.mean_free_time / plan.clock.time;
        self.lag.unwrap_or_else(|| usual.min(longest))
    }
}

/// Helfand moments of one event-driven engine and replica; `None` for other engines.
type Record = Option<Helfand>;

/// Transport coefficient, or one part of it: column names, Helfand moment, correlation, and
/// Enskog's value.
struct Coefficient {
    name: &'static str,
    over: Option<[&'static str; 2]>,
    meaning: &'static str,
    moment: fn(&HelfandMoments) -> f64,
    correlation: Option<fn(&Correlations) -> f64>,
    theory: fn(&ElasticDisks) -> f64,
}

const KINETIC: &str = "What moving disks carry of it";
const CROSS: &str = "What the correlation of kinetic and collisional transfer adds to it";
const COLLISIONAL: &str = "What collisions carry of it over the distance of two centres";

/// Creates a list of transport coefficients from one line for each.
macro_rules! coefficients {
    ($($name:literal $over:expr, $meaning:expr, $moment:expr, $correlation:expr, $theory:expr;)*) => {
        &[$(Coefficient {
            name: $name,
            over: $over,
            meaning: $meaning,
            moment: $moment,
            correlation: $correlation,
            theory: $theory,
        }),*]
    };
}

const COEFFICIENTS: &[Coefficient] = coefficients! {
    "self_diffusion" Some(["self_diffusion_over_enskog", "self_diffusion_green_kubo"]), "Self-diffusion coefficient, in units of diameter, mass and temperature; theory is Enskog's in three Sonine orders",
        |m| m.diffusion, Some(|c| c.diffusion), ElasticDisks::self_diffusion;
    "shear_viscosity" Some(["shear_viscosity_over_enskog", "shear_viscosity_green_kubo"]), "Shear viscosity in the same units; theory is Enskog's of all orders",
        |m| m.shear.iter().sum(), Some(|c| c.shear), |e| e.shear_viscosity().sum();
    "shear_viscosity_kinetic" None, KINETIC, |m| m.shear[0], None, |e| e.shear_viscosity().kinetic;
    "shear_viscosity_cross" None, CROSS, |m| m.shear[1], None, |e| e.shear_viscosity().cross;
    "shear_viscosity_collisional" None, COLLISIONAL, |m| m.shear[2], None, |e| e.shear_viscosity().collisional;
    "bulk_viscosity" Some(["bulk_viscosity_over_enskog", "bulk_viscosity_green_kubo"]), "Bulk viscosity, all of it collisional",
        |m| m.bulk, Some(|c| c.bulk), ElasticDisks::bulk_viscosity;
    "heat_conductivity" Some(["heat_conductivity_over_enskog", "heat_conductivity_green_kubo"]), "Heat conductivity, Boltzmann's constant being one",
        |m| m.heat.iter().sum(), Some(|c| c.heat), |e| e.heat_conductivity().sum();
    "heat_conductivity_kinetic" None, KINETIC, |m| m.heat[0], None, |e| e.heat_conductivity().kinetic;
    "heat_conductivity_cross" None, CROSS, |m| m.heat[1], None, |e| e.heat_conductivity().cross;
    "heat_conductivity_collisional" None, COLLISIONAL, |m| m.heat[2], None, |e| e.heat_conductivity().collisional;
};

/// Returns the whole transport coefficients, without their kinetic and collisional parts.
fn whole_coefficients() -> impl Iterator<Item = &'static Coefficient> {
    COEFFICIENTS.iter().filter(|one| one.over.is_some())
}

impl Coefficient {
    /// Computes the slope of the coefficient's moment against the lag, from half of the largest lag
    /// on.
    fn slope(&self, moments: &[HelfandMoments], points: usize) -> Option<f64> {
        let (half, all) = (moments.get(points / 2 - 1)?, moments.get(points - 1)?);
        let rise = (self.moment)(all) - (self.moment)(half);
        Some(rise / (all.lag - half.lag))
    }

    /// Computes the Green-Kubo integrals of the coefficient's correlation up to each lag, by the
    /// trapezoidal rule; empty for a coefficient without a correlation.
    fn integrals(&self, correlations: &[Correlations]) -> Vec<f64> {
        let Some(of) = self.correlation else {
            return Vec::new();
        };
        let mut sum = 0.0;
        let step = correlations.get(1).map_or(0.0, |one| one.lag);
        let all = correlations.iter().enumerate();
        let integrals = all.map(|(lag, one)| {
            // The trapezoidal rule: half of the first, of each the other half when the next comes.
            let own = of(one) * step;
            let half = 0.5 * own;
            sum += if lag == 0 { half } else { own };
            if lag == 0 { 0.0 } else { sum - half }
        });
        integrals.collect()
    }

    /// Estimates the coefficient as the mean of its Green-Kubo integrals from half of the largest
    /// lag on.
    fn green_kubo(&self, all: &[Vec<Correlations>]) -> TableEstimate {
        mean_over_replicas(all.iter().map(|correlations| {
            let integrals = self.integrals(correlations);
            let late = integrals.get(integrals.len() / 2..)?;
            (!late.is_empty()).then(|| late.iter().sum::<f64>() / late.len() as f64)
        }))
    }

    /// Estimates the transport coefficient from the moments of all replicas, with its standard
    /// error.
    fn estimate(&self, all: &[Vec<HelfandMoments>], points: usize) -> TableEstimate {
        mean_over_replicas(all.iter().map(|moments| self.slope(moments, points)))
    }
}

struct TransportProbe {
    record: Record,
    exact: bool,
    area: f64,
    bin: f64,
    points: usize,
}

impl Observer for TransportProbe {
    fn on_collisions(&mut self, batch: &[Collision]) {
        if let Some(moments) = &mut self.record {
            for collision in batch {
                moments.collide(collision);
            }
        }
    }

    fn is_active(&self) -> bool {
        self.record.is_some()
    }
}

impl Probe for TransportProbe {
    fn collision_observer(&mut self) -> Option<&mut dyn Observer> {
        Some(self)
    }

    fn on_start(&mut self, moment: &mut SampleContext<'_>) {
        if self.exact {
            let start = moment.simulation.time();
            let all = &moment.particles().all;
            let velocities = all.iter().map(|one| one.velocity.xy());
            let mass = all.first().map_or(1.0, |one| one.mass);
            let moments = Helfand::new(start, velocities, mass, self.area, self.bin, self.points);
            self.record = Some(moments);
        }
    }

    fn on_sample(&mut self, moment: &mut SampleContext<'_>) {
        if let Some(moments) = &mut self.record {
            moments.advance(moment.simulation.time());
        }
    }

    keeps_record!();
}

fn enskog(plan: &CasePlan) -> ElasticDisks {
    ElasticDisks {
        packing_fraction: plan.gas.packing_fraction,
        contact_value: plan.gas.contact_value,
    }
}

impl Measure for TransportMeasure {
    described!(
        "transport",
        "Self-diffusion, viscosities and heat conductivity of elastic disks by Einstein-Helfand moments.",
        TransportOptions
    );

    fn check_options(&self, plan: &CasePlan) -> Result<(), BadOption> {
        let options: TransportOptions = measure::options(plan, self.name())?;
        let disks = plan.has_theory() && plan.gas.dimension == 2;
        measure::require(disks, "", "equal smooth disks in a periodic box")?;
        let elastic = plan.gas.restitution == 1.0 && plan.case.bath().is_none();
        let allowed = "an elastic gas, gas.restitution = 1, without a bath: only there do fluctuations in equilibrium tell the \
                       coefficients";
        measure::require(elastic, "", allowed)?;
        let exact = plan.engines.iter().any(EnginePlan::is_exact);
        measure::require(exact, "", "the event-driven engine, [engine.ed]")?;
        let most = 0.5 * plan.case.run.until;
        let lag = options.lag(plan);
        let allowed = format!(
            "a time above 0, at most half of the run = {}",
            format_short(most)
        );
        measure::require(lag > 0.0 && lag <= most, "lag", allowed)?;
        let points = options.points;
        let allowed = "an even number from 2 to 1000";
        let good = (2..=1000).contains(&points) && points.is_multiple_of(2);
        measure::require(good, "points", allowed)
    }

    fn sample_times(&self, plan: &CasePlan) -> Vec<f64> {
        vec![plan.case.run.until]
    }

    fn gathers_particles(&self, _plan: &CasePlan) -> bool {
        true
    }

    fn kept_per_particle(&self, _plan: &CasePlan) -> f64 {
        Helfand::BYTES_PER_DISK as f64
    }

    fn new_probe(&self, plan: &CasePlan, engine: &EnginePlan) -> Box<dyn Probe> {
        let options = measure::chosen::<TransportOptions>(plan, self.name());
        let points = options.points as usize;
        Box::new(TransportProbe {
            record: None,
            exact: engine.is_exact(),
            area: plan.gas.volume,
            bin: plan.engine_time(options.lag(plan) / points as f64),
            points,
        })
    }

    fn result_tables(&self, plan: &CasePlan, runs: &ReplicaRecords<'_>) -> Vec<Table> {
        let options = measure::chosen::<TransportOptions>(plan, self.name());
        let (points, enskog) = (options.points as usize, enskog(plan));
        let mut lags = lag_table();
        let (mut coefficients, mut correlations) = (coefficient_table(), correlation_table());
        for (engine, records) in runs
            .each::<Record>(plan)
            .filter(|(engine, _)| engine.is_exact())
        {
            let all = moments(&records);
            let fluxes = by_replica(&records, Helfand::correlations);
            let mut cells = Vec::new();
            for one in COEFFICIENTS {
                let theory = (one.theory)(&enskog);
                let found = one.estimate(&all, points);
                cells.push(found.against(Some(theory)));
                cells.extend(one.over.map(|_| found.times(1.0 / theory)));
                let integral = one.over.map(|_| one.green_kubo(&fluxes));
                cells.extend(integral.map(|found| found.times(1.0 / theory)));
            }
            coefficients.add((engine.name, cells, all.len()));
            for one in whole_coefficients() {
                let theory = (one.theory)(&enskog);
                let integrals: Vec<_> = fluxes.iter().map(|own| one.integrals(own)).collect();
                for point in 0..points {
                    let values = one.correlation.map(|of| {
                        let unit = plan.clock.time / theory;
                        let values = fluxes.iter().map(|own| Some(of(own.get(point)?) * unit));
                        mean_over_replicas(values)
                    });
                    let integrals = integrals.iter().map(|own| Some(own.get(point)? / theory));
                    let lag = options.lag(plan) * point as f64 / points as f64;
                    let key = (engine.name, one.name, lag);
                    correlations.add((
                        key,
                        values.unwrap_or_default(),
                        mean_over_replicas(integrals),
                        all.len(),
                    ));
                }
                for point in 0..points {
                    let apparent = mean_over_replicas(all.iter().map(|moments| {
                        let moments = moments.get(point)?;
                        Some((one.moment)(moments) / (moments.lag * theory))
                    }));
                    let lag = options.lag(plan) * (point + 1) as f64 / points as f64;
                    lags.add(((engine.name, one.name, lag), apparent, all.len()));
                }
            }
        }
        vec![coefficients, lags, correlations]
    }

    fn test_count(&self, plan: &CasePlan) -> usize {
        plan.engines
            .iter()
            .filter(|engine| engine.is_exact())
            .count()
            * whole_coefficients().count()
    }

    fn result_verdicts(
        &self,
        plan: &CasePlan,
        runs: &ReplicaRecords<'_>,
        _tables: &[Table],
    ) -> Vec<VerdictText> {
        let points = measure::chosen::<TransportOptions>(plan, self.name()).points as usize;
        let enskog = enskog(plan);
        let mut list = Vec::new();
        for (engine, records) in runs
            .each::<Record>(plan)
            .filter(|(engine, _)| engine.is_exact())
        {
            let all = moments(&records);
            for one in whole_coefficients() {
                let found = one.estimate(&all, points);
                let found = found.times(1.0 / (one.theory)(&enskog));
                let rule = runs.rule(plan);
                list.extend(against_enskog(one.name, title(engine.name), &found, rule));
            }
        }
        list
    }
}

/// Computes the Helfand moments of every replica.
fn moments(records: &[&Record]) -> Vec<Vec<HelfandMoments>> {
    by_replica(records, Helfand::moments)
}

fn by_replica<T>(records: &[&Record], of: fn(&Helfand) -> Vec<T>) -> Vec<Vec<T>> {
    let all = records.iter().map(|one| one.as_ref().map(of));
    all.map(Option::unwrap_or_default).collect()
}

/// Decides the verdict on the ratio of a transport coefficient to Enskog's value.
fn against_enskog(
    name: &str,
    engine: &str,
    found: &TableEstimate,
    rule: VerdictRule,
) -> Option<VerdictText> {
    let name = name.replace('_', " ");
    let off = TableEstimate {
        value: found.value.map(|found| found - 1.0),
        ..*found
    };
    let comparison = Comparison {
        topic: &format!("{name}, {engine}"),
        a: engine,
        b: "Enskog's theory",
        quantity: &name,
        unit: DifferenceUnit::Relative,
        rule,
    };
    let finding = Finding {
        interval: interval_of(&off, rule.level),
        place: "from half of the largest lag on".into(),
        level: rule.level,
    };
    comparison.judge(&[finding], "")
}

fn coefficient_table() -> Table {
    let mut table = table! {
        "transport", "Transport coefficients, from half of the largest lag on.";
        key "engine", "", "Engine";
    };
    for one in COEFFICIENTS {
        table = table.with_theory(one.name, "1", one.meaning);
        if let Some(over) = one.over {
            table = table.estimate(over[0], "1", "The same over that theory");
            table = table.estimate(over[1], "1", "The same by the correlation of Green and Kubo, its integral up to lags from half of the largest on");
        }
    }
    table.note("replicas", "1", "Replicas")
}

fn correlation_table() -> Table {
    let figure = Figure::curves(
        "Integrals of Green and Kubo",
        FigureAxis::linear("lag", "lag"),
        FigureAxis::linear("integral", "integral over Enskog's coefficient"),
    );
    let figure =
        figure.caption("What fluxes remember adds to each coefficient until its curve is level.");
    table! {
        "green_kubo", "Correlations of the fluxes by lag, whose integrals are the transport coefficients (Green and Kubo).";
        key "engine", "", "Engine";
        key "coefficient", "", "self_diffusion, shear_viscosity, bulk_viscosity, heat_conductivity";
        key "lag", "time", "Lag; fluxes are means over bins of the width of the smallest one";
        estimate "correlation", "1/time", "Correlation over Enskog's coefficient";
        estimate "integral", "1", "Its integral up to this lag over Enskog's coefficient";
        note "replicas", "1", "Replicas";
    }
    .figure(figure.panels(&["coefficient"]).line("Enskog", 1.0))
}

fn lag_table() -> Table {
    let figure = Figure::curves(
        "Transport coefficients by lag",
        FigureAxis::linear("lag", "lag"),
        FigureAxis::linear(
            "moment_over_lag",
            "moment over lag and Enskog's coefficient",
        ),
    );
    let figure = figure
        .caption("Each tends to the coefficient over Enskog's, and begins below it while velocities are remembered.");
    table! {
        "helfand", "Einstein-Helfand moments by lag.";
        key "engine", "", "Engine";
        key "coefficient", "", "self_diffusion, shear_viscosity, bulk_viscosity, heat_conductivity";
        key "lag", "time", "Lag";
        estimate "moment_over_lag", "1", "Moment over the lag and Enskog's coefficient";
        note "replicas", "1", "Replicas";
    }
    .figure(figure.panels(&["coefficient"]).line("Enskog", 1.0))
}
