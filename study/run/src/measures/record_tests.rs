//! Files of single particles and collisions: of which replicas and engines, when, and in which
//! columns.

use std::path::Path;

use stosszahl_case::Case;
use stosszahl_model::Interrupt;
use stosszahl_results::{Snapshot, Table, TableCell};

use super::{collision_log::CollisionLog, snapshots::SnapshotMeasure};
use crate::control::Control;
use crate::engine_run::EngineRun;
use crate::measure::{CompletedRun, Measure, ReplicaRecords, share_of_others};
use crate::plan::CasePlan;

/// Both measures of one engine of a case without a prepared start, replica by replica.
fn run(text: &str) -> (CasePlan, Vec<CompletedRun>) {
    let text = format!("format = 2\ntitle = \"a test\"\n{text}");
    let case: Case = toml::from_str(&text).expect("a case");
    let plan = CasePlan::new(&case, Path::new(".")).expect("a plan");
    let measures: [&'static dyn Measure; 2] = [&SnapshotMeasure, &CollisionLog];
    for one in measures {
        one.check_options(&plan).expect("good options");
    }
    let follow = |replica| {
        let part = EngineRun {
            plan: &plan,
            engine: &plan.engines[0],
            measures: &measures,
            replica,
            start: None,
        };
        let stop = Interrupt::default();
        let control = Control::new(None, 1e9, &stop, &|_, _| {});
        part.run_engine(&control).expect("a run to its end")
    };
    let finished = (0..plan.case.replicas).map(follow).collect();
    (plan, finished)
}

fn runs(measure: usize, finished: &[Vec<CompletedRun>]) -> ReplicaRecords<'_> {
    ReplicaRecords {
        measure,
        level: 0.01,
        finished,
    }
}

fn files(plan: &CasePlan, finished: &[Vec<CompletedRun>]) -> Vec<(Snapshot, String)> {
    let files = SnapshotMeasure
        .snapshot_files(plan, &runs(0, finished))
        .into_iter();
    files
        .map(|(one, bytes)| (one, String::from_utf8(bytes).expect("text")))
        .collect()
}

fn log(plan: &CasePlan, finished: &[Vec<CompletedRun>]) -> Table {
    CollisionLog
        .result_tables(plan, &runs(1, finished))
        .remove(0)
}

fn numbers(table: &Table, name: &str) -> Vec<f64> {
    let column = table.find_column(name).expect("a column of this name");
    let number = |row: &Vec<TableCell>| match &row[column] {
        TableCell::Number(number) => *number,
        TableCell::Count(count) => *count as f64,
        other => panic!("{name} is {other:?}"),
    };
    table.rows.iter().map(number).collect()
}

/// Spheres of two kinds without positions, in three replicas.
const SPHERES: &str = "replicas = 3
[gas]
dimension = 3
volume = 3000
restitution = 0.8
[[species]]
number = 200
[[species]]
number = 100
mass = 4
[run]
until = 20
";

#[test]
fn velocities_of_a_gas_without_positions_are_csv() {
    let asked = "[measure.snapshots]\ninterval = 10\nreplicas = [0, 2]\n[measure.collision_log]\nmost = 50\nreplicas = [1]";
    let (plan, finished) = run(&format!("{SPHERES}{asked}"));
    let finished = [finished];
    let files = files(&plan, &finished);
    let found = files
        .iter()
        .map(|(one, _)| (&*one.file, one.replica, one.time));
    let expected = [
        ("snapshots/dsmc-homogeneous-0.csv", 0, 0.0),
        ("snapshots/dsmc-homogeneous-1.csv", 0, 10.0),
        ("snapshots/dsmc-homogeneous-2.csv", 0, 20.0),
        ("snapshots/dsmc-homogeneous-0-replica-2.csv", 2, 0.0),
        ("snapshots/dsmc-homogeneous-1-replica-2.csv", 2, 10.0),
        ("snapshots/dsmc-homogeneous-2-replica-2.csv", 2, 20.0),
    ];
    assert_eq!(found.collect::<Vec<_>>(), expected);
    assert!(files.iter().all(|(one, _)| !one.is_shown()));
    let energy = |text: &str| {
        let mut rows = text.lines();
        let names = "id,velocity_x,velocity_y,velocity_z,radius,mass,species";
        assert_eq!(rows.next(), Some(names));
        let row = |row: &str| {
            let numbers = row.split(',').map(|word| word.parse().expect("a number"));
            let row: Vec<f64> = numbers.collect();
            assert_eq!(row[5], 1.0 + 3.0 * row[6]);
            row[5] * row[1..4].iter().map(|one| one.powi(2)).sum::<f64>()
        };
        let all: Vec<f64> = rows.map(row).collect();
        assert_eq!(all.len(), 300);
        all.iter().sum::<f64>() / 900.0
    };
    let temperatures: Vec<f64> = files.iter().map(|(_, text)| energy(text)).collect();
    // A gas starts at exactly its temperature, and only loses energy; replicas differ.
    for own in temperatures.chunks(3) {
        assert!((own[0] - 1.0).abs() < 1e-12 && own[1] < 0.9 && own[2] < own[1]);
    }
    assert_ne!(temperatures[2], temperatures[5]);

    let log = log(&plan, &finished);
    assert_eq!(numbers(&log, "replica"), [1.0; 50]);
    let times = numbers(&log, "time");
    assert!(times.is_sorted() && times[0] > 0.0);
    // One replica of the two others, whose records are then kept.
    assert_eq!(share_of_others(&SnapshotMeasure, &plan), 0.5);
    assert_eq!(share_of_others(&CollisionLog, &plan), 0.5);
}

