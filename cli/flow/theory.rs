//! What theory says of a flow, where it says something in closed form.

use stosszahl_analysis::theory::rough::{RoughGas, Temperatures};
use stosszahl_analysis::theory::sonine::MOST_ROUGH_ORDERS;
use stosszahl_analysis::theory::{Column, Layer, TheoryError};
use stosszahl_model::{Plane, Rough, Space, Volume};

use super::case::{Face, FaceWord, Flow, Scheme, Wall};
use super::plan::Plan;

/// Theory of a case.
#[derive(Clone, Debug, Default)]
pub struct Theory {
    /// Temperatures of translation and rotation at the sample times of a homogeneous gas.
    cooling: Vec<(f64, [f64; 2])>,
    /// The equilibrium of an elastic gas in a closed column.
    column: Option<Column>,
    /// Temperature of all walls of an elastic gas, if they have one.
    wall_temperature: Option<f64>,
}

impl Theory {
    /// What applies to a case.
    ///
    /// # Errors
    /// [`TheoryError`] if an equation cannot be solved.
    pub fn new(plan: &Plan) -> Result<Self, TheoryError> {
        Ok(Self {
            cooling: cooling(plan)?,
            column: column(plan)?,
            wall_temperature: wall_temperature(&plan.flow),
        })
    }

    /// Temperatures of translation and rotation at a time.
    pub fn temperatures(&self, time: f64) -> Option<[f64; 2]> {
        let place = self.cooling.partition_point(|&(known, _)| known < time);
        let (known, values) = self.cooling.get(place)?;
        ((known - time).abs() <= 1e-9 * time.abs()).then_some(*values)
    }

    /// Whether [`Self::temperatures`] says anything.
    pub fn cools(&self) -> bool {
        !self.cooling.is_empty()
    }

    /// The settled column, if the case is one.
    pub fn column(&self) -> Option<&Column> {
        self.column.as_ref()
    }

    /// Temperature of all walls of an elastic gas.
    pub fn wall_temperature(&self) -> Option<f64> {
        self.wall_temperature
    }

    /// Number density of a species, or of all, averaged between two heights of the settled column.
    pub fn density(&self, plan: &Plan, species: Option<usize>, ends: [f64; 2]) -> Option<f64> {
        let column = self.column.as_ref()?;
        let one = |index: usize| {
            let kind = &plan.kinds[index];
            let uniform = kind.count as f64 / plan.volume;
            // Gravity may point up the axis.
            let height = plan.flow.domain.size[1];
            let [from, to] = if falls_down(&plan.flow) {
                ends
            } else {
                [height - ends[1], height - ends[0]]
            };
            uniform * column.mean_density(kind.mass, from.max(0.0), to.min(height))
        };
        Some(match species {
            Some(index) => one(index),
            None => (0..plan.kinds.len()).map(one).sum(),
        })
    }
}

/// Whether all contacts of grains keep their energy.
pub(super) fn is_elastic(flow: &Flow) -> bool {
    flow.contact.restitution == 1.0
        && (flow.contact.tangential_restitution).is_none_or(|beta| beta.abs() == 1.0)
}

/// Whether walls and obstacles keep the energy of grains too, and nothing leaves.
pub(super) fn keeps_energy(flow: &Flow) -> bool {
    let specular = |face: &Face| match face {
        Face::Word(word) => *word != FaceWord::Open,
        Face::Wall(wall) => keeps(wall),
    };
    let faces = (0..3).flat_map(|axis| [0, 1].map(|side| flow.walls.at(axis, side)));
    let obstacles = flow.obstacle.iter().all(|obstacle| {
        obstacle.temperature.is_none()
            && obstacle.restitution.is_none_or(|r| r == 1.0)
            && obstacle.slip.is_none_or(|slip| slip.abs() == 1.0)
    });
    is_elastic(flow) && faces.into_iter().all(specular) && obstacles
}

/// Whether a wall gives no energy: it reverses velocities, and does not move where it has friction.
fn keeps(wall: &Wall) -> bool {
    let slip = wall.slip.unwrap_or(1.0);
    let slides = wall.sliding.iter().flatten().any(|&v| v != 0.0);
    wall.restitution == Some(1.0)
        && slip.abs() == 1.0
        && wall.vibration.is_none()
        && (slip == 1.0 || !slides)
}

