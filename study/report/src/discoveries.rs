//! Confidence intervals of a sweep, corrected for multiple comparisons by the false discovery rate
//! over its points.
//!
//! Each point has a number chosen before the run, with an interval at the level q. Of m points,
//! those are *decided* whose interval lies inside the margin or on one side of zero. The largest k
//! is determined for which at least k points are decided at the level q k/m; all intervals are then
//! taken at that level, or at q/m if there is no such k.
//!
//! This is the step-up procedure of Y. Benjamini & Y. Hochberg, *J. R. Stat. Soc. B* **57**, 289
//! (1995), with the intervals of Y. Benjamini & D. Yekutieli, *J. Am. Stat. Assoc.* **100**, 71
//! (2005): of the decided points a fraction q at most is decided falsely, on average. Bonferroni's
//! correction for m points would leave nothing to find in a large sweep.

use stosszahl_analysis::compare::{ComparisonVerdict as Test, Interval, VerdictRule};
use stosszahl_results::{ComparedNumber, VerdictKind};

/// Confidence intervals of a sweep point: at its own error rate, and corrected for all points.
#[derive(Clone, Debug, PartialEq)]
pub struct Corrected {
    /// Confidence interval at the error rate of the point alone.
    pub own: Option<[f64; 2]>,
    /// Confidence interval at the error rate that is corrected for all points.
    pub corrected: Option<[f64; 2]>,
    /// Verdict from the corrected interval.
    pub kind: VerdictKind,
}

/// Compared number of each sweep point with its intervals; `None` where nothing is compared or the
/// comparison is void.
pub(crate) type Numbers = Vec<Option<(ComparedNumber, Corrected)>>;

/// Computes the confidence interval of a compared number at an error rate, and the outcome of the
/// test.
fn at_level(one: &ComparedNumber, level: f64) -> (Option<[f64; 2]>, Test) {
    let freedom = one.degrees_of_freedom.map(|count| count as usize);
    let interval = Interval::student(one.difference, one.standard_error, freedom, level);
    let rule = VerdictRule {
        level,
        margin: one.margin,
        differ_beyond: one.differ_beyond,
    };
    (interval.ends, interval.decide(&rule))
}

/// Computes corrected intervals for the compared numbers of all sweep points. Points without a
/// number, or with a void comparison, do not count.
///
/// ```
/// use stosszahl_report::corrected;
/// use stosszahl_results::{ComparedNumber, VerdictKind};
///
/// let number = |difference: f64| Some(ComparedNumber {
///     quantity: "energy".into(), place: "at t = 20".into(), relative: true,
///     difference, standard_error: Some(0.01), degrees_of_freedom: None,
///     margin: 0.01, differ_beyond: 0.0, level: 0.05,
/// });
/// // 2.1 standard errors, where 1.96 are a difference of one point alone and 2.4 are one of three.
/// let [alone, all] = [vec![number(0.021)], vec![number(0.021), None, number(0.0), number(0.001)]]
///     .map(|numbers| corrected(&numbers).remove(0).unwrap());
/// assert_eq!((alone.kind, all.kind), (VerdictKind::Differ, VerdictKind::Undecided));
/// ```
pub fn corrected(numbers: &[Option<ComparedNumber>]) -> Vec<Option<Corrected>> {
    let all: Vec<&ComparedNumber> = numbers.iter().flatten().collect();
    let count = all.len();
    let share = |decided: usize| decided as f64 / count.max(1) as f64;
    let decided = |wanted: usize| {
        let level = |one: &ComparedNumber| one.level * share(wanted);
        let some = all.iter();
        some.filter(|one| at_level(one, level(one)).1 != Test::Undecided)
            .count()
    };
    let most = (1..=count).rev().find(|&wanted| decided(wanted) >= wanted);
    let factor = share(most.unwrap_or(1));
    let one = |number: &ComparedNumber| {
        let (corrected, test) = at_level(number, factor * number.level);
        Corrected {
            own: at_level(number, number.level).0,
            corrected,
            kind: match test {
                Test::Agree => VerdictKind::Agree,
                Test::Higher | Test::Lower => VerdictKind::Differ,
                Test::Undecided => VerdictKind::Undecided,
            },
        }
    };
    numbers
        .iter()
        .map(|number| number.as_ref().map(one))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn number(z: f64) -> ComparedNumber {
        ComparedNumber {
            quantity: "energy".into(),
            place: "at t = 1".into(),
            relative: true,
            difference: 0.1 * z,
            standard_error: Some(0.1),
            degrees_of_freedom: None,
            margin: 0.01,
            differ_beyond: 0.0,
            level: 0.05,
        }
    }

    /// Corrected intervals find the same differences as the procedure on p values: the largest k
    /// with p_(k) <= q k/m.
    #[test]
    fn differences_are_those_of_benjamini_and_hochberg() {
        for shift in [0.0, 0.5, 1.0, 1.7] {
            let z: Vec<f64> = (0..20).map(|n| f64::from(n) * 0.17 - 0.4 + shift).collect();
            let numbers: Vec<_> = z.iter().map(|&z| Some(number(z))).collect();
            let found = corrected(&numbers);
            let far =
                |z: f64, level: f64| z.abs() > stosszahl_analysis::replicas::quantile(level, None);
            let most = (1..=z.len()).rev().find(|&k| {
                let level = 0.05 * k as f64 / z.len() as f64;
                z.iter().filter(|&&z| far(z, level)).count() >= k
            });
            let level = 0.05 * most.unwrap_or(0) as f64 / z.len() as f64;
            for (z, found) in z.iter().zip(&found) {
                let kind = found.as_ref().expect("a number").kind;
                let expected = most.is_some() && far(*z, level);
                assert_eq!(kind == VerdictKind::Differ, expected, "{shift}: {z}");
            }
        }
    }

    /// Ten clear differences do not hide an eleventh, as Bonferroni's correction would.
    #[test]
    fn clear_points_leave_the_others_their_power() {
        let mut numbers = vec![Some(number(8.0)); 10];
        numbers.push(Some(number(2.1)));
        let found = corrected(&numbers);
        assert!(
            found
                .iter()
                .flatten()
                .all(|one| one.kind == VerdictKind::Differ)
        );
        let alone = corrected(&[vec![Some(number(2.1))], vec![Some(number(0.1)); 10]].concat());
        assert_eq!(
            alone[0].as_ref().expect("a number").kind,
            VerdictKind::Undecided
        );
        let [low, high] = alone[0]
            .as_ref()
            .and_then(|one| one.own)
            .expect("an interval");
        let [far_low, far_high] = alone[0]
            .as_ref()
            .and_then(|one| one.corrected)
            .expect("an interval");
        assert!(far_low < low && high < far_high);
    }
}
