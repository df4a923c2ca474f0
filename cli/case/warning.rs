//! What is allowed in a case but deserves a second look.

use std::f64::consts::{PI, SQRT_2};
use std::fmt::{self, Display, Formatter};

use super::{Bodies, Case, Engine};

/// Something in a valid case that may not be what was meant.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Warning {
    /// One replica has no spread, so nothing can be compared within errors.
    SingleReplica,
    /// The gas starts from a lattice and is not equilibrated. A disordered start above a packing fraction of 0.45
    /// is such a lattice, with vacancies.
    LatticeStart,
    /// The cells of an engine are so wide that transport is overestimated.
    WideCells {
        /// Name of the engine.
        engine: &'static str,
        /// Width of a cell in mean free paths.
        mean_free_paths: f64,
    },
    /// The box holds so few disks that kinetic theory does not describe it.
    FewDisks {
        /// The number of disks.
        disks: usize,
    },
}

impl Display for Warning {
    fn fmt(&self, out: &mut Formatter<'_>) -> fmt::Result {
        match self {
            Self::SingleReplica => {
                write!(
                    out,
                    "replicas = 1: no error bars; at least 2 replicas give a spread"
                )
            }
            Self::LatticeStart => write!(
                out,
                "start.collisions_per_particle = 0: the gas starts from a lattice; an elastic \
                 equilibration of 10 or more collisions per particle melts it"
            ),
            Self::WideCells {
                engine,
                mean_free_paths,
            } => write!(
                out,
                "engine.{engine}.cell_size: the cells are {mean_free_paths:.1} mean free paths wide, so \
                 transport is overestimated, by an error that grows with the square of the width"
            ),
            Self::FewDisks { disks } => write!(
                out,
                "gas.disks = {disks}: kinetic theory holds for many disks; below 10 the comparison with it \
                 says little"
            ),
        }
    }
}

/// The warnings of a case.
pub(super) fn of(case: &Case) -> Vec<Warning> {
    /// Cells wider than this many mean free paths are named.
    const WIDE: f64 = 4.0;
    /// Above this packing fraction a disordered start is a lattice with vacancies that has to be melted.
    const SEQUENTIAL: f64 = 0.45;
    let mut warnings = Vec::new();
    if case.replicas == 1 {
        warnings.push(Warning::SingleReplica);
    }
    let lattice = match case.start.bodies {
        Bodies::Square { .. } | Bodies::Hexagonal { .. } => true,
        Bodies::Disordered {
            packing_fraction, ..
        } => packing_fraction > SEQUENTIAL,
        Bodies::File(_) => false,
    };
    if lattice && case.start.collisions_per_particle == 0.0 {
        warnings.push(Warning::LatticeStart);
    }
    if let Some(disks) = case.disks()
        && disks < 10
    {
        warnings.push(Warning::FewDisks { disks });
    }
    for engine in &case.engines {
        if let Engine::Dsmc(dsmc) = engine
            && let (Some(size), Some(packing_fraction)) = (dsmc.cell_size, case.packing_fraction())
        {
            let mean_free_paths = size / mean_free_path(packing_fraction);
            if mean_free_paths > WIDE {
                warnings.push(Warning::WideCells {
                    engine: engine.name(),
                    mean_free_paths,
                });
            }
        }
    }
    warnings
}

/// Mean free path in diameters, `pi/(8 sqrt(2) phi chi)`, with Henderson's contact value
/// `chi = (1 - 7 phi/16)/(1 - phi)^2` (Mol. Phys. 30, 971 (1975), doi:10.1080/00268977500102511).
fn mean_free_path(packing_fraction: f64) -> f64 {
    let free = 1.0 - packing_fraction;
    let contact_value = (1.0 - 7.0 * packing_fraction / 16.0) / (free * free);
    PI / (8.0 * SQRT_2 * packing_fraction * contact_value)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_mean_free_path_is_that_of_luding_1998() {
        // pi 9/16/(8 sqrt(2) 0.25 (1 - 7/64)) by hand.
        assert!((mean_free_path(0.25) - 0.7014).abs() < 1e-3);
    }
}
