//! Initial states in data files of LAMMPS (`write_data`, `read_data`): the sections `Atoms` of the
//! styles `atomic` and `sphere`, `Masses` and `Velocities`. Other sections are ignored.

use std::collections::HashMap;
use std::f64::consts::PI;

use nalgebra::Vector3;

use super::rows::{Columns, FileError, Rows, SourceFile, StartFile};

/// Row of a section in a LAMMPS data file: its line number, and its words.
type Row<'a> = (usize, Vec<&'a str>);

/// Section of a LAMMPS data file, such as `Atoms`, with its rows.
struct Section<'a> {
    /// Number of the line with the name of the section.
    line: usize,
    /// Comment after the name of the section, which is the atom style.
    remark: &'a str,
    rows: Vec<Row<'a>>,
}

/// Description of the atom styles that can be read, with the columns of a row, for error messages.
const STYLES: &str = "`Atoms # sphere` (id type diameter density x y z) or `Atoms # atomic` (id type x y z); a text dump \
                      with the columns id type x y z vx vy vz radius mass has those of any style";

/// Reads an initial state from the text of a LAMMPS data file.
pub(super) fn read_data(source: &SourceFile<'_>, text: &str) -> Result<StartFile, FileError> {
    let (head, sections) = split_sections(text);
    let last = text.lines().count().max(1);
    let bounds = Bounds::of(source, &head, last)?;
    let absent = |what: &str| source.error(last, "the end of the file", what);
    let atoms = sections
        .get("Atoms")
        .ok_or_else(|| absent("a section `Atoms`"))?;
    let count = head
        .iter()
        .find(|(_, words)| words.get(1) == Some(&"atoms"));
    let (line, words) = count.ok_or_else(|| absent("a line `N atoms` at the beginning"))?;
    let count = words[0].parse::<usize>().map_err(|_| {
        let found = format!("`{} atoms`", words[0]);
        source.error(*line, found, "the number of atoms")
    })?;
    if atoms.rows.len() != count {
        let found = format!("{} atoms", atoms.rows.len());
        return Err(source.error(
            atoms.line,
            found,
            format!("{count} atoms, as line {line} says"),
        ));
    }
    let is_sphere = style(source, atoms)?;
    let first = if is_sphere { 4 } else { 2 };
    let columns = Columns {
        position: Some([0, 1, 2].map(|axis| Some(first + axis))),
        radius: is_sphere.then_some(2),
        mass: is_sphere.then_some(3),
        kind: Some(1),
        ..Columns::default()
    };
    let mut rows = Rows::new(source, Some(bounds.lengths), columns);
    for (line, words) in &atoms.rows {
        rows.push(*line, |column| words.get(column).copied())?;
    }
    let mut start = rows.finish()?;
    start.shear_offset = bounds.tilt;
    for place in start.positions.iter_mut().flatten() {
        *place -= bounds.lower;
    }
    for radius in start.radii.iter_mut().flatten() {
        *radius *= 0.5;
    }
    let radii = start.radii.iter().flatten();
    for (density, radius) in start.masses.iter_mut().flatten().zip(radii) {
        // LAMMPS gives atoms of this style the mass of a sphere, also in the plane.
        *density *= 4.0 / 3.0 * PI * radius.powi(3);
    }
    if let (Some(masses), false) = (sections.get("Masses"), is_sphere) {
        start.masses = Some(masses_of_types(source, masses, atoms)?);
    }
    if let Some(velocities) = sections.get("Velocities") {
        add_velocities(source, velocities, atoms, &mut start)?;
    }
    Ok(start)
}

