//! Builder of gases for custom programs: from numbers, densities and contact laws to particles in a
//! box.

use nalgebra::{Vector2, Vector3};
use stosszahl_model::initial::{self, Arrangement};
use stosszahl_model::random::{Purpose, Streams};
use stosszahl_model::walls::{Face, Walls};
use stosszahl_model::{
    Domain, Free, Interrupt, InvalidValue, Law, Particle, ParticleSpec, ParticleState, Particles,
    Plane, Rough, Scene, Shear, SizeDistribution, Sizes, Smooth, Space, Species, SpeciesProperties,
    State, Volume,
};

use crate::GasError;
use crate::memory::{BUILDING, need_memory};

/// Gas at one time: the particles, their contact laws, and the box. Engines start from a gas and
/// return one.
#[derive(Clone, Debug)]
pub struct Gas {
    /// Particle properties: sizes, contact laws and external field.
    pub grains: ParticleSpec,
    /// State of all particles; without positions in a homogeneous gas.
    pub particles: Particles,
    /// Faces of the box: periodic, walls, or open.
    pub walls: Walls<Volume>,
    /// Volume of the gas \[length^D\]; an area in the plane.
    pub volume: f64,
    /// Random streams from which engines and walls draw.
    pub streams: Streams,
    /// Contact time of the TC model in exact dynamics \[time\]; 0 for none.
    pub contact_time: f64,
}

impl Gas {
    /// Begins the description of a gas of `count` hard disks.
    pub fn disks(count: usize) -> GasBuilder {
        GasBuilder::new(2, count)
    }

    /// Begins the description of a homogeneous gas of `count` hard spheres without positions.
    pub fn spheres(count: usize) -> GasBuilder {
        GasBuilder::new(3, count)
    }

    /// Returns the granular temperature of the gas \[energy\].
    pub fn temperature(&self) -> f64 {
        self.particles.temperature()
    }

    /// Returns the displacement, along the first axis, of the periodic image above in a shear flow,
    /// from 0 to the width of the box \[length\]; 0 without shear.
    pub fn shear_offset(&self) -> f64 {
        self.particles.shear_offset(self.grains.shear())
    }

    /// Computes Haff's cooling time \[time\] of equal particles with one coefficient of restitution
    /// r, at their packing and temperature T. It is `t0 = 2 D/((1 - r^2) w)`, w being Enskog's
    /// collision rate per particle. Infinite for elastic particles; `None` for other gases and in a
    /// shear flow. Brilliantov & Pöschel, *Kinetic Theory of Granular Gases* (Oxford 2004).
    pub fn haff_time(&self) -> Option<f64> {
        let cools = self.grains.shear_rate.is_none();
        let restitution = self.grains.restitution.constant().filter(|_| cools)?;
        let SizeDistribution::Equal(one) = &self.grains.sizes else {
            return None;
        };
        let (dimension, count) = (self.particles.dimension, self.particles.all.len() as f64);
        let rate = if dimension == 2 {
            let packing = count * Plane::particle_volume(one.radius) / self.volume;
            Plane::collision_rate(packing, Plane::contact_value(packing))
        } else {
            let packing = count * Volume::particle_volume(one.radius) / self.volume;
            Volume::collision_rate(packing, Volume::contact_value(packing))
        };
        // A gas without positions draws its velocities when it starts.
        let temperature = Some(self.temperature()).filter(|&known| known > 0.0);
        let speed = (temperature.unwrap_or(1.0) / one.mass).sqrt();
        let rate = rate * speed / (2.0 * one.radius);
        Some(2.0 * dimension as f64 / ((1.0 - restitution * restitution) * rate))
    }
}

/// Builder of a gas from a description: numbers, sizes, densities and contact laws.
#[derive(Clone, Debug)]
#[must_use = "a description is no gas until it is built"]
pub struct GasBuilder {
    dimension: usize,
    species: Vec<SpeciesProperties>,
    packing: Option<f64>,
    size: Option<[f64; 2]>,
    walls: [[Face<Volume>; 2]; 3],
    law: Result<Law, InvalidValue>,
    tangential: Option<f64>,
    gravity: Option<Vector3<f64>>,
    shear_rate: Option<f64>,
    contact_time: f64,
    temperature: f64,
    seed: u64,
    replica: u64,
    start: Option<Particles>,
    interrupt: Interrupt,
}

