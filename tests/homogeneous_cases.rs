//! Cases of gases without positions: what is refused, and what a run leaves, through the program and the library.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::atomic::AtomicBool;

use serde_json::Value;
use stosszahl::analysis::theory::{Component, Contact, Mixture};
use stosszahl::case::{CaseError, CaseFile, Kind};
use stosszahl::homogeneous::case::Case;
use stosszahl::homogeneous::plan::Plan;
use stosszahl::homogeneous::run;
use stosszahl::model::Constant;
use stosszahl::progress::Progress;
use stosszahl::run::Place;

/// A small mixture with all that can be measured on it.
const MIXTURE: &str = "\
# Does a small mixture cool?
format = 1
kind = \"homogeneous\"
title = \"a test\"
seed = 3
replicas = 3

[gas]
dimension = 3
volume = 2e4
restitution = 0.8

[[species]]
density = 0.1
mass = 1

[[species]]
count = 500
mass = 4
diameter = 1.5
temperature = 2

[run]
until = 50
first_sample = 0.5
samples_per_decade = 4

[measure]
displacement = true
velocity_correlation = true
paths = 20
";

/// Monomers that stick and break.
const CLUSTERS: &str = "\
# Do a few monomers stick?
format = 1
kind = \"homogeneous\"
title = \"a test of sticking\"
replicas = 2

[gas]
volume = 2e5
restitution = 1

[[species]]
count = 2000

[sticking]
stick_below = 4
break_above = 12

[heating]
interval = 5

[run]
until = 200

[measure]
size_distribution_times = [0, 100]
";

fn read(text: &str, overrides: &[&str]) -> Result<CaseFile<Case>, CaseError> {
    let overrides: Vec<String> = overrides.iter().map(|&one| one.to_owned()).collect();
    CaseFile::from_text(Path::new("test.toml"), text, &overrides)
}

fn plan(text: &str, overrides: &[&str]) -> Plan {
    let file = read(text, overrides).unwrap_or_else(|error| panic!("{error}"));
    Plan::new(&file.points[0].case).expect("a plan")
}

#[test]
fn every_case_is_valid_and_asks_a_question() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("cases");
    let mut count = 0;
    for entry in fs::read_dir(folder).expect("the cases") {
        let path = entry.expect("a case").path();
        if Kind::of_file(&path).expect("a case has a kind") != Kind::Homogeneous {
            continue;
        }
        count += 1;
        let file = CaseFile::<Case>::read(&path, &[]).unwrap_or_else(|error| panic!("{error}"));
        let first = file.source_text.lines().next().unwrap_or_default();
        assert!(
            first.starts_with("# ") && first.ends_with('?'),
            "{}: {first}",
            path.display()
        );
        for point in &file.points {
            let times = point.case.sample_times();
            assert_eq!(times.first(), Some(&0.0));
            assert_eq!(times.last(), Some(&point.case.run.until));
            assert!(times.is_sorted_by(|earlier, later| earlier < later));
            Plan::new(&point.case).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
        }
    }
    assert!(count >= 13, "{count} cases");
}

/// The case with one text replaced by another, what the error says, and the line that it names.
struct Bad(
    &'static str,
    &'static str,
    &'static str,
    &'static [&'static str],
    usize,
);

