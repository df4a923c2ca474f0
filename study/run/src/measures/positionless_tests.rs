//! Measures of gases without positions on the engine, against slow sums and against laws.

use std::path::Path;

use stosszahl_case::Case;
use stosszahl_model::random::Streams;
use stosszahl_model::{Budget, Interrupt};
use stosszahl_results::{Table, TableCell, VerdictKind, VerdictText};

use super::ALL;
use super::species_record::moments;
use crate::control::Control;
use crate::engine_run::EngineRun;
use crate::engines::{self, From};
use crate::measure::{CompletedRun, Measure, Needs, ReplicaRecords};
use crate::plan::CasePlan;

/// A plan from the text of a case below its first lines.
fn plan(text: &str) -> CasePlan {
    let text = format!("format = 2\ntitle = \"a test\"\n{text}");
    let case: Case = toml::from_str(&text).expect("a case");
    CasePlan::new(&case, Path::new(".")).expect("a plan")
}

fn measures(plan: &CasePlan) -> Vec<&'static dyn Measure> {
    let asked =
        |one: &&&dyn Measure| one.by_default(plan) || plan.case.measure.contains_key(one.name());
    let all: Vec<_> = ALL.iter().filter(asked).copied().collect();
    for one in &all {
        one.check_options(plan).expect("good options");
    }
    all
}

/// One replica from its start to its end.
fn follow(plan: &CasePlan, measures: &[&'static dyn Measure], replica: u64) -> CompletedRun {
    let part = EngineRun {
        plan,
        engine: &plan.engines[0],
        measures,
        replica,
        start: None,
    };
    let stop = Interrupt::default();
    let control = Control::new(None, 1e9, &stop, &|_, _| {});
    part.run_engine(&control).expect("a run to its end")
}

/// All tables and verdicts of a plan.
pub(super) fn results(plan: &CasePlan) -> (Vec<Table>, Vec<VerdictText>) {
    let measures = measures(plan);
    let run = |replica| follow(plan, &measures, replica);
    let finished = [(0..plan.case.replicas).map(run).collect::<Vec<_>>()];
    let (mut tables, mut verdicts) = (Vec::new(), Vec::new());
    for (measure, one) in measures.iter().enumerate() {
        let runs = ReplicaRecords {
            level: 0.01,
            measure,
            finished: &finished,
        };
        let own = one.result_tables(plan, &runs);
        verdicts.extend(one.result_verdicts(plan, &runs, &own));
        tables.extend(own);
    }
    (tables, verdicts)
}

/// The number in a row and column.
fn number(table: &Table, row: usize, column: &str) -> f64 {
    let column = table.find_column(column).expect("a column of this name");
    match &table.rows[row][column] {
        TableCell::Number(number) => *number,
        TableCell::Count(count) => *count as f64,
        other => panic!("{column} is {other:?}"),
    }
}

fn table<'a>(tables: &'a [Table], name: &str) -> &'a Table {
    let mut all = tables.iter();
    all.find(|table| table.name == name)
        .expect("a table of this name")
}

/// Sums over N = 300 particles in another order differ by rounding: N epsilon = 7e-14 of the
/// largest term.
fn close(a: f64, b: f64) {
    assert!((a - b).abs() <= 1e-12 * a.abs().max(b.abs()), "{a} {b}");
}

const MIXTURE: &str = "replicas = 3
[gas]
dimension = 3
volume = 3000
restitution = 0.8
[[species]]
number = 200
[[species]]
number = 100
mass = 4
diameter = 2
temperature = 2
[run]
until = 20
first_sample = 1
samples_per_decade = 3
[measure.displacement]
[measure.velocity_correlation]
";

