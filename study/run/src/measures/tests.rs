//! Measures of flows on tiny gases, against slow computations.

use std::path::Path;

use nalgebra::{Vector3, vector};
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use stosszahl_case::Case;
use stosszahl_model::random::Streams;
use stosszahl_model::{Budget, Collision, Observer, Particle, Particles, Simulation};
use stosszahl_results::{Table, TableCell, VerdictKind, VerdictText};

use super::ALL;
use super::species::SpeciesMeasure;
use crate::measure::{CompletedRun, Measure, Probe, ReplicaRecords, RunStop, SampleContext};
use crate::plan::{CasePlan, EngineKind, EnginePlan, UnitScale};
use crate::theory::flow;

/// Everything that happened in one run, for slow computations.
#[derive(Default)]
pub(super) struct Log {
    pub(super) collisions: Vec<Collision>,
    /// Engine time and particles at each sample, from the start on.
    pub(super) states: Vec<(f64, Vec<Particle>)>,
}

impl Observer for Log {
    fn on_collisions(&mut self, batch: &[Collision]) {
        self.collisions.extend(batch);
    }
}

/// A case in format 2.
pub(super) fn case(text: &str) -> CasePlan {
    let case: Case = toml::from_str(text).expect("a case");
    CasePlan::new(&case, Path::new(".")).expect("a plan")
}

pub(super) fn measure(name: &str) -> &'static dyn Measure {
    *ALL.iter().find(|one| one.name() == name).expect("known")
}

/// Disks on a lattice with random velocities (and spins), the same for all engines and different
/// for each replica.
pub(super) fn start(plan: &CasePlan, seed: u64) -> Particles {
    let mut stream = Xoshiro256PlusPlus::seed_from_u64(seed);
    let mut number = || stream.random_range(-1.0..1.0);
    let count = plan.count();
    let side = (count as f64).powf(1.0 / plan.gas.dimension as f64).ceil() as usize;
    let mut all = Vec::new();
    for index in 0..count {
        let species = {
            let mut left = index;
            let kinds = plan.gas.species.iter();
            kinds
                .take_while(|kind| {
                    let beyond = left >= kind.count;
                    left = left.saturating_sub(kind.count);
                    beyond
                })
                .count()
        };
        let kind = &plan.gas.species[species];
        let place = [index % side, index / side % side, index / side / side];
        let mut position = Vector3::zeros();
        let mut velocity = Vector3::zeros();
        for axis in 0..plan.gas.dimension {
            position[axis] = plan.gas.lengths[axis] * (place[axis] as f64 + 0.5) / side as f64;
            velocity[axis] = number();
        }
        let mut particle = Particle::at_rest(kind.radius, kind.mass);
        (particle.position, particle.velocity) = (position, velocity);
        if plan.gas.particles.rough.is_some() {
            particle.spin = match plan.gas.dimension {
                2 => vector![0.0, 0.0, 2.0 * number()],
                _ => vector![2.0 * number(), 2.0 * number(), 2.0 * number()],
            };
        }
        all.push(particle);
    }
    Particles {
        time: 0.0,
        dimension: plan.gas.dimension,
        lengths: plan.gas.lengths,
        periodic: [0, 1, 2].map(|axis| {
            axis >= plan.gas.dimension
                || *plan.case.walls.face_at(axis, 0) == stosszahl_case::format::FaceSpec::default()
        }),
        all,
    }
}

fn simulation(plan: &CasePlan, engine: &EnginePlan, replica: u64) -> Box<dyn Simulation> {
    let streams = Streams::new(plan.case.seed, replica);
    let start = start(plan, replica);
    match &engine.kind {
        EngineKind::EventDriven { .. } => stosszahl_ed::simulate(
            &plan.gas.particles,
            stosszahl_ed::DissipationRule::Scene,
            &plan.exact_boundaries(streams).expect("walls"),
            &start,
        )
        .expect("exact disks"),
        EngineKind::MonteCarlo(parameters) => {
            let boundaries = plan.boundaries(engine).expect("walls");
            let gas = stosszahl_dsmc::CellGas {
                grains: &plan.gas.particles,
                parameters: *parameters,
                boundaries: &boundaries,
                streams,
                displacements: false,
            };
            let starts = vec![start; parameters.simulators_per_particle as usize];
            stosszahl_dsmc::simulate(&gas, &starts).expect("cells")
        }
        EngineKind::Homogeneous(_) => unreachable!("flows have positions"),
    }
}

