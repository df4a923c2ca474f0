//! Conversion of particle data and collisions to byte arrays, which Python reads without copying.

use nalgebra::Vector3;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyByteArray;
use stosszahl_model::{Collision, Particle, Particles};

/// Number of 64-bit words per collision record: thirteen numbers, two indices, two species.
pub const WORDS: usize = 15;

/// Packs two 32-bit numbers into eight bytes, in this order in memory.
fn word([a, b]: [u32; 2]) -> [u8; 8] {
    let ([a0, a1, a2, a3], [b0, b1, b2, b3]) = (a.to_ne_bytes(), b.to_ne_bytes());
    [a0, a1, a2, a3, b0, b1, b2, b3]
}

/// Appends a collision record to a byte array, in the layout of `stosszahl.engines.COLLISION`.
pub fn write_collision(one: &Collision, into: &mut Vec<u8>) {
    let mut bytes = [0; 8 * WORDS];
    let mut at = bytes.chunks_exact_mut(8);
    let mut put = |word: [u8; 8]| {
        if let Some(place) = at.next() {
            place.copy_from_slice(&word);
        }
    };
    put(one.time.to_ne_bytes());
    for vector in [&one.position, &one.relative_velocity, &one.line] {
        for axis in 0..3 {
            put(vector[axis].to_ne_bytes());
        }
    }
    put(one.reduced_mass.to_ne_bytes());
    put(one.restitution.to_ne_bytes());
    put(one.weight.to_ne_bytes());
    put(word(one.pair));
    put(word(one.species));
    into.extend_from_slice(&bytes);
}

/// Returns one property of all particles as bytes, by its name. Vectors have as many components as
/// the gas has dimensions.
pub fn column<'py>(
    py: Python<'py>,
    particles: &Particles,
    name: &str,
) -> PyResult<Bound<'py, PyByteArray>> {
    let vector = |of: fn(&Particle) -> Vector3<f64>, axes: std::ops::Range<usize>| {
        fill(py, particles, axes.len(), move |one, number, place| {
            place.copy_from_slice(&of(one)[axes.start + number].to_ne_bytes());
        })
    };
    let scalar = |of: fn(&Particle) -> f64| {
        fill(py, particles, 1, move |one, _, place| {
            place.copy_from_slice(&of(one).to_ne_bytes());
        })
    };
    let all = 0..particles.dimension;
    match name {
        "positions" => vector(|one| one.position, all),
        "velocities" => vector(|one| one.velocity, all),
        "spins" => vector(|one| one.spin, if all.len() == 2 { 2..3 } else { all }),
        "radii" => scalar(|one| one.radius),
        "masses" => scalar(|one| one.mass),
        "weights" => scalar(|one| one.weight),
        "species" => fill(py, particles, 1, |one, _, place| {
            place.copy_from_slice(&u64::from(one.species).to_ne_bytes());
        }),
        _ => Err(PyValueError::new_err(format!("no column {name}"))),
    }
}

/// Creates a byte array with `width` 64-bit words per particle, filled by `write`.
fn fill<'py>(
    py: Python<'py>,
    particles: &Particles,
    width: usize,
    write: impl Fn(&Particle, usize, &mut [u8]),
) -> PyResult<Bound<'py, PyByteArray>> {
    let all = &particles.all;
    PyByteArray::new_with(py, 8 * width * all.len(), |bytes| {
        let mut words = bytes.chunks_exact_mut(8);
        for one in all {
            for (number, word) in words.by_ref().take(width).enumerate() {
                write(one, number, word);
            }
        }
        Ok(())
    })
}

/// Reads vectors with the given number of components from bytes; missing components are zero.
pub fn vectors(bytes: &[u8], components: usize) -> Vec<[f64; 3]> {
    let one = |chunk: &[u8]| {
        let mut vector = [0.0; 3];
        for (number, word) in vector.iter_mut().zip(chunk.chunks_exact(8)) {
            *number = f64::from_ne_bytes(word.try_into().unwrap_or_default());
        }
        vector
    };
    bytes.chunks_exact(8 * components.max(1)).map(one).collect()
}
