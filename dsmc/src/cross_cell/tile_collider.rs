//! Collisions of the particles of one tile: candidate pairs, acceptance, and the collision itself.

use std::ops::Range;

use rand::{Rng, RngExt};
use stosszahl_model::{
    CollidingPair, Collision, ParticleModel, Plane, Restitution, Sizes, Space, Vector, VectorOf,
    collide,
};

use super::arm::{self, ContactDistance};
use super::extents::VelocityBox;
use super::halo_copy::HaloCopy;
use super::rate::Rates;
use super::report::{TileBounds, TileReport};
use super::tile_neighbourhood::TileNeighbourhood;
use crate::density::{DensityKernel, FreeVolumeFactors};
use crate::particle::{DisplacementTracking, covered, index};
use crate::scheme::PartnerSelection;
use crate::within_cell::CollisionContext;

/// Collider of the particles of one tile with partners in that tile and in its neighbours. Created
/// once per tile and time step.
pub(super) struct TileCollider<'a, 'b, 'c, P: ParticleModel, F: DisplacementTracking<P::Space>> {
    pub(super) kernel: &'a CollisionContext<'a, P>,
    /// Local collision rates n χ of the contact-point scheme; `None` for other schemes.
    pub(super) rates: Option<&'a Rates<P::Space>>,
    pub(super) arm: &'a ContactDistance,
    /// Largest contact value χ over the tile and its neighbours: the majorant of the ESMC scheme.
    pub(super) bounds: TileBounds,
    /// True if the number of candidate pairs follows from a speed majorant (all schemes but
    /// stochastic disks).
    pub(super) moves: bool,
    pub(super) around: TileNeighbourhood<'b, 'c, P, F>,
    pub(super) patch: &'a mut HaloCopy<P>,
    pub(super) cells: Vec<Cell<P::Space>>,
    pub(super) drawn: Vec<Candidate<VectorOf<P>>>,
    pub(super) report: TileReport,
}

/// Line of cells of a tile along the first axis: its number, row and layer in the tile.
#[derive(Clone, Copy)]
pub(super) struct Line {
    pub(super) number: usize,
    pub(super) row: usize,
    pub(super) layer: usize,
}

/// Cell of the tile that contains simulators, with the rate and the bounds of its collisions.
pub(super) struct Cell<S: Space> {
    /// Index of the cell in its tile.
    pub(super) local: usize,
    /// Column, row and layer of the cell in the box.
    pub(super) at: [u32; 3],
    /// Index range in the halo copy of the cell's simulators.
    pub(super) members: Range<usize>,
    /// Area or volume of the particles in the density neighbourhood of the cell, in units of the
    /// largest particle's.
    pub(super) units: f64,
    /// Free-volume factors of the density neighbourhood of the cell, for the volume that boundaries
    /// take.
    pub(super) crowding: FreeVolumeFactors,
    /// Packing fraction of the density neighbourhood of the cell.
    pub(super) packing: f64,
    /// True if the contact value chi is at its limit at the cell's packing fraction.
    limited: bool,
    /// Class of the cell's packing fraction for the adaptive contact distance.
    pub(super) class: u8,
    /// Cross section times chi for pairs of the largest particles, over the same product for equal
    /// particles at the contact distance.
    pub(super) ceiling: f64,
    /// Majorant in the cell of n χ times the size factor of a pair \[1/length^D\].
    pub(super) most: f64,
    /// Expected number of candidate pairs per simulator of the cell in this time step.
    pub(super) rate: f64,
    /// Bounding box of the velocities of all possible partners of the cell's simulators.
    pub(super) extent: VelocityBox<S>,
    pub(super) collisions: u64,
    pub(super) virial: f64,
}

/// Candidate of a collision: a simulator with a random line of centres, for which a partner is then
/// sought.
#[derive(Clone, Copy)]
pub(super) struct Candidate<V> {
    /// Index of the simulator's cell in the list of cells of the current piece of a line.
    pub(super) cell: usize,
    /// Index of the simulator in the halo copy.
    pub(super) first: usize,
    pub(super) position: V,
    /// Random number from 0 to 2^32 that picks the partner among several.
    pub(super) pick: u64,
    /// Random number from 0 to 1 that decides the direction along the line of centres and the
    /// acceptance threshold.
    chance: f64,
    /// Line of centres as it was drawn, a unit vector whose sign is not yet chosen.
    line: V,
    /// Distance of the two centres at contact \[length\], for a partner of the mean radius.
    pub(super) distance: f64,
    /// Velocity of the simulator when direction and threshold were chosen \[length/time\]: they are
    /// chosen again if it has changed.
    pub(super) velocity: V,
    /// Unit vector from the simulator towards its partner.
    pub(super) normal: V,
    /// Speed of the simulator along `normal` \[length/time\], relative to the shear flow at a
    /// partner of the mean radius.
    pub(super) along: f64,
    /// Normal approach speed above which the candidate pair is accepted \[length/time\].
    pub(super) threshold: f64,
    /// Upper bound of the normal approach speed of the candidate pair \[length/time\].
    majorant: f64,
}

