//! Starts read from a file: CSV, or the extended XYZ that OVITO and ASE write.
//!
//! CSV: a first line `# box: Lx Ly` (`Lx Ly Lz` of spheres), then a header with the columns `x,y`
//! (`z`) and, optionally, `vx,vy,vz,wx,wy,wz,radius,mass,type` in any order; velocities alone need
//! no box. Extended XYZ: a second line with `Lattice="..."` (orthogonal) and `Properties=...`
//! naming `pos`, and optionally `velo`, `angular_velocity`, `radius`, `mass`, `type` or `species`,
//! `weight`; and `pbc="..."`, optionally.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::{fs, io};

use nalgebra::Vector3;

/// Content of a start file, as written; components that the file lacks are zero.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StartFile {
    /// Side lengths of the box \[length\], the third 0 where the file names two; `None` without a
    /// box.
    pub lengths: Option<[f64; 3]>,
    /// Periodicity by axis; `None` where the file does not state it.
    pub periodic: Option<[bool; 3]>,
    /// Centres \[length\], if the file has them.
    pub positions: Option<Vec<Vector3<f64>>>,
    /// Velocities \[length/time\], if the file has them.
    pub velocities: Option<Vec<Vector3<f64>>>,
    /// Angular velocities \[1/time\], if the file has them.
    pub spins: Option<Vec<Vector3<f64>>>,
    /// Radii \[length\], if the file has them.
    pub radii: Option<Vec<f64>>,
    /// Masses, if the file has them.
    pub masses: Option<Vec<f64>>,
    /// Names of the species of the particles, if the file has them.
    pub types: Option<Vec<String>>,
    /// Weights: numbers of particles that each particle of the file stands for, if the file has
    /// them.
    pub weights: Option<Vec<f64>>,
}

impl StartFile {
    /// Number of particles.
    pub fn count(&self) -> usize {
        let placed = self.positions.as_ref().or(self.velocities.as_ref());
        placed.map_or(0, Vec::len)
    }
}

/// Reason why a start file could not be used.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum FileError {
    /// The file could not be read.
    #[error("{}: {source}", path.display())]
    Unreadable {
        /// Path of the file.
        path: PathBuf,
        /// Error of the operating system.
        source: io::Error,
    },
    /// A line has wrong content.
    #[error("{}:{line}: found {found}; expected {expected}", path.display())]
    Content {
        /// Path of the file.
        path: PathBuf,
        /// Line, counted from 1.
        line: usize,
        /// Text found.
        found: String,
        /// Expected content.
        expected: String,
    },
}

/// Largest number of a start file: squares and ratios of such numbers are still finite.
const LARGEST: f64 = 1e100;

/// Most columns of one property of an extended XYZ file.
const MOST_COLUMNS: usize = 1000;

/// Most characters in the name of a species.
const LONGEST_NAME: usize = 40;

struct Source<'a> {
    path: &'a Path,
}

impl Source<'_> {
    fn error(
        &self,
        line: usize,
        found: impl Into<String>,
        expected: impl Into<String>,
    ) -> FileError {
        FileError::Content {
            path: self.path.to_owned(),
            line,
            found: found.into(),
            expected: expected.into(),
        }
    }

    fn number(&self, line: usize, name: &str, text: Option<&str>) -> Result<f64, FileError> {
        let text = text
            .ok_or_else(|| self.error(line, "too few columns", format!("a value of `{name}`")))?;
        match text.trim().parse::<f64>() {
            Ok(value) if value.abs() <= LARGEST => Ok(value),
            _ => Err(self.error(
                line,
                format!("{name} = {text}"),
                "a finite number up to 1e100",
            )),
        }
    }

    fn positive(&self, line: usize, name: &str, text: Option<&str>) -> Result<f64, FileError> {
        let value = self.number(line, name, text)?;
        if value >= 1.0 / LARGEST {
            Ok(value)
        } else {
            Err(self.error(
                line,
                format!("{name} = {value}"),
                "a number above zero (from 1e-100)",
            ))
        }
    }
}

impl Source<'_> {
    fn name(&self, line: usize, text: Option<&str>) -> Result<String, FileError> {
        let name = text.unwrap_or("").trim();
        let plain = !name.chars().any(char::is_control) && name.chars().count() <= LONGEST_NAME;
        if !plain || name.is_empty() || name == "all" {
            let expected = format!("a name of 1 to {LONGEST_NAME} characters other than \"all\"");
            return Err(self.error(line, format!("type = `{name}`"), expected));
        }
        Ok(name.to_owned())
    }
}

