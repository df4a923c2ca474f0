//! HTML report page of one run.

use std::path::Path;

use maud::{Markup, PreEscaped, html};
use serde_json::Value;
use stosszahl_results::{
    Figure, MANIFEST_FILE, Manifest, PointMark, REPORT_FILE, Snapshot, Stored, Table, VerdictKind,
    VerdictText, engine_title, headlines, quantity_title,
};

use crate::archive::{self, Archive};
use crate::figure::{Drawn, draw};
use crate::page::{self, ListColumn};
use crate::sheet::sheet;
use crate::viewer::{self, Player};
use crate::words::number;
use crate::{Report, ReportError};

/// Builds the HTML report page of a finished run.
pub(crate) fn build(folder: &Path, stored: &Stored) -> Result<Report, ReportError> {
    let manifest = &stored.manifest;
    let player = viewer::player(folder, manifest)?;
    let Figures {
        first,
        others,
        drawings,
    } = figures(stored);
    let mut archive = Archive::new(&manifest.title);
    add_to_archive(&mut archive, folder, "", manifest, &drawings)?;
    let rest = || {
        stored
            .tables
            .iter()
            .filter(|table| table.figures.is_empty())
    };
    let content = html! {
        h1 { (manifest.title) }
        @if !manifest.question.text.is_empty() { p.lead { (manifest.question.text) } }
        nav {
            a href="#verdicts" { "Verdicts" } a href="#figures" { "Figures" }
            @if has_particles(manifest) { a href="#snapshots" { "Particles" } }
            a href="#tables" { "Numbers" } a href="#provenance" { "Case and provenance" }
        }
        (summary(stored, &player, &first))
        section id="figures" { h2 { "Figures" } (others) }
        (particles(&player, manifest))
        section id="tables" {
            @if rest().next().is_some() { h2 { "More tables" } @for table in rest() { (page::folded(table)) } }
            (derived(manifest)) (work_table(manifest)) (start_table(manifest))
        }
        (provenance(manifest, &archive.section()))
    };
    let mut scripts = vec![archive::SCRIPT];
    if !player.data.is_empty() {
        scripts.push(viewer::SCRIPT);
    }
    Ok(Report {
        page: page::document(&manifest.title, &content, &scripts),
        beside: drawings,
    })
}

/// Adds the files of a run to an archive: manifest, tables, drawings, and snapshots as long as they
/// fit. `point` is a prefix for their names: the name of the sweep point with a slash, or empty.
pub(crate) fn add_to_archive(
    archive: &mut Archive,
    folder: &Path,
    point: &str,
    manifest: &Manifest,
    drawings: &[(String, Vec<u8>)],
) -> Result<(), ReportError> {
    archive.add_file(folder, &format!("{point}{MANIFEST_FILE}"))?;
    for table in &manifest.tables {
        archive.add_file(folder, &format!("{point}{}", table.file()))?;
    }
    for (name, bytes) in drawings {
        archive.add(&format!("{point}{name}"), bytes);
    }
    // The player of the page has the frames.
    for snapshot in &manifest.snapshots {
        archive.add_file(folder, &format!("{point}{}", snapshot.file))?;
    }
    Ok(())
}

