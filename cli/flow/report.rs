//! The report of a flow: one self-contained page.

use std::path::Path;

use maud::{Markup, html};

use super::manifest::Manifest;
use super::tables::{BoundaryRow, FieldRow, ProfileRow, SeriesRow, SpeciesRow};
use crate::manifest::{MANIFEST_FILE, SWEEP_FILE, Sweep, VerdictKind};
use crate::report::figures::{
    Figure, curve, distinct, engine_name, engines, number, ordered, same, theory, with_error,
};
use crate::report::page::{self, Counter};
use crate::report::plot::map::Map;
use crate::report::plot::{Axis, Chart, Curve, Point, Stroke};
use crate::report::{REPORT_FILE, ReportError, read, write_whole};
use crate::tables::Row;

/// Everything that is read from the folder.
struct Results {
    manifest: Manifest,
    series: Vec<SeriesRow>,
    species: Vec<SpeciesRow>,
    fields: Vec<FieldRow>,
    profiles: Vec<ProfileRow>,
    boundaries: Vec<BoundaryRow>,
}

/// Builds the page of a results folder.
pub(crate) fn build(folder: &Path) -> Result<String, ReportError> {
    let results = Results {
        manifest: read::json(&folder.join(MANIFEST_FILE))?,
        series: read::table(folder)?.unwrap_or_default(),
        species: read::table(folder)?.unwrap_or_default(),
        fields: read::table(folder)?.unwrap_or_default(),
        profiles: read::table(folder)?.unwrap_or_default(),
        boundaries: read::table(folder)?.unwrap_or_default(),
    };
    let mut counter = Counter::default();
    let content = html! {
        (head(&results))
        (course(&results, &mut counter))
        (maps(&results, &mut counter))
        (profiles(&results, &mut counter))
        (boundaries(&results))
        (provenance(&results.manifest))
    };
    Ok(page::document(&results.manifest.title, &content, None))
}

fn head(results: &Results) -> Markup {
    let manifest = &results.manifest;
    let warnings = (manifest.verdicts.iter())
        .filter(|verdict| verdict.kind == VerdictKind::Warning)
        .map(|verdict| &verdict.sentence)
        .chain(&manifest.warnings);
    let sides: Vec<String> = manifest.size.iter().map(|side| number(*side, 4)).collect();
    let derived = |name: &str| manifest.derived.get(name).copied();
    html! {
        h1 { (manifest.title) }
        nav {
            a href="#verdict" { "Verdict" }
            a href="#course" { "Course" }
            a href="#fields" { "Fields" }
            a href="#profiles" { "Profiles" }
            a href="#boundaries" { "Boundaries" }
            a href="#provenance" { "Case and provenance" }
        }
        section id="verdict" {
            p.lead {
                "A flow in a box of " (sides.join(" × "))
                @if let Some(grains) = derived("grains") { ", " (number(grains, 6)) " grains" }
                @if let Some(path) = derived("mean_free_path_of_the_dilute_gas") {
                    ", mean free path " (number(path, 3))
                }
                ", " (manifest.replicas) " replicas. Lengths, masses and times are in the units of the case; temperatures are energies."
            }
            (page::verdict_list(&manifest.verdicts))
            @for warning in warnings { p.warning { (warning) } }
        }
    }
}

/// The whole gas against time.
fn course(results: &Results, counter: &mut Counter) -> Markup {
    html! {
        section id="course" {
            h2 { "Course of the whole gas" }
            (page::figure(energies(&results.series), counter).unwrap_or_default())
            (page::figure(temperatures(&results.series), counter).unwrap_or_default())
            @if !results.species.is_empty() {
                (page::figure(species(&results.species), counter).unwrap_or_default())
            }
        }
    }
}

/// Points of a column of the series of one engine.
fn points(
    rows: &[SeriesRow],
    engine: &str,
    of: impl Fn(&SeriesRow) -> Option<(f64, Option<f64>)>,
) -> Vec<Point> {
    let own = rows.iter().filter(|row| row.engine == engine);
    let all: Vec<Point> = own
        .filter_map(|row| {
            of(row).map(|(y, error)| Point {
                x: row.time,
                y,
                error,
            })
        })
        .collect();
    thinned(&all)
}

/// At most some hundred points of a curve.
fn thinned(points: &[Point]) -> Vec<Point> {
    const MOST: usize = 120;
    crate::report::figures::spread(points, MOST)
}

