//! Elastic twins and contact values of tiny gases, against slow computations.

use stosszahl_analysis::contacts::MEMORY;
use stosszahl_model::{Budget, Collision, Observer};
use stosszahl_results::{Table, TableCell};

use super::tests::{case, measure, number, run, start};
use crate::plan::CasePlan;

const COOLING: &str = r#"
    format = 2
    title = "a cooling gas"
    replicas = 1
    gas = { number = 100, restitution = 0.7 }
    box = { packing_fraction = 0.3 }
    run = { until = 1.5, samples_per_decade = 6 }
    engine = { ed = {}, dsmc-boltzmann = { simulators_per_particle = 2, cell_size = 3 } }
    measure.contacts = { windows = [[0, 0.5], [0.5, 1.5], [0, 1.5]] }
"#;

/// Number in a column of the row of `chaos.csv` of an engine, window and quantity.
fn chaos(table: &Table, engine: &str, window: [f64; 2], quantity: &str, column: &str) -> f64 {
    let is = |row: usize, column: &str, wanted: &str| {
        let at = table.find_column(column).expect("a column");
        table.rows[row][at] == TableCell::Text(wanted.to_owned())
    };
    let row = (0..table.rows.len()).find(|&row| {
        is(row, "engine", engine)
            && is(row, "quantity", quantity)
            && number(table, row, "window_start") == window[0]
            && number(table, row, "window_end") == window[1]
    });
    let row = row.unwrap_or_else(|| {
        panic!(
            "no row of {engine}, {window:?}, {quantity}: {:?}",
            table.rows
        )
    });
    number(table, row, column)
}

/// All partners of each particle, for a slow count of collisions whose partners have met within
/// their last eight.
struct Partners {
    all: Vec<Vec<u32>>,
    returned: u64,
    collisions: u64,
}

impl Observer for Partners {
    fn on_collisions(&mut self, batch: &[Collision]) {
        for collision in batch {
            let [i, j] = collision.pair;
            let met = |who: u32, whom: u32| {
                let mut latest = self.all[who as usize].iter().rev().take(MEMORY);
                latest.any(|&other| other == whom)
            };
            self.returned += u64::from(met(i, j) && met(j, i));
            self.collisions += 1;
            self.all[i as usize].push(j);
            self.all[j as usize].push(i);
        }
    }
}

/// Share of collisions of partners that return, of an elastic run from the same start with
/// `collisions` per particle.
fn expected_returns(plan: &CasePlan, collisions: f64) -> f64 {
    let count = plan.count();
    let streams = stosszahl_model::random::Streams::new(plan.case.seed, 0);
    let mut gas = stosszahl_ed::simulate(
        &plan.gas.particles,
        stosszahl_ed::DissipationRule::Elastic,
        &plan.exact_boundaries(streams).expect("no walls"),
        &start(plan, 0),
    )
    .expect("exact disks");
    let mut seen = Partners {
        all: vec![Vec::new(); count],
        returned: 0,
        collisions: 0,
    };
    let budget = Budget::Collisions((0.5 * collisions * count as f64).round() as u64);
    gas.advance(f64::INFINITY, budget, &mut seen)
        .expect("it goes on");
    seen.returned as f64 / seen.collisions as f64
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
    let returned = of(whole, "returned", "value_elastic");
    let expected = expected_returns(&plan, twin);
    assert!((returned - expected).abs() < 1e-12, "{returned} {expected}");
    assert!(returned > 0.1);
    assert_ne!(returned, of(whole, "returned", "value"));
    // Elastic normal speeds are the same before and after; those of the gas are not.
    let [before, after] = ["before_2", "after_2"].map(|moment| of(whole, moment, "value_elastic"));
    assert!((before - after).abs() < 1e-12 * before, "{before} {after}");
    // Monte Carlo has no twin.
    let none = chaos(
        table,
        "dsmc-boltzmann",
        whole,
        "collisions",
        "value_elastic",
    );
    assert!(none.is_nan());
}

/// No twin of a gas that is elastic itself, and none on request.
#[test]
fn twins_can_be_left_out() {
    let elastic = COOLING.replace("restitution = 0.7", "restitution = 1");
    let without = COOLING.replace("{ windows", "{ elastic_twin = false, windows");
    for text in [elastic, without] {
        let (tables, _, _) = run(&case(&text), measure("contacts"));
        let column = tables[0].find_column("value_elastic").expect("a column");
        assert!(
            tables[0]
                .rows
                .iter()
                .all(|row| row[column] == TableCell::Empty)
        );
    }
}

