//! Derivation of the resolved plan from a case: units, sizes, densities, times and checks.

use std::borrow::Cow;
use std::f64::consts::{FRAC_PI_4, PI};
use std::path::Path;

use stosszahl_case::Case;
use stosszahl_case::format::{PlacementSpec, TimeUnit, VelocitiesSpec};
use stosszahl_model::initial::{
    self, Arrangement, PlacementError, SEQUENTIAL_LIMIT, StartFile, VelocityDistribution,
};
use stosszahl_model::{
    Domain, Law, Monodisperse, ParticleSpec, Plane, Polydisperse, Rough, SizeDistribution,
    Space as _, Species, Volume, equation_of_state,
};
use stosszahl_results::format_number;
use stosszahl_theory::{cooling, transport};

use super::boundaries;
use super::data::{
    CasePlan, ClockPlan, GasPlan, PlanError, PlanNotes, SizeGroup, SpeciesPlan, TheoryCache,
    UnitScale, in_space,
};
use super::engines;
use super::free_volume::{covered_area, factor_of_radii, free_volume, uncovered_volume};
use super::gas::ResolvedGas;
use super::machine::available_memory;
use super::species::{self, SizedParticles};
use super::start_file;
use super::theory::{dilute_path, rates};

impl CasePlan {
    /// Derives the resolved plan of a case; `folder` holds the case file.
    ///
    /// The case is one that [`CaseFile`](stosszahl_case::CaseFile) has read: its checks of keys and
    /// their relations are not repeated.
    ///
    /// # Errors
    /// [`PlanError`] names the key that is to blame.
    pub fn new(case: &Case, folder: &Path) -> Result<Self, PlanError> {
        Self::derive_within(case, folder, available_memory())
    }

    /// Derives the resolved plan of a case, with a limit `free` on the memory for data of each
    /// particle \[bytes\]; `None` for no limit.
    ///
    /// # Errors
    /// As [`CasePlan::new`].
    pub fn derive_within(case: &Case, folder: &Path, free: Option<f64>) -> Result<Self, PlanError> {
        let numbered = with_number(case)?;
        let case = &*numbered;
        let temperature = temperature(case)?;
        let mut gas = if !case.has_box() {
            resolve_homogeneous(case, temperature)?
        } else if case.start.placement == PlacementSpec::File {
            start_file::gas(case, folder, temperature)?
        } else if case.start.velocities == VelocitiesSpec::FILE {
            let dealt = start_file::dealt(case, folder)?;
            let placed = resolve_boxed(case, dealt.particles, dealt.temperature, free)?;
            placed.with_velocities(dealt.file, dealt.changes)
        } else {
            let particles = species::particles(case, temperature)?;
            resolve_boxed(case, particles, temperature, free)?
        };
        // In units of the engines.
        let temperature = gas.temperature / gas.scale.energy;
        let thermal_speed = (temperature / gas.mean_mass).sqrt();
        let law = species::law(case, &gas)?;
        let dimension = case.gas.dimension as usize;
        let particles = ParticleSpec {
            sizes: gas.sizes,
            restitution: law.clone(),
            rough: rough(case)?,
            gravity: (case.gravity.as_ref())
                .map(|gravity| boundaries::vector(&gravity.acceleration)),
            shear_rate: (case.domain.as_ref())
                .and_then(|domain| domain.shear_rate)
                .map(|rate| rate * gas.scale.time()),
            shear_offset: gas.shear_offset,
            is_bounded: !case.walls.is_periodic() || !case.obstacle.is_empty(),
        };
        let contact_value = match dimension {
            2 => contact_value(gas.packing),
            _ => Volume::contact_value(gas.packing.min(0.74)),
        };
        let mean_approach = PI.sqrt() * thermal_speed;
        let restitution =
            (law.coefficient(mean_approach)).unwrap_or_else(|| case.gas.restitution.coefficient());
        let mut plan = Self {
            case: case.clone(),
            gas: GasPlan {
                dimension,
                species: std::mem::take(&mut gas.species),
                species_numbers: gas.numbers.take(),
                kinds_in_groups: case.polydisperse.as_ref().map(|one| one.number as usize),
                classes: std::mem::take(&mut gas.classes),
                particles,
                law,
                restitution,
                lengths: gas.lengths,
                volume: gas.volume,
                packing_fraction: gas.packing,
                contact_value,
                temperature,
                velocities: velocity_distribution(case)?,
                file: gas.file,
            },
            scale: gas.scale,
            clock: ClockPlan {
                time: 1.0,
                time_unit: TimeUnit::Case,
                haff_time: f64::INFINITY,
                mean_free_time: f64::INFINITY,
            },
            engines: Vec::new(),
            theory: TheoryCache::default(),
            notes: PlanNotes {
                warnings: Vec::new(),
                choices: std::mem::take(&mut gas.choices),
            },
            folder: folder.to_owned(),
        };
        boundaries::check_boundaries(&plan)?;
        plan.find_times()?;
        plan.check_times()?;
        plan.check_gravity()?;
        plan.choose_blocks()?;
        plan.check_sticking()?;
        plan.check_bath()?;
        plan.check_start()?;
        plan.engines = engines::all_engines(&mut plan)?;
        plan.check_density()?;
        plan.separate_rounded()?;
        plan.check_file()?;
        plan.check_region()?;
        plan.notes.warnings.extend(plan.notable());
        Ok(plan)
    }

