//! Collisions at contact, against molecular chaos at the local granular temperature: where chaos breaks, and whether partners know each
//! other or only share a flow.

mod contact_values;

use serde::{Deserialize, Serialize};
use stosszahl_analysis::contact_value::ContactFlux;
use stosszahl_analysis::contacts::{
    BYTES_PER_SIMULATOR, Contacts, DISTANCES, EDGES, LONGEST_RING, MOST_BETWEEN, NEAR, ORDERS, Sums,
};
use stosszahl_analysis::replicas::of_sums;
use stosszahl_model::{Collision, Observer};
use stosszahl_results::{Axis, Estimate, Figure, Table, Verdict, table};

use super::impact_parameters::{Spans, spans};
use super::over;
use crate::judge::{self, title};
use crate::measure::{
    self, BadOption, Measure, Moment, Probe, ReplicaRecords, Stop, described, keeps_record,
};
use crate::plan::{EnginePlan, Plan};

/// Measure of collisions at contact.
pub struct AtContact;

/// Windows.
#[derive(Clone, Debug, Default, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Options {
    /// Time windows \[start, end\], or "whole-run" for one. Default: those of the impact parameters.
    pub windows: Option<Spans>,
}

/// Sums of one engine and replica, in windows.
#[derive(Serialize, Deserialize)]
struct ContactSums {
    contacts: Contacts,
    flux: ContactFlux,
}

impl Observer for ContactSums {
    fn collisions(&mut self, batch: &[Collision]) {
        self.contacts.collisions(batch);
        self.flux.collisions(batch);
    }
}

