//! Gas from a start file: its box and particles, and the changes that the plan makes to them.

use std::path::Path;

use nalgebra::Vector3;
use stosszahl_case::Case;
use stosszahl_case::format::{FACES, FaceSpec, PlacementSpec, UnitsSpec, VelocitiesSpec};
use stosszahl_model::images::{nearest, wrapped};
use stosszahl_model::initial::{self, Overlap, StartFile};
use stosszahl_model::{Domain, Plane, Shear, Space as _, Volume, format_short};
use stosszahl_results::format_number;

use super::confinement::Confinement;
use super::data::{CasePlan, PlanError, UnitScale, in_space};
use super::file_species::FileSpecies;
use super::free_volume::{free_volume, uncovered_volume};
use super::gas::ResolvedGas;
use super::species::SizedParticles;

/// Largest overlap of particles in a start file that counts as rounding, over the mean diameter.
const OVERLAP_TOLERANCE: f64 = 1e-9;
/// Smallest temperature of a start file over the mean squared speed; below it, thermal motion is
/// rounding.
const LEAST_WARMTH: f64 = 1e-24;
/// Smallest drift of a start file over the thermal speed; below it, the drift is rounding.
const LEAST_DRIFT: f64 = 1e-12;
/// Largest relative difference between sides of two boxes that counts as rounding.
const SIDE_TOLERANCE: f64 = 1e-9;
/// Relative rounding error of single-precision numbers: half a unit of the last of 24 bits.
const SINGLE_PRECISION: f64 = 1.0 / (1 << 24) as f64;
/// Largest number of overlapping pairs of a start file that are moved apart.
const MOST_SEPARATIONS: usize = 10_000;
/// Names of the three axes in messages.
const AXES: [&str; 3] = ["x", "y", "z"];

/// Creates an error about the content of the file of the key `start.file`.
fn content_error(found: String, allowed: impl Into<String>) -> PlanError {
    PlanError::new("start.file", found, allowed)
}

/// Start file of a case while it is converted, with the changes that the plan makes to its
/// particles.
struct Source<'a> {
    case: &'a Case,
    name: &'a str,
    file: StartFile,
    /// Changes that the plan makes to the particles of the file, one sentence each for the user.
    changes: Vec<String>,
}

/// Reads the start file of a case and checks the kind of its particles.
///
/// # Errors
/// [`PlanError`] if it cannot be read, or is of particles of another kind.
fn source<'a>(case: &'a Case, folder: &Path) -> Result<Source<'a>, PlanError> {
    let name = case.start.file.as_deref();
    let name = name.ok_or_else(|| content_error("none".into(), "a file"))?;
    let file = initial::read_start_file(&folder.join(name))
        .map_err(|error| content_error(error.to_string(), "a start file as docs describe it"))?;
    let source = Source {
        case,
        name,
        file,
        changes: Vec::new(),
    };
    source.check_file()?;
    Ok(source)
}

/// Creates the gas of a case whose particles a start file places.
pub(super) fn gas(case: &Case, folder: &Path, temperature: f64) -> Result<ResolvedGas, PlanError> {
    let mut source = source(case, folder)?;
    let dimension = case.gas.dimension as usize;
    let lengths = source.lengths()?;
    let shear_offset = source.shear_offset(lengths[0])?;
    source.wrap(lengths, shear_offset)?;
    let species = FileSpecies::from_file(&source.file, case)?;
    let warmth = source.start_temperature(&species.masses, temperature)?;
    let scale = if case.has_thermal_units() {
        UnitScale {
            length: 2.0 * exact_mean(&species.radii),
            mass: exact_mean(&species.masses),
            energy: warmth,
        }
    } else {
        UnitScale::CASE
    };
    source.tell_spins();
    source.tell_units(scale);
    source.tell_precision();
    let file = scaled(source.file, scale);
    let species = species.scaled(scale);
    let lengths = lengths.map(|side| side / scale.length);
    let volume = free_volume(case, &lengths, exact_mean(&species.radii))?;
    let covered: f64 = species.covered(dimension);
    let mean_mass = exact_mean(&species.masses);
    let temperature = warmth / scale.energy;
    let temperatures = match case.start.velocities {
        VelocitiesSpec::FILE => species.temperatures(&file, dimension, temperature),
        _ => vec![temperature; species.names.len()],
    };
    let (plans, classes) = species.groups(&temperatures, volume);
    Ok(ResolvedGas {
        species: plans,
        classes,
        sizes: species.sizes(case)?,
        numbers: species.numbers(),
        mean_mass,
        temperature: warmth,
        lengths,
        shear_offset: shear_offset / scale.length,
        volume,
        packing: covered / uncovered_volume(case, &lengths, 0.0)?,
        scale,
        file: Some(file),
        choices: source.changes,
    })
}

