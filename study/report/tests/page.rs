//! Pages of made-up results: required and forbidden contents.
#![allow(clippy::unwrap_used, reason = "a test may stop at what it cannot read")]

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use serde_json::json;
use stosszahl_report::{
    COLUMN_WIDTHS, PrintFigure, drawings, print_figure, print_figures, write_report,
};
use stosszahl_results::{
    Derived, EngineWork, Existing, Figure, FigureAxis, Folder, Keys, Machine, Manifest, PointMark,
    Program, ReferenceLine, RunId, RunPlace, Snapshot, StartRecord, StartTest, Sweep, SweepPoint,
    Table, TableEstimate, TimeUnitSize, VerdictKind, VerdictText,
};

const ENGINES: [&str; 2] = ["ed", "dsmc-contact-point"];
/// Files of uPlot 1.6.32 in the registry: name, bytes, BLAKE3.
const LIBRARY: [(&str, usize, &str); 3] = [
    (
        "uPlot.iife.min.js",
        51_081,
        "ea2d16ff65797375a846049c0f0a17f68b47a2850b9c73f2816ecf040ec9f2ce",
    ),
    (
        "uPlot.min.css",
        1_857,
        "70ead7542eab83ef6ff4269c1f139e3c40f5f59f98302552320b9f79188abba1",
    ),
    (
        "LICENSE",
        1_078,
        "80723da02446eaf6792b975295c3447a1492e3ca814b7645e8fbd366156b025a",
    ),
];

fn energy(shift: f64) -> Table {
    let mut table = Table::new("energy", "Energy of the gas")
        .key("engine", "", "The engine")
        .key("time", "time unit", "When")
        .with_theory(
            "energy_ratio",
            "1",
            "Kinetic energy over that of the start, <K> & co",
        )
        .note("replicas", "1", "Replicas");
    for (engine, factor) in ENGINES.iter().zip([1.0, 1.1]) {
        for step in 0..25 {
            let time = 0.01 * 10_f64.powf(f64::from(step) / 6.0);
            let law = (1.0 + time).powi(-2);
            let value = law * (1.0 + (factor - 1.0 + shift) * time / 20.0);
            let estimate = TableEstimate {
                replicas: None,
                value: Some(value),
                // One error is as large as the value, and one is unknown.
                standard_error: (step != 3).then_some(if step == 22 {
                    value
                } else {
                    0.04 * value
                }),
                theory: Some(law),
                theory_error: None,
            };
            table.add((*engine, time, estimate, 4_u64));
        }
    }
    let axes = (
        FigureAxis::logarithmic("time", "t / t₀"),
        FigureAxis::logarithmic("energy_ratio", "K(t) / K(0)"),
    );
    let mut figure = Figure::curves("Cooling", axes.0, axes.1);
    figure.caption = "Energy against time.".into();
    table.figure(figure)
}

fn impact() -> Table {
    let mut table = Table::new("impact_parameter", "Impact parameters")
        .key("engine", "", "The engine")
        .key("window_start", "time unit", "Begin")
        .key("window_end", "time unit", "End")
        .key("bin_low", "1", "Lower edge")
        .key("bin_high", "1", "Upper edge")
        .estimate("density", "1", "P(b/d)");
    for (engine, slope) in ENGINES.iter().zip([0.5, 0.0]) {
        for window in 0..3 {
            for bin in 0..10 {
                let low = f64::from(bin) / 10.0;
                let density = 1.0 + slope * f64::from(window) * (low - 0.45);
                let estimate = TableEstimate {
                    value: Some(density),
                    standard_error: Some(0.05),
                    ..TableEstimate::default()
                };
                table.add((
                    *engine,
                    f64::from(window),
                    f64::from(window + 1),
                    low,
                    low + 0.1,
                    estimate,
                ));
            }
        }
    }
    let axes = (
        FigureAxis::linear("bin_low", "b / d"),
        FigureAxis::linear("density", "P(b/d)"),
    );
    table.figure(Figure {
        caption: "Flat under chaos.".into(),
        panels: vec!["window_start".into(), "window_end".into()],
        mark: PointMark::Bars,
        lines: vec![ReferenceLine {
            label: "molecular chaos".into(),
            y: 1.0,
        }],
        ..Figure::curves("Impact parameter", axes.0, axes.1)
    })
}

