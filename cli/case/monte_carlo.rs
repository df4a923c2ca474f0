//! The Monte Carlo engines of a case.

use serde::Serialize;

use super::written;

/// A Monte Carlo engine.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Dsmc {
    /// Which pairs collide, and how often.
    pub scheme: Scheme,
    /// Width of a cell in diameters, above 0; none leaves it to the engine.
    pub cell_size: Option<f64>,
    /// Simulated particles for each disk, 1 to 1000; none leaves it to the engine.
    pub simulators_per_disk: Option<u32>,
    /// Steps in which a mean free time passes and, for pairs within cells, in which the fastest particle crosses a
    /// cell; at least 1.
    pub steps_per_crossing: f64,
}

/// Which pairs collide, and how often.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Scheme {
    /// Pairs within a cell at the dilute rate.
    Boltzmann {
        /// How far partners are displaced.
        displacement: Displacement,
    },
    /// Pairs within a cell, more often the smaller its free volume.
    FreeVolume {
        /// How far partners are displaced.
        displacement: Displacement,
        /// Limit on the contact value, at least 1.
        largest: f64,
    },
    /// Pairs within a cell at the rate of Enskog's theory.
    Enskog {
        /// How far partners are displaced.
        displacement: Displacement,
        /// Where the packing fraction is taken.
        neighbourhood: Neighbourhood,
        /// Limit on the contact value, at least 1.
        largest: f64,
    },
    /// A partner from the cell of the point of contact.
    Esmc {
        /// Where the packing fraction is taken.
        neighbourhood: Neighbourhood,
        /// Limit on the contact value, at least 1.
        largest: f64,
    },
    /// Overlapping disks along their line of centres.
    StochasticDisks {
        /// How readily they collide, above 0.
        stiffness: f64,
    },
    /// A partner around the point of contact, at the rate of Enskog's theory.
    ContactPoint {
        /// From how far around, in diameters, at least 0; none leaves it to the engine.
        partner_radius: Option<f64>,
        /// How several simulators of a disk start; none leaves it to the program.
        copies: Option<Copies>,
        /// Limit on the contact value, at least 1.
        largest: f64,
    },
}

impl Scheme {
    /// The name of its engine in case files and results.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Boltzmann { .. } => "dsmc-boltzmann",
            Self::FreeVolume { .. } => "dsmc-free-volume",
            Self::Enskog { .. } => "dsmc-enskog",
            Self::Esmc { .. } => "dsmc-esmc",
            Self::StochasticDisks { .. } => "dsmc-stochastic-disks",
            Self::ContactPoint { .. } => "dsmc-contact-point",
        }
    }

    /// Whether partners are sought within a cell, so that cells are their own error.
    pub fn within_cells(&self) -> bool {
        matches!(
            self,
            Self::Boltzmann { .. } | Self::FreeVolume { .. } | Self::Enskog { .. }
        )
    }
}

/// How far the partners of a collision are displaced along the momentum that each receives.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Displacement {
    /// Not at all.
    None,
    /// One diameter.
    Diameter,
    /// d (1 + r)/(2 r) for a contact with restitution r.
    Inelastic,
}

/// How several simulators of a disk start.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Copies {
    /// Each set moved and turned at random.
    Independent,
    /// Each set with the long waves of the start.
    Coherent,
}

/// Where the packing fraction in the contact value is taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Neighbourhood {
    /// Over the `(2n+1)^2` cells around, with `n` from 0 to 50.
    Cells(u32),
    /// In the whole box.
    Mean,
}

/// The Monte Carlo engines of a case as written, in the order of [`super::Case::engines`].
pub(super) fn engines(written: &written::Engines) -> Vec<Dsmc> {
    let boltzmann = written.boltzmann.as_ref().map(|table| Dsmc {
        scheme: Scheme::Boltzmann {
            displacement: table.displacement.into(),
        },
        cell_size: table.cell_size,
        simulators_per_disk: Some(table.simulators_per_disk),
        steps_per_crossing: table.steps_per_crossing,
    });
    let free_volume = written.free_volume.as_ref().map(|table| Dsmc {
        scheme: Scheme::FreeVolume {
            displacement: table.displacement.into(),
            largest: table.largest_contact_value,
        },
        cell_size: table.cell_size,
        simulators_per_disk: Some(table.simulators_per_disk),
        steps_per_crossing: table.steps_per_crossing,
    });
    let enskog = written.enskog.as_ref().map(|table| Dsmc {
        scheme: Scheme::Enskog {
            displacement: table.displacement.into(),
            neighbourhood: table.neighbourhood.into(),
            largest: table.largest_contact_value,
        },
        cell_size: table.cell_size,
        simulators_per_disk: Some(table.simulators_per_disk),
        steps_per_crossing: table.steps_per_crossing,
    });
    let esmc = written.esmc.as_ref().map(|table| Dsmc {
        scheme: Scheme::Esmc {
            neighbourhood: table.neighbourhood.into(),
            largest: table.largest_contact_value,
        },
        cell_size: table.cell_size,
        simulators_per_disk: Some(table.simulators_per_disk),
        steps_per_crossing: table.steps_per_mean_free_time,
    });
    let stochastic_disks = written.stochastic_disks.as_ref().map(|table| Dsmc {
        scheme: Scheme::StochasticDisks {
            stiffness: table.stiffness,
        },
        cell_size: None,
        simulators_per_disk: Some(table.simulators_per_disk),
        steps_per_crossing: table.steps_per_mean_free_time,
    });
    let contact_point = written.contact_point.as_ref().map(|table| Dsmc {
        scheme: Scheme::ContactPoint {
            partner_radius: table.partner_radius,
            copies: table.copies.map(Into::into),
            largest: table.largest_contact_value,
        },
        cell_size: table.cell_size,
        simulators_per_disk: table.simulators_per_disk,
        steps_per_crossing: table.steps_per_mean_free_time,
    });
    [
        boltzmann,
        free_volume,
        enskog,
        esmc,
        stochastic_disks,
        contact_point,
    ]
    .into_iter()
    .flatten()
    .collect()
}

impl From<written::Displacement> for Displacement {
    fn from(written: written::Displacement) -> Self {
        match written {
            written::Displacement::Switch(false) => Self::None,
            written::Displacement::Switch(true) => Self::Diameter,
            written::Displacement::Word(written::Inelastic::Inelastic) => Self::Inelastic,
        }
    }
}

impl From<written::Copies> for Copies {
    fn from(written: written::Copies) -> Self {
        match written {
            written::Copies::Independent => Self::Independent,
            written::Copies::Coherent => Self::Coherent,
        }
    }
}

impl From<written::Neighbourhood> for Neighbourhood {
    fn from(written: written::Neighbourhood) -> Self {
        match written {
            written::Neighbourhood::Cells(cells) => Self::Cells(cells),
            written::Neighbourhood::Whole(written::Mean::Mean) => Self::Mean,
        }
    }
}