/// Runs a measure on all engines and replicas; the log is of the last engine and replica. At the
/// middle all records are written and read back, as after a stop.
pub(super) fn run(plan: &CasePlan, measure: &dyn Measure) -> (Vec<Table>, Vec<VerdictText>, Log) {
    run_from(plan, measure, 0)
}

/// Runs a measure on all engines and replicas, with starts of other seeds.
pub(super) fn run_from(
    plan: &CasePlan,
    measure: &dyn Measure,
    seed: u64,
) -> (Vec<Table>, Vec<VerdictText>, Log) {
    measure.check_options(plan).expect("the options are good");
    let mut log = Log::default();
    let finished: Vec<Vec<CompletedRun>> = plan
        .engines
        .iter()
        .map(|engine| {
            (0..plan.case.replicas)
                .map(|replica| {
                    let mut gas = simulation(plan, engine, seed + replica);
                    let mut probe = measure.new_probe(plan, engine);
                    log = follow(plan, measure, engine, &mut *gas, &mut probe);
                    CompletedRun {
                        probes: vec![probe],
                        work: gas.work_counters(),
                        bytes: 0,
                        seconds: 0.0,
                    }
                })
                .collect()
        })
        .collect();
    let runs = ReplicaRecords {
        level: 0.01,
        measure: 0,
        finished: &finished,
    };
    let mut tables = measure.result_tables(plan, &runs);
    if measure.name() == "energy" && plan.gas.species.len() > 1 {
        // The species of a box are read from the record of the whole gas.
        tables.extend(SpeciesMeasure.result_tables(plan, &runs));
    }
    for table in &tables {
        for row in &table.rows {
            assert_eq!(row.len(), table.columns.len(), "{}", table.name);
        }
    }
    let verdicts = measure.result_verdicts(plan, &runs, &tables);
    (tables, verdicts, log)
}

fn follow(
    plan: &CasePlan,
    measure: &dyn Measure,
    engine: &EnginePlan,
    gas: &mut dyn Simulation,
    probe: &mut Box<dyn Probe>,
) -> Log {
    let mut log = Log::default();
    let mut times = measure.sample_times(plan);
    times.sort_by(f64::total_cmp);
    log.states.push((0.0, gas.particles().all));
    probe.on_start(&mut SampleContext::new(0.0, gas));
    for (number, time) in times.iter().copied().enumerate() {
        let until = plan.engine_time(time);
        let mut no_observer = ();
        loop {
            let observer = probe.collision_observer().unwrap_or(&mut no_observer);
            if (gas.advance(until, Budget::Leg, &mut (&mut log, observer))).expect("it goes on") {
                break;
            }
        }
        log.states.push((until, gas.particles().all));
        probe.on_stop(&RunStop {
            time: until,
            temperature: gas.temperature(),
            kicked_from: None,
        });
        probe.on_sample(&mut SampleContext::new(time, gas));
        if number == times.len() / 2 {
            let bytes = probe.save_record().expect("a record");
            *probe = measure.new_probe(plan, engine);
            probe.load_record(&bytes).expect("the record");
        }
    }
    log
}

pub(super) fn number(table: &Table, row: usize, column: &str) -> f64 {
    let at = table
        .find_column(column)
        .unwrap_or_else(|| panic!("{column}"));
    match table.rows[row][at] {
        TableCell::Number(number) => number,
        TableCell::Count(count) => count as f64,
        _ => f64::NAN,
    }
}

fn table<'a>(tables: &'a [Table], name: &str) -> &'a Table {
    let mut all = tables.iter();
    all.find(|table| table.name == name).expect("the table")
}

fn word<'a>(table: &'a Table, row: usize, column: &str) -> &'a str {
    match &table.rows[row][table.find_column(column).expect("a column")] {
        TableCell::Text(text) => text,
        _ => "",
    }
}

/// Rows in which a column says a word.
fn rows(table: &Table, wanted: &[(&str, &str)]) -> Vec<usize> {
    let says = |&row: &usize| {
        wanted
            .iter()
            .all(|(column, text)| word(table, row, column) == *text)
    };
    (0..table.rows.len()).filter(says).collect()
}

