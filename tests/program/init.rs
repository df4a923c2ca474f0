//! `stosszahl init`: its cases can be checked and run, and invalid ones are not written.

use crate::support::program::Desk;

#[test]
fn what_is_written_passes_check_and_means_what_was_asked() {
    let desk = Desk::new("");
    for kind in ["comparison", "homogeneous", "channel"] {
        let line = format!(
            "init {kind}.toml --kind {kind} --number 400 --packing-fraction 0.2 --restitution 0.9,0.7 --until 12 --replicas 3"
        );
        let said = desk.done(&line);
        assert!(
            said.out.starts_with(&format!("{kind}.toml\n")),
            "{}",
            said.out
        );
        let text = desk.text(&format!("{kind}.toml"));
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
        let checked = desk.done(&format!("check {kind}.toml"));
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
    desk.done("init one.toml --number 200 --until 1 --replicas 2");
    assert!(!desk.text("one.toml").contains("[[sweep]]"));
    desk.done("run one.toml");
    assert!(desk.path("results/one/report.html").exists());
}

#[test]
fn what_cannot_be_is_refused_and_not_written() {
    let desk = Desk::new("");
    desk.refused(
        "init bad.toml --restitution 1.5",
        &["gas.restitution", "1.5"],
    );
    desk.refused("init bad.toml --packing-fraction 0", &["packing_fraction"]);
    desk.refused("init bad.toml --number 0", &["number"]);
    assert!(!desk.path("bad.toml").exists());
    desk.write("mine.toml", "keep");
    desk.refused("init mine.toml", &["mine.toml exists", "--force"]);
    assert_eq!(desk.text("mine.toml"), "keep");
    desk.done("init mine.toml --force");
    assert!(desk.text("mine.toml").contains("[engine.ed]"));
    desk.refused(
        "init absent/mine.toml/x/y.toml --kind wrong",
        &["wrong", "comparison"],
    );
}
