//! Test of theoretical orders of convergence, by weighted fits of errors against refined
//! parameters.
//!
//! Each sequence of settings is fitted with `limit + slope h^order`, the order being theory's, and
//! with the order free. The runs of a sequence share their starts, so their common noise goes into
//! the limit, and the errors of the fitted differences are at worst too large. Where the order of
//! theory describes only the finer settings, the fit is to those.

use stosszahl_analysis::fit::{self, FitPoint, FittedLine};
use stosszahl_results::{Table, TableEstimate, table};

use super::front::MeasuredSetting;
use super::quantity::FrontierQuantity;
use super::reference::Reference;

/// Number of standard errors from which the slope of an error over h counts as significant.
const SEEN: f64 = 3.0;
/// Excess of chi-squared over its degrees of freedom, in standard deviations, from which an order
/// of convergence is rejected.
const BAD: f64 = 3.0;

/// Verdict on the theoretical order of convergence of a sequence of settings.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum OrderVerdict {
    /// The theoretical order describes the values, and the error is significant.
    Holds,
    /// The theoretical order does not describe the values.
    DoesNotHold,
    /// The slope of the error is within the noise, so that no order can be tested.
    NotSeen,
}

impl OrderVerdict {
    /// Returns the verdict in words, for tables.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Holds => "holds",
            Self::DoesNotHold => "does not hold",
            Self::NotSeen => "no error seen",
        }
    }
}

/// Row of `orders.csv`: the fitted order of convergence of one sequence and quantity.
#[derive(Clone, Debug)]
pub(crate) struct OrderRow {
    /// Name of the refined parameter and the scheme.
    pub sequence: &'static str,
    /// Quantity whose order of convergence is fitted.
    pub quantity: FrontierQuantity,
    /// Number of settings in the fit: those with the smallest h.
    pub settings: usize,
    /// Largest refined parameter h of the settings in the fit.
    pub coarsest: f64,
    /// Order of convergence by theory.
    pub order: f64,
    /// Order that fits best, and its range of one standard error; `None` if the error is not
    /// significant or there are fewer than three settings.
    pub found: Option<(f64, [f64; 2])>,
    /// Fit of `limit + slope h^order` to the errors, over the unit of the quantity. The limit is
    /// the systematic error at h = 0.
    pub line: FittedLine,
    /// Verdict on whether the theoretical order describes the values.
    pub verdict: OrderVerdict,
}

/// Builds the table `orders.csv` of convergence orders, with one row for each sequence of settings
/// and each quantity.
pub(crate) fn table(rows: &[OrderRow]) -> Table {
    let mut table = table! {
        "orders", "Whether errors fall at the orders that theory predicts.";
        key "sequence", "", "What is refined";
        key "quantity", "", "Quantity";
        key "time", "time", "When";
        note "settings", "1", "Settings of the fit, the finest ones";
        note "coarsest", "", "Largest h among them";
        value "order", "1", "Order by theory";
        value "found_order", "1", "Order that fits best; empty where no error is seen or three settings are lacking";
        note "found_order_low", "1", "Range of one standard error of it";
        note "found_order_high", "1", "Range of one standard error of it";
        estimate "limit_error", "1", "Limit at h = 0 less the reference, over the unit of the error";
        estimate "slope", "", "Slope over the unit of the error";
        note "chi_squared", "1", "Sum of the squared deviations over the squared errors";
        note "degrees_of_freedom", "1", "Degrees of freedom";
        note "verdict", "", "Whether the order of theory holds";
    };
    for row in rows {
        let line = &row.line;
        table.add((
            (row.sequence, row.quantity.kind.name(), row.quantity.time),
            (row.settings, row.coarsest, row.order),
            row.found.map(|found| found.0),
            [0, 1].map(|side| row.found.map(|found| found.1[side])),
            TableEstimate::with_error(line.intercept, Some(line.intercept_error)),
            TableEstimate::with_error(line.slope, Some(line.slope_error)),
            (
                line.chi_squared,
                line.degrees_of_freedom,
                row.verdict.name(),
            ),
        ));
    }
    table
}

