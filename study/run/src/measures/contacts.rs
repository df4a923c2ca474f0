//! Measure `contacts`: velocities and impact parameters of colliding pairs, against molecular chaos
//! at the local granular temperature.

mod contact_values;
mod elastic_twin;

use serde::{Deserialize, Serialize};
use stosszahl_analysis::contact_value::{ContactFlux, FluxWindow};
use stosszahl_analysis::contacts::{
    Acquaintance, BYTES_PER_SIMULATOR, ContactObserver, ContactSums, DISTANCES, EDGES,
    LONGEST_RING, MOST_BETWEEN, NEAR, ORDERS,
};
use stosszahl_analysis::replicas::of_sums;
use stosszahl_model::{Collision, Interrupt, Observer, ParticleSpec, Particles};
use stosszahl_results::{
    Figure, FigureAxis, Table, TableEstimate, VerdictText, format_number, table,
};

use self::elastic_twin::{ElasticTwin, SavedTwin, TwinWindow, has_twin};
use super::impact_parameters::{Spans, spans};
use super::mean_over_replicas;
use crate::judge::{self, title};
use crate::measure::{
    self, BadOption, Measure, Probe, ReplicaRecords, RunStop, SampleContext, described,
};
use crate::plan::{CasePlan, EnginePlan};

/// Measure `contacts` of the statistics of colliding pairs.
pub struct ContactMeasure;

/// Options of `[measure.contacts]`: time windows, and the elastic twin.
#[derive(Clone, Debug, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct ContactOptions {
    /// Time windows \[start, end\], or "whole-run" for one. Default: those of the impact
    /// parameters.
    pub windows: Option<Spans>,
    /// Whether exact disks that lose energy have an elastic twin: the same start with restitution
    /// 1, up to the same number of collisions per particle. It takes as long as they do, and gives
    /// the columns that end in `_elastic`.
    pub elastic_twin: bool,
}

impl Default for ContactOptions {
    fn default() -> Self {
        Self {
            windows: None,
            elastic_twin: true,
        }
    }
}

/// Sums over collisions and over pairs near contact, in time windows: contact statistics and flux.
#[derive(Clone, Serialize, Deserialize)]
struct WindowSums {
    contacts: ContactObserver,
    flux: ContactFlux,
}

impl WindowSums {
    fn new(spans: &[[f64; 2]], particles: &Particles, temperature: f64) -> Self {
        let contacts = ContactObserver::new(spans, particles);
        let (dimension, number) = (particles.dimension, contacts.particles());
        let flux = ContactFlux::new(spans, dimension, number, particles.time, temperature);
        Self { contacts, flux }
    }

    fn synchronise(&mut self, time: f64, temperature: f64) {
        self.contacts.synchronise(temperature);
        self.flux.synchronise(time, temperature);
    }
}

impl Observer for WindowSums {
    fn on_collisions(&mut self, batch: &[Collision]) {
        self.contacts.on_collisions(batch);
        self.flux.on_collisions(batch);
    }
}

/// Contact sums of one engine and replica, and of its elastic twin: a companion simulation of exact
/// disks from the same start that loses no energy.
#[derive(Serialize, Deserialize)]
struct Observed {
    own: WindowSums,
    /// Number of collisions of the engine so far.
    collisions: u64,
    /// Time of the last sample of the gas \[time\].
    sampled: f64,
    /// Contact sums of the elastic twin in each time window; empty without a twin.
    elastic: Vec<TwinWindow>,
    /// Error message of the elastic twin, if it could not start or failed; else `None`.
    failure: Option<String>,
}

impl Observer for Observed {
    fn on_collisions(&mut self, batch: &[Collision]) {
        self.collisions += batch.len() as u64;
        self.own.on_collisions(batch);
    }
}

