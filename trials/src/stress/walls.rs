//! Hard cases of obstacles and openings, for exact dynamics and Monte Carlo. The tests of the
//! engines have the other hard cases of boundaries: rest on a floor and in a wedge, grazing, fast
//! walls, starts that overlap, empty channels.

use nalgebra::{Vector2, vector};
use stosszahl_dsmc::{BoundaryConditions, CellGas, Inflow, Parameters, Scheme, WallClearance};
use stosszahl_ed::DissipationRule;
use stosszahl_model::random::Streams;
use stosszahl_model::walls::{Obstacle, ObstacleShape};
use stosszahl_model::{
    Budget::Unlimited, Face, Particle, ParticleSpec, Particles, Rebound, Simulation, Volume, Wall,
    Walls,
};

use crate::gas::{PLAIN, law};
use crate::{Done, TrialError, TrialLog};

trials! {
    "sharp-corner" => sharp_corner,
        "disks and points that fly into the corner of two plates at 1 degree, elastic",
        "none gets through a plate; energy to 1e-10";
    "supersonic-inflow" => supersonic,
        "a stream at Mach number 20 through an empty channel",
        "its density and flux in the steady state to 1 % and 4.4 standard errors";
}

/// Monte Carlo parameters without collisions between particles, so that only boundaries act.
const POINTS: Parameters = Parameters {
    scheme: Scheme::Collisionless,
    cell_size: Some(0.5),
    max_contact_value: 100.0,
    ..PLAIN
};

/// Elastic disks of diameter 1 and mass 1 (position, velocity) in a box with walls and obstacles.
struct BoundedDisks<'a> {
    lengths: [f64; 2],
    boundaries: &'a BoundaryConditions<Volume>,
    bodies: &'a [(Vector2<f64>, Vector2<f64>)],
}

impl BoundedDisks<'_> {
    fn grains() -> Result<ParticleSpec, TrialError> {
        Ok(ParticleSpec {
            is_bounded: true,
            ..ParticleSpec::equal(0.5, 1.0, law(1.0)?)
        })
    }

    fn start(&self) -> Particles {
        let body = |&(at, velocity): &(Vector2<f64>, Vector2<f64>)| Particle {
            position: at.push(0.0),
            velocity: velocity.push(0.0),
            ..Particle::at_rest(0.5, 1.0)
        };
        Particles {
            time: 0.0,
            dimension: 2,
            lengths: [self.lengths[0], self.lengths[1], 0.0],
            periodic: [false, false, true],
            all: self.bodies.iter().map(body).collect(),
        }
    }

    /// Creates an event-driven simulation of the disks with walls and obstacles.
    fn exact(&self) -> Result<Box<dyn Simulation>, TrialError> {
        let boundaries = stosszahl_ed::DiskBoundaries {
            walls: self.boundaries.walls.in_plane(),
            obstacles: self.boundaries.obstacles.clone(),
            streams: Streams::new(11, 0),
        };
        let rule = DissipationRule::Scene;
        let made = stosszahl_ed::simulate(&Self::grains()?, rule, &boundaries, &self.start());
        Ok(made?)
    }

    /// Creates a Monte Carlo simulation of the particles in cells with walls and obstacles.
    fn points(&self, parameters: Parameters) -> Result<Box<dyn Simulation>, TrialError> {
        let gas = CellGas {
            grains: &Self::grains()?,
            parameters,
            boundaries: self.boundaries,
            streams: Streams::new(11, 0),
            displacements: false,
        };
        Ok(stosszahl_dsmc::simulate(&gas, &[self.start()])?)
    }
}

/// Returns the number of particle contacts with a named boundary, or passages through a named
/// opening.
fn touches(gas: &dyn Simulation, name: &str) -> f64 {
    let fluxes = gas.boundary_fluxes();
    let found = fluxes.iter().find(|flux| flux.name == name);
    found.map_or(0.0, |flux| flux.particles)
}

fn sharp_corner(log: &mut TrialLog) -> Done {
    let tip = vector![20.0, 10.0];
    let half = 0.5_f64.to_radians();
    let arm = |sign: f64| tip + vector![half.cos(), sign * half.sin()] * 150.0;
    let points = vec![arm(1.0), tip, arm(-1.0)];
    let rebound = Rebound::Restitutive {
        restitution: 1.0,
        slip: 1.0,
    };
    let plates = Obstacle::new(ObstacleShape::Polyline { points }, rebound)?;
    let boundaries = |clearance| -> Result<_, TrialError> {
        Ok(BoundaryConditions {
            walls: Walls::new(&[[Face::Wall(Wall::specular()); 2]; 2])?,
            obstacles: vec![plates.clone()],
            clearance,
            ..BoundaryConditions::default()
        })
    };
    let lengths = [200.0, 20.0];
    // Disk from the wide end; at a distance of 115 from the tip the plates are one diameter apart.
    let mut worst = 0.0_f64;
    for number in 0..20 {
        let angle = f64::from(number - 10) * 0.025;
        let disk = BoundedDisks {
            lengths,
            boundaries: &boundaries(WallClearance::Radius)?,
            bodies: &[(vector![180.0, 10.0], vector![-angle.cos(), angle.sin()])],
        };
        let wide = Parameters {
            cell_size: Some(2.0),
            ..POINTS
        };
        for mut gas in [disk.exact()?, disk.points(wide)?] {
            gas.advance(250.0, Unlimited, &mut ())?;
            let end = gas.particles().all[0];
            worst = worst.max((end.velocity.norm() - 1.0).abs());
            let depth = 0.5 - plates.clearance(end.position.xy());
            log.at_most("disk within a plate", depth, 1e-8);
        }
    }
    // Points reach further in, to where the plates are a millionth apart.
    let points = 500;
    let inside = |index: usize| {
        let far = 20.0 + index as f64 * 0.2;
        let angle = 0.1 * (index as f64).sin();
        (tip + vector![far, 0.0], vector![-angle.cos(), angle.sin()])
    };
    let many = BoundedDisks {
        lengths,
        boundaries: &boundaries(WallClearance::Centre)?,
        bodies: &(0..points).map(inside).collect::<Vec<_>>(),
    };
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

fn supersonic(log: &mut TrialLog) -> Done {
    let [length, width] = [20.0, 5.0];
    // Mach number u sqrt(1/(gamma T)) with gamma = 2 in the plane.
    let (density, speed) = (100.0, 20.0 * 2.0_f64.sqrt());
    let boundaries = BoundaryConditions {
        walls: Walls::new(&[[Face::Open; 2], [Face::Wall(Wall::specular()); 2]])?,
        inflows: vec![Inflow {
            axis: 0,
            side: 0,
            density,
            velocity: vector![speed, 0.0, 0.0],
            temperature: 1.0,
            spin_temperature: 1.0,
            like: 0,
        }],
        ..BoundaryConditions::default()
    };
    let channel = BoundedDisks {
        lengths: [length, width],
        boundaries: &boundaries,
        bodies: &[],
    };
    // Collisionless particles, so that cells may be as wide as the channel.
    let mut gas = channel.points(Parameters {
        cell_size: Some(width),
        ..POINTS
    })?;
    let passage = length / speed;
    gas.advance(3.0 * passage, Unlimited, &mut ())?;
    let before = touches(&*gas, "inflow 1");
    let (samples, mut sum) = (20, 0.0);
    for sample in 1..=samples {
        // Two passages between samples, so that they share no particle.
        let until = (3.0 + 2.0 * f64::from(sample)) * passage;
        gas.advance(until, Unlimited, &mut ())?;
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
