//! First-order density corrections to Enskog's theory of hard disks, by Monte Carlo over the
//! dynamics of three disks.
//!
//! Two disks that have just collided shield each other. A third disk that would have hit one of
//! them from behind cannot do so, or it hits the other first and sends it back to its partner.
//!
//! To first order in density only three disks matter. The third one has a uniform position without
//! overlap and a Maxwellian velocity. R. Zwanzig derived such a cluster expansion for the velocity
//! autocorrelation, *Physical Review* **129**, 486 (1963), doi:10.1103/PhysRev.129.486. Monte Carlo
//! evaluates the expansion: pairs and third disks are drawn at random, and their collisions are
//! simulated. Diameter d, mass m and temperature T are one. The number density is `n = 4 phi/pi`
//! for the packing fraction `phi`.
//!
//! # Bulk viscosity
//!
//! In Enskog's theory `zeta_E` the collisional pressure has no memory. Its rate of momentum
//! transfer depends on the conserved energy alone, so it fluctuates by independent collisions. The
//! transfer of a collision with normal speed g is `q = (m/2) g d`. At first order the slope of the
//! Helfand moment at the lag t is
//!
//! ```text
//! zeta(t) = zeta_E [1 + (2/<q²>) n ∫ dr_3 dv_3 f(v_3) <q (Q_123(t) - Q_13(t) - Q_23(t))>]
//! ```
//!
//! The mean is over pairs that have just collided, with the transfer q. `Q_123` is the transfer of
//! all later collisions of the three disks up to t. `Q_13` and `Q_23` are those of the third disk
//! with one partner, as if the other were absent. In two dimensions the integral grows as the
//! logarithm of t without a limit.
//!
//! In a box of N disks the relative change is smaller by `pi omega t/N`, for omega pair collisions
//! per disk and time, and the lag t. A pair that has collided does not collide again before it has
//! mixed, but the mean counts it like any other pair. For colliding pairs the mean of `q g²` is
//! `(<g_n³> + <g_n> <g_t²>)/2 = 4 sqrt(pi)`, where the relative velocity has the normal and
//! tangential components `g_n` and `g_t`. The mean of `g²` for all pairs is 4, and `<q>` is
//! `sqrt(pi)/2`.
//!
//! # Impact parameters after equilibrium
//!
//! A gas in elastic equilibrium loses energy from t = 0 on. Its first collisions obey molecular
//! chaos; later ones of the same three disks do not. P(b/d) is the distribution of the impact
//! parameter b over the diameter. Its slope in the collisions up to the time T is `12 <b/d - 1/2>`.
//! To first order it is n times the mean of `12 (b/d - 1/2)` over two kinds of collisions. Here
//! `tau_i` is the time for which the third disk, traced backwards from the collision of the pair,
//! flies before it touches partner i.
//!
//! - Later collisions of the three disks, at a time u after the collision of the pair, have the
//!   weight `min(tau_1, tau_2, T - u)/T`. It is the fraction of collision times of the pair before
//!   which the third disk has met neither partner.
//! - Collisions of the pair have the weight `1 - max(tau_1, tau_2)/T`, where the third disk would
//!   have met both partners, each alone. Molecular chaos removes them twice.
//!
//! Without energy loss the sum is zero, because an equilibrium gas obeys molecular chaos.
//! Collisions of the third disk with one partner alone are also chaotic, and are subtracted to
//! reduce the noise. The first order neglects further disks, so it holds for T up to the mean free
//! time.

use std::f64::consts::{PI, SQRT_2, TAU};

use nalgebra::{Vector2, vector};
use rand::{Rng, RngExt, SeedableRng};
use rand_distr::StandardNormal;
use rand_xoshiro::Xoshiro256PlusPlus;

/// Cutoff speed of the third disk in units of the thermal speed `sqrt(T/m)`: sampled positions
/// reach as far as a disk of this speed flies. Fewer than 1e-5 of Maxwellian disks are faster.
const FASTEST: f64 = 5.0;

/// First-order density coefficient of a quantity, with its Monte Carlo error. Times the packing
/// fraction, it corrects Enskog's theory.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DensityCoefficient {
    /// Value of the density coefficient: the relative correction to Enskog's theory over the
    /// packing fraction.
    pub value: f64,
    /// Monte Carlo standard error of the density coefficient.
    pub standard_error: f64,
}

/// Position and velocity of one disk, in units of the diameter and the thermal speed.
#[derive(Clone, Copy)]
struct Disk {
    place: Vector2<f64>,
    velocity: Vector2<f64>,
}

impl Disk {
    fn after(self, time: f64) -> Self {
        Self {
            place: self.place + self.velocity * time,
            ..self
        }
    }

