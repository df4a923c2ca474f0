//! Transport in a gas of equal disks by Enskog's theory, and what it says about the cooling gas:
//! viscosities, self-diffusion, the shear instability, and how the velocity distribution relaxes
//! from a Maxwellian.
//!
//! Units: diameter d, mass m and granular temperature T are one, so viscosities come in sqrt(m T)/d
//! (in the plane), and diffusion in d sqrt(T/m). The contact value chi is an argument, so that each
//! equation of state can be used.
//!
//! Source of the inelastic coefficients: Garzó & Dufty, Phys. Rev. E 59, 5895 (1999),
//! doi:10.1103/PhysRevE.59.5895, for any dimension by Lutsko, Phys. Rev. E 72, 021306 (2005),
//! doi:10.1103/PhysRevE.72.021306, here for D = 2, first Sonine order. Elastic limit: Gass, J.
//! Chem. Phys. 54, 1898 (1971), doi:10.1063/1.1675116.

use std::f64::consts::{PI, TAU};

use crate::kinetic;

/// Shear viscosity of dilute elastic disks in first Sonine order, `eta_0 = sqrt(m T/pi)/(2 d)`, in
/// sqrt(m T)/d.
pub const DILUTE_VISCOSITY: f64 = 0.282_094_791_773_878_14;

/// Ratio of the viscosity of dilute elastic disks in all Sonine orders to that in first order (Gass
/// 1971).
pub const VISCOSITY_ORDERS: f64 = 1.022;

/// Ratio of the self-diffusion coefficient of elastic disks in three Sonine orders to that in first
/// order; two orders give 43/42.
pub const DIFFUSION_ORDERS: f64 = 1.027;

/// Number of space dimensions in all formulas of this module, two.
const D: f64 = 2.0;

/// Computes the cooling rate of the homogeneous gas, `zeta* = ((D + 2)/(4 D)) chi (1 - r^2)(1 + 3
/// a2/16)`, over that at which dilute elastic disks lose shear stress, `n T/eta_0`.
fn reduced_cooling(contact_value: f64, restitution: f64) -> f64 {
    let a2 = kinetic::fourth_cumulant(2, restitution);
    (D + 2.0) / (4.0 * D)
        * contact_value
        * (1.0 - restitution * restitution)
        * (1.0 + 3.0 * a2 / 16.0)
}

/// Bulk viscosity \[sqrt(m T)/d\], `((1 + r)/(2 D^2)) chi n^2 d^3 2 pi sqrt(m T/pi) (1 - a2/16)`:
/// in the plane `(8/pi) phi^2 chi (1 + r)(1 - a2/16) eta_0`. The dilute gas has none.
pub fn bulk_viscosity(packing_fraction: f64, contact_value: f64, restitution: f64) -> f64 {
    let a2 = kinetic::fourth_cumulant(2, restitution);
    let reduced = 8.0 / PI
        * packing_fraction.powi(2)
        * contact_value
        * (1.0 + restitution)
        * (1.0 - a2 / 16.0);
    reduced * DILUTE_VISCOSITY
}

/// Computes the kinetic part of the shear viscosity with its coupling to collisions, over `eta_0`.
/// `decay` is the rate at which shear stress decays besides by collisions, over `n T/eta_0`.
fn kinetic_viscosity(
    packing_fraction: f64,
    contact_value: f64,
    restitution: f64,
    fourth_cumulant: f64,
    decay: f64,
) -> f64 {
    let (phi, chi, r, a2) = (
        packing_fraction,
        contact_value,
        restitution,
        fourth_cumulant,
    );
    let relaxation =
        3.0 / (4.0 * D) * chi * (1.0 - r + 2.0 / 3.0 * D) * (1.0 + r) * (1.0 + 7.0 * a2 / 16.0);
    let streaming = 1.0 - (1.0 + r) * (1.0 - 3.0 * r) * phi * chi / (D + 2.0);
    let kinetic = streaming / (relaxation + decay);
    kinetic * (1.0 + 2.0 / (D + 2.0) * phi * chi * (1.0 + r))
}

