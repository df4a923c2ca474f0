//! Starts that the user gives: start files and regions, in every box, and the messages about them.

use std::collections::BTreeSet;
use std::fmt::Write as _;

use stosszahl::study;

use crate::support::program::{Columns, TestFolder, format, overridden, plan};

/// Case of disks from a file; more tables may follow.
const FROM_FILE: &str = "format = 2\ntitle = \"a start of my own\"\nreplicas = 1\n[gas]\nrestitution = 0.9\n[start]\nplacement = \"file\"\n\
     file = \"start.csv\"\nvelocities = \"file\"\n[run]\ntime_unit = \"case\"\nuntil = 5\n[engine.ed]\n";

/// Returns positions and velocities of a snapshot of extended XYZ, without the index.
fn rows(text: &str) -> Vec<Vec<f64>> {
    let rows = text.lines().skip(2);
    let numbers = |row: &str| {
        let all = row.split_whitespace().skip(1);
        all.map(|one| one.parse().expect("a number")).collect()
    };
    rows.map(numbers).collect()
}

/// At t = 0 the gas is that of the file, but for what `check` says; the tolerance is two roundings
/// of numbers up to 10.
#[test]
fn a_start_file_with_velocities_is_the_start() {
    let written = [
        [1.0, 1.0, 1.0, 0.01],
        [5.0, 5.0, -1.0, 0.3],
        [-3.0, 7.0, 0.5, 0.5],
    ];
    let mut file = "# box: 10 10\nx,y,vx,vy\n".to_owned();
    for [x, y, vx, vy] in written {
        writeln!(file, "{x},{y},{vx},{vy}").expect("a string");
    }
    let boxed = format!("{FROM_FILE}[measure.snapshots]\ntimes = [0]\n[box]\n");
    let work = TestFolder::new(&boxed);
    work.write("start.csv", file);
    let said = work.done("check case.toml --no-timing").out;
    for words in [
        "mean velocity",
        "moved into it by whole sides: 1",
        "last digit",
    ] {
        assert!(said.contains(words), "{words}: {said}");
    }
    let said = work.done("run case.toml --out out").out;
    assert!(!said.contains("equilibr"), "{said}");
    let drift = [0, 1].map(|axis| written.iter().map(|row| row[2 + axis]).sum::<f64>() / 3.0);
    let check = |path: &str, drift: [f64; 2], inside: bool| {
        for (found, row) in rows(&work.text(path)).iter().zip(written) {
            let x = if inside {
                row[0].rem_euclid(10.0)
            } else {
                row[0]
            };
            let wanted = [x, row[1], row[2] - drift[0], row[3] - drift[1]];
            let found = [found[0], found[1], found[3], found[4]];
            for (found, wanted) in found.iter().zip(wanted) {
                assert!((found - wanted).abs() < 4e-15, "{found} {wanted}");
            }
        }
    };
    check("out/snapshots/ed-0.xyz", drift, true);
    // Between walls no position is changed.
    let walls = "[walls]\nleft = \"specular\"\nright = \"specular\"\nbottom = \"specular\"\ntop = \"specular\"\n";
    work.write("walls.toml", format!("{boxed}{walls}"));
    work.refused("run walls.toml --out walls", &["particle 2", "x = -3"]);
    work.write("start.csv", work.text("start.csv").replace("-3,7", "3,7"));
    let said = work.done("check walls.toml --no-timing").out;
    assert!(!said.contains("start.file:"), "{said}");
    work.done("run walls.toml --out walls");
    let text = work.text("walls/snapshots/ed-0.xyz");
    for (found, row) in rows(&text)
        .iter()
        .zip([written[0], written[1], [3.0, 7.0, 0.5, 0.5]])
    {
        assert_eq!([found[0], found[1], found[3], found[4]], row);
    }
}

/// Returns a start file of disks of two sizes on a grid with velocities of a Maxwellian, every
/// seventh large; `extra` is a further column.
fn two_sizes(extra: &str, value: impl Fn(bool) -> String) -> String {
    let mut text = format!("# box: 60 60\nx,y,vx,vy,radius,mass{extra}\n");
    for index in 0_u32..100 {
        let large = index % 7 == 3;
        let (radius, mass) = if large { (2.5, 25.0) } else { (0.5, 1.0) };
        let (x, y) = (6 * (index % 10) + 3, 6 * (index / 10) + 3);
        // Any velocities without a pattern will do.
        let angle = f64::from(index * index % 101);
        let (vx, vy) = (angle.cos() * 2.0, angle.sin());
        writeln!(text, "{x},{y},{vx},{vy},{radius},{mass}{}", value(large)).expect("a string");
    }
    text
}

