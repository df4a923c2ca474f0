//! Snapshots of each format, read as start files.

use std::path::Path;

use nalgebra::{Vector3, vector};
use rand::{RngExt as _, SeedableRng as _};
use rand_xoshiro::Xoshiro256PlusPlus;
use stosszahl_model::images::wrapped;
use stosszahl_model::initial::{self, StartFile};
use stosszahl_model::{Particle, Particles, Shear};

use super::{Content, SnapshotFormat, SnapshotUnits};
use crate::plan::UnitScale;

const SIDES: [f64; 3] = [30.1, 20.3, 11.7];

/// Particles of two species with any numbers, at the time 1, between walls along y unless sheared.
fn particles(dimension: usize, walled: bool) -> Particles {
    let mut stream = Xoshiro256PlusPlus::seed_from_u64(5);
    let mut vector = |sides: [f64; 3], middle: f64| {
        let mut found = Vector3::zeros();
        for axis in 0..dimension {
            found[axis] = sides[axis] * (stream.random::<f64>() - middle);
        }
        found
    };
    let particle = |index: usize| {
        let species = u32::from(index % 3 == 1);
        let (radius, mass) = [(0.5, 1.0), (0.4, 2.1)][species as usize];
        let spin = vector([1.0; 3], 0.5);
        Particle {
            position: vector(SIDES, 0.0),
            velocity: vector([3.0; 3], 0.5),
            spin: if dimension == 2 {
                vector![0.0, 0.0, spin.x]
            } else {
                spin
            },
            species,
            ..Particle::at_rest(radius, mass)
        }
    };
    Particles {
        time: 1.0,
        dimension,
        lengths: [
            SIDES[0],
            SIDES[1],
            if dimension == 2 { 0.0 } else { SIDES[2] },
        ],
        periodic: [true, !walled, true],
        all: (0..100).map(particle).collect(),
    }
}

fn units(shear: Option<Shear>) -> SnapshotUnits {
    SnapshotUnits {
        scale: UnitScale::CASE,
        time_over_t0: None,
        depth: 0.9,
        shear,
    }
}

fn read(particles: &Particles, shear: Option<Shear>, format: SnapshotFormat) -> StartFile {
    let bytes = Content::new(particles, None, units(shear), "ed", 1.0).file(format);
    let name = format!("a.{}", format.ending());
    initial::read_bytes(Path::new(&name), bytes).expect("a start")
}

/// Formats with all digits give back the bits of all numbers. Single precision, that of GSD, rounds
/// each number by 2^-24 of its size. Positions are rounded by 2^-24 of half a side, as they are
/// from the middle of the box, and so is the middle to which they are added.
#[test]
fn snapshots_are_starts() {
    let half_bit = 0.5_f64.powi(24);
    for (dimension, walled) in [(2, true), (3, true), (2, false)] {
        let gas = particles(dimension, walled);
        let all = &gas.all;
        let positions: Vec<_> = all.iter().map(|one| one.position).collect();
        let velocities: Vec<_> = all.iter().map(|one| one.velocity).collect();
        let spins: Vec<_> = all.iter().map(|one| one.spin).collect();
        let radii: Vec<_> = all.iter().map(|one| one.radius).collect();
        let masses: Vec<_> = all.iter().map(|one| one.mass).collect();
        for (format, types) in [
            (SnapshotFormat::Xyz, ["0", "1"]),
            (SnapshotFormat::Lammps, ["1", "2"]),
        ] {
            let found = read(&gas, None, format);
            let types = all.iter().map(|one| types[one.species as usize].to_owned());
            let depth = if dimension == 2 { 0.9 } else { SIDES[2] };
            let wanted = StartFile {
                lengths: Some([SIDES[0], SIDES[1], depth]),
                periodic: Some([true, !walled, dimension == 3]),
                positions: Some(positions.clone()),
                velocities: Some(velocities.clone()),
                spins: Some(spins.clone()),
                radii: Some(radii.clone()),
                masses: Some(masses.clone()),
                types: Some(types.collect()),
                ..StartFile::default()
            };
            assert_eq!(found, wanted);
        }
        let found = read(&gas, None, SnapshotFormat::Gsd);
        assert!(found.is_single_precision && found.weights.is_none());
        assert_eq!(found.periodic, Some([true, !walled, dimension == 3]));
        let lengths = found.lengths.expect("a box");
        for axis in 0..dimension {
            assert!((lengths[axis] / SIDES[axis] - 1.0).abs() <= half_bit);
        }
        let (found_radii, found_masses) =
            (found.radii.expect("radii"), found.masses.expect("masses"));
        let (found_positions, found_velocities) = (
            found.positions.expect("positions"),
            found.velocities.expect("velocities"),
        );
        for index in 0..all.len() {
            for axis in 0..3 {
                let off = found_positions[index][axis] - positions[index][axis];
                assert!(off.abs() <= half_bit * SIDES[axis], "{off}");
                let (was, is) = (velocities[index][axis], found_velocities[index][axis]);
                assert!((is - was).abs() <= half_bit * was.abs());
            }
            assert!((found_radii[index] / radii[index] - 1.0).abs() <= half_bit);
            assert!((found_masses[index] / masses[index] - 1.0).abs() <= half_bit);
        }
        assert_eq!(found.spins, Some(spins));
        let types = all.iter().map(|one| one.species.to_string()).collect();
        assert_eq!(found.types, Some(types));
    }
}

