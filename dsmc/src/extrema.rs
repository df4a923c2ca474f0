//! Minimum and maximum of two numbers as single processor instructions, without the NaN rules of
//! the standard library.

/// Returns the larger of two numbers in one instruction; unlike `f64::max`, without special care
/// for NaN.
#[inline(always)]
pub(crate) fn larger(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

/// Returns the smaller of two numbers in one instruction; unlike `f64::min`, without special care
/// for NaN.
#[inline(always)]
pub(crate) fn smaller(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}
