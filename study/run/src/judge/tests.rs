use super::*;
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use stosszahl_analysis::statistics::student_t_test;
use stosszahl_results::TableEstimate;

/// Normal values by the sum of twelve uniform ones.
fn normal(stream: &mut Xoshiro256PlusPlus) -> f64 {
    (0..12).map(|_| stream.random::<f64>()).sum::<f64>() - 6.0
}

/// Pairs at each time whose quotient has the given logarithm and noise.
fn planted(
    stream: &mut Xoshiro256PlusPlus,
    logs: &[f64],
    noise: f64,
    replicas: usize,
) -> Vec<Vec<(f64, f64)>> {
    let one = |&log: &f64| {
        let pair = |stream: &mut Xoshiro256PlusPlus| ((log + noise * normal(stream)).exp(), 1.0);
        (0..replicas).map(|_| pair(stream)).collect()
    };
    logs.iter().map(one).collect()
}

fn pair(times: &[f64]) -> ComparedPair<'_> {
    ComparedPair {
        comparison: Comparison {
            topic: "energy",
            a: "DSMC stochastic disks",
            b: "Haff's law with its Sonine factor",
            quantity: "energy",
            unit: DifferenceUnit::Relative,
            rule: VerdictRule::new(0.01, 0.05),
        },
        places: Places::Times(times),
    }
}

#[test]
fn planted_differences_are_named_with_their_margin() {
    let stream = &mut Xoshiro256PlusPlus::seed_from_u64(1);
    let times = [0.1, 1.0, 100.0];
    let judge = |pairs: &[Vec<(f64, f64)>]| pair(&times).judge(pairs).expect("a verdict");
    let found = judge(&planted(stream, &[0.0, 0.0, 1.073_f64.ln()], 0.003, 8));
    assert_eq!(found.kind, VerdictKind::Differ);
    let said = &found.sentence;
    assert!(
        said.contains("differ in energy from t = 100 on: +7."),
        "{said}"
    );
    assert!(
        said.contains(" % (7 degrees of freedom) at t = 100, at least 6."),
        "{said}"
    );
    assert!(said.len() <= 170, "{said}");
    let number = found.number.expect("a number");
    assert_eq!((&*number.place, number.level), ("at t = 100", 0.005));
    let found = judge(&planted(stream, &[0.0; 3], 0.005, 8));
    assert_eq!(found.kind, VerdictKind::Agree);
    let said = &found.sentence;
    assert!(
        said.contains("agree in energy within 5 % at all times to t = 100: ")
            && said.contains(", below "),
        "{said}"
    );
    let found = judge(&planted(stream, &[0.0; 3], 0.3, 4));
    assert_eq!(found.kind, VerdictKind::Undecided);
    // An interval that reaches to twice the value is none.
    assert!(
        found.sentence.ends_with("; no bound holds."),
        "{}",
        found.sentence
    );
    let found = judge(&planted(stream, &[0.0; 3], 0.05, 4));
    assert_eq!(found.kind, VerdictKind::Undecided);
    let said = &found.sentence;
    assert!(
        said.contains("agree in energy within 5 % is undecided: ")
            && said.contains(" % (3 degrees of freedom) at t = 100, below "),
        "{said}"
    );
    let found = judge(&planted(stream, &[0.5; 3], 0.0, 1));
    assert_eq!(found.kind, VerdictKind::Undecided);
    assert!(
        found.sentence.contains("error unknown"),
        "{}",
        found.sentence
    );
    let same = judge(&[
        vec![(1.0, 1.0); 3],
        vec![(0.5, 0.5); 3],
        vec![(0.2, 0.2); 3],
    ]);
    assert!(same.kind == VerdictKind::Agree && same.sentence.contains("have the same energy"));
}

/// A difference that is found before the end is stated where its interval is farthest from zero.
#[test]
fn a_difference_that_vanishes_is_stated_where_it_was() {
    let stream = &mut Xoshiro256PlusPlus::seed_from_u64(5);
    let logs = [0.0, 0.2, 0.0];
    let found = pair(&[1.0, 2.0, 3.0]).judge(&planted(stream, &logs, 0.01, 8));
    let found = found.expect("a verdict");
    assert_eq!(found.kind, VerdictKind::Differ);
    assert!(
        found.sentence.contains("at 1 of 3 times: +2")
            && found.sentence.contains("at t = 2, at least 20 %"),
        "{}",
        found.sentence
    );
}