/// Equal but for the order of sums: some hundred roundings.
#[track_caller]
pub(super) fn near(found: f64, expected: f64, scale: f64) {
    assert!(
        (found - expected).abs() <= 1e-12 * scale,
        "{found} {expected}"
    );
}

const ROUGH_COLUMN: &str = r#"
    format = 2
    title = "rough disks of two species fall between walls"
    replicas = 2
    gas = { restitution = 0.8, tangential_restitution = 0.3 }
    species = [{ number = 9, name = "small" }, { number = 7, diameter = 1.4, mass = 2, name = "large" }]
    box = { size = [12, 10] }
    walls = { bottom = { temperature = 0.7 }, top = { restitution = 0.9, slip = 0.5 } }
    gravity = { acceleration = [0.1, -0.2] }
    run = { until = 8, samples = 16 }
    engine = { ed = {}, dsmc-enskog = { simulators_per_particle = 3, cell_size = 3, displacement = false } }
    measure.fields = { cells = [3, 2], blocks = 4, windows = [[0, 4]] }
"#;

/// The whole gas, from its particles.
#[test]
fn series_is_what_particles_have() {
    let plan = case(ROUGH_COLUMN);
    let (tables, _, log) = run(&plan, measure("energy"));
    let rows = |name: &str| table(&tables, name).rows.len();
    assert_eq!((rows("energy"), rows("species")), (2 * 17, 2 * 2 * 17));
    // A second run of one replica leaves the log of just that replica.
    let mut one = plan.clone();
    one.case.replicas = 1;
    one.engines.remove(0);
    let (tables_of_one, verdicts, log_of_one) = run(&one, measure("energy"));
    assert!(log.states.len() == 17 && verdicts.iter().all(|v| v.kind != VerdictKind::Agree));
    for (index, (_, particles)) in log_of_one.states.iter().enumerate() {
        let sum =
            |of: &dyn Fn(&Particle) -> f64| particles.iter().map(|p| p.weight * of(p)).sum::<f64>();
        let (count, mass) = (sum(&|_| 1.0), sum(&|p| p.mass));
        let drift: Vector3<f64> = particles
            .iter()
            .map(|p| p.velocity * (p.mass * p.weight / mass))
            .sum();
        let temperature = sum(&|p| p.mass * (p.velocity - drift).norm_squared()) / (2.0 * count);
        let table = |name: &str| table(&tables_of_one, name);
        let (table, of_species) = (table("energy"), table("species"));
        near(count, 16.0, 16.0);
        near(number(table, index, "temperature"), temperature, 1.0);
        near(
            number(table, index, "spin_temperature"),
            sum(&|p| 2.0 * p.spin_energy) / count,
            1.0,
        );
        // Along the periodic axis there is no height.
        let height = sum(&|p| p.mass * 0.2 * p.position.y);
        near(number(table, index, "potential"), height, 100.0);
        let motion = sum(&|p| 0.5 * p.mass * p.velocity.norm_squared() + p.spin_energy);
        near(number(table, index, "energy"), motion + height, 100.0);
        assert!(number(table, index, "energy_se").is_nan());
        let until = log_of_one.states[index].0;
        let met = log_of_one
            .collisions
            .iter()
            .filter(|c| c.time <= until)
            .map(|c| c.weight);
        near(
            number(table, index, "collisions_per_particle"),
            2.0 * met.sum::<f64>() / 16.0,
            10.0,
        );
        for (kind, radius) in [(0, 0.5), (1, 0.7)] {
            let own = particles.iter().filter(|p| p.radius == radius);
            let spins: f64 = own.clone().map(|p| 2.0 * p.spin_energy * p.weight).sum();
            let own: f64 = own.map(|p| p.weight).sum();
            let row = 2 * index + kind;
            near(number(of_species, row, "particles"), own, 16.0);
            near(
                number(of_species, row, "spin_temperature"),
                spins / own,
                1.0,
            );
        }
    }
}