    /// Checks that a free fall is not so fast that thermal motion is below the rounding of its
    /// energy.
    fn check_gravity(&self) -> Result<(), PlanError> {
        const STRONGEST: f64 = 1e12;
        let gravity = self.gravity();
        let masses = self
            .gas
            .species
            .iter()
            .map(|one| one.count as f64 * one.mass);
        let mass = masses.sum::<f64>() / self.count() as f64;
        let found = (0..self.gas.dimension)
            .map(|axis| mass * gravity[axis].abs() * self.gas.lengths[axis] / self.gas.temperature)
            .fold(0.0, f64::max);
        if found <= STRONGEST {
            return Ok(());
        }
        let found = format!("a fall through the box gives {} T", format_number(found));
        let allowed = format!("at most {STRONGEST:e} T");
        Err(PlanError::new("gravity.acceleration", found, allowed))
    }

    /// Computes Haff's time, the mean free time, and the unit of time of the case.
    fn find_times(&mut self) -> Result<(), PlanError> {
        let mixed = self.gas.classes.len() > 1
            || self.gas.dimension == 3
            || matches!(self.gas.law, Law::Pairs(_));
        let viscoelastic = matches!(self.gas.law, Law::Viscoelastic(_));
        let is_closed_form = self.has_thermal_units()
            && self.gas.law.delta().is_none()
            && (!mixed || viscoelastic && self.gas.dimension == 2);
        if is_closed_form {
            let (phi, chi) = (self.gas.packing_fraction, self.gas.contact_value);
            if self.gas.restitution < 1.0 {
                self.clock.haff_time = cooling::haff_time(phi, self.gas.restitution, chi);
            }
            self.clock.mean_free_time = 1.0 / equation_of_state::collision_rate(phi, chi, 0.0);
        } else if self.is_uniform() {
            let mixture = self
                .mixture()
                .map_err(|error| PlanError::new("gas", error, "a gas with kinetic equations"))?;
            let all = self.count() as f64;
            // Tracers, which only a gas without positions has, have no density and no share.
            let share = |class: &SizeGroup| {
                if self.has_box() {
                    class.count as f64 / all
                } else {
                    class.density
                }
            };
            [self.clock.haff_time, self.clock.mean_free_time] =
                rates(&self.gas.classes, &mixture, share);
        } else {
            // Walls and gravity spread the gas unevenly: a scale, at the mean density.
            self.clock.mean_free_time = 1.0 / self.dilute_collision_rate();
            if let Ok(mixture) = self.mixture() {
                self.clock.haff_time = rates(&self.gas.classes, &mixture, |class| class.density)[0];
            }
        }
        // A gas that its contacts heat has no cooling time, even where it begins above its steady
        // temperature.
        if self.gas.law.is_elastic() || self.heats_itself() {
            self.clock.haff_time = f64::INFINITY;
        }
        let natural = if !self.has_thermal_units() {
            TimeUnit::Case
        } else if self.is_sheared() {
            // It does not cool as the gas of Haff's law.
            TimeUnit::MeanFreeTime
        } else {
            TimeUnit::Haff
        };
        self.clock.time_unit = self.case.run.time_unit.unwrap_or(natural);
        // The natural time of a gas that does not cool.
        if self.clock.time_unit == TimeUnit::Haff && !self.clock.haff_time.is_finite() {
            self.clock.time_unit = TimeUnit::MeanFreeTime;
        }
        self.clock.time = match self.clock.time_unit {
            TimeUnit::Case => 1.0 / self.scale.time(),
            TimeUnit::Haff => self.clock.haff_time,
            TimeUnit::MeanFreeTime => self.clock.mean_free_time,
        };
        let sticks = self.case.aggregation.is_some() && self.clock.time_unit == TimeUnit::Haff;
        let good = self.clock.time > 0.0 && self.clock.time.is_finite() && !sticks;
        let allowed = "a unit above 0: \"haff\" for a gas that cools and does not stick, \"mean-free-time\" for one that collides, \"case\"";
        PlanError::require(good, "run.time_unit", self.clock.time, allowed)
    }

