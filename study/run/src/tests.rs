//! Runs stopped after every segment continue to the same bytes, and plans agree with the
//! literature.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use stosszahl_case::CaseFile;
use stosszahl_model::random::Streams;
use stosszahl_model::{Budget, Collision, Interrupt, Observer};
use stosszahl_results::{Existing, VerdictKind};

use crate::check::question;
use crate::control::{CheckpointFile, Control};
use crate::engine_run::{EngineRun, PartError};
use crate::engines::{self, From};
use crate::judge;
use crate::measure::{
    CompletedRun, Measure, Needs, NoOptions, Probe, RunStop, SampleContext, SampleProbe, described,
    keeps_record,
};
use crate::measures::ALL;
use crate::plan::{CasePlan, EnginePlan};
use crate::start::{Preparation, StartError, is_prepared, placed};

/// Data seen by a probe: collisions, stops and samples, in numbers.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
struct Seen {
    collisions: f64,
    stops: Vec<f64>,
    samples: Vec<f64>,
}

struct All {
    record: Seen,
}

impl Observer for Seen {
    fn on_collisions(&mut self, batch: &[Collision]) {
        self.collisions += batch.iter().map(Collision::normal_square).sum::<f64>();
    }
}

impl Probe for All {
    fn collision_observer(&mut self) -> Option<&mut dyn Observer> {
        Some(&mut self.record)
    }
    fn on_start(&mut self, moment: &mut SampleContext<'_>) {
        moment.simulation.track_displacements();
    }
    fn on_stop(&mut self, stop: &RunStop) {
        self.record.stops.extend([stop.time, stop.temperature]);
        self.record.stops.extend(stop.kicked_from);
    }
    fn on_sample(&mut self, moment: &mut SampleContext<'_>) {
        let particles = moment.particles().all.iter();
        let sum: f64 = particles
            .map(|one| one.position.norm() + one.velocity.norm())
            .sum();
        let far = moment.simulation.displacements().unwrap_or_default();
        let far: f64 = far.iter().map(nalgebra::Vector3::norm).sum();
        self.record
            .samples
            .extend([moment.time, moment.heated, sum, far]);
    }
    keeps_record!();
}

struct Everything;

impl Measure for Everything {
    described!("everything", "All that a probe can see", NoOptions);

    fn sample_times(&self, plan: &CasePlan) -> Vec<f64> {
        plan.sample_times()
    }
    fn engine_needs(&self, plan: &CasePlan) -> Needs {
        Needs {
            displacements: plan.is_uniform() && !plan.is_rough() && plan.case.aggregation.is_none(),
            trajectories: 0,
        }
    }
    fn new_probe(&self, _plan: &CasePlan, _engine: &EnginePlan) -> Box<dyn Probe> {
        Box::new(All {
            record: Seen::default(),
        })
    }
}

fn plan(text: &str) -> CasePlan {
    let text = format!("format = 2\ntitle = \"a test\"\nreplicas = 1\n{text}");
    let file = CaseFile::from_text(Path::new("test.toml"), &text, &[]).expect("a case");
    CasePlan::new(&file.points[0].case, Path::new("")).expect("a plan")
}

fn seen(finished: &CompletedRun) -> Seen {
    let record = finished.probes[0].record().downcast_ref::<Seen>();
    record.cloned().expect("a record")
}

/// Runs each engine of a plan without a stop, and again with a stop after every segment; results
/// must be equal.
fn assert_resumes(text: &str) {
    let plan = plan(text);
    let streams = Streams::new(plan.case.seed, 0);
    let never = Interrupt::default();
    let start = if is_prepared(&plan) {
        let mut preparation = Preparation::new(&plan, streams, &never).expect("a start");
        while !preparation.leg(&plan, streams, &never).expect("a leg") {
            let bytes = postcard::to_stdvec(&preparation).expect("bytes");
            preparation = postcard::from_bytes(&bytes).expect("the same");
        }
        Some(preparation.particles(&plan, streams).expect("particles"))
    } else if plan.gas.lengths[0] > 0.0 {
        Some(placed(&plan, 0, streams, &never).expect("a start").0)
    } else {
        None
    };
    for engine in &plan.engines {
        let part = EngineRun {
            plan: &plan,
            engine,
            measures: &[&Everything],
            replica: 0,
            start: start.as_ref(),
        };
        let whole = part
            .run_engine(&Control::new(None, 1e9, &never, &|_, _| {}))
            .expect("a run");
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("part.snapshot");
        let mut stops = 0;
        let stopped = loop {
            let after_leg = Interrupt::default();
            let tell = |_: f64, _: u64| after_leg.raise();
            let file = CheckpointFile::alone(path.clone());
            let control = Control::new(Some(file), 1e9, &after_leg, &tell);
            match part.run_engine(&control) {
                Ok(finished) => break finished,
                Err(PartError::Interrupted) => stops += 1,
                Err(error) => panic!("{}: {error}", engine.name),
            }
        };
        assert!(stops > 5, "{}: {stops} stops", engine.name);
        assert_eq!(seen(&whole), seen(&stopped), "{}", engine.name);
        assert_eq!(whole.work, stopped.work, "{}", engine.name);
        assert!(whole.work.collisions > 10, "{}", engine.name);
    }
}

