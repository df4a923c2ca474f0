//! Hard cases of Monte Carlo densities: crowded cells, empty cells, large density differences; no
//! simulator, one, and two.

use nalgebra::vector;
use stosszahl_dsmc::{Neighbourhood, Scheme};
use stosszahl_model::samples::state;

use super::schemes::{SchemeRun, each, setups, uniform, warm};
use crate::gas::{domain, random, scattered};
use crate::{Done, TrialLog};

trials! {
    "crowded" => crowded,
        "300 of 400 disks in a square of 2 d, at 59 times the area they have; elastic and r = 0.8; every scheme",
        "chi limited and counted wherever it follows the density; no rate negative or infinite; energy and momentum";
    "packed" => packed,
        "500 disks without order at packing 0.85 and 0.95, beyond close packing, limits on chi of 10 and 100; every scheme",
        "chi limited and counted where it is reached; energy, momentum, an end";
    "one-point" => one_point,
        "50 disks at one point: in the middle, at the origin and at the last number below the sides; every scheme",
        "energy and momentum; they part, and collide when they meet around the box";
    "contrast" => contrast,
        "density contrast of 1e4: 1000 disks on 1 % of the box, 10 on the rest; every scheme",
        "energy and momentum; the dense part collides, the thin one too in the end";
    "few" => few,
        "0, 1 and 2 disks in boxes from 0.7 d to 40 d a side and of 1 : 100, moving and at rest; every scheme",
        "the time is reached; one alone flies straight on and never collides; energy and momentum; most cells are empty";
}

const ALL: [f64; 2] = [1.0, 0.8];

/// Runs a Monte Carlo scheme for a number of time steps, and checks that particles collide.
fn collides(log: &mut TrialLog, run: &mut SchemeRun, steps: u64) {
    run.steps(steps);
    must!(log, run.tally().collisions > 0; "no collision");
}

fn crowded(log: &mut TrialLog) -> Done {
    let side = 32.0;
    let mut stream = random(1);
    let mut places = scattered(300, [8.5, 8.5], [2.0, 2.0], &mut stream);
    places.extend(scattered(100, [0.0; 2], [side; 2], &mut stream));
    let start = warm(domain(side, side)?, places, 1)?;
    let mut least = u64::MAX;
    let worst = each(log, &ALL, &start, |log, run| {
        collides(log, run, 10);
        let cells = run.tally().limited_cells;
        must!(log, run.setup.is_local() == (cells > 0); "{cells} limited cells");
        if cells > 0 {
            least = least.min(cells);
        }
        Ok(())
    })?;
    found!(log; "chi limited in {least} cells or more of each scheme that follows the density; energy and momentum to {:.1e}",
        worst[0].max(worst[1]));
    Ok(())
}

fn packed(log: &mut TrialLog) -> Done {
    let (mut worst, mut most) = (0.0_f64, 0.0_f64);
    for packing in [0.85, 0.95] {
        let start = uniform(500, packing, 2)?;
        for limit in [10.0, 100.0] {
            for mut setup in setups() {
                setup.parameters.max_contact_value = limit;
                about!(log; "{} at {packing}, limit {limit:e}", setup.name);
                let mut run = SchemeRun::new(setup, 1.0, &start)?;
                run.steps(10);
                run.audit(log);
                worst = worst.max(run.off[0]).max(run.off[1]);
                let tally = run.tally();
                let (cells, active) = (tally.limited_cells, tally.active_cells);
                // All simulators at random, some cells beyond close packing.
                let limited = match setup.parameters.scheme {
                    Scheme::Boltzmann => cells == 0,
                    Scheme::Enskog(Neighbourhood::Mean) => {
                        let beyond = limit < 15.0 || packing > 0.9;
                        (cells == active) == beyond
                    }
                    _ => cells > 0 && tally.limited_collisions > 0,
                };
                let collisions = tally.limited_collisions;
                must!(log, limited; "{cells} of {active} cells limited, {collisions} collisions");
                let pairs = run.engine.simulators() as f64 * tally.steps.max(1) as f64;
                most = most.max(2.0 * tally.collisions as f64 / pairs);
            }
        }
    }
    found!(log; "{most:.2} collisions of each in a step at most; energy and momentum to {worst:.1e}");
    Ok(())
}

fn one_point(log: &mut TrialLog) -> Done {
    let side = 20.0_f64;
    let mut worst = 0.0_f64;
    for at in [0.5 * side, 0.0, side.next_down()] {
        let start = warm(domain(side, side)?, vec![vector![at, at]; 50], 3)?;
        let off = each(log, &ALL, &start, |log, run| {
            collides(log, run, 40);
            Ok(())
        })?;
        worst = worst.max(off[0]).max(off[1]);
    }
    found!(log; "energy and momentum to {worst:.1e}");
    Ok(())
}

fn contrast(log: &mut TrialLog) -> Done {
    let side = 300.0;
    let mut stream = random(4);
    let mut places = scattered(1000, [75.0; 2], [0.1 * side; 2], &mut stream);
    // The box without a strip beside the dense part.
    places.extend(scattered(10, [0.0, 110.0], [side, 180.0], &mut stream));
    let start = warm(domain(side, side)?, places, 4)?;
    let worst = each(log, &ALL, &start, |log, run| {
        collides(log, run, 5);
        Ok(())
    })?;
    found!(log; "energy and momentum to {:.1e}", worst[0].max(worst[1]));
    Ok(())
}

fn few(log: &mut TrialLog) -> Done {
    const TIME: f64 = 20.0;
    let (mut runs, mut met) = (0, 0);
    let boxes = [
        [0.7, 0.7],
        [5.0, 5.0],
        [40.0, 40.0],
        [1.0, 100.0],
        [100.0, 1.0],
    ];
    for [width, height] in boxes {
        for (count, speed) in [
            (0_usize, 1.0),
            (0, 0.0),
            (1, 1.0),
            (1, 0.0),
            (2, 1.0),
            (2, 0.0),
        ] {
            let bodies = [
                (
                    vector![0.3 * width, 0.4 * height],
                    vector![0.9, -0.7] * speed,
                ),
                (
                    vector![0.5 * width, 0.6 * height],
                    vector![-0.8, 0.3] * speed,
                ),
            ];
            let start = state(domain(width, height)?, bodies[..count].iter().copied());
            for setup in setups() {
                about!(log; "{}: {count} in {width} x {height} at {speed}", setup.name);
                let mut run = SchemeRun::new(setup, 1.0, &start)?;
                let reached = run.engine.advance(TIME, 100_000, &mut ());
                let (time, steps) = (run.engine.time(), run.tally().steps);
                must!(log, reached && time == TIME; "time {time} after {steps} steps");
                run.audit(log);
                let collisions = run.tally().collisions;
                met += collisions;
                runs += 1;
                if count == 1 && run.engine.simulators() == 1 {
                    must!(log, collisions == 0; "one alone has {collisions} collisions");
                    let place = start.domain.wrap(bodies[0].0 + bodies[0].1 * TIME);
                    let end = run.engine.state().bodies[0].position;
                    // Steps of 1e-1 and more, each rounded to 1e-14 in a box of 100.
                    log.at_most("place off", start.domain.distance(place, end), 1e-11);
                }
                let good = speed > 0.0 || collisions == 0;
                must!(log, good; "disks at rest have {collisions} collisions");
            }
        }
    }
    found!(log; "{runs} runs, {met} collisions");
    Ok(())
}
