//! Starts read from a file: CSV, or the extended XYZ that OVITO and ASE write.
//!
//! CSV: a first line `# box: Lx Ly`, then a header with the columns `x,y` and, optionally,
//! `vx,vy,radius,mass` in any order. Extended XYZ: a second line with `Lattice="..."` (orthogonal) and
//! `Properties=...` naming `pos`, and optionally `velo`, `radius`, `mass`.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::{fs, io};

use nalgebra::{Vector2, vector};

/// What a start file says. Radii and masses are as written, or the given defaults.
#[derive(Clone, Debug, PartialEq)]
pub struct StartFile {
    /// Side lengths of the periodic box.
    pub lengths: [f64; 2],
    /// Centres.
    pub positions: Vec<Vector2<f64>>,
    /// Velocities, if the file has them.
    pub velocities: Option<Vec<Vector2<f64>>>,
    /// Radii, if the file has them.
    pub radii: Option<Vec<f64>>,
    /// Masses, if the file has them.
    pub masses: Option<Vec<f64>>,
}

/// Why a start file could not be used.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum FileError {
    /// The file could not be read.
    #[error("{}: {source}", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// A line has something else than what belongs there.
    #[error("{}:{line}: found {found}; expected {expected}", path.display())]
    Content {
        /// The file.
        path: PathBuf,
        /// Line, from 1.
        line: usize,
        /// What was found.
        found: String,
        /// What belongs there.
        expected: String,
    },
}

/// Largest number of a start file: squares and ratios of such numbers are still finite.
const LARGEST: f64 = 1e100;

/// Most columns of one property of an extended XYZ file.
const MOST_COLUMNS: usize = 1000;

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

/// Which column holds what.
struct Columns {
    position: [usize; 2],
    velocity: Option<[usize; 2]>,
    radius: Option<usize>,
    mass: Option<usize>,
}

