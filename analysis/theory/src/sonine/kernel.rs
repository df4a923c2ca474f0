//! Collision integrals of Sonine polynomials as coefficients of power series; formulas are those of
//! [`super`].

use super::series::{PowerSeries, Shape, scaled, times};

/// Term of a polynomial in the variables u, s and t of [`super`].
type Term = super::series::Term<3>;

/// Change of the normal velocity of a particle in collisions with one species, `beta = (1 + e)
/// m_2/(m_1 + m_2)` in units of the relative one.
pub(super) enum Loss {
    /// Constant `beta`, independent of the approach speed.
    Constant(f64),
    /// Values of `beta` by approach speed: nodes `y = g^2/(2 V)`, weights of the mean with
    /// `exp(-y)`, and `beta` there.
    Spread(Vec<[f64; 3]>),
}

/// Polynomials from which the collision integrals of a pair of species are computed, in units in
/// which V is 1 at s = t = 0.
struct Parts {
    shape: Shape<3>,
    own: f64,
    other: f64,
    /// Polynomial S of the collision integrals in [`super`].
    same: Vec<Term>,
    /// Polynomial V of the collision integrals in [`super`].
    v: Vec<Term>,
    /// Polynomial W of the collision integrals in [`super`].
    w: Vec<Term>,
    /// Polynomial Z of the collision integrals in [`super`].
    z: Vec<Term>,
    /// Coefficients of the powers 0, 1, 2 of beta in `(Y - beta V)(1 - u + beta u Z m_1/T_1)`, as
    /// polynomials.
    turns: [Vec<Term>; 3],
    /// Power series of `W^(1/2)` and `W^(-1/2)`.
    roots: [PowerSeries; 2],
}

impl Parts {
    /// Computes the polynomials of a pair of species; `own` is the share of `T_1/m_1` in V.
    fn new(shape: Shape<3>, own: f64) -> Self {
        let other = 1.0 - own;
        let v = vec![([0; 3], 1.0), ([0, 1, 0], -own), ([0, 0, 1], -other)];
        let w = vec![
            ([0; 3], 1.0),
            ([0, 1, 0], -own),
            ([0, 0, 1], -other),
            ([1, 0, 0], -own),
            ([1, 1, 0], own - other),
            ([1, 1, 1], other),
        ];
        let y = [([0; 3], own), ([0, 1, 0], -own)];
        let z = vec![([0; 3], other), ([0, 0, 1], -other)];
        let without_u = [([0; 3], 1.0), ([1, 0, 0], -1.0)];
        let up = [([1, 0, 0], 1.0 / own)];
        let mut first = times(&times(&y, &z), &up);
        first.extend(scaled(&times(&v, &without_u), -1.0));
        Self {
            turns: [
                times(&y, &without_u),
                first,
                scaled(&times(&times(&v, &z), &up), -1.0),
            ],
            roots: [shape.power(&w, 0.5), shape.power(&w, -0.5)],
            same: vec![([0; 3], 1.0), ([1, 1, 0], -1.0)],
            shape,
            own,
            other,
            v,
            w,
            z,
        }
    }

    /// Computes the power series `(W/A)/W^(1/2)` and `[Z W/A + 2 (Y - beta V)(1 - u + beta u Z
    /// m_1/T_1) (W/A)^2/W]/W^(3/2)` at one value of beta.
    fn at(&self, beta: f64) -> [PowerSeries; 2] {
        let shape = self.shape;
        let square = beta * beta;
        let a = [
            ([0; 3], 1.0),
            ([1, 0, 0], square / self.own - 2.0 * beta),
            ([1, 1, 0], 2.0 * beta - 1.0 - square),
            ([1, 0, 1], -square * self.other / self.own),
        ];
        let inverse = shape.power(&a, -1.0);
        let mut sum = shape.times(&inverse, &self.z);
        let inverse_square = shape.power(&a, -2.0);
        for (terms, factor) in self.turns.iter().zip([1.0, beta, square]) {
            shape.add_times(&mut sum, &inverse_square, terms, 2.0 * factor);
        }
        let [up, down] = &self.roots;
        [shape.product(&inverse, up), shape.product(&sum, down)]
    }

