//! Collision and cooling rates of the homogeneous cooling state over those of Maxwellian
//! velocities, from Sonine expansions.

use stosszahl_model::Constant;

use super::component::Component;
use super::contact::ContactValues;
use super::error::TheoryError;
use super::mixture::MaxwellianMixture;

/// Collisions per particle after which the scaled velocity distribution of a cooling gas is
/// stationary.
const SETTLED: f64 = 40.0;
/// Collisions per particle at the end of the interval from which the rates are fitted.
const END: f64 = 100.0;

/// Factors by which collision and cooling rates of the homogeneous cooling state differ from those
/// of Maxwellian velocities at equal temperature, under molecular chaos. They do not depend on
/// density.
///
/// To first order in the fourth cumulant a2 they are `1 - a2/16` for collisions, `1 + a2/4` for the
/// squared relative speed of colliding pairs, `1 + 3 a2/16` for the cooling rate, and `1 - 3 a2/16`
/// for the cooling rate at a given squared speed of pairs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CoolingFactors {
    /// Collision rate of the cooling state over that of Maxwellian velocities.
    pub collision_rate: f64,
    /// Mean squared relative speed of colliding pairs in the cooling state, over that of Maxwellian
    /// velocities.
    pub pair_speed: f64,
}

impl CoolingFactors {
    /// Computes the factors for equal particles of constant restitution in two or three dimensions,
    /// from a Sonine expansion of `orders` ([`MaxwellianMixture::expand`]) between 40 and 100
    /// collisions of each particle. For elastic particles they are 1.
    ///
    /// # Errors
    /// [`TheoryError`] if the dimension, the restitution or the order is out of range, or the
    /// expansion does not converge.
    pub fn for_restitution(
        dimension: usize,
        restitution: f64,
        orders: usize,
    ) -> Result<Self, TheoryError> {
        let law = Constant::new(restitution)?;
        let particle = Component {
            mass: 1.0,
            diameter: 1.0,
            density: 1.0,
        };
        let gas = MaxwellianMixture::new(dimension, vec![particle], law, ContactValues::Dilute)?;
        let cooling = gas.rates(0, &[1.0]).cooling;
        if cooling == 0.0 {
            return Ok(Self {
                collision_rate: 1.0,
                pair_speed: 1.0,
            });
        }
        let share = (1.0 - restitution * restitution) / dimension as f64;
        // Haff's law, whose temperature falls by the factor exp(-share) in each collision.
        let times = [SETTLED, END].map(|count| 2.0 / cooling * (0.5 * share * count).exp_m1());
        let found = gas.expand(orders, &[1.0], &times)?;
        let [before, after] = [&found[0], &found[1]]
            .map(|moment| [moment.time, moment.temperatures[0], moment.collisions[0]]);
        Ok(Self::fitted_between(before, after, share, cooling))
    }

    /// Computes the factors from time, temperature and collisions per particle of a cooling gas at
    /// two times. For Maxwellian velocities, ln T falls by `share` with each collision, and
    /// 1/sqrt(T) grows by `cooling/2` per time.
    fn fitted_between(before: [f64; 3], after: [f64; 3], share: f64, cooling: f64) -> Self {
        let [time, temperature, collisions] = after;
        let fall = (before[1] / temperature).ln();
        let growth = temperature.powf(-0.5) - before[1].powf(-0.5);
        let pair_speed = fall / (share * (collisions - before[2]));
        let cooling_rate = 2.0 * growth / (cooling * (time - before[0]));
        Self {
            collision_rate: cooling_rate / pair_speed,
            pair_speed,
        }
    }

    /// Computes the cooling rate over that of Maxwellian velocities: the product of
    /// `collision_rate` and `pair_speed`.
    pub fn cooling_rate(&self) -> f64 {
        self.collision_rate * self.pair_speed
    }

    /// Computes the cooling rate over that of Maxwellian velocities with equal squared relative
    /// speed of colliding pairs. Energy is lost as the power 3/2 of that square.
    pub fn at_pair_speed(&self) -> f64 {
        self.collision_rate / self.pair_speed.sqrt()
    }
}
