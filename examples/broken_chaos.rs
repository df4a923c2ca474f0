//! Where does molecular chaos break? Exact disks and Monte Carlo from one and the same microstate,
//! for 32 gases.

#![allow(clippy::print_stdout, clippy::cast_precision_loss)]

use stosszahl::prelude::*;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let (mut exact_slopes, mut chaos_slopes) = (Vec::new(), Vec::new());
    for seed in 1..=32 {
        let gas = Gas::disks(1000)
            .packing_fraction(0.25)
            .restitution(0.6)
            .seed(seed)
            .build()?;
        let mut exact = EventDriven::new(&gas)?;
        exact.equilibrate(10.0)?;
        let mut chaos = MonteCarlo::from_state(&exact.state(), Scheme::CONTACT_POINT)?; // the same microstate
        let (mut impact, mut uniform) = (ImpactParameters::default(), ImpactParameters::default());
        exact.advance(100.0, &mut impact)?;
        chaos.advance(100.0, &mut uniform)?;
        exact_slopes.extend(impact.slope());
        chaos_slopes.extend(uniform.slope());
    }
    let (exact, exact_se) = mean_and_error(&exact_slopes);
    let (chaos, chaos_se) = mean_and_error(&chaos_slopes);
    println!(
        "slope of P(b/d): exact {exact:.3} ± {exact_se:.3}, Monte Carlo {chaos:.3} ± {chaos_se:.3}"
    );
    // Slopes of single gases scatter by .14. Chaos in both would be beyond four errors once in 10^4
    // times (t, 31 degrees of freedom).
    assert!(exact - chaos > 4.0 * exact_se.hypot(chaos_se));
    Ok(())
}

/// Mean of independent values, and the standard error of the mean.
fn mean_and_error(values: &[f64]) -> (f64, f64) {
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    let squares: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
    (mean, (squares / (count - 1.0) / count).sqrt())
}
