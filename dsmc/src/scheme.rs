//! Collision schemes: which pairs collide, and how often.

use serde::{Deserialize, Serialize};
use stosszahl_model::Space;

/// Density window: cells over which the packing fraction is averaged.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Neighbourhood {
    /// The whole box.
    Mean,
    /// The square or cube of (2n + 1)^D cells around a cell.
    Cells(u32),
}

/// Collision scheme: which pairs collide, and how often.
///
/// Collision rates per pair are those of kinetic theory times chi. The first four draw pairs within
/// a cell; the last three draw partners by position, at about a contact distance d.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Scheme {
    /// No collisions at all: free molecular flow.
    Collisionless,
    /// Dilute gas, chi = 1. Converges to the Boltzmann equation.
    Boltzmann,
    /// Free-volume scheme of Luding, Müller & McNamara (1998).
    ///
    /// chi = V/(V - `V_0`), `V_0` the area that the disks of the cell need at random close packing,
    /// 0.82 (spheres: 0.64). 9 % below Enskog at packing 0.25; without a limit it is infinite or
    /// negative in a crowded cell.
    FreeVolume,
    /// Enskog scheme: chi at the packing around the cell. With many simulators, the local Enskog
    /// collision rate.
    Enskog(Neighbourhood),
    /// Enskog Simulation Monte Carlo (Montanero & Santos, Phys. Rev. E 54, 438 (1996),
    /// doi:10.1103/PhysRevE.54.438).
    ///
    /// A partner is drawn from the cell at distance d from the simulator along a random line of
    /// centres, with probability proportional to the number in that cell and chi halfway. With many
    /// simulators and small cells it solves the Enskog equation.
    Esmc(Neighbourhood),
    /// Stochastic hard-sphere dynamics (Donev, Alder & Garcia, Phys. Rev. Lett. 101, 075902 (2008),
    /// doi:10.1103/PhysRevLett.101.075902).
    ///
    /// Pairs closer than d that approach at `g_n` along their line of centres collide at the rate
    /// `stiffness` D chi `g_n`/d. The gas is a fluid of penetrable particles, with fluctuations and
    /// structure of its own equation of state. At large stiffness it tends to exact hard particles,
    /// its collision rate from below.
    StochasticDisks {
        /// Relative collision rate of overlapping particles; 1 would give Enskog's rate if they
        /// overlapped as in the dilute gas.
        stiffness: f64,
    },
    /// Contact-point scheme: Enskog's rate for the local density, however few the partners
    /// (`docs/development/monte-carlo.md`).
    ///
    /// A partner is drawn from around the point at about d from the simulator along a random line
    /// of centres. The density is averaged over at least 3 d with up to eleven simulators per disk,
    /// in three dimensions, in dilute gases, for unequal sizes and with boundaries. The scheme then
    /// has Enskog's rate, pressure and transport where the state varies little over that length. At
    /// shorter wavelengths its structure factor is too large: at k d = 0.5 and packing 0.25, 0.53
    /// with one simulator per disk and 0.40 with four, where exact disks have 0.335.
    ///
    /// With more simulators the density is averaged over about a diameter around the point halfway
    /// to contact. With 16 per disk, S(k d) agrees with exact disks within 5 % up to k d = 1.
    ContactPoint {
        /// Radius around the point within which all simulators are equally likely; outside it the
        /// nearest in the cells around is taken \[length\]. `None`: half the diameter, or a quarter
        /// of the mean free path if that is longer.
        radius: Option<f64>,
    },
}

impl Scheme {
    /// Contact-point scheme with its default radius: the scheme to compare with exact disks.
    pub const CONTACT_POINT: Self = Self::ContactPoint { radius: None };

    /// All schemes, each with its default settings.
    pub const ALL: [Self; 7] = [
        Self::Collisionless,
        Self::Boltzmann,
        Self::FreeVolume,
        Self::Enskog(Neighbourhood::Cells(2)),
        Self::Esmc(Neighbourhood::Cells(2)),
        Self::StochasticDisks { stiffness: 1.0 },
        Self::CONTACT_POINT,
    ];

    /// Scheme of a [`Self::name`], with its default settings.
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

    /// Name used in file names and tables.
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

    /// Returns true if partners are drawn by position, also from other cells.
    pub fn is_across(self) -> bool {
        matches!(
            self,
            Self::Esmc(_) | Self::StochasticDisks { .. } | Self::ContactPoint { .. }
        )
    }

    /// Returns true if collisions carry momentum over the distance of the partners, as those of
    /// exact particles do; their virial is then part of the pressure. Partners within a cell are
    /// treated as points.
    pub fn carries(self) -> bool {
        self.is_across()
    }

    /// Returns true if partners in a uniform shear flow count as a contact distance apart, as in
    /// Enskog's theory. The flow between them then contributes to their approach speed, and they
    /// carry momentum over that distance. Other pairs within a cell are treated as points.
    pub fn feels_flow(self) -> bool {
        matches!(self, Self::Enskog(_))
    }

    /// Returns true if the number of candidate pairs follows from a bound of the approach speed.
    pub(crate) fn bounds_trials(self) -> bool {
        !matches!(self, Self::StochasticDisks { .. })
    }

    /// Factor chi at a packing fraction, before any limit.
    pub fn contact_value<S: Space>(self, packing_fraction: f64) -> f64 {
        match self {
            Self::Collisionless | Self::Boltzmann => 1.0,
            Self::FreeVolume if packing_fraction >= S::RANDOM_CLOSE_PACKING => f64::INFINITY,
            Self::FreeVolume => 1.0 / (1.0 - packing_fraction / S::RANDOM_CLOSE_PACKING),
            _ => S::contact_value(packing_fraction),
        }
    }
}
