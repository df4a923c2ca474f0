//! Rows of the tables of a flow, one struct for each CSV file.
//!
//! Lengths, masses and times are in the units of the case, temperatures are energies. A standard error (`_se`) is empty
//! where it cannot be estimated.

use serde::{Deserialize, Serialize};

use crate::tables::row;

row! {
    /// The whole gas at one time, averaged over the replicas (`series.csv`).
    SeriesRow in "series.csv" {
        /// Engine: `ed` or `dsmc`.
        engine: String,
        /// Time.
        time: f64,
        /// Number of grains.
        grains: f64,
        /// Collisions that a grain took part in since the start, on average.
        collisions_per_grain: f64,
        /// Energy of translation, of all grains.
        translation: f64,
        /// Energy of rotation.
        rotation: f64,
        /// Energy in the field; zero at the origin.
        potential: f64,
        /// Their sum.
        energy: f64,
        /// Standard error of `energy`.
        energy_se: Option<f64>,
        /// Granular temperature, m <(v - u)^2>/D with the mean velocity u of all grains.
        temperature: f64,
        /// Standard error of `temperature`.
        temperature_se: Option<f64>,
        /// Temperature of rotation; empty for smooth grains.
        spin_temperature: Option<f64>,
        /// Standard error of `spin_temperature`.
        spin_temperature_se: Option<f64>,
        /// Temperature by theory; empty where there is none.
        theory_temperature: Option<f64>,
        /// Temperature of rotation by theory.
        theory_spin_temperature: Option<f64>,
        /// Replicas that the averages run over.
        replicas: u64,
    }
}

row! {
    /// One species at one time, averaged over the replicas (`species.csv`).
    SpeciesRow in "species.csv" {
        /// Engine.
        engine: String,
        /// Time.
        time: f64,
        /// Name of the species.
        species: String,
        /// Number of its grains.
        grains: f64,
        /// Its temperature, m <v^2>/D about its own mean velocity.
        temperature: f64,
        /// Standard error of `temperature`.
        temperature_se: Option<f64>,
        /// Its temperature of rotation; empty for smooth grains.
        spin_temperature: Option<f64>,
        /// Standard error of `spin_temperature`.
        spin_temperature_se: Option<f64>,
    }
}

row! {
    /// Fields in one cell and window of time (`fields.csv`).
    FieldRow in "fields.csv" {
        /// Engine.
        engine: String,
        /// Start of the window.
        window_start: f64,
        /// End of the window.
        window_end: f64,
        /// Centre of the cell along the first axis.
        x: f64,
        /// Centre of the cell along the second axis.
        y: f64,
        /// Grains per volume (area in the plane).
        number_density: f64,
        /// Standard error of `number_density`.
        number_density_se: Option<f64>,
        /// Mean velocity along the first axis.
        velocity_x: f64,
        /// Standard error of `velocity_x`.
        velocity_x_se: Option<f64>,
        /// Mean velocity along the second axis.
        velocity_y: f64,
        /// Standard error of `velocity_y`.
        velocity_y_se: Option<f64>,
        /// Granular temperature.
        temperature: f64,
        /// Standard error of `temperature`.
        temperature_se: Option<f64>,
        /// Temperature of rotation; zero for smooth grains.
        spin_temperature: f64,
        /// Standard error of `spin_temperature`.
        spin_temperature_se: Option<f64>,
        /// Pressure: n T, and what collisions carry.
        pressure: f64,
        /// Standard error of `pressure`.
        pressure_se: Option<f64>,
        /// Collisions that a grain takes part in, per time.
        collision_rate: f64,
        /// Standard error of `collision_rate`.
        collision_rate_se: Option<f64>,
    }
}

row! {
    /// A profile in one window of time (`profiles.csv`).
    ProfileRow in "profiles.csv" {
        /// Engine.
        engine: String,
        /// Start of the window.
        window_start: f64,
        /// End of the window.
        window_end: f64,
        /// Axis of the profile: `x` or `y`; the other one is averaged over.
        along: String,
        /// Species, or `all`.
        species: String,
        /// Place along the axis.
        at: f64,
        /// Grains per volume (area in the plane).
        number_density: f64,
        /// Standard error of `number_density`.
        number_density_se: Option<f64>,
        /// The same by theory; empty where there is none.
        theory_number_density: Option<f64>,
        /// Mean velocity along the first axis.
        velocity_x: f64,
        /// Standard error of `velocity_x`.
        velocity_x_se: Option<f64>,
        /// Mean velocity along the second axis.
        velocity_y: f64,
        /// Standard error of `velocity_y`.
        velocity_y_se: Option<f64>,
        /// Granular temperature.
        temperature: f64,
        /// Standard error of `temperature`.
        temperature_se: Option<f64>,
        /// Temperature of rotation; zero for smooth grains.
        spin_temperature: f64,
        /// Standard error of `spin_temperature`.
        spin_temperature_se: Option<f64>,
        /// Pressure; zero for one of several species.
        pressure: f64,
        /// Standard error of `pressure`.
        pressure_se: Option<f64>,
    }
}

row! {
    /// What a boundary gives to the gas, per time, in the last window (`boundaries.csv`).
    BoundaryRow in "boundaries.csv" {
        /// Engine.
        engine: String,
        /// Name of the face, obstacle or inflow.
        boundary: String,
        /// Start of the window.
        window_start: f64,
        /// End of the window.
        window_end: f64,
        /// Contacts per time, or grains per time that came in (out: below zero).
        grains_per_time: f64,
        /// Standard error of `grains_per_time`.
        grains_per_time_se: Option<f64>,
        /// Force on the gas along the first axis.
        force_x: f64,
        /// Standard error of `force_x`.
        force_x_se: Option<f64>,
        /// Force on the gas along the second axis.
        force_y: f64,
        /// Standard error of `force_y`.
        force_y_se: Option<f64>,
        /// Power given to the gas.
        power: f64,
        /// Standard error of `power`.
        power_se: Option<f64>,
    }
}