/// The box of a shear flow is tilted, and particles are those of the box at rest but for whole
/// widths: in extended XYZ the same, in other formats those in the tilted box.
#[test]
fn sheared_snapshots_are_starts_with_their_offset() {
    let gas = particles(2, false);
    let [width, height, _] = SIDES;
    // An offset of 0.2, 0.7 and 0.95 of the width.
    for part in [0.2, 0.7, 0.95] {
        let shear = Shear {
            rate: 0.25 * width / height,
            offset: (part - 0.25 + 1.0) % 1.0 * width,
        };
        for (format, bits) in [
            (SnapshotFormat::Xyz, 53),
            (SnapshotFormat::Lammps, 53),
            (SnapshotFormat::Gsd, 24),
        ] {
            // Rounding of three numbers of at most twice the width.
            let rounding = 6.0 * width * 0.5_f64.powi(bits);
            let found = read(&gas, Some(shear), format);
            let [found_width, found_height, _] = found.lengths.expect("a box");
            assert!((found_width - width).abs() <= rounding);
            assert!((found_height - height).abs() <= rounding);
            let offset = wrapped(found.shear_offset, width);
            assert!((offset - part * width).abs() <= rounding, "{offset}");
            let is_tilted = format != SnapshotFormat::Xyz;
            assert!(!is_tilted || found.shear_offset.abs() <= 0.5 * width + rounding);
            for (one, at) in gas.all.iter().zip(found.positions.expect("positions")) {
                let away = at - one.position;
                let boxes = (away.x / width).round();
                assert!((away.x - boxes * width).abs() <= rounding && away.y.abs() <= rounding);
                assert!(is_tilted || boxes == 0.0);
                let part = (at.x - found.shear_offset * at.y / height) / width;
                assert!(!is_tilted || (-1e-6..=1.0 + 1e-6).contains(&part), "{part}");
            }
        }
    }
}

/// H5MD has all digits: the particles, the box, which may be tilted, and the moment.
#[test]
fn snapshots_as_h5md_have_all_digits() {
    use hdf5_pure::{AttrValue, File};

    for (dimension, walled, offset) in [(2, true, 0.0), (3, false, 0.0), (2, false, 0.3)] {
        let gas = particles(dimension, walled);
        let width = SIDES[0];
        let shear = (offset > 0.0).then_some(Shear {
            rate: 0.0,
            offset: offset * width,
        });
        let content = Content::new(&gas, None, units(shear), "ed", 0.25);
        let file = File::from_bytes(content.file(SnapshotFormat::H5md)).expect("a file");
        let numbers = |name: &str| {
            let data = file.dataset(&format!("particles/all/{name}"));
            data.expect("an array").read_f64().expect("numbers")
        };
        let shape = file
            .dataset("particles/all/position/value")
            .expect("places");
        let count = gas.all.len() as u64;
        assert_eq!(shape.shape().expect("a shape"), [1, count, 3]);
        let flat = |of: &dyn Fn(&Particle) -> Vector3<f64>| -> Vec<f64> {
            gas.all
                .iter()
                .flat_map(|one| <[f64; 3]>::from(of(one)))
                .collect()
        };
        let domain = content.domain;
        assert_eq!(
            numbers("position/value"),
            flat(&|one| domain.inside(one.position))
        );
        assert_eq!(numbers("velocity/value"), flat(&|one| one.velocity));
        assert_eq!(numbers("angular_velocity/value"), flat(&|one| one.spin));
        let radii: Vec<f64> = gas.all.iter().map(|one| one.radius).collect();
        assert_eq!(numbers("radius"), radii);
        let species: Vec<f64> = gas.all.iter().map(|one| f64::from(one.species)).collect();
        assert_eq!(numbers("species"), species);
        let ([x, y, z], tilt) = (domain.lengths, domain.tilt());
        let edges = if offset > 0.0 {
            vec![x, 0.0, 0.0, tilt, y, 0.0, 0.0, 0.0, z]
        } else {
            vec![x, y, z]
        };
        assert_eq!(numbers("box/edges/value"), edges);
        assert_eq!(numbers("position/time"), [gas.time]);
        let boundary = file.group("particles/all/box").expect("a box");
        let boundary = boundary.attrs().expect("attributes");
        let kinds = domain
            .periodic
            .map(|is| if is { "periodic" } else { "none" }.to_owned());
        let found = format!("{:?}", boundary.get("boundary"));
        assert!(
            kinds.iter().all(|kind| found.contains(kind.as_str())),
            "{found}"
        );
        assert!(matches!(boundary.get("dimension"), Some(AttrValue::I64(3))));
    }
}

/// Endings of start files are the same list where cases are read and where files are.
#[test]
fn cases_know_the_endings_of_start_files() {
    assert_eq!(stosszahl_case::format::START_FILE_ENDINGS, initial::ENDINGS);
}
