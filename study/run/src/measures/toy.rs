//! Mock simulation whose velocities follow a formula, and tests of measures on it.

use std::path::Path;
use std::sync::Arc;

use nalgebra::{Vector3, vector};
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use stosszahl_analysis::structure_factor::direct_shells;
use stosszahl_model::{
    Budget, Collision, Failure, Interrupt, Observer, Particle, Particles, Simulation, WorkCounters,
};
use stosszahl_results::{Table, TableCell};

use crate::measure::{CompletedRun, Measure, ReplicaRecords, RunStop, SampleContext};
use crate::plan::CasePlan;

/// Velocity of a particle at a time, as a function of its initial velocity and the time.
type Law = Arc<dyn Fn(Vector3<f64>, f64) -> Vector3<f64> + Send + Sync>;

/// Mock simulation: particles at rest in space whose velocities follow a formula. Displacements are
/// those of the initial velocities.
#[derive(Clone)]
struct ScriptedSimulation {
    start: Particles,
    law: Law,
    time: f64,
    collisions: Vec<Collision>,
    followed: Option<f64>,
}

impl Simulation for ScriptedSimulation {
    fn time(&self) -> f64 {
        self.time
    }
    fn dimension(&self) -> usize {
        self.start.dimension
    }
    fn particle_count(&self) -> usize {
        self.start.all.len()
    }
    fn mean_weight(&self) -> f64 {
        1.0
    }
    fn advance(
        &mut self,
        until: f64,
        _budget: Budget,
        observer: &mut dyn Observer,
    ) -> Result<bool, Failure> {
        let due = |one: &&Collision| self.time < one.time && one.time <= until;
        let batch: Vec<Collision> = self.collisions.iter().filter(due).copied().collect();
        observer.on_collisions(&batch);
        self.time = until;
        Ok(true)
    }
    fn set_stop_flag(&mut self, _interrupt: &Interrupt) {}
    fn set_pause_flag(&mut self, _pause: &Interrupt) {}

    fn is_interrupted(&self) -> bool {
        false
    }
    fn visit_particles(&self, look: &mut dyn FnMut(&Particle)) {
        self.particles().all.iter().for_each(look);
    }
    fn particles(&self) -> Particles {
        let mut now = self.start.clone();
        now.time = self.time;
        for one in &mut now.all {
            one.velocity = (self.law)(one.velocity, self.time);
        }
        now
    }
    fn add_velocities(&mut self, _changes: &[Vector3<f64>]) -> Result<(), Failure> {
        Ok(())
    }
    fn scale_velocities(&mut self, _factor: f64) -> Result<(), Failure> {
        Ok(())
    }
    fn save_checkpoint(&self) -> Result<Vec<u8>, Failure> {
        Ok(Vec::new())
    }
    fn work_counters(&self) -> WorkCounters {
        let done = self.collisions.iter().filter(|one| one.time <= self.time);
        WorkCounters {
            collisions: done.count() as u64,
            ..WorkCounters::default()
        }
    }
    fn memory_bytes(&self) -> usize {
        0
    }
    fn track_displacements(&mut self) -> bool {
        self.followed = Some(self.time);
        true
    }
    fn displacements(&self) -> Option<Vec<Vector3<f64>>> {
        let passed = self.time - self.followed?;
        Some(
            self.start
                .all
                .iter()
                .map(|one| one.velocity * passed)
                .collect(),
        )
    }
}

/// Plans a case from text, with a title and a seed added.
fn plan(text: &str) -> CasePlan {
    let text = format!("format = 2\ntitle = \"toy\"\n{text}");
    let case = toml::from_str(&text).expect("a case");
    CasePlan::new(&case, Path::new(".")).expect("a plan")
}

/// Plans a case of disks at restitution 0.9 in a box, with exact dynamics, Monte Carlo and a
/// measure.
fn disks(measure: &str) -> CasePlan {
    plan(&format!(
        "[gas]\nnumber = 60\nrestitution = 0.9\n[box]\npacking_fraction = 0.1\n[engine.ed]\n[engine.dsmc-boltzmann]\n\
         [run]\nuntil = 4\nfirst_sample = 1\nsamples_per_decade = 2\n[measure.{measure}]"
    ))
}

