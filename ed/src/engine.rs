//! The engine: disks, their events, and the loop over them.

use nalgebra::Vector2;
use stosszahl_model::{
    Body, Collision, Domain, Encounter, Free, Observe, Physics, Plane, Restitution, Sizes, Smooth,
    State, collide,
};

use crate::calendar::{Agenda, Buckets, Calendar, Entry};
use crate::cells::NONE;
use crate::checkpoint::{Checkpoint, Dissipation, Tally};
use crate::contact::Candidates;
use crate::disk::Disks;
use crate::error::EngineError;
use crate::progress::{Latest, Progress};
use crate::windings::{self, Winding};

/// Collisions a disk after which an engine starts afresh: time is then measured from a near epoch again, and the
/// disks, which diffuse, are sorted in memory.
const REFRESH: u64 = 20;

/// Collisions below which that does not pay.
const LEAST_REFRESH: u64 = 100_000;

/// Diameters flown by a typical disk after which it does so too, in a thin gas: own times are rounded to 1e-16 of
/// themselves, and so are places to 1e-12 diameters.
const HORIZON: f64 = 4096.0;

/// Event-driven dynamics of smooth disks in a periodic box.
///
/// An engine lives for one leg of a run: [`Engine::checkpoint`] and a new engine start the next one
/// with a fresh epoch and the disks sorted in memory. As the leg is a function of the checkpoint alone,
/// a run continues from it to the same bytes. In a long leg the engine does the same by itself now and
/// then.
pub struct Engine<P: Physics, Q: Calendar = Buckets> {
    scene: P,
    dissipation: Dissipation,
    domain: Domain<Plane>,
    disks: Disks,
    tags: Vec<<P::Sizes as Sizes>::Tag>,
    /// Index in the state of each disk; disks are stored in cell order.
    names: Vec<u32>,
    last_contact: Vec<f64>,
    /// Box crossings along each axis, by disk; empty unless asked for.
    windings: Vec<Winding>,
    calendar: Q,
    candidates: Candidates,
    /// Unit of the engine's own speeds, a power of two, so that changing units rounds nothing and squares of
    /// speeds neither overflow nor underflow.
    speed: f64,
    /// Absolute time at which the engine's own time is zero.
    epoch: f64,
    /// Own time.
    now: f64,
    /// Absolute time; exactly the one asked for when it was reached.
    time: f64,
    tally: Tally,
    /// Number of collisions at which the engine starts afresh.
    refresh: u64,
    /// Own time at which it does.
    horizon: f64,
    progress: Progress,
    /// Own time in which a typical disk moves by its diameter, since the last fresh start.
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
        let lengths = state.domain.lengths();
        let diameter = 2.0 * scene.sizes().largest_radius();
        check(&state, &last_contact, diameter)?;
        let fastest = (state.bodies.iter())
            .map(|body| body.velocity.amax())
            .fold(0.0, f64::max);
        let speed = if fastest > 0.0 {
            2.0_f64.powi((fastest.log2().floor() as i32).clamp(-1000, 1000))
        } else {
            1.0
        };
        let sizes = scene.sizes();
        let body = |index: usize| {
            let body = &state.bodies[index];
            let position = state.domain.wrap(body.position);
            (
                position,
                body.velocity / speed,
                sizes.radius(sizes.tag(index)),
            )
        };
        let unequal = !P::Sizes::UNIFORM;
        let (disks, names) = Disks::new(lengths, sizes.largest_radius(), count, body, unequal);
        let last_contact = match dissipation {
            Dissipation::ContactTime(_) if last_contact.is_empty() => {
                vec![f64::NEG_INFINITY; count]
            }
            Dissipation::ContactTime(_) => names
                .iter()
                .map(|&name| (last_contact[name as usize] - state.time) * speed)
                .collect(),
            _ => Vec::new(),
        };
        let windings = windings::follow(&state, &windings, &names)?;
        let square: f64 = (disks.all.iter())
            .map(|disk| disk.velocity.norm_squared())
            .sum();
        let unit = diameter / (square / count.max(1) as f64).sqrt();
        let unit = if unit.is_finite() { unit } else { 0.0 };
        let tags = names
            .iter()
            .map(|&name| scene.sizes().tag(name as usize))
            .collect();
        let mut engine = Self {
            scene,
            dissipation,
            domain: state.domain,
            calendar: Q::new(&NoEvents),
            disks,
            tags,
            names,
            last_contact,
            windings,
            candidates: Candidates::new(),
            speed,
            epoch: state.time,
            now: 0.0,
            time: state.time,
            refresh: (tally.collisions).saturating_add(REFRESH * count as u64 + LEAST_REFRESH),
            horizon: if unit > 0.0 {
                HORIZON * unit
            } else {
                f64::INFINITY
            },
            progress: Progress::new(tally.collisions.saturating_sub(stalled)),
            unit,
            tally,
        };
        for disk in 0..count as u32 {
            engine.look_around(disk);
        }
        engine.tally.pushes += count as u64;
        // A single disk meets nobody, however far it flies.
        if count > 1 {
            engine.calendar = Q::new(&engine.disks);
        }
        Ok(engine)
    }

    /// Advances to the absolute time `until`, or until `most_collisions` have happened in this call.
    /// True if the time was reached.
    ///
    /// # Errors
    /// [`EngineError::InelasticCollapse`]; the engine then stands at the moment of collapse.
    /// [`EngineError::NoCollisions`] and [`EngineError::BadTime`] if the time cannot be reached.
    pub fn advance(
        &mut self,
        until: f64,
        most_collisions: u64,
        watch: &mut impl Observe<P>,
    ) -> Result<bool, EngineError> {
        if until.is_nan() {
            return Err(EngineError::BadTime { until });
        }
        self.progress.be_patient();
        let last = self.tally.collisions.saturating_add(most_collisions);
        while self.tally.collisions < last {
            if self.tally.collisions >= self.refresh || self.now >= self.horizon {
                self.start_afresh(until)?;
            }
            if self.advance_afresh(until, last.min(self.refresh), watch)? {
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// Goes on as a new engine from the present checkpoint.
    fn start_afresh(&mut self, until: f64) -> Result<(), EngineError> {
        self.time = self.present(until);
        let checkpoint = self.checkpoint();
        let progress = self.progress.afresh(self.tally.collisions);
        // Two engines at once would take twice the memory.
        let nobody = |_| (Vector2::zeros(), Vector2::zeros(), 0.0);
        self.calendar = Q::new(&NoEvents);
        self.disks = Disks::new(self.domain.lengths(), 1.0, 0, nobody, false).0;
        *self = Self::new(self.scene.clone(), self.dissipation, checkpoint)?;
        self.progress = progress;
        Ok(())
    }

    /// The absolute time; not beyond the one asked for by rounding.
    fn present(&self, until: f64) -> f64 {
        (self.epoch + self.now / self.speed).min(until.max(self.time))
    }

    /// Advances to a time, or until there were `last` collisions in all.
    fn advance_afresh(
        &mut self,
        until: f64,
        last: u64,
        watch: &mut impl Observe<P>,
    ) -> Result<bool, EngineError> {
        let end = (until - self.epoch) * self.speed;
        let width = self.disks.cells.width();
        while self.tally.collisions < last && self.now < self.horizon {
            let Some(entry) = self.calendar.pop(end, &self.disks) else {
                // A gas without events stays where it is rather than move for an infinite time.
                if until.is_finite() {
                    self.stop_at(until, end)?;
                }
                return Ok(true);
            };
            let disk = &self.disks.all[entry.disk as usize];
            let (exit, axis) = disk.exit(width);
            let contact = disk.contact <= exit;
            if entry.time != if contact { disk.contact } else { exit } {
                self.tally.stale += 1;
                continue;
            }
            self.now = entry.time;
            if !contact {
                self.cross(entry.disk, axis)?;
                continue;
            }
            let partner = disk.partner;
            if self.disks.all[partner as usize].count == disk.partner_count {
                self.collide(entry.disk, partner, watch)?;
            } else {
                self.tally.broken += 1;
                self.disks.all[entry.disk as usize].advance(entry.time);
                self.predict(entry.disk);
            }
        }
        self.time = self.present(until);
        Ok(false)
    }

    /// Stands at a time at which nothing happens.
    fn stop_at(&mut self, until: f64, end: f64) -> Result<(), EngineError> {
        let moving = || self.disks.all.iter().any(|disk| disk.velocity.amax() > 0.0);
        let diameter = 2.0 * self.scene.sizes().largest_radius();
        // Only a disk that is alone can fly so far without an event.
        if end * f64::EPSILON > diameter && moving() {
            return Err(EngineError::BadTime { until });
        }
        self.now = self.now.max(end);
        self.time = self.time.max(until);
        Ok(())
    }

    /// The gas at the present time.
    pub fn state(&self) -> State<P> {
        let mut bodies = vec![Body::new(Vector2::zeros(), Vector2::zeros()); self.names.len()];
        for (disk, &name) in self.names.iter().enumerate() {
            let position = self.disks.place(disk as u32, self.now);
            let velocity = self.disks.all[disk].velocity * self.speed;
            bodies[name as usize] = Body::new(self.domain.wrap(position), velocity);
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
            last_contact[name as usize] = last / self.speed + self.epoch;
        }
        let mut windings = vec![[0; 2]; self.windings.len()];
        for (disk, (&winding, &name)) in self.windings.iter().zip(&self.names).enumerate() {
            // Where the state wraps a position, the winding follows.
            let position = self.disks.place(disk as u32, self.now);
            let wound = windings::wound(&self.domain, position);
            windings[name as usize] = windings::add(winding, wound);
        }
        Checkpoint {
            state: self.state(),
            last_contact,
            windings,
            tally: self.tally,
            stalled: self.progress.stalled(self.tally.collisions),
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
        for who in 0..self.names.len() as u32 {
            let distance = |other| self.contact_distance(who, other);
            let radius = self.scene.sizes().radius(self.tags[who as usize]);
            worst = worst.max(self.disks.overlap(who, self.now, radius, distance));
        }
        worst
    }

    /// Memory held \[bytes\].
    pub fn bytes(&self) -> usize {
        self.disks.bytes()
            + self.calendar.bytes()
            + self.names.capacity() * 4
            + self.last_contact.capacity() * 8
            + self.windings.capacity() * size_of::<Winding>()
            + self.tags.capacity() * size_of::<<P::Sizes as Sizes>::Tag>()
    }

    #[inline(always)]
    fn contact_distance(&self, first: u32, second: u32) -> f64 {
        let sizes = self.scene.sizes();
        sizes.radius(self.tags[first as usize]) + sizes.radius(self.tags[second as usize])
    }

    /// Improves the predicted contact of a disk, which is up to date, by those with disks in the cells
    /// around it, as [`Disks::search`].
    #[inline(always)]
    fn search(&mut self, who: u32, beyond: Option<(usize, usize)>) {
        self.tally.predictions += self.disks.search(
            &mut self.candidates,
            who,
            beyond,
            self.scene.sizes(),
            &self.tags,
        );
    }

    /// Predicts the next contact of a disk that is up to date, from nothing.
    fn look_around(&mut self, who: u32) {
        let disk = &mut self.disks.all[who as usize];
        disk.contact = f64::INFINITY;
        disk.partner = NONE;
        self.search(who, None);
    }

    /// Predicts the next contact of a disk that is up to date, from nothing, and files it.
    fn predict(&mut self, who: u32) {
        // The search for two is faster even where it does the same for one twice.
        let sizes = self.scene.sizes();
        if let Some(predictions) = self.disks.search_both(who, who, sizes, &self.tags) {
            self.tally.predictions += predictions / 2;
        } else {
            self.look_around(who);
        }
        self.schedule(who);
    }

    /// Predicts the next contacts of two disks that have just collided.
    #[inline]
    fn predict_both(&mut self, first: u32, second: u32) {
        let sizes = self.scene.sizes();
        if let Some(predictions) = self.disks.search_both(first, second, sizes, &self.tags) {
            self.tally.predictions += predictions;
            self.schedule(first);
            self.schedule(second);
        } else {
            self.predict(first);
            self.predict(second);
        }
    }

    #[inline]
    fn schedule(&mut self, who: u32) {
        let time = self.disks.time(who);
        if time.is_finite() {
            self.tally.pushes += 1;
            self.calendar.push(Entry { time, disk: who });
        }
    }

    /// Moves a disk into the next cell and looks at what comes into its reach.
    fn cross(&mut self, who: u32, axis: usize) -> Result<(), EngineError> {
        self.tally.crossings += 1;
        let (forward, around) = self.disks.cross(who, axis, self.now);
        if around && !self.windings.is_empty() {
            let winding = &mut self.windings[who as usize][axis];
            *winding = winding.wrapping_add(if forward { 1 } else { -1 });
        }
        self.search(who, Some((axis, if forward { 2 } else { 0 })));
        self.schedule(who);
        if let Some(crossings) = self.progress.crossing(self.names.len()) {
            self.time = self.epoch + self.now / self.speed;
            return Err(EngineError::NoCollisions {
                time: self.time,
                crossings,
            });
        }
        Ok(())
    }

    fn collide(
        &mut self,
        first: u32,
        second: u32,
        watch: &mut impl Observe<P>,
    ) -> Result<(), EngineError> {
        let now = self.now;
        self.tally.collisions += 1;
        self.disks.all[first as usize].meet(now);
        self.disks.all[second as usize].meet(now);
        let distance = self.contact_distance(first, second);
        let line = self.disks.line(first, second, distance);
        let velocities = [
            self.disks.all[first as usize].velocity,
            self.disks.all[second as usize].velocity,
        ];
        let sizes = self.scene.sizes();
        let masses = [
            sizes.mass(self.tags[first as usize]),
            sizes.mass(self.tags[second as usize]),
        ];
        let relative = velocities[0] - velocities[1];
        let approach = -relative.dot(&line) / line.norm();
        let restitution = self.restitution([first, second], approach * self.speed);
        let mut pair = Encounter {
            velocities,
            spins: [(); 2],
            masses,
            radii: [0.5 * distance; 2],
            line,
        };
        pair.velocities = collide(&self.scene, &pair, restitution).velocities;
        if (pair.velocities[0] - pair.velocities[1]).dot(&line) < 0.0 {
            part(&self.scene, &mut pair);
        }
        self.disks.all[first as usize].velocity = pair.velocities[0];
        self.disks.all[second as usize].velocity = pair.velocities[1];
        watch.collision(&Collision {
            time: self.epoch + now / self.speed,
            relative: relative * self.speed,
            line,
            reduced_mass: masses[0] * masses[1] / (masses[0] + masses[1]),
            restitution,
            weight: 1.0,
        });
        self.predict_both(first, second);
        let latest = Latest {
            pair: [first, second],
            now,
            age: self.epoch * self.speed + now,
            approach,
            diameter: distance,
            unit: self.unit,
            disks: self.names.len(),
        };
        if self.progress.collision(self.tally.collisions, &latest) {
            return Err(self.collapse(latest.pair));
        }
        Ok(())
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
                    recent |= self.now - *last < contact_time * self.speed;
                    *last = self.now;
                }
                self.tally.elastic_contacts += u64::from(recent);
                if recent { 1.0 } else { law(&self.scene) }
            }
        }
    }

    /// Stands at the moment of collapse, and tells of it.
    #[cold]
    fn collapse(&mut self, pair: [u32; 2]) -> EngineError {
        self.time = self.epoch + self.now / self.speed;
        let name = |disk: u32| self.names[disk as usize] as usize;
        let mut cluster: Vec<usize> = self.progress.cluster().into_iter().map(name).collect();
        cluster.sort_unstable();
        EngineError::InelasticCollapse {
            time: self.time,
            collisions: self.progress.stalled(self.tally.collisions),
            pair: pair.map(name),
            cluster,
            place: self.domain.wrap(self.disks.place(pair[0], self.now)).into(),
        }
    }
}

