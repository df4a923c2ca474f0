use super::*;
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

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

fn pair(times: &[f64]) -> Pair<'_> {
    Pair {
        topic: "energy",
        a: "DSMC stochastic disks",
        b: "Haff's law with its Sonine factor",
        quantity: "energy",
        places: Places::Times(times),
        level: 0.01,
    }
}

#[test]
fn planted_differences_are_named_with_their_margin() {
    let stream = &mut Xoshiro256PlusPlus::seed_from_u64(1);
    let times = [0.1, 1.0, 100.0];
    let judge = |pairs: &[Vec<(f64, f64)>]| pair(&times).judge(pairs).expect("a verdict");
    let found = judge(&planted(stream, &[0.0, 0.0, 1.043_f64.ln()], 0.003, 8));
    assert_eq!(found.kind, VerdictKind::Differ);
    assert!(
        found.sentence.contains("from t = 100 on, most by +4."),
        "{}",
        found.sentence
    );
    assert!(
        found.sentence.ends_with("% at t = 100."),
        "{}",
        found.sentence
    );
    assert!(found.sentence.len() <= 160, "{}", found.sentence);
    let found = judge(&planted(stream, &[0.0; 3], 0.005, 8));
    assert_eq!(found.kind, VerdictKind::Agree);
    assert!(found.sentence.contains("within") && found.sentence.contains("to t = 100"));
    let found = judge(&planted(stream, &[0.0; 3], 0.3, 4));
    assert_eq!(found.kind, VerdictKind::Undecided);
    let said = &found.sentence;
    // An interval that reaches to twice the value is none.
    assert!(
        said.contains("4 replicas are too few for any bound at t = "),
        "{said}"
    );
    let found = judge(&planted(stream, &[0.0; 3], 0.05, 4));
    assert_eq!(found.kind, VerdictKind::Undecided);
    let said = &found.sentence;
    assert!(
        said.contains("cannot be told apart in energy: < "),
        "{said}"
    );
    assert!(said.contains(" % with 4 replicas at t = "), "{said}");
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

/// Of 1000 pairs that are equal at five times, 1 % may be called different: 10, and five binomial errors of 3.1. Of pairs
/// that are 1 % apart, each agreement names a margin of that or more but for the share of misses of one time, 1 %.
#[test]
fn verdicts_are_calibrated() {
    let stream = &mut Xoshiro256PlusPlus::seed_from_u64(2);
    let (times, logs) = ([1.0, 2.0, 3.0, 4.0, 5.0], [0.0; 5]);
    let (mut alarms, mut agreed, mut short) = (0, 0, 0);
    for _ in 0..1000 {
        let found = pair(&times)
            .judge(&planted(stream, &logs, 0.02, 6))
            .expect("a verdict");
        alarms += i32::from(found.kind == VerdictKind::Differ);
        let apart = quotients(&planted(stream, &[0.01], 0.01, 6), 0.01);
        if apart[0].verdict == Test::Agree {
            agreed += 1;
            let reach = apart[0].quotient.value.ln().abs() + apart[0].half_width.expect("an error");
            short += i32::from(reach < 0.01);
        }
    }
    assert!(alarms <= 26, "{alarms}");
    assert!(agreed > 500 && short <= 26, "{short} of {agreed}");
}

#[test]
fn points_need_errors_to_agree() {
    let point = |measured: f64, error: Option<f64>| Point {
        time: 2.0,
        measured,
        error,
        replicas: None,
        theory: 2.0,
        theory_error: None,
    };
    let kind = |measured, error| point(measured, error).outcome(0.02, 0.01);
    assert_eq!(kind(2.01, Some(0.01)), VerdictKind::Agree);
    assert_eq!(kind(2.1, Some(0.01)), VerdictKind::Differ);
    assert_eq!(kind(2.1, Some(0.1)), VerdictKind::Undecided);
    assert_eq!(kind(2.0, None), VerdictKind::Undecided);
    let points = [
        point(2.01, Some(0.01)),
        point(2.1, Some(0.01)),
        point(1.8, Some(0.2)),
    ];
    let found = against_theory(
        "t",
        "The temperature of species 2",
        "theory",
        &points,
        0.02,
        0.01,
    );
    let found = found.expect("a verdict");
    assert_eq!(found.kind, VerdictKind::Differ);
    let expected =
        "The temperature of species 2 differs from theory by +5.0 ± 0.5 % at t = 2, beyond 2 %.";
    assert_eq!(found.sentence, expected);
    // 5 % and ten standard errors of two replicas are nothing: Student's quantile at 1 % is 64.
    let few = Point {
        replicas: Some(2),
        ..point(2.1, Some(0.01))
    };
    assert_eq!(few.outcome(0.02, 0.01), VerdictKind::Undecided);
    let found =
        against_theory("t", "The energy", "theory", &points[..1], 0.02, 0.01).expect("a verdict");
    // 0.5 % and 1.96 times as much.
    let expected = "The energy agrees with theory within 1.5 %; most off by +0.5 ± 0.5 % at t = 2.";
    assert_eq!(
        (found.kind, &*found.sentence),
        (VerdictKind::Agree, expected)
    );
    let found = against_theory("t", "The energy", "theory", &[few], 0.02, 0.01).expect("a verdict");
    let expected = "The energy cannot be told from theory: < 12 % with 2 replicas at t = 2, where it is off by +5.0 ± 0.5 %.";
    assert_eq!(found.sentence, expected);
}

/// A window of as many replicas as there are slopes, with given curvatures.
fn window(slopes: &[f64], curvatures: &[f64], fewest: u64) -> ImpactTest {
    let mean = stosszahl_analysis::statistics::Estimate::over_replicas(slopes);
    let rows: Vec<Vec<f64>> = curvatures.iter().map(|&one| vec![one]).collect();
    ImpactTest {
        window: [1.0, 5.0],
        collisions: fewest * slopes.len() as u64,
        fewest,
        slope: mean.map_or(Estimate::default(), |mean| Estimate {
            replicas: Some(mean.replicas),
            ..Estimate::of(mean.value, mean.standard_error)
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
        let words = impact_words(tests, 0.01);
        let found = impact_parameters("impact", "ED (exact)", tests, &words, 0.01);
        (words, found.kind, found.sentence)
    };
    let (words, kind, said) = judge(&[flat, grazing, central, curved]);
    assert_eq!(
        words,
        ["uniform", "grazing excess", "central excess", "uneven"]
    );
    assert_eq!(kind, VerdictKind::Differ);
    assert!(
        said.contains("slope -0.2300 ± 0.0020 from t = 1 to 5"),
        "{said}"
    );
    for (test, kind, word, part) in [
        (flat, VerdictKind::Agree, "uniform", "is below 0.007"),
        (
            curved,
            VerdictKind::Differ,
            "uneven",
            "density is curved (p = ",
        ),
        (
            wide,
            VerdictKind::Undecided,
            "undecided",
            "a slope below 0.66 stays possible with 4 replicas",
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
    assert_eq!(percent(0.0432, Some(0.001)), "+4.3 ± 0.1 %");
    assert_eq!(percent(-0.05, None), "-5.00 % (error unknown)");
    assert_eq!(with_error(0.9324, Some(0.0123)), "0.932 ± 0.012");
    assert_eq!(margin(0.0179), "1.8 %");
    assert_eq!(margin(0.02), "2 %");
    assert_eq!(short(100.0), "100");
    assert_eq!(short(2.5e-7), "2.500e-7");
}

#[test]
fn what_has_no_error_is_never_said_to_agree() {
    let zero = |value, error| super::zero(&Estimate::of(value, error), 0.01);
    assert_eq!(zero(0.0, None), VerdictKind::Undecided);
    assert_eq!(zero(0.1, Some(0.05)), VerdictKind::Agree);
    assert_eq!(zero(0.3, Some(0.05)), VerdictKind::Differ);
    let within = |value, error| super::within(&Estimate::of(value, error), 0.01, 0.01);
    assert_eq!(within(0.0, None), VerdictKind::Undecided);
    assert_eq!(within(f64::NAN, Some(0.1)), VerdictKind::Undecided);
    assert_eq!(kept("t", "x", 1e-12, 1e-10).kind, VerdictKind::Agree);
    assert_eq!(kept("t", "x", f64::NAN, 1e-10).kind, VerdictKind::Differ);
    let differ = |errors: [Option<f64>; 2], parts| {
        let values = [Estimate::of(1.0, errors[0]), Estimate::of(1.2, errors[1])];
        profiles("t", ["A", "B"], &[(values, "x = 0.5".into())], parts, 0.01)
    };
    assert!(differ([None, Some(0.1)], 40).is_none());
    let found = [40, 4].map(|parts| differ([Some(0.01); 2], parts).expect("a verdict").kind);
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
                super::percent(value, error),
            ] {
                assert!(said.len() < 40, "{said}");
                assert!(!said.contains("inf") && !said.contains("NaN"), "{said}");
            }
        }
    }
}
