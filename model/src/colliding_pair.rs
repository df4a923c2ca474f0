//! Pair of particles before and after a collision: input and result of the collision law.

/// Pair of particles about to collide: input of the collision law.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CollidingPair<V, W = ()> {
    /// Velocities of the first and the second particle before the collision \[length/time\].
    pub velocities: [V; 2],
    /// Angular velocities of both particles before the collision \[1/time\]; an empty type for
    /// smooth particles.
    pub spins: [W; 2],
    /// Masses of both particles \[mass\].
    pub masses: [f64; 2],
    /// Radii of both particles \[length\]; not used for smooth particles.
    pub radii: [f64; 2],
    /// Line of centres at contact, from the second to the first particle; any positive length. A
    /// law that adds speed pushes the particles apart along it.
    pub line: V,
}

/// Velocities and spins of a pair of particles after a collision.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PostCollision<V, W = ()> {
    /// Velocities of the first and the second particle after the collision \[length/time\].
    pub velocities: [V; 2],
    /// Angular velocities of both particles after the collision \[1/time\]; an empty type for
    /// smooth particles.
    pub spins: [W; 2],
}
