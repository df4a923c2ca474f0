//! Boundary processes in one free-flight phase: contacts with walls and obstacles, outflow, inflow,
//! and splitting or merging at changes of weight.

use stosszahl_model::random::{Purpose, StreamBundle, Streams};
use stosszahl_model::{ParticleModel, Sizes, Space, Surface, VectorOf};

use super::ledgers::{Ledgers, energy};
use super::surroundings::GridBoundaries;
use super::travel::{BoundaryFlight, Draws};
use crate::grid::Grid;
use crate::particle::{DisplacementTracking, SimulatorOf};
use crate::random_counts::draw_whole;

/// Number, start time and duration of one free-flight phase of the DSMC time step.
#[derive(Clone, Copy)]
pub(crate) struct FlightTiming {
    /// Number of the free-flight phase since the start of the run, from 0.
    pub(crate) number: u64,
    /// Time at which the free-flight phase starts \[time\].
    pub(crate) begin: f64,
    /// Duration of the free-flight phase \[time\].
    pub(crate) duration: f64,
}

/// Boundary conditions applied in one free-flight phase. Random numbers are addressed by phase,
/// cell of origin and order in that cell, so they do not depend on thread or process.
pub(crate) struct Passage<'a, P: ParticleModel> {
    pub(crate) surroundings: &'a GridBoundaries<P>,
    scene: &'a P,
    /// Number of particles per simulator where the weight factor is one.
    weight: f64,
    begin: f64,
    duration: f64,
    walls: StreamBundle,
    balance: StreamBundle,
    inflow: StreamBundle,
}

/// Address of the random numbers of a simulator in a free flight: the cell where it starts, and its
/// order in that cell.
#[derive(Clone, Copy)]
pub(crate) struct Origin {
    pub(crate) cell: u32,
    pub(crate) order: u32,
}

impl Origin {
    fn address(self) -> u64 {
        (u64::from(self.cell) << 32) | u64::from(self.order)
    }
}

impl<'a, P: ParticleModel> Passage<'a, P> {
    /// Prepares the boundary conditions for one free-flight phase.
    pub(crate) fn new(
        scene: &'a P,
        surroundings: &'a GridBoundaries<P>,
        weight: f64,
        streams: Streams,
        FlightTiming {
            number,
            begin,
            duration,
        }: FlightTiming,
    ) -> Self {
        Self {
            surroundings,
            scene,
            weight,
            begin,
            duration,
            walls: streams.bundle(Purpose::Walls, number),
            balance: streams.bundle(Purpose::Balance, number),
            inflow: streams.bundle(Purpose::Inflow, number),
        }
    }

    /// Moves a simulator for the duration of the free flight, with bounces off walls and obstacles.
    /// Returns `false` if it left through an open face.
    pub(crate) fn travel<F: DisplacementTracking<P::Space>>(
        &self,
        simulator: &mut SimulatorOf<P, F>,
        origin: Origin,
        ledgers: &mut Ledgers<P::Space>,
    ) -> bool {
        self.travel_from::<F>(simulator, origin, 0.0, ledgers)
    }

    /// Moves a simulator from a time `after` the begin of the free flight \[time\] to its end, with
    /// bounces off walls and obstacles. Returns `false` if it left through an open face.
    fn travel_from<F: DisplacementTracking<P::Space>>(
        &self,
        simulator: &mut SimulatorOf<P, F>,
        origin: Origin,
        after: f64,
        ledgers: &mut Ledgers<P::Space>,
    ) -> bool {
        let trip = BoundaryFlight {
            scene: self.scene,
            surroundings: self.surroundings,
            begin: self.begin + after,
            duration: self.duration - after,
            particles: self.weight * self.surroundings.factor(origin.cell),
        };
        let mut draws = Draws::stream_at(self.walls, origin.address());
        trip.travel::<F>(simulator, &mut draws, ledgers)
    }

    /// Draws the number of copies of a simulator that moved into a cell with another weight factor:
    /// 0 if it is removed, 1 if unchanged.
    pub(crate) fn copies<F: DisplacementTracking<P::Space>>(
        &self,
        simulator: &SimulatorOf<P, F>,
        origin: Origin,
        cell: u32,
        ledgers: &mut Ledgers<P::Space>,
    ) -> u64 {
        let [before, after] = [origin.cell, cell].map(|cell| self.surroundings.factor(cell));
        if before == after {
            return 1;
        }
        ledgers.balanced += 1;
        let mut stream = self.balance.stream_at(origin.address());
        let copies = draw_whole(before / after, &mut stream);
        let particles = self.weight * (copies as f64 * after - before);
        enter::<P, F>(self.scene, simulator, particles, &mut ledgers.balance);
        copies
    }

    /// Draws the simulators that an inflow brings into a boundary cell, and passes each with its
    /// origin to `land`. `members` simulators of the cell have used the first addresses of random
    /// numbers.
    pub(crate) fn let_in<F: DisplacementTracking<P::Space>>(
        &self,
        grid: &Grid<P::Space>,
        cell: [u32; 3],
        members: u32,
        ledgers: &mut Ledgers<P::Space>,
        mut land: impl FnMut(SimulatorOf<P, F>, Origin, &mut Ledgers<P::Space>),
    ) {
        let mut origin = Origin {
            cell: grid.number(cell),
            order: members,
        };
        let particles = self.weight * self.surroundings.factor(origin.cell);
        for (number, source) in self.surroundings.sources().iter().enumerate() {
            let (axis, side) = source.face();
            let last = grid.counts()[axis] - 1;
            if cell[axis] != [0, last][side] {
                continue;
            }
            let Some(corners) = self.surroundings.opening(grid, cell, source) else {
                continue;
            };
            let area: f64 = (0..P::Space::DIMENSION)
                .filter(|&other| other != axis)
                .map(|other| corners[1][other] - corners[0][other])
                .product();
            let mean = source.flux() * area * self.duration / particles;
            let address = u64::from(origin.cell) | (number as u64) << 32;
            let mut stream = self.inflow.stream_at(address);
            for _ in 0..draw_whole(mean, &mut stream) {
                let mut simulator = source.draw::<F>(self.scene, corners, &mut stream);
                let after = self.duration * draw_uniform(&mut stream);
                enter::<P, F>(
                    self.scene,
                    &simulator,
                    particles,
                    &mut ledgers.inflows[number],
                );
                if self.travel_from::<F>(&mut simulator, origin, after, ledgers) {
                    land(simulator, origin, ledgers);
                }
                origin.order += 1;
            }
        }
    }
}

/// Draws a random number uniformly from 0 to 1.
fn draw_uniform(stream: &mut impl rand::Rng) -> f64 {
    rand::RngExt::random(stream)
}

/// Adds a simulator that stands for `particles` particles to a transfer of mass, momentum and
/// energy.
pub(crate) fn enter<P: ParticleModel, F: DisplacementTracking<P::Space>>(
    scene: &P,
    simulator: &SimulatorOf<P, F>,
    particles: f64,
    transfer: &mut super::Transfer<P::Space>,
) {
    let sizes = scene.sizes();
    let (mass, radius) = (sizes.mass(simulator.tag), sizes.radius(simulator.tag));
    let turning = scene.surface().spin_energy(mass, radius, simulator.spin);
    let velocity: VectorOf<P> = simulator.velocity;
    transfer.enter(particles, mass, velocity, energy(mass, velocity, turning));
}
