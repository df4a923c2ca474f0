//! The page of a gas without positions, built from its results folder with the pieces of the paired case's page.

mod figures;
mod sweep;

use std::path::Path;

use maud::{Markup, html};

use super::manifest::Manifest;
use super::tables::{
    CheckRow, ClusterRow, GasRow, SampleRow, SizeRow, SpeciesRow, TimeAveragedRow,
};
use crate::manifest::VerdictKind;
use crate::report::figures::{Figure, number, with_error};
use crate::report::page::{self, Column, Counter};
use crate::report::{REPORT_FILE, ReportError, read};
use crate::tables::Row;

pub(crate) use sweep::build as build_sweep;

/// Everything that the page is made of.
#[derive(Debug)]
pub(super) struct Results {
    pub manifest: Manifest,
    pub gas: Vec<GasRow>,
    pub species: Vec<SpeciesRow>,
    pub time_averaged: Vec<TimeAveragedRow>,
    pub clusters: Vec<ClusterRow>,
    pub sizes: Vec<SizeRow>,
    pub checks: Vec<CheckRow>,
}

impl Results {
    /// Reads a results folder; a table that its case does not ask for has no rows.
    fn read(folder: &Path) -> Result<Self, ReportError> {
        fn rows<R: Row>(folder: &Path) -> Result<Vec<R>, ReportError> {
            Ok(read::table(folder)?.unwrap_or_default())
        }
        Ok(Self {
            manifest: read::json(&folder.join(crate::manifest::MANIFEST_FILE))?,
            gas: rows(folder)?,
            species: rows(folder)?,
            time_averaged: rows(folder)?,
            clusters: rows(folder)?,
            sizes: rows(folder)?,
            checks: rows(folder)?,
        })
    }
}

/// Builds the page of a results folder.
pub(crate) fn build(folder: &Path) -> Result<String, ReportError> {
    Ok(page_of(&Results::read(folder)?))
}

fn page_of(results: &Results) -> String {
    let manifest = &results.manifest;
    let mut counter = Counter::default();
    let content = html! {
        h1 { (manifest.title) }
        nav {
            a href="#verdict" { "Verdict" }
            a href="#plots" { "Plots" }
            a href="#tables" { "Tables" }
            a href="#provenance" { "Case and provenance" }
        }
        (summary(results))
        section id="plots" {
            @for (heading, list) in sections(results) {
                h2 { (heading) }
                div.pair[list.len() > 1] { @for figure in list { (drawn(figure, &mut counter)) } }
            }
        }
        section id="tables" {
            h2 { "Tables" }
            h3 { "Measured against theory" }
            (checks(results))
            h3 { "Work of a replica" }
            (numbers("Work", manifest.work.iter()))
            h3 { "Derived quantities" }
            (numbers("Derived quantities", manifest.derived.iter()))
        }
        (provenance(manifest))
    };
    page::document(&manifest.title, &content, None)
}

/// The figures that there is something to draw for, by section.
fn sections(results: &Results) -> Vec<(&'static str, Vec<Figure>)> {
    let list = [
        (
            "Cooling",
            vec![
                figures::energy(&results.gas),
                figures::temperatures(&results.species),
                figures::temperature_by_mass(&results.species),
            ],
        ),
        (
            "Collisions and velocities",
            vec![
                figures::collisions(&results.gas),
                figures::cumulants(&results.species),
                figures::correlations(&results.species),
            ],
        ),
        (
            "Diffusion",
            vec![
                figures::displacements(&results.gas, &results.species),
                figures::displacement_by_mass(&results.species),
                figures::time_averaged(&results.time_averaged),
            ],
        ),
        (
            "Clusters",
            vec![
                figures::clusters(&results.clusters),
                figures::sizes(&results.sizes),
            ],
        ),
    ];
    list.into_iter()
        .map(|(heading, figures)| (heading, figures.into_iter().flatten().collect::<Vec<_>>()))
        .filter(|(_, figures)| !figures.is_empty())
        .collect()
}

fn drawn(figure: Figure, counter: &mut Counter) -> Markup {
    page::figure(Some(figure), counter).unwrap_or_else(|| html! {})
}

