//! Tests of the gas without positions: exact pair rates, conservation laws, bytes, theory.

use std::f64::consts::PI;

use stosszahl_homogeneous::{
    AggregationRule, AliasTableSelection, Bird, Bounce, ContactRule, DisplacementRecord,
    EnergyLimit, EnergyLoss, HomogeneousEngine, HomogeneousGas, LowRank, PairCorrelationFactor,
    SelectionMethod, Sticking, StopReason, TestOrder, Threshold, Tracers, Trajectories, moments,
    shards, size_distribution, time_averaged,
};
use stosszahl_model::random::{Purpose, Stream, Streams};
use stosszahl_model::samples::{SmoothParticles, equal, law, smooth_particles, species};
use stosszahl_model::{
    Clusters, Law, PerPair, Plane, Polydisperse, Space, Species, Vector, Viscoelastic, Volume,
};
use stosszahl_theory::{Component, ContactValues, CoolingState, MaxwellianMixture};

fn stream(seed: u64) -> Stream {
    Streams::new(seed, 0).stream_at(Purpose::Velocities, [0, 0])
}

/// Radii from 0.1 to 10, some equal and some nearly equal.
fn uneven() -> Polydisperse {
    let sizes = [
        (0.1, 0.01),
        (0.5, 1.0),
        (0.5, 2.0),
        (0.51, 1.0),
        (0.52, 1.1),
        (1.0, 8.0),
        (3.0, 100.0),
        (10.0, 3000.0),
    ];
    Polydisperse::new(sizes.to_vec()).expect("sizes")
}

/// Upper quantile of chi-squared at a false alarm rate of 1e-6, by Wilson & Hilferty.
fn chi_squared_limit(degrees: f64) -> f64 {
    let a = 2.0 / (9.0 * degrees);
    degrees * (1.0 - a + 4.753 * a.sqrt()).powi(3)
}

/// The next pair and its time follow the exact rates `k g` of all pairs, from a selection that has
/// been in use for a few collisions, so that some of its places are stale and some bounds raised.
fn pairs_follow_their_rates<S: Space, Pick: SelectionMethod<SmoothParticles<S, Polydisperse>>>(
    used: u64,
) {
    let gas = HomogeneousGas::maxwellian(
        smooth_particles::<S, _>(law(0.6), uneven()),
        PairCorrelationFactor::Dilute,
        1000.0,
        8,
        |_| 1.0,
        &mut stream(11),
    )
    .expect("a gas");
    let mut engine: HomogeneousEngine<_, Pick> =
        HomogeneousEngine::new(gas, (), Bounce, Streams::new(5, 0)).expect("an engine");
    assert_eq!(
        engine.advance(f64::INFINITY, used, &mut ()).expect("runs"),
        StopReason::Collisions
    );
    let kernel = *engine.gas().kernel();
    let before: Vec<_> = engine.gas().alive().copied().collect();
    let count = before.len();
    let mut rates = vec![0.0; count * count];
    for i in 0..count {
        for j in 0..i {
            let radius = |index: usize| engine.gas().radius(&before[index]);
            rates[i * count + j] = kernel.rate_coefficient(radius(i), radius(j))
                * (before[i].velocity - before[j].velocity).square().sqrt();
        }
    }
    let total: f64 = rates.iter().sum();
    let tries = 60_000_u64;
    let mut found = vec![0.0; count * count];
    let mut waited = 0.0;
    let checkpoint = engine.checkpoint();
    for number in 0..tries {
        let mut next = HomogeneousEngine::resume(
            engine.gas().scene().clone(),
            checkpoint.clone(),
            Streams::new(number, 9),
        );
        next.advance(f64::INFINITY, 1, &mut ()).expect("runs");
        waited += next.time() - engine.time();
        let changed: Vec<usize> = next
            .gas()
            .alive()
            .enumerate()
            .filter(|(index, after)| after.velocity != before[*index].velocity)
            .map(|(index, _)| index)
            .collect();
        assert_eq!(changed.len(), 2);
        found[changed[1] * count + changed[0]] += 1.0;
    }
    let n = tries as f64;
    // Waiting times are exponential: z = 4.75, a false alarm in 1e6.
    let mean = waited / n * total;
    assert!(
        (mean - 1.0).abs() < 4.75 / n.sqrt(),
        "{} waits {mean}",
        Pick::NAME
    );
    let (mut chi, mut bins, mut rest) = (0.0, 0.0, (0.0, 0.0));
    for (rate, found) in rates.iter().zip(&found) {
        let expected = n * rate / total;
        if expected > 10.0 {
            chi += (found - expected) * (found - expected) / expected;
            bins += 1.0;
        } else {
            rest = (rest.0 + expected, rest.1 + found);
        }
    }
    assert!(bins > 10.0, "too few pairs to tell");
    assert!(
        rest.1 <= rest.0 + 5.0 * (rest.0 + 1.0).sqrt() + 5.0,
        "rare pairs {rest:?}"
    );
    let limit = chi_squared_limit(bins - 1.0);
    assert!(chi < limit, "{} {chi} of {bins} after {used}", Pick::NAME);
}

