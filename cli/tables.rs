//! Rows of the tables in a results folder, one struct for each CSV file.
//!
//! The program that writes a table and the report that reads it share these structs, so a column is named once.
//! Times and windows are in units of `t0`, Haff's cooling time, unless a column says otherwise. `engine` is `ed`,
//! `dsmc-boltzmann`, `dsmc-free-volume` or `dsmc-enskog`. A standard error (`_se`) is empty where it cannot be
//! estimated, which is the case of a single replica. Lines that begin with `#` are comments.
//!
//! ```
//! use stosszahl::tables::{PairCorrelationRow, Row};
//! let row = PairCorrelationRow { engine: "ed".into(), time_over_t0: 2.0, r_over_d: 1.01, g: 2.4, g_se: None };
//! let mut table = csv::Writer::from_writer(Vec::new());
//! table.serialize(&row)?;
//! assert_eq!(table.into_inner()?, b"engine,time_over_t0,r_over_d,g,g_se\ned,2.0,1.01,2.4,\n");
//! assert_eq!(PairCorrelationRow::COLUMNS.len(), 5);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use serde::{Deserialize, Serialize, de::DeserializeOwned};

/// A table of the results folder: the name of its file and of its columns, in their order.
pub trait Row: Serialize + DeserializeOwned {
    /// Name of the file inside the results folder.
    const FILE: &'static str;
    /// Names of the columns, as the header line of the file spells them.
    const COLUMNS: &'static [&'static str];
}

