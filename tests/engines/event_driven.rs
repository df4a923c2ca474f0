//! The event-driven engine, against its oracles and the conservation laws.

use nalgebra::{Vector2, Vector3};
use stosszahl_ed::{
    Buckets, Calendar, DissipationRule, EventDrivenCheckpoint, EventDrivenEngine, Sorted,
    crossings_per_collision, plain,
};
use stosszahl_model::initial::{Arrangement, place_unequal};
use stosszahl_model::random::Streams;
use stosszahl_model::samples::{EqualDisks, disks, maxwellian, mixture};
use stosszahl_model::snapshot;
use stosszahl_model::{Collision, Domain, Interrupt, Observer, State, ThresholdModel};

use crate::support::gas;

/// Observer that keeps the times and lines of all collisions.
#[derive(Default)]
struct Journal(Vec<(f64, Vector3<f64>, Vector3<f64>)>);

impl Observer for Journal {
    fn on_collisions(&mut self, batch: &[Collision]) {
        for collision in batch {
            self.0
                .push((collision.time, collision.line, collision.relative_velocity));
        }
    }
}

fn run<Q: Calendar>(
    scene: &EqualDisks,
    state: State<EqualDisks>,
    collisions: u64,
) -> (Journal, State<EqualDisks>) {
    let mut engine = EventDrivenEngine::<_, Q>::new(scene.clone(), DissipationRule::Scene, state)
        .expect("an engine");
    let mut journal = Journal::default();
    engine
        .advance(f64::INFINITY, collisions, &mut journal)
        .expect("collisions");
    (journal, engine.state())
}

/// The bucket calendar gives bitwise the same collisions in the same order as the sorted queue.
#[test]
fn bucket_calendar_gives_the_bits_of_the_sorted_queue() {
    for (packing, restitution) in [(0.02, 1.0), (0.25, 0.8), (0.5, 0.6), (0.68, 1.0)] {
        let start = gas(Arrangement::Disordered, 400, packing, 11);
        let scene = disks(restitution);
        let (fast, fast_state) = run::<Buckets>(&scene, start.clone(), 20_000);
        let (plain, plain_state) = run::<Sorted>(&scene, start, 20_000);
        assert_eq!(fast.0.len(), 20_000);
        assert!(fast.0 == plain.0);
        assert_eq!(fast_state.bodies, plain_state.bodies);
    }
}

/// Cells, local clocks and calendar find the collisions of all pairs with all disks moved at every
/// event. The two round differently, and each collision of a disk multiplies differences by about
/// twice its free path over the diameter plus one: by e^2 in dense gases, by 60 at packing 0.01.
/// Five collisions a disk (one where it is dilute) leave 1e-13 times e^10 or 60^3, so 1e-8 on times
/// of order ten.
#[test]
fn engine_finds_the_collisions_of_all_pairs() {
    for (count, packing, restitution, each) in [
        (60, 0.01, 1.0, 1),
        (60, 0.25, 0.8, 5),
        (60, 0.5, 0.3, 5),
        (64, 0.68, 1.0, 5),
        (12, 0.6, 1.0, 5),
        (2, 0.1, 1.0, 3),
        (3, 0.3, 0.9, 5),
    ] {
        let scene = disks(restitution);
        let start = gas(Arrangement::Disordered, count, packing, 5);
        let collisions = each * count / 2;
        let mut slow_state = start.clone();
        let slow = plain::run_collisions(&scene, &mut slow_state, collisions);
        let (fast, fast_state) = run::<Buckets>(&scene, start, collisions as u64);
        assert_eq!(fast.0.len(), slow.len());
        for (number, (ours, theirs)) in fast.0.iter().zip(&slow).enumerate() {
            let scale = theirs.time.max(1.0);
            assert!(
                (ours.0 - theirs.time).abs() < 1e-8 * scale,
                "{count} {packing} event {number}: {ours:?} {theirs:?}"
            );
        }
        for (ours, theirs) in fast_state.bodies.iter().zip(&slow_state.bodies) {
            let apart = start_distance(&fast_state, ours.position, theirs.position);
            assert!(
                apart < 1e-7,
                "{count} disks at packing {packing}: {apart:e} apart"
            );
        }
    }
}