impl<'a, 'b, 'c, P, F> TileCollider<'a, 'b, 'c, P, F>
where
    P: ParticleModel,
    F: DisplacementTracking<P::Space>,
{
    /// Creates the collider of one tile and its neighbours, `around`; `patch` is the memory of the
    /// halo copy to fill.
    pub(super) fn new(
        kernel: &'a CollisionContext<'a, P>,
        rates: Option<&'a Rates<P::Space>>,
        arm: &'a ContactDistance,
        bounds: TileBounds,
        mut around: TileNeighbourhood<'b, 'c, P, F>,
        patch: &'a mut HaloCopy<P>,
    ) -> Self {
        let report = TileReport {
            log: around.take_log(),
            ..TileReport::default()
        };
        Self {
            kernel,
            rates,
            arm,
            bounds,
            moves: kernel.density.scheme().partners() != PartnerSelection::Overlap,
            around,
            patch,
            cells: Vec::new(),
            drawn: Vec::new(),
            report,
        }
    }

    /// Prepares a cell for its collisions, with packing fraction and bounds; `None` if it is empty.
    /// `column` is its place in the line of cells.
    #[inline(always)]
    pub(super) fn cell(
        &mut self,
        line: Line,
        columns: usize,
        column: usize,
    ) -> Option<Cell<P::Space>> {
        let kernel = self.kernel;
        let sizes = kernel.scene.sizes();
        let here = self.patch.own_cell([column, line.row, line.layer]);
        let members = self.patch.members(here, 1);
        if members.is_empty() {
            return None;
        }
        let at = self.cell_of(line, column);
        let local = column + columns * line.number;
        let own = if kernel.density.looks_around() {
            0.0
        } else {
            covered::<P>(sizes, members.clone().map(|who| self.patch.tag(who)))
        };
        let mut units = kernel.density.around(at, own);
        if self.is_halfway() {
            units -= kernel.density.share_of([0; 3]);
        }
        let crowding = kernel.density.crowding(at);
        let known = self.rates.and_then(|rates| rates.known(units, crowding));
        let (packing, limited, class) = if let Some(known) = known {
            (known.packing, known.limited, known.class)
        } else {
            let covered = units * crowding.bodies;
            let packing = covered * kernel.density.unit();
            let class = arm::class(packing, crowding == FreeVolumeFactors::NONE);
            (packing, kernel.density.is_limited(covered), class)
        };
        self.report.tally.active_cells += 1;
        self.report.tally.limited_cells += u64::from(limited);
        let ceiling = if sizes.are_equal() {
            1.0
        } else {
            let largest = 2.0 * sizes.largest_radius();
            pair_share(kernel, packing, [largest; 2], largest).max(1.0)
        };
        Some(Cell {
            local,
            at,
            members,
            units,
            crowding,
            packing,
            limited,
            class,
            ceiling,
            most: 0.0,
            rate: 0.0,
            extent: VelocityBox::empty(),
            collisions: 0,
            virial: 0.0,
        })
    }

    /// Returns column, row and layer in the box of a cell in a line of the tile.
    #[inline(always)]
    pub(super) fn cell_of(&self, line: Line, column: usize) -> [u32; 3] {
        let [x, y, z] = self.around.home().place.first;
        [
            x + column as u32,
            y + line.row as u32,
            z + line.layer as u32,
        ]
    }

    /// Adds the collisions and the virial of one finished cell to the counters of the tile.
    #[inline(always)]
    pub(super) fn close(&mut self, cell: &Cell<P::Space>) {
        if cell.collisions == 0 {
            return;
        }
        let tally = &mut self.report.tally;
        if cell.limited {
            tally.limited_collisions += cell.collisions;
        }
        let (each, count) = (2.0 * cell.collisions as f64, cell.members.len() as f64);
        if each > tally.busiest_cell * count {
            tally.busiest_cell = each / count;
        }
        let weighed = self.kernel.weight * cell.collisions as f64;
        self.around
            .count(self.around.middle(), cell.local, weighed, cell.virial);
    }

    /// Draws a candidate: a random line of centres for the simulator `first`, and the acceptance
    /// threshold of the approach speed.
    ///
    /// A partner of velocity u collides at the rate ((v - u) . k)+, at most w(k) = h(k) + v . k,
    /// where h(k) is the largest -u . k over the velocity box. Both ends of a line together have
    /// w(k) + w(-k) = h(k) + h(-k), the sum of the box sides times `|k_i|`, whatever v. So the line
    /// is drawn with that density and its end with weights w(k) and w(-k); a partner is accepted
    /// with ((v - u) . k)+/w(k). The remainder of the number that chose the end is uniform too, and
    /// serves as the threshold.
    #[inline(always)]
    pub(super) fn propose(
        &self,
        cell: usize,
        first: usize,
        extent: &VelocityBox<P::Space>,
        pick: u64,
        stream: &mut impl Rng,
    ) -> Candidate<VectorOf<P>> {
        let line = line_of_centres::<P::Space>(extent.sides(), stream);
        let radius = self.kernel.scene.sizes().radius(self.patch.tag(first));
        let trial = Candidate {
            cell,
            first,
            position: self.patch.position(first),
            pick,
            chance: stream.random(),
            line,
            distance: radius + self.kernel.mean_radius,
            velocity: VectorOf::<P>::default(),
            normal: line,
            along: 0.0,
            threshold: 0.0,
            majorant: 0.0,
        };
        self.direct(trial, extent)
    }

    /// Chooses the sign of a candidate's line of centres, and the acceptance threshold, for the
    /// simulator's current velocity.
    #[inline(always)]
    pub(super) fn direct(
        &self,
        trial: Candidate<VectorOf<P>>,
        extent: &VelocityBox<P::Space>,
    ) -> Candidate<VectorOf<P>> {
        let (line, velocity) = (trial.line, self.patch.velocities[trial.first]);
        let sides = extent.sides();
        let both: f64 = (0..P::Space::DIMENSION)
            .map(|axis| sides[axis] * line[axis].abs())
            .sum();
        let number = both * trial.chance;
        let along = velocity.inner(&line);
        let one = extent.against(line) + along;
        // Branch-free, because the condition is unpredictable.
        let turns = f64::from(u8::from(number >= one));
        let sign = 1.0 - 2.0 * turns;
        Candidate {
            velocity,
            normal: line * sign,
            along: along * sign + self.approach_by_flow(line) * trial.distance,
            threshold: number - turns * one,
            majorant: turns * both + sign * one,
            ..trial
        }
    }

    /// Returns the approach speed that a uniform shear flow gives to partners along `normal`, per
    /// unit of their distance: `-a n_x n_y` \[1/time\].
    #[inline(always)]
    pub(super) fn approach_by_flow(&self, normal: VectorOf<P>) -> f64 {
        -self.kernel.flow.rate * (normal[0] * normal[1])
    }

    /// Tests a candidate with its partner, and collides them if they approach fast enough and, for
    /// unequal sizes, a random number accepts their cross section relative to `ceiling`. Returns
    /// their distance along the line of centres \[contact distances\]; `None` if rejected.
    #[inline(always)]
    pub(super) fn try_pair(
        &mut self,
        cell: &mut Cell<P::Space>,
        trial: &Candidate<VectorOf<P>>,
        second: usize,
        ceiling: f64,
        stream: &mut impl Rng,
    ) -> Option<f64> {
        let mut speed = trial.along - self.patch.velocities[second].inner(&trial.normal);
        let sizes = self.kernel.scene.sizes();
        if self.kernel.flow.rate != 0.0 {
            let excess = sizes.radius(self.patch.tag(second)) - self.kernel.mean_radius;
            speed += self.approach_by_flow(trial.normal) * excess;
        }
        self.report.tally.majorant_violations += u64::from(speed > trial.majorant * (1.0 + 1e-12));
        if speed <= trial.threshold {
            return None;
        }
        let radii = [trial.first, second].map(|who| sizes.radius(self.patch.tag(who)));
        if !sizes.are_equal() {
            let largest = 2.0 * sizes.largest_radius();
            let diameters = radii.map(|radius| 2.0 * radius);
            let share = pair_share(self.kernel, cell.packing, diameters, largest);
            debug_assert!(share <= ceiling * (1.0 + 1e-12));
            if stream.random::<f64>() * ceiling >= share {
                return None;
            }
        }
        let contact = radii[0] + radii[1];
        let virial = self.report.tally.virial;
        let apart = self.strike([trial.first, second], trial.normal, contact);
        cell.collisions += 1;
        cell.virial += self.report.tally.virial - virial;
        Some(-apart.inner(&trial.normal) / contact)
    }

    /// Returns true if the density is counted around the point halfway to contact; never in three
    /// dimensions, which the compiler sees here.
    #[inline(always)]
    pub(super) fn is_halfway(&self) -> bool {
        P::Space::DIMENSION == 2 && self.kernel.density.weighing() == DensityKernel::Triangle
    }

    /// Executes the collision of a pair along `normal`, from the first to the second, with its
    /// counters and log. Returns the vector from the second to the first \[length\].
    #[inline(always)]
    pub(super) fn strike(
        &mut self,
        who: [usize; 2],
        normal: VectorOf<P>,
        contact: f64,
    ) -> VectorOf<P> {
        let kernel = self.kernel;
        let sizes = kernel.scene.sizes();
        let places = who.map(|index| self.patch.home(index));
        let pair = places.map(|at| self.around.read(at));
        let before = pair.map(|simulator| simulator.velocity);
        let apart = kernel
            .grid
            .nearest_image(pair[0].position - pair[1].position);
        let line = -normal * contact;
        // In a shear flow partners feel it over the distance that carries their momentum, so that
        // the energy of peculiar motion balances.
        let is_sheared = kernel.flow.rate != 0.0;
        let overlaps = kernel.density.scheme().partners() == PartnerSelection::Overlap;
        let felt = if is_sheared && !overlaps { line } else { apart };
        let slip = kernel.flow.rate * felt[1];
        let mut velocities = before;
        velocities[0][0] += slip;
        let masses = pair.map(|simulator| sizes.mass(simulator.tag));
        let relative = velocities[0] - velocities[1];
        let kinds = [0, 1].map(|who| sizes.species_of(pair[who].tag));
        let law = (kernel.scene.restitution()).separation(kinds, relative.inner(&normal));
        let encounter = CollidingPair {
            velocities,
            spins: pair.map(|simulator| simulator.spin),
            masses,
            radii: pair.map(|simulator| sizes.radius(simulator.tag)),
            line,
        };
        let outcome = collide(kernel.scene, &encounter, law);
        let mut after = outcome.velocities;
        after[0][0] -= slip;
        for number in 0..2 {
            self.around
                .set(places[number], after[number], outcome.spins[number]);
            self.patch.set(who[number], after[number], self.moves);
        }
        let tally = &mut self.report.tally;
        tally.collisions += 1;
        tally.separation += apart.square().sqrt();
        let gained = (after[0] - before[0]) * masses[0];
        tally.virial += kernel.weight * felt.inner(&gained);
        if kernel.looks {
            self.report.log.push(Collision {
                time: kernel.time,
                position: pair[0].position.spatial(),
                relative_velocity: relative.spatial(),
                line: if is_sheared { felt } else { line }.spatial(),
                reduced_mass: masses[0] * masses[1] / (masses[0] + masses[1]),
                restitution: law.coefficient,
                added_speed: law.added_speed,
                momentum_transfer: felt.spatial() * gained.spatial().transpose(),
                weight: kernel.weight,
                pair: [0, 1].map(|who| index::<P>(pair[who].tag)),
                species: kinds,
            });
        }
        apart
    }
}

