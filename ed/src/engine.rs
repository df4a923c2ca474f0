//! The engine: disks, their events, and the loop over them.

use nalgebra::{Vector2, vector};
use serde::{Deserialize, Serialize};
use stosszahl_model::{
    Body, Collision, Domain, Encounter, Free, Observe, Physics, Plane, Restitution, Sizes, Smooth,
    State, collide,
};

use crate::calendar::{Buckets, Calendar, Entry};
use crate::cells::{Cell, Cells, NONE};
use crate::contact::time_to_contact;

/// Which collisions lose energy.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Dissipation {
    /// None: the restitution of the scene is set aside (to equilibrate).
    Elastic,
    /// All, by the restitution of the scene.
    Scene,
    /// Those of disks whose last contacts are both older than this time; others are elastic. The TC
    /// model of Luding & McNamara, Granular Matter 1, 113 (1998), doi:10.1007/s100350050017, which
    /// removes inelastic collapse.
    ContactTime(f64),
}

/// What was done, in numbers that do not depend on the machine.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Tally {
    /// Pair collisions.
    pub collisions: u64,
    /// Candidate pairs whose contact was predicted.
    pub predictions: u64,
    /// Events put into the calendar.
    pub pushes: u64,
    /// Cell boundaries crossed.
    pub crossings: u64,
    /// Events found stale because their disk had collided meanwhile.
    pub stale: u64,
    /// Contacts that did not happen because the partner had collided meanwhile.
    pub broken: u64,
    /// Collisions made elastic by the TC model.
    pub elastic_contacts: u64,
}

/// Everything needed to continue a run.
#[derive(Debug, Serialize, Deserialize)]
#[serde(bound = "")]
pub struct Checkpoint<P: Physics> {
    /// The gas.
    pub state: State<P>,
    /// Time of each disk's last contact; empty unless the TC model asks for it.
    pub last_contact: Vec<f64>,
    /// How often each disk has left the box on the right and at the top, less how often on the left and at the bottom;
    /// the position plus so many sides of the box is that of a disk that was never wrapped. Empty unless asked for,
    /// by a start that has one for each disk.
    pub windings: Vec<[i32; 2]>,
    /// What was done so far.
    pub tally: Tally,
    /// Collisions since time last advanced noticeably.
    pub stalled: u64,
}

impl<P: Physics> Clone for Checkpoint<P> {
    fn clone(&self) -> Self {
        Self {
            state: self.state.clone(),
            last_contact: self.last_contact.clone(),
            windings: self.windings.clone(),
            tally: self.tally,
            stalled: self.stalled,
        }
    }
}

impl<P: Physics> From<State<P>> for Checkpoint<P> {
    fn from(state: State<P>) -> Self {
        Self {
            state,
            last_contact: Vec::new(),
            windings: Vec::new(),
            tally: Tally::default(),
            stalled: 0,
        }
    }
}

/// Why the engine could not start or go on.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum EngineError {
    /// The box is narrower than a disk.
    #[error("a disk of diameter {diameter} meets its own image in a box of {:.6} x {:.6}; both sides must be longer", lengths[0], lengths[1])]
    BoxTooSmall {
        /// Largest diameter.
        diameter: f64,
        /// Box.
        lengths: [f64; 2],
    },
    /// A position or velocity is no finite number, or too large to be squared.
    #[error("disk {disk} has {quantity} {value:?}; allowed are finite numbers up to 1e150")]
    BadNumber {
        /// Index of the disk.
        disk: usize,
        /// `position` or `velocity`.
        quantity: &'static str,
        /// What was found.
        value: [f64; 2],
    },
    /// Not one winding for each disk.
    #[error("{windings} windings for {disks} disks; allowed are none, or one for each disk")]
    BadWindings {
        /// How many were given.
        windings: usize,
        /// How many disks there are.
        disks: usize,
    },
    /// More disks than the engine can number.
    #[error("{disks} disks; allowed are up to {}", u32::MAX - 1)]
    TooMany {
        /// How many were given.
        disks: usize,
    },
    /// Infinitely many collisions in a finite time.
    #[error(
        "inelastic collapse at time {time}: {collisions} collisions without progress of time, the last of disks {} and {} near ({:.6}, {:.6}); \
         a contact time above zero (TC model) lets such a gas go on",
        pair[0], pair[1], place[0], place[1]
    )]
    InelasticCollapse {
        /// When \[time\].
        time: f64,
        /// Collisions since time last advanced.
        collisions: u64,
        /// The last pair.
        pair: [usize; 2],
        /// Where.
        place: [f64; 2],
    },
}

