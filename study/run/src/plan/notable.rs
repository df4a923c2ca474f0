//! Warnings about a case before it is run, with rules of thumb for numerical errors of the engines,
//! and derived quantities.

use stosszahl_case::format::{FaceSpec, PlacementSpec, VelocitiesSpec, VelocityWord};
use stosszahl_dsmc::{ContactLaw, Parameters, PartnerSelection, SimulatorStart};
use stosszahl_model::equation_of_state;
use stosszahl_model::initial::SEQUENTIAL_LIMIT;
use stosszahl_results::{engine_title, format_number, format_percent};

use super::data::{CasePlan, DerivedQuantity, EngineKind, EnginePlan, SpeciesPlan, in_space};

/// Relative error of the collision rate of a within-cell scheme, times the simulators per cell.
/// Measured at 1.27 disks per cell and packing 0.25: 26 %, with displaced partners and with the
/// free volume of each cell.
pub(crate) const RATE_ERROR_IN_A_CELL: f64 = 1.0 / 3.0;
/// Relative error of the collision rate of ESMC, times the simulators per particle.
const RATE_ERROR_OF_ESMC: f64 = 0.3;
/// Relative error of the kinetic energy over that of the collision rate: late in free cooling K is
/// proportional to the rate to the power -2.
const ENERGY_OVER_RATE: f64 = 2.0;
/// Number of simulators per cell below which profiles along walls or gravity are unreliable; the
/// default is ten.
const FEW_IN_FLOWS: f64 = 5.0;
/// Effect of a scheme's theoretical collision rate, over the margin of the case, from which `check`
/// reports it.
const NOTABLE_RATE: f64 = 0.5;
/// Cell width in mean free paths above which cells transport momentum too far.
const WIDE: f64 = 2.0;
/// Cell width in mean free paths above which cells blur profiles along walls or gravity.
const WIDE_IN_FLOWS: f64 = 1.0;
/// Share of the collision rate that walls may cost `dsmc-contact-point` without a warning.
const NOTABLE_WALLS: f64 = 0.02;
/// Height of a box in T/(m g) above which a warning says that a gas without heating falls and comes
/// to rest.
const FALLS: f64 = 5.0;
/// Default number of elastic collisions per particle before the start, over `sqrt(phi) chi`.
/// Density waves as long as the box of 600 disks, which relax last, need so many at packings from
/// 0.2 to 0.44.
const SOUND: f64 = 10.0;
/// Smallest default number of elastic collisions per particle before the start. Distances up to 1.3
/// diameters need 4 at any packing.
const LEAST_EQUILIBRATION: f64 = 10.0;
/// Largest default number of elastic collisions per particle before the start. At packings that
/// need more, the crystal is the equilibrium and stays.
const MOST_EQUILIBRATION: f64 = 100.0;

impl CasePlan {
    /// Returns the number of elastic collisions per particle before the start. Default for disks in
    /// a periodic box that the program places: 10, and more at packings above 0.3, `10 sqrt(phi)
    /// chi` up to 100.
    pub fn equilibration(&self) -> f64 {
        let melts = self.is_disk_fluid() && !self.starts_as_given();
        let crowded = SOUND * self.gas.packing_fraction.sqrt() * self.gas.contact_value;
        let default = if melts {
            crowded
                .ceil()
                .clamp(LEAST_EQUILIBRATION, MOST_EQUILIBRATION)
        } else {
            0.0
        };
        self.case.start.equilibration.unwrap_or(default)
    }

    /// Returns true if the velocities of the start are drawn after the elastic equilibration, which
    /// would make them Maxwellian.
    pub fn draws_after_equilibration(&self) -> bool {
        let placed = self.case.start.placement == PlacementSpec::File;
        let own = match self.case.start.velocities {
            VelocitiesSpec::Drawn(_) => true,
            VelocitiesSpec::Word(word) => word == VelocityWord::File && !placed,
        };
        own && self.equilibration() > 0.0
    }

