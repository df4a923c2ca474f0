//! Boundary conditions prepared for the cell grid of a DSMC run: free fractions and weight factors
//! of cells, cut cells, inflows, and speed bounds.

use stosszahl_model::Rebound;
use stosszahl_model::{Face, ParticleModel, Sizes, Space, VectorOf, Walls};

use nalgebra::vector;

use super::boundaries::BoundaryConditions;
use super::cut_cells::{CentreLimits, CutCell, CutCells, LEAST_ROOM};
use super::inflow::{Inflow, InflowSource};
use super::obstacles::ObstacleMap;
use super::sight;
use super::weights::SimulatorWeights;
use crate::density::Density;
use crate::grid::{Grid, TilePlace};
use crate::parameters::DsmcError;
use crate::particle::{DisplacementTracking, SimulatorOf};
use crate::scheme::WallClearance;

/// Boundary conditions of a DSMC run prepared for its cell grid: walls, inflows, obstacles, weight
/// factors, and the free fraction of each cell.
pub(crate) struct GridBoundaries<P: ParticleModel> {
    walls: Walls<P::Space>,
    /// Axis and side of each face of the box that is not periodic.
    faces: Vec<(usize, usize)>,
    clearance: WallClearance,
    lengths: VectorOf<P>,
    /// Largest depth into the box to which each wall can stop a particle centre, with vibration and
    /// clearance, by axis and side \[length\].
    depths: [[f64; 2]; 3],
    sources: Vec<InflowSource<P>>,
    obstacles: Option<ObstacleMap>,
    /// Weight factor of each cell, by cell number; empty where all are one.
    factors: Vec<f64>,
    weights: SimulatorWeights,
    /// Fraction of each column of cells, row or layer that is open to particle centres at the
    /// current time, by axis; empty where walls cut none.
    columns: [Vec<f64>; 3],
    /// Fraction of each column of cells, row or layer that particle bodies can cover, by axis;
    /// bodies reach one radius beyond centres.
    bodies: [Vec<f64>; 3],
    mean_radius: f64,
    /// Cells that obstacles cut, with the rectangle that walls leave to particle centres; `None`
    /// without obstacles.
    cuts: Option<(CutCells, CentreLimits)>,
    /// Upper bound of the speed that boundaries give to simulators, along each axis
    /// \[length/time\].
    speeds: VectorOf<P>,
}

impl<P: ParticleModel> GridBoundaries<P> {
    /// Prepares boundary conditions for a cell grid at a time \[time\]; `None` if the box is
    /// periodic without obstacles, inflows and weight factors.
    pub(crate) fn new(
        scene: &P,
        boundaries: &BoundaryConditions<P::Space>,
        grid: &Grid<P::Space>,
        [mean_radius, mean_mass]: [f64; 2],
        time: f64,
    ) -> Result<Option<Self>, DsmcError> {
        if boundaries.is_periodic() {
            return Ok(None);
        }
        let walls = boundaries.walls.clone();
        let lengths = grid.domain().lengths();
        let mut faces = Vec::new();
        for axis in 0..P::Space::DIMENSION {
            let here = [0, 1].map(|side| (axis, side));
            faces.extend(
                here.into_iter()
                    .filter(|&(axis, side)| *walls.face(axis, side) != Face::Periodic),
            );
        }
        let room = |radius: f64| match boundaries.clearance {
            WallClearance::Centre => 0.0,
            WallClearance::Radius => radius,
        };
        let largest = scene.sizes().largest_radius();
        let depth = |axis: usize, side: usize, radius: f64| {
            let wall = walls.wall(axis, side);
            wall.map_or(0.0, |wall| {
                room(radius) + wall.vibration.map_or(0.0, |v| v.amplitude())
            })
        };
        let depths = [0, 1, 2].map(|axis| [0, 1].map(|side| depth(axis, side, largest)));
        for (axis, depths) in depths.iter().enumerate().take(P::Space::DIMENSION) {
            let needed = depths[0] + depths[1];
            if needed >= lengths[axis] {
                let length = lengths[axis];
                return Err(DsmcError::NoRoom {
                    axis,
                    length,
                    needed,
                });
            }
        }
        let sources = boundaries
            .inflows
            .iter()
            .enumerate()
            .map(|(number, inflow)| InflowSource::new(scene, number, inflow, &walls))
            .collect::<Result<_, _>>()?;
        let obstacles = ObstacleMap::new(&boundaries.obstacles, grid.domain(), room(largest))?;
        let mut surroundings = Self {
            faces,
            clearance: boundaries.clearance,
            lengths,
            depths,
            sources,
            obstacles,
            cuts: None,
            factors: weight_factors(grid, &boundaries.weights),
            weights: boundaries.weights.clone(),
            columns: [const { Vec::new() }; 3],
            bodies: [const { Vec::new() }; 3],
            mean_radius,
            speeds: VectorOf::<P>::default(),
            walls,
        };
        surroundings.speeds = surroundings.fastest(scene, &boundaries.inflows, mean_mass);
        surroundings.set_time(grid, time);
        surroundings.cuts = surroundings.cut_cells(grid, time)?;
        Ok(Some(surroundings))
    }

