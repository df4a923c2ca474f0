//! Obstacles as the model has them.

use nalgebra::{Vector2, vector};
use stosszahl_model::walls::{Obstacle, ObstacleError, Outline};

use super::case::{self, Flow};
use super::plan::rebound;

/// An obstacle that is none.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("[[obstacle]] number {number}: {source}")]
pub struct BadObstacle {
    /// Which, from 1.
    pub number: usize,
    /// Why.
    pub source: Box<ObstacleError>,
}

/// The obstacles of a case.
///
/// # Errors
/// [`BadObstacle`] names the one that has no meaning, or does not stand in the box.
pub fn of(flow: &Flow) -> Result<Vec<Obstacle>, BadObstacle> {
    let size = vector![flow.domain.size[0], flow.domain.size[1]];
    let one = |(index, written): (usize, &case::Obstacle)| {
        let failed = |source| BadObstacle {
            number: index + 1,
            source: Box::new(source),
        };
        let law = rebound(written.restitution, written.slip, written.temperature);
        let obstacle = Obstacle::new(outline(written), law).map_err(failed)?;
        obstacle.check_inside(size).map_err(failed)?;
        Ok(obstacle)
    };
    flow.obstacle.iter().enumerate().map(one).collect()
}

/// The one shape that is given.
fn outline(written: &case::Obstacle) -> Outline {
    let points = |list: &[[f64; 2]]| -> Vec<Vector2<f64>> {
        list.iter().map(|&point| point.into()).collect()
    };
    match (&written.disc, &written.polyline, &written.polygon) {
        (Some(disc), _, _) => Outline::Disc {
            centre: disc.centre.into(),
            radius: disc.radius,
        },
        (_, Some(list), _) => Outline::Polyline {
            points: points(list),
        },
        (_, _, list) => Outline::Polygon {
            points: points(list.as_deref().unwrap_or_default()),
        },
    }
}
