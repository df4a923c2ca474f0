//! Hard cases of exact disks in boxes of less than three cells, in long boxes and at cell corners,
//! and of disks of very different size.

use std::f64::consts::{FRAC_PI_4, PI};

use nalgebra::{Vector2, vector};
use rand::RngExt;
use stosszahl_model::samples::{EqualDisks, SmoothParticles, maxwellian, state};
use stosszahl_model::{Domain, ParticleState, Plane, Sizes};

use super::gas::{RunEnd, StressGas, disordered, few};
use crate::gas::{disks, domain, mixture, random, random_places};
use crate::{Done, TrialError, TrialLog};

trials! {
    "small-boxes" => small,
        "1 to 4 disks in boxes of 1.01 to 3.1 d a side, all combinations that fit, restitution 1 and 0.7",
        "the collisions of all pairs and images, in the same order; one disk alone flies straight on; energy, momentum, exclusion";
    "wedge" => wedge,
        "a disk that meets another and its periodic image at once, or nearly, in boxes of 1.5 to 1.99 d; restitution 1 and 0.5",
        "contacts only with images that approach; both are met, and left unless it is a collapse; energy, momentum, exclusion";
    "long-box" => long,
        "boxes with sides of 1000 : 1 and 1 : 1000, from 1.2 d wide",
        "the collisions of all pairs; energy, momentum, exclusion";
    "borders" => borders,
        "disks on borders and corners of cells, at -0, at exactly the box length, moving along axes and diagonals through \
         corners",
        "the collisions of all pairs; energy, momentum, exclusion; the same bits for a place and its image";
    "ratios" => ratios,
        "size ratio 100 : 1 together with mass ratios 1e6 : 1 and 1 : 1e6, 3 large among 300 small",
        "the collisions of all pairs; energy to 1e-11, momentum, exclusion";
    "one-huge" => one_huge,
        "one disk of 100 d among small ones: 20 000 with 1e5 collisions, 1e5 with 1e6 long",
        "energy to 1e-11, momentum, exclusion";
}

/// Relative tolerance of collision times against a search over all pairs.
///
/// Two gases that start alike but round differently diverge by a factor e^2 per collision in dense
/// gases, and by 60 in the most dilute one here. Four collisions of each disk leave 1e-15 times
/// 60^4 at most, mostly far less.
const AS_ALL_PAIRS: f64 = 1e-8;

fn small(log: &mut TrialLog) -> Done {
    const SIDES: [f64; 9] = [1.01, 1.2, 1.5, 1.7, 1.99, 2.0, 2.2, 2.6, 3.1];
    let mut stream = random(2);
    let (mut gases, mut compared) = (0, 0);
    let boxes = SIDES
        .into_iter()
        .flat_map(|width| SIDES.map(|height| [width, height]));
    for (seed, [width, height]) in (0..).zip(boxes) {
        for count in 1..=4_usize {
            let scene = disks(if gases % 2 == 0 { 1.0 } else { 0.7 })?;
            let domain = domain(width, height)?;
            // Several disks hardly find their places at random in a denser box.
            let packing = count as f64 * FRAC_PI_4 / (width * height);
            if count > 1 && packing > 0.8 {
                continue;
            }
            let Ok(places) = random_places(&scene.sizes, count, &domain, seed) else {
                continue;
            };
            let mut part = || stream.random_range(-1.0..1.0);
            let bodies = places.into_iter().map(|at| (at, vector![part(), part()]));
            let gas = StressGas::new(scene, state(domain, bodies));
            about!(log; "{count} in {width} x {height}");
            gases += 1;
            if count == 1 {
                alone(log, &gas)?;
                continue;
            }
            compared += gas.follows_all_pairs(log, 4 * count / 2, AS_ALL_PAIRS)?;
            gas.check(log, 50.0, 300, RunEnd::TimeOrCount, 50)?;
        }
    }
    // Of 81 boxes, all hold one disk and most hold two.
    must!(log, gases > 150; "only {gases} gases fitted");
    found!(log; "{gases} gases, {compared} collisions compared");
    Ok(())
}

