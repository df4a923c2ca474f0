//! Box of a snapshot of a sheared gas, tilted as LAMMPS and OVITO expect it.

use nalgebra::Vector3;
use stosszahl_model::Particles;
use stosszahl_model::images::nearest;

use super::SnapshotUnits;

/// Box of a snapshot, tilted by shear, in the units of the case.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct TiltedBox {
    /// Sides of the box \[length\].
    pub(super) lengths: [f64; 3],
    /// Displacement of the periodic image above along x, from 0 to the width of the box \[length\].
    pub(super) offset: f64,
    /// True for each axis along which the box is periodic; false beyond the dimension.
    pub(super) periodic: [bool; 3],
}

impl TiltedBox {
    pub(super) fn of(particles: &Particles, units: SnapshotUnits) -> Self {
        let mut lengths = particles.lengths.map(|side| side * units.scale.length);
        if particles.dimension == 2 {
            lengths[2] = units.depth;
        }
        Self {
            lengths,
            offset: particles.shear_offset(units.shear) * units.scale.length,
            periodic: [0, 1, 2].map(|axis| axis < particles.dimension && particles.periodic[axis]),
        }
    }

    /// Returns the tilt: displacement of the upper side along x, at most half the width \[length\],
    /// as programs for tilted boxes expect it.
    pub(super) fn tilt(&self) -> f64 {
        nearest(self.offset, self.lengths[0])
    }

    /// Returns the periodic image of a position that lies in the tilted box; the position itself
    /// without a tilt.
    pub(super) fn inside(&self, position: Vector3<f64>) -> Vector3<f64> {
        let ([width, height, _], tilt) = (self.lengths, self.tilt());
        if tilt == 0.0 {
            return position;
        }
        let boxes = ((position.x - tilt * position.y / height) / width).floor();
        position - Vector3::new(width * boxes, 0.0, 0.0)
    }
}