/// Columns of the components of a vector, some of which may be absent.
type Components = [Option<usize>; 3];

/// Columns of the quantities in a file.
#[derive(Default)]
struct Columns {
    position: Option<Components>,
    velocity: Option<Components>,
    spin: Option<Components>,
    radius: Option<usize>,
    mass: Option<usize>,
    kind: Option<usize>,
    weight: Option<usize>,
}

/// Names of the columns of CSV.
const NAMES: [&str; 12] = [
    "x", "y", "z", "vx", "vy", "vz", "wx", "wy", "wz", "radius", "mass", "type",
];

/// Reads a start file; its name's ending (`.csv` or `.xyz`) decides the format.
///
/// # Errors
/// [`FileError`] names the file, the line, what was found and what belongs there.
pub fn read(path: &Path) -> Result<StartFile, FileError> {
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
    let text = text.trim_start_matches('\u{feff}');
    let source = Source { path };
    let ending = path
        .extension()
        .and_then(|ending| ending.to_str())
        .unwrap_or("")
        .to_ascii_lowercase();
    match ending.as_str() {
        "csv" => read_csv(&source, text),
        "xyz" | "extxyz" => read_xyz(&source, text),
        _ => Err(source.error(
            1,
            format!("a file name ending in `{ending}`"),
            "`.csv` or `.xyz`",
        )),
    }
}

fn read_csv(source: &Source<'_>, text: &str) -> Result<StartFile, FileError> {
    let first = text.lines().next().unwrap_or("");
    let boxed = first.strip_prefix("# box:");
    let lengths = boxed.map(|rest| csv_box(source, first, rest)).transpose()?;
    let header = if boxed.is_some() { 2 } else { 1 };
    let mut reader = csv::ReaderBuilder::new()
        .comment(Some(b'#'))
        .trim(csv::Trim::All)
        .from_reader(text.as_bytes());
    let line_of = |position: Option<&csv::Position>| position.map_or(0, |p| p.line() as usize);
    let table = |error: &csv::Error| {
        source.error(
            line_of(error.position()),
            error.to_string(),
            "a table with equally many columns in each row",
        )
    };
    let headers = reader.headers().map_err(|error| table(&error))?.clone();
    let all = format!("columns {}", NAMES.join(", "));
    let mut names = HashMap::new();
    for (column, name) in headers.iter().enumerate() {
        if !NAMES.contains(&name) {
            return Err(source.error(header, format!("column `{name}`"), all));
        }
        if names.insert(name.to_owned(), column).is_some() {
            return Err(source.error(header, format!("column `{name}` twice"), "each column once"));
        }
    }
    let column = |name: &str| names.get(name).copied();
    // Vectors need their first two components; the third one is optional.
    let vector = |[a, b, c]: [&str; 3]| match [column(a), column(b), column(c)] {
        [None, None, None] => Ok(None),
        found @ [Some(_), Some(_), _] => Ok(Some(found)),
        _ => Err(source.error(
            header,
            format!("only some of the columns `{a}`, `{b}` and `{c}`"),
            format!("`{a}` and `{b}` both or none, and `{c}` with both"),
        )),
    };
    let spin = ["wx", "wy", "wz"].map(column);
    let columns = Columns {
        position: vector(["x", "y", "z"])?,
        velocity: vector(["vx", "vy", "vz"])?,
        spin: spin.iter().any(Option::is_some).then_some(spin),
        radius: column("radius"),
        mass: column("mass"),
        kind: column("type"),
        weight: None,
    };
    let moves = columns.velocity.is_some();
    if lengths.is_some() && columns.position.is_none() && !moves {
        return Err(source.error(header, "no columns `x` and `y`, or `vx` and `vy`", all));
    }
    if lengths.is_none() && (columns.position.is_some() || !moves) {
        return Err(source.error(
            1,
            format!("`{first}`"),
            "`# box: Lx Ly`, the sides of the box; of spheres `# box: Lx Ly Lz`",
        ));
    }
    let mut rows = Rows::new(source, lengths, columns);
    for record in reader.records() {
        let record = record.map_err(|error| table(&error))?;
        rows.push(line_of(record.position()), |column| record.get(column))?;
    }
    rows.finish()
}

