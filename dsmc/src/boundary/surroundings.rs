//! Boundaries, made ready for the cells of a run.

use stosszahl_model::Rebound;
use stosszahl_model::{Face, Physics, Sizes, Space, VectorOf, Walls};

use nalgebra::vector;

use super::boundaries::{Boundaries, Clearance};
use super::cut_cells::{CentreLimits, CutCell, CutCells, LEAST_ROOM};
use super::inflow::{Inflow, Source};
use super::obstacles::Standing;
use super::sight;
use super::weights::Weights;
use crate::density::Density;
use crate::grid::{Grid, Place};
use crate::parameters::EngineError;
use crate::particle::{Follow, SimulatorOf};

/// What is at the faces of the box and inside it.
pub(crate) struct Surroundings<P: Physics> {
    walls: Walls<P::Space>,
    /// The faces that are not periodic, by axis and side.
    faces: Vec<(usize, usize)>,
    clearance: Clearance,
    lengths: VectorOf<P>,
    /// How far the walls and the room for their particles reach into the box at most, by axis and side.
    depths: [[f64; 2]; 3],
    sources: Vec<Source<P>>,
    obstacles: Option<Standing>,
    /// Particles of a simulator over those where the factor is one, by the number of the cell; empty where all are one.
    factors: Vec<f64>,
    weights: Weights,
    /// The share of each column of cells, along each axis, in which centres can now be; empty where walls cut none.
    columns: [Vec<f64>; 3],
    /// The same of bodies: a radius more at each wall.
    bodies: [Vec<f64>; 3],
    mean_radius: f64,
    /// The cells that obstacles cut, and the limits of their free area along the first two axes.
    cuts: Option<(CutCells, CentreLimits)>,
    /// Fastest that boundaries make simulators, along each axis \[length/time\].
    speeds: VectorOf<P>,
}

