//! Content of a file with an initial state, assembled row by row, and errors that name file and
//! line.

use std::io;
use std::path::{Path, PathBuf};

use nalgebra::Vector3;

/// Content of a file with an initial state, as written; vector components that the file lacks are
/// zero.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StartFile {
    /// Side lengths of the box \[length\], the third 0 where the file names two; `None` without a
    /// box.
    pub lengths: Option<[f64; 3]>,
    /// Displacement of the periodic image above along x, from the tilt of a box in shear flow
    /// \[length\]; 0 for a rectangular box. It may be negative or beyond the width.
    pub shear_offset: f64,
    /// True for each axis along which the box is periodic; `None` where the file does not state it.
    pub periodic: Option<[bool; 3]>,
    /// Position of the centre of each particle \[length\]; `None` if the file has no positions.
    pub positions: Option<Vec<Vector3<f64>>>,
    /// Velocity of each particle \[length/time\]; `None` if the file has no velocities.
    pub velocities: Option<Vec<Vector3<f64>>>,
    /// Angular velocity of each particle \[1/time\]; `None` if the file has none.
    pub spins: Option<Vec<Vector3<f64>>>,
    /// Radius of each particle \[length\]; `None` if the file has no radii.
    pub radii: Option<Vec<f64>>,
    /// Mass of each particle \[mass\]; `None` if the file has no masses.
    pub masses: Option<Vec<f64>>,
    /// Species name of each particle; `None` if the file has no types.
    pub types: Option<Vec<String>>,
    /// Weight of each particle of the file, the number of particles it stands for; `None` if the
    /// file has no weights.
    pub weights: Option<Vec<f64>>,
    /// True if the numbers in the file have single precision, with a relative rounding of 2^-24.
    pub is_single_precision: bool,
}

impl StartFile {
    /// Returns the number of particles in the file.
    pub fn count(&self) -> usize {
        let placed = self.positions.as_ref().or(self.velocities.as_ref());
        placed.map_or(0, Vec::len)
    }
}

/// Error why a file with an initial state could not be read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum FileError {
    /// The file could not be read from disk.
    #[error("{}: {source}", path.display())]
    Unreadable {
        /// Path of the unreadable file.
        path: PathBuf,
        /// Error of the operating system.
        source: io::Error,
    },
    /// A line of a text file has invalid content.
    #[error("{}:{line}: found {found}; expected {expected}", path.display())]
    Content {
        /// Path of the text file with the invalid line.
        path: PathBuf,
        /// Number of the invalid line, from 1.
        line: usize,
        /// Text found in the invalid line.
        found: String,
        /// Text that is expected in this line.
        expected: String,
    },
    /// A frame of a binary file has invalid content.
    #[error("{}, frame {frame}: found {found}; expected {expected}", path.display())]
    Frame {
        /// Path of the binary file with the invalid frame.
        path: PathBuf,
        /// Number of the invalid frame, from 0.
        frame: u64,
        /// Content found in the invalid frame.
        found: String,
        /// Content that is expected in this frame.
        expected: String,
    },
}

/// Largest number allowed in a file with an initial state: squares and ratios of such numbers are
/// still finite.
pub(super) const LARGEST: f64 = 1e100;

/// Description of the allowed names of species, for error messages.
pub(super) const SPECIES_NAME: &str = "a name of 1 to 40 characters other than \"all\"";

/// Returns true if a text is an allowed name of a species.
pub(super) fn is_species_name(name: &str) -> bool {
    let plain = !name.chars().any(char::is_control) && name.chars().count() <= 40;
    plain && !name.is_empty() && name != "all"
}

/// Path of the file that is being read, for its error messages.
pub(super) struct SourceFile<'a> {
    pub(super) path: &'a Path,
}

