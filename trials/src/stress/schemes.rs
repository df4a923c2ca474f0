//! Monte Carlo schemes in hard cases: their initial states, and the checks that every run
//! undergoes.

use nalgebra::{Vector2, vector};
use stosszahl_dsmc::{
    CollisionCounters, DsmcEngine, Neighbourhood, Parameters, PartnerDisplacement, Scheme,
};
use stosszahl_model::State;
use stosszahl_model::random::Streams;
use stosszahl_model::samples::{EqualDisks, ideal_gas, maxwellian, square};

use crate::gas::{PLAIN, disks};
use crate::{Done, TrialError, TrialLog};

/// Relative rounding error that one collision may add to a conserved sum, per fraction of the sum
/// that a pair holds: some ten operations of 1.1e-16. Errors of one collision differ in sign, so
/// twice their sum is never reached.
const EACH_COLLISION: f64 = 2e-15;
/// Relative rounding error of each addition to a conserved sum over simulators.
const EACH_ADDITION: f64 = 1.2e-16;

/// Monte Carlo scheme in hard cases, with its partner displacement and number of simulators per
/// disk.
#[derive(Clone, Copy, Debug)]
pub(super) struct Setup {
    pub name: &'static str,
    pub parameters: Parameters,
}

/// Returns all Monte Carlo schemes with collisions, each with every choice of its options.
pub(super) fn setups() -> Vec<Setup> {
    let setup = |name, scheme, displacement, simulators_per_particle| Setup {
        name,
        parameters: Parameters {
            scheme,
            displacement,
            simulators_per_particle,
            ..PLAIN
        },
    };
    let (none, around) = (PartnerDisplacement::None, Neighbourhood::Cells(1));
    let (enskog, mean) = (Scheme::Enskog(around), Scheme::Enskog(Neighbourhood::Mean));
    let soft = Scheme::StochasticDisks { stiffness: 1.0 };
    let contact = Scheme::ContactPoint { radius: None };
    vec![
        setup("boltzmann", Scheme::Boltzmann, none, 1),
        setup("free-volume", Scheme::FreeVolume, none, 1),
        setup("enskog of the mean", mean, none, 1),
        setup("enskog", enskog, none, 1),
        setup("enskog displaced", enskog, PartnerDisplacement::Diameter, 1),
        setup(
            "enskog inelastic",
            enskog,
            PartnerDisplacement::Inelastic,
            1,
        ),
        setup("esmc", Scheme::Esmc(around), none, 1),
        setup("stochastic-disks", soft, none, 1),
        setup("contact-point", contact, none, 1),
        setup("contact-point of 8", contact, none, 8),
    ]
}

impl Setup {
    /// Returns true if the scheme's pair correlation χ depends on the local density.
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

/// Creates elastic unit disks at given positions with Maxwellian velocities.
pub(super) fn warm(
    domain: stosszahl_model::Domain<stosszahl_model::Plane>,
    places: Vec<Vector2<f64>>,
    seed: u64,
) -> Result<State<EqualDisks>, TrialError> {
    Ok(maxwellian(&disks(1.0)?, domain, places, 1.0, seed))
}

/// Creates elastic unit disks at uniform random positions in a square box, overlaps allowed.
pub(super) fn uniform(
    count: usize,
    packing: f64,
    seed: u64,
) -> Result<State<EqualDisks>, TrialError> {
    let domain = square(count, packing);
    Ok(ideal_gas(&disks(1.0)?, domain, 0.0, count, 1.0, seed))
}

/// Creates the Monte Carlo engine of a scheme from an initial state.
pub(super) fn engine(
    setup: Setup,
    restitution: f64,
    start: &State<EqualDisks>,
) -> Result<DsmcEngine<EqualDisks>, TrialError> {
    let scene = disks(restitution)?;
    Ok(DsmcEngine::new(
        &scene,
        setup.parameters,
        start,
        Streams::new(1, 0),
    )?)
}

/// Run of a Monte Carlo scheme in a hard case: the engine, and the conserved sums at its start.
pub(super) struct SchemeRun {
    pub setup: Setup,
    pub restitution: f64,
    pub engine: DsmcEngine<EqualDisks>,
    pub before: ConservedSums,
    /// Relative errors of momentum and of energy in the last check; that of energy is zero for
    /// inelastic collisions.
    pub off: [f64; 2],
}

impl SchemeRun {
    pub(super) fn new(
        setup: Setup,
        restitution: f64,
        start: &State<EqualDisks>,
    ) -> Result<Self, TrialError> {
        let engine = engine(setup, restitution, start)?;
        let before = ConservedSums::of(&engine.state());
        Ok(Self {
            setup,
            restitution,
            engine,
            before,
            off: [0.0; 2],
        })
    }

