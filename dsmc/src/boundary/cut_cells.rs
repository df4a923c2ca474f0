//! Cut cells: cells that obstacles cut, divided into sub-cells of their free area.
//!
//! A body thinner than a cell, or one that cuts it, may hide some particles of the cell from
//! others, which must not collide. So the free area of such a cell is divided into **sub-cells**
//! within which all points see each other. The split cells of SPARTA (Plimpton et al.,
//! Phys. Fluids 31, 086101 (2019), doi:10.1063/1.5108534) serve the same purpose. Pairs are drawn
//! within a sub-cell, at the rate of its own number of particles and its own area. The number of
//! pairs of a uniform gas is then that of the free area, on each side of a body.
//!
//! * **Division**: the cell is halved along an edge of a body that crosses it, and each part
//!   again, until no edge crosses a part. Each part is convex, so that no straight body is between
//!   two of its points. Parts are then united where no edge crosses their convex hull.
//! * **Disks** hide the region behind an inscribed polygon that is at most a tenth of a cell from
//!   their circle.
//! * **Area**: exact between straight edges; near disks and rounded corners of the free area of
//!   centres the error is below `1e-3` of a cell.
//!
//! Areas are those of the centres of particles of the mean radius. A sub-cell without room for them
//! has no collisions.

use nalgebra::Vector2;
use stosszahl_model::Space;

use super::convex::{ConvexPolygon, CutLine};
use super::obstacles::{ClosedRegion, ObstacleMap};
use crate::grid::Grid;
use crate::parameters::DsmcError;

/// Least free fraction of a cell or sub-cell that contains simulators: rounding may leave one just
/// beyond a wall that cuts the cell.
pub(super) const LEAST_ROOM: f64 = 1e-3;

/// Largest number of convex parts into which the edges of obstacles may divide a cell.
const MOST_PARTS: usize = 256;

/// Number of successive quarterings of a cell part in the measurement of its free area, after which
/// the boundary counts as straight.
const DEPTH: u32 = 5;

/// Least length of an edge inside a part of a cell, in cell widths, for which the edge divides the
/// part.
const THIN: f64 = 1e-11;

/// Largest number of halvings of a cell tried when the error message suggests a smaller cell size.
const FINEST: u32 = 8;

type Point = Vector2<f64>;

/// Cells that obstacles cut, with a table that finds them by column and row.
pub(crate) struct CutCells {
    /// Index of each cell of the grid in the list `cells` plus one; 0 for cells that no obstacle
    /// cuts.
    indices: Vec<u32>,
    columns: u32,
    cells: Vec<CutCell>,
    /// Number of sub-cells, summed over all cells that obstacles split.
    sub_cells: usize,
}

/// Cell that obstacles cut, with its free area and its sub-cells.
pub(crate) struct CutCell {
    /// Column and row of the cut cell in the grid.
    at: [u32; 2],
    /// Lower left and upper right corner of the cut cell, extended where a moving wall recedes
    /// beyond the box \[length\].
    corners: [Point; 2],
    /// Indices of the obstacles that may overlap the cut cell.
    near: Vec<usize>,
    /// Fraction of the cell's area that is open to particle centres, 0 to 1.
    room: f64,
    nodes: Vec<CutNode>,
    /// Convex parts into which edges of obstacles divide the cell, each with the index of its
    /// sub-cell.
    parts: Vec<(ConvexPolygon, usize)>,
    sub_cells: Vec<SubCell>,
    /// Index of the cell's first sub-cell among the sub-cells of all split cells.
    first: usize,
}

/// Node of the binary tree that finds the part of a cut cell at a position: a line, and the
/// branches behind and in front of it.
struct CutNode {
    line: CutLine,
    sides: [CutBranch; 2],
}

#[derive(Clone, Copy)]
enum CutBranch {
    Node(usize),
    Part(usize),
}

/// Sub-cell: part of the free area of a cut cell within which all points are in line of sight.
struct SubCell {
    /// Free area of the sub-cell over the area of a whole cell, from 0 to 1.
    share: f64,
    /// Point in the sub-cell that is far from all obstacles, from which lines of sight start
    /// \[length\].
    inside: Point,
    /// Distance of the point `inside` from the region that obstacles close to particle centres
    /// \[length\].
    gap: f64,
}

/// Rectangle that walls leave to particle centres: its lower left and upper right corner
/// \[length\].
pub(super) type CentreLimits = [Point; 2];

