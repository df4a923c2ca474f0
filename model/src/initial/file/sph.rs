//! Initial states in `.sph` files of the program EDMD: the number of particles, the sides of the
//! box, and a line `LABEL x y z radius` for each particle. Labels are names of species.

use super::rows::{Columns, FileError, Rows, SourceFile, StartFile};

/// Reads an initial state from the text of a `.sph` file.
pub(super) fn read_sph(source: &SourceFile<'_>, text: &str) -> Result<StartFile, FileError> {
    let mut lines = text
        .lines()
        .enumerate()
        .map(|(index, line)| (index + 1, line));
    let (_, first) = lines.next().unwrap_or((1, ""));
    // A time may follow.
    let count = first
        .split_whitespace()
        .next()
        .and_then(|word| word.parse().ok());
    let count: usize =
        count.ok_or_else(|| source.error(1, format!("`{first}`"), "the number of particles"))?;
    let (_, sides) = lines.next().unwrap_or((2, ""));
    let mut words = sides.split_whitespace();
    let lengths = [
        source.positive(2, "Lx", words.next())?,
        source.positive(2, "Ly", words.next())?,
        source.number(2, "Lz", words.next())?,
    ];
    let columns = Columns {
        position: Some([1, 2, 3].map(Some)),
        radius: Some(4),
        kind: Some(0),
        ..Columns::default()
    };
    Rows::new(source, Some(lengths), columns).read(&mut lines, 2, count)
}
