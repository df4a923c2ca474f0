//! What the kinetic equations say of a gas without positions, group by group.

use std::ops::Range;

use stosszahl_analysis::theory::{CoolingState, Mixture, Moment, TheoryError};
use stosszahl_model::Law;
use stosszahl_model::kinetic;

use crate::plan::Plan;

/// Theory at the sample times of a plan, solved once.
///
/// # Errors
/// [`TheoryError`] if it cannot be followed in the first Sonine order.
pub fn curves(plan: &Plan) -> Result<&Curves, TheoryError> {
    let solved = plan.theory.get_or_init(|| Theory::of(plan)?.curves());
    solved.as_ref().map_err(|error| *error)
}

/// Which group a species of the engine belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Grouping {
    /// Each species is a group.
    Species,
    /// All particles are one group, as where they stick.
    One,
    /// Each particle is a species, in the order of sizes; groups hold equal shares of them.
    Shares {
        /// Number of groups.
        groups: usize,
        /// Number of particles.
        particles: usize,
    },
}

impl Grouping {
    /// That of a plan.
    pub fn of(plan: &Plan) -> Self {
        if plan.case.continuous.is_some() {
            Self::Shares {
                groups: plan.species.len(),
                particles: plan.count().max(1),
            }
        } else if plan.case.sticking.is_some() {
            Self::One
        } else {
            Self::Species
        }
    }

    /// The group of a species.
    #[inline]
    pub fn group(self, species: u32) -> usize {
        match self {
            Self::Species => species as usize,
            Self::One => 0,
            Self::Shares { groups, particles } => species as usize * groups / particles,
        }
    }
}

/// Fourth cumulants of theory, where there is one for it: equal particles of constant restitution that do not stick.
/// First Sonine order by van Noije & Ernst, and in the form of Montanero & Santos.
pub fn fourth_cumulants(plan: &Plan) -> Option<[f64; 2]> {
    let restitution = plan.law.constant().filter(|&r| r < 1.0)?;
    let alone = plan.species.len() == 1 && plan.case.sticking.is_none();
    alone.then(|| {
        [
            kinetic::fourth_cumulant(plan.dimension, restitution),
            kinetic::fourth_cumulant_of_montanero_santos(plan.dimension, restitution),
        ]
    })
}

/// The kinetic equations of a plan.
pub struct Theory<'a> {
    plan: &'a Plan,
    mixture: Mixture<Law>,
    /// Temperatures of the classes at the start.
    start: Vec<f64>,
}

impl<'a> Theory<'a> {
    /// The kinetic equations of the classes of a plan.
    ///
    /// # Errors
    /// [`TheoryError`] if a number is out of range, or the gas is packed too densely for its contact values.
    pub fn of(plan: &'a Plan) -> Result<Self, TheoryError> {
        Ok(Self {
            plan,
            mixture: plan.mixture()?,
            start: plan.temperatures(),
        })
    }

    /// The classes of a group.
    fn classes_of(&self, group: usize) -> Range<usize> {
        let each = self.plan.classes.len() / self.plan.species.len().max(1);
        group * each..(group + 1) * each
    }

    /// Weighted mean over the classes of a group; the value of the only one, bit by bit.
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

    /// The cooling state that the gas starts in, if it does: cooling rates of all classes within a hundredth of each other.
    pub fn cooling_state(&self) -> Option<CoolingState> {
        let rate = |k| self.mixture.rates(k, &self.start).cooling;
        let (least, most) = (0..self.start.len())
            .map(rate)
            .fold((f64::INFINITY, 0.0_f64), |(least, most), rate| {
                (least.min(rate), most.max(rate))
            });
        let together = least > 0.0 && most < 1.01 * least;
        (self.mixture.is_constant() && together)
            .then(|| CoolingState::from_temperatures(&self.mixture, self.start.clone()))
    }

    /// Theory at the sample times: velocities in a Sonine expansion. Orders in which it cannot be followed to the end are
    /// left out.
    fn curves(&self) -> Result<Curves, TheoryError> {
        let plan = self.plan;
        if plan.case.sticking.is_some() {
            return Ok(Curves {
                orders: 1,
                at: Vec::new(),
            });
        }
        let samples = plan.sample_times();
        let times: Vec<f64> = samples.iter().map(|&time| plan.engine_time(time)).collect();
        let solve = |orders| self.mixture.solve(orders, &self.start, &times);
        let asked = plan.case.verdict.sonine_orders;
        let mut orders = asked.map_or_else(
            || self.mixture.affordable_orders(),
            |orders| orders.max(1) as usize,
        );
        let (found, below) = loop {
            let lower = || (orders > 1).then(|| solve(orders - 1));
            match rayon::join(|| solve(orders), lower) {
                (Ok(found), below) => break (found, below.and_then(Result::ok)),
                (Err(error), _) if orders == 1 => return Err(error),
                _ => orders -= 1,
            }
        };
        let at = found.iter().enumerate().map(|(index, moment)| {
            let value = self.curve(moment);
            match below.as_ref().and_then(|below| below.get(index)) {
                Some(below) => value.against(&self.curve(below), |value, below| Predicted {
                    value,
                    error: Some((value - below).abs()),
                }),
                None => value.against(&value, |value, _| Predicted { value, error: None }),
            }
        });
        Ok(Curves {
            orders,
            at: at.collect(),
        })
    }

