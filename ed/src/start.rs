//! Checks of the initial state or checkpoint of an engine: finite numbers, box, boundaries and
//! overlaps.

use stosszahl_model::walls::{Face, Walls};
use stosszahl_model::{Domain, Field, ParticleModel, Plane, Sizes, State, Surface};

use crate::checkpoint::EventDrivenCheckpoint;
use crate::error::{EventDrivenError, POSITION, Touchable};
use crate::surroundings::{DiskBoundaries, FACES, above, images, overlap_of};

/// Largest overlap of two disks at the start, in diameters, that counts as rounding.
pub(crate) const ROUNDING: f64 = 1e-9;

/// Checks that a checkpoint is valid for an engine: finite numbers, list lengths, shear rate, and a
/// box wider than `diameter` \[length\].
pub(crate) fn check_checkpoint<P: ParticleModel<Space = Plane>>(
    scene: &P,
    start: &EventDrivenCheckpoint<P>,
    diameter: f64,
) -> Result<(), EventDrivenError> {
    let (state, last_contact) = (&start.state, &start.last_contact);
    let count = state.bodies.len();
    if !state.time.is_finite() {
        return Err(EventDrivenError::BadStart { time: state.time });
    }
    if count >= u32::MAX as usize {
        return Err(EventDrivenError::TooMany { disks: count });
    }
    let found = state.domain.images().shear().map(|shear| shear.rate);
    let rate = P::Field::SHEARED.then(|| scene.field().shear_rate());
    if found != rate {
        return Err(EventDrivenError::UnlikeFlow { found, rate });
    }
    if P::Field::SHEARED && !start.image_flags.is_empty() {
        return Err(EventDrivenError::FlagsInFlow);
    }
    let lengths = state.domain.lengths();
    let narrow =
        |axis: usize| state.domain.is_periodic(axis) && lengths[axis] <= diameter * (1.0 + 1e-9);
    if narrow(0) || narrow(1) {
        return Err(EventDrivenError::BoxTooSmall {
            diameter,
            lengths: lengths.into(),
        });
    }
    for (index, body) in state.bodies.iter().enumerate() {
        let sizes = scene.sizes();
        let (mass, radius) = (
            sizes.mass(sizes.tag_of(index)),
            sizes.radius(sizes.tag_of(index)),
        );
        if !(scene.surface())
            .spin_energy(mass, radius, body.spin)
            .is_finite()
        {
            return Err(EventDrivenError::BadSpin { disk: index });
        }
        for (quantity, value) in [(POSITION, body.position), ("velocity", body.velocity)] {
            // Also false for NaN.
            if !value.iter().all(|x| x.abs() <= 1e150) {
                return Err(EventDrivenError::BadNumber {
                    disk: index,
                    quantity,
                    value: value.into(),
                });
            }
        }
    }
    if !last_contact.is_empty() && last_contact.len() != count {
        return Err(EventDrivenError::WrongCount {
            quantity: "times of last contact",
            found: last_contact.len(),
            disks: count,
        });
    }
    Ok(())
}

/// Checks that walls and obstacles fit the box of the gas and leave room for the largest disk.
pub(crate) fn check_boundaries(
    domain: &Domain<Plane>,
    boundaries: &DiskBoundaries,
    diameter: f64,
    ledgers: usize,
) -> Result<(), EventDrivenError> {
    let expected = boundaries.ledgers();
    if ledgers != 0 && ledgers != expected {
        return Err(EventDrivenError::WrongLedgers {
            found: ledgers,
            expected,
        });
    }
    let walls = &boundaries.walls;
    for axis in 0..2 {
        for side in 0..2 {
            if *walls.face(axis, side) == Face::Open {
                return Err(EventDrivenError::OpenFace { axis, side });
            }
        }
        let state = domain.is_periodic(axis);
        if state != (*walls.face(axis, 0) == Face::Periodic) {
            return Err(EventDrivenError::UnlikeBox { axis, state });
        }
        if state {
            continue;
        }
        let room = domain.lengths()[axis]
            - largest_displacement(walls, axis, 0)
            - largest_displacement(walls, axis, 1);
        if room < diameter {
            return Err(EventDrivenError::NoRoom {
                axis,
                room,
                diameter,
            });
        }
    }
    for (number, obstacle) in boundaries.obstacles.iter().enumerate() {
        let inside = obstacle.check_inside(domain.lengths());
        inside.map_err(|source| EventDrivenError::BadObstacle {
            obstacle: number,
            source,
        })?;
    }
    Ok(())
}

/// Returns how far a vibrating wall moves into the box, its amplitude \[length\]; 0 for a wall at
/// rest.
fn largest_displacement(walls: &Walls<Plane>, axis: usize, side: usize) -> f64 {
    let vibration = walls.wall(axis, side).and_then(|wall| wall.vibration);
    vibration.map_or(0.0, |vibration| vibration.amplitude())
}

/// Checks that no disk of the initial state overlaps a wall or an obstacle.
pub(crate) fn check_overlaps<P: ParticleModel<Space = Plane>>(
    scene: &P,
    state: &State<P>,
    boundaries: &DiskBoundaries,
) -> Result<(), EventDrivenError> {
    let sizes = scene.sizes();
    for (disk, body) in state.bodies.iter().enumerate() {
        let radius = sizes.radius(sizes.tag_of(disk));
        let place = state.domain.wrap(body.position);
        let refuse = |ledger: usize, depth: f64| {
            if depth <= 2.0 * radius * ROUNDING {
                return Ok(());
            }
            Err(EventDrivenError::Overlap {
                disk,
                place: place.into(),
                what: Touchable::of_ledger(ledger),
                depth,
            })
        };
        for face in 0..FACES {
            if let Some(wall) = boundaries.walls.wall(face / 2, face % 2) {
                let above = above(&state.domain, face / 2, face % 2, place);
                refuse(face, radius - above + wall.displacement(state.time))?;
            }
        }
        for (number, obstacle) in boundaries.obstacles.iter().enumerate() {
            let depths = images(&state.domain, place);
            let depths = depths.map(|image| overlap_of(obstacle, image, radius));
            refuse(FACES + number, depths.fold(f64::NEG_INFINITY, f64::max))?;
        }
    }
    Ok(())
}
