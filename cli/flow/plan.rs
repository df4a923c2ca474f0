//! What follows from the case of a flow.

use stosszahl_analysis::Error as AnalysisError;
use stosszahl_analysis::fields::{Freedom, Grid};
use stosszahl_dsmc::{Copies, Displacement, Neighbourhood, Parameters};
use stosszahl_model::walls::{Vibration, WallError};
use stosszahl_model::{Face, Rebound, Rough, Space, Species, Wall, Walls, species};

use super::FlowError;
use super::case::{self, FaceWord, Flow, MonteCarlo, Scheme, WallsActOn};

/// A case of a flow and all that is derived from it.
#[derive(Clone, Debug)]
pub struct Plan {
    /// The case.
    pub flow: Flow,
    /// Radius, mass and number of each species.
    pub kinds: Vec<species::Kind>,
    /// The same, as engines have it.
    pub sizes: Species,
    /// Volume of the box (area in the plane).
    pub volume: f64,
}

impl Plan {
    /// Derives it.
    ///
    /// # Errors
    /// [`FlowError::Sizes`] if there are too many grains.
    pub fn new(flow: &Flow) -> Result<Self, FlowError> {
        let volume = flow.domain.size.iter().product();
        let mut kinds: Vec<species::Kind> = flow
            .species
            .iter()
            .map(|species| species::Kind {
                radius: 0.5 * species.diameter,
                mass: species.mass,
                count: species.number as usize,
            })
            .collect();
        if let Some(wanted) = flow.start.mean_free_path {
            let found = mean_free_path(&kinds, volume, flow.dimension());
            // Cross sections grow with the power D - 1 of the diameter.
            let scale = (found / wanted).powf(1.0 / (flow.dimension() as f64 - 1.0));
            for kind in &mut kinds {
                kind.radius *= scale;
            }
        }
        let sizes = Species::new(kinds.clone()).ok_or(FlowError::Sizes {
            grains: flow.grains(),
        })?;
        Ok(Self {
            flow: flow.clone(),
            kinds,
            sizes,
            volume,
        })
    }

    /// Number of axes.
    pub fn dimension(&self) -> usize {
        self.flow.dimension()
    }

    /// Name of a species.
    pub fn name(&self, species: usize) -> String {
        let given = self.flow.species[species].name.clone();
        given.unwrap_or_else(|| (species + 1).to_string())
    }

    /// Mean free path of the uniform dilute box \[length\].
    pub fn mean_free_path(&self) -> f64 {
        mean_free_path(&self.kinds, self.volume, self.dimension())
    }

    /// Collisions per grain and time in the uniform dilute box.
    pub fn collision_rate(&self) -> f64 {
        let total: f64 = self.kinds.iter().map(|kind| kind.count as f64).sum();
        let mean_speed = match self.dimension() {
            2 => std::f64::consts::FRAC_PI_2,
            _ => 8.0 / std::f64::consts::PI,
        };
        let rates = self.kinds.iter().map(|one| {
            let with = self.kinds.iter().map(|other| {
                let density = other.count as f64 / self.volume;
                let over = self.flow.start.temperature * (1.0 / one.mass + 1.0 / other.mass);
                density * cross_section(one, other, self.dimension()) * (mean_speed * over).sqrt()
            });
            one.count as f64 / total * with.sum::<f64>()
        });
        rates.sum()
    }

    /// Share of the box that grains cover.
    pub fn packing_fraction(&self) -> f64 {
        let ball = |radius: f64| match self.dimension() {
            2 => stosszahl_model::Plane::ball(radius),
            _ => stosszahl_model::Volume::ball(radius),
        };
        let covered = self.kinds.iter();
        covered
            .map(|kind| kind.count as f64 * ball(kind.radius))
            .sum::<f64>()
            / self.volume
    }

    /// Components of velocities and of spins.
    pub fn freedom(&self) -> Freedom {
        let rotations = match (self.flow.is_rough(), self.dimension()) {
            (false, _) => 0,
            (true, 2) => 1,
            (true, _) => 3,
        };
        Freedom {
            dimension: self.dimension(),
            rotations,
        }
    }