/// Cases that are wrong in one way each.
const BAD: [Bad; 27] = [
    Bad(
        MIXTURE,
        "kind = \"homogeneous\"",
        "kind = \"homogenous\"",
        &[
            "kind = \"homogenous\"",
            "did you mean \"homogeneous\"?",
            "\"paired\"",
        ],
        3,
    ),
    Bad(
        MIXTURE,
        "restitution = 0.8",
        "restitution = 1.8",
        &["gas.restitution = 1.8", "from 0 to 1"],
        11,
    ),
    Bad(
        MIXTURE,
        "restitution = 0.8",
        "restitutoin = 0.8",
        &["unknown key gas.restitutoin", "did you mean restitution?"],
        11,
    ),
    Bad(
        MIXTURE,
        "dimension = 3",
        "dimension = 4",
        &["gas.dimension = 4", "2 or 3"],
        9,
    ),
    Bad(
        MIXTURE,
        "volume = 2e4\n",
        "",
        &["gas.volume is missing", "above 0"],
        8,
    ),
    Bad(
        MIXTURE,
        "volume = 2e4",
        "volume = 1e300",
        &["species[0].density = 0.1", "at most 2147483647 particles"],
        14,
    ),
    Bad(
        MIXTURE,
        "count = 500",
        "count = 500\ndensity = 0.1",
        &["species[1].density = 0.1", "in place of a count"],
        19,
    ),
    Bad(
        MIXTURE,
        "count = 500\n",
        "",
        &["species[1].count is missing", "either a count"],
        17,
    ),
    Bad(
        MIXTURE,
        "count = 500",
        "count = 0\ntracer = 1",
        &["species[1].tracer = 1", "true for one species at most"],
        19,
    ),
    Bad(
        MIXTURE,
        "density = 0.1",
        "density = 0.1\ntracer = true",
        &["species[0].density = 0.1", "0 or more"],
        14,
    ),
    Bad(
        MIXTURE,
        "mass = 4",
        "mas = 4",
        &["unknown key species[1].mas", "did you mean mass?"],
        19,
    ),
    Bad(
        MIXTURE,
        "mass = 4",
        "mass = 0",
        &["species[1].mass = 0", "above 0"],
        19,
    ),
    Bad(
        MIXTURE,
        "[run]",
        "[power_law]\nmonomers = 5\nexponent = 3\n[run]",
        &["power_law = ", "exactly one of the three"],
        23,
    ),
    Bad(
        MIXTURE,
        "[run]",
        "[[pair]]\nspecies = [1, 3]\nrestitution = 0.5\n[run]",
        &["pair[0].species = [1, 3]", "counted from 1"],
        24,
    ),
    Bad(
        MIXTURE,
        "[run]",
        "[[pair]]\nspecies = [1, 2]\nrestitution = 1.5\n[run]",
        &["pair[0].restitution = 1.5", "from 0 to 1"],
        25,
    ),
    Bad(
        MIXTURE,
        "[run]",
        "[sticking]\n[run]",
        &["sticking = {}", "exactly one [[species]]"],
        23,
    ),
    Bad(
        MIXTURE,
        "first_sample = 0.5",
        "first_sample = 50",
        &["run.first_sample = 50", "run.until = 50"],
        25,
    ),
    Bad(
        MIXTURE,
        "displacement = true",
        "displacement = false",
        &["measure.paths = 20", "measure.displacement is true"],
        31,
    ),
    Bad(
        MIXTURE,
        "paths = 20",
        "size_distribution_times = [1]",
        &["measure.size_distribution_times = [1]", "need [sticking]"],
        31,
    ),
    Bad(
        MIXTURE,
        "restitution = 0.8",
        "restitution = 1\n[verdict]\nsonine_orders = 13",
        &["verdict.sonine_orders = 13", "from 1 to 12"],
        13,
    ),
    Bad(
        MIXTURE,
        "restitution = 0.8",
        "restitution = 1\n[engine]\nselection = \"birds\"",
        &["engine.selection = \"birds\"", "did you mean \"bird\"?"],
        13,
    ),
    Bad(
        CLUSTERS,
        "until = 200",
        "until = 200\ntime_unit = \"haff\"",
        &["run.time_unit = \"haff\"", "one that sticks"],
        23,
    ),
    Bad(
        CLUSTERS,
        "interval = 5",
        "interval = 500",
        &["heating.interval = 500", "below run.until"],
        19,
    ),
    Bad(
        CLUSTERS,
        "break_above = 12",
        "break_above = -1",
        &["sticking.break_above = -1", "0 or more"],
        16,
    ),
    Bad(
        CLUSTERS,
        "[0, 100]",
        "[0, 100]\nfit_monomers = [5, 9]",
        &["measure.fit_monomers = [5, 9]", "by a factor 2"],
        26,
    ),
    Bad(
        CLUSTERS,
        "[0, 100]",
        "[100, 0]",
        &["measure.size_distribution_times = [100, 0]", "rising"],
        25,
    ),
    Bad(
        CLUSTERS,
        "[0, 100]",
        "[]\ndisplacement = true",
        &[
            "measure.displacement = true",
            "particles that stick have none",
        ],
        26,
    ),
];