#[test]
fn selections_follow_the_rates_of_all_pairs() {
    for used in [0, 7] {
        pairs_follow_their_rates::<Volume, AliasTableSelection>(used);
        pairs_follow_their_rates::<Volume, LowRank>(used);
        pairs_follow_their_rates::<Volume, Bird>(used);
        pairs_follow_their_rates::<Plane, AliasTableSelection>(used);
        pairs_follow_their_rates::<Plane, LowRank>(used);
        pairs_follow_their_rates::<Plane, Bird>(used);
    }
}

fn always_stick() -> Sticking {
    let rule = AggregationRule {
        stick: Threshold {
            limit: EnergyLimit::Energy(f64::INFINITY),
            part: EnergyLoss::Full,
        },
        shatter: Threshold {
            limit: EnergyLimit::Energy(f64::INFINITY),
            part: EnergyLoss::Normal,
        },
        order: TestOrder::StickFirst,
        retained: 0.5,
        most: 1 << 30,
    };
    Sticking::new(rule).expect("a rule")
}

/// Mergers follow the exact rates in a gas in which three pairs have stuck together: clusters of
/// 2^k monomers, so that the next one's number tells which two it is made of.
fn mergers_follow_their_rates<Pick: SelectionMethod<SmoothParticles<Volume, Clusters>>>() {
    let start = (0..10).map(|k| 1 << k).collect();
    let sizes = Clusters::new(0.5, 1.0, 3, start).expect("clusters");
    let gas = HomogeneousGas::maxwellian(
        smooth_particles::<Volume, _>(law(0.6), sizes),
        PairCorrelationFactor::Dilute,
        1000.0,
        10,
        |_| 1.0,
        &mut stream(3),
    )
    .expect("a gas");
    let mut engine: HomogeneousEngine<_, Pick, (), Sticking> =
        HomogeneousEngine::new(gas, (), always_stick(), Streams::new(6, 0)).expect("an engine");
    engine.advance(f64::INFINITY, 3, &mut ()).expect("runs");
    let kernel = *engine.gas().kernel();
    let before: Vec<_> = engine.gas().alive().copied().collect();
    assert_eq!(before.len(), 7);
    let mut rates = std::collections::BTreeMap::new();
    for (i, one) in before.iter().enumerate() {
        for other in &before[..i] {
            let radius = |particle| engine.gas().radius(particle);
            let speed = (one.velocity - other.velocity).square().sqrt();
            let rate = kernel.rate_coefficient(radius(one), radius(other)) * speed;
            rates.insert(one.tag + other.tag, (rate, 0.0));
        }
    }
    let total: f64 = rates.values().map(|pair| pair.0).sum();
    let tries = 40_000_u64;
    let checkpoint = engine.checkpoint();
    for number in 0..tries {
        let scene = engine.gas().scene().clone();
        let mut next =
            HomogeneousEngine::resume(scene, checkpoint.clone(), Streams::new(number, 8));
        next.advance(f64::INFINITY, 1, &mut ()).expect("runs");
        let new = next
            .gas()
            .alive()
            .map(|particle| particle.tag)
            .find(|tag| before.iter().all(|old| old.tag != *tag))
            .expect("a new cluster");
        rates.get_mut(&new).expect("made of two old ones").1 += 1.0;
    }
    let n = tries as f64;
    let (mut chi, mut bins) = (0.0, 0.0);
    for (rate, found) in rates.values() {
        let expected = n * rate / total;
        if expected > 10.0 {
            chi += (found - expected) * (found - expected) / expected;
            bins += 1.0;
        }
    }
    assert!(
        bins > 10.0 && chi < chi_squared_limit(bins - 1.0),
        "{} {chi} of {bins}",
        Pick::NAME
    );
}

