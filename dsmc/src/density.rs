//! Local packing fraction in a window of cells around each cell, and the contact value chi by which
//! density raises the collision rate.

mod windows;

use std::cmp::Ordering;

use stosszahl_model::Space;
use stosszahl_model::threads::each_of;

use crate::extrema::larger;
use crate::scheme::{DensityWindow, Neighbourhood, PartnerSelection, Scheme};

pub(crate) use windows::{CellLayers, CutWindow, CutWindows, WindowCentre, WindowMember};

/// Number of lines of cells whose window sums one thread computes in turn.
const BLOCK: usize = 16;

/// Weights of the cells in the window of the local packing fraction: equal or triangular.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum DensityKernel {
    /// Top-hat window: equal weights of all cells.
    Flat,
    /// Triangular window: weight n + 1 - j at a distance of j cells along each axis, of n on each
    /// side. Its Fourier transform is nowhere negative, so a dense gas does not form waves as short
    /// as the window.
    Triangle,
}

impl DensityKernel {
    /// Returns the weight of a cell in the window along one axis, `away` cells from the centre, for
    /// the half width `reach` \[cells\].
    #[inline(always)]
    fn along(self, reach: usize, away: usize) -> usize {
        match self {
            Self::Flat => 1,
            Self::Triangle => reach + 1 - away,
        }
    }
}

/// Largest number of entries in the table of contact values chi; in windows with more particles,
/// chi is computed each time.
const LARGEST_TABLE: u32 = 1 << 14;

/// Local packing fraction and contact value chi of each cell, from the area or volume that
/// particles cover in its window of cells.
pub(crate) struct Density<S: Space> {
    scheme: Scheme,
    limit: f64,
    /// Contact value chi by the number of units in the window, where a unit is the area or volume
    /// of a largest particle. For equal particles this is a whole number, so chi is looked up.
    table: Vec<f64>,
    /// Packing fraction that one unit, the area or volume of a largest particle, contributes to a
    /// window.
    unit: f64,
    /// Half width of the density window along each axis \[cells\]; 0 for a single cell.
    reach: [usize; 3],
    weighing: DensityKernel,
    mean: Option<f64>,
    mean_packing: f64,
    counts: [usize; 3],
    /// Area or volume of particles, in units of a largest particle, in the part of the density
    /// window along the first axis, for each cell; whole numbers up to 2^24 are exact. Empty for
    /// single-cell windows.
    lines: Vec<f32>,
    /// Area or volume that particles cover in the whole density window of each cell, in units of a
    /// largest particle.
    sums: Vec<f32>,
    /// True for each axis along which the box is not periodic, so that density windows end at its
    /// faces.
    bounded: [bool; 3],
    /// Displacement of the periodic image above in a shear flow, in whole columns of cells.
    offset: usize,
    /// Factors for the volume that boundaries take from the density window of each cell; empty
    /// without boundaries.
    crowding: Vec<FreeVolumeFactors>,
    /// Density windows cut by obstacles; `None` without obstacles.
    cut_windows: Option<CutWindows>,
    space: std::marker::PhantomData<S>,
}

/// Free-volume factors: how much denser boundaries make a density window than its number of
/// particles says.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct FreeVolumeFactors {
    /// Volume of the density window over the part that particle bodies can cover, for packing
    /// fractions.
    pub(crate) bodies: f64,
    /// Volume that particle bodies can cover over the volume open to their centres, for number
    /// densities.
    pub(crate) centres: f64,
}

impl FreeVolumeFactors {
    /// Free-volume factors of a window without boundaries: all one.
    pub(crate) const NONE: Self = Self {
        bodies: 1.0,
        centres: 1.0,
    };
}

