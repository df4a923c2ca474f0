//! The engine behind the common interface: chosen at run time, for any grains of the model.

use nalgebra::{Vector2, Vector3, vector};
use serde::{Deserialize, Serialize};
use stosszahl_model::interrupt::Interruption;
use stosszahl_model::simulation::BETWEEN_PAUSES;
use stosszahl_model::{
    Body, BoundaryFlux, Budget, Failure, GrainSizes, Grains, Interrupt, Invalid, Observer,
    Particle, Particles, Physics, Plane, Simulation, Sizes, Smooth, State, Surface, Vector as _,
    Work,
};

use crate::checkpoint::{Checkpoint, Dissipation, Tally};
use crate::engine::Engine;
use crate::error::EngineError;
use crate::strips::Spread;
use crate::surroundings::Boundaries;

/// Collisions in one leg, for each disk, and at least: a new leg costs about as much as a tenth of a collision for each disk.
const LEG: u64 = 4;
const LEAST_LEG: u64 = 100_000;

/// Disks that a thread of its own pays for.
const EACH_THREAD: usize = 20_000;

/// Starts exact dynamics of disks.
///
/// ```
/// use stosszahl_ed::{Boundaries, Dissipation, simulate};
/// use stosszahl_model::{Budget, Constant, Grains, Particles, Simulation};
/// # fn particles() -> Particles {
/// #     use stosszahl_model::{Particle, Vector};
/// #     let at = |x: f64, v: f64| Particle {
/// #         position: nalgebra::vector![x, 5.0, 0.0], velocity: nalgebra::vector![v, 0.0, 0.0],
/// #         ..Particle::of(0.5, 1.0)
/// #     };
/// #     Particles { time: 0.0, dimension: 2, lengths: [10.0, 10.0, 0.0], periodic: [true; 3],
/// #         all: vec![at(2.0, 1.0), at(6.0, -1.0)] }
/// # }
///
/// let grains = Grains::equal(0.5, 1.0, Constant::new(0.5)?);
/// let boundaries = Boundaries::periodic();
/// let mut gas = simulate(&grains, Dissipation::Scene, &boundaries, &particles())?;
/// gas.advance(2.0, Budget::Unlimited, &mut ())?;
/// assert_eq!(gas.work().collisions, 1);
/// assert!((gas.temperature() - 0.5 * 0.25).abs() < 1e-15);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`EngineError`] if grains, boundaries and particles do not go together, or particles overlap.
pub fn simulate(
    grains: &Grains,
    dissipation: Dissipation,
    boundaries: &Boundaries,
    start: &Particles,
) -> Result<Box<dyn Simulation>, EngineError> {
    let begin = Begin {
        dissipation,
        boundaries,
        from: Source::Start(start),
    };
    begin.choose(grains, start.all.len())
}

/// Goes on from [`Simulation::checkpoint`]; all else must be as it was at the start.
///
/// # Errors
/// As [`simulate`]; and [`EngineError::Checkpoint`] if the bytes are none of this engine.
pub fn resume(
    grains: &Grains,
    count: usize,
    dissipation: Dissipation,
    boundaries: &Boundaries,
    checkpoint: &[u8],
) -> Result<Box<dyn Simulation>, EngineError> {
    let begin = Begin {
        dissipation,
        boundaries,
        from: Source::Checkpoint(checkpoint),
    };
    begin.choose(grains, count)
}

/// What an engine begins with.
enum Source<'a> {
    Start(&'a Particles),
    Checkpoint(&'a [u8]),
}

/// Makes an engine of the types of a scene.
struct Begin<'a> {
    dissipation: Dissipation,
    boundaries: &'a Boundaries,
    from: Source<'a>,
}

impl Begin<'_> {
    /// One engine for each kind of disks that changes what is stored for a disk.
    fn choose(self, grains: &Grains, count: usize) -> Result<Box<dyn Simulation>, EngineError> {
        match (&grains.sizes, grains.rough) {
            (GrainSizes::Equal(sizes), _) if grains.is_plain() => self.run(grains.plain(*sizes)),
            (GrainSizes::Each(sizes), _) if grains.is_plain() => {
                self.run(grains.plain(sizes.clone()))
            }
            (_, Some(rough)) => self.run(grains.scene(rough, count)?),
            (_, None) => self.run(grains.scene(Smooth, count)?),
        }
    }

    fn run<P: Physics<Space = Plane>>(self, scene: P) -> Result<Box<dyn Simulation>, EngineError> {
        let (stage, origin) = match self.from {
            Source::Start(start) => {
                let domain = self.boundaries.walls.domain(flat(start.lengths.into()))?;
                let body = |particle: &Particle| Body {
                    position: flat(particle.position),
                    velocity: flat(particle.velocity),
                    spin: <P::Surface as Surface<Plane>>::spin_of(particle.spin),
                };
                let state = State {
                    time: start.time,
                    domain,
                    bodies: start.all.iter().map(body).collect(),
                };
                // The engine checks the start; the checkpoint before it is what the first leg begins with.
                let checkpoint = Checkpoint::from(state);
                Engine::<P>::between(
                    scene.clone(),
                    self.dissipation,
                    checkpoint.clone(),
                    self.boundaries,
                )?;
                (Stage::Between(Box::new(checkpoint)), Vec::new())
            }
            Source::Checkpoint(bytes) => {
                let kept: Kept<P> = postcard::from_bytes(bytes)?;
                (Stage::Between(Box::new(kept.gas)), kept.origin)
            }
        };
        Ok(Box::new(Disks {
            scene,
            dissipation: self.dissipation,
            boundaries: self.boundaries.clone(),
            stage,
            origin,
            bytes: 0,
            spread: Spread::default(),
            stop: Interruption::default(),
            pause: None,
        }))
    }
}

