//! Messages of the command line: refusals that name the rule, notes on settings from outside, help,
//! and places that cannot be written to.

use std::fs;
use std::process::Stdio;

use crate::support::program::{COOLING, TestFolder, WALLS};

/// Creates the case COOLING with a sweep.
fn swept(block: &str) -> TestFolder {
    TestFolder::new(&format!("{COOLING}[[sweep]]\n{block}\n"))
}

#[test]
fn a_refusal_says_the_rule_and_what_may_be_meant() {
    let work = TestFolder::new(COOLING);
    let refused =
        |line: &str, words: &[&str]| work.refused(&format!("check case.toml {line}"), words);
    refused(
        "--set gas.restitution=1.5",
        &["gas.restitution = 1.5 is refused; the rule: a number from 0 to 1"],
    );
    for (given, meant) in [
        ("gas.resti=0.9", "restitution"),
        ("gas.restituton=0.9", "restitution"),
        ("box.packing=0.2", "packing_fraction"),
        ("measure.snap.times=[1]", "snapshots"),
        ("engine.dsmc-ensk.displacement=false", "dsmc-enskog"),
    ] {
        refused(
            &format!("--set {given}"),
            &["unknown key", &format!("did you mean {meant}?")],
        );
    }
    refused(
        "--set gas.restitution",
        &["--set gas.restitution: an override is key=value"],
    );
    refused(
        "--set title=a\u{1b}[31mb",
        &["the value is a number, a word"],
    );
    // A negative number is a value, not an option.
    for option in ["--replicas", "--seed"] {
        let said = work.say(&format!("check case.toml {option} -1"));
        assert_eq!(said.code, Some(2));
        assert!(said.err.contains("expected a whole number"), "{}", said.err);
    }
}

#[test]
fn a_case_without_a_format_is_told_what_to_write() {
    let work = TestFolder::new(&COOLING.replace("format = 2\n", ""));
    let said = work.say("check case.toml --no-timing");
    assert_eq!(said.code, Some(2));
    assert!(
        said.err.contains("write `format = 2` in the first line"),
        "{}",
        said.err
    );
}

#[test]
fn texts_of_a_case_have_no_control_characters() {
    let work = TestFolder::new(&COOLING.replace("a small comparison", "red \\u001b[31m"));
    let said = work.say("run case.toml");
    assert_eq!(said.code, Some(2));
    assert!(
        said.err.contains("text without control characters"),
        "{}",
        said.err
    );
    assert!(
        !said.err.contains('\u{1b}') && !said.out.contains('\u{1b}'),
        "{:?}",
        said.err
    );
}

#[test]
fn a_typo_in_a_sweep_marks_the_key() {
    let work = swept("\"gas.restitutoin\" = [0.8, 0.9]");
    let line = COOLING.lines().count() + 2;
    let place = format!("case.toml:{line}:1");
    work.refused(
        "check case.toml",
        &[
            &place,
            "unknown key gas.restitutoin",
            "did you mean restitution?",
        ],
    );
    // The message points at the refused value itself, behind `"gas.restitution" = [0.8, `.
    let work = swept("\"gas.restitution\" = [0.8, 1.9]");
    work.refused(
        "check case.toml",
        &[&format!("case.toml:{line}:27"), "is refused"],
    );
}

#[test]
fn what_a_setting_does_to_a_sweep_is_told() {
    let work = swept(
        "\"gas\" = [{ number = 400, restitution = 0.8 }, { number = 500, restitution = 0.9 }]",
    );
    work.refused(
        "check case.toml --no-timing --set gas.number=100",
        &[
            "--set gas.number=100",
            "the case sweeps \"gas\", the whole table that holds this key",
        ],
    );
    let work = swept("\"run.until\" = [10, 20]");
    let said = work.done("check case.toml --no-timing --until 3");
    assert!(
        said.err.contains(
            "run.until is set from outside, so that the sweep of the case over it is left out"
        ),
        "{}",
        said.err
    );
    assert!(!said.out.contains("2 points"), "{}", said.out);
    // Setting another key leaves the sweep as it is, without a note.
    let said = work.done("check case.toml --no-timing --set gas.number=100");
    assert!(
        said.out.contains("2 points") && said.err.is_empty(),
        "{} {}",
        said.out,
        said.err
    );
}