/// Builds the summary of the page: case and engines in a few sentences, and the verdicts.
fn summary(stored: &Stored, player: &Player, figure: &Markup) -> Markup {
    let manifest = &stored.manifest;
    let engines: Vec<&str> = manifest
        .engines
        .iter()
        .map(|one| engine_title(&one.engine))
        .collect();
    let first = headlines(&manifest.verdicts);
    let others = manifest.verdicts.iter().filter(|one| !first.contains(one));
    let (urgent, mut rest): (Vec<&VerdictText>, Vec<&VerdictText>) =
        others.partition(|one| one.kind == VerdictKind::Warning);
    // Where nothing is compared, the first informative number answers the question.
    let told = (rest.iter().position(|one| one.topic != "steady state"))
        .filter(|_| first.is_empty())
        .map(|place| rest.remove(place));
    let uneven = manifest
        .start
        .iter()
        .filter(|start| start.equilibrated == Some(false))
        .count();
    // Warnings that may void the results below.
    let mut warnings: Vec<Markup> = Vec::new();
    if uneven > 0 {
        warnings.push(html! {
            strong { "The start was not in equilibrium" } " in " (uneven) " of " (manifest.start.len())
            " replicas. Differences may come from the start; see " a href="#start" { "its tests" } "."
        });
    }
    for file in &stored.changed {
        warnings.push(html! { code { (file) } " is not the file that the run wrote." });
    }
    for file in &player.missing {
        warnings.push(html! { "The file " code { (file) } " is missing." });
    }
    let said = |one: &&VerdictText| html! { strong { (one.topic) } ": " (one.sentence) };
    warnings.extend(urgent.iter().map(said));
    html! {
        section id="verdicts" {
            (page::warnings(&warnings))
            @match first.first().copied().or(told) {
                Some(first) => { (page::headline(first)) }
                None => { p.absent { "This run has no verdict." } }
            }
            (figure)
            @if first.len() > 1 { (page::verdicts(&first[1..])) }
            @if !rest.is_empty() {
                @if first.is_empty() { (page::verdicts(&rest)) } @else {
                    details { summary { "More conclusions and numbers, " (rest.len()) } (page::verdicts(&rest)) }
                }
            }
            @if !manifest.warnings.is_empty() {
                details {
                    summary { "What to read with care, " (manifest.warnings.len()) }
                    ul { @for text in &manifest.warnings { li { (text) } } }
                }
            }
            @if !manifest.choices.is_empty() {
                details {
                    summary { "What the program chose, " (manifest.choices.len()) }
                    ul { @for choice in &manifest.choices { li { (choice) } } }
                }
            }
            p {
                @match engines.as_slice() {
                    [] => {}
                    [one] => { "Engine: " (one) ". " }
                    several => { "Engines: " (several.join(", ")) ". " }
                }
                (manifest.replicas) @if manifest.replicas == 1 { " replica, so standard errors over replicas are unknown" } @else { " replicas" } ". "
                "Unit of time: " (manifest.time_unit.name.strip_prefix("unit of time").map_or_else(|| manifest.time_unit.name.clone(), |of| format!("that{of}")))
                @if manifest.time_unit.size.is_finite() && manifest.time_unit.size != 1.0 {
                    ", " (number(manifest.time_unit.size, 5)) " in units of the case"
                }
                "."
            }
        }
    }
}

/// Figures of the report page of a run.
struct Figures {
    /// HTML of the figure that the question of the case asks for, or of the first figure.
    first: Markup,
    /// HTML of all other figures, each with its table below.
    others: Markup,
    /// Drawings of all figures as files: names and contents.
    drawings: Vec<(String, Vec<u8>)>,
}

/// Entry of the figures section of a page: a figure, or a table without one.
enum Part<'a> {
    Figure(&'a Figure, Drawn),
    Other(Markup),
}

/// Draws all figures of a table, each with the name of its file; `None` where there is nothing to
/// draw.
pub(crate) fn drawn<'a>(
    table: &'a Table,
    obstacles: &[Value],
) -> Vec<(&'a Figure, String, Option<Drawn>)> {
    let named = table.figures.iter().zip(table.drawings());
    let drawn = named.map(|(figure, file)| {
        let mut drawn = draw(table, figure);
        if figure.mark == PointMark::Map && figure.x.column == "x" && figure.y.column == "y" {
            let panels = drawn.iter_mut().flat_map(|drawn| &mut drawn.panels);
            panels.for_each(|panel| panel.add_obstacles(obstacles));
        }
        (figure, file, drawn)
    });
    drawn.collect()
}

