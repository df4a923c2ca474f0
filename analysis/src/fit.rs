//! Weighted least squares for a handful of measured values: lines, limits, and orders of
//! convergence.
//!
//! Each value comes with its own standard error, taken as known: the errors of what is fitted
//! follow from them, and `chi_squared` shows whether the model can be true.

use serde::{Deserialize, Serialize};

use crate::Error;

/// Data point of a fit: abscissa, measured value and its standard error.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct FitPoint {
    /// Abscissa of the point, such as a time step or a time.
    pub x: f64,
    /// Measured value at the abscissa.
    pub y: f64,
    /// Standard error of the measured value.
    pub error: f64,
}

/// Line `y = intercept + slope x` fitted to data points, with standard errors.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct FittedLine {
    /// Intercept: fitted value at x = 0.
    pub intercept: f64,
    /// Standard error of the intercept.
    pub intercept_error: f64,
    /// Slope of the fitted line, in units of y over x.
    pub slope: f64,
    /// Standard error of the slope.
    pub slope_error: f64,
    /// Chi-squared of the fitted line: sum of the squared deviations over the squared errors.
    pub chi_squared: f64,
    /// Degrees of freedom of the fit: number of values less two.
    pub degrees_of_freedom: usize,
}

fn usable(points: &[FitPoint], needed: usize) -> Result<Vec<FitPoint>, Error> {
    let good =
        |p: &&FitPoint| p.x.is_finite() && p.y.is_finite() && p.error > 0.0 && p.error.is_finite();
    let points: Vec<_> = points.iter().filter(good).copied().collect();
    if points.len() < needed {
        return Err(Error::FitImpossible {
            found: points.len(),
            needed,
        });
    }
    Ok(points)
}

/// Fits a straight line by weighted least squares. Values that are not finite or have no error are
/// left out.
///
/// # Errors
/// [`Error::FitImpossible`] with fewer than two usable values, or all at one x.
///
/// ```
/// use stosszahl_analysis::fit::{FitPoint, line};
///
/// let points = [(0.0, 1.0), (1.0, 3.0), (2.0, 5.0)].map(|(x, y)| FitPoint { x, y, error: 0.1 });
/// let line = line(&points)?;
/// assert!((line.intercept - 1.0).abs() < 1e-14 && (line.slope - 2.0).abs() < 1e-14);
/// # Ok::<(), stosszahl_analysis::Error>(())
/// ```
pub fn line(points: &[FitPoint]) -> Result<FittedLine, Error> {
    let points = usable(points, 2)?;
    let weight = |p: &FitPoint| (p.error * p.error).recip();
    let total: f64 = points.iter().map(weight).sum();
    let mean = |value: fn(&FitPoint) -> f64| {
        points.iter().map(|p| weight(p) * value(p)).sum::<f64>() / total
    };
    let [x, y] = [mean(|p| p.x), mean(|p| p.y)];
    let spread: f64 = points.iter().map(|p| weight(p) * (p.x - x).powi(2)).sum();
    if spread <= 0.0 {
        return Err(Error::FitImpossible {
            found: 1,
            needed: 2,
        });
    }
    let slope = points
        .iter()
        .map(|p| weight(p) * (p.x - x) * (p.y - y))
        .sum::<f64>()
        / spread;
    let chi_squared = points
        .iter()
        .map(|p| weight(p) * (p.y - y - slope * (p.x - x)).powi(2))
        .sum();
    Ok(FittedLine {
        intercept: y - slope * x,
        intercept_error: (1.0 / total + x * x / spread).sqrt(),
        slope,
        slope_error: spread.sqrt().recip(),
        chi_squared,
        degrees_of_freedom: points.len() - 2,
    })
}

/// Computes the limit of a quantity at vanishing step, cell size or simulator weight h, if its
/// error is `a h^order`: Richardson's extrapolation, by a line in h^order with the slope a.
///
/// # Errors
/// As [`line()`].
pub fn richardson(points: &[FitPoint], order: f64) -> Result<FittedLine, Error> {
    let raised: Vec<_> = points
        .iter()
        .map(|point| FitPoint {
            x: point.x.powf(order),
            ..*point
        })
        .collect();
    line(&raised)
}

/// Order of convergence that fits measured values best, with the limit at h = 0.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ConvergenceOrder {
    /// Order at which `limit + a h^order` fits best, searched from 0.1 to 6.
    pub value: f64,
    /// Range of the order in which chi-squared exceeds its minimum by at most one: one standard
    /// error. At the limits of the search the range is open.
    pub range: [f64; 2],
    /// Limit of the quantity at h = 0, fitted with the best order.
    pub limit: f64,
    /// Chi-squared of the fit with the best order; degrees of freedom are the number of values less
    /// three.
    pub chi_squared: f64,
}

/// Smallest and largest order of convergence that the search tries.
const ORDERS: [f64; 2] = [0.1, 6.0];

