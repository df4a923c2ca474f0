//! Damages valid files: cuts them, splices them with each other, fills in bytes and words that are
//! hard to read. A failure is shrunk to the fewest changes.

use std::path::Path;

use proptest::prelude::*;
use proptest::test_runner::TestCaseError;

use super::draws::drawn;

/// Change to the bytes of a file; places are shares of its length.
#[derive(Clone, Debug)]
enum Damage {
    Set(f64, u8),
    Flip(f64, u8),
    Insert(f64, Vec<u8>),
    Word(f64, usize),
    /// Word in place of the number at or after a place.
    Number(f64, usize),
    Remove(f64, usize),
    Cut(f64),
    Repeat(f64, usize),
    Splice(f64, usize, f64),
}

/// Words that are hard to read.
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

/// Damages valid files a number of times and tests each.
pub fn fuzz(times: u32, valid: &[Vec<u8>], look: impl Fn(&[u8]) -> Result<(), TestCaseError>) {
    drawn(
        times,
        2,
        &(0..valid.len(), damages()),
        |(which, damages)| look(&apply(valid, which, &damages)),
    );
}

/// Checks that an error names the file, has a text, and is not too long.
pub fn clear(message: &str, path: &Path) -> Result<(), TestCaseError> {
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
