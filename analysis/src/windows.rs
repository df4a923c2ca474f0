//! Collision statistics in time windows: impact parameters, and the four factors of the dissipation
//! identity.
//!
//! In a gas of equal disks with constant restitution the cooling rate is
//! `zeta = (1 - r^2) m/(4 T) . (omega/2) . 2 <(g.k)^2>/D`, an identity. Divided by its
//! molecular-chaos value it is the product of
//!
//! * the collision rate over Enskog's, omega/`omega_E`,
//! * the squared relative speed of colliding pairs over chaos, `<g^2>/(6 T/m)`,
//! * the impact parameters, `<1 - b^2/d^2>/(2/3)`,
//! * the correlation of speed and impact parameter,
//!   `<g^2 (1 - b^2/d^2)>/(<g^2><1 - b^2/d^2>)`.
//!
//! Spheres have 8 T/m in place of 6 T/m and 1/2 in place of 2/3. Impact parameters are uniform on
//! the cross-section of the partners, so (b/d)^(D-1) is uniform under chaos: b/d of disks, its
//! square of spheres.
//!
//! So any difference between two engines at the same temperature splits into these four factors. T
//! is that of the *total* kinetic energy. In a gas that flows, most of it can be flow; a speed
//! factor far below one then says that partners share the flow, not that chaos fails.
//! [`crate::contacts`] takes the local temperature at contact instead.
//!
//! All factors are relative to the temperature *at the moment of each collision*, which the
//! observer knows from the energy lost so far. So windows in which the gas cools by decades mix no
//! temperatures.

mod pairs;

use serde::{Deserialize, Serialize};
use stosszahl_model::{Collision, Observer};

use crate::replicas::pseudo_values;

pub use pairs::{PairBins, PairKind};

/// Sums over the collisions in one time window, for impact parameters and the dissipation identity.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CollisionWindow {
    /// Dimension of space: 2 or 3.
    pub dimension: usize,
    /// Start of the time window \[time\].
    pub start: f64,
    /// End of the time window \[time\], not included.
    pub end: f64,
    /// Histogram of collisions by |b|/d, in bins of equal width from 0 to 1.
    pub bins: Vec<u64>,
    /// Number of pair collisions observed; collisions of simulators in Monte Carlo.
    pub collisions: u64,
    /// Number of physical collisions: sum of the weights of colliding simulators.
    pub physical_collisions: f64,
    /// Sum over collisions of |b|/d, the impact parameter over the contact distance.
    pub impact: f64,
    /// Sum over collisions of the squared impact parameter (b/d)^2, over the contact distance.
    pub impact_square: f64,
    /// Sum over collisions of (b/d)^4 of spheres; 0 for disks, which do not need it.
    pub impact_fourth: f64,
    /// Sum over collisions of m g^2/T, with the relative speed g.
    pub square: f64,
    /// Sum over collisions of m (g.k)^2/T, with the normal relative speed g.k.
    pub normal_square: f64,
    /// Integral over time of the thermal speed sqrt(T/m), over the part of the window that has
    /// passed \[length\].
    pub root_temperature: f64,
}

impl CollisionWindow {
    /// Computes the mean of |b|/d: 1/2 for disks and 2/3 for spheres under molecular chaos. `None`
    /// without collisions.
    pub fn mean_impact(&self) -> Option<f64> {
        (self.collisions > 0).then(|| self.impact / self.collisions as f64)
    }

    /// Returns the sums over collisions of (b/d)^(D-1), which is uniform under molecular chaos, and
    /// of its square.
    fn uniform(&self) -> [f64; 2] {
        if self.dimension == 2 {
            [self.impact, self.impact_square]
        } else {
            [self.impact_square, self.impact_fourth]
        }
    }

    /// Adds the sums of the same window in another replica.
    pub fn merge(&mut self, other: &Self) {
        for (count, more) in self.bins.iter_mut().zip(&other.bins) {
            *count += more;
        }
        self.collisions += other.collisions;
        self.physical_collisions += other.physical_collisions;
        self.impact += other.impact;
        self.impact_square += other.impact_square;
        self.impact_fourth += other.impact_fourth;
        self.square += other.square;
        self.normal_square += other.normal_square;
        self.root_temperature += other.root_temperature;
    }

    /// Computes the slope s of the least-squares line P(u) = 1 + s (u - 1/2) of u = (b/d)^(D-1):
    /// s = 12 (`<u>` - 1/2). Positive where grazing collisions are in excess.
    pub fn slope(&self) -> Option<f64> {
        (self.collisions > 0).then(|| 12.0 * (self.uniform()[0] / self.collisions as f64 - 0.5))
    }

    /// Computes the standard error that [`Self::slope`] would have with independent collisions.
    /// Collisions of one clustered gas are not independent: the spread over replicas is compared
    /// with this error.
    pub fn slope_error(&self) -> Option<f64> {
        let n = self.collisions as f64;
        let [mean, square] = self.uniform().map(|sum| sum / n);
        let variance = (square - mean * mean).max(0.0);
        (self.collisions > 0).then(|| 12.0 * (variance / n).sqrt())
    }

