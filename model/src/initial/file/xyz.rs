//! Initial states in extended XYZ files, as OVITO and ASE write: a second line with `Lattice="..."`
//! (orthogonal, or with its second vector tilted along x) and `Properties=...` naming `pos`, and
//! optionally `velo`, `angular_velocity`, `radius`, `mass`, `type` or `species`, `weight`; and
//! `pbc="..."`, optionally.

use std::collections::HashMap;

use super::rows::{Columns, Components, FileError, Rows, SourceFile, StartFile};

/// Largest number of columns of one property in an extended XYZ file.
const MOST_COLUMNS: usize = 1000;

/// Reads which axes are periodic from the `pbc` of an extended XYZ file.
fn xyz_periodic(source: &SourceFile<'_>, text: &str) -> Result<[bool; 3], FileError> {
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

/// Reads an initial state from the text of an extended XYZ file.
pub(super) fn read_xyz(source: &SourceFile<'_>, text: &str) -> Result<StartFile, FileError> {
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
    let mut shear_offset = 0.0;
    for (index, entry) in entries.iter().enumerate() {
        let value = source.number(2, "Lattice", Some(entry))?;
        match index {
            3 => shear_offset = value,
            0 | 4 | 8 => {}
            _ if value == 0.0 => {}
            _ => return Err(source.error(2, format!("Lattice=\"{lattice}\""), super::TILTED)),
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
    rows.start.shear_offset = shear_offset;
    rows.read(&mut lines, 2, count)
}

/// Splits the second line of an extended XYZ file into its fields `key=value` or `key="quoted
/// value"`, with keys in lower case.
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
