//! Inflows through open faces of the box: a drifting Maxwellian gas, with its flux and the velocity
//! distribution of crossing particles.

use std::f64::consts::PI;

use rand::{Rng, RngExt};
use rand_distr::{Distribution, StandardNormal};
use stosszahl_model::{Face, ParticleModel, Plane, Sizes, Space, Surface, VectorOf, Volume, Walls};

use crate::parameters::DsmcError;
use crate::particle::{DisplacementTracking, Simulator, SimulatorOf};

/// Inflow through an open face of the box: density, drift velocity and temperatures of the gas
/// beyond the face.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Inflow<S: Space> {
    /// Axis of the open face, from 0: the direction of its normal.
    pub axis: usize,
    /// Side of the box where the open face is: 0 lower, 1 upper.
    pub side: usize,
    /// Number density of the gas beyond the face \[1/length^D\].
    pub density: f64,
    /// Drift velocity of the gas beyond the face \[length/time\].
    pub velocity: S::Vector,
    /// Translational granular temperature of the gas beyond the face \[energy\].
    pub temperature: f64,
    /// Rotational granular temperature of the gas beyond the face \[energy\]; unused for smooth
    /// particles.
    pub spin_temperature: f64,
    /// Index in the table of sizes of a particle with the inflow's radius and mass; 0 for equal
    /// particles.
    pub like: usize,
}

impl Inflow<Volume> {
    /// Returns the inflow reduced to two dimensions, without the third component of its velocity.
    pub(crate) fn in_plane(&self) -> Inflow<Plane> {
        Inflow {
            axis: self.axis,
            side: self.side,
            density: self.density,
            velocity: self.velocity.xy(),
            temperature: self.temperature,
            spin_temperature: self.spin_temperature,
            like: self.like,
        }
    }
}

/// Largest number of simulators that an initial state or an inflow may bring into the box.
pub(crate) const MOST_SIMULATORS: f64 = (1_u64 << 30) as f64;

/// Inflow with its derived quantities: mass and radius of its particles, and flux through the face.
pub(crate) struct InflowSource<P: ParticleModel> {
    inflow: Inflow<P::Space>,
    tag: <P::Sizes as Sizes>::Tag,
    mass: f64,
    radius: f64,
    /// Number flux of particles through the face \[1/(length^(D-1) time)\].
    flux: f64,
}

impl<P: ParticleModel> InflowSource<P> {
    /// Checks the inflow with the index `number` and computes its flux; its face must be open.
    pub(crate) fn new(
        scene: &P,
        number: usize,
        inflow: &Inflow<P::Space>,
        walls: &Walls<P::Space>,
    ) -> Result<Self, DsmcError> {
        let refuse = |name, value, allowed| {
            Err(DsmcError::BadInflow {
                inflow: number,
                name,
                value,
                allowed,
            })
        };
        let (axis, side) = (inflow.axis, inflow.side);
        if axis >= P::Space::DIMENSION {
            return refuse("axis", axis as f64, "one of the space");
        }
        if side > 1 || *walls.face(axis, side) != Face::Open {
            return refuse("side", side as f64, "0 or 1, where the face is open");
        }
        let is_amount = |value: f64| (0.0..=1e150).contains(&value);
        for (name, value) in [
            ("density", inflow.density),
            ("temperature", inflow.temperature),
            ("spin temperature", inflow.spin_temperature),
        ] {
            if !is_amount(value) {
                return refuse(name, value, "0 to 1e150");
            }
        }
        for component in 0..P::Space::DIMENSION {
            let speed = inflow.velocity[component];
            if !is_amount(speed.abs()) {
                return refuse("velocity", speed, "a finite number up to 1e150");
            }
        }
        let sizes = scene.sizes();
        let tag = sizes.tag_of(inflow.like);
        let mass = sizes.mass(tag);
        let inwards = if side == 0 { 1.0 } else { -1.0 };
        let drift = inwards * inflow.velocity[axis];
        Ok(Self {
            inflow: *inflow,
            tag,
            mass,
            radius: sizes.radius(tag),
            flux: inflow.density * flux(drift, inflow.temperature / mass),
        })
    }

    /// Refuses an inflow whose gas would fill the box with more than [`MOST_SIMULATORS`]
    /// simulators; `weight` is the smallest number of particles per simulator.
    pub(crate) fn check_number(
        &self,
        number: usize,
        volume: f64,
        weight: f64,
    ) -> Result<(), DsmcError> {
        if self.inflow.density * volume <= MOST_SIMULATORS * weight {
            return Ok(());
        }
        Err(DsmcError::BadInflow {
            inflow: number,
            name: "density",
            value: self.inflow.density,
            allowed: "at most 2^30 simulators in the box",
        })
    }

