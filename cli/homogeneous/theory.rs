//! What kinetic theory says at the times of a case.

use stosszahl_analysis::theory::TheoryError;

use super::plan::Plan;

/// Theory of one group at one time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct GroupCurve {
    /// Temperature.
    pub temperature: f64,
    /// Mean squared displacement.
    pub displacement: f64,
    /// `<v(0) . v(t)>/<v(0)^2>`.
    pub correlation: f64,
}

/// Theory at one time.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Curve {
    /// Energy over that of the start.
    pub energy_ratio: f64,
    /// Collisions of a particle, on average over those that collide with each other.
    pub collisions: f64,
    /// Mean squared displacement, on average over the same.
    pub displacement: f64,
    /// Each group.
    pub groups: Vec<GroupCurve>,
}

/// Theory at the sample times; empty for a gas that sticks.
///
/// The kinetic equations of Maxwellian species. Equal particles of constant restitution follow Haff's law with the fourth
/// cumulant of the cooling state (Montanero & Santos): its correction of the cooling rate, `1 + 3 a2/16`, and of the
/// collision rate, `1 - a2/16`.
pub(super) fn curves(plan: &Plan) -> Result<Vec<Curve>, TheoryError> {
    if plan.case.sticking.is_some() {
        return Ok(Vec::new());
    }
    let times: Vec<f64> = plan
        .case
        .sample_times()
        .iter()
        .map(|time| time * plan.time)
        .collect();
    let mixture = plan.mixture()?;
    let start = plan.temperatures();
    let classes = plan.classes();
    let particles: Vec<f64> = classes.iter().map(|class| class.density).collect();
    let mean = |values: &dyn Fn(usize) -> f64| -> f64 {
        let total: f64 = particles.iter().sum();
        let sum: f64 = particles
            .iter()
            .enumerate()
            .map(|(k, density)| density * values(k))
            .sum();
        sum / total
    };
    let found = mixture.evolve(&start, &times)?;
    let curves = found.iter().map(|moment| {
        let mut curve = Curve {
            energy_ratio: mean(&|k| moment.temperatures[k]) / mean(&|k| start[k]),
            collisions: mean(&|k| moment.collisions[k]),
            displacement: mean(&|k| moment.displacements[k]),
            groups: (0..plan.groups.len())
                .map(|group| {
                    let count = |k: usize| classes[k].count as f64;
                    let square = |k: usize| count(k) * start[k] / classes[k].mass;
                    GroupCurve {
                        temperature: plan.over_classes(group, count, |k| moment.temperatures[k]),
                        displacement: plan.over_classes(group, count, |k| moment.displacements[k]),
                        correlation: plan
                            .over_classes(group, square, |k| (-moment.decays[k]).exp()),
                    }
                })
                .collect(),
        };
        if let (Some([_, a2]), [group]) = (plan.fourth_cumulants(), &mut curve.groups[..]) {
            let rate = (1.0 + 3.0 * a2 / 16.0) / plan.haff_time;
            let slowing = 1.0 + rate * moment.time;
            curve.energy_ratio = slowing.powi(-2);
            group.temperature = start[0] * curve.energy_ratio;
            curve.collisions = (1.0 - a2 / 16.0) / plan.mean_free_time / rate * slowing.ln();
        }
        curve
    });
    Ok(curves.collect())
}

/// Displacements averaged over time by group and lag, for a gas that starts in its cooling state.
pub(super) fn time_averaged(plan: &Plan) -> Option<Vec<Vec<f64>>> {
    let lags = plan.lags();
    if lags.is_empty() {
        return None;
    }
    let state = plan.cooling_state()?;
    let total = plan.case.run.until * plan.time;
    let count = |k: usize| plan.classes()[k].count as f64;
    let of_group = |group: usize| {
        lags.iter()
            .map(|lag| {
                plan.over_classes(group, count, |k| {
                    state.time_averaged(k, lag * plan.time, total)
                })
            })
            .collect()
    };
    Some((0..plan.groups.len()).map(of_group).collect())
}
