//! Solved kinetic theory of a gas without positions, which the plan keeps.

/// Theoretical value, with its change from one Sonine order less as an error estimate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Predicted {
    /// Theoretical value of the quantity.
    pub value: f64,
    /// Change of the value from one Sonine order less; `None` at the first order.
    pub error: Option<f64>,
}

/// Theory of one species at one sample time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GroupCurve {
    /// Temperature of the species \[energy\].
    pub temperature: Predicted,
    /// Fourth cumulant a2 of the velocities of the species.
    pub fourth_cumulant: Predicted,
    /// Mean squared displacement of the species \[length^2\].
    pub displacement: Predicted,
    /// Diffusion coefficient `<R . v>/D` of the species \[length^2/time\].
    pub diffusion: Predicted,
    /// Relaxation time of the velocity, `m/T` times the diffusion coefficient \[time\]; the mean
    /// over the size groups of the species.
    pub relaxation: Predicted,
    /// Normalised velocity autocorrelation `<v(0) . v(t)>/<v(0)^2>` of the species.
    pub correlation: Predicted,
}

/// Theory of the whole gas and of each species at one sample time.
#[derive(Clone, Debug, PartialEq)]
pub struct TheoryPoint {
    /// Kinetic energy over that of the start.
    pub energy_ratio: Predicted,
    /// Mean number of collisions of a particle since the start, over all particles that collide
    /// with each other.
    pub collisions: Predicted,
    /// Mean squared displacement, averaged over all particles that collide with each other
    /// \[length^2\].
    pub displacement: Predicted,
    /// Theory of each species at the sample time.
    pub groups: Vec<GroupCurve>,
}

/// Theory of a case at all sample times.
#[derive(Clone, Debug, PartialEq)]
pub struct TheoryCurves {
    /// Number of Sonine orders in the expansion of velocities.
    pub orders: usize,
    /// Theory in the order of the sample times; empty for a gas whose particles stick.
    pub at: Vec<TheoryPoint>,
}
