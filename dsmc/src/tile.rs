//! Tiles: the simulators of a block of cells, and their migration between tiles.
//!
//! Between two collisions a tile does three things, in functions here or in `collide` and `fly`.
//! **Arrange** sorts the simulators of the tile by cell, **collide** processes cell after cell, and
//! **fly** moves all and sends those that leave to other tiles. The sorted simulators lie in a
//! scratch buffer that fits the cache and belongs to a thread; fly writes them back. Each simulator
//! thus crosses the memory bus once per step.
//!
//! The order within a cell is canonical: by the source cell at the last sort, and within a source
//! cell by the order there. It depends on neither threads nor tiles.

use stosszahl_model::{Collision, ParticleModel, Space, VectorOf};

use crate::boundary::Ledgers;
use crate::grid::{Grid, OFFSETS, TilePlace, offset};
use crate::particle::{DisplacementTracking, SimulatorOf};
use crate::tally::{CellCount, CollisionCounters, StepBounds};

/// Simulator that left its tile, with the number of the cell it was in at the last sort.
#[derive(Clone, Copy)]
pub(crate) struct DepartedSimulator<S> {
    pub(crate) source: u32,
    pub(crate) simulator: S,
}

/// Simulator that migrates from one tile to another, with its source cell.
pub(crate) type Migrant<P, F> = DepartedSimulator<SimulatorOf<P, F>>;

/// Send buffer of a tile: simulators that left it, by the offset of the adjacent tile they enter,
/// or by tile number if they flew farther.
pub(crate) struct SendBuffer<P: ParticleModel, F: DisplacementTracking<P::Space>> {
    near: Vec<Migrant<P, F>>,
    /// Index in `near` after the last simulator for each offset to an adjacent tile.
    ends: [u32; OFFSETS],
    pub(crate) far: Vec<(u32, Migrant<P, F>)>,
}

impl<P: ParticleModel, F: DisplacementTracking<P::Space>> Default for SendBuffer<P, F> {
    fn default() -> Self {
        Self {
            near: Vec::new(),
            ends: [0; OFFSETS],
            far: Vec::new(),
        }
    }
}

impl<P: ParticleModel, F: DisplacementTracking<P::Space>> SendBuffer<P, F> {
    /// Returns the simulators in the send buffer for the adjacent tile at an offset (by its
    /// number), in the order of their source cells.
    pub(crate) fn towards(&self, offset: usize) -> &[Migrant<P, F>] {
        let begin = if offset == 0 {
            0
        } else {
            self.ends[offset - 1]
        };
        &self.near[begin as usize..self.ends[offset] as usize]
    }

    /// Fills the send buffer with the simulators that left, each with the number of its offset, in
    /// the order of their source cells.
    pub(crate) fn fill(&mut self, leavers: &[(u8, Migrant<P, F>)]) {
        let mut starts = [0_u32; OFFSETS];
        for (offset, _) in leavers {
            starts[usize::from(*offset)] += 1;
        }
        let mut total = 0;
        for start in &mut starts {
            total += *start;
            *start = total - *start;
        }
        self.near.clear();
        fit(&mut self.near, leavers.len());
        if let Some(&(_, first)) = leavers.first() {
            self.near.resize(leavers.len(), first);
        }
        for &(offset, traveller) in leavers {
            let slot = &mut starts[usize::from(offset)];
            self.near[*slot as usize] = traveller;
            *slot += 1;
        }
        self.ends = starts;
    }

    /// Returns the number of simulators in the send buffer that enter adjacent tiles, without those
    /// that flew farther.
    pub(crate) fn near(&self) -> usize {
        self.near.len()
    }

    pub(crate) fn bytes(&self) -> usize {
        self.near.capacity() * size_of::<Migrant<P, F>>()
            + self.far.capacity() * size_of::<(u32, Migrant<P, F>)>()
    }
}

/// Grows a vector's memory to hold `count` elements with little to spare, and shrinks one that is
/// far too large.
pub(crate) fn fit<T>(vector: &mut Vec<T>, count: usize) {
    let enough = count + count / 24 + 4;
    if vector.capacity() < count {
        vector.reserve_exact(enough - vector.len());
    } else if vector.capacity() > 2 * enough + 64 {
        vector.shrink_to(enough);
    }
}

