//! Obstacles thinner than a cell, or cutting one: partners are on the same side.

use nalgebra::{Vector2, vector};
use stosszahl_dsmc::{
    BoundaryConditions, DsmcEngine, DsmcError, Neighbourhood, Parameters, Scheme, WallClearance,
};
use stosszahl_model::random::Streams;
use stosszahl_model::samples::{FallingDisks, FallingParticles, grains, ideal_gas, no_gravity};
use stosszahl_model::walls::{Obstacle, ObstacleShape};
use stosszahl_model::{
    Collision, Domain, Face, Observer, Plane, Rebound, Smooth, Space, State, Volume, Wall, Walls,
};

use crate::support::PARAMETERS;

const SPECULAR: Rebound = Rebound::Restitutive {
    restitution: 1.0,
    slip: 1.0,
};

fn obstacle(outline: ObstacleShape) -> Obstacle {
    Obstacle::new(outline, SPECULAR).expect("an obstacle")
}

/// Thin plate through some points.
fn plate(points: &[[f64; 2]]) -> Obstacle {
    let points = points.iter().map(|&point| point.into()).collect();
    obstacle(ObstacleShape::Polyline { points })
}

/// Solid polygon with some corners.
fn solid(points: &[[f64; 2]]) -> Obstacle {
    let points = points.iter().map(|&point| point.into()).collect();
    obstacle(ObstacleShape::Polygon { points })
}

/// Channel that is periodic along the first axis, with elastic walls along the second.
fn channel(obstacles: Vec<Obstacle>, clearance: WallClearance) -> BoundaryConditions<Plane> {
    let wall = Face::Wall(Wall::specular());
    BoundaryConditions {
        walls: Walls::new(&[[Face::Periodic; 2], [wall; 2]]).expect("fit"),
        clearance,
        obstacles,
        ..BoundaryConditions::default()
    }
}

/// Height of a partition at x, for a nominal height, in a box 12 wide.
type Height = fn(f64, f64) -> f64;

/// Flat partition, and bent one.
const SHAPES: [Height; 2] = [
    |_, at| at,
    |x, at| at + 0.25 * (3.0 - (x - 6.0).abs()).max(0.0) - (3.0 - (x - 9.0).abs()).max(0.0) / 6.0,
];

/// Partition across the box, thin or of finite thickness.
fn partition(shape: Height, at: f64, thickness: f64) -> Obstacle {
    let corners = [0.0, 3.0, 6.0, 9.0, 12.0].map(|x| [x, shape(x, at)]);
    if thickness == 0.0 {
        return plate(&corners);
    }
    let above = corners.iter().rev().map(|&[x, y]| [x, y + thickness]);
    let all: Vec<[f64; 2]> = corners.iter().copied().chain(above).collect();
    solid(&all)
}

/// Two gases, one on each side of a partition, with their own numbers and temperatures.
fn two_gases(
    partition: &dyn Fn(f64) -> f64,
    thickness: f64,
    margin: f64,
    counts: [usize; 2],
    temperatures: [f64; 2],
    seed: u64,
) -> State<FallingDisks> {
    let scene = grains(0.2, 1.0, Smooth, no_gravity());
    let boundaries = channel(Vec::new(), WallClearance::Centre);
    let domain = boundaries.walls.domain(vector![12.0, 8.0]).expect("a box");
    let mut sides = [0, 1].map(|side| {
        // Ten times as many as needed: those on the other side are dropped.
        let many = 10 * counts[side];
        let mut all = ideal_gas::<FallingDisks>(
            &scene,
            domain,
            margin,
            many,
            temperatures[side],
            seed + side as u64,
        );
        all.bodies.retain(|body| {
            let height = partition(body.position[0]);
            if side == 0 {
                body.position[1] < height - 2.0 * margin
            } else {
                body.position[1] > height + thickness + 2.0 * margin
            }
        });
        assert!(all.bodies.len() >= counts[side]);
        all.bodies.truncate(counts[side]);
        all
    });
    let above = std::mem::take(&mut sides[1].bodies);
    sides[0].bodies.extend(above);
    let [all, _] = sides;
    all
}