    /// Temperature of rotation at the start \[energy\].
    pub fn spin_temperature(&self) -> f64 {
        let start = &self.flow.start;
        start.spin_temperature.unwrap_or(start.temperature)
    }

    /// A list of components as a vector.
    pub fn vector<S: Space>(list: &[f64]) -> S::Vector {
        S::vector(|axis| list.get(axis).copied().unwrap_or(0.0))
    }

    /// The faces of the box.
    ///
    /// # Errors
    /// [`WallError`], which the checks of the case should have kept away.
    pub fn walls<S: Space>(&self) -> Result<Walls<S>, WallError> {
        let faces: Vec<[Face<S>; 2]> = (0..S::DIMENSION)
            .map(|axis| [0, 1].map(|side| face::<S>(self.flow.walls.at(axis, side))))
            .collect();
        Walls::new(&faces)
    }

    /// The surface of rough grains; `None` for smooth ones.
    pub fn rough<S: Space>(&self) -> Option<Rough> {
        let contact = &self.flow.contact;
        let inertia = contact.inertia.unwrap_or(S::INERTIA);
        Rough::new(contact.tangential_restitution?, inertia)
    }

    /// Whether walls act on the centres of grains in Monte Carlo.
    pub fn walls_act_on_centres(&self, dsmc: &MonteCarlo) -> bool {
        match dsmc.walls_act_on {
            Some(place) => place == WallsActOn::Centre,
            None => dsmc.scheme == Scheme::Boltzmann,
        }
    }

    /// Side of a Monte Carlo cell \[length\]; `None` where the engine chooses it.
    pub fn cell_size(&self, dsmc: &MonteCarlo) -> Option<f64> {
        if dsmc.cell_size.is_some() || dsmc.scheme == Scheme::ContactPoint {
            return dsmc.cell_size;
        }
        let simulators = self.flow.grains() as f64 * dsmc.simulators_per_grain as f64;
        let ten = (10.0 * self.volume / simulators).powf(1.0 / self.dimension() as f64);
        let chi = match (dsmc.scheme, self.dimension()) {
            (Scheme::Boltzmann, _) => 1.0,
            (_, 2) => stosszahl_model::Plane::contact_value(self.packing_fraction().min(0.6)),
            _ => stosszahl_model::Volume::contact_value(self.packing_fraction().min(0.5)),
        };
        let wanted = (0.5 * self.mean_free_path() / chi).max(ten);
        let largest = self
            .kinds
            .iter()
            .map(|kind| kind.radius)
            .fold(0.0, f64::max);
        Some(if dsmc.scheme == Scheme::Boltzmann {
            wanted
        } else {
            wanted.max(4.0 * largest)
        })
    }

    /// The numerical choices of Monte Carlo.
    pub fn parameters(&self, dsmc: &MonteCarlo) -> Parameters {
        let scheme = match dsmc.scheme {
            Scheme::Boltzmann => stosszahl_dsmc::Scheme::Boltzmann,
            Scheme::Enskog => stosszahl_dsmc::Scheme::Enskog(Neighbourhood::Cells(1)),
            Scheme::FreeVolume => stosszahl_dsmc::Scheme::FreeVolume,
            Scheme::ContactPoint => stosszahl_dsmc::Scheme::ContactPoint { radius: None },
        };
        Parameters {
            scheme,
            displacement: Displacement::None,
            cell_size: self.cell_size(dsmc),
            simulators_per_disk: dsmc.simulators_per_grain as u32,
            copies: Copies::Independent,
            steps_per_crossing: dsmc.steps_per_crossing.max(1.0),
            largest_contact_value: 100.0,
        }
    }

    /// The grid of the fields.
    ///
    /// # Errors
    /// As [`Grid::new`].
    pub fn grid(&self) -> Result<Grid, AnalysisError> {
        let size = &self.flow.domain.size;
        let depth = size.get(2).copied().unwrap_or(1.0);
        let counts = self.flow.fields.cells.map(|count| count as usize);
        Grid::new([size[0], size[1]], counts, depth)
    }

    /// Length of a block of time.
    pub fn block(&self) -> f64 {
        self.flow.run.until / self.flow.run.blocks as f64
    }

    /// Time of a sample, from 0 to `run.samples`; the last is the end exactly.
    pub fn sample_time(&self, sample: u64) -> f64 {
        self.flow.run.until * (sample as f64 / self.flow.run.samples as f64)
    }

