//! Collision schemes of the DSMC: which pairs collide, how often, and how density enters.

use serde::{Deserialize, Serialize};
use stosszahl_model::Space;

/// Window of the local packing fraction: the cells over which it is averaged.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Neighbourhood {
    /// Window of the whole box: the mean packing fraction.
    Mean,
    /// Square or cubic window of (2n + 1)^D cells around a cell.
    Cells(u32),
}

/// Displacement of the partners of a collision within a cell, along the momentum that each
/// receives.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum PartnerDisplacement {
    /// No displacement of partners.
    None,
    /// Displacement of partners by the contact distance d: Alexander, Garcia & Alder, Phys. Rev.
    /// Lett. 74, 5212 (1995), doi:10.1103/PhysRevLett.74.5212. The collisional pressure is then
    /// that of elastic hard particles, times 2r/(1 + r) for restitution r, which shortens the
    /// momentum that is carried.
    Diameter,
    /// Displacement of partners by d (1 + r)/(2r), with restitution r, which gives the pressure of
    /// elastic hard particles. Not for restitution 0.
    Inelastic,
}

/// Contact of particles with walls: distance from a wall at which the particle's centre is stopped.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum WallClearance {
    /// A wall stops a particle's centre: particles are points for walls, as in the dilute gas.
    #[default]
    Centre,
    /// A wall stops a particle's surface: the centre stays one radius away.
    Radius,
}

/// Algorithm by which a scheme selects the partner of a collision.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PartnerSelection {
    /// No partners: particles do not collide, as in free molecular flow.
    None,
    /// Partner is any other simulator of the same cell.
    WithinCell,
    /// Partner is a simulator of the cell at the contact distance along a random line of centres
    /// (ESMC).
    ContactCell,
    /// Partner is a simulator that overlaps, in the same cell or a neighbouring one (stochastic
    /// hard disks).
    Overlap,
    /// Partner is a simulator within a radius around the point of contact, or the nearest to it.
    AroundContact,
}

/// Contact value chi of a scheme as a function of density, the factor on the collision rate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ContactLaw {
    /// Contact value chi = 1: the collision rate of the dilute gas.
    Dilute,
    /// Contact value chi = V/(V - `V_0`), with `V_0` the volume of the particles at random close
    /// packing.
    FreeVolume,
    /// Contact value chi of [`Space::contact_value`], as in Enskog's theory.
    Enskog,
}

/// Window of the packing fraction from which a scheme takes its contact value: fixed or adaptive.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DensityWindow {
    /// Window with a fixed number of cells.
    Fixed(Neighbourhood),
    /// Window whose width follows from the number of simulators per particle: at least three
    /// diameters, or about one with many simulators.
    Adaptive,
}

/// Properties in which collision schemes differ: partners, contact value, density window, and
/// defaults of parameters.
#[derive(Clone, Copy, Debug)]
pub struct SchemeProperties {
    /// Name of the scheme in file names and tables.
    pub name: &'static str,
    /// Algorithm that selects the partners of collisions.
    pub partners: PartnerSelection,
    /// Contact value chi as a function of density.
    pub contact: ContactLaw,
    /// Window of cells in which the packing fraction is taken.
    pub window: DensityWindow,
    /// Default displacement of partners in collisions within a cell.
    pub displacement: PartnerDisplacement,
    /// Default number of time steps in a mean free time and in the time to cross a cell.
    pub steps_per_cell_crossing: f64,
    /// Default upper limit of the contact value chi.
    pub max_contact_value: f64,
    /// Default contact of particles with walls: by the centre for point-like particles, by the
    /// surface for hard ones.
    pub clearance: WallClearance,
    /// True if the shear flow between partners contributes to their approach speed, and partners
    /// carry momentum over their distance: the contact distance, as in Enskog's theory, or that of
    /// their centres if they overlap. Other partners are treated as points.
    pub feels_flow: bool,
    /// Branch of a replica's random streams that the scheme uses, so that schemes draw different
    /// numbers.
    pub random_branch: u64,
}

