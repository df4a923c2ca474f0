//! Reference frames of the cells around a disk: separations and relative velocities of disks in
//! different cells.

use nalgebra::{Vector2, vector};

/// Reference frames of the cells around a disk, for separations and relative velocities from it;
/// cells are given by their numbers in the walk.
pub(crate) trait CellFrames {
    /// Returns the separation vector \[length\] from a disk at `position` in the cell numbered
    /// `cell` to the central disk.
    fn separation(&self, cell: usize, position: Vector2<f64>) -> Vector2<f64>;

    /// Returns the relative velocity of the central disk and one in the cell numbered `cell`, from
    /// the difference of their velocities in their own frames.
    fn relative(&self, cell: usize, difference: Vector2<f64>) -> Vector2<f64>;
}

/// Frames of cells at rest: position of the central disk relative to the corners of the columns,
/// and of the rows, around it \[length\].
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

/// Frames of the cells around a disk in rows that slide with a shear flow.
pub(crate) struct Sliding {
    /// Position of the central disk along the flow, relative to the corners of the cells around it
    /// \[length\], by cell number.
    pub(crate) x: [f64; 12],
    /// Position of the central disk across the flow, relative to the lower edges of the rows around
    /// it \[length\], by row.
    pub(crate) y: [f64; 4],
    /// Velocity of the central disk's own row less the velocity of each row around it.
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
