//! By how much density raises the collision rate.

mod windows;

use std::cmp::Ordering;

use stosszahl_model::Space;

use crate::extrema::larger;
use crate::scheme::{Neighbourhood, Scheme};
use crate::threads::each_of;

pub(crate) use windows::{CellLayers, CutWindow, CutWindows, WindowCentre, WindowMember};

/// Lines of cells that one thread adds up in turn.
const BLOCK: usize = 16;

/// How the cells of a neighbourhood count.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Weighing {
    /// All as much.
    Flat,
    /// The less the farther they are along each axis: n + 1 - j of one that is j cells away, of n on each side. The transform of these
    /// weights is nowhere negative, so that a dense gas does not break up into waves as short as the neighbourhood is wide.
    Triangle,
}

impl Weighing {
    /// Of a cell that is so many away along one axis, of `reach` on each side.
    #[inline(always)]
    fn along(self, reach: usize, away: usize) -> usize {
        match self {
            Self::Flat => 1,
            Self::Triangle => reach + 1 - away,
        }
    }
}

/// Most entries of the table of chi: beyond, in huge cells, it is computed.
const LARGEST_TABLE: u32 = 1 << 14;

/// chi in each cell, from how much area or volume its neighbourhood's particles cover.
pub(crate) struct Density<S: Space> {
    scheme: Scheme,
    limit: f64,
    /// chi by the number of units in the neighbourhood: the covered area is a small integer times
    /// one particle's where all are alike, so chi is looked up.
    table: Vec<f64>,
    /// Packing fraction of one unit in the neighbourhood.
    unit: f64,
    /// Half widths of the neighbourhood in cells, along each axis.
    reach: [usize; 3],
    weighing: Weighing,
    mean: Option<f64>,
    mean_packing: f64,
    counts: [usize; 3],
    /// Units in the 2n + 1 cells along the first axis around each cell; integers up to 2^24 are exact. Empty where no
    /// neighbourhood is needed.
    lines: Vec<f32>,
    /// Units in the whole neighbourhood of each cell.
    sums: Vec<f32>,
    /// Axes along which the box is not periodic: neighbourhoods stop at its faces.
    bounded: [bool; 3],
    /// Columns by which the rows above the box are displaced, in a shear flow.
    offset: usize,
    /// By the number of the cell; empty where all is room.
    crowding: Vec<Crowding>,
    /// Windows that bodies cut, if there are bodies.
    cut_windows: Option<CutWindows>,
    space: std::marker::PhantomData<S>,
}

/// By how much boundaries make a neighbourhood denser than the number in it says.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Crowding {
    /// Its volume over that in which its particles can be, with all of their bodies: for packing fractions.
    pub(crate) bodies: f64,
    /// The latter over that in which their centres can be: for number densities.
    pub(crate) centres: f64,
}

impl Crowding {
    /// Of a neighbourhood that is all room.
    pub(crate) const NONE: Self = Self {
        bodies: 1.0,
        centres: 1.0,
    };
}

/// What [`Density::new`] must know of the gas.
pub(crate) struct Gas {
    /// Limit on chi.
    pub(crate) limit: f64,
    /// Cells along each axis, and area or volume of one.
    pub(crate) counts: [u32; 3],
    pub(crate) cell: f64,
    /// Narrowest side of a cell, and the mean diameter.
    pub(crate) width: f64,
    pub(crate) diameter: f64,
    pub(crate) simulators_per_particle: f64,
    /// Area or volume of the largest particle, times the particles of a simulator: the unit.
    pub(crate) unit: f64,
    /// Packing fraction of the whole box.
    pub(crate) packing_fraction: f64,
    /// Axes along which the box is not periodic.
    pub(crate) bounded: [bool; 3],
    /// Whether particles are all alike, and nothing is in their way.
    pub(crate) is_plain: bool,
}

