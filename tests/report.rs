//! The report, built from a fabricated results folder.
//!
//! The numbers below are invented: smooth functions with pseudo-random scatter, made to look like a run. Nothing was
//! simulated.

#![allow(
    clippy::unwrap_used,
    reason = "a test that cannot read its own files may stop"
)]

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use stosszahl::case::Kind;
use stosszahl::manifest::{
    EngineWork, Machine, Manifest, Program, ReferenceTime, Snapshot, Start, StartTest, Sweep,
    SweepPoint, TimeDefinition, Units, Verdict, VerdictKind,
};
use stosszahl::report::{ReportError, SIZE_LIMIT, write_report};
use stosszahl::tables::{
    ComparisonRow, DissipationRow, EnergyRow, ImpactParameterRow, ImpactSummaryRow,
    PairCorrelationRow, ReplicaRow, Row, StructureFactorRow,
};
use tempfile::TempDir;

/// How large the fabricated run is.
#[derive(Clone, Copy)]
struct Size {
    particles: usize,
    times: usize,
    windows: u32,
    bins: usize,
    shells: usize,
    snapshots: u32,
    strength: f64,
}

const SMALL: Size = Size {
    particles: 16,
    times: 4,
    windows: 2,
    bins: 5,
    shells: 12,
    snapshots: 2,
    strength: 0.5,
};
const LARGE: Size = Size {
    particles: 2500,
    times: 30,
    windows: 5,
    bins: 20,
    shells: 64,
    snapshots: 4,
    strength: 0.5,
};
const ENGINES: [&str; 3] = ["ed", "dsmc-boltzmann", "dsmc-enskog"];

/// A stream of invented scatter between -1 and 1.
struct Scatter(u64);

impl Scatter {
    fn next(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }
}

fn save<R: Row>(folder: &Path, rows: &[R]) {
    let mut table = csv::Writer::from_path(folder.join(R::FILE)).unwrap();
    for row in rows {
        table.serialize(row).unwrap();
    }
    table.flush().unwrap();
}

/// Writes a fabricated results folder.
fn fabricate(folder: &Path, size: Size, title: &str) {
    fs::create_dir_all(folder.join("snapshots")).unwrap();
    let mut scatter = Scatter(7);
    energies(folder, size, &mut scatter);
    impacts(folder, size, &mut scatter);
    structures(folder, size, &mut scatter);
    let snapshots = particles(folder, size, &mut scatter);
    let manifest = manifest(size, title, snapshots);
    fs::write(
        folder.join("manifest.json"),
        serde_json::to_string_pretty(&manifest).unwrap(),
    )
    .unwrap();
}

/// The invented sample times.
fn times(size: Size) -> Vec<f64> {
    (0..size.times)
        .map(|i| {
            if i == 0 {
                0.0
            } else {
                0.1 * 1000_f64.powf(i as f64 / (size.times - 1) as f64)
            }
        })
        .collect()
}

/// The invented energy ratio.
fn energy(engine: usize, time: f64, strength: f64) -> f64 {
    let lift = strength * (1.0 - (-time / 30.0).exp());
    (1.0 + time).powi(-2) * (1.0 + lift * [2.0, 1.4, 1.6][engine])
}

fn energies(folder: &Path, size: Size, scatter: &mut Scatter) {
    let (mut energies, mut comparisons, mut replicas) = (Vec::new(), Vec::new(), Vec::new());
    for time in times(size) {
        for (place, engine) in ENGINES.iter().enumerate() {
            let width = 0.01 + 0.02 * (1.0 + time).ln() / 4.0;
            let value = energy(place, time, size.strength) * (1.0 + 0.5 * width * scatter.next());
            energies.push(EnergyRow {
                engine: (*engine).to_owned(),
                time: time * 0.043,
                time_over_t0: time,
                collisions_per_particle: 5.5 * (1.0 + time).ln(),
                energy_ratio: value,
                energy_ratio_se: Some(width * value),
                haff_ratio: Some((1.0 + time).powi(-2)),
                fourth_cumulant: -0.02 * (1.0 - (-time).exp())
                    + 0.1 * time / 100.0
                    + 0.004 * scatter.next(),
                fourth_cumulant_se: Some(0.005),
                replicas: 8,
            });
            for replica in 0..2 {
                replicas.push(ReplicaRow {
                    replica,
                    engine: (*engine).to_owned(),
                    time_over_t0: time,
                    energy_ratio: value * (1.0 + 0.01 * scatter.next()),
                    fourth_cumulant: 0.0,
                    collisions_per_particle: 5.5 * (1.0 + time).ln(),
                });
            }
        }
        for (place, engine) in ENGINES.iter().enumerate().skip(1) {
            let [a, b] = [0, place].map(|which| energy(which, time, size.strength));
            let error = 0.02 * a / b;
            let quotient = a / b + 0.5 * error * scatter.next();
            comparisons.push(ComparisonRow {
                engine_a: "ed".to_owned(),
                engine_b: (*engine).to_owned(),
                time_over_t0: time,
                energy_ratio_a: a,
                energy_ratio_b: b,
                quotient,
                quotient_se: Some(error),
                z: Some((quotient - 1.0) / error),
                verdict: if quotient > 1.0 + 3.0 * error {
                    "a higher"
                } else {
                    "agree"
                }
                .to_owned(),
            });
        }
    }
    save(folder, &energies);
    save(folder, &comparisons);
    save(folder, &replicas);
}