fn fields() -> Table {
    let mut table = Table::new("fields", "Means over cells")
        .key("engine", "", "The engine")
        .key("x", "length", "Place")
        .key("y", "length", "Place")
        .value("density", "1/length²", "Number density")
        .value("temperature", "energy", "Temperature");
    for engine in ENGINES {
        for place in 0..240 {
            let (x, y) = (f64::from(place % 20) + 0.5, f64::from(place / 20) + 0.5);
            let density = (place != 7).then_some(1.0 + (x / 5.0).sin() * (y / 4.0).cos());
            table.add((engine, x, y, density, if place == 8 { f64::NAN } else { x }));
        }
    }
    let figure = Figure {
        mark: PointMark::Map,
        ..Figure::curves(
            "Density",
            FigureAxis::linear("x", "x"),
            FigureAxis::linear("y", "y"),
        )
    };
    let coloured = Figure {
        title: "Temperature".into(),
        colour: Some(FigureAxis::logarithmic("temperature", "T")),
        ..figure.clone()
    };
    table.figure(figure).figure(coloured)
}

fn species() -> Table {
    let mut table = Table::new("species", "Temperatures of the species")
        .key("time", "time unit", "When")
        .key("species", "", "Which")
        .with_theory("temperature", "1", "T/T(0)");
    for name in ["small", "large", "<b>"] {
        for step in 0..200 {
            let time = f64::from(step) * 0.05;
            let value = (-time / name.len() as f64).exp();
            let estimate = TableEstimate {
                value: Some(value),
                theory: Some(value * 1.02),
                ..TableEstimate::default()
            };
            table.add((time, name, estimate));
        }
    }
    table.figure(Figure {
        curves: vec!["engine".into(), "species".into()],
        ..Figure::curves(
            "Species",
            FigureAxis::linear("time", "time"),
            FigureAxis::linear("temperature", "T / T(0)"),
        )
    })
}

fn checks() -> Table {
    let mut table = Table::new("checks", "Comparisons")
        .key("quantity", "", "What")
        .value("measured", "1", "Value")
        .note("verdict", "", "Word");
    table.add(("energy", f64::INFINITY, "agree"));
    let axes = (
        FigureAxis::linear("quantity", "quantity"),
        FigureAxis::logarithmic("measured", "measured"),
    );
    table.figure(Figure {
        mark: PointMark::Points,
        ..Figure::curves("Nothing to draw", axes.0, axes.1)
    })
}

fn verdict(kind: VerdictKind) -> VerdictText {
    VerdictText {
        topic: format!("topic {}", kind.name()),
        sentence: "ED (exact) and DSMC contact point: <script>alert(1)</script> within 2 %.".into(),
        number: None,
        kind,
    }
}

