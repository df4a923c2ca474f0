//! Disks of several species in the paired case.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use stosszahl::case::Case;
use stosszahl::setup::{Setup, TimeUnit};

const BINARY: &str = "\
# Do a few disks of two sizes cool?
format = 1
title = \"a test\"
seed = 5
replicas = 8

[gas]
disks = 90
packing_fraction = 0.2
restitution = 0.8

[[gas.species]]
share = 0.7
diameter = 1
mass = 1

[[gas.species]]
share = 0.3
diameter = 2
mass = 4

[run]
until = 4
first_sample = 0.5

[engine.ed]

[engine.dsmc-contact-point]
simulators_per_disk = 4

[measure]
impact_windows = [[0, 4]]
impact_bins = 5
structure_times = []
";

fn stosszahl(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_stosszahl"))
        .current_dir(folder)
        .args(arguments)
        .output()
        .expect("the program starts")
}

fn setup(folder: &Path, overrides: &[&str]) -> Result<Setup, String> {
    let overrides: Vec<String> = overrides.iter().map(|&one| one.to_owned()).collect();
    let file = Case::read(folder.join("binary.toml"), &overrides).expect("a valid case");
    Setup::new(&file.points[0].case).map_err(|error| error.to_string())
}

#[test]
fn species_give_sizes_and_units() {
    let folder = tempfile::tempdir().expect("a folder");
    fs::write(folder.path().join("binary.toml"), BINARY).expect("written");
    let plan = setup(folder.path(), &[]).expect("a plan");
    let counts: Vec<usize> = plan.species.iter().map(|one| one.count).collect();
    assert_eq!(counts, [63, 27]);
    // Means of diameter and mass are one: (0.7 + 0.3 2) = 1.3, (0.7 + 0.3 4) = 1.9.
    assert!((plan.scale.length - 1.3).abs() < 1e-12 && (plan.scale.mass - 1.9).abs() < 1e-12);
    assert_eq!(
        (
            plan.species_of(62),
            plan.species_of(63),
            plan.species_of(90)
        ),
        (0, 1, 0)
    );
    let covered: f64 = plan
        .species
        .iter()
        .map(|one| one.count as f64 * std::f64::consts::PI * one.radius * one.radius)
        .sum();
    assert!((covered / plan.domain.volume() / 0.2 - 1.0).abs() < 1e-12);
    assert_eq!(plan.time_unit, TimeUnit::Haff);
    // The energy falls at the rate -2/t0 at first: over a thousandth of t0 by 2e-3, and by its square less.
    let theory = plan.partial_temperatures(&[0.0, 1e-3]).expect("theory");
    let energy = |all: &[f64]| (63.0 * all[0] + 27.0 * all[1]) / 90.0;
    let slope = (energy(&theory[0]) - energy(&theory[1])) / 1e-3;
    assert!((slope - 2.0).abs() < 0.01, "{slope}");
    let dense = setup(folder.path(), &["gas.packing_fraction=0.6"]).expect_err("too dense");
    assert!(dense.contains("at most 0.45"), "{dense}");
}

#[test]
fn tables_tell_the_species_apart() {
    let folder = tempfile::tempdir().expect("a folder");
    fs::write(folder.path().join("binary.toml"), BINARY).expect("written");
    for (threads, out) in [("1", "one"), ("2", "two")] {
        let ran = stosszahl(
            folder.path(),
            &["run", "binary.toml", "--threads", threads, "--out", out],
        );
        assert!(
            ran.status.success(),
            "{}",
            String::from_utf8_lossy(&ran.stderr)
        );
    }
    let read =
        |out: &str, name: &str| fs::read(folder.path().join(out).join(name)).expect("a table");
    let name = "partial_temperature.csv";
    assert_eq!(read("one", name), read("two", name));
    let text = String::from_utf8(read("one", name)).expect("text");
    let mut reader = csv::Reader::from_reader(text.as_bytes());
    let rows: Vec<(String, f64, u64, f64)> = reader
        .records()
        .map(|row| {
            let row = row.expect("a row");
            let number = |place: usize| row[place].parse::<f64>().expect("a number");
            (row[0].to_owned(), number(1), number(2) as u64, number(3))
        })
        .collect();
    // Partial temperatures, by the numbers of their disks, make up the energy of the gas.
    let energy = String::from_utf8(read("one", "energy.csv")).expect("text");
    let mut energies = csv::Reader::from_reader(energy.as_bytes());
    let mut count = 0;
    for row in energies.records() {
        let row = row.expect("a row");
        let time: f64 = row[2].parse().expect("a number");
        let ratio: f64 = row[4].parse().expect("a number");
        let part = |species: u64| {
            let own = rows
                .iter()
                .find(|one| one.0 == row[0] && one.1 == time && one.2 == species);
            own.expect("a species").3
        };
        let sum = (63.0 * part(1) + 27.0 * part(2)) / 90.0;
        assert!((sum / ratio - 1.0).abs() < 1e-12, "{time}: {sum} {ratio}");
        count += 1;
    }
    assert!(count > 10, "{count} samples");
    // Every collision is one of the three kinds of pairs.
    let sum = |name: &str, column: &str| -> u64 {
        let bytes = read("one", name);
        let mut reader = csv::Reader::from_reader(bytes.as_slice());
        let place = reader
            .headers()
            .expect("a header")
            .iter()
            .position(|one| one == column);
        let place = place.expect("a column");
        let cells = reader
            .records()
            .map(|row| row.expect("a row")[place].parse::<u64>());
        cells.map(|cell| cell.expect("a count")).sum()
    };
    let pairs = sum("impact_parameter_pairs.csv", "count");
    assert_eq!(pairs, sum("impact_parameter.csv", "count"));
    assert!(pairs > 1000, "{pairs}");
    let page = String::from_utf8(read("one", "report.html")).expect("text");
    assert!(page.contains("Partial temperatures") && page.contains("species 1 and 2"));
}
