//! Reading tables, JSON files and snapshots of a results folder, with the place of every fault.

use std::fs;
use std::io::ErrorKind;
use std::path::Path;

use csv::{DeserializeErrorKind, Reader, ReaderBuilder, StringRecord};
use serde::de::DeserializeOwned;

use super::ReportError;
use crate::tables::Row;

/// Reads the table of `R` in `folder`; `None` when there is no such file.
pub(crate) fn table<R: Row>(folder: &Path) -> Result<Option<Vec<R>>, ReportError> {
    let path = folder.join(R::FILE);
    let file = match fs::File::open(&path) {
        Ok(file) => file,
        Err(fault) if fault.kind() == ErrorKind::NotFound => return Ok(None),
        Err(source) => return Err(ReportError::Read { file: path, source }),
    };
    let mut reader = ReaderBuilder::new().comment(Some(b'#')).from_reader(file);
    let headers = reader
        .headers()
        .map_err(|fault| table_fault(&path, fault))?
        .clone();
    if headers.iter().ne(R::COLUMNS.iter().copied()) {
        return Err(ReportError::Columns {
            file: path,
            found: headers.iter().map(str::to_owned).collect(),
            expected: R::COLUMNS,
        });
    }
    rows(&mut reader, &headers, &path).map(Some)
}

/// Reads the rows that follow the header line.
fn rows<R: Row>(
    reader: &mut Reader<fs::File>,
    headers: &StringRecord,
    path: &Path,
) -> Result<Vec<R>, ReportError> {
    let mut rows = Vec::new();
    let mut record = StringRecord::new();
    while reader
        .read_record(&mut record)
        .map_err(|fault| table_fault(path, fault))?
    {
        match record.deserialize(Some(headers)) {
            Ok(row) => rows.push(row),
            Err(fault) => return Err(cell_fault(path, headers, &record, fault)),
        }
    }
    Ok(rows)
}

/// Says which cell could not be read.
fn cell_fault(
    path: &Path,
    headers: &StringRecord,
    record: &StringRecord,
    fault: csv::Error,
) -> ReportError {
    let csv::ErrorKind::Deserialize { err, .. } = fault.kind() else {
        return table_fault(path, fault);
    };
    let field = err.field().and_then(|index| usize::try_from(index).ok());
    let text = |source: &StringRecord| {
        field
            .and_then(|index| source.get(index))
            .unwrap_or_default()
            .to_owned()
    };
    let expected = match err.kind() {
        DeserializeErrorKind::ParseFloat(_) => "a number".to_owned(),
        DeserializeErrorKind::ParseInt(_) => "a whole number, not negative".to_owned(),
        other => other.to_string(),
    };
    ReportError::Cell {
        file: path.to_owned(),
        line: record.position().map_or(0, csv::Position::line),
        column: text(headers),
        found: text(record),
        expected,
    }
}

/// Says what is wrong with a table outside its cells.
fn table_fault(path: &Path, fault: csv::Error) -> ReportError {
    let file = path.to_owned();
    let line = fault.position().map_or(0, csv::Position::line);
    match fault.into_kind() {
        csv::ErrorKind::Io(source) => ReportError::Read { file, source },
        csv::ErrorKind::UnequalLengths {
            expected_len, len, ..
        } => ReportError::Length {
            file,
            line,
            found: len,
            expected: expected_len,
        },
        csv::ErrorKind::Utf8 { .. } => ReportError::Encoding { file, line },
        other => ReportError::Cell {
            file,
            line,
            column: String::new(),
            found: format!("{other:?}"),
            expected: "a row of a table".to_owned(),
        },
    }
}

/// Reads a JSON file; the error names the key.
pub(crate) fn json<T: DeserializeOwned>(path: &Path) -> Result<T, ReportError> {
    let file = path.to_owned();
    let text = fs::read(path).map_err(|source| ReportError::Read {
        file: file.clone(),
        source,
    })?;
    let mut source = serde_json::Deserializer::from_slice(&text);
    serde_path_to_error::deserialize(&mut source).map_err(|fault| {
        let key = fault.path().to_string();
        let source = fault.into_inner();
        ReportError::Json {
            file,
            key,
            line: source.line(),
            column: source.column(),
            source,
        }
    })
}

/// Particles at one instant.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Particles {
    /// Sides of the domain.
    pub sides: [f64; 2],
    /// Positions, velocities and radii.
    pub disks: Vec<Disk>,
}

/// One particle of a snapshot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Disk {
    /// Position.
    pub position: [f64; 2],
    /// Velocity.
    pub velocity: [f64; 2],
    /// Radius.
    pub radius: f64,
}