/// Creates a mock simulation at random places, with speeds of order one.
fn gas(plan: &CasePlan, seed: u64, law: Law) -> ScriptedSimulation {
    let mut stream = Xoshiro256PlusPlus::seed_from_u64(seed);
    let mut all = Vec::new();
    for (species, one) in plan.gas.species.iter().enumerate() {
        for _ in 0..one.count {
            let mut part = |side: f64| side * stream.random::<f64>();
            let [x, y, z] = plan.gas.lengths;
            all.push(Particle {
                position: vector![part(x), part(y), part(z)],
                velocity: vector![part(2.0) - 1.0, part(2.0) - 1.0, 0.0],
                spin: Vector3::zeros(),
                radius: one.radius,
                mass: one.mass,
                spin_energy: 0.0,
                species: species as u32,
                weight: 1.0,
            });
        }
    }
    let start = Particles {
        time: 0.0,
        dimension: plan.gas.dimension,
        lengths: plan.gas.lengths,
        periodic: [true; 3],
        all,
    };
    ScriptedSimulation {
        start,
        law,
        time: 0.0,
        collisions: Vec::new(),
        followed: None,
    }
}

/// Runs a measure on the mock simulations of all engines and replicas, and returns its tables.
/// Halfway each probe is saved and loaded into a new one.
fn tables(
    plan: &CasePlan,
    measure: &dyn Measure,
    toys: &[ScriptedSimulation],
) -> (Vec<Table>, Vec<Vec<CompletedRun>>) {
    measure.check_options(plan).expect("a measure");
    let mut times = measure.sample_times(plan);
    times.sort_by(f64::total_cmp);
    times.dedup();
    let run = |engine, toy: &ScriptedSimulation| {
        let mut toy = toy.clone();
        let mut probe = measure.new_probe(plan, engine);
        probe.on_start(&mut SampleContext::new(0.0, &mut toy));
        for &time in &times {
            let until = plan.engine_time(time);
            let mut no_observer = ();
            match probe.collision_observer() {
                Some(observer) => toy.advance(until, Budget::Unlimited, observer),
                None => toy.advance(until, Budget::Unlimited, &mut no_observer),
            }
            .expect("a law");
            probe.on_stop(&RunStop {
                time: until,
                temperature: toy.temperature(),
                kicked_from: None,
            });
            probe.on_sample(&mut SampleContext::new(time, &mut toy));
            let bytes = probe.save_record().expect("a record");
            let mut next = measure.new_probe(plan, engine);
            next.load_record(&bytes).expect("the same record");
            assert_eq!(next.save_record().expect("a record"), bytes);
            probe = next;
        }
        CompletedRun {
            probes: vec![probe],
            work: toy.work_counters(),
            bytes: 0,
            seconds: 0.0,
        }
    };
    let finished: Vec<Vec<CompletedRun>> = plan
        .engines
        .iter()
        .map(|engine| toys.iter().map(|toy| run(engine, toy)).collect())
        .collect();
    let runs = ReplicaRecords {
        level: 0.01,
        measure: 0,
        finished: &finished,
    };
    let tables = measure.result_tables(plan, &runs);
    for table in &tables {
        for row in &table.rows {
            assert_eq!(row.len(), table.columns.len(), "{}", table.name);
        }
    }
    for verdict in measure.result_verdicts(plan, &runs, &tables) {
        assert!(verdict.sentence.len() <= 175, "{}", verdict.sentence);
    }
    (tables, finished)
}

/// Returns the numbers of a column; NaN for empty cells.
fn column(table: &Table, name: &str) -> Vec<f64> {
    let at = table.find_column(name).expect("a column");
    let number = |row: &Vec<TableCell>| match row[at] {
        TableCell::Number(number) => number,
        TableCell::Count(count) => count as f64,
        _ => f64::NAN,
    };
    table.rows.iter().map(number).collect()
}

fn close(found: f64, expected: f64, tolerance: f64) {
    assert!(
        (found - expected).abs() <= tolerance,
        "{found} against {expected}"
    );
}

