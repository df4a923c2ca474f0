//! Initial state of a replica, shared by all engines: random or lattice placement, velocities, and
//! elastic equilibration.

pub(crate) mod error;
mod places;
pub(crate) mod stream;

use nalgebra::{Vector2, Vector3};
use rand::Rng;
use rand::seq::SliceRandom;
use serde::{Deserialize, Serialize};
use stosszahl_analysis::equilibrium::{self, EquilibriumTest};
use stosszahl_case::format::{PlacementSpec, VelocitiesSpec};
use stosszahl_ed::DissipationRule;
use stosszahl_model::initial::{self, Arrangement};
use stosszahl_model::random::{Purpose, Streams};
use stosszahl_model::{
    Budget, Collision, Domain, Free, Interrupt, Law, Observer, Particle, ParticleSpec,
    ParticleState, Particles, Plane, Polydisperse, Rough, Scene, Simulation, SizeDistribution,
    Sizes as _, Smooth, Space, State, Surface, Vector as _, Volume,
};

use crate::control::Content;
use crate::plan::{CasePlan, Confinement, threads_each};
use crate::start::places::StartSpace;

pub use error::{PlacementFailed, StartError};

/// Number of bins in the test for uniform impact parameters.
const BINS: usize = 20;
/// Number of collisions per bin that the test of impact parameters needs.
const COLLISIONS_PER_BIN: u64 = 1000;
/// Number of collisions per particle in one segment of the equilibration, between checkpoints.
const LEG: u64 = 4;
/// Smallest number of collisions in one segment of the equilibration.
const LEAST_LEG: u64 = 100_000;
/// Deepest overlap of disks that counts as rounding \[diameters\].
const OVERLAP_TOLERANCE: f64 = 1e-9;
/// Branch of the random streams for the second and further sets of simulators.
const SETS: u64 = 3;

/// Report on the placement and equilibration of a start.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct StartReport {
    /// Method of placement in words.
    pub placement: String,
    /// Number of elastic collisions per particle in the equilibration.
    pub collisions_per_particle: f64,
    /// True if the requested collisions happened, at least one, and no test failed; `None` if the
    /// case gives the start.
    pub equilibrated: Option<bool>,
    /// Outcomes of the equilibration tests on the last block of collisions.
    pub tests: Vec<EquilibriumTest>,
}

/// Start in preparation: state of the equilibration, as stored in a checkpoint.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Preparation {
    /// Checkpoint bytes of the elastic dynamics, between two segments.
    #[serde(with = "serde_bytes")]
    gas: Vec<u8>,
    collisions: u64,
    bins: Vec<u64>,
    /// Time of the start \[engine time\], and true if the requested collisions have happened;
    /// `None` while collisions are still counted.
    end: Option<(f64, bool)>,
    /// Bragg peaks, as reciprocal indices, of the lattice that must melt.
    reciprocal: Vec<[i32; 2]>,
    placement: String,
    /// Report of the finished start; `None` before it is finished.
    report: Option<StartReport>,
}

/// Histogram of impact parameters |b|/d over the collisions of the equilibration.
struct Histogram<'a>(&'a mut [u64]);

impl Observer for Histogram<'_> {
    fn on_collisions(&mut self, batch: &[Collision]) {
        for collision in batch {
            let bin = (collision.impact_square().sqrt() * BINS as f64) as usize;
            self.0[bin.min(BINS - 1)] += 1;
        }
    }
}

/// Creates the initial state of a set of simulators, not equilibrated: particles, reciprocal
/// indices of the lattice, and method of placement. Set 0 is also the start of exact dynamics.
///
/// # Errors
/// [`StartError`] if the state cannot be made.
pub fn placed(
    plan: &CasePlan,
    set: u64,
    streams: Streams,
    interrupt: &Interrupt,
) -> Result<(Particles, Vec<[i32; 2]>, String), StartError> {
    let streams = streams_of(set, streams);
    match (plan.gas.dimension, plan.gas.particles.rough) {
        (2, None) => by_surface::<Plane, _>(plan, Smooth, set, streams, interrupt),
        (2, Some(rough)) => by_surface::<Plane, Rough>(plan, rough, set, streams, interrupt),
        (_, None) => by_surface::<Volume, _>(plan, Smooth, set, streams, interrupt),
        (_, Some(rough)) => by_surface::<Volume, Rough>(plan, rough, set, streams, interrupt),
    }
    .map_err(|error| error.in_units(plan))
}

