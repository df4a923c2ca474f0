//! Collisions with a partner from where the line of centres says.

use rand::{Rng, RngExt};
use stosszahl_model::{
    Collision, Encounter, Physics, Restitution, Sizes, Space, Vector, VectorOf, collide,
};

use super::arm::{self, Arm};
use super::partners::{Aim, Search};
use super::shared::{Around, At};
use super::speeds::{Near, note};
use super::{Bounds, Rates, Report};
use crate::boundary::Surroundings;
use crate::collide::{Kernel, covered, draw_whole, index, nearest_image};
use crate::density::{Crowding, Scheme};
use crate::grid::{Grid, OFFSETS, offset};
use crate::simulator::{Follow, SimulatorOf};

/// What works around a tile.
pub(super) struct Worker<'a, 'b, 'c, P: Physics, F: Follow<P::Space>> {
    pub(super) kernel: &'a Kernel<'a, P>,
    pub(super) rates: &'a Rates<P::Space>,
    pub(super) arm: &'a Arm,
    /// Of the tile and all next to it together.
    pub(super) bounds: Bounds,
    pub(super) near: Near<VectorOf<P>>,
    pub(super) around: Around<'b, 'c, P, F>,
    pub(super) report: Report,
}

/// A cell whose simulators look for partners.
#[derive(Clone, Copy)]
pub(super) struct Cell {
    pub(super) at: [u32; 3],
    pub(super) tile: u32,
    begin: u32,
    end: u32,
    /// Units around, itself included, what boundaries leave of the room for them, and their packing fraction.
    units: f64,
    crowding: Crowding,
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
    pub(super) fn collide(mut self) -> Report {
        let number = self.around.middle();
        let kernel = self.kernel;
        let mut search = Search::new(
            kernel.grid,
            kernel.partner_radius,
            kernel.scene.sizes(),
            kernel.mean_radius,
        );
        let home = self.around.tile(number);
        let place = home.place;
        if !kernel.density.scheme().bounds_trials() {
            for local in 0..home.cells() {
                if kernel.stop.is_raised() {
                    break;
                }
                self.collide_in(number, local, &mut search);
            }
            return self.report;
        }
        for block in home.speeds.blocks(&place) {
            self.near = Near::new(&self.around, block);
            for [begin, end] in block.lines(&place) {
                if kernel.stop.is_raised() {
                    return self.report;
                }
                for local in begin..end {
                    self.collide_in(number, local, &mut search);
                }
            }
        }
        self.report
    }

    /// Collides the simulators of a cell of a tile, by its number there.
    fn collide_in(&mut self, tile: u32, local: usize, search: &mut Search<'_, P>) {
        let Some(cell) = self.cell(tile, local) else {
            return;
        };
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
        if collisions == 0 {
            return;
        }
        if cell.limited {
            tally.limited_collisions += collisions;
        }
        let each = 2.0 * collisions as f64;
        let count = f64::from(cell.end - cell.begin);
        if each > tally.busiest_cell * count {
            tally.busiest_cell = each / count;
        }
        let virial = tally.virial - virial;
        (self.around).count(tile, local, kernel.weight * collisions as f64, virial);
    }

    /// A cell of a tile, if it is not empty.
    fn cell(&mut self, tile: u32, local: usize) -> Option<Cell> {
        let kernel = self.kernel;
        let home = self.around.tile(tile);
        let (begin, end) = (home.starts[local], home.starts[local + 1]);
        if begin == end {
            return None;
        }
        let at = home.cell_at(local);
        let own = covered::<P, F>(kernel.scene.sizes(), home.members(local));
        let units = kernel.density.around(at, own);
        let crowding = kernel.density.crowding(at);
        let (_, limited, packing) = kernel.density.value_of(units * crowding.bodies);
        self.report.tally.active_cells += 1;
        self.report.tally.limited_cells += u64::from(limited);
        Some(Cell {
            at,
            tile,
            begin,
            end,
            units,
            crowding,
            packing,
            limited,
        })
    }

    /// Draws one of the simulators of a cell, a line of centres, and the speed along it that a partner must exceed.
    ///
    /// A partner of velocity v' is met at the rate ((v - v') . k)+. With speeds against the middle, none beyond `fastest` R, that
    /// is at most R + v . k: so the line has the density R + v . k, and a partner is accepted with ((v - v') . k)+/(R + v . k).
    /// A line k that is uniform, turned into -k with the probability (R - v . k)/(2 R), has that density, and its mean rate is R
    /// whatever v. What is left of the number that turns it is uniform too: the threshold.
    fn propose(&self, cell: Cell, fastest: f64, stream: &mut impl Rng) -> Trial<VectorOf<P>> {
        let first = At {
            tile: cell.tile,
            index: stream.random_range(cell.begin..cell.end),
        };
        let simulator = self.around.read(first);
        let normal = line::<P::Space>(stream);
        let along = (simulator.velocity - self.near.middle).inner(&normal);
        let number = 2.0 * fastest * stream.random::<f64>();
        // Without a branch, which nobody could foresee.
        let turns = number >= fastest + along;
        let sign = 1.0 - 2.0 * f64::from(u8::from(turns));
        let normal = normal * sign;
        let majorant = fastest + sign * along;
        let threshold = number - f64::from(u8::from(turns)) * (fastest + along);
        Trial {
            first,
            position: simulator.position,
            normal,
            distance: self.kernel.scene.sizes().radius(simulator.tag) + self.kernel.mean_radius,
            threshold,
            majorant,
        }
    }