/// Simulators that each stand for eight particles of eight times the volume are those of the gas
/// itself, byte by byte, and say the density of all that they stand for.
#[test]
fn simulators_stand_for_particles() {
    let one = plan(MIXTURE);
    let many = plan(&MIXTURE.replace(
        "volume = 3000",
        "volume = 24000\nparticles_per_simulator = 8",
    ));
    let [(small, _), (large, _)] = [&one, &many].map(results);
    for name in ["energy", "species"] {
        assert_eq!(table(&small, name).rows, table(&large, name).rows);
    }
    let derived = |plan: &CasePlan, name: &str| {
        let all = plan.derived();
        all.iter().find(|one| one.name == name).expect("it").value
    };
    assert_eq!(derived(&many, "volume"), 24000.0);
    assert_eq!(derived(&many, "number_density"), 0.1);
    assert_eq!(derived(&many, "particles_per_simulator"), 8.0);
}

/// Every moment of a group against its definition, species by species.
#[test]
fn moments_are_those_of_the_particles() {
    let plan = plan(MIXTURE);
    let needs = Needs {
        displacements: true,
        trajectories: 0,
    };
    let streams = Streams::new(1, 0);
    let (engine, never) = (&plan.engines[0], Interrupt::default());
    let mut gas = engines::begin(
        &plan,
        engine,
        streams,
        needs,
        From::Start(None),
        &never,
        None,
    )
    .expect("an engine");
    let start: Vec<[f64; 3]> = gas
        .particles()
        .all
        .iter()
        .map(|p| p.velocity.into())
        .collect();
    gas.advance(5.0, Budget::Unlimited, &mut ())
        .expect("no failure");
    let paths = gas.displacements().expect("displacements");
    let found = moments(&*gas, plan.grouping(), &paths, &start);
    let all = gas.particles().all;
    assert_eq!(found.len(), 2);
    for (species, found) in found.iter().enumerate() {
        let own: Vec<usize> = (0..all.len())
            .filter(|&i| all[i].species as usize == species)
            .collect();
        let mean = |value: &dyn Fn(usize) -> f64| {
            own.iter().map(|&i| value(i)).sum::<f64>() / own.len() as f64
        };
        let square = |i: usize| all[i].velocity.norm_squared();
        assert_eq!(found.count, plan.gas.species[species].count);
        close(
            found.temperature,
            plan.gas.species[species].mass * mean(&square) / 3.0,
        );
        let fourth = mean(&|i| square(i).powi(2));
        close(
            found.fourth_cumulant + 1.0,
            3.0 * fourth / (5.0 * mean(&square).powi(2)),
        );
        close(found.displacement, mean(&|i| paths[i].norm_squared()));
        close(
            found.displacement_fourth,
            mean(&|i| paths[i].norm_squared().powi(2)),
        );
        let along = |i: usize| paths[i].dot(&all[i].velocity);
        close(found.displacement_velocity, mean(&along));
        close(
            found.displacement_velocity_square,
            mean(&|i| along(i).powi(2)),
        );
        let kept = mean(&|i| (0..3).map(|a| start[i][a] * all[i].velocity[a]).sum());
        assert!((found.velocity_correlation - kept).abs() < 1e-12);
    }
}

/// The table of the gas against that of its replicas, and errors against the two spreads.
#[test]
fn the_gas_is_the_mean_of_its_replicas() {
    let plan = plan(MIXTURE);
    let (tables, _) = results(&plan);
    let (gas, replicas) = (table(&tables, "energy"), table(&tables, "replicas"));
    let times = plan.sample_times();
    assert_eq!(
        (gas.rows.len(), replicas.rows.len()),
        (times.len(), 3 * times.len())
    );
    for (row, &time) in times.iter().enumerate() {
        let of = |replica: usize, column| number(replicas, replica * times.len() + row, column);
        let ratios: Vec<f64> = (0..3).map(|r| of(r, "energy_ratio")).collect();
        let mean = ratios.iter().sum::<f64>() / 3.0;
        assert_eq!(number(gas, row, "time"), time);
        close(number(gas, row, "energy_ratio"), mean);
        let spread = ratios.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / 6.0;
        assert!(number(gas, row, "energy_ratio_se") >= 0.999_999 * spread.sqrt());
        // Of 300 particles over 3 replicas an energy is known to sqrt(2/(3 900)) at best.
        assert!(number(gas, row, "energy_ratio_se") > 0.7 * mean * (2.0_f64 / 2700.0).sqrt());
        let hits = (0..3)
            .map(|r| of(r, "collisions_per_particle"))
            .sum::<f64>()
            / 3.0;
        close(number(gas, row, "collisions_per_particle"), hits);
    }
    let species = table(&tables, "species");
    assert_eq!(species.rows.len(), 2 * times.len());
    // At the start velocities are their own, and nothing has moved.
    for row in 0..2 {
        assert_eq!(number(species, row, "velocity_correlation"), 1.0);
        assert_eq!(number(species, row, "mean_squared_displacement"), 0.0);
        // Three passes set temperatures and take out the drift, each to a share of 1/N of the one
        // before.
        let found = number(species, row, "temperature") / plan.gas.species[row].temperature;
        assert!((found - 1.0).abs() < 1e-6, "{found}");
    }
    let checks = table(&tables, "checks");
    let known = checks
        .rows
        .iter()
        .filter(|row| row[0] == TableCell::Text("temperature".to_owned()));
    assert_eq!(known.count(), 2);
}

