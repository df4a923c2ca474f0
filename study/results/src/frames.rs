//! Particle frames: positions and velocities at many times, quantised for animation in a report
//! page.
//!
//! Positions take sixteen bits along each axis, directions and speeds eight, and the last collision
//! four and four. If there are too many particles, or simulators of unequal weight, a fair sample
//! is kept: each kept particle stands for equally many. The choice depends on particle numbers
//! alone, so a particle with a fixed number is in all frames or in none. The order is unrelated to
//! position and velocity, so the first few of a frame are a fair sample too.
//!
//! Functions that make frames are `inline`, so that they are compiled where they are used: this
//! crate is compiled with little optimisation, and a run makes many frames.

use std::f64::consts::TAU;
use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::error::ResultsError;
use crate::regular;

/// Name of the folder of frames inside the results folder of a run.
pub const FRAMES: &str = "frames";
/// Largest speed that a frame resolves, over the root mean square speed of all particles.
pub const FASTEST: f64 = 4.0;
/// Number of steps that resolve the energy of the last collision partner, and the last impact
/// parameter; 0 is unknown.
pub const STEPS: u8 = 15;
/// Largest kinetic energy of a collision partner that a frame resolves, over the mean of all
/// particles.
pub const HOTTEST: f64 = 4.0;

/// Particle frame: particles of one engine at one time, in two dimensions, quantised to bytes.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ParticleFrame {
    /// Time of the frame, in the unit of time of the case.
    pub time: f64,
    /// Sides of the box of the gas \[length\].
    pub sides: [f64; 2],
    /// True for each axis along which the box is periodic.
    pub periodic: [bool; 2],
    /// Number of particles of the gas, before sampling; simulators count with their weights.
    pub particles: f64,
    /// Number of particles of the gas that each particle in the frame stands for.
    pub share: f64,
    /// Root mean square speed of all particles of the gas \[length/time\].
    pub speed: f64,
    /// Largest radius of the particles of the gas \[length\].
    pub radius: f64,
    /// Abscissae of the particles in units of the side, two bytes each, the lower one first.
    #[serde(with = "serde_bytes")]
    pub x: Vec<u8>,
    /// Ordinates of the particles in units of the side, two bytes each, the lower one first.
    #[serde(with = "serde_bytes")]
    pub y: Vec<u8>,
    /// Directions of the velocities: 256 for a full turn, 0 along the abscissa.
    #[serde(with = "serde_bytes")]
    pub direction: Vec<u8>,
    /// Speeds of the particles: 255 for [`FASTEST`] times the root mean square.
    #[serde(with = "serde_bytes")]
    pub pace: Vec<u8>,
    /// Radii: 255 for the largest radius; empty if all are equal.
    #[serde(with = "serde_bytes")]
    pub size: Vec<u8>,
    /// Last collision of each particle, in [`STEPS`] steps: square root of the partner's energy in
    /// the upper four bits, impact parameter in the lower ones. 0 before the first collision; empty
    /// if the engine does not distinguish particles.
    #[serde(with = "serde_bytes")]
    pub met: Vec<u8>,
}

/// Last collision of a particle: energy of the partner, and impact parameter.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct LastCollision {
    /// Current kinetic energy of the collision partner, over the mean of all particles.
    pub partner: f64,
    /// Impact parameter of the last collision over the contact distance, from 0 to 1.
    pub impact: f64,
}

impl LastCollision {
    #[inline]
    fn byte(self) -> u8 {
        let step = |share: f64| 1 + (share.clamp(0.0, 1.0) * f64::from(STEPS - 1)).round() as u8;
        (step((self.partner / HOTTEST).sqrt()) << 4) | step(self.impact)
    }
}

/// Particle from which a frame is made: position, velocity, radius, weight and last collision.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Dot {
    /// Position of the centre \[length\].
    pub position: [f64; 2],
    /// Velocity of the centre \[length/time\].
    pub velocity: [f64; 2],
    /// Radius of the particle \[length\].
    pub radius: f64,
    /// Number of particles of the gas that this one stands for, such as the weight of a simulator.
    pub weight: f64,
    /// Last collision of the particle; `None` if unknown.
    pub met: Option<LastCollision>,
}

