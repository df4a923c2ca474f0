//! Event-driven simulation behind the common interface `Simulation`, for any particles of the
//! model, chosen at run time.

use std::borrow::Cow;
use std::sync::OnceLock;

use nalgebra::{Vector2, Vector3, vector};
use stosszahl_model::interrupt::Interruption;
use stosszahl_model::simulation::in_slices;
use stosszahl_model::{
    BoundaryFlux, Budget, Failure, Field, Interrupt, InvalidValue, Observer, Particle,
    ParticleModel, ParticleSpec, ParticleState, Particles, Plane, RecentContacts, Shear,
    Simulation, SizeDistribution, Sizes, Smooth, State, Surface, Vector as _, VelocityMoments,
    WorkCounters,
};

use crate::checkpoint::{DissipationRule, EventCounters, EventDrivenCheckpoint};
use crate::engine::EventDrivenEngine;
use crate::error::EventDrivenError;
use crate::strips::{StripSettings, StripedEngine};
use crate::surroundings::DiskBoundaries;

/// Collisions per disk in one leg of a run, the segment that one engine simulates. A new leg costs
/// about as much as a tenth of a collision per disk. A run that resumes within a leg repeats up to
/// that many.
const LEG: u64 = 4;
/// Least number of collisions in one leg of a run, the segment that one engine simulates.
const LEAST_LEG: u64 = 100_000;

/// Number of disks per thread from which one more thread pays.
const EACH_THREAD: usize = 20_000;

/// Returns the number of strips into which [`Simulation::use_threads`] cuts a gas of `disks` disks,
/// each for a thread: fewer where that does not pay.
pub fn strips_for(threads: usize, disks: usize) -> usize {
    threads.min(disks / EACH_THREAD)
}

/// Starts an event-driven simulation of disks from particles at given positions and velocities.
///
/// ```
/// use stosszahl_ed::{DiskBoundaries, DissipationRule, simulate};
/// use stosszahl_model::{Budget, Constant, ParticleSpec, Particles, Simulation};
/// # fn particles() -> Particles {
/// #     use stosszahl_model::{Particle, Vector};
/// #     let at = |x: f64, v: f64| Particle {
/// #         position: nalgebra::vector![x, 5.0, 0.0], velocity: nalgebra::vector![v, 0.0, 0.0],
/// #         ..Particle::at_rest(0.5, 1.0)
/// #     };
/// #     Particles { time: 0.0, dimension: 2, lengths: [10.0, 10.0, 0.0], periodic: [true; 3],
/// #         all: vec![at(2.0, 1.0), at(6.0, -1.0)] }
/// # }
///
/// let grains = ParticleSpec::equal(0.5, 1.0, Constant::new(0.5)?);
/// let boundaries = DiskBoundaries::periodic();
/// let mut gas = simulate(&grains, DissipationRule::Scene, &boundaries, &particles())?;
/// gas.advance(2.0, Budget::Unlimited, &mut ())?;
/// assert_eq!(gas.work_counters().collisions, 1);
/// assert!((gas.temperature() - 0.5 * 0.25).abs() < 1e-15);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`EventDrivenError`] if grains, boundaries and particles do not go together, or particles
/// overlap; [`EventDrivenError::NoShear`] and [`EventDrivenError::NoRough`] without the features
/// `shear` and `rough`.
pub fn simulate(
    grains: &ParticleSpec,
    dissipation: DissipationRule,
    boundaries: &DiskBoundaries,
    start: &Particles,
) -> Result<Box<dyn Simulation>, EventDrivenError> {
    let begin = EngineBuilder {
        dissipation,
        boundaries,
        shear: grains.shear(),
        from: Source::Start(start),
    };
    begin.choose(grains, start.all.len())
}

/// Resumes an event-driven simulation from the bytes of [`Simulation::save_checkpoint`]; all other
/// arguments must be as at the start. The last collisions before it, up to four of each disk or 100
/// 000 in all, are repeated, which the interrupt can break off.
///
/// # Errors
/// As [`simulate`]; and [`EventDrivenError::Checkpoint`] if the bytes are none of this engine.
pub fn resume(
    grains: &ParticleSpec,
    count: usize,
    dissipation: DissipationRule,
    boundaries: &DiskBoundaries,
    checkpoint: &[u8],
    interrupt: &Interrupt,
) -> Result<Box<dyn Simulation>, EventDrivenError> {
    let begin = EngineBuilder {
        dissipation,
        boundaries,
        shear: grains.shear(),
        from: Source::Checkpoint(checkpoint, interrupt),
    };
    begin.choose(grains, count)
}

