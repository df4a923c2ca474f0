//! Kinetic theory of a case in its plan: collision rates, Haff's law, steady states and expected
//! collisions.

use stosszahl_case::format::{PairCorrelationSpec, TimeUnit, VelocitiesSpec};
use stosszahl_model::{Law, Restitution as _, Space as _, Volume, equation_of_state};
use stosszahl_theory::{
    Component, ContactValues, MaxwellianMixture, Moment, TheoryError, UniformShear, cooling,
    delta_model,
};

use super::data::{CasePlan, PlanError, SizeGroup, in_space};

/// Computes Haff's time of the start, twice the energy over its loss rate, and the mean free time.
/// Both are infinite without dissipation or collisions. `weight` is the share of a size group.
pub(super) fn rates(
    classes: &[SizeGroup],
    mixture: &MaxwellianMixture<Law>,
    weight: impl Fn(&SizeGroup) -> f64,
) -> [f64; 2] {
    let temperatures: Vec<f64> = classes.iter().map(|class| class.temperature).collect();
    let (mut energy, mut loss, mut particles, mut hits) = (0.0, 0.0, 0.0, 0.0);
    for (k, class) in classes.iter().enumerate() {
        let rates = mixture.rates(k, &temperatures);
        let weight = weight(class);
        energy += weight * class.temperature;
        loss += weight * class.temperature * rates.cooling;
        particles += weight;
        hits += weight * rates.collisions;
    }
    let over = |a: f64, b: f64| if b > 0.0 { a / b } else { f64::INFINITY };
    [over(2.0 * energy, loss), over(particles, hits)]
}

/// Returns the cross-section of a pair of particles whose radii add up to a distance
/// \[length^(D-1)\].
fn cross_section(dimension: usize, distance: f64) -> f64 {
    in_space!(dimension, S => S::cross_section(distance))
}

/// Computes the mean free path of a dilute mixture at one temperature \[length\]: the mean over the
/// particles of `1/sum_q n_q s_pq sqrt(1 + m_p/m_q)` (Kawasaki 1985, A.1; Bird 1976). `sizes` has
/// count, radius and mass of equal particles.
pub(super) fn dilute_path(sizes: &[(f64, f64, f64)], volume: f64, dimension: usize) -> f64 {
    let total: f64 = sizes.iter().map(|one| one.0).sum();
    let path = |&(number, own, own_mass): &(f64, f64, f64)| {
        let rates = sizes.iter().map(|&(count, radius, mass)| {
            count / volume * cross_section(dimension, own + radius) * (1.0 + own_mass / mass).sqrt()
        });
        number / total / rates.sum::<f64>()
    };
    sizes.iter().map(path).sum()
}

impl CasePlan {
    /// Returns the contact values that theory uses: those of the case without a box, Enskog's in a
    /// box.
    pub fn contact(&self) -> ContactValues {
        let is_dilute = self.case.gas.pair_correlation == PairCorrelationSpec::Boltzmann;
        if is_dilute && !self.has_box() {
            ContactValues::Dilute
        } else {
            ContactValues::Enskog
        }
    }

    /// Creates the kinetic equations of the size groups of the case.
    ///
    /// # Errors
    /// [`TheoryError`] if the gas has none.
    pub fn mixture(&self) -> Result<MaxwellianMixture<Law>, TheoryError> {
        let components = self.gas.classes.iter().map(|class| Component {
            mass: class.mass,
            diameter: class.diameter,
            density: class.density,
        });
        let law = self.gas.law.clone();
        MaxwellianMixture::new(
            self.gas.dimension,
            components.collect(),
            law,
            self.contact(),
        )
    }

    /// Returns the initial temperatures of the size groups \[energy\].
    pub fn temperatures(&self) -> Vec<f64> {
        self.gas
            .classes
            .iter()
            .map(|class| class.temperature)
            .collect()
    }

