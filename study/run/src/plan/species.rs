//! Species, sizes and restitution laws of a case, for its plan.

use rand::{Rng, RngExt};
use stosszahl_case::Case;
use stosszahl_case::format::{
    DiameterDistribution, PolydisperseSpec, RestitutionSpec, Rounding, SpeciesSpec as Written,
};
use stosszahl_model::random::{Purpose, Streams};
use stosszahl_model::{
    Constant, DeltaModel, InvalidValue, Law, Material, PerPair, SpeciesProperties as Like,
    ThresholdModel, Viscoelastic,
};

use super::data::{PlanError, SizeGroup, SpeciesPlan};
use super::gas::ResolvedGas;

/// Number of size groups in a species for theory, if it has as many particles. Theory with one size
/// for each of 12 species of a wide distribution is off by 3 %.
const CLASSES: usize = 8;

/// Particles of a case in blocks of equal ones, in the units of the case.
#[derive(Default)]
pub(super) struct SizedParticles {
    /// Blocks of equal particles, one after the other.
    pub(super) kinds: Vec<Like>,
    /// Granular temperature at the start of each block of equal particles in `kinds` \[energy\].
    temperatures: Vec<f64>,
    /// Name of each species; `None` if its number is its name.
    names: Vec<Option<String>>,
    tracer: Option<usize>,
    /// Number of species into which particles are grouped by size, if each block is one particle.
    groups: Option<usize>,
}

/// Creates the particles of a case without a start file: equal ones, species, a power law, or
/// individual sizes.
pub(super) fn particles(case: &Case, temperature: f64) -> Result<SizedParticles, PlanError> {
    let found = if !case.species.is_empty() {
        listed_species(case, temperature)?
    } else if let Some(law) = &case.power_law {
        let count = |mass| {
            let share = law.monomers as f64 * (mass as f64).powf(-law.exponent);
            match law.rounding {
                // A share that is whole must not fall below itself by rounding.
                Rounding::Down => (share * (1.0 + 1e-12)).floor() as usize,
                Rounding::Nearest => share.round() as usize,
            }
        };
        let kinds: Vec<Like> = (1..=law.largest_mass.unwrap_or(u64::MAX))
            .map(|mass| Like {
                radius: 0.5 * cluster_diameter(mass as f64, case.gas.dimension),
                mass: mass as f64,
                count: count(mass),
            })
            .take_while(|kind| kind.count > 0)
            .collect();
        SizedParticles {
            temperatures: vec![temperature; kinds.len()],
            kinds,
            ..SizedParticles::default()
        }
    } else if let Some(continuous) = &case.polydisperse {
        let count = continuous.number as usize;
        let mut stream = Streams::new(case.seed, 0).stream_at(Purpose::Placement, [0, 0]);
        let mut diameters: Vec<f64> = (0..count)
            .map(|_| draw_diameter(continuous, &mut stream))
            .collect();
        diameters.sort_by(f64::total_cmp);
        let kinds = diameters.iter().map(|d| Like {
            radius: 0.5 * d,
            mass: continuous.unit_mass * d.powi(case.gas.dimension as i32),
            count: 1,
        });
        SizedParticles {
            kinds: kinds.collect(),
            temperatures: vec![temperature; count],
            groups: Some((continuous.groups as usize).clamp(1, count.max(1))),
            ..SizedParticles::default()
        }
    } else {
        let count = case.gas.number.unwrap_or(0) as usize;
        SizedParticles {
            kinds: vec![Like {
                radius: 0.5 * case.gas.diameter.unwrap_or(1.0),
                mass: case.gas.mass.unwrap_or(1.0),
                count,
            }],
            temperatures: vec![temperature],
            ..SizedParticles::default()
        }
    };
    Ok(found)
}

