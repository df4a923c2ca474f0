//! Measure `checks`: a gas without positions against kinetic theory, each quantity at the time of
//! its worst deviation.
//!
//! The rule is that of [`crate::judge`], all times and species of a quantity together.

use stosszahl_analysis::compare::Interval;
use stosszahl_results::{
    Table, TableCell, TableEstimate, VerdictKind, VerdictText, format_number, table,
};

use super::energy::{self, GasRow};
use super::gas_series::{GasSample, GasSeries};
use super::species_record::{self as record, SpeciesRecord};
use super::time_averaged_displacement as averaged;
use super::{mean_over_replicas, species};
use crate::judge::{
    DifferenceUnit, MeasuredPoint, VerdictRule, bound, interval_of, kind_of, verdict, warning,
    with_error, worst,
};
use crate::measure::{BadOption, Measure, NoOptions, ReplicaRecords, described};
use crate::plan::CasePlan;
use crate::theory::homogeneous;

/// Measure `checks` that compares a gas without positions with kinetic theory.
pub struct TheoryComparison;

const NAME: &str = "checks";

impl Measure for TheoryComparison {
    described!(
        NAME,
        "Comparisons of a gas without positions with theory, each at the time of its worst deviation.",
        NoOptions
    );

    fn by_default(&self, plan: &CasePlan) -> bool {
        !plan.has_box()
    }

    fn check_options(&self, plan: &CasePlan) -> Result<(), BadOption> {
        record::homogeneous_only(plan)?;
        self.read_options(plan)
    }

    fn result_tables(&self, plan: &CasePlan, runs: &ReplicaRecords<'_>) -> Vec<Table> {
        vec![table(plan, &Found::of(plan, runs).rows())]
    }

    fn test_count(&self, _plan: &CasePlan) -> usize {
        QUANTITIES.len()
    }

    fn result_verdicts(
        &self,
        plan: &CasePlan,
        runs: &ReplicaRecords<'_>,
        _tables: &[Table],
    ) -> Vec<VerdictText> {
        if let Err(error) = homogeneous::curves(plan) {
            let sentence = format!("There is no theory to compare with: {error}.");
            return vec![warning("theory", sentence)];
        }
        Found::of(plan, runs).verdicts()
    }
}

/// Fourth cumulant beyond which Sonine expansions are unreliable. They fail for tracers of -0.36
/// and beyond.
const STRANGE: f64 = 0.3;

/// Fewest particles of a species, all replicas together, for a comparison with theory. The mean of
/// `m v^2` of fewer is not normally distributed: of a hundred in space it has 300 degrees of
/// freedom, and its skewness is `sqrt(8/300) = 0.16`.
const FEWEST: usize = 100;

/// Collisions of a particle after which the Maxwellian start is forgotten. The fourth cumulant
/// relaxes within some five.
const FORGOTTEN: f64 = 15.0;

/// Smallest velocity correlation that is compared with theory; below it the relative error is too
/// large.
const LEAST_CORRELATION: f64 = 0.1;

/// Quantity that is compared with theory; the variants are in the order of the verdicts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Quantity {
    Energy,
    Temperature,
    Collisions,
    Cumulant,
    Displacement,
    Correlation,
    TimeAveraged,
    Decay,
}

/// Quantities that are compared with theory and their names in tables, in the order of the
/// verdicts.
const QUANTITIES: [(Quantity, &str); 8] = [
    (Quantity::Energy, "energy"),
    (Quantity::Temperature, "temperature"),
    (Quantity::Collisions, "collisions per particle"),
    (Quantity::Cumulant, "fourth cumulant"),
    (Quantity::Displacement, "mean squared displacement"),
    (Quantity::Correlation, "velocity correlation"),
    (Quantity::TimeAveraged, "time-averaged displacement"),
    (Quantity::Decay, "exponents of the decay"),
];

