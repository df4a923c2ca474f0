//! Collision of two disks at contact: post-collisional velocities and spins, dissipation by the
//! chosen rule, counters, and the record for observers.

use nalgebra::Vector2;
use stosszahl_model::{
    CollidingPair, Collision, Field, ParticleModel, Plane, RecentContacts, Recorder, Restitution,
    Separation, Sizes, SpinOf, Surface, Vector, bounce, collide,
};

use crate::calendar::Calendar;
use crate::cells::NONE;
use crate::checkpoint::DissipationRule;
use crate::collapse::ContactInfo;
use crate::engine::EventDrivenEngine;
use crate::error::EventDrivenError;

impl<P, Q> EventDrivenEngine<P, Q>
where
    P: ParticleModel<Space = Plane>,
    Q: Calendar,
{
    /// Executes the collision of two disks: sets their velocities and spins, counts it, and passes
    /// it to the recorder.
    #[inline(always)]
    pub(crate) fn collide(
        &mut self,
        first: u32,
        second: u32,
        recorder: &mut Recorder<'_>,
    ) -> Result<(), EventDrivenError> {
        let now = self.now;
        self.tally.collisions += 1;
        self.enter_flight(first);
        self.enter_flight(second);
        self.disks.meet(first, now);
        self.disks.meet(second, now);
        let distance = self.contact_distance(first, second);
        let (line, slip) = self.disks.line(first, second, distance);
        let mut velocities = [
            self.disks.all[first as usize].velocity,
            self.disks.all[second as usize].velocity,
        ];
        if P::Field::SHEARED {
            // In the frame of the first.
            velocities[1][0] -= slip;
        }
        let sizes = self.scene.sizes();
        let masses = [
            sizes.mass(self.tags[first as usize]),
            sizes.mass(self.tags[second as usize]),
        ];
        let radii = [
            sizes.radius(self.tags[first as usize]),
            sizes.radius(self.tags[second as usize]),
        ];
        let relative = velocities[0] - velocities[1];
        let approach = -relative.dot(&line) / line.norm();
        let kinds = [first, second].map(|disk| sizes.species_of(self.tags[disk as usize]));
        let law = self.restitution([first, second], kinds, approach * self.speed);
        let mut pair = CollidingPair {
            velocities,
            spins: [self.spin(first), self.spin(second)],
            masses,
            radii,
            line,
        };
        let contact = law.unwrap_or(Separation::ELASTIC);
        let after = match law {
            Some(law) => collide(&self.scene, &pair, law.in_units(self.speed)),
            None => bounce(&pair, 1.0),
        };
        pair.velocities = after.velocities;
        if (pair.velocities[0] - pair.velocities[1]).dot(&line) < 0.0 {
            separate_pair(&mut pair);
        }
        if P::Field::SHEARED {
            self.enter_contact(&pair, velocities, after.spins);
            pair.velocities[1][0] += slip;
        }
        if P::Surface::ROUGH {
            self.spins[first as usize] = after.spins[0];
            self.spins[second as usize] = after.spins[1];
        }
        self.disks.all[first as usize].velocity = pair.velocities[0];
        self.disks.all[second as usize].velocity = pair.velocities[1];
        if recorder.looks() {
            let gained = (pair.velocities[0] - velocities[0]) * masses[0];
            self.record([first, second], [relative, line, gained], contact, recorder);
        }
        self.predict_both(first, second);
        let latest = self.latest([first, second], now);
        let is_negligible = latest.is_negligible(approach, distance);
        if self.window.is_some() {
            self.log_contact(&latest, is_negligible);
        } else if (self.progress).collision(self.tally.contacts(), &latest, is_negligible) {
            return Err(self.collapse(latest.pair));
        }
        Ok(())
    }

    /// Adds a collision to the energy balance of a shear flow: the work of the flow during contact
    /// and the dissipated energy, from the velocities before and the spins after.
    fn enter_contact(
        &mut self,
        pair: &CollidingPair<Vector2<f64>, SpinOf<P>>,
        before: [Vector2<f64>; 2],
        spins: [SpinOf<P>; 2],
    ) {
        let unit = self.speed * self.speed;
        let kick = pair.masses[0] * (pair.velocities[0][0] - before[0][0]);
        self.shear_work.collisional -= self.disks.rows.rate() * pair.line[1] * kick * unit;
        let surface = self.scene.surface();
        let lost = |one: usize| {
            let (mass, radius) = (pair.masses[one], pair.radii[one]);
            let spinning = surface.spin_energy(mass, radius, pair.spins[one])
                - surface.spin_energy(mass, radius, spins[one]);
            let moving = before[one].norm_squared() - pair.velocities[one].norm_squared();
            0.5 * mass * moving + spinning
        };
        self.shear_work.dissipated += (lost(0) + lost(1)) * unit;
    }

    /// Returns a contact of `pair` at engine time `now` with the data that the detector of collapse
    /// needs.
    #[inline(always)]
    pub(crate) fn latest(&self, pair: [u32; 2], now: f64) -> ContactInfo {
        ContactInfo {
            pair,
            now,
            absolute_time: self.epoch * self.speed + now,
            unit: self.unit,
            disks: self.names.len(),
            straight: P::Field::FREE,
        }
    }

    /// Passes a collision to the recorder, with relative velocity before, line of centres and
    /// momentum gained by the first disk, all in engine units. Never inlined: the loop over events
    /// keeps its registers without an observer.
    #[cold]
    #[inline(never)]
    fn record(
        &self,
        pair: [u32; 2],
        [relative, line, gained]: [Vector2<f64>; 3],
        contact: Separation,
        recorder: &mut Recorder<'_>,
    ) {
        if self.window.as_ref().is_some_and(|window| !window.owns()) {
            return;
        }
        let sizes = self.scene.sizes();
        let tags = pair.map(|disk| self.tags[disk as usize]);
        let masses = tags.map(|tag| sizes.mass(tag));
        recorder.record(|| Collision {
            time: self.epoch + self.now / self.speed,
            position: self.disks.wrapped_position(pair[0], self.now).spatial(),
            relative_velocity: (relative * self.speed).spatial(),
            line: line.spatial(),
            reduced_mass: masses[0] * masses[1] / (masses[0] + masses[1]),
            restitution: contact.coefficient,
            added_speed: contact.added_speed,
            momentum_transfer: line.spatial() * (gained * self.speed).spatial().transpose(),
            weight: 1.0,
            pair: pair.map(|disk| self.names[disk as usize]),
            species: tags.map(|tag| sizes.species_of(tag)),
        });
    }

    /// Returns the result of the collision law for a contact at the given approach speed, in
    /// physical units; `None` if the contact is elastic and smooth, by the rule of dissipation.
    #[inline(always)]
    fn restitution(
        &mut self,
        pair: [u32; 2],
        kinds: [u32; 2],
        approach: f64,
    ) -> Option<Separation> {
        let law = |scene: &P| Some(scene.restitution().separation(kinds, approach.max(0.0)));
        match self.dissipation {
            DissipationRule::Elastic => None,
            DissipationRule::Scene => law(&self.scene),
            DissipationRule::ContactTime(contact_time) => {
                let recent = pair.map(|who| self.touches_again(who, contact_time));
                let recent = recent[0] | recent[1];
                self.tally.elastic_contacts += u64::from(recent);
                if recent { None } else { law(&self.scene) }
            }
        }
    }

    /// Returns true if the last contact of a disk was less than the contact time of the TC model
    /// ago; records the current contact.
    #[inline]
    pub(crate) fn touches_again(&mut self, who: u32, contact_time: f64) -> bool {
        let last = &mut self.last_contact[who as usize];
        let recent = self.now - *last < contact_time * self.speed;
        *last = self.now;
        recent
    }

    /// Returns the disks of the latest contacts, the cluster of a collapse, by their indices in the
    /// state.
    pub(crate) fn cluster(&self) -> Vec<usize> {
        let name = |disk: u32| self.names[disk as usize] as usize;
        let mut cluster: Vec<usize> = self.progress.cluster().into_iter().map(name).collect();
        cluster.sort_unstable();
        cluster
    }

    /// Returns a summary of the latest contacts, with disks by their indices in the state.
    pub(crate) fn recent_contacts(&self) -> RecentContacts {
        let name = |disk: u32| self.names[disk as usize] as usize;
        let disks = |pair: [u32; 2]| pair.into_iter().filter(|&disk| disk != NONE).map(name);
        let mut recent = RecentContacts::from_contacts(self.progress.recent().map(disks));
        let busiest = recent.busiest.first().copied();
        let disk = self
            .progress
            .recent()
            .flatten()
            .find(|&disk| disk != NONE && Some(name(disk)) == busiest);
        if let Some(disk) = disk {
            let place = self
                .domain
                .wrap(self.disks.wrapped_position(disk, self.now));
            recent.place = place.spatial().into();
        }
        recent
    }

    /// Sets the clock to the time of the collapse, and returns the error of an inelastic collapse
    /// at a contact of `pair`.
    #[cold]
    fn collapse(&mut self, pair: [u32; 2]) -> EventDrivenError {
        self.time = self.epoch + self.now / self.speed;
        let name = |disk: u32| self.names[disk as usize] as usize;
        EventDrivenError::InelasticCollapse {
            time: self.time,
            collisions: self.progress.stalled(self.tally.contacts()),
            pair: pair.map(name),
            cluster: self.cluster(),
            place: self
                .domain
                .wrap(self.disks.wrapped_position(pair[0], self.now))
                .into(),
        }
    }
}

/// Separates two disks that still approach after a contact without rebound, by the rounding of
/// their velocities: they would overlap otherwise. Their velocities change by the least difference,
/// which changes the energy by the square of that.
#[cold]
fn separate_pair<W: Copy>(pair: &mut CollidingPair<Vector2<f64>, W>) {
    pair.velocities = bounce(pair, 1.0).velocities;
    let total = pair.masses[0] + pair.masses[1];
    let normal = pair.line.normalize();
    let speed = pair.velocities[0].amax().max(pair.velocities[1].amax());
    let mut least = (f64::EPSILON * speed).max(f64::MIN_POSITIVE);
    while (pair.velocities[0] - pair.velocities[1]).dot(&pair.line) < 0.0 {
        pair.velocities[0] += normal * (least * pair.masses[1] / total);
        pair.velocities[1] -= normal * (least * pair.masses[0] / total);
        least *= 2.0;
    }
}