/// Properties of gas and grid from which the local density, [`Density::new`], is set up.
pub(crate) struct DensityInput {
    /// Upper limit of the contact value chi.
    pub(crate) limit: f64,
    /// Number of cells of the box along each axis.
    pub(crate) counts: [u32; 3],
    /// Area or volume of a cell of the grid \[length^D\].
    pub(crate) cell: f64,
    /// Least side of a cell of the grid \[length\].
    pub(crate) width: f64,
    /// Mean particle diameter \[length\].
    pub(crate) diameter: f64,
    pub(crate) simulators_per_particle: f64,
    /// Unit in which covered area or volume is counted: that of the largest particle times
    /// particles per simulator \[length^D\].
    pub(crate) unit: f64,
    /// Packing fraction of the whole box.
    pub(crate) packing_fraction: f64,
    /// True for each axis along which the box is not periodic.
    pub(crate) bounded: [bool; 3],
    /// True if all particles are equal and the box has no boundaries.
    pub(crate) is_plain: bool,
}

/// Returns half width \[cells\] and weights of a scheme's density window; `None` for the mean of
/// the whole box, or where density does not matter.
fn density_window(
    scheme: Scheme,
    gas: &DensityInput,
    dimension: usize,
) -> Option<(u32, DensityKernel)> {
    let (cell, diameter) = (gas.width, gas.diameter);
    let reach = match scheme.properties().window {
        _ if scheme.is_dilute() => return None,
        DensityWindow::Fixed(Neighbourhood::Mean) => return None,
        DensityWindow::Fixed(Neighbourhood::Cells(n)) => n,
        // Ten diameters around one simulator per particle; fewer for many simulators, which are
        // less noisy.
        DensityWindow::Adaptive => {
            let shrunk = 10.0 / gas.simulators_per_particle.powf(1.0 / dimension as f64);
            // Three dimensions were not measured.
            let is_known = dimension == 2 && gas.is_plain && !gas.bounded[..2].contains(&true);
            if shrunk < 3.0 && is_known && cell < diameter {
                let half = (diameter / cell).ceil().min(50.0);
                return Some((half as u32 - 1, DensityKernel::Triangle));
            }
            let side = shrunk.max(3.0) * diameter;
            ((0.5 * (side / cell - 1.0)).ceil().max(0.0) as u32).min(50)
        }
    };
    Some((reach, DensityKernel::Flat))
}

impl<S: Space> Density<S> {
    pub(crate) fn new(scheme: Scheme, gas: &DensityInput) -> Self {
        let counts = gas.counts.map(|count| count as usize);
        let wanted = density_window(scheme, gas, S::DIMENSION);
        let (cells, mut weighing) = wanted.unwrap_or((0, DensityKernel::Flat));
        let reach = [0, 1, 2].map(|axis| {
            let wanted = if axis < S::DIMENSION {
                cells as usize
            } else {
                0
            };
            // A window around the whole box would count particles twice; at walls it ends.
            wanted.min(if gas.bounded[axis] {
                counts[axis] - 1
            } else {
                (counts[axis] - 1) / 2
            })
        });
        // In so narrow a box all cells have the same weight.
        if reach[..S::DIMENSION]
            .iter()
            .any(|&reach| reach < cells as usize)
        {
            weighing = DensityKernel::Flat;
        }
        let mean = wanted
            .is_none()
            .then(|| scheme.contact_value::<S>(gas.packing_fraction));
        let unit = gas.unit / (gas.cell * sum_of_weights(weighing, reach));
        let table = if mean.is_some() { 0 } else { LARGEST_TABLE };
        let table = (0..table)
            .map(|count| scheme.contact_value::<S>(f64::from(count) * unit))
            .take_while(|&chi| chi < gas.limit)
            .collect();
        let mean_packing = if scheme.is_dilute() {
            0.0
        } else {
            gas.packing_fraction
        };
        let cells = match reach {
            [0, 0, 0] => 0,
            _ => counts.iter().product(),
        };
        Self {
            scheme,
            limit: gas.limit,
            table,
            unit,
            reach,
            weighing,
            mean,
            mean_packing,
            counts,
            lines: vec![0.0; cells],
            sums: vec![0.0; cells],
            bounded: gas.bounded,
            offset: 0,
            crowding: Vec::new(),
            cut_windows: None,
            space: std::marker::PhantomData,
        }
    }

    /// Sets the displacement of the periodic images above and below in a shear flow, in whole
    /// columns of cells.
    pub(crate) fn slide(&mut self, columns: usize) {
        self.offset = columns % self.counts[0];
    }

