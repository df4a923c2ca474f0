//! Snapshots of the program as start files of the program, in every format, and tables in theirs.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use stosszahl::model::gsd::{Chunk, to_bytes};

use crate::support::program::TestFolder;

/// Disks of two sizes between walls, where the program changes no number of a start.
const WALLED: &str = "format = 2\ntitle = \"a start of every format\"\nreplicas = 1\n[gas]\nrestitution = 0.9\n[start]\n\
     placement = \"file\"\nfile = \"FILE\"\nvelocities = \"file\"\n[box]\n[walls]\nleft = \"specular\"\nright = \"specular\"\n\
     [run]\ntime_unit = \"case\"\nuntil = 1\nsamples = 2\n[engine.ed]\n[engine.dsmc-boltzmann]\nsimulators_per_particle = 1\n\
     [measure.fields]\ncells = [2, 2]\nblocks = 1\n[measure.snapshots]\ntimes = [0, 1]\nformats = [\"xyz\", \"lammps\", \"gsd\"]\n";

/// Returns the particles of a snapshot of extended XYZ: position, velocity, radius and mass, in the
/// order of their positions, as engines have orders of their own.
fn particles(text: &str) -> Vec<Vec<f64>> {
    let row = |line: &str| {
        let all = line.split(' ').skip(1).take(8);
        all.map(|one| one.parse().expect("a number")).collect()
    };
    let mut all: Vec<Vec<f64>> = text.lines().skip(2).map(row).collect();
    all.sort_by(|a, b| a[0].total_cmp(&b[0]));
    all
}

/// Snapshots in each format start all engines from the microstate that was written. Formats with all
/// digits give the same bits. GSD gives positions within 2^-24 of half a side of 40, and other numbers
/// within 2^-24 of themselves.
#[test]
fn every_format_is_the_same_start_for_all_engines() {
    let work = TestFolder::new(&WALLED.replace("FILE", "start.csv"));
    let mut csv = "# box: 40 40\nx,y,vx,vy,radius,mass,type\n".to_owned();
    for index in 0_u32..100 {
        let large = index % 7 == 3;
        let (radius, mass) = if large { (1.25, 25.0) } else { (0.4, 1.1) };
        let (x, y) = (4 * (index % 10) + 2, 4 * (index / 10) + 2);
        // Any numbers without a pattern will do.
        let angle = f64::from(index * index % 101);
        let (vx, vy) = (angle.cos() * 2.0, angle.sin());
        let (x, y) = (f64::from(x) + 0.3 * vx, f64::from(y) + 0.3 * vy);
        writeln!(
            csv,
            "{x},{y},{vx},{vy},{radius},{mass},{}",
            u32::from(large)
        )
        .expect("a string");
    }
    work.write("start.csv", &csv);
    work.done("run case.toml --out first");
    for ending in ["xyz", "dump", "gsd"] {
        let first = work.path(&format!("first/snapshots/ed-1.{ending}"));
        let case = WALLED.replace("FILE", &first.display().to_string());
        work.write("again.toml", case);
        let said = work.done("check again.toml --no-timing").out;
        assert_eq!(said.contains("2^-24"), ending == "gsd", "{said}");
        work.done(&format!("run again.toml --out {ending}"));
        let wanted = particles(&work.text("first/snapshots/ed-1.xyz"));
        for engine in ["ed", "dsmc-boltzmann"] {
            let found = particles(&work.text(&format!("{ending}/snapshots/{engine}-0.xyz")));
            assert_eq!(found.len(), 100);
            if ending != "gsd" {
                assert_eq!(found, wanted, "{ending} {engine}");
                continue;
            }
            let rounding = 0.5_f64.powi(24);
            for (found, wanted) in found.iter().zip(&wanted) {
                for (column, (found, wanted)) in found.iter().zip(wanted).enumerate() {
                    let most = if column < 3 { 20.0 } else { wanted.abs() };
                    assert!(
                        (found - wanted).abs() <= most * rounding,
                        "{found} {wanted}"
                    );
                }
            }
        }
    }
}

