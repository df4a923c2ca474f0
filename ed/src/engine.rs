//! Event-driven engine: its state, its start from a gas or checkpoint, restarts of its epoch, and
//! read access to the gas.

use std::sync::Arc;

use nalgebra::Vector2;
use stosszahl_model::interrupt::Interruption;
use stosszahl_model::walls::WallLedger;
use stosszahl_model::{
    Domain, Field, Interrupt, ParticleModel, ParticleState, Plane, ShearWork, Sizes, SpinOf, State,
    Surface,
};

use crate::arrange::{GridOptions, fill};
use crate::calendar::{Buckets, Calendar, EventTimes};
use crate::checkpoint::{DissipationRule, EventCounters, EventDrivenCheckpoint};
use crate::collapse::CollapseDetector;
use crate::contact::Candidates;
use crate::disk::DiskSystem;
use crate::error::EventDrivenError;
use crate::image_flags::{self, ImageFlags};
use crate::motion::FlightMotion;
use crate::start::{ROUNDING, check_boundaries, check_checkpoint, check_overlaps};
use crate::strip_log::StripLog;
use crate::surroundings::{BoundaryGeometry, DiskBoundaries, EngineUnits};

/// Collisions per disk after which an engine restarts: times are then counted from a new epoch, and
/// the disks, which diffuse, are sorted in memory again.
const REFRESH: u64 = 20;

/// Least number of collisions between two restarts of an engine: fewer do not pay.
const LEAST_REFRESH: u64 = 100_000;

/// Flight of a typical disk, in diameters, after which an engine restarts in a dilute gas: engine
/// times are rounded to 1e-16 of themselves, so positions to 1e-12 diameters.
const HORIZON: f64 = 4096.0;

/// Flight of a typical disk, in widths of cells, after which an engine restarts in a very dilute
/// gas with wide cells: positions are rounded to 4e-15 cells.
const HORIZON_CELLS: f64 = 16.0;

/// Order in which disks are written to a state or checkpoint.
#[derive(Clone, Copy)]
enum Order {
    /// Order of the disks in the start of the run, which users see.
    State,
    /// Order of the disks in the engine's memory, roughly sorted by cells.
    Memory,
}

/// Engine of the event-driven dynamics of disks in a box: periodic, or between walls and around
/// obstacles.
///
/// An engine lives for one leg of a run, a number of collisions: [`EventDrivenEngine::checkpoint`]
/// and a new engine start the next leg with a fresh epoch and the disks sorted in memory. As the
/// leg is a function of the checkpoint alone, a run continues from it to the same bytes. In a long
/// leg the engine does the same now and then. The times at which an engine stops do not change its
/// trajectory.
pub struct EventDrivenEngine<P: ParticleModel, Q: Calendar = Buckets> {
    pub(crate) scene: P,
    pub(crate) dissipation: DissipationRule,
    pub(crate) domain: Domain<Plane>,
    pub(crate) disks: DiskSystem<P::Field>,
    pub(crate) tags: Vec<<P::Sizes as Sizes>::Tag>,
    /// Angular velocity of each disk, in engine units; empty for smooth disks.
    pub(crate) spins: Vec<SpinOf<P>>,
    /// Index in the state of each disk of the engine; the engine stores disks sorted by cells.
    pub(crate) names: Vec<u32>,
    pub(crate) last_contact: Vec<f64>,
    /// Walls and obstacles of the box, shared by the strips of a decomposed gas.
    pub(crate) surroundings: Arc<BoundaryGeometry>,
    /// Momentum and energy given to the gas by each face of the box, then by each obstacle; empty
    /// without walls and obstacles.
    pub(crate) ledgers: Vec<WallLedger<P::Space>>,
    /// Image flags of each disk, its signed numbers of box crossings along each axis; empty unless
    /// requested.
    pub(crate) image_flags: Vec<ImageFlags>,
    pub(crate) calendar: Q,
    /// True if the event calendar holds the events of all disks; otherwise it is filled before the
    /// next event.
    pub(crate) knows_events: bool,
    pub(crate) candidates: Candidates,
    /// Engine unit of speed, a power of two near the largest speed: changing units rounds nothing,
    /// and squares of speeds neither overflow nor underflow.
    pub(crate) speed: f64,
    /// Absolute time at which the engine time is zero \[time\].
    pub(crate) epoch: f64,
    /// Current engine time: absolute time since `epoch`, times the unit of speed.
    pub(crate) now: f64,
    /// Absolute time of the gas \[time\]; exactly the requested one once it is reached.
    pub(crate) time: f64,
    pub(crate) tally: EventCounters,
    /// Energy balance of a shear flow so far: work, dissipation and supplied energy, in the units
    /// of the state; zero without a shear flow.
    pub(crate) shear_work: ShearWork,
    /// Number of stale calendar entries that came up as events: their disk had collided before.
    /// Most stale entries are dropped earlier.
    pub(crate) stale: u64,
    /// Number of contacts of each disk with walls and obstacles, which address the random numbers
    /// of rebounds; empty without any.
    pub(crate) rebounds: Vec<u32>,
    /// Number of collisions of the run at which the engine restarts next.
    pub(crate) refresh: u64,
    /// Engine time at which the engine restarts at the latest: the epoch moves, and disks are
    /// sorted again.
    pub(crate) horizon: f64,
    pub(crate) progress: CollapseDetector,
    /// Engine time in which a typical disk moves by its diameter, as of the last restart of the
    /// engine.
    pub(crate) unit: f64,
    /// State of the interrupt that can break off an advance.
    pub(crate) stop: Interruption,
    /// True if all threads of the current pool take part in restarts of the engine.
    pub(crate) parallel: bool,
    /// Log of the events of the current time window, if this engine simulates one strip of a
    /// decomposed gas.
    pub(crate) window: Option<Box<StripLog<P>>>,
}