/// Velocities of a start file for particles that are placed by the case.
pub(super) struct Dealt {
    /// Particles of the gas, sorted by species.
    pub(super) particles: SizedParticles,
    /// Velocities and spins from the file in the order of species, in the units of the case.
    pub(super) file: StartFile,
    /// Granular temperature of the velocities, in the units of the case \[energy\].
    pub(super) temperature: f64,
    /// Changes that the plan makes to the data of the file, one sentence each for the user.
    pub(super) changes: Vec<String>,
}

/// Reads the particles of a case whose start file gives only their velocities.
pub(super) fn dealt(case: &Case, folder: &Path) -> Result<Dealt, PlanError> {
    let mut source = source(case, folder)?;
    let name = source.name;
    let species = FileSpecies::from_file(&source.file, case)?;
    let temperature = source.start_temperature(&species.masses, 1.0)?;
    let dimension = case.gas.dimension as usize;
    let temperatures = species.temperatures(&source.file, dimension, temperature);
    let (kinds, order) = species.blocks().ok_or_else(|| {
        let allowed = "sizes by which particles are species: at most 100 of them, and two particles of each on average";
        content_error(format!("{name}: particles of many sizes"), allowed)
    })?;
    source.changes.push(format!(
        "start.velocities: each replica deals the velocities of {name} to its particles in an order of its own, within species"
    ));
    if source.file.positions.take().is_some() {
        source.changes.push(format!(
            "start.file: positions of {name} are not used; placement = \"file\" uses them"
        ));
    }
    source.tell_spins();
    source.tell_units(UnitScale {
        energy: temperature,
        ..UnitScale::CASE
    });
    let sorted = |list: Option<Vec<Vector3<f64>>>| {
        list.map(|all| order.iter().map(|&index| all[index]).collect())
    };
    Ok(Dealt {
        particles: SizedParticles::of_species(kinds, temperatures, species.names),
        file: StartFile {
            velocities: sorted(source.file.velocities),
            spins: sorted(source.file.spins),
            ..StartFile::default()
        },
        temperature,
        changes: source.changes,
    })
}

/// Computes the mean of numbers, exactly for equal numbers.
fn exact_mean(values: &[f64]) -> f64 {
    match values {
        [first, rest @ ..] if rest.iter().all(|one| one == first) => *first,
        all => all.iter().sum::<f64>() / all.len() as f64,
    }
}

/// Converts positions, velocities and spins of a start file to engine units; radii and masses are
/// stored elsewhere.
pub(super) fn scaled(file: StartFile, scale: UnitScale) -> StartFile {
    let over = |list: Option<Vec<Vector3<f64>>>, unit: f64| {
        list.map(|all| all.into_iter().map(|one| one / unit).collect())
    };
    StartFile {
        lengths: None,
        positions: over(file.positions, scale.length),
        velocities: over(file.velocities, scale.speed()),
        spins: over(file.spins, 1.0 / scale.time()),
        is_single_precision: file.is_single_precision,
        ..StartFile::default()
    }
}

