//! Gases of exact disks for hard cases, and the checks that every run of them undergoes.

use nalgebra::Vector2;
use rand::RngExt;
use stosszahl_ed::{
    DissipationRule, EventDrivenCheckpoint, EventDrivenEngine, EventDrivenError, plain,
    time_to_contact,
};
use stosszahl_model::samples::{EqualDisks, state};
use stosszahl_model::{
    Collision, Free, Observer, ParticleModel, Plane, Sizes, Smooth, State, initial,
};

use crate::gas::{disks, disordered as fluid, domain, random};
use crate::{Done, TrialError, TrialLog};

/// Particle model of all hard cases of exact disks: smooth disks in free flight.
pub(super) trait Planar:
    ParticleModel<Space = Plane, Surface = Smooth, Field = Free>
{
}

impl<P: ParticleModel<Space = Plane, Surface = Smooth, Field = Free>> Planar for P {}

/// Largest relative error of the energy of exact disks: 1e5 roundings of 1e-16, all of one sign.
/// Random-walk drifts stay far below.
pub(super) const ENERGY: f64 = 1e-11;
/// Deepest allowed overlap of exact disks over the largest diameter. Positions and flights of tens
/// of diameters are rounded to 1e-14, with room for a contact that a fast disk makes late.
pub(super) const OVERLAP: f64 = 1e-11;
/// Largest error of the total momentum of exact disks over the sum of m |v| at the start. The bound
/// has the origin of [`ENERGY`].
pub(super) const MOMENTUM: f64 = 1e-11;

/// Largest receding speed of a colliding pair, over its whole relative speed. The position of a
/// grazing contact is the square root of a difference of terms of 1e-14.
const RECEDING: f64 = 1e-6;
/// Relative speed added to the divisor of the receding-speed check, so that rounding of velocities
/// of order one cannot fail it \[length/time\].
const RESTING: f64 = 1e-8;

/// Observer that sums energy loss, virial and times over the collisions of a run of exact disks.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct CollisionSums {
    /// Energy lost in all collisions of the run \[energy\].
    pub lost: f64,
    /// Virial of all collisions of the run: the sum of transferred momentum times distance
    /// \[energy\].
    pub virial: f64,
    /// Number of collisions of the run.
    pub collisions: u64,
    /// Time of the first collision of the run \[time\]; `None` without collisions.
    pub first: Option<f64>,
    /// Time of the last collision of the run \[time\].
    pub last: f64,
    /// True if a collision had an earlier time than the previous one, which is a fault.
    pub disordered: bool,
    /// Largest receding speed of a colliding pair, over its whole relative speed. Above rounding it
    /// is a fault.
    pub receding: f64,
}

impl Observer for CollisionSums {
    fn on_collisions(&mut self, batch: &[Collision]) {
        for collision in batch {
            self.lost += collision.energy_lost();
            self.virial += collision.virial();
            self.collisions += 1;
            let (relative, line) = (&collision.relative_velocity, &collision.line);
            let receding = relative.dot(line) / ((relative.norm() + RESTING) * line.norm());
            self.receding = self.receding.max(receding);
            self.disordered |= collision.time < self.last;
            self.last = collision.time;
            self.first.get_or_insert(collision.time);
        }
    }
}

/// Gas of exact disks for a hard case: particle model, dissipation rule and initial state.
#[derive(Clone, Debug)]
pub(super) struct StressGas<P: Planar> {
    pub scene: P,
    pub dissipation: DissipationRule,
    pub start: State<P>,
}

/// Way in which a run of exact disks must end to pass.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum RunEnd {
    /// Required end of a run at the given time or after the given number of collisions, without an
    /// error.
    TimeOrCount,
    /// Required end of a run at the given time.
    Time,
    /// Required end of a run at the given time, or by inelastic collapse.
    TimeOrCollapse,
}

/// Finished run of exact disks: final checkpoint, collision sums and the error that ended it, if
/// any.
pub(super) struct StressRun<P: Planar> {
    pub end: EventDrivenCheckpoint<P>,
    pub ledger: CollisionSums,
    /// Deepest overlap at the end of any segment of the run \[length\].
    pub overlap: f64,
    /// True if the run reached its end time.
    pub reached: bool,
    pub stopped: Option<EventDrivenError>,
}

impl<P: Planar> StressRun<P> {
    /// Returns the number of collisions of the run.
    pub fn collisions(&self) -> u64 {
        self.ledger.collisions
    }

    /// Returns true if the run ended in inelastic collapse.
    pub fn collapsed(&self) -> bool {
        matches!(
            self.stopped,
            Some(EventDrivenError::InelasticCollapse { .. })
        )
    }

    /// Describes how the run ended: its number of collisions and its error.
    pub fn ended(&self) -> String {
        format!("{} collisions, {:?}", self.collisions(), self.stopped)
    }
}

