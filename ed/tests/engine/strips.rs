//! One gas on many threads has the bytes of one engine, for any gas and any strips.

use nalgebra::vector;
use rand::RngExt;
use stosszahl_ed::{
    DiskBoundaries, DissipationRule, EventDrivenCheckpoint, EventDrivenEngine, StripSettings,
    StripedEngine, simulate,
};
use stosszahl_model::random::{Purpose, Streams};
use stosszahl_model::samples::{UNIT, disks, grains, law, maxwellian, particles_of};
use stosszahl_model::walls::{ObstacleShape, Wall};
use stosszahl_model::{
    Budget, Collision, EachCollision, Interrupt, ParticleModel, ParticleSpec, Plane, Rebound, State,
};

use crate::support::{bounces, down, obstacle, rough, vibrates, walled};

/// Creates a gas of this many unit disks, at least, on a jittered lattice, without those that
/// overlap obstacles; as wide as it is high over `aspect`.
fn lattice<P: ParticleModel<Space = Plane>>(
    scene: &P,
    boundaries: &DiskBoundaries,
    count: usize,
    packing: f64,
    aspect: f64,
) -> State<P> {
    // Triangles hold up to a packing of .9.
    let spacing = (std::f64::consts::FRAC_PI_4 / packing / 0.75_f64.sqrt()).sqrt();
    let columns = (count as f64 / aspect * 0.75_f64.sqrt()).sqrt().ceil() as usize;
    let rows = (count.div_ceil(columns)).next_multiple_of(2);
    let lengths = vector![
        columns as f64 * spacing,
        rows as f64 * spacing * 0.75_f64.sqrt()
    ];
    let domain = boundaries.walls.domain(lengths).expect("a box");
    let mut stream = Streams::new(1, 0).stream_at(Purpose::Placement, [0, 0]);
    let jitter = 0.45 * (spacing - 1.0);
    let mut positions = Vec::new();
    for row in 0..rows {
        for column in 0..columns {
            let shift = if row % 2 == 0 { 0.25 } else { 0.75 };
            let mut off = || jitter * (stream.random::<f64>() - 0.5);
            let at = vector![
                (column as f64 + shift) * spacing + off(),
                (row as f64 + 0.5) * spacing * 0.75_f64.sqrt() + off()
            ];
            let inside = (0..2).all(|axis| {
                domain.is_periodic(axis) || (at[axis] > 0.6 && at[axis] < lengths[axis] - 0.6)
            });
            let free = (boundaries.obstacles.iter()).all(|one| !one.overlaps(at, 0.5, 0.0));
            if inside && free {
                positions.push(at);
            }
        }
    }
    maxwellian(scene, domain, positions, 1.0, 1)
}

/// Result of a run: its checkpoint, and all its collisions.
type Left = (Vec<u8>, Vec<Collision>);

/// Runs legs with an engine each, as a run that is killed and resumed after each does.
fn run<P: ParticleModel<Space = Plane>>(
    scene: &P,
    dissipation: DissipationRule,
    boundaries: &DiskBoundaries,
    start: impl Into<EventDrivenCheckpoint<P>>,
    legs: &[(f64, u64)],
    strips: usize,
) -> (Left, StripSettings) {
    let mut checkpoint = start.into();
    let mut collisions = Vec::new();
    let mut spread = StripSettings::default();
    for &(until, most) in legs {
        let engine =
            EventDrivenEngine::<P>::between(scene.clone(), dissipation, checkpoint, boundaries);
        let mut engine = StripedEngine::new(engine.expect("an engine"), strips);
        let mut observer = EachCollision(|collision: &Collision| collisions.push(*collision));
        engine.advance(until, most, &mut observer).expect("time");
        checkpoint = engine.engine().checkpoint();
        let its = engine.settings();
        spread.windows += its.windows;
        spread.retries += its.retries;
        spread.events += its.events;
        spread.twice += its.twice;
    }
    let bytes = postcard::to_stdvec(&checkpoint).expect("bytes");
    ((bytes, collisions), spread)
}