impl Quantity {
    fn name(self) -> &'static str {
        QUANTITIES[self as usize].1
    }

    /// Returns true if the theory of the quantity needs more than the temperatures of the species.
    fn needs_correlations(self) -> bool {
        matches!(
            self,
            Self::Displacement | Self::TimeAveraged | Self::Correlation
        )
    }

    /// Returns the name of the theory that the quantity is compared with.
    fn theory(self, orders: usize) -> String {
        let words = match self {
            _ if orders > 1 => return format!("the kinetic equations in {orders} Sonine orders"),
            Self::TimeAveraged => "the cooling state in first Sonine order",
            Self::Energy | Self::Temperature | Self::Collisions => {
                "the kinetic equations of Maxwellian species"
            }
            _ => "theory in first Sonine order",
        };
        words.to_owned()
    }
}

/// Row of the comparison with theory: one quantity of one species, at the time that decides the
/// verdict.
#[derive(Clone, Copy, Debug)]
struct Row {
    quantity: Quantity,
    /// Index of the species, from 0; `None` for the gas as a whole.
    species: Option<usize>,
    point: MeasuredPoint,
    interval: Interval,
    kind: VerdictKind,
}

impl Row {
    fn size(&self) -> f64 {
        bound(&self.interval, self.kind)
    }
}

/// Measured values and their theory, from which the rows of the comparison are made.
struct Found<'a> {
    plan: &'a CasePlan,
    all_series: Vec<&'a GasSeries>,
    gas: Vec<GasRow>,
    displacements: Vec<(f64, TableEstimate)>,
    species: Vec<species::SpeciesRow>,
    averaged: Vec<averaged::PathRow>,
    rule: VerdictRule,
    absolute_rule: VerdictRule,
}

impl<'a> Found<'a> {
    fn of(plan: &'a CasePlan, runs: &ReplicaRecords<'a>) -> Self {
        let records: Vec<&SpeciesRecord> = runs.records_of(0);
        let all_series: Vec<&GasSeries> = runs.records_of(0);
        let lasts = plan.case.aggregation.is_none();
        let species = lasts.then(|| species::homogeneous_rows(plan, &records));
        Self {
            plan,
            gas: energy::rows(plan, &plan.engines[0], &all_series),
            displacements: record::whole_displacements(plan, &records),
            species: species.unwrap_or_default(),
            averaged: averaged::rows(plan, &runs.records_of(0)),
            all_series,
            rule: runs.rule(plan),
            absolute_rule: runs.absolute_rule(plan),
        }
    }

