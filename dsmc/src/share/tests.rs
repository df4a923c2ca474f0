//! A gas that several processes hold, which are threads here, against the same gas in one.

use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Mutex};
use std::thread;
use std::time::Duration;

use nalgebra::{Vector2, vector};
use stosszahl_model::random::Streams;
use stosszahl_model::walls::{Obstacle, Outline, Vibration};
use stosszahl_model::{
    Collision, Constant, Face, Gravity, Monodisperse, Observer, Physics, Plane, Rebound, Rough,
    Scene, Space as _, State, VectorOf, Volume, Wall, Walls,
};

use super::*;
use crate::simulator::{Followed, Unfollowed};
use crate::tests::{equal, start};
use crate::{Boundaries, Copies, Displacement, Inflow, Neighbourhood, Parameters, Scheme, Weights};

/// Threads that send each other bytes.
struct Threads {
    me: usize,
    to: Vec<Sender<Vec<u8>>>,
    from: Vec<Mutex<Receiver<Vec<u8>>>>,
}

impl Ranks for Threads {
    fn rank(&self) -> usize {
        self.me
    }

    fn size(&self) -> usize {
        self.to.len()
    }

    fn exchange_around(
        &self,
        messages: Vec<(usize, Vec<u8>)>,
        from: &[usize],
        meanwhile: &mut dyn FnMut(),
        then: &mut dyn FnMut(Vec<Vec<u8>>),
    ) {
        for (to, message) in messages {
            assert_ne!(to, self.me);
            self.to[to].send(message).expect("it listens");
        }
        meanwhile();
        let limit = Duration::from_mins(1);
        let receive = |&rank: &usize| {
            let from = self.from[rank].lock().expect("a lock");
            from.recv_timeout(limit).expect("a message in time")
        };
        then(from.iter().map(receive).collect());
    }
}

/// Does the work as each of some processes, and returns what the first found.
fn among<R: Send>(size: usize, work: impl Fn(Arc<dyn Ranks>) -> R + Sync) -> R {
    let mut ends: Vec<(Vec<Sender<_>>, Vec<_>)> =
        (0..size).map(|_| (Vec::new(), Vec::new())).collect();
    for from in 0..size {
        for to in 0..size {
            let (send, receive) = channel();
            ends[from].0.push(send);
            ends[to].1.push(Mutex::new(receive));
        }
    }
    thread::scope(|scope| {
        let threads: Vec<_> = ends
            .into_iter()
            .enumerate()
            .map(|(me, (to, from))| {
                let work = &work;
                scope.spawn(move || work(Arc::new(Threads { me, to, from })))
            })
            .collect();
        let mut all = threads.into_iter().map(|one| one.join().expect("no panic"));
        let first = all.next().expect("a process");
        all.for_each(drop);
        first
    })
}

#[test]
fn messages_reach_all() {
    for size in 1..10 {
        let found = among(size, |ranks| {
            let me = ranks.rank() as u8;
            let all = all_gather(&*ranks, vec![me; usize::from(me)]);
            for (rank, message) in all.iter().enumerate() {
                assert_eq!(message, &vec![rank as u8; rank], "{size}");
            }
            let told = if me == 0 { vec![7, 8] } else { Vec::new() };
            assert_eq!(broadcast(&*ranks, told), [7, 8]);
            gather(&*ranks, vec![me])
        });
        let wanted: Vec<Vec<u8>> = (0..size as u8).map(|rank| vec![rank]).collect();
        assert_eq!(found, wanted);
    }
}

/// All that an observer sees, in numbers that depend on the order.
#[derive(Default, PartialEq, Debug, Clone, Copy)]
struct Seen(u64, f64);

impl Observer for Seen {
    fn collisions(&mut self, batch: &[Collision]) {
        for one in batch {
            self.0 += 1;
            self.1 += one.time * one.normal_square() + 0.5 * self.1.sin() * one.position.norm();
        }
    }
}

struct Legs {
    steps: u64,
    count: usize,
    tiles: Option<usize>,
    looks: bool,
}

