//! Homogeneous cooling of equal disks and spheres: Haff's law, collisions, and how the velocity
//! distribution relaxes from a Maxwellian.
//!
//! The contact value chi is an argument, so that each equation of state can be used. Symbols are
//! those of [`stosszahl_model::equation_of_state`].

use std::f64::consts::PI;

/// Number of space dimensions of the formulas for disks, two.
const D: f64 = 2.0;

/// Fourth cumulant a2 = D<v^4>/((D + 2)<v^2>^2) - 1 of the homogeneous cooling state, first Sonine
/// order: van Noije & Ernst, Granular Matter 1, 57 (1998), doi:10.1007/s100350050009.
pub fn fourth_cumulant(dimension: usize, restitution: f64) -> f64 {
    let (d, r) = (dimension as f64, restitution);
    16.0 * (1.0 - r) * (1.0 - 2.0 * r * r)
        / (9.0 + 24.0 * d + (8.0 * d - 41.0) * r + 30.0 * r * r * (1.0 - r))
}

/// Fourth cumulant a2 of the homogeneous cooling state in the linearisation of Montanero & Santos,
/// Granular Matter 2, 53 (2000), doi:10.1007/s100350050035, which is closer to simulations where
/// dissipation is strong: `a2 = 16(1 - r)(1 - 2 r^2)/(25 + 24 D + (8 D - 57) r - 2 (1 - r) r^2)`.
pub fn fourth_cumulant_of_montanero_santos(dimension: usize, restitution: f64) -> f64 {
    let (d, r) = (dimension as f64, restitution);
    16.0 * (1.0 - r) * (1.0 - 2.0 * r * r)
        / (25.0 + 24.0 * d + (8.0 * d - 57.0) * r - 2.0 * r * r * (1.0 - r))
}

/// Haff's time `t_0` of equal disks in units of d/sqrt(T/m), without Sonine correction:
/// `1/t_0 = 2(1 - r^2) phi chi/sqrt(pi)`. Infinite for an elastic gas.
///
/// ```
/// // The case of Luding, Müller & McNamara (1998): 1/t_0 = 23.27 per second.
/// use stosszahl_model::equation_of_state::henderson;
/// use stosszahl_theory::cooling::haff_time;
/// let thermal_speed = 0.2047 / 2.0_f64.sqrt();
/// let rate = thermal_speed / 0.001 / haff_time(0.25, 0.8, henderson(0.25));
/// assert!((rate - 23.274).abs() < 0.001);
/// ```
pub fn haff_time(packing_fraction: f64, restitution: f64, contact_value: f64) -> f64 {
    PI.sqrt() / (2.0 * (1.0 - restitution * restitution) * packing_fraction * contact_value)
}

/// Haff's law with its Sonine correction: `T/T_0` at the time `time_over_haff`, in units of
/// [`haff_time`].
///
/// `T/T_0 = (1 + (1 + 3 a2/16) t/t_0)^-2`. A Maxwellian start relaxes to a2 within a few collisions
/// per particle; until then the law with the final a2 is off by less than 1e-3.
pub fn haff_law(time_over_haff: f64, fourth_cumulant: f64) -> f64 {
    (1.0 + (1.0 + 3.0 * fourth_cumulant / 16.0) * time_over_haff).powi(-2)
}

/// Collisions per particle in the homogeneous cooling state up to the time `t/t_0`:
/// `c = 2D/((1 - r^2)(1 + a2/4)) ln(1 + t/t_0)`.
pub fn haff_collisions(dimension: usize, restitution: f64, time_over_haff: f64) -> f64 {
    let a2 = fourth_cumulant(dimension, restitution);
    let rate = (1.0 - restitution * restitution) * (1.0 + a2 / 4.0);
    2.0 * dimension as f64 / rate * (1.0 + 3.0 * a2 / 16.0).mul_add(time_over_haff, 1.0).ln()
}

/// Rate at which a2 approaches its value in the cooling state, per collision of a particle, linear
/// in a2: `(1 + r) B/(16 D (D + 2))` with `B = 9 + 24 D + (8 D - 41) r + 30 r^2 (1 - r)`.
///
/// From `(D (D + 2)/4) da2/ds = (D + 2)(1 + a2) mu_2 - mu_4` with the moments of van Noije & Ernst,
/// Granular Matter 1, 57 (1998), `mu_2 = (1 - r^2)/2 (1 + 3 a2/16)` and `mu_4 = (1 - r^2)(D + 3/2 +
/// r^2)/2 + a2 [3 (1 - r^2)(10 D + 39 + 10 r^2)/64 + (1 + r)(D - 1)/2]`, and s counted in
/// collisions of a particle.
pub fn cumulant_relaxation(dimension: usize, restitution: f64) -> f64 {
    let (d, r) = (dimension as f64, restitution);
    let denominator = 9.0 + 24.0 * d + (8.0 * d - 41.0) * r + 30.0 * r * r * (1.0 - r);
    (1.0 + r) * denominator / (16.0 * d * (d + 2.0))
}

/// Exponent with which `a2 - a2*` of disks falls in powers of `1 + t/t_0`: the relaxation rate
/// times the `2 D/(1 - r^2)` collisions of a particle in which the thermal speed falls to 1/e.
fn cumulant_exponent(restitution: f64) -> f64 {
    cumulant_relaxation(2, restitution) * 2.0 * D / (1.0 - restitution * restitution)
}