#[test]
fn driven_disks_resume_to_the_same_bytes() {
    assert_resumes(
        "[gas]\nnumber = 100\nrestitution = 0.8\n[box]\npacking_fraction = 0.2\n[start]\nequilibration = 2\n\
         [thermostat]\nkind = \"white-noise\"\nheating = 2\ninterval = 0.05\n[run]\nuntil = 1\n[engine.ed]\n[engine.dsmc-boltzmann]\n\
         [engine.dsmc-contact-point]\nsimulators_per_particle = 4\n",
    );
}

/// Disks of two masses, spheres, and rough disks between walls, in a Langevin bath.
#[test]
fn gases_in_a_langevin_bath_resume_to_the_same_bytes() {
    let bath = "[thermostat]\nkind = \"langevin\"\ndrag = 0.5\ninterval = 0.05\n[run]\nuntil = 1\n";
    assert_resumes(&format!(
        "[gas]\nnumber = 100\nrestitution = 0.8\n[[species]]\nshare = 0.5\n[[species]]\nshare = 0.5\nmass = 4.0\n[box]\n\
         packing_fraction = 0.2\n[start]\nequilibration = 2\n{bath}[engine.ed]\n[engine.dsmc-boltzmann]\n\
         [engine.dsmc-contact-point]\nsimulators_per_particle = 4\n"
    ));
    assert_resumes(&format!(
        "[gas]\nnumber = 200\ndimension = 3\nrestitution = 0.8\n[box]\npacking_fraction = 0.1\n{bath}[engine.dsmc-enskog]\n"
    ));
    assert_resumes(&format!(
        "[gas]\nnumber = 100\nrestitution = 0.8\ntangential_restitution = 0.5\n[box]\nsize = [20, 20]\n[walls]\nbottom = \
         {{ restitution = 0.9 }}\ntop = {{ temperature = 2 }}\n{bath}[engine.ed]\n[engine.dsmc-boltzmann]\n"
    ));
}

#[test]
fn disks_whose_velocities_are_scaled_resume_to_the_same_bytes() {
    assert_resumes(
        "[gas]\nnumber = 100\nrestitution = 0.8\n[box]\npacking_fraction = 0.2\n[start]\nequilibration = 2\n\
         [thermostat]\nkind = \"rescaling\"\ninterval = 0.05\n[run]\nuntil = 1\n[engine.ed]\n[engine.dsmc-contact-point]\nsimulators_per_particle = 4\n",
    );
}

/// Rescaling subtracts the mean velocity. Otherwise its rounding would grow by e^50 in this run,
/// and exceed all relative motion.
#[test]
fn scaled_disks_have_no_drift() {
    let plan = plan(
        "[gas]\nnumber = 30\nrestitution = 0.5\n[box]\npacking_fraction = 0.1\n[thermostat]\nkind = \"rescaling\"\ninterval = 0.1\n[run]\nuntil = 50\n\
         samples_per_decade = 1\n[engine.ed]\n",
    );
    let (streams, never) = (Streams::new(plan.case.seed, 0), Interrupt::default());
    let start = placed(&plan, 0, streams, &never).expect("a start").0;
    let part = EngineRun {
        plan: &plan,
        engine: &plan.engines[0],
        measures: &[&Drift],
        replica: 0,
        start: Some(&start),
    };
    let control = Control::new(None, 1e9, &never, &|_, _| {});
    let finished = part.run_engine(&control).expect("a run");
    let record = finished.probes[0].record().downcast_ref::<Vec<f64>>();
    let drift = record.and_then(|all| all.last()).expect("a sample");
    assert!(*drift < 1e-12, "{drift}");
}

/// Measure of the mean velocity of the gas.
struct Drift;

impl Measure for Drift {
    described!("drift", "The mean velocity", NoOptions);

    fn sample_times(&self, plan: &CasePlan) -> Vec<f64> {
        vec![plan.case.run.until]
    }
    fn new_probe(&self, _plan: &CasePlan, _engine: &EnginePlan) -> Box<dyn Probe> {
        Box::new(SampleProbe::new(Vec::<f64>::new(), |record, moment| {
            let all = &moment.particles().all;
            let sum: nalgebra::Vector3<f64> = all.iter().map(|one| one.velocity).sum();
            record.push(sum.norm() / all.len() as f64);
        }))
    }
}