    /// Sets the density windows that obstacles cut; `None` without obstacles.
    pub(crate) fn cut(&mut self, windows: Option<CutWindows>) {
        self.cut_windows = windows;
    }

    /// Returns true for each axis along which density windows end at the faces of the box.
    pub(crate) fn bounded(&self) -> [bool; 3] {
        self.bounded
    }

    /// Sets the fractions of each cell that are open to particle centres and to particle bodies;
    /// packing fractions use the latter.
    pub(crate) fn set_room(
        &mut self,
        centres: impl Fn([u32; 3]) -> f64 + Sync,
        bodies: impl Fn([u32; 3]) -> f64 + Sync,
    ) {
        let centres = self.rooms_around(centres);
        let bodies = self.rooms_around(bodies);
        let cells = self.cells_around();
        // The fractions are summed in single precision.
        let whole = |factor: f64| if factor > 1.0 + 1e-5 { factor } else { 1.0 };
        let crowding = centres
            .iter()
            .zip(&bodies)
            .map(|(centres, bodies)| FreeVolumeFactors {
                bodies: whole(cells / bodies),
                centres: whole(bodies / centres),
            });
        self.crowding = crowding.collect();
        if self
            .crowding
            .iter()
            .all(|one| *one == FreeVolumeFactors::NONE)
        {
            self.crowding = Vec::new();
        }
    }

    /// Sets the free area of the windows that obstacles cut \[cells\]; call after
    /// [`Density::set_room`].
    pub(crate) fn set_room_in_windows(&mut self, mut room: impl FnMut(WindowMember, u32) -> f64) {
        let Some(windows) = &mut self.cut_windows else {
            return;
        };
        windows.set_rooms(&mut room);
        if self.crowding.is_empty() {
            self.crowding = vec![FreeVolumeFactors::NONE; self.counts.iter().product()];
        }
        let [columns, rows, _] = self.counts;
        let cells = sum_of_weights(self.weighing, self.reach);
        for ([x, y, z], _, room) in windows.cells() {
            let cell = x as usize + columns * (y as usize + rows * z as usize);
            self.crowding[cell].bodies = if room > 0.0 { cells / room } else { 1.0 };
        }
    }

    /// Sets the area that particles cover in the windows that obstacles cut, in units of a largest
    /// particle; call after [`Density::update`].
    pub(crate) fn update_windows(&mut self, mut units: impl FnMut(WindowMember, u32) -> f64) {
        let Some(windows) = &mut self.cut_windows else {
            return;
        };
        windows.set_units(&mut units);
        let [columns, rows, _] = self.counts;
        for ([x, y, z], units, _) in windows.cells() {
            self.sums[x as usize + columns * (y as usize + rows * z as usize)] = units as f32;
        }
    }

    /// Returns the free volume in the density window of each cell \[cells\], from the free fraction
    /// `room` of each cell.
    fn rooms_around(&mut self, room: impl Fn([u32; 3]) -> f64 + Sync) -> Vec<f64> {
        let [columns, rows, layers] = self.counts;
        let at = |x: usize, line: usize| [x as u32, (line % rows) as u32, (line / rows) as u32];
        if self.looks_around() {
            self.update(false, &|line, values| {
                for (x, value) in values.iter_mut().enumerate() {
                    *value = room(at(x, line)) as f32;
                }
            });
        }
        let cells = (0..rows * layers).flat_map(|line| (0..columns).map(move |x| at(x, line)));
        cells.map(|cell| self.around(cell, room(cell))).collect()
    }

    /// Returns true if chi of a cell depends on other cells, so that all cells must be sorted
    /// before any pair collides.
    pub(crate) fn looks_around(&self) -> bool {
        self.reach != [0; 3]
    }

    /// Returns the half width of the density window along each axis \[cells\].
    pub(crate) fn reach(&self) -> [usize; 3] {
        self.reach
    }

    /// Returns the sum of the cell weights in a density window: for equal weights its number of
    /// cells.
    pub(crate) fn cells_around(&self) -> f64 {
        sum_of_weights(self.weighing, self.reach)
    }

