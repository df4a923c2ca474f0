//! Starts lie between collisions, and have the requested velocities.

use std::fmt::Write as _;
use std::path::Path;

use nalgebra::Vector3;
use stosszahl_case::CaseFile;
use stosszahl_dsmc::StartStream as _;
use stosszahl_ed::DissipationRule;
use stosszahl_model::random::Streams;
use stosszahl_model::{Budget, Interrupt, Particles};

use super::stream::IndependentStart;
use super::{Preparation, is_prepared, placed};
use crate::engines::{self, From};
use crate::measure::Needs;
use crate::plan::CasePlan;

fn plan_in(folder: &Path, text: &str) -> CasePlan {
    let text = format!("format = 2\ntitle = \"a start\"\n{text}");
    let file = CaseFile::from_text(&folder.join("test.toml"), &text, &[]).expect("a case");
    CasePlan::new(&file.points[0].case, folder).expect("a plan")
}

fn plan(text: &str) -> CasePlan {
    plan_in(Path::new(""), text)
}

/// Start of a replica.
fn start(plan: &CasePlan, replica: u64) -> Particles {
    let (streams, never) = (Streams::new(plan.case.seed, replica), Interrupt::default());
    if !is_prepared(plan) {
        return placed(plan, 0, streams, &never).expect("a start").0;
    }
    let mut preparation = Preparation::new(plan, streams, &never).expect("a start");
    while !preparation.leg(plan, streams, &never).expect("a leg") {}
    preparation.particles(plan, streams).expect("particles")
}

/// Mean of independent numbers, and its standard error.
fn mean(numbers: &[f64]) -> [f64; 2] {
    let count = numbers.len() as f64;
    let mean = numbers.iter().sum::<f64>() / count;
    let square: f64 = numbers.iter().map(|one| (one - mean).powi(2)).sum();
    [mean, (square / (count - 1.0) / count).sqrt()]
}

/// Distances of pairs closer than 1.05 diameters in a periodic box.
fn close(particles: &Particles) -> Vec<f64> {
    let side = Vector3::from(particles.lengths);
    let mut found = Vec::new();
    for (index, one) in particles.all.iter().enumerate() {
        for other in &particles.all[..index] {
            let mut apart = one.position - other.position;
            for axis in 0..2 {
                apart[axis] -= side[axis] * (apart[axis] / side[axis]).round();
            }
            found.extend(Some(apart.norm()).filter(|&distance| distance < 1.05));
        }
    }
    found
}

/// Starts of 48 disks have as many pairs within 0.05 d of contact as samples of a long elastic run,
/// and none at contact.
///
/// The two agree within 4.4 measured standard errors (a false alarm in 10^5 runs), and the error is
/// at most a sixth of the one extra pair of a start at a collision. A pair within 1e-9 of contact
/// occurs by chance in 3 of 10^5 runs.
#[test]
fn starts_lie_between_collisions() {
    let plan = plan(
        "[gas]\nnumber = 48\nrestitution = 1\n[box]\npacking_fraction = 0.25\n\
         [start]\nequilibration = 10\nlongest_equilibration = 10\n[run]\nuntil = 1\n[engine.ed]\n",
    );
    let starts: Vec<Vec<f64>> = (0..400)
        .map(|replica| close(&start(&plan, replica)))
        .collect();
    assert!(
        starts
            .iter()
            .flatten()
            .all(|&distance| distance > 1.0 + 1e-9)
    );
    let streams = Streams::new(plan.case.seed, 1000);
    let boundaries = plan.exact_boundaries(streams).expect("none");
    let first = start(&plan, 1000);
    let mut gas = stosszahl_ed::simulate(
        &plan.gas.particles,
        DissipationRule::Elastic,
        &boundaries,
        &first,
    )
    .expect("a gas");
    // Five mean free times later, other pairs are near contact.
    let later = (1..=400).map(|step| {
        let time = 5.0 * f64::from(step) / plan.collision_rate();
        gas.advance(time, Budget::Unlimited, &mut ())
            .expect("on it goes");
        close(&gas.particles()).len() as f64
    });
    let later: Vec<f64> = later.collect();
    let starts: Vec<f64> = starts.iter().map(|one| one.len() as f64).collect();
    let ([found, error], [wanted, other]) = (mean(&starts), mean(&later));
    let error = error.hypot(other);
    assert!(
        (found - wanted).abs() < 4.4 * error,
        "{found} {wanted} ({error})"
    );
    assert!(error < 1.0 / 6.0, "{error}");
}

