//! Homogeneous mixtures whose velocities are not Maxwellian: Sonine expansions of any order.
//!
//! The velocities of species k are `f_k = M_k sum_p a_kp S_p(x)`, with the Maxwellian M of a
//! reference temperature T, `x = m v^2/(2 T)` and Laguerre's polynomials `S_p = L_p^(D/2 - 1)`.
//! Their correlation with displacements, `h_k(v) = <R delta(v - v_k)>`, is
//! `M_k v sum_p b_kp L_p^(D/2)(x)`. Cut after some orders, Boltzmann's equation becomes ordinary
//! differential equations for T, a and b, whose coefficients are all known in closed form:
//!
//! Generating functions turn polynomials into Maxwellians, `sum_p s^p S_p(x) M(T) = M(T (1 - s))`
//! and `sum_p u^p S_p(x) = (1 - u)^(-D/2) exp(-x u/(1 - u))`, so that one Gaussian integral J(u, s,
//! t) over a collision, with the temperatures `T_1 (1 - s)` and `T_2 (1 - t)`, has all coefficients
//! as those of its power series. With the variances of a component of the velocities
//! `Y = (1 - s) T_1/m_1` and `Z = (1 - t) T_2/m_2`, `V = Y + Z`, the part
//! `beta = (1 + e) m_2/(m_1 + m_2)` of the normal velocity that a collision takes, `S = 1 - u s`,
//! `W = (1 - u) V + u Y Z m_1/T_1` and `A = 1 - u + u ((1 - s)(1 - 2 beta) + beta^2 V m_1/T_1)`,
//! the rate of change of `<S_p>` by species 2 is `n_2 d^(D-1) chi Omega_D/sqrt(2 pi)` times
//!
//! `J = S^((1-D)/2) W^(1/2) (1/A - 1/S)`,
//!
//! and that of `<R . v L_p^(D/2)>`, with h in place of f, the same times
//!
//! `(T_1/m_1) S^((1-D)/2) {(D - 1) W^(1/2) (1/A - 1/S)/S + [Z/A + 2 (Y - beta V)(1 - u + beta u Z
//! m_1/T_1)/A^2 - Z/S - 2 Y (1 - u)/S^2]/W^(1/2)}`.
//!
//! Where restitution depends on the approach speed g, `W/A` and `2 (W/A)^2` stand for the integrals
//! over speeds of `g exp(-g^2 A(g)/(2 W))` and of `g^3` with the same, by quadrature. That Sonine
//! coefficients of collisions follow from generating functions is classical (Chapman & Cowling, The
//! Mathematical Theory of Non-Uniform Gases, 1970, chapter 9); the closed form for dissipative
//! pairs of any masses in two and three dimensions is derived here.
//!
//! The first order is that of [`MaxwellianMixture::evolve`], and the second has the fourth cumulant
//! of van Noije & Ernst (1998), but for its terms of second degree. From the third on, x refers to
//! a temperature somewhat above that of the species: tails of dissipative gases are heavier than
//! Gaussian ones. Coefficients about the temperature itself alternate and soon grow, by `0.053,
//! 0.045, 0.049, 0.047, 0.048` for the fourth cumulant of spheres at restitution 0.5; about 1.23
//! times it they settle at 0.0476. `<x>` is fixed by `a_1` then, `T_k = (1 - a_1) T`.

use stosszahl_model::{InvalidValue, Restitution};

use super::error::TheoryError;
use super::integrate::Integrator;
use super::mixture::{MaxwellianMixture, Moment};
use kernel::{Loss, MomentKernel};
use orders::{TOLERANCE, check_orders, norms};
use series::Shape;

mod kernel;
mod orders;
mod rough;
mod series;

pub use rough::{MOST_ROUGH_ORDERS, RoughMoment};

/// Largest order of the Sonine expansion.
pub const MOST_ORDERS: usize = 12;

/// Coefficient `a_1` of the shifted reference temperature, for collisions that take all normal
/// velocity. In other gases it is multiplied by the share of the normal energy that collisions
/// take.
const SHIFT: f64 = 0.25;

/// Lowest Sonine order at which the reference temperature is shifted. At lower orders, the error of
/// truncation outweighs the gain.
const SHIFTED: usize = 3;

/// Number of start times of displacements, for averages over start times.
const STARTS: usize = 40;
/// Number of quadrature points of the integral over start times.
const POINTS: u32 = 1000;