impl CutCells {
    /// Finds the cells cut by obstacles and divides them into sub-cells, for particle centres at
    /// least `clearance` from obstacles \[length\]. `beyond` holds the largest displacement of each
    /// wall out of the box \[length\].
    ///
    /// # Errors [`DsmcError::CutCell`] if a cell would be divided into too many parts.
    pub(super) fn new<S: Space>(
        obstacles: &ObstacleMap,
        grid: &Grid<S>,
        clearance: f64,
        limits: CentreLimits,
        beyond: [Point; 2],
    ) -> Result<Self, DsmcError> {
        let [columns, rows, _] = grid.counts();
        let width = Point::new(grid.width()[0], grid.width()[1]);
        let edges = obstacles.edges(0.1 * width.min());
        let mut all = Self {
            indices: vec![0; (columns * rows) as usize],
            columns,
            cells: Vec::new(),
            sub_cells: 0,
        };
        let mut refused: Option<(Point, u32)> = None;
        for y in 0..rows {
            for x in 0..columns {
                let mut low = Point::new(f64::from(x), f64::from(y)).component_mul(&width);
                let mut high = low + width;
                for (axis, at, count) in [(0, x, columns), (1, y, rows)] {
                    if at == 0 {
                        low[axis] -= beyond[0][axis];
                    }
                    if at + 1 == count {
                        high[axis] += beyond[1][axis];
                    }
                }
                let Some(near) = obstacles.near([low, high], clearance) else {
                    continue;
                };
                let cell = CutCell::new([x, y], [low, high], obstacles, near, &edges);
                if let Some(mut cell) = cell {
                    cell.measure(obstacles, clearance, limits, width);
                    if cell.is_split() {
                        cell.first = all.sub_cells;
                        all.sub_cells += cell.sub_cells.len();
                    }
                    all.cells.push(cell);
                    all.indices[(x + columns * y) as usize] = all.cells.len() as u32;
                } else {
                    let halvings = halvings_that_do([low, high], &edges);
                    if refused.is_none_or(|(_, most)| halvings > most) {
                        refused = Some((low, halvings));
                    }
                }
            }
        }
        match refused {
            Some((low, halvings)) => Err(DsmcError::CutCell {
                place: low.into(),
                width: width.min(),
                most: MOST_PARTS,
                enough: width.min() / f64::from(1_u32 << halvings),
            }),
            None => Ok(all),
        }
    }

    /// Recomputes the free areas of cut cells that moving walls now cut differently: `old` and
    /// `new` are the limits for particle centres.
    pub(super) fn move_walls(
        &mut self,
        obstacles: &ObstacleMap,
        clearance: f64,
        width: Point,
        [old, new]: [CentreLimits; 2],
    ) {
        for cell in &mut self.cells {
            let clipped = |limits: CentreLimits| {
                [
                    limits[0].sup(&cell.corners[0]),
                    limits[1].inf(&cell.corners[1]),
                ]
            };
            if clipped(old) != clipped(new) {
                cell.measure(obstacles, clearance, new, width);
            }
        }
    }

    /// Returns the cut cell at a column and row of the grid; `None` if no obstacle cuts that cell.
    #[inline]
    pub(crate) fn get(&self, [x, y, _]: [u32; 3]) -> Option<&CutCell> {
        let index = self.indices[(x + self.columns * y) as usize] as usize;
        index.checked_sub(1).map(|index| &self.cells[index])
    }

    /// Returns the cut cell at a column and row of the grid if it has several sub-cells; `None`
    /// otherwise.
    #[inline]
    pub(crate) fn split(&self, at: [u32; 3]) -> Option<&CutCell> {
        self.get(at).filter(|cell| cell.is_split())
    }

    /// Returns all cells that obstacles cut.
    pub(super) fn cells(&self) -> &[CutCell] {
        &self.cells
    }

    /// Returns the number of sub-cells of all cells that obstacles split.
    pub(super) fn sub_cells(&self) -> usize {
        self.sub_cells
    }

    /// Returns the memory that the cut cells occupy \[bytes\].
    pub(super) fn memory_bytes(&self) -> usize {
        4 * self.indices.capacity() + self.cells.iter().map(CutCell::memory_bytes).sum::<usize>()
    }
}