/// Simulators whose weights differ, between walls, with the quantities that are asked for; and
/// those of the log.
#[test]
fn simulators_of_a_flow_have_the_quantities_that_are_asked_for() {
    let flow = |snapshots: &str| {
        format!(
            "replicas = 2\n[gas]\nnumber = 400\nrestitution = 0.9\n[box]\nsize = [40, 20]\n\
             [walls]\nleft = {{ temperature = 1 }}\nright = {{ temperature = 4 }}\n\
             [engine.dsmc-boltzmann]\nsimulators_per_particle = 1\nweights = {{ along = \"x\", factors = [1, 0.5] }}\n[run]\nuntil = 5\n\
             [measure.snapshots]\ntimes = [5]\n{snapshots}\n[measure.collision_log]\nfrom = 2\nmost = 100000\nreplicas = \"all\""
        )
    };
    let head = |snapshots: &str| {
        let (plan, finished) = run(&flow(snapshots));
        let finished = [finished];
        let text = files(&plan, &finished).remove(0).1;
        let head = text.lines().nth(1).expect("two lines").to_owned();
        let (_, properties) = head.split_once("Properties=").expect("properties");
        let properties = properties.split(' ').next().expect("a word").to_owned();
        (properties, text, log(&plan, &finished))
    };
    let (properties, text, log) = head("");
    assert_eq!(
        properties,
        "id:I:1:pos:R:3:velo:R:3:radius:R:1:mass:R:1:weight:R:1"
    );
    let weights = text.lines().skip(2).map(|line| {
        let (_, last) = line.rsplit_once(' ').expect("several words");
        last.parse::<f64>().expect("a weight")
    });
    let mut weights: Vec<f64> = weights.collect();
    weights.sort_by(f64::total_cmp);
    weights.dedup();
    assert_eq!(weights, [0.5, 1.0]);

    let replicas = numbers(&log, "replica");
    assert!(replicas.is_sorted() && replicas.contains(&0.0) && replicas.contains(&1.0));
    let times = numbers(&log, "time");
    assert!(times.iter().all(|time| (2.0..=5.0).contains(time)));
    let columns = ["impact_parameter", "relative_speed", "normal_speed"];
    let [impact, relative, normal] = columns.map(|name| numbers(&log, name));
    for ((b, g), along) in impact.iter().zip(&relative).zip(&normal) {
        // Pythagoras, by rounding of some operations.
        assert!((b.powi(2) + (along / g).powi(2) - 1.0).abs() < 1e-13);
    }
    assert!(numbers(&log, "restitution").iter().all(|&one| one == 0.9));

    let (properties, ..) = head("quantities = [\"species\", \"angular-velocity\", \"velocity\"]");
    assert_eq!(
        properties,
        "id:I:1:pos:R:3:velo:R:3:angular_velocity:R:3:type:I:1"
    );
    assert_eq!(head("quantities = []").0, "id:I:1:pos:R:3");
}

#[test]
fn options_that_cannot_be_are_named() {
    let bad = |text: &str, measure: &dyn Measure| {
        let text = format!("format = 2\ntitle = \"a test\"\n{SPHERES}{text}");
        let case: Case = toml::from_str(&text).expect("a case");
        let plan = CasePlan::new(&case, Path::new(".")).expect("a plan");
        measure
            .check_options(&plan)
            .expect_err("it cannot be")
            .to_string()
    };
    for (options, expected) in [
        (
            "replicas = [0, 3]",
            "replicas.2: replicas from 0 to 2, or \"all\"",
        ),
        (
            "replicas = \"some\"",
            "replicas: a list of replicas, from 0, or \"all\"",
        ),
        (
            "engines = [\"ed\"]",
            "engines.1: engines of the case, dsmc-homogeneous",
        ),
        (
            "quantities = []",
            "quantities: one or more of a gas without positions",
        ),
        (
            "formats = [\"gsd\"]",
            "formats: a gas with positions; snapshots of one without are CSV",
        ),
    ] {
        let found = bad(&format!("[measure.snapshots]\n{options}"), &SnapshotMeasure);
        assert_eq!(found, expected);
    }
    for (options, expected) in [
        ("most = 0", "most: a number of collisions from 1 to 1000000"),
        (
            "replicas = [9]",
            "replicas.1: replicas from 0 to 2, or \"all\"",
        ),
    ] {
        let found = bad(
            &format!("[measure.collision_log]\n{options}"),
            &CollisionLog,
        );
        assert_eq!(found, expected);
    }
}