fn start_distance(state: &State<EqualDisks>, a: Vector2<f64>, b: Vector2<f64>) -> f64 {
    state.domain.distance(a, b)
}

/// Contacts that are elastic below a threshold g* of the approach speed lose the share
/// `(1 + x) exp(-x)`, `x = m g*^2/(4 T)`, of the energy that contacts at all speeds would, in a gas
/// near equilibrium. The share is a quotient of sums over collisions; its standard error is that of
/// their residuals, and 4.5 of them are a false alarm in 150 000 runs.
#[test]
fn elastic_contacts_below_a_threshold_keep_their_share_of_energy() {
    let (coefficient, threshold) = (0.999, 2.0);
    let law = ThresholdModel::new(coefficient, threshold).expect("a law");
    let scene = EqualDisks {
        restitution: law.into(),
        ..disks(1.0)
    };
    let start = gas(Arrangement::Disordered, 2000, 0.02, 31);
    let before = start.kinetic_energy(&scene);
    let (journal, end) = run::<Buckets>(&scene, start, 20_000);
    let after = end.kinetic_energy(&scene);
    let squares = (journal.0.iter()).map(|(_, line, velocity)| velocity.dot(line).powi(2));
    let squares: Vec<f64> = squares.collect();
    let all: f64 = squares.iter().sum();
    let share = (before - after) / (0.25 * (1.0 - coefficient * coefficient) * all);
    let temperature = 0.5 * (before + after) / 2000.0;
    let x = threshold * threshold / (4.0 * temperature);
    let theory = (1.0 + x) * (-x).exp();
    let residual = |square: f64| {
        let lost = if square < threshold * threshold {
            0.0
        } else {
            square
        };
        (lost - share * square).powi(2)
    };
    let error = squares
        .iter()
        .map(|&square| residual(square))
        .sum::<f64>()
        .sqrt()
        / all;
    assert!(error < 0.01, "{error}");
    assert!(
        (share - theory).abs() < 4.5 * error,
        "{share} {theory} {error}"
    );
}

/// Elastic: energy, momentum and exclusion to rounding after half a million collisions.
#[test]
fn elastic_gas_conserves_energy_momentum_and_distance() {
    for packing in [0.1, 0.5, 0.69] {
        let scene = disks(1.0);
        let state = gas(Arrangement::Disordered, 1000, packing, 2);
        let energy = state.kinetic_energy(&scene);
        let mut engine = EventDrivenEngine::<_>::new(scene.clone(), DissipationRule::Scene, state)
            .expect("an engine");
        engine
            .advance(f64::INFINITY, 500_000, &mut ())
            .expect("collisions");
        // A random walk of 5e5 roundings of 1e-16 each on 1e3 disks: below 1e-13.
        let drift = engine.state().kinetic_energy(&scene) / energy - 1.0;
        assert!(drift.abs() < 1e-12, "energy drift {drift:e}");
        assert!(engine.state().momentum(&scene).norm() < 1e-10);
        assert!(
            engine.worst_overlap() < 1e-12,
            "overlap {:e}",
            engine.worst_overlap()
        );
        let fresh =
            EventDrivenEngine::<_>::new(scene.clone(), DissipationRule::Scene, engine.state())
                .expect("an engine");
        assert!(fresh.worst_overlap() < 1e-12);
    }
}

/// A checkpoint that went through a file continues to the bits of one that did not.
#[test]
fn legs_are_functions_of_their_checkpoint() {
    let scene = disks(0.9);
    let folder = tempfile::tempdir().expect("a folder");
    for dissipation in [DissipationRule::Scene, DissipationRule::ContactTime(1e-3)] {
        let start = gas(Arrangement::Disordered, 300, 0.4, 3);
        let mut first =
            EventDrivenEngine::<_>::new(scene.clone(), dissipation, start).expect("an engine");
        first
            .advance(f64::INFINITY, 3000, &mut ())
            .expect("collisions");
        let checkpoint = first.checkpoint();
        let path = folder.path().join("checkpoint");
        snapshot::write_snapshot(&path, &[1; 32], &checkpoint).expect("written");
        let read: EventDrivenCheckpoint<EqualDisks> =
            snapshot::read_snapshot(&path, &[1; 32]).expect("read");
        let finish = |checkpoint| {
            let mut engine = EventDrivenEngine::<_>::new(scene.clone(), dissipation, checkpoint)
                .expect("an engine");
            engine
                .advance(f64::INFINITY, 3000, &mut ())
                .expect("collisions");
            (engine.state().bodies, engine.tally(), engine.time())
        };
        assert_eq!(finish(checkpoint), finish(read));
    }
}