impl Observed {
    /// Adds sums of the elastic twin to every window that contains a whole time interval, or an
    /// instant \[time\].
    fn add_elastic(&mut self, [start, end]: [f64; 2], (sums, flux): &TwinWindow) {
        for ((all, all_flux), (span, _)) in self.elastic.iter_mut().zip(&self.own.contacts.windows)
        {
            let inside = start >= span[0] && end <= span[1] && start < span[1];
            if inside {
                all.merge(sums);
                all_flux.merge(flux);
            }
        }
    }

    /// Advances the elastic twin to the number of collisions that the gas has had, and adds its
    /// sums since the last sample.
    fn follow(
        &mut self,
        twin: &mut ElasticTwin,
        time: f64,
        stop: &Interrupt,
    ) -> Result<(), stosszahl_model::Failure> {
        twin.follow(self.collisions, stop)?;
        if !stop.is_raised() {
            self.add_elastic([self.sampled, time], &twin.take_sums());
            twin.sample_twin();
            self.add_elastic([time; 2], &twin.take_sums());
        }
        Ok(())
    }
}

/// Contact sums of one engine and replica; `None` before the start.
type Record = Option<Observed>;

struct ContactProbe {
    spans: Vec<[f64; 2]>,
    record: Record,
    /// Elastic twin's input: particles, their number, and their theoretical collisions per time at
    /// temperature 1. `None` without a twin.
    grains: Option<(ParticleSpec, usize, f64)>,
    twin: Option<ElasticTwin>,
}

impl Probe for ContactProbe {
    fn collision_observer(&mut self) -> Option<&mut dyn Observer> {
        self.record
            .as_mut()
            .map(|record| record as &mut dyn Observer)
    }

    fn on_start(&mut self, moment: &mut SampleContext<'_>) {
        let time = moment.simulation.time();
        let (particles, temperature) = (moment.particles(), moment.temperature());
        let mut own = WindowSums::new(&self.spans, particles, temperature);
        own.contacts.sample_gas(time, particles);
        let record = self.record.insert(Observed {
            own,
            collisions: 0,
            sampled: time,
            elastic: Vec::new(),
            failure: None,
        });
        if let Some((grains, _, expected)) = &self.grains {
            match ElasticTwin::new(grains, particles, *expected) {
                Ok(twin) => {
                    let window = |&span| (ContactSums::default(), FluxWindow::new(span));
                    record.elastic = self.spans.iter().map(window).collect();
                    let twin = self.twin.insert(twin);
                    record.add_elastic([time; 2], &twin.take_sums());
                }
                Err(error) => record.failure = Some(error.to_string()),
            }
        }
    }

    fn on_stop(&mut self, stop: &RunStop) {
        if let Some(record) = &mut self.record {
            record.own.synchronise(stop.time, stop.temperature);
        }
    }

    fn on_sample(&mut self, moment: &mut SampleContext<'_>) {
        let time = moment.simulation.time();
        let Some(record) = &mut self.record else {
            return;
        };
        record.own.contacts.sample_gas(time, moment.particles());
        if let Some(twin) = &mut self.twin
            && let Err(failure) = record.follow(twin, time, &moment.interrupt)
        {
            record.failure = Some(failure.to_string());
            self.twin = None;
        }
        record.sampled = time;
        // The twin is not needed after the last window.
        if self.spans.iter().all(|span| span[1] <= time) {
            self.twin = None;
        }
    }

    fn save_record(&self) -> Result<Vec<u8>, postcard::Error> {
        let twin = self.twin.as_ref().map(ElasticTwin::save).transpose();
        let twin = twin.map_err(|_| postcard::Error::SerdeSerCustom)?;
        postcard::to_stdvec(&(&self.record, twin))
    }

    fn load_record(&mut self, bytes: &[u8]) -> Result<(), postcard::Error> {
        let (record, twin): (Record, Option<SavedTwin>) = postcard::from_bytes(bytes)?;
        self.record = record;
        let resumed = twin
            .zip(self.grains.as_ref())
            .map(|(saved, (grains, count, _))| ElasticTwin::load(grains, *count, saved));
        let twin = resumed.transpose();
        self.twin = twin.map_err(|_| postcard::Error::SerdeDeCustom)?;
        Ok(())
    }