/// Random streams of a set of simulators.
fn streams_of(set: u64, streams: Streams) -> Streams {
    match set {
        0 => streams,
        _ => streams.branch(SETS).branch(set),
    }
}

/// Particle model with individual sizes, from which velocities are drawn.
type Each<S, C> = Scene<S, C, Law, Polydisperse, Free>;

fn scene<S: Space, C: Surface<S>>(plan: &CasePlan, surface: C) -> Result<Each<S, C>, StartError> {
    Ok(Scene {
        space: S::default(),
        surface,
        restitution: Law::ELASTIC,
        sizes: Polydisperse::new(plan.radii_and_masses())?,
        field: Free,
    })
}

fn by_surface<S: Space, C: Surface<S>>(
    plan: &CasePlan,
    surface: C,
    set: u64,
    streams: Streams,
    interrupt: &Interrupt,
) -> Result<(Particles, Vec<[i32; 2]>, String), StartError> {
    let scene = scene(plan, surface)?;
    let confinement = Confinement::<S>::from_plan(plan)?;
    let domain = confinement.domain;
    let count = if plan.case.start.empty {
        0
    } else {
        plan.count()
    };
    let radius = |index: usize| scene.sizes.radius(scene.sizes.tag_of(index));
    let given = plan
        .gas
        .file
        .as_ref()
        .and_then(|file| file.positions.as_ref());
    let (positions, reciprocal, placement) = if let Some(given) = given {
        let places = given.iter().map(|at| S::from_components(|axis| at[axis]));
        (places.collect(), Vec::new(), "file".to_owned())
    } else if plan.is_disk_fluid() && plan.region().is_none() {
        let (places, reciprocal, name) = in_plane(plan, streams, radius, interrupt)?;
        let places = places
            .into_iter()
            .map(|at| S::from_components(|axis| at[axis]));
        (places.map(|at| domain.wrap(at)).collect(), reciprocal, name)
    } else {
        let space = StartSpace::from_plan(plan, &confinement);
        let mut stream = streams.stream_at(Purpose::Placement, [0, 0]);
        let mut places = vec![S::Vector::default(); count];
        let mut look = |index: usize, at| places[index] = at;
        space.place_all(count, &radius, &mut stream, interrupt, &mut look)?;
        (
            places,
            Vec::new(),
            match plan.region() {
                Some(_) => "at random in a region".to_owned(),
                None => "at random".to_owned(),
            },
        )
    };
    let body = |at| ParticleState::new(at, <S::Vector as Default>::default());
    let mut state: State<Each<S, C>> = State {
        time: 0.0,
        domain,
        bodies: positions.into_iter().map(body).collect(),
    };
    if set == 0 && plan.draws_after_equilibration() {
        let mut stream = streams.stream_at(Purpose::Velocities, [0, 0]);
        initial::maxwellian(&scene, &mut state, plan.gas.temperature, &mut stream);
    } else {
        velocities(plan, &scene, &mut state, streams, 0);
    }
    Ok((particles(plan, &scene, &state), reciprocal, placement))
}