/// Reads the sides of the box from the first line of a CSV file.
fn csv_box(source: &Source<'_>, line: &str, sides: &str) -> Result<[f64; 3], FileError> {
    let sides: Vec<&str> = sides.split_whitespace().collect();
    if !(2..=3).contains(&sides.len()) {
        let expected = "`# box: Lx Ly`, the sides of the box; of spheres `# box: Lx Ly Lz`";
        return Err(source.error(1, format!("`{line}`"), expected));
    }
    let mut lengths = [0.0; 3];
    for ((length, name), text) in lengths.iter_mut().zip(["Lx", "Ly", "Lz"]).zip(sides) {
        *length = source.positive(1, name, Some(text))?;
    }
    Ok(lengths)
}

/// Reads which axes are periodic from the `pbc` of an extended XYZ file.
fn xyz_periodic(source: &Source<'_>, text: &str) -> Result<[bool; 3], FileError> {
    let word = |word: &str| match word {
        "T" | "True" | "true" | "1" => Some(true),
        "F" | "False" | "false" | "0" => Some(false),
        _ => None,
    };
    let found: Option<Vec<bool>> = text.split_whitespace().map(word).collect();
    found
        .and_then(|axes| <[bool; 3]>::try_from(axes).ok())
        .ok_or_else(|| source.error(2, format!("pbc=\"{text}\""), "three of T and F"))
}

fn read_xyz(source: &Source<'_>, text: &str) -> Result<StartFile, FileError> {
    let mut lines = text
        .lines()
        .enumerate()
        .map(|(index, line)| (index + 1, line));
    let (_, first) = lines.next().unwrap_or((1, ""));
    let count: usize = first
        .trim()
        .parse()
        .map_err(|_| source.error(1, format!("`{first}`"), "the number of particles"))?;
    let (_, comment) = lines.next().unwrap_or((2, ""));
    let fields = comment_fields(comment);
    let lattice = fields.get("lattice").map_or("", String::as_str);
    let entries: Vec<&str> = lattice.split_whitespace().collect();
    if entries.len() != 9 {
        return Err(source.error(
            2,
            format!("Lattice=\"{lattice}\""),
            "Lattice=\"Lx 0 0 0 Ly 0 0 0 Lz\"",
        ));
    }
    for (index, entry) in entries.iter().enumerate() {
        if index % 4 != 0 && source.number(2, "Lattice", Some(entry))? != 0.0 {
            return Err(source.error(2, format!("Lattice=\"{lattice}\""), "a rectangular box"));
        }
    }
    let lengths = [
        source.positive(2, "Lx", Some(entries[0]))?,
        source.positive(2, "Ly", Some(entries[4]))?,
        source.number(2, "Lz", Some(entries[8]))?,
    ];
    let periodic = fields.get("pbc");
    let periodic = periodic
        .map(|text| xyz_periodic(source, text))
        .transpose()?;
    let properties = fields
        .get("properties")
        .map_or("species:S:1:pos:R:3", String::as_str);
    let parts: Vec<&str> = properties.split(':').collect();
    let mut columns = HashMap::new();
    let mut next = 0;
    for property in parts.chunks(3) {
        // Upper bound of a width, so that sums of widths do not overflow.
        let width: Option<usize> = property
            .get(2)
            .and_then(|width| width.parse().ok())
            .filter(|width| (1..=MOST_COLUMNS).contains(width));
        let Some(width) = width else {
            return Err(source.error(
                2,
                format!("Properties={properties}"),
                format!("triples name:type:columns, from 1 to {MOST_COLUMNS} columns each"),
            ));
        };
        columns.insert(property[0].to_ascii_lowercase(), (next, width));
        next += width;
    }
    let vector = |name: &str| -> Option<Components> {
        let &(first, width) = columns.get(name).filter(|entry| entry.1 >= 2)?;
        Some([0, 1, 2].map(|axis| (axis < width).then_some(first + axis)))
    };
    let single = |name: &str| columns.get(name).map(|entry| entry.0);
    let flat_spin = || single("angular_velocity").map(|column| [None, None, Some(column)]);
    let position = vector("pos").ok_or_else(|| {
        source.error(
            2,
            format!("Properties={properties}"),
            "pos:R:2 or pos:R:3 among them",
        )
    })?;
    let columns = Columns {
        position: Some(position),
        velocity: vector("velo").or_else(|| vector("vel")),
        spin: vector("angular_velocity").or_else(flat_spin),
        radius: single("radius"),
        mass: single("mass").or_else(|| single("masses")),
        kind: single("type").or_else(|| single("species")),
        weight: single("weight"),
    };
    let mut rows = Rows::new(source, Some(lengths), columns);
    rows.start.periodic = periodic;
    for _ in 0..count {
        let Some((line, row)) = lines.next() else {
            return Err(source.error(
                text.lines().count(),
                "the end of the file",
                format!("{count} particles"),
            ));
        };
        let values: Vec<&str> = row.split_whitespace().collect();
        rows.push(line, |column| values.get(column).copied())?;
    }
    if let Some((line, row)) = lines.find(|(_, row)| !row.trim().is_empty()) {
        return Err(source.error(
            line,
            format!("`{row}`"),
            format!("nothing after {count} particles (one frame)"),
        ));
    }
    rows.finish()
}

