//! Uniform shear flow: against all pairs, and what is conserved.

use nalgebra::{Vector2, vector};
use rand::RngExt;
use stosszahl_ed::{
    DiskBoundaries, DissipationRule, EventDrivenEngine, EventDrivenError, plain, resume, simulate,
};
use stosszahl_model::random::{Purpose, Streams};
use stosszahl_model::samples::{UNIT, law, particles_of, species};
use stosszahl_model::{
    Budget, Domain, Interrupt, Law, Monodisperse, ParticleModel, ParticleSpec, Particles, PerPair,
    Plane, Rough, Scene, Shear, Sheared, SizeDistribution, Smooth, Species, State, Surface,
    Viscoelastic,
};

use crate::support::{Journal, gas_in};

type ShearedScene<C, Z> = Scene<Plane, C, Law, Z, Sheared>;

fn flow(rate: f64) -> Sheared {
    Sheared::new(rate).expect("a rate")
}

/// Equal smooth disks of diameter and mass one.
fn equal(restitution: Law, rate: f64) -> ShearedScene<Smooth, Monodisperse> {
    Scene::new(Smooth, restitution, UNIT, flow(rate))
}

/// Creates a sheared scene of two species with the given surface.
fn mixture<C: Surface<Plane>>(
    surface: C,
    restitution: Law,
    rate: f64,
    counts: [usize; 2],
) -> ShearedScene<C, Species> {
    let sizes = species([(0.5, 1.0, counts[0]), (0.3, 0.5, counts[1])]);
    Scene::new(surface, restitution, sizes, flow(rate))
}

/// Disks at random places of a box whose images are displaced, without total momentum.
fn gas<P: ParticleModel<Space = Plane>>(
    scene: &P,
    rate: f64,
    lengths: Vector2<f64>,
    count: usize,
    seed: u64,
) -> State<P> {
    let mut shear = Shear::new(rate).expect("a rate");
    let mut stream = Streams::new(seed, 0).stream_at(Purpose::Placement, [1, 0]);
    // The first seed is for a start with boxes above each other.
    shear.offset = if seed == 0 {
        0.0
    } else {
        stream.random::<f64>() * lengths[0]
    };
    let domain = Domain::<Plane>::periodic(lengths)
        .expect("a box")
        .sheared(Some(shear))
        .expect("a flow");
    gas_in(scene, domain, count, seed, |_, _| true)
}

/// Compares the engine with all pairs: the collisions must be the same at the same times, and so
/// must the gas after them. Rounding differs, and each collision of a disk multiplies differences,
/// by twice its free path over its diameter: some five for each leave 1e-8, fewer in a dilute gas.
/// Images slide farther than the box, so that rows of cells step and disks cross its edges.
fn follow_plain<P: ParticleModel<Space = Plane>>(
    name: &str,
    scene: &P,
    start: &State<P>,
    collisions: usize,
) {
    let mut slow = start.clone();
    let events = plain::run_collisions(scene, &mut slow, collisions);
    assert_eq!(events.len(), collisions, "{name}");
    let engine = EventDrivenEngine::<P>::new(scene.clone(), DissipationRule::Scene, start.clone());
    let mut engine = engine.expect("an engine");
    let mut journal = Journal::default();
    let there = engine.advance(slow.time, u64::MAX, &mut journal);
    assert!(there.expect("time"));
    for (number, (time, event)) in journal.0.iter().zip(&events).enumerate() {
        assert!(
            (time - event.time).abs() < 1e-8,
            "{name}, {number}: {time} {event:?}"
        );
    }
    // Rounding may delay the last collision beyond the end.
    assert!(
        journal.0.len() + 1 >= collisions,
        "{name}: {} of {collisions}",
        journal.0.len()
    );
    let state = engine.state();
    let last = events[collisions - 1].pair;
    for (disk, (one, other)) in state.bodies.iter().zip(&slow.bodies).enumerate() {
        let apart = state.domain.distance(one.position, other.position);
        assert!(apart < 1e-7, "{name}, disk {disk}: {apart:e} apart");
        let change = (one.velocity - other.velocity).norm();
        assert!(
            change < 1e-7 || last.contains(&disk),
            "{name}, disk {disk}: {change:e}"
        );
    }
    let images = [&state, &slow].map(|gas| gas.domain.images().shear().expect("a flow").offset);
    let length = state.domain.lengths()[0];
    let apart = (images[0] - images[1]).abs();
    assert!(
        apart.min(length - apart) < 1e-9,
        "{name}: images {images:?}"
    );
}

