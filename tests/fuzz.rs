//! Damaged files: whatever stands in a case, a start file or a checkpoint, reading it ends in a value that makes sense or
//! in an error that names the file, never in a panic.
//!
//! Valid files are cut, spliced with each other and peppered with bytes and with words that readers trip over. proptest
//! draws the damage from a fixed seed, keeps no files, and shrinks what fails to the fewest changes.

#[allow(dead_code, unused_imports, reason = "each test file uses its own part")]
mod support;

use std::fs;
use std::path::Path;

use proptest::prelude::*;
use proptest::test_runner::{Config, RngAlgorithm, RngSeed, TestCaseError, TestRng, TestRunner};
use serde_json::Value;
use stosszahl::case::CaseFile;
use stosszahl::ed::{Checkpoint, Dissipation, Engine};
use stosszahl::model::initial::{self, Arrangement};
use stosszahl::model::snapshot::{self, SnapshotError};
use stosszahl::study;
use support::program::{COOLING, SMALL, bundled, bundled_names, format};
use support::{Disks, disks, gas};

/// One change to the bytes of a file; places are shares of its length.
#[derive(Clone, Debug)]
enum Damage {
    Set(f64, u8),
    Flip(f64, u8),
    Insert(f64, Vec<u8>),
    Word(f64, usize),
    /// A word in place of the number at or after a place.
    Number(f64, usize),
    Remove(f64, usize),
    Cut(f64),
    Repeat(f64, usize),
    Splice(f64, usize, f64),
}

/// What readers trip over.
#[rustfmt::skip]
const WORDS: &[&str] = &[
    "nan", "-inf", "1e999", "-0", "0", "-1", "1e-320", "1e308", "1e100", "18446744073709551615", "18446744073709551616",
    "9223372036854775807", "4294967296", "0x7f", "\"", "\n", "\r\n", "\0", "\u{feff}", "\u{2028}", "é", "[", "]]", "{", "}",
    "=", ".", ",", "#", "'", "\\", "[[sweep]]\n", "a.b = 1\n", ":R:3", ":R:18446744073709551615", "x", " ", "\t", "true",
    "1979-05-27",
];

fn damages() -> impl Strategy<Value = Vec<Damage>> {
    let place = || 0.0..1.0_f64;
    let one = prop_oneof![
        (place(), any::<u8>()).prop_map(|(at, byte)| Damage::Set(at, byte)),
        (place(), 0..8_u8).prop_map(|(at, bit)| Damage::Flip(at, bit)),
        (place(), prop::collection::vec(any::<u8>(), 1..9))
            .prop_map(|(at, bytes)| Damage::Insert(at, bytes)),
        (place(), 0..WORDS.len()).prop_map(|(at, word)| Damage::Word(at, word)),
        (place(), 0..WORDS.len()).prop_map(|(at, word)| Damage::Number(at, word)),
        (place(), 1..40_usize).prop_map(|(at, length)| Damage::Remove(at, length)),
        place().prop_map(Damage::Cut),
        (place(), 1..60_usize).prop_map(|(at, length)| Damage::Repeat(at, length)),
        (place(), 0..8_usize, place())
            .prop_map(|(at, other, from)| Damage::Splice(at, other, from)),
    ];
    prop::collection::vec(one, 1..6)
}

fn apply(valid: &[Vec<u8>], which: usize, damages: &[Damage]) -> Vec<u8> {
    let mut bytes = valid[which % valid.len()].clone();
    for damage in damages {
        let length = bytes.len();
        let place = |share: f64| ((share * length as f64) as usize).min(length.saturating_sub(1));
        match *damage {
            Damage::Set(at, byte) if length > 0 => bytes[place(at)] = byte,
            Damage::Flip(at, bit) if length > 0 => bytes[place(at)] ^= 1 << bit,
            Damage::Set(..) | Damage::Flip(..) => {}
            Damage::Insert(at, ref more) => {
                bytes.splice(place(at)..place(at), more.iter().copied());
            }
            Damage::Word(at, word) => {
                bytes.splice(place(at)..place(at), WORDS[word].bytes());
            }
            Damage::Number(at, word) => {
                let number = |byte: &u8| byte.is_ascii_digit() || b".+-eE".contains(byte);
                let begin = (place(at)..length).find(|&i| bytes[i].is_ascii_digit());
                if let Some(begin) = begin {
                    let many = bytes[begin..]
                        .iter()
                        .take_while(|byte| number(byte))
                        .count();
                    bytes.splice(begin..begin + many, WORDS[word].bytes());
                }
            }
            Damage::Remove(at, many) => {
                let from = place(at);
                bytes.drain(from..(from + many).min(length));
            }
            Damage::Cut(at) => bytes.truncate(place(at)),
            Damage::Repeat(at, many) => {
                let from = place(at);
                let piece = bytes[from..(from + many).min(length)].to_vec();
                bytes.splice(from..from, piece);
            }
            Damage::Splice(at, other, from) => {
                let other = &valid[other % valid.len()];
                bytes.truncate(place(at));
                bytes.extend_from_slice(&other[(from * other.len() as f64) as usize..]);
            }
        }
    }
    bytes
}

