//! Displacements across the periodic box: both engines against closed forms and against the
//! diffusion of Enskog.

use nalgebra::{Vector2, vector};
use stosszahl_dsmc::{
    DsmcEngine, Neighbourhood, Parameters, PartnerDisplacement, Scheme, SimulatorStart, Tracked,
};
use stosszahl_ed::{DissipationRule, EventDrivenCheckpoint, EventDrivenEngine as EventDriven};
use stosszahl_model::equation_of_state;
use stosszahl_model::initial::Arrangement;
use stosszahl_model::random::Streams;
use stosszahl_model::samples::{EqualDisks, FallingDisks, disks};
use stosszahl_model::{Domain, State, samples};
use stosszahl_theory::{cooling, diffusion};

use crate::support::{as_kinds, gas, kinds, mean_and_error};

/// Creates equal disks as one species.
fn equal(restitution: f64, count: usize) -> FallingDisks {
    kinds(restitution, [(0.5, 1.0, count)])
}

fn tracked(state: State<EqualDisks>) -> EventDrivenCheckpoint<EqualDisks> {
    let image_flags = vec![[0; 2]; state.bodies.len()];
    EventDrivenCheckpoint {
        image_flags,
        ..state.into()
    }
}

/// Returns positions of disks that were never wrapped.
fn unwrapped(gas: &EventDrivenCheckpoint<EqualDisks>) -> Vec<Vector2<f64>> {
    let lengths = gas.state.domain.lengths();
    let winding = |w: &[i32; 2]| vector![f64::from(w[0]), f64::from(w[1])].component_mul(&lengths);
    let bodies = gas.state.bodies.iter().zip(&gas.image_flags);
    bodies.map(|(body, w)| body.position + winding(w)).collect()
}

fn leg(
    gas: EventDrivenCheckpoint<EqualDisks>,
    restitution: f64,
    until: f64,
) -> EventDrivenCheckpoint<EqualDisks> {
    let mut engine =
        EventDriven::<_>::new(disks(restitution), DissipationRule::Scene, gas).expect("an engine");
    assert!(engine.advance(until, u64::MAX, &mut ()).expect("a leg"));
    engine.checkpoint()
}

/// Disks in separate lanes move by v t, in segments that end anywhere, also on the edge of the box.
/// Each of the at most 1e4 crossings rounds a position of the size of the box, 4, by 4e-16.
#[test]
fn free_flight_is_velocity_times_time() {
    let domain = Domain::periodic(vector![1.5, 4.0]).expect("a box");
    let lanes = [(0.0, 1.5), (1.2, -0.75), (2.4, -1e-30)];
    let start: State<EqualDisks> = samples::state(
        domain,
        lanes.map(|(y, v)| (vector![0.0, y], vector![v, 0.0])),
    );
    let mut gas = tracked(start.clone());
    for time in [0.1, 1.0, 2.0, 3.5, 1000.0, 7777.7] {
        gas = leg(gas, 0.5, time);
        for (now, then) in unwrapped(&gas).iter().zip(&start.bodies) {
            let expected = then.position + then.velocity * time;
            assert!((now - expected).norm() < 4e-12, "{time}: {now} {expected}");
        }
    }
    assert_eq!(gas.image_flags[0][0], 7777);
    assert_eq!(gas.image_flags[2], [0, 0]);
    // Motion along the second axis.
    let mut turned = start;
    for body in &mut turned.bodies {
        body.velocity = vector![0.0, 2.0 * body.velocity[0]];
        body.position = vector![0.0, 0.0];
    }
    turned.bodies.truncate(1);
    let gas = leg(tracked(turned), 0.5, 8.0);
    assert_eq!((gas.image_flags[0], unwrapped(&gas)[0][1]), ([0, 6], 24.0));
}

/// Image flags add up to the displacements that are summed over times so short that no disk moves
/// by half a box. Boxes have many cells, three, two and one. 1e-10: 40 sums, each of positions that
/// round to 1e-14, and their image flags.
#[test]
fn windings_add_up_to_the_displacements() {
    for (count, packing) in [(400, 0.25), (6, 0.3), (4, 0.5), (2, 0.35)] {
        let start = gas(Arrangement::Square, count, packing, 5);
        let lengths = start.domain.lengths();
        let mut sums: Vec<Vector2<f64>> = start.bodies.iter().map(|body| body.position).collect();
        let mut gas = tracked(start.clone());
        let mut plain: EventDrivenCheckpoint<EqualDisks> = start.into();
        let speed = gas
            .state
            .bodies
            .iter()
            .map(|b| b.velocity.norm())
            .sum::<f64>();
        let step = 0.45 * lengths.min() / speed;
        let mut wound = false;
        for i in 1..=400 {
            let before = gas.state.clone();
            gas = leg(gas, 1.0, f64::from(i) * step);
            plain = leg(plain, 1.0, f64::from(i) * step);
            wound |= gas.image_flags.iter().any(|winding| *winding != [0, 0]);
            for (sum, (now, then)) in sums
                .iter_mut()
                .zip(gas.state.bodies.iter().zip(&before.bodies))
            {
                *sum += before.domain.displacement(now.position, then.position);
            }
        }
        for (sum, found) in sums.iter().zip(unwrapped(&gas)) {
            assert!((sum - found).norm() < 1e-10, "{count} disks: {sum} {found}");
        }
        // Tracking of displacements changes nothing else.
        assert_eq!(gas.state.bodies, plain.state.bodies);
        assert_eq!(gas.tally, plain.tally);
        assert!(plain.image_flags.is_empty());
        // At least one disk has gone around a small box.
        assert!(wound || count == 400);
    }
}