    fn record(&self) -> &dyn std::any::Any {
        &self.record
    }
}

impl ContactMeasure {
    fn spans(&self, plan: &CasePlan) -> Vec<[f64; 2]> {
        let options: ContactOptions = measure::chosen(plan, self.name());
        spans(plan, options.windows)
    }

    fn with_twin(&self, plan: &CasePlan, engine: &EnginePlan) -> bool {
        let options: ContactOptions = measure::chosen(plan, self.name());
        options.elastic_twin && has_twin(plan, engine)
    }
}

impl Measure for ContactMeasure {
    described!(
        "contacts",
        "Speeds, impact parameters and repeated collisions at contact, against molecular chaos at the local temperature.",
        ContactOptions
    );

    fn check_options(&self, plan: &CasePlan) -> Result<(), BadOption> {
        measure::require(
            plan.has_box(),
            "",
            "a gas in a box; this one has no positions",
        )?;
        let ContactOptions { windows, .. } = measure::options(plan, self.name())?;
        super::impact_parameters::check_windows(windows.as_ref())
    }

    /// Returns the sample times: edges of the time windows, and some times in each window for the
    /// local temperature.
    fn sample_times(&self, plan: &CasePlan) -> Vec<f64> {
        let mut times = plan.sample_times();
        times.extend(self.spans(plan).into_flattened());
        times.retain(|&time| time > 0.0);
        times
    }

    fn gathers_particles(&self, _plan: &CasePlan) -> bool {
        true
    }

    fn kept_per_particle(&self, plan: &CasePlan) -> f64 {
        let own = BYTES_PER_SIMULATOR as f64;
        let mut engines = plan.engines.iter();
        if engines.any(|engine| self.with_twin(plan, engine)) {
            2.0 * own + elastic_twin::BYTES_PER_DISK
        } else {
            own
        }
    }

    /// Returns the share of the run up to the end of the last time window, in which the elastic
    /// twin has as many collisions as the gas.
    fn companion_share(&self, plan: &CasePlan, engine: &EnginePlan) -> f64 {
        if self.with_twin(plan, engine) {
            let ends = self.spans(plan).into_iter().map(|[_, end]| end);
            plan.done_share(ends.fold(0.0, f64::max))
        } else {
            0.0
        }
    }

    fn new_probe(&self, plan: &CasePlan, engine: &EnginePlan) -> Box<dyn Probe> {
        let spans = self.spans(plan).into_iter();
        let spans = spans.map(|span| span.map(|edge| plan.engine_time(edge)));
        let with_twin = self.with_twin(plan, engine);
        Box::new(ContactProbe {
            spans: spans.collect(),
            record: None,
            grains: with_twin.then(|| {
                let count = plan.count();
                let expected = 0.5 * count as f64 * plan.collision_rate();
                (plan.gas.particles.clone(), count, expected)
            }),
            twin: None,
        })
    }