/// 40000 particles in all know their energy to 0.4 %, and their collisions better: within 2 % of
/// theory unless it is wrong.
#[test]
fn a_cooling_gas_agrees_with_theory() {
    let plan = plan(
        "replicas = 4
[gas]
dimension = 3
number = 10000
volume = 1e5
restitution = 0.8
[run]
time_unit = \"haff\"
until = 10
first_sample = 1
samples_per_decade = 3",
    );
    let (_, verdicts) = results(&plan);
    for topic in ["energy", "collisions per particle"] {
        let found = verdicts.iter().find(|one| one.topic == topic);
        assert_eq!(
            found.expect("a verdict").kind,
            VerdictKind::Agree,
            "{found:?}"
        );
    }
}

/// Without collisions a path is straight: `delta^2 = <v^2> lag^2 = D T lag^2/m`, as is the
/// displacement since the start, and the averages of single paths differ as `v^2` does, at all lags
/// alike; to rounding.
#[test]
fn straight_paths_are_averaged_exactly() {
    let plan = plan(
        "replicas = 1
[gas]
dimension = 2
number = 50
volume = 1e30
temperature = 3
restitution = 0.9
[run]
until = 10
first_sample = 0.1
samples_per_decade = 2
[measure.displacement]
[measure.time_averaged_displacement]
particles = 50",
    );
    let (tables, _) = results(&plan);
    let species = table(&tables, "species");
    // In the plane the mean of v^4 is 2 (1 + a2) times the squared mean of v^2.
    let cumulant = number(species, 0, "fourth_cumulant");
    let averaged = table(&tables, "time_averaged_displacement");
    assert_eq!(averaged.rows.len(), 3);
    for row in 0..3 {
        let breaking = number(averaged, row, "ergodicity_breaking");
        assert!((breaking - 1.0 - 2.0 * cumulant).abs() < 1e-9, "{breaking}");
        let ratio = number(averaged, row, "over_ensemble");
        assert!((ratio - 1.0).abs() < 1e-9, "{ratio}");
        let lag = number(averaged, row, "lag");
        let found = number(averaged, row, "mean_squared_displacement");
        assert!((found / (6.0 * lag * lag) - 1.0).abs() < 1e-9, "{found}");
        assert_eq!(number(averaged, row, "paths"), 50.0);
    }
}

