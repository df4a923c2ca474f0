//! Snapshots as H5MD, version 1.1.

use hdf5_pure::{AttrValue, FileBuilder, GroupBuilder};

use super::Content;
use super::quantity::ParticleQuantity;

/// Time of a snapshot, and its number.
#[derive(Clone, Copy)]
struct Moment {
    time: f64,
    step: i64,
}

impl Moment {
    /// Adds numbers at this moment to a group, as an element of this shape that depends on time.
    fn add_element(self, to: &mut GroupBuilder, name: &str, numbers: &[f64], shape: &[u64]) {
        let mut element = to.create_group(name);
        let shape = [&[1], shape].concat();
        element
            .create_dataset("value")
            .with_f64_data(numbers)
            .with_shape(&shape);
        element
            .create_dataset("step")
            .with_i64_data(&[self.step])
            .with_shape(&[1]);
        element
            .create_dataset("time")
            .with_f64_data(&[self.time])
            .with_shape(&[1]);
        to.add_group(element.finish());
    }
}

/// Adds a group with the attribute `name`, and a version if there is one.
fn add_named(to: &mut GroupBuilder, group: &str, name: &str, version: Option<&str>) {
    let mut named = to.create_group(group);
    named.set_attr("name", AttrValue::String(name.to_owned()));
    if let Some(version) = version {
        named.set_attr("version", AttrValue::String(version.to_owned()));
    }
    to.add_group(named.finish());
}

/// Returns a snapshot as H5MD with one frame, whose step is the number of the snapshot. All numbers
/// have double precision. Radii, masses and species do not depend on time.
pub(super) fn h5md(content: &Content<'_>) -> Vec<u8> {
    let (particles, domain) = (content.particles, &content.domain);
    let scale = content.units.scale;
    let moment = Moment {
        time: particles.time * scale.time(),
        step: content.index as i64,
    };
    let count = particles.all.len() as u64;
    let mut file = FileBuilder::new();
    let mut head = file.create_group("h5md");
    head.set_attr("version", AttrValue::I32Array(vec![1, 1]));
    add_named(&mut head, "author", "stosszahl", None);
    let version = Some(env!("CARGO_PKG_VERSION"));
    add_named(&mut head, "creator", "stosszahl", version);
    file.add_group(head.finish());

    let mut groups = file.create_group("particles");
    let mut all = groups.create_group("all");
    let places = particles.all.iter();
    let places = places.map(|one| domain.inside(one.position * scale.length));
    let places: Vec<f64> = places.flat_map(<[f64; 3]>::from).collect();
    moment.add_element(&mut all, "position", &places, &[count, 3]);
    for &quantity in &content.quantities {
        let name = quantity.name();
        let numbers = particles.all.iter();
        let numbers = numbers.flat_map(|one| quantity.numbers(one, scale).as_slice().to_vec());
        let numbers: Vec<f64> = numbers.collect();
        match quantity {
            ParticleQuantity::Velocity | ParticleQuantity::AngularVelocity => {
                moment.add_element(&mut all, name, &numbers, &[count, 3]);
            }
            ParticleQuantity::Weight => moment.add_element(&mut all, name, &numbers, &[count]),
            ParticleQuantity::Radius | ParticleQuantity::Mass => {
                all.create_dataset(name)
                    .with_f64_data(&numbers)
                    .with_shape(&[count]);
            }
            ParticleQuantity::Species => {
                let species: Vec<u32> = particles.all.iter().map(|one| one.species).collect();
                all.create_dataset(name)
                    .with_u32_data(&species)
                    .with_shape(&[count]);
            }
        }
    }
    let mut boundary = all.create_group("box");
    boundary.set_attr("dimension", AttrValue::I64(3));
    let kinds = domain.periodic.map(|is_periodic| {
        let kind = if is_periodic { "periodic" } else { "none" };
        kind.to_owned()
    });
    boundary.set_attr("boundary", AttrValue::StringArray(kinds.into()));
    let ([x, y, z], tilt) = (domain.lengths, domain.tilt());
    if tilt == 0.0 {
        moment.add_element(&mut boundary, "edges", &[x, y, z], &[3]);
    } else {
        let edges = [x, 0.0, 0.0, tilt, y, 0.0, 0.0, 0.0, z];
        moment.add_element(&mut boundary, "edges", &edges, &[3, 3]);
    }
    all.add_group(boundary.finish());
    groups.add_group(all.finish());
    file.add_group(groups.finish());
    file.finish()
        .expect("groups and arrays that the format allows")
}