/// Cells on each side over which the packing is taken, and how they count; none for the whole box, or where it does not count.
fn window(scheme: Scheme, gas: &Gas, dimension: usize) -> Option<(u32, Weighing)> {
    let (cell, diameter) = (gas.width, gas.diameter);
    let reach = match scheme {
        Scheme::Enskog(Neighbourhood::Cells(n)) | Scheme::Esmc(Neighbourhood::Cells(n)) => n,
        Scheme::FreeVolume => 0,
        Scheme::StochasticDisks { .. } => 2,
        // Ten diameters around one simulator per particle, fewer around many, which make less noise.
        Scheme::ContactPoint { .. } => {
            let shrunk = 10.0 / gas.simulators_per_particle.powf(1.0 / dimension as f64);
            // In space it was not measured.
            let is_known = dimension == 2 && gas.is_plain && !gas.bounded[..2].contains(&true);
            if shrunk < 3.0 && is_known && cell < diameter {
                let half = (diameter / cell).ceil().min(50.0);
                return Some((half as u32 - 1, Weighing::Triangle));
            }
            let side = shrunk.max(3.0) * diameter;
            ((0.5 * (side / cell - 1.0)).ceil().max(0.0) as u32).min(50)
        }
        _ => return None,
    };
    Some((reach, Weighing::Flat))
}