    fn backwards(self) -> Self {
        Self {
            velocity: -self.velocity,
            ..self
        }
    }

    fn overlaps(&self, other: &Self) -> bool {
        (self.place - other.place).norm_squared() < 1.0
    }
}

/// Returns the time until two disks in free flight touch \[d sqrt(m/T)\]; `None` if they miss.
fn contact(a: &Disk, b: &Disk) -> Option<f64> {
    let (line, relative) = (a.place - b.place, a.velocity - b.velocity);
    let approach = line.dot(&relative);
    let apart = line.norm_squared() - 1.0;
    let root = approach * approach - relative.norm_squared() * apart;
    // Clamp for disks in contact that rounding left a little closer.
    (approach < 0.0 && root > 0.0).then(|| (apart / (root.sqrt() - approach)).max(0.0))
}

/// Collision of two of the three disks: time, normal speed and impact parameter.
#[derive(Clone, Copy)]
struct Meeting {
    time: f64,
    /// Normal component of the relative velocity before the collision \[sqrt(T/m)\].
    normal: f64,
    /// Impact parameter of the collision over the diameter, from 0 to 1.
    impact: f64,
}

impl Meeting {
    /// Returns the collisional momentum transfer `q = (m/2) g d` of an elastic collision with
    /// normal speed g.
    fn transfer(&self) -> f64 {
        0.5 * self.normal
    }

    /// Returns the estimate `12 (b/d - 1/2)` of the slope of P(b/d) from one collision with impact
    /// parameter b.
    fn slope(&self) -> f64 {
        12.0 * (self.impact - 0.5)
    }
}

/// Applies the inelastic collision rule to two disks that touch, and returns the collision.
fn collide(a: &mut Disk, b: &mut Disk, restitution: f64, time: f64) -> Meeting {
    let line = (a.place - b.place).normalize();
    let relative = a.velocity - b.velocity;
    let normal = relative.dot(&line);
    let change = 0.5 * (1.0 + restitution) * normal * line;
    a.velocity -= change;
    b.velocity += change;
    let cosine = normal * normal / relative.norm_squared();
    Meeting {
        time,
        normal: -normal,
        impact: (1.0 - cosine).max(0.0).sqrt(),
    }
}

/// Two disks just after their collision, with that collision. A third disk then disturbs the pair.
struct Pair {
    after: [Disk; 2],
    first: Meeting,
}

fn normal(stream: &mut impl Rng) -> Vector2<f64> {
    vector![stream.sample(StandardNormal), stream.sample(StandardNormal)]
}

impl Pair {
    fn new(before: [Disk; 2], restitution: f64) -> Self {
        let [mut a, mut b] = before;
        let first = collide(&mut a, &mut b, restitution, 0.0);
        Self {
            after: [a, b],
            first,
        }
    }
}

/// Draws two disks in contact just before a collision. The probability is proportional to the
/// normal speed times the Maxwellian distribution.
fn draw_colliding_pair(stream: &mut impl Rng) -> [Disk; 2] {
    let speed = 2.0 * (-(1.0 - stream.random::<f64>()).ln()).sqrt();
    let across: f64 = stream.sample::<f64, _>(StandardNormal) * SQRT_2;
    let (mean, half) = (normal(stream) / SQRT_2, vector![-0.5 * speed, 0.5 * across]);
    [1.0, -1.0].map(|sign| Disk {
        place: vector![0.5 * sign, 0.0],
        velocity: mean + sign * half,
    })
}

/// Draws a third disk with its statistical weight. Its distance from the contact point of the pair
/// is uniform up to `reach`, its velocity Maxwellian.
fn draw_third_disk(stream: &mut impl Rng, reach: f64) -> (Disk, f64) {
    let (share, angle): (f64, f64) = (stream.random(), TAU * stream.random::<f64>());
    let disk = Disk {
        place: reach * share * vector![angle.cos(), angle.sin()],
        velocity: normal(stream),
    };
    (disk, 2.0 * share * PI * reach * reach)
}

/// Simulates three disks, two of which have just collided, and returns all later collisions up to
/// the time `until`.
fn collisions_of_three(pair: &Pair, third: Disk, restitution: f64, until: f64) -> Vec<Meeting> {
    let mut meetings = Vec::new();
    if pair.after.iter().any(|disk| disk.overlaps(&third)) {
        return meetings;
    }
    let [a, b] = pair.after;
    let (mut disks, mut now, mut last) = ([a, b, third], 0.0, (0, 1));
    loop {
        let pairs = [(0, 1), (0, 2), (1, 2)].into_iter();
        let next = pairs.filter(|pair| *pair != last);
        let next = next.filter_map(|(i, j)| Some((contact(&disks[i], &disks[j])?, (i, j))));
        let Some((after, (i, j))) = next.min_by(|a, b| a.0.total_cmp(&b.0)) else {
            return meetings;
        };
        now += after;
        if now >= until {
            return meetings;
        }
        disks = disks.map(|disk| disk.after(after));
        let (left, right) = disks.split_at_mut(j);
        meetings.push(collide(&mut left[i], &mut right[0], restitution, now));
        last = (i, j);
    }
}

