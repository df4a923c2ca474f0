//! Engines and observers of the Python package.

use std::collections::BTreeMap;
use std::ops::{Deref, DerefMut};
use std::sync::{Mutex, MutexGuard, PoisonError};

use nalgebra::Vector3;
use pyo3::prelude::*;
use pyo3::types::{PyByteArray, PyBytes};
use stosszahl_dsmc::Parameters;
use stosszahl_gas::{EventDriven, GasError, MonteCarlo, Scheme, SchemeSettings};
use stosszahl_model::{Collision, Interrupt, Observer, Simulation};

use crate::arrays::{WORDS, column, vectors, write_collision};
use crate::error::{Raise, raised};
use crate::gas::PyGas;
use crate::wait::{Messages, PyInterrupt, wait};

/// Largest number of collisions for which a batch reserves memory at once.
const MOST_RESERVED: usize = 1 << 16;

/// Engine behind a Python object: exact dynamics or Monte Carlo.
enum Kind {
    Exact(EventDriven),
    Chaos(MonteCarlo),
}

impl Deref for Kind {
    type Target = dyn Simulation;

    fn deref(&self) -> &Self::Target {
        match self {
            Self::Exact(engine) => &**engine,
            Self::Chaos(engine) => &**engine,
        }
    }
}

impl DerefMut for Kind {
    fn deref_mut(&mut self) -> &mut Self::Target {
        match self {
            Self::Exact(engine) => &mut **engine,
            Self::Chaos(engine) => &mut **engine,
        }
    }
}

/// Engine for Python: exact dynamics or Monte Carlo of a gas, as `stosszahl.engines` uses it.
#[pyclass(name = "Engine", module = "stosszahl._native", frozen)]
pub struct PyEngine(Mutex<Kind>);

/// Observer that passes collisions to Python in batches, and pauses the engine if Python has
/// failed.
struct Batches {
    size: usize,
    bytes: Vec<u8>,
    messages: Messages<Vec<u8>>,
    pause: Interrupt,
}

impl Batches {
    fn flush(&mut self) {
        if self.bytes.is_empty() {
            return;
        }
        let next = Vec::with_capacity(self.bytes.capacity());
        if !self.messages.send(std::mem::replace(&mut self.bytes, next)) {
            self.pause.raise();
        }
    }
}

impl Observer for Batches {
    fn on_collisions(&mut self, batch: &[Collision]) {
        for one in batch {
            write_collision(one, &mut self.bytes);
            if self.bytes.len() >= 8 * WORDS * self.size {
                self.flush();
            }
        }
    }
}

/// Observer of impact parameters for Python that runs without calling Python code.
#[pyclass(name = "ImpactParameters", module = "stosszahl._native", frozen)]
pub struct PyImpactParameters(Mutex<stosszahl_analysis::impact::ImpactParameters>);

/// Observer that fills [`PyImpactParameters`], which Python may read at any time.
struct Shared<'a>(&'a PyImpactParameters);

impl Observer for Shared<'_> {
    fn on_collisions(&mut self, batch: &[Collision]) {
        Observer::on_collisions(&mut *self.0.lock(), batch);
    }
}

impl PyImpactParameters {
    fn lock(&self) -> MutexGuard<'_, stosszahl_analysis::impact::ImpactParameters> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[pymethods]
impl PyImpactParameters {
    #[new]
    fn new(dimension: usize, bins: usize) -> Self {
        Self(Mutex::new(
            stosszahl_analysis::impact::ImpactParameters::new(dimension, bins),
        ))
    }

    fn collisions(&self) -> u64 {
        self.lock().collisions()
    }

    fn densities(&self) -> Vec<f64> {
        self.lock().densities()
    }

    fn slope(&self) -> Option<f64> {
        self.lock().slope()
    }

