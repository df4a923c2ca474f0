//! A custom observer: number of meetings of each pair of disks.

#![allow(clippy::print_stdout)]

use std::collections::HashMap;

use stosszahl::prelude::*;

/// Counts the meetings of each pair.
#[derive(Default)]
struct Meetings(HashMap<[u32; 2], u64>);

impl Observer for Meetings {
    fn on_collisions(&mut self, batch: &[Collision]) {
        for collision in batch {
            let mut pair = collision.pair;
            pair.sort_unstable();
            *self.0.entry(pair).or_default() += 1;
        }
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    for packing in [0.05, 0.5] {
        let gas = Gas::disks(500)
            .packing_fraction(packing)
            .restitution(0.9)
            .build()?;
        let mut exact = EventDriven::new(&gas)?;
        exact.equilibrate(10.0)?;
        let mut meetings = Meetings::default();
        exact.advance(20.0, &mut meetings)?;
        let all: u64 = meetings.0.values().sum();
        let again = all - meetings.0.len() as u64;
        let share = 100.0 * again as f64 / all as f64;
        println!("packing {packing}: {all} collisions, {share:.1} % of pairs that had met before");
        assert!(all > 0);
    }
    Ok(())
}
