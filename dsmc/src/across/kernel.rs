//! Collisions with a partner from where the line of centres says.

use rand::{Rng, RngExt};
use stosszahl_model::{
    Collision, Encounter, Physics, Restitution, Sizes, Space, Vector, VectorOf, collide,
};

use super::arm::{self, Arm};
use super::partners::{Aim, Search};
use super::shared::{Around, At};
use super::speeds::{Speeds, patches};
use super::{Bounds, Rates, Report};
use crate::boundary::Surroundings;
use crate::collide::{Kernel, covered, draw_whole, nearest_image};
use crate::density::Scheme;
use crate::grid::{Grid, OFFSETS, offset};
use crate::simulator::{Follow, SimulatorOf};

/// Whoever works around a tile.
pub(super) struct Worker<'a, 'b, 'c, P: Physics, F: Follow<P::Space>> {
    pub(super) kernel: &'a Kernel<'a, P>,
    pub(super) rates: &'a Rates<P::Space>,
    pub(super) arm: &'a Arm,
    /// Of the tile and all next to it together.
    pub(super) bounds: Bounds,
    pub(super) speeds: Speeds<P::Space>,
    pub(super) around: Around<'b, 'c, P, F>,
    pub(super) report: Report<P>,
}

/// A cell whose simulators look for partners.
#[derive(Clone, Copy)]
pub(super) struct Cell {
    pub(super) at: [u32; 3],
    pub(super) tile: u32,
    begin: u32,
    end: u32,
    /// Units around, itself included, and their packing fraction.
    units: f64,
    packing: f64,
    limited: bool,
}

/// A simulator that looks for a partner.
struct Trial<V> {
    first: At,
    position: V,
    /// Towards the partner.
    normal: V,
    /// From centre to centre at contact, for a partner of the mean radius \[length\].
    distance: f64,
    /// How fast they must approach, of how fast they can.
    threshold: f64,
    majorant: f64,
    /// Whether no partner around approaches fast enough.
    is_hopeless: bool,
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
    pub(super) fn collide(mut self) -> Report<P> {
        let number = self.around.middle();
        let kernel = self.kernel;
        let mut search = Search::new(
            kernel.grid,
            kernel.partner_radius,
            kernel.scene.sizes(),
            kernel.mean_radius,
        );
        for patch in patches(&self.around.tile(number).place) {
            if kernel.density.scheme().bounds_trials() {
                self.speeds = Speeds::new(kernel.grid, &self.around, patch);
            }
            for at in patch.cells() {
                if let Some(cell) = self.cell(number, at) {
                    self.collide_in(cell, &mut search);
                }
            }
        }
        self.report
    }

    /// Collides the simulators of a cell.
    fn collide_in(&mut self, cell: Cell, search: &mut Search<'_, P>) {
        let kernel = self.kernel;
        let mut stream = kernel.streams.at(u64::from(kernel.grid.number(cell.at)));
        let (before, virial) = (self.report.tally.collisions, self.report.tally.virial);
        match kernel.density.scheme() {
            Scheme::ContactPoint { .. } => self.around_points(cell, search, &mut stream),
            Scheme::Esmc(_) => self.in_cells(cell, &mut stream),
            Scheme::StochasticDisks { stiffness } => {
                self.overlapping(cell, stiffness, &mut stream);
            }
            _ => {}
        }
        let tally = &mut self.report.tally;
        let collisions = tally.collisions - before;
        if cell.limited {
            tally.limited_collisions += collisions;
        }
        let each = 2.0 * collisions as f64 / f64::from(cell.end - cell.begin);
        tally.busiest_cell = tally.busiest_cell.max(each);
        let virial = tally.virial - virial;
        let local = self.around.tile(cell.tile).number(cell.at);
        (self.around).count(cell.tile, local, kernel.weight * collisions as f64, virial);
    }

