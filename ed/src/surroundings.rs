//! Walls at the faces of the box, and obstacles in it, that disks can touch.
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

/// Faces of a box, which come before the obstacles: lower and upper along the first axis, then
/// along the second.
pub(crate) const FACES: usize = 4;

/// Walls at the faces of the box, and obstacles in it.
#[derive(Clone, Debug)]
pub struct DiskBoundaries {
    /// Faces of the box.
    pub walls: Walls<Plane>,
    /// Obstacles inside the box.
    pub obstacles: Vec<Obstacle>,
    /// Random streams of rebounds from diffuse walls.
    pub streams: Streams,
}

impl DiskBoundaries {
    /// Returns a periodic box with nothing in it.
    pub fn periodic() -> Self {
        Self {
            walls: Walls::none(),
            obstacles: Vec::new(),
            streams: Streams::new(0, 0),
        }
    }

    /// Number of ledgers: one for each face and each obstacle, or 0 without walls and obstacles.
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

/// Units of the engine: its speed, and the absolute time at which its own is zero.
#[derive(Clone, Copy, Debug)]
pub(crate) struct EngineUnits {
    pub(crate) speed: f64,
    pub(crate) epoch: f64,
}

/// Disk that may touch a wall or obstacle, in the engine's own units.
pub(crate) struct Approach {
    pub(crate) home: CellCoordinates,
    /// Position relative to the corner of the cell, at `clock`.
    pub(crate) position: Vector2<f64>,
    pub(crate) velocity: Vector2<f64>,
    pub(crate) acceleration: Vector2<f64>,
    pub(crate) radius: f64,
    /// Engine time of the position.
    pub(crate) clock: f64,
    /// Wait until the next predicted event of the disk, beyond which contacts do not count.
    pub(crate) limit: f64,
}

/// Wall or obstacle that was touched.
pub(crate) struct Touched {
    pub(crate) rebound: Rebound,
    /// Unit normal vector from the boundary into the gas.
    pub(crate) normal: Vector2<f64>,
    /// Velocity of the wall, in absolute units.
    pub(crate) velocity: Vector2<f64>,
    /// Index of its ledger: first the faces, then the obstacles.
    pub(crate) ledger: usize,
}

/// Walls and obstacles near a cell.
#[derive(Clone, Copy, Debug, Default)]
struct Near {
    /// Faces, one bit for each.
    faces: u8,
    /// Index of the cell's first entry in the list of obstacle parts.
    begin: u32,
    /// Index after the cell's last entry in the list of obstacle parts.
    end: u32,
}

/// Side or corner of an obstacle, or of one of its periodic images.
#[derive(Clone, Copy, Debug)]
struct Part {
    obstacle: u32,
    feature: Feature,
}

/// Walls and obstacles, with a table of the boundaries near each cell.
#[derive(Debug)]
pub(crate) struct BoundaryGeometry {
    pub(crate) boundaries: DiskBoundaries,
    units: EngineUnits,
    near: Vec<Near>,
    lists: Vec<u32>,
    parts: Vec<Part>,
}

impl BoundaryGeometry {
    /// Creates the table for a grid; obstacles are known to be inside the box.
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

    /// Returns true if there are no walls and no obstacles anywhere.
    #[inline(always)]
    pub(crate) fn is_empty(&self) -> bool {
        self.near.is_empty()
    }

    /// Marks the cells from which a wall can be touched, at all its displacements.
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

    /// Lists, for each cell, the sides and corners of obstacles that disks in it can touch.
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

    /// Returns the first contact of a disk before its limit: the wait for it, and the number of the
    /// wall or obstacle.
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

    /// Returns a time at which a vibration has the displacement of an engine time, small enough to
    /// have digits left.
    fn phase(&self, vibration: &Vibration, clock: f64) -> f64 {
        self.units.epoch.rem_euclid(vibration.period()) + clock / self.units.speed
    }

    /// Returns the wall or obstacle that a disk at a position touches at an engine time.
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

    /// Depth of a disk at a position in a wall or an obstacle at an engine time \[length\]; not
    /// above 0 if in none.
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

    /// Number of faces, and of sides and corners of obstacles, that can be touched.
    pub(crate) fn things(&self) -> usize {
        FACES + self.parts.len()
    }

    /// Memory held \[bytes\].
    pub(crate) fn memory_bytes(&self) -> usize {
        self.near.capacity() * size_of::<Near>()
            + self.lists.capacity() * 4
            + self.parts.capacity() * size_of::<Part>()
    }
}

/// Distance of a position from a face \[length\].
pub(crate) fn above(domain: &Domain<Plane>, axis: usize, side: usize, place: Vector2<f64>) -> f64 {
    if side == 0 {
        place[axis]
    } else {
        domain.lengths()[axis] - place[axis]
    }
}

/// Returns a position and its periodic images around the box.
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

/// Depth of a disk in an obstacle \[length\]; minus infinity from afar.
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
