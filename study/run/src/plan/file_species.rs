//! Species of the particles in a start file, told apart by `type`, radius and mass.

use std::collections::{BTreeSet, HashMap};
use std::sync::Arc;

use nalgebra::Vector3;
use stosszahl_case::Case;
use stosszahl_model::initial::StartFile;
use stosszahl_model::{
    Monodisperse, Polydisperse, SizeDistribution, Space as _, Species, SpeciesProperties as Like,
};

use super::data::{PlanError, SizeGroup, SpeciesPlan, UnitScale, in_space};

/// Largest number of species told apart by size; with more sizes, each type is one species.
const MOST_SPECIES: usize = 100;
/// Largest number of types in a start file.
const MOST_TYPES: usize = 1000;
/// Largest number of size groups for theory, of all species together.
const MOST_CLASSES: usize = 96;
/// Smallest temperature of a species in theory, over that of the gas; colder species are set to it.
const COLDEST: f64 = 1e-9;

/// Particles of a start file with their species, in the order of the file.
pub(super) struct FileSpecies {
    /// Radius of each particle \[length\].
    pub(super) radii: Vec<f64>,
    /// Mass of each particle \[mass\].
    pub(super) masses: Vec<f64>,
    /// Index of the species of each particle.
    numbers: Vec<u32>,
    /// Name of each species in the file.
    pub(super) names: Vec<String>,
}

impl FileSpecies {
    /// Determines the species of the particles in a start file; if the file lacks sizes, those of
    /// the case are taken.
    ///
    /// Particles of one type, radius and mass are a species, up to [`MOST_SPECIES`] of at least two
    /// particles on average; otherwise all particles of one type are a species.
    ///
    /// # Errors
    /// [`PlanError`] if a name of a species cannot be told from another.
    pub(super) fn from_file(file: &StartFile, case: &Case) -> Result<Self, PlanError> {
        let count = file.count();
        let each =
            |own: &Option<Vec<f64>>, all: f64| own.clone().unwrap_or_else(|| vec![all; count]);
        let radii = each(&file.radii, 0.5 * case.gas.diameter.unwrap_or(1.0));
        let masses = each(&file.masses, case.gas.mass.unwrap_or(1.0));
        let (types, type_names) = numbered(file.types.as_deref(), count);
        let found = format!("{} types of particles", type_names.len());
        let few = type_names.len() <= MOST_TYPES;
        PlanError::require(
            few,
            "start.file",
            found,
            format!("at most {MOST_TYPES} types"),
        )?;
        // The order of species is that of types, and within a type that of the file.
        let mut of_type: Vec<Vec<[u64; 2]>> = vec![Vec::new(); type_names.len()];
        let mut seen = BTreeSet::new();
        for index in 0..count {
            let size = [radii[index].to_bits(), masses[index].to_bits()];
            if seen.insert((types[index], size)) {
                of_type[types[index] as usize].push(size);
            }
        }
        let by_size = seen.len() == 1 || seen.len() <= MOST_SPECIES && 2 * seen.len() <= count;
        let has_types = file.types.is_some();
        if !by_size {
            return Ok(Self {
                radii,
                masses,
                numbers: types,
                names: type_names,
            });
        }
        let mut names: Vec<String> = Vec::new();
        let mut places = HashMap::new();
        for (number, sizes) in of_type.iter().enumerate() {
            for (place, &size) in sizes.iter().enumerate() {
                places.insert((number as u32, size), names.len() as u32);
                names.push(match (has_types, sizes.len()) {
                    (false, _) => (names.len() + 1).to_string(),
                    (true, 1) => type_names[number].clone(),
                    (true, _) => format!("{}-{}", type_names[number], place + 1),
                });
            }
        }
        let unlike: BTreeSet<&String> = names.iter().collect();
        let allowed = "types whose names with -1, -2 after them, for their sizes, differ";
        let found = format!("species {}", names.join(", "));
        PlanError::require(unlike.len() == names.len(), "start.file", found, allowed)?;
        let number = |index: usize| {
            places[&(
                types[index],
                [radii[index].to_bits(), masses[index].to_bits()],
            )]
        };
        Ok(Self {
            numbers: (0..count).map(number).collect(),
            radii,
            masses,
            names,
        })
    }

