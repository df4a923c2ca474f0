//! Random initial velocities with zero momentum, a given temperature and a given fourth cumulant,
//! and Maxwellian spins.

use rand::Rng;
use rand_distr::{Distribution, Gamma, StandardNormal};

use crate::invalid::InvalidValue;
use crate::physics::{ParticleModel, VectorOf};
use crate::sizes::Sizes;
use crate::space::Space;
use crate::state::State;
use crate::surface::Surface;

/// Isotropic velocity distribution with a given fourth cumulant `a2 = D/(D + 2) <v^4>/<v^2>^2 - 1`.
///
/// The squared speed follows a Gamma distribution with the shape `k = 1/((1 + a2)(D + 2)/D - 1)`:
/// the Maxwellian at a2 = 0, one speed for all particles at the least a2 possible, `-2/(D + 2)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VelocityDistribution(Shape);

/// Distribution of the squared speed in units of T/m, by its fourth cumulant.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Shape {
    Maxwellian,
    OneSpeed,
    Gamma(Gamma<f64>),
}

impl VelocityDistribution {
    /// Maxwellian velocity distribution, with fourth cumulant a2 = 0.
    pub const MAXWELLIAN: Self = Self(Shape::Maxwellian);
    /// Largest fourth cumulant a2 of a velocity distribution: beyond it a few particles have nearly
    /// all of the energy.
    pub const LARGEST_CUMULANT: f64 = 10.0;

    /// Returns the smallest fourth cumulant that a velocity distribution in D dimensions can have,
    /// `-2/(D + 2)`.
    pub fn least_cumulant(dimension: usize) -> f64 {
        -2.0 / (dimension as f64 + 2.0)
    }

    /// Creates a velocity distribution with the fourth cumulant `a2` in `dimension` dimensions.
    ///
    /// # Errors
    /// [`InvalidValue`] below [`Self::least_cumulant`], which no distribution has, and above
    /// [`Self::LARGEST_CUMULANT`].
    pub fn new(dimension: usize, a2: f64) -> Result<Self, InvalidValue> {
        let allowed = if dimension == 2 {
            "from -0.5, all particles of one speed, to 10"
        } else {
            "from -0.4, all particles of one speed, to 10"
        };
        let fits = (Self::least_cumulant(dimension)..=Self::LARGEST_CUMULANT).contains(&a2);
        InvalidValue::require(fits, "fourth cumulant", a2, allowed)?;
        if a2 == 0.0 {
            return Ok(Self::MAXWELLIAN);
        }
        let d = dimension as f64;
        // Relative variance of the squared speed, 1/k.
        let variance = (1.0 + a2) * (d + 2.0) / d - 1.0;
        if variance < 1e-12 {
            return Ok(Self(Shape::OneSpeed));
        }
        Gamma::new(variance.recip(), d * variance)
            .map(|gamma| Self(Shape::Gamma(gamma)))
            .map_err(|_| InvalidValue::new("fourth cumulant", a2, allowed))
    }

    /// Draws a random velocity for a particle whose thermal speed `sqrt(T/m)` is `spread`
    /// \[length/time\].
    pub fn draw<S: Space>(&self, spread: f64, stream: &mut impl Rng) -> S::Vector {
        let square = match &self.0 {
            Shape::Maxwellian => {
                let mut velocity = S::Vector::default();
                for axis in 0..S::DIMENSION {
                    let normal: f64 = StandardNormal.sample(stream);
                    velocity[axis] = spread * normal;
                }
                return velocity;
            }
            Shape::OneSpeed => S::DIMENSION as f64,
            Shape::Gamma(gamma) => gamma.sample(stream),
        };
        S::random_direction(stream) * (spread * square.sqrt())
    }
}

/// Gives all particles of a state Maxwellian velocities without drift and with exactly the
/// temperature `temperature` \[energy\], see [`draw_velocities`].
pub fn maxwellian<P: ParticleModel>(
    scene: &P,
    state: &mut State<P>,
    temperature: f64,
    stream: &mut impl Rng,
) {
    let law = VelocityDistribution::MAXWELLIAN;
    draw_velocities(scene, state, temperature, law, stream);
}