    /// Returns true if the case gives the positions of the start, which elastic collisions would
    /// change.
    pub fn starts_as_given(&self) -> bool {
        self.case.start.placement == PlacementSpec::File || self.case.start.region.is_some()
    }

    /// Returns the number of collisions per particle after which equilibration ends, whatever its
    /// tests say.
    pub fn longest_equilibration(&self) -> f64 {
        let most = self.case.start.longest_equilibration;
        most.unwrap_or_else(|| (4.0 * self.equilibration()).max(200.0))
    }

    /// Returns warnings about settings of the case that are allowed but questionable.
    pub(super) fn notable(&self) -> Vec<String> {
        let mut list = Vec::new();
        if self.case.replicas == 1 {
            list.push("replicas = 1: no error bars; at least 2 replicas give a spread".to_owned());
        }
        self.notable_shear(&mut list);
        if self.has_box() {
            self.notable_start(&mut list);
        } else {
            self.notable_without_box(&mut list);
        }
        if !self.is_uniform() {
            self.notable_fall(&mut list);
        }
        self.notable_region(&mut list);
        list.extend(self.implausible());
        for engine in &self.engines {
            if let EngineKind::MonteCarlo(parameters) = &engine.kind {
                self.notable_engine(engine, parameters, &mut list);
            }
        }
        if self.is_uniform() {
            self.notable_errors(&mut list);
        }
        list
    }

    /// Warns that exact disks in a shear flow run on one thread.
    fn notable_shear(&self, list: &mut Vec<String>) {
        if self.is_sheared() && self.engines.iter().any(EnginePlan::is_exact) {
            list.push(
                "box.shear_rate: one gas of exact disks runs on one thread, as its rows of cells slide all at once; replicas and points \
                 of a sweep use several"
                    .to_owned(),
            );
        }
    }

    fn notable_without_box(&self, list: &mut Vec<String>) {
        let few = self.gas.species.iter().filter(|one| one.count < 10).count();
        if few > 0 && self.case.aggregation.is_none() {
            list.push(format!(
                "{few} of {} species have fewer than 10 particles: their temperatures fluctuate by more than a quarter",
                self.gas.species.len()
            ));
        }
        if self.gas.packing_fraction > 1.0 {
            list.push(format!(
                "the packing fraction is {}: no such gas exists; the Boltzmann equation is solved for it",
                format_number(self.gas.packing_fraction)
            ));
        }
    }

    fn notable_start(&self, list: &mut Vec<String>) {
        let lattice = match self.case.start.placement {
            PlacementSpec::Square | PlacementSpec::Hexagonal => true,
            PlacementSpec::Disordered => {
                self.case.start.region.is_none() && self.gas.packing_fraction > SEQUENTIAL_LIMIT
            }
            PlacementSpec::File => false,
        };
        if lattice && self.is_disk_fluid() && self.equilibration() == 0.0 {
            list.push(
                "start.equilibration = 0: the gas starts from a lattice; some tens of elastic collisions per particle melt it, \
                 and the start is tested for that"
                    .to_owned(),
            );
        }
        if self.is_uniform() && self.count() < 10 {
            list.push(format!(
                "{} particles: kinetic theory holds for many; below 10 the comparison with it says little",
                self.count()
            ));
        }
        let velocities = (self.gas.file.as_ref()).is_some_and(|file| file.velocities.is_some());
        if velocities && self.case.start.velocities != VelocitiesSpec::FILE {
            list.push(
                "the start file has velocities, which are not used: start.velocities = \"file\" uses them".to_owned(),
            );
        }
        self.notable_bath(list);
    }

