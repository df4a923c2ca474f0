//! Reader and writer of GSD files, the binary format of HOOMD-blue that OVITO and freud open: named
//! arrays by frame.
//!
//! A file is a header of 256 bytes, an index of entries of 32 bytes, a list of names, and the arrays.
//! All numbers are little-endian. This is the file layer of version 2 as its documentation describes
//! it (J. A. Anderson, <https://gsd.readthedocs.io/en/stable/file-layer.html>); files of version 1,
//! whose names have a fixed length, are read too. The names and shapes of the arrays are the matter
//! of a schema, such as `hoomd`.

use std::collections::HashMap;
use std::ops::Range;

/// Magic number at the begin of every GSD file.
const MAGIC: u64 = 0x65DF_65DF_65DF_65DF;
/// Length of the header of a GSD file \[bytes\].
const HEADER: usize = 256;
/// Length of an entry in the index of a GSD file \[bytes\].
const ENTRY: usize = 32;
/// Unit of the length of the list of array names in a GSD file \[bytes\].
const NAME: usize = 64;
/// Version of the GSD file layer that is written, 2.0: the major one is in the upper 16 bits.
const VERSION: u32 = 2 << 16;
/// Number of entries reserved in the index of a new GSD file, so that other programs can append to
/// it.
const SPACE: usize = 128;

/// Number type of the elements of an array in a GSD file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Number {
    U8,
    U16,
    U32,
    U64,
    I8,
    I16,
    I32,
    I64,
    F32,
    F64,
}

impl Number {
    /// List of all number types of GSD files, in the order of their codes, from 1.
    const ALL: [Self; 10] = [
        Self::U8,
        Self::U16,
        Self::U32,
        Self::U64,
        Self::I8,
        Self::I16,
        Self::I32,
        Self::I64,
        Self::F32,
        Self::F64,
    ];

    /// Returns the number type with a GSD code; the code for characters (11) gives bytes. `None`
    /// for an unknown code.
    fn of(code: u8) -> Option<Self> {
        match code {
            11 => Some(Self::U8),
            _ => Self::ALL.get(usize::from(code).checked_sub(1)?).copied(),
        }
    }

    /// Returns the length of a number of this type \[bytes\].
    fn size(self) -> usize {
        match self {
            Self::U8 | Self::I8 => 1,
            Self::U16 | Self::I16 => 2,
            Self::U32 | Self::I32 | Self::F32 => 4,
            Self::U64 | Self::I64 | Self::F64 => 8,
        }
    }

    /// Reads a number of this type from its little-endian bytes.
    fn read(self, bytes: &[u8]) -> f64 {
        let mut all = [0; 8];
        all[..bytes.len()].copy_from_slice(bytes);
        let bits = u64::from_le_bytes(all);
        match self {
            Self::U8 | Self::U16 | Self::U32 | Self::U64 => bits as f64,
            Self::I8 => f64::from(bits as u8 as i8),
            Self::I16 => f64::from(bits as u16 as i16),
            Self::I32 => f64::from(bits as u32 as i32),
            Self::I64 => bits as i64 as f64,
            Self::F32 => f64::from(f32::from_bits(bits as u32)),
            Self::F64 => f64::from_bits(bits),
        }
    }
}

/// Named array of one frame, to be written to a GSD file.
#[derive(Clone, Debug, PartialEq)]
pub struct Chunk {
    name: &'static str,
    columns: usize,
    number: Number,
    bytes: Vec<u8>,
}

impl Chunk {
    fn new<const N: usize>(
        name: &'static str,
        columns: usize,
        number: Number,
        numbers: impl Iterator<Item = [u8; N]>,
    ) -> Self {
        let bytes = numbers.flatten().collect();
        Self {
            name,
            columns,
            number,
            bytes,
        }
    }