/// Tests the energy table on speeds that fall as 1/(1 + t): K/K(0) = (1 + t)^-2 in both engines.
/// Rounding: some ten operations.
#[test]
fn energies_and_their_comparison() {
    let plan = disks("energy");
    let unit = plan.clock.time;
    let law: Law = Arc::new(move |v, t| v / (1.0 + t / unit));
    let toys = [1, 2, 3].map(|seed| gas(&plan, seed, law.clone()));
    let (tables, _) = tables(&plan, &super::energy::EnergyMeasure, &toys);
    let [energy, comparison, replicas] = &tables[..] else {
        panic!("three tables");
    };
    assert_eq!(
        (
            energy.rows.len(),
            comparison.rows.len(),
            replicas.rows.len()
        ),
        (8, 4, 24)
    );
    for (time, ratio) in column(energy, "time")
        .iter()
        .zip(column(energy, "energy_ratio"))
    {
        close(ratio, (1.0 + time).powi(-2), 1e-14);
    }
    assert_eq!(column(comparison, "energy_ratio_a_over_b"), [1.0; 4]);
    let theory = column(energy, "energy_ratio_theory");
    close(theory[3], plan.haff_ratio(4.0).expect("a law"), 0.0);
}

/// Tests velocity correlations and displacements on turning velocities: C(t) = cos(w t) and v^2
/// t^2.
#[test]
fn correlations_and_displacements_of_known_motion() {
    let mut plan = disks("velocity_autocorrelation");
    let unit = plan.clock.time;
    let law: Law = Arc::new(move |v, t| {
        let (sine, cosine) = (t / unit).sin_cos();
        vector![cosine * v.x - sine * v.y, sine * v.x + cosine * v.y, 0.0]
    });
    let toys = [gas(&plan, 4, law)];
    let measure = super::velocity_autocorrelation::VelocityAutocorrelation;
    let (found, _) = tables(&plan, &measure, &toys);
    let times = column(&found[0], "lag");
    assert_eq!(times.len(), 8);
    for (time, correlation) in times.iter().zip(column(&found[0], "correlation")) {
        close(correlation, time.cos(), 1e-12);
    }
    plan.case.measure.clear();
    let table = "from = 0.5".parse().expect("a table");
    plan.case.measure.insert("displacement".into(), table);
    let (found, _) = tables(&plan, &super::displacement::DisplacementMeasure, &toys);
    let squares = toys[0]
        .start
        .all
        .iter()
        .map(|one| one.velocity.norm_squared());
    let mean = squares.sum::<f64>() / 60.0;
    let elapsed = column(&found[0], "lag");
    assert_eq!(elapsed[2], 3.5);
    for (passed, square) in elapsed
        .iter()
        .zip(column(&found[0], "mean_squared_displacement"))
    {
        let expected = mean * (plan.clock.time * passed * plan.scale.length).powi(2);
        close(square / expected, 1.0, 1e-12);
    }
}

/// Tests S(k) of the longest waves against direct sums, which the grid meets to (1/15)^4, and g(r)
/// against all pairs, exactly.
#[test]
fn structure_against_plain_sums() {
    let plan = disks("structure_factor");
    let toy = gas(&plan, 5, Arc::new(|v, _| v));
    let positions: Vec<_> = toy.start.all.iter().map(|one| one.position.xy()).collect();
    let [x, y, _] = plan.gas.lengths;
    let toys = [toy];
    let (found, _) = tables(&plan, &super::structure_factor::StructureFactors, &toys);
    let plain = direct_shells(&positions, [x, y], 3, 1.0).expect("shells");
    for (found, plain) in column(&found[0], "structure_factor")
        .iter()
        .zip(&plain.shells)
    {
        close(found / plain.value, 1.0, 0.01);
    }
    let (found, _) = tables(&plan, &super::pair_correlation::PairCorrelations, &toys);
    let g = column(&found[0], "g");
    let range = 6.0_f64.min(0.499_999 * x.min(y));
    let width = range / (range / 0.05).round();
    let mut pairs = 0.0;
    for (index, a) in positions.iter().enumerate() {
        for b in &positions[..index] {
            let apart = |axis: usize, side: f64| {
                let gap = (a[axis] - b[axis]).abs();
                gap.min(side - gap)
            };
            pairs += f64::from(u8::from(apart(0, x).hypot(apart(1, y)) < range));
        }
    }
    let bins = (range / width).round() as usize;
    let area = |bin: usize| std::f64::consts::PI * width * width * (2 * bin + 1) as f64;
    let counted: f64 = (0..bins)
        .map(|bin| g[bin] * area(bin) * 0.5 * 60.0 * 59.0 / (x * y))
        .sum();
    close(counted, pairs, 1e-9);
}

