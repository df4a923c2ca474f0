//! A start and what must hold of every run from it.

use nalgebra::Vector2;
use rand::RngExt;
use stosszahl_ed::{Checkpoint, Dissipation, Engine, EngineError, plain, time_to_contact};
use stosszahl_model::initial;
use stosszahl_model::random::Stream;
use stosszahl_model::{Collision, Observe, Sizes, State};

use super::{Findings, Trouble};
use crate::dispatch::Planar;

/// Largest relative error of the energy: 1e5 roundings of 1e-16, all to one side. Drifts that are random walks stay far
/// below.
pub(super) const ENERGY: f64 = 1e-11;
/// Deepest overlap over the largest diameter: positions and flights of tens of diameters are rounded to 1e-14, with room
/// for a contact that a fast disk makes late.
pub(super) const OVERLAP: f64 = 1e-11;
/// Largest error of the momentum over the sum of m |v| at the start; as [`ENERGY`].
pub(super) const MOMENTUM: f64 = 1e-11;

/// Largest speed at which a colliding pair may recede, over its whole relative speed: a contact that grazes is where the
/// square root of a difference of terms of 1e-14 says.
const RECEDING: f64 = 1e-6;
/// Relative speed that is nothing but the rounding of velocities of order one, over [`RECEDING`].
const RESTING: f64 = 1e-8;

/// What is summed over the collisions of a run.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Ledger {
    /// Energy lost.
    pub lost: f64,
    /// Momentum times distance.
    pub virial: f64,
    /// How many.
    pub collisions: u64,
    /// Time of the first.
    pub first: Option<f64>,
    /// Time of the last.
    pub last: f64,
    /// Whether one was earlier than the one before.
    pub disordered: bool,
    /// Largest speed at which a colliding pair receded, over its whole relative speed.
    pub receding: f64,
}

impl<P: Planar> Observe<P> for Ledger {
    fn collision(&mut self, collision: &Collision<Vector2<f64>>) {
        self.lost += collision.energy_lost();
        self.virial += collision.virial();
        self.collisions += 1;
        let (relative, line) = (&collision.relative, &collision.line);
        let receding = relative.dot(line) / ((relative.norm() + RESTING) * line.norm());
        self.receding = self.receding.max(receding);
        self.disordered |= collision.time < self.last;
        self.last = collision.time;
        self.first.get_or_insert(collision.time);
    }
}

/// A start.
#[derive(Clone, Debug)]
pub(super) struct Gas<P: Planar> {
    pub scene: P,
    pub dissipation: Dissipation,
    pub start: State<P>,
}

/// A run from it.
pub(super) struct Course<P: Planar> {
    pub end: Checkpoint<P>,
    pub ledger: Ledger,
    /// Deepest overlap at the end of any leg.
    pub overlap: f64,
    /// Whether the time was reached.
    pub reached: bool,
    pub stopped: Option<EngineError>,
}

impl<P: Planar> Gas<P> {
    /// The gas whose collisions follow the scene.
    pub fn new(scene: P, start: State<P>) -> Self {
        Self {
            scene,
            dissipation: Dissipation::Scene,
            start,
        }
    }

    /// The same with a contact time.
    pub fn with_contact_time(mut self, contact_time: f64) -> Self {
        self.dissipation = Dissipation::ContactTime(contact_time);
        self
    }

    pub fn engine(&self, from: Checkpoint<P>) -> Result<Engine<P>, EngineError> {
        Engine::new(self.scene.clone(), self.dissipation, from)
    }

    pub fn diameter(&self) -> f64 {
        2.0 * self.scene.sizes().largest_radius()
    }