/// A shear flow is continued from its snapshots of any format, as the box above is displaced at the
/// start.
/// At t = 2 it is displaced by 0.45 * 20 * 2 = 18 of 30. The same collisions follow until t = 2.2, some
/// 0.4 for each disk; rounding of 1e-15 (6e-8 in GSD) of lengths and of units grows tenfold in each
/// collision of a disk, of which hardly one has more than three in this time.
#[test]
fn a_shear_flow_goes_on_from_its_snapshots() {
    let case = |start: &str, until: f64, times: &str| {
        format!(
            "format = 2\ntitle = \"a flow\"\nreplicas = 1\n[gas]\nrestitution = 0.9\n{start}\
             [run]\ntime_unit = \"case\"\nuntil = {until}\n[engine.ed]\n[engine.dsmc-enskog]\nsimulators_per_particle = 1\n\
             [measure.snapshots]\ntimes = {times}\nformats = [\"xyz\", \"lammps\", \"gsd\"]\n"
        )
    };
    let drawn = "number = 200\n[box]\nsize = [30, 20]\nshear_rate = 0.45\n";
    let work = TestFolder::new(&case(drawn, 2.2, "[2, 2.2]"));
    work.done("run case.toml --out first");
    let rows = |path: &str| -> Vec<Vec<f64>> {
        let text = work.text(path);
        let row = |line: &str| {
            line.split(' ')
                .map(|one| one.parse().expect("a number"))
                .collect()
        };
        text.lines().skip(2).map(row).collect()
    };
    let offset = |path: &str| -> f64 {
        let text = work.text(path);
        let (_, lattice) = text.split_once("Lattice=\"").expect("a lattice");
        let offset = lattice.split(' ').nth(3).expect("nine numbers");
        offset.parse().expect("a number")
    };
    assert!((offset("first/snapshots/ed-0.xyz") - 18.0).abs() < 1e-12);
    let before = rows("first/snapshots/ed-0.xyz");
    let after = rows("first/snapshots/ed-1.xyz");
    for (ending, rounding) in [("xyz", 1e-15), ("dump", 1e-15), ("gsd", 6e-8)] {
        let file = work.path(&format!("first/snapshots/ed-0.{ending}"));
        let start = |rate: &str| {
            format!(
                "[start]\nplacement = \"file\"\nfile = \"{}\"\nvelocities = \"file\"\n[box]\n{rate}",
                file.display()
            )
        };
        work.write(
            "again.toml",
            case(&start("shear_rate = 0.45\n"), 0.2, "[0, 0.2]"),
        );
        let said = work.done("check again.toml --no-timing").out;
        assert!(said.contains("the box above displaced by 18"), "{said}");
        work.done(&format!("run again.toml --out {ending}"));
        for (engine, number, wanted, growth) in [
            ("ed", 0, &before, 1.0),
            ("dsmc-enskog", 0, &before, 1.0),
            ("ed", 1, &after, 1e3),
        ] {
            let path = format!("{ending}/snapshots/{engine}-{number}.xyz");
            let slid = offset(&path);
            let expected = 18.0 + 9.0 * 0.2 * f64::from(number);
            let tolerance: f64 = 100.0 * rounding * growth;
            assert!(
                (slid - expected).abs() < tolerance.max(1e-12),
                "{path}: {slid}"
            );
            let mut found = rows(&path);
            if engine != "ed" {
                // Order of simulators is the engine's own.
                let mut order = wanted.clone();
                order.sort_by(|a, b| a[2].total_cmp(&b[2]));
                found.sort_by(|a, b| a[2].total_cmp(&b[2]));
                for (found, wanted) in found.iter().zip(&order) {
                    assert!((found[2] - wanted[2]).abs() < tolerance, "{path}");
                }
                continue;
            }
            assert_eq!(found.len(), 200);
            for (found, wanted) in found.iter().zip(wanted) {
                let mut away = found[1] - wanted[1];
                away -= 30.0 * (away / 30.0).round();
                let other = (2..=6).map(|column| (found[column] - wanted[column]).abs());
                let worst = other.fold(away.abs(), f64::max);
                assert!(worst < tolerance, "{path}: {found:?} {wanted:?}");
            }
        }
        // Without the flow the box is refused, and so are elastic collisions in a box at rest.
        work.write("rest.toml", case(&start(""), 1.0, "[1]"));
        work.refused("run rest.toml --out rest", &["tilted by", "box.shear_rate"]);
        work.refused(
            "run again.toml --out rest --set start.equilibration=5",
            &["start.equilibration", "displaced by 18"],
        );
        assert!(!work.path("rest").exists());
    }
}

