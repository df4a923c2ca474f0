//! Units of the numbers in error messages: conversion from engine units to the units of a case.

/// Units of a case, in which errors of engines are reported: each is the size of one engine unit.
///
/// ```
/// use stosszahl_model::MessageUnits;
///
/// let millimetres = MessageUnits { length: 1e-3, time: 1.0, speed: 1e-3 };
/// assert_eq!(millimetres.scale_position([2.0, 500.0]), [0.002, 0.5]);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MessageUnits {
    /// Engine unit of length, in the case's unit of length.
    pub length: f64,
    /// Engine unit of time, in the case's unit of time.
    pub time: f64,
    /// Engine unit of speed, in the case's unit of speed.
    pub speed: f64,
}

impl MessageUnits {
    /// Converts the coordinates of a position from engine units to the units of the case.
    #[must_use]
    pub fn scale_position<const D: usize>(&self, place: [f64; D]) -> [f64; D] {
        place.map(|coordinate| coordinate * self.length)
    }
}
