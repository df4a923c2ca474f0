//! Walls, obstacles, inflows and simulator weights of a case, converted to the form of the engines.

use nalgebra::{Vector2, Vector3, vector};
use stosszahl_case::Case;
use stosszahl_case::format::{
    FACES, FaceSpec as Written, FaceWord, ObstacleSpec as ParticleState, StripeAxis,
    WeightsSpec as Regions,
};
use stosszahl_dsmc::{BoundaryConditions, Inflow, SimulatorWeights, WallClearance};
use stosszahl_model::random::Streams;
use stosszahl_model::walls::{Obstacle, ObstacleError, ObstacleShape, Vibration};
use stosszahl_model::{Face, Rebound, Space, Wall, Walls};

use super::data::{CasePlan, EnginePlan, PlanError, in_space};

/// Branch of the random streams for diffuse walls in exact dynamics, so that engines of one replica
/// draw different numbers.
const ED: u64 = 1;

/// Converts a list of components to a vector; the third is zero in the plane.
pub(super) fn vector(list: &[f64]) -> Vector3<f64> {
    Vector3::from_fn(|axis, _| list.get(axis).copied().unwrap_or(0.0))
}

impl CasePlan {
    /// Converts the faces of the box of the case.
    ///
    /// # Errors
    /// [`PlanError`] names the face.
    pub fn walls<S: Space>(&self) -> Result<Walls<S>, PlanError> {
        let case = &self.case;
        let face = |axis: usize, side: usize| -> Result<Face<S>, PlanError> {
            let key = format!("walls.{}", FACES[axis][side]);
            let wall = match case.walls.face_at(axis, side) {
                Written::Word(FaceWord::Periodic) => return Ok(Face::Periodic),
                Written::Word(FaceWord::Open) => return Ok(Face::Open),
                Written::Word(FaceWord::Specular) => return Ok(Face::Wall(Wall::specular())),
                Written::Wall(wall) => wall,
            };
            let sliding = vector(wall.sliding.as_deref().unwrap_or_default());
            let vibration = wall.vibration.map(|one| {
                Vibration::new(one.amplitude, one.period).map_err(|error| {
                    PlanError::new(format!("{key}.vibration"), error.found, error.allowed)
                })
            });
            Ok(Face::Wall(Wall {
                rebound: rebound(wall.restitution, wall.slip, wall.temperature),
                sliding: S::from_components(|axis| sliding[axis]),
                vibration: vibration.transpose()?,
            }))
        };
        let faces = (0..S::DIMENSION)
            .map(|axis| Ok([face(axis, 0)?, face(axis, 1)?]))
            .collect::<Result<Vec<_>, PlanError>>()?;
        Walls::new(&faces)
            .map_err(|error| PlanError::new("walls", error, "walls as docs describe them"))
    }

    /// Converts the obstacles of the case that lie inside the box.
    ///
    /// # Errors
    /// [`PlanError`] names the obstacle.
    pub fn obstacles(&self) -> Result<Vec<Obstacle>, PlanError> {
        let size = vector![self.gas.lengths[0], self.gas.lengths[1]];
        let all = obstacles(&self.case)?;
        for (index, obstacle) in all.iter().enumerate() {
            obstacle
                .check_inside(size)
                .map_err(|error| no_obstacle(index, error))?;
        }
        Ok(all)
    }

    /// Converts the faces of the box and the obstacles, for Monte Carlo.
    ///
    /// # Errors
    /// As [`Self::walls`], [`Self::obstacles`].
    pub fn boundaries<S: Space>(
        &self,
        engine: &EnginePlan,
    ) -> Result<BoundaryConditions<S>, PlanError> {
        Ok(BoundaryConditions {
            walls: self.walls()?,
            clearance: engine.clearance,
            inflows: self.inflows()?,
            weights: engine.weights.clone(),
            obstacles: self.obstacles()?,
        })
    }

    /// Converts the faces of the box and the obstacles, for exact dynamics of a replica with the
    /// given random streams.
    ///
    /// # Errors
    /// As [`Self::walls`], [`Self::obstacles`].
    pub fn exact_boundaries(
        &self,
        streams: Streams,
    ) -> Result<stosszahl_ed::DiskBoundaries, PlanError> {
        Ok(stosszahl_ed::DiskBoundaries {
            walls: self.walls()?,
            obstacles: self.obstacles()?,
            streams: streams.branch(ED),
        })
    }

    /// Converts the inflows of the case: one for each species and face.
    fn inflows<S: Space>(&self) -> Result<Vec<Inflow<S>>, PlanError> {
        let case = &self.case;
        let mut list = Vec::new();
        for (number, inflow) in case.inflow.iter().enumerate() {
            let key = |name: &str| format!("inflow.{}.{name}", number + 1);
            let face = FACES.iter().flatten().position(|name| *name == inflow.face);
            let is_open = |face: &usize| {
                *case.walls.face_at(face / 2, face % 2) == Written::Word(FaceWord::Open)
            };
            let face = face.filter(is_open).ok_or_else(|| {
                PlanError::new(key("face"), &inflow.face, "an open face of the box")
            })?;
            let velocity = vector(&inflow.velocity);
            let densities = inflow.number_density.as_deref();
            let each = densities.is_none_or(|list| list.len() == self.gas.species.len());
            let allowed = "one density for each species";
            PlanError::require(each, key("number_density"), "another number", allowed)?;
            let temperature = inflow.temperature.unwrap_or(self.gas.temperature);
            for (species, one) in self.gas.species.iter().enumerate() {
                let uniform = one.count as f64 / self.gas.volume;
                list.push(Inflow {
                    axis: face / 2,
                    side: face % 2,
                    density: densities.map_or(uniform, |densities| densities[species]),
                    velocity: S::from_components(|axis| velocity[axis]),
                    temperature,
                    spin_temperature: inflow.spin_temperature.unwrap_or(temperature),
                    like: self.first_of(species),
                });
            }
        }
        Ok(list)
    }