/// Fourth cumulant of velocities in units of their own mean square.
fn cumulant(particles: &[Vector3<f64>], dimension: f64) -> f64 {
    let squares = particles.iter().map(Vector3::norm_squared);
    let (second, fourth) = squares.fold((0.0, 0.0), |(a, b), x| (a + x, b + x * x));
    let count = particles.len() as f64;
    dimension / (dimension + 2.0) * count * fourth / (second * second) - 1.0
}

/// Fourth cumulants of 60 starts of 400 particles are the requested ones, for all engines and after
/// equilibration. Tolerance: 4.4 measured standard errors and the bias of a ratio, some 4/400; the
/// error is small enough to detect a Maxwellian. Temperature and momentum are exact to rounding.
#[test]
fn starts_have_the_fourth_cumulant_asked_for() {
    for (text, a2) in [
        ("[box]\npacking_fraction = 0.2\n[engine.ed]\n", -0.3),
        (
            "[box]\npacking_fraction = 0.2\n[engine.ed]\n[gas]\nnumber = 400\ntangential_restitution = 0\n",
            0.4,
        ),
        ("volume = 2000\n", -0.3),
    ] {
        let gas = if text.contains("[gas]") {
            ""
        } else {
            "[gas]\nnumber = 400\n"
        };
        let plan = plan(&format!(
            "{gas}{text}[start.velocities]\na2 = {a2}\n[run]\nuntil = 1\n"
        ));
        let sample = |replica: u64| {
            if plan.gas.lengths[0] > 0.0 {
                let start = start(&plan, replica);
                let momentum: Vector3<f64> =
                    start.all.iter().map(|one| one.mass * one.velocity).sum();
                assert!(momentum.norm() < 1e-11 && (start.temperature() - 1.0).abs() < 1e-13);
                return cumulant(
                    &start.all.iter().map(|one| one.velocity).collect::<Vec<_>>(),
                    2.0,
                );
            }
            let (streams, never) = (Streams::new(1, replica), Interrupt::default());
            let engine = &plan.engines[0];
            let gas = engines::begin(
                &plan,
                engine,
                streams,
                Needs::default(),
                From::Start(None),
                &never,
                None,
            );
            let mut velocities = Vec::new();
            gas.expect("a gas")
                .visit_particles(&mut |one| velocities.push(one.velocity));
            cumulant(&velocities, 2.0)
        };
        let [found, error] = mean(&(0..60).map(sample).collect::<Vec<_>>());
        assert!(
            (found - a2).abs() < 4.4 * error + 0.01,
            "{a2}: {found}({error})"
        );
        assert!(error < 0.02, "{a2}: {error}");
    }
}