    /// Creates an array with `columns` columns of numbers rounded to single precision.
    pub fn single(
        name: &'static str,
        columns: usize,
        numbers: impl IntoIterator<Item = f64>,
    ) -> Self {
        let bytes = numbers.into_iter().map(|one| (one as f32).to_le_bytes());
        Self::new(name, columns, Number::F32, bytes)
    }

    /// Creates an array with `columns` columns of double-precision numbers.
    pub fn double(
        name: &'static str,
        columns: usize,
        numbers: impl IntoIterator<Item = f64>,
    ) -> Self {
        let bytes = numbers.into_iter().map(f64::to_le_bytes);
        Self::new(name, columns, Number::F64, bytes)
    }

    /// Creates an array of one column of unsigned 32-bit integers.
    pub fn counts(name: &'static str, numbers: impl IntoIterator<Item = u32>) -> Self {
        let bytes = numbers.into_iter().map(u32::to_le_bytes);
        Self::new(name, 1, Number::U32, bytes)
    }

    /// Creates an array of one unsigned 64-bit integer.
    pub fn count(name: &'static str, number: u64) -> Self {
        Self::new(name, 1, Number::U64, std::iter::once(number.to_le_bytes()))
    }

    /// Creates an array of one column of unsigned 8-bit integers.
    pub fn bytes(name: &'static str, numbers: impl IntoIterator<Item = u8>) -> Self {
        let bytes = numbers.into_iter().map(|one| [one]);
        Self::new(name, 1, Number::U8, bytes)
    }

    /// Creates an array of texts: each text is a row of bytes, padded with zeros.
    pub fn texts(name: &'static str, texts: &[String]) -> Self {
        let columns = texts.iter().map(String::len).max().unwrap_or(0) + 1;
        let padded = |text: &String| {
            let mut row = text.clone().into_bytes();
            row.resize(columns, 0);
            row
        };
        let bytes = texts.iter().flat_map(padded).map(|byte| [byte]);
        Self::new(name, columns, Number::I8, bytes)
    }

    fn rows(&self) -> usize {
        self.bytes.len() / (self.columns * self.number.size())
    }
}

/// Returns the bytes of a GSD file with these frames. `schema` is the name of the schema with its
/// major and minor version; `application` names the writing program.
pub fn to_bytes(
    application: &str,
    (schema, major, minor): (&str, u32, u32),
    frames: &[Vec<Chunk>],
) -> Vec<u8> {
    let mut names: Vec<&str> = Vec::new();
    let mut entries = Vec::new();
    for (frame, chunks) in frames.iter().enumerate() {
        let first = entries.len();
        for chunk in chunks {
            let known = names.iter().position(|name| *name == chunk.name);
            let id = known.unwrap_or_else(|| {
                names.push(chunk.name);
                names.len() - 1
            });
            entries.push((frame, id, chunk));
        }
        // Readers search the index by frame and name.
        entries[first..].sort_by_key(|&(_, id, _)| id);
    }
    let listed: Vec<u8> = names
        .iter()
        .flat_map(|name| [name.as_bytes(), &[0]].concat())
        .collect();
    let (space, lines) = (entries.len().max(SPACE), listed.len() / NAME + 1);
    let text = |text: &str| {
        let mut all = [0; NAME];
        for (to, from) in all[..NAME - 1].iter_mut().zip(text.bytes()) {
            *to = from;
        }
        all
    };
    let mut bytes = Vec::new();
    let places = [HEADER, space, HEADER + space * ENTRY, lines];
    bytes.extend(MAGIC.to_le_bytes());
    bytes.extend(places.iter().flat_map(|&one| (one as u64).to_le_bytes()));
    bytes.extend(
        [major << 16 | minor, VERSION]
            .iter()
            .flat_map(|one| one.to_le_bytes()),
    );
    bytes.extend([text(application), text(schema)].concat());
    bytes.resize(HEADER, 0);
    let mut at = HEADER + space * ENTRY + lines * NAME;
    for &(frame, id, chunk) in &entries {
        let place = [frame as u64, chunk.rows() as u64, at as u64];
        bytes.extend(place.iter().flat_map(|one| one.to_le_bytes()));
        bytes.extend((chunk.columns as u32).to_le_bytes());
        bytes.extend((id as u16).to_le_bytes());
        bytes.extend([chunk.number as u8 + 1, 0]);
        at += chunk.bytes.len();
    }
    bytes.resize(HEADER + space * ENTRY, 0);
    bytes.extend(listed);
    bytes.resize(HEADER + space * ENTRY + lines * NAME, 0);
    for (_, _, chunk) in entries {
        bytes.extend(&chunk.bytes);
    }
    bytes
}