#[test]
fn windings_of_other_disks_are_refused() {
    let mut start = tracked(gas(Arrangement::Square, 16, 0.2, 5));
    start.image_flags.pop();
    let refused = EventDriven::<_>::new(disks(1.0), DissipationRule::Scene, start);
    assert_eq!(
        refused.err().expect("an error").to_string(),
        "15 windings for 16 disks; allowed are none, or one for each disk"
    );
}

fn parameters(
    cell: f64,
    simulators_per_particle: u32,
    displacement: PartnerDisplacement,
) -> Parameters {
    Parameters {
        scheme: Scheme::Enskog(Neighbourhood::Mean),
        displacement,
        cell_size: Some(cell),
        simulators_per_particle,
        copies: SimulatorStart::Independent,
        steps_per_cell_crossing: 8.0,
        max_contact_value: 10.0,
    }
}

/// Displacements of simulators end at their positions, up to sides of the box, as all start from
/// one point. 1e-9: 2000 steps that round a position of 30 or a displacement of 300 each.
#[test]
fn displacements_of_simulators_end_at_their_positions() {
    let mut start = gas(Arrangement::Disordered, 300, 0.3, 3);
    let origin = start.bodies[0].position;
    for body in &mut start.bodies {
        body.position = origin;
    }
    let (scene, start) = (equal(1.0, 300), as_kinds(&start));
    for displacement in [PartnerDisplacement::None, PartnerDisplacement::Diameter] {
        let streams = Streams::new(1, 0);
        let parameters = parameters(2.0, 1, displacement);
        let mut engine = DsmcEngine::<_, Tracked>::setup(&scene, parameters, streams)
            .start(&start)
            .expect("an engine");
        engine.track_displacements();
        engine.advance(40.0, u64::MAX, &mut ());
        // Two parts, as in a resumed run.
        let checkpoint = engine.checkpoint();
        let mut engine = DsmcEngine::setup(&scene, parameters, streams)
            .resume(start.domain, checkpoint)
            .expect("an engine");
        engine.advance(80.0, u64::MAX, &mut ());
        assert!(engine.tally().collisions > 5_000);
        let state = engine.state();
        let mut farthest = 0.0_f64;
        assert_eq!(engine.displacements().len(), 300);
        for (body, way) in state.bodies.iter().zip(engine.displacements()) {
            let missed = state.domain.distance(body.position, origin + way);
            assert!(missed < 1e-9, "{missed}");
            farthest = farthest.max(way.norm());
        }
        assert!(farthest > state.domain.lengths().min(), "{farthest}");
    }
}

/// Simulators of an elastic gas at packing 0.1 diffuse as Enskog's theory says, after 15.8 mean
/// free times, over first Sonine order.
///
/// The velocity correlation in Sonine polynomials decays by a matrix of collision integrals with
/// the elements 1, -1/4, -1/32, 43/16, ... (by quadrature over 1.5e8 collisions), which gives D in
/// the first three orders as 1, 43/42, 1.0265 (known: 1.027, Gass, J. Chem. Phys. 54, 1898 (1971)),
/// and 1.0243 for the displacement at this time. Allowed are 0.5 % for the length of the step
/// (1/64), the slow decay of correlations through flow (1/32 of that of ED below, 0.15 %) and
/// repeated partners (1 in 60). To these come 3.77 standard errors (t with 23 degrees of freedom,
/// false alarm 1e-3), which may be at most 1.2 %.
#[test]
fn simulators_diffuse_as_enskog_says() {
    let (packing, chi) = (0.1, equation_of_state::contact_value(0.1));
    let decay = diffusion::velocity_decay(packing, chi, 1.0);
    let time = 15.8 / decay;
    let theory = diffusion::steady_displacement(1.0, decay, time);
    let found: Vec<f64> = (0..24)
        .map(|seed| {
            let start = gas(Arrangement::Disordered, 600, packing, seed);
            let streams = Streams::new(seed, 0);
            let mut engine = DsmcEngine::<_, Tracked>::setup(
                &equal(1.0, 600),
                parameters(4.0, 32, PartnerDisplacement::None),
                streams,
            )
            .start(&as_kinds(&start))
            .expect("an engine");
            engine.track_displacements();
            engine.advance(time, u64::MAX, &mut ());
            let all = engine.displacements();
            let square = all.iter().map(Vector2::norm_squared).sum::<f64>() / all.len() as f64;
            square / theory
        })
        .collect();
    let (mean, error) = mean_and_error(&found);
    println!("DSMC: {mean:.4} ± {error:.4}");
    assert!(
        (mean - 1.0243).abs() < 0.005 + 3.77 * error,
        "{mean} ± {error}"
    );
    assert!(3.77 * error < 0.012, "the error bar {error} is too wide");
}