/// Tests known impact parameters in known windows, in the plane and in space.
#[test]
fn impact_parameters_are_counted_in_windows() {
    for dimension in [2, 3] {
        let engine = ["[engine.ed]", "[engine.dsmc-boltzmann]"][dimension - 2];
        let plan = plan(&format!(
            "[gas]\ndimension = {dimension}\nnumber = 60\nrestitution = 0.9\n[box]\npacking_fraction = 0.1\n{engine}\n\
             [run]\nuntil = 4\n[measure.impact_parameters]\nwindows = [[0, 1], [1, 4]]\nbins = 4"
        ));
        let mut toy = gas(&plan, 6, Arc::new(|v, _| v));
        for (time, impact) in [(0.5, 0.6), (2.0, 0.1), (3.0, 0.9), (3.5, 0.8)] {
            toy.collisions.push(Collision {
                time: plan.engine_time(time),
                ..Collision::at_contact(
                    vector![-(1.0_f64 - impact * impact).sqrt(), impact, 0.0],
                    Vector3::x(),
                    0.5,
                    0.9,
                )
            });
        }
        let (found, _) = tables(&plan, &super::impact_parameters::ImpactMeasure, &[toy]);
        let [bins, summary, dissipation] = &found[..] else {
            panic!("three tables: {}", found.len());
        };
        assert_eq!(
            column(bins, "count"),
            [0.0, 0.0, 1.0, 0.0, 1.0, 0.0, 0.0, 2.0]
        );
        let chaos = [[1.0; 4], [0.25, 0.75, 1.25, 1.75]][dimension - 2];
        assert_eq!(column(bins, "density_theory")[..4], chaos);
        let uniform = |impact: f64| impact.powi(dimension as i32 - 1);
        let mean = [0.1, 0.9, 0.8].map(uniform).iter().sum::<f64>() / 3.0;
        close(column(summary, "slope")[1], 12.0 * (mean - 0.5), 1e-12);
        close(column(summary, "mean_b_over_d")[0], 0.6, 1e-14);
        assert_eq!(column(dissipation, "collisions"), [1.0, 3.0]);
        let of = |name: &str| column(dissipation, name)[1];
        let product = of("rate_ratio") * of("speed_ratio") * of("impact_ratio");
        close(
            product * of("correlation_ratio") / of("dissipation_ratio"),
            1.0,
            1e-12,
        );
        let at_pair_speed = of("dissipation_ratio") / of("speed_ratio").powf(1.5);
        close(of("at_pair_speed") / at_pair_speed, 1.0, 1e-12);
    }
}

/// Tests temperatures of two species against a plain sum, and that a snapshot reads back.
#[test]
fn species_and_snapshots() {
    let mut plan = plan(
        "[gas]\nnumber = 40\nrestitution = 0.9\n[[species]]\nshare = 0.25\nmass = 3\n[[species]]\nshare = 0.75\n\
         [box]\npacking_fraction = 0.1\n[engine.ed]\n[run]\nuntil = 4\nfirst_sample = 1\nsamples_per_decade = 1",
    );
    let toy = gas(&plan, 7, Arc::new(|v, _| v));
    let toys = [toy.clone()];
    // The species of a box are read from the record of the whole gas.
    let (_, finished) = tables(&plan, &super::energy::EnergyMeasure, &toys);
    let runs = ReplicaRecords {
        level: 0.01,
        measure: 0,
        finished: &finished,
    };
    let found = super::species::SpeciesMeasure.result_tables(&plan, &runs);
    let plain = |species: usize| {
        let own = toy
            .start
            .all
            .iter()
            .filter(|one| one.species as usize == species);
        let sum: f64 = own
            .clone()
            .map(|one| one.mass * one.velocity.norm_squared())
            .sum();
        sum / (2.0 * own.count() as f64)
    };
    close(
        column(&found[0], "ratio_to_first")[1],
        plain(1) / plain(0),
        1e-14,
    );
    let temperature = column(&found[0], "temperature");
    close(temperature[0] / (plain(0) * plan.scale.energy), 1.0, 1e-14);

    plan.case
        .measure
        .insert("snapshots".into(), toml::Table::new());
    let measure = super::snapshots::SnapshotMeasure;
    let (_, finished) = tables(&plan, &measure, &toys);
    let runs = ReplicaRecords {
        level: 0.01,
        measure: 0,
        finished: &finished,
    };
    let files = measure.snapshot_files(&plan, &runs);
    assert_eq!(files[0].0.file, "snapshots/ed-0.xyz");
    assert_eq!((&*files[0].0.engine, files[0].0.time), ("ed", 4.0));
    let text = String::from_utf8(files[0].1.clone()).expect("text");
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!((lines[0], lines.len()), ("40", 42));
    let fields: Vec<f64> = lines[2]
        .split(' ')
        .map(|word| word.parse().expect("a number"))
        .collect();
    assert_eq!(fields[1], toy.start.all[0].position.x * plan.scale.length);
    assert_eq!(fields[8], toy.start.all[0].mass * plan.scale.mass);
}