    /// Warns of a gas that falls onto a wall and is not heated.
    fn notable_fall(&self, list: &mut Vec<String>) {
        let gravity = self.gravity();
        let walls = || {
            self.case.walls.all_faces().filter_map(|face| match face {
                FaceSpec::Wall(wall) => Some(wall),
                FaceSpec::Word(_) => None,
            })
        };
        let heated = walls().any(|wall| wall.temperature.is_some() || wall.vibration.is_some());
        let damped = walls().any(|wall| {
            wall.restitution.is_some_and(|kept| kept < 1.0)
                || wall.slip.is_some_and(|kept| kept.abs() < 1.0)
        });
        let loses = !self.is_elastic() || damped;
        if !loses || heated || !self.case.inflow.is_empty() {
            return;
        }
        let masses = self
            .gas
            .species
            .iter()
            .map(|one| one.count as f64 * one.mass);
        let mass = masses.sum::<f64>() / self.count() as f64;
        let stops = |axis: &usize| {
            let side = usize::from(gravity[*axis] > 0.0);
            self.case.walls.face_at(*axis, side).is_wall()
        };
        let depths = (0..self.gas.dimension)
            .filter(stops)
            .map(|axis| mass * gravity[axis].abs() * self.gas.lengths[axis] / self.gas.temperature);
        let deepest = depths.fold(0.0, f64::max);
        if deepest > FALLS {
            list.push(format!(
                "gravity: the box is {} T/(m g) high and nothing heats the gas, so it falls and comes to rest in a bed. A bed has far more \
                 collisions than the start, from which work and time are estimated; Monte Carlo does not hold one up",
                format_number(deepest)
            ));
        }
    }

    fn notable_engine(&self, engine: &EnginePlan, parameters: &Parameters, list: &mut Vec<String>) {
        let name = engine_title(engine.name);
        if parameters.scheme.partners() == PartnerSelection::AroundContact {
            let diameter = 2.0 * self.mean_radius();
            let (scheme, packing) = (parameters.scheme, self.gas.packing_fraction);
            let (wanted, excess) = in_space!(self.gas.dimension, S => (
                Parameters::enough_for_chaos::<S>(scheme, packing, diameter, 1),
                parameters.excess_of_repeated_pairs::<S>(packing, diameter, self.gas.restitution),
            ));
            if parameters.simulators_per_particle < wanted && excess > Parameters::LARGEST_EXCESS {
                list.push(format!(
                    "{name}: {} simulators per particle, where {wanted} make the partners of a collision independent; with fewer \
                     they meet again and lose less energy, some {} of it at t0, as real particles do, and their shear viscosity is \
                     too large, so a difference to ED is not that of broken chaos alone",
                    parameters.simulators_per_particle,
                    format_percent(excess)
                ));
            }
            // `stosszahl_dsmc::Engine::wall_error`, before there is an engine.
            let walled = |axis: &usize| self.case.walls.face_at(*axis, 0).is_wall();
            let widths = (0..self.gas.dimension)
                .filter(walled)
                .map(|axis| self.gas.lengths[axis]);
            let error: f64 = widths.map(|width| 1.75 * packing * diameter / width).sum();
            if error > NOTABLE_WALLS {
                list.push(format!(
                    "{name}: exact disks form layers at walls, which it does not know; its collision rate may be up to {} \
                     below theirs in a box so narrow",
                    format_percent(error)
                ));
            }
            return;
        }
        if parameters.scheme.is_cross_cell() {
            return;
        }
        if let Some(simulators) = self.few_in_a_flow(parameters) {
            list.push(format!(
                "{name}: {} simulators per cell, so its collision rate may be off by tens of per cent and its pairs \
                 meet again and again; profiles of it are void. More simulators_per_particle or a larger cell_size make it smaller",
                format_number(simulators)
            ));
        }
        if let Some(wide) = self.wide_cells(parameters) {
            let remedy = if self.is_uniform() {
                ""
            } else {
                ". A smaller cell_size with more simulators_per_particle resolves it"
            };
            list.push(format!(
                "{name}: cells are {} mean free paths wide, so transport is overestimated, by an error that grows with \
                 the square of the width{remedy}",
                format_number(wide)
            ));
        }
        if !self.starts_from_copies() {
            return;
        }
        let placed = self.case.start.placement == PlacementSpec::File;
        if parameters.simulators_per_particle > 1 && placed {
            list.push(format!(
                "{name}: several simulators per particle are copies of the start moved and turned at random, which blurs a \
                 pattern of density or flow in the start file"
            ));
        }
    }

