//! Observer of the impact parameters of a whole run, for programs that use the engines directly.

use stosszahl_model::{Collision, Observer};

/// Observer of impact parameters. Under molecular chaos b/d is uniform in the plane, and P = 2 b/d
/// in space, where its square is uniform: the chance that a collision is more central, `u =
/// (b/d)^(D-1)`, is uniform in both.
#[derive(Clone, Debug, PartialEq)]
pub struct ImpactParameters {
    dimension: i32,
    bins: Vec<u64>,
    collisions: u64,
    sum: f64,
    squares: f64,
}

impl Default for ImpactParameters {
    /// Creates an observer with twenty bins for two dimensions.
    fn default() -> Self {
        Self::new(2, 20)
    }
}

impl ImpactParameters {
    /// Creates an observer with `bins` bins of equal width, for 2 or 3 dimensions.
    pub fn new(dimension: usize, bins: usize) -> Self {
        Self {
            dimension: dimension as i32,
            bins: vec![0; bins.max(1)],
            collisions: 0,
            sum: 0.0,
            squares: 0.0,
        }
    }

    /// Returns the number of pair collisions observed.
    pub fn collisions(&self) -> u64 {
        self.collisions
    }

    /// Computes the probability density of u = (b/d)^(D-1) in each bin; 1 under molecular chaos.
    pub fn densities(&self) -> Vec<f64> {
        let each = self.collisions.max(1) as f64 / self.bins.len() as f64;
        self.bins.iter().map(|&count| count as f64 / each).collect()
    }

    /// Computes the slope s of the least-squares line P(u) = 1 + s (u - 1/2), s = 12 (`<u>` - 1/2):
    /// positive where grazing collisions are in excess. `None` without collisions.
    pub fn slope(&self) -> Option<f64> {
        (self.collisions > 0).then(|| 12.0 * (self.sum / self.collisions as f64 - 0.5))
    }

    /// Computes the standard error that [`Self::slope`] has if collisions are independent;
    /// collisions of one clustered gas are not.
    pub fn slope_error(&self) -> Option<f64> {
        let count = self.collisions as f64;
        let mean = self.sum / count;
        let variance = (self.squares / count - mean * mean).max(0.0);
        (self.collisions > 0).then(|| 12.0 * (variance / count).sqrt())
    }
}

impl Observer for ImpactParameters {
    fn on_collisions(&mut self, batch: &[Collision]) {
        for collision in batch {
            let u = collision.impact_square().sqrt().powi(self.dimension - 1);
            let bin = (u * self.bins.len() as f64) as usize;
            let last = self.bins.len() - 1;
            self.bins[bin.min(last)] += 1;
            self.collisions += 1;
            self.sum += u;
            self.squares += u * u;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Vector3, vector};

    fn collision(impact: f64) -> Collision {
        let relative = vector![-(1.0 - impact * impact).sqrt(), impact, 0.0];
        Collision::at_contact(relative, Vector3::x(), 0.5, 1.0)
    }

    #[test]
    fn slope_of_two_collisions_by_hand() {
        let mut impact = ImpactParameters::new(2, 4);
        assert_eq!(impact.slope(), None);
        Observer::on_collisions(&mut impact, &[collision(0.6), collision(0.8)]);
        let slope = impact.slope().expect("collisions");
        // Two roundings of numbers of order one, times 12.
        assert!((slope - 12.0 * 0.2).abs() < 1e-14);
        let error = impact.slope_error().expect("collisions");
        assert!((error - 12.0 * 0.1 / 2.0_f64.sqrt()).abs() < 1e-14);
        assert_eq!(impact.densities(), [0.0, 0.0, 2.0, 2.0]);
        let mut spheres = ImpactParameters::new(3, 4);
        Observer::on_collisions(&mut spheres, &[collision(0.6)]);
        assert_eq!(spheres.densities(), [0.0, 4.0, 0.0, 0.0]);
    }
}
