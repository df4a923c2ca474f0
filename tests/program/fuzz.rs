//! Damaged files: reading any case or start file ends in a value that makes sense or in an error
//! that names the file, never in a panic. Damaged checkpoints are in `engines/checkpoints.rs`.

use std::fs;
use std::ops::Range;
use std::path::Path;

use crate::support::damage::{clear, fuzz};
use crate::support::part::part_of;
use crate::support::program::{COOLING, SMALL, bundled, bundled_names, format};
use proptest::prelude::*;
use proptest::test_runner::TestCaseError;
use serde_json::Value;
use stosszahl::case::CaseFile;
use stosszahl::model::initial;
use stosszahl::study;

#[test]
fn damaged_start_files() {
    let mut valid = vec![
        b"# box: 10 8\nx,y\n1,1\n3,1\n5,5\n".to_vec(),
        b"# box: 10 8.5\nx,y,vx,vy,radius,mass\n1,1,0.5,-1e-3,0.5,1\n3,1,0,0,0.25,2\n5.5,5,1,1,0.1,1e-2\n".to_vec(),
        b"# box: 4 4\r\nmass,y,x,radius\r\n1,1,1,0.5\r\n2,3,3,0.5\r\n".to_vec(),
    ];
    let texts = [
        "3\nLattice=\"10 0 0 0 8 0 0 0 1\" Properties=id:I:1:pos:R:3:velo:R:3:radius:R:1:mass:R:1 Time=0\n0 1 1 0 0.5 0 0 0.5 1\n\
         1 3 1 0 0 0 0 0.5 1\n2 5 5 0 1 1 0 0.5 1\n",
        "2\nLattice=\"10 0 0 0 8 0 0 0 1\" Properties=species:S:1:pos:R:2\nA 1 1\nA 3 3\n",
    ];
    let tables = valid.len();
    valid.extend(texts.map(|text| text.as_bytes().to_vec()));
    let folder = tempfile::tempdir().expect("a folder");
    for (times, ending, valid) in [
        (1000, "csv", &valid[..tables]),
        (1000, "xyz", &valid[tables..]),
        (250, "xyz", &valid[..]),
    ] {
        let path = folder.path().join(format!("start.{ending}"));
        for whole in valid.iter().filter(|_| times > 500) {
            fs::write(&path, whole).expect("written");
            initial::read_start_file(&path).expect("a valid file");
        }
        fuzz(times, valid, |bytes| {
            fs::write(&path, bytes).expect("written");
            match initial::read_start_file(&path) {
                Err(error) => clear(&error.to_string(), &path),
                Ok(start) => {
                    let count = start.count();
                    let alike = |other: Option<usize>| other.is_none_or(|n| n == count);
                    prop_assert!(count > 0);
                    prop_assert!(
                        start
                            .lengths
                            .iter()
                            .flatten()
                            .take(2)
                            .all(|side| *side > 0.0 && side.is_finite())
                    );
                    let mut vectors = start.positions.iter().chain(&start.velocities).flatten();
                    prop_assert!(vectors.all(|v| v.iter().all(|x| x.is_finite())));
                    let mut sizes = start.radii.iter().chain(&start.masses).flatten();
                    prop_assert!(sizes.all(|x| *x > 0.0 && x.is_finite()));
                    prop_assert!(alike(start.velocities.as_ref().map(Vec::len)));
                    prop_assert!(alike(start.radii.as_ref().map(Vec::len)));
                    prop_assert!(alike(start.masses.as_ref().map(Vec::len)));
                    Ok(())
                }
            }
        });
    }
}

/// Reads a case as the program does, and plans its first points, which stand for all.
fn look(path: &Path, text: &str, set: &[String]) -> Result<(), TestCaseError> {
    let planned = format().from_text(path, text, set).and_then(|mut file| {
        file.points.truncate(2);
        for planned in study::check_case(&file)? {
            let outline = planned.outline(2);
            assert!(
                outline.cost.bytes >= 0.0 && !outline.engines.is_empty(),
                "{set:?}"
            );
            for text in outline.warnings.iter().chain(&planned.plan.notes.choices) {
                assert!(is_readable(text), "{set:?}: {text}");
            }
        }
        Ok(())
    });
    let Err(error) = planned else {
        return Ok(());
    };
    prop_assert!(!error.report(false).is_empty());
    let said = error.to_string();
    if set.is_empty() {
        return clear(&said, path);
    }
    prop_assert!(
        said.len() > 12 && said.len() < 4000,
        "{} bytes: {said}",
        said.len()
    );
    prop_assert!(is_readable(&said), "{said}");
    Ok(())
}

