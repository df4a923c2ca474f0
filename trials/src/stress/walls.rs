//! Walls, obstacles, gravity and openings, for both engines.

use nalgebra::{Vector2, vector};
use stosszahl_dsmc::{Boundaries, Clearance, Engine as MonteCarlo, Inflow, Parameters, Scheme};
use stosszahl_ed::{Boundaries as ExactBoundaries, Dissipation, Engine as Exact, EngineError};
use stosszahl_model::random::Streams;
use stosszahl_model::walls::{Obstacle, Outline, Vibration};
use stosszahl_model::{
    Constant, Face, Gravity, Plane, Rebound, Scene, Smooth, Species, State, Wall, Walls,
    species::Kind,
};

use crate::gas::{PLAIN, law, state};
use crate::{Done, Findings, Trouble};

trials! {
    "sharp-corner" => sharp_corner,
        "disks and points that fly into the corner of two plates at 1 degree, elastic",
        "none gets through a plate; energy to 1e-10";
    "grain-in-a-wedge" => wedge,
        "a disk that falls into a wedge of 60 degrees and loses half its speed at each touch",
        "Monte Carlo lays it to rest at the bottom; exact dynamics tells of a collapse, or with a contact time ends, lower than it began";
    "floor" => floor,
        "a disk at rest on the floor under gravity, and one that bounces with restitution 0.5",
        "exact dynamics tells of a collapse, or ends with a contact time; Monte Carlo keeps it on the floor";
    "grazing-walls" => grazing,
        "flight along a wall at angles of 1e-6 to 1e-15, towards it and away from it",
        "never outside by more than rounding; energy kept";
    "fast-wall" => fast_wall,
        "a wall that moves 1000 times as fast as the grains, to and fro",
        "no grain behind it; all numbers finite";
    "inside-an-obstacle" => inside,
        "a start that overlaps an obstacle, and one that overlaps a wall",
        "refused, with grain and obstacle or wall named";
    "empty-channel" => empty_channel,
        "an open channel without a grain, and an inflow of density zero",
        "nothing comes, nothing goes, the time is reached";
    "supersonic-inflow" => supersonic,
        "a stream at Mach number 20 through an empty channel",
        "its density and flux in the steady state to 1 % and 4.4 standard errors";
}

type Disks = Scene<Plane, Smooth, Constant, Species, Gravity<Plane>>;

const STREAMS: u64 = 11;

fn streams() -> Streams {
    Streams::new(STREAMS, 0)
}

/// Points in cells: no collisions of grains, so that only boundaries act.
const POINTS: Parameters = Parameters {
    scheme: Scheme::Collisionless,
    cell_size: Some(0.5),
    largest_contact_value: 100.0,
    ..PLAIN
};

/// Disks of diameter 1 and mass 1 between walls and obstacles, for both engines.
struct Setting {
    scene: Disks,
    start: State<Disks>,
    walls: Walls<Plane>,
    obstacles: Vec<Obstacle>,
}

impl Setting {
    /// Bodies (position, velocity) with a restitution under a weight along -y.
    fn new(
        walls: Walls<Plane>,
        size: [f64; 2],
        [restitution, weight]: [f64; 2],
        bodies: Vec<(Vector2<f64>, Vector2<f64>)>,
    ) -> Result<Self, Trouble> {
        let sizes = Species::new(vec![Kind {
            radius: 0.5,
            mass: 1.0,
            count: bodies.len().max(1),
        }]);
        let scene = Scene {
            space: Plane,
            surface: Smooth,
            restitution: law(restitution)?,
            sizes: sizes?,
            field: Gravity::new(vector![0.0, -weight]).unwrap_or_default(),
        };
        let domain = walls.domain(size.into())?;
        Ok(Self {
            scene,
            start: state(domain, bodies),
            walls,
            obstacles: Vec::new(),
        })
    }

    fn around(mut self, obstacle: &Obstacle) -> Self {
        self.obstacles.push(obstacle.clone());
        self
    }

