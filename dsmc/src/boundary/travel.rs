//! Free flight of one simulator between walls and obstacles: all contacts in a time step are
//! computed one after the other, exact in time.

use nalgebra::Vector2;
use stosszahl_model::random::{ShortStream, StreamBundle};
use stosszahl_model::walls::flight::{time_to_plane, time_to_vibrating_plane};
use stosszahl_model::walls::{Rebound, Touch};
use stosszahl_model::{Face, Field, ParticleModel, Sizes, Space, Surface, Vector, VectorOf, Wall};

use super::ledgers::{Ledgers, energy};
use super::obstacles::ObstacleMap;
use super::surroundings::GridBoundaries;
use crate::particle::{DisplacementTracking, Simulator, SimulatorOf};

/// Largest number of contacts with one wall in one flight. A particle that falls onto an inelastic
/// floor touches it infinitely often in finite time; it is set to rest instead, and counted.
const MOST_TOUCHES: u32 = 1000;

/// Slope at which a particle that slides along an obstacle moves away from it, so that rounding
/// does not lead inside.
const UPWARDS: f64 = 1e-12;

/// Free flight of one simulator with boundaries: particle model, boundary conditions, start time
/// and duration.
pub(crate) struct BoundaryFlight<'a, P: ParticleModel> {
    pub(crate) scene: &'a P,
    pub(crate) surroundings: &'a GridBoundaries<P>,
    /// Time at which the simulator's flight starts \[time\].
    pub(crate) begin: f64,
    /// Duration of the simulator's flight \[time\].
    pub(crate) duration: f64,
    /// Number of particles that the simulator represents.
    pub(crate) particles: f64,
}

/// Random stream for the rebounds of one simulator from diffuse walls, created when the first
/// number is needed.
pub(crate) struct Draws {
    bundle: StreamBundle,
    address: u64,
    stream: Option<ShortStream>,
}

impl Draws {
    /// Creates the random stream at an address, without drawing from it yet.
    pub(crate) fn stream_at(bundle: StreamBundle, address: u64) -> Self {
        Self {
            bundle,
            address,
            stream: None,
        }
    }

    /// Returns the random stream, seeded at the first call.
    pub(crate) fn stream(&mut self) -> &mut ShortStream {
        self.stream
            .get_or_insert_with(|| self.bundle.stream_at(self.address))
    }
}

/// Next event in the flight of a simulator: contact with a face or obstacle, periodic crossing, or
/// release from a wall.
enum FlightEvent {
    /// Contact with the wall or open face of an axis and a side.
    Contact(usize, usize),
    /// Release from the vibrating wall on which the simulator rests along an axis, at the time when
    /// the wall turns.
    Release(usize),
    /// Crossing of the periodic face of an axis and a side.
    Wrap(usize, usize),
    /// Contact with an obstacle: its index, its rebound law, and the unit normal at the contact.
    Obstacle(usize, Rebound, [f64; 2]),
}

/// State of rest of a simulator on a wall along one axis.
#[derive(Clone, Copy)]
struct Rest {
    side: usize,
    /// Time at which the simulator is released from the wall \[time\].
    until: f64,
}

/// State of a simulator in the course of its flight: clock, acceleration, walls it rests on, and
/// numbers of contacts.
struct Motion<'a, 'b, P: ParticleModel> {
    trip: &'a BoundaryFlight<'b, P>,
    mass: f64,
    radius: f64,
    /// Distance from the faces of the box at which the simulator's centre is stopped \[length\].
    clearance: f64,
    acceleration: VectorOf<P>,
    now: f64,
    left: f64,
    rests: [Option<Rest>; 3],
    touches: [u32; 3],
    obstacle_touches: u32,
    /// Index of the obstacle that the simulator slides along, and the acceleration by its normal
    /// force; `None` if it slides along none.
    support: Option<(usize, VectorOf<P>)>,
}

