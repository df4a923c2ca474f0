//! Thermal bath in the plan of a case: engine parameters, steady state in theory, and warnings.

use stosszahl_case::format::ThermostatKind;
use stosszahl_model::{Bath, InvalidValue};
use stosszahl_results::format_number;
use stosszahl_theory::{BathState, transport};

use super::data::{CasePlan, PlanError};

/// Smallest length of a run, in relaxation times of its bath, at which the last half has forgotten
/// the start. Of 20 relaxation times, half leave e^-10 of it.
const LEAST_RELAXATIONS: f64 = 20.0;
/// Largest share of the temperature that a kick of white noise may add without a warning. The mean
/// temperature then differs from that of the continuous bath by `share^2/32 < 4e-4`.
const LARGEST_KICK: f64 = 0.1;
/// Default interval of kicks in a Langevin bath, times the sum of collision rate and drag. The
/// splitting error goes with its square: some 3e-4 of the temperature at restitution 0.8.
const KICKED_PART: f64 = 0.2;
/// Largest interval of kicks in a Langevin bath without a warning, times the sum of collision rate
/// and drag.
const LARGEST_PART: f64 = 0.5;
/// Smallest default number of kicks of a Langevin bath in a run.
const LEAST_KICKS: f64 = 10.0;

impl CasePlan {
    /// Returns the bath in engine units, and the time between two kicks in the unit of time of the
    /// case.
    ///
    /// # Errors
    /// [`PlanError`] if its numbers leave the range of floating-point numbers.
    pub fn bath(&self) -> Result<Option<(Bath, f64)>, PlanError> {
        let (Some(thermostat), Some(interval)) = (self.case.bath(), self.kick_interval()) else {
            return Ok(None);
        };
        let time = interval * self.clock.time;
        let bath = match thermostat.kind {
            ThermostatKind::Langevin => Bath::langevin(self.drag(), self.bath_temperature(), time),
            _ => Bath::white_noise(self.heating(), time),
        };
        let failed =
            |error: InvalidValue| PlanError::new("thermostat", error.to_string(), error.allowed);
        bath.map(|bath| Some((bath, interval))).map_err(failed)
    }

    /// Checks the bath, and adds a note on the interval of kicks if the program chooses it.
    pub(super) fn check_bath(&mut self) -> Result<(), PlanError> {
        let Some((_, interval)) = self.bath()? else {
            return Ok(());
        };
        if self.case.bath().is_some_and(|one| one.interval.is_none()) {
            self.notes.choices.push(format!(
                "thermostat.interval = {}: a fifth of the time in which collisions and drag change a velocity, and at most a tenth of \
                 the run; the error of kicks at intervals goes with the square of it",
                format_number(interval)
            ));
        }
        Ok(())
    }

    /// Returns the drag coefficient of a Langevin bath \[1/engine time\]; 0 for other gases.
    fn drag(&self) -> f64 {
        let drag = self.case.bath().and_then(|one| one.drag);
        drag.unwrap_or(0.0) / self.clock.time
    }

    /// Returns the temperature of a Langevin bath \[energy\], by default that of the start.
    fn bath_temperature(&self) -> f64 {
        let given = self.case.bath().and_then(|one| one.bath_temperature);
        given.map_or(self.gas.temperature, |given| given / self.scale.energy)
    }

    /// Returns the energy that white noise adds to each particle \[energy/engine time\]; 0 for
    /// other gases.
    fn heating(&self) -> f64 {
        let heating = self.case.bath().and_then(|one| one.heating);
        heating.unwrap_or(0.0) * self.gas.temperature / self.clock.time
    }

    /// Estimates the rate at which velocities change in a bath: collision rate in the steady state
    /// plus drag \[1/engine time\].
    fn rate_of_change(&self) -> f64 {
        let hotter = self.steady_guess().unwrap_or(1.0).max(1.0);
        hotter.sqrt() / self.clock.mean_free_time + self.drag()
    }

    /// Returns the time between two kicks of a bath, in the unit of time of the case; `None`
    /// without a bath.
    pub fn kick_interval(&self) -> Option<f64> {
        let bath = self.case.bath()?;
        Some(bath.interval.unwrap_or_else(|| {
            let natural = KICKED_PART / (self.rate_of_change() * self.clock.time);
            natural.min(self.case.run.until / LEAST_KICKS)
        }))
    }

