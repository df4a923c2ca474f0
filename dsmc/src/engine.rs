//! The engine: simulators, cells, and the step.

use std::f64::consts::{PI, TAU};

use nalgebra::{Vector2, vector};
use rand::{Rng, RngExt};
use serde::{Deserialize, Serialize};
use stosszahl_model::random::{Purpose, Streams};
use stosszahl_model::{
    Body, Collision, Domain, Encounter, Field, Free, Observe, Physics, Plane, Restitution, Sizes,
    Smooth, State, collide, kinetic,
};

use crate::density::{Density, Scheme};

/// Numerical choices of a run. All of them buy accuracy or speed; none is physics.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Parameters {
    /// How density raises the collision rate.
    pub scheme: Scheme,
    /// Whether partners are displaced by one contact distance along the transferred momentum.
    pub displacement: bool,
    /// Smallest side of a cell \[length\]; `None`: half a mean free path, but at least two diameters.
    pub cell_size: Option<f64>,
    /// Simulators for each disk.
    pub simulators_per_disk: u32,
    /// Steps in which the fastest simulator crosses a cell, and in which a mean free time passes.
    pub steps_per_crossing: f64,
    /// Limit on chi.
    pub largest_contact_value: f64,
}

impl Parameters {
    fn check(&self) -> Result<(), EngineError> {
        let check = |name, value: f64, good: bool, allowed| {
            if good {
                Ok(())
            } else {
                Err(EngineError::BadParameter {
                    name,
                    value,
                    allowed,
                })
            }
        };
        let copies = f64::from(self.simulators_per_disk);
        check("simulators_per_disk", copies, copies >= 1.0, "at least 1")?;
        let steps = self.steps_per_crossing;
        check(
            "steps_per_crossing",
            steps,
            (1.0..=1e6).contains(&steps),
            "from 1 to 1e6",
        )?;
        let limit = self.largest_contact_value;
        check(
            "largest_contact_value",
            limit,
            (1.0..=1e9).contains(&limit),
            "from 1 to 1e9",
        )?;
        if let Some(size) = self.cell_size {
            check(
                "cell_size",
                size,
                size > 0.0 && size.is_finite(),
                "above zero",
            )?;
        }
        Ok(())
    }

    /// Mean free path at a packing fraction, by the scheme's own collision rate \[length\].
    pub fn mean_free_path(&self, packing_fraction: f64, diameter: f64) -> f64 {
        let chi = self
            .scheme
            .contact_value(packing_fraction)
            .min(self.largest_contact_value);
        diameter * kinetic::mean_free_path(packing_fraction.max(1e-12), chi)
    }

    /// Columns and rows of cells in a box: as many as fit at the chosen size.
    pub fn cells(
        &self,
        domain: &Domain<Plane>,
        packing_fraction: f64,
        diameter: f64,
    ) -> [usize; 2] {
        let automatic =
            || (0.5 * self.mean_free_path(packing_fraction, diameter)).max(2.0 * diameter);
        let side = self.cell_size.unwrap_or_else(automatic);
        // At most 2^26 cells in all: where more would fit, nearly all would be empty.
        [0, 1].map(|axis| ((domain.lengths()[axis] / side * (1.0 + 1e-12)) as usize).clamp(1, 8192))
    }
}

/// What was done, in numbers that do not depend on the machine.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Tally {
    /// Steps.
    pub steps: u64,
    /// Pairs tried.
    pub trials: u64,
    /// Pairs of simulators that collided.
    pub collisions: u64,
    /// Trials whose relative speed exceeded the majorant.
    pub majorant_violations: u64,
    /// Cells, summed over steps, with at least two simulators.
    pub active_cells: u64,
    /// Those of them in which chi was limited.
    pub limited_cells: u64,
    /// Collisions in cells in which chi was limited.
    pub limited_collisions: u64,
    /// Sum over collisions of the distance of the partners \[length\].
    pub separation: f64,
    /// Sum over collisions of `r_ij . dp_i + dr_i . p_i' + dr_j . p_j'` \[mass length^2/time\]: momentum
    /// carried from partner to partner, over the nearest image of their distance, and with partners that are displaced
    /// by `dr`, with the momentum p' after the collision. The compressibility factor of an elastic gas over the time t
    /// is `Z = 1 + weight virial/(D N T t)`, N being the number of disks.
    pub virial: f64,
    /// Largest number of collisions per simulator in one cell and step.
    pub busiest_cell: f64,
}