impl<P, Q> EventDrivenEngine<P, Q>
where
    P: ParticleModel<Space = Plane>,
    Q: Calendar,
{
    /// Creates an engine for a periodic box, from the state of a gas or from a checkpoint.
    ///
    /// # Errors
    /// [`EventDrivenError`] if the state has numbers that no engine can work with, or disks of a
    /// start overlap.
    pub fn new(
        scene: P,
        dissipation: DissipationRule,
        start: impl Into<EventDrivenCheckpoint<P>>,
    ) -> Result<Self, EventDrivenError> {
        Self::between(scene, dissipation, start, &DiskBoundaries::periodic())
    }

    /// Creates an engine for a box with walls and obstacles, from the state of a gas or from a
    /// checkpoint.
    ///
    /// # Errors
    /// As [`EventDrivenEngine::new`]; and if the boundaries do not fit the box, or a disk overlaps
    /// a boundary.
    pub fn between(
        scene: P,
        dissipation: DissipationRule,
        start: impl Into<EventDrivenCheckpoint<P>>,
        boundaries: &DiskBoundaries,
    ) -> Result<Self, EventDrivenError> {
        let start = start.into();
        let diameter = 2.0 * scene.sizes().largest_radius();
        check_checkpoint(&scene, &start, diameter)?;
        check_boundaries(
            &start.state.domain,
            boundaries,
            diameter,
            start.ledgers.len(),
        )?;
        check_overlaps(&scene, &start.state, boundaries)?;
        let fresh = start.tally == EventCounters::default();
        let boundaries = boundaries.clone();
        let engine = Self::from_checkpoint(scene, dissipation, start, None, boundaries, false)?;
        // Contacts leave pairs apart by rounding, so only a start can have others.
        if fresh {
            engine.check_pairs(ROUNDING * diameter)?;
        }
        Ok(engine)
    }

    /// Checks that no two disks overlap by more than `most` \[length\]; an error otherwise.
    fn check_pairs(&self, most: f64) -> Result<(), EventDrivenError> {
        let disks = self.names.len() as u32;
        let depth = |who: u32| {
            let distance = |other| self.contact_distance(who, other);
            let radius = self.scene.sizes().radius(self.tags[who as usize]);
            self.disks.overlap(who, self.now, radius, distance)
        };
        // In the order of the state, whatever the order in memory.
        let first = (0..disks)
            .filter(|&who| depth(who) > most)
            .min_by_key(|&who| self.names[who as usize]);
        let Some(first) = first else { return Ok(()) };
        let place = |who: u32| self.domain.wrap(self.disks.wrapped_position(who, self.now));
        let gap = |other: &u32| {
            let apart = self.domain.displacement(place(first), place(*other));
            apart.norm() - self.contact_distance(first, *other)
        };
        let second = (0..disks)
            .filter(|&other| other != first)
            .min_by(|a, b| gap(a).total_cmp(&gap(b)));
        let name = |who: u32| self.names[who as usize] as usize;
        Err(EventDrivenError::OverlappingDisks {
            pair: [name(first), second.map_or(name(first), name)],
            depth: depth(first),
        })
    }

    /// Creates an engine from a valid checkpoint, whose disks may be in another order than the
    /// particles of the model: `which` gives the index in the model of each disk.
    pub(crate) fn from_checkpoint(
        scene: P,
        dissipation: DissipationRule,
        start: EventDrivenCheckpoint<P>,
        which: Option<&[u32]>,
        boundaries: DiskBoundaries,
        shared: bool,
    ) -> Result<Self, EventDrivenError> {
        let EventDrivenCheckpoint {
            state,
            last_contact,
            image_flags,
            tally,
            stalled,
            ledgers,
            rebounds,
            shear_work,
        } = start;
        let count = state.bodies.len();
        let diameter = 2.0 * scene.sizes().largest_radius();
        let pull = scene.field().acceleration().norm();
        let slip = scene.field().shear_rate().abs() * diameter;
        let speed = unit_of_speed(&state, (pull * diameter).sqrt().max(slip));
        let shear_work = begin_balance(shear_work, &scene, which, &state);
        let sizes = scene.sizes();
        let name = |index: usize| which.map_or(index as u32, |which| which[index]);
        let body = |index: usize| {
            let ParticleState {
                position, velocity, ..
            } = state.bodies[index];
            let radius = sizes.radius(sizes.tag_of(name(index) as usize));
            (state.domain.wrap(position), velocity / speed, radius)
        };
        let motion = FlightMotion::new(scene.field(), speed);
        let largest = sizes.largest_radius();
        let options = grid_options::<P>(&boundaries, shared);
        let (disks, order) = DiskSystem::new(&state.domain, largest, count, &body, motion, options);
        let epoch = state.time;
        let units = EngineUnits { speed, epoch };
        let surroundings =
            BoundaryGeometry::new(boundaries, &state.domain, &disks.cells, largest, units);
        let bounded = !surroundings.is_empty();
        // Numbers of walls and obstacles come after those of the disks.
        if count + surroundings.things() >= u32::MAX as usize {
            return Err(EventDrivenError::TooMany { disks: count });
        }
        let ledgers = if ledgers.is_empty() {
            vec![WallLedger::default(); surroundings.boundaries.ledgers()]
        } else {
            ledgers
        };
        let counts = bounded.then(|| counts_by_disk(&rebounds, &order));
        let ages = |&index: &u32| match last_contact.get(index as usize) {
            Some(last) => (last - state.time) * speed,
            None => f64::NEG_INFINITY,
        };
        let last_contact = match dissipation {
            DissipationRule::ContactTime(_) => order.iter().map(ages).collect(),
            _ => Vec::new(),
        };
        let image_flags = image_flags::follow(&state, &image_flags, &order)?;
        let unit = typical_time(&disks, diameter, pull / speed / speed);
        let horizon = restart_horizon(unit, disks.cells.width().max() / diameter);
        let spins = if P::Surface::ROUGH {
            let spin =
                |&index: &u32| converted_spin::<P>(state.bodies[index as usize].spin, 1.0 / speed);
            order.iter().map(spin).collect()
        } else {
            Vec::new()
        };
        let domain = state.domain;
        // Memory released before the following needs as much again.
        drop(state);
        let names: Vec<u32> = order.iter().map(|&index| name(index as usize)).collect();
        let tag = |&name: &u32| scene.sizes().tag_of(name as usize);
        let mut engine = Self {
            tags: names.iter().map(tag).collect(),
            scene,
            dissipation,
            domain,
            calendar: Q::new(&NoEvents, 0.0),
            knows_events: false,
            disks,
            spins,
            names,
            last_contact,
            surroundings: Arc::new(surroundings),
            ledgers,
            image_flags,
            candidates: Candidates::new(),
            speed,
            epoch,
            now: 0.0,
            time: epoch,
            refresh: (tally.collisions).saturating_add(REFRESH * count as u64 + LEAST_REFRESH),
            horizon,
            progress: CollapseDetector::new(tally.contacts().saturating_sub(stalled)),
            unit,
            tally,
            shear_work,
            stale: 0,
            rebounds: counts.unwrap_or_default(),
            stop: Interruption::default(),
            parallel: shared,
            window: None,
        };
        engine.look_at_all();
        engine.tally.pushes += count as u64;
        Ok(engine)
    }

    /// Sets an interrupt that breaks off an advance of the engine, after at most some hundred
    /// events.
    pub fn set_stop_flag(&mut self, interrupt: &Interrupt) {
        self.stop.on(interrupt);
    }

    /// Returns true if an advance was interrupted. The gas is then at some time within the advance,
    /// and the engine advances no further. To get the bytes of a run without interrupt, resume from
    /// the checkpoint before that advance.
    pub fn is_interrupted(&self) -> bool {
        self.stop.has_ended()
    }

    /// Restarts the engine from its current checkpoint, with engine time zero now and disks sorted
    /// in memory.
    pub(crate) fn rebase_epoch(&mut self, until: f64) -> Result<(), EventDrivenError> {
        self.time = self.present(until);
        let (cells, disks) = (self.disks.cells.places(), self.disks.all.len());
        if let Some(crossings) = self.progress.fresh_start(cells, disks) {
            let time = self.time;
            return Err(EventDrivenError::NoCollisions { time, crossings });
        }
        let progress = self.progress.afresh(self.tally.contacts());
        // Two engines at once would take twice the memory.
        self.forget_events();
        let checkpoint = self.checkpoint_in(Order::Memory);
        let names = std::mem::take(&mut self.names);
        let no_disk = |_| (Vector2::zeros(), Vector2::zeros(), 0.0);
        let motion = self.disks.motion;
        self.disks = DiskSystem::new(
            &self.domain,
            1.0,
            0,
            &no_disk,
            motion,
            GridOptions::default(),
        )
        .0;
        let boundaries = self.surroundings.boundaries.clone();
        let scene = self.scene.clone();
        let (stop, parallel, stale) = (self.stop.clone(), self.parallel, self.stale);
        let (dissipation, which) = (self.dissipation, Some(&names[..]));
        *self = Self::from_checkpoint(scene, dissipation, checkpoint, which, boundaries, parallel)?;
        self.progress = progress;
        (self.stop, self.stale) = (stop, stale);
        Ok(())
    }

    /// Returns the absolute time of the last event \[time\], limited to `until`, which rounding
    /// could exceed.
    pub(crate) fn present(&self, until: f64) -> f64 {
        (self.epoch + self.now / self.speed).min(until.max(self.time))
    }

    /// Returns the box at the current time; in a shear flow its periodic images slide.
    pub(crate) fn domain_now(&self) -> Domain<Plane> {
        let mut domain = self.domain;
        domain.advance(self.now / self.speed);
        domain
    }

    /// Returns the energy balance of a shear flow so far; `None` without a flow.
    pub fn shear_work(&self) -> Option<ShearWork> {
        P::Field::SHEARED.then(|| {
            let mut all = self.shear_work;
            let disks = 0..self.names.len() as u32;
            all.kinetic += disks.map(|disk| self.work_of_flight(disk)).sum::<f64>();
            all
        })
    }

    /// Returns the work of the shear flow on a disk in its flight since its clock, in the units of
    /// the state \[energy\].
    #[inline(always)]
    fn work_of_flight(&self, who: u32) -> f64 {
        let mass = self.scene.sizes().mass(self.tags[who as usize]);
        mass * self.disks.work_of_flight(who, self.now) * (self.speed * self.speed)
    }

    /// Adds the work of the shear flow on a disk in its flight since its clock to the energy
    /// balance; called before the disk is moved.
    #[inline(always)]
    pub(crate) fn enter_flight(&mut self, who: u32) {
        if P::Field::SHEARED {
            self.shear_work.kinetic += self.work_of_flight(who);
        }
    }

    /// Returns the state of the gas at the current time: box, positions, velocities and spins.
    pub fn state(&self) -> State<P> {
        self.state_in(Order::State)
    }

    fn state_in(&self, order: Order) -> State<P> {
        let nothing = ParticleState::new(Vector2::zeros(), Vector2::zeros());
        let domain = self.domain_now();
        let body = |disk: usize| {
            let position = self.disks.wrapped_position(disk as u32, self.now);
            let velocity = self.disks.velocity(disk as u32, self.now) * self.speed;
            let mut body = ParticleState::new(domain.wrap(position), velocity);
            body.spin = converted_spin::<P>(self.spin(disk as u32), self.speed);
            body
        };
        State {
            time: self.time,
            domain,
            bodies: self.of_each(self.names.len(), order, nothing, body),
        }
    }

    /// Returns the values `of(disk)` of the first `count` disks as a list in the given order;
    /// `nothing` is a placeholder.
    fn of_each<T: Clone + Send>(
        &self,
        count: usize,
        order: Order,
        nothing: T,
        of: impl Fn(usize) -> T + Sync,
    ) -> Vec<T> {
        let mut all = Vec::new();
        match order {
            Order::Memory => fill(&mut all, count, self.parallel, of),
            Order::State => {
                all.resize(count, nothing);
                for disk in 0..count {
                    all[self.names[disk] as usize] = of(disk);
                }
            }
        }
        all
    }

    /// Returns the state of the gas at the current time and consumes the engine, which takes less
    /// memory than [`EventDrivenEngine::state`].
    pub fn into_state(mut self) -> State<P> {
        self.forget_events();
        self.state()
    }

    /// Empties the event calendar and frees its memory, before other data need it.
    pub(crate) fn forget_events(&mut self) {
        self.calendar = Q::new(&NoEvents, 0.0);
        self.knows_events = false;
    }

    /// Fills the event calendar with the events of all disks, unless it already holds them.
    pub(crate) fn recall_events(&mut self) {
        if self.knows_events {
            return;
        }
        self.knows_events = true;
        // A single disk that flies straight meets no other, however far it flies.
        if self.names.len() > 1 || !self.surroundings.is_empty() || !P::Field::FREE {
            self.calendar = Q::new(&self.disks, self.now);
        }
    }

    /// Returns a checkpoint of the current gas, from which a run resumes to the same bytes.
    pub fn checkpoint(&self) -> EventDrivenCheckpoint<P> {
        self.checkpoint_in(Order::State)
    }

    fn checkpoint_in(&self, order: Order) -> EventDrivenCheckpoint<P> {
        let last = |disk: usize| self.last_contact[disk] / self.speed + self.epoch;
        let winding = |disk: usize| {
            // Where the state wraps a position, the winding follows. Under shear there are none.
            let position = self.disks.wrapped_position(disk as u32, self.now);
            image_flags::add(
                self.image_flags[disk],
                image_flags::wound(&self.domain, position),
            )
        };
        let rebounds = |disk: usize| self.rebounds[disk];
        EventDrivenCheckpoint {
            state: self.state_in(order),
            rebounds: self.of_each(self.rebounds.len(), order, 0, rebounds),
            last_contact: self.of_each(self.last_contact.len(), order, 0.0, last),
            image_flags: self.of_each(self.image_flags.len(), order, [0; 2], winding),
            tally: self.tally,
            stalled: self.progress.stalled(self.tally.contacts()),
            ledgers: self.ledgers.clone(),
            shear_work: self.shear_work().unwrap_or(self.shear_work),
        }
    }

    /// Returns the momentum and energy that walls and obstacles have given to the gas so far: the
    /// faces of the box, lower and upper along the first axis, then along the second, and after
    /// these four the obstacles. Empty without any.
    pub fn ledgers(&self) -> &[WallLedger<Plane>] {
        &self.ledgers
    }

    /// Returns the walls and obstacles of the box, and the random streams of diffuse walls.
    pub fn boundaries(&self) -> &DiskBoundaries {
        &self.surroundings.boundaries
    }

    /// Returns the counters of collisions and other events since the start of the run.
    pub fn tally(&self) -> EventCounters {
        self.tally
    }

    /// Returns the number of stale calendar entries that came up as events: their disk had collided
    /// before. It depends on the calendar, not on the gas.
    pub fn stale(&self) -> u64 {
        self.stale
    }

    /// Returns the absolute time of the gas \[time\].
    pub fn time(&self) -> f64 {
        self.time
    }

    /// Returns the deepest overlap of two disks, or of a disk with a wall or obstacle, at the
    /// current time \[length\]; 0 if none overlap. It costs about as much as predicting the events
    /// of all disks.
    pub fn worst_overlap(&self) -> f64 {
        let mut worst = 0.0_f64;
        for who in 0..self.names.len() as u32 {
            let distance = |other| self.contact_distance(who, other);
            let radius = self.scene.sizes().radius(self.tags[who as usize]);
            worst = worst.max(self.disks.overlap(who, self.now, radius, distance));
            if !self.surroundings.is_empty() {
                let place = self.domain.wrap(self.disks.wrapped_position(who, self.now));
                let inside = self
                    .surroundings
                    .overlap(&self.domain, place, radius, self.now);
                worst = worst.max(inside);
            }
        }
        worst
    }

    /// Returns the memory that the engine occupies \[bytes\].
    pub fn memory_bytes(&self) -> usize {
        self.disks.memory_bytes()
            + self.calendar.memory_bytes()
            + self.surroundings.memory_bytes()
            + self.spins.capacity() * size_of::<SpinOf<P>>()
            + (self.names.capacity() + self.rebounds.capacity()) * 4
            + self.last_contact.capacity() * 8
            + self.image_flags.capacity() * size_of::<ImageFlags>()
            + self.tags.capacity() * size_of::<<P::Sizes as Sizes>::Tag>()
    }

    /// Returns the angular velocity of a disk in engine units; zero for smooth disks.
    #[inline(always)]
    pub(crate) fn spin(&self, who: u32) -> SpinOf<P> {
        if P::Surface::ROUGH {
            self.spins[who as usize]
        } else {
            SpinOf::<P>::default()
        }
    }

    #[inline(always)]
    pub(crate) fn contact_distance(&self, first: u32, second: u32) -> f64 {
        let sizes = self.scene.sizes();
        sizes.radius(self.tags[first as usize]) + sizes.radius(self.tags[second as usize])
    }
}

