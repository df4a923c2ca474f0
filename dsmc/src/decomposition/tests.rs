//! Domain decomposition over threads against the same gas in one process.

use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Mutex};
use std::thread;
use std::time::Duration;

use nalgebra::{Vector2, Vector3, vector};
use stosszahl_model::random::Streams;
use stosszahl_model::samples::{EqualDisks, equal, grains};
use stosszahl_model::walls::{Obstacle, ObstacleShape, Vibration};
use stosszahl_model::{
    Collision, Face, Gravity, Observer, ParticleModel, Plane, Rebound, Rough, Space as _, State,
    Vector as _, VectorOf, VelocityMoments, Volume, Wall, Walls,
};

use super::distribution::STEPS_BETWEEN;
use super::ranks::gather;
use super::*;
use crate::particle::{DisplacementTracking, Tracked, Untracked};
use crate::tests::start;
use crate::{
    BoundaryConditions, DsmcCheckpoint, DsmcEngine, DsmcError, Grid, Inflow, Neighbourhood,
    Parameters, PartnerDisplacement, Scheme, SimulatorStart, SimulatorWeights, StartStream,
};

/// Transport between threads that send each other bytes.
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

/// Runs the work once for each rank, in threads, and returns the result of the first.
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
            let sum = all_reduce(&*ranks, u64::from(me), |sum, more| *sum += more);
            assert_eq!(sum, (0..size as u64).sum());
            gather(&*ranks, vec![me])
        });
        let wanted: Vec<Vec<u8>> = (0..size as u8).map(|rank| vec![rank]).collect();
        assert_eq!(found, wanted);
    }
}

/// Sums over particles are reduced to the root process.
#[test]
fn sums_over_processes_are_put_together_in_the_first() {
    for size in 1..10 {
        let found = among(size, |ranks| {
            let mut sum = VelocityMoments::default();
            sum.add(1.0, ranks.rank() as f64);
            reduce(&*ranks, &mut sum);
            sum.means()[0]
        });
        assert_eq!(found, 0.5 * (size - 1) as f64, "{size}");
    }
}

/// Hash and sum of all observed collisions; both depend on the order.
#[derive(Default, PartialEq, Debug, Clone, Copy)]
struct Seen(u64, f64);

