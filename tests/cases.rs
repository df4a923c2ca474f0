//! The cases that come with the program, the schema, overrides, sweeps and defaults.

#[allow(dead_code, unused_imports, reason = "only the good case is used here")]
mod support;

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use rand::{RngExt, SeedableRng, rngs::Xoshiro256PlusPlus};
use stosszahl::case::{
    Assignment, Bodies, Case, CaseError, CaseFile, Displacement, Engine, Kind, Neighbourhood,
    Restitution, Scheme, Units, Velocities, Warning, schema,
};
use stosszahl::setup::Setup;
use support::bad_cases::GOOD;

/// The cases of the kind that is tested here.
fn case_files() -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("cases");
    let mut files: Vec<PathBuf> = fs::read_dir(folder)
        .expect("the folder of cases")
        .map(|entry| entry.expect("a case").path())
        .filter(|path| Kind::of_file(path).expect("a case has a kind") == Kind::Paired)
        .collect();
    files.sort();
    assert!(files.len() >= 5);
    files
}

fn read(name: &str, overrides: &[&str]) -> Result<CaseFile, CaseError> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("cases")
        .join(name);
    let overrides: Vec<String> = overrides.iter().map(ToString::to_string).collect();
    Case::read(path, &overrides)
}

fn from_text(text: &str, overrides: &[&str]) -> Result<CaseFile, CaseError> {
    let overrides: Vec<String> = overrides.iter().map(ToString::to_string).collect();
    CaseFile::from_text(Path::new("test.toml"), text, &overrides)
}

fn one(file: CaseFile) -> Case {
    let [point] = <[_; 1]>::try_from(file.points).expect("one point");
    assert!(point.settings.is_empty() && point.name.is_empty());
    point.case
}

#[test]
fn every_case_is_valid_and_asks_a_question() {
    for path in case_files() {
        assert_eq!(
            path.extension().and_then(|ending| ending.to_str()),
            Some("toml")
        );
        let file = Case::read(&path, &[]).unwrap_or_else(|error| panic!("{error}"));
        let first = file.source_text.lines().next().unwrap_or_default();
        assert!(
            first.starts_with("# ") && first.ends_with('?'),
            "{}: {first}",
            path.display()
        );
        for point in &file.points {
            assert_eq!(
                point.case.warnings(),
                [],
                "{} {}",
                path.display(),
                point.name
            );
            let times = point.case.sample_times();
            assert_eq!(times.first(), Some(&0.0));
            assert_eq!(times.last(), Some(&point.case.run.until));
            assert!(times.is_sorted_by(|earlier, later| earlier < later));
        }
    }
}

#[test]
fn luding_1998_is_as_published() {
    let case = one(read("luding-1998.toml", &[]).expect("the case is valid"));
    assert_eq!(case.units, Units::Si);
    assert_eq!(
        case.start.bodies,
        Bodies::Disordered {
            disks: 99856,
            packing_fraction: 0.25
        }
    );
    assert_eq!(case.gas.restitution, Restitution::Constant(0.8));
    // kT = m v^2/2.
    let temperature = case.temperature().expect("a Maxwellian start");
    assert!((temperature / (0.5e-6 * 0.2047 * 0.2047) - 1.0).abs() < 1e-15);
    assert_eq!(case.start.most_collisions_per_particle, 200.0);
    assert_eq!(
        case.engines.iter().map(Engine::name).collect::<Vec<_>>(),
        ["ed", "dsmc-free-volume", "dsmc-enskog"]
    );
    assert_eq!(
        case.measure.structure.assignment,
        Assignment::NearestGridPoint
    );
    assert!(!case.measure.structure.correction);
    let written = case.measure.impact_windows.clone();
    let quick = one(read("quick.toml", &["run.until=400"]).expect("the case is valid"));
    assert_eq!(
        quick.measure.impact_windows, written,
        "the published windows are the default ones"
    );
}