fn impacts(folder: &Path, size: Size, scatter: &mut Scatter) {
    let (mut bins, mut summaries, mut dissipations) = (Vec::new(), Vec::new(), Vec::new());
    for (place, engine) in ENGINES.iter().enumerate() {
        for window in 0..size.windows {
            let start = if window == 0 {
                0.0
            } else {
                2.5 * 2_f64.powf(f64::from(window))
            };
            let end = 2.5 * 2_f64.powf(f64::from(window) + 1.0);
            let slope = if place == 0 {
                size.strength * f64::from(window) / f64::from(size.windows)
            } else {
                0.0
            };
            for bin in 0..size.bins {
                let low = bin as f64 / size.bins as f64;
                let high = (bin + 1) as f64 / size.bins as f64;
                bins.push(ImpactParameterRow {
                    engine: (*engine).to_owned(),
                    window_start: start,
                    window_end: end,
                    bin_low: low,
                    bin_high: high,
                    count: 4000,
                    density: 1.0 + slope * (0.5 * (low + high) - 0.5) + 0.015 * scatter.next(),
                    density_se: Some(0.016),
                });
            }
            summaries.push(ImpactSummaryRow {
                engine: (*engine).to_owned(),
                window_start: start,
                window_end: end,
                collisions: 80_000,
                slope: Some(slope + 0.01 * scatter.next()),
                slope_se: Some(0.012),
                mean_b_over_d: Some(0.5 + slope / 12.0),
                chi_squared: Some(19.0 + 900.0 * slope),
                degrees_of_freedom: 19,
                p_value: Some(if slope > 0.05 { 1.3e-9 } else { 0.46 }),
                verdict: if slope > 0.05 {
                    "grazing prevails"
                } else {
                    "uniform"
                }
                .to_owned(),
            });
            dissipations.push(DissipationRow {
                engine: (*engine).to_owned(),
                window_start: start,
                window_end: end,
                collisions: 80_000,
                rate_ratio: Some(1.0 + 0.3 * slope),
                rate_ratio_se: Some(0.004),
                speed_ratio: Some(1.0 - 0.4 * slope),
                speed_ratio_se: Some(0.006),
                impact_ratio: Some(1.0 - slope / 8.0),
                impact_ratio_se: Some(0.002),
                correlation_ratio: Some(1.0 - 0.02 * slope),
                correlation_ratio_se: Some(0.001),
                dissipation_ratio: Some(1.0 - 0.25 * slope),
                dissipation_ratio_se: None,
                replicas: 8,
            });
        }
    }
    save(folder, &bins);
    save(folder, &summaries);
    save(folder, &dissipations);
}