/// Sets the initial velocities and spins: values of the start file, or drawn ones. `draw` is the
/// number of the draw in a replica.
fn velocities<S: Space, C: Surface<S>>(
    plan: &CasePlan,
    scene: &Each<S, C>,
    state: &mut State<Each<S, C>>,
    streams: Streams,
    draw: u64,
) {
    let start = &plan.case.start;
    let stream = |purpose| streams.stream_at(purpose, [draw, 0]);
    if let Some(file) = plan
        .gas
        .file
        .as_ref()
        .filter(|_| start.velocities == VelocitiesSpec::FILE)
    {
        let order = order(plan, &mut stream(Purpose::Velocities));
        let place = |index: usize| order.as_ref().map_or(index, |order| order[index]);
        for (index, body) in state.bodies.iter_mut().enumerate() {
            let of = |list: Option<&Vec<Vector3<f64>>>| {
                let found = list.and_then(|list| list.get(place(index)));
                found.copied().unwrap_or_default()
            };
            let velocity = of(file.velocities.as_ref());
            body.velocity = S::from_components(|axis| velocity[axis]);
            body.spin = <C as Surface<S>>::spin_of(of(file.spins.as_ref()));
        }
        if let Some(spins) = start.spin_temperature {
            initial::thermal_spins(scene, state, spins, &mut stream(Purpose::Spins));
        }
        return;
    }
    let law = plan.gas.velocities;
    let mut own = stream(Purpose::Velocities);
    initial::draw_velocities(scene, state, plan.gas.temperature, law, &mut own);
    if let Some(drift) = &start.velocity {
        for body in &mut state.bodies {
            body.velocity += S::from_components(|axis| drift[axis]);
        }
    }
    let spins = start.spin_temperature.unwrap_or(plan.gas.temperature);
    initial::thermal_spins(scene, state, spins, &mut stream(Purpose::Spins));
}

/// Draws a random assignment of the file's velocities to particles of their species; `None` if
/// particles keep their own.
fn order(plan: &CasePlan, stream: &mut impl Rng) -> Option<Vec<usize>> {
    if plan.case.start.placement == PlacementSpec::File {
        return None;
    }
    let mut order: Vec<usize> = (0..plan.count()).collect();
    let mut rest = &mut order[..];
    for species in &plan.gas.species {
        let (own, others) = std::mem::take(&mut rest).split_at_mut(species.count);
        own.shuffle(stream);
        rest = others;
    }
    Some(order)
}

/// Replaces the velocities of equilibrated disks by the initial ones of the case, which
/// equilibration has changed.
fn with_initial_velocities<C: Surface<Plane>>(
    plan: &CasePlan,
    surface: C,
    equilibrated: &Particles,
    streams: Streams,
) -> Result<Particles, StartError> {
    let scene = scene::<Plane, C>(plan, surface)?;
    let body = |one: &Particle| ParticleState::new(one.position.xy(), Vector2::zeros());
    let mut state: State<Each<Plane, C>> = State {
        time: 0.0,
        domain: Confinement::<Plane>::from_plan(plan)?.domain,
        bodies: equilibrated.all.iter().map(body).collect(),
    };
    velocities(plan, &scene, &mut state, streams, 1);
    Ok(particles(plan, &scene, &state))
}

/// Placed disks in a periodic box: positions, reciprocal indices of the lattice that must melt, and
/// name of the arrangement.
type Placed = (Vec<Vector2<f64>>, Vec<[i32; 2]>, String);

fn in_plane(
    plan: &CasePlan,
    streams: Streams,
    radius: impl Fn(usize) -> f64,
    interrupt: &Interrupt,
) -> Result<Placed, StartError> {
    let domain = Domain::<Plane>::periodic([plan.gas.lengths[0], plan.gas.lengths[1]].into())?;
    let (placement, name) = match plan.arrangement() {
        Some(_) if matches!(plan.gas.particles.sizes, SizeDistribution::Each(_)) => {
            let radii: Vec<f64> = (0..plan.count()).map(&radius).collect();
            let placement = initial::place_unequal(&radii, &domain, &streams, interrupt)?;
            (placement, "disordered, large particles first".to_owned())
        }
        arrangement => {
            let arrangement = arrangement.unwrap_or(Arrangement::Disordered);
            let (count, diameter) = (plan.count(), 2.0 * radius(0));
            let placement =
                initial::place_disks(arrangement, count, diameter, &domain, &streams, interrupt)?;
            let molten = arrangement == Arrangement::Disordered && !placement.reciprocal.is_empty();
            let name = format!("{arrangement:?}").to_lowercase();
            (
                placement,
                if molten {
                    "molten hexagonal lattice".to_owned()
                } else {
                    name
                },
            )
        }
    };
    let overlap = initial::first_overlap(&placement.positions, &radius, &domain, OVERLAP_TOLERANCE);
    if let Some(initial::Overlap { pair, depth }) = overlap {
        return Err(StartError::Overlap { pair, depth });
    }
    Ok((placement.positions, placement.reciprocal, name))
}

