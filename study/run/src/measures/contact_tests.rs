//! Elastic twins and contact values of tiny gases, against slow computations.

use stosszahl_model::{Budget, Collision, Observer};
use stosszahl_results::{Cell, Table};

use super::tests::{case, measure, number, run, start};
use crate::plan::Plan;

const COOLING: &str = r#"
    format = 2
    title = "a cooling gas"
    replicas = 1
    gas = { number = 100, restitution = 0.7 }
    box = { packing_fraction = 0.3 }
    run = { until = 1.5, samples_per_decade = 6 }
    engine = { ed = {}, dsmc-boltzmann = {} }
    measure.contacts = { windows = [[0, 0.5], [0.5, 1.5], [0, 1.5]] }
"#;

/// Number in a column of the row of `chaos.csv` of an engine, window and quantity.
fn chaos(table: &Table, engine: &str, window: [f64; 2], quantity: &str, column: &str) -> f64 {
    let is = |row: usize, column: &str, wanted: &str| {
        let at = table.find(column).expect("a column");
        table.rows[row][at] == Cell::Text(wanted.to_owned())
    };
    let row = (0..table.rows.len()).find(|&row| {
        is(row, "engine", engine)
            && is(row, "quantity", quantity)
            && number(table, row, "window_start") == window[0]
            && number(table, row, "window_end") == window[1]
    });
    number(table, row.expect("a row"), column)
}

/// Last partner of each particle, for a slow count of collisions between the same two.
struct LastPartners {
    last: Vec<Option<u32>>,
    again: u64,
    all: u64,
}

impl Observer for LastPartners {
    fn collisions(&mut self, batch: &[Collision]) {
        for collision in batch {
            let [i, j] = collision.pair;
            let known = self.last[i as usize] == Some(j) && self.last[j as usize] == Some(i);
            self.again += u64::from(known);
            self.all += 1;
            self.last[i as usize] = Some(j);
            self.last[j as usize] = Some(i);
        }
    }
}

/// Collisions of the twin, and how many of them are again of the same two: as many as an elastic
/// run from the same start has.
fn expected_again(plan: &Plan, collisions: f64) -> f64 {
    let count = plan.count();
    let streams = stosszahl_model::random::Streams::new(plan.case.seed, 0);
    let mut gas = stosszahl_ed::simulate(
        &plan.grains,
        stosszahl_ed::Dissipation::Elastic,
        &plan.exact_boundaries(streams).expect("no walls"),
        &start(plan, 0),
    )
    .expect("exact disks");
    let mut seen = LastPartners {
        last: vec![None; count],
        again: 0,
        all: 0,
    };
    let budget = Budget::Collisions((0.5 * collisions * count as f64).round() as u64);
    gas.advance(f64::INFINITY, budget, &mut seen)
        .expect("it goes on");
    seen.again as f64 / seen.all as f64
}

/// The twin has as many collisions as the gas, within the spread of a Poisson number between two
/// samples; and those of an elastic run from the same start, also across a checkpoint. Windows that
/// touch add up to their union.
#[test]
fn elastic_twin_is_an_elastic_run_from_the_same_start() {
    let plan = case(COOLING);
    let (tables, _, _) = run(&plan, measure("contacts"));
    let table = &tables[0];
    let both = [[0.0, 0.5], [0.5, 1.5]];
    let whole = [0.0, 1.5];
    let of = |window, quantity, column| chaos(table, "ed", window, quantity, column);
    let (own, twin) = (
        of(whole, "collisions", "value"),
        of(whole, "collisions", "value_elastic"),
    );
    assert!(own > 4.0, "{own} collisions of each");
    // Pair collisions are half as many as those of 100 disks: five roots of their number.
    let spread = 5.0 * (50.0 * own).sqrt() / 50.0;
    assert!((own - twin).abs() < spread, "{own} {twin}");
    let parts: f64 = both
        .map(|one| of(one, "collisions", "value_elastic"))
        .iter()
        .sum();
    assert!((parts - twin).abs() < 1e-12 * twin, "{parts} {twin}");
    let again = of(whole, "again", "value_elastic");
    assert!(
        (again - expected_again(&plan, twin)).abs() < 1e-12,
        "{again}"
    );
    assert!(again > 0.0);
    assert_ne!(again, of(whole, "again", "value"));
    // Elastic normal speeds are the same before and after; those of the gas are not.
    let [before, after] = ["before_2", "after_2"].map(|moment| of(whole, moment, "value_elastic"));
    assert!((before - after).abs() < 1e-12 * before, "{before} {after}");
    // Monte Carlo has no twin.
    let none = chaos(table, "dsmc-boltzmann", whole, "again", "value_elastic");
    assert!(none.is_nan());
}

/// No twin of a gas that is elastic itself, and none on request.
#[test]
fn twins_can_be_left_out() {
    let elastic = COOLING.replace("restitution = 0.7", "restitution = 1");
    let without = COOLING.replace("{ windows", "{ elastic_twin = false, windows");
    for text in [elastic, without] {
        let (tables, _, _) = run(&case(&text), measure("contacts"));
        let column = tables[0].find("value_elastic").expect("a column");
        assert!(tables[0].rows.iter().all(|row| row[column] == Cell::Empty));
    }
}

/// Both parts of the contact value are in the ratio of the restitution, and the flux of the twin is
/// that of a plain sum of 1/g over its norm. The rate is that of the collisions in the log.
#[test]
fn contact_values_are_those_of_the_collisions() {
    let plan = case(&COOLING.replace(", dsmc-boltzmann = {}", ""));
    let (tables, _, log) = run(&plan, measure("contacts"));
    let table = &tables[1];
    assert_eq!(table.name, "contact_values");
    let row = 2;
    let of = |column: &str| number(table, row, column);
    let [before, after, total] = ["approaching", "separating", "contact_value"].map(of);
    assert!((after - before / 0.7).abs() < 1e-12 * after);
    assert!((total - before - after).abs() < 1e-12 * total);
    assert_eq!(of("collisions"), log.collisions.len() as f64);
    // The integral of sqrt(T), collision by collision.
    let temperature = |state: &[stosszahl_model::Particle]| {
        let squares = state
            .iter()
            .map(|one| one.mass * one.velocity.norm_squared());
        squares.sum::<f64>() / (2.0 * state.len() as f64)
    };
    let (mut now, mut last, mut exposure, mut sum) = (temperature(&log.states[0].1), 0.0, 0.0, 0.0);
    let count = plan.count() as f64;
    for collision in &log.collisions {
        exposure += now.sqrt() * (collision.time - last);
        sum += now.sqrt() / collision.approach();
        now -= collision.energy_lost() / count;
        last = collision.time;
    }
    exposure += now.sqrt() * (plan.engine_time(1.5) - last);
    let pairs = 0.5 * count * (count - 1.0);
    let norm = pairs / plan.volume * std::f64::consts::TAU * exposure;
    let rate = log.collisions.len() as f64 * std::f64::consts::PI.sqrt() / norm;
    let sonine = (count / (count - 1.0)).sqrt() * (1.0 - plan.fourth_cumulant() / 16.0);
    assert!((of("rate_contact_value") - rate / sonine).abs() < 1e-9 * rate);
    // The plain sum has the same mean, and differs by the pairs below the cut: one in thirteen, and
    // their spread is some 1.4 of the mean of all of them, a tail of 1/g beside it.
    let tolerance = 5.0 * 2.0 / (log.collisions.len() as f64).sqrt();
    assert!(
        (sum / norm / before - 1.0).abs() < tolerance,
        "{sum} {before}"
    );
}