    /// Checks that the start can be equilibrated as the case asks.
    fn check_start(&self) -> Result<(), PlanError> {
        let (asked, key) = (self.equilibration(), "start.equilibration");
        let good = (0.0..=1e9).contains(&asked) && self.longest_equilibration() >= asked;
        let allowed = "from 0 to 1e9, and at most start.longest_equilibration";
        PlanError::require(good, key, asked, allowed)?;
        let disks = self.has_box() && self.gas.dimension == 2;
        let possible = disks && !self.case.is_open() && !self.case.start.empty;
        let allowed = "0, but for disks in a closed box";
        PlanError::require(asked <= 0.0 || possible, key, asked, allowed)
    }

    /// Returns the largest packing fraction of the particles: that of close packing for equal ones,
    /// or 1 if sizes differ.
    pub fn closest_packing(&self) -> f64 {
        match (self.gas.classes.len(), self.gas.dimension) {
            (1, 2) => equation_of_state::CLOSE_PACKING,
            (1, _) => PI / 18.0_f64.sqrt(),
            _ => 1.0,
        }
    }

    /// Checks that hard particles can have the packing fraction of the case.
    fn check_density(&self) -> Result<(), PlanError> {
        let hard = self
            .engines
            .iter()
            .any(|engine| (engine.parameters()).is_none_or(|one| !one.scheme.is_dilute()));
        let closest = self.closest_packing();
        let fits = self.gas.packing_fraction <= closest * (1.0 + 1e-9);
        let part = if self.case.obstacle.is_empty() {
            "the box"
        } else {
            "what obstacles leave of the box"
        };
        let covered = format_number(self.gas.packing_fraction);
        let found = format!("particles cover {covered} of {part}");
        let allowed = format!("at most {closest:.4}, close packing");
        let fine = !self.has_box() || !hard;
        PlanError::require(fine || fits, "box", found, &allowed)?;
        for (index, inflow) in self.case.inflow.iter().enumerate() {
            let kinds = inflow
                .number_density
                .iter()
                .flatten()
                .zip(&self.gas.species);
            let covered = |(density, one): (&f64, &SpeciesPlan)| {
                density * in_space!(self.gas.dimension, S => S::particle_volume(one.radius))
            };
            let share: f64 = kinds.map(covered).sum();
            let found = format!("particles cover {} of the stream", format_number(share));
            let key = format!("inflow.{}.number_density", index + 1);
            PlanError::require(fine || share <= closest, key, found, &allowed)?;
        }
        Ok(())
    }
}

impl ResolvedGas {
    /// Returns the gas with the velocities of a start file, in the order of species, and notes on
    /// how the plan changed them.
    fn with_velocities(self, file: StartFile, changes: Vec<String>) -> Self {
        Self {
            file: Some(start_file::scaled(file, self.scale)),
            choices: changes,
            ..self
        }
    }
}

/// Returns the distribution of the initial velocities; a Maxwellian if a file gives the velocities.
fn velocity_distribution(case: &Case) -> Result<VelocityDistribution, PlanError> {
    let VelocitiesSpec::Drawn(drawn) = case.start.velocities else {
        return Ok(VelocityDistribution::MAXWELLIAN);
    };
    VelocityDistribution::new(case.gas.dimension as usize, drawn.a2)
        .map_err(|error| PlanError::new("start.velocities.a2", error.found, error.allowed))
}

