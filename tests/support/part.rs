//! Long tests in parts.

use std::env;
use std::ops::Range;

/// Names the part of each long test that is run, as `2/5`: the second of five. Without it all is run.
const VARIABLE: &str = "STOSSZAHL_PART";

/// Which of so many things this part has: parts are of equal length, but for one, and together have each thing once.
pub fn part_of(count: usize) -> Range<usize> {
    match env::var(VARIABLE) {
        Ok(text) => part(&text, count).unwrap_or_else(|| {
            panic!("{VARIABLE}={text}: expected K/N with K from 1 to N, as 2/5");
        }),
        Err(_) => 0..count,
    }
}

fn part(text: &str, count: usize) -> Option<Range<usize>> {
    let (number, all) = text.split_once('/')?;
    let (number, all): (usize, usize) = (number.parse().ok()?, all.parse().ok()?);
    let start = |number: usize| number * count / all;
    (1..=all)
        .contains(&number)
        .then(|| start(number - 1)..start(number))
}
