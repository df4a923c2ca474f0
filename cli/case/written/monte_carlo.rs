//! The tables of the Monte Carlo engines as written. Each has keys of its own, though some are shared: a table that
//! is flattened into another could no longer refuse unknown keys.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Monte Carlo collisions at the dilute rate.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Boltzmann {
    /// Displace the partners of a collision as the consistent Boltzmann algorithm does: false, true for one diameter, or
    /// "inelastic" for d (1 + r)/(2 r), which restores the pressure where restitution r shortens the momentum carried.
    #[schemars(extend("x-allowed" = "displacement is true, false or \"inelastic\""))]
    pub displacement: Displacement,
    /// Width of a cell in diameters. Default: half the mean free path, and at least 2.
    #[schemars(extend("exclusiveMinimum" = 0.0, "x-allowed" = "a cell size lies above 0, in diameters"))]
    pub cell_size: Option<f64>,
    /// Simulated particles for each disk.
    #[schemars(extend("minimum" = 1, "maximum" = 1000, "x-allowed" = "the simulators per disk are a whole number from 1 to 1000"))]
    pub simulators_per_disk: u32,
    /// Steps that the fastest particle needs to cross a cell, and in which a mean free time passes.
    #[schemars(extend("minimum" = 1.0, "maximum" = 1e6, "x-allowed" = "the steps per crossing are from 1 to 1000000"))]
    pub steps_per_crossing: f64,
}

impl Default for Boltzmann {
    fn default() -> Self {
        Self {
            displacement: Displacement::Switch(false),
            cell_size: None,
            simulators_per_disk: 1,
            steps_per_crossing: 4.0,
        }
    }
}

/// Monte Carlo collisions at the rate of the free volume in each cell.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct FreeVolume {
    /// Displace the partners of a collision as the consistent Boltzmann algorithm does: false, true for one diameter, or
    /// "inelastic" for d (1 + r)/(2 r), which restores the pressure where restitution r shortens the momentum carried.
    #[schemars(extend("x-allowed" = "displacement is true, false or \"inelastic\""))]
    pub displacement: Displacement,
    /// Width of a cell in diameters. Default: half the mean free path, and at least 2.
    #[schemars(extend("exclusiveMinimum" = 0.0, "x-allowed" = "a cell size lies above 0, in diameters"))]
    pub cell_size: Option<f64>,
    /// Simulated particles for each disk.
    #[schemars(extend("minimum" = 1, "maximum" = 1000, "x-allowed" = "the simulators per disk are a whole number from 1 to 1000"))]
    pub simulators_per_disk: u32,
    /// Steps that the fastest particle needs to cross a cell, and in which a mean free time passes.
    #[schemars(extend("minimum" = 1.0, "maximum" = 1e6, "x-allowed" = "the steps per crossing are from 1 to 1000000"))]
    pub steps_per_crossing: f64,
    /// Limit on the factor by which the density raises the collision rate.
    #[schemars(extend("minimum" = 1.0, "maximum" = 1e9, "x-allowed" = "the largest contact value is from 1 to 1000000000"))]
    pub largest_contact_value: f64,
}

impl Default for FreeVolume {
    fn default() -> Self {
        Self {
            displacement: Displacement::Switch(true),
            cell_size: None,
            simulators_per_disk: 1,
            steps_per_crossing: 4.0,
            largest_contact_value: 10.0,
        }
    }
}

/// Monte Carlo collisions at the rate of Enskog's theory.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Enskog {
    /// Displace the partners of a collision as the consistent Boltzmann algorithm does: false, true for one diameter, or
    /// "inelastic" for d (1 + r)/(2 r), which restores the pressure where restitution r shortens the momentum carried.
    #[schemars(extend("x-allowed" = "displacement is true, false or \"inelastic\""))]
    pub displacement: Displacement,
    /// Width of a cell in diameters. Default: half the mean free path, and at least 2.
    #[schemars(extend("exclusiveMinimum" = 0.0, "x-allowed" = "a cell size lies above 0, in diameters"))]
    pub cell_size: Option<f64>,
    /// Simulated particles for each disk.
    #[schemars(extend("minimum" = 1, "maximum" = 1000, "x-allowed" = "the simulators per disk are a whole number from 1 to 1000"))]
    pub simulators_per_disk: u32,
    /// Steps that the fastest particle needs to cross a cell, and in which a mean free time passes.
    #[schemars(extend("minimum" = 1.0, "maximum" = 1e6, "x-allowed" = "the steps per crossing are from 1 to 1000000"))]
    pub steps_per_crossing: f64,
    /// Where the packing fraction in the contact value is taken: over the `(2n+1)^2` cells around, or
    /// "mean" for the whole box.
    #[schemars(extend("x-allowed" = "a neighbourhood is a whole number of cells from 0 to 50, or \"mean\" for the whole box"))]
    pub neighbourhood: Neighbourhood,
    /// Limit on the factor by which the density raises the collision rate.
    #[schemars(extend("minimum" = 1.0, "maximum" = 1e9, "x-allowed" = "the largest contact value is from 1 to 1000000000"))]
    pub largest_contact_value: f64,
}

impl Default for Enskog {
    fn default() -> Self {
        Self {
            displacement: Displacement::Switch(true),
            cell_size: None,
            simulators_per_disk: 1,
            steps_per_crossing: 4.0,
            neighbourhood: Neighbourhood::Cells(2),
            largest_contact_value: 10.0,
        }
    }
}

