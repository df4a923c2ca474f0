//! Walls, obstacles, gravity and openings, for both engines.

use nalgebra::{Vector2, vector};
use stosszahl_dsmc::{BoundaryConditions, CellGas, Inflow, Parameters, Scheme, WallClearance};
use stosszahl_ed::{DissipationRule, EventDrivenError};
use stosszahl_model::random::Streams;
use stosszahl_model::walls::{FACES, Obstacle, ObstacleShape, Vibration};
use stosszahl_model::{
    Budget::{Collisions, Unlimited},
    Face, Failure, Particle, ParticleSpec, Particles, Rebound, Simulation, SizeDistribution,
    Species, Volume, Wall, Walls,
    species::SpeciesProperties,
};

use crate::gas::{PLAIN, law};
use crate::{Done, TrialError, TrialLog};

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

const STREAMS: u64 = 11;

/// Parameters of points in cells: no collisions of particles, so that only boundaries act.
const POINTS: Parameters = Parameters {
    scheme: Scheme::Collisionless,
    cell_size: Some(0.5),
    max_contact_value: 100.0,
    ..PLAIN
};

/// Disks of diameter 1 and mass 1 between walls and obstacles, for both engines.
struct Setting {
    grains: ParticleSpec,
    start: Particles,
    boundaries: BoundaryConditions<Volume>,
}

impl Setting {
    /// Creates particles (position, velocity) with a restitution under a weight along -y.
    fn new(
        walls: Walls<Volume>,
        [width, height]: [f64; 2],
        [restitution, weight]: [f64; 2],
        bodies: &[(Vector2<f64>, Vector2<f64>)],
    ) -> Result<Self, TrialError> {
        let sizes = Species::new(vec![SpeciesProperties {
            radius: 0.5,
            mass: 1.0,
            count: bodies.len().max(1),
        }]);
        let body = |&(at, velocity): &(Vector2<f64>, Vector2<f64>)| Particle {
            position: at.push(0.0),
            velocity: velocity.push(0.0),
            ..Particle::at_rest(0.5, 1.0)
        };
        Ok(Self {
            grains: ParticleSpec {
                sizes: SizeDistribution::Species(sizes?),
                restitution: law(restitution)?,
                rough: None,
                gravity: Some(vector![0.0, -weight, 0.0]),
                shear_rate: None,
                shear_offset: 0.0,
                is_bounded: true,
            },
            start: Particles {
                time: 0.0,
                dimension: 2,
                lengths: [width, height, 0.0],
                periodic: [false, false, true],
                all: bodies.iter().map(body).collect(),
            },
            boundaries: BoundaryConditions {
                walls,
                clearance: WallClearance::Radius,
                ..BoundaryConditions::default()
            },
        })
    }

    fn box_around(mut self, obstacle: &Obstacle) -> Self {
        self.boundaries.obstacles.push(obstacle.clone());
        self
    }

    fn exact(&self, dissipation: DissipationRule) -> Result<Box<dyn Simulation>, EventDrivenError> {
        let boundaries = stosszahl_ed::DiskBoundaries {
            walls: self.boundaries.walls.in_plane(),
            obstacles: self.boundaries.obstacles.clone(),
            streams: Streams::new(STREAMS, 0),
        };
        stosszahl_ed::simulate(&self.grains, dissipation, &boundaries, &self.start)
    }

    fn points(
        &self,
        parameters: Parameters,
    ) -> Result<Box<dyn Simulation>, stosszahl_dsmc::DsmcError> {
        let gas = CellGas {
            grains: &self.grains,
            parameters,
            boundaries: &self.boundaries,
            streams: Streams::new(STREAMS, 0),
            displacements: false,
        };
        stosszahl_dsmc::simulate(&gas, std::slice::from_ref(&self.start))
    }

    /// Creates both engines: exact dynamics, and Monte Carlo of point particles in cells.
    fn both(&self) -> Result<[Box<dyn Simulation>; 2], TrialError> {
        Ok([self.exact(DissipationRule::Scene)?, self.points(POINTS)?])
    }

    /// Runs exact dynamics without a contact time; returns true if the time was reached.
    fn ends(&self, until: f64, budget: stosszahl_model::Budget) -> Result<bool, Failure> {
        let mut gas = self.exact(DissipationRule::Scene).map_err(Failure::new)?;
        gas.advance(until, budget, &mut ())
    }
}

fn error(ended: &Result<bool, Failure>) -> Option<&EventDrivenError> {
    ended.as_ref().err().and_then(Failure::downcast_ref)
}

/// Returns position and speed of the single particle of a gas.
fn only(gas: &dyn Simulation) -> (Vector2<f64>, f64) {
    let body = gas.particles().all[0];
    (body.position.xy(), body.velocity.norm())
}

