//! Measurements against theory: rows of a table, and the verdict in words.
//!
//! A deviation counts as a difference if it is larger than the tolerance of the case *and* than three standard errors. It
//! counts as agreement if it is within the tolerance and its standard error is too. All else is undecided: the error is
//! unknown, or too wide to tell.

use stosszahl_analysis::statistics::Estimate;

use super::export::Tables;
use super::plan::Plan;
use super::run::Finished;
use super::steady;
use super::tables::{CheckRow, ClusterRow, SpeciesRow};
use crate::manifest::{Verdict, VerdictKind};
use crate::verdicts::with_error;

/// Standard errors from which a deviation is no chance.
const SIGNIFICANT: f64 = 3.0;

/// Fourth cumulant beyond which Sonine expansions are not to be trusted: tracers of -0.36 and more are where they fail.
const STRANGE: f64 = 0.3;

/// Particles of a species, all replicas together, from which it is compared. The mean of `m v^2` of fewer is not normally
/// distributed: of a hundred in space it has 300 degrees of freedom, and its skewness is `sqrt(8/300) = 0.16`.
const FEWEST: usize = 100;

/// Quantities that are compared, with their theory in words.
const ENERGY: &str = "energy";
const COLLISIONS: &str = "collisions per particle";
const TEMPERATURE: &str = "temperature";
const DISPLACEMENT: &str = "mean squared displacement";
const CORRELATION: &str = "velocity correlation";
const TIME_AVERAGED: &str = "time-averaged displacement";
const CUMULANT: &str = "fourth cumulant";
const DECAY: &str = "exponents of the decay";

/// A measured value at one time and what theory says of it.
#[derive(Clone, Copy, Debug)]
struct Point {
    time: f64,
    measured: f64,
    error: Option<f64>,
    theory: f64,
    /// Change of the theory from one order less.
    theory_error: Option<f64>,
}

impl Point {
    fn deviation(&self) -> f64 {
        self.measured / self.theory - 1.0
    }

    /// Deviation in standard errors, to which what is unknown of the theory adds up.
    fn z(&self) -> Option<f64> {
        let error = self.error.filter(|&error| error > 0.0)?;
        let total = error.hypot(self.theory_error.unwrap_or(0.0));
        Some((self.measured - self.theory) / total)
    }

    /// Outcome for a tolerance.
    fn outcome(&self, tolerance: f64) -> VerdictKind {
        let Some(error) = self.error else {
            return VerdictKind::Undecided;
        };
        let far = self.deviation().abs() > tolerance;
        let significant = self.z().is_none_or(|z| z.abs() > SIGNIFICANT);
        let narrow = error.max(self.theory_error.unwrap_or(0.0)) <= tolerance * self.theory.abs();
        match (far, significant, narrow) {
            (true, true, _) => VerdictKind::Differ,
            (false, _, true) => VerdictKind::Agree,
            _ => VerdictKind::Undecided,
        }
    }
}

fn name(kind: VerdictKind) -> &'static str {
    match kind {
        VerdictKind::Agree => "agree",
        VerdictKind::Differ => "differ",
        VerdictKind::Undecided | VerdictKind::Warning => "undecided",
    }
}

/// The row of one quantity of one species: what all its times say together, told at the worst of them.
fn row(
    quantity: &str,
    species: Option<u64>,
    points: impl Iterator<Item = Point>,
    tolerance: f64,
) -> Option<CheckRow> {
    let points: Vec<Point> = points
        .filter(|point| point.theory != 0.0 && point.deviation().is_finite())
        .collect();
    let rank = |kind| match kind {
        VerdictKind::Differ => 2,
        VerdictKind::Undecided | VerdictKind::Warning => 1,
        VerdictKind::Agree => 0,
    };
    let worst = points.iter().max_by(|a, b| {
        let key = |point: &Point| (rank(point.outcome(tolerance)), point.deviation().abs());
        let (a, b) = (key(a), key(b));
        a.0.cmp(&b.0).then(a.1.total_cmp(&b.1))
    })?;
    Some(CheckRow {
        quantity: quantity.to_owned(),
        species,
        time: worst.time,
        measured: worst.measured,
        measured_se: worst.error,
        theory: worst.theory,
        theory_error: worst.theory_error,
        deviation_percent: 100.0 * worst.deviation(),
        z: worst.z(),
        verdict: name(worst.outcome(tolerance)).to_owned(),
    })
}