/// Number and energy below and above the partition.
fn by_side(state: &State<FallingDisks>, partition: &dyn Fn(f64) -> f64) -> [[f64; 2]; 2] {
    let mut sums = [[0.0; 2]; 2];
    for body in &state.bodies {
        let side = usize::from(body.position[1] > partition(body.position[0]));
        sums[side][0] += 1.0;
        sums[side][1] += 0.5 * body.velocity.norm_squared();
    }
    sums
}

/// Schemes that support obstacles, with the clearance at which obstacles stop their particles.
const SCHEMES: [(Scheme, WallClearance); 4] = [
    (Scheme::Boltzmann, WallClearance::Centre),
    (Scheme::FreeVolume, WallClearance::Radius),
    (
        Scheme::Enskog(Neighbourhood::Cells(2)),
        WallClearance::Radius,
    ),
    (
        Scheme::Enskog(Neighbourhood::Cells(0)),
        WallClearance::Centre,
    ),
];

/// No collision carries energy through an elastic partition between a hot and a cold gas, wherever
/// it cuts the cells, thin or two diameters thick, straight or bent. Tolerance: each of some 1e5
/// collisions and rebounds changes the energy by some 1e-16.
#[test]
fn no_energy_goes_through_a_partition() {
    for (scheme, clearance) in SCHEMES {
        for shape in SHAPES {
            for (at, thickness) in [(4.0, 0.0), (3.8, 0.0), (4.47, 0.0), (3.3, 0.4), (4.9, 0.4)] {
                let height = |x: f64| shape(x, at);
                let boundaries = channel(vec![partition(shape, at, thickness)], clearance);
                let margin = if clearance == WallClearance::Radius {
                    0.1
                } else {
                    1e-6
                };
                let state = two_gases(&height, thickness, margin, [600, 600], [10.0, 0.1], 1);
                let scene = grains(0.2, 1.0, Smooth, no_gravity());
                let parameters = Parameters {
                    scheme,
                    ..PARAMETERS
                };
                let streams = Streams::new(1, 0);
                let mut engine: DsmcEngine<FallingDisks> =
                    DsmcEngine::setup(&scene, parameters, streams)
                        .between(&boundaries)
                        .start(&state)
                        .expect("an engine");
                engine.advance(1.0, u64::MAX, &mut ());
                assert!(engine.tally().collisions > 2000, "{:?}", engine.tally());
                let [before, after] =
                    [&state, &engine.state()].map(|state| by_side(state, &height));
                for side in 0..2 {
                    assert_eq!(before[side][0], after[side][0]);
                    let change = after[side][1] / before[side][1] - 1.0;
                    assert!(
                        change.abs() < 1e-10,
                        "{scheme:?} {at} {thickness}: {change}"
                    );
                }
            }
        }
    }
}

/// Collision counter below and above a partition.
struct Sides<'a> {
    partition: &'a dyn Fn(f64) -> f64,
    found: [f64; 2],
}

impl Observer for Sides<'_> {
    fn on_collisions(&mut self, batch: &[Collision]) {
        for one in batch {
            let side = one.position[1] > (self.partition)(one.position[0]);
            self.found[usize::from(side)] += one.weight;
        }
    }
}