#[test]
fn quiet_says_where_the_report_is_and_nothing_else() {
    let work = TestFolder::new(COOLING);
    let said = work.done("run case.toml --quiet --until 1");
    assert_eq!(said.err, "");
    assert_eq!(said.out.lines().count(), 1);
    assert!(said.out.trim_end().ends_with("report.html"), "{}", said.out);
}

#[test]
fn help_names_all_commands_and_fails_where_it_cannot_be_printed() {
    let work = TestFolder::new(COOLING);
    let said = work.done("--help");
    for command in [
        "run",
        "check",
        "cases",
        "schema",
        "completions",
        "manual",
        "reference",
    ] {
        assert!(
            said.out.contains(&format!("\n  {command} ")),
            "{command}: {}",
            said.out
        );
    }
    if cfg!(target_os = "linux") {
        for line in ["--help", "run --help", "--version", "cases"] {
            let full = fs::OpenOptions::new()
                .write(true)
                .open("/dev/full")
                .expect("a full device");
            let done = work
                .command(line)
                .stdout(Stdio::from(full))
                .output()
                .expect("an end");
            assert_eq!(done.status.code(), Some(1), "{line}");
            let said = String::from_utf8_lossy(&done.stderr);
            assert!(said.contains("standard output"), "{line}: {said}");
        }
    }
}

#[test]
fn a_folder_that_cannot_be_made_is_refused_input() {
    let work = TestFolder::new(COOLING);
    work.write("file", "");
    let long = "x".repeat(300);
    for place in ["file/below", &long, "/proc/nowhere/results"] {
        work.refused(
            &format!("run case.toml --until 1 --out {place}"),
            &["cannot be"],
        );
        work.refused(&format!("manual {place}"), &["cannot be"]);
    }
}

#[test]
fn a_damaged_mark_of_a_folder_is_named() {
    let work = TestFolder::new(COOLING);
    work.done("run case.toml --until 1");
    let whole = work.text("results/case/run.json");
    for damaged in [
        &whole[..whole.len() / 2],
        "{\"program\": \"stosszahl\", \"format\": 2}",
    ] {
        work.write("results/case/run.json", damaged);
        for how in ["--resume", "--force", ""] {
            work.refused(
                &format!("run case.toml --until 1 {how}"),
                &["run.json is damaged"],
            );
        }
    }
}

#[test]
fn chances_of_a_false_alarm_are_large_enough_to_be_computed() {
    let work = TestFolder::new(COOLING);
    work.refused(
        "check case.toml --no-timing --set verdict.family_wise_error_rate=1e-99",
        &["of at least 1e-12"],
    );
    work.done("check case.toml --no-timing --set verdict.family_wise_error_rate=1e-12");
}

/// A limit on the size of files is an error that names the file.
#[cfg(target_os = "linux")]
#[test]
fn a_file_beyond_the_limit_is_named() {
    let work = TestFolder::new(COOLING);
    let program = env!("CARGO_BIN_EXE_stosszahl");
    let done = std::process::Command::new("sh")
        .current_dir(work.path(""))
        .args([
            "-c",
            &format!("ulimit -f 4; exec {program} run case.toml --until 1"),
        ])
        .output()
        .expect("an end");
    assert_eq!(done.status.code(), Some(1), "{:?}", done.status);
    let said = String::from_utf8_lossy(&done.stderr);
    assert!(
        said.contains("cannot be written") && said.contains("results/case"),
        "{said}"
    );
}

#[test]
fn forces_and_contact_times_beyond_all_reason_are_refused() {
    let work = TestFolder::new(WALLS);
    work.refused(
        "check case.toml --no-timing --set gravity.acceleration=[0,-1e100]",
        &[
            "gravity.acceleration",
            "a fall through the box gives",
            "at most 1e12 T",
        ],
    );
    work.refused(
        "run case.toml --set engine.ed.contact_time=1e18",
        &[
            "engine.ed.contact_time = 1e18 is refused",
            "from 0 to run.until = 20",
        ],
    );
    work.done("check case.toml --no-timing --set gravity.acceleration=[0,-1e3]");
}