impl CutCell {
    /// Divides one cell at the edges of obstacles into convex parts and unites these to sub-cells;
    /// `None` if there are too many parts. Free areas are measured later.
    fn new(
        at: [u32; 2],
        corners: [Point; 2],
        obstacles: &ObstacleMap,
        near: Vec<usize>,
        edges: &[[Point; 2]],
    ) -> Option<Self> {
        let edges = edges_in(corners, edges);
        let mut division = CellDivision::default();
        let all = ConvexPolygon::rectangle(corners[0], corners[1]);
        let thin = THIN * (corners[1] - corners[0]).min();
        division.divide(all, &edges, thin)?;
        let CellDivision { nodes, parts } = division;
        let bodies = ClosedRegion::new(obstacles, &near, 0.0);
        let free = |part: &ConvexPolygon| bodies.free_area(part, DEPTH, &mut |_, _| ()) > 0.0;
        let is_free: Vec<bool> = parts.iter().map(free).collect();
        let (sub_cells, count) = unite_parts(&parts, &is_free, &edges, thin);
        let sub_cell = || SubCell {
            share: 0.0,
            inside: 0.5 * (corners[0] + corners[1]),
            gap: f64::NEG_INFINITY,
        };
        Some(Self {
            at,
            corners,
            near,
            room: 0.0,
            nodes,
            parts: parts.into_iter().zip(sub_cells).collect(),
            sub_cells: (0..count).map(|_| sub_cell()).collect(),
            first: 0,
        })
    }

    /// Measures the free area of each sub-cell of the cell, between walls with the given limits for
    /// particle centres.
    fn measure(
        &mut self,
        obstacles: &ObstacleMap,
        clearance: f64,
        limits: CentreLimits,
        width: Point,
    ) {
        let bodies = ClosedRegion::new(obstacles, &self.near, clearance);
        for sub_cell in &mut self.sub_cells {
            (sub_cell.share, sub_cell.gap) = (0.0, f64::NEG_INFINITY);
        }
        let low = limits[0].sup(&self.corners[0]);
        let high = limits[1].inf(&self.corners[1]);
        let sides = [
            (low, Point::x()),
            (low, Point::y()),
            (high, -Point::x()),
            (high, -Point::y()),
        ];
        let lines = sides.map(|(point, normal)| CutLine::facing(point, normal));
        for (part, sub_cell) in &self.parts {
            let Some(sub_cell) = self.sub_cells.get_mut(*sub_cell) else {
                continue;
            };
            let within = (lines.iter()).fold(part.clone(), |part, line| part.in_front_of(line));
            let area = bodies.free_area(&within, DEPTH, &mut |gap, point| {
                if gap > sub_cell.gap {
                    (sub_cell.gap, sub_cell.inside) = (gap, point);
                }
            });
            sub_cell.share += area / width.product();
        }
        self.room = self.sub_cells.iter().map(|one| one.share).sum();
    }

    /// Returns true if an obstacle divides the cell into several sub-cells without line of sight.
    #[inline]
    pub(crate) fn is_split(&self) -> bool {
        self.sub_cells.len() > 1
    }

    /// Returns column and row of the cut cell in the grid.
    pub(super) fn cell_coordinates(&self) -> [u32; 2] {
        self.at
    }

    /// Returns the fraction of the cell's area that is open to particle centres, 0 to 1.
    #[inline]
    pub(crate) fn room(&self) -> f64 {
        self.room
    }

    /// Returns the number of sub-cells of the cell.
    pub(crate) fn count(&self) -> usize {
        self.sub_cells.len()
    }

    /// Returns the free area of a sub-cell over the area of a whole cell; 0 where no particle
    /// centre fits.
    #[inline]
    pub(crate) fn free_share(&self, sub_cell: usize) -> f64 {
        match self.sub_cells.get(sub_cell) {
            Some(one) if one.share > 0.0 => one.share.max(LEAST_ROOM),
            _ => 0.0,
        }
    }

    /// Returns the index of a sub-cell of the cell among the sub-cells of all split cells.
    #[inline]
    pub(crate) fn number(&self, sub_cell: usize) -> usize {
        self.first + sub_cell
    }

    /// Returns a point in a sub-cell of the cell, far from all obstacles \[length\].
    pub(super) fn inside(&self, sub_cell: usize) -> Point {
        self.sub_cells[sub_cell].inside
    }