    /// Returns true if a wall vibrates, so that the free area of cells changes.
    pub(crate) fn vibrates(&self) -> bool {
        let mut faces = self.faces.iter();
        faces.any(|&(axis, side)| {
            let wall = self.walls.wall(axis, side);
            wall.is_some_and(|wall| wall.vibration.is_some())
        })
    }

    /// Moves vibrating walls to their positions at a time \[time\], and updates the free fractions
    /// of cells.
    pub(crate) fn set_time(&mut self, grid: &Grid<P::Space>, time: f64) {
        let clearance = self.clearance(self.mean_radius);
        for axis in 0..P::Space::DIMENSION {
            let insets = [0, 1].map(|side| {
                let wall = self.walls.wall(axis, side);
                wall.map_or(0.0, |wall| clearance + wall.displacement(time))
            });
            self.columns[axis] = open_columns(grid, axis, insets);
            let reach = [0, 1].map(|side| {
                let wall = self.walls.wall(axis, side);
                wall.map_or(0.0, |_| insets[side] - self.mean_radius)
            });
            self.bodies[axis] = open_columns(grid, axis, reach);
        }
        let limits = self.limits(time);
        let clearance = self.clearance(self.mean_radius);
        if let (Some((cuts, old)), Some(obstacles)) = (&mut self.cuts, &self.obstacles) {
            let width = vector![grid.width()[0], grid.width()[1]];
            cuts.move_walls(obstacles, clearance, width, [*old, limits]);
            *old = limits;
        }
    }

    /// Returns the rectangle that walls leave to centres of particles of the mean radius at a time
    /// \[length\].
    fn limits(&self, time: f64) -> CentreLimits {
        let inset = |axis: usize, side: usize| {
            let wall = self.walls.wall(axis, side);
            wall.map_or(0.0, |wall| {
                self.clearance(self.mean_radius) + wall.displacement(time)
            })
        };
        let [low, high] = [0, 1].map(|side| vector![inset(0, side), inset(1, side)]);
        [low, vector![self.lengths[0], self.lengths[1]] - high]
    }

    /// Finds the cells that obstacles cut, with the rectangle that walls leave to particle centres;
    /// `None` without obstacles.
    fn cut_cells(
        &self,
        grid: &Grid<P::Space>,
        time: f64,
    ) -> Result<Option<(CutCells, CentreLimits)>, DsmcError> {
        let Some(obstacles) = &self.obstacles else {
            return Ok(None);
        };
        let clearance = self.clearance(self.mean_radius);
        let beyond = |axis: usize, side: usize| {
            let wall = self.walls.wall(axis, side);
            let amplitude = wall
                .and_then(|wall| wall.vibration)
                .map_or(0.0, |v| v.amplitude());
            (amplitude - clearance).max(0.0)
        };
        let beyond = [0, 1].map(|side| vector![beyond(0, side), beyond(1, side)]);
        let limits = self.limits(time);
        let cuts = CutCells::new(obstacles, grid, clearance, limits, beyond)?;
        Ok(Some((cuts, limits)))
    }

    /// Cuts the windows of the local packing fraction near obstacles to the cells in line of sight.
    pub(crate) fn cut_windows(&self, grid: &Grid<P::Space>, density: &mut Density<P::Space>) {
        if let (Some((cuts, _)), Some(obstacles)) = (&self.cuts, &self.obstacles) {
            let (reach, bounded) = (density.reach(), density.bounded());
            density.cut(sight::cut_windows(cuts, obstacles, grid, reach, bounded));
        }
    }