/// Both parts of the contact value are in the ratio of the restitution, and the flux of the twin is
/// that of a plain sum of 1/g over its norm. The rate is that of the collisions in the log.
#[test]
fn contact_values_are_those_of_the_collisions() {
    let plan = case(&COOLING.replace(
        ", dsmc-boltzmann = { simulators_per_particle = 2, cell_size = 3 }",
        "",
    ));
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
    let norm = pairs / plan.gas.volume * std::f64::consts::TAU * exposure;
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

const MIXTURE: &str = r#"
    format = 2
    title = "two species"
    replicas = 2
    gas = { restitution = 0.9 }
    species = [{ number = 60, name = "small" }, { number = 40, diameter = 1.5, mass = 2, name = "large" }]
    box = { packing_fraction = 0.2 }
    run = { until = 1 }
    engine = { ed = {}, dsmc-enskog = { simulators_per_particle = 3, cell_size = 3 } }
"#;

/// Rows of a table with a word in a column.
fn rows_of(table: &Table, column: &str, word: &str) -> Vec<usize> {
    let at = table.find_column(column).expect("a column");
    let says = |row: &usize| table.rows[*row][at] == TableCell::Text(word.to_owned());
    (0..table.rows.len()).filter(says).collect()
}

/// Partial structure of mixtures: a table of all pairs by name, whose pairs of particles are all of
/// those of the whole gas. The tables of contacts name their pairs, too.
#[test]
fn pairs_of_species_have_names_and_add_up() {
    let plan = case(MIXTURE);
    let (tables, _, _) = run(&plan, measure("pair_correlation"));
    let [all, pairs] = &tables[..] else {
        panic!("two tables");
    };
    assert_eq!(pairs.name, "partial_pair_correlation");
    let ed = |rows: Vec<usize>| -> Vec<usize> {
        let ed = rows_of(pairs, "engine", "ed");
        rows.into_iter().filter(|row| ed.contains(row)).collect()
    };
    let [small, both, large] = ["small, small", "small, large", "large, large"]
        .map(|name| ed(rows_of(pairs, "pair", name)));
    let whole = rows_of(all, "engine", "ed");
    assert!(whole.len() > 100 && small.len() == whole.len());
    for (index, &row) in whole.iter().enumerate() {
        let of = |rows: &[usize]| number(pairs, rows[index], "g");
        let sum = 60.0 * 59.0 / 2.0 * of(&small)
            + 60.0 * 40.0 * of(&both)
            + 40.0 * 39.0 / 2.0 * of(&large);
        let found = number(all, row, "g") * 100.0 * 99.0 / 2.0;
        // Rounding of sums over the 4950 pairs, of which a bin holds a share.
        assert!(
            (found - sum).abs() < 1e-10 * (4950.0 + sum.abs()),
            "{found} {sum}"
        );
    }
    let (tables, _, _) = run(&plan, measure("structure_factor"));
    assert_eq!(tables[1].name, "partial_structure_factor");
    let (first, part) = (number(&tables[0], 0, "structure_factor"), |name: &str| {
        number(
            &tables[1],
            rows_of(&tables[1], "pair", name)[0],
            "structure_factor",
        )
    });
    let sum = 60.0 * part("small, small")
        + 40.0 * part("large, large")
        + 2.0 * 2400.0_f64.sqrt() * part("small, large");
    // Of a lattice at the start S(k) is zero but for rounding.
    assert!((first - sum / 100.0).abs() < 1e-9, "{first} {sum}");
    for name in ["contacts", "impact_parameters"] {
        let (tables, _, _) = run(&plan, measure(name));
        let named = tables
            .iter()
            .filter(|table| table.find_column("pair").is_some());
        let found: Vec<_> = named
            .map(|table| rows_of(table, "pair", "small, large").len())
            .collect();
        assert!(found.iter().any(|&rows| rows > 0), "{name}: {found:?}");
    }
}

/// Two species of one name could not be told apart.
#[test]
fn species_of_one_name_are_refused() {
    for (name, key) in [("small", "species.2.name"), ("1", "species.2.name")] {
        let text = MIXTURE.replace("name = \"large\"", &format!("name = \"{name}\""));
        let text = if name == "1" {
            text.replace(", name = \"small\"", "")
        } else {
            text
        };
        let case: stosszahl_case::Case = toml::from_str(&text).expect("a case");
        let error = CasePlan::new(&case, std::path::Path::new(".")).expect_err("one name");
        let error = error.to_string();
        assert!(
            error.contains(key) && error.contains("no other species"),
            "{error}"
        );
    }
}