    /// Returns the index of the sub-cell that contains a position; [`Self::count`] for a position
    /// that rounding has put inside an obstacle.
    #[inline]
    pub(crate) fn sub_cell_at(&self, place: [f64; 2]) -> usize {
        let point = Point::from(place);
        let mut branch = if self.nodes.is_empty() {
            CutBranch::Part(0)
        } else {
            CutBranch::Node(0)
        };
        loop {
            match branch {
                CutBranch::Node(node) => {
                    let node = &self.nodes[node];
                    branch = node.sides[usize::from(node.line.height(point) >= 0.0)];
                }
                CutBranch::Part(part) => return self.parts[part].1,
            }
        }
    }

    fn memory_bytes(&self) -> usize {
        let corners = self
            .parts
            .iter()
            .map(|(part, _)| size_of_val(part.corners()));
        size_of::<Self>()
            + self.nodes.capacity() * size_of::<CutNode>()
            + self.parts.capacity() * size_of::<(ConvexPolygon, usize)>()
            + self.sub_cells.capacity() * size_of::<SubCell>()
            + 8 * self.near.capacity()
            + corners.sum::<usize>()
    }
}

/// Division of a cell at the edges of obstacles into convex parts, as far as it has come: parts and
/// tree of cuts.
#[derive(Default)]
struct CellDivision {
    nodes: Vec<CutNode>,
    parts: Vec<ConvexPolygon>,
}

impl CellDivision {
    /// Divides a region recursively at the edges of obstacles; returns its branch of the tree, or
    /// `None` if there are too many parts.
    fn divide(
        &mut self,
        region: ConvexPolygon,
        edges: &[[Point; 2]],
        thin: f64,
    ) -> Option<CutBranch> {
        // Cutting along the longest edge first leaves fewer parts.
        let lengths = edges
            .iter()
            .map(|&edge| (edge, region.length_inside(edge, thin)));
        let longest = lengths.max_by(|a, b| a.1.total_cmp(&b.1));
        let Some((edge, _)) = longest.filter(|(_, length)| *length > thin) else {
            self.parts.push(region);
            return (self.parts.len() <= MOST_PARTS).then(|| CutBranch::Part(self.parts.len() - 1));
        };
        let line = CutLine::through(edge);
        let node = self.nodes.len();
        self.nodes.push(CutNode {
            line,
            sides: [CutBranch::Node(node); 2],
        });
        let [behind, front] = region.cut(&line);
        let sides = [
            self.divide(behind, edges, thin)?,
            self.divide(front, edges, thin)?,
        ];
        self.nodes[node].sides = sides;
        Some(CutBranch::Node(node))
    }
}

/// Unites convex parts to sub-cells where no edge of an obstacle crosses their common hull. Returns
/// the sub-cell index of each part and the number of sub-cells, which is also the index of solid
/// parts.
fn unite_parts(
    parts: &[ConvexPolygon],
    is_free: &[bool],
    edges: &[[Point; 2]],
    thin: f64,
) -> (Vec<usize>, usize) {
    let mut groups: Vec<Vec<Point>> = Vec::new();
    let group_of = |(part, &is_free): (&ConvexPolygon, &bool)| {
        if !is_free {
            return usize::MAX;
        }
        let joined = |group: &Vec<Point>| [group, part.corners()].concat();
        let sees = |group: &Vec<Point>| {
            let hull = ConvexPolygon::hull(&joined(group));
            let mut edges = edges.iter();
            edges.all(|&edge| hull.length_inside(edge, thin) <= thin)
        };
        let group = groups.iter().position(sees).unwrap_or_else(|| {
            groups.push(Vec::new());
            groups.len() - 1
        });
        groups[group] = joined(&groups[group]);
        group
    };
    let of_parts: Vec<usize> = parts.iter().zip(is_free).map(group_of).collect();
    let count = groups.len();
    let of_parts = of_parts.into_iter().map(|group| group.min(count));
    (of_parts.collect(), count)
}

/// Returns the edges of obstacles whose bounding boxes overlap the rectangle between two corners.
fn edges_in(corners: [Point; 2], edges: &[[Point; 2]]) -> Vec<[Point; 2]> {
    let meets = |[from, to]: &&[Point; 2]| {
        (0..2).all(|axis| {
            from[axis].max(to[axis]) >= corners[0][axis]
                && from[axis].min(to[axis]) <= corners[1][axis]
        })
    };
    edges.iter().filter(meets).copied().collect()
}

