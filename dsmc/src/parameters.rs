//! The numerical choices of a run, and why an engine cannot start.

use serde::{Deserialize, Serialize};
use stosszahl_model::{Domain, Space};

use crate::density::Scheme;

/// Numerical choices of a run. All of them buy accuracy or speed; none is physics.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Parameters {
    /// How density raises the collision rate.
    pub scheme: Scheme,
    /// Whether partners are displaced by one contact distance along the transferred momentum.
    pub displacement: bool,
    /// Smallest side of a cell \[length\]; `None`: half a mean free path, but at least two diameters.
    pub cell_size: Option<f64>,
    /// Simulators for each particle.
    pub simulators_per_disk: u32,
    /// Steps in which the fastest simulator crosses a cell, and in which a mean free time passes.
    pub steps_per_crossing: f64,
    /// Limit on chi.
    pub largest_contact_value: f64,
}

impl Parameters {
    pub(crate) fn check(&self) -> Result<(), EngineError> {
        let check = |name, value: f64, good: bool, allowed| {
            if good {
                Ok(())
            } else {
                Err(EngineError::BadParameter {
                    name,
                    value,
                    allowed,
                })
            }
        };
        let copies = f64::from(self.simulators_per_disk);
        check("simulators_per_disk", copies, copies >= 1.0, "at least 1")?;
        let steps = self.steps_per_crossing;
        check(
            "steps_per_crossing",
            steps,
            (1.0..=1e6).contains(&steps),
            "from 1 to 1e6",
        )?;
        let limit = self.largest_contact_value;
        check(
            "largest_contact_value",
            limit,
            (1.0..=1e9).contains(&limit),
            "from 1 to 1e9",
        )?;
        if let Some(size) = self.cell_size {
            check(
                "cell_size",
                size,
                size > 0.0 && size.is_finite(),
                "above zero",
            )?;
        }
        Ok(())
    }

    /// Mean free path at a packing fraction, by the scheme's own collision rate \[length\].
    pub fn mean_free_path<S: Space>(&self, packing_fraction: f64, diameter: f64) -> f64 {
        let chi = self
            .scheme
            .contact_value::<S>(packing_fraction)
            .min(self.largest_contact_value);
        diameter * S::mean_free_path(packing_fraction.max(1e-12), chi)
    }

    /// Number of cells along each axis of a box: as many as fit at the chosen size; one beyond the dimension.
    pub fn cells<S: Space>(
        &self,
        domain: &Domain<S>,
        packing_fraction: f64,
        diameter: f64,
    ) -> [usize; 3] {
        let automatic =
            || (0.5 * self.mean_free_path::<S>(packing_fraction, diameter)).max(2.0 * diameter);
        let side = self.cell_size.unwrap_or_else(automatic);
        // At most 2^26 cells in all: where more would fit, nearly all would be empty.
        let most = if S::DIMENSION == 2 { 8192 } else { 406 };
        [0, 1, 2].map(|axis| {
            if axis < S::DIMENSION {
                ((domain.lengths()[axis] / side * (1.0 + 1e-12)) as usize).clamp(1, most)
            } else {
                1
            }
        })
    }
}

/// Why the engine could not start.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum EngineError {
    /// A parameter has no meaning.
    #[error("{name} = {value}; allowed: {allowed}")]
    BadParameter {
        /// Which.
        name: &'static str,
        /// What was found.
        value: f64,
        /// What is allowed.
        allowed: &'static str,
    },
    /// A position or velocity is no finite number, or too large to be squared.
    #[error(
        "simulator {simulator} has position {position:?} and velocity {velocity:?}; allowed are finite numbers up to 1e150"
    )]
    BadNumber {
        /// Index.
        simulator: usize,
        /// Position.
        position: Vec<f64>,
        /// Velocity.
        velocity: Vec<f64>,
    },
}