/// Disks that overlap by the rounding of single precision are moved apart, and said to be; those that
/// overlap by more are refused. Twice 2^-24 of a box of 40 is 4.8e-6.
#[test]
fn disks_that_single_precision_makes_overlap_are_moved_apart() {
    let file = |overlap: f64| {
        let places = [
            -1.0,
            0.0,
            0.0,
            -overlap,
            0.0,
            0.0,
            1.0 - 2.0 * overlap,
            0.0,
            0.0,
        ];
        let frame = vec![
            Chunk::bytes("configuration/dimensions", [2]),
            Chunk::single("configuration/box", 1, [40.0, 40.0, 0.0, 0.0, 0.0, 0.0]),
            Chunk::counts("particles/N", [3]),
            Chunk::single("particles/position", 3, places),
            Chunk::single(
                "particles/velocity",
                3,
                [1.0, 0.5, 0.0, -0.5, 0.5, 0.0, -0.5, -1.0, 0.0],
            ),
        ];
        to_bytes("a test", ("hoomd", 1, 4), &[frame])
    };
    let case = "format = 2\ntitle = \"a dense start\"\nreplicas = 1\n[gas]\nrestitution = 0.9\n[start]\nplacement = \"file\"\n\
                file = \"start.gsd\"\nvelocities = \"file\"\n[box]\n[run]\ntime_unit = \"case\"\nuntil = 1\n[engine.ed]\n\
                [measure.snapshots]\ntimes = [0]\n";
    let work = TestFolder::new(case);
    work.write("start.gsd", file(1e-6));
    let said = work.done("check case.toml --no-timing").out;
    assert!(said.contains("moved apart: "), "{said}");
    work.done("run case.toml --out out");
    let found = particles(&work.text("out/snapshots/ed-0.xyz"));
    for pair in found.windows(2) {
        let distance = (pair[1][0] - pair[0][0]).hypot(pair[1][1] - pair[0][1]);
        assert!((-1e-9..2e-6).contains(&(distance - 1.0)), "{distance}");
    }
    work.write("start.gsd", file(1e-4));
    work.refused("run case.toml --out deep", &["overlap by", "at most touch"]);
    assert!(!work.path("deep").exists());
}

/// Returns all Parquet files of a results folder, by their path in it.
fn parquet_files(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut found = BTreeMap::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(one) = folders.pop() {
        for entry in std::fs::read_dir(one).expect("a folder") {
            let path = entry.expect("a file").path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|ending| ending == "parquet") {
                let name = path.strip_prefix(folder).expect("inside").to_owned();
                found.insert(name, std::fs::read(&path).expect("bytes"));
            }
        }
    }
    found
}

/// Formats of tables: CSV alone by default; Parquet next to it where the program knows it, and else an
/// error before anything is written.
#[test]
fn tables_are_parquet_too_if_asked() {
    let case = "format = 2\ntitle = \"a sweep\"\nreplicas = 2\n[gas]\nnumber = 50\nrestitution = 0.9\n[box]\npacking_fraction = 0.1\n\
                [run]\nuntil = 1\n[engine.ed]\n[[sweep]]\n\"gas.restitution\" = [0.9, 0.8]\n";
    let work = TestFolder::new(case);
    if cfg!(not(feature = "parquet")) {
        let words = ["--tables parquet", "--features parquet"];
        for more in ["", " --join", " --part 1/2"] {
            let line = format!("run case.toml --out out --tables parquet{more}");
            work.refused(&line, &words);
        }
        assert!(!work.path("out").exists());
        work.done("run case.toml --out out --tables csv");
        return;
    }
    work.done("run case.toml --out out");
    work.done("run case.toml --out out --resume --tables csv,parquet");
    work.done("run case.toml --out joined --join --tables parquet");
    for part in ["1/2", "2/2"] {
        let out = part.replace('/', "-");
        work.done(&format!(
            "run case.toml --out {out} --part {part} --tables parquet"
        ));
    }
    work.done("merge 1-2 2-2 --out merged --tables parquet");
    for folder in ["joined", "merged"] {
        assert_eq!(
            parquet_files(&work.path(folder)),
            parquet_files(&work.path("out"))
        );
    }
    assert!(parquet_files(&work.path("out")).contains_key(Path::new("sweep.parquet")));
    let mut points = 0;
    for point in std::fs::read_dir(work.path("out")).expect("a folder") {
        let point = point.expect("a file").path();
        if !point.join("manifest.json").exists() {
            continue;
        }
        points += 1;
        for file in std::fs::read_dir(&point).expect("a folder") {
            let file = file.expect("a file").path();
            if file.extension().is_some_and(|ending| ending == "csv") {
                let bytes = std::fs::read(file.with_extension("parquet")).expect("a file");
                assert!(bytes.starts_with(b"PAR1") && bytes.ends_with(b"PAR1"));
            }
        }
    }
    assert_eq!(points, 2);
    // They belong to the run, which another replaces.
    work.done("run case.toml --out out --force");
    let files = std::fs::read_dir(work.path("out")).expect("a folder");
    let inside = |point: PathBuf| std::fs::read_dir(point).into_iter().flatten();
    let mut all = files.flat_map(|one| inside(one.expect("a file").path()));
    assert!(!all.any(|file| {
        file.expect("a file")
            .path()
            .extension()
            .is_some_and(|ending| ending == "parquet")
    }));
}
