//! Frontier measured by several processes, against one: the tables are equal but for times.

use std::fs;
use std::path::Path;

use crate::support::{
    Scratch, appears, appears_like, done, ends, job, kill, processes, said, started, succeeds,
};

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

/// Returns the tables of a folder without the columns that times decide: the last three of the
/// front.
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
    // Of three, one stands still and one dies, once the first runs of the reference are kept;
    // others do what they had.
    let out = scratch.out("killed");
    let words = [&common[..], &more, &[&out, "--lost-after", "2"]].concat();
    let child = started(job(3, &["--enable-recovery"], &words));
    let ids = processes(&out, 3);
    appears_like(&out, "reference-");
    kill("-STOP", ids[1]);
    kill("-KILL", ids[2]);
    appears(&out, "frontier.html");
    kill("-KILL", ids[1]);
    let output = child.wait_with_output().expect("an end");
    ends(&output);
    let text = said(&output);
    for rank in [1, 2] {
        assert!(text.contains(&format!("rank {rank} is lost")), "{text}");
    }
    assert!(untimed(&out) == wanted, "{text}");
    // What the first process refuses ends all, and is said once.
    let words = [&common[..], &more, &[&alone, "--seed", "99"]].concat();
    let output = done(job(3, &[], &words));
    let text = said(&output);
    assert_eq!(output.status.code(), Some(2), "{text}");
    assert_eq!(text.matches("error:").count(), 1, "{text}");
}