    fn slope_error(&self) -> Option<f64> {
        self.lock().slope_error()
    }
}

/// Flux through a boundary into the gas: name, particles, momentum, energy.
type Flux = (String, f64, [f64; 3], f64);

impl Kind {
    /// Advances the engine up to a time, unless an interrupt is raised.
    fn go(
        &mut self,
        until: f64,
        observer: &mut dyn Observer,
        stop: &PyInterrupt,
    ) -> Result<(), GasError> {
        self.set_pause_flag(&stop.soon);
        self.set_stop_flag(&stop.now);
        match self {
            Self::Exact(engine) => engine.advance(until, observer),
            Self::Chaos(engine) => engine.advance(until, observer),
        }
    }
}

impl PyEngine {
    fn of(kind: Kind) -> Self {
        Self(Mutex::new(kind))
    }

    /// Locks the engine; an error if another thread is using it, or if its work was broken off.
    fn lock(&self) -> PyResult<MutexGuard<'_, Kind>> {
        let Ok(engine) = self.0.try_lock() else {
            let text = "the engine is at work; an observer, or another thread, has to wait until advance ends";
            return Err(raised("EngineError", text));
        };
        if engine.is_interrupted() {
            let text = "the engine was interrupted in the middle of a step and has no state; start again from an earlier one";
            return Err(raised("EngineError", text));
        }
        Ok(engine)
    }
}

fn scheme(name: &str, stiffness: Option<f64>, radius: Option<f64>) -> PyResult<Scheme> {
    let Some(scheme) = Scheme::named(name) else {
        let names = Scheme::ALL.map(Scheme::name).join(", ");
        let text = format!("scheme {name:?} is not known; allowed: {names}");
        return Err(raised("GasError", &text));
    };
    Ok(scheme.with_settings(SchemeSettings {
        stiffness,
        radius,
        ..SchemeSettings::default()
    }))
}

#[pymethods]
impl PyEngine {
    #[staticmethod]
    fn event_driven(gas: &PyGas) -> PyResult<Self> {
        let engine = EventDriven::new(&gas.0).map_err(Raise::into_exception)?;
        Ok(Self::of(Kind::Exact(engine)))
    }

    /// Creates a Monte Carlo engine for a gas without positions.
    #[staticmethod]
    fn without_positions(gas: &PyGas) -> PyResult<Self> {
        let engine = MonteCarlo::new(&gas.0).map_err(Raise::into_exception)?;
        Ok(Self::of(Kind::Chaos(engine)))
    }

    /// Creates a Monte Carlo engine in cells, with a scheme given by its name.
    #[staticmethod]
    #[pyo3(signature = (gas, name, *, cell_size, steps_per_cell_crossing, max_contact_value, stiffness, partner_radius))]
    fn in_cells(
        gas: &PyGas,
        name: &str,
        cell_size: Option<f64>,
        steps_per_cell_crossing: Option<f64>,
        max_contact_value: Option<f64>,
        stiffness: Option<f64>,
        partner_radius: Option<f64>,
    ) -> PyResult<Self> {
        let defaults = MonteCarlo::defaults(&gas.0, scheme(name, stiffness, partner_radius)?);
        let parameters = Parameters {
            cell_size,
            steps_per_cell_crossing: steps_per_cell_crossing
                .unwrap_or(defaults.steps_per_cell_crossing),
            max_contact_value: max_contact_value.unwrap_or(defaults.max_contact_value),
            ..defaults
        };
        let engine = MonteCarlo::with(&gas.0, parameters).map_err(Raise::into_exception)?;
        Ok(Self::of(Kind::Chaos(engine)))
    }

