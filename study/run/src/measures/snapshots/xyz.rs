//! Snapshot files in the extended XYZ format.

use std::fmt::Write as _;

use super::quantity::ParticleQuantity;
use super::{Content, LINE};

impl ParticleQuantity {
    /// Returns the property of the quantity in extended XYZ: name, type and number of columns.
    fn property(self) -> &'static str {
        match self {
            Self::Velocity => "velo:R:3",
            Self::Radius => "radius:R:1",
            Self::Mass => "mass:R:1",
            Self::AngularVelocity => "angular_velocity:R:3",
            // "species" would be names of elements to OVITO and ASE.
            Self::Species => "type:I:1",
            Self::Weight => "weight:R:1",
        }
    }
}

/// Formats a snapshot as extended XYZ.
pub(super) fn xyz(content: &Content<'_>) -> String {
    let (particles, units, domain) = (content.particles, content.units, &content.domain);
    let scale = units.scale;
    let [x, y, z] = domain.lengths;
    // The second vector of the lattice leads to the image above, which slides in a shear flow.
    let slid = domain.offset;
    let over_t0 = units.time_over_t0.map(|unit| content.time * unit);
    let over_t0 = over_t0.map_or_else(String::new, |time| format!(" TimeOverT0={time}"));
    let periodic = domain.periodic.map(|one| if one { "T" } else { "F" });
    let mut text = String::with_capacity(LINE as usize * particles.all.len());
    let mut properties = String::from("id:I:1:pos:R:3");
    // Writing to a string cannot fail.
    for one in &content.quantities {
        let _ = write!(properties, ":{}", one.property());
    }
    let _ = writeln!(text, "{}", particles.all.len());
    let _ = writeln!(
        text,
        "Lattice=\"{x} 0 0 {slid} {y} 0 0 0 {z}\" Properties={properties} pbc=\"{}\" Time={}{over_t0} Engine={}",
        periodic.join(" "),
        particles.time * scale.time(),
        content.engine,
    );
    for (index, one) in particles.all.iter().enumerate() {
        let at = one.position * scale.length;
        let _ = write!(text, "{index} {} {} {}", at[0], at[1], at[2]);
        for quantity in &content.quantities {
            for number in quantity.numbers(one, scale).as_slice() {
                let _ = write!(text, " {number}");
            }
        }
        text.push('\n');
    }
    text
}
