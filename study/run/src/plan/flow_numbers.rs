//! Dimensionless numbers of a flow between walls or past a disk: Reynolds, Mach and Knudsen number.

use std::f64::consts::PI;

use super::data::{CasePlan, DerivedQuantity};

impl CasePlan {
    /// Computes Reynolds, Mach and Knudsen number of a flow of one species with a mean velocity;
    /// empty without a width between walls or of a disk.
    ///
    /// With the speed u of the first inflow, or else of the start, the mean free path l of the
    /// dilute gas, the diameter h of a disk in the stream or else the width between walls, and c =
    /// (2T/m)^(1/2):
    ///
    /// `Re = rho u h/eta`, where the viscosity of dilute elastic spheres is
    /// `eta = (5 pi^(1/2)/16) rho c l` and that of disks `eta = pi^(-1/2) rho c l` (first Sonine
    /// order); `M = u/(gamma T/m)^(1/2)` with `gamma = 1 + 2/f`, f degrees of freedom of
    /// translation and, of rough particles, rotation; `Kn = l/h`.
    pub(super) fn flow_numbers(&self) -> Vec<DerivedQuantity> {
        let inflow = self.case.inflow.first();
        let velocity = inflow.map(|one| &one.velocity);
        let velocity = velocity.or(self.case.start.velocity.as_ref());
        let ([species], Some(velocity), Some(width)) =
            (&self.gas.species[..], velocity, self.width())
        else {
            return Vec::new();
        };
        let speed = velocity.iter().map(|one| one * one).sum::<f64>().sqrt();
        let temperature = inflow.and_then(|one| one.temperature);
        let temperature: f64 = temperature.unwrap_or(species.temperature);
        let thermal = temperature / species.mass;
        if speed == 0.0 || thermal <= 0.0 {
            return Vec::new();
        }
        let path = self.dilute_mean_free_path();
        let (in_plane, spins) = (self.gas.dimension == 2, self.is_rough());
        let freedom = match (in_plane, spins) {
            (true, false) => 2.0,
            (true, true) | (false, false) => 3.0,
            (false, true) => 6.0,
        };
        let viscosity = if in_plane {
            1.0 / PI.sqrt()
        } else {
            5.0 * PI.sqrt() / 16.0
        };
        let reynolds = speed * width / (viscosity * (2.0 * thermal).sqrt() * path);
        let mach = speed / ((1.0 + 2.0 / freedom) * thermal).sqrt();
        vec![
            DerivedQuantity::new("reynolds_number", reynolds, "1"),
            DerivedQuantity::new("mach_number", mach, "1"),
            DerivedQuantity::new("knudsen_number", path / width, "1"),
        ]
    }

    /// Returns the width of the flow \[length\]: diameter of the first disk obstacle, or else the
    /// smallest distance between walls that face each other.
    fn width(&self) -> Option<f64> {
        let is_wall = |axis: usize, side: usize| self.case.walls.face_at(axis, side).is_wall();
        let between = (0..self.gas.dimension).filter(|&axis| is_wall(axis, 0) && is_wall(axis, 1));
        let between = between.map(|axis| self.gas.lengths[axis]).reduce(f64::min);
        let disk = self
            .case
            .obstacle
            .iter()
            .find_map(|one| one.circle.as_ref());
        disk.map(|disk| 2.0 * disk.radius).or(between)
    }
}
