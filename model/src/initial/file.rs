//! Initial states read from a file: CSV, extended XYZ, a dump or data file of LAMMPS, GSD, or the
//! `.sph` of EDMD.

mod csv;
mod gsd;
mod lammps;
mod lammps_data;
mod rows;
mod sph;
mod xyz;

use std::path::Path;
use std::{fs, io};

use rows::SourceFile;
pub use rows::{FileError, StartFile};

/// File name endings of the formats of initial states that can be read.
pub const ENDINGS: [&str; 9] = [
    ".csv",
    ".xyz",
    ".extxyz",
    ".dump",
    ".lammpstrj",
    ".data",
    ".lmp",
    ".gsd",
    ".sph",
];

/// Description of the boxes allowed in formats with a general box, for error messages.
const TILTED: &str =
    "a box with sides along x, y and z, or in a shear flow one that is tilted by xy alone";

/// Reads an initial state from a file; the ending of its name decides the format.
///
/// # Errors
/// [`FileError`] names the file, the line, what was found and what belongs there.
pub fn read_start_file(path: &Path) -> Result<StartFile, FileError> {
    let failed = |source| FileError::Unreadable {
        path: path.to_owned(),
        source,
    };
    // Regular files only: a run reads the file more than once, and a pipe would block.
    if !fs::metadata(path).map_err(failed)?.is_file() {
        let kind = io::ErrorKind::InvalidInput;
        return Err(failed(io::Error::new(
            kind,
            "a folder, a pipe or a device; expected a file",
        )));
    }
    read_bytes(path, fs::read(path).map_err(failed)?)
}

/// Reads an initial state from the bytes of a file; the ending of its path decides the format.
///
/// # Errors
/// As [`read_start_file`].
pub fn read_bytes(path: &Path, bytes: Vec<u8>) -> Result<StartFile, FileError> {
    let source = SourceFile { path };
    if ending_of(path) == "gsd" {
        return gsd::read_gsd(&source, &bytes);
    }
    let text = String::from_utf8(bytes).map_err(|error| FileError::Unreadable {
        path: path.to_owned(),
        source: io::Error::new(io::ErrorKind::InvalidData, error),
    })?;
    // Some systems' editors put a byte order mark at the beginning.
    read_text(&source, text.trim_start_matches('\u{feff}'))
}

/// Returns the file name ending of a path in lower case, without the dot; empty without one.
fn ending_of(path: &Path) -> String {
    let ending = path.extension().and_then(|ending| ending.to_str());
    ending.map_or_else(String::new, str::to_ascii_lowercase)
}