/// Gives all particles of a state random velocities by a distribution, without drift and with
/// exactly the temperature `temperature` \[energy\]. One particle alone stays at rest: zero
/// momentum allows nothing else.
pub fn draw_velocities<P: ParticleModel>(
    scene: &P,
    state: &mut State<P>,
    temperature: f64,
    law: VelocityDistribution,
    stream: &mut impl Rng,
) {
    let sizes = scene.sizes();
    for (index, body) in state.bodies.iter_mut().enumerate() {
        let spread = (temperature / sizes.mass(sizes.tag_of(index))).sqrt();
        body.velocity = law.draw::<P::Space>(spread, stream);
    }
    rescale(scene, state, temperature);
}

/// Removes the drift of the centre of mass and scales the velocities to the temperature
/// `temperature` \[energy\].
pub fn rescale<P: ParticleModel>(scene: &P, state: &mut State<P>, temperature: f64) {
    let sizes = scene.sizes();
    let mass: f64 = (0..state.bodies.len())
        .map(|index| sizes.mass(sizes.tag_of(index)))
        .sum();
    // The second pass removes what the rounding of the first left behind, the third what scaling
    // did.
    for _ in 0..3 {
        let drift: VectorOf<P> = state.momentum(scene) * (1.0 / mass.max(f64::MIN_POSITIVE));
        for body in &mut state.bodies {
            body.velocity -= drift;
        }
        let found = state.temperature(scene);
        if found > 0.0 && state.bodies.len() > 1 {
            let factor = (temperature / found).sqrt();
            for body in &mut state.bodies {
                body.velocity = body.velocity * factor;
            }
        } else {
            for body in &mut state.bodies {
                body.velocity = VectorOf::<P>::default();
            }
        }
    }
}