    /// Collides a trial's simulator with a partner, if they approach fast enough and, where particles differ in size, their
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

    /// Partners around the point of contact, at the rate of Enskog's theory.
    fn around_points(&mut self, cell: Cell, search: &mut Search<'_, P>, stream: &mut impl Rng) {
        let kernel = self.kernel;
        let sizes = kernel.scene.sizes();
        // Room for rounding.
        let fastest = self.near.spread * (1.0 + 1e-12);
        let largest = 2.0 * sizes.largest_radius();
        let section = largest.powi(P::Space::DIMENSION as i32 - 1);
        // Of pairs over pairs of the largest with the chi of equal ones.
        let ceiling = self.pair_ceiling(cell, largest);
        let most = self.rates.most(cell.units, cell.crowding);
        let rate = 0.5 * P::Space::SOLID_ANGLE * section * ceiling * most;
        let count = f64::from(cell.end - cell.begin);
        let trials = draw_whole(count * rate * fastest * kernel.step, stream);
        self.report.tally.trials += trials;
        let class = arm::class(cell.packing, cell.crowding == Crowding::NONE);
        let reach = self.arm.reach(class);
        for number in 0..trials {
            if kernel.stop.is_raised_at(number) {
                break;
            }
            let trial = self.propose(cell, fastest, stream);
            let Trial {
                first,
                position,
                normal,
                distance,
                ..
            } = trial;
            if !P::Sizes::UNIFORM {
                let share = sizes.radius(self.around.read(first).tag) / sizes.largest_radius();
                if stream.random::<f64>() * most >= self.rates.at(cell.units, cell.crowding, share)
                {
                    continue;
                }
                // A search among the small for the partner of a large one may look at ten thousands.
                if kernel.stop.is_raised() {
                    break;
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
        // Room for rounding.
        let fastest = self.near.spread * (1.0 + 1e-12);
        let largest = 2.0 * sizes.largest_radius();
        let section = largest.powi(P::Space::DIMENSION as i32 - 1);
        let ceiling = self.pair_ceiling(cell, largest);
        let Bounds { crowd, chi, .. } = self.bounds;
        // Cells that walls cut are denser than their number says.
        let least = kernel.surroundings.map_or(1.0, Surroundings::least_room);
        let density = f64::from(crowd) * kernel.weight / (least * kernel.grid.cell_volume());
        let rate = 0.5 * P::Space::SOLID_ANGLE * section * ceiling * chi * density;
        let count = f64::from(cell.end - cell.begin);
        let trials = draw_whole(count * rate * fastest * kernel.step, stream);
        self.report.tally.trials += trials;
        for number in 0..trials {
            if kernel.stop.is_raised_at(number) {
                break;
            }
            let trial = self.propose(cell, fastest, stream);
            let slot = stream.random_range(0..crowd);
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
            self.around.set(place, velocity, outcome.spins[number]);
            let cell = kernel.grid.cell_at(pair[number].position);
            if kernel.density.scheme().bounds_trials() {
                note(&mut self.around, place, cell, velocity);
                self.near.note(velocity);
            }
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

/// A random unit vector along a line of any direction, all equally likely; which of its two ends it points to does not matter.
///
/// In the plane without a branch or a call: sine and cosine of half the angle by their series to 1e-9, and a step of Newton's
/// to length one, which leaves the square of that.
#[inline]
fn line<S: Space>(stream: &mut impl Rng) -> S::Vector {
    if S::DIMENSION != 2 {
        return S::random_direction(stream);
    }
    // Half of an angle up to a right one.
    let x = std::f64::consts::FRAC_PI_4 * (2.0 * stream.random::<f64>() - 1.0);
    let s = x * x;
    let sine = x * (1.0 - s / 6.0 * (1.0 - s / 20.0 * (1.0 - s / 42.0 * (1.0 - s / 72.0))));
    let cosine =
        1.0 - s / 2.0 * (1.0 - s / 12.0 * (1.0 - s / 30.0 * (1.0 - s / 56.0 * (1.0 - s / 90.0))));
    let (a, b) = (cosine * cosine - sine * sine, 2.0 * sine * cosine);
    let scale = 1.5 - 0.5 * (a * a + b * b);
    S::vector(|axis| scale * if axis == 0 { a } else { b })
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