/// Twenty gases: in wide, high and narrow boxes, with the flow to either side, slow and fast,
/// dilute and dense; smooth and rough, of one and of two species, with three laws.
#[test]
fn all_pairs_have_the_same_collisions() {
    let laws = || {
        let viscoelastic = Law::from(Viscoelastic::new(0.3).expect("a law"));
        let pairs = vec![law(0.9), law(0.6), law(0.6), law(0.75)];
        let pairs = Law::from(PerPair::new(2, pairs).expect("laws"));
        [law(1.0), law(0.8), viscoelastic, pairs]
    };
    let boxes = [
        (vector![12.0, 9.0], 40, 120),
        (vector![7.0, 16.0], 40, 120),
        (vector![5.3, 5.1], 14, 42),
        (vector![30.0, 20.0], 40, 50),
        (vector![2.6, 40.0], 30, 75),
    ];
    let rates = [0.5, -0.7, 2.0, -0.1];
    for (number, (lengths, count, collisions)) in boxes.into_iter().enumerate() {
        for (which, law) in laws().into_iter().enumerate() {
            let (rate, seed) = (rates[(number + which) % 4], (4 * number + which + 1) as u64);
            let name = format!("{lengths:?}, rate {rate}, law {law:?}");
            match which {
                0 | 2 => {
                    let scene = equal(law, rate);
                    let start = gas(&scene, rate, lengths, count, seed);
                    follow_plain(&name, &scene, &start, collisions);
                }
                1 => {
                    let rough = Rough::new(0.3, 0.5).expect("a surface");
                    let scene = mixture(rough, law, rate, [count / 2, count - count / 2]);
                    let start = gas(&scene, rate, lengths, count, seed);
                    follow_plain(&name, &scene, &start, collisions);
                }
                _ => {
                    let scene = mixture(Smooth, law, rate, [count / 2, count - count / 2]);
                    let start = gas(&scene, rate, lengths, count, seed);
                    follow_plain(&name, &scene, &start, collisions);
                }
            }
        }
    }
}

/// The energy is that of the start, plus the work of the stress, less the dissipation, and the
/// momentum stays zero, over restarts too. Each of some 10^6 terms is rounded to 1e-16 of itself,
/// with random signs: 1e-13 of the sum; the bound is 1e-10.
#[test]
fn the_energy_balance_closes() {
    for (rate, restitution) in [(0.4, 0.8), (-1.0, 0.9)] {
        let rough = Rough::new(0.2, 0.5).expect("a surface");
        let scene = mixture(rough, law(restitution), rate, [300, 300]);
        let start = gas(&scene, rate, vector![45.0, 30.0], 600, 3);
        let engine = EventDrivenEngine::<_>::new(scene.clone(), DissipationRule::Scene, start);
        let mut engine = engine.expect("an engine");
        assert!(
            !engine
                .advance(f64::INFINITY, 150_000, &mut ())
                .expect("time")
        );
        let work = engine.shear_work().expect("a flow");
        let state = engine.state();
        let energy = state.kinetic_energy(&scene) + state.spin_energy(&scene);
        let imbalance = work.imbalance(energy);
        assert!(imbalance.abs() < 1e-10, "{imbalance:e}: {work:?}");
        // Most of what the flow does is dissipated, and collisions carry much of the stress.
        assert!(work.dissipated > 10.0 * energy, "{work:?}");
        assert!(
            work.kinetic > 0.0 && work.collisional > 0.1 * work.kinetic,
            "{work:?}"
        );
        let drift = state.momentum(&scene).norm() / (energy * 600.0).sqrt();
        assert!(drift < 1e-11, "{drift:e}");
        assert!(engine.worst_overlap() < 1e-9);
    }
}