/// Gives all particles of a state Maxwellian spins with exactly the temperature I <w^2>/rotations
/// \[energy\]; does nothing for smooth particles.
pub fn thermal_spins<P: ParticleModel>(
    scene: &P,
    state: &mut State<P>,
    temperature: f64,
    stream: &mut impl Rng,
) {
    let sizes = scene.sizes();
    for (index, body) in state.bodies.iter_mut().enumerate() {
        let tag = sizes.tag_of(index);
        let (mass, radius) = (sizes.mass(tag), sizes.radius(tag));
        body.spin = scene
            .surface()
            .thermal_spin(temperature, mass, radius, stream);
    }
    let found = state.spin_temperature(scene);
    if found > 0.0 {
        let factor = (temperature / found).sqrt();
        for body in &mut state.bodies {
            body.spin = <P::Surface as Surface<P::Space>>::scale_spin(body.spin, factor);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::{Purpose, Streams};
    use crate::space::Vector;
    use crate::{Constant, Domain, Free, ParticleState, Plane, Polydisperse, Rough, Scene, Smooth};
    use nalgebra::vector;

    /// Fourth cumulants of 200 samples of 2000 velocities: their mean lies within 4.4 of its
    /// measured standard errors of the requested value, which 10 tests fail once in 10^4 times by
    /// chance. The error is at most a tenth of the smallest a2 here. The mean of a ratio is biased
    /// by some (1 + a2)/2000 of it, less than that error.
    #[test]
    fn fourth_cumulants_are_those_asked_for() {
        fn measured<S: Space>(a2: f64) -> [f64; 2] {
            let law = VelocityDistribution::new(S::DIMENSION, a2).expect("a distribution");
            let mut stream = Streams::new(7, 0).stream_at(Purpose::Velocities, [0, 0]);
            let d = S::DIMENSION as f64;
            let sample = |_: i32| {
                let squares = (0..2000).map(|_| law.draw::<S>(3.0, &mut stream).square());
                let (second, fourth) = squares.fold((0.0, 0.0), |(a, b), x| (a + x, b + x * x));
                let (second, fourth) = (second / 2000.0, fourth / 2000.0);
                (second, d / (d + 2.0) * fourth / (second * second) - 1.0)
            };
            let all: Vec<(f64, f64)> = (0..200).map(sample).collect();
            let mean = all.iter().map(|one| one.1).sum::<f64>() / 200.0;
            let spread = all.iter().map(|one| (one.1 - mean).powi(2)).sum::<f64>() / 199.0;
            let energy = all.iter().map(|one| one.0).sum::<f64>() / 200.0;
            // 400 000 squared speeds with a relative variance below 3.5: 4.4 standard errors are
            // 1.3 %.
            assert!((energy / (9.0 * d) - 1.0).abs() < 0.013, "{a2}: {energy}");
            [mean, (spread / 200.0).sqrt()]
        }
        for a2 in [-0.3, -0.1, 0.0, 0.2, 1.0] {
            for [found, error] in [measured::<Plane>(a2), measured::<crate::Volume>(a2)] {
                assert!((found - a2).abs() < 4.4 * error, "{a2}: {found}({error})");
                assert!(error < 0.01, "{a2}: {error}");
            }
        }
        let one = VelocityDistribution::new(2, -0.5).expect("one speed");
        let mut stream = Streams::new(8, 0).stream_at(Purpose::Velocities, [0, 0]);
        let velocity = one.draw::<Plane>(3.0, &mut stream);
        // Rounding of a unit vector.
        assert!((velocity.square() / 18.0 - 1.0).abs() < 1e-14);
        for (dimension, a2) in [(2, -0.51), (3, -0.41), (2, 11.0), (3, f64::NAN)] {
            assert!(VelocityDistribution::new(dimension, a2).is_err());
        }
    }

    /// Momentum to N roundings of a thermal momentum, temperature to a few roundings: 1e-12 and
    /// 1e-14.
    #[test]
    fn momentum_vanishes_and_temperature_is_exact() {
        let count = 1000;
        let sizes = (0..count).map(|i| (0.5, 1.0 + f64::from(i % 7))).collect();
        let scene = Scene {
            space: Plane,
            surface: Smooth,
            restitution: Constant::new(1.0).expect("a coefficient"),
            sizes: Polydisperse::new(sizes).expect("positive"),
            field: Free,
        };
        let mut state = State {
            time: 0.0,
            domain: Domain::periodic(vector![100.0, 100.0]).expect("positive"),
            bodies: vec![ParticleState::new(vector![0.0, 0.0], vector![0.0, 0.0]); count as usize],
        };
        maxwellian(
            &scene,
            &mut state,
            2.5,
            &mut Streams::new(1, 0).stream_at(Purpose::Velocities, [0, 0]),
        );
        assert!(state.momentum(&scene).square().sqrt() < 1e-12);
        assert!((state.temperature(&scene) / 2.5 - 1.0).abs() < 1e-14);
        thermal_spins(
            &scene,
            &mut state,
            2.5,
            &mut Streams::new(1, 0).stream_at(Purpose::Spins, [0, 0]),
        );
        assert_eq!(state.spin_energy(&scene), 0.0);
        let rough = Scene {
            space: Plane,
            surface: Rough::new(0.5, 0.5).expect("a surface"),
            restitution: Constant::new(1.0).expect("a coefficient"),
            sizes: scene.sizes.clone(),
            field: Free,
        };
        let at_rest = ParticleState::new(vector![0.0, 0.0], vector![0.0, 0.0]);
        let mut spinning = State {
            time: 0.0,
            domain: state.domain,
            bodies: vec![at_rest; count as usize],
        };
        thermal_spins(
            &rough,
            &mut spinning,
            2.5,
            &mut Streams::new(1, 0).stream_at(Purpose::Spins, [0, 0]),
        );
        assert!((spinning.spin_temperature(&rough) / 2.5 - 1.0).abs() < 1e-14);
        state.bodies.truncate(1);
        rescale(&scene, &mut state, 2.5);
        assert_eq!(state.bodies[0].velocity, vector![0.0, 0.0]);
    }
}