#[test]
fn selections_stay_exact_while_particles_stick() {
    mergers_follow_their_rates::<AliasTableSelection>();
    mergers_follow_their_rates::<LowRank>();
    mergers_follow_their_rates::<Bird>();
}

/// Species of mass k, compact in three dimensions, with `floor(first k^-theta)` particles each.
fn powers(first: f64, theta: i32, most: u32) -> Species {
    species((1..=most).map(|k| {
        let k = f64::from(k);
        let count = (first * k.powi(-theta) + 1e-9).floor();
        (0.5 * k.cbrt(), k, count as usize)
    }))
}

fn table<Pick: SelectionMethod<SmoothParticles<Volume, Species>>>(
    seed: u64,
) -> HomogeneousEngine<SmoothParticles<Volume, Species>, Pick> {
    let species = powers(3e4, 3, 31);
    let count = species.count();
    let gas = HomogeneousGas::maxwellian(
        smooth_particles::<Volume, _>(law(0.5), species),
        PairCorrelationFactor::Dilute,
        3e5,
        count,
        |_| 1.0,
        &mut stream(seed),
    )
    .expect("a gas");
    let mut engine =
        HomogeneousEngine::new(gas, (), Bounce, Streams::new(seed, 0)).expect("an engine");
    engine.advance(20.0, u64::MAX, &mut ()).expect("runs");
    engine
}

/// Three selections give equal collision numbers and energies at t = 20. Between runs the number of
/// collisions C varies by about 0.4 sqrt(C), and the energy by 0.4/sqrt(N) (measured with 12
/// seeds); tolerance: five times the scatter of a difference.
#[test]
fn selections_agree_on_a_polydisperse_gas() {
    let (own, low, bird) = (
        table::<AliasTableSelection>(1),
        table::<LowRank>(2),
        table::<Bird>(3),
    );
    let of = |collisions: u64, energy: f64| (collisions as f64, energy);
    let results = [
        of(own.tally().collisions, own.gas().kinetic_energy()),
        of(low.tally().collisions, low.gas().kinetic_energy()),
        of(bird.tally().collisions, bird.gas().kinetic_energy()),
    ];
    let n = own.gas().count() as f64;
    for other in &results[1..] {
        let scatter = 5.0 * 1.5;
        assert!(
            (other.0 - results[0].0).abs() < scatter * other.0.sqrt(),
            "{results:?}"
        );
        assert!(
            (other.1 / results[0].1 - 1.0).abs() < scatter / n.sqrt(),
            "{results:?}"
        );
    }
    // Counters of work, independent of the machine.
    let tally = own.tally();
    let each = |count: u64| count as f64 / tally.collisions as f64;
    assert!(each(tally.trials) < 1.55, "{}", each(tally.trials));
    assert!(each(tally.proposals) < 2.1, "{}", each(tally.proposals));
    assert!(own.memory_bytes() as f64 / n < 64.0);
    // Energy lost is recorded, to one rounding per collision.
    let start = 0.5 * 3.0 * n;
    let booked = own.gas().kinetic_energy() + tally.energy_lost;
    let rounding = 1e-15 * (tally.collisions as f64).sqrt() * 10.0;
    let rare = 3.0 * 31.0 * 3.0 / start;
    assert!(
        (booked / start - 1.0).abs() < rounding + rare,
        "{booked} {start}"
    );
}

