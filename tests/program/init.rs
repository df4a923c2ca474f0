//! `stosszahl init`: its cases can be checked and run, and invalid ones are not written.

use crate::support::program::TestFolder;

#[test]
fn what_is_written_passes_check_and_means_what_was_asked() {
    let work = TestFolder::new("");
    for kind in ["comparison", "homogeneous", "channel"] {
        let line = format!(
            "init {kind}.toml --kind {kind} --number 400 --packing-fraction 0.2 --restitution 0.9,0.7 --until 12 --replicas 3"
        );
        let said = work.done(&line);
        assert!(
            said.out.starts_with(&format!("{kind}.toml\n")),
            "{}",
            said.out
        );
        let text = work.text(&format!("{kind}.toml"));
        // Each key has a comment, on its line or, for engines that explain themselves, above.
        let keys = text
            .lines()
            .filter(|line| line.contains(" = ") && !line.starts_with('#'));
        for line in
            keys.filter(|line| !line.contains("simulators") && !line.contains("temperature = 1.0"))
        {
            let explained =
                line.contains('#') || line.starts_with("title") || line.starts_with('"');
            assert!(
                explained || ["samples_per_decade = 10", "cells = [1, 20]"].contains(&line),
                "{line}"
            );
        }
        let checked = work.done(&format!("check {kind}.toml"));
        for word in [
            "2 points",
            "restitution=0.9",
            "restitution=0.7",
            "3 replicas",
        ] {
            assert!(
                checked.out.contains(word),
                "{kind}: {word} in {}",
                checked.out
            );
        }
    }
    // One value is no sweep; and the case runs.
    work.done("init one.toml --number 200 --until 1 --replicas 2");
    assert!(!work.text("one.toml").contains("[[sweep]]"));
    work.done("run one.toml");
    assert!(work.path("results/one/report.html").exists());
}

#[test]
fn what_cannot_be_is_refused_and_not_written() {
    let work = TestFolder::new("");
    work.refused(
        "init bad.toml --restitution 1.5",
        &["gas.restitution", "1.5"],
    );
    work.refused("init bad.toml --packing-fraction 0", &["packing_fraction"]);
    work.refused("init bad.toml --number 0", &["number"]);
    assert!(!work.path("bad.toml").exists());
    work.write("mine.toml", "keep");
    work.refused("init mine.toml", &["mine.toml exists", "--force"]);
    assert_eq!(work.text("mine.toml"), "keep");
    work.done("init mine.toml --force");
    assert!(work.text("mine.toml").contains("[engine.ed]"));
    work.refused(
        "init absent/mine.toml/x/y.toml --kind wrong",
        &["wrong", "comparison"],
    );
}
