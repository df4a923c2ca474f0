//! The engines of a case, with every numerical choice made.

use stosszahl_case::Kind;
use stosszahl_case::format::{
    Copies as WrittenCopies, Displacement as WrittenDisplacement, Face, FaceWord, Inelastic,
    MonteCarlo, Neighbourhood as WrittenNeighbourhood, WallsActOn,
};
use stosszahl_dsmc::{Clearance, Copies, Displacement, Neighbourhood, Parameters, Scheme, Weights};
use stosszahl_model::{Plane, Space, Volume, transport};

use super::boundaries;
use super::data::{EngineKind, EnginePlan, Plan, PlanError};

/// All engines, in their order.
pub(super) fn all(plan: &mut Plan) -> Result<Vec<EnginePlan>, PlanError> {
    let written = plan.case.engine.clone();
    let mut list = Vec::new();
    if let Some(ed) = &written.ed {
        let refused = |found: &str, allowed| Err(PlanError::new("engine.ed", found, allowed));
        if plan.kind == Kind::Homogeneous {
            return refused("exact dynamics without a box", "a [box] beside it");
        }
        if plan.dimension != 2 {
            return refused("exact dynamics of spheres", "disks: gas.dimension = 2");
        }
        let open =
            |axis| *plan.case.walls.at(axis, 0) == open() || *plan.case.walls.at(axis, 1) == open();
        if open(0) || open(1) {
            return refused(
                "exact dynamics in an open box",
                "closed faces: it keeps its disks",
            );
        }
        list.push(EnginePlan {
            name: "ed",
            kind: EngineKind::EventDriven {
                contact_time: ed.contact_time * plan.time,
                collision_limit: ed.collision_limit,
            },
            clearance: Clearance::Radius,
            weights: Weights::uniform(),
        });
    }
    let schemes = [
        ("dsmc-boltzmann", written.boltzmann, Scheme::Boltzmann),
        ("dsmc-free-volume", written.free_volume, Scheme::FreeVolume),
        (
            "dsmc-enskog",
            written.enskog,
            Scheme::Enskog(Neighbourhood::Cells(2)),
        ),
        (
            "dsmc-esmc",
            written.esmc,
            Scheme::Esmc(Neighbourhood::Cells(2)),
        ),
        (
            "dsmc-stochastic-disks",
            written.stochastic_disks,
            Scheme::StochasticDisks { stiffness: 1.0 },
        ),
        (
            "dsmc-contact-point",
            written.contact_point,
            Scheme::ContactPoint { radius: None },
        ),
    ];
    for (name, written, scheme) in schemes {
        let Some(written) = written else { continue };
        if plan.kind == Kind::Homogeneous {
            let key = format!("engine.{name}");
            return Err(PlanError::new(
                key,
                "cells without a box",
                "[engine.dsmc-homogeneous], or a [box]",
            ));
        }
        list.push(match plan.dimension {
            2 => monte_carlo::<Plane>(plan, name, &written, scheme)?,
            _ => monte_carlo::<Volume>(plan, name, &written, scheme)?,
        });
    }
    match (plan.kind, written.homogeneous) {
        (Kind::Homogeneous, selection) => list.push(EnginePlan {
            name: "dsmc-homogeneous",
            kind: EngineKind::Homogeneous(selection.unwrap_or_default().selection),
            clearance: Clearance::Centre,
            weights: Weights::uniform(),
        }),
        (_, Some(_)) => {
            let key = "engine.dsmc-homogeneous";
            return Err(PlanError::new(
                key,
                "a gas without positions in a [box]",
                "no [box] beside it",
            ));
        }
        _ => {}
    }
    if list.is_empty() {
        return Err(PlanError::new("engine", "none", "at least one engine"));
    }
    if plan.case.gas.mean_free_path.is_some() && list.iter().any(|one| one.name != "dsmc-boltzmann")
    {
        let allowed = "dsmc-boltzmann alone beside it: diameters are scaled";
        return Err(PlanError::new(
            "gas.mean_free_path",
            "other engines",
            allowed,
        ));
    }
    Ok(list)
}

fn open() -> Face {
    Face::Word(FaceWord::Open)
}

