//! Minimum and maximum in one instruction.

/// Larger of two numbers in one instruction; unlike `f64::max`, without special care for NaN.
#[inline(always)]
pub(crate) fn larger(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

/// Smaller of two numbers in one instruction, without special care for NaN.
#[inline(always)]
pub(crate) fn smaller(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}
