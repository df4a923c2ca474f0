//! Gases without positions behind the common interface `Simulation`: particles, pair selection and
//! contact rule are chosen at run time.

use std::collections::BTreeMap;

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};
use stosszahl_model::initial::VelocityDistribution;
use stosszahl_model::random::{Purpose, Streams};
use stosszahl_model::{
    Budget, Census, Clusters, Failure, Free, Interrupt, Law, Observer, ParticleSpec as AnyGrains,
    Particles, Plane, Scene, Simulation, SizeDistribution, Sizes, Smooth, Space, Species,
    SpeciesProperties, Vector, VectorOf, Volume, WorkCounters,
};

use super::bird::Bird;
use super::checkpoint::HomogeneousCheckpoint;
use super::clock::StopReason;
use super::contact::{ContactRule, Tracers};
use super::engine::HomogeneousEngine;
use super::error::HomogeneousError;
use super::gas::{HomogeneousGas, SmoothPhysics};
use super::kernel::PairCorrelationFactor;
use super::low_rank::LowRank;
use super::motion::{DisplacementRecord, PathRecord};
use super::paths::{Trajectories, time_averaged};
use super::selection::SelectionMethod;
use super::slots::AliasTableSelection;
use super::sticking::{AggregationRule, Sticking, size_distribution};

/// Collisions per particle of the start in one leg, the segment of a run between two checkpoints.
const LEG: f64 = 1.0;
/// Least number of collisions in one leg, the segment of a run between two checkpoints.
const LEAST_LEG: u64 = 200_000;

/// Choice of the method that selects candidate pairs; all methods are exact.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PairSelection {
    /// Selection from groups of nearly equal speed and size in alias tables:
    /// [`AliasTableSelection`].
    #[default]
    AliasTables,
    /// Selection by products of the weights of size classes, found in trees of sums: [`LowRank`].
    LowRank,
    /// Bird's selection with a single majorant for all pairs: [`Bird`].
    SingleMajorant,
}

/// Settings of a simulation of a gas without positions.
#[derive(Clone, Debug)]
pub struct HomogeneousSettings<'a> {
    /// Number of space dimensions, 2 or 3.
    pub dimension: usize,
    /// Sizes, masses and collision law of the particles, which must be smooth and without a field.
    /// For aggregation: equal monomers.
    pub grains: &'a AnyGrains,
    /// Number of particles at the start.
    pub count: usize,
    /// Volume of the gas \[length^D\], in two dimensions an area.
    pub volume: f64,
    /// Contact value of the pair correlation by which density raises collision rates.
    pub contact: PairCorrelationFactor,
    /// Granular temperature of each species at the start \[energy\].
    pub temperatures: &'a [f64],
    /// Shape of the velocity distribution of each species at the start.
    pub velocities: VelocityDistribution,
    /// Method that selects candidate pairs.
    pub pick: PairSelection,
    /// Number of the species in the tracer limit, which does not affect the others; `None` without.
    pub tracer: Option<u32>,
    /// Rule of aggregation and fragmentation; `None` if particles only bounce.
    pub sticking: Option<AggregationRule>,
    /// True if displacements of particles are recorded.
    pub displacements: bool,
    /// Number of particles in each group of species whose trajectories are kept, and the group of
    /// each species; an empty list for no trajectories.
    pub paths: (usize, &'a [u32]),
    /// Random streams of the run, by seed and replica.
    pub streams: Streams,
}