/// Fields and profiles in the last window against sums over particles and collisions, cell by cell.
#[expect(
    clippy::too_many_lines,
    reason = "one slow computation beside each number of the tables"
)]
fn check_fields(plan: &CasePlan, carries: bool) {
    let (tables, _, log) = run(plan, measure("fields"));
    let [cells, profiles] = &tables[..] else {
        panic!("two tables")
    };
    let last = cells.rows.len() - 1;
    let [from, to] = ["window_start", "window_end"].map(|name| number(cells, last, name));
    let unit = plan.scale;
    let [width, height] = [plan.gas.lengths[0] / 3.0, plan.gas.lengths[1] / 2.0];
    let depth = if plan.gas.dimension == 3 {
        plan.gas.lengths[2]
    } else {
        1.0
    };
    let per_volume = unit.length.powi(-(plan.gas.dimension as i32));
    let duration = plan.engine_time(to - from);
    assert_eq!(to, 4.0 * (to - from), "the last of four blocks");
    // States at the ends of intervals within the window.
    let inside: Vec<&Vec<Particle>> = (log.states.iter())
        .filter(|(time, _)| {
            let time = time / plan.clock.time;
            time > from * (1.0 + 1e-9) && time <= to * (1.0 + 1e-9)
        })
        .map(|(_, particles)| particles)
        .collect();
    assert_eq!(inside.len(), 4);
    let cell = |x: f64, y: f64| {
        let wrap = |at: f64, length: f64| at.rem_euclid(length);
        (
            (wrap(x, plan.gas.lengths[0]) / width) as usize,
            (wrap(y, plan.gas.lengths[1]) / height) as usize,
        )
    };
    let met = |place: &dyn Fn((usize, usize)) -> bool| -> (f64, f64) {
        log.collisions
            .iter()
            .filter(|one| ((one.time / duration) as usize).min(3) == 3)
            .filter(|one| place(cell(one.position.x, one.position.y)))
            .fold((0.0, 0.0), |(count, virial), one| {
                let approach = -one.relative_velocity.dot(&one.line.normalize());
                let carried =
                    one.reduced_mass * (1.0 + one.restitution) * approach * one.line.norm();
                (count + one.weight, virial + one.weight * carried)
            })
    };
    let check = |table: &Table, row: usize, volume: f64, place: &dyn Fn((usize, usize)) -> bool| {
        let seen: Vec<&Particle> = (inside.iter().flat_map(|all| all.iter()))
            .filter(|p| place(cell(p.position.x, p.position.y)))
            .collect();
        let sum =
            |of: &dyn Fn(&Particle) -> f64| seen.iter().map(|p| p.weight * of(p)).sum::<f64>();
        let (count, mass) = (sum(&|_| 1.0), sum(&|p| p.mass));
        let density = count / 4.0 / volume;
        near(
            number(table, row, "number_density"),
            density * per_volume,
            1.0,
        );
        if count == 0.0 {
            return;
        }
        let drift: Vector3<f64> = seen
            .iter()
            .map(|p| p.velocity * (p.mass * p.weight / mass))
            .sum();
        let thermal = sum(&|p| p.mass * (p.velocity - drift).norm_squared());
        let temperature = thermal / (plan.gas.dimension as f64 * count);
        near(
            number(table, row, "velocity_x"),
            drift.x * unit.speed(),
            10.0,
        );
        near(
            number(table, row, "velocity_y"),
            drift.y * unit.speed(),
            10.0,
        );
        near(
            number(table, row, "temperature"),
            temperature * unit.energy,
            100.0 * unit.energy,
        );
        let (collisions, virial) = met(place);
        let virial = if carries { virial } else { 0.0 };
        let pressure =
            density * temperature + virial / duration / (plan.gas.dimension as f64 * volume);
        let scale = unit.energy * per_volume;
        near(
            number(table, row, "pressure"),
            pressure * scale,
            100.0 * scale,
        );
        if table.find_column("collision_rate").is_some() {
            let rate = 2.0 * collisions / (to - from) / (count / 4.0);
            near(
                number(table, row, "collision_rate"),
                rate,
                100.0 * rate.max(1.0),
            );
        }
    };
    for (place, row) in (cells.rows.len() - 6..cells.rows.len()).enumerate() {
        let here = (place % 3, place / 3);
        near(
            number(cells, row, "x"),
            (here.0 as f64 + 0.5) * width * unit.length,
            10.0,
        );
        check(cells, row, width * height * depth, &|at| at == here);
    }
    let end = number(cells, last, "window_end");
    let of_last = |row: &usize| {
        number(profiles, *row, "window_end") == end
            && number(profiles, *row, "window_start") == from
    };
    let along_y = rows(profiles, &[("along", "y"), ("species", "all")]);
    for (line, row) in along_y.into_iter().filter(of_last).enumerate() {
        let volume = plan.gas.lengths[0] * height * depth;
        check(profiles, row, volume, &|(_, y)| y == line);
    }
    let along_x = rows(profiles, &[("along", "x"), ("species", "all")]);
    for (line, row) in along_x.into_iter().filter(of_last).enumerate() {
        check(
            profiles,
            row,
            width * plan.gas.lengths[1] * depth,
            &|(x, _)| x == line,
        );
    }
}