    /// Computes the two power series of [`Self::at`], averaged over speeds by quadrature.
    fn over(&self, nodes: &[[f64; 3]]) -> [PowerSeries; 2] {
        let shape = self.shape;
        let inverse = shape.power(&self.w, -1.0);
        // A/W by powers of beta.
        let parts = [
            shape.times(&inverse, &self.same),
            shape.times(&inverse, &[([1, 0, 0], -2.0), ([1, 1, 0], 2.0)]),
            shape.times(&inverse, &times(&self.v, &[([1, 0, 0], 1.0 / self.own)])),
        ];
        // Means of 1, y, y beta, y beta^2 with exp(-g^2 A/(2 W)).
        let mut means: [PowerSeries; 4] = std::array::from_fn(|_| vec![0.0; shape.len()]);
        let mut exponent = vec![0.0; shape.len()];
        for &[y, weight, beta] in nodes {
            for (n, exponent) in exponent.iter_mut().enumerate() {
                *exponent = -y * (parts[0][n] + beta * (parts[1][n] + beta * parts[2][n]));
            }
            let value = shape.exponential(&exponent);
            let first = weight * y;
            let weights = [weight, first, first * beta, first * beta * beta];
            for (mean, weight) in means.iter_mut().zip(weights) {
                for (mean, value) in mean.iter_mut().zip(&value) {
                    *mean += weight * value;
                }
            }
        }
        let [all, by_power @ ..] = means;
        let mut cubes = vec![0.0; shape.len()];
        for (mean, terms) in by_power.iter().zip(&self.turns) {
            shape.add_times(&mut cubes, mean, terms, 2.0);
        }
        let mut sum = shape.product(&cubes, &inverse);
        shape.add_times(&mut sum, &all, &self.z, 1.0);
        let [_, down] = &self.roots;
        let thrice = shape.product(&inverse, down);
        [shape.product(&all, down), shape.product(&sum, &thrice)]
    }
}

/// Collision kernel of one pair of species: coefficients of the changes of Sonine moments, over
/// `n_2 d^(D-1) chi Omega_D sqrt(V/(2 pi))`.
pub(super) struct MomentKernel {
    /// Change of `<S_p>`, as coefficients of the products of `a_j` of the particle and `a_k` of the
    /// partner.
    pub scalar: PowerSeries,
    /// Change of `<R . v L_p>` over `T_1/m_1`, as coefficients of the products of `b_j` and `a_k`.
    pub vector: PowerSeries,
    /// Collision rate, as coefficients of the products of `a_j` and `a_k` (no powers of u).
    pub hits: PowerSeries,
}

impl MomentKernel {
    /// Computes the collision kernel of a pair of species; `own` is the share of `T_1/m_1` in V.
    pub fn new(shape: Shape<3>, dimension: usize, own: f64, loss: &Loss) -> Self {
        let d = dimension as f64;
        let parts = Parts::new(shape, own);
        let [mut scalar, mut vector] = match loss {
            Loss::Constant(beta) => parts.at(*beta),
            Loss::Spread(nodes) => parts.over(nodes),
        };
        // Less what was there before: A is S, and beta zero.
        let [up, down] = &parts.roots;
        let lost = shape.power(&parts.same, -1.0);
        for (scalar, before) in scalar.iter_mut().zip(shape.product(up, &lost)) {
            *scalar -= before;
        }
        let mut before = shape.times(&lost, &parts.z);
        let twice = shape.power(&parts.same, -2.0);
        shape.add_times(&mut before, &twice, &parts.turns[0], 2.0);
        let sideways = shape.product(&scalar, &lost);
        for ((vector, before), sideways) in vector
            .iter_mut()
            .zip(shape.product(&before, down))
            .zip(sideways)
        {
            *vector += (d - 1.0) * sideways - before;
        }
        let across = shape.power(&parts.same, 0.5 * (1.0 - d));
        let flat = Shape([1, shape.0[1], shape.0[2]]);
        Self {
            scalar: shape.product(&scalar, &across),
            vector: shape.product(&vector, &across),
            hits: flat.power(&parts.v, 0.5),
        }
    }
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_distr::StandardNormal;
    use rand_xoshiro::Xoshiro256PlusPlus;

    use super::*;