/// Returns the energy balance of a shear flow at the start of an engine: the energy of the gas
/// counts as supplied, unless the balance has begun before.
fn begin_balance<P: ParticleModel<Space = Plane>>(
    mut work: ShearWork,
    scene: &P,
    which: Option<&[u32]>,
    state: &State<P>,
) -> ShearWork {
    if P::Field::SHEARED && work.supplied.is_none() {
        work.supplied = Some(energy_of(scene, which, state));
    }
    work
}

/// Returns the kinetic energy of all disks, translation and rotation \[energy\]; `which` gives the
/// index in the model of each disk.
fn energy_of<P: ParticleModel<Space = Plane>>(
    scene: &P,
    which: Option<&[u32]>,
    state: &State<P>,
) -> f64 {
    let sizes = scene.sizes();
    let energy = |(index, body): (usize, &ParticleState<P>)| {
        let tag = sizes.tag_of(which.map_or(index, |which| which[index] as usize));
        let (mass, radius) = (sizes.mass(tag), sizes.radius(tag));
        let spinning = scene.surface().spin_energy(mass, radius, body.spin);
        0.5 * mass * body.velocity.norm_squared() + spinning
    };
    state.bodies.iter().enumerate().map(energy).sum()
}

/// Returns the engine unit of speed: a power of two near the largest speed component of the disks,
/// or near the speed `to_come` that they will reach.
fn unit_of_speed<P: ParticleModel<Space = Plane>>(state: &State<P>, to_come: f64) -> f64 {
    let fastest = (state.bodies.iter())
        .map(|body| body.velocity.amax())
        .fold(to_come, f64::max);
    if fastest > 0.0 {
        2.0_f64.powi((fastest.log2().floor() as i32).clamp(-1000, 1000))
    } else {
        1.0
    }
}