impl GasBuilder {
    fn new(dimension: usize, count: usize) -> Self {
        Self {
            dimension,
            species: vec![SpeciesProperties {
                radius: 0.5,
                mass: 1.0,
                count,
            }],
            packing: None,
            size: None,
            walls: [[Face::Periodic; 2]; 3],
            law: Ok(Law::ELASTIC),
            tangential: None,
            gravity: None,
            shear_rate: None,
            contact_time: 0.0,
            temperature: 1.0,
            seed: 1,
            replica: 0,
            start: None,
            interrupt: Interrupt::default(),
        }
    }

    /// Sets the packing fraction, the share of the area or volume that particles cover, in a square
    /// box; 0.1 unless this or a box size is set.
    pub fn packing_fraction(mut self, packing_fraction: f64) -> Self {
        self.packing = Some(packing_fraction);
        self
    }

    /// Sets the sides of the box \[length\], in place of a packing fraction. Disks only.
    pub fn box_size(mut self, sides: [f64; 2]) -> Self {
        self.size = Some(sides);
        self
    }

    /// Sets a constant coefficient of normal restitution for all approach speeds; 1, elastic,
    /// unless set.
    pub fn restitution(mut self, coefficient: f64) -> Self {
        self.law = stosszahl_model::Constant::new(coefficient).map(Law::from);
        self
    }

    /// Sets the law of normal restitution, such as viscoelastic contacts.
    pub fn law(mut self, law: impl Into<Law>) -> Self {
        self.law = Ok(law.into());
        self
    }

    /// Makes particles rough, with a coefficient of tangential restitution from -1 (smooth) to 1
    /// (perfectly rough). Disks only.
    pub fn tangential_restitution(mut self, coefficient: f64) -> Self {
        self.tangential = Some(coefficient);
        self
    }

    /// Adds particles of another species by number, radius and mass.
    pub fn and(mut self, count: usize, radius: f64, mass: f64) -> Self {
        self.species.push(SpeciesProperties {
            radius,
            mass,
            count,
        });
        self
    }

    /// Sets the faces of the box along an axis, lower and upper; periodic unless set. Disks only.
    pub fn walls(mut self, axis: usize, faces: [Face<Volume>; 2]) -> Self {
        if let Some(pair) = self.walls.get_mut(axis) {
            *pair = faces;
        }
        self
    }

    /// Sets a uniform acceleration \[length/time^2\]. Disks only.
    pub fn gravity(mut self, acceleration: [f64; 2]) -> Self {
        self.gravity = Some(Vector3::new(acceleration[0], acceleration[1], 0.0));
        self
    }

    /// Puts the gas into uniform shear flow u = (a y, 0) between Lees-Edwards boundaries, with the
    /// shear rate a \[1/time\], not zero. Velocities, and all that is made of them, are then
    /// peculiar: relative to the flow. Disks only, in a periodic box without gravity. Lees &
    /// Edwards, J. Phys. C 5, 1921 (1972), doi:10.1088/0022-3719/5/15/006.
    pub fn shear_rate(mut self, shear_rate: f64) -> Self {
        self.shear_rate = Some(shear_rate);
        self
    }

    /// Sets the contact time of the TC model in exact dynamics \[time\]; 0 unless set. Contacts of
    /// disks that touched something less than this time ago are elastic, which prevents inelastic
    /// collapse: Luding & McNamara, Granular Matter 1, 113 (1998), doi:10.1007/s100350050017. Disks
    /// only.
    pub fn contact_time(mut self, contact_time: f64) -> Self {
        self.contact_time = contact_time;
        self
    }

    /// Sets the granular temperature of the start \[energy\]; 1 unless set.
    pub fn temperature(mut self, temperature: f64) -> Self {
        self.temperature = temperature;
        self
    }

    /// Sets the seed of all random numbers; 1 unless set. The same seed gives the same bytes.
    pub fn seed(mut self, seed: u64) -> Self {
        self.seed = seed;
        self
    }

    /// Sets the number of the replica, which selects other random numbers of the same seed.
    pub fn replica(mut self, replica: u64) -> Self {
        self.replica = replica;
        self
    }

    /// Sets the initial particles, such as those of [`Gas::particles`], instead of placing
    /// particles and drawing velocities. Radii, masses and species are those of the description, in
    /// its order. Along periodic axes a position may be in any image of the box, and is moved into
    /// the box; between walls it lies inside.
    pub fn start_from(mut self, particles: Particles) -> Self {
        self.start = Some(particles);
        self
    }