fn manifest() -> Manifest {
    let kinds = [
        VerdictKind::Agree,
        VerdictKind::Differ,
        VerdictKind::Undecided,
        VerdictKind::Warning,
        VerdictKind::Note,
    ];
    Manifest {
        program: Program {
            name: "stosszahl".into(),
            version: "0.1.0".into(),
            commit: "0123456789ab".into(),
        },
        title: "Cooling & <i>chaos</i>".into(),
        case_text: "title = \"Cooling\" # </pre><script>".into(),
        time_unit: TimeUnitSize {
            name: "Haff's cooling time".into(),
            size: 12.5,
        },
        derived: vec![
            Derived {
                name: "mean free path".into(),
                value: 0.73,
                unit: "length".into(),
            },
            Derived {
                name: "haff_time".into(),
                value: f64::INFINITY,
                unit: "time".into(),
            },
        ],
        machine: Machine {
            cores: 2,
            processor: "a & b".into(),
            system: "linux".into(),
        },
        seed: 7,
        replicas: 4,
        wall_seconds: 12.0,
        start: vec![StartRecord {
            replica: 0,
            placement: "disordered".into(),
            collisions_per_particle: 10.0,
            equilibrated: Some(false),
            tests: vec![StartTest {
                name: "impact".into(),
                statistic: f64::NAN,
                p_value: Some(0.4),
                passed: Some(false),
                detail: "x < y".into(),
            }],
        }],
        engines: ENGINES
            .map(|engine| EngineWork {
                engine: engine.into(),
                seconds: if engine == "ed" { 0.0 } else { 3.0 },
                collisions: 1_234_567,
                bytes: 10_000_000,
                work: [("predictions".to_owned(), f64::NAN)].into(),
            })
            .to_vec(),
        verdicts: kinds.map(verdict).to_vec(),
        choices: vec!["cells of 1.2 d".into()],
        warnings: vec!["few particles".into()],
        ..Manifest::default()
    }
}

/// Writes a finished run with two snapshots.
fn write(place: &RunPlace<'_>, shift: f64) {
    let mut manifest = manifest();
    for engine in ENGINES {
        for (index, time) in [0.5, 5.0].into_iter().enumerate() {
            let mut text = "60\nLattice=\"10 0 0 0 10 0 0 0 1\" Properties=id:I:1:pos:R:3:velo:R:3:radius:R:1:mass:R:1\n".to_owned();
            for i in 0..60 {
                let _ = writeln!(
                    text,
                    "{i} {} {} 0 {} {} 0 0.4 1",
                    0.5 + f64::from(i % 10),
                    0.5 + 1.5 * f64::from(i / 10),
                    (f64::from(i) * time).cos(),
                    (f64::from(i)).sin()
                );
            }
            let file = format!("snapshots/{engine}-{index}.xyz");
            place.write(&file, text.as_bytes()).unwrap();
            manifest.snapshots.push(Snapshot {
                engine: engine.into(),
                replica: 0,
                time,
                file,
                blake3: String::new(),
            });
        }
    }
    place
        .finish(
            manifest,
            &[energy(shift), impact(), fields(), species(), checks()],
        )
        .unwrap();
}

fn run(path: &Path) -> String {
    let runs = vec![RunId::new("", &json!({"seed": 7}), Keys::default(), &[]).unwrap()];
    let folder = Folder::open(path, Existing::Refuse, &[], runs).unwrap();
    write(&folder.places().next().unwrap(), 0.0);
    fs::read_to_string(write_report(path).unwrap()).unwrap()
}

/// Checks that all tags are closed in the right order; scripts and styles hold no tags.
fn balanced(page: &str) {
    let mut open: Vec<&str> = Vec::new();
    let mut rest = page;
    while let Some(at) = rest.find('<') {
        rest = &rest[at + 1..];
        let end = rest.find('>').unwrap();
        let (tag, after) = (&rest[..end], &rest[end + 1..]);
        assert!(!tag.contains('<'), "a tag inside of a tag: {tag}");
        rest = after;
        if let Some(name) = tag.strip_prefix('/') {
            assert_eq!(open.pop(), Some(name), "closed too early");
        } else if !tag.starts_with('!') {
            let name = tag.split_whitespace().next().unwrap();
            if ["meta", "input", "wbr"].contains(&name) {
                continue;
            }
            open.push(name);
            if ["script", "style"].contains(&name) {
                rest = &rest[rest.find(&format!("</{name}>")).unwrap()..];
            }
        }
    }
    assert!(open.is_empty(), "not closed: {open:?}");
}

