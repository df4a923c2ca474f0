//! Halo copy: the simulators of a tile and of the cells around it, in contiguous memory.
//!
//! Partners of a tile's simulators may be in adjacent tiles and across periodic faces. All cells
//! within reach of a tile are therefore copied, with the first axis running fastest, one list for
//! each component of the positions, and periodic images where the tile sees them. A search then
//! runs through contiguous memory. Velocities are updated both here and in the tiles.

mod bounds;

use stosszahl_model::{ParticleModel, Sizes, Space, VectorOf};

use super::extents::VelocityBox;
use super::lanes::{BEYOND, CellRow, LANES};
use super::search_ranges::Ranges;
use super::search_target::{Aim, Block};
use super::tile_neighbourhood::{At, TileNeighbourhood};
use crate::extrema::{larger, smaller};
use crate::grid::{Grid, ROUNDER};
use crate::particle::DisplacementTracking;

/// Coordinate of particles masked in a search \[length\]: far away, but its square does not
/// overflow.
const NOWHERE: f64 = 1e150;

/// Value of `tile` for cells of the halo copy beyond a sliding edge: each of their particles has an
/// entry in `homes_of_sliding`.
const SLIDING: u32 = u32::MAX;

/// Halo copy: contiguous copy of the cells of a tile and around it, with positions, velocities,
/// sizes and velocity bounds of their simulators.
pub(crate) struct HaloCopy<P: ParticleModel> {
    ranges: Ranges,
    /// Lattice coordinates of the copy's first cell, counted in cells of the box; negative or
    /// beyond the box where the copy wraps.
    first: [i64; 3],
    /// Number of cells in the halo copy along each axis.
    sides: [usize; 3],
    /// Number of ghost cells on each side of the tile, along each axis.
    margin: [usize; 3],
    /// Number of cells of the whole box along each axis.
    counts: [i64; 3],
    /// True if the box is so narrow that a partner search may see the same simulator twice.
    is_narrow: bool,
    /// True if the halo copy may hold several periodic images of a simulator.
    has_images: bool,
    /// Inverse sides of a cell \[1/length\], to find the cell of a position.
    scale: VectorOf<P>,
    /// Index of the first simulator of each cell of the halo copy, and the total number at the end.
    starts: Vec<u32>,
    positions: [Vec<f64>; 3],
    pub(super) velocities: Vec<VectorOf<P>>,
    tags: Vec<<P::Sizes as Sizes>::Tag>,
    /// Radius minus mean radius of each simulator in the halo copy \[length\]; empty if sizes are
    /// equal or partners are not sought around points.
    excess: Vec<f64>,
    /// Smallest and largest radius minus mean radius of the simulators in the halo copy \[length\].
    spread: [f64; 2],
    /// Index of the cell in the halo copy of each simulator.
    cells: Vec<u32>,
    /// For each cell of the halo copy, the tile that owns its simulators, and the offset from an
    /// index in the copy to the index in that tile.
    homes: Vec<At>,
    /// Tile and index in it of each simulator beyond a sliding edge of a shear flow, where a cell
    /// of the copy holds simulators of several cells of the tile.
    homes_of_sliding: Vec<At>,
    /// Index in the halo copy of the next periodic image of each simulator, in a ring of all its
    /// images; empty if all have one image.
    next_images: Vec<u32>,
    /// Scratch memory for linking periodic images: index in the halo copy of the last image found
    /// of each simulator.
    last_images: Vec<u32>,
    /// Bounding box of the velocities in each cell of the halo copy.
    extents: Vec<VelocityBox<P::Space>>,
    /// Number of simulators in the block of cells around each cell that a partner search visits
    /// first.
    near: Vec<u32>,
    /// For each line of cells along the first axis: true if the search block around one of its
    /// cells has at most one simulator.
    lonely: Vec<bool>,
    sums: Vec<u32>,
    /// Bounding box of velocities for each column of cells of one layer, joined over the layers
    /// around it; only in three dimensions.
    slab: Vec<VelocityBox<P::Space>>,
    /// Layer of the halo copy for which `slab` was computed; `None` for none yet.
    slab_of: Option<usize>,
    /// Bounding box of the velocities of all possible partners, for each cell of the tile's current
    /// line of cells.
    pub(super) bounds: Vec<VelocityBox<P::Space>>,
    /// Row and layer in the halo copy of the tile's current line of cells.
    line: [usize; 2],
    /// Scratch memory for bounding boxes of velocities, one for each cell of a line.
    work: Vec<VelocityBox<P::Space>>,
    places: Vec<bool>,
}

