//! Contact values of the pair correlation in mixtures of disks or spheres, from equations of state.

use std::f64::consts::PI;

use stosszahl_model::{InvalidValue, equation_of_state};

use super::component::Component;
use super::error::TheoryError;

/// Contact values χ to use: how density changes collision rates.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ContactValues {
    /// Dilute gas: all contact values are one.
    Dilute,
    /// Enskog gas: contact values of Santos, Yuste & López de Haro (1999) in the plane, Boublík
    /// (1970) and Mansoori et al. (1971) in space.
    Enskog,
}

/// Computes the contact values of all pairs of species, row by row.
///
/// # Errors
/// [`TheoryError::Invalid`] if the packing fraction is too high.
pub fn values(
    dimension: usize,
    components: &[Component],
    contact: ContactValues,
) -> Result<Vec<f64>, TheoryError> {
    let count = components.len();
    if contact == ContactValues::Dilute {
        return Ok(vec![1.0; count * count]);
    }
    let moment = |power: i32| -> f64 {
        components
            .iter()
            .map(|component| component.density * component.diameter.powi(power))
            .sum()
    };
    let packing = PI / if dimension == 2 { 4.0 } else { 6.0 } * moment(dimension as i32);
    let equal = equation_of_state::contact_value(packing);
    let fits = packing < 1.0 && (dimension == 3 || equal.is_finite());
    InvalidValue::require(fits, "packing fraction", packing, "below close packing")?;
    let pair = |a: f64, b: f64| {
        if dimension == 2 {
            let ratio = if packing > 0.0 {
                moment(1) / moment(2)
            } else {
                0.0
            };
            equation_of_state::mixture_contact_value(equal, packing, [a, b], ratio)
        } else {
            let (free, length) = (1.0 - packing, a * b / (a + b));
            let x = PI / 6.0 * moment(2) * length;
            1.0 / free + 3.0 * x / (free * free) + 2.0 * x * x / (free * free * free)
        }
    };
    let diameters = || components.iter().map(|component| component.diameter);
    Ok(diameters()
        .flat_map(|a| diameters().map(move |b| (a, b)))
        .map(|(a, b)| pair(a, b))
        .collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Equal sizes split into two species are one: Henderson-type value in the plane, Carnahan &
    /// Starling's `(1 - phi/2)/(1 - phi)^3` in space, which follow from the formulas by algebra.
    /// Tolerance: roundings.
    #[test]
    fn mixtures_of_equals_have_the_value_of_equals() {
        let half = |density| Component {
            mass: 1.0,
            diameter: 1.0,
            density,
        };
        let phi = 0.3;
        let space = values(
            3,
            &[half(0.5 * phi * 6.0 / PI), half(0.5 * phi * 6.0 / PI)],
            ContactValues::Enskog,
        )
        .expect("room");
        for value in space {
            assert!((value / ((1.0 - phi / 2.0) / (1.0_f64 - phi).powi(3)) - 1.0).abs() < 1e-14);
        }
        let plane = values(
            2,
            &[half(0.5 * phi * 4.0 / PI), half(0.5 * phi * 4.0 / PI)],
            ContactValues::Enskog,
        )
        .expect("room");
        for value in plane {
            assert!((value / equation_of_state::contact_value(phi) - 1.0).abs() < 1e-14);
        }
        assert!(values(3, &[half(2.5)], ContactValues::Enskog).is_err());
        assert_eq!(
            values(2, &[half(99.0)], ContactValues::Dilute).expect("no density"),
            [1.0]
        );
    }
}
