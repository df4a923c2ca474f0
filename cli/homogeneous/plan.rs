//! What follows from a case: species, laws, the unit of time, and what kinetic theory says.

use std::ops::Range;

use rand::Rng;
use rand::RngExt;
use stosszahl_analysis::theory::{self, Component, CoolingState, Mixture, TheoryError};
use stosszahl_dsmc::homogeneous::{self as dsmc, Order, Part, Rule, Sticking, Threshold};
use stosszahl_model::random::{Purpose, Streams};
use stosszahl_model::{Kind, Species, kinetic};

use super::case::{
    self, Case, ContactValues, Content, Distribution, EnergyPart, FirstTest, TimeUnit,
};
use super::law::Law;
use super::validate::power_law_count;

/// Why a valid case cannot be started.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PlanError {
    /// The species make no gas.
    #[error(
        "the species make no gas of at most {} particles with finite masses and diameters",
        u32::MAX
    )]
    Species,
    /// A law or threshold out of range.
    #[error("{name} is out of range")]
    Law {
        /// Which.
        name: &'static str,
    },
    /// Theory, or the contact values, refuse the gas.
    #[error("the gas as a whole: {0}")]
    Theory(#[from] TheoryError),
}

/// Particles that are told about together: a species, or those of like size.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Group {
    /// Number of particles.
    pub count: usize,
    /// Mass of a particle; the mean where they differ.
    pub mass: f64,
    /// Diameter of a particle; the mean where they differ.
    pub diameter: f64,
    /// Temperature at the start.
    pub temperature: f64,
    /// Particles per volume; 0 for tracers.
    pub density: f64,
}

/// Classes of like size in a group, if there are as many particles: theory of one size for each of 12 groups of a wide distribution
/// is off by 3 %.
const CLASSES: usize = 8;

/// A case and all that follows from it.
#[derive(Clone, Debug)]
pub struct Plan {
    /// The case.
    pub case: Case,
    /// The sizes, species by species or particle by particle.
    pub(super) species: Species,
    /// What is told about.
    pub groups: Vec<Group>,
    /// What theory is solved for: the groups, or several classes of like size for each, one group after the other.
    classes: Vec<Group>,
    /// Group of each species of `species`, where these are the particles.
    pub(super) group_of: Option<Vec<u32>>,
    /// Restitution.
    pub(super) law: Law,
    /// The species that leaves no trace.
    pub(super) tracer: Option<u32>,
    /// The unit of time of the case, in its units of length, mass and energy.
    pub time: f64,
    /// Haff's time of the start, twice the energy over the rate of its loss; infinite in an elastic gas.
    pub haff_time: f64,
    /// Mean time between two collisions of a particle at the start.
    pub mean_free_time: f64,
}

impl Plan {
    /// Derives what follows from a case.
    ///
    /// # Errors
    /// [`PlanError`] if species or laws are beyond what numbers can hold, or the gas is packed too densely.
    pub fn new(case: &Case) -> Result<Self, PlanError> {
        let (kinds, temperatures, group_count) = particles(case);
        let tracer = match &case.content {
            Content::Species(species) => species.iter().position(|one| one.tracer),
            _ => None,
        }
        .map(|index| index as u32);
        let count = kinds.len();
        let in_parts = |parts: usize| {
            let part_of = |index| (index * parts / count) as u32;
            (0..count).map(part_of).collect::<Vec<u32>>()
        };
        let group_of = group_count.map(in_parts);
        let groups = groups(case, &kinds, &temperatures, group_of.as_deref(), tracer);
        let classes = match group_count {
            Some(number) => {
                let split = (count / number).clamp(1, CLASSES);
                let class_of = in_parts(number * split);
                self::groups(case, &kinds, &temperatures, Some(&class_of), tracer)
            }
            None => groups.clone(),
        };
        let law = Law::new(case, groups.len()).ok_or(PlanError::Law {
            name: "gas.restitution",
        })?;
        let species = Species::new(kinds).ok_or(PlanError::Species)?;
        let mut plan = Self {
            case: case.clone(),
            species,
            groups,
            classes,
            group_of,
            law,
            tracer,
            time: 1.0,
            haff_time: f64::INFINITY,
            mean_free_time: f64::INFINITY,
        };
        plan.find_times()?;
        plan.sticking()?;
        Ok(plan)
    }

