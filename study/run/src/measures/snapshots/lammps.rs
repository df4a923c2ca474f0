//! Snapshot files as text dumps of LAMMPS.

use std::fmt::Write as _;

use super::quantity::ParticleQuantity;
use super::{Content, LINE};

impl ParticleQuantity {
    /// Returns the columns of the quantity in a LAMMPS dump; empty for the species, which are
    /// types.
    fn dump_columns(self) -> &'static str {
        match self {
            Self::Velocity => " vx vy vz",
            Self::Radius => " radius",
            Self::Mass => " mass",
            Self::AngularVelocity => " omegax omegay omegaz",
            Self::Species => "",
            Self::Weight => " weight",
        }
    }
}

/// Formats a snapshot as a text dump of LAMMPS. Atoms and types are counted from 1, and the time
/// step is the number of the snapshot. The third axis of disks is one diameter thick, and not
/// periodic.
pub(super) fn dump(content: &Content<'_>) -> String {
    let (particles, domain) = (content.particles, &content.domain);
    let scale = content.units.scale;
    let [x, y, z] = domain.lengths;
    let faces = domain
        .periodic
        .map(|one| if one { "pp" } else { "ff" })
        .join(" ");
    let mut text = String::with_capacity(LINE as usize * particles.all.len());
    // Writing to a string cannot fail.
    let _ = write!(
        text,
        "ITEM: TIMESTEP\n{}\nITEM: NUMBER OF ATOMS\n{}\n",
        content.index,
        particles.all.len()
    );
    let tilt = domain.tilt();
    let _ = if tilt == 0.0 {
        write!(text, "ITEM: BOX BOUNDS {faces}\n0 {x}\n0 {y}\n0 {z}\n")
    } else {
        // Bounds are those of the tilted box.
        let (low, high) = (tilt.min(0.0), x + tilt.max(0.0));
        write!(
            text,
            "ITEM: BOX BOUNDS xy xz yz {faces}\n{low} {high} {tilt}\n0 {y} 0\n0 {z} 0\n"
        )
    };
    text.push_str("ITEM: ATOMS id type x y z");
    let quantities = content.quantities.iter().map(|one| one.dump_columns());
    text.extend(quantities);
    text.push('\n');
    let species = content.quantities.contains(&ParticleQuantity::Species);
    for (index, one) in particles.all.iter().enumerate() {
        let at = domain.inside(one.position * scale.length);
        let kind = if species { one.species + 1 } else { 1 };
        let _ = write!(text, "{} {kind} {} {} {}", index + 1, at[0], at[1], at[2]);
        let told = content
            .quantities
            .iter()
            .filter(|one| **one != ParticleQuantity::Species);
        for quantity in told {
            for number in quantity.numbers(one, scale).as_slice() {
                let _ = write!(text, " {number}");
            }
        }
        text.push('\n');
    }
    text
}
