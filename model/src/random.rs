//! Random streams with addresses: reproducible for any order of draws and any number of threads.
//!
//! A stream is a function of (seed, replica, purpose, address). So results do not depend on the
//! order of draws, on the number of threads, or on where a run was stopped and resumed.
//!
//! Each address is hashed into the seed of a xoshiro256++ generator: Blackman & Vigna, ACM Trans.
//! Math. Softw. 47, 36 (2021), doi:10.1145/3460772.
//!
//! A counter-based generator would need no hashing. It lost, because it costs four times as much a
//! draw once a stream is used more than a few times.

use std::convert::Infallible;

use rand::rand_core::utils::fill_bytes_via_next_word;
use rand::{SeedableRng, TryRng};
pub use rand_xoshiro::Xoshiro256PlusPlus as Stream;

/// Purpose of a random stream, part of its address; streams of different purposes are independent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u64)]
pub enum Purpose {
    /// Random positions of the initial state.
    Placement = 1,
    /// Random velocities of the initial state.
    Velocities = 2,
    /// Initial states of several simulators for each particle.
    Simulators = 3,
    /// Collisions in Monte Carlo cells; addressed by step and cell.
    Collisions = 5,
    /// Random kicks of a thermal bath; addressed by the number of the kick and the particle.
    StochasticDrive = 6,
    /// Selection and contacts of pairs in a gas without positions.
    Pairs = 7,
    /// Rebounds of particles from diffuse walls.
    Walls = 8,
    /// Particles that flow in through open faces.
    Inflow = 9,
    /// Splitting and merging of simulators where their weight changes.
    Balance = 10,
    /// Random spins of the initial state.
    Spins = 11,
}

/// Random streams of one replica of a run, from which streams for every purpose and address are
/// made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Streams {
    root: u64,
}

