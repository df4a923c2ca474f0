//! A binary mixture: do heavy and light disks share their energy equally? Not if collisions lose
//! energy.

#![allow(clippy::print_stdout)]

use stosszahl::prelude::*;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let gas = Gas::disks(800)
        .and(800, 1.0, 4.0)
        .packing_fraction(0.05)
        .restitution(0.7)
        .build()?;
    let mut exact = EventDriven::new(&gas)?;
    exact.equilibrate(5.0)?;
    exact.advance(60.0, &mut ())?;
    let mut sums = [(0.0, 0.0); 2];
    exact.visit_particles(&mut |particle| {
        let (energy, count) = &mut sums[particle.species as usize];
        *energy += 0.5 * particle.mass * particle.velocity.norm_squared();
        *count += 1.0;
    });
    let [light, heavy] = sums.map(|(energy, count)| energy / count);
    println!(
        "T of light disks {light:.4}, of heavy ones {heavy:.4}: ratio {:.3}",
        heavy / light
    );
    // Theory: heavy disks are hotter, 1.1 to 1.6 times here; 800 disks of each have an error of 5
    // %.
    assert!(heavy > light);
    Ok(())
}
