//! Results on pages: each block exists and has the current statistics versions, and faults in a
//! block are found.

use std::fs;
use std::path::Path;

use stosszahl_trials::docs::{
    self, DATA, DataMaker, ENTRIES, EntrySource, Head, ROOT, ROWS_OF_A_PAGE, block_names, faults,
    find_block, generated_rows, is_open, outside, pages, replace, stale, stale_typed, strays,
    unfounded,
};

fn read(file: &str) -> String {
    fs::read_to_string(Path::new(ROOT).join(file)).expect("a page")
}

#[test]
fn every_block_stands_on_its_page() {
    let root = Path::new(ROOT);
    let mut all = Vec::new();
    for entry in ENTRIES {
        let page = read(entry.file);
        if is_open(&page, entry.name) {
            continue;
        }
        assert_eq!(stale(&page, entry), [""; 0], "{}", entry.name);
        let block = find_block(&page, entry.name).expect("a block");
        let is_short = matches!(entry.make, DataMaker::Data { .. });
        assert!(is_short || block.text.lines().count() > 1, "{}", entry.name);
        assert_eq!(
            unfounded(root, &page, entry.name),
            [""; 0],
            "{}",
            entry.name
        );
        assert_ne!(block.head.commit, "unknown", "{}", entry.name);
    }
    // Blocks that no entry makes, with their typed source.
    for file in pages(Path::new(ROOT)).expect("pages") {
        let page = read(&file);
        let names = block_names(&page);
        for (name, found) in stale_typed(&page) {
            assert_eq!(found, [""; 0], "{name} in {file}");
            assert_eq!(unfounded(root, &page, &name), [""; 0], "{name} in {file}");
        }
        for (place, name) in names.iter().enumerate() {
            assert!(!names[..place].contains(name), "{name} twice in {file}");
            let elsewhere = ENTRIES.iter().find(|entry| entry.name == name);
            assert!(elsewhere.is_none_or(|entry| entry.file == file), "{name}");
        }
        all.extend(names);
    }
    assert_eq!(strays(root, &all).expect("a folder"), [""; 0]);
}

/// Long tables are files. Rows of a block inside another count once.
#[test]
fn generated_tables_of_a_page_are_short() {
    for file in pages(Path::new(ROOT)).expect("pages") {
        let rows = generated_rows(&read(&file));
        assert!(rows <= ROWS_OF_A_PAGE, "{file}: {rows} rows");
    }
    let head = "<!-- docs a: commit c0ffee, date 2026-11-23, statistics ed=1 -->";
    let table = "| a |\n|---|\n| 1 |\n| 2 |\n";
    let page = format!("{table}\n{head}\n\n{table}\n{table}\n<!-- end of a -->\n");
    assert_eq!(generated_rows(&page), 4);
    let outer = "<!-- docs b: commit c0ffee, date 2026-11-23, statistics ed=1 -->";
    let nested = format!("{outer}\n\n{page}\n{table}\n<!-- end of b -->\n");
    assert_eq!(generated_rows(&nested), 8);
}

/// Plants another number in the file of a block, another text on its page, a file without a block,
/// and a damaged file.
#[test]
fn a_file_and_a_page_that_differ_are_found() {
    let folder = tempfile::tempdir().expect("a folder");
    let (root, name) = (folder.path(), "validation");
    let file = root.join(DATA).join("validation.csv");
    fs::create_dir_all(root.join(DATA)).expect("a folder");
    let (page, rows) = (read("docs/validation.md"), read("docs/data/validation.csv"));
    fs::write(&file, &rows).expect("a file");
    assert_eq!(unfounded(root, &page, name), [""; 0]);

    let found = unfounded(root, &page.replace("224 claims:", "225 claims:"), name);
    assert!(
        found.len() == 1 && found[0].contains("225 claims"),
        "{found:?}"
    );
    for (then, now, said) in [
        (",pass,", ",fail,", "stands there"),
        (",pass,", ",pass,,", "cells"),
        (",1.0,", ",one,", "a finite number"),
        ("quantity", "quality", "columns"),
    ] {
        fs::write(&file, rows.replacen(then, now, 1)).expect("a file");
        let found = unfounded(root, &page, name);
        assert!(
            found.len() == 1 && found[0].contains(said),
            "{now}: {found:?}"
        );
    }
    fs::remove_file(&file).expect("a file");
    assert_eq!(unfounded(root, &page, name).len(), 1);

    fs::write(&file, &rows).expect("a file");
    let none = strays(root, &[name.to_owned()]).expect("a folder");
    assert_eq!(none, [""; 0]);
    assert_eq!(strays(root, &[]).expect("a folder").len(), 1);
}

