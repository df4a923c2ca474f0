//! Gases of the Python package: [`stosszahl_gas::Gas`] built from a description and arrays.

use nalgebra::{Vector3, vector};
use pyo3::prelude::*;
use pyo3::types::PyByteArray;
use stosszahl_gas::{Face, Rebound, Wall};
use stosszahl_model::walls::Vibration;
use stosszahl_model::{
    Constant, DeltaModel, InvalidValue, Law, Particle, Particles, ThresholdModel, Viscoelastic,
    Volume,
};

use crate::arrays::{column, vectors};
use crate::error::Raise;
use crate::wait::{Messages, PyInterrupt, wait};

/// Gas for Python: particles, box and contact laws, as `stosszahl.Gas` uses them.
#[pyclass(name = "Gas", module = "stosszahl._native", frozen)]
pub struct PyGas(pub stosszahl_gas::Gas);

/// Wall passed from Python, as `stosszahl.Wall` has it.
#[derive(FromPyObject)]
struct GivenWall {
    restitution: f64,
    slip: f64,
    temperature: Option<f64>,
    sliding: [f64; 2],
    vibration: Option<(f64, f64)>,
}

/// Description of a gas passed from Python, as `stosszahl.Gas` keeps it.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
struct Description {
    dimension: usize,
    number: usize,
    species: Vec<(usize, f64, f64)>,
    packing_fraction: Option<f64>,
    box_size: Option<[f64; 2]>,
    restitution: GivenLaw,
    tangential_restitution: Option<f64>,
    walls: Vec<(usize, [GivenFace; 2])>,
    gravity: Option<[f64; 2]>,
    shear_rate: Option<f64>,
    contact_time: f64,
    temperature: f64,
    seed: u64,
    replica: u64,
}

/// Law of normal restitution passed from Python: a number, or one of the classes of `stosszahl` by
/// its attributes.
#[derive(FromPyObject)]
enum GivenLaw {
    Constant(f64),
    Delta {
        coefficient: f64,
        delta: f64,
    },
    Threshold {
        coefficient: f64,
        elastic_below: f64,
    },
    Viscoelastic {
        strength: f64,
    },
}

impl GivenLaw {
    fn law(&self) -> Result<Law, InvalidValue> {
        Ok(match *self {
            Self::Constant(coefficient) => Constant::new(coefficient)?.into(),
            Self::Delta { coefficient, delta } => DeltaModel::new(coefficient, delta)?.into(),
            Self::Threshold {
                coefficient,
                elastic_below,
            } => ThresholdModel::new(coefficient, elastic_below)?.into(),
            Self::Viscoelastic { strength } => Viscoelastic::new(strength)?.into(),
        })
    }
}

/// Face of the box passed from Python.
#[derive(FromPyObject)]
enum GivenFace {
    Wall(GivenWall),
    Word(String),
}

/// Custom initial state passed from Python in arrays; vectors have two components for disks, three
/// for spheres.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
struct Start {
    time: f64,
    lengths: [f64; 3],
    periodic: [bool; 3],
    positions: Vec<u8>,
    velocities: Vec<u8>,
    spins: Vec<u8>,
    weights: Vec<u8>,
}

impl GivenFace {
    fn face(&self) -> Result<Face<Volume>, stosszahl_gas::GasError> {
        let wall = match self {
            Self::Word(word) if word == "open" => return Ok(Face::Open),
            Self::Word(_) => return Ok(Face::Periodic),
            Self::Wall(wall) => wall,
        };
        let rebound = match wall.temperature {
            Some(temperature) => Rebound::Diffuse { temperature },
            None => Rebound::Restitutive {
                restitution: wall.restitution,
                slip: wall.slip,
            },
        };
        let vibration = match wall.vibration {
            Some((amplitude, period)) => Some(Vibration::new(amplitude, period)?),
            None => None,
        };
        Ok(Face::Wall(Wall {
            sliding: vector![wall.sliding[0], wall.sliding[1], 0.0],
            vibration,
            ..Wall::still(rebound)
        }))
    }
}