/// Sizes and types of a file are species: theory and tables are those of the same gas by
/// `[[species]]`. The mean free time of a mixture is an exact sum, but the temperatures of the
/// species of a file are those of its velocities. With random velocities they are one, and the two
/// plans agree to rounding of sums of 100 numbers.
#[test]
fn species_of_a_file_are_species() {
    let drawn = FROM_FILE.replace("velocities = \"file\"\n", "");
    let work = TestFolder::new(&format!("{drawn}[box]\n"));
    work.write("start.csv", two_sizes("", |_| String::new()));
    let case = overridden(&work.path("case.toml"), &work.text("case.toml"), &[]);
    let mut planned = study::check_case(&case).expect("a plan");
    let found = planned.remove(0).plan;
    let twin = plan(
        "format = 2\ntitle = \"twin\"\n[gas]\nrestitution = 0.9\n[[species]]\nnumber = 86\n[[species]]\nnumber = 14\n\
         diameter = 5\nmass = 25\n[box]\nsize = [60, 60]\n[run]\nuntil = 1\n[engine.ed]\n",
        &[],
    );
    assert_eq!(found.gas.species.len(), 2);
    assert_eq!([0, 1].map(|k| found.gas.species[k].count), [86, 14]);
    for (found, twin) in [
        (found.clock.mean_free_time, twin.clock.mean_free_time),
        (found.clock.haff_time, twin.clock.haff_time),
        (found.gas.packing_fraction, twin.gas.packing_fraction),
        (found.scale.length, twin.scale.length),
    ] {
        assert!((found / twin - 1.0).abs() < 1e-13, "{found} {twin}");
    }
    assert_eq!(
        [2, 3, 4, 10].map(|index| found.species_of(index)),
        [0, 1, 0, 1]
    );
    // Types name species, in the order of numbers, and tables have a row for each; indices are
    // those of the file.
    let named = |large: bool| format!(",{}", if large { 7 } else { 11 });
    work.write("start.csv", two_sizes(",type", named));
    work.done("run case.toml --out out --set start.velocities=file --set run.until=2");
    let table = Columns::read(&work.path("out"), "species");
    let names: BTreeSet<&String> = table.texts("species").iter().collect();
    assert_eq!(names.into_iter().collect::<Vec<_>>(), ["1", "2"]);
    let known: Vec<String> = study::check_case(&overridden(
        &work.path("case.toml"),
        &work.text("case.toml"),
        &[],
    ))
    .expect("a plan")[0]
        .plan
        .gas
        .species
        .iter()
        .map(|one| one.name.clone())
        .collect();
    assert_eq!(known, ["7", "11"]);
    let last = rows(&work.text("out/snapshots/ed-0.xyz"));
    // The seventh and eighth number: mass, and the number of the species, which is 0 for type 7.
    assert!(last.iter().enumerate().all(|(index, row)| {
        let large = index % 7 == 3;
        (row[7] - if large { 25.0 } else { 1.0 }).abs() < 1e-13 && row[8] == f64::from(!large)
    }));
}

/// Continuous sizes are one species, with classes of like size for theory; the free time of one
/// mean disk would be off.
#[test]
fn continuous_sizes_of_a_file_are_classes() {
    let mut text = "# box: 90 90\nx,y,radius\n".to_owned();
    for index in 0..225 {
        let (x, y) = (6 * (index % 15) + 3, 6 * (index / 15) + 3);
        writeln!(text, "{x},{y},{}", 0.3 + 0.01 * f64::from(index)).expect("a string");
    }
    let work = TestFolder::new(&format!(
        "{}[box]\n",
        FROM_FILE.replace("velocities = \"file\"\n", "")
    ));
    work.write("start.csv", text);
    let case = work.path("case.toml");
    let file = format().read(&case, &[]).expect("a case");
    let planned = study::check_case(&file).expect("a plan");
    let plan = &planned[0].plan;
    assert_eq!(plan.gas.species.len(), 1);
    assert!(plan.gas.classes.len() > 12, "{}", plan.gas.classes.len());
    let counts: usize = plan.gas.classes.iter().map(|one| one.count).sum();
    assert_eq!(counts, 225);
}

