//! Kinetic theory of inelastic hard disks (D = 2) and spheres (D = 3), against which the engines
//! are tested.
//!
//! Symbols: d diameter, m mass, n number density, phi packing fraction, r coefficient of
//! restitution, chi pair correlation at contact, T = m<v^2>/D granular temperature (an energy),
//! omega collisions per particle and time (one pair collision counts once for each partner).

use std::f64::consts::PI;

pub mod spheres;

/// Packing fraction of equal disks at close packing, pi/(2 sqrt 3).
pub const CLOSE_PACKING: f64 = 0.906_899_682_117_089_3;

/// Packing fraction of equal disks at random close packing, as used by Luding, Müller & McNamara
/// (1998).
pub const RANDOM_CLOSE_PACKING: f64 = 0.82;

/// Packing fraction at which the disordered fluid of equal hard disks begins to order, about 0.70
/// (Bernard & Krauth, Phys. Rev. Lett. 107, 155704 (2011), doi:10.1103/PhysRevLett.107.155704).
pub const FREEZING: f64 = 0.70;

/// Pair correlation of equal disks at contact, for packing fractions from 0 to close packing.
///
/// Luding, Phys. Rev. E 63, 042201 (2001), doi:10.1103/PhysRevE.63.042201: the fluid branch g4 =
/// (1 - 7 phi/16)/(1 - phi)^2 - (phi^3/16)/(8 (1 - phi)^4), which improves Henderson's first term,
/// joined at phi = 0.701 to the free-volume branch of the crystal. Within 0.1 % of simulations in
/// the fluid, about 1 % beyond. Infinite from close packing on.
///
/// ```
/// let chi = stosszahl_model::kinetic::contact_value(0.25);
/// assert!((chi - 1.58295).abs() < 1e-5);
/// ```
pub fn contact_value(packing_fraction: f64) -> f64 {
    let phi = packing_fraction;
    if phi >= CLOSE_PACKING {
        return f64::INFINITY;
    }
    let fluid = |phi: f64| henderson(phi) - phi.powi(3) / (128.0 * (1.0 - phi).powi(4));
    // The switch is below 1e-18 there, and the dense branch is singular at zero packing.
    if phi < 0.2 {
        return fluid(phi);
    }
    let gap = CLOSE_PACKING - phi;
    let dense = 2.0 * CLOSE_PACKING * (1.0 - 0.04 * gap + 3.25 * gap.powi(3)) / gap - 1.0;
    let share = 1.0 / (1.0 + ((0.701 - phi) / 0.0111).exp());
    let pressure = 2.0 * phi * fluid(phi);
    (pressure + share * (dense - pressure)) / (2.0 * phi)
}

/// Henderson's contact value of equal disks, (1 - 7 phi/16)/(1 - phi)^2 (Mol. Phys. 30, 971 (1975),
/// doi:10.1080/00268977500102511): the one that Luding, Müller & McNamara (1998) use for `t_0`.
pub fn henderson(packing_fraction: f64) -> f64 {
    (1.0 - 7.0 / 16.0 * packing_fraction) / (1.0 - packing_fraction).powi(2)
}

/// Factor by which the free volume of Luding, Müller & McNamara (1998) raises the collision rate,
/// 1/(1 - phi/0.82); infinite from random close packing on.
pub fn free_volume_factor(packing_fraction: f64) -> f64 {
    if packing_fraction >= RANDOM_CLOSE_PACKING {
        f64::INFINITY
    } else {
        1.0 / (1.0 - packing_fraction / RANDOM_CLOSE_PACKING)
    }
}

/// Contact value of a pair of species in a mixture, from the contact value chi of equal disks at
/// the same packing: `1/(1 - phi) + (chi - 1/(1 - phi)) 2 d_i d_j M_1/((d_i + d_j) M_2)` with the
/// moments M of the diameter. Santos, Yuste & López de Haro, Mol. Phys. 96, 1 (1999); with
/// Henderson's chi this is Jenkins & Mancini 1987.
pub fn mixture_contact_value(
    equal: f64,
    packing_fraction: f64,
    diameters: [f64; 2],
    moment_ratio: f64,
) -> f64 {
    let point = 1.0 / (1.0 - packing_fraction);
    let [i, j] = diameters;
    point + (equal - point) * 2.0 * i * j * moment_ratio / (i + j)
}

/// Computes the compressibility factor of a gas of inelastic disks, p/(nT) = 1 + (1 + r) phi chi.
pub fn compressibility_factor(packing_fraction: f64, restitution: f64) -> f64 {
    1.0 + (1.0 + restitution) * packing_fraction * contact_value(packing_fraction)
}

