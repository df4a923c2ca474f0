//! The cases and papers that come with the program.

use std::path::Path;

use include_dir::{Dir, include_dir};

static FOLDER: Dir<'_> = include_dir!("$CARGO_MANIFEST_DIR/cases");

/// A case or paper that comes with the program.
#[derive(Clone, Copy, Debug)]
pub struct Bundled {
    /// Its name: that of its file without the ending.
    pub name: &'static str,
    /// The file.
    pub text: &'static str,
}

impl Bundled {
    /// What the case asks: the comment that it begins with, up to the question mark.
    pub fn question(self) -> String {
        let comment = self.text.lines().map_while(|line| line.strip_prefix('#'));
        let words: Vec<&str> = comment.flat_map(str::split_whitespace).collect();
        let text = words.join(" ");
        let end = text.find('?').map_or(text.len(), |mark| mark + 1);
        text[..end].to_owned()
    }
}

/// All of them, by name.
pub fn all() -> Vec<Bundled> {
    files(&FOLDER)
}

/// All papers, by name.
pub fn papers() -> Vec<Bundled> {
    FOLDER.get_dir("papers").map(files).unwrap_or_default()
}

/// The files of a folder, by name.
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

/// The case of a name.
pub fn named(name: &str) -> Option<Bundled> {
    all().into_iter().find(|one| one.name == name)
}

/// The case of a name, unless there is a file of that path.
pub fn find(path: &Path) -> Option<Bundled> {
    if path.exists() {
        return None;
    }
    named(path.to_str()?)
}
