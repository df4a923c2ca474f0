//! Frames of the cells around a disk: where they are, and how they move.

use nalgebra::{Vector2, vector};

/// Frames of the cells around one, by their numbers: where they are, and how they move.
pub(crate) trait Frames {
    /// Separation of a disk from another at a position in a cell.
    fn separation(&self, cell: usize, position: Vector2<f64>) -> Vector2<f64>;

    /// Relative velocity from the difference of velocities in two frames.
    fn relative(&self, cell: usize, difference: Vector2<f64>) -> Vector2<f64>;
}

/// Cells that stand still: position of a disk relative to the corners of their columns, and of their rows.
pub(crate) struct Still(pub(crate) [[f64; 4]; 2]);

impl Frames for Still {
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

/// Cells of rows that slide.
pub(crate) struct Sliding {
    /// Position of a disk relative to the corners of cells, along the flow.
    pub(crate) x: [f64; 12],
    /// The same across it, by row.
    pub(crate) y: [f64; 4],
    /// Velocity of the own row less that of each.
    pub(crate) slip: [f64; 4],
}

impl Frames for Sliding {
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