#[test]
fn momentum_is_conserved_and_bytes_are_repeatable() {
    let make = || {
        let species = powers(3e3, 3, 14);
        let count = species.count();
        let laws = (0..14 * 14).map(|pair| law(0.4 + 0.003 * f64::from(pair)));
        let laws = PerPair::new(14, laws.collect()).expect("a table");
        let gas = HomogeneousGas::maxwellian(
            smooth_particles::<Volume, _>(laws, species),
            PairCorrelationFactor::Enskog,
            3e4,
            count,
            |kind| 1.0 + f64::from(kind),
            &mut stream(4),
        )
        .expect("a gas");
        let paths = DisplacementRecord::new(count, 0.0);
        HomogeneousEngine::<_, AliasTableSelection, _>::new(gas, paths, Bounce, Streams::new(8, 0))
            .expect("an engine")
    };
    let mut whole = make();
    let momentum = |engine: &HomogeneousEngine<_, AliasTableSelection, DisplacementRecord<_>>| {
        let gas: &HomogeneousGas<SmoothParticles<Volume, Species>> = engine.gas();
        gas.momentum().square().sqrt()
    };
    assert!(momentum(&whole) < 1e-10);
    whole.advance(2.0, u64::MAX, &mut ()).expect("runs");
    let half = postcard::to_stdvec(&whole.checkpoint()).expect("serialises");
    whole.advance(7.0, u64::MAX, &mut ()).expect("runs");
    assert!(whole.tally().collisions > 10_000);
    // One rounding of the largest momenta per collision, random in sign.
    assert!(momentum(&whole) < 1e-10);
    let mut resumed = HomogeneousEngine::<_, AliasTableSelection, DisplacementRecord<_>>::resume(
        whole.gas().scene().clone(),
        postcard::from_bytes(&half).expect("reads"),
        Streams::new(8, 0),
    );
    resumed.advance(7.0, u64::MAX, &mut ()).expect("runs");
    let bytes = |engine: &HomogeneousEngine<_, AliasTableSelection, DisplacementRecord<_>>| {
        postcard::to_stdvec(&engine.checkpoint()).expect("serialises")
    };
    assert_eq!(bytes(&whole), bytes(&resumed));
}

/// Equal particles in two and three dimensions follow Haff's law and its closed forms, including
/// elastic displacements, within z = 4.4 standard errors. That of energy is sqrt(2/(D N)) times the
/// fraction that is still random (all of it, as an upper bound). That of a mean squared
/// displacement is sqrt(2/(D N)) in the Gaussian case, doubled.
fn haff<S: Space>() {
    let (count, r) = (40_000, 0.8);
    let d = S::DIMENSION as f64;
    let density = 0.1;
    let gas = HomogeneousGas::maxwellian(
        equal::<S>(r),
        PairCorrelationFactor::Enskog,
        count as f64 / density,
        count,
        |_| 1.0,
        &mut stream(21),
    )
    .expect("a gas");
    let paths = DisplacementRecord::new(count, 0.0);
    let mut engine: HomogeneousEngine<_, AliasTableSelection, _> =
        HomogeneousEngine::new(gas, paths, Bounce, Streams::new(2, 0)).expect("an engine");
    let one = Component {
        mass: 1.0,
        diameter: 1.0,
        density,
    };
    let mixture = MaxwellianMixture::new(S::DIMENSION, vec![one], law(r), ContactValues::Enskog)
        .expect("a gas");
    let state = CoolingState::at_temperature(&mixture, 1.0).expect("it cools");
    let a2 = stosszahl_theory::cooling::fourth_cumulant(S::DIMENSION, r);
    let error = (2.0 / (d * count as f64)).sqrt();
    for tau in [1.0, 4.0] {
        let time = tau * state.time;
        engine.advance(time, u64::MAX, &mut ()).expect("runs");
        let found = moments(engine.gas(), Some((engine.motion(), time)), None)[0];
        let haff = stosszahl_theory::cooling::haff_law(tau, a2);
        // The start is Maxwellian, not yet of this a2: 2e-3 more.
        assert!(
            (found.temperature / haff - 1.0).abs() < 4.4 * error + 2e-3,
            "{found:?} {haff}"
        );
        let displacement = state.displacement(0, 0.0, time);
        // First Sonine order, with a2 left out: |a2| more.
        assert!(
            (found.displacement / displacement - 1.0).abs() < 8.8 * error + a2.abs(),
            "{found:?} {displacement}"
        );
        let collisions = 2.0 * engine.tally().collisions as f64 / count as f64;
        let expected = stosszahl_theory::cooling::haff_collisions(S::DIMENSION, r, tau);
        // Pair collisions are Poisson at fixed temperature; the temperature's own error adds as
        // much.
        let scatter = 8.8 / (0.5 * collisions * count as f64).sqrt() + 2.0 * error;
        assert!(
            (collisions / expected - 1.0).abs() < scatter + 3e-3,
            "{collisions} {expected}"
        );
        // sqrt(24/N) in the plane is an upper bound of the standard error of a2.
        let noise = 4.4 * (24.0 / count as f64).sqrt() / 2.0;
        assert!((found.fourth_cumulant - a2).abs() < noise, "{found:?} {a2}");
    }
}

