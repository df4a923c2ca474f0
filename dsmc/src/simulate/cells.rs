//! DSMC gas of one process behind the common interface `Simulation`: advances in legs, checkpoints,
//! measurements.

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};
use stosszahl_model::sum::Totals;
use stosszahl_model::walls::FACES;
use stosszahl_model::{
    BoundaryFlux, Budget, DynReduction, Failure, Interrupt, InvalidValue, Observer, Particle,
    ParticleModel, Particles, Simulation, Sizes, Space, Surface, Vector as _, VectorOf,
    WorkCounters,
};

use super::others::Others;
use crate::boundary::Transfer;
use crate::checkpoint::DsmcCheckpoint;
use crate::decomposition::Shard;
use crate::engine::DsmcEngine;
use crate::particle::{DisplacementTracking, SimulatorOf};

/// Number of simulator steps (simulators times time steps) in one leg, the segment of a run between
/// two checkpoints.
const LEG: u64 = 5_000_000;
/// Least number of time steps in one leg, the segment of a run between two checkpoints.
const LEAST_LEG: u64 = 20;

/// Name of the entry for splitting and merging simulators in [`Simulation::boundary_fluxes`].
pub const BALANCE: &str = "splitting and merging";

/// Content of a saved checkpoint: the state of the gas, and the shards that hold its simulators.
#[derive(Serialize, Deserialize)]
#[serde(bound = "")]
pub(super) struct CheckpointContent<P: ParticleModel, F: DisplacementTracking<P::Space>> {
    pub(super) gas: DsmcCheckpoint<P, F>,
    pub(super) follows: bool,
    /// Shards that hold the simulators; empty if these are in `gas`.
    pub(super) shards: Vec<Shard>,
}

/// DSMC engine behind the interface [`Simulation`], in one process or as the part of one of
/// several.
pub(super) struct CellSimulation<P: ParticleModel, F: DisplacementTracking<P::Space>> {
    pub(super) engine: DsmcEngine<P, F>,
    /// True if displacements of simulators can be measured.
    pub(super) displacements: bool,
    /// True if displacements of simulators are being measured.
    pub(super) follows: bool,
    /// Other processes that hold parts of the gas and receive commands; `None` for a single
    /// process.
    pub(super) others: Option<Others>,
}

impl<P: ParticleModel, F: DisplacementTracking<P::Space>> CellSimulation<P, F> {
    /// Advances the engines of all processes, as [`DsmcEngine::advance`].
    fn go(&mut self, until: f64, steps: u64, observer: &mut dyn Observer) -> bool {
        if let Some(others) = &self.others {
            others.advance(until, steps, observer.is_active());
        }
        self.engine.advance(until, steps, observer)
    }

    /// Computes the sums of squared displacements of the simulators in this process, tile by tile
    /// \[length^2\].
    pub(super) fn squared_ways(&self) -> Totals {
        let mut squares = Totals::new(1);
        for tile in self.engine.tiles_here() {
            self.engine.each_in(tile, |simulator, _| {
                squares.open()[0] += F::displacement_of(simulator.mark).square();
            });
            squares.close();
        }
        squares
    }

    /// Computes the mean squared displacement from sums over all simulators \[length^2\]; `None`
    /// without simulators.
    pub(super) fn mean_of(&self, squares: &Totals) -> Option<f64> {
        let sum: f64 = squares.values().iter().sum();
        (self.particle_count() > 0).then(|| sum / self.particle_count() as f64)
    }

    fn particle(&self, simulator: &SimulatorOf<P, F>, weight: f64) -> Particle {
        let scene = self.engine.scene();
        let sizes = scene.sizes();
        let (radius, mass) = (sizes.radius(simulator.tag), sizes.mass(simulator.tag));
        Particle {
            position: simulator.position.spatial(),
            velocity: simulator.velocity.spatial(),
            spin: <P::Surface as Surface<P::Space>>::spin_in_space(simulator.spin),
            radius,
            mass,
            spin_energy: scene.surface().spin_energy(mass, radius, simulator.spin),
            species: sizes.species_of(simulator.tag),
            weight,
        }
    }
}

impl<P: ParticleModel, F: DisplacementTracking<P::Space>> Simulation for CellSimulation<P, F> {
    fn time(&self) -> f64 {
        self.engine.time()
    }

    fn dimension(&self) -> usize {
        P::Space::DIMENSION
    }

    fn particle_count(&self) -> usize {
        self.engine.simulators()
    }

    fn mean_weight(&self) -> f64 {
        self.engine.weight()
    }

    fn advance(
        &mut self,
        until: f64,
        budget: Budget,
        observer: &mut dyn Observer,
    ) -> Result<bool, Failure> {
        Ok(match budget {
            Budget::Unlimited => self.go(until, u64::MAX, observer),
            Budget::Leg => {
                let steps = LEG / self.particle_count().max(1) as u64;
                self.go(until, steps.max(LEAST_LEG), observer)
            }
            Budget::Collisions(most) => {
                let last = self.engine.tally().collisions.saturating_add(most);
                while self.engine.tally().collisions < last {
                    if self.go(until, 1, observer) {
                        return Ok(true);
                    }
                    if self.engine.is_interrupted() {
                        return Ok(false);
                    }
                }
                until <= self.time()
            }
        })
    }

    fn set_stop_flag(&mut self, interrupt: &Interrupt) {
        self.engine.set_stop_flag(interrupt);
    }

    fn set_pause_flag(&mut self, pause: &Interrupt) {
        self.engine.set_pause_flag(pause);
    }

    fn is_interrupted(&self) -> bool {
        self.engine.is_interrupted()
    }