    /// Returns the cut cell at a column, row and layer if it has several sub-cells; `None` if it
    /// has not.
    #[inline]
    pub(crate) fn split_cell(&self, cell: [u32; 3]) -> Option<&CutCell> {
        self.cuts.as_ref().and_then(|(cuts, _)| cuts.split(cell))
    }

    /// Returns the fraction of a whole cell that one of its sub-cells leaves open to particle
    /// centres; 0 where no centre fits.
    #[inline]
    pub(crate) fn room_in(&self, cut: &CutCell, sub_cell: usize, layer: u32) -> f64 {
        cut.free_share(sub_cell) * share_of(&self.columns[2], layer)
    }

    /// Passes the free fractions of cells to the local packing fraction: for particle centres in
    /// schemes that pair within a cell, for particle bodies in cross-cell schemes.
    pub(crate) fn leave_room(&self, density: &mut Density<P::Space>) {
        let across = density.scheme().is_cross_cell();
        let bodies = |cell| {
            if across {
                self.body_room(cell)
            } else {
                self.room(cell)
            }
        };
        density.set_room(|cell| self.room(cell), bodies);
        density.set_room_in_windows(|member, layer| {
            let cell = [member.cell[0], member.cell[1], layer];
            match (self.split_cell(cell), member.sub_cell) {
                (Some(cut), Some(sub_cell)) => self.room_in(cut, sub_cell, layer),
                _ => self.room(cell),
            }
        });
    }

    /// Returns the distance between the two walls along an axis, as particle surfaces meet them
    /// \[mean diameters\]; infinite unless both faces have walls.
    pub(crate) fn width(&self, axis: usize) -> f64 {
        if (0..2).any(|side| self.walls.wall(axis, side).is_none()) {
            return f64::INFINITY;
        }
        let beyond = self.mean_radius - self.clearance(self.mean_radius);
        0.5 * (self.lengths[axis] + 2.0 * beyond) / self.mean_radius
    }

    /// Returns the memory that boundary conditions and cut cells occupy \[bytes\].
    pub(crate) fn memory_bytes(&self) -> usize {
        let columns = self.columns.iter().chain(&self.bodies);
        let numbers = columns.map(Vec::capacity).sum::<usize>() + self.factors.capacity();
        let cuts = self
            .cuts
            .as_ref()
            .map_or(0, |(cuts, _)| cuts.memory_bytes());
        size_of::<Self>() + 8 * numbers + cuts
    }

    /// Returns the faces of the box: walls, open and periodic faces.
    pub(crate) fn walls(&self) -> &Walls<P::Space> {
        &self.walls
    }

    /// Returns axis and side of each face of the box that is not periodic.
    pub(crate) fn faces(&self) -> &[(usize, usize)] {
        &self.faces
    }

    /// Returns the sides of the box \[length\].
    pub(crate) fn lengths(&self) -> VectorOf<P> {
        self.lengths
    }

    /// Returns the obstacles in the box; `None` without any.
    #[inline]
    pub(crate) fn obstacles(&self) -> Option<&ObstacleMap> {
        self.obstacles.as_ref()
    }

    /// Returns the number of inflows and the number of obstacles.
    pub(crate) fn numbers(&self) -> [usize; 2] {
        let obstacles = self.obstacles.as_ref().map_or(0, ObstacleMap::count);
        [self.sources.len(), obstacles]
    }

    /// Returns the inflows of the run, with their fluxes.
    pub(crate) fn sources(&self) -> &[InflowSource<P>] {
        &self.sources
    }

    /// Returns the upper bound of the speed that boundaries give to simulators, along each axis
    /// \[length/time\].
    pub(crate) fn speeds(&self) -> VectorOf<P> {
        self.speeds
    }

    /// Returns the distance from walls at which the centre of a particle is stopped \[length\]: its
    /// radius, or 0 if its centre touches walls.
    #[inline]
    pub(crate) fn clearance(&self, radius: f64) -> f64 {
        match self.clearance {
            WallClearance::Centre => 0.0,
            WallClearance::Radius => radius,
        }
    }

    /// Returns the weight factor of a cell: particles per simulator over their number at a factor
    /// of one.
    #[inline]
    pub(crate) fn factor(&self, cell: u32) -> f64 {
        self.factors.get(cell as usize).copied().unwrap_or(1.0)
    }