impl<P: ParticleModel> BoundaryFlight<'_, P> {
    /// Moves a simulator to the end of its free flight, with rebounds from walls and obstacles.
    /// Returns `false` if it left through an open face.
    pub(crate) fn travel<F: DisplacementTracking<P::Space>>(
        &self,
        simulator: &mut SimulatorOf<P, F>,
        draws: &mut Draws,
        ledgers: &mut Ledgers<P::Space>,
    ) -> bool {
        let sizes = self.scene.sizes();
        let radius = sizes.radius(simulator.tag);
        let mut motion = Motion {
            trip: self,
            mass: sizes.mass(simulator.tag),
            radius,
            clearance: self.surroundings.clearance(radius),
            acceleration: self.scene.field().acceleration(),
            now: self.begin,
            left: self.duration,
            rests: [None; 3],
            touches: [0; 3],
            obstacle_touches: 0,
            support: None,
        };
        while let Some((wait, next)) = motion.next::<F>(simulator) {
            motion.drift::<F>(simulator, wait, ledgers);
            match next {
                FlightEvent::Release(axis) => motion.release(axis),
                FlightEvent::Wrap(axis, side) => {
                    let length = self.surroundings.lengths()[axis];
                    simulator.position[axis] = [length.next_down(), 0.0][side];
                }
                FlightEvent::Obstacle(number, law, normal) => {
                    motion.strike::<F>(simulator, number, law, normal, draws, ledgers);
                }
                FlightEvent::Contact(axis, side) => {
                    let Some(wall) = self.surroundings.walls().wall(axis, side) else {
                        motion.leave::<F>(simulator, axis, side, ledgers);
                        return false;
                    };
                    motion.rebound::<F>(simulator, [axis, side], wall, draws, ledgers);
                }
            }
        }
        let left = motion.left;
        motion.drift::<F>(simulator, left, ledgers);
        self.surroundings
            .keep_inside(&mut simulator.position, motion.clearance);
        true
    }
}

impl<P: ParticleModel> Motion<'_, '_, P> {
    /// Returns the height of a simulator's centre above its contact position at a face, and its
    /// velocity and acceleration away from the face.
    fn approach<F: DisplacementTracking<P::Space>>(
        &self,
        simulator: &SimulatorOf<P, F>,
        axis: usize,
        side: usize,
        clearance: f64,
    ) -> [f64; 3] {
        let (x, v, a) = (
            simulator.position[axis],
            simulator.velocity[axis],
            self.acceleration[axis],
        );
        if side == 0 {
            [x - clearance, v, a]
        } else {
            let length = self.trip.surroundings.lengths()[axis];
            [length - clearance - x, -v, -a]
        }
    }

    /// Returns the next event of the simulator's flight and the time until then; `None` if the
    /// flight ends before.
    fn next<F: DisplacementTracking<P::Space>>(
        &self,
        simulator: &SimulatorOf<P, F>,
    ) -> Option<(f64, FlightEvent)> {
        let mut wait = self.left;
        let mut next = None;
        for &(axis, side) in self.trip.surroundings.faces() {
            if let Some(rest) = self.rests[axis] {
                if rest.until - self.now < wait {
                    wait = (rest.until - self.now).max(0.0);
                    next = Some(FlightEvent::Release(axis));
                }
                continue;
            }
            let face = self.trip.surroundings.walls().face(axis, side);
            let time = match face {
                Face::Periodic => None,
                Face::Open => {
                    let [height, speed, pull] = self.approach::<F>(simulator, axis, side, 0.0);
                    time_to_plane(height, speed, pull)
                }
                Face::Wall(wall) => {
                    let clearance = self.clearance;
                    let [height, speed, pull] =
                        self.approach::<F>(simulator, axis, side, clearance);
                    match &wall.vibration {
                        None => time_to_plane(height, speed, pull),
                        Some(vibration) => {
                            time_to_vibrating_plane(height, speed, pull, vibration, self.now, wait)
                        }
                    }
                }
            };
            if let Some(time) = time
                && time < wait
            {
                wait = time;
                next = Some(FlightEvent::Contact(axis, side));
            }
        }
        if let Some(obstacles) = self.trip.surroundings.obstacles() {
            self.look_for_obstacles::<F>(simulator, obstacles, &mut wait, &mut next);
        }
        next.map(|next| (wait, next))
    }