/// Tile: the simulators of a block of cells, with its counters and logs.
pub(crate) struct Tile<P: ParticleModel, F: DisplacementTracking<P::Space>> {
    pub(crate) place: TilePlace<P::Space>,
    /// Simulators of the tile: sorted by cell before collisions; after a flight, those that stayed,
    /// by source cell.
    pub(crate) simulators: Vec<SimulatorOf<P, F>>,
    /// Cell of each simulator after a flight, as the cell's number in the tile.
    pub(crate) codes: Vec<u16>,
    /// After sorting: index of the first simulator of each cell, and the end. After a flight:
    /// number of simulators that stayed in each cell.
    pub(crate) starts: Vec<u32>,
    /// After a flight: index after the last simulator that came from each line of cells along the
    /// first axis.
    pub(crate) lines: Vec<u32>,
    /// Counters of collisions in the tile since it was sorted.
    pub(crate) tally: CollisionCounters,
    pub(crate) stock: StepBounds<P::Space>,
    /// Collisions in the tile logged for observers.
    pub(crate) log: Vec<Collision>,
    /// Number of collisions and virial of each cell of the tile; empty unless they are counted.
    pub(crate) counts: Vec<CellCount>,
    /// True if all cells of the tile have the same simulator weight.
    pub(crate) is_even: bool,
    /// Numbers in the tile of the cells that obstacles split into sub-cells, in order.
    pub(crate) split_cells: Vec<usize>,
    /// Boundary ledgers of the tile since they were last summed; `None` without boundaries.
    pub(crate) ledgers: Option<Box<Ledgers<P::Space>>>,
    /// True if this process owns the tile. Tiles of other processes are empty, or hold ghost cells.
    pub(crate) is_here: bool,
    /// Computing time that the tile took since the last load balancing \[s\].
    pub(crate) seconds: f64,
}

/// Working memory of a thread for one tile: sorted simulators, migrants, and sort keys.
pub(crate) struct Scratch<P: ParticleModel, F: DisplacementTracking<P::Space>> {
    pub(crate) sorted: Vec<SimulatorOf<P, F>>,
    next: Vec<u32>,
    pub(crate) leavers: Vec<(u8, Migrant<P, F>)>,
    arrivals: Vec<Migrant<P, F>>,
    /// Sort keys of the simulators that arrive in the tile: source cell, and index in `arrivals`.
    order: Vec<(u32, u32)>,
}

impl<P: ParticleModel, F: DisplacementTracking<P::Space>> Default for Scratch<P, F> {
    fn default() -> Self {
        Self {
            sorted: Vec::new(),
            next: Vec::new(),
            leavers: Vec::new(),
            arrivals: Vec::new(),
            order: Vec::new(),
        }
    }
}

impl<P: ParticleModel, F: DisplacementTracking<P::Space>> Scratch<P, F> {
    pub(crate) fn bytes(&self) -> usize {
        self.sorted.capacity() * size_of::<SimulatorOf<P, F>>()
            + self.next.capacity() * 4
            + self.leavers.capacity() * size_of::<(u8, Migrant<P, F>)>()
            + self.arrivals.capacity() * size_of::<Migrant<P, F>>()
            + self.order.capacity() * size_of::<(u32, u32)>()
    }
}

/// Simulators that arrive in tiles after a free flight.
pub(crate) struct Arrivals<'a, P: ParticleModel, F: DisplacementTracking<P::Space>> {
    /// Send buffer of each tile with the simulators that left it in the last flight.
    pub(crate) boxes: &'a [SendBuffer<P, F>],
    /// Simulators that flew beyond adjacent tiles, with the number of the tile they enter; ordered
    /// by tile and source cell.
    pub(crate) far: &'a [(u32, Migrant<P, F>)],
}