fn structures(folder: &Path, size: Size, scatter: &mut Scatter) {
    let (mut factors, mut pairs) = (Vec::new(), Vec::new());
    for (place, engine) in ENGINES.iter().enumerate() {
        for time in [1.0, 10.0, 100.0] {
            for shell in 1..=size.shells {
                let k = shell as f64;
                let rise = 0.4 * time / (1.0 + (k / 4.0).powi(3));
                let floor = if place == 0 {
                    0.45 + 0.5 * (k / 64.0).min(1.0)
                } else {
                    0.97
                };
                let modes = (6.2 * k) as u64;
                let error = 0.6 / (modes as f64).sqrt();
                factors.push(StructureFactorRow {
                    engine: (*engine).to_owned(),
                    time_over_t0: time,
                    k,
                    structure_factor: (floor + rise) * (1.0 + 0.6 * error * scatter.next()),
                    structure_factor_se: Some((floor + rise) * error),
                    modes,
                });
            }
            for bin in 0..60 {
                let r = 0.05 + 0.1 * f64::from(bin);
                let inside = if place == 0 { 0.0 } else { 1.1 };
                let shell = if place == 0 {
                    1.8 * (-(r - 1.0) * 1.6).exp() * (6.3 * (r - 1.0)).cos()
                } else {
                    0.1
                };
                pairs.push(PairCorrelationRow {
                    engine: (*engine).to_owned(),
                    time_over_t0: time,
                    r_over_d: r,
                    g: if r < 1.0 { inside } else { 1.0 + shell } + 0.01 * scatter.next(),
                    g_se: Some(0.03 / r.max(0.3)),
                });
            }
        }
    }
    save(folder, &factors);
    save(folder, &pairs);
}

fn particles(folder: &Path, size: Size, scatter: &mut Scatter) -> Vec<Snapshot> {
    let side = (size.particles as f64).sqrt().ceil();
    let length = side * 1.772; // packing fraction 0.25 at diameter 1
    let mut snapshots = Vec::new();
    for engine in ENGINES {
        for index in 0..size.snapshots {
            let time = if index == 0 {
                0.0
            } else {
                10_f64.powf(f64::from(index) - 1.0)
            };
            let mut text = format!(
                "{}\nLattice=\"{length} 0 0 0 {length} 0 0 0 1\" Properties=id:I:1:pos:R:3:velo:R:3:radius:R:1 \
                 Time={} TimeOverT0={time} Engine={engine}\n",
                size.particles,
                time * 0.043
            );
            for id in 0..size.particles {
                let cell = |place: usize| (place as f64 + 0.5) * 1.772;
                let x = cell(id % side as usize) + 0.38 * scatter.next();
                let y = cell(id / side as usize) + 0.38 * scatter.next();
                let order = f64::from(index) / f64::from(size.snapshots);
                let turn =
                    order * (6.2 * x / length).sin() * 3.0 + (1.0 - order) * 3.1 * scatter.next();
                let _ = writeln!(text, "{id} {x} {y} 0 {} {} 0 0.5", turn.cos(), turn.sin());
            }
            let file = format!("snapshots/{engine}-{index}.xyz");
            fs::write(folder.join(&file), text).unwrap();
            snapshots.push(Snapshot {
                engine: engine.to_owned(),
                time_over_t0: time,
                file,
            });
        }
    }
    snapshots
}

fn manifest(size: Size, title: &str, snapshots: Vec<Snapshot>) -> Manifest {
    let verdict = |topic: &str, sentence: &str, kind| Verdict {
        topic: topic.to_owned(),
        sentence: sentence.to_owned(),
        kind,
    };
    Manifest {
        format: 1,
        program: Program { name: "stosszahl".to_owned(), version: "0.0.0-fabricated".to_owned() },
        title: title.to_owned(),
        case_text: "# Fabricated numbers, not a simulation.\n[gas]\nparticles = 2500\npacking_fraction = 0.25\nrestitution = 0.8\n".to_owned(),
        case: serde_json::json!({"gas": {"particles": size.particles, "packing_fraction": 0.25, "restitution": 0.8}}),
        units: Units::Si,
        t0: ReferenceTime { seconds_or_units: 0.04303, definition: TimeDefinition::Haff },
        derived: BTreeMap::from([
            ("fourth_cumulant_theory".to_owned(), -0.0179),
            ("mean_free_path".to_owned(), 0.000_893_5),
            ("not_a_number".to_owned(), f64::NAN),
        ]),
        machine: Machine { cores: 2, processor: "invented".to_owned(), system: "invented".to_owned() },
        seed: 42,
        replicas: 8,
        wall_seconds: 321.0,
        start: (0..3)
            .map(|replica| Start {
                replica,
                placement: "square lattice".to_owned(),
                collisions_per_particle: 10.0,
                equilibrated: replica != 1,
                tests: vec![StartTest {
                    name: "Maxwell distribution".to_owned(),
                    statistic: 0.012,
                    p_value: (replica != 2).then_some(0.31),
                    passed: Some(replica != 1),
                    detail: "Kolmogorov-Smirnov distance of the speeds".to_owned(),
                }],
            })
            .collect(),
        engines: ENGINES
            .iter()
            .map(|engine| EngineWork {
                engine: (*engine).to_owned(),
                wall_seconds: 100.0,
                collisions: 1_234_567,
                work: BTreeMap::from([("predictions".to_owned(), 9_876_543.0), ("stale_events".to_owned(), 345_678.0)]),
            })
            .collect(),
        verdicts: vec![
            verdict("Energy", "From t/t₀ = 12 on, ED holds more energy than DSMC Boltzmann (invented).", VerdictKind::Differ),
            verdict("Impact parameter", "P(b/d) of DSMC is uniform in every window (invented).", VerdictKind::Agree),
            verdict("Structure factor", "The error bars are too wide to tell at k = 1 (invented).", VerdictKind::Undecided),
        ],
        warnings: vec!["the numbers of this folder are invented".to_owned()],
        snapshots,
    }
}

