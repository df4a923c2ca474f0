//! SIMD search for the particles within a radius of a point, in two dimensions.

use crate::extrema::{larger, smaller};

/// Number of particles tested at once by SIMD; lists of positions are padded by as many.
pub(super) const LANES: usize = 8;

/// Number of lines of cells tested at once in a search around a point.
pub(super) const LINES: usize = 3;

/// Bit mask of the low bits of a squared distance that hold the particle's number, below [`LINES`]
/// times [`LANES`].
const NUMBERS: u64 = 31;

/// Padding of SIMD lanes with infinite squared distances: the slice `[LANES - n..]` masks all but
/// the first n lanes.
pub(super) const BEYOND: [f64; 2 * LANES] = {
    let mut beyond = [0.0; 2 * LANES];
    let mut lane = LANES;
    while lane < 2 * LANES {
        beyond[lane] = f64::MAX;
        lane += 1;
    }
    beyond
};

/// Particles in adjacent cells of a line, in two dimensions: their coordinates and number.
#[derive(Clone, Copy)]
pub(super) struct CellRow<'a> {
    pub(super) positions: [&'a [f64; LANES]; 2],
    pub(super) count: usize,
}

impl CellRow<'_> {
    /// Returns lower bounds of the squared distances in each SIMD lane: zero, but infinite for
    /// lanes beyond the number of particles.
    #[inline(always)]
    fn least(&self) -> &[f64] {
        let first = LANES - self.count.min(LANES);
        &BEYOND[first..first + LANES]
    }
}

/// Result of a search around a point: particles within the radius, and the nearest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct SearchResult {
    /// Bit mask of the particles within the search radius, one bit for each SIMD lane of each line
    /// of cells.
    pub(super) near: u32,
    /// Number of the particle nearest to the point, in the order of the bit mask.
    pub(super) nearest: usize,
    /// Squared distance of the nearest particle from the point \[length^2\]; its last bits hold the
    /// particle's number.
    pub(super) square: f64,
}

impl SearchResult {
    /// Creates a search result from the bit mask of near particles and the least squared distance,
    /// whose last bits hold the particle's number.
    #[inline(always)]
    fn new(near: u32, best: f64) -> Self {
        Self {
            near,
            nearest: (best.to_bits() & NUMBERS) as usize,
            square: best,
        }
    }
}

