//! Vibration of a wall along its normal, as a triangle wave.

use serde::{Deserialize, Serialize};

use crate::invalid::InvalidValue;

/// Vibration of a wall as a triangle wave: in each period it goes `amplitude` into the gas and back
/// at constant speed, so that contact times have a closed form. It begins at its face, inwards, at
/// time zero.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Vibration {
    amplitude: f64,
    period: f64,
}

impl Vibration {
    /// Creates a vibration from an amplitude \[length\] and a period \[time\].
    ///
    /// # Errors
    /// [`InvalidValue`] unless amplitude and period are positive and finite.
    pub fn new(amplitude: f64, period: f64) -> Result<Self, InvalidValue> {
        Ok(Self {
            amplitude: InvalidValue::unless_positive("amplitude of a vibration", amplitude)?,
            period: InvalidValue::unless_positive("period of a vibration", period)?,
        })
    }

    /// Returns the amplitude of the vibration: the largest displacement of the wall into the gas
    /// \[length\].
    pub fn amplitude(&self) -> f64 {
        self.amplitude
    }

    /// Returns the period of the vibration: the time of one way into the gas and back \[time\].
    pub fn period(&self) -> f64 {
        self.period
    }

    /// Returns the constant speed of the vibrating wall \[length/time\].
    pub fn speed(&self) -> f64 {
        2.0 * self.amplitude / self.period
    }

    /// Returns the number of turns of the vibrating wall before a time: even on the way into the
    /// gas, odd on the way back. A turn belongs to the way that it begins.
    fn turns(&self, time: f64) -> f64 {
        let half = 0.5 * self.period;
        let turns = (time / half).floor();
        // The quotient may round to the next turn, or below this one.
        if (turns + 1.0) * half <= time {
            turns + 1.0
        } else if turns * half > time {
            turns - 1.0
        } else {
            turns
        }
    }

    /// Returns the displacement of the vibrating wall from its face into the gas at a time
    /// \[length\].
    pub fn displacement(&self, time: f64) -> f64 {
        let turns = self.turns(time);
        let since = (time - turns * 0.5 * self.period) * self.speed();
        if turns.rem_euclid(2.0) == 0.0 {
            since
        } else {
            self.amplitude - since
        }
    }

    /// Returns the velocity of the vibrating wall into the gas just after a time \[length/time\].
    pub fn velocity(&self, time: f64) -> f64 {
        if self.turns(time).rem_euclid(2.0) == 0.0 {
            self.speed()
        } else {
            -self.speed()
        }
    }

    /// Returns the first time after `time` at which the vibrating wall turns \[time\].
    pub fn next_turn(&self, time: f64) -> f64 {
        ((self.turns(time) + 1.0) * 0.5 * self.period).max(time.next_up())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn goes_to_and_fro() {
        let vibration = Vibration::new(0.5, 0.3).expect("a vibration");
        let mut time = 0.0;
        for turn in 0..1000 {
            let way = if turn % 2 == 0 { 0.0 } else { 0.5 };
            assert!((vibration.displacement(time) - way).abs() < 1e-12);
            let inwards = vibration.velocity(time) > 0.0;
            assert_eq!(inwards, turn % 2 == 0, "{turn}");
            let next = vibration.next_turn(time);
            assert!((next - time - 0.15).abs() < 1e-12);
            time = next;
        }
        assert!(Vibration::new(0.0, 1.0).is_err());
    }
}