/// Origin of the gas for a new engine: initial particles, or the bytes of a checkpoint.
enum Source<'a> {
    Start(&'a Particles),
    Checkpoint(&'a [u8], &'a Interrupt),
}

/// Builder of an event-driven engine, whose type is chosen by sizes, roughness and field of the
/// particles.
struct EngineBuilder<'a> {
    dissipation: DissipationRule,
    boundaries: &'a DiskBoundaries,
    /// Shear flow of the gas with its state at time 0; `None` without shear.
    shear: Option<Shear>,
    from: Source<'a>,
}

impl EngineBuilder<'_> {
    /// Chooses the type of the engine: sizes and roughness of disks decide which data are stored
    /// for a disk.
    fn choose(
        self,
        grains: &ParticleSpec,
        count: usize,
    ) -> Result<Box<dyn Simulation>, EventDrivenError> {
        if grains.rough.is_some() && !cfg!(feature = "rough") {
            return Err(EventDrivenError::NoRough);
        }
        if grains.shear_rate.is_some() {
            return self.in_shear_flow(grains, count);
        }
        match (&grains.sizes, grains.rough) {
            (SizeDistribution::Equal(sizes), _) if grains.is_plain() => {
                self.begin_engine(grains.plain(*sizes))
            }
            (SizeDistribution::Each(sizes), _) if grains.is_plain() => {
                self.begin_engine(grains.plain(sizes.clone()))
            }
            (_, Some(rough)) if cfg!(feature = "rough") => {
                self.begin_engine(grains.scene(rough, count)?)
            }
            _ => self.begin_engine(grains.scene(Smooth, count)?),
        }
    }

    /// Creates the engine for a uniform shear flow, with the type that the sizes and roughness of
    /// disks need.
    fn in_shear_flow(
        self,
        grains: &ParticleSpec,
        count: usize,
    ) -> Result<Box<dyn Simulation>, EventDrivenError> {
        if !cfg!(feature = "shear") {
            return Err(EventDrivenError::NoShear);
        }
        match (&grains.sizes, grains.rough) {
            (SizeDistribution::Equal(sizes), None) => {
                self.begin_engine(grains.sheared_smooth(*sizes)?)
            }
            (_, Some(rough)) if cfg!(feature = "rough") => {
                self.begin_engine(grains.sheared(rough, count)?)
            }
            _ => self.begin_engine(grains.sheared(Smooth, count)?),
        }
    }

    fn begin_engine<P: ParticleModel<Space = Plane>>(
        self,
        scene: P,
    ) -> Result<Box<dyn Simulation>, EventDrivenError> {
        let (checkpoint, stops, origin) = match self.from {
            Source::Start(start) => {
                let domain = self
                    .boundaries
                    .walls
                    .domain(to_plane(start.lengths.into()))?;
                let domain = domain.in_flow(self.shear, start.time)?;
                let body = |particle: &Particle| ParticleState {
                    position: to_plane(particle.position),
                    velocity: to_plane(particle.velocity),
                    spin: <P::Surface as Surface<Plane>>::spin_of(particle.spin),
                };
                let state = State {
                    time: start.time,
                    domain,
                    bodies: start.all.iter().map(body).collect(),
                };
                // The engine checks the start; the checkpoint before it is what the first leg
                // begins with.
                let checkpoint = EventDrivenCheckpoint::from(state);
                EventDrivenEngine::<P>::between(
                    scene.clone(),
                    self.dissipation,
                    checkpoint.clone(),
                    self.boundaries,
                )?;
                (checkpoint, Vec::new(), Vec::new())
            }
            Source::Checkpoint(bytes, _) => {
                let (gas, stops, origin): Kept<'_, P> = postcard::from_bytes(bytes)?;
                (gas.into_owned(), stops.into_owned(), origin.into_owned())
            }
        };
        let mut gas = Disks {
            scene,
            dissipation: self.dissipation,
            boundaries: self.boundaries.clone(),
            stage: Stage::Between(Box::new(checkpoint)),
            present: OnceLock::new(),
            origin,
            bytes: 0,
            recent: None,
            spread: StripSettings::default(),
            stop: Interruption::default(),
            pause: None,
            collapse: None,
        };
        if let Source::Checkpoint(_, interrupt) = self.from {
            gas.stop.on(interrupt);
            gas.repeat(stops)?;
        }
        Ok(Box::new(gas))
    }
}

