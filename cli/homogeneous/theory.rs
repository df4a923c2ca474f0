//! What kinetic theory says at the times of a case.

use stosszahl_analysis::theory::{Moment, TheoryError};

use super::plan::Plan;

/// A value of theory, and how far it is from that of one Sonine order less; the first has none.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Predicted {
    /// Value.
    pub value: f64,
    /// Error.
    pub error: Option<f64>,
}

/// Theory of one group at one time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct GroupCurve<T = Predicted> {
    /// Temperature.
    pub temperature: T,
    /// Fourth cumulant of the velocities.
    pub fourth_cumulant: T,
    /// Mean squared displacement.
    pub displacement: T,
    /// `<v(0) . v(t)>/<v(0)^2>`.
    pub correlation: T,
}

/// Theory at one time.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Curve<T = Predicted> {
    /// Energy over that of the start.
    pub energy_ratio: T,
    /// Collisions of a particle, on average over those that collide with each other.
    pub collisions: T,
    /// Mean squared displacement, on average over the same.
    pub displacement: T,
    /// Each group.
    pub groups: Vec<GroupCurve<T>>,
}

/// What theory says at all sample times.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Curves {
    /// Sonine orders of the velocities.
    pub orders: usize,
    /// By sample time; none for a gas that sticks.
    pub at: Vec<Curve>,
}

/// Theory at the sample times: the kinetic equations with velocities in a Sonine expansion. Orders in which it
/// cannot be followed to the end are left out.
pub(super) fn curves(plan: &Plan) -> Result<Curves, TheoryError> {
    if plan.case.sticking.is_some() {
        return Ok(Curves {
            orders: 1,
            at: Vec::new(),
        });
    }
    let times: Vec<f64> = plan
        .case
        .sample_times()
        .iter()
        .map(|time| time * plan.time)
        .collect();
    let mixture = plan.mixture()?;
    let start = plan.temperatures();
    let solve = |orders| mixture.solve(orders, &start, &times);
    let mut orders = plan
        .case
        .sonine_orders
        .unwrap_or_else(|| mixture.affordable_orders());
    let (found, below) = loop {
        let lower = || (orders > 1).then(|| solve(orders - 1));
        match rayon::join(|| solve(orders), lower) {
            (Ok(found), below) => break (found, below.and_then(Result::ok)),
            (Err(error), _) if orders == 1 => return Err(error),
            _ => orders -= 1,
        }
    };
    let at = found.iter().enumerate().map(|(index, moment)| {
        let value = curve(plan, &start, moment);
        match below.as_ref().and_then(|below| below.get(index)) {
            Some(below) => value.against(&curve(plan, &start, below), |value, below| Predicted {
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

/// Collisions of a particle up to the end of the run, in the first order.
pub(super) fn collisions(plan: &Plan) -> Result<f64, TheoryError> {
    let (start, end) = (plan.temperatures(), plan.case.run.until * plan.time);
    let found = plan.mixture()?.evolve(&start, &[end])?;
    Ok(found
        .iter()
        .map(|moment| curve(plan, &start, moment).collisions)
        .sum())
}

/// What a moment says of the groups.
fn curve(plan: &Plan, start: &[f64], moment: &Moment) -> Curve<f64> {
    let classes = plan.classes();
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
            temperature: plan.over_classes(group, count, |k| moment.temperatures[k]),
            fourth_cumulant: plan.over_classes(group, count, |k| moment.fourth_cumulants[k]),
            displacement: plan.over_classes(group, count, |k| moment.displacements[k]),
            correlation: plan.over_classes(group, square, |k| moment.kept[k]),
        }
    };
    Curve {
        energy_ratio: mean(&|k| moment.temperatures[k]) / mean(&|k| start[k]),
        collisions: mean(&|k| moment.collisions[k]),
        displacement: mean(&|k| moment.displacements[k]),
        groups: (0..plan.groups.len()).map(of_group).collect(),
    }
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

/// Displacements averaged over time by group and lag, in so many Sonine orders; in the first only for a gas that starts in
/// its cooling state.
pub(super) fn time_averaged(plan: &Plan, orders: usize) -> Option<Vec<Vec<Predicted>>> {
    let lags: Vec<f64> = plan.lags().iter().map(|lag| lag * plan.time).collect();
    if lags.is_empty() {
        return None;
    }
    let total = plan.case.run.until * plan.time;
    let start = plan.temperatures();
    let by_class = |orders: usize| -> Option<Vec<Vec<f64>>> {
        if orders > 1 {
            let mixture = plan.mixture().ok()?;
            return mixture.time_averaged(orders, &start, &lags, total).ok();
        }
        let state = plan.cooling_state()?;
        let each = |k: usize| {
            let of_lag = |&lag: &f64| state.time_averaged(k, lag, total);
            lags.iter().map(of_lag).collect()
        };
        Some((0..start.len()).map(each).collect())
    };
    let (found, below) = rayon::join(
        || by_class(orders),
        || (orders > 1).then(|| by_class(orders - 1)).flatten(),
    );
    let found = found?;
    let count = |k: usize| plan.classes()[k].count as f64;
    let of_group = |group: usize| {
        (0..lags.len())
            .map(|index| {
                let mean =
                    |values: &[Vec<f64>]| plan.over_classes(group, count, |k| values[k][index]);
                let value = mean(&found);
                let error = below.as_deref().map(|below| (value - mean(below)).abs());
                Predicted { value, error }
            })
            .collect()
    };
    Some((0..plan.groups.len()).map(of_group).collect())
}
