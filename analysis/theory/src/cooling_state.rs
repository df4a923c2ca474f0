//! Homogeneous cooling state of a mixture, in which all temperatures fall in proportion:
//! temperature ratios, Haff's time and displacements in closed form.

use stosszahl_model::{InvalidValue, Restitution};

use super::error::TheoryError;
use super::integrate::{Integrator, Tolerance};
use super::mixture::MaxwellianMixture;

/// State of a mixture whose temperature ratios have become constant, so that
/// `T_k(t) = T_k (1 + t/tau_0)^-2`. Restitution must not depend on speed.
#[derive(Clone, Debug, PartialEq)]
pub struct CoolingState {
    dimension: usize,
    /// Temperature of each species at time zero \[energy\].
    pub temperatures: Vec<f64>,
    /// Haff's time `tau_0 = 2/xi` \[time\].
    pub time: f64,
    /// Relaxation time of the velocity of each species relative to cooling, `1/(nu_k - xi/2)`
    /// \[time\].
    pub relaxation: Vec<f64>,
    masses: Vec<f64>,
}

impl CoolingState {
    /// Computes the cooling state of a mixture at the mean temperature `mean` (by densities). It
    /// integrates `d ln T_k = -(xi_k - xi_1) ds` from equal temperatures until the ratios no longer
    /// change.
    ///
    /// # Errors
    /// [`TheoryError::Invalid`] if the gas does not cool, the mean is not above zero, or the
    /// ratios do not settle.
    pub fn at_temperature<R: Restitution>(
        mixture: &MaxwellianMixture<R>,
        mean: f64,
    ) -> Result<Self, TheoryError> {
        let count = mixture.components().len();
        InvalidValue::unless_positive("mean temperature", mean)?;
        let leader = mixture
            .components()
            .iter()
            .position(|component| component.density > 0.0)
            .unwrap_or(0);
        let mut now = vec![0.0; count];
        let mut rates = vec![0.0; count];
        let slope = |_: f64, y: &[f64], slope: &mut [f64]| {
            for (t, log) in now.iter_mut().zip(y) {
                *t = (log - y[leader]).exp();
            }
            for (k, rate) in rates.iter_mut().enumerate() {
                *rate = mixture.rates(k, &now).cooling;
            }
            for (change, rate) in slope.iter_mut().zip(&rates) {
                *change = rates[leader] - rate;
            }
        };
        let tolerance = Tolerance {
            relative: 0.0,
            absolute: 1e-12,
        };
        let scale = mixture.rates(leader, &vec![1.0; count]).cooling;
        let allowed = "above 0: an elastic or empty gas has no cooling state";
        InvalidValue::require(
            scale > 0.0 && scale.is_finite(),
            "cooling rate",
            scale,
            allowed,
        )?;
        let mut problem = Integrator::new(slope, 0.0, vec![0.0; count], 1e-3 / scale, tolerance);
        let mut before = vec![0.0; count];
        let mut span = 1.0 / scale;
        for _ in 0..200 {
            let end = problem.at() + span;
            let y = problem.advance(end)?;
            let moved = y
                .iter()
                .zip(&before)
                .map(|(y, before)| (y - before).abs())
                .fold(0.0, f64::max);
            if moved < 1e-9 {
                let raw: Vec<f64> = y.iter().map(|log| log.exp()).collect();
                let factor = mean / mixture.average(&raw);
                let temperatures = raw.iter().map(|t| t * factor).collect();
                return Ok(Self::from_temperatures(mixture, temperatures));
            }
            before.copy_from_slice(y);
            span *= 1.1;
        }
        let name = "change of temperature ratios in the last span";
        Err(InvalidValue::new(name, span, "none").into())
    }

    /// Creates the cooling state from given temperatures \[energy\], whose ratios must be those of
    /// the cooling state.
    pub fn from_temperatures<R: Restitution>(
        mixture: &MaxwellianMixture<R>,
        temperatures: Vec<f64>,
    ) -> Self {
        let leader = mixture
            .components()
            .iter()
            .position(|component| component.density > 0.0)
            .unwrap_or(0);
        let xi = mixture.rates(leader, &temperatures).cooling;
        let relaxation = (0..temperatures.len())
            .map(|k| 1.0 / (mixture.rates(k, &temperatures).velocity - 0.5 * xi))
            .collect();
        Self {
            dimension: mixture.dimension(),
            temperatures,
            time: 2.0 / xi,
            relaxation,
            masses: mixture.components().iter().map(|c| c.mass).collect(),
        }
    }

    /// Computes the prefactor `2 tau_0^2 D T_k/(m_k beta)` of displacements of species k, and
    /// `beta = tau_0/tau_v`.
    fn scale(&self, k: usize) -> (f64, f64) {
        let beta = self.time / self.relaxation[k];
        let thermal = self.dimension as f64 * self.temperatures[k] / self.masses[k];
        (2.0 * self.time * self.time * thermal / beta, beta)
    }

    /// Computes the mean squared displacement \[length^2\] of species k from time `start` over a
    /// time `lag`: `(2 tau_0^2 D T_k/(m_k beta)) (l - (1 - exp(-beta l))/beta)`, with `l = ln(1 +
    /// lag/(tau_0 + start))` and `beta = tau_0/tau_v` (Bodrova & Osinsky (2024), Eq. 22).
    pub fn displacement(&self, k: usize, start: f64, lag: f64) -> f64 {
        let (scale, beta) = self.scale(k);
        let l = (lag / (self.time + start)).ln_1p();
        let x = beta * l;
        // The difference of l and what it saturates to, without loss of digits for small x.
        let delayed = if x.abs() < 1e-3 {
            x * x * (0.5 - x * (1.0 / 6.0 - x * (1.0 / 24.0 - x / 120.0)))
        } else {
            x + (-x).exp_m1()
        };
        scale * delayed / beta
    }

    /// Computes the mean squared displacement \[length^2\] of species k over a lag, averaged over
    /// start times up to `total - lag`: `(1/(t - lag)) integral_0^(t - lag) <(R(s + lag) - R(s))^2>
    /// ds`, by the trapezoidal rule in `ln(tau_0 + s)`.
    pub fn time_averaged(&self, k: usize, lag: f64, total: f64) -> f64 {
        let span = total - lag;
        let steps = 4000;
        let end = (span / self.time).ln_1p();
        let mut sum = 0.0;
        for step in 0..=steps {
            let start = self.time * (end * f64::from(step) / f64::from(steps)).exp_m1();
            let weight = if step == 0 || step == steps { 0.5 } else { 1.0 };
            sum += weight * self.displacement(k, start, lag) * (self.time + start);
        }
        sum * end / f64::from(steps) / span
    }

    /// Computes the velocity autocorrelation of species k, `<v(0).v(t)> = (D T_k/m_k) (1 +
    /// t/tau_0)^(-tau_0/tau_v - 1)` \[length^2/time^2\].
    pub fn velocity_correlation(&self, k: usize, time: f64) -> f64 {
        let (_, beta) = self.scale(k);
        let thermal = self.dimension as f64 * self.temperatures[k] / self.masses[k];
        thermal * (1.0 + time / self.time).powf(-beta - 1.0)
    }
}
