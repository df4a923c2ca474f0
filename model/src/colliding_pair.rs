//! A pair of particles before and after a collision.

/// Pair of particles about to collide: input of the collision law.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CollidingPair<V, W = ()> {
    /// Velocities of the first and the second partner \[length/time\].
    pub velocities: [V; 2],
    /// Angular velocities \[1/time\]; nothing for smooth particles.
    pub spins: [W; 2],
    /// Masses of the partners \[mass\].
    pub masses: [f64; 2],
    /// Radii \[length\]; not read for smooth particles.
    pub radii: [f64; 2],
    /// Line of centres, from the second to the first partner; any positive length. A law that
    /// adds speed pushes the partners apart along it.
    pub line: V,
}

/// Velocities and spins of a pair after a collision.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PostCollision<V, W = ()> {
    /// Velocities of the first and the second partner \[length/time\].
    pub velocities: [V; 2],
    /// Angular velocities \[1/time\]; nothing for smooth particles.
    pub spins: [W; 2],
}