/// Number of contacts with a boundary, or of particles through an opening, by its name.
fn touches(gas: &dyn Simulation, name: &str) -> f64 {
    let fluxes = gas.boundary_fluxes();
    let found = fluxes.iter().find(|flux| flux.name == name);
    found.map_or(0.0, |flux| flux.particles)
}

/// Creates the faces of a box, by axis and side.
fn faces(faces: &[[Face<Volume>; 2]; 2]) -> Result<Walls<Volume>, TrialError> {
    Ok(Walls::new(faces)?)
}

/// Creates a box of walls.
fn walled(wall: Wall<Volume>) -> Result<Walls<Volume>, TrialError> {
    faces(&[[Face::Wall(wall); 2]; 2])
}

/// Creates a law that keeps a share of the normal speed and all of the tangential one.
const fn bounce(restitution: f64) -> Rebound {
    Rebound::Restitutive {
        restitution,
        slip: 1.0,
    }
}

/// Creates two plates with a common tip, each at an angle to an axis.
fn plates(points: [Vector2<f64>; 3], restitution: f64) -> Result<Obstacle, TrialError> {
    let points = points.to_vec();
    Ok(Obstacle::new(
        ObstacleShape::Polyline { points },
        bounce(restitution),
    )?)
}

fn sharp_corner(log: &mut TrialLog) -> Done {
    let size = [200.0, 20.0];
    let tip = vector![20.0, 10.0];
    let half = 0.5_f64.to_radians();
    let arm = |sign: f64| tip + vector![half.cos(), sign * half.sin()] * 150.0;
    let plates = plates([arm(1.0), tip, arm(-1.0)], 1.0)?;
    let setting = |bodies: &[_]| -> Result<Setting, TrialError> {
        let setting = Setting::new(walled(Wall::specular())?, size, [1.0, 0.0], bodies)?;
        Ok(setting.box_around(&plates))
    };
    // Disk from the wide end; at a distance of 115 from the tip the plates are one diameter apart.
    let mut worst = 0.0_f64;
    for number in 0..20 {
        let angle = f64::from(number - 10) * 0.025;
        let velocity = vector![-angle.cos(), angle.sin()];
        for mut gas in setting(&[(vector![180.0, 10.0], velocity)])?.both()? {
            gas.advance(250.0, Unlimited, &mut ())?;
            let (at, speed) = only(&*gas);
            worst = worst.max((speed - 1.0).abs());
            log.at_most("disk within a plate", 0.5 - plates.clearance(at), 1e-8);
        }
    }
    // Points reach further in, to where the plates are a millionth apart.
    let points = 500;
    let inside = |index: usize| {
        let far = 20.0 + index as f64 * 0.2;
        let angle = 0.1 * (index as f64).sin();
        (tip + vector![far, 0.0], vector![-angle.cos(), angle.sin()])
    };
    let mut many = setting(&(0..points).map(inside).collect::<Vec<_>>())?;
    many.boundaries.clearance = WallClearance::Centre;
    let mut gas = many.points(POINTS)?;
    let before = gas.temperature();
    for step in 1..=20 {
        gas.advance(f64::from(step), Unlimited, &mut ())?;
        for body in gas.particles().all {
            let from_tip = body.position.xy() - tip;
            let off = from_tip[1].abs() - from_tip[0] * half.tan();
            log.at_most("point beyond a plate", off, 1e-7);
        }
    }
    worst = worst.max((gas.temperature() / before - 1.0).abs());
    log.at_most("change of speed or energy", worst, 1e-10);
    let touches = touches(&*gas, "obstacle 1");
    found!(log; "20 disks and {points} points, {touches:.0} touches of the points, energy to {worst:.1e}");
    Ok(())
}

fn wedge(log: &mut TrialLog) -> Done {
    let slope = 60.0_f64.to_radians();
    let tip = vector![10.0, 2.0];
    let arm = |sign: f64| tip + vector![sign * slope.cos(), slope.sin()] * 12.0;
    let plates = plates([arm(-1.0), tip, arm(1.0)], 0.5)?;
    let bodies = [(vector![10.3, 12.0], vector![0.1, 0.0])];
    let setting = Setting::new(walled(Wall::specular())?, [20.0; 2], [0.5, 1.0], &bodies)?;
    let setting = setting.box_around(&plates);
    // The plates open by 60 degrees, so its centre comes to rest a diameter above the tip.
    let rest = tip + vector![0.0, 0.5 / (0.5 * (180.0_f64 - 120.0)).to_radians().sin()];
    let mut gas = setting.exact(DissipationRule::ContactTime(1e-3))?;
    let reached = gas.advance(200.0, Collisions(10_000_000), &mut ())?;
    must!(log, reached; "exact dynamics did not reach the end");
    // Rocking at the bottom: the disk meets one plate while it slides along the other in repeated
    // contacts. With a contact time these cost no energy, so that it never comes to rest.
    let (end, _) = only(&*gas);
    let off = (end - rest).norm();
    log.at_most("exact: height above the bottom", end[1] - rest[1], 1.0);
    log.at_most("exact: depth in a plate", 0.5 - plates.clearance(end), 1e-8);
    let refused = setting.ends(200.0, Collisions(10_000_000));
    let collapse = matches!(
        error(&refused),
        Some(EventDrivenError::WallCollapse { .. } | EventDrivenError::InelasticCollapse { .. })
    );
    must!(log, collapse; "without a contact time: {refused:?}");
    let mut points = setting.points(POINTS)?;
    points.advance(200.0, Unlimited, &mut ())?;
    let far = (only(&*points).0 - rest).norm();
    log.at_most("Monte Carlo: distance from the bottom", far, 1e-2);
    found!(log; "{off:.1e} and {far:.1e} from the bottom, exact and Monte Carlo; collapse reported without a contact time");
    Ok(())
}