#[test]
fn bad_cases_are_explained() {
    for Bad(good, from, to, says, line) in BAD {
        let text = good.replacen(from, to, 1);
        assert_ne!(text, good, "{from}");
        let path = Path::new("test.toml");
        let error = Kind::of_text(path, &text)
            .and_then(|_| read(&text, &[]))
            .expect_err(to);
        let said = error.to_string();
        for part in says {
            assert!(said.contains(part), "{to}: {said}");
        }
        assert_eq!(error.line(), Some(line), "{to}: {said}");
    }
    let error = read(MIXTURE, &["gas.volume=100", "gas.contact_values=dense"]).expect("valid");
    let refused = Plan::new(&error.points[0].case).expect_err("too dense");
    assert!(
        refused.to_string().contains("packing fraction"),
        "{refused}"
    );
}

#[test]
fn cases_without_species_of_their_own_name_what_is_missing() {
    let none = MIXTURE
        .replace("[[species]]\ndensity = 0.1\nmass = 1\n", "")
        .replace(
            "[[species]]\ncount = 500\nmass = 4\ndiameter = 1.5\ntemperature = 2\n",
            "",
        );
    let error = read(&none, &[]).expect_err("no species").to_string();
    assert!(error.contains("species is missing"), "{error}");
    let endless = none.clone() + "[power_law]\nmonomers = 100\nexponent = 0.1\n";
    let error = read(&endless, &[]).expect_err("no end").to_string();
    assert!(
        error.contains("power_law.largest_mass is missing"),
        "{error}"
    );
    let wide = none.clone()
        + "[continuous]\nparticles = 100\ndistribution = \"uniform\"\nrelative_width = 0.6\n";
    let error = read(&wide, &[]).expect_err("negative sizes").to_string();
    assert!(error.contains("at most at 0.57"), "{error}");
}

#[test]
fn species_follow_from_rules() {
    let none = MIXTURE
        .split("[[species]]")
        .next()
        .expect("a start")
        .to_owned();
    let rest = "[run]\nuntil = 5\n";
    let law = |rounding: &str| {
        let table = format!(
            "[power_law]\nmonomers = 1000\nexponent = 3\nrounding = \"{rounding}\"\n{rest}"
        );
        plan(&(none.clone() + &table), &[])
    };
    // 1000 k^-3 falls below one at k = 10 and below one half at k = 12.6.
    assert_eq!(law("down").groups.len(), 10);
    assert_eq!(law("nearest").groups.len(), 12);
    let eighth = law("down").groups[1];
    assert_eq!((eighth.count, eighth.mass), (125, 2.0));
    assert!((eighth.diameter - 2.0_f64.cbrt()).abs() < 1e-15);

    let sizes = "[continuous]\nparticles = 40000\ndistribution = \"log-normal\"\nrelative_width = 0.3\ngroups = 8\n";
    let continuous = plan(&(none.clone() + sizes + rest), &[]);
    assert_eq!(continuous.groups.len(), 8);
    assert!(continuous.groups.iter().all(|group| group.count == 5000));
    let mean: f64 = continuous
        .groups
        .iter()
        .map(|group| group.diameter / 8.0)
        .sum();
    // The mean of 40000 has the standard error 0.3/200; z = 4.5 is a false alarm in 1e5, and the seed is fixed.
    assert!((mean - 1.0).abs() < 4.5 * 0.3 / 200.0, "{mean}");
}

#[test]
fn keys_of_the_schema_have_descriptions_and_sentences() {
    fn visit(schema: &Value, path: &str, count: &mut usize) {
        for inner in ["anyOf", "oneOf"] {
            for choice in schema[inner].as_array().into_iter().flatten() {
                visit(choice, path, count);
            }
        }
        if schema.get("items").is_some() {
            visit(&schema["items"], path, count);
        }
        for (key, value) in schema["properties"].as_object().into_iter().flatten() {
            let path = format!("{path}.{key}");
            assert!(
                value["description"].is_string(),
                "{path} has no description"
            );
            let table = value["properties"].is_object()
                || value["items"]["properties"].is_object()
                || value["anyOf"][0]["properties"].is_object();
            assert!(
                table || value["x-allowed"].is_string() || value["anyOf"].is_array(),
                "{path} has no sentence"
            );
            *count += 1;
            visit(value, &path, count);
        }
    }
    let mut count = 0;
    visit(Kind::Homogeneous.schema().json(), "", &mut count);
    assert!(count > 50, "{count}");
}

fn stosszahl(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_stosszahl"))
        .current_dir(folder)
        .args(arguments)
        .output()
        .expect("the program starts")
}

