//! Implausible cases are named or refused, by `check` as by `run`, and a run that would never end
//! does.

use crate::support::program::{CASES, TestFolder};

/// Returns a case of disks in a box with faces and forces, and an engine.
fn flow(gas: &str, more: &str) -> String {
    format!(
        "format = 2\ntitle = \"a flow\"\nreplicas = 2\n[gas]\nnumber = 100\nrestitution = 0.9\n{gas}[box]\nsize = [40, 20]\n\
         [run]\nuntil = 1\n{more}"
    )
}

/// Returns the lines of `check --no-timing` that begin with a word, without it.
fn lines(text: &str, word: &str) -> Vec<String> {
    let said = TestFolder::new(text)
        .done("check case.toml --no-timing")
        .out;
    let lines = said
        .lines()
        .filter_map(|line| line.trim().strip_prefix(word));
    lines.map(str::to_owned).collect()
}

/// Returns true if a warning of a case has all of these words.
fn warns(text: &str, words: &[&str]) -> bool {
    let warnings = lines(text, "warning:");
    warnings
        .iter()
        .any(|line| words.iter().all(|word| line.contains(word)))
}

#[test]
fn a_contact_time_that_makes_all_contacts_elastic_is_named() {
    let case = |contact_time: &str, restitution: &str| {
        format!(
            "format = 2\ntitle = \"contact time\"\n[gas]\nnumber = 100\nrestitution = {restitution}\n[box]\npacking_fraction = 0.25\n\
             [run]\nuntil = 4\ntime_unit = \"mean-free-time\"\n[engine.ed]\ncontact_time = {contact_time}\n"
        )
    };
    // 1 - exp(-4) of the contacts have a partner that collided within two mean free times.
    assert!(warns(
        &case("2", "0.9"),
        &["engine.ed.contact_time is 2 mean free times", "98 %"]
    ));
    assert!(!warns(&case("0.01", "0.9"), &["contact_time"]));
    assert!(!warns(&case("2", "1"), &["contact_time is"]));
}

#[test]
fn gravity_that_nothing_holds_is_named() {
    let ed = "[gravity]\nacceleration = [0, -1]\n[engine.ed]\n";
    let held = "[walls]\nbottom = \"specular\"\ntop = \"specular\"\n";
    let along = "[gravity]\nacceleration = [1, 0]\n[engine.ed]\n";
    let rough = "[walls]\nbottom = { restitution = 0.9, slip = 0.5 }\ntop = { temperature = 1 }\n";
    assert!(warns(
        &flow("", ed),
        &["gravity.acceleration along y", "falls for ever"]
    ));
    assert!(!warns(&flow("", &format!("{held}{ed}")), &["for ever"]));
    // Smooth walls along the force hold nothing, rough ones do.
    assert!(warns(
        &flow("", &format!("{held}{along}")),
        &["gravity.acceleration along x"]
    ));
    assert!(!warns(&flow("", &format!("{rough}{along}")), &["for ever"]));
}

#[test]
fn kelvin_grams_and_millimetres_in_si_are_named() {
    let grains = |gas: &str| {
        format!(
            "format = 2\ntitle = \"grains\"\nunits = \"si\"\n[gas]\nnumber = 100\nrestitution = 0.9\n{gas}\n[box]\n\
             packing_fraction = 0.2\n[run]\nuntil = 1\n[engine.ed]\n"
        )
    };
    let kelvin = grains("diameter = 1e-3\nmass = 1e-6\ntemperature = 300");
    assert!(warns(
        &kelvin,
        &["gas.temperature = 300", "17321", "joules, not kelvin"]
    ));
    let joules = grains("diameter = 1e-3\nmass = 1e-6\ntemperature = 1e-9");
    // Cases without a warning: argon at 300 K, a molecular gas, and a speed that is given
    // explicitly.
    let argon = grains("diameter = 3.4e-10\nmass = 6.63e-26\ntemperature = 4.14e-21");
    let meant = grains("diameter = 1e-3\nmass = 1e-6\nrms_speed = 1000");
    for sane in [&joules, &argon, &meant] {
        assert!(!warns(sane, &["units = \"si\""]), "{sane}");
    }
    let millimetres = grains("diameter = 1\nmass = 1e-6\ntemperature = 1e-9");
    assert!(warns(&millimetres, &["density", "metres"]));
    let shaken = joules.replace(
        "packing_fraction = 0.2\n",
        "size = [0.05, 0.05]\n[walls]\nbottom = { restitution = 0.9, vibration = { amplitude = 1e-3, period = 1e-6 } }\ntop = \"specular\"\n",
    );
    assert!(warns(&shaken, &["walls.bottom moves at 2000 m/s"]));
}