/// Returns a page without the text of its scripts and of its archive.
fn without_programs(page: &str) -> String {
    let archive = "<script type=\"application/zip;base64\"";
    let page = match page.split_once(archive) {
        Some((first, rest)) => format!("{first}{}", rest.split_once("</script>").unwrap().1),
        None => page.to_owned(),
    };
    let mut parts = page.split("<script>");
    let first = parts.next().unwrap_or_default().to_owned();
    parts.fold(first, |text, part| {
        text + part.split_once("</script>").unwrap().1
    })
}

fn sound(page: &str) {
    balanced(page);
    let page = &without_programs(page);
    for never in [
        "http://", "https://", "NaN", "inf ", "inf<", "\"inf", "<i>chaos", "<b><", "src=",
        "@import", "url(",
    ] {
        assert!(!page.contains(never), "{never}");
    }
    assert!(!page.contains("<script>alert"));
}

#[test]
fn the_page_of_a_run_has_all_that_the_folder_holds() {
    let place = tempfile::tempdir().unwrap();
    let page = run(place.path());
    sound(&page);
    // One chart of energies, three windows, two maps of two engines, and the species.
    assert_eq!(page.matches("class=\"plot\"").count(), 1 + 3 + 4 + 1);
    for figure in [
        "Figure 1. Cooling.",
        "Figure 2. Impact parameter.",
        "Figure 3. Density.",
        "Figure 4. Temperature.",
        "Figure 5. Species.",
    ] {
        let (number, title) = figure.trim_end_matches('.').split_once(". ").unwrap();
        assert!(page.contains(&format!("{number}. {title}.")), "{figure}");
    }
    for word in [
        "✓ agree",
        "≠ differ",
        "? undecided",
        "· note",
        "ED (exact)",
        "DSMC contact point",
        "molecular chaos",
        "theory",
        "window 0 to 1",
        "species small",
        "holds no value that could be drawn",
        "mean free path",
        "Haff's cooling time, 12.5",
        "The start was not in equilibrium",
        "few particles",
        "cells of 1.2 d",
        "Cooling &amp; &lt;i&gt;chaos",
        "id=\"frames\"",
        "energy.csv",
        "fields.csv",
        "480 rows",
        "id=\"viewer\"",
    ] {
        assert!(page.contains(word), "{word}");
    }
    let again = fs::read_to_string(write_report(place.path()).unwrap()).unwrap();
    assert_eq!(page, again);
    // The page includes the library once, with its licence.
    for once in ["var uPlot=", "Permission is hereby granted, free of charge"] {
        assert_eq!(page.matches(once).count(), 1, "{once}");
    }
}

/// Numbers behind the figures of a page.
fn behind(page: &str) -> Vec<serde_json::Value> {
    let parts = page.split("<script type=\"application/json\">").skip(1);
    let texts = parts.map(|part| part.split_once("</script>").unwrap().0);
    texts
        .map(|text| serde_json::from_str(text).unwrap())
        .collect()
}

#[test]
fn figures_hold_the_numbers_behind_them() {
    let place = tempfile::tempdir().unwrap();
    let all = behind(&run(place.path()));
    assert_eq!(all.len(), 5);
    let curves = all[0]["panels"][0]["plot"]["curves"].as_array().unwrap();
    assert_eq!(curves[1]["label"], "ED (exact)");
    let (times, values, theory) = (&curves[1]["x"], &curves[1]["y"], &curves[1]["theory"]);
    assert_eq!(times.as_array().unwrap().len(), 25);
    // The first time is 0.01, and the exact gas follows theory; nine digits are kept.
    let law = 1.01_f64.powi(-2);
    assert!((values[0].as_f64().unwrap() - law).abs() < 5e-10);
    assert_eq!(values[0], theory[0]);
    assert!((curves[1]["error"][0].as_f64().unwrap() - 0.04 * law).abs() < 5e-10);
    assert!(curves[1]["error"][3].is_null());
    // Windows of the impact parameter are side by side, with steps that have two ends.
    let windows = all[1]["panels"].as_array().unwrap();
    assert_eq!(windows.len(), 3);
    assert_eq!(windows[0]["plot"]["curves"][0]["end"][9], 1.0);
    // Of 240 cells one has no density.
    let map = &all[2]["panels"][0]["plot"];
    assert_eq!(map["cells"][2].as_array().unwrap().len(), 239);
    assert_eq!(map["map"], true);
}