impl<S: Space> Density<S> {
    pub(crate) fn new(scheme: Scheme, gas: &Gas) -> Self {
        let counts = gas.counts.map(|count| count as usize);
        let wanted = window(scheme, gas, S::DIMENSION);
        let (cells, mut weighing) = wanted.unwrap_or((0, Weighing::Flat));
        let reach = [0, 1, 2].map(|axis| {
            let wanted = if axis < S::DIMENSION {
                cells as usize
            } else {
                0
            };
            // A neighbourhood that wraps around the box would count particles twice; at walls it ends.
            wanted.min(if gas.bounded[axis] {
                counts[axis] - 1
            } else {
                (counts[axis] - 1) / 2
            })
        });
        // In a box so narrow all of it counts alike.
        if reach[..S::DIMENSION]
            .iter()
            .any(|&reach| reach < cells as usize)
        {
            weighing = Weighing::Flat;
        }
        let mean = wanted
            .is_none()
            .then(|| scheme.contact_value::<S>(gas.packing_fraction));
        let unit = gas.unit / (gas.cell * block(weighing, reach));
        let table = if mean.is_some() { 0 } else { LARGEST_TABLE };
        let table = (0..table)
            .map(|count| scheme.contact_value::<S>(f64::from(count) * unit))
            .take_while(|&chi| chi < gas.limit)
            .collect();
        let mean_packing = if matches!(scheme, Scheme::Collisionless | Scheme::Boltzmann) {
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

    /// Displaces the rows above the box by this number of columns, and those below it the other way.
    pub(crate) fn slide(&mut self, columns: usize) {
        self.offset = columns % self.counts[0];
    }

    /// Sets the windows that bodies cut.
    pub(crate) fn cut(&mut self, windows: Option<CutWindows>) {
        self.cut_windows = windows;
    }

    /// Axes along which windows end at the faces of the box.
    pub(crate) fn bounded(&self) -> [bool; 3] {
        self.bounded
    }

    /// Notes which share of each cell is room for centres, and which for bodies: packing fractions are of the latter.
    pub(crate) fn set_room(
        &mut self,
        centres: impl Fn([u32; 3]) -> f64 + Sync,
        bodies: impl Fn([u32; 3]) -> f64 + Sync,
    ) {
        let centres = self.rooms_around(centres);
        let bodies = self.rooms_around(bodies);
        let cells = self.cells_around();
        // Rooms are added in single precision.
        let whole = |factor: f64| if factor > 1.0 + 1e-5 { factor } else { 1.0 };
        let crowding = centres
            .iter()
            .zip(&bodies)
            .map(|(centres, bodies)| Crowding {
                bodies: whole(cells / bodies),
                centres: whole(bodies / centres),
            });
        self.crowding = crowding.collect();
        if self.crowding.iter().all(|one| *one == Crowding::NONE) {
            self.crowding = Vec::new();
        }
    }

    /// Sets the room for centres in cells and sub-cells \[cells\] whose windows bodies cut; after [`Density::set_room`].
    pub(crate) fn set_room_in_windows(&mut self, mut room: impl FnMut(WindowMember, u32) -> f64) {
        let Some(windows) = &mut self.cut_windows else {
            return;
        };
        windows.set_rooms(&mut room);
        if self.crowding.is_empty() {
            self.crowding = vec![Crowding::NONE; self.counts.iter().product()];
        }
        let [columns, rows, _] = self.counts;
        let cells = block(self.weighing, self.reach);
        for ([x, y, z], _, room) in windows.cells() {
            let cell = x as usize + columns * (y as usize + rows * z as usize);
            self.crowding[cell].bodies = if room > 0.0 { cells / room } else { 1.0 };
        }
    }

    /// Takes the units in cells and sub-cells whose windows bodies cut; after [`Density::update`].
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

    /// The room in the neighbourhood of each cell, in cells.
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

    /// Whether chi of a cell depends on other cells, so that all must be arranged before any collides.
    pub(crate) fn looks_around(&self) -> bool {
        self.reach != [0; 3]
    }

    /// Cells on each side of one whose particles count for it, along each axis.
    pub(crate) fn reach(&self) -> [usize; 3] {
        self.reach
    }

    /// Cells of a neighbourhood, each as often as it counts.
    pub(crate) fn cells_around(&self) -> f64 {
        block(self.weighing, self.reach)
    }

    /// Mean of the squares of what cells of a neighbourhood count, over their mean.
    pub(crate) fn squares(&self) -> f64 {
        let along = |reach: usize| match self.weighing {
            Weighing::Flat => 1.0,
            // The sum of the squares of 1 to n to 1 is n(2 n^2 + 1)/3, and the sum n^2.
            Weighing::Triangle => {
                let half = (reach + 1) as f64;
                (2.0 * half * half + 1.0) / (3.0 * half)
            }
        };
        self.reach.map(along).iter().product()
    }

    /// How cells of a neighbourhood count.
    pub(crate) fn weighing(&self) -> Weighing {
        self.weighing
    }

    /// How much of a neighbourhood a simulator is that is so many cells from its middle along each axis, at most its half width.
    #[inline(always)]
    pub(crate) fn share_of(&self, away: [usize; 3]) -> f64 {
        let along = |axis: usize| self.weighing.along(self.reach[axis], away[axis]);
        (along(0) * along(1) * along(2)) as f64
    }

    /// Which pairs collide.
    pub(crate) fn scheme(&self) -> Scheme {
        self.scheme
    }

    /// Packing fraction of one unit in a neighbourhood.
    pub(crate) fn unit(&self) -> f64 {
        self.unit
    }

    /// Whether pairs collide at all.
    pub(crate) fn collides(&self) -> bool {
        self.scheme != Scheme::Collisionless
    }

    /// Takes the covered units of all cells: `fill` writes those of one line along the first axis, given its number.
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

    /// Adds the sums of the lines around each line.
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
                let layer = wrapped(layer + z, depth, layers);
                for y in 0..=2 * reach {
                    if bounded[1] && is_outside(row + y, reach, rows) {
                        continue;
                    }
                    let first = columns * (wrapped(row + y, reach, rows) + rows * layer);
                    let counts = (deep * weighing.along(reach, y.abs_diff(reach))) as f32;
                    let line = &lines[first..first + columns];
                    // An image above begins at this column of its original, and one below at the opposite one.
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

    /// Units around a cell, of which the cell itself has `own`.
    #[inline(always)]
    pub(crate) fn around(&self, cell: [u32; 3], own: f64) -> f64 {
        if !self.looks_around() {
            return own;
        }
        let [columns, rows, _] = self.counts;
        let [x, y, z] = cell.map(|at| at as usize);
        f64::from(self.sums[x + columns * (y + rows * z)])
    }

    /// Units around the cell that is so many steps from that of a simulator, at most its half width, without what the simulator itself
    /// counts. Where nothing bounds the box, and neighbourhoods are wider than a cell.
    #[inline(always)]
    pub(crate) fn others(&self, cell: [u32; 3], step: [i64; 3]) -> f64 {
        let own = self.share_of(step.map(|step| step.unsigned_abs() as usize));
        f64::from(self.sums[self.index(cell, step)]) - own
    }

    /// The most of [`Density::others`] up to so many steps along each axis, for each cell of a part of a line along the first axis.
    /// `first`: its first cell; `line`: memory to work in.
    #[inline(always)]
    pub(crate) fn most_others(
        &self,
        first: [u32; 3],
        [x, y, z]: [i64; 3],
        line: &mut Vec<f32>,
        most: &mut [f64],
    ) {
        let columns = self.counts[0];
        let before = wrapped(first[0] as usize, x as usize, columns);
        let length = most.len() + 2 * x as usize;
        most.fill(0.0);
        for layer in -z..=z {
            for row in -y..=y {
                // The sums of the line there, from so many steps before the first cell to so many after the last, around the box.
                let begin = self.index([0, first[1], first[2]], [0, row, layer]);
                let mut column = before;
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

    /// The number of the cell that is so many steps from one.
    #[inline(always)]
    fn index(&self, cell: [u32; 3], step: [i64; 3]) -> usize {
        let [x, y, z] = [0, 1, 2].map(|axis| {
            let count = self.counts[axis];
            let at = (cell[axis] as usize + count).wrapping_add_signed(step[axis] as isize);
            wrapped(at, count, count)
        });
        x + self.counts[0] * (y + self.counts[1] * z)
    }

    /// What boundaries leave of the neighbourhood of a cell.
    #[inline(always)]
    pub(crate) fn crowding(&self, cell: [u32; 3]) -> Crowding {
        if self.crowding.is_empty() {
            return Crowding::NONE;
        }
        let [x, y, z] = cell.map(|at| at as usize);
        self.crowding[x + self.counts[0] * (y + self.counts[1] * z)]
    }

    /// chi of a cell whose own particles cover `own` units; whether it was limited; and the packing fraction that
    /// it belongs to, none for the dilute gas.
    #[inline]
    pub(crate) fn contact_value(&self, cell: [u32; 3], own: f64) -> (f64, bool, f64) {
        if let Some(chi) = self.mean {
            return (chi.min(self.limit), chi > self.limit, self.mean_packing);
        }
        self.value_of(self.around(cell, own) * self.crowding(cell).bodies)
    }

    /// [`Density::contact_value`] of a sub-cell with this share of its cell, by its number among all and its layer.
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

    /// The same, where this number of units is around as if all around were room.
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

    /// Whether chi is limited where this number of units is around.
    #[inline]
    pub(crate) fn is_limited(&self, units: f64) -> bool {
        (self.mean.is_some() || units as usize >= self.table.len()) && self.value_of(units).1
    }

    /// Memory \[bytes\].
    pub(crate) fn bytes(&self) -> usize {
        8 * (self.table.capacity() + 2 * self.crowding.capacity())
            + 4 * (self.lines.capacity() + self.sums.capacity())
            + self.cut_windows.as_ref().map_or(0, CutWindows::bytes)
    }
}

/// Cells of a neighbourhood of given half widths, each as often as it counts.
fn block(weighing: Weighing, reach: [usize; 3]) -> f64 {
    let along = |reach: usize| match weighing {
        Weighing::Flat => 2 * reach + 1,
        Weighing::Triangle => (reach + 1) * (reach + 1),
    };
    reach.map(|reach| along(reach) as f64).iter().product()
}

/// Whether `shifted - reach` is not a number below `count`.
#[inline]
fn is_outside(shifted: usize, reach: usize, count: usize) -> bool {
    shifted < reach || shifted - reach >= count
}

/// The number `shifted - reach`, around a ring of `count`; both are at most `count`.
#[inline]
fn wrapped(shifted: usize, reach: usize, count: usize) -> usize {
    let at = shifted + count - reach;
    let at = if at >= count { at - count } else { at };
    if at >= count { at - count } else { at }
}

#[cfg(test)]
mod tests;
