//! A frontier measured by several processes, against one: the same tables but for times.

mod support;

use std::fs;
use std::path::Path;

use support::{Scratch, done, job, said, succeeds};

const CASE: &str = r#"
format = 2
title = "a small gas"
seed = 3
replicas = 1
[gas]
number = 100
restitution = 0.8
[box]
packing_fraction = 0.25
[run]
until = 1
[engine.ed]
[engine.dsmc-contact-point]
"#;

/// The tables of a folder without what times decide: the last three columns of the front.
fn untimed(out: &str) -> (Vec<String>, Vec<u8>) {
    let text = fs::read_to_string(Path::new(out).join("frontier.csv")).expect("a table");
    let cut = |line: &str| line.rsplitn(4, ',').last().map(str::to_owned);
    let orders = fs::read(Path::new(out).join("orders.csv")).expect("a table");
    (text.lines().filter_map(cut).collect(), orders)
}

#[test]
fn a_frontier_is_the_same_for_any_number_of_processes() {
    let scratch = Scratch::new(CASE);
    let alone = scratch.out("alone");
    // No run is left out for lack of time: the budget is far above what they take.
    let common = [
        "frontier",
        &scratch.case,
        "--budget",
        "2s",
        "--target-error",
        "20%",
    ];
    let more = ["--tests", "2", "--threads", "1", "--out"];
    let words = [&["stosszahl"], &common[..], &more, &[&alone]].concat();
    let code = stosszahl::commands::execute(clap::Parser::parse_from(words));
    assert_eq!(code, std::process::ExitCode::SUCCESS);
    let wanted = untimed(&alone);
    assert!(wanted.0.len() > 50, "{}", wanted.0.len());
    for ranks in [1, 2, 3, 4] {
        let out = scratch.out(&ranks.to_string());
        succeeds(job(ranks, &[], &[&common[..], &more, &[&out]].concat()));
        assert!(untimed(&out) == wanted, "{ranks} ranks");
    }
    // What the first process refuses ends all, and is said once.
    let output = done(job(3, &[], &[&common[..], &more, &[&alone]].concat()));
    let text = said(&output);
    assert_eq!(output.status.code(), Some(2), "{text}");
    assert_eq!(text.matches("error:").count(), 1, "{text}");
}