fn figures(stored: &Stored) -> Figures {
    let (mut first, mut others, mut drawings) = (Vec::new(), Vec::new(), Vec::new());
    let obstacles = viewer::obstacles(&stored.manifest);
    let question = &stored.manifest.question;
    let answers = |table: &Table, figure: &Figure| {
        table.name == question.table && figure.y.column == question.column
    };
    let mut all = stored.tables.iter().flat_map(|table| {
        let figures = table.figures.iter();
        figures.map(move |figure| (table, figure))
    });
    let answered = all.any(|(table, figure)| answers(table, figure));
    for table in &stored.tables {
        for (figure, file, drawn) in drawn(table, &obstacles) {
            let Some(drawn) = drawn else {
                others.push(Part::Other(html! { p.absent { (figure.title) ": " code { (table.file()) } " holds no value that could be drawn." } }));
                continue;
            };
            drawings.push((file, sheet(&figure.title, &drawn).into_bytes()));
            let leads = if answered {
                answers(table, figure)
            } else {
                drawings.len() == 1
            };
            if leads && first.is_empty() {
                first.push((figure, drawn));
            } else {
                others.push(Part::Figure(figure, drawn));
            }
        }
        if !table.figures.is_empty() {
            others.push(Part::Other(page::folded(table)));
        }
    }
    // Figures are numbered in the order of the page.
    let mut count = 0;
    let mut numbered = |figure: &Figure, drawn: &Drawn| {
        count += 1;
        page::figure(count, &figure.title, &figure.caption, drawn)
    };
    let first: Vec<Markup> = first
        .iter()
        .map(|(figure, drawn)| numbered(figure, drawn))
        .collect();
    let others: Vec<Markup> = (others.into_iter())
        .map(|part| match part {
            Part::Figure(figure, drawn) => numbered(figure, &drawn),
            Part::Other(markup) => markup,
        })
        .collect();
    Figures {
        first: html! { div.answer { @for one in &first { (one) } } },
        others: html! {
            @if others.is_empty() { p.absent { "No table of this run is drawn." } }
            @for part in &others { (part) }
        },
        drawings,
    }
}

fn has_particles(manifest: &Manifest) -> bool {
    let mut snapshots = manifest.snapshots.iter();
    snapshots.any(Snapshot::is_shown) || !manifest.frames.is_empty()
}

/// Builds the section of the page with the particle player.
fn particles(player: &Player, manifest: &Manifest) -> Markup {
    html! {
        @if has_particles(manifest) {
            section id="snapshots" {
                h2 { "Particles" }
                @if player.data.is_empty() {
                    p.absent { "No frame or snapshot of this run is left to be shown." }
                } @else {
                    p {
                        "The first replica. Drag to move; click a picture and turn the wheel to magnify; double-click to return."
                        @if player.sampled { " Where not all particles are shown, those that are shown are a fair sample." }
                        @if player.shown < player.available { " Shown are " (player.shown) " of " (player.available) " times." }
                    }
                    (player_controls(player))
                    div id="viewer" {}
                    noscript { p.absent { "The player needs JavaScript." } }
                    script type="application/json" id="frames" { (PreEscaped(&player.data)) }
                }
            }
        }
    }
}

/// Builds the controls of the particle player, and its colour legend.
fn player_controls(player: &Player) -> Markup {
    html! {
        // The script shows the controls, which do nothing without it.
        div.controls id="viewer-controls" hidden {
            @if player.shown > 1 {
                button id="viewer-play" type="button" aria-pressed="false" { "play" }
                input id="viewer-time" type="range" min="0" max=(player.shown - 1) step="1" aria-label="time";
            }
            output id="viewer-label" {}
            @if player.shown > 1 {
                label { "frames in a second " select id="viewer-speed" {
                    @for rate in [2, 5, 10, 20] { option selected[rate == 5] { (rate) } }
                } }
            }
            label { "colour " select id="viewer-colour" {
                option value="direction" { "direction" } option value="speed" { "speed" }
                option value="density" { "local density" } option value="field" { "field of density and velocity" }
                option value="partner" { "energy of the last partner" } option value="impact" { "last impact parameter" }
            } }
            span {
                button id="viewer-closer" type="button" title="magnify" { "+" } " "
                button id="viewer-farther" type="button" title="show more" { "−" } " "
                button id="viewer-home" type="button" { "reset" }
            }
            span.compass data-key="direction" role="img" aria-label="colour of each direction" {}
            span.ramp data-key="speed" hidden { "0" i {} "2 times the root mean square" }
            span.ramp data-key="density field" hidden { "0" i {} "3 times the mean" }
            span.ramp data-key="partner" hidden { "0" i {} "4 times the mean" }
            span.ramp data-key="impact" hidden { "central" i {} "grazing" }
        }
    }
}

