//! Support for the tests of disks between walls and around obstacles.

use nalgebra::{Vector2, vector};
use rand::RngExt;
use stosszahl_ed::{DiskBoundaries, DissipationRule, EventDrivenEngine, Touchable, plain};
use stosszahl_model::initial;
use stosszahl_model::random::{Purpose, Streams};
use stosszahl_model::walls::{Face, Obstacle, ObstacleShape, Vibration, Wall, Walls};
use stosszahl_model::{
    Collision, Domain, Gravity, Observer, ParticleModel, Plane, Rebound, Rough, Sizes, State,
    samples,
};

pub fn rough(tangential: f64) -> Rough {
    Rough::new(tangential, 0.5).expect("a surface")
}

pub fn down(weight: f64) -> Gravity<Plane> {
    Gravity::new(vector![0.0, -weight]).expect("a field")
}

pub fn bounces(restitution: f64, slip: f64) -> Wall<Plane> {
    Wall::still(Rebound::Restitutive { restitution, slip })
}

pub fn vibrates(wall: Wall<Plane>, amplitude: f64, period: f64) -> Wall<Plane> {
    Wall {
        vibration: Vibration::new(amplitude, period).ok(),
        ..wall
    }
}

pub fn obstacle(outline: ObstacleShape) -> Obstacle {
    let law = Rebound::Restitutive {
        restitution: 1.0,
        slip: 1.0,
    };
    Obstacle::new(outline, law).expect("an obstacle")
}

/// Creates walls at lower and upper faces of the first and the second axis; `None` for a periodic
/// one.
pub fn walled(axes: [Option<[Wall<Plane>; 2]>; 2]) -> DiskBoundaries {
    let faces = axes.map(|pair| pair.map_or([Face::Periodic; 2], |pair| pair.map(Face::Wall)));
    DiskBoundaries {
        walls: Walls::new(&faces).expect("walls"),
        obstacles: Vec::new(),
        streams: Streams::new(5, 0),
    }
}

/// Creates a closed box of specular walls.
pub fn closed() -> DiskBoundaries {
    walled([Some([Wall::specular(); 2]), Some([Wall::specular(); 2])])
}

/// Creates a single disk of diameter one in a box, at a position with a velocity.
pub fn alone<P: ParticleModel<Space = Plane>>(
    boundaries: &DiskBoundaries,
    lengths: [f64; 2],
    at: [f64; 2],
    velocity: [f64; 2],
) -> State<P> {
    let domain = boundaries.walls.domain(lengths.into()).expect("a box");
    samples::state(domain, [(at.into(), velocity.into())])
}

/// Creates a Maxwellian gas at random positions without overlap.
pub fn gas<P: ParticleModel<Space = Plane>>(
    scene: &P,
    boundaries: &DiskBoundaries,
    lengths: [f64; 2],
    count: usize,
    seed: u64,
) -> State<P> {
    let domain = boundaries.walls.domain(lengths.into()).expect("a box");
    let is_free = |at: Vector2<f64>, radius: f64| {
        let walls = (0..4).all(|face| {
            let (axis, side) = (face / 2, face % 2);
            let above = if side == 0 {
                at[axis]
            } else {
                lengths[axis] - at[axis]
            };
            let wall = boundaries.walls.wall(axis, side);
            let reach = |wall: &Wall<Plane>| wall.vibration.map_or(0.0, |v| v.amplitude());
            wall.is_none_or(|wall| above > radius + reach(wall))
        });
        let steps = [-1.0, 0.0, 1.0];
        let clear = |obstacle: &Obstacle| {
            steps.iter().all(|&right| {
                steps.iter().all(|&up| {
                    let image = at + vector![right * lengths[0], up * lengths[1]];
                    !obstacle.overlaps(image, radius, 0.0)
                })
            })
        };
        walls && boundaries.obstacles.iter().all(clear)
    };
    gas_in(scene, domain, count, seed, is_free)
}