    /// Generating functions, summed up where they are small, agree with the mean over random
    /// colliding pairs, with one restitution and with one that falls with speed. The limit is z =
    /// 4.75, a false alarm in 1e6 for each of 16 values. The ninth powers leave out less than 1e-4
    /// of 0.3, and so does the quadrature.
    #[test]
    fn kernels_are_the_moments_of_collisions() {
        let (s, t, u) = (0.3_f64, -0.2_f64, 0.25_f64);
        let shape = Shape([9; 3]);
        for (dimension, taus) in [(2, [1.0, 0.4]), (3, [0.5, 2.0])] {
            let [first, second] = taus;
            let variance: f64 = first + second;
            let nodes = |law: fn(f64) -> f64| -> Vec<[f64; 3]> {
                (1..=4000)
                    .map(|n| {
                        let y = 0.01 * (f64::from(n) - 0.5);
                        [y, 0.01 * (-y).exp(), law((2.0 * y * variance).sqrt())]
                    })
                    .collect()
            };
            let laws: [fn(f64) -> f64; 2] = [|_| 0.7, |g| 0.9 / (1.0 + 0.2 * g)];
            for (law, loss) in [
                (laws[0], Loss::Constant(0.7)),
                (laws[1], Loss::Spread(nodes(laws[1]))),
            ] {
                let kernel = MomentKernel::new(shape, dimension, first / variance, &loss);
                let sum = |series: &[f64]| -> f64 {
                    let value = |(powers, value): ([usize; 3], &f64)| {
                        let [a, b, c] = powers.map(|power| power as i32);
                        value * u.powi(a) * s.powi(b) * t.powi(c)
                    };
                    shape.powers().zip(series).map(value).sum()
                };
                let unit = (variance / std::f64::consts::TAU).sqrt();
                let expected = [
                    unit * sum(&kernel.scalar),
                    unit * first * sum(&kernel.vector),
                ];
                let found = drawn(dimension, taus, [u, s, t], law);
                for (expected, (mean, error)) in expected.into_iter().zip(found) {
                    assert!(
                        (mean - expected).abs() < 4.75 * error + 1e-4,
                        "{dimension}: {mean} +- {error} against {expected}"
                    );
                    assert!(
                        error < 0.01 * expected.abs(),
                        "{error} says nothing of {expected}"
                    );
                }
            }
        }
    }

    /// Computes means and standard errors over 4e5 random pairs.
    fn drawn(
        dimension: usize,
        taus: [f64; 2],
        [u, s, t]: [f64; 3],
        beta: fn(f64) -> f64,
    ) -> [(f64, f64); 2] {
        const PAIRS: usize = 400_000;
        let mut random = Xoshiro256PlusPlus::seed_from_u64(1);
        let mut vector = |scale: f64| -> Vec<f64> {
            let each = |_| scale * random.sample::<f64, _>(StandardNormal);
            (0..dimension).map(each).collect()
        };
        let dot = |a: &[f64], b: &[f64]| -> f64 { a.iter().zip(b).map(|(a, b)| a * b).sum() };
        let d = dimension as f64;
        let weight = |v: &[f64]| (-dot(v, v) / (2.0 * taus[0]) * u / (1.0 - u)).exp();
        let mut sums = [[0.0; 2]; 2];
        for _ in 0..PAIRS {
            let one = vector((taus[0] * (1.0 - s)).sqrt());
            let other = vector((taus[1] * (1.0 - t)).sqrt());
            let line = vector(1.0);
            let length = dot(&line, &line).sqrt();
            let line: Vec<f64> = line.iter().map(|x| x / length).collect();
            let approach = dot(&one, &line) - dot(&other, &line);
            if approach <= 0.0 {
                continue;
            }
            let after: Vec<f64> = one
                .iter()
                .zip(&line)
                .map(|(v, e)| v - beta(approach) * approach * e)
                .collect();
            let (new, old) = (weight(&after), weight(&one));
            let values = [
                approach * (new - old) * (1.0 - u).powf(-0.5 * d),
                approach * (new * dot(&one, &after) - old * dot(&one, &one)) / (1.0 - s)
                    * (1.0 - u).powf(-0.5 * d - 1.0),
            ];
            for (sum, value) in sums.iter_mut().zip(values) {
                sum[0] += value;
                sum[1] += value * value;
            }
        }
        sums.map(|[sum, square]| {
            let n = PAIRS as f64;
            let mean = sum / n;
            (mean, ((square / n - mean * mean) / n).sqrt())
        })
    }
}