/// Declares the struct of a row together with the names of its file and columns.
macro_rules! row {
    ($(#[$about:meta])* $name:ident in $file:literal { $($(#[$doc:meta])* $field:ident: $kind:ty,)+ }) => {
        $(#[$about])*
        #[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
        pub struct $name { $($(#[$doc])* pub $field: $kind,)+ }

        impl $crate::tables::Row for $name {
            const FILE: &'static str = $file;
            const COLUMNS: &'static [&'static str] = &[$(stringify!($field)),+];
        }
    };
}
pub(crate) use row;

row! {
    /// Energy and velocity distribution at one sample time, averaged over the replicas (`energy.csv`).
    EnergyRow in "energy.csv" {
        /// Engine.
        engine: String,
        /// Time since the start of the dissipative run \[units of the case\].
        time: f64,
        /// Time `t/t0` \[1\].
        time_over_t0: f64,
        /// Collisions that a particle took part in since the start, on average \[1\].
        collisions_per_particle: f64,
        /// Kinetic energy over its initial value, `K(t)/K(0)` \[1\].
        energy_ratio: f64,
        /// Standard error of `energy_ratio` \[1\].
        energy_ratio_se: Option<f64>,
        /// Haff's law `(1 + t/t0)^-2` \[1\]; empty where the law does not apply.
        haff_ratio: Option<f64>,
        /// Fourth cumulant `a2` of the velocity distribution, zero for a Gaussian \[1\].
        fourth_cumulant: f64,
        /// Standard error of `fourth_cumulant` \[1\].
        fourth_cumulant_se: Option<f64>,
        /// Replicas that the averages run over.
        replicas: u64,
    }
}

row! {
    /// Energies of two engines at the same time (`comparison.csv`).
    ComparisonRow in "comparison.csv" {
        /// First engine, the numerator of the quotient.
        engine_a: String,
        /// Second engine, the denominator of the quotient.
        engine_b: String,
        /// Time `t/t0` \[1\].
        time_over_t0: f64,
        /// `K(t)/K(0)` of the first engine \[1\].
        energy_ratio_a: f64,
        /// `K(t)/K(0)` of the second engine \[1\].
        energy_ratio_b: f64,
        /// `energy_ratio_a / energy_ratio_b` \[1\].
        quotient: f64,
        /// Standard error of `quotient` \[1\].
        quotient_se: Option<f64>,
        /// Difference from equality in standard errors \[1\].
        z: Option<f64>,
        /// Outcome in words: `agree`, `a higher`, `a lower`, `undecided`.
        verdict: String,
    }
}

row! {
    /// One bin of the distribution of the impact parameter in one time window (`impact_parameter.csv`).
    ImpactParameterRow in "impact_parameter.csv" {
        /// Engine.
        engine: String,
        /// Start of the window, `t/t0` \[1\].
        window_start: f64,
        /// End of the window, `t/t0` \[1\].
        window_end: f64,
        /// Lower edge of the bin, `b/d` \[1\].
        bin_low: f64,
        /// Upper edge of the bin, `b/d` \[1\].
        bin_high: f64,
        /// Collisions in the bin, over all replicas.
        count: u64,
        /// Probability density `P(b/d)`, which integrates to one over `0 < b/d < 1` \[1\].
        density: f64,
        /// Standard error of `density` \[1\].
        density_se: Option<f64>,
    }
}

row! {
    /// The distribution of the impact parameter in one time window, in a few numbers (`impact_parameter_summary.csv`).
    ImpactSummaryRow in "impact_parameter_summary.csv" {
        /// Engine.
        engine: String,
        /// Start of the window, `t/t0` \[1\].
        window_start: f64,
        /// End of the window, `t/t0` \[1\].
        window_end: f64,
        /// Collisions in the window, over all replicas.
        collisions: u64,
        /// Slope of `P(b/d)` against `b/d`, zero under molecular chaos, positive where grazing collisions prevail \[1\].
        slope: Option<f64>,
        /// Standard error of `slope` \[1\].
        slope_se: Option<f64>,
        /// Mean of `b/d`, one half under molecular chaos \[1\].
        mean_b_over_d: Option<f64>,
        /// Chi-squared statistic against the uniform distribution \[1\].
        chi_squared: Option<f64>,
        /// Degrees of freedom of `chi_squared`.
        degrees_of_freedom: u64,
        /// Probability of so large a `chi_squared` under the uniform distribution \[1\].
        p_value: Option<f64>,
        /// Outcome in words.
        verdict: String,
    }
}

row! {
    /// Structure factor on one shell of wave numbers at one time (`structure_factor.csv`).
    StructureFactorRow in "structure_factor.csv" {
        /// Engine.
        engine: String,
        /// Time `t/t0` \[1\].
        time_over_t0: f64,
        /// Wave number `k = L/wavelength`, the number of wavelengths in the side `L` of the domain \[1\].
        k: f64,
        /// Structure factor `S(k)`, one for an ideal gas \[1\].
        structure_factor: f64,
        /// Standard error of `structure_factor` \[1\].
        structure_factor_se: Option<f64>,
        /// Wave vectors in the shell.
        modes: u64,
    }
}

row! {
    /// Pair correlation function at one distance and time (`pair_correlation.csv`).
    PairCorrelationRow in "pair_correlation.csv" {
        /// Engine.
        engine: String,
        /// Time `t/t0` \[1\].
        time_over_t0: f64,
        /// Distance of the centres over the diameter, `r/d` \[1\].
        r_over_d: f64,
        /// Pair correlation function `g(r)`, one for an ideal gas \[1\].
        g: f64,
        /// Standard error of `g` \[1\].
        g_se: Option<f64>,
    }
}

row! {
    /// The dissipation identity in one time window (`dissipation.csv`): the cooling rate over its value under
    /// molecular chaos (Enskog) is the product of the four ratios of rate, speed, impact and correlation.
    DissipationRow in "dissipation.csv" {
        /// Engine.
        engine: String,
        /// Start of the window, `t/t0` \[1\].
        window_start: f64,
        /// End of the window, `t/t0` \[1\].
        window_end: f64,
        /// Collisions in the window, over all replicas.
        collisions: u64,
        /// Collision rate over its Enskog value \[1\].
        rate_ratio: Option<f64>,
        /// Standard error of `rate_ratio` \[1\].
        rate_ratio_se: Option<f64>,
        /// Mean squared relative speed `<g^2>` of colliding pairs over its Enskog value \[1\].
        speed_ratio: Option<f64>,
        /// Standard error of `speed_ratio` \[1\].
        speed_ratio_se: Option<f64>,
        /// Mean of `1 - b^2/d^2` over two thirds, its value for a uniform impact parameter \[1\].
        impact_ratio: Option<f64>,
        /// Standard error of `impact_ratio` \[1\].
        impact_ratio_se: Option<f64>,
        /// What is left: the correlation of relative speed and impact parameter in a collision \[1\].
        correlation_ratio: Option<f64>,
        /// Standard error of `correlation_ratio` \[1\].
        correlation_ratio_se: Option<f64>,
        /// Cooling rate over its Enskog value, the product of the four \[1\].
        dissipation_ratio: Option<f64>,
        /// Standard error of `dissipation_ratio` \[1\].
        dissipation_ratio_se: Option<f64>,
        /// Replicas that the ratios are averaged over.
        replicas: u64,
    }
}

row! {
    /// Temperature of a driven gas, averaged over one quarter of the run (`steady_state.csv`).
    SteadyRow in "steady_state.csv" {
        /// Engine.
        engine: String,
        /// Start of the quarter, `t/t0` \[1\].
        window_start: f64,
        /// End of the quarter, `t/t0` \[1\].
        window_end: f64,
        /// Mean temperature over that of the start \[1\]; empty without a kick in the quarter.
        temperature_ratio: Option<f64>,
        /// Standard error of `temperature_ratio` \[1\].
        temperature_ratio_se: Option<f64>,
        /// Steady temperature over that of the start, by Enskog's theory \[1\]; empty where it does not apply.
        theory_ratio: Option<f64>,
        /// Replicas that the average runs over.
        replicas: u64,
    }
}

row! {
    /// Mean squared displacement of the disks at one time (`mean_squared_displacement.csv`).
    DisplacementRow in "mean_squared_displacement.csv" {
        /// Engine.
        engine: String,
        /// Time `t/t0` \[1\].
        time_over_t0: f64,
        /// Time since the start of the measurement, over `t0` \[1\].
        elapsed_over_t0: f64,
        /// Mean squared displacement over the squared diameter \[1\].
        displacement_square_over_d2: f64,
        /// Standard error of `displacement_square_over_d2` \[1\].
        displacement_square_over_d2_se: Option<f64>,
        /// The same by Enskog's theory in first Sonine order \[1\]; empty where it does not apply.
        theory_over_d2: Option<f64>,
        /// Replicas that the average runs over.
        replicas: u64,
    }
}

/// How far a source of error is to be minded.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Mark {
    /// Up to 1 %.
    Green,
    /// Up to 5 %.
    Amber,
    /// More, or unknown.
    Red,
}

row! {
    /// One source of error of one engine (`error_budget.csv`).
    ErrorBudgetRow in "error_budget.csv" {
        /// Engine.
        engine: String,
        /// Source of error.
        source: String,
        /// What was measured of it; empty if nothing could be.
        value: Option<f64>,
        /// Unit of `value`.
        unit: String,
        /// Rough estimate of the relative error \[1\]; empty where there is none.
        estimate: Option<f64>,
        /// `green`, `amber` or `red`.
        mark: Mark,
        /// What goes wrong, and in what.
        reason: String,
    }
}

row! {
    /// Temperature of one species of a gas of several (`partial_temperature.csv`).
    PartialTemperatureRow in "partial_temperature.csv" {
        /// Engine.
        engine: String,
        /// Time `t/t0` \[1\].
        time_over_t0: f64,
        /// Number of the species, from 1.
        species: u64,
        /// Its temperature over that of the gas at the start \[1\].
        temperature_ratio: f64,
        /// Standard error of `temperature_ratio` \[1\].
        temperature_ratio_se: Option<f64>,
        /// The same by Enskog's equations \[1\]; empty where they do not apply.
        temperature_ratio_theory: Option<f64>,
        /// Its temperature over that of the first species at the same time \[1\].
        ratio_to_first: f64,
        /// Standard error of `ratio_to_first` \[1\].
        ratio_to_first_se: Option<f64>,
        /// The same by Enskog's equations \[1\]; empty where they do not apply.
        ratio_to_first_theory: Option<f64>,
        /// Replicas that the averages run over.
        replicas: u64,
    }
}

row! {
    /// One bin of the distribution of the impact parameter of one kind of pair (`impact_parameter_pairs.csv`).
    PairImpactRow in "impact_parameter_pairs.csv" {
        /// Engine.
        engine: String,
        /// Number of one species, from 1.
        species_a: u64,
        /// Number of the other, not below the first.
        species_b: u64,
        /// Start of the window, `t/t0` \[1\].
        window_start: f64,
        /// End of the window, `t/t0` \[1\].
        window_end: f64,
        /// Lower edge of the bin, `b/d` \[1\], d the distance of the centres at contact.
        bin_low: f64,
        /// Upper edge of the bin, `b/d` \[1\].
        bin_high: f64,
        /// Collisions in the bin, over all replicas.
        count: u64,
        /// Probability density `P(b/d)`, which integrates to one over `0 < b/d < 1` \[1\].
        density: f64,
        /// Standard error of `density` by the number of collisions \[1\].
        density_se: Option<f64>,
    }
}

row! {
    /// Raw sample of one replica (`replicas.csv`).
    ReplicaRow in "replicas.csv" {
        /// Number of the replica, from zero.
        replica: u64,
        /// Engine.
        engine: String,
        /// Time `t/t0` \[1\].
        time_over_t0: f64,
        /// Kinetic energy over its initial value, `K(t)/K(0)` \[1\].
        energy_ratio: f64,
        /// Fourth cumulant `a2` of the velocity distribution \[1\].
        fourth_cumulant: f64,
        /// Collisions that a particle took part in since the start, on average \[1\].
        collisions_per_particle: f64,
    }
}