    /// Returns all rows of the comparison, each at the time that decides its verdict.
    fn rows(&self) -> Vec<Row> {
        let mut rows: Vec<Row> = Vec::new();
        // A quantity is judged for each species, and some for the gas as a whole.
        let parts = (self.plan.gas.species.len() + 1) as f64;
        let rule = self.rule.at_level(self.rule.level / parts);
        let mut add = |quantity, species, points: Vec<MeasuredPoint>| {
            rows.extend(worst(&points, &rule).map(|(&point, interval, kind)| Row {
                quantity,
                species,
                point,
                interval,
                kind,
            }));
        };
        let whole = |of: fn(&GasRow) -> &TableEstimate| {
            let later = self.gas.iter().filter(|row| row.time > 0.0);
            later
                .filter_map(|row| MeasuredPoint::from_estimate(row.time, of(row)))
                .collect()
        };
        add(Quantity::Energy, None, whole(|row| &row.energy_ratio));
        add(Quantity::Collisions, None, whole(|row| &row.collisions));
        let displaced = self.displacements.iter().filter(|one| one.0 > 0.0);
        let displaced =
            displaced.filter_map(|(time, square)| MeasuredPoint::from_estimate(*time, square));
        add(Quantity::Displacement, None, displaced.collect());
        for (number, species) in self.plan.gas.species.iter().enumerate() {
            if species.count * self.all_series.len() < FEWEST {
                continue;
            }
            let own = |of: fn(&species::SpeciesRow) -> &TableEstimate| -> Vec<MeasuredPoint> {
                let rows = self
                    .species
                    .iter()
                    .filter(|row| row.species == number && row.time > 0.0);
                rows.filter_map(|row| MeasuredPoint::from_estimate(row.time, of(row)))
                    .collect()
            };
            let mut correlation = own(|row| &row.correlation);
            correlation.retain(|point| point.theory > LEAST_CORRELATION);
            let averaged = self.averaged.iter().filter(|row| row.species == number);
            let averaged =
                averaged.filter_map(|row| MeasuredPoint::from_estimate(row.lag, &row.displacement));
            let (species, displacement) = (Some(number), own(|row| &row.displacement));
            add(Quantity::Temperature, species, own(|row| &row.temperature));
            add(Quantity::Displacement, species, displacement);
            add(Quantity::Correlation, species, correlation);
            add(Quantity::TimeAveraged, species, averaged.collect());
        }
        // The cumulant is near zero, so that its margin is absolute.
        let cumulant = self.cumulant().map(|point| {
            let off = TableEstimate {
                replicas: point.replicas,
                ..TableEstimate::with_error(point.measured - point.theory, point.total_error())
            };
            let rule = &self.absolute_rule;
            let interval = interval_of(&off, rule.level);
            let kind = kind_of(interval.decide(rule));
            (Quantity::Cumulant, point, interval, kind)
        });
        let decay = self.decay().map(|point| {
            let interval = point.interval(self.rule.level);
            let kind = kind_of(interval.decide(&self.rule));
            (Quantity::Decay, point, interval, kind)
        });
        rows.extend([cumulant, decay].into_iter().flatten().map(
            |(quantity, point, interval, kind)| Row {
                quantity,
                species: None,
                point,
                interval,
                kind,
            },
        ));
        rows
    }

    /// Compares the fourth cumulant in the cooling state with the Sonine expansion at the end. The
    /// measured value is averaged over replicas and over the samples after the start is forgotten.
    fn cumulant(&self) -> Option<MeasuredPoint> {
        homogeneous::fourth_cumulants(self.plan)?;
        let last = self.species.last()?.fourth_cumulant;
        let particles = self.plan.count() as f64;
        let mut begin = f64::INFINITY;
        let means = self.all_series.iter().map(|series| {
            let late = series.iter();
            let late = late.filter(|one| 2.0 * one.collisions / particles > FORGOTTEN);
            let values: Vec<f64> = late
                .inspect(|sample| begin = begin.min(sample.time))
                .map(|sample| sample.total().fourth_cumulant(self.plan.gas.dimension))
                .collect();
            let count = values.len() as f64;
            (count > 0.0).then(|| values.iter().sum::<f64>() / count)
        });
        let found = TableEstimate {
            theory: last.theory,
            theory_error: last.theory_error,
            ..mean_over_replicas(means)
        };
        let point = MeasuredPoint::from_estimate(begin, &found)?;
        (point.theory != 0.0 && point.deviation().is_finite()).then_some(point)
    }

    /// Compares `2 xi/D + theta` of a gas in which all pairs stick with 2, over the last factor of
    /// ten of time. The number of clusters decays as `t^-xi` and the energy as `t^-theta`: Trizac &
    /// Krapivsky, Phys. Rev. Lett. 91, 218302 (2003).
    ///
    /// The rate of collisions is `n R^(D-1) v`; with the sizes `R^D ~ 1/n` and `v^2 ~ E` (mass is
    /// conserved) it is the rate `1/t` at which n decays if `xi/D + theta/2 = 1`.
    fn decay(&self) -> Option<MeasuredPoint> {
        let sticking = self.plan.case.aggregation.as_ref()?;
        if sticking.may_bounce() {
            return None;
        }
        let until = self.plan.case.run.until;
        let sum = |samples: &&GasSeries| {
            let last = samples.last()?;
            let first = samples.iter().rev().find(|s| s.time <= 0.1001 * until)?;
            let decades = (last.time / first.time).ln();
            let exponent = |a: f64, b: f64| (a / b).ln() / decades;
            let [start, end] = [first, last].map(GasSample::total);
            let number = exponent(start.number, end.number);
            let energy = exponent(start.translation, end.translation);
            (first.time > 0.0).then_some(2.0 * number / self.plan.gas.dimension as f64 + energy)
        };
        MeasuredPoint::from_estimate(
            until,
            &mean_over_replicas(self.all_series.iter().map(sum)).against(Some(2.0)),
        )
    }