/// Interface of the search within a radius for a SIMD width of the processor; all implementations
/// give identical bits.
pub(super) trait SimdBackend: Copy {
    /// Finds, among particles in three lines of cells, those within `sqrt(limit)` of a point and
    /// the nearest one, without the particle numbered `but`.
    fn look(
        self,
        runs: &[CellRow<'_>; LINES],
        point: [f64; 2],
        limit: f64,
        but: usize,
    ) -> SearchResult;

    /// Returns the index of the set bit in `bits` that follows `skip` other set bits.
    fn bit_after(self, bits: u32, skip: u32) -> u32;
}

/// Portable implementation of the radius search without explicit SIMD; same bits as [`Avx2`].
#[derive(Clone, Copy, Debug)]
pub(super) struct Plain;

impl SimdBackend for Plain {
    #[inline(always)]
    fn look(
        self,
        runs: &[CellRow<'_>; LINES],
        point: [f64; 2],
        limit: f64,
        but: usize,
    ) -> SearchResult {
        // Squares are not negative, so their bits sort as integers.
        let (mut near, mut best) = (0, [f64::MAX; LANES]);
        for (line, run) in runs.iter().enumerate() {
            let [xs, ys] = run.positions;
            let least = run.least();
            for lane in 0..LANES {
                let [x, y] = [xs[lane] - point[0], ys[lane] - point[1]];
                let number = LANES * line + lane;
                let least = [least[lane], f64::MAX][usize::from(number == but)];
                let square = larger(x * x + y * y, least);
                near |= u32::from(square < limit) << number;
                let square = f64::from_bits((square.to_bits() & !NUMBERS) | number as u64);
                best[lane] = smaller(best[lane], square);
            }
        }
        SearchResult::new(near, best.into_iter().fold(f64::MAX, smaller))
    }

    #[inline(always)]
    fn bit_after(self, bits: u32, skip: u32) -> u32 {
        let left = (0..skip).fold(bits, |bits, _| bits & bits.wrapping_sub(1));
        left.trailing_zeros()
    }
}

/// AVX2 implementation of the radius search, four lanes at once. A value exists only if the
/// processor supports AVX2.
#[cfg(target_arch = "x86_64")]
#[derive(Clone, Copy, Debug)]
pub(super) struct Avx2(());

#[cfg(target_arch = "x86_64")]
impl Avx2 {
    /// Returns the AVX2 implementation if the processor supports it; `None` otherwise.
    pub(super) fn detect() -> Option<Self> {
        use std::arch::is_x86_feature_detected as has;

        let can = has!("avx2") && has!("bmi1") && has!("bmi2") && has!("lzcnt") && has!("popcnt");
        can.then_some(Self(()))
    }
}

#[cfg(target_arch = "x86_64")]
#[allow(
    unsafe_code,
    reason = "the compiler does not know that the processor was asked"
)]
impl SimdBackend for Avx2 {
    #[inline(always)]
    fn look(
        self,
        runs: &[CellRow<'_>; LINES],
        point: [f64; 2],
        limit: f64,
        but: usize,
    ) -> SearchResult {
        let (mut near, mut best) = (0, [f64::MAX; LANES / 2]);
        for (line, run) in runs.iter().enumerate() {
            for part in 0..2 {
                let first = LANES * line + LANES / 2 * part;
                let place = but.wrapping_sub(first);
                // SAFETY: the processor has these instructions, or there would be no `self`.
                let bits =
                    unsafe { avx2::look(run, [part, first, place], point, limit, &mut best) };
                near |= bits << first;
            }
        }
        // SAFETY: as above.
        SearchResult::new(near, unsafe { avx2::least(best) })
    }

    #[inline(always)]
    fn bit_after(self, bits: u32, skip: u32) -> u32 {
        // SAFETY: as above.
        unsafe { bit_with_bmi2(bits, skip) }
    }
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "bmi1,bmi2")]
#[inline]
fn bit_with_bmi2(bits: u32, skip: u32) -> u32 {
    use std::arch::x86_64::_pdep_u32;

    _pdep_u32(1 << (skip & 31), bits).trailing_zeros()
}

/// Steps of the radius search with AVX2 instructions, small enough for the compiler to inline.
#[cfg(target_arch = "x86_64")]
mod avx2 {
    use std::arch::x86_64::{
        __m256d, _CMP_LT_OQ, _mm_cvtsd_f64, _mm_min_pd, _mm_unpackhi_pd, _mm256_add_epi64,
        _mm256_add_pd, _mm256_and_pd, _mm256_castpd256_pd128, _mm256_castsi256_pd, _mm256_cmp_pd,
        _mm256_cmpeq_epi64, _mm256_extractf128_pd, _mm256_max_pd, _mm256_min_pd,
        _mm256_movemask_pd, _mm256_mul_pd, _mm256_or_pd, _mm256_set1_epi64x, _mm256_set1_pd,
        _mm256_setr_epi64x, _mm256_setr_pd, _mm256_sub_pd,
    };

    use super::{CellRow, LANES, NUMBERS};

    const HALF: usize = LANES / 2;

    #[target_feature(enable = "avx2,bmi1,bmi2,lzcnt,popcnt")]
    #[inline]
    fn half(all: &[f64], part: usize) -> __m256d {
        let some = &all[HALF * part..HALF * (part + 1)];
        _mm256_setr_pd(some[0], some[1], some[2], some[3])
    }