/// Sums of one engine and replica; `None` before the start.
type Record = Option<ContactSums>;

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
        let (particles, temperature) = (moment.particles(), moment.temperature());
        let contacts = Contacts::new(&self.spans, particles);
        let (dimension, number) = (particles.dimension, contacts.particles());
        let flux = ContactFlux::new(&self.spans, dimension, number, time, temperature);
        let record = self.record.insert(ContactSums { contacts, flux });
        record.contacts.look(time, particles);
    }

    fn stop(&mut self, stop: &Stop) {
        if let Some(record) = &mut self.record {
            record.contacts.synchronise(stop.temperature);
            record.flux.synchronise(stop.time, stop.temperature);
        }
    }

    fn sample(&mut self, moment: &mut Moment<'_>) {
        let time = moment.simulation.time();
        if let Some(record) = &mut self.record {
            record.contacts.look(time, moment.particles());
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
        measure::require(
            plan.has_box(),
            "",
            "a gas in a box; this one has no positions",
        )?;
        let Options { windows } = measure::options(plan, self.name())?;
        super::impact_parameters::check_windows(windows.as_ref())
    }

    /// The edges of the windows, and some looks at the local temperature in each.
    fn times(&self, plan: &Plan) -> Vec<f64> {
        let mut times = plan.sample_times();
        times.extend(self.spans(plan).into_flattened());
        times.retain(|&time| time > 0.0);
        times
    }

    fn gathers(&self, _plan: &Plan) -> bool {
        true
    }

    fn kept_per_particle(&self, _plan: &Plan) -> f64 {
        BYTES_PER_SIMULATOR as f64
    }

    fn probe(&self, plan: &Plan, _engine: &EnginePlan) -> Box<dyn Probe> {
        let spans = self.spans(plan).into_iter();
        let spans = spans.map(|span| span.map(|edge| plan.engine_time(edge)));
        Box::new(ContactProbe {
            spans: spans.collect(),
            record: None,
        })
    }

    fn tables(&self, plan: &Plan, runs: &ReplicaRecords<'_>) -> Vec<Table> {
        let mut tables = [chaos_table(), meetings_table(), velocities_table()];
        let [chaos, meetings, velocities] = &mut tables;
        for (engine, records) in runs.each::<Record>(plan) {
            for (number, &span) in self.spans(plan).iter().enumerate() {
                let sums = sums(&records, number);
                for quantity in quantities(plan) {
                    let found = over(quantity.values(&sums)).against(quantity.theory);
                    if found.value.is_some() {
                        chaos.add((engine.name, span, &*quantity.name, found, sums.len()));
                    }
                }
                if sums.iter().all(|(sums, _)| sums.named == 0.0) {
                    continue;
                }
                for length in 0..=MOST_BETWEEN {
                    let [between, ring] = [
                        share(&sums, move |sums| sums.between[length]),
                        share(&sums, move |sums| {
                            sums.rings.get(length).copied().unwrap_or_default()
                        }),
                    ];
                    let known = (2..=LONGEST_RING).contains(&length);
                    let ring = ring.filter(|_| known).unwrap_or_default();
                    let between = between.unwrap_or_default();
                    meetings.add((engine.name, span, length, between, ring, sums.len()));
                }
                for bin in 0..DISTANCES {
                    let found = [(0, 0), (0, 1), (1, 0), (1, 1)].map(|(kind, axis)| {
                        ratio(&sums, move |(sums, _)| {
                            let one = &sums.velocities[bin][kind];
                            [one.products[axis], one.squares[axis]]
                        })
                    });
                    if let [Some(a), Some(b), Some(c), Some(d)] = found {
                        let distance = 0.5 * (EDGES[bin] + EDGES[bin + 1]);
                        let edges = (EDGES[bin], EDGES[bin + 1], distance);
                        velocities.add((engine.name, span, edges, [a, b, c, d], sums.len()));
                    }
                }
            }
        }
        let [chaos, meetings, velocities] = tables;
        let values = contact_values::table(plan, runs, &self.spans(plan));
        vec![chaos, values, meetings, velocities]
    }

    /// Whether partners near contact know each other in the last window, or only share a flow.
    fn verdicts(&self, plan: &Plan, runs: &ReplicaRecords<'_>, _tables: &[Table]) -> Vec<Verdict> {
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
        .map(|one| (one.contacts.windows[number].1, one.contacts.particles()))
        .collect()
}

fn chaos_table() -> Table {
    table! {
        "chaos", "What happens at contact, against molecular chaos at the local granular temperature.";
        key "engine", "", "Engine";
        key "window_start", "time", "Start of the window";
        key "window_end", "time", "End of the window";
        key "quantity", "", "before_p, after_p: moment <g^p> of the normal speed before and after contact over that of chaos before it; collisions: of a particle in the window; heat: local temperature over that of the whole gas, flow included; slope_slow, slope_fast: slope of P(b/d) of pairs below and above the mean squared speed; slope_near, slope_shuffled: of approaching pairs within 1.1 d, as they are and with partners shuffled within the local flow; parallel, perpendicular: velocity correlation of pairs within 1.1 d, flow included; again: share of collisions of partners that have met no other particle since they met; returned: of those that met within their last 8 collisions; between: collisions of both between such two meetings";
        with_theory "value", "1", "Its value; theory is molecular chaos";
        note "replicas", "1", "Replicas";
    }
    .figure(
        Figure::curves("Contacts over molecular chaos", Axis::logarithmic("window_end", "end of the window"), Axis::linear("value", "value"))
            .panels(&["quantity"]),
    )
}

fn meetings_table() -> Table {
    table! {
        "meetings", "Shares of the collisions whose partners have met before, and that close a ring of collisions.";
        key "engine", "", "Engine";
        key "window_start", "time", "Start of the window";
        key "window_end", "time", "End of the window";
        key "collisions", "1", "Number of collisions n";
        estimate "between", "1", "Share of collisions whose partners have met within their last 8 collisions, with n collisions of both since";
        estimate "ring", "1", "Share of collisions that close a ring of n, this one and the first one included: the shortest way back to a collision from which both partners descend; n from 2 to 6";
        note "replicas", "1", "Replicas";
    }
    .figure(
        Figure::curves("Collisions between two meetings of a pair", Axis::linear("collisions", "collisions of both between"), Axis::logarithmic("between", "share of all collisions"))
            .panels(&["window_end"]),
    )
}

fn velocities_table() -> Table {
    table! {
        "pair_velocities", "Velocity correlations of pairs by distance, along the line of centres and across it.";
        key "engine", "", "Engine";
        key "window_start", "time", "Start of the window";
        key "window_end", "time", "End of the window";
        key "from", "1", "Start of the bin, over the contact distance";
        key "to", "1", "End of the bin";
        key "distance", "1", "Its middle";
        estimate "parallel", "1", "Product of the velocities along the line of centres over their mean square, relative to the mean velocity of the gas";
        estimate "perpendicular", "1", "The same across the line";
        estimate "parallel_flow", "1", "The same with partners shuffled within the local flow: what flow alone gives";
        estimate "perpendicular_flow", "1", "Across the line";
        note "replicas", "1", "Replicas";
    }
    .figure(
        Figure::curves("Velocity correlation of pairs across their line", Axis::linear("distance", "distance over the contact distance"), Axis::linear("perpendicular", "correlation"))
            .panels(&["window_end"]),
    )
}

/// Sums above and below the line of a ratio, of one replica.
type Pick<'a, T> = dyn Fn(&T) -> [f64; 2] + 'a;

/// A ratio of two sums, after `of`.
struct Quantity {
    name: String,
    sums: Box<Pick<'static, (Sums, f64)>>,
    of: fn(f64) -> f64,
    theory: Option<f64>,
}

impl Quantity {
    fn values(&self, all: &[(Sums, f64)]) -> Vec<Option<f64>> {
        pseudo(all, &*self.sums, self.of)
    }
}

/// Returns a ratio of sums over the replicas; `None` where nothing is known.
fn ratio<T>(all: &[T], sums: impl Fn(&T) -> [f64; 2]) -> Option<Estimate> {
    let found = over(pseudo(all, &sums, |ratio| ratio));
    found.value.map(|_| found)
}

/// A share of the collisions of known partners.
fn share(all: &[(Sums, f64)], of: impl Fn(&Sums) -> f64) -> Option<Estimate> {
    ratio(all, |(sums, _)| [of(sums), sums.named])
}

/// Pseudo-values of a function of a ratio of sums over the replicas; none where nothing is known.
fn pseudo<T>(all: &[T], sums: &Pick<'_, T>, of: fn(f64) -> f64) -> Vec<Option<f64>> {
    let each: Vec<[f64; 2]> = all
        .iter()
        .map(sums)
        .filter(|[_, below]| *below > 0.0)
        .collect();
    let values = of_sums(&each, |[above, below]| of(above / below));
    values.into_iter().map(Some).collect()
}

/// All quantities, in the order of the table.
fn quantities(plan: &Plan) -> Vec<Quantity> {
    fn as_is(ratio: f64) -> f64 {
        ratio
    }
    fn near(all: &Sums, axis: usize) -> [f64; 2] {
        let [one, _] = &all.velocities[0];
        [one.products[axis], one.squares[axis]]
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
        one("heat", None, as_is, |(all, _)| all.heat),
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
        one("parallel", zero, as_is, |(all, _)| near(all, 0)),
        one("perpendicular", zero, as_is, |(all, _)| near(all, 1)),
        one("again", zero, as_is, |(all, _)| [all.again, all.named]),
        one("returned", zero, as_is, |(all, _)| {
            [all.returned, all.named]
        }),
        one("between", None, as_is, |(all, _)| {
            let collisions = all.between.iter().enumerate();
            let sum = collisions.map(|(count, share)| count as f64 * share).sum();
            [sum, all.returned]
        }),
    ]);
    all
}
