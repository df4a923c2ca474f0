//! What is allowed in a case but deserves a second look.

use std::fmt::{self, Display, Formatter};

use stosszahl_model::initial::SEQUENTIAL_LIMIT;

use super::{Bodies, Case};

/// Something in a valid case that may not be what was meant.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Warning {
    /// One replica has no spread, so nothing can be compared within errors.
    SingleReplica,
    /// The gas starts from a lattice and is not equilibrated. A disordered start above a packing fraction of 0.45
    /// is such a lattice, with vacancies.
    LatticeStart,
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
                 equilibration of some tens of collisions per particle melts it, and the start is tested for that"
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
    let mut warnings = Vec::new();
    if case.replicas == 1 {
        warnings.push(Warning::SingleReplica);
    }
    let lattice = match case.start.bodies {
        Bodies::Square { .. } | Bodies::Hexagonal { .. } => true,
        Bodies::Disordered {
            packing_fraction, ..
        } => packing_fraction > SEQUENTIAL_LIMIT,
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
    warnings
}