    /// Rates of the start, and the unit of time that they give.
    fn find_times(&mut self) -> Result<(), PlanError> {
        let mixture = self.mixture()?;
        let temperatures = self.temperatures();
        let (mut energy, mut loss, mut particles, mut hits) = (0.0, 0.0, 0.0, 0.0);
        for (k, group) in self.classes.iter().enumerate() {
            let rates = mixture.rates(k, &temperatures);
            energy += group.density * group.temperature;
            loss += group.density * group.temperature * rates.cooling;
            particles += group.density;
            hits += group.density * rates.collisions;
        }
        if loss > 0.0 {
            self.haff_time = 2.0 * energy / loss;
        }
        if hits > 0.0 {
            self.mean_free_time = particles / hits;
        }
        self.time = match self.case.run.time_unit {
            TimeUnit::Case => 1.0,
            TimeUnit::Haff => self.haff_time,
            TimeUnit::MeanFreeTime => self.mean_free_time,
        };
        if !(self.time > 0.0 && self.time.is_finite()) {
            return Err(TheoryError::BadNumber {
                name: "unit of time",
                value: self.time,
                allowed: "above 0 and finite: the gas must collide, and cool if Haff's time is the unit",
            }
            .into());
        }
        Ok(())
    }

    /// What theory is solved for: the groups, or classes within them.
    pub(super) fn classes(&self) -> &[Group] {
        &self.classes
    }

    /// The classes of a group.
    fn classes_of(&self, group: usize) -> Range<usize> {
        let each = self.classes.len() / self.groups.len().max(1);
        group * each..(group + 1) * each
    }

    /// Weighted mean over the classes of a group; the value of the only one, bit by bit.
    pub(super) fn over_classes(
        &self,
        group: usize,
        weight: impl Fn(usize) -> f64,
        value: impl Fn(usize) -> f64,
    ) -> f64 {
        let classes = self.classes_of(group);
        if classes.len() == 1 {
            return value(classes.start);
        }
        let total: f64 = classes.clone().map(&weight).sum();
        classes.map(|k| weight(k) * value(k)).sum::<f64>() / total
    }

    /// Temperatures of the classes at the start.
    pub(super) fn temperatures(&self) -> Vec<f64> {
        self.classes.iter().map(|class| class.temperature).collect()
    }

    /// Lags of the displacements averaged over time, in the unit of time of the case; empty where none are.
    pub(super) fn lags(&self) -> Vec<f64> {
        self.case.lags()
    }

    /// Number of particles.
    pub fn particles(&self) -> usize {
        self.species.count()
    }

    /// Temperature of a species at the start.
    pub(super) fn temperature_of(&self, kind: u32) -> f64 {
        self.groups[self.group(kind)].temperature
    }

    /// Group of a species.
    #[inline]
    pub(super) fn group(&self, kind: u32) -> usize {
        match &self.group_of {
            None => kind as usize,
            Some(groups) => groups[kind as usize] as usize,
        }
    }

    /// Packing fraction; tracers take no room.
    pub fn packing_fraction(&self) -> f64 {
        let d = self.case.dimension;
        let unit = std::f64::consts::PI / if d == 2 { 4.0 } else { 6.0 };
        let kinds = self.species.kinds().iter().enumerate();
        let filled: f64 = kinds
            .filter(|(index, _)| self.tracer != Some(*index as u32))
            .map(|(_, kind)| kind.count as f64 * (2.0 * kind.radius).powi(d as i32))
            .sum();
        unit * filled / self.case.volume
    }

    /// Contact values for the engine.
    pub(super) fn contact(&self) -> dsmc::Contact {
        match self.case.contact_values {
            ContactValues::Dilute => dsmc::Contact::Dilute,
            ContactValues::Dense => dsmc::Contact::Enskog,
        }
    }