/// Restitution 0: after a contact the normal part of the relative velocity is rounding, which must
/// not make contacts of its own. Two disks at a time, from random sides; each collides once in the
/// time between two crossings of the box.
#[test]
fn contacts_without_rebound_happen_once() {
    let mut central = 0;
    for seed in 0..2000 {
        let mut start = gas(Arrangement::Disordered, 2, 0.05, seed);
        let scene = disks(0.0);
        let apart = start
            .domain
            .displacement(start.bodies[1].position, start.bodies[0].position);
        // Aim at the other disk, a little off its centre.
        let aim = apart.normalize() + Vector2::new(0.1, -0.1) * (seed as f64 / 2000.0 - 0.5);
        start.bodies[0].velocity = aim;
        start.bodies[1].velocity = Vector2::zeros();
        let mut engine =
            EventDrivenEngine::<_>::new(scene, DissipationRule::Scene, start).expect("an engine");
        let mut journal = Journal::default();
        engine
            .advance(4.0, 1_000_000, &mut journal)
            .expect("no collapse");
        assert!(
            journal.0.len() <= 1,
            "seed {seed}: {} contacts",
            journal.0.len()
        );
        central += journal.0.len();
        assert!(engine.worst_overlap() < 1e-12);
    }
    assert!(central > 1000, "{central} of 2000 met");
}

/// A long segment restarts the engine by itself: such a restart gives the bits of a checkpoint made
/// by the caller. Contact times, image flags and a clock far from zero are included.
#[test]
fn starting_afresh_is_a_cut() {
    let (count, collisions) = (50, 130_000);
    let mut start = EventDrivenCheckpoint::from(gas(Arrangement::Disordered, count, 0.3, 8));
    start.state.time = 1e3;
    start.image_flags = vec![[0; 2]; count];
    let new = |checkpoint| {
        EventDrivenEngine::<_>::new(disks(1.0), DissipationRule::ContactTime(1e-2), checkpoint)
            .expect("an engine")
    };
    let mut whole = new(start.clone());
    whole
        .advance(f64::INFINITY, collisions, &mut ())
        .expect("collisions");
    let whole = whole.checkpoint();
    // Segments of one collision until the engine has restarted, which shows in the pushes of all
    // disks.
    let mut engine = new(start.clone());
    let mut before = engine.tally();
    let cut = loop {
        assert!(before.collisions < collisions, "no fresh start");
        engine
            .advance(f64::INFINITY, 1, &mut ())
            .expect("a collision");
        let now = engine.tally();
        let events = now.collisions - before.collisions + now.crossings - before.crossings;
        if now.pushes - before.pushes > 3 * events + count as u64 / 2 {
            break before.collisions;
        }
        before = now;
    };
    let mut first = new(start);
    first
        .advance(f64::INFINITY, cut, &mut ())
        .expect("collisions");
    let mut second = new(first.checkpoint());
    second
        .advance(f64::INFINITY, collisions - cut, &mut ())
        .expect("collisions");
    let second = second.checkpoint();
    assert_eq!(second.state.bodies, whole.state.bodies);
    assert_eq!(second.state.time, whole.state.time);
    assert_eq!(second.image_flags, whole.image_flags);
    assert_eq!(second.last_contact, whole.last_contact);
    assert_eq!(second.tally, whole.tally);
}