/// Each side of a partition has the collision rate of its own density, also in cells that the
/// partition cuts. z = 4.4 Poisson errors, which detect 3.5 %. In addition, chi of a noisy count is
/// that of a denser gas: 1.5 % more for the 27 to 53 simulators of a cell, less than 1 % for Enskog
/// windows of 25 cells.
#[test]
fn each_side_has_the_collision_rate_of_its_own_density() {
    const SETS: u32 = 8;
    for (scheme, clearance) in SCHEMES {
        for shape in SHAPES {
            for (at, thickness) in [(3.8, 0.0), (4.47, 0.4)] {
                let height = |x: f64| shape(x, at);
                let boundaries = channel(vec![partition(shape, at, thickness)], clearance);
                let margin = if clearance == WallClearance::Radius {
                    0.1
                } else {
                    0.0
                };
                let counts = [320, 160];
                let sets: Vec<State<FallingDisks>> = (0..SETS)
                    .map(|set| {
                        let seed = 10 + 2 * u64::from(set);
                        two_gases(&height, thickness, margin, counts, [1.0, 1.0], seed)
                    })
                    .collect();
                let scene = grains(0.2, 1.0, Smooth, no_gravity());
                let parameters = Parameters {
                    scheme,
                    simulators_per_particle: SETS,
                    ..PARAMETERS
                };
                let streams = Streams::new(1, 0);
                let mut engine: DsmcEngine<FallingDisks> =
                    DsmcEngine::setup(&scene, parameters, streams)
                        .between(&boundaries)
                        .start_sets(&sets)
                        .expect("an engine");
                // Relaxes from the start, which leaves a margin at bends, to a uniform density.
                engine.advance(3.0, u64::MAX, &mut ());
                let mut sides = Sides {
                    partition: &height,
                    found: [0.0; 2],
                };
                engine.advance(15.0, u64::MAX, &mut sides);
                let free = free_area(&height, thickness, margin);
                let energies = by_side(&engine.state(), &height);
                for (side, count) in counts.map(|count| count as f64).into_iter().enumerate() {
                    let (energy, free) = (energies[side], free[side]);
                    let packing = count * Plane::particle_volume(0.1) / free;
                    let chi = scheme.contact_value::<Plane>(packing);
                    let temperature = energy[1] / energy[0];
                    let rate = Plane::collision_rate(packing, chi) / 0.2 * temperature.sqrt();
                    let pairs = 0.5 * count * rate * 12.0;
                    let ratio = sides.found[side] / pairs;
                    let error = 4.4 / (f64::from(SETS) * pairs).sqrt();
                    let noise = match scheme {
                        Scheme::Boltzmann => 0.0,
                        Scheme::Enskog(Neighbourhood::Cells(2)) => 0.01,
                        _ => 0.03,
                    };
                    assert!(error < 0.035);
                    assert!(
                        (ratio - 1.0).abs() < error + noise,
                        "{scheme:?} {at} {thickness} {side}: {ratio}"
                    );
                }
            }
        }
    }
}

/// Area below and above a partition that is open to centres at `clearance` from it, by a fine grid.
fn free_area(partition: &dyn Fn(f64) -> f64, thickness: f64, clearance: f64) -> [f64; 2] {
    const STEPS: u32 = 1200;
    let columns = (0..STEPS).map(|column| 12.0 * (f64::from(column) + 0.5) / f64::from(STEPS));
    let mut areas = [0.0; 2];
    for x in columns {
        // The nearest point of the surface is within a clearance along x, whatever the slope.
        let near = (-20..=20).map(|step| f64::from(step) / 20.0 * clearance);
        let reach = |of: f64| (clearance * clearance - of * of).max(0.0).sqrt();
        let wrapped = |x: f64| x.rem_euclid(12.0);
        let lowest = near
            .clone()
            .map(|dx| partition(wrapped(x + dx)) - reach(dx));
        let highest = near.map(|dx| partition(wrapped(x + dx)) + thickness + reach(dx));
        areas[0] += lowest.fold(f64::MAX, f64::min) - clearance;
        areas[1] += 8.0 - clearance - highest.fold(0.0, f64::max);
    }
    areas.map(|area| area * 12.0 / f64::from(STEPS))
}