/// Rescaled velocities are free cooling in another unit of time: exact disks move as far, with
/// equal collision numbers. Ten intervals h make 1 + t/t0 = (1 + h)^10 where the gas follows Haff's
/// law; 100 disks do so within some hundredths, which is the tolerance.
#[test]
fn scaled_disks_go_the_ways_of_those_that_cool() {
    let run = |thermostat: &str, until: f64| {
        let plan = plan(&format!(
            "[gas]\nnumber = 100\nrestitution = 0.8\n[box]\npacking_fraction = 0.2\n[start]\nequilibration = 2\n{thermostat}\
             [run]\nuntil = {until}\n[engine.ed]\n"
        ));
        let (streams, never) = (Streams::new(plan.case.seed, 0), Interrupt::default());
        let mut preparation = Preparation::new(&plan, streams, &never).expect("a start");
        while !preparation.leg(&plan, streams, &never).expect("a leg") {}
        let start = preparation.particles(&plan, streams).expect("particles");
        let part = EngineRun {
            plan: &plan,
            engine: &plan.engines[0],
            measures: &[&Everything],
            replica: 0,
            start: Some(&start),
        };
        let control = Control::new(None, 1e9, &never, &|_, _| {});
        let finished = part.run_engine(&control).expect("a run");
        let far = seen(&finished).samples.last().copied().expect("a sample");
        let passed = plan.cooling_logarithm(until, false).expect("it cools");
        let expected = plan.expected_collisions(until);
        (far, finished.work.collisions, passed, expected)
    };
    let scaled = run("[thermostat]\nkind = \"rescaling\"\ninterval = 0.05\n", 0.5);
    let free = run("", 1.05_f64.powi(10) - 1.0);
    assert!(scaled.1 > 200);
    let collisions = scaled.1 as f64 / free.1 as f64;
    assert!((collisions - 1.0).abs() < 0.05, "{scaled:?} {free:?}");
    assert!(
        (scaled.0 / free.0 - 1.0).abs() < 0.05,
        "{scaled:?} {free:?}"
    );
    assert!(
        (scaled.2 / free.2 - 1.0).abs() < 1e-12,
        "{scaled:?} {free:?}"
    );
    // With the Sonine factor c of the rate, (1 + c h)^10 replaces 1 + c ((1 + h)^10 - 1).
    assert!(
        (scaled.3 / free.3 - 1.0).abs() < 2e-3,
        "{scaled:?} {free:?}"
    );
}

#[test]
fn disks_of_two_sizes_resume_to_the_same_bytes() {
    assert_resumes(
        "[gas]\nnumber = 100\nrestitution = 0.8\n[[species]]\nshare = 0.5\n[[species]]\nshare = 0.5\ndiameter = 2.0\nmass = 4.0\n\
         [box]\npacking_fraction = 0.2\n[run]\nuntil = 2\n[engine.ed]\n[engine.dsmc-enskog]\nsimulators_per_particle = 2\n",
    );
}

#[test]
fn flows_resume_to_the_same_bytes() {
    assert_resumes(
        "[gas]\nnumber = 100\nrestitution = 0.9\n[box]\nsize = [20.0, 20.0]\n[walls]\nbottom = {temperature = 1.0}\n\
         top = {restitution = 0.9}\n[gravity]\nacceleration = [0.0, -0.1]\n[run]\nuntil = 10\nsamples = 20\n[engine.ed]\n\
         [engine.dsmc-contact-point]\nsimulators_per_particle = 2\n",
    );
}

#[test]
fn dense_monte_carlo_alone_starts_off_walls_and_obstacles() {
    let obstacle = "[[obstacle]]\ncircle = {centre = [10.0, 10.0], radius = 3.0}\n";
    for (engine, obstacle) in [
        ("enskog]\ndisplacement = false", obstacle),
        ("free-volume]\ndisplacement = false", obstacle),
        ("contact-point]", ""),
    ] {
        assert_resumes(&format!(
            "[gas]\nnumber = 60\nrestitution = 0.9\n[box]\nsize = [20.0, 20.0]\n[walls]\nbottom = \"specular\"\n\
             top = \"specular\"\n{obstacle}[run]\nuntil = 10\nsamples = 20\n[engine.dsmc-{engine}\n"
        ));
    }
}

#[test]
fn gases_without_positions_resume_to_the_same_bytes() {
    assert_resumes(
        "[gas]\ndimension = 3\nnumber = 200\nrestitution = 0.8\nvolume = 1000.0\n[run]\nuntil = 20\n\
         [engine.dsmc-homogeneous]\n",
    );
}

