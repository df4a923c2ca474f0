//! Bounding boxes of the velocities of possible partners in a halo copy, by cell and by line of
//! cells: majorants of the approach speed.

use stosszahl_model::{ParticleModel, Space, VectorOf};

use super::HaloCopy;
use crate::cross_cell::extents::VelocityBox;
use crate::cross_cell::search_ranges::Ranges;
use crate::extrema::larger;

impl<P: ParticleModel> HaloCopy<P> {
    /// Computes the bounding box of the velocities in each cell of the halo copy, and counts
    /// simulators around cells to mark lines with sparse cells.
    #[inline(always)]
    pub(super) fn bound(&mut self) {
        let all = self.starts.len() - 1;
        self.extents.resize(all, VelocityBox::empty());
        // Particles of a cell are consecutive, so its box grows in registers; reading it back from
        // memory just after it was written would stall.
        let (mut extent, mut before) = (VelocityBox::empty(), u32::MAX);
        for (&cell, &velocity) in self.cells.iter().zip(&self.velocities) {
            extent.keep_if(cell == before);
            extent.note(velocity);
            self.extents[cell as usize] = extent;
            before = cell;
        }
        self.near.resize(all, 0);
        if self.is_narrow {
            // A particle may appear twice, so counts are unreliable: all lines are treated as
            // sparse.
            self.lonely.resize(self.sides[1] * self.sides[2], true);
            return;
        }
        // Sums along the first axis from differences of the cell starts, then line by line.
        let near = self.ranges.block();
        let width = 2 * near + 1;
        self.sums.clear();
        self.sums.resize(all, 0);
        for ((sum, low), high) in (self.sums[near..].iter_mut())
            .zip(&self.starts)
            .zip(&self.starts[width..])
        {
            *sum = high - low;
        }
        let [columns, rows, layers] = self.sides;
        let deep = near * usize::from(P::Space::DIMENSION > 2);
        self.lonely.resize(rows * layers, false);
        let inner = near..columns - near;
        for z in deep..layers - deep {
            for y in near..rows - near {
                let line = y + rows * z;
                let there = &mut self.near[columns * line..columns * (line + 1)];
                for layer in z - deep..=z + deep {
                    for row in y - near..=y + near {
                        let begin = columns * (row + rows * layer);
                        let sums = &self.sums[begin..begin + columns];
                        for (near, sum) in there.iter_mut().zip(sums) {
                            *near += sum;
                        }
                    }
                }
                let least = there[inner.clone()].iter().min();
                self.lonely[line] = least.is_none_or(|&near| near <= 1);
            }
        }
    }

    /// Computes the bounding box of the velocities of all possible partners, for each cell of one
    /// line of the tile.
    #[inline(always)]
    pub(in crate::cross_cell) fn bound_line(&mut self, [y, z]: [usize; 2]) {
        let columns = self.sides[0];
        let (y, z) = (y + self.margin[1], z + self.margin[2]);
        self.line = [y, z];
        let reach = self.ranges.reach();
        let is_deep = P::Space::DIMENSION > 2;
        if is_deep && self.slab_of != Some(z) {
            self.join_layers(z);
        }
        let begin = self.margin[0] - reach;
        let length = columns - 2 * begin;
        self.work.clear();
        self.work.resize(length, VelocityBox::empty());
        let layer = if is_deep { &self.slab } else { &self.extents };
        for row in y - reach..=y + reach {
            let first = begin + columns * row;
            for (one, other) in self.work.iter_mut().zip(&layer[first..first + length]) {
                one.join(other);
            }
        }
        self.bounds.clear();
        let inner = length - 2 * reach;
        self.bounds.extend_from_slice(&self.work[..inner]);
        for step in 1..=2 * reach {
            for (one, other) in self.bounds.iter_mut().zip(&self.work[step..step + inner]) {
                one.join(other);
            }
        }
        self.bound_far();
    }