/// A part of the energy: its name, its column and its colour.
type Part = (&'static str, fn(&SeriesRow) -> f64, &'static str);
const PARTS: [Part; 4] = [
    ("all", |row| row.energy, "var(--ink)"),
    ("translation", |row| row.translation, "var(--engine-0)"),
    ("rotation", |row| row.rotation, "var(--engine-1)"),
    ("height", |row| row.potential, "var(--engine-2)"),
];

fn energies(rows: &[SeriesRow]) -> Option<Figure> {
    let names = engines(rows.iter().map(|row| &row.engine));
    let panels = names.iter().map(|name| {
        let curves = PARTS.iter().map(|(label, of, colour)| Curve {
            label: (*label).to_owned(),
            colour: (*colour).to_owned(),
            mark: None,
            stroke: Stroke::Solid,
            points: points(rows, name, |row| Some((of(row), None))),
        });
        let used = curves.filter(|curve| curve.points.iter().any(|point| point.y != 0.0));
        let chart = Chart {
            x: Axis::linear("time"),
            y: Axis::linear("energy of all grains"),
            curves: used.collect(),
            level: None,
        };
        let title = if names.len() > 1 {
            engine_name(name)
        } else {
            String::new()
        };
        (title, chart)
    });
    Figure {
        title: "Partition of the energy".to_owned(),
        panels: panels.collect(),
        caption: "Kinetic energy of translation and of rotation, energy of height, and their sum."
            .to_owned(),
    }
    .drawable()
}

/// A temperature of the series and its standard error.
type Temperature = fn(&SeriesRow) -> Option<(f64, Option<f64>)>;

fn temperatures(rows: &[SeriesRow]) -> Option<Figure> {
    let names = engines(rows.iter().map(|row| &row.engine));
    let panel = |of: Temperature, expected: fn(&SeriesRow) -> Option<f64>, label: &str| {
        let mut curves: Vec<Curve> = names
            .iter()
            .map(|name| Curve {
                mark: None,
                ..Curve {
                    points: points(rows, name, of),
                    ..curve(name, Stroke::Solid, rows, |_| None)
                }
            })
            .collect();
        let first = names.first().map_or("", String::as_str);
        let law = points(rows, first, |row| expected(row).map(|value| (value, None)));
        if !law.is_empty() {
            curves.push(theory("theory", law));
        }
        Chart {
            x: Axis::linear("time"),
            y: Axis::linear(label),
            curves,
            level: None,
        }
    };
    let translation = panel(
        |row| Some((row.temperature, row.temperature_se)),
        |row| row.theory_temperature,
        "granular temperature",
    );
    let rotation = panel(
        |row| {
            row.spin_temperature
                .map(|value| (value, row.spin_temperature_se))
        },
        |row| row.theory_spin_temperature,
        "temperature of rotation",
    );
    Figure {
        title: "Temperatures".to_owned(),
        panels: vec![
            ("translation".to_owned(), translation),
            ("rotation".to_owned(), rotation),
        ],
        caption: "Mean over the replicas, about the mean velocity of all grains; bars are standard errors.".to_owned(),
    }
    .drawable()
}

fn species(rows: &[SpeciesRow]) -> Option<Figure> {
    let names = engines(rows.iter().map(|row| &row.engine));
    let mut kinds: Vec<&String> = Vec::new();
    for row in rows {
        if !kinds.contains(&&row.species) {
            kinds.push(&row.species);
        }
    }
    let panels = names.iter().map(|name| {
        let curves = kinds.iter().enumerate().map(|(place, kind)| {
            let own = rows
                .iter()
                .filter(|row| &row.engine == name && &row.species == *kind);
            let all = own.map(|row| Point {
                x: row.time,
                y: row.temperature,
                error: row.temperature_se,
            });
            Curve {
                label: format!("species {kind}"),
                colour: format!("var(--engine-{})", place % 7),
                mark: None,
                stroke: Stroke::Solid,
                points: thinned(&ordered(all)),
            }
        });
        let chart = Chart {
            x: Axis::linear("time"),
            y: Axis::linear("temperature"),
            curves: curves.collect(),
            level: None,
        };
        (engine_name(name), chart)
    });
    Figure {
        title: "Temperatures of the species".to_owned(),
        panels: panels.collect(),
        caption: "Each about its own mean velocity.".to_owned(),
    }
    .drawable()
}

