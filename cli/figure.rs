//! The command `figure`: figures of a results folder as vector files for a paper.

use std::path::{Path, PathBuf};

use crate::arguments::{FigureArguments, FigureFormat};
use crate::error::CommandError;
use crate::report::{COLUMN_WIDTHS, PrintFigure, print_figure, print_figures};
use crate::results::write_file;
use crate::terminal::{beside, note, say};

/// Writes one figure or all of them, or lists the figures, as the arguments say.
pub(crate) fn figure(arguments: &FigureArguments) -> Result<(), CommandError> {
    let folder = &arguments.folder;
    let width = arguments
        .width
        .unwrap_or(COLUMN_WIDTHS[usize::from(arguments.columns > 1)]);
    match (&arguments.name, arguments.all) {
        (Some(name), _) => {
            let format = format(arguments)?;
            let figure = print_figure(folder, name)?;
            let file = figure_file(figure.name(), format);
            let path = match &arguments.out {
                Some(out) if out.is_dir() => out.join(file),
                Some(out) => out.clone(),
                None => file,
            };
            write(&figure, width, format, &path)
        }
        (None, true) => {
            let format = arguments.format.unwrap_or_default();
            let into = arguments.out.as_deref().unwrap_or(Path::new("."));
            for figure in print_figures(folder)? {
                let path = into.join(figure_file(figure.name(), format));
                write(&figure, width, format, &path)?;
            }
            Ok(())
        }
        (None, false) => list(&print_figures(folder)?),
    }
}

fn list(figures: &[PrintFigure]) -> Result<(), CommandError> {
    let names = figures.iter().map(|one| one.name().chars().count());
    let widest = names.max().unwrap_or(0);
    for figure in figures {
        say(&beside(
            &format!("{:<widest$}  ", figure.name()),
            figure.title(),
        ))?;
    }
    Ok(())
}

/// Returns the file format of a figure: by `--format`, or by the ending of the file.
fn format(arguments: &FigureArguments) -> Result<FigureFormat, CommandError> {
    let out = arguments.out.as_ref().filter(|out| !out.is_dir());
    let ending = out.map(|out| out.extension().unwrap_or_default().to_string_lossy());
    let named = match ending.as_deref() {
        None => return Ok(arguments.format.unwrap_or_default()),
        Some("svg") => Some(FigureFormat::Svg),
        Some("pdf") => Some(FigureFormat::Pdf),
        Some(_) => None,
    };
    match (named, arguments.format) {
        (Some(named), None) => Ok(named),
        (Some(named), Some(format)) if named == format => Ok(named),
        _ => Err(CommandError::FigureEnding {
            path: out.cloned().unwrap_or_default(),
        }),
    }
}

fn figure_file(name: &str, format: FigureFormat) -> PathBuf {
    let ending = match format {
        FigureFormat::Svg => "svg",
        FigureFormat::Pdf => "pdf",
    };
    PathBuf::from(format!("{name}.{ending}"))
}

fn write(
    figure: &PrintFigure,
    width: f64,
    format: FigureFormat,
    path: &Path,
) -> Result<(), CommandError> {
    let drawing = figure.draw(width)?;
    let bytes = match format {
        FigureFormat::Svg => drawing.to_svg().into_bytes(),
        FigureFormat::Pdf => drawing.to_pdf(),
    };
    write_file(path, &bytes)?;
    let missing = drawing.missing_letters();
    if !missing.is_empty() {
        note(&format!(
            "warning: {}: the fonts have no {missing}; an empty box is drawn for each",
            path.display()
        ));
    }
    let [width, height] = drawing.size();
    Ok(say(&format!(
        "{}: {width:.0} x {height:.0} mm, {}",
        path.display(),
        figure.title()
    ))?)
}
