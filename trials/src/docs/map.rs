//! The map of broken chaos: deviation of exact disks from molecular chaos, by packing and
//! restitution.
//!
//! In a box narrower than the critical length the gas stays uniform, so that only the correlation
//! of few particles is left. Each point has two such boxes, which shows the effect of the box. The
//! cooling rate is relative to that of chaos at the squared speed of the colliding pairs, because
//! thermal shear waves lower that speed, the more the wider the box is. It is also relative to that
//! of N elastic disks ([`of_few`]).

use std::f64::consts::PI;

use stosszahl_model::kinetic;
use stosszahl_results::{Axis, Estimate, Figure, Table, table};

use super::data::{Made, text as csv_text};
use super::results::{Key, Measured, Results, Row};
use super::tables::table as markdown;
use crate::TrialError;
use crate::three_disks;

/// Path of the page from the root.
pub(super) const PAGE: &str = "docs/map.md";

/// Results of one box: the rows of its windows.
struct Gas<'a> {
    at: Place,
    disks: f64,
    impacts: Vec<Row<'a>>,
    rates: Vec<Row<'a>>,
}

impl<'a> Gas<'a> {
    fn of(results: &'a Results, point: &str) -> Result<Self, TrialError> {
        let engine = [("engine", Key::Is("ed"))];
        let keys = ["box.packing_fraction", "gas.restitution"];
        let [packing, restitution] = keys.map(|key| results.setting(point, key));
        let found = Self {
            at: [packing?, restitution?],
            disks: results.derived(point, "particles")?,
            impacts: results.rows(point, "impact_parameter_summary", &engine)?,
            rates: results.rows(point, "dissipation", &engine)?,
        };
        if found.impacts.is_empty() || found.impacts.len() != found.rates.len() {
            return Err(TrialError::failed(format!("{point}: no windows")));
        }
        Ok(found)
    }

    fn slope(&self, window: usize) -> Result<Measured, TrialError> {
        self.impacts[window].measured("slope")
    }

    /// Cooling rate over chaos at the squared speed of pairs in the last window, over that of the
    /// same number of elastic disks.
    fn cooling(&self) -> Result<Measured, TrialError> {
        let unit = of_few(self.disks, self.at[0]);
        Ok(self.late("at_pair_speed")?.over(unit))
    }

    /// Returns a column of the last window.
    fn late(&self, column: &str) -> Result<Measured, TrialError> {
        self.rates[self.rates.len() - 1].measured(column)
    }
}

/// Mean of two measurements of one number, weighted by their errors.
fn mean(a: Measured, b: Measured) -> Measured {
    let [wa, wb] = [a, b].map(|one| one.error.powi(-2));
    Measured {
        value: (wa * a.value + wb * b.value) / (wa + wb),
        error: (wa + wb).powf(-0.5),
    }
}

/// Collision rate of N elastic disks at a given squared speed of colliding pairs, over that of very
/// many disks.
///
/// The density of a box of N disks does not fluctuate. That lowers the pairs at contact by half the
/// variance of the density times the second derivative of `n^2 chi`: by
/// `S(0)/(2 N) (phi^2 chi)''/chi` (Salacuse, Denton & Egelstaff, *Physical Review E* **53**, 2382
/// (1996), doi:10.1103/PhysRevE.53.2382).
///
/// Velocities of N disks of fixed energy and momentum are a point on a sphere of `2 (N - 1)`
/// dimensions. `<g>` is therefore larger by `sqrt(N) Gamma(N - 1)/Gamma(N - 1/2)`, and the squared
/// speed of colliding pairs by `N/(N - 1/2)`.
fn of_few(disks: f64, packing: f64) -> f64 {
    let near = 1e-3;
    let [below, own, above] = [packing - near, packing, packing + near]
        .map(|phi| phi * phi * kinetic::contact_value(phi));
    let second = (below - 2.0 * own + above) / (near * near);
    let structure = kinetic::structure_factor_at_zero(packing);
    let pairs = 1.0 - 0.5 * structure / disks * second / kinetic::contact_value(packing);
    let gammas = (2..disks as u32).fold(2.0 / PI.sqrt(), |ratio, n| {
        ratio * f64::from(n - 1) / (f64::from(n) - 0.5)
    });
    pairs * gammas * (disks - 0.5).sqrt()
}

fn estimate(one: Measured) -> Estimate {
    Estimate::of(one.value, Some(one.error))
}

/// Packing fraction and restitution of a point.
type Place = [f64; 2];

/// Returns all boxes.
fn gases(results: &Results) -> Result<Vec<Gas<'_>>, TrialError> {
    let points = results.points();
    points.map(|point| Gas::of(results, point)).collect()
}