impl CasePlan {
    /// Returns the lattice or random arrangement in which particles are placed; `None` with a start
    /// file.
    pub fn arrangement(&self) -> Option<Arrangement> {
        match self.case.start.placement {
            PlacementSpec::Disordered => Some(Arrangement::Disordered),
            PlacementSpec::Square => Some(Arrangement::Square),
            PlacementSpec::Hexagonal => Some(Arrangement::Hexagonal),
            PlacementSpec::File => None,
        }
    }
}

/// Converts the state of a particle model to particles of the common interface.
fn particles<S: Space, C: Surface<S>>(
    plan: &CasePlan,
    scene: &Each<S, C>,
    state: &State<Each<S, C>>,
) -> Particles {
    let particle = |(index, body): (usize, &ParticleState<Each<S, C>>)| {
        let (radius, mass) = scene.sizes.pairs()[index];
        Particle {
            position: body.position.spatial(),
            velocity: body.velocity.spatial(),
            spin: <C as Surface<S>>::spin_in_space(body.spin),
            spin_energy: scene.surface.spin_energy(mass, radius, body.spin),
            species: plan.species_of(index) as u32,
            ..Particle::at_rest(radius, mass)
        }
    };
    Particles {
        time: state.time,
        dimension: S::DIMENSION,
        lengths: plan.gas.lengths,
        periodic: [0, 1, 2].map(|axis| state.domain.is_periodic(axis)),
        all: state.bodies.iter().enumerate().map(particle).collect(),
    }
}

/// Returns the particle properties without shear, as equilibration is at rest and shear starts
/// after it. A start whose periodic images are displaced already is not equilibrated and keeps its
/// shear.
fn at_rest(plan: &CasePlan) -> ParticleSpec {
    let has_begun = plan.gas.particles.shear_offset != 0.0;
    ParticleSpec {
        shear_rate: plan.gas.particles.shear_rate.filter(|_| has_begun),
        ..plan.gas.particles.clone()
    }
}

/// Rescales the velocities of smooth disks to the initial temperature, without drift.
fn rescale(plan: &CasePlan, all: &mut Particles) -> Result<(), StartError> {
    let scene = scene::<Plane, Smooth>(plan, Smooth)?;
    let body = |one: &Particle| ParticleState::new(one.position.xy(), one.velocity.xy());
    let mut state: State<Each<Plane, Smooth>> = State {
        time: 0.0,
        domain: Domain::periodic([plan.gas.lengths[0], plan.gas.lengths[1]].into())?,
        bodies: all.all.iter().map(body).collect(),
    };
    initial::rescale(&scene, &mut state, plan.gas.temperature);
    for (particle, body) in all.all.iter_mut().zip(&state.bodies) {
        particle.velocity = body.velocity.spatial();
    }
    Ok(())
}

impl Content for Preparation {}

impl Preparation {
    /// Begins the start of a replica by placing its particles.
    ///
    /// # Errors
    /// [`StartError`] if particles do not fit, or on interruption.
    pub fn new(
        plan: &CasePlan,
        streams: Streams,
        interrupt: &Interrupt,
    ) -> Result<Self, StartError> {
        let (particles, reciprocal, placement) = placed(plan, 0, streams, interrupt)?;
        let boundaries = plan.exact_boundaries(streams)?;
        let gas = stosszahl_ed::simulate(
            &at_rest(plan),
            DissipationRule::Elastic,
            &boundaries,
            &particles,
        );
        let gas = gas.map_err(|error| StartError::from(error).in_units(plan))?;
        Ok(Self {
            gas: gas.save_checkpoint()?,
            collisions: 0,
            bins: vec![0; BINS],
            end: None,
            reciprocal,
            placement,
            report: None,
        })
    }

