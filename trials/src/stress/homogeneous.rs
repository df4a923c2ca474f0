//! Hard cases of Monte Carlo gases without positions: extreme sizes and temperatures, rare species,
//! aggregation.

use stosszahl_dsmc::homogeneous::{
    AggregationRule, AliasTableSelection, Bird, EnergyLimit, EnergyLoss, HomogeneousEngine,
    HomogeneousGas, LowRank, PairCorrelationFactor, SelectionMethod, Sticking, StopReason,
    TestOrder, Threshold, moments, size_distribution,
};
use stosszahl_model::random::{Purpose, Streams};
use stosszahl_model::samples::{SmoothParticles, smooth_particles};
use stosszahl_model::{Clusters, Plane, Vector};

use crate::gas::{Spheres, law, spheres, without_positions};
use crate::{Done, TrialError, TrialLog};

trials! {
    "size-ratio" => size_ratio,
        "spheres of diameters 1e-6 to 1 and masses 1e-18 to 1 at one temperature, by three selections",
        "bounds never exceeded, energy in the ledger to 1e-11, at most 4 pairs looked at for each collision (alias tables)";
    "giant" => giant,
        "one giant among 1e5 grains of dust, 1e7 long",
        "the giant is hit as often as kinetic theory says, within 5 standard errors";
    "rare-species" => rare_species,
        "species with no particle, one, and two beside a thousand; restitution 0 and 1",
        "bounds never exceeded, energy in the ledger to 1e-11";
    "temperatures" => temperatures,
        "species whose temperatures differ by 1e6 and 1e12, elastic, until they have mixed",
        "energy conserved to 1e-11 and shared alike at the end within 5 standard errors";
    "cold" => cold,
        "a hundred spheres cooling until their speeds are below what numbers can tell",
        "a stop that says so, after collisions by the ten thousand for each";
    "one-cluster" => one_cluster,
        "sticking until one cluster is left: 2e4 disks, 1e6 long",
        "mass exact, momentum and energy ledger to 1e-11";
}

/// Creates an engine for a dilute gas without positions, of species (diameter, mass, count).
fn engine<S: SelectionMethod<Spheres>>(
    kinds: &[(f64, f64, usize)],
    restitution: f64,
    volume: f64,
    temperature: impl Fn(u32) -> f64,
) -> Result<HomogeneousEngine<Spheres, S>, TrialError> {
    let extent = (volume, kinds.iter().map(|kind| kind.2).sum());
    without_positions(
        spheres(kinds, restitution)?,
        PairCorrelationFactor::Dilute,
        extent,
        temperature,
        17,
    )
}

/// Runs a gas without positions for a number of collisions, and checks that kinetic energy plus
/// recorded loss is conserved. Returns the candidate pairs per collision.
fn check_energy_balance<S: SelectionMethod<Spheres>>(
    log: &mut TrialLog,
    name: &str,
    engine: &mut HomogeneousEngine<Spheres, S>,
    collisions: u64,
) -> Result<f64, TrialError> {
    let start = engine.gas().kinetic_energy();
    engine.advance(f64::INFINITY, collisions, &mut ())?;
    let tally = *engine.tally();
    let end = engine.gas().kinetic_energy() + tally.energy_lost;
    // Ten thousand times a rounding: collisions round at random, the largest energies once each.
    log.at_most("energy not in the ledger", (end / start - 1.0).abs(), 1e-11);
    let each = tally.trials as f64 / tally.collisions.max(1) as f64;
    let (collisions, fits) = (tally.collisions, tally.rebuilds);
    found!(log; "{name}: {collisions} collisions, {each:.2} pairs each, {fits} fits");
    Ok(each)
}

/// Runs gases without positions with all three pair-selection methods, and checks their energy
/// balance. Returns the candidate pairs per collision of alias tables.
fn check_all_selections(
    log: &mut TrialLog,
    kinds: &[(f64, f64, usize)],
    restitution: f64,
    volume: f64,
    [tables, trees, single]: [u64; 3],
) -> Result<f64, TrialError> {
    let mut gas = engine::<AliasTableSelection>(kinds, restitution, volume, |_| 1.0)?;
    let each = check_energy_balance(log, "alias-tables", &mut gas, tables)?;
    let mut gas = engine::<LowRank>(kinds, restitution, volume, |_| 1.0)?;
    check_energy_balance(log, "low-rank", &mut gas, trees)?;
    let mut gas = engine::<Bird>(kinds, restitution, volume, |_| 1.0)?;
    check_energy_balance(log, "single-majorant", &mut gas, single)?;
    Ok(each)
}

fn size_ratio(log: &mut TrialLog) -> Done {
    let kind = |k: i32| {
        let diameter = 10.0_f64.powi(-k);
        (diameter, diameter.powi(3), 300 << k)
    };
    let kinds: Vec<_> = (0..7).map(kind).collect();
    let each = check_all_selections(log, &kinds, 0.9, 1e3, [200_000, 20_000, 2_000])?;
    log.at_most("pairs looked at for each collision", each, 4.0);
    Ok(())
}