/// Splits a LAMMPS data file into the rows of its head, and its sections by name.
fn split_sections(text: &str) -> (Vec<Row<'_>>, HashMap<String, Section<'_>>) {
    let (mut head, mut sections) = (Vec::new(), HashMap::<String, Section<'_>>::new());
    let mut name = String::new();
    // The first line is a remark.
    for (index, line) in text.lines().enumerate().skip(1) {
        let (content, remark) = line.split_once('#').unwrap_or((line, ""));
        let words: Vec<&str> = content.split_whitespace().collect();
        if words.is_empty() {
            continue;
        }
        if words.iter().all(|word| word.parse::<f64>().is_err()) {
            name = words.join(" ");
            let section = Section {
                line: index + 1,
                remark: remark.trim(),
                rows: Vec::new(),
            };
            sections.insert(name.clone(), section);
        } else if let Some(section) = sections.get_mut(&name) {
            section.rows.push((index + 1, words));
        } else {
            head.push((index + 1, words));
        }
    }
    (head, sections)
}

/// Box of a LAMMPS data file: its lower corner, sides and tilt.
struct Bounds {
    lower: Vector3<f64>,
    lengths: [f64; 3],
    /// Displacement of the upper side of the box along x, the tilt factor xy \[length\].
    tilt: f64,
}

impl Bounds {
    fn of(source: &SourceFile<'_>, head: &[Row<'_>], last: usize) -> Result<Self, FileError> {
        let mut bounds = Self {
            lower: Vector3::zeros(),
            lengths: [0.0; 3],
            tilt: 0.0,
        };
        let mut known = [false; 3];
        for (line, words) in head {
            let number =
                |name: &str, column: usize| source.number(*line, name, words.get(column).copied());
            for (axis, names) in [["xlo", "xhi"], ["ylo", "yhi"], ["zlo", "zhi"]]
                .iter()
                .enumerate()
            {
                if words.get(2..) == Some(names.as_slice()) {
                    let (low, high) = (number(names[0], 0)?, number(names[1], 1)?);
                    if high <= low {
                        let found = format!("`{}`", words.join(" "));
                        return Err(source.error(*line, found, "a lower and a higher bound"));
                    }
                    bounds.lower[axis] = low;
                    bounds.lengths[axis] = high - low;
                    known[axis] = true;
                }
            }
            if words.get(3..) == Some(["xy", "xz", "yz"].as_slice()) {
                bounds.tilt = number("xy", 0)?;
                if number("xz", 1)? != 0.0 || number("yz", 2)? != 0.0 {
                    let found = format!("`{}`", words.join(" "));
                    return Err(source.error(*line, found, super::TILTED));
                }
            }
            if words.contains(&"avec") {
                let found = format!("`{}`, a general triclinic box", words.join(" "));
                return Err(source.error(*line, found, super::TILTED));
            }
        }
        if known == [true; 3] {
            return Ok(bounds);
        }
        let expected = "lines `LOW HIGH xlo xhi`, and the same of y and z, before the sections";
        Err(source.error(last, "the end of the file", expected))
    }
}

/// Determines the atom style of a LAMMPS data file: true for `sphere` (diameter and density), false
/// for `atomic` (points).
fn style(source: &SourceFile<'_>, atoms: &Section<'_>) -> Result<bool, FileError> {
    let width = atoms.rows.first().map_or(0, |(_, words)| words.len());
    match (atoms.remark, width) {
        ("sphere", _) | ("", 7 | 10) => Ok(true),
        ("atomic", _) | ("", 5 | 8) => Ok(false),
        ("", _) => {
            let found = format!("`Atoms` without a style, in {width} columns");
            Err(source.error(atoms.line, found, STYLES))
        }
        (other, _) => {
            Err(source.error(atoms.line, format!("atoms of the style `{other}`"), STYLES))
        }
    }
}

/// Returns the mass of each atom of a LAMMPS data file, by its type in the section `Masses`.
fn masses_of_types(
    source: &SourceFile<'_>,
    masses: &Section<'_>,
    atoms: &Section<'_>,
) -> Result<Vec<f64>, FileError> {
    let mut known = HashMap::new();
    for (line, words) in &masses.rows {
        let mass = source.positive(*line, "mass", words.get(1).copied())?;
        known.insert(words[0], mass);
    }
    let mass = |(line, words): &Row<'_>| {
        let kind = words.get(1).copied().unwrap_or("");
        known.get(kind).copied().ok_or_else(|| {
            let expected = format!("a type of the section `Masses` in line {}", masses.line);
            source.error(*line, format!("type `{kind}`"), expected)
        })
    };
    atoms.rows.iter().map(mass).collect()
}

/// Adds velocities and angular velocities from the section `Velocities` of a LAMMPS data file to
/// the atoms with the same numbers.
fn add_velocities(
    source: &SourceFile<'_>,
    velocities: &Section<'_>,
    atoms: &Section<'_>,
    start: &mut StartFile,
) -> Result<(), FileError> {
    let known: HashMap<&str, &Row<'_>> = (velocities.rows.iter())
        .filter_map(|row| Some((*row.1.first()?, row)))
        .collect();
    let turns = velocities
        .rows
        .first()
        .is_some_and(|(_, words)| words.len() >= 7);
    let (mut speeds, mut spins) = (Vec::new(), Vec::new());
    for (_, words) in &atoms.rows {
        let id = words.first().copied().unwrap_or("");
        let Some((line, words)) = known.get(id) else {
            let found = format!("no velocity of atom {id}");
            return Err(source.error(velocities.line, found, "one of each atom"));
        };
        let vector = |names: [&str; 3], first: usize| -> Result<Vector3<f64>, FileError> {
            let mut found = Vector3::zeros();
            for (axis, name) in names.iter().enumerate() {
                found[axis] = source.number(*line, name, words.get(first + axis).copied())?;
            }
            Ok(found)
        };
        speeds.push(vector(["vx", "vy", "vz"], 1)?);
        if turns {
            spins.push(vector(["wx", "wy", "wz"], 4)?);
        }
    }
    start.velocities = Some(speeds);
    start.spins = turns.then_some(spins);
    Ok(())
}
