//! Contact times of two disks in free flight: roots of a quadratic equation, for one pair or for
//! many candidates of a disk.

use nalgebra::Vector2;

/// Returns the time until two disks in free flight touch; `None` if they never do.
///
/// With the separation r, the relative velocity g, b = r . g and c = r^2 - d^2, contact is at
/// t = c/(-b + sqrt(b^2 - g^2 c)), the root that loses no digits at slow approach. Receding pairs
/// (b >= 0) never touch, which also covers a pair that has just collided. A pair that overlaps by
/// rounding and approaches gets a time that is negative by rounding.
///
/// ```
/// use nalgebra::vector;
/// let t = stosszahl_ed::time_to_contact(vector![3.0, 0.0], vector![-2.0, 0.0], 1.0, f64::INFINITY);
/// assert_eq!(t, Some(1.0));
/// ```
///
/// `limit`: contacts at or after it are of no interest; most candidates are refused by it before
/// the square root, as t >= c/(-2b).
#[inline(always)]
pub fn time_to_contact(
    separation: Vector2<f64>,
    relative: Vector2<f64>,
    distance_squared: f64,
    limit: f64,
) -> Option<f64> {
    let b = separation.dot(&relative);
    if b >= 0.0 {
        return None;
    }
    let c = separation.norm_squared() - distance_squared;
    if c > -2.0 * b * limit {
        return None;
    }
    let discriminant = b * b - relative.norm_squared() * c;
    if discriminant < 0.0 {
        return None;
    }
    let time = c / (discriminant.sqrt() - b);
    (time < limit).then_some(time)
}

/// Buffer of collision candidates of one disk: other disks that will touch it, unless something
/// happens before.
///
/// Which candidate will touch is unpredictable, and a wrong prediction of the processor costs as
/// much as the evaluation of two. So all candidates undergo the same operations without a branch.
/// Only candidates that will touch, about one in five, need the root and the division.
#[derive(Clone, Debug)]
pub(crate) struct Candidates {
    touching: [Touching; Self::ROOM],
    count: usize,
}

#[derive(Clone, Copy, Debug)]
struct Touching {
    b: f64,
    c: f64,
    discriminant: f64,
    disk: u32,
    /// Time from now until the next predicted contact of the candidate `disk` itself.
    until_its_own: f64,
}

impl Touching {
    #[inline(always)]
    fn time(&self) -> f64 {
        self.c / (self.discriminant.sqrt() - self.b)
    }
}

impl Candidates {
    const ROOM: usize = 16;

    pub(crate) fn new() -> Self {
        let none = Touching {
            b: -1.0,
            c: f64::INFINITY,
            discriminant: 0.0,
            disk: 0,
            until_its_own: 0.0,
        };
        Self {
            touching: [none; Self::ROOM],
            count: 0,
        }
    }

    /// Adds a collision candidate if it will touch the disk; true if the buffer is full. A contact
    /// later than `until_its_own`, the time until the candidate's own next contact, does not count:
    /// the candidate predicts again then.
    #[inline(always)]
    pub(crate) fn add(
        &mut self,
        disk: u32,
        separation: Vector2<f64>,
        relative: Vector2<f64>,
        distance_squared: f64,
        until_its_own: f64,
    ) -> bool {
        let b = separation.dot(&relative);
        let c = separation.norm_squared() - distance_squared;
        let discriminant = b * b - relative.norm_squared() * c;
        self.keep(Touching {
            b,
            c,
            discriminant,
            disk,
            until_its_own,
        })
    }

    /// Adds a collision candidate at any distance, as in wide cells, if it will touch the disk;
    /// true if the buffer is full. The discriminant `(r.g)^2 - g^2 (r^2 - d^2)` is written as `g^2
    /// d^2 - (r x g)^2`, in which nothing of the order of r^2 cancels. Slower than [`Self::add`],
    /// and rounded differently.
    #[inline(always)]
    pub(crate) fn add_far(
        &mut self,
        disk: u32,
        separation: Vector2<f64>,
        relative: Vector2<f64>,
        distance_squared: f64,
        until_its_own: f64,
    ) -> bool {
        let cross = separation.perp(&relative);
        self.keep(Touching {
            b: separation.dot(&relative),
            c: separation.norm_squared() - distance_squared,
            discriminant: relative.norm_squared() * distance_squared - cross * cross,
            disk,
            until_its_own,
        })
    }

