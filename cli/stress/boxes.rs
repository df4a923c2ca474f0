//! Boxes of less than three cells, long boxes, and places where cells meet.

use nalgebra::vector;
use rand::RngExt;
use stosszahl_ed::EngineError;
use stosszahl_model::{Body, State};

use super::gas::{Gas, random};
use super::starts::{at_rest, disordered, domain, place_by_trial, state, unit_disks, warm};
use super::{Case, Effort, Findings, Trouble};
use crate::bench::Disks;

pub(super) const CASES: &[Case] = &[
    Case::new(
        "small-boxes",
        "1 to 4 disks in boxes of 1.01 to 3.1 d a side, all combinations that fit, restitution 1 and 0.7",
        "the collisions of all pairs and images, in the same order; one disk alone flies straight on; energy, momentum, exclusion",
        small,
    ),
    Case::new(
        "wedge",
        "a disk that meets another and its periodic image at once, or nearly, in boxes of 1.5 to 1.99 d; restitution 1 and 0.5",
        "contacts only with images that approach; both are met, and left unless it is a collapse; energy, momentum, exclusion",
        wedge,
    ),
    Case::new(
        "long-box",
        "boxes with sides of 1000 : 1 and 1 : 1000, from 1.2 d wide",
        "the collisions of all pairs; energy, momentum, exclusion",
        long,
    ),
    Case::new(
        "borders",
        "disks on borders and corners of cells, at -0, at exactly the box length, moving along axes and diagonals through \
         corners",
        "the collisions of all pairs; energy, momentum, exclusion; the same bits for a place and its image",
        borders,
    ),
];

/// Two gases that start alike and round differently part by e^2 a collision in dense gases and by 60 in the thinnest here;
/// four collisions of each disk leave 1e-15 times 60^4 at most, mostly far less.
const AS_ALL_PAIRS: f64 = 1e-8;

fn small(_: Effort, findings: &mut Findings) -> Result<(), Trouble> {
    const SIDES: [f64; 9] = [1.01, 1.2, 1.5, 1.7, 1.99, 2.0, 2.2, 2.6, 3.1];
    let mut stream = random(2);
    let (mut gases, mut compared) = (0, 0);
    for width in SIDES {
        for height in SIDES {
            for count in 1..=4_usize {
                let scene = unit_disks(if gases % 2 == 0 { 1.0 } else { 0.7 })?;
                let domain = domain(width, height)?;
                let Some(positions) =
                    place_by_trial(&scene.sizes, count, &domain, 300, &mut stream)
                else {
                    continue;
                };
                let mut start: State<Disks> = at_rest(domain, &positions);
                for body in &mut start.bodies {
                    body.velocity = vector![
                        stream.random_range(-1.0..1.0),
                        stream.random_range(-1.0..1.0)
                    ];
                }
                let gas = Gas::new(scene, start);
                let what = format!("{count} in {width} x {height}");
                gases += 1;
                if count == 1 {
                    alone(findings, &what, &gas)?;
                    continue;
                }
                compared += gas.follows_all_pairs(findings, &what, 4 * count / 2, AS_ALL_PAIRS)?;
                let course = gas.run(50.0, 300, 100, |_, _| ())?;
                findings.require(course.stopped.is_none(), || {
                    format!("{what}: {:?}", course.stopped)
                });
                gas.audit(findings, &what, &course);
                gas.survives_kills(findings, &what, 50, 1)?;
            }
        }
    }
    // Of 81 boxes: one disk fits into all, two into most.
    findings.require(gases > 150, || format!("only {gases} gases fitted"));
    findings.found(format!("{gases} gases, {compared} collisions compared"));
    Ok(())
}

/// One disk flies on through its own images.
fn alone(findings: &mut Findings, what: &str, gas: &Gas<Disks>) -> Result<(), Trouble> {
    const TIME: f64 = 100.0;
    let course = gas.run(TIME, 10, 10, |_, _| ())?;
    findings.require(course.reached && course.ledger.collisions == 0, || {
        format!(
            "{what}: {} collisions, {:?}",
            course.ledger.collisions, course.stopped
        )
    });
    let body = gas.start.bodies[0];
    let expected = gas.start.domain.wrap(body.position + body.velocity * TIME);
    let off = gas
        .start
        .domain
        .distance(course.end.state.bodies[0].position, expected);
    // A hundred crossings and a position of 100, each rounded to 1e-14.
    findings.at_most(&format!("{what}: place off"), off, 2e-12);
    Ok(())
}