/// Why the engine could not start.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum EngineError {
    /// A parameter has no meaning.
    #[error("{name} = {value}; allowed: {allowed}")]
    BadParameter {
        /// Which.
        name: &'static str,
        /// What was found.
        value: f64,
        /// What is allowed.
        allowed: &'static str,
    },
    /// A position or velocity is no finite number, or too large to be squared.
    #[error(
        "simulator {simulator} has position {position:?} and velocity {velocity:?}; allowed are finite numbers up to 1e150"
    )]
    BadNumber {
        /// Index.
        simulator: usize,
        /// Position.
        position: [f64; 2],
        /// Velocity.
        velocity: [f64; 2],
    },
}

/// One simulator: 32 bytes, and its index where disks are unlike.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
struct Simulator<T> {
    position: Vector2<f64>,
    velocity: Vector2<f64>,
    tag: T,
}

/// Everything needed to continue a run to the same bytes.
#[derive(Debug, Serialize, Deserialize)]
#[serde(bound = "")]
pub struct Checkpoint<P: Physics<Space = Plane>> {
    time: f64,
    simulators: Vec<Simulator<TagOf<P>>>,
    displacements: Vec<Vector2<f64>>,
    remainders: Vec<f64>,
    fastest: f64,
    temperature: f64,
    tally: Tally,
}

fn check_numbers<T>(simulators: &[Simulator<T>]) -> Result<(), EngineError> {
    for (index, simulator) in simulators.iter().enumerate() {
        let Simulator {
            position, velocity, ..
        } = simulator;
        if !position
            .iter()
            .chain(velocity.iter())
            .all(|x| x.abs() <= 1e150)
        {
            return Err(EngineError::BadNumber {
                simulator: index,
                position: (*position).into(),
                velocity: (*velocity).into(),
            });
        }
    }
    Ok(())
}

type TagOf<P> = <<P as Physics>::Sizes as Sizes>::Tag;

/// Direct Simulation Monte Carlo of smooth disks in a periodic box.
pub struct Engine<P: Physics<Space = Plane>> {
    /// The scene, with the sizes of all simulators.
    scene: P,
    parameters: Parameters,
    streams: Streams,
    domain: Domain<Plane>,
    /// Number and sides of the cells.
    counts: [usize; 2],
    width: Vector2<f64>,
    /// Disks per simulator.
    weight: f64,
    /// Mean free path of the mean density \[length\], for the step.
    mean_free_path: f64,
    moment_ratio: f64,
    density: Density,
    /// In cell order after the sort.
    simulators: Vec<Simulator<TagOf<P>>>,
    sorted: Vec<Simulator<TagOf<P>>>,
    /// How far each simulator has come, in the order of the simulators; empty unless asked for.
    displacements: Vec<Vector2<f64>>,
    /// Cell of each simulator, and where each cell's simulators begin.
    places: Vec<u32>,
    starts: Vec<u32>,
    remainders: Vec<f64>,
    time: f64,
    fastest: f64,
    temperature: f64,
    tally: Tally,
}