/// A table by columns, cells as text.
fn table(path: &Path) -> BTreeMap<String, Vec<String>> {
    let mut reader = csv::Reader::from_path(path).expect("a table");
    let headers = reader.headers().expect("a header").clone();
    let mut columns: BTreeMap<String, Vec<String>> = BTreeMap::new();
    for record in reader.records() {
        for (name, cell) in headers.iter().zip(&record.expect("a row")) {
            columns
                .entry(name.to_owned())
                .or_default()
                .push(cell.to_owned());
        }
    }
    columns
}

/// Cells of a column; empty ones are no numbers.
fn numbers(table: &BTreeMap<String, Vec<String>>, column: &str) -> Vec<f64> {
    let number = |cell: &String| match cell.as_str() {
        "" => f64::NAN,
        cell => cell.parse().expect("a number"),
    };
    table[column].iter().map(number).collect()
}

/// The tables of a folder, byte for byte.
fn tables(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    fs::read_dir(folder)
        .expect("a folder")
        .map(|entry| entry.expect("an entry").path())
        .filter(|path| path.extension().is_some_and(|ending| ending == "csv"))
        .map(|path| {
            let bytes = fs::read(&path).expect("a table");
            (PathBuf::from(path.file_name().expect("a name")), bytes)
        })
        .collect()
}

#[test]
fn a_run_leaves_the_same_tables_on_any_number_of_threads() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    fs::write(at.join("mixture.toml"), MIXTURE).expect("written");
    let checked = stosszahl(at, &["check", "mixture.toml"]);
    assert!(checked.status.success());
    let said = String::from_utf8_lossy(&checked.stdout).into_owned();
    assert!(said.contains("collisions_per_particle_by_theory"), "{said}");
    for (threads, out) in [("1", "one"), ("2", "two")] {
        let ran = stosszahl(
            at,
            &["run", "mixture.toml", "--threads", threads, "--out", out],
        );
        let error = String::from_utf8_lossy(&ran.stderr).into_owned();
        assert!(ran.status.success(), "{error}");
    }
    let (one, two) = (tables(&at.join("one")), tables(&at.join("two")));
    assert_eq!(one.len(), 5, "{:?}", one.keys());
    assert_eq!(one, two);
    assert!(!at.join("one/checkpoints").exists());
    // The report is a function of the folder.
    let page = fs::read(at.join("one/report.html")).expect("a report");
    fs::remove_file(at.join("one/report.html")).expect("removed");
    assert!(stosszahl(at, &["report", "one"]).status.success());
    assert_eq!(
        fs::read(at.join("one/report.html")).expect("a report"),
        page
    );
    let page = String::from_utf8(page).expect("text");
    for part in [
        "Temperatures of the species",
        "Mean squared displacement",
        "Time-averaged",
        "Measured against theory",
    ] {
        assert!(page.contains(part), "no {part} in the report");
    }
    theory_is_that_of_the_library(&at.join("one"));
    // Replaced only on demand, and other seeds have other tables.
    let again = ["run", "mixture.toml", "--out", "one", "--seed", "4"];
    assert_eq!(stosszahl(at, &again).status.code(), Some(2));
    let mut forced = again.to_vec();
    forced.push("--force");
    assert!(stosszahl(at, &forced).status.success());
    assert_ne!(
        tables(&at.join("one"))[Path::new("gas.csv")],
        one[Path::new("gas.csv")]
    );
}

/// The columns of theory against the equations solved here, and measured values against them.
fn theory_is_that_of_the_library(folder: &Path) {
    let species = table(&folder.join("species.csv"));
    let component = |mass, diameter, density| Component {
        mass,
        diameter,
        density,
    };
    let components = vec![component(1.0, 1.0, 0.1), component(4.0, 1.5, 500.0 / 2e4)];
    let law = Constant::new(0.8).expect("a coefficient");
    let mixture = Mixture::new(3, components, law, Contact::Dilute).expect("a mixture");
    let (time, number) = (numbers(&species, "time"), numbers(&species, "species"));
    let times: Vec<f64> = time.iter().copied().step_by(2).collect();
    let orders = mixture.affordable_orders();
    assert_eq!(orders, 6);
    let curves = mixture.solve(orders, &[1.0, 2.0], &times).expect("smooth");
    for (column, tolerance) in [
        ("temperature_theory", 1e-12),
        ("displacement_square_theory", 1e-12),
    ] {
        for (row, found) in numbers(&species, column).into_iter().enumerate() {
            let moment = &curves[row / 2];
            let k = number[row] as usize - 1;
            let exact = if column == "temperature_theory" {
                moment.temperatures[k]
            } else {
                moment.displacements[k]
            };
            // The same integration: only the writing and reading of numbers lies between.
            assert!(
                (found - exact).abs() <= tolerance * exact,
                "{column} {row}: {found} {exact}"
            );
        }
    }
    // 2000 light particles in each of three replicas know their temperature to 1 %; 6 % are six standard errors.
    let last = time.len() - 2;
    let ratio =
        numbers(&species, "temperature")[last] / numbers(&species, "temperature_theory")[last];
    assert!((ratio - 1.0).abs() < 0.06, "{ratio}");
    let averaged = table(&folder.join("time_averaged_displacement.csv"));
    assert!(
        numbers(&averaged, "displacement_square")
            .iter()
            .all(|&square| square > 0.0)
    );
}