    /// Returns the mean of the cell weights w in a density window, weighted by w: sum of w^2 over
    /// sum of w.
    pub(crate) fn mean_weight(&self) -> f64 {
        let along = |reach: usize| match self.weighing {
            DensityKernel::Flat => 1.0,
            // The sum of the squares of 1, ..., n, ..., 1 is n(2 n^2 + 1)/3; the sum is n^2.
            DensityKernel::Triangle => {
                let half = (reach + 1) as f64;
                (2.0 * half * half + 1.0) / (3.0 * half)
            }
        };
        self.reach.map(along).iter().product()
    }

    /// Returns the kind of cell weights in the density window: equal or triangular.
    pub(crate) fn weighing(&self) -> DensityKernel {
        self.weighing
    }

    /// Returns the weight of a cell in the density window, `away` cells from its centre along each
    /// axis.
    #[inline(always)]
    pub(crate) fn share_of(&self, away: [usize; 3]) -> f64 {
        let along = |axis: usize| self.weighing.along(self.reach[axis], away[axis]);
        (along(0) * along(1) * along(2)) as f64
    }

    /// Returns the collision scheme of the gas.
    pub(crate) fn scheme(&self) -> Scheme {
        self.scheme
    }

    /// Returns the packing fraction that one unit, the area or volume of a largest particle,
    /// contributes to a window.
    pub(crate) fn unit(&self) -> f64 {
        self.unit
    }

    /// Returns true unless the scheme is that of free molecular flow, without collisions.
    pub(crate) fn collides(&self) -> bool {
        self.scheme.partners() != PartnerSelection::None
    }

    /// Recomputes the area or volume that particles cover in the density windows of all cells, in
    /// units of a largest particle. `fill` writes that of each cell in one line of cells along the
    /// first axis, given the number of the line.
    pub(crate) fn update(&mut self, parallel: bool, fill: &(dyn Fn(usize, &mut [f32]) + Sync)) {
        let (columns, reach, bounded) = (self.counts[0], self.reach[0], self.bounded[0]);
        let weighing = self.weighing;
        let line = |padded: &mut Vec<f32>, number: usize, sums: &mut [f32]| {
            padded.resize(columns + 2 * reach, 0.0);
            fill(number, &mut padded[reach..reach + columns]);
            if !bounded {
                padded.copy_within(columns..columns + reach, 0);
                padded.copy_within(reach..2 * reach, reach + columns);
            }
            sums.fill(0.0);
            for shift in 0..=2 * reach {
                let counts = weighing.along(reach, shift.abs_diff(reach)) as f32;
                for (sum, &value) in sums.iter_mut().zip(&padded[shift..]) {
                    *sum += counts * value;
                }
            }
        };
        let blocks = self.lines.chunks_mut(BLOCK * columns);
        each_of(parallel, blocks, |block, lines| {
            let mut padded = Vec::new();
            for (number, sums) in lines.chunks_mut(columns).enumerate() {
                line(&mut padded, BLOCK * block + number, sums);
            }
        });
        self.add_lines(parallel);
    }

    /// Adds up lines of cells to density windows, along the second and third axis.
    fn add_lines(&mut self, parallel: bool) {
        let [columns, rows, layers] = self.counts;
        let [_, reach, depth] = self.reach;
        let (lines, bounded, weighing) = (&self.lines, self.bounded, self.weighing);
        let offset = self.offset;
        let add = |line: usize, sums: &mut [f32]| {
            let (row, layer) = (line % rows, line / rows);
            sums.fill(0.0);
            for z in 0..=2 * depth {
                if bounded[2] && is_outside(layer + z, depth, layers) {
                    continue;
                }
                let deep = weighing.along(depth, z.abs_diff(depth));
                let layer = wrapped_index(layer + z, depth, layers);
                for y in 0..=2 * reach {
                    if bounded[1] && is_outside(row + y, reach, rows) {
                        continue;
                    }
                    let first = columns * (wrapped_index(row + y, reach, rows) + rows * layer);
                    let counts = (deep * weighing.along(reach, y.abs_diff(reach))) as f32;
                    let line = &lines[first..first + columns];
                    // An image above begins at this column of its original, and one below at the
                    // opposite one.
                    let begin = match (row + y).cmp(&reach) {
                        _ if offset == 0 => 0,
                        Ordering::Less => offset,
                        _ if row + y - reach >= rows => columns - offset,
                        _ => 0,
                    };
                    let (near, far) = sums.split_at_mut(columns - begin);
                    for (sums, values) in [(near, &line[begin..]), (far, &line[..begin])] {
                        for (sum, value) in sums.iter_mut().zip(values) {
                            *sum += counts * value;
                        }
                    }
                }
            }
        };
        let blocks = self.sums.chunks_mut(BLOCK * columns);
        each_of(parallel, blocks, |block, sums| {
            for (number, sums) in sums.chunks_mut(columns).enumerate() {
                add(BLOCK * block + number, sums);
            }
        });
    }