    /// Advances the engine to a time. The observer is none, an
    /// [`ImpactParameters`](PyImpactParameters), or a function of bytes.
    fn advance(
        &self,
        py: Python<'_>,
        until: f64,
        observer: Option<&Bound<'_, PyAny>>,
        batch: usize,
    ) -> PyResult<()> {
        let mut guard = self.lock()?;
        let engine = &mut *guard;
        let stop = PyInterrupt::default();
        let rust = observer.and_then(|one| one.cast::<PyImpactParameters>().ok());
        let python = observer
            .filter(|_| rust.is_none())
            .map(|one| one.clone().unbind());
        let rust = rust.map(Bound::get);
        let looks = python.is_some();
        let work = |messages: Messages<Vec<u8>>| match rust {
            Some(one) => engine.go(until, &mut Shared(one), &stop),
            None if looks => {
                let size = batch.max(1);
                let mut batches = Batches {
                    size,
                    bytes: Vec::with_capacity(8 * WORDS * size.min(MOST_RESERVED)),
                    messages,
                    pause: stop.soon.clone(),
                };
                let done = engine.go(until, &mut batches, &stop);
                batches.flush();
                done
            }
            None => engine.go(until, &mut (), &stop),
        };
        let hear = |py: Python<'_>, bytes: Vec<u8>| match &python {
            Some(function) => function.call1(py, (PyBytes::new(py, &bytes),)).map(drop),
            None => Ok(()),
        };
        let done = wait(py, &stop, work, hear, |_| Ok(()))?;
        done.map_err(Raise::into_exception)?;
        Ok(())
    }

    /// Runs elastic collisions until the gas has forgotten its start.
    fn equilibrate(&self, py: Python<'_>, collisions_per_particle: f64) -> PyResult<()> {
        let mut guard = self.lock()?;
        let Kind::Exact(engine) = &mut *guard else {
            let text = "equilibrate is of EventDriven; equilibrate there and start Monte Carlo from its state";
            return Err(raised("GasError", text));
        };
        let stop = PyInterrupt::default();
        let work = |_: Messages<()>| engine.equilibrate_unless(collisions_per_particle, &stop.soon);
        let done = wait(py, &stop, work, |_, ()| Ok(()), |_| Ok(()))?;
        done.map_err(Raise::into_exception)?;
        Ok(())
    }

    /// Returns the current state of the engine as a gas.
    fn state(&self) -> PyResult<PyGas> {
        Ok(PyGas(match &*self.lock()? {
            Kind::Exact(engine) => engine.state(),
            Kind::Chaos(engine) => engine.state(),
        }))
    }

    fn column<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyByteArray>> {
        column(py, &self.lock()?.particles(), name)
    }

    fn time(&self) -> PyResult<f64> {
        Ok(self.lock()?.time())
    }

    fn count(&self) -> PyResult<usize> {
        Ok(self.lock()?.particle_count())
    }

    fn dimension(&self) -> PyResult<usize> {
        Ok(self.lock()?.dimension())
    }

    fn temperature(&self) -> PyResult<f64> {
        Ok(self.lock()?.temperature())
    }

    /// Returns the number of collisions so far, and the work counters by name.
    fn work(&self) -> PyResult<(u64, BTreeMap<String, f64>)> {
        let work = self.lock()?.work_counters();
        Ok((work.collisions, work.numbers))
    }

    /// Returns the flux of each boundary into the gas: name, particles, momentum, energy.
    fn boundaries(&self) -> PyResult<Vec<Flux>> {
        let all = self.lock()?.boundary_fluxes();
        let each = all.into_iter();
        Ok(each
            .map(|one| (one.name, one.particles, one.momentum, one.energy))
            .collect())
    }

    /// Adds a given velocity change to each particle.
    fn kick(&self, changes: Vec<u8>) -> PyResult<()> {
        let mut engine = self.lock()?;
        let changes: Vec<Vector3<f64>> = vectors(&changes, engine.dimension())
            .into_iter()
            .map(Vector3::from)
            .collect();
        engine
            .add_velocities(&changes)
            .map_err(|error| GasError::from(error).into_exception())
    }

    fn scale_velocities(&self, factor: f64) -> PyResult<()> {
        let done = self.lock()?.scale_velocities(factor);
        done.map_err(|error| GasError::from(error).into_exception())
    }

    fn track_displacements(&self) -> PyResult<bool> {
        Ok(self.lock()?.track_displacements())
    }

    fn displacements<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyByteArray>>> {
        let engine = self.lock()?;
        let dimension = engine.dimension();
        let Some(all) = engine.displacements() else {
            return Ok(None);
        };
        let made = PyByteArray::new_with(py, 8 * dimension * all.len(), |bytes| {
            let numbers = all.iter().flat_map(|one| one.iter().take(dimension));
            for (place, number) in bytes.chunks_exact_mut(8).zip(numbers) {
                place.copy_from_slice(&number.to_ne_bytes());
            }
            Ok(())
        });
        made.map(Some)
    }
}
