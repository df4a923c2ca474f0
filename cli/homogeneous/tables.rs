//! Rows of the tables in the results folder of a gas without positions, one struct for each CSV file.
//!
//! Times are in the unit that `run.time_unit` names. A standard error (`_se`) is the larger of two: the spread over
//! replicas, and the spread over particles (where it is known), so that few replicas that lie close together by chance do
//! not look precise. It is empty where neither is known. A value of theory is empty where there is none; its error
//! (`_theory_error`) is the change from one Sonine order less, and empty for the first.

use serde::{Deserialize, Serialize};

use crate::tables::row;

row! {
    /// The gas as a whole at one sample time (`gas.csv`).
    GasRow in "gas.csv" {
        /// Time.
        time: f64,
        /// Particles over those of the start \[1\].
        particles_ratio: f64,
        /// Standard error of `particles_ratio` \[1\].
        particles_ratio_se: Option<f64>,
        /// Collisions that a particle took part in since the start, on average over the particles of the start \[1\]; empty
        /// where tracers collide too.
        collisions_per_particle: Option<f64>,
        /// Standard error of `collisions_per_particle` \[1\].
        collisions_per_particle_se: Option<f64>,
        /// The same by theory \[1\].
        collisions_per_particle_theory: Option<f64>,
        /// Error of `collisions_per_particle_theory` \[1\].
        collisions_per_particle_theory_error: Option<f64>,
        /// Kinetic energy over its initial value, without tracers \[1\].
        energy_ratio: f64,
        /// Standard error of `energy_ratio` \[1\].
        energy_ratio_se: Option<f64>,
        /// The same by theory \[1\].
        energy_ratio_theory: Option<f64>,
        /// Error of `energy_ratio_theory` \[1\].
        energy_ratio_theory_error: Option<f64>,
        /// Mean squared displacement of all particles but tracers \[length^2\].
        displacement_square: Option<f64>,
        /// Standard error of `displacement_square`.
        displacement_square_se: Option<f64>,
        /// The same by theory.
        displacement_square_theory: Option<f64>,
        /// Error of `displacement_square_theory`.
        displacement_square_theory_error: Option<f64>,
        /// Replicas that the averages run over.
        replicas: u64,
    }
}

row! {
    /// One species, or the particles of like size, at one sample time (`species.csv`).
    SpeciesRow in "species.csv" {
        /// Time.
        time: f64,
        /// Number of the species, from 1.
        species: u64,
        /// Mass of a particle.
        mass: f64,
        /// Diameter of a particle \[length\].
        diameter: f64,
        /// Particles in each replica.
        count: u64,
        /// Temperature `m <v^2>/D` \[energy\].
        temperature: f64,
        /// Standard error of `temperature`.
        temperature_se: Option<f64>,
        /// The same by theory.
        temperature_theory: Option<f64>,
        /// Error of `temperature_theory`.
        temperature_theory_error: Option<f64>,
        /// Fourth cumulant `a2` of the velocity distribution, zero for a Gaussian \[1\].
        fourth_cumulant: f64,
        /// Standard error of `fourth_cumulant`, from replicas only \[1\].
        fourth_cumulant_se: Option<f64>,
        /// The same by theory \[1\]; empty in the first order, which has none.
        fourth_cumulant_theory: Option<f64>,
        /// Error of `fourth_cumulant_theory` \[1\].
        fourth_cumulant_theory_error: Option<f64>,
        /// Mean squared displacement \[length^2\].
        displacement_square: Option<f64>,
        /// Standard error of `displacement_square`.
        displacement_square_se: Option<f64>,
        /// The same by theory.
        displacement_square_theory: Option<f64>,
        /// Error of `displacement_square_theory`.
        displacement_square_theory_error: Option<f64>,
        /// Correlation of the velocity with that of the start, `<v(0) . v(t)>/<v(0)^2>` \[1\].
        velocity_correlation: Option<f64>,
        /// Standard error of `velocity_correlation`, from replicas only \[1\].
        velocity_correlation_se: Option<f64>,
        /// The same by theory \[1\].
        velocity_correlation_theory: Option<f64>,
        /// Error of `velocity_correlation_theory` \[1\].
        velocity_correlation_theory_error: Option<f64>,
    }
}

