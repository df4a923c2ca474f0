//! Free volume that obstacles leave to the gas, of the whole box and of each cell of a grid, by
//! numerical integration.

use stosszahl_case::Case;
use stosszahl_case::format::FaceSpec;
use stosszahl_dsmc::WallClearance;
use stosszahl_model::walls::FreeArea;

use super::boundaries;
use super::data::{CasePlan, EnginePlan, PlanError};
use super::engines;
use super::region::Region;

/// Largest number of iterations in which diameters are fitted to a mean free path.
const STEPS: usize = 200;

/// Computes the free volume of a box \[length^D\]: where centres of particles of a mean radius can
/// be, as far from obstacles as the engines keep them. Without obstacles it is the volume of the
/// box.
///
/// # Errors
/// [`PlanError`] names the invalid obstacle.
pub(super) fn free_volume(
    case: &Case,
    lengths: &[f64; 3],
    mean_radius: f64,
) -> Result<f64, PlanError> {
    let clearance = match engines::widest_clearance(case) {
        WallClearance::Centre => 0.0,
        WallClearance::Radius => mean_radius,
    };
    uncovered_volume(case, lengths, clearance)
}

/// Computes the volume of the part of a box that is at least `clearance` away from obstacles
/// \[length^D\].
///
/// # Errors
/// [`PlanError`] names the invalid obstacle.
pub(super) fn uncovered_volume(
    case: &Case,
    lengths: &[f64; 3],
    clearance: f64,
) -> Result<f64, PlanError> {
    let dimension = case.gas.dimension as usize;
    let all = lengths[..dimension].iter().product();
    let obstacles = boundaries::obstacles(case)?;
    if obstacles.is_empty() {
        return Ok(all);
    }
    // Obstacles are for disks, so that this is all of the volume.
    let [x, y, _] = *lengths;
    let area = FreeArea::new(&obstacles, [x, y], periodic(case), clearance);
    let free = area.rectangle_between([0.0; 2], [x, y]);
    let allowed = "obstacles that leave room for the gas";
    PlanError::require(free > 1e-9 * all, "obstacle", "no free area", allowed)?;
    Ok(free)
}

/// Computes the area that obstacles cover \[length^2\], also beyond the box.
///
/// # Errors
/// [`PlanError`] names the invalid obstacle.
pub(super) fn covered_area(case: &Case) -> Result<f64, PlanError> {
    let obstacles = boundaries::obstacles(case)?;
    let corner = (obstacles.iter()).fold([0.0; 2], |corner: [f64; 2], obstacle| {
        let most = obstacle.bounds()[1];
        [corner[0].max(most.x), corner[1].max(most.y)]
    });
    let area = FreeArea::new(&obstacles, corner, [false; 2], 0.0);
    Ok(corner[0] * corner[1] - area.rectangle_between([0.0; 2], corner))
}

/// Solves for the factor of all radii at which a length that depends on them has the value
/// `wanted`. `found` computes that length from the factor; without obstacles it falls with the
/// power `1 / exponent` of the factor.
///
/// # Errors
/// As `found`.
pub(super) fn factor_of_radii(
    wanted: f64,
    exponent: f64,
    found: impl Fn(f64) -> Result<f64, PlanError>,
) -> Result<f64, PlanError> {
    let mut factor = 1.0;
    for _ in 0..STEPS {
        let next = factor * (found(factor)? / wanted).powf(exponent);
        if (next / factor - 1.0).abs() <= 4.0 * f64::EPSILON {
            return Ok(factor);
        }
        factor = next;
    }
    Ok(factor)
}

/// Returns true for each of the first two axes along which the box is periodic.
fn periodic(case: &Case) -> [bool; 2] {
    [0, 1].map(|axis| *case.walls.face_at(axis, 0) == FaceSpec::default())
}

impl CasePlan {
    /// Returns the volume of the box, obstacles included \[length^D\]; without a box, the volume of
    /// the gas.
    pub fn box_volume(&self) -> f64 {
        match self.gas.lengths[0] {
            0.0 => self.gas.volume,
            _ => self.gas.lengths[..self.gas.dimension].iter().product(),
        }
    }

    /// Computes the share of a region that obstacles do not cover; 0 if it is no more than
    /// rounding.
    pub(super) fn uncovered_share(&self, region: &Region) -> Result<f64, PlanError> {
        let obstacles = self.obstacles()?;
        if obstacles.is_empty() {
            return Ok(1.0);
        }
        let [low, high] = [region.low, region.high].map(|corner| [corner[0], corner[1]]);
        let sides = [self.gas.lengths[0], self.gas.lengths[1]];
        let area = FreeArea::new(&obstacles, sides, self.periodic(), 0.0);
        let share = area.rectangle_between(low, high) / ((high[0] - low[0]) * (high[1] - low[1]));
        Ok(if share > 1e-9 { share } else { 0.0 })
    }

    /// Computes, for each cell of a grid over the first two axes, the share that obstacles leave to
    /// the centres of an engine's particles. The index runs fastest along the first axis; empty
    /// without obstacles.
    pub fn free_shares(&self, engine: &EnginePlan, counts: [usize; 2]) -> Vec<f64> {
        let obstacles = self.obstacles().unwrap_or_default();
        if obstacles.is_empty() {
            return Vec::new();
        }
        let clearance = match engine.clearance {
            WallClearance::Centre => 0.0,
            WallClearance::Radius => self.mean_radius(),
        };
        let sides = [self.gas.lengths[0], self.gas.lengths[1]];
        let area = FreeArea::new(&obstacles, sides, self.periodic(), clearance);
        let edge = |axis: usize, number: usize| sides[axis] * number as f64 / counts[axis] as f64;
        let share = |row: usize, column: usize| {
            let low = [edge(0, column), edge(1, row)];
            let high = [edge(0, column + 1), edge(1, row + 1)];
            area.rectangle_between(low, high) / ((high[0] - low[0]) * (high[1] - low[1]))
        };
        (0..counts[1])
            .flat_map(|row| (0..counts[0]).map(move |column| (row, column)))
            .map(|(row, column)| share(row, column))
            .collect()
    }
}