/// Reads the number of particles in the first line of a snapshot; `None` when there is no such file.
pub(crate) fn particle_count(path: &Path) -> Result<Option<usize>, ReportError> {
    use std::io::{BufRead, BufReader, Read};
    let fault = |source| ReportError::Read {
        file: path.to_owned(),
        source,
    };
    let file = match fs::File::open(path) {
        Ok(file) => file,
        Err(source) if source.kind() == ErrorKind::NotFound => return Ok(None),
        Err(source) => return Err(fault(source)),
    };
    let mut line = Vec::new();
    BufReader::new(file.take(64))
        .read_until(b'\n', &mut line)
        .map_err(fault)?;
    let line = String::from_utf8_lossy(&line);
    match line.trim().parse() {
        Ok(count) => Ok(Some(count)),
        Err(_) => Err(snapshot_fault(
            path,
            1,
            line.trim(),
            "the number of particles",
        )),
    }
}

/// Reads an extended XYZ snapshot.
pub(crate) fn snapshot(path: &Path) -> Result<Particles, ReportError> {
    let bytes = fs::read(path).map_err(|source| ReportError::Read {
        file: path.to_owned(),
        source,
    })?;
    let text = String::from_utf8_lossy(&bytes);
    let mut lines = text.lines();
    let first = lines.next().unwrap_or_default();
    let count: usize = first
        .trim()
        .parse()
        .map_err(|_| snapshot_fault(path, 1, first, "the number of particles"))?;
    let header = lines.next().unwrap_or_default();
    let sides = sides(header).ok_or_else(|| {
        snapshot_fault(
            path,
            2,
            header,
            "Lattice=\"Lx 0 0 0 Ly 0 0 0 1\" with positive sides",
        )
    })?;
    let columns = columns(header)
        .ok_or_else(|| snapshot_fault(path, 2, header, "Properties with pos, velo and radius"))?;
    let mut disks = Vec::new();
    for (line, number) in lines.zip(3..).take(count) {
        let disk = disk(line, columns).ok_or_else(|| {
            snapshot_fault(
                path,
                number,
                line,
                "position, velocity and radius as finite numbers",
            )
        })?;
        disks.push(disk);
    }
    if disks.len() != count {
        let expected = format!("{count} particles");
        let found = format!("{} particles", disks.len());
        return Err(snapshot_fault(
            path,
            disks.len() as u64 + 2,
            &found,
            &expected,
        ));
    }
    Ok(Particles { sides, disks })
}

/// Sides of the domain in the header of a snapshot.
fn sides(header: &str) -> Option<[f64; 2]> {
    let lattice = header.split_once("Lattice=\"")?.1.split_once('"')?.0;
    let numbers: Vec<f64> = lattice
        .split_whitespace()
        .map(str::parse)
        .collect::<Result<_, _>>()
        .ok()?;
    let sides = [*numbers.first()?, *numbers.get(4)?];
    sides
        .iter()
        .all(|side| side.is_finite() && *side > 0.0)
        .then_some(sides)
}

/// First columns of position, velocity and radius in the header of a snapshot.
fn columns(header: &str) -> Option<[usize; 3]> {
    let properties = header
        .split_once("Properties=")?
        .1
        .split_whitespace()
        .next()?;
    let parts: Vec<&str> = properties.split(':').collect();
    let mut found = [None; 3];
    let mut column = 0_usize;
    for property in parts.chunks(3) {
        let width: usize = property.get(2)?.parse().ok()?;
        let place = ["pos", "velo", "radius"]
            .iter()
            .position(|name| name == &property[0]);
        if let Some(place) = place {
            if width < [2, 2, 1][place] {
                return None;
            }
            found[place] = Some(column);
        }
        column = column.checked_add(width)?;
    }
    Some([found[0]?, found[1]?, found[2]?])
}

/// One particle line of a snapshot.
fn disk(line: &str, [position, velocity, radius]: [usize; 3]) -> Option<Disk> {
    let fields: Vec<&str> = line.split_whitespace().collect();
    let number = |column: usize| {
        fields
            .get(column)?
            .parse::<f64>()
            .ok()
            .filter(|value| value.is_finite())
    };
    Some(Disk {
        position: [number(position)?, number(position + 1)?],
        velocity: [number(velocity)?, number(velocity + 1)?],
        radius: number(radius).filter(|radius| *radius >= 0.0)?,
    })
}

/// A fault in a snapshot, with the offending text cut to a readable length.
fn snapshot_fault(path: &Path, line: u64, found: &str, expected: &str) -> ReportError {
    ReportError::Snapshot {
        file: path.to_owned(),
        line,
        found: found.chars().take(80).collect(),
        expected: expected.to_owned(),
    }
}