/// Returns the x and y components of a three-dimensional vector.
fn to_plane(vector: Vector3<f64>) -> Vector2<f64> {
    vector.xy()
}

/// Event-driven simulation of disks behind the interface [`Simulation`].
///
/// Between legs the gas is a checkpoint, and each leg makes a new engine. Within a leg the engine
/// stops at the requested times. A checkpoint at a stop holds the checkpoint of the beginning of
/// the leg and these times: a run that resumes from it repeats the leg up to there, to the same
/// bytes. The stops have no influence on the trajectory.
struct Disks<P: ParticleModel<Space = Plane>> {
    scene: P,
    dissipation: DissipationRule,
    boundaries: DiskBoundaries,
    stage: Stage<P>,
    /// State of the gas at the last stop of the engine, computed at the first request.
    present: OnceLock<State<P>>,
    /// Position of each disk when the tracking of displacements began \[length\]; empty if not
    /// tracked.
    origin: Vec<Vector2<f64>>,
    bytes: usize,
    /// Latest contacts at the end of the last leg; `None` before that. A leg is the segment of a
    /// run that one engine simulates.
    recent: Option<RecentContacts>,
    spread: StripSettings,
    stop: Interruption,
    pause: Option<Interrupt>,
    /// Error of the inelastic collapse in which the gas ended; `None` once its velocities are
    /// changed.
    collapse: Option<EventDrivenError>,
}

/// Form in which the gas is held: a checkpoint between legs of the run, or a running engine.
enum Stage<P: ParticleModel<Space = Plane>> {
    Between(Box<EventDrivenCheckpoint<P>>),
    Flying(Box<StripedEngine<P>>, Option<Box<Leg<P>>>),
}

/// Segment of a run that one engine simulates: the checkpoint at its begin, and the stops since.
struct Leg<P: ParticleModel> {
    from: EventDrivenCheckpoint<P>,
    /// Times at which the engine has stopped since the checkpoint at the begin of the leg \[time\].
    stops: Vec<f64>,
}

/// Content of a saved checkpoint: the gas at the begin of the leg, the times at which the engine
/// has stopped since \[time\], and the origins of displacements \[length\].
type Kept<'a, P> = (
    Cow<'a, EventDrivenCheckpoint<P>>,
    Cow<'a, [f64]>,
    Cow<'a, [Vector2<f64>]>,
);

impl<P: ParticleModel<Space = Plane>> Disks<P> {
    fn tally(&self) -> EventCounters {
        match &self.stage {
            Stage::Between(gas) => gas.tally,
            Stage::Flying(striped, _) => striped.engine().tally(),
        }
    }

    /// Returns the state of the gas at the current time.
    fn state(&self) -> &State<P> {
        match &self.stage {
            Stage::Between(gas) => &gas.state,
            Stage::Flying(engine, _) => self.present.get_or_init(|| engine.engine().state()),
        }
    }

    /// Replaces the running engine by its checkpoint, which ends a leg of the run, and returns that
    /// checkpoint.
    fn land(&mut self) -> &mut EventDrivenCheckpoint<P> {
        self.present.take();
        if let Stage::Flying(engine, leg) = &mut self.stage {
            *leg = None;
            self.recent = Some(engine.engine().recent_contacts());
            let gas = engine.land();
            self.bytes = engine.memory_bytes();
            self.spread = engine.settings().clone();
            self.stage = Stage::Between(Box::new(gas));
        }
        match &mut self.stage {
            Stage::Between(gas) => gas,
            Stage::Flying(..) => unreachable!("the engine was put aside"),
        }
    }

