//! Map of broken molecular chaos: deviations of exact disks from chaos, by packing fraction and
//! restitution.
//!
//! In a box narrower than the critical length the gas stays uniform, so only the correlation of few
//! particles remains. Each point of the map has two such boxes, which shows the effect of the box
//! size. The cooling rate is relative to that of molecular chaos at the mean squared speed of the
//! colliding pairs. Thermal shear waves lower this speed, and more so in wider boxes. The cooling
//! rate is also relative to that of N elastic disks ([`few_disks_ratio`]). Molecular chaos stands
//! for the homogeneous cooling state of Enskog's equation, whose velocities are not Maxwellian
//! ([`CoolingFactors`]).

use std::f64::consts::PI;

use stosszahl_model::equation_of_state;
use stosszahl_results::{
    Figure, FigureAxis, FinishedPoints, NumberNotFound, Table, TableEstimate, TableRow, table,
};
use stosszahl_theory::{CoolingFactors, three_disks};

use super::data::{DataMaker, DataTable, Made, csv_text};
use super::results::{OF_EXACT, number_text, value_and_error};
use super::tables::markdown_table;
use crate::TrialError;

/// Path of the page of the map of broken molecular chaos, relative to the repository root.
pub(super) const PAGE: &str = "docs/map.md";
/// Sonine orders of the velocity distribution under molecular chaos. Two more change a cooling rate
/// by 5e-4 at r = 0.5, where the series converges worst.
const ORDERS: usize = 8;
/// Number of standard errors beyond which the results of two box sizes disagree.
const APART: f64 = 3.0;

/// Packing fraction and coefficient of restitution of a point of the map.
type Place = [f64; 2];

/// Results of one box size at a point of the map: its number of disks, and table rows of its time
/// windows.
struct Gas<'a> {
    at: Place,
    disks: f64,
    chaos: CoolingFactors,
    impacts: Vec<TableRow<'a>>,
    rates: Vec<TableRow<'a>>,
}

impl<'a> Gas<'a> {
    fn from_results(results: &'a FinishedPoints, point: &str) -> Result<Self, TrialError> {
        let derived = &results.point(point)?.1.manifest.derived;
        let disks = derived.iter().find(|one| one.name == "particles");
        let restitution = results.setting(point, "gas.restitution")?;
        let found = Self {
            at: [results.setting(point, "box.packing_fraction")?, restitution],
            disks: disks.map_or(f64::NAN, |disks| disks.value),
            chaos: CoolingFactors::for_restitution(2, restitution, ORDERS)?,
            impacts: results.rows(point, "impact_parameter_summary", &[OF_EXACT])?,
            rates: results.rows(point, "dissipation", &[OF_EXACT])?,
        };
        if found.impacts.len() != found.rates.len() || !found.disks.is_finite() {
            return Err(TrialError::failed(format!("{point}: no windows or number")));
        }
        Ok(found)
    }

    /// Returns the slope of P(b/d) in the first time window of the box.
    fn first_slope(&self) -> Result<TableEstimate, NumberNotFound> {
        self.impacts[0].measured("slope")
    }

    /// Returns the slope of P(b/d) in the last time window of the box.
    fn slope(&self) -> Result<TableEstimate, NumberNotFound> {
        self.impacts[self.impacts.len() - 1].measured("slope")
    }

    /// Returns the cooling rate in the last time window over that of molecular chaos at the same
    /// pair speed, corrected for the finite number of disks.
    fn cooling(&self) -> Result<TableEstimate, NumberNotFound> {
        let unit = few_disks_ratio(self.disks, self.at[0]) * self.chaos.at_pair_speed();
        self.late("at_pair_speed", unit)
    }

    /// Returns a column of the cooling table in the last time window, over its value under
    /// molecular chaos.
    fn late(&self, column: &str, chaos: f64) -> Result<TableEstimate, NumberNotFound> {
        let last = self.rates[self.rates.len() - 1].measured(column)?;
        Ok(last.times(1.0 / chaos))
    }
}

