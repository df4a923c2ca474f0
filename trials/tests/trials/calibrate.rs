//! Rates of false alarms and of found effects, in the short form of `stosszahl-trials calibrate`.

use stosszahl_trials::{Effort, calibrate};

/// Calibrates on planted replicas, and on 20 elastic cases of the program itself.
#[test]
fn verdicts_are_calibrated() {
    let effort = Effort {
        quick: true,
        ..Effort::default()
    };
    for trial in calibrate::TRIALS {
        let report = trial.run_trial(&effort);
        assert!(report.passed(), "{report}");
    }
}
