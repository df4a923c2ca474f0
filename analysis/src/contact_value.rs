//! Contact value of the pair correlation function, from sums of the inverse normal speed over
//! colliding pairs.
//!
//! Of the pairs at contact, those that approach and those that separate are counted apart, so that
//! g(d+) is the sum of two parts. In a volume V, pairs that approach with a normal speed between g
//! and g + dg collide at the rate
//!
//! ```text
//! (pairs/V) Ω_D d^(D-1) g p(g) dg        with the integral of p over all g: g_pre
//! ```
//!
//! where `Ω_D` is 2π or 4π. So a sum of 1/g over the collisions of a time t is `(pairs/V) Ω_D
//! d^(D-1) t g_pre`: no velocity distribution, no temperature and no extrapolation enter. The sum
//! of 1/g' with the speed g' of separation is that of `g_post`. For a constant restitution r each
//! pair leaves with r g, so `g_post = g_pre/r` and
//!
//! ```text
//! g(d+) = g_pre (1 + 1/r) = χ (1 + r)/(2 r)        with χ = 2 g_pre
//! ```
//!
//! The *collision rate* gives another number, `χ_rate`: the rate over that of Maxwellian pairs
//! without correlations. Both agree where the normal speeds of colliding pairs are Maxwellian. They
//! differ by what inelastic partners know of each other: then pairs approach more slowly than the
//! temperature says, and there are more of them at contact than their collision rate shows.
//!
//! In a gas that cools each collision is weighted by the thermal speed of its time, and t is the
//! integral of that speed, so that all collisions count alike.
//!
//! # Error
//!
//! The density of g is linear near zero, so that 1/g has a mean and no variance. Below the speed
//! `c = CUT sqrt(T/μ)` the function 1/g is therefore replaced by
//!
//! ```text
//! w(g) = (12 - 30 x + 20 x²)/c        with x = g/c
//! ```
//!
//! whose mean is that of 1/g for every p(g) that is a polynomial of second order below the cut. The
//! weights are bounded, so standard errors over replicas are valid: some `1.4/sqrt(n)` of the value
//! for n collisions. For a Maxwellian the replacement is off by 2e-5 of the value.
//!
//! # Near contact
//!
//! For r < 1 the function g(r) itself has a cusp: pairs at the distance d + s that separate slowly
//! have missed each other, and are not more frequent. To the leading order in s
//!
//! ```text
//! g(d + s) = χ [(1 + r)/(2 r) - (1/r² - 1)/π sqrt(2 s/d)]        in the plane
//! ```
//!
//! ([`cusp`]). A polynomial through bins of g(r) misses it.

use std::f64::consts::{PI, TAU};
use std::mem;

use serde::{Deserialize, Serialize};
use stosszahl_model::{Collision, Observer};

/// Normal speed below which 1/g is replaced by a bounded function, over the thermal speed
/// `sqrt(T/μ)` of relative motion.
pub const CUT: f64 = 0.4;

/// Sums over the collisions of one pair of species in one time window, for its contact value.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Flux {
    /// Number of physical collisions, each counted with the weight of its simulators.
    pub collisions: f64,
    /// Sum of `sqrt(2 π μ)/d^(D-1)` over the collisions: the inverse mean approach speed of a
    /// Maxwellian for each collision.
    pub rate: f64,
    /// Sum over the collisions of the thermal speed `sqrt(T)` over `g d^(D-1)`, g being the normal
    /// speed before contact.
    pub approaching: f64,
    /// Sum over the collisions of the thermal speed `sqrt(T)` over `g' d^(D-1)`, g' being the
    /// normal speed after contact. Infinite if a pair does not separate.
    pub separating: f64,
}

