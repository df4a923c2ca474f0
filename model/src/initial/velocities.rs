//! Random initial velocities with zero momentum, a given temperature and a given fourth cumulant,
//! and Maxwellian spins.

use rand::Rng;
use rand_distr::{Distribution, Gamma, StandardNormal};

use crate::invalid::InvalidValue;
use crate::physics::{ParticleModel, SpinOf, VectorOf};
use crate::sizes::Sizes;
use crate::space::{Space, Vector};
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

/// Draws velocities as [`draw_velocities`] and passes each to `look` with its index, without a list
/// of them. `stream` returns the random stream at its beginning; velocities are drawn seven times.
pub fn visit_drawn_velocities<P: ParticleModel, R: Rng>(
    scene: &P,
    count: usize,
    temperature: f64,
    law: VelocityDistribution,
    stream: impl Fn() -> R,
    look: &mut dyn FnMut(usize, VectorOf<P>),
) {
    let sizes = scene.sizes();
    let mass = |index| sizes.mass(sizes.tag_of(index));
    let draw_all = |look: &mut dyn FnMut(usize, VectorOf<P>)| {
        let mut stream = stream();
        for index in 0..count {
            let spread = (temperature / mass(index)).sqrt();
            look(index, law.draw::<P::Space>(spread, &mut stream));
        }
    };
    let rescaling = VelocityRescaling::new::<P::Space>(temperature, |look| {
        draw_all(&mut |index, velocity| look(mass(index), velocity));
    });
    draw_all(&mut |index, velocity| look(index, rescaling.apply(velocity)));
}

/// Removes the drift of the centre of mass and scales the velocities to the temperature
/// `temperature` \[energy\].
pub fn rescale<P: ParticleModel>(scene: &P, state: &mut State<P>, temperature: f64) {
    let (sizes, bodies) = (scene.sizes(), &state.bodies);
    let rescaling = VelocityRescaling::new::<P::Space>(temperature, |look| {
        for (index, body) in bodies.iter().enumerate() {
            look(sizes.mass(sizes.tag_of(index)), body.velocity);
        }
    });
    for body in &mut state.bodies {
        body.velocity = rescaling.apply(body.velocity);
    }
}

/// Map of velocities that removes the drift of the centre of mass and sets the temperature.
struct VelocityRescaling<V> {
    /// Drift \[length/time\] and factor of each pass; a factor of `None` leaves particles at rest.
    passes: Vec<(V, Option<f64>)>,
}

impl<V: Vector> VelocityRescaling<V> {
    /// Computes the map to a temperature \[energy\]. `visit` passes masses and velocities of all
    /// particles to its argument, in the same order each time.
    fn new<S: Space<Vector = V>>(temperature: f64, visit: impl Fn(&mut dyn FnMut(f64, V))) -> Self {
        let mut map = Self { passes: Vec::new() };
        // The second pass removes the rounding error of the first, the third that of scaling.
        for _ in 0..3 {
            let (mut count, mut total, mut momentum) = (0_usize, 0.0, V::default());
            visit(&mut |mass, velocity| {
                count += 1;
                total += mass;
                momentum += map.apply(velocity) * mass;
            });
            let drift = momentum * (1.0 / f64::max(total, f64::MIN_POSITIVE));
            let mut twice_energy = 0.0;
            visit(&mut |mass, velocity| {
                twice_energy += mass * (map.apply(velocity) - drift).square();
            });
            let found = twice_energy / (S::DIMENSION * count.max(1)) as f64;
            let factor = (found > 0.0 && count > 1).then(|| (temperature / found).sqrt());
            map.passes.push((drift, factor));
        }
        map
    }

    /// Returns the velocity without drift, scaled.
    fn apply(&self, velocity: V) -> V {
        let pass = |velocity: V, (drift, factor): &(V, Option<f64>)| {
            factor.map_or_else(V::default, |factor| (velocity - *drift) * factor)
        };
        self.passes.iter().fold(velocity, pass)
    }
}

