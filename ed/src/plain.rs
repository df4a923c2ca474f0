//! The oracle of the engine: slow and obvious.

use nalgebra::Vector2;
use stosszahl_model::{Encounter, Physics, Plane, Restitution, Sizes, Smooth, State, collide};

use crate::contact::time_to_contact;

/// One collision of the plain gas.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Event {
    /// When.
    pub time: f64,
    /// Who, the smaller index first.
    pub pair: [usize; 2],
}

/// Moves the gas through its next `collisions` collisions and lists them.
///
/// For each, the contact times of all pairs over many periodic images are computed anew, the earliest
/// is taken, and all disks are moved there. Cost N^2 a collision. Images up to 1 + 40/N boxes away are
/// seen: the fewer the disks, the further one flies before it meets another.
pub fn run<P: Physics<Space = Plane, Surface = Smooth>>(
    scene: &P,
    state: &mut State<P>,
    collisions: usize,
) -> Vec<Event> {
    let sizes = scene.sizes();
    let lengths = state.domain.lengths();
    let reach = 1 + (40 / state.bodies.len().max(1)) as i32;
    let mut events = Vec::new();
    for _ in 0..collisions {
        let mut next: Option<(f64, [usize; 2], Vector2<f64>)> = None;
        for (i, one) in state.bodies.iter().enumerate() {
            for (j, other) in state.bodies.iter().enumerate().skip(i + 1) {
                let distance = sizes.radius(sizes.tag(i)) + sizes.radius(sizes.tag(j));
                let nearest = state.domain.displacement(one.position, other.position);
                for column in -reach..=reach {
                    for row in -reach..=reach {
                        let image = Vector2::new(
                            f64::from(column) * lengths[0],
                            f64::from(row) * lengths[1],
                        );
                        let separation = nearest + image;
                        let limit = next.map_or(f64::INFINITY, |known| known.0);
                        let relative = one.velocity - other.velocity;
                        if let Some(time) =
                            time_to_contact(separation, relative, distance * distance, limit)
                        {
                            next = Some((time, [i, j], separation + relative * time));
                        }
                    }
                }
            }
        }
        let Some((wait, [i, j], line)) = next else {
            break;
        };
        state.time += wait;
        for body in &mut state.bodies {
            body.position = state.domain.wrap(body.position + body.velocity * wait);
        }
        let velocities = [state.bodies[i].velocity, state.bodies[j].velocity];
        let masses = [sizes.mass(sizes.tag(i)), sizes.mass(sizes.tag(j))];
        let approach = -(velocities[0] - velocities[1]).dot(&line) / line.norm();
        let restitution = scene.restitution().normal(approach.max(0.0));
        let after = collide(
            scene,
            &Encounter {
                velocities,
                spins: [(); 2],
                masses,
                radii: [sizes.radius(sizes.tag(i)), sizes.radius(sizes.tag(j))],
                line,
            },
            restitution,
        )
        .velocities;
        state.bodies[i].velocity = after[0];
        state.bodies[j].velocity = after[1];
        events.push(Event {
            time: state.time,
            pair: [i, j],
        });
    }
    events
}