impl Flux {
    /// Adds a collision of a gas that has the given granular temperature \[energy\].
    fn add(&mut self, collision: &Collision, dimension: usize, temperature: f64) {
        let weight = collision.weight / collision.line.norm().powi(dimension as i32 - 1);
        let (approach, separation) = (collision.approach(), collision.separation());
        let speed = temperature.sqrt();
        let cut = CUT * speed / collision.reduced_mass.sqrt();
        let before = inverse(approach, cut);
        // A law that adds speed bounds 1/g' itself, and p(g') is no polynomial there.
        let after = if approach < cut && collision.added_speed == 0.0 {
            before / collision.restitution
        } else {
            1.0 / separation
        };
        self.collisions += collision.weight;
        self.rate += weight * (TAU * collision.reduced_mass).sqrt();
        self.approaching += weight * speed * before;
        self.separating += weight * speed * after;
    }

    /// Adds the sums over another set of collisions.
    pub fn merge(&mut self, other: &Self) {
        self.collisions += other.collisions;
        self.rate += other.rate;
        self.approaching += other.approaching;
        self.separating += other.separating;
    }
}

/// Returns 1/g of the normal speed g; below the cut, a bounded function with the same mean.
fn inverse(speed: f64, cut: f64) -> f64 {
    if speed >= cut {
        return 1.0 / speed;
    }
    let x = speed / cut;
    (12.0 - 30.0 * x + 20.0 * x * x) / cut
}

/// Time window with the collision sums of each pair of species.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FluxWindow {
    /// Start and end of the window \[time\], the end not included.
    pub span: [f64; 2],
    /// Integral over time of the thermal speed `sqrt(T)`, over the part of the window that has
    /// passed.
    pub exposure: f64,
    /// Sums for each pair of species, in the order of [`pair_index`]; pairs that are missing at the
    /// end have not collided.
    kinds: Vec<Flux>,
}

impl FluxWindow {
    /// Returns the collision sums of one pair of species; zeros if the pair has not collided.
    pub fn pair_sums(&self, species: [usize; 2]) -> Flux {
        let known = self.kinds.get(pair_index(species));
        known.copied().unwrap_or_default()
    }

    /// Moves the sums out of the window, which continues from zero.
    #[must_use]
    pub fn take_sums(&mut self) -> Self {
        Self {
            span: self.span,
            exposure: mem::take(&mut self.exposure),
            kinds: mem::take(&mut self.kinds),
        }
    }

    /// Creates a time window `[start, end)` \[time\] with sums of zero.
    pub fn new(span: [f64; 2]) -> Self {
        Self {
            span,
            exposure: 0.0,
            kinds: Vec::new(),
        }
    }

    /// Adds the sums of the same window of another replica, or of another part of the time.
    pub fn merge(&mut self, other: &Self) {
        self.exposure += other.exposure;
        if self.kinds.len() < other.kinds.len() {
            self.kinds.resize(other.kinds.len(), Flux::default());
        }
        for (sums, more) in self.kinds.iter_mut().zip(&other.kinds) {
            sums.merge(more);
        }
    }

    /// Returns the normalisation of [`Flux::rate`], [`Flux::approaching`] and [`Flux::separating`]:
    /// their value for independent pairs, `(pairs/V) Ω_D` times the exposure.
    pub fn norm(&self, dimension: usize, pairs: f64, volume: f64) -> f64 {
        let directions = if dimension == 2 { TAU } else { 2.0 * TAU };
        pairs / volume * directions * self.exposure
    }
}

/// Returns the position of a pair of species in a list of all pairs: (0, 0), (0, 1), (1, 1), (0,
/// 2), ...
///
/// ```
/// use stosszahl_analysis::contact_value::pair_index;
///
/// assert_eq!([[0, 0], [1, 0], [1, 1], [0, 2]].map(pair_index), [0, 1, 2, 3]);
/// ```
pub fn pair_index([a, b]: [usize; 2]) -> usize {
    let (low, high) = (a.min(b), a.max(b));
    high * (high + 1) / 2 + low
}

/// Returns the number of pairs of two species with numbers of particles N: unlike pairs `N_a N_b`,
/// like pairs `N (N - weight)/2` of simulators of one weight.
pub fn number_of_pairs(like: bool, [a, b]: [f64; 2], weight: f64) -> f64 {
    if like { 0.5 * a * (a - weight) } else { a * b }
}

