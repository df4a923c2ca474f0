//! Free flight of the simulators of a tile in a time step, and their migration to other tiles.

use stosszahl_model::random::Streams;
use stosszahl_model::{Field, ParticleModel, Space, VectorOf};

use crate::boundary::{FlightTiming, GridBoundaries, Ledgers, Origin, Passage};
use crate::grid::{Grid, offset_number};
use crate::particle::{DisplacementTracking, Simulator, SimulatorOf};
use crate::tile::{DepartedSimulator, Migrant, Scratch, SendBuffer, Tile, code, fit};

/// Free-flight phase of all simulators, between the collisions of two time steps.
pub(crate) struct FreeFlight<'a, P: ParticleModel> {
    pub(crate) scene: &'a P,
    pub(crate) grid: &'a Grid<P::Space>,
    /// Duration of the free-flight phase \[time\].
    pub(crate) duration: f64,
    /// Boundary conditions during the flight; `None` if the box is periodic.
    pub(crate) passage: Option<Passage<'a, P>>,
}

impl<'a, P: ParticleModel> FreeFlight<'a, P> {
    /// Prepares a free-flight phase. `weight` is the number of particles per simulator, unless
    /// regions have other weights.
    pub(crate) fn new(
        scene: &'a P,
        grid: &'a Grid<P::Space>,
        surroundings: Option<&'a GridBoundaries<P>>,
        weight: f64,
        streams: Streams,
        timing: FlightTiming,
    ) -> Self {
        let passage = surroundings
            .map(|surroundings| Passage::new(scene, surroundings, weight, streams, timing));
        Self {
            scene,
            grid,
            duration: timing.duration,
            passage,
        }
    }

    /// Returns the box sides by which positions beyond an edge are wrapped directly \[length\];
    /// zero or infinite along axes where wrapping needs more care.
    fn wrapping_lengths(&self) -> VectorOf<P> {
        let has_obstacles = |passage: &Passage<'_, P>| passage.surroundings.obstacles().is_some();
        match &self.passage {
            // Obstacles may block the path across a periodic face.
            Some(passage) if has_obstacles(passage) => P::Space::from_components(|_| f64::INFINITY),
            // Images in a shear flow are displaced.
            _ if self.grid.domain().images().shear().is_some() => VectorOf::<P>::default(),
            _ => self.grid.images(),
        }
    }

    /// Returns the largest deviation of a flight path from a straight line along each axis by the
    /// field, |a| t^2/8 \[length\].
    fn bend(&self) -> VectorOf<P> {
        let acceleration = self.scene.field().acceleration();
        P::Space::from_components(|axis| {
            0.125 * acceleration[axis].abs() * self.duration * self.duration
        })
    }
}

/// Buffers for simulators that leave a tile in a free flight: to adjacent tiles, and farther.
struct Exits<'a, P: ParticleModel, F: DisplacementTracking<P::Space>> {
    near: &'a mut Vec<(u8, Migrant<P, F>)>,
    far: &'a mut Vec<(u32, Migrant<P, F>)>,
}