    /// Tests half of a line's particles, `part` 0 or 1, for the distance from a point. Returns a
    /// bit mask of the near ones and updates the least square of each lane. `first` is the number
    /// of the first particle; `but` is the lane to ignore.
    #[target_feature(enable = "avx2,bmi1,bmi2,lzcnt,popcnt")]
    #[inline]
    pub(super) fn look(
        run: &CellRow<'_>,
        [part, first, but]: [usize; 3],
        point: [f64; 2],
        limit: f64,
        best: &mut [f64; HALF],
    ) -> u32 {
        let [xs, ys] = run.positions;
        let across = _mm256_sub_pd(half(xs, part), _mm256_set1_pd(point[0]));
        let along = _mm256_sub_pd(half(ys, part), _mm256_set1_pd(point[1]));
        let square = _mm256_add_pd(_mm256_mul_pd(across, across), _mm256_mul_pd(along, along));
        let places = _mm256_setr_epi64x(0, 1, 2, 3);
        let numbers = _mm256_add_epi64(places, _mm256_set1_epi64x(first as i64));
        // All bits set, a NaN: neither near nor the least.
        let is_but = _mm256_cmpeq_epi64(places, _mm256_set1_epi64x(but as i64));
        let square = _mm256_max_pd(square, half(run.least(), part));
        let square = _mm256_or_pd(square, _mm256_castsi256_pd(is_but));
        let near = _mm256_cmp_pd::<_CMP_LT_OQ>(square, _mm256_set1_pd(limit));
        let kept = _mm256_castsi256_pd(_mm256_set1_epi64x(!NUMBERS as i64));
        let numbered = _mm256_or_pd(_mm256_and_pd(square, kept), _mm256_castsi256_pd(numbers));
        let least = _mm256_min_pd(numbered, half(best, 0));
        let low = _mm256_castpd256_pd128(least);
        let high = _mm256_extractf128_pd::<1>(least);
        *best = [
            _mm_cvtsd_f64(low),
            _mm_cvtsd_f64(_mm_unpackhi_pd(low, low)),
            _mm_cvtsd_f64(high),
            _mm_cvtsd_f64(_mm_unpackhi_pd(high, high)),
        ];
        _mm256_movemask_pd(near) as u32
    }

    #[target_feature(enable = "avx2,bmi1,bmi2,lzcnt,popcnt")]
    #[inline]
    pub(super) fn least(best: [f64; HALF]) -> f64 {
        let best = half(&best, 0);
        let two = _mm_min_pd(
            _mm256_castpd256_pd128(best),
            _mm256_extractf128_pd::<1>(best),
        );
        _mm_cvtsd_f64(_mm_min_pd(two, _mm_unpackhi_pd(two, two)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_xoshiro::Xoshiro256PlusPlus;

    /// Searches particle by particle: mask of those within the radius, and the nearest.
    fn one_by_one(
        runs: &[CellRow<'_>; LINES],
        point: [f64; 2],
        limit: f64,
        but: usize,
    ) -> (u32, Option<usize>) {
        let (mut near, mut nearest) = (0, None);
        for (line, run) in runs.iter().enumerate() {
            for lane in 0..run.count.min(LANES) {
                let apart = [0, 1].map(|axis| run.positions[axis][lane] - point[axis]);
                let square = apart[0].powi(2) + apart[1].powi(2);
                let number = LANES * line + lane;
                if number == but {
                    continue;
                }
                near |= u32::from(square < limit) << number;
                if nearest.is_none_or(|(least, _)| square < least) {
                    nearest = Some((square, number));
                }
            }
        }
        (near, nearest.map(|(_, number)| number))
    }

    /// Both implementations agree with a loop over particles, for empty, filled and overfull lines.
    #[test]
    fn all_ways_see_the_same() {
        let mut stream = Xoshiro256PlusPlus::seed_from_u64(9);
        for _ in 0..2000 {
            let places: [[[f64; LANES]; 2]; LINES] =
                std::array::from_fn(|_| std::array::from_fn(|_| stream.random()));
            let counts: [usize; LINES] = std::array::from_fn(|_| stream.random_range(0..10));
            let runs: [CellRow; LINES] = std::array::from_fn(|line| CellRow {
                positions: [&places[line][0], &places[line][1]],
                count: counts[line],
            });
            let point = [stream.random(), stream.random()];
            let (limit, but) = (0.2 * stream.random::<f64>(), stream.random_range(0..30));
            let (near, nearest) = one_by_one(&runs, point, limit, but);
            let seen = Plain.look(&runs, point, limit, but);
            assert_eq!(seen.near, near);
            match nearest {
                Some(number) => assert_eq!(seen.nearest, number),
                None => assert!(seen.square > 1e300),
            }
            let bits: Vec<u32> = (0..32).filter(|bit| near >> bit & 1 > 0).collect();
            for (skip, &bit) in bits.iter().enumerate() {
                assert_eq!(Plain.bit_after(near, skip as u32), bit);
            }
            #[cfg(target_arch = "x86_64")]
            if let Some(wide) = Avx2::detect() {
                assert_eq!(wide.look(&runs, point, limit, but), seen);
                for (skip, &bit) in bits.iter().enumerate() {
                    assert_eq!(wide.bit_after(near, skip as u32), bit);
                }
            }
        }
    }
}
