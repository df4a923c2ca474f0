//! Verdicts on impact parameters against molecular chaos: slope and shape of their density, over
//! independent replicas.

use stosszahl_analysis::compare::{ComparisonVerdict as Test, Interval, VerdictRule, differences};
use stosszahl_analysis::replicas::{HotellingTest, hotelling_test, shape};
use stosszahl_analysis::statistics::{Estimate as Mean, TTest, holm, student_t_test};
use stosszahl_analysis::windows::{CollisionWindow, pooled};
use stosszahl_results::{TableEstimate, VerdictKind, VerdictText, format_number};

use super::{Comparison, DifferenceUnit, Finding, in_units, verdict};

/// Tests of the impact parameters in one time window against molecular chaos. Replicas are
/// independent, collisions within one are not.
#[derive(Clone, Debug, PartialEq)]
pub struct ImpactTest {
    /// Start and end of the time window, in the unit of time of the case.
    pub window: [f64; 2],
    /// Number of collisions in the window, all replicas together.
    pub collisions: u64,
    /// Smallest number of collisions in the window in any replica.
    pub fewest: u64,
    /// Slope of the density of impact parameters b/d of all collisions, zero under molecular chaos;
    /// its standard error is the jackknife's over replicas.
    pub slope: TableEstimate,
    /// Jackknife pseudo-values of the slope, one for each replica.
    pub slopes: Vec<f64>,
    /// Student's test of the slope against zero; `None` with one replica.
    pub trend: Option<TTest>,
    /// Hotelling's test of further shapes of the density (curvature and so on), as many as the
    /// replicas allow.
    pub shape: Option<HotellingTest>,
    /// Size of the further shapes, expressed as the slope of a straight density with equal mean
    /// square deviation from uniform.
    pub bend: f64,
}

/// Largest number of shapes beyond the slope that are tested at once. A contact value or a cluster
/// bends the density; it does not ripple it.
const SHAPES: usize = 4;

/// Largest slope of a density over b/d from 0 to 1; a density with a larger slope is negative
/// somewhere.
const STEEPEST: f64 = 2.0;

/// Fewest collisions of a replica at which its slope is taken as normally distributed. The slope of
/// 30 uniform numbers is normal to 1 % of the probability beyond three standard errors.
pub const FEWEST_COLLISIONS: u64 = 30;

impl ImpactTest {
    /// Tests the impact parameters of one time window, given the sums of that window in every
    /// replica.
    pub fn test_window(span: [f64; 2], all: &[&CollisionWindow]) -> Self {
        let slopes = pooled(all, CollisionWindow::slope);
        let slope = Mean::over_replicas(&slopes);
        // Half as many as replicas leaves each a spread that is known; one at least, which is
        // Student's test of the curvature.
        let orders = (slopes.len().saturating_sub(1) / 2).clamp(1, SHAPES);
        let some = all.iter().filter(|window| window.collisions > 0);
        let shapes = some.map(|window| {
            let found = shape(&window.bins, &window.chances(), orders + 1);
            found.into_iter().skip(1).collect()
        });
        let shapes: Vec<Vec<f64>> = shapes.collect();
        let mean = |order: usize| {
            shapes.iter().map(|row| row[order]).sum::<f64>() / shapes.len().max(1) as f64
        };
        let squares = (0..shapes.first().map_or(0, Vec::len)).map(|order| mean(order).powi(2));
        Self {
            window: span,
            collisions: all.iter().map(|window| window.collisions).sum(),
            fewest: (all.iter().map(|window| window.collisions).min()).unwrap_or(0),
            slope: slope.map_or(TableEstimate::default(), |slope| TableEstimate {
                replicas: Some(slope.replicas),
                ..TableEstimate::with_error(slope.value, slope.standard_error)
            }),
            trend: student_t_test(&slopes, 0.0),
            slopes,
            // A slope s has the mean square s²/12.
            bend: (12.0 * squares.sum::<f64>()).sqrt(),
            shape: hotelling_test(&shapes),
        }
    }

    fn is_testable(&self) -> bool {
        self.fewest >= FEWEST_COLLISIONS && self.slopes.len() > 1
    }
}

/// Outcome of the tests of impact parameters in all windows of one engine.
#[derive(Clone, Debug, PartialEq)]
pub struct ImpactWindows {
    /// Slope of each window with its confidence interval, simultaneous over the windows at half of
    /// the error probability; `None` if the slope cannot be tested.
    pub slopes: Vec<Option<Interval>>,
    /// Outcome of each window in a word for tables: `uniform`, `grazing excess`, `central excess`,
    /// `uneven`, `undecided`, `one replica` or `too few collisions`.
    pub words: Vec<&'static str>,
}

