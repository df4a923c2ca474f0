//! Answers of a case to questions about its gas, by the tables that it has.

use std::path::Path;

use stosszahl_case::{Case, CaseFile};

fn case(tables: &str) -> Case {
    let text = format!("format = 2\ntitle = \"a gas\"\n[run]\nuntil = 1\n{tables}");
    let file = CaseFile::from_text(Path::new("case.toml"), &text, &[]);
    file.unwrap_or_else(|error| panic!("{}", error.report(false)))
        .points
        .remove(0)
        .case
}

/// Question of a case.
type Ask = fn(&Case) -> bool;

const INELASTIC: &str = "[gas]\nnumber = 10\nrestitution = 0.9\n";
const BOX: &str = "[box]\nsize = [9, 9]\n[engine.dsmc-boltzmann]\n";

#[test]
fn a_case_answers_by_its_tables() {
    let questions: [(&str, Ask); 6] = [
        ("box", Case::has_box),
        ("bounded", Case::is_bounded),
        ("uniform", Case::is_uniform),
        ("open", Case::is_open),
        ("rough", Case::is_rough),
        ("cools", Case::cools_freely),
    ];
    let open = "[walls]\nleft = \"open\"\nright = \"open\"\n";
    let body = "[[obstacle]]\ncircle = { centre = [4, 4], radius = 1 }\n";
    let pull = "[gravity]\nacceleration = [0, -1]\n";
    for (tables, yes) in [
        (format!("{INELASTIC}volume = 100\n"), "uniform cools"),
        (format!("{INELASTIC}{BOX}"), "box uniform cools"),
        (
            format!("{INELASTIC}tangential_restitution = 0\n{BOX}"),
            "box uniform rough cools",
        ),
        (format!("[gas]\nnumber = 10\n{BOX}"), "box uniform"),
        (
            format!("[gas]\nnumber = 10\ntangential_restitution = 1\n{BOX}"),
            "box uniform rough",
        ),
        (format!("{INELASTIC}{BOX}{pull}"), "box"),
        (format!("{INELASTIC}{BOX}{body}"), "box bounded"),
        (format!("{INELASTIC}{BOX}{open}"), "box bounded open"),
        (
            format!("{INELASTIC}[box]\nsize = [9, 9]\nshear_rate = 1\n[engine.ed]\n"),
            "box uniform",
        ),
        (
            format!(
                "[gas]\nnumber = 10\nrestitution = {{ coefficient = 0.9, delta = 0.1 }}\n{BOX}"
            ),
            "box uniform",
        ),
    ] {
        let found = case(&tables);
        let named = questions.iter().filter(|(_, ask)| ask(&found));
        let named: Vec<&str> = named.map(|one| one.0).collect();
        assert_eq!(named.join(" "), yes, "{tables}");
    }
}