/// All comparisons of a case.
pub(super) fn checks(plan: &Plan, runs: &[Finished], tables: &Tables) -> Vec<CheckRow> {
    let tolerance = plan.case.tolerance;
    let later = || tables.gas.iter().filter(|row| row.time > 0.0);
    let energy = later().filter_map(|row| {
        Some(Point {
            time: row.time,
            measured: row.energy_ratio,
            error: row.energy_ratio_se,
            theory: row.energy_ratio_theory?,
            theory_error: row.energy_ratio_theory_error,
        })
    });
    let collisions = later().filter_map(|row| {
        Some(Point {
            time: row.time,
            measured: row.collisions_per_particle?,
            error: row.collisions_per_particle_se,
            theory: row.collisions_per_particle_theory?,
            theory_error: row.collisions_per_particle_theory_error,
        })
    });
    let total = later().filter_map(|row| {
        Some(Point {
            time: row.time,
            measured: row.displacement_square?,
            error: row.displacement_square_se,
            theory: row.displacement_square_theory?,
            theory_error: row.displacement_square_theory_error,
        })
    });
    let mut rows: Vec<CheckRow> = Vec::new();
    rows.extend(row(ENERGY, None, energy, tolerance));
    rows.extend(row(COLLISIONS, None, collisions, tolerance));
    rows.extend(row(DISPLACEMENT, None, total, tolerance));
    let replicas = runs.len();
    for (number, group) in (1..).zip(&plan.groups) {
        if group.count * replicas < FEWEST {
            continue;
        }
        let own = || {
            let of_species = tables.species.iter();
            of_species.filter(move |row| row.species == number && row.time > 0.0)
        };
        let temperature = own().filter_map(|row| {
            Some(Point {
                time: row.time,
                measured: row.temperature,
                error: row.temperature_se,
                theory: row.temperature_theory?,
                theory_error: row.temperature_theory_error,
            })
        });
        rows.extend(row(TEMPERATURE, Some(number), temperature, tolerance));
        let displacement = own().filter_map(|row| {
            Some(Point {
                time: row.time,
                measured: row.displacement_square?,
                error: row.displacement_square_se,
                theory: row.displacement_square_theory?,
                theory_error: row.displacement_square_theory_error,
            })
        });
        rows.extend(row(DISPLACEMENT, Some(number), displacement, tolerance));
        // A correlation that has fallen below its noise has no relative error to speak of.
        let correlation = own().filter_map(|row| {
            let theory = row.velocity_correlation_theory?;
            (theory > 0.1).then_some(Point {
                time: row.time,
                measured: row.velocity_correlation?,
                error: row.velocity_correlation_se,
                theory,
                theory_error: row.velocity_correlation_theory_error,
            })
        });
        rows.extend(row(CORRELATION, Some(number), correlation, tolerance));
        let averaged = tables
            .time_averaged
            .iter()
            .filter(|row| row.species == number)
            .filter_map(|row| {
                Some(Point {
                    time: row.lag,
                    measured: row.displacement_square,
                    error: row.displacement_square_se,
                    theory: row.displacement_square_theory?,
                    theory_error: row.displacement_square_theory_error,
                })
            });
        rows.extend(row(TIME_AVERAGED, Some(number), averaged, tolerance));
    }
    rows.extend(cumulant(plan, runs, tables).and_then(|point| {
        // An absolute quantity near zero: only its standard error counts.
        let mut row = row(CUMULANT, None, std::iter::once(point), f64::MAX)?;
        name(cumulant_outcome(&point)).clone_into(&mut row.verdict);
        Some(row)
    }));
    rows.extend(
        hyperscaling(plan, runs)
            .and_then(|point| row(DECAY, None, std::iter::once(point), tolerance)),
    );
    rows
}

fn cumulant_outcome(point: &Point) -> VerdictKind {
    match point.z() {
        None => VerdictKind::Undecided,
        Some(z) if z.abs() > SIGNIFICANT => VerdictKind::Differ,
        Some(_) => VerdictKind::Agree,
    }
}

/// Collisions of a particle after which a Maxwellian start is forgotten: the cumulant relaxes within some five.
const FORGOTTEN: f64 = 15.0;