#[test]
fn drawings_stand_beside_the_page_and_belong_to_the_run() {
    let place = tempfile::tempdir().unwrap();
    run(place.path());
    let owned = fs::read_to_string(place.path().join("run.files")).unwrap();
    for name in [
        "energy",
        "impact_parameter",
        "fields",
        "fields-2",
        "species",
    ] {
        let name = format!("figures/{name}.svg");
        let text = fs::read_to_string(place.path().join(&name)).unwrap();
        balanced(&text.replace("/>", ">"));
        assert!(!text.contains("var("), "{name}");
        assert!(owned.contains(&name), "{name}");
    }
    // A figure without values has no drawing.
    assert!(!place.path().join("figures/checks.svg").exists());
    let runs = vec![RunId::new("", &json!({"seed": 7}), Keys::default(), &[]).unwrap()];
    Folder::open(place.path(), Existing::Replace, &[], runs).unwrap();
    assert!(!place.path().join("figures/energy.svg").exists());
}

/// Corners of the text of an SVG file that begins with some letters: lowest and highest
/// coordinates of its outlines.
fn extent(path: &str) -> [[f64; 2]; 2] {
    let numbers = path.split(|c: char| c.is_ascii_alphabetic() || c == ' ');
    let numbers: Vec<f64> = numbers
        .filter(|part| !part.is_empty())
        .map(|part| part.parse().unwrap())
        .collect();
    let mut ends = [[f64::INFINITY; 2], [f64::NEG_INFINITY; 2]];
    for pair in numbers.chunks(2) {
        for axis in 0..2 {
            ends[0][axis] = ends[0][axis].min(pair[axis]);
            ends[1][axis] = ends[1][axis].max(pair[axis]);
        }
    }
    ends
}

#[test]
fn figures_for_print_fit_their_width_and_need_nothing() {
    let place = tempfile::tempdir().unwrap();
    run(place.path());
    let figures = print_figures(place.path()).unwrap();
    let names: Vec<&str> = figures.iter().map(PrintFigure::name).collect();
    assert_eq!(
        names,
        [
            "energy",
            "impact_parameter",
            "fields",
            "fields-2",
            "species"
        ]
    );
    let mut heights = Vec::new();
    for figure in &figures {
        for width in COLUMN_WIDTHS.into_iter().chain([60.0, 400.0]) {
            let drawing = figure.draw(width).unwrap();
            let text = drawing.to_svg();
            let file = roxmltree::Document::parse(&text).unwrap();
            let root = file.root_element();
            assert_eq!(root.attribute("width"), Some(&*format!("{width}mm")));
            let view: Vec<f64> = (root.attribute("viewBox").unwrap().split(' '))
                .map(|part| part.parse().unwrap())
                .collect();
            // Two decimals of a point.
            assert!((view[2] * 25.4 / 72.0 - width).abs() < 0.002, "{view:?}");
            for node in root.descendants().filter(roxmltree::Node::is_element) {
                let name = node.tag_name().name();
                assert!(["svg", "title", "rect", "path"].contains(&name), "{name}");
                for attribute in node.attributes() {
                    assert!(!["href", "style", "class", "id"].contains(&attribute.name()));
                    assert!(!attribute.value().contains("url("));
                }
                let Some(path) = node.attribute("d") else {
                    continue;
                };
                // Nothing is cut off: error bars of lines are half a point wide.
                let [low, high] = extent(path);
                let inside = low[0] > -0.5
                    && low[1] > -0.5
                    && high[0] < view[2] + 0.5
                    && high[1] < view[3] + 0.5;
                assert!(
                    inside,
                    "{} at {width} mm: {low:?} {high:?} of {view:?}: {:?}",
                    figure.name(),
                    node.attribute("aria-label")
                );
                if node.attribute("aria-label") == Some("1") {
                    heights.push(high[1] - low[1]);
                }
            }
            let document = drawing.to_pdf();
            assert!(document.starts_with(b"%PDF-1.7"));
            let has = |word: &str| {
                document
                    .windows(word.len())
                    .any(|part| part == word.as_bytes())
            };
            for word in [
                "/FontFile2",
                "/STOSSZ+DejaVuSansCondensed",
                "/ToUnicode",
                "/Identity-H",
            ] {
                assert!(has(word), "{word}");
            }
            assert!(document == figure.draw(width).unwrap().to_pdf());
            assert_eq!(drawing.missing_letters(), "");
        }
    }
    // Digits have 0.73 of the size of the text, 8 points, at any width.
    assert!(heights.len() > 8);
    assert!(
        heights
            .iter()
            .all(|height| (height - 0.729 * 8.0).abs() < 0.03),
        "{heights:?}"
    );
}

