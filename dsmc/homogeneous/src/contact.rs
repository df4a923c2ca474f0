//! Contact of a pair in a gas without positions: random line of centres, and contact rules such as
//! bounce and tracer limit with their outcomes.

use rand::{Rng, RngExt};
use serde::Serialize;
use serde::de::DeserializeOwned;
use stosszahl_model::{
    CollidingPair, Restitution, Separation, Sizes, Space, Vector, VectorOf, collide,
};

use super::gas::{HomogeneousGas, SmoothPhysics};

/// Draws a random line of centres for a pair that collides with the relative velocity `g`: a vector
/// of any positive length; zero if the pair only grazes.
///
/// Its density is proportional to |g . e|. In two dimensions the impact parameter b/d is uniform in
/// \[-1, 1\]. In three dimensions the elastic rebound of hard spheres is isotropic, so a random
/// direction n gives the line `g - |g| n` without a frame around g.
#[inline]
pub fn line_of_centres<S: Space>(g: &S::Vector, stream: &mut impl Rng) -> S::Vector {
    let mut line = *g;
    if S::DIMENSION == 2 {
        let b = 2.0 * stream.random::<f64>() - 1.0;
        let along = (1.0 - b * b).sqrt();
        line[0] = along * g[0] - b * g[1];
        line[1] = along * g[1] + b * g[0];
    } else {
        // Marsaglia, Ann. Math. Stat. 43, 645 (1972), doi:10.1214/aoms/1177692644.
        let (x, y, square) = loop {
            let x = 2.0 * stream.random::<f64>() - 1.0;
            let y = 2.0 * stream.random::<f64>() - 1.0;
            let square = x * x + y * y;
            if square < 1.0 {
                break (x, y, square);
            }
        };
        let speed = g.square().sqrt();
        let twice = 2.0 * speed * (1.0 - square).sqrt();
        line[0] -= twice * x;
        line[1] -= twice * y;
        line[2] -= speed * (1.0 - 2.0 * square);
    }
    line
}

/// Colliding pair of a gas without positions: indices, relative velocity and line of centres.
#[derive(Clone, Copy, Debug)]
pub struct CollidingParticles<V> {
    /// Indices of the first and the second particle of the pair.
    pub pair: [u32; 2],
    /// Relative velocity of the pair, first minus second \[length/time\].
    pub relative: V,
    /// Line of centres of the pair, a vector of any positive length.
    pub line: V,
}

/// Outcome of a contact by a [`ContactRule`]: no change, a bounce, or other particles in place of
/// the pair.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ContactOutcome {
    /// The pair passed without any change.
    Passed,
    /// The pair bounced: its velocities changed by the collision law.
    Bounced {
        /// True for the first and the second particle if its velocity changed.
        changed: [bool; 2],
        /// Result of the normal collision law: coefficient of restitution and added speed.
        law: Separation,
    },
    /// The pair is removed; the particles that replace it are appended to the list of particles.
    Replaced {
        /// Length of the list of particles before the contact, where the new ones begin.
        from: usize,
    },
}

/// Rule for the contact of a pair in a gas without positions: bounce, aggregation or fragmentation.
pub trait ContactRule<P: SmoothPhysics>: Clone + Serialize + DeserializeOwned {
    /// True if the rule makes particles merge or break, so that particles appear and vanish.
    const SIZES_CHANGE: bool;

    /// Changes the velocities at the start of a run as the rule requires; by default not at all.
    fn prepare_gas(&self, _gas: &mut HomogeneousGas<P>) {}

    /// Returns true if a species belongs to those that conserve their total momentum under the
    /// rule.
    fn conserves_momentum(&self, _kind: u32) -> bool {
        true
    }

    /// Changes the two particles of a pair at contact by the rule, and returns the outcome.
    fn apply_contact(
        &mut self,
        gas: &mut HomogeneousGas<P>,
        meeting: &CollidingParticles<VectorOf<P>>,
        stream: &mut impl Rng,
    ) -> ContactOutcome;
}

