//! Collisions with a partner from where the line of centres says.

use rand::{Rng, RngExt};
use stosszahl_model::{
    Collision, Encounter, Physics, Plane, Restitution, Sizes, Space, Vector, VectorOf, collide,
};

use super::arm::{self, Arm};
use super::extents::{Extent, Extents};
use super::partners::{Aim, Search};
use super::shared::{Around, At, ChangeOf};
use super::{Bounds, Rates, Report};
use crate::boundary::Surroundings;
use crate::collide::{Kernel, covered, draw_whole, index, nearest_image};
use crate::density::{Crowding, Scheme};
use crate::grid::{Grid, OFFSETS, offset};
use crate::simulator::{Follow, SimulatorOf};
use crate::tally::smaller;

/// Simulators that a line of cells is to hold, and most cells in one: their trials are drawn together.
const SIMULATORS_IN_LINE: f64 = 4.0;
const LONGEST_LINE: f64 = 8.0;

/// What works around a tile.
pub(super) struct Worker<'a, 'b, 'c, P: Physics, F: Follow<P::Space>> {
    pub(super) kernel: &'a Kernel<'a, P>,
    /// Of partners around points of contact.
    pub(super) rates: Option<&'a Rates<P::Space>>,
    pub(super) arm: &'a Arm,
    /// Of the tile and all next to it together.
    pub(super) bounds: Bounds,
    pub(super) extents: Extents<P::Space>,
    pub(super) around: Around<'b, 'c, P, F>,
    pub(super) cells: Vec<Cell>,
    pub(super) report: Report,
}

/// Neighbouring cells in a line, whose simulators look for partners together.
#[derive(Clone, Copy)]
pub(super) struct Line {
    /// The first cell, and its number in the tile.
    first: [u32; 3],
    local: usize,
    cells: usize,
}

/// A cell of a line.
#[derive(Clone, Copy)]
pub(super) struct Cell {
    pub(super) at: [u32; 3],
    /// Where its simulators end.
    end: u32,
    count: u32,
    /// Units around, what boundaries leave of the room for them, and their packing fraction.
    units: f64,
    crowding: Crowding,
    packing: f64,
    limited: bool,
    /// Cross section times chi of pairs of the largest, over that of the contact distance and the chi of equal ones.
    ceiling: f64,
    /// n chi of the simulators that have most, times the ceiling; and the sum of this over the simulators of the line up to here.
    rate: f64,
    sum: f64,
    collisions: u64,
    virial: f64,
}

/// A simulator that looks for a partner.
struct Trial<V> {
    first: At,
    position: V,
    /// Towards the partner.
    normal: V,
    /// From centre to centre at contact, for a partner of the mean radius \[length\].
    distance: f64,
    /// Its own speed along the normal.
    along: f64,
    /// How fast they must approach, of how fast they can.
    threshold: f64,
    majorant: f64,
}

/// The bounds of a tile and all next to it.
pub(super) fn around<S: Space>(grid: &Grid<S>, bounds: &[Bounds], number: usize) -> Bounds {
    let mut all = bounds[number];
    let tile = grid.place_of(number);
    for step in 0..OFFSETS {
        let other = &bounds[grid.tile_number(grid.neighbour(tile, offset(step)))];
        all.crowd = all.crowd.max(other.crowd);
        all.chi = all.chi.max(other.chi);
    }
    all
}