impl<P: ParticleModel> Default for HaloCopy<P> {
    fn default() -> Self {
        Self {
            ranges: Ranges::default(),
            first: [0; 3],
            sides: [0; 3],
            margin: [0; 3],
            counts: [1; 3],
            is_narrow: false,
            has_images: false,
            scale: VectorOf::<P>::default(),
            starts: Vec::new(),
            positions: [const { Vec::new() }; 3],
            velocities: Vec::new(),
            tags: Vec::new(),
            excess: Vec::new(),
            spread: [0.0; 2],
            cells: Vec::new(),
            homes: Vec::new(),
            homes_of_sliding: Vec::new(),
            next_images: Vec::new(),
            last_images: Vec::new(),
            extents: Vec::new(),
            near: Vec::new(),
            lonely: Vec::new(),
            sums: Vec::new(),
            slab: Vec::new(),
            slab_of: None,
            bounds: Vec::new(),
            line: [0; 2],
            work: Vec::new(),
            places: Vec::new(),
        }
    }
}

impl<P: ParticleModel> HaloCopy<P> {
    /// Fills the halo copy with the cells of the central tile and around it. `moves` is true if
    /// candidate pairs are bounded by velocities; the last argument holds the sizes and their mean
    /// radius.
    #[inline(always)]
    pub(super) fn fill<F: DisplacementTracking<P::Space>>(
        &mut self,
        around: &TileNeighbourhood<'_, '_, P, F>,
        grid: &Grid<P::Space>,
        ranges: Ranges,
        moves: bool,
        (sizes, mean_radius): (&P::Sizes, f64),
    ) {
        let place = &around.home().place;
        let is_used = |axis: usize| usize::from(axis < P::Space::DIMENSION);
        self.ranges = ranges;
        self.margin = [0, 1, 2].map(|axis| ranges.margin() * is_used(axis));
        self.counts = grid.counts().map(i64::from);
        self.first = [0, 1, 2].map(|axis| i64::from(place.first[axis]) - self.margin[axis] as i64);
        self.sides = [0, 1, 2].map(|axis| place.sides[axis] as usize + 2 * self.margin[axis]);
        let within = 2 * (ranges.point + ranges.block()) as i64 + 1;
        self.is_narrow = (0..P::Space::DIMENSION)
            .any(|axis| grid.domain().is_periodic(axis) && self.counts[axis] < within);
        self.has_images =
            (0..P::Space::DIMENSION).any(|axis| self.counts[axis] < self.sides[axis] as i64);
        self.scale = P::Space::from_components(|axis| 1.0 / grid.width()[axis]);
        self.clear();
        for z in 0..self.sides[2] {
            for y in 0..self.sides[1] {
                self.fill_line(around, grid, [y, z]);
            }
        }
        self.starts.push(self.velocities.len() as u32);
        if self.has_images {
            self.link_images(around);
        }
        for list in &mut self.positions[..P::Space::DIMENSION] {
            list.resize(list.len() + LANES, NOWHERE);
        }
        if ranges.shift > 0 {
            let excess = |&tag: &_| sizes.radius(tag) - mean_radius;
            self.excess.extend(self.tags.iter().map(excess));
            let ends = self
                .excess
                .iter()
                .fold([0.0, 0.0], |[least, most], &excess| {
                    [smaller(least, excess), larger(most, excess)]
                });
            self.spread = ends;
            self.excess.resize(self.tags.len() + LANES, 0.0);
        }
        if moves {
            self.bound();
        }
    }

    fn clear(&mut self) {
        self.starts.clear();
        self.positions.iter_mut().for_each(Vec::clear);
        self.velocities.clear();
        self.tags.clear();
        self.excess.clear();
        self.homes.clear();
        self.homes_of_sliding.clear();
        self.next_images.clear();
        self.cells.clear();
        self.extents.clear();
        self.near.clear();
        self.lonely.clear();
        self.slab_of = None;
    }

