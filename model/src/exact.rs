//! Order-independent exact sums of floating-point numbers: the small superaccumulator of Neal,
//! arXiv:1505.05571.
//!
//! A finite number of double precision is an integer times 2^-1074. Such integers are added in
//! chunks of 32 bits, each in 64, so that carries wait. The sum is rounded once, to the nearest
//! number (the small superaccumulator of Neal, arXiv:1505.05571, which here holds only the chunks
//! that occur). So parts of a sum can be made anywhere and put together in any order.

use serde::{Deserialize, Serialize};

/// Number of bits in a chunk of the superaccumulator.
const BITS: u32 = 32;
/// Bit mask of one chunk of the superaccumulator.
const MASK: i64 = (1 << BITS) - 1;
/// Index of the first chunk whose numbers are beyond the range of double precision.
const BEYOND: usize = 66;
/// Number of additions after which carries must be propagated: each is below 2^32 in every chunk,
/// so that sums fit 64 bits.
const PATIENCE: u32 = 1 << 29;

/// Exact, order-independent sum of double-precision numbers (superaccumulator), rounded only when
/// read.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct ExactSum {
    /// Index of the lowest chunk stored; chunk i counts multiples of 2^(32 i - 1074).
    low: u8,
    chunks: Vec<i64>,
    /// Number of additions since carries were propagated.
    pending: u32,
    /// Sum of the infinite and NaN numbers added; zero if there are none.
    special: f64,
}

impl ExactSum {
    /// Adds a number to the sum without rounding.
    #[inline]
    pub fn add(&mut self, number: f64) {
        let bits = number.to_bits();
        let biased = (bits >> 52) & 0x7ff;
        let fraction = bits & ((1 << 52) - 1);
        if biased == 0x7ff {
            self.special += number;
            return;
        }
        if biased == 0 && fraction == 0 {
            return;
        }
        let (shift, mantissa) = match biased {
            0 => (0, fraction),
            _ => (biased as u32 - 1, fraction | 1 << 52),
        };
        let wide = u128::from(mantissa) << (shift % BITS);
        let first = self.chunk_index((shift / BITS) as usize, 3);
        let sign = if number < 0.0 { -1 } else { 1 };
        for (chunk, part) in self.chunks[first..first + 3].iter_mut().zip(0..) {
            *chunk += sign * ((wide >> (BITS * part)) as i64 & MASK);
        }
        self.count(1);
    }

    /// Adds another exact sum to this one without rounding.
    pub fn merge(&mut self, other: &Self) {
        self.special += other.special;
        if other.chunks.is_empty() {
            return;
        }
        let mut other = other.clone();
        other.carry();
        let first = self.chunk_index(usize::from(other.low), other.chunks.len());
        for (chunk, more) in self.chunks[first..].iter_mut().zip(&other.chunks) {
            *chunk += more;
        }
        self.count(1);
    }

    /// Returns the sum rounded to the nearest double-precision number, ties to even.
    pub fn value(&self) -> f64 {
        if self.special != 0.0 {
            return self.special;
        }
        let mut sum = self.clone();
        sum.carry();
        let negative = sum.chunks.last().is_some_and(|&top| top < 0);
        if negative {
            sum.chunks.iter_mut().for_each(|chunk| *chunk = -*chunk);
            sum.carry();
        }
        let size = sum.size();
        if negative { -size } else { size }
    }