    /// Returns the simulator weights by region of the box.
    pub(crate) fn weights(&self) -> &SimulatorWeights {
        &self.weights
    }

    /// Returns the index of the region of simulator weights that contains a cell.
    pub(crate) fn region(&self, grid: &Grid<P::Space>, cell: [u32; 3]) -> usize {
        self.weights.block(cell_centre(grid.counts(), cell))
    }

    /// Replaces the simulator weights of all regions, and the weight factors of cells.
    pub(crate) fn set_weights(&mut self, grid: &Grid<P::Space>, weights: SimulatorWeights) {
        self.factors = weight_factors(grid, &weights);
        self.weights = weights;
    }

    /// Returns the smallest weight factor of any cell; at most 1.
    pub(crate) fn least_factor(&self) -> f64 {
        self.factors.iter().copied().fold(1.0, f64::min)
    }

    /// Returns the fraction of a cell's volume that walls and obstacles leave open to particle
    /// centres.
    #[inline]
    pub(crate) fn room(&self, cell: [u32; 3]) -> f64 {
        let cut = self.cuts.as_ref().and_then(|(cuts, _)| cuts.get(cell));
        let room = match cut {
            Some(cut) => cut.room() * share_of(&self.columns[2], cell[2]),
            None => product_of_shares(&self.columns, cell),
        };
        room.max(LEAST_ROOM)
    }

    /// Returns the fraction of a cell's volume that particle bodies can cover between walls; above
    /// one where bodies stick out of the box.
    pub(crate) fn body_room(&self, cell: [u32; 3]) -> f64 {
        product_of_shares(&self.bodies, cell).max(LEAST_ROOM)
    }

    /// Returns true if the centre of a particle with this radius may be at a position, as far as
    /// walls and open faces tell.
    pub(crate) fn has_room(&self, position: VectorOf<P>, radius: f64) -> bool {
        let clearance = self.clearance(radius);
        let is_inside = |&(axis, side): &(usize, usize)| {
            let inset = self.walls.wall(axis, side).map_or(0.0, |_| clearance);
            let x = position[axis];
            if side == 0 {
                x >= inset
            } else {
                x <= self.lengths[axis] - inset && x < self.lengths[axis]
            }
        };
        self.faces.iter().all(is_inside)
    }

    /// Returns a lower bound of the free fraction [`Self::room`] over all cells that walls do not
    /// close.
    pub(crate) fn least_room(&self) -> f64 {
        let columns = self.columns.iter();
        let least = columns.map(|shares| {
            let some = shares.iter().copied().filter(|&share| share > 0.0);
            some.fold(1.0, f64::min)
        });
        least.product::<f64>().max(LEAST_ROOM)
    }

    /// Returns true if simulators that stay in a tile meet no boundary in a flight, if their paths
    /// deviate from straight lines by at most `bend` along each axis \[length\]. Simulators that
    /// leave the tile are checked separately.
    pub(crate) fn is_far_from(&self, place: &TilePlace<P::Space>, bend: VectorOf<P>) -> bool {
        let far = |&(axis, side): &(usize, usize)| {
            let gap = if side == 0 {
                place.low[axis]
            } else {
                self.lengths[axis] - place.high[axis]
            };
            gap > self.depths[axis][side] + bend[axis]
        };
        self.faces.iter().all(far) && self.are_obstacles_far_from(place, bend)
    }

    /// Returns the corners of the part of the box in which simulators of a tile meet no wall in a
    /// flight, if their paths deviate from straight lines by at most `bend` along each axis
    /// \[length\]. `None` if obstacles are near.
    pub(crate) fn clear_part(
        &self,
        place: &TilePlace<P::Space>,
        bend: VectorOf<P>,
    ) -> Option<[VectorOf<P>; 2]> {
        if !self.are_obstacles_far_from(place, bend) {
            return None;
        }
        let mut low = P::Space::from_components(|_| f64::NEG_INFINITY);
        let mut high = P::Space::from_components(|_| f64::INFINITY);
        for &(axis, side) in &self.faces {
            let inset = self.depths[axis][side] + bend[axis];
            if side == 0 {
                low[axis] = inset;
            } else {
                high[axis] = self.lengths[axis] - inset;
            }
        }
        Some([low, high])
    }

