//! Gas of a case while its plan is derived: species, sizes, box and units.

use std::sync::Arc;

use stosszahl_model::SizeDistribution;
use stosszahl_model::initial::StartFile;

use super::data::{SizeGroup, SpeciesPlan, UnitScale};

/// Gas of a case, resolved from its keys or from a start file.
pub(super) struct ResolvedGas {
    pub(super) species: Vec<SpeciesPlan>,
    pub(super) classes: Vec<SizeGroup>,
    pub(super) sizes: SizeDistribution,
    /// Index of the species of each particle, unless particles are sorted by species.
    pub(super) numbers: Option<Arc<[u32]>>,
    pub(super) mean_mass: f64,
    /// Granular temperature of the start, in the units of the case \[energy\].
    pub(super) temperature: f64,
    pub(super) lengths: [f64; 3],
    /// Displacement of the periodic image above at the start of a shear flow \[length\].
    pub(super) shear_offset: f64,
    pub(super) volume: f64,
    pub(super) packing: f64,
    pub(super) scale: UnitScale,
    pub(super) file: Option<StartFile>,
    /// Changes that the plan makes to values of the case, one sentence each for the user.
    pub(super) choices: Vec<String>,
}