/// A folder with fabricated results, and the page that is built from it.
fn built() -> (TempDir, String) {
    let folder = TempDir::new().unwrap();
    fabricate(folder.path(), SMALL, "Fabricated results");
    let page = rebuild(folder.path()).unwrap();
    (folder, page)
}

fn rebuild(folder: &Path) -> Result<String, ReportError> {
    let file = write_report(folder)?;
    assert_eq!(file, folder.join("report.html"));
    Ok(fs::read_to_string(file).unwrap())
}

#[test]
fn the_page_holds_every_section() {
    let (_folder, page) = built();
    for text in [
        "<h1>Fabricated results</h1>",
        "N = 16 hard disks with packing fraction 0.25 and restitution coefficient 0.8",
        "ED holds more energy",
        "not in equilibrium",
        "K(t) / K(0)",
        "quotient of K",
        "P(b/d)",
        "S(k)",
        "g(r)",
        "a₂",
        "id=\"frames\"",
        "Comparison of the engines",
        "Dissipation identity",
        "stale events",
        "Maxwell distribution",
        "mean free path",
        "# Fabricated numbers, not a simulation.",
        "How to cite",
        "seed 42",
    ] {
        assert!(page.contains(text), "the page lacks {text:?}");
    }
    for number in 1..=7 {
        assert!(
            page.contains(&format!("Figure {number}. ")),
            "figure {number} is missing"
        );
    }
    assert!(
        !page.contains("NaN"),
        "a value that is not a number reached the page"
    );
    let (box_start, verdict) = (
        page.find("class=\"warnings\"").unwrap(),
        page.find("id=\"plots\"").unwrap(),
    );
    assert!(box_start < verdict, "warnings stand above the plots");
    let [start, other] = ["not in equilibrium", "numbers of this folder are invented"]
        .map(|text| page.find(text).unwrap());
    assert!(start < other, "the start comes first among the warnings");
}

#[test]
fn the_page_loads_nothing() {
    let (_folder, page) = built();
    for text in [
        "http:", "https:", "url(//", "src=", "@import", "<link", "fetch(",
    ] {
        assert!(!page.contains(text), "the page contains {text:?}");
    }
}

#[test]
fn the_same_folder_gives_the_same_bytes() {
    let (folder, page) = built();
    assert_eq!(rebuild(folder.path()).unwrap(), page);
    let names: Vec<_> = fs::read_dir(folder.path())
        .unwrap()
        .map(|f| f.unwrap().file_name())
        .collect();
    assert!(
        names
            .iter()
            .all(|name| !name.to_string_lossy().ends_with(".part"))
    );
}

#[test]
fn a_damaged_number_names_file_line_and_column() {
    let (folder, _page) = built();
    let file = folder.path().join("energy.csv");
    let mut lines: Vec<String> = fs::read_to_string(&file)
        .unwrap()
        .lines()
        .map(str::to_owned)
        .collect();
    lines[4] = "ed,1.0,one,0.0,1.0,,,0.0,,8".to_owned();
    fs::write(&file, lines.join("\n")).unwrap();
    let fault = rebuild(folder.path()).unwrap_err();
    assert!(
        fault
            .to_string()
            .contains("energy.csv, line 5, column time_over_t0"),
        "{fault}"
    );
    match fault {
        ReportError::Cell {
            file: named,
            line: 5,
            column,
            found,
            expected,
        } => {
            assert_eq!(named, file);
            assert_eq!((column.as_str(), found.as_str()), ("time_over_t0", "one"));
            assert_eq!(expected, "a number");
        }
        other => panic!("{other:?}"),
    }
}

