//! Initial states in text dumps of LAMMPS: one frame of a box that is orthogonal or tilted by `xy`,
//! whose atoms have `x y z` (or scaled `xs ys zs`) and, optionally, `vx vy vz`, `omegax omegay
//! omegaz`, `radius` or `diameter`, `mass`, `type` and `weight`. Further columns are ignored.

use std::collections::HashMap;

use nalgebra::Vector3;

use super::rows::{Columns, Components, FileError, Rows, SourceFile, StartFile};

/// Box of a LAMMPS dump: its lower corner and sides \[length\], its tilt, and its periodic axes.
struct DumpBox {
    lower: Vector3<f64>,
    lengths: [f64; 3],
    /// Displacement of the upper side of the box along x, the tilt factor xy \[length\].
    tilt: f64,
    periodic: [bool; 3],
}

/// Reads an initial state from a text dump of LAMMPS.
pub(super) fn read_dump(source: &SourceFile<'_>, text: &str) -> Result<StartFile, FileError> {
    let mut lines = text
        .lines()
        .enumerate()
        .map(|(index, line)| (index + 1, line));
    let (mut count, mut domain) = (None, None);
    loop {
        let Some((line, item)) = lines.next() else {
            let last = text.lines().count();
            return Err(source.error(last, "the end of the file", "`ITEM: ATOMS`"));
        };
        if let Some(columns) = item.strip_prefix("ITEM: ATOMS") {
            let (Some(count), Some(domain)) = (count, domain) else {
                let expected = "`ITEM: NUMBER OF ATOMS` and `ITEM: BOX BOUNDS` before";
                return Err(source.error(line, "`ITEM: ATOMS`", expected));
            };
            return read_atoms(source, (line, columns), &domain, count, &mut lines);
        } else if item.starts_with("ITEM: NUMBER OF ATOMS") {
            let (line, number) = lines.next().unwrap_or((line + 1, ""));
            let parsed = number.trim().parse::<usize>().ok();
            let refused = || source.error(line, format!("`{number}`"), "the number of atoms");
            count = Some(parsed.ok_or_else(refused)?);
        } else if let Some(ends) = item.strip_prefix("ITEM: BOX BOUNDS") {
            domain = Some(read_bounds(source, line, ends, &mut lines)?);
        } else if item.starts_with("ITEM:") {
            // The time, its number of step, the units.
            lines.next();
        } else {
            return Err(source.error(line, format!("`{item}`"), "a line `ITEM: ...`"));
        }
    }
}

/// Reads the bounds of the box from a LAMMPS dump; `faces` holds the words on its periodic axes.
fn read_bounds<'a>(
    source: &SourceFile<'_>,
    header: usize,
    faces: &str,
    lines: &mut impl Iterator<Item = (usize, &'a str)>,
) -> Result<DumpBox, FileError> {
    let mut words: Vec<&str> = faces.split_whitespace().collect();
    if words.contains(&"abc") {
        let found = format!("`ITEM: BOX BOUNDS{faces}`, a general triclinic box");
        return Err(source.error(header, found, super::TILTED));
    }
    let is_tilted = words.starts_with(&["xy", "xz", "yz"]);
    if is_tilted {
        words.drain(..3);
    }
    let mut domain = DumpBox {
        lower: Vector3::zeros(),
        lengths: [0.0; 3],
        tilt: 0.0,
        // Old dumps do not say; their boxes are periodic.
        periodic: [0, 1, 2].map(|axis| words.get(axis).is_none_or(|word| *word == "pp")),
    };
    for (axis, names) in [["xlo", "xhi"], ["ylo", "yhi"], ["zlo", "zhi"]]
        .iter()
        .enumerate()
    {
        let (line, row) = lines.next().unwrap_or((header + axis + 1, ""));
        let mut values = row.split_whitespace();
        let mut low = source.number(line, names[0], values.next())?;
        let mut high = source.number(line, names[1], values.next())?;
        if is_tilted {
            // The line of x has xy, that of y has xz, and that of z has yz.
            let tilt = source.number(line, "the tilt", values.next())?;
            if axis > 0 && tilt != 0.0 {
                return Err(source.error(line, format!("`{row}`"), super::TILTED));
            } else if axis == 0 {
                // Bounds are those of the tilted box.
                domain.tilt = tilt;
                low -= tilt.min(0.0);
                high -= tilt.max(0.0);
            }
        }
        if high <= low {
            return Err(source.error(line, format!("`{row}`"), "a lower and a higher bound"));
        }
        domain.lower[axis] = low;
        domain.lengths[axis] = high - low;
    }
    Ok(domain)
}

/// Reads the atoms of a LAMMPS dump, after the line with the names of their columns.
fn read_atoms<'a>(
    source: &SourceFile<'_>,
    (header, names): (usize, &str),
    domain: &DumpBox,
    count: usize,
    lines: &mut impl Iterator<Item = (usize, &'a str)>,
) -> Result<StartFile, FileError> {
    let columns: HashMap<&str, usize> = (names.split_whitespace().enumerate())
        .map(|(column, name)| (name, column))
        .collect();
    let single = |name: &str| columns.get(name).copied();
    let vector = |names: [&str; 3]| -> Option<Components> {
        let found = names.map(single);
        (found[0].is_some() && found[1].is_some()).then_some(found)
    };
    let scaled = vector(["xs", "ys", "zs"]);
    let placed = vector(["x", "y", "z"]);
    let position = placed.or(scaled).ok_or_else(|| {
        let expected = "columns `x y z` or `xs ys zs` among them";
        source.error(header, format!("`ITEM: ATOMS{names}`"), expected)
    })?;
    let diameter = single("diameter").filter(|_| single("radius").is_none());
    let table = Columns {
        position: Some(position),
        velocity: vector(["vx", "vy", "vz"]),
        spin: vector(["omegax", "omegay", "omegaz"]),
        radius: single("radius").or(diameter),
        mass: single("mass"),
        kind: single("type"),
        weight: single("weight"),
    };
    let mut rows = Rows::new(source, Some(domain.lengths), table);
    rows.start.periodic = Some(domain.periodic);
    rows.start.shear_offset = domain.tilt;
    let mut start = rows.read(lines, header, count)?;
    for place in start.positions.iter_mut().flatten() {
        *place = if placed.is_some() {
            *place - domain.lower
        } else {
            // Scaled places are parts of the vectors of the box.
            let tilt = Vector3::new(domain.tilt * place.y, 0.0, 0.0);
            place.component_mul(&Vector3::from(domain.lengths)) + tilt
        };
    }
    if diameter.is_some() {
        start
            .radii
            .iter_mut()
            .flatten()
            .for_each(|radius| *radius *= 0.5);
    }
    Ok(start)
}