    /// Creates a running engine from the checkpoint. If `is_leg`, the checkpoint is kept as the
    /// begin of a new leg.
    fn take_off(&mut self, is_leg: bool) -> Result<&mut StripedEngine<P>, EventDrivenError> {
        self.present.take();
        if let Stage::Between(gas) = &mut self.stage {
            let leg = is_leg.then(|| {
                let (from, stops) = ((**gas).clone(), Vec::new());
                Box::new(Leg { from, stops })
            });
            let nowhere = EventDrivenCheckpoint::nowhere(gas);
            let gas = std::mem::replace(&mut **gas, nowhere);
            let (scene, boundaries) = (self.scene.clone(), self.boundaries.clone());
            let (dissipation, spread) = (self.dissipation, self.spread.clone());
            let parallel = spread.strips > 1;
            let engine = EventDrivenEngine::from_checkpoint(
                scene,
                dissipation,
                gas,
                None,
                boundaries,
                parallel,
            )?;
            let engine = StripedEngine::with_settings(engine, spread);
            self.stage = Stage::Flying(Box::new(engine), leg);
        }
        match &mut self.stage {
            Stage::Flying(engine, _) => Ok(engine),
            Stage::Between(_) => unreachable!("the engine was made"),
        }
    }

    /// Returns a checkpoint of the gas at the current time.
    fn now(&self) -> Cow<'_, EventDrivenCheckpoint<P>> {
        match &self.stage {
            Stage::Between(gas) => Cow::Borrowed(&**gas),
            Stage::Flying(engine, _) => Cow::Owned(engine.engine().checkpoint()),
        }
    }

    /// Returns the number of collisions until the current leg of the run ends.
    fn left_of_leg(&mut self) -> u64 {
        let all = (LEG * self.particle_count() as u64).max(LEAST_LEG);
        let now = self.tally().collisions;
        match &self.stage {
            Stage::Flying(_, Some(leg)) => all - (now - leg.from.tally.collisions),
            Stage::Flying(_, None) => {
                self.land();
                all
            }
            Stage::Between(_) => all,
        }
    }

    /// Advances a resumed gas from the checkpoint at the begin of its leg through all `stops`
    /// \[time\], to the same bytes as before.
    fn repeat(&mut self, stops: Vec<f64>) -> Result<(), EventDrivenError> {
        if stops.is_empty() {
            return Ok(());
        }
        let (left, stop) = (self.left_of_leg(), self.stop.clone());
        let engine = self.take_off(true)?;
        engine.set_interruption(stop);
        for &until in &stops {
            engine.advance(until, left, &mut ())?;
        }
        self.stop = engine.engine().stop.clone();
        // Also where an interrupt has come in between: the checkpoint stays what it was.
        if let Stage::Flying(_, Some(leg)) = &mut self.stage {
            leg.stops = stops;
        }
        Ok(())
    }

    /// Advances the gas to the time `until` \[time\] or by the budget of collisions; implements
    /// [`Simulation::advance`].
    fn go(
        &mut self,
        until: f64,
        budget: Budget,
        observer: &mut dyn Observer,
    ) -> Result<bool, EventDrivenError> {
        let left = match budget {
            Budget::Leg => self.left_of_leg(),
            Budget::Collisions(most) => most,
            Budget::Unlimited => u64::MAX,
        };
        let (stop, pause) = (self.stop.clone(), self.pause.clone());
        let engine = self.take_off(budget == Budget::Leg)?;
        engine.set_interruption(stop);
        let reached = in_slices(left, pause.as_ref(), |slice| {
            let reached = engine.advance(until, slice, observer);
            let goes_on = matches!(reached, Ok(false)) && !engine.engine().is_interrupted();
            (reached, goes_on)
        });
        self.stop = engine.engine().stop.clone();
        match (&reached, &mut self.stage) {
            (Ok(_), Stage::Flying(_, leg)) if budget != Budget::Leg => *leg = None,
            (Ok(true), Stage::Flying(_, Some(leg))) => leg.stops.push(until),
            // After an interrupt the run resumes from the checkpoint before.
            (Ok(_), _) if self.stop.has_ended() => {}
            // The state at the end of the leg, or at a failure, becomes the checkpoint.
            _ => drop(self.land()),
        }
        reached
    }

    /// Applies a change of velocities from outside, as a thermostat makes; in a shear flow, adds
    /// the energy supplied to the balance.
    fn drive(&mut self, change: impl FnOnce(&mut [ParticleState<P>])) {
        self.collapse = None;
        let scene = self.scene.clone();
        let gas = self.land();
        let before = P::Field::SHEARED.then(|| gas.state.kinetic_energy(&scene));
        change(&mut gas.state.bodies);
        if let (Some(before), Some(supplied)) = (before, &mut gas.shear_work.supplied) {
            *supplied += gas.state.kinetic_energy(&scene) - before;
        }
    }

    /// Returns the relative error of the energy balance of a shear flow: the error over the sum of
    /// work and dissipation; `None` without a shear flow.
    fn shear_imbalance(&self) -> Option<f64> {
        let work = match &self.stage {
            Stage::Between(gas) => gas.shear_work,
            Stage::Flying(engine, _) => engine.engine().shear_work().unwrap_or_default(),
        };
        P::Field::SHEARED.then(|| {
            let state = self.state();
            let energy = state.kinetic_energy(&self.scene) + state.spin_energy(&self.scene);
            work.imbalance(energy)
        })
    }

    fn show(&self, state: &State<P>, look: &mut dyn FnMut(&Particle)) {
        let (sizes, surface) = (self.scene.sizes(), self.scene.surface());
        for (index, body) in state.bodies.iter().enumerate() {
            let tag = sizes.tag_of(index);
            let (radius, mass) = (sizes.radius(tag), sizes.mass(tag));
            look(&Particle {
                position: body.position.spatial(),
                velocity: body.velocity.spatial(),
                spin: <P::Surface as Surface<Plane>>::spin_in_space(body.spin),
                radius,
                mass,
                spin_energy: surface.spin_energy(mass, radius, body.spin),
                species: sizes.species_of(tag),
                weight: 1.0,
            });
        }
    }
}

