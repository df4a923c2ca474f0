//! Walls at the faces of the box and obstacles in it: a table of those near each cell, and contact
//! times of disks with them.
//!
//! Which of these a disk can touch from within a cell is a table that is made at the start.
//! Contacts are sought in that table each time a disk's next event is predicted, and only up to the
//! time at which it leaves the cell.

use nalgebra::Vector2;
use stosszahl_model::random::Streams;
use stosszahl_model::walls::flight::{time_to_plane, time_to_vibrating_plane};
use stosszahl_model::walls::{Feature, FlyingParticle, Obstacle, Vibration};
use stosszahl_model::{Domain, Plane, Rebound, Walls};

use crate::cells::{CellCoordinates, CellLists};

/// Number of faces of a box. Faces precede the obstacles in lists: lower and upper along the first
/// axis, then along the second.
pub(crate) const FACES: usize = 4;

/// Walls at the faces of a box and obstacles in it, for a gas of disks.
#[derive(Clone, Debug)]
pub struct DiskBoundaries {
    /// Walls at the faces of the box; faces without a wall are periodic.
    pub walls: Walls<Plane>,
    /// Obstacles inside the box, in addition to walls at its faces.
    pub obstacles: Vec<Obstacle>,
    /// Random streams of rebounds from diffuse walls.
    pub streams: Streams,
}

impl DiskBoundaries {
    /// Returns the boundaries of a periodic box without walls and obstacles.
    pub fn periodic() -> Self {
        Self {
            walls: Walls::none(),
            obstacles: Vec::new(),
            streams: Streams::new(0, 0),
        }
    }

    /// Returns the number of ledgers of momentum and energy: one for each face and each obstacle,
    /// or 0 without walls and obstacles.
    pub(crate) fn ledgers(&self) -> usize {
        if self.is_empty() {
            0
        } else {
            FACES + self.obstacles.len()
        }
    }

    /// Returns true if there are no walls and no obstacles.
    pub(crate) fn is_empty(&self) -> bool {
        self.walls.is_periodic() && self.obstacles.is_empty()
    }
}

/// Units of the engine: its unit of speed, and the absolute time at which engine time is zero.
#[derive(Clone, Copy, Debug)]
pub(crate) struct EngineUnits {
    pub(crate) speed: f64,
    pub(crate) epoch: f64,
}

/// Disk on its flight that may touch a wall or obstacle, in engine units.
pub(crate) struct Approach {
    pub(crate) home: CellCoordinates,
    /// Position of the disk at the engine time `clock`, relative to the corner of its cell
    /// \[length\].
    pub(crate) position: Vector2<f64>,
    pub(crate) velocity: Vector2<f64>,
    pub(crate) acceleration: Vector2<f64>,
    pub(crate) radius: f64,
    /// Engine time at which the disk has the given position and velocity.
    pub(crate) clock: f64,
    /// Time until the next predicted event of the disk \[engine time\]; contacts after it do not
    /// count.
    pub(crate) limit: f64,
}

/// Wall or obstacle that a disk touches: its law, normal and velocity at the contact.
pub(crate) struct Touched {
    pub(crate) rebound: Rebound,
    /// Unit normal vector of the wall or obstacle at the contact, pointing into the gas.
    pub(crate) normal: Vector2<f64>,
    /// Velocity of the vibrating wall at the contact, in the units of the state.
    pub(crate) velocity: Vector2<f64>,
    /// Index of the ledger of this wall or obstacle: first the faces, then the obstacles.
    pub(crate) ledger: usize,
}

/// Walls and obstacles that disks in one cell can touch.
#[derive(Clone, Copy, Debug, Default)]
struct Near {
    /// Bit mask of the faces of the box that disks in the cell can touch.
    faces: u8,
    /// Index of the first entry for this cell in the list of obstacle parts near cells.
    begin: u32,
    /// Index after the last entry for this cell in the list of obstacle parts near cells.
    end: u32,
}