/// Returns the least number of halvings of a cell after which no piece has too many convex parts;
/// at most [`FINEST`].
fn halvings_that_do(corners: [Point; 2], edges: &[[Point; 2]]) -> u32 {
    let near = edges_in(corners, edges);
    let do_all = |halvings: &u32| {
        let count = 1_u32 << halvings;
        let width = (corners[1] - corners[0]) / f64::from(count);
        let mut places = (0..count).flat_map(|y| (0..count).map(move |x| [x, y]));
        places.all(|at| {
            let low = corners[0] + width.component_mul(&Point::new(at[0].into(), at[1].into()));
            let corners = [low, low + width];
            let near = edges_in(corners, &near);
            let mut division = CellDivision::default();
            let region = ConvexPolygon::rectangle(corners[0], corners[1]);
            division.divide(region, &near, THIN * width.min()).is_some()
        })
    };
    (1..FINEST).find(do_all).unwrap_or(FINEST)
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::vector;
    use rand::RngExt;
    use std::f64::consts::PI;
    use stosszahl_model::random::{Purpose, Streams};
    use stosszahl_model::walls::{Obstacle, ObstacleShape};
    use stosszahl_model::{Domain, Plane, Rebound};

    const SIDES: [f64; 2] = [12.0, 9.0];

    fn standing(outlines: Vec<ObstacleShape>) -> (ObstacleMap, Grid<Plane>) {
        let law = Rebound::Restitutive {
            restitution: 1.0,
            slip: 1.0,
        };
        let obstacle = |outline| Obstacle::new(outline, law).expect("an obstacle");
        let all: Vec<Obstacle> = outlines.into_iter().map(obstacle).collect();
        let domain = Domain::periodic(SIDES.into()).expect("a box");
        let standing = ObstacleMap::new(&all, &domain, 0.5).expect("inside");
        let grid = Grid::new(domain, [6, 6, 1], 1000, 100, 0.0);
        (standing.expect("some"), grid)
    }

    fn cuts(obstacles: &ObstacleMap, grid: &Grid<Plane>, clearance: f64) -> CutCells {
        let limits = [Point::zeros(), SIDES.into()];
        CutCells::new(obstacles, grid, clearance, limits, [Point::zeros(); 2]).expect("few parts")
    }

    fn points(corners: &[[f64; 2]]) -> Vec<Point> {
        corners.iter().map(|&corner| corner.into()).collect()
    }

    /// Outlines of straight edges: a comb, a wedge, a star, a plate that ends in a cell, and two
    /// plates with a slit between them.
    fn straight() -> Vec<ObstacleShape> {
        let comb = (0..9).map(|tooth| {
            let x = 1.0 + 0.31 * f64::from(tooth);
            [x, if tooth % 2 == 0 { 0.7 } else { 2.9 }]
        });
        let star = (0..10).map(|corner| {
            let angle = PI * f64::from(corner) / 5.0;
            let radius = if corner % 2 == 0 { 1.4 } else { 0.5 };
            [8.3 + radius * angle.cos(), 2.6 + radius * angle.sin()]
        });
        vec![
            ObstacleShape::Polyline {
                points: points(&comb.collect::<Vec<_>>()),
            },
            ObstacleShape::Polygon {
                points: points(&[[0.2, 5.0], [3.0, 5.1], [0.2, 8.0]]),
            },
            ObstacleShape::Polygon {
                points: points(&star.collect::<Vec<_>>()),
            },
            ObstacleShape::Segment {
                ends: [vector![5.0, 5.2], vector![6.7, 8.3]],
            },
            ObstacleShape::Polyline {
                points: points(&[[8.0, 7.3], [9.4, 7.3]]),
            },
            ObstacleShape::Polyline {
                points: points(&[[9.6, 7.3], [11.0, 7.3], [11.0, 6.2]]),
            },
        ]
    }

    /// Points of one sub-cell see each other, every free point has a sub-cell, and area fractions
    /// match random points. 2e5 points, some 5500 in a cell; tolerance: z = 5 binomial standard
    /// errors for each fraction.
    #[test]
    fn points_of_a_sub_cell_see_each_other() {
        let (obstacles, grid) = standing(straight());
        let cuts = cuts(&obstacles, &grid, 0.0);
        let mut stream = Streams::new(1, 0).stream_at(Purpose::Placement, [0, 0]);
        let mut found = std::collections::BTreeMap::new();
        let mut tried = std::collections::BTreeMap::new();
        for _ in 0..200_000 {
            let point = vector![
                SIDES[0] * stream.random::<f64>(),
                SIDES[1] * stream.random::<f64>()
            ];
            let cell = grid.cell_at(point);
            let Some(cut) = cuts.get(cell) else { continue };
            *tried.entry(cell).or_insert(0.0) += 1.0;
            if obstacles.overlapped(point.into(), 0.0).is_some() {
                continue;
            }
            let sub_cell = cut.sub_cell_at(point.into());
            assert!(cut.free_share(sub_cell) > 0.0, "{point}");
            found
                .entry((cell, sub_cell))
                .or_insert_with(Vec::new)
                .push(point);
        }
        let mut hidden = 0;
        for ((cell, sub_cell), points) in &found {
            for pair in points.windows(2) {
                assert!(
                    obstacles.sees([pair[0], pair[1]], &[Point::zeros()]),
                    "{cell:?} {sub_cell} {pair:?}"
                );
            }
            let (share, count) = (
                cuts.get(*cell).map_or(0.0, |cut| cut.free_share(*sub_cell)),
                tried[cell],
            );
            let error = 5.0 * (share * (1.0 - share) / count).sqrt();
            let expected = points.len() as f64 / count;
            assert!(
                (share - expected).abs() <= error + 1e-9,
                "{cell:?} {sub_cell}: {share} {expected}"
            );
            let first = &found
                .iter()
                .find(|((other, _), _)| other == cell)
                .expect("one")
                .1[0];
            hidden += usize::from(!obstacles.sees([*first, points[0]], &[Point::zeros()]));
        }
        // The test needs hidden pairs of points.
        assert!(hidden > 10, "{hidden}");
    }

    /// Free areas of all cells add up to that of the box: exactly between straight edges, and to
    /// 1e-3 of a cell for each of some twenty cells around disks and rounded corners.
    #[test]
    fn areas_add_up() {
        let whole = SIDES[0] * SIDES[1];
        let room = |outlines: Vec<ObstacleShape>, clearance: f64| {
            let (obstacles, grid) = standing(outlines);
            let cuts = cuts(&obstacles, &grid, clearance);
            let taken: f64 = cuts.cells.iter().map(|cell| 1.0 - cell.room).sum();
            whole - taken * 3.0
        };
        let star = 5.0 * 1.4 * 0.5 * (PI / 5.0).sin();
        // Half of base times height: (2.8, 0.1) x (0, 3).
        let wedge = 0.5 * 2.8 * 3.0;
        let exact = whole - wedge - star;
        let found = room(straight(), 0.0);
        assert!((found - exact).abs() < 1e-9, "{found} {exact}");
        let disk = || ObstacleShape::Circle {
            centre: vector![6.3, 4.1],
            radius: 2.2,
        };
        let small = || ObstacleShape::Circle {
            centre: vector![1.1, 1.2],
            radius: 0.3,
        };
        for clearance in [0.0, 0.4] {
            let exact: f64 = [2.2, 0.3]
                .iter()
                .map(|r| PI * (r + clearance) * (r + clearance))
                .sum();
            let found = whole - room(vec![disk(), small()], clearance);
            assert!((found - exact).abs() < 20.0 * 3e-3, "{found} {exact}");
        }
        let plate = ObstacleShape::Segment {
            ends: [vector![2.3, 2.9], vector![7.7, 6.1]],
        };
        let length = 5.4_f64.hypot(3.2);
        let exact = 2.0 * 0.4 * length + PI * 0.16;
        let found = whole - room(vec![plate], 0.4);
        assert!((found - exact).abs() < 4.0 * 3e-3, "{found} {exact}");
    }

    /// Points on opposite sides of a disk are in different sub-cells.
    #[test]
    fn a_disc_hides_what_is_behind_it() {
        let disk = ObstacleShape::Circle {
            centre: vector![5.0, 3.75],
            radius: 0.5,
        };
        let (obstacles, grid) = standing(vec![disk]);
        let cuts = cuts(&obstacles, &grid, 0.0);
        let cut = cuts
            .split(grid.cell_at(vector![5.0, 3.75]))
            .expect("a split cell");
        for turn in 0..24 {
            let angle = PI * f64::from(turn) / 24.0;
            let arm = vector![angle.cos(), angle.sin()] * 0.6;
            let [one, other] =
                [arm, -arm].map(|arm| cut.sub_cell_at((vector![5.0, 3.75] + arm).into()));
            assert_ne!(one, other, "{turn}");
        }
        assert!(cut.count() <= 6, "{}", cut.count());
    }
}