impl<P: Physics> Surroundings<P> {
    /// Boundaries for the cells of a run, at a time; none if the box is periodic, and alike everywhere.
    pub(crate) fn new(
        scene: &P,
        boundaries: &Boundaries<P::Space>,
        grid: &Grid<P::Space>,
        [mean_radius, mean_mass]: [f64; 2],
        time: f64,
    ) -> Result<Option<Self>, EngineError> {
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
            Clearance::Centre => 0.0,
            Clearance::Radius => radius,
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
                return Err(EngineError::NoRoom {
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
            .map(|(number, inflow)| Source::new(scene, number, inflow, &walls))
            .collect::<Result<_, _>>()?;
        let obstacles = Standing::new(&boundaries.obstacles, grid.domain(), room(largest))?;
        let mut surroundings = Self {
            faces,
            clearance: boundaries.clearance,
            lengths,
            depths,
            sources,
            obstacles,
            cuts: None,
            factors: factors(grid, &boundaries.weights),
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

    /// Whether a wall moves to and fro, so that the room of cells changes.
    pub(crate) fn vibrates(&self) -> bool {
        let mut faces = self.faces.iter();
        faces.any(|&(axis, side)| {
            let wall = self.walls.wall(axis, side);
            wall.is_some_and(|wall| wall.vibration.is_some())
        })
    }

    /// Puts walls where they are at a time.
    pub(crate) fn set_time(&mut self, grid: &Grid<P::Space>, time: f64) {
        let clearance = self.clearance(self.mean_radius);
        for axis in 0..P::Space::DIMENSION {
            let insets = [0, 1].map(|side| {
                let wall = self.walls.wall(axis, side);
                wall.map_or(0.0, |wall| clearance + wall.displacement(time))
            });
            self.columns[axis] = columns(grid, axis, insets);
            let reach = [0, 1].map(|side| {
                let wall = self.walls.wall(axis, side);
                wall.map_or(0.0, |_| insets[side] - self.mean_radius)
            });
            self.bodies[axis] = columns(grid, axis, reach);
        }
        let limits = self.limits(time);
        let clearance = self.clearance(self.mean_radius);
        if let (Some((cuts, old)), Some(obstacles)) = (&mut self.cuts, &self.obstacles) {
            let width = vector![grid.width()[0], grid.width()[1]];
            cuts.move_walls(obstacles, clearance, width, [*old, limits]);
            *old = limits;
        }
    }

    /// Corners of what walls leave to centres of the mean radius at a time, along the first two axes.
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

    /// The cells that obstacles cut, if there are obstacles.
    fn cut_cells(
        &self,
        grid: &Grid<P::Space>,
        time: f64,
    ) -> Result<Option<(CutCells, CentreLimits)>, EngineError> {
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

    /// Cuts the density windows of cells near obstacles to what is in sight.
    pub(crate) fn cut_windows(&self, grid: &Grid<P::Space>, density: &mut Density<P::Space>) {
        if let (Some((cuts, _)), Some(obstacles)) = (&self.cuts, &self.obstacles) {
            let (reach, bounded) = (density.reach(), density.bounded());
            density.cut(sight::cut_windows(cuts, obstacles, grid, reach, bounded));
        }
    }

    /// The cell at these coordinates, if obstacles hide a part of it from another.
    #[inline]
    pub(crate) fn split_cell(&self, cell: [u32; 3]) -> Option<&CutCell> {
        self.cuts.as_ref().and_then(|(cuts, _)| cuts.split(cell))
    }

    /// The share of a sub-cell of a split cell in which centres can be, as [`Self::room`] of a cell: none where no centre can be.
    #[inline]
    pub(crate) fn room_in(&self, cut: &CutCell, sub_cell: usize, layer: u32) -> f64 {
        cut.share(sub_cell) * share_of(&self.columns[2], layer)
    }

    /// Notes in the densities of cells how much room there is: pairs within a cell have packing fractions of the room for
    /// centres.
    pub(crate) fn leave_room(&self, density: &mut Density<P::Space>) {
        let across = density.scheme().is_across();
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

    /// From wall to wall along an axis, as surfaces of particles meet them \[mean diameters\]; infinite unless there are two.
    pub(crate) fn width(&self, axis: usize) -> f64 {
        if (0..2).any(|side| self.walls.wall(axis, side).is_none()) {
            return f64::INFINITY;
        }
        let beyond = self.mean_radius - self.clearance(self.mean_radius);
        0.5 * (self.lengths[axis] + 2.0 * beyond) / self.mean_radius
    }

    /// Memory \[bytes\].
    pub(crate) fn bytes(&self) -> usize {
        let columns = self.columns.iter().chain(&self.bodies);
        let numbers = columns.map(Vec::capacity).sum::<usize>() + self.factors.capacity();
        let cuts = self.cuts.as_ref().map_or(0, |(cuts, _)| cuts.bytes());
        size_of::<Self>() + 8 * numbers + cuts
    }

    /// The faces of the box.
    pub(crate) fn walls(&self) -> &Walls<P::Space> {
        &self.walls
    }

    /// The faces that are not periodic, by axis and side.
    pub(crate) fn faces(&self) -> &[(usize, usize)] {
        &self.faces
    }

    /// Sides of the box.
    pub(crate) fn lengths(&self) -> VectorOf<P> {
        self.lengths
    }

    /// What stands in the box.
    #[inline]
    pub(crate) fn obstacles(&self) -> Option<&Standing> {
        self.obstacles.as_ref()
    }

    /// Numbers of inflows and of obstacles.
    pub(crate) fn numbers(&self) -> [usize; 2] {
        let obstacles = self.obstacles.as_ref().map_or(0, Standing::count);
        [self.sources.len(), obstacles]
    }

    /// What flows in.
    pub(crate) fn sources(&self) -> &[Source<P>] {
        &self.sources
    }

    /// Fastest that boundaries make simulators, along each axis.
    pub(crate) fn speeds(&self) -> VectorOf<P> {
        self.speeds
    }

    /// Distance from walls at which the centre of a particle stops.
    #[inline]
    pub(crate) fn clearance(&self, radius: f64) -> f64 {
        match self.clearance {
            Clearance::Centre => 0.0,
            Clearance::Radius => radius,
        }
    }

    /// Particles of a simulator in a cell, over those where the factor is one.
    #[inline]
    pub(crate) fn factor(&self, cell: u32) -> f64 {
        self.factors.get(cell as usize).copied().unwrap_or(1.0)
    }

    /// The weights of regions.
    pub(crate) fn weights(&self) -> &Weights {
        &self.weights
    }

    /// The region of a cell.
    pub(crate) fn region(&self, grid: &Grid<P::Space>, cell: [u32; 3]) -> usize {
        self.weights.block(middle(grid.counts(), cell))
    }

    /// Changes the weights of regions.
    pub(crate) fn set_weights(&mut self, grid: &Grid<P::Space>, weights: Weights) {
        self.factors = factors(grid, &weights);
        self.weights = weights;
    }

    /// The least of all factors.
    pub(crate) fn least_factor(&self) -> f64 {
        self.factors.iter().copied().fold(1.0, f64::min)
    }

    /// The share of a cell in which centres can be.
    #[inline]
    pub(crate) fn room(&self, cell: [u32; 3]) -> f64 {
        let cut = self.cuts.as_ref().and_then(|(cuts, _)| cuts.get(cell));
        let room = match cut {
            Some(cut) => cut.room() * share_of(&self.columns[2], cell[2]),
            None => product(&self.columns, cell),
        };
        room.max(LEAST_ROOM)
    }

    /// The share of a cell in which bodies can be, of particles whose centres are where [`Self::room`] says; more than one
    /// where they stick out of the box.
    pub(crate) fn body_room(&self, cell: [u32; 3]) -> f64 {
        product(&self.bodies, cell).max(LEAST_ROOM)
    }

    /// Whether walls and open faces let the centre of a particle be at a position.
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

    /// The least of [`Self::room`] of all cells that have some.
    pub(crate) fn least_room(&self) -> f64 {
        let columns = self.columns.iter();
        let least = columns.map(|shares| {
            let some = shares.iter().copied().filter(|&share| share > 0.0);
            some.fold(1.0, f64::min)
        });
        least.product::<f64>().max(LEAST_ROOM)
    }

    /// Whether flight within a tile, and out of it, is all that happens to simulators that are in it: for a flight that
    /// leaves a straight line by at most `bend` along each axis. Simulators that leave the tile are looked at anyway.
    pub(crate) fn is_far_from(&self, place: &Place<P::Space>, bend: VectorOf<P>) -> bool {
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

    /// Corners of the part of the box from which, and to which, simulators of a tile come in a flight without touching
    /// anything, if they leave a straight line by at most `bend` along each axis; none if obstacles are near.
    pub(crate) fn clear_part(
        &self,
        place: &Place<P::Space>,
        bend: VectorOf<P>,
    ) -> Option<[VectorOf<P>; 2]> {
        if !self.are_obstacles_far_from(place, bend) {
            return None;
        }
        let mut low = P::Space::vector(|_| f64::NEG_INFINITY);
        let mut high = P::Space::vector(|_| f64::INFINITY);
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

    /// Whether no obstacle is where simulators of a tile fly that stay in it.
    fn are_obstacles_far_from(&self, place: &Place<P::Space>, bend: VectorOf<P>) -> bool {
        let corners = [place.low, place.high].map(|corner| [corner[0], corner[1]]);
        self.obstacles
            .as_ref()
            .is_none_or(|obstacles| obstacles.are_far_from(corners, [bend[0], bend[1]]))
    }

    /// Whether all simulators of a tile weigh the same.
    pub(crate) fn is_even(&self, grid: &Grid<P::Space>, place: &Place<P::Space>) -> bool {
        let first = self.factor(grid.number(place.first));
        let [columns, rows, layers] = place.sides;
        let mut cells = (0..layers)
            .flat_map(|z| (0..rows).flat_map(move |y| (0..columns).map(move |x| [x, y, z])));
        cells.all(|step| {
            let cell = [0, 1, 2].map(|axis| place.first[axis] + step[axis]);
            self.factor(grid.number(cell)) == first
        })
    }

    /// The part of the face of a cell through which a source sends its particles, by two corners of the cell.
    pub(crate) fn opening(
        &self,
        grid: &Grid<P::Space>,
        cell: [u32; 3],
        source: &Source<P>,
    ) -> Option<[VectorOf<P>; 2]> {
        let (through, _) = source.face();
        let clearance = self.clearance(source.particle().1);
        let width = grid.width();
        let mut corners = [0, 1].map(|more| {
            P::Space::vector(|axis| {
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

    /// Puts a coordinate back that rounding has put beyond a face, and wraps the others.
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

    /// Mirrors a position at the faces until it is inside.
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

    /// A simulator at the start, which must not be beyond a wall.
    pub(crate) fn check_place<F: Follow<P::Space>>(
        &self,
        scene: &P,
        index: usize,
        simulator: &SimulatorOf<P, F>,
        time: f64,
    ) -> Result<(), EngineError> {
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
            // A start that was written down loses its last digits.
            let slack = 1e-12 * length;
            if !(low - slack..=high + slack).contains(&x) {
                return Err(EngineError::BeyondWall {
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
            Some(obstacle) => Err(EngineError::InObstacle {
                simulator: index,
                obstacle,
                place,
            }),
            None => Ok(()),
        }
    }

    /// A bound on what boundaries do to the speed of simulators, for the length of a step: the drift of an inflow and three
    /// times its thermal speed, the same for diffuse walls, and twice the speed of a vibrating wall.
    fn fastest(&self, scene: &P, inflows: &[Inflow<P::Space>], mean_mass: f64) -> VectorOf<P> {
        let mut speeds = VectorOf::<P>::default();
        let sizes = scene.sizes();
        for inflow in inflows {
            let mass = sizes.mass(sizes.tag(inflow.like));
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
                speeds = P::Space::vector(|axis| speeds[axis].max(thermal));
            }
        }
        speeds
    }
}

/// The product of the shares of the columns that a cell is in; empty ones are whole.
fn product(columns: &[Vec<f64>; 3], cell: [u32; 3]) -> f64 {
    let shares = columns.iter().zip(cell);
    shares.map(|(shares, at)| share_of(shares, at)).product()
}

/// The share of one column; whole where there are none.
fn share_of(shares: &[f64], at: u32) -> f64 {
    shares.get(at as usize).copied().unwrap_or(1.0)
}

/// The share of each column of cells along an axis that lies at least so far from its two faces, where that is less than
/// nothing with what lies beyond them; empty if all do.
fn columns<S: Space>(grid: &Grid<S>, axis: usize, insets: [f64; 2]) -> Vec<f64> {
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

/// The factor of each cell; empty if all are one.
fn factors<S: Space>(grid: &Grid<S>, weights: &Weights) -> Vec<f64> {
    if weights.is_uniform() {
        return Vec::new();
    }
    let [columns, rows, layers] = grid.counts();
    let mut factors = Vec::with_capacity(grid.cells());
    for z in 0..layers {
        for y in 0..rows {
            for x in 0..columns {
                factors.push(weights.at(middle(grid.counts(), [x, y, z])));
            }
        }
    }
    factors
}

/// The middle of a cell, in shares of the sides of the box.
fn middle(counts: [u32; 3], cell: [u32; 3]) -> [f64; 3] {
    [0, 1, 2].map(|axis| (f64::from(cell[axis]) + 0.5) / f64::from(counts[axis]))
}
