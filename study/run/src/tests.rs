//! A run that is stopped after every leg goes on to the same bytes, and plans have the numbers of the literature.

use std::path::Path;
use std::sync::atomic::AtomicBool;

use serde::{Deserialize, Serialize};
use stosszahl_case::CaseFile;
use stosszahl_model::random::Streams;
use stosszahl_model::{Collision, Observer};

use crate::control::Control;
use crate::follow::{Part, PartError};
use crate::measure::{
    Finished, Measure, Moment, Needs, NoOptions, Probe, Stop, described, keeps_record,
};
use crate::plan::{EnginePlan, Plan};
use crate::start::{Preparation, is_prepared, placed};

/// All that a probe can see, in numbers.
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
    fn collisions(&mut self, batch: &[Collision]) {
        self.collisions += batch.iter().map(Collision::normal_square).sum::<f64>();
    }
}

impl Probe for All {
    fn observer(&mut self) -> Option<&mut dyn Observer> {
        Some(&mut self.record)
    }
    fn begin(&mut self, moment: &mut Moment<'_>) {
        moment.simulation.follow_displacements();
    }
    fn stop(&mut self, stop: &Stop) {
        self.record.stops.extend([stop.time, stop.temperature]);
        self.record.stops.extend(stop.kicked_from);
    }
    fn sample(&mut self, moment: &mut Moment<'_>) {
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

    fn times(&self, plan: &Plan) -> Vec<f64> {
        plan.sample_times()
    }
    fn needs(&self, plan: &Plan) -> Needs {
        Needs {
            displacements: plan.kind != stosszahl_case::Kind::Flow && plan.case.sticking.is_none(),
            trajectories: 0,
        }
    }
    fn probe(&self, _plan: &Plan, _engine: &EnginePlan) -> Box<dyn Probe> {
        Box::new(All {
            record: Seen::default(),
        })
    }
}

fn plan(text: &str) -> Plan {
    let text = format!("format = 2\ntitle = \"a test\"\nreplicas = 1\n{text}");
    let file = CaseFile::from_text(Path::new("test.toml"), &text, &[]).expect("a case");
    Plan::new(&file.points[0].case, Path::new("")).expect("a plan")
}

fn seen(finished: &Finished) -> Seen {
    let record = finished.probes[0].record().downcast_ref::<Seen>();
    record.cloned().expect("a record")
}

/// Runs each engine of a plan at a stretch, and again with a stop after every leg.
fn assert_resumes(text: &str) {
    let plan = plan(text);
    let streams = Streams::new(plan.case.seed, 0);
    let start = if is_prepared(&plan) {
        let mut preparation = Preparation::new(&plan, streams).expect("a start");
        while !preparation.leg(&plan, streams).expect("a leg") {
            let bytes = postcard::to_stdvec(&preparation).expect("bytes");
            preparation = postcard::from_bytes(&bytes).expect("the same");
        }
        Some(preparation.particles(&plan, streams).expect("particles"))
    } else if plan.lengths[0] > 0.0 {
        Some(placed(&plan, 0, streams).expect("a start").0)
    } else {
        None
    };
    for engine in &plan.engines {
        let part = Part {
            plan: &plan,
            engine,
            measures: &[&Everything],
            replica: 0,
            start: start.as_ref(),
        };
        let (never, at_once) = (AtomicBool::new(false), AtomicBool::new(true));
        let tell = |_: f64, _: u64| {};
        let whole = part
            .run(&Control::new(None, [0; 32], 1e9, &never, &tell))
            .expect("a run");
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("part.snapshot");
        let mut stops = 0;
        let stopped = loop {
            let control = Control::new(Some(path.clone()), [1; 32], 1e9, &at_once, &tell);
            match part.run(&control) {
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
         [drive]\nheating = 2\ninterval = 0.05\n[run]\nuntil = 1\n[engine.ed]\n[engine.dsmc-boltzmann]\n\
         [engine.dsmc-contact-point]\nsimulators_per_particle = 4\n",
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
    assert_resumes(
        "[gas]\nnumber = 60\nrestitution = 0.9\n[box]\nsize = [20.0, 20.0]\n[walls]\nbottom = \"specular\"\ntop = \"specular\"\n\
         [[obstacle]]\ndisc = {centre = [10.0, 10.0], radius = 3.0}\n[run]\nuntil = 10\nsamples = 20\n\
         [engine.dsmc-enskog]\ndisplacement = false\n",
    );
}

#[test]
fn gases_without_positions_resume_to_the_same_bytes() {
    assert_resumes(
        "[gas]\ndimension = 3\nnumber = 200\nrestitution = 0.8\nvolume = 1000.0\n[run]\nuntil = 20\n\
         [engine.dsmc-homogeneous]\n",
    );
}

/// `t_0 = sqrt(pi)/(2 (1 - r^2) phi chi) d sqrt(m/T)`, with the speed of the paper, `<v^2> = (0.2047 m/s)^2` and so
/// `T/m = 0.2047^2/2`. Bound: a few roundings.
#[test]
fn luding_1998_has_the_published_time() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../cases/luding-1998.toml");
    let file = CaseFile::read(&path, &[]).expect("a case");
    let plan = Plan::new(&file.points[0].case, Path::new("")).expect("a plan");
    let chi = stosszahl_model::kinetic::contact_value(0.25);
    let reduced = std::f64::consts::PI.sqrt() / (2.0 * 0.36 * 0.25 * chi);
    let wanted = reduced * 0.001 / (0.2047 * 0.5_f64.sqrt());
    assert!((plan.time_in_case() / wanted - 1.0).abs() < 1e-14);
    assert_eq!(plan.count(), 99856);
    let names: Vec<&str> = plan.engines.iter().map(|engine| engine.name).collect();
    assert_eq!(names, ["ed", "dsmc-free-volume", "dsmc-enskog"]);
}

#[test]
fn bundled_cases_have_plans() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../cases");
    let entries = std::fs::read_dir(&folder).expect("the bundled cases");
    for path in entries.flatten().map(|entry| entry.path()) {
        if path.extension().is_some_and(|ending| ending == "toml") {
            let file = CaseFile::read(&path, &[]).expect("a case");
            for point in &file.points {
                let plan = Plan::new(&point.case, &folder);
                let plan = plan
                    .unwrap_or_else(|error| panic!("{} {}: {error}", path.display(), point.name));
                assert!(
                    plan.share(plan.case.run.until) > 0.999,
                    "{}",
                    path.display()
                );
                assert!(plan.cost(2).bytes > 0.0 && plan.cost(2).core_seconds > 0.0);
            }
        }
    }
}
