//! Collisions of pairs within cells by the no-time-counter method: candidate pairs, acceptance, and
//! displacement of partners.

use rand::RngExt;
use stosszahl_model::random::StreamBundle;
use stosszahl_model::{
    CollidingPair, Collision, Interrupt, ParticleModel, Restitution, Separation, Sizes, Space,
    Vector, VectorOf, collide, equation_of_state,
};

use crate::boundary::{CutCell, GridBoundaries};
use crate::density::Density;
use crate::extrema::{larger, smaller};
use crate::grid::Grid;
use crate::particle::{DisplacementTracking, SimulatorOf, covered, index};
use crate::random_counts::{draw_pair, draw_whole};
use crate::scheme::PartnerDisplacement;
use crate::tally::{CollisionCounters, StepBounds};
use crate::tile::Tile;

/// Data shared by all collisions of one time step: particle model, grid, density, step length,
/// streams and flags.
pub(crate) struct CollisionContext<'a, P: ParticleModel> {
    pub(crate) scene: &'a P,
    pub(crate) grid: &'a Grid<P::Space>,
    pub(crate) density: &'a Density<P::Space>,
    /// True if pairs within a cell collide; if false, only speeds and energies are updated.
    pub(crate) collides: bool,
    /// Displacement of the partners of a collision within a cell.
    pub(crate) displacement: PartnerDisplacement,
    /// Radius around the point of contact within which all simulators are equally likely partners
    /// \[length\].
    pub(crate) partner_radius: f64,
    /// Mean radius of the particles \[length\].
    pub(crate) mean_radius: f64,
    /// Number of particles per simulator where the weight factor is one.
    pub(crate) weight: f64,
    /// Walls, obstacles, inflows and weights of the box; `None` if it is periodic.
    pub(crate) surroundings: Option<&'a GridBoundaries<P>>,
    /// Moment ratio `M_(D-1)/M_D` of the particle diameters \[1/length\].
    pub(crate) moment_ratio: f64,
    /// Uniform shear flow that partners within a cell feel.
    pub(crate) flow: CellFlow,
    /// Relative speed that a pair may gain by the collisions of one time step, by two contacts of
    /// each partner \[length/time\]; 0 for laws that only dissipate.
    pub(crate) heating: f64,
    /// Length of the time step \[time\].
    pub(crate) step: f64,
    /// Time at the middle of the time step \[time\].
    pub(crate) time: f64,
    /// Random streams of the time step, addressed by cell.
    pub(crate) streams: StreamBundle,
    /// Inverse of the unit of integer energy sums \[1/energy\].
    pub(crate) units: f64,
    /// True if collisions are logged for observers.
    pub(crate) looks: bool,
    /// True if tiles are processed by several threads.
    pub(crate) parallel: bool,
    /// Interrupt that breaks off the time step.
    pub(crate) stop: &'a Interrupt,
}

/// Uniform shear flow u = (a y, 0) as it acts between partners within a cell. Velocities of
/// simulators are relative to the flow.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CellFlow {
    /// Shear rate a of the flow \[1/time\]; 0 without a flow.
    pub(crate) rate: f64,
    /// True if partners count as a contact distance apart in the shear flow, see
    /// [`crate::Scheme::feels_flow`].
    pub(crate) is_felt: bool,
}

/// Results of the collisions of a tile in one step: counters, speed bounds and log.
struct Report<'a, P: ParticleModel> {
    tally: CollisionCounters,
    stock: StepBounds<P::Space>,
    log: &'a mut Vec<Collision>,
}

impl<P: ParticleModel> Report<'_, P> {
    /// Adds the numbers of candidates and collisions of one cell with `count` simulators to the
    /// counters of the tile.
    #[inline(always)]
    fn close(&mut self, cell: &Cell, count: u64, trials: u64, collisions: u64) {
        let tally = &mut self.tally;
        tally.trials += trials;
        tally.collisions += collisions;
        if cell.limited {
            tally.limited_collisions += collisions;
        }
        let each = 2.0 * collisions as f64;
        if each > tally.busiest_cell * count as f64 {
            tally.busiest_cell = each / count as f64;
        }
    }
}

/// Cell or sub-cell with its collision rate, contact value and weight.
struct Cell {
    /// Address of the cell's random stream in this step.
    address: u64,
    /// Number of particles per simulator in the cell.
    weight: f64,
    /// Expected number of candidates per pair and unit of relative speed in this step
    /// \[time/length\], for pairs of the largest cross section.
    rate: f64,
    chi: f64,
    limited: bool,
    packing: f64,
    /// Largest product of cross section and contact value chi of any pair \[length^(D-1)\].
    ceiling: f64,
}

