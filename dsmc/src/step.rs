//! Time stepping of a DSMC engine: choice of the time step, sorting, collisions, free flight, and
//! exchange of simulators between tiles.

use std::collections::BTreeMap;
use std::iter;

use stosszahl_model::random::Purpose;
use stosszahl_model::{
    Field, Observer, ParticleModel, Recorder, Restitution, Sizes, Space, Vector,
};

use crate::boundary::{CutCell, FlightTiming};
use crate::cross_cell::TilePeers;
use crate::decomposition::Subdomain;
use crate::density::DensityKernel;
use crate::engine::DsmcEngine;
use crate::features::PROCESSES;
use crate::flight::FreeFlight;
use crate::particle::{DisplacementTracking, covered};
use crate::pause::Pause;
use crate::scheme::PartnerSelection;
use crate::sweep::sweep;
use crate::tally::{EnergyUnit, StepBounds, StepCounters};
use crate::threads::is_parallel;
use crate::tile::{Arrivals, Migrant, SendBuffer, Tile};
use crate::within_cell::{CellFlow, CollisionContext};

impl<P, F> DsmcEngine<P, F>
where
    P: ParticleModel,
    F: DisplacementTracking<P::Space>,
{
    /// Advances the gas by whole time steps to `until` \[time\], with the last step shortened to
    /// end there exactly, or for `most_steps`. Returns `true` if the time was reached; `false` also
    /// if [`DsmcEngine::set_stop_flag`] stopped it or [`DsmcEngine::set_pause_flag`] paused it.
    /// After a pause, the next call with the same time continues as if there had been none.
    pub fn advance(&mut self, until: f64, most_steps: u64, observer: &mut dyn Observer) -> bool {
        if self.stop.has_ended() {
            return false;
        }
        self.scatter_tiles();
        self.balance();
        let mut recorder = Recorder::new(observer);
        let mut left = most_steps;
        let resumed = self.pause.take().filter(|pause| pause.until == until);
        let mut settled = resumed.is_some();
        let mut step = match resumed {
            Some(pause) if left > 0 => {
                self.time = pause.time;
                pause.step
            }
            _ => {
                let Some(step) = self.next_step(self.time, until, left) else {
                    return until <= self.time;
                };
                let before = self.flight_before(0.5 * step);
                self.fly_only(before);
                settled = false;
                step
            }
        };
        loop {
            left -= 1;
            let end = if step >= until - self.time {
                until
            } else {
                self.time + step
            };
            let next = self.next_step(end, until, left);
            // The two half flights between collisions form one flight.
            let flight = 0.5 * (step + next.unwrap_or(0.0));
            self.step(step, flight, settled, &mut recorder);
            settled = false;
            self.time = end;
            if self.ends() {
                return false;
            }
            let Some(next) = next else { break };
            if self.is_paused() {
                self.sort_simulators();
                // The flight has covered half of the next step.
                self.time = end + 0.5 * next;
                self.pause = Some(Pause {
                    until,
                    time: end,
                    step: next,
                });
                return false;
            }
            step = next;
        }
        self.sort_simulators();
        until <= self.time
    }

    /// Returns true if the run was asked to stop; in a decomposed gas, if all processes have been
    /// told so in the last step.
    fn ends(&mut self) -> bool {
        match &self.share {
            Some(share) if !share.ends => return false,
            Some(_) => self.stop.interrupt().raise(),
            None => {}
        }
        self.stop.ends()
    }

    /// Returns true if the run was asked to pause; in a decomposed gas, if all processes have been
    /// told so in the last step.
    fn is_paused(&self) -> bool {
        match &self.share {
            Some(share) => share.pauses,
            None => self.stop.is_paused(),
        }
    }

    /// Returns the length of the next time step, which begins at `from` \[time\]; `None` if `until`
    /// is reached or no step is left.
    fn next_step(&self, from: f64, until: f64, steps_left: u64) -> Option<f64> {
        let left = until - from;
        if left.is_nan() || left <= 0.0 || steps_left == 0 {
            return None;
        }
        let step = self.held_step.unwrap_or_else(|| self.step_length());
        // Equal last steps instead of a long and a tiny one.
        let steps = (left / step).ceil();
        if steps <= 1.0 {
            return Some(left);
        }
        let step = if steps.is_finite() {
            left / steps
        } else {
            step
        };
        // Difference of the rounded clock readings, so that positions and clock do not drift apart;
        // at least the smallest step that the clock resolves.
        let end = (from + step).max(from.next_up());
        Some(end - from)
    }

    /// Returns the time step that the gas allows \[time\], from its state before the last
    /// collisions: several steps for the fastest simulator to cross a cell, and as many in a mean
    /// free time.
    fn step_length(&self) -> f64 {
        let width = self.grid.width();
        // Cross-cell schemes search partners anew in each step, so crossing a cell does not matter.
        let axes = if self.parameters.scheme.is_cross_cell() {
            0
        } else {
            P::Space::DIMENSION
        };
        let acceleration = self.scene.field().acceleration();
        let forced = |axis: usize| match &self.surroundings {
            Some(surroundings) => surroundings.speeds()[axis],
            None => 0.0,
        };
        let crossing = (0..axes)
            .map(|axis| {
                let (speed, width) = (self.stock.speeds[axis], width[axis]);
                let pull = acceleration[axis].abs();
                if P::Field::FREE && self.surroundings.is_none() {
                    return width / speed;
                }
                // Time t with v t + a t^2/2 = width.
                let speed = speed.max(forced(axis));
                2.0 * width / (speed + (speed * speed + 2.0 * pull * width).sqrt())
            })
            .fold(f64::MAX, f64::min);
        let degrees = P::Space::DIMENSION * self.simulators.max(1);
        let temperature = self.stock.twice_energy(self.unit) / degrees as f64;
        // The mean mass is one in the program's units.
        let mean_speed = P::Space::MEAN_SPEED * temperature.sqrt();
        // A shear flow rotates velocities during flight.
        let crossing = crossing.min(1.0 / self.scene.field().shear_rate().abs());
        let step = if self.density.collides() {
            crossing.min(self.constants.mean_free_path / mean_speed)
        } else {
            crossing
        };
        // A gas at rest allows any step that can be added to another.
        (step / self.parameters.steps_per_cell_crossing).min(1e150)
    }

    /// Computes the largest speeds and the kinetic energy of the current gas, from which the next
    /// time step is chosen.
    pub(crate) fn update_step_bounds(&mut self) {
        let sizes = self.scene.sizes();
        let mut total = 0.0;
        for simulator in self.ordered() {
            total += sizes.mass(simulator.tag) * simulator.velocity.square();
        }
        let unit = EnergyUnit::for_total(total);
        let mut stock = StepBounds::default();
        for simulator in self.ordered() {
            let v = simulator.velocity;
            let twice_energy = sizes.mass(simulator.tag) * v.square();
            stock.add_cell(v, v, twice_energy, unit.inverse());
        }
        (self.stock, self.unit) = (stock, unit);
    }

    /// Executes one time step: the collisions, and the free flight of duration `flight` after them.
    /// `was_settled` is true if tiles are sorted already.
    fn step(&mut self, step: f64, flight: f64, was_settled: bool, recorder: &mut Recorder<'_>) {
        let begin = self.time + 0.5 * step;
        self.move_walls(begin);
        let parallel = is_parallel(self.simulators);
        let across = self.parameters.scheme.is_cross_cell();
        let around = self.density.looks_around();
        let weighs = self.weighs_anew();
        let settled = was_settled || around || across || weighs;
        if settled && !was_settled {
            self.sort_simulators();
        }
        if weighs {
            self.follow_number();
        }
        if around {
            self.look_around(parallel);
        }
        if !self.parameters.scheme.is_cross_cell() {
            self.grid.slide(flight);
        }
        let unit = EnergyUnit::for_total(self.stock.twice_energy(self.unit));
        let timing = FlightTiming {
            number: 2 * self.tally.steps + 1,
            begin,
            duration: flight,
        };
        let kernel = CollisionContext {
            scene: &self.scene,
            grid: &self.grid,
            density: &self.density,
            collides: self.density.collides(),
            displacement: self.parameters.displacement,
            weight: self.constants.weight,
            moment_ratio: self.constants.moment_ratio,
            flow: CellFlow {
                rate: self.scene.field().shear_rate(),
                is_felt: self.parameters.scheme.properties().feels_flow,
            },
            heating: 2.0 * self.scene.restitution().max_added_speed(),
            partner_radius: self.constants.partner_radius,
            mean_radius: self.constants.mean_radius,
            step,
            surroundings: self.surroundings.as_ref(),
            time: begin,
            streams: self.streams.bundle(Purpose::Collisions, self.tally.steps),
            units: unit.inverse(),
            looks: recorder.looks(),
            parallel,
            stop: self.stop.interrupt(),
        };
        if self.parameters.scheme.is_cross_cell() {
            let (tiles, arm, tally) = (&mut self.tiles, &mut self.arm, &mut self.tally);
            let (peers, rates) = (tile_peers(self.share.as_ref()), self.rates.as_ref());
            let halo_copies = &self.halo_copies;
            for (number, report) in
                kernel.collide_across(tiles, peers, rates, arm, tally, halo_copies)
            {
                recorder.pass(&report.log);
                // The memory is reused in the next step.
                let log = &mut tiles[number as usize].log;
                *log = report.log;
                log.clear();
            }
            self.fly_only(timing);
            self.close_step(unit);
            return;
        }
        let arrivals = Arrivals {
            boxes: &self.arriving,
            far: &self.far,
        };
        let grid = &self.grid;
        let boundaries = self.surroundings.as_ref();
        let weight = self.constants.weight;
        let flight = FreeFlight::new(&self.scene, grid, boundaries, weight, self.streams, timing);
        sweep(
            parallel,
            &mut self.tiles,
            &mut self.departing,
            &self.pool,
            |tile, outbox, scratch| {
                if settled {
                    std::mem::swap(&mut tile.simulators, &mut scratch.sorted);
                } else {
                    tile.arrange(grid, &arrivals, scratch);
                }
                kernel.collide(tile, &mut scratch.sorted);
                tile.fly(&flight, scratch, outbox);
            },
        );
        self.exchange(true, recorder.looks());
        for tile in &mut self.tiles {
            recorder.pass(&tile.log);
            tile.log.clear();
        }
        self.close_step(unit);
    }

    /// Moves vibrating walls to their positions at a time \[time\], and updates the free volume of
    /// cells.
    fn move_walls(&mut self, time: f64) {
        if let Some(surroundings) = self.surroundings.as_mut().filter(|all| all.vibrates()) {
            surroundings.set_time(&self.grid, time);
            surroundings.leave_room(&mut self.density);
        }
    }

    /// Reduces the largest speeds and the energy over all tiles at the end of a time step; the next
    /// one is chosen from them.
    fn close_step(&mut self, unit: EnergyUnit) {
        self.unit = unit;
        self.stock = match &self.share {
            Some(share) => share.stock,
            None => self
                .tiles
                .iter()
                .fold(StepBounds::default(), |mut sum, tile| {
                    sum.add(&tile.stock);
                    sum
                }),
        };
        if self.stock.is_full() {
            // From rest or an empty box: an upper bound, which the next step improves.
            let total = self.simulators as f64 * self.constants.mean_mass;
            let most = total * self.stock.speeds.square();
            self.unit = EnergyUnit::for_total(most);
            self.stock.set_twice_energy(most, self.unit);
        }
        self.tally.steps += 1;
    }

    /// Returns the timing of the free flight before a time step, from the current time on. Each
    /// step has a flight after it, and one before it where a run starts or continues.
    fn flight_before(&self, duration: f64) -> FlightTiming {
        FlightTiming {
            number: 2 * self.tally.steps,
            begin: self.time,
            duration,
        }
    }

    /// Executes a free flight of all simulators from sorted tiles, without collisions before it.
    fn fly_only(&mut self, timing: FlightTiming) {
        self.grid.slide(timing.duration);
        let (grid, boundaries) = (&self.grid, self.surroundings.as_ref());
        let weight = self.constants.weight;
        let flight = FreeFlight::new(&self.scene, grid, boundaries, weight, self.streams, timing);
        sweep(
            is_parallel(self.simulators),
            &mut self.tiles,
            &mut self.departing,
            &self.pool,
            |tile, outbox, scratch| {
                std::mem::swap(&mut tile.simulators, &mut scratch.sorted);
                tile.fly(&flight, scratch, outbox);
            },
        );
        self.exchange(false, false);
    }

    /// Sorts the simulators of all tiles by cell.
    fn sort_simulators(&mut self) {
        let grid = &self.grid;
        let arrivals = Arrivals {
            boxes: &self.arriving,
            far: &self.far,
        };
        sweep(
            is_parallel(self.simulators),
            &mut self.tiles,
            &mut self.departing,
            &self.pool,
            |tile, _, scratch| {
                tile.arrange(grid, &arrivals, scratch);
                tile.settle(scratch);
            },
        );
    }

    /// Delivers simulators that left their tile, and sums the counters of all tiles: those of
    /// boundaries, and those of collisions if `collided`.
    fn exchange(&mut self, collided: bool, looks: bool) {
        std::mem::swap(&mut self.departing, &mut self.arriving);
        self.far.clear();
        for outbox in &mut self.arriving {
            self.far.append(&mut outbox.far);
        }
        if let (None, None, [only]) = (&self.share, &self.surroundings, &self.tiles[..]) {
            // One tile needs no exact summation, and steps of small gases are short.
            if collided {
                self.tally.add(&only.tally);
            }
        } else {
            self.count(collided, looks);
        }
        let order = |(tile, traveller): &(u32, Migrant<P, F>)| (*tile, traveller.source);
        self.far.sort_by_key(order);
        if self.surroundings.is_some() && self.share.is_none() {
            let travelling = self.arriving.iter().map(SendBuffer::near).sum::<usize>();
            let staying = self.tiles.iter().map(|tile| tile.simulators.len());
            self.simulators = self.far.len() + travelling + staying.sum::<usize>();
        }
    }

    /// Sums the counters of all tiles, and exchanges simulators and counters with other processes.
    fn count(&mut self, collided: bool, looks: bool) {
        let mut counts = StepCounters::default();
        for tile in self.tiles.iter_mut().filter(|tile| tile.is_here) {
            if collided {
                counts.add(&tile.tally);
            }
            if let Some(ledgers) = &mut tile.ledgers {
                counts.take_ledgers(ledgers);
            }
        }
        let counts = self.exchange_with_others(counts, looks);
        counts.enter(&mut self.tally, &mut self.ledgers);
    }

    /// Updates the local packing fraction in the window around every cell.
    fn look_around(&mut self, parallel: bool) {
        let (grid, tiles, sizes) = (&self.grid, &self.tiles, self.scene.sizes());
        let surroundings = self.surroundings.as_ref();
        let units = |tile: &Tile<P, F>, local: usize| {
            let units = covered::<P>(sizes, tile.members(local).iter().map(|member| member.tag));
            let factor =
                surroundings.map_or(1.0, |all| all.factor(grid.number(tile.cell_at(local))));
            (units * factor) as f32
        };
        // Units in the sub-cells of a split cell.
        let split = |tile: &Tile<P, F>, local: usize| -> Vec<f32> {
            let cell = tile.cell_at(local);
            let Some(cut) = surroundings.and_then(|all| all.split_cell(cell)) else {
                return Vec::new();
            };
            let mut units = vec![0.0; cut.count()];
            for member in tile.members(local) {
                let place = [member.position[0], member.position[1]];
                if let Some(sum) = units.get_mut(cut.sub_cell_at(place)) {
                    *sum += covered::<P>(sizes, iter::once(member.tag));
                }
            }
            let factor = surroundings.map_or(1.0, |all| all.factor(grid.number(cell)));
            units.iter().map(|units| (units * factor) as f32).collect()
        };
        let contents = |tile: &Tile<P, F>| {
            let split_cells = tile.split_cells.iter();
            (0..tile.cells())
                .map(|cell| units(tile, cell))
                .chain(split_cells.flat_map(|&cell| split(tile, cell)))
                .collect::<Vec<f32>>()
        };
        let reach = self.density.reach();
        // Wide margin of schemes that read the density between a simulator and its partner.
        let is_wide = self.density.scheme().partners() == PartnerSelection::ContactCell
            || self.density.weighing() == DensityKernel::Triangle;
        let others = match &self.share {
            Some(share) if PROCESSES => share.units_around(grid, tiles, reach, is_wide, contents),
            _ => BTreeMap::new(),
        };
        let rows = grid.counts()[1];
        self.density.slide(self.grid.offset_columns());
        self.density.update(parallel, &|line, values| {
            let line = line as u32;
            let mut x = 0;
            while x < values.len() {
                let cell = [x as u32, line % rows, line / rows];
                let (number, first) = grid.locate(cell);
                let tile = &tiles[number];
                let width = tile.place.sides[0] as usize;
                let there = &mut values[x..x + width];
                if tile.is_here {
                    for (value, local) in there.iter_mut().zip(first..) {
                        *value = units(tile, local);
                    }
                } else if let Some(known) = others.get(&number) {
                    there.copy_from_slice(&known[first..first + width]);
                } else {
                    // Too far away to matter for any window here.
                    there.fill(0.0);
                }
                x += width;
            }
        });
        let mut last = (None, Vec::new());
        self.density.update_windows(|member, layer| {
            let cell = [member.cell[0], member.cell[1], layer];
            let (number, local) = grid.locate(cell);
            let tile = &tiles[number];
            let known = others.get(&number);
            let Some(sub_cell) = member.sub_cell else {
                return f64::from(match known {
                    _ if tile.is_here => units(tile, local),
                    Some(known) => known[local],
                    None => 0.0,
                });
            };
            if last.0 != Some(cell) {
                last = (
                    Some(cell),
                    match known {
                        _ if tile.is_here => split(tile, local),
                        Some(known) => {
                            let count = |local: usize| {
                                let cut = surroundings
                                    .and_then(|all| all.split_cell(tile.cell_at(local)));
                                cut.map_or(0, CutCell::count)
                            };
                            let before = tile.split_cells.iter().take_while(|&&one| one < local);
                            let first = tile.cells() + before.map(|&one| count(one)).sum::<usize>();
                            known[first..first + count(local)].to_vec()
                        }
                        None => Vec::new(),
                    },
                );
            }
            last.1.get(sub_cell).map_or(0.0, |&units| f64::from(units))
        });
    }
}

/// Returns the interface to other processes for cross-cell collisions; `None` for a single process.
fn tile_peers<P: ParticleModel, F: DisplacementTracking<P::Space>>(
    share: Option<&Subdomain<P::Space>>,
) -> Option<&dyn TilePeers<P, F>> {
    if PROCESSES {
        share.map(|share| share as &dyn TilePeers<P, F>)
    } else {
        None
    }
}