impl<P: ParticleModel, F: DisplacementTracking<P::Space>> Tile<P, F> {
    pub(crate) fn new(place: TilePlace<P::Space>) -> Self {
        let mut tile = Self {
            place,
            simulators: Vec::new(),
            codes: Vec::new(),
            starts: Vec::new(),
            lines: vec![0; (place.sides[1] * place.sides[2]) as usize],
            tally: CollisionCounters::default(),
            stock: StepBounds::default(),
            log: Vec::new(),
            counts: Vec::new(),
            is_even: true,
            split_cells: Vec::new(),
            ledgers: None,
            is_here: true,
            seconds: 0.0,
        };
        tile.starts = vec![0; tile.cells() + 1];
        tile
    }

    /// Returns the mean number of simulators in a cell of the tile.
    pub(crate) fn in_cell(&self) -> f64 {
        self.simulators.len() as f64 / self.cells() as f64
    }

    /// Returns the number of cells in the tile.
    pub(crate) fn cells(&self) -> usize {
        self.place.sides.iter().map(|&side| side as usize).product()
    }

    /// Returns the number in the grid of the first cell in a line of the tile's cells along the
    /// first axis.
    #[inline]
    pub(crate) fn line_number(&self, grid: &Grid<P::Space>, line: u32) -> u32 {
        let TilePlace { first, sides, .. } = self.place;
        grid.number([
            first[0],
            first[1] + line % sides[1],
            first[2] + line / sides[1],
        ])
    }

    /// Returns column, row and layer in the grid of a cell, given its number in the tile.
    pub(crate) fn cell_at(&self, local: usize) -> [u32; 3] {
        let TilePlace { first, sides, .. } = self.place;
        let local = local as u32;
        [
            first[0] + local % sides[0],
            first[1] + local / sides[0] % sides[1],
            first[2] + local / sides[0] / sides[1],
        ]
    }

    /// Returns the number in the tile of a cell, given its column, row and layer in the grid.
    pub(crate) fn number(&self, cell: [u32; 3]) -> usize {
        let TilePlace { first, sides, .. } = self.place;
        let [x, y, z] = [0, 1, 2].map(|axis| cell[axis] - first[axis]);
        (x + sides[0] * (y + sides[1] * z)) as usize
    }

    /// Returns the number in the tile of the cell that contains a position.
    #[inline(always)]
    pub(crate) fn code(&self, grid: &Grid<P::Space>, position: VectorOf<P>) -> u16 {
        code::<P>(grid, &self.place, position)
    }

    /// Sorts the simulators that stayed in the tile and those that arrive by cell, into the scratch
    /// memory.
    pub(crate) fn arrange(
        &mut self,
        grid: &Grid<P::Space>,
        arrivals: &Arrivals<'_, P, F>,
        scratch: &mut Scratch<P, F>,
    ) {
        self.tally = CollisionCounters::default();
        self.receive(grid, arrivals, scratch);
        let Scratch {
            sorted,
            next,
            arrivals: foreign,
            order,
            ..
        } = scratch;
        let total = self.simulators.len() + foreign.len();
        sorted.truncate(total);
        fit(sorted, total);
        sorted.resize(total, SimulatorOf::<P, F>::default());
        next.clear();
        next.reserve(self.starts.len());
        let mut sum = 0;
        for count in &mut self.starts {
            next.push(sum);
            let begin = sum;
            sum += *count;
            *count = begin;
        }
        let (sorted, next) = (&mut sorted[..], &mut next[..]);
        let mut put = |code: u16, simulator: &SimulatorOf<P, F>| {
            let slot = &mut next[usize::from(code)];
            sorted[*slot as usize] = *simulator;
            *slot += 1;
        };
        let mut begin = 0;
        let mut coming = order.iter().peekable();
        let arrival = |place: u32| {
            let simulator = &foreign[place as usize].simulator;
            (self.code(grid, simulator.position), simulator)
        };
        for (line, &end) in self.lines.iter().enumerate() {
            let number = self.line_number(grid, line as u32);
            while let Some(&(_, place)) = coming.next_if(|(source, _)| *source < number) {
                let (code, simulator) = arrival(place);
                put(code, simulator);
            }
            let stayed = begin as usize..end as usize;
            for (&code, simulator) in self.codes[stayed.clone()]
                .iter()
                .zip(&self.simulators[stayed])
            {
                put(code, simulator);
            }
            begin = end;
        }
        for &(_, place) in coming {
            let (code, simulator) = arrival(place);
            put(code, simulator);
        }
    }