/// Flights of 3e4 to 3e9 diameters between collisions. Contacts are exact, and a disk crosses as
/// many cells between two of them as its free path over their width asks for.
#[test]
fn thin_gases_are_exact() {
    for (count, packing) in [
        (8, 1e-5),
        (8, 1e-7),
        (200, 1e-5),
        (200, 1e-7),
        (50, 1e-9),
        (20, 1e-10),
    ] {
        let scene = disks(1.0);
        let start = gas(Arrangement::Disordered, count, packing, 8);
        let energy = start.kinetic_energy(&scene);
        let mut engine = EventDrivenEngine::<_>::new(scene.clone(), DissipationRule::Scene, start)
            .expect("an engine");
        let mut journal = Journal::default();
        engine
            .advance(f64::INFINITY, 100, &mut journal)
            .expect("collisions");
        let lines = journal
            .0
            .iter()
            .map(|(_, line, _)| (line.norm() - 1.0).abs());
        let off = lines.fold(0.0, f64::max);
        // A quarter of the side of the box is the widest cell.
        let side = (count as f64 * std::f64::consts::FRAC_PI_4 / packing).sqrt();
        let width = (0.45_f64.sqrt() * side / (count as f64).sqrt()).min(0.25 * side);
        // Engine times of 4096 units, or of 16 cells, are rounded to 1.1e-16 of themselves. Disks
        // are moved some ten times in between.
        let rounding = 10.0 * 1.1e-16 * (16.0 * width).max(4096.0);
        assert!(
            off < rounding,
            "packing {packing}: contacts at distances off by {off:e}, {rounding:e} expected"
        );
        let energy = engine.state().kinetic_energy(&scene) / energy - 1.0;
        assert!(energy.abs() < 1e-13, "packing {packing}: {energy:e}");
        // The mean free path is pi d/(8 sqrt 2 phi); two disks fly it for a collision. Speeds of
        // all disks but the mean flight of few collisions leave a spread of some tens of per cent.
        let path = std::f64::consts::PI / (8.0 * 2.0_f64.sqrt() * packing);
        let expected = crossings_per_collision([side; 2], count, 1.0, path, false);
        let crossings = engine.tally().crossings as f64 / engine.tally().collisions as f64;
        assert!(
            crossings < 2.0 * expected && expected < 2.0 * crossings,
            "packing {packing}: {crossings} crossings a collision, {expected} expected"
        );
    }
}

/// Diameters from 1 to 30 with a density like their -2.5th power: several grids. They have the
/// collisions of all pairs, no overlap after many, and no more candidates than disks that are near.
#[test]
fn very_unequal_disks_follow_all_pairs() {
    let count = 400_usize;
    let diameters: Vec<f64> = (0..count)
        .map(|rank| (1.0 - 0.997 * rank as f64 / count as f64).powf(-2.0 / 3.0))
        .collect();
    assert!(diameters[count - 1] > 25.0);
    let area: f64 = diameters
        .iter()
        .map(|d| std::f64::consts::FRAC_PI_4 * d * d)
        .sum();
    let side = (area / 0.35).sqrt();
    let domain = Domain::periodic(Vector2::new(side, side)).expect("a box");
    let radii: Vec<f64> = diameters.iter().map(|d| 0.5 * d).collect();
    let placed = place_unequal(&radii, &domain, &Streams::new(6, 0), &Interrupt::default());
    let scene = mixture(1.0, diameters.iter().map(|d| (0.5 * d, d * d)));
    let state = maxwellian(&scene, domain, placed.expect("a gas").positions, 1.0, 6);
    let energy = state.kinetic_energy(&scene);
    let events = plain::run_collisions(&scene, &mut state.clone(), 150);
    let mut engine = EventDrivenEngine::<_>::new(scene.clone(), DissipationRule::Scene, state)
        .expect("an engine");
    let mut journal = Journal::default();
    engine
        .advance(f64::INFINITY, 150, &mut journal)
        .expect("collisions");
    assert_eq!(journal.0.len(), events.len());
    for (ours, theirs) in journal.0.iter().zip(&events) {
        // Rounding, 1e-15, grows by about e in each of the few collisions that a disk has had.
        assert!((ours.0 - theirs.time).abs() < 1e-8, "{ours:?} {theirs:?}");
    }
    for _ in 0..20 {
        engine
            .advance(f64::INFINITY, 10_000, &mut ())
            .expect("collisions");
        // A contact that is missed is an overlap of the order of a diameter.
        assert!(engine.worst_overlap() < 1e-11);
    }
    assert!((engine.state().kinetic_energy(&scene) / energy - 1.0).abs() < 1e-12);
    let tally = engine.tally();
    let predictions = tally.predictions as f64 / tally.collisions as f64;
    println!("{predictions:.1} predictions a collision");
    // Bound that fails a single grid: cells that hold the largest disk would make each disk test
    // half of all, over 400 a collision.
    assert!(predictions < 150.0, "{predictions}");
}