/// Tests one disk in a periodic box that flies through the positions of its own images.
fn alone(log: &mut TrialLog, gas: &StressGas<EqualDisks>) -> Done {
    const TIME: f64 = 100.0;
    let course = gas.run_until(TIME, 10)?;
    must!(log, course.reached && course.collisions() == 0; "{}", course.ended());
    let body = gas.start.bodies[0];
    let domain = gas.start.domain;
    let expected = domain.wrap(body.position + body.velocity * TIME);
    let off = domain.distance(course.end.state.bodies[0].position, expected);
    // A hundred crossings and a position of 100, each rounded to 1e-14.
    log.at_most("place off", off, 2e-12);
    Ok(())
}

fn wedge(log: &mut TrialLog) -> Done {
    let mut contacts = 0;
    for width in [1.5, 1.75, 1.9, 1.99] {
        for restitution in [1.0, 0.5] {
            // Beside the point half a box away, which is as far from the disk as from its image.
            for off in [0.0, 1e-15, -1e-15, 1e-9, -1e-3] {
                for place in [0.0, 0.3] {
                    let other = [place + 0.5 * width + off, 3.5];
                    let bodies = [([place, 2.0], [0.0, 0.0]), (other, [0.0, -1.0])];
                    let gas = few(restitution, [width, 6.0], bodies)?;
                    about!(log; "width {width}, {off:e} off the middle, from {place}, r = {restitution}");
                    let course = gas.run_until(3.0, 10_000)?;
                    // Exemption of an inelastic disk that is driven into a narrow wedge, where it
                    // may bounce for ever.
                    let collapsed = restitution < 1.0 && course.collapsed();
                    must!(log, course.reached || collapsed; "{}", course.ended());
                    gas.audit(log, &course);
                    must!(log, course.collisions() >= 2; "{}", course.ended());
                    contacts += course.collisions();
                }
            }
        }
    }
    found!(log; "{contacts} contacts");
    Ok(())
}

/// Creates a Maxwellian gas of disks at random positions without overlap.
fn placed_gas<Z: Sizes>(
    scene: SmoothParticles<Plane, Z>,
    domain: Domain<Plane>,
    count: usize,
    seed: u64,
) -> Result<StressGas<SmoothParticles<Plane, Z>>, TrialError> {
    let places = random_places(&scene.sizes, count, &domain, seed)?;
    let start = maxwellian(&scene, domain, places, 1.0, seed);
    Ok(StressGas::new(scene, start))
}

fn long(log: &mut TrialLog) -> Done {
    for (count, aspect) in [(40_usize, 1000.0), (40, 1e-3), (400, 1000.0), (400, 1e-3)] {
        // Narrow enough that 40 disks are a row and 400 a channel.
        let across: f64 = if count == 40 { 1.2 } else { 3.3 };
        let domain = if aspect > 1.0 {
            domain(across, across * aspect)?
        } else {
            domain(across / aspect, across)?
        };
        let scene = disks(1.0)?;
        let gas = placed_gas(scene, domain, count, 4)?;
        about!(log; "{count} disks, aspect {aspect}");
        // Positions up to 3300 are rounded to 5e-13; grazing contacts multiply that by up to a
        // thousand.
        let most = if count == 40 { 300 } else { 20 };
        let compared = gas.collides_as_all_pairs(log, most, 1e-9)?;
        let course = gas.holds(log, 20_000)?;
        must!(log, course.collisions() == 20_000; "{}", course.ended());
        found!(log; "{compared} compared");
    }
    Ok(())
}