    /// Decides the verdicts of all comparisons with theory.
    fn verdicts(&self) -> Vec<VerdictText> {
        let rows = self.rows();
        let orders = homogeneous::curves(self.plan).map_or(1, |curves| curves.orders);
        let of = |(quantity, name)| {
            let own: Vec<&Row> = rows.iter().filter(|row| row.quantity == quantity).collect();
            let (sentence, kind) = self.sentence(quantity, &own, orders)?;
            Some(verdict(name, sentence, kind))
        };
        QUANTITIES.into_iter().filter_map(of).collect()
    }

    fn sentence(
        &self,
        quantity: Quantity,
        rows: &[&Row],
        orders: usize,
    ) -> Option<(String, VerdictKind)> {
        let largest = |kind: Option<VerdictKind>| {
            let some = rows
                .iter()
                .filter(|row| kind.is_none_or(|kind| row.kind == kind));
            some.max_by(|a, b| a.size().total_cmp(&b.size()))
        };
        let with = |kind| rows.iter().filter(|row| row.kind == kind).count();
        let (differ, agree) = (with(VerdictKind::Differ), with(VerdictKind::Agree));
        let all = largest(None)?;
        let theory = quantity.theory(orders);
        let tolerance = format_number(100.0 * self.plan.case.verdict.tolerance);
        let measured = with_error(all.point.measured, all.point.error);
        let place = |kind| Some(self.deviation_text(largest(kind)?));
        Some(match quantity {
            Quantity::Cumulant => {
                let [simplest, _] = homogeneous::fourth_cumulants(self.plan)?;
                let (time, theirs) = (
                    format_number(all.point.time),
                    with_error(all.point.theory, all.point.theory_error),
                );
                let sentence = format!(
                    "From t = {time} on the fourth cumulant is {measured}; {theory} have {theirs}, the simplest formula (van Noije & \
                     Ernst) {simplest:.4}; the margin is {}.",
                    format_number(self.absolute_rule.margin)
                );
                (sentence, all.kind)
            }
            Quantity::Decay => {
                let sentence = format!(
                    "Over the last factor of ten of time, 2 xi/D + theta = {measured} against 2, xi of the number and theta of the \
                     energy; the margin is {tolerance} %."
                );
                (sentence, all.kind)
            }
            _ if differ > 0 => {
                let more = match differ - 1 {
                    0 => String::new(),
                    more => format!(", and {more} more differ"),
                };
                let (place, caveat) = (
                    place(Some(VerdictKind::Differ))?,
                    self.caveat(quantity, rows, orders),
                );
                let sentence = format!(
                    "Against {theory}, the deviation that is surest not zero is {place}{more}; the margin is {tolerance} %.{caveat}"
                );
                (sentence, VerdictKind::Differ)
            }
            _ if agree == rows.len() => {
                let place = place(Some(VerdictKind::Agree))?;
                let sentence = format!(
                    "Against {theory}, deviations are within {tolerance} %, errors included; the widest is {place}."
                );
                (sentence, VerdictKind::Agree)
            }
            _ => {
                let place = self.deviation_text(all);
                let sentence = format!(
                    "Against {theory}, errors, or what one order more changes, are unknown or wider than {tolerance} %; the \
                     largest deviation is {place}."
                );
                (sentence, VerdictKind::Undecided)
            }
        })
    }