/// Work per collision and memory, as numbers: a slowdown shows here without a clock. Bounds 10 %
/// above what the present algorithm needs, and a little for what is rare.
#[test]
fn work_per_collision_is_bounded() {
    // Packing; predictions, pushes, crossings, stale events, broken contacts a collision.
    for (packing, most) in [
        (0.01, [28.1, 15.2, 12.9, 0.02, 0.09]),
        (0.25, [9.4, 3.95, 1.64, 0.02, 0.09]),
        (0.69, [15.5, 2.55, 0.17, 0.02, 0.18]),
    ] {
        let start = gas(Arrangement::Disordered, 4000, packing, 2);
        let mut engine = EventDrivenEngine::<_>::new(disks(1.0), DissipationRule::Scene, start)
            .expect("an engine");
        engine
            .advance(f64::INFINITY, 40_000, &mut ())
            .expect("collisions");
        let counts = |engine: &EventDrivenEngine<_>| {
            let tally = engine.tally();
            let all = [tally.predictions, tally.pushes, tally.crossings];
            let rare = [engine.stale(), tally.broken];
            [all[0], all[1], all[2], rare[0], rare[1]].map(|count| count as f64 / 40_000.0)
        };
        let before = counts(&engine);
        engine
            .advance(f64::INFINITY, 40_000, &mut ())
            .expect("collisions");
        let after = counts(&engine);
        let found: [f64; 5] = std::array::from_fn(|which| after[which] - before[which]);
        let bytes = engine.memory_bytes() / 4000;
        println!("packing {packing}: {found:.2?} a collision, {bytes} bytes a disk");
        for (found, most) in found.iter().zip(most) {
            assert!(
                *found < most,
                "packing {packing}: {found} of at most {most}"
            );
        }
        assert!(bytes <= 150, "packing {packing}: {bytes} bytes a disk");
    }
}

/// A collapse is reported, also when the run is cut into segments, and the TC model goes through
/// it.
///
/// The engine calls 4000 collisions, and 8 of each disk, without progress a collapse: more than a
/// segment of 200 disks, and just a segment of 1500.
#[test]
fn inelastic_collapse_is_an_error_and_the_contact_time_prevents_it() {
    for (count, leg) in [(200, 100_000_000), (200, 3_000), (1_500, 16_000)] {
        let start = gas(Arrangement::Disordered, count, 0.5, 4);
        let scene = disks(0.1);
        let mut checkpoint = EventDrivenCheckpoint::from(start.clone());
        let error = loop {
            let mut engine =
                EventDrivenEngine::<_>::new(scene.clone(), DissipationRule::Scene, checkpoint)
                    .expect("an engine");
            match engine.advance(1e6, leg, &mut ()) {
                Ok(true) => panic!("no collapse of {count} disks"),
                Ok(false) => checkpoint = engine.checkpoint(),
                Err(error) => break error,
            }
        };
        assert!(error.to_string().contains("inelastic collapse"), "{error}");
        let mut engine =
            EventDrivenEngine::<_>::new(scene, DissipationRule::ContactTime(1e-3), start)
                .expect("an engine");
        engine
            .advance(f64::INFINITY, 100 * count as u64, &mut ())
            .expect("no collapse");
        assert!(engine.tally().elastic_contacts > 0);
    }
}

/// A gas at rest reaches the requested time without an event.
#[test]
fn gas_at_rest_reaches_the_time() {
    let mut start = gas(Arrangement::Square, 16, 0.4, 1);
    for body in &mut start.bodies {
        body.velocity = Vector2::zeros();
    }
    let mut engine = EventDrivenEngine::<_>::new(disks(0.0), DissipationRule::Scene, start.clone())
        .expect("an engine");
    assert!(engine.advance(1e9, u64::MAX, &mut ()).expect("nothing"));
    assert_eq!(engine.time(), 1e9);
    assert_eq!(engine.state().bodies, start.bodies);
    start.bodies[3].velocity[0] = f64::NAN;
    assert!(EventDrivenEngine::<_>::new(disks(0.0), DissipationRule::Scene, start).is_err());
}