/// Fits limit, slope and order of `limit + a h^order`, by a scan of the order with [`richardson`]
/// at each.
///
/// # Errors
/// [`Error::FitImpossible`] with fewer than three usable values.
pub fn order(points: &[FitPoint]) -> Result<ConvergenceOrder, Error> {
    const STEPS: u32 = 5900;
    let points = usable(points, 3)?;
    let at = |step: u32| ORDERS[0] + (ORDERS[1] - ORDERS[0]) * f64::from(step) / f64::from(STEPS);
    let fits: Vec<_> = (0..=STEPS)
        .map(|step| richardson(&points, at(step)).map(|fit| (at(step), fit)))
        .collect::<Result<_, _>>()?;
    let mut best = fits[0];
    for &fit in &fits {
        if fit.1.chi_squared < best.1.chi_squared {
            best = fit;
        }
    }
    let within = fits
        .iter()
        .filter(|(_, fit)| fit.chi_squared <= best.1.chi_squared + 1.0);
    let mut range = [best.0; 2];
    for &(value, _) in within {
        range = [range[0].min(value), range[1].max(value)];
    }
    Ok(ConvergenceOrder {
        value: best.0,
        range,
        limit: best.1.intercept,
        chi_squared: best.1.chi_squared,
    })
}

#[cfg(test)]
#[allow(
    clippy::unwrap_used,
    reason = "in a test, an unexpected error is a failure"
)]
mod tests {
    use super::*;
    use crate::statistics::RunningMoments;
    use rand::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};
    use rand_xoshiro::Xoshiro256PlusPlus;

    /// Tests a line through two values: its errors are those of propagation by hand.
    #[test]
    fn errors_are_propagated() {
        let points =
            [(1.0, 2.0, 0.3), (3.0, 6.0, 0.4)].map(|(x, y, error)| FitPoint { x, y, error });
        let found = line(&points).unwrap();
        // Intercept (3 y1 - y2)/2, slope (y2 - y1)/2.
        assert!(found.intercept.abs() < 1e-14 && (found.slope - 2.0).abs() < 1e-14);
        assert!((found.intercept_error - (0.81_f64 + 0.16).sqrt() / 2.0).abs() < 1e-14);
        assert!((found.slope_error - 0.25).abs() < 1e-14);
        assert!(found.chi_squared < 1e-25 && found.degrees_of_freedom == 0);
    }

    /// Tests fits of synthetic values with known errors: limits scatter by the fitted error, and
    /// chi-squared has its mean. The bounds are 4.4 standard errors (false alarm 1e-5) of 2000
    /// trials: the mean to 0.1 of the error, the variance to 14 %.
    #[test]
    fn limits_scatter_as_they_say() {
        let mut stream = Xoshiro256PlusPlus::seed_from_u64(4);
        let [mut pulls, mut chi] = [RunningMoments::default(); 2];
        for _ in 0..2000 {
            let points: Vec<_> = [1.0, 0.5, 0.25, 0.125, 0.0625]
                .into_iter()
                .map(|x: f64| {
                    let noise: f64 = StandardNormal.sample(&mut stream);
                    let error = 0.01 + 0.01 * x;
                    FitPoint {
                        x,
                        y: 0.25 + 0.1 * x * x + error * noise,
                        error,
                    }
                })
                .collect();
            let fit = richardson(&points, 2.0).unwrap();
            pulls.add((fit.intercept - 0.25) / fit.intercept_error);
            chi.add(fit.chi_squared);
        }
        assert!(pulls.mean().unwrap().abs() < 4.4 / 2000.0_f64.sqrt());
        assert!((pulls.variance().unwrap() - 1.0).abs() < 4.4 * (2.0 / 2000.0_f64).sqrt());
        let deviation = (chi.mean().unwrap() - 3.0).abs();
        assert!(deviation < 4.4 * chi.standard_error().unwrap());
    }

    #[test]
    fn orders_are_found() {
        for known in [0.5, 1.0, 2.0, 4.0] {
            let points: Vec<_> = [1.0, 0.7, 0.5, 0.3]
                .into_iter()
                .map(|x: f64| FitPoint {
                    x,
                    y: 3.0 - 2.0 * x.powf(known),
                    error: 1e-3,
                })
                .collect();
            let found = order(&points).unwrap();
            // The scan has steps of 0.001.
            assert!((found.value - known).abs() < 6e-4, "{known}: {found:?}");
            assert!(found.range[0] < known && found.range[1] > known);
            assert!((found.limit - 3.0).abs() < 2e-3);
        }
    }

    #[test]
    fn useless_values_are_left_out() {
        let point = |x, y, error| FitPoint { x, y, error };
        let points = [
            point(1.0, 1.0, 0.1),
            point(2.0, f64::NAN, 0.1),
            point(3.0, 1.0, 0.0),
        ];
        let error = line(&points).unwrap_err();
        assert!(matches!(
            error,
            Error::FitImpossible {
                found: 1,
                needed: 2
            }
        ));
        assert!(line(&[point(1.0, 1.0, 0.1), point(1.0, 2.0, 0.1)]).is_err());
        assert!(order(&points).is_err());
    }
}
