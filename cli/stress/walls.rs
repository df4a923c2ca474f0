//! Walls, obstacles, gravity and openings, for both engines.

use nalgebra::{Vector2, vector};
use stosszahl_dsmc::{
    Boundaries, Clearance, Copies, Displacement, Engine as MonteCarlo, Inflow, Parameters, Scheme,
};
use stosszahl_ed::{Boundaries as ExactBoundaries, Dissipation, Engine as Exact, EngineError};
use stosszahl_model::random::Streams;
use stosszahl_model::walls::{Obstacle, Outline, Vibration};
use stosszahl_model::{
    Body, Constant, Face, Gravity, Plane, Rebound, Scene, Smooth, Species, State, Wall, Walls,
    species::Kind,
};

use super::{Case, Effort, Findings, Trouble};

pub(super) const CASES: &[Case] = &[
    Case::new(
        "sharp-corner",
        "disks and points that fly into the corner of two plates at 1 degree, elastic",
        "none gets through a plate; energy to 1e-10",
        sharp_corner,
    ),
    Case::new(
        "grain-in-a-wedge",
        "a disk that falls into a wedge of 60 degrees and loses half its speed at each touch",
        "Monte Carlo lays it to rest at the bottom; exact dynamics tells of a collapse, or with a contact time ends, lower than it began",
        wedge,
    ),
    Case::new(
        "floor",
        "a disk at rest on the floor under gravity, and one that bounces with restitution 0.5",
        "exact dynamics tells of a collapse, or ends with a contact time; Monte Carlo keeps it on the floor",
        floor,
    ),
    Case::new(
        "grazing-walls",
        "flight along a wall at angles of 1e-6 to 1e-15, towards it and away from it",
        "never outside by more than rounding; energy kept",
        grazing,
    ),
    Case::new(
        "fast-wall",
        "a wall that moves 1000 times as fast as the grains, to and fro",
        "no grain behind it; all numbers finite",
        fast_wall,
    ),
    Case::new(
        "inside-an-obstacle",
        "a start that overlaps an obstacle, and one that overlaps a wall",
        "refused, with grain and obstacle or wall named",
        inside,
    ),
    Case::new(
        "empty-channel",
        "an open channel without a grain, and an inflow of density zero",
        "nothing comes, nothing goes, the time is reached",
        empty_channel,
    ),
    Case::new(
        "supersonic-inflow",
        "a stream at Mach number 20 through an empty channel",
        "its density and flux in the steady state to 1 % and 4.4 standard errors",
        supersonic,
    ),
];

type Disks = Scene<Plane, Smooth, Constant, Species, Gravity<Plane>>;

/// Disks of diameter 1 and mass 1.
fn disks(count: usize, restitution: f64, gravity: Vector2<f64>) -> Result<Disks, Trouble> {
    let sizes = Species::new(vec![Kind {
        radius: 0.5,
        mass: 1.0,
        count,
    }]);
    Ok(Scene {
        space: Plane,
        surface: Smooth,
        restitution: Constant::new(restitution).unwrap_or(Constant::ELASTIC),
        sizes: sizes.ok_or(Trouble::NoStart("no sizes"))?,
        field: Gravity::new(gravity).unwrap_or_default(),
    })
}

const STREAMS: u64 = 11;

fn streams() -> Streams {
    Streams::new(STREAMS, 0)
}

/// Points in cells: no collisions of grains, so that only boundaries act.
const POINTS: Parameters = Parameters {
    scheme: Scheme::Collisionless,
    displacement: Displacement::None,
    cell_size: Some(0.5),
    simulators_per_disk: 1,
    copies: Copies::Independent,
    steps_per_crossing: 4.0,
    largest_contact_value: 100.0,
};

/// A box of walls.
fn walled(wall: Wall<Plane>) -> Result<Walls<Plane>, Trouble> {
    Walls::new(&[[Face::Wall(wall); 2]; 2]).map_err(|_| Trouble::NoStart("walls do not fit"))
}

fn state(
    walls: &Walls<Plane>,
    size: Vector2<f64>,
    bodies: Vec<(Vector2<f64>, Vector2<f64>)>,
) -> Result<State<Disks>, Trouble> {
    Ok(State {
        time: 0.0,
        domain: walls.domain(size).ok_or(Trouble::NoStart("no box"))?,
        bodies: bodies
            .into_iter()
            .map(|(position, velocity)| Body::new(position, velocity))
            .collect(),
    })
}

