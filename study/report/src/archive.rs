//! ZIP archive of a results folder, embedded in its report page, for readers who have only the
//! page.
//!
//! A page that is opened from a disk cannot read the files beside it: browsers forbid it. So the
//! page holds them, compressed, up to a limit; the files that do not fit are named.

use std::fs;
use std::io::{ErrorKind, Write as _};
use std::path::{Component, Path};

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use flate2::write::DeflateEncoder;
use flate2::{Compression, Crc};
use maud::{Markup, PreEscaped, html};
use stosszahl_results::ResultsError;

/// JavaScript that saves the archive from the page.
pub(crate) const SCRIPT: &str = include_str!("archive.js");
/// Largest size of the archive in a report page \[bytes\].
const LARGEST: usize = 4 << 20;
/// Size of the largest file that is compressed to see whether it fits into the archive \[bytes\].
const LARGEST_FILE: u64 = 64 << 20;
/// Date of all files in the archive, 1 January 1980, so that equal folders give equal bytes.
const DATE: u16 = (1 << 5) | 1;

/// ZIP archive under construction, of files of a results folder.
pub(crate) struct Archive {
    /// Name of the archive, and of the folder inside it.
    name: String,
    /// Contents of the archive so far: each file after a header with its name and size.
    bytes: Vec<u8>,
    /// Entries of the central directory, which is written at the end of the archive.
    list: Vec<u8>,
    /// Number of files in the archive.
    held: u16,
    /// Names of the files that do not fit into the archive.
    left_out: Vec<String>,
}

impl Archive {
    /// Creates an empty archive, named after the title of a case.
    pub fn new(title: &str) -> Self {
        let plain = |c: char| {
            if c.is_ascii_alphanumeric() {
                c.to_ascii_lowercase()
            } else {
                '-'
            }
        };
        let name: String = title.chars().map(plain).collect();
        let words: Vec<&str> = name
            .split('-')
            .filter(|word| !word.is_empty())
            .take(8)
            .collect();
        Self {
            name: if words.is_empty() {
                "results".into()
            } else {
                words.join("-")
            },
            bytes: Vec::new(),
            list: Vec::new(),
            held: 0,
            left_out: Vec::new(),
        }
    }

    /// Adds a file of the results folder to the archive, if it exists, is inside the folder, and
    /// fits.
    ///
    /// # Errors
    /// [`ResultsError`] if the file cannot be read.
    pub fn add_file(&mut self, folder: &Path, file: &str) -> Result<(), ResultsError> {
        let inside = |part: Component<'_>| matches!(part, Component::Normal(_));
        if !Path::new(file).components().all(inside) {
            return Ok(());
        }
        let path = folder.join(file);
        let failed = |source| ResultsError::System {
            path: path.clone(),
            action: "read",
            source,
        };
        let size = match fs::metadata(&path) {
            Err(error) if error.kind() == ErrorKind::NotFound => return Ok(()),
            about => about.map_err(failed)?.len(),
        };
        if size > LARGEST_FILE {
            self.left_out.push(file.to_owned());
            return Ok(());
        }
        let bytes = fs::read(&path).map_err(failed)?;
        self.add(file, &bytes);
        Ok(())
    }

    /// Adds a file with the given contents to the archive, if it fits.
    pub fn add(&mut self, file: &str, bytes: &[u8]) {
        let packed = deflated(bytes);
        let full = self.bytes.len() + self.list.len() + packed.len() > LARGEST;
        if full || self.held == u16::MAX {
            self.left_out.push(file.to_owned());
            return;
        }
        let name = format!("{}/{file}", self.name);
        let mut sum = Crc::new();
        sum.update(bytes);
        // Version 2.0, names in UTF-8, deflated, time and date, checksum, sizes, length of the
        // name.
        let mut about = Vec::new();
        for word in [20, 1 << 11, 8, 0, DATE] {
            about.extend(u16::to_le_bytes(word));
        }
        about.extend(sum.sum().to_le_bytes());
        for length in [packed.len(), bytes.len()] {
            about.extend((length as u32).to_le_bytes());
        }
        about.extend((name.len() as u16).to_le_bytes());
        about.extend([0, 0]);
        let start = self.bytes.len() as u32;
        self.bytes.extend(b"PK\x03\x04");
        self.bytes.extend(&about);
        self.bytes.extend(name.as_bytes());
        self.bytes.extend(packed);
        self.list.extend(b"PK\x01\x02\x14\x00");
        self.list.extend(&about);
        // No comment, first disk, no attributes.
        self.list.extend([0; 10]);
        self.list.extend(start.to_le_bytes());
        self.list.extend(name.as_bytes());
        self.held += 1;
    }

