//! Direct Simulation Monte Carlo of inelastic hard disks, dilute and dense.