/// Structure factor of the elastic fluid of disks at zero wave number, S(0) = 1/(d(phi Z)/d phi).
///
/// The derivative is a central difference of width 1e-5, good to 1e-8.
pub fn structure_factor_at_zero(packing_fraction: f64) -> f64 {
    let pressure = |phi: f64| phi * compressibility_factor(phi, 1.0);
    let step = 1e-5_f64.min(packing_fraction / 2.0);
    2.0 * step / (pressure(packing_fraction + step) - pressure(packing_fraction - step))
}

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

/// Collisions per particle and time of equal disks,
/// omega = 2 sqrt(pi) n d chi sqrt(T/m)(1 - a2/16), in units of sqrt(T/m)/d:
/// the factor that multiplies sqrt(T/m)/d, with n d^2 = 4 phi/pi.
pub fn collision_rate(packing_fraction: f64, contact_value: f64, fourth_cumulant: f64) -> f64 {
    8.0 * packing_fraction / PI.sqrt() * contact_value * (1.0 - fourth_cumulant / 16.0)
}

/// Mean free path of equal disks over the diameter, pi/(8 sqrt(2) phi chi).
pub fn mean_free_path(packing_fraction: f64, contact_value: f64) -> f64 {
    PI / (8.0 * 2.0_f64.sqrt() * packing_fraction * contact_value)
}

/// Haff's time `t_0` of equal disks in units of d/sqrt(T/m), without Sonine correction:
/// `1/t_0 = 2(1 - r^2) phi chi/sqrt(pi)`. Infinite for an elastic gas.
///
/// ```
/// // The case of Luding, Müller & McNamara (1998): 1/t_0 = 23.27 per second.
/// use stosszahl_model::kinetic::{haff_time, henderson};
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

/// Rate at which disks forget their velocity, `nu = omega (1 + r)/2` in units of sqrt(T/m)/d. The
/// velocity correlation of a gas in a steady state begins to decay at this rate. The self-diffusion
/// coefficient in first Sonine order is `D = T/(m nu)` (Bodrova & Osinsky 2024 for mixtures in
/// three dimensions; here for equal disks).
///
/// In an elastic gas of disks the next two Sonine orders raise D by 43/42 and by 1.027.
///
/// ```
/// // Elastic disks: D = (d/(2 n d^2 chi)) sqrt(T/(pi m)).
/// let (phi, chi) = (0.1, stosszahl_model::kinetic::contact_value(0.1));
/// let n = 4.0 * phi / std::f64::consts::PI;
/// let d = 1.0 / stosszahl_model::kinetic::velocity_decay(phi, chi, 1.0);
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Ten-term virial series of hard disks (as quoted with the bar of the equation of state); the
    /// fluid branch claims 0.1 %.
    #[test]
    fn contact_value_matches_the_virial_series_and_the_dense_branch() {
        for (phi, z, tolerance) in [
            (0.1, 1.236_144, 1e-4),
            (0.25, 1.791_574, 3e-4),
            (0.5, 4.107, 1e-3),
        ] {
            let found = compressibility_factor(phi, 1.0);
            assert!((found / z - 1.0).abs() < tolerance, "phi = {phi}: {found}");
        }
        // Values of the published global equation of state.
        for (phi, z) in [(0.72, 10.31), (0.75, 11.68), (0.80, 16.96)] {
            let found = compressibility_factor(phi, 1.0);
            assert!((found - z).abs() < 0.02, "phi = {phi}: {found}");
        }
        assert!(contact_value(CLOSE_PACKING).is_infinite());
        assert!((contact_value(0.0) - 1.0).abs() < 1e-15);
    }

    #[test]
    fn literature_values_of_cooling() {
        for (r, a2) in [(0.5, 0.0829), (0.6, 0.0387), (0.8, -0.0219), (0.9, -0.0269)] {
            assert!((fourth_cumulant(2, r) - a2).abs() < 5e-5, "r = {r}");
        }
        for (r, a2) in [(0.5, 0.0525), (0.8, -0.0126)] {
            assert!((fourth_cumulant(3, r) - a2).abs() < 5e-5, "r = {r}");
        }
        assert!((structure_factor_at_zero(0.25) - 0.3318).abs() < 3e-4);
        assert!((haff_law(1.0, fourth_cumulant(2, 0.8)) - 0.2510).abs() < 5e-5);
        assert!((haff_collisions(2, 0.8, 9.0) - 11.1 * 10.0_f64.ln()).abs() < 0.2);
        // omega = 4 (Z - 1)/sqrt(pi) with d = m = T = 1.
        let chi = contact_value(0.25);
        let omega = collision_rate(0.25, chi, 0.0);
        assert!(
            (omega - 4.0 * (compressibility_factor(0.25, 1.0) - 1.0) / PI.sqrt()).abs() < 1e-14
        );
    }

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
    fn mixture_reduces_to_equal_disks() {
        assert!((mixture_contact_value(1.58, 0.25, [2.0, 2.0], 0.5) - 1.58).abs() < 1e-15);
    }
}
