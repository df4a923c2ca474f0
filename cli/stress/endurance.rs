//! Long runs.

use super::gas::{Gas, MOMENTUM};
use super::starts::disordered;
use super::{Case, Effort, Findings, Trouble};

pub(super) const CASES: &[Case] = &[
    Case::new(
        "elastic-run",
        "1000 elastic disks at packing 0.4 in legs of 1e5 collisions; 2e6 collisions, 1e9 long (--collisions)",
        "energy drift at most 1e-10, no overlap beyond 1e-10 d, and at the end the bits of the same gas with a clock at zero",
        elastic,
    ),
    Case::new(
        "cooling",
        "500 disks at packing 0.4, restitution 0.9, contact time 1e-6, until the temperature has fallen by 12 decades",
        "numbers stay finite, no overlap, momentum and energy balance to rounding, temperature never grows",
        cooling,
    ),
];

fn elastic(effort: Effort, findings: &mut Findings) -> Result<(), Trouble> {
    const LEG: u64 = 100_000;
    let collisions = effort.collisions.unwrap_or(if effort.long {
        1_000_000_000
    } else {
        2_000_000
    });
    let gas = disordered(1000, 0.4, 1.0, 5)?;
    let mut told = 0;
    let course = gas.run(f64::INFINITY, collisions, LEG, |end, ledger| {
        if ledger.collisions - told >= 20_000_000 {
            told = ledger.collisions;
            let share = ledger.collisions as f64 / collisions as f64;
            findings.progress(share, &format!("at time {:.4e}", end.state.time));
        }
    })?;
    if let Some(error) = &course.stopped {
        findings.fault(error.to_string());
    }
    // 2e6 collisions of each disk: a linear sum of roundings of 1e-16 would be 2e-10, their random walk is 1e-13.
    findings.at_most("energy drift", gas.energy_error(&course), 1e-10);
    findings.at_most("overlap over d", course.overlap, 1e-10);
    findings.at_most(
        "momentum",
        gas.momentum_error(&course.end.state),
        MOMENTUM * 10.0,
    );
    let late = Gas::new(gas.scene.clone(), course.end.state.clone());
    let mut early = late.clone();
    early.start.time = 0.0;
    let ends = [&late, &early].map(|gas| {
        gas.run(f64::INFINITY, LEG, LEG, |_, _| ())
            .map(|course| course.end.state.bodies)
    });
    let [late_end, early_end] = ends;
    findings.require(late_end? == early_end?, || {
        format!(
            "at time {:.3e} the gas moves otherwise than at time zero",
            course.end.state.time
        )
    });
    findings.found(format!(
        "{} collisions to time {:.3e}, energy {:.1e}, overlap {:.1e} d",
        course.ledger.collisions,
        course.end.state.time,
        gas.energy_error(&course),
        course.overlap
    ));
    gas.survives_kills(findings, "gas", 40_000, 1)
}

fn cooling(_: Effort, findings: &mut Findings) -> Result<(), Trouble> {
    const DECADES: f64 = 1e-12;
    const MOST: u64 = 5_000_000;
    let gas = disordered(500, 0.4, 0.9, 6)?.with_contact_time(1e-6);
    let start = gas.start.temperature(&gas.scene);
    let mut last = start;
    let mut grew = 0.0_f64;
    let mut gas_now = gas.clone();
    let (mut lost, mut collisions) = (0.0, 0);
    let mut from = stosszahl_ed::Checkpoint::from(gas.start.clone());
    while last > DECADES * start && collisions < MOST {
        let mut engine = gas.engine(from)?;
        let mut ledger = super::gas::Ledger::default();
        engine.advance(f64::INFINITY, 2000, &mut ledger)?;
        findings.at_most(
            "overlap over d",
            engine.worst_overlap(),
            super::gas::OVERLAP,
        );
        from = engine.checkpoint();
        lost += ledger.lost;
        collisions += ledger.collisions;
        let temperature = from.state.temperature(&gas.scene);
        grew = grew.max(temperature / last - 1.0);
        last = temperature;
        if ledger.collisions == 0 {
            break;
        }
    }
    let count = from.state.bodies.len() as f64;
    findings.at_most(
        "temperature over the asked one",
        last / (DECADES * start),
        1.0,
    );
    // Two thousand roundings.
    findings.at_most("growth of the temperature", grew, 1e-12);
    let balance = (last * count + lost) / (start * count) - 1.0;
    findings.at_most("energy balance", balance.abs(), super::gas::ENERGY);
    findings.at_most("momentum", gas.momentum_error(&from.state), MOMENTUM);
    // The last collisions still follow the energy law among themselves, at speeds of 1e-6.
    gas_now.start = from.state;
    gas_now.holds(findings, "cold gas", 2000)?;
    findings.found(format!(
        "{collisions} collisions to T/T(0) = {:.1e}",
        last / start
    ));
    gas.survives_kills(findings, "cooling", 40_000, 1)
}