#[test]
fn dense_240_sweeps_density_and_dissipation() {
    let file = read("dense-240.toml", &[]).expect("the case is valid");
    assert_eq!(file.points.len(), 8 + 3);
    assert_eq!(
        file.points[3].name,
        "aspect_ratio=1,packing_fraction=0.25,restitution=1,until=120"
    );
    for point in &file.points {
        let case = &point.case;
        let Restitution::Constant(restitution) = case.gas.restitution else {
            panic!("constant restitution");
        };
        let per_particle = if restitution == 1.0 {
            case.run.until
        } else {
            4.0 / (1.0 - restitution * restitution) * (1.0 + case.run.until).ln()
        };
        let collisions = per_particle * 240.0 / 2.0 * case.replicas as f64;
        assert!(
            (1e5..1.3e5).contains(&collisions),
            "{}: {collisions}",
            point.name
        );
        assert_eq!(case.measure.impact_windows, [[0.0, case.run.until]]);
    }
}

#[test]
fn defaults_are_as_documented() {
    let text = "format = 1\ntitle = \"t\"\n[gas]\ndisks = 9\npacking_fraction = 0.1\nrestitution = 1\n\
                [run]\nuntil = 30\n[engine.ed]\n";
    let case = one(from_text(text, &[]).expect("a short case"));
    assert_eq!(
        (case.units, case.seed, case.replicas),
        (Units::Reduced, 1, 4)
    );
    assert_eq!(
        (case.gas.diameter, case.gas.mass, case.domain.aspect_ratio),
        (1.0, 1.0, 1.0)
    );
    assert_eq!(
        case.start.velocities,
        Velocities::Maxwellian { temperature: 1.0 }
    );
    assert_eq!(case.start.collisions_per_particle, 10.0);
    assert_eq!(case.start.most_collisions_per_particle, 200.0);
    assert_eq!(
        (case.run.first_sample, case.run.samples_per_decade),
        (0.03, 12)
    );
    assert_eq!(case.run.checkpoint_seconds, 30.0);
    assert_eq!(
        case.measure.impact_windows,
        [[0.0, 1.0], [1.0, 5.0], [5.0, 20.0], [20.0, 30.0]]
    );
    assert_eq!(
        (
            case.measure.impact_bins,
            case.measure.structure.largest_wave_number
        ),
        (20, 64)
    );
    assert_eq!(case.measure.structure.times, [0.0, 30.0]);
    assert_eq!(case.measure.structure.assignment, Assignment::CloudInCell);
    assert!(case.measure.structure.correction);
    assert_eq!(case.measure.pair_correlation_range, 6.0);
    assert_eq!(case.measure.snapshot_times, [30.0]);
    assert_eq!(case.verdict.false_alarm, 0.01);
    let [Engine::Ed(ed)] = &case.engines[..] else {
        panic!("one engine");
    };
    assert_eq!((ed.contact_time, ed.collision_limit), (0.0, None));
}

#[test]
fn defaults_of_the_monte_carlo_engines_are_as_documented() {
    let text = "format = 1\ntitle = \"t\"\n[gas]\ndisks = 9\npacking_fraction = 0.1\nrestitution = 1\n\
                [run]\nuntil = 30\n[engine.dsmc-boltzmann]\n[engine.dsmc-free-volume]\n[engine.dsmc-enskog]\n\
                [engine.dsmc-esmc]\n[engine.dsmc-stochastic-disks]\n[engine.dsmc-contact-point]\n";
    let case = one(from_text(text, &[]).expect("a short case"));
    let [
        Engine::Dsmc(boltzmann),
        Engine::Dsmc(free_volume),
        Engine::Dsmc(enskog),
        Engine::Dsmc(esmc),
        Engine::Dsmc(stochastic_disks),
        Engine::Dsmc(contact_point),
    ] = &case.engines[..]
    else {
        panic!("six engines, in this order");
    };
    for dsmc in [boltzmann, free_volume, enskog] {
        assert_eq!(
            (
                dsmc.cell_size,
                dsmc.simulators_per_disk,
                dsmc.steps_per_crossing
            ),
            (None, Some(1), 4.0)
        );
    }
    assert_eq!(
        [boltzmann.scheme, free_volume.scheme, enskog.scheme],
        [
            Scheme::Boltzmann {
                displacement: Displacement::None
            },
            Scheme::FreeVolume {
                displacement: Displacement::Diameter,
                largest: 10.0
            },
            Scheme::Enskog {
                displacement: Displacement::Diameter,
                neighbourhood: Neighbourhood::Cells(2),
                largest: 10.0
            }
        ]
    );
    for dsmc in [esmc, stochastic_disks] {
        assert_eq!(dsmc.simulators_per_disk, Some(1));
    }
    assert_eq!(
        stochastic_disks.scheme,
        Scheme::StochasticDisks { stiffness: 1.0 }
    );
    // What suits the gas is chosen when the gas is known.
    assert_eq!(
        (
            contact_point.scheme,
            contact_point.simulators_per_disk,
            contact_point.steps_per_crossing
        ),
        (
            Scheme::ContactPoint {
                partner_radius: None,
                copies: None,
                largest: 100.0
            },
            None,
            8.0
        )
    );
}

