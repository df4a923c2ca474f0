//! Speed of the engines: pair collisions a second (event-driven) and simulator steps a second (Monte Carlo) of one
//! thread, equilibrated elastic disks. All settings take turns for several rounds; medians and extremes are printed.
//!
//! `cargo bench --bench engines [ROUNDS]`

use std::time::Instant;

use stosszahl::bench::{EventDriven, gas, unit_disks};
use stosszahl::dsmc::{self, Copies, Displacement, Neighbourhood, Parameters, Scheme};
use stosszahl::model::Constant;
use stosszahl::model::initial::Arrangement;
use stosszahl::model::random::Streams;

/// One thing that is timed: what it does, and a closure that does it and returns how much.
struct Subject {
    name: String,
    unit: &'static str,
    work: Box<dyn FnMut() -> f64>,
}

fn exact(count: usize, packing_fraction: f64) -> Subject {
    let work = EventDriven {
        disks: count,
        packing_fraction,
        restitution: 1.0,
        arrangement: Arrangement::Disordered,
        equilibrate: 10.0,
    };
    let mut prepared = work.prepare().expect("a gas");
    let collisions = (4 * count as u64).max(200_000);
    Subject {
        name: format!("ed, N = {count}, packing {packing_fraction}"),
        unit: "collisions/s",
        work: Box::new(move || {
            let speed = prepared.time(collisions, None).expect("collisions");
            speed.collisions_per_second
        }),
    }
}

fn monte_carlo(count: usize, scheme: Scheme) -> Subject {
    let start = gas(Arrangement::Disordered, count, 0.25, 1.0, 1).expect("a gas");
    let parameters = Parameters {
        scheme,
        displacement: Displacement::Diameter,
        cell_size: Some(2.0),
        simulators_per_disk: 1,
        copies: Copies::Independent,
        steps_per_crossing: 4.0,
        largest_contact_value: 10.0,
    };
    let mut engine = dsmc::Engine::new(
        &unit_disks(Constant::ELASTIC),
        parameters,
        &start,
        Streams::new(1, 0),
    )
    .expect("an engine");
    engine.advance(f64::INFINITY, 20, &mut ());
    let steps = (4_000_000 / count as u64).max(10);
    Subject {
        name: format!(
            "dsmc-{}, N = {count}, packing 0.25, cells of 2 d",
            scheme.name()
        ),
        unit: "simulator steps/s",
        work: Box::new(move || {
            let began = Instant::now();
            engine.advance(f64::INFINITY, steps, &mut ());
            (steps * count as u64) as f64 / began.elapsed().as_secs_f64()
        }),
    }
}

#[allow(clippy::print_stdout, reason = "a benchmark prints")]
fn main() {
    let rounds = std::env::args()
        .find_map(|argument| argument.parse().ok())
        .unwrap_or(5);
    let mut subjects = Vec::new();
    for packing in [0.25, 0.70] {
        for count in [10_000, 100_000] {
            subjects.push(exact(count, packing));
        }
    }
    for scheme in [Scheme::FreeVolume, Scheme::Enskog(Neighbourhood::Cells(2))] {
        subjects.push(monte_carlo(100_000, scheme));
    }
    let mut rates = vec![Vec::new(); subjects.len()];
    for _ in 0..rounds {
        for (subject, rates) in subjects.iter_mut().zip(&mut rates) {
            rates.push((subject.work)());
        }
    }
    for (subject, rates) in subjects.iter().zip(&mut rates) {
        rates.sort_by(f64::total_cmp);
        println!(
            "{:<52} {:>11.3e} {} (least {:.3e}, most {:.3e})",
            subject.name,
            rates[rates.len() / 2],
            subject.unit,
            rates[0],
            rates[rates.len() - 1]
        );
    }
}
