//! Figures for papers as vector files (SVG, PDF) of the width of one or two columns of a journal.
//!
//! Text has 8 points at any width, lines have the widths of print, and curves are told apart
//! without colour, by markers and dashes. A figure is arranged once as paths and lines of text,
//! from which both formats are written: SVG has text as outlines, PDF as letters with the fonts of
//! this crate embedded. Both are self-contained, and equal folders give equal bytes.
//!
//! | module   | owns                                             |
//! |----------|--------------------------------------------------|
//! | `canvas` | paths and text in points                         |
//! | `font`   | letters, their widths and outlines               |
//! | `label`  | symbols, exponents, indices and units            |
//! | `style`  | markers, dashes and line widths                  |
//! | `marks`  | contents of panels                               |
//! | `legend` | the legend and its place                         |
//! | `layout` | panels, axes, ticks and labels                   |
//! | `svg`    | SVG files                                        |
//! | `pdf`    | PDF files                                        |
//!
//! Converters from SVG to PDF were left out: they bring parsers and text layout for all of SVG,
//! while paths and lines of text need a page of code.

mod canvas;
mod font;
mod label;
mod layout;
mod legend;
mod marks;
mod pdf;
mod style;
mod svg;

use std::collections::BTreeSet;
use std::path::Path;

use stosszahl_results::{Stored, Sweep};

use crate::figure::Drawn;
use crate::{ReportError, run, sweep, viewer};

use canvas::{Canvas, Item};
use font::Fonts;

/// Widths of one and of two columns of a journal (Physical Review) \[mm\].
pub const COLUMN_WIDTHS: [f64; 2] = [86.0, 178.0];
/// Smallest and largest width of a figure for print \[mm\].
pub const PRINT_WIDTHS: [f64; 2] = [60.0, 400.0];

/// Figure of a results folder that can be drawn for print.
pub struct PrintFigure {
    name: String,
    title: String,
    drawn: Drawn,
}

/// Figure drawn for print, which can be written as SVG or PDF.
pub struct PrintDrawing {
    title: String,
    canvas: Canvas,
}

/// Reads the figures of a results folder or of a sweep folder that can be drawn, in the order of
/// its tables.
///
/// # Errors
/// As [`crate::write_report`], and [`ReportError::NoFigures`].
pub fn print_figures(folder: &Path) -> Result<Vec<PrintFigure>, ReportError> {
    let named = |(file, title, drawn): (String, String, Drawn)| {
        let name = file.rsplit_once('/').map_or(&*file, |(_, name)| name);
        PrintFigure {
            name: name.trim_end_matches(".svg").to_owned(),
            title,
            drawn,
        }
    };
    let figures: Vec<PrintFigure> = if let Some(index) = Sweep::read(folder)? {
        let all = sweep::drawn(folder, &index)?.into_iter();
        all.map(|(file, figure, drawn)| named((file, figure.title.to_string(), drawn)))
            .collect()
    } else if let Some(stored) = Stored::read(folder)? {
        let obstacles = viewer::obstacles(&stored.manifest);
        let tables = stored.tables.iter();
        let all = tables.flat_map(|table| run::drawn(table, &obstacles));
        all.filter_map(|(figure, file, drawn)| {
            Some(named((file, figure.title.to_string(), drawn?)))
        })
        .collect()
    } else {
        return Err(ReportError::NoResults {
            folder: folder.to_owned(),
        });
    };
    if figures.is_empty() {
        return Err(ReportError::NoFigures {
            folder: folder.to_owned(),
        });
    }
    Ok(figures)
}

/// Reads one figure of a results folder by its name.
///
/// # Errors
/// As [`print_figures`], and [`ReportError::NoFigure`] if none has this name.
pub fn print_figure(folder: &Path, name: &str) -> Result<PrintFigure, ReportError> {
    let figures = print_figures(folder)?;
    let names: Vec<String> = figures.iter().map(|one| one.name.clone()).collect();
    let found = figures.into_iter().find(|one| one.name == name);
    found.ok_or_else(|| ReportError::NoFigure {
        folder: folder.to_owned(),
        name: name.to_owned(),
        close: close_name(name, &names),
        names,
    })
}

/// Returns the figure name that differs from a given one by at most two letters, or else begins
/// with it.
fn close_name(given: &str, names: &[String]) -> Option<String> {
    // Nothing so long is close, and distances cost the product of lengths.
    let names = names.iter().filter(|_| given.len() <= 64);
    let apart = |name: &String| strsim::osa_distance(given, name);
    let near = names.clone().filter(|name| apart(name) <= 2);
    let begun = names.filter(|name| given.len() >= 3 && name.starts_with(given));
    near.min_by_key(|name| apart(name))
        .or(begun.min_by_key(|name| name.len()))
        .cloned()
}

impl PrintFigure {
    /// Returns the name of the figure and of its drawing in the folder: the name of the table, with
    /// `-2` and so on for further figures of the table.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Returns the title of the figure.
    pub fn title(&self) -> &str {
        &self.title
    }

    /// Draws the figure for print with a width \[mm\].
    ///
    /// # Errors
    /// [`ReportError::PrintWidth`] if the width is not in [`PRINT_WIDTHS`].
    pub fn draw(&self, width: f64) -> Result<PrintDrawing, ReportError> {
        if !(PRINT_WIDTHS[0]..=PRINT_WIDTHS[1]).contains(&width) {
            return Err(ReportError::PrintWidth { found: width });
        }
        Ok(PrintDrawing {
            title: self.title.clone(),
            canvas: layout::lay_out(&self.drawn, width / svg::POINT, &Fonts::new()),
        })
    }
}

impl PrintDrawing {
    /// Returns width and height of the drawing \[mm\].
    pub fn size(&self) -> [f64; 2] {
        self.canvas.size.map(|length| length * svg::POINT)
    }

    /// Returns the letters of the drawing that the fonts of this crate lack; they are drawn as
    /// empty boxes.
    pub fn missing_letters(&self) -> String {
        let texts = self.canvas.items.iter().filter_map(|item| match item {
            Item::Text(text) => Some(&text.glyphs),
            Item::Path { .. } => None,
        });
        let missing = texts.flatten().filter(|glyph| glyph.id == 0);
        let letters: BTreeSet<char> = missing.map(|glyph| glyph.letter).collect();
        letters.into_iter().collect()
    }

    /// Returns the drawing as an SVG file, with text as outlines.
    pub fn to_svg(&self) -> String {
        svg::write(&self.canvas, &Fonts::new(), &self.title)
    }

    /// Returns the drawing as a PDF document of one page, with its fonts embedded.
    pub fn to_pdf(&self) -> Vec<u8> {
        pdf::write(&self.canvas, &Fonts::new(), &self.title)
    }
}