    /// Gathers the simulators that arrive from other tiles, by source cell, and adds them to the
    /// counts of their cells.
    fn receive(
        &mut self,
        grid: &Grid<P::Space>,
        arrivals: &Arrivals<'_, P, F>,
        scratch: &mut Scratch<P, F>,
    ) {
        let Scratch {
            arrivals: foreign,
            order,
            ..
        } = scratch;
        foreign.clear();
        let tile = self.place.tile;
        let here = grid.tile_number(tile);
        for number in 0..OFFSETS {
            let back = offset(OFFSETS - 1 - number);
            if (0..3).any(|axis| axis >= <P::Space as Space>::DIMENSION && back[axis] != 0) {
                continue;
            }
            let from = grid.tile_number(grid.neighbour(tile, back));
            foreign.extend_from_slice(arrivals.boxes[from].towards(number));
        }
        if !arrivals.far.is_empty() {
            let begin = arrivals
                .far
                .partition_point(|(to, _)| (*to as usize) < here);
            let mine = arrivals.far[begin..].iter();
            foreign.extend(
                mine.take_while(|(to, _)| *to as usize == here)
                    .map(|(_, traveller)| *traveller),
            );
        }
        // No two outboxes share a source cell, so indices keep the order within a source cell.
        order.clear();
        for (place, traveller) in foreign.iter().enumerate() {
            order.push((traveller.source, place as u32));
            let code = self.code(grid, traveller.simulator.position);
            self.starts[usize::from(code)] += 1;
        }
        order.sort_unstable();
    }

    /// Moves the sorted simulators from the scratch memory into the tile, by exchange of buffers.
    pub(crate) fn settle(&mut self, scratch: &mut Scratch<P, F>) {
        std::mem::swap(&mut self.simulators, &mut scratch.sorted);
    }

    /// Replaces the simulators of the tile by a list sorted by cell, with the cell number of each.
    pub(crate) fn take(&mut self, members: &[(u16, SimulatorOf<P, F>)]) {
        self.simulators = Vec::with_capacity(members.len() + members.len() / 24);
        self.simulators
            .extend(members.iter().map(|(_, simulator)| *simulator));
        self.starts.fill(0);
        for (code, _) in members {
            self.starts[usize::from(*code) + 1] += 1;
        }
        let mut sum = 0;
        for start in &mut self.starts {
            sum += *start;
            *start = sum;
        }
    }

    /// Returns the simulators of a cell in a sorted tile, given the cell's number in the tile.
    #[inline]
    pub(crate) fn members(&self, cell: usize) -> &[SimulatorOf<P, F>] {
        &self.simulators[self.starts[cell] as usize..self.starts[cell + 1] as usize]
    }

    /// Returns the simulators of a cell in a sorted tile for changes, given the cell's number in
    /// the tile.
    #[inline]
    pub(crate) fn members_mut(&mut self, cell: usize) -> &mut [SimulatorOf<P, F>] {
        &mut self.simulators[self.starts[cell] as usize..self.starts[cell + 1] as usize]
    }

    pub(crate) fn bytes(&self) -> usize {
        size_of::<Self>()
            + self.simulators.capacity() * size_of::<SimulatorOf<P, F>>()
            + 2 * self.codes.capacity()
            + 4 * (self.starts.capacity() + self.lines.capacity())
            + self.log.capacity() * size_of::<Collision>()
            + self.counts.capacity() * size_of::<CellCount>()
            + 8 * self.split_cells.capacity()
    }
}

/// Returns the number in a tile, located at `place`, of the cell that contains a position.
#[inline(always)]
pub(crate) fn code<P: ParticleModel>(
    grid: &Grid<P::Space>,
    place: &TilePlace<P::Space>,
    position: VectorOf<P>,
) -> u16 {
    let column = |axis| {
        grid.column(axis, position[axis])
            .wrapping_sub(place.first[axis])
    };
    let line = if <P::Space as Space>::DIMENSION == 2 {
        column(1)
    } else {
        column(1) + place.sides[1] * column(2)
    };
    (column(0) + place.sides[0] * line) as u16
}