    /// Runs the Monte Carlo scheme for a number of time steps.
    pub(super) fn steps(&mut self, steps: u64) {
        self.engine.advance(f64::INFINITY, steps, &mut ());
    }

    pub(super) fn tally(&self) -> CollisionCounters {
        self.engine.tally()
    }

    /// Checks a run of a Monte Carlo scheme: finite numbers within the box, consistent counters,
    /// and momentum. Energy must be conserved by elastic collisions and never grow.
    pub(super) fn audit(&mut self, log: &mut TrialLog) {
        self.audit_shared(log, 8.0 / self.engine.simulators().max(8) as f64);
    }

    /// Checks a run as [`Self::audit`], with a tolerance for pairs that hold up to the fraction
    /// `share` of all energy.
    pub(super) fn audit_shared(&mut self, log: &mut TrialLog, share: f64) {
        let state = self.engine.state();
        let lengths = state.domain.lengths();
        let inside = |x: f64, axis: usize| (0.0..lengths[axis]).contains(&x);
        let sound = state.bodies.iter().all(|body| {
            (0..2).all(|axis| body.velocity[axis].is_finite() && inside(body.position[axis], axis))
        });
        must!(log, sound; "a position outside the box or a velocity that is no number");
        let tally = self.tally();
        let sums = [tally.separation, tally.virial, tally.busiest_cell];
        let sound = sums.iter().all(|sum| sum.is_finite())
            && tally.separation >= 0.0
            && tally.busiest_cell >= 0.0
            && tally.collisions <= tally.trials
            && tally.missed <= tally.trials
            && tally.limited_cells <= tally.active_cells
            && tally.limited_collisions <= tally.collisions;
        must!(log, sound; "counts that cannot be, {tally:?}");
        let (before, after) = (self.before, ConservedSums::of(&state));
        let tolerance = rounding(self.engine.simulators(), tally.collisions, share);
        let energy = (after.energy - before.energy) / before.energy.max(f64::MIN_POSITIVE);
        let momentum =
            (after.momentum - before.momentum).norm() / before.speed.max(f64::MIN_POSITIVE);
        log.at_most("momentum off", momentum, tolerance);
        self.off = [momentum, 0.0];
        if self.restitution == 1.0 {
            log.at_most("energy off", energy.abs(), tolerance);
            self.off[1] = energy.abs();
        } else {
            log.at_most("energy grown", energy, tolerance);
        }
    }
}

/// Runs a job for all Monte Carlo schemes and some coefficients of restitution, and checks each
/// run. Returns the largest relative errors of momentum and energy.
pub(super) fn each(
    log: &mut TrialLog,
    restitutions: &[f64],
    start: &State<EqualDisks>,
    mut job: impl FnMut(&mut TrialLog, &mut SchemeRun) -> Done,
) -> Result<[f64; 2], TrialError> {
    let mut worst = [0.0_f64; 2];
    for setup in setups() {
        for &restitution in restitutions {
            log.about(match restitutions.len() {
                1 => setup.name.to_owned(),
                _ => format!("{}, r = {restitution}", setup.name),
            });
            let mut run = SchemeRun::new(setup, restitution, start)?;
            job(log, &mut run)?;
            run.audit(log);
            worst = [0, 1].map(|index: usize| worst[index].max(run.off[index]));
        }
    }
    log.about("");
    Ok(worst)
}

/// Energy and momentum of all simulators, which collisions conserve, and the sum of speeds as the
/// scale of momentum.
#[derive(Clone, Copy, Debug)]
pub(super) struct ConservedSums {
    pub energy: f64,
    pub momentum: Vector2<f64>,
    /// Sum of the speeds |v| of all simulators \[length/time\].
    speed: f64,
}

impl ConservedSums {
    pub(super) fn of(state: &State<EqualDisks>) -> Self {
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

/// Returns the largest relative rounding error of a conserved sum after a number of collisions.
/// Here `share` is the largest fraction of the sum that a pair holds.
pub(super) fn rounding(simulators: usize, collisions: u64, share: f64) -> f64 {
    EACH_COLLISION * (collisions as f64 * share).max(1.0) + EACH_ADDITION * simulators as f64
}
