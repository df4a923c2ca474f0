//! The numerical choices of a run, and why an engine cannot start.

use serde::{Deserialize, Serialize};
use stosszahl_model::walls::ObstacleError;
use stosszahl_model::{Domain, Invalid, MessageUnits, Space, brief};

use crate::scheme::Scheme;

/// How far the partners of a collision within a cell are displaced, along the momentum that each receives.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Displacement {
    /// Not at all.
    None,
    /// By the contact distance d: Alexander, Garcia & Alder, Phys. Rev. Lett. 74, 5212 (1995),
    /// doi:10.1103/PhysRevLett.74.5212. The collisional pressure is then that of elastic hard particles, and 2r/(1 + r) of
    /// it for a restitution r, which shortens the momentum that is carried.
    Diameter,
    /// By d (1 + r)/(2r), which makes up for that. Not for restitution 0.
    Inelastic,
}

/// How several simulators of a particle start.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Copies {
    /// Each set is the whole state moved by a random vector, with all velocities turned alike at random. This keeps energy and
    /// vanishing momentum, and is the same gas only where the state is homogeneous and isotropic: a pattern of density
    /// or flow is blurred, and thermal noise is weaker by the number of simulators.
    Independent,
    /// Each set keeps the long waves of the state: it is moved by no more than a neighbourhood of some 32 particles, and
    /// velocities relative to the mean of that neighbourhood are turned at random, each by itself. The noise that the start
    /// has at longer waves, which seeds instabilities, is then the state's own.
    Coherent,
}

/// Numerical choices of a run. All of them buy accuracy or speed; none is physics.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Parameters {
    /// Which pairs collide, and how often.
    pub scheme: Scheme,
    /// How far partners within a cell are displaced.
    pub displacement: Displacement,
    /// Smallest side of a cell \[length\]; `None`: what the scheme likes. Within cells, half a mean free path, but at least two
    /// diameters; across, what makes the search for partners fast.
    pub cell_size: Option<f64>,
    /// Simulators for each particle.
    pub simulators_per_particle: u32,
    /// How they start, if several.
    pub copies: Copies,
    /// Steps in which a mean free time passes and, for pairs within cells, in which the fastest simulator crosses a cell.
    pub steps_per_cell_crossing: f64,
    /// Limit on chi.
    pub max_contact_value: f64,
}

impl Parameters {
    /// A scheme with its own defaults: one simulator for each particle; partners within a cell that dense schemes displace by
    /// a diameter; time steps as fine as each scheme needs; and a limit on chi that its cells need.
    ///
    /// Partners of [`Scheme::ContactPoint`] are uncorrelated only with more simulators: see [`Parameters::enough_for_chaos`].
    pub fn for_scheme(scheme: Scheme) -> Self {
        /// For schemes without a limit of their own: beyond any packing.
        const UNLIMITED: f64 = 1e3;
        let (displacement, steps, limit) = match scheme {
            Scheme::Collisionless | Scheme::Boltzmann => (Displacement::None, 4.0, 1.0),
            Scheme::FreeVolume | Scheme::Enskog(_) => (Displacement::Diameter, 4.0, 10.0),
            Scheme::Esmc(_) => (Displacement::None, 8.0, 10.0),
            Scheme::StochasticDisks { .. } => (Displacement::None, 20.0, UNLIMITED),
            Scheme::ContactPoint { .. } => (Displacement::None, 4.0, 100.0),
        };
        Self {
            scheme,
            displacement,
            cell_size: None,
            simulators_per_particle: 1,
            copies: Copies::Independent,
            steps_per_cell_crossing: steps,
            max_contact_value: limit,
        }
    }

