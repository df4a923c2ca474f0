//! Adaptive Runge-Kutta integrator of ordinary differential equations, by the embedded pair of
//! Dormand & Prince.

use super::error::TheoryError;

/// Error allowed in each integration step: relative and absolute.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tolerance {
    /// Relative tolerance, as a share of the value.
    pub relative: f64,
    /// Absolute tolerance, in the units of the integrated values.
    pub absolute: f64,
}

/// Numbers of accepted and rejected steps of an integration: a machine-independent measure of work.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct IntegrationWork {
    /// Number of accepted integration steps.
    pub steps: u64,
    /// Number of rejected integration steps, whose error was too large.
    pub rejected: u64,
}

/// Largest number of steps in one call of `advance`.
const STEPS: u64 = 10_000_000;

/// Coefficients of Dormand & Prince, J. Comput. Appl. Math. 6, 19 (1980),
/// doi:10.1016/0771-050X(80)90013-3. First the nodes, then the stages (the last row is the
/// fifth-order solution), then its difference from the fourth-order one.
const NODES: [f64; 7] = [0.0, 0.2, 0.3, 0.8, 8.0 / 9.0, 1.0, 1.0];
const STAGES: [[f64; 6]; 7] = [
    [0.0; 6],
    [0.2, 0.0, 0.0, 0.0, 0.0, 0.0],
    [3.0 / 40.0, 9.0 / 40.0, 0.0, 0.0, 0.0, 0.0],
    [44.0 / 45.0, -56.0 / 15.0, 32.0 / 9.0, 0.0, 0.0, 0.0],
    [
        19372.0 / 6561.0,
        -25360.0 / 2187.0,
        64448.0 / 6561.0,
        -212.0 / 729.0,
        0.0,
        0.0,
    ],
    [
        9017.0 / 3168.0,
        -355.0 / 33.0,
        46732.0 / 5247.0,
        49.0 / 176.0,
        -5103.0 / 18656.0,
        0.0,
    ],
    [
        35.0 / 384.0,
        0.0,
        500.0 / 1113.0,
        125.0 / 192.0,
        -2187.0 / 6784.0,
        11.0 / 84.0,
    ],
];
const DIFFERENCE: [f64; 7] = [
    71.0 / 57600.0,
    0.0,
    -71.0 / 16695.0,
    71.0 / 1920.0,
    -17253.0 / 339_200.0,
    22.0 / 525.0,
    -1.0 / 40.0,
];

/// Adaptive integrator of an initial value problem `dy/dx = slope(x, y)`.
///
/// The embedded pair of Dormand & Prince, orders 5 and 4. A step is kept if the largest of the
/// errors over `absolute + relative |y|` is at most one, and the next one has `0.9 error^(-1/5)` of
/// its length.
pub struct Integrator<F> {
    slope: F,
    tolerance: Tolerance,
    x: f64,
    y: Vec<f64>,
    step: f64,
    slopes: [Vec<f64>; 7],
    trial: Vec<f64>,
    fresh: bool,
    work: IntegrationWork,
}

impl<F: FnMut(f64, &[f64], &mut [f64])> Integrator<F> {
    /// Creates the integration of `dy/dx = slope(x, y)` from the initial values `y` at `x`; `first`
    /// is the length of the first step tried.
    pub fn new(slope: F, x: f64, y: Vec<f64>, first: f64, tolerance: Tolerance) -> Self {
        let zeros = vec![0.0; y.len()];
        Self {
            slope,
            tolerance,
            x,
            step: first,
            slopes: std::array::from_fn(|_| zeros.clone()),
            trial: zeros,
            y,
            fresh: true,
            work: IntegrationWork::default(),
        }
    }

    /// Returns the current values y.
    pub fn values(&self) -> &[f64] {
        &self.y
    }

    /// Returns the current value of the independent variable x.
    pub fn at(&self) -> f64 {
        self.x
    }

    /// Returns the numbers of accepted and rejected steps so far.
    pub fn work(&self) -> IntegrationWork {
        self.work
    }

