//! A release is one: manifests, changelog, citation and pages have one version, and everything that
//! is published says the same of itself.

use std::fs;
use std::path::Path;

use toml::Table;

fn text(file: &str) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(file);
    fs::read_to_string(path).unwrap_or_else(|error| panic!("{file}: {error}"))
}

fn table(file: &str) -> Table {
    text(file)
        .parse()
        .unwrap_or_else(|error| panic!("{file}: {error}"))
}

/// Returns the entry at a path of keys, as text.
fn entry<'a>(table: &'a Table, path: &str) -> &'a str {
    let mut keys = path.split('/');
    let first = table.get(keys.next().expect("a key"));
    keys.fold(first, |found, key| found.and_then(|found| found.get(key)))
        .and_then(|found| found.as_str())
        .unwrap_or_else(|| panic!("no text at {path}"))
}

/// Returns the value of a key of `CITATION.cff` at the left margin.
fn cited<'a>(citation: &'a str, key: &str) -> Option<&'a str> {
    let mut values = citation
        .lines()
        .filter_map(|line| line.strip_prefix(key)?.strip_prefix(':'));
    values.next().map(str::trim)
}

/// Returns the version of a heading of the changelog, and its date unless it is unreleased.
fn heading(line: &str) -> Option<(&str, Option<&str>)> {
    let (version, rest) = line.strip_prefix("## ")?.split_once(" (")?;
    let date = rest.strip_suffix(')')?;
    Some((version, (date != "unreleased").then_some(date)))
}

#[test]
fn manifests_changelog_and_citation_have_one_version() {
    let root = table("Cargo.toml");
    let version = entry(&root, "workspace/package/version");
    assert_eq!(version.split('.').count(), 3, "{version}");

    let changelog = text("CHANGELOG.md");
    let (newest, released) = changelog
        .lines()
        .find_map(heading)
        .expect("a heading like \"## 0.1.0 (unreleased)\"");
    assert_eq!(newest, version, "CHANGELOG.md");

    let citation = text("CITATION.cff");
    assert_eq!(cited(&citation, "version"), Some(version), "CITATION.cff");
    // A version that is not released has no date.
    assert_eq!(cited(&citation, "date-released"), released, "CITATION.cff");
    assert!(
        text("docs/citing.md").contains(&format!("stosszahl {version} ")),
        "docs/citing.md cites another version"
    );

    // Crates of the workspace depend on the version that is published with them.
    let shared = root["workspace"]["dependencies"].as_table();
    let ours = shared
        .into_iter()
        .flatten()
        .filter(|(name, _)| name.starts_with("stosszahl"));
    let mut count = 0;
    for (name, dependency) in ours {
        let wanted = dependency.get("version").and_then(|its| its.as_str());
        assert_eq!(wanted, Some(version), "{name} in Cargo.toml");
        count += 1;
    }
    assert!(count > 5, "{count} crates of the workspace");
    let distributed = table("distributed/Cargo.toml");
    let wanted = entry(&distributed, "dependencies/stosszahl/version");
    assert_eq!(wanted, version, "distributed/Cargo.toml");

    // The template asks for the newest compatible version.
    let template = table("examples/own-crate/Cargo.toml");
    let wanted = entry(&template, "dependencies/stosszahl/version");
    assert!(version.starts_with(&format!("{wanted}.")), "{wanted}");
}

#[test]
fn all_crates_say_the_same_of_themselves() {
    let root = table("Cargo.toml");
    let members = root["workspace"]["members"].as_array().expect("a list");
    let folders = members.iter().filter_map(|member| member.as_str());
    for folder in folders.chain(["."]) {
        let file = format!("{folder}/Cargo.toml");
        let manifest = table(&file);
        let package = &manifest["package"];
        for key in ["version", "edition", "rust-version", "license"] {
            let inherits = package.get(key).and_then(|its| its.get("workspace"));
            let inherits = inherits.and_then(toml::Value::as_bool);
            assert_eq!(inherits, Some(true), "{key} of {file}");
        }
        // Registries refuse a crate without a description.
        assert!(entry(&manifest, "package/description").len() > 10, "{file}");
        let name = entry(&manifest, "package/name");
        if package.get("publish").is_none() {
            let page = entry(&manifest, "package/documentation");
            assert_eq!(page, format!("https://docs.rs/{name}"), "{file}");
        }
    }

    let license = entry(&root, "workspace/package/license");
    let python = table("python/pyproject.toml");
    assert_eq!(entry(&python, "project/license"), license);
    assert_eq!(
        entry(&python, "project/description"),
        entry(&root, "package/description")
    );
    // The wheel has the version of its crate.
    let dynamic = python["project"]["dynamic"].as_array().expect("a list");
    assert!(dynamic.iter().any(|its| its.as_str() == Some("version")));
    let cited = format!("[{}]", license.replace(" OR ", ", "));
    assert!(text("CITATION.cff").contains(&format!("license: {cited}")));
    for file in ["LICENSE-MIT", "LICENSE-APACHE"] {
        assert!(text(file).len() > 500, "{file}");
    }

    let rust = entry(&root, "workspace/package/rust-version");
    for page in ["README.md", "docs/tutorial.md"] {
        let says = format!("{rust} or later");
        assert!(text(page).contains(&says), "{page} lacks \"{says}\"");
    }
}

/// The recipe of the container takes the toolchain that the manifest asks for, and copies what it has
/// built.
#[test]
fn the_container_has_what_it_builds() {
    let recipe = text("distributed/cluster/Containerfile");
    let root = table("Cargo.toml");
    let toolchain = entry(&root, "workspace/package/rust-version");
    assert!(
        recipe.contains(&format!("library/rust:{toolchain}-")),
        "{recipe}"
    );
    for program in ["stosszahl", "stosszahl-mpi"] {
        assert!(recipe.contains(&format!("-p {program}")), "{program}");
        let built = format!("/source/target/release/{program} ");
        assert!(recipe.contains(&built), "{program}");
    }
}