/// Fourth cumulant in the cooling state: replicas averaged over the samples after the start is forgotten, against the
/// Sonine expansion at the end.
fn cumulant(plan: &Plan, runs: &[Finished], tables: &Tables) -> Option<Point> {
    plan.fourth_cumulants()?;
    let last = tables.species.last()?;
    let theory = last.fourth_cumulant_theory?;
    let particles = plan.particles() as f64;
    let mut begin = f64::INFINITY;
    let means: Vec<f64> = runs
        .iter()
        .filter_map(|run| {
            let late = run
                .record
                .samples
                .iter()
                .filter(|sample| 2.0 * sample.collisions as f64 / particles > FORGOTTEN);
            let values: Vec<f64> = late
                .inspect(|sample| begin = begin.min(sample.time))
                .filter_map(|sample| Some(sample.groups.first()?.fourth_cumulant))
                .collect();
            let count = values.len() as f64;
            (count > 0.0).then(|| values.iter().sum::<f64>() / count)
        })
        .collect();
    let estimate = Estimate::over_replicas(&means)?;
    Some(Point {
        time: begin,
        measured: estimate.value,
        error: estimate.standard_error,
        theory,
        theory_error: last.fourth_cumulant_theory_error,
    })
}

/// `2 xi/D + theta` of a gas in which all pairs stick, whose number decays as `t^-xi` and whose energy as `t^-theta`, over
/// the last factor of ten of time, against 2: Trizac & Krapivsky, Phys. Rev. Lett. 91, 218302 (2003).
///
/// The rate of collisions is `n R^(D-1) v`; with the sizes `R^D ~ 1/n` and `v^2 ~ E` (mass is conserved) it is the rate
/// `1/t` at which n decays if `xi/D + theta/2 = 1`.
fn hyperscaling(plan: &Plan, runs: &[Finished]) -> Option<Point> {
    let sticking = plan.case.sticking?;
    if sticking.stick_below.is_some() || sticking.break_above.is_some() {
        return None;
    }
    let until = plan.case.run.until;
    let sums: Vec<f64> = runs
        .iter()
        .filter_map(|run| {
            let samples = &run.record.samples;
            let last = samples.last()?;
            let first = samples.iter().rev().find(|s| s.time <= 0.1001 * until)?;
            let decades = (last.time / first.time).ln();
            let exponent = |a: f64, b: f64| (a / b).ln() / decades;
            let number = exponent(first.particles as f64, last.particles as f64);
            let energy = exponent(first.energy, last.energy);
            let sum = 2.0 * number / plan.case.dimension as f64 + energy;
            (first.time > 0.0 && sum.is_finite()).then_some(sum)
        })
        .collect();
    let estimate = Estimate::over_replicas(&sums)?;
    Some(Point {
        time: until,
        measured: estimate.value,
        error: estimate.standard_error,
        theory: 2.0,
        theory_error: None,
    })
}

/// Everything that the checks say, in words.
pub(crate) fn verdicts(plan: &Plan, runs: &[Finished], tables: &Tables) -> Vec<Verdict> {
    let quantities = [
        ENERGY,
        TEMPERATURE,
        COLLISIONS,
        CUMULANT,
        DISPLACEMENT,
        CORRELATION,
        TIME_AVERAGED,
        DECAY,
    ];
    let mut list: Vec<Verdict> = quantities
        .into_iter()
        .filter_map(|quantity| verdict(plan, quantity, tables))
        .collect();
    list.extend(ledger(tables));
    list.extend(steady_state(plan, runs));
    list
}

/// What theory is meant, in words.
fn theory_of(quantity: &str, orders: usize) -> String {
    match quantity {
        TIME_AVERAGED if orders == 1 => "the cooling state in first Sonine order".to_owned(),
        DECAY => "2 xi/D + theta = 2, xi of the number and theta of the energy".to_owned(),
        ENERGY | TEMPERATURE | COLLISIONS if orders == 1 => {
            "the kinetic equations of Maxwellian species".to_owned()
        }
        _ if orders == 1 => "theory in first Sonine order".to_owned(),
        _ => format!("the kinetic equations in {orders} Sonine orders"),
    }
}