    /// A cell of a tile, if it is not empty.
    fn cell(&mut self, tile: u32, at: [u32; 3]) -> Option<Cell> {
        let kernel = self.kernel;
        let home = self.around.tile(tile);
        let local = home.number(at);
        let members = home.members(local);
        if members.is_empty() {
            return None;
        }
        let (begin, end) = (home.starts[local], home.starts[local + 1]);
        let own = covered::<P, F>(kernel.scene.sizes(), members);
        let (_, limited, packing) = kernel.density.contact_value(at, own);
        let units = kernel.density.units(at, own);
        self.report.tally.active_cells += 1;
        self.report.tally.limited_cells += u64::from(limited);
        Some(Cell {
            at,
            tile,
            begin,
            end,
            units,
            packing,
            limited,
        })
    }

    /// Draws one of the simulators of a cell, a line of centres, and the speed along it that a partner must exceed.
    fn propose(&self, cell: Cell, majorant: f64, stream: &mut impl Rng) -> Trial<VectorOf<P>> {
        let first = At {
            tile: cell.tile,
            index: stream.random_range(cell.begin..cell.end),
        };
        let simulator = self.around.read(first);
        let normal = P::Space::random_direction(stream);
        let threshold = majorant * stream.random::<f64>();
        let velocity = simulator.velocity - self.speeds.middle();
        let fastest = velocity.inner(&normal) + self.speeds.spread(cell.at);
        Trial {
            first,
            position: simulator.position,
            normal,
            distance: self.kernel.scene.sizes().radius(simulator.tag) + self.kernel.mean_radius,
            threshold,
            majorant,
            is_hopeless: fastest <= threshold,
        }
    }

    /// Collides a trial's simulator with a partner, if they approach fast enough and, where particles are unlike, their
    /// cross section lets them. Returns how far apart they were along the line of centres, in contact distances.
    fn try_pair(
        &mut self,
        cell: Cell,
        trial: &Trial<VectorOf<P>>,
        second: At,
        [largest, ceiling]: [f64; 2],
        stream: &mut impl Rng,
    ) -> Option<f64> {
        let places = [trial.first, second];
        let pair = places.map(|at| self.around.read(at));
        let speed = (pair[0].velocity - pair[1].velocity).inner(&trial.normal);
        self.report.tally.majorant_violations += u64::from(speed > trial.majorant);
        if speed <= trial.threshold {
            return None;
        }
        let sizes = self.kernel.scene.sizes();
        let contact = sizes.radius(pair[0].tag) + sizes.radius(pair[1].tag);
        if !P::Sizes::UNIFORM {
            let diameters = pair.map(|simulator| 2.0 * sizes.radius(simulator.tag));
            let share = self.pair_share(cell, diameters, largest) / ceiling;
            if stream.random::<f64>() >= share {
                return None;
            }
        }
        let apart = self.strike(places, &pair, trial.normal, contact);
        Some(-apart.inner(&trial.normal) / contact)
    }

    /// No simulator of a cell approaches any partner faster.
    fn majorant(&self, cell: Cell) -> f64 {
        let members = &self.around.tile(cell.tile).simulators;
        let squares = members[cell.begin as usize..cell.end as usize]
            .iter()
            .map(|member| self.speeds.square(member.velocity));
        // Room for the rounding of the middle.
        (squares.fold(0.0, f64::max).sqrt() + self.speeds.spread(cell.at)) * (1.0 + 1e-12)
    }