    /// Returns true if flights within a tile cannot reach any obstacle, with paths that deviate
    /// from straight lines by at most `bend` along each axis \[length\].
    fn are_obstacles_far_from(&self, place: &TilePlace<P::Space>, bend: VectorOf<P>) -> bool {
        let corners = [place.low, place.high].map(|corner| [corner[0], corner[1]]);
        self.obstacles
            .as_ref()
            .is_none_or(|obstacles| obstacles.are_far_from(corners, [bend[0], bend[1]]))
    }

    /// Returns true if all cells of a tile have the same weight factor.
    pub(crate) fn is_even(&self, grid: &Grid<P::Space>, place: &TilePlace<P::Space>) -> bool {
        let first = self.factor(grid.number(place.first));
        let [columns, rows, layers] = place.sides;
        let mut cells = (0..layers)
            .flat_map(|z| (0..rows).flat_map(move |y| (0..columns).map(move |x| [x, y, z])));
        cells.all(|step| {
            let cell = [0, 1, 2].map(|axis| place.first[axis] + step[axis]);
            self.factor(grid.number(cell)) == first
        })
    }

    /// Returns the two corners of the part of a cell's open face through which an inflow enters
    /// \[length\]; `None` if walls close it.
    pub(crate) fn opening(
        &self,
        grid: &Grid<P::Space>,
        cell: [u32; 3],
        source: &InflowSource<P>,
    ) -> Option<[VectorOf<P>; 2]> {
        let (through, _) = source.face();
        let clearance = self.clearance(source.particle().1);
        let width = grid.width();
        let mut corners = [0, 1].map(|more| {
            P::Space::from_components(|axis| {
                let edge = cell[axis] + more;
                if edge == grid.counts()[axis] {
                    self.lengths[axis]
                } else {
                    f64::from(edge) * width[axis]
                }
            })
        });
        for &(axis, side) in &self.faces {
            if axis != through && self.walls.wall(axis, side).is_some() {
                let edge = &mut corners[side][axis];
                *edge = if side == 0 {
                    edge.max(clearance)
                } else {
                    edge.min(self.lengths[axis] - clearance)
                };
            }
        }
        let is_open = (0..P::Space::DIMENSION).all(|axis| corners[0][axis] < corners[1][axis]);
        is_open.then_some(corners)
    }

    /// Moves a position that rounding has put beyond a face of the box back to that face, and wraps
    /// periodic coordinates.
    pub(crate) fn keep_inside(&self, position: &mut VectorOf<P>, clearance: f64) {
        for &(axis, side) in &self.faces {
            let inset = if self.walls.wall(axis, side).is_some() {
                clearance
            } else {
                0.0
            };
            let x = position[axis];
            position[axis] = if side == 0 {
                x.max(inset)
            } else {
                x.min((self.lengths[axis] - inset).min(self.lengths[axis].next_down()))
            };
        }
    }

    /// Reflects a position at the faces of the box that are not periodic until it is inside.
    pub(crate) fn fold(&self, position: &mut VectorOf<P>, radius: f64) {
        let clearance = self.clearance(radius);
        for axis in 0..P::Space::DIMENSION {
            if *self.walls.face(axis, 0) == Face::Periodic {
                continue;
            }
            let inset = |side| self.walls.wall(axis, side).map_or(0.0, |_| clearance);
            let (low, high) = (inset(0), self.lengths[axis] - inset(1));
            let x = position[axis];
            if !(low..=high).contains(&x) && x.is_finite() {
                let width = high - low;
                let along = (x - low).rem_euclid(2.0 * width);
                position[axis] = low + along.min(2.0 * width - along);
            }
        }
        self.keep_inside(position, clearance);
    }

    /// Checks that a simulator of the initial state overlaps no wall and no obstacle.
    pub(crate) fn check_place<F: DisplacementTracking<P::Space>>(
        &self,
        scene: &P,
        index: usize,
        simulator: &SimulatorOf<P, F>,
        time: f64,
    ) -> Result<(), DsmcError> {
        let clearance = self.clearance(scene.sizes().radius(simulator.tag));
        for axis in 0..P::Space::DIMENSION {
            if *self.walls.face(axis, 0) == Face::Periodic {
                continue;
            }
            let inset = |side| {
                let wall = self.walls.wall(axis, side);
                wall.map_or(0.0, |wall| clearance + wall.displacement(time))
            };
            let length = self.lengths[axis];
            let (low, high) = (inset(0), length - inset(1));
            let x = simulator.position[axis];
            // A start read from text has lost its last digits.
            let slack = 1e-12 * length;
            if !(low - slack..=high + slack).contains(&x) {
                return Err(DsmcError::BeyondWall {
                    simulator: index,
                    axis,
                    coordinate: x,
                    allowed: [low, high],
                });
            }
        }
        let place = [simulator.position[0], simulator.position[1]];
        match self
            .obstacles
            .as_ref()
            .and_then(|all| all.overlapped(place, clearance))
        {
            Some(obstacle) => Err(DsmcError::InObstacle {
                simulator: index,
                obstacle,
                place,
            }),
            None => Ok(()),
        }
    }