impl<P> Engine<P>
where
    P: Physics<Space = Plane, Surface = Smooth, Field = Free>,
{
    /// Starts from a state of disks.
    ///
    /// With several simulators per disk, the first set has the state's own positions and velocities;
    /// each further set is the whole state moved by a random vector with all velocities turned by a
    /// random angle. This keeps energy and vanishing momentum, and is the same gas only where the state is
    /// homogeneous and isotropic: a density or flow pattern of the start is blurred.
    ///
    /// # Errors
    /// [`EngineError`] if a parameter or a number of the state has no meaning.
    pub fn new(
        scene: &P,
        parameters: Parameters,
        state: &State<P>,
        streams: Streams,
    ) -> Result<Self, EngineError> {
        let copies = parameters.simulators_per_disk as usize;
        let scene = scene.with_sizes(scene.sizes().repeated(copies));
        let lengths = state.domain.lengths();
        let mut simulators = Vec::with_capacity(state.bodies.len() * copies);
        for copy in 0..copies {
            let mut stream = streams.at(Purpose::Simulators, [copy as u64, 0]);
            let mut number = |scale: f64| {
                if copy == 0 {
                    0.0
                } else {
                    scale * stream.random::<f64>()
                }
            };
            let shift = vector![number(lengths[0]), number(lengths[1])];
            let (sine, cosine) = number(TAU).sin_cos();
            for (index, body) in state.bodies.iter().enumerate() {
                let v = body.velocity;
                simulators.push(Simulator {
                    position: state.domain.wrap(body.position + shift),
                    velocity: vector![cosine * v[0] - sine * v[1], sine * v[0] + cosine * v[1]],
                    tag: scene.sizes().tag(copy * state.bodies.len() + index),
                });
            }
        }
        let checkpoint = Checkpoint {
            time: state.time,
            simulators,
            displacements: Vec::new(),
            remainders: Vec::new(),
            fastest: 0.0,
            temperature: 0.0,
            tally: Tally::default(),
        };
        let mut engine = Self::assemble(scene, parameters, state.domain, checkpoint, streams)?;
        let mut stream = streams.at(Purpose::Remainders, [0, 0]);
        engine.remainders = (0..engine.counts[0] * engine.counts[1])
            .map(|_| stream.random())
            .collect();
        engine.take_stock();
        Ok(engine)
    }

    /// Goes on from a checkpoint of a run that was started with the same arguments.
    ///
    /// # Errors
    /// As [`Engine::new`].
    pub fn resume(
        scene: &P,
        parameters: Parameters,
        domain: Domain<Plane>,
        checkpoint: Checkpoint<P>,
        streams: Streams,
    ) -> Result<Self, EngineError> {
        let scene = scene.with_sizes(
            scene
                .sizes()
                .repeated(parameters.simulators_per_disk as usize),
        );
        Self::assemble(scene, parameters, domain, checkpoint, streams)
    }

    fn assemble(
        scene: P,
        parameters: Parameters,
        domain: Domain<Plane>,
        checkpoint: Checkpoint<P>,
        streams: Streams,
    ) -> Result<Self, EngineError> {
        let Checkpoint {
            time,
            simulators,
            displacements,
            remainders,
            fastest,
            temperature,
            tally,
        } = checkpoint;
        parameters.check()?;
        check_numbers(&simulators)?;
        let copies = f64::from(parameters.simulators_per_disk);
        let limit = parameters.largest_contact_value;
        let weight = 1.0 / copies;
        let sizes = scene.sizes();
        let [mut first, mut second] = [0.0; 2];
        // In the order of the sizes, which unlike that of the simulators is the same after a restart.
        for index in 0..simulators.len() {
            let diameter = 2.0 * sizes.radius(sizes.tag(index));
            first += diameter;
            second += diameter * diameter;
        }
        let packing = weight * PI / 4.0 * second / domain.volume();
        let (mean_diameter, moment_ratio) = if second > 0.0 {
            (first / simulators.len() as f64, first / second)
        } else {
            (2.0 * sizes.largest_radius(), 1.0)
        };
        let mean_free_path = parameters.mean_free_path(packing, mean_diameter);
        let counts = parameters.cells(&domain, packing, mean_diameter);
        let lengths = domain.lengths();
        let width = vector![lengths[0] / counts[0] as f64, lengths[1] / counts[1] as f64];
        let unit_diameter = 2.0 * sizes.largest_radius();
        let density = Density::new(
            parameters.scheme,
            limit,
            counts,
            width[0] * width[1],
            unit_diameter,
            weight,
            packing,
        );
        Ok(Self {
            sorted: simulators.clone(),
            places: vec![0; simulators.len()],
            starts: vec![0; counts[0] * counts[1] + 1],
            scene,
            parameters,
            streams,
            domain,
            counts,
            width,
            weight,
            mean_free_path,
            moment_ratio,
            density,
            simulators,
            displacements,
            remainders,
            time,
            fastest,
            temperature,
            tally,
        })
    }

    /// Advances by whole steps to the time `until` (the last step is shortened to end there exactly), or
    /// for `most_steps`. True if the time was reached.
    pub fn advance(&mut self, until: f64, most_steps: u64, watch: &mut impl Observe<P>) -> bool {
        for _ in 0..most_steps {
            let left = until - self.time;
            if left <= 0.0 {
                return true;
            }
            let step = self.step_length();
            // Equal last steps instead of a long and a tiny one.
            let steps = (left / step).ceil();
            let (step, last) = if steps <= 1.0 {
                (left, true)
            } else {
                (left / steps, false)
            };
            self.step(step, watch);
            self.time = if last { until } else { self.time + step };
        }
        until <= self.time
    }

    /// The gas at the present time: one body for each simulator, in the order of the sizes of
    /// [`Engine::scene`].
    pub fn state(&self) -> State<P> {
        let mut bodies = vec![Body::new(Vector2::zeros(), Vector2::zeros()); self.simulators.len()];
        for (order, simulator) in self.simulators.iter().enumerate() {
            bodies[P::Sizes::index(simulator.tag, order)] =
                Body::new(self.domain.wrap(simulator.position), simulator.velocity);
        }
        State {
            time: self.time,
            domain: self.domain,
            bodies,
        }
    }

    /// The scene with the sizes of all simulators.
    pub fn scene(&self) -> &P {
        &self.scene
    }

    /// Measures displacements from now on. They cost one vector a simulator and two passes over them a step.
    pub fn follow_displacements(&mut self) {
        self.displacements = vec![Vector2::zeros(); self.simulators.len()];
    }

    /// How far simulators have come since [`Self::follow_displacements`], across the edges of the box \[length\]; in no
    /// order that stays, and empty unless they are followed. The displacement of partners in the scheme counts.
    pub fn displacements(&self) -> &[Vector2<f64>] {
        &self.displacements
    }

    /// Adds to the velocity of each simulator, in the order of [`Engine::state`]; further simulators stay as they
    /// are.
    pub fn kick(&mut self, changes: &[Vector2<f64>]) {
        for (order, simulator) in self.simulators.iter_mut().enumerate() {
            if let Some(change) = changes.get(P::Sizes::index(simulator.tag, order)) {
                simulator.velocity += change;
            }
        }
        self.take_stock();
    }

    /// Everything needed to go on from here.
    pub fn checkpoint(&self) -> Checkpoint<P> {
        Checkpoint {
            time: self.time,
            simulators: self.simulators.clone(),
            displacements: self.displacements.clone(),
            remainders: self.remainders.clone(),
            fastest: self.fastest,
            temperature: self.temperature,
            tally: self.tally,
        }
    }

    /// What was done so far.
    pub fn tally(&self) -> Tally {
        self.tally
    }

    /// The present time.
    pub fn time(&self) -> f64 {
        self.time
    }

    /// Number of simulators.
    pub fn simulators(&self) -> usize {
        self.simulators.len()
    }

    /// Disks per simulator.
    pub fn weight(&self) -> f64 {
        self.weight
    }

    /// Sides of a cell \[length\].
    pub fn cell(&self) -> [f64; 2] {
        self.width.into()
    }

    fn step_length(&self) -> f64 {
        let crossing = self.width.min() / self.fastest;
        // Mean speed sqrt(pi T/(2m)); the mean mass is one in the program's units.
        let free = self.mean_free_path / (PI / 2.0 * self.temperature).sqrt();
        let step = crossing.min(free) / self.parameters.steps_per_crossing;
        if step.is_finite() { step } else { f64::MAX }
    }

    /// Largest speed and temperature, for the length of the next step.
    fn take_stock(&mut self) {
        let sizes = self.scene.sizes();
        let (mut fastest, mut twice_energy) = (0.0_f64, 0.0);
        for simulator in &self.simulators {
            let square = simulator.velocity.norm_squared();
            fastest = fastest.max(square);
            twice_energy += sizes.mass(simulator.tag) * square;
        }
        self.fastest = fastest.sqrt();
        self.temperature = twice_energy / (2.0 * self.simulators.len().max(1) as f64);
    }

    fn step(&mut self, step: f64, watch: &mut impl Observe<P>) {
        self.fly_and_sort(0.5 * step);
        let sizes = self.scene.sizes();
        let unit = sizes.largest_radius().powi(-2);
        let (starts, simulators) = (&self.starts, &self.simulators);
        self.density.update(starts.windows(2).map(|ends| {
            if P::Sizes::UNIFORM {
                f64::from(ends[1] - ends[0])
            } else {
                simulators[ends[0] as usize..ends[1] as usize]
                    .iter()
                    .map(|simulator| sizes.radius(simulator.tag).powi(2) * unit)
                    .sum()
            }
        }));
        for cell in 0..self.starts.len() - 1 {
            if self.starts[cell + 1] - self.starts[cell] >= 2 {
                self.collide_cell(cell, step, watch);
            }
        }
        self.note_flight(0.5 * step);
        let field = self.scene.field();
        for simulator in &mut self.simulators {
            Field::<Plane>::drift(
                field,
                &mut simulator.position,
                &mut simulator.velocity,
                0.5 * step,
            );
        }
        self.take_stock();
        self.tally.steps += 1;
    }

    /// Half a free flight, then a counting sort by cell, which keeps the order within a cell.
    fn fly_and_sort(&mut self, duration: f64) {
        self.note_flight(duration);
        let field = self.scene.field();
        let scale = vector![1.0 / self.width[0], 1.0 / self.width[1]];
        self.starts.fill(0);
        for (simulator, place) in self.simulators.iter_mut().zip(&mut self.places) {
            Field::<Plane>::drift(
                field,
                &mut simulator.position,
                &mut simulator.velocity,
                duration,
            );
            simulator.position = self.domain.wrap(simulator.position);
            let column = ((simulator.position[0] * scale[0]) as usize).min(self.counts[0] - 1);
            let row = ((simulator.position[1] * scale[1]) as usize).min(self.counts[1] - 1);
            let cell = row * self.counts[0] + column;
            *place = cell as u32;
            self.starts[cell + 1] += 1;
        }
        let mut total = 0;
        for start in &mut self.starts {
            total += *start;
            *start = total;
        }
        // `starts[c]` is now where cell c begins; filling moves it to where c ends, which is where
        // c + 1 began: shifted back by one afterwards.
        for (simulator, &place) in self.simulators.iter().zip(&self.places) {
            let slot = &mut self.starts[place as usize];
            self.sorted[*slot as usize] = *simulator;
            *slot += 1;
        }
        self.starts.rotate_right(1);
        self.starts[0] = 0;
        std::mem::swap(&mut self.simulators, &mut self.sorted);
        self.sort_displacements();
    }

    /// Adds a free flight to the displacements that are followed.
    fn note_flight(&mut self, duration: f64) {
        for (displacement, simulator) in self.displacements.iter_mut().zip(&self.simulators) {
            *displacement += simulator.velocity * duration;
        }
    }

    /// Brings the displacements into the order of the simulators just sorted.
    fn sort_displacements(&mut self) {
        if self.displacements.is_empty() {
            return;
        }
        let mut next = self.starts.clone();
        let mut sorted = vec![Vector2::zeros(); self.displacements.len()];
        for (&displacement, &place) in self.displacements.iter().zip(&self.places) {
            let slot = &mut next[place as usize];
            sorted[*slot as usize] = displacement;
            *slot += 1;
        }
        self.displacements = sorted;
    }

    fn collide_cell(&mut self, cell: usize, step: f64, watch: &mut impl Observe<P>) {
        let place = self.starts[cell] as usize..self.starts[cell + 1] as usize;
        // Nothing to slice unless displacements are followed.
        let followed = self.displacements.get_mut(place.clone());
        let followed = followed.unwrap_or_default();
        let members = &mut self.simulators[place];
        let count = members.len();
        let sizes = self.scene.sizes();
        let (chi, limited) = self.density.contact_value(cell);
        self.tally.active_cells += 1;
        self.tally.limited_cells += u64::from(limited);
        let mut majorant = largest_relative_speed(members);
        if majorant == 0.0 {
            return;
        }
        let largest = 2.0 * sizes.largest_radius();
        let packing = if P::Sizes::UNIFORM {
            0.0
        } else {
            self.density.packing(cell).min(0.9)
        };
        // chi and contact distance of a pair over those of the largest disks at chi.
        let pair_factor = |diameters: [f64; 2]| {
            let distance = 0.5 * (diameters[0] + diameters[1]);
            distance * kinetic::mixture_contact_value(chi, packing, diameters, self.moment_ratio)
        };
        let ceiling = if P::Sizes::UNIFORM {
            largest * chi
        } else {
            pair_factor([largest; 2]).max(largest * chi)
        };
        let pairs = 0.5 * count as f64 * (count - 1) as f64;
        let area = self.width[0] * self.width[1];
        let trials =
            pairs * 2.0 * ceiling * self.weight * majorant * step / area + self.remainders[cell];
        self.remainders[cell] = trials.fract();
        let trials = trials as u64;
        if trials == 0 {
            return;
        }
        let mut stream = self
            .streams
            .at(Purpose::Collisions, [self.tally.steps, cell as u64]);
        let mut collisions = 0;
        for _ in 0..trials {
            let [i, j] = draw_pair(count, &mut stream);
            let relative = members[i].velocity - members[j].velocity;
            let square = relative.norm_squared();
            let mut threshold = majorant * stream.random::<f64>();
            if square > majorant * majorant {
                self.tally.majorant_violations += 1;
                majorant = square.sqrt();
            }
            let radii = [i, j].map(|who| sizes.radius(members[who].tag));
            if !P::Sizes::UNIFORM {
                threshold *= ceiling / pair_factor(radii.map(|radius| 2.0 * radius));
            }
            if square <= threshold * threshold {
                continue;
            }
            collisions += 1;
            let distance = radii[0] + radii[1];
            let speed = square.sqrt();
            let (normal, along) = draw_normal(relative / speed, &mut stream);
            let line = normal * distance;
            let masses = [i, j].map(|who| sizes.mass(members[who].tag));
            let velocities = [members[i].velocity, members[j].velocity];
            let restitution = self.scene.restitution().normal(-along * speed);
            let pair = Encounter {
                velocities,
                masses,
                line,
            };
            let [u, v] = collide(&self.scene, &pair, restitution);
            members[i].velocity = u;
            members[j].velocity = v;
            let [first, second] = [members[i].position, members[j].position];
            let separation = self.domain.displacement(first, second);
            self.tally.separation += separation.norm();
            self.tally.virial += masses[0] * separation.dot(&(u - velocities[0]));
            if self.parameters.displacement {
                self.tally.virial += line.dot(&(u * masses[0] - v * masses[1]));
                displace(members, followed, [i, j], line);
            }
            watch.collision(&Collision {
                time: self.time + 0.5 * step,
                relative,
                line,
                reduced_mass: masses[0] * masses[1] / (masses[0] + masses[1]),
                restitution,
                weight: self.weight,
            });
        }
        self.tally.trials += trials;
        self.tally.collisions += collisions;
        if limited {
            self.tally.limited_collisions += collisions;
        }
        self.tally.busiest_cell = self
            .tally
            .busiest_cell
            .max(2.0 * collisions as f64 / count as f64);
    }
}

