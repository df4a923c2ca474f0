//! One gas that several processes hold, against the same in one: the same tables.

mod support;

use std::path::Path;

use support::{Scratch, done, job, said, succeeds, tables};

/// A gas that flows into a channel.
const CHANNEL: &str = r#"
format = 2
title = "a channel"
replicas = 2
[gas]
dimension = 3
number = 20000
temperature = 0.5
restitution = 0.9
mean_free_path = 1
[box]
size = [16, 8, 0.25]
[walls]
left = "open"
right = "open"
bottom = { temperature = 0.5 }
top = { temperature = 0.5 }
[[inflow]]
face = "left"
velocity = [2.2567, 0, 0]
[start]
velocity = [2.2567, 0, 0]
[run]
until = 3
samples = 6
[engine.dsmc-boltzmann]
cell_size = 0.25
[measure.fields]
cells = [8, 4]
blocks = 3
"#;

/// Neighbourhoods of cells, and partners across cells.
const BOX: &str = r#"
format = 2
title = "a box"
replicas = 1
[gas]
number = 12000
restitution = 0.9
[box]
packing_fraction = 0.2
[start]
equilibration = 0
[run]
until = 4
samples = 3
[engine.dsmc-enskog]
[engine.dsmc-contact-point]
[measure.impact_parameters]
[measure.structure_factor]
"#;

#[test]
fn tables_are_the_same_bytes_for_any_number_of_processes() {
    for case in [CHANNEL, BOX] {
        let scratch = Scratch::new(case);
        let wanted = scratch.alone();
        for (ranks, threads) in [("1", "2"), ("2", "1"), ("3", "1")] {
            let out = scratch.out(ranks);
            let arguments = [
                "run",
                &scratch.case,
                "--one-gas",
                "--out",
                &out,
                "--threads",
                threads,
            ];
            let ranks = ranks.parse().expect("a number");
            succeeds(job(ranks, &[], &arguments));
            assert!(tables(Path::new(&out)) == wanted, "{ranks} ranks");
        }
    }
}

#[test]
fn refusals_end_all_processes() {
    let scratch = Scratch::new(&BOX.replace("restitution = 0.9", "restitution = 9"));
    let out = scratch.out("refused");
    let output = done(job(
        3,
        &[],
        &["run", &scratch.case, "--one-gas", "--out", &out],
    ));
    let text = said(&output);
    assert_eq!(output.status.code(), Some(2), "{text}");
    assert_eq!(text.matches("gas.restitution").count(), 1, "{text}");
}