fn floor(log: &mut TrialLog) -> Done {
    let walls = walled(Wall::still(bounce(0.5)))?;
    for (what, height) in [("at rest", 0.5), ("dropped", 3.0)] {
        log.about(what);
        let bodies = [(vector![5.0, height], Vector2::zeros())];
        let setting = Setting::new(walls.clone(), [10.0; 2], [0.5, 1.0], &bodies)?;
        let ended = setting.ends(1000.0, Unlimited);
        let collapse = matches!(error(&ended), Some(EventDrivenError::WallCollapse { .. }));
        must!(log, collapse; "without a contact time: {ended:?}");
        let mut gas = setting.exact(DissipationRule::ContactTime(1e-4))?;
        let reached = gas.advance(100.0, Collisions(10_000_000), &mut ())?;
        must!(log, reached; "the end was not reached");
        log.at_most("exact: height", (only(&*gas).0[1] - 0.5).abs(), 1e-6);
        let mut points = setting.points(POINTS)?;
        points.advance(100.0, Unlimited, &mut ())?;
        let (at, speed) = only(&*points);
        log.at_most("Monte Carlo: height", (at[1] - 0.5).abs(), 1e-9);
        log.at_most("Monte Carlo: speed", speed, 1e-9);
    }
    log.found("collapse reported; with a contact time, and in Monte Carlo, at rest");
    Ok(())
}

fn grazing(log: &mut TrialLog) -> Done {
    let walls = walled(Wall::specular())?;
    let mut worst = 0.0_f64;
    for exponent in [-6, -9, -12, -15] {
        for (sign, above) in [(-1.0, 0.0), (-1.0, 1e-12), (1.0, 0.0), (1.0, 1e-12)] {
            let velocity = vector![1.0, sign * 10.0_f64.powi(exponent)];
            let bodies = [(vector![5.0, 0.5 + above], velocity)];
            let setting = Setting::new(walls.clone(), [10.0; 2], [1.0, 0.0], &bodies)?;
            for mut gas in setting.both()? {
                for time in [10.0, 1000.0] {
                    gas.advance(time, Unlimited, &mut ())?;
                    let (at, speed) = only(&*gas);
                    log.at_most("outside", (0.5 - at.min()).max(at.max() - 9.5), 1e-12);
                    worst = worst.max((speed / velocity.norm() - 1.0).abs());
                }
            }
        }
    }
    log.at_most("change of speed", worst, 1e-12);
    found!(log; "speed to {worst:.1e}");
    Ok(())
}

fn fast_wall(log: &mut TrialLog) -> Done {
    let mut floor = Wall::still(bounce(0.9));
    // Amplitude 1 in half a period of 1e-3: speed 1000.
    floor.vibration = Some(Vibration::new(1.0, 2e-3)?);
    let top = Wall::still(Rebound::Diffuse { temperature: 1.0 });
    let walls = faces(&[[Face::Periodic; 2], [Face::Wall(floor), Face::Wall(top)]])?;
    let place = |index: i32| {
        let (x, y) = (f64::from(index % 5), f64::from(index / 5));
        (vector![1.0 + 2.0 * x, 2.0 + 2.0 * y], vector![0.1, -1.0])
    };
    let bodies: Vec<_> = (0..20).map(place).collect();
    let mut both = Setting::new(walls, [10.0; 2], [1.0, 1.0], &bodies)?.both()?;
    for gas in &mut both {
        for step in 1..=50 {
            let time = f64::from(step) * 0.1;
            gas.advance(time, Unlimited, &mut ())?;
            must!(log, gas.particle_count() == bodies.len(); "a grain is lost");
            for body in gas.particles().all {
                let gap = body.position[1] - 0.5 - floor.displacement(time);
                log.at_most("behind the wall", -gap, 1e-8);
                log.at_most("behind the other wall", body.position[1] - 9.5, 1e-8);
                must!(log, body.velocity.norm().is_finite(); "no number");
            }
        }
    }
    let [exact, points] = both.map(|gas| touches(&*gas, FACES[1][0]));
    found!(log; "{exact:.0} contacts of exact disks, {points:.0} of points");
    Ok(())
}