/// Whether the engine can work with what it is given.
fn check<P: Physics<Space = Plane>>(
    state: &State<P>,
    last_contact: &[f64],
    diameter: f64,
) -> Result<(), EngineError> {
    let count = state.bodies.len();
    if !state.time.is_finite() {
        return Err(EngineError::BadStart { time: state.time });
    }
    if count >= u32::MAX as usize {
        return Err(EngineError::TooMany { disks: count });
    }
    let lengths = state.domain.lengths();
    if lengths.min() <= diameter * (1.0 + 1e-9) {
        return Err(EngineError::BoxTooSmall {
            diameter,
            lengths: lengths.into(),
        });
    }
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
    }
    if !last_contact.is_empty() && last_contact.len() != count {
        return Err(EngineError::WrongCount {
            quantity: "times of last contact",
            found: last_contact.len(),
            disks: count,
        });
    }
    Ok(())
}

/// Parts two disks that still approach after a contact without rebound, as the rounding of their velocities has it:
/// they would go on into each other. They get what velocities can just tell apart, which changes the energy by the
/// square of that.
#[cold]
fn part<P: Physics<Space = Plane, Surface = Smooth>>(
    scene: &P,
    pair: &mut Encounter<Vector2<f64>>,
) {
    pair.velocities = collide(scene, pair, 1.0).velocities;
    let total = pair.masses[0] + pair.masses[1];
    let normal = pair.line.normalize();
    let speed = pair.velocities[0].amax().max(pair.velocities[1].amax());
    let mut least = (f64::EPSILON * speed).max(f64::MIN_POSITIVE);
    while (pair.velocities[0] - pair.velocities[1]).dot(&pair.line) < 0.0 {
        pair.velocities[0] += normal * (least * pair.masses[1] / total);
        pair.velocities[1] -= normal * (least * pair.masses[0] / total);
        least *= 2.0;
    }
}

/// Nothing happens; stands in while there are no predictions.
struct NoEvents;

impl Agenda for NoEvents {
    fn disks(&self) -> u32 {
        0
    }
    fn time(&self, _disk: u32) -> f64 {
        f64::INFINITY
    }
}
