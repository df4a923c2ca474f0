//! One gas, exact and by Monte Carlo, with every number in full, for comparison with the same from Python, bit by bit.
//! `states 5000 50` has more disks and a later end, and says how fast they were.

#![allow(clippy::print_stdout, clippy::print_stderr)]

use std::time::Instant;

use stosszahl_gas::{EventDriven, Gas, MonteCarlo, Scheme, Simulation};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut given = std::env::args().skip(1);
    let count = given.next().map_or(Ok(500), |text| text.parse())?;
    let until = given.next().map_or(Ok(5.0), |text| text.parse())?;
    let gas = Gas::disks(count)
        .packing_fraction(0.25)
        .restitution(0.9)
        .seed(7)
        .build()?;
    let mut exact = EventDriven::new(&gas)?;
    exact.equilibrate(5.0)?;
    let mut chaos = MonteCarlo::from_state(&exact.state(), Scheme::CONTACT_POINT)?;
    let begin = Instant::now();
    exact.advance(until, &mut ())?;
    let (seconds, collisions) = (begin.elapsed().as_secs_f64(), exact.work().collisions);
    chaos.advance(until, &mut ())?;
    for particle in [exact.particles(), chaos.particles()]
        .iter()
        .flat_map(|one| &one.all)
    {
        let (at, v) = (particle.position, particle.velocity);
        println!("{:?} {:?} {:?} {:?}", at.x, at.y, v.x, v.y);
    }
    eprintln!("exact: {collisions} collisions in {seconds:.4} s");
    assert_eq!(exact.time(), until);
    Ok(())
}