#[test]
fn equal_particles_cool_and_spread_as_haff_says() {
    haff::<Plane>();
    haff::<Volume>();
}

/// Mixtures of two and three species from equal temperatures follow the kinetic equations in Sonine
/// expansion, for constant and viscoelastic restitution. Includes mass ratios of a hundred and low
/// restitution, so that velocities are far from Maxwellian.
#[test]
fn mixtures_cool_and_spread_as_the_equations_say() {
    let solid = |mass: f64, count| (0.5 * mass.cbrt(), mass, count);
    let viscoelastic = |strength| Law::from(Viscoelastic::new(strength).expect("positive"));
    let two = [solid(1.0, 20_000), solid(3.0, 20_000)];
    mixture_case(&two, law(0.9), 4);
    let three = [solid(1.0, 20_000), solid(2.0, 20_000), solid(4.0, 20_000)];
    mixture_case(&three, viscoelastic(0.2), 3);
    mixture_case(&[(0.5, 1.0, 40_000), (0.5, 100.0, 40_000)], law(0.5), 6);
    mixture_case(
        &[solid(1.0, 40_000), solid(100.0, 40_000)],
        viscoelastic(0.3),
        4,
    );
}

/// Temperatures, displacements and fourth cumulants at three times. Tolerance: the change by the
/// last Sonine order, and 4.75 standard errors, a false alarm in 1e6 each: of a temperature
/// `sqrt(2 (1 + 5 a2/2)/(3 N))`, of a mean squared displacement `sqrt(2/(3 N))` times 1.5 for its
/// heavier tails, of a2 `sqrt(8/(15 N))` times 1.5.
fn mixture_case(parts: &[(f64, f64, usize)], law: Law, orders: usize) {
    let species = species(parts.iter().copied());
    let count = species.count();
    let volume = parts[0].2 as f64 / 0.1;
    let gas = HomogeneousGas::maxwellian(
        smooth_particles::<Volume, _>(law.clone(), species),
        PairCorrelationFactor::Dilute,
        volume,
        count,
        |_| 1.0,
        &mut stream(5),
    )
    .expect("a gas");
    let paths = DisplacementRecord::new(count, 0.0);
    let mut engine: HomogeneousEngine<_, AliasTableSelection, _> =
        HomogeneousEngine::new(gas, paths, Bounce, Streams::new(3, 0)).expect("an engine");
    let components = parts
        .iter()
        .map(|&(radius, mass, count)| Component {
            mass,
            diameter: 2.0 * radius,
            density: count as f64 / volume,
        })
        .collect();
    let mixture =
        MaxwellianMixture::new(3, components, law, ContactValues::Dilute).expect("a mixture");
    let (times, start) = ([1.0, 10.0, 100.0], vec![1.0; parts.len()]);
    let curves = |orders| mixture.expand(orders, &start, &times).expect("smooth");
    for (curve, below) in curves(orders).into_iter().zip(curves(orders - 1)) {
        engine.advance(curve.time, u64::MAX, &mut ()).expect("runs");
        let found = moments(engine.gas(), Some((engine.motion(), curve.time)), None);
        for (k, found) in found.iter().enumerate() {
            let n = parts[k].2 as f64;
            let thermal = (2.0 / (3.0 * n)).sqrt();
            let at = curve.time;
            let check = |what: &str, found: f64, curve: f64, below: f64, error: f64| {
                let (off, left) = ((found - curve).abs(), (curve - below).abs());
                assert!(
                    off < left + 4.75 * error,
                    "{what} of {k} at {at}: {found} {curve} {below}"
                );
                assert!(
                    left < 2.0 * error.max(0.005 * curve.abs()),
                    "{what} {curve} {below}"
                );
            };
            let (t, r) = (curve.temperatures[k], curve.displacements[k]);
            let spread = (1.0 + 2.5 * curve.fourth_cumulants[k]).sqrt();
            check(
                "T",
                found.temperature,
                t,
                below.temperatures[k],
                t * thermal * spread,
            );
            let below_r = below.displacements[k];
            check("R^2", found.displacement, r, below_r, 1.5 * r * thermal);
            let (a2, below_a2) = (curve.fourth_cumulants[k], below.fourth_cumulants[k]);
            let error = 1.5 * (8.0 / (15.0 * n)).sqrt();
            check("a2", found.fourth_cumulant, a2, below_a2, error);
        }
    }
}

