//! Initial states in CSV files: a first line `# box: Lx Ly` (`Lx Ly Lz` of spheres), then a header
//! with the columns `x,y` (`z`) and, optionally, `vx,vy,vz,wx,wy,wz,radius,mass,type` in any order;
//! velocities alone need no box.

use std::collections::HashMap;

use super::rows::{Columns, FileError, Rows, SourceFile, StartFile};

/// Names of the columns that a CSV file of an initial state may have.
const NAMES: [&str; 12] = [
    "x", "y", "z", "vx", "vy", "vz", "wx", "wy", "wz", "radius", "mass", "type",
];

/// Reads an initial state from the text of a CSV file.
pub(super) fn read_csv(source: &SourceFile<'_>, text: &str) -> Result<StartFile, FileError> {
    let first = text.lines().next().unwrap_or("");
    let boxed = first.strip_prefix("# box:");
    let lengths = boxed.map(|rest| csv_box(source, first, rest)).transpose()?;
    let header = if boxed.is_some() { 2 } else { 1 };
    let mut reader = ::csv::ReaderBuilder::new()
        .comment(Some(b'#'))
        .trim(::csv::Trim::All)
        .from_reader(text.as_bytes());
    let line_of = |position: Option<&::csv::Position>| position.map_or(0, |p| p.line() as usize);
    let table = |error: &::csv::Error| {
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

/// Reads the side lengths of the box from the first line of a CSV file.
fn csv_box(source: &SourceFile<'_>, line: &str, sides: &str) -> Result<[f64; 3], FileError> {
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