impl Source<'_> {
    /// Checks that the file has particles of the right dimension, and no simulators of a weight
    /// other than one.
    fn check_file(&self) -> Result<(), PlanError> {
        let (file, name) = (&self.file, self.name);
        if file.count() < 2 {
            return Err(content_error("one particle".into(), "at least two"));
        }
        if self.case.gas.dimension == 2 {
            let positions = file.positions.iter().flatten();
            let place = file.positions.iter().flatten().next();
            let height = place.map_or(0.0, |one| one.z);
            let out = |one: &&Vector3<f64>| one.z != 0.0;
            let mut above = positions.filter(|one| one.z != height);
            let found = match (above.next(), file.velocities.iter().flatten().find(out)) {
                (Some(one), _) => Some(format!(
                    "z = {} and z = {}",
                    format_short(height),
                    format_short(one.z)
                )),
                (None, Some(one)) => Some(format!("a velocity vz = {}", format_number(one.z))),
                (None, None) => None,
            };
            if let Some(found) = found {
                let allowed = "disks, which have one z and no velocity along it; gas.dimension = 3 reads spheres";
                return Err(content_error(format!("{name}: spheres ({found})"), allowed));
            }
        }
        if let Some(weight) = file.weights.iter().flatten().find(|&&one| one != 1.0) {
            let found = format!(
                "{name}: a simulator with weight {}, no particle",
                format_number(*weight)
            );
            return Err(content_error(found, "particles, of weight 1"));
        }
        let start = &self.case.start;
        for (key, given, in_file) in [
            (
                "start.spin_temperature",
                start.spin_temperature.is_some() && start.velocities == VelocitiesSpec::FILE,
                file.spins.is_some(),
            ),
            (
                "gas.diameter",
                self.case.gas.diameter.is_some(),
                file.radii.is_some(),
            ),
            (
                "gas.mass",
                self.case.gas.mass.is_some(),
                file.masses.is_some(),
            ),
        ] {
            let allowed = format!("this key is left out, as {name} says this of each particle");
            PlanError::require(!(given && in_file), key, "", allowed)?;
            let needed = self.case.units == UnitsSpec::Si && key != "start.spin_temperature";
            let allowed =
                format!("a number above 0, with units = \"si\" and as {name} does not say this");
            PlanError::require(given || in_file || !needed, key, "", allowed)?;
        }
        Ok(())
    }

    /// Returns the sides of the box in the file, after checking that sides and periodic axes agree
    /// with the case.
    fn lengths(&mut self) -> Result<[f64; 3], PlanError> {
        let dimension = self.case.gas.dimension as usize;
        let found = self.file.lengths.unwrap_or_default();
        let mut lengths = [0.0; 3];
        for axis in 0..dimension {
            if found[axis] <= 0.0 {
                let found = format!("{}: a box without a side along {}", self.name, AXES[axis]);
                return Err(content_error(
                    found,
                    "positive sides, three of them for spheres",
                ));
            }
            lengths[axis] = found[axis];
        }
        let size = self.case.domain.as_ref().and_then(|one| one.size.as_ref());
        if let Some(size) = size {
            let pairs = size.iter().zip(lengths);
            let tolerance = if self.file.is_single_precision {
                SINGLE_PRECISION
            } else {
                SIDE_TOLERANCE
            };
            let alike = |(a, b): (&f64, f64)| (a - b).abs() <= tolerance * b;
            let allowed = format!("the box of {}: {:?}", self.name, &lengths[..dimension]);
            PlanError::require(pairs.into_iter().all(alike), "box.size", "", allowed)?;
        }
        let Some(said) = self.file.periodic else {
            return Ok(lengths);
        };
        for axis in 0..dimension {
            let is_periodic = *self.case.walls.face_at(axis, 0) == FaceSpec::default();
            let [low, high] = FACES[axis];
            if is_periodic && !said[axis] {
                let flags = said.map(|one| if one { "T" } else { "F" }).join(" ");
                let found = format!(
                    "{}: pbc=\"{flags}\", a box that ends along {}",
                    self.name, AXES[axis]
                );
                let allowed = format!(
                    "a box that is periodic there, as in the case; walls.{low} and walls.{high} of the case say what stands at \
                     its ends"
                );
                return Err(content_error(found, allowed));
            }
            if !is_periodic && said[axis] {
                self.changes.push(format!(
                    "start.file: {} is periodic along {}; the walls of the case stand there",
                    self.name, AXES[axis]
                ));
            }
        }
        Ok(lengths)
    }

    /// Returns the displacement of the periodic image above along x at the start, from the tilt of
    /// the file's box, in the units of the case \[length\]. An error if the tilt is not that of a
    /// shear flow.
    fn shear_offset(&mut self, width: f64) -> Result<f64, PlanError> {
        let (tilt, name) = (self.file.shear_offset, self.name);
        let offset = wrapped(tilt, width);
        if offset == 0.0 {
            return Ok(0.0);
        }
        if !self.case.is_sheared() {
            let found = format!(
                "{name}: a box that is tilted by {} along x",
                format_number(tilt)
            );
            let allowed = "a rectangular box; a tilted one is that of a shear flow, which box.shear_rate makes";
            return Err(content_error(found, allowed));
        }
        let asked = self.case.start.equilibration.unwrap_or(0.0);
        let allowed = format!(
            "0, as elastic collisions are those of a box at rest, and the box above that of {name} is displaced by {}",
            format_number(offset)
        );
        PlanError::require(asked == 0.0, "start.equilibration", asked, allowed)?;
        self.changes.push(format!(
            "start.file: the shear flow begins with the box above displaced by {}, the tilt of {name}",
            format_number(offset)
        ));
        Ok(offset)
    }

    /// Moves particles into the box along its periodic axes; the periodic image above is displaced
    /// by `shear_offset` along x. An error for particles outside along other axes.
    fn wrap(&mut self, lengths: [f64; 3], shear_offset: f64) -> Result<(), PlanError> {
        let dimension = self.case.gas.dimension as usize;
        let periodic = |axis: usize| *self.case.walls.face_at(axis, 0) == FaceSpec::default();
        // Images of positions do not depend on the rate.
        let shear = (shear_offset != 0.0).then_some(Shear {
            rate: 1.0,
            offset: shear_offset,
        });
        let domain = Domain::<Volume>::periodic(lengths.map(|side| side.max(1e-300)).into())
            .and_then(|domain| domain.sheared(shear))
            .map_err(|error| content_error(format!("{}: {error}", self.name), "positive sides"))?;
        let positions = self.file.positions.as_mut();
        let none = || content_error(format!("{}: no positions", self.name), "columns x and y");
        let mut moved = 0;
        for (index, position) in positions.ok_or_else(none)?.iter_mut().enumerate() {
            let inside = domain.wrap(*position);
            let before = *position;
            for axis in 0..dimension {
                if periodic(axis) {
                    position[axis] = inside[axis];
                } else if !(0.0..=lengths[axis]).contains(&position[axis]) {
                    let found = format!(
                        "{}: particle {index} (counted from 0) at {} = {}",
                        self.name,
                        AXES[axis],
                        format_short(position[axis])
                    );
                    let allowed = format!("places from 0 to {}", format_short(lengths[axis]));
                    return Err(content_error(found, allowed));
                }
            }
            moved += usize::from(before != *position);
        }
        if moved > 0 {
            self.changes.push(format!(
                "start.file: particles of {} outside the box, moved into it by whole sides: {moved}",
                self.name
            ));
        }
        Ok(())
    }

    /// Returns the granular temperature of the start, in the units of the case \[energy\]. In a
    /// periodic box without gravity and spin, the drift is subtracted from the velocities.
    fn start_temperature(&mut self, masses: &[f64], temperature: f64) -> Result<f64, PlanError> {
        if self.case.start.velocities != VelocitiesSpec::FILE {
            return Ok(temperature);
        }
        let name = self.name;
        let Some(velocities) = &mut self.file.velocities else {
            let allowed = "columns vx and vy (velo), or velocities = \"maxwellian\"";
            return Err(content_error(format!("{name}: no velocities"), allowed));
        };
        let square = velocities.iter().map(Vector3::norm_squared);
        let square = square.fold(0.0, f64::max);
        let total: f64 = masses.iter().sum();
        let momenta = velocities.iter().zip(masses);
        let drift = momenta.fold(Vector3::zeros(), |sum, (v, m)| sum + v * (m / total));
        let momenta = velocities.iter().zip(masses);
        let twice: f64 = momenta.map(|(v, m)| m * (v - drift).norm_squared()).sum();
        let dimension = self.case.gas.dimension as usize;
        let found = twice / (dimension * velocities.len()) as f64;
        let mean_mass = total / masses.len() as f64;
        let warm = found > LEAST_WARMTH * square * mean_mass;
        if !(found.is_normal() && found < 1e200 && warm) {
            let found = format!("{name}: a granular temperature of {}", format_number(found));
            let allowed =
                "velocities that give one above rounding; velocities = \"maxwellian\" draws some";
            return Err(content_error(found, allowed));
        }
        if self.case.is_uniform() {
            for velocity in velocities {
                *velocity -= drift;
            }
            if drift.norm() > LEAST_DRIFT * (found / mean_mass).sqrt() {
                let parts = drift.iter().take(dimension).map(|one| format_number(*one));
                let parts = parts.collect::<Vec<_>>().join(", ");
                self.changes.push(format!(
                    "start.file: the mean velocity ({parts}) of {name} is taken out of all velocities, as nothing in a periodic box \
                     depends on it"
                ));
            }
        }
        Ok(found)
    }

    /// Adds the note that particles start without spin if neither file nor case gives one.
    fn tell_spins(&mut self) {
        let start = &self.case.start;
        let spins = self.case.gas.tangential_restitution.is_some();
        let drawn = start.velocities != VelocitiesSpec::FILE || start.spin_temperature.is_some();
        if spins && !drawn && self.file.spins.is_none() {
            self.changes.push(format!(
                "start.file: {} has no spins (wz), so particles start without; start.spin_temperature draws some",
                self.name
            ));
        }
    }

    /// Adds the note that the file has single-precision numbers.
    fn tell_precision(&mut self) {
        if self.file.is_single_precision {
            self.changes.push(format!(
                "start.file: numbers of {} have single precision, with a relative rounding of 2^-24 = 6e-8",
                self.name
            ));
        }
    }

    /// Adds the note that conversion to engine units rounds the values of the file.
    fn tell_units(&mut self, scale: UnitScale) {
        if scale.length != 1.0 || scale.mass != 1.0 || scale.energy != 1.0 {
            self.changes.push(format!(
                "start.file: numbers of {} are divided by the mean diameter, the mean mass and the thermal speed, and multiplied in \
                 tables and snapshots, which rounds their last digit",
                self.name
            ));
        }
    }
}

