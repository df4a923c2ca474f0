//! Figures for papers: files, sizes, and refusals that leave nothing behind.

use std::fs;

use crate::support::program::{COOLING, TestFolder, files};

/// Width and height of an SVG file \[mm\], and those of its view \[pt\].
fn sizes(svg: &str) -> ([f64; 2], [f64; 2]) {
    let attribute = |name: &str| {
        let (_, rest) = svg
            .split_once(&format!(" {name}=\""))
            .expect("an attribute");
        rest.split_once('"').expect("a value").0.to_owned()
    };
    let millimetres = ["width", "height"].map(|name| {
        let text = attribute(name);
        let number = text.strip_suffix("mm").expect("millimetres");
        number.parse().expect("a number")
    });
    let view: Vec<f64> = attribute("viewBox")
        .split(' ')
        .map(|part| part.parse().expect("a number"))
        .collect();
    assert_eq!(view[..2], [0.0, 0.0]);
    (millimetres, [view[2], view[3]])
}

#[test]
fn figures_are_listed_and_written() {
    let work = TestFolder::new(COOLING);
    work.done("run case.toml --out out --replicas 2 --until 2");
    let before = files(&work.path("out"));
    let listed = work.done("figure out").out;
    let names: Vec<&str> = (listed.lines())
        .map(|line| line.split_whitespace().next().expect("a name"))
        .collect();
    assert!(names.contains(&"energy"), "{listed}");
    assert!(listed.contains("Energy"), "{listed}");
    // The width is that of the columns, in millimetres and in points of 25.4/72 mm.
    for (options, width) in [
        ("", 86.0),
        ("--columns 1", 86.0),
        ("--columns 2", 178.0),
        ("--width 120.5", 120.5),
    ] {
        let said = work.done(&format!("figure out energy {options} --out new/energy.svg"));
        let ([across, down], view) = sizes(&work.text("new/energy.svg"));
        assert_eq!(across, width, "{options}");
        let points = [across, down].map(|length| length / 25.4 * 72.0);
        // Files have two decimals of a millimetre, 0.03 points, and two of a point.
        assert!(
            points.iter().zip(view).all(|(a, b)| (a - b).abs() < 0.03),
            "{points:?} {view:?}"
        );
        let told = format!("{across:.0} x {down:.0} mm");
        assert!(
            said.out.contains(&told) && said.out.contains("energy.svg"),
            "{}",
            said.out
        );
    }
    // Equal folders give equal bytes, in a file that is named after the figure.
    work.done("figure out energy");
    let bytes = fs::read(work.path("energy.pdf")).expect("a document");
    assert!(bytes.starts_with(b"%PDF-1."));
    work.done("figure out energy --format pdf --out energy.pdf");
    assert!(fs::read(work.path("energy.pdf")).expect("a document") == bytes);
    work.done("figure out --all --columns 2 --format svg --out all");
    let mut found: Vec<String> = fs::read_dir(work.path("all"))
        .expect("a folder")
        .map(|entry| {
            entry
                .expect("an entry")
                .file_name()
                .to_string_lossy()
                .into_owned()
        })
        .collect();
    found.sort();
    let mut expected: Vec<String> = names.iter().map(|name| format!("{name}.svg")).collect();
    expected.sort();
    assert_eq!(found, expected);
    assert_eq!(files(&work.path("out")), before);
}

#[test]
fn refused_figures_leave_nothing_behind() {
    let work = TestFolder::new(COOLING);
    work.done("run case.toml --out out --replicas 2 --until 2");
    work.write("file", "kept");
    for (line, words) in [
        (
            "figure out energie --out x.svg",
            &[
                "out: no figure is called energie (did you mean energy?)",
                "its figures are energy",
            ][..],
        ),
        (
            "figure out energy --columns 3 --out x.svg",
            &["--columns", "1..=2"],
        ),
        (
            "figure out energy --columns 0 --out x.svg",
            &["--columns", "1..=2"],
        ),
        (
            "figure out energy --width 59 --out x.svg",
            &["a width of 59 mm; allowed is 60 to 400 mm"],
        ),
        (
            "figure out energy --width NaN --out x.svg",
            &["a width of NaN mm; allowed is 60 to 400 mm"],
        ),
        (
            "figure out energy --width 100 --columns 1 --out x.svg",
            &["cannot be used with"],
        ),
        (
            "figure out energy --out x.png",
            &["--out x.png: the file of a figure ends in .svg or .pdf"],
        ),
        (
            "figure out energy --out x.svg --format pdf",
            &["x.svg", "as --format says"],
        ),
        ("figure out --all", &["--out"]),
        ("figure out --columns 1", &["NAME", "--all"]),
        ("figure out energy --all --out x", &["cannot be used with"]),
        (
            "figure no energy --out x.svg",
            &["no: neither manifest.json nor sweep.json"],
        ),
        ("figure no", &["no: neither manifest.json nor sweep.json"]),
        (
            "figure out energy --out file/x.svg",
            &["file/x.svg: cannot be written"],
        ),
    ] {
        let said = work.say(line);
        assert!(
            matches!(said.code, Some(1 | 2)) && said.out.is_empty(),
            "{line}: {:?} {}",
            said.code,
            said.out
        );
        for word in words {
            assert!(
                said.err.contains(word),
                "{line}: no {word:?} in {}",
                said.err
            );
        }
    }
    for none in ["x", "x.svg", "x.png", "x.pdf", "energy.pdf"] {
        assert!(!work.path(none).exists(), "{none}");
    }
    assert_eq!(work.text("file"), "kept");
    let help = work.done("figure --help").out;
    for word in ["86 mm", "178 mm", "--all", "8 points"] {
        assert!(help.contains(word), "{word}");
    }
}
