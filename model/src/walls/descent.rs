//! Root finding for contacts in parabolic flight: times at which a function first falls through
//! zero.

use std::ops::Range;

/// Largest number of steps of a root search; a bracket that is at least halved each time has all
/// its digits by then.
const MOST_STEPS: usize = 200;

/// Returns the time at which h + w t + a t^2/2 falls through zero; `None` if it never falls through
/// it. Negative where that was before.
///
/// A parabola falls through zero at one of its two roots only, (-w - sqrt(w^2 - 2 a h))/a, taken in
/// the form that loses no digits.
#[inline]
pub(super) fn of_parabola(height: f64, speed: f64, acceleration: f64) -> Option<f64> {
    if acceleration == 0.0 {
        return (speed < 0.0).then(|| -height / speed);
    }
    let discriminant = speed * speed - 2.0 * acceleration * height;
    if discriminant < 0.0 {
        return None;
    }
    let root = discriminant.sqrt();
    if speed < 0.0 {
        Some(2.0 * height / (root - speed))
    } else {
        (acceleration < 0.0).then(|| (speed + root) / -acceleration)
    }
}

/// Returns the turning points of a function inside an interval: where its slope is zero. `turns`
/// are the turning points of the slope, in order; between two of them the slope has at most one
/// root, which is bracketed and cannot be lost. `slope` returns the slope and its derivative.
pub(super) fn turning_points(
    slope: impl Fn(f64) -> (f64, f64),
    turns: &[f64],
    within: &Range<f64>,
) -> Vec<f64> {
    let inside = |turn: &&f64| **turn > within.start && **turn < within.end;
    let mut found = Vec::with_capacity(turns.len() + 1);
    let mut begin = within.start;
    for &end in turns.iter().filter(inside).chain([&within.end]) {
        let ends = [slope(begin).0, slope(end).0];
        if (ends[0] < 0.0) != (ends[1] < 0.0) {
            found.push(bracketed(&slope, begin..end));
        }
        begin = end;
    }
    found
}

/// Returns the root of a function that is monotonic in an interval and has different signs at its
/// ends, by Newton's steps, or bisection where these leave it or do not come closer. `function`
/// returns the value and its slope.
pub(super) fn bracketed(function: impl Fn(f64) -> (f64, f64), within: Range<f64>) -> f64 {
    let (mut low, mut high) = (within.start, within.end);
    let rises = function(low).0 < 0.0;
    let mut time = 0.5 * (low + high);
    let mut before = high - low;
    for _ in 0..MOST_STEPS {
        let (value, slope) = function(time);
        if value == 0.0 {
            return time;
        }
        if (value < 0.0) == rises {
            low = time;
        } else {
            high = time;
        }
        let newton = time - value / slope;
        let next = if newton > low && newton < high && 2.0 * (newton - time).abs() <= before {
            newton
        } else {
            0.5 * (low + high)
        };
        before = (next - time).abs();
        if before <= f64::EPSILON * next.abs() {
            return next;
        }
        time = next;
    }
    time
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_parabola_falls_through_zero_once() {
        assert_eq!(of_parabola(6.0, -2.0, 0.0), Some(3.0));
        // Rises above zero at 1 and falls back at 3.
        assert_eq!(of_parabola(-3.0, 4.0, -2.0), Some(3.0));
        // Falls at 1 and rises again at 3.
        assert_eq!(of_parabola(3.0, -4.0, 2.0), Some(1.0));
        assert_eq!(of_parabola(-3.0, -4.0, -2.0), Some(-1.0));
        assert_eq!(of_parabola(1.0, 1.0, 0.0), None);
        assert_eq!(of_parabola(-3.0, 3.0, -2.0), None);
        assert_eq!(of_parabola(0.0, 1.0, 2.0), None);
    }

    /// (t - 1)(t - 2)(t - 3)(t - 4): all turning points, and each root between them.
    #[test]
    fn roots_of_a_quartic_are_bracketed() {
        let value = |t: f64| (t - 1.0) * (t - 2.0) * (t - 3.0) * (t - 4.0);
        let slope = |t: f64| ((4.0 * t - 30.0) * t + 70.0) * t - 50.0;
        let bend = |t: f64| (12.0 * t - 60.0) * t + 70.0;
        let third = 2.5 - (5.0_f64 / 12.0).sqrt();
        let turns = turning_points(|t| (slope(t), bend(t)), &[third, 5.0 - third], &(0.0..10.0));
        assert_eq!(turns.len(), 3);
        for turn in &turns {
            assert!(slope(*turn).abs() < 1e-12);
        }
        let ends = [0.0, turns[0], turns[1], turns[2], 10.0];
        for (number, pair) in ends.windows(2).enumerate() {
            let root = bracketed(|t| (value(t), slope(t)), pair[0]..pair[1]);
            assert!((root - (number + 1) as f64).abs() < 1e-14, "{root}");
        }
    }
}