    #[inline(always)]
    fn keep(&mut self, candidate: Touching) -> bool {
        let touches = (candidate.b < 0.0) & (candidate.discriminant >= 0.0);
        self.touching[self.count % Self::ROOM] = candidate;
        self.count += usize::from(touches);
        self.count == Self::ROOM
    }

    /// Returns time and disk of the earliest contact before `limit` among the candidates, the first
    /// added of simultaneous ones, and empties the buffer.
    ///
    /// Each time equals [`time_to_contact`], bit by bit. `slides` returns true for a disk that
    /// touches already, with its b = r . g, if its contact does not count.
    #[inline(always)]
    pub(crate) fn earliest(
        &mut self,
        mut limit: f64,
        slides: impl Fn(u32, f64) -> bool,
    ) -> Option<(f64, u32)> {
        let mut found = None;
        for pair in self.spend() {
            let time = pair.time();
            if time < limit
                && time <= pair.until_its_own
                && !(time <= 0.0 && slides(pair.disk, pair.b))
            {
                limit = time;
                found = Some((time, pair.disk));
            }
        }
        found
    }

    /// Returns contact time and number of all candidates, also of those with an earlier contact of
    /// their own, and empties the buffer.
    pub(crate) fn all_candidates(
        &mut self,
        slides: impl Fn(u32, f64) -> bool,
    ) -> impl Iterator<Item = (f64, u32)> {
        self.spend().iter().filter_map(move |pair| {
            let time = pair.time();
            (!(time <= 0.0 && slides(pair.disk, pair.b))).then_some((time, pair.disk))
        })
    }