/// Returns the collisions of the third disk with each partner of the pair as if the other partner
/// were absent, up to the time `until`.
fn collisions_with_one(pair: &Pair, third: Disk, until: f64) -> impl Iterator<Item = Meeting> {
    let clear = pair
        .after
        .into_iter()
        .filter(move |disk| !disk.overlaps(&third));
    clear.filter_map(move |disk| {
        let time = contact(&disk, &third).filter(|&time| time < until)?;
        let (mut a, mut b) = (disk.after(time), third.after(time));
        Some(collide(&mut a, &mut b, 1.0, time))
    })
}

/// Sums and sums of squares of Monte Carlo samples, for means and their standard errors.
struct Sums {
    all: Vec<[f64; 2]>,
    count: f64,
}

impl Sums {
    fn new(length: usize) -> Self {
        Self {
            all: vec![[0.0; 2]; length],
            count: 0.0,
        }
    }

    fn add(&mut self, values: &[f64]) {
        self.count += 1.0;
        for (sum, value) in self.all.iter_mut().zip(values) {
            sum[0] += value;
            sum[1] += value * value;
        }
    }

    fn orders(&self, unit: f64) -> Vec<DensityCoefficient> {
        let one = |[sum, squares]: &[f64; 2]| {
            let mean = sum / self.count;
            let square = ((squares / self.count - mean * mean) / self.count).max(0.0);
            DensityCoefficient {
                value: unit * mean,
                standard_error: unit * square.sqrt(),
            }
        };
        self.all.iter().map(one).collect()
    }
}

/// Computes the density coefficient of the bulk viscosity, `(zeta(t)/zeta_E - 1)/phi`, at rising
/// lags t \[d sqrt(m/T)\]. Here `zeta_E` is Enskog's value and `phi` the packing fraction;
/// `samples` third disks are drawn.
pub fn bulk_viscosity(lags: &[f64], samples: u64, seed: u64) -> Vec<DensityCoefficient> {
    let until = lags.last().copied().unwrap_or(0.0);
    let stream = &mut Xoshiro256PlusPlus::seed_from_u64(seed);
    let mut sums = Sums::new(lags.len());
    let mut values = vec![0.0; lags.len()];
    for _ in 0..samples {
        let pair = Pair::new(draw_colliding_pair(stream), 1.0);
        let (third, weight) = draw_third_disk(stream, 1.0 + FASTEST * until);
        values.fill(0.0);
        let mut add = |one: Meeting, sign: f64| {
            for (value, _) in values
                .iter_mut()
                .zip(lags)
                .filter(|(_, lag)| one.time <= **lag)
            {
                *value += sign * weight * pair.first.transfer() * one.transfer();
            }
        };
        collisions_with_one(&pair, third, until).for_each(|one| add(one, -1.0));
        for one in collisions_of_three(&pair, third, 1.0, until) {
            add(one, 1.0);
        }
        sums.add(&values);
    }
    // <q²> is one, and n is 4 phi/pi.
    sums.orders(8.0 / PI)
}