    pub(crate) fn check(&self) -> Result<(), EngineError> {
        let check = |name, value: f64, good: bool, allowed| {
            Invalid::unless(good, name, value, allowed).map(|_| ())
        };
        let copies = f64::from(self.simulators_per_particle);
        check(
            "simulators_per_particle",
            copies,
            copies >= 1.0,
            "at least 1",
        )?;
        let steps = self.steps_per_cell_crossing;
        check(
            "steps_per_cell_crossing",
            steps,
            (1.0..=1e6).contains(&steps),
            "from 1 to 1e6",
        )?;
        let limit = self.max_contact_value;
        check(
            "max_contact_value",
            limit,
            (1.0..=1e9).contains(&limit),
            "from 1 to 1e9",
        )?;
        if self.scheme.is_across() && self.displacement != Displacement::None {
            let scheme = self.scheme.name();
            return Err(EngineError::Displaced { scheme });
        }
        match self.scheme {
            Scheme::StochasticDisks { stiffness } => check(
                "stiffness",
                stiffness,
                stiffness > 0.0 && stiffness <= 1e6,
                "above 0 and at most 1e6",
            )?,
            Scheme::ContactPoint {
                radius: Some(radius),
            } => check(
                "radius",
                radius,
                radius >= 0.0 && radius.is_finite(),
                "0 or more",
            )?,
            _ => {}
        }
        if let Some(size) = self.cell_size {
            check(
                "cell_size",
                size,
                size > 0.0 && size.is_finite(),
                "above zero",
            )?;
            if let Scheme::ContactPoint {
                radius: Some(radius),
            } = self.scheme
            {
                let allowed = "at most 30 times the cell size";
                check("radius", radius, radius <= 30.0 * size, allowed)?;
            }
        }
        Ok(())
    }

    /// Mean free path at a packing fraction, by the scheme's own collision rate \[length\].
    pub fn mean_free_path<S: Space>(&self, packing_fraction: f64, diameter: f64) -> f64 {
        let chi = self
            .scheme
            .contact_value::<S>(packing_fraction)
            .min(self.max_contact_value);
        diameter * S::mean_free_path(packing_fraction.max(1e-12), chi)
    }

    /// Radius around the point of contact within which partners are drawn \[length\]. If none is given: a quarter of the mean
    /// free path, at least half a diameter; less if the shell that partners come from would hold more than two particles,
    /// but not so little that fewer than four simulators are within it.
    ///
    /// Partners within s of the point of contact spread the arms over which momentum goes, so that the collisional part of the
    /// shear viscosity is too large by `<k_x^2 s_y^2>/(d^2 <k_x^2 k_y^2>) = (s/d)^2`, in the plane and in space. That part
    /// grows with density: with s = d/2 it adds 4 % to the viscosity of disks at packing 0.25 and would add 12 % at 0.5.
    pub fn partner_radius<S: Space>(&self, packing_fraction: f64, diameter: f64) -> f64 {
        /// Most particles in the shell of a radius of half a diameter; linear in the radius but for a tenth in space.
        const SHELL: f64 = 2.0;
        /// Fewest simulators around a point of contact, on average: with fewer, pressure and long waves suffer.
        const CHOICE: f64 = 4.0;
        let Scheme::ContactPoint { radius } = self.scheme else {
            return 0.0;
        };
        radius.unwrap_or_else(|| {
            let path = self.mean_free_path::<S>(packing_fraction, diameter);
            let half = 0.5 * diameter;
            let held = shell::<S>(packing_fraction, diameter, half);
            let copies = f64::from(self.simulators_per_particle);
            let around = copies * density::<S>(packing_fraction, diameter) * S::ball(half);
            let least = half * (CHOICE / around).powf(1.0 / S::DIMENSION as f64);
            let narrow = (half * SHELL / held).max(least).min(half);
            narrow.max(0.25 * path)
        })
    }

    /// The width of a cell that suits the scheme \[length\].
    fn automatic_cell<S: Space>(&self, packing_fraction: f64, diameter: f64) -> f64 {
        let path = || self.mean_free_path::<S>(packing_fraction, diameter);
        match self.scheme {
            Scheme::ContactPoint { .. } => {
                // One or two simulators in a cell, or the radius.
                let density = density::<S>(packing_fraction, diameter);
                let each = 1.5 / (density * f64::from(self.simulators_per_particle));
                let radius = self.partner_radius::<S>(packing_fraction, diameter);
                each.powf(1.0 / S::DIMENSION as f64).max(radius)
            }
            Scheme::StochasticDisks { .. } => diameter,
            Scheme::Esmc(_) => (0.5 * path()).max(0.5 * diameter),
            _ => (0.5 * path()).max(2.0 * diameter),
        }
    }

    /// Mean number of simulators in the shell that the partners of one come from \[[`Scheme::ContactPoint`]\]; at least one, since
    /// the nearest is taken where there is none.
    pub fn partners<S: Space>(&self, packing_fraction: f64, diameter: f64) -> f64 {
        let radius = self.partner_radius::<S>(packing_fraction, diameter);
        let each = shell::<S>(packing_fraction, diameter, radius);
        (f64::from(self.simulators_per_particle) * each).max(1.0)
    }