fn grid_options<P: ParticleModel>(boundaries: &DiskBoundaries, shared: bool) -> GridOptions {
    GridOptions {
        unequal: !P::Sizes::UNIFORM,
        may_be_wide: boundaries.obstacles.is_empty(),
        shared,
    }
}

/// Returns the engine time in which a typical disk flies, or falls, by its diameter; zero if none
/// moves.
fn typical_time<F: Field<Plane>>(disks: &DiskSystem<F>, diameter: f64, pull: f64) -> f64 {
    let squares = disks.all.iter().map(|disk| disk.velocity.norm_squared());
    let mean = squares.sum::<f64>() / disks.all.len().max(1) as f64;
    let unit = diameter / mean.max(pull * diameter).sqrt();
    if unit.is_finite() { unit } else { 0.0 }
}

/// Returns the engine time at which an engine restarts at the latest; infinite if no disk moves.
/// `cell` is the width of a cell in diameters.
fn restart_horizon(unit: f64, cell: f64) -> f64 {
    if unit > 0.0 {
        HORIZON.max(HORIZON_CELLS * cell) * unit
    } else {
        f64::INFINITY
    }
}

/// Returns the counts of contacts with walls in the engine's order of disks, from those in the
/// order of the state; zeros if there are none.
fn counts_by_disk(counts: &[u32], names: &[u32]) -> Vec<u32> {
    let count = |&name: &u32| counts.get(name as usize).copied().unwrap_or(0);
    names.iter().map(count).collect()
}