/// Computes the density coefficient of the slope of P(b/d) in collisions up to the time `until` \[d
/// sqrt(m/T)\] after elastic equilibrium. The first result is that of elastic disks, zero in
/// theory. The others are the difference to it for each coefficient of restitution, from the same
/// random disks.
pub fn onset(
    restitutions: &[f64],
    until: f64,
    samples: u64,
    seed: u64,
) -> (DensityCoefficient, Vec<DensityCoefficient>) {
    let stream = &mut Xoshiro256PlusPlus::seed_from_u64(seed);
    let (mut elastic, mut others) = (Sums::new(1), Sums::new(restitutions.len()));
    for _ in 0..samples {
        let before = draw_colliding_pair(stream);
        let (third, weight) = draw_third_disk(stream, 1.0 + FASTEST * until);
        // Free flight of the third disk from each of the pair, backwards in time.
        let free = before.map(|disk| {
            if disk.overlaps(&third) {
                return 0.0;
            }
            contact(&disk.backwards(), &third.backwards()).unwrap_or(f64::INFINITY)
        });
        let after = |restitution: f64| -> f64 {
            let pair = Pair::new(before, restitution);
            let known = collisions_with_one(&pair, third, until);
            let known = known.map(|one| one.slope() * (until - one.time) / until);
            let later = collisions_of_three(&pair, third, restitution, until).into_iter();
            let later =
                later.map(|one| one.slope() * free[0].min(free[1]).min(until - one.time) / until);
            weight * (later.sum::<f64>() - known.sum::<f64>())
        };
        let twice = (1.0 - free[0].max(free[1]) / until).max(0.0);
        let pair = Pair::new(before, 1.0);
        let same = after(1.0);
        elastic.add(&[same + weight * twice * pair.first.slope()]);
        let values: Vec<f64> = restitutions.iter().map(|&r| after(r) - same).collect();
        others.add(&values);
    }
    let unit = 4.0 / PI;
    (elastic.orders(unit)[0], others.orders(unit))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Compares the collisions of three disks in time order with those found by small time steps.
    #[test]
    fn three_disks_move_as_disks_do() {
        let stream = &mut Xoshiro256PlusPlus::seed_from_u64(1);
        let (mut found, mut all) = (0, 0);
        while all < 300 {
            let pair = Pair::new(draw_colliding_pair(stream), 0.8);
            let (third, _) = draw_third_disk(stream, 2.5);
            if pair.after.iter().any(|disk| disk.overlaps(&third)) {
                continue;
            }
            let meetings = collisions_of_three(&pair, third, 0.8, 3.0);
            assert!(meetings.is_sorted_by_key(|one| one.time));
            assert!(meetings.iter().all(|one| one.normal > 0.0));
            let [a, b] = pair.after;
            let (mut now, mut plain, steps) = ([a, b, third], 0, 3000);
            let mut last = Some((0, 1));
            for _ in 0..steps {
                now = now.map(|disk| disk.after(3.0 / f64::from(steps)));
                for (i, j) in [(0, 1), (0, 2), (1, 2)] {
                    let line = now[i].place - now[j].place;
                    let nears = line.dot(&(now[i].velocity - now[j].velocity)) < 0.0;
                    if now[i].overlaps(&now[j]) && nears && last != Some((i, j)) {
                        let (left, right) = now.split_at_mut(j);
                        collide(&mut left[i], &mut right[0], 0.8, 0.0);
                        plain += 1;
                        last = Some((i, j));
                    }
                }
            }
            all += 1;
            found += usize::from(plain == meetings.len());
        }
        // A contact that grazes may fall between two steps, or be missed a step later.
        assert!(found >= 294, "{found} of {all} agree");
    }

    /// Tests that drawn pairs have `<q²>` = 1 and uniform impact parameters, and conserve their
    /// momentum.
    #[test]
    fn pairs_are_those_of_chaos() {
        let stream = &mut Xoshiro256PlusPlus::seed_from_u64(2);
        let (mut square, mut slope) = (0.0, 0.0);
        for _ in 0..40_000 {
            let before = draw_colliding_pair(stream);
            let pair = Pair::new(before, 0.7);
            let momentum = |disks: &[Disk; 2]| disks[0].velocity + disks[1].velocity;
            assert!((momentum(&before) - momentum(&pair.after)).norm() < 1e-12);
            assert!(contact(&pair.after[0], &pair.after[1]).is_none());
            square += pair.first.transfer().powi(2) / 40_000.0;
            slope += pair.first.slope() / 40_000.0;
        }
        // The square of q is exponential, so that its mean has an error of 0.005; that of the slope
        // is sqrt(12/40 000) = 0.017.
        assert!((square - 1.0).abs() < 4.4 * 0.005, "{square}");
        assert!(slope.abs() < 4.4 * 0.017, "{slope}");
    }

    /// Tests that the slope of P(b/d) is zero without losses, within 4.4 standard errors. With
    /// losses grazing collisions are in excess, and the bulk viscosity falls.
    #[test]
    fn equilibrium_is_chaos_and_losses_are_not() {
        let (elastic, lossy) = onset(&[0.8, 0.5], 1.0, 400_000, 3);
        assert!(
            elastic.value.abs() < 4.4 * elastic.standard_error,
            "{elastic:?}"
        );
        assert!(elastic.standard_error < 0.2, "{elastic:?}");
        assert!(lossy[1].value > 4.4 * lossy[1].standard_error, "{lossy:?}");
        assert!(lossy[0].value < lossy[1].value, "{lossy:?}");
        for one in bulk_viscosity(&[0.5, 2.0], 200_000, 3) {
            assert!(one.value < -4.4 * one.standard_error, "{one:?}");
        }
    }
}