/// Averages two estimates of one number, weighted by their inverse variances.
fn mean(a: TableEstimate, b: TableEstimate) -> TableEstimate {
    let [[a, a_error], [b, b_error]] = [a, b].map(value_and_error);
    let [wa, wb] = [a_error, b_error].map(|error| error.powi(-2));
    TableEstimate::with_error((wa * a + wb * b) / (wa + wb), Some((wa + wb).powf(-0.5)))
}

/// Returns the collision rate of N elastic disks at a given squared speed of colliding pairs, over
/// the rate of infinitely many disks.
///
/// The density of a box of N disks does not fluctuate. That lowers the pairs at contact by half the
/// variance of the density times the second derivative of `n^2 chi`: by
/// `S(0)/(2 N) (phi^2 chi)''/chi` (Salacuse, Denton & Egelstaff, *Physical Review E* **53**, 2382
/// (1996), doi:10.1103/PhysRevE.53.2382).
///
/// Velocities of N disks of fixed energy and momentum are a point on a sphere of `2 (N - 1)`
/// dimensions. `<g>` is therefore larger by `sqrt(N) Gamma(N - 1)/Gamma(N - 1/2)`, and the squared
/// speed of colliding pairs by `N/(N - 1/2)`.
fn few_disks_ratio(disks: f64, packing: f64) -> f64 {
    let near = 1e-3;
    let [below, own, above] = [packing - near, packing, packing + near]
        .map(|phi| phi * phi * equation_of_state::contact_value(phi));
    let second = (below - 2.0 * own + above) / (near * near);
    let structure = equation_of_state::structure_factor_at_zero(packing);
    let pairs = 1.0 - 0.5 * structure / disks * second / equation_of_state::contact_value(packing);
    let gammas = (2..disks as u32).fold(2.0 / PI.sqrt(), |ratio, n| {
        ratio * f64::from(n - 1) / (f64::from(n) - 0.5)
    });
    pairs * gammas * (disks - 0.5).sqrt()
}

/// Reads the results of all boxes of the map.
fn gases(results: &FinishedPoints) -> Result<Vec<Gas<'_>>, TrialError> {
    let points = results.names();
    points
        .map(|point| Gas::from_results(results, point))
        .collect()
}

/// Coefficients of restitution shown on documentation pages. The table files have all of them.
const SHOWN: [f64; 3] = [0.5, 0.7, 0.9];

/// Returns the distinct values of one coordinate of the map's points, in rising order.
fn coordinates(points: impl IntoIterator<Item = Place>, axis: usize) -> Vec<f64> {
    let mut all: Vec<f64> = points.into_iter().map(|at| at[axis]).collect();
    all.sort_by(f64::total_cmp);
    all.dedup();
    all
}

/// Formats a Markdown table of the map, with a row for each restitution of `SHOWN` and a column for
/// each packing fraction.
fn matrix(cells: &[(Place, String)]) -> Result<String, TrialError> {
    let packings = coordinates(cells.iter().map(|cell| cell.0), 0);
    let mut restitutions = coordinates(cells.iter().map(|cell| cell.0), 1);
    restitutions.retain(|r| SHOWN.contains(r));
    let header = packings.iter().map(|phi| format!(" | {phi}"));
    let rows = restitutions.into_iter().map(|r| {
        let cell = |&phi: &f64| {
            let found = cells.iter().find(|cell| cell.0 == [phi, r]);
            found.map_or(String::new(), |cell| cell.1.clone())
        };
        let own = [r.to_string()].into_iter();
        Ok(own.chain(packings.iter().map(cell)).collect())
    });
    markdown_table(&format!("r \\ φ{}", header.collect::<String>()), rows)
}

/// Returns true if the results of two box sizes differ by more than three standard errors.
fn disagree(both: [TableEstimate; 2]) -> bool {
    let [[narrow, narrow_error], [wide, wide_error]] = both.map(value_and_error);
    (narrow - wide).abs() > APART * narrow_error.hypot(wide_error)
}

/// Formats the result of the wider box with its error. If the two boxes disagree, formats both
/// values without errors.
fn of_boxes(both: [TableEstimate; 2]) -> String {
    if disagree(both) {
        let [[narrow, _], [wide, _]] = both.map(value_and_error);
        format!("{narrow:.4} … {wide:.4}")
    } else {
        number_text(both[1])
    }
}