/// Decides the outcome of all windows of one engine. Half of the error probability is for the
/// slopes, half for further shapes, by Holm's method.
pub fn impact_windows(tests: &[ImpactTest], rule: &VerdictRule) -> ImpactWindows {
    let half = rule.at_level(0.5 * rule.level);
    let rows = tests.iter().filter(|one| one.is_testable());
    let rows: Vec<Vec<f64>> = rows.map(|one| one.slopes.clone()).collect();
    let mut found = differences(&rows, &half).into_iter();
    let slopes: Vec<Option<Interval>> = (tests.iter())
        .map(|one| one.is_testable().then(|| found.next()).flatten())
        .collect();
    let p_value = |one: &ImpactTest| {
        let test = one.shape.filter(|_| one.is_testable());
        test.map_or(f64::NAN, |test| test.p_value)
    };
    let p_values: Vec<f64> = tests.iter().map(p_value).collect();
    let bent = holm(&p_values, half.level);
    let judged = tests.iter().zip(&slopes).zip(bent);
    let words = judged.map(|((one, slope), bent)| {
        let Some(slope) = slope else {
            return if one.fewest < FEWEST_COLLISIONS {
                "too few collisions"
            } else {
                "one replica"
            };
        };
        match slope.decide(rule) {
            Test::Higher => "grazing excess",
            Test::Lower => "central excess",
            _ if bent && one.bend > rule.margin => "uneven",
            Test::Agree => "uniform",
            Test::Undecided => "undecided",
        }
    });
    let words = words.collect();
    ImpactWindows { slopes, words }
}

/// Decides the verdict on the impact parameters of one engine, and words it.
pub fn impact_parameters(
    topic: &str,
    engine: &str,
    tests: &[ImpactTest],
    rule: &VerdictRule,
) -> VerdictText {
    let ImpactWindows { slopes, words } = impact_windows(tests, rule);
    let span = |one: &ImpactTest| {
        let [start, end] = one.window.map(format_number);
        format!("from t = {start} to {end}")
    };
    let open = |sentence: String| verdict(topic, sentence, VerdictKind::Undecided);
    let several = slopes.iter().flatten().count() > 1;
    let comparison = Comparison {
        topic,
        a: engine,
        b: "molecular chaos",
        quantity: "slope of P(b/d)",
        unit: DifferenceUnit::Own(STEEPEST),
        rule: rule.at_level(0.5 * rule.level),
    };
    let findings = tests.iter().zip(&slopes).filter_map(|(one, slope)| {
        let share = if several { 0.5 } else { 1.0 };
        Some(Finding {
            interval: (*slope)?,
            place: span(one),
            level: share * comparison.rule.level,
        })
    });
    let findings: Vec<Finding> = findings.collect();
    let everywhere = match findings.len() {
        1 => String::new(),
        count => format!("in all {count} windows"),
    };
    let Some(mut found) = comparison.judge(&findings, &everywhere) else {
        return match tests.iter().find(|one| one.collisions > 0) {
            Some(one) if one.fewest < FEWEST_COLLISIONS => open(format!(
                "Whether the impact parameters of {engine} are uniform is undecided: {} collisions, at least {} in a replica, are \
                 too few {}.",
                one.collisions,
                one.fewest,
                span(one)
            )),
            Some(one) => open(format!(
                "Whether the impact parameters of {engine} are uniform is undecided: collisions of one gas depend on each other, \
                 and one replica does not show how much; slope {} {}.",
                in_units(&one.slope, 1.0),
                span(one)
            )),
            None => open(format!(
                "{engine} has no collisions whose impact parameters could be tested."
            )),
        };
    };
    let mut bent = tests.iter().zip(&words).rev();
    let bent = bent.find(|(_, word)| **word == "uneven");
    if let Some((one, _)) = bent.filter(|_| found.kind != VerdictKind::Differ) {
        let p_value = one.shape.map_or(f64::NAN, |test| test.p_value);
        found.kind = VerdictKind::Differ;
        found.sentence = format!(
            "{engine} and molecular chaos differ in the shape of P(b/d): it is bent as much as by a slope of {} (p = {p_value:.1e}), \
             and its slope is {} {}.",
            format_number(one.bend),
            in_units(&one.slope, 1.0),
            span(one)
        );
    }
    if findings.len() < tests.len() && found.kind == VerdictKind::Agree {
        found.kind = VerdictKind::Undecided;
        found.sentence += " Other windows have too few collisions.";
    }
    found
}