/// Formats a table of Markdown with a row for each restitution and a column for each packing.
fn matrix(cells: &[(Place, Measured)]) -> String {
    let values = |axis: usize| {
        let mut all: Vec<f64> = cells.iter().map(|cell| cell.0[axis]).collect();
        all.sort_by(f64::total_cmp);
        all.dedup();
        all
    };
    let packings = values(0);
    let mut header = vec!["r \\ φ".to_owned()];
    header.extend(packings.iter().map(f64::to_string));
    let row = |&r: &f64| {
        let cell = |&phi: &f64| {
            let found = cells.iter().find(|cell| cell.0 == [phi, r]);
            found.map_or(String::new(), |cell| cell.1.text())
        };
        let own = [r.to_string()].into_iter();
        own.chain(packings.iter().map(cell)).collect::<Vec<_>>()
    };
    let rows: Vec<Vec<String>> = values(1).iter().map(row).collect();
    markdown(
        &header.iter().map(String::as_str).collect::<Vec<_>>(),
        &rows,
    )
}

/// Creates a figure of a column against 1 - r, with a curve for each packing.
fn figure(title: &'static str, column: &'static str, label: &'static str, chaos: f64) -> Figure {
    let [x, y] = [
        Axis::logarithmic("inelasticity", "1 - r"),
        Axis::linear(column, label),
    ];
    Figure::curves(title, x, y)
        .by(&["packing_fraction"])
        .line("molecular chaos", chaos)
}