/// Returns true if no number has more digits than the longest whole one, and none is infinite with
/// an error.
fn is_readable(text: &str) -> bool {
    let digits = text.split(|letter: char| !letter.is_ascii_digit());
    digits.map(str::len).max().unwrap_or(0) <= 20 && !text.contains('±')
}

#[test]
fn damaged_cases() {
    // Sorted names, because the order in a folder depends on the system.
    let files = bundled_names()
        .into_iter()
        .map(|name| fs::read(bundled(&name)).expect("a case"));
    let small = SMALL.iter().map(|(_, text)| text.as_bytes().to_vec());
    let valid: Vec<Vec<u8>> = files.chain(small).collect();
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("case.toml");
    fuzz(2000, &valid, |bytes| {
        fs::write(&path, bytes).expect("written");
        match CaseFile::read(&path, &[]) {
            Err(error) => clear(&error.to_string(), &path),
            Ok(file) => look(&path, &file.text, &[]),
        }
    });
}

/// Damaged overrides, as people mistype them, are read or refused.
#[test]
fn damaged_overrides() {
    let valid: Vec<Vec<u8>> = [
        "gas.restitution=0.9",
        "run.until=3",
        "measure.impact_parameters.windows=[[0,1]]",
        "start.placement=square",
        "species.1.number=40",
    ]
    .map(|text| text.as_bytes().to_vec())
    .to_vec();
    fuzz(1500, &valid, |bytes| {
        let text = String::from_utf8_lossy(bytes).into_owned();
        if let Err(error) = CaseFile::from_text(Path::new("case.toml"), COOLING, &[text]) {
            prop_assert!(error.to_string().len() > 12, "{error}");
        }
        Ok(())
    });
}

/// Values that people, programs and damaged files write.
const ODD: &str = "0 -0.0 1 -1 2 3 0.5 1.5 1e5 nan inf -inf 1e308 1e-308 5e-324 1e100 1e15 1000000 2000000000 \
    9223372036854775807 -9223372036854775808 true \"\" \"x\" \"../../x\" \"a\\u0000b\" [] [1] [0,0] [1e-9,2,3] [[0,1]] {} \
    1979-05-27";

/// Lists all keys of a part of the schema, dotted; of lists, the first element.
fn keys(schema: &Value, key: &str, found: &mut Vec<String>) {
    let inside = |name: &str| match key {
        "" => name.to_owned(),
        _ => format!("{key}.{name}"),
    };
    for (name, inner) in schema["properties"].as_object().into_iter().flatten() {
        found.push(inside(name));
        keys(inner, &inside(name), found);
    }
    if schema["items"].is_object() {
        found.push(inside("1"));
        keys(&schema["items"], &inside("1"), found);
    }
    for choices in ["anyOf", "oneOf"] {
        for choice in schema[choices].as_array().into_iter().flatten() {
            keys(choice, key, found);
        }
    }
}

/// Sets each key of the format to each odd value, in every `stride`-th of the small cases: the
/// result is a case, or an error that names the place.
#[allow(clippy::print_stdout, reason = "a long test tells where it is")]
fn odd_values(stride: usize, chosen: impl Fn(usize) -> Range<usize>) {
    let mut all = Vec::new();
    keys(format().json(), "", &mut all);
    all.sort();
    all.dedup();
    assert!(all.len() > 150, "{}", all.len());
    let path = Path::new("case.toml");
    let rows = chosen(all.len());
    let mut looks = 0;
    for (row, key) in all.iter().enumerate().skip(rows.start).take(rows.len()) {
        // The key is printed, so that the place is known if the test is killed.
        println!("{key}");
        for (column, value) in ODD.split_whitespace().enumerate() {
            let set = format!("{key}={value}");
            // A different case for each key and value.
            let cases = SMALL.iter().skip((row + column) % stride).step_by(stride);
            for (name, text) in cases {
                if let Err(error) = look(path, text, std::slice::from_ref(&set)) {
                    panic!("{name} --set {set}: {error}");
                }
                looks += 1;
            }
        }
    }
    println!("keys {rows:?} of {}: {looks} looks", all.len());
}

#[test]
fn every_key_takes_odd_values_or_refuses_them() {
    odd_values(SMALL.len(), |count| 0..count);
}

/// Long form, run by `cargo test --test program fuzz -- --ignored`.
#[test]
#[ignore = "takes some minutes: cargo long-tests"]
fn every_key_of_every_small_case_takes_odd_values() {
    odd_values(1, part_of);
}