/// Returns the velocities of a pair after a bounce by the collision law of the particle model, and
/// the result of its normal part.
#[inline]
pub(crate) fn bounce<P: SmoothPhysics>(
    gas: &HomogeneousGas<P>,
    meeting: &CollidingParticles<VectorOf<P>>,
) -> ([VectorOf<P>; 2], Separation) {
    let partners = meeting.pair.map(|index| &gas.particles[index as usize]);
    let sizes = gas.scene.sizes();
    let along = meeting.relative.inner(&meeting.line);
    let approach = (along * along / meeting.line.square()).sqrt();
    let kinds = partners.map(|particle| sizes.species_of(particle.tag));
    let law = gas.scene.restitution().separation(kinds, approach);
    let encounter = CollidingPair {
        velocities: partners.map(|particle| particle.velocity),
        spins: [(); 2],
        masses: partners.map(|particle| sizes.mass(particle.tag)),
        radii: partners.map(|particle| sizes.radius(particle.tag)),
        // From the second to the first partner, which approach each other.
        line: meeting.line * if along > 0.0 { -1.0 } else { 1.0 },
    };
    let after = collide(&gas.scene, &encounter, law);
    (after.velocities, law)
}

/// Contact rule by which every pair bounces by the collision law of the particle model.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, serde::Deserialize)]
pub struct Bounce;

impl<P: SmoothPhysics> ContactRule<P> for Bounce {
    const SIZES_CHANGE: bool = false;

    #[inline]
    fn apply_contact(
        &mut self,
        gas: &mut HomogeneousGas<P>,
        meeting: &CollidingParticles<VectorOf<P>>,
        _stream: &mut impl Rng,
    ) -> ContactOutcome {
        let (velocities, law) = bounce(gas, meeting);
        for (index, velocity) in meeting.pair.into_iter().zip(velocities) {
            gas.particles[index as usize].velocity = velocity;
        }
        ContactOutcome::Bounced {
            changed: [true; 2],
            law,
        }
    }
}

/// Contact law chosen when the run begins: `None` lets every pair bounce. The choice is made once
/// for each collision, so its cost is not measurable, and it halves the number of engines that are
/// compiled.
impl<P: SmoothPhysics> ContactRule<P> for Option<Tracers> {
    const SIZES_CHANGE: bool = false;

    fn prepare_gas(&self, gas: &mut HomogeneousGas<P>) {
        if let Some(tracers) = self {
            tracers.prepare_gas(gas);
        }
    }

    fn conserves_momentum(&self, kind: u32) -> bool {
        self.is_none_or(|tracers| kind != tracers.kind)
    }

    #[inline]
    fn apply_contact(
        &mut self,
        gas: &mut HomogeneousGas<P>,
        meeting: &CollidingParticles<VectorOf<P>>,
        stream: &mut impl Rng,
    ) -> ContactOutcome {
        match self {
            None => Bounce.apply_contact(gas, meeting, stream),
            Some(tracers) => tracers.apply_contact(gas, meeting, stream),
        }
    }
}

/// Contact rule of a mixture with a tracer species, which does not affect the others and does not
/// collide with itself.
///
/// The tracer limit of a mixture, for any number of tracers that statistics requires.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, serde::Deserialize)]
pub struct Tracers {
    /// Number of the tracer species among the species of the mixture.
    pub kind: u32,
}

impl<P: SmoothPhysics> ContactRule<P> for Tracers {
    const SIZES_CHANGE: bool = false;

    /// Removes the drift of all species but the tracers, which would never decay while the gas
    /// cools.
    fn prepare_gas(&self, gas: &mut HomogeneousGas<P>) {
        gas.remove_drift_of(|kind| kind != self.kind);
    }

    fn conserves_momentum(&self, kind: u32) -> bool {
        kind != self.kind
    }

    #[inline]
    fn apply_contact(
        &mut self,
        gas: &mut HomogeneousGas<P>,
        meeting: &CollidingParticles<VectorOf<P>>,
        _stream: &mut impl Rng,
    ) -> ContactOutcome {
        let is_tracer = meeting.pair.map(|index| {
            let tag = gas.particles[index as usize].tag;
            gas.scene.sizes().species_of(tag) == self.kind
        });
        if is_tracer == [true; 2] {
            return ContactOutcome::Passed;
        }
        let (velocities, law) = bounce(gas, meeting);
        let bath = is_tracer == [false; 2];
        let changed = is_tracer.map(|tracer| tracer || bath);
        for side in 0..2 {
            if changed[side] {
                gas.particles[meeting.pair[side] as usize].velocity = velocities[side];
            }
        }
        ContactOutcome::Bounced { changed, law }
    }
}