/// Creates the particles of the species listed in `[[species]]`.
fn listed_species(case: &Case, temperature: f64) -> Result<SizedParticles, PlanError> {
    let mut found = SizedParticles::default();
    for (index, (one, count)) in case.species.iter().zip(species_counts(case)?).enumerate() {
        if one.tracer {
            found.tracer = Some(index);
        }
        found
            .names
            .push(one.name.clone().filter(|name| !name.is_empty()));
        found
            .temperatures
            .push(one.temperature.unwrap_or(temperature));
        found.kinds.push(Like {
            radius: 0.5 * one.diameter,
            mass: one.mass,
            count,
        });
    }
    // Tables, figures and verdicts tell species apart by their names.
    let named = |index: usize| match &found.names[index] {
        Some(name) => name.clone(),
        None => (index + 1).to_string(),
    };
    let names: Vec<String> = (0..found.names.len()).map(named).collect();
    for (index, name) in names.iter().enumerate() {
        if names[..index].contains(name) {
            let key = format!("species.{}.name", index + 1);
            return Err(PlanError::new(
                key,
                name,
                "a name that no other species has",
            ));
        }
    }
    Ok(found)
}

/// Computes the number of particles of each species. Shares are rounded so that their sum is the
/// total; the largest share takes up the remainder.
fn species_counts(case: &Case) -> Result<Vec<usize>, PlanError> {
    let shared = case.species.iter().all(|one| one.share.is_some());
    if shared {
        let all = case.gas.number.unwrap_or(0) as usize;
        let total: f64 = case.species.iter().filter_map(|one| one.share).sum();
        let share = |one: &Written| one.share.unwrap_or(0.0) / total;
        let mut counts: Vec<usize> = (case.species.iter())
            .map(|one| (share(one) * all as f64).round() as usize)
            .collect();
        let largest = (0..counts.len())
            .max_by(|&a, &b| share(&case.species[a]).total_cmp(&share(&case.species[b])));
        if let Some(largest) = largest {
            let others: usize = counts.iter().sum::<usize>() - counts[largest];
            counts[largest] = all.saturating_sub(others);
        }
        if let Some(empty) = counts.iter().position(|&count| count == 0) {
            let (key, found) = (
                format!("species.{}.share", empty + 1),
                "a species without particles",
            );
            return Err(PlanError::new(key, found, "a share that gives one"));
        }
        return Ok(counts);
    }
    let volume = case.gas.simulated_volume();
    let one = |one: &Written| match (one.number, one.number_density, volume) {
        (None, Some(density), Some(volume)) => (density * volume).round() as usize,
        (number, _, _) => number.unwrap_or(0) as usize,
    };
    Ok(case.species.iter().map(one).collect())
}

/// Returns the diameter `k^(1/D)` of a cluster of k monomers.
fn cluster_diameter(k: f64, dimension: u64) -> f64 {
    if dimension == 2 { k.sqrt() } else { k.cbrt() }
}

/// Draws a diameter from a continuous distribution.
fn draw_diameter(continuous: &PolydisperseSpec, stream: &mut impl Rng) -> f64 {
    let PolydisperseSpec {
        distribution,
        mean_diameter,
        relative_width,
        ..
    } = *continuous;
    match distribution {
        DiameterDistribution::Uniform => {
            let place = 2.0 * stream.random::<f64>() - 1.0;
            mean_diameter * (1.0 + 3.0_f64.sqrt() * relative_width * place)
        }
        DiameterDistribution::LogNormal => {
            // exp(mu + s x) has the mean exp(mu + s^2/2) and the relative variance exp(s^2) - 1.
            // Box & Muller's x; the complement keeps the logarithm finite.
            let square = (relative_width * relative_width).ln_1p();
            let length = (-2.0 * (1.0 - stream.random::<f64>()).ln()).sqrt();
            let normal = length * (std::f64::consts::TAU * stream.random::<f64>()).cos();
            mean_diameter * (square.sqrt() * normal - 0.5 * square).exp()
        }
    }
}