    /// The kinetic equations of the classes.
    pub(super) fn mixture(&self) -> Result<Mixture<Law>, TheoryError> {
        let components = self
            .classes
            .iter()
            .map(|class| Component {
                mass: class.mass,
                diameter: class.diameter,
                density: class.density,
            })
            .collect();
        let contact = match self.case.contact_values {
            ContactValues::Dilute => theory::Contact::Dilute,
            ContactValues::Dense => theory::Contact::Enskog,
        };
        Mixture::new(self.case.dimension, components, self.law.clone(), contact)
    }

    /// The cooling state that the gas starts in, if it does: cooling rates of all classes within a hundredth of each other.
    pub(super) fn cooling_state(&self) -> Option<CoolingState> {
        let mixture = self.mixture().ok()?;
        let constant = self.law.constant().is_some()
            || self
                .case
                .pairs
                .iter()
                .map(|pair| pair.1)
                .chain([self.case.restitution])
                .all(|law| matches!(law, case::Restitution::Constant(_)));
        let temperatures = self.temperatures();
        let rates: Vec<f64> = (0..temperatures.len())
            .map(|k| mixture.rates(k, &temperatures).cooling)
            .collect();
        let (least, most) = rates
            .iter()
            .fold((f64::INFINITY, 0.0_f64), |(least, most), &rate| {
                (least.min(rate), most.max(rate))
            });
        let together = least > 0.0 && most < 1.01 * least;
        (constant && together).then(|| CoolingState::from_temperatures(&mixture, temperatures))
    }

    /// Fourth cumulants of theory, where there is one for it: equal particles of constant restitution. First Sonine order
    /// by van Noije & Ernst, and in the form of Montanero & Santos.
    pub(super) fn fourth_cumulants(&self) -> Option<[f64; 2]> {
        let restitution = self.law.constant().filter(|&r| r < 1.0)?;
        let alone = self.groups.len() == 1 && self.case.sticking.is_none();
        let d = self.case.dimension;
        alone.then(|| {
            [
                kinetic::fourth_cumulant(d, restitution),
                kinetic::fourth_cumulant_of_montanero_santos(d, restitution),
            ]
        })
    }

    /// When particles stick or break, for the engine.
    pub(super) fn sticking(&self) -> Result<Option<Sticking>, PlanError> {
        let Some(written) = &self.case.sticking else {
            return Ok(None);
        };
        let part = |part| match part {
            EnergyPart::Full => Part::Full,
            EnergyPart::Normal => Part::Normal,
        };
        let threshold = |energy: Option<f64>, compared| Threshold {
            energy: energy.unwrap_or(f64::INFINITY),
            part: part(compared),
        };
        let rule = Rule {
            stick: threshold(written.stick_below, written.stick_part),
            shatter: threshold(written.break_above, written.break_part),
            order: match written.first {
                FirstTest::Stick => Order::StickFirst,
                FirstTest::Break => Order::BreakFirst,
            },
            retained: written.speed_kept_in_breaking,
            // Monomers are never more than at the start.
            most: self.particles(),
        };
        Sticking::new(rule).map(Some).ok_or(PlanError::Law {
            name: "a threshold of [sticking]",
        })
    }

    /// Named quantities that follow from the case.
    pub fn derived(&self) -> Vec<(String, f64)> {
        let mut list = vec![
            ("particles".to_owned(), self.particles() as f64),
            ("species".to_owned(), self.groups.len() as f64),
            ("packing_fraction".to_owned(), self.packing_fraction()),
            ("haff_time".to_owned(), self.haff_time),
            ("mean_free_time".to_owned(), self.mean_free_time),
            ("unit_of_time".to_owned(), self.time),
        ];
        if let Some([first, second]) = self.fourth_cumulants() {
            list.push(("fourth_cumulant_van_noije_ernst".to_owned(), first));
            list.push(("fourth_cumulant_montanero_santos".to_owned(), second));
        }
        list
    }
}