    /// Relative excess of the kinetic energy at `t_0` in a gas that cools at a constant restitution r, since two simulators
    /// that collided meet again before others come between, and then lose less \[[`Scheme::ContactPoint`]\]:
    /// `(1 - r^2)(0.05 + 0.15 x)/N` with N [`Parameters::partners`], and x the reach of partners, d + s, in mean free paths.
    /// The longer two are within reach of each other, the likelier it is.
    ///
    /// Fitted to disks at packings from 0.0025 to 0.5, restitutions from 0.5 to 0.95 and 1 to 32 simulators for each: what
    /// exceeds 1 % is within a factor of two of it. In space it was not measured.
    pub fn excess_of_repeated_pairs<S: Space>(
        &self,
        packing_fraction: f64,
        diameter: f64,
        restitution: f64,
    ) -> f64 {
        let radius = self.partner_radius::<S>(packing_fraction, diameter);
        let reach = (diameter + radius) / self.mean_free_path::<S>(packing_fraction, diameter);
        let partners = self.partners::<S>(packing_fraction, diameter);
        (1.0 - restitution * restitution) * (0.05 + 0.15 * reach) / partners
    }

    /// Largest [`Parameters::excess_of_repeated_pairs`] of partners that count as uncorrelated.
    pub const LARGEST_EXCESS: f64 = 0.0012;

    /// Simulators for each particle with which the partners of a collision are uncorrelated: as many as make
    /// [`Parameters::excess_of_repeated_pairs`] at most [`Parameters::LARGEST_EXCESS`] at restitution 0.8, but not more than put 120 partners into
    /// reach. At most 1000, and at most 2^20 in all.
    pub fn enough_for_chaos<S: Space>(
        scheme: Scheme,
        packing_fraction: f64,
        diameter: f64,
        particles: usize,
    ) -> u32 {
        const RESTITUTION: f64 = 0.8;
        const PARTNERS: f64 = 120.0;
        const MOST: usize = 1 << 20;
        const MOST_COPIES: u32 = 1000;
        let most = f64::from(MOST_COPIES);
        // As narrow as the reach of many simulators is.
        let many = Self {
            simulators_per_particle: MOST_COPIES,
            ..Self::for_scheme(scheme)
        };
        let partners = many.partners::<S>(packing_fraction, diameter);
        let excess = many.excess_of_repeated_pairs::<S>(packing_fraction, diameter, RESTITUTION);
        let wanted = most * (excess / Self::LARGEST_EXCESS).min(PARTNERS / partners);
        let affordable = ((MOST / particles.max(1)) as f64).clamp(1.0, most);
        2_u32
            .pow(
                wanted
                    .clamp(1.0, most)
                    .log2()
                    .ceil()
                    .min(affordable.log2().floor()) as u32,
            )
            .min(MOST_COPIES)
    }

    /// Number of cells along each axis of a box: as many as fit at the chosen size; one beyond the dimension.
    pub fn cells<S: Space>(
        &self,
        domain: &Domain<S>,
        packing_fraction: f64,
        diameter: f64,
    ) -> [usize; 3] {
        let side = self
            .cell_size
            .unwrap_or_else(|| self.automatic_cell::<S>(packing_fraction, diameter));
        // At most 2^26 cells in all: where more would fit, nearly all would be empty.
        let most = if S::DIMENSION == 2 { 8192 } else { 406 };
        [0, 1, 2].map(|axis| {
            if axis < S::DIMENSION {
                let count =
                    ((domain.lengths()[axis] / side * (1.0 + 1e-12)) as usize).clamp(1, most);
                // Pairs of overlapping disks are sought in each cell and the next: around two cells, each would be met twice.
                if matches!(self.scheme, Scheme::StochasticDisks { .. }) && count < 3 {
                    1
                } else {
                    count
                }
            } else {
                1
            }
        })
    }
}

/// Particles per volume.
fn density<S: Space>(packing_fraction: f64, diameter: f64) -> f64 {
    packing_fraction.max(1e-12) / S::ball(0.5 * diameter)
}

/// Mean number of particles in the shell that the partners of one come from, within `radius` of its surface of contact.
fn shell<S: Space>(packing_fraction: f64, diameter: f64, radius: f64) -> f64 {
    let outer = S::ball(diameter + radius);
    density::<S>(packing_fraction, diameter) * (outer - S::ball((diameter - radius).max(0.0)))
}