/// Creates unit disks at given positions with given velocities in a periodic box.
pub(super) fn few(
    restitution: f64,
    [width, height]: [f64; 2],
    bodies: impl IntoIterator<Item = ([f64; 2], [f64; 2])>,
) -> Result<StressGas<EqualDisks>, TrialError> {
    let bodies = bodies
        .into_iter()
        .map(|(at, velocity)| (at.into(), velocity.into()));
    Ok(StressGas::new(
        disks(restitution)?,
        state(domain(width, height)?, bodies),
    ))
}

/// Creates a gas of randomly placed unit disks with Maxwellian velocities in a periodic square box.
pub(super) fn disordered(
    count: usize,
    packing: f64,
    restitution: f64,
    seed: u64,
) -> Result<StressGas<EqualDisks>, TrialError> {
    Ok(StressGas::new(
        disks(restitution)?,
        fluid(count, packing, seed)?,
    ))
}

impl<P: Planar> StressGas<P> {
    /// Creates a gas of exact disks with the contact law of its particle model, without a contact
    /// time.
    pub fn new(scene: P, start: State<P>) -> Self {
        Self {
            scene,
            dissipation: DissipationRule::Scene,
            start,
        }
    }

    /// Sets the contact time of the TC model, within which repeated collisions are elastic
    /// \[time\].
    pub fn with_contact_time(mut self, contact_time: f64) -> Self {
        self.dissipation = DissipationRule::ContactTime(contact_time);
        self
    }

    pub fn engine(
        &self,
        from: EventDrivenCheckpoint<P>,
    ) -> Result<EventDrivenEngine<P>, EventDrivenError> {
        EventDrivenEngine::new(self.scene.clone(), self.dissipation, from)
    }

    pub fn diameter(&self) -> f64 {
        2.0 * self.scene.sizes().largest_radius()
    }

    /// Runs exact disks from the start until a time or a number of collisions.
    pub fn run_until(&self, until: f64, collisions: u64) -> Result<StressRun<P>, EventDrivenError> {
        self.run_in_legs(until, collisions, collisions, |_, _| true)
    }

    /// Runs exact disks until a time or a number of collisions, in segments of `leg` collisions.
    /// Stops early if `after_leg` returns false.
    pub fn run_in_legs(
        &self,
        until: f64,
        collisions: u64,
        leg: u64,
        mut after_leg: impl FnMut(&EventDrivenCheckpoint<P>, &CollisionSums) -> bool,
    ) -> Result<StressRun<P>, EventDrivenError> {
        let mut course = StressRun {
            end: self.start.clone().into(),
            ledger: CollisionSums::default(),
            overlap: 0.0,
            reached: false,
            stopped: None,
        };
        while course.collisions() < collisions && !course.reached && course.stopped.is_none() {
            let mut engine = self.engine(course.end)?;
            let before = course.ledger.collisions;
            match engine.advance(until, leg.min(collisions - before), &mut course.ledger) {
                Ok(reached) => {
                    let silent = course.ledger.collisions == before;
                    course.reached = reached && (until.is_finite() || silent);
                }
                Err(error) => course.stopped = Some(error),
            }
            course.overlap = course.overlap.max(engine.worst_overlap());
            course.end = engine.checkpoint();
            if !after_leg(&course.end, &course.ledger) {
                break;
            }
        }
        Ok(course)
    }

    /// Checks a finished run of exact disks: finite numbers, collisions in time order, no overlap,
    /// energy and momentum.
    pub fn audit(&self, log: &mut TrialLog, course: &StressRun<P>) {
        let end = &course.end.state;
        let bodies = end.bodies.iter();
        let mut numbers = bodies.flat_map(|b| b.position.iter().chain(b.velocity.iter()));
        let finite = numbers.all(|x| x.is_finite()) && end.time.is_finite();
        must!(log, finite; "a number that is not finite");
        if !finite {
            return;
        }
        must!(log, !course.ledger.disordered; "collisions out of order");
        log.at_most("receding pair", course.ledger.receding, RECEDING);
        log.at_most("overlap over d", course.overlap / self.diameter(), OVERLAP);
        // Independent check, without the engine's neighbour search.
        if let Some(initial::Overlap {
            pair: [one, other],
            depth,
        }) = self.overlap(end, OVERLAP * self.diameter())
        {
            log.fault(format!("disks {one} and {other} overlap by {depth:.3e}"));
        }
        log.at_most("energy", self.energy_error(course), ENERGY);
        log.at_most("momentum", self.momentum_error(end), MOMENTUM);
    }

    /// Returns the radius and the mass of the disk with this index.
    fn size(&self, index: usize) -> (f64, f64) {
        let sizes = self.scene.sizes();
        let tag = sizes.tag_of(index);
        (sizes.radius(tag), sizes.mass(tag))
    }