/// Moves two partners apart by the vector `line` each, and notes it where displacements are followed.
#[inline]
fn displace<T>(
    members: &mut [Simulator<T>],
    followed: &mut [Vector2<f64>],
    [i, j]: [usize; 2],
    line: Vector2<f64>,
) {
    members[i].position += line;
    members[j].position -= line;
    if !followed.is_empty() {
        followed[i] += line;
        followed[j] -= line;
    }
}

/// The sum of the two largest speeds relative to the mean velocity: no pair is faster.
#[inline]
fn largest_relative_speed<T>(members: &[Simulator<T>]) -> f64 {
    let sum = members
        .iter()
        .fold(Vector2::zeros(), |sum, member| sum + member.velocity);
    let mean = sum / members.len() as f64;
    let [mut first, mut second] = [0.0_f64; 2];
    for member in members {
        let square = (member.velocity - mean).norm_squared();
        second = second.max(square.min(first));
        first = first.max(square);
    }
    // Room for the rounding of the mean.
    (first.sqrt() + second.sqrt()) * (1.0 + 1e-12)
}

/// A unit vector along the line of centres for an approach in the direction `direction`, with b/d uniform
/// on [-1, 1], from the second partner to the first; and its component along the approach, never positive.
#[inline]
fn draw_normal(direction: Vector2<f64>, stream: &mut impl Rng) -> (Vector2<f64>, f64) {
    let impact = 2.0 * stream.random::<f64>() - 1.0;
    let along = -(1.0 - impact * impact).sqrt();
    (
        direction * along + vector![-direction[1], direction[0]] * impact,
        along,
    )
}

/// Two different numbers below `count`, each pair equally likely.
#[inline]
fn draw_pair(count: usize, stream: &mut impl Rng) -> [usize; 2] {
    let i = stream.random_range(0..count);
    let j = stream.random_range(0..count - 1);
    [i, if j >= i { j + 1 } else { j }]
}