#[test]
fn fields_between_walls_are_sums_over_cells() {
    for (keep, carries) in [(0, true), (1, false)] {
        let mut plan = case(ROUGH_COLUMN);
        plan.engines = vec![plan.engines.swap_remove(keep)];
        plan.case.replicas = 1;
        check_fields(&plan, carries);
    }
}

const PERIODIC: &str = r#"
    format = 2
    title = "smooth disks, periodic"
    replicas = 1
    gas = { number = 16, restitution = 0.7 }
    box = { size = [7, 6] }
    run = { until = 8, samples = 16 }
    engine = { ed = {}, dsmc-contact-point = { simulators_per_particle = 2 } }
    measure.fields = { cells = [3, 2], blocks = 4 }
"#;

/// Without walls, in units of the engine that are none of the case: particles and collisions in all
/// images of the box.
#[test]
fn fields_of_a_periodic_gas_are_in_the_units_of_the_case() {
    for keep in [0, 1] {
        let mut plan = case(PERIODIC);
        plan.engines = vec![plan.engines.swap_remove(keep)];
        plan.scale = UnitScale {
            length: 2.0,
            mass: 3.0,
            energy: 5.0,
        };
        plan.clock.time = 0.5;
        check_fields(&plan, true);
    }
}

#[test]
fn fields_in_space_are_sums_over_columns() {
    let text = PERIODIC
        .replace("[7, 6]", "[4, 4, 4]")
        .replace("number = 16", "number = 27, dimension = 3")
        .replace("ed = {}, dsmc-contact-point", "dsmc-boltzmann");
    let text = text.replace(
        "simulators_per_particle = 2",
        "simulators_per_particle = 2, cell_size = 1",
    );
    check_fields(&case(&text), false);
}

/// Disks and spheres, in a periodic box, between walls and without positions.
#[test]
fn what_is_measured_by_default_can_be_measured() {
    let disks = PERIODIC
        .replace(", samples = 16", "")
        .replace("measure.fields = { cells = [3, 2], blocks = 4 }", "");
    let spheres = disks
        .replace("[7, 6]", "[4, 4, 4]")
        .replace("number = 16", "number = 27, dimension = 3")
        .replace("ed = {}, ", "");
    let walls = "walls = { bottom = 'specular', top = 'specular' }\n    box =";
    let between = [&disks, &spheres].map(|text| text.replace("box =", walls));
    let nowhere = spheres
        .replace("box = { size = [4, 4, 4] }", "")
        .replace("dimension = 3", "dimension = 3, volume = 64")
        .replace(
            "dsmc-contact-point = { simulators_per_particle = 2 }",
            "dsmc-homogeneous = {}",
        );
    for text in [&disks, &spheres, &between[0], &between[1], &nowhere] {
        let plan = case(text);
        let mut found = 0;
        for measure in ALL.iter().filter(|one| one.by_default(&plan)) {
            let checked = measure.check_options(&plan);
            assert!(checked.is_ok(), "{}: {checked:?}\n{text}", measure.name());
            found += 1;
        }
        assert!(found > 1, "{text}");
    }
}