    /// Runs in legs of so many collisions until a time or a number of collisions.
    pub fn run(
        &self,
        until: f64,
        collisions: u64,
        leg: u64,
        mut after_leg: impl FnMut(&Checkpoint<P>, &Ledger),
    ) -> Result<Course<P>, EngineError> {
        let mut course = Course {
            end: self.start.clone().into(),
            ledger: Ledger::default(),
            overlap: 0.0,
            reached: false,
            stopped: None,
        };
        while course.ledger.collisions < collisions && !course.reached && course.stopped.is_none() {
            let mut engine = self.engine(course.end)?;
            let most = leg.min(collisions - course.ledger.collisions);
            let before = course.ledger.collisions;
            match engine.advance(until, most, &mut course.ledger) {
                Ok(reached) => {
                    let silent = course.ledger.collisions == before;
                    course.reached = reached && (until.is_finite() || silent);
                }
                Err(error) => course.stopped = Some(error),
            }
            course.overlap = course.overlap.max(engine.worst_overlap());
            course.end = engine.checkpoint();
            after_leg(&course.end, &course.ledger);
        }
        Ok(course)
    }

    /// What must hold of every run: finite numbers, collisions in order of time, exclusion, energy and momentum.
    pub fn audit(&self, findings: &mut Findings, what: &str, course: &Course<P>) {
        let end = &course.end.state;
        let mut numbers = end
            .bodies
            .iter()
            .flat_map(|b| b.position.iter().chain(b.velocity.iter()));
        let finite = numbers.all(|x| x.is_finite()) && end.time.is_finite();
        findings.require(finite, || format!("{what}: a number that is not finite"));
        if !finite {
            return;
        }
        findings.require(!course.ledger.disordered, || {
            format!("{what}: collisions out of order")
        });
        findings.at_most(
            &format!("{what}: receding pair"),
            course.ledger.receding,
            RECEDING,
        );
        findings.at_most(
            &format!("{what}: overlap over d"),
            course.overlap / self.diameter(),
            OVERLAP,
        );
        // By other means than the engine's.
        if let Some(overlap) = self.overlap(end, OVERLAP * self.diameter()) {
            findings.fault(format!(
                "{what}: disks {} and {} overlap by {:.3e}",
                overlap.pair[0], overlap.pair[1], overlap.depth
            ));
        }
        findings.at_most(
            &format!("{what}: energy"),
            self.energy_error(course),
            ENERGY,
        );
        findings.at_most(
            &format!("{what}: momentum"),
            self.momentum_error(end),
            MOMENTUM,
        );
    }

    /// The first pair that overlaps by more than a tolerance.
    pub fn overlap(&self, state: &State<P>, tolerance: f64) -> Option<initial::Overlap> {
        let positions: Vec<_> = state.bodies.iter().map(|body| body.position).collect();
        let sizes = self.scene.sizes();
        initial::first_overlap(
            &positions,
            |index| sizes.radius(sizes.tag(index)),
            &state.domain,
            tolerance,
        )
    }

    /// |K + what the collisions lost - K(0)| / K(0).
    pub fn energy_error(&self, course: &Course<P>) -> f64 {
        let energy = self.start.kinetic_energy(&self.scene);
        let now = course.end.state.kinetic_energy(&self.scene) + course.ledger.lost;
        if energy > 0.0 {
            (now / energy - 1.0).abs()
        } else {
            now.abs()
        }
    }

    /// |P - P(0)| / sum of m |v| at the start.
    pub fn momentum_error(&self, state: &State<P>) -> f64 {
        let sizes = self.scene.sizes();
        let scale: f64 = self
            .start
            .bodies
            .iter()
            .enumerate()
            .map(|(index, body)| sizes.mass(sizes.tag(index)) * body.velocity.norm())
            .sum();
        let change = (state.momentum(&self.scene) - self.start.momentum(&self.scene)).norm();
        if scale > 0.0 { change / scale } else { change }
    }

    /// Runs, audits and says what was found; then the same under kills.
    pub fn holds(
        &self,
        findings: &mut Findings,
        what: &str,
        collisions: u64,
    ) -> Result<Course<P>, Trouble> {
        let course = self.run(
            f64::INFINITY,
            collisions,
            collisions.div_ceil(4).max(1),
            |_, _| (),
        )?;
        if let Some(error) = &course.stopped {
            findings.fault(format!("{what}: {error}"));
        }
        self.audit(findings, what, &course);
        findings.found(format!(
            "{what}: {} collisions, energy {:.1e}, overlap {:.1e} d",
            course.ledger.collisions,
            self.energy_error(&course),
            course.overlap / self.diameter()
        ));
        self.survives_kills(findings, what, collisions.min(4000), 1)?;
        Ok(course)
    }