/// Array of one frame as read from a GSD file.
#[derive(Clone, Debug, PartialEq)]
pub struct Array {
    /// Number of rows of the array.
    pub rows: usize,
    /// Number of columns of the array.
    pub columns: usize,
    /// All elements of the array as numbers, row by row.
    pub numbers: Vec<f64>,
}

impl Array {
    /// Returns the rows of the array as texts, each up to the first zero byte.
    pub fn texts(&self) -> Vec<String> {
        let rows = self.numbers.chunks(self.columns.max(1));
        rows.map(|row| {
            let bytes = row.iter().take_while(|one| **one != 0.0);
            let bytes: Vec<u8> = bytes.map(|one| *one as i16 as u8).collect();
            String::from_utf8_lossy(&bytes).into_owned()
        })
        .collect()
    }
}

/// Location and type of an array in a GSD file.
#[derive(Clone, Debug)]
struct Place {
    number: Number,
    columns: usize,
    bytes: Range<usize>,
}

/// GSD file opened for reading: its index of arrays, schema and number of frames.
#[derive(Clone, Debug)]
pub struct GsdFile<'a> {
    bytes: &'a [u8],
    places: HashMap<(u64, String), Place>,
    schema: String,
    frames: u64,
}

impl<'a> GsdFile<'a> {
    /// Reads the index of a GSD file from its bytes; `None` if they are no GSD file, or a damaged
    /// one.
    pub fn read(bytes: &'a [u8]) -> Option<Self> {
        let number = |at: usize, size: usize| -> Option<u64> {
            let mut all = [0; 8];
            all[..size].copy_from_slice(bytes.get(at..at.checked_add(size)?)?);
            Some(u64::from_le_bytes(all))
        };
        let count = |at: usize| usize::try_from(number(at, 8)?).ok();
        let block = |at: usize, count: usize, size: usize| {
            bytes.get(at..at.checked_add(count.checked_mul(size)?)?)
        };
        if number(0, 8)? != MAGIC || bytes.len() < HEADER {
            return None;
        }
        let [index_at, index_count, names_at, names_count] =
            [count(8)?, count(16)?, count(24)?, count(32)?];
        let texts = |block: &[u8]| -> Vec<String> {
            let parts = block
                .split(|byte| *byte == 0)
                .take_while(|part| !part.is_empty());
            parts
                .map(|part| String::from_utf8_lossy(part).into_owned())
                .collect()
        };
        let names = block(names_at, names_count, NAME)?;
        let names: Vec<String> = if number(44, 4)? < u64::from(VERSION) {
            let fixed = names.chunks(NAME).map(texts);
            fixed.map_while(|found| found.into_iter().next()).collect()
        } else {
            texts(names)
        };
        let (mut places, mut frames) = (HashMap::new(), 0);
        block(index_at, index_count, ENTRY)?;
        for at in (0..index_count).map(|index| index_at + index * ENTRY) {
            let (frame, rows, start) = (number(at, 8)?, count(at + 8)?, count(at + 16)?);
            if start == 0 {
                break;
            }
            let columns = usize::try_from(number(at + 24, 4)?).ok()?;
            let name = names.get(usize::try_from(number(at + 28, 2)?).ok()?)?;
            let kind = Number::of(u8::try_from(number(at + 30, 1)?).ok()?)?;
            let length = block(start, rows.checked_mul(columns)?, kind.size())?.len();
            let place = Place {
                number: kind,
                columns,
                bytes: start..start + length,
            };
            places.insert((frame, name.clone()), place);
            frames = frames.max(frame.checked_add(1)?);
        }
        let schema = texts(bytes.get(112..112 + NAME)?);
        Some(Self {
            bytes,
            places,
            schema: schema.into_iter().next().unwrap_or_else(String::new),
            frames,
        })
    }

