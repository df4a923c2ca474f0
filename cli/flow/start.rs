//! The initial state of a flow: grains at random in the box, outside walls and obstacles, Maxwellian.

use rand::{Rng, RngExt};
use stosszahl_model::initial::{maxwellian, thermal_spins};
use stosszahl_model::random::{Purpose, Streams};
use stosszahl_model::walls::Obstacle;
use stosszahl_model::{Body, Domain, Physics, Sizes, Space, State, Vector, VectorOf, Walls};

use super::plan::Plan;

/// Why a start cannot be made.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum StartError {
    /// No room.
    #[error(
        "grain {grain} of {grains} finds no place without overlap in {trials} trials; fewer or smaller grains, or a larger box, are needed (random addition jams near a packing fraction of 0.5)"
    )]
    Full {
        /// Index of the grain.
        grain: usize,
        /// How many there are to be.
        grains: usize,
        /// How often it was tried.
        trials: usize,
    },
    /// The box has a side that is not finite.
    #[error("the box has no volume")]
    Box,
}

/// How grains keep away from each other and from walls at the start.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Room {
    /// Points: anywhere in the box.
    Points,
    /// Grains that overlap neither each other nor walls.
    Grains,
}

/// Makes the state.
///
/// # Errors
/// [`StartError::Full`] if grains jam.
pub fn make<P: Physics>(
    plan: &Plan,
    scene: &P,
    walls: &Walls<P::Space>,
    obstacles: &[Obstacle],
    room: Room,
    streams: &Streams,
) -> Result<State<P>, StartError> {
    let size = Plan::vector::<P::Space>(&plan.flow.domain.size);
    let domain = walls.domain(size).ok_or(StartError::Box)?;
    let grains = if plan.flow.start.empty {
        0
    } else {
        plan.flow.grains() as usize
    };
    let mut state = State {
        time: 0.0,
        domain,
        bodies: Vec::with_capacity(grains),
    };
    let mut stream = streams.at(Purpose::Placement, [0, 0]);
    let mut places = Places::new(scene, domain, walls, obstacles, room, grains);
    // The largest first, which find no place later.
    let mut order: Vec<usize> = (0..grains).collect();
    let radius = |index: usize| scene.sizes().radius(scene.sizes().tag(index));
    order.sort_by(|&a, &b| radius(b).total_cmp(&radius(a)));
    let origin = VectorOf::<P>::default();
    state.bodies.resize(grains, Body::new(origin, origin));
    for index in order {
        state.bodies[index].position = places.find(index, radius(index), &mut stream)?;
    }
    let temperature = plan.flow.start.temperature;
    let mut stream = streams.at(Purpose::Velocities, [0, 0]);
    maxwellian(scene, &mut state, temperature, &mut stream);
    if let Some(drift) = &plan.flow.start.velocity {
        let drift = Plan::vector::<P::Space>(drift);
        for body in &mut state.bodies {
            body.velocity += drift;
        }
    }
    let mut stream = streams.at(Purpose::Spins, [0, 0]);
    thermal_spins(scene, &mut state, plan.spin_temperature(), &mut stream);
    Ok(state)
}

/// Places that are taken, in a grid.
struct Places<'a, P: Physics> {
    walls: &'a Walls<P::Space>,
    obstacles: &'a [Obstacle],
    domain: Domain<P::Space>,
    size: VectorOf<P>,
    room: Room,
    grains: usize,
    counts: [usize; 3],
    cells: Vec<Vec<(VectorOf<P>, f64)>>,
}

/// Trials for one grain.
const MOST_TRIALS: usize = 1_000_000;

impl<'a, P: Physics> Places<'a, P> {
    fn new(
        scene: &P,
        domain: Domain<P::Space>,
        walls: &'a Walls<P::Space>,
        obstacles: &'a [Obstacle],
        room: Room,
        grains: usize,
    ) -> Self {
        let size = domain.lengths();
        let largest = scene.sizes().largest_radius();
        // As fine as a diameter, but never many more cells than grains.
        let most = (2.0 * grains as f64)
            .powf(1.0 / P::Space::DIMENSION as f64)
            .ceil() as usize
            + 1;
        let counts = [0, 1, 2].map(|axis| {
            if axis < P::Space::DIMENSION && room == Room::Grains {
                ((size[axis] / (2.0 * largest)).floor() as usize).clamp(1, most)
            } else {
                1
            }
        });
        Self {
            walls,
            obstacles,
            domain,
            size,
            room,
            grains,
            counts,
            cells: vec![Vec::new(); counts.iter().product()],
        }
    }

    fn cell(&self, position: VectorOf<P>) -> [usize; 3] {
        [0, 1, 2].map(|axis| {
            if axis < P::Space::DIMENSION {
                let place = position[axis] / self.size[axis] * self.counts[axis] as f64;
                (place as usize).min(self.counts[axis] - 1)
            } else {
                0
            }
        })
    }

    fn number(&self, [x, y, z]: [usize; 3]) -> usize {
        x + self.counts[0] * (y + self.counts[1] * z)
    }

    fn find(
        &mut self,
        grain: usize,
        radius: f64,
        stream: &mut impl Rng,
    ) -> Result<VectorOf<P>, StartError> {
        for _ in 0..MOST_TRIALS {
            let mut trial = VectorOf::<P>::default();
            for axis in 0..P::Space::DIMENSION {
                let edge = |side: usize| self.clearance(axis, side, radius);
                let (low, high) = (edge(0), self.size[axis] - edge(1));
                trial[axis] = low + (high - low) * stream.random::<f64>();
            }
            if self.is_free(trial, radius) {
                if self.room == Room::Grains {
                    let cell = self.number(self.cell(trial));
                    self.cells[cell].push((trial, radius));
                }
                return Ok(trial);
            }
        }
        Err(StartError::Full {
            grain,
            grains: self.grains,
            trials: MOST_TRIALS,
        })
    }

    /// How far from a face the centre of a grain is at least.
    fn clearance(&self, axis: usize, side: usize, radius: f64) -> f64 {
        match (self.walls.wall(axis, side), self.room) {
            // A little more, so that no grain touches a wall by rounding.
            (Some(wall), Room::Grains) => wall.displacement(0.0) + radius * (1.0 + 1e-9),
            (Some(wall), Room::Points) => wall.displacement(0.0),
            (None, _) => 0.0,
        }
    }

    fn is_free(&self, trial: VectorOf<P>, radius: f64) -> bool {
        let reach = if self.room == Room::Grains {
            radius * (1.0 + 1e-9)
        } else {
            0.0
        };
        let blocked = self
            .obstacles
            .iter()
            .any(|obstacle| obstacle.overlaps([trial[0], trial[1]].into(), reach, 0.0));
        if blocked || self.room == Room::Points {
            return !blocked;
        }
        let home = self.cell(trial);
        let around = |axis: usize| {
            let (centre, count) = (home[axis], self.counts[axis]);
            let reach = if count < 3 {
                0..count
            } else {
                centre + count - 1..centre + count + 2
            };
            reach.map(move |cell| cell % count)
        };
        around(2).all(|z| {
            around(1).all(|y| {
                around(0).all(|x| {
                    self.cells[self.number([x, y, z])]
                        .iter()
                        .all(|&(other, far)| {
                            let apart = self.domain.displacement(trial, other);
                            apart.square() > (radius + far).powi(2)
                        })
                })
            })
        })
    }
}
