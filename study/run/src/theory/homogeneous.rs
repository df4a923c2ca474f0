//! Kinetic theory of a gas without positions, by equations for its size groups in Sonine
//! expansions. Each species of the plan has one or more size groups.

use std::ops::Range;

use stosszahl_case::format::VelocitiesSpec;
use stosszahl_model::{InvalidValue, Law};
use stosszahl_theory::{CoolingState, MaxwellianMixture, Moment, TheoryError, cooling};

use crate::plan::{CasePlan, GroupCurve, Predicted, TheoryCurves, TheoryPoint};

/// Returns the theory of a case at its sample times, solved once.
///
/// # Errors
/// [`TheoryError`] if it cannot be followed in the first Sonine order.
pub fn curves(plan: &CasePlan) -> Result<&TheoryCurves, TheoryError> {
    let solved = plan
        .theory
        .curves
        .get_or_init(|| Theory::from_plan(plan)?.curves());
    solved.as_ref().map_err(|error| *error)
}

/// Computes theoretical fourth cumulants of equal particles with constant restitution that do not
/// stick: in first Sonine order by van Noije & Ernst, and in the form of Montanero & Santos. `None`
/// for other gases.
pub fn fourth_cumulants(plan: &CasePlan) -> Option<[f64; 2]> {
    let restitution = plan.gas.law.constant().filter(|&r| r < 1.0)?;
    let alone = plan.gas.species.len() == 1 && plan.case.aggregation.is_none();
    alone.then(|| {
        [
            cooling::fourth_cumulant(plan.gas.dimension, restitution),
            cooling::fourth_cumulant_of_montanero_santos(plan.gas.dimension, restitution),
        ]
    })
}

/// Kinetic equations of the size groups of a case.
pub struct Theory<'a> {
    plan: &'a CasePlan,
    mixture: MaxwellianMixture<Law>,
    /// Initial temperature of each size group \[energy\].
    start: Vec<f64>,
}

impl<'a> Theory<'a> {
    /// Creates the kinetic equations of the size groups of a case.
    ///
    /// # Errors
    /// [`TheoryError`] if a number is out of range, or the gas is packed too densely for its
    /// contact values.
    pub fn from_plan(plan: &'a CasePlan) -> Result<Self, TheoryError> {
        if let VelocitiesSpec::Drawn(drawn) = plan.case.start.velocities {
            let allowed = "Maxwellian velocities at the start";
            return Err(InvalidValue::new("a2 of the start", drawn.a2, allowed).into());
        }
        Ok(Self {
            plan,
            mixture: plan.mixture()?,
            start: plan.temperatures(),
        })
    }

    /// Returns the index range of the size groups of a species.
    fn classes_of(&self, group: usize) -> Range<usize> {
        let each = self.plan.gas.classes.len() / self.plan.gas.species.len().max(1);
        group * each..(group + 1) * each
    }

    /// Computes the weighted mean over the size groups of a species; for a single group exactly its
    /// value.
    fn over_classes(
        &self,
        group: usize,
        weight: impl Fn(usize) -> f64,
        value: impl Fn(usize) -> f64,
    ) -> f64 {
        let classes = self.classes_of(group);
        if classes.len() == 1 {
            return value(classes.start);
        }
        let total: f64 = classes.clone().map(&weight).sum();
        classes.map(|k| weight(k) * value(k)).sum::<f64>() / total
    }

    /// Returns the homogeneous cooling state if the gas starts in it: cooling rates of all size
    /// groups within 1 % of each other.
    pub fn cooling_state(&self) -> Option<CoolingState> {
        let rate = |k| self.mixture.rates(k, &self.start).cooling;
        let rates = || (0..self.start.len()).map(rate);
        let (least, most) = (
            rates().fold(f64::INFINITY, f64::min),
            rates().fold(0.0, f64::max),
        );
        let together = least > 0.0 && most < 1.01 * least;
        (self.mixture.is_constant() && together)
            .then(|| CoolingState::from_temperatures(&self.mixture, self.start.clone()))
    }

    /// Solves the theory at the sample times, with velocities in a Sonine expansion. Orders that
    /// cannot be integrated to the end are left out.
    fn curves(&self) -> Result<TheoryCurves, TheoryError> {
        let plan = self.plan;
        if plan.case.aggregation.is_some() {
            return Ok(TheoryCurves {
                orders: 1,
                at: Vec::new(),
            });
        }
        let samples = plan.sample_times();
        let times: Vec<f64> = samples.iter().map(|&time| plan.engine_time(time)).collect();
        let solve = |orders| self.mixture.solve(orders, &self.start, &times);
        let asked = plan.case.verdict.sonine_orders;
        let affordable = || self.mixture.affordable_orders();
        let mut orders = asked.map_or_else(affordable, |orders| orders.max(1) as usize);
        let (found, below) = loop {
            let lower = || (orders > 1).then(|| solve(orders - 1));
            match rayon::join(|| solve(orders), lower) {
                (Ok(found), below) => break (found, below.and_then(Result::ok)),
                (Err(error), _) if orders == 1 => return Err(error),
                _ => orders -= 1,
            }
        };
        let below = |index: usize| below.as_ref().and_then(|below| below.get(index));
        let at = found.iter().enumerate();
        Ok(TheoryCurves {
            orders,
            at: at
                .map(|(index, moment)| self.curve(moment, below(index)))
                .collect(),
        })
    }