    /// Copies one line of cells along the first axis into the halo copy; `y` and `z` are its row
    /// and layer in the copy.
    #[inline(always)]
    fn fill_line<F: DisplacementTracking<P::Space>>(
        &mut self,
        around: &TileNeighbourhood<'_, '_, P, F>,
        grid: &Grid<P::Space>,
        [y, z]: [usize; 2],
    ) {
        let images = grid.domain().images();
        // Coordinate of the cell inside the box, and the number of boxes to its image.
        let (first, counts) = (self.first, self.counts);
        let seen = |axis: usize, at: usize| {
            let (there, count) = (first[axis] + at as i64, counts[axis]);
            let boxes = there.div_euclid(count);
            let is_here =
                boxes == 0 || (axis < P::Space::DIMENSION && grid.domain().is_periodic(axis));
            is_here.then(|| ((there - boxes * count) as u32, boxes as f64))
        };
        let (row, layer) = (seen(1, y), seen(2, z));
        if let (Some(row), Some(layer), Some(_)) = (row, layer, images.shear())
            && row.1 != 0.0
        {
            self.fill_sliding_line(around, grid, [row, layer]);
            return;
        }
        let mut x = 0;
        while x < self.sides[0] {
            let begin = self.velocities.len() as u32;
            let (Some(column), Some(row), Some(layer)) = (seen(0, x), row, layer) else {
                self.leave_out(begin, 1);
                x += 1;
                continue;
            };
            let there = [column, row, layer];
            let cell = there.map(|one| one.0);
            let Some((slot, local)) = around.find(cell) else {
                self.leave_out(begin, 1);
                x += 1;
                continue;
            };
            let tile = around.tile(slot);
            let left = (tile.place.first[0] + tile.place.sides[0] - cell[0]) as usize;
            let length = left.min(self.sides[0] - x);
            if tile.starts.is_empty() {
                self.leave_out(begin, length);
                x += length;
                continue;
            }
            let starts = &tile.starts[local..=local + length];
            let source = starts[0] as usize..starts[length] as usize;
            let shift = images.image(there.map(|one| one.1)).position;
            let members = &tile.simulators[source];
            for axis in 0..P::Space::DIMENSION {
                self.positions[axis].extend(
                    members
                        .iter()
                        .map(|member| member.position[axis] + shift[axis]),
                );
            }
            self.velocities
                .extend(members.iter().map(|member| member.velocity));
            self.tags.extend(members.iter().map(|member| member.tag));
            let first = self.starts.len() as u32;
            self.cells.extend(members.iter().map(|member| {
                let column = grid.column(0, member.position[0]);
                first + (column - cell[0])
            }));
            let index = starts[0].wrapping_sub(begin);
            self.starts.extend(
                starts[..length]
                    .iter()
                    .map(|&start| start.wrapping_sub(index)),
            );
            let home = At { tile: slot, index };
            self.homes.resize(self.starts.len(), home);
            x += length;
        }
    }

    /// Copies one line of cells beyond an edge along which boxes slide in a shear flow. Its columns
    /// are displaced from those of the tiles by part of a cell, so each simulator is sorted anew.
    /// `row` and `layer` are coordinates inside the box, with the number of boxes to the image.
    fn fill_sliding_line<F: DisplacementTracking<P::Space>>(
        &mut self,
        around: &TileNeighbourhood<'_, '_, P, F>,
        grid: &Grid<P::Space>,
        [row, layer]: [(u32, f64); 2],
    ) {
        let images = grid.domain().images();
        let shift = images.image([0.0, row.1, layer.1]).position[0];
        let columns = self.counts[0];
        for x in 0..self.sides[0] as i64 {
            let seen = self.first[0] + x;
            self.starts.push(self.velocities.len() as u32);
            let index = self.homes_of_sliding.len() as u32;
            self.homes.push(At {
                tile: SLIDING,
                index: index.wrapping_sub(self.velocities.len() as u32),
            });
            let cell = self.starts.len() as u32 - 1;
            // Two columns overlap with this one; a coordinate at an edge may be rounded to either
            // side.
            let middle = fast_floor(seen as f64 - shift * self.scale[0]);
            for column in middle - 1..=middle + 2 {
                let boxes = column.div_euclid(columns);
                let there = [(column - boxes * columns) as u32, row.0, layer.0];
                let Some((tile, local)) = around.find(there) else {
                    continue;
                };
                let shift = images.image([boxes as f64, row.1, layer.1]).position;
                let source = around.tile(tile);
                for index in source.starts[local]..source.starts[local + 1] {
                    let member = &source.simulators[index as usize];
                    let position = member.position + shift;
                    if fast_floor(position[0] * self.scale[0]) != seen {
                        continue;
                    }
                    for axis in 0..P::Space::DIMENSION {
                        self.positions[axis].push(position[axis]);
                    }
                    self.velocities.push(member.velocity);
                    self.tags.push(member.tag);
                    self.cells.push(cell);
                    self.homes_of_sliding.push(At { tile, index });
                }
            }
        }
    }