impl CasePlan {
    /// Returns the box of disks at the start of a shear flow.
    fn box_of_start(&self) -> Result<Domain<Plane>, PlanError> {
        let domain = Confinement::<Plane>::from_plan(self)?.domain;
        // With a displacement of at most half the width, one image on each side is enough.
        let shear = self.gas.particles.shear().map(|shear| Shear {
            offset: nearest(shear.offset, self.gas.lengths[0]),
            ..shear
        });
        domain
            .sheared(shear)
            .map_err(|error| PlanError::new("box.shear_rate", error.found, error.allowed))
    }

    /// Moves disks apart that overlap only by the rounding of a single-precision file, if engines
    /// require it. Deeper overlaps are left, and lead to an error later.
    pub(super) fn separate_rounded(&mut self) -> Result<(), PlanError> {
        let placed = self.case.start.placement == PlacementSpec::File;
        if self.gas.dimension != 2 || !placed || !self.keeps_apart() {
            return Ok(());
        }
        let file = self
            .gas
            .file
            .as_ref()
            .filter(|file| file.is_single_precision);
        let Some(positions) = file.and_then(|file| file.positions.as_ref()) else {
            return Ok(());
        };
        let (domain, sizes) = (self.box_of_start()?, self.radii_and_masses());
        let radius = |index: usize| sizes[index].0;
        let mut places: Vec<_> = positions.iter().map(Vector3::xy).collect();
        let tolerance = OVERLAP_TOLERANCE * 2.0 * self.mean_radius();
        // Each component of a distance is rounded by 2^-24 of a side at most, and so is the
        // diameter.
        let rounding = 2.0 * SINGLE_PRECISION * self.gas.lengths[0].max(self.gas.lengths[1]);
        let (mut pairs, mut deepest) = (0, 0.0_f64);
        while pairs < MOST_SEPARATIONS
            && let Some(Overlap {
                pair: [a, b],
                depth,
            }) = initial::first_overlap(&places, radius, &domain, tolerance)
            && depth <= rounding
            && a != b
        {
            let away = domain.images().nearest(places[b] - places[a]);
            let push = away * (0.5 * depth / away.norm());
            places[a] = domain.wrap(places[a] - push);
            places[b] = domain.wrap(places[b] + push);
            pairs += 1;
            deepest = deepest.max(depth);
        }
        if pairs == 0 {
            return Ok(());
        }
        let positions = self
            .gas
            .file
            .as_mut()
            .and_then(|file| file.positions.as_mut());
        for (position, place) in positions.into_iter().flatten().zip(places) {
            *position = Vector3::new(place.x, place.y, position.z);
        }
        let name = self.case.start.file.as_deref().unwrap_or("the file");
        self.notes.choices.push(format!(
            "start.file: pairs of disks of {name} that overlapped by the rounding of single precision, at most {}, and are moved \
             apart: {pairs}",
            format_number(deepest * self.scale.length)
        ));
        Ok(())
    }