impl<P, F> Worker<'_, '_, '_, P, F>
where
    P: Physics,
    F: Follow<P::Space>,
{
    /// Collides the simulators of the tile with each other and with those around it.
    pub(super) fn collide(mut self) -> (Report, Vec<ChangeOf<P>>) {
        self.collide_lines();
        (self.report, self.around.changes())
    }

    fn collide_lines(&mut self) {
        let kernel = self.kernel;
        let mut search = Search::new(
            kernel.grid,
            kernel.partner_radius,
            kernel.scene.sizes(),
            kernel.mean_radius,
            self.extents.ranges(),
        );
        let place = self.around.home().place;
        let [columns, rows, layers] = place.sides.map(|side| side as usize);
        let home = self.around.home();
        let each = home.simulators.len() as f64 / home.cells() as f64;
        let cells = (SIMULATORS_IN_LINE / each).clamp(1.0, LONGEST_LINE) as usize;
        let pieces = columns.div_ceil(cells);
        for row in 0..rows * layers {
            for piece in 0..pieces {
                if kernel.stop.is_raised() {
                    return;
                }
                let [from, to] = [piece, piece + 1].map(|piece| columns * piece / pieces);
                let local = columns * row + from;
                let home = self.around.home();
                let [begin, end] = [home.starts[local], home.starts[local + to - from]];
                if begin == end {
                    continue;
                }
                let line = Line {
                    first: home.cell_at(local),
                    local,
                    cells: to - from,
                };
                self.collide_line(line, &mut search);
            }
        }
    }

    /// Collides the simulators of a line of cells.
    fn collide_line(&mut self, line: Line, search: &mut Search<'_, P>) {
        let kernel = self.kernel;
        self.look_at_cells(line);
        let number = kernel.grid.number(line.first);
        let mut stream = kernel.streams.at(u64::from(number));
        match (kernel.density.scheme(), self.rates) {
            (Scheme::ContactPoint { .. }, Some(rates)) => {
                self.around_points(line, rates, search, &mut stream);
            }
            (Scheme::Esmc(_), _) => self.in_cells(line, &mut stream),
            (Scheme::StochasticDisks { stiffness }, _) => {
                for cell in 0..line.cells {
                    if self.cells[cell].count == 0 {
                        continue;
                    }
                    let before = (self.report.tally.collisions, self.report.tally.virial);
                    self.overlapping(self.cells[cell], stiffness, &mut stream);
                    self.cells[cell].collisions = self.report.tally.collisions - before.0;
                    self.cells[cell].virial = self.report.tally.virial - before.1;
                }
            }
            _ => {}
        }
        for (local, cell) in (line.local..).zip(&self.cells) {
            let tally = &mut self.report.tally;
            if cell.collisions > 0 {
                if cell.limited {
                    tally.limited_collisions += cell.collisions;
                }
                let each = 2.0 * cell.collisions as f64;
                let count = f64::from(cell.count);
                if each > tally.busiest_cell * count {
                    tally.busiest_cell = each / count;
                }
                let weighed = kernel.weight * cell.collisions as f64;
                let home = self.around.middle();
                self.around.count(home, local, weighed, cell.virial);
            }
        }
    }

    /// Looks at the cells of a line, as they are before any of them collides.
    fn look_at_cells(&mut self, line: Line) {
        let kernel = self.kernel;
        let sizes = kernel.scene.sizes();
        let home = self.around.home();
        let largest = 2.0 * sizes.largest_radius();
        self.cells.clear();
        let mut at = line.first;
        for local in line.local..line.local + line.cells {
            let (begin, end) = (home.starts[local], home.starts[local + 1]);
            let count = end - begin;
            if count == 0 {
                self.cells.push(Cell::empty(at, end));
                at[0] += 1;
                continue;
            }
            let own = if kernel.density.looks_around() {
                0.0
            } else {
                covered::<P, F>(sizes, home.members(local))
            };
            let units = kernel.density.around(at, own);
            let crowding = kernel.density.crowding(at);
            let covered = units * crowding.bodies;
            let (packing, limited) = (
                covered * kernel.density.unit(),
                kernel.density.is_limited(covered),
            );
            self.report.tally.active_cells += 1;
            self.report.tally.limited_cells += u64::from(limited);
            let ceiling = if P::Sizes::UNIFORM {
                1.0
            } else {
                pair_share(kernel, packing, [largest; 2], largest).max(1.0)
            };
            self.cells.push(Cell {
                count,
                units,
                crowding,
                packing,
                limited,
                ceiling,
                ..Cell::empty(at, end)
            });
            at[0] += 1;
        }
    }

    /// Draws a line of centres for a simulator, and the speed along it that a partner must exceed.
    ///
    /// A partner of velocity u is met at the rate ((v - u) . k)+, at most w(k) = h(k) + v . k, where h(k) is the largest -u . k of
    /// the box that holds all u. The two ends of a line together have w(k) + w(-k) = h(k) + h(-k), which is the sum of the sides
    /// of the box times `|k_i|`, whatever v: so the line is drawn with that density, one of its ends by the shares of the two, and
    /// a partner is accepted with ((v - u) . k)+/w(k). What is left of the number that chose the end is uniform too: the threshold.
    fn propose(
        &self,
        first: At,
        extent: &Extent<P::Space>,
        sides: VectorOf<P>,
        stream: &mut impl Rng,
    ) -> Trial<VectorOf<P>> {
        let simulator = self.around.read(first);
        let normal = line_of_centres::<P::Space>(sides, stream);
        let both: f64 = (0..P::Space::DIMENSION)
            .map(|axis| sides[axis] * normal[axis].abs())
            .sum();
        let number = both * stream.random::<f64>();
        let along = simulator.velocity.inner(&normal);
        let one = extent.against(normal) + along;
        // Without a branch, which nobody could foresee.
        let turns = number >= one;
        let sign = 1.0 - 2.0 * f64::from(u8::from(turns));
        Trial {
            first,
            position: simulator.position,
            normal: normal * sign,
            distance: self.kernel.scene.sizes().radius(simulator.tag) + self.kernel.mean_radius,
            along: along * sign,
            threshold: if turns { number - one } else { number },
            majorant: if turns { both - one } else { one },
        }
    }

    /// Collides a trial's simulator with a partner, if they approach fast enough and, where particles differ in size, their
    /// cross section lets them. Returns how far apart they were along the line of centres, in contact distances.
    fn try_pair(
        &mut self,
        cell: usize,
        trial: &Trial<VectorOf<P>>,
        second: At,
        stream: &mut impl Rng,
    ) -> Option<f64> {
        let places = [trial.first, second];
        let pair = places.map(|at| self.around.read(at));
        let speed = (pair[0].velocity - pair[1].velocity).inner(&trial.normal);
        self.report.tally.majorant_violations += u64::from(speed > trial.majorant * (1.0 + 1e-12));
        if speed <= trial.threshold {
            return None;
        }
        let sizes = self.kernel.scene.sizes();
        let contact = sizes.radius(pair[0].tag) + sizes.radius(pair[1].tag);
        if !P::Sizes::UNIFORM {
            let diameters = pair.map(|simulator| 2.0 * sizes.radius(simulator.tag));
            let Cell {
                packing, ceiling, ..
            } = self.cells[cell];
            let largest = 2.0 * sizes.largest_radius();
            let share = pair_share(self.kernel, packing, diameters, largest) / ceiling;
            if stream.random::<f64>() >= share {
                return None;
            }
        }
        let virial = self.report.tally.virial;
        let apart = self.strike(places, &pair, trial.normal, contact);
        self.cells[cell].collisions += 1;
        self.cells[cell].virial += self.report.tally.virial - virial;
        Some(-apart.inner(&trial.normal) / contact)
    }

    /// Sets the rates of the cells of a line, and draws the number of their trials in a step, for partners of these velocities.
    fn trials(
        &mut self,
        sides: VectorOf<P>,
        rate: impl Fn(&Cell) -> f64,
        stream: &mut impl Rng,
    ) -> u64 {
        let kernel = self.kernel;
        let mut sum = 0.0;
        for cell in &mut self.cells {
            if cell.count > 0 {
                cell.rate = cell.ceiling * rate(cell);
                sum += cell.rate * f64::from(cell.count);
            }
            cell.sum = sum;
        }
        let largest = 2.0 * kernel.scene.sizes().largest_radius();
        let section = largest.powi(P::Space::DIMENSION as i32 - 1);
        // The mean of h(k).
        let mean = 0.5 * MEAN_COMPONENT[P::Space::DIMENSION - 2] * total::<P::Space>(sides);
        let each = 0.5 * P::Space::SOLID_ANGLE * section * mean;
        let trials = draw_whole(sum * each * kernel.step, stream);
        self.report.tally.trials += trials;
        trials
    }

    /// Draws a simulator of a line by the rates of their cells: the number of the cell, and where it is.
    #[inline]
    fn draw_first(&self, stream: &mut impl Rng) -> (usize, At) {
        let sum = self.cells.last().map_or(0.0, |cell| cell.sum);
        // Below the sum also where the product rounds up to it: so there is a cell, and it is not empty.
        let pick = smaller(sum * stream.random::<f64>(), sum.next_down());
        let number = self.cells.iter().filter(|cell| cell.sum <= pick).count();
        let cell = &self.cells[number];
        let left = ((cell.sum - pick) / cell.rate) as u32;
        let first = At {
            tile: self.around.middle(),
            index: cell.end - 1 - left.min(cell.count - 1),
        };
        (number, first)
    }

    /// Partners around the point of contact, at the rate of Enskog's theory.
    fn around_points(
        &mut self,
        line: Line,
        rates: &Rates<P::Space>,
        search: &mut Search<'_, P>,
        stream: &mut impl Rng,
    ) {
        let kernel = self.kernel;
        let sizes = kernel.scene.sizes();
        let extent = self.extents.along(line.first, line.cells);
        let sides = extent.sides();
        let most = |cell: &Cell| rates.most(cell.units, cell.crowding);
        let trials = self.trials(sides, most, stream);
        for number in 0..trials {
            if kernel.stop.is_raised_at(number) {
                break;
            }
            let (number, first) = self.draw_first(stream);
            let trial = self.propose(first, &extent, sides, stream);
            let Trial {
                position,
                normal,
                distance,
                ..
            } = trial;
            let cell = &self.cells[number];
            if !P::Sizes::UNIFORM {
                let share = sizes.radius(self.around.read(first).tag) / sizes.largest_radius();
                let rate = cell.ceiling * rates.at(cell.units, cell.crowding, share);
                if stream.random::<f64>() * cell.rate >= rate {
                    continue;
                }
                // A search among the small for the partner of a large one may look at ten thousands.
                if kernel.stop.is_raised() {
                    break;
                }
            }
            let class = arm::class(cell.packing, cell.crowding == Crowding::NONE);
            let reach = self.arm.reach(class);
            let aim = Aim {
                point: position + normal * (reach * distance),
                along: normal * reach,
            };
            // Beyond a wall there is nobody.
            if !kernel.has_room(position + normal * distance) {
                continue;
            }
            // Nobody there is fast enough.
            if let Some(near) = self.extents.at(search.cell(aim.point))
                && near.against(normal) + trial.along <= trial.threshold
            {
                continue;
            }
            self.report.tally.searches += 1;
            let Some(second) = search.partner(&self.around, aim, first, stream) else {
                self.report.tally.missed += 1;
                continue;
            };
            if let Some(arm) = self.try_pair(number, &trial, second, stream) {
                self.report.distances.note(class, arm);
            }
        }
    }

    /// Partners from the cell of the point of contact.
    fn in_cells(&mut self, line: Line, stream: &mut impl Rng) {
        let kernel = self.kernel;
        let sizes = kernel.scene.sizes();
        let Bounds { crowd, chi, .. } = self.bounds;
        // Cells that walls cut are denser than their number says.
        let least = kernel.surroundings.map_or(1.0, Surroundings::least_room);
        let density = f64::from(crowd) * kernel.weight / (least * kernel.grid.cell_volume());
        let extent = self.extents.along(line.first, line.cells);
        let sides = extent.sides();
        let trials = self.trials(sides, |_| chi * density, stream);
        for number in 0..trials {
            if kernel.stop.is_raised_at(number) {
                break;
            }
            let (number, first) = self.draw_first(stream);
            let trial = self.propose(first, &extent, sides, stream);
            let slot = stream.random_range(0..crowd);
            let Trial {
                position,
                normal,
                distance,
                ..
            } = trial;
            let domain = kernel.grid.domain();
            let point = domain.wrap(position + normal * distance);
            if !kernel.has_room(point) {
                continue;
            }
            let there = kernel.grid.cell_at(point);
            let Some((tile, local)) = self.around.find(there) else {
                continue;
            };
            let room = kernel.surroundings.map_or(1.0, |all| all.room(there));
            if least < room && stream.random::<f64>() * room >= least {
                continue;
            }
            let home = self.around.tile(tile);
            if slot >= home.starts[local + 1] - home.starts[local] {
                continue;
            }
            let second = At {
                tile,
                index: home.starts[local] + slot,
            };
            if second == first {
                continue;
            }
            let middle = domain.wrap(position + normal * (0.5 * distance));
            let middle = kernel.grid.cell_at(middle);
            let Some((tile, local)) = self.around.find(middle) else {
                continue;
            };
            let own = covered::<P, F>(sizes, self.around.tile(tile).members(local));
            let (there, ..) = kernel.density.contact_value(middle, own);
            if chi * stream.random::<f64>() >= there {
                continue;
            }
            self.try_pair(number, &trial, second, stream);
        }
    }

    /// Collides a pair along `normal`, from the first to the second, and returns the vector from the second to the first.
    pub(super) fn strike(
        &mut self,
        places: [At; 2],
        pair: &[SimulatorOf<P, F>; 2],
        normal: VectorOf<P>,
        contact: f64,
    ) -> VectorOf<P> {
        let kernel = self.kernel;
        let sizes = kernel.scene.sizes();
        let velocities = pair.map(|simulator| simulator.velocity);
        let masses = pair.map(|simulator| sizes.mass(simulator.tag));
        let relative = velocities[0] - velocities[1];
        let line = -normal * contact;
        let kinds = [0, 1].map(|who| sizes.kind(pair[who].tag));
        let restitution = (kernel.scene.restitution()).between(kinds, relative.inner(&normal));
        let encounter = Encounter {
            velocities,
            spins: pair.map(|simulator| simulator.spin),
            masses,
            radii: pair.map(|simulator| sizes.radius(simulator.tag)),
            line,
        };
        let outcome = collide(kernel.scene, &encounter, restitution);
        let after = outcome.velocities;
        let apart = nearest_image::<P>(kernel.grid, pair[0].position - pair[1].position);
        for (number, (place, velocity)) in places.into_iter().zip(after).enumerate() {
            let cell = kernel.grid.cell_at(pair[number].position);
            self.around
                .set(place, cell, velocity, outcome.spins[number]);
            self.extents.note(cell, velocity);
        }
        let tally = &mut self.report.tally;
        tally.collisions += 1;
        tally.separation += apart.square().sqrt();
        tally.virial += kernel.weight * apart.inner(&((after[0] - velocities[0]) * masses[0]));
        if kernel.looks {
            self.report.log.push(Collision {
                time: kernel.time,
                position: pair[0].position.spatial(),
                relative: relative.spatial(),
                line: line.spatial(),
                reduced_mass: masses[0] * masses[1] / (masses[0] + masses[1]),
                restitution,
                weight: kernel.weight,
                pair: [0, 1].map(|who| index::<P>(pair[who].tag)),
                species: kinds,
            });
        }
        apart
    }
}