/// A Monte Carlo engine: what is written, over the defaults of its scheme.
fn monte_carlo<S: Space>(
    plan: &mut Plan,
    name: &'static str,
    written: &MonteCarlo,
    scheme: Scheme,
) -> Result<EnginePlan, PlanError> {
    let key = |name_of_key: &str| format!("engine.{name}.{name_of_key}");
    refuse_unknown(written, scheme, &key)?;
    let unit = plan.scale.length;
    let neighbourhood = |default| match written.neighbourhood {
        Some(WrittenNeighbourhood::Cells(cells)) => Neighbourhood::Cells(cells as u32),
        Some(WrittenNeighbourhood::Whole(_)) => Neighbourhood::Mean,
        None => default,
    };
    let scheme = match scheme {
        Scheme::Enskog(default) => Scheme::Enskog(neighbourhood(default)),
        Scheme::Esmc(default) => Scheme::Esmc(neighbourhood(default)),
        Scheme::StochasticDisks { stiffness } => Scheme::StochasticDisks {
            stiffness: written.stiffness.unwrap_or(stiffness),
        },
        Scheme::ContactPoint { .. } => Scheme::ContactPoint {
            radius: written.partner_radius.map(|radius| radius / unit),
        },
        other => other,
    };
    let mut parameters = Parameters::for_scheme(scheme);
    if let Some(displacement) = written.displacement {
        parameters.displacement = match displacement {
            WrittenDisplacement::Switch(false) => Displacement::None,
            WrittenDisplacement::Switch(true) => Displacement::Diameter,
            WrittenDisplacement::Word(Inelastic::Inelastic) => Displacement::Inelastic,
        };
    }
    let boxed = plan.is_bounded() || !plan.case.inflow.is_empty() || written.weights.is_some();
    if boxed && parameters.displacement != Displacement::None {
        let found = "a displacement (the default of this scheme) beside walls, openings, obstacles or weights";
        let allowed = "false there, for partners would be displaced through walls";
        return Err(PlanError::new(key("displacement"), found, allowed));
    }
    if scheme.is_across() && (written.weights.is_some() || !plan.case.obstacle.is_empty()) {
        let allowed = "dsmc-boltzmann, dsmc-free-volume or dsmc-enskog";
        return Err(PlanError::new(
            format!("engine.{name}"),
            "obstacles or weights",
            allowed,
        ));
    }
    let steps = written
        .steps_per_crossing
        .or(written.steps_per_mean_free_time);
    parameters.steps_per_crossing = steps.unwrap_or(parameters.steps_per_crossing);
    parameters.largest_contact_value =
        (written.largest_contact_value).unwrap_or(parameters.largest_contact_value);
    let diameter = 2.0 * plan.mean_radius();
    let chaotic = matches!(scheme, Scheme::ContactPoint { .. });
    parameters.simulators_per_disk = match written.simulators_per_particle {
        Some(simulators) => simulators as u32,
        None if chaotic => {
            Parameters::enough_for_chaos::<S>(scheme, plan.packing_fraction, diameter, plan.count())
        }
        None => parameters.simulators_per_disk,
    };
    parameters.copies = match written.copies {
        Some(WrittenCopies::Independent) => Copies::Independent,
        Some(WrittenCopies::Coherent) => Copies::Coherent,
        // A gas that shear modes destabilise needs their seeds; in any other the copies are better independent.
        None if chaotic && plan.has_unstable_modes() => Copies::Coherent,
        None => parameters.copies,
    };
    parameters.cell_size = match written.cell_size {
        Some(size) => Some(size / unit),
        None if plan.kind == Kind::Flow && !scheme.is_across() => {
            Some(plan.cell_of_flow::<S>(scheme, parameters.simulators_per_disk))
        }
        None => None,
    };
    let centre = match written.walls_act_on {
        Some(place) => place == WallsActOn::Centre,
        None => scheme == Scheme::Boltzmann,
    };
    Ok(EnginePlan {
        name,
        kind: EngineKind::MonteCarlo(parameters),
        clearance: if centre {
            Clearance::Centre
        } else {
            Clearance::Radius
        },
        weights: boundaries::weights(&format!("engine.{name}"), written.weights.as_ref())?,
    })
}

/// Refuses keys that a scheme does not have.
fn refuse_unknown(
    written: &MonteCarlo,
    scheme: Scheme,
    key: &impl Fn(&str) -> String,
) -> Result<(), PlanError> {
    let point = matches!(scheme, Scheme::ContactPoint { .. });
    let stochastic = matches!(scheme, Scheme::StochasticDisks { .. });
    let around = matches!(scheme, Scheme::Enskog(_) | Scheme::Esmc(_));
    let across = scheme.is_across();
    let limited = !stochastic && scheme != Scheme::Boltzmann;
    let keys = [
        ("cell_size", written.cell_size.is_some(), !stochastic),
        (
            "steps_per_crossing",
            written.steps_per_crossing.is_some(),
            !across,
        ),
        (
            "steps_per_mean_free_time",
            written.steps_per_mean_free_time.is_some(),
            across,
        ),
        ("displacement", written.displacement.is_some(), !across),
        ("neighbourhood", written.neighbourhood.is_some(), around),
        (
            "largest_contact_value",
            written.largest_contact_value.is_some(),
            limited,
        ),
        ("partner_radius", written.partner_radius.is_some(), point),
        ("copies", written.copies.is_some(), point),
        ("stiffness", written.stiffness.is_some(), stochastic),
        ("weights", written.weights.is_some(), !across),
    ];
    match keys.iter().find(|(_, given, known)| *given && !known) {
        Some((name, ..)) => Err(PlanError::new(
            key(name),
            "a key of other schemes",
            "nothing here",
        )),
        None => Ok(()),
    }
}