    /// Returns axis and side of the open face through which the gas flows in.
    pub(crate) fn face(&self) -> (usize, usize) {
        (self.inflow.axis, self.inflow.side)
    }

    /// Returns the number flux of particles through the face \[1/(length^(D-1) time)\].
    pub(crate) fn flux(&self) -> f64 {
        self.flux
    }

    /// Returns mass \[mass\] and radius \[length\] of the inflowing particles.
    pub(crate) fn particle(&self) -> (f64, f64) {
        (self.mass, self.radius)
    }

    /// Draws a simulator with random position and velocity that crosses the part of the face
    /// between the corners `low` and `high`.
    pub(crate) fn draw<F: DisplacementTracking<P::Space>>(
        &self,
        scene: &P,
        [low, high]: [VectorOf<P>; 2],
        stream: &mut impl Rng,
    ) -> SimulatorOf<P, F> {
        let Inflow {
            axis,
            side,
            velocity: drift,
            temperature,
            spin_temperature,
            ..
        } = self.inflow;
        let spread = (temperature / self.mass).sqrt();
        let mut velocity = P::Space::from_components(|component| {
            let normal: f64 = StandardNormal.sample(stream);
            drift[component] + spread * normal
        });
        let inwards = if side == 0 { 1.0 } else { -1.0 };
        velocity[axis] = inwards * crossing_speed(inwards * drift[axis], spread, stream);
        let mut position =
            P::Space::from_components(|at| low[at] + (high[at] - low[at]) * stream.random::<f64>());
        position[axis] = if side == 0 { low[axis] } else { high[axis] };
        let surface = scene.surface();
        Simulator {
            position,
            velocity,
            tag: self.tag,
            mark: F::DisplacementMark::default(),
            spin: surface.thermal_spin(spin_temperature, self.mass, self.radius, stream),
        }
    }
}

/// Computes the number flux of a Maxwellian gas of unit density through a plane \[length/time\],
/// for a drift u across it and variance T/m of each velocity component: `s sqrt(T/(2 pi m))` with
/// `s = exp(-z^2) + sqrt(pi) z (1 + erf z)`, `z = u/sqrt(2T/m)`. Bird, Molecular Gas Dynamics and
/// the Direct Simulation of Gas Flows (Oxford 1994), Eq. 4.22.
fn flux(drift: f64, variance: f64) -> f64 {
    if variance == 0.0 {
        return drift.max(0.0);
    }
    let ratio = drift / (2.0 * variance).sqrt();
    let gaussian = (-ratio * ratio).exp();
    let share = if ratio > -2.0 {
        gaussian + PI.sqrt() * ratio * (1.0 + error_function(ratio))
    } else {
        // Continued fraction sqrt(pi) exp(z^2) erfc z = 1/(z + (1/2)/(z + 1/(z + (3/2)/(z +
        // ...)))): no cancellation.
        let tail = (1..=200)
            .rev()
            .fold(0.0, |tail, term| 0.5 * f64::from(term) / (tail - ratio));
        gaussian * tail / (tail - ratio)
    };
    (variance / (2.0 * PI)).sqrt() * share.max(0.0)
}

/// Computes the error function by `erf x = (2/sqrt(pi)) exp(-x^2) (x + 2 x^3/3 + 4 x^5/15 + ...)`;
/// all terms have one sign, so the error is a few roundings.
fn error_function(x: f64) -> f64 {
    if x.abs() > 6.0 {
        return 1.0_f64.copysign(x);
    }
    let (mut term, mut sum, mut odd) = (x, x, 1.0);
    while term.abs() > 1e-17 * sum.abs() {
        odd += 2.0;
        term *= 2.0 * x * x / odd;
        sum += term;
    }
    2.0 / PI.sqrt() * (-x * x).exp() * sum
}

