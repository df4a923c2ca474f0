//! Aggregation and fragmentation: clusters of monomers that merge or break into monomers on
//! contact, by thresholds of the relative energy or speed.

use rand::Rng;
use rand_distr::{Distribution, StandardNormal};
use serde::{Deserialize, Serialize};
use stosszahl_model::{Clusters, InvalidValue, ParticleModel, Sizes, Space, Vector, VectorOf};

use super::contact::{Bounce, CollidingParticles, ContactOutcome, ContactRule};
use super::gas::{GasParticle, HomogeneousGas, SmoothPhysics};

/// Part of the relative kinetic energy of a pair that is compared with a threshold: all, or that
/// along the line of centres.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum EnergyLoss {
    /// Kinetic energy of the whole relative motion, `mu g^2/2`, with the reduced mass mu.
    Full,
    /// Kinetic energy of the relative motion along the line of centres, `mu (g . e)^2/2`, with the
    /// reduced mass mu.
    Normal,
}

/// Value of a threshold of aggregation or fragmentation, as energy or speed; infinity is allowed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum EnergyLimit {
    /// Threshold energy of the relative motion \[energy\].
    Energy(f64),
    /// Threshold of the relative speed, for any masses \[length/time\].
    Speed(f64),
}

impl EnergyLimit {
    /// Returns the threshold as energy of the relative motion, for a reduced mass \[energy\].
    fn energy(self, reduced: f64) -> f64 {
        match self {
            Self::Energy(energy) => energy,
            Self::Speed(speed) => 0.5 * reduced * speed * speed,
        }
    }
}

/// Threshold of energy or speed below which particles aggregate, or above which they break.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Threshold {
    /// Value of the threshold, an energy or a speed.
    pub limit: EnergyLimit,
    /// Part of the relative motion that is compared with the threshold.
    pub part: EnergyLoss,
}

/// Order in which the conditions of aggregation and of fragmentation are tested, if both hold.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum TestOrder {
    /// Aggregation is tested before fragmentation.
    StickFirst,
    /// Fragmentation is tested before aggregation.
    BreakFirst,
}

/// Rule of aggregation and fragmentation: when particles merge, break into monomers, or bounce.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct AggregationRule {
    /// Threshold below which the two particles of a pair merge.
    pub stick: Threshold,
    /// Threshold above which pairs of clusters with three monomers or more break into monomers; two
    /// monomers bounce.
    pub shatter: Threshold,
    /// Order in which the two thresholds are tested, if both conditions hold.
    pub order: TestOrder,
    /// Factor on the relative speed in fragmentation, 0 to 1: its square is the fraction of the
    /// relative kinetic energy that remains kinetic.
    pub retained: f64,
    /// Largest number of particles of the gas; pairs that would break beyond it bounce, and are
    /// counted.
    pub most: usize,
}

/// Ledger of aggregation and fragmentation: energy lost, and number of events, of each kind.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct AggregationLedger {
    /// Kinetic energy lost in aggregation \[energy\].
    pub stuck: f64,
    /// Kinetic energy lost in fragmentation \[energy\].
    pub shattered: f64,
    /// Number of aggregations: pairs that merged.
    pub mergers: u64,
    /// Number of fragmentations: pairs that broke into monomers.
    pub shatterings: u64,
    /// Number of pairs that bounced instead of merging or breaking, because the gas or the cluster
    /// would have become too large.
    pub refused: u64,
}

/// Contact rule of clusters of monomers: pairs merge (aggregation) below one energy or relative
/// speed, break (fragmentation) above another, and bounce in between.
///
/// Sticking conserves mass and momentum; the energy `mu g^2/2` goes into the ledger. Breaking turns
/// both partners into their k + j monomers, with the velocity of the centre of mass. Relative
/// velocities are drawn uniformly from all sets with zero momentum and energy `retained^2 mu g^2/2`
/// (microcanonical measure: Gaussian vectors, minus their mean, scaled). So each event conserves
/// momentum and energy to rounding. Fixing the last monomer's velocity by momentum alone, as is
/// sometimes proposed, creates energy.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Sticking {
    /// Thresholds and parameters of aggregation and fragmentation.
    pub rule: AggregationRule,
    /// Energy lost and number of events by aggregation and fragmentation so far.
    pub ledger: AggregationLedger,
}