    /// Names of the engines, in their order.
    pub fn engines(&self) -> Vec<&'static str> {
        let engines = &self.flow.engine;
        let ed = engines.ed.as_ref().map(|_| "ed");
        ed.into_iter()
            .chain(engines.dsmc.as_ref().map(|_| "dsmc"))
            .collect()
    }

    /// Whether nothing but grains acts on grains: periodic, without field.
    pub fn is_homogeneous(&self) -> bool {
        let flow = &self.flow;
        let periodic = (0..3).all(|axis| *flow.walls.at(axis, 0) == case::Face::default());
        periodic && flow.gravity.is_none() && flow.obstacle.is_empty()
    }

    /// Derived quantities, for the eye.
    pub fn derived(&self) -> Vec<(&'static str, f64)> {
        let mut list = vec![
            ("grains", self.flow.grains() as f64),
            ("volume_of_the_box", self.volume),
            ("number_density", self.flow.grains() as f64 / self.volume),
            ("packing_fraction", self.packing_fraction()),
            ("diameter_of_the_first_species", 2.0 * self.kinds[0].radius),
            ("mean_free_path_of_the_dilute_gas", self.mean_free_path()),
            (
                "mean_free_time_of_the_dilute_gas",
                1.0 / self.collision_rate(),
            ),
            ("length_of_a_block", self.block()),
        ];
        if let Some(dsmc) = &self.flow.engine.dsmc
            && let Some(size) = self.cell_size(dsmc)
        {
            let per_cell = self.flow.grains() as f64 * dsmc.simulators_per_grain as f64
                / self.volume
                * size.powi(self.dimension() as i32);
            list.push(("side_of_a_cell", size));
            list.push(("simulators_in_a_cell", per_cell));
            list.push((
                "side_of_a_cell_over_mean_free_path",
                size / self.mean_free_path(),
            ));
        }
        list
    }
}

/// Cross section of two grains \[length^(D-1)\].
fn cross_section(one: &species::Kind, other: &species::Kind, dimension: usize) -> f64 {
    let distance = one.radius + other.radius;
    match dimension {
        2 => stosszahl_model::Plane::cross_section(distance),
        _ => stosszahl_model::Volume::cross_section(distance),
    }
}

/// Mean over the grains of `1/sum_q n_q s_pq sqrt(1 + m_p/m_q)`, the mean free path of a dilute mixture at one
/// temperature (Kawasaki 1985, A.1; Bird 1976).
fn mean_free_path(kinds: &[species::Kind], volume: f64, dimension: usize) -> f64 {
    let total: f64 = kinds.iter().map(|kind| kind.count as f64).sum();
    let paths = kinds.iter().map(|one| {
        let rate: f64 = kinds
            .iter()
            .map(|other| {
                let density = other.count as f64 / volume;
                density
                    * cross_section(one, other, dimension)
                    * (1.0 + one.mass / other.mass).sqrt()
            })
            .sum();
        one.count as f64 / total / rate
    });
    paths.sum()
}

/// A face as the model has it.
fn face<S: Space>(written: &case::Face) -> Face<S> {
    match written {
        case::Face::Word(FaceWord::Periodic) => Face::Periodic,
        case::Face::Word(FaceWord::Open) => Face::Open,
        case::Face::Word(FaceWord::Specular) => Face::Wall(Wall::specular()),
        case::Face::Wall(wall) => Face::Wall(Wall {
            rebound: rebound(wall.restitution, wall.slip, wall.temperature),
            sliding: Plan::vector::<S>(wall.sliding.as_deref().unwrap_or_default()),
            vibration: wall
                .vibration
                .and_then(|v| Vibration::new(v.amplitude, v.period)),
        }),
    }
}

/// The law of a surface as the model has it.
pub(super) fn rebound(
    restitution: Option<f64>,
    slip: Option<f64>,
    temperature: Option<f64>,
) -> Rebound {
    match temperature {
        Some(temperature) => Rebound::Diffuse { temperature },
        None => Rebound::Restitutive {
            restitution: restitution.unwrap_or(1.0),
            slip: slip.unwrap_or(1.0),
        },
    }
}
