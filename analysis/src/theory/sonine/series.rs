//! Power series in three variables (u, s, t), cut after given powers of each.

/// How many powers of each variable are kept, from the zeroth on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Shape(pub [usize; 3]);

/// One term of a polynomial: its powers and its coefficient.
pub(super) type Term = ([usize; 3], f64);

/// Coefficients, those of the last variable side by side.
pub(super) type Series = Vec<f64>;

impl Shape {
    /// Number of coefficients.
    pub fn len(self) -> usize {
        self.0.iter().product()
    }

    /// Where the coefficient of given powers stands.
    pub fn index(self, [u, s, t]: [usize; 3]) -> usize {
        (u * self.0[1] + s) * self.0[2] + t
    }

    /// All powers that are kept, in the order of their coefficients.
    pub fn powers(self) -> impl Iterator<Item = [usize; 3]> {
        let [us, ss, ts] = self.0;
        (0..us).flat_map(move |u| (0..ss).flat_map(move |s| (0..ts).map(move |t| [u, s, t])))
    }

    /// Adds `factor` times the product of a series with a polynomial.
    pub fn add_times(self, sum: &mut [f64], series: &[f64], terms: &[Term], factor: f64) {
        let [us, ss, ts] = self.0;
        for &([du, ds, dt], value) in terms {
            if du >= us || ds >= ss || dt >= ts || value == 0.0 {
                continue;
            }
            let value = value * factor;
            for u in du..us {
                for s in ds..ss {
                    let to = self.index([u, s, dt]);
                    let from = self.index([u - du, s - ds, 0]);
                    let (to, from) = (&mut sum[to..][..ts - dt], &series[from..][..ts - dt]);
                    for (to, from) in to.iter_mut().zip(from) {
                        *to += value * from;
                    }
                }
            }
        }
    }

    /// The product with a polynomial.
    pub fn times(self, series: &[f64], terms: &[Term]) -> Series {
        let mut product = vec![0.0; self.len()];
        self.add_times(&mut product, series, terms, 1.0);
        product
    }

    /// The product of two series.
    pub fn product(self, a: &[f64], b: &[f64]) -> Series {
        let terms: Vec<Term> = self.powers().zip(b.iter().copied()).collect();
        self.times(a, &terms)
    }

    /// A real power of a polynomial whose constant term, which must be the first, is above zero.
    ///
    /// With the Euler operator E = u d/du + s d/ds + t d/dt and Q = P^a, `P E Q = a Q E P`; power by power that is
    /// `|n| P_0 Q_n = sum_(i != 0) (a |i| - |n - i|) P_i Q_(n - i)`.
    pub fn power(self, terms: &[Term], exponent: f64) -> Series {
        let constant = terms[0].1;
        let mut power = vec![0.0; self.len()];
        power[0] = constant.powf(exponent);
        for n in self.powers().skip(1) {
            let degree: usize = n.iter().sum();
            let mut sum = 0.0;
            for &(i, value) in &terms[1..] {
                if (0..3).all(|axis| i[axis] <= n[axis]) {
                    let of_term: usize = i.iter().sum();
                    let rest = [n[0] - i[0], n[1] - i[1], n[2] - i[2]];
                    let weight = exponent * of_term as f64 - (degree - of_term) as f64;
                    sum += weight * value * power[self.index(rest)];
                }
            }
            power[self.index(n)] = sum / (degree as f64 * constant);
        }
        power
    }

    /// The exponential of a series, whose constant term is passed over: `|n| Q_n = sum_i |i| P_i Q_(n - i)`.
    pub fn exponential(self, series: &[f64]) -> Series {
        let weighted: Series = self
            .powers()
            .zip(series)
            .map(|(powers, value)| powers.iter().sum::<usize>() as f64 * value)
            .collect();
        let mut found = vec![0.0; self.len()];
        found[0] = 1.0;
        for n in self.powers().skip(1) {
            let [u, s, t] = n;
            let mut sum = 0.0;
            for i in 0..=u {
                for k in 0..=s {
                    let given = &weighted[self.index([i, k, 0])..][..=t];
                    let known = &found[self.index([u - i, s - k, 0])..][..=t];
                    // What is not known yet is still zero, and so is its factor.
                    sum += given
                        .iter()
                        .zip(known.iter().rev())
                        .map(|(a, b)| a * b)
                        .sum::<f64>();
                }
            }
            found[self.index(n)] = sum / n.iter().sum::<usize>() as f64;
        }
        found
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SHAPE: Shape = Shape([4, 3, 5]);
    const TERMS: [Term; 4] = [
        ([0, 0, 0], 1.5),
        ([1, 0, 0], -0.3),
        ([0, 1, 1], 0.7),
        ([1, 0, 2], 0.2),
    ];

    /// Roots and inverses undo each other, and exponentials multiply. Tolerance: roundings of sums of 60 terms of order one.
    #[test]
    fn powers_and_exponentials_obey_their_laws() {
        let same = |a: &[f64], b: &[f64]| {
            for (a, b) in a.iter().zip(b) {
                assert!((a - b).abs() < 1e-13, "{a} against {b}");
            }
        };
        let series = |terms: &[Term]| SHAPE.power(terms, 1.0);
        let root = SHAPE.power(&TERMS, 0.5);
        same(&SHAPE.product(&root, &root), &series(&TERMS));
        let inverse = SHAPE.power(&TERMS, -1.0);
        same(&SHAPE.times(&inverse, &TERMS), &series(&[([0; 3], 1.0)]));
        let mut exponent = series(&TERMS);
        exponent[0] = 0.0;
        let half: Series = exponent.iter().map(|value| 0.5 * value).collect();
        let half = SHAPE.exponential(&half);
        same(&SHAPE.product(&half, &half), &SHAPE.exponential(&exponent));
    }
}