fn verdict(plan: &Plan, quantity: &str, tables: &Tables) -> Option<Verdict> {
    let rows: Vec<&CheckRow> = tables
        .checks
        .iter()
        .filter(|row| row.quantity == quantity)
        .collect();
    let worst = rows.iter().max_by(|a, b| {
        a.deviation_percent
            .abs()
            .total_cmp(&b.deviation_percent.abs())
    })?;
    let with = |verdict: &str| -> Vec<&&CheckRow> {
        rows.iter().filter(|row| row.verdict == verdict).collect()
    };
    let (differ, undecided) = (with("differ"), with("undecided"));
    let theory = theory_of(quantity, tables.sonine_orders);
    let tolerance = 100.0 * plan.case.tolerance;
    let (sentence, kind) = if quantity == CUMULANT {
        let [simplest, _] = plan.fourth_cumulants()?;
        let sentence = format!(
            "From t = {} on the fourth cumulant is {}; {theory} have {}, the simplest formula (van Noije & Ernst) {simplest:.4}.",
            short(worst.time),
            with_error(worst.measured, worst.measured_se),
            with_error(worst.theory, worst.theory_error),
        );
        (sentence, kind_of(&worst.verdict))
    } else if quantity == DECAY {
        let sentence = format!(
            "Over the last factor of ten of time, 2 xi/D + theta = {} against 2.",
            with_error(worst.measured, worst.measured_se)
        );
        (sentence, kind_of(&worst.verdict))
    } else if !differ.is_empty() {
        let told: Vec<String> = spread(&differ, 6)
            .iter()
            .map(|row| place(plan, tables, row))
            .collect();
        let more = differ.len() - told.len();
        let more = if more > 0 {
            format!(" and {more} more")
        } else {
            String::new()
        };
        let sentence = format!(
            "Against {theory}, tolerance {tolerance} %, the largest deviations are {}{more}.{}",
            told.join("; "),
            caveat(plan, quantity, tables, &differ)
        );
        (sentence, VerdictKind::Differ)
    } else if rows.len() > undecided.len() {
        let agreed: Vec<&&CheckRow> = with("agree");
        let largest = agreed.iter().max_by(|a, b| {
            a.deviation_percent
                .abs()
                .total_cmp(&b.deviation_percent.abs())
        })?;
        let wide = if undecided.is_empty() {
            String::new()
        } else {
            format!(
                " Of {} species the errors, or what one order more changes, are too wide to tell.",
                undecided.len()
            )
        };
        let sentence = format!(
            "Against {theory}, deviations are within {tolerance} %; the largest is {}.{wide}",
            place(plan, tables, largest)
        );
        (sentence, VerdictKind::Agree)
    } else {
        let sentence = format!(
            "Against {theory}, errors, or what one order more changes, are unknown or wider than {tolerance} %; the largest \
             deviation is {}.",
            place(plan, tables, worst)
        );
        (sentence, VerdictKind::Undecided)
    };
    Some(Verdict {
        topic: quantity.to_owned(),
        sentence,
        kind,
    })
}

fn kind_of(verdict: &str) -> VerdictKind {
    match verdict {
        "agree" => VerdictKind::Agree,
        "differ" => VerdictKind::Differ,
        _ => VerdictKind::Undecided,
    }
}

/// What is known of the theory's own limits.
fn caveat(plan: &Plan, quantity: &str, tables: &Tables, differ: &[&&CheckRow]) -> &'static str {
    let masses = || plan.groups.iter().map(|group| group.mass);
    let lightest = masses().fold(f64::INFINITY, f64::min);
    let heaviest = masses().fold(0.0, f64::max);
    let unlike = heaviest > 4.0 * lightest;
    let orders = tables.sonine_orders;
    let strange = || {
        let of_species =
            |row: &SpeciesRow| differ.iter().any(|one| one.species == Some(row.species));
        let mut rows = tables.species.iter().filter(|row| of_species(row));
        rows.any(|row| row.fourth_cumulant.abs() > STRANGE && row.count > 100)
    };
    match quantity {
        _ if orders > 1 && strange() => {
            " Velocities there are too far from Maxwellian for an expansion to converge; what one order less changes says too \
             little of its error (docs/mixtures.md)."
        }
        _ if orders > 1 => "",
        DISPLACEMENT | TIME_AVERAGED | CORRELATION if unlike => {
            " First Sonine order takes velocities for Maxwellian and their correlations for exponential, and is off by up to \
             15 % for light particles among heavy ones, by more for heavy ones among very many light ones, whose speeds \
             become alike (docs/mixtures.md)."
        }
        TEMPERATURE | ENERGY | COLLISIONS if unlike => {
            " The equations take all velocities for Maxwellian; how far they are from it, the fourth cumulants tell \
             (docs/mixtures.md)."
        }
        DISPLACEMENT | TIME_AVERAGED | CORRELATION => {
            " First Sonine order takes velocities for Maxwellian and their correlations for exponential."
        }
        _ => "",
    }
}