    /// Integrates up to x = `end` and returns the values there.
    ///
    /// # Errors
    /// [`TheoryError::Integration`] if a step falls below the resolution of x, values are no longer
    /// finite, or ten million steps were made.
    pub fn advance(&mut self, end: f64) -> Result<&[f64], TheoryError> {
        while self.x < end {
            let rest = end - self.x;
            let whole = self.step < rest;
            let step = if whole { self.step } else { rest };
            let error = self.try_step(step);
            let lost = |x: f64| TheoryError::Integration { at: x, step };
            if self.work.steps + self.work.rejected > STEPS {
                return Err(lost(self.x));
            }
            if error <= 1.0 {
                self.work.steps += 1;
                self.x = if whole { self.x + step } else { end };
                std::mem::swap(&mut self.y, &mut self.trial);
                // The last stage is the first of the next step.
                self.slopes.swap(0, 6);
                let factor = (0.9 * error.powf(-0.2)).clamp(0.2, 5.0);
                // A step cut short by the end says nothing against the longer one.
                self.step = (step * factor).max(if whole { 0.0 } else { self.step });
            } else {
                self.work.rejected += 1;
                let factor = if error.is_finite() {
                    (0.9 * error.powf(-0.2)).clamp(0.1, 0.9)
                } else {
                    0.1
                };
                self.step = step * factor;
                if self.step <= self.x.abs() * f64::EPSILON || self.step < f64::MIN_POSITIVE {
                    return Err(lost(self.x));
                }
            }
        }
        Ok(&self.y)
    }

    /// Tries an integration step: stores its result in `trial` and returns its error over the
    /// tolerance.
    fn try_step(&mut self, step: f64) -> f64 {
        let count = self.y.len();
        if self.fresh {
            let [first, ..] = &mut self.slopes;
            (self.slope)(self.x, &self.y, first);
            self.fresh = false;
        }
        for stage in 1..7 {
            for index in 0..count {
                let sum: f64 = STAGES[stage][..stage]
                    .iter()
                    .zip(&self.slopes)
                    .map(|(weight, slope)| weight * slope[index])
                    .sum();
                self.trial[index] = self.y[index] + step * sum;
            }
            let x = self.x + NODES[stage] * step;
            (self.slope)(x, &self.trial, &mut self.slopes[stage]);
        }
        let mut largest = 0.0_f64;
        for index in 0..count {
            let error: f64 = DIFFERENCE
                .iter()
                .zip(&self.slopes)
                .map(|(weight, slope)| weight * slope[index])
                .sum();
            let size = self.y[index].abs().max(self.trial[index].abs());
            let allowed = self.tolerance.absolute + self.tolerance.relative * size;
            let ratio = (step * error).abs() / allowed;
            // NaN must not be lost, as `max` would do.
            if ratio.is_nan() {
                return ratio;
            }
            if ratio > largest {
                largest = ratio;
            }
        }
        largest
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FINE: Tolerance = Tolerance {
        relative: 1e-10,
        absolute: 1e-14,
    };

    /// The oscillator and a stiff-ish decay over many orders of time, whose solutions are known.
    /// The error of a step is controlled, so the global one is a modest multiple of it: a factor
    /// 100 is allowed.
    #[test]
    fn known_solutions_are_met_to_the_tolerance() {
        let mut circle = Integrator::new(
            |_, y: &[f64], slope: &mut [f64]| {
                slope[0] = y[1];
                slope[1] = -y[0];
            },
            0.0,
            vec![0.0, 1.0],
            0.1,
            FINE,
        );
        for end in [1.0, 2.5, 10.0] {
            let y = circle.advance(end).expect("smooth");
            assert!((y[0] - end.sin()).abs() < 1e-8);
            assert!((y[1] - end.cos()).abs() < 1e-8);
        }
        let mut haff = Integrator::new(
            |_, y: &[f64], slope: &mut [f64]| slope[0] = -2.0 * y[0].powf(1.5),
            0.0,
            vec![1.0],
            1e-3,
            Tolerance {
                relative: 1e-10,
                absolute: 0.0,
            },
        );
        let y = haff.advance(1e6).expect("smooth")[0];
        assert!((y * (1.0 + 1e6_f64).powi(2) - 1.0).abs() < 1e-8, "{y}");
        // Steps grow with time: an order of magnitude takes about as many wherever it lies.
        assert!(haff.work().steps < 2000, "{:?}", haff.work());
    }

    /// Fifth order: a tolerance lower by 1e5 takes ten times the steps, and the error follows the
    /// tolerance.
    #[test]
    fn the_order_is_five() {
        let steps = |relative| {
            let mut problem = Integrator::new(
                |x: f64, _: &[f64], slope: &mut [f64]| slope[0] = x.cos(),
                0.0,
                vec![1.0],
                0.1,
                Tolerance {
                    relative,
                    absolute: relative,
                },
            );
            let found = problem.advance(20.0).expect("smooth")[0];
            assert!((found - 1.0 - 20.0_f64.sin()).abs() < 100.0 * relative);
            problem.work().steps as f64
        };
        let ratio = steps(1e-11) / steps(1e-6);
        assert!((7.0..13.0).contains(&ratio), "{ratio}");
    }

    #[test]
    fn a_singularity_is_refused() {
        let mut blow = Integrator::new(
            |_, y: &[f64], slope: &mut [f64]| slope[0] = y[0] * y[0],
            0.0,
            vec![1.0],
            0.1,
            FINE,
        );
        assert!(blow.advance(2.0).is_err());
    }
}