/// All keys of a part of the schema, dotted.
fn keys(schema: &serde_json::Value, prefix: &str, found: &mut BTreeSet<String>) {
    for (key, inner) in schema["properties"].as_object().into_iter().flatten() {
        let name = format!("{prefix}{key}");
        keys(inner, &format!("{name}."), found);
        found.insert(name);
    }
    for choice in schema["anyOf"].as_array().into_iter().flatten() {
        keys(choice, prefix, found);
    }
}

/// The keys of the Monte Carlo engines with partners across cells.
const ACROSS: [(&str, &[&str]); 3] = [
    (
        "engine.dsmc-esmc.",
        &[
            "cell_size",
            "simulators_per_disk",
            "steps_per_mean_free_time",
            "neighbourhood",
            "largest_contact_value",
        ],
    ),
    (
        "engine.dsmc-stochastic-disks.",
        &[
            "stiffness",
            "simulators_per_disk",
            "steps_per_mean_free_time",
        ],
    ),
    (
        "engine.dsmc-contact-point.",
        &[
            "partner_radius",
            "cell_size",
            "simulators_per_disk",
            "copies",
            "steps_per_mean_free_time",
            "largest_contact_value",
        ],
    ),
];

#[test]
fn the_schema_has_every_key_and_a_description_for_each() {
    let mut found = BTreeSet::new();
    keys(&schema(), "", &mut found);
    let dsmc = [
        "displacement",
        "cell_size",
        "simulators_per_disk",
        "steps_per_crossing",
    ];
    let tables: [(&str, &[&str]); 15] = [
        (
            "",
            &[
                "format", "kind", "title", "units", "seed", "replicas", "gas", "box", "start",
                "run", "drive", "engine", "measure", "verdict", "accuracy", "sweep",
            ],
        ),
        ("accuracy.", &["target"]),
        ("drive.", &["heating", "interval"]),
        (
            "gas.",
            &[
                "disks",
                "packing_fraction",
                "restitution",
                "diameter",
                "mass",
                "temperature",
                "rms_speed",
                "species",
            ],
        ),
        ("gas.restitution.", &["viscoelastic"]),
        ("box.", &["aspect_ratio", "boundary"]),
        (
            "start.",
            &[
                "placement",
                "file",
                "velocities",
                "collisions_per_particle",
                "most_collisions_per_particle",
            ],
        ),
        (
            "run.",
            &[
                "until",
                "first_sample",
                "samples_per_decade",
                "checkpoint_seconds",
            ],
        ),
        (
            "engine.",
            &[
                "ed",
                "dsmc-boltzmann",
                "dsmc-free-volume",
                "dsmc-enskog",
                "dsmc-esmc",
                "dsmc-stochastic-disks",
                "dsmc-contact-point",
            ],
        ),
        ("engine.ed.", &["contact_time", "collision_limit"]),
        ("engine.dsmc-boltzmann.", &[]),
        ("engine.dsmc-free-volume.", &["largest_contact_value"]),
        (
            "engine.dsmc-enskog.",
            &["neighbourhood", "largest_contact_value"],
        ),
        (
            "measure.",
            &[
                "impact_windows",
                "impact_bins",
                "structure_times",
                "structure_assignment",
                "structure_correction",
                "largest_wave_number",
                "pair_correlation_range",
                "snapshot_times",
                "mean_squared_displacement",
                "displacement_start",
            ],
        ),
        ("verdict.", &["false_alarm"]),
    ];
    let mut documented: BTreeSet<String> = BTreeSet::new();
    for (table, keys) in tables.into_iter().chain(ACROSS) {
        documented.extend(keys.iter().map(|key| format!("{table}{key}")));
        let within_cells = ["boltzmann", "free-volume", "enskog"];
        if within_cells
            .iter()
            .any(|name| table == format!("engine.dsmc-{name}."))
        {
            documented.extend(dsmc.iter().map(|key| format!("{table}{key}")));
        }
    }
    assert_eq!(found, documented);
}