    /// Computes the steady state of the gas in its bath by theory in first Sonine order, in engine
    /// units, as if it were uniform and of equal smooth particles. `None` without a bath, and if
    /// the gas heats up for ever.
    pub fn bath_state(&self) -> Option<BathState> {
        self.case.bath()?;
        let drag = self.drag();
        let gain =
            2.0 * drag * self.bath_temperature() + 2.0 / self.gas.dimension as f64 * self.heating();
        let cooling = 2.0 / (self.clock.haff_time * self.gas.temperature.sqrt());
        BathState::new(
            self.gas.dimension,
            self.gas.restitution,
            cooling,
            drag,
            gain,
        )
    }

    /// Estimates the steady temperature in a bath over that of the start, also for particles of
    /// several sizes and viscoelastic ones.
    pub fn steady_guess(&self) -> Option<f64> {
        Some(self.bath_state()?.temperature / self.gas.temperature)
    }

    /// Computes the kinematic viscosity of disks in the steady state of their bath \[engine
    /// length^2/engine time\], by Enskog's theory.
    pub fn bath_viscosity(&self) -> Option<f64> {
        let state = self.bath_state()?;
        let (phi, speed) = (self.gas.packing_fraction, state.temperature.sqrt());
        let (r, a2) = (self.gas.restitution, state.fourth_cumulant);
        let viscosity =
            transport::bath_viscosity(phi, self.gas.contact_value, r, a2, state.drag / speed);
        Some(viscosity * speed / transport::number_density(phi))
    }

    /// Returns the relaxation time of the temperature in a bath, in the unit of time of the case.
    pub fn relaxation_time(&self) -> Option<f64> {
        Some(self.bath_state()?.relaxation_time() / self.clock.time)
    }

    /// Returns the number of kicks of the bath in the run; `None` without a bath.
    pub(super) fn kicks(&self) -> Option<f64> {
        Some(
            (self.case.run.until / self.kick_interval()? - 0.5)
                .ceil()
                .max(0.0),
        )
    }

    /// Estimates the number of collisions per particle up to a time in a bath: in the steady state
    /// or, if there is none, while the gas heats up.
    pub(super) fn collisions_in_bath(&self, time: f64) -> f64 {
        let rate = self.clock.time / self.clock.mean_free_time;
        if let Some(temperature) = self.steady_guess() {
            return rate * temperature.sqrt() * time;
        }
        // The integral of sqrt(1 + h t).
        let heating = 2.0 / self.gas.dimension as f64 * self.heating();
        let h = heating * self.clock.time / self.gas.temperature;
        rate * 2.0 / (3.0 * h) * ((1.0 + h * time).powf(1.5) - 1.0)
    }

    pub(super) fn notable_bath(&self, list: &mut Vec<String>) {
        let (Some(bath), Some(interval)) = (self.case.bath(), self.kick_interval()) else {
            return;
        };
        let (Some(temperature), Some(relaxation)) = (self.steady_guess(), self.relaxation_time())
        else {
            list.push(
                "thermostat: nothing is lost at restitution 1, so white noise heats the gas up without end"
                    .to_owned(),
            );
            return;
        };
        let relaxations = self.case.run.until / relaxation;
        if relaxations < LEAST_RELAXATIONS {
            list.push(format!(
                "thermostat: run.until is {} relaxation times, so the steady state may not be reached; at least {LEAST_RELAXATIONS} \
                 leave nothing of the start in the last half",
                format_number(relaxations)
            ));
        }
        if let Some(heating) = bath.heating {
            let share = heating * interval / temperature;
            if share > LARGEST_KICK {
                list.push(format!(
                    "thermostat: each kick adds {} of the steady temperature, which is no white noise; an interval of at most {} is",
                    format_number(share),
                    format_number(LARGEST_KICK * temperature / heating)
                ));
            }
            return;
        }
        let rate = self.rate_of_change() * self.clock.time;
        if interval * rate > LARGEST_PART {
            list.push(format!(
                "thermostat.interval: kicks are rarer than collisions and drag change a velocity, and the temperature differs from that \
                 of a continuous bath; an interval of at most {} is close to one",
                format_number(LARGEST_PART / rate)
            ));
        }
    }
}
