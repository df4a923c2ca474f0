//! Sonine expansion for rough particles, whose velocities and spins are not Maxwellian.
//!
//! As in [`super`], with the polynomials `S_p(x) S_q(y)` of `x = m v^2/(2 T)` and `y = I w^2/(2
//! T_r)`, so that the correlation of the sizes of velocity and spin is followed, but not that of
//! their directions, which spheres also have. Generating functions have two variables for each
//! particle, (s, s') and (t, t'), and two for the moment, (u, u'). The normal part of a collision
//! is that of smooth particles. Of the tangential velocities `v_t`, and `w_t = R w x k` of the
//! surfaces, in units of T/m, a collision takes `eta g` and `(eta/q) g` with `g = v_1 - v_2 + w_1 +
//! w_2`. So with the variances `X = 1 - s`, `Y = z (1 - s')`, `z = T_r/(q T)`, `G = 2 - s - t + z
//! (2 - s' - t')`, `kappa = eta/q` and
//!
//! `E = (1 - u + u F_1)(1 - u' + u' F_2/z) - u u' F_3^2/z`, with `F_1 = X (1 - 2 eta) + eta^2 G`,
//! `F_2 = Y (1 - 2 kappa) + kappa^2 G` and `F_3 = eta kappa G - kappa X - eta Y`,
//!
//! the rate of change of `<S_p S_q>` is `n d^(D-1) chi Omega_D sqrt(T/(2 pi m))` times
//!
//! `J = W^(1/2) {E^((1-D)/2)/A - [S S']^((1-D)/2)/S} S'^(-(R-D+1)/2)`,
//!
//! with `S' = 1 - u' s'` and R rotations.

use stosszahl_model::InvalidValue;

use super::super::error::TheoryError;
use super::super::integrate::Integrator;
use super::super::rough::{RoughGas, Temperatures};
use super::orders::{TOLERANCE, check_orders, norms};
use super::series::{PowerSeries, Shape, Term, scaled, times};

/// Largest Sonine order for rough particles.
pub const MOST_ROUGH_ORDERS: usize = 3;

/// State of a gas of rough particles at one time: temperatures and fourth cumulants.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RoughMoment {
    /// Temperatures of translation and rotation \[energy\].
    pub temperatures: Temperatures,
    /// Fourth cumulants of velocities and of spins, and their correlation `<v^2 w^2>/(<v^2><w^2>) -
    /// 1`.
    pub cumulants: [f64; 3],
}

type Polynomial = Vec<Term<6>>;

const ONE: Term<6> = ([0; 6], 1.0);

/// Returns the polynomial term `factor` times one variable of the series: u, u', s, s', t or t'.
fn variable(axis: usize, factor: f64) -> Term<6> {
    let mut powers = [0; 6];
    powers[axis] = 1;
    (powers, factor)
}

/// Adds polynomials; the sum has one term for each power, the constant first.
fn sum(parts: &[&[Term<6>]]) -> Polynomial {
    let mut sum: Polynomial = vec![([0; 6], 0.0)];
    for &(powers, value) in parts.iter().copied().flatten() {
        match sum.iter_mut().find(|(known, _)| *known == powers) {
            Some((_, known)) => *known += value,
            None => sum.push((powers, value)),
        }
    }
    sum
}

/// Computes the collision kernel: changes of `<S_p S_q>`, as coefficients of the products of the
/// Sonine coefficients of both particles.
fn kernel(gas: &RoughGas, shape: Shape<6>, ratio: f64) -> PowerSeries {
    let [eta, q] = gas.surface;
    let (kappa, z) = (eta / q, ratio / q);
    let b = 0.5 * (1.0 + gas.restitution);
    let [u, v, s, r, t, w] = [0, 1, 2, 3, 4, 5].map(|axis| vec![variable(axis, 1.0)]);
    let less = |polynomial: &[Term<6>]| sum(&[&[ONE], &scaled(polynomial, -1.0)]);
    let (x, x_other) = (less(&s), less(&t));
    let (y, y_other) = (scaled(&less(&r), z), scaled(&less(&w), z));
    let normal = sum(&[&x, &x_other]);
    let all = sum(&[&normal, &y, &y_other]);
    let roots = {
        let lost = times(&u, &times(&x, &x_other));
        shape.power(&sum(&[&times(&normal, &less(&u)), &lost]), 0.5)
    };
    let a = sum(&[
        &less(&u),
        &times(&u, &scaled(&x, 1.0 - 2.0 * b)),
        &times(&u, &scaled(&normal, b * b)),
    ]);
    let first = sum(&[&scaled(&x, 1.0 - 2.0 * eta), &scaled(&all, eta * eta)]);
    let second = sum(&[&scaled(&y, 1.0 - 2.0 * kappa), &scaled(&all, kappa * kappa)]);
    let cross = sum(&[
        &scaled(&all, eta * kappa),
        &scaled(&x, -kappa),
        &scaled(&y, -eta),
    ]);
    let tangential = sum(&[
        &times(
            &sum(&[&less(&u), &times(&u, &first)]),
            &sum(&[&less(&v), &times(&v, &scaled(&second, 1.0 / z))]),
        ),
        &times(&times(&u, &v), &scaled(&times(&cross, &cross), -1.0 / z)),
    ]);
    let (same, same_spin) = (less(&times(&u, &s)), less(&times(&v, &r)));
    let share = 0.5 * (1.0 - gas.dimension as f64);
    let across = shape.power(&tangential, share);
    let found = shape.product(&across, &shape.product(&roots, &shape.power(&a, -1.0)));
    let before = shape.product(
        &shape.power(&same_spin, share),
        &shape.product(&roots, &shape.power(&same, share - 1.0)),
    );
    let change: PowerSeries = found.iter().zip(before).map(|(a, b)| a - b).collect();
    let rest = 0.5 * (gas.dimension as f64 - 1.0 - gas.rotations as f64);
    shape.product(&change, &shape.power(&same_spin, rest))
}