/// Edge or corner of an obstacle that a disk can touch, or of one of its periodic images.
#[derive(Clone, Copy, Debug)]
struct Part {
    obstacle: u32,
    feature: Feature,
}

/// Walls and obstacles of a box, with a table of those that disks in each cell can touch.
#[derive(Debug)]
pub(crate) struct BoundaryGeometry {
    pub(crate) boundaries: DiskBoundaries,
    units: EngineUnits,
    near: Vec<Near>,
    lists: Vec<u32>,
    parts: Vec<Part>,
}

impl BoundaryGeometry {
    /// Creates the table of walls and obstacles near each cell; obstacles must be inside the box.
    pub(crate) fn new(
        boundaries: DiskBoundaries,
        domain: &Domain<Plane>,
        cells: &CellLists,
        largest_radius: f64,
        units: EngineUnits,
    ) -> Self {
        let mut surroundings = Self {
            near: Vec::new(),
            lists: Vec::new(),
            parts: Vec::new(),
            boundaries,
            units,
        };
        if !surroundings.boundaries.is_empty() {
            surroundings.near = vec![Near::default(); cells.places()];
            surroundings.find_walls(cells, largest_radius);
            surroundings.find_obstacles(domain, cells, largest_radius);
        }
        surroundings
    }

    /// Returns true if the box has no walls and no obstacles.
    #[inline(always)]
    pub(crate) fn is_empty(&self) -> bool {
        self.near.is_empty()
    }

    /// Marks the cells whose disks can touch a wall, at all displacements of a vibrating wall.
    fn find_walls(&mut self, cells: &CellLists, largest_radius: f64) {
        let counts = cells.counts();
        for axis in 0..2 {
            for side in 0..2 {
                let Some(wall) = self.boundaries.walls.wall(axis, side) else {
                    continue;
                };
                let amplitude = wall
                    .vibration
                    .map_or(0.0, |vibration| vibration.amplitude());
                let reach = (amplitude + largest_radius) * (1.0 + 1e-9);
                let steps = (reach / cells.width()[axis]).floor() as usize;
                let within = (steps + 1).min(usize::from(counts[axis])) as u16;
                for number in 0..within {
                    let number = if side == 0 {
                        number
                    } else {
                        counts[axis] - 1 - number
                    };
                    for other in 0..counts[1 - axis] {
                        let cell = if axis == 0 {
                            [number, other]
                        } else {
                            [other, number]
                        };
                        self.near[cells.place(cell, 1, 1)].faces |= 1 << (2 * axis + side);
                    }
                }
            }
        }
    }

    /// Lists for each cell the sides and corners of obstacles that its disks can touch.
    fn find_obstacles(&mut self, domain: &Domain<Plane>, cells: &CellLists, largest_radius: f64) {
        let (width, lengths) = (cells.width(), domain.lengths());
        let (diagonal, counts) = (0.5 * width.norm(), cells.counts());
        let mut listed: Vec<(u32, u32)> = Vec::new();
        for (obstacle, shape) in self.boundaries.obstacles.iter().enumerate() {
            let reach = shape.taken(largest_radius) * (1.0 + 1e-9) + 1e-12 * lengths.amax();
            for feature in shape.features() {
                let bounds = feature.bounds();
                // Cells of the box, and of its neighbour images along periodic axes: there may be
                // none beyond, however large a particle is.
                let number = |position: f64, axis: usize| {
                    let count = i32::from(counts[axis]);
                    let margin = if cells.is_periodic(axis) { count } else { 0 };
                    let number = (position / width[axis]).floor() as i32;
                    number.clamp(-margin, count - 1 + margin)
                };
                let least = [0, 1].map(|axis| number(bounds[0][axis] - reach, axis));
                let most = [0, 1].map(|axis| number(bounds[1][axis] + reach, axis));
                // The images that were needed so far: boxes away, and number of the part.
                let mut images: Vec<([i32; 2], u32)> = Vec::new();
                for x in least[0]..=most[0] {
                    for y in least[1]..=most[1] {
                        let (place, boxes) = cells.place_beyond([x, y]);
                        let beyond = |axis: usize| boxes[axis] != 0 && !cells.is_periodic(axis);
                        let steps = Vector2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
                        let centre = width.component_mul(&steps);
                        if beyond(0) || beyond(1) || feature.distance(centre) > diagonal + reach {
                            continue;
                        }
                        let known = images.iter().find(|image| image.0 == boxes);
                        let part = known.map_or(self.parts.len() as u32, |image| image.1);
                        if known.is_none() {
                            let [x, y] = boxes.map(f64::from);
                            let shift = -domain.images().image([x, y, 0.0]).position;
                            images.push((boxes, part));
                            self.parts.push(Part {
                                obstacle: obstacle as u32,
                                feature: feature.moved(shift),
                            });
                        }
                        listed.push((place as u32, part));
                    }
                }
            }
        }
        listed.sort_unstable();
        for run in listed.chunk_by(|a, b| a.0 == b.0) {
            let near = &mut self.near[run[0].0 as usize];
            near.begin = self.lists.len() as u32;
            self.lists.extend(run.iter().map(|&(_, part)| part));
            near.end = self.lists.len() as u32;
        }
    }

