//! Test of the pair correlation at contact: g(d+) from the flux of colliding pairs, against the
//! collision rate and Enskog's theory.
//!
//! Claims concern the contact value of elastic disks. Under molecular chaos they also concern the
//! ratio of the flux to the collision rate, `(1 + r)/(2 r)` for the restitution r. For exact
//! inelastic disks both are only measured. Partners about to collide approach more slowly than the
//! temperature suggests, so their flux is higher.

use stosszahl_analysis::contact_value::{ContactFlux, number_of_pairs, separation_factor};
use stosszahl_analysis::replicas::ratio_of_means;
use stosszahl_analysis::statistics::Estimate;
use stosszahl_dsmc::Parameters;
use stosszahl_model::{Budget, Simulation, equation_of_state};
use stosszahl_theory::cooling;

use super::gas::{exact, monte_carlo, start};
use super::over_seeds;
use super::schemes::METHODS;
use crate::table::RowPlace;
use crate::{Done, TrialError, TrialLog};

/// Packing fractions at which the pair correlation at contact is measured.
const PACKINGS: [f64; 3] = [0.05, 0.25, 0.5];
/// Collisions per disk before the pair correlation is measured. By then the fourth cumulant a2 has
/// relaxed.
const SETTLE: u64 = 5;
/// Monte Carlo simulators per disk of the gas under molecular chaos.
const SIMULATORS: u32 = 16;

/// Gas of unit disks in which the pair correlation at contact is measured.
#[derive(Clone, Copy, Debug)]
pub struct UnitDiskGas {
    /// Number of disks in the gas for the contact value.
    pub disks: usize,
    /// Packing fraction of the gas for the contact value.
    pub packing: f64,
    /// Coefficient of restitution of the gas for the contact value.
    pub restitution: f64,
    /// Collisions per disk over which the pair correlation is measured.
    pub collisions: u64,
}

/// Pair correlation at contact of a gas, averaged over seeds, by two methods.
#[derive(Clone, Copy, Debug)]
pub struct ContactValue {
    /// Pair correlation at contact χ of a gas, from its collision rate.
    pub rate: Estimate,
    /// Pair correlation at contact g(d+) from the flux of colliding pairs.
    pub flux: Estimate,
    /// Ratio of g(d+) from the flux to (1 + r)/(2 r) χ from the collision rate, for the restitution
    /// r; 1 under molecular chaos.
    pub flux_over_rate: Estimate,
    /// CPU time of the gases with all seeds \[s\].
    pub seconds: f64,
}

impl UnitDiskGas {
    /// Returns three sums over the collisions of a gas for the contact value: by collision rate, by
    /// flux, and the norm that divides both.
    fn follow(&self, mut gas: Box<dyn Simulation>) -> Result<[f64; 3], TrialError> {
        let (simulators, disks) = (gas.particle_count() as f64, self.disks as f64);
        let of_each = |number: u64| Budget::Collisions(number * gas_pairs(simulators));
        gas.advance(f64::INFINITY, of_each(SETTLE), &mut ())?;
        let (time, temperature) = (gas.time(), gas.temperature());
        let span = [time, f64::INFINITY];
        let mut flux = ContactFlux::new(&[span], 2, disks, time, temperature);
        gas.advance(f64::INFINITY, of_each(self.collisions), &mut flux)?;
        flux.synchronise(gas.time(), gas.temperature());
        let window = &flux.windows[0];
        let pairs = number_of_pairs(true, [disks; 2], disks / simulators);
        let norm = window.norm(2, pairs, gas.particles().volume());
        // The gas as a whole is at rest.
        let sonine = 1.0 - cooling::fourth_cumulant(2, self.restitution) / 16.0;
        let expected = sonine * (simulators / (simulators - 1.0)).sqrt();
        let sums = window.pair_sums([0, 0]);
        Ok([
            sums.rate / expected,
            sums.approaching + sums.separating,
            norm,
        ])
    }