/// Collision scheme: which pairs collide, and how often.
///
/// Collision rates per pair are the rates of kinetic theory times chi. The first four schemes draw
/// pairs within a cell; the last three draw partners by position, at about a contact distance d.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Scheme {
    /// Free molecular flow: no collisions at all.
    Collisionless,
    /// Boltzmann scheme of a dilute gas, contact value chi = 1. Converges to the Boltzmann
    /// equation.
    Boltzmann,
    /// Free-volume scheme of Luding, Müller & McNamara (1998): pairs within a cell, at a rate
    /// raised by the free volume of the cell.
    ///
    /// chi = V/(V - `V_0`), `V_0` the area that the disks of the cell need at random close packing,
    /// 0.82 (spheres: 0.64). 9 % below Enskog at packing 0.25; without a limit it is infinite or
    /// negative in a crowded cell.
    FreeVolume,
    /// Enskog scheme: pairs within a cell, with the contact value chi at the packing fraction
    /// around the cell. With many simulators it has the local Enskog collision rate.
    Enskog(Neighbourhood),
    /// Enskog Simulation Monte Carlo, ESMC (Montanero & Santos, Phys. Rev. E 54, 438 (1996),
    /// doi:10.1103/PhysRevE.54.438): partners from the cell at contact distance.
    ///
    /// A partner is drawn from the cell at distance d from the simulator along a random line of
    /// centres, with probability proportional to the number in that cell and chi halfway. With many
    /// simulators and small cells it solves the Enskog equation.
    Esmc(Neighbourhood),
    /// Stochastic hard-sphere dynamics (Donev, Alder & Garcia, Phys. Rev. Lett. 101, 075902 (2008),
    /// doi:10.1103/PhysRevLett.101.075902): overlapping pairs collide at random.
    ///
    /// Pairs closer than d that approach at `g_n` along their line of centres collide at the rate
    /// `stiffness` D chi `g_n`/d. The gas is a fluid of penetrable particles, with fluctuations and
    /// structure of its own equation of state. At large stiffness it tends to exact hard particles,
    /// its collision rate from below.
    StochasticDisks {
        /// Relative collision rate of overlapping simulators; 1 would give Enskog's rate if they
        /// overlapped as often as in the dilute gas.
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
        /// Radius around the point of contact within which all simulators are equally likely
        /// partners \[length\]; without any, the nearest in the cells around is taken. `None`: half
        /// the diameter, or a quarter of the mean free path if that is longer.
        radius: Option<f64>,
    },
}

impl Scheme {
    /// Contact-point scheme with its default partner radius: the scheme to compare with exact
    /// disks.
    pub const CONTACT_POINT: Self = Self::ContactPoint { radius: None };

    /// List of all collision schemes, each with its default settings.
    pub const ALL: [Self; 7] = [
        Self::Collisionless,
        Self::Boltzmann,
        Self::FreeVolume,
        Self::Enskog(Neighbourhood::Cells(2)),
        Self::Esmc(Neighbourhood::Cells(2)),
        Self::StochasticDisks { stiffness: 1.0 },
        Self::CONTACT_POINT,
    ];

    /// Returns the collision scheme with a [`Self::name`], in its default settings; `None` for an
    /// unknown name.
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

    /// Returns the properties of the scheme: partners, contact value, density window, and defaults
    /// of parameters.
    pub const fn properties(self) -> SchemeProperties {
        /// Limit of the contact value chi for schemes without a limit of their own: above chi at
        /// any packing fraction.
        const UNLIMITED: f64 = 1e3;
        /// Properties that most schemes with pairs within cells have in common.
        const WITHIN_CELL: SchemeProperties = SchemeProperties {
            name: "",
            partners: PartnerSelection::WithinCell,
            contact: ContactLaw::Enskog,
            window: DensityWindow::Fixed(Neighbourhood::Mean),
            displacement: PartnerDisplacement::Diameter,
            steps_per_cell_crossing: 4.0,
            max_contact_value: 10.0,
            clearance: WallClearance::Radius,
            feels_flow: false,
            random_branch: 0,
        };
        /// Properties that most schemes with partners across cells have in common.
        const CROSS_CELL: SchemeProperties = SchemeProperties {
            displacement: PartnerDisplacement::None,
            feels_flow: true,
            ..WITHIN_CELL
        };
        /// Properties of schemes for the dilute gas of point-like particles.
        const DILUTE: SchemeProperties = SchemeProperties {
            contact: ContactLaw::Dilute,
            displacement: PartnerDisplacement::None,
            max_contact_value: 1.0,
            clearance: WallClearance::Centre,
            ..WITHIN_CELL
        };
        match self {
            Self::Collisionless => SchemeProperties {
                name: "collisionless",
                partners: PartnerSelection::None,
                random_branch: 0,
                ..DILUTE
            },
            Self::Boltzmann => SchemeProperties {
                name: "boltzmann",
                random_branch: 1,
                ..DILUTE
            },
            Self::FreeVolume => SchemeProperties {
                name: "free-volume",
                contact: ContactLaw::FreeVolume,
                window: DensityWindow::Fixed(Neighbourhood::Cells(0)),
                random_branch: 2,
                ..WITHIN_CELL
            },
            Self::Enskog(neighbourhood) => SchemeProperties {
                name: "enskog",
                window: DensityWindow::Fixed(neighbourhood),
                feels_flow: true,
                random_branch: 3,
                ..WITHIN_CELL
            },
            Self::Esmc(neighbourhood) => SchemeProperties {
                name: "esmc",
                partners: PartnerSelection::ContactCell,
                window: DensityWindow::Fixed(neighbourhood),
                steps_per_cell_crossing: 8.0,
                random_branch: 4,
                ..CROSS_CELL
            },
            Self::StochasticDisks { .. } => SchemeProperties {
                name: "stochastic-disks",
                partners: PartnerSelection::Overlap,
                window: DensityWindow::Fixed(Neighbourhood::Cells(2)),
                steps_per_cell_crossing: 20.0,
                max_contact_value: UNLIMITED,
                random_branch: 5,
                ..CROSS_CELL
            },
            Self::ContactPoint { .. } => SchemeProperties {
                name: "contact-point",
                partners: PartnerSelection::AroundContact,
                window: DensityWindow::Adaptive,
                max_contact_value: 100.0,
                random_branch: 6,
                ..CROSS_CELL
            },
        }
    }