/// Finds numbers with an error outside of blocks; pages that explain a format show the sign alone.
#[test]
fn results_stand_in_blocks() {
    let is_result = |line: &str| {
        line.match_indices('±').any(|(at, sign)| {
            let digit = |text: Option<char>| text.is_some_and(|c| c.is_ascii_digit() || c == '.');
            digit(line[..at].trim_end().chars().last())
                && digit(line[at + sign.len()..].trim_start().chars().next())
        })
    };
    assert!(is_result("| 1.0 ± .2 |") && !is_result("`energy_ratio` ±T") && !is_result("a ± b"));
    for file in pages(Path::new(ROOT)).expect("pages") {
        let typed = outside(&read(&file));
        let found: Vec<&str> = typed.lines().filter(|line| is_result(line)).collect();
        assert_eq!(found, [""; 0], "outside of all blocks in {file}");
    }
}

/// Typed numbers are refused once an engine has another statistics version, or where no source is
/// stated.
#[test]
fn typed_numbers_are_of_the_engines_of_today() {
    let page =
        |line: &str| format!("<!-- docs own: {line} -->\n\n1.0 ± 0.1\n\n<!-- end of own -->\n");
    let faults = |line: &str| stale_typed(&page(line))[0].1.len();
    let of = "commit c0ffee, date 2026-11-23, statistics";
    assert_eq!(faults(&format!("{of} ed=1, typed from quick")), 0);
    assert_eq!(faults(&format!("{of} ed=0 dsmc=0, typed from quick")), 2);
    assert_eq!(faults(&format!("{of} ed=1")), 1);
    assert_eq!(faults("by hand"), 1);
}

/// Compares two runs of a small case: equal bytes. Then plants a number off by twenty errors,
/// another engine version, and another word.
#[test]
fn a_planted_number_is_found() {
    let entry = ENTRIES
        .iter()
        .find(|entry| entry.name == "quick")
        .expect("it");
    let EntrySource::Case(case) = entry.source else {
        panic!("a case");
    };
    let folder = tempfile::tempdir().expect("a folder");
    let run = |name: &str| {
        let set = ["gas.number=60", "replicas=3"].map(str::to_owned);
        let done = docs::run_bundled(case, &set, &folder.path().join(name), false, "c0ffee");
        let (results, commit) = done.expect("a run");
        assert_eq!(commit, "c0ffee");
        results
    };
    let (first, second) = (run("first"), run("second"));
    let made = entry.made(&first).expect("a block");
    assert_eq!(made, entry.made(&second).expect("a block"));

    let head = Head {
        name: entry.name.into(),
        commit: "c0ffee".into(),
        date: "2026-11-23".into(),
        statistics: entry.statistics(),
        typed: None,
    };
    let empty = "<!-- docs quick: to be made -->\n<!-- end of quick -->\n";
    let page = replace(empty, &head, &made.text).expect("a page");
    assert!(stale(&page, entry).is_empty());
    assert_eq!(faults(&page, entry, &second).expect("results"), [""; 0]);

    let row = made.text.lines().nth(2).expect("a row");
    let cell = row.split('|').nth(2).expect("a cell").trim();
    let (value, error) = cell.split_once(" ± ").expect("an error");
    let [value, error]: [f64; 2] = [value, error].map(|text| text.parse().expect("a number"));
    let planted = page.replace(cell, &format!("{:.4} ± {error:.4}", value + 20.0 * error));
    let found = faults(&planted, entry, &second).expect("results");
    assert!(found.len() == 1 && found[0].contains(cell), "{found:?}");
    let word = page.replace("contact point", "contact lens");
    assert_eq!(faults(&word, entry, &second).expect("results").len(), 1);

    let version = entry.statistics()[1].1;
    let later = page.replace(&format!("dsmc={version}"), &format!("dsmc={}", version + 1));
    assert_eq!(stale(&later, entry).len(), 1);
    assert_eq!(stale("", entry).len(), 1);
}