/// Observer that raises an interrupt after a number of collisions.
struct Raising {
    interrupt: Interrupt,
    left: u64,
}

impl Observer for Raising {
    fn on_collisions(&mut self, batch: &[Collision]) {
        self.left = self.left.saturating_sub(batch.len() as u64);
        if self.left == 0 {
            self.interrupt.raise();
        }
    }
}

/// Cases with engines of every kind.
const ALL_ENGINES: [&str; 2] = [
    "[gas]\nnumber = 400\nrestitution = 1.0\n[box]\npacking_fraction = 0.2\n[start]\nequilibration = 0\n[run]\nuntil = 20\n\
     [engine.ed]\n[engine.dsmc-boltzmann]\n[engine.dsmc-contact-point]\n[engine.dsmc-esmc]\n[engine.dsmc-stochastic-disks]\n",
    "[gas]\ndimension = 3\nnumber = 400\nrestitution = 1.0\nvolume = 4000.0\n[run]\nuntil = 1e3\n[engine.dsmc-homogeneous]\n",
];

/// An interrupt ends an advance after a few hundred events or proposals, or one step, and the
/// engine cannot continue.
#[test]
fn an_interrupt_breaks_any_engine_off() {
    for text in ALL_ENGINES {
        let plan = plan(text);
        for engine in &plan.engines {
            let interrupt = Interrupt::default();
            let streams = Streams::new(1, 0);
            let mut gas = engines::begin(
                &plan,
                engine,
                streams,
                Needs::default(),
                From::Start(None),
                &interrupt,
                None,
            )
            .expect("an engine");
            let mut observer = Raising {
                interrupt: interrupt.clone(),
                left: 600,
            };
            let reached = gas.advance(1e5, Budget::Unlimited, &mut observer);
            assert!(!reached.expect("a gas"), "{}", engine.name);
            assert!(gas.is_interrupted(), "{}", engine.name);
            // Collisions come in batches of some hundred, or by the step, in which a simulator
            // meets at most one other.
            let collisions = gas.work_counters().collisions;
            let most = 600 + 1200.max(gas.particle_count() as u64 / 2);
            assert!(
                (600..=most).contains(&collisions),
                "{}: {collisions}",
                engine.name
            );
            assert!(!gas.advance(1e5, Budget::Leg, &mut ()).expect("a gas"));
            assert_eq!(
                gas.work_counters().collisions,
                collisions,
                "{}",
                engine.name
            );
        }
    }
}

/// An interrupt stops placement and equilibration, and leaves the work done before unchanged.
#[test]
fn an_interrupt_ends_a_start() {
    let (never, now) = (Interrupt::default(), Interrupt::default());
    now.raise();
    let plan = plan(
        "[gas]\nnumber = 3000\nrestitution = 0.9\n[box]\npacking_fraction = 0.4\n[run]\nuntil = 1\n[engine.ed]\n",
    );
    let streams = Streams::new(1, 0);
    let placed = Preparation::new(&plan, streams, &now);
    assert!(matches!(placed, Err(StartError::Interrupted)));
    let mut start = Preparation::new(&plan, streams, &never).expect("a start");
    let before = postcard::to_stdvec(&start).expect("bytes");
    let leg = start.leg(&plan, streams, &now);
    assert!(matches!(leg, Err(StartError::Interrupted)));
    assert_eq!(postcard::to_stdvec(&start).expect("bytes"), before);
    assert!(!start.leg(&plan, streams, &never).expect("a leg"));
}

/// More threads than any machine has are refused, for every option.
#[test]
fn threads_have_a_limit() {
    let folder = tempfile::tempdir().expect("a folder");
    let text = "format = 2\ntitle = \"few\"\nreplicas = 1\n[gas]\nnumber = 4\n[box]\npacking_fraction = 0.1\n[start]\n\
                equilibration = 0\n[run]\nuntil = 1\n[engine.dsmc-boltzmann]\n";
    let file = crate::format().from_text(Path::new("case.toml"), text, &[]);
    let file = file.expect("a case");
    let options = crate::RunOptions {
        out: Some(folder.path().join("out")),
        existing: Existing::Refuse,
        threads: Some(1025),
        ignore_memory_limit: false,
        stop: &Interrupt::default(),
        progress: &(),
        commit: "",
    };
    let refused = crate::run_case(&file, &options).expect_err("too many");
    assert!(refused.to_string().contains("from 1 to 1024"), "{refused}");
}