    /// Describes the numerical error of a Monte Carlo engine that makes its comparisons void,
    /// because it exceeds the margin of the case; `None` without such an error.
    ///
    /// Numerical are few simulators, wide cells along walls or gravity, and the penetrable disks of
    /// `dsmc-stochastic-disks`. That a scheme has by its theory another collision rate than hard
    /// disks ([`CasePlan::rate_ratio`]) is no such error: a comparison measures it.
    pub fn numerical_error(&self, engine: &EnginePlan) -> Option<String> {
        let EngineKind::MonteCarlo(parameters) = &engine.kind else {
            return None;
        };
        let name = engine_title(engine.name);
        if !self.is_uniform() {
            if parameters.scheme.is_cross_cell() {
                return None;
            }
            let few = self.few_in_a_flow(parameters);
            let few = few.map(|few| format!("{} simulators in a cell", format_number(few)));
            // Profiles are made by transport.
            let wide = self.wide_cells(parameters);
            let wide =
                wide.map(|wide| format!("cells {} mean free paths wide", format_number(wide)));
            let reasons: Vec<String> = few.into_iter().chain(wide).collect();
            return (!reasons.is_empty()).then(|| format!("{name} has {}", reasons.join(" and ")));
        }
        let each = f64::from(parameters.simulators_per_particle);
        let (error, has) = match parameters.scheme.partners() {
            PartnerSelection::None => return None,
            PartnerSelection::Overlap => {
                return Some(format!(
                    "{name} is a fluid of penetrable disks, whose collision rate is not that of hard disks"
                ));
            }
            PartnerSelection::ContactCell => (
                ENERGY_OVER_RATE * RATE_ERROR_OF_ESMC / each,
                format!("{} simulators per particle", format_number(each)),
            ),
            PartnerSelection::AroundContact => {
                let diameter = 2.0 * self.mean_radius();
                let excess = in_space!(self.gas.dimension, S => parameters
                    .excess_of_repeated_pairs::<S>(self.gas.packing_fraction, diameter, self.gas.restitution));
                (
                    excess,
                    format!("{} simulators per particle", format_number(each)),
                )
            }
            PartnerSelection::WithinCell => {
                let simulators = self.simulators_per_cell(parameters);
                (
                    ENERGY_OVER_RATE * RATE_ERROR_IN_A_CELL / simulators,
                    format!("{} simulators in a cell", format_number(simulators)),
                )
            }
        };
        let margin = self.case.verdict.tolerance;
        (error > margin).then(|| {
            format!(
                "{name} has {has}, which put energies off by some {}, more than the margin of {} %",
                format_percent(error),
                format_number(100.0 * margin)
            )
        })
    }

    /// Warns of engines whose comparisons will be void, and of differences that follow from the
    /// theoretical collision rate of a scheme.
    fn notable_errors(&self, list: &mut Vec<String>) {
        for engine in &self.engines {
            if let Some(reason) = self.numerical_error(engine) {
                list.push(format!(
                    "{reason}: its comparisons are void. {}",
                    match engine.parameters().map(|one| one.scheme) {
                        Some(scheme) if scheme.partners() == PartnerSelection::Overlap =>
                            "A larger stiffness brings it nearer to hard disks",
                        Some(scheme) if scheme.is_cross_cell() =>
                            "More simulators_per_particle make the error smaller",
                        _ =>
                            "More simulators_per_particle or a larger cell_size make the error smaller",
                    }
                ));
                continue;
            }
            let (ratio, end) = (self.rate_ratio(engine), self.case.run.until);
            let off = ENERGY_OVER_RATE * (ratio - 1.0).abs();
            if off > NOTABLE_RATE * self.case.verdict.tolerance {
                let energy = self.energy_by_rates(ratio, 1.0, end);
                let energy = energy.map_or(String::new(), |energy| {
                    format!(
                        ": its energy is then {} times that of a gas with Enskog's rate at the end",
                        format_number(1.0 + energy)
                    )
                });
                list.push(format!(
                    "{}: its theory has {ratio:.3} of Enskog's collision rate at this density{energy}. A difference to exact disks \
                     contains that",
                    engine_title(engine.name)
                ));
            }
        }
    }