/// What was run, in one sentence.
fn statement(results: &Results) -> String {
    let manifest = &results.manifest;
    let quantity = |name: &str| manifest.derived.get(name).copied().unwrap_or(f64::NAN);
    let dimension = manifest.case["dimension"].as_u64().unwrap_or(3);
    let species = quantity("species");
    let kinds = if species == 1.0 {
        String::new()
    } else {
        format!(" of {species:.0} species")
    };
    let last = results.gas.last().map_or(f64::NAN, |row| row.time);
    let unit = match manifest.case["run"]["time_unit"].as_str() {
        Some("haff") => " times Haff’s time of the start",
        Some("mean-free-time") => " mean free times of the start",
        _ => " in the units of the case",
    };
    let errors = if manifest.replicas == 1 {
        "A single replica was run: standard errors are from the spread over particles where that is known.".to_owned()
    } else {
        format!(
            "Standard errors are the larger of the spread over {} replicas and that over particles.",
            manifest.replicas
        )
    };
    format!(
        "A gas of {} particles{kinds} without positions, in {dimension} dimensions at the packing fraction {}, was followed up \
         to t = {}{unit} by Monte Carlo without time steps. {errors}",
        number(quantity("particles"), 12),
        number(quantity("packing_fraction"), 4),
        number(last, 4),
    )
}

/// Statement, verdicts and warnings.
fn summary(results: &Results) -> Markup {
    let manifest = &results.manifest;
    let urgent: Vec<_> = manifest
        .verdicts
        .iter()
        .filter(|verdict| verdict.kind == VerdictKind::Warning)
        .collect();
    html! {
        section id="verdict" {
            p.lead { (statement(results)) }
            (page::verdict_list(&manifest.verdicts))
            @if !(urgent.is_empty() && manifest.warnings.is_empty()) {
                div.warnings role="alert" {
                    strong { "Warnings" }
                    ul {
                        @for verdict in &urgent { li { strong { (verdict.topic) } ": " (verdict.sentence) } }
                        @for warning in &manifest.warnings { li { (warning) } }
                    }
                }
            }
        }
    }
}

/// Table of the comparisons.
fn checks(results: &Results) -> Markup {
    let columns: [Column; 8] = [
        ("quantity", true),
        ("species", false),
        ("t", false),
        ("measured", false),
        ("theory", false),
        ("deviation in %", false),
        ("z", false),
        ("verdict", true),
    ];
    let optional = |value: Option<f64>| value.map_or_else(|| "–".to_owned(), |z| number(z, 3));
    let lines: Vec<Vec<String>> = results
        .checks
        .iter()
        .map(|row| {
            vec![
                row.quantity.clone(),
                row.species
                    .map_or_else(|| "all".to_owned(), |species| species.to_string()),
                number(row.time, 4),
                with_error(Some(row.measured), row.measured_se),
                match row
                    .theory_error
                    .filter(|error| *error > 1e-4 * row.theory.abs())
                {
                    Some(error) => with_error(Some(row.theory), Some(error)),
                    None => number(row.theory, 5),
                },
                number(row.deviation_percent, 3),
                optional(row.z),
                row.verdict.clone(),
            ]
        })
        .collect();
    html! {
        @if lines.is_empty() {
            p.absent { "There is no theory for this gas." }
        } @else {
            p {
                "Each line is told at its worst time: that of the largest deviation beyond three standard errors, or else of the "
                "largest one. A difference is larger than the tolerance of the case and than three standard errors; agreement is "
                "within the tolerance, with an error within it too; the fourth cumulant has no tolerance but its error. The error "
                "of theory is what one Sonine order less would change; it counts as the others do."
            }
            (page::table("Measured against theory", &columns, &lines))
        }
    }
}

/// Table of named numbers.
fn numbers<'a>(name: &str, values: impl Iterator<Item = (&'a String, &'a f64)>) -> Markup {
    let lines: Vec<Vec<String>> = values
        .map(|(name, value)| vec![name.replace('_', " "), number(*value, 8)])
        .collect();
    page::table(name, &[("quantity", true), ("value", false)], &lines)
}

/// Case file, versions and machine.
fn provenance(manifest: &Manifest) -> Markup {
    let program = &manifest.program;
    let rows = [
        ("program", format!("{} {}", program.name, program.version)),
        ("seed", manifest.seed.to_string()),
        ("replicas", manifest.replicas.to_string()),
        ("seconds", number(manifest.wall_seconds, 4)),
        ("processor", manifest.machine.processor.clone()),
        ("cores", manifest.machine.cores.to_string()),
        ("system", manifest.machine.system.clone()),
    ];
    let lines: Vec<Vec<String>> = rows
        .into_iter()
        .map(|(what, value)| vec![what.to_owned(), value])
        .collect();
    html! {
        section id="provenance" {
            h2 { "Case and provenance" }
            h3 { "Case file" }
            (page::case_file(&manifest.case_text))
            h3 { "Versions, seed and machine" }
            (page::table("Provenance", &[("what", true), ("value", true)], &lines))
            p {
                "The numbers behind every figure are beside this page: " code { (GasRow::FILE) } ", " code { (SpeciesRow::FILE) }
                " and the others; single replicas are in " code { (SampleRow::FILE) } "."
            }
        }
        footer {
            p { "This page is complete in itself: it loads nothing, and can be rebuilt from the tables of its folder, which stand beside " code { (REPORT_FILE) } "." }
        }
    }
}