/// Shear viscosity of the cooling or elastic gas of disks \[sqrt(m T)/d\], first Sonine order.
///
/// `eta = eta_0 {eta_k* [1 + (2/(D + 2)) phi chi (1 + r)] + (D/(D + 2)) gamma*}` in the plane, with
/// `eta_k* = [1 - (1/(D + 2))(1 + r)(1 - 3 r) phi chi]/(nu* - zeta*/2)`,
/// `nu* = (3/(4 D)) chi (1 - r + 2 D/3)(1 + r)(1 + 7 a2/16)` and the reduced bulk viscosity gamma*.
///
/// ```
/// use stosszahl_model::{kinetic::henderson, transport};
/// let eta = transport::shear_viscosity(0.25, henderson(0.25), 1.0) / transport::DILUTE_VISCOSITY;
/// assert!((eta - 1.4825).abs() < 5e-5);
/// ```
pub fn shear_viscosity(packing_fraction: f64, contact_value: f64, restitution: f64) -> f64 {
    let a2 = kinetic::fourth_cumulant(2, restitution);
    // Relative to the temperature, which falls, stress decays the less.
    let decay = -reduced_cooling(contact_value, restitution) / 2.0;
    let kinetic = kinetic_viscosity(packing_fraction, contact_value, restitution, a2, decay);
    DILUTE_VISCOSITY * kinetic
        + D / (D + 2.0) * bulk_viscosity(packing_fraction, contact_value, restitution)
}

/// Shear viscosity of elastic disks with [`VISCOSITY_ORDERS`] on its kinetic part \[sqrt(m T)/d\]:
/// the reference of elastic simulations of the Enskog equation. The collisional part has no orders
/// to sum.
pub fn elastic_viscosity(packing_fraction: f64, contact_value: f64) -> f64 {
    bath_viscosity(packing_fraction, contact_value, 1.0, 0.0, 0.0)
}

/// Shear viscosity of disks in a bath that keeps their temperature \[sqrt(m T)/d\], first Sonine
/// order with [`VISCOSITY_ORDERS`] on its kinetic part.
///
/// As [`shear_viscosity`], but the temperature is constant and a drag gamma, `drag`
/// \[sqrt(T/m)/d\], damps the velocities, so that stress decays at the rate `nu + 2 gamma` in place
/// of `nu - zeta/2`; gamma = 0 in white noise. Garzó & Montanero, Physica A 313, 336 (2002),
/// doi:10.1016/S0378-4371(02)00994-3 (white noise); Garzó, Chamorro & Vega Reyes, Phys. Rev. E 87,
/// 032201 (2013), doi:10.1103/PhysRevE.87.032201 (with drag).
pub fn bath_viscosity(
    packing_fraction: f64,
    contact_value: f64,
    restitution: f64,
    fourth_cumulant: f64,
    drag: f64,
) -> f64 {
    let (phi, chi, r) = (packing_fraction, contact_value, restitution);
    let decay = if drag > 0.0 {
        2.0 * drag * DILUTE_VISCOSITY / number_density(phi)
    } else {
        0.0
    };
    let kinetic = kinetic_viscosity(phi, chi, r, fourth_cumulant, decay);
    DILUTE_VISCOSITY * VISCOSITY_ORDERS * kinetic + D / (D + 2.0) * bulk_viscosity(phi, chi, r)
}

/// Returns the number density of disks times d^2, `4 phi/pi`.
pub fn number_density(packing_fraction: f64) -> f64 {
    4.0 * packing_fraction / PI
}

/// Rate at which a shear wave of an elastic gas decays, over k^2: the kinematic viscosity
/// `eta/(m n)` \[d sqrt(T/m)\].
pub fn kinematic_viscosity(packing_fraction: f64, contact_value: f64) -> f64 {
    elastic_viscosity(packing_fraction, contact_value) / number_density(packing_fraction)
}

/// Self-diffusion coefficient of elastic disks \[d sqrt(T/m)\], three Sonine orders:
/// `D = 1.027 (d/(2 n d^2 chi)) sqrt(T/(pi m))`.
pub fn self_diffusion(packing_fraction: f64, contact_value: f64) -> f64 {
    DIFFUSION_ORDERS / kinetic::velocity_decay(packing_fraction, contact_value, 1.0)
}

/// Self-diffusion coefficient of the cooling gas, `T tau_v/m` at the present temperature \[d
/// sqrt(T/m)\], first Sonine order: velocities are forgotten at the rate `nu = omega (1 + r)/2`
/// while all of them shrink at `zeta/2`, so `1/tau_v = nu - zeta/2 = omega (1 + r)^2/4`. Bodrova &
/// Osinsky (2024) in three dimensions; here for disks.
pub fn cooling_diffusion(packing_fraction: f64, contact_value: f64, restitution: f64) -> f64 {
    let rate = kinetic::collision_rate(packing_fraction, contact_value, 0.0);
    4.0 / (rate * (1.0 + restitution).powi(2))
}

/// Wave number times d below which shear modes of the cooling gas grow against its thermal speed,
/// `k_c^2 = rho zeta/(2 eta)`, that is `(k_c d)^2 = (32 phi^2/pi) zeta*/eta*`. Zero in an elastic
/// gas.
pub fn critical_wave_number(packing_fraction: f64, contact_value: f64, restitution: f64) -> f64 {
    let viscosity =
        shear_viscosity(packing_fraction, contact_value, restitution) / DILUTE_VISCOSITY;
    let cooling = reduced_cooling(contact_value, restitution);
    (32.0 / PI * packing_fraction.powi(2) * cooling / viscosity).sqrt()
}