    /// Returns the bytes of the archive, with the central directory at its end.
    fn finished(&self) -> Vec<u8> {
        let mut bytes = self.bytes.clone();
        bytes.extend(&self.list);
        bytes.extend(b"PK\x05\x06\0\0\0\0");
        for _ in 0..2 {
            bytes.extend(self.held.to_le_bytes());
        }
        bytes.extend((self.list.len() as u32).to_le_bytes());
        bytes.extend((self.bytes.len() as u32).to_le_bytes());
        bytes.extend([0, 0]);
        bytes
    }

    /// Builds the HTML button that saves the archive, with the contents embedded.
    pub fn section(&self) -> Markup {
        let bytes = self.finished();
        html! {
            p.download {
                button id="archive-save" type="button" hidden { "Download the folder" }
                noscript { "To download the folder needs JavaScript." }
                " " (self.name) ".zip, " (bytes.len().div_ceil(1024)) " kB inside this page: " (self.held) " files of its folder: manifest, tables, drawings and snapshots."
                @match &self.left_out[..] {
                    [] => {}
                    [one] => { " Not in it for its size: " code { (one) } "." }
                    [first, rest @ ..] => { " Not in it for their size: " code { (first) } " and " (rest.len()) " more." }
                }
            }
            script type="application/zip;base64" id="archive" data-name={ (self.name) ".zip" } { (PreEscaped(STANDARD.encode(bytes))) }
        }
    }
}

/// Compresses bytes by `deflate`.
pub(crate) fn deflated(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = DeflateEncoder::new(Vec::new(), Compression::default());
    let packed = encoder.write_all(bytes).and_then(|()| encoder.finish());
    packed.expect("memory takes all bytes")
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Reads an archive by its list, as programs do.
    fn read(bytes: &[u8]) -> Vec<(String, Vec<u8>)> {
        let word = |at: usize| u16::from_le_bytes([bytes[at], bytes[at + 1]]) as usize;
        let long = |at: usize| word(at) + (word(at + 2) << 16);
        let end = bytes.len() - 22;
        assert_eq!(&bytes[end..end + 4], b"PK\x05\x06");
        let (count, mut at) = (word(end + 10), long(end + 16));
        assert_eq!(at + long(end + 12), end);
        let mut files = Vec::new();
        for _ in 0..count {
            assert_eq!(&bytes[at..at + 4], b"PK\x01\x02");
            let (sum, packed, size, name) =
                (long(at + 16), long(at + 20), long(at + 24), word(at + 28));
            let start = long(at + 42);
            let text = String::from_utf8(bytes[at + 46..at + 46 + name].to_vec()).unwrap();
            assert_eq!(&bytes[start..start + 4], b"PK\x03\x04");
            assert_eq!(bytes[start + 4..start + 30], bytes[at + 6..at + 32]);
            let from = start + 30 + name;
            let mut decoder = flate2::write::DeflateDecoder::new(Vec::new());
            decoder.write_all(&bytes[from..from + packed]).unwrap();
            let found = decoder.finish().unwrap();
            let mut check = Crc::new();
            check.update(&found);
            assert_eq!((found.len(), check.sum() as usize), (size, sum));
            files.push((text, found));
            at += 46 + name;
        }
        files
    }

    #[test]
    fn an_archive_is_read_back() {
        let mut archive = Archive::new("Cooling: r = 0.9");
        archive.add("a.csv", b"x,y\n1,2\n");
        archive.add("figures/ä.svg", &[7; 3000]);
        archive
            .add_file(Path::new("/"), "etc/../etc/passwd")
            .unwrap();
        archive.add_file(Path::new("/"), "no/such/file").unwrap();
        // Bytes that cannot be compressed do not fit.
        let noise: Vec<u8> = (0..=LARGEST as u64)
            .map(|i| (i.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 40) as u8 ^ ((i * i) >> 13) as u8)
            .collect();
        let noise = [noise.clone(), noise.iter().rev().copied().collect()].concat();
        archive.add("noise", &noise);
        let found = read(&archive.finished());
        assert_eq!(
            found[0],
            ("cooling-r-0-9/a.csv".into(), b"x,y\n1,2\n".to_vec())
        );
        assert_eq!(
            found[1],
            ("cooling-r-0-9/figures/ä.svg".into(), vec![7; 3000])
        );
        assert_eq!(found.len(), 2);
        assert_eq!(archive.left_out, ["noise"]);
    }
}