/// Why the engine could not start.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum EngineError {
    /// A number that a law, a size, a box or a parameter cannot have.
    #[error(transparent)]
    Invalid(#[from] Invalid),
    /// Bytes that are no checkpoint of this engine.
    #[error("the bytes are no checkpoint of this gas: {0}")]
    Checkpoint(String),
    /// A part of a checkpoint cannot be used.
    #[error(
        "{why}; it has {simulators} simulators in {tiles} tiles, of a checkpoint in {all} shards, which is of no use without it: \
             without its .snapshot file this part of the run begins anew"
    )]
    Shard {
        /// What is wrong with which file.
        why: String,
        /// Tiles in it.
        tiles: usize,
        /// Simulators in them.
        simulators: u64,
        /// Number of all shards.
        all: usize,
    },
    /// Several processes are to hold the gas, which was left out of the program.
    #[error(
        "this program holds a gas in one process; it was compiled without the feature \"processes\""
    )]
    OneProcess,
    /// Another process that is to hold a part of the gas cannot.
    #[error("process {rank}: {why}")]
    Elsewhere {
        /// Its number.
        rank: usize,
        /// Why.
        why: String,
    },
    /// Restitution 0 leaves no momentum for a displacement to make up for.
    #[error(
        "restitution 0 with the inelastic displacement d (1 + r)/(2r), which is infinite; allowed: one diameter, or none"
    )]
    NoDisplacement,
    /// Restitution so small that the displacement that makes up for it leads around the box.
    #[error(
        "restitution {restitution} with the inelastic displacement d (1 + r)/(2r) = {displacement}; allowed: up to the \
         shortest side {side}, and a diameter", restitution = brief(*restitution), displacement = brief(*displacement), side = brief(*side))]
    FarDisplacement {
        /// At the thermal speed.
        restitution: f64,
        /// Of the largest particles \[length\].
        displacement: f64,
        /// Shortest side of the box \[length\].
        side: f64,
    },
    /// Displacements are for pairs within cells.
    #[error(
        "the scheme {scheme} with a displacement; allowed: none, as its partners are a contact distance apart anyway"
    )]
    Displaced {
        /// Its name.
        scheme: &'static str,
    },
    /// Partners in other cells are looked for where cells stand still.
    #[error(
        "the scheme {scheme} in a uniform shear flow, whose cells slide along each other at the edge of the box; allowed: \
         boltzmann, free-volume and enskog, whose partners share a cell"
    )]
    Sheared {
        /// Its name.
        scheme: &'static str,
    },
    /// Weights that have no meaning.
    #[error("weights: {found}; allowed: {allowed}")]
    BadWeights {
        /// What was found.
        found: String,
        /// What is allowed.
        allowed: &'static str,
    },
    /// The box is periodic along other axes than its faces are.
    #[error(
        "axis {axis}: the box is {}, its faces are {}; allowed: both alike",
        if *.periodic { "periodic" } else { "not periodic" },
        if *.periodic { "not" } else { "periodic" }
    )]
    UnlikeFaces {
        /// Which, from 0.
        axis: usize,
        /// Whether the box is.
        periodic: bool,
    },
    /// Walls that leave no room between them.
    #[error(
        "axis {axis}: walls, their vibrations and the particles' radii take {needed} of {length}; allowed: less than that", needed = brief(*needed), length = brief(*length))]
    NoRoom {
        /// Which, from 0.
        axis: usize,
        /// Side of the box \[length\].
        length: f64,
        /// What is taken of it \[length\].
        needed: f64,
    },
    /// Walls so near to each other that partners across cells have no meaning.
    #[error(
        "axis {axis}: the scheme {scheme} between walls {width:.3} mean diameters apart; allowed: 3 or more, as it misses up to a \
         third of the collisions at packing 0.25 in narrower channels, and half of them at 0.4"
    )]
    Narrow {
        /// Which, from 0.
        axis: usize,
        /// Its name.
        scheme: &'static str,
        /// From wall to wall, as the particles' surfaces meet them \[mean diameters\].
        width: f64,
    },
    /// A simulator starts beyond a wall.
    #[error(
        "simulator {simulator} is at {coordinate} along axis {axis}, beyond a wall; allowed: {} to {}",
        brief(allowed[0]),
        brief(allowed[1]), coordinate = brief(*coordinate))]
    BeyondWall {
        /// Index.
        simulator: usize,
        /// Which axis, from 0.
        axis: usize,
        /// Its coordinate \[length\].
        coordinate: f64,
        /// The lowest and the highest that is allowed \[length\].
        allowed: [f64; 2],
    },
    /// An obstacle that is not in the box.
    #[error("obstacle {obstacle}: {source}")]
    Obstacle {
        /// Its number, from 0.
        obstacle: usize,
        /// What is wrong with it.
        source: ObstacleError,
    },
    /// A cell that obstacles cut into too many parts to tell them apart.
    #[error(
        "cells {} wide: edges of obstacles cut the cell at ({}, {}) into more than {most} parts; allowed: cells of at most {}, \
         where partners on different sides of a body can be told apart",
        brief(*width), brief(place[0]), brief(place[1]), brief(*enough))]
    CutCell {
        /// Lower left corner of the cell \[length\].
        place: [f64; 2],
        /// Narrowest side of a cell \[length\].
        width: f64,
        /// Most parts.
        most: usize,
        /// Side of cells that would do \[length\].
        enough: f64,
    },
    /// A simulator starts inside an obstacle.
    #[error(
        "simulator {simulator} at ({:.6}, {:.6}) overlaps obstacle {obstacle}; allowed: all outside of it",
        place[0],
        place[1]
    )]
    InObstacle {
        /// Index.
        simulator: usize,
        /// Number of the obstacle, from 0.
        obstacle: usize,
        /// Where it is \[length\].
        place: [f64; 2],
    },
    /// An inflow that has no meaning.
    #[error("inflow {inflow}: {name} = {value}; allowed: {allowed}", value = brief(*value))]
    BadInflow {
        /// Its number, from 0.
        inflow: usize,
        /// What.
        name: &'static str,
        /// What was found.
        value: f64,
        /// What is allowed.
        allowed: &'static str,
    },
    /// Not one state for each simulator of a particle.
    #[error(
        "{found} states for {wanted} simulators of each particle; allowed: one for each, all alike in number, time and box"
    )]
    UnequalStarts {
        /// How many were given.
        found: usize,
        /// How many are needed.
        wanted: usize,
    },
    /// Simulators come and go, and each particle has a size of its own.
    #[error(
        "open faces or weights, and a size of its own for each particle; allowed: equal particles, or species"
    )]
    Individuals,
    /// A scheme that cannot do with what stands at the boundaries.
    #[error("the scheme {scheme} with {what}; allowed: {allowed}")]
    Boundary {
        /// Its name.
        scheme: &'static str,
        /// What it cannot do with.
        what: &'static str,
        /// What can.
        allowed: &'static str,
    },
    /// A position, velocity or spin is no finite number, or too large to be squared.
    #[error(
        "simulator {simulator} has position {position:?} and velocity {velocity:?}; allowed are finite numbers up to 1e150"
    )]
    BadNumber {
        /// Index.
        simulator: usize,
        /// Position.
        position: Vec<f64>,
        /// Velocity.
        velocity: Vec<f64>,
    },
}