impl Observer for Seen {
    fn on_collisions(&mut self, batch: &[Collision]) {
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

/// State of a gas after several segments, between which the root process holds all of it.
fn run<P: ParticleModel, F: DisplacementTracking<P::Space>>(
    make: &(dyn Fn() -> DsmcEngine<P, F> + Sync),
    legs: &Legs,
    ranks: Option<Arc<dyn Ranks>>,
) -> (Vec<u8>, Seen) {
    let mut engine = make();
    if let Some(tiles) = legs.tiles {
        engine.retile(tiles);
    }
    let first = ranks.as_ref().is_none_or(|ranks| ranks.rank() == 0);
    if let Some(ranks) = ranks {
        engine.distribute_among(ranks);
    }
    let mut seen = Seen::default();
    for leg in 0..legs.count {
        // Every second segment continues with scattered tiles.
        if leg % 2 == 1 {
            engine.gather_tiles();
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
    engine.gather_tiles();
    if first {
        (to_bytes(&engine.checkpoint()), seen)
    } else {
        (Vec::new(), seen)
    }
}

fn assert_same<P: ParticleModel, F: DisplacementTracking<P::Space>>(
    name: &str,
    legs: &Legs,
    sizes: &[usize],
    make: impl Fn() -> DsmcEngine<P, F> + Sync,
) {
    let alone = run(&make, legs, None);
    assert!(!legs.looks || alone.1.0 > 500, "{name}: {:?}", alone.1);
    for &size in sizes {
        let found = among(size, |ranks| run(&make, legs, Some(ranks)));
        assert!(alone.0 == found.0, "{name}, {size} processes");
        assert_eq!(alone.1, found.1, "{name}, {size} processes");
    }
}

fn start_of<P: ParticleModel>(_scene: &P, count: usize, sides: VectorOf<P>) -> State<P> {
    start(count, sides, 4)
}

fn parameters(scheme: Scheme, cell: f64) -> Parameters {
    Parameters {
        scheme,
        displacement: PartnerDisplacement::None,
        cell_size: Some(cell),
        simulators_per_particle: 1,
        copies: SimulatorStart::Independent,
        steps_per_cell_crossing: 3.0,
        max_contact_value: 10.0,
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
        assert_same::<_, Tracked>(scheme.name(), &legs, &[1, 2, 3, 5, 8], || {
            let parameters = parameters(scheme, cell);
            DsmcEngine::setup(&equal::<Plane>(0.7), parameters, Streams::new(5, 0))
                .start(&state)
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
        assert_same::<_, Untracked>(scheme.name(), &legs, &[2, 3, 8], || {
            let parameters = parameters(scheme, cell);
            DsmcEngine::setup(&equal::<Volume>(0.8), parameters, Streams::new(5, 0))
                .start(&state)
                .expect("an engine")
        });
    }
}

/// Channel of rough disks with inflow, gravity, a vibrating floor, a disk as obstacle, and several
/// simulator weights.
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
    let disk = ObstacleShape::Circle {
        centre: vector![6.0, 2.5],
        radius: 0.8,
    };
    let disk = Obstacle::new(disk, Rebound::Diffuse { temperature: 1.2 }).expect("an obstacle");
    let boundaries = BoundaryConditions {
        obstacles: vec![disk.clone()],
        walls: Walls::new(&[
            [Face::Open; 2],
            [Face::Wall(floor), Face::Wall(Wall::specular())],
        ])
        .expect("fit"),
        inflows: vec![inflow(0, 100.0, 1.0), inflow(1, 50.0, -0.2)],
        weights: SimulatorWeights::table([4, 2, 1], vec![1.0, 0.8, 0.5, 1.7, 1.0, 2.5, 1.0, 0.6])
            .expect("factors"),
        ..BoundaryConditions::default()
    };
    let surface = Rough::new(0.5, Plane::INERTIA).expect("a surface");
    let field = Gravity::new(vector![0.05, -0.2]).expect("finite");
    let scene = grains(0.01, 0.9, surface, field);
    let mut state = start_of(&scene, 6000, vector![12.0, 5.0]);
    state.domain = boundaries.walls.domain(vector![12.0, 5.0]).expect("a box");
    state
        .bodies
        .retain(|body| !disk.holds(body.position) && body.position[1] > 0.7);
    let legs = Legs {
        steps: 8,
        count: 3,
        tiles: Some(300),
        looks: false,
    };
    assert_same::<_, Tracked>("a flow", &legs, &[1, 2, 3, 8], || {
        let parameters = parameters(Scheme::Boltzmann, 0.3);
        let streams = Streams::new(9, 0);
        DsmcEngine::setup(&scene, parameters, streams)
            .between(&boundaries)
            .start(&state)
            .expect("an engine")
    });
}

/// Partition that cuts cells, with a slit and a disk in it: density windows of one process contain
/// sub-cells of others.
#[test]
fn a_gas_around_thin_bodies_is_the_same_for_any_number_of_processes() {
    let plate = |from: [f64; 2], to: [f64; 2]| ObstacleShape::Segment {
        ends: [from.into(), to.into()],
    };
    let disk = ObstacleShape::Circle {
        centre: vector![40.3, 52.1],
        radius: 3.0,
    };
    let outlines = [
        plate([0.0, 41.3], [70.0, 41.3]),
        plate([73.0, 41.3], [149.0, 47.0]),
        disk,
    ];
    let law = Rebound::Restitutive {
        restitution: 0.9,
        slip: 1.0,
    };
    let obstacles = outlines.map(|outline| Obstacle::new(outline, law).expect("an obstacle"));
    let mut state = start::<_>(6000, Vector2::new(150.0, 90.0), 4);
    (state.bodies).retain(|body: &stosszahl_model::ParticleState<EqualDisks>| {
        obstacles
            .iter()
            .all(|one| one.clearance(body.position) > 0.5)
    });
    let boundaries = BoundaryConditions {
        obstacles: obstacles.to_vec(),
        clearance: crate::WallClearance::Radius,
        ..BoundaryConditions::default()
    };
    let legs = Legs {
        steps: 12,
        count: 2,
        tiles: Some(250),
        looks: true,
    };
    for neighbourhood in [0, 2] {
        assert_same::<_, Tracked>("thin bodies", &legs, &[2, 3, 8], || {
            let scheme = Scheme::Enskog(Neighbourhood::Cells(neighbourhood));
            let parameters = parameters(scheme, 2.0);
            let (scene, streams) = (equal::<Plane>(0.7), Streams::new(5, 0));
            DsmcEngine::setup(&scene, parameters, streams)
                .between(&boundaries)
                .start(&state)
                .expect("an engine")
        });
    }
}

/// Load balancing moves tiles as the gas piles up, and results do not change.
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
        DsmcEngine::<_, Untracked>::setup(&scene, parameters, Streams::new(5, 0))
            .start(&state)
            .expect("an engine")
    };
    let found = among(3, |ranks| {
        let first = ranks.rank() == 0;
        let mut engine = make();
        engine.retile(100);
        engine.distribute_among(ranks);
        let mut seen = Seen::default();
        for step in 0..legs.steps {
            // The first estimate counts simulators.
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
        engine.gather_tiles();
        (
            if first {
                to_bytes(&engine.checkpoint())
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
        (to_bytes(&engine.checkpoint()), seen)
    };
    assert!(single == found);
}

/// Manifest of a sharded checkpoint.
type Manifest<P, F> = (DsmcCheckpoint<P, F>, Vec<Shard>);

/// Runs a channel for some steps and returns the bytes of its state.
fn goes_on<F: DisplacementTracking<Plane>>(
    mut engine: DsmcEngine<EqualDisks, F>,
    first: bool,
) -> Vec<u8> {
    engine.advance(f64::INFINITY, 6, &mut ());
    engine.gather_tiles();
    if first {
        to_bytes(&engine.checkpoint())
    } else {
        Vec::new()
    }
}

/// Channel with inflow at one side and a wall opposite.
struct Channel {
    scene: EqualDisks,
    boundaries: BoundaryConditions<Plane>,
    state: State<EqualDisks>,
}

impl Channel {
    fn new() -> Self {
        let scene = equal::<Plane>(0.8);
        let inflow = Inflow {
            axis: 0,
            side: 0,
            density: 0.5,
            velocity: vector![1.0, 0.0],
            temperature: 1.0,
            spin_temperature: 1.0,
            like: 0,
        };
        let wall = || Face::Wall(Wall::<Plane>::still(Rebound::Diffuse { temperature: 0.7 }));
        let boundaries = BoundaryConditions {
            walls: Walls::new(&[[Face::Open; 2], [wall(), wall()]]).expect("fit"),
            inflows: vec![inflow],
            ..BoundaryConditions::default()
        };
        let sides = Vector2::new(120.0, 60.0);
        let mut state = start_of(&scene, 4000, sides);
        state.domain = boundaries.walls.domain(sides).expect("a box");
        state
            .bodies
            .retain(|body| (1.0..59.0).contains(&body.position[1]));
        Self {
            scene,
            boundaries,
            state,
        }
    }

    fn parameters() -> Parameters {
        parameters(Scheme::Boltzmann, 2.0)
    }

    /// Sets small tiles that do not depend on the number of simulators.
    fn tile(&self, engine: &mut DsmcEngine<EqualDisks>) {
        let simulators: Vec<_> = engine.ordered().copied().collect();
        let counts = engine.grid.counts().map(|count| count as usize);
        let (domain, reach) = (*engine.grid.domain(), engine.grid.reach());
        engine.grid = Grid::new(domain, counts, self.state.bodies.len(), 150, reach);
        engine.fill(&simulators);
    }

    fn begins(&self) -> DsmcEngine<EqualDisks, Untracked> {
        let (parameters, streams) = (Self::parameters(), Streams::new(3, 0));
        DsmcEngine::setup(&self.scene, parameters, streams)
            .between(&self.boundaries)
            .start(&self.state)
            .expect("an engine")
    }

    fn resumes(&self, checkpoint: DsmcCheckpoint<EqualDisks>) -> DsmcEngine<EqualDisks> {
        let (parameters, streams) = (Self::parameters(), Streams::new(3, 0));
        DsmcEngine::setup(&self.scene, parameters, streams)
            .between(&self.boundaries)
            .resume(self.state.domain, checkpoint)
            .expect("an engine")
    }

    /// Writes a checkpoint by several processes; returns its manifest and the later state of the
    /// gas.
    fn written_by(&self, size: usize, beside: &ShardLocation) -> (Vec<u8>, Vec<u8>) {
        among(size, |ranks| {
            let first = ranks.rank() == 0;
            let mut engine = self.begins();
            self.tile(&mut engine);
            engine.distribute_among(ranks);
            engine.advance(f64::INFINITY, 5, &mut ());
            let shards = engine.write_shards("gas.a-", beside).expect("written");
            let manifest: Manifest<_, _> = (engine.without_simulators(), shards);
            (to_bytes(&manifest), goes_on(engine, first))
        })
    }

    /// Reads the checkpoint in one process and continues.
    fn read_by_one(&self, manifest: &[u8], beside: &ShardLocation) -> Result<Vec<u8>, DsmcError> {
        let (mut gas, shards): Manifest<EqualDisks, Untracked> = from_bytes(manifest);
        gas.hold(read_all::<EqualDisks, Untracked>(&shards, beside)?);
        let mut engine = self.resumes(gas);
        self.tile(&mut engine);
        Ok(goes_on(engine, true))
    }

    /// Reads the checkpoint in several processes and continues if all can; else returns the errors.
    fn read_by(
        &self,
        size: usize,
        manifest: &[u8],
        beside: &ShardLocation,
    ) -> Result<Vec<u8>, String> {
        among(size, |ranks| {
            let (gas, shards): Manifest<EqualDisks, Untracked> = from_bytes(manifest);
            let mut engine = self.resumes(gas);
            self.tile(&mut engine);
            engine.distribute_among(ranks.clone());
            let done = engine.read_shards(&shards, beside);
            let why = done.err().map(|error| error.to_string());
            let all = all_gather(&*ranks, to_bytes(&why));
            match all.iter().find_map(|why| from_bytes::<Option<String>>(why)) {
                Some(why) => Err(why),
                None => Ok(goes_on(engine, ranks.rank() == 0)),
            }
        })
    }
}

/// A sharded checkpoint continues to the same bytes in any number of processes, one included.
#[test]
fn shards_are_read_by_any_number_of_processes() {
    let channel = Channel::new();
    for writers in [2, 5] {
        let folder = tempfile::tempdir().expect("a folder");
        let beside = ShardLocation {
            folder: folder.path().to_owned(),
            run: [7; 32],
        };
        let (manifest, wanted) = channel.written_by(writers, &beside);
        let files = std::fs::read_dir(folder.path()).expect("a folder").count();
        assert_eq!(files, writers);
        let found = channel.read_by_one(&manifest, &beside).expect("read");
        assert!(found == wanted, "{writers} writers, one reader");
        for readers in [1, 2, 3, 8] {
            let found = channel.read_by(readers, &manifest, &beside).expect("read");
            assert!(found == wanted, "{writers} writers, {readers} readers");
        }
    }
}

/// A shard that is missing, truncated, changed, or of another run or checkpoint is named in the
/// error.
#[test]
fn a_shard_that_cannot_be_used_is_named() {
    use std::fs;
    let channel = Channel::new();
    let folder = tempfile::tempdir().expect("a folder");
    let beside = ShardLocation {
        folder: folder.path().to_owned(),
        run: [7; 32],
    };
    let (manifest, wanted) = channel.written_by(3, &beside);
    let path = folder.path().join(shard_name("gas.a-", 1));
    let whole = fs::read(&path).expect("bytes");
    let flipped = |place: usize| {
        let mut bytes = whole.clone();
        bytes[place] ^= 4;
        Some(bytes)
    };
    let other = ShardLocation {
        run: [8; 32],
        ..beside.clone()
    };
    let elsewhere = tempfile::tempdir().expect("a folder");
    let again = ShardLocation {
        folder: elsewhere.path().to_owned(),
        ..beside.clone()
    };
    // A checkpoint of as many processes, some steps later.
    among(3, |ranks| {
        let mut engine = channel.begins();
        channel.tile(&mut engine);
        engine.distribute_among(ranks);
        engine.advance(f64::INFINITY, 8, &mut ());
        engine.write_shards("gas.a-", &again).expect("written");
    });
    let of_another = fs::read(elsewhere.path().join(shard_name("gas.a-", 1))).expect("bytes");
    let faults = [
        ("No such file", None, &beside),
        ("bytes of", Some(whole[..whole.len() - 1].to_vec()), &beside),
        (
            "bytes without its mark",
            Some(whole[..20].to_vec()),
            &beside,
        ),
        ("another hash", flipped(whole.len() / 2), &beside),
        ("another hash", flipped(60), &beside),
        ("belongs to another run", Some(whole.clone()), &other),
        ("of another checkpoint", Some(of_another), &beside),
    ];
    for (wanted, bytes, beside) in faults {
        match bytes {
            Some(bytes) => fs::write(&path, bytes).expect("written"),
            None => fs::remove_file(&path).expect("removed"),
        }
        let one = channel.read_by_one(&manifest, beside);
        let said = [
            one.expect_err(wanted).to_string(),
            channel.read_by(2, &manifest, beside).expect_err(wanted),
        ];
        for said in said {
            // If all shards are of another run, the first is named.
            let rank = usize::from(beside.run == [7; 32]);
            assert!(said.contains(&shard_name("gas.a-", rank)), "{said}");
            assert!(said.contains(wanted), "{wanted}: {said}");
            assert!(said.contains("of a checkpoint in 3 shards"), "{said}");
        }
    }
    fs::write(&path, &whole).expect("written");
    let found = channel.read_by(2, &manifest, &beside).expect("read");
    assert!(found == wanted);
}

/// Shards that cannot be written are an error of the root process, and the gas continues.
#[test]
fn a_folder_that_is_not_there_is_an_error() {
    let channel = Channel::new();
    let folder = tempfile::tempdir().expect("a folder");
    let beside = ShardLocation {
        folder: folder.path().join("not-there"),
        run: [7; 32],
    };
    let said = among(3, |ranks| {
        let first = ranks.rank() == 0;
        let mut engine = channel.begins();
        channel.tile(&mut engine);
        engine.distribute_among(ranks);
        engine.advance(f64::INFINITY, 5, &mut ());
        let said = engine.write_shards("gas.a-", &beside).map(drop);
        let before = engine.time();
        engine.advance(f64::INFINITY, 2, &mut ());
        assert!(engine.time() > before);
        assert_eq!(first, said.is_err());
        said
    });
    let said = said.expect_err("no folder").to_string();
    assert!(
        said.contains("process 0") && said.contains("not-there"),
        "{said}"
    );
}

/// State whose particles are visited one after the other, from the last to the first.
struct Visited<'a, P: ParticleModel>(&'a State<P>);

impl<P: ParticleModel> StartStream for Visited<'_, P> {
    fn dimension(&self) -> usize {
        P::Space::DIMENSION
    }

    fn lengths(&self) -> [f64; 3] {
        self.0.domain.lengths().spatial().into()
    }

    fn particles(&self) -> usize {
        self.0.bodies.len()
    }

    fn sets(&self) -> usize {
        1
    }

    fn visit_positions(&self, look: &mut dyn FnMut(usize, Vector3<f64>)) -> Result<(), String> {
        let bodies = self.0.bodies.iter().enumerate().rev();
        bodies.for_each(|(index, body)| look(index, body.position.spatial()));
        Ok(())
    }

    fn visit_velocities(&self, look: &mut dyn FnMut(usize, Vector3<f64>)) -> Result<(), String> {
        let bodies = self.0.bodies.iter().enumerate();
        bodies.for_each(|(index, body)| look(index, body.velocity.spatial()));
        Ok(())
    }

    fn visit_spins(&self, _: &mut dyn FnMut(usize, Vector3<f64>)) -> Result<(), String> {
        Ok(())
    }
}

/// Makes a start in parts, and returns the checkpoint of the whole gas, in the first process, and
/// the number of simulators that this process made and kept.
fn part_of_start<P: ParticleModel>(
    scene: &P,
    state: &State<P>,
    ranks: Arc<dyn Ranks>,
) -> Result<(Vec<u8>, usize), DsmcError> {
    let (start, boundaries) = (Visited(state), BoundaryConditions::default());
    let mut engine = DsmcEngine::<P, Untracked>::setup(
        scene,
        parameters(Scheme::Boltzmann, 3.0),
        Streams::new(5, 0),
    )
    .between(&boundaries)
    .before_start(&start, state.domain)?;
    let is_first = ranks.rank() == 0;
    engine.distribute_among(ranks);
    let own = engine.start_parts(&start)?;
    engine.unite_step_bounds(own)?;
    engine.gather_tiles();
    let whole = is_first.then(|| to_bytes(&engine.checkpoint()));
    Ok((whole.unwrap_or_default(), own))
}

/// Processes make a start in parts: the bytes are those of the start in one process, and no process
/// keeps more than its share, some tiles of 8192 simulators more or less.
#[test]
fn a_start_in_parts_has_the_bytes_of_a_whole_one() {
    let scene = equal::<Plane>(0.7);
    let state = start::<_>(120_000, Vector2::new(700.0, 400.0), 4);
    let whole = DsmcEngine::<_, Untracked>::setup(
        &scene,
        parameters(Scheme::Boltzmann, 3.0),
        Streams::new(5, 0),
    )
    .start(&state);
    let whole = to_bytes(&whole.expect("an engine").checkpoint());
    for size in [1, 2, 3, 5] {
        let kept = Mutex::new(Vec::new());
        let found = among(size, |ranks| {
            let made = part_of_start(&scene, &state, ranks).expect("a start");
            kept.lock().expect("a lock").push(made.1);
            made.0
        });
        assert!(found == whole, "{size}");
        let kept = kept.into_inner().expect("a lock");
        let most = kept.iter().copied().max().expect("a process");
        assert_eq!(kept.iter().sum::<usize>(), 120_000);
        assert!(most <= 120_000 / size + 2 * 8192, "{size}: {kept:?}");
    }
}

/// Processes that make different starts are refused, all of them.
#[test]
fn different_starts_are_refused() {
    let scene = equal::<Plane>(0.7);
    let state = start::<_>(60_000, Vector2::new(700.0, 400.0), 4);
    let refused = Mutex::new(0);
    among(2, |ranks| {
        let mut state = state.clone();
        if ranks.rank() == 1 {
            for body in &mut state.bodies {
                body.position = vector![1.0, 1.0];
            }
        }
        let made = part_of_start(&scene, &state, ranks);
        if matches!(made, Err(DsmcError::UnequalParts { wanted: 60_000, .. })) {
            *refused.lock().expect("a lock") += 1;
        }
    });
    assert_eq!(refused.into_inner().expect("a lock"), 2);
}
