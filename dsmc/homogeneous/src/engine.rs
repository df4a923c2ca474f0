//! Monte Carlo engine of a gas without positions: Poisson process of pair collisions by
//! acceptance-rejection, without time step.

use rand::RngExt;
use rand_distr::{Beta, Distribution, Exp1, Poisson};
use stosszahl_model::random::{Purpose, Stream, Streams};
use stosszahl_model::{
    Collision, Interrupt, InvalidValue, Observer, Recorder, Separation, Sizes, Vector, VectorOf,
};

use super::clock::{Clock, SelectionCounters, StopReason};
use super::contact::{Bounce, CollidingParticles, ContactOutcome, ContactRule, line_of_centres};
use super::error::HomogeneousError;
use super::gas::{GONE, GasParticle, HomogeneousGas, SmoothPhysics};
use super::motion::PathRecord;
use super::selection::{CandidatePair, ProposalValidity, SelectionMethod};
use stosszahl_model::interrupt::Interruption;

/// Number of pair proposals drawn ahead as one batch.
const BATCH: usize = 64;
/// Number of pair proposals whose particles are prefetched while earlier ones are processed.
const AHEAD: usize = 24;

/// Monte Carlo engine of a gas without positions. See the [module](super).
#[derive(Clone, Debug)]
pub struct HomogeneousEngine<P: SmoothPhysics, S, M = (), C = Bounce> {
    pub(super) gas: HomogeneousGas<P>,
    pub(super) selection: S,
    pub(super) motion: M,
    pub(super) contacts: C,
    pub(super) streams: Streams,
    pub(super) clock: Clock,
    pub(super) tally: SelectionCounters,
    pub(super) stop: Interruption,
    /// Random stream of an advance that was paused, which the next advance continues; `None`
    /// otherwise.
    pub(super) paused: Option<Stream>,
}

