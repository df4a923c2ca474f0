//! Gases without positions from the command line.

use std::process::Command;

use serde_json::Value;
use stosszahl::stress::{Effort, mixture_cases};

fn bench(extra: &[&str]) -> Value {
    let output = Command::new(env!("CARGO_BIN_EXE_stosszahl"))
        .args(["bench", "mixture", "--monomers", "20000", "--json"])
        .args(extra)
        .output()
        .expect("starts");
    assert!(output.status.success(), "{output:?}");
    serde_json::from_slice(&output.stdout).expect("one JSON object")
}

/// The keys that scripts rely on, and the same numbers for the same seed.
#[test]
fn bench_mixture_prints_its_keys() {
    for selection in ["bird", "low-rank", "own"] {
        let work = ["--selection", selection, "--collisions", "5000"];
        let (first, again) = (bench(&work), bench(&work));
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
    let timed = bench(&["--until", "2"]);
    assert_eq!(timed["time"], 2.0);
    let refused = Command::new(env!("CARGO_BIN_EXE_stosszahl"))
        .args(["bench", "mixture", "--restitution", "1.5"])
        .output()
        .expect("starts");
    assert!(!refused.status.success());
    assert!(String::from_utf8_lossy(&refused.stderr).contains("from 0 to 1"));
}

#[test]
fn hard_cases_of_mixtures_hold() {
    for case in mixture_cases() {
        let report = case.run(Effort::default());
        assert!(report.passed(), "{report}");
    }
}