/// A part interrupted in the middle of a segment, each time a little later, ends with the same
/// numbers: the segment leaves nothing behind.
#[test]
fn a_leg_that_is_broken_off_leaves_nothing_behind() {
    let plan = plan(ALL_ENGINES[0]);
    let never = Interrupt::default();
    let start = placed(&plan, 0, Streams::new(plan.case.seed, 0), &never)
        .expect("a start")
        .0;
    for engine in &plan.engines {
        let run = |measures: &[&'static dyn Measure], path: Option<PathBuf>, stop: &Interrupt| {
            let part = EngineRun {
                plan: &plan,
                engine,
                measures,
                replica: 0,
                start: Some(&start),
            };
            let file = path.map(CheckpointFile::alone);
            part.run_engine(&Control::new(file, 1e9, stop, &|_, _| {}))
        };
        let eager = |interrupt: &Interrupt, left| -> &'static Eager {
            Box::leak(Box::new(Eager(interrupt.clone(), left)))
        };
        let whole = run(&[&Everything], None, &never).expect("a run");
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("part.snapshot");
        for left in [1, 1000, 2000] {
            let interrupt = Interrupt::default();
            let measures: [&dyn Measure; 2] = [&Everything, eager(&interrupt, left)];
            let ended = run(&measures, Some(path.clone()), &interrupt);
            assert!(
                matches!(ended, Err(PartError::Interrupted)),
                "{}",
                engine.name
            );
        }
        // A slow machine has kept a state of both measures.
        let idle = eager(&Interrupt::default(), 1);
        let last = run(&[&Everything, idle], Some(path), &never).expect("a run");
        assert_eq!(seen(&whole), seen(&last), "{}", engine.name);
        assert_eq!(whole.work, last.work, "{}", engine.name);
    }
}

/// Few simulators per cell change the collision rate by more than the margin: comparisons are void,
/// before and after the run. With the default number they are not, whatever the collision rate of
/// the scheme.
#[test]
fn comparisons_with_large_numerical_errors_are_void() {
    let case = |engines: &str| {
        plan(&format!(
            "[gas]\nrestitution = 0.8\nnumber = 400\n[box]\npacking_fraction = 0.25\n[run]\nuntil = 1\n[engine.ed]\n{engines}"
        ))
    };
    let few = case("[engine.dsmc-enskog]\ncell_size = 2\n[engine.dsmc-contact-point]\n");
    let reasons: Vec<_> = few
        .engines
        .iter()
        .map(|one| few.numerical_error(one))
        .collect();
    assert!(reasons[0].is_none() && reasons[2].is_none());
    let reason = reasons[1].as_ref().expect("a reason");
    assert!(reason.starts_with("DSMC Enskog has 1."), "{reason}");
    let void = judge::void(
        judge::verdict("energy", "They differ.", VerdictKind::Differ),
        reason,
    );
    assert_eq!(void.kind, VerdictKind::Void);
    assert!(void.sentence.starts_with("Void, for DSMC Enskog has 1."));
    let named = few
        .notes
        .warnings
        .iter()
        .filter(|one| one.contains("are void"));
    assert_eq!(named.count(), 1, "{:?}", few.notes.warnings);
    let many = case(
        "[engine.dsmc-boltzmann]\n[engine.dsmc-free-volume]\n[engine.dsmc-enskog]\n[engine.dsmc-esmc]\n\
         [engine.dsmc-stochastic-disks]\n[engine.dsmc-contact-point]\n",
    );
    let void = |engine: &&crate::plan::EnginePlan| many.numerical_error(engine).is_some();
    let void: Vec<_> = many
        .engines
        .iter()
        .filter(void)
        .map(|one| one.name)
        .collect();
    assert_eq!(void, ["dsmc-stochastic-disks"]);
    // By theory a dilute gas cools more slowly than exact disks; both notes on rates say so.
    let [exact, dilute] = [&many.engines[0], &many.engines[1]];
    let expected = many.stated_rates([exact, dilute], 1.0).expect("a rate");
    assert!(
        expected.contains("(DSMC Boltzmann) of Enskog's collision rate, which gives -"),
        "{expected}"
    );
    assert!(many.stated_rates([exact, &many.engines[3]], 1.0).is_none());
    let named = many
        .notes
        .warnings
        .iter()
        .filter(|one| one.contains("its theory has 0."));
    assert_eq!(named.count(), 2, "{:?}", many.notes.warnings);
}