/// The components in the plane.
fn flat(vector: Vector3<f64>) -> Vector2<f64> {
    vector.xy()
}

/// Event-driven disks behind [`Simulation`].
///
/// A leg is a function of the checkpoint before it, so between legs the checkpoint is the gas and the engine is made anew;
/// in longer advances the engine stays.
struct Disks<P: Physics<Space = Plane>> {
    scene: P,
    dissipation: Dissipation,
    boundaries: Boundaries,
    stage: Stage<P>,
    /// Where each disk was when displacements began; empty unless they are followed.
    origin: Vec<Vector2<f64>>,
    bytes: usize,
    spread: Spread,
    stop: Interruption,
    pause: Option<Interrupt>,
}

/// Where the gas is kept.
enum Stage<P: Physics<Space = Plane>> {
    Between(Box<Checkpoint<P>>),
    Flying(Box<Engine<P>>),
}

/// What is written into a checkpoint.
#[derive(Serialize, Deserialize)]
#[serde(bound = "")]
struct Kept<P: Physics> {
    gas: Checkpoint<P>,
    origin: Vec<Vector2<f64>>,
}

impl<P: Physics<Space = Plane>> Disks<P> {
    fn tally(&self) -> Tally {
        match &self.stage {
            Stage::Between(gas) => gas.tally,
            Stage::Flying(engine) => engine.tally(),
        }
    }

    /// The gas as a checkpoint.
    fn checkpoint(&self) -> Checkpoint<P> {
        match &self.stage {
            Stage::Between(gas) => (**gas).clone(),
            Stage::Flying(engine) => engine.checkpoint(),
        }
    }

    /// Puts the engine aside.
    fn land(&mut self) -> &mut Checkpoint<P> {
        if let Stage::Flying(engine) = &mut self.stage {
            // The checkpoint has use for their memory.
            engine.strips.clear();
            self.bytes = engine.bytes();
            self.spread = engine.spread();
            self.stage = Stage::Between(Box::new(engine.checkpoint()));
        }
        match &mut self.stage {
            Stage::Between(gas) => gas,
            Stage::Flying(_) => unreachable!("the engine was put aside"),
        }
    }

    /// Makes an engine of the checkpoint.
    fn take_off(&mut self) -> Result<&mut Engine<P>, EngineError> {
        if let Stage::Between(gas) = &mut self.stage {
            let nowhere = Checkpoint::nowhere(gas);
            let gas = std::mem::replace(&mut **gas, nowhere);
            let (scene, boundaries) = (self.scene.clone(), self.boundaries.clone());
            let (dissipation, spread) = (self.dissipation, self.spread.clone());
            let engine = Engine::from_checkpoint(scene, dissipation, gas, boundaries, spread)?;
            self.stage = Stage::Flying(Box::new(engine));
        }
        match &mut self.stage {
            Stage::Flying(engine) => Ok(engine),
            Stage::Between(_) => unreachable!("the engine was made"),
        }
    }

    fn show(&self, state: &State<P>, look: &mut dyn FnMut(&Particle)) {
        let (sizes, surface) = (self.scene.sizes(), self.scene.surface());
        for (index, body) in state.bodies.iter().enumerate() {
            let tag = sizes.tag(index);
            let (radius, mass) = (sizes.radius(tag), sizes.mass(tag));
            look(&Particle {
                position: body.position.spatial(),
                velocity: body.velocity.spatial(),
                spin: <P::Surface as Surface<Plane>>::spin_in_space(body.spin),
                radius,
                mass,
                spin_energy: surface.spin_energy(mass, radius, body.spin),
                species: sizes.kind(tag),
                weight: 1.0,
            });
        }
    }
}

impl<P: Physics<Space = Plane>> Simulation for Disks<P> {
    fn time(&self) -> f64 {
        match &self.stage {
            Stage::Between(gas) => gas.state.time,
            Stage::Flying(engine) => engine.time(),
        }
    }

    fn dimension(&self) -> usize {
        2
    }