    fn exact(&self, dissipation: Dissipation) -> Result<Exact<Disks>, EngineError> {
        let boundaries = ExactBoundaries {
            walls: self.walls.clone(),
            obstacles: self.obstacles.clone(),
            streams: streams(),
        };
        Exact::between(
            self.scene.clone(),
            dissipation,
            self.start.clone(),
            &boundaries,
        )
    }

    fn boundaries(&self) -> Boundaries<Plane> {
        Boundaries {
            walls: self.walls.clone(),
            clearance: Clearance::Radius,
            obstacles: self.obstacles.clone(),
            ..Boundaries::default()
        }
    }

    fn between(
        &self,
        parameters: Parameters,
        boundaries: &Boundaries<Plane>,
    ) -> Result<MonteCarlo<Disks>, stosszahl_dsmc::EngineError> {
        MonteCarlo::start_between(&self.scene, parameters, &self.start, boundaries, streams())
    }

    fn points(&self) -> Result<MonteCarlo<Disks>, stosszahl_dsmc::EngineError> {
        self.between(POINTS, &self.boundaries())
    }
}

/// Faces of a box, by axis and side.
fn faces(faces: [[Face<Plane>; 2]; 2]) -> Result<Walls<Plane>, Trouble> {
    Walls::new(&faces).map_err(|_| Trouble::NoStart("walls do not fit"))
}

/// A box of walls.
fn walled(wall: Wall<Plane>) -> Result<Walls<Plane>, Trouble> {
    faces([[Face::Wall(wall); 2]; 2])
}

fn obstacle(outline: Outline, law: Rebound) -> Result<Obstacle, Trouble> {
    Obstacle::new(outline, law).map_err(|_| Trouble::NoStart("no obstacle"))
}

/// A law that keeps a share of the normal speed and all of the tangential.
const fn bounce(restitution: f64) -> Rebound {
    Rebound::Restitutive {
        restitution,
        slip: 1.0,
    }
}

fn sharp_corner(log: &mut Findings) -> Done {
    let size = [200.0, 20.0];
    let tip = vector![20.0, 10.0];
    let half = 0.5_f64.to_radians();
    let arm = |sign: f64| tip + vector![half.cos(), sign * half.sin()] * 150.0;
    let points = vec![arm(1.0), tip, arm(-1.0)];
    let plates = obstacle(Outline::Polyline { points }, bounce(1.0))?;
    let setting = |bodies| {
        Ok::<_, Trouble>(
            Setting::new(walled(Wall::specular())?, size, [1.0, 0.0], bodies)?.around(&plates),
        )
    };
    // One disk flies in from the wide end; the plates are as far apart as it is wide at 115 from the tip.
    let mut worst = 0.0_f64;
    for number in 0..20 {
        let angle = f64::from(number - 10) * 0.025;
        let one = setting(vec![(
            vector![180.0, 10.0],
            vector![-angle.cos(), angle.sin()],
        )])?;
        let (mut exact, mut points) = (one.exact(Dissipation::Scene)?, one.points()?);
        exact.advance(250.0, u64::MAX, &mut ())?;
        points.advance(250.0, u64::MAX, &mut ());
        for end in [exact.state(), points.state()] {
            let body = end.bodies[0];
            worst = worst.max((body.velocity.norm() - 1.0).abs());
            log.at_most(
                "disk within a plate",
                0.5 - plates.clearance(body.position),
                1e-8,
            );
        }
    }
    // Points go further in: to where the plates are a millionth apart.
    let points = 500;
    let inside = |index: usize| {
        let far = 20.0 + index as f64 * 0.2;
        let angle = 0.1 * (index as f64).sin();
        (tip + vector![far, 0.0], vector![-angle.cos(), angle.sin()])
    };
    let many = setting((0..points).map(inside).collect())?;
    let mut all = many.boundaries();
    all.clearance = Clearance::Centre;
    let mut engine = many.between(POINTS, &all)?;
    let before = many.start.kinetic_energy(&many.scene);
    for step in 1..=20 {
        engine.advance(f64::from(step), u64::MAX, &mut ());
        for body in engine.state().bodies {
            let from_tip = body.position - tip;
            let off = from_tip[1].abs() - from_tip[0] * half.tan();
            log.at_most("point beyond a plate", off, 1e-7);
        }
    }
    let energy = engine.state().kinetic_energy(&many.scene);
    worst = worst.max((energy / before - 1.0).abs());
    log.at_most("change of speed or energy", worst, 1e-10);
    log.found(format!(
        "20 disks and {points} points, {:.0} touches of the points, energy to {worst:.1e}",
        engine.ledgers().obstacles[0].contacts
    ));
    Ok(())
}