/// Draws the normal speed of a particle that crosses a plane \[length/time\]: density `v exp(-(v -
/// u)^2/(2 s^2))`, v > 0, for drift u and thermal speed s.
///
/// Acceptance-rejection, exact for all drifts; at least three of ten candidates are accepted. In
/// units of sqrt(2) s with z = u/(sqrt(2) s): for z >= 0 the density (z + y) exp(-y^2), y > -z, is
/// bounded by z exp(-y^2) plus, for y > 0, y exp(-y^2): a Gaussian and the flux of a gas at rest.
/// For z < 0 it is v exp(-v^2) exp(-2 |z| v): one factor is drawn, the other is the acceptance.
fn crossing_speed(drift: f64, spread: f64, stream: &mut impl Rng) -> f64 {
    if spread == 0.0 {
        return drift.max(0.0);
    }
    let unit = std::f64::consts::SQRT_2 * spread;
    let z = drift / unit;
    if z >= 0.0 {
        let gaussian = z * PI.sqrt() / (z * PI.sqrt() + 0.5);
        loop {
            if stream.random::<f64>() >= gaussian {
                return unit * (z + draw_exponential(stream).sqrt());
            }
            let normal: f64 = StandardNormal.sample(stream);
            let y = normal * std::f64::consts::FRAC_1_SQRT_2;
            if y >= 0.0 || z * stream.random::<f64>() < z + y {
                return unit * (z + y);
            }
        }
    }
    let steep = -2.0 * z;
    loop {
        let (v, share) = if steep < 1.5 {
            let v = draw_exponential(stream).sqrt();
            (v, -steep * v)
        } else {
            let v = (draw_exponential(stream) + draw_exponential(stream)) / steep;
            (v, -v * v)
        };
        if stream.random::<f64>() < share.exp() {
            return unit * v;
        }
    }
}

/// Draws an exponentially distributed random number, x > 0 with density exp(-x).
fn draw_exponential(stream: &mut impl Rng) -> f64 {
    // 1 - u is above zero.
    -(1.0 - stream.random::<f64>()).ln()
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_xoshiro::Xoshiro256PlusPlus;

    /// Error function against Abramowitz & Stegun, table 7.1, to the digits given there.
    #[test]
    fn error_functions_are_the_known_ones() {
        for (x, known) in [
            (0.0, 0.0),
            (0.5, 0.520_499_877_813_046_5),
            (1.0, 0.842_700_792_949_714_9),
            (2.0, 0.995_322_265_018_952_7),
            (5.0, 0.999_999_999_998_462_5),
        ] {
            assert!((error_function(x) - known).abs() < 1e-15, "{x}");
            assert_eq!(error_function(-x), -error_function(x));
        }
        assert_eq!(error_function(7.0), 1.0);
    }

    /// Flux against the integral of v f(v), and moments of drawn speeds against the midpoint rule:
    /// 40 000 draws each, z = 4.4 of the standard error from their own variance.
    #[test]
    fn speeds_across_a_face_have_the_density_of_the_flux() {
        let mut stream = Xoshiro256PlusPlus::seed_from_u64(3);
        for drift in [-4.0, -1.5, -0.6, 0.0, 0.4, 1.0, 3.0, 20.0] {
            let spread = 0.7;
            let density = |v: f64| {
                let y = (v - drift) / spread;
                (-0.5 * y * y).exp() / (spread * (2.0 * PI).sqrt())
            };
            let (mut zeroth, mut first, mut second) = (0.0, 0.0, 0.0);
            let (cells, width) = (200_000, 1e-4 * (1.0 + f64::abs(drift) / 20.0 * 1.5));
            for cell in 0..cells {
                let v = (f64::from(cell) + 0.5) * width;
                let share = v * density(v) * width;
                zeroth += share;
                first += v * share;
                second += v * v * share;
            }
            let found = flux(drift, spread * spread);
            assert!(
                (found / zeroth - 1.0).abs() < 1e-6,
                "{drift}: {found} {zeroth}"
            );
            let draws = 40_000;
            let (mut sum, mut squares, mut fourth) = (0.0, 0.0, 0.0);
            for _ in 0..draws {
                let v = crossing_speed(drift, spread, &mut stream);
                assert!(v > 0.0);
                sum += v;
                squares += v * v;
                fourth += v.powi(4);
            }
            let n = f64::from(draws);
            let (mean, square) = (sum / n, squares / n);
            let error = ((square - mean * mean) / n).sqrt();
            assert!(
                (mean - first / zeroth).abs() < 4.4 * error,
                "{drift}: {mean}"
            );
            let error = ((fourth / n - square * square) / n).sqrt();
            assert!((square - second / zeroth).abs() < 4.4 * error, "{drift}");
        }
    }

    #[test]
    fn cold_streams_cross_at_their_drift() {
        let mut stream = Xoshiro256PlusPlus::seed_from_u64(4);
        assert_eq!(crossing_speed(2.5, 0.0, &mut stream), 2.5);
        assert_eq!(flux(2.5, 0.0), 2.5);
        assert_eq!(flux(-2.5, 0.0), 0.0);
    }
}
