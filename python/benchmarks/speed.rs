//! Speed of exact elastic disks at packing 0.25: `speed DISKS UNTIL` prints the number of
//! collisions up to a time, and the seconds they took, for comparison with Python.

#![allow(clippy::print_stdout)]

use std::time::Instant;

use stosszahl_gas::{EventDriven, Gas};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut given = std::env::args().skip(1);
    let disks = given.next().map_or(Ok(5000), |text| text.parse())?;
    let until = given.next().map_or(Ok(50.0), |text| text.parse())?;
    let gas = Gas::disks(disks).packing_fraction(0.25).seed(7).build()?;
    let mut exact = EventDriven::new(&gas)?;
    exact.equilibrate(5.0)?;
    let (before, begin) = (exact.work_counters().collisions, Instant::now());
    exact.advance(until, &mut ())?;
    let seconds = begin.elapsed().as_secs_f64();
    println!("{} {seconds:?}", exact.work_counters().collisions - before);
    Ok(())
}
