//! Arithmetic of power series in several variables, truncated after given powers of each.

/// Shape of a truncated power series: number of powers of each variable, the zeroth included.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Shape<const V: usize>(pub [usize; V]);

/// Term of a polynomial in V variables: its powers and its coefficient.
pub(crate) type Term<const V: usize> = ([usize; V], f64);

/// Coefficients of a truncated power series; the last variable runs fastest.
pub(crate) type PowerSeries = Vec<f64>;

impl<const V: usize> Shape<V> {
    /// Returns the number of coefficients of a series.
    pub fn len(self) -> usize {
        self.0.iter().product()
    }

    /// Returns the index of the coefficient of given powers; the index is linear in the powers.
    pub fn index(self, powers: [usize; V]) -> usize {
        let axes = powers.iter().zip(&self.0);
        axes.fold(0, |index, (power, size)| index * size + power)
    }

    /// Returns all powers of a series, in the order of their coefficients.
    pub fn powers(self) -> impl Iterator<Item = [usize; V]> {
        (0..self.len()).map(move |mut index| {
            let mut powers = [0; V];
            for axis in (0..V).rev() {
                powers[axis] = index % self.0[axis];
                index /= self.0[axis];
            }
            powers
        })
    }

    /// Calls `act` with the index of the first coefficient of each run along the last variable. The
    /// powers of all other variables go from 0 to `most`.
    fn runs(self, most: [usize; V], act: &mut impl FnMut(usize)) {
        let mut at = [0; V];
        loop {
            act(self.index(at));
            let Some(axis) = (0..V - 1).rev().find(|&axis| at[axis] < most[axis]) else {
                return;
            };
            at[axis] += 1;
            at[axis + 1..].fill(0);
        }
    }

    /// Adds `factor` times the product of a series and a polynomial to `sum`.
    pub fn add_times(self, sum: &mut [f64], series: &[f64], terms: &[Term<V>], factor: f64) {
        for &(shift, value) in terms {
            if value == 0.0 || (0..V).any(|axis| shift[axis] >= self.0[axis]) {
                continue;
            }
            let value = value * factor;
            let offset = self.index(shift);
            let most: [usize; V] = std::array::from_fn(|axis| self.0[axis] - 1 - shift[axis]);
            let run = most[V - 1] + 1;
            self.runs(most, &mut |from| {
                let (to, from) = (&mut sum[from + offset..][..run], &series[from..][..run]);
                for (to, from) in to.iter_mut().zip(from) {
                    *to += value * from;
                }
            });
        }
    }

    /// Multiplies a series by a polynomial.
    pub fn times(self, series: &[f64], terms: &[Term<V>]) -> PowerSeries {
        let mut product = vec![0.0; self.len()];
        self.add_times(&mut product, series, terms, 1.0);
        product
    }

    /// Multiplies two series.
    pub fn product(self, a: &[f64], b: &[f64]) -> PowerSeries {
        let run = self.0[V - 1];
        let mut product = vec![0.0; self.len()];
        for (powers, row) in self.powers().step_by(run).zip(b.chunks_exact(run)) {
            // Powers of S = 1 - u s have few.
            if row.iter().all(|&value| value == 0.0) {
                continue;
            }
            let offset = self.index(powers);
            let most = std::array::from_fn(|axis| self.0[axis] - 1 - powers[axis]);
            self.runs(most, &mut |from| {
                add_product(&mut product[from + offset..][..run], &a[from..][..run], row);
            });
        }
        product
    }

