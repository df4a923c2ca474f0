//! Schemes, starts, and what must hold of every run.

use nalgebra::{Vector2, vector};
use rand::RngExt;
use stosszahl_dsmc::{
    Checkpoint, Copies, Displacement, Engine, Neighbourhood, Parameters, Scheme, Tally,
};
use stosszahl_model::random::{Purpose, Stream, Streams};
use stosszahl_model::{Body, Constant, Domain, Plane, State, initial};

use super::{Findings, Trouble};
use crate::bench::{self, Disks};

/// Roundings of 1.1e-16 in a collision: some ten operations, each with a pair's share of the sum. Those of one
/// collision are not all to one side, so that twice their sum is never reached.
const EACH_COLLISION: f64 = 2e-15;
/// Rounding of each addition to a sum over simulators.
const EACH_ADDITION: f64 = 1.2e-16;

/// A scheme with its displacement and number of simulators.
#[derive(Clone, Copy, Debug)]
pub(super) struct Setup {
    pub name: &'static str,
    pub parameters: Parameters,
}

const PLAIN: Parameters = Parameters {
    scheme: Scheme::Boltzmann,
    displacement: Displacement::None,
    cell_size: None,
    simulators_per_disk: 1,
    copies: Copies::Independent,
    steps_per_crossing: 4.0,
    largest_contact_value: 10.0,
};

/// All schemes that collide, each in every way it can be used.
pub(super) fn setups() -> Vec<Setup> {
    let setup = |name, scheme, displacement, simulators_per_disk| Setup {
        name,
        parameters: Parameters {
            scheme,
            displacement,
            simulators_per_disk,
            ..PLAIN
        },
    };
    let (none, around) = (Displacement::None, Neighbourhood::Cells(1));
    let enskog = Scheme::Enskog(around);
    let contact = Scheme::ContactPoint { radius: None };
    vec![
        setup("boltzmann", Scheme::Boltzmann, none, 1),
        setup("free-volume", Scheme::FreeVolume, none, 1),
        setup(
            "enskog of the mean",
            Scheme::Enskog(Neighbourhood::Mean),
            none,
            1,
        ),
        setup("enskog", enskog, none, 1),
        setup("enskog displaced", enskog, Displacement::Diameter, 1),
        setup("enskog inelastic", enskog, Displacement::Inelastic, 1),
        setup("esmc", Scheme::Esmc(around), none, 1),
        setup(
            "stochastic-disks",
            Scheme::StochasticDisks { stiffness: 1.0 },
            none,
            1,
        ),
        setup("contact-point", contact, none, 1),
        setup("contact-point of 8", contact, none, 8),
    ]
}

impl Setup {
    /// Whether chi follows the density around.
    pub(super) fn is_local(self) -> bool {
        !matches!(
            self.parameters.scheme,
            Scheme::Boltzmann | Scheme::Enskog(Neighbourhood::Mean)
        )
    }

    pub(super) fn is_stochastic_disks(self) -> bool {
        matches!(self.parameters.scheme, Scheme::StochasticDisks { .. })
    }
}

/// Unit disks with a restitution.
pub(super) fn unit_disks(restitution: f64) -> Result<Disks, Trouble> {
    let law = Constant::new(restitution).ok_or(Trouble::NoStart("restitution outside 0 to 1"))?;
    Ok(bench::unit_disks(law))
}

/// A periodic box.
pub(super) fn domain(width: f64, height: f64) -> Result<Domain<Plane>, Trouble> {
    Domain::periodic(vector![width, height]).ok_or(Trouble::NoStart("a box without a size"))
}

/// The square box in which so many unit disks have a packing fraction.
pub(super) fn square(count: usize, packing: f64) -> Result<Domain<Plane>, Trouble> {
    let side = (count as f64 * std::f64::consts::FRAC_PI_4 / packing).sqrt();
    domain(side, side)
}

pub(super) fn random(seed: u64) -> Stream {
    Streams::new(seed, 0).at(Purpose::Placement, [0, 0])
}

/// Positions uniform in a rectangle, whether they overlap or not.
pub(super) fn scattered(
    count: usize,
    low: [f64; 2],
    sides: [f64; 2],
    stream: &mut Stream,
) -> Vec<Vector2<f64>> {
    let mut place = |axis: usize| low[axis] + sides[axis] * stream.random::<f64>();
    (0..count).map(|_| vector![place(0), place(1)]).collect()
}

/// Bodies at these places with Maxwellian velocities of temperature one and no momentum.
pub(super) fn warm(
    domain: Domain<Plane>,
    places: &[Vector2<f64>],
    seed: u64,
) -> Result<State<Disks>, Trouble> {
    let mut state = State {
        time: 0.0,
        domain,
        bodies: places
            .iter()
            .map(|&at| Body::new(at, vector![0.0, 0.0]))
            .collect(),
    };
    let mut stream = Streams::new(seed, 0).at(Purpose::Velocities, [0, 0]);
    initial::maxwellian(&unit_disks(1.0)?, &mut state, 1.0, &mut stream);
    Ok(state)
}

