use stosszahl::prelude::*;

fn main() -> Result<(), GasError> {
    let gas = Gas::disks(10_000).packing_fraction(0.25);
    let gas = gas.restitution(0.6).seed(1).build()?;
    let mut exact = EventDriven::new(&gas)?;
    exact.equilibrate(10.0)?;
    let mut chaos = MonteCarlo::from_state(&exact.state(), Scheme::CONTACT_POINT)?;
    let mut impacts = [ImpactParameters::default(), ImpactParameters::default()];
    exact.advance(100.0, &mut impacts[0])?;
    chaos.advance(100.0, &mut impacts[1])?;
    let [exact, chaos] = impacts.map(|its| its.slope().unwrap_or(f64::NAN));
    println!("slope of P(b/d): exact {exact:.3}, Monte Carlo {chaos:.3}");
    Ok(())
}