/// Monte Carlo collisions with partners from the cell of the point of contact.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Esmc {
    /// Width of a cell in diameters. Default: half the mean free path, and at least half a diameter.
    #[schemars(extend("exclusiveMinimum" = 0.0, "x-allowed" = "a cell size lies above 0, in diameters"))]
    pub cell_size: Option<f64>,
    /// Simulated particles for each disk.
    #[schemars(extend("minimum" = 1, "maximum" = 1000, "x-allowed" = "the simulators per disk are a whole number from 1 to 1000"))]
    pub simulators_per_disk: u32,
    /// Steps in which a mean free time passes.
    #[schemars(extend("minimum" = 1.0, "maximum" = 1e6, "x-allowed" = "the steps per mean free time are from 1 to 1000000"))]
    pub steps_per_mean_free_time: f64,
    /// Where the packing fraction in the contact value is taken: over the `(2n+1)^2` cells around, or
    /// "mean" for the whole box.
    #[schemars(extend("x-allowed" = "a neighbourhood is a whole number of cells from 0 to 50, or \"mean\" for the whole box"))]
    pub neighbourhood: Neighbourhood,
    /// Limit on the factor by which the density raises the collision rate.
    #[schemars(extend("minimum" = 1.0, "maximum" = 1e9, "x-allowed" = "the largest contact value is from 1 to 1000000000"))]
    pub largest_contact_value: f64,
}

impl Default for Esmc {
    fn default() -> Self {
        Self {
            cell_size: None,
            simulators_per_disk: 1,
            steps_per_mean_free_time: 8.0,
            neighbourhood: Neighbourhood::Cells(2),
            largest_contact_value: 10.0,
        }
    }
}

/// Monte Carlo collisions of overlapping disks along their line of centres.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct StochasticDisks {
    /// How readily overlapping disks collide, in units of the rate at which the dilute gas would have Enskog's
    /// collision rate; ever larger, exact hard disks are approached.
    #[schemars(extend("exclusiveMinimum" = 0.0, "maximum" = 1e6, "x-allowed" = "a stiffness lies above 0 and at most at 1000000"))]
    pub stiffness: f64,
    /// Simulated particles for each disk.
    #[schemars(extend("minimum" = 1, "maximum" = 1000, "x-allowed" = "the simulators per disk are a whole number from 1 to 1000"))]
    pub simulators_per_disk: u32,
    /// Steps in which a mean free time passes.
    #[schemars(extend("minimum" = 1.0, "maximum" = 1e6, "x-allowed" = "the steps per mean free time are from 1 to 1000000"))]
    pub steps_per_mean_free_time: f64,
}

impl Default for StochasticDisks {
    fn default() -> Self {
        Self {
            stiffness: 1.0,
            simulators_per_disk: 1,
            steps_per_mean_free_time: 20.0,
        }
    }
}

/// Monte Carlo collisions with partners around the point of contact.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct ContactPoint {
    /// Radius in diameters of the disk around the point of contact from which a partner is drawn. Default: half a
    /// diameter, or a quarter of the mean free path if that is longer.
    #[schemars(extend("minimum" = 0.0, "maximum" = 1e6, "x-allowed" = "a partner radius is from 0, the nearest, to 1000000, in diameters"))]
    pub partner_radius: Option<f64>,
    /// Width of a cell in diameters. Default: as the search for partners likes it.
    #[schemars(extend("exclusiveMinimum" = 0.0, "x-allowed" = "a cell size lies above 0, in diameters"))]
    pub cell_size: Option<f64>,
    /// Simulated particles for each disk. Default: as many as keep the partners of a collision strangers.
    #[schemars(extend("minimum" = 1, "maximum" = 1000, "x-allowed" = "the simulators per disk are a whole number from 1 to 1000"))]
    pub simulators_per_disk: Option<u32>,
    /// How several simulators of a disk start: "independent" of each other, or "coherent" in the long waves of the
    /// start, which then has its own thermal noise. Default: coherent in a cooling gas whose box is unstable.
    #[schemars(extend("x-allowed" = "copies are \"independent\" or \"coherent\""))]
    pub copies: Option<Copies>,
    /// Steps in which a mean free time passes.
    #[schemars(extend("minimum" = 1.0, "maximum" = 1e6, "x-allowed" = "the steps per mean free time are from 1 to 1000000"))]
    pub steps_per_mean_free_time: f64,
    /// Limit on the factor by which the density raises the collision rate.
    #[schemars(extend("minimum" = 1.0, "maximum" = 1e9, "x-allowed" = "the largest contact value is from 1 to 1000000000"))]
    pub largest_contact_value: f64,
}

impl Default for ContactPoint {
    fn default() -> Self {
        Self {
            partner_radius: None,
            cell_size: None,
            simulators_per_disk: None,
            copies: None,
            steps_per_mean_free_time: 8.0,
            largest_contact_value: 100.0,
        }
    }
}

/// A displacement as written.
#[derive(Clone, Copy, Deserialize, Serialize, JsonSchema)]
#[serde(untagged)]
pub enum Displacement {
    /// By one diameter, or not.
    Switch(bool),
    /// By the inelastic length.
    Word(Inelastic),
}

/// The word that stands for the inelastic length.
#[derive(Clone, Copy, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Inelastic {
    /// d (1 + r)/(2 r).
    Inelastic,
}

/// How several simulators of a disk start.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Copies {
    /// Each set moved and turned at random.
    Independent,
    /// Each set with the long waves of the start.
    Coherent,
}

/// A neighbourhood as written.
#[derive(Clone, Copy, Deserialize, Serialize, JsonSchema)]
#[serde(untagged)]
pub enum Neighbourhood {
    /// Cells on each side.
    Cells(#[schemars(extend("minimum" = 0, "maximum" = 50))] u32),
    /// The whole box.
    Whole(Mean),
}

/// The word that stands for the whole box.
#[derive(Clone, Copy, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Mean {
    /// The mean packing fraction of the whole box.
    Mean,
}