impl<P: SmoothPhysics, S: SelectionMethod<P>, M: PathRecord<P>, C: ContactRule<P>>
    HomogeneousEngine<P, S, M, C>
{
    /// Creates an engine at time zero. Particles keep their indices as long as none appears or
    /// vanishes; the record `motion` relies on that.
    ///
    /// # Errors
    /// [`HomogeneousError::Invalid`] if paths are to be tracked while particles appear and
    /// vanish.
    pub fn new(
        mut gas: HomogeneousGas<P>,
        motion: M,
        contacts: C,
        streams: Streams,
    ) -> Result<Self, HomogeneousError> {
        let stay = !(motion.is_tracked() && C::SIZES_CHANGE);
        let name = "number of tracked particles in a gas that sticks or breaks";
        InvalidValue::require(stay, name, gas.count() as f64, "0")?;
        contacts.prepare_gas(&mut gas);
        Ok(Self {
            gas,
            selection: S::new(),
            motion,
            contacts,
            streams,
            clock: Clock {
                outdated: true,
                ..Clock::default()
            },
            tally: SelectionCounters::default(),
            stop: Interruption::default(),
            paused: None,
        })
    }

    /// Returns the gas: particles, volume and collision kernel.
    pub fn gas(&self) -> &HomogeneousGas<P> {
        &self.gas
    }

    /// Returns the method that proposes candidate pairs, in its current state.
    pub fn selection(&self) -> &S {
        &self.selection
    }

    /// Returns the recorded displacements and trajectories.
    pub fn motion(&self) -> &M {
        &self.motion
    }

    /// Returns the contact rule, with its ledger of merged and broken pairs.
    pub fn contacts(&self) -> &C {
        &self.contacts
    }

    /// Returns the current time of the gas \[time\].
    pub fn time(&self) -> f64 {
        self.clock.time
    }

    /// Returns the work counters since the start of the run.
    pub fn tally(&self) -> &SelectionCounters {
        &self.tally
    }

    /// Returns the memory that particles, pair selection and recorded displacements occupy
    /// \[bytes\].
    pub fn memory_bytes(&self) -> usize {
        self.gas.particles.capacity() * size_of::<GasParticle<P>>()
            + self.selection.memory_bytes()
            + self.motion.memory_bytes()
    }

    /// Sets an interrupt that breaks off an advance after at most some dozen proposals; it then
    /// returns [`StopReason::Interrupted`].
    pub fn set_stop_flag(&mut self, interrupt: &Interrupt) {
        self.stop.on(interrupt);
    }

    /// Sets a pause flag that ends an advance with [`StopReason::Paused`], after at most some dozen
    /// proposals or a quarter for each particle. The next advance to the same time continues as
    /// without a pause; a checkpoint of the paused gas continues with other random numbers.
    pub fn set_pause_flag(&mut self, pause: &Interrupt) {
        self.stop.set_pause_flag(pause);
    }

    /// Returns true if an advance was broken off by an interrupt. The gas is then in the middle of
    /// the advance, and the engine advances no further.
    pub fn is_interrupted(&self) -> bool {
        self.stop.has_ended()
    }

    /// Adds a velocity change to each particle, in the order of the particles.
    pub fn kick(&mut self, changes: impl Iterator<Item = VectorOf<P>>) {
        let alive = self.gas.particles.iter_mut().filter(|one| !one.is_gone());
        for (particle, change) in alive.zip(changes) {
            particle.velocity += change;
        }
        self.clock.outdated = true;
    }

    /// Multiplies the velocities of all particles by a positive factor.
    ///
    /// # Errors
    /// [`HomogeneousError::Invalid`] unless the factor is above zero and finite.
    pub fn scale_velocities(&mut self, factor: f64) -> Result<(), HomogeneousError> {
        InvalidValue::unless_positive("factor of all velocities", factor)?;
        for particle in &mut self.gas.particles {
            particle.velocity = particle.velocity * factor;
        }
        self.clock.outdated = true;
        Ok(())
    }

    /// Advances the gas until a time \[time\], or by a number of collisions, whichever comes first.
    ///
    /// The random stream is addressed by the number of advances before. So a run gives the same
    /// bytes if it is stopped and resumed between two advances, and other bytes if its time is
    /// divided otherwise; a pause divides nothing. An observer receives the exact time of each
    /// collision if trajectories are kept, and else its mean for the number of the collision
    /// in the sequence.
    ///
    /// # Errors
    /// [`HomogeneousError`] if `until` is no number or before the present, a rate is not finite, or
    /// a bound was exceeded.
    pub fn advance(
        &mut self,
        until: f64,
        collisions: u64,
        observer: &mut dyn Observer,
    ) -> Result<StopReason, HomogeneousError> {
        let mut recorder = Recorder::new(observer);
        let is_to_come = until >= self.clock.time;
        let allowed = "the present or later";
        InvalidValue::require(is_to_come, "time to advance to", until, allowed)?;
        let mut stream = if let Some(stream) = self.paused.take() {
            stream
        } else {
            self.clock.advances += 1;
            self.streams
                .stream_at(Purpose::Pairs, [self.clock.advances - 1, 0])
        };
        let last = self.tally.collisions.saturating_add(collisions);
        while self.clock.time < until {
            if self.stop.ends() {
                return Ok(StopReason::Interrupted);
            }
            if self.tally.collisions >= last {
                return Ok(StopReason::Collisions);
            }
            self.refit()?;
            let rate = self.selection.proposal_rate();
            let allowed = "a finite number: speeds or densities are too large";
            InvalidValue::require(rate.is_finite(), "rate of proposals", rate, allowed)?;
            if rate == 0.0 || self.gas.count() < 2 {
                if until.is_finite() {
                    self.clock.time = until;
                }
                return Ok(StopReason::Still);
            }
            self.interval(until, last, rate, &mut stream, &mut recorder)?;
            if self.stop.is_paused() && self.clock.time < until {
                self.paused = Some(stream);
                return Ok(StopReason::Paused);
            }
        }
        Ok(StopReason::Time)
    }

    /// Rebuilds the bounds of speed and rate if enough collisions have happened since the last
    /// rebuild, or if velocities were changed from outside.
    fn refit(&mut self) -> Result<(), HomogeneousError> {
        let due = 0.5 * self.selection.rebuild_interval() * self.gas.count() as f64;
        if self.clock.outdated || self.clock.since as f64 > due.max(8.0) {
            if C::SIZES_CHANGE {
                self.gas.measure_contacts()?;
            }
            if self.tally.rebuilds % 64 == 63 {
                let contacts = &self.contacts;
                self.gas
                    .remove_rounding(|kind| contacts.conserves_momentum(kind));
            }
            self.selection.rebuild_bounds(&mut self.gas);
            self.clock.since = 0;
            self.clock.outdated = false;
            self.tally.rebuilds += 1;
        }
        Ok(())
    }

    /// Processes proposals with a constant rate: until a time, until the bounds of the selection
    /// must be rebuilt, or until a particle exceeds its bound.
    ///
    /// The number of proposals in the interval is Poisson. If the law changes with proposal m of M,
    /// later proposals are void; the time of proposal m is the m-th of M uniform times, Beta
    /// distributed, and a new Poisson process follows.
    fn interval(
        &mut self,
        until: f64,
        last: u64,
        rate: f64,
        stream: &mut Stream,
        recorder: &mut Recorder<'_>,
    ) -> Result<(), HomogeneousError> {
        let begin = self.clock.time;
        let planned = (self.gas.count() as f64 * 0.25).max(64.0);
        let span = (planned / rate).min(until - begin);
        let expected = rate * span;
        let drawn = if expected > 0.0 {
            Poisson::new(expected).map_or(0.0, |law| law.sample(stream))
        } else {
            0.0
        };
        let mut left = drawn as u64;
        let total = left;
        let end = begin + span;
        let mut draws = [S::Draw::default(); BATCH];
        let mut now = begin;
        let tracked = self.motion.is_tracked();
        while left > 0 {
            if self.stop.ends() {
                return Ok(());
            }
            let batch = left.min(BATCH as u64) as usize;
            for draw in &mut draws[..batch] {
                *draw = self.selection.draw_proposal(stream);
                self.selection.prefetch_index(draw);
            }
            for draw in &draws[..batch.min(AHEAD)] {
                self.selection.prefetch_particles(&self.gas, draw);
            }
            for number in 0..batch {
                if let Some(draw) = draws[..batch].get(number + AHEAD) {
                    self.selection.prefetch_particles(&self.gas, draw);
                }
                if tracked {
                    now += (end - now) * first_of(left, stream);
                }
                left -= 1;
                let draw = draws[number];
                let Some(candidate) = self.selection.resolve_proposal(&self.gas, &draw) else {
                    continue;
                };
                if !self.accept(&candidate, now, stream)? {
                    continue;
                }
                if !tracked {
                    now = begin + span * ((total - left) as f64 / (total + 1) as f64);
                }
                let standing = self.meet(&candidate, now, stream, recorder);
                if standing != ProposalValidity::Kept || self.tally.collisions >= last {
                    self.clock.outdated |= standing == ProposalValidity::Outdated;
                    let done = total - left;
                    self.tally.proposals += done;
                    if !tracked {
                        let place = Beta::new(done as f64, (left + 1) as f64)
                            .map_or(0.5, |law| law.sample(stream));
                        now = begin + span * place;
                    }
                    self.clock.time = now.min(until);
                    return Ok(());
                }
            }
        }
        self.tally.proposals += total;
        self.clock.time = if span < until - begin { end } else { until };
        Ok(())
    }

    /// Decides by acceptance-rejection if a candidate pair collides: with the probability relative
    /// speed over its bound.
    #[inline]
    fn accept(
        &mut self,
        candidate: &CandidatePair,
        time: f64,
        stream: &mut Stream,
    ) -> Result<bool, HomogeneousError> {
        self.tally.trials += 1;
        let [first, second] = [candidate.first, candidate.second]
            .map(|index| &self.gas.particles[index as usize].velocity);
        let square = (*first - *second).square();
        let reach = stream.random::<f64>() * candidate.bound;
        if reach * reach >= square {
            return Ok(false);
        }
        // A pair at its bound may exceed it by a few roundings.
        if square > candidate.bound * candidate.bound * (1.0 + 1e-12) {
            return Err(HomogeneousError::BoundExceeded {
                speed: square.sqrt(),
                bound: candidate.bound,
                time,
            });
        }
        Ok(true)
    }

    /// Executes the contact of an accepted pair: draws the line of centres, applies the contact
    /// rule, and updates the selection.
    #[inline]
    fn meet(
        &mut self,
        candidate: &CandidatePair,
        time: f64,
        stream: &mut Stream,
        recorder: &mut Recorder<'_>,
    ) -> ProposalValidity {
        let pair = [candidate.first, candidate.second];
        let before = pair.map(|index| self.gas.particles[index as usize].velocity);
        let relative = before[0] - before[1];
        let line = line_of_centres::<P::Space>(&relative, stream);
        if line.square() == 0.0 {
            // Grazing beyond the resolution of floating-point numbers: a collision without effect.
            self.tally.collisions += 1;
            return ProposalValidity::Kept;
        }
        for (index, velocity) in pair.iter().zip(&before) {
            self.motion.record_flight(*index, velocity, time);
        }
        let meeting = CollidingParticles {
            pair,
            relative,
            line,
        };
        match self.contacts.apply_contact(&mut self.gas, &meeting, stream) {
            ContactOutcome::Passed => ProposalValidity::Kept,
            ContactOutcome::Bounced { changed, law } => {
                self.record(&meeting, time, law, recorder);
                let mut worst = ProposalValidity::Kept;
                for side in 0..2 {
                    if changed[side] {
                        let standing = self.selection.velocity_changed(&mut self.gas, pair[side]);
                        worst = more_severe(worst, standing);
                    }
                }
                worst
            }
            ContactOutcome::Replaced { from } => {
                self.clock.since += 1;
                self.tally.collisions += 1;
                for index in pair {
                    self.gas.particles[index as usize].mark = GONE;
                }
                self.gas.gone += 2;
                let mut worst = ProposalValidity::Kept;
                for index in from..self.gas.particles.len() {
                    let standing = self.selection.particle_added(&mut self.gas, index as u32);
                    worst = more_severe(worst, standing);
                    if worst == ProposalValidity::Outdated {
                        break;
                    }
                }
                worst
            }
        }
    }

    /// Counts a bounce and passes it to the observer.
    #[inline]
    fn record(
        &mut self,
        meeting: &CollidingParticles<VectorOf<P>>,
        time: f64,
        law: Separation,
        recorder: &mut Recorder<'_>,
    ) {
        self.clock.since += 1;
        self.tally.collisions += 1;
        let partners = meeting
            .pair
            .map(|index| &self.gas.particles[index as usize]);
        let masses = partners.map(|particle| self.gas.mass(particle));
        let distance = partners
            .map(|particle| self.gas.radius(particle))
            .iter()
            .sum::<f64>();
        let length = meeting.line.square().sqrt();
        // The line points from the second to the first partner, which approach each other.
        let sign = if meeting.relative.inner(&meeting.line) > 0.0 {
            -1.0
        } else {
            1.0
        };
        let reduced_mass = masses[0] * masses[1] / (masses[0] + masses[1]);
        let line = (meeting.line * (sign * distance / length)).spatial();
        let collision = Collision {
            time,
            pair: meeting.pair,
            species: partners.map(|particle| self.gas.scene.sizes().species_of(particle.tag)),
            momentum_transfer: nalgebra::Matrix3::zeros(),
            ..Collision::at_contact(meeting.relative.spatial(), line, reduced_mass, law)
        };
        self.tally.energy_lost += collision.energy_lost();
        recorder.record(|| collision);
    }
}

/// Returns the more severe of two effects on the proposals drawn ahead.
fn more_severe(one: ProposalValidity, other: ProposalValidity) -> ProposalValidity {
    match (one, other) {
        (ProposalValidity::Outdated, _) | (_, ProposalValidity::Outdated) => {
            ProposalValidity::Outdated
        }
        (ProposalValidity::Changed, _) | (_, ProposalValidity::Changed) => {
            ProposalValidity::Changed
        }
        _ => ProposalValidity::Kept,
    }
}

/// Draws the minimum of `count` independent uniform random numbers, `1 - U^(1/count)`.
#[inline]
fn first_of(count: u64, stream: &mut Stream) -> f64 {
    let exponential: f64 = Exp1.sample(stream);
    let x = exponential / count as f64;
    if x < 1e-4 {
        // The next term is below 1e-16 of the first.
        x * (1.0 - x * (0.5 - x * (1.0 / 6.0 - x / 24.0)))
    } else {
        -(-x).exp_m1()
    }
}