impl SourceFile<'_> {
    /// Creates the error that a line of the file has invalid content.
    pub(super) fn error(
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

    /// Creates the error that a frame of the binary file has invalid content.
    pub(super) fn frame_error(
        &self,
        frame: u64,
        found: impl Into<String>,
        expected: impl Into<String>,
    ) -> FileError {
        FileError::Frame {
            path: self.path.to_owned(),
            frame,
            found: found.into(),
            expected: expected.into(),
        }
    }

    /// Reads a number from the column `name` of a line; an error if it is missing or invalid.
    pub(super) fn number(
        &self,
        line: usize,
        name: &str,
        text: Option<&str>,
    ) -> Result<f64, FileError> {
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

    /// Reads a number above zero from the column `name` of a line; an error otherwise.
    pub(super) fn positive(
        &self,
        line: usize,
        name: &str,
        text: Option<&str>,
    ) -> Result<f64, FileError> {
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

    /// Reads the name of a species from a column of a line; an error if it is not allowed.
    pub(super) fn name(&self, line: usize, text: Option<&str>) -> Result<String, FileError> {
        let name = text.unwrap_or("").trim();
        if is_species_name(name) {
            Ok(name.to_owned())
        } else {
            Err(self.error(line, format!("type = `{name}`"), SPECIES_NAME))
        }
    }
}

/// Column index of each component of a vector; `None` for components that the file lacks.
pub(super) type Components = [Option<usize>; 3];

/// Column index of each quantity in a file with an initial state.
#[derive(Default)]
pub(super) struct Columns {
    pub(super) position: Option<Components>,
    pub(super) velocity: Option<Components>,
    pub(super) spin: Option<Components>,
    pub(super) radius: Option<usize>,
    pub(super) mass: Option<usize>,
    pub(super) kind: Option<usize>,
    pub(super) weight: Option<usize>,
}

/// Particles of an initial state that is being read, row by row.
pub(super) struct Rows<'a> {
    source: &'a SourceFile<'a>,
    columns: Columns,
    last_line: usize,
    pub(super) start: StartFile,
}

impl<'a> Rows<'a> {
    /// Creates an empty initial state for a file with the given box \[length\] and columns.
    pub(super) fn new(
        source: &'a SourceFile<'a>,
        lengths: Option<[f64; 3]>,
        columns: Columns,
    ) -> Self {
        let start = StartFile {
            lengths,
            positions: columns.position.map(|_| Vec::new()),
            velocities: columns.velocity.map(|_| Vec::new()),
            spins: columns.spin.map(|_| Vec::new()),
            radii: columns.radius.map(|_| Vec::new()),
            masses: columns.mass.map(|_| Vec::new()),
            types: columns.kind.map(|_| Vec::new()),
            weights: columns.weight.map(|_| Vec::new()),
            ..StartFile::default()
        };
        Self {
            source,
            columns,
            last_line: 2,
            start,
        }
    }

    /// Adds the particle in one line of the file; `value` gives the text in each column.
    pub(super) fn push<'b>(
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

    /// Reads `count` particles, one in each line with columns between spaces, and checks that
    /// nothing follows them. `header` is the number of the line before the first.
    pub(super) fn read<'b>(
        mut self,
        lines: &mut impl Iterator<Item = (usize, &'b str)>,
        header: usize,
        count: usize,
    ) -> Result<StartFile, FileError> {
        self.last_line = header;
        for _ in 0..count {
            let Some((line, row)) = lines.next() else {
                let expected = format!("{count} particles");
                return Err(self
                    .source
                    .error(self.last_line, "the end of the file", expected));
            };
            let values: Vec<&str> = row.split_whitespace().collect();
            self.push(line, |column| values.get(column).copied())?;
        }
        if let Some((line, row)) = lines.find(|(_, row)| !row.trim().is_empty()) {
            let expected = format!("nothing after {count} particles (one frame)");
            return Err(self.source.error(line, format!("`{row}`"), expected));
        }
        self.finish()
    }

    /// Returns the complete initial state; an error if it has no particle.
    pub(super) fn finish(self) -> Result<StartFile, FileError> {
        if self.start.count() == 0 {
            return Err(self
                .source
                .error(self.last_line, "no particle", "at least one"));
        }
        Ok(self.start)
    }
}