fn exact(
    scene: &Disks,
    dissipation: Dissipation,
    start: State<Disks>,
    walls: &Walls<Plane>,
    obstacles: &[Obstacle],
) -> Result<Exact<Disks>, EngineError> {
    let boundaries = ExactBoundaries {
        walls: walls.clone(),
        obstacles: obstacles.to_vec(),
        streams: streams(),
    };
    Exact::between(scene.clone(), dissipation, start, &boundaries)
}

fn monte_carlo(
    scene: &Disks,
    start: &State<Disks>,
    boundaries: &Boundaries<Plane>,
) -> Result<MonteCarlo<Disks>, stosszahl_dsmc::EngineError> {
    MonteCarlo::start_between(scene, POINTS, start, boundaries, streams())
}

fn boundaries(walls: &Walls<Plane>, obstacles: &[Obstacle]) -> Boundaries<Plane> {
    Boundaries {
        walls: walls.clone(),
        clearance: Clearance::Radius,
        obstacles: obstacles.to_vec(),
        ..Boundaries::default()
    }
}

fn plates(points: Vec<Vector2<f64>>, rebound: Rebound) -> Result<Obstacle, Trouble> {
    Obstacle::new(Outline::Polyline { points }, rebound)
        .map_err(|_| Trouble::NoStart("no obstacle"))
}

const MIRROR: Rebound = Rebound::Restitutive {
    restitution: 1.0,
    slip: 1.0,
};

fn sharp_corner(_: Effort, findings: &mut Findings) -> Result<(), Trouble> {
    let walls = walled(Wall::specular())?;
    let size = vector![200.0, 20.0];
    let tip = vector![20.0, 10.0];
    let half = 0.5_f64.to_radians();
    let length = 150.0;
    let arm = |sign: f64| tip + vector![half.cos(), sign * half.sin()] * length;
    let obstacle = plates(vec![arm(1.0), tip, arm(-1.0)], MIRROR)?;
    // One disk flies in from the wide end; the plates are as far apart as it is wide at 115 from the tip.
    let scene = disks(1, 1.0, Vector2::zeros())?;
    let mut worst = 0.0_f64;
    for number in 0..20 {
        let angle = f64::from(number - 10) * 0.025;
        let bodies = vec![(vector![180.0, 10.0], vector![-angle.cos(), angle.sin()])];
        let begin = state(&walls, size, bodies)?;
        let mut engine = exact(
            &scene,
            Dissipation::Scene,
            begin.clone(),
            &walls,
            std::slice::from_ref(&obstacle),
        )?;
        let mut engine_dsmc = monte_carlo(
            &scene,
            &begin,
            &boundaries(&walls, std::slice::from_ref(&obstacle)),
        )?;
        engine.advance(250.0, u64::MAX, &mut ())?;
        engine_dsmc.advance(250.0, u64::MAX, &mut ());
        for end in [engine.state(), engine_dsmc.state()] {
            let body = end.bodies[0];
            worst = worst.max((body.velocity.norm() - 1.0).abs());
            let depth = 0.5 - obstacle.clearance(body.position);
            findings.at_most("disk within a plate", depth, 1e-8);
        }
    }
    // Points go further in: to where the plates are a millionth apart.
    let points = 500;
    let scene = disks(points, 1.0, Vector2::zeros())?;
    let inside = |index: usize| {
        let far = 20.0 + index as f64 * 0.2;
        let angle = 0.1 * (index as f64).sin();
        (tip + vector![far, 0.0], vector![-angle.cos(), angle.sin()])
    };
    let begin = state(&walls, size, (0..points).map(inside).collect())?;
    let mut all = boundaries(&walls, std::slice::from_ref(&obstacle));
    all.clearance = Clearance::Centre;
    let mut engine = monte_carlo(&scene, &begin, &all)?;
    let before = begin.kinetic_energy(&scene);
    for step in 1..=20 {
        engine.advance(f64::from(step), u64::MAX, &mut ());
        for body in engine.state().bodies {
            let from_tip = body.position - tip;
            let off = from_tip[1].abs() - from_tip[0] * half.tan();
            findings.at_most("point beyond a plate", off, 1e-7);
        }
    }
    let energy = engine.state().kinetic_energy(&scene);
    worst = worst.max((energy / before - 1.0).abs());
    findings.at_most("change of speed or energy", worst, 1e-10);
    findings.found(format!(
        "20 disks and {points} points, {:.0} touches of the points, energy to {worst:.1e}",
        engine.books().obstacles[0].contacts
    ));
    Ok(())
}