fn derived(manifest: &Manifest) -> Markup {
    let rows = manifest.derived.iter().map(|one| {
        let unit = if one.unit == "1" {
            String::new()
        } else {
            one.unit.clone()
        };
        vec![quantity_title(&one.name), number(one.value, 6), unit]
    });
    let columns: [ListColumn<'_>; 3] = [("quantity", true), ("value", false), ("unit", true)];
    html! {
        @if !manifest.derived.is_empty() { h2 { "What follows from the case" } (page::table(&columns, &rows.collect::<Vec<_>>())) }
    }
}

/// Builds the table of the engines' work counters, with one column for each engine.
fn work_table(manifest: &Manifest) -> Markup {
    let engines = &manifest.engines;
    let mut rows: Vec<Vec<String>> = Vec::new();
    let mut add = |name: &str, value: &dyn Fn(usize) -> Option<String>| {
        let cells = (0..engines.len()).map(|i| value(i).unwrap_or("–".into()));
        rows.push(
            std::iter::once(name.replace('_', " "))
                .chain(cells)
                .collect(),
        );
    };
    add("computing time [s]", &|i| {
        Some(number(engines[i].seconds, 4))
    });
    add("collisions", &|i| Some(engines[i].collisions.to_string()));
    add("collisions per second", &|i| {
        let rate = engines[i].collisions as f64 / engines[i].seconds;
        Some(number(rate, 3))
    });
    add("memory [MiB]", &|i| {
        Some(number(engines[i].bytes as f64 / 1_048_576.0, 3))
    });
    let mut names: Vec<&String> = engines.iter().flat_map(|one| one.work.keys()).collect();
    names.sort();
    names.dedup();
    for name in names {
        add(name, &|i| Some(number(*engines[i].work.get(name)?, 6)));
    }
    let mut columns: Vec<ListColumn<'_>> = vec![("quantity", true)];
    columns.extend(engines.iter().map(|one| (engine_title(&one.engine), false)));
    html! {
        @if !engines.is_empty() {
            h2 { "Work of the engines" }
            p { "Over all replicas. The run took " (number(manifest.wall_seconds, 4)) " s on " (manifest.machine.cores) " cores." }
            (page::table(&columns, &rows))
        }
    }
}

/// Builds the table of the initial states of the replicas.
fn start_table(manifest: &Manifest) -> Markup {
    let mut rows = Vec::new();
    for start in &manifest.start {
        for test in &start.tests {
            let passed = test
                .passed
                .map_or("–", |passed| if passed { "yes" } else { "no" });
            rows.push(vec![
                start.replica.to_string(),
                test.name.clone(),
                number(test.statistic, 4),
                test.p_value.map_or("–".into(), |p| number(p, 3)),
                passed.to_owned(),
                test.detail.clone(),
            ]);
        }
    }
    let passed = manifest
        .start
        .iter()
        .filter(|start| start.equilibrated == Some(true))
        .count();
    let judged = manifest
        .start
        .iter()
        .any(|start| start.equilibrated.is_some());
    let columns: [ListColumn<'_>; 6] = [
        ("replica", false),
        ("test", true),
        ("statistic", false),
        ("p", false),
        ("passed", true),
        ("detail", true),
    ];
    html! {
        @if let Some(first) = manifest.start.first() {
            h2 id="start" { "Start" }
            p {
                "Placement: " (first.placement) ", then " (number(first.collisions_per_particle, 4))
                " elastic collisions per particle. "
                @if judged { (passed) " of " (manifest.start.len()) " replicas began in equilibrium." }
                @else { "The case gives the start." }
            }
            @if !rows.is_empty() {
                details { summary { "Tests of the start, " (rows.len()) } (page::table(&columns, &rows)) }
            }
        }
    }
}

/// Builds the section on provenance: case file, citation, versions and machine.
fn provenance(manifest: &Manifest, archive: &Markup) -> Markup {
    let built = match &*manifest.program.commit {
        "" => String::new(),
        commit => format!(" ({commit})"),
    };
    let program = format!(
        "{} {}{built}",
        manifest.program.name, manifest.program.version
    );
    let row = |name: &str, value: String| vec![name.to_owned(), value];
    html! {
        section id="provenance" {
            (page::case_file(&manifest.case_text))
            h2 { "Provenance" }
            (archive)
            p { "To cite, name the program, its version and the seed, and publish the case file: “computed with " (program) ", seed " (manifest.seed) "”." }
            (page::table(&[("what", true), ("value", true)], &[
                row("program", program.clone()),
                row("seed", manifest.seed.to_string()),
                row("replicas", manifest.replicas.to_string()),
                row("processor", manifest.machine.processor.clone()),
                row("cores", manifest.machine.cores.to_string()),
                row("system", manifest.machine.system.clone()),
                row("fingerprint", manifest.fingerprint.numbers.chars().take(16).collect()),
            ]))
        }
        footer { p { "This page loads nothing. It can be rebuilt from the tables that stand beside " code { (REPORT_FILE) } "." } }
    }
}