/// Tests that frames are at times at which the run is sampled anyway, the first and the last among
/// them.
#[test]
fn frames_are_at_times_of_samples() {
    let mut plan = plan(
        "[gas]\nnumber = 40\nrestitution = 0.9\n[box]\npacking_fraction = 0.1\n[engine.ed]\n[run]\nuntil = 4\n\
         first_sample = 0.01\nsamples_per_decade = 6",
    );
    let toy = gas(&plan, 7, Arc::new(|v, _| v));
    let toys = [toy.clone()];
    let measure = super::frames::FrameMeasure;
    let all = plan.sample_times();
    assert!(measure.by_default(&plan) && measure.sample_times(&plan) == all);
    let table = "number = 5\nparticles = 10".parse().expect("a table");
    plan.case.measure.insert("frames".into(), table);
    let times = measure.sample_times(&plan);
    assert!(times.len() == 5 && times[0] == 0.0 && times[4] == 4.0);
    assert!(times.iter().all(|time| all.contains(time)));
    let (_, finished) = tables(&plan, &measure, &toys);
    let runs = ReplicaRecords {
        level: 0.01,
        measure: 0,
        finished: &finished,
    };
    let files = measure.player_frames(&plan, &runs);
    assert_eq!((files.len(), &*files[0].file), (1, "frames/ed.bin"));
    let frames = &files[0].frames;
    let found: Vec<f64> = frames.iter().map(|frame| frame.time).collect();
    assert_eq!(found, times);
    // The last frame has all; of the others each particle is drawn with probability 1/4.
    assert_eq!((frames[4].len(), frames[4].particles), (40, 40.0));
    assert!((1..=24).contains(&frames[1].len()) && frames[1].share == 4.0);
}

/// Tests that invalid options are refused with their key.
#[test]
fn bad_options_are_named() {
    let bad = |measure: &dyn Measure, table: &str| {
        let mut plan = disks("energy");
        let table = table.parse().expect("a table");
        plan.case.measure.insert(measure.name().into(), table);
        measure.check_options(&plan).expect_err("a bad option").key
    };
    let impact = super::impact_parameters::ImpactMeasure;
    assert_eq!(bad(&impact, "bins = 1"), "bins");
    assert_eq!(bad(&impact, "bins = 4\nwindow = 3"), "window");
    assert_eq!(bad(&impact, "windows = []"), "windows");
    assert_eq!(
        bad(&super::displacement::DisplacementMeasure, "from = 4"),
        "from"
    );
    assert_eq!(bad(&super::species::SpeciesMeasure, ""), "");
    assert_eq!(bad(&super::steady_state::SteadyState, ""), "");
}

/// Tests that each measure has a unique name, a schema and a description.
#[test]
fn measures_are_described() {
    let mut names: Vec<&str> = super::ALL.iter().map(|one| one.name()).collect();
    names.sort_unstable();
    names.dedup();
    assert_eq!(names.len(), super::ALL.len());
    for one in super::ALL {
        assert!(one.about().ends_with('.') && one.options_schema().as_object().is_some());
    }
}