fn wedge(_: Effort, findings: &mut Findings) -> Result<(), Trouble> {
    let walls = walled(Wall::specular())?;
    let size = vector![20.0, 20.0];
    let law = Rebound::Restitutive {
        restitution: 0.5,
        slip: 1.0,
    };
    let slope = 60.0_f64.to_radians();
    let tip = vector![10.0, 2.0];
    let arm = |sign: f64| tip + vector![sign * slope.cos(), slope.sin()] * 12.0;
    let obstacle = plates(vec![arm(-1.0), tip, arm(1.0)], law)?;
    let scene = disks(1, 0.5, vector![0.0, -1.0])?;
    let begin = state(&walls, size, vec![(vector![10.3, 12.0], vector![0.1, 0.0])])?;
    // The plates open by 60 degrees, so its centre comes to rest a diameter above the tip.
    let rest = tip + vector![0.0, 0.5 / (0.5 * (180.0_f64 - 120.0)).to_radians().sin()];
    let all = std::slice::from_ref(&obstacle);
    let contact_time = Dissipation::ContactTime(1e-3);
    let mut engine = exact(&scene, contact_time, begin.clone(), &walls, all)?;
    let reached = engine.advance(200.0, 10_000_000, &mut ())?;
    let end = engine.state().bodies[0];
    findings.require(reached, || "exact dynamics did not reach the end".into());
    // It slides along one plate, touching ever again, when it meets the other: with a contact time that costs nothing, so
    // that it goes on rocking.
    let off = (end.position - rest).norm();
    findings.at_most(
        "exact: height above the bottom",
        end.position[1] - rest[1],
        1.0,
    );
    let within = 0.5 - obstacle.clearance(end.position);
    findings.at_most("exact: depth in a plate", within, 1e-8);
    let refused = exact(&scene, Dissipation::Scene, begin.clone(), &walls, all)?.advance(
        200.0,
        10_000_000,
        &mut (),
    );
    findings.require(
        matches!(
            refused,
            Err(EngineError::WallCollapse { .. } | EngineError::InelasticCollapse { .. })
        ),
        || format!("without a contact time: {refused:?}"),
    );
    let mut points = monte_carlo(&scene, &begin, &boundaries(&walls, all))?;
    points.advance(200.0, u64::MAX, &mut ());
    let last = points.state().bodies[0];
    let far = (last.position - rest).norm();
    findings.at_most("Monte Carlo: distance from the bottom", far, 1e-2);
    findings.found(format!(
        "{off:.1e} and {far:.1e} from the bottom, exact and Monte Carlo; collapse told of without a contact time"
    ));
    Ok(())
}

fn floor(_: Effort, findings: &mut Findings) -> Result<(), Trouble> {
    let half = Wall::still(Rebound::Restitutive {
        restitution: 0.5,
        slip: 1.0,
    });
    let walls = walled(half)?;
    let size = vector![10.0, 10.0];
    let scene = disks(1, 0.5, vector![0.0, -1.0])?;
    for (what, height) in [("at rest", 0.5), ("dropped", 3.0)] {
        let begin = state(&walls, size, vec![(vector![5.0, height], Vector2::zeros())])?;
        let told = exact(&scene, Dissipation::Scene, begin.clone(), &walls, &[])
            .and_then(|mut engine| engine.advance(1000.0, u64::MAX, &mut ()).map(|_| ()));
        findings.require(
            matches!(told, Err(EngineError::WallCollapse { .. })),
            || format!("{what}, without a contact time: {told:?}"),
        );
        let dissipation = Dissipation::ContactTime(1e-4);
        let mut engine = exact(&scene, dissipation, begin.clone(), &walls, &[])?;
        let reached = engine.advance(100.0, 10_000_000, &mut ())?;
        let body = engine.state().bodies[0];
        findings.require(reached, || format!("{what}: the end was not reached"));
        findings.at_most("exact: height", (body.position[1] - 0.5).abs(), 1e-6);
        let mut engine = monte_carlo(&scene, &begin, &boundaries(&walls, &[]))?;
        engine.advance(100.0, u64::MAX, &mut ());
        let body = engine.state().bodies[0];
        findings.at_most("Monte Carlo: height", (body.position[1] - 0.5).abs(), 1e-9);
        findings.at_most("Monte Carlo: speed", body.velocity.norm(), 1e-9);
    }
    findings.found("collapse told of; with a contact time, and in Monte Carlo, at rest");
    Ok(())
}