fn inside(log: &mut TrialLog) -> Done {
    let (centre, radius) = (vector![10.0, 10.0], 2.0);
    let disk = Obstacle::new(ObstacleShape::Circle { centre, radius }, bounce(1.0))?;
    for (third, named) in [
        (vector![12.3, 10.0], "obstacle"),
        (vector![5.0, 0.3], "wall"),
    ] {
        about!(log; "in the {named}");
        let places = [vector![3.0, 3.0], vector![3.0, 8.0], third];
        let bodies = places.map(|at| (at, Vector2::zeros()));
        let setting = Setting::new(walled(Wall::specular())?, [20.0; 2], [1.0, 0.0], &bodies)?;
        let setting = setting.box_around(&disk);
        let exact = setting.exact(DissipationRule::Scene).err();
        let points = setting.points(POINTS).err();
        for said in [exact.map(|e| e.to_string()), points.map(|e| e.to_string())] {
            let said = said.unwrap_or_else(|| "accepted".into());
            let good = said.contains('2') && (said.contains(named) || said.contains("axis 1"));
            must!(log, good; "{said}");
            log.found(said);
        }
    }
    Ok(())
}

/// Creates a channel with a stream of a density and speed from the left, if there is one.
fn channel(
    [length, width]: [f64; 2],
    stream: Option<[f64; 2]>,
    parameters: Parameters,
) -> Result<Box<dyn Simulation>, TrialError> {
    let walls = faces(&[[Face::Open; 2], [Face::Wall(Wall::specular()); 2]])?;
    let mut setting = Setting::new(walls, [length, width], [1.0, 0.0], &[])?;
    setting.boundaries.clearance = WallClearance::default();
    let inflow = |[density, speed]: [f64; 2]| Inflow {
        axis: 0,
        side: 0,
        density,
        velocity: vector![speed, 0.0, 0.0],
        temperature: 1.0,
        spin_temperature: 1.0,
        like: 0,
    };
    setting.boundaries.inflows.extend(stream.map(inflow));
    Ok(setting.points(parameters)?)
}

fn empty_channel(log: &mut TrialLog) -> Done {
    for stream in [None, Some([0.0, 1.0])] {
        let mut gas = channel([20.0, 5.0], stream, POINTS)?;
        let reached = gas.advance(1000.0, Unlimited, &mut ())?;
        must!(log, reached && gas.time() == 1000.0; "stopped at {}", gas.time());
        must!(log, gas.particle_count() == 0; "grains from nothing");
        for flux in gas.boundary_fluxes() {
            let momentum: f64 = flux.momentum.iter().map(|part| part.abs()).sum();
            log.at_most(
                "ledgers",
                flux.particles.abs() + momentum + flux.energy.abs(),
                0.0,
            );
        }
    }
    log.found("empty until t = 1000");
    Ok(())
}

fn supersonic(log: &mut TrialLog) -> Done {
    let [length, width] = [20.0, 5.0];
    // Mach number u sqrt(1/(gamma T)) with gamma = 2 in the plane.
    let (density, speed) = (100.0, 20.0 * 2.0_f64.sqrt());
    // Collisionless particles, so that cells may be as wide as the channel.
    let wide = Parameters {
        cell_size: Some(width),
        ..POINTS
    };
    let mut gas = channel([length, width], Some([density, speed]), wide)?;
    let passage = length / speed;
    gas.advance(3.0 * passage, Unlimited, &mut ())?;
    let before = touches(&*gas, "inflow 1");
    let mut sum = 0.0;
    let samples = 20;
    for sample in 1..=samples {
        // Two passages between samples, so that they share no particle.
        gas.advance(
            (3.0 + 2.0 * f64::from(sample)) * passage,
            Unlimited,
            &mut (),
        )?;
        sum += gas.particle_count() as f64;
    }
    let expected = density * length * width;
    let found = sum / f64::from(samples);
    let error = (expected / f64::from(samples)).sqrt();
    let came = touches(&*gas, "inflow 1") - before;
    let due = density * speed * width * 2.0 * f64::from(samples) * passage;
    for (what, found, expected, error) in [
        ("number in the channel", found, expected, error),
        ("flux", came, due, due.sqrt()),
    ] {
        log.about(what);
        log.at_most("in standard errors", (found - expected).abs() / error, 4.4);
        log.at_most("relative", (found / expected - 1.0).abs(), 0.01);
    }
    let flux = came / due;
    found!(log; "{found:.0} grains, {expected:.0} expected (± {error:.0}); flux {flux:.4} of n u");
    Ok(())
}