/// A partition halfway up a cell shields disks below it from a sliding wall above. The error of the
/// mean velocity is that of eight replicas; t = 6.4 is 1e-4 false alarms on two sides with 7
/// degrees of freedom. The error must be small enough to detect half of the 0.2 to 0.4 that pairs
/// through the partition gave.
#[test]
fn a_partition_shields_a_gas_from_a_sliding_wall() {
    let mut floor = Wall::<Plane>::still(Rebound::Diffuse { temperature: 1.0 });
    let rest = Face::Wall(floor);
    floor.sliding = vector![1.0, 0.0];
    for obstacle in [
        plate(&[[0.0, 21.0], [40.0, 21.0]]),
        solid(&[[0.0, 23.0], [40.0, 23.0], [40.0, 25.0], [0.0, 25.0]]),
    ] {
        let boundaries = BoundaryConditions {
            walls: Walls::new(&[[Face::Periodic; 2], [rest, Face::Wall(floor)]]).expect("fit"),
            obstacles: vec![obstacle.clone()],
            ..BoundaryConditions::default()
        };
        let means: Vec<f64> = (0..8)
            .map(|replica| {
                let scene = grains(0.0625, 1.0, Smooth, no_gravity());
                let domain = boundaries.walls.domain(vector![40.0, 40.0]).expect("a box");
                let mut state = ideal_gas::<FallingDisks>(&scene, domain, 0.5, 6400, 1.0, replica);
                state.bodies.retain(|body| !obstacle.holds(body.position));
                let parameters = Parameters {
                    cell_size: Some(2.0),
                    ..PARAMETERS
                };
                let streams = Streams::new(replica, 0);
                let mut engine: DsmcEngine<FallingDisks> =
                    DsmcEngine::setup(&scene, parameters, streams)
                        .between(&boundaries)
                        .start(&state)
                        .expect("an engine");
                let (mut momentum, mut count) = (0.0, 0.0);
                engine.advance(100.0, u64::MAX, &mut ());
                for sample in 1..=20 {
                    engine.advance(100.0 + 10.0 * f64::from(sample), u64::MAX, &mut ());
                    for body in &engine.state().bodies {
                        if body.position[1] < 21.0 {
                            momentum += body.velocity[0];
                            count += 1.0;
                        }
                    }
                }
                momentum / count
            })
            .collect();
        let mean = means.iter().sum::<f64>() / 8.0;
        let squares: f64 = means.iter().map(|one| (one - mean).powi(2)).sum();
        let error = (squares / 7.0 / 8.0).sqrt();
        assert!(6.4 * error < 0.08, "{error}");
        assert!(mean.abs() < 6.4 * error, "{mean} +- {error}");
    }
}

/// A comb of plates in cells that hold several teeth, and a disk: the bytes do not depend on the
/// number of threads or the grouping of cells.
#[test]
fn sub_cells_give_the_same_bytes_for_any_number_of_threads() {
    let mut obstacles: Vec<Obstacle> = (0..8)
        .map(|tooth| {
            let x = 1.0 + 0.45 * f64::from(tooth);
            plate(&[[x, 2.0], [x + 0.1, 5.3]])
        })
        .collect();
    obstacles.push(obstacle(ObstacleShape::Circle {
        centre: vector![8.0, 4.0],
        radius: 0.7,
    }));
    let boundaries = channel(obstacles.clone(), WallClearance::Centre);
    let scene = grains(0.02, 1.0, Smooth, no_gravity());
    let domain = boundaries.walls.domain(vector![12.0, 8.0]).expect("a box");
    let mut state = ideal_gas::<FallingDisks>(&scene, domain, 0.0, 25_000, 1.0, 3);
    (state.bodies).retain(|body| {
        obstacles
            .iter()
            .all(|one| one.clearance(body.position) > 1e-6)
    });
    let run = |threads: usize, tile: Option<usize>| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        pool.expect("a pool").install(|| {
            let parameters = Parameters {
                scheme: Scheme::Enskog(Neighbourhood::Cells(1)),
                ..PARAMETERS
            };
            let streams = Streams::new(1, 0);
            let mut engine: DsmcEngine<FallingDisks> =
                DsmcEngine::setup(&scene, parameters, streams)
                    .between(&boundaries)
                    .start(&state)
                    .expect("an engine");
            if let Some(tile) = tile {
                engine.retile(tile);
            }
            engine.advance(f64::INFINITY, 5, &mut ());
            assert!(engine.tally().collisions > 1000);
            engine.state().bodies
        })
    };
    let one = run(1, None);
    assert!(one == run(3, None));
    assert!(one == run(2, Some(700)));
}