/// Formats the results of both box sizes at each point of the map. Also returns the number of
/// points at which they disagree, and the largest error.
fn of_all_boxes(
    points: &[(Place, [TableEstimate; 2])],
) -> Result<(String, usize, f64), TrialError> {
    let cells: Vec<_> = points
        .iter()
        .map(|(at, both)| (*at, of_boxes(*both)))
        .collect();
    let apart = points.iter().filter(|(_, both)| disagree(*both)).count();
    let errors = points.iter().map(|(_, both)| value_and_error(both[1])[1]);
    Ok((matrix(&cells)?, apart, errors.fold(0.0, f64::max)))
}

/// Creates a figure of one column against 1 - r for the restitution r, with a curve for each
/// packing fraction.
fn figure(title: &'static str, column: &'static str, label: &'static str, chaos: f64) -> Figure {
    let [x, y] = [
        FigureAxis::logarithmic("inelasticity", "1 - r"),
        FigureAxis::linear(column, label),
    ];
    Figure::curves(title, x, y)
        .by(&["packing_fraction"])
        .line("molecular chaos", chaos)
}

/// Combines the text of a block with its table as CSV and its two figures.
fn made(text: String, table: &Table, names: [&'static str; 3]) -> Result<Made, TrialError> {
    let mut files = vec![(names[0].to_owned(), csv_text(table)?)];
    for (figure, name) in table.figures.iter().zip(&names[1..]) {
        let drawn = stosszahl_report::drawing(table, figure);
        let drawn = drawn.ok_or_else(|| TrialError::failed(format!("{name}: nothing to draw")))?;
        files.push(((*name).to_owned(), drawn));
    }
    Ok(Made { text, files })
}

/// Generates the block of boxes narrower than the critical length of shear modes, two for each
/// point of the map.
pub(super) fn uniform(results: &FinishedPoints) -> Result<Made, TrialError> {
    let mut table = table! {
        "map", "Exact disks that cool in boxes narrower than the critical length, against the homogeneous cooling state under molecular chaos.";
        key "packing_fraction", "1", "Packing fraction";
        key "restitution", "1", "Restitution";
        key "inelasticity", "1", "1 - r";
        note "disks_narrow", "1", "Disks in the narrower box, 0.57 critical lengths wide";
        note "disks", "1", "Disks in the wider box, 0.8 critical lengths wide";
        estimate "slope_first", "1", "Slope of P(b/d) in the first two collisions of a disk, both boxes";
        estimate "slope_narrow", "1", "Slope of P(b/d) from 10 to 100 collisions of a disk, narrower box";
        estimate "slope", "1", "The same in the wider box";
        estimate "cooling_narrow", "1", "Cooling rate over that of chaos at the squared speed of pairs, over that of as many elastic disks, narrower box";
        estimate "cooling", "1", "The same in the wider box";
        estimate "impact_ratio", "1", "Mean of 1 - b^2/d^2 over its value under chaos, wider box";
        estimate "correlation_ratio", "1", "Correlation of relative speed and impact parameter, wider box";
        estimate "speed_ratio", "1", "Squared speed of pairs over its value under chaos at the total kinetic energy, wider box";
        estimate "dissipation_ratio", "1", "Cooling rate over that of chaos at the total kinetic energy, wider box";
    }
    .figure(figure("Grazing collisions: slope of P(b/d)", "slope", "slope of P(b/d)", 0.0))
    .figure(figure("Cooling rate over chaos at the same speed of pairs", "cooling", "cooling rate over chaos", 1.0));
    let all = gases(results)?;
    // Slopes and cooling rates, each with its point and the results of both boxes.
    let mut columns = [Vec::new(), Vec::new()];
    for narrow in &all {
        let is_wider = |b: &&Gas<'_>| b.at == narrow.at && b.disks > narrow.disks;
        let Some(wide) = all.iter().find(is_wider) else {
            continue;
        };
        let [packing, restitution] = wide.at;
        let slopes = [narrow.slope()?, wide.slope()?];
        let rates = [narrow.cooling()?, wide.cooling()?];
        table.add((
            (packing, restitution, 1.0 - restitution),
            [narrow.disks as u64, wide.disks as u64],
            mean(narrow.first_slope()?, wide.first_slope()?),
            [slopes, rates],
            [
                wide.late("impact_ratio", 1.0)?,
                wide.late("correlation_ratio", 1.0)?,
                wide.late("speed_ratio", wide.chaos.pair_speed)?,
                wide.late("dissipation_ratio", wide.chaos.cooling_rate())?,
            ],
        ));
        columns[0].push((wide.at, slopes));
        columns[1].push((wide.at, rates));
    }
    let [slopes, rates] = columns;
    let count = slopes.len();
    let (slopes, slopes_apart, slope_error) = of_all_boxes(&slopes)?;
    let (rates, rates_apart, rate_error) = of_all_boxes(&rates)?;
    let text = format!(
        "Slope of P(b/d) from 10 to 100 collisions of a disk; 0 is chaos:\n\n{slopes}\n\
         Cooling rate over that of chaos at the same squared speed of pairs; 1 is chaos:\n\n{rates}\n\
         Where two numbers stand, the narrower and the wider box differ by more than three errors, and neither is the gas's: slopes at {slopes_apart} \
         of {count} points, cooling rates at {rates_apart}. The widest error of a slope is {slope_error:.4}, and of a cooling rate {rate_error:.4}.\n",
    );
    let names = [
        "docs/map-uniform.csv",
        "docs/map-slope.svg",
        "docs/map-cooling.svg",
    ];
    made(text, &table, names)
}

/// Generates the block of boxes of 4000 disks, in which thermal shear waves matter.
pub(super) fn waves(results: &FinishedPoints) -> Result<Made, TrialError> {
    let mut table = table! {
        "map-waves", "Exact disks that cool in boxes of 4000, against the homogeneous cooling state under molecular chaos, from 5 to 30 t0.";
        key "packing_fraction", "1", "Packing fraction";
        key "restitution", "1", "Restitution";
        key "inelasticity", "1", "1 - r";
        estimate "slope", "1", "Slope of P(b/d)";
        estimate "dissipation_ratio", "1", "Cooling rate over that of chaos at the total kinetic energy";
        estimate "at_pair_speed", "1", "Cooling rate over that of chaos at the squared speed of pairs";
    }
    .figure(figure("Slope of P(b/d), 4000 disks, 5 to 30 t0", "slope", "slope of P(b/d)", 0.0))
    .figure(figure("Cooling rate over chaos, 4000 disks, 5 to 30 t0", "dissipation_ratio", "cooling rate over chaos", 1.0));
    let (mut slopes, mut rates) = (Vec::new(), Vec::new());
    for gas in gases(results)? {
        let [packing, restitution] = gas.at;
        let slope = gas.slope()?;
        let dissipation = gas.late("dissipation_ratio", gas.chaos.cooling_rate())?;
        let at_pair_speed = gas.late("at_pair_speed", gas.chaos.at_pair_speed())?;
        table.add((
            (packing, restitution, 1.0 - restitution),
            [slope, dissipation, at_pair_speed],
        ));
        slopes.push((gas.at, number_text(slope)));
        rates.push((gas.at, number_text(dissipation)));
    }
    let text = format!(
        "Slope of P(b/d) from 5 to 30 t0:\n\n{}\nCooling rate over that of chaos at the total kinetic energy, from 5 to 30 t0:\n\n{}",
        matrix(&slopes)?,
        matrix(&rates)?,
    );
    let names = [
        "docs/map-waves.csv",
        "docs/map-waves-slope.svg",
        "docs/map-waves-cooling.svg",
    ];
    made(text, &table, names)
}

/// Packing fractions at which the three-disk theory is compared with the first collisions of exact
/// disks: low enough for first order, high enough for a visible effect.
const THREE_DISKS: [f64; 2] = [0.1, 0.2];
/// Number of random third disks in the Monte Carlo integral of the three-disk theory.
const SAMPLES: u64 = 20_000_000;

/// Generator of the block of P(b/d) in the first two collisions of a disk, next to the three-disk
/// theory.
pub(super) const ONSET: DataMaker = DataMaker::Data {
    table: onset,
    data: DataTable {
        columns: onset_columns,
        summary: onset_summary,
    },
};

fn onset_columns() -> Table {
    table! {
        "map-onset", "Slope of P(b/d) in the first two collisions of a disk.";
        key "packing_fraction", "1", "Packing fraction";
        key "restitution", "1", "Restitution";
        estimate "slope", "1", "Slope of P(b/d) of exact disks";
        estimate "three_disks", "1", "Slope of three disks alone, to first order in density; empty where that is no limit";
    }
}

fn onset(results: &FinishedPoints) -> Result<Table, TrialError> {
    let gases = gases(results)?;
    let restitutions = coordinates(gases.iter().map(|gas| gas.at), 1);
    let mut alone = Vec::new();
    for packing in THREE_DISKS {
        let chi = equation_of_state::contact_value(packing);
        let until = 2.0 / equation_of_state::collision_rate(packing, chi, 0.0);
        let (_, orders) = three_disks::onset(&restitutions, until, SAMPLES, 1);
        for (&restitution, order) in restitutions.iter().zip(orders) {
            let slope = TableEstimate::with_error(order.value, Some(order.standard_error));
            alone.push(([packing, restitution], slope.times(packing)));
        }
    }
    let mut table = onset_columns();
    for gas in &gases {
        let found = alone.iter().find(|(at, _)| *at == gas.at);
        let found = found.map_or_else(TableEstimate::default, |(_, slope)| *slope);
        table.add((gas.at, [gas.first_slope()?, found]));
    }
    Ok(table)
}

/// Formats the slopes of P(b/d) at the restitutions `SHOWN`, and the largest error of all.
fn onset_summary(table: &Table, link: &str) -> Result<String, TrialError> {
    let (mut slopes, mut alone, mut widest) = (Vec::new(), Vec::new(), 0.0_f64);
    for row in table.all_rows() {
        let at = [row.number("packing_fraction")?, row.number("restitution")?];
        let slope = row.measured("slope")?;
        widest = widest.max(value_and_error(slope)[1]);
        slopes.push((at, number_text(slope)));
        if row.number("three_disks").is_ok() {
            alone.push((at, number_text(row.measured("three_disks")?)));
        }
    }
    Ok(format!(
        "Slope of P(b/d) in the first two collisions of a disk ([all points]({link})); the widest error is {widest:.4}:\n\n{}\n\
         The same by three disks alone, to first order in density:\n\n{}",
        matrix(&slopes)?,
        matrix(&alone)?,
    ))
}

#[cfg(test)]
mod tests {
    use stosszahl_analysis::statistics::Estimate;
    use stosszahl_dsmc::homogeneous::{
        AliasTableSelection, HomogeneousEngine, PairCorrelationFactor, moments,
    };
    use stosszahl_model::samples::{EqualDisks, UNIT, smooth_particles};

    use super::*;
    use crate::gas::{law, without_positions};

    /// Number of disks of the gas without positions that tests the map.
    const DISKS: usize = 20_000;

    /// Simulates disks that cool without positions, and returns collision rate and squared speed of
    /// pairs over those of Maxwellian velocities. The window is 40 to 60 collisions per disk. The
    /// rate is the number of collisions over the integral of the square root of the temperature, by
    /// the trapezoidal rule.
    fn factors_of_a_gas(restitution: f64, seed: u64) -> [f64; 2] {
        let scene: EqualDisks = smooth_particles(law(restitution).expect("a law"), UNIT);
        let extent = (DISKS as f64, DISKS);
        let made = without_positions(scene, PairCorrelationFactor::Dilute, extent, |_| 1.0, seed);
        let mut engine: HomogeneousEngine<_, AliasTableSelection> = made.expect("a gas");
        // Enskog's rate of Maxwellian velocities at T = m and n d^2 = 1: 2 sqrt(pi).
        let rate = 2.0 * PI.sqrt();
        let haff = 4.0 / ((1.0 - restitution * restitution) * rate);
        let share = 0.25 * (1.0 - restitution * restitution);
        let mut course = Vec::new();
        for step in 0..=100 {
            let collisions = 40.0 + 0.2 * f64::from(step);
            let time = haff * (share * collisions).exp_m1();
            engine.advance(time, u64::MAX, &mut ()).expect("it cools");
            let temperature = moments(engine.gas(), None, None)[0].temperature;
            let collisions = 2.0 * engine.tally().collisions as f64 / DISKS as f64;
            course.push([time, temperature, collisions]);
        }
        let span = |step: &[[f64; 3]]| {
            let [from, to] = [step[0], step[1]];
            0.5 * (to[0] - from[0]) * (from[1].sqrt() + to[1].sqrt())
        };
        let speeds: f64 = course.windows(2).map(span).sum();
        let [first, last] = [course[0], course[course.len() - 1]];
        let collisions = last[2] - first[2];
        let fall = (first[1] / last[1]).ln();
        [
            collisions / (rate * speeds),
            fall / (2.0 * share * collisions),
        ]
    }

    /// Tests the theory of chaotic cooling on disks without positions, whose collisions are chaotic
    /// by construction. The tolerance is five standard errors of eight gases, which one true mean
    /// in 600 exceeds. Errors must be small enough to resolve the difference to Maxwellian
    /// velocities.
    #[test]
    fn chaos_is_a_cooling_gas_without_positions() {
        for restitution in [0.5, 0.9] {
            let chaos = CoolingFactors::for_restitution(2, restitution, ORDERS).expect("factors");
            let gases: Vec<_> = (0..8)
                .map(|seed| factors_of_a_gas(restitution, seed))
                .map(|[rate, speed]| [rate, speed, rate / speed.sqrt()])
                .collect();
            let wanted = [
                chaos.collision_rate,
                chaos.pair_speed,
                chaos.at_pair_speed(),
            ];
            for (place, wanted) in wanted.into_iter().enumerate() {
                let values: Vec<f64> = gases.iter().map(|found| found[place]).collect();
                let found = Estimate::over_replicas(&values).expect("many gases");
                let error = found.standard_error.expect("many gases");
                let is_seen = 5.0 * error < (wanted - 1.0).abs();
                assert!(place < 2 || is_seen, "{restitution}: {error}");
                assert!(
                    (found.value - wanted).abs() < 5.0 * error,
                    "{restitution}: {found:?}, not {wanted}"
                );
            }
        }
    }

    #[test]
    fn boxes_that_disagree_have_no_error() {
        let of = |value| TableEstimate::with_error(value, Some(0.01));
        assert_eq!(of_boxes([of(1.0), of(1.04)]), "1.040 ± 0.010");
        assert_eq!(of_boxes([of(1.0), of(1.05)]), "1.0000 … 1.0500");
    }

    /// Tests the collision rate of N disks in a dilute gas, `1 - 5/(8 N)` of that of many disks.
    /// The N (N - 1)/2 pairs reduce it by 1/N, and speeds at a fixed squared speed of pairs add
    /// 3/(8 N).
    #[test]
    fn few_disks_collide_less_often() {
        for disks in [1e3, 1e4] {
            let wanted = 1.0 - 0.625 / disks;
            assert!((few_disks_ratio(disks, 1e-6) - wanted).abs() < 10.0 / (disks * disks));
        }
        assert!((few_disks_ratio(2.0, 1e-6) - 0.5 * 2.0 / PI.sqrt() * 1.5_f64.sqrt()).abs() < 1e-5);
    }

    #[test]
    fn a_mean_is_weighted_by_errors() {
        let root = 3.0_f64.sqrt();
        let [one, five] = [(1.0, 1.0), (5.0, root)]
            .map(|(value, error)| TableEstimate::with_error(value, Some(error)));
        let [value, error] = value_and_error(mean(one, five));
        assert!((value - 2.0).abs() < 1e-14 && (error - 0.5 * root).abs() < 1e-14);
    }
}
