//! Starts of hard cases.

use nalgebra::{Vector2, vector};
use rand::RngExt;
use stosszahl_model::initial::{self, Arrangement};
use stosszahl_model::random::{Purpose, Stream, Streams};
use stosszahl_model::{
    Body, Constant, Domain, Free, Plane, Polydisperse, Scene, Sizes, Smooth, State,
};

use super::Trouble;
use super::gas::Gas;
use crate::bench::{self, Disks};
use crate::dispatch::Planar;

/// Disks of unlike sizes.
pub(super) type Mixture = Scene<Plane, Smooth, Constant, Polydisperse, Free>;

/// Unit disks with a restitution.
pub(super) fn unit_disks(restitution: f64) -> Result<Disks, Trouble> {
    let law = Constant::new(restitution).ok_or(Trouble::NoStart("restitution outside 0 to 1"))?;
    Ok(bench::unit_disks(law))
}

/// Disks of unlike sizes, (radius, mass) each.
pub(super) fn mixture(sizes: Vec<(f64, f64)>, restitution: f64) -> Result<Mixture, Trouble> {
    let unit = unit_disks(restitution)?;
    Ok(Scene {
        space: unit.space,
        surface: unit.surface,
        restitution: unit.restitution,
        sizes: Polydisperse::new(sizes).ok_or(Trouble::NoStart("sizes that are not positive"))?,
        field: unit.field,
    })
}

/// A periodic box.
pub(super) fn domain(width: f64, height: f64) -> Result<Domain<Plane>, Trouble> {
    Domain::periodic(vector![width, height]).ok_or(Trouble::NoStart("a box without a size"))
}

/// A state from positions and velocities as written.
pub(super) fn state<P: Planar>(
    domain: Domain<Plane>,
    bodies: impl IntoIterator<Item = ([f64; 2], [f64; 2])>,
) -> State<P> {
    let bodies = bodies
        .into_iter()
        .map(|(position, velocity)| Body::new(position.into(), velocity.into()))
        .collect();
    State {
        time: 0.0,
        domain,
        bodies,
    }
}

/// A disordered Maxwellian gas of unit disks in a square box.
pub(super) fn disordered(
    disks: usize,
    packing_fraction: f64,
    restitution: f64,
    seed: u64,
) -> Result<Gas<Disks>, Trouble> {
    let start = bench::gas(Arrangement::Disordered, disks, packing_fraction, 1.0, seed)?;
    Ok(Gas::new(unit_disks(restitution)?, start))
}

/// Velocities of a Maxwellian at temperature one.
pub(super) fn warm<P: Planar>(scene: &P, start: &mut State<P>, seed: u64) {
    let mut stream = Streams::new(seed, 0).at(Purpose::Velocities, [0, 0]);
    initial::maxwellian(scene, start, 1.0, &mut stream);
}

/// Positions without overlap by trial, one disk after another in the order of their sizes; `None` if one finds no place
/// in so many trials. Cost N^2.
pub(super) fn place_by_trial<Z: Sizes>(
    sizes: &Z,
    count: usize,
    domain: &Domain<Plane>,
    trials: usize,
    stream: &mut Stream,
) -> Option<Vec<Vector2<f64>>> {
    let radius = |index: usize| sizes.radius(sizes.tag(index));
    let lengths = domain.lengths();
    let mut order: Vec<usize> = (0..count).collect();
    order.sort_by(|&a, &b| radius(b).total_cmp(&radius(a)));
    let mut placed: Vec<usize> = Vec::with_capacity(count);
    let mut positions = vec![Vector2::zeros(); count];
    for who in order {
        let free = (0..trials).find_map(|_| {
            let at = vector![
                lengths[0] * stream.random::<f64>(),
                lengths[1] * stream.random::<f64>()
            ];
            placed
                .iter()
                .all(|&other| domain.distance(at, positions[other]) > radius(who) + radius(other))
                .then_some(at)
        })?;
        positions[who] = free;
        placed.push(who);
    }
    Some(positions)
}

/// The state of bodies at rest at these positions.
pub(super) fn at_rest<P: Planar>(domain: Domain<Plane>, positions: &[Vector2<f64>]) -> State<P> {
    let bodies = positions.iter().map(|&at| (at.into(), [0.0; 2]));
    state(domain, bodies)
}