enum Fate {
    Stick(u32),
    Shatter(u32),
    Bounce,
}

impl Sticking {
    /// Creates the contact rule of aggregation and fragmentation, with an empty ledger.
    ///
    /// # Errors
    /// [`InvalidValue`] unless thresholds are numbers not below zero and `retained` is from 0 to 1.
    pub fn new(rule: AggregationRule) -> Result<Self, InvalidValue> {
        for threshold in [rule.stick, rule.shatter] {
            let (what, value) = match threshold.limit {
                EnergyLimit::Energy(energy) => ("threshold energy", energy),
                EnergyLimit::Speed(speed) => ("threshold speed", speed),
            };
            InvalidValue::require(value >= 0.0, what, value, "at least 0")?;
        }
        let kept = rule.retained;
        let allowed = (0.0..=1.0).contains(&kept);
        InvalidValue::require(allowed, "speed kept in breaking", kept, "0 to 1")?;
        Ok(Self {
            rule,
            ledger: AggregationLedger::default(),
        })
    }

    /// Decides whether a pair merges, breaks or bounces. `monomers` are the cluster sizes,
    /// `energies` those of its relative motion and of the part along the line of centres.
    fn fate(
        &mut self,
        monomers: [u32; 2],
        reduced: f64,
        energies: [f64; 2],
        particles: usize,
    ) -> Fate {
        let rule = &self.rule;
        let part = |threshold: Threshold| match threshold.part {
            EnergyLoss::Full => energies[0],
            EnergyLoss::Normal => energies[1],
        };
        let stick = part(rule.stick) < rule.stick.limit.energy(reduced);
        let large = monomers[0] > 1 || monomers[1] > 1;
        let shatter = large && part(rule.shatter) > rule.shatter.limit.energy(reduced);
        let stick = stick && !(shatter && rule.order == TestOrder::BreakFirst);
        if !(stick || shatter) {
            return Fate::Bounce;
        }
        match monomers[0].checked_add(monomers[1]) {
            Some(total) if stick => Fate::Stick(total),
            Some(total) if particles + total as usize <= rule.most => Fate::Shatter(total),
            _ => {
                self.ledger.refused += 1;
                Fate::Bounce
            }
        }
    }
}

/// Draws the velocities of `count` equal fragments with zero total momentum and mean squared speed
/// `square`, uniformly from all such sets (microcanonical).
pub fn shards<S: Space>(count: u32, square: f64, stream: &mut impl Rng) -> Vec<S::Vector> {
    let n = f64::from(count);
    let mut velocities: Vec<S::Vector> = (0..count)
        .map(|_| {
            let mut velocity = S::Vector::default();
            for axis in 0..S::DIMENSION {
                velocity[axis] = StandardNormal.sample(stream);
            }
            velocity
        })
        .collect();
    // The second pass takes out what the rounding of the first left.
    for _ in 0..2 {
        let mut mean = S::Vector::default();
        for velocity in &velocities {
            mean += *velocity;
        }
        for velocity in &mut velocities {
            *velocity -= mean * (1.0 / n);
        }
    }
    let found: f64 = velocities.iter().map(Vector::square).sum();
    let factor = if found > 0.0 {
        (n * square / found).sqrt()
    } else {
        0.0
    };
    for velocity in &mut velocities {
        *velocity = *velocity * factor;
    }
    velocities
}

impl<P: SmoothPhysics<Sizes = Clusters>> ContactRule<P> for Sticking {
    const SIZES_CHANGE: bool = true;