    fn result_tables(&self, plan: &CasePlan, runs: &ReplicaRecords<'_>) -> Vec<Table> {
        let mut tables = [chaos_table(), meetings_table(), velocities_table()];
        let [chaos, meetings, velocities] = &mut tables;
        for (engine, records) in runs.each::<Record>(plan) {
            for (number, &span) in self.spans(plan).iter().enumerate() {
                let [sums, elastic] = [sums(&records, number), elastic(&records, number)];
                for quantity in quantities(plan) {
                    let found = mean_over_replicas(quantity.values(&sums)).against(quantity.theory);
                    let twin = mean_over_replicas(quantity.values(&elastic));
                    if found.value.is_some() {
                        let key = (engine.name, span, &*quantity.name);
                        chaos.add((key, found, twin, sums.len()));
                    }
                }
                if sums.iter().all(|(sums, _)| sums.named == 0.0) {
                    continue;
                }
                for length in 0..=MOST_BETWEEN {
                    let between = [&sums, &elastic].map(|sums| {
                        collision_share(sums, move |sums| sums.between[length]).unwrap_or_default()
                    });
                    let known = (2..=LONGEST_RING).contains(&length);
                    let ring = [&sums, &elastic].map(|sums| {
                        let ring = |sums: &ContactSums| sums.rings[length.min(LONGEST_RING)];
                        collision_share(sums, ring)
                            .filter(|_| known)
                            .unwrap_or_default()
                    });
                    meetings.add((engine.name, span, length, between, ring, sums.len()));
                }
                for bin in 0..DISTANCES {
                    let correlation =
                        |sums: &[(ContactSums, f64)], (kind, axis): (usize, usize)| {
                            ratio(sums, move |(sums, _)| {
                                let one = &sums.velocities[bin][kind];
                                [one.products[axis], one.squares[axis]]
                            })
                        };
                    let found = [(0, 0), (0, 1), (1, 0), (1, 1)];
                    if let [Some(a), Some(b), Some(c), Some(d)] =
                        found.map(|one| correlation(&sums, one))
                    {
                        let distance = 0.5 * (EDGES[bin] + EDGES[bin + 1]);
                        let edges = (EDGES[bin], EDGES[bin + 1], distance);
                        let twin = [(0, 0), (0, 1)]
                            .map(|one| correlation(&elastic, one).unwrap_or_default());
                        let values = ([a, b, c, d], twin);
                        velocities.add((engine.name, span, edges, values, sums.len()));
                    }
                }
            }
        }
        let [chaos, meetings, velocities] = tables;
        let values = contact_values::table(plan, runs, &self.spans(plan));
        vec![chaos, values, meetings, velocities]
    }

    /// Creates notes on pairs near contact and on recollisions in the last time window, and a
    /// warning if an elastic twin failed.
    fn result_verdicts(
        &self,
        plan: &CasePlan,
        runs: &ReplicaRecords<'_>,
        _tables: &[Table],
    ) -> Vec<VerdictText> {
        let all = self.spans(plan);
        let Some(number) = all.len().checked_sub(1) else {
            return Vec::new();
        };
        let [start, end] = all[number].map(format_number);
        let known = quantities(plan);
        let told = |wanted: &str, sums: &[(ContactSums, f64)]| {
            let quantity = known.iter().find(|one| one.name == wanted)?;
            let found = mean_over_replicas(quantity.values(sums));
            found.value.map(|_| judge::in_units(&found, 1.0))
        };
        let near = |(engine, records): (&EnginePlan, &[&Record])| {
            let (sums, name) = (sums(records, number), title(engine.name));
            let sentence = format!(
                "{name}, t = {start} to {end}: the slope of P(b/d) of pairs that approach within {NEAR} d is {}; with partners \
                 shuffled within the local flow, {}.",
                told("slope_near", &sums)?,
                told("slope_shuffled", &sums)?
            );
            Some(judge::verdict_note(
                format!("pairs near contact, {name}"),
                sentence,
            ))
        };
        let meetings = |(engine, records): (&EnginePlan, &[&Record])| {
            let (own, twin) = (sums(records, number), elastic(records, number));
            let name = title(engine.name);
            let sentence = format!(
                "{name}, t = {start} to {end}: {} of the collisions are of partners that met within their last 8 collisions, and {} \
                 in an elastic gas from the same start. The slope of P(b/d) of these is {}, elastic {}; of partners that have not met \
                 {}, elastic {}.",
                told("returned", &own)?,
                told("returned", &twin)?,
                told("slope_returned", &own)?,
                told("slope_returned", &twin)?,
                told("slope_new", &own)?,
                told("slope_new", &twin)?
            );
            Some(judge::verdict_note(
                format!("partners that meet again, {name}"),
                sentence,
            ))
        };
        let failed = |(engine, records): (&EnginePlan, &[&Record])| {
            let mut known = records.iter().filter_map(|record| record.as_ref());
            let failure = known.find_map(|one| one.failure.as_ref())?;
            let name = title(engine.name);
            let sentence = format!("The elastic twin of {name} stopped early: {failure}.");
            Some(judge::warning(format!("elastic twin, {name}"), sentence))
        };
        let all: Vec<_> = runs.each::<Record>(plan).collect();
        let each = || all.iter().map(|(engine, records)| (*engine, &records[..]));
        let notes = each().filter_map(near).chain(each().filter_map(meetings));
        notes.chain(each().filter_map(failed)).collect()
    }
}

