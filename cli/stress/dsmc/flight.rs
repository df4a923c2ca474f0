//! Free flight, for long.

use rand::RngExt;
use stosszahl_dsmc::{Engine, Scheme};
use stosszahl_model::random::Streams;
use stosszahl_model::{Body, Polydisperse, Scene, State};

use super::gas::{domain, random, scattered, setups, unit_disks, warm};
use super::{Case, Effort, Findings, Trouble};

pub(super) const CASES: &[Case] = &[Case::new(
    "free-flight",
    "1e5 steps of nothing but free flight, 5 disks in square boxes and in boxes of 1 : 1000 and 1000 : 1, of one, two and many \
     cells; steps of the engine's own and held at 0.37",
    "positions to 1e-11 L of x0 + v t, whose product is exact; velocities the same bits",
    free_flight,
)];

/// How far from x + v t a place is along an axis of a periodic box; the products v t and n L are exact as sums of two numbers.
fn off(from: f64, velocity: f64, time: f64, length: f64, place: f64) -> f64 {
    let way = velocity * time;
    let way_rest = velocity.mul_add(time, -way);
    let rounds = ((from - place + way) / length).round();
    let ring = rounds * length;
    let ring_rest = rounds.mul_add(length, -ring);
    ((way - ring) + (from - place) + (way_rest - ring_rest)).abs()
}

fn free_flight(effort: Effort, findings: &mut Findings) -> Result<(), Trouble> {
    let steps = if effort.long { 10_000_000 } else { 100_000 };
    let mut worst = 0.0_f64;
    let boxes = [
        ([30.0, 30.0], None),
        ([30.0, 30.0], Some(30.0)),
        ([30.0, 30.0], Some(15.0)),
        ([1.0, 1000.0], Some(1000.0)),
        ([1.0, 1000.0], Some(500.0)),
        ([1000.0, 1.0], Some(500.0)),
        ([1000.0, 1.0], Some(20.0)),
    ];
    for (sides, cell_size) in boxes {
        for step in [0.0, 0.37] {
            let mut setup = setups()[0];
            setup.parameters.scheme = Scheme::Collisionless;
            setup.parameters.cell_size = cell_size;
            let mut stream = random(10);
            let places = scattered(5, [0.0; 2], sides, &mut stream);
            let mut start = warm(domain(sides[0], sides[1])?, &places, 10)?;
            start.time = stream.random::<f64>();
            // Equal disks have no identity; with sizes of their own, even equal ones, they keep their order.
            let unit = unit_disks(1.0)?;
            let sizes = Polydisperse::new(vec![(0.5, 1.0); start.bodies.len()]);
            let scene = Scene {
                space: unit.space,
                surface: unit.surface,
                restitution: unit.restitution,
                sizes: sizes.ok_or(Trouble::NoStart("sizes that are not positive"))?,
                field: unit.field,
            };
            let bodies = start.bodies.iter();
            let start = State {
                time: start.time,
                domain: start.domain,
                bodies: bodies
                    .map(|body| Body::new(body.position, body.velocity))
                    .collect(),
            };
            let mut engine = Engine::new(&scene, setup.parameters, &start, Streams::new(1, 0))?;
            engine.hold_step(step);
            engine.advance(f64::INFINITY, steps, &mut ());
            let what = format!(
                "{} x {}, cells {cell_size:?}, step {step}",
                sides[0], sides[1]
            );
            let time = engine.time() - start.time;
            let end = engine.state();
            for (before, after) in start.bodies.iter().zip(&end.bodies) {
                findings.require(before.velocity == after.velocity, || {
                    format!("{what}: another velocity")
                });
            }
            let mut most = 0.0_f64;
            for (before, after) in start.bodies.iter().zip(&end.bodies) {
                for (axis, side) in sides.into_iter().enumerate() {
                    let [from, to] = [before, after].map(|body| body.position[axis]);
                    let off = off(from, before.velocity[axis], time, side, to);
                    most = most.max(off / side);
                }
            }
            findings.at_most(&format!("{what}: off"), most, 1e-11);
            worst = worst.max(most);
        }
    }
    findings.found(format!("{steps} steps each, off by {worst:.1e} L at most"));
    Ok(())
}
