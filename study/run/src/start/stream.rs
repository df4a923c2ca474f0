//! Start of independent particles, made one after the other.
//!
//! Particles that may overlap are placed independently of each other. So each process can make all
//! of them in turn and keep its own. The numbers are those of [`placed`](super::placed), which holds
//! the whole start.

use std::sync::{Mutex, PoisonError};

use nalgebra::Vector3;
use stosszahl_dsmc::StartStream;
use stosszahl_model::random::{Purpose, Streams};
use stosszahl_model::{
    Free, Interrupt, Law, Plane, Rough, Scene, Sizes as _, Smooth, Space, Species, Surface,
    Vector as _, Volume, initial,
};

use super::error::StartError;
use super::streams_of;
use crate::plan::{CasePlan, Confinement, EnginePlan};
use crate::start::places::StartSpace;

/// Independent particles of a replica of one engine, in one or several sets.
pub(crate) struct IndependentStart<'a> {
    plan: &'a CasePlan,
    sets: usize,
    streams: Streams,
    interrupt: &'a Interrupt,
    /// First error of a visit.
    failure: Mutex<Option<StartError>>,
}

impl<'a> IndependentStart<'a> {
    /// Returns the start of an engine; `None` if its particles exclude each other, come from a file,
    /// or stand in several simulators each for one particle of a shared state, or if weights differ
    /// by region.
    pub(crate) fn new(
        plan: &'a CasePlan,
        engine: &EnginePlan,
        streams: Streams,
        interrupt: &'a Interrupt,
    ) -> Option<Self> {
        let sets = engine.copies();
        plan.has_independent_start(engine).then(|| Self {
            plan,
            sets,
            streams,
            interrupt,
            failure: Mutex::default(),
        })
    }

    /// Takes the first error of a visit.
    pub(crate) fn take_failure(&self) -> Option<StartError> {
        let mut failure = self.failure.lock().unwrap_or_else(PoisonError::into_inner);
        failure.take()
    }

    /// Visits all sets in turn; `visit` gets the streams of a set and the first index in it.
    fn visit_sets(
        &self,
        visit: &mut dyn FnMut(Streams, usize) -> Result<(), StartError>,
    ) -> Result<(), String> {
        let mut sets = 0..self.sets;
        let visited = sets.try_for_each(|set| {
            if self.interrupt.is_raised() {
                return Err(StartError::Interrupted);
            }
            visit(streams_of(set as u64, self.streams), set * self.particles())
        });
        visited.map_err(|error| {
            let error = error.in_units(self.plan);
            let why = error.to_string();
            let mut failure = self.failure.lock().unwrap_or_else(PoisonError::into_inner);
            failure.get_or_insert(error);
            why
        })
    }

    fn visit_places<S: Space>(
        &self,
        look: &mut dyn FnMut(usize, Vector3<f64>),
    ) -> Result<(), String> {
        let plan = self.plan;
        self.visit_sets(&mut |streams, first| {
            let sizes = plan.gas.particles.species(self.particles())?;
            let radius = |index| sizes.radius(sizes.tag_of(index));
            let confinement = Confinement::<S>::from_plan(plan)?;
            let space = StartSpace::from_plan(plan, &confinement);
            let mut stream = streams.stream_at(Purpose::Placement, [0, 0]);
            let mut look = |index: usize, at: S::Vector| look(first + index, at.spatial());
            space.place_all(
                self.particles(),
                &radius,
                &mut stream,
                self.interrupt,
                &mut look,
            )
        })
    }

    fn visit_drawn<S: Space>(
        &self,
        look: &mut dyn FnMut(usize, Vector3<f64>),
    ) -> Result<(), String> {
        let plan = self.plan;
        let drift = plan.case.start.velocity.as_ref();
        let drift = drift.map(|drift| S::from_components(|axis| drift[axis]));
        self.visit_sets(&mut |streams, first| {
            let scene = self.scene::<S, _>(Smooth)?;
            let stream = || streams.stream_at(Purpose::Velocities, [0, 0]);
            let (count, law) = (self.particles(), plan.gas.velocities);
            let temperature = plan.gas.temperature;
            initial::visit_drawn_velocities(
                &scene,
                count,
                temperature,
                law,
                stream,
                &mut |index, mut velocity| {
                    if let Some(drift) = drift {
                        velocity += drift;
                    }
                    look(first + index, velocity.spatial());
                },
            );
            Ok(())
        })
    }

    fn visit_thermal<S: Space>(
        &self,
        rough: Rough,
        look: &mut dyn FnMut(usize, Vector3<f64>),
    ) -> Result<(), String>
    where
        Rough: Surface<S>,
    {
        let temperature = self.plan.case.start.spin_temperature;
        let temperature = temperature.unwrap_or(self.plan.gas.temperature);
        self.visit_sets(&mut |streams, first| {
            let scene = self.scene::<S, _>(rough)?;
            let stream = || streams.stream_at(Purpose::Spins, [0, 0]);
            let count = self.particles();
            initial::visit_thermal_spins(&scene, count, temperature, stream, &mut |index, spin| {
                look(first + index, <Rough as Surface<S>>::spin_in_space(spin));
            });
            Ok(())
        })
    }

    /// Model of the particles, from which velocities are drawn.
    fn scene<S: Space, C: Surface<S>>(
        &self,
        surface: C,
    ) -> Result<Scene<S, C, Law, Species, Free>, StartError> {
        Ok(Scene {
            space: S::default(),
            surface,
            restitution: Law::ELASTIC,
            sizes: self.plan.gas.particles.species(self.particles())?,
            field: Free,
        })
    }
}

impl StartStream for IndependentStart<'_> {
    fn dimension(&self) -> usize {
        self.plan.gas.dimension
    }

    fn lengths(&self) -> [f64; 3] {
        self.plan.gas.lengths
    }

    fn particles(&self) -> usize {
        if self.plan.case.start.empty {
            0
        } else {
            self.plan.count()
        }
    }

    fn sets(&self) -> usize {
        self.sets
    }

    fn visit_positions(&self, look: &mut dyn FnMut(usize, Vector3<f64>)) -> Result<(), String> {
        match self.plan.gas.dimension {
            2 => self.visit_places::<Plane>(look),
            _ => self.visit_places::<Volume>(look),
        }
    }

    fn visit_velocities(&self, look: &mut dyn FnMut(usize, Vector3<f64>)) -> Result<(), String> {
        match self.plan.gas.dimension {
            2 => self.visit_drawn::<Plane>(look),
            _ => self.visit_drawn::<Volume>(look),
        }
    }

    fn visit_spins(&self, look: &mut dyn FnMut(usize, Vector3<f64>)) -> Result<(), String> {
        match (self.plan.gas.particles.rough, self.plan.gas.dimension) {
            (None, _) => Ok(()),
            (Some(rough), 2) => self.visit_thermal::<Plane>(rough, look),
            (Some(rough), _) => self.visit_thermal::<Volume>(rough, look),
        }
    }
}