/// Mixes the bits of a word: one round of the finaliser of Steele, Lea & Flood's `SplitMix` (2014),
/// a bijection with full avalanche.
#[inline]
const fn mix(word: u64) -> u64 {
    let word = (word ^ (word >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let word = (word ^ (word >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    word ^ (word >> 31)
}

/// Mixes one word of an address into a hash; the odd constant keeps zero from being a fixed point.
#[inline]
const fn absorb(state: u64, word: u64) -> u64 {
    mix(state.wrapping_add(0x9e37_79b9_7f4a_7c15) ^ mix(word.wrapping_add(0x9e37_79b9_7f4a_7c15)))
}

/// Returns a hash of the bits of numbers as a fraction in \[0, 1), for a random choice that depends
/// on nothing else.
pub fn unit_hash<'a>(numbers: impl Iterator<Item = &'a f64>) -> f64 {
    let hash = numbers.fold(0, |state, number| absorb(state, number.to_bits()));
    // The 53 bits of a fraction.
    (hash >> 11) as f64 * (0.5 * f64::EPSILON)
}

impl Streams {
    /// Creates the random streams of a replica of a run.
    pub fn new(seed: u64, replica: u64) -> Self {
        Self {
            root: absorb(absorb(0, seed), replica),
        }
    }

    /// Returns random streams for one of several users that must not share theirs, by its number.
    #[must_use]
    pub fn branch(&self, user: u64) -> Self {
        Self {
            root: absorb(self.root, user),
        }
    }

    /// Returns the random stream for a purpose at an address.
    #[inline]
    pub fn stream_at(&self, purpose: Purpose, address: [u64; 2]) -> Stream {
        let key = absorb(
            absorb(absorb(self.root, purpose as u64), address[0]),
            address[1],
        );
        Stream::seed_from_u64(key)
    }

    /// Returns a bundle of many short random streams that share purpose and first half of their
    /// address.
    #[inline]
    pub fn bundle(&self, purpose: Purpose, first: u64) -> StreamBundle {
        let key = absorb(absorb(self.root, purpose as u64), first);
        StreamBundle {
            roots: [absorb(key, 0), absorb(key, 1)],
        }
    }
}

/// Bundle of short random streams that share purpose and first half of their address, and are
/// created quickly.
///
/// Where each stream gives only some ten numbers, the cost of creating it counts. Both words of a
/// stream are hashes of the second half of the address, counted from two roots of 64 bits that are
/// hashes of the rest.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StreamBundle {
    roots: [u64; 2],
}

impl StreamBundle {
    /// Returns the short random stream of the bundle at the second half of an address.
    #[inline]
    pub fn stream_at(&self, second: u64) -> ShortStream {
        let place = second.wrapping_mul(0x9e37_79b9_7f4a_7c15);
        ShortStream::new(self.roots.map(|root| mix(root.wrapping_add(place))))
    }
}

/// Random generator xoroshiro128++ (Blackman & Vigna 2021) for short streams, with the bits of the
/// one in `rand_xoshiro`. The constructor of `rand_xoshiro` is not inlined: a call for each cell
/// cost Monte Carlo a twentieth of its speed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ShortStream {
    words: [u64; 2],
}

impl ShortStream {
    /// Creates a random generator from two words of state; two zeros, which would give only zeros,
    /// are replaced.
    #[inline]
    const fn new(words: [u64; 2]) -> Self {
        let words = if words[0] | words[1] == 0 {
            [0xe220_a839_7b1d_cdaf, 0x6e78_9e6a_a1b9_65f4]
        } else {
            words
        };
        Self { words }
    }
}

impl TryRng for ShortStream {
    type Error = Infallible;

    #[inline]
    fn try_next_u32(&mut self) -> Result<u32, Infallible> {
        Ok(self.try_next_u64()? as u32)
    }

    #[inline]
    fn try_next_u64(&mut self) -> Result<u64, Infallible> {
        let [first, second] = self.words;
        let turned = first ^ second;
        self.words = [
            first.rotate_left(49) ^ turned ^ (turned << 21),
            turned.rotate_left(28),
        ];
        Ok(first
            .wrapping_add(second)
            .rotate_left(17)
            .wrapping_add(first))
    }

    #[inline]
    fn try_fill_bytes(&mut self, bytes: &mut [u8]) -> Result<(), Infallible> {
        fill_bytes_via_next_word(bytes, || self.try_next_u64())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{Rng, RngExt};
    use rand_xoshiro::Xoroshiro128PlusPlus;

    /// Short streams give the bits of the generator of another crate.
    #[test]
    fn short_streams_are_xoroshiro128() {
        let mut stream = Streams::new(1, 0).stream_at(Purpose::StochasticDrive, [0, 0]);
        let drawn = (0..1000).map(|_| stream.random());
        for words in [[0, 0], [0, 1], [1, 0]].into_iter().chain(drawn) {
            let mut short = ShortStream::new(words);
            let seed: Vec<u8> = words.into_iter().flat_map(u64::to_le_bytes).collect();
            let seed = seed.try_into().expect("sixteen bytes");
            let mut other = Xoroshiro128PlusPlus::from_seed(seed);
            for _ in 0..10 {
                assert_eq!(short.next_u64(), other.next_u64());
            }
            assert_eq!(short.next_u32(), other.next_u32());
            let mut bytes = [[0; 13]; 2];
            short.fill_bytes(&mut bytes[0]);
            other.fill_bytes(&mut bytes[1]);
            assert_eq!(bytes[0], bytes[1]);
        }
    }

    #[test]
    fn addresses_are_repeatable_and_distinct() {
        let streams = Streams::new(7, 3);
        let first = |streams: Streams, purpose, address| -> u64 {
            streams.stream_at(purpose, address).random()
        };
        let reference = first(streams, Purpose::Collisions, [5, 9]);
        assert_eq!(reference, first(streams, Purpose::Collisions, [5, 9]));
        assert_ne!(reference, first(streams, Purpose::Collisions, [9, 5]));
        assert_ne!(reference, first(streams, Purpose::Velocities, [5, 9]));
        assert_ne!(
            reference,
            first(Streams::new(3, 7), Purpose::Collisions, [5, 9])
        );
    }

    #[test]
    fn bundles_are_repeatable_and_distinct() {
        let draw = |seed, purpose, first, second| -> u64 {
            let bundle = Streams::new(seed, 0).bundle(purpose, first);
            bundle.stream_at(second).random()
        };
        let reference = draw(1, Purpose::Collisions, 5, 9);
        assert_eq!(reference, draw(1, Purpose::Collisions, 5, 9));
        for other in [
            draw(2, Purpose::Collisions, 5, 9),
            draw(1, Purpose::StochasticDrive, 5, 9),
            draw(1, Purpose::Collisions, 9, 5),
            draw(1, Purpose::Collisions, 5, 10),
        ] {
            assert_ne!(reference, other);
        }
    }

    /// First draws at consecutive addresses are as good as one stream: mean and lag correlation of
    /// uniform numbers within z = 4.4 of their exact standard errors (false alarm 1e-5 each).
    #[test]
    fn first_draws_of_neighbouring_addresses_are_independent() {
        let streams = Streams::new(1, 0);
        let count = 200_000_u64;
        check_independence((0..count).map(|cell| {
            let mut stream = streams.stream_at(Purpose::Collisions, [cell / 1000, cell % 1000]);
            stream.random()
        }));
        // The first and the third draw of short streams.
        for skip in [0, 2] {
            check_independence((0..count).map(|cell| {
                let bundle = streams.bundle(Purpose::Collisions, cell / 1000);
                let mut stream = bundle.stream_at(cell % 1000);
                for _ in 0..skip {
                    stream.random::<u64>();
                }
                stream.random()
            }));
        }
    }

    fn check_independence(draws: impl Iterator<Item = f64>) {
        let draws: Vec<f64> = draws.map(|draw| draw - 0.5).collect();
        let n = draws.len() as f64;
        let mean = draws.iter().sum::<f64>() / n;
        assert!(mean.abs() < 4.4 * (1.0 / 12.0 / n).sqrt(), "mean {mean}");
        for lag in [1, 2, 1000] {
            let products: f64 = draws.windows(lag + 1).map(|w| w[0] * w[lag]).sum();
            let correlation = products / n;
            assert!(
                correlation.abs() < 4.4 / 12.0 / n.sqrt(),
                "lag {lag}: {correlation}"
            );
        }
    }
}
