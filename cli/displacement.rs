//! What theory expects of the mean squared displacement.

use stosszahl_model::kinetic;

use crate::setup::{Setup, TimeUnit};

impl Setup {
    /// Mean squared displacement in units of d^2, a time `elapsed` (in units of `t0`) after the start of its measurement,
    /// by Enskog's theory in first Sonine order; `None` where it does not apply.
    ///
    /// A driven gas is taken to be in its steady state, whatever the start was.
    pub fn displacement_theory(&self, elapsed: f64) -> Option<f64> {
        let start = self.case.measure.displacement_start?;
        if !self.has_theory() {
            return None;
        }
        let decay =
            kinetic::velocity_decay(self.packing_fraction, self.contact_value, self.restitution);
        let steady = |temperature: f64| {
            kinetic::steady_displacement(
                temperature,
                decay * temperature.sqrt(),
                elapsed * self.time,
            )
        };
        match (self.case.drive, self.time_unit) {
            (None, TimeUnit::MeanFreeTime) => Some(steady(1.0)),
            // T t0^2 is the same at all times of the cooling state, and t0 grows as 1 + t.
            (None, TimeUnit::Haff) => {
                let square = self.time * self.time;
                Some(
                    square
                        * kinetic::cooling_displacement(self.restitution, elapsed / (1.0 + start)),
                )
            }
            (Some(_), _) => self.steady_temperature().map(steady),
        }
    }
}