row! {
    /// Displacement averaged over time along whole paths up to the end of the run (`time_averaged_displacement.csv`).
    TimeAveragedRow in "time_averaged_displacement.csv" {
        /// Lag, in the unit of time.
        lag: f64,
        /// Number of the species, from 1.
        species: u64,
        /// Mass of a particle.
        mass: f64,
        /// Squared displacement over the lag, averaged over all its starts and over paths \[length^2\].
        displacement_square: f64,
        /// Standard error of `displacement_square`, from replicas only.
        displacement_square_se: Option<f64>,
        /// The same by theory.
        displacement_square_theory: Option<f64>,
        /// Error of `displacement_square_theory`.
        displacement_square_theory_error: Option<f64>,
        /// Paths in each replica.
        paths: u64,
    }
}

row! {
    /// A gas that sticks at one sample time (`clusters.csv`). Energies are over that of the start.
    ClusterRow in "clusters.csv" {
        /// Time.
        time: f64,
        /// Clusters over those of the start, `N/N_0` \[1\].
        clusters_ratio: f64,
        /// Standard error of `clusters_ratio` \[1\].
        clusters_ratio_se: Option<f64>,
        /// Clusters of one monomer over those of the start \[1\].
        single_ratio: f64,
        /// Monomers of the cluster that a monomer is in, on average over monomers \[1\].
        mean_monomers: f64,
        /// Standard error of `mean_monomers` \[1\].
        mean_monomers_se: Option<f64>,
        /// Monomers of the largest cluster, on average over replicas \[1\].
        largest_monomers: f64,
        /// Kinetic energy \[1\].
        energy_ratio: f64,
        /// Standard error of `energy_ratio` \[1\].
        energy_ratio_se: Option<f64>,
        /// Energy lost in sticking since the start \[1\].
        stuck_energy: f64,
        /// Energy lost in breaking since the start \[1\].
        shattered_energy: f64,
        /// Energy put in by heating since the start \[1\].
        heating_energy: f64,
        /// Pairs that stuck since the start, for each monomer \[1\].
        mergers_per_monomer: f64,
        /// Pairs that broke since the start, for each monomer \[1\].
        shatterings_per_monomer: f64,
        /// Pairs that should have stuck or broken, but bounced because of limits on numbers, in all replicas.
        refused: u64,
    }
}

row! {
    /// Numbers of clusters by their monomers (`size_distribution.csv`).
    SizeRow in "size_distribution.csv" {
        /// `instant`: at `time`; `steady`: averaged from `time` to the end of the run.
        average: String,
        /// Time.
        time: f64,
        /// Smallest number of monomers of the bin.
        monomers_low: u64,
        /// Largest number of monomers of the bin.
        monomers_high: u64,
        /// Clusters of one size in the bin, on average over its sizes, for each monomer of the gas \[1\].
        clusters_per_monomer: f64,
        /// Standard error of `clusters_per_monomer`, from replicas only \[1\].
        clusters_per_monomer_se: Option<f64>,
        /// Clusters counted, in all replicas and times.
        counted: u64,
    }
}

row! {
    /// One comparison with theory (`checks.csv`).
    CheckRow in "checks.csv" {
        /// What is compared.
        quantity: String,
        /// Number of the species, from 1; empty for the gas as a whole.
        species: Option<u64>,
        /// Time of the largest deviation that can be told from chance, or else of the largest one.
        time: f64,
        /// Measured.
        measured: f64,
        /// Its standard error.
        measured_se: Option<f64>,
        /// By theory.
        theory: f64,
        /// Its error: the change from one Sonine order less.
        theory_error: Option<f64>,
        /// Measured over theory, less one \[percent\].
        deviation_percent: f64,
        /// Deviation in standard errors, that of theory included \[1\].
        z: Option<f64>,
        /// Outcome: `agree`, `differ` or `undecided`.
        verdict: String,
    }
}

row! {
    /// Raw sample of one replica (`replicas.csv`).
    SampleRow in "replicas.csv" {
        /// Number of the replica, from zero.
        replica: u64,
        /// Time.
        time: f64,
        /// Particles.
        particles: u64,
        /// Pair collisions since the start.
        collisions: u64,
        /// Kinetic energy, `(1/2) sum m v^2` \[energy\].
        energy: f64,
    }
}