/// Mean size of a component of a random unit vector, in the plane and in space.
const MEAN_COMPONENT: [f64; 2] = [std::f64::consts::FRAC_2_PI, 0.5];

/// The sum of the components.
fn total<S: Space>(vector: S::Vector) -> f64 {
    (0..S::DIMENSION).map(|axis| vector[axis]).sum()
}

/// Cross section times chi of pairs of given diameters, over `largest^(D-1)` and the chi of equal ones.
fn pair_share<P: Physics>(
    kernel: &Kernel<'_, P>,
    packing: f64,
    diameters: [f64; 2],
    largest: f64,
) -> f64 {
    let packing = packing.min(0.9);
    let chi = P::Space::contact_value(packing);
    kernel.pair_factor(chi, packing, diameters) / (P::Space::cross_section(largest) * chi)
}

/// A random line of centres k whose density is the sum of these sides times `|k_i|`: of one of the axes, by their share, the
/// component has the density `|k_i|`, so that its square is uniform in space, and the other component in the plane.
#[inline(always)]
pub(super) fn line_of_centres<S: Space>(sides: S::Vector, stream: &mut impl Rng) -> S::Vector {
    let pick = total::<S>(sides) * stream.random::<f64>();
    if S::DIMENSION == 2 {
        // What is left of the number that chose the axis is uniform too, from -1 to 1.
        let is_first = pick < sides[0];
        let (left, side) = if is_first {
            (pick, sides[0])
        } else {
            (pick - sides[0], sides[1])
        };
        let other = (2.0 * left / side - 1.0).clamp(-1.0, 1.0);
        let along = (1.0 - other * other).sqrt();
        return S::vector(|axis| {
            if (axis == 0) == is_first {
                along
            } else {
                other
            }
        });
    }
    let chosen = if pick < sides[0] {
        0
    } else if pick < sides[0] + sides[1] {
        1
    } else {
        2
    };
    let square: f64 = stream.random();
    let around = Plane::random_direction(stream) * (1.0 - square).sqrt();
    S::vector(|axis| match (axis + 3 - chosen) % 3 {
        0 => square.sqrt(),
        other => around[other - 1],
    })
}

impl Cell {
    fn empty(at: [u32; 3], end: u32) -> Self {
        Self {
            at,
            end,
            count: 0,
            units: 0.0,
            crowding: Crowding::NONE,
            packing: 0.0,
            limited: false,
            ceiling: 0.0,
            rate: 0.0,
            sum: 0.0,
            collisions: 0,
            virial: 0.0,
        }
    }

    /// The places of its simulators in a tile.
    pub(super) fn places(self, tile: u32) -> impl Iterator<Item = At> + Clone {
        (self.end - self.count..self.end).map(move |index| At { tile, index })
    }
}