    /// Returns the area or volume that particles cover in the density window of a cell, in units of
    /// a largest particle; in a single-cell window `own`, that of the cell itself.
    #[inline(always)]
    pub(crate) fn around(&self, cell: [u32; 3], own: f64) -> f64 {
        if !self.looks_around() {
            return own;
        }
        let [columns, rows, _] = self.counts;
        let [x, y, z] = cell.map(|at| at as usize);
        f64::from(self.sums[x + columns * (y + rows * z)])
    }

    /// Returns the area or volume that particles cover, in units of a largest particle, in the
    /// density window of the cell `step` away from a simulator's cell, without the simulator
    /// itself. For offsets within the half width, boxes without boundaries, and windows of several
    /// cells.
    #[inline(always)]
    pub(crate) fn others(&self, cell: [u32; 3], step: [i64; 3]) -> f64 {
        let own = self.share_of(step.map(|step| step.unsigned_abs() as usize));
        f64::from(self.sums[self.index(cell, step)]) - own
    }

    /// Computes the largest neighbour count [`Density::others`] over offsets up to `x`, `y`, `z`,
    /// for each cell of a line that starts at `first`. `line` is scratch memory.
    #[inline(always)]
    pub(crate) fn most_others(
        &self,
        first: [u32; 3],
        [x, y, z]: [i64; 3],
        line: &mut Vec<f32>,
        most: &mut [f64],
    ) {
        let columns = self.counts[0];
        let length = most.len() + 2 * x as usize;
        most.fill(0.0);
        for layer in -z..=z {
            for row in -y..=y {
                // Sums of the line there, extended by the offsets on both sides, across periodic
                // faces.
                let [mut column, y, z] = self.original(first, [-x, row, layer]);
                let begin = columns * (y + self.counts[1] * z);
                line.clear();
                while line.len() < length {
                    let next = (length - line.len()).min(columns - column);
                    line.extend_from_slice(&self.sums[begin + column..begin + column + next]);
                    column = 0;
                }
                for column in -x..=x {
                    let own = self
                        .share_of([column, row, layer].map(|step| step.unsigned_abs() as usize));
                    let shifted = &line[(column + x) as usize..];
                    for (most, &units) in most.iter_mut().zip(shifted) {
                        *most = larger(*most, f64::from(units) - own);
                    }
                }
            }
        }
    }

    /// Returns the index of the cell at an offset of `step` from a cell, across periodic faces.
    #[inline(always)]
    fn index(&self, cell: [u32; 3], step: [i64; 3]) -> usize {
        let [x, y, z] = self.original(cell, step);
        x + self.counts[0] * (y + self.counts[1] * z)
    }

    /// Returns column, row and layer of the cell at an offset of `step` from a cell, across
    /// periodic faces. In a shear flow, cells beyond the edge are displaced by whole columns, as in
    /// [`Self::add_lines`].
    #[inline(always)]
    fn original(&self, cell: [u32; 3], step: [i64; 3]) -> [usize; 3] {
        let shifted = |axis: usize| {
            (cell[axis] as usize + self.counts[axis]).wrapping_add_signed(step[axis] as isize)
        };
        let around =
            |axis: usize, at: usize| wrapped_index(at, self.counts[axis], self.counts[axis]);
        let (columns, rows) = (self.counts[0], self.counts[1]);
        let row = shifted(1);
        let mut column = around(0, shifted(0));
        if self.offset != 0 && row >= 2 * rows {
            column = around(0, columns + column - self.offset);
        } else if self.offset != 0 && row < rows {
            column = around(0, columns + column + self.offset);
        }
        [column, around(1, row), around(2, shifted(2))]
    }