#[test]
fn other_damage_is_a_typed_error_too() {
    let (folder, _page) = built();
    let at = |name: &str| folder.path().join(name);
    let healthy = fs::read(at("comparison.csv")).unwrap();

    fs::write(at("comparison.csv"), "engine_a,engine_b\n").unwrap();
    assert!(
        matches!(rebuild(folder.path()), Err(ReportError::Columns { found, expected, .. })
        if found.len() == 2 && expected.len() == 9)
    );
    let cut = [healthy.as_slice(), b"ed,dsmc-enskog\n"].concat();
    fs::write(at("comparison.csv"), cut).unwrap();
    assert!(matches!(
        rebuild(folder.path()),
        Err(ReportError::Length {
            line: 10,
            found: 2,
            expected: 9,
            ..
        })
    ));
    fs::write(
        at("comparison.csv"),
        [healthy.as_slice(), b"\xff,,,,,,,,\n"].concat(),
    )
    .unwrap();
    assert!(matches!(
        rebuild(folder.path()),
        Err(ReportError::Encoding { line: 10, .. })
    ));
    fs::write(at("comparison.csv"), &healthy).unwrap();

    let snapshot = fs::read_to_string(at("snapshots/ed-1.xyz")).unwrap();
    let short: Vec<&str> = snapshot.lines().take(9).collect();
    fs::write(at("snapshots/ed-1.xyz"), short.join("\n")).unwrap();
    assert!(matches!(
        rebuild(folder.path()),
        Err(ReportError::Snapshot { line: 9, .. })
    ));
    fs::write(
        at("snapshots/ed-1.xyz"),
        snapshot.replacen("Lattice", "Lettuce", 1),
    )
    .unwrap();
    assert!(matches!(
        rebuild(folder.path()),
        Err(ReportError::Snapshot { line: 2, .. })
    ));
    fs::write(at("snapshots/ed-1.xyz"), &snapshot).unwrap();

    let manifest = fs::read_to_string(at("manifest.json")).unwrap();
    fs::write(
        at("manifest.json"),
        manifest.replace("\"seed\": 42", "\"seed\": \"many\""),
    )
    .unwrap();
    assert!(
        matches!(rebuild(folder.path()), Err(ReportError::Json { key, line, .. }) if key == "seed" && line > 1)
    );
    fs::write(at("manifest.json"), "{\"format\": 9, \"other\": 1}").unwrap();
    assert!(matches!(
        rebuild(folder.path()),
        Err(ReportError::Format {
            found: 9,
            expected: 1,
            ..
        })
    ));
    fs::remove_file(at("manifest.json")).unwrap();
    assert!(matches!(
        rebuild(folder.path()),
        Err(ReportError::NoResults { .. })
    ));
}

#[test]
fn a_missing_table_leaves_a_note() {
    let tables = [
        "energy.csv",
        "comparison.csv",
        "impact_parameter.csv",
        "impact_parameter_summary.csv",
        "structure_factor.csv",
        "pair_correlation.csv",
        "dissipation.csv",
        "replicas.csv",
    ];
    let (folder, _page) = built();
    for name in tables {
        fs::remove_file(folder.path().join(name)).unwrap();
    }
    fs::remove_file(folder.path().join("snapshots/ed-0.xyz")).unwrap();
    let page = rebuild(folder.path()).unwrap();
    for name in tables {
        let note = format!("<code>{name}</code> was not found");
        assert!(page.contains(&note), "no note on {name}");
    }
    assert!(page.contains("<code>snapshots/ed-0.xyz</code> is named in the manifest"));
    assert!(page.contains("How to cite"), "the rest is still built");
}

#[test]
fn tables_without_rows_leave_a_note() {
    let (folder, _page) = built();
    fs::write(
        folder.path().join("energy.csv"),
        EnergyRow::COLUMNS.join(",") + "\n",
    )
    .unwrap();
    let page = rebuild(folder.path()).unwrap();
    assert!(page.contains("<code>energy.csv</code> holds no rows"));
}

#[test]
fn a_title_is_text() {
    let folder = TempDir::new().unwrap();
    fabricate(folder.path(), SMALL, "<script>alert(1)</script> & more");
    let page = rebuild(folder.path()).unwrap();
    assert!(!page.contains("<script>alert"));
    assert!(page.contains("&lt;script&gt;alert(1)&lt;/script&gt; &amp; more"));
}