fn grazing(_: Effort, findings: &mut Findings) -> Result<(), Trouble> {
    let walls = walled(Wall::specular())?;
    let size = vector![10.0, 10.0];
    let scene = disks(1, 1.0, Vector2::zeros())?;
    let mut worst = 0.0_f64;
    for exponent in [-6, -9, -12, -15] {
        for sign in [-1.0, 1.0] {
            for height in [0.5, 0.5 + 1e-12] {
                let velocity = vector![1.0, sign * 10.0_f64.powi(exponent)];
                let begin = state(&walls, size, vec![(vector![5.0, height], velocity)])?;
                let speed = velocity.norm();
                let mut engine = exact(&scene, Dissipation::Scene, begin.clone(), &walls, &[])?;
                let mut points = monte_carlo(&scene, &begin, &boundaries(&walls, &[]))?;
                for time in [10.0, 1000.0] {
                    engine.advance(time, u64::MAX, &mut ())?;
                    points.advance(time, u64::MAX, &mut ());
                    for end in [engine.state(), points.state()] {
                        let body = end.bodies[0];
                        let low = 0.5 - body.position.min();
                        let high = body.position.max() - 9.5;
                        findings.at_most("outside", low.max(high), 1e-12);
                        worst = worst.max((body.velocity.norm() / speed - 1.0).abs());
                    }
                }
            }
        }
    }
    findings.at_most("change of speed", worst, 1e-12);
    findings.found(format!("speed to {worst:.1e}"));
    Ok(())
}

fn fast_wall(_: Effort, findings: &mut Findings) -> Result<(), Trouble> {
    let mut floor = Wall::<Plane>::still(Rebound::Restitutive {
        restitution: 0.9,
        slip: 1.0,
    });
    // Amplitude 1 in half a period of 1e-3: speed 1000.
    floor.vibration = Vibration::new(1.0, 2e-3);
    let top = Wall::still(Rebound::Diffuse { temperature: 1.0 });
    let walls = Walls::new(&[[Face::Periodic; 2], [Face::Wall(floor), Face::Wall(top)]])
        .map_err(|_| Trouble::NoStart("walls do not fit"))?;
    let size = vector![10.0, 10.0];
    let count = 20;
    let scene = disks(count, 1.0, vector![0.0, -1.0])?;
    let place = |index: usize| {
        let (x, y) = ((index % 5) as f64, (index / 5) as f64);
        (vector![1.0 + 2.0 * x, 2.0 + 2.0 * y], vector![0.1, -1.0])
    };
    let begin = state(&walls, size, (0..count).map(place).collect())?;
    let mut engine = exact(&scene, Dissipation::Scene, begin.clone(), &walls, &[])?;
    let mut points = monte_carlo(&scene, &begin, &boundaries(&walls, &[]))?;
    for step in 1..=50 {
        let time = f64::from(step) * 0.1;
        engine.advance(time, u64::MAX, &mut ())?;
        points.advance(time, u64::MAX, &mut ());
        for end in [engine.state(), points.state()] {
            findings.require(end.bodies.len() == count, || "a grain is lost".into());
            for body in &end.bodies {
                let gap = body.position[1] - 0.5 - floor.displacement(time);
                findings.at_most("behind the wall", -gap, 1e-8);
                findings.at_most("behind the other wall", body.position[1] - 9.5, 1e-8);
                findings.require(body.velocity.norm().is_finite(), || "no number".into());
            }
        }
    }
    findings.found(format!(
        "{:.0} contacts of exact disks, {:.0} of points",
        engine.books()[2].contacts,
        points.books().walls[1][0].contacts
    ));
    Ok(())
}

fn inside(_: Effort, findings: &mut Findings) -> Result<(), Trouble> {
    let walls = walled(Wall::specular())?;
    let size = vector![20.0, 20.0];
    let scene = disks(3, 1.0, Vector2::zeros())?;
    let disc = Obstacle::new(
        Outline::Disc {
            centre: vector![10.0, 10.0],
            radius: 2.0,
        },
        MIRROR,
    )
    .map_err(|_| Trouble::NoStart("no obstacle"))?;
    let still = Vector2::zeros();
    for (third, named) in [
        (vector![12.3, 10.0], "obstacle"),
        (vector![5.0, 0.3], "wall"),
    ] {
        let places = [vector![3.0, 3.0], vector![3.0, 8.0], third];
        let begin = state(&walls, size, places.map(|at| (at, still)).to_vec())?;
        let all = std::slice::from_ref(&disc);
        let said = [
            exact(&scene, Dissipation::Scene, begin.clone(), &walls, all)
                .err()
                .map(|error| error.to_string()),
            monte_carlo(&scene, &begin, &boundaries(&walls, all))
                .err()
                .map(|error| error.to_string()),
        ];
        for text in said {
            let text = text.unwrap_or_else(|| "accepted".into());
            let good = text.contains('2') && (text.contains(named) || text.contains("axis 1"));
            findings.require(good, || format!("in the {named}: {text}"));
            findings.found(text);
        }
    }
    Ok(())
}