/// Advances one engine to times one after another, in which its strips stay.
fn stay<P: ParticleModel<Space = Plane>>(
    scene: &P,
    dissipation: DissipationRule,
    boundaries: &DiskBoundaries,
    start: EventDrivenCheckpoint<P>,
    times: &[f64],
    strips: usize,
) -> (Left, StripSettings) {
    let engine = EventDrivenEngine::<P>::between(scene.clone(), dissipation, start, boundaries);
    let mut engine = StripedEngine::new(engine.expect("an engine"), strips);
    let (mut bytes, mut collisions) = (Vec::new(), Vec::new());
    for &until in times {
        let mut observer = EachCollision(|collision: &Collision| collisions.push(*collision));
        let there = engine.advance(until, u64::MAX, &mut observer);
        assert!(there.expect("time"));
        bytes.extend(postcard::to_stdvec(&engine.engine().checkpoint()).expect("bytes"));
    }
    ((bytes, collisions), engine.settings().clone())
}

/// Compares strips with one engine, and checks that there were strips.
fn compare<P: ParticleModel<Space = Plane>>(
    name: &str,
    scene: &P,
    dissipation: DissipationRule,
    boundaries: &DiskBoundaries,
    start: &EventDrivenCheckpoint<P>,
    legs: &[(f64, u64)],
) {
    let (plain, _) = run(scene, dissipation, boundaries, start.clone(), legs, 1);
    for strips in [2, 3, 4, 8] {
        let (left, spread) = run(scene, dissipation, boundaries, start.clone(), legs, strips);
        assert!(spread.windows > 0, "{name}: {strips} strips were not used");
        assert_eq!(left.1.len(), plain.1.len(), "{name}: {strips} strips");
        assert!(left.1 == plain.1, "{name}: collisions of {strips} strips");
        assert!(left.0 == plain.0, "{name}: bytes of {strips} strips");
    }
    // Equally many collisions in five advances of one engine.
    let engine =
        EventDrivenEngine::<P>::between(scene.clone(), dissipation, start.clone(), boundaries);
    let mut engine = engine.expect("an engine");
    let times: Vec<f64> = (0..5)
        .map(|_| {
            let each = plain.1.len() as u64 / 5;
            engine.advance(FOREVER, each, &mut ()).expect("time");
            engine.time()
        })
        .collect();
    let (plain, _) = stay(scene, dissipation, boundaries, start.clone(), &times, 1);
    let (left, spread) = stay(scene, dissipation, boundaries, start.clone(), &times, 3);
    assert!(spread.windows > 0, "{name}: strips that stay were not used");
    assert!(left.1 == plain.1, "{name}: collisions of strips that stay");
    assert!(left.0 == plain.0, "{name}: bytes of strips that stay");
}

const FOREVER: f64 = f64::INFINITY;

#[test]
fn periodic_gases() {
    for (packing, restitution) in [
        (0.01, 1.0),
        (0.01, 0.8),
        (0.25, 1.0),
        (0.25, 0.8),
        (0.70, 1.0),
        (0.70, 0.8),
    ] {
        let scene = disks(restitution);
        let boundaries = DiskBoundaries::periodic();
        let start = lattice(&scene, &boundaries, 20_000, packing, 1.0);
        let legs = [(FOREVER, 30_000), (FOREVER, 40_001), (FOREVER, 25_000)];
        let name = format!("packing {packing}, restitution {restitution}");
        let dissipation = DissipationRule::Scene;
        compare(
            &name,
            &scene,
            dissipation,
            &boundaries,
            &start.into(),
            &legs,
        );
    }
}

/// Strips give equal bytes behind the common interface, by legs and with pauses.
#[test]
fn a_simulation_on_two_threads() {
    let scene = disks(0.8);
    let boundaries = DiskBoundaries::periodic();
    let state = lattice(&scene, &boundaries, 40_000, 0.3, 1.0);
    let grains = ParticleSpec::equal(0.5, 1.0, law(0.8));
    let start = particles_of(&UNIT, &state);
    let [alone, shared] = [1, 2].map(|threads| {
        let mut gas =
            simulate(&grains, DissipationRule::Scene, &boundaries, &start).expect("an engine");
        gas.use_threads(threads);
        let until = gas.time() + 1e3;
        for _ in 0..2 {
            assert!(!gas.advance(until, Budget::Leg, &mut ()).expect("time"));
        }
        for budget in [Budget::Collisions(70_001), Budget::Leg] {
            assert!(!gas.advance(until, budget, &mut ()).expect("time"));
        }
        gas.save_checkpoint().expect("bytes")
    });
    assert!(alone == shared);
}