/// A deviation with its place.
fn place(plan: &Plan, tables: &Tables, row: &CheckRow) -> String {
    let z = row.z.map_or_else(
        || "error unknown".to_owned(),
        |z| format!("{z:.1} standard errors"),
    );
    // How far the velocities are from those that theory assumes.
    let cumulant = tables
        .species
        .iter()
        .rfind(|known| Some(known.species) == row.species && known.time <= row.time)
        .map_or(String::new(), |known| {
            format!(", fourth cumulant {:.3}", known.fourth_cumulant)
        });
    let species = match row.species {
        Some(number) if plan.groups.len() > 1 => {
            format!(
                "species {number} (mass {})",
                short(plan.groups[number as usize - 1].mass)
            )
        }
        _ => "the gas as a whole".to_owned(),
    };
    format!(
        "{:+.2} % for {species} at t = {} ({z}{cumulant})",
        row.deviation_percent,
        short(row.time)
    )
}

/// A number in few digits.
fn short(value: f64) -> String {
    if (1e-3..1e6).contains(&value.abs()) || value == 0.0 {
        let rounded = format!("{value:.4}");
        rounded
            .trim_end_matches('0')
            .trim_end_matches('.')
            .to_owned()
    } else {
        format!("{value:.3e}")
    }
}

/// At most `most` of the items, evenly spread.
fn spread<T: Copy>(items: &[T], most: usize) -> Vec<T> {
    if items.len() <= most {
        return items.to_vec();
    }
    (0..most)
        .map(|i| items[i * (items.len() - 1) / (most - 1)])
        .collect()
}

/// Whether what was limited in a gas that sticks was limited at all.
fn ledger(tables: &Tables) -> Option<Verdict> {
    let last: &ClusterRow = tables.clusters.last()?;
    (last.refused > 0).then(|| Verdict {
        topic: "limits".to_owned(),
        sentence: format!(
            "{} pairs bounced that should have stuck or broken, as the gas or a cluster would have become too large.",
            last.refused
        ),
        kind: VerdictKind::Warning,
    })
}

/// Exponent of the distribution of radii: with k ~ R^D and dk ~ R^(D - 1) dR, k^-q dk is R^-(D q - D + 1) dR.
fn radius_exponent(plan: &Plan, exponent: f64) -> f64 {
    let d = plan.case.dimension as f64;
    d * exponent - d + 1.0
}

/// Whether sticking and breaking have come to a balance, and its power law.
fn steady_state(plan: &Plan, runs: &[Finished]) -> Vec<Verdict> {
    let (Some(steady), Some(drift)) = (plan.case.measure.steady, steady::drift(runs)) else {
        return Vec::new();
    };
    let mut list = Vec::new();
    let point = Point {
        time: steady.from,
        measured: drift.value,
        error: drift.standard_error,
        theory: 1.0,
        theory_error: None,
    };
    let kind = point.outcome(plan.case.tolerance);
    let said = match kind {
        VerdictKind::Agree => "The gas is steady",
        VerdictKind::Differ => "The gas is not steady",
        _ => "Whether the gas is steady cannot be told",
    };
    list.push(Verdict {
        topic: "steady state".to_owned(),
        sentence: format!(
            "{said} from t = {} on: the number of clusters in the second half over that in the first is {}.",
            short(steady.from),
            with_error(drift.value, drift.standard_error)
        ),
        kind,
    });
    if let Some(fit) = steady::fit(plan, runs) {
        let [low, high] = steady.fit_monomers;
        let cutoff = fit.inverse_cutoff;
        list.push(Verdict {
            topic: "sizes in the steady state".to_owned(),
            sentence: format!(
                "Numbers of clusters of {low} to {high} monomers follow k^-q exp(-k/K) with q = {}, which is {:.3} for their radii, and \
                 1/K = {:.5}{}.",
                with_error(fit.exponent.value, fit.exponent.standard_error),
                radius_exponent(plan, fit.exponent.value),
                cutoff.value,
                cutoff
                    .standard_error
                    .map_or(String::new(), |error| format!(" ± {error:.5}"))
            ),
            // A statement without anything to compare it with.
            kind: if kind == VerdictKind::Agree {
                VerdictKind::Agree
            } else {
                VerdictKind::Undecided
            },
        });
    }
    list
}