/// Obstacles are prisms in three dimensions: a plate that cuts cells separates two gases of
/// spheres.
#[test]
fn no_energy_goes_through_a_plate_in_space() {
    let boundaries = BoundaryConditions::<Volume> {
        walls: Walls::new(&[
            [Face::Periodic; 2],
            [Face::Wall(Wall::specular()); 2],
            [Face::Wall(Wall::specular()); 2],
        ])
        .expect("fit"),
        obstacles: vec![plate(&[[0.0, 2.3], [6.0, 2.7]])],
        clearance: WallClearance::Radius,
        ..BoundaryConditions::default()
    };
    let scene = grains::<Volume, _>(0.4, 1.0, Smooth, no_gravity());
    let domain = boundaries.walls.domain(vector![6.0, 5.0, 4.0]);
    let mut state = ideal_gas(&scene, domain.expect("a box"), 0.2, 1500, 1.0, 3);
    let height = |x: f64| 2.3 + 0.4 * x / 6.0;
    state.bodies.retain(
        |body: &stosszahl_model::ParticleState<FallingParticles<Volume, Smooth>>| {
            (body.position[1] - height(body.position[0])).abs() > 0.21
        },
    );
    let above = |body: &stosszahl_model::ParticleState<FallingParticles<Volume, Smooth>>| {
        body.position[1] > height(body.position[0])
    };
    for body in state.bodies.iter_mut().filter(|body| above(body)) {
        body.velocity *= 0.1;
    }
    for scheme in [Scheme::Boltzmann, Scheme::Enskog(Neighbourhood::Cells(1))] {
        let parameters = Parameters {
            scheme,
            ..PARAMETERS
        };
        let streams = Streams::new(1, 0);
        let mut engine: DsmcEngine<FallingParticles<Volume, Smooth>> =
            DsmcEngine::setup(&scene, parameters, streams)
                .between(&boundaries)
                .start(&state)
                .expect("an engine");
        engine.advance(2.0, u64::MAX, &mut ());
        assert!(engine.tally().collisions > 1000, "{:?}", engine.tally());
        let energy = |state: &State<FallingParticles<Volume, Smooth>>| -> f64 {
            let cold = state.bodies.iter().filter(|body| above(body));
            cold.map(|body| body.velocity.norm_squared()).sum()
        };
        let change = energy(&engine.state()) / energy(&state) - 1.0;
        assert!(change.abs() < 1e-10, "{change}");
    }
}

fn refusal(obstacles: Vec<Obstacle>, parameters: Parameters) -> DsmcError {
    let scene = grains(0.2, 1.0, Smooth, no_gravity());
    let domain = Domain::periodic(vector![12.0, 8.0]).expect("a box");
    let mut state = ideal_gas::<FallingDisks>(&scene, domain, 0.0, 50, 1.0, 3);
    (state.bodies).retain(|body| {
        obstacles
            .iter()
            .all(|one| one.clearance(body.position) > 0.01)
    });
    let boundaries = BoundaryConditions {
        obstacles,
        ..BoundaryConditions::default()
    };
    let engine = DsmcEngine::<FallingDisks>::setup(&scene, parameters, Streams::new(1, 0))
        .between(&boundaries)
        .start(&state);
    engine.err().expect("a refusal")
}