/// Interpolates between values at whole numbers by the cubic through the four nearest.
fn interpolate_cubic(values: &[f64], at: f64) -> f64 {
    let first = (at.floor().max(1.0) as usize - 1).min(values.len() - 4);
    let x = at - first as f64;
    let [a, b, c, d] = [0, 1, 2, 3].map(|n| x - f64::from(n));
    let weights = [
        -b * c * d / 6.0,
        a * c * d / 2.0,
        -a * b * d / 2.0,
        a * b * c / 6.0,
    ];
    weights
        .iter()
        .zip(&values[first..])
        .map(|(w, value)| w * value)
        .sum()
}

/// Layout of the integrated values of one species: ln T, `<R^2>`, collisions, then `a_2 ...`, `B_0
/// ...` and `K_0 ...`, the moments `<R . v L_p>` and `<v(0) . v L_p>`. Lengths and times are in
/// units of `sqrt(D T_k(0)/m_k)` and the shortest mean free time.
#[derive(Clone, Copy, Debug)]
struct Layout {
    orders: usize,
    /// Sonine coefficient `a_1` of the species, constant in time.
    shift: f64,
}

const LOGARITHM: usize = 0;
const DISPLACEMENT: usize = 1;
const COLLISIONS: usize = 2;

impl Layout {
    fn len(self) -> usize {
        2 + 3 * self.orders
    }

    /// Returns the Sonine coefficient `a_p`; zero beyond the orders kept.
    fn coefficient(self, values: &[f64], p: usize) -> f64 {
        match p {
            0 => 1.0,
            1 => self.shift,
            p if p <= self.orders => values[1 + p],
            _ => 0.0,
        }
    }

    fn displaced(self) -> usize {
        2 + self.orders
    }

    fn kept(self) -> usize {
        2 + 2 * self.orders
    }

    /// Returns the temperature of the species over its reference temperature, `1 - a_1`.
    fn ratio(self) -> f64 {
        1.0 - self.shift
    }

    /// Computes the fourth cumulant of the species: `<x^2>` over `<x^2>` of a Maxwellian of its
    /// temperature, less 1.
    fn fourth_cumulant(self, values: &[f64]) -> f64 {
        if self.orders < 2 {
            return 0.0;
        }
        let square = 1.0 - 2.0 * self.shift + self.coefficient(values, 2);
        square / self.ratio().powi(2) - 1.0
    }
}

/// Largest number of species for which an expansion takes some seconds at most, with its order:
/// first for constant restitution, then for restitution that depends on speed.
const AFFORDABLE: [[(usize, usize); 5]; 2] = [
    [(3, 6), (4, 5), (6, 4), (10, 3), (16, 2)],
    [(1, 5), (2, 4), (3, 4), (4, 3), (6, 2)],
];

impl<R: Restitution> MaxwellianMixture<R> {
    /// Returns the largest number of Sonine orders whose integration takes some seconds at most: 6
    /// for three species, 1 for many.
    pub fn affordable_orders(&self) -> usize {
        let affordable = AFFORDABLE[usize::from(!self.is_constant())];
        let count = self.components().len();
        let first = affordable.into_iter().find(|&(most, _)| count <= most);
        first.map_or(1, |(_, orders)| orders)
    }

    /// Computes the states of the mixture at given times: by [`Self::evolve`] for one Sonine order,
    /// by [`Self::expand`] for more.
    ///
    /// # Errors
    /// As [`Self::evolve`] and [`Self::expand`].
    pub fn solve(
        &self,
        orders: usize,
        temperatures: &[f64],
        times: &[f64],
    ) -> Result<Vec<Moment>, TheoryError> {
        if orders == 1 {
            self.evolve(temperatures, times)
        } else {
            self.expand(orders, temperatures, times)
        }
    }

    /// Computes the states of [`Self::evolve`] with velocities expanded to the given order in
    /// Sonine polynomials. Order one is for Maxwellians whose velocities are forgotten
    /// exponentially, order two has fourth cumulants too, and so on. The difference to the order
    /// below shows how far the expansion can be trusted.
    ///
    /// All velocities are Maxwellian at time zero.
    ///
    /// # Errors
    /// [`TheoryError`] if a temperature is not above zero, the numbers differ, the order is not
    /// from 1 to [`MOST_ORDERS`], or the integration fails, as it does where an expansion does not
    /// converge.
    pub fn expand(
        &self,
        orders: usize,
        temperatures: &[f64],
        times: &[f64],
    ) -> Result<Vec<Moment>, TheoryError> {
        let system = self.system(orders, temperatures)?;
        let mut problem = system.problem(0.0, system.start(temperatures));
        times
            .iter()
            .map(|&time| Ok(system.moment(time, problem.advance(time)?)))
            .collect()
    }