/// Differential equations of a gas of rough particles. Values are the logarithms of T and `T_r` and
/// the coefficients `a_pq` by rows, of which `a_10` and `a_01` stay zero.
struct System {
    gas: RoughGas,
    shape: Shape<6>,
    orders: usize,
    norms: [Vec<f64>; 2],
}

impl System {
    fn place(&self, p: usize, q: usize) -> usize {
        2 + p * (self.orders + 1) + q
    }

    fn slope(&self, values: &[f64], slope: &mut [f64]) {
        let (n, gas) = (self.orders + 1, &self.gas);
        let [t, r] = [values[0].exp(), values[1].exp()];
        let kernel = kernel(gas, self.shape, r / t);
        let a = &values[2..];
        // sqrt(2) stands in the kernel.
        let rate = gas.collision_rate(t) / std::f64::consts::SQRT_2;
        let size = n * n;
        let moment = |p: usize, q: usize| -> f64 {
            let begin = (p * n + q) * size * size;
            let rows = kernel[begin..begin + size * size].chunks(size).zip(a);
            let each = rows.map(|(row, own)| {
                let partners = row.iter().zip(a).map(|(value, other)| value * other);
                own * partners.sum::<f64>()
            });
            rate * each.sum::<f64>()
        };
        let degrees = [gas.dimension as f64, gas.rotations as f64];
        let changes = [
            -2.0 / degrees[0] * moment(1, 0),
            -2.0 / degrees[1] * moment(0, 1),
        ];
        slope.fill(0.0);
        slope[..2].copy_from_slice(&changes);
        for p in 0..n {
            for q in 0..n {
                if p + q < 2 && !(p == 1 && q == 1) {
                    continue;
                }
                let own = values[self.place(p, q)];
                let below = |p: usize, q: usize| own - values[self.place(p, q)];
                let mut change = moment(p, q) / (self.norms[0][p] * self.norms[1][q]);
                if p > 0 {
                    change -= changes[0] * p as f64 * below(p - 1, q);
                }
                if q > 0 {
                    change -= changes[1] * q as f64 * below(p, q - 1);
                }
                slope[self.place(p, q)] = change;
            }
        }
    }

    fn moment(&self, values: &[f64]) -> RoughMoment {
        let a = |p: usize, q: usize| {
            if p.max(q) <= self.orders {
                values[self.place(p, q)]
            } else {
                0.0
            }
        };
        RoughMoment {
            temperatures: Temperatures {
                translation: values[0].exp(),
                rotation: values[1].exp(),
            },
            cumulants: [a(2, 0), a(0, 2), a(1, 1)],
        }
    }
}

