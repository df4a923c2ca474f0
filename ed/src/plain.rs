//! Reference event-driven dynamics, slow and obvious, against which the engine is tested: all pairs
//! are tested and all disks moved at every event. In a shear flow, velocities are peculiar, so that
//! periodic images have the velocity of the original.

use nalgebra::Vector2;
use stosszahl_model::random::Purpose;
use stosszahl_model::walls::flight::{time_to_plane, time_to_vibrating_plane};
use stosszahl_model::walls::{Hit, Touch, Walls};
use stosszahl_model::{
    CollidingPair, Field, ParticleModel, Plane, Restitution, Sizes, State, collide,
};

use crate::contact::time_to_contact;
use crate::error::Touchable;
use crate::surroundings::{DiskBoundaries, FACES, above, images};

/// Collision of two disks in the reference dynamics: its time and the pair.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Event {
    /// Time of the collision \[time\].
    pub time: f64,
    /// Indices in the state of the colliding disks, the smaller first.
    pub pair: [usize; 2],
}

/// Partners of a contact: two disks, or a disk and a wall or obstacle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ContactPartners {
    /// Contact of two disks, by their indices in the state, the smaller first.
    Disks([usize; 2]),
    /// Contact of a disk, by its index in the state, with a wall or an obstacle.
    Boundary(usize, Touchable),
}

/// Contact in the reference dynamics, of two disks or of a disk with a wall or obstacle: its time
/// and partners.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlainContact {
    /// Time of the contact \[time\].
    pub time: f64,
    /// Disks in contact, or the disk and the wall or obstacle that it touches.
    pub met: ContactPartners,
}

/// Advances a gas in a periodic box by its next `collisions` collisions with the reference
/// dynamics, and returns these.
///
/// For each collision, the contact times of all pairs over many periodic images are computed, the
/// earliest is taken, and all disks are moved there. Cost N^2 a collision. Images up to 1 + 40/N
/// boxes away are seen: the fewer the disks, the longer the free flights.
pub fn run_collisions<P: ParticleModel<Space = Plane>>(
    scene: &P,
    state: &mut State<P>,
    collisions: usize,
) -> Vec<Event> {
    let contacts = run_between(scene, state, &DiskBoundaries::periodic(), collisions);
    let event = |contact: PlainContact| match contact.met {
        ContactPartners::Disks(pair) => Some(Event {
            time: contact.time,
            pair,
        }),
        ContactPartners::Boundary(..) => None,
    };
    contacts.into_iter().filter_map(event).collect()
}

/// Advances a gas with walls and obstacles by its next `contacts` contacts with the reference
/// dynamics, and returns these. Contacts with walls and obstacles are sought over periodic images
/// of the disks.
pub fn run_between<P: ParticleModel<Space = Plane>>(
    scene: &P,
    state: &mut State<P>,
    boundaries: &DiskBoundaries,
    contacts: usize,
) -> Vec<PlainContact> {
    let mut rebounds = vec![0; state.bodies.len()];
    let mut all = Vec::new();
    for _ in 0..contacts {
        let mut next = next_pair(scene, state);
        let limit = next.map_or(f64::INFINITY, |next| next.wait);
        next = next_boundary(scene, state, boundaries, limit).or(next);
        let Some(next) = next else {
            break;
        };
        state.time += next.wait;
        for body in &mut state.bodies {
            (scene.field()).move_particle(&mut body.position, &mut body.velocity, next.wait);
        }
        state.domain.advance(next.wait);
        for body in &mut state.bodies {
            body.position = state.domain.wrap(body.position);
        }
        match next.met {
            ContactPartners::Disks(pair) => collide_disks(scene, state, pair, next.line),
            ContactPartners::Boundary(disk, what) => {
                let number = rebounds[disk];
                rebound_disk(scene, state, boundaries, [disk, number], what, next.line);
                rebounds[disk] += 1;
            }
        }
        all.push(PlainContact {
            time: state.time,
            met: next.met,
        });
    }
    all
}

/// Next contact of the reference dynamics: its time, its partners, and the line of centres or the
/// normal of the wall or obstacle.
#[derive(Clone, Copy)]
struct Next {
    wait: f64,
    met: ContactPartners,
    line: Vector2<f64>,
}

/// Returns the next contact of any two disks, over all pairs and many periodic images. A uniform
/// field does not affect their relative motion.
fn next_pair<P: ParticleModel<Space = Plane>>(scene: &P, state: &State<P>) -> Option<Next> {
    let sizes = scene.sizes();
    let reach = [0, 1].map(|axis| {
        let boxes = 1 + (40 / state.bodies.len().max(1)) as i32;
        if state.domain.is_periodic(axis) {
            boxes
        } else {
            0
        }
    });
    let mut next: Option<Next> = None;
    for (i, one) in state.bodies.iter().enumerate() {
        for (j, other) in state.bodies.iter().enumerate().skip(i + 1) {
            let distance = sizes.radius(sizes.tag_of(i)) + sizes.radius(sizes.tag_of(j));
            let nearest = state.domain.displacement(one.position, other.position);
            for column in -reach[0]..=reach[0] {
                for row in -reach[1]..=reach[1] {
                    let boxes = [f64::from(column), f64::from(row), 0.0];
                    let separation = nearest + state.domain.images().image(boxes).position;
                    let limit = next.map_or(f64::INFINITY, |known| known.wait);
                    let mut relative = one.velocity - other.velocity;
                    relative[0] += state.domain.images().flow(separation[1]);
                    if let Some(wait) =
                        time_to_contact(separation, relative, distance * distance, limit)
                    {
                        next = Some(Next {
                            wait,
                            met: ContactPartners::Disks([i, j]),
                            line: separation + relative * wait,
                        });
                    }
                }
            }
        }
    }
    next
}