#[test]
fn the_schema_has_types_ranges_and_defaults() {
    let schema = schema();
    let packing = &schema["properties"]["gas"]["properties"]["packing_fraction"];
    assert_eq!(packing["type"], "number");
    assert_eq!(packing["maximum"], 0.9069);
    assert_eq!(packing["exclusiveMinimum"], 0.0);
    assert!(
        packing["description"]
            .as_str()
            .is_some_and(|text| text.contains("area"))
    );
    assert_eq!(
        schema["properties"]["measure"]["properties"]["impact_bins"]["default"],
        20
    );
    assert_eq!(schema["additionalProperties"], false);
    assert!(!schema.to_string().contains("\"null\""), "TOML has no null");
}

#[test]
fn every_key_has_a_sentence_on_what_is_allowed() {
    fn check(schema: &serde_json::Value, path: &str) {
        for (key, inner) in schema["properties"].as_object().into_iter().flatten() {
            let path = format!("{path}.{key}");
            let table = inner["properties"].is_object()
                || inner["anyOf"]
                    .as_array()
                    .is_some_and(|list| list.iter().any(|one| one["properties"].is_object()));
            assert!(table || inner["x-allowed"].is_string(), "{path} {inner}");
            assert!(inner["description"].is_string(), "{path}");
            check(inner, &path);
        }
    }
    check(&schema(), "");
}

#[test]
fn displacements_are_measured_at_rising_times_after_their_start() {
    let times = |overrides: &[&str]| {
        let mut all = vec!["measure.mean_squared_displacement=true"];
        all.extend(overrides);
        one(from_text(GOOD, &all).expect("a valid case")).displacement_times()
    };
    let case = one(from_text(GOOD, &[]).expect("a valid case"));
    assert!(case.displacement_times().is_empty());
    // From the start, the samples but for the first; later, the same grid from there.
    let plain: Vec<f64> = times(&[]).iter().map(|moment| moment.0).collect();
    assert_eq!(plain, case.sample_times()[1..]);
    let late = times(&["measure.displacement_start=10"]);
    assert_eq!(late[0], (10.1, 0.1));
    assert_eq!(late.last(), Some(&(40.0, 30.0)));
    // A grid finer than the rounding of a late start loses its first times.
    let fine = times(&[
        "run.until=1e9",
        "run.first_sample=1e-9",
        "measure.displacement_start=999999999",
    ]);
    assert!(fine.is_sorted_by(|a, b| a.0 < b.0));
    assert!(fine[0].0 > 999_999_999.0 && fine.len() < 9 * 12);
}

#[test]
fn overrides_replace_what_is_written() {
    let case = one(from_text(
        GOOD,
        &[
            "gas.restitution=0.9",
            "engine.ed.contact_time=1e-4",
            "replicas=2",
            "seed=11",
            "engine.dsmc-enskog.neighbourhood=mean",
            "start.placement=hexagonal",
            "engine.dsmc-boltzmann.displacement=true",
            "title=another title",
            "run.until=50",
            "run.until=30",
        ],
    )
    .expect("the overrides are valid"));
    assert_eq!(case.gas.restitution, Restitution::Constant(0.9));
    assert_eq!((case.replicas, case.seed, case.run.until), (2, 11, 30.0));
    assert_eq!(case.title, "another title");
    assert!(matches!(
        case.start.bodies,
        Bodies::Hexagonal { disks: 100, .. }
    ));
    assert!(matches!(case.engines[0], Engine::Ed(ed) if ed.contact_time == 1e-4));
    assert_eq!(case.engines[1].name(), "dsmc-boltzmann");
    assert!(matches!(
        case.engines[2],
        Engine::Dsmc(dsmc) if matches!(dsmc.scheme, Scheme::Enskog { neighbourhood: Neighbourhood::Mean, .. })
    ));
    let case = one(from_text(GOOD, &["gas.restitution.viscoelastic=0.3"]).expect("a law"));
    assert_eq!(
        case.gas.restitution,
        Restitution::Viscoelastic { dissipation: 0.3 }
    );
}

