//! Initial states in GSD files of the schema `hoomd`: one frame with `particles/position` and,
//! optionally, `velocity`, `diameter`, `mass`, `typeid` and `types`, and the angular velocities,
//! weights and periodic axes that snapshots log. The box of HOOMD-blue is around the origin; its
//! numbers have single precision.

use nalgebra::Vector3;

use super::rows::{FileError, LARGEST, SPECIES_NAME, SourceFile, StartFile, is_species_name};
use crate::gsd::{Array, GsdFile};

/// Reads an initial state from the bytes of a GSD file.
pub(super) fn read_gsd(source: &SourceFile<'_>, bytes: &[u8]) -> Result<StartFile, FileError> {
    let refuse = |found: String, expected: &str| Err(source.frame_error(0, found, expected));
    let Some(file) = GsdFile::read(bytes) else {
        return refuse(
            "no GSD file, or a damaged one".into(),
            "a whole file of GSD",
        );
    };
    if file.schema() != "hoomd" {
        let found = format!("the schema `{}`", file.schema());
        return refuse(found, "the schema `hoomd`");
    }
    if file.frames() != 1 {
        let found = format!("{} frames", file.frames());
        return refuse(
            found,
            "one frame: of a trajectory, the frame to start from in a file of its own",
        );
    }
    let frame = Frame { source, file };
    let count = frame.numbers("particles/N", 1)?;
    let count = count.and_then(|all| all.first().copied());
    let Some(count) = count
        .filter(|count| *count > 0.0)
        .map(|count| count as usize)
    else {
        return refuse("no particle (particles/N)".into(), "at least one");
    };
    let Some([x, y, z, xy, xz, yz]) = frame.vector("configuration/box")? else {
        return refuse("no configuration/box".into(), "Lx, Ly, Lz, xy, xz, yz");
    };
    if x <= 0.0 || y <= 0.0 || z < 0.0 {
        return refuse(format!("a box of {x} x {y} x {z}"), "positive sides");
    }
    if xz != 0.0 || yz != 0.0 {
        return refuse(format!("a box with xz = {xz}, yz = {yz}"), super::TILTED);
    }
    let Some(positions) = frame.vectors("particles/position", count)? else {
        return refuse("no particles/position".into(), "positions");
    };
    let tilt = xy * y;
    let corner = Vector3::new(x + tilt, y, z) * 0.5;
    let positions = positions.into_iter().map(|place| place + corner).collect();
    let periodic = frame.numbers("log/periodic", 3)?;
    let periodic = periodic.and_then(|all| <[f64; 3]>::try_from(all).ok());
    let diameters = frame.sizes("particles/diameter", count)?;
    Ok(StartFile {
        lengths: Some([x, y, z]),
        shear_offset: tilt,
        periodic: periodic.map(|all| all.map(|one| one != 0.0)),
        is_single_precision: true,
        positions: Some(positions),
        velocities: frame.vectors("particles/velocity", count)?,
        spins: frame.vectors("log/particles/angular_velocity", count)?,
        radii: diameters.map(|all| all.into_iter().map(|one| 0.5 * one).collect()),
        masses: frame.sizes("particles/mass", count)?,
        types: frame.types(count)?,
        weights: frame.sizes("log/particles/weight", count)?,
    })
}

/// First frame of a GSD file with an initial state.
struct Frame<'a> {
    source: &'a SourceFile<'a>,
    file: GsdFile<'a>,
}

impl Frame<'_> {
    fn error(&self, found: String, expected: &str) -> FileError {
        self.source.frame_error(0, found, expected)
    }

    /// Returns an array of the frame, checked for the given number of rows and finite numbers;
    /// `None` if the frame does not have it.
    fn array(&self, name: &str, rows: usize) -> Result<Option<Array>, FileError> {
        let Some(array) = self.file.array(0, name) else {
            return Ok(None);
        };
        if array.rows != rows {
            let expected = format!("{rows} of them");
            return Err(self.error(format!("{} rows of {name}", array.rows), &expected));
        }
        let bad = array
            .numbers
            .iter()
            .position(|one| one.is_nan() || one.abs() > LARGEST);
        if let Some(index) = bad {
            let (row, value) = (index / array.columns.max(1), array.numbers[index]);
            let found = format!("{name} = {value} in row {row} (counted from 0)");
            return Err(self.error(found, "a finite number up to 1e100"));
        }
        Ok(Some(array))
    }

    /// Returns the numbers of a one-column array of the frame, checked for the given number of
    /// rows; `None` if the frame does not have it.
    fn numbers(&self, name: &str, rows: usize) -> Result<Option<Vec<f64>>, FileError> {
        Ok(self.columns(name, rows, 1)?.map(|array| array.numbers))
    }

    fn columns(&self, name: &str, rows: usize, columns: usize) -> Result<Option<Array>, FileError> {
        let array = self.array(name, rows)?;
        match &array {
            Some(array) if array.columns != columns => {
                let found = format!("{} columns of {name}", array.columns);
                Err(self.error(found, &format!("{columns} of them")))
            }
            _ => Ok(array),
        }
    }

    /// Returns the six numbers of a one-column array of the frame; `None` if the frame does not
    /// have it.
    fn vector(&self, name: &str) -> Result<Option<[f64; 6]>, FileError> {
        let numbers = self.numbers(name, 6)?;
        Ok(numbers.and_then(|all| all.try_into().ok()))
    }

    /// Returns a vector for each of `count` particles from a three-column array of the frame;
    /// `None` if the frame does not have it.
    fn vectors(&self, name: &str, count: usize) -> Result<Option<Vec<Vector3<f64>>>, FileError> {
        let array = self.columns(name, count, 3)?;
        Ok(array.map(|array| {
            array
                .numbers
                .chunks_exact(3)
                .map(Vector3::from_column_slice)
                .collect()
        }))
    }

    /// Returns a positive number for each of `count` particles from an array of the frame, as a
    /// diameter or mass; `None` if the frame does not have it.
    fn sizes(&self, name: &str, count: usize) -> Result<Option<Vec<f64>>, FileError> {
        let numbers = self.numbers(name, count)?;
        let bad = numbers
            .iter()
            .flatten()
            .position(|one| *one < 1.0 / LARGEST);
        match bad {
            Some(index) => {
                let found = format!("{name} of particle {index} (counted from 0) not above zero");
                Err(self.error(found, "numbers above zero (from 1e-100)"))
            }
            None => Ok(numbers),
        }
    }

    /// Returns the species name of each of `count` particles; `None` if the file has neither type
    /// names nor type numbers.
    fn types(&self, count: usize) -> Result<Option<Vec<String>>, FileError> {
        let names = self
            .file
            .array(0, "particles/types")
            .map(|array| array.texts());
        let numbers = self.numbers("particles/typeid", count)?;
        if names.is_none() && numbers.is_none() {
            return Ok(None);
        }
        // The defaults of the schema: one type, of the name A, for all.
        let names = names.unwrap_or_else(|| vec!["A".to_owned()]);
        let numbers = numbers.unwrap_or_else(|| vec![0.0; count]);
        let name = |number: f64| {
            let name = names.get(number as usize).filter(|_| number >= 0.0);
            let name = name.filter(|name| is_species_name(name));
            name.cloned().ok_or_else(|| {
                let found = format!("type {number} of the types {names:?}");
                self.error(found, SPECIES_NAME)
            })
        };
        numbers
            .into_iter()
            .map(name)
            .collect::<Result<_, _>>()
            .map(Some)
    }
}