impl SizedParticles {
    /// Creates blocks of equal particles, one for each species, with their temperatures and names.
    pub(super) fn of_species(kinds: Vec<Like>, temperatures: Vec<f64>, names: Vec<String>) -> Self {
        Self {
            kinds,
            temperatures,
            names: names.into_iter().map(Some).collect(),
            ..Self::default()
        }
    }

    /// Returns the species of the plan, and their size groups for theory, in a gas of a given
    /// volume.
    pub(super) fn groups(&self, volume: f64) -> (Vec<SpeciesPlan>, Vec<SizeGroup>) {
        let count = self.kinds.len();
        let in_parts = |parts: usize| {
            (0..count)
                .map(|index| index * parts / count)
                .collect::<Vec<_>>()
        };
        let (groups, classes) = if let Some(number) = self.groups {
            let split = (count / number).clamp(1, CLASSES);
            let classes = |parts| self.classes(volume, Some(&in_parts(parts)));
            (classes(number), classes(number * split))
        } else {
            let classes = self.classes(volume, None);
            (classes.clone(), classes)
        };
        let species = groups.iter().enumerate().map(|(index, group)| SpeciesPlan {
            name: (self.names.get(index).cloned().flatten())
                .unwrap_or_else(|| (index + 1).to_string()),
            count: group.count,
            radius: 0.5 * group.diameter,
            mass: group.mass,
            temperature: group.temperature,
            tracer: self.tracer == Some(index),
        });
        (species.collect(), classes)
    }

    fn classes(&self, volume: f64, part_of: Option<&[usize]>) -> Vec<SizeGroup> {
        let mut classes: Vec<SizeGroup> = Vec::new();
        for (index, (kind, &temperature)) in self.kinds.iter().zip(&self.temperatures).enumerate() {
            let number = part_of.map_or(index, |parts| parts[index]);
            if number >= classes.len() {
                classes.push(SizeGroup {
                    count: 0,
                    mass: 0.0,
                    diameter: 0.0,
                    temperature,
                    density: 0.0,
                });
            }
            let class = &mut classes[number];
            class.count += kind.count;
            // Sums for now where a class has several sizes.
            class.mass += kind.mass;
            class.diameter += 2.0 * kind.radius;
            if self.tracer != Some(index) {
                class.density += kind.count as f64 / volume;
            }
        }
        if part_of.is_some() {
            for class in &mut classes {
                let count = class.count.max(1) as f64;
                class.mass /= count;
                class.diameter /= count;
            }
        }
        classes
    }

    /// Converts the particles to other units: factors of length, mass and energy.
    pub(super) fn scaled(mut self, length: f64, mass: f64, energy: f64) -> Self {
        for kind in &mut self.kinds {
            kind.radius /= length;
            kind.mass /= mass;
        }
        self.temperatures.iter_mut().for_each(|one| *one /= energy);
        self
    }

    /// Computes the mean of a value over all particles.
    pub(super) fn mean(&self, value: impl Fn(&Like) -> f64) -> f64 {
        if let [one] = &self.kinds[..] {
            return value(one);
        }
        let sum: f64 = (self.kinds.iter())
            .map(|kind| kind.count as f64 * value(kind))
            .sum();
        sum / self.kinds.iter().map(|kind| kind.count).sum::<usize>() as f64
    }

    /// Returns the number of particles of all species together.
    pub(super) fn count(&self) -> usize {
        self.kinds.iter().map(|kind| kind.count).sum()
    }

    /// Computes the area or volume that particles cover; `ball` gives that of a number of particles
    /// with a radius. Tracers cover nothing.
    pub(super) fn covered(&self, ball: impl Fn(f64, f64) -> f64) -> f64 {
        let kinds = self.kinds.iter().enumerate();
        kinds
            .filter(|&(index, _)| self.tracer != Some(index))
            .map(|(_, kind)| ball(kind.count as f64, kind.radius))
            .sum()
    }
}

/// Largest number of species for which each pair can have its own restitution law.
const MOST_IN_PAIRS: usize = 4096;

