//! Units of the numbers in messages.

/// Units of a case, each as the size of one engine unit. Errors of engines are reported in these
/// units.
///
/// ```
/// use stosszahl_model::MessageUnits;
///
/// let millimetres = MessageUnits { length: 1e-3, time: 1.0, speed: 1e-3 };
/// assert_eq!(millimetres.scale_position([2.0, 500.0]), [0.002, 0.5]);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MessageUnits {
    /// Engine unit of length, in lengths of the case.
    pub length: f64,
    /// Engine unit of time, in units of time of the case.
    pub time: f64,
    /// Engine unit of speed, in speeds of the case.
    pub speed: f64,
}

impl MessageUnits {
    /// Scales the coordinates of a point \[length\].
    #[must_use]
    pub fn scale_position<const D: usize>(&self, place: [f64; D]) -> [f64; D] {
        place.map(|coordinate| coordinate * self.length)
    }
}