    /// Returns an error if particles of a start file overlap each other, walls or obstacles,
    /// although an engine forbids it.
    pub(super) fn check_file(&self) -> Result<(), PlanError> {
        let positions = self
            .gas
            .file
            .as_ref()
            .and_then(|file| file.positions.as_ref());
        let (Some(positions), Some(name)) = (positions, &self.case.start.file) else {
            return Ok(());
        };
        if self.case.start.placement != PlacementSpec::File {
            return Ok(());
        }
        let sizes = self.radii_and_masses();
        let exact = self.keeps_apart();
        let clear = exact || self.keeps_clear();
        let reach = |index: usize| if clear { sizes[index].0 } else { 0.0 };
        let all: Vec<_> = (positions.iter().enumerate())
            .map(|(index, &at)| (at, reach(index)))
            .collect();
        in_space!(self.gas.dimension, S => {
            let confinement = Confinement::<S>::from_plan(self)?;
            for (index, &(at, reach)) in all.iter().enumerate() {
                let at = S::from_components(|axis| at[axis]);
                if let Some((what, depth)) = confinement.blocks(at, reach) {
                    let found = format!(
                        "{name}: particle {index} (counted from 0) overlaps {what} by {}",
                        format_number(depth * self.scale.length)
                    );
                    return Err(content_error(found, "particles that at most touch"));
                }
            }
        });
        if self.gas.dimension != 2 || !exact {
            return Ok(());
        }
        let domain = self.box_of_start()?;
        let places: Vec<_> = positions.iter().map(Vector3::xy).collect();
        let deepest = OVERLAP_TOLERANCE * 2.0 * self.mean_radius();
        let overlap = initial::first_overlap(&places, |i| sizes[i].0, &domain, deepest);
        if let Some(Overlap {
            pair: [a, b],
            depth,
        }) = overlap
        {
            let found = format!(
                "{name}: disks {a} and {b} (counted from 0) overlap by {}",
                format_number(depth * self.scale.length)
            );
            let allowed = if self
                .gas
                .file
                .as_ref()
                .is_some_and(|file| file.is_single_precision)
            {
                "disks that at most touch, but for the rounding of single precision"
            } else {
                "touching disks"
            };
            return Err(content_error(found, allowed));
        }
        let widest = sizes.iter().map(|one| 2.0 * one.0).fold(0.0, f64::max);
        let narrow = |axis: usize| {
            domain.is_periodic(axis) && self.gas.lengths[axis] <= widest * (1.0 + 1e-9)
        };
        let [x, y] = [0, 1].map(|axis| format_number(self.gas.lengths[axis] * self.scale.length));
        let found = format!("{name}: a box of {x} x {y}");
        let wide = !narrow(0) && !narrow(1);
        wide.then_some(())
            .ok_or_else(|| content_error(found, "sides longer than one disk is wide"))
    }
}