    /// Cuts the run into legs of random length. One gas goes on in memory; the other is killed within each leg, so
    /// that what it did there is lost, and continues from the bytes of its last checkpoint. Both must end in the same
    /// bytes, or in the same error.
    pub fn survives_kills(
        &self,
        findings: &mut Findings,
        what: &str,
        collisions: u64,
        seed: u64,
    ) -> Result<(), Trouble> {
        const LEGS: u64 = 4;
        let mut stream = random(seed);
        let mut in_memory = Checkpoint::from(self.start.clone());
        let mut bytes = postcard::to_stdvec(&in_memory)?;
        // A box in which nothing collides ends its legs by time instead.
        let horizon = self.horizon();
        for leg in 0..LEGS {
            let most = stream.random_range(1..=(2 * collisions / LEGS).max(1));
            let until = in_memory.state.time + horizon;
            let mut engine = self.engine(in_memory)?;
            let ended = engine.advance(until, most, &mut ());
            in_memory = engine.checkpoint();

            let mut killed = self.engine(postcard::from_bytes(&bytes)?)?;
            // What happens before a kill is of no consequence.
            let _ = killed.advance(until, stream.random_range(0..=most), &mut ());
            let _ = killed.checkpoint();
            let mut resumed = self.engine(postcard::from_bytes(&bytes)?)?;
            let again = resumed.advance(until, most, &mut ());
            bytes = postcard::to_stdvec(&resumed.checkpoint())?;
            findings.require(ended == again, || {
                format!("{what}: leg {leg} ended otherwise after a kill: {ended:?}, {again:?}")
            });
            let same = postcard::to_stdvec(&in_memory)? == bytes;
            findings.require(same, || {
                format!("{what}: leg {leg} has other bytes after a kill")
            });
            if ended.is_err() || !same {
                break;
            }
        }
        Ok(())
    }

    /// A time in which the fastest disk flies a thousand diameters.
    fn horizon(&self) -> f64 {
        let fastest = self
            .start
            .bodies
            .iter()
            .map(|b| b.velocity.norm())
            .fold(0.0, f64::max);
        let time = 1e3 * self.diameter() / fastest;
        if time.is_finite() { time } else { 1.0 }
    }

    /// The first collisions against those of all pairs: same pairs in the same order, times within a tolerance of the
    /// last one's.
    pub fn follows_all_pairs(
        &self,
        findings: &mut Findings,
        what: &str,
        collisions: usize,
        tolerance: f64,
    ) -> Result<usize, Trouble> {
        let mut slow_state = self.start.clone();
        let slow = plain::run(&self.scene, &mut slow_state, collisions);
        let fast = self.pairs(slow.len())?;
        findings.require(fast.len() == slow.len(), || {
            format!("{what}: {} collisions of {}", fast.len(), slow.len())
        });
        let scale = slow
            .last()
            .map_or(0.0, |event| event.time - self.start.time);
        for (number, (ours, theirs)) in fast.iter().zip(&slow).enumerate() {
            let good = ours.1 == theirs.pair && (ours.0 - theirs.time).abs() <= tolerance * scale;
            findings.require(good, || {
                format!("{what}: collision {number} is {ours:?}, of all pairs {theirs:?}")
            });
            if !good {
                break;
            }
        }
        Ok(slow.len())
    }