/// Damages valid files a number of times and looks at each.
fn fuzz(times: u32, valid: &[Vec<u8>], look: impl Fn(&[u8]) -> Result<(), TestCaseError>) {
    let config = Config {
        cases: times,
        failure_persistence: None,
        rng_seed: RngSeed::Fixed(2),
        ..Config::default()
    };
    let stream = TestRng::deterministic_rng(RngAlgorithm::ChaCha);
    TestRunner::new_with_rng(config, stream)
        .run(&(0..valid.len(), damages()), |(which, damages)| {
            look(&apply(valid, which, &damages))
        })
        .unwrap_or_else(|failure| panic!("{failure}"));
}

/// An error names the file, says something, and is no flood.
fn clear(message: &str, path: &Path) -> Result<(), TestCaseError> {
    let name = path
        .file_name()
        .and_then(|name| name.to_str())
        .unwrap_or_default();
    prop_assert!(message.contains(name), "the file is not named: {message}");
    prop_assert!(
        message.len() > name.len() + 12,
        "nothing is said: {message}"
    );
    prop_assert!(message.len() < 4000, "{} bytes of message", message.len());
    Ok(())
}

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
        (3000, "csv", &valid[..tables]),
        (3000, "xyz", &valid[tables..]),
        (500, "xyz", &valid[..]),
    ] {
        let path = folder.path().join(format!("start.{ending}"));
        for whole in valid.iter().filter(|_| times > 1000) {
            fs::write(&path, whole).expect("written");
            initial::read(&path).expect("a valid file");
        }
        fuzz(times, valid, |bytes| {
            fs::write(&path, bytes).expect("written");
            match initial::read(&path) {
                Err(error) => clear(&error.to_string(), &path),
                Ok(start) => {
                    let count = start.positions.len();
                    let alike = |other: Option<usize>| other.is_none_or(|n| n == count);
                    prop_assert!(count > 0);
                    prop_assert!(
                        start
                            .lengths
                            .iter()
                            .all(|side| *side > 0.0 && side.is_finite())
                    );
                    let mut vectors = start
                        .positions
                        .iter()
                        .chain(start.velocities.iter().flatten());
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

/// Reads a case as the program does, and derives what follows from its first points, which stand for all.
fn look(path: &Path, text: &str, set: &[String]) -> Result<(), TestCaseError> {
    let planned = format().from_text(path, text, set).and_then(|mut file| {
        file.points.truncate(2);
        for planned in study::check(&file)? {
            let outline = planned.outline(2, 0.01);
            assert!(
                outline.cost.bytes >= 0.0 && !outline.engines.is_empty(),
                "{set:?}"
            );
            for text in outline.warnings.iter().chain(&planned.plan.choices) {
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

/// No number has more digits than the longest whole one, and none is infinite with an error.
fn is_readable(text: &str) -> bool {
    let digits = text.split(|letter: char| !letter.is_ascii_digit());
    digits.map(str::len).max().unwrap_or(0) <= 20 && !text.contains('±')
}

#[test]
fn damaged_cases() {
    // As the folder lists them differs from system to system, names are sorted.
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

/// Overrides are typed by people.
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

/// All keys of a part of the schema, dotted; of lists, the first element.
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

/// Each key of the format at each odd value, every `stride`-th of the small cases: a case, or an error that names the place.
fn odd_values(stride: usize) {
    let mut all = Vec::new();
    keys(format().json(), "", &mut all);
    all.sort();
    all.dedup();
    assert!(all.len() > 150, "{}", all.len());
    let path = Path::new("case.toml");
    for (row, key) in all.iter().enumerate() {
        for (column, value) in ODD.split_whitespace().enumerate() {
            let set = format!("{key}={value}");
            // Another case for each key and value.
            let cases = SMALL.iter().skip((row + column) % stride).step_by(stride);
            for (name, text) in cases {
                if let Err(error) = look(path, text, std::slice::from_ref(&set)) {
                    panic!("{name} --set {set}: {error}");
                }
            }
        }
    }
}

#[test]
fn every_key_takes_odd_values_or_refuses_them() {
    odd_values(SMALL.len());
}

/// `cargo test --test fuzz -- --ignored`.
#[test]
#[ignore = "takes some minutes"]
fn every_key_of_every_small_case_takes_odd_values() {
    odd_values(1);
}

const RUN: snapshot::Fingerprint = [3; 32];

/// Files of two checkpoints, with and without contact times.
fn checkpoints(folder: &Path) -> Vec<Vec<u8>> {
    [Dissipation::Scene, Dissipation::ContactTime(1e-3)]
        .into_iter()
        .map(|dissipation| {
            let start = gas(Arrangement::Disordered, 6, 0.3, 1);
            let mut engine = Engine::<_>::new(disks(0.9), dissipation, start).expect("an engine");
            engine
                .advance(f64::INFINITY, 20, &mut ())
                .expect("collisions");
            let path = folder.join("valid");
            snapshot::write(&path, &RUN, &engine.checkpoint()).expect("written");
            fs::read(&path).expect("read")
        })
        .collect()
}

/// Bytes before the payload: mark, format, length, fingerprint, hash.
const HEADER: usize = 84;

/// Whatever happens to a checkpoint on its way, it is found out: never is other content read than was written.
#[test]
fn damaged_checkpoints() {
    let folder = tempfile::tempdir().expect("a folder");
    let valid = checkpoints(folder.path());
    let path = folder.path().join("checkpoint");
    fuzz(3000, &valid, |bytes| {
        fs::write(&path, bytes).expect("written");
        match snapshot::read::<Checkpoint<Disks>>(&path, &RUN) {
            Err(error @ (SnapshotError::Damaged { .. } | SnapshotError::Foreign { .. })) => {
                clear(&error.to_string(), &path)
            }
            Err(error) => Err(TestCaseError::fail(format!("another error: {error}"))),
            Ok(_) => {
                prop_assert!(
                    valid.iter().any(|whole| whole == bytes),
                    "damage was not noticed"
                );
                Ok(())
            }
        }
    });
}

/// Payloads that are wrong under the right hash, as another version might write them: read or refused, and what is read is
/// taken by the engine or refused.
#[test]
fn wrong_checkpoints() {
    let folder = tempfile::tempdir().expect("a folder");
    let valid: Vec<Vec<u8>> = checkpoints(folder.path())
        .into_iter()
        .map(|whole| whole[HEADER..].to_vec())
        .collect();
    let path = folder.path().join("checkpoint");
    fuzz(3000, &valid, |payload| {
        let mut bytes = b"STOSSZHL".to_vec();
        bytes.extend_from_slice(&1_u32.to_le_bytes());
        bytes.extend_from_slice(&(payload.len() as u64).to_le_bytes());
        bytes.extend_from_slice(&RUN);
        bytes.extend_from_slice(blake3::hash(payload).as_bytes());
        bytes.extend_from_slice(payload);
        fs::write(&path, bytes).expect("written");
        match snapshot::read::<Checkpoint<Disks>>(&path, &RUN) {
            Err(error) => clear(&error.to_string(), &path),
            Ok(checkpoint) => {
                // What the engine says it does not look for, see `Engine::new`.
                let state = &checkpoint.state;
                let positions: Vec<_> = state
                    .bodies
                    .iter()
                    .map(|body| state.domain.wrap(body.position))
                    .collect();
                let finite = positions
                    .iter()
                    .chain([&state.domain.lengths()])
                    .all(|v| v.iter().all(|x| x.is_finite()));
                if finite
                    && initial::first_overlap(&positions, |_| 0.5, &state.domain, 1e-9).is_some()
                {
                    return Ok(());
                }
                for dissipation in [Dissipation::Scene, Dissipation::ContactTime(1e-3)] {
                    if let Err(error) =
                        Engine::<_>::new(disks(0.9), dissipation, checkpoint.clone())
                    {
                        prop_assert!(error.to_string().len() > 12, "{error}");
                    }
                }
                Ok(())
            }
        }
    });
}