/// One disk in one cache line.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
struct Disk {
    /// Position relative to the corner of the cell, at the time `clock`.
    position: Vector2<f64>,
    velocity: Vector2<f64>,
    /// When position and velocity were last brought up to date.
    clock: f64,
    /// Predicted time of contact with `partner`; infinite without one.
    contact: f64,
    partner: u32,
    /// Collisions of the partner when the contact was predicted.
    partner_count: u32,
    /// Collisions of this disk.
    count: u32,
    cell: Cell,
}

impl Disk {
    #[inline]
    fn at(&self, time: f64) -> Vector2<f64> {
        self.position + self.velocity * (time - self.clock)
    }

    #[inline]
    fn advance(&mut self, time: f64) {
        self.position = self.at(time);
        self.clock = time;
    }

    /// Time and axis of the next cell boundary; the time is never before the clock.
    #[inline]
    fn crossing(&self, width: Vector2<f64>) -> (f64, usize) {
        let exit = |axis: usize| {
            let speed = self.velocity[axis];
            if speed > 0.0 {
                (width[axis] - self.position[axis]) / speed
            } else if speed < 0.0 {
                -self.position[axis] / speed
            } else {
                f64::INFINITY
            }
        };
        let (x, y) = (exit(0), exit(1));
        let (wait, axis) = if x <= y { (x, 0) } else { (y, 1) };
        (self.clock + wait.max(0.0), axis)
    }
}

/// Whether two touching disks approach no faster than their velocities are rounded: after a contact
/// with restitution 0 the normal part of their relative velocity is nothing but rounding.
#[inline]
fn at_rest(separation: Vector2<f64>, first: Vector2<f64>, second: Vector2<f64>) -> bool {
    let approach = -separation.dot(&(first - second)) / separation.norm();
    approach <= 8.0 * f64::EPSILON * (first.norm() + second.norm())
}

/// Sides of the box that [`Domain::wrap`] takes off a position.
fn wound(domain: &Domain<Plane>, position: Vector2<f64>) -> [i32; 2] {
    let (inside, lengths) = (domain.wrap(position), domain.lengths());
    // A tiny negative position is wrapped to zero, which is no side of the box.
    [0, 1].map(|axis| ((position[axis] - inside[axis]) / lengths[axis]).round() as i32)
}

/// The windings of a start by disk, for positions wrapped into the box.
fn follow<P: Physics<Space = Plane>>(
    state: &State<P>,
    windings: &[[i32; 2]],
    names: &[u32],
) -> Result<Vec<[i32; 2]>, EngineError> {
    if windings.is_empty() {
        return Ok(Vec::new());
    }
    if windings.len() != names.len() {
        return Err(EngineError::BadWindings {
            windings: windings.len(),
            disks: names.len(),
        });
    }
    let winding = |&name: &u32| {
        let at = state.bodies[name as usize].position;
        add(windings[name as usize], wound(&state.domain, at))
    };
    Ok(names.iter().map(winding).collect())
}

fn add(one: [i32; 2], other: [i32; 2]) -> [i32; 2] {
    [0, 1].map(|axis| one[axis].wrapping_add(other[axis]))
}

/// Collisions without progress of time, beyond those that many disks may have at once, that are called
/// a collapse.
const COLLAPSE: u64 = 20_000;