impl<P, F> Tile<P, F>
where
    P: ParticleModel,
    F: DisplacementTracking<P::Space>,
{
    /// Moves the sorted simulators of a tile by a free flight; those that stay are kept in the
    /// tile, the others put into send buffers.
    pub(crate) fn fly(
        &mut self,
        flight: &FreeFlight<'_, P>,
        scratch: &mut Scratch<P, F>,
        outbox: &mut SendBuffer<P, F>,
    ) {
        if let Some(passage) = &flight.passage {
            let surroundings = passage.surroundings;
            if !self.is_even || !surroundings.is_far_from(&self.place, flight.bend()) {
                self.fly_between(flight, passage, scratch, outbox);
                return;
            }
        }
        let (scene, grid, duration) = (flight.scene, flight.grid, flight.duration);
        let (sorted, leavers) = (&mut scratch.sorted, &mut scratch.leavers);
        leavers.clear();
        outbox.far.clear();
        let total = sorted.len();
        // Taken out, so that the compiler knows that nothing else points to them.
        let mut simulators = std::mem::take(&mut self.simulators);
        let mut codes = std::mem::take(&mut self.codes);
        let mut ledgers = std::mem::take(&mut self.ledgers);
        simulators.truncate(total);
        fit(&mut simulators, total);
        fit(&mut codes, total);
        simulators.resize(total, SimulatorOf::<P, F>::default());
        codes.resize(total, 0);
        let lengths = flight.wrapping_lengths();
        let field = scene.field();
        let place = self.place;
        let width = place.sides[0] as usize;
        let mut stayed = 0;
        let mut begin = self.starts[0] as usize;
        for line in 0..self.lines.len() {
            let end = self.starts[(line + 1) * width] as usize;
            // The counts of this line's cells become those of the simulators that stay, added from
            // here on.
            for (index, simulator) in sorted[begin..end].iter().enumerate() {
                let Simulator {
                    mut position,
                    mut velocity,
                    tag,
                    mut mark,
                    spin,
                } = *simulator;
                let way = flight_displacement::<P>(field, velocity, duration);
                field.move_particle(&mut position, &mut velocity, duration);
                F::add_displacement(&mut mark, way);
                let mut inside = true;
                let position = P::Space::from_components(|axis| {
                    let x = position[axis];
                    let x = x + if x < 0.0 { lengths[axis] } else { 0.0 };
                    // A tiny negative coordinate becomes the length itself.
                    let x = x - if x >= lengths[axis] {
                        lengths[axis]
                    } else {
                        0.0
                    };
                    inside &= (place.low[axis] <= x) & (x < place.high[axis]);
                    x
                });
                if inside {
                    codes[stayed] = code::<P>(grid, &place, position);
                    simulators[stayed] = Simulator {
                        position,
                        velocity,
                        tag,
                        mark,
                        spin,
                    };
                    stayed += 1;
                    continue;
                }
                // In a separate function: shared or addressed values would live in memory, for all
                // simulators that stay.
                let origin = self.origin(grid, line, begin + index);
                let mut exits = Exits {
                    near: &mut *leavers,
                    far: &mut outbox.far,
                };
                let moved = if let (Some(passage), Some(ledgers)) = (&flight.passage, &mut ledgers)
                {
                    self.depart_between(grid, passage, simulator, origin, &mut exits, ledgers)
                } else {
                    let moved = Simulator {
                        position,
                        velocity,
                        tag,
                        mark,
                        spin,
                    };
                    self.depart(grid, moved, origin.cell, &mut exits)
                };
                if let Some(moved) = moved {
                    codes[stayed] = code::<P>(grid, &place, moved.position);
                    simulators[stayed] = moved;
                    stayed += 1;
                }
            }
            begin = end;
            self.lines[line] = stayed as u32;
        }
        simulators.truncate(stayed);
        codes.truncate(stayed);
        (self.simulators, self.codes, self.ledgers) = (simulators, codes, ledgers);
        self.count_cells();
        outbox.fill(leavers);
    }

    /// Returns the random-number address of a sorted simulator before its flight: its cell, and its
    /// order in the cell. `line` is its line of cells.
    fn origin(&self, grid: &Grid<P::Space>, line: usize, index: usize) -> Origin {
        let width = self.place.sides[0] as usize;
        let cells = &self.starts[line * width..=(line + 1) * width];
        let column = cells.partition_point(|&start| start as usize <= index) - 1;
        Origin {
            cell: self.line_number(grid, line as u32) + column as u32,
            order: index as u32 - cells[column],
        }
    }

    /// Counts the simulators in each cell of the tile that stayed in the tile after a free flight.
    fn count_cells(&mut self) {
        self.starts.fill(0);
        for &code in &self.codes {
            self.starts[usize::from(code)] += 1;
        }
    }

    /// Puts a moved simulator into the send buffer for the tile that it enters; returns it, with
    /// wrapped position, if that is this tile.
    #[cold]
    #[inline(never)]
    fn depart(
        &self,
        grid: &Grid<P::Space>,
        mut moved: SimulatorOf<P, F>,
        source: u32,
        exits: &mut Exits<'_, P, F>,
    ) -> Option<SimulatorOf<P, F>> {
        moved.position = grid.domain().wrap(moved.position);
        let tile = self.place.tile;
        let to = grid.owner(grid.cell_at(moved.position));
        if to == tile {
            return Some(moved);
        }
        let traveller = DepartedSimulator {
            source,
            simulator: moved,
        };
        match offset_number(grid.tiles(), tile, to) {
            Some(number) => exits.near.push((number as u8, traveller)),
            None => exits.far.push((grid.tile_number(to) as u32, traveller)),
        }
        None
    }

    /// Moves one simulator by a free flight between walls and obstacles, and puts it into a send
    /// buffer if it leaves the tile. Returns it if it stays.
    #[cold]
    #[inline(never)]
    fn depart_between(
        &self,
        grid: &Grid<P::Space>,
        passage: &Passage<'_, P>,
        simulator: &SimulatorOf<P, F>,
        origin: Origin,
        exits: &mut Exits<'_, P, F>,
        ledgers: &mut Ledgers<P::Space>,
    ) -> Option<SimulatorOf<P, F>> {
        let mut moved = *simulator;
        if !passage.travel::<F>(&mut moved, origin, ledgers) {
            return None;
        }
        let mut staying = None;
        // All cells of this tile have one weight, so at most one copy comes back.
        let stay = |simulator| staying = Some(simulator);
        self.land(grid, passage, moved, origin, exits, ledgers, stay);
        staying
    }

    /// Delivers a moved simulator to its new cell, in as many copies as the weight there requires:
    /// to this tile through `stay`, or into send buffers.
    #[expect(
        clippy::too_many_arguments,
        reason = "all that changes is apart, so that it can be borrowed"
    )]
    fn land(
        &self,
        grid: &Grid<P::Space>,
        passage: &Passage<'_, P>,
        mut simulator: SimulatorOf<P, F>,
        origin: Origin,
        exits: &mut Exits<'_, P, F>,
        ledgers: &mut Ledgers<P::Space>,
        mut stay: impl FnMut(SimulatorOf<P, F>),
    ) {
        simulator.position = grid.domain().wrap(simulator.position);
        let cell = grid.cell_at(simulator.position);
        for _ in 0..passage.copies::<F>(&simulator, origin, grid.number(cell), ledgers) {
            if let Some(simulator) = self.depart(grid, simulator, origin.cell, exits) {
                stay(simulator);
            }
        }
    }

    /// Moves one simulator by a free flight if it meets no boundary, stays in the tile, and keeps
    /// its weight. `None` otherwise; `clear` is the part of the box without contacts.
    #[inline]
    fn fly_clear(
        &self,
        flight: &FreeFlight<'_, P>,
        simulator: &SimulatorOf<P, F>,
        clear: Option<[VectorOf<P>; 2]>,
        cell: u32,
        passage: &Passage<'_, P>,
    ) -> Option<SimulatorOf<P, F>> {
        let [low, high] = clear?;
        let mut moved = *simulator;
        let field = flight.scene.field();
        let way = flight_displacement::<P>(field, moved.velocity, flight.duration);
        field.move_particle(&mut moved.position, &mut moved.velocity, flight.duration);
        F::add_displacement(&mut moved.mark, way);
        let (from, to, place) = (simulator.position, moved.position, &self.place);
        let is_clear = (0..P::Space::DIMENSION).all(|axis| {
            let within = |x: f64| low[axis] <= x && x <= high[axis];
            within(from[axis])
                && within(to[axis])
                && place.low[axis] <= to[axis]
                && to[axis] < place.high[axis]
        });
        let stays = is_clear && {
            let surroundings = passage.surroundings;
            let there = flight.grid.number(flight.grid.cell_at(to));
            self.is_even || surroundings.factor(there) == surroundings.factor(cell)
        };
        stays.then_some(moved)
    }

    /// Moves the sorted simulators of a tile near walls or other boundaries by a free flight, as
    /// [`Self::fly`] does elsewhere.
    fn fly_between(
        &mut self,
        flight: &FreeFlight<'_, P>,
        passage: &Passage<'_, P>,
        scratch: &mut Scratch<P, F>,
        outbox: &mut SendBuffer<P, F>,
    ) {
        let grid = flight.grid;
        let Scratch {
            sorted, leavers, ..
        } = scratch;
        leavers.clear();
        outbox.far.clear();
        let mut exits = Exits {
            near: leavers,
            far: &mut outbox.far,
        };
        let mut simulators = std::mem::take(&mut self.simulators);
        let mut codes = std::mem::take(&mut self.codes);
        let mut ledgers = std::mem::take(&mut self.ledgers).unwrap_or_default();
        simulators.clear();
        codes.clear();
        fit(&mut simulators, sorted.len());
        fit(&mut codes, sorted.len());
        let place = self.place;
        let clear = passage.surroundings.clear_part(&place, flight.bend());
        let width = place.sides[0] as usize;
        for line in 0..self.lines.len() {
            for column in 0..width {
                let local = line * width + column;
                let at = self.cell_at(local);
                let cell = grid.number(at);
                let mut stay = |simulator: SimulatorOf<P, F>| {
                    codes.push(code::<P>(grid, &place, simulator.position));
                    simulators.push(simulator);
                };
                let members = self.starts[local] as usize..self.starts[local + 1] as usize;
                let count = members.len() as u32;
                for (order, simulator) in sorted[members].iter().enumerate() {
                    let origin = Origin {
                        cell,
                        order: order as u32,
                    };
                    if let Some(moved) = self.fly_clear(flight, simulator, clear, cell, passage) {
                        stay(moved);
                        continue;
                    }
                    let mut moved = *simulator;
                    if passage.travel::<F>(&mut moved, origin, &mut ledgers) {
                        let (exits, ledgers) = (&mut exits, &mut ledgers);
                        self.land(grid, passage, moved, origin, exits, ledgers, &mut stay);
                    }
                }
                passage.let_in::<F>(grid, at, count, &mut ledgers, |entered, origin, ledgers| {
                    self.land(
                        grid, passage, entered, origin, &mut exits, ledgers, &mut stay,
                    );
                });
            }
            self.lines[line] = simulators.len() as u32;
        }
        (self.simulators, self.codes, self.ledgers) = (simulators, codes, Some(ledgers));
        self.count_cells();
        outbox.fill(leavers);
    }
}

/// Returns the displacement of a particle in a free flight \[length\].
#[inline(always)]
fn flight_displacement<P: ParticleModel>(
    field: &P::Field,
    velocity: VectorOf<P>,
    duration: f64,
) -> VectorOf<P> {
    if P::Field::FREE {
        velocity * duration
    } else {
        (velocity + field.acceleration() * (0.5 * duration)) * duration
    }
}