    /// Returns true if theory for a uniform gas of one species of smooth particles with constant
    /// restitution applies.
    pub fn has_theory(&self) -> bool {
        let sizes = !matches!(
            self.gas.particles.sizes,
            stosszahl_model::SizeDistribution::Each(_)
        );
        let bathed = self.case.bath().is_some();
        // A gas that begins in a part of the box is alike everywhere only once it has mixed.
        let uniform = self.case.start.region.is_none() || bathed;
        let settled = bathed || !matches!(self.case.start.velocities, VelocitiesSpec::Drawn(_));
        self.is_uniform_box()
            && !self.is_rough()
            && !self.is_sheared()
            && sizes
            && uniform
            && settled
            && self.gas.classes.len() == 1
            && self.gas.law.constant().is_some()
    }

    /// Computes the fourth cumulant a2 of the homogeneous cooling state, or of the steady state in
    /// a bath; 0 for an elastic gas.
    pub fn fourth_cumulant(&self) -> f64 {
        match self.bath_state() {
            Some(state) => state.fourth_cumulant,
            None => cooling::fourth_cumulant(self.gas.dimension, self.gas.restitution),
        }
    }

    /// Computes Enskog's collision rate per particle at the start \[1/engine time\].
    pub fn collision_rate(&self) -> f64 {
        if self.is_disk_fluid() {
            equation_of_state::collision_rate(
                self.gas.packing_fraction,
                self.gas.contact_value,
                self.fourth_cumulant(),
            )
        } else {
            1.0 / self.clock.mean_free_time
        }
    }

    /// Computes Enskog's mean free path \[engine length\].
    pub fn mean_free_path(&self) -> f64 {
        let (packing, chi, diameter) = (
            self.gas.packing_fraction,
            self.gas.contact_value,
            2.0 * self.mean_radius(),
        );
        diameter
            * match self.gas.dimension {
                2 => equation_of_state::mean_free_path(packing, chi),
                _ => Volume::mean_free_path(packing, chi),
            }
    }

    /// Computes the mean free path of the dilute mixture at one temperature \[engine length\].
    pub fn dilute_mean_free_path(&self) -> f64 {
        let sizes = self.gas.classes.iter();
        let sizes = sizes.map(|class| (class.count as f64, 0.5 * class.diameter, class.mass));
        dilute_path(
            &sizes.collect::<Vec<_>>(),
            self.gas.volume,
            self.gas.dimension,
        )
    }

    /// Computes the collision rate of a particle at the start in the uniform dilute gas \[1/engine
    /// time\].
    pub fn dilute_collision_rate(&self) -> f64 {
        let total: f64 = self
            .gas
            .classes
            .iter()
            .map(|class| class.count as f64)
            .sum();
        let mean_speed = match self.gas.dimension {
            2 => std::f64::consts::FRAC_PI_2,
            _ => 8.0 / std::f64::consts::PI,
        };
        let rates = self.gas.classes.iter().map(|one| {
            let with = self.gas.classes.iter().map(|other| {
                let density = other.count as f64 / self.gas.volume;
                let over = self.gas.temperature * (1.0 / one.mass + 1.0 / other.mass);
                let distance = 0.5 * one.diameter + 0.5 * other.diameter;
                density * cross_section(self.gas.dimension, distance) * (mean_speed * over).sqrt()
            });
            one.count as f64 / total * with.sum::<f64>()
        });
        rates.sum()
    }

    /// Converts a time of the case to units of Haff's time; `None` in a gas that does not cool.
    pub fn time_over_haff(&self, time: f64) -> Option<f64> {
        let haff = self.clock.haff_time.is_finite() && self.clock.haff_time > 0.0;
        haff.then(|| match self.clock.time_unit {
            TimeUnit::Haff => time,
            _ => self.engine_time(time) / self.clock.haff_time,
        })
    }

    /// Computes the energy at a time of the case over that of the start, by Haff's law with its
    /// Sonine factor; `None` if the law does not apply, as with a thermostat.
    pub fn haff_ratio(&self, time: f64) -> Option<f64> {
        let free = self.case.thermostat.is_none();
        (free && self.has_theory()).then(|| self.haff_law(time))
    }