/// Computes the contact value of equal disks, with the packing fraction limited to close packing,
/// which particles of several sizes can exceed.
fn contact_value(packing: f64) -> f64 {
    equation_of_state::contact_value(packing.min(0.999 * equation_of_state::CLOSE_PACKING))
}

/// Returns the case with its number of disks; if the box is given in critical lengths, the number
/// follows from it.
fn with_number(case: &Case) -> Result<Cow<'_, Case>, PlanError> {
    let domain = case.domain.as_ref();
    let given =
        domain.and_then(|one| Some((one.width_over_critical_length?, one.packing_fraction?)));
    let Some((lengths, packing)) = given else {
        return Ok(Cow::Borrowed(case));
    };
    let restitution = case.gas.restitution.coefficient();
    let critical = transport::critical_length(packing, contact_value(packing), restitution);
    let aspect = domain.map_or(1.0, |domain| domain.aspect_ratio);
    let number = (packing * (aspect * (lengths * critical).powi(2)) / FRAC_PI_4).round();
    let [side, disks] = [lengths, number].map(format_number);
    let found = format!("{side} ({disks} disks)");
    let allowed = "a box of 2 to 2147483647 disks";
    let fits = (2.0..=2_147_483_647.0).contains(&number);
    PlanError::require(fits, "box.width_over_critical_length", found, allowed)?;
    let mut case = case.clone();
    case.gas.number = Some(number as u64);
    if let Some(domain) = &mut case.domain {
        domain.width_over_critical_length = None;
    }
    Ok(Cow::Owned(case))
}

/// Returns the initial temperature in the units of the case \[energy\]; 1 if a start file
/// determines it.
fn temperature(case: &Case) -> Result<f64, PlanError> {
    if case.start.velocities == VelocitiesSpec::FILE {
        return Ok(1.0);
    }
    let Some(speed) = case.gas.rms_speed else {
        return Ok(case.gas.temperature.unwrap_or(1.0));
    };
    let mass = case.gas.mass.unwrap_or(1.0);
    let temperature = 1.0 / case.gas.dimension as f64 * mass * speed * speed;
    let allowed = "a speed whose temperature is a number";
    PlanError::require(temperature.is_normal(), "gas.rms_speed", speed, allowed)?;
    Ok(temperature)
}

fn rough(case: &Case) -> Result<Option<Rough>, PlanError> {
    let Some(tangential) = case.gas.tangential_restitution else {
        return Ok(None);
    };
    let inertia = in_space!(case.gas.dimension, S => S::INERTIA);
    let inertia = case.gas.reduced_inertia.unwrap_or(inertia);
    Rough::new(tangential, inertia)
        .map(Some)
        .map_err(|error| PlanError::new("gas.tangential_restitution", error.found, error.allowed))
}

/// Resolves a gas without positions: species, units and densities.
fn resolve_homogeneous(case: &Case, temperature: f64) -> Result<ResolvedGas, PlanError> {
    let allowed = "a volume above 0 in a gas without [box]";
    let volume = case.gas.simulated_volume();
    let volume = volume.ok_or_else(|| PlanError::new("gas.volume", "none", allowed))?;
    let particles = species::particles(case, temperature)?;
    let (species, classes) = particles.groups(volume);
    let dimension = case.gas.dimension as i32;
    let unit = PI / if dimension == 2 { 4.0 } else { 6.0 };
    let covered = particles.covered(|count, radius| count * (2.0 * radius).powi(dimension));
    Ok(ResolvedGas {
        species,
        classes,
        mean_mass: particles.mean(|kind| kind.mass),
        sizes: match &particles.kinds[..] {
            // Monomers.
            [one] if case.aggregation.is_some() => SizeDistribution::Equal(Monodisperse {
                radius: one.radius,
                mass: one.mass,
            }),
            _ => SizeDistribution::Species(listed(particles)?),
        },
        lengths: [0.0; 3],
        shear_offset: 0.0,
        volume,
        packing: unit * covered / volume,
        scale: UnitScale::CASE,
        numbers: None,
        temperature,
        file: None,
        choices: Vec::new(),
    })
}

fn listed(particles: SizedParticles) -> Result<Species, PlanError> {
    Species::new(particles.kinds)
        .map_err(|error| PlanError::of_message("species", &error.to_string()))
}