/// Species for the engine, their temperatures, and the number of groups where these are others: equal shares of the species,
/// which are the particles by size.
fn particles(case: &Case) -> (Vec<Kind>, Vec<f64>, Option<usize>) {
    match &case.content {
        Content::Species(species) => {
            let kinds = species.iter().map(|one| Kind {
                radius: 0.5 * one.diameter,
                mass: one.mass,
                count: one.count,
            });
            let temperatures = species.iter().map(|one| one.temperature).collect();
            (kinds.collect(), temperatures, None)
        }
        &Content::PowerLaw {
            monomers,
            exponent,
            largest_mass,
            rounding,
            temperature,
        } => {
            let kinds: Vec<Kind> = (1..=largest_mass.unwrap_or(u64::MAX))
                .map(|mass| Kind {
                    radius: 0.5 * root(mass as f64, case.dimension),
                    mass: mass as f64,
                    count: power_law_count(monomers, exponent, mass, rounding),
                })
                .take_while(|kind| kind.count > 0)
                .collect();
            let temperatures = vec![temperature; kinds.len()];
            (kinds, temperatures, None)
        }
        &Content::Continuous {
            particles,
            temperature,
            unit_mass,
            groups,
            ..
        } => {
            let mut stream = Streams::new(case.seed, 0).at(Purpose::Placement, [0, 0]);
            let mut diameters: Vec<f64> = (0..particles)
                .map(|_| diameter(&case.content, &mut stream))
                .collect();
            diameters.sort_by(f64::total_cmp);
            let kinds = diameters.iter().map(|d| Kind {
                radius: 0.5 * d,
                mass: unit_mass * d.powi(case.dimension as i32),
                count: 1,
            });
            (kinds.collect(), vec![temperature; particles], Some(groups))
        }
    }
}

/// `k^(1/D)`.
fn root(k: f64, dimension: usize) -> f64 {
    if dimension == 2 { k.sqrt() } else { k.cbrt() }
}

/// One diameter of a continuous distribution.
fn diameter(content: &Content, stream: &mut impl Rng) -> f64 {
    let &Content::Continuous {
        distribution,
        mean_diameter,
        relative_width,
        ..
    } = content
    else {
        return 1.0;
    };
    match distribution {
        Distribution::Uniform => {
            let place = 2.0 * stream.random::<f64>() - 1.0;
            mean_diameter * (1.0 + 3.0_f64.sqrt() * relative_width * place)
        }
        Distribution::LogNormal => {
            // exp(mu + s x) has the mean exp(mu + s^2/2) and the relative variance exp(s^2) - 1. Box & Muller's x; the
            // complement keeps the logarithm finite.
            let square = (relative_width * relative_width).ln_1p();
            let length = (-2.0 * (1.0 - stream.random::<f64>()).ln()).sqrt();
            let normal = length * (std::f64::consts::TAU * stream.random::<f64>()).cos();
            mean_diameter * (square.sqrt() * normal - 0.5 * square).exp()
        }
    }
}

fn groups(
    case: &Case,
    kinds: &[Kind],
    temperatures: &[f64],
    group_of: Option<&[u32]>,
    tracer: Option<u32>,
) -> Vec<Group> {
    let mut groups: Vec<Group> = Vec::new();
    for (index, (kind, &temperature)) in kinds.iter().zip(temperatures).enumerate() {
        let number = group_of.map_or(index, |groups| groups[index] as usize);
        if number >= groups.len() {
            groups.push(Group {
                count: 0,
                mass: 0.0,
                diameter: 0.0,
                temperature,
                density: 0.0,
            });
        }
        let group = &mut groups[number];
        group.count += kind.count;
        // Sums for now where a group has several sizes.
        group.mass += kind.mass;
        group.diameter += 2.0 * kind.radius;
        if tracer != Some(index as u32) {
            group.density += kind.count as f64 / case.volume;
        }
    }
    if group_of.is_some() {
        for group in &mut groups {
            let count = group.count.max(1) as f64;
            group.mass /= count;
            group.diameter /= count;
        }
    }
    groups
}
