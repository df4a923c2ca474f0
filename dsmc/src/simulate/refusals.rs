//! Checks of the settings of a DSMC gas before its particles are created.

use stosszahl_model::{
    Monodisperse, ParticleModel, ParticleSpec, SizeDistribution, Sizes as _, Smooth, Space,
};

use super::begin::CellGas;
use super::field::scene_of;
use crate::boundary::{BoundaryConditions, GridBoundaries};
use crate::grid::Grid;
use crate::parameters::DsmcError;
use crate::start::{check_choices, require_room};

/// Largest number of cells for which obstacles and walls are checked; more would take too long.
const MOST_CELLS: usize = 4_000_000;

/// Expected box and means over the particles of a gas that has not started.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ExpectedGas {
    /// Sides of the box; the third is 0 for disks \[length\].
    pub lengths: [f64; 3],
    /// Expected mean radius of the particles \[length\].
    pub mean_radius: f64,
    /// Expected packing fraction of the initial state.
    pub packing_fraction: f64,
}

/// Checks parameters, sizes and boundaries of a gas as [`super::simulate`] does, but without its
/// particles.
///
/// # Errors
/// [`DsmcError`] if the parts do not go together.
pub fn check_gas(gas: &CellGas<'_>, expected: &ExpectedGas) -> Result<(), DsmcError> {
    let grains = &ParticleSpec {
        sizes: match &gas.grains.sizes {
            // Only the largest size matters, and a list of all may be long.
            SizeDistribution::Each(all) => SizeDistribution::Equal(Monodisperse {
                radius: all.largest_radius(),
                mass: 1.0,
            }),
            other => other.clone(),
        },
        ..gas.grains.clone()
    };
    if expected.lengths[2] > 0.0 {
        return in_space(gas, grains, gas.boundaries, expected);
    }
    in_space(gas, grains, &gas.boundaries.in_plane(), expected)
}

fn in_space<S: Space>(
    gas: &CellGas<'_>,
    grains: &ParticleSpec,
    boundaries: &BoundaryConditions<S>,
    expected: &ExpectedGas,
) -> Result<(), DsmcError> {
    match grains.rough {
        Some(rough) => of(gas, &scene_of(grains, rough, 1)?, boundaries, expected),
        None => of(gas, &scene_of(grains, Smooth, 1)?, boundaries, expected),
    }
}

fn of<P: ParticleModel>(
    gas: &CellGas<'_>,
    scene: &P,
    boundaries: &BoundaryConditions<P::Space>,
    expected: &ExpectedGas,
) -> Result<(), DsmcError> {
    let lengths = P::Space::from_components(|axis| expected.lengths[axis]);
    let domain = boundaries.walls.domain(lengths)?;
    check_choices(scene, gas.parameters, &domain, boundaries)?;
    let (radius, densest) = (expected.mean_radius, boundaries.densest(scene.sizes()));
    let packing = expected.packing_fraction.max(densest);
    let counts = gas.parameters.cells(&domain, packing, 2.0 * radius);
    if boundaries.is_periodic() || counts.iter().product::<usize>() > MOST_CELLS {
        return Ok(());
    }
    let grid = Grid::new(domain, counts, 1, MOST_CELLS, 0.0);
    let surroundings = GridBoundaries::new(scene, boundaries, &grid, [radius, 1.0], 0.0)?;
    let Some(surroundings) = surroundings else {
        return Ok(());
    };
    require_room(&surroundings, gas.parameters.scheme)?;
    let weight = 1.0 / f64::from(gas.parameters.simulators_per_particle);
    for (number, source) in surroundings.sources().iter().enumerate() {
        source.check_number(
            number,
            domain.volume(),
            weight * surroundings.least_factor(),
        )?;
    }
    Ok(())
}