/// Creates a Maxwellian gas at random positions without overlap, where `is_free` allows a disk of a
/// radius.
pub fn gas_in<P: ParticleModel<Space = Plane>>(
    scene: &P,
    domain: Domain<Plane>,
    count: usize,
    seed: u64,
    is_free: impl Fn(Vector2<f64>, f64) -> bool,
) -> State<P> {
    let stream = |purpose| Streams::new(seed, 0).stream_at(purpose, [0, 0]);
    let mut places = stream(Purpose::Placement);
    let (sizes, lengths) = (scene.sizes(), domain.lengths());
    let radius = |disk: usize| sizes.radius(sizes.tag_of(disk));
    let mut positions: Vec<Vector2<f64>> = Vec::new();
    for disk in 0..count {
        let free = |at: &Vector2<f64>| {
            let apart = |other: usize| {
                domain.distance(*at, positions[other]) > radius(disk) + radius(other)
            };
            is_free(*at, radius(disk)) && (0..disk).all(apart)
        };
        let at = std::iter::repeat_with(|| lengths.map(|side| side * places.random::<f64>()))
            .take(1_000_000)
            .find(free)
            .expect("a free place");
        positions.push(at);
    }
    let mut state = samples::maxwellian(scene, domain, positions, 1.0, seed);
    initial::thermal_spins(scene, &mut state, 1.0, &mut stream(Purpose::Spins));
    state
}

/// Observer of the times of all collisions of two disks.
#[derive(Default)]
pub struct Journal(pub Vec<f64>);

impl Observer for Journal {
    fn on_collisions(&mut self, batch: &[Collision]) {
        self.0.extend(batch.iter().map(|collision| collision.time));
    }
}

/// Compares the engine with all pairs, walls and obstacles: the contacts must be the same in the
/// same order, and so must the gas after them. Rounding differs, and each contact of a disk
/// multiplies differences: a handful of contacts per disk leave 1e-8. Returns the number of
/// contacts with walls and obstacles.
pub fn follow_plain<P: ParticleModel<Space = Plane>>(
    scene: &P,
    boundaries: &DiskBoundaries,
    start: &State<P>,
    contacts: usize,
) -> usize {
    let mut slow = start.clone();
    let events = plain::run_between(scene, &mut slow, boundaries, contacts);
    assert_eq!(events.len(), contacts);
    let end = events[contacts - 1].time;
    let mut engine = EventDrivenEngine::<P>::between(
        scene.clone(),
        DissipationRule::Scene,
        start.clone(),
        boundaries,
    )
    .expect("an engine");
    let mut journal = Journal::default();
    assert!(
        engine
            .advance(end + 1e-7, u64::MAX, &mut journal)
            .expect("contacts")
    );
    let mut times = journal.0.iter();
    let mut ledgers = vec![0.0; engine.ledgers().len()];
    for (number, event) in events.iter().enumerate() {
        match event.met {
            plain::ContactPartners::Disks(_) => {
                let time = times.next().expect("a collision");
                assert!(
                    (time - event.time).abs() < 1e-8,
                    "{number}: {time} {event:?}"
                );
            }
            plain::ContactPartners::Boundary(_, Touchable::Wall { axis, side }) => {
                ledgers[2 * axis + side] += 1.0;
            }
            plain::ContactPartners::Boundary(_, Touchable::Obstacle(which)) => {
                ledgers[4 + which] += 1.0;
            }
        }
    }
    assert_eq!(times.next(), None);
    let found: Vec<f64> = engine
        .ledgers()
        .iter()
        .map(|ledger| ledger.contacts)
        .collect();
    assert_eq!(found, ledgers);
    let state = engine.state();
    for (one, other) in state.bodies.iter().zip(&slow.bodies) {
        let apart = state.domain.distance(one.position, other.position);
        // The engine ends later by 1e-7.
        assert!(apart < 1e-7 + 2e-7 * one.velocity.norm(), "{apart:e} apart");
    }
    let tally = engine.tally();
    assert_eq!(tally.collisions + tally.rebounds, contacts as u64);
    tally.rebounds as usize
}
