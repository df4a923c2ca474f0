//! Initial states: placement of particles at random or on a lattice, their velocities, files, and
//! the check for overlaps.
//!
//! A disordered start is made by random sequential addition up to [`SEQUENTIAL_LIMIT`]; above, a
//! hexagonal lattice with randomly placed vacancies is returned as a start to be *melted* by
//! elastic dynamics, and says so. Compression of a dilute start lost: it needs an engine of its
//! own, and its jams must be melted too.

mod file;
mod lattice;
mod overlap;
mod placement;
mod sequential;
mod velocities;

pub use file::{ENDINGS, FileError, StartFile, read_bytes, read_start_file};
pub use lattice::{Lattice, hexagonal, square};
pub use overlap::{Overlap, first_overlap};
pub use placement::{PlacedDisks, PlacementError};
pub use sequential::{
    AdditionError, FreeSpace, SEQUENTIAL_LIMIT, SequentialAddition, sequential_addition,
};
pub use velocities::{
    VelocityDistribution, draw_velocities, maxwellian, rescale, thermal_spins,
    visit_drawn_velocities, visit_thermal_spins,
};

use crate::domain::Domain;
use crate::interrupt::Interrupt;
use crate::random::{Purpose, Streams};
use crate::space::Plane;

/// Arrangement of the particles in an initial state: disordered, or on a lattice.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Arrangement {
    /// Random positions without order, by random sequential addition.
    Disordered,
    /// Square lattice, of rows and columns.
    Square,
    /// Hexagonal lattice, of triangles.
    Hexagonal,
}

/// Places disks of the given radii at random positions without overlap in a periodic box, by random
/// sequential addition.
///
/// # Errors
/// [`PlacementError::Jammed`] if one finds no place; [`PlacementError::Interrupted`].
pub fn place_unequal(
    radii: &[f64],
    domain: &Domain<Plane>,
    streams: &Streams,
    interrupt: &Interrupt,
) -> Result<PlacedDisks, PlacementError> {
    let mut stream = streams.stream_at(Purpose::Placement, [0, 0]);
    let positions = sequential_addition(radii, domain, &mut stream, interrupt);
    let positions = positions.map_err(|error| match error {
        AdditionError::Interrupted => PlacementError::Interrupted,
        AdditionError::Jammed { .. } => PlacementError::Jammed {
            count: radii.len(),
            lengths: domain.lengths().into(),
        },
    })?;
    Ok(PlacedDisks {
        positions,
        reciprocal: Vec::new(),
    })
}

/// Places equal disks in a periodic box without overlap, at random or on a lattice.
///
/// # Errors
/// [`PlacementError::TooDense`] if a lattice of that many disks does not fit;
/// [`PlacementError::Interrupted`].
pub fn place_disks(
    arrangement: Arrangement,
    count: usize,
    diameter: f64,
    domain: &Domain<Plane>,
    streams: &Streams,
    interrupt: &Interrupt,
) -> Result<PlacedDisks, PlacementError> {
    let mut stream = streams.stream_at(Purpose::Placement, [0, 0]);
    let packing =
        count as f64 * std::f64::consts::FRAC_PI_4 * diameter * diameter / domain.volume();
    if arrangement == Arrangement::Disordered && packing <= SEQUENTIAL_LIMIT {
        let radii = vec![0.5 * diameter; count];
        match sequential_addition(&radii, domain, &mut stream, interrupt) {
            Ok(positions) => {
                return Ok(PlacedDisks {
                    positions,
                    reciprocal: Vec::new(),
                });
            }
            Err(AdditionError::Interrupted) => return Err(PlacementError::Interrupted),
            // A lattice is left.
            Err(AdditionError::Jammed { .. }) => {}
        }
    }
    lattice(arrangement, count, domain).occupy(count, diameter, domain, &mut stream)
}

/// Checks that equal disks fit on the lattice of an arrangement; a disordered one stands for the
/// hexagonal lattice. Places no disk, so that it costs no memory.
///
/// # Errors
/// [`PlacementError::TooDense`] if they do not.
pub fn fits(
    arrangement: Arrangement,
    count: usize,
    diameter: f64,
    domain: &Domain<Plane>,
) -> Result<(), PlacementError> {
    lattice(arrangement, count, domain).holds(count, diameter, domain)
}

fn lattice(arrangement: Arrangement, count: usize, domain: &Domain<Plane>) -> Lattice {
    match arrangement {
        Arrangement::Disordered | Arrangement::Hexagonal => hexagonal(count, domain),
        Arrangement::Square => square(count, domain),
    }
}