    /// Returns the index of the first particle of a species, in the order of the state.
    fn first_of(&self, species: usize) -> usize {
        match &self.gas.species_numbers {
            Some(numbers) => {
                let is_own = |&number: &u32| number as usize == species;
                numbers.iter().position(is_own).unwrap_or(0)
            }
            None => self.gas.species[..species]
                .iter()
                .map(|one| one.count)
                .sum(),
        }
    }

    /// Returns true if particles of the start must not overlap each other, as exact dynamics
    /// requires.
    pub(crate) fn keeps_apart(&self) -> bool {
        self.is_disk_fluid() || self.engine("ed").is_some() || self.equilibration() > 0.0
    }

    /// Returns true if the start must keep particles clear of walls and obstacles, because an
    /// engine requires it.
    pub fn keeps_clear(&self) -> bool {
        let clear = |engine: &EnginePlan| engine.clearance == WallClearance::Radius;
        self.is_bounded() && self.engines.iter().any(clear)
    }
}

/// Converts all obstacles of a case, also those beyond its box.
///
/// # Errors
/// [`PlanError`] names the obstacle.
pub(super) fn obstacles(case: &Case) -> Result<Vec<Obstacle>, PlanError> {
    let one = |(index, written): (usize, &ParticleState)| {
        let outline = outline(written).ok_or_else(|| {
            let key = format!("obstacle.{}", index + 1);
            let allowed = "one of circle, polyline and polygon";
            PlanError::new(key, "none or several shapes", allowed)
        })?;
        let law = rebound(written.restitution, written.slip, written.temperature);
        Obstacle::new(outline, law).map_err(|error| no_obstacle(index, error))
    };
    case.obstacle.iter().enumerate().map(one).collect()
}

/// Creates the error of an invalid obstacle, with its index.
fn no_obstacle(index: usize, error: ObstacleError) -> PlanError {
    let key = format!("obstacle.{}", index + 1);
    PlanError::new(key, error, "an obstacle with a surface, inside the box")
}

/// Checks that the walls and obstacles fit the box.
pub(super) fn check_boundaries(plan: &CasePlan) -> Result<(), PlanError> {
    let case = &plan.case;
    if plan.gas.lengths[0] == 0.0 {
        return Ok(());
    }
    for (axis, names) in FACES.iter().enumerate() {
        for (side, name) in names.iter().enumerate() {
            let Written::Wall(wall) = case.walls.face_at(axis, side) else {
                continue;
            };
            let half = 0.5 * plan.gas.lengths[axis];
            let flat = wall.vibration.is_none_or(|one| one.amplitude < half);
            let key = format!("walls.{name}.vibration.amplitude");
            PlanError::require(flat, key, "half the box or more", "less than half the box")?;
        }
    }
    in_space!(plan.gas.dimension, S => plan.inflows::<S>().map(drop))?;
    plan.obstacles()?;
    in_space!(plan.gas.dimension, S => plan.walls::<S>().map(drop))
}

/// Converts the weights of simulators by region; `key` is their table for messages.
pub(super) fn weights(key: &str, written: Option<&Regions>) -> Result<SimulatorWeights, PlanError> {
    let Some(written) = written else {
        return Ok(SimulatorWeights::uniform());
    };
    let axis = usize::from(written.along == StripeAxis::Y);
    let made = match written.adaptive_stripes {
        Some(stripes) => SimulatorWeights::following(axis, stripes as usize),
        None => SimulatorWeights::along(axis, written.factors.clone().unwrap_or_default()),
    };
    made.map_err(|error| {
        PlanError::new(format!("{key}.weights"), error, "weights from 1e-6 to 1e6")
    })
}

/// Converts restitution, slip and temperature of a surface to its wall law.
fn rebound(restitution: Option<f64>, slip: Option<f64>, temperature: Option<f64>) -> Rebound {
    match temperature {
        Some(temperature) => Rebound::Diffuse { temperature },
        None => Rebound::Restitutive {
            restitution: restitution.unwrap_or(1.0),
            slip: slip.unwrap_or(1.0),
        },
    }
}

/// Returns the shape of an obstacle; `None` unless exactly one of circle, polyline and polygon is
/// given.
fn outline(written: &ParticleState) -> Option<ObstacleShape> {
    let points = |list: &[[f64; 2]]| -> Vec<Vector2<f64>> {
        list.iter().map(|&point| point.into()).collect()
    };
    match (&written.circle, &written.polyline, &written.polygon) {
        (Some(disk), None, None) => Some(ObstacleShape::Circle {
            centre: disk.centre.into(),
            radius: disk.radius,
        }),
        (None, Some(list), None) => {
            let points = points(list);
            Some(ObstacleShape::Polyline { points })
        }
        (None, None, Some(list)) => {
            let points = points(list);
            Some(ObstacleShape::Polygon { points })
        }
        _ => None,
    }
}