impl HomogeneousSettings<'_> {
    /// Creates the gas with random velocities, as a [`Simulation`].
    ///
    /// ```
    /// use stosszahl_homogeneous::{PairCorrelationFactor, HomogeneousSettings, PairSelection};
    /// use stosszahl_model::initial::VelocityDistribution;
    /// use stosszahl_model::random::Streams;
    /// use stosszahl_model::{Budget, Constant, ParticleSpec, Simulation};
    ///
    /// let grains = ParticleSpec::equal(0.5, 1.0, Constant::new(0.8)?);
    /// let gas = HomogeneousSettings {
    ///     dimension: 3,
    ///     grains: &grains,
    ///     count: 1000,
    ///     volume: 1e4,
    ///     contact: PairCorrelationFactor::Dilute,
    ///     temperatures: &[1.0],
    ///     velocities: VelocityDistribution::MAXWELLIAN,
    ///     pick: PairSelection::AliasTables,
    ///     tracer: None,
    ///     sticking: None,
    ///     displacements: false,
    ///     paths: (0, &[]),
    ///     streams: Streams::new(1, 0),
    /// };
    /// let mut gas = gas.simulate()?;
    /// gas.advance(10.0, Budget::Unlimited, &mut ())?;
    /// assert!(gas.temperature() < 1.0);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`HomogeneousError`] if a number is out of range or the parts do not go together;
    /// [`HomogeneousError::NoAggregation`] for particles that stick without the feature
    /// `aggregation`.
    pub fn simulate(&self) -> Result<Box<dyn Simulation>, HomogeneousError> {
        self.choose(None)
    }

    /// Resumes a gas from the bytes of [`Simulation::save_checkpoint`]; all settings must be as at
    /// the start.
    ///
    /// # Errors
    /// As [`Self::simulate`]; and [`HomogeneousError::Checkpoint`] if the bytes are none of this
    /// gas.
    pub fn resume(&self, checkpoint: &[u8]) -> Result<Box<dyn Simulation>, HomogeneousError> {
        self.choose(Some(checkpoint))
    }

    fn choose(&self, from: Option<&[u8]>) -> Result<Box<dyn Simulation>, HomogeneousError> {
        if self.grains.rough.is_some() || self.grains.gravity.is_some() {
            return Err(HomogeneousError::Unfit {
                what: "spin or a field",
                allowed: "smooth particles in free flight",
            });
        }
        if self.dimension == 2 {
            self.in_space(Plane, from)
        } else {
            self.in_space(Volume, from)
        }
    }

    fn in_space<S: Space>(
        &self,
        space: S,
        from: Option<&[u8]>,
    ) -> Result<Box<dyn Simulation>, HomogeneousError> {
        match self.pick {
            PairSelection::AliasTables => self.picked::<S, AliasTableSelection>(space, from),
            PairSelection::LowRank => self.picked::<S, LowRank>(space, from),
            PairSelection::SingleMajorant => self.picked::<S, Bird>(space, from),
        }
    }

    fn picked<S: Space, P>(
        &self,
        space: S,
        from: Option<&[u8]>,
    ) -> Result<Box<dyn Simulation>, HomogeneousError>
    where
        P: SelectionMethod<Mixed<S>> + SelectionMethod<Sticky<S>> + Send + 'static,
    {
        let restitution = self.grains.restitution.clone();
        if let Some(rule) = self.sticking {
            if !cfg!(feature = "aggregation") {
                return Err(HomogeneousError::NoAggregation);
            }
            let SizeDistribution::Equal(monomer) = &self.grains.sizes else {
                return Err(HomogeneousError::Unfit {
                    what: "particles of several sizes that stick",
                    allowed: "equal monomers",
                });
            };
            let sizes = Clusters::new(monomer.radius, monomer.mass, self.dimension, Vec::new())?;
            let scene = scene(space, restitution, sizes);
            let contacts = Sticking::new(rule)?;
            return self.boxed::<_, P, _, _>(scene, |_| (), contacts, from);
        }
        let sizes = self.species()?;
        let scene = scene(space, restitution, sizes);
        let tracers = self.tracer.map(|kind| Tracers { kind });
        let follow = |gas: &HomogeneousGas<Mixed<S>>| {
            self.displacements.then(|| {
                let places = DisplacementRecord::new(gas.count(), 0.0);
                let chosen = self.chosen(gas);
                let paths =
                    (!chosen.is_empty()).then(|| Trajectories::new(gas.count(), &chosen, 0.0));
                (places, paths)
            })
        };
        self.boxed::<_, P, _, _>(scene, follow, tracers, from)
    }

    fn species(&self) -> Result<Species, HomogeneousError> {
        Ok(match &self.grains.sizes {
            SizeDistribution::Species(species) => species.clone(),
            SizeDistribution::Equal(one) => Species::new(vec![SpeciesProperties {
                radius: one.radius,
                mass: one.mass,
                count: self.count,
            }])?,
            SizeDistribution::Each(all) => {
                let kinds = all.pairs().iter().map(|&(radius, mass)| SpeciesProperties {
                    radius,
                    mass,
                    count: 1,
                });
                Species::new(kinds.collect())?
            }
        })
    }

    /// Returns the indices of the particles whose trajectories are kept: the first of each group of
    /// species, group by group.
    fn chosen<S: Space>(&self, gas: &HomogeneousGas<Mixed<S>>) -> Vec<u32> {
        let (most, groups) = self.paths;
        let last = groups.iter().max().map_or(0, |&last| last as usize + 1);
        let mut lists = vec![Vec::new(); last];
        for (index, particle) in gas.alive().enumerate() {
            let group = groups.get(particle.tag as usize);
            let list: Option<&mut Vec<u32>> =
                group.and_then(|&group| lists.get_mut(group as usize));
            if let Some(list) = list.filter(|list| list.len() < most) {
                list.push(index as u32);
            }
        }
        lists.concat()
    }

    fn boxed<G, P, M, C>(
        &self,
        scene: G,
        motion: impl FnOnce(&HomogeneousGas<G>) -> M,
        contacts: C,
        from: Option<&[u8]>,
    ) -> Result<Box<dyn Simulation>, HomogeneousError>
    where
        G: SmoothPhysics<Restitution = Law>,
        P: SelectionMethod<G> + Send + 'static,
        M: Follows<G> + Send + 'static,
        C: Counts<G> + Send + 'static,
    {
        let (engine, leg) = if let Some(bytes) = from {
            let kept: Kept<G, P, M, C> = postcard::from_bytes(bytes)
                .map_err(|error| HomogeneousError::Checkpoint(error.to_string()))?;
            (
                HomogeneousEngine::resume(scene, kept.gas, self.streams),
                kept.leg,
            )
        } else {
            let temperature = |kind: u32| {
                let last = self.temperatures.len().saturating_sub(1);
                self.temperatures.get((kind as usize).min(last)).copied()
            };
            let gas = HomogeneousGas::drawn(
                scene,
                self.contact,
                self.volume,
                self.count,
                |kind| temperature(kind).unwrap_or(1.0),
                self.velocities,
                &mut self.streams.stream_at(Purpose::Velocities, [0, 0]),
            )?;
            let leg = ((LEG * gas.count() as f64) as u64).max(LEAST_LEG);
            let motion = motion(&gas);
            (
                HomogeneousEngine::new(gas, motion, contacts, self.streams)?,
                leg,
            )
        };
        Ok(Box::new(Positionless { engine, leg }))
    }
}