impl Plan {
    /// Mean radius of the particles.
    pub(super) fn mean_radius(&self) -> f64 {
        if let [one] = &self.species[..] {
            return one.radius;
        }
        let sum: f64 = (self.species.iter())
            .map(|one| one.count as f64 * one.radius)
            .sum();
        sum / self.count() as f64
    }

    /// Whether the box is wider than the shortest wave of shear that grows while the gas cools.
    pub fn has_unstable_modes(&self) -> bool {
        let widest = self.lengths[0].max(self.lengths[1]);
        self.kind == Kind::Comparison
            && self.dimension == 2
            && self.restitution < 1.0
            && self.case.drive.is_none()
            && widest
                > transport::critical_length(
                    self.packing_fraction,
                    self.contact_value,
                    self.restitution,
                )
    }

    /// Side of a cell in a flow: half the mean free path of the uniform box, and at least such that a cell holds ten
    /// simulators; no less than two diameters for dense schemes.
    fn cell_of_flow<S: Space>(&self, scheme: Scheme, simulators_per_particle: u32) -> f64 {
        let simulators = self.count() as f64 * f64::from(simulators_per_particle);
        let ten = (10.0 * self.volume / simulators).powf(1.0 / self.dimension as f64);
        let densest = if self.dimension == 2 { 0.6 } else { 0.5 };
        let chi = match scheme {
            Scheme::Boltzmann => 1.0,
            _ => S::contact_value(self.packing_fraction.min(densest)),
        };
        let wanted = (0.5 * self.dilute_mean_free_path() / chi).max(ten);
        if scheme == Scheme::Boltzmann {
            wanted
        } else {
            let largest = self
                .species
                .iter()
                .map(|one| one.radius)
                .fold(0.0, f64::max);
            wanted.max(4.0 * largest)
        }
    }

    /// Sides of a Monte Carlo cell; zero beyond the dimension.
    pub fn cell(&self, parameters: &Parameters) -> [f64; 3] {
        let diameter = 2.0 * self.mean_radius();
        let counts = match self.dimension {
            2 => cells::<Plane>(parameters, self, diameter),
            _ => cells::<Volume>(parameters, self, diameter),
        };
        [0, 1, 2].map(|axis| self.lengths[axis] / counts[axis] as f64)
    }

    /// Mean number of simulators in a Monte Carlo cell.
    pub fn simulators_per_cell(&self, parameters: &Parameters) -> f64 {
        let cell: f64 = self.cell(parameters)[..self.dimension].iter().product();
        let share = cell / self.volume;
        share * self.count() as f64 * f64::from(parameters.simulators_per_disk)
    }

    /// Radius around the point of contact within which partners are drawn.
    pub fn partner_radius(&self, parameters: &Parameters) -> f64 {
        let (packing, diameter) = (self.packing_fraction, 2.0 * self.mean_radius());
        match self.dimension {
            2 => parameters.partner_radius::<Plane>(packing, diameter),
            _ => parameters.partner_radius::<Volume>(packing, diameter),
        }
    }

    /// Mean free path by the collision rate of a scheme.
    pub fn scheme_path(&self, parameters: &Parameters) -> f64 {
        let (packing, diameter) = (self.packing_fraction, 2.0 * self.mean_radius());
        match self.dimension {
            2 => parameters.mean_free_path::<Plane>(packing, diameter),
            _ => parameters.mean_free_path::<Volume>(packing, diameter),
        }
    }
}

fn cells<S: Space>(parameters: &Parameters, plan: &Plan, diameter: f64) -> [usize; 3] {
    let lengths = S::vector(|axis| plan.lengths[axis]);
    // The sides are positive, or the plan would not be.
    stosszahl_model::Domain::<S>::periodic(lengths).map_or([1; 3], |domain| {
        parameters.cells(&domain, plan.packing_fraction, diameter)
    })
}