/// What is left of a gas after some legs, between which the first process holds all of it.
fn run<P: Physics, F: Follow<P::Space>>(
    make: &(dyn Fn() -> Engine<P, F> + Sync),
    legs: &Legs,
    ranks: Option<Arc<dyn Ranks>>,
) -> (Vec<u8>, Seen) {
    let mut engine = make();
    if let Some(tiles) = legs.tiles {
        engine.retile(tiles);
    }
    let first = ranks.as_ref().is_none_or(|ranks| ranks.rank() == 0);
    if let Some(ranks) = ranks {
        engine.share(ranks);
    }
    let mut seen = Seen::default();
    for leg in 0..legs.count {
        // Every second leg goes on from where tiles are.
        if leg % 2 == 1 {
            engine.unite();
            if first {
                engine.scale_velocities(0.99);
            }
        }
        if legs.looks {
            engine.advance(f64::INFINITY, legs.steps, &mut seen);
        } else {
            engine.advance(f64::INFINITY, legs.steps, &mut ());
        }
        assert!(!engine.is_interrupted());
    }
    engine.unite();
    if first {
        (write(&engine.checkpoint()), seen)
    } else {
        (Vec::new(), seen)
    }
}

fn assert_same<P: Physics, F: Follow<P::Space>>(
    name: &str,
    legs: &Legs,
    sizes: &[usize],
    make: impl Fn() -> Engine<P, F> + Sync,
) {
    let alone = run(&make, legs, None);
    assert!(!legs.looks || alone.1.0 > 500, "{name}: {:?}", alone.1);
    for &size in sizes {
        let found = among(size, |ranks| run(&make, legs, Some(ranks)));
        assert!(alone.0 == found.0, "{name}, {size} processes");
        assert_eq!(alone.1, found.1, "{name}, {size} processes");
    }
}

fn start_of<P: Physics>(_scene: &P, count: usize, sides: VectorOf<P>) -> State<P> {
    start(count, sides, 4)
}

fn parameters(scheme: Scheme, cell: f64) -> Parameters {
    Parameters {
        scheme,
        displacement: Displacement::None,
        cell_size: Some(cell),
        simulators_per_disk: 1,
        copies: Copies::Independent,
        steps_per_crossing: 3.0,
        largest_contact_value: 10.0,
    }
}

#[test]
fn a_gas_in_the_plane_is_the_same_for_any_number_of_processes() {
    let state = start::<_>(6000, Vector2::new(150.0, 90.0), 4);
    let schemes = [
        (Scheme::Boltzmann, 3.0),
        (Scheme::FreeVolume, 3.0),
        (Scheme::Enskog(Neighbourhood::Cells(2)), 2.0),
        (Scheme::Esmc(Neighbourhood::Cells(1)), 2.0),
        (Scheme::StochasticDisks { stiffness: 2.0 }, 2.0),
        (Scheme::CONTACT_POINT, 1.5),
    ];
    for (scheme, cell) in schemes {
        let legs = Legs {
            steps: 12,
            count: 4,
            tiles: Some(250),
            looks: true,
        };
        assert_same::<_, Followed>(scheme.name(), &legs, &[1, 2, 3, 5, 8], || {
            let parameters = parameters(scheme, cell);
            Engine::start(&equal::<Plane>(0.7), parameters, &state, Streams::new(5, 0))
                .expect("an engine")
        });
    }
}

#[test]
fn a_gas_in_space_is_the_same_for_any_number_of_processes() {
    let state = start::<_>(6000, vector![24.0, 20.0, 16.0], 4);
    for (scheme, cell) in [(Scheme::Boltzmann, 2.0), (Scheme::CONTACT_POINT, 1.0)] {
        let legs = Legs {
            steps: 6,
            count: 2,
            tiles: Some(150),
            looks: true,
        };
        assert_same::<_, Unfollowed>(scheme.name(), &legs, &[2, 3, 8], || {
            let parameters = parameters(scheme, cell);
            Engine::start(
                &equal::<Volume>(0.8),
                parameters,
                &state,
                Streams::new(5, 0),
            )
            .expect("an engine")
        });
    }
}