    /// Returns the collision rate of an engine, by the theory of its scheme, over Enskog's: that of
    /// a dilute gas, or of free volume.
    pub fn rate_ratio(&self, engine: &EnginePlan) -> f64 {
        let known = engine
            .parameters()
            .filter(|one| one.scheme.properties().contact != ContactLaw::Enskog);
        known.map_or(1.0, |one| {
            let packing = self.gas.packing_fraction;
            let chi = in_space!(self.gas.dimension, S => one.scheme.contact_value::<S>(packing));
            chi.min(one.max_contact_value) / self.gas.contact_value
        })
    }

    /// Computes the relative difference in energy at `time` of two gases that cool by Haff's law at
    /// the collision rates a and b, given over Enskog's; `None` if the law does not hold.
    fn energy_by_rates(&self, a: f64, b: f64, time: f64) -> Option<f64> {
        Some(self.haff_ratio(time * a)? / self.haff_ratio(time * b)? - 1.0)
    }

    /// Describes the part of a difference in energy of two engines that follows from the collision
    /// rates of their theories; `None` if both have nearly Enskog's rate.
    pub fn stated_rates(&self, [a, b]: [&EnginePlan; 2], time: f64) -> Option<String> {
        let rates = [a, b].map(|engine| self.rate_ratio(engine));
        let off = ENERGY_OVER_RATE * (rates[0] / rates[1] - 1.0).abs();
        if !self.is_uniform() || off <= NOTABLE_RATE * self.case.verdict.tolerance {
            return None;
        }
        let by = [a, b].into_iter().zip(rates).filter(|one| one.1 != 1.0);
        let by: Vec<String> = by
            .map(|(engine, rate)| format!("{rate:.3} ({})", engine_title(engine.name)))
            .collect();
        let difference = self.energy_by_rates(rates[0], rates[1], time);
        let gives = difference.map_or(String::new(), |difference| {
            format!(", which gives {:+.0} % by Haff's law", 100.0 * difference)
        });
        Some(format!(
            "Theory has {} of Enskog's collision rate{gives}.",
            by.join(" and ")
        ))
    }

    /// Returns the number of simulators per cell next to walls or in gravity, if it is too small.
    fn few_in_a_flow(&self, parameters: &Parameters) -> Option<f64> {
        let few = |&simulators: &f64| !self.is_uniform() && simulators < FEW_IN_FLOWS;
        Some(self.simulators_per_cell(parameters)).filter(few)
    }

    /// Returns the width of the cells in mean free paths of the uniform gas, if it is too large.
    fn wide_cells(&self, parameters: &Parameters) -> Option<f64> {
        // Velocities in a uniform shear flow are relative to it at each particle, so cells do not
        // carry its momentum: cells of 7 and of 21 mean free paths have the same stress within
        // 0.1 %.
        if self.is_sheared() {
            return None;
        }
        let (path, limit) = if self.is_uniform() {
            (self.mean_free_path(), WIDE)
        } else {
            (self.flow_path(parameters.scheme), WIDE_IN_FLOWS)
        };
        let widest = self.cell(parameters).into_iter().fold(0.0, f64::max);
        Some(widest / path).filter(|&wide| wide > limit)
    }

    /// Returns the thermal speed `(T/m)^(1/2)` of the start, by the means of T and m over the
    /// particles \[engine speed\].
    pub fn thermal_speed(&self) -> f64 {
        let sum = |of: fn(&SpeciesPlan) -> f64| {
            let each = self
                .gas
                .species
                .iter()
                .map(|one| one.count as f64 * of(one));
            each.sum::<f64>()
        };
        (sum(|one| one.temperature) / sum(|one| one.mass)).sqrt()
    }