    fn visit_particles(&self, look: &mut dyn FnMut(&Particle)) {
        self.engine
            .each(|simulator, weight| look(&self.particle(simulator, weight)));
    }

    fn reduce_particles(&self, sum: &mut dyn DynReduction) {
        for tile in self.engine.tiles_here() {
            (self.engine).each_in(tile, |simulator, weight| {
                sum.add_particle(&self.particle(simulator, weight));
            });
            sum.close_group(tile as u32);
        }
    }

    fn reduce_neighbourhoods(&self, _reach: f64, sum: &mut dyn DynReduction) {
        self.visit_particles(&mut |particle| sum.add_particle(particle));
        sum.close_group(0);
    }

    fn particles(&self) -> Particles {
        let domain = self.engine.grid().domain();
        let mut all = vec![Particle::at_rest(0.0, 0.0); self.particle_count()];
        self.engine.each_in_place(|index, simulator, weight| {
            all[index] = self.particle(simulator, weight);
        });
        Particles {
            time: self.time(),
            dimension: P::Space::DIMENSION,
            lengths: domain.lengths().spatial().into(),
            periodic: [0, 1, 2].map(|axis| domain.is_periodic(axis)),
            all,
        }
    }

    fn add_velocities(&mut self, changes: &[Vector3<f64>]) -> Result<(), Failure> {
        let flat = |change: &Vector3<f64>| P::Space::from_components(|axis| change[axis]);
        let changes: Vec<VectorOf<P>> = changes.iter().map(flat).collect();
        self.engine.kick(&changes);
        Ok(())
    }

    fn scale_velocities(&mut self, factor: f64) -> Result<(), Failure> {
        InvalidValue::unless_positive("factor of all velocities", factor).map_err(Failure::new)?;
        self.engine.scale_velocities(factor);
        Ok(())
    }

    fn save_checkpoint(&self) -> Result<Vec<u8>, Failure> {
        let kept = CheckpointContent {
            gas: self.engine.checkpoint(),
            follows: self.follows,
            shards: Vec::new(),
        };
        postcard::to_stdvec(&kept).map_err(Failure::new)
    }

    fn work_counters(&self) -> WorkCounters {
        let tally = self.engine.tally();
        let over = |a: f64, b: u64| a / b.max(1) as f64;
        let simulators = self.engine.simulators() as u64;
        let numbers = [
            ("steps", tally.steps as f64),
            ("simulators", simulators as f64),
            (
                "trials_per_collision",
                over(tally.trials as f64, tally.collisions),
            ),
            (
                "majorant_violations_per_trial",
                over(tally.majorant_violations as f64, tally.trials),
            ),
            (
                "collisions_per_simulator_and_step",
                over(2.0 * tally.collisions as f64, tally.steps * simulators),
            ),
            (
                "share_of_cells_with_limited_contact_value",
                over(tally.limited_cells as f64, tally.active_cells),
            ),
            (
                "share_of_collisions_in_limited_cells",
                over(tally.limited_collisions as f64, tally.collisions),
            ),
            (
                "collision_separation",
                over(tally.separation, tally.collisions),
            ),
            (
                "most_collisions_per_simulator_in_a_cell_and_step",
                tally.busiest_cell,
            ),
            ("cell_width", self.engine.cell()[0]),
            (
                "particles_laid_to_rest_on_walls",
                self.engine.ledgers().settled_particles as f64,
            ),
        ];
        WorkCounters {
            collisions: tally.collisions,
            numbers: numbers
                .map(|(name, number)| (name.to_owned(), number))
                .into(),
        }
    }

    fn memory_bytes(&self) -> usize {
        self.engine.memory_bytes()
    }

    fn track_displacements(&mut self) -> bool {
        if self.displacements {
            self.engine.track_displacements();
            self.follows = true;
        }
        self.displacements
    }

    fn displacements(&self) -> Option<Vec<Vector3<f64>>> {
        let all = self.follows.then(|| self.engine.displacements())?;
        Some(all.iter().map(stosszahl_model::Vector::spatial).collect())
    }

    fn mean_squared_displacement(&self) -> Option<f64> {
        let squares = self.follows.then(|| self.squared_ways())?;
        self.mean_of(&squares)
    }

    fn boundary_fluxes(&self) -> Vec<BoundaryFlux> {
        let ledgers = self.engine.ledgers();
        let mut entries = Vec::new();
        for (axis, names) in FACES.iter().enumerate() {
            for (side, name) in names.iter().enumerate() {
                let wall = &ledgers.walls[axis][side];
                if wall.contacts > 0.0 {
                    entries.push(BoundaryFlux::of_ledger(*name, wall));
                }
                let open = &ledgers.open[axis][side];
                if open.particles != 0.0 {
                    entries.push(of_transfer(format!("out through {name}"), open));
                }
            }
        }
        for (index, obstacle) in ledgers.obstacles.iter().enumerate() {
            let name = format!("obstacle {}", index + 1);
            entries.push(BoundaryFlux::of_ledger(name, obstacle));
        }
        for (index, inflow) in ledgers.inflows.iter().enumerate() {
            entries.push(of_transfer(format!("inflow {}", index + 1), inflow));
        }
        if ledgers.balanced > 0 {
            entries.push(of_transfer(BALANCE.to_owned(), &ledgers.balance));
        }
        entries
    }
}

fn of_transfer<S: Space>(name: String, transfer: &Transfer<S>) -> BoundaryFlux {
    BoundaryFlux {
        name,
        particles: transfer.particles,
        momentum: transfer.momentum.spatial().into(),
        energy: transfer.energy,
    }
}