/// A gas without order in a square box.
pub(super) fn uniform(count: usize, packing: f64, seed: u64) -> Result<State<Disks>, Trouble> {
    let domain = square(count, packing)?;
    let sides = domain.lengths().into();
    let places = scattered(count, [0.0; 2], sides, &mut random(seed));
    warm(domain, &places, seed)
}

/// An engine from a start.
pub(super) fn engine(
    setup: Setup,
    restitution: f64,
    start: &State<Disks>,
) -> Result<Engine<Disks>, Trouble> {
    let streams = Streams::new(1, 0);
    let scene = unit_disks(restitution)?;
    Ok(Engine::new(&scene, setup.parameters, start, streams)?)
}

/// The engine that goes on from the bytes of a checkpoint.
pub(super) fn resumed(
    setup: Setup,
    restitution: f64,
    domain: Domain<Plane>,
    bytes: &[u8],
) -> Result<Engine<Disks>, Trouble> {
    let checkpoint: Checkpoint<Disks> = postcard::from_bytes(bytes)?;
    let scene = unit_disks(restitution)?;
    let streams = Streams::new(1, 0);
    Ok(Engine::resume(
        &scene,
        setup.parameters,
        domain,
        checkpoint,
        streams,
    )?)
}

/// The bytes of a checkpoint.
pub(super) fn bytes(engine: &Engine<Disks>) -> Result<Vec<u8>, Trouble> {
    Ok(postcard::to_allocvec(&engine.checkpoint())?)
}

/// Sums over simulators that collisions conserve.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sums {
    pub energy: f64,
    pub momentum: Vector2<f64>,
    /// Sum of |v|.
    speed: f64,
}

impl Sums {
    pub(super) fn of(state: &State<Disks>) -> Self {
        let mut sums = Self {
            energy: 0.0,
            momentum: vector![0.0, 0.0],
            speed: 0.0,
        };
        for body in &state.bodies {
            sums.energy += 0.5 * body.velocity.norm_squared();
            sums.momentum += body.velocity;
            sums.speed += body.velocity.norm();
        }
        sums
    }
}

/// Largest relative error of a sum over so many simulators after so many collisions, `share` being the largest share of the
/// sum that a pair has.
pub(super) fn rounding(simulators: usize, collisions: u64, share: f64) -> f64 {
    EACH_COLLISION * (collisions as f64 * share).max(1.0) + EACH_ADDITION * simulators as f64
}

/// What must hold of every run: finite numbers within the box, counts that fit each other, momentum, and energy: the same
/// if collisions are elastic, and no more than before in any case. Returns the error of energy and momentum.
pub(super) fn audit(
    findings: &mut Findings,
    what: &str,
    engine: &Engine<Disks>,
    before: Sums,
    elastic: bool,
) -> [f64; 2] {
    let simulators = engine.simulators();
    let share = 8.0 / simulators.max(8) as f64;
    audit_shared(findings, what, engine, before, elastic, share)
}

/// The same where a pair may have any share of the energy.
pub(super) fn audit_shared(
    findings: &mut Findings,
    what: &str,
    engine: &Engine<Disks>,
    before: Sums,
    elastic: bool,
    share: f64,
) -> [f64; 2] {
    let state = engine.state();
    let lengths = state.domain.lengths();
    let inside = |x: f64, axis: usize| (0.0..lengths[axis]).contains(&x);
    let sound = state.bodies.iter().all(|body| {
        (0..2).all(|axis| body.velocity[axis].is_finite() && inside(body.position[axis], axis))
    });
    findings.require(sound, || {
        format!("{what}: a position outside the box or a velocity that is no number")
    });
    check_tally(findings, what, &engine.tally());
    let after = Sums::of(&state);
    let tolerance = rounding(engine.simulators(), engine.tally().collisions, share);
    let energy = (after.energy - before.energy) / before.energy.max(f64::MIN_POSITIVE);
    let momentum = (after.momentum - before.momentum).norm() / before.speed.max(f64::MIN_POSITIVE);
    findings.at_most(&format!("{what}: momentum off"), momentum, tolerance);
    if elastic {
        findings.at_most(&format!("{what}: energy off"), energy.abs(), tolerance);
    } else {
        findings.at_most(&format!("{what}: energy grown"), energy, tolerance);
    }
    [energy, momentum]
}

/// Counts that fit each other, and sums that are numbers.
fn check_tally(findings: &mut Findings, what: &str, tally: &Tally) {
    let sums = [tally.separation, tally.virial, tally.busiest_cell];
    let sound = sums.iter().all(|sum| sum.is_finite())
        && tally.separation >= 0.0
        && tally.busiest_cell >= 0.0
        && tally.collisions <= tally.trials
        && tally.missed <= tally.trials
        && tally.limited_cells <= tally.active_cells
        && tally.limited_collisions <= tally.collisions;
    findings.require(sound, || {
        format!("{what}: counts that cannot be, {tally:?}")
    });
}

/// Collisions of each simulator in a step, on average.
pub(super) fn each_step(engine: &Engine<Disks>) -> f64 {
    let tally = engine.tally();
    2.0 * tally.collisions as f64 / (engine.simulators() as f64 * tally.steps.max(1) as f64)
}