/// Resolves a gas in a box whose particles the program places: species, units, sides and densities.
fn resolve_boxed(
    case: &Case,
    mut particles: SizedParticles,
    temperature: f64,
    free: Option<f64>,
) -> Result<ResolvedGas, PlanError> {
    let scale = if case.has_thermal_units() {
        UnitScale {
            length: particles.mean(|kind| 2.0 * kind.radius),
            mass: particles.mean(|kind| kind.mass),
            energy: temperature,
        }
    } else {
        UnitScale::CASE
    };
    particles = particles.scaled(scale.length, scale.mass, scale.energy);
    let dimension = case.gas.dimension as usize;
    let equal = particles.kinds.len() == 1;
    let balls = |particles: &SizedParticles| {
        let ball = |radius| in_space!(dimension, S => S::particle_volume(radius));
        particles.covered(|count, radius| count * ball(radius))
    };
    let covered = match dimension {
        2 => particles.covered(|count, radius| count * PI * radius * radius),
        _ => balls(&particles),
    };
    let (lengths, given) = box_sides(case, covered, scale.length)?;
    if let Some(path) = case.gas.mean_free_path {
        let mean_radius = particles.mean(|kind| kind.radius);
        let found = |factor: f64| {
            let kinds = particles.kinds.iter();
            let sizes = kinds.map(|kind| (kind.count as f64, factor * kind.radius, kind.mass));
            let volume = free_volume(case, &lengths, factor * mean_radius)?;
            Ok(dilute_path(&sizes.collect::<Vec<_>>(), volume, dimension))
        };
        // Cross sections grow with the power D - 1 of the diameter.
        let exponent = 1.0 / (dimension as f64 - 1.0);
        let factor = factor_of_radii(path / scale.length, exponent, found)?;
        for kind in &mut particles.kinds {
            kind.radius *= factor;
        }
    }
    let volume = free_volume(case, &lengths, particles.mean(|kind| kind.radius))?;
    let packing = match given {
        Some(packing) if case.gas.mean_free_path.is_none() => packing,
        _ => balls(&particles) / uncovered_volume(case, &lengths, 0.0)?,
    };
    let (species, classes) = particles.groups(volume);
    check_placement(case, &particles, &lengths, packing, scale.length)?;
    let mean_mass = particles.mean(|kind| kind.mass);
    let sizes = if !case.has_thermal_units() {
        SizeDistribution::Species(listed(particles)?)
    } else if equal {
        SizeDistribution::Equal(Monodisperse {
            radius: particles.kinds[0].radius,
            mass: particles.kinds[0].mass,
        })
    } else {
        SizeDistribution::Each(list_particles(&particles, free)?)
    };
    Ok(ResolvedGas {
        species,
        classes,
        sizes,
        mean_mass,
        lengths,
        shear_offset: 0.0,
        volume,
        packing,
        scale,
        numbers: None,
        temperature,
        file: None,
        choices: Vec::new(),
    })
}

/// Checks, before anything is written, that the particles can be placed. An engine unit of length
/// is `unit` of the case.
fn check_placement(
    case: &Case,
    particles: &SizedParticles,
    lengths: &[f64; 3],
    packing: f64,
    unit: f64,
) -> Result<(), PlanError> {
    let dimension = case.gas.dimension as usize;
    let random = case.start.placement == PlacementSpec::Disordered;
    let disordered = || {
        let allowed = "\"disordered\" in space, next to walls and obstacles, with gravity or spins: a lattice is for smooth disks in \
                       a periodic box, where it melts before the start";
        PlanError::require(random, "start.placement", "a lattice", allowed)
    };
    if !case.is_uniform_box() || case.is_rough() {
        return disordered();
    }
    let widest = particles
        .kinds
        .iter()
        .map(|kind| 2.0 * kind.radius)
        .fold(0.0, f64::max);
    let sides = &lengths[..dimension];
    let fits = sides.iter().all(|&side| side > widest * (1.0 + 1e-9));
    let found = format!("sides of {sides:?} diameters");
    PlanError::require(fits, "box", found, "sides longer than one particle is wide")?;
    let dense = packing > SEQUENTIAL_LIMIT;
    match (dimension, particles.kinds.len()) {
        (3, _) => disordered(),
        (2, 1) if dense || !random => {
            let arrangement = match case.start.placement {
                PlacementSpec::Square => Arrangement::Square,
                PlacementSpec::Hexagonal => Arrangement::Hexagonal,
                _ => Arrangement::Disordered,
            };
            let domain = Domain::<Plane>::periodic([lengths[0], lengths[1]].into())
                .map_err(|error| PlanError::new("box", error.found, error.allowed))?;
            let fits = initial::fits(arrangement, particles.count(), widest, &domain);
            let refuse = |error: PlacementError| {
                PlanError::new(
                    "start.placement",
                    error.in_units(unit),
                    "a lattice that fits",
                )
            };
            fits.map_err(refuse)
        }
        (2, 2..) if dense || !random => {
            let allowed = format!(
                "disks of several sizes are placed at random, at packing fractions up to {SEQUENTIAL_LIMIT}"
            );
            let found = "lattice or dense packing";
            Err(PlanError::new("start.placement", found, allowed))
        }
        _ => Ok(()),
    }
}