    /// Returns the scheme with other settings; settings that the scheme does not have are ignored.
    #[must_use]
    pub fn with_settings(self, settings: SchemeSettings) -> Self {
        match self {
            Self::Enskog(default) => Self::Enskog(settings.neighbourhood.unwrap_or(default)),
            Self::Esmc(default) => Self::Esmc(settings.neighbourhood.unwrap_or(default)),
            Self::StochasticDisks { stiffness } => Self::StochasticDisks {
                stiffness: settings.stiffness.unwrap_or(stiffness),
            },
            Self::ContactPoint { radius } => Self::ContactPoint {
                radius: settings.radius.or(radius),
            },
            Self::Collisionless | Self::Boltzmann | Self::FreeVolume => self,
        }
    }

    /// Returns the collision rate of overlapping simulators, relative to that at which dilute ones
    /// would have Enskog's rate; 1 for schemes without overlap.
    pub(crate) const fn stiffness(self) -> f64 {
        match self {
            Self::StochasticDisks { stiffness } => stiffness,
            _ => 1.0,
        }
    }

    /// Returns the name of the scheme in file names and tables.
    pub const fn name(self) -> &'static str {
        self.properties().name
    }

    /// Returns the algorithm by which the scheme selects collision partners.
    pub const fn partners(self) -> PartnerSelection {
        self.properties().partners
    }

    /// Returns true if partners are drawn by position, also from other cells. Their collisions
    /// carry momentum over the distance of the partners, as collisions of exact particles do, and
    /// their virial is part of the pressure. Partners within a cell are treated as points.
    pub fn is_cross_cell(self) -> bool {
        matches!(
            self.partners(),
            PartnerSelection::ContactCell
                | PartnerSelection::Overlap
                | PartnerSelection::AroundContact
        )
    }

    /// Returns true if the contact value is 1, so that the collision rate is that of the dilute gas
    /// at any density.
    pub fn is_dilute(self) -> bool {
        self.properties().contact == ContactLaw::Dilute
    }

    /// Returns the contact value chi of the scheme at a packing fraction, before any limit.
    pub fn contact_value<S: Space>(self, packing_fraction: f64) -> f64 {
        match self.properties().contact {
            ContactLaw::Dilute => 1.0,
            ContactLaw::FreeVolume if packing_fraction >= S::RANDOM_CLOSE_PACKING => f64::INFINITY,
            ContactLaw::FreeVolume => 1.0 / (1.0 - packing_fraction / S::RANDOM_CLOSE_PACKING),
            ContactLaw::Enskog => S::contact_value(packing_fraction),
        }
    }
}

/// Settings that only some collision schemes have; `None` for the default.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SchemeSettings {
    /// Window of the local packing fraction in [`Scheme::Enskog`] and [`Scheme::Esmc`].
    pub neighbourhood: Option<Neighbourhood>,
    /// Relative collision rate of overlapping simulators in [`Scheme::StochasticDisks`].
    pub stiffness: Option<f64>,
    /// Radius of the partner search around the point of contact in [`Scheme::ContactPoint`]
    /// \[length\].
    pub radius: Option<f64>,
}
