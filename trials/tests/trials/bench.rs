//! Speed from the command line.

use std::process::{Command, Output};

use serde_json::Value;

fn run(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_stosszahl-trials"))
        .args(arguments)
        .output()
        .expect("the program runs")
}

fn text(bytes: &[u8]) -> &str {
    std::str::from_utf8(bytes).expect("text")
}

fn mixture(extra: &[&str]) -> Value {
    let work = ["bench", "mixture", "--monomers", "20000", "--json"];
    let output = run(&[&work, extra].concat());
    assert!(output.status.success(), "{output:?}");
    serde_json::from_slice(&output.stdout).expect("one JSON object")
}

/// Outputs have the keys that scripts rely on, and equal numbers for equal seeds.
#[test]
fn bench_mixture_prints_its_keys() {
    for selection in ["single-majorant", "low-rank", "alias-tables"] {
        let work = ["--selection", selection, "--collisions", "5000"];
        let (first, again) = (mixture(&work), mixture(&work));
        for key in [
            "collisions",
            "trials_per_collision",
            "final_energy",
            "bytes_per_particle",
        ] {
            assert!(
                first[key].as_f64().is_some_and(|value| value > 0.0),
                "{key}: {first}"
            );
            assert_eq!(first[key], again[key], "{key}");
        }
        assert!(first["seconds"].as_f64().is_some());
        assert_eq!(first["collisions"], 5000);
        assert_eq!(first["selection"], selection);
    }
    let timed = mixture(&["--until", "2"]);
    assert_eq!(timed["time"], 2.0);
    let refused = run(&["bench", "mixture", "--restitution", "1.5"]);
    assert!(!refused.status.success());
    assert!(String::from_utf8_lossy(&refused.stderr).contains("0 to 1"));
}

/// Runs do the requested work, and refuse numbers out of range with the allowed ones.
#[test]
fn bench_dsmc_measures_the_work_that_was_asked_for() {
    for (dimension, free) in [("2", false), ("3", false), ("2", true)] {
        let mut arguments = vec!["bench", "dsmc", "--dimension", dimension, "--json"];
        arguments.extend(["--simulators", "30000", "--steps", "10", "--threads", "2"]);
        arguments.extend(free.then_some("--free-flight"));
        let output = run(&arguments);
        assert!(output.status.success(), "{}", text(&output.stderr));
        let found: Value = serde_json::from_slice(&output.stdout).expect("an object");
        let number = |key: &str| found[key].as_f64().expect(key);
        assert!(number("particle_steps_per_second") > 0.0);
        // Bound with the working memory of two threads, a good part of the total for few
        // simulators.
        assert!(number("bytes_per_simulator") < 200.0);
        assert_eq!(number("collisions_per_second") > 0.0, !free);
        // 2e4 collisions: a spread of 0.7 %, and as much by the ideal gas of the start; z = 4.
        let expected = if free { 0.0 } else { 1.0 };
        assert!((number("collision_rate_over_theory") - expected).abs() < 0.04);
        assert!((number("collisions_per_step") - 0.07 * expected).abs() < 0.003);
    }
    let output = run(&["bench", "dsmc", "--per-cell", "0"]);
    assert_eq!(output.status.code(), Some(2), "{}", text(&output.stderr));
    assert!(text(&output.stderr).contains("allowed"));
}