    /// Measures the pair correlation at contact of exact disks, averaged over seeds.
    ///
    /// # Errors
    ///
    /// [`TrialError`] if the gas cannot be created or simulated.
    pub fn exact(&self, seeds: u64) -> Result<ContactValue, TrialError> {
        let all = over_seeds(0..seeds, |seed| {
            let start = start(self.disks, self.packing, seed, 20.0)?;
            self.follow(exact(&start, self.restitution)?)
        })?;
        self.found(all)
    }

    /// Measures the pair correlation at contact under molecular chaos: Monte Carlo at Enskog's rate
    /// in one cell.
    fn chaos(&self, seeds: u64) -> Result<ContactValue, TrialError> {
        let enskog = METHODS.iter().find(|method| method.name == "enskog");
        let method = enskog.ok_or_else(|| TrialError::failed("no scheme enskog"))?;
        let all = over_seeds(0..seeds, |seed| {
            let start = start(self.disks, self.packing, seed, 5.0)?;
            let parameters = Parameters {
                cell_size: Some(start.lengths[0]),
                simulators_per_particle: SIMULATORS,
                ..method.parameters
            };
            self.follow(monte_carlo(&start, self.restitution, parameters, seed)?)
        })?;
        self.found(all)
    }

    fn found(&self, (all, seconds): (Vec<[f64; 3]>, f64)) -> Result<ContactValue, TrialError> {
        let ratio = |of: &dyn Fn(&[f64; 3]) -> (f64, f64)| {
            let pairs: Vec<(f64, f64)> = all.iter().map(of).collect();
            ratio_of_means(&pairs).ok_or_else(|| TrialError::failed("no gas"))
        };
        let factor = separation_factor(self.restitution);
        Ok(ContactValue {
            rate: ratio(&|[rate, _, norm]| (*rate, *norm))?,
            flux: ratio(&|[_, flux, norm]| (*flux, *norm))?,
            flux_over_rate: ratio(&|[rate, flux, _]| (*flux, factor * rate))?,
            seconds,
        })
    }
}

/// Returns the number of pair collisions that amounts to one collision per simulator.
fn gas_pairs(simulators: f64) -> u64 {
    (0.5 * simulators).ceil() as u64
}

/// Measures the pair correlation at contact of elastic and of cooling gases by the flux of colliding
/// pairs, in event-driven dynamics and in Monte Carlo, and adds a row for each to the log.
pub(super) fn test_contact(log: &mut TrialLog) -> Done {
    let more = if log.effort.quick { 1 } else { 4 };
    let what = "g(d+) by flux over (1 + r)/(2 r) χ of the collision rate";
    for packing in PACKINGS {
        let chi = equation_of_state::contact_value(packing);
        let place = |scheme, setting, found: &ContactValue| {
            RowPlace::new("exact", scheme, setting, packing, found.seconds)
        };
        let elastic = UnitDiskGas {
            disks: 1000,
            packing,
            restitution: 1.0,
            collisions: 50,
        };
        let found = elastic.exact(40 * more)?;
        let here = place("event-driven", "1000 disks", &found);
        log.claim(&here, "g(d+) by flux", chi, found.flux, Some(0.004 * chi));
        let rate = "χ of the collision rate";
        log.claim(&here, rate, chi, found.rate, Some(0.003 * chi));
        let cooling = UnitDiskGas {
            restitution: 0.8,
            collisions: 5,
            ..elastic
        };
        let found = cooling.exact(200 * more)?;
        let setting = "1000 disks, r = 0.8, 5 to 10 collisions of each";
        let here = place("event-driven", setting, &found);
        let flux = separation_factor(0.8) * chi;
        log.claim(&here, "g(d+) by flux", flux, found.flux, None);
        log.claim(&here, rate, chi, found.rate, None);
        log.claim(&here, what, 1.0, found.flux_over_rate, None);
        let chaos = UnitDiskGas {
            disks: 100,
            collisions: 100,
            ..cooling
        };
        let found = chaos.chaos(16 * more)?;
        let here = place("enskog", "r = 0.8, one cell", &found);
        log.claim(&here, what, 1.0, found.flux_over_rate, Some(0.005));
    }
    Ok(())
}
