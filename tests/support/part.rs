//! Long tests in parts.

use std::env;
use std::ops::Range;

/// Name of the variable that selects the part of each long test, as `2/5`: the second of five.
/// Without it all parts are run.
const VARIABLE: &str = "STOSSZAHL_PART";

/// Returns the indices below `count` of this part: parts are of equal length, up to one, and
/// together have each index once.
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