/// The question names the engine whose verdict comes first; an engine that is not in the case is
/// refused.
#[test]
fn the_question_names_the_engine_of_the_headline() {
    let case = |engine: &str| {
        plan(&format!(
            "question = {{ engine = \"{engine}\" }}\n[gas]\nnumber = 60\n[box]\npacking_fraction = 0.1\n[run]\nuntil = 1\n\
             [engine.ed]\n[engine.dsmc-enskog]\n[engine.dsmc-contact-point]\n"
        ))
    };
    let energy = ALL.iter().find(|one| one.name() == "energy");
    let measures = [*energy.expect("a measure")];
    let named = case("dsmc-contact-point");
    let verdict = |topic: &str| judge::verdict(topic, "", VerdictKind::Undecided);
    let mut verdicts = [
        verdict("energy, ED (exact) against DSMC Enskog"),
        verdict("energy, ED (exact) against DSMC contact point"),
        verdict("energy, DSMC Enskog against DSMC contact point"),
    ];
    let [first, second, third] = verdicts.clone();
    question::put_first(&named, &mut verdicts);
    assert_eq!(verdicts, [second, first, third]);
    assert_eq!(
        question::headline(&named, &measures),
        "energy, DSMC contact point"
    );
    assert!(question::check_question(&named, &measures, |_| Vec::new()).is_ok());
    let error =
        question::check_question(&case("dsmc-esmc"), &measures, |_| Vec::new()).expect_err("none");
    assert_eq!(error.key, "question.engine");
    assert!(
        error
            .allowed
            .ends_with("ed, dsmc-enskog, dsmc-contact-point"),
        "{error:?}"
    );
}

/// A sample that is interrupted, here between two measures, is discarded and taken again.
#[test]
fn a_measurement_that_is_broken_off_is_made_again() {
    let plan = plan(ALL_ENGINES[0]);
    let never = Interrupt::default();
    let start = placed(&plan, 0, Streams::new(plan.case.seed, 0), &never)
        .expect("a start")
        .0;
    let mut all = ALL.iter().copied();
    let pairs = all.find(|one| one.name() == "pair_correlation");
    let pairs = pairs.expect("a measure");
    let run = |eager: &'static Eager, path: &Path, stop: &Interrupt| {
        let part = EngineRun {
            plan: &plan,
            engine: &plan.engines[1],
            measures: &[&Everything, eager, pairs],
            replica: 0,
            start: Some(&start),
        };
        let file = CheckpointFile::alone(path.to_owned());
        part.run_engine(&Control::new(Some(file), 1e9, stop, &|_, _| {}))
    };
    let folder = tempfile::tempdir().expect("a folder");
    let eager = |interrupt: &Interrupt| Box::leak(Box::new(Eager(interrupt.clone(), 0)));
    let [path, other] = ["part", "whole"].map(|name| folder.path().join(name));
    let stop = Interrupt::default();
    let ended = run(eager(&stop), &path, &stop);
    assert!(matches!(ended, Err(PartError::Interrupted)));
    let [last, whole] = [path, other].map(|path| {
        let finished = run(eager(&Interrupt::default()), &path, &never).expect("a run");
        finished.probes[2].save_record().expect("bytes")
    });
    assert!(last == whole);
}

/// Measure that raises an interrupt after a number of collisions; after zero, when it samples.
struct Eager(Interrupt, u64);

struct EagerProbe(Raising);

impl Probe for EagerProbe {
    fn collision_observer(&mut self) -> Option<&mut dyn Observer> {
        Some(&mut self.0)
    }
    fn on_sample(&mut self, _moment: &mut SampleContext<'_>) {
        if self.0.left == 0 {
            self.0.interrupt.raise();
        }
    }
    fn save_record(&self) -> Result<Vec<u8>, postcard::Error> {
        Ok(Vec::new())
    }
    fn load_record(&mut self, _bytes: &[u8]) -> Result<(), postcard::Error> {
        Ok(())
    }
    fn record(&self) -> &dyn std::any::Any {
        &()
    }
}

impl Measure for Eager {
    described!("eager", "Ends the run early", NoOptions);

    fn sample_times(&self, plan: &CasePlan) -> Vec<f64> {
        plan.sample_times()
    }

    fn new_probe(&self, _plan: &CasePlan, _engine: &EnginePlan) -> Box<dyn Probe> {
        Box::new(EagerProbe(Raising {
            interrupt: self.0.clone(),
            left: self.1,
        }))
    }
}