/// The windows of some rows, the last one written last.
fn windows<'a>(times: impl Iterator<Item = (f64, f64)> + 'a) -> Vec<(f64, f64)> {
    let mut found: Vec<(f64, f64)> = Vec::new();
    for (start, end) in times {
        if !found.iter().any(|&(a, b)| same(a, start) && same(b, end)) {
            found.push((start, end));
        }
    }
    found
}

fn within(window: (f64, f64), start: f64, end: f64) -> bool {
    same(window.0, start) && same(window.1, end)
}

/// Contour maps of the fields in the last window, one set for each engine.
fn maps(results: &Results, counter: &mut Counter) -> Markup {
    let rows = &results.fields;
    let names = engines(rows.iter().map(|row| &row.engine));
    let last = windows(rows.iter().map(|row| (row.window_start, row.window_end)))
        .last()
        .copied();
    let Some(last) = last else {
        return html! {};
    };
    let drawn: Vec<Markup> = names
        .iter()
        .filter_map(|name| engine_maps(results, name, last, counter))
        .collect();
    html! {
        section id="fields" {
            h2 { "Fields" }
            @if drawn.is_empty() {
                p.absent { "One cell along an axis: see the profiles. The fields are in " code { (FieldRow::FILE) } "." }
            } @else {
                p { "Averages from t = " (number(last.0, 4)) " to " (number(last.1, 4)) "; other windows of time are in the tables." }
            }
            @for figure in drawn { (figure) }
        }
    }
}