    /// Replaces the next event of a flight by a contact with an obstacle, or the crossing of a
    /// periodic face, if that is earlier than `wait` \[time\].
    fn look_for_obstacles<F: DisplacementTracking<P::Space>>(
        &self,
        simulator: &SimulatorOf<P, F>,
        obstacles: &ObstacleMap,
        wait: &mut f64,
        next: &mut Option<FlightEvent>,
    ) {
        for axis in 0..2 {
            for side in 0..2 {
                if *self.trip.surroundings.walls().face(axis, side) != Face::Periodic {
                    continue;
                }
                let [height, speed, pull] = self.approach::<F>(simulator, axis, side, 0.0);
                if let Some(time) = time_to_plane(height, speed, pull)
                    && time < *wait
                {
                    *wait = time;
                    *next = Some(FlightEvent::Wrap(axis, side));
                }
            }
        }
        let planar = |vector: VectorOf<P>| Vector2::new(vector[0], vector[1]);
        let way = [simulator.position, simulator.velocity, self.acceleration].map(planar);
        if let Some((obstacle, number, hit)) = obstacles.first_contact(way, self.clearance, *wait)
            && hit.time < *wait
        {
            *wait = hit.time;
            let normal = [hit.normal[0], hit.normal[1]];
            *next = Some(FlightEvent::Obstacle(number, *obstacle.rebound(), normal));
        }
    }

    /// Executes the contact of a simulator with an obstacle: rebound, random numbers of diffuse
    /// surfaces, and ledger.
    fn strike<F: DisplacementTracking<P::Space>>(
        &mut self,
        simulator: &mut SimulatorOf<P, F>,
        number: usize,
        law: Rebound,
        normal: [f64; 2],
        draws: &mut Draws,
        ledgers: &mut Ledgers<P::Space>,
    ) {
        let normal = P::Space::from_components(|axis| normal.get(axis).copied().unwrap_or(0.0));
        let touch = Touch {
            normal,
            wall: VectorOf::<P>::default(),
            mass: self.mass,
            radius: self.radius,
        };
        self.let_go();
        let before = (simulator.velocity, self.energy::<F>(simulator));
        let Simulator { velocity, spin, .. } = simulator;
        law.apply(self.trip.scene, &touch, velocity, spin, || draws.stream());
        for axis in 0..P::Space::DIMENSION {
            // The obstacle pushed the simulator off, or into, a wall on which it rested.
            if self.rests[axis].is_some() && simulator.velocity[axis] != before.0[axis] {
                self.release(axis);
            }
        }
        self.obstacle_touches += 1;
        let leaving = simulator.velocity.inner(&normal);
        let pull = self.acceleration.inner(&normal);
        let too_often = self.obstacle_touches > MOST_TOUCHES;
        if pull < 0.0 && (leaving <= 0.0 || too_often) {
            // Sliding along the supporting obstacle until the next flight.
            simulator.velocity -= normal * leaving;
            let speed = simulator.velocity.square().sqrt();
            simulator.velocity += normal * (UPWARDS * speed);
            let lift = normal * (-pull * (1.0 + UPWARDS));
            self.acceleration += lift;
            self.support = Some((number, lift));
        }
        let gained = (
            (simulator.velocity - before.0) * self.mass,
            self.energy::<F>(simulator) - before.1,
        );
        ledgers.obstacles[number].enter(self.trip.particles, gained.0, gained.1);
        ledgers.settled_particles += u64::from(too_often);
        if self.obstacle_touches > 2 * MOST_TOUCHES || (too_often && self.support.is_none()) {
            // Too many contacts in a wedge: the simulator stays in place to the end of the flight.
            self.left = 0.0;
        }
    }

    /// Moves the simulator freely for a time \[time\], along the walls on which it rests. The
    /// impulse by which walls and obstacles support it goes to their ledgers.
    fn drift<F: DisplacementTracking<P::Space>>(
        &mut self,
        simulator: &mut SimulatorOf<P, F>,
        time: f64,
        ledgers: &mut Ledgers<P::Space>,
    ) {
        let way = (simulator.velocity + self.acceleration * (0.5 * time)) * time;
        simulator.position += way;
        F::add_displacement(&mut simulator.mark, way);
        simulator.velocity += self.acceleration * time;
        self.now += time;
        self.left -= time;
        if let Some((number, lift)) = self.support {
            let force = lift * (self.mass * self.trip.particles);
            ledgers.obstacles[number].momentum += force * time;
        }
        for (axis, rest) in self.rests.iter().enumerate() {
            if let Some(rest) = rest {
                // The wall bears the weight.
                let weight = self.trip.scene.field().acceleration()[axis] * self.mass;
                let momentum = -weight * time * self.trip.particles;
                let ledger = &mut ledgers.walls[axis][rest.side];
                ledger.momentum[axis] += momentum;
                ledger.energy += momentum * simulator.velocity[axis];
            }
        }
    }