/// Energy that sticking and breaking take and a thermostat gives adds up, and clusters are counted
/// once.
#[test]
fn clusters_keep_their_energy_and_number() {
    let plan = plan(
        "replicas = 2
[gas]
dimension = 3
number = 2000
volume = 2e4
[aggregation]
aggregate_below = 4
fragment_above = 12
[thermostat]
kind = \"rescaling\"
interval = 3
[run]
until = 30
first_sample = 1
samples_per_decade = 3
[measure.clusters]
times = [10, 30]
steady_from = 10
fit_monomers = [1, 8]",
    );
    let (tables, verdicts) = results(&plan);
    let (clusters, sizes) = (
        table(&tables, "clusters"),
        table(&tables, "size_distribution"),
    );
    for row in 0..clusters.rows.len() {
        let of = |column| number(clusters, row, column);
        let sum = of("energy_ratio") + of("aggregation_loss") + of("fragmentation_loss");
        // Sums of some thousand events, each off by rounding.
        assert!((sum - of("heating_energy") - 1.0).abs() < 1e-9, "{sum}");
    }
    let last = clusters.rows.len() - 1;
    assert!(number(clusters, last, "heating_energy") > 0.0);
    assert!(number(clusters, last, "mean_monomers") > 1.0);
    let of_last = |row: &usize| {
        sizes.rows[*row][0] == TableCell::Text("instant".to_owned())
            && number(sizes, *row, "time") == 30.0
    };
    let counted = (0..sizes.rows.len()).filter(of_last);
    let counted: f64 = counted.map(|row| number(sizes, row, "counted")).sum();
    let expected = number(clusters, last, "clusters_ratio") * 2000.0 * 2.0;
    assert_eq!(counted.round(), expected.round());
    let steady = (0..sizes.rows.len())
        .filter(|&row| sizes.rows[row][0] == TableCell::Text("steady".to_owned()));
    let monomers: f64 = steady
        .filter(|&row| number(sizes, row, "monomers_high") <= 16.0)
        .map(|row| number(sizes, row, "clusters_per_monomer") * number(sizes, row, "monomers_low"))
        .sum();
    assert!(monomers > 0.5 && monomers <= 1.0 + 1e-12, "{monomers}");
    let topics: Vec<&str> = verdicts.iter().map(|one| one.topic.as_str()).collect();
    assert!(topics.contains(&"steady state") && topics.contains(&"sizes in the steady state"));
}

/// Each particle with its own size: equal shares by size, whose theory begins at the temperature of
/// the start.
#[test]
fn continuous_sizes_have_groups() {
    let plan = plan(
        "replicas = 1
[gas]
dimension = 2
volume = 1e4
restitution = 0.7
[polydisperse]
number = 600
distribution = \"uniform\"
relative_width = 0.3
groups = 4
[run]
until = 3
samples_per_decade = 1",
    );
    let (tables, _) = results(&plan);
    let species = table(&tables, "species");
    for row in 0..4 {
        assert_eq!(number(species, row, "particles"), 150.0);
        assert_eq!(number(species, row, "temperature_theory"), 1.0);
        assert!(row == 0 || number(species, row, "mass") > number(species, row - 1, "mass"));
    }
}

/// A measure where it makes no sense, and options that cannot be.
#[test]
fn what_cannot_be_measured_is_refused() {
    let refused = |text: &str, name: &str| {
        let plan = plan(text);
        let measure = ALL
            .iter()
            .find(|one| one.name() == name)
            .expect("a measure");
        measure.check_options(&plan).expect_err("a refusal").key
    };
    let gas = "[gas]\nnumber = 100\nvolume = 1e4\nrestitution = 0.9\n[run]\nuntil = 10\n";
    let boxed =
        "[gas]\nnumber = 100\n[box]\npacking_fraction = 0.1\n[engine.ed]\n[run]\nuntil = 10\n";
    let sticky = format!("{gas}[aggregation]\n");
    for name in ["species", "checks", "clusters", "velocity_correlation"] {
        assert_eq!(refused(boxed, name), "");
    }
    assert_eq!(refused(gas, "clusters"), "");
    assert_eq!(refused(&sticky, "species"), "");
    let with = |options: &str| format!("{sticky}[measure.clusters]\n{options}\n");
    for (key, options) in [
        ("times", "times = [3, 2]"),
        ("steady_from", "steady_from = 2"),
        ("fit_monomers", "fit_monomers = [2, 9]"),
        ("nothing", "nothing = 1"),
    ] {
        assert_eq!(refused(&with(options), "clusters"), key, "{options}");
    }
    let paths = format!("{gas}[measure.time_averaged_displacement]\nparticles = 0\n");
    assert_eq!(refused(&paths, "time_averaged_displacement"), "particles");
}
