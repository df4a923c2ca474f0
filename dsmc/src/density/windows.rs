//! Windows of the local packing fraction that obstacles cut: they contain only cells and sub-cells
//! in line of sight of their centre.

/// Cell of a density window, or one of its sub-cells if an obstacle splits it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct WindowMember {
    /// Column and row of the cell in the grid.
    pub(crate) cell: [u32; 2],
    /// Index of the sub-cell in its cell; `None` in a cell that is not split.
    pub(crate) sub_cell: Option<usize>,
}

/// Density window of a cell or sub-cell that obstacles cut, in the plane of the first two axes.
#[derive(Clone, Debug)]
pub(crate) struct CutWindow<T> {
    pub(crate) centre: WindowCentre,
    /// Cells and sub-cells that belong to the density window.
    pub(crate) members: Vec<T>,
}

/// Cell or sub-cell at the centre of a density window.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum WindowCentre {
    /// Cell that is not split, by its column and row.
    Cell([u32; 2]),
    /// Sub-cell of a split cell, by its index among the sub-cells of all split cells.
    SubCell(usize),
}

/// All density windows that obstacles cut, with the area that particles cover in them and their
/// free area.
pub(crate) struct CutWindows {
    members: Vec<WindowMember>,
    windows: Vec<CutWindow<usize>>,
    /// Index of the density window around each sub-cell of all split cells.
    of_sub_cells: Vec<usize>,
    layers: CellLayers,
    /// Area that particles cover in each density window, in units of a largest particle, layer
    /// after layer of cells.
    units: Vec<f64>,
    /// Free area in each density window, layer after layer \[cells\].
    rooms: Vec<f64>,
}

/// Layers of cells along the third axis, the axis of prismatic obstacles: their number, and the
/// window across them.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CellLayers {
    pub(crate) count: usize,
    /// Half width of density windows along the third axis \[cells\].
    pub(crate) reach: usize,
    /// True if density windows end at the faces of the box along the third axis; false if it is
    /// periodic.
    pub(crate) bounded: bool,
}

impl CellLayers {
    /// Returns the layers of cells in the density window around a layer.
    fn layers_around(self, layer: usize) -> impl Iterator<Item = usize> {
        let Self {
            count,
            reach,
            bounded,
        } = self;
        let shifted = (layer + count - reach)..=(layer + count + reach);
        shifted
            .filter(move |at| !bounded || (count..2 * count).contains(at))
            .map(move |at| at % count)
    }
}

impl CutWindows {
    /// Collects cut density windows, in the order of their centres. `sub_cells` is the number of
    /// sub-cells of all split cells.
    pub(crate) fn new(
        windows: Vec<CutWindow<WindowMember>>,
        sub_cells: usize,
        layers: CellLayers,
    ) -> Self {
        let all = windows.iter().flat_map(|window| &window.members);
        let mut members: Vec<WindowMember> = all.copied().collect();
        members.sort_unstable();
        members.dedup();
        let index = |source| members.partition_point(|other| *other < source);
        let windows: Vec<CutWindow<usize>> = windows
            .into_iter()
            .map(|CutWindow { centre, members }| CutWindow {
                centre,
                members: members.into_iter().map(index).collect(),
            })
            .collect();
        let mut of_sub_cells = vec![0; sub_cells];
        for (number, window) in windows.iter().enumerate() {
            if let WindowCentre::SubCell(sub_cell) = window.centre {
                of_sub_cells[sub_cell] = number;
            }
        }
        let size = windows.len() * layers.count;
        Self {
            members,
            windows,
            of_sub_cells,
            layers,
            units: vec![0.0; size],
            rooms: vec![1.0; size],
        }
    }

    /// Sets the areas that particles cover in all density windows from those of cells and
    /// sub-cells, given layer by layer, in units of a largest particle.
    pub(super) fn set_units(&mut self, units: &mut dyn FnMut(WindowMember, u32) -> f64) {
        self.units = self.sums(units);
    }

    /// Sets the free areas of all density windows \[cells\] from those of cells and sub-cells,
    /// given layer by layer.
    pub(super) fn set_rooms(&mut self, room: &mut dyn FnMut(WindowMember, u32) -> f64) {
        self.rooms = self.sums(room);
    }

    /// Returns the sum of a value over the cells and sub-cells of each density window, layer after
    /// layer.
    fn sums(&self, value: &mut dyn FnMut(WindowMember, u32) -> f64) -> Vec<f64> {
        let values: Vec<Vec<f64>> = (0..self.layers.count as u32)
            .map(|layer| {
                let members = self.members.iter();
                members.map(|&source| value(source, layer)).collect()
            })
            .collect();
        let sum = |window: &CutWindow<usize>, layer| -> f64 {
            let layers = self.layers.layers_around(layer).map(|layer| &values[layer]);
            let sums =
                layers.map(|values| window.members.iter().map(|&one| values[one]).sum::<f64>());
            sums.sum()
        };
        (0..self.layers.count)
            .flat_map(|layer| self.windows.iter().map(move |window| (window, layer)))
            .map(|(window, layer)| sum(window, layer))
            .collect()
    }

    /// Returns the cells with a cut density window, each with the area that particles cover in its
    /// window, in units of a largest particle, and the window's free area \[cells\].
    pub(super) fn cells(&self) -> impl Iterator<Item = ([u32; 3], f64, f64)> + '_ {
        let places = (0..self.layers.count as u32).flat_map(|layer| {
            self.windows
                .iter()
                .map(move |window| (window.centre, layer))
        });
        let contents = self.units.iter().zip(&self.rooms);
        places
            .zip(contents)
            .filter_map(|((centre, layer), (&units, &room))| match centre {
                WindowCentre::Cell([x, y]) => Some(([x, y, layer], units, room)),
                WindowCentre::SubCell(_) => None,
            })
    }

    /// Returns the area that particles cover per cell of free area in the density window of a
    /// sub-cell, in units of a largest particle; 0 without free area.
    pub(super) fn density(&self, sub_cell: usize, layer: u32) -> f64 {
        let place = self.of_sub_cells[sub_cell] + self.windows.len() * layer as usize;
        if self.rooms[place] > 0.0 {
            self.units[place] / self.rooms[place]
        } else {
            0.0
        }
    }

    /// Returns the memory that the cut density windows occupy \[bytes\].
    pub(super) fn memory_bytes(&self) -> usize {
        let members = self.windows.iter().map(|window| window.members.capacity());
        size_of::<WindowMember>() * self.members.capacity()
            + size_of::<CutWindow<usize>>() * self.windows.capacity()
            + 8 * (members.sum::<usize>() + self.of_sub_cells.capacity())
            + 8 * (self.units.capacity() + self.rooms.capacity())
    }
}
