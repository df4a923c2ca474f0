//! Combinations of walls, gravity, spin, kicks, weights and copies, each run through as a small
//! case.

use std::path::Path;

use stosszahl_model::Interrupt;
use stosszahl_results::{Existing, Manifest};

use crate::check::{self, Planned};
use crate::run_case;

/// Reads a case of 40 disks whose remaining tables are `tables`.
fn file(gas: &str, tables: &str) -> stosszahl_case::CaseFile {
    let text =
        format!("format = 2\nreplicas = 2\n[gas]\nnumber = 40\n{gas}\n[run]\nuntil = 2\n{tables}");
    let file = check::format().from_text(Path::new("case.toml"), &text, &[]);
    file.unwrap_or_else(|error| panic!("{}", error.report(false)))
}

/// Runs a case with its default measures and returns the names of its tables.
fn tables_of(gas: &str, tables: &str) -> Vec<String> {
    let file = file(gas, tables);
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().join("out");
    let options = crate::RunOptions {
        out: Some(out.clone()),
        existing: Existing::Refuse,
        threads: Some(1),
        ignore_memory_limit: false,
        stop: &Interrupt::default(),
        progress: &(),
        commit: "",
    };
    run_case(&file, &options).unwrap_or_else(|error| panic!("{tables}: {error}"));
    let manifest = Manifest::read(&out)
        .expect("a folder")
        .expect("a finished run");
    manifest.tables.into_iter().map(|one| one.name).collect()
}

const WALLS: &str =
    "[box]\nsize = [20, 20]\n[walls]\nbottom = { restitution = 1 }\ntop = { restitution = 1 }\n";
const PERIODIC: &str = "[box]\nsize = [20, 20]\n";
const ENGINES: &str = "[engine.ed]\n[engine.dsmc-enskog]\ndisplacement = false\n";

/// Kicks drive smooth and rough disks between walls, in gravity and in a periodic box.
#[test]
fn kicks_go_with_walls_gravity_and_spin() {
    let kicks = "[thermostat]\nkind = \"white-noise\"\nheating = 0.5\ninterval = 0.1\n";
    let gravity = "[gravity]\nacceleration = [0, -0.1]\n";
    for (gas, tables) in [
        ("restitution = 0.9", format!("{WALLS}{kicks}{ENGINES}")),
        (
            "restitution = 0.9\ntangential_restitution = 0.5",
            format!("{WALLS}{gravity}{kicks}{ENGINES}"),
        ),
        (
            "restitution = 0.9\ntangential_restitution = 0.5",
            format!("{PERIODIC}{kicks}{ENGINES}"),
        ),
    ] {
        let found = tables_of(gas, &tables);
        assert!(found.iter().any(|name| name == "steady_state"), "{found:?}");
    }
}

/// Weights by region split and merge simulators of a uniform gas too.
#[test]
fn weights_go_with_a_uniform_gas() {
    let engine = "[engine.dsmc-boltzmann]\nsimulators_per_particle = 4\nweights = { along = \"x\", factors = [1, 2] }\n";
    let found = tables_of("restitution = 0.9", &format!("{PERIODIC}{engine}"));
    assert!(
        found.iter().any(|name| name == "impact_parameter"),
        "{found:?}"
    );
}

/// Independent sets of simulators may be asked for wherever the engine runs.
#[test]
fn independent_copies_go_with_walls_and_spin() {
    let engine = "[engine.dsmc-contact-point]\nsimulators_per_particle = 2\nsimulator_start = \"independent\"\n";
    tables_of("restitution = 0.9", &format!("{WALLS}{engine}"));
    let rough = "restitution = 0.9\ntangential_restitution = 0.5";
    tables_of(rough, &format!("{PERIODIC}{engine}"));
}

/// An elastic gas has no cooling time: its unit is then the mean free time, whatever stands around
/// it.
#[test]
fn cooling_times_of_elastic_gases_are_mean_free_times() {
    for tables in [WALLS, PERIODIC] {
        let tables = format!("time_unit = \"haff\"\n{tables}{ENGINES}");
        let file = file("restitution = 1", &tables);
        let plan = Planned::new(&file, &file.points[0]).expect("a plan").plan;
        assert_eq!(
            plan.clock.time.to_bits(),
            plan.clock.mean_free_time.to_bits()
        );
    }
}

/// A pilot knows the error of its resolution by theory, which walls, gravity and spin take away.
#[test]
fn accuracy_names_what_theory_does_not_know() {
    let accuracy = "[accuracy]\ntarget = \"10%\"\n";
    let rough = "restitution = 0.9\ntangential_restitution = 0.5";
    for (gas, tables, words) in [
        ("restitution = 0.9", WALLS, "walls"),
        (rough, PERIODIC, "particles that spin"),
    ] {
        let file = file(gas, &format!("{tables}{accuracy}{ENGINES}"));
        let Err(error) = Planned::new(&file, &file.points[0]) else {
            panic!("{words}: an accuracy without a theory");
        };
        let said = error.to_string();
        assert!(said.contains(words) && said.contains("accuracy"), "{said}");
    }
}