    /// Returns the first contact of a disk with a wall or obstacle before its limit: the time until
    /// then \[engine time\], and the number of the wall or obstacle part.
    pub(crate) fn first_contact(&self, cells: &CellLists, disk: &Approach) -> Option<(f64, u32)> {
        let near = self.near[cells.place(disk.home, 1, 1)];
        let mut first: Option<(f64, u32)> = None;
        let mut limit = disk.limit;
        for face in 0..FACES {
            if near.faces >> face & 1 == 1
                && let Some(wait) = self.time_to_wall(cells, face, disk, limit)
                && wait < limit
            {
                limit = wait;
                first = Some((wait, face as u32));
            }
        }
        if near.begin < near.end {
            let flight = FlyingParticle {
                position: cells.corner(disk.home) + disk.position,
                velocity: disk.velocity,
                acceleration: disk.acceleration,
            };
            for &part in &self.lists[near.begin as usize..near.end as usize] {
                let Part { obstacle, feature } = self.parts[part as usize];
                let radius = self.boundaries.obstacles[obstacle as usize].taken(disk.radius);
                if let Some(hit) = feature.first_contact(&flight, radius, limit) {
                    limit = hit.time;
                    first = Some((hit.time, FACES as u32 + part));
                }
            }
        }
        first
    }

    fn time_to_wall(
        &self,
        cells: &CellLists,
        face: usize,
        disk: &Approach,
        limit: f64,
    ) -> Option<f64> {
        let (axis, side) = (face / 2, face % 2);
        let wall = self.boundaries.walls.wall(axis, side)?;
        // Away from the wall: the last boundary of the last cell is the face.
        let (sign, steps) = if side == 0 {
            (1.0, disk.home[axis])
        } else {
            (-1.0, cells.counts()[axis] - disk.home[axis])
        };
        let corner = f64::from(steps) * cells.width()[axis];
        let height = corner + sign * disk.position[axis] - disk.radius;
        let velocity = sign * disk.velocity[axis];
        let acceleration = sign * disk.acceleration[axis];
        let Some(vibration) = &wall.vibration else {
            return time_to_plane(height, velocity, acceleration);
        };
        let speed = self.units.speed;
        let wait = time_to_vibrating_plane(
            height,
            velocity * speed,
            acceleration * speed * speed,
            vibration,
            self.phase(vibration, disk.clock),
            limit / speed,
        );
        wait.map(|wait| wait * speed)
    }

    /// Returns an absolute time within few periods of a vibration at which the wall is displaced as
    /// at an engine time: small, so that no digits are lost \[time\].
    fn phase(&self, vibration: &Vibration, clock: f64) -> f64 {
        self.units.epoch.rem_euclid(vibration.period()) + clock / self.units.speed
    }