/// Tracers respond to the bath but do not affect it; paths, velocities and their time averages
/// agree with closed forms.
#[test]
fn tracers_follow_the_tracer_limit() {
    let kinds = [(1.0_f64, 40_000), (10.0, 4000)];
    let species = species(kinds.map(|(mass, count)| (0.5 * mass.cbrt(), mass, count)));
    let count = species.count();
    let components = [(1.0_f64, 0.1), (10.0, 0.0)].map(|(mass, density)| Component {
        mass,
        diameter: mass.cbrt(),
        density,
    });
    let mixture = MaxwellianMixture::new(3, components.to_vec(), law(0.9), ContactValues::Dilute)
        .expect("a mixture");
    let state = CoolingState::at_temperature(&mixture, 1.0).expect("it cools");
    let gas = HomogeneousGas::maxwellian(
        smooth_particles::<Volume, _>(law(0.9), species),
        PairCorrelationFactor::Dilute,
        4e5,
        count,
        |kind| state.temperatures[kind as usize],
        &mut stream(6),
    )
    .expect("a gas");
    let start: Vec<_> = gas.alive().map(|particle| particle.velocity).collect();
    let chosen: Vec<u32> = (0..1000).map(|i| i * 40).chain(40_000..44_000).collect();
    let motion = (
        DisplacementRecord::new(count, 0.0),
        Trajectories::new(count, &chosen, 0.0),
    );
    let mut engine: HomogeneousEngine<_, AliasTableSelection, _, _> =
        HomogeneousEngine::new(gas, motion, Tracers { kind: 1 }, Streams::new(7, 0))
            .expect("an engine");
    engine.advance(3.0, u64::MAX, &mut ()).expect("runs");
    let early = moments(engine.gas(), None, Some(&start));
    engine.advance(300.0, u64::MAX, &mut ()).expect("runs");
    let end = engine.time();
    let found = moments(engine.gas(), Some((&engine.motion().0, end)), None);
    // The tracers do not affect the bath: its momentum stays zero.
    let bath = engine.gas().alive().filter(|particle| particle.tag == 0);
    let mut drift = <Volume as Space>::Vector::default();
    for particle in bath {
        drift += particle.velocity;
    }
    assert!(drift.square().sqrt() < 1e-10, "{drift}");
    // 4.4 standard errors of 4000 tracers (2.6 % each for Gaussian displacements in three
    // dimensions, with 4 % in all for the bath's departure from Maxwell).
    let error = |n: f64| 4.4 * (2.0 / (3.0 * n)).sqrt();
    for (k, n) in [(0, 4e4), (1, 4e3)] {
        let spread = found[k].displacement / state.displacement(k, 0.0, end);
        assert!((spread - 1.0).abs() < error(n) + 0.04, "{k}: {spread}");
    }
    let memory = early[1].velocity_correlation / state.velocity_correlation(1, 3.0);
    assert!((memory - 1.0).abs() < error(4e3) + 0.04, "{memory}");
    for lag in [1.0, 30.0] {
        let mut sum = 0.0;
        for (path, &index) in chosen.iter().enumerate().skip(1000) {
            let mut corners = engine.motion().1.corners(path).to_vec();
            let particle = engine.gas().alive().nth(index as usize).expect("there");
            let last = engine
                .motion()
                .0
                .displacement_at(index as usize, &particle.velocity, end);
            corners.push((end, last));
            sum += time_averaged(&corners, lag);
        }
        let ratio = sum / 4000.0 / state.time_averaged(1, lag, end);
        assert!(
            (ratio - 1.0).abs() < error(4e3) + 0.04,
            "lag {lag}: {ratio}"
        );
    }
}