/// Strips give equal bytes in a cooled gas with clusters, in which windows are short, and empty
/// regions.
#[test]
fn a_clustered_gas() {
    let scene = disks(0.8);
    let boundaries = DiskBoundaries::periodic();
    let start = lattice(&scene, &boundaries, 40_000, 0.25, 2.0);
    let dissipation = DissipationRule::ContactTime(1e-5);
    let mut engine =
        EventDrivenEngine::<_>::new(scene.clone(), dissipation, start).expect("an engine");
    engine.advance(FOREVER, 2_000_000, &mut ()).expect("time");
    let start = engine.checkpoint();
    let until = start.state.time * 1.2;
    let legs = [(FOREVER, 30_000), (FOREVER, 60_000), (until, u64::MAX)];
    compare("clustered", &scene, dissipation, &boundaries, &start, &legs);
}

/// Strips give equal bytes, ledgers of walls too, between walls of all kinds, around obstacles,
/// under gravity, and with spin.
#[test]
fn walls_obstacles_gravity_and_spin() {
    let diffuse = Wall::still(Rebound::Diffuse { temperature: 1.0 });
    let mut channel = walled([
        None,
        Some([vibrates(bounces(0.9, 0.5), 0.05, 1.0), diffuse]),
    ]);
    channel.obstacles = vec![
        obstacle(ObstacleShape::Circle {
            centre: vector![30.0, 40.0],
            radius: 6.0,
        }),
        obstacle(ObstacleShape::Circle {
            centre: vector![60.0, 90.0],
            radius: 3.0,
        }),
    ];
    let legs = [(FOREVER, 20_000), (FOREVER, 20_001), (FOREVER, 20_000)];
    let scene = grains(1.0, 0.9, rough(0.4), down(0.01));
    let start = lattice(&scene, &channel, 12_000, 0.25, 1.5);
    compare(
        "channel",
        &scene,
        DissipationRule::Scene,
        &channel,
        &start.into(),
        &legs,
    );
    let sides = walled([Some([Wall::specular(), diffuse]), None]);
    let scene = disks(0.9);
    let start = lattice(&scene, &sides, 12_000, 0.4, 1.5);
    compare(
        "sides",
        &scene,
        DissipationRule::Scene,
        &sides,
        &start.into(),
        &legs,
    );
}

/// A collapse happens at the collision, and with the message, of a single engine.
#[test]
fn a_collapse_is_that_of_one_engine() {
    let scene = disks(0.3);
    let boundaries = DiskBoundaries::periodic();
    let start = lattice(&scene, &boundaries, 20_000, 0.25, 1.0);
    let [alone, shared] = [1, 4].map(|strips| {
        let engine =
            EventDrivenEngine::<_>::new(scene.clone(), DissipationRule::Scene, start.clone());
        let mut engine = StripedEngine::new(engine.expect("an engine"), strips);
        let error = (engine.advance(FOREVER, u64::MAX, &mut ())).expect_err("a collapse");
        assert_eq!(engine.settings().windows > 0, strips > 1);
        let bytes = postcard::to_stdvec(&engine.engine().checkpoint()).expect("bytes");
        (error.to_string(), bytes)
    });
    assert_eq!(alone.0, shared.0);
    assert!(alone.1 == shared.1);
}

/// A leap that is interrupted ends.
#[test]
fn an_interrupt_ends_all_strips() {
    let scene = disks(1.0);
    let boundaries = DiskBoundaries::periodic();
    let start = lattice(&scene, &boundaries, 20_000, 0.3, 1.0);
    let engine =
        EventDrivenEngine::<_>::new(scene, DissipationRule::Scene, start).expect("an engine");
    let mut engine = StripedEngine::new(engine, 4);
    let interrupt = Interrupt::default();
    engine.set_stop_flag(&interrupt);
    let mut seen = 0_u64;
    let mut observer = EachCollision(|_: &Collision| {
        seen += 1;
        if seen == 50_000 {
            interrupt.raise();
        }
    });
    assert!(
        !engine
            .advance(FOREVER, u64::MAX, &mut observer)
            .expect("an end")
    );
    assert!(engine.engine().is_interrupted());
    assert!(engine.settings().windows > 0);
}