    /// Returns the quantities derived from the case, in its units, as `check` lists them.
    #[expect(clippy::too_many_lines, reason = "a list of quantities")]
    pub fn derived(&self) -> Vec<DerivedQuantity> {
        let mut list: Vec<DerivedQuantity> = Vec::new();
        let mut add = |name: &str, value, unit: &str| {
            let (name, unit) = (name.to_owned(), self.derived_unit(unit));
            list.push(DerivedQuantity { name, value, unit });
        };
        let (length, time) = (self.scale.length, self.scale.time());
        let stands_for = self.case.gas.particles_per_simulator;
        let unit = length.powi(self.gas.dimension as i32);
        let simulated = self.gas.volume * unit;
        let volume = self.box_volume() * unit * stands_for.unwrap_or(1.0);
        add("particles", self.count() as f64, "1");
        if let Some(stands_for) = stands_for {
            add("particles_per_simulator", stands_for, "1");
        }
        add("species", self.gas.species.len() as f64, "1");
        add("packing_fraction", self.gas.packing_fraction, "1");
        if self.has_box() {
            for (name, side) in ["x", "y", "z"]
                .iter()
                .zip(&self.gas.lengths[..self.gas.dimension])
            {
                add(&format!("box_size_{name}"), side * length, "length");
            }
        }
        add("volume", volume, "length^D");
        if !self.case.obstacle.is_empty() {
            add("free_volume", simulated, "length^D");
        }
        add(
            "number_density",
            self.count() as f64 / simulated,
            "length^-D",
        );
        add("restitution", self.gas.restitution, "1");
        add("contact_value", self.gas.contact_value, "1");
        add("mean_diameter", 2.0 * self.mean_radius() * length, "length");
        let path = if self.is_uniform() {
            self.mean_free_path()
        } else {
            self.dilute_mean_free_path()
        };
        // Enskog's path is that of equal particles, the dilute one that of a mixture.
        if self.gas.species.len() == 1 || !self.is_uniform() {
            add("mean_free_path", path * length, "length");
        }
        add(
            "thermal_speed",
            self.thermal_speed() * self.scale.speed(),
            "length/time",
        );
        add("mean_free_time", self.clock.mean_free_time * time, "time");
        add("haff_time", self.clock.haff_time * time, "time");
        add("unit_of_time", self.time_in_case(), "time");
        let collisions = self.expected_collisions(self.case.run.until);
        add("expected_collisions_per_particle", collisions, "1");
        if self.is_disk_fluid() {
            let structure = equation_of_state::structure_factor_at_zero(self.gas.packing_fraction);
            add("structure_factor_at_zero_elastic", structure, "1");
        }
        if self.has_theory() {
            add("fourth_cumulant_theory", self.fourth_cumulant(), "1");
        }
        if let Some((kicks, interval)) = self.kicks().zip(self.kick_interval()) {
            add("kicks", kicks, "1");
            add("kick_interval", interval, "unit of time");
            if let Some(temperature) = self.steady_temperature() {
                add("steady_temperature_over_start", temperature, "1");
            }
            if let Some(relaxation) = self.relaxation_time() {
                add("relaxation_time", relaxation, "unit of time");
            }
        }
        for one in self.flow_numbers() {
            add(&one.name, one.value, &one.unit);
        }
        for engine in &self.engines {
            let Some(parameters) = engine.parameters() else {
                continue;
            };
            let mut own = |what: &str, value, unit: &str| {
                let name = engine.name.replace('-', "_");
                add(&format!("{name}_{what}"), value, unit);
            };
            let side = self.cell(parameters)[0];
            own("cell_size", side * length, "length");
            own("cell_size_over_mean_free_path", side / path, "1");
            own(
                "simulators_per_cell",
                self.simulators_per_cell(parameters),
                "1",
            );
            own(
                "simulators_per_particle",
                f64::from(parameters.simulators_per_particle),
                "1",
            );
            if parameters.scheme.partners() == PartnerSelection::AroundContact {
                let coherent = f64::from(u8::from(parameters.copies == SimulatorStart::Coherent));
                own(
                    "partner_radius",
                    self.partner_radius(parameters) * length,
                    "length",
                );
                own("coherent_copies", coherent, "1");
            }
        }
        // An elastic gas has no time of cooling.
        list.retain(|one| one.value.is_finite());
        list
    }
}