fn wedge(log: &mut Findings) -> Done {
    let slope = 60.0_f64.to_radians();
    let tip = vector![10.0, 2.0];
    let arm = |sign: f64| tip + vector![sign * slope.cos(), slope.sin()] * 12.0;
    let points = vec![arm(-1.0), tip, arm(1.0)];
    let plates = obstacle(Outline::Polyline { points }, bounce(0.5))?;
    let bodies = vec![(vector![10.3, 12.0], vector![0.1, 0.0])];
    let setting = Setting::new(walled(Wall::specular())?, [20.0; 2], [0.5, 1.0], bodies)?;
    let setting = setting.around(&plates);
    // The plates open by 60 degrees, so its centre comes to rest a diameter above the tip.
    let rest = tip + vector![0.0, 0.5 / (0.5 * (180.0_f64 - 120.0)).to_radians().sin()];
    let mut engine = setting.exact(Dissipation::ContactTime(1e-3))?;
    let reached = engine.advance(200.0, 10_000_000, &mut ())?;
    let end = engine.state().bodies[0];
    must!(log, reached; "exact dynamics did not reach the end");
    // It slides along one plate, touching ever again, when it meets the other: with a contact time that costs nothing, so
    // that it goes on rocking.
    let off = (end.position - rest).norm();
    log.at_most(
        "exact: height above the bottom",
        end.position[1] - rest[1],
        1.0,
    );
    log.at_most(
        "exact: depth in a plate",
        0.5 - plates.clearance(end.position),
        1e-8,
    );
    let refused = setting
        .exact(Dissipation::Scene)?
        .advance(200.0, 10_000_000, &mut ());
    let collapse = matches!(
        refused,
        Err(EngineError::WallCollapse { .. } | EngineError::InelasticCollapse { .. })
    );
    must!(log, collapse; "without a contact time: {refused:?}");
    let mut points = setting.points()?;
    points.advance(200.0, u64::MAX, &mut ());
    let far = (points.state().bodies[0].position - rest).norm();
    log.at_most("Monte Carlo: distance from the bottom", far, 1e-2);
    log.found(format!(
        "{off:.1e} and {far:.1e} from the bottom, exact and Monte Carlo; collapse told of without a contact time"
    ));
    Ok(())
}

fn floor(log: &mut Findings) -> Done {
    let walls = walled(Wall::still(bounce(0.5)))?;
    for (what, height) in [("at rest", 0.5), ("dropped", 3.0)] {
        log.about(what);
        let bodies = vec![(vector![5.0, height], Vector2::zeros())];
        let setting = Setting::new(walls.clone(), [10.0; 2], [0.5, 1.0], bodies)?;
        let ended = setting
            .exact(Dissipation::Scene)
            .and_then(|mut engine| engine.advance(1000.0, u64::MAX, &mut ()));
        let collapse = matches!(ended, Err(EngineError::WallCollapse { .. }));
        must!(log, collapse; "without a contact time: {ended:?}");
        let mut engine = setting.exact(Dissipation::ContactTime(1e-4))?;
        let reached = engine.advance(100.0, 10_000_000, &mut ())?;
        must!(log, reached; "the end was not reached");
        let body = engine.state().bodies[0];
        log.at_most("exact: height", (body.position[1] - 0.5).abs(), 1e-6);
        let mut points = setting.points()?;
        points.advance(100.0, u64::MAX, &mut ());
        let body = points.state().bodies[0];
        log.at_most("Monte Carlo: height", (body.position[1] - 0.5).abs(), 1e-9);
        log.at_most("Monte Carlo: speed", body.velocity.norm(), 1e-9);
    }
    log.found("collapse told of; with a contact time, and in Monte Carlo, at rest");
    Ok(())
}

