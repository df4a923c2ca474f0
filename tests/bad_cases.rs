//! Wrong case files are refused with a message that names file, line, key, value and what is allowed.

#[allow(
    dead_code,
    unused_imports,
    reason = "only the table of bad cases is used here"
)]
mod support;

use std::collections::BTreeSet;
use std::fs;

use stosszahl::case::{Case, CaseError};
use support::bad_cases::{BAD_CASES, BadCase, Content, GOOD};

/// Reads a bad case from a real file.
fn refused(bad: &BadCase) -> (String, CaseError) {
    let folder = tempfile::tempdir().expect("a folder for the case");
    let path = folder
        .path()
        .join(format!("{}.toml", bad.name.replace(' ', "-")));
    if let Some(bytes) = bad.bytes() {
        fs::write(&path, bytes).expect("the case is written");
    } else if matches!(bad.content, Content::Directory) {
        fs::create_dir(&path).expect("a directory in place of the case");
    }
    let overrides: Vec<String> = bad.overrides.iter().map(ToString::to_string).collect();
    match Case::read(&path, &overrides) {
        Ok(_) => panic!("{}: a bad case was taken", bad.name),
        Err(error) => (path.display().to_string(), error),
    }
}

#[test]
fn the_good_case_is_good() {
    let folder = tempfile::tempdir().expect("a folder for the case");
    let path = folder.path().join("good.toml");
    fs::write(&path, GOOD).expect("the case is written");
    let file = Case::read(&path, &[]).expect("the good case is read");
    assert_eq!(file.points.len(), 1);
    assert!(file.points[0].settings.is_empty());
    assert_eq!(file.points[0].case.warnings(), []);
}

#[test]
fn names_differ() {
    let names: BTreeSet<&str> = BAD_CASES.iter().map(|bad| bad.name).collect();
    assert_eq!(names.len(), BAD_CASES.len());
    assert!(BAD_CASES.len() >= 30);
}

#[test]
fn every_bad_case_is_explained() {
    let mut wrong = Vec::new();
    for bad in BAD_CASES {
        let (path, error) = refused(bad);
        let message = error.to_string();
        let mut fault = |what: String| wrong.push(format!("{}: {what}\n    {message}", bad.name));
        for says in bad.says {
            if !message.contains(says) {
                fault(format!("the message does not say {says:?}"));
            }
        }
        if error.line() != bad.line {
            fault(format!(
                "line {:?} is named, not {:?}",
                error.line(),
                bad.line
            ));
        }
        if let Some(line) = bad.line
            && !message.starts_with(&format!("{path}:{line}: "))
        {
            fault(format!("the message does not begin with {path}:{line}:"));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
