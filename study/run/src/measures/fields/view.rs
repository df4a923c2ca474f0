//! Fields of one engine in one window of time, in the units of the case.

use stosszahl_analysis::fields::{CellAveraging, FieldSums as Sums, ParticleAverages, Values};
use stosszahl_results::TableEstimate;

use crate::measures::course::{self, BlockRange};
use crate::plan::CasePlan;

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
pub(super) fn units(plan: &CasePlan) -> [f64; QUANTITIES] {
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
pub(super) type Quantities = [TableEstimate; QUANTITIES];

/// Averages of one engine over its replicas and a window.
pub(super) struct View<'a> {
    averages: ParticleAverages<'a>,
    units: [f64; QUANTITIES],
}

impl<'a> View<'a> {
    /// Averages of the sums of all replicas. `free_shares` are those of [`CasePlan::free_shares`].
    pub(super) fn new(
        plan: &CasePlan,
        sums: &'a [&'a Sums],
        free_shares: &'a [f64],
        window: &BlockRange,
    ) -> Self {
        Self {
            averages: ParticleAverages {
                replicas: sums,
                blocks: window.blocks.clone(),
                freedom: course::freedom(plan),
                free_shares,
            },
            units: units(plan),
        }
    }

    /// Quantities at each place, of all species or of one.
    pub(super) fn fields(&self, species: Option<usize>, along: CellAveraging) -> Vec<Quantities> {
        let found = self.averages.fields(species, along);
        let quantity = |values: &Values, index: usize| values.list()[PLACES[index]];
        let estimate = |place: usize, index: usize| {
            let place = &found.places[place];
            let error = quantity(&place.errors, index);
            let value = quantity(&place.values, index);
            TableEstimate {
                replicas: Some(found.parts[PLACES[index]]),
                ..TableEstimate::with_error(value, Some(error).filter(|error| error.is_finite()))
            }
            .times(self.units[index])
        };
        (0..found.places.len())
            .map(|place| std::array::from_fn(|index| estimate(place, index)))
            .collect()
    }

    /// Mean of a quantity over cells, weighted with their density.
    pub(super) fn mean(&self, cells: &[usize], quantity: usize) -> TableEstimate {
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
    ) -> [TableEstimate; N] {
        let (numbers, errors) = self.averages.derived(cells, of);
        std::array::from_fn(|index| {
            let error = errors.standard_errors[0][index];
            TableEstimate {
                replicas: Some(errors.parts[index]),
                ..TableEstimate::with_error(
                    numbers[index],
                    Some(error).filter(|error| error.is_finite()),
                )
            }
        })
    }
}