/// Returns an angular velocity converted to another unit, by a factor.
fn converted_spin<P: ParticleModel<Space = Plane>>(spin: SpinOf<P>, factor: f64) -> SpinOf<P> {
    <P::Surface as Surface<Plane>>::scale_spin(spin, factor)
}

/// Source of event times without any disk: an empty calendar is made from it.
struct NoEvents;

impl EventTimes for NoEvents {
    fn disks(&self) -> u32 {
        0
    }
    fn time(&self, _disk: u32) -> f64 {
        f64::INFINITY
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::vector;
    use stosszahl_model::samples::law;
    use stosszahl_model::walls::{Face, Wall, Walls};
    use stosszahl_model::{Free, Polydisperse, Rough, Scene};

    use super::*;

    /// A fresh start is a new engine from the checkpoint, though it does not take the disks in the
    /// order of the state: unequal rough disks between walls, with image flags and times of last
    /// contact.
    #[test]
    fn a_fresh_start_is_a_new_engine() {
        const SIDE: u32 = 60;
        // A large disk in every sixth row and column, and none next to it.
        let sites = (0..SIDE * SIDE).filter_map(|site| {
            let (x, y) = (site % SIDE, site / SIDE);
            let from_large = [x % 6, y % 6]
                .map(|step| step.abs_diff(3))
                .into_iter()
                .max();
            let radius = match from_large {
                Some(0) => 1.3,
                Some(1) => return None,
                _ => 0.3 + 0.2 * f64::from(site).sin().abs(),
            };
            let place = vector![f64::from(x), f64::from(y)].add_scalar(0.5) * 1.2;
            let angle = f64::from(site) * f64::from(site);
            let mut body = ParticleState::new(place, vector![angle.sin(), angle.cos()]);
            body.spin = vector![angle.sin()];
            Some((body, (radius, radius * radius)))
        });
        let (bodies, sizes): (Vec<_>, Vec<_>) = sites.unzip();
        let surface = Rough::new(0.3, 0.5).expect("a surface");
        let sizes = Polydisperse::new(sizes).expect("sizes");
        let scene = Scene::<Plane, _, _, _, _>::new(surface, law(0.9), sizes, Free);
        let wall = || Face::Wall(Wall::specular());
        let faces = [[Face::Periodic, Face::Periodic], [wall(), wall()]];
        let boundaries = DiskBoundaries {
            walls: Walls::new(&faces).expect("walls"),
            ..DiskBoundaries::periodic()
        };
        let length = 1.2 * f64::from(SIDE);
        let state = State {
            time: 0.0,
            domain: boundaries
                .walls
                .domain(vector![length, length])
                .expect("a box"),
            bodies,
        };
        let start = EventDrivenCheckpoint {
            image_flags: vec![[0; 2]; state.bodies.len()],
            ..EventDrivenCheckpoint::from(state)
        };
        let dissipation = DissipationRule::ContactTime(1e-3);
        let engine = |start| {
            EventDrivenEngine::<_>::between(scene.clone(), dissipation, start, &boundaries)
                .expect("an engine")
        };
        for parallel in [false, true] {
            let mut old = engine(start.clone());
            let disordered = old.advance(f64::INFINITY, 50_000, &mut ());
            assert!(!disordered.expect("time"));
            old.parallel = parallel;
            let new = engine(old.checkpoint());
            let names = old.names.clone();
            old.rebase_epoch(f64::INFINITY).expect("a fresh start");
            assert_ne!(old.names, names);
            assert_eq!(old.names, new.names);
            assert_eq!(old.tags, new.tags);
            assert_eq!(old.tally, new.tally);
            let each = |engine: &EventDrivenEngine<_>| {
                let (spins, last) = (&engine.spins, &engine.last_contact);
                let (rebounds, image_flags) = (&engine.rebounds, &engine.image_flags);
                let (disks, levels) = (&engine.disks.all, &engine.disks.levels);
                format!("{disks:?} {levels:?} {spins:?} {last:?} {rebounds:?} {image_flags:?}")
            };
            assert!(each(&old) == each(&new));
            assert!(old.disks.hierarchical());
            assert!(old.rebounds.iter().any(|&count| count > 0));
            assert!(old.image_flags.iter().any(|winding| winding[0] != 0));
        }
    }
}
