//! Snapshot files in the GSD format, schema hoomd, version 1.4.

use nalgebra::Vector3;
use stosszahl_model::gsd::{Chunk, to_bytes};

use super::Content;
use super::quantity::ParticleQuantity;

/// Formats a snapshot as GSD with one frame, whose step is the number of the snapshot. The schema
/// has single precision. The time, quantities that the schema lacks, and which axes are periodic
/// are logged in addition, in double precision. The box of disks has no thickness, as HOOMD-blue
/// has it.
pub(super) fn gsd(content: &Content<'_>) -> Vec<u8> {
    let (particles, domain) = (content.particles, &content.domain);
    let scale = content.units.scale;
    let ([x, y, z], tilt) = (domain.lengths, domain.tilt());
    let z = if particles.dimension == 2 { 0.0 } else { z };
    // The box of HOOMD-blue is centred at the origin.
    let centre = Vector3::new(x + tilt, y, z) * 0.5;
    let places = particles
        .all
        .iter()
        .map(|one| domain.inside(one.position * scale.length) - centre);
    let mut chunks = vec![
        Chunk::count("configuration/step", content.index as u64),
        Chunk::bytes("configuration/dimensions", [particles.dimension as u8]),
        Chunk::single("configuration/box", 1, [x, y, z, tilt / y, 0.0, 0.0]),
        Chunk::counts("particles/N", [particles.all.len() as u32]),
        Chunk::single("particles/position", 3, places.flat_map(<[f64; 3]>::from)),
        Chunk::bytes("log/periodic", domain.periodic.map(u8::from)),
        Chunk::double("log/time", 1, [particles.time * scale.time()]),
    ];
    if content.quantities.contains(&ParticleQuantity::Species) {
        let most = particles.all.iter().map(|one| one.species).max();
        let names: Vec<String> = (0..=most.unwrap_or(0)).map(|one| one.to_string()).collect();
        chunks.push(Chunk::texts("particles/types", &names));
    }
    for &quantity in &content.quantities {
        let all = particles.all.iter();
        let numbers = all.flat_map(|one| quantity.numbers(one, scale).as_slice().to_vec());
        chunks.push(match quantity {
            ParticleQuantity::Velocity => Chunk::single("particles/velocity", 3, numbers),
            ParticleQuantity::Radius => {
                Chunk::single("particles/diameter", 1, numbers.map(|radius| 2.0 * radius))
            }
            ParticleQuantity::Mass => Chunk::single("particles/mass", 1, numbers),
            ParticleQuantity::AngularVelocity => {
                Chunk::double("log/particles/angular_velocity", 3, numbers)
            }
            ParticleQuantity::Species => {
                let species = particles.all.iter().map(|one| one.species);
                Chunk::counts("particles/typeid", species)
            }
            ParticleQuantity::Weight => Chunk::double("log/particles/weight", 1, numbers),
        });
    }
    let application = concat!("stosszahl ", env!("CARGO_PKG_VERSION"));
    to_bytes(application, ("hoomd", 1, 4), &[chunks])
}