fn borders(log: &mut TrialLog) -> Done {
    // Edges of the engine's cells, whatever their number: multiples of L/2 ... L/12.
    let side = 12.0;
    let mut compared = 0;
    for cells in [2_usize, 3, 4, 6, 8, 10, 12] {
        let width = side / cells as f64;
        let velocities: [[f64; 2]; 8] = [
            [1.0, 0.0],
            [-1.0, 0.0],
            [0.0, 1.0],
            [0.0, -1.0],
            [1.0, 1.0],
            [-1.0, 1.0],
            [-1.0, -1.0],
            [-0.0, -0.0],
        ];
        // Corners of a sparse set of cells, so that none overlap; different speeds, so that no
        // contacts tie.
        let step = (2.0 / width).ceil() as usize;
        let places: Vec<[f64; 2]> = (0..cells)
            .step_by(step)
            .flat_map(|x| (0..cells).step_by(step).map(move |y| [x, y]))
            .filter(|&[x, y]| cells - x >= step && cells - y >= step)
            .map(|place| place.map(|n| n as f64 * width))
            .collect();
        let bodies = places.iter().enumerate().map(|(i, &at)| {
            let speed = 1.0 + 0.37 * (i as f64 * 0.618_034).fract();
            (at, velocities[i % 8].map(|v| v * speed))
        });
        let gas = few(1.0, [side; 2], bodies)?;
        about!(log; "corners of {cells} x {cells} cells");
        compared += gas.follows_all_pairs(log, 2 * places.len(), AS_ALL_PAIRS)?;
        gas.holds(log, 5000)?;
    }
    // The engine takes the image; the runner of cases wraps before.
    let mut gas = disordered(30, 0.3, 0.9, 3)?;
    let (domain, origin) = (gas.start.domain, vector![0.0, 0.0]);
    let bodies = &mut gas.start.bodies;
    bodies.retain(|body| domain.distance(body.position, origin) > 1.0);
    bodies.insert(0, ParticleState::new(origin, vector![0.6, -0.9]));
    let end = |at: Vector2<f64>| {
        let mut other = gas.clone();
        other.start.bodies[0].position = at;
        other
            .run_until(f64::INFINITY, 1000)
            .map(|course| course.end.state.bodies)
    };
    let expected = end(origin)?;
    log.about("");
    must!(log, end(vector![-0.0, 0.0])? == expected; "at -0 it goes otherwise than at 0");
    must!(log, end(domain.lengths())? == expected; "at the box length it goes otherwise than at 0");
    found!(log; "{compared} collisions compared");
    Ok(())
}

fn ratios(log: &mut TrialLog) -> Done {
    for mass in [1e6, 1e-6] {
        // Against all pairs, with few disks.
        for (large, small, side) in [(1, 12, 130.0), (3, 300, 280.0)] {
            let mut sizes = vec![(50.0, mass); large];
            sizes.extend(vec![(0.5, 1.0); small]);
            let scene = mixture(sizes, 1.0)?;
            let domain = domain(side, 0.9 * side)?;
            let gas = placed_gas(scene, domain, large + small, 8)?;
            about!(log; "{large} large and {small} small, mass ratio {mass:.0e}");
            if large == 1 {
                // A small disk between large ones is like a mirror between mirrors: differences
                // grow by the flight over its own diameter, up to a hundred; one collision of each.
                gas.follows_all_pairs(log, 6, 1e-8)?;
            }
            gas.holds(log, 20_000)?;
        }
    }
    Ok(())
}

fn one_huge(log: &mut TrialLog) -> Done {
    let (small, collisions) = if log.effort.long {
        (100_000, 1_000_000)
    } else {
        (20_000, 100_000)
    };
    let collisions = log.effort.collisions.unwrap_or(collisions);
    let huge = 50.0;
    // Small disks at packing 0.2 beside the huge one, on a square lattice that the dynamics
    // forgets.
    let spacing = (FRAC_PI_4 / 0.2_f64).sqrt();
    let covered = PI * (huge + 1.0) * (huge + 1.0);
    let columns =
        ((small as f64 * spacing * spacing + 1.1 * covered).sqrt() / spacing).ceil() as usize;
    let side = columns as f64 * spacing;
    let domain = domain(side, side)?;
    let middle = vector![0.5 * side, 0.5 * side];
    let at = |index| {
        vector![
            (index % columns) as f64 * spacing,
            (index / columns) as f64 * spacing
        ]
    };
    let lattice = (0..columns * columns).map(at);
    let free = lattice.filter(|&at| domain.distance(at, middle) > huge + 0.6);
    let places: Vec<_> = std::iter::once(middle).chain(free.take(small)).collect();
    if places.len() != small + 1 {
        return Err(TrialError::refused("small disks do not fit"));
    }
    let mut sizes = vec![(0.5, 1.0); small + 1];
    sizes[0] = (huge, 1e4);
    let scene = mixture(sizes, 1.0)?;
    let start = maxwellian(&scene, domain, places, 1.0, 9);
    log.progress(0.0, &format!("{small} small disks"));
    about!(log; "{small} small disks");
    StressGas::new(scene, start).holds(log, collisions)?;
    Ok(())
}