/// Of 1000 pairs that are equal at five times, 1 % may be called different: 10, and five binomial
/// errors of 3.1. Of as many pairs that are a margin apart, 0.5 % may be said to agree: 5, and five
/// errors of 2.2.
#[test]
fn verdicts_are_calibrated() {
    let stream = &mut Xoshiro256PlusPlus::seed_from_u64(2);
    let (times, logs) = ([1.0, 2.0, 3.0, 4.0, 5.0], [0.0; 5]);
    let (mut alarms, mut agreed, mut found_equal) = (0, 0, 0);
    for _ in 0..1000 {
        let kind = |found: Option<VerdictText>| found.expect("a verdict").kind;
        let equal = kind(pair(&times).judge(&planted(stream, &logs, 0.02, 6)));
        alarms += i32::from(equal == VerdictKind::Differ);
        let near = kind(pair(&times[..1]).judge(&planted(stream, &[0.0], 0.02, 6)));
        found_equal += i32::from(near == VerdictKind::Agree);
        let apart = planted(stream, &[1.05_f64.ln()], 0.02, 6);
        agreed += i32::from(kind(pair(&times[..1]).judge(&apart)) == VerdictKind::Agree);
    }
    assert!(alarms <= 26 && agreed <= 16, "{alarms} {agreed}");
    assert!(found_equal > 500, "{found_equal}");
}

#[test]
fn points_need_errors_to_agree() {
    let point = |measured: f64, error: Option<f64>| MeasuredPoint {
        time: 2.0,
        measured,
        error,
        replicas: None,
        theory: 2.0,
        theory_error: None,
    };
    let rule = VerdictRule::new(0.01, 0.02);
    let kind = |measured, error| point(measured, error).outcome(&rule);
    assert_eq!(kind(2.01, Some(0.01)), VerdictKind::Agree);
    assert_eq!(kind(2.03, Some(0.01)), VerdictKind::Differ);
    assert_eq!(kind(2.02, Some(0.01)), VerdictKind::Undecided);
    assert_eq!(kind(2.1, Some(0.01)), VerdictKind::Differ);
    assert_eq!(kind(2.1, Some(0.1)), VerdictKind::Undecided);
    assert_eq!(kind(2.0, None), VerdictKind::Undecided);
    let points = [
        point(2.01, Some(0.01)),
        point(1.8, Some(0.2)),
        point(2.1, Some(0.01)),
    ];
    let words = ["ED (exact)", "theory", "temperature of species heavy"];
    let found =
        |points: &[MeasuredPoint]| against_theory("t", words, points, &rule).expect("a verdict");
    let differ = found(&points);
    assert_eq!(differ.kind, VerdictKind::Differ);
    let expected = "ED (exact) and theory differ in temperature of species heavy from t = 2 on: +5.0 ± 0.5 % at t = 2, at least 3.5 %.";
    assert_eq!(differ.sentence, expected);
    // 5 % and ten standard errors of two replicas are nothing: Student's quantile at 1 % is 64.
    let few = MeasuredPoint {
        replicas: Some(2),
        ..point(2.1, Some(0.01))
    };
    assert_eq!(few.outcome(&rule), VerdictKind::Undecided);
    let agree = found(&points[..1]);
    // 0.5 % and 2.58 times as much.
    let expected = "ED (exact) and theory agree in temperature of species heavy within 2 %: +0.5 ± 0.5 % at t = 2, below 1.8 %.";
    assert_eq!(
        (agree.kind, &*agree.sentence),
        (VerdictKind::Agree, expected)
    );
    let expected = "Whether ED (exact) and theory agree in temperature of species heavy within 2 % is undecided: +5.0 ± 0.5 % (1 degree \
                    of freedom) at t = 2, below 37 %.";
    assert_eq!(found(&[few]).sentence, expected);
}

/// A window of as many replicas as there are slopes, with given curvatures.
fn window(slopes: &[f64], curvatures: &[f64], fewest: u64) -> ImpactTest {
    let mean = stosszahl_analysis::statistics::Estimate::over_replicas(slopes);
    let rows: Vec<Vec<f64>> = curvatures.iter().map(|&one| vec![one]).collect();
    ImpactTest {
        window: [1.0, 5.0],
        collisions: fewest * slopes.len() as u64,
        fewest,
        slopes: slopes.to_vec(),
        bend: 12_f64.sqrt() * curvatures.iter().sum::<f64>().abs() / curvatures.len() as f64,
        slope: mean.map_or(TableEstimate::default(), |mean| TableEstimate {
            replicas: Some(mean.replicas),
            ..TableEstimate::with_error(mean.value, mean.standard_error)
        }),
        trend: student_t_test(slopes, 0.0),
        shape: stosszahl_analysis::replicas::hotelling_test(&rows),
    }
}