    /// Computes mean squared displacements by species and lag, averaged over start times up to
    /// `total` less the lag: `(1/(t - lag)) integral_0^(t - lag) <(R(s + lag) - R(s))^2> ds`. Lags
    /// do not fall. Velocities are Maxwellian at time zero and expanded as in [`Self::expand`].
    ///
    /// Displacements are followed from 40 starts and their logarithms interpolated in the logarithm
    /// of time.
    ///
    /// # Errors
    /// As [`Self::expand`]; [`TheoryError::Invalid`] unless all lags are above zero, below
    /// `total`, and do not fall.
    pub fn time_averaged(
        &self,
        orders: usize,
        temperatures: &[f64],
        lags: &[f64],
        total: f64,
    ) -> Result<Vec<Vec<f64>>, TheoryError> {
        let mut least = f64::MIN_POSITIVE;
        for &lag in lags {
            let allowed = "above 0, below the whole time and not below the one before";
            let is_allowed = lag >= least && lag < total && total.is_finite();
            InvalidValue::require(is_allowed, "lag", lag, allowed)?;
            least = lag;
        }
        let system = self.system(orders, temperatures)?;
        let unit = system.unit;
        let width = (total / unit).ln_1p() / (STARTS - 1) as f64;
        let mut problem = system.problem(0.0, system.start(temperatures));
        // Logarithms of displacements by lag, species and start.
        let mut found = vec![vec![Vec::with_capacity(STARTS); temperatures.len()]; lags.len()];
        for number in 0..STARTS {
            let begin = unit * (width * number as f64).exp_m1();
            let fresh = system.with_displacements_reset(problem.advance(begin)?);
            let mut own = system.problem(begin, fresh);
            for (&lag, found) in lags.iter().zip(&mut found) {
                let moment = system.moment(begin + lag, own.advance(begin + lag)?);
                for (found, r) in found.iter_mut().zip(moment.displacements) {
                    found.push(r.ln());
                }
            }
        }
        let mean = |lag: f64, logarithms: &[f64]| -> f64 {
            let span = total - lag;
            let step = (span / unit).ln_1p() / f64::from(POINTS);
            let sum: f64 = (0..=POINTS)
                .map(|point| {
                    let l = step * f64::from(point);
                    let weight = if point == 0 || point == POINTS {
                        0.5
                    } else {
                        1.0
                    };
                    weight * (interpolate_cubic(logarithms, l / width) + l).exp()
                })
                .sum();
            // ds = unit e^l dl.
            sum * step * unit / span
        };
        let of_species = |k: usize| {
            let each = lags.iter().zip(&found);
            each.map(|(&lag, found)| mean(lag, &found[k])).collect()
        };
        Ok((0..temperatures.len()).map(of_species).collect())
    }

    fn system(&self, orders: usize, temperatures: &[f64]) -> Result<System<'_, R>, TheoryError> {
        self.check_temperatures(temperatures)?;
        check_orders(orders, MOST_ORDERS, "from 1 to 12")?;
        let d = self.dimension() as f64;
        let shift = if orders < SHIFTED {
            0.0
        } else {
            SHIFT * self.largest_dissipation(temperatures)
        };
        let fastest = (0..temperatures.len())
            .map(|k| self.rates(k, temperatures).velocity)
            .fold(0.0, f64::max);
        Ok(System {
            mixture: self,
            layout: Layout { orders, shift },
            shape: Shape([orders + 1; 3]),
            norms: norms(0.5 * d - 1.0, orders + 1),
            vector_norms: norms(0.5 * d, orders),
            speeds: (self.components().iter().zip(temperatures))
                .map(|(component, t)| t / component.mass)
                .collect(),
            unit: if fastest > 0.0 { fastest.recip() } else { 1.0 },
            nodes: self.speeds(),
        })
    }

    /// Computes the largest share `1 - e^2` of its normal energy that any pair of species loses at
    /// its thermal speed.
    fn largest_dissipation(&self, temperatures: &[f64]) -> f64 {
        let count = temperatures.len();
        let pairs = (0..count).flat_map(|k| (0..count).map(move |i| [k, i]));
        pairs
            .filter(|&[k, i]| self.base(k, i) > 0.0)
            .map(|[k, i]| {
                let [a, b] = [k, i].map(|kind| temperatures[kind] / self.components()[kind].mass);
                let e = self.between([k as u32, i as u32], (a + b).sqrt());
                1.0 - e * e
            })
            .fold(0.0, f64::max)
    }

    /// Returns quadrature nodes over approach speeds: `y = g^2/(2 S^2)`, g over S, and the weight
    /// for means with `exp(-y)`. Every second node is enough for polynomials with exponentials of
    /// y, and for powers of g.
    fn speeds(&self) -> Vec<[f64; 3]> {
        let nodes = self.nodes().iter().step_by(2);
        let mut nodes: Vec<[f64; 3]> = nodes
            .map(|&(speed, weight)| {
                let y = 0.5 * speed * speed;
                [y, speed, weight / y]
            })
            .collect();
        let sum: f64 = nodes.iter().map(|node| node[0] * node[2]).sum();
        for node in &mut nodes {
            node[2] /= sum;
        }
        nodes
    }

    /// Returns the change `beta` of the normal velocity in collisions of a pair of species;
    /// `spread` is the standard deviation S of a component of its relative velocity.
    fn loss(&self, [k, i]: [usize; 2], spread: f64, speeds: &[[f64; 3]]) -> Loss {
        let [own, other] = [k, i].map(|kind| self.components()[kind].mass);
        let beta = |speed: f64| {
            let kept = self.between([k as u32, i as u32], speed);
            (1.0 + kept) * other / (own + other)
        };
        if self.is_constant() {
            return Loss::Constant(beta(1.0));
        }
        let nodes = speeds.iter();
        Loss::Spread(
            nodes
                .map(|&[y, speed, weight]| [y, weight, beta(speed * spread)])
                .collect(),
        )
    }
}