    /// Collisions of a particle up to a time \[time\], in the first order.
    ///
    /// # Errors
    /// [`TheoryError`] if theory cannot be followed up to there.
    pub fn collisions(&self, until: f64) -> Result<f64, TheoryError> {
        let found = self.mixture.evolve(&self.start, &[until])?;
        let all = found.iter();
        Ok(all.map(|moment| self.curve(moment).collisions).sum())
    }

    /// What a moment says of the groups.
    fn curve(&self, moment: &Moment) -> Curve<f64> {
        let (classes, start) = (&self.plan.classes, &self.start);
        let mean = |values: &dyn Fn(usize) -> f64| -> f64 {
            let total: f64 = classes.iter().map(|class| class.density).sum();
            let sum: f64 = classes
                .iter()
                .enumerate()
                .map(|(k, class)| class.density * values(k))
                .sum();
            sum / total
        };
        let of_group = |group: usize| {
            let count = |k: usize| classes[k].count as f64;
            let square = |k: usize| count(k) * start[k] / classes[k].mass;
            GroupCurve {
                temperature: self.over_classes(group, count, |k| moment.temperatures[k]),
                fourth_cumulant: self.over_classes(group, count, |k| moment.fourth_cumulants[k]),
                displacement: self.over_classes(group, count, |k| moment.displacements[k]),
                correlation: self.over_classes(group, square, |k| moment.kept[k]),
            }
        };
        Curve {
            energy_ratio: mean(&|k| moment.temperatures[k]) / mean(&|k| start[k]),
            collisions: mean(&|k| moment.collisions[k]),
            displacement: mean(&|k| moment.displacements[k]),
            groups: (0..self.plan.species.len()).map(of_group).collect(),
        }
    }

    /// Displacements averaged over time by group and lag up to a time \[time\], in so many Sonine orders; in the first only
    /// for a gas that starts in its cooling state.
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
        let count = |k: usize| self.plan.classes[k].count as f64;
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
        Some((0..self.plan.species.len()).map(of_group).collect())
    }
}

/// A value of theory, and how far it is from that of one Sonine order less; the first has none.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Predicted {
    /// Value.
    pub value: f64,
    /// Error.
    pub error: Option<f64>,
}

/// Theory of one group at one time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GroupCurve<T = Predicted> {
    /// Temperature \[energy\].
    pub temperature: T,
    /// Fourth cumulant of the velocities.
    pub fourth_cumulant: T,
    /// Mean squared displacement \[length^2\].
    pub displacement: T,
    /// `<v(0) . v(t)>/<v(0)^2>`.
    pub correlation: T,
}

/// Theory at one time.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve<T = Predicted> {
    /// Energy over that of the start.
    pub energy_ratio: T,
    /// Collisions of a particle, on average over those that collide with each other.
    pub collisions: T,
    /// Mean squared displacement, on average over the same \[length^2\].
    pub displacement: T,
    /// Each group.
    pub groups: Vec<GroupCurve<T>>,
}

/// What theory says at all sample times.
#[derive(Clone, Debug, PartialEq)]
pub struct Curves {
    /// Sonine orders of the velocities.
    pub orders: usize,
    /// By sample time; none for a gas that sticks.
    pub at: Vec<Curve>,
}

impl Curve<f64> {
    /// Each value with its like in another curve.
    fn against<T>(&self, other: &Self, with: impl Fn(f64, f64) -> T) -> Curve<T> {
        let groups = self.groups.iter().zip(&other.groups);
        Curve {
            energy_ratio: with(self.energy_ratio, other.energy_ratio),
            collisions: with(self.collisions, other.collisions),
            displacement: with(self.displacement, other.displacement),
            groups: groups
                .map(|(a, b)| GroupCurve {
                    temperature: with(a.temperature, b.temperature),
                    fourth_cumulant: with(a.fourth_cumulant, b.fourth_cumulant),
                    displacement: with(a.displacement, b.displacement),
                    correlation: with(a.correlation, b.correlation),
                })
                .collect(),
        }
    }
}