/// Obstacles that cut a cell into too many parts are refused, with a cell size that works.
#[test]
fn bodies_that_cannot_be_told_apart_are_refused() {
    let teeth: Vec<[f64; 2]> = (0..300)
        .map(|corner| {
            [
                4.1 + 0.006 * f64::from(corner),
                2.3 + 0.4 * f64::from(corner % 2),
            ]
        })
        .collect();
    let parameters = Parameters {
        cell_size: Some(4.0),
        ..PARAMETERS
    };
    let said = refusal(vec![plate(&teeth)], parameters).to_string();
    assert!(
        said.contains("cells 4 wide") && said.contains("the cell at (4, 0)"),
        "{said}"
    );
    let enough: f64 = said
        .split("cells of at most ")
        .nth(1)
        .and_then(|rest| rest.split(',').next())
        .and_then(|number| number.parse().ok())
        .expect("a size");
    let scene = grains(0.2, 1.0, Smooth, no_gravity());
    let state = State::<FallingDisks> {
        time: 0.0,
        domain: Domain::periodic(vector![12.0, 8.0]).expect("a box"),
        bodies: Vec::new(),
    };
    let boundaries = BoundaryConditions {
        obstacles: vec![plate(&teeth)],
        ..BoundaryConditions::default()
    };
    let smaller = Parameters {
        cell_size: Some(enough),
        ..PARAMETERS
    };
    let streams = Streams::new(1, 0);
    DsmcEngine::<FallingDisks>::setup(&scene, smaller, streams)
        .between(&boundaries)
        .start(&state)
        .expect("cells that do");
    let mean = Parameters {
        scheme: Scheme::Enskog(Neighbourhood::Mean),
        ..PARAMETERS
    };
    let one = || vec![plate(&[[1.0, 1.0], [2.0, 2.0]])];
    let said = refusal(one(), mean).to_string();
    assert!(said.contains("mean density of the whole box"), "{said}");
    let copies = Parameters {
        simulators_per_particle: 2,
        ..PARAMETERS
    };
    let said = refusal(one(), copies).to_string();
    assert!(said.contains("a state for each simulator"), "{said}");
    for scheme in Scheme::ALL
        .into_iter()
        .filter(|scheme| scheme.is_cross_cell())
    {
        let across = Parameters {
            scheme,
            ..PARAMETERS
        };
        let said = refusal(one(), across).to_string();
        assert!(
            said.contains("obstacles") && said.contains(scheme.name()),
            "{said}"
        );
    }
}

/// A hot gas inside a ring of twelve edges, in cells a third as wide as the ring, keeps its energy.
#[test]
fn a_closed_ring_holds_its_gas_apart() {
    let corner = |corner: u32| {
        let angle = std::f64::consts::TAU * f64::from(corner % 12) / 12.0;
        let centre: Vector2<f64> = vector![6.1, 4.2];
        (centre + vector![angle.cos(), angle.sin()] * 1.5).into()
    };
    let ring: Vec<[f64; 2]> = (0..=12).map(corner).collect();
    let boundaries = channel(vec![plate(&ring)], WallClearance::Centre);
    let filled = solid(&ring[..12]);
    let inside = |at: Vector2<f64>| filled.holds(at);
    let scene = grains(0.2, 1.0, Smooth, no_gravity());
    let domain = boundaries.walls.domain(vector![12.0, 8.0]).expect("a box");
    let mut state = ideal_gas::<FallingDisks>(&scene, domain, 0.0, 3000, 1.0, 3);
    (state.bodies).retain(|body| filled.clearance(body.position).abs() > 1e-6);
    for body in &mut state.bodies {
        body.velocity *= if inside(body.position) { 10.0 } else { 1.0 };
    }
    let streams = Streams::new(1, 0);
    let mut engine: DsmcEngine<FallingDisks> = DsmcEngine::setup(&scene, PARAMETERS, streams)
        .between(&boundaries)
        .start(&state)
        .expect("an engine");
    engine.advance(1.0, u64::MAX, &mut ());
    assert!(engine.tally().collisions > 1000, "{:?}", engine.tally());
    let energy = |state: &State<FallingDisks>| -> f64 {
        let hot = state.bodies.iter().filter(|body| inside(body.position));
        hot.map(|body| body.velocity.norm_squared()).sum()
    };
    let change = energy(&engine.state()) / energy(&state) - 1.0;
    assert!(change.abs() < 1e-10, "{change}");
}
