//! Resolved plan of a case: all quantities that engines, measurements and theory need, derived
//! once.
//!
//! Engines compute in units of their own ([`UnitScale`]): for smooth particles in a uniform box the
//! mean diameter, the mean mass and the temperature of the start are one; elsewhere they are the
//! units of the case. All numbers here are in engine units unless they say otherwise; tables and
//! reports are in the units of the case, times in its unit of time.
//!
//! | module | content |
//! |---|---|
//! | `data` | the plan itself |
//! | `derive` | units, box: [`CasePlan::new`] |
//! | `start_file` | a gas from a start file |
//! | `file_species` | species of its particles |
//! | `region` | the region of the box in which a start is placed |
//! | `confinement` | faces and bodies that keep particles of a start out |
//! | `species` | species, sizes, laws |
//! | `boundaries` | walls, obstacles, streams |
//! | `free_volume` | volume that obstacles leave to the gas |
//! | `engines` | the numerical choices of each engine |
//! | `theory_curves` | solved theory of a gas without positions |
//! | `times` | sample times |
//! | `bath` | thermal bath and its steady state |
//! | `theory` | rates, Haff's law, steady states |
//! | `notable` | warnings and derived quantities |
//! | `plausible` | implausible numbers, limits of the estimate of the time |
//! | `si` | names of units |
//! | `flow_numbers` | Reynolds, Mach and Knudsen number |
//! | `work` | collisions, candidate pairs, time steps, cells |
//! | `machine` | threads and memory of the machine |

mod bath;
mod boundaries;
mod confinement;
mod data;
mod derive;
mod engines;
mod file_species;
mod flow_numbers;
mod free_volume;
mod gas;
mod machine;
mod notable;
mod plausible;
mod region;
mod si;
mod species;
mod start_file;
mod theory;
mod theory_curves;
mod times;
mod work;

pub(crate) use confinement::Confinement;
pub(crate) use data::in_space;
pub use data::{
    CasePlan, ClockPlan, DerivedQuantity, EngineKind, EnginePlan, GasPlan, PlanError, PlanNotes,
    SizeGroup, SpeciesPlan, TheoryCache, UnitScale,
};
pub use machine::{available_memory, available_threads, threads_each};
pub(crate) use notable::RATE_ERROR_IN_A_CELL;
pub use region::Region;
pub use theory_curves::{GroupCurve, Predicted, TheoryCurves, TheoryPoint};
pub use times::logarithmic;
