//! Species of a mixture in kinetic theory: mass, diameter and number density.

/// Species of a mixture: size, mass and number density.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Component {
    /// Mass of a particle \[mass\].
    pub mass: f64,
    /// Diameter of a particle \[length\].
    pub diameter: f64,
    /// Number density \[1/length^D\]; zero is the tracer limit.
    pub density: f64,
}