type Mixed<S> = Scene<S, Smooth, Law, Species, Free>;
type Sticky<S> = Scene<S, Smooth, Law, Clusters, Free>;

fn scene<S, Z>(space: S, restitution: Law, sizes: Z) -> Scene<S, Smooth, Law, Z, Free> {
    Scene {
        space,
        surface: Smooth,
        restitution,
        sizes,
        field: Free,
    }
}

/// Access to recorded displacements and trajectories; `None` where they are not recorded.
trait Follows<P: SmoothPhysics>: PathRecord<P> {
    fn displacement(&self) -> Option<&DisplacementRecord<P>> {
        None
    }
    fn paths(&self) -> Option<&Trajectories<P>> {
        None
    }
}

impl<P: SmoothPhysics> Follows<P> for () {}

impl<P: SmoothPhysics> Follows<P> for Option<(DisplacementRecord<P>, Option<Trajectories<P>>)> {
    fn displacement(&self) -> Option<&DisplacementRecord<P>> {
        self.as_ref().map(|(places, _)| places)
    }
    fn paths(&self) -> Option<&Trajectories<P>> {
        self.as_ref().and_then(|(_, paths)| paths.as_ref())
    }
}

/// Access to the cluster sizes and counters of a contact rule; `None` for rules that only bounce.
trait Counts<P: SmoothPhysics>: ContactRule<P> {
    fn census(&self, _gas: &HomogeneousGas<P>) -> Option<Census> {
        None
    }
}

impl<P: SmoothPhysics> Counts<P> for Option<Tracers> {}

impl<P: SmoothPhysics<Sizes = Clusters>> Counts<P> for Sticking {
    fn census(&self, gas: &HomogeneousGas<P>) -> Option<Census> {
        let ledger = self.ledger;
        let ledger = [
            ("aggregation_loss", ledger.stuck),
            ("fragmentation_loss", ledger.shattered),
            ("mergers", ledger.mergers as f64),
            ("shatterings", ledger.shatterings as f64),
            ("refused", ledger.refused as f64),
        ];
        Some(Census {
            sizes: size_distribution(gas),
            ledger: ledger.map(|(name, value)| (name.to_owned(), value)).into(),
        })
    }
}

/// Content of a saved checkpoint of a gas without positions.
#[derive(Serialize, Deserialize)]
#[serde(bound(
    serialize = "S: Serialize, M: Serialize, C: Serialize",
    deserialize = "S: Deserialize<'de>, M: Deserialize<'de>, C: Deserialize<'de>"
))]
struct Kept<P: SmoothPhysics, S, M, C> {
    gas: HomogeneousCheckpoint<P, S, M, C>,
    leg: u64,
}

/// Gas without positions behind the interface [`Simulation`].
struct Positionless<P: SmoothPhysics, S, M, C> {
    engine: HomogeneousEngine<P, S, M, C>,
    /// Number of collisions in one leg, the segment of the run between two checkpoints.
    leg: u64,
}