#[test]
fn unknown_figures_and_widths_are_refused() {
    let place = tempfile::tempdir().unwrap();
    run(place.path());
    let said = |name: &str| print_figure(place.path(), name).err().unwrap().to_string();
    assert!(
        said("enrgy")
            .contains("(did you mean energy?); its figures are energy, impact_parameter, fields")
    );
    let figure = print_figure(place.path(), "energy").unwrap();
    for width in [59.9, 400.1, 0.0, -86.0, f64::NAN, f64::INFINITY] {
        let error = figure.draw(width).err().unwrap().to_string();
        assert!(error.contains("allowed is 60 to 400 mm"), "{error}");
    }
    assert!(print_figures(&place.path().join("no")).is_err());
}

#[test]
fn figures_of_several_tables_share_a_legend() {
    let (energy, impact) = (energy(0.0), impact());
    let own = &energy.figures[0];
    let windows = &impact.figures[0];
    let text = drawings(
        "all",
        &[("Energy", &energy, own), ("Impacts", &impact, windows)],
    );
    let text = text.unwrap();
    balanced(&text.replace("/>", ">"));
    let times = |words: &str| text.matches(words).count();
    // A curve for each engine, and in the legend once.
    assert_eq!(times("ED (exact)</text>"), 1);
    assert_eq!(times(">Energy</text>"), 1);
    assert_eq!(times(">Impacts window "), 3);
    // Without values there is nothing to draw.
    let empty = Table {
        rows: Vec::new(),
        ..energy.clone()
    };
    let both = [("Energy", &energy, own), ("Nothing", &empty, own)];
    assert_eq!(drawings("none", &both), None);
}

#[test]
fn the_library_is_the_one_that_was_published() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("vendor/uplot");
    for (file, bytes, hash) in LIBRARY {
        let found = fs::read(folder.join(file)).unwrap();
        assert_eq!(found.len(), bytes, "{file}");
        assert_eq!(blake3::hash(&found).to_hex().as_str(), hash, "{file}");
    }
}

#[test]
fn what_is_lost_or_changed_is_said() {
    let place = tempfile::tempdir().unwrap();
    run(place.path());
    fs::remove_file(place.path().join("snapshots/ed-0.xyz")).unwrap();
    let file = place.path().join("energy.csv");
    let text = fs::read_to_string(&file).unwrap();
    fs::write(&file, text.replace(",4\n", ",5\n")).unwrap();
    let page = fs::read_to_string(write_report(place.path()).unwrap()).unwrap();
    assert!(page.contains("The file <code>snapshots/ed-0.xyz</code> is missing."));
    assert!(page.contains("<code>energy.csv</code> is not the file that the run wrote."));
    fs::remove_file(&file).unwrap();
    assert!(
        write_report(place.path())
            .unwrap_err()
            .to_string()
            .contains("energy.csv is missing")
    );
}

