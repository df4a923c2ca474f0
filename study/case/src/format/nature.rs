//! Properties of the gas that a case describes, such as `has_box` and `is_elastic`. Defaults,
//! checks and measurements depend on them.

use super::{Case, FaceSpec, FaceWord};

impl Case {
    /// Returns true if the gas has positions in a box; without one it is homogeneous by
    /// construction.
    pub fn has_box(&self) -> bool {
        self.domain.is_some()
    }

    /// Returns true if the gas has walls, openings or obstacles, which single out a frame of
    /// reference.
    pub fn is_bounded(&self) -> bool {
        !self.walls.is_periodic() || !self.obstacle.is_empty()
    }

    /// Returns true if particles leave through a face of the box, so that their number changes.
    pub fn is_open(&self) -> bool {
        let open = FaceSpec::Word(FaceWord::Open);
        self.walls.all_faces().any(|face| *face == open)
    }

    /// Returns true if the gas is homogeneous by its setup: no walls, openings, obstacles or
    /// gravity. A gas without positions is so by construction.
    pub fn is_uniform(&self) -> bool {
        !self.is_bounded() && self.gravity.is_none()
    }

    /// Returns true for a gas in a periodic box without obstacles or gravity.
    pub fn is_uniform_box(&self) -> bool {
        self.has_box() && self.is_uniform()
    }

    /// Returns true if the particles are rough and spin.
    pub fn is_rough(&self) -> bool {
        self.gas.tangential_restitution.is_some()
    }

    /// Returns true for a uniform shear flow, with Lees-Edwards boundaries.
    pub fn is_sheared(&self) -> bool {
        let shear_rate = self.domain.as_ref().and_then(|domain| domain.shear_rate);
        shear_rate.is_some()
    }

    /// Returns true if contacts conserve energy: a restitution of 1, and for particles that spin a
    /// tangential restitution of 1 or -1.
    pub fn is_elastic(&self) -> bool {
        let tangential = self.gas.tangential_restitution;
        self.gas.restitution.is_elastic()
            && self.pair.iter().all(|pair| pair.restitution.is_elastic())
            && tangential.is_none_or(|tangential| tangential.abs() == 1.0)
    }

    /// Returns true for a uniform gas that contacts alone cool: not elastic, without a
    /// thermostat, a shear flow or contacts that heat.
    pub fn cools_freely(&self) -> bool {
        self.is_uniform()
            && !self.is_elastic()
            && !self.gas.restitution.heats()
            && self.thermostat.is_none()
            && !self.is_sheared()
    }

    /// Returns true if engines compute with the mean diameter, the mean mass and the temperature of
    /// the start as units: smooth particles in a uniform box, where the case has no other length,
    /// mass or energy that would be converted. Runs that differ in these three alone are then
    /// equal, and the cooling time is the natural unit of time. With walls, gravity or spins, and
    /// without a box, engines compute in the units of the case.
    pub fn has_thermal_units(&self) -> bool {
        self.is_uniform_box() && !self.is_rough()
    }
}