/// A channel of rough disks that flow in and fall between a vibrating floor and a wall, around a disc, with simulators of several
/// weights.
#[test]
fn a_flow_is_the_same_for_any_number_of_processes() {
    let inflow = |side, density: f64, velocity: f64| Inflow {
        axis: 0,
        side,
        density,
        velocity: vector![velocity, 0.0],
        temperature: 1.0,
        spin_temperature: 1.0,
        like: 0,
    };
    let mut floor = Wall::<Plane>::still(Rebound::Diffuse { temperature: 0.7 });
    floor.sliding = vector![0.3, 0.0];
    floor.vibration = Vibration::new(0.3, 1.1).ok();
    let disc = Outline::Disc {
        centre: vector![6.0, 2.5],
        radius: 0.8,
    };
    let disc = Obstacle::new(disc, Rebound::Diffuse { temperature: 1.2 }).expect("an obstacle");
    let boundaries = Boundaries {
        obstacles: vec![disc.clone()],
        walls: Walls::new(&[
            [Face::Open; 2],
            [Face::Wall(floor), Face::Wall(Wall::specular())],
        ])
        .expect("fit"),
        inflows: vec![inflow(0, 100.0, 1.0), inflow(1, 50.0, -0.2)],
        weights: Weights::table([4, 2, 1], vec![1.0, 0.8, 0.5, 1.7, 1.0, 2.5, 1.0, 0.6])
            .expect("factors"),
        ..Boundaries::default()
    };
    let scene = Scene {
        space: Plane,
        surface: Rough::new(0.5, Plane::INERTIA).expect("a surface"),
        restitution: Constant::new(0.9).expect("a coefficient"),
        sizes: Monodisperse {
            radius: 0.005,
            mass: 1.0,
        },
        field: Gravity::new(vector![0.05, -0.2]).expect("finite"),
    };
    let mut state = start_of(&scene, 6000, vector![12.0, 5.0]);
    state.domain = boundaries.walls.domain(vector![12.0, 5.0]).expect("a box");
    state
        .bodies
        .retain(|body| !disc.holds(body.position) && body.position[1] > 0.7);
    let legs = Legs {
        steps: 8,
        count: 3,
        tiles: Some(300),
        looks: false,
    };
    assert_same::<_, Followed>("a flow", &legs, &[1, 2, 3, 8], || {
        let parameters = parameters(Scheme::Boltzmann, 0.3);
        let streams = Streams::new(9, 0);
        Engine::start_between(&scene, parameters, &state, &boundaries, streams).expect("an engine")
    });
}

/// Tiles change hands as the gas piles up, and nothing else does.
#[test]
fn tiles_that_change_hands_change_nothing() {
    let scene = equal::<Plane>(0.9);
    let mut state = start_of(&scene, 6000, vector![60.0, 40.0]);
    for body in &mut state.bodies {
        body.position[0] *= 0.3;
        body.velocity[0] += 3.0;
    }
    let legs = Legs {
        steps: 2 * STEPS_BETWEEN + 10,
        count: 1,
        tiles: Some(100),
        looks: true,
    };
    let owners = Mutex::new(Vec::new());
    let make = || {
        let parameters = parameters(Scheme::Boltzmann, 1.0);
        Engine::<_, Unfollowed>::start(&scene, parameters, &state, Streams::new(5, 0))
            .expect("an engine")
    };
    let found = among(3, |ranks| {
        let first = ranks.rank() == 0;
        let mut engine = make();
        engine.retile(100);
        engine.share(ranks);
        let mut seen = Seen::default();
        for step in 0..legs.steps {
            // The first guess counts simulators.
            for tile in engine.tiles.iter_mut().filter(|_| step > 0) {
                let weight = if tile.place.low[0] >= 40.0 {
                    1e-3
                } else {
                    1e-6
                };
                tile.seconds = if tile.is_here { weight } else { 0.0 };
            }
            engine.advance(f64::INFINITY, 1, &mut seen);
            if first {
                let now = engine.share.as_ref().map(|share| share.owners.clone());
                owners.lock().expect("a lock").push(now);
            }
        }
        engine.unite();
        (
            if first {
                write(&engine.checkpoint())
            } else {
                Vec::new()
            },
            seen,
        )
    });
    let mut owners = owners.into_inner().expect("a lock");
    owners.dedup();
    assert!(owners.len() > 1, "no tile has changed hands");
    let single = {
        let mut engine = make();
        engine.retile(100);
        let mut seen = Seen::default();
        for _ in 0..legs.steps {
            engine.advance(f64::INFINITY, 1, &mut seen);
        }
        (write(&engine.checkpoint()), seen)
    };
    assert!(single == found);
}
