//! Numerical parameters of a DSMC run with their defaults, and the errors with which an engine
//! refuses to start.

use serde::{Deserialize, Serialize};
use stosszahl_model::walls::ObstacleError;
use stosszahl_model::{Domain, InvalidValue, MessageUnits, Space, format_short};

use crate::scheme::{PartnerDisplacement, PartnerSelection, Scheme, SchemeProperties};

/// Choice of the initial states of further sets of simulators, if several simulators stand for a
/// particle.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum SimulatorStart {
    /// Independent copies: each set is the whole state, shifted by a random vector and with all
    /// velocities rotated alike at random. This keeps the energy and zero momentum, but the gas is
    /// the same only if the state is homogeneous and isotropic: patterns of density or flow are
    /// blurred. Thermal noise is weaker by the number of simulators.
    Independent,
    /// Coherent copies: each set keeps the long waves of the state. It is shifted by no more than a
    /// neighbourhood of some 32 particles, and each velocity relative to the mean of that
    /// neighbourhood is rotated at random. The long-wave noise of the start, which seeds
    /// instabilities, is then that of the state.
    Coherent,
}

/// Numerical parameters of a DSMC run: they set accuracy and speed, not the physics.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Parameters {
    /// Collision scheme: which pairs collide, and how often.
    pub scheme: Scheme,
    /// Displacement of the partners of a collision within a cell, as in the consistent Boltzmann
    /// algorithm.
    pub displacement: PartnerDisplacement,
    /// Smallest side of a cell \[length\]; `None` for the scheme's default. Within cells: half a
    /// mean free path, but at least two diameters. Cross-cell: the side for the fastest search of
    /// partners.
    pub cell_size: Option<f64>,
    /// Number of simulators that stand for each particle of the gas.
    pub simulators_per_particle: u32,
    /// Choice of the initial states of further sets of simulators.
    pub copies: SimulatorStart,
    /// Number of time steps in a mean free time and, for pairs within cells, in the time in which
    /// the fastest simulator crosses a cell.
    pub steps_per_cell_crossing: f64,
    /// Upper limit of the contact value chi.
    pub max_contact_value: f64,
}

impl Parameters {
    /// Returns the default parameters of a scheme: one simulator per particle; displacement by a
    /// diameter within cells of dense schemes; time steps and limit of chi that the scheme needs.
    ///
    /// Partners of [`Scheme::ContactPoint`] are uncorrelated only with more simulators: see
    /// [`Parameters::enough_for_chaos`].
    pub fn for_scheme(scheme: Scheme) -> Self {
        let SchemeProperties {
            displacement,
            steps_per_cell_crossing,
            max_contact_value,
            ..
        } = scheme.properties();
        Self {
            scheme,
            displacement,
            cell_size: None,
            simulators_per_particle: 1,
            copies: SimulatorStart::Independent,
            steps_per_cell_crossing,
            max_contact_value,
        }
    }

