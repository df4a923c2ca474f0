//! Trajectories of some particles of a gas without positions, and time-averaged mean squared
//! displacements along them.

use serde::{Deserialize, Serialize};
use stosszahl_model::{ParticleModel, Vector, VectorOf};

use super::motion::PathRecord;

/// Trajectories of chosen particles, as the corners at their collisions: exact, as particles fly
/// straight in between.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(bound = "")]
pub struct Trajectories<P: ParticleModel> {
    /// Index of the trajectory of each particle; the largest `u32` for particles without one.
    path_of: Vec<u32>,
    corners: Vec<Vec<(f64, VectorOf<P>)>>,
}

impl<P: ParticleModel> Trajectories<P> {
    /// Creates trajectories of the `chosen` particles out of `count`, all starting at the origin at
    /// `time`.
    pub fn new(count: usize, chosen: &[u32], time: f64) -> Self {
        let mut path_of = vec![u32::MAX; count];
        for (path, &index) in chosen.iter().enumerate() {
            if let Some(slot) = path_of.get_mut(index as usize) {
                *slot = path as u32;
            }
        }
        Self {
            path_of,
            corners: vec![vec![(time, VectorOf::<P>::default())]; chosen.len()],
        }
    }

    /// Returns the index of the trajectory of a particle; `None` if it has none.
    pub fn path_of(&self, particle: u32) -> Option<usize> {
        let path = *self.path_of.get(particle as usize)?;
        (path != u32::MAX).then_some(path as usize)
    }

    /// Returns the corners of a trajectory so far, the start and each collision, as time and
    /// displacement.
    pub fn corners(&self, path: usize) -> &[(f64, VectorOf<P>)] {
        self.corners.get(path).map_or(&[], Vec::as_slice)
    }
}

impl<P: ParticleModel> PathRecord<P> for Trajectories<P> {
    fn is_tracked(&self) -> bool {
        true
    }

    #[inline]
    fn record_flight(&mut self, index: u32, velocity: &VectorOf<P>, time: f64) {
        let path = self.path_of[index as usize];
        if path == u32::MAX {
            return;
        }
        let corners = &mut self.corners[path as usize];
        if let Some(&(since, place)) = corners.last() {
            corners.push((time, place + *velocity * (time - since)));
        }
    }
    fn memory_bytes(&self) -> usize {
        self.path_of.capacity() * size_of::<u32>()
            + self
                .corners
                .iter()
                .map(|corners| corners.capacity() * size_of::<(f64, VectorOf<P>)>())
                .sum::<usize>()
    }
}

/// Computes the time-averaged mean squared displacement along one trajectory over a lag
/// \[length^2\], averaged over all start times that fit: `(1/(t - lag)) integral <(R(s + lag) -
/// R(s))^2> ds`. `corners` must include the end of the trajectory.
///
/// Between two corners of either end the integrand is quadratic, so Simpson's rule on each piece is
/// exact. Two pointers run along the path: the cost is the number of corners. Zero if the lag does
/// not fit.
pub fn time_averaged<V: Vector>(corners: &[(f64, V)], lag: f64) -> f64 {
    let (Some(first), Some(last)) = (corners.first(), corners.last()) else {
        return 0.0;
    };
    let end = last.0 - lag;
    if !(end > first.0 && lag > 0.0) {
        return 0.0;
    }
    let mut tail = Walker { corners, leg: 0 };
    let mut head = Walker { corners, leg: 0 };
    let mut sum = 0.0;
    let mut now = first.0;
    while now < end {
        tail.seek(now);
        head.seek(now + lag);
        let next = tail.leg_end().min(head.leg_end() - lag).min(end);
        // Legs shorter than rounding must not stop the clock.
        let next = if next > now { next } else { now.next_up() };
        let square = |s: f64| (head.position_at(s + lag) - tail.position_at(s)).square();
        let middle = 0.5 * (now + next);
        sum += (next - now) / 6.0 * (square(now) + 4.0 * square(middle) + square(next));
        now = next;
    }
    sum / (end - first.0)
}

/// Pointer to a straight segment of a trajectory, which advances with time.
struct Walker<'a, V> {
    corners: &'a [(f64, V)],
    leg: usize,
}

impl<V: Vector> Walker<'_, V> {
    /// Advances to the straight segment of the trajectory that contains a time.
    fn seek(&mut self, time: f64) {
        while self.leg + 2 < self.corners.len() && self.corners[self.leg + 1].0 <= time {
            self.leg += 1;
        }
    }

    fn leg_end(&self) -> f64 {
        self.corners[self.leg + 1].0
    }

    fn position_at(&self, time: f64) -> V {
        let (begin, from) = self.corners[self.leg];
        let (end, to) = self.corners[self.leg + 1];
        let span = end - begin;
        if span > 0.0 {
            from + (to - from) * ((time - begin) / span)
        } else {
            from
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Vector2, vector};

    /// Time averages agree with a plain sum over 1e5 starts on a path with uneven legs; the sum is
    /// a midpoint rule, off by some 1e-9.
    #[test]
    fn time_averages_are_sums_over_starts() {
        let corners = [
            (0.0, vector![0.0, 0.0]),
            (0.3, vector![1.0, 0.0]),
            (0.3, vector![1.0, 0.0]),
            (1.1, vector![0.5, 2.0]),
            (4.0, vector![-1.0, 2.5]),
            (5.0, vector![3.0, 0.0]),
        ];
        let at = |time: f64| -> Vector2<f64> {
            let leg = corners
                .windows(2)
                .find(|leg| leg[1].0 > leg[0].0 && time <= leg[1].0)
                .unwrap_or(&corners[4..6]);
            leg[0].1 + (leg[1].1 - leg[0].1) * ((time - leg[0].0) / (leg[1].0 - leg[0].0))
        };
        for lag in [0.01, 0.5, 2.0, 4.9] {
            let starts = 100_000;
            let span = 5.0 - lag;
            let sum: f64 = (0..starts)
                .map(|start| {
                    let s = span * (f64::from(start) + 0.5) / f64::from(starts);
                    (at(s + lag) - at(s)).norm_squared()
                })
                .sum();
            let plain = sum / f64::from(starts);
            let found = time_averaged(&corners, lag);
            assert!(
                (found / plain - 1.0).abs() < 1e-7,
                "lag {lag}: {found} {plain}"
            );
        }
        assert_eq!(time_averaged(&corners, 5.0), 0.0);
        assert_eq!(time_averaged::<Vector2<f64>>(&[], 1.0), 0.0);
    }
}