    /// Returns the report of the finished start; `None` before it is finished.
    pub fn report(&self) -> Option<&StartReport> {
        self.report.as_ref()
    }

    /// Returns the fraction of the longest equilibration that is done.
    pub fn done_share(&self, plan: &CasePlan) -> f64 {
        self.collisions as f64 / pairs(plan, plan.longest_equilibration()).max(1) as f64
    }

    /// Equilibrates for one segment, in blocks. The end is reached when the requested collisions
    /// have happened and no test fails, or at the longest equilibration. Returns `true` when
    /// finished. A segment is a function of the preparation before it.
    ///
    /// # Errors
    /// [`StartError`] if elastic dynamics cannot continue; [`StartError::Interrupted`] leaves the
    /// preparation unchanged.
    pub fn leg(
        &mut self,
        plan: &CasePlan,
        streams: Streams,
        interrupt: &Interrupt,
    ) -> Result<bool, StartError> {
        let asked = pairs(plan, plan.equilibration());
        let most = pairs(plan, plan.longest_equilibration()).max(asked);
        // The last half of the requested collisions is tested, or more if that is too few for the
        // test.
        let block = (asked / 2).max(BINS as u64 * COLLISIONS_PER_BIN);
        if self.report.is_some() {
            return Ok(true);
        }
        let done = self.collisions;
        let in_block: u64 = self.bins.iter().sum();
        // Blocks end at multiples of their length after the first half of the requested collisions.
        let first = asked.saturating_sub(block);
        let target = if done < first {
            first
        } else {
            done + block.saturating_sub(in_block)
        };
        let target = if asked == 0 { 0 } else { target.min(most) };
        let mut gas = self.gas(plan, streams)?;
        gas.set_stop_flag(interrupt);
        gas.use_threads(threads_each(plan.case.replicas as usize));
        let leg = (LEG * plan.count() as u64).max(LEAST_LEG);
        if self.end.is_none() && done < target {
            let leg = leg.min(target - done);
            // Time in which theory expects a hundred collisions per particle: a gas in which
            // nothing collides in that time has nothing to forget.
            let horizon = gas.time() + 100.0 / plan.collision_rate();
            let mut bins = self.bins.clone();
            let (mut histogram, mut no_observer) = (Histogram(&mut bins), ());
            let counted = done >= first;
            let observer: &mut dyn Observer = if counted {
                &mut histogram
            } else {
                &mut no_observer
            };
            gas.advance(horizon, Budget::Collisions(leg), observer)
                .map_err(|failure| plan.told(failure))?;
            if gas.is_interrupted() {
                return Err(StartError::Interrupted);
            }
            self.bins = bins;
            self.gas = gas.save_checkpoint()?;
            self.collisions = gas.work_counters().collisions;
            if self.collisions > done {
                return Ok(false);
            }
        }
        let complete = self.end.map_or(done >= target, |end| end.1);
        if self.collisions > 0 && !self.fly_on(plan, &mut *gas, leg, complete)? {
            return Ok(false);
        }
        let given = plan.starts_as_given() && asked == 0;
        let tests = if given {
            Vec::new()
        } else {
            self.tests(plan, &gas.particles())
        };
        let failed = tests.iter().any(|test| test.passed == Some(false));
        let done = self.collisions;
        if failed && done < most && complete && asked > 0 {
            self.bins = vec![0; BINS];
            self.end = None;
            return Ok(false);
        }
        self.report = Some(StartReport {
            placement: self.placement.clone(),
            collisions_per_particle: 2.0 * done as f64 / plan.count() as f64,
            equilibrated: (!given).then_some(!failed && asked > 0 && done >= asked),
            tests,
        });
        Ok(true)
    }