/// Memory of radius, mass and species of each particle while they are listed \[bytes\].
const LISTED: f64 = (size_of::<(f64, f64)>() + 2 * size_of::<u32>()) as f64;

/// Lists radius, mass and species of each particle, if the list fits into the available memory
/// `free` \[bytes\].
fn list_particles(
    particles: &SizedParticles,
    free: Option<f64>,
) -> Result<Polydisperse, PlanError> {
    let refused = |error: stosszahl_model::InvalidValue| {
        let found = format!(
            "{} {}",
            error.quantity,
            stosszahl_model::format_short(error.found)
        );
        PlanError::new("species", found, "ratios of sizes and masses up to 1e300")
    };
    let count = particles.count();
    if let Some(free) = free
        && LISTED * count as f64 > free
    {
        let most = (free / LISTED) as u64;
        let found = format!("{count} particles of several sizes");
        let allowed = format!(
            "up to {most}, whose sizes fit into the memory that is free; `run --ignore-memory-limit` lists them all the same"
        );
        return Err(PlanError::new("species", found, allowed));
    }
    let (mut list, mut numbers) = (Vec::with_capacity(count), Vec::with_capacity(count));
    for (k, one) in particles.kinds.iter().enumerate() {
        list.extend(std::iter::repeat_n((one.radius, one.mass), one.count));
        numbers.extend(std::iter::repeat_n(k as u32, one.count));
    }
    Polydisperse::new(list)
        .and_then(|sizes| sizes.of_kinds(numbers))
        .map_err(refused)
}

/// Computes the sides of the box in engine units, and returns the packing fraction if the case
/// gives it.
fn box_sides(case: &Case, covered: f64, unit: f64) -> Result<([f64; 3], Option<f64>), PlanError> {
    let dimension = case.gas.dimension as usize;
    let written = case.domain.as_ref();
    let size = written.and_then(|domain| domain.size.as_ref());
    let packing = written.and_then(|domain| domain.packing_fraction);
    match (size, packing) {
        (Some(size), None) => {
            let mut lengths = [0.0; 3];
            for (length, side) in lengths.iter_mut().zip(size) {
                *length = side / unit;
            }
            Ok((lengths, None))
        }
        (None, Some(packing)) => {
            let aspect = written.map_or(1.0, |domain| domain.aspect_ratio);
            let volume = covered / packing;
            let lengths = if dimension == 2 {
                let area = volume + covered_area(case)?;
                let width = (area / aspect).sqrt();
                [width, area / width, 0.0]
            } else {
                let width = (volume / aspect).cbrt();
                [width, volume / (width * width), width]
            };
            Ok((lengths, Some(packing)))
        }
        (found, _) => {
            let words = [
                "neither size nor packing_fraction",
                "both size and packing_fraction",
            ];
            let found = words[usize::from(found.is_some())];
            Err(PlanError::new("box", found, "one of the two"))
        }
    }
}

#[cfg(test)]
mod tests {
    use stosszahl_model::{Material, Restitution as _};

    use super::*;
    use crate::check::format;