    /// Groups particles by species, if those of each species are equal. Returns the species, and
    /// the indices of their particles in the file, species after species; `None` otherwise.
    pub(super) fn blocks(&self) -> Option<(Vec<Like>, Vec<usize>)> {
        let mut order: Vec<usize> = (0..self.numbers.len()).collect();
        order.sort_by_key(|&index| self.numbers[index]);
        let mut kinds: Vec<Like> = Vec::new();
        let size = |index: usize| (self.radii[index], self.masses[index]);
        for (place, &index) in order.iter().enumerate() {
            let own = place > 0 && self.numbers[order[place - 1]] == self.numbers[index];
            match kinds.last_mut() {
                Some(kind) if own && (kind.radius, kind.mass) == size(index) => kind.count += 1,
                Some(_) if own => return None,
                _ => kinds.push(Like {
                    radius: self.radii[index],
                    mass: self.masses[index],
                    count: 1,
                }),
            }
        }
        Some((kinds, order))
    }

    /// Converts radii and masses to other units.
    pub(super) fn scaled(mut self, scale: UnitScale) -> Self {
        self.radii.iter_mut().for_each(|one| *one /= scale.length);
        self.masses.iter_mut().for_each(|one| *one /= scale.mass);
        self
    }

    /// Computes the total area or volume of the particles \[length^D\].
    pub(super) fn covered(&self, dimension: usize) -> f64 {
        let balls = self.radii.iter();
        balls
            .map(|&radius| in_space!(dimension, S => S::particle_volume(radius)))
            .sum()
    }

    /// Returns true if all particles have equal radius and mass.
    fn are_equal(&self) -> bool {
        let alike = |values: &[f64]| values.iter().all(|&value| value == values[0]);
        self.names.len() == 1 && alike(&self.radii) && alike(&self.masses)
    }

    /// Returns the species of each particle; `None` if there is one species.
    pub(super) fn numbers(&self) -> Option<Arc<[u32]>> {
        (self.names.len() > 1).then(|| self.numbers.clone().into())
    }

    /// Converts radii and masses to the size distribution of the engines.
    ///
    /// # Errors
    /// [`PlanError`] if numbers are beyond what engines can work with.
    pub(super) fn sizes(&self, case: &Case) -> Result<SizeDistribution, PlanError> {
        if self.are_equal() && case.has_thermal_units() {
            return Ok(SizeDistribution::Equal(Monodisperse {
                radius: self.radii[0],
                mass: self.masses[0],
            }));
        }
        let failed = |error: stosszahl_model::InvalidValue| {
            let allowed = "ratios of radii and masses up to 1e300";
            PlanError::new("start.file", error, allowed)
        };
        let pairs = self.radii.iter().copied().zip(self.masses.iter().copied());
        if case.has_thermal_units() {
            return Polydisperse::new(pairs.collect())
                .and_then(|sizes| sizes.of_kinds(self.numbers.clone()))
                .map(SizeDistribution::Each)
                .map_err(failed);
        }
        // Like particles that follow each other are one entry.
        let (mut runs, mut numbers): (Vec<Like>, Vec<u32>) = (Vec::new(), Vec::new());
        for ((radius, mass), &number) in pairs.zip(&self.numbers) {
            match runs.last_mut() {
                Some(run)
                    if (run.radius, run.mass) == (radius, mass)
                        && numbers.last() == Some(&number) =>
                {
                    run.count += 1;
                }
                _ => {
                    numbers.push(number);
                    runs.push(Like {
                        radius,
                        mass,
                        count: 1,
                    });
                }
            }
        }
        Species::new(runs)
            .and_then(|species| species.of_kinds(numbers))
            .map(SizeDistribution::Species)
            .map_err(failed)
    }

