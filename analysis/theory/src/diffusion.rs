//! Diffusion of equal disks by kinetic theory: decay of velocities, mean squared displacements and
//! coefficients of self-diffusion, in steady and in cooling gases.
//!
//! Units: diameter d, mass m and granular temperature T are one. The contact value chi is an
//! argument, so that each equation of state can be used.

use stosszahl_model::equation_of_state::collision_rate;

/// Ratio of the self-diffusion coefficient of elastic disks in three Sonine orders to that in first
/// order; two orders give 43/42.
pub const DIFFUSION_ORDERS: f64 = 1.027;

/// Rate at which disks forget their velocity, `nu = omega (1 + r)/2` in units of sqrt(T/m)/d. The
/// velocity correlation of a gas in a steady state begins to decay at this rate. The self-diffusion
/// coefficient in first Sonine order is `D = T/(m nu)` (Bodrova & Osinsky 2024 for mixtures in
/// three dimensions; here for equal disks).
///
/// In an elastic gas of disks the next two Sonine orders raise D by 43/42 and by 1.027.
///
/// ```
/// // Elastic disks: D = (d/(2 n d^2 chi)) sqrt(T/(pi m)).
/// let (phi, chi) = (0.1, stosszahl_model::equation_of_state::contact_value(0.1));
/// let n = 4.0 * phi / std::f64::consts::PI;
/// let d = 1.0 / stosszahl_theory::diffusion::velocity_decay(phi, chi, 1.0);
/// assert!((d * 2.0 * n * chi * std::f64::consts::PI.sqrt() - 1.0).abs() < 1e-14);
/// ```
pub fn velocity_decay(packing_fraction: f64, contact_value: f64, restitution: f64) -> f64 {
    0.5 * (1.0 + restitution) * collision_rate(packing_fraction, contact_value, 0.0)
}

/// Computes x - 1 + exp(-x), accurate for small x too.
fn delayed(x: f64) -> f64 {
    if x < 1e-3 {
        // The next term is below 1e-13 of the first.
        x * x * (0.5 - x * (1.0 / 6.0 - x * (1.0 / 24.0 - x / 120.0)))
    } else {
        x + (-x).exp_m1()
    }
}

/// Mean squared displacement \[length^2\] in a steady gas of disks at temperature over mass
/// `temperature`, whose velocities decay at the rate `decay` (see [`velocity_decay`]), after the
/// time `time`: `4 D (t - (1 - exp(-nu t))/nu)` with `D = T/(m nu)`. It is `2 (T/m) t^2` at first
/// and `4 D t` later.
pub fn steady_displacement(temperature: f64, decay: f64, time: f64) -> f64 {
    4.0 * temperature / (decay * decay) * delayed(decay * time)
}

/// Mean squared displacement in a gas of disks in the homogeneous cooling state, in units of
/// `(T_0/m) t_0^2`, after the time `time_over_haff` in units of Haff's time `t_0`:
/// `(4/beta) (l - (1 - exp(-beta l))/beta)` with `l = ln(1 + t/t_0)` and `beta = (1 + r)/(1 - r)`.
///
/// With `dl = dt/(t_0 + t)`, both the speed and the rate of its decay become constant: velocities
/// decay as `exp(-2 l/(1 - r))` and cooling slows all by `exp(-l)`, so relative to it they decay at
/// the rate beta. The gas spreads ever more slowly, as the logarithm of time. First Sonine order,
/// a2 left out.
pub fn cooling_displacement(restitution: f64, time_over_haff: f64) -> f64 {
    let beta = (1.0 + restitution) / (1.0 - restitution);
    4.0 / (beta * beta) * delayed(beta * time_over_haff.ln_1p())
}

/// Self-diffusion coefficient of elastic disks \[d sqrt(T/m)\], three Sonine orders:
/// `D = 1.027 (d/(2 n d^2 chi)) sqrt(T/(pi m))`.
pub fn self_diffusion(packing_fraction: f64, contact_value: f64) -> f64 {
    DIFFUSION_ORDERS / velocity_decay(packing_fraction, contact_value, 1.0)
}

/// Self-diffusion coefficient of the cooling gas, `T tau_v/m` at the present temperature \[d
/// sqrt(T/m)\], first Sonine order: velocities are forgotten at the rate `nu = omega (1 + r)/2`
/// while all of them shrink at `zeta/2`, so `1/tau_v = nu - zeta/2 = omega (1 + r)^2/4`. Bodrova &
/// Osinsky (2024) in three dimensions; here for disks.
pub fn cooling_diffusion(packing_fraction: f64, contact_value: f64, restitution: f64) -> f64 {
    let rate = collision_rate(packing_fraction, contact_value, 0.0);
    4.0 / (rate * (1.0 + restitution).powi(2))
}

#[cfg(test)]
mod tests {
    use stosszahl_model::equation_of_state::{contact_value, henderson};

    use super::*;
    use crate::cooling::haff_time;

    /// Against d<R.v>/dt = 2 T - nu sqrt(T) <R.v> and d<R^2>/dt = 2 <R.v> with Haff's T, integrated
    /// by the midpoint rule; its error is third order in the step and below 1e-6 here.
    #[test]
    fn displacements_solve_their_equations() {
        let (phi, r) = (0.2, 0.7);
        let chi = contact_value(phi);
        let (t0, decay) = (haff_time(phi, r, chi), velocity_decay(phi, chi, r));
        let temperature = |t: f64| (1.0 + t / t0).powi(-2);
        let (mut mean, mut square, mut t) = (0.0, 0.0, 0.0);
        let step = t0 * 1e-4;
        for _ in 0..30_000 {
            let slope = |t: f64, x: f64| 2.0 * temperature(t) - decay * temperature(t).sqrt() * x;
            let middle = mean + 0.5 * step * slope(t, mean);
            square += step * 2.0 * middle;
            mean += step * slope(t + 0.5 * step, middle);
            t += step;
        }
        let found = cooling_displacement(r, 3.0) * t0 * t0;
        assert!((square / found - 1.0).abs() < 1e-6, "{square} {found}");
        // Ballistic at first: 2 T t^2; and no jump where the series ends.
        assert!((steady_displacement(3.0, 2.0, 1e-9) / 6e-18 - 1.0).abs() < 1e-8);
        assert!((delayed(1e-3) / delayed(0.999_999_999e-3) - 1.0).abs() < 1e-8);
    }

    #[test]
    fn diffusion_agrees_with_the_velocity_decay() {
        let (phi, chi) = (0.25, henderson(0.25));
        let elastic = cooling_diffusion(phi, chi, 1.0);
        assert!((elastic * velocity_decay(phi, chi, 1.0) - 1.0).abs() < 1e-14);
        assert!((self_diffusion(phi, chi) / elastic - DIFFUSION_ORDERS).abs() < 1e-14);
        // nu - zeta/2 with zeta = (1 - r^2) omega/2.
        let r = 0.7;
        let rate = collision_rate(phi, chi, 0.0);
        let decay = velocity_decay(phi, chi, r) - (1.0 - r * r) * rate / 4.0;
        assert!((cooling_diffusion(phi, chi, r) * decay - 1.0).abs() < 1e-14);
    }
}
