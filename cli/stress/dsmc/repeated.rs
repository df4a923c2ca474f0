//! The same bytes with any number of threads, and after a restart.

use rayon::ThreadPoolBuilder;
use stosszahl_dsmc::Engine;
use stosszahl_model::State;

use super::gas::{Setup, bytes, engine, resumed, setups, uniform};
use super::{Case, Effort, Findings, Trouble};
use crate::bench::Disks;

pub(super) const CASES: &[Case] = &[
    Case::new(
        "threads",
        "20 160 simulators in few and many tiles, by 1, 2 and 3 threads, restitution 0.9, packing 0.2, 2 steps; every scheme",
        "the same bytes of the checkpoint with any number of threads; with other tiles the same gas, unless partners are across cells",
        threads,
    ),
    Case::new(
        "kills",
        "the same gas and one of 300, ended after legs of 1 and 2 steps and begun again from bytes; every scheme",
        "the bytes of the gas that goes on in memory",
        kills,
    ),
];

fn gas_of(setup: Setup, simulators: usize) -> Result<State<Disks>, Trouble> {
    uniform(
        simulators / setup.parameters.simulators_per_disk as usize,
        0.2,
        11,
    )
}

/// Advances in a pool of so many threads.
fn advance(engine: &mut Engine<Disks>, threads: usize, steps: u64) -> Result<(), Trouble> {
    let pool = ThreadPoolBuilder::new().num_threads(threads).build();
    let pool = pool.map_err(|_| Trouble::NoStart("no threads"))?;
    pool.install(|| engine.advance(f64::INFINITY, steps, &mut ()));
    Ok(())
}

fn threads(_: Effort, findings: &mut Findings) -> Result<(), Trouble> {
    let mut other = Vec::new();
    for setup in setups() {
        let start = gas_of(setup, 20_160)?;
        let mut ends = Vec::new();
        for tile in [8_000, 500] {
            let mut one = Vec::new();
            for threads in [1, 2, 3] {
                let mut engine = engine(setup, 0.9, &start)?;
                engine.retile(tile);
                advance(&mut engine, threads, 2)?;
                let bytes = bytes(&engine)?;
                if threads == 1 {
                    one = bytes;
                    ends.push(engine.state().bodies);
                } else {
                    findings.require(bytes == one, || {
                        format!(
                            "{}: other bytes with {threads} threads, tiles of {tile}",
                            setup.name
                        )
                    });
                }
            }
        }
        if ends.iter().any(|end| *end != ends[0]) {
            findings.require(setup.parameters.scheme.is_across(), || {
                format!("{}: another gas with other tiles", setup.name)
            });
            other.push(setup.name);
        }
    }
    findings.found(format!(
        "another gas with other tiles: {}",
        other.join(", ")
    ));
    Ok(())
}

fn kills(_: Effort, findings: &mut Findings) -> Result<(), Trouble> {
    for simulators in [304, 20_160] {
        for setup in setups() {
            let start = gas_of(setup, simulators)?;
            let mut steady = engine(setup, 0.9, &start)?;
            let mut killed = bytes(&steady)?;
            for leg in [1, 2] {
                steady.advance(f64::INFINITY, leg, &mut ());
                let mut engine = resumed(setup, 0.9, start.domain, &killed)?;
                engine.advance(f64::INFINITY, leg, &mut ());
                killed = bytes(&engine)?;
                let same = killed == bytes(&steady)?;
                findings.require(same, || {
                    format!(
                        "{} of {simulators}: other bytes after {leg} steps",
                        setup.name
                    )
                });
            }
        }
    }
    findings.found("two gases, two legs each".to_owned());
    Ok(())
}