fn grazing(log: &mut Findings) -> Done {
    let walls = walled(Wall::specular())?;
    let mut worst = 0.0_f64;
    for exponent in [-6, -9, -12, -15] {
        for (sign, height) in [
            (-1.0, 0.5),
            (-1.0, 0.5 + 1e-12),
            (1.0, 0.5),
            (1.0, 0.5 + 1e-12),
        ] {
            let velocity = vector![1.0, sign * 10.0_f64.powi(exponent)];
            let bodies = vec![(vector![5.0, height], velocity)];
            let setting = Setting::new(walls.clone(), [10.0; 2], [1.0, 0.0], bodies)?;
            let (mut exact, mut points) = (setting.exact(Dissipation::Scene)?, setting.points()?);
            for time in [10.0, 1000.0] {
                exact.advance(time, u64::MAX, &mut ())?;
                points.advance(time, u64::MAX, &mut ());
                for end in [exact.state(), points.state()] {
                    let body = end.bodies[0];
                    let low = 0.5 - body.position.min();
                    let high = body.position.max() - 9.5;
                    log.at_most("outside", low.max(high), 1e-12);
                    worst = worst.max((body.velocity.norm() / velocity.norm() - 1.0).abs());
                }
            }
        }
    }
    log.at_most("change of speed", worst, 1e-12);
    log.found(format!("speed to {worst:.1e}"));
    Ok(())
}

fn fast_wall(log: &mut Findings) -> Done {
    let mut floor = Wall::<Plane>::still(bounce(0.9));
    // Amplitude 1 in half a period of 1e-3: speed 1000.
    floor.vibration = Some(Vibration::new(1.0, 2e-3)?);
    let top = Wall::still(Rebound::Diffuse { temperature: 1.0 });
    let walls = faces([[Face::Periodic; 2], [Face::Wall(floor), Face::Wall(top)]])?;
    let count = 20;
    let place = |index: usize| {
        let (x, y) = ((index % 5) as f64, (index / 5) as f64);
        (vector![1.0 + 2.0 * x, 2.0 + 2.0 * y], vector![0.1, -1.0])
    };
    let bodies = (0..count).map(place).collect();
    let setting = Setting::new(walls, [10.0; 2], [1.0, 1.0], bodies)?;
    let (mut exact, mut points) = (setting.exact(Dissipation::Scene)?, setting.points()?);
    for step in 1..=50 {
        let time = f64::from(step) * 0.1;
        exact.advance(time, u64::MAX, &mut ())?;
        points.advance(time, u64::MAX, &mut ());
        for end in [exact.state(), points.state()] {
            must!(log, end.bodies.len() == count; "a grain is lost");
            for body in &end.bodies {
                let gap = body.position[1] - 0.5 - floor.displacement(time);
                log.at_most("behind the wall", -gap, 1e-8);
                log.at_most("behind the other wall", body.position[1] - 9.5, 1e-8);
                must!(log, body.velocity.norm().is_finite(); "no number");
            }
        }
    }
    log.found(format!(
        "{:.0} contacts of exact disks, {:.0} of points",
        exact.ledgers()[2].contacts,
        points.ledgers().walls[1][0].contacts
    ));
    Ok(())
}