/// A gas that falls and is not heated comes to rest, which is reported before the run.
#[test]
fn a_gas_that_will_rest_is_named() {
    let text = "format = 2\ntitle = \"a test\"\nreplicas = 2\n[gas]\nnumber = 100\nrestitution = RESTITUTION\n[box]\nsize = [20, 40]\n\
                [walls]\nbottom = FLOOR\ntop = \"specular\"\n[gravity]\nacceleration = [0, GRAVITY]\n[run]\nuntil = 1\n[engine.ed]\n";
    for (restitution, floor, gravity, settled_particles) in [
        ("0.9", "\"specular\"", "-1", true),
        ("1", "{ restitution = 0.5 }", "-1", true),
        ("0.9", "{ temperature = 1 }", "-1", false),
        (
            "0.9",
            "{ restitution = 1, vibration = { amplitude = 0.5, period = 0.1 } }",
            "-1",
            false,
        ),
        ("1", "\"specular\"", "-1", false),
        ("0.9", "\"specular\"", "-0.1", false),
    ] {
        let text = text.replace("RESTITUTION", restitution);
        let text = text.replace("FLOOR", floor).replace("GRAVITY", gravity);
        let file = CaseFile::from_text(Path::new("test.toml"), &text, &[]).expect("a case");
        let plan = CasePlan::new(&file.points[0].case, Path::new(".")).expect("a plan");
        let said = plan
            .notes
            .warnings
            .iter()
            .any(|one| one.starts_with("gravity: "));
        assert_eq!(said, settled_particles, "{text}{:?}", plan.notes.warnings);
    }
}

/// A key with another common name is suggested by that name.
#[test]
fn other_names_lead_to_keys() {
    let format = crate::check::format();
    let keys = serde_json::to_string(format.json()).expect("a schema");
    for (other, key) in stosszahl_case::SYNONYMS {
        // A key, or the one value that has other names.
        let known = if *key == "specular" { "" } else { ":" };
        assert!(keys.contains(&format!("\"{key}\"{known}")), "{key}");
        assert_ne!(other, key);
    }
    let text = "format = 2\ntitle = \"a test\"\n[gas]\nnumber = 100\nrestitution = 0.9\n[box]\npacking_fraction = 0.1\n[run]\nuntil = 1\n\
                [engine.ed]\n[measure.msd]\n";
    let error = format.from_text(Path::new("test.toml"), text, &[]);
    let said = error.expect_err("no such measure").to_string();
    assert!(said.contains("did you mean displacement?"), "{said}");
}

/// A few large particles among many small ones make a scheme slow whose majorant is that of the
/// largest pair, and this is reported; exact dynamics has no such candidates.
#[test]
fn slow_schemes_are_called_slow() {
    let text = "format = 2\ntitle = \"a test\"\nreplicas = 1\n[gas]\nnumber = 1000\nrestitution = 0.9\n[[species]]\nshare = 0.999\n\
                [[species]]\nshare = 0.001\ndiameter = DIAMETER\n[box]\npacking_fraction = 0.1\n[run]\nuntil = 1\n[engine.ed]\n\
                [engine.dsmc-esmc]\n";
    for (diameter, slow) in [("1.5", false), ("100", true)] {
        let text = text.replace("DIAMETER", diameter);
        let file = CaseFile::from_text(Path::new("test.toml"), &text, &[]).expect("a case");
        let planned = crate::check_case(&file).expect("a plan");
        let outline = planned[0].outline(1);
        let said = outline
            .warnings
            .iter()
            .any(|one| one.starts_with("ESMC: slow"));
        assert_eq!(said, slow, "{:?}", outline.warnings);
        assert!(outline.cost.engines[0].trials_per_collision.is_none());
        let trials = outline.cost.engines[1]
            .trials_per_collision
            .expect("trials");
        assert!((trials > 50.0) == slow, "{trials}");
    }
}

/// The warning that a sheared gas keeps to one thread is about exact disks, so it is left out where
/// there are none. Wide cells carry no momentum of a uniform shear flow, and are not warned of.
#[test]
fn warnings_of_a_shear_flow_are_of_its_engines() {
    for (engine, told) in [("ed", true), ("dsmc-enskog", false)] {
        let text = format!(
            "format = 2\ntitle = \"a test\"\nreplicas = 2\n[gas]\nnumber = 100\nrestitution = 0.9\n[box]\npacking_fraction = 0.4\n\
             shear_rate = 0.9\n[run]\nuntil = 1\n[engine.{engine}]\n"
        );
        let file = CaseFile::from_text(Path::new("test.toml"), &text, &[]).expect("a case");
        let planned = crate::check_case(&file).expect("a plan");
        let warnings = planned[0].outline(1).warnings;
        let said = warnings.iter().any(|one| one.contains("on one thread"));
        assert_eq!(said, told, "{engine}: {warnings:?}");
        let wide = warnings
            .iter()
            .any(|one| one.contains("mean free paths wide"));
        assert!(!wide, "{engine}: {warnings:?}");
    }
}