    /// Computes the energy ratio K/K(0) at a time of the case by Haff's law with its Sonine factor.
    fn haff_law(&self, time: f64) -> f64 {
        self.time_over_haff(time)
            .map_or(1.0, |time| cooling::haff_law(time, self.fourth_cumulant()))
    }

    /// Computes the growth, up to a time of the case, of a quantity that grows from 0 as `free` in
    /// a freely cooling gas. If a thermostat scales velocities, the gas starts again at the initial
    /// temperature after each interval.
    pub(crate) fn passed(&self, time: f64, free: impl Fn(f64) -> f64) -> f64 {
        let Some(interval) = self.case.rescaling() else {
            return free(time);
        };
        let intervals = (time / interval + 1e-9).floor();
        let rest = (time - intervals * interval).max(0.0);
        intervals * free(interval) + free(rest)
    }

    /// Computes the logarithm by which the thermal speed has fallen up to a time of the case, by
    /// Haff's law with or without its Sonine factor, ignoring any scaling; `None` if the gas does
    /// not cool by that law.
    pub fn cooling_logarithm(&self, time: f64, with_cumulant: bool) -> Option<f64> {
        let cools = self.has_theory() && self.case.bath().is_none() && self.gas.restitution < 1.0;
        cools.then(|| {
            self.passed(time, |time| match self.time_over_haff(time) {
                _ if with_cumulant => -0.5 * self.haff_law(time).ln(),
                passed => passed.unwrap_or(0.0).ln_1p(),
            })
        })
    }

    /// Estimates the collisions per particle up to a time of the case by theory. Without one the
    /// estimate is rough; with walls or gravity it is that of the uniform gas at the initial
    /// temperature.
    pub fn expected_collisions(&self, time: f64) -> f64 {
        let rate = 1.0 / self.clock.mean_free_time;
        if self.case.bath().is_some() {
            return self.collisions_in_bath(time);
        }
        if let Some(collisions) = self.collisions_in_flow(time) {
            return collisions;
        }
        if !self.is_uniform() {
            return rate * self.engine_time(time);
        }
        self.passed(time, |time| match self.time_over_haff(time) {
            Some(time) if self.has_theory() => {
                cooling::haff_collisions(self.gas.dimension, self.gas.restitution, time)
            }
            // The collision rate of any gas that cools as Haff's law says.
            Some(time) => rate * self.clock.haff_time * time.ln_1p(),
            None => rate * self.engine_time(time),
        })
    }

    /// Estimates the share of a run's work that is done at a time of the case, by its expected
    /// collisions.
    pub fn done_share(&self, time: f64) -> f64 {
        let all = self.expected_collisions(self.case.run.until);
        if all > 0.0 && all.is_finite() {
            (self.expected_collisions(time) / all).clamp(0.0, 1.0)
        } else {
            (time / self.case.run.until).clamp(0.0, 1.0)
        }
    }

    /// Computes the temperatures of the species over that of the start, at the sample times, by
    /// Enskog's equations in as many Sonine orders as are quick. They are solved once; `None` if
    /// they do not apply.
    pub fn partial_temperatures(&self) -> Option<&[Vec<f64>]> {
        let solved = self.theory.partial_temperatures.get_or_init(|| {
            let constant = !matches!(self.gas.law, Law::Viscoelastic(_));
            let free = self.case.bath().is_none() && !self.is_sheared();
            let applies = self.is_uniform_box() && !self.is_rough() && free && constant;
            let species = self.gas.species.len();
            if !applies || species < 2 || self.gas.classes.len() != species {
                return None;
            }
            let times = self.sample_times();
            let times: Vec<f64> = times.iter().map(|&time| self.engine_time(time)).collect();
            let (mixture, start) = (self.mixture().ok()?, self.temperatures());
            let mut orders = (1..=mixture.affordable_orders()).rev();
            let found = orders.find_map(|orders| mixture.solve(orders, &start, &times).ok())?;
            let all = found.into_iter();
            Some(all.map(|moment| moment.temperatures).collect())
        });
        solved.as_deref()
    }