/// Draws spins as [`thermal_spins`] and passes each to `look` with its index, without a list of
/// them. `stream` returns the random stream at its beginning; spins are drawn twice.
pub fn visit_thermal_spins<P: ParticleModel, R: Rng>(
    scene: &P,
    count: usize,
    temperature: f64,
    stream: impl Fn() -> R,
    look: &mut dyn FnMut(usize, SpinOf<P>),
) {
    let (sizes, surface) = (scene.sizes(), scene.surface());
    let size = |index| {
        let tag = sizes.tag_of(index);
        (sizes.mass(tag), sizes.radius(tag))
    };
    let draw_all = |look: &mut dyn FnMut(usize, SpinOf<P>)| {
        let mut stream = stream();
        for index in 0..count {
            let (mass, radius) = size(index);
            look(
                index,
                surface.thermal_spin(temperature, mass, radius, &mut stream),
            );
        }
    };
    let mut energy = 0.0;
    draw_all(&mut |index, spin| {
        let (mass, radius) = size(index);
        energy += surface.spin_energy(mass, radius, spin);
    });
    let found = 2.0 * energy / (P::Space::ROTATIONS * count.max(1)) as f64;
    let factor = (temperature / found).sqrt();
    draw_all(&mut |index, spin| {
        let scaled = || <P::Surface as Surface<P::Space>>::scale_spin(spin, factor);
        look(index, if found > 0.0 { scaled() } else { spin });
    });
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
    use crate::samples::{self, DiskMixture};
    use crate::{Constant, Domain, Free, Plane, Polydisperse, Rough, Scene};
    use nalgebra::{Vector2, vector};

    /// Creates particles that all rest at the origin of a box.
    fn at_rest<P: ParticleModel<Space = Plane>>(count: usize) -> State<P> {
        let domain = Domain::periodic(vector![100.0, 100.0]).expect("positive");
        samples::state(domain, vec![(Vector2::zeros(), Vector2::zeros()); count])
    }

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

    /// Visited velocities and spins have the bits of those in a state: three unequal masses, all
    /// distributions, and counts without and with a temperature.
    #[test]
    fn visited_velocities_and_spins_are_those_of_a_state() {
        let streams = Streams::new(3, 0);
        let stream = |purpose| streams.stream_at(purpose, [0, 0]);
        for (count, a2) in [
            (0, 0.0),
            (1, 0.0),
            (2, 0.1),
            (1000, 0.0),
            (1000, 0.3),
            (999, -0.5),
        ] {
            let size = |i: usize| (0.5 + (i % 3) as f64, 1.0 + (i % 7) as f64);
            let sizes = Polydisperse::new((0..count.max(1)).map(size).collect()).expect("positive");
            let surface = Rough::new(0.5, 0.5).expect("a surface");
            let scene = Scene::new(surface, Constant::ELASTIC, sizes, Free);
            let mut state = at_rest(count);
            let law = VelocityDistribution::new(2, a2).expect("a distribution");
            draw_velocities(
                &scene,
                &mut state,
                2.5,
                law,
                &mut stream(Purpose::Velocities),
            );
            thermal_spins(&scene, &mut state, 1.5, &mut stream(Purpose::Spins));
            let mut found = at_rest(count).bodies;
            let begin = || stream(Purpose::Velocities);
            visit_drawn_velocities(&scene, count, 2.5, law, begin, &mut |index, velocity| {
                found[index].velocity = velocity;
            });
            let begin = || stream(Purpose::Spins);
            visit_thermal_spins(&scene, count, 1.5, begin, &mut |index, spin| {
                found[index].spin = spin;
            });
            assert_eq!(found, state.bodies, "{count}, {a2}");
        }
    }

    /// Momentum to N roundings of a thermal momentum, temperature to a few roundings: 1e-12 and
    /// 1e-14.
    #[test]
    fn momentum_vanishes_and_temperature_is_exact() {
        let count = 1000;
        let scene = samples::mixture(1.0, (0..count).map(|i| (0.5, 1.0 + (i % 7) as f64)));
        let (State { domain, .. }, origin) = (at_rest::<DiskMixture>(0), Vector2::zeros());
        let mut state = samples::maxwellian(&scene, domain, vec![origin; count], 2.5, 1);
        assert!(state.momentum(&scene).square().sqrt() < 1e-12);
        assert!((state.temperature(&scene) / 2.5 - 1.0).abs() < 1e-14);
        thermal_spins(
            &scene,
            &mut state,
            2.5,
            &mut Streams::new(1, 0).stream_at(Purpose::Spins, [0, 0]),
        );
        assert_eq!(state.spin_energy(&scene), 0.0);
        let surface = Rough::new(0.5, 0.5).expect("a surface");
        let rough = Scene::new(surface, Constant::ELASTIC, scene.sizes.clone(), Free);
        let mut spinning = at_rest(count);
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