    /// Returns the first pair of disks that overlap by more than a tolerance \[length\].
    pub fn overlap(&self, state: &State<P>, tolerance: f64) -> Option<initial::Overlap> {
        let positions: Vec<_> = state.bodies.iter().map(|body| body.position).collect();
        initial::first_overlap(
            &positions,
            |index| self.size(index).0,
            &state.domain,
            tolerance,
        )
    }

    /// Returns the relative error of the energy: |K + energy lost in collisions - K(0)|/K(0) for
    /// the kinetic energy K.
    pub fn energy_error(&self, course: &StressRun<P>) -> f64 {
        let energy = self.start.kinetic_energy(&self.scene);
        let now = course.end.state.kinetic_energy(&self.scene) + course.ledger.lost;
        if energy > 0.0 {
            (now / energy - 1.0).abs()
        } else {
            now.abs()
        }
    }

    /// Returns the error of the total momentum P: |P - P(0)| over the sum of m |v| at the start.
    pub fn momentum_error(&self, state: &State<P>) -> f64 {
        let bodies = self.start.bodies.iter().enumerate();
        let scale: f64 = bodies
            .map(|(index, body)| self.size(index).1 * body.velocity.norm())
            .sum();
        let change = (state.momentum(&self.scene) - self.start.momentum(&self.scene)).norm();
        if scale > 0.0 { change / scale } else { change }
    }

    /// Runs exact disks to a time or a number of collisions, checks the run and its end, and
    /// records it. Then repeats the first `killed` collisions with kills and restarts.
    pub fn check(
        &self,
        log: &mut TrialLog,
        until: f64,
        most: u64,
        end: RunEnd,
        killed: u64,
    ) -> Result<StressRun<P>, TrialError> {
        let course = self.run_in_legs(until, most, most.div_ceil(4).max(1), |_, _| true)?;
        let good = match end {
            RunEnd::TimeOrCount => course.stopped.is_none(),
            RunEnd::Time => course.reached,
            RunEnd::TimeOrCollapse => course.reached || course.collapsed(),
        };
        must!(log, good; "{}", course.ended());
        self.audit(log, &course);
        let then = if course.collapsed() {
            ", then collapse"
        } else {
            ""
        };
        found_in_gas!(log; "{} collisions{then}, energy {:.1e}, overlap {:.1e} d",
            course.collisions(), self.energy_error(&course), course.overlap / self.diameter());
        self.survives_kills(log, killed.min(course.collisions()).max(1), 1)?;
        Ok(course)
    }

    /// Runs and checks exact disks for a number of collisions, without an end time.
    pub fn holds(&self, log: &mut TrialLog, collisions: u64) -> Result<StressRun<P>, TrialError> {
        self.check(log, f64::INFINITY, collisions, RunEnd::TimeOrCount, 4000)
    }

    /// Tests that restarts from checkpoints do not change a run of exact disks, in segments of
    /// random length.
    ///
    /// One gas continues in memory. The other is killed within each segment, so that its work there
    /// is lost, and continues from the bytes of its last checkpoint. Both must end in the same
    /// bytes, or in the same error.
    pub fn survives_kills(&self, log: &mut TrialLog, collisions: u64, seed: u64) -> Done {
        const LEGS: u64 = 4;
        let mut stream = random(seed);
        let mut in_memory = EventDrivenCheckpoint::from(self.start.clone());
        let mut bytes = postcard::to_stdvec(&in_memory)?;
        // Segments end by time, too: a thousand diameters of flight of the fastest disk, for a box
        // in which nothing collides.
        let horizon = match 1e3 * self.diameter() / fastest(&self.start) {
            time if time.is_finite() => time,
            _ => 1.0,
        };
        for leg in 0..LEGS {
            let most = stream.random_range(1..=(2 * collisions / LEGS).max(1));
            let until = in_memory.state.time + horizon;
            let mut engine = self.engine(in_memory)?;
            let ended = engine.advance(until, most, &mut ());
            in_memory = engine.checkpoint();

            let mut killed = self.engine(postcard::from_bytes(&bytes)?)?;
            // The outcome before a kill is lost on purpose.
            let _ = killed.advance(until, stream.random_range(0..=most), &mut ());
            let _ = killed.checkpoint();
            let mut resumed = self.engine(postcard::from_bytes(&bytes)?)?;
            let again = resumed.advance(until, most, &mut ());
            bytes = postcard::to_stdvec(&resumed.checkpoint())?;
            must!(log, ended == again; "leg {leg} ended otherwise after a kill: {ended:?}, {again:?}");
            let same = postcard::to_stdvec(&in_memory)? == bytes;
            must!(log, same; "leg {leg} has other bytes after a kill");
            if ended.is_err() || !same {
                break;
            }
        }
        Ok(())
    }

