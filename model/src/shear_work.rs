//! Energy balance of a gas in uniform shear flow: work of the stress, dissipation and supplied
//! energy.

use serde::{Deserialize, Serialize};

/// Energy balance of a gas in uniform shear flow. The energy of peculiar motion and spin is the
/// energy supplied, plus the work `-a P_xy V` of the stress over time, less the energy dissipated,
/// exactly and at any density.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ShearWork {
    /// Energy at the start plus the energy that thermostats or baths have added since \[energy\];
    /// `None` before the start.
    pub supplied: Option<f64>,
    /// Work of the kinetic part of the stress, the integral over time of `-a sum m c_x c_y` with
    /// shear rate a and peculiar velocity c \[energy\].
    pub kinetic: f64,
    /// Work of the collisional part of the stress \[energy\]: the sum of `-a y_12` times the
    /// momentum along the flow that the first particle got.
    pub collisional: f64,
    /// Energy that collisions have dissipated since the start \[energy\].
    pub dissipated: f64,
}

impl ShearWork {
    /// Returns the energy that the gas should have by the balance \[energy\].
    pub fn expected_energy(&self) -> f64 {
        self.supplied.unwrap_or_default() + self.kinetic + self.collisional - self.dissipated
    }

    /// Returns the relative error of the energy balance: energy less expected energy, over the sum
    /// of work and dissipation so far; 0 if this sum is zero.
    pub fn imbalance(&self, energy: f64) -> f64 {
        let turnover = self.kinetic.abs() + self.collisional.abs() + self.dissipated.abs();
        if turnover > 0.0 {
            (energy - self.expected_energy()) / turnover
        } else {
            0.0
        }
    }
}