/// Momentum and energy that boundaries give, with the pull of gravity, are what the gas gains; so
/// are particles.
fn check_balance(plan: &CasePlan, names: &[&str]) {
    let (tables, verdicts, log) = run(plan, measure("boundaries"));
    let (series, _, _) = run(plan, measure("energy"));
    let (given, series) = (&tables[0], &series[0]);
    let found: Vec<&str> = (0..given.rows.len())
        .map(|row| word(given, row, "boundary"))
        .collect();
    assert_eq!(found, names);
    let [from, to] = ["window_start", "window_end"].map(|name| number(given, 0, name));
    let sum = |column: &str| -> f64 {
        (0..given.rows.len())
            .map(|row| number(given, row, column))
            .sum()
    };
    let at = |time: f64| {
        (0..series.rows.len())
            .find(|&row| number(series, row, "time") == time)
            .expect("a sample")
    };
    let gain = |column: &str| {
        (number(series, at(to), column) - number(series, at(from), column)) / (to - from)
    };
    near(sum("power"), gain("energy"), 100.0);
    let momentum = |row: usize| -> Vector3<f64> {
        log.states[row]
            .1
            .iter()
            .map(|p| p.velocity * (p.mass * p.weight))
            .sum()
    };
    let mass: f64 = log.states[0].1.iter().map(|p| p.mass * p.weight).sum();
    let pull = plan.gas.particles.gravity.unwrap_or_default() * mass;
    let force = (momentum(at(to)) - momentum(at(from))) / (to - from) - pull;
    near(sum("force_x"), force.x, 100.0);
    near(sum("force_y"), force.y, 100.0);
    let flows = |row: &usize| {
        ["inflow 1", "out through left", "out through right"]
            .contains(&word(given, *row, "boundary"))
    };
    let through: f64 = (0..given.rows.len())
        .filter(flows)
        .map(|row| number(given, row, "particles_per_time"))
        .sum();
    // The number of a closed gas has no column.
    let counted = series.find_column("particles");
    near(through, counted.map_or(0.0, |_| gain("particles")), 100.0);
    for verdict in verdicts {
        assert_eq!(
            verdict.kind,
            VerdictKind::Note,
            "one replica has no errors: {}",
            verdict.sentence
        );
    }
}

#[test]
fn walls_and_gravity_give_what_the_gas_gains() {
    let text = ROUGH_COLUMN
        .replace(
            "restitution = 0.8, tangential_restitution = 0.3",
            "restitution = 1",
        )
        .replace("replicas = 2", "replicas = 1")
        // Along a periodic axis the energy of height jumps where a particle enters on the other
        // side.
        .replace("[0.1, -0.2]", "[0, -0.02]");
    for keep in [0, 1] {
        let mut plan = case(&text);
        plan.engines = vec![plan.engines.swap_remove(keep)];
        check_balance(&plan, &["bottom", "top"]);
    }
}

const STREAM: &str = r#"
    format = 2
    title = "a stream past a disk"
    replicas = 1
    gas = { number = 36, restitution = 1, diameter = 0.4 }
    box = { size = [13, 7] }
    walls = { left = "open", right = "open", bottom = "specular", top = "specular" }
    obstacle = [{ circle = { centre = [5.8, 3.4], radius = 0.3 } }]
    inflow = [{ face = "left", velocity = [2, 0], number_density = [0.1] }]
    run = { until = 8, samples = 16 }
    engine = { dsmc-boltzmann = { simulators_per_particle = 2, cell_size = 1 } }
    measure.fields = { cells = [8, 4], blocks = 4 }
"#;

#[test]
fn a_stream_gives_what_the_gas_gains() {
    let plan = case(STREAM);
    let names = [
        "out through left",
        "out through right",
        "bottom",
        "top",
        "obstacle 1",
        "inflow 1",
    ];
    check_balance(&plan, &names);
    let (_, verdicts, _) = run(&plan, measure("boundaries"));
    assert!(
        verdicts[0].sentence.contains("coefficient of drag"),
        "{verdicts:?}"
    );
    // A stream at rest has no coefficient.
    let mut still = plan;
    still.case.inflow[0].velocity = vec![0.0, 0.0];
    let (_, verdicts, _) = run(&still, measure("boundaries"));
    let sentence = &verdicts[0].sentence;
    assert!(
        sentence.contains("coefficient of drag is unknown") && !sentence.contains("inf"),
        "{sentence}"
    );
}

/// Few blocks, one replica: no verdict claims more than that allows.
#[test]
fn verdicts_without_errors_claim_nothing() {
    for text in [ROUGH_COLUMN, STREAM] {
        let mut plan = case(text);
        plan.case.replicas = 1;
        for name in ["energy", "fields", "boundaries"] {
            let (_, verdicts, _) = run(&plan, measure(name));
            for verdict in verdicts {
                let kind = verdict.kind;
                let claims = matches!(kind, VerdictKind::Agree | VerdictKind::Differ);
                assert!(!claims, "{}: {}", verdict.topic, verdict.sentence);
                assert!(
                    !verdict.sentence.contains("NaN") && !verdict.sentence.contains("inf"),
                    "{}",
                    verdict.sentence
                );
            }
        }
    }
}