    /// Joins the velocity boxes of the layers of cells around the layer `z`, column by column, in
    /// three dimensions.
    #[inline(always)]
    fn join_layers(&mut self, z: usize) {
        let reach = self.ranges.reach();
        let cells = self.sides[0] * self.sides[1];
        self.slab.clear();
        self.slab.resize(cells, VelocityBox::empty());
        for layer in z - reach..=z + reach {
            let layer = &self.extents[cells * layer..cells * (layer + 1)];
            for (one, other) in self.slab.iter_mut().zip(layer) {
                one.join(other);
            }
        }
        self.slab_of = Some(z);
    }

    /// Widens the velocity bounds of cells where a partner search may find no partner in the first
    /// block and continue farther away.
    fn bound_far(&mut self) {
        let [y, z] = self.line;
        let [columns, rows, _] = self.sides;
        let Ranges {
            point, far, shift, ..
        } = self.ranges;
        if far <= self.ranges.near {
            return;
        }
        let lines = |cells: usize| {
            let deep = cells * usize::from(P::Space::DIMENSION > 2);
            (z - deep..=z + deep)
                .flat_map(move |layer| (y - cells..=y + cells).map(move |row| row + rows * layer))
        };
        if !lines(point).any(|line| self.lonely[line]) {
            return;
        }
        // Whether a block in each column of cells around may be empty, from the first column that
        // counts.
        let begin = self.margin[0] - point;
        let length = self.bounds.len() + 2 * point;
        self.places.clear();
        self.places.resize(length, false);
        for line in lines(point) {
            let first = begin + columns * line;
            let near = &self.near[first..first + length];
            for (is_lonely, &near) in self.places.iter_mut().zip(near) {
                *is_lonely |= near <= 1;
            }
        }
        let far = point + far + shift;
        // Boxes of the columns around, computed only as far as needed: sparse places are adjacent.
        let begin = self.margin[0] - far;
        self.work.clear();
        self.work
            .resize(self.bounds.len() + 2 * far, VelocityBox::empty());
        let mut known = 0;
        for x in 0..self.bounds.len() {
            if !self.places[x..=x + 2 * point].contains(&true) {
                continue;
            }
            let end = x + 2 * far + 1;
            for line in lines(far) {
                let first = begin + columns * line;
                for column in known.max(x)..end {
                    self.work[column].join(&self.extents[first + column]);
                }
            }
            known = end;
            for one in &self.work[x..end] {
                self.bounds[x].join(one);
            }
        }
    }

    /// Returns true if no partner found around a point in a cell approaches along -k faster than
    /// `speed` \[length/time\]. False if the search may continue farther away.
    #[inline(always)]
    pub(in crate::cross_cell) fn is_slow(&self, cell: usize, k: VectorOf<P>, speed: f64) -> bool {
        if self.near[cell] <= 1 {
            return false;
        }
        // The common case, adjacent cells, is written out for speed.
        if self.ranges.block() == 1 {
            self.fastest(cell, k, 1) <= speed
        } else {
            self.fastest(cell, k, self.ranges.block()) <= speed
        }
    }

    /// Returns the largest speed along -k of simulators in cells within `near` cells of a cell
    /// \[length/time\].
    #[inline(always)]
    fn fastest(&self, cell: usize, k: VectorOf<P>, near: usize) -> f64 {
        let deep = near * usize::from(P::Space::DIMENSION > 2);
        let [_, column, layer] = self.strides();
        let first = cell - near * (1 + column) - deep * layer;
        let side = P::Space::from_components(|axis| k[axis].abs());
        let ends = [0, 1, 2].map(|axis| usize::from(axis < P::Space::DIMENSION && k[axis] < 0.0));
        let mut most = f64::NEG_INFINITY;
        for z in 0..=2 * deep {
            for y in 0..=2 * near {
                let begin = first + column * y + layer * z;
                // One maximum per line, so that comparisons do not all wait for each other.
                let mut line = f64::NEG_INFINITY;
                for one in &self.extents[begin..=begin + 2 * near] {
                    line = larger(line, one.against_signed(ends, side));
                }
                most = larger(most, line);
            }
        }
        most
    }
}