    fn apply_contact(
        &mut self,
        gas: &mut HomogeneousGas<P>,
        meeting: &CollidingParticles<VectorOf<P>>,
        stream: &mut impl Rng,
    ) -> ContactOutcome {
        let partners = meeting.pair.map(|index| gas.particles[index as usize]);
        let masses = partners.map(|particle| gas.mass(&particle));
        let total_mass = masses[0] + masses[1];
        let reduced = masses[0] * (masses[1] / total_mass);
        let along = meeting.relative.inner(&meeting.line);
        let full = 0.5 * reduced * meeting.relative.square();
        let normal = 0.5 * reduced * (along * along / meeting.line.square());
        let monomers = partners.map(|particle| particle.tag);
        let common = partners[0].velocity * (masses[0] / total_mass)
            + partners[1].velocity * (masses[1] / total_mass);
        let from = gas.particles.len();
        match self.fate(monomers, reduced, [full, normal], gas.count()) {
            Fate::Stick(total) => {
                self.ledger.mergers += 1;
                self.ledger.stuck += full;
                gas.particles.push(GasParticle::new(common, total));
                ContactOutcome::Replaced { from }
            }
            Fate::Shatter(total) => {
                let kept = self.rule.retained * self.rule.retained;
                self.ledger.shatterings += 1;
                self.ledger.shattered += (1.0 - kept) * full;
                let monomer = gas.scene.sizes().mass(1);
                let square = 2.0 * kept * full / (monomer * f64::from(total));
                let shards = shards::<<P as ParticleModel>::Space>(total, square, stream);
                let whole = shards
                    .into_iter()
                    .map(|shard| GasParticle::new(common + shard, 1));
                gas.particles.extend(whole);
                ContactOutcome::Replaced { from }
            }
            Fate::Bounce => Bounce.apply_contact(gas, meeting, stream),
        }
    }
}

/// Counts the clusters of each size: pairs of monomer number and cluster count, in rising order.
pub fn size_distribution<P: SmoothPhysics<Sizes = Clusters>>(
    gas: &HomogeneousGas<P>,
) -> Vec<(u32, u64)> {
    let mut counts = std::collections::BTreeMap::new();
    for particle in gas.alive() {
        *counts.entry(particle.tag).or_insert(0_u64) += 1;
    }
    counts.into_iter().collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rule(stick: EnergyLimit, shatter: EnergyLimit) -> Sticking {
        let threshold = |limit| Threshold {
            limit,
            part: EnergyLoss::Full,
        };
        let rule = AggregationRule {
            stick: threshold(stick),
            shatter: threshold(shatter),
            order: TestOrder::StickFirst,
            retained: 0.5,
            most: 100,
        };
        Sticking::new(rule).expect("a rule")
    }

    /// Two dimers of mass 2 and two clusters of mass 20 meet at speed 3: a limit of speed treats
    /// them alike, one of energy does not.
    #[test]
    fn a_limit_of_speed_knows_no_masses() {
        let fates = |stick: EnergyLimit, shatter: EnergyLimit| {
            let mut sticking = rule(stick, shatter);
            [1.0, 10.0].map(|reduced| {
                let energy = 0.5 * reduced * 9.0;
                match sticking.fate([2, 2], reduced, [energy; 2], 10) {
                    Fate::Stick(_) => 's',
                    Fate::Shatter(_) => 'b',
                    Fate::Bounce => '-',
                }
            })
        };
        let (speed, energy) = (EnergyLimit::Speed, EnergyLimit::Energy);
        let never = energy(f64::INFINITY);
        assert_eq!(fates(speed(3.1), never), ['s', 's']);
        assert_eq!(fates(speed(2.9), never), ['-', '-']);
        assert_eq!(fates(energy(4.6), never), ['s', '-']);
        assert_eq!(fates(speed(0.0), speed(2.9)), ['b', 'b']);
        assert_eq!(fates(speed(0.0), speed(3.1)), ['-', '-']);
        assert_eq!(fates(energy(0.0), energy(5.0)), ['-', 'b']);
        assert!(Sticking::new(rule(speed(1.0), never).rule).is_ok());
        let bad = AggregationRule {
            stick: Threshold {
                limit: speed(-1.0),
                part: EnergyLoss::Full,
            },
            ..rule(speed(1.0), never).rule
        };
        assert!(Sticking::new(bad).is_err());
    }
}