#[test]
fn sweeps_are_products_without_duplicates() {
    let sweep = "[[sweep]]\n\"gas.packing_fraction\" = [0.01, 0.25]\n\"gas.restitution\" = [1.0, { viscoelastic = 0.3 }]\n\
                 [[sweep]]\n\"gas.packing_fraction\" = [0.25, 0.5]\n\"gas.restitution\" = [1]\n";
    let file = from_text(&format!("{GOOD}{sweep}"), &[]).expect("a sweep");
    let names: Vec<&str> = file
        .points
        .iter()
        .map(|point| point.name.as_str())
        .collect();
    assert_eq!(
        names,
        [
            "packing_fraction=0.01,restitution=1",
            "packing_fraction=0.01,restitution=viscoelastic_0.3",
            "packing_fraction=0.25,restitution=1",
            "packing_fraction=0.25,restitution=viscoelastic_0.3",
            "packing_fraction=0.5,restitution=1",
        ]
    );
    assert_eq!(file.points[2].case.packing_fraction(), Some(0.25));
    assert_eq!(file.points[2].settings[1].key, "gas.restitution");

    let fixed = from_text(&format!("{GOOD}{sweep}"), &["gas.restitution=1"]).expect("a sweep");
    let names: Vec<&str> = fixed
        .points
        .iter()
        .map(|point| point.name.as_str())
        .collect();
    assert_eq!(
        names,
        [
            "packing_fraction=0.01",
            "packing_fraction=0.25",
            "packing_fraction=0.5"
        ]
    );
}

#[test]
fn names_of_points_are_safe_and_different() {
    let sweep = "[[sweep]]\n\"title\" = [\"a/b\", \"a:b\", \"../A_B\", \"\\u0000\"]\n\
                 \"engine.ed.contact_time\" = [1e-9]\n\
                 [[sweep]]\n\"engine.dsmc-enskog.cell_size\" = [2, 4]\n\"engine.dsmc-free-volume.cell_size\" = [3]\n";
    let file = from_text(&format!("{GOOD}{sweep}"), &[]).expect("a sweep");
    let names: BTreeSet<String> = file
        .points
        .iter()
        .map(|point| point.name.to_lowercase())
        .collect();
    assert_eq!(names.len(), file.points.len());
    for name in &names {
        assert!(
            name.len() < 200 && !name.contains(['/', '\\', ':', '\0']),
            "{name}"
        );
    }
    assert!(names.contains("engine.dsmc-enskog.cell_size=2,engine.dsmc-free-volume.cell_size=3"));
}

#[test]
fn suspicious_cases_are_valid_with_a_warning() {
    let warnings =
        |overrides: &[&str]| one(from_text(GOOD, overrides).expect("a valid case")).warnings();
    assert_eq!(warnings(&["replicas=1"]), [Warning::SingleReplica]);
    assert_eq!(
        warnings(&["start.placement=square", "start.collisions_per_particle=0"]),
        [Warning::LatticeStart]
    );
    let dense = warnings(&[
        "gas.packing_fraction=0.5",
        "engine.dsmc-enskog.cell_size=0.5",
        "start.collisions_per_particle=0",
    ]);
    assert_eq!(dense, [Warning::LatticeStart]);
    assert_eq!(warnings(&["gas.disks=4"]), [Warning::FewDisks { disks: 4 }]);
    // What depends on the cells that the engine chooses is known to the setup.
    let setup = |overrides: &[&str]| {
        let case = one(from_text(GOOD, overrides).expect("a valid case"));
        Setup::new(&case).expect("a start").warnings().join("; ")
    };
    let wide = setup(&["engine.dsmc-enskog.cell_size=7"]);
    assert!(
        wide.contains("dsmc-enskog: cells are 12.6 mean free paths wide"),
        "{wide}"
    );
    let few = setup(&["engine.dsmc-enskog.cell_size=2"]);
    assert!(
        few.contains("dsmc-enskog: 1.") && few.contains("simulators per cell"),
        "{few}"
    );
    let driven = |heating: f64, interval: f64, others: &[&str]| {
        let (heating, interval) = (
            format!("drive.heating={heating}"),
            format!("drive.interval={interval}"),
        );
        let all: Vec<&str> = [heating.as_str(), interval.as_str()]
            .iter()
            .chain(others)
            .copied()
            .collect();
        setup(&all)
    };
    assert!(!driven(2.0, 0.01, &[]).contains("drive:"));
    let endless = driven(2.0, 0.01, &["gas.restitution=1"]);
    assert!(endless.contains("heats up without end"), "{endless}");
    let coarse = driven(2.0, 0.2, &[]);
    assert!(
        coarse.contains("each kick adds 0.40 of the steady temperature"),
        "{coarse}"
    );
    // The relaxation time is 1/(3 sqrt(T)) and T = (h/2)^(2/3), so 40 t0 are 12 of them at h = 2e-3.
    let short = driven(2e-3, 0.1, &[]);
    assert!(
        short.contains("run.until is 12.0 times the relaxation time"),
        "{short}"
    );
    let refined = setup(&[
        "engine.dsmc-enskog.cell_size=1",
        "engine.dsmc-enskog.simulators_per_disk=32",
    ]);
    assert!(!refined.contains("dsmc-enskog"), "{refined}");
}

