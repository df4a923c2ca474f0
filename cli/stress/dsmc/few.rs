//! No simulator, one, and two.

use nalgebra::vector;
use stosszahl_model::{Body, State};

use super::gas::{Sums, audit, domain, engine, setups};
use super::{Case, Effort, Findings, Trouble};
use crate::bench::Disks;

pub(super) const CASES: &[Case] = &[Case::new(
    "few",
    "0, 1 and 2 disks in boxes from 0.7 d to 40 d a side and of 1 : 100, moving and at rest; every scheme",
    "the time is reached; one alone flies straight on and meets nobody; energy and momentum; most cells are empty",
    few,
)];

fn few(_: Effort, findings: &mut Findings) -> Result<(), Trouble> {
    const TIME: f64 = 20.0;
    let mut runs = 0;
    let mut met = 0;
    for [width, height] in [
        [0.7, 0.7],
        [5.0, 5.0],
        [40.0, 40.0],
        [1.0, 100.0],
        [100.0, 1.0],
    ] {
        for count in 0..=2_usize {
            for speed in [1.0, 0.0] {
                let bodies = [
                    Body::new(
                        vector![0.3 * width, 0.4 * height],
                        vector![0.9, -0.7] * speed,
                    ),
                    Body::new(
                        vector![0.5 * width, 0.6 * height],
                        vector![-0.8, 0.3] * speed,
                    ),
                ];
                let start: State<Disks> = State {
                    time: 0.0,
                    domain: domain(width, height)?,
                    bodies: bodies[..count].to_vec(),
                };
                for setup in setups() {
                    let what = format!("{}: {count} in {width} x {height} at {speed}", setup.name);
                    let mut engine = engine(setup, 1.0, &start)?;
                    let before = Sums::of(&engine.state());
                    let reached = engine.advance(TIME, 100_000, &mut ());
                    findings.require(reached && engine.time() == TIME, || {
                        format!(
                            "{what}: time {} after {} steps",
                            engine.time(),
                            engine.tally().steps
                        )
                    });
                    audit(findings, &what, &engine, before, true);
                    let collisions = engine.tally().collisions;
                    met += collisions;
                    runs += 1;
                    if count == 1 && engine.simulators() == 1 {
                        findings.require(collisions == 0, || {
                            format!("{what}: one alone has {collisions} collisions")
                        });
                        let body = bodies[0];
                        let place = start.domain.wrap(body.position + body.velocity * TIME);
                        let off = start
                            .domain
                            .distance(place, engine.state().bodies[0].position);
                        // Steps of 1e-1 and more, each rounded to 1e-14 in a box of 100.
                        findings.at_most(&format!("{what}: place off"), off, 1e-11);
                    }
                    findings.require(speed > 0.0 || collisions == 0, || {
                        format!("{what}: disks at rest have {collisions} collisions")
                    });
                }
            }
        }
    }
    findings.found(format!("{runs} runs, {met} collisions"));
    Ok(())
}
