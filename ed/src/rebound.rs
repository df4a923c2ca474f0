//! Contact of a disk with a wall or an obstacle: rebound by the wall law, ledger of momentum and
//! energy, and collapse at a wall.

use nalgebra::Vector2;
use stosszahl_model::random::Purpose;
use stosszahl_model::walls::Touch;
use stosszahl_model::{Field, ParticleModel, Plane, Rebound, Sizes, SpinOf, Surface};

use crate::calendar::Calendar;
use crate::cells::NONE;
use crate::checkpoint::DissipationRule;
use crate::engine::EventDrivenEngine;
use crate::error::{EventDrivenError, Touchable};
use crate::strip_log::WallImpulse;
use crate::surroundings::Touched;

/// Shortest time of flight after a contact with a wall that a field pulls the disk back to, in
/// contact times of the TC model. So a disk at rest on a floor has finitely many contacts, all
/// elastic.
const LEAST_HOP: f64 = 0.5;

impl<P, Q> EventDrivenEngine<P, Q>
where
    P: ParticleModel<Space = Plane>,
    Q: Calendar,
{
    /// Executes the contact of a disk with the wall or obstacle `what`. `ends` is true if the run
    /// has an end time.
    pub(crate) fn rebound(
        &mut self,
        who: u32,
        what: u32,
        ends: bool,
    ) -> Result<(), EventDrivenError> {
        let (now, speed) = (self.now, self.speed);
        self.disks.meet(who, now);
        let place = self.disks.wrapped_position(who, now);
        let touched = self.surroundings.touched(what, place, now);
        let sizes = self.scene.sizes();
        let tag = self.tags[who as usize];
        let (mass, radius) = (sizes.mass(tag), sizes.radius(tag));
        let before = self.disks.all[who as usize].velocity * speed;
        let spin_before = self.absolute_spin(who);
        let approach = -(before - touched.velocity).dot(&touched.normal);

        let law = self.law_of(who, &touched.rebound);
        let touch = Touch {
            normal: touched.normal,
            wall: touched.velocity,
            mass,
            radius,
        };
        let (mut velocity, mut spin) = (before, spin_before);
        // The count of the disk's own contacts: that of all would depend on what happens elsewhere.
        let count = &mut self.rebounds[who as usize];
        let address = [u64::from(*count), u64::from(self.names[who as usize])];
        *count = count.wrapping_add(1);
        let streams = self.surroundings.boundaries.streams;
        law.apply(&self.scene, &touch, &mut velocity, &mut spin, || {
            streams.stream_at(Purpose::Walls, address)
        });
        self.send_off(&touched, &mut velocity);
        self.tally.rebounds += 1;

        let energy = |velocity: Vector2<f64>, spin: SpinOf<P>| {
            let spinning = self.scene.surface().spin_energy(mass, radius, spin);
            0.5 * mass * velocity.norm_squared() + spinning
        };
        let gained = energy(velocity, spin) - energy(before, spin_before);
        let given = WallImpulse {
            ledger: touched.ledger,
            momentum: (velocity - before) * mass,
            energy: gained,
        };
        self.disks.all[who as usize].velocity = velocity / speed;
        if P::Surface::ROUGH {
            self.spins[who as usize] =
                <P::Surface as Surface<Plane>>::scale_spin(spin, 1.0 / speed);
        }
        self.predict(who);

        let latest = self.latest([who, NONE], now);
        let is_negligible = latest.is_negligible(approach / speed, 2.0 * radius);
        if self.window.is_some() {
            self.log_rebound(&latest, is_negligible, ends, given);
            return Ok(());
        }
        self.account_for(&given);
        if let Some(crossings) = self.progress.rebound(ends, self.names.len()) {
            self.time = self.epoch + now / speed;
            return Err(EventDrivenError::NoCollisions {
                time: self.time,
                crossings,
            });
        }
        if (self.progress).collision(self.tally.contacts(), &latest, is_negligible) {
            return Err(self.wall_collapse(who, &touched));
        }
        Ok(())
    }

    /// Adds the momentum and energy that a wall or obstacle has given to the gas to its ledger.
    pub(crate) fn account_for(&mut self, given: &WallImpulse) {
        self.ledgers[given.ledger].enter(1.0, given.momentum, given.energy);
    }

    /// Returns the angular velocity of a disk in the units of the state \[1/time\].
    fn absolute_spin(&self, who: u32) -> SpinOf<P> {
        <P::Surface as Surface<Plane>>::scale_spin(self.spin(who), self.speed)
    }

    /// Returns the collision law of a wall or obstacle for a disk; an elastic law where the rule of
    /// dissipation makes the contact elastic.
    fn law_of(&mut self, who: u32, rebound: &Rebound) -> Rebound {
        const SPECULAR: Rebound = Rebound::Restitutive {
            restitution: 1.0,
            slip: 1.0,
        };
        match self.dissipation {
            DissipationRule::Elastic => SPECULAR,
            DissipationRule::Scene => *rebound,
            DissipationRule::ContactTime(contact_time) => {
                let recent = self.touches_again(who, contact_time);
                self.tally.elastic_contacts += u64::from(recent);
                if recent { SPECULAR } else { *rebound }
            }
        }
    }

    /// Raises the normal velocity of a disk after a contact so that it leaves the wall or obstacle
    /// in spite of rounding. In the TC model a disk that a field holds down leaves for at least
    /// part of the contact time. Momentum and energy added go to the wall's ledger.
    fn send_off(&self, touched: &Touched, velocity: &mut Vector2<f64>) {
        let normal = touched.normal;
        let away = |velocity: &Vector2<f64>| (*velocity - touched.velocity).dot(&normal);
        let mut least = f64::EPSILON * velocity.amax().max(touched.velocity.amax());
        least = least.max(f64::MIN_POSITIVE);
        while away(velocity) < 0.0 {
            *velocity += normal * least;
            least *= 2.0;
        }
        if let DissipationRule::ContactTime(contact_time) = self.dissipation
            && !P::Field::FREE
        {
            let pull = -self.scene.field().acceleration().dot(&normal);
            // Not higher than the box, however long contacts are.
            let highest = (2.0 * pull.max(0.0) * self.domain.lengths().amax()).sqrt();
            let hop = (0.5 * LEAST_HOP * pull * contact_time).min(highest);
            let lacking = hop - away(velocity);
            if pull > 0.0 && lacking > 0.0 {
                *velocity += normal * lacking;
            }
        }
    }

    /// Sets the clock to the time of a collapse at a wall or obstacle, and returns the error.
    #[cold]
    fn wall_collapse(&mut self, who: u32, touched: &Touched) -> EventDrivenError {
        self.time = self.epoch + self.now / self.speed;
        EventDrivenError::WallCollapse {
            time: self.time,
            collisions: self.progress.stalled(self.tally.contacts()),
            disk: self.names[who as usize] as usize,
            what: Touchable::of_ledger(touched.ledger),
            cluster: self.cluster(),
            place: self
                .domain
                .wrap(self.disks.wrapped_position(who, self.now))
                .into(),
        }
    }

    /// Returns the error that a disk went through the wall at a face of the box.
    #[cold]
    pub(crate) fn escaped(&mut self, who: u32, axis: usize, forward: bool) -> EventDrivenError {
        self.time = self.epoch + self.now / self.speed;
        EventDrivenError::Escaped {
            disk: self.names[who as usize] as usize,
            wall: Touchable::Wall {
                axis,
                side: usize::from(forward),
            },
            time: self.time,
        }
    }
}