/// A field that is drawn: its name, its column and whether arrows show the velocity.
type Field = (&'static str, fn(&FieldRow) -> f64, bool);
const FIELDS: [Field; 6] = [
    ("number density", |row| row.number_density, false),
    (
        "speed of the flow",
        |row| row.velocity_x.hypot(row.velocity_y),
        true,
    ),
    ("granular temperature", |row| row.temperature, false),
    ("temperature of rotation", |row| row.spin_temperature, false),
    ("pressure", |row| row.pressure, false),
    ("collision rate", |row| row.collision_rate, false),
];

fn engine_maps(
    results: &Results,
    engine: &str,
    window: (f64, f64),
    counter: &mut Counter,
) -> Option<Markup> {
    let rows: Vec<&FieldRow> = (results.fields.iter())
        .filter(|row| row.engine == engine && within(window, row.window_start, row.window_end))
        .collect();
    let places = [
        distinct(rows.iter().map(|row| row.x)),
        distinct(rows.iter().map(|row| row.y)),
    ];
    let size = [
        results.manifest.size.first().copied().unwrap_or(1.0),
        results.manifest.size.get(1).copied().unwrap_or(1.0),
    ];
    let drawn: Vec<(&str, Map)> = FIELDS
        .iter()
        .map(|(label, of, arrows)| {
            let map = Map {
                label: (*label).to_owned(),
                size,
                places: places.clone(),
                values: rows.iter().map(|row| of(row)).collect(),
                arrows: if *arrows {
                    rows.iter()
                        .map(|row| [row.velocity_x, row.velocity_y])
                        .collect()
                } else {
                    Vec::new()
                },
            };
            (*label, map)
        })
        .filter(|(_, map)| !map.is_empty())
        .collect();
    (!drawn.is_empty()).then(|| {
        page::maps(
            &format!("Fields, {}", engine_name(engine)),
            "Filled contours; the arrows are the mean velocity.",
            &drawn,
            counter,
        )
    })
}

/// Profiles along both axes in all windows.
fn profiles(results: &Results, counter: &mut Counter) -> Markup {
    html! {
        section id="profiles" {
            h2 { "Profiles" }
            @for along in ["y", "x"] {
                (page::figure(profile(&results.profiles, along), counter).unwrap_or_default())
            }
            (page::figure(development(&results.profiles), counter).unwrap_or_default())
        }
    }
}

/// A column of a profile and its standard error.
type Column = (&'static str, fn(&ProfileRow) -> (f64, Option<f64>));
const COLUMNS: [Column; 6] = [
    ("number density", |row| {
        (row.number_density, row.number_density_se)
    }),
    ("velocity along x", |row| {
        (row.velocity_x, row.velocity_x_se)
    }),
    ("velocity along y", |row| {
        (row.velocity_y, row.velocity_y_se)
    }),
    ("granular temperature", |row| {
        (row.temperature, row.temperature_se)
    }),
    ("temperature of rotation", |row| {
        (row.spin_temperature, row.spin_temperature_se)
    }),
    ("pressure", |row| (row.pressure, row.pressure_se)),
];

fn profile(rows: &[ProfileRow], along: &str) -> Option<Figure> {
    let rows: Vec<&ProfileRow> = rows.iter().filter(|row| row.along == along).collect();
    let last = *windows(rows.iter().map(|row| (row.window_start, row.window_end))).last()?;
    let rows: Vec<&ProfileRow> = rows
        .into_iter()
        .filter(|row| within(last, row.window_start, row.window_end))
        .collect();
    if distinct(rows.iter().map(|row| row.at)).len() < 2 {
        return None;
    }
    let names = engines(rows.iter().map(|row| &row.engine));
    let mut kinds: Vec<&String> = Vec::new();
    for row in &rows {
        if !kinds.contains(&&row.species) {
            kinds.push(&row.species);
        }
    }
    let panels = COLUMNS.iter().map(|(label, of)| {
        let mut curves = Vec::new();
        for (place, kind) in kinds.iter().enumerate() {
            for name in &names {
                let own = rows
                    .iter()
                    .filter(|row| &row.engine == name && &row.species == *kind);
                let all: Vec<Point> = own
                    .map(|row| {
                        let (y, error) = of(row);
                        Point {
                            x: row.at,
                            y,
                            error,
                        }
                    })
                    .collect();
                if all.iter().all(|point| point.y == 0.0) {
                    continue;
                }
                let mut line = curve(name, Stroke::Thin, &all, |point| Some(*point));
                if kinds.len() > 1 {
                    line.label = format!("{}, {kind}", engine_name(name));
                    line.colour = format!("var(--engine-{})", place % 7);
                }
                curves.push(line);
            }
            if *label == "number density" {
                let first = names.first().map_or("", String::as_str);
                let law = rows
                    .iter()
                    .filter(|row| row.engine == first && &row.species == *kind);
                let law = law.filter_map(|row| {
                    row.theory_number_density.map(|y| Point {
                        x: row.at,
                        y,
                        error: None,
                    })
                });
                let law = ordered(law);
                if !law.is_empty() {
                    curves.push(theory("barometric", law));
                }
            }
        }
        let chart = Chart {
            x: Axis::linear(along),
            y: Axis::linear(label),
            curves,
            level: None,
        };
        ((*label).to_owned(), chart)
    });
    Figure {
        title: format!("Profiles along {along}"),
        panels: panels.collect(),
        caption: format!(
            "Averages over the other axis and from t = {} to {}; bars are standard errors from blocks of time.",
            number(last.0, 4),
            number(last.1, 4)
        ),
    }
    .drawable()
}

/// How the density along y develops through the windows.
fn development(rows: &[ProfileRow]) -> Option<Figure> {
    let rows: Vec<&ProfileRow> = rows
        .iter()
        .filter(|row| row.along == "y" && row.species == "all")
        .collect();
    let all = windows(rows.iter().map(|row| (row.window_start, row.window_end)));
    if all.len() < 2 || distinct(rows.iter().map(|row| row.at)).len() < 2 {
        return None;
    }
    let names = engines(rows.iter().map(|row| &row.engine));
    let panels = names.iter().map(|name| {
        let curves = all.iter().enumerate().map(|(place, &window)| {
            let own = rows.iter().filter(|row| {
                &row.engine == name && within(window, row.window_start, row.window_end)
            });
            let points = own.map(|row| Point {
                x: row.at,
                y: row.number_density,
                error: row.number_density_se,
            });
            Curve {
                label: format!("t = {} to {}", number(window.0, 4), number(window.1, 4)),
                colour: crate::report::figures::shade(place, all.len()),
                mark: None,
                stroke: Stroke::Solid,
                points: ordered(points),
            }
        });
        let chart = Chart {
            x: Axis::linear("y"),
            y: Axis::linear("number density"),
            curves: curves.collect(),
            level: None,
        };
        (engine_name(name), chart)
    });
    Figure {
        title: "Development of the density".to_owned(),
        panels: panels.collect(),
        caption: "The windows of time that the case asks for, and last the steady state."
            .to_owned(),
    }
    .drawable()
}

fn boundaries(results: &Results) -> Markup {
    let columns = [
        ("engine", true),
        ("boundary", true),
        ("grains per time", false),
        ("force along x", false),
        ("force along y", false),
        ("power", false),
    ];
    let rows: Vec<Vec<String>> = results
        .boundaries
        .iter()
        .map(|row| {
            vec![
                engine_name(&row.engine),
                row.boundary.clone(),
                with_error(Some(row.grains_per_time), row.grains_per_time_se),
                with_error(Some(row.force_x), row.force_x_se),
                with_error(Some(row.force_y), row.force_y_se),
                with_error(Some(row.power), row.power_se),
            ]
        })
        .collect();
    let work: Vec<Vec<String>> = (results.manifest.engines.iter())
        .flat_map(|engine| {
            let name = engine_name(&engine.engine);
            let seconds = ("seconds, all replicas".to_owned(), engine.wall_seconds);
            let collisions = (
                "collisions, all replicas".to_owned(),
                engine.collisions as f64,
            );
            let named = engine
                .work
                .iter()
                .map(|(what, value)| (what.replace('_', " "), *value));
            let all: Vec<_> = [seconds, collisions].into_iter().chain(named).collect();
            all.into_iter()
                .map(move |(what, value)| vec![name.clone(), what, number(value, 5)])
        })
        .collect();
    html! {
        section id="boundaries" {
            h2 { "Boundaries" }
            @if rows.is_empty() {
                p.absent { "The box is periodic: nothing comes from outside." }
            } @else {
                p { "What each boundary gives to the gas, per time, in the last window: grains that touch it, or that come in (below zero: leave), momentum and energy." }
                (page::table("Boundaries", &columns, &rows))
            }
            h2 { "Work" }
            (page::table("Work", &[("engine", true), ("quantity", true), ("value", false)], &work))
        }
    }
}

fn provenance(manifest: &Manifest) -> Markup {
    let mut rows: Vec<Vec<String>> = manifest
        .derived
        .iter()
        .map(|(name, value)| vec![name.replace('_', " "), number(*value, 6)])
        .collect();
    rows.extend([
        vec![
            "program".to_owned(),
            format!("{} {}", manifest.program.name, manifest.program.version),
        ],
        vec!["seed".to_owned(), manifest.seed.to_string()],
        vec!["replicas".to_owned(), manifest.replicas.to_string()],
        vec!["seconds".to_owned(), number(manifest.wall_seconds, 4)],
        vec!["processor".to_owned(), manifest.machine.processor.clone()],
        vec!["cores".to_owned(), manifest.machine.cores.to_string()],
    ]);
    html! {
        section id="provenance" {
            h2 { "Case and provenance" }
            h3 { "Case file" }
            (page::case_file(&manifest.case_text))
            h3 { "Derived quantities, program and machine" }
            (page::table("Provenance", &[("what", true), ("value", true)], &rows))
        }
    }
}

/// Builds the page of a sweep and rewrites the reports of its finished points.
pub(crate) fn build_sweep(folder: &Path) -> Result<String, ReportError> {
    let sweep: Sweep = read::json(&folder.join(SWEEP_FILE))?;
    let mut rows = Vec::new();
    for point in &sweep.points {
        let inside = folder.join(&point.folder);
        let finished = inside.join(MANIFEST_FILE).exists();
        let verdicts = if finished {
            write_whole(&inside.join(REPORT_FILE), &build(&inside)?)?;
            read::json::<Manifest>(&inside.join(MANIFEST_FILE))?.verdicts
        } else {
            Vec::new()
        };
        rows.push((point, finished, verdicts));
    }
    let content = html! {
        h1 { (sweep.title) }
        p.lead {
            "A sweep of " (rows.len()) " points, of which " (rows.iter().filter(|row| row.1).count())
            " are finished. Every point has a report of its own."
        }
        @for (point, finished, verdicts) in &rows {
            h3 {
                @if *finished { a href=(page::link_to(&point.folder)) { (point.name) } } @else { (point.name) }
            }
            @if *finished { (page::verdict_list(verdicts)) } @else { p.absent { "Not finished." } }
        }
        h2 { "Case file" }
        (page::case_file(&sweep.case_text))
    };
    Ok(page::document(&sweep.title, &content, None))
}