/// Shattering conserves momentum and energy, over a million fragments and at extreme speeds.
/// Tolerance: rounding, 1e-12.
#[test]
fn shards_have_no_momentum_and_the_energy_asked_for() {
    let mut stream = stream(9);
    for (pieces, square) in [(2, 1.0), (3, 1e-20), (10, 1e20), (1_000_000, 2.0)] {
        for _ in 0..(1_000_000 / pieces).min(2000) {
            let shards = shards::<Volume>(pieces, square, &mut stream);
            let energy: f64 = shards.iter().map(Vector::square).sum();
            let n = f64::from(pieces);
            assert!((energy / (n * square) - 1.0).abs() < 1e-12);
            let mut sum = <Volume as Space>::Vector::default();
            for shard in &shards {
                sum += *shard;
            }
            assert!(sum.square().sqrt() < 1e-12 * n * square.sqrt());
        }
    }
    // Uniform on the manifold: <u_i . u_j> = -u^2/(K - 1).
    let mut product = 0.0;
    let tries = 20_000;
    for _ in 0..tries {
        let shards = shards::<Plane>(4, 1.0, &mut stream);
        product += shards[0].inner(&shards[1]);
    }
    // The standard error is below 1/sqrt(tries); z = 4.4.
    let mean = product / f64::from(tries);
    assert!(
        (mean + 1.0 / 3.0).abs() < 4.4 / f64::from(tries).sqrt(),
        "{mean}"
    );
}

fn clusters<C: ContactRule<SmoothParticles<S, Clusters>>, S: Space>(
    count: usize,
    density: f64,
    contacts: C,
) -> HomogeneousEngine<SmoothParticles<S, Clusters>, AliasTableSelection, (), C> {
    let sizes = Clusters::new(0.5, 1.0, S::DIMENSION, Vec::new()).expect("clusters");
    let gas = HomogeneousGas::maxwellian(
        smooth_particles::<S, _>(law(0.5), sizes),
        PairCorrelationFactor::Dilute,
        count as f64 / density,
        count,
        |_| 1.0,
        &mut stream(31),
    )
    .expect("a gas");
    HomogeneousEngine::new(gas, (), contacts, Streams::new(13, 0)).expect("an engine")
}

/// Number and energy of a gas in which all collisions merge, against runs of another code with 2e5
/// particles, accurate to 1 or 2 %.
#[test]
fn aggregation_decays_as_measured_elsewhere() {
    let count = 60_000;
    let mut space = clusters::<_, Volume>(count, 0.01, always_stick());
    for (time, number, energy) in [
        (10.0, 0.737, 0.665),
        (31.6, 0.466, 0.361),
        (100.0, 0.2137, 0.1279),
        (316.0, 0.0764, 0.0337),
    ] {
        space.advance(time, u64::MAX, &mut ()).expect("runs");
        let n = space.gas().count() as f64 / count as f64;
        let e = space.gas().kinetic_energy() / (1.5 * count as f64);
        // 2 %, and 4.4/sqrt of the remaining number of clusters.
        let error = 0.02 + 4.4 * 0.5 / (n * count as f64).sqrt();
        assert!((n / number - 1.0).abs() < error, "{time}: {n} {number}");
        assert!(
            (e / energy - 1.0).abs() < 2.0 * error,
            "{time}: {e} {energy}"
        );
    }
    let mut plane = clusters::<_, Plane>(count, 0.01, always_stick());
    for (time, number, energy) in [(10.0, 0.852, 0.783), (100.0, 0.383, 0.237)] {
        plane.advance(time, u64::MAX, &mut ()).expect("runs");
        let n = plane.gas().count() as f64 / count as f64;
        let e = plane.gas().kinetic_energy() / count as f64;
        let error = 0.02 + 4.4 * 0.5 / (n * count as f64).sqrt();
        assert!((n / number - 1.0).abs() < error, "{time}: {n} {number}");
        assert!(
            (e / energy - 1.0).abs() < 2.0 * error,
            "{time}: {e} {energy}"
        );
    }
}