/// Returns the next contact of any disk with a wall or an obstacle, if before `limit` \[time\].
fn next_boundary<P: ParticleModel<Space = Plane>>(
    scene: &P,
    state: &State<P>,
    boundaries: &DiskBoundaries,
    mut limit: f64,
) -> Option<Next> {
    let sizes = scene.sizes();
    let pull = scene.field().acceleration();
    let mut next = None;
    for (disk, body) in state.bodies.iter().enumerate() {
        let radius = sizes.radius(sizes.tag_of(disk));
        for face in 0..FACES {
            let (axis, side) = (face / 2, face % 2);
            let Some(wall) = boundaries.walls.wall(axis, side) else {
                continue;
            };
            let normal = Walls::<Plane>::normal(axis, side);
            let height = above(&state.domain, axis, side, body.position) - radius;
            let (speed, pull) = (body.velocity.dot(&normal), pull.dot(&normal));
            let wait = match &wall.vibration {
                None => time_to_plane(height, speed, pull),
                Some(vibration) => {
                    time_to_vibrating_plane(height, speed, pull, vibration, state.time, limit)
                }
            };
            if let Some(wait) = wait.filter(|&wait| wait < limit) {
                limit = wait;
                next = Some(Next {
                    wait,
                    met: ContactPartners::Boundary(disk, Touchable::Wall { axis, side }),
                    line: normal,
                });
            }
        }
        for (number, obstacle) in boundaries.obstacles.iter().enumerate() {
            for image in images(&state.domain, body.position) {
                let hit = obstacle.first_contact(image, body.velocity, pull, radius, limit);
                if let Some(Hit { time, normal }) = hit {
                    limit = time;
                    next = Some(Next {
                        wait: time,
                        met: ContactPartners::Boundary(disk, Touchable::Obstacle(number)),
                        line: normal,
                    });
                }
            }
        }
    }
    next
}

/// Executes the collision of disks i and j in the reference dynamics: sets their velocities and
/// spins. `line` is the line of centres.
fn collide_disks<P: ParticleModel<Space = Plane>>(
    scene: &P,
    state: &mut State<P>,
    [i, j]: [usize; 2],
    line: Vector2<f64>,
) {
    let sizes = scene.sizes();
    let mut velocities = [state.bodies[i].velocity, state.bodies[j].velocity];
    // In the frame in which the second is, in a shear flow.
    let flow = state.domain.images().flow(line[1]);
    velocities[0][0] += flow;
    let masses = [sizes.mass(sizes.tag_of(i)), sizes.mass(sizes.tag_of(j))];
    let approach = -(velocities[0] - velocities[1]).dot(&line) / line.norm();
    let kinds = [i, j].map(|disk| sizes.species_of(sizes.tag_of(disk)));
    let law = (scene.restitution()).separation(kinds, approach.max(0.0));
    let after = collide(
        scene,
        &CollidingPair {
            velocities,
            spins: [state.bodies[i].spin, state.bodies[j].spin],
            masses,
            radii: [sizes.radius(sizes.tag_of(i)), sizes.radius(sizes.tag_of(j))],
            line,
        },
        law,
    );
    for (place, disk) in [i, j].into_iter().enumerate() {
        state.bodies[disk].velocity = after.velocities[place];
        state.bodies[disk].spin = after.spins[place];
    }
    state.bodies[i].velocity[0] -= flow;
}

/// Executes the contact of a disk with a wall or an obstacle in the reference dynamics. `number`
/// counts the disk's earlier contacts, which address its random numbers.
fn rebound_disk<P: ParticleModel<Space = Plane>>(
    scene: &P,
    state: &mut State<P>,
    boundaries: &DiskBoundaries,
    [disk, number]: [usize; 2],
    what: Touchable,
    normal: Vector2<f64>,
) {
    let sizes = scene.sizes();
    let (law, velocity) = match what {
        Touchable::Wall { axis, side } => match boundaries.walls.wall(axis, side) {
            Some(wall) => (wall.rebound, wall.velocity(normal, state.time)),
            None => return,
        },
        Touchable::Obstacle(number) => (*boundaries.obstacles[number].rebound(), Vector2::zeros()),
    };
    let touch = Touch {
        normal,
        wall: velocity,
        mass: sizes.mass(sizes.tag_of(disk)),
        radius: sizes.radius(sizes.tag_of(disk)),
    };
    let body = &mut state.bodies[disk];
    let address = [number as u64, disk as u64];
    law.apply(scene, &touch, &mut body.velocity, &mut body.spin, || {
        boundaries.streams.stream_at(Purpose::Walls, address)
    });
}
