//! Sorting of disks by the cells of the cell lists, and storage of their records in that order:
//! disks near each other in the box are near in memory.

use nalgebra::{Vector2, vector};
use stosszahl_model::threads::{self, each_of};
use stosszahl_model::{Domain, Field, Plane, memory};

use crate::cells::CellLists;
use crate::disk::DiskSystem;
use crate::grid_hierarchy::GridHierarchy;
use crate::motion::FlightMotion;
use crate::record::DiskRecord;
use crate::sliding_rows::SlidingRows;

/// Fills an empty vector with the values `make(i)` for i from 0 to `count - 1`, on this thread or
/// on all threads of the current pool.
pub(crate) fn fill<T: Clone + Send>(
    empty: &mut Vec<T>,
    count: usize,
    shared: bool,
    make: impl Fn(usize) -> T + Sync,
) {
    if !shared || count == 0 {
        empty.extend((0..count).map(make));
        return;
    }
    empty.resize(count, make(0));
    let length = threads::piece(count);
    each_of(true, empty.chunks_mut(length), |number, piece| {
        for (index, place) in (number * length..).zip(piece) {
            *place = make(index);
        }
    });
}

/// Sorts `count` bodies by their cells: returns pairs of cell number and body index. Bodies in one
/// cell are sorted by position, so that the result does not depend on their numbering.
fn by_cell(
    count: usize,
    shared: bool,
    cell: &(dyn Fn(usize) -> u32 + Sync),
    position: &(dyn Fn(usize) -> Vector2<f64> + Sync),
) -> Vec<(u32, u32)> {
    let mut order = Vec::new();
    fill(&mut order, count, shared, |index| {
        (cell(index), index as u32)
    });
    if shared {
        threads::sort(&mut order);
    } else {
        order.sort_unstable();
    }
    let by_position = |cell: &mut [(u32, u32)]| {
        cell.sort_by(|a, b| {
            let (a, b) = (position(a.1 as usize), position(b.1 as usize));
            (a[0].total_cmp(&b[0])).then(a[1].total_cmp(&b[1]))
        });
    };
    // Pieces for threads end where cells do.
    let length = if shared {
        threads::piece(count)
    } else {
        count.max(1)
    };
    let mut pieces = Vec::new();
    let mut rest = &mut order[..];
    while !rest.is_empty() {
        let mut end = length.min(rest.len());
        while end < rest.len() && rest[end].0 == rest[end - 1].0 {
            end += 1;
        }
        let (piece, others) = rest.split_at_mut(end);
        pieces.push(piece);
        rest = others;
    }
    each_of(shared, pieces.into_iter(), |_, piece| {
        piece.chunk_by_mut(|a, b| a.0 == b.0).for_each(by_position);
    });
    order
}

/// Options for building the cell lists of disks: kinds of grids allowed, and number of threads.
#[derive(Clone, Copy, Default)]
pub(crate) struct GridOptions {
    /// True if disks have different radii: a hierarchy of several grids is allowed then.
    pub(crate) unequal: bool,
    /// True if cells of a dilute gas may be wider than usual ([`CellLists::wide_ones`]). False
    /// around obstacles, whose contact times are computed from squares of distances.
    pub(crate) may_be_wide: bool,
    /// True if all threads of the current pool sort the disks; false for this thread alone.
    pub(crate) shared: bool,
}

impl<F: Field<Plane>> DiskSystem<F> {
    /// Creates the cell lists of `count` disks and sorts the disks in memory. `body` gives position
    /// inside the box, velocity and radius. Also returns each disk's index in the state.
    pub(crate) fn new(
        domain: &Domain<Plane>,
        largest_radius: f64,
        count: usize,
        body: &(dyn Fn(usize) -> (Vector2<f64>, Vector2<f64>, f64) + Sync),
        motion: FlightMotion<F>,
        options: GridOptions,
    ) -> (Self, Vec<u32>) {
        let GridOptions {
            unequal, shared, ..
        } = options;
        let (lengths, periodic) = (
            domain.lengths(),
            [0, 1].map(|axis| domain.is_periodic(axis)),
        );
        let largest = 2.0 * largest_radius;
        let wide = if options.may_be_wide
            && !F::SHEARED
            && CellLists::may_be_wide(lengths, largest, count)
        {
            let places: Vec<Vector2<f64>> = (0..count).map(|index| body(index).0).collect();
            CellLists::wide_ones(lengths, periodic, largest, &places)
        } else {
            None
        };
        let (cells, coarse) = match wide {
            Some(cells) => (cells, Vec::new()),
            None => GridHierarchy::grids(lengths, periodic, largest, count, unequal && !F::SHEARED),
        };
        let place = |index: usize| {
            let (cell, _) = cells.locate(body(index).0);
            cells.place(cell, 1, 1) as u32
        };
        let order = by_cell(count, shared, &place, &|index| body(index).0);
        let levels = (!coarse.is_empty()).then(|| {
            let radii = order.iter().map(|&(_, index)| body(index as usize).2);
            GridHierarchy::new(coarse, &cells, radii)
        });
        let mut disks = Self {
            all: memory::reserved(count),
            motion,
            rows: SlidingRows::none(),
            cells,
            levels,
            recounts: 0,
        };
        if let Some(shear) = domain.images().shear() {
            let rate = disks.motion.shear_rate();
            disks.rows = SlidingRows::new(&disks.cells, rate, shear.offset);
        }
        fill(&mut disks.all, count, shared, |who| {
            let (position, velocity, _) = body(order[who].1 as usize);
            let (cell, offset) = disks.cells.locate(position);
            let flow = vector![disks.rows.flow(offset[1]), 0.0];
            DiskRecord::new(
                cell,
                offset,
                if F::SHEARED {
                    velocity + flow
                } else {
                    velocity
                },
            )
        });
        for who in 0..count as u32 {
            disks.enter(who);
        }
        (disks, order.into_iter().map(|(_, index)| index).collect())
    }
}