    /// Links all periodic images of each simulator in the halo copy in a ring.
    fn link_images<F: DisplacementTracking<P::Space>>(
        &mut self,
        around: &TileNeighbourhood<'_, '_, P, F>,
    ) {
        let mut all = 0;
        let firsts: Vec<usize> = (around.lengths())
            .map(|length| {
                all += length;
                all - length
            })
            .collect();
        self.last_images.clear();
        self.last_images.resize(all, u32::MAX);
        for index in 0..self.velocities.len() {
            let home = self.home(index);
            let last = &mut self.last_images[firsts[home.tile as usize] + home.index as usize];
            let next = match *last {
                u32::MAX => index as u32,
                last => std::mem::replace(&mut self.next_images[last as usize], index as u32),
            };
            self.next_images.push(next);
            *last = index as u32;
        }
    }

    /// Adds empty cells to the halo copy: cells outside the box, or not held by this process.
    fn leave_out(&mut self, begin: u32, cells: usize) {
        let all = self.starts.len() + cells;
        self.starts.resize(all, begin);
        self.homes.resize(all, At { tile: 0, index: 0 });
    }

    /// Returns the index in the halo copy of the cell that contains a point, which may be outside
    /// the box.
    #[inline(always)]
    pub(super) fn cell_of(&self, point: VectorOf<P>) -> usize {
        let mut cell = 0;
        for axis in (0..P::Space::DIMENSION).rev() {
            let at = fast_floor(point[axis] * self.scale[axis]) - self.first[axis];
            cell = cell * self.sides[axis] + at as usize;
        }
        cell
    }

    /// Returns the smallest block of cells of the halo copy that contains all partners within
    /// `radius` of their target points, at most `cells` on each side of the aim.
    #[inline(always)]
    pub(super) fn block_within(&self, aim: Aim<VectorOf<P>>, radius: f64, cells: usize) -> Block {
        // Slightly more, so that rounding of a coordinate at the edge of a cell has no effect.
        let radius = radius * (1.0 + 1e-9);
        let (mut first, mut sides) = (0, [1; 3]);
        for axis in (0..P::Space::DIMENSION).rev() {
            let ends = self
                .spread
                .map(|excess| aim.point[axis] + aim.along[axis] * excess);
            let at = |x: f64| fast_floor(x * self.scale[axis]) - self.first[axis];
            // Between walls the radius may be far wider than the box.
            let (middle, cells) = (at(aim.point[axis]), cells as i64);
            let low = at(smaller(ends[0], ends[1]) - radius).max(middle - cells);
            let high = at(larger(ends[0], ends[1]) + radius).min(middle + cells);
            first = first * self.sides[axis] + low as usize;
            sides[axis] = (high - low) as usize + 1;
        }
        Block { first, sides }
    }

    /// Returns the offset from a cell of the tile to the cell that contains a point, in cells along
    /// each axis.
    #[inline(always)]
    pub(super) fn steps_to(&self, cell: [u32; 3], point: VectorOf<P>) -> [i64; 3] {
        [0, 1, 2].map(|axis| {
            if axis < P::Space::DIMENSION {
                fast_floor(point[axis] * self.scale[axis]) - i64::from(cell[axis])
            } else {
                0
            }
        })
    }

    /// Returns the index in the halo copy of a cell of the central tile, given its column, row and
    /// layer in the tile.
    #[inline(always)]
    pub(super) fn own_cell(&self, at: [usize; 3]) -> usize {
        let [x, y, z] = [0, 1, 2].map(|axis| at[axis] + self.margin[axis]);
        x + self.sides[0] * (y + self.sides[1] * z)
    }