    /// Computes the temperatures of the species relative to the mean velocity of the gas, from the
    /// velocities of the file.
    pub(super) fn temperatures(&self, file: &StartFile, dimension: usize, all: f64) -> Vec<f64> {
        let velocities = file.velocities.as_deref().unwrap_or_default();
        let total: f64 = self.masses.iter().sum();
        let momenta = velocities.iter().zip(&self.masses);
        let drift = momenta.fold(Vector3::zeros(), |sum, (v, m)| sum + v * (m / total));
        let mut sums = vec![(0.0, 0_usize); self.names.len()];
        for ((velocity, mass), &number) in velocities.iter().zip(&self.masses).zip(&self.numbers) {
            let (twice, count) = &mut sums[number as usize];
            *twice += mass * (velocity - drift).norm_squared();
            *count += 1;
        }
        let temperature = |(twice, count): (f64, usize)| {
            (twice / (dimension * count.max(1)) as f64).max(COLDEST * all)
        };
        sums.into_iter().map(temperature).collect()
    }

    /// Creates the species of the plan with the given temperatures, and size groups for theory: the
    /// species, or several groups for each whose sizes differ.
    pub(super) fn groups(
        &self,
        temperatures: &[f64],
        volume: f64,
    ) -> (Vec<SpeciesPlan>, Vec<SizeGroup>) {
        let mut members: Vec<Vec<usize>> = vec![Vec::new(); self.names.len()];
        for (index, &number) in self.numbers.iter().enumerate() {
            members[number as usize].push(index);
        }
        let class = |part: &[usize], temperature: f64| {
            let mean = |values: &[f64]| {
                let first = values[part[0]];
                // Of like particles the mean is what each has, whatever a sum rounds to.
                if part.iter().all(|&index| values[index] == first) {
                    return first;
                }
                part.iter().map(|&index| values[index]).sum::<f64>() / part.len() as f64
            };
            SizeGroup {
                count: part.len(),
                mass: mean(&self.masses),
                diameter: 2.0 * mean(&self.radii),
                temperature,
                density: part.len() as f64 / volume,
            }
        };
        let (mut species, mut classes) = (Vec::new(), Vec::new());
        for ((own, name), &temperature) in members.iter_mut().zip(&self.names).zip(temperatures) {
            let whole = class(own, temperature);
            species.push(SpeciesPlan {
                name: name.clone(),
                count: own.len(),
                radius: 0.5 * whole.diameter,
                mass: whole.mass,
                temperature,
                tracer: false,
            });
            let size = |index: &usize| [self.radii[*index], self.masses[*index]];
            let alike = own.iter().all(|index| size(index) == size(&own[0]));
            if alike {
                classes.push(whole);
                continue;
            }
            own.sort_by(|a, b| {
                let ([r, m], [s, n]) = (size(a), size(b));
                r.total_cmp(&s).then(m.total_cmp(&n))
            });
            let parts = (MOST_CLASSES / self.names.len()).clamp(2, own.len().max(2));
            let each = own.len().div_ceil(parts).max(1);
            classes.extend(own.chunks(each).map(|part| class(part, temperature)));
        }
        (species, classes)
    }
}

/// Numbers the types of a start file, in the order of their numbers or of their first particles.
/// Returns the index of each particle's type, and the names.
fn numbered(types: Option<&[String]>, count: usize) -> (Vec<u32>, Vec<String>) {
    let Some(types) = types else {
        return (vec![0; count], vec!["1".to_owned()]);
    };
    let (mut names, mut known): (Vec<String>, HashMap<&str, u32>) = (Vec::new(), HashMap::new());
    for name in types {
        known.entry(name).or_insert_with(|| {
            names.push(name.clone());
            names.len() as u32 - 1
        });
    }
    if names.iter().all(|name| name.parse::<i64>().is_ok()) {
        names.sort_by_key(|name| name.parse::<i64>().ok());
    }
    let order: HashMap<&str, u32> = (names.iter().map(String::as_str)).zip(0..).collect();
    let numbers = types.iter().map(|name| order[name.as_str()]).collect();
    (numbers, names)
}
