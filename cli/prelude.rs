//! Items that a custom program needs: `use stosszahl::prelude::*`.

pub use stosszahl_analysis::impact::ImpactParameters;
pub use stosszahl_gas::{
    EventDriven, Face, Gas, GasBuilder, GasError, Law, MonteCarlo, Rebound, Rough, Scheme, Wall,
};
pub use stosszahl_model::{Budget, Collision, Observer, Particle, Particles, Simulation};