/// Returns the contact sums of one time window in every replica, each with the number of particles.
fn sums(records: &[&Record], number: usize) -> Vec<(ContactSums, f64)> {
    let known = records.iter().filter_map(|record| record.as_ref());
    let one = |one: &Observed| {
        let contacts = &one.own.contacts;
        (contacts.windows[number].1, contacts.particles())
    };
    known.map(one).collect()
}

/// Returns the contact sums of the elastic twins for one time window in every replica, each with
/// the number of particles.
fn elastic(records: &[&Record], number: usize) -> Vec<(ContactSums, f64)> {
    let known = records.iter().filter_map(|record| record.as_ref());
    let one = |one: &Observed| {
        let window = one.elastic.get(number)?;
        Some((window.0, one.own.contacts.particles()))
    };
    known.filter_map(one).collect()
}

fn chaos_table() -> Table {
    table! {
        "chaos", "What happens at contact, against molecular chaos at the local granular temperature.";
        key "engine", "", "Engine";
        key "window_start", "time", "Start of the window";
        key "window_end", "time", "End of the window";
        key "quantity", "", "before_p, after_p: moment <g^p> of the normal speed before and after contact over that of chaos before it; collisions: of a particle in the window; heat: local temperature over that of the whole gas, flow included; slope_slow, slope_fast: slope of P(b/d) of pairs below and above the mean squared speed; slope_near, slope_shuffled: of approaching pairs within 1.1 d, as they are and with partners shuffled within the local flow; parallel, perpendicular: velocity correlation of pairs within 1.1 d, flow included; again: share of collisions of partners that have met no other particle since they met; returned: of those that met within their last 8 collisions; between: collisions of both between such two meetings; slope_again, slope_returned, slope_new: slope of P(b/d) of these and of partners that have not met; speed_again, speed_returned, speed_new: mean squared normal speed of them before contact over that of chaos";
        with_theory "value", "1", "Its value; theory is molecular chaos in the Boltzmann-Grad limit, of packing 0, in which partners never meet again";
        estimate "value_elastic", "1", "The same of the elastic twin: exact disks of the same start with restitution 1, at as many collisions per particle";
        note "replicas", "1", "Replicas";
    }
    .figure(
        Figure::curves("Contacts over molecular chaos", FigureAxis::logarithmic("window_end", "end of the window"), FigureAxis::linear("value", "value"))
            .panels(&["quantity"])
            .caption("The dashed line is molecular chaos in the Boltzmann-Grad limit. An elastic gas at this packing is in the columns value_elastic."),
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
        estimate "between_elastic", "1", "The same of the elastic twin";
        estimate "ring", "1", "Share of collisions that close a ring of n, this one and the first one included: the shortest way back to a collision from which both partners descend; n from 2 to 6";
        estimate "ring_elastic", "1", "The same of the elastic twin";
        note "replicas", "1", "Replicas";
    }
    .figure(
        Figure::curves("Collisions between two meetings of a pair", FigureAxis::linear("collisions", "collisions of both between"), FigureAxis::logarithmic("between", "share of all collisions"))
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
        estimate "parallel_elastic", "1", "Along the line, of the elastic twin";
        estimate "perpendicular_elastic", "1", "Across the line, of the elastic twin";
        note "replicas", "1", "Replicas";
    }
    .figure(
        Figure::curves("Velocity correlation of pairs across their line", FigureAxis::linear("distance", "distance over the contact distance"), FigureAxis::linear("perpendicular", "correlation"))
            .panels(&["window_end"]),
    )
}

/// Function from the sums of one replica to numerator and denominator of a ratio.
type Pick<'a, T> = dyn Fn(&T) -> [f64; 2] + 'a;