    /// Sets an interrupt that makes [`Self::build`] end early.
    pub fn set_stop_flag(mut self, interrupt: &Interrupt) -> Self {
        self.interrupt = interrupt.clone();
        self
    }

    /// Builds the gas: disks at random without overlap (from packing 0.45 on a lattice, to be
    /// molten by [`crate::EventDriven::equilibrate`]), with Maxwellian velocities.
    ///
    /// # Errors
    /// [`GasError`] if a number is out of range or disks find no place.
    pub fn build(self) -> Result<Gas, GasError> {
        let streams = Streams::new(self.seed, self.replica);
        InvalidValue::unless_positive("temperature", self.temperature)?;
        InvalidValue::require(
            self.contact_time >= 0.0 && self.contact_time.is_finite(),
            "contact time",
            self.contact_time,
            "finite numbers from 0",
        )?;
        if self.packing.is_some() && self.size.is_some() {
            return Err(GasError::Unfit {
                what: "a packing fraction and the size of the box together",
                instead: "give one of them",
            });
        }
        let sizes = Species::new(self.species.clone())?;
        need_memory(sizes.count(), BUILDING)?;
        let bounded = self
            .walls
            .iter()
            .flatten()
            .any(|face| *face != Face::Periodic);
        let places = bounded
            || self.gravity.is_some()
            || self.shear_rate.is_some()
            || self.contact_time > 0.0;
        if self.dimension == 3 && (places || self.tangential.is_some()) {
            return Err(GasError::Unfit {
                what: "walls, gravity, shear, spin or a contact time of spheres without positions",
                instead: "use a gas of disks, or a case file for spheres in a box",
            });
        }
        let rough = self.tangential.map(|beta| Rough::new(beta, Plane::INERTIA));
        let grains = ParticleSpec {
            sizes: match &self.species[..] {
                [one] => SizeDistribution::Equal(stosszahl_model::Monodisperse {
                    radius: one.radius,
                    mass: one.mass,
                }),
                _ => SizeDistribution::Species(sizes.clone()),
            },
            restitution: self.law.clone()?,
            rough: rough.transpose()?,
            gravity: self.gravity,
            shear_rate: self.shear_rate,
            shear_offset: 0.0,
            is_bounded: bounded,
        };
        if self.shear_rate.is_some() {
            grains.sheared_smooth::<Plane, _>(())?;
        }
        let covered = self.species.iter().map(|kind| {
            let ball = match self.dimension {
                2 => Plane::particle_volume(kind.radius),
                _ => Volume::particle_volume(kind.radius),
            };
            kind.count as f64 * ball
        });
        let volume = match (&self.start, self.size) {
            (Some(start), _) if start.lengths[0] > 0.0 => start.volume(),
            (_, Some([x, y])) => x * y,
            (_, None) => {
                let packing = self.packing.unwrap_or(0.1);
                covered.sum::<f64>() / InvalidValue::unless_positive("packing fraction", packing)?
            }
        };
        let walls = Walls::new(&self.walls)?;
        let particles = match &self.start {
            Some(start) => self.given(start, &sizes, &walls)?,
            None if self.dimension == 2 => self.placed(&sizes, volume, streams)?,
            None => self.unplaced(&sizes),
        };
        Ok(Gas {
            grains,
            particles,
            walls,
            volume,
            streams,
            contact_time: self.contact_time,
        })
    }