    /// Returns law, normal and velocity of the wall or obstacle part `what` that a disk at a
    /// position touches at an engine time.
    pub(crate) fn touched(&self, what: u32, place: Vector2<f64>, clock: f64) -> Touched {
        let what = what as usize;
        if what >= FACES {
            let Part { obstacle, feature } = self.parts[what - FACES];
            return Touched {
                rebound: *self.boundaries.obstacles[obstacle as usize].rebound(),
                normal: feature.normal(place),
                velocity: Vector2::zeros(),
                ledger: FACES + obstacle as usize,
            };
        }
        let (axis, side) = (what / 2, what % 2);
        let normal = Walls::<Plane>::normal(axis, side);
        let wall = self.boundaries.walls.wall(axis, side);
        let wall = wall
            .copied()
            .unwrap_or_else(stosszahl_model::Wall::specular);
        let time = (wall.vibration).map_or(0.0, |vibration| self.phase(&vibration, clock));
        Touched {
            rebound: wall.rebound,
            normal,
            velocity: wall.velocity(normal, time),
            ledger: what,
        }
    }

    /// Returns the depth by which a disk at a position overlaps a wall or obstacle at an engine
    /// time \[length\]; 0 or less without overlap.
    pub(crate) fn overlap(
        &self,
        domain: &Domain<Plane>,
        place: Vector2<f64>,
        radius: f64,
        clock: f64,
    ) -> f64 {
        let mut worst = f64::NEG_INFINITY;
        for face in 0..FACES {
            let (axis, side) = (face / 2, face % 2);
            if let Some(wall) = self.boundaries.walls.wall(axis, side) {
                let time = (wall.vibration).map_or(0.0, |vibration| self.phase(&vibration, clock));
                worst =
                    worst.max(radius - above(domain, axis, side, place) + wall.displacement(time));
            }
        }
        for obstacle in &self.boundaries.obstacles {
            for image in images(domain, place) {
                worst = worst.max(overlap_of(obstacle, image, radius));
            }
        }
        worst
    }

    /// Returns the number of faces, and of sides and corners of obstacles, that disks can touch.
    pub(crate) fn things(&self) -> usize {
        FACES + self.parts.len()
    }

    /// Returns the memory that the table of walls and obstacles occupies \[bytes\].
    pub(crate) fn memory_bytes(&self) -> usize {
        self.near.capacity() * size_of::<Near>()
            + self.lists.capacity() * 4
            + self.parts.capacity() * size_of::<Part>()
    }
}

/// Returns the distance of a position from a face of the box \[length\].
pub(crate) fn above(domain: &Domain<Plane>, axis: usize, side: usize, place: Vector2<f64>) -> f64 {
    if side == 0 {
        place[axis]
    } else {
        domain.lengths()[axis] - place[axis]
    }
}

/// Returns a position and its periodic images one box away along each periodic axis.
pub(crate) fn images(
    domain: &Domain<Plane>,
    place: Vector2<f64>,
) -> impl Iterator<Item = Vector2<f64>> {
    let map = *domain.images();
    let steps = [0, 1].map(|axis| {
        let all: &'static [f64] = if domain.is_periodic(axis) {
            &[0.0, -1.0, 1.0]
        } else {
            &[0.0]
        };
        all
    });
    steps[0].iter().flat_map(move |&right| {
        let shift = move |&up: &f64| map.image([right, up, 0.0]).position;
        steps[1].iter().map(move |up| place + shift(up))
    })
}

/// Returns the depth by which a disk overlaps an obstacle \[length\]; minus infinity far from it.
pub(crate) fn overlap_of(obstacle: &Obstacle, place: Vector2<f64>, radius: f64) -> f64 {
    let [least, most] = obstacle.bounds();
    let outside =
        |axis: usize| place[axis] < least[axis] - radius || place[axis] > most[axis] + radius;
    if outside(0) || outside(1) {
        f64::NEG_INFINITY
    } else {
        radius - obstacle.clearance(place)
    }
}