/// Splits `key=value key="quoted value"`; keys in lower case.
fn comment_fields(comment: &str) -> HashMap<String, String> {
    let mut fields = HashMap::new();
    let mut rest = comment.trim_start();
    while let Some((key, after)) = rest.split_once('=') {
        let key = key
            .split_whitespace()
            .last()
            .unwrap_or("")
            .to_ascii_lowercase();
        let (value, tail) = if let Some(quoted) = after.strip_prefix('"') {
            quoted.split_once('"').unwrap_or((quoted, ""))
        } else {
            after.split_once(char::is_whitespace).unwrap_or((after, ""))
        };
        fields.insert(key, value.to_owned());
        rest = tail.trim_start();
    }
    fields
}

/// Rows on their way into a [`StartFile`].
struct Rows<'a> {
    source: &'a Source<'a>,
    columns: Columns,
    last_line: usize,
    start: StartFile,
}

impl<'a> Rows<'a> {
    fn new(source: &'a Source<'a>, lengths: Option<[f64; 3]>, columns: Columns) -> Self {
        let start = StartFile {
            lengths,
            periodic: None,
            positions: columns.position.map(|_| Vec::new()),
            velocities: columns.velocity.map(|_| Vec::new()),
            spins: columns.spin.map(|_| Vec::new()),
            radii: columns.radius.map(|_| Vec::new()),
            masses: columns.mass.map(|_| Vec::new()),
            types: columns.kind.map(|_| Vec::new()),
            weights: columns.weight.map(|_| Vec::new()),
        };
        Self {
            source,
            columns,
            last_line: 2,
            start,
        }
    }

    fn push<'b>(
        &mut self,
        line: usize,
        value: impl Fn(usize) -> Option<&'b str>,
    ) -> Result<(), FileError> {
        let (source, columns) = (self.source, &self.columns);
        self.last_line = line;
        let vector = |names: [&str; 3], columns: Components| -> Result<Vector3<f64>, FileError> {
            let mut found = Vector3::zeros();
            for ((component, name), column) in found.iter_mut().zip(names).zip(columns) {
                if let Some(column) = column {
                    *component = source.number(line, name, value(column))?;
                }
            }
            Ok(found)
        };
        let start = &mut self.start;
        let vectors = [
            (["x", "y", "z"], columns.position, &mut start.positions),
            (["vx", "vy", "vz"], columns.velocity, &mut start.velocities),
            (["wx", "wy", "wz"], columns.spin, &mut start.spins),
        ];
        for (names, columns, list) in vectors {
            if let (Some(list), Some(columns)) = (list, columns) {
                list.push(vector(names, columns)?);
            }
        }
        let numbers = [
            ("radius", columns.radius, &mut start.radii),
            ("mass", columns.mass, &mut start.masses),
            ("weight", columns.weight, &mut start.weights),
        ];
        for (name, column, list) in numbers {
            if let (Some(list), Some(column)) = (list, column) {
                list.push(source.positive(line, name, value(column))?);
            }
        }
        if let (Some(list), Some(column)) = (&mut start.types, columns.kind) {
            list.push(source.name(line, value(column))?);
        }
        Ok(())
    }

    fn finish(self) -> Result<StartFile, FileError> {
        if self.start.count() == 0 {
            return Err(self
                .source
                .error(self.last_line, "no particle", "at least one"));
        }
        Ok(self.start)
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::vector;

    use super::*;

    fn from_text(name: &str, text: &str) -> Result<StartFile, FileError> {
        let source = Source {
            path: Path::new(name),
        };
        if name.ends_with("csv") {
            read_csv(&source, text)
        } else {
            read_xyz(&source, text)
        }
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

    /// Devices and pipes are refused, `/dev/null` in place of all, because it ends.
    #[cfg(unix)]
    #[test]
    fn what_is_no_file_is_refused() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("start.csv");
        std::os::unix::fs::symlink("/dev/null", &path).expect("a link");
        let said = read(&path).expect_err("no file").to_string();
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