    /// Returns the probability of each bin of |b|/d under molecular chaos.
    pub fn chances(&self) -> Vec<f64> {
        let bins = self.bins.len();
        (0..bins).map(|bin| self.chaos(bin) / bins as f64).collect()
    }

    /// Returns the probability density of |b|/d in a bin under molecular chaos: 1 for disks, 2 b/d
    /// for spheres.
    pub fn chaos(&self, bin: usize) -> f64 {
        if self.dimension == 2 {
            1.0
        } else {
            (2 * bin + 1) as f64 / self.bins.len() as f64
        }
    }

    /// Computes the factors of the dissipation identity. `theory` is the collision rate of
    /// molecular chaos per particle in units of sqrt(T/m), from
    /// `stosszahl_model::equation_of_state::collision_rate`. `disks` is the number of particles in one
    /// replica.
    pub fn dissipation(&self, theory: f64, disks: usize) -> Option<DissipationFactors> {
        if self.collisions == 0 || self.root_temperature <= 0.0 {
            return None;
        }
        let n = self.collisions as f64;
        let d = self.dimension as f64;
        let expected = 0.5 * disks as f64 * theory * self.root_temperature;
        let rate = self.physical_collisions / expected;
        let speed = self.square / n / (2.0 * (d + 1.0));
        let impact = (1.0 - self.impact_square / n) * (0.5 * (d + 1.0));
        let total = self.normal_square / n / 4.0;
        Some(DissipationFactors {
            rate,
            speed,
            impact,
            correlation: total / (speed * impact),
            dissipation: rate * total,
        })
    }
}

/// Dissipation identity: cooling rate over that of molecular chaos, and its four factors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DissipationFactors {
    /// Collision rate over that of Enskog's theory.
    pub rate: f64,
    /// Speed factor: mean <g^2> of colliding pairs over its value 2 (D + 1) T/m under molecular
    /// chaos.
    pub speed: f64,
    /// Impact parameter factor: mean <1 - b^2/d^2> of colliding pairs over its value 2/(D + 1)
    /// under molecular chaos.
    pub impact: f64,
    /// Mean <g^2(1 - b^2/d^2)> over the product <g^2><1 - b^2/d^2>: correlation of speed and impact
    /// parameter.
    pub correlation: f64,
    /// Cooling rate over that of molecular chaos: the product of all four factors.
    pub dissipation: f64,
}

impl DissipationFactors {
    /// Computes the cooling rate over that of molecular chaos at the squared speed of colliding
    /// pairs, instead of at the total kinetic energy. Energy is lost as the power 3/2 of that
    /// square. The effect of waves and clusters on the speeds of pairs cancels.
    pub fn at_pair_speed(&self) -> f64 {
        self.dissipation / self.speed.powf(1.5)
    }
}

/// Observer that sums over collisions in time windows. The factors of the dissipation identity are
/// valid for equal particles only.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CollisionWindows {
    /// Collision sums of each time window; windows may overlap.
    pub windows: Vec<CollisionWindow>,
    /// Impact parameters by pair of species; `None` in a gas of one species.
    pub pairs: Option<PairBins>,
    dimension: usize,
    temperature: f64,
    disks: usize,
    last: f64,
}

impl CollisionWindows {
    /// Creates an observer with time windows `[start, end)` \[time\] of `bins` bins each, for a gas
    /// of `disks` particles with time `start` and granular temperature `temperature`.
    pub fn new(
        spans: &[[f64; 2]],
        bins: usize,
        disks: usize,
        start: f64,
        temperature: f64,
    ) -> Self {
        let windows = spans
            .iter()
            .map(|&[start, end]| CollisionWindow {
                dimension: 2,
                start,
                end,
                bins: vec![0; bins],
                collisions: 0,
                physical_collisions: 0.0,
                impact: 0.0,
                impact_square: 0.0,
                impact_fourth: 0.0,
                square: 0.0,
                normal_square: 0.0,
                root_temperature: 0.0,
            })
            .collect();
        Self {
            windows,
            pairs: None,
            dimension: 2,
            temperature,
            disks,
            last: start,
        }
    }

    /// Returns this observer for a gas of disks (2) or spheres (3).
    #[must_use]
    pub fn in_dimension(mut self, dimension: usize) -> Self {
        self.dimension = dimension;
        for window in &mut self.windows {
            window.dimension = dimension;
        }
        self
    }

    /// Sets the current time and granular temperature, so that rounding errors of the running
    /// energy do not accumulate.
    pub fn synchronise(&mut self, time: f64, temperature: f64) {
        self.pass(time);
        self.temperature = temperature;
    }

    #[inline]
    fn pass(&mut self, time: f64) {
        let speed = self.temperature.max(0.0).sqrt();
        for window in &mut self.windows {
            let passed = time.min(window.end) - self.last.max(window.start);
            if passed > 0.0 {
                window.root_temperature += speed * passed;
            }
        }
        self.last = time;
    }
}