impl<P: ParticleModel<Space = Plane>> Simulation for Disks<P> {
    fn time(&self) -> f64 {
        match &self.stage {
            Stage::Between(gas) => gas.state.time,
            Stage::Flying(engine, _) => engine.engine().time(),
        }
    }

    fn dimension(&self) -> usize {
        2
    }

    fn particle_count(&self) -> usize {
        match &self.stage {
            Stage::Between(gas) => gas.state.bodies.len(),
            Stage::Flying(engine, _) => engine.engine().names.len(),
        }
    }

    fn mean_weight(&self) -> f64 {
        1.0
    }

    fn advance(
        &mut self,
        until: f64,
        budget: Budget,
        observer: &mut dyn Observer,
    ) -> Result<bool, Failure> {
        if self.stop.has_ended() {
            return Ok(false);
        }
        let beyond = until > self.time();
        if let Some(collapse) = self.collapse.as_ref().filter(|_| beyond) {
            return Err(Failure::new(collapse.clone()));
        }
        self.go(until, budget, observer).map_err(|error| {
            self.collapse = error.is_collapse().then(|| error.clone());
            Failure::new(error)
        })
    }

    fn set_stop_flag(&mut self, interrupt: &Interrupt) {
        self.stop.on(interrupt);
    }

    fn set_pause_flag(&mut self, pause: &Interrupt) {
        self.pause = Some(pause.clone());
    }

    fn use_threads(&mut self, threads: usize) {
        self.spread.strips = strips_for(threads, self.particle_count());
        if let Stage::Flying(engine, _) = &mut self.stage {
            engine.spread_over(self.spread.strips);
        }
    }

    fn is_interrupted(&self) -> bool {
        self.stop.has_ended()
    }

    fn visit_particles(&self, look: &mut dyn FnMut(&Particle)) {
        self.show(self.state(), look);
    }

    fn velocity_moments(&self) -> VelocityMoments {
        VelocityMoments::of_state(&self.scene, self.state())
    }

    fn particles(&self) -> Particles {
        let domain = self.state().domain;
        let mut all = Vec::with_capacity(self.particle_count());
        self.visit_particles(&mut |particle| all.push(*particle));
        Particles {
            time: self.time(),
            dimension: 2,
            lengths: domain.lengths().spatial().into(),
            periodic: [0, 1, 2].map(|axis| domain.is_periodic(axis)),
            all,
        }
    }

