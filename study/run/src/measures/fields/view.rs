//! Fields of one engine, averaged over replicas and a time window, in the units of the case.

use stosszahl_analysis::fields::{CellAveraging, FieldSums as Sums, ParticleAverages, Values};
use stosszahl_results::TableEstimate;

use crate::measures::{gas_series, time_blocks::TimeBlocks};
use crate::plan::CasePlan;

/// Number of field quantities in the tables of fields.
pub(super) const QUANTITIES: usize = 7;
/// Index of the number density among the field quantities.
pub(super) const DENSITY: usize = 0;
/// Index of the velocity along the first axis among the field quantities.
pub(super) const SPEED: usize = 1;
/// Index of the granular temperature among the field quantities.
pub(super) const TEMPERATURE: usize = 3;

/// Index of each field quantity in [`Values::list`].
const PLACES: [usize; QUANTITIES] = [0, 1, 2, 4, 5, 6, 7];

/// Returns the size of the engine unit of each field quantity, in units of the case.
pub(super) fn units(plan: &CasePlan) -> [f64; QUANTITIES] {
    let (scale, speed, energy) = (plan.scale, plan.scale.speed(), plan.scale.energy);
    let volume = scale.length.powi(plan.gas.dimension as i32);
    let density = 1.0 / volume;
    [
        density,
        speed,
        speed,
        energy,
        energy,
        energy / volume,
        plan.clock.time,
    ]
}

/// Field quantities of one cell or profile position, in the units of the case. `replicas` of each
/// is the number of independent parts of the runs behind its standard error.
pub(super) type Quantities = [TableEstimate; QUANTITIES];

/// Fields of one engine, averaged over its replicas and a time window.
pub(super) struct View<'a> {
    averages: ParticleAverages<'a>,
    units: [f64; QUANTITIES],
}

impl<'a> View<'a> {
    /// Creates the averages of an engine from the sums of all replicas. `free_shares` is
    /// [`CasePlan::free_shares`]: the free share of each cell.
    pub(super) fn new(
        plan: &CasePlan,
        sums: &'a [&'a Sums],
        free_shares: &'a [f64],
        window: &TimeBlocks,
    ) -> Self {
        Self {
            averages: ParticleAverages {
                replicas: sums,
                blocks: window.blocks.clone(),
                freedom: gas_series::freedom(plan),
                free_shares,
            },
            units: units(plan),
        }
    }

    /// Computes the field quantities of each cell or profile position, of all species together or
    /// of one.
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

    /// Computes the mean of a field quantity over cells, weighted with their density.
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

    /// Estimates numbers that the function `of` computes from the fields of some cells, in engine
    /// units, with errors.
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