    /// Ends the sliding of the simulator along an obstacle: removes the acceleration by its normal
    /// force.
    fn let_go(&mut self) {
        if let Some((_, lift)) = self.support.take() {
            self.acceleration -= lift;
        }
    }

    /// Ends the rest of the simulator on the wall along an axis, so that it flies freely again.
    fn release(&mut self, axis: usize) {
        self.let_go();
        self.rests[axis] = None;
        self.acceleration[axis] = self.trip.scene.field().acceleration()[axis];
    }

    /// Adds a simulator that leaves through an open face to the ledger of that face.
    fn leave<F: DisplacementTracking<P::Space>>(
        &self,
        simulator: &SimulatorOf<P, F>,
        axis: usize,
        side: usize,
        ledgers: &mut Ledgers<P::Space>,
    ) {
        let energy = self.energy::<F>(simulator);
        let particles = -self.trip.particles;
        ledgers.open[axis][side].enter(particles, self.mass, simulator.velocity, energy);
    }

    /// Returns the kinetic energy of one particle of the simulator, translational and rotational
    /// \[energy\].
    fn energy<F: DisplacementTracking<P::Space>>(&self, simulator: &SimulatorOf<P, F>) -> f64 {
        let surface = self.trip.scene.surface();
        let turning = surface.spin_energy(self.mass, self.radius, simulator.spin);
        energy(self.mass, simulator.velocity, turning)
    }

    /// Executes the contact of a simulator with a wall that it has just reached: rebound, random
    /// numbers of diffuse walls, and ledger.
    fn rebound<F: DisplacementTracking<P::Space>>(
        &mut self,
        simulator: &mut SimulatorOf<P, F>,
        [axis, side]: [usize; 2],
        wall: &Wall<P::Space>,
        draws: &mut Draws,
        ledgers: &mut Ledgers<P::Space>,
    ) {
        self.let_go();
        // The coordinate is set to the wall exactly.
        let height = self.clearance + wall.displacement(self.now);
        simulator.position[axis] = if side == 0 {
            height
        } else {
            self.trip.surroundings.lengths()[axis] - height
        };
        let normal = stosszahl_model::Walls::<P::Space>::normal(axis, side);
        let touch = Touch {
            normal,
            wall: wall.velocity(normal, self.now),
            mass: self.mass,
            radius: self.radius,
        };
        let before = (simulator.velocity, self.energy::<F>(simulator));
        let arrives = (before.0 - touch.wall).inner(&normal) < 0.0;
        wall.rebound.apply(
            self.trip.scene,
            &touch,
            &mut simulator.velocity,
            &mut simulator.spin,
            || draws.stream(),
        );
        self.touches[axis] += 1;
        let leaving = (simulator.velocity - touch.wall).inner(&normal);
        let pull = self.acceleration.inner(&normal);
        let too_often = self.touches[axis] > MOST_TOUCHES;
        let comes_to_rest = pull < 0.0 && (leaving <= 0.0 || too_often);
        if comes_to_rest {
            simulator.velocity[axis] = touch.wall[axis];
            self.acceleration[axis] = 0.0;
            let turn = wall.vibration.map(|v| v.next_turn(self.now));
            let until = turn.unwrap_or(f64::INFINITY);
            self.rests[axis] = Some(Rest { side, until });
        }
        let gained = (
            (simulator.velocity - before.0) * self.mass,
            self.energy::<F>(simulator) - before.1,
        );
        let ledger = &mut ledgers.walls[axis][side];
        ledger.enter(self.trip.particles, gained.0, gained.1);
        if !arrives {
            // A particle already at rest counts no contact.
            ledger.contacts -= self.trip.particles;
        }
        ledgers.settled_particles += u64::from(too_often);
        if too_often && !comes_to_rest {
            // Too many contacts between walls: the simulator stays in place to the flight's end.
            self.left = 0.0;
        }
    }
}