    /// Each of the next collisions is the one that all pairs find from the state before it, to a tolerance of the time.
    /// States are compared anew each time, so that differences do not grow.
    pub fn collides_as_all_pairs(
        &self,
        findings: &mut Findings,
        what: &str,
        collisions: usize,
        tolerance: f64,
    ) -> Result<usize, Trouble> {
        let mut engine = self.engine(self.start.clone().into())?;
        for number in 0..collisions {
            let before = engine.state();
            let expected = next_of_all_pairs(&self.scene, &before);
            let mut ledger = Ledger::default();
            engine.advance(f64::INFINITY, 1, &mut ledger)?;
            let pair = changed(&before, &engine.state());
            let good = expected.is_some_and(|(time, expected)| {
                expected == pair
                    && ledger
                        .first
                        .is_some_and(|first| (first - time).abs() <= tolerance)
            });
            findings.require(good, || {
                format!(
                    "{what}: collision {number} is {:?} of {pair:?}, of all pairs {expected:?}",
                    ledger.first
                )
            });
            if !good {
                return Ok(number);
            }
        }
        Ok(collisions)
    }

    /// Time and pair of the next collisions: the disks whose velocities changed.
    pub fn pairs(&self, collisions: usize) -> Result<Vec<(f64, [usize; 2])>, EngineError> {
        let mut engine = self.engine(self.start.clone().into())?;
        let mut before = self.start.clone();
        let mut list = Vec::with_capacity(collisions);
        for _ in 0..collisions {
            let mut ledger = Ledger::default();
            engine.advance(f64::INFINITY, 1, &mut ledger)?;
            let Some(time) = ledger.first else { break };
            let after = engine.state();
            let pair = changed(&before, &after);
            list.push((time, pair));
            before = after;
        }
        Ok(list)
    }
}

/// The pair whose velocities differ between two states.
fn changed<P: Planar>(before: &State<P>, after: &State<P>) -> [usize; 2] {
    let mut who =
        (0..before.bodies.len()).filter(|&i| before.bodies[i].velocity != after.bodies[i].velocity);
    let first = who.next().unwrap_or(usize::MAX);
    [first, who.next_back().unwrap_or(usize::MAX)]
}

/// The next collision of all pairs over as many images as a flight can reach: (time, pair). `plain::run` sees a fixed
/// number of images, too few where a box is narrow and flights are long.
fn next_of_all_pairs<P: Planar>(scene: &P, state: &State<P>) -> Option<(f64, [usize; 2])> {
    let (sizes, lengths) = (scene.sizes(), state.domain.lengths());
    let fastest = state
        .bodies
        .iter()
        .map(|b| b.velocity.norm())
        .fold(0.0, f64::max);
    let mut horizon = lengths.max() / fastest;
    // Twice as far each time, to a thousand boxes.
    for _ in 0..10 {
        let mut next: Option<(f64, [usize; 2])> = None;
        for (i, one) in state.bodies.iter().enumerate() {
            for (j, other) in state.bodies.iter().enumerate().skip(i + 1) {
                let distance = sizes.radius(sizes.tag(i)) + sizes.radius(sizes.tag(j));
                let separation = state.domain.displacement(one.position, other.position);
                let relative = one.velocity - other.velocity;
                let limit = next.map_or(horizon, |known| known.0);
                let reach = |axis: usize| {
                    1 + ((relative[axis].abs() * limit + distance) / lengths[axis]).ceil() as i32
                };
                // Only images on the side from which they come.
                let range = |axis: usize| {
                    if relative[axis] > 0.0 {
                        -reach(axis)..=1
                    } else {
                        -1..=reach(axis)
                    }
                };
                for column in range(0) {
                    for row in range(1) {
                        let image = Vector2::new(
                            f64::from(column) * lengths[0],
                            f64::from(row) * lengths[1],
                        );
                        let limit = next.map_or(horizon, |known| known.0);
                        let contact = time_to_contact(
                            separation + image,
                            relative,
                            distance * distance,
                            limit,
                        );
                        if let Some(time) = contact {
                            next = Some((time, [i, j]));
                        }
                    }
                }
            }
        }
        if let Some((wait, pair)) = next {
            return Some((state.time + wait, pair));
        }
        horizon *= 2.0;
    }
    None
}

/// The random numbers of a case.
pub(super) fn random(seed: u64) -> Stream {
    use stosszahl_model::random::{Purpose, Streams};
    Streams::new(seed, 0).at(Purpose::Placement, [0, 0])
}