    /// Partners around the point of contact, at the rate of Enskog's theory.
    fn around_points(&mut self, cell: Cell, search: &mut Search<'_, P>, stream: &mut impl Rng) {
        let kernel = self.kernel;
        let sizes = kernel.scene.sizes();
        let majorant = self.majorant(cell);
        let largest = 2.0 * sizes.largest_radius();
        let section = largest.powi(P::Space::DIMENSION as i32 - 1);
        // Of pairs over pairs of the largest with the chi of equal ones.
        let ceiling = self.pair_ceiling(cell, largest);
        let most = self.rates.most(cell.units);
        let rate = 0.5 * P::Space::SOLID_ANGLE * section * ceiling * most;
        let count = f64::from(cell.end - cell.begin);
        let trials = draw_whole(count * rate * majorant * kernel.step, stream);
        self.report.tally.trials += trials;
        let class = arm::class(cell.packing);
        let reach = self.arm.reach(class);
        for _ in 0..trials {
            let trial = self.propose(cell, majorant, stream);
            if trial.is_hopeless {
                continue;
            }
            let Trial {
                first,
                position,
                normal,
                distance,
                ..
            } = trial;
            if !P::Sizes::UNIFORM {
                let share = sizes.radius(self.around.read(first).tag) / sizes.largest_radius();
                if stream.random::<f64>() * most >= self.rates.at(cell.units, share) {
                    continue;
                }
            }
            let aim = Aim {
                point: position + normal * (reach * distance),
                along: normal * reach,
            };
            // Beyond a wall there is nobody.
            if !kernel.has_room(position + normal * distance) {
                continue;
            }
            let Some(second) = search.partner(&self.around, aim, first, stream) else {
                self.report.tally.missed += 1;
                continue;
            };
            if let Some(arm) = self.try_pair(cell, &trial, second, [largest, ceiling], stream) {
                self.report.distances.note(class, arm);
            }
        }
    }

    /// Partners from the cell of the point of contact.
    fn in_cells(&mut self, cell: Cell, stream: &mut impl Rng) {
        let kernel = self.kernel;
        let sizes = kernel.scene.sizes();
        let majorant = self.majorant(cell);
        let largest = 2.0 * sizes.largest_radius();
        let section = largest.powi(P::Space::DIMENSION as i32 - 1);
        let ceiling = self.pair_ceiling(cell, largest);
        let Bounds { crowd, chi, .. } = self.bounds;
        // Cells that walls cut are denser than their number says.
        let least = kernel.surroundings.map_or(1.0, Surroundings::least_room);
        let density = f64::from(crowd) * kernel.weight / (least * kernel.grid.cell_volume());
        let rate = 0.5 * P::Space::SOLID_ANGLE * section * ceiling * chi * density;
        let count = f64::from(cell.end - cell.begin);
        let trials = draw_whole(count * rate * majorant * kernel.step, stream);
        self.report.tally.trials += trials;
        for _ in 0..trials {
            let trial = self.propose(cell, majorant, stream);
            let slot = stream.random_range(0..crowd);
            if trial.is_hopeless {
                continue;
            }
            let Trial {
                first,
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
            self.try_pair(cell, &trial, second, [largest, ceiling], stream);
        }
    }

    /// Cross section times chi of the pairs of largest particles, over `largest^(D-1)` and the chi of equal ones.
    fn pair_ceiling(&self, cell: Cell, largest: f64) -> f64 {
        if P::Sizes::UNIFORM {
            1.0
        } else {
            self.pair_share(cell, [largest; 2], largest).max(1.0)
        }
    }

    /// The same of pairs of given diameters.
    fn pair_share(&self, cell: Cell, diameters: [f64; 2], largest: f64) -> f64 {
        let chi = P::Space::contact_value(cell.packing.min(0.9));
        let pair = self
            .kernel
            .pair_factor(chi, cell.packing.min(0.9), diameters);
        pair / (P::Space::cross_section(largest) * chi)
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
        let restitution = kernel.scene.restitution().normal(relative.inner(&normal));
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
            self.around.set(place, velocity, outcome.spins[number]);
            let cell = kernel.grid.cell_at(pair[number].position);
            self.speeds.note(cell, velocity);
        }
        let tally = &mut self.report.tally;
        tally.collisions += 1;
        tally.separation += apart.square().sqrt();
        tally.virial += kernel.weight * apart.inner(&((after[0] - velocities[0]) * masses[0]));
        if kernel.looks {
            self.report.log.push(Collision {
                time: kernel.time,
                position: pair[0].position,
                relative,
                line,
                reduced_mass: masses[0] * masses[1] / (masses[0] + masses[1]),
                restitution,
                weight: kernel.weight,
            });
        }
        apart
    }
}

impl Cell {
    /// The places of its simulators.
    pub(super) fn places(self) -> impl Iterator<Item = At> + Clone {
        (self.begin..self.end).map(move |index| At {
            tile: self.tile,
            index,
        })
    }
}
