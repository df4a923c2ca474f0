//! Image flags: counts of crossings of the periodic boundary by each disk, from which unwrapped
//! displacements follow.

use nalgebra::Vector2;
use stosszahl_model::{Domain, ParticleModel, Plane, State};

use crate::error::EventDrivenError;

/// Image flags of a disk: the number of times it has left the box on the right and at the top, less
/// that on the left and at the bottom.
pub(crate) type ImageFlags = [i32; 2];

/// Returns the image flags of an unwrapped position: the number of box sides along each axis that
/// [`Domain::wrap`] subtracts from it.
pub(crate) fn wound(domain: &Domain<Plane>, position: Vector2<f64>) -> ImageFlags {
    let (inside, lengths) = (domain.wrap(position), domain.lengths());
    // A tiny negative position is wrapped to zero, which is no side of the box.
    [0, 1].map(|axis| ((position[axis] - inside[axis]) / lengths[axis]).round() as i32)
}

/// Returns the image flags of all disks at the start, in the engine's order of disks and for
/// positions wrapped into the box; empty if the start has none.
pub(crate) fn follow<P: ParticleModel<Space = Plane>>(
    state: &State<P>,
    image_flags: &[ImageFlags],
    order: &[u32],
) -> Result<Vec<ImageFlags>, EventDrivenError> {
    if image_flags.is_empty() {
        return Ok(Vec::new());
    }
    if image_flags.len() != order.len() {
        return Err(EventDrivenError::WrongCount {
            quantity: "windings",
            found: image_flags.len(),
            disks: order.len(),
        });
    }
    let winding = |&index: &u32| {
        let at = state.bodies[index as usize].position;
        add(image_flags[index as usize], wound(&state.domain, at))
    };
    Ok(order.iter().map(winding).collect())
}

pub(crate) fn add(one: ImageFlags, other: ImageFlags) -> ImageFlags {
    [0, 1].map(|axis| one[axis].wrapping_add(other[axis]))
}