impl RoughGas {
    /// Computes the cooling of [`Self::cooling`] with Sonine expansions of velocities and spins,
    /// Maxwellian at time zero. The first order has the correlation of both magnitudes, but no
    /// fourth cumulants; three orders give temperatures to 0.3 %.
    ///
    /// # Errors
    /// [`TheoryError::Invalid`] if a temperature is not above zero, or the order is not from 1 to
    /// [`MOST_ROUGH_ORDERS`]; [`TheoryError::Integration`] if the integration fails before the last
    /// time.
    pub fn expand(
        &self,
        orders: usize,
        start: Temperatures,
        times: &[f64],
    ) -> Result<Vec<RoughMoment>, TheoryError> {
        check_orders(orders, MOST_ROUGH_ORDERS, "from 1 to 3")?;
        for value in [start.translation, start.rotation] {
            InvalidValue::unless_positive("temperature", value)?;
        }
        let degrees = [self.dimension, self.rotations];
        let system = System {
            gas: *self,
            shape: Shape([orders + 1; 6]),
            orders,
            norms: degrees.map(|degrees| norms(0.5 * degrees as f64 - 1.0, orders)),
        };
        let mut values = vec![0.0; 2 + (orders + 1) * (orders + 1)];
        (values[0], values[1], values[2]) = (start.translation.ln(), start.rotation.ln(), 1.0);
        let slope = |_: f64, y: &[f64], slope: &mut [f64]| system.slope(y, slope);
        let first = 0.01 / self.collision_rate(start.translation);
        let mut problem = Integrator::new(slope, 0.0, values, first, TOLERANCE);
        times
            .iter()
            .map(|&time| Ok(system.moment(problem.advance(time)?)))
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rough::tests::gas;
    use crate::{Component, ContactValues, MaxwellianMixture};
    use stosszahl_model::{Constant, Plane, Space, Volume};

    const START: Temperatures = Temperatures {
        translation: 1.0,
        rotation: 0.6,
    };

    /// Maxwellians begin to cool as the two-temperature theory says, in every order. Tolerance: the
    /// time is 1e-4 of a mean free time, and slopes change by as much.
    fn first_slopes<S: Space>() {
        for (restitution, beta) in [(0.6, 0.0), (0.9, -0.5), (1.0, 0.7)] {
            let gas = gas::<S>(restitution, beta);
            let time = 1e-4 / gas.collision_rate(1.0);
            let slopes = gas.slopes(START);
            for orders in 1..=MOST_ROUGH_ORDERS {
                let found = gas.expand(orders, START, &[time]).expect("smooth")[0].temperatures;
                let close = |change: f64, slope: f64| {
                    assert!(
                        (change / (slope * time) - 1.0).abs() < 1e-3,
                        "{change} {slope}"
                    );
                };
                close(found.translation - 1.0, slopes.translation);
                close(found.rotation - START.rotation, slopes.rotation);
            }
        }
    }

    #[test]
    fn maxwellians_begin_as_in_the_theory_of_two_temperatures() {
        first_slopes::<Volume>();
        first_slopes::<Plane>();
    }

    /// Smooth particles keep their spins and cool as without them. Tolerance: 1e-5, for some
    /// hundred integration steps with errors of at most 1e-6 each that largely cancel.
    #[test]
    fn smooth_grains_cool_as_without_spins() {
        let one = Component {
            mass: 1.0,
            diameter: 1.0,
            density: 0.1,
        };
        let law = Constant::new(0.6).expect("a coefficient");
        for (dimension, rough) in [(2, gas::<Plane>(0.6, -1.0)), (3, gas::<Volume>(0.6, -1.0))] {
            let smooth = MaxwellianMixture::new(dimension, vec![one], law, ContactValues::Dilute)
                .expect("a gas");
            let times = [3.0, 30.0, 300.0];
            let found = rough.expand(2, START, &times).expect("smooth");
            let expected = smooth.expand(2, &[1.0], &times).expect("smooth");
            for (found, expected) in found.iter().zip(expected) {
                let ratio = found.temperatures.translation / expected.temperatures[0];
                assert!((ratio - 1.0).abs() < 1e-5, "{ratio}");
                assert!((found.temperatures.rotation / START.rotation - 1.0).abs() < 1e-10);
                assert!((found.cumulants[0] - expected.fourth_cumulants[0]).abs() < 1e-5);
            }
        }
    }

    /// Perfectly rough elastic particles come to share their energy alike, with no cumulants, and
    /// lose none on the way.
    #[test]
    fn perfectly_rough_grains_come_to_equilibrium() {
        for (rough, degrees) in [
            (gas::<Plane>(1.0, 1.0), [2.0, 1.0]),
            (gas::<Volume>(1.0, 1.0), [3.0, 3.0]),
        ] {
            let times = [1.0, 5.0, 60.0].map(|time| time / rough.collision_rate(1.0));
            let found = rough.expand(3, START, &times).expect("smooth");
            let energy = |t: Temperatures| degrees[0] * t.translation + degrees[1] * t.rotation;
            for found in &found {
                assert!((energy(found.temperatures) / energy(START) - 1.0).abs() < 1e-5);
            }
            let end = found[2];
            let alike = end.temperatures.rotation / end.temperatures.translation;
            assert!((alike - 1.0).abs() < 1e-4, "{alike}");
            assert!(
                end.cumulants.iter().all(|cumulant| cumulant.abs() < 1e-4),
                "{end:?}"
            );
        }
    }

    #[test]
    fn impossible_orders_are_refused() {
        let gas = gas::<Plane>(0.9, 0.0);
        assert!(gas.expand(0, START, &[1.0]).is_err());
        assert!(gas.expand(MOST_ROUGH_ORDERS + 1, START, &[1.0]).is_err());
        let still = Temperatures {
            rotation: 0.0,
            ..START
        };
        assert!(gas.expand(2, still, &[1.0]).is_err());
    }
}