/// Combines a text with a table as files: CSV and its two figures.
fn made(text: String, table: &Table, names: [&'static str; 3]) -> Result<Made, TrialError> {
    let mut files = vec![(names[0].to_owned(), csv_text(table)?)];
    for (figure, name) in table.figures.iter().zip(&names[1..]) {
        let drawn = stosszahl_report::drawing(table, figure);
        let drawn = drawn.ok_or_else(|| TrialError::failed(format!("{name}: nothing to draw")))?;
        files.push(((*name).to_owned(), drawn));
    }
    Ok(Made { text, files })
}

/// Makes the block of boxes narrower than the critical length.
pub(super) fn uniform(results: &Results) -> Result<Made, TrialError> {
    let mut table = table! {
        "map", "Exact disks that cool in boxes narrower than the critical length, against molecular chaos.";
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
        estimate "speed_ratio", "1", "Squared speed of pairs over its value at the total kinetic energy, wider box";
        estimate "dissipation_ratio", "1", "Cooling rate over that of chaos at the total kinetic energy, wider box";
    }
    .figure(figure("Grazing collisions: slope of P(b/d)", "slope", "slope of P(b/d)", 0.0))
    .figure(figure("Cooling rate over chaos at the same speed of pairs", "cooling", "cooling rate over chaos", 1.0));
    let (mut slopes, mut cooling) = (Vec::new(), Vec::new());
    let (mut apart, mut widest) = ([0; 2], [0.0_f64; 2]);
    let all = gases(results)?;
    for a in &all {
        // Each place has a narrow box and a wide one.
        let at = a.at;
        let Some(b) = all.iter().find(|b| b.at == at && b.disks > a.disks) else {
            continue;
        };
        let last = a.impacts.len() - 1;
        let [slope_a, slope] = [a.slope(last)?, b.slope(last)?];
        let [rate_a, rate] = [a.cooling()?, b.cooling()?];
        let differ = |one: Measured, other: Measured| {
            usize::from((one.value - other.value).abs() > 3.0 * one.error.hypot(other.error))
        };
        apart = [
            apart[0] + differ(slope_a, slope),
            apart[1] + differ(rate_a, rate),
        ];
        widest = [widest[0].max(slope.error), widest[1].max(rate.error)];
        table.add((
            (at[0], at[1], 1.0 - at[1]),
            [a.disks, b.disks].map(|disks| disks as u64),
            estimate(mean(a.slope(0)?, b.slope(0)?)),
            [slope_a, slope, rate_a, rate].map(estimate),
            [b.late("impact_ratio")?, b.late("correlation_ratio")?].map(estimate),
            [b.late("speed_ratio")?, b.late("dissipation_ratio")?].map(estimate),
        ));
        slopes.push((at, slope));
        cooling.push((at, rate));
    }
    let text = format!(
        "Slope of P(b/d) from 10 to 100 collisions of a disk; 0 is chaos:\n\n{}\n\
         Cooling rate over that of chaos at the same squared speed of pairs; 1 is chaos:\n\n{}\n\
         Between the two boxes the slopes differ by more than three errors at {} of {} points, and the cooling rates at {}. The widest error of a \
         slope is {:.4}, and of a cooling rate {:.4}.\n",
        matrix(&slopes),
        matrix(&cooling),
        apart[0],
        slopes.len(),
        apart[1],
        widest[0],
        widest[1],
    );
    let names = [
        "docs/map-uniform.csv",
        "docs/map-slope.svg",
        "docs/map-cooling.svg",
    ];
    made(text, &table, names)
}

/// Makes the block of boxes of 4000 disks.
pub(super) fn waves(results: &Results) -> Result<Made, TrialError> {
    let mut table = table! {
        "map-waves", "Exact disks that cool in boxes of 4000, against molecular chaos, from 5 to 30 t0.";
        key "packing_fraction", "1", "Packing fraction";
        key "restitution", "1", "Restitution";
        key "inelasticity", "1", "1 - r";
        estimate "slope", "1", "Slope of P(b/d)";
        estimate "dissipation_ratio", "1", "Cooling rate over that of chaos at the total kinetic energy";
        estimate "at_pair_speed", "1", "Cooling rate over that of chaos at the squared speed of pairs";
    }
    .figure(figure("Slope of P(b/d), 4000 disks, 5 to 30 t0", "slope", "slope of P(b/d)", 0.0))
    .figure(figure("Cooling rate over chaos, 4000 disks, 5 to 30 t0", "dissipation_ratio", "cooling rate over chaos", 1.0));
    let (mut slopes, mut cooling) = (Vec::new(), Vec::new());
    for gas in gases(results)? {
        let at = gas.at;
        let slope = gas.slope(gas.impacts.len() - 1)?;
        let rate = gas.late("dissipation_ratio")?;
        table.add((
            (at[0], at[1], 1.0 - at[1]),
            [slope, rate, gas.late("at_pair_speed")?].map(estimate),
        ));
        slopes.push((at, slope));
        cooling.push((at, rate));
    }
    let text = format!(
        "Slope of P(b/d) from 5 to 30 t0:\n\n{}\nCooling rate over that of chaos at the total kinetic energy, from 5 to 30 t0:\n\n{}",
        matrix(&slopes),
        matrix(&cooling),
    );
    let names = [
        "docs/map-waves.csv",
        "docs/map-waves-slope.svg",
        "docs/map-waves-cooling.svg",
    ];
    made(text, &table, names)
}

/// Packings at which three disks alone are compared with the onset: thin enough for a first order,
/// and dense enough to see it.
const THREE_DISKS: [f64; 2] = [0.1, 0.2];
/// Number of random third disks.
const SAMPLES: u64 = 20_000_000;

/// Makes the block of the first two collisions of a disk, next to the result of three disks alone.
pub(super) fn onset(results: &Results) -> Result<Made, TrialError> {
    let mut slopes = Vec::new();
    for gas in gases(results)? {
        slopes.push((gas.at, gas.slope(0)?));
    }
    let widest = slopes
        .iter()
        .map(|(_, slope)| slope.error)
        .fold(0.0, f64::max);
    let mut restitutions: Vec<f64> = slopes.iter().map(|(at, _)| at[1]).collect();
    restitutions.sort_by(f64::total_cmp);
    restitutions.dedup();
    let mut cells = Vec::new();
    for packing in THREE_DISKS {
        let chi = kinetic::contact_value(packing);
        let until = 2.0 / kinetic::collision_rate(packing, chi, 0.0);
        let (_, orders) = three_disks::onset(&restitutions, until, SAMPLES, 1);
        for (&restitution, order) in restitutions.iter().zip(orders) {
            let slope = Measured {
                value: packing * order.value,
                error: packing * order.standard_error,
            };
            cells.push(([packing, restitution], slope));
        }
    }
    let text = format!(
        "Slope of P(b/d) in the first two collisions of a disk; the widest error is {widest:.4}:\n\n{}\n\
         The same by three disks alone, to first order in density:\n\n{}",
        matrix(&slopes),
        matrix(&cells),
    );
    Ok(text.into())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Collision rate of N disks in a dilute gas, `1 - 5/(8 N)`: N (N - 1)/2 pairs are 1 - 1/N of
    /// those of very many disks, and Maxwellian speeds at a given squared speed of pairs add 3/(8
    /// N).
    #[test]
    fn few_disks_collide_less_often() {
        for disks in [1e3, 1e4] {
            let wanted = 1.0 - 0.625 / disks;
            assert!((of_few(disks, 1e-6) - wanted).abs() < 10.0 / (disks * disks));
        }
        assert!((of_few(2.0, 1e-6) - 0.5 * 2.0 / PI.sqrt() * 1.5_f64.sqrt()).abs() < 1e-5);
    }

    #[test]
    fn a_mean_is_weighted_by_errors() {
        let both = mean(
            Measured {
                value: 1.0,
                error: 1.0,
            },
            Measured {
                value: 5.0,
                error: 3.0_f64.sqrt(),
            },
        );
        assert!((both.value - 2.0).abs() < 1e-14 && (both.error - 0.75_f64.sqrt()).abs() < 1e-14);
    }
}