/// Side of the smallest square box, over d, in which a shear mode can grow: `2 pi/k_c`. Infinite in
/// an elastic gas.
pub fn critical_length(packing_fraction: f64, contact_value: f64, restitution: f64) -> f64 {
    TAU / critical_wave_number(packing_fraction, contact_value, restitution)
}

/// Exponent with which the amplitude of a shear mode of the cooling gas grows over the thermal
/// speed, as a power of `1 + t/t_0`: `1 - (k/k_c)^2`.
pub fn shear_exponent(wave_number: f64, critical: f64) -> f64 {
    1.0 - (wave_number / critical).powi(2)
}

/// Energy of a shear mode over T after `logarithm = ln(1 + t/t_0)` of a cooling that began in
/// thermal equilibrium.
///
/// The scaled amplitude grows at `g = 1 - q`, `q = (k/k_c)^2`, per unit of the logarithm, and
/// viscous noise of the strength of the elastic gas feeds it: `dS/dl = 2 g S + 2 q`, so
/// `S = (exp(2 g l) - q)/(1 - q)`, and `1 + 2 l` at q = 1. (The true noise of the cooling state
/// differs from the elastic one by terms of order 1 - r.)
pub fn thermal_shear_energy(wave_number: f64, critical: f64, logarithm: f64) -> f64 {
    let exponent = shear_exponent(wave_number, critical);
    let growth = 2.0 * exponent * logarithm;
    // (exp(x) - 1)/g is 2 l (1 + x/2 + ...): finite at g = 0.
    let rise = if growth.abs() < 1e-8 {
        2.0 * logarithm
    } else {
        growth.exp_m1() / exponent
    };
    1.0 + rise
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
    kinetic::fourth_cumulant(2, restitution) * (1.0 - left)
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
/// use stosszahl_model::{kinetic, transport};
/// let law = transport::relaxing_haff_law(0.8, 1.0);
/// assert!((law / kinetic::haff_law(1.0, kinetic::fourth_cumulant(2, 0.8)) - 1.0).abs() < 1e-3);
/// ```
pub fn relaxing_haff_law(restitution: f64, time_over_haff: f64) -> f64 {
    let fall = cumulant_exponent(restitution) - 1.0;
    let lag = -(-fall * time_over_haff.ln_1p()).exp_m1() / fall;
    let sonine = 3.0 / 16.0 * kinetic::fourth_cumulant(2, restitution);
    (1.0 + time_over_haff + sonine * (time_over_haff - lag)).powi(-2)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kinetic::henderson;

    /// Published table of `L_c/d`, three digits (four above 1000), with Henderson's contact value.
    #[test]
    fn critical_lengths_are_those_of_the_table() {
        let restitutions = [0.99, 0.95, 0.9, 0.8, 0.7, 0.6];
        for (phi, lengths) in [
            (0.01, [1968.0, 897.0, 649.0, 477.0, 404.0, 363.0]),
            (0.05, [386.0, 176.0, 127.0, 92.7, 78.1, 69.8]),
            (0.1, [190.0, 86.1, 61.9, 45.0, 37.6, 33.4]),
            (0.25, [76.3, 34.3, 24.4, 17.3, 14.2, 12.3]),
            (0.4, [51.8, 23.1, 16.3, 11.4, 9.12, 7.76]),
            (0.5, [45.0, 20.0, 14.1, 9.74, 7.76, 6.56]),
            (0.7, [39.1, 17.4, 12.1, 8.37, 6.64, 5.58]),
        ] {
            for (r, known) in restitutions.into_iter().zip(lengths) {
                let found = critical_length(phi, henderson(phi), r);
                // Half a unit of the third digit is at most 0.5 %.
                assert!(
                    (found / known - 1.0_f64).abs() < 5.01e-3,
                    "phi = {phi}, r = {r}: {found} {known}"
                );
            }
        }
        assert!(critical_length(0.25, henderson(0.25), 1.0).is_infinite());
    }

    /// The elastic limit in closed form, `eta/eta_0 = 1/chi + 2 phi + (1 + 8/pi) phi^2 chi` (Gass),
    /// and its value.
    #[test]
    fn elastic_viscosity_is_that_of_gass() {
        for phi in [1e-6, 0.05, 0.25, 0.5] {
            let chi = henderson(phi);
            let known = 1.0 / chi + 2.0 * phi + (1.0 + 8.0 / PI) * phi * phi * chi;
            let found = shear_viscosity(phi, chi, 1.0) / DILUTE_VISCOSITY;
            assert!(
                (found / known - 1.0).abs() < 1e-14,
                "{phi}: {found} {known}"
            );
            let bulk = bulk_viscosity(phi, chi, 1.0) / DILUTE_VISCOSITY;
            assert!((bulk - 16.0 / PI * phi * phi * chi).abs() < 1e-14);
            let all = elastic_viscosity(phi, chi) / DILUTE_VISCOSITY;
            let orders = VISCOSITY_ORDERS * (found - 0.5 * bulk) + 0.5 * bulk;
            assert!((all / orders - 1.0).abs() < 1e-14);
        }
        assert!((DILUTE_VISCOSITY - 0.5 / PI.sqrt()).abs() < 1e-16);
        let chi = henderson(0.25);
        assert!((shear_viscosity(0.25, chi, 1.0) / DILUTE_VISCOSITY - 1.4825).abs() < 5e-5);
    }

    /// Where drag outruns collisions, stress decays at 2 gamma, and the dilute kinetic viscosity is
    /// n T/(2 gamma), without a trace of the collisions.
    #[test]
    fn strong_drag_sets_the_viscosity() {
        let (phi, drag) = (1e-6, 1.0);
        for r in [1.0, 0.8] {
            let found = bath_viscosity(phi, 1.0, r, 0.0, drag);
            let known = VISCOSITY_ORDERS * number_density(phi) / (2.0 * drag);
            assert!((found / known - 1.0).abs() < 1e-5, "{found} {known}");
        }
        let (phi, chi) = (0.25, henderson(0.25));
        let cooling = shear_viscosity(phi, chi, 0.8);
        let heated = bath_viscosity(phi, chi, 0.8, kinetic::fourth_cumulant(2, 0.8), 0.0);
        assert!(
            heated < cooling && heated > 0.9 * cooling,
            "{heated} {cooling}"
        );
    }

    #[test]
    fn diffusion_agrees_with_the_velocity_decay() {
        let (phi, chi) = (0.25, henderson(0.25));
        let elastic = cooling_diffusion(phi, chi, 1.0);
        assert!((elastic * kinetic::velocity_decay(phi, chi, 1.0) - 1.0).abs() < 1e-14);
        assert!((self_diffusion(phi, chi) / elastic - DIFFUSION_ORDERS).abs() < 1e-14);
        // nu - zeta/2 with zeta = (1 - r^2) omega/2.
        let r = 0.7;
        let rate = kinetic::collision_rate(phi, chi, 0.0);
        let decay = kinetic::velocity_decay(phi, chi, r) - (1.0 - r * r) * rate / 4.0;
        assert!((cooling_diffusion(phi, chi, r) * decay - 1.0).abs() < 1e-14);
    }

    /// Against `dS/dl = 2 g S + 2 q`, `du/dt = 1 + 3 a2/16` and the relaxation of a2 over
    /// collisions, integrated by the midpoint rule: its error is third order in the step and below
    /// 1e-6 here.
    #[test]
    fn growth_and_cooling_solve_their_equations() {
        for (k, critical) in [(0.1, 0.3), (0.3, 0.3), (0.5, 0.3)] {
            let (q, mut energy, step) = ((k / critical) * (k / critical), 1.0, 1e-4_f64);
            let slope = |energy: f64| 2.0 * (1.0 - q) * energy + 2.0 * q;
            for _ in 0..20_000 {
                let middle = energy + 0.5 * step * slope(energy);
                energy += step * slope(middle);
            }
            let found = thermal_shear_energy(k, critical, 2.0);
            assert!((found / energy - 1.0).abs() < 1e-6, "{k}: {found} {energy}");
        }
        let r = 0.8;
        let a2 = kinetic::fourth_cumulant(2, r);
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
            assert!(balance(kinetic::fourth_cumulant(2, r)).abs() < 1e-14);
            let relaxation = 0.5 * (balance(0.0) - balance(1.0));
            assert!((cumulant_relaxation(2, r) / relaxation - 1.0).abs() < 1e-13);
        }
    }

    #[test]
    fn relaxation_takes_a_few_collisions() {
        assert!((1.0..3.0).contains(&(1.0 / cumulant_relaxation(2, 0.8))));
        assert_eq!(relaxing_haff_law(0.8, 0.0), 1.0);
        assert!(relaxing_cumulant(0.8, 0.0).abs() < 1e-18);
        let final_law = kinetic::haff_law(10.0, kinetic::fourth_cumulant(2, 0.8));
        assert!((relaxing_haff_law(0.8, 10.0) / final_law - 1.0).abs() < 1e-3);
        assert!((kinetic::structure_factor_at_zero(0.25) - 0.3318).abs() < 3e-4);
    }
}