    /// Checks that given particles can be the initial state: sizes, positions, velocities. Overlaps
    /// are found by the engine.
    fn given(
        &self,
        start: &Particles,
        sizes: &Species,
        walls: &Walls<Volume>,
    ) -> Result<Particles, GasError> {
        let refused = |found: String, allowed: &'static str| GasError::Start { found, allowed };
        if start.dimension != self.dimension {
            let found = format!("particles in {} dimensions", start.dimension);
            return Err(refused(found, "2 for disks, 3 for spheres"));
        }
        let (found, count) = (start.all.len(), sizes.count());
        if found == 0 || found != count {
            let found = format!("{found} particles in a gas that has {count}");
            return Err(refused(found, "as many as the gas has, and at least one"));
        }
        if !start.time.is_finite() {
            return Err(refused(format!("time {}", start.time), "a finite time"));
        }
        for (number, one) in start.all.iter().enumerate() {
            if !one
                .position
                .iter()
                .chain(&one.velocity)
                .chain(&one.spin)
                .all(|x| x.is_finite())
            {
                let found = format!("a number of particle {number} that is not finite");
                return Err(refused(found, "finite numbers"));
            }
        }
        let mut lengths = Vector3::from(start.lengths);
        if self.dimension == 2 {
            lengths[2] = 1.0;
        }
        let has_places = start.lengths[0] > 0.0;
        let shear = self.shear_rate.map(|rate| Shear { rate, offset: 0.0 });
        let domain = has_places.then(|| walls.domain(lengths)?.in_flow(shear, start.time));
        let domain = domain.transpose()?;
        let place = |number: usize, position: Vector3<f64>| {
            let inside = domain.map_or(position, |domain| domain.wrap(position));
            let is_outside = |axis: &usize| !(0.0..=lengths[*axis]).contains(&inside[*axis]);
            match (0..self.dimension).find(is_outside) {
                Some(axis) if has_places => {
                    let (at, side) = (position[axis], lengths[axis]);
                    let found =
                        format!("particle {number} at {at} along axis {axis} of a box of {side}");
                    Err(refused(
                        found,
                        "positions inside the box where it has walls",
                    ))
                }
                _ => Ok(inside),
            }
        };
        let kind = |index: usize| match sizes.kinds() {
            [_] => 0,
            _ => sizes.species_of(sizes.tag_of(index)),
        };
        let particle = |(index, one): (usize, &Particle)| {
            let species = kind(index);
            let SpeciesProperties { radius, mass, .. } = sizes.kinds()[species as usize];
            Ok(Particle {
                position: place(index, one.position)?,
                radius,
                mass,
                species,
                ..*one
            })
        };
        let all = start.all.iter().enumerate().map(particle);
        Ok(Particles {
            all: all.collect::<Result<_, GasError>>()?,
            ..start.clone()
        })
    }

    fn unplaced(&self, sizes: &Species) -> Particles {
        let kinds = sizes.kinds().iter().zip(0..);
        let particle = |(kind, species): (&SpeciesProperties, u32)| {
            let one = Particle {
                species,
                ..Particle::at_rest(kind.radius, kind.mass)
            };
            std::iter::repeat_n(one, kind.count)
        };
        Particles {
            time: 0.0,
            dimension: self.dimension,
            lengths: [0.0; 3],
            periodic: [true; 3],
            all: kinds.flat_map(particle).collect(),
        }
    }

    fn placed(
        &self,
        sizes: &Species,
        volume: f64,
        streams: Streams,
    ) -> Result<Particles, GasError> {
        let [x, y] = self.size.unwrap_or([volume.sqrt(); 2]);
        let largest = sizes.largest_radius();
        // Between walls, centres keep a radius away: they are placed in a periodic box that is
        // smaller by a diameter, and moved by a radius.
        let walled = [0, 1].map(|axis| self.walls[axis][0] != Face::Periodic);
        let margin = walled.map(|is| if is { largest * (1.0 + 1e-9) } else { 0.0 });
        let inner = Vector2::new(x - 2.0 * margin[0], y - 2.0 * margin[1]);
        let domain = Domain::<Plane>::periodic(inner)?;
        let count = sizes.count();
        let positions = if sizes.kinds().len() == 1 {
            initial::place_disks(
                Arrangement::Disordered,
                count,
                2.0 * largest,
                &domain,
                &streams,
                &self.interrupt,
            )?
        } else {
            let radii: Vec<f64> = (0..count).map(|i| sizes.radius(sizes.tag_of(i))).collect();
            initial::place_unequal(&radii, &domain, &streams, &self.interrupt)?
        };
        let scene = Scene {
            space: Plane,
            surface: Smooth,
            restitution: Law::ELASTIC,
            sizes: sizes.clone(),
            field: Free,
        };
        let shift = Vector2::from(margin);
        let body =
            |at: &Vector2<f64>| ParticleState::new(domain.wrap(*at) + shift, Vector2::zeros());
        let mut state = State {
            time: 0.0,
            domain,
            bodies: positions.positions.iter().map(body).collect(),
        };
        let mut stream = streams.stream_at(Purpose::Velocities, [0, 0]);
        initial::maxwellian(&scene, &mut state, self.temperature, &mut stream);
        let mut particles = self.unplaced(sizes);
        for (particle, body) in particles.all.iter_mut().zip(&state.bodies) {
            particle.position = Vector3::new(body.position[0], body.position[1], 0.0);
            particle.velocity = Vector3::new(body.velocity[0], body.velocity[1], 0.0);
        }
        particles.lengths = [x, y, 0.0];
        particles.periodic = [!walled[0], !walled[1], true];
        Ok(particles)
    }
}
