//! A gas from a start file: disks of one species in a periodic box.

use std::f64::consts::PI;
use std::path::Path;

use stosszahl_case::format::Velocities;
use stosszahl_case::{Case, Kind};
use stosszahl_model::initial::{self, Overlap, StartFile};
use stosszahl_model::{Domain, GrainSizes, Monodisperse, Plane, Polydisperse};

use crate::words::short;

use super::data::{Class, PlanError, Scale, SpeciesPlan};
use super::derive::Gas;

/// Deepest overlap of a start that counts as rounding, over the mean diameter.
const OVERLAP_TOLERANCE: f64 = 1e-9;
/// Temperature of a start file over the mean squared speed, below which it is rounding.
const LEAST_WARMTH: f64 = 1e-24;

/// An error in the file or in what goes with it.
fn content(found: String, allowed: &str) -> PlanError {
    PlanError::new("start.file", found, allowed)
}

/// A gas from a start file.
pub(super) fn gas(case: &Case, folder: &Path, temperature: f64) -> Result<Gas, PlanError> {
    if case.gas.dimension != 2 || case.kind() != Kind::Comparison || !case.species.is_empty() {
        let allowed = "smooth disks of one species in a periodic box";
        return Err(content("a start file of another gas".into(), allowed));
    }
    let written = case
        .start
        .file
        .as_deref()
        .ok_or_else(|| content("none".into(), "a file"))?;
    let mut start = initial::read(&folder.join(written))
        .map_err(|error| content(error.to_string(), "a start file as docs describe it"))?;
    let count = start.positions.len();
    let (diameter, mass) = (
        case.gas.diameter.unwrap_or(1.0),
        case.gas.mass.unwrap_or(1.0),
    );
    let radii = start
        .radii
        .take()
        .unwrap_or_else(|| vec![0.5 * diameter; count]);
    let masses = start.masses.take().unwrap_or_else(|| vec![mass; count]);
    if count < 2 {
        return Err(content("one disk".into(), "at least two"));
    }
    let domain = Domain::<Plane>::periodic(start.lengths.into())
        .map_err(|_| content("a box without area".into(), "positive sides"))?;
    for position in &mut start.positions {
        *position = domain.wrap(*position);
    }
    let mean = |values: &[f64]| values.iter().sum::<f64>() / count as f64;
    let length = 2.0 * mean(&radii);
    let deepest = OVERLAP_TOLERANCE * length;
    let overlap = initial::first_overlap(&start.positions, |i| radii[i], &domain, deepest);
    if let Some(Overlap {
        pair: [a, b],
        depth,
    }) = overlap
    {
        let found = format!(
            "{written}: disks {a} and {b} (counted from 0) overlap by {}",
            short(depth)
        );
        return Err(content(found, "touching disks"));
    }
    let mass = mean(&masses);
    let energy = warmth(case, written, temperature, &mut start, (&masses, mass))?;
    let scale = Scale {
        length,
        mass,
        energy,
    };
    let covered: f64 = radii.iter().map(|r| PI * r * r).sum();
    let packing = covered / domain.volume();
    let sizes = sizes(&radii, &masses, length, mass)?;
    let [width, height] = start.lengths.map(|side| side / length);
    let widest = radii.iter().map(|r| 2.0 * r / length).fold(0.0, f64::max);
    if width.min(height) <= widest * (1.0 + 1e-9) {
        let found = format!("{written}: a box of {width} x {height} diameters");
        return Err(content(found, "sides longer than one disk is wide"));
    }
    start.positions.iter_mut().for_each(|x| *x /= length);
    start.lengths = [width, height];
    for velocity in start.velocities.iter_mut().flatten() {
        *velocity /= scale.speed();
    }
    let volume = width * height;
    let species = SpeciesPlan {
        name: "1".into(),
        count,
        radius: 0.5,
        mass: 1.0,
        temperature: 1.0,
        tracer: false,
    };
    let class = Class {
        count,
        mass: 1.0,
        diameter: 1.0,
        temperature: 1.0,
        density: count as f64 / volume,
    };
    Ok(Gas {
        species: vec![species],
        classes: vec![class],
        sizes,
        mean_mass: 1.0,
        lengths: [width, height, 0.0],
        volume,
        packing,
        scale,
        file: Some(start),
    })
}

/// Radii and masses over the mean diameter and mass.
fn sizes(radii: &[f64], masses: &[f64], length: f64, mass: f64) -> Result<GrainSizes, PlanError> {
    let alike = |values: &[f64]| values.iter().all(|&value| value == values[0]);
    if alike(radii) && alike(masses) {
        return Ok(GrainSizes::Equal(Monodisperse {
            radius: 0.5,
            mass: 1.0,
        }));
    }
    let pairs = radii.iter().zip(masses);
    let sizes = Polydisperse::new(pairs.map(|(r, m)| (r / length, m / mass)).collect());
    let allowed = "ratios of radii and masses up to 1e300";
    let sizes = sizes.map_err(|error| content(error.to_string(), allowed))?;
    Ok(GrainSizes::Each(sizes))
}

/// The temperature of a start, in the units of the case; the drift is taken out of velocities in the file.
fn warmth(
    case: &Case,
    written: &str,
    temperature: f64,
    start: &mut StartFile,
    (masses, mean_mass): (&[f64], f64),
) -> Result<f64, PlanError> {
    match (case.start.velocities, &mut start.velocities) {
        (Velocities::Maxwellian, _) => Ok(temperature),
        (Velocities::File, None) => {
            let allowed = "columns vx and vy (velo), or velocities = \"maxwellian\"";
            Err(content(format!("{written}: no velocities"), allowed))
        }
        (Velocities::File, Some(velocities)) => {
            let square = velocities
                .iter()
                .map(nalgebra::Vector2::norm_squared)
                .fold(0.0, f64::max);
            let found = remove_drift(velocities, masses);
            if found.is_normal() && found < 1e200 && found > LEAST_WARMTH * square * mean_mass {
                return Ok(found);
            }
            let found = format!("{written}: a granular temperature of {}", short(found));
            Err(content(found, "velocities that give one above rounding"))
        }
    }
}

/// Takes the drift of the whole gas out of its velocities, which changes nothing in it, and returns the temperature
/// that is left.
fn remove_drift(velocities: &mut [nalgebra::Vector2<f64>], masses: &[f64]) -> f64 {
    let total: f64 = masses.iter().sum();
    let drift = (velocities.iter().zip(masses)).fold(nalgebra::Vector2::zeros(), |sum, (v, m)| {
        sum + v * (m / total)
    });
    let mut twice = 0.0;
    for (velocity, mass) in velocities.iter_mut().zip(masses) {
        *velocity -= drift;
        twice += mass * velocity.norm_squared();
    }
    0.5 * twice / velocities.len() as f64
}