    /// Rounds the magnitude of the sum, which must not be negative and have its carries propagated.
    fn size(&self) -> f64 {
        let Some(top) = self.chunks.iter().rposition(|&chunk| chunk != 0) else {
            return 0.0;
        };
        let highest = usize::from(self.low) + top;
        if highest >= BEYOND {
            return f64::INFINITY;
        }
        // Three chunks, 65 bits at least; of the lower chunks it matters only whether any is
        // non-zero.
        let chunk = |down: usize| {
            top.checked_sub(down)
                .map_or(0, |index| self.chunks[index] as u128)
        };
        let leading = chunk(0) << (2 * BITS) | chunk(1) << BITS | chunk(2);
        let rest = self.chunks[..top.saturating_sub(2)]
            .iter()
            .any(|&chunk| chunk != 0);
        // The first bit of the leading ones counts 2^lowest; no number is finer than 2^-1074.
        let lowest = BITS as i32 * (highest as i32 - 2) - 1074;
        let length = 128 - leading.leading_zeros() as i32;
        let cut = (length - 53).max(-1074 - lowest);
        let (kept, lost) = (leading >> cut, leading & ((1 << cut) - 1));
        let half = 1_u128 << (cut - 1);
        let up = lost > half || lost == half && (rest || kept & 1 == 1);
        (kept + u128::from(up)) as f64 * power_of_two(lowest + cut)
    }

    /// Returns the index in the buffer of the superaccumulator's chunk `chunk`, after growing the
    /// buffer so that `count` chunks fit from there.
    #[inline(always)]
    fn chunk_index(&mut self, chunk: usize, count: usize) -> usize {
        if self.chunks.is_empty() {
            self.low = chunk as u8;
        }
        let low = usize::from(self.low);
        if chunk < low {
            self.chunks
                .splice(0..0, std::iter::repeat_n(0, low - chunk));
            self.low = chunk as u8;
        }
        let first = chunk - usize::from(self.low);
        if self.chunks.len() < first + count {
            self.chunks.resize(first + count, 0);
        }
        first
    }

    #[inline]
    fn count(&mut self, more: u32) {
        self.pending += more;
        if self.pending >= PATIENCE {
            self.carry();
        }
    }

    /// Propagates carries between the chunks of the superaccumulator: all but the last, which has
    /// the sign, are then from 0 to 2^32 - 1.
    fn carry(&mut self) {
        self.pending = 0;
        let mut carry = 0;
        for chunk in &mut self.chunks {
            let sum = *chunk + carry;
            (*chunk, carry) = (sum & MASK, sum >> BITS);
        }
        // The rest of a negative sum is -1.
        while carry != 0 && carry != -1 {
            self.chunks.push(carry & MASK);
            carry >>= BITS;
        }
        if carry == -1
            && let Some(top) = self.chunks.last_mut()
        {
            *top -= 1 << BITS;
        }
    }
}

impl Extend<f64> for ExactSum {
    fn extend<I: IntoIterator<Item = f64>>(&mut self, numbers: I) {
        numbers.into_iter().for_each(|number| self.add(number));
    }
}