/// Returns the factor (1 + r)/(2 r) by which g(d+) exceeds the contact value χ, for restitution r;
/// infinite for r = 0.
///
/// ```
/// use stosszahl_analysis::contact_value::separation_factor;
///
/// assert!((separation_factor(0.8) - 1.125).abs() < 1e-15);
/// ```
pub fn separation_factor(restitution: f64) -> f64 {
    (1.0 + restitution) / (2.0 * restitution)
}

/// Computes the cusp of the pair correlation next to contact: the leading term of g(d + s)/χ -
/// g(d+)/χ under molecular chaos at the gap s/d. It is `-(1/r² - 1)/π sqrt(2 s/d)` in the plane,
/// `-(1/r² - 1)/2 sqrt(2 s/d)` in space.
///
/// A pair with the radial speed v and the tangential speed u has touched if v > u sqrt(2 s/d). The
/// pairs that have not lack the factor 1/r² of the density of slow separating pairs.
pub fn cusp(dimension: usize, restitution: f64, gap: f64) -> f64 {
    let tangential = if dimension == 2 { 1.0 / PI } else { 0.5 };
    -(restitution.powi(-2) - 1.0) * tangential * (2.0 * gap).sqrt()
}

/// Observer that sums 1/g of colliding pairs in time windows, by pair of species, for the contact
/// value.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ContactFlux {
    /// Collision sums of each time window; windows may overlap.
    pub windows: Vec<FluxWindow>,
    dimension: usize,
    number: f64,
    temperature: f64,
    last: f64,
}

impl ContactFlux {
    /// Creates an observer with windows `[start, end)` \[time\], for a gas of `number` particles
    /// with the given current time and temperature.
    pub fn new(
        spans: &[[f64; 2]],
        dimension: usize,
        number: f64,
        time: f64,
        temperature: f64,
    ) -> Self {
        Self {
            windows: spans.iter().map(|&span| FluxWindow::new(span)).collect(),
            dimension,
            number,
            temperature,
            last: time,
        }
    }

    /// Sets the current time and temperature, so that rounding errors of the running energy do not
    /// accumulate.
    pub fn synchronise(&mut self, time: f64, temperature: f64) {
        self.pass(time);
        self.temperature = temperature;
    }

    fn pass(&mut self, time: f64) {
        let speed = self.temperature.max(0.0).sqrt();
        for window in &mut self.windows {
            let passed = time.min(window.span[1]) - self.last.max(window.span[0]);
            window.exposure += speed * passed.max(0.0);
        }
        self.last = time;
    }
}