#[test]
fn a_folder_without_results_is_an_error() {
    let place = tempfile::tempdir().unwrap();
    let error = write_report(place.path()).unwrap_err();
    assert!(
        error
            .to_string()
            .contains("neither manifest.json nor sweep.json")
    );
}

#[test]
fn the_page_of_a_sweep_compares_its_points() {
    let place = tempfile::tempdir().unwrap();
    // Replicas and measures differ between points too, but are not abscissae.
    let points: Vec<SweepPoint> = [(0.9, 100, 4), (0.8, 100, 8), (0.7, 200, 16), (0.6, 200, 32)]
        .iter()
        .map(|(r, n, replicas)| SweepPoint {
            name: format!("r {r}"),
            values: [
                ("gas.restitution".to_owned(), json!(r)),
                ("measure.frames.number".to_owned(), json!(replicas)),
                ("replicas".to_owned(), json!(replicas)),
                ("species.1.number".to_owned(), json!(n)),
            ]
            .into(),
        })
        .collect();
    let runs = points
        .iter()
        .map(|point| RunId::new(&point.name, &json!(point.values), Keys::default(), &[]).unwrap());
    let folder = Folder::open(place.path(), Existing::Refuse, &[], runs.collect()).unwrap();
    folder
        .write_sweep(&Sweep {
            format: 2,
            title: "A <sweep>".into(),
            case_text: "x".into(),
            points,
        })
        .unwrap();
    for (point, number) in folder.places().zip(0..3) {
        write(&point, f64::from(number));
    }
    let page = fs::read_to_string(write_report(place.path()).unwrap()).unwrap();
    sound(&page);
    for word in [
        "gas.restitution",
        "not finished",
        "./r%200.9/report.html",
        "Cooling, at each point",
        "K(t) / K(0) at the end, against gas.restitution",
        "species.1.number 100",
    ] {
        assert!(page.contains(word), "{word}");
    }
    // Measured against swept quantities come before the list of points.
    let at = |word: &str| page.find(word).unwrap();
    assert!(at("K(t) / K(0) at the end, against gas.restitution") < at("<h2>Points</h2>"));
    // One row per point: the energy at the last time, t = 100, where shift is 2 and the exact gas
    // has (1 + 2 t / 20) over theory.
    let table = fs::read_to_string(place.path().join("sweep.csv")).unwrap();
    let lines: Vec<&str> = table.lines().collect();
    assert_eq!(lines.len(), 5);
    let names: Vec<&str> = lines[0].split(',').collect();
    let column = |name: &str| names.iter().position(|one| *one == name).unwrap();
    let cells: Vec<&str> = lines[3].split(',').collect();
    assert_eq!(cells[column("gas.restitution")], "0.7");
    assert_eq!(cells[column("verdict")], "agree");
    let number = |name: &str| cells[column(name)].parse::<f64>().unwrap();
    let law = number("energy.energy_ratio_theory[ed]");
    assert!((law / 101.0_f64.powi(-2) - 1.0).abs() < 1e-12, "{law}");
    assert!((number("energy.energy_ratio[ed]") / law - 11.0).abs() < 1e-9);
    assert!((number("energy.energy_ratio_se[ed]") / law - 0.04 * 11.0).abs() < 1e-9);
    assert!(lines[4].contains("not finished"));
    // Each figure has a drawing beside the page, as in the report of a run.
    let drawing = |name: &str| fs::read_to_string(place.path().join("figures").join(name)).unwrap();
    assert!(drawing("energy.svg").contains("against gas.restitution"));
    assert!(drawing("energy-at-each-point.svg").contains("at each point"));
    let kinds = page.matches("</span> at ").count();
    assert_eq!(kinds, 1, "three finished points that agree");
    assert!(page.contains(" at 3 points. "));
    assert!(
        place.path().join("r 0.8/report.html").exists()
            && !place.path().join("r 0.6/report.html").exists()
    );
}