#[test]
fn impact_parameters_are_judged_over_replicas() {
    let none = [1e-4, -2e-4, 0.0, 1e-4];
    let flat = window(&[0.001, -0.002, 0.003, -0.001], &none, 10_000);
    let grazing = window(&[0.225, 0.235, 0.23, 0.23], &none, 10_000);
    let central = window(&[-0.225, -0.235, -0.23, -0.23], &none, 10_000);
    let curved = window(
        &[0.001, -0.002, 0.003, -0.001],
        &[0.09, 0.11, 0.1, 0.1],
        10_000,
    );
    let wide = window(&[0.3, -0.2, 0.1, 0.0], &none, 10_000);
    let one = window(&[0.3], &[0.1], 10_000);
    let few = window(&[0.3, 0.3, 0.31, 0.29], &none, 12);
    let judge = |tests: &[ImpactTest]| {
        let rule = VerdictRule::new(0.01, 0.02);
        let words = impact_windows(tests, &rule).words;
        let found = impact_parameters("impact", "ED (exact)", tests, &rule);
        (words, found.kind, found.sentence)
    };
    let (words, kind, said) = judge(&[flat.clone(), grazing, curved.clone(), central]);
    assert_eq!(
        words,
        ["uniform", "grazing excess", "uneven", "central excess"]
    );
    assert_eq!(kind, VerdictKind::Differ);
    assert!(
        said.contains("in slope of P(b/d) in 2 of 4 windows: -0.2300 ± 0.0020 (3 degrees of freedom) from t = 1 to 5, at least 0.2"),
        "{said}"
    );
    for (test, kind, word, part) in [
        (
            flat,
            VerdictKind::Agree,
            "uniform",
            "within 0.02: 0.0003 ± 0.0011 (3 degrees of freedom) from t = 1 to 5, below 0.0086",
        ),
        (
            curved,
            VerdictKind::Differ,
            "uneven",
            "is bent as much as by a slope of 0.34",
        ),
        (
            wide,
            VerdictKind::Undecided,
            "undecided",
            "is undecided: 0.05 ± 0.10 (3 degrees of freedom) from t = 1 to 5, below 0.83",
        ),
        (
            one,
            VerdictKind::Undecided,
            "one replica",
            "one replica does not show",
        ),
        (
            few,
            VerdictKind::Undecided,
            "too few collisions",
            "48 collisions, at least 12 in a replica",
        ),
    ] {
        let (words, found, said) = judge(&[test]);
        assert_eq!((words[0], found), (word, kind), "{said}");
        assert!(said.contains(part), "{said}");
    }
}

#[test]
fn numbers_are_written_in_the_digits_of_their_error() {
    assert_eq!(format_deviation(0.0432, Some(0.001)), "+4.3 ± 0.1 %");
    assert_eq!(format_deviation(-0.05, None), "-5.00 % (error unknown)");
    assert_eq!(with_error(0.9324, Some(0.0123)), "0.932 ± 0.012");
    assert_eq!(format_margin(0.0179), "1.8 %");
    assert_eq!(format_margin(0.02), "2 %");
    assert_eq!(format_number(100.0), "100");
    assert_eq!(format_number(2.5e-7), "2.5e-7");
}

#[test]
fn what_has_no_error_is_never_said_to_agree() {
    let zero = |value, error| holds_zero(&TableEstimate::with_error(value, error), 0.01);
    assert_eq!(zero(0.0, None), None);
    assert_eq!(zero(0.1, Some(0.05)), Some(true));
    assert_eq!(zero(0.3, Some(0.05)), Some(false));
    let rule = VerdictRule::new(0.01, 0.05);
    let within =
        |value, error| super::verdict_within(&TableEstimate::with_error(value, error), &rule);
    assert_eq!(within(0.0, None), VerdictKind::Undecided);
    assert_eq!(within(f64::NAN, Some(0.1)), VerdictKind::Undecided);
    assert_eq!(is_kept("t", "x", 1e-12, 1e-10).kind, VerdictKind::Agree);
    assert_eq!(is_kept("t", "x", f64::NAN, 1e-10).kind, VerdictKind::Differ);
    let differ = |errors: [Option<f64>; 2], parts| {
        let values = [
            TableEstimate::with_error(1.0, errors[0]),
            TableEstimate::with_error(1.2, errors[1]),
        ];
        let words = ["A", "B", "density"];
        profiles("t", words, &[(values, "x = 0.5".into())], parts, &rule)
    };
    assert!(differ([None, Some(0.1)], 40).is_none());
    // Two blocks know their error badly.
    let found = [40, 2].map(|parts| differ([Some(0.01); 2], parts).expect("a verdict").kind);
    assert_eq!(found, [VerdictKind::Differ, VerdictKind::Undecided]);
}

/// No infinity, no number that is none, and no number of three hundred digits.
#[test]
fn numbers_that_nobody_can_read_are_not_shown() {
    let all = [f64::NAN, f64::INFINITY, 0.0, -0.25, 1e300, -1e300];
    for value in all {
        for error in all.map(|error| Some(error.abs())).into_iter().chain([None]) {
            for said in [
                super::with_error(value, error),
                super::format_deviation(value, error),
            ] {
                assert!(said.len() < 40, "{said}");
                assert!(!said.contains("inf") && !said.contains("NaN"), "{said}");
            }
        }
    }
}