impl<P, S, M, C> Simulation for Positionless<P, S, M, C>
where
    P: SmoothPhysics,
    S: SelectionMethod<P> + Send,
    M: Follows<P> + Send,
    C: Counts<P> + Send,
{
    fn time(&self) -> f64 {
        self.engine.time()
    }

    fn dimension(&self) -> usize {
        P::Space::DIMENSION
    }

    fn particle_count(&self) -> usize {
        self.engine.gas().count()
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
        let left = match budget {
            Budget::Unlimited => u64::MAX,
            Budget::Leg => self.leg,
            Budget::Collisions(most) => most,
        };
        let stop = self.engine.advance(until, left, observer);
        Ok(match stop.map_err(Failure::new)? {
            StopReason::Time | StopReason::Still => true,
            StopReason::Collisions => self.engine.time() >= until,
            StopReason::Paused | StopReason::Interrupted => false,
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

    fn visit_particles(&self, look: &mut dyn FnMut(&stosszahl_model::Particle)) {
        let gas = self.engine.gas();
        for particle in gas.alive() {
            let (radius, mass) = (gas.radius(particle), gas.mass(particle));
            look(&stosszahl_model::Particle {
                velocity: particle.velocity.spatial(),
                species: gas.scene().sizes().species_of(particle.tag),
                ..stosszahl_model::Particle::at_rest(radius, mass)
            });
        }
    }

    fn particles(&self) -> Particles {
        let mut all = Vec::with_capacity(self.particle_count());
        self.visit_particles(&mut |particle| all.push(*particle));
        Particles {
            time: self.time(),
            dimension: P::Space::DIMENSION,
            lengths: [0.0; 3],
            periodic: [true; 3],
            all,
        }
    }

    fn add_velocities(&mut self, changes: &[Vector3<f64>]) -> Result<(), Failure> {
        let flat = |change: &Vector3<f64>| P::Space::from_components(|axis| change[axis]);
        self.engine.kick(changes.iter().map(flat));
        Ok(())
    }

    fn scale_velocities(&mut self, factor: f64) -> Result<(), Failure> {
        self.engine.scale_velocities(factor).map_err(Failure::new)
    }

    fn save_checkpoint(&self) -> Result<Vec<u8>, Failure> {
        let kept = Kept {
            gas: self.engine.checkpoint(),
            leg: self.leg,
        };
        postcard::to_stdvec(&kept).map_err(Failure::new)
    }

    fn work_counters(&self) -> WorkCounters {
        let tally = self.engine.tally();
        let each = |count: u64| count as f64 / tally.collisions.max(1) as f64;
        let numbers: BTreeMap<String, f64> = [
            ("proposals_per_collision", each(tally.proposals)),
            ("trials_per_collision", each(tally.trials)),
            ("rebuilds", tally.rebuilds as f64),
            ("energy_lost", tally.energy_lost),
        ]
        .map(|(name, number)| (name.to_owned(), number))
        .into();
        WorkCounters {
            collisions: tally.collisions,
            numbers,
        }
    }

    fn memory_bytes(&self) -> usize {
        self.engine.memory_bytes()
    }

    fn track_displacements(&mut self) -> bool {
        self.engine.motion().displacement().is_some()
    }

    fn displacements(&self) -> Option<Vec<Vector3<f64>>> {
        let places = self.engine.motion().displacement()?;
        let now = self.engine.time();
        let particles = self.engine.gas().alive().enumerate();
        let way = |(index, particle): (usize, &super::gas::GasParticle<P>)| {
            places
                .displacement_at(index, &particle.velocity, now)
                .spatial()
        };
        Some(particles.map(way).collect())
    }

    fn time_averaged_displacements(
        &self,
        particles: &[u32],
        lags: &[f64],
    ) -> Option<Vec<[f64; 2]>> {
        let paths = self.engine.motion().paths()?;
        let velocities: Vec<VectorOf<P>> = self.engine.gas().alive().map(|p| p.velocity).collect();
        let mut sums = vec![[0.0; 2]; lags.len()];
        for &index in particles {
            let mut corners = paths.corners(paths.path_of(index)?).to_vec();
            if let Some(&(since, place)) = corners.last() {
                let end = self.engine.time();
                let velocity = *velocities.get(index as usize)?;
                corners.push((end, place + velocity * (end - since)));
            }
            for ([sum, squares], &lag) in sums.iter_mut().zip(lags) {
                let average = time_averaged(&corners, lag);
                *sum += average;
                *squares += average * average;
            }
        }
        Some(sums)
    }

    fn cluster_sizes(&self) -> Option<Census> {
        self.engine.contacts().census(self.engine.gas())
    }
}