/// Sizes, numbers and laws from two equal shares to every particle its own, in both dimensions, dilute and dense.
const CONTENTS: [(&str, &str, &str); 8] = [
    ("two", "dimension = 3", TWO),
    ("two disks", "dimension = 2", TWO),
    ("two, dense", "contact_values = \"dense\"", TWO),
    (
        "two disks, dense",
        "dimension = 2\ncontact_values = \"dense\"",
        TWO,
    ),
    (
        "pairs",
        "dimension = 3",
        "species = [{ count = 20000 }, { count = 20000, mass = 4, diameter = 1.5874 }]\n\
         pair = [{ species = [1, 2], restitution = 0.6 }, { species = [2, 2], restitution = 1 }]\n",
    ),
    (
        "three",
        "dimension = 3",
        "species = [{ count = 20000 }, { count = 20000, mass = 4, diameter = 1.5874 }, \
         { count = 20000, mass = 0.25, diameter = 0.63 }]\n",
    ),
    (
        "hundred",
        "dimension = 3",
        "replicas = 16\npower_law = { monomers = 20000, exponent = 1, largest_mass = 100 }\n",
    ),
    (
        "continuous",
        "dimension = 3",
        "continuous = { particles = 60000, distribution = \"log-normal\", relative_width = 0.4, groups = 8 }\n",
    ),
];

const TWO: &str = "species = [{ count = 20000 }, { count = 20000, mass = 4, diameter = 1.5874 }]\n";

/// Partial temperatures follow the kinetic equations: to the error of their Sonine expansion where there is one, and within
/// 2 % in the first order where velocities are nearly Maxwellian, which it assumes: a fourth cumulant below 0.03.
/// Measured are those species whose temperature is known to one percent; 4.5 standard errors beyond are a false alarm in
/// 10^5 values.
#[test]
fn partial_temperatures_are_those_of_the_kinetic_equations() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    for (name, gas, content) in CONTENTS {
        // Keys of the top level come before the tables.
        let text = format!(
            "format = 1\nkind = \"homogeneous\"\ntitle = \"{name}\"\nseed = 5\n{content}\
             [gas]\nvolume = 4e5\nrestitution = 0.9\n{gas}\n\
             [run]\nuntil = 100\nfirst_sample = 1\nsamples_per_decade = 2\n"
        );
        fs::write(at.join("case.toml"), text).expect("written");
        let ran = stosszahl(at, &["run", "case.toml", "--force", "--out", "out"]);
        assert!(
            ran.status.success(),
            "{name}: {}",
            String::from_utf8_lossy(&ran.stderr)
        );
        let species = table(&at.join("out/species.csv"));
        let column = |name| numbers(&species, name);
        let (found, errors) = (column("temperature"), column("temperature_se"));
        let (theory, cumulants) = (column("temperature_theory"), column("fourth_cumulant"));
        let left = column("temperature_theory_error");
        let mut checked = 0;
        for row in 0..found.len() {
            let (ratio, error) = (found[row] / theory[row], errors[row] / theory[row]);
            // Not known of the first order.
            let (allowed, applies) = if left[row].is_nan() {
                (0.02, cumulants[row].abs() < 0.03)
            } else {
                assert!(
                    left[row] < 0.005 * theory[row],
                    "{name}, row {row}: {}",
                    left[row]
                );
                (left[row] / theory[row], true)
            };
            if error < 0.01 && applies {
                let what = format!(
                    "{name}, row {row}: {ratio} +- {error}, a2 {}",
                    cumulants[row]
                );
                assert!((ratio - 1.0).abs() < allowed + 4.5 * error, "{what}");
                checked += 1;
            }
        }
        assert!(checked >= 6, "{name}: only {checked} of {}", found.len());
        // They have parted from each other and cooled by a factor: the equations had something to say.
        assert!(theory.last().is_some_and(|&last| last < 0.7), "{name}");
    }
}