/// Boxes and particles of another kind are refused, with the reason.
#[test]
fn open_boxes_and_spheres_are_no_periodic_disks() {
    let xyz = |pbc: &str, z: f64, vz: f64| {
        format!(
            "3\nLattice=\"10 0 0 0 10 0 0 0 10\" Properties=species:S:1:pos:R:3:velo:R:3 {pbc}\nA 1 1 3 1 0 0\n\
             A 5 1.2 {z} -1 0 {vz}\nA 8 8 3 0 1 0\n"
        )
    };
    let case = format!("{}[box]\n", FROM_FILE.replace(".csv", ".xyz"));
    let work = TestFolder::new(&case);
    for (text, words) in [
        (
            xyz("pbc=\"F F F\"", 3.0, 0.0),
            &["ends along x", "walls.left"][..],
        ),
        (
            xyz("pbc=\"T F T\"", 3.0, 0.0),
            &["ends along y", "walls.bottom"],
        ),
        (
            xyz("pbc=\"T T T\"", -2.0, 0.0),
            &["spheres", "z = -2", "gas.dimension = 3"],
        ),
        (xyz("", 3.0, 0.7), &["spheres", "vz = 0.7"]),
        (
            xyz("pbc=\"T T\"", 3.0, 0.0),
            &["start.xyz:2", "three of T and F"],
        ),
    ] {
        work.write("start.xyz", text);
        work.refused("run case.toml --out out", words);
        assert!(!work.path("out").exists());
    }
    work.write("start.xyz", xyz("pbc=\"T T F\"", 3.0, 0.0));
    work.done("run case.toml --out out");
    // Spheres from a file, in an engine of spheres.
    work.write("start.xyz", xyz("pbc=\"T T T\"", -2.0, 0.7));
    let spheres = case.replace("[gas]", "[gas]\ndimension = 3").replace(
        "[engine.ed]",
        "[engine.dsmc-boltzmann]\nsimulators_per_particle = 1",
    );
    work.write(
        "spheres.toml",
        format!("{spheres}[measure.snapshots]\ntimes = [0]\n"),
    );
    work.done("run spheres.toml --out spheres");
    let found = rows(&work.text("spheres/snapshots/dsmc-boltzmann-0.xyz"));
    assert_eq!(found.len(), 3);
    // Order of simulators is the engine's own.
    let heights: Vec<f64> = found.iter().map(|row| row[2].round()).collect();
    assert_eq!(heights.iter().filter(|z| **z == 8.0).count(), 1);
}

/// Start files are read in a box with walls, gravity and a body, and refused where particles
/// overlap these.
#[test]
fn start_files_are_read_between_walls_and_bodies() {
    let walled = format!(
        "{}[box]\n[walls]\nbottom = {{ restitution = 0.9 }}\ntop = \"specular\"\n[gravity]\nacceleration = [0, -1]\n\
         [[obstacle]]\ncircle = {{ centre = [9, 5], radius = 1 }}\n[engine.dsmc-boltzmann]\nsimulators_per_particle = 1\n",
        FROM_FILE.replace("until = 5", "until = 0.5\nsamples = 4")
    );
    let work = TestFolder::new(&format!(
        "{walled}[measure.snapshots]\ntimes = [0]\n[measure.fields]\ncells = [2, 2]\nblocks = 2\n"
    ));
    let start =
        |x: f64, y: f64| format!("# box: 10 10\nx,y,vx,vy\n5,2,1,0\n2,7,0,-1\n{x},{y},0.5,1\n");
    for (x, y, words) in [
        (3.0, 0.4, &["particle 2", "walls.bottom", "0.1"][..]),
        (3.0, 9.6, &["particle 2", "walls.top"]),
        (9.0, 6.2, &["particle 2", "obstacle.1", "0.3"]),
        // Across the periodic side.
        (0.3, 5.0, &["particle 2", "obstacle.1", "0.2"]),
        (5.5, 2.0, &["disks 0 and 2", "overlap by 0.5"]),
        (3.0, 10.5, &["particle 2", "y = 10.5"]),
    ] {
        work.write("start.csv", start(x, y));
        work.refused("run case.toml --out out", words);
    }
    work.write("start.csv", start(0.6, 5.0));
    work.done("run case.toml --out out");
    for engine in ["ed", "dsmc-boltzmann"] {
        let mut found = rows(&work.text(&format!("out/snapshots/{engine}-0.xyz")));
        found.sort_by(|a, b| b[0].total_cmp(&a[0]));
        let all: Vec<[f64; 4]> = found
            .iter()
            .map(|row| [row[0], row[1], row[3], row[4]])
            .collect();
        assert_eq!(
            all,
            [
                [5.0, 2.0, 1.0, 0.0],
                [2.0, 7.0, 0.0, -1.0],
                [0.6, 5.0, 0.5, 1.0]
            ]
        );
    }
}

