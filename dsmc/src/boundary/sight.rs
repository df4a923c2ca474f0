//! Windows of the local packing fraction near obstacles, cut to the cells in the line of sight of
//! their central cell.

use nalgebra::Vector2;
use stosszahl_model::Space;

use super::cut_cells::CutCells;
use super::obstacles::ObstacleMap;
use crate::density::{CellLayers, CutWindow, CutWindows, WindowCentre, WindowMember};
use crate::grid::Grid;

type Point = Vector2<f64>;

/// Builds the density windows that obstacles cut, `reach` cells wide on each side. Windows end at
/// the faces along `bounded` axes. `None` if windows are single cells.
pub(super) fn cut_windows<S: Space>(
    cuts: &CutCells,
    obstacles: &ObstacleMap,
    grid: &Grid<S>,
    reach: [usize; 3],
    bounded: [bool; 3],
) -> Option<CutWindows> {
    if reach == [0; 3] {
        return None;
    }
    let neighbours = SightLines {
        counts: [grid.counts()[0], grid.counts()[1]].map(i64::from),
        grid,
        width: Point::new(grid.width()[0], grid.width()[1]),
        reach: [reach[0], reach[1]].map(|reach| reach as i64),
        bounded: [bounded[0], bounded[1]],
        cuts,
        obstacles,
    };
    let mut near = vec![false; grid.counts()[0] as usize * grid.counts()[1] as usize];
    let number = |[x, y]: [u32; 2]| (x + grid.counts()[0] * y) as usize;
    for cell in cuts.cells() {
        for (other, _) in neighbours.cells_around(cell.cell_coordinates()) {
            near[number(other)] = true;
        }
    }
    let all = (0..grid.counts()[1]).flat_map(|y| (0..grid.counts()[0]).map(move |x| [x, y]));
    let windows = all
        .filter(|&cell| near[number(cell)])
        .flat_map(|cell| neighbours.windows(cell));
    let layers = CellLayers {
        count: grid.counts()[2] as usize,
        reach: reach[2],
        bounded: bounded[2],
    };
    Some(CutWindows::new(windows.collect(), cuts.sub_cells(), layers))
}

/// Lines of sight from a cell to the cells in its window of the local packing fraction.
struct SightLines<'a, S: Space> {
    grid: &'a Grid<S>,
    counts: [i64; 2],
    width: Point,
    reach: [i64; 2],
    bounded: [bool; 2],
    cuts: &'a CutCells,
    obstacles: &'a ObstacleMap,
}

impl<S: Space> SightLines<'_, S> {
    /// Returns the cells in the window around a cell, each with the numbers of boxes by which its
    /// periodic image is displaced.
    fn cells_around(&self, [x, y]: [u32; 2]) -> impl Iterator<Item = ([u32; 2], [i64; 2])> + '_ {
        let [along_x, along_y] = self.reach.map(|reach| -reach..=reach);
        let steps = along_y.flat_map(move |up| along_x.clone().map(move |right| [right, up]));
        steps.filter_map(move |step| {
            let at = [i64::from(x) + step[0], i64::from(y) + step[1]];
            let boxes = [0, 1].map(|axis| at[axis].div_euclid(self.counts[axis]));
            let is_outside = (0..2).any(|axis| self.bounded[axis] && boxes[axis] != 0);
            let cell = [0, 1].map(|axis| (at[axis] - boxes[axis] * self.counts[axis]) as u32);
            (!is_outside).then_some((cell, boxes))
        })
    }

    /// Returns the sub-cells of a cell, `None` for one that is not split, each with a point inside
    /// \[length\].
    fn parts(&self, cell: [u32; 2]) -> Vec<(Option<usize>, Point)> {
        let [x, y] = cell;
        match self.cuts.get([x, y, 0]) {
            None => {
                let middle = Point::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
                vec![(None, middle.component_mul(&self.width))]
            }
            Some(cut) => (0..cut.count())
                .map(|part| (cut.is_split().then_some(part), cut.inside(part)))
                .collect(),
        }
    }

    /// Returns the density windows of a cell or its sub-cells that obstacles cut; empty if the cell
    /// sees its whole window.
    fn windows(&self, cell: [u32; 2]) -> Vec<CutWindow<WindowMember>> {
        let windows = self.parts(cell).into_iter().filter_map(|(part, from)| {
            let mut members = Vec::new();
            let mut sees_all = true;
            for (other, boxes) in self.cells_around(cell) {
                let (shift, images) = (self.shift(boxes), self.images(boxes));
                for (sub_cell, inside) in self.parts(other) {
                    let is_here = (other, sub_cell) == (cell, part);
                    let is_seen = is_here || self.obstacles.sees([from, inside + shift], &images);
                    sees_all &= is_seen && sub_cell.is_none();
                    if is_seen {
                        members.push(WindowMember {
                            cell: other,
                            sub_cell,
                        });
                    }
                }
            }
            let centre = match (part, self.cuts.get([cell[0], cell[1], 0])) {
                (Some(part), Some(cut)) => WindowCentre::SubCell(cut.number(part)),
                _ => WindowCentre::Cell(cell),
            };
            (!sees_all).then_some(CutWindow { centre, members })
        });
        windows.collect()
    }

    /// Returns the displacement to the periodic image `boxes` box lengths away along each axis
    /// \[length\].
    fn shift(&self, boxes: [i64; 2]) -> Point {
        let images = self.grid.domain().images();
        let image = images.image([boxes[0] as f64, boxes[1] as f64, 0.0]);
        Point::new(image.position[0], image.position[1])
    }

    /// Returns the shifts that bring each part of a line of sight to a periodic image back into the
    /// box \[length\].
    fn images(&self, [x, y]: [i64; 2]) -> Vec<Point> {
        let mut images = vec![[0, 0], [-x, 0], [0, -y], [-x, -y]];
        images.sort_unstable();
        images.dedup();
        images.into_iter().map(|boxes| self.shift(boxes)).collect()
    }
}