/// Cooling of a homogeneous gas of equal rough grains.
fn cooling(plan: &Plan) -> Result<Vec<(f64, [f64; 2])>, TheoryError> {
    let ([kind], true) = (&plan.kinds[..], plan.is_homogeneous()) else {
        return Ok(Vec::new());
    };
    let density = kind.count as f64 / plan.volume;
    let gas = |space: usize| {
        let contact = &plan.flow.contact;
        let (restitution, diameter) = (contact.restitution, 2.0 * kind.radius);
        let dense =
            (plan.flow.engine.dsmc.as_ref()).is_none_or(|dsmc| dsmc.scheme != Scheme::Boltzmann);
        let packing = plan.packing_fraction();
        // The dilute theory for points; with exact disks beside them, they are not.
        if space == 2 {
            let chi = if dense {
                Plane::contact_value(packing)
            } else {
                1.0
            };
            let surface = plan.rough::<Plane>();
            surface
                .map(|s| RoughGas::new::<Plane>(restitution, s, density, diameter, kind.mass, chi))
        } else {
            let chi = if dense {
                Volume::contact_value(packing)
            } else {
                1.0
            };
            let surface: Option<Rough> = plan.rough::<Volume>();
            surface
                .map(|s| RoughGas::new::<Volume>(restitution, s, density, diameter, kind.mass, chi))
        }
    };
    let Some(gas) = gas(plan.dimension()) else {
        return Ok(Vec::new());
    };
    let times: Vec<f64> = (0..=plan.flow.run.samples)
        .map(|sample| plan.sample_time(sample))
        .collect();
    let start = Temperatures {
        translation: plan.flow.start.temperature,
        rotation: plan.spin_temperature(),
    };
    let gas = gas?;
    // Grains that do not spin at first have no Maxwellian to expand about.
    let found: Vec<Temperatures> = match gas.expand(MOST_ROUGH_ORDERS, start, &times) {
        Ok(found) => found.iter().map(|moment| moment.temperatures).collect(),
        Err(_) => gas.cooling(start, &times)?,
    };
    Ok(times
        .into_iter()
        .zip(found)
        .map(|(time, t)| (time, [t.translation, t.rotation]))
        .collect())
}

/// Whether gravity points down the second axis.
fn falls_down(flow: &Flow) -> bool {
    flow.gravity
        .as_ref()
        .is_some_and(|gravity| gravity.acceleration[1] < 0.0)
}

/// The settled column: an elastic dilute gas between still walls at the ends of the second axis, along which gravity points.
fn column(plan: &Plan) -> Result<Option<Column>, TheoryError> {
    let flow = &plan.flow;
    let Some(gravity) = &flow.gravity else {
        return Ok(None);
    };
    let along = gravity.acceleration.iter().enumerate();
    let only = along.filter(|&(axis, _)| axis != 1).all(|(_, &g)| g == 0.0);
    let points = (flow.engine.dsmc.as_ref())
        .is_some_and(|dsmc| dsmc.scheme == Scheme::Boltzmann && plan.walls_act_on_centres(dsmc));
    let closed = [0, 1].iter().all(|&side| {
        !matches!(
            flow.walls.at(1, side),
            Face::Word(FaceWord::Open | FaceWord::Periodic)
        )
    });
    let spins = plan.spin_temperature() == flow.start.temperature;
    let applies = only
        && points
        && closed
        && keeps_energy(flow)
        && gravity.acceleration[1] != 0.0
        && flow.obstacle.is_empty()
        && flow.start.velocity.is_none()
        && flow.engine.ed.is_none();
    // A perfectly rough gas shares its energy with its spins, a smooth one has none.
    let shares = match flow.contact.tangential_restitution {
        None => Some(plan.dimension()),
        Some(beta) if beta > 0.0 && spins => Some(plan.dimension() + plan.freedom().rotations),
        Some(_) => None,
    };
    let Some(freedoms) = shares.filter(|_| applies) else {
        return Ok(None);
    };
    let layers: Vec<Layer> = plan
        .kinds
        .iter()
        .map(|kind| Layer {
            mass: kind.mass,
            number: kind.count as f64,
        })
        .collect();
    let strength = gravity.acceleration[1].abs();
    Column::settled(
        &layers,
        flow.domain.size[1],
        strength,
        flow.start.temperature,
        freedoms,
    )
    .map(Some)
}

/// The temperature of all walls, if all have the same and the gas is elastic.
fn wall_temperature(flow: &Flow) -> Option<f64> {
    if !is_elastic(flow) || flow.gravity.is_some() {
        return None;
    }
    let mut found = None;
    for axis in 0..flow.dimension() {
        for side in 0..2 {
            match flow.walls.at(axis, side) {
                Face::Word(FaceWord::Periodic | FaceWord::Specular) => {}
                Face::Wall(Wall {
                    temperature: Some(t),
                    vibration: None,
                    sliding: None,
                    ..
                }) if found.is_none_or(|known| known == *t) => found = Some(*t),
                _ => return None,
            }
        }
    }
    found
}
