//! Particles, parameters and starts shared by the tests of walls and flow.

#![allow(dead_code, reason = "each file of tests uses what it needs")]

use stosszahl_dsmc::{Parameters, PartnerDisplacement, Scheme, SimulatorStart};

/// Parameters of Bird's dilute gas, in cells that each test chooses.
pub const PARAMETERS: Parameters = Parameters {
    scheme: Scheme::Boltzmann,
    displacement: PartnerDisplacement::None,
    cell_size: Some(1.0),
    simulators_per_particle: 1,
    copies: SimulatorStart::Independent,
    steps_per_cell_crossing: 3.0,
    max_contact_value: 10.0,
};

/// Diameter of disks whose mean free path is one at this density.
pub fn disk_for_unit_path(density: f64) -> f64 {
    1.0 / (8.0_f64.sqrt() * density)
}

/// Diameter of spheres whose mean free path is one at this density.
pub fn sphere_for_unit_path(density: f64) -> f64 {
    (2.0_f64.sqrt() * std::f64::consts::PI * density).powf(-0.5)
}
