//! Collision schemes: which pairs collide, and how often.

use serde::{Deserialize, Serialize};
use stosszahl_model::Space;

/// Over which area the packing fraction is taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Neighbourhood {
    /// The whole box.
    Mean,
    /// The square or cube of (2n + 1)^D cells around.
    Cells(u32),
}

/// Which pairs collide, and how often.
///
/// Collisions per pair and time are those of kinetic theory with the factor chi. The first four draw pairs within a cell;
/// the last three draw partners by where they are, over a contact distance d.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Scheme {
    /// No collisions at all: free molecular flow.
    Collisionless,
    /// chi = 1: the dilute gas. Converges to the Boltzmann equation.
    Boltzmann,
    /// chi = V/(V - `V_0`), `V_0` the area that the disks of the cell need at random close packing, 0.82 (spheres: 0.64):
    /// the scheme of Luding, Müller & McNamara (1998). 9 % below Enskog at packing 0.25; without a
    /// limit it is infinite or negative in a crowded cell.
    FreeVolume,
    /// chi of the packing around the cell: with many simulators the local Enskog collision rate.
    Enskog(Neighbourhood),
    /// A partner from the cell of the point at d from the simulator along a random line of centres, as likely as that cell is
    /// crowded, times chi halfway: Enskog Simulation Monte Carlo (Montanero & Santos, Phys. Rev. E 54, 438 (1996),
    /// doi:10.1103/PhysRevE.54.438). With many simulators and small cells it solves the Enskog equation.
    Esmc(Neighbourhood),
    /// Partners nearer than d that approach at `g_n` along the line between them collide with the rate
    /// `stiffness` D chi `g_n`/d: stochastic hard-sphere dynamics (Donev, Alder & Garcia, Phys. Rev. Lett. 101, 075902 (2008),
    /// doi:10.1103/PhysRevLett.101.075902). The gas is a fluid of penetrable particles, with fluctuations and structure
    /// of its own equation of state; stiff, it tends to exact hard particles, its collision rate from below.
    StochasticDisks {
        /// How readily overlapping particles collide: 1 would give Enskog's rate if they overlapped as in the dilute gas.
        stiffness: f64,
    },
    /// A partner from around the point at about d from the simulator along a random line of centres, at the rate of
    /// Enskog's theory for the density around, however few the partners (`docs/development/monte-carlo.md`). With up to eleven simulators for
    /// each disk, in space, in thin gases, for unequal sizes and in boxes with boundaries the density is a mean over at least
    /// 3 d: the scheme then has Enskog's rate, pressure and transport where the state changes little within that length, and at
    /// shorter wavelengths the structure factor is too large (at k d = 0.5 and packing 0.25, 0.53 with one simulator for each disk
    /// and 0.40 with four, where exact disks have 0.335). With more simulators it is a mean over about a diameter around the point halfway,
    /// and with 16 for each disk S(k d) is that of exact disks within 5 % up to k d = 1.
    ContactPoint {
        /// Radius around the point within which all simulators are equally likely; if there is none, the nearest in
        /// the cells around is taken \[length\]. None: half the diameter, or a quarter of the mean free path if that is longer.
        radius: Option<f64>,
    },
}

impl Scheme {
    /// [`Scheme::ContactPoint`] with its own radius: the scheme to compare with exact disks.
    pub const CONTACT_POINT: Self = Self::ContactPoint { radius: None };

    /// All schemes, each with the settings that it has where none are chosen.
    pub const ALL: [Self; 7] = [
        Self::Collisionless,
        Self::Boltzmann,
        Self::FreeVolume,
        Self::Enskog(Neighbourhood::Cells(2)),
        Self::Esmc(Neighbourhood::Cells(2)),
        Self::StochasticDisks { stiffness: 1.0 },
        Self::CONTACT_POINT,
    ];

    /// The scheme of a [`Self::name`], with its own settings.
    ///
    /// ```
    /// use stosszahl_dsmc::{Neighbourhood, Scheme};
    ///
    /// assert_eq!(Scheme::named("enskog"), Some(Scheme::Enskog(Neighbourhood::Cells(2))));
    /// assert_eq!(Scheme::named("ensk"), None);
    /// ```
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|scheme| scheme.name() == name)
    }

    /// The word used in file names and tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Collisionless => "collisionless",
            Self::Boltzmann => "boltzmann",
            Self::FreeVolume => "free-volume",
            Self::Enskog(_) => "enskog",
            Self::Esmc(_) => "esmc",
            Self::StochasticDisks { .. } => "stochastic-disks",
            Self::ContactPoint { .. } => "contact-point",
        }
    }

    /// Whether partners are drawn by where they are, from other cells too.
    pub fn is_across(self) -> bool {
        matches!(
            self,
            Self::Esmc(_) | Self::StochasticDisks { .. } | Self::ContactPoint { .. }
        )
    }

    /// Whether its collisions carry momentum over the distance of the partners, as those of exact particles do: their virial is
    /// then part of the pressure. Partners within a cell are points, whatever their rate.
    pub fn carries(self) -> bool {
        self.is_across()
    }

    /// Whether partners in a uniform shear flow are taken as a contact distance apart: they then approach with the flow between
    /// them and carry momentum over that distance, as Enskog's theory says. Other pairs within a cell are points.
    pub fn feels_flow(self) -> bool {
        matches!(self, Self::Enskog(_))
    }

    /// Whether the number of its trials follows from a bound of the speeds at which partners approach.
    pub(crate) fn bounds_trials(self) -> bool {
        !matches!(self, Self::StochasticDisks { .. })
    }

    /// chi at a packing fraction, before any limit.
    pub fn contact_value<S: Space>(self, packing_fraction: f64) -> f64 {
        match self {
            Self::Collisionless | Self::Boltzmann => 1.0,
            Self::FreeVolume if packing_fraction >= S::RANDOM_CLOSE_PACKING => f64::INFINITY,
            Self::FreeVolume => 1.0 / (1.0 - packing_fraction / S::RANDOM_CLOSE_PACKING),
            _ => S::contact_value(packing_fraction),
        }
    }
}