    /// Returns the index in the halo copy of the cell that contains a simulator.
    pub(super) fn cell_of_member(&self, index: usize) -> usize {
        self.cells[index] as usize
    }

    /// Returns the index of the cell of the halo copy at an offset of -1, 0 or 1 along each axis
    /// from another.
    pub(super) fn step_from(&self, cell: usize, step: [i32; 3]) -> usize {
        let strides = self.strides();
        let by = |axis: usize| strides[axis] as isize * step[axis] as isize;
        cell.wrapping_add_signed(by(0) + by(1) + by(2))
    }

    /// Returns the index range of the simulators in `length` adjacent cells of the halo copy, from
    /// `cell` on along the first axis.
    #[inline(always)]
    pub(super) fn members(&self, cell: usize, length: usize) -> std::ops::Range<usize> {
        self.starts[cell] as usize..self.starts[cell + length] as usize
    }

    /// Returns the largest number of simulators in any single cell within `cells` cells of a cell.
    #[inline(always)]
    pub(super) fn crowd(&self, cell: usize, cells: usize) -> u32 {
        let deep = cells * usize::from(P::Space::DIMENSION > 2);
        let [_, column, layer] = self.strides();
        let mut most = 0;
        for z in 0..=2 * deep {
            for y in 0..=2 * cells {
                let first = cell + column * y + layer * z - cells * (1 + column) - deep * layer;
                for ends in self.starts[first..=first + 2 * cells + 1].windows(2) {
                    most = most.max(ends[1] - ends[0]);
                }
            }
        }
        most
    }

    /// Returns the position of a simulator in the halo copy, as seen from the tile \[length\].
    #[inline(always)]
    pub(super) fn position(&self, index: usize) -> VectorOf<P> {
        P::Space::from_components(|axis| self.positions[axis][index])
    }

    /// Returns the tile and the index in it of a simulator in the halo copy.
    #[inline(always)]
    pub(super) fn home(&self, index: usize) -> At {
        let home = self.homes[self.cells[index] as usize];
        let there = home.index.wrapping_add(index as u32);
        if home.tile == SLIDING {
            return self.homes_of_sliding[there as usize];
        }
        At {
            tile: home.tile,
            index: there,
        }
    }

    /// Returns the tag by which radius and mass of a simulator in the halo copy are found.
    #[inline(always)]
    pub(super) fn tag(&self, index: usize) -> <P::Sizes as Sizes>::Tag {
        self.tags[index]
    }

    /// Returns the radius minus the mean radius of a simulator in the halo copy \[length\]; `None`
    /// where it does not shift the target point.
    #[inline(always)]
    pub(super) fn excess(&self, index: usize) -> Option<f64> {
        self.excess.get(index).copied()
    }

    /// Returns true if partners of all sizes are sought at the same target point.
    #[inline(always)]
    pub(super) fn is_plain(&self) -> bool {
        P::Sizes::UNIFORM || self.excess.is_empty()
    }

    /// Returns the simulators of three adjacent cells in two dimensions: index of the first, and
    /// positions. `line` is 0 for the line of cells below `cell`, 1 for its own, 2 for the one
    /// above.
    #[inline(always)]
    pub(super) fn run(&self, cell: usize, line: usize) -> (usize, CellRow<'_>) {
        let columns = self.sides[0];
        let members = self.members(cell + columns * line - columns - 1, 3);
        let positions = [0, 1].map(|axis| {
            let all = &self.positions[axis][members.start..members.start + LANES];
            all.first_chunk().unwrap_or(&[NOWHERE; LANES])
        });
        let count = members.len();
        (members.start, CellRow { positions, count })
    }

    /// Returns the squared distances of [`LANES`] consecutive simulators from their target points
    /// \[length^2\]; a large number from index `end` on.
    #[inline(always)]
    pub(super) fn squares(&self, aim: Aim<VectorOf<P>>, begin: usize, end: usize) -> [f64; LANES] {
        let mut squares = [0.0; LANES];
        for axis in 0..P::Space::DIMENSION {
            let lanes = &self.positions[axis][begin..begin + LANES];
            let mut points = [aim.point[axis]; LANES];
            if !self.is_plain() {
                let excess = &self.excess[begin..begin + LANES];
                for lane in 0..LANES {
                    points[lane] += aim.along[axis] * excess[lane];
                }
            }
            for lane in 0..LANES {
                let apart = lanes[lane] - points[lane];
                squares[lane] += apart * apart;
            }
        }
        let left = (end - begin).min(LANES);
        let beyond = &BEYOND[LANES - left..2 * LANES - left];
        for lane in 0..LANES {
            squares[lane] = larger(squares[lane], beyond[lane]);
        }
        squares
    }

