//! Theory of flows with a closed form, such as a settled column. All numbers are in engine units.

use stosszahl_case::format::{FaceSpec, FaceWord, WallSpec, WallsActOn};
use stosszahl_model::Space as _;
use stosszahl_theory::rough::{RoughGas, Temperatures};
use stosszahl_theory::sonine::MOST_ROUGH_ORDERS;
use stosszahl_theory::{BarometricColumn, Layer, TheoryError};

use crate::plan::{CasePlan, EngineKind, EnginePlan, SpeciesPlan, in_space};

/// Returns true if the gas conserves its energy: contacts, walls and obstacles dissipate none, and
/// there are no openings, kicks or shear.
pub fn keeps_energy(plan: &CasePlan) -> bool {
    let specular = |face: &FaceSpec| match face {
        FaceSpec::Word(word) => *word != FaceWord::Open,
        FaceSpec::Wall(wall) => conserves_energy(wall),
    };
    let obstacles = plan.case.obstacle.iter().all(|obstacle| {
        obstacle.temperature.is_none()
            && obstacle.restitution.is_none_or(|r| r == 1.0)
            && obstacle.slip.is_none_or(|slip| slip.abs() == 1.0)
    });
    let driven = plan.case.thermostat.is_some() || plan.is_sheared();
    // Along a periodic axis gravity does work for ever.
    let ends = plan.gravity() == plan.gas.particles.gravity.unwrap_or_default();
    plan.is_elastic() && !driven && plan.case.walls.all_faces().all(specular) && obstacles && ends
}

/// Returns true if a wall conserves the energy of particles: it reverses velocities and, if it has
/// friction, does not move.
fn conserves_energy(wall: &WallSpec) -> bool {
    let slip = wall.slip.unwrap_or(1.0);
    let slides = wall.sliding.iter().flatten().any(|&v| v != 0.0);
    wall.restitution == Some(1.0)
        && slip.abs() == 1.0
        && wall.vibration.is_none()
        && (slip == 1.0 || !slides)
}

/// Returns the temperature of rotation at the start \[energy\].
fn spin_temperature(plan: &CasePlan) -> f64 {
    let written = plan.case.start.spin_temperature;
    written.map_or(plan.gas.temperature, |t| t / plan.scale.energy)
}

/// Returns true if particles of an engine collide at the rate of a dilute gas at any density.
pub fn is_dilute(engine: &EnginePlan) -> bool {
    matches!(&engine.kind, EngineKind::MonteCarlo(one) if one.scheme.is_dilute())
}

/// Computes the temperatures of translation and rotation, at some engine times, of a homogeneous
/// gas of equal rough particles at the collision rate of an engine; `None` for other gases.
///
/// # Errors
/// [`TheoryError`] if its equations cannot be solved.
pub fn cooling(
    plan: &CasePlan,
    engine: &EnginePlan,
    times: &[f64],
) -> Result<Option<Vec<Temperatures>>, TheoryError> {
    let homogeneous = plan.case.domain.is_some()
        && plan.case.walls.is_periodic()
        && plan.case.gravity.is_none()
        && plan.case.obstacle.is_empty()
        && plan.case.bath().is_none();
    let ([kind], true, Some(surface), Some(restitution)) = (
        &plan.gas.species[..],
        homogeneous,
        plan.gas.particles.rough,
        plan.gas.law.constant(),
    ) else {
        return Ok(None);
    };
    let (density, diameter) = (kind.count as f64 / plan.gas.volume, 2.0 * kind.radius);
    let gas = in_space!(plan.gas.dimension, S => {
        let chi = if is_dilute(engine) { 1.0 } else { S::contact_value(plan.gas.packing_fraction) };
        RoughGas::new::<S>(restitution, surface, density, diameter, kind.mass, chi)
    })?;
    let start = Temperatures {
        translation: plan.gas.temperature,
        rotation: spin_temperature(plan),
    };
    // Particles that do not spin at first have no Maxwellian to expand about.
    let found = match gas.expand(MOST_ROUGH_ORDERS, start, times) {
        Ok(found) => found.iter().map(|moment| moment.temperatures).collect(),
        Err(_) => gas.cooling(start, times)?,
    };
    Ok(Some(found))
}