impl EngineError {
    /// Converts lengths and speeds of the error to the units of a case. Inflows and obstacles are written in these already.
    #[must_use]
    pub fn in_units(mut self, units: &MessageUnits) -> Self {
        let scale =
            |list: &mut [f64], unit: f64| list.iter_mut().for_each(|number| *number *= unit);
        match &mut self {
            Self::FarDisplacement {
                displacement, side, ..
            } => {
                *displacement *= units.length;
                *side *= units.length;
            }
            Self::NoRoom { length, needed, .. } => {
                *length *= units.length;
                *needed *= units.length;
            }
            Self::BeyondWall {
                coordinate,
                allowed,
                ..
            } => {
                *coordinate *= units.length;
                *allowed = units.place(*allowed);
            }
            Self::InObstacle { place, .. } => *place = units.place(*place),
            Self::CutCell {
                place,
                width,
                enough,
                ..
            } => {
                *place = units.place(*place);
                *width *= units.length;
                *enough *= units.length;
            }
            Self::BadNumber {
                position, velocity, ..
            } => {
                scale(position, units.length);
                scale(velocity, units.speed);
            }
            Self::Invalid(_)
            | Self::Checkpoint(_)
            | Self::Shard { .. }
            | Self::OneProcess
            | Self::Elsewhere { .. }
            | Self::NoDisplacement
            | Self::Displaced { .. }
            | Self::BadWeights { .. }
            | Self::UnlikeFaces { .. }
            | Self::Narrow { .. }
            | Self::Obstacle { .. }
            | Self::BadInflow { .. }
            | Self::UnequalStarts { .. }
            | Self::Individuals
            | Self::Boundary { .. }
            | Self::Sheared { .. } => {}
        }
        self
    }
}
