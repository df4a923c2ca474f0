//! What happens at contact, against molecular chaos at the local granular temperature: where chaos breaks, and whether partners know each
//! other or only share a flow.

use serde::Deserialize;
use stosszahl_analysis::contacts::{Contacts, MEMORY, NEAR, ORDERS, Sums};
use stosszahl_analysis::replicas::pseudo_values;
use stosszahl_case::Kind;
use stosszahl_model::Observer;
use stosszahl_results::{Axis, Figure, Table, Verdict, table};

use super::impact_parameters::{Spans, spans};
use super::over;
use crate::judge::{self, title};
use crate::measure::{
    self, BadOption, Measure, Moment, Probe, Runs, Stop, described, keeps_record,
};
use crate::plan::{EnginePlan, Plan};

/// What happens at contact.
pub struct AtContact;

/// Windows.
#[derive(Clone, Debug, Default, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Options {
    /// Time windows \[start, end\], or "whole-run" for one. Default: those of the impact parameters.
    pub windows: Option<Spans>,
}

/// Windows of one engine and replica; none before the start.
type Record = Option<Contacts>;

struct ContactProbe {
    spans: Vec<[f64; 2]>,
    record: Record,
}

impl Probe for ContactProbe {
    fn observer(&mut self) -> Option<&mut dyn Observer> {
        self.record
            .as_mut()
            .map(|record| record as &mut dyn Observer)
    }

    fn begin(&mut self, moment: &mut Moment<'_>) {
        let time = moment.simulation.time();
        let record = self
            .record
            .insert(Contacts::new(&self.spans, moment.particles()));
        record.look(time, moment.particles());
    }

    fn stop(&mut self, stop: &Stop) {
        if let Some(record) = &mut self.record {
            record.synchronise(stop.temperature);
        }
    }

    fn sample(&mut self, moment: &mut Moment<'_>) {
        let time = moment.simulation.time();
        if let Some(record) = &mut self.record {
            record.look(time, moment.particles());
        }
    }

    keeps_record!();
}

impl AtContact {
    fn spans(&self, plan: &Plan) -> Vec<[f64; 2]> {
        let options: Options = measure::chosen(plan, self.name());
        spans(plan, options.windows)
    }
}

impl Measure for AtContact {
    described!(
        "contacts",
        "Speeds, impact parameters and repeated collisions at contact, against molecular chaos at the local temperature.",
        Options
    );

    fn check(&self, plan: &Plan) -> Result<(), BadOption> {
        let boxed = plan.kind != Kind::Homogeneous;
        measure::require(boxed, "", "a gas in a box; this one has no positions")?;
        let Options { windows } = measure::options(plan, self.name())?;
        super::impact_parameters::check_windows(plan, windows)
    }

    /// The edges of the windows, and some looks at the local temperature in each.
    fn times(&self, plan: &Plan) -> Vec<f64> {
        let mut times = plan.sample_times();
        times.extend(self.spans(plan).into_flattened());
        times.retain(|&time| time > 0.0);
        times
    }

    fn kept_per_particle(&self, _plan: &Plan) -> f64 {
        (MEMORY * size_of::<u32>()) as f64
    }

    fn probe(&self, plan: &Plan, _engine: &EnginePlan) -> Box<dyn Probe> {
        let spans = self.spans(plan).into_iter();
        let spans = spans.map(|span| span.map(|edge| plan.engine_time(edge)));
        Box::new(ContactProbe {
            spans: spans.collect(),
            record: None,
        })
    }

    fn tables(&self, plan: &Plan, runs: &Runs<'_>) -> Vec<Table> {
        let mut table = table! {
            "chaos", "What happens at contact, against molecular chaos at the local granular temperature.";
            key "engine", "", "Engine";
            key "window_start", "time", "Start of the window";
            key "window_end", "time", "End of the window";
            key "quantity", "", "before_p, after_p: moment <g^p> of the normal speed before and after contact over that of chaos before it; collisions: of a particle in the window; slope_slow, slope_fast: slope of P(b/d) of pairs below and above the mean squared speed; slope_near, slope_shuffled: of approaching pairs within 1.1 d, as they are and with partners shuffled within the local flow; parallel, perpendicular: velocity correlation of pairs within 1.1 d, flow included; again: share of collisions of partners that have met nobody else since they met; returned: of those that met within their last 8 collisions; between: collisions of both between such two meetings";
            with_theory "value", "1", "Its value; theory is molecular chaos";
            note "replicas", "1", "Replicas";
        }
        .figure(
            Figure::curves("Contacts over molecular chaos", Axis::logarithmic("window_end", "end of the window"), Axis::linear("value", "value"))
                .panels(&["quantity"]),
        );
        for (engine, records) in runs.each::<Record>(plan) {
            for (number, &span) in self.spans(plan).iter().enumerate() {
                let sums = sums(&records, number);
                for quantity in quantities(plan) {
                    let found = over(quantity.values(&sums)).against(quantity.theory);
                    if found.value.is_some() {
                        table.add((engine.name, span, &*quantity.name, found, sums.len()));
                    }
                }
            }
        }
        vec![table]
    }