/// Differential equations of the Sonine coefficients of a mixture.
struct System<'a, R> {
    mixture: &'a MaxwellianMixture<R>,
    layout: Layout,
    shape: Shape<3>,
    /// Norms of the Laguerre polynomials that expand velocities.
    norms: Vec<f64>,
    /// Norms of the Laguerre polynomials that multiply v, for displacements.
    vector_norms: Vec<f64>,
    /// Squared thermal speed `T_k/m_k` of each species at time zero.
    speeds: Vec<f64>,
    /// Unit of time: the shortest mean free time at time zero.
    unit: f64,
    /// Quadrature nodes over approach speeds.
    nodes: Vec<[f64; 3]>,
}

impl<R: Restitution> System<'_, R> {
    fn dimension(&self) -> f64 {
        self.mixture.dimension() as f64
    }

    /// Computes `<v . v L_p>` over `D T/m` of the reference temperature: `(2/D)(p + D/2) N_p (a_p -
    /// a_(p+1))`.
    fn flight_moment(&self, p: usize, a: impl Fn(usize) -> f64) -> f64 {
        let half = 0.5 * self.dimension();
        (p as f64 + half) / half * self.norms[p] * (a(p) - a(p + 1))
    }

    /// Returns the initial moments of the velocities of all species for the integration in time: those
    /// of Maxwellian velocities at `temperatures`, whose reduced moments are `a_p = a_1^p`.
    fn start(&self, temperatures: &[f64]) -> Vec<f64> {
        let layout = self.layout;
        let maxwellian = |p: usize| layout.shift.powi(p as i32);
        let mut start = Vec::with_capacity(layout.len() * temperatures.len());
        for t in temperatures {
            start.extend([(t / layout.ratio()).ln(), 0.0, 0.0]);
            start.extend((2..=layout.orders).map(maxwellian));
            start.extend(vec![0.0; layout.orders]);
            start.extend(
                (0..layout.orders).map(|p| self.flight_moment(p, maxwellian) / layout.ratio()),
            );
        }
        start
    }

    /// Returns the integrated values with displacements reset to zero, for a new start time.
    fn with_displacements_reset(&self, y: &[f64]) -> Vec<f64> {
        let layout = self.layout;
        let mut fresh = y.to_vec();
        for values in fresh.chunks_mut(layout.len()) {
            values[DISPLACEMENT] = 0.0;
            values[layout.displaced()..layout.kept()].fill(0.0);
        }
        fresh
    }

    /// Returns the initial value problem that continues from given values at time `begin`.
    fn problem(
        &self,
        begin: f64,
        values: Vec<f64>,
    ) -> Integrator<impl FnMut(f64, &[f64], &mut [f64])> {
        let slope = |_: f64, y: &[f64], slope: &mut [f64]| self.slope(y, slope);
        // A gas that cools is the slower the later.
        Integrator::new(
            slope,
            begin,
            values,
            0.01 * (self.unit + 0.1 * begin),
            TOLERANCE,
        )
    }

    fn moment(&self, time: f64, y: &[f64]) -> Moment {
        let (layout, d) = (self.layout, self.dimension());
        let each = |value: &dyn Fn(&[f64]) -> f64| -> Vec<f64> {
            y.chunks(layout.len()).map(value).collect()
        };
        // In units of D T(0)/m and a power of the time.
        let squared = |index: usize, power: i32| -> Vec<f64> {
            let speeds = self.speeds.iter();
            let of_species = speeds.zip(y.chunks(layout.len()));
            of_species
                .map(|(speed, values)| values[index] * d * speed * self.unit.powi(power))
                .collect()
        };
        Moment {
            time,
            temperatures: each(&|values| values[LOGARITHM].exp() * layout.ratio()),
            correlations: squared(layout.displaced(), 1),
            displacements: squared(DISPLACEMENT, 2),
            kept: each(&|values| values[layout.kept()]),
            collisions: each(&|values| values[COLLISIONS]),
            fourth_cumulants: each(&|values| layout.fourth_cumulant(values)),
        }
    }

    fn slope(&self, y: &[f64], slope: &mut [f64]) {
        let size = self.layout.len();
        let values: Vec<&[f64]> = y.chunks(size).collect();
        for (k, change) in slope.chunks_mut(size).enumerate() {
            self.of_species(k, &values, change);
        }
    }

    /// Computes the time derivatives of the values of species k. Without collisions, `<L_p>` of a
    /// gas whose reference temperature changes at the rate `r` changes by `-r (p <L_p> - (p +
    /// alpha) <L_(p-1)>)`, as `x L_p' = p L_p - (p + alpha) L_(p-1)`. For velocities `alpha` is
    /// `D/2 - 1`, and `a_1` keeps its value if `r (1 - a_1) D/2` balances the change by collisions;
    /// with displacements `alpha` is `D/2`.
    fn of_species(&self, k: usize, values: &[&[f64]], change: &mut [f64]) {
        let (layout, orders) = (self.layout, self.layout.orders);
        let (d, own) = (self.dimension(), values[k]);
        let speed = own[LOGARITHM].exp() / self.mixture.components()[k].mass;
        let a = |p: usize| layout.coefficient(own, p);
        let vectors = [layout.displaced(), layout.kept()];
        change.fill(0.0);
        let mut moments = vec![0.0; orders + 1];
        for (i, partner) in self.mixture.components().iter().enumerate() {
            let base = self.mixture.base(k, i);
            if base == 0.0 {
                continue;
            }
            let variance = speed + values[i][LOGARITHM].exp() / partner.mass;
            let spread = variance.sqrt();
            let loss = self.mixture.loss([k, i], spread, &self.nodes);
            let kernel = MomentKernel::new(
                self.shape,
                self.mixture.dimension(),
                speed / variance,
                &loss,
            );
            // base has sqrt(2/pi)/D where the kernel has 1/sqrt(2 pi).
            let rate = 0.5 * d * base * spread;
            let element = |series: &[f64], p: usize, j: usize| -> f64 {
                let row = &series[self.shape.index([p, j, 0])..][..=orders];
                let partners = row.iter().enumerate();
                let sum: f64 = partners
                    .map(|(n, value)| value * layout.coefficient(values[i], n))
                    .sum();
                rate * sum
            };
            for j in 0..=orders {
                change[COLLISIONS] += a(j) * element(&kernel.hits, 0, j);
                for (p, moment) in moments.iter_mut().enumerate() {
                    *moment += a(j) * element(&kernel.scalar, p, j);
                }
            }
            for p in 0..orders {
                for j in 0..orders {
                    let element = element(&kernel.vector, p, j) / (d * self.vector_norms[j]);
                    for at in vectors {
                        change[at + p] += element * own[at + j];
                    }
                }
            }
        }
        let rate = -2.0 / d * moments[1] / layout.ratio();
        change[LOGARITHM] = rate;
        change[DISPLACEMENT] = 2.0 * own[layout.displaced()] / self.unit;
        for p in 2..=orders {
            change[1 + p] = moments[p] / self.norms[p] - rate * p as f64 * (a(p) - a(p - 1));
        }
        for p in 0..orders {
            for at in vectors {
                let below = if p > 0 { own[at + p - 1] } else { 0.0 };
                change[at + p] -= rate * (p as f64 * own[at + p] - (p as f64 + 0.5 * d) * below);
            }
            change[layout.displaced() + p] +=
                speed / self.speeds[k] / self.unit * self.flight_moment(p, a);
        }
    }
}