    /// Checks that a gas with aggregation has one species and no box.
    pub(super) fn check_sticking(&self) -> Result<(), PlanError> {
        let good =
            self.case.aggregation.is_none() || !self.has_box() && self.gas.classes.len() == 1;
        let allowed = "one species in a gas without [box]";
        PlanError::require(good, "aggregation", "particles that stick", allowed)
    }

    /// Computes the steady temperature over that of the start, by Enskog's theory with its Sonine
    /// correction; `None` for a gas without a steady state or without theory.
    pub fn steady_temperature(&self) -> Option<f64> {
        if self.case.bath().is_some() {
            return self.steady_guess().filter(|_| self.has_theory());
        }
        self.steady_state().map(|moment| moment.temperatures[0])
    }

    /// Computes the collisions per particle up to a time of the case in a uniform shear flow, by
    /// the kinetic model of dilute gases at the collision rate of this density; `None` without
    /// shear. The model lacks collisional stress, so dense gases collide more often.
    fn collisions_in_flow(&self, time: f64) -> Option<f64> {
        let (flow, rate) = self.shear_flow()?;
        let chi = self.gas.contact_value;
        let total: f64 = self
            .gas
            .classes
            .iter()
            .map(|one| one.count as f64 * one.mass)
            .sum();
        let speed = (self.gas.temperature * self.count() as f64 / total).sqrt();
        let relaxation = chi * self.shear_relaxation() * speed;
        let found = flow.after(rate, relaxation, self.engine_time(time)).ok()?;
        Some(found.elapsed / self.clock.mean_free_time)
    }

    /// Returns the theory of uniform shear flow in a dilute gas with the restitution of the case,
    /// and the shear rate in engine units; `None` without shear.
    pub(crate) fn shear_flow(&self) -> Option<(UniformShear, f64)> {
        let rate = self.gas.particles.shear_rate?;
        Some((
            UniformShear::new(self.gas.dimension, self.gas.restitution),
            rate,
        ))
    }

    /// Computes the relaxation rate of the stress in a dilute gas at T = m = 1, in engine units.
    pub(crate) fn shear_relaxation(&self) -> f64 {
        let density = self.count() as f64 / self.gas.volume;
        UniformShear::relaxation_rate(self.gas.dimension, density, 2.0 * self.mean_radius())
    }

    /// Returns true if contacts may add energy, so that a gas without walls or bath reaches a
    /// steady state.
    pub fn heats_itself(&self) -> bool {
        self.gas.law.max_added_speed() > 0.0
    }

    /// Computes the steady state of a uniform gas that its contacts heat, by Enskog's equations in
    /// as many Sonine orders as are quick, solved once. The temperature is over that of the start.
    /// `None` if the equations do not apply.
    pub fn steady_state(&self) -> Option<&Moment> {
        let solved = self.theory.steady_state.get_or_init(|| {
            let uniform = self.is_uniform() && self.gas.classes.len() == 1 && !self.is_rough();
            if !(uniform && self.heats_itself()) {
                return None;
            }
            let law = self.gas.law.delta()?;
            let mixture = self.mixture().ok()?;
            let scale = self.gas.classes[0].mass * law.delta().powi(2);
            let start = vec![scale * delta_model::maxwellian_temperature(law.coefficient())?];
            // From the Maxwellian estimate, which is right to a few per cent, the gas relaxes by a
            // share of 1 - r^2 in a collision.
            let free_time = 1.0 / mixture.rates(0, &start).collisions;
            let until = 40.0 * free_time / (1.0 - law.coefficient().powi(2));
            let mut orders = (1..=mixture.affordable_orders()).rev();
            let found = orders.find_map(|orders| mixture.solve(orders, &start, &[until]).ok())?;
            let mut moment = found.into_iter().next_back()?;
            moment.temperatures[0] /= self.gas.temperature;
            Some(moment)
        });
        solved.as_ref()
    }
}