fn inside(log: &mut Findings) -> Done {
    let (centre, radius) = (vector![10.0, 10.0], 2.0);
    let disc = obstacle(Outline::Disc { centre, radius }, bounce(1.0))?;
    for (third, named) in [
        (vector![12.3, 10.0], "obstacle"),
        (vector![5.0, 0.3], "wall"),
    ] {
        log.about(format!("in the {named}"));
        let places = [vector![3.0, 3.0], vector![3.0, 8.0], third];
        let bodies = places.map(|at| (at, Vector2::zeros())).to_vec();
        let setting = Setting::new(walled(Wall::specular())?, [20.0; 2], [1.0, 0.0], bodies)?;
        let setting = setting.around(&disc);
        let exact = setting.exact(Dissipation::Scene).err();
        let points = setting.points().err();
        for said in [
            exact.map(|error| error.to_string()),
            points.map(|error| error.to_string()),
        ] {
            let said = said.unwrap_or_else(|| "accepted".into());
            let good = said.contains('2') && (said.contains(named) || said.contains("axis 1"));
            must!(log, good; "{said}");
            log.found(said);
        }
    }
    Ok(())
}

fn channel(inflows: Vec<Inflow<Plane>>) -> Result<(Setting, Boundaries<Plane>), Trouble> {
    let walls = faces([[Face::Open; 2], [Face::Wall(Wall::specular()); 2]])?;
    let setting = Setting::new(walls, [20.0, 5.0], [1.0, 0.0], Vec::new())?;
    let boundaries = Boundaries {
        walls: setting.walls.clone(),
        inflows,
        ..Boundaries::default()
    };
    Ok((setting, boundaries))
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

fn empty_channel(log: &mut Findings) -> Done {
    for inflows in [Vec::new(), vec![stream(0.0, 1.0)]] {
        let (setting, all) = channel(inflows)?;
        let mut engine = setting.between(POINTS, &all)?;
        let reached = engine.advance(1000.0, u64::MAX, &mut ());
        let good = reached && engine.time() == 1000.0;
        must!(log, good; "stopped at {}", engine.time());
        must!(log, engine.simulators() == 0; "grains from nothing");
        let (mass, momentum, energy) = engine.ledgers().total();
        log.at_most("ledgers", mass.abs() + momentum.norm() + energy.abs(), 0.0);
    }
    log.found("empty until t = 1000");
    Ok(())
}

fn supersonic(log: &mut Findings) -> Done {
    let [length, width] = [20.0, 5.0];
    // Mach number u sqrt(1/(gamma T)) with gamma = 2 in the plane.
    let (density, speed) = (100.0, 20.0 * 2.0_f64.sqrt());
    let (setting, all) = channel(vec![stream(density, speed)])?;
    // Nobody collides, so that cells may be as wide as the channel.
    let wide = Parameters {
        cell_size: Some(width),
        ..POINTS
    };
    let mut engine = setting.between(wide, &all)?;
    let passage = length / speed;
    engine.advance(3.0 * passage, u64::MAX, &mut ());
    let before = engine.ledgers().inflows[0].particles;
    let mut sum = 0.0;
    let samples = 20;
    for sample in 1..=samples {
        // Two passages apart, so that samples share no grain.
        engine.advance((3.0 + 2.0 * f64::from(sample)) * passage, u64::MAX, &mut ());
        sum += engine.simulators() as f64;
    }
    let expected = density * length * width;
    let found = sum / f64::from(samples);
    let error = (expected / f64::from(samples)).sqrt();
    let came = engine.ledgers().inflows[0].particles - before;
    let due = density * speed * width * 2.0 * f64::from(samples) * passage;
    for (what, found, expected, error) in [
        ("number in the channel", found, expected, error),
        ("flux", came, due, due.sqrt()),
    ] {
        log.about(what);
        log.at_most("in standard errors", (found - expected).abs() / error, 4.4);
        log.at_most("relative", (found / expected - 1.0).abs(), 0.01);
    }
    log.found(format!(
        "{found:.0} grains, {expected:.0} expected (± {error:.0}); flux {:.4} of n u",
        came / due
    ));
    Ok(())
}
