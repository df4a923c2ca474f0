//! Contact times of a particle in straight or parabolic flight with a plane wall, at rest or
//! vibrating, in closed form.

use super::vibration::Vibration;

/// Returns the time until a point at `height` above a plane, with the given velocity and
/// acceleration away from it, reaches the plane; `None` if it never does.
///
/// The earliest t >= 0 with h + v t + a t^2/2 = 0 at which the point is not going up, from the form
/// of the root that loses no digits. A point that has just been thrown up from the plane (h = 0 to
/// rounding, v > 0) returns after 2 v/|a|, to rounding also where that is tiny; one that is on or,
/// by rounding, below the plane and falls is there at once.
///
/// ```
/// use stosszahl_model::walls::flight::time_to_plane;
/// assert_eq!(time_to_plane(6.0, -2.0, 0.0), Some(3.0));
/// assert_eq!(time_to_plane(0.0, 3.0, -2.0), Some(3.0));
/// assert_eq!(time_to_plane(1.0, 1.0, 0.0), None);
/// assert_eq!(time_to_plane(0.0, -1.0, -2.0), Some(0.0));
/// ```
#[inline]
pub fn time_to_plane(height: f64, velocity: f64, acceleration: f64) -> Option<f64> {
    let falls = velocity < 0.0 || (velocity == 0.0 && acceleration < 0.0);
    if height <= 0.0 && falls {
        return Some(0.0);
    }
    if acceleration == 0.0 {
        return (velocity < 0.0).then(|| -height / velocity);
    }
    let discriminant = velocity * velocity - 2.0 * acceleration * height;
    if acceleration < 0.0 {
        // A point below the plane by rounding returns as from the plane.
        let root = discriminant.max(0.0).sqrt();
        return Some(if velocity >= 0.0 {
            (velocity + root) / -acceleration
        } else {
            2.0 * height / (root - velocity)
        });
    }
    (velocity < 0.0 && discriminant >= 0.0).then(|| 2.0 * height / (discriminant.sqrt() - velocity))
}