/// Returns the sum of the components of a vector.
#[inline(always)]
pub(super) fn total<S: Space>(vector: S::Vector) -> f64 {
    (0..S::DIMENSION).map(|axis| vector[axis]).sum()
}

/// Returns cross section times chi of a pair with these diameters, over `largest^(D-1)` times the
/// chi of equal particles.
pub(super) fn pair_share<P: ParticleModel>(
    kernel: &CollisionContext<'_, P>,
    packing: f64,
    diameters: [f64; 2],
    largest: f64,
) -> f64 {
    let packing = packing.min(0.9);
    let chi = P::Space::contact_value(packing);
    kernel.pair_factor(chi, packing, diameters) / (P::Space::cross_section(largest) * chi)
}

/// Draws a random line of centres k whose density is the sum of `sides` times `|k_i|`. One axis is
/// chosen in proportion to its side; the component along it has the density `|k_i|`. In three
/// dimensions its square is then uniform, in two dimensions the other component is.
#[inline(always)]
pub(super) fn line_of_centres<S: Space>(sides: S::Vector, stream: &mut impl Rng) -> S::Vector {
    let pick = total::<S>(sides) * stream.random::<f64>();
    if S::DIMENSION == 2 {
        // The remainder of the number that chose the axis is uniform from -1 to 1. Branch-free,
        // because the condition is unpredictable.
        let first = f64::from(u8::from(pick < sides[0]));
        let second = 1.0 - first;
        let left = pick - second * sides[0];
        let side = first * sides[0] + second * sides[1];
        let other = (2.0 * left / side - 1.0).clamp(-1.0, 1.0);
        let along = (1.0 - other * other).sqrt();
        let both = [
            first * along + second * other,
            first * other + second * along,
        ];
        return S::from_components(|axis| both[axis]);
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
    S::from_components(|axis| match (axis + 3 - chosen) % 3 {
        0 => square.sqrt(),
        other => around[other - 1],
    })
}