/// Fourth cumulant a2 of cooling disks that were Maxwellian at time 0; time in units of Haff's
/// `t_0`. Inelastic gas.
pub fn relaxing_cumulant(restitution: f64, time_over_haff: f64) -> f64 {
    let exponent = cumulant_exponent(restitution);
    let left = (-exponent * time_over_haff.ln_1p()).exp();
    fourth_cumulant(2, restitution) * (1.0 - left)
}

/// Haff's law of disks that were Maxwellian at time 0, `T/T_0` at the time `t/t_0`, first order in
/// a2.
///
/// `1/sqrt(T)` grows at the rate `1 + 3 a2(t)/16` and a2 approaches its final value as
/// `(1 + t/t_0)^-kappa`, so
/// `sqrt(T_0/T) = 1 + t + (3 a2/16)[t - (1 - (1 + t)^(1 - kappa))/(kappa - 1)]`: for r = 0.8 at
/// most a thousandth off the law with the final a2. Inelastic gas.
///
/// ```
/// use stosszahl_theory::cooling::{fourth_cumulant, haff_law, relaxing_haff_law};
/// let law = relaxing_haff_law(0.8, 1.0);
/// assert!((law / haff_law(1.0, fourth_cumulant(2, 0.8)) - 1.0).abs() < 1e-3);
/// ```
pub fn relaxing_haff_law(restitution: f64, time_over_haff: f64) -> f64 {
    let fall = cumulant_exponent(restitution) - 1.0;
    let lag = -(-fall * time_over_haff.ln_1p()).exp_m1() / fall;
    let sonine = 3.0 / 16.0 * fourth_cumulant(2, restitution);
    (1.0 + time_over_haff + sonine * (time_over_haff - lag)).powi(-2)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn literature_values_of_cooling() {
        for (r, a2) in [(0.5, 0.0829), (0.6, 0.0387), (0.8, -0.0219), (0.9, -0.0269)] {
            assert!((fourth_cumulant(2, r) - a2).abs() < 5e-5, "r = {r}");
        }
        for (r, a2) in [(0.5, 0.0525), (0.8, -0.0126)] {
            assert!((fourth_cumulant(3, r) - a2).abs() < 5e-5, "r = {r}");
        }
        assert!((haff_law(1.0, fourth_cumulant(2, 0.8)) - 0.2510).abs() < 5e-5);
        assert!((haff_collisions(2, 0.8, 9.0) - 11.1 * 10.0_f64.ln()).abs() < 0.2);
    }

    /// Against `du/dt = 1 + 3 a2/16` and the relaxation of a2 over collisions, integrated by the
    /// midpoint rule: its error is third order in the step and below 1e-6 here.
    #[test]
    fn relaxation_solves_its_equations() {
        let r = 0.8;
        let a2 = fourth_cumulant(2, r);
        let rate = cumulant_relaxation(2, r) * 4.0 / (1.0 - r * r);
        let (mut u, mut cumulant, step) = (1.0, 0.0, 1e-4);
        for _ in 0..20_000 {
            // First order in a2: collisions are counted with Haff's law without it.
            let slope = |u: f64, c: f64| [1.0 + 3.0 / 16.0 * c, rate / u * (a2 - c)];
            let first = slope(u, cumulant);
            let middle = slope(u + 0.5 * step * first[0], cumulant + 0.5 * step * first[1]);
            u += step * middle[0];
            cumulant += step * middle[1];
        }
        // Terms of second order: the clock of the collisions runs 3 a2/16 = 0.4 % off where a2 is
        // 1e-3 from its end.
        assert!((relaxing_cumulant(r, 2.0) - cumulant).abs() < 1e-5);
        assert!((relaxing_haff_law(r, 2.0) * u * u - 1.0).abs() < 2e-5);
        // The fixed point of the two moments is the a2 of the cooling state, and their slope the
        // relaxation.
        for r in [0.3, 0.8, 0.95] {
            let q = 1.0 - r * r;
            let slope = 3.0 / 64.0 * q * (59.0 + 10.0 * r * r) + 0.5 * (1.0 + r);
            let balance = |a2: f64| {
                4.0 * (0.5 * q) * (1.0 + 19.0 / 16.0 * a2) - (0.5 * q * (3.5 + r * r) + slope * a2)
            };
            assert!(balance(fourth_cumulant(2, r)).abs() < 1e-14);
            let relaxation = 0.5 * (balance(0.0) - balance(1.0));
            assert!((cumulant_relaxation(2, r) / relaxation - 1.0).abs() < 1e-13);
        }
    }

    #[test]
    fn relaxation_takes_a_few_collisions() {
        assert!((1.0..3.0).contains(&(1.0 / cumulant_relaxation(2, 0.8))));
        assert_eq!(relaxing_haff_law(0.8, 0.0), 1.0);
        assert!(relaxing_cumulant(0.8, 0.0).abs() < 1e-18);
        let final_law = haff_law(10.0, fourth_cumulant(2, 0.8));
        assert!((relaxing_haff_law(0.8, 10.0) / final_law - 1.0).abs() < 1e-3);
    }
}