#[test]
fn sticking_ends_with_one_cluster() {
    let count = 3000;
    let mut engine = clusters::<_, Volume>(count, 0.05, always_stick());
    let start = engine.gas().kinetic_energy();
    assert_eq!(
        engine
            .advance(f64::INFINITY, u64::MAX, &mut ())
            .expect("runs"),
        StopReason::Still
    );
    assert_eq!(size_distribution(engine.gas()), [(count as u32, 1)]);
    assert!(engine.gas().momentum().square().sqrt() < 1e-9);
    // All initial energy is in the ledger, to one rounding per merger.
    let booked = engine.contacts().ledger.stuck + engine.gas().kinetic_energy();
    assert!((booked / start - 1.0).abs() < 1e-12);
    assert_eq!(engine.contacts().ledger.mergers, count as u64 - 1);
}

/// Sticking and breaking together: mass, momentum and the energy ledger balance, and numbers reach
/// a steady state without driving: fast pairs break, slow ones stick.
#[test]
fn breaking_closes_the_ledgers() {
    let mut rule = always_stick().rule;
    rule.stick.limit = EnergyLimit::Energy(0.2);
    rule.shatter.limit = EnergyLimit::Energy(1.0);
    rule.retained = 0.9;
    let contacts = Sticking::new(rule).expect("a rule");
    let count = 5000;
    let mut engine = clusters::<_, Volume>(count, 0.05, contacts);
    let start = engine.gas().kinetic_energy();
    engine.advance(200.0, u64::MAX, &mut ()).expect("runs");
    let ledger = engine.contacts().ledger;
    assert!(
        ledger.mergers > 1000 && ledger.shatterings > 100,
        "{ledger:?}"
    );
    let mass: u64 = size_distribution(engine.gas())
        .iter()
        .map(|&(monomers, number)| u64::from(monomers) * number)
        .sum();
    assert_eq!(mass, count as u64);
    assert!(engine.gas().momentum().square().sqrt() < 1e-9);
    let booked = engine.gas().kinetic_energy()
        + ledger.stuck
        + ledger.shattered
        + engine.tally().energy_lost;
    assert!((booked / start - 1.0).abs() < 1e-12, "{booked} {start}");
}

/// Extreme gases neither fail nor hang: no particle, one, all at rest, one giant among tiny ones,
/// restitution zero, a species at a millionth of the other's temperature.
#[test]
fn extreme_gases_run() {
    let run = |kinds: &[(f64, f64, usize)], r: f64, until: f64, temperature: fn(u32) -> f64| {
        let species = species(kinds.iter().copied());
        let count = species.count();
        let gas = HomogeneousGas::maxwellian(
            smooth_particles::<Volume, _>(law(r), species),
            PairCorrelationFactor::Dilute,
            1e3 * PI,
            count,
            temperature,
            &mut stream(12),
        )
        .expect("a gas");
        let mut engine: HomogeneousEngine<_, AliasTableSelection> =
            HomogeneousEngine::new(gas, (), Bounce, Streams::new(1, 1)).expect("an engine");
        let stop = engine.advance(until, 300_000, &mut ()).expect("runs");
        (stop, *engine.tally())
    };
    assert_eq!(
        run(&[(0.5, 1.0, 0)], 0.5, 10.0, |_| 1.0).0,
        StopReason::Still
    );
    assert_eq!(
        run(&[(0.5, 1.0, 1), (1.0, 1.0, 0)], 0.5, 10.0, |_| 1.0).0,
        StopReason::Still
    );
    assert_eq!(
        run(&[(0.5, 1.0, 50)], 0.5, f64::INFINITY, |_| 0.0).0,
        StopReason::Still
    );
    let (stop, tally) = run(&[(1e-5, 1e-15, 20_000), (10.0, 1e3, 1)], 0.9, 1e-5, |_| 1.0);
    assert_eq!((stop, tally.collisions), (StopReason::Collisions, 300_000));
    assert!(
        (tally.trials as f64) < 3.0 * tally.collisions as f64,
        "{tally:?}"
    );
    let (_, tally) = run(&[(0.5, 1.0, 1000), (0.6, 1.0, 1)], 0.0, 1e4, |_| 1.0);
    assert!(tally.collisions > 1000);
    let (_, tally) = run(&[(0.5, 1.0, 1000), (0.5, 1.0, 1000)], 1.0, 100.0, |kind| {
        if kind == 0 { 1.0 } else { 1e-6 }
    });
    assert!(tally.collisions > 1000);
}
