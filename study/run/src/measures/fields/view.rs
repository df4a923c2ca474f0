//! Fields of one engine in one window of time, in the units of the case.

use stosszahl_analysis::fields::{Along, Averages, Fields as Sums, Values};
use stosszahl_results::Estimate;

use crate::measures::course::{self, Window};
use crate::plan::Plan;

/// Number of the quantities of the tables.
pub(super) const QUANTITIES: usize = 7;
/// Index of the number density among the quantities.
pub(super) const DENSITY: usize = 0;
/// Index of the velocity along the first axis.
pub(super) const SPEED: usize = 1;
/// Index of the granular temperature.
pub(super) const TEMPERATURE: usize = 3;

/// Places of the quantities in [`Values::list`].
const PLACES: [usize; QUANTITIES] = [0, 1, 2, 4, 5, 6, 7];

/// Units of the quantities, in their order.
pub(super) fn units(plan: &Plan) -> [f64; QUANTITIES] {
    let (scale, speed, energy) = (plan.scale, plan.scale.speed(), plan.scale.energy);
    let volume = scale.length.powi(plan.dimension as i32);
    let density = 1.0 / volume;
    [
        density,
        speed,
        speed,
        energy,
        energy,
        energy / volume,
        plan.time,
    ]
}

/// Quantities of a place, in the units of the case. Their number of replicas is that of the independent parts behind their errors.
pub(super) type Quantities = [Estimate; QUANTITIES];

/// Averages of one engine over its replicas and a window.
pub(super) struct View<'a> {
    averages: Averages<'a>,
    units: [f64; QUANTITIES],
}

impl<'a> View<'a> {
    /// Averages of the sums of all replicas. `free_shares` are those of [`Plan::free_shares`].
    pub(super) fn new(
        plan: &Plan,
        sums: &'a [&'a Sums],
        free_shares: &'a [f64],
        window: &Window,
    ) -> Self {
        Self {
            averages: Averages {
                replicas: sums,
                blocks: window.blocks.clone(),
                freedom: course::freedom(plan),
                free_shares,
            },
            units: units(plan),
        }
    }

    /// Quantities at each place, of all species or of one.
    pub(super) fn fields(&self, species: Option<usize>, along: Along) -> Vec<Quantities> {
        let found = self.averages.fields(species, along);
        let quantity = |values: &Values, index: usize| values.list()[PLACES[index]];
        let estimate = |place: usize, index: usize| {
            let place = &found.places[place];
            let error = quantity(&place.errors, index);
            let value = quantity(&place.values, index);
            Estimate {
                replicas: Some(found.parts[PLACES[index]]),
                ..Estimate::of(value, Some(error).filter(|error| error.is_finite()))
            }
            .times(self.units[index])
        };
        (0..found.places.len())
            .map(|place| std::array::from_fn(|index| estimate(place, index)))
            .collect()
    }

    /// Mean of a quantity over cells, weighted with their density.
    pub(super) fn mean(&self, cells: &[usize], quantity: usize) -> Estimate {
        let mean = |values: &[Values]| {
            let (mut number, mut sum) = (0.0, 0.0);
            for values in values {
                let list = values.list();
                number += list[0];
                sum += list[0] * list[PLACES[quantity]];
            }
            [sum / number]
        };
        let [mean] = self.derived(cells, mean);
        mean.times(self.units[quantity])
    }

    /// Numbers that follow from the fields of some cells, in engine units.
    pub(super) fn derived<const N: usize>(
        &self,
        cells: &[usize],
        of: impl Fn(&[Values]) -> [f64; N],
    ) -> [Estimate; N] {
        let (numbers, errors) = self.averages.derived(cells, of);
        std::array::from_fn(|index| {
            let error = errors.standard_errors[0][index];
            Estimate {
                replicas: Some(errors.parts[index]),
                ..Estimate::of(
                    numbers[index],
                    Some(error).filter(|error| error.is_finite()),
                )
            }
        })
    }
}