/// Returns the law of normal restitution of a case, in engine units.
pub(super) fn law(case: &Case, gas: &ResolvedGas) -> Result<Law, PlanError> {
    let species = gas.species.len();
    let one = |key: &str, written: RestitutionSpec, pair| one_law(key, written, gas, pair);
    let material = case.gas.restitution.is_of_material();
    let first = one("gas.restitution", case.gas.restitution, [0, 0])?;
    if case.pair.is_empty() && !(material && species > 1) {
        return Ok(first);
    }
    let few = species <= MOST_IN_PAIRS;
    let key = if material { "gas.restitution" } else { "pair" };
    let allowed = format!("at most {MOST_IN_PAIRS} species, as each pair has its own law");
    PlanError::require(few, key, format!("{species} species"), allowed)?;
    for (index, pair) in case.pair.iter().enumerate() {
        let known = pair.species.iter().all(|&one| one as usize <= species);
        let key = format!("pair.{}.species", index + 1);
        let allowed = format!("two of the {species} species, counted from 1");
        PlanError::require(known, key, "", allowed)?;
    }
    let mut laws = vec![first; species * species];
    if material {
        for (place, law) in laws.iter_mut().enumerate() {
            let pair = [place / species, place % species];
            *law = one("gas.restitution", case.gas.restitution, pair)?;
        }
    }
    for (index, pair) in case.pair.iter().enumerate() {
        let [a, b] = pair.species.map(|number| number as usize - 1);
        let [first, second] = [a.min(b), a.max(b)];
        let key = format!("pair.{}.restitution", index + 1);
        laws[first * species + second] = one(&key, pair.restitution, [first, second])?;
    }
    PerPair::new(species, laws)
        .map(Law::from)
        .map_err(|error| PlanError::new("pair", error.found, error.allowed))
}

/// Converts the restitution law given by a key, between two species, to engine units.
fn one_law(
    key: &str,
    written: RestitutionSpec,
    gas: &ResolvedGas,
    pair: [usize; 2],
) -> Result<Law, PlanError> {
    let refused = |error: InvalidValue| PlanError::new(key, error.found, error.allowed);
    let viscoelastic = match written {
        RestitutionSpec::Constant(coefficient) => {
            return Constant::new(coefficient).map(Law::from).map_err(refused);
        }
        RestitutionSpec::Delta(law) => {
            let delta = law.delta / gas.scale.speed();
            return DeltaModel::new(law.coefficient, delta)
                .map(Law::from)
                .map_err(refused);
        }
        RestitutionSpec::Threshold(law) => {
            let threshold = law.elastic_below / gas.scale.speed();
            return ThresholdModel::new(law.coefficient, threshold)
                .map(Law::from)
                .map_err(refused);
        }
        RestitutionSpec::Viscoelastic(law) => law,
    };
    // v* = strength g^(1/10), with speeds g of the engine in its own unit.
    let unit = gas.scale.speed().powf(0.1);
    let Some((modulus, ratio, viscosities)) = viscoelastic.material() else {
        let strength = viscoelastic.viscoelastic.unwrap_or(f64::NAN) * unit;
        return Viscoelastic::new(strength).map(Law::from).map_err(refused);
    };
    let alike = gas.classes.len() == gas.species.len();
    let allowed = "a constant or { viscoelastic = STRENGTH }, as particles of one species differ and the constants of a material \
                   make another law of each pair";
    PlanError::require(alike, key, "constants of a material", allowed)?;
    let (length, mass) = (gas.scale.length, gas.scale.mass);
    let of_case = Material::new(modulus, ratio, viscosities).and_then(|material| {
        let of = |index: usize| &gas.species[index];
        let radii = pair.map(|index| of(index).radius * length);
        material.law_between(radii, pair.map(|index| of(index).mass * mass))
    });
    let strength = of_case.map_err(refused)?.strength() * unit;
    Viscoelastic::new(strength).map(Law::from).map_err(refused)
}