impl Start {
    fn particles(&self, dimension: usize) -> Particles {
        let spin_axes = if dimension == 2 { 1 } else { 3 };
        let velocities = vectors(&self.velocities, dimension);
        let positions = vectors(&self.positions, dimension);
        let spins = vectors(&self.spins, spin_axes);
        let weights = vectors(&self.weights, 1);
        let all = velocities.iter().enumerate().map(|(index, velocity)| {
            let of = |list: &[[f64; 3]]| list.get(index).map_or_else(Vector3::zeros, |&v| v.into());
            let spin = of(&spins);
            Particle {
                position: of(&positions),
                velocity: (*velocity).into(),
                spin: if dimension == 2 {
                    vector![0.0, 0.0, spin[0]]
                } else {
                    spin
                },
                weight: weights.get(index).map_or(1.0, |weight| weight[0]),
                ..Particle::at_rest(0.0, 0.0)
            }
        });
        Particles {
            time: self.time,
            dimension,
            lengths: self.lengths,
            periodic: self.periodic,
            all: all.collect(),
        }
    }
}

fn build(
    given: &Description,
    start: Option<&Start>,
    stop: &PyInterrupt,
) -> Result<stosszahl_gas::Gas, stosszahl_gas::GasError> {
    let mut gas = match given.dimension {
        2 => stosszahl_gas::Gas::disks(given.number),
        _ => stosszahl_gas::Gas::spheres(given.number),
    };
    for &(count, radius, mass) in &given.species {
        gas = gas.and(count, radius, mass);
    }
    if let Some(packing) = given.packing_fraction {
        gas = gas.packing_fraction(packing);
    }
    if let Some(sides) = given.box_size {
        gas = gas.box_size(sides);
    }
    if let Some(coefficient) = given.tangential_restitution {
        gas = gas.tangential_restitution(coefficient);
    }
    for (axis, [lower, upper]) in &given.walls {
        gas = gas.walls(*axis, [lower.face()?, upper.face()?]);
    }
    if let Some(acceleration) = given.gravity {
        gas = gas.gravity(acceleration);
    }
    if let Some(rate) = given.shear_rate {
        gas = gas.shear_rate(rate);
    }
    if let Some(start) = start {
        gas = gas.start_from(start.particles(given.dimension));
    }
    gas.law(given.restitution.law()?)
        .temperature(given.temperature)
        .contact_time(given.contact_time)
        .seed(given.seed)
        .replica(given.replica)
        .set_stop_flag(&stop.soon)
        .build()
}

#[pymethods]
impl PyGas {
    #[new]
    fn new(py: Python<'_>, description: Description, start: Option<Start>) -> PyResult<Self> {
        let stop = PyInterrupt::default();
        let work = |_: Messages<()>| build(&description, start.as_ref(), &stop);
        let gas = wait(py, &stop, work, |_, ()| Ok(()), |_| Ok(()))?;
        Ok(Self(gas.map_err(Raise::into_exception)?))
    }

    /// Returns one property of all particles as bytes, by its name.
    fn column<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyByteArray>> {
        column(py, &self.0.particles, name)
    }

    /// Returns the number of particles of the gas.
    fn count(&self) -> usize {
        self.0.particles.all.len()
    }

    /// Returns the time of the gas, the sides of the box, and which axes are periodic.
    fn frame(&self) -> (f64, [f64; 3], [bool; 3]) {
        let all = &self.0.particles;
        (all.time, all.lengths, all.periodic)
    }

    /// Returns the granular temperature of the gas \[energy\].
    fn temperature(&self) -> f64 {
        self.0.temperature()
    }

    /// Returns the area or volume of the gas \[length^D\].
    fn volume(&self) -> f64 {
        self.0.volume
    }

    /// Returns the displacement of the periodic image above in a shear flow \[length\].
    fn shear_offset(&self) -> f64 {
        self.0.shear_offset()
    }

    /// Returns Haff's cooling time of the gas \[time\]; `None` if there is none.
    fn haff_time(&self) -> Option<f64> {
        self.0.haff_time()
    }
}
