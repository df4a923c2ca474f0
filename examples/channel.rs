//! A channel: grains that a force drives between walls with a temperature. Which profile has their
//! velocity?

#![allow(clippy::print_stdout)]

use stosszahl::prelude::*;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let wall = Face::Wall(Wall::still(Rebound::Diffuse { temperature: 1.0 }));
    let gas = Gas::disks(600)
        .box_size([60.0, 30.0])
        .walls(1, [wall, wall])
        .gravity([0.01, 0.0])
        .restitution(0.9)
        .build()?;
    let mut exact = EventDriven::new(&gas)?;
    exact.advance(300.0, &mut ())?;
    let mut rows = [(0.0, 0.0); 6];
    for _ in 0..200 {
        let next = exact.time() + 1.0;
        exact.advance(next, &mut ())?;
        exact.visit_particles(&mut |particle| {
            let row = (particle.position.y / 5.0) as usize;
            let (sum, count) = &mut rows[row.min(5)];
            *sum += particle.velocity.x;
            *count += 1.0;
        });
    }
    let profile = rows.map(|(sum, count)| sum / count);
    println!("velocity along the channel, from wall to wall: {profile:.3?}");
    assert!(
        profile[2] > profile[0] && profile[3] > profile[5],
        "the middle is fastest"
    );
    Ok(())
}