#[test]
fn values_without_a_place_do_not_reach_the_plots() {
    let (folder, _page) = built();
    let file = folder.path().join("energy.csv");
    let mut table = fs::read_to_string(&file).unwrap();
    table.push_str("ed,1.0,50.0,0.0,NaN,inf,,NaN,,8\ned,1.0,inf,0.0,-1.0,,,inf,,8\n");
    table.push_str(
        "ed,1.0,1e300,0.0,1e300,1e300,,1e300,,8\ned,1.0,1e-300,0.0,1e-300,,,-1e300,1e308,8\n",
    );
    fs::write(&file, table).unwrap();
    fs::write(
        folder.path().join("snapshots/ed-0.xyz"),
        format!("{}\n", u64::MAX),
    )
    .unwrap();
    let page = rebuild(folder.path()).unwrap();
    assert!(!page.contains("NaN") && !page.contains("\"inf"));
    assert!(page.contains("Shown are 1 of 2 times") || page.contains("would exceed"));
}

#[test]
fn fewer_snapshots_are_kept_above_the_size_limit() {
    let (folder, _page) = built();
    let size = Size {
        particles: 200_000,
        snapshots: 4,
        ..SMALL
    };
    particles(folder.path(), size, &mut Scatter(1));
    let manifest = folder.path().join("manifest.json");
    let mut read: Manifest = serde_json::from_slice(&fs::read(&manifest).unwrap()).unwrap();
    read.snapshots = particles(folder.path(), size, &mut Scatter(1));
    fs::write(&manifest, serde_json::to_string(&read).unwrap()).unwrap();
    let page = rebuild(folder.path()).unwrap();
    assert!(page.len() <= SIZE_LIMIT, "{} bytes", page.len());
    assert!(
        page.contains("Shown are 2 of 4 times"),
        "the page says what it left out"
    );
}

/// Writes a fabricated sweep over the restitution coefficient at two packing fractions.
fn fabricate_sweep(folder: &Path, size: Size) {
    let mut points = Vec::new();
    for packing in [0.1, 0.25] {
        for restitution in [0.6, 0.8, 0.95] {
            let name = format!("nu {packing} r {restitution}");
            let size = Size {
                strength: 4.0 * packing * (1.0 - restitution),
                ..size
            };
            if (packing, restitution) != (0.1, 0.95) {
                fabricate(
                    &folder.join("points").join(&name),
                    size,
                    &format!("Fabricated {name}"),
                );
            }
            points.push(SweepPoint {
                folder: format!("points/{name}"),
                name,
                values: BTreeMap::from([
                    ("gas.packing_fraction".to_owned(), packing.into()),
                    ("gas.restitution".to_owned(), restitution.into()),
                ]),
            });
        }
    }
    let sweep = Sweep {
        kind: Kind::Paired,
        title: "Fabricated sweep".to_owned(),
        case_text: "# invented".to_owned(),
        points,
    };
    fs::write(
        folder.join("sweep.json"),
        serde_json::to_string(&sweep).unwrap(),
    )
    .unwrap();
}

#[test]
fn a_sweep_has_an_index() {
    let folder = TempDir::new().unwrap();
    fabricate_sweep(folder.path(), SMALL);
    let page = rebuild(folder.path()).unwrap();
    for text in [
        "A sweep of 6 points, of which 5 are finished",
        "href=\"./points/nu%200.25%20r%200.8/report.html\"",
        "Sweep of gas.restitution at gas.packing_fraction = 0.25",
        "Sweep of gas.packing_fraction at gas.restitution = 0.6",
        "slope of P(b/d)",
        "Impact parameter of all points",
        "not finished",
    ] {
        assert!(page.contains(text), "the page lacks {text:?}");
    }
    assert!(
        folder
            .path()
            .join("points/nu 0.25 r 0.8/report.html")
            .exists()
    );
    assert_eq!(rebuild(folder.path()).unwrap(), page);
}

/// Writes large fabricated pages for looking at: `cargo test --test report -- --ignored`.
#[test]
#[ignore = "writes pages to be looked at, and asserts nothing"]
fn pages_to_look_at() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("report");
    fabricate(
        &folder.join("run"),
        LARGE,
        "Fabricated results, made to look at the page",
    );
    write_report(&folder.join("run")).unwrap();
    fabricate_sweep(
        &folder.join("sweep"),
        Size {
            particles: 400,
            ..LARGE
        },
    );
    write_report(&folder.join("sweep")).unwrap();
}