    /// Returns a sentence on the known limits of the theory of a quantity.
    fn caveat(&self, quantity: Quantity, rows: &[&Row], orders: usize) -> &'static str {
        let masses = || self.plan.gas.species.iter().map(|one| one.mass);
        let lightest = masses().fold(f64::INFINITY, f64::min);
        let disparate = masses().fold(0.0, f64::max) > 4.0 * lightest;
        let differs = |number| {
            let mut rows = rows.iter();
            rows.any(|row| row.kind == VerdictKind::Differ && row.species == Some(number))
        };
        let strange = || {
            self.species.iter().any(|row| {
                let value = row.fourth_cumulant.value.unwrap_or(0.0);
                let many = self.plan.gas.species[row.species].count > 100;
                many && value.abs() > STRANGE && differs(row.species)
            })
        };
        if orders > 1 {
            return if strange() {
                " Velocities there are too far from Maxwellian for an expansion to converge; its error is more than what one \
                 order less changes."
            } else {
                ""
            };
        }
        match quantity.needs_correlations() {
            true if disparate => {
                " First Sonine order takes velocities for Maxwellian and their correlations for exponential, and is off by up \
                 to 15 % for light particles among heavy ones, by more for heavy ones among very many light ones."
            }
            true => {
                " First Sonine order takes velocities for Maxwellian and their correlations for exponential."
            }
            false if disparate => {
                " The equations take all velocities for Maxwellian; fourth cumulants show how far they are from it."
            }
            false => "",
        }
    }

    /// Formats the deviation from theory in a row, with its species and time.
    fn deviation_text(&self, row: &Row) -> String {
        // How far the velocities are from those that theory assumes.
        let before = |known: &&species::SpeciesRow| {
            Some(known.species) == row.species && known.time <= row.point.time
        };
        let cumulant = self.species.iter().rfind(before);
        let cumulant = cumulant.and_then(|known| known.fourth_cumulant.value);
        let cumulant = cumulant.map_or(String::new(), |a2| {
            format!(", where the fourth cumulant is {a2:.3}")
        });
        let species = match row.species {
            Some(number) if self.plan.gas.species.len() > 1 => {
                let species = &self.plan.gas.species[number];
                format!(
                    "species {} (mass {})",
                    species.name,
                    format_number(species.mass)
                )
            }
            _ => "the gas as a whole".to_owned(),
        };
        format!(
            "{} for {species} at t = {}{cumulant}",
            DifferenceUnit::Relative.interval(&row.interval),
            format_number(row.point.time)
        )
    }
}

fn table(plan: &CasePlan, rows: &[Row]) -> Table {
    let mut table = table! {
        NAME, "Each comparison with theory at its worst time";
        key "quantity", "", "What is compared";
        key "species", "1", "Number of the species, from 1; empty for the gas as a whole";
        key "species_name", "", "Its name; empty for the gas as a whole";
        note "time", "unit of time", "Time of the largest deviation that is not chance, or else of the largest one";
        value "measured", "of the quantity", "Measured";
        note "measured_se", "", "Its standard error";
        note "theory", "", "By theory";
        note "theory_error", "", "Its error: the change from one Sonine order less";
        note "deviation_percent", "percent", "Measured over theory, less one";
        note "z", "1", "Deviation in standard errors, that of theory included";
        note "verdict", "", "agree, differ or undecided";
    };
    for row in rows {
        let point = &row.point;
        let species = row.species.map_or(TableCell::Empty, |number| {
            TableCell::Count(number as u64 + 1)
        });
        let name = row
            .species
            .map_or("", |number| &*plan.gas.species[number].name);
        let measured = (point.time, point.measured, point.error);
        let theory = (point.theory, point.theory_error);
        let off = (100.0 * point.deviation(), point.z());
        table.add((
            row.quantity.name(),
            (species, name),
            measured,
            theory,
            off,
            row.kind.name(),
        ));
    }
    table
}