fn giant(log: &mut TrialLog) -> Done {
    let dust = if log.effort.long { 10_000_000 } else { 100_000 };
    let volume = dust as f64;
    // Dust meets dust at 4 sqrt(pi) d^2 n N/2, and the giant at n pi ((D + d)/2)^2 sqrt(8/pi), T =
    // m = n = 1.
    let (small, large) = (1e-4_f64, 20.0);
    let mut gas =
        engine::<AliasTableSelection>(&[(small, 1.0, dust), (large, 1e9, 1)], 1.0, volume, |_| {
            1.0
        })?;
    let own = 2.0 * std::f64::consts::PI.sqrt() * small * small * dust as f64;
    let distance = 0.5 * (small + large);
    let hits = std::f64::consts::PI * distance * distance * (8.0 / std::f64::consts::PI).sqrt();
    let time = 50.0;
    gas.advance(time, u64::MAX, &mut ())?;
    let found = gas.tally().collisions as f64;
    let expected = (own + hits) * time;
    found!(log; "{found} collisions, {expected:.0} expected");
    // Poisson, and the giant's hits see the mean speed of the dust, which fluctuates by
    // 0.4/sqrt(N).
    let error = 5.0 * (expected.sqrt() + expected * 0.4 / (dust as f64).sqrt());
    log.at_most("deviation", (found - expected).abs(), error);
    Ok(())
}

fn rare_species(log: &mut TrialLog) -> Done {
    let kinds = [
        (1.0, 1.0, 1000),
        (2.0, 8.0, 0),
        (3.0, 27.0, 1),
        (0.1, 0.001, 2),
    ];
    for restitution in [0.0, 1.0] {
        check_all_selections(log, &kinds, restitution, 1e4, [20_000; 3])?;
    }
    Ok(())
}

fn temperatures(log: &mut TrialLog) -> Done {
    let kinds = [(1.0, 1.0, 4000), (1.0, 2.0, 4000), (1.0, 4.0, 4000)];
    let mut gas =
        engine::<AliasTableSelection>(&kinds, 1.0, 1e5, |kind| 1e-6_f64.powi(kind as i32))?;
    check_energy_balance(log, "alias-tables", &mut gas, 600_000)?;
    let mean = 2.0 * gas.gas().kinetic_energy() / (3.0 * 12_000.0);
    for found in moments(gas.gas(), None, None) {
        let error = 5.0 * (2.0 / (3.0 * 4000.0_f64)).sqrt();
        log.at_most("temperature", (found.temperature / mean - 1.0).abs(), error);
    }
    Ok(())
}

fn cold(log: &mut TrialLog) -> Done {
    let mut gas = engine::<AliasTableSelection>(&[(1.0, 1.0, 100)], 0.9, 1e3, |_| 1.0)?;
    let stop = gas.advance(f64::INFINITY, 100_000_000, &mut ())?;
    let tally = gas.tally();
    found!(log; "{} collisions to energy {:.1e} at time {:.1e}", tally.collisions, gas.gas().kinetic_energy(), gas.time());
    must!(log, stop == StopReason::Still; "stopped by {stop:?}");
    must!(log, tally.collisions > 100_000; "too few collisions");
    Ok(())
}

fn one_cluster(log: &mut TrialLog) -> Done {
    let count = if log.effort.long { 1_000_000 } else { 20_000 };
    let always = |part| Threshold {
        limit: EnergyLimit::Energy(f64::INFINITY),
        part,
    };
    let rule = AggregationRule {
        stick: always(EnergyLoss::Full),
        shatter: always(EnergyLoss::Normal),
        order: TestOrder::StickFirst,
        retained: 0.0,
        most: count,
    };
    let sizes = Clusters::new(0.5, 1.0, 2, Vec::new())?;
    let scene: SmoothParticles<Plane, Clusters> = smooth_particles(law(0.5)?, sizes);
    let streams = Streams::new(19, 0);
    let mut start = streams.stream_at(Purpose::Velocities, [0, 0]);
    let volume = 100.0 * count as f64;
    let gas = HomogeneousGas::maxwellian(
        scene,
        PairCorrelationFactor::Dilute,
        volume,
        count,
        |_| 1.0,
        &mut start,
    )?;
    let contacts = Sticking::new(rule)?;
    let before = gas.kinetic_energy();
    let mut engine: HomogeneousEngine<_, AliasTableSelection, (), _> =
        HomogeneousEngine::new(gas, (), contacts, streams)?;
    let stop = engine.advance(f64::INFINITY, u64::MAX, &mut ())?;
    let sizes = size_distribution(engine.gas());
    found!(log; "{stop:?} at time {:.3e}: {sizes:?}", engine.time());
    must!(log, sizes == [(count as u32, 1)]; "{sizes:?}");
    let booked = engine.contacts().ledger.stuck + engine.gas().kinetic_energy();
    log.at_most(
        "energy not in the ledger",
        (booked / before - 1.0).abs(),
        1e-11,
    );
    let momentum = engine.gas().momentum().square().sqrt();
    log.at_most("momentum over sum m v", momentum / count as f64, 1e-11);
    Ok(())
}
