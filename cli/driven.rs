//! What theory expects of a driven gas, and which drives deserve a second look.
//!
//! A gas that gains `h` temperatures of its start in each `t0` has `dT/dt = h - 2 (1 + 3 a2/16) T^(3/2)`, with
//! times in units of `t0` and temperatures in that of the start: Haff's law and a gain.

use stosszahl_model::{Drive, kinetic};

use crate::setup::{Setup, SetupError, TimeUnit};

/// Relaxation times in a run, below which its last half still remembers the start: e^-10 is left after half of it.
const LEAST_RELAXATIONS: f64 = 20.0;
/// Largest share of the temperature that a kick may add: the mean temperature then differs from that of white noise
/// by `share^2/32 < 4e-4`, from the saw tooth of the temperature.
const LARGEST_KICK: f64 = 0.1;

impl Setup {
    /// The drive in reduced units.
    ///
    /// # Errors
    /// [`SetupError::Content`] if its numbers leave the range of floating-point numbers.
    pub fn drive(&self) -> Result<Option<Drive>, SetupError> {
        let Some(drive) = self.case.drive else {
            return Ok(None);
        };
        let found = Drive::new(drive.heating / self.time, drive.interval * self.time);
        found.map(Some).ok_or_else(|| SetupError::Content {
            file: "[drive]".into(),
            found: format!(
                "heating = {:?} with interval = {:?}",
                drive.heating, drive.interval
            ),
            expected: "a kick whose energy is a floating-point number above 0".into(),
        })
    }

    /// Temperature of the steady state over that of the start, by Enskog's theory with its Sonine correction; `None`
    /// for a gas that has no such state or no such theory.
    pub fn steady_temperature(&self) -> Option<f64> {
        let drive = self.case.drive?;
        (self.has_theory() && self.time_unit == TimeUnit::Haff)
            .then(|| kinetic::heated_temperature(drive.heating, self.fourth_cumulant()))
    }

    /// The same, roughly, for unlike disks and viscoelastic ones too.
    fn steady_guess(&self) -> Option<f64> {
        let drive = self.case.drive?;
        (self.time_unit == TimeUnit::Haff).then(|| kinetic::heated_temperature(drive.heating, 0.0))
    }

    /// Collisions per particle up to a time in the steady state; without one, while the gas heats up.
    pub(crate) fn driven_collisions(&self, heating: f64, time_over_t0: f64) -> f64 {
        let rate = kinetic::collision_rate(self.packing_fraction, self.contact_value, 0.0);
        let path = match self.steady_guess() {
            Some(temperature) => temperature.sqrt() * time_over_t0,
            // The integral of sqrt(1 + h t).
            None => 2.0 / (3.0 * heating) * ((1.0 + heating * time_over_t0).powf(1.5) - 1.0),
        };
        rate * self.time * path
    }

    /// Derived quantities of the drive, by name.
    pub(crate) fn driven_quantities(&self) -> Vec<(String, f64)> {
        let Some(drive) = self.case.drive else {
            return Vec::new();
        };
        let mut list = vec![
            (
                "kicks".to_owned(),
                (self.case.run.until / drive.interval).ceil() - 1.0,
            ),
            (
                "heating_per_particle_and_time".to_owned(),
                drive.heating * self.scale.energy / (self.time * self.scale.time()),
            ),
        ];
        if let Some(temperature) = self.steady_temperature() {
            let relaxation = kinetic::heated_relaxation(drive.heating, self.fourth_cumulant());
            list.push(("steady_temperature_over_start".to_owned(), temperature));
            list.push(("relaxation_time_over_t0".to_owned(), relaxation));
        }
        list
    }

    /// What is allowed of a drive but deserves a second look.
    pub(crate) fn driven_warnings(&self) -> Vec<String> {
        let Some(drive) = self.case.drive else {
            return Vec::new();
        };
        let Some(temperature) = self.steady_guess() else {
            return vec![
                "drive: nothing is lost at gas.restitution = 1, so the gas heats up without end"
                    .into(),
            ];
        };
        let mut list = Vec::new();
        let relaxations = self.case.run.until / kinetic::heated_relaxation(drive.heating, 0.0);
        if relaxations < LEAST_RELAXATIONS {
            list.push(format!(
                "drive: run.until is {relaxations:.1} times the relaxation time, so the steady state may not be reached; \
                 at least {LEAST_RELAXATIONS} leave nothing of the start in the last half"
            ));
        }
        let share = drive.heating * drive.interval / temperature;
        if share > LARGEST_KICK {
            list.push(format!(
                "drive: each kick adds {share:.2} of the steady temperature, which is no white noise; a shorter interval, at \
                 most {:.3}, is",
                LARGEST_KICK * temperature / drive.heating
            ));
        }
        list
    }
}