fn particles(count: usize) -> Particles {
    let scene = equal(law(1.0), 1.0);
    let state = gas(&scene, 1.0, vector![40.0, 30.0], count, 0);
    particles_of(&UNIT, &state)
}

fn grains(rate: f64) -> ParticleSpec {
    ParticleSpec {
        shear_rate: Some(rate),
        ..ParticleSpec::equal(0.5, 1.0, law(0.8))
    }
}

/// A run that is killed at a checkpoint and resumed has the bytes of one that is not, and those of
/// several threads are those of one.
#[test]
fn resumed_runs_have_the_same_bytes() {
    let (boundaries, grains) = (DiskBoundaries::periodic(), grains(0.5));
    let start = particles(300);
    let mut gas =
        simulate(&grains, DissipationRule::Scene, &boundaries, &start).expect("an engine");
    let mut again =
        simulate(&grains, DissipationRule::Scene, &boundaries, &start).expect("an engine");
    again.use_threads(4);
    for step in 1..=8 {
        let until = 1.5 * f64::from(step);
        while !gas.advance(until, Budget::Leg, &mut ()).expect("time") {}
        while !again.advance(until, Budget::Leg, &mut ()).expect("time") {}
        let kept = again.save_checkpoint().expect("bytes");
        again = resume(
            &grains,
            300,
            DissipationRule::Scene,
            &boundaries,
            &kept,
            &Interrupt::default(),
        )
        .expect("an engine");
    }
    assert!(
        gas.work_counters().collisions > 1000,
        "{}",
        gas.work_counters().collisions
    );
    assert!(gas.work_counters().numbers["shear_energy_imbalance"].abs() < 1e-10);
    assert!(gas.save_checkpoint().expect("bytes") == again.save_checkpoint().expect("bytes"));
    assert!(
        !gas.track_displacements(),
        "displacements are not told from the flow"
    );
}

/// The energy balance holds in a driven gas too.
#[test]
fn the_balance_knows_what_drives_supply() {
    let mut gas = simulate(
        &grains(0.5),
        DissipationRule::Scene,
        &DiskBoundaries::periodic(),
        &particles(200),
    )
    .expect("an engine");
    for step in 1..=3 {
        while !gas
            .advance(f64::from(step), Budget::Leg, &mut ())
            .expect("time")
        {}
        gas.scale_velocities(1.1).expect("a factor");
    }
    assert!(gas.work_counters().numbers["shear_energy_imbalance"].abs() < 1e-10);
}

#[test]
fn flows_that_cannot_be_are_refused() {
    let start = particles(20);
    let run = |grains: &ParticleSpec| {
        simulate(
            grains,
            DissipationRule::Scene,
            &DiskBoundaries::periodic(),
            &start,
        )
        .map(|_| ())
    };
    for rate in [0.0, f64::NAN, f64::INFINITY] {
        let error = run(&grains(rate)).expect_err("no rate");
        assert!(error.to_string().contains("shear rate"), "{error}");
    }
    let mut falls = grains(1.0);
    falls.gravity = Some(vector![0.0, -1.0, 0.0]);
    assert!(
        run(&falls)
            .expect_err("gravity")
            .to_string()
            .contains("gravity")
    );
    let mut each = grains(1.0);
    each.sizes = SizeDistribution::Equal(UNIT);
    run(&each).expect("a gas");
    // The box of a flow with another shear rate.
    let scene = equal(law(1.0), 1.0);
    let state = gas(&scene, 2.0, vector![9.0, 9.0], 5, 1);
    let error = EventDrivenEngine::<_>::new(scene, DissipationRule::Scene, state).err();
    assert!(
        matches!(error, Some(EventDrivenError::UnlikeFlow { .. })),
        "{error:?}"
    );
}
