//! Starts read from a file: CSV, extended XYZ, a dump of LAMMPS, or the `.sph` of EDMD.

mod csv;
mod lammps;
mod rows;
mod sph;
mod xyz;

use std::path::Path;
use std::{fs, io};

use rows::SourceFile;
pub use rows::{FileError, StartFile};

/// Endings of the names of start files.
pub const ENDINGS: [&str; 6] = [".csv", ".xyz", ".extxyz", ".dump", ".lammpstrj", ".sph"];

/// Reads a start file; the ending of its name decides the format.
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
    let text = fs::read_to_string(path).map_err(failed)?;
    // Some systems' editors put a byte order mark at the beginning.
    read_text(&SourceFile { path }, text.trim_start_matches('\u{feff}'))
}

/// Reads the text of a start file.
fn read_text(source: &SourceFile<'_>, text: &str) -> Result<StartFile, FileError> {
    let ending = (source.path)
        .extension()
        .and_then(|ending| ending.to_str())
        .unwrap_or("")
        .to_ascii_lowercase();
    match ending.as_str() {
        "csv" => csv::read_csv(source, text),
        "xyz" | "extxyz" => xyz::read_xyz(source, text),
        "dump" | "lammpstrj" => lammps::read_dump(source, text),
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
    use nalgebra::vector;

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
                "1\nLattice=\"1 0 0 1 1 0 0 0 1\"\n1 1 1\n",
                2,
                "rectangular",
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
            ("a.dump", "id x y\n", 1, "ITEM:"),
            ("a.dump", "ITEM: TIMESTEP\n", 1, "ITEM: ATOMS"),
            ("a.dump", "ITEM: ATOMS x y z\n", 1, "BOX BOUNDS"),
            (
                "a.dump",
                "ITEM: BOX BOUNDS xy xz yz pp pp pp\n0 1 0\n",
                1,
                "rectangular",
            ),
            ("a.dump", "ITEM: BOX BOUNDS pp pp pp\n1 0\n", 2, "higher"),
            (
                "a.dump",
                "ITEM: NUMBER OF ATOMS\n1\nITEM: BOX BOUNDS pp pp pp\n0 1\n0 1\n0 1\nITEM: ATOMS id\n",
                7,
                "xs ys zs",
            ),
            ("a.sph", "N\n", 1, "number of particles"),
            ("a.sph", "1\n1 1 1\n", 2, "1 particles"),
            ("a.sph", "1\n1 1 1\nA 0 0 0 0\n", 3, "above zero"),
            ("a.gro", "1\n", 1, ".lammpstrj"),
        ] {
            let error = from_text(name, text).expect_err(text);
            let said = error.to_string();
            assert!(
                said.contains(fragment) && said.contains(&format!("{name}:{line}:")),
                "{text}: {said}"
            );
        }
    }
}
