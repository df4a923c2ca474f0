//! Energy balance of a sheared gas.

use serde::{Deserialize, Serialize};

/// Energy balance of a gas in uniform shear flow: the energy of peculiar motion and spin is the
/// energy supplied, plus the work `-a P_xy V` of the stress over time, less the energy dissipated,
/// exactly and at any density.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ShearWork {
    /// Energy at the start plus the energy that drives have added since \[energy\]; `None` before
    /// the start.
    pub supplied: Option<f64>,
    /// Work of the kinetic part of the stress, the integral of `-a sum m c_x c_y` over time
    /// \[energy\].
    pub kinetic: f64,
    /// Work of the collisional part, `-a` times the sum of `y_12` times the momentum along the flow
    /// that the first partner got \[energy\].
    pub collisional: f64,
    /// Energy that collisions have dissipated \[energy\].
    pub dissipated: f64,
}

impl ShearWork {
    /// Energy that the balance expects \[energy\].
    pub fn expected_energy(&self) -> f64 {
        self.supplied.unwrap_or_default() + self.kinetic + self.collisional - self.dissipated
    }

    /// Energy less the energy expected from the balance, over the sum of work and dissipation so
    /// far; 0 if this sum is zero.
    pub fn imbalance(&self, energy: f64) -> f64 {
        let turnover = self.kinetic.abs() + self.collisional.abs() + self.dissipated.abs();
        if turnover > 0.0 {
            (energy - self.expected_energy()) / turnover
        } else {
            0.0
        }
    }
}
