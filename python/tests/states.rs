//! States of one gas, exact and by Monte Carlo, printed in full for a bitwise comparison with
//! Python.

#![allow(clippy::print_stdout)]

use stosszahl_gas::{EventDriven, Gas, MonteCarlo, Scheme};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let until = 5.0;
    let gas = Gas::disks(500)
        .packing_fraction(0.25)
        .restitution(0.9)
        .seed(7)
        .build()?;
    let mut exact = EventDriven::new(&gas)?;
    exact.equilibrate(5.0)?;
    let mut chaos = MonteCarlo::from_state(&exact.state(), Scheme::CONTACT_POINT)?;
    exact.advance(until, &mut ())?;
    chaos.advance(until, &mut ())?;
    for particle in [exact.particles(), chaos.particles()]
        .iter()
        .flat_map(|one| &one.all)
    {
        let (at, v) = (particle.position, particle.velocity);
        println!("{:?} {:?} {:?} {:?}", at.x, at.y, v.x, v.y);
    }
    assert_eq!(exact.time(), until);
    Ok(())
}
