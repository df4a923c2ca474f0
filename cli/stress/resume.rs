//! Kills, in gases of every kind and at many moments.

use super::crystals::hexagonal;
use super::starts::disordered;
use super::{Case, Effort, Findings, Trouble};

pub(super) const CASES: &[Case] = &[Case::new(
    "kills",
    "gases from thin to crystalline, elastic, inelastic and with contact time, cut at 8 (long: 200) sets of random moments each",
    "the bytes of the run that was never killed; the other cases are cut as well",
    kills,
)];

fn kills(effort: Effort, findings: &mut Findings) -> Result<(), Trouble> {
    let sets = if effort.long { 200 } else { 8 };
    let mut gases = vec![hexagonal(0.88, 1.0)?, hexagonal(0.9, 0.99)?];
    for (packing, restitution) in [(0.01, 1.0), (0.25, 0.8), (0.5, 0.6), (0.69, 1.0)] {
        let gas = disordered(200, packing, restitution, 3)?;
        gases.push(gas.clone().with_contact_time(1e-3));
        gases.push(gas);
    }
    for (number, gas) in gases.iter().enumerate() {
        for seed in 0..sets {
            gas.survives_kills(
                findings,
                &format!("gas {number}, moments {seed}"),
                3000,
                seed,
            )?;
        }
        findings.progress((number + 1) as f64 / gases.len() as f64, "");
    }
    findings.found(format!("{} gases, {sets} sets of four legs", gases.len()));
    Ok(())
}