/// A guess refuses cases that engines refuse, in the same words, with exit code 2.
#[test]
fn a_guess_refuses_what_a_run_refuses() {
    let narrow = "format = 2\ntitle = \"a channel\"\n[gas]\nnumber = 20\nrestitution = 0.9\n[box]\nsize = [40, 2.5]\n[walls]\n\
                  bottom = \"specular\"\ntop = \"specular\"\n[run]\nuntil = 1\n[engine.dsmc-contact-point]\n";
    let flat = "format = 2\ntitle = \"no room\"\n[gas]\nnumber = 20\ndiameter = 1\nrestitution = 0.9\n[box]\nsize = [400, 0.9]\n[walls]\n\
                bottom = \"specular\"\ntop = \"specular\"\n[run]\nuntil = 1\n[engine.ed]\n";
    let thin = "format = 2\ntitle = \"thin\"\n[gas]\nnumber = 100\nrestitution = 0.9\n[box]\npacking_fraction = 1e-13\n[run]\nuntil = 1\n\
                [engine.ed]\n";
    for (text, words) in [
        (narrow, ["engine.dsmc-contact-point", "3 or more"]),
        (flat, ["engine.ed", "room for 0.9"]),
        (thin, ["engine.ed", "cells between two collisions"]),
    ] {
        let work = TestFolder::new(text);
        for line in [
            "check case.toml --no-timing",
            "check case.toml",
            "run case.toml --out out",
        ] {
            work.refused(line, &words);
        }
        assert!(!work.path("out").exists());
    }
    // Random placement may fail only when particles are placed.
    let full = "format = 2\ntitle = \"full\"\nreplicas = 1\n[gas]\nnumber = 310\nrestitution = 0.9\n[box]\nsize = [20, 20]\n[walls]\n\
                bottom = \"specular\"\ntop = \"specular\"\n[run]\nuntil = 1\n[engine.ed]\n";
    let work = TestFolder::new(full);
    work.refused("check case.toml", &["finds no place"]);
    assert_eq!(work.say("run case.toml --out out").code, Some(2));
}

#[test]
fn a_guess_says_what_it_does_not_know() {
    let unknown = |text: &str| lines(text, "not in the guess:");
    let species = "format = 2\ntitle = \"sizes\"\n[gas]\nrestitution = 0.9\n[[species]]\nnumber = 100\n[[species]]\nnumber = 5\ndiameter = 10\n\
                   [box]\npacking_fraction = 0.2\n[run]\nuntil = 1\n[engine.ed]\n";
    assert!(unknown(species)[0].contains("by a factor of 10"));
    let walls = "[walls]\ntop = \"specular\"\nbottom = ";
    let still = flow("", &format!("{walls}\"specular\"\n[engine.ed]\n"));
    assert!(unknown(&still).is_empty(), "{:?}", unknown(&still));
    let heavy = still.replace(
        "[engine.ed]",
        "[gravity]\nacceleration = [0, -100]\n[engine.ed]",
    );
    assert!(unknown(&heavy)[0].contains("gravity"));
    let wall = "{ restitution = 0.9, vibration = { amplitude = 1, period = 0.02 } }";
    let fast = still.replace("bottom = \"specular\"", &format!("bottom = {wall}"));
    assert!(
        unknown(&fast)[0].contains("walls.bottom: it moves at 100 thermal speeds"),
        "{:?}",
        unknown(&fast)
    );
    let hot = still.replace("bottom = \"specular\"", "bottom = { temperature = 100 }");
    assert!(unknown(&hot)[0].contains("100 times as hot"));
}

/// Bundled cases have no warnings of implausible settings.
#[test]
fn bundled_cases_are_plausible() {
    for case in ["luding-1998", "vibrated-box"] {
        let work = TestFolder::new("");
        let said = work
            .done(&format!("check {CASES}/{case}.toml --no-timing"))
            .out;
        for word in ["falls for ever", "contact_time is", "units = \"si\""] {
            assert!(!said.contains(word), "{case}: {said}");
        }
    }
}

/// Disks that fall onto a floor and come to rest collide ever more often. The run ends with the
/// particles, the place and the remedy.
#[test]
fn a_bed_that_comes_to_rest_ends() {
    let bed = "format = 2\ntitle = \"a bed\"\nreplicas = 1\n[gas]\nnumber = 50\nrestitution = 0.5\n[box]\nsize = [10, 20]\n[walls]\n\
               bottom = { restitution = 0.5 }\ntop = { restitution = 0.5 }\n[gravity]\nacceleration = [0, -1]\n[run]\nuntil = 1000\n\
               [engine.ed]\ncontact_time = 1e-3\n";
    let work = TestFolder::new(bed);
    let said = work.say("run case.toml --out out");
    assert_eq!(said.code, Some(1), "{}", said.err);
    for word in [
        "collisions of a particle in a unit of time",
        "engine.ed.collision_rate_limit",
        "of 50 particles",
        "near (",
        "engine.ed.contact_time",
    ] {
        assert!(said.err.contains(word), "no {word:?} in {}", said.err);
    }
    assert!(work.path("out/snapshots/replica-0-ed.stopped.xyz").exists());
    // The limit is a key of the case.
    let said = work.say("run case.toml --out out --force --set engine.ed.collision_rate_limit=10 --set engine.ed.contact_time=1e-2");
    assert!(said.err.contains("allowed are up to 10 "), "{}", said.err);
}