/// Fits the order of convergence of every sequence of settings in every quantity, as far as
/// possible.
pub(crate) fn orders(
    measured: &[MeasuredSetting],
    quantities: &[FrontierQuantity],
    references: &[Reference],
) -> Vec<OrderRow> {
    let mut sequences: Vec<(&'static str, f64)> = Vec::new();
    for one in measured.iter().flat_map(|one| &one.setting.refinements) {
        if !sequences.iter().any(|(name, _)| *name == one.sequence) {
            sequences.push((one.sequence, one.order));
        }
    }
    let mut rows = Vec::new();
    for (sequence, order) in sequences {
        for (index, quantity) in quantities.iter().enumerate() {
            let known = references[index].known;
            let unit = quantity.kind.unit(known.value).abs();
            let point = |one: &MeasuredSetting| {
                let mut members = one.setting.refinements.iter();
                let here = members.find(|member| member.sequence == sequence)?;
                let found = one.accuracies[index]?;
                Some(FitPoint {
                    x: here.h,
                    y: (found.mean - known.value) / unit,
                    error: found.statistical / (found.repetitions as f64).sqrt(),
                })
            };
            let points = measured.iter().filter_map(point).collect();
            let error = known.standard_error / unit;
            rows.extend(fit_sequence(sequence, *quantity, order, points, error));
        }
    }
    rows
}

/// Fits the order of convergence of one sequence in one quantity. Theory holds for small h: while
/// its order does not describe the values, the coarsest setting is left out, down to three.
fn fit_sequence(
    sequence: &'static str,
    quantity: FrontierQuantity,
    order: f64,
    mut points: Vec<FitPoint>,
    reference_error: f64,
) -> Option<OrderRow> {
    /// Smallest number of settings in a fit of the order.
    const FEWEST: usize = 3;
    points.sort_by(|a, b| a.x.total_cmp(&b.x));
    let all = points.clone();
    while points.len() > FEWEST && fit::richardson(&points, order).is_ok_and(|line| is_bad(&line)) {
        points.pop();
    }
    if fit::richardson(&points, order).is_ok_and(|line| is_bad(&line)) {
        // Even the fewest settings do not fit: all points are reported.
        points = all;
    }
    let mut line = fit::richardson(&points, order).ok()?;
    if line.degrees_of_freedom == 0 {
        return None;
    }
    let bad = is_bad(&line);
    let seen = line.slope.abs() > SEEN * line.slope_error;
    let verdict = match (bad, seen) {
        (true, _) => OrderVerdict::DoesNotHold,
        (false, true) => OrderVerdict::Holds,
        (false, false) => OrderVerdict::NotSeen,
    };
    let free = (seen || bad).then(|| fit::order(&points).ok()).flatten();
    line.intercept_error = line.intercept_error.hypot(reference_error);
    Some(OrderRow {
        sequence,
        quantity,
        settings: points.len(),
        coarsest: points.last()?.x,
        order,
        found: free.map(|free| (free.value, free.range)),
        line,
        verdict,
    })
}

/// Returns true if chi-squared shows that a fit does not describe its values.
fn is_bad(line: &FittedLine) -> bool {
    let freedom = line.degrees_of_freedom as f64;
    line.chi_squared > freedom + BAD * (2.0 * freedom).sqrt()
}

#[cfg(test)]
mod tests {
    use super::super::quantity::QuantityKind;
    use super::*;

    fn verdict(order: f64, values: impl Fn(f64) -> f64) -> OrderVerdict {
        let points = [0.25, 0.5, 1.0, 2.0].map(|x| FitPoint {
            x,
            y: values(x),
            error: 0.01,
        });
        let quantity = FrontierQuantity {
            kind: QuantityKind::Energy,
            time: 1.0,
        };
        fit_sequence("cells", quantity, order, points.to_vec(), 0.0)
            .expect("a fit")
            .verdict
    }

    #[test]
    fn orders_hold_only_where_they_describe_the_values() {
        assert_eq!(verdict(2.0, |h| 0.1 + 0.3 * h * h), OrderVerdict::Holds);
        assert_eq!(
            verdict(1.0, |h| 0.1 + 3.0 * h * h),
            OrderVerdict::DoesNotHold
        );
        assert_eq!(verdict(2.0, |h| 0.1 + 3.0 * h), OrderVerdict::DoesNotHold);
        assert_eq!(verdict(2.0, |h| 0.1 + 1e-4 * h), OrderVerdict::NotSeen);
        // The coarsest setting is beyond the range of the leading order.
        let bent = |h: f64| 0.1 + 0.3 * h * h + if h > 1.5 { 0.5 } else { 0.0 };
        assert_eq!(verdict(2.0, bent), OrderVerdict::Holds);
    }
}