    /// Advances by a mean free time after the collision at which counting ended. Otherwise the
    /// start would be at a collision, with one pair more than average in contact. Returns `true`
    /// when finished.
    ///
    /// # Errors
    /// [`StartError::Interrupted`] leaves the preparation unchanged.
    fn fly_on(
        &mut self,
        plan: &CasePlan,
        gas: &mut dyn Simulation,
        leg: u64,
        complete: bool,
    ) -> Result<bool, StartError> {
        let (end, _) = self.end.unwrap_or_else(|| {
            let free = 0.5 * gas.time() * gas.particle_count() as f64 / self.collisions as f64;
            // Where hardly anything collides, at most as long as the count took.
            (gas.time() + free.min(gas.time()), complete)
        });
        let reached = gas
            .advance(end, Budget::Collisions(leg), &mut ())
            .map_err(|failure| plan.told(failure))?;
        if gas.is_interrupted() {
            return Err(StartError::Interrupted);
        }
        self.end = Some((end, complete));
        self.gas = gas.save_checkpoint()?;
        self.collisions = gas.work_counters().collisions;
        Ok(reached)
    }

    /// Creates the gas of the equilibration, in its current state.
    pub(crate) fn gas(
        &self,
        plan: &CasePlan,
        streams: Streams,
    ) -> Result<Box<dyn Simulation>, StartError> {
        let (boundaries, kind) = (plan.exact_boundaries(streams)?, DissipationRule::Elastic);
        let gas = stosszahl_ed::resume(
            &at_rest(plan),
            plan.count(),
            kind,
            &boundaries,
            &self.gas,
            &Interrupt::default(),
        );
        gas.map_err(|error| StartError::from(error).in_units(plan))
    }

    /// Returns the finished start, at time 0.
    ///
    /// # Errors
    /// [`StartError`] if the preparation is damaged.
    pub fn particles(&self, plan: &CasePlan, streams: Streams) -> Result<Particles, StartError> {
        let mut particles = self.gas(plan, streams)?.particles();
        particles.time = 0.0;
        if plan.draws_after_equilibration() {
            return match plan.gas.particles.rough {
                None => with_initial_velocities(plan, Smooth, &particles, streams),
                Some(rough) => with_initial_velocities(plan, rough, &particles, streams),
            };
        }
        let drawn = plan.case.start.velocities == VelocitiesSpec::MAXWELLIAN;
        if plan.equilibration() > 0.0 && drawn && plan.is_disk_fluid() {
            rescale(plan, &mut particles)?;
        }
        Ok(particles)
    }

    fn tests(&self, plan: &CasePlan, particles: &Particles) -> Vec<EquilibriumTest> {
        let mut tests = vec![equilibrium::impact_uniform(&self.bins)];
        if !plan.is_disk_fluid() {
            return tests;
        }
        let places: Vec<Vector2<f64>> = particles.all.iter().map(|one| one.position.xy()).collect();
        let lengths = [plan.gas.lengths[0], plan.gas.lengths[1]];
        let packing = plan.gas.packing_fraction;
        let peaks = &self.reciprocal;
        let forgotten = || equilibrium::lattice_forgotten(&places, lengths, peaks, packing);
        tests.extend((!peaks.is_empty()).then(forgotten));
        let diameter = 2.0 * plan.gas.species[0].radius;
        let waves = || equilibrium::long_waves_fluctuate(&places, lengths, diameter, packing);
        tests.extend(matches!(plan.gas.particles.sizes, SizeDistribution::Equal(_)).then(waves));
        tests
    }
}

/// Converts a number of collisions per particle to a number of pair collisions.
pub(crate) fn pairs(plan: &CasePlan, per_particle: f64) -> u64 {
    (0.5 * per_particle * plan.count() as f64).ceil() as u64
}

/// Returns true if elastic dynamics equilibrates or tests the start of a case; only for hard disks.
pub fn is_prepared(plan: &CasePlan) -> bool {
    plan.is_disk_fluid() || plan.gas.dimension == 2 && plan.equilibration() > 0.0
}

#[cfg(test)]
mod tests;