/// The elastic twin of `contacts` has the collisions of the gas up to the last window, and adds as
/// many to the time of exact disks. Monte Carlo and elastic gases have no twin.
#[test]
fn elastic_twins_take_their_time() {
    let text = "format = 2\ntitle = \"a test\"\nreplicas = 2\n[gas]\nnumber = 1000\nrestitution = 0.9\n[box]\npacking_fraction = 0.1\n\
                [run]\nuntil = 20\n[engine.ed]\n[engine.dsmc-boltzmann]\n[measure.contacts]\n";
    let times = |changed: &str| {
        let file = CaseFile::from_text(Path::new("test.toml"), changed, &[]).expect("a case");
        let planned = crate::check_case(&file).expect("a plan");
        let plan = &planned[0].plan;
        let found = planned[0].cost(1).pace.engines;
        let alone = crate::cost::estimate_runtime(plan, &[]).engines;
        assert_eq!(found[1], alone[1]);
        let work =
            crate::measure::work_with_companions(&planned[0].measures, plan, &plan.engines[0]);
        for which in [0, 1] {
            let ratio = found[0][which] / alone[0][which];
            assert!((ratio - work[which]).abs() < 1e-12, "{ratio} {work:?}");
        }
        (work, plan.done_share(5.0))
    };
    let (whole, _) = times(&text.replace("contacts]", "contacts]\nwindows = [[0, 5], [5, 20]]"));
    assert_eq!(whole, [2.0; 2]);
    let (early, share) = times(&text.replace("contacts]", "contacts]\nwindows = [[0, 5]]"));
    assert!(share > 0.1 && share < 0.9, "{share}");
    assert_eq!(early, [1.0 + share; 2]);
    for (from, to) in [
        ("contacts]", "contacts]\nelastic_twin = false"),
        ("restitution = 0.9", "restitution = 1"),
        ("[measure.contacts]", ""),
    ] {
        assert_eq!(times(&text.replace(from, to)).0, [1.0; 2], "{to}");
    }
}

/// Haff's time `t_0 = sqrt(pi)/(2 (1 - r^2) phi chi) d sqrt(m/T)`, with the speed of the paper,
/// `<v^2> = (0.2047 m/s)^2` and thus `T/m = 0.2047^2/2`. Tolerance: a few roundings.
#[test]
fn luding_1998_has_the_published_time() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../cases/luding-1998.toml");
    let file = CaseFile::read(&path, &[]).expect("a case");
    let plan = CasePlan::new(&file.points[0].case, Path::new("")).expect("a plan");
    let chi = stosszahl_model::equation_of_state::contact_value(0.25);
    let reduced = std::f64::consts::PI.sqrt() / (2.0 * 0.36 * 0.25 * chi);
    let wanted = reduced * 0.001 / (0.2047 * 0.5_f64.sqrt());
    assert!((plan.time_in_case() / wanted - 1.0).abs() < 1e-14);
    assert_eq!(plan.count(), 99856);
    let names: Vec<&str> = plan.engines.iter().map(|engine| engine.name).collect();
    assert_eq!(names, ["ed", "dsmc-free-volume", "dsmc-enskog"]);
}

/// The critical length at packing 0.25 and restitution 0.8 is 17.311 d; a box of 0.8 of it holds
/// 61.05 disks.
#[test]
fn a_box_in_critical_lengths_says_the_number_of_disks() {
    let text = "[gas]\nrestitution = 0.8\n[box]\npacking_fraction = 0.25\nwidth_over_critical_length = 0.8\n[run]\nuntil = 1\n[engine.ed]\n";
    let small = plan(text);
    assert_eq!(small.count(), 61);
    assert!(!small.has_unstable_modes());
    let wide = plan(&text.replace("0.8\n[run]", "1.1\n[run]"));
    assert_eq!((wide.count(), wide.has_unstable_modes()), (115, true));
    let file = text.replace("0.8\n[run]", "1e-3\n[run]");
    let file = format!("format = 2\ntitle = \"a test\"\n{file}");
    let file = CaseFile::from_text(Path::new("test.toml"), &file, &[]).expect("a case");
    let refused = CasePlan::new(&file.points[0].case, Path::new("")).expect_err("no disks");
    assert_eq!(refused.key, "box.width_over_critical_length");
}

/// In SI units, temperatures of all species replace that of the gas.
#[test]
fn species_with_temperatures_need_none_of_the_gas() {
    let text = "units = \"si\"\n[gas]\nvolume = 1e-6\n[run]\nuntil = 1\n\
                [[species]]\nnumber = 10\ndiameter = 1e-4\nmass = 1e-9\ntemperature = 1e-12\n\
                [[species]]\nnumber = 10\ndiameter = 2e-4\nmass = 8e-9\ntemperature = 2e-12\n";
    let plan = plan(text);
    assert_eq!(plan.temperatures(), [1e-12, 2e-12]);
}
