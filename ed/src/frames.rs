//! Frames of the cells around a disk: positions and velocities.

use nalgebra::{Vector2, vector};

/// Frames of the cells around one, by their numbers: positions and velocities.
pub(crate) trait CellFrames {
    /// Returns the separation of a disk from another at a position in a cell.
    fn separation(&self, cell: usize, position: Vector2<f64>) -> Vector2<f64>;

    /// Returns the relative velocity from the difference of velocities in two frames.
    fn relative(&self, cell: usize, difference: Vector2<f64>) -> Vector2<f64>;
}

/// Frames of cells at rest: position of a disk relative to the corners of their columns, and of
/// their rows.
pub(crate) struct Still(pub(crate) [[f64; 4]; 2]);

impl CellFrames for Still {
    #[inline(always)]
    fn separation(&self, cell: usize, position: Vector2<f64>) -> Vector2<f64> {
        let [x, y] = &self.0;
        vector![x[cell % 4] - position[0], y[cell / 4 % 4] - position[1]]
    }

    #[inline(always)]
    fn relative(&self, _cell: usize, difference: Vector2<f64>) -> Vector2<f64> {
        difference
    }
}

/// Frames of cells in rows that slide.
pub(crate) struct Sliding {
    /// Position of a disk relative to the corners of cells, along the flow.
    pub(crate) x: [f64; 12],
    /// Position of a disk relative to the corners of cells, across the flow, by row.
    pub(crate) y: [f64; 4],
    /// Velocity of the disk's own row less the velocity of each row.
    pub(crate) slip: [f64; 4],
}

impl CellFrames for Sliding {
    #[inline(always)]
    fn separation(&self, cell: usize, position: Vector2<f64>) -> Vector2<f64> {
        vector![
            self.x[cell % 12] - position[0],
            self.y[cell / 4 % 4] - position[1]
        ]
    }

    #[inline(always)]
    fn relative(&self, cell: usize, difference: Vector2<f64>) -> Vector2<f64> {
        vector![difference[0] + self.slip[cell / 4 % 4], difference[1]]
    }
}