/// Computes a pseudorandom hash of a particle number (the finaliser of `SplitMix64`).
#[inline]
fn hash_number(index: u64) -> u64 {
    let mut mixed = index.wrapping_add(1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    mixed = (mixed ^ (mixed >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    mixed ^ (mixed >> 31)
}

/// Totals over all particles of a gas that scale its frame, such as the mean squared speed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Crowd {
    /// Number of particles of the gas: the sum of the weights.
    pub particles: f64,
    /// Largest weight of a particle.
    pub heaviest: f64,
    /// Sum of the weights times the squared speeds \[length²/time²\].
    pub squares: f64,
    /// Smallest and largest radius of a particle \[length\]; `None` without particles.
    pub radii: Option<[f64; 2]>,
}

impl Crowd {
    /// Adds a particle of a given weight to the totals.
    #[inline]
    pub fn add(&mut self, weight: f64, radius: f64, velocity: [f64; 2]) {
        self.particles += weight;
        self.squares += weight * (velocity[0].powi(2) + velocity[1].powi(2));
        self.widen(weight, radius);
    }

    /// Widens the ranges of weight and radius to include a particle, without changing the sums.
    #[inline]
    pub fn widen(&mut self, weight: f64, radius: f64) {
        self.heaviest = self.heaviest.max(weight);
        let [low, high] = self.radii.unwrap_or([radius; 2]);
        self.radii = Some([low.min(radius), high.max(radius)]);
    }

    /// Widens the ranges of weight and radius to those of other totals, without changing the sums.
    pub fn widen_by(&mut self, other: &Self) {
        if let Some([low, high]) = other.radii {
            self.widen(other.heaviest, low);
            self.widen(other.heaviest, high);
        }
    }

    /// Returns the number of particles that each sampled particle stands for, if about `most` are
    /// sampled.
    pub fn kept_share(&self, most: usize) -> f64 {
        let share = self.particles / most.max(1) as f64;
        share.max(self.heaviest).max(1.0)
    }
}

/// Returns true if a frame of the player shows a particle with this number: with the probability
/// `weight / share`, where `share` is the weight for which each particle shown stands.
#[inline]
pub fn keeps(number: u64, weight: f64, share: f64) -> bool {
    hash_number(number) as f64 / 2_f64.powi(64) * share < weight
}

impl ParticleFrame {
    /// Creates a frame of at most about `most` of the particles `dots`, whose particle numbers are
    /// their indices.
    #[inline]
    pub fn new(time: f64, sides: [f64; 2], periodic: [bool; 2], dots: &[Dot], most: usize) -> Self {
        let mut crowd = Crowd::default();
        for dot in dots {
            crowd.add(dot.weight, dot.radius, dot.velocity);
        }
        let share = crowd.kept_share(most);
        let kept = (0..).zip(dots.iter().copied());
        let kept = kept.filter(|(number, dot)| keeps(*number, dot.weight, share));
        Self::of_particles(time, sides, periodic, &crowd, share, kept.collect())
    }

    /// Creates a frame from `kept`: the sampled particles with their particle numbers, which decide
    /// the order in the frame. Each stands for `share` particles of the gas `crowd`.
    #[inline]
    pub fn of_particles(
        time: f64,
        sides: [f64; 2],
        periodic: [bool; 2],
        crowd: &Crowd,
        share: f64,
        mut kept: Vec<(u64, Dot)>,
    ) -> Self {
        let particles = crowd.particles;
        let speed = if particles > 0.0 {
            (crowd.squares / particles).sqrt()
        } else {
            0.0
        };
        let [smallest, radius] = crowd.radii.unwrap_or_default();
        let equal = smallest == radius;
        let told = kept.iter().any(|(_, dot)| dot.met.is_some());
        // Sorted by a second hash, so that the order is unrelated to weights.
        kept.sort_by_cached_key(|(number, _)| hash_number(hash_number(*number)));
        let mut frame = Self {
            time,
            sides,
            periodic,
            particles,
            share,
            speed,
            radius,
            ..Self::default()
        };
        for (_, dot) in kept {
            for (axis, places) in [&mut frame.x, &mut frame.y].into_iter().enumerate() {
                let within = (dot.position[axis] / sides[axis]).clamp(0.0, 1.0);
                let place = (within * 65536.0).min(65535.0) as u16;
                places.extend_from_slice(&place.to_le_bytes());
            }
            let turn = dot.velocity[1].atan2(dot.velocity[0]) / TAU;
            frame
                .direction
                .push(((turn.rem_euclid(1.0) * 256.0).round() as u32 % 256) as u8);
            let pace =
                dot.velocity[0].hypot(dot.velocity[1]) / (FASTEST * speed.max(f64::MIN_POSITIVE));
            frame.pace.push((pace.min(1.0) * 255.0).round() as u8);
            if !equal {
                frame.size.push((dot.radius / radius * 255.0).round() as u8);
            }
            if told {
                frame.met.push(dot.met.map_or(0, LastCollision::byte));
            }
        }
        frame
    }

    /// Returns the number of particles in the frame.
    pub fn len(&self) -> usize {
        self.direction.len()
    }

    /// Returns true if the frame has no particles.
    pub fn is_empty(&self) -> bool {
        self.direction.is_empty()
    }

    /// Returns a frame of the first `count` particles of this frame, which are a fair sample.
    #[must_use]
    pub fn first(&self, count: usize) -> Self {
        let count = count.min(self.len());
        let part = |all: &[u8], bytes: usize| all[..(count * bytes).min(all.len())].to_vec();
        let share = if count == 0 {
            self.share
        } else {
            self.share * self.len() as f64 / count as f64
        };
        Self {
            share,
            x: part(&self.x, 2),
            y: part(&self.y, 2),
            direction: part(&self.direction, 1),
            pace: part(&self.pace, 1),
            size: part(&self.size, 1),
            met: part(&self.met, 1),
            ..self.clone()
        }
    }
}

/// Serializes particle frames as the bytes of a file.
///
/// # Errors
/// [`ResultsError::System`] if they cannot be encoded, which is an error of the program.
pub fn to_bytes(frames: &[ParticleFrame]) -> Result<Vec<u8>, ResultsError> {
    let failed =
        |error| ResultsError::system(Path::new(FRAMES), "written")(std::io::Error::other(error));
    postcard::to_stdvec(frames).map_err(failed)
}

/// Reads a file of particle frames.
///
/// # Errors
/// [`ResultsError`] if the file cannot be read, or is damaged.
pub fn read_frames(path: &Path) -> Result<Vec<ParticleFrame>, ResultsError> {
    let failed = |error| ResultsError::system(path, "read")(error);
    let bytes = regular::read_bytes(path).map_err(failed)?;
    postcard::from_bytes(&bytes).map_err(|error| failed(std::io::Error::other(error)))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Gas in a box of 10 x 5: simulators on the left stand for one particle, those on the right
    /// for a quarter.
    fn gas() -> Vec<Dot> {
        let dot = |i: u32| Dot {
            position: [f64::from(i % 1000) * 0.01, f64::from(i / 1000) * 0.05],
            velocity: [f64::from(i % 7) - 3.0, f64::from(i % 5) - 2.0],
            radius: 0.5,
            weight: if i % 1000 < 500 { 1.0 } else { 0.25 },
            met: None,
        };
        (0..100_000).map(dot).collect()
    }

    #[test]
    fn each_that_is_kept_stands_for_as_many() {
        let dots = gas();
        for most in [usize::MAX, 10_000] {
            let frame = ParticleFrame::new(1.0, [10.0, 5.0], [true; 2], &dots, most);
            let left = frame.x.chunks(2).filter(|place| place[1] < 128).count();
            let (left, all) = (left as f64, frame.len() as f64);
            // Of 62 500 particles 50 000 are on the left; tolerance: five binomial standard
            // deviations.
            let spread = 5.0 * (0.8 * 0.2 / all).sqrt();
            assert!((left / all - 0.8).abs() < spread, "{left} of {all}");
            let expected = 62_500.0 / frame.share;
            assert!((all - expected).abs() < 5.0 * expected.sqrt());
            assert!(frame.particles == 62_500.0 && frame.size.is_empty());
        }
    }

    #[test]
    fn the_same_particles_are_in_each_frame_and_the_first_are_fair() {
        let mut dots = gas();
        let before = ParticleFrame::new(1.0, [10.0, 5.0], [true; 2], &dots, 5000);
        for dot in &mut dots {
            dot.velocity = [1.0, 0.0];
        }
        let after = ParticleFrame::new(2.0, [10.0, 5.0], [true; 2], &dots, 5000);
        assert!(before.x == after.x && before.direction != after.direction);
        // Direction 0, and the root mean square speed, a quarter of the range.
        assert!(
            after.pace.iter().all(|pace| *pace == 64)
                && after.direction.iter().all(|turn| *turn == 0)
        );
        let first = before.first(1000);
        let left = first.x.chunks(2).filter(|place| place[1] < 128).count() as f64;
        assert!(
            (left / 1000.0 - 0.8).abs() < 5.0 * (0.16_f64 / 1000.0).sqrt(),
            "{left}"
        );
        assert_eq!(first.x, before.x[..2000]);
    }

    #[test]
    fn places_are_within_a_step() {
        let at = |x: f64, y: f64| Dot {
            position: [x, y],
            velocity: [0.0, -2.0],
            radius: x,
            weight: 1.0,
            met: None,
        };
        let dots = [at(0.0, 5.0), at(9.999_999, 1.0), at(2.5, -0.1)];
        let frame = ParticleFrame::new(0.0, [10.0, 5.0], [false; 2], &dots, 10);
        let number = |bytes: &[u8]| f64::from(u16::from_le_bytes([bytes[0], bytes[1]])) / 65536.0;
        let mut places: Vec<(f64, f64)> = (frame.x.chunks(2).zip(frame.y.chunks(2)))
            .map(|(x, y)| (10.0 * number(x), 5.0 * number(y)))
            .collect();
        places.sort_by(|a, b| a.0.total_cmp(&b.0));
        for (found, (x, y)) in places
            .iter()
            .zip([(0.0, 5.0), (2.5, 0.0), (9.999_999, 1.0)])
        {
            // Positions below the box are drawn at its edge.
            assert!((found.0 - x).abs() <= 10.0 / 65536.0 && (found.1 - y).abs() <= 5.0 / 65536.0);
        }
        assert!(frame.direction.iter().all(|turn| *turn == 192));
        assert_eq!(frame.size.len(), 3);
        assert_eq!(
            ParticleFrame::new(0.0, [1.0; 2], [true; 2], &[], 10).len(),
            0
        );
    }

    #[test]
    fn the_last_collision_is_told_in_steps() {
        let dot = |met| Dot {
            position: [0.5; 2],
            velocity: [1.0, 0.0],
            radius: 0.5,
            weight: 1.0,
            met,
        };
        let byte = |partner, impact| LastCollision { partner, impact }.byte();
        assert_eq!(byte(0.0, 0.0), 0x11);
        assert_eq!(byte(HOTTEST, 1.0), 0xff);
        // The mean energy is in the middle, as its root is half of the largest; values beyond are
        // clamped.
        assert_eq!((byte(1.0, 0.5), byte(1e9, 2.0)), (0x88, 0xff));
        let frame = |known: &[Option<LastCollision>]| {
            let dots: Vec<Dot> = known.iter().map(|met| dot(*met)).collect();
            let mut met = ParticleFrame::new(0.0, [1.0; 2], [true; 2], &dots, 10).met;
            met.sort_unstable();
            met
        };
        let (partner, impact) = (1.0, 0.5);
        assert_eq!(
            frame(&[None, Some(LastCollision { partner, impact })]),
            [0, 0x88]
        );
        assert!(frame(&[None, None]).is_empty());
    }
}
