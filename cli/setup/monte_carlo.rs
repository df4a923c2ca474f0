//! What the Monte Carlo engines of a case are told.

use stosszahl_dsmc::{Copies, Displacement, Parameters};
use stosszahl_model::{Plane, transport};

use super::Setup;
use crate::case::{self, Dsmc, Scheme};

impl Setup {
    /// The numerical choices of a Monte Carlo engine; those that the case leaves open are made here.
    pub fn dsmc_parameters(&self, dsmc: &Dsmc) -> Parameters {
        let (scheme, displacement, largest) = scheme(dsmc.scheme);
        let copies = match dsmc.scheme {
            Scheme::ContactPoint { copies, .. } => copies.map(Into::into),
            _ => Some(Copies::Independent),
        };
        // A gas that shear modes destabilise needs their seeds; any other is better made of strangers.
        let copies = copies.unwrap_or_else(|| {
            if self.has_unstable_modes() {
                Copies::Coherent
            } else {
                Copies::Independent
            }
        });
        Parameters {
            scheme,
            displacement: displacement.map_or(Displacement::None, Into::into),
            cell_size: dsmc.cell_size,
            simulators_per_disk: dsmc.simulators_per_disk.unwrap_or_else(|| {
                Parameters::strangers::<Plane>(scheme, self.packing_fraction, 1.0, self.disks)
            }),
            copies,
            steps_per_crossing: dsmc.steps_per_crossing,
            largest_contact_value: largest,
        }
    }

    /// Whether the box is wider than the shortest wave of shear that grows while the gas cools.
    pub fn has_unstable_modes(&self) -> bool {
        let lengths = self.domain.lengths();
        let widest = lengths[0].max(lengths[1]);
        self.restitution < 1.0
            && self.case.drive.is_none()
            && widest
                > transport::critical_length(
                    self.packing_fraction,
                    self.contact_value,
                    self.restitution,
                )
    }

    /// Simulators for each disk.
    pub fn copies(&self, dsmc: &Dsmc) -> f64 {
        f64::from(self.dsmc_parameters(dsmc).simulators_per_disk)
    }

    /// Steps of a Monte Carlo engine up to the end of the run, about.
    pub fn expected_steps(&self, dsmc: &Dsmc) -> f64 {
        let parameters = self.dsmc_parameters(dsmc);
        // The fastest of many simulators has about 4.5 thermal speeds, a mean one 1.25.
        let path = parameters.mean_free_path::<Plane>(self.packing_fraction, 1.0);
        let mut step = path / 1.25;
        if dsmc.scheme.within_cells() {
            step = step.min(self.cell_size(dsmc)[0] / 4.5);
        }
        let time = self.expected_collisions(self.case.run.until) / self.collision_rate();
        time * dsmc.steps_per_crossing / step
    }

    /// Mean number of simulators in a Monte Carlo cell.
    pub fn simulators_per_cell(&self, dsmc: &Dsmc) -> f64 {
        let side = self.cell_size(dsmc);
        let share = side[0] * side[1] / self.domain.volume();
        share * self.disks as f64 * f64::from(self.dsmc_parameters(dsmc).simulators_per_disk)
    }

    /// Sides of a Monte Carlo cell in diameters.
    pub fn cell_size(&self, dsmc: &Dsmc) -> [f64; 2] {
        let parameters = self.dsmc_parameters(dsmc);
        let cells = parameters.cells(&self.domain, self.packing_fraction, 1.0);
        [0, 1].map(|axis| self.domain.lengths()[axis] / cells[axis] as f64)
    }
}

/// A scheme of a case as the engine has it, with its displacement and the limit on its contact value.
fn scheme(scheme: Scheme) -> (stosszahl_dsmc::Scheme, Option<case::Displacement>, f64) {
    /// For schemes without a limit of their own: beyond any packing of disks.
    const UNLIMITED: f64 = 1e3;
    use stosszahl_dsmc::Scheme as Engine;
    match scheme {
        Scheme::Boltzmann { displacement } => (Engine::Boltzmann, Some(displacement), 1.0),
        Scheme::FreeVolume {
            displacement,
            largest,
        } => (Engine::FreeVolume, Some(displacement), largest),
        Scheme::Enskog {
            displacement,
            neighbourhood,
            largest,
        } => (
            Engine::Enskog(neighbourhood.into()),
            Some(displacement),
            largest,
        ),
        Scheme::Esmc {
            neighbourhood,
            largest,
        } => (Engine::Esmc(neighbourhood.into()), None, largest),
        Scheme::StochasticDisks { stiffness } => {
            (Engine::StochasticDisks { stiffness }, None, UNLIMITED)
        }
        Scheme::ContactPoint {
            partner_radius,
            largest,
            ..
        } => {
            let radius = partner_radius;
            (Engine::ContactPoint { radius }, None, largest)
        }
    }
}

impl From<case::Neighbourhood> for stosszahl_dsmc::Neighbourhood {
    fn from(written: case::Neighbourhood) -> Self {
        match written {
            case::Neighbourhood::Mean => Self::Mean,
            case::Neighbourhood::Cells(n) => Self::Cells(n),
        }
    }
}

impl From<case::Displacement> for Displacement {
    fn from(written: case::Displacement) -> Self {
        match written {
            case::Displacement::None => Self::None,
            case::Displacement::Diameter => Self::Diameter,
            case::Displacement::Inelastic => Self::Inelastic,
        }
    }
}

impl From<case::Copies> for Copies {
    fn from(written: case::Copies) -> Self {
        match written {
            case::Copies::Independent => Self::Independent,
            case::Copies::Coherent => Self::Coherent,
        }
    }
}