/// Column of the table of contacts: the function `of` applied to a ratio of two sums.
struct Quantity {
    name: String,
    sums: Box<Pick<'static, (ContactSums, f64)>>,
    of: fn(f64) -> f64,
    theory: Option<f64>,
}

impl Quantity {
    fn values(&self, all: &[(ContactSums, f64)]) -> Vec<Option<f64>> {
        ratio_pseudo_values(all, &*self.sums, self.of)
    }
}

/// Estimates a ratio of sums over the replicas, with its jackknife error; `None` without data.
fn ratio<T>(all: &[T], sums: impl Fn(&T) -> [f64; 2]) -> Option<TableEstimate> {
    let found = mean_over_replicas(ratio_pseudo_values(all, &sums, |ratio| ratio));
    found.value.map(|_| found)
}

/// Estimates a share of those collisions whose partners are known by their index.
fn collision_share(
    all: &[(ContactSums, f64)],
    of: impl Fn(&ContactSums) -> f64,
) -> Option<TableEstimate> {
    ratio(all, |(sums, _)| [of(sums), sums.named])
}

/// Computes jackknife pseudo-values, one for each replica with data, of a function of a ratio of
/// sums over the replicas.
fn ratio_pseudo_values<T>(all: &[T], sums: &Pick<'_, T>, of: fn(f64) -> f64) -> Vec<Option<f64>> {
    let each: Vec<[f64; 2]> = all
        .iter()
        .map(sums)
        .filter(|[_, below]| *below > 0.0)
        .collect();
    let values = of_sums(&each, |[above, below]| of(above / below));
    values.into_iter().map(Some).collect()
}

/// Returns the quantities of the table of contacts, in the order of its columns.
fn quantities(plan: &CasePlan) -> Vec<Quantity> {
    fn as_is(ratio: f64) -> f64 {
        ratio
    }
    fn near(all: &ContactSums, axis: usize) -> [f64; 2] {
        let [one, _] = &all.velocities[0];
        [one.products[axis], one.squares[axis]]
    }
    fn met(all: &ContactSums, which: Acquaintance) -> [f64; 2] {
        let one = &all.met[which as usize];
        [one.impacts, one.count]
    }
    fn speeds(all: &ContactSums, which: Acquaintance) -> [f64; 2] {
        let one = &all.met[which as usize];
        [one.squares, one.chaos]
    }
    fn slope(mean: f64) -> f64 {
        12.0 * (mean - 0.5)
    }
    let one = |name: &str, theory, of, sums: fn(&(ContactSums, f64)) -> [f64; 2]| Quantity {
        name: name.to_owned(),
        sums: Box::new(sums),
        of,
        theory,
    };
    let mut all = vec![one("collisions", None, as_is, |(sums, particles)| {
        [2.0 * sums.physical, *particles]
    })];
    for (index, order) in ORDERS.into_iter().enumerate() {
        let restitution = plan.gas.law.constant();
        let moment = |name: &str, theory, sums: fn(&ContactSums, usize) -> f64| Quantity {
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
        one("slope_again", None, slope, |(all, _)| {
            met(all, Acquaintance::Again)
        }),
        one("slope_returned", None, slope, |(all, _)| {
            met(all, Acquaintance::Returned)
        }),
        one("slope_new", None, slope, |(all, _)| {
            met(all, Acquaintance::New)
        }),
        one("speed_again", None, as_is, |(all, _)| {
            speeds(all, Acquaintance::Again)
        }),
        one("speed_returned", None, as_is, |(all, _)| {
            speeds(all, Acquaintance::Returned)
        }),
        one("speed_new", None, as_is, |(all, _)| {
            speeds(all, Acquaintance::New)
        }),
        one("between", None, as_is, |(all, _)| {
            let collisions = all.between.iter().enumerate();
            let sum = collisions.map(|(count, share)| count as f64 * share).sum();
            [sum, all.returned]
        }),
    ]);
    all
}