/// Reads a start file; its name's ending (`.csv` or `.xyz`) decides the format.
///
/// # Errors
/// [`FileError`] names the file, the line, what was found and what belongs there.
pub fn read(path: &Path) -> Result<StartFile, FileError> {
    let failed = |source| FileError::Unreadable {
        path: path.to_owned(),
        source,
    };
    // A run reads it more than once, and would wait for a pipe.
    if !fs::metadata(path).map_err(failed)?.is_file() {
        let kind = io::ErrorKind::InvalidInput;
        return Err(failed(io::Error::new(
            kind,
            "a folder, a pipe or a device; expected a file",
        )));
    }
    let text = fs::read_to_string(path).map_err(failed)?;
    // Editors of some systems begin a file with a byte order mark.
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
    let sizes: Vec<&str> = first
        .strip_prefix("# box:")
        .map(|rest| rest.split_whitespace().collect())
        .unwrap_or_default();
    if sizes.len() != 2 {
        return Err(source.error(
            1,
            format!("`{first}`"),
            "`# box: Lx Ly`, the sides of the periodic box",
        ));
    }
    let lengths = [
        source.positive(1, "Lx", Some(sizes[0]))?,
        source.positive(1, "Ly", Some(sizes[1]))?,
    ];
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
    let mut names = HashMap::new();
    for (column, name) in headers.iter().enumerate() {
        if !["x", "y", "vx", "vy", "radius", "mass"].contains(&name) {
            return Err(source.error(
                2,
                format!("column `{name}`"),
                "columns x, y, vx, vy, radius, mass",
            ));
        }
        if names.insert(name.to_owned(), column).is_some() {
            return Err(source.error(2, format!("column `{name}` twice"), "each column once"));
        }
    }
    let column = |name: &str| names.get(name).copied();
    let pair = |a: &str, b: &str| match (column(a), column(b)) {
        (Some(a), Some(b)) => Ok(Some([a, b])),
        (None, None) => Ok(None),
        _ => Err(source.error(
            2,
            format!("only one of the columns `{a}` and `{b}`"),
            "both or none",
        )),
    };
    let columns = Columns {
        position: pair("x", "y")?.ok_or_else(|| {
            source.error(
                2,
                "no columns `x` and `y`",
                "columns x, y, vx, vy, radius, mass",
            )
        })?,
        velocity: pair("vx", "vy")?,
        radius: column("radius"),
        mass: column("mass"),
    };
    let mut rows = Rows::new(source, lengths, columns);
    for record in reader.records() {
        let record = record.map_err(|error| table(&error))?;
        rows.push(line_of(record.position()), |column| record.get(column))?;
    }
    rows.finish()
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
    ];
    let properties = fields
        .get("properties")
        .map_or("species:S:1:pos:R:3", String::as_str);
    let parts: Vec<&str> = properties.split(':').collect();
    let mut columns = HashMap::new();
    let mut next = 0;
    for property in parts.chunks(3) {
        // A bound, so that sums of widths are numbers, too.
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
    let planar = |name: &str| {
        columns
            .get(name)
            .filter(|entry| entry.1 >= 2)
            .map(|entry| [entry.0, entry.0 + 1])
    };
    let single = |name: &str| columns.get(name).map(|entry| entry.0);
    let columns = Columns {
        position: planar("pos").ok_or_else(|| {
            source.error(
                2,
                format!("Properties={properties}"),
                "pos:R:2 or pos:R:3 among them",
            )
        })?,
        velocity: planar("velo").or_else(|| planar("vel")),
        radius: single("radius"),
        mass: single("mass").or_else(|| single("masses")),
    };
    let mut rows = Rows::new(source, lengths, columns);
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
    fn new(source: &'a Source<'a>, lengths: [f64; 2], columns: Columns) -> Self {
        let start = StartFile {
            lengths,
            positions: Vec::new(),
            velocities: columns.velocity.map(|_| Vec::new()),
            radii: columns.radius.map(|_| Vec::new()),
            masses: columns.mass.map(|_| Vec::new()),
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
        let source = self.source;
        self.last_line = line;
        let planar = |names: [&str; 2], columns: [usize; 2]| -> Result<Vector2<f64>, FileError> {
            let x = source.number(line, names[0], value(columns[0]))?;
            let y = source.number(line, names[1], value(columns[1]))?;
            Ok(vector![x, y])
        };
        self.start
            .positions
            .push(planar(["x", "y"], self.columns.position)?);
        if let (Some(velocities), Some(columns)) =
            (&mut self.start.velocities, self.columns.velocity)
        {
            velocities.push(planar(["vx", "vy"], columns)?);
        }
        if let (Some(radii), Some(column)) = (&mut self.start.radii, self.columns.radius) {
            radii.push(source.positive(line, "radius", value(column))?);
        }
        if let (Some(masses), Some(column)) = (&mut self.start.masses, self.columns.mass) {
            masses.push(source.positive(line, "mass", value(column))?);
        }
        Ok(())
    }

    fn finish(self) -> Result<StartFile, FileError> {
        if self.start.positions.is_empty() {
            return Err(self
                .source
                .error(self.last_line, "no particle", "at least one"));
        }
        Ok(self.start)
    }
}

#[cfg(test)]
mod tests {
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
        let csv =
            "# box: 10 8\nx,y,vx,vy,radius,mass\n1,2,0.5,-0.5,0.5,1\n# a remark\n3,4,-1,1,0.25,2\n";
        let xyz = "2\nTime=0 Lattice=\"10 0 0 0 8 0 0 0 1\" Properties=id:I:1:pos:R:3:velo:R:3:radius:R:1:mass:R:1\n\
                   1 1 2 0 0.5 -0.5 0 0.5 1\n2 3 4 0 -1 1 0 0.25 2\n";
        let start = from_text("a.csv", csv).expect("a start");
        assert_eq!(start, from_text("a.xyz", xyz).expect("a start"));
        assert_eq!(start.lengths, [10.0, 8.0]);
        assert_eq!(start.radii, Some(vec![0.5, 0.25]));
        let bare = from_text("a.csv", "# box: 1 1\ny,x\n0.5,0.25\n").expect("positions alone");
        assert_eq!(bare.positions, vec![vector![0.25, 0.5]]);
        assert_eq!(bare.velocities, None);
    }

    /// `/dev/null` is a device that ends; of others, and of pipes, that is not known.
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
            ("a.csv", "# box: 1 1\nx,z\n", 2, "column `z`"),
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