/// Runs a plan in a folder, stopped after every leg if so asked; the number of stops.
fn run_in(folder: &Path, plan: &Plan, stops: bool) -> (Vec<run::Finished>, usize) {
    let stop = AtomicBool::new(stops);
    let mut count = 0;
    loop {
        let progress = Progress::start("test");
        let place = Place {
            folder,
            fingerprint: &[7; 32],
            stop: &stop,
            progress: &progress,
        };
        match run::run(plan, place) {
            Ok(runs) => return (runs, count),
            Err(error) => assert!(error.is_interruption(), "{error}"),
        }
        count += 1;
        assert!(count < 10_000, "no end");
    }
}

#[test]
fn a_run_that_is_stopped_again_and_again_measures_the_same() {
    for (text, selection) in [
        (MIXTURE, "own"),
        (MIXTURE, "low-rank"),
        (CLUSTERS, "own"),
        (CLUSTERS, "bird"),
    ] {
        let plan = plan(
            text,
            &[
                &format!("engine.selection={selection}"),
                "replicas=2",
                "run.until=20",
                "run.first_sample=1",
                "measure={}",
            ],
        );
        let folder = tempfile::tempdir().expect("a folder");
        let (through, none) = run_in(folder.path(), &plan, false);
        let other = tempfile::tempdir().expect("a folder");
        let (stopped, count) = run_in(other.path(), &plan, true);
        assert_eq!(none, 0);
        assert!(count > 3, "{count} stops");
        for (a, b) in through.iter().zip(&stopped) {
            assert_eq!(a.record, b.record);
            assert_eq!(a.tally, b.tally);
        }
    }
}

#[test]
fn clusters_keep_mass_and_energy_in_their_tables() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    fs::write(at.join("clusters.toml"), CLUSTERS).expect("written");
    let ran = stosszahl(at, &["run", "clusters.toml", "--out", "out"]);
    assert!(
        ran.status.success(),
        "{}",
        String::from_utf8_lossy(&ran.stderr)
    );
    let said = String::from_utf8_lossy(&ran.stdout).into_owned();
    assert!(said.contains("steady state"), "{said}");
    let clusters = table(&at.join("out/clusters.csv"));
    let column = |name| numbers(&clusters, name);
    let (energy, stuck) = (column("energy_ratio"), column("stuck_energy"));
    let (shattered, heated) = (column("shattered_energy"), column("heating_energy"));
    for row in 0..energy.len() {
        // Elastic bounces; some thousand events, each closed to a few roundings of energies below ten.
        let sum = energy[row] + stuck[row] + shattered[row] - heated[row];
        assert!((sum - 1.0).abs() < 1e-11, "row {row}: {sum}");
    }
    assert!(stuck.last().is_some_and(|&stuck| stuck > 0.1));
    let sizes = table(&at.join("out/size_distribution.csv"));
    let density = numbers(&sizes, "clusters_per_monomer");
    let (low, high) = (
        numbers(&sizes, "monomers_low"),
        numbers(&sizes, "monomers_high"),
    );
    let single: Vec<usize> = (0..density.len())
        .filter(|&row| sizes["average"][row] == "instant" && sizes["time"][row] == "0.0")
        .collect();
    assert_eq!(single.len(), 1);
    assert_eq!((low[single[0]], density[single[0]]), (1.0, 1.0));
    // Mass in bins of one size is exact; wider bins know their middle only, which bounds it from both sides.
    let mass = |edge: &[f64]| -> f64 {
        (0..density.len())
            .filter(|&row| sizes["average"][row] == "steady")
            .map(|row| density[row] * edge[row] * (high[row] - low[row] + 1.0))
            .sum()
    };
    assert!(
        mass(&low) <= 1.0 + 1e-12 && mass(&high) >= 1.0 - 1e-12,
        "{} {}",
        mass(&low),
        mass(&high)
    );
}