/// Pair of simulators accepted for a collision, with relative velocity and normal.
struct Pair<V> {
    /// Indices of the two simulators in their cell.
    who: [usize; 2],
    /// Velocity of the first simulator relative to the second \[length/time\]; in a shear flow that
    /// they feel, at their positions at contact.
    relative: V,
    /// Unit vector along the line of centres, from the second simulator to the first at contact.
    normal: V,
    /// Approach speed of the pair along `normal` \[length/time\].
    approach: f64,
    /// Number of particles per simulator of the pair.
    weight: f64,
}

impl<P> CollisionContext<'_, P>
where
    P: ParticleModel,
{
    /// Executes the collisions of all cells of a tile, whose simulators are `sorted`, and updates
    /// its largest speeds and energy.
    pub(crate) fn collide<F: DisplacementTracking<P::Space>>(
        &self,
        tile: &mut Tile<P, F>,
        sorted: &mut [SimulatorOf<P, F>],
    ) {
        if tile.split_cells.is_empty() {
            self.collide_tile::<F, false>(tile, sorted);
        } else {
            self.collide_tile::<F, true>(tile, sorted);
        }
    }

    /// Executes the collisions of all cells of a tile; `SPLIT` is true if obstacles split some
    /// cells. Not inlined: in the sweep it would have too few registers, and write half as much
    /// again to memory.
    #[inline(never)]
    fn collide_tile<F: DisplacementTracking<P::Space>, const SPLIT: bool>(
        &self,
        tile: &mut Tile<P, F>,
        sorted: &mut [SimulatorOf<P, F>],
    ) {
        let mut report = Report::<P> {
            tally: tile.tally,
            stock: StepBounds::default(),
            log: &mut tile.log,
        };
        let place = tile.place;
        let mut index = 0;
        for z in 0..place.sides[2] {
            for y in 0..place.sides[1] {
                if self.stop.is_raised() {
                    break;
                }
                let line = [place.first[0], place.first[1] + y, place.first[2] + z];
                for x in 0..place.sides[0] {
                    let range = tile.starts[index] as usize..tile.starts[index + 1] as usize;
                    index += 1;
                    let members = &mut sorted[range];
                    if members.is_empty() {
                        continue;
                    }
                    let at = [line[0] + x, line[1], line[2]];
                    let before = (report.tally.collisions, report.tally.virial);
                    let cut = if SPLIT { self.split_cell(at) } else { None };
                    let weight = if let Some(cut) = cut {
                        self.collide_split::<F>(members, at, cut, &mut report)
                    } else {
                        let widest = self.update_step_bounds::<F>(members, &mut report.stock);
                        let majorant = widest + self.heating;
                        if members.len() < 2 || !self.collides {
                            continue;
                        }
                        let cell = self.cell::<F>(members, at);
                        self.collide_cell::<F>(members, &cell, majorant, &mut report)
                    };
                    if let Some(count) = tile.counts.get_mut(index - 1) {
                        let more = report.tally.collisions - before.0;
                        count.collisions += weight * more as f64;
                        count.virial += report.tally.virial - before.1;
                    }
                }
            }
        }
        let Report { tally, stock, .. } = report;
        (tile.tally, tile.stock) = (tally, stock);
    }

    /// Returns true if walls and open faces allow the centre of a particle of the mean radius at a
    /// position.
    #[inline]
    pub(crate) fn has_room(&self, position: VectorOf<P>) -> bool {
        self.surroundings
            .is_none_or(|surroundings| surroundings.has_room(position, self.mean_radius))
    }

    /// Adds speeds and energy of a cell's simulators to the bounds `stock`. Returns the diagonal of
    /// their velocity box, an upper bound of the relative speed of all pairs \[length/time\].
    #[inline(always)]
    fn update_step_bounds<F: DisplacementTracking<P::Space>>(
        &self,
        members: &[SimulatorOf<P, F>],
        stock: &mut StepBounds<P::Space>,
    ) -> f64 {
        let sizes = self.scene.sizes();
        let [mut low, mut high] = [members[0].velocity; 2];
        let mut squares = VectorOf::<P>::default();
        for member in members {
            let velocity = member.velocity;
            let mass = if sizes.are_equal() {
                1.0
            } else {
                sizes.mass(member.tag)
            };
            low = P::Space::from_components(|axis| smaller(velocity[axis], low[axis]));
            high = P::Space::from_components(|axis| larger(velocity[axis], high[axis]));
            squares = P::Space::from_components(|axis| {
                let square = velocity[axis] * velocity[axis];
                squares[axis]
                    + if sizes.are_equal() {
                        square
                    } else {
                        mass * square
                    }
            });
        }
        let mut twice_energy = squares.inner(&P::Space::from_components(|_| 1.0));
        if sizes.are_equal() {
            twice_energy *= sizes.mass(members[0].tag);
        }
        stock.add_cell(low, high, twice_energy, self.units);
        (high - low).square().sqrt()
    }

    /// Returns the cut cell at a column, row and layer if obstacles split it into sub-cells; `None`
    /// otherwise.
    fn split_cell(&self, at: [u32; 3]) -> Option<&CutCell> {
        self.surroundings.and_then(|all| all.split_cell(at))
    }

    /// Executes the collisions in each sub-cell of a cell that obstacles split. Returns the number
    /// of particles per simulator of the cell.
    #[inline(never)]
    fn collide_split<F: DisplacementTracking<P::Space>>(
        &self,
        members: &mut [SimulatorOf<P, F>],
        at: [u32; 3],
        cut: &CutCell,
        report: &mut Report<'_, P>,
    ) -> f64 {
        let sub_cell =
            |member: &SimulatorOf<P, F>| cut.sub_cell_at([member.position[0], member.position[1]]);
        members.sort_by_key(sub_cell);
        let mut weight = self.weight;
        for members in members.chunk_by_mut(|a, b| sub_cell(a) == sub_cell(b)) {
            let majorant = self.update_step_bounds::<F>(members, &mut report.stock) + self.heating;
            let which = sub_cell(&members[0]);
            let room = self
                .surroundings
                .map_or(0.0, |all| all.room_in(cut, which, at[2]));
            if members.len() >= 2 && self.collides && room > 0.0 {
                let cell = self.sub_cell::<F>(members, at, cut.number(which), room);
                weight = self.collide_cell::<F>(members, &cell, majorant, report);
            }
        }
        weight
    }

    /// Draws candidate pairs in a cell or sub-cell by the no-time-counter method, and collides
    /// those accepted. Returns the number of particles per simulator.
    #[inline(always)]
    fn collide_cell<F: DisplacementTracking<P::Space>>(
        &self,
        members: &mut [SimulatorOf<P, F>],
        cell: &Cell,
        mut majorant: f64,
        report: &mut Report<'_, P>,
    ) -> f64 {
        report.tally.active_cells += 1;
        report.tally.limited_cells += u64::from(cell.limited);
        if self.flow.is_felt && self.flow.rate != 0.0 {
            return self.collide_in_flow::<F>(members, cell, majorant, report);
        }
        let count = members.len() as u64;
        let mut stream = self.streams.stream_at(cell.address);
        let ordered = (count * (count - 1)) as f64;
        let trials = draw_whole(0.5 * ordered * cell.rate * majorant, &mut stream);
        let mut collisions = 0;
        for trial in 0..trials {
            if self.stop.is_raised_at(trial) {
                break;
            }
            let [i, j] = draw_pair(count, &mut stream);
            let relative = members[i].velocity - members[j].velocity;
            let square = relative.square();
            let mut threshold = majorant * stream.random::<f64>();
            if square > majorant * majorant {
                report.tally.majorant_violations += 1;
                majorant = square.sqrt();
            }
            let sizes = self.scene.sizes();
            if !sizes.are_equal() {
                let diameters = [i, j].map(|who| 2.0 * sizes.radius(members[who].tag));
                threshold *= cell.ceiling / self.pair_factor(cell.chi, cell.packing, diameters);
            }
            if square > threshold * threshold {
                collisions += 1;
                let speed = square.sqrt();
                let (normal, along) =
                    P::Space::line_of_centres(relative * (1.0 / speed), &mut stream);
                let pair = Pair {
                    who: [i, j],
                    relative,
                    normal,
                    approach: -along * speed,
                    weight: cell.weight,
                };
                self.collide_pair::<F>(members, &pair, report);
            }
        }
        report.close(cell, count, trials, collisions);
        cell.weight
    }

    /// Executes the collisions in a cell in a uniform shear flow that partners feel. Returns the
    /// number of particles per simulator.
    ///
    /// The line of centres is drawn first, uniformly. The pair collides at a rate proportional to
    /// its approach speed along that line, which includes the flow over the contact distance
    /// (Montanero & Santos, Phys. Rev. E 54, 438 (1996), doi:10.1103/PhysRevE.54.438).
    #[inline(never)]
    fn collide_in_flow<F: DisplacementTracking<P::Space>>(
        &self,
        members: &mut [SimulatorOf<P, F>],
        cell: &Cell,
        majorant: f64,
        report: &mut Report<'_, P>,
    ) -> f64 {
        let sizes = self.scene.sizes();
        // The product n_x n_y is at most a half.
        let mut majorant = majorant + self.flow.rate.abs() * sizes.largest_radius();
        let count = members.len() as u64;
        let mut stream = self.streams.stream_at(cell.address);
        let ordered = (count * (count - 1)) as f64;
        let directions = P::Space::SOLID_ANGLE / P::Space::cross_section(1.0);
        let trials = draw_whole(
            0.5 * ordered * cell.rate * majorant * directions,
            &mut stream,
        );
        let mut collisions = 0;
        for trial in 0..trials {
            if self.stop.is_raised_at(trial) {
                break;
            }
            let [i, j] = draw_pair(count, &mut stream);
            let normal = P::Space::random_direction(&mut stream);
            let mut threshold = majorant * stream.random::<f64>();
            let radii = [i, j].map(|who| sizes.radius(members[who].tag));
            let mut relative = members[i].velocity - members[j].velocity;
            relative[0] += self.flow.rate * ((radii[0] + radii[1]) * normal[1]);
            let approach = -relative.inner(&normal);
            if approach > majorant {
                report.tally.majorant_violations += 1;
                majorant = approach;
            }
            if !sizes.are_equal() {
                let diameters = radii.map(|radius| 2.0 * radius);
                threshold *= cell.ceiling / self.pair_factor(cell.chi, cell.packing, diameters);
            }
            if approach > threshold {
                collisions += 1;
                let pair = Pair {
                    who: [i, j],
                    relative,
                    normal,
                    approach,
                    weight: cell.weight,
                };
                self.collide_pair::<F>(members, &pair, report);
            }
        }
        report.close(cell, count, trials, collisions);
        cell.weight
    }

    /// Returns a cell with its collision rate and contact value, for the simulators `members` in
    /// it.
    #[inline(always)]
    fn cell<F: DisplacementTracking<P::Space>>(
        &self,
        members: &[SimulatorOf<P, F>],
        at: [u32; 3],
    ) -> Cell {
        let number = self.grid.number(at);
        let mut own = covered::<P>(self.scene.sizes(), members.iter().map(|member| member.tag));
        let (mut weight, mut volume) = (self.weight, self.grid.cell_volume());
        if let Some(surroundings) = self.surroundings {
            let factor = surroundings.factor(number);
            own *= factor;
            weight *= factor;
            volume *= surroundings.room(at);
        }
        let density = self.density.contact_value(at, own);
        self.rates(u64::from(number), weight, volume, density)
    }

    /// Returns a sub-cell with its collision rate and contact value, for the simulators `members`
    /// in it. `share` is its fraction of a whole cell.
    fn sub_cell<F: DisplacementTracking<P::Space>>(
        &self,
        members: &[SimulatorOf<P, F>],
        at: [u32; 3],
        sub_cell: usize,
        share: f64,
    ) -> Cell {
        let number = self.grid.number(at);
        let factor = self.surroundings.map_or(1.0, |all| all.factor(number));
        let own = covered::<P>(self.scene.sizes(), members.iter().map(|member| member.tag));
        let place = [sub_cell, at[2] as usize];
        let density = self.density.contact_value_in(place, own * factor, share);
        // Addresses of cells have 32 bits.
        let address = u64::from(number) | (1 + sub_cell as u64) << 32;
        let volume = self.grid.cell_volume() * share;
        self.rates(address, self.weight * factor, volume, density)
    }

    /// Returns a cell with its collision rate in a volume \[length^D\], from contact value chi,
    /// whether that is at its limit, and packing fraction.
    #[inline(always)]
    fn rates(
        &self,
        address: u64,
        weight: f64,
        volume: f64,
        (chi, limited, packing): (f64, bool, f64),
    ) -> Cell {
        let sizes = self.scene.sizes();
        let packing = packing.min(0.9);
        let largest = 2.0 * sizes.largest_radius();
        let ceiling = chi * P::Space::cross_section(largest);
        let ceiling = if sizes.are_equal() {
            ceiling
        } else {
            ceiling.max(self.pair_factor(chi, packing, [largest; 2]))
        };
        Cell {
            address,
            weight,
            rate: ceiling * weight * self.step / volume,
            chi,
            limited,
            packing,
            ceiling,
        }
    }

    /// Returns cross section times contact value chi of a pair with these diameters
    /// \[length^(D-1)\].
    #[inline]
    pub(crate) fn pair_factor(&self, chi: f64, packing: f64, diameters: [f64; 2]) -> f64 {
        P::Space::cross_section(0.5 * (diameters[0] + diameters[1]))
            * equation_of_state::mixture_contact_value(chi, packing, diameters, self.moment_ratio)
    }

    /// Executes the collision of an accepted pair: velocities, spins, displacements, counters and
    /// log.
    #[inline(always)]
    fn collide_pair<F: DisplacementTracking<P::Space>>(
        &self,
        members: &mut [SimulatorOf<P, F>],
        &Pair {
            who: [i, j],
            relative,
            normal,
            approach,
            weight,
        }: &Pair<VectorOf<P>>,
        report: &mut Report<'_, P>,
    ) {
        let sizes = self.scene.sizes();
        let radii = [i, j].map(|who| sizes.radius(members[who].tag));
        let masses = [i, j].map(|who| sizes.mass(members[who].tag));
        let line = normal * (radii[0] + radii[1]);
        let before = [i, j].map(|who| members[who].velocity);
        // Flow at the first minus flow at the second.
        let slip = if self.flow.is_felt {
            self.flow.rate * line[1]
        } else {
            0.0
        };
        let mut velocities = before;
        velocities[0][0] += slip;
        let kinds = [i, j].map(|who| sizes.species_of(members[who].tag));
        let law = (self.scene.restitution()).separation(kinds, approach);
        let pair = CollidingPair {
            velocities,
            spins: [i, j].map(|who| members[who].spin),
            masses,
            radii,
            line,
        };
        let outcome = collide(self.scene, &pair, law);
        let mut after = outcome.velocities;
        after[0][0] -= slip;
        let apart = self
            .grid
            .nearest_image(members[i].position - members[j].position);
        report.tally.separation += apart.square().sqrt();
        let gained = (after[0] - before[0]) * masses[0];
        let carried_over = match self.flow {
            CellFlow { rate: 0.0, .. } => apart,
            // At contact, or as points, so that the peculiar energy balances.
            CellFlow { is_felt: true, .. } => line,
            CellFlow { .. } => VectorOf::<P>::default(),
        };
        let mut virial = carried_over.inner(&gained);
        members[i].velocity = after[0];
        members[j].velocity = after[1];
        [members[i].spin, members[j].spin] = outcome.spins;
        let share = match self.displacement {
            PartnerDisplacement::None => 0.0,
            PartnerDisplacement::Diameter => 1.0,
            PartnerDisplacement::Inelastic => inelastic_displacement(law, approach),
        };
        let mut transfer = None;
        if share > 0.0 {
            let line = line * share;
            let carried = after[0] * masses[0] - after[1] * masses[1];
            virial += line.inner(&carried);
            transfer = Some(line.spatial() * carried.spatial().transpose());
            for (who, by) in [(i, line), (j, -line)] {
                members[who].position += by;
                F::add_displacement(&mut members[who].mark, by);
            }
        }
        report.tally.virial += weight * virial;
        if self.looks {
            report.log.push(Collision {
                time: self.time,
                position: members[i].position.spatial(),
                relative_velocity: relative.spatial(),
                line: line.spatial(),
                reduced_mass: masses[0] * masses[1] / (masses[0] + masses[1]),
                restitution: law.coefficient,
                added_speed: law.added_speed,
                momentum_transfer: carried_over.spatial() * gained.spatial().transpose()
                    + transfer.unwrap_or_default(),
                weight,
                pair: [i, j].map(|who| index::<P>(members[who].tag)),
                species: kinds,
            });
        }
    }
}

/// Displacement of both partners along the line of centres, over the contact distance, after which
/// the collision carries the momentum of a contact: `(g + s)/(2 s)` with normal speeds g before and
/// s after it; `(1 + r)/(2 r)` for a constant coefficient.
pub(crate) fn inelastic_displacement(law: Separation, approach: f64) -> f64 {
    if law.added_speed == 0.0 {
        0.5 * (1.0 + law.coefficient) / law.coefficient
    } else {
        0.5 * (1.0 + approach / law.speed(approach))
    }
}