    /// Returns the name of the schema of the GSD file, such as `hoomd`.
    pub fn schema(&self) -> &str {
        &self.schema
    }

    /// Returns the number of frames in the GSD file.
    pub fn frames(&self) -> u64 {
        self.frames
    }

    /// Returns the array with a name in a frame of the GSD file; `None` if the frame does not have
    /// it.
    pub fn array(&self, frame: u64, name: &str) -> Option<Array> {
        let place = self.places.get(&(frame, name.to_owned()))?;
        let bytes = self.bytes.get(place.bytes.clone())?;
        let numbers = bytes.chunks_exact(place.number.size());
        let numbers: Vec<f64> = numbers.map(|one| place.number.read(one)).collect();
        Some(Array {
            rows: numbers.len() / place.columns.max(1),
            columns: place.columns,
            numbers,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file() -> Vec<u8> {
        let names = ["A".to_owned(), "long".to_owned()];
        let first = vec![
            Chunk::count("configuration/step", u64::from(u32::MAX) + 1),
            Chunk::bytes("configuration/dimensions", [2]),
            Chunk::single("particles/position", 3, [0.1, -2.0, 0.0, 3.0, 4.0, 5.0]),
            Chunk::texts("particles/types", &names),
        ];
        let second = vec![
            Chunk::counts("particles/typeid", [0, 1, 7]),
            Chunk::double("log/time", 1, [0.1]),
            Chunk::bytes("configuration/dimensions", [3]),
        ];
        to_bytes("a test", ("hoomd", 1, 4), &[first, second])
    }

    #[test]
    fn what_is_written_is_read() {
        let bytes = file();
        let file = GsdFile::read(&bytes).expect("a file");
        assert_eq!((file.schema(), file.frames()), ("hoomd", 2));
        let array = |frame: u64, name: &str| file.array(frame, name).expect("an array");
        assert_eq!(array(0, "configuration/step").numbers, [4_294_967_296.0]);
        let places = array(0, "particles/position");
        assert_eq!((places.rows, places.columns), (2, 3));
        let wanted = [f64::from(0.1_f32), -2.0, 0.0, 3.0, 4.0, 5.0];
        assert_eq!(places.numbers, wanted);
        assert_eq!(array(0, "particles/types").texts(), ["A", "long"]);
        assert_eq!(array(1, "particles/typeid").numbers, [0.0, 1.0, 7.0]);
        assert_eq!(array(1, "log/time").numbers, [0.1]);
        let dimensions = [0, 1].map(|frame| array(frame, "configuration/dimensions").numbers[0]);
        assert_eq!(dimensions, [2.0, 3.0]);
        assert!(file.array(1, "particles/types").is_none());
    }

    /// A file that ends anywhere, or with any byte of header and index changed, is refused or read;
    /// nothing panics, and no array is larger than the file.
    #[test]
    fn damage_is_refused_or_harmless() {
        let whole = file();
        for length in (0..whole.len()).step_by(7) {
            assert!(GsdFile::read(&whole[..length]).is_none());
        }
        for at in (0..HEADER + 10 * ENTRY).chain(HEADER + SPACE * ENTRY..whole.len()) {
            for change in [1, 0x80, 0xff] {
                let mut bytes = whole.clone();
                bytes[at] ^= change;
                let Some(file) = GsdFile::read(&bytes) else {
                    continue;
                };
                for (frame, name) in file.places.keys() {
                    let array = file.array(*frame, name).expect("an array");
                    assert!(array.numbers.len() <= bytes.len());
                    array.texts();
                }
            }
        }
    }
}
