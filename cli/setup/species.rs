//! Disks of several species, in reduced units.

use stosszahl_analysis::theory::{Component, Contact, Mixture};
use stosszahl_model::initial::SEQUENTIAL_LIMIT;
use stosszahl_model::{Constant, Polydisperse};

use super::{Law, Scale, Setup, SetupError, TimeUnit};
use crate::case::{Case, GasSpecies};

/// Disks of one species, in reduced units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DiskSpecies {
    /// How many.
    pub count: usize,
    /// Radius.
    pub radius: f64,
    /// Mass.
    pub mass: f64,
}

/// Numbers of disks by their shares: whole, and together all of them. What rounding leaves over or lacks is taken from
/// the largest share.
fn counts(species: &[GasSpecies], disks: usize) -> Vec<usize> {
    let mut counts: Vec<usize> = species
        .iter()
        .map(|one| (one.share * disks as f64).round() as usize)
        .collect();
    let largest = (0..species.len()).max_by(|&a, &b| species[a].share.total_cmp(&species[b].share));
    if let Some(largest) = largest {
        let others: usize = counts.iter().sum::<usize>() - counts[largest];
        counts[largest] = disks.saturating_sub(others);
    }
    counts
}

/// The case of several species.
pub(super) fn setup(case: &Case, disks: usize, packing_fraction: f64) -> Result<Setup, SetupError> {
    let counts = counts(&case.gas.species, disks);
    let mean = |value: fn(&GasSpecies) -> f64| {
        let sum: f64 = case
            .gas
            .species
            .iter()
            .zip(&counts)
            .map(|(one, &count)| count as f64 * value(one))
            .sum();
        sum / disks as f64
    };
    let scale = Scale {
        length: mean(|one| one.diameter),
        mass: mean(|one| one.mass),
        energy: case.temperature().unwrap_or(1.0),
    };
    let species: Vec<DiskSpecies> = case
        .gas
        .species
        .iter()
        .zip(&counts)
        .map(|(one, &count)| DiskSpecies {
            count,
            radius: 0.5 * one.diameter / scale.length,
            mass: one.mass / scale.mass,
        })
        .collect();
    let refused = |found: &str, expected: &str| SetupError::Content {
        file: "gas.species".into(),
        found: found.into(),
        expected: expected.into(),
    };
    if species.iter().any(|one| one.count == 0) {
        return Err(refused(
            "a species without disks",
            "shares that give each at least one",
        ));
    }
    if packing_fraction > SEQUENTIAL_LIMIT {
        return Err(refused(
            &format!("a packing fraction of {packing_fraction}"),
            "one of at most 0.45: disks of several species are placed one by one",
        ));
    }
    let list = species
        .iter()
        .flat_map(|one| std::iter::repeat_n((one.radius, one.mass), one.count));
    let sizes = Polydisperse::new(list.collect()).ok_or_else(|| {
        refused(
            "diameters or masses whose ratios are too large",
            "ratios up to 1e300",
        )
    })?;
    let covered: f64 = species
        .iter()
        .map(|one| one.count as f64 * std::f64::consts::PI * one.radius * one.radius)
        .sum();
    let area = covered / packing_fraction;
    let width = (area / case.domain.aspect_ratio).sqrt();
    let mut setup = Setup::assemble(
        case,
        scale,
        disks,
        [width, area / width],
        packing_fraction,
        Some(sizes),
        None,
    )?;
    setup.species = species;
    setup.find_time();
    Ok(setup)
}

impl Setup {
    /// Number of the species of a disk; simulators are numbered on, copy after copy of the gas.
    pub fn species_of(&self, index: usize) -> usize {
        let mut place = index % self.disks.max(1);
        for (number, one) in self.species.iter().enumerate() {
            if place < one.count {
                return number;
            }
            place -= one.count;
        }
        0
    }

    /// Enskog's kinetic equations of the species, where they apply: several of them, one coefficient.
    fn mixture(&self) -> Option<Mixture<Constant>> {
        let Law::Constant(law) = self.law else {
            return None;
        };
        if self.species.is_empty() {
            return None;
        }
        let area = self.domain.volume();
        let components = self.species.iter().map(|one| Component {
            mass: one.mass,
            diameter: 2.0 * one.radius,
            density: one.count as f64 / area,
        });
        Mixture::new(2, components.collect(), law, Contact::Enskog).ok()
    }

    /// Sets `t_0` to twice the energy over the rate of its loss, or to the mean free time of an elastic gas.
    fn find_time(&mut self) {
        let Some(mixture) = self.mixture() else {
            return;
        };
        let alike = vec![1.0; self.species.len()];
        let disks = self.disks as f64;
        let (mut loss, mut hits) = (0.0, 0.0);
        for (k, one) in self.species.iter().enumerate() {
            let rates = mixture.rates(k, &alike);
            let share = one.count as f64 / disks;
            loss += share * rates.cooling;
            hits += share * rates.collisions;
        }
        self.time = match self.time_unit {
            TimeUnit::Haff => 2.0 / loss,
            TimeUnit::MeanFreeTime => 1.0 / hits,
        };
    }

    /// Temperatures of the species over that of the start at given times over `t_0`, by Enskog's equations in as many Sonine
    /// orders as are quick; `None` where they do not apply.
    pub fn partial_temperatures(&self, times_over_t0: &[f64]) -> Option<Vec<Vec<f64>>> {
        if self.case.drive.is_some() {
            return None;
        }
        let times: Vec<f64> = times_over_t0.iter().map(|time| time * self.time).collect();
        let (mixture, start) = (self.mixture()?, vec![1.0; self.species.len()]);
        let mut orders = (1..=mixture.affordable_orders()).rev();
        let found = orders.find_map(|orders| mixture.solve(orders, &start, &times).ok())?;
        Some(
            found
                .into_iter()
                .map(|moment| moment.temperatures)
                .collect(),
        )
    }
}