fn wedge(_: Effort, findings: &mut Findings) -> Result<(), Trouble> {
    let mut contacts = 0;
    for width in [1.5, 1.75, 1.9, 1.99] {
        for restitution in [1.0, 0.5] {
            // Half a box to the side is as far from the disk as from its image.
            for off in [0.0, 1e-15, -1e-15, 1e-9, -1e-3] {
                for place in [0.0, 0.3] {
                    let bodies = [
                        ([place, 2.0], [0.0, 0.0]),
                        ([place + 0.5 * width + off, 3.5], [0.0, -1.0]),
                    ];
                    let gas =
                        Gas::new(unit_disks(restitution)?, state(domain(width, 6.0)?, bodies));
                    let what = format!(
                        "width {width}, {off:e} off the middle, from {place}, r = {restitution}"
                    );
                    let course = gas.run(3.0, 10_000, 10_000, |_, _| ())?;
                    // An inelastic disk that is driven into a narrow wedge may bounce in it for ever.
                    let collapsed = restitution < 1.0
                        && matches!(course.stopped, Some(EngineError::InelasticCollapse { .. }));
                    findings.require(course.reached || collapsed, || {
                        format!(
                            "{what}: {} contacts, {:?}",
                            course.ledger.collisions, course.stopped
                        )
                    });
                    gas.audit(findings, &what, &course);
                    findings.require(course.ledger.collisions >= 2, || {
                        format!("{what}: {} contacts", course.ledger.collisions)
                    });
                    contacts += course.ledger.collisions;
                }
            }
        }
    }
    findings.found(format!("{contacts} contacts"));
    Ok(())
}

fn long(_: Effort, findings: &mut Findings) -> Result<(), Trouble> {
    for (count, aspect) in [(40_usize, 1000.0), (40, 1e-3), (400, 1000.0), (400, 1e-3)] {
        // Narrow enough that 40 disks are a row and 400 a channel.
        let across: f64 = if count == 40 { 1.2 } else { 3.3 };
        let domain = if aspect > 1.0 {
            domain(across, across * aspect)?
        } else {
            domain(across / aspect, across)?
        };
        let scene = unit_disks(1.0)?;
        let mut stream = random(4);
        let positions = place_by_trial(&scene.sizes, count, &domain, 10_000, &mut stream)
            .ok_or(Trouble::NoStart("disks do not fit"))?;
        let mut start: State<Disks> = at_rest(domain, &positions);
        warm(&scene, &mut start, 4);
        let gas = Gas::new(scene, start);
        let what = format!("{count} disks, aspect {aspect}");
        // Positions up to 3300 are rounded to 5e-13; grazing contacts multiply that by up to a thousand.
        let most = if count == 40 { 300 } else { 20 };
        let compared = gas.collides_as_all_pairs(findings, &what, most, 1e-9)?;
        let course = gas.holds(findings, &what, 20_000)?;
        findings.require(course.ledger.collisions == 20_000, || {
            format!("{what}: {} collisions", course.ledger.collisions)
        });
        findings.found(format!("{compared} compared"));
    }
    Ok(())
}

fn borders(_: Effort, findings: &mut Findings) -> Result<(), Trouble> {
    // Whatever the cells are, some of these are theirs: multiples of L/2 ... L/12.
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
        // On the corners of a sparse set of cells, so that none overlap; speeds differ, so that no contacts tie.
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
        let gas = Gas::new(unit_disks(1.0)?, state(domain(side, side)?, bodies));
        let what = format!("corners of {cells} x {cells} cells");
        compared += gas.follows_all_pairs(findings, &what, 2 * places.len(), AS_ALL_PAIRS)?;
        gas.holds(findings, &what, 5000)?;
    }
    // The engine takes the image; the runner of cases wraps before.
    let mut gas = disordered(30, 0.3, 0.9, 3)?;
    let domain = gas.start.domain;
    gas.start
        .bodies
        .retain(|body| domain.distance(body.position, vector![0.0, 0.0]) > 1.0);
    gas.start
        .bodies
        .insert(0, Body::new(vector![0.0, 0.0], vector![0.6, -0.9]));
    let lengths = gas.start.domain.lengths();
    let at = gas;
    let [here, image] = [vector![-0.0, 0.0], lengths].map(|position| {
        let mut other = at.clone();
        other.start.bodies[0] = Body::new(position, other.start.bodies[0].velocity);
        other
    });
    let ends = [&at, &here, &image].map(|gas| {
        gas.run(f64::INFINITY, 1000, 1000, |_, _| ())
            .map(|course| course.end.state.bodies)
    });
    let [at_end, here_end, image_end] = ends;
    let at_end = at_end?;
    findings.require(at_end == here_end?, || {
        "at -0 it goes otherwise than at 0".to_owned()
    });
    findings.require(at_end == image_end?, || {
        "at the box length it goes otherwise than at 0".to_owned()
    });
    findings.found(format!("{compared} collisions compared"));
    Ok(())
}