/// Event-driven dynamics of smooth disks in a periodic box.
///
/// An engine lives for one leg of a run: [`Engine::checkpoint`] and a new engine start the next one
/// with a fresh epoch and the disks sorted in memory. As the leg is a function of the checkpoint alone,
/// a run continues from it to the same bytes.
pub struct Engine<P: Physics, Q: Calendar = Buckets> {
    scene: P,
    dissipation: Dissipation,
    domain: Domain<Plane>,
    cells: Cells,
    disks: Vec<Disk>,
    tags: Vec<<P::Sizes as Sizes>::Tag>,
    /// Index in the state of each disk; disks are stored in cell order.
    names: Vec<u32>,
    last_contact: Vec<f64>,
    /// Box crossings along each axis, by disk; empty unless asked for.
    windings: Vec<[i32; 2]>,
    calendar: Q,
    /// Absolute time at which the engine's own time is zero.
    epoch: f64,
    /// Own time.
    now: f64,
    /// Absolute time; exactly the one asked for when it was reached.
    time: f64,
    tally: Tally,
    /// Own time and number of collisions when time last advanced noticeably.
    progress: (f64, u64),
    /// Time in which a typical disk moves by its diameter, at the start of the leg.
    unit: f64,
}

impl<P, Q> Engine<P, Q>
where
    P: Physics<Space = Plane, Surface = Smooth, Field = Free>,
    Q: Calendar,
{
    /// Starts from a state, or goes on from a checkpoint.
    ///
    /// # Errors
    /// [`EngineError`] if the state has numbers that no engine can work with. Overlaps are not looked
    /// for here: see `stosszahl_model::initial::first_overlap`.
    pub fn new(
        scene: P,
        dissipation: Dissipation,
        start: impl Into<Checkpoint<P>>,
    ) -> Result<Self, EngineError> {
        let Checkpoint {
            state,
            last_contact,
            windings,
            tally,
            stalled,
        } = start.into();
        let count = state.bodies.len();
        if count >= u32::MAX as usize {
            return Err(EngineError::TooMany { disks: count });
        }
        let lengths = state.domain.lengths();
        let diameter = 2.0 * scene.sizes().largest_radius();
        let mut cells = Cells::new(lengths, diameter, count);
        if lengths.min() <= diameter * (1.0 + 1e-9) {
            return Err(EngineError::BoxTooSmall {
                diameter,
                lengths: lengths.into(),
            });
        }
        let mut located = Vec::with_capacity(count);
        for (index, body) in state.bodies.iter().enumerate() {
            for (quantity, value) in [("position", body.position), ("velocity", body.velocity)] {
                // Also false for NaN.
                if !value.iter().all(|x| x.abs() <= 1e150) {
                    return Err(EngineError::BadNumber {
                        disk: index,
                        quantity,
                        value: value.into(),
                    });
                }
            }
            let (cell, offset) = cells.locate(state.domain.wrap(body.position));
            located.push((cells.index(cell), index, cell, offset));
        }
        located.sort_unstable_by_key(|&(place, index, ..)| (place, index));
        let disks: Vec<Disk> = located
            .iter()
            .map(|&(_, index, cell, position)| Disk {
                position,
                velocity: state.bodies[index].velocity,
                clock: 0.0,
                contact: f64::INFINITY,
                partner: NONE,
                partner_count: 0,
                count: 0,
                cell,
            })
            .collect();
        let names: Vec<u32> = located.iter().map(|&(_, index, ..)| index as u32).collect();
        for (disk, &(_, _, cell, _)) in located.iter().enumerate() {
            cells.insert(disk as u32, cell);
        }
        let last_contact = match dissipation {
            Dissipation::ContactTime(_) if last_contact.is_empty() => {
                vec![f64::NEG_INFINITY; count]
            }
            Dissipation::ContactTime(_) => names
                .iter()
                .map(|&name| last_contact[name as usize] - state.time)
                .collect(),
            _ => Vec::new(),
        };
        let windings = follow(&state, &windings, &names)?;
        let speed = state
            .bodies
            .iter()
            .map(|body| body.velocity.norm_squared())
            .sum::<f64>();
        let unit = diameter / (speed / count.max(1) as f64).sqrt();
        let unit = if unit.is_finite() { unit } else { 0.0 };
        let tags = names
            .iter()
            .map(|&name| scene.sizes().tag(name as usize))
            .collect();
        let mut engine = Self {
            scene,
            dissipation,
            domain: state.domain,
            cells,
            disks,
            tags,
            names,
            last_contact,
            windings,
            calendar: Q::new(Vec::new(), 0),
            epoch: state.time,
            now: 0.0,
            time: state.time,
            progress: (0.0, tally.collisions - stalled.min(tally.collisions)),
            unit,
            tally,
        };
        let entries = (0..count as u32)
            .filter_map(|disk| engine.predict(disk))
            .collect();
        engine.calendar = Q::new(entries, count);
        Ok(engine)
    }

    /// Advances to the absolute time `until`, or until `most_collisions` have happened in this call.
    /// True if the time was reached.
    ///
    /// # Errors
    /// [`EngineError::InelasticCollapse`]; the engine then stands at the moment of collapse.
    pub fn advance(
        &mut self,
        until: f64,
        most_collisions: u64,
        watch: &mut impl Observe<P>,
    ) -> Result<bool, EngineError> {
        let end = until - self.epoch;
        let last = self.tally.collisions.saturating_add(most_collisions);
        while self.tally.collisions < last {
            let Some(entry) = self.calendar.pop(end) else {
                // A gas without events stays where it is rather than move for an infinite time.
                if until.is_finite() {
                    self.now = self.now.max(end);
                    self.time = self.time.max(until);
                }
                return Ok(true);
            };
            let disk = &self.disks[entry.disk as usize];
            if entry.count != disk.count {
                self.tally.stale += 1;
                continue;
            }
            self.now = entry.time;
            if entry.time != disk.contact {
                self.cross(entry.disk);
            } else if self.disks[disk.partner as usize].count == disk.partner_count {
                let partner = disk.partner;
                self.collide(entry.disk, partner, watch);
                if self.tally.collisions.is_multiple_of(4096) {
                    self.check_progress([entry.disk, partner])?;
                }
            } else {
                self.tally.broken += 1;
                self.disks[entry.disk as usize].advance(entry.time);
                self.schedule(entry.disk);
            }
        }
        self.time = self.epoch + self.now;
        Ok(false)
    }

    /// The gas at the present time.
    pub fn state(&self) -> State<P> {
        let mut bodies = vec![Body::new(Vector2::zeros(), Vector2::zeros()); self.disks.len()];
        for (disk, &name) in self.disks.iter().zip(&self.names) {
            let position = self.cells.corner(disk.cell) + disk.at(self.now);
            bodies[name as usize] = Body::new(self.domain.wrap(position), disk.velocity);
        }
        State {
            time: self.time,
            domain: self.domain,
            bodies,
        }
    }

    /// Everything needed to go on from here.
    pub fn checkpoint(&self) -> Checkpoint<P> {
        let mut last_contact = vec![0.0; self.last_contact.len()];
        for (&last, &name) in self.last_contact.iter().zip(&self.names) {
            last_contact[name as usize] = last + self.epoch;
        }
        let mut windings = vec![[0; 2]; self.windings.len()];
        for ((&winding, disk), &name) in self.windings.iter().zip(&self.disks).zip(&self.names) {
            // Where the state wraps a position, the winding follows.
            let position = self.cells.corner(disk.cell) + disk.at(self.now);
            windings[name as usize] = add(winding, wound(&self.domain, position));
        }
        Checkpoint {
            state: self.state(),
            last_contact,
            windings,
            tally: self.tally,
            stalled: self.tally.collisions - self.progress.1,
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

    /// The deepest overlap of any pair at the present time \[length\]; 0 if none overlap. An audit: cost
    /// of one prediction for all disks.
    pub fn worst_overlap(&self) -> f64 {
        let mut worst = 0.0_f64;
        for who in 0..self.disks.len() as u32 {
            let own = self.disks[who as usize].at(self.now);
            self.for_neighbours(who, -1..=1, -1..=1, |other, shift| {
                let apart = own - self.disks[other as usize].at(self.now) - shift;
                worst = worst.max(self.contact_distance(who, other) - apart.norm());
            });
        }
        worst
    }

    /// Memory held \[bytes\].
    pub fn bytes(&self) -> usize {
        self.disks.capacity() * size_of::<Disk>()
            + self.cells.bytes()
            + self.calendar.bytes()
            + self.names.capacity() * 4
            + self.last_contact.capacity() * 8
            + self.windings.capacity() * size_of::<[i32; 2]>()
            + self.tags.capacity() * size_of::<<P::Sizes as Sizes>::Tag>()
    }

    #[inline]
    fn contact_distance(&self, first: u32, second: u32) -> f64 {
        let sizes = self.scene.sizes();
        sizes.radius(self.tags[first as usize]) + sizes.radius(self.tags[second as usize])
    }

    /// Calls `visit` with each disk in the cells `columns` x `rows` around a disk (steps of -1, 0, 1)
    /// and the vector from that disk's cell to the other's. Disks in a box of fewer than three cells
    /// are met once for each image.
    #[inline(always)]
    fn for_neighbours(
        &self,
        who: u32,
        columns: std::ops::RangeInclusive<i32>,
        rows: std::ops::RangeInclusive<i32>,
        mut visit: impl FnMut(u32, Vector2<f64>),
    ) {
        let cell = self.disks[who as usize].cell;
        let width = self.cells.width();
        for row in rows {
            let y = self.cells.shifted(cell[1], 1, row);
            for column in columns.clone() {
                let x = self.cells.shifted(cell[0], 0, column);
                let mut other = self.cells.first(self.cells.index([x, y]));
                while other != NONE {
                    if other != who {
                        visit(
                            other,
                            vector![f64::from(column) * width[0], f64::from(row) * width[1]],
                        );
                    }
                    other = self.cells.after(other);
                }
            }
        }
    }

    /// Improves the predicted contact of a disk, which is up to date, by those with disks in the given
    /// cells around it.
    #[inline(always)]
    fn search(
        &mut self,
        who: u32,
        columns: std::ops::RangeInclusive<i32>,
        rows: std::ops::RangeInclusive<i32>,
    ) {
        let disk = self.disks[who as usize];
        let (mut wait, mut partner) = (disk.contact - disk.clock, disk.partner);
        let mut predictions = 0;
        self.for_neighbours(who, columns, rows, |candidate, shift| {
            let other = &self.disks[candidate as usize];
            let separation = disk.position - other.at(disk.clock) - shift;
            let relative = disk.velocity - other.velocity;
            let distance = self.contact_distance(who, candidate);
            predictions += 1;
            if let Some(time) = time_to_contact(separation, relative, distance * distance, wait) {
                if time <= 0.0 && at_rest(separation, disk.velocity, other.velocity) {
                    return;
                }
                if time <= 0.0 && at_rest(separation, disk.velocity, other.velocity) {
                    return;
                }
                debug_assert!(
                    distance - separation.norm() < 1e-9 * distance,
                    "disks {who} and {candidate} overlap by {}",
                    distance - separation.norm()
                );
                wait = time;
                partner = candidate;
            }
        });
        self.tally.predictions += predictions;
        if partner != disk.partner || wait != disk.contact - disk.clock {
            let partner_count = self.disks[partner as usize].count;
            let disk = &mut self.disks[who as usize];
            // An overlap by rounding gives a time just before now.
            disk.contact = disk.clock + wait.max(0.0);
            disk.partner = partner;
            disk.partner_count = partner_count;
        }
    }

    /// Predicts the next event of a disk that is up to date, from nothing; `None` if it has none.
    fn predict(&mut self, who: u32) -> Option<Entry> {
        let disk = &mut self.disks[who as usize];
        disk.contact = f64::INFINITY;
        disk.partner = NONE;
        self.search(who, -1..=1, -1..=1);
        self.next_event(who)
    }

    fn next_event(&mut self, who: u32) -> Option<Entry> {
        let disk = &self.disks[who as usize];
        let time = disk.contact.min(disk.crossing(self.cells.width()).0);
        time.is_finite().then(|| {
            self.tally.pushes += 1;
            Entry {
                time,
                disk: who,
                count: disk.count,
            }
        })
    }

    fn schedule(&mut self, who: u32) {
        if let Some(entry) = self.predict(who) {
            self.calendar.push(entry);
        }
    }

    /// Moves a disk into the next cell and looks at the three cells that come into its reach.
    fn cross(&mut self, who: u32) {
        self.tally.crossings += 1;
        let width = self.cells.width();
        let disk = &mut self.disks[who as usize];
        let axis = disk.crossing(width).1;
        let step = if disk.velocity[axis] > 0.0 { 1 } else { -1 };
        disk.advance(self.now);
        let old = disk.cell;
        disk.position[axis] -= f64::from(step) * width[axis];
        disk.cell[axis] = self.cells.shifted(old[axis], axis, step);
        let new = disk.cell;
        if !self.windings.is_empty() && i32::from(new[axis]) != i32::from(old[axis]) + step {
            let winding = &mut self.windings[who as usize][axis];
            *winding = winding.wrapping_add(step);
        }
        self.cells.remove(who, old);
        self.cells.insert(who, new);
        if axis == 0 {
            self.search(who, step..=step, -1..=1);
        } else {
            self.search(who, -1..=1, step..=step);
        }
        if let Some(entry) = self.next_event(who) {
            self.calendar.push(entry);
        }
    }

    fn collide(&mut self, first: u32, second: u32, watch: &mut impl Observe<P>) {
        let now = self.now;
        self.tally.collisions += 1;
        for who in [first, second] {
            let disk = &mut self.disks[who as usize];
            disk.advance(now);
            disk.count = disk.count.wrapping_add(1);
        }
        let (one, other) = (self.disks[first as usize], self.disks[second as usize]);
        let line = self
            .cells
            .nearest(one.position - other.position + self.cells.between(one.cell, other.cell));
        let sizes = self.scene.sizes();
        let masses = [first, second].map(|who| sizes.mass(self.tags[who as usize]));
        let pair = Encounter {
            velocities: [one.velocity, other.velocity],
            masses,
            line,
        };
        let relative = one.velocity - other.velocity;
        let restitution = self.restitution([first, second], -relative.dot(&line) / line.norm());
        let [u, v] = collide(&self.scene, &pair, restitution);
        self.disks[first as usize].velocity = u;
        self.disks[second as usize].velocity = v;
        watch.collision(&Collision {
            time: self.epoch + now,
            relative,
            line,
            reduced_mass: masses[0] * masses[1] / (masses[0] + masses[1]),
            restitution,
            weight: 1.0,
        });
        self.schedule(first);
        self.schedule(second);
    }

    #[inline]
    fn restitution(&mut self, pair: [u32; 2], approach: f64) -> f64 {
        let law = |scene: &P| scene.restitution().normal(approach.max(0.0));
        match self.dissipation {
            Dissipation::Elastic => 1.0,
            Dissipation::Scene => law(&self.scene),
            Dissipation::ContactTime(contact_time) => {
                let mut recent = false;
                for who in pair {
                    let last = &mut self.last_contact[who as usize];
                    recent |= self.now - *last < contact_time;
                    *last = self.now;
                }
                self.tally.elastic_contacts += u64::from(recent);
                if recent { 1.0 } else { law(&self.scene) }
            }
        }
    }

    /// Tells a collapse: many collisions within what rounding leaves of time.
    fn check_progress(&mut self, pair: [u32; 2]) -> Result<(), EngineError> {
        let (time, collisions) = self.progress;
        // Legs end, and epochs move, but a collapse does not: its collisions are counted across legs, and
        // time is measured against its absolute value.
        let resolution = 1e-13 * ((self.epoch + self.now).abs() + self.unit);
        if self.now - time > resolution {
            self.progress = (self.now, self.tally.collisions);
            return Ok(());
        }
        let stuck = self.tally.collisions - collisions;
        if stuck > COLLAPSE + 8 * self.disks.len() as u64 {
            let place = self.cells.corner(self.disks[pair[0] as usize].cell)
                + self.disks[pair[0] as usize].position;
            return Err(EngineError::InelasticCollapse {
                time: self.epoch + self.now,
                collisions: stuck,
                pair: pair.map(|who| self.names[who as usize] as usize),
                place: self.domain.wrap(place).into(),
            });
        }
        Ok(())
    }
}