/// Event-driven disks, elastic, packing 0.1: ballistic and decaying as Enskog says, and later a
/// little faster.
///
/// After half a mean free time, first Sonine order is within 0.3 % of the theory itself, for it has
/// the right initial decay; packing correlations beyond Enskog's are of the order of the 0.5 %
/// allowed in all. After 20 mean free times, the theory itself is 1.025. In two dimensions, flow
/// carries disks along and adds the share (1/(8 pi n (D + nu))) ln(t/t1)/D from about t1 = 1 to 5
/// mean free times on (Alder & Wainwright, Phys. Rev. A 1, 18 (1970)): with n = 0.127, D = 1.88 and
/// nu = 2.4, this is 4 % a factor e. So it is 5 % to 12 % at most by 20, and less in the
/// displacement, which is a mean over time. Allowed is from none of it to 12 %, and 4.07 standard
/// errors (t with fifteen degrees of freedom, false alarm 1e-3), which may be at most 5 %.
#[test]
fn disks_diffuse_as_enskog_says() {
    let (packing, chi) = (0.1, equation_of_state::contact_value(0.1));
    let decay = diffusion::velocity_decay(packing, chi, 1.0);
    let times = [0.5 / decay, 20.0 / decay];
    let mut ratios = [Vec::new(), Vec::new()];
    for seed in 0..16 {
        let mut start = leg(
            gas(Arrangement::Disordered, 2500, packing, seed).into(),
            1.0,
            20.0,
        )
        .state;
        start.time = 0.0;
        let origin: Vec<_> = start.bodies.iter().map(|body| body.position).collect();
        let mut gas = tracked(start);
        for (ratios, time) in ratios.iter_mut().zip(times) {
            gas = leg(gas, 1.0, time);
            let squares = unwrapped(&gas);
            let squares = squares
                .iter()
                .zip(&origin)
                .map(|(a, b)| (a - b).norm_squared());
            let theory = diffusion::steady_displacement(1.0, decay, time);
            ratios.push(squares.sum::<f64>() / origin.len() as f64 / theory);
        }
    }
    let (mean, error) = mean_and_error(&ratios[0]);
    println!("ED, early: {mean:.4} ± {error:.4}");
    assert!(
        (mean - 1.0).abs() < 0.005 + 4.07 * error,
        "{mean} ± {error}"
    );
    assert!(4.07 * error < 0.02, "the error bar {error} is too wide");
    let (mean, error) = mean_and_error(&ratios[1]);
    println!("ED, late: {mean:.4} ± {error:.4}");
    assert!(
        (1.025 - 4.07 * error..1.145 + 4.07 * error).contains(&mean),
        "{mean} ± {error}"
    );
    assert!(4.07 * error < 0.05, "the error bar {error} is too wide");
}

/// A cooling gas, r = 0.9, spreads as the logarithm of time to t/t0 = 2, in Monte Carlo at packing
/// 0.05.
///
/// First Sonine order leaves out the Maxwellian start, and the change of D by the second order: 2.7
/// % in the elastic gas at long times, of either sign with a2 = -0.027. So 3.5 % are allowed, and
/// 3.77 standard errors (t with 23 degrees of freedom, false alarm 1e-3), at most 1.2 %.
///
/// The test sees the cooling of the correlation: without it (beta = (1 + r)/(1 - r) in place of
/// 2/(1 - r)) the result would be off by 5 %. With D of the start's temperature it would be off by
/// a factor of 2.
#[test]
fn cooling_gas_spreads_as_the_logarithm_of_time() {
    let (packing, r) = (0.05, 0.9);
    let chi = equation_of_state::contact_value(packing);
    let haff = cooling::haff_time(packing, r, chi);
    let theory = diffusion::cooling_displacement(r, 2.0) * haff * haff;
    let found: Vec<f64> = (0..24)
        .map(|seed| {
            let start = gas(Arrangement::Disordered, 400, packing, seed);
            let streams = Streams::new(seed, 0);
            let mut engine = DsmcEngine::<_, Tracked>::setup(
                &equal(r, 400),
                parameters(4.0, 16, PartnerDisplacement::None),
                streams,
            )
            .start(&as_kinds(&start))
            .expect("an engine");
            engine.track_displacements();
            engine.advance(2.0 * haff, u64::MAX, &mut ());
            let all = engine.displacements();
            all.iter().map(Vector2::norm_squared).sum::<f64>() / all.len() as f64 / theory
        })
        .collect();
    let (mean, error) = mean_and_error(&found);
    println!("cooling: {mean:.4} ± {error:.4}");
    assert!(
        (mean - 1.0).abs() < 0.035 + 3.77 * error,
        "{mean} ± {error}"
    );
    assert!(3.77 * error < 0.012, "the error bar {error} is too wide");
}