    fn count(&self) -> usize {
        match &self.stage {
            Stage::Between(gas) => gas.state.bodies.len(),
            Stage::Flying(engine) => engine.names.len(),
        }
    }

    fn weight(&self) -> f64 {
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
        let mut left = match budget {
            Budget::Leg => {
                self.land();
                (LEG * self.count() as u64).max(LEAST_LEG)
            }
            Budget::Collisions(most) => most,
            Budget::Unlimited => u64::MAX,
        };
        let (stop, pause) = (self.stop.clone(), self.pause.clone());
        let engine = self.take_off().map_err(Failure::new)?;
        engine.stop = stop;
        let reached = loop {
            let slice = left.min(pause.as_ref().map_or(u64::MAX, |_| BETWEEN_PAUSES));
            let reached = engine.advance(until, slice, observer);
            left -= slice;
            let ends = pause.as_ref().is_none_or(Interrupt::is_raised) || left == 0;
            if ends || engine.is_interrupted() || !matches!(reached, Ok(false)) {
                break reached;
            }
        };
        let stop = engine.stop.clone();
        // Also where it cannot go on: that state is what one wants to see.
        if (budget == Budget::Leg && !stop.has_ended()) || reached.is_err() {
            self.land();
        }
        self.stop = stop;
        reached.map_err(Failure::new)
    }

    fn stop_on(&mut self, interrupt: &Interrupt) {
        self.stop.on(interrupt);
    }

    fn pause_on(&mut self, pause: &Interrupt) {
        self.pause = Some(pause.clone());
    }

    fn use_threads(&mut self, threads: usize) {
        self.spread.strips = threads.min(self.count() / EACH_THREAD);
        if let Stage::Flying(engine) = &mut self.stage {
            engine.spread_over(self.spread.strips);
        }
    }

    fn is_interrupted(&self) -> bool {
        self.stop.has_ended()
    }

    fn visit(&self, look: &mut dyn FnMut(&Particle)) {
        match &self.stage {
            Stage::Between(gas) => self.show(&gas.state, look),
            Stage::Flying(engine) => self.show(&engine.state(), look),
        }
    }

    fn particles(&self) -> Particles {
        let domain = match &self.stage {
            Stage::Between(gas) => gas.state.domain,
            Stage::Flying(engine) => engine.domain,
        };
        let mut all = Vec::with_capacity(self.count());
        self.visit(&mut |particle| all.push(*particle));
        Particles {
            time: self.time(),
            dimension: 2,
            lengths: domain.lengths().spatial().into(),
            periodic: [0, 1, 2].map(|axis| domain.is_periodic(axis)),
            all,
        }
    }

    fn kick(&mut self, changes: &[Vector3<f64>]) -> Result<(), Failure> {
        for (body, change) in self.land().state.bodies.iter_mut().zip(changes) {
            body.velocity += flat(*change);
        }
        Ok(())
    }

    fn scale_velocities(&mut self, factor: f64) -> Result<(), Failure> {
        Invalid::unless_positive("factor of all velocities", factor).map_err(Failure::new)?;
        for body in &mut self.land().state.bodies {
            body.velocity *= factor;
        }
        Ok(())
    }

    fn checkpoint(&self) -> Result<Vec<u8>, Failure> {
        let kept = Kept {
            gas: self.checkpoint(),
            origin: self.origin.clone(),
        };
        postcard::to_stdvec(&kept).map_err(Failure::new)
    }

    fn work(&self) -> Work {
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
        Work {
            collisions: tally.collisions,
            numbers: numbers
                .map(|(name, number)| (name.to_owned(), number))
                .into(),
        }
    }

    fn bytes(&self) -> usize {
        match &self.stage {
            Stage::Between(_) => self.bytes,
            Stage::Flying(engine) => engine.bytes(),
        }
    }

    fn follow_displacements(&mut self) -> bool {
        let gas = self.land();
        gas.windings = vec![[0; 2]; gas.state.bodies.len()];
        self.origin = gas.state.bodies.iter().map(|body| body.position).collect();
        true
    }

    fn displacements(&self) -> Option<Vec<Vector3<f64>>> {
        if self.origin.is_empty() {
            return None;
        }
        let gas = self.checkpoint();
        let sides = gas.state.domain.lengths();
        let disks = gas.state.bodies.iter().zip(&gas.windings).zip(&self.origin);
        let way = |((body, winding), origin): ((&Body<P>, &[i32; 2]), &Vector2<f64>)| {
            let turns = vector![f64::from(winding[0]), f64::from(winding[1])];
            (body.position - origin + turns.component_mul(&sides)).spatial()
        };
        Some(disks.map(way).collect())
    }

    fn boundaries(&self) -> Vec<BoundaryFlux> {
        let ledgers = match &self.stage {
            Stage::Between(gas) => &gas.ledgers[..],
            Stage::Flying(engine) => engine.ledgers(),
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
