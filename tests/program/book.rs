//! The book: every page is in its summary, every link leads somewhere, and generated pages are
//! those that the program makes.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use crate::support::program::{COOLING, FLUCTUATIONS, LANGEVIN, MIXTURE, TestFolder, WALLS};

fn docs() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("docs")
}

/// Returns all pages of a folder and of those below it.
fn pages(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).expect("a folder").flatten() {
        let path = entry.path();
        if path.is_dir() {
            found.extend(pages(&path));
        } else if path.extension().is_some_and(|ending| ending == "md") {
            found.push(path);
        }
    }
    found.sort();
    found
}

/// Returns the targets of the links and pictures of a page, outside of code.
fn links(text: &str) -> Vec<String> {
    let mut found = Vec::new();
    let mut fenced = false;
    for line in text.lines() {
        if line.starts_with("```") {
            fenced = !fenced;
        }
        if fenced || line.starts_with("    ") {
            continue;
        }
        // Every other piece is inside backticks.
        for prose in line.split('`').step_by(2) {
            let parts = prose.split("](").skip(1);
            found.extend(parts.filter_map(|part| Some(part.split_once(')')?.0.to_owned())));
        }
        // Links whose text is code.
        let parts = line.split("`](").skip(1);
        found.extend(parts.filter_map(|part| Some(part.split_once(')')?.0.to_owned())));
    }
    found
}

/// Returns the name that a heading has in links.
fn anchor(heading: &str) -> String {
    let words = heading.trim_start_matches('#').trim().to_lowercase();
    let kept = words
        .chars()
        .filter(|c| c.is_alphanumeric() || " -_".contains(*c));
    kept.map(|c| if c == ' ' { '-' } else { c }).collect()
}

#[test]
fn every_link_leads_somewhere() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut all = pages(&docs());
    all.extend(["README.md", "CONTRIBUTING.md"].map(|name| root.join(name)));
    let mut checked = 0;
    let mut broken = Vec::new();
    for page in all {
        let text = fs::read_to_string(&page).expect("a page");
        for link in links(&text) {
            if link.contains("://") {
                continue;
            }
            checked += 1;
            let (file, part) = link.split_once('#').unwrap_or((&link, ""));
            let target = if file.is_empty() {
                page.clone()
            } else {
                page.parent().expect("a folder").join(file)
            };
            let whole = fs::read_to_string(&target).unwrap_or_default();
            let has = || {
                whole
                    .lines()
                    .any(|line| line.starts_with('#') && anchor(line) == part)
            };
            if !target.exists() || (!part.is_empty() && !has()) {
                broken.push(format!("{}: {link}", page.display()));
            }
        }
    }
    assert!(broken.is_empty(), "{broken:#?}");
    assert!(checked > 50, "{checked} links");
}

/// Links do not leave the folder of the book, where they would be dead.
#[test]
fn no_page_links_to_what_is_not_in_the_book() {
    let folder = docs();
    for page in pages(&folder) {
        let depth = page
            .strip_prefix(&folder)
            .map_or(0, |inside| inside.components().count() - 1);
        for link in links(&fs::read_to_string(&page).expect("a page")) {
            let up = link.matches("../").count();
            assert!(up <= depth, "{}: {link}", page.display());
        }
    }
}

/// Files that pages for developers name exist, also after files are moved.
#[test]
fn files_that_pages_for_developers_name_are_there() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut checked = 0;
    for page in [
        "CONTRIBUTING.md",
        "docs/extending.md",
        "docs/development/architecture.md",
    ] {
        let text = fs::read_to_string(root.join(page)).expect("a page");
        for line in text.lines().filter(|line| !line.starts_with("    ")) {
            let code = line.split('`').skip(1).step_by(2);
            let is_path = |word: &&str| word.contains('/') && !word.contains([' ', '-', '>']);
            for path in code
                .filter(is_path)
                .filter(|path| !path.starts_with("target"))
            {
                checked += 1;
                assert!(root.join(path).exists(), "{page}: {path}");
            }
        }
    }
    assert!(checked > 15, "{checked} paths");
}

#[test]
fn the_summary_has_every_page_once() {
    let folder = docs();
    let summary = fs::read_to_string(folder.join("SUMMARY.md")).expect("a summary");
    let listed = links(&summary);
    let set: BTreeSet<PathBuf> = listed.iter().map(|link| folder.join(link)).collect();
    assert_eq!(set.len(), listed.len(), "a page is listed twice");
    let there = pages(&folder)
        .into_iter()
        .filter(|page| !page.ends_with("SUMMARY.md"));
    assert_eq!(set, there.collect());
}

/// The index lists the pages of the summary, with the same titles and in the same order.
#[test]
fn the_index_is_that_of_the_book() {
    let read = |name: &str| fs::read_to_string(docs().join(name)).expect("a page");
    let (summary, index) = (read("SUMMARY.md"), read("README.md"));
    let listed: Vec<&str> = summary
        .lines()
        .filter_map(|line| line.strip_prefix("- "))
        .collect();
    let cells = index
        .lines()
        .filter_map(|line| line.strip_prefix("| ")?.split_once(" | "));
    let shown: Vec<&str> = cells
        .map(|cells| cells.0)
        .filter(|cell| cell.starts_with('['))
        .collect();
    assert_eq!(shown, listed);
    assert!(listed.len() > 20, "{} pages", listed.len());
}

#[test]
fn the_page_of_keys_is_that_of_the_program() {
    let said = TestFolder::new("").done("reference");
    let page = fs::read_to_string(docs().join("keys.md")).expect("a page");
    assert!(
        page == said.out,
        "docs/keys.md is not what `stosszahl reference` prints"
    );
    for key in [
        "gas.restitution",
        "species[].mass",
        "measure.frames.number",
        "engine.ed.contact_time",
    ] {
        assert!(page.contains(&format!("`{key}`")), "{key}");
    }
}

/// Tables of small runs of each kind have no column that the page lacks, or describes otherwise.
#[test]
fn the_page_of_columns_has_those_of_runs() {
    let page = fs::read_to_string(docs().join("columns.md")).expect("a page");
    let known: BTreeSet<&str> = page.lines().collect();
    for case in [COOLING, MIXTURE, WALLS, FLUCTUATIONS, LANGEVIN] {
        let work = TestFolder::new(case);
        work.done("run case.toml --quiet");
        let made = work.done("reference results/case").out;
        let rows = made
            .lines()
            .filter(|line| line.starts_with("| `") || line.starts_with("## "));
        let mut count = 0;
        for row in rows {
            count += 1;
            assert!(known.contains(row), "docs/columns.md lacks {row}");
        }
        assert!(count > 10, "{count} rows");
    }
}