    /// A plan lists the particles of its case: 2e9 of them took 48 GiB.
    #[test]
    fn more_particles_than_memory_can_list_are_refused() {
        let written = |name| {
            std::format!("[[species]]\nname = \"{name}\"\nnumber = 1000000000\ndiameter = 1\n")
        };
        let text = std::format!(
            "format = 2\ntitle = \"large\"\n[gas]\nrestitution = 0.9\n[box]\npacking_fraction = 0.1\n\
             [run]\nuntil = 1\n[engine.ed]\n{}{}",
            written("a"),
            written("b")
        );
        let file = format().from_text(Path::new("case.toml"), &text, &[]);
        let file = file.expect("a case");
        let particles = species::particles(&file.points[0].case, 1.0).expect("particles");
        let refused = list_particles(&particles, Some(1e9)).expect_err("too many");
        assert_eq!(refused.key, "species");
        assert!(refused.found.contains("2000000000"), "{}", refused.found);
        assert!(refused.allowed.contains("memory"), "{}", refused.allowed);
    }

    /// Plans the text of a case.
    fn planned(text: &str) -> Result<CasePlan, PlanError> {
        let file = format().from_text(Path::new("case.toml"), text, &[]);
        CasePlan::new(&file.expect("a case").points[0].case, Path::new(""))
    }

    /// Constants of a material make the law that they make by hand, for each pair of species, at
    /// speeds in units of the engine.
    #[test]
    fn a_material_has_a_law_for_each_pair() {
        let law =
            "restitution = { young_modulus = 3e4, poisson_ratio = 0.3, viscosities = [40, 25] }";
        let by_hand = Material::new(3e4, 0.3, [40.0, 25.0]).expect("a material");
        let gas = std::format!("format = 2\ntitle = \"material\"\n[gas]\n{law}\n");
        let species =
            "[[species]]\nnumber = 10\n[[species]]\nnumber = 10\ndiameter = 2\nmass = 5\n";

        let plan = planned(&std::format!(
            "{gas}volume = 1e4\ntemperature = 9\n[run]\nuntil = 1\n{species}"
        ));
        let plan = plan.expect("a homogeneous gas");
        for (kinds, radii, masses) in [
            ([0, 0], [0.5, 0.5], [1.0, 1.0]),
            ([0, 1], [0.5, 1.0], [1.0, 5.0]),
            ([1, 1], [1.0, 1.0], [5.0, 5.0]),
        ] {
            let exact = by_hand
                .law_between(radii, masses)
                .expect("a law")
                .normal_restitution(0.1);
            assert_eq!(plan.gas.law.pair_restitution(kinds, 0.1), exact);
        }

        // A comparison whose unit of speed is 3, of mass 4 and of length 0.5.
        let one = "diameter = 0.5\nmass = 4\ntemperature = 36\nnumber = 20\n[box]\npacking_fraction = 0.1\n[run]\nuntil = 1\n[engine.ed]\n";
        let plan = planned(&std::format!("{gas}{one}")).expect("a comparison");
        let law = by_hand
            .law_between([0.25, 0.25], [4.0, 4.0])
            .expect("a law");
        // Rounding of two powers.
        assert!((plan.gas.law.normal_restitution(0.1) - law.normal_restitution(0.3)).abs() < 1e-14);
        assert!(plan.clock.haff_time.is_finite() && plan.gas.restitution < 1.0);

        let continuous = "volume = 1e4\n[run]\nuntil = 1\n[polydisperse]\nnumber = 100\ndistribution = \"uniform\"\nrelative_width = 0.2\n";
        let refused = planned(&std::format!("{gas}{continuous}")).expect_err("unlike particles");
        assert_eq!(refused.key, "gas.restitution");
        assert!(
            refused.allowed.contains("particles of one species differ"),
            "{}",
            refused.allowed
        );
    }

    /// A plan refuses a list of particles beyond the free memory, unless it may take more.
    #[test]
    fn lists_may_take_more_memory_than_is_free_if_that_is_asked_for() {
        let text = "format = 2\ntitle = \"two sizes\"\n[gas]\n[box]\npacking_fraction = 0.1\n[run]\nuntil = 1\n[engine.ed]\n\
                    [[species]]\nnumber = 10\n[[species]]\nnumber = 10\ndiameter = 2\n";
        let file = format().from_text(Path::new("case.toml"), text, &[]);
        let file = file.expect("a case");
        let plan = |free| CasePlan::derive_within(&file.points[0].case, Path::new(""), free);
        let said = plan(Some(1.0)).expect_err("too much").to_string();
        assert!(said.contains("--ignore-memory-limit"), "{said}");
        assert_eq!(plan(None).expect("a plan").count(), 20);
    }
}
