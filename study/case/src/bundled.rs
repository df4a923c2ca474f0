//! Cases and papers that are built into a program as a folder of files.

use std::path::Path;

use include_dir::Dir;

use crate::{CaseError, CaseFile, Format, nearest, read_text};

/// Folder of bundled case files, with bundled papers in its subfolder `papers`.
#[derive(Clone, Copy, Debug)]
pub struct CaseBundle(pub &'static Dir<'static>);

/// Bundled case or paper: a file built into the program.
#[derive(Clone, Copy, Debug)]
pub struct Bundled {
    /// Name of the bundled case or paper: its file name without the ending.
    pub name: &'static str,
    /// Text of the bundled file.
    pub text: &'static str,
}

impl Bundled {
    /// Returns the question of the bundled case: its first comment, up to the question mark.
    pub fn question(self) -> String {
        crate::format::leading_question(self.text).unwrap_or_default()
    }
}

impl CaseBundle {
    /// Returns all bundled cases, sorted by name.
    pub fn cases(self) -> Vec<Bundled> {
        files(self.0)
    }

    /// Returns all bundled papers, sorted by name.
    pub fn papers(self) -> Vec<Bundled> {
        self.0.get_dir("papers").map(files).unwrap_or_default()
    }

    /// Returns the bundled case with a given name; `None` if there is none.
    pub fn named(self, name: &str) -> Option<Bundled> {
        self.cases().into_iter().find(|one| one.name == name)
    }

    /// Returns the bundled case with a name similar to `given`; `None` if none is similar.
    pub fn close_to(self, given: &Path) -> Option<&'static str> {
        let name = given.file_stem()?.to_str()?;
        let cases = self.cases();
        nearest(name, cases.iter().map(|one| one.name))
    }

    /// Returns the text of a case file; if there is no file, of the bundled case of that name.
    ///
    /// # Errors
    /// [`CaseError::NoCase`] if there is neither; or the file cannot be read.
    pub fn text(self, path: &Path) -> Result<String, CaseError> {
        if path.exists() {
            return read_text(path);
        }
        match path.to_str().and_then(|name| self.named(name)) {
            Some(one) => Ok(one.text.to_owned()),
            None => Err(CaseError::NoCase {
                path: path.to_owned(),
                close: self.close_to(path),
            }),
        }
    }

    /// Reads a case file; if there is no file, the bundled case of that name.
    ///
    /// # Errors
    /// As [`Self::text`] and [`Format::from_text`].
    pub fn read_case(
        self,
        format: &Format,
        path: &Path,
        overrides: &[String],
    ) -> Result<CaseFile, CaseError> {
        let text = self.text(path)?;
        if path.exists() {
            format.from_text(path, &text, overrides)
        } else {
            format.from_text(&path.with_extension("toml"), &text, overrides)
        }
    }
}

/// Returns the files of a bundled folder, sorted by name.
fn files(folder: &'static Dir<'static>) -> Vec<Bundled> {
    let one = |file: &'static include_dir::File<'static>| {
        let name = file.path().file_stem()?.to_str()?;
        let text = file.contents_utf8()?;
        Some(Bundled { name, text })
    };
    let mut all: Vec<_> = folder.files().filter_map(one).collect();
    all.sort_by_key(|one| one.name);
    all
}
