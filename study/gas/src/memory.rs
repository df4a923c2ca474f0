//! Memory that a gas needs, checked before it is allocated: a program that runs out of memory ends
//! without a message.

use stosszahl_model::{Particle, memory};

use crate::GasError;

/// Memory for each particle while a gas is placed: the particle, its place, its state, and the
/// cells in which overlaps are sought \[bytes\].
pub(crate) const BUILDING: usize = size_of::<Particle>() + 128;
/// Memory for each particle of an engine, the gas that it keeps, and a copy while it starts
/// \[bytes\].
pub(crate) const RUNNING: usize = 2 * size_of::<Particle>() + 192;
/// Memory that is assumed to be free always \[bytes\].
const SMALL: f64 = 16e6;

/// Refuses more memory than is free.
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
