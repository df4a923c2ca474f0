//! Numbers for users are in the units of the case: in messages, in snapshots and in the output of
//! `check`.

use crate::support::program::TestFolder;

/// Returns a case of disks that lose nearly all energy in each collision, in SI or in reduced
/// units.
fn collapsing(si: bool) -> String {
    let (head, gas, run) = if si {
        let gas = "diameter = 0.001\nmass = 1e-6\ntemperature = 1e-9\n";
        (
            "units = \"si\"\n",
            gas,
            "time_unit = \"case\"\nuntil = 1e6\n",
        )
    } else {
        ("", "", "until = 1000\n")
    };
    format!(
        "format = 2\ntitle = \"collapse of millimetre disks\"\nreplicas = 1\nseed = 4\n{head}[gas]\nnumber = 400\n\
         restitution = 0.1\n{gas}[box]\npacking_fraction = 0.3\n[run]\n{run}[engine.ed]\n"
    )
}

/// Returns the numbers after a word of a text.
fn numbers_after(text: &str, word: &str) -> Vec<f64> {
    let rest = text.split_once(word).map_or("", |(_, rest)| rest);
    rest.split(|c: char| !(c.is_ascii_digit() || ".e-".contains(c)))
        .filter_map(|number| number.trim_end_matches('.').parse().ok())
        .collect()
}

/// Returns the header of a snapshot.
fn header(text: &str) -> &str {
    text.lines().nth(1).expect("a header")
}

/// The collapse of one gas is reported in seconds and metres of a box 0.0324 m wide, or in cooling
/// times and diameters. Its cooling time is 1.6836 times that of a flight over a mean diameter at
/// thermal speed.
#[test]
fn a_collapse_is_told_in_the_units_of_the_case() {
    let [si, reduced] = [true, false].map(|si| {
        let work = TestFolder::new(&collapsing(si));
        let said = work.say("run case.toml --out out");
        assert_eq!(said.code, Some(1), "{}", said.err);
        let time = numbers_after(&said.err, "inelastic collapse at time ")[0];
        let place = numbers_after(&said.err, "near (");
        let state = work.text("out/snapshots/replica-0-ed.stopped.xyz");
        let lattice = numbers_after(header(&state), "Lattice=\"");
        (
            time,
            [place[0], place[1]],
            lattice,
            header(&state).to_owned(),
        )
    });
    // A thermal speed of sqrt(1e-9/1e-6) m/s and disks of 1 mm: one unit of the engine is 31.6 ms.
    // Messages have seven digits.
    let unit = 1e-3 / 1e-3_f64.sqrt();
    let ratio = si.0 / unit / reduced.0;
    assert!((ratio / 1.6836 - 1.0).abs() < 1e-3, "{si:?} {reduced:?}");
    for (metres, diameters) in si.1.into_iter().zip(reduced.1) {
        assert!(
            (metres - 1e-3 * diameters).abs() < 1e-7,
            "{metres} {diameters}"
        );
        assert!((0.0..0.0324).contains(&metres));
    }
    // The third vector of the lattice is a diameter long.
    assert!(
        (si.2[8] - 1e-3).abs() < 1e-15 && reduced.2[8] == 1.0,
        "{:?}",
        si.2
    );
    let over_t0 = numbers_after(&si.3, "TimeOverT0=")[0];
    assert!((over_t0 - reduced.0).abs() < 1e-6, "{over_t0}");
}

/// 10 units of time are 0.6113 times Haff's time of 16.358931, for any unit of the case; snapshots
/// of an elastic gas have none.
#[test]
fn times_of_snapshots_are_over_haffs_time() {
    let case = |restitution: f64, run: &str| {
        format!(
            "format = 2\ntitle = \"attributes of snapshots\"\nreplicas = 1\n[gas]\nnumber = 64\nrestitution = {restitution}\n\
             [box]\npacking_fraction = 0.2\n[run]\n{run}[engine.ed]\n"
        )
    };
    let header_of = |text: &str| {
        let work = TestFolder::new(text);
        work.done("run case.toml --out out");
        header(&work.text("out/snapshots/ed-0.xyz")).to_owned()
    };
    let cooling = header_of(&case(0.9, "time_unit = \"case\"\nuntil = 10\n"));
    let over_t0 = numbers_after(&cooling, "TimeOverT0=")[0];
    // Seven digits of Haff's time are given.
    assert!((over_t0 - 10.0 / 16.358_931).abs() < 1e-7, "{cooling}");
    assert!(
        (numbers_after(&cooling, " Time=")[0] - 10.0).abs() < 1e-12,
        "{cooling}"
    );
    let own = header_of(&case(0.9, "until = 0.5\n"));
    assert!(own.contains("TimeOverT0=0.5 "), "{own}");
    let elastic = header_of(&case(1.0, "until = 0.5\n"));
    assert!(!elastic.contains("TimeOverT0"), "{elastic}");
}

/// `check`, the manifest and the tables of a case in SI name metres, seconds and kilograms.
#[test]
fn cases_in_si_have_units_of_si() {
    let text = collapsing(true).replace("until = 1e6", "until = 0.01");
    let work = TestFolder::new(&text.replace("restitution = 0.1", "restitution = 0.9"));
    let said = work.done("check case.toml --no-timing").out;
    for line in said
        .lines()
        .filter(|line| line.starts_with("  ") && !line.contains(':'))
    {
        let unit = line.split_whitespace().last().expect("a word");
        assert!(
            !["length", "mass", "energy", "time"]
                .iter()
                .any(|word| unit.contains(word)),
            "{line}"
        );
    }
    let thermal = said.lines().find(|line| line.contains("thermal speed"));
    let thermal = thermal.expect("the thermal speed");
    assert!(thermal.contains("0.0316228 m/s"), "{thermal}");
    work.done("run case.toml --out out");
    let manifest = work.text("out/manifest.json");
    for word in [
        "\"unit\": \"length",
        "\"unit\": \"energy\"",
        "\"unit\": \"time\"",
    ] {
        assert!(!manifest.contains(word), "{word}");
    }
    assert!(manifest.contains("\"unit\": \"m\"") && manifest.contains("\"unit\": \"m/s\""));
}