fn open_channel() -> Result<Walls<Plane>, Trouble> {
    Walls::new(&[[Face::Open; 2], [Face::Wall(Wall::specular()); 2]])
        .map_err(|_| Trouble::NoStart("walls do not fit"))
}

fn stream(density: f64, speed: f64) -> Inflow<Plane> {
    Inflow {
        axis: 0,
        side: 0,
        density,
        velocity: vector![speed, 0.0],
        temperature: 1.0,
        spin_temperature: 1.0,
        like: 0,
    }
}

fn empty_channel(_: Effort, findings: &mut Findings) -> Result<(), Trouble> {
    let walls = open_channel()?;
    let size = vector![20.0, 5.0];
    let scene = disks(1, 1.0, Vector2::zeros())?;
    for inflows in [Vec::new(), vec![stream(0.0, 1.0)]] {
        let begin = state(&walls, size, Vec::new())?;
        let all = Boundaries {
            walls: walls.clone(),
            inflows,
            ..Boundaries::default()
        };
        let mut engine = monte_carlo(&scene, &begin, &all)?;
        let reached = engine.advance(1000.0, u64::MAX, &mut ());
        findings.require(reached && engine.time() == 1000.0, || {
            format!("stopped at {}", engine.time())
        });
        findings.require(engine.simulators() == 0, || "grains from nothing".into());
        let (mass, momentum, energy) = engine.books().total();
        let books = mass.abs() + momentum.norm() + energy.abs();
        findings.at_most("books", books, 0.0);
    }
    findings.found("empty until t = 1000");
    Ok(())
}

fn supersonic(_: Effort, findings: &mut Findings) -> Result<(), Trouble> {
    let walls = open_channel()?;
    let size = vector![20.0, 5.0];
    let scene = disks(1, 1.0, Vector2::zeros())?;
    // Mach number u sqrt(1/(gamma T)) with gamma = 2 in the plane.
    let (density, speed) = (100.0, 20.0 * 2.0_f64.sqrt());
    let all = Boundaries {
        walls: walls.clone(),
        inflows: vec![stream(density, speed)],
        ..Boundaries::default()
    };
    let begin = state(&walls, size, Vec::new())?;
    // Nobody collides, so that cells may be as wide as the channel.
    let wide = Parameters {
        cell_size: Some(size[1]),
        ..POINTS
    };
    let mut engine: MonteCarlo<Disks> =
        MonteCarlo::start_between(&scene, wide, &begin, &all, streams())?;
    let passage = size[0] / speed;
    engine.advance(3.0 * passage, u64::MAX, &mut ());
    let before = engine.books().inflows[0].particles;
    let mut sum = 0.0;
    let samples = 20;
    for sample in 1..=samples {
        // Two passages apart, so that samples share no grain.
        let time = (3.0 + 2.0 * f64::from(sample)) * passage;
        engine.advance(time, u64::MAX, &mut ());
        sum += engine.simulators() as f64;
    }
    let expected = density * size[0] * size[1];
    let found = sum / f64::from(samples);
    let error = (expected / f64::from(samples)).sqrt();
    findings.at_most(
        "number in the channel, in standard errors",
        (found - expected).abs() / error,
        4.4,
    );
    findings.at_most(
        "number in the channel, relative",
        (found / expected - 1.0).abs(),
        0.01,
    );
    let came = engine.books().inflows[0].particles - before;
    let due = density * speed * size[1] * 2.0 * f64::from(samples) * passage;
    let flux_error = due.sqrt();
    findings.at_most(
        "flux, in standard errors",
        (came - due).abs() / flux_error,
        4.4,
    );
    findings.at_most("flux, relative", (came / due - 1.0).abs(), 0.01);
    findings.found(format!(
        "{found:.0} grains, {expected:.0} expected (± {error:.0}); flux {:.4} of n u",
        came / due
    ));
    Ok(())
}
