//! Where does molecular chaos break? Exact disks and Monte Carlo from one and the same microstate.

#![allow(clippy::print_stdout)]

use stosszahl::prelude::*;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let gas = Gas::disks(1000)
        .packing_fraction(0.25)
        .restitution(0.6)
        .seed(1)
        .build()?;
    let mut exact = EventDriven::new(&gas)?;
    exact.equilibrate(10.0)?;
    let mut chaos = MonteCarlo::from_state(&exact.state(), Scheme::CONTACT_POINT)?; // the same microstate
    let (mut impact, mut uniform) = (ImpactParameters::default(), ImpactParameters::default());
    exact.advance(100.0, &mut impact)?;
    chaos.advance(100.0, &mut uniform)?;
    println!(
        "slope of P(b/d): exact {:.3}, Monte Carlo {:.3}",
        slope(&impact),
        slope(&uniform)
    );
    assert!(slope(&impact) > 0.1 && slope(&uniform).abs() < 0.1);
    Ok(())
}

fn slope(impact: &ImpactParameters) -> f64 {
    impact.slope().unwrap_or(0.0)
}