#[test]
fn options_that_cannot_be_are_refused() {
    let refused = |table: &str, key: &str| {
        let plan = case(&PERIODIC.replace("cells = [3, 2], blocks = 4", table));
        let error = measure("fields").check_options(&plan).expect_err(table);
        assert_eq!(error.key, key, "{error}");
    };
    refused("cells = [0, 2]", "cells");
    refused("cells = [1000, 1001]", "cells");
    refused("blocks = 7", "blocks");
    refused("blocks = 0", "blocks");
    refused("cell = [1, 1]", "cell");
    refused("cells = 3", "cells");
    // Fields of a long run on a fine grid would fill the memory.
    let long = PERIODIC.replace(
        "cells = [3, 2], blocks = 4",
        "cells = [1000, 1000], blocks = 100",
    );
    let long = long.replace("samples = 16", "samples = 100");
    assert_eq!(
        measure("fields")
            .check_options(&case(&long))
            .expect_err("too many")
            .key,
        "cells"
    );
    let mut plan = case(PERIODIC);
    plan.case.domain = None;
    for name in ["fields", "boundaries"] {
        assert!(
            measure(name).check_options(&plan).is_err(),
            "{name} without a box"
        );
    }
}

/// Energy is kept between specular walls, but not by a force along a periodic axis, which does work
/// for ever.
#[test]
fn energy_is_kept_only_where_nothing_does_work() {
    let text = PERIODIC.replace("0.7", "1");
    let closed = format!(
        "{text}\n[walls]\nbottom = 'specular'\ntop = 'specular'\n[gravity]\nacceleration = [0, -0.1]"
    );
    assert!(flow::keeps_energy(&case(&closed)));
    assert!(!flow::keeps_energy(&case(
        &closed.replace("[0, -0.1]", "[0.1, 0]")
    )));
    let rough = "restitution = 1, tangential_restitution = 0";
    assert!(!flow::keeps_energy(&case(
        &closed.replace("restitution = 1", rough)
    )));
    let (_, verdicts, _) = run(&case(&closed), measure("energy"));
    assert!(
        verdicts
            .iter()
            .all(|one| one.kind == VerdictKind::Agree || !one.topic.starts_with("energy")),
        "{verdicts:?}"
    );
}

/// Dilute points in a column: layers of theory hold all of them; the same gas pulled up is the
/// mirror image.
#[test]
fn a_column_of_theory_holds_all_particles() {
    let text = r#"
        format = 2
        title = "points settle"
        gas = { number = 100, diameter = 0.01 }
        box = { size = [10, 20] }
        walls = { bottom = "specular", top = "specular" }
        gravity = { acceleration = [0, -0.1] }
        run = { until = 8, samples = 40 }
        engine = { dsmc-boltzmann = { cell_size = 1 } }
    "#;
    let plan = case(text);
    let column = flow::column(&plan, &plan.engines[0])
        .expect("theory")
        .expect("a column");
    let layer = |plan: &CasePlan, low: f64| flow::density(plan, &column, Some(0), [low, low + 2.0]);
    let all: f64 = (0..10)
        .map(|layer_number| 20.0 * layer(&plan, 2.0 * f64::from(layer_number)))
        .sum();
    near(all, 100.0, 100.0);
    let up = case(&text.replace("-0.1", "0.1"));
    near(layer(&plan, 4.0), layer(&up, 14.0), 1.0);
    // Not with inelastic particles, moving floors, or exact disks beside them.
    for (old, new) in [
        ("diameter = 0.01", "diameter = 0.01, restitution = 0.9"),
        (
            "bottom = \"specular\"",
            "bottom = { restitution = 1, vibration = { amplitude = 1, period = 1 } }",
        ),
        ("engine = { ", "engine = { ed = {}, "),
        ("top = \"specular\"", "top = { temperature = 1 }"),
    ] {
        let other = case(&text.replace(old, new));
        let engine = other.engines.last().expect("an engine");
        assert_eq!(flow::column(&other, engine), Ok(None), "{new}");
    }
}