    /// Whether partners near contact know each other in the last window, or only share a flow.
    fn verdicts(&self, plan: &Plan, runs: &Runs<'_>, _tables: &[Table]) -> Vec<Verdict> {
        let all = self.spans(plan);
        let Some(number) = all.len().checked_sub(1) else {
            return Vec::new();
        };
        let [start, end] = all[number].map(judge::short);
        let one = |(engine, records): (&EnginePlan, Vec<&Record>)| {
            let (sums, name) = (sums(&records, number), title(engine.name));
            let slope = |wanted: &str| {
                let known = quantities(plan);
                let quantity = known.iter().find(|one| one.name == wanted)?;
                let found = over(quantity.values(&sums));
                found.value.map(|_| judge::in_units(&found, 1.0))
            };
            let sentence = format!(
                "{name}, t = {start} to {end}: the slope of P(b/d) of pairs that approach within {NEAR} d is {}; with partners \
                 shuffled within the local flow, {}.",
                slope("slope_near")?,
                slope("slope_shuffled")?
            );
            Some(judge::note(format!("pairs near contact, {name}"), sentence))
        };
        runs.each::<Record>(plan).filter_map(one).collect()
    }
}

/// One window of all replicas, with the number of particles and the dimension of the gas.
fn sums(records: &[&Record], number: usize) -> Vec<(Sums, f64)> {
    let known = records.iter().filter_map(|record| record.as_ref());
    known
        .map(|one| (one.windows[number].1, one.particles()))
        .collect()
}

/// The sums above and below the line, of one replica and its number of particles.
type Pick = dyn Fn(&(Sums, f64)) -> [f64; 2];

/// A ratio of two sums, after `of`.
struct Quantity {
    name: String,
    sums: Box<Pick>,
    of: fn(f64) -> f64,
    theory: Option<f64>,
}

impl Quantity {
    /// Pseudo-values over the replicas; none where nothing is known.
    fn values(&self, all: &[(Sums, f64)]) -> Vec<Option<f64>> {
        let each: Vec<[f64; 2]> = all
            .iter()
            .map(|one| (self.sums)(one))
            .filter(|[_, below]| *below > 0.0)
            .collect();
        let values = pseudo_values(each.len(), |without| {
            let kept = each
                .iter()
                .enumerate()
                .filter(|(index, _)| Some(*index) != without);
            let [above, below] = kept.fold([0.0; 2], |[a, b], (_, [x, y])| [a + x, b + y]);
            (self.of)(above / below)
        });
        values.into_iter().map(Some).collect()
    }
}

/// All quantities, in the order of the table.
fn quantities(plan: &Plan) -> Vec<Quantity> {
    fn as_is(ratio: f64) -> f64 {
        ratio
    }
    fn slope(mean: f64) -> f64 {
        12.0 * (mean - 0.5)
    }
    let one = |name: &str, theory, of, sums: fn(&(Sums, f64)) -> [f64; 2]| Quantity {
        name: name.to_owned(),
        sums: Box::new(sums),
        of,
        theory,
    };
    let mut all = vec![one("collisions", None, as_is, |(sums, particles)| {
        [2.0 * sums.physical, *particles]
    })];
    for (index, order) in ORDERS.into_iter().enumerate() {
        let restitution = plan.law.constant();
        let moment = |name: &str, theory, sums: fn(&Sums, usize) -> f64| Quantity {
            name: format!("{name}_{order}"),
            sums: Box::new(move |(all, _)| [sums(all, index), all.chaos[index]]),
            of: as_is,
            theory,
        };
        all.push(moment("before", Some(1.0), |all, index| all.before[index]));
        all.push(moment(
            "after",
            restitution.map(|r| r.powi(order)),
            |all, index| all.after[index],
        ));
    }
    let zero = Some(0.0);
    all.extend([
        one("slope_slow", zero, slope, |(all, _)| {
            [all.impacts[0], all.pairs[0]]
        }),
        one("slope_fast", zero, slope, |(all, _)| {
            [all.impacts[1], all.pairs[1]]
        }),
        one("slope_near", zero, slope, |(all, _)| {
            [all.flux_impacts[0], all.flux[0]]
        }),
        one("slope_shuffled", zero, slope, |(all, _)| {
            [all.flux_impacts[1], all.flux[1]]
        }),
        one("parallel", zero, as_is, |(all, _)| {
            [all.products[0], all.squares[0]]
        }),
        one("perpendicular", zero, as_is, |(all, _)| {
            [all.products[1], all.squares[1]]
        }),
        one("again", zero, as_is, |(all, _)| [all.again, all.named]),
        one("returned", zero, as_is, |(all, _)| {
            [all.returned, all.named]
        }),
        one("between", None, as_is, |(all, _)| {
            [all.between, all.returned]
        }),
    ]);
    all
}
