//! Crowded cells, empty cells and great differences of density.

use nalgebra::vector;
use stosszahl_dsmc::{Engine, Neighbourhood, Scheme};
use stosszahl_model::State;

use super::gas::{
    Setup, Sums, audit, domain, each_step, engine, random, scattered, setups, uniform, warm,
};
use super::{Case, Effort, Findings, Trouble};
use crate::bench::Disks;

pub(super) const CASES: &[Case] = &[
    Case::new(
        "crowded",
        "300 of 400 disks in a square of 2 d, at 59 times the area they have; elastic and r = 0.8; every scheme",
        "chi limited and counted wherever it follows the density; no rate negative or infinite; energy and momentum",
        crowded,
    ),
    Case::new(
        "packed",
        "500 disks without order at packing 0.85 and 0.95, beyond close packing, limits on chi of 10 and 100; every scheme",
        "chi limited and counted where it is reached; energy, momentum, an end",
        packed,
    ),
    Case::new(
        "one-point",
        "50 disks at one point: in the middle, at the origin and at the last number below the sides; every scheme",
        "energy and momentum; they part, and collide when they meet around the box",
        one_point,
    ),
    Case::new(
        "contrast",
        "density contrast of 1e4: 1000 disks on 1 % of the box, 10 on the rest; every scheme",
        "energy and momentum; the dense part collides, the thin one too in the end",
        contrast,
    ),
];

/// Runs a start for so many steps, all setups, elastic and not.
fn all(
    findings: &mut Findings,
    start: &State<Disks>,
    steps: u64,
    mut look: impl FnMut(&mut Findings, Setup, &Engine<Disks>),
) -> Result<f64, Trouble> {
    let mut worst = 0.0_f64;
    for setup in setups() {
        for restitution in [1.0, 0.8] {
            let what = format!("{}, r = {restitution}", setup.name);
            let mut engine = engine(setup, restitution, start)?;
            let before = Sums::of(&engine.state());
            engine.advance(f64::INFINITY, steps, &mut ());
            let elastic = restitution == 1.0;
            let [energy, momentum] = audit(findings, &what, &engine, before, elastic);
            worst = worst.max(momentum);
            if elastic {
                worst = worst.max(energy.abs());
            }
            look(findings, setup, &engine);
        }
    }
    Ok(worst)
}

fn crowded(_: Effort, findings: &mut Findings) -> Result<(), Trouble> {
    let side = 32.0;
    let mut stream = random(1);
    let mut places = scattered(300, [8.5, 8.5], [2.0, 2.0], &mut stream);
    places.extend(scattered(100, [0.0; 2], [side; 2], &mut stream));
    let start = warm(domain(side, side)?, &places, 1)?;
    let mut limited = Vec::new();
    let worst = all(findings, &start, 10, |findings, setup, engine| {
        let tally = engine.tally();
        findings.require(tally.collisions > 0, || {
            format!("{}: no collision", setup.name)
        });
        findings.require(setup.is_local() == (tally.limited_cells > 0), || {
            format!("{}: {} limited cells", setup.name, tally.limited_cells)
        });
        limited.push(tally.limited_cells);
    })?;
    let least = limited.iter().filter(|&&cells| cells > 0).min();
    findings.found(format!(
        "chi limited in {} cells or more of each scheme that follows the density; energy and momentum to {worst:.1e}",
        least.copied().unwrap_or_default()
    ));
    Ok(())
}

fn packed(_: Effort, findings: &mut Findings) -> Result<(), Trouble> {
    let (mut worst, mut most) = (0.0_f64, 0.0_f64);
    for packing in [0.85, 0.95] {
        let start = uniform(500, packing, 2)?;
        for limit in [10.0, 100.0] {
            for mut setup in setups() {
                setup.parameters.largest_contact_value = limit;
                let what = format!("{} at {packing}, limit {limit:e}", setup.name);
                let mut engine = engine(setup, 1.0, &start)?;
                let before = Sums::of(&engine.state());
                engine.advance(f64::INFINITY, 10, &mut ());
                let [energy, momentum] = audit(findings, &what, &engine, before, true);
                worst = worst.max(energy.abs()).max(momentum);
                let tally = engine.tally();
                // All of them at random: some cells are beyond close packing.
                let limited = match setup.parameters.scheme {
                    Scheme::Boltzmann => tally.limited_cells == 0,
                    Scheme::Enskog(Neighbourhood::Mean) => {
                        let beyond = limit < 15.0 || packing > 0.9;
                        (tally.limited_cells == tally.active_cells) == beyond
                    }
                    _ => tally.limited_cells > 0 && tally.limited_collisions > 0,
                };
                findings.require(limited, || {
                    format!(
                        "{what}: {} of {} cells limited, {} collisions",
                        tally.limited_cells, tally.active_cells, tally.limited_collisions
                    )
                });
                most = most.max(each_step(&engine));
            }
        }
    }
    findings.found(format!(
        "{most:.2} collisions of each in a step at most; energy and momentum to {worst:.1e}"
    ));
    Ok(())
}

fn one_point(_: Effort, findings: &mut Findings) -> Result<(), Trouble> {
    let side = 20.0_f64;
    let mut worst = 0.0_f64;
    for at in [0.5 * side, 0.0, side.next_down()] {
        let places = vec![vector![at, at]; 50];
        let start = warm(domain(side, side)?, &places, 3)?;
        let off = all(findings, &start, 40, |findings, setup, engine| {
            findings.require(engine.tally().collisions > 0, || {
                format!("{} at {at}: no collision", setup.name)
            });
        })?;
        worst = worst.max(off);
    }
    findings.found(format!("energy and momentum to {worst:.1e}"));
    Ok(())
}

fn contrast(_: Effort, findings: &mut Findings) -> Result<(), Trouble> {
    let side = 300.0;
    let mut stream = random(4);
    let mut places = scattered(1000, [75.0; 2], [0.1 * side; 2], &mut stream);
    // All of the box but for a strip beside the dense part.
    places.extend(scattered(10, [0.0, 110.0], [side, 180.0], &mut stream));
    let start = warm(domain(side, side)?, &places, 4)?;
    let worst = all(findings, &start, 5, |findings, setup, engine| {
        findings.require(engine.tally().collisions > 0, || {
            format!("{}: no collision", setup.name)
        });
    })?;
    findings.found(format!("energy and momentum to {worst:.1e}"));
    Ok(())
}