/// Velocities of a file are dealt anew in each replica, within each species, to other positions.
#[test]
fn velocities_of_a_file_are_dealt_within_species() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut text = String::from("vx,vy,mass,type\n");
    for index in 0..40_i32 {
        let heavy = index % 4 == 1;
        // No sum of these is zero, and no two are equal.
        let (vx, vy) = (index * index, 3 * index - 7);
        let (mass, name) = if heavy { (3, "b") } else { (1, "a") };
        writeln!(text, "{vx},{vy},{mass},{name}").expect("a string");
    }
    std::fs::write(folder.path().join("v.csv"), text).expect("a file");
    for more in [
        "[engine.ed]\n",
        "[engine.ed]\n[walls]\nleft = \"specular\"\nright = \"specular\"\n",
    ] {
        let plan = plan_in(
            folder.path(),
            &format!(
                "[gas]\nrestitution = 0.9\n[box]\npacking_fraction = 0.1\n[start]\nfile = \"v.csv\"\nvelocities = \"file\"\n\
                 [run]\nuntil = 1\n{more}"
            ),
        );
        assert_eq!(plan.case.replicas, 4);
        assert_eq!([0, 1].map(|k| plan.gas.species[k].count), [30, 10]);
        let starts: Vec<Particles> = (0..2).map(|replica| start(&plan, replica)).collect();
        let speeds = |start: &Particles, species: u32| {
            let own = start.all.iter().filter(|one| one.species == species);
            let mut own: Vec<f64> = own.map(|one| one.velocity.norm()).collect();
            own.sort_by(f64::total_cmp);
            own
        };
        let file = plan
            .gas
            .file
            .as_ref()
            .and_then(|file| file.velocities.as_ref())
            .expect("velocities");
        for (species, wanted) in [(0, &file[..30]), (1, &file[30..])] {
            let mut wanted: Vec<f64> = wanted.iter().map(Vector3::norm).collect();
            wanted.sort_by(f64::total_cmp);
            assert!(starts.iter().all(|start| speeds(start, species) == wanted));
        }
        let first = |start: &Particles| (start.all[0].position, start.all[0].velocity);
        let [a, b] = [0, 1].map(|replica| first(&starts[replica]));
        assert!(a.0 != b.0 && a.1 != b.1);
    }
}

/// Default equilibration grows with packing; starts from a file or in a region have none.
#[test]
fn default_equilibration_depends_on_packing() {
    let asked = |packing: f64, start: &str| {
        let text = format!(
            "[gas]\nnumber = 100\nrestitution = 1\n[box]\npacking_fraction = {packing}\n[start]\n{start}[run]\nuntil = 1\n[engine.ed]\n"
        );
        plan(&text).equilibration()
    };
    // Expected: 10 sqrt(phi) chi with Henderson's chi minus a hundredth, 9.7, 14.5, 22.0 and 35.2,
    // rounded up.
    for (packing, wanted) in [
        (0.05, 10.0),
        (0.3, 10.0),
        (0.4, 15.0),
        (0.5, 22.0),
        (0.6, 36.0),
    ] {
        assert_eq!(asked(packing, ""), wanted, "{packing}");
    }
    assert_eq!(asked(0.4, "equilibration = 3\n"), 3.0);
    assert_eq!(asked(0.02, "region = [[0, 0], [40, 40]]\n"), 0.0);
}

/// The flight after the count also ends where hardly anything collides, and at the longest
/// equilibration.
#[test]
fn few_disks_end_their_equilibration() {
    let plan = plan(
        "[gas]\nnumber = 2\nrestitution = 1\n[box]\npacking_fraction = 1e-4\n[start]\nequilibration = 1\n[run]\nuntil = 1\n[engine.ed]\n",
    );
    let start = start(&plan, 0);
    assert_eq!((start.all.len(), start.time), (2, 0.0));
}