/// Merges the same window of several replicas; `None` without replicas.
pub fn merged(windows: &[&CollisionWindow]) -> Option<CollisionWindow> {
    let (first, rest) = windows.split_first()?;
    let mut sum = (*first).clone();
    for one in rest {
        sum.merge(one);
    }
    Some(sum)
}

/// Computes the pseudo-values ([`pseudo_values`]) over replicas of a number that follows from the
/// sums of one window. Replicas without the number are left out.
pub fn pooled(
    windows: &[&CollisionWindow],
    of: impl Fn(&CollisionWindow) -> Option<f64>,
) -> Vec<f64> {
    let known = windows.iter().filter(|one| of(one).is_some());
    let known: Vec<CollisionWindow> = known.map(|one| (*one).clone()).collect();
    pseudo_values(&known, CollisionWindow::merge, |window| {
        of(window).unwrap_or(f64::NAN)
    })
}

impl Observer for CollisionWindows {
    fn on_collisions(&mut self, batch: &[Collision]) {
        for collision in batch {
            self.collision(collision);
        }
    }
}

impl CollisionWindows {
    fn collision(&mut self, collision: &Collision) {
        self.pass(collision.time);
        let mut known = None;
        for (number, window) in self.windows.iter_mut().enumerate() {
            if !(window.start..window.end).contains(&collision.time) {
                continue;
            }
            let (impact_square, square, normal_square) = *known.get_or_insert_with(|| {
                let mass = 2.0 * collision.reduced_mass / self.temperature;
                let square = collision.relative_velocity.norm_squared() * mass;
                (
                    collision.impact_square(),
                    square,
                    collision.normal_square() * mass,
                )
            });
            let impact = impact_square.sqrt();
            if let Some(pairs) = &mut self.pairs {
                pairs.count(number, collision, impact);
            }
            let bins = window.bins.len();
            window.bins[((impact * bins as f64) as usize).min(bins - 1)] += 1;
            window.collisions += 1;
            window.physical_collisions += collision.weight;
            window.impact += impact;
            window.impact_square += impact_square;
            if window.dimension > 2 {
                window.impact_fourth += impact_square * impact_square;
            }
            window.square += square;
            window.normal_square += normal_square;
        }
        // T = 2 K/(D N).
        let share = 2.0 / self.dimension as f64;
        self.temperature -= collision.energy_lost() * share * collision.weight / self.disks as f64;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Vector3, vector};

    #[test]
    fn sums_of_two_collisions_by_hand() {
        let mut windows = CollisionWindows::new(&[[0.0, 1.0], [1.0, 3.0]], 4, 10, 0.0, 2.0);
        let collision = |time: f64, relative: Vector3<f64>| Collision {
            time,
            ..Collision::at_contact(relative, Vector3::x(), 0.5, 0.0)
        };
        // Central: g^2 = 4, loss (mu/2) 4 = 1, so T = 2 - 1/10 after it.
        windows.collision(&collision(0.5, vector![-2.0, 0.0, 0.0]));
        // b/d = 3/5.
        windows.collision(&collision(2.0, vector![-0.8, 0.6, 0.0]));
        windows.synchronise(3.5, 1.0);
        let [first, second] = &windows.windows[..] else {
            panic!("two windows")
        };
        assert_eq!(first.bins, [1, 0, 0, 0]);
        assert_eq!(second.bins, [0, 0, 1, 0]);
        assert!((first.square - 4.0 / 2.0).abs() < 1e-15);
        assert!((second.normal_square - 0.64 / 1.9).abs() < 1e-15);
        assert!((second.impact - 0.6).abs() < 1e-15);
        assert!((first.root_temperature - 0.5 * (2.0_f64.sqrt() + 1.9_f64.sqrt())).abs() < 1e-15);
        let after = 1.9 - 0.5 * 0.5 * 0.64 / 10.0_f64;
        assert!((second.root_temperature - (1.9_f64.sqrt() + after.sqrt())).abs() < 1e-14);
        let slope = second.slope().expect("a collision");
        assert!((slope - 1.2).abs() < 1e-14);
    }

    #[test]
    fn factors_multiply_to_the_cooling_rate() {
        let mut windows = CollisionWindows::new(&[[0.0, 1.0]], 4, 2, 0.0, 1.0);
        for (time, relative) in [
            (0.1, vector![-1.0, 0.2, 0.0]),
            (0.4, vector![-0.3, 0.9, 0.0]),
            (0.7, vector![-2.0, 1.0, 0.0]),
        ] {
            let collision = Collision {
                time,
                ..Collision::at_contact(relative, Vector3::x(), 0.5, 0.9)
            };
            windows.collision(&collision);
        }
        let d = windows.windows[0].dissipation(1.7, 2).expect("collisions");
        assert!((d.rate * d.speed * d.impact * d.correlation - d.dissipation).abs() < 1e-14);
    }
}
