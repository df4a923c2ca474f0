//! Results on pages: each block is there and of the statistics of today, and what is wrong in one is found.

use std::fs;
use std::path::Path;

use stosszahl_trials::docs::{ENTRIES, Head, ROOT, Results, faults, find, replace, stale};

#[test]
fn every_block_stands_on_its_page() {
    for entry in ENTRIES {
        let page = fs::read_to_string(Path::new(ROOT).join(entry.file)).expect("a page");
        assert_eq!(stale(&page, entry), [""; 0], "{}", entry.name);
        let block = find(&page, entry.name).expect("a block");
        assert!(block.text.lines().count() > 1, "{}", entry.name);
        assert_ne!(block.head.commit, "unknown", "{}", entry.name);
    }
    // Nor is there a block that no entry makes.
    for file in ["README.md", "docs/paired-case.md"] {
        let page = fs::read_to_string(Path::new(ROOT).join(file)).expect("a page");
        let known = ENTRIES.iter().filter(|entry| entry.file == file).count();
        assert_eq!(page.matches("<!-- docs ").count(), known, "{file}");
    }
}

/// A small form of a case is run twice: the same bytes. Then a number is changed by twenty of its errors, the version of an engine, and
/// a word.
#[test]
fn a_planted_number_is_found() {
    let entry = ENTRIES
        .iter()
        .find(|entry| entry.name == "quick")
        .expect("it");
    let folder = tempfile::tempdir().expect("a folder");
    let run = |name: &str| {
        let set = ["gas.number=60", "replicas=3"].map(str::to_owned);
        let done = Results::of(entry.case, &set, &folder.path().join(name), false, "c0ffee");
        let (results, commit) = done.expect("a run");
        assert_eq!(commit, "c0ffee");
        results
    };
    let (first, second) = (run("first"), run("second"));
    let made = (entry.make)(&first).expect("a block");
    assert_eq!(made, (entry.make)(&second).expect("a block"));

    let head = Head {
        name: entry.name.into(),
        commit: "c0ffee".into(),
        date: "2026-11-23".into(),
        statistics: entry.statistics(),
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
    let word = page.replace("free volume", "free lunch");
    assert_eq!(faults(&word, entry, &second).expect("results").len(), 1);

    let version = entry.statistics()[1].1;
    let later = page.replace(&format!("dsmc={version}"), &format!("dsmc={}", version + 1));
    assert_eq!(stale(&later, entry).len(), 1);
    assert_eq!(stale("", entry).len(), 1);
}