    /// Returns the upper bound of the speed that boundaries give to simulators, for the choice of
    /// the time step \[length/time\]: drift of an inflow plus three thermal speeds, three thermal
    /// speeds of diffuse walls, twice the speed of a vibrating wall.
    fn fastest(&self, scene: &P, inflows: &[Inflow<P::Space>], mean_mass: f64) -> VectorOf<P> {
        let mut speeds = VectorOf::<P>::default();
        let sizes = scene.sizes();
        for inflow in inflows {
            let mass = sizes.mass(sizes.tag_of(inflow.like));
            for axis in 0..P::Space::DIMENSION {
                let thermal = 3.0 * (inflow.temperature / mass).sqrt();
                speeds[axis] = speeds[axis].max(inflow.velocity[axis].abs() + thermal);
            }
        }
        for &(axis, side) in &self.faces {
            let Some(wall) = self.walls.wall(axis, side) else {
                continue;
            };
            let speed = wall
                .vibration
                .map_or(0.0, |vibration| 2.0 * vibration.speed());
            speeds[axis] = speeds[axis].max(speed);
            if let Rebound::Diffuse { temperature } = wall.rebound {
                let thermal = 3.0 * (temperature / mean_mass).sqrt();
                speeds = P::Space::from_components(|axis| speeds[axis].max(thermal));
            }
        }
        speeds
    }
}

/// Returns the product of the free fractions of a cell's column, row and layer; an empty list
/// counts as 1.
fn product_of_shares(columns: &[Vec<f64>; 3], cell: [u32; 3]) -> f64 {
    let shares = columns.iter().zip(cell);
    shares.map(|(shares, at)| share_of(shares, at)).product()
}

/// Returns the free fraction of one column, row or layer of cells; 1 where the list is empty.
fn share_of(shares: &[f64], at: u32) -> f64 {
    shares.get(at as usize).copied().unwrap_or(1.0)
}

/// Returns the fraction of each column (or row, layer) of cells along an axis that is at least
/// `insets` away from its two faces. Negative insets extend the outermost columns beyond the box.
/// Empty if both are zero.
fn open_columns<S: Space>(grid: &Grid<S>, axis: usize, insets: [f64; 2]) -> Vec<f64> {
    if insets == [0.0; 2] {
        return Vec::new();
    }
    let count = grid.counts()[axis];
    let (length, width) = (grid.domain().lengths()[axis], grid.width()[axis]);
    (0..count)
        .map(|column| {
            let [first, last] = [column == 0, column + 1 == count];
            let [below, above] = [0, 1].map(|side: usize| insets[side].min(0.0));
            let low = (f64::from(column) * width).max(insets[0]) + if first { below } else { 0.0 };
            let high = (f64::from(column + 1) * width).min(length - insets[1])
                - if last { above } else { 0.0 };
            ((high - low) / width).max(0.0)
        })
        .collect()
}

/// Returns the weight factor of each cell of the grid; empty if weights are uniform.
fn weight_factors<S: Space>(grid: &Grid<S>, weights: &SimulatorWeights) -> Vec<f64> {
    if weights.is_uniform() {
        return Vec::new();
    }
    let [columns, rows, layers] = grid.counts();
    let mut factors = Vec::with_capacity(grid.cells());
    for z in 0..layers {
        for y in 0..rows {
            for x in 0..columns {
                factors.push(weights.factor_at(cell_centre(grid.counts(), [x, y, z])));
            }
        }
    }
    factors
}

/// Returns the centre of a cell, as fractions of the box sides.
fn cell_centre(counts: [u32; 3], cell: [u32; 3]) -> [f64; 3] {
    [0, 1, 2].map(|axis| (f64::from(cell[axis]) + 0.5) / f64::from(counts[axis]))
}
