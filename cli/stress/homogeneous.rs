//! Gases without positions.

use stosszahl_dsmc::homogeneous::{
    Bird, Bounce, Contact, Engine, Gas, GasError, LowRank, Order, Part, Rule, Selection, Slots,
    Sticking, Stop, Tally, Threshold, size_distribution,
};
use stosszahl_model::random::{Purpose, Streams};
use stosszahl_model::{
    Clusters, Constant, Free, Kind, Plane, Scene, Smooth, Species, Vector, Volume,
};

use super::{Case, Effort, Findings, Trouble};

pub(super) const CASES: &[Case] = &[
    Case::new(
        "size-ratio",
        "spheres of diameters 1e-6 to 1 and masses 1e-18 to 1 at one temperature, by three selections",
        "bounds never exceeded, energy in the ledger to 1e-11, at most 4 pairs looked at for each collision (own)",
        size_ratio,
    ),
    Case::new(
        "giant",
        "one giant among 1e5 grains of dust, 1e7 long",
        "the giant is hit as often as kinetic theory says, within 5 standard errors",
        giant,
    ),
    Case::new(
        "rare-species",
        "species with no particle, one, and two beside a thousand; restitution 0 and 1",
        "bounds never exceeded, energy in the ledger to 1e-11",
        rare_species,
    ),
    Case::new(
        "temperatures",
        "species whose temperatures differ by 1e6 and 1e12, elastic, until they have mixed",
        "energy conserved to 1e-11 and shared alike at the end within 5 standard errors",
        temperatures,
    ),
    Case::new(
        "cold",
        "a hundred spheres cooling until their speeds are below what numbers can tell",
        "a stop that says so, after collisions by the ten thousand for each",
        cold,
    ),
    Case::new(
        "one-cluster",
        "sticking until one cluster is left: 2e4 disks, 1e6 long",
        "mass exact, momentum and energy ledger to 1e-11",
        one_cluster,
    ),
];

type Spheres = Scene<Volume, Smooth, Constant, Species, Free>;

fn coefficient(r: f64) -> Result<Constant, Trouble> {
    Constant::new(r).ok_or(Trouble::NoStart("restitution"))
}

/// A gas of species (diameter, mass, count), and an engine for it.
fn engine<S: Selection<Spheres>>(
    kinds: &[(f64, f64, usize)],
    restitution: f64,
    volume: f64,
    temperature: impl Fn(u32) -> f64,
) -> Result<Engine<Spheres, S>, Trouble> {
    let kinds = kinds.iter().map(|&(diameter, mass, count)| Kind {
        radius: 0.5 * diameter,
        mass,
        count,
    });
    let species = Species::new(kinds.collect()).ok_or(Trouble::NoStart("species"))?;
    let count = species.count();
    let scene = Scene {
        space: Volume,
        surface: Smooth,
        restitution: coefficient(restitution)?,
        sizes: species,
        field: Free,
    };
    let streams = Streams::new(17, 0);
    let mut start = streams.at(Purpose::Velocities, [0, 0]);
    let gas = Gas::maxwellian(
        scene,
        Contact::Dilute,
        volume,
        count,
        temperature,
        &mut start,
    )?;
    Ok(Engine::new(gas, (), Bounce, streams)?)
}

/// Runs for a number of collisions; checks the ledger.
fn booked<S: Selection<Spheres>>(
    engine: &mut Engine<Spheres, S>,
    collisions: u64,
    findings: &mut Findings,
) -> Result<Tally, GasError> {
    let start = engine.gas().kinetic_energy();
    engine.advance(f64::INFINITY, collisions, &mut ())?;
    let tally = *engine.tally();
    let end = engine.gas().kinetic_energy() + tally.energy_lost;
    // Ten thousand times a rounding: collisions round at random, the largest energies once each.
    findings.at_most("energy not in the ledger", (end / start - 1.0).abs(), 1e-11);
    let each = tally.trials as f64 / tally.collisions.max(1) as f64;
    findings.found(format!(
        "{}: {} collisions, {each:.2} pairs each, {} fits",
        S::NAME,
        tally.collisions,
        tally.rebuilds
    ));
    Ok(tally)
}

fn size_ratio(_: Effort, findings: &mut Findings) -> Result<(), Trouble> {
    let kinds: Vec<_> = (0..7)
        .map(|k| {
            let diameter = 10.0_f64.powi(-k);
            (diameter, diameter.powi(3), 300 << k)
        })
        .collect();
    let mut own = engine::<Slots>(&kinds, 0.9, 1e3, |_| 1.0)?;
    let tally = booked(&mut own, 200_000, findings)?;
    let each = tally.trials as f64 / tally.collisions as f64;
    findings.at_most("pairs looked at for each collision", each, 4.0);
    booked(
        &mut engine::<LowRank>(&kinds, 0.9, 1e3, |_| 1.0)?,
        20_000,
        findings,
    )?;
    booked(
        &mut engine::<Bird>(&kinds, 0.9, 1e3, |_| 1.0)?,
        2_000,
        findings,
    )?;
    Ok(())
}