    /// Computes the number of collisions of a particle up to a time \[time\], in the first Sonine
    /// order.
    ///
    /// # Errors
    /// [`TheoryError`] if theory cannot be followed up to there.
    pub fn collisions(&self, until: f64) -> Result<f64, TheoryError> {
        let found = self.mixture.evolve(&self.start, &[until])?;
        let all = found.iter();
        Ok(all
            .map(|moment| self.curve(moment, None).collisions.value)
            .sum())
    }

    /// Computes the predictions for each species at one time, with their change from one Sonine
    /// order less.
    fn curve(&self, moment: &Moment, below: Option<&Moment>) -> TheoryPoint {
        let (classes, start) = (&self.plan.gas.classes, &self.start);
        let d = self.plan.gas.dimension as f64;
        let predicted = |of: &dyn Fn(&Moment) -> f64| {
            let value = of(moment);
            let error = below.map(|below| (value - of(below)).abs());
            Predicted { value, error }
        };
        let mean = |values: &[f64]| -> f64 {
            let total: f64 = classes.iter().map(|class| class.density).sum();
            let all = classes.iter().zip(values);
            all.map(|(class, value)| class.density * value).sum::<f64>() / total
        };
        let of_group = |group: usize| {
            let count = |k: usize| classes[k].count as f64;
            let square = |k: usize| count(k) * start[k] / classes[k].mass;
            let over = |of: fn(&Moment) -> &[f64]| {
                predicted(&|moment| self.over_classes(group, count, |k| of(moment)[k]))
            };
            GroupCurve {
                temperature: over(|moment| &moment.temperatures),
                fourth_cumulant: over(|moment| &moment.fourth_cumulants),
                displacement: over(|moment| &moment.displacements),
                diffusion: predicted(&|moment| {
                    self.over_classes(group, count, |k| moment.correlations[k] / d)
                }),
                relaxation: predicted(&|moment| {
                    let time = |k: usize| {
                        moment.correlations[k] * classes[k].mass / (d * moment.temperatures[k])
                    };
                    self.over_classes(group, count, time)
                }),
                correlation: predicted(&|m| self.over_classes(group, square, |k| m.kept[k])),
            }
        };
        TheoryPoint {
            energy_ratio: predicted(&|moment| mean(&moment.temperatures) / mean(start)),
            collisions: predicted(&|moment| mean(&moment.collisions)),
            displacement: predicted(&|moment| mean(&moment.displacements)),
            groups: (0..self.plan.gas.species.len()).map(of_group).collect(),
        }
    }

    /// Computes time-averaged displacements by species and lag, up to a time \[time\], in a number
    /// of Sonine orders. The first order needs a gas that starts in its cooling state.
    pub fn time_averaged(
        &self,
        orders: usize,
        lags: &[f64],
        total: f64,
    ) -> Option<Vec<Vec<Predicted>>> {
        if lags.is_empty() {
            return None;
        }
        let by_class = |orders: usize| -> Option<Vec<Vec<f64>>> {
            if orders > 1 {
                let solved = self.mixture.time_averaged(orders, &self.start, lags, total);
                return solved.ok();
            }
            let state = self.cooling_state()?;
            let each = |k: usize| {
                let of_lag = |&lag: &f64| state.time_averaged(k, lag, total);
                lags.iter().map(of_lag).collect()
            };
            Some((0..self.start.len()).map(each).collect())
        };
        let (found, below) = rayon::join(
            || by_class(orders),
            || (orders > 1).then(|| by_class(orders - 1)).flatten(),
        );
        let found = found?;
        let count = |k: usize| self.plan.gas.classes[k].count as f64;
        let of_group = |group: usize| {
            let of_lag = |index: usize| {
                let mean =
                    |values: &[Vec<f64>]| self.over_classes(group, count, |k| values[k][index]);
                let value = mean(&found);
                let error = below.as_deref().map(|below| (value - mean(below)).abs());
                Predicted { value, error }
            };
            (0..lags.len()).map(of_lag).collect()
        };
        Some((0..self.plan.gas.species.len()).map(of_group).collect())
    }
}