/// A gas in a region of the box, by every engine and in every kind of box.
#[test]
fn a_gas_starts_in_a_region() {
    let case = |dimension: u32, size: &str, region: &str, engines: &str, more: &str| {
        format!(
            "format = 2\ntitle = \"a region\"\nreplicas = 1\n[gas]\nnumber = 60\nrestitution = 0.9\ndimension = {dimension}\n\
             [box]\nsize = {size}\n[start]\nregion = {region}\n[run]\ntime_unit = \"case\"\nuntil = 0.1\n{engines}{more}\n\
             [measure.snapshots]\ntimes = [0]\n"
        )
    };
    let disks = "[engine.ed]\n[engine.dsmc-enskog]\nsimulators_per_particle = 3\n[engine.dsmc-boltzmann]\n[engine.dsmc-contact-point]\n";
    let walled = "[engine.ed]\n[engine.dsmc-boltzmann]\n[measure.fields]\ncells = [2, 2]\nblocks = 1\n[walls]\nleft = \"specular\"\n\
                  right = { temperature = 1 }\n[[obstacle]]\ncircle = { centre = [8, 10], radius = 2 }\n";
    for (dimension, engines, more) in [
        (2, disks, ""),
        (2, walled, ""),
        (
            3,
            "[engine.dsmc-boltzmann]\nsimulators_per_particle = 2\n",
            "",
        ),
    ] {
        let (size, region) = match dimension {
            2 => ("[30, 20]", "[[1, 2], [13, 18]]"),
            _ => ("[30, 20, 20]", "[[1, 2, 3], [13, 18, 7]]"),
        };
        let work = TestFolder::new(&case(dimension, size, region, engines, more));
        let said = work.done("run case.toml --out out").out;
        assert!(!said.contains("equilibr"), "{said}");
        let snapshots = std::fs::read_dir(work.path("out/snapshots")).expect("snapshots");
        for path in snapshots.map(|one| one.expect("a file").path()) {
            let text = std::fs::read_to_string(&path).expect("a snapshot");
            let exact = path.ends_with("ed-0.xyz");
            let margin = if exact { 0.5 } else { 0.0 };
            let found = rows(&text);
            assert!(found.len() >= 60);
            for row in found {
                let inside = [(1.0, 13.0), (2.0, 18.0)].iter().zip(&row);
                let mut inside = inside.map(|((low, high), x)| {
                    low + margin - 1e-12 <= *x && *x <= high - margin + 1e-12
                });
                assert!(inside.all(|one| one), "{}: {row:?}", path.display());
                assert!(dimension == 2 || (3.0..=7.0).contains(&row[2]), "{row:?}");
            }
        }
    }
    let work = TestFolder::new(&case(2, "[30, 20]", "[[1, 2], [13, 18]]", walled, ""));
    for (set, words) in [
        ("[[5, 2], [5, 18]]", &["start.region", "not empty"][..]),
        ("[[13, 2], [1, 18]]", &["start.region", "not empty"]),
        ("[[1, 2, 3], [13, 18, 4]]", &["start.region", "2 numbers"]),
        ("[[1, 2], [31, 18]]", &["start.region", "inside the box"]),
        ("[[-1, 2], [13, 18]]", &["start.region", "inside the box"]),
        (
            "[[1, 2], [1.8, 18]]",
            &["start.region", "a side of 0.8", "widest particle"],
        ),
        (
            "[[1, 2], [8, 12]]",
            &["start.region", "particles cover", "0.547"],
        ),
        (
            "[[7, 9], [9, 11]]",
            &["start.region", "bodies cover all of it"],
        ),
    ] {
        // Words of one shell argument have no blanks.
        let set = set.replace(' ', "");
        work.refused(
            &format!("run case.toml --out out --set start.region={set}"),
            words,
        );
        assert!(!work.path("out").exists());
    }
    work.refused(
        "run case.toml --set start.equilibration=5",
        &["start.equilibration", "spreads"],
    );
}