    pub(crate) fn check_values(&self) -> Result<(), DsmcError> {
        let check = |name, value: f64, good: bool, allowed| {
            InvalidValue::require(good, name, value, allowed).map(|_| ())
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
        if self.scheme.is_cross_cell() && self.displacement != PartnerDisplacement::None {
            let scheme = self.scheme.name();
            return Err(DsmcError::Displaced { scheme });
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

    /// Returns the mean free path at a packing fraction \[length\], by the collision rate of the
    /// scheme.
    pub fn mean_free_path<S: Space>(&self, packing_fraction: f64, diameter: f64) -> f64 {
        let chi = self
            .scheme
            .contact_value::<S>(packing_fraction)
            .min(self.max_contact_value);
        diameter * S::mean_free_path(packing_fraction.max(1e-12), chi)
    }

    /// Returns the radius around the point of contact within which partners are drawn \[length\].
    /// It is a quarter of the mean free path, at least half a diameter; less if the shell that
    /// holds the partners would contain more than two particles, but not below the radius that
    /// contains four simulators.
    ///
    /// Partners at distance s from the point of contact spread the distances over which momentum is
    /// transferred. The collisional part of the shear viscosity is therefore too large by the
    /// factor `<k_x^2 s_y^2>/(d^2 <k_x^2 k_y^2>) = (s/d)^2`, in two and three dimensions. That part
    /// grows with density: with s = d/2 it adds 4 % to the viscosity of disks at packing 0.25 and
    /// would add 12 % at 0.5.
    pub fn partner_radius<S: Space>(&self, packing_fraction: f64, diameter: f64) -> f64 {
        /// Largest number of particles in the shell of possible partners for a radius of half a
        /// diameter; the number is linear in the radius, but for a tenth in three dimensions.
        const SHELL: f64 = 2.0;
        /// Least mean number of simulators around a point of contact; with fewer, pressure and long
        /// waves deteriorate.
        const CHOICE: f64 = 4.0;
        let Scheme::ContactPoint { radius } = self.scheme else {
            return 0.0;
        };
        radius.unwrap_or_else(|| {
            let path = self.mean_free_path::<S>(packing_fraction, diameter);
            let half = 0.5 * diameter;
            let held = particles_in_shell::<S>(packing_fraction, diameter, half);
            let copies = f64::from(self.simulators_per_particle);
            let around =
                copies * number_density::<S>(packing_fraction, diameter) * S::particle_volume(half);
            let least = half * (CHOICE / around).powf(1.0 / S::DIMENSION as f64);
            let narrow = (half * SHELL / held).max(least).min(half);
            narrow.max(0.25 * path)
        })
    }

    /// Returns the default side of a cell for the scheme \[length\].
    fn automatic_cell<S: Space>(&self, packing_fraction: f64, diameter: f64) -> f64 {
        let path = || self.mean_free_path::<S>(packing_fraction, diameter);
        match self.scheme.partners() {
            PartnerSelection::AroundContact => {
                // One or two simulators per cell, or the search radius.
                let density = number_density::<S>(packing_fraction, diameter);
                let each = 1.5 / (density * f64::from(self.simulators_per_particle));
                let radius = self.partner_radius::<S>(packing_fraction, diameter);
                each.powf(1.0 / S::DIMENSION as f64).max(radius)
            }
            PartnerSelection::Overlap => diameter,
            PartnerSelection::ContactCell => (0.5 * path()).max(0.5 * diameter),
            PartnerSelection::None | PartnerSelection::WithinCell => {
                (0.5 * path()).max(2.0 * diameter)
            }
        }
    }

    /// Returns the mean number of simulators in the shell that holds the partners of a simulator
    /// \[[`Scheme::ContactPoint`]\]; at least 1, since the nearest is taken if there is none.
    pub fn partners<S: Space>(&self, packing_fraction: f64, diameter: f64) -> f64 {
        let radius = self.partner_radius::<S>(packing_fraction, diameter);
        let each = particles_in_shell::<S>(packing_fraction, diameter, radius);
        (f64::from(self.simulators_per_particle) * each).max(1.0)
    }

    /// Returns the relative excess of the kinetic energy at Haff's time `t_0` by repeated
    /// collisions of pairs, in a gas that cools at constant restitution r
    /// \[[`Scheme::ContactPoint`]\]: `(1 - r^2)(0.05 + 0.15 x)/N`, with N [`Parameters::partners`],
    /// and x the range of partners, d + s, in mean free paths.
    ///
    /// It arises because two simulators that collided may collide again before they meet others,
    /// and then lose less energy. The longer they stay within range, the likelier that is.
    ///
    /// Fitted to disks at packings from 0.0025 to 0.5, restitutions from 0.5 to 0.95 and 1 to 32
    /// simulators per particle: values above 1 % are within a factor of two. Three dimensions were
    /// not measured.
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

    /// Largest relative excess of energy by repeated pairs,
    /// [`Parameters::excess_of_repeated_pairs`], at which partners count as uncorrelated.
    pub const LARGEST_EXCESS: f64 = 0.0012;

    /// Returns the number of simulators per particle at which collision partners are uncorrelated:
    /// [`Parameters::excess_of_repeated_pairs`] is at most [`Parameters::LARGEST_EXCESS`] at
    /// restitution 0.8, or 120 partners are within range if that takes fewer. At most 1000, and at
    /// most 2^20 simulators in all.
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
        // Radius for many simulators, where it is narrowest.
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

    /// Returns the number of cells along each axis of a box: as many as fit at the chosen side of
    /// cells; 1 beyond the dimension.
    pub fn cells<S: Space>(
        &self,
        domain: &Domain<S>,
        packing_fraction: f64,
        diameter: f64,
    ) -> [usize; 3] {
        let side = self
            .cell_size
            .unwrap_or_else(|| self.automatic_cell::<S>(packing_fraction, diameter));
        // At most 2^26 cells in all: more would nearly all be empty.
        let most = if S::DIMENSION == 2 { 8192 } else { 406 };
        [0, 1, 2].map(|axis| {
            if axis < S::DIMENSION {
                let count =
                    ((domain.lengths()[axis] / side * (1.0 + 1e-12)) as usize).clamp(1, most);
                // Overlapping disks are sought in each cell and the next: with two cells around,
                // each pair would be found twice.
                if self.scheme.partners() == PartnerSelection::Overlap && count < 3 {
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

/// Returns the number density of particles at a packing fraction \[1/length^D\].
fn number_density<S: Space>(packing_fraction: f64, diameter: f64) -> f64 {
    packing_fraction.max(1e-12) / S::particle_volume(0.5 * diameter)
}

/// Returns the mean number of particles in the shell that holds the possible partners of a
/// particle: at the contact distance, plus or minus `radius` \[length\].
fn particles_in_shell<S: Space>(packing_fraction: f64, diameter: f64, radius: f64) -> f64 {
    let outer = S::particle_volume(diameter + radius);
    number_density::<S>(packing_fraction, diameter)
        * (outer - S::particle_volume((diameter - radius).max(0.0)))
}

/// Error with which a DSMC engine refuses to start or to resume.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum DsmcError {
    /// A number of a law, a size, a box or a parameter is outside its allowed range.
    #[error(transparent)]
    Invalid(#[from] InvalidValue),
    /// The bytes given are not a checkpoint of this engine; the text says why.
    #[error("the bytes are no checkpoint of this gas: {0}")]
    Checkpoint(String),
    /// A shard of the checkpoint, the file of one process, cannot be used.
    #[error(
        "{why}; it has {simulators} simulators in {tiles} tiles, of a checkpoint in {all} shards, which is of no use without it: \
             without its .snapshot file this part of the run begins anew"
    )]
    Shard {
        /// Reason why the shard cannot be used, with the name of the file.
        why: String,
        /// Number of tiles in the unusable shard.
        tiles: usize,
        /// Number of simulators in the unusable shard.
        simulators: u64,
        /// Number of all shards of the checkpoint.
        all: usize,
    },
    /// Several processes are requested, but the program was compiled without domain decomposition.
    #[error(
        "this program holds a gas in one process; it was compiled without the feature \"processes\""
    )]
    OneProcess,
    /// Spheres in a box are requested, but the program was compiled without them.
    #[error(
        "this program has no spheres in a box; it was compiled without the feature \"spheres\""
    )]
    NoSpheres,
    /// Rough particles are requested, but the program was compiled without them.
    #[error(
        "this program has no particles that spin; it was compiled without the feature \"rough\""
    )]
    NoRough,
    /// Another process that should hold a part of the gas has failed.
    #[error("process {rank}: {why}")]
    Elsewhere {
        /// Rank of the process that has failed.
        rank: usize,
        /// Error message of the process that has failed.
        why: String,
    },
    /// Start that its source could not make.
    #[error("{why}")]
    Start {
        /// Error message of the source.
        why: String,
    },
    /// Processes whose parts of the start are not the whole gas.
    #[error(
        "the processes made {found} of {wanted} simulators together: their machines round differently, so that one start differs \
         from another; allowed: machines and programs of one kind"
    )]
    UnequalParts {
        /// Number of simulators made.
        found: usize,
        /// Number of simulators of the gas.
        wanted: usize,
    },
    /// The inelastic displacement of partners is chosen at restitution 0, where it is infinite.
    #[error(
        "restitution 0 with the inelastic displacement d (1 + r)/(2r), which is infinite; allowed: one diameter, or none"
    )]
    NoDisplacement,
    /// The restitution is so small that the inelastic displacement of partners exceeds the box.
    #[error(
        "restitution {restitution} with the inelastic displacement d (1 + r)/(2r) = {displacement}; allowed: up to the \
         shortest side {side}, and a diameter", restitution = format_short(*restitution), displacement = format_short(*displacement), side = format_short(*side))]
    FarDisplacement {
        /// Coefficient of restitution at the thermal speed of the gas.
        restitution: f64,
        /// Displacement of the partners if both are the largest particles \[length\].
        displacement: f64,
        /// Shortest side of the box, which the displacement exceeds \[length\].
        side: f64,
    },
    /// A displacement of partners is chosen with a cross-cell scheme, whose partners are a contact
    /// distance apart anyway.
    #[error(
        "the scheme {scheme} with a displacement; allowed: none, as its partners are a contact distance apart anyway"
    )]
    Displaced {
        /// Name of the scheme that allows no displacement of partners.
        scheme: &'static str,
    },
    /// The weight factors of regions are invalid.
    #[error("weights: {found}; allowed: {allowed}")]
    BadWeights {
        /// Invalid weight factor, or wrong number of factors, as text.
        found: String,
        /// Allowed weight factors, as text.
        allowed: &'static str,
    },
    /// The box is periodic along an axis where faces are not, or the reverse.
    #[error(
        "axis {axis}: the box is {}, its faces are {}; allowed: both alike",
        if *.periodic { "periodic" } else { "not periodic" },
        if *.periodic { "not" } else { "periodic" }
    )]
    UnlikeFaces {
        /// Axis along which box and faces differ, from 0.
        axis: usize,
        /// True if the box is periodic along this axis.
        periodic: bool,
    },
    /// Two opposite walls leave no room for particles between them.
    #[error(
        "axis {axis}: walls, their vibrations and the particles' radii take {needed} of {length}; allowed: less than that", needed = format_short(*needed), length = format_short(*length))]
    NoRoom {
        /// Axis along which the walls are too close, from 0.
        axis: usize,
        /// Side of the box along this axis \[length\].
        length: f64,
        /// Length that walls, their vibrations and the particle radii need \[length\].
        needed: f64,
    },
    /// Two opposite walls are too close for a cross-cell scheme.
    #[error(
        "axis {axis}: the scheme {scheme} between walls {width:.3} mean diameters apart; allowed: 3 or more, as it misses up to a \
         third of the collisions at packing 0.25 in narrower channels, and half of them at 0.4"
    )]
    Narrow {
        /// Axis along which the walls are too close for the scheme, from 0.
        axis: usize,
        /// Name of the cross-cell scheme that needs a wider box.
        scheme: &'static str,
        /// Distance between the two walls, as particle surfaces meet them \[mean diameters\].
        width: f64,
    },
    /// A simulator of the initial state is beyond a wall.
    #[error(
        "simulator {simulator} is at {coordinate} along axis {axis}, beyond a wall; allowed: {} to {}",
        format_short(allowed[0]),
        format_short(allowed[1]), coordinate = format_short(*coordinate))]
    BeyondWall {
        /// Index of the simulator that is beyond a wall.
        simulator: usize,
        /// Axis of the wall, the direction of its normal, from 0.
        axis: usize,
        /// Coordinate of the simulator along this axis \[length\].
        coordinate: f64,
        /// Lowest and highest coordinate that walls allow along this axis \[length\].
        allowed: [f64; 2],
    },
    /// An obstacle is invalid, or outside the box.
    #[error("obstacle {obstacle}: {source}")]
    Obstacle {
        /// Index of the invalid obstacle, from 0.
        obstacle: usize,
        /// Reason why the obstacle is invalid.
        source: ObstacleError,
    },
    /// Obstacles cut a cell of the grid into too many parts.
    #[error(
        "cells {} wide: edges of obstacles cut the cell at ({}, {}) into more than {most} parts; allowed: cells of at most {}, \
         where partners on different sides of a body can be told apart",
        format_short(*width), format_short(place[0]), format_short(place[1]), format_short(*enough))]
    CutCell {
        /// Lower left corner of the cell that has too many parts \[length\].
        place: [f64; 2],
        /// Least side of a cell of the grid \[length\].
        width: f64,
        /// Largest allowed number of parts of a cell.
        most: usize,
        /// Side of cells that would be small enough \[length\].
        enough: f64,
    },
    /// A simulator of the initial state is inside an obstacle.
    #[error(
        "simulator {simulator} at ({:.6}, {:.6}) overlaps obstacle {obstacle}; allowed: all outside of it",
        place[0],
        place[1]
    )]
    InObstacle {
        /// Index of the simulator that is inside an obstacle.
        simulator: usize,
        /// Index of the obstacle that contains the simulator, from 0.
        obstacle: usize,
        /// Position of the simulator inside the obstacle \[length\].
        place: [f64; 2],
    },
    /// A number of an inflow is invalid.
    #[error("inflow {inflow}: {name} = {value}; allowed: {allowed}", value = format_short(*value))]
    BadInflow {
        /// Index of the inflow with an invalid number, from 0.
        inflow: usize,
        /// Name of the invalid quantity of the inflow.
        name: &'static str,
        /// Invalid value of the inflow's quantity.
        value: f64,
        /// Allowed values of the inflow's quantity, as text.
        allowed: &'static str,
    },
    /// The number of initial states given differs from the number of simulators per particle.
    #[error(
        "{found} states for {wanted} simulators of each particle; allowed: one for each, all alike in number, time and box"
    )]
    UnequalStarts {
        /// Number of initial states given.
        found: usize,
        /// Number of initial states needed: one for each simulator per particle.
        wanted: usize,
    },
    /// Particles have individual sizes although the number of simulators can change.
    #[error(
        "open faces or weights, and a size of its own for each particle; allowed: equal particles, or species"
    )]
    Individuals,
    /// The scheme does not support a boundary condition of the box.
    #[error("the scheme {scheme} with {what}; allowed: {allowed}")]
    Boundary {
        /// Name of the scheme that does not support the boundary condition.
        scheme: &'static str,
        /// Boundary condition that the scheme does not support.
        what: &'static str,
        /// Schemes that support the boundary condition, as text.
        allowed: &'static str,
    },
    /// Position, velocity or spin of a simulator is not finite, or too large to be squared.
    #[error(
        "simulator {simulator} has position {position:?} and velocity {velocity:?}; allowed are finite numbers up to 1e150"
    )]
    BadNumber {
        /// Index of the simulator with an invalid number.
        simulator: usize,
        /// Position of the simulator with an invalid number \[length\].
        position: Vec<f64>,
        /// Velocity of the simulator with an invalid number \[length/time\].
        velocity: Vec<f64>,
    },
}

impl DsmcError {
    /// Converts lengths and speeds of the error to the units of a case, for messages. Inflows and
    /// obstacles are stored in these already.
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
                *allowed = units.scale_position(*allowed);
            }
            Self::InObstacle { place, .. } => *place = units.scale_position(*place),
            Self::CutCell {
                place,
                width,
                enough,
                ..
            } => {
                *place = units.scale_position(*place);
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
            | Self::NoSpheres
            | Self::NoRough
            | Self::Elsewhere { .. }
            | Self::Start { .. }
            | Self::UnequalParts { .. }
            | Self::NoDisplacement
            | Self::Displaced { .. }
            | Self::BadWeights { .. }
            | Self::UnlikeFaces { .. }
            | Self::Narrow { .. }
            | Self::Obstacle { .. }
            | Self::BadInflow { .. }
            | Self::UnequalStarts { .. }
            | Self::Individuals
            | Self::Boundary { .. } => {}
        }
        self
    }
}