/// Computes the barometric column of an engine: an elastic dilute gas that has settled between
/// walls at rest, at the ends of the second axis, along gravity. `None` for other gases.
///
/// # Errors
/// [`TheoryError`] if its equation cannot be solved.
pub fn column(
    plan: &CasePlan,
    engine: &EnginePlan,
) -> Result<Option<BarometricColumn>, TheoryError> {
    let case = &plan.case;
    let Some(gravity) = plan.gas.particles.gravity else {
        return Ok(None);
    };
    // Exact dynamics needs room for its particles at the start, so that points do not begin uniform
    // beside it.
    let centre = |act: Option<WallsActOn>| act.is_none_or(|place| place == WallsActOn::Centre);
    let points = engine.name == "dsmc-boltzmann"
        && (case.engine.boltzmann.as_ref()).is_some_and(|one| centre(one.wall_contact))
        && case.engine.ed.is_none();
    let closed = [0, 1]
        .iter()
        .all(|&side| case.walls.face_at(1, side).is_wall());
    let applies = points
        && closed
        && gravity.x == 0.0
        && gravity.y != 0.0
        && gravity.z == 0.0
        && keeps_energy(plan)
        && case.obstacle.is_empty()
        && case.start.velocity.is_none();
    // A perfectly rough gas shares its energy with its spins, a smooth one has none.
    let spins = spin_temperature(plan) == plan.gas.temperature;
    let shares = match plan.gas.particles.rough {
        None => Some(plan.gas.dimension),
        Some(rough) if rough.tangential_restitution() > 0.0 && spins => {
            Some(plan.gas.dimension + if plan.gas.dimension == 2 { 1 } else { 3 })
        }
        Some(_) => None,
    };
    let Some(freedoms) = shares.filter(|_| applies) else {
        return Ok(None);
    };
    let layer = |kind: &SpeciesPlan| Layer {
        mass: kind.mass,
        number: kind.count as f64,
    };
    let layers: Vec<Layer> = plan.gas.species.iter().map(layer).collect();
    let (height, strength) = (plan.gas.lengths[1], gravity.y.abs());
    BarometricColumn::settled(&layers, height, strength, plan.gas.temperature, freedoms).map(Some)
}

/// Computes the number density of a species, or of all, averaged between two heights of the settled
/// column.
pub fn density(
    plan: &CasePlan,
    column: &BarometricColumn,
    species: Option<usize>,
    ends: [f64; 2],
) -> f64 {
    let height = plan.gas.lengths[1];
    // Gravity may point up the axis.
    let falls = plan
        .gas
        .particles
        .gravity
        .is_some_and(|gravity| gravity.y < 0.0);
    let [from, to] = if falls {
        ends
    } else {
        [height - ends[1], height - ends[0]]
    };
    let one = |kind: &SpeciesPlan| {
        let uniform = kind.count as f64 / plan.gas.volume;
        uniform * column.mean_density(kind.mass, from.max(0.0), to.min(height))
    };
    match species {
        Some(index) => one(&plan.gas.species[index]),
        None => plan.gas.species.iter().map(one).sum(),
    }
}

/// Returns the common temperature of the walls \[energy\]; `None` unless all have the same, none
/// moves and the gas is elastic.
pub fn wall_temperature(plan: &CasePlan) -> Option<f64> {
    if !plan.is_elastic() || plan.gas.particles.gravity.is_some() || plan.case.bath().is_some() {
        return None;
    }
    let mut found = None;
    for face in plan.case.walls.all_faces() {
        match face {
            FaceSpec::Word(FaceWord::Periodic | FaceWord::Specular) => {}
            FaceSpec::Wall(WallSpec {
                temperature: Some(t),
                vibration: None,
                sliding: None,
                ..
            }) if found.is_none_or(|known| known == *t) => found = Some(*t),
            _ => return None,
        }
    }
    found.map(|t| t / plan.scale.energy)
}
