//! Initial states: where the bodies are, how fast they move, and the check that none overlap.
//!
//! A disordered start is made by random sequential addition up to [`SEQUENTIAL_LIMIT`]; above, a
//! hexagonal lattice with randomly placed vacancies is returned as a start to be *melted* by elastic
//! dynamics, and says so. Compression of a dilute start lost: it needs an engine of its own, and its
//! jams must be melted too.

mod file;
mod lattice;
mod overlap;
mod sequential;
mod velocities;

pub use file::{FileError, StartFile, read};
pub use lattice::{Lattice, hexagonal, square};
pub use overlap::{Overlap, first_overlap};
pub use sequential::{SEQUENTIAL_LIMIT, sequential_addition, sequential_addition_of};
pub use velocities::{maxwellian, rescale, thermal_spins};

use nalgebra::Vector2;

use crate::domain::Domain;
use crate::random::{Purpose, Streams};
use crate::space::Plane;

/// Which arrangement was requested.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Arrangement {
    /// No order.
    Disordered,
    /// Square lattice.
    Square,
    /// Hexagonal lattice.
    Hexagonal,
}

/// Positions, and the lattice they came from if they did.
#[derive(Clone, Debug)]
pub struct Placement {
    /// Centres of the disks.
    pub positions: Vec<Vector2<f64>>,
    /// Reciprocal vectors whose Bragg peaks show whether the lattice is forgotten; empty without one.
    pub reciprocal: Vec<[i32; 2]>,
}

/// Why disks could not be placed.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PlacementError {
    /// Disks of several sizes do not fit.
    #[error(
        "{count} disks of several sizes do not fit into a box of {:.6} x {:.6} when placed at random one by one, the large \
         ones first; a lower packing fraction or a larger box may do",
        lengths[0], lengths[1]
    )]
    Jammed {
        /// Number of disks.
        count: usize,
        /// Box.
        lengths: [f64; 2],
    },
    /// The lattice that fits into the box is too tight.
    #[error(
        "{count} disks of diameter {diameter} do not fit as a {lattice} lattice into a box of {:.6} x {:.6}: \
         the closest lattice sites are {spacing:.6} apart; allowed at this number and box: packing fractions up to {allowed:.4}",
        lengths[0], lengths[1]
    )]
    TooDense {
        /// `square` or `hexagonal`.
        lattice: &'static str,
        /// Number of disks.
        count: usize,
        /// Their diameter.
        diameter: f64,
        /// Box.
        lengths: [f64; 2],
        /// Shortest distance of two sites.
        spacing: f64,
        /// Largest packing fraction that this lattice holds.
        allowed: f64,
    },
}

/// Places disks of the given radii at random in a periodic box.
///
/// # Errors
/// [`PlacementError::Jammed`] if one finds no place.
pub fn place_unlike(
    radii: &[f64],
    domain: &Domain<Plane>,
    streams: &Streams,
) -> Result<Placement, PlacementError> {
    let mut stream = streams.at(Purpose::Placement, [0, 0]);
    let positions =
        sequential_addition_of(radii, domain, &mut stream).ok_or(PlacementError::Jammed {
            count: radii.len(),
            lengths: domain.lengths().into(),
        })?;
    Ok(Placement {
        positions,
        reciprocal: Vec::new(),
    })
}

/// Places equal disks in a periodic box.
///
/// # Errors
/// [`PlacementError::TooDense`] if a lattice of that many disks does not fit.
pub fn place(
    arrangement: Arrangement,
    count: usize,
    diameter: f64,
    domain: &Domain<Plane>,
    streams: &Streams,
) -> Result<Placement, PlacementError> {
    let mut stream = streams.at(Purpose::Placement, [0, 0]);
    let packing =
        count as f64 * std::f64::consts::FRAC_PI_4 * diameter * diameter / domain.volume();
    let lattice = match arrangement {
        Arrangement::Disordered if packing <= SEQUENTIAL_LIMIT => {
            if let Some(positions) = sequential_addition(count, diameter, domain, &mut stream) {
                return Ok(Placement {
                    positions,
                    reciprocal: Vec::new(),
                });
            }
            hexagonal(count, domain)
        }
        Arrangement::Disordered | Arrangement::Hexagonal => hexagonal(count, domain),
        Arrangement::Square => square(count, domain),
    };
    lattice.occupy(count, diameter, domain, &mut stream)
}