    /// Masks a simulator, so that a partner search does not find it. Returns the coordinate that
    /// [`Self::show`] restores.
    #[inline(always)]
    pub(super) fn hide(&mut self, index: usize) -> f64 {
        std::mem::replace(&mut self.positions[0][index], NOWHERE)
    }

    /// Restores a simulator masked by [`Self::hide`], so that partner searches find it again.
    #[inline(always)]
    pub(super) fn show(&mut self, index: usize, hidden: f64) {
        self.positions[0][index] = hidden;
    }

    /// Returns true if the box is so narrow that a partner search may see one simulator twice.
    #[inline(always)]
    pub(super) fn is_narrow(&self) -> bool {
        self.is_narrow
    }

    /// Sets a simulator's velocity in the halo copy, in all its periodic images, and widens the
    /// velocity bounds if `moves`.
    #[inline(always)]
    pub(super) fn set(&mut self, index: usize, velocity: VectorOf<P>, moves: bool) {
        self.set_at(self.cells[index], index, velocity, moves);
        if !self.has_images {
            return;
        }
        let mut image = self.next_images[index] as usize;
        while image != index {
            self.set_at(self.cells[image], image, velocity, moves);
            image = self.next_images[image] as usize;
        }
    }

    #[inline(always)]
    fn set_at(&mut self, cell: u32, index: usize, velocity: VectorOf<P>, moves: bool) {
        self.velocities[index] = velocity;
        if !moves {
            return;
        }
        self.extents[cell as usize].note(velocity);
        let columns = self.sides[0] as u32;
        let (line, x) = ((cell / columns) as usize, (cell % columns) as usize);
        let [y, z] = if P::Space::DIMENSION == 2 {
            [line, 0]
        } else {
            [line % self.sides[1], line / self.sides[1]]
        };
        let reach = self.ranges.reach();
        if P::Space::DIMENSION > 2 && self.slab_of.is_some_and(|layer| z.abs_diff(layer) <= reach) {
            self.slab[x + self.sides[0] * y].note(velocity);
        }
        if y.abs_diff(self.line[0]) <= reach && z.abs_diff(self.line[1]) <= reach {
            let all = self.bounds.len();
            let from = x.saturating_sub(self.margin[0] + reach).min(all);
            let to = (x + reach + 1).saturating_sub(self.margin[0]).min(all);
            for bound in &mut self.bounds[from..to] {
                bound.note(velocity);
            }
        }
    }

    pub(crate) fn bytes(&self) -> usize {
        let positions: usize = self.positions.iter().map(Vec::capacity).sum();
        let extents = self.extents.capacity()
            + self.slab.capacity()
            + self.bounds.capacity()
            + self.work.capacity();
        8 * (positions + self.excess.capacity())
            + 4 * (self.starts.capacity()
                + self.cells.capacity()
                + self.near.capacity()
                + self.sums.capacity())
            + 4 * (self.next_images.capacity() + self.last_images.capacity())
            + self.lonely.capacity()
            + self.places.capacity()
            + size_of::<VectorOf<P>>() * self.velocities.capacity()
            + size_of::<<P::Sizes as Sizes>::Tag>() * self.tags.capacity()
            + size_of::<At>() * (self.homes.capacity() + self.homes_of_sliding.capacity())
            + size_of::<VelocityBox<P::Space>>() * extents
    }

    /// Returns the differences of the cell index in the halo copy for one step along each axis.
    #[inline(always)]
    pub(super) fn strides(&self) -> [usize; 3] {
        [1, self.sides[0], self.sides[0] * self.sides[1]]
    }
}

/// Returns the floor of a small number `x` quickly, by a rounding constant; for a whole number,
/// possibly one less.
#[inline(always)]
fn fast_floor(x: f64) -> i64 {
    i64::from(((x - 0.5) + ROUNDER).to_bits() as i32)
}