    /// Computes a real power of a polynomial as a power series. The constant term must be the first
    /// and above zero.
    ///
    /// With the Euler operator E, the sum of x d/dx over the variables, and Q = P^a,
    /// `P E Q = a Q E P`; power by power that is
    /// `|n| P_0 Q_n = sum_(i != 0) (a |i| - |n - i|) P_i Q_(n - i)`.
    pub fn power(self, terms: &[Term<V>], exponent: f64) -> PowerSeries {
        let constant = terms[0].1;
        let degree = |powers: &[usize; V]| powers.iter().sum::<usize>() as f64;
        let terms: Vec<_> = terms[1..]
            .iter()
            .map(|(i, value)| (*i, self.index(*i), degree(i), *value))
            .collect();
        let mut power = vec![0.0; self.len()];
        power[0] = constant.powf(exponent);
        for (place, n) in self.powers().enumerate().skip(1) {
            let whole = degree(&n);
            let mut sum = 0.0;
            for &(i, before, of_term, value) in &terms {
                if (0..V).all(|axis| i[axis] <= n[axis]) {
                    let weight = exponent * of_term - (whole - of_term);
                    sum += weight * value * power[place - before];
                }
            }
            power[place] = sum / (whole * constant);
        }
        power
    }

    /// Computes the exponential of a power series without its constant term: `|n| Q_n = sum_i |i|
    /// P_i Q_(n - i)`.
    pub fn exponential(self, series: &[f64]) -> PowerSeries {
        let weighted: PowerSeries = self
            .powers()
            .zip(series)
            .map(|(powers, value)| powers.iter().sum::<usize>() as f64 * value)
            .collect();
        let mut found = vec![0.0; self.len()];
        found[0] = 1.0;
        for (place, n) in self.powers().enumerate().skip(1) {
            let run = n[V - 1];
            let mut sum = 0.0;
            self.runs(n, &mut |begin| {
                let given = &weighted[begin..=begin + run];
                let known = &found[place - begin - run..=place - begin];
                // Unknown coefficients are still zero, and so are their products.
                let products = given.iter().zip(known.iter().rev()).map(|(a, b)| a * b);
                sum += products.sum::<f64>();
            });
            found[place] = sum / n.iter().sum::<usize>() as f64;
        }
        found
    }
}

/// Adds the product of two series in one variable to `sum`.
fn add_product(sum: &mut [f64], a: &[f64], b: &[f64]) {
    for (shift, b) in b.iter().enumerate() {
        for (sum, a) in sum[shift..].iter_mut().zip(a) {
            *sum += b * a;
        }
    }
}

/// Multiplies two polynomials.
pub(crate) fn times<const V: usize>(a: &[Term<V>], b: &[Term<V>]) -> Vec<Term<V>> {
    a.iter()
        .flat_map(|&(i, x)| {
            b.iter()
                .map(move |&(k, y)| (std::array::from_fn(|axis| i[axis] + k[axis]), x * y))
        })
        .collect()
}

/// Multiplies a polynomial by a number.
pub(crate) fn scaled<const V: usize>(terms: &[Term<V>], factor: f64) -> Vec<Term<V>> {
    terms.iter().map(|&(i, x)| (i, factor * x)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const SHAPE: Shape<3> = Shape([4, 3, 5]);
    const TERMS: [Term<3>; 4] = [
        ([0, 0, 0], 1.5),
        ([1, 0, 0], -0.3),
        ([0, 1, 1], 0.7),
        ([1, 0, 2], 0.2),
    ];

    /// Roots and inverses undo each other, and exponentials multiply. Tolerance: roundings of sums
    /// of 60 terms of order one.
    #[test]
    fn powers_and_exponentials_obey_their_laws() {
        let same = |a: &[f64], b: &[f64]| {
            for (a, b) in a.iter().zip(b) {
                assert!((a - b).abs() < 1e-13, "{a} against {b}");
            }
        };
        let series = |terms: &[Term<3>]| SHAPE.power(terms, 1.0);
        let root = SHAPE.power(&TERMS, 0.5);
        same(&SHAPE.product(&root, &root), &series(&TERMS));
        let inverse = SHAPE.power(&TERMS, -1.0);
        same(&SHAPE.times(&inverse, &TERMS), &series(&[([0; 3], 1.0)]));
        let mut exponent = series(&TERMS);
        exponent[0] = 0.0;
        let half: PowerSeries = exponent.iter().map(|value| 0.5 * value).collect();
        let half = SHAPE.exponential(&half);
        same(&SHAPE.product(&half, &half), &SHAPE.exponential(&exponent));
    }
}