/// Cases whose particles are independent of each other: sizes, walls and bodies, regions, drift,
/// spins, and several simulators for each particle.
const INDEPENDENT: [&str; 6] = [
    "[gas]\nnumber = 400\nrestitution = 0.9\n[box]\nsize = [40, 30]\n[walls]\nbottom = \"specular\"\ntop = { temperature = 1 }\n\
     [run]\nuntil = 1\n[engine.dsmc-boltzmann]\nsimulators_per_particle = 3\n",
    "[gas]\nrestitution = 0.9\n[box]\nsize = [60, 60]\n[walls]\nbottom = \"specular\"\ntop = \"specular\"\n\
     [[species]]\nnumber = 100\ndiameter = 1\n[[species]]\nnumber = 50\ndiameter = 3\nmass = 4\n[[species]]\nnumber = 70\ndiameter = 2\n\
     [run]\nuntil = 1\n[engine.dsmc-boltzmann]\n",
    "[gas]\nnumber = 300\nrestitution = 0.9\n[box]\nsize = [60, 60]\n[walls]\nbottom = \"specular\"\ntop = \"specular\"\n\
     [start]\nregion = [[10, 10], [30, 40]]\nvelocity = [0.5, -0.25]\n[run]\nuntil = 1\n[engine.dsmc-boltzmann]\n",
    "[gas]\nnumber = 300\nrestitution = 0.9\n[box]\nsize = [60, 60]\n[walls]\nleft = \"specular\"\nright = \"specular\"\n\
     [[obstacle]]\ncircle = { centre = [30, 30], radius = 8 }\n[run]\nuntil = 1\n[engine.dsmc-boltzmann]\n",
    "[gas]\ndimension = 3\nnumber = 500\nrestitution = 0.9\ntangential_restitution = 0.3\n[box]\nsize = [20, 20, 20]\n\
     [start]\nspin_temperature = 0.5\n[run]\nuntil = 1\n[engine.dsmc-boltzmann]\n",
    "[gas]\ndimension = 3\nnumber = 500\nrestitution = 0.9\n[box]\nsize = [20, 20, 20]\n[run]\nuntil = 1\n[engine.dsmc-boltzmann]\n\
     simulators_per_particle = 1\n",
];

/// Particles made one after the other are those of a start that is made whole, and so are engines
/// that begin with them.
#[test]
fn streams_of_particles_are_whole_starts() {
    for text in INDEPENDENT {
        let plan = plan(text);
        let (streams, never) = (Streams::new(plan.case.seed, 1), Interrupt::default());
        let engine = &plan.engines[0];
        let stream = IndependentStart::new(&plan, engine, streams, &never).expect("a stream");
        let mut found = vec![[Vector3::zeros(); 3]; stream.particles() * stream.sets()];
        let positions = stream.visit_positions(&mut |index, at| found[index][0] = at);
        let velocities = stream.visit_velocities(&mut |index, velocity| found[index][1] = velocity);
        let spins = stream.visit_spins(&mut |index, spin| found[index][2] = spin);
        positions.and(velocities).and(spins).expect("particles");
        let sets = (0..stream.sets()).map(|set| placed(&plan, set as u64, streams, &never));
        let sets: Vec<Particles> = sets.map(|set| set.expect("a start").0).collect();
        let wanted = sets.iter().flat_map(|set| &set.all);
        let wanted: Vec<_> = wanted
            .map(|one| [one.position, one.velocity, one.spin])
            .collect();
        assert!(found == wanted, "{text}");
        let begin = |from| {
            let needs = Needs::default();
            let gas = engines::begin(&plan, engine, streams, needs, from, &never, None);
            gas.expect("an engine").save_checkpoint().expect("bytes")
        };
        let whole = begin(From::Start(Some(&sets[0])));
        assert!(begin(From::Start(None)) == whole, "{text}");
    }
}

/// Particles that exclude each other are not made one after the other; nor are several simulators of
/// one state.
#[test]
fn dense_starts_are_made_whole() {
    let exclusive = "[gas]\nnumber = 20\nrestitution = 0.9\n[box]\nsize = [20, 20]\n[walls]\nbottom = \"specular\"\ntop = \"specular\"\n\
                     [run]\nuntil = 1\n[engine.ed]\n[engine.dsmc-boltzmann]\n";
    let shared = "[gas]\ndimension = 3\nnumber = 50\nrestitution = 0.9\n[box]\nsize = [20, 20, 20]\n\
                  [run]\nuntil = 1\n[engine.dsmc-boltzmann]\nsimulators_per_particle = 2\n";
    for text in [exclusive, shared] {
        let plan = plan(text);
        let (streams, never) = (Streams::new(plan.case.seed, 0), Interrupt::default());
        let (_, engine) = plan.engine("dsmc-boltzmann").expect("an engine");
        assert!(IndependentStart::new(&plan, engine, streams, &never).is_none());
    }
}
