//! Maxwellian velocities with zero momentum and a given temperature, and Maxwellian spins.

use rand::Rng;
use rand_distr::{Distribution, StandardNormal};

use crate::physics::{Physics, VectorOf};
use crate::sizes::Sizes;
use crate::space::Space;
use crate::state::State;
use crate::surface::Surface;

/// Draws velocities from the Maxwellian, then removes the drift and scales to the temperature
/// `temperature` \[energy\] exactly (to rounding). One particle alone stays at rest: zero momentum allows
/// nothing else.
pub fn maxwellian<P: Physics>(
    scene: &P,
    state: &mut State<P>,
    temperature: f64,
    stream: &mut impl Rng,
) {
    let sizes = scene.sizes();
    for (index, body) in state.bodies.iter_mut().enumerate() {
        let spread = (temperature / sizes.mass(sizes.tag(index))).sqrt();
        for axis in 0..P::Space::DIMENSION {
            let normal: f64 = StandardNormal.sample(stream);
            body.velocity[axis] = spread * normal;
        }
    }
    rescale(scene, state, temperature);
}

/// Removes the drift of the centre of mass and scales the velocities to the temperature.
pub fn rescale<P: Physics>(scene: &P, state: &mut State<P>, temperature: f64) {
    let sizes = scene.sizes();
    let mass: f64 = (0..state.bodies.len())
        .map(|index| sizes.mass(sizes.tag(index)))
        .sum();
    // The second pass removes what the rounding of the first left behind, the third what scaling did.
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

/// Draws spins from the Maxwellian, then scales them to a temperature I <w^2>/rotations \[energy\] exactly; smooth particles have none.
pub fn thermal_spins<P: Physics>(
    scene: &P,
    state: &mut State<P>,
    temperature: f64,
    stream: &mut impl Rng,
) {
    let sizes = scene.sizes();
    for (index, body) in state.bodies.iter_mut().enumerate() {
        let tag = sizes.tag(index);
        let (mass, radius) = (sizes.mass(tag), sizes.radius(tag));
        body.spin = scene
            .surface()
            .thermal_spin(temperature, mass, radius, stream);
    }
    let found = state.spin_temperature(scene);
    if found > 0.0 {
        let factor = (temperature / found).sqrt();
        for body in &mut state.bodies {
            body.spin = <P::Surface as Surface<P::Space>>::scaled(body.spin, factor);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::{Purpose, Streams};
    use crate::space::Vector;
    use crate::{Body, Constant, Domain, Free, Plane, Polydisperse, Rough, Scene, Smooth};
    use nalgebra::vector;

    /// Momentum to N roundings of a thermal momentum, temperature to a few roundings: 1e-12 and 1e-14.
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
            bodies: vec![Body::new(vector![0.0, 0.0], vector![0.0, 0.0]); count as usize],
        };
        maxwellian(
            &scene,
            &mut state,
            2.5,
            &mut Streams::new(1, 0).at(Purpose::Velocities, [0, 0]),
        );
        assert!(state.momentum(&scene).square().sqrt() < 1e-12);
        assert!((state.temperature(&scene) / 2.5 - 1.0).abs() < 1e-14);
        thermal_spins(
            &scene,
            &mut state,
            2.5,
            &mut Streams::new(1, 0).at(Purpose::Spins, [0, 0]),
        );
        assert_eq!(state.spin_energy(&scene), 0.0);
        let rough = Scene {
            space: Plane,
            surface: Rough::new(0.5, 0.5).expect("a surface"),
            restitution: Constant::new(1.0).expect("a coefficient"),
            sizes: scene.sizes.clone(),
            field: Free,
        };
        let at_rest = Body::new(vector![0.0, 0.0], vector![0.0, 0.0]);
        let mut spinning = State {
            time: 0.0,
            domain: state.domain,
            bodies: vec![at_rest; count as usize],
        };
        thermal_spins(
            &rough,
            &mut spinning,
            2.5,
            &mut Streams::new(1, 0).at(Purpose::Spins, [0, 0]),
        );
        assert!((spinning.spin_temperature(&rough) / 2.5 - 1.0).abs() < 1e-14);
        state.bodies.truncate(1);
        rescale(&scene, &mut state, 2.5);
        assert_eq!(state.bodies[0].velocity, vector![0.0, 0.0]);
    }
}