    /// Returns the free-volume factors of the density window of a cell.
    #[inline(always)]
    pub(crate) fn crowding(&self, cell: [u32; 3]) -> FreeVolumeFactors {
        if self.crowding.is_empty() {
            return FreeVolumeFactors::NONE;
        }
        let [x, y, z] = cell.map(|at| at as usize);
        self.crowding[x + self.counts[0] * (y + self.counts[1] * z)]
    }

    /// Returns the contact value chi of a cell, true if chi is at its limit, and the packing
    /// fraction (0 for the dilute gas). The cell's own particles cover `own`, in units of a largest
    /// particle.
    #[inline]
    pub(crate) fn contact_value(&self, cell: [u32; 3], own: f64) -> (f64, bool, f64) {
        if let Some(chi) = self.mean {
            return (chi.min(self.limit), chi > self.limit, self.mean_packing);
        }
        self.value_of(self.around(cell, own) * self.crowding(cell).bodies)
    }

    /// Returns contact value, limit flag and packing fraction, as [`Density::contact_value`], of a
    /// sub-cell with its layer. `share` is its fraction of a cell.
    pub(crate) fn contact_value_in(
        &self,
        [sub_cell, layer]: [usize; 2],
        own: f64,
        share: f64,
    ) -> (f64, bool, f64) {
        let units = match &self.cut_windows {
            Some(windows) => windows.density(sub_cell, layer as u32) * self.cells_around(),
            None => own / share,
        };
        self.value_of(units)
    }

    /// Returns contact value, limit flag and packing fraction, as [`Density::contact_value`], for a
    /// window without boundaries in which particles cover `units`, in units of a largest particle.
    #[inline]
    pub(crate) fn value_of(&self, units: f64) -> (f64, bool, f64) {
        if let Some(chi) = self.mean {
            return (chi.min(self.limit), chi > self.limit, self.mean_packing);
        }
        let known = if f64::from(units as u32) == units {
            self.table.get(units as usize)
        } else {
            None
        };
        let chi = known
            .copied()
            .unwrap_or_else(|| self.scheme.contact_value::<S>(units * self.unit));
        (chi.min(self.limit), chi >= self.limit, units * self.unit)
    }

    /// Returns true if the contact value chi is at its limit in a window in which particles cover
    /// `units`, in units of a largest particle.
    #[inline]
    pub(crate) fn is_limited(&self, units: f64) -> bool {
        (self.mean.is_some() || units as usize >= self.table.len()) && self.value_of(units).1
    }

    /// Returns the memory that the local density and its tables occupy \[bytes\].
    pub(crate) fn bytes(&self) -> usize {
        8 * (self.table.capacity() + 2 * self.crowding.capacity())
            + 4 * (self.lines.capacity() + self.sums.capacity())
            + self
                .cut_windows
                .as_ref()
                .map_or(0, CutWindows::memory_bytes)
    }
}

/// Returns the sum of the cell weights in a window with the given half widths: for equal weights
/// its number of cells.
fn sum_of_weights(weighing: DensityKernel, reach: [usize; 3]) -> f64 {
    let along = |reach: usize| match weighing {
        DensityKernel::Flat => 2 * reach + 1,
        DensityKernel::Triangle => (reach + 1) * (reach + 1),
    };
    reach.map(|reach| along(reach) as f64).iter().product()
}

/// Returns true if the index `shifted - reach` is outside a list of `count` entries.
#[inline]
fn is_outside(shifted: usize, reach: usize, count: usize) -> bool {
    shifted < reach || shifted - reach >= count
}

/// Returns the index `shifted - reach` wrapped around a ring of `count` entries, for `reach` up to
/// `count`.
#[inline]
fn wrapped_index(shifted: usize, reach: usize, count: usize) -> usize {
    let at = shifted + count - reach;
    let at = if at >= count { at - count } else { at };
    if at >= count { at - count } else { at }
}

#[cfg(test)]
mod tests;