impl Observer for ContactFlux {
    fn on_collisions(&mut self, batch: &[Collision]) {
        for collision in batch {
            self.pass(collision.time);
            let kind = pair_index(collision.species.map(|one| one as usize));
            let (dimension, temperature) = (self.dimension, self.temperature.max(0.0));
            for window in &mut self.windows {
                if (window.span[0]..window.span[1]).contains(&collision.time) {
                    if window.kinds.len() <= kind {
                        window.kinds.resize(kind + 1, Flux::default());
                    }
                    window.kinds[kind].add(collision, dimension, temperature);
                }
            }
            let lost = collision.energy_lost() * collision.weight;
            self.temperature -= 2.0 * lost / (self.dimension as f64 * self.number);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Vector3, vector};
    use rand::{RngExt, SeedableRng};
    use rand_distr::StandardNormal;
    use rand_xoshiro::Xoshiro256PlusPlus;

    /// Means of 1/g over densities g p(g) below the cut with p = 1, g, g²: the bounded function
    /// gives those of 1/g. By Simpson's rule, which is exact for the polynomials of both.
    #[test]
    fn bounded_function_has_the_means_of_the_inverse() {
        let cut = 0.7;
        for power in 0..3 {
            let of = |speed: f64| inverse(speed, cut) * speed.powi(power + 1);
            // Fifth order, so that Simpson's rule needs parts: its error falls as their fourth
            // power, 1e-12 for 1000.
            let (parts, mut sum) = (1000, 0.0);
            for part in 0..parts {
                let [a, b] = [part, part + 1].map(|edge| cut * f64::from(edge) / f64::from(parts));
                let end = b * (1.0 - 1e-15);
                sum += (of(a) + 4.0 * of(0.5 * (a + b)) + of(end)) * (b - a) / 6.0;
            }
            let exact = cut.powi(power + 1) / f64::from(power + 1);
            assert!((sum / exact - 1.0).abs() < 1e-11, "{power}: {sum}, {exact}");
        }
    }

    /// Pairs drawn from the flux of a Maxwellian, with a plain estimator of all terms beside it.
    /// They are as many as contact values of 1 in both parts make; errors are `1.4/sqrt(n)`.
    #[test]
    fn flux_of_a_maxwellian_has_the_contact_value_one() {
        const COLLISIONS: usize = 400_000;
        const RESTITUTION: f64 = 0.8;
        let stream = &mut Xoshiro256PlusPlus::seed_from_u64(5);
        let (temperature, mass) = (2.0, 0.5);
        let mut flux = ContactFlux::new(&[[0.0, 1.0], [2.0, 3.0]], 2, 1e18, 0.0, temperature);
        let thermal = f64::sqrt(temperature / mass);
        let mut spread = [0.0; 2];
        for number in 0..COLLISIONS {
            // The normal speed of colliding pairs is Rayleigh distributed.
            let uniform: f64 = 1.0 - stream.random::<f64>();
            let normal = thermal * (-2.0 * uniform.ln()).sqrt();
            let across: f64 = stream.sample(StandardNormal);
            let relative: Vector3<f64> = vector![-normal, thermal * across, 0.0];
            flux.on_collisions(&[Collision {
                time: number as f64 / COLLISIONS as f64,
                ..Collision::at_contact(relative, vector![3.0, 0.0, 0.0], mass, RESTITUTION)
            }]);
            let one = inverse(normal, CUT * thermal) * thermal;
            spread[0] += one;
            spread[1] += one * one;
        }
        flux.synchronise(1.0, temperature);
        let window = &flux.windows[0];
        assert!((window.exposure - temperature.sqrt()).abs() < 1e-9);
        assert_eq!(flux.windows[1].exposure, 0.0);
        let sums = window.pair_sums([0, 0]);
        assert_eq!(sums.collisions, COLLISIONS as f64);
        // As many pairs in the volume as make the rate that of χ = 1.
        let norm = sums.rate;
        let count = COLLISIONS as f64;
        let mean = spread[0] / count;
        let error = ((spread[1] / count - mean * mean) / count).sqrt() / mean;
        assert!(error < 1.5 / count.sqrt(), "{error}");
        // Four errors; the bias of the cut is 2e-5.
        let before = 2.0 * sums.approaching / norm;
        assert!((before - 1.0).abs() < 4.0 * error, "{before} ± {error}");
        let total = (sums.approaching + sums.separating) / norm;
        let expected = separation_factor(RESTITUTION);
        assert!((total / expected - 1.0).abs() < 4.0 * error, "{total}");
    }

    /// A law that adds speed: 1/g' is bounded by it, and summed as it is.
    #[test]
    fn contacts_that_heat_are_summed_as_they_are() {
        let mut flux = ContactFlux::new(&[[0.0, 1.0]], 3, 2.0, 0.0, 1.0);
        let law = stosszahl_model::Separation {
            coefficient: 0.5,
            added_speed: 0.25,
        };
        let relative: Vector3<f64> = vector![-1e-3, 1.0, 0.0];
        flux.on_collisions(&[Collision {
            species: [2, 1],
            ..Collision::at_contact(relative, vector![2.0, 0.0, 0.0], 0.5, law)
        }]);
        let sums = flux.windows[0].pair_sums([1, 2]);
        assert!((sums.separating - 1.0 / (0.2505 * 4.0)).abs() < 1e-12);
        assert_eq!(flux.windows[0].pair_sums([2, 2]), Flux::default());
        assert_eq!(flux.windows[0].pair_sums([7, 2]), Flux::default());
    }
}