/// Returns the time until a point reaches a vibrating wall whose rest position is `height` below
/// it, at the time `now`; `None` if it never does, or not before `limit`.
///
/// The wall moves at a constant velocity between two turns, so that each of these intervals is a
/// case of [`time_to_plane`]; intervals in which the point is beyond the reach of the wall are left
/// out.
pub fn time_to_vibrating_plane(
    height: f64,
    velocity: f64,
    acceleration: f64,
    vibration: &Vibration,
    now: f64,
    limit: f64,
) -> Option<f64> {
    // Limit for a point that stays at its height, to which all periods are alike.
    let limit = if velocity == 0.0 && acceleration == 0.0 {
        limit.min(1.5 * vibration.period())
    } else {
        limit
    };
    let mut waited = 0.0;
    let mut within_reach = false;
    while waited < limit {
        let speed = velocity + acceleration * waited;
        let above = height + (velocity + 0.5 * acceleration * waited) * waited;
        // Within reach from the found time on, also where by rounding the point seems to be above.
        if above > vibration.amplitude() && !within_reach {
            waited += time_to_plane(above - vibration.amplitude(), speed, acceleration)?;
            within_reach = true;
            continue;
        }
        within_reach = false;
        let time = now + waited;
        let turn = vibration.next_turn(time);
        let gap = above - vibration.displacement(time);
        let closing = speed - vibration.velocity(time);
        if let Some(wait) = time_to_plane(gap, closing, acceleration)
            && wait <= turn - time
        {
            return (waited + wait < limit).then_some(waited + wait);
        }
        waited = (turn - now).max(waited.next_up());
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_xoshiro::Xoshiro256PlusPlus;

    /// The height at the time found is zero to rounding of its terms, and nowhere before: sampled
    /// at a thousand times.
    #[test]
    fn the_plane_is_reached_first_then() {
        let mut stream = Xoshiro256PlusPlus::seed_from_u64(8);
        let mut number = |low: f64, high: f64| stream.random_range(low..high);
        let mut found = 0;
        for _ in 0..5000 {
            let (h, v, a) = (
                10.0_f64.powf(number(-12.0, 1.0)),
                number(-1.0, 1.0),
                number(-1.0, 1.0),
            );
            let at = |t: f64| h + v * t + 0.5 * a * t * t;
            let end = time_to_plane(h, v, a);
            if let Some(t) = end {
                found += 1;
                let scale = h + v.abs() * t + 0.5 * a.abs() * t * t;
                assert!(
                    at(t).abs() <= 8.0 * f64::EPSILON * scale,
                    "{h} {v} {a}: {t}"
                );
            }
            for step in 1..1000 {
                let t = f64::from(step) * 0.001 * end.unwrap_or(100.0);
                assert!(at(t) > -4e-16 * (h + v.abs() * t), "{h} {v} {a}: {t}");
            }
        }
        assert!(found > 2000);
    }

    /// A throw from the plane comes back after 2 v/g, at speeds down to 1e-150, and a grazing one
    /// is not lost.
    #[test]
    fn returns_are_exact_also_when_tiny() {
        for exponent in [0, -12, -100, -150] {
            let v = 10.0_f64.powi(exponent);
            for height in [0.0, 1e-18 * v * v, -1e-18 * v * v] {
                let t = time_to_plane(height, v, -2.0).expect("comes back");
                assert!((t / v - 1.0).abs() < 1e-15);
            }
        }
        assert_eq!(time_to_plane(0.0, 0.0, 0.0), None);
        assert_eq!(time_to_plane(0.0, 0.0, -1.0), Some(0.0));
        assert_eq!(time_to_plane(0.0, 1e-12, 0.0), None);
    }

    /// A vibrating plane is reached at the time that a search in steps of a thousandth of a period
    /// finds.
    #[test]
    fn a_vibrating_plane_is_reached_first_then() {
        let mut stream = Xoshiro256PlusPlus::seed_from_u64(9);
        let vibration = Vibration::new(0.3, 1.7).expect("a vibration");
        let mut found = 0;
        for round in 0..2000 {
            let mut number = |low: f64, high: f64| stream.random_range(low..high);
            let (now, v) = (number(0.0, 5.0), number(-1.0, 1.0));
            let a = if round % 2 == 0 {
                number(-1.0, 0.0)
            } else {
                0.0
            };
            let h = vibration.displacement(now) + number(1e-3, 1.0);
            let gap = |t: f64| h + v * t + 0.5 * a * t * t - vibration.displacement(now + t);
            let end = time_to_vibrating_plane(h, v, a, &vibration, now, 20.0);
            let mut t = 0.0;
            let step = 1.7e-3;
            while t < end.unwrap_or(20.0) - step {
                assert!(gap(t) > -1e-12, "{round}: {end:?} {t} {}", gap(t));
                t += step;
            }
            if let Some(t) = end {
                found += 1;
                assert!(gap(t).abs() < 1e-13, "{round}: {}", gap(t));
            }
        }
        assert!(found > 1000);
        // Departure faster than the wall: a return after some time, or never.
        let away = time_to_vibrating_plane(0.4, 0.3, 0.0, &vibration, 0.9, f64::INFINITY);
        assert_eq!(away, None);
        // At rest at the height of the turn, the wall touches there or not at all; at the smallest
        // speed it touches once there.
        for height in [0.3, 0.3 * (1.0 + 1e-15), 0.3 * (1.0 - 1e-15)] {
            time_to_vibrating_plane(height, 0.0, 0.0, &vibration, 0.1, f64::INFINITY);
            let slow = time_to_vibrating_plane(height, -1e-20, 0.0, &vibration, 0.1, f64::INFINITY);
            assert!(slow.is_some_and(|time| time < 1e6), "{slow:?}");
        }
        assert_eq!(
            time_to_vibrating_plane(0.31, 0.0, 0.0, &vibration, 0.1, f64::INFINITY),
            None
        );
        let within = time_to_vibrating_plane(0.29, 0.3, 0.0, &vibration, 0.9, f64::INFINITY);
        assert_eq!(within, None);
    }
}
