//! Memory check of a gas before allocation, as a program that runs out of memory ends without a
//! message.

use stosszahl_model::{Particle, memory};

use crate::GasError;

/// Memory per particle while a gas is built \[bytes\]: the particle, its place, its state, and the
/// cells in which overlaps are sought.
pub(crate) const BUILDING: usize = size_of::<Particle>() + 128;
/// Memory per particle of a running engine \[bytes\], with the gas that it stores and a copy during
/// its start.
pub(crate) const RUNNING: usize = 2 * size_of::<Particle>() + 192;
/// Memory that is taken as available without a check \[bytes\].
const SMALL: f64 = 16e6;

/// Returns an error if `particles` particles of `each` bytes need more memory than is available.
pub(crate) fn need_memory(particles: usize, each: usize) -> Result<(), GasError> {
    let needed = particles as f64 * each as f64;
    match memory::available() {
        Some(free) if needed > SMALL && needed > free => Err(GasError::Memory {
            particles,
            needed: needed / GIBIBYTE,
            free: free / GIBIBYTE,
        }),
        _ => Ok(()),
    }
}

/// Size of a gibibyte \[bytes\].
const GIBIBYTE: f64 = 1_073_741_824.0;
