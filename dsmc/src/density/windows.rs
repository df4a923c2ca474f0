//! Density windows cut by obstacles: they contain only cells on the same side.

/// A cell, or a sub-cell of a split one, whose particles count in density windows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct WindowMember {
    /// Coordinates of the cell along the first two axes.
    pub(crate) cell: [u32; 2],
    /// Sub-cell; `None` in a cell that is not split.
    pub(crate) sub_cell: Option<usize>,
}

/// Density window of a cell or sub-cell, in the plane of the first two axes.
#[derive(Clone, Debug)]
pub(crate) struct CutWindow<T> {
    pub(crate) centre: WindowCentre,
    /// Cells and sub-cells in the window.
    pub(crate) members: Vec<T>,
}

/// The cell or sub-cell at the centre of a window.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum WindowCentre {
    /// A cell, by its coordinates along the first two axes.
    Cell([u32; 2]),
    /// A sub-cell, by its index among the sub-cells of all split cells.
    SubCell(usize),
}

/// All cut windows, with the particles and the free area in them.
pub(crate) struct CutWindows {
    members: Vec<WindowMember>,
    windows: Vec<CutWindow<usize>>,
    /// Index of the window of each sub-cell.
    of_sub_cells: Vec<usize>,
    layers: CellLayers,
    /// Covered units in each window in each layer of cells.
    units: Vec<f64>,
    /// Free area of each window in each layer \[cells\].
    rooms: Vec<f64>,
}

/// Layers of cells along the third axis, along which obstacles are prisms.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CellLayers {
    pub(crate) count: usize,
    /// Half width of density windows \[cells\].
    pub(crate) reach: usize,
    /// True if density windows end at the faces of the box.
    pub(crate) bounded: bool,
}

impl CellLayers {
    /// Layers in a window around a layer.
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
    /// Collects windows in the order of their centres. `sub_cells`: number of sub-cells of all
    /// split cells.
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

    /// Sets the units in all cells and sub-cells of the windows.
    pub(super) fn set_units(&mut self, units: &mut dyn FnMut(WindowMember, u32) -> f64) {
        self.units = self.sums(units);
    }

    /// Sets the free area of all cells and sub-cells of the windows \[cells\].
    pub(super) fn set_rooms(&mut self, room: &mut dyn FnMut(WindowMember, u32) -> f64) {
        self.rooms = self.sums(room);
    }

    /// Sums of a value over each window in each layer.
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

    /// Cells with a cut window, with its units and its free area.
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

    /// Units per cell of free area in the window of a sub-cell.
    pub(super) fn density(&self, sub_cell: usize, layer: u32) -> f64 {
        let place = self.of_sub_cells[sub_cell] + self.windows.len() * layer as usize;
        if self.rooms[place] > 0.0 {
            self.units[place] / self.rooms[place]
        } else {
            0.0
        }
    }

    /// Memory of the density windows \[bytes\].
    pub(super) fn memory_bytes(&self) -> usize {
        let members = self.windows.iter().map(|window| window.members.capacity());
        size_of::<WindowMember>() * self.members.capacity()
            + size_of::<CutWindow<usize>>() * self.windows.capacity()
            + 8 * (members.sum::<usize>() + self.of_sub_cells.capacity())
            + 8 * (self.units.capacity() + self.rooms.capacity())
    }
}