    #[inline(always)]
    fn spend(&mut self) -> &[Touching] {
        &self.touching[..std::mem::take(&mut self.count).min(Self::ROOM)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::vector;
    use parry2d_f64::math::{Pose, Vector};
    use parry2d_f64::query::{ShapeCastOptions, cast_shapes};
    use parry2d_f64::shape::Ball;
    use rand::{RngExt, SeedableRng};

    /// Contact times agree with parry's closed-form ball-ball cast, an independent implementation
    /// whose accuracy is 2e-14 at gaps from 1e-6 on; 1e-12 relative leaves room for ill-conditioned
    /// grazing.
    #[test]
    fn agrees_with_the_shape_cast_of_parry() {
        let mut stream = rand_xoshiro::Xoshiro256PlusPlus::seed_from_u64(3);
        let ball = Ball::new(0.5);
        let vector = |ours: Vector2<f64>| Vector::new(ours[0], ours[1]);
        let mut hits = 0;
        for _ in 0..20_000 {
            let angle = stream.random_range(0.0..std::f64::consts::TAU);
            let gap = 10.0_f64.powf(stream.random_range(-6.0..0.5));
            let separation = vector![angle.cos(), angle.sin()] * (1.0 + gap);
            let relative = vector![
                stream.random_range(-1.0..1.0),
                stream.random_range(-1.0..1.0)
            ];
            let ours = time_to_contact(separation, relative, 1.0, f64::INFINITY);
            let theirs = cast_shapes(
                &Pose::from_translation(vector(separation)),
                vector(relative),
                &ball,
                &Pose::identity(),
                Vector::ZERO,
                &ball,
                ShapeCastOptions::default(),
            )
            .expect("balls are supported")
            .map(|hit| hit.time_of_impact);
            let grazing = {
                let b = separation.dot(&relative);
                let g = relative.norm_squared();
                (b * b - g * (separation.norm_squared() - 1.0)).abs() < 1e-6 * g
            };
            match (ours, theirs) {
                (Some(a), Some(b)) => {
                    hits += 1;
                    assert!(grazing || (a - b).abs() <= 1e-12 * (1.0 + b), "{a} {b}");
                }
                (None, None) => {}
                (a, b) => assert!(grazing, "{a:?} {b:?}"),
            }
        }
        assert!(hits > 5_000);
    }

    /// Candidates give the same partner and the same bits as one by one; every other candidate has
    /// a contact of its own before long.
    #[test]
    fn candidates_give_the_earliest_of_all() {
        let mut stream = rand_xoshiro::Xoshiro256PlusPlus::seed_from_u64(4);
        let mut candidates = Candidates::new();
        let (mut hits, mut left) = (0, 0);
        for round in 0..20_000 {
            let count = round % (Candidates::ROOM + 1);
            let limit = if round % 3 == 0 { 1.0 } else { f64::INFINITY };
            let mut expected = None;
            let mut least = limit;
            for disk in 0..count as u32 {
                let mut number = || stream.random_range(-2.0..2.0_f64);
                let separation = vector![number(), number()];
                let separation = separation * (1.0 + 1.0 / separation.norm());
                let relative = vector![number(), number()];
                let until_its_own = if disk % 2 == 0 {
                    number().abs()
                } else {
                    f64::INFINITY
                };
                candidates.add(disk, separation, relative, 1.0, until_its_own);
                match time_to_contact(separation, relative, 1.0, least) {
                    Some(time) if time <= until_its_own => {
                        least = time;
                        expected = Some((time, disk));
                    }
                    late => left += u32::from(late.is_some()),
                }
            }
            hits += u32::from(expected.is_some());
            assert_eq!(candidates.earliest(limit, |_, _| false), expected);
        }
        assert!(hits > 5_000 && left > 3_000, "{hits} {left}");
    }

    /// Contacts from 1e6 diameters away are found where the disks touch, to the rounding of their
    /// positions, and pairs that miss each other by 1e-9 diameters miss. Squares of separations
    /// would be off by 1e-4.
    #[test]
    fn far_contacts_are_exact() {
        let mut stream = rand_xoshiro::Xoshiro256PlusPlus::seed_from_u64(5);
        for _ in 0..1000 {
            let angle = stream.random_range(0.0..std::f64::consts::TAU);
            let (along, across) = (
                vector![angle.cos(), angle.sin()],
                vector![-angle.sin(), angle.cos()],
            );
            for (impact, touches) in [(0.3, true), (1.0 - 1e-9, true), (1.0 + 1e-9, false)] {
                let (separation, relative) = (along * 1e6 + across * impact, along * -0.7);
                let mut candidates = Candidates::new();
                candidates.add_far(1, separation, relative, 1.0, f64::INFINITY);
                let found = candidates.earliest(f64::INFINITY, |_, _| false);
                assert_eq!(found.is_some(), touches, "{impact}");
                if let Some((time, _)) = found {
                    // Places are rounded to 1e6 times 2e-16, some times over; a grazing contact
                    // moves by the root of that.
                    let off = (separation + relative * time).norm() - 1.0;
                    assert!(off.abs() < 2e-9, "{off:e}");
                }
            }
        }
    }

    #[test]
    fn limits_and_receding_pairs() {
        let apart = vector![2.0, 0.0];
        assert_eq!(
            time_to_contact(apart, vector![1.0, 0.0], 1.0, f64::INFINITY),
            None
        );
        assert_eq!(
            time_to_contact(apart, vector![0.0, 0.0], 1.0, f64::INFINITY),
            None
        );
        assert_eq!(time_to_contact(apart, vector![-1.0, 0.0], 1.0, 1.0), None);
        assert_eq!(
            time_to_contact(apart, vector![-1.0, 0.0], 1.0, 1.0 + 1e-15),
            Some(1.0)
        );
        // Overlap by rounding while approaching: at once.
        let now = time_to_contact(vector![1.0 - 1e-16, 0.0], vector![-1.0, 0.0], 1.0, 1.0);
        assert!(now.is_some_and(|time| time <= 0.0 && time > -1e-15));
    }
}