    fn add_velocities(&mut self, changes: &[Vector3<f64>]) -> Result<(), Failure> {
        self.drive(|bodies| {
            for (body, change) in bodies.iter_mut().zip(changes) {
                body.velocity += to_plane(*change);
            }
        });
        Ok(())
    }

    fn scale_velocities(&mut self, factor: f64) -> Result<(), Failure> {
        InvalidValue::unless_positive("factor of all velocities", factor).map_err(Failure::new)?;
        self.drive(|bodies| {
            for body in bodies {
                body.velocity *= factor;
            }
        });
        Ok(())
    }

    fn save_checkpoint(&self) -> Result<Vec<u8>, Failure> {
        let (gas, stops) = match &self.stage {
            Stage::Flying(_, Some(leg)) => (Cow::Borrowed(&leg.from), &leg.stops[..]),
            _ => (self.now(), &[][..]),
        };
        let kept: Kept<'_, P> = (gas, stops.into(), (&self.origin).into());
        postcard::to_stdvec(&kept).map_err(Failure::new)
    }

    fn work_counters(&self) -> WorkCounters {
        let tally = self.tally();
        let each = |count: u64| count as f64 / tally.collisions.max(1) as f64;
        let numbers = [
            ("predictions_per_collision", each(tally.predictions)),
            ("calendar_pushes_per_collision", each(tally.pushes)),
            ("cell_crossings_per_collision", each(tally.crossings)),
            ("broken_contacts_per_collision", each(tally.broken)),
            (
                "share_of_collisions_made_elastic",
                each(tally.elastic_contacts),
            ),
        ];
        let flow = self.shear_imbalance();
        let flow = flow.map(|imbalance| ("shear_energy_imbalance", imbalance));
        let numbers = numbers.into_iter().chain(flow);
        WorkCounters {
            collisions: tally.collisions,
            numbers: numbers
                .map(|(name, number)| (name.to_owned(), number))
                .collect(),
        }
    }

    fn recent_contacts(&self) -> Option<RecentContacts> {
        match &self.stage {
            Stage::Between(_) => self.recent.clone(),
            Stage::Flying(engine, _) => Some(engine.engine().recent_contacts()),
        }
    }

    fn memory_bytes(&self) -> usize {
        match &self.stage {
            Stage::Between(_) => self.bytes,
            Stage::Flying(engine, leg) => {
                engine.memory_bytes() + leg.as_ref().map_or(0, |leg| leg.from.memory_bytes())
            }
        }
    }

    fn track_displacements(&mut self) -> bool {
        // Displacements would include the flow.
        if P::Field::SHEARED {
            return false;
        }
        let gas = self.land();
        gas.image_flags = vec![[0; 2]; gas.state.bodies.len()];
        self.origin = gas.state.bodies.iter().map(|body| body.position).collect();
        true
    }

    fn displacements(&self) -> Option<Vec<Vector3<f64>>> {
        if self.origin.is_empty() {
            return None;
        }
        let gas = self.now();
        let sides = gas.state.domain.lengths();
        let disks = gas
            .state
            .bodies
            .iter()
            .zip(&gas.image_flags)
            .zip(&self.origin);
        let way = |((body, winding), origin): ((&ParticleState<P>, &[i32; 2]), &Vector2<f64>)| {
            let turns = vector![f64::from(winding[0]), f64::from(winding[1])];
            (body.position - origin + turns.component_mul(&sides)).spatial()
        };
        Some(disks.map(way).collect())
    }

    fn boundary_fluxes(&self) -> Vec<BoundaryFlux> {
        let ledgers = match &self.stage {
            Stage::Between(gas) => &gas.ledgers[..],
            Stage::Flying(engine, _) => engine.engine().ledgers(),
        };
        let faces = stosszahl_model::walls::FACES.iter().take(2).flatten();
        let names = faces
            .map(|name| (*name).to_owned())
            .chain((1..).map(|number| format!("obstacle {number}")));
        let touched = names
            .zip(ledgers)
            .filter(|(_, ledger)| ledger.contacts > 0.0);
        touched
            .map(|(name, ledger)| BoundaryFlux::of_ledger(name, ledger))
            .collect()
    }
}