/// Returns 2^exponent, for exponents from -1074 to 1023.
fn power_of_two(exponent: i32) -> f64 {
    f64::from_bits(match exponent {
        -1074..-1022 => 1 << (exponent + 1074),
        _ => ((exponent + 1023) as u64) << 52,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::{Purpose, Streams};
    use rand::RngExt as _;

    fn sum(numbers: &[f64]) -> f64 {
        let mut sum = ExactSum::default();
        sum.extend(numbers.iter().copied());
        sum.value()
    }

    /// Numbers of any size and sign, many of which cancel.
    fn numbers(seed: u64) -> Vec<f64> {
        let mut draw = Streams::new(seed, 0).stream_at(Purpose::Placement, [0, 0]);
        let widest = [4, 60, 1000][seed as usize % 3];
        let mut all: Vec<f64> = (0..200)
            .map(|_| {
                let exponent = draw.random_range(-widest..widest);
                (draw.random::<f64>() - 0.5) * power_of_two(exponent)
            })
            .collect();
        let cancelling: Vec<f64> = all.iter().step_by(2).map(|one| -one).collect();
        all.extend(cancelling);
        all
    }

    /// Returns the exact sum in units of 2^-1074, as one integer per bit.
    fn bits(numbers: &[f64]) -> Vec<i64> {
        let mut bits = vec![0; 2200];
        for &number in numbers {
            let raw = number.to_bits();
            let biased = (raw >> 52) & 0x7ff;
            let mantissa = raw & ((1 << 52) - 1) | u64::from(biased > 0) << 52;
            let shift = biased.max(1) - 1;
            for bit in 0..53 {
                let one = (mantissa >> bit & 1) as i64;
                bits[(shift + bit) as usize] += if number < 0.0 { -one } else { one };
            }
        }
        bits
    }

    /// Returns true if a number is the nearest to a sum, by exact arithmetic of the bits.
    fn is_nearest(found: f64, numbers: &[f64]) -> bool {
        let sign_of = |numbers: &[f64]| -> i64 {
            let mut bits = bits(numbers);
            let mut carry = 0;
            for bit in &mut bits {
                let sum = *bit + carry;
                (*bit, carry) = (sum & 1, sum >> 1);
            }
            if carry < 0 {
                return -1;
            }
            i64::from(bits.iter().any(|&bit| bit != 0))
        };
        // The sum is nearest if it lies between the midpoints to both neighbours of the number; all
        // are doubled to be exact.
        let twice: Vec<f64> = numbers.iter().chain(numbers).copied().collect();
        let against = |other: f64| sign_of(&[&twice[..], &[-found, -other]].concat());
        let (below, above) = (against(found.next_down()), against(found.next_up()));
        let even = found.to_bits() & 1 == 0;
        (below > 0 || below == 0 && even) && (above < 0 || above == 0 && even)
    }

    #[test]
    fn sums_are_rounded_to_the_nearest_number() {
        for seed in 0..300 {
            let numbers = numbers(seed);
            let found = sum(&numbers);
            assert!(is_nearest(found, &numbers), "seed {seed}: {found:e}");
        }
    }

    #[test]
    fn orders_and_parts_change_no_bit() {
        for seed in 0..300 {
            let mut numbers = numbers(seed);
            let wanted = sum(&numbers);
            numbers.sort_by(f64::total_cmp);
            assert_eq!(sum(&numbers).to_bits(), wanted.to_bits(), "seed {seed}");
            let mut parts = ExactSum::default();
            for part in numbers.chunks(7).rev() {
                let mut one = ExactSum::default();
                one.extend(part.iter().copied());
                parts.merge(&one);
            }
            assert_eq!(parts.value().to_bits(), wanted.to_bits(), "seed {seed}");
        }
    }

    #[test]
    fn edges_of_the_range() {
        let tiny = f64::from_bits(1);
        assert_eq!(sum(&[]), 0.0);
        assert_eq!(sum(&[tiny]), tiny);
        assert_eq!(sum(&[-tiny, -tiny]), -2.0 * tiny);
        assert_eq!(
            sum(&[f64::MIN_POSITIVE, -tiny]),
            f64::MIN_POSITIVE.next_down()
        );
        assert_eq!(sum(&[f64::MAX, f64::MAX, -f64::MAX]), f64::MAX);
        assert_eq!(sum(&[f64::MAX; 3]), f64::INFINITY);
        assert_eq!(sum(&[-f64::MAX; 3]), f64::NEG_INFINITY);
        assert_eq!(sum(&[1.0, 1e100, 1.0, -1e100]), 2.0);
        assert_eq!(sum(&[1.0, f64::EPSILON / 2.0]), 1.0);
        assert_eq!(sum(&[1.0, f64::EPSILON / 2.0, tiny]), 1.0 + f64::EPSILON);
        assert_eq!(sum(&[1.0, f64::INFINITY]), f64::INFINITY);
        assert!(sum(&[f64::INFINITY, f64::NEG_INFINITY]).is_nan());
    }

    /// Sums of 2^40 numbers stay exact, because carries are passed on to higher words.
    #[test]
    fn many_numbers_do_not_overflow() {
        let mut all = ExactSum::default();
        all.add(f64::from_bits(0x3fef_ffff_ffff_ffff));
        for _ in 0..40 {
            let half = all.clone();
            all.merge(&half);
        }
        assert_eq!(
            all.value(),
            f64::from_bits(0x3fef_ffff_ffff_ffff) * power_of_two(40)
        );
    }
}
