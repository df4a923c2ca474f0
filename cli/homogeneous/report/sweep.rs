//! The page of a sweep of gases without positions: what its points say, side by side.

use std::path::Path;

use maud::html;

use super::Results;
use crate::manifest::{MANIFEST_FILE, SWEEP_FILE, Sweep};
use crate::report::figures::{number, with_error};
use crate::report::page::{self, Column};
use crate::report::{REPORT_FILE, ReportError, read, write_whole};

/// Builds the page of a sweep and rewrites the reports of its finished points.
pub(crate) fn build(folder: &Path) -> Result<String, ReportError> {
    let sweep: Sweep = read::json(&folder.join(SWEEP_FILE))?;
    let mut points = Vec::new();
    for point in &sweep.points {
        let inside = folder.join(&point.folder);
        let results = if inside.join(MANIFEST_FILE).exists() {
            let results = Results::read(&inside)?;
            write_whole(&inside.join(REPORT_FILE), &super::page_of(&results))?;
            Some(results)
        } else {
            None
        };
        points.push((point, results));
    }
    let finished = points.iter().filter(|point| point.1.is_some()).count();
    let columns: [Column; 8] = [
        ("point", true),
        ("quantity", true),
        ("species", false),
        ("t", false),
        ("measured", false),
        ("theory", false),
        ("deviation in %", false),
        ("verdict", true),
    ];
    let rows = points.iter().flat_map(|(point, results)| {
        let checks = results.iter().flat_map(|results| &results.checks);
        checks.map(|row| {
            vec![
                point.name.clone(),
                row.quantity.clone(),
                row.species
                    .map_or_else(|| "all".to_owned(), |species| species.to_string()),
                number(row.time, 4),
                with_error(Some(row.measured), row.measured_se),
                number(row.theory, 5),
                number(row.deviation_percent, 3),
                row.verdict.clone(),
            ]
        })
    });
    let rows: Vec<Vec<String>> = rows.collect();
    let content = html! {
        h1 { (sweep.title) }
        p.lead {
            "A sweep of " (points.len()) " points, of which " (finished) " are finished. Every point has a report of its own."
        }
        @for (point, results) in &points {
            h2 {
                @if results.is_some() { a href={ (point.folder) "/" (REPORT_FILE) } { (point.name) } } @else { (point.name) }
            }
            @match results {
                Some(results) => (page::verdict_list(&results.manifest.verdicts)),
                None => p.absent { "This point is not finished." },
            }
        }
        h2 { "Measured against theory" }
        (page::table("All points", &columns, &rows))
        h2 { "Case file" }
        (page::case_file(&sweep.case_text))
    };
    Ok(page::document(&sweep.title, &content, None))
}