    /// Compares the first collisions of exact disks with a search over all pairs: same pairs, same
    /// order, and times within a relative tolerance.
    pub fn follows_all_pairs(
        &self,
        log: &mut TrialLog,
        collisions: usize,
        tolerance: f64,
    ) -> Result<usize, TrialError> {
        let mut slow_state = self.start.clone();
        let slow = plain::run_collisions(&self.scene, &mut slow_state, collisions);
        let fast = self.pairs(slow.len())?;
        must!(log, fast.len() == slow.len(); "{} collisions of {}", fast.len(), slow.len());
        let scale = slow
            .last()
            .map_or(0.0, |event| event.time - self.start.time);
        for (number, (ours, theirs)) in fast.iter().zip(&slow).enumerate() {
            let good = ours.1 == theirs.pair && (ours.0 - theirs.time).abs() <= tolerance * scale;
            must!(log, good; "collision {number} is {ours:?}, of all pairs {theirs:?}");
            if !good {
                break;
            }
        }
        Ok(slow.len())
    }

    /// Compares each collision of exact disks with a search over all pairs in the state before it,
    /// so that rounding differences do not grow. Times agree within a tolerance \[time\]. Returns
    /// the number of equal collisions.
    pub fn collides_as_all_pairs(
        &self,
        log: &mut TrialLog,
        collisions: usize,
        tolerance: f64,
    ) -> Result<usize, TrialError> {
        let mut engine = self.engine(self.start.clone().into())?;
        for number in 0..collisions {
            let before = engine.state();
            let theirs = next_of_all_pairs(&self.scene, &before);
            let ours = next_pair(&mut engine, &before)?;
            let good = ours.zip(theirs).is_some_and(|(ours, theirs)| {
                ours.1 == theirs.1 && (ours.0 - theirs.0).abs() <= tolerance
            });
            must!(log, good; "collision {number} is {ours:?}, of all pairs {theirs:?}");
            if !good {
                return Ok(number);
            }
        }
        Ok(collisions)
    }

    /// Returns time and pair of each of the next collisions. The pair consists of the disks whose
    /// velocities changed.
    pub fn pairs(&self, collisions: usize) -> Result<Vec<(f64, [usize; 2])>, EventDrivenError> {
        let mut engine = self.engine(self.start.clone().into())?;
        let mut list = Vec::with_capacity(collisions);
        while list.len() < collisions {
            let before = engine.state();
            let Some(pair) = next_pair(&mut engine, &before)? else {
                break;
            };
            list.push(pair);
        }
        Ok(list)
    }
}

fn fastest<P: Planar>(state: &State<P>) -> f64 {
    let speeds = state.bodies.iter().map(|body| body.velocity.norm());
    speeds.fold(0.0, f64::max)
}

/// Advances exact disks by one collision. Returns its time and the pair whose velocities it
/// changes.
fn next_pair<P: Planar>(
    engine: &mut EventDrivenEngine<P>,
    before: &State<P>,
) -> Result<Option<(f64, [usize; 2])>, EventDrivenError> {
    let mut ledger = CollisionSums::default();
    engine.advance(f64::INFINITY, 1, &mut ledger)?;
    let after = engine.state();
    let mut who =
        (0..before.bodies.len()).filter(|&i| before.bodies[i].velocity != after.bodies[i].velocity);
    let first = who.next().unwrap_or(usize::MAX);
    let pair = [first, who.next_back().unwrap_or(usize::MAX)];
    Ok(ledger.first.map(|time| (time, pair)))
}

/// Finds the next collision by a search over all pairs and as many periodic images as a flight can
/// reach: (time, pair). `plain::run_collisions` sees a fixed number of images, too few for narrow
/// boxes and long flights.
fn next_of_all_pairs<P: Planar>(scene: &P, state: &State<P>) -> Option<(f64, [usize; 2])> {
    let (sizes, lengths) = (scene.sizes(), state.domain.lengths());
    let mut horizon = lengths.max() / fastest(state);
    // Twice as far each time, to a thousand boxes.
    for _ in 0..10 {
        let mut next: Option<(f64, [usize; 2])> = None;
        for (i, one) in state.bodies.iter().enumerate() {
            for (j, other) in state.bodies.iter().enumerate().skip(i + 1) {
                let distance = sizes.radius(sizes.tag_of(i)) + sizes.radius(sizes.tag_of(j));
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
                        let image = Vector2::new(f64::from(column), f64::from(row));
                        let away = separation + image.component_mul(&lengths);
                        let limit = next.map_or(horizon, |known| known.0);
                        let wait = time_to_contact(away, relative, distance * distance, limit);
                        next = wait.map(|time| (time, [i, j])).or(next);
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