fn giant(effort: Effort, findings: &mut Findings) -> Result<(), Trouble> {
    let dust = if effort.long { 10_000_000 } else { 100_000 };
    let volume = dust as f64;
    // Dust meets dust at 4 sqrt(pi) d^2 n N/2, and the giant at n pi ((D + d)/2)^2 sqrt(8/pi), T = m = n = 1.
    let (small, large) = (1e-4_f64, 20.0);
    let mut gas = engine::<Slots>(&[(small, 1.0, dust), (large, 1e9, 1)], 1.0, volume, |_| 1.0)?;
    let own = 2.0 * std::f64::consts::PI.sqrt() * small * small * dust as f64;
    let distance = 0.5 * (small + large);
    let hits = std::f64::consts::PI * distance * distance * (8.0 / std::f64::consts::PI).sqrt();
    let time = 50.0;
    gas.advance(time, u64::MAX, &mut ())?;
    let found = gas.tally().collisions as f64;
    let expected = (own + hits) * time;
    findings.found(format!("{found} collisions, {expected:.0} expected"));
    // Poisson, and the giant's hits see the mean speed of the dust, which fluctuates by 0.4/sqrt(N).
    let error = 5.0 * (expected.sqrt() + expected * 0.4 / (dust as f64).sqrt());
    findings.at_most("deviation", (found - expected).abs(), error);
    Ok(())
}

fn rare_species(_: Effort, findings: &mut Findings) -> Result<(), Trouble> {
    let kinds = [
        (1.0, 1.0, 1000),
        (2.0, 8.0, 0),
        (3.0, 27.0, 1),
        (0.1, 0.001, 2),
    ];
    for restitution in [0.0, 1.0] {
        booked(
            &mut engine::<Slots>(&kinds, restitution, 1e4, |_| 1.0)?,
            20_000,
            findings,
        )?;
        booked(
            &mut engine::<LowRank>(&kinds, restitution, 1e4, |_| 1.0)?,
            20_000,
            findings,
        )?;
        booked(
            &mut engine::<Bird>(&kinds, restitution, 1e4, |_| 1.0)?,
            20_000,
            findings,
        )?;
    }
    Ok(())
}

fn temperatures(_: Effort, findings: &mut Findings) -> Result<(), Trouble> {
    let kinds = [(1.0, 1.0, 4000), (1.0, 2.0, 4000), (1.0, 4.0, 4000)];
    let mut gas = engine::<Slots>(&kinds, 1.0, 1e5, |kind| 1e-6_f64.powi(kind as i32))?;
    booked(&mut gas, 600_000, findings)?;
    let mean = 2.0 * gas.gas().kinetic_energy() / (3.0 * 12_000.0);
    for found in stosszahl_dsmc::homogeneous::moments(gas.gas(), None, None) {
        let error = 5.0 * (2.0 / (3.0 * 4000.0_f64)).sqrt();
        findings.at_most("temperature", (found.temperature / mean - 1.0).abs(), error);
    }
    Ok(())
}

fn cold(_: Effort, findings: &mut Findings) -> Result<(), Trouble> {
    let mut gas = engine::<Slots>(&[(1.0, 1.0, 100)], 0.9, 1e3, |_| 1.0)?;
    let stop = gas.advance(f64::INFINITY, 100_000_000, &mut ())?;
    let tally = gas.tally();
    findings.found(format!(
        "{} collisions to energy {:.1e} at time {:.1e}",
        tally.collisions,
        gas.gas().kinetic_energy(),
        gas.time()
    ));
    findings.require(stop == Stop::Still, || format!("stopped by {stop:?}"));
    findings.require(tally.collisions > 100_000, || {
        "too few collisions".to_owned()
    });
    Ok(())
}

fn one_cluster(effort: Effort, findings: &mut Findings) -> Result<(), Trouble> {
    let count = if effort.long { 1_000_000 } else { 20_000 };
    let rule = Rule {
        stick: Threshold {
            energy: f64::INFINITY,
            part: Part::Full,
        },
        shatter: Threshold {
            energy: f64::INFINITY,
            part: Part::Normal,
        },
        order: Order::StickFirst,
        retained: 0.0,
        most: count,
    };
    let scene = Scene {
        space: Plane,
        surface: Smooth,
        restitution: coefficient(0.5)?,
        sizes: Clusters::new(0.5, 1.0, 2, Vec::new()).ok_or(Trouble::NoStart("clusters"))?,
        field: Free,
    };
    let streams = Streams::new(19, 0);
    let mut start = streams.at(Purpose::Velocities, [0, 0]);
    let volume = 100.0 * count as f64;
    let gas = Gas::maxwellian(scene, Contact::Dilute, volume, count, |_| 1.0, &mut start)?;
    let contacts = Sticking::new(rule).ok_or(Trouble::NoStart("rule"))?;
    let before = gas.kinetic_energy();
    let mut engine: Engine<_, Slots, (), _> = Engine::new(gas, (), contacts, streams)?;
    let stop = engine.advance(f64::INFINITY, u64::MAX, &mut ())?;
    let sizes = size_distribution(engine.gas());
    findings.found(format!("{stop:?} at time {:.3e}: {sizes:?}", engine.time()));
    findings.require(sizes == [(count as u32, 1)], || format!("{sizes:?}"));
    let booked = engine.contacts().ledger.stuck + engine.gas().kinetic_energy();
    findings.at_most(
        "energy not in the ledger",
        (booked / before - 1.0).abs(),
        1e-11,
    );
    let momentum = engine.gas().momentum().square().sqrt();
    findings.at_most("momentum over sum m v", momentum / count as f64, 1e-11);
    Ok(())
}