/// Reads an initial state from the text of a file, in the format of its name's ending.
fn read_text(source: &SourceFile<'_>, text: &str) -> Result<StartFile, FileError> {
    let ending = ending_of(source.path);
    match ending.as_str() {
        "csv" => csv::read_csv(source, text),
        "xyz" | "extxyz" => xyz::read_xyz(source, text),
        "dump" | "lammpstrj" => lammps::read_dump(source, text),
        "data" | "lmp" => lammps_data::read_data(source, text),
        "sph" => sph::read_sph(source, text),
        _ => Err(source.error(
            1,
            format!("a file name ending in `{ending}`"),
            format!("`{}`", ENDINGS.join("`, `")),
        )),
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{Vector3, vector};

    use super::*;

    fn from_text(name: &str, text: &str) -> Result<StartFile, FileError> {
        let source = SourceFile {
            path: Path::new(name),
        };
        read_text(&source, text)
    }

    #[test]
    fn both_formats_give_the_same_start() {
        let csv = "# box: 10 8 1\nx,y,vx,vy,radius,mass\n1,2,0.5,-0.5,0.5,1\n# a remark\n3,4,-1,1,0.25,2\n";
        let xyz = "2\nTime=0 Lattice=\"10 0 0 0 8 0 0 0 1\" Properties=id:I:1:pos:R:3:velo:R:3:radius:R:1:mass:R:1\n\
                   1 1 2 0 0.5 -0.5 0 0.5 1\n2 3 4 0 -1 1 0 0.25 2\n";
        let start = from_text("a.csv", csv).expect("a start");
        assert_eq!(start, from_text("a.xyz", xyz).expect("a start"));
        assert_eq!(start.lengths, Some([10.0, 8.0, 1.0]));
        assert_eq!(start.radii, Some(vec![0.5, 0.25]));
        let bare = from_text("a.csv", "# box: 1 1\ny,x\n0.5,0.25\n").expect("positions alone");
        assert_eq!(bare.positions, Some(vec![vector![0.25, 0.5, 0.0]]));
        assert_eq!(bare.velocities, None);
    }

    /// Dumps of LAMMPS begin at the lower corner of their box; scaled places, diameters and further
    /// columns are read. Lines of EDMD have a label, a place and a radius.
    #[test]
    fn files_of_other_programs_give_the_same_start() {
        let dump = "ITEM: TIMESTEP\n7\nITEM: NUMBER OF ATOMS\n2\nITEM: BOX BOUNDS pp ff pp\n-5 5\n0 8\n-0.5 0.5\n\
                    ITEM: ATOMS id type x y z vx vy vz radius mass\n1 A -4 2 0 0.5 -0.5 0 0.5 1\n2 B -2 4 0 -1 1 0 0.25 2\n";
        let start = from_text("a.dump", dump).expect("a start");
        assert_eq!(start.lengths, Some([10.0, 8.0, 1.0]));
        assert_eq!(start.periodic, Some([true, false, true]));
        let places = vec![vector![1.0, 2.0, 0.5], vector![3.0, 4.0, 0.5]];
        assert_eq!(start.positions, Some(places.clone()));
        assert_eq!(start.radii, Some(vec![0.5, 0.25]));
        assert_eq!(start.masses, Some(vec![1.0, 2.0]));
        assert_eq!(start.types, Some(vec!["A".into(), "B".into()]));
        let scaled = "ITEM: NUMBER OF ATOMS\n2\nITEM: BOX BOUNDS pp pp pp\n-5 5\n0 8\n-0.5 0.5\n\
                      ITEM: ATOMS id q xs ys zs diameter\n1 9 0.1 0.25 0.5 1\n2 9 0.3 0.5 0.5 0.5\n";
        let scaled = from_text("a.lammpstrj", scaled).expect("a start");
        assert_eq!(scaled.positions, Some(places.clone()));
        assert_eq!(scaled.radii, start.radii);
        assert_eq!(scaled.velocities, None);
        let sph = "2 0.75\n10 8 1\nA 1 2 0.5 0.5\nB 3 4 0.5 0.25\n";
        let sph = from_text("a.sph", sph).expect("a start");
        assert_eq!((sph.positions, sph.radii), (Some(places), start.radii));
        assert_eq!((sph.types, sph.lengths), (start.types, start.lengths));
    }

    /// Devices and pipes are refused, `/dev/null` in place of all, because it ends.
    #[cfg(unix)]
    #[test]
    fn what_is_no_file_is_refused() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("start.csv");
        std::os::unix::fs::symlink("/dev/null", &path).expect("a link");
        let said = read_start_file(&path).expect_err("no file").to_string();
        assert!(said.contains("expected a file"), "{said}");
    }

    /// Returns a data file of LAMMPS with one atom, after these lines of the box and sections.
    fn data(x: &str, sections: &str) -> String {
        format!("remark\n\n1 atoms\n{x}\n0 1 ylo yhi\n0 1 zlo zhi\n\n{sections}")
    }

    /// Data files of LAMMPS: density and diameter of spheres, masses of types, velocities by number.
    #[test]
    fn data_files_are_read() {
        let head = "LAMMPS data file\n\n2 atoms\n2 atom types\n\n-5 5 xlo xhi\n0 8 ylo yhi\n-0.5 0.5 zlo zhi\n";
        let velocities = "\nVelocities\n\n2 -1 1 0 0 0 3\n1 0.5 -0.5 0 0 0 0\n";
        let spheres = format!(
            "{head}\nPair Coeffs # gran\n\n1 2 3\n\nAtoms # sphere\n\n1 1 1 2 -4 2 0 0 0 1\n2 2 0.5 4 -2 4 0 0 0 0\n{velocities}"
        );
        let start = from_text("a.data", &spheres).expect("a start");
        let places = vec![vector![1.0, 2.0, 0.5], vector![3.0, 4.0, 0.5]];
        assert_eq!(start.lengths, Some([10.0, 8.0, 1.0]));
        assert_eq!(
            (start.periodic, start.positions),
            (None, Some(places.clone()))
        );
        assert_eq!(start.radii, Some(vec![0.5, 0.25]));
        let ball = |radius: f64| 4.0 / 3.0 * std::f64::consts::PI * radius.powi(3);
        assert_eq!(start.masses, Some(vec![2.0 * ball(0.5), 4.0 * ball(0.25)]));
        assert_eq!(start.types, Some(vec!["1".into(), "2".into()]));
        let speeds = vec![vector![0.5, -0.5, 0.0], vector![-1.0, 1.0, 0.0]];
        assert_eq!(start.velocities, Some(speeds));
        assert_eq!(
            start.spins,
            Some(vec![Vector3::zeros(), vector![0.0, 0.0, 3.0]])
        );
        let points = format!(
            "{head}0.5 0 0 xy xz yz\n\nMasses\n\n2 7 # B\n1 3\n\nAtoms\n\n9 2 -4 2 0\n4 1 -2 4 0\n"
        );
        let points = from_text("a.lmp", &points).expect("a start");
        assert_eq!((points.positions, points.shear_offset), (Some(places), 0.5));
        assert_eq!((points.masses, points.radii), (Some(vec![7.0, 3.0]), None));
        assert_eq!(points.velocities, None);
    }

    /// Boxes of a shear flow by their tilt, in all formats that have one.
    #[test]
    fn tilted_boxes_are_read() {
        let xyz = "1\nLattice=\"10 0 0 -2 8 0 0 0 1\" Properties=pos:R:3\n1 2 0\n";
        let dump = |columns: &str, row: &str| {
            format!(
                "ITEM: NUMBER OF ATOMS\n1\nITEM: BOX BOUNDS xy xz yz pp pp ff\n-2 10 -2\n0 8 0\n0 1 0\n\
                 ITEM: ATOMS {columns}\n{row}\n"
            )
        };
        // By parts of the vectors of the box, x is 0.15 times 10 less 0.25 times 2.
        let scaled = dump("xs ys zs", "0.15 0.25 0");
        for (name, text) in [
            ("a.xyz", xyz),
            ("a.dump", &dump("x y z", "1 2 0")),
            ("a.dump", &scaled),
        ] {
            let start = from_text(name, text).expect("a start");
            assert_eq!(
                (start.lengths, start.shear_offset),
                (Some([10.0, 8.0, 1.0]), -2.0)
            );
            assert_eq!(start.positions, Some(vec![vector![1.0, 2.0, 0.0]]));
        }
    }

    /// GSD as HOOMD-blue writes it, with its box around the origin, and what is refused of it.
    #[test]
    fn gsd_is_read() {
        use crate::gsd::{Chunk, to_bytes};
        let frame = || {
            vec![
                Chunk::single("configuration/box", 1, [10.0, 8.0, 0.0, -0.25, 0.0, 0.0]),
                Chunk::counts("particles/N", [2]),
                // The corner is at (-4, -4).
                Chunk::single("particles/position", 3, [-3.0, -2.0, 0.0, -1.0, 0.0, 0.0]),
                Chunk::texts("particles/types", &["A".into(), "B".into()]),
                Chunk::counts("particles/typeid", [1, 0]),
                Chunk::single("particles/diameter", 1, [1.0, 0.5]),
                Chunk::single("particles/mass", 1, [1.0, 2.0]),
            ]
        };
        let read = |frames: &[Vec<Chunk>], schema: &str| {
            let bytes = to_bytes("a test", (schema, 1, 4), frames);
            read_bytes(Path::new("a.gsd"), bytes)
        };
        let start = read(&[frame()], "hoomd").expect("a start");
        assert_eq!(start.lengths, Some([10.0, 8.0, 0.0]));
        assert_eq!(
            (start.shear_offset, start.is_single_precision),
            (-2.0, true)
        );
        let places = vec![vector![1.0, 2.0, 0.0], vector![3.0, 4.0, 0.0]];
        assert_eq!((start.positions, start.velocities), (Some(places), None));
        assert_eq!(
            (start.radii, start.masses),
            (Some(vec![0.5, 0.25]), Some(vec![1.0, 2.0]))
        );
        assert_eq!(start.types, Some(vec!["B".into(), "A".into()]));
        let refused = |frames: &[Vec<Chunk>], schema: &str, words: &str| {
            let said = read(frames, schema).expect_err(words).to_string();
            assert!(
                said.contains("a.gsd, frame 0: ") && said.contains(words),
                "{said}"
            );
        };
        refused(&[frame()], "other", "`other`");
        refused(&[frame(), frame()], "hoomd", "2 frames");
        let changed = |index: usize, chunk: Chunk| {
            let mut frame = frame();
            frame[index] = chunk;
            [frame]
        };
        let tilted = Chunk::single("configuration/box", 1, [1.0, 1.0, 1.0, 0.0, 0.5, 0.0]);
        refused(&changed(0, tilted), "hoomd", "tilted by xy alone");
        let flat = Chunk::single("configuration/box", 1, [1.0, 0.0, 1.0, 0.0, 0.0, 0.0]);
        refused(&changed(0, flat), "hoomd", "positive sides");
        refused(
            &changed(1, Chunk::counts("particles/N", [0])),
            "hoomd",
            "no particle",
        );
        let plane = Chunk::single("particles/position", 2, [1.0; 4]);
        refused(&changed(2, plane), "hoomd", "2 columns");
        let few = Chunk::single("particles/position", 3, [1.0; 3]);
        refused(&changed(2, few), "hoomd", "1 rows");
        let odd = Chunk::single("particles/position", 3, [0.0, 0.0, 0.0, f64::NAN, 0.0, 0.0]);
        refused(&changed(2, odd), "hoomd", "NaN in row 1");
        refused(
            &changed(4, Chunk::counts("particles/typeid", [0, 2])),
            "hoomd",
            "type 2",
        );
        let point = Chunk::single("particles/diameter", 1, [1.0, 0.0]);
        refused(&changed(5, point), "hoomd", "of particle 1");
        let damaged = read_bytes(Path::new("a.gsd"), b"no GSD".to_vec());
        assert!(
            damaged
                .expect_err("no file")
                .to_string()
                .contains("a whole file")
        );
    }

    fn refused(name: &str, text: &str, line: usize, fragment: &str) {
        let said = from_text(name, text).expect_err(text).to_string();
        let place = format!("{name}:{line}:");
        assert!(
            said.contains(fragment) && said.contains(&place),
            "{text}: {said}"
        );
    }

    #[test]
    fn damage_is_named_with_its_line() {
        for (name, text, line, fragment) in [
            ("a.csv", "x,y\n1,2\n", 1, "# box: Lx Ly"),
            ("a.csv", "# box: 1 -1\nx,y\n", 1, "above zero"),
            ("a.csv", "# box: 1 1\nx,q\n", 2, "column `q`"),
            ("a.csv", "# box: 1 1\nx,z\n", 2, "both or none"),
            ("a.csv", "x,y,vx,vy\n1,2,3,4\n", 1, "# box: Lx Ly"),
            ("a.csv", "# box: 1 1\nx,y,type\n1,1,all\n", 3, "other than"),
            ("a.csv", "# box: 1 1\nx,y,vx\n", 2, "both or none"),
            ("a.csv", "# box: 1 1\nx,y\n1,NaN\n", 3, "finite number"),
            ("a.csv", "# box: 1 1\nx,y\n1\n", 3, "equally many"),
            ("a.csv", "# box: 1 1\nx,y,radius\n1,1,0\n", 3, "above zero"),
            ("a.csv", "# box: 1 1\nx,y\n", 2, "no particle"),
            ("a.xyz", "two\n", 1, "number of particles"),
            ("a.xyz", "1\nProperties=pos:R:3\n1 1 1\n", 2, "Lattice"),
            (
                "a.xyz",
                "1\nLattice=\"1 1 0 0 1 0 0 0 1\"\n1 1 1\n",
                2,
                "tilted by xy alone",
            ),
            (
                "a.xyz",
                "2\nLattice=\"1 0 0 0 1 0 0 0 1\" Properties=pos:R:2\n0 0\n",
                3,
                "end of the file",
            ),
            (
                "a.xyz",
                "1\nLattice=\"1 0 0 0 1 0 0 0 1\" Properties=pos:R\n0 0\n",
                2,
                "triples",
            ),
            (
                "a.xyz",
                "1\nLattice=\"1 0 0 0 1 0 0 0 1\" Properties=pos:R:2\n0 x\n",
                3,
                "finite",
            ),
            (
                "a.xyz",
                "1\nLattice=\"1 0 0 0 1 0 0 0 1\" Properties=pos:R:2\n0 0\n1 1\n",
                4,
                "one frame",
            ),
            ("a.sph", "N\n", 1, "number of particles"),
            ("a.sph", "1\n1 1 1\n", 2, "1 particles"),
            ("a.sph", "1\n1 1 1\nA 0 0 0 0\n", 3, "above zero"),
            ("a.gro", "1\n", 1, ".lammpstrj"),
        ] {
            refused(name, text, line, fragment);
        }
    }

    #[test]
    fn damage_of_files_of_lammps_is_named_with_its_line() {
        for (name, text, line, fragment) in [
            ("a.dump", "id x y\n", 1, "ITEM:"),
            ("a.dump", "ITEM: TIMESTEP\n", 1, "ITEM: ATOMS"),
            ("a.dump", "ITEM: ATOMS x y z\n", 1, "BOX BOUNDS"),
            (
                "a.dump",
                "ITEM: BOX BOUNDS xy xz yz pp pp pp\n0 1 0\n0 1 0.5\n",
                3,
                "tilted by xy alone",
            ),
            (
                "a.dump",
                "ITEM: BOX BOUNDS abc origin pp pp pp\n",
                1,
                "general triclinic",
            ),
            ("a.data", "remark\n\n1 atoms\n", 3, "xlo xhi"),
            (
                "a.data",
                &data("1 0 xlo xhi", "Atoms # atomic\n\n1 1 0 0 0\n"),
                4,
                "higher",
            ),
            (
                "a.data",
                &data("1 0 1 xy xz yz\n0 1 xlo xhi", ""),
                4,
                "tilted by xy alone",
            ),
            ("a.data", &data("0 1 xlo xhi", ""), 7, "a section `Atoms`"),
            (
                "a.data",
                &data("0 1 xlo xhi", "Atoms # full\n\n1 1 1 0 0 0 0\n"),
                8,
                "`full`",
            ),
            (
                "a.data",
                &data("0 1 xlo xhi", "Atoms\n\n1 1 0 0\n"),
                8,
                "in 4 columns",
            ),
            (
                "a.data",
                &data("0 1 xlo xhi", "Atoms\n\n"),
                8,
                "1 atoms, as line 3 says",
            ),
            (
                "a.data",
                &data("0 1 xlo xhi", "Atoms\n\n1 1 0 q 0\n"),
                10,
                "y = q",
            ),
            (
                "a.data",
                &data("0 1 xlo xhi", "Atoms\n\n1 1 0 1 0 0 0\n"),
                10,
                "radius = 0",
            ),
            (
                "a.data",
                &data("0 1 xlo xhi", "Masses\n\n2 1\n\nAtoms\n\n1 1 0 0 0\n"),
                14,
                "line 8",
            ),
            (
                "a.data",
                &data(
                    "0 1 xlo xhi",
                    "Atoms\n\n1 1 0 0 0\n\nVelocities\n\n2 0 0 0\n",
                ),
                12,
                "atom 1",
            ),
            ("a.dump", "ITEM: BOX BOUNDS pp pp pp\n1 0\n", 2, "higher"),
            (
                "a.dump",
                "ITEM: NUMBER OF ATOMS\n1\nITEM: BOX BOUNDS pp pp pp\n0 1\n0 1\n0 1\nITEM: ATOMS id\n",
                7,
                "xs ys zs",
            ),
        ] {
            refused(name, text, line, fragment);
        }
    }
}