#[test]
fn a_start_file_is_found_beside_the_case() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("case.toml");
    fs::write(folder.path().join("start.csv"), "x,y\n").expect("a start file");
    let text = "format = 1\ntitle = \"t\"\nreplicas = 1\n[gas]\nrestitution = 1\n[start]\nplacement = \"file\"\nfile = \"start.csv\"\n\
                velocities = \"file\"\n[run]\nuntil = 1\n[engine.ed]\n";
    fs::write(&path, text).expect("a case");
    let case = one(Case::read(&path, &[]).expect("a case with a start file"));
    let Bodies::File(file) = &case.start.bodies else {
        panic!("a start file");
    };
    assert_eq!(file.path, folder.path().join("start.csv"));
    assert_eq!((case.disks(), case.temperature()), (None, None));
    // The serialised case is the same wherever the folder is.
    let folder_name = folder.path().display().to_string();
    assert!(
        !serde_json::to_string(&case)
            .expect("a case is serialised")
            .contains(&folder_name)
    );
}

#[test]
fn dos_line_endings_and_a_byte_order_mark_are_read() {
    let text = format!("\u{feff}{}", GOOD.replace('\n', "\r\n"));
    one(from_text(&text, &[]).expect("the same case"));
}

#[test]
fn deep_nesting_is_an_error() {
    for text in [
        format!("a = {}", "[".repeat(200_000)),
        format!("{} = 1", vec!["a"; 100_000].join(".")),
        format!("a = {}1{}", "{a=".repeat(50_000), "}".repeat(50_000)),
    ] {
        assert!(from_text(&text, &[]).is_err());
    }
}

/// Damaged cases are read or refused, never a panic: 2000 mutations, the same in every run.
#[test]
fn damaged_cases_never_panic() {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(20_250_101);
    let good: Vec<Vec<u8>> = case_files()
        .iter()
        .map(|path| fs::read(path).expect("a case"))
        .collect();
    let (mut read, mut refused) = (0, 0);
    for _ in 0..2000 {
        let mut bytes = good[random.random_range(0..good.len())].clone();
        for _ in 0..random.random_range(1..=4) {
            let at = random.random_range(0..bytes.len());
            let end = (at + random.random_range(1..=12)).min(bytes.len());
            match random.random_range(0..4) {
                0 => drop(bytes.drain(at..end)),
                1 => {
                    let part = bytes[at..end].to_vec();
                    bytes.splice(at..at, part);
                }
                2 => bytes[at] ^= 1 << random.random_range(0..8),
                _ => bytes[at] = b"0123456789.-=[]{}\"#\n"[random.random_range(0..20)],
            }
        }
        let text = String::from_utf8_lossy(&bytes);
        match CaseFile::<Case>::from_text(Path::new("damaged.toml"), &text, &[]) {
            Ok(file) => {
                read += 1;
                assert!(
                    file.points
                        .iter()
                        .all(|point| point.case.sample_times().len() > 1)
                );
            }
            Err(error) => {
                refused += 1;
                assert!(error.to_string().starts_with("damaged.toml"), "{error}");
                assert!(
                    error
                        .line()
                        .is_some_and(|line| line <= text.lines().count() + 1),
                    "{error}"
                );
            }
        }
    }
    assert!(
        read > 100 && refused > 1000,
        "{read} read, {refused} refused"
    );
}
