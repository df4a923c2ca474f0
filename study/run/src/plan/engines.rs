//! Plans of the engines of a case, with every numerical parameter chosen.

use stosszahl_case::Case;
use stosszahl_case::format::{
    DensityWindowSpec as WrittenNeighbourhood, DisplacementSpec as WrittenDisplacement, Inelastic,
    MonteCarloSpec, SCHEMES, SchemeFormat, SimulatorStartSpec as WrittenCopies, WallsActOn,
};
use stosszahl_dsmc::{
    Neighbourhood, Parameters, PartnerDisplacement, PartnerSelection, Scheme, SchemeSettings,
    SimulatorStart, SimulatorWeights, WallClearance,
};
use stosszahl_model::Space;
use stosszahl_theory::transport;

use super::boundaries;
use super::data::{CasePlan, EngineKind, EnginePlan, PlanError, in_space};

/// Default limit of the collision rate per particle, over the largest rate expected in the case.
const NATURAL_RATES: f64 = 1e4;

/// Plans all engines of a case, in the order of tables.
pub(super) fn all_engines(plan: &mut CasePlan) -> Result<Vec<EnginePlan>, PlanError> {
    let written = plan.case.engine.clone();
    let mut list = Vec::new();
    if let Some(ed) = &written.ed {
        list.push(EnginePlan {
            name: "ed",
            kind: EngineKind::EventDriven {
                contact_time: ed.contact_time * plan.clock.time,
                collision_limit: ed.collision_limit,
                collision_rate_limit: match ed.collision_rate_limit {
                    Some(limit) => Some(limit / plan.clock.time),
                    None => {
                        Some(NATURAL_RATES * plan.natural_rate()).filter(|rate| rate.is_normal())
                    }
                },
            },
            clearance: WallClearance::Radius,
            weights: SimulatorWeights::uniform(),
        });
    }
    for format in &SCHEMES {
        let (Some(written), Some(scheme)) = ((format.table)(&written), scheme_of(format.engine))
        else {
            continue;
        };
        let engine = in_space!(plan.gas.dimension, S => monte_carlo::<S>(plan, format.engine, written, scheme));
        list.push(engine?);
    }
    if !plan.has_box() {
        list.push(EnginePlan {
            name: "dsmc-homogeneous",
            kind: EngineKind::Homogeneous(written.homogeneous.unwrap_or_default().selection),
            clearance: WallClearance::Centre,
            weights: SimulatorWeights::uniform(),
        });
    }
    Ok(list)
}

/// Default number of simulators per cell of a flow.
const TEN: f64 = 10.0;
/// Largest default number of simulators in total: some 100 MB.
const MOST_SIMULATORS: f64 = 1_048_576.0;

/// Returns the scheme of a Monte Carlo engine in cells by the engine's name; `None` for other
/// engines.
fn scheme_of(engine: &str) -> Option<Scheme> {
    Scheme::named(engine.strip_prefix("dsmc-")?)
}

/// Number of simulators per cell at which the collision rate of a within-cell scheme is off by less
/// than 1 %. The relative error is a third over that number.
const ENOUGH_IN_A_CELL: f64 = 50.0;
/// Number of simulators per particle at which the collision rate of ESMC is off by less than 1 %.
/// The relative error is 0.3 over that number.
const ENOUGH_FOR_ESMC: f64 = 64.0;

/// Plans a Monte Carlo engine in cells from the settings of the case and the defaults of its
/// scheme.
fn monte_carlo<S: Space>(
    plan: &mut CasePlan,
    name: &'static str,
    written: &MonteCarloSpec,
    scheme: Scheme,
) -> Result<EnginePlan, PlanError> {
    let unit = plan.scale.length;
    let scheme = scheme.with_settings(SchemeSettings {
        neighbourhood: written.density_window.map(|window| match window {
            WrittenNeighbourhood::Cells(cells) => Neighbourhood::Cells(cells as u32),
            WrittenNeighbourhood::Whole(_) => Neighbourhood::Mean,
        }),
        stiffness: written.stiffness,
        radius: written.partner_radius.map(|radius| radius / unit),
    });
    let mut parameters = Parameters::for_scheme(scheme);
    parameters.displacement = match written.displacement {
        Some(WrittenDisplacement::Switch(false)) => PartnerDisplacement::None,
        Some(WrittenDisplacement::Switch(true)) => PartnerDisplacement::Diameter,
        Some(WrittenDisplacement::Word(Inelastic::Inelastic)) => PartnerDisplacement::Inelastic,
        // In a flow partners are a contact distance apart as it is.
        None if plan.is_sheared() => PartnerDisplacement::None,
        None => parameters.displacement,
    };
    let boxed = plan.is_bounded() || !plan.case.inflow.is_empty() || written.weights.is_some();
    let free = !boxed || parameters.displacement == PartnerDisplacement::None;
    let key = format!("engine.{name}.displacement");
    let found = "a displacement, the default of this scheme";
    let allowed = "false beside walls, openings, obstacles or weights, for partners would be displaced through walls";
    PlanError::require(free, key, found, allowed)?;
    let steps = (written.steps_per_cell_crossing).or(written.steps_per_mean_free_time);
    parameters.steps_per_cell_crossing = steps.unwrap_or(parameters.steps_per_cell_crossing);
    parameters.max_contact_value =
        (written.max_contact_value).unwrap_or(parameters.max_contact_value);
    let diameter = 2.0 * plan.mean_radius();
    let chaotic = scheme.partners() == PartnerSelection::AroundContact;
    parameters.simulators_per_particle = match written.simulators_per_particle {
        Some(simulators) => simulators as u32,
        None if chaotic => Parameters::enough_for_chaos::<S>(
            scheme,
            plan.gas.packing_fraction,
            diameter,
            plan.count(),
        ),
        // A case that chooses the cells also chooses their simulators.
        None if !plan.is_uniform() && !scheme.is_cross_cell() && written.cell_size.is_none() => {
            plan.simulators_of_flow(plan.resolving_cell(scheme))
        }
        None if written.cell_size.is_none() => plan.enough_simulators(&parameters),
        None => parameters.simulators_per_particle,
    };
    parameters.copies = match written.simulator_start {
        Some(WrittenCopies::Independent) => SimulatorStart::Independent,
        Some(WrittenCopies::Coherent) => SimulatorStart::Coherent,
        // A gas that shear modes destabilise needs their seeds; in any other the copies are better
        // independent.
        None if chaotic && plan.has_unstable_modes() => SimulatorStart::Coherent,
        None => parameters.copies,
    };
    parameters.cell_size = match written.cell_size {
        Some(size) => Some(size / unit),
        None if !plan.is_uniform() && !scheme.is_cross_cell() => {
            Some(plan.cell_of_flow(scheme, parameters.simulators_per_particle))
        }
        None => None,
    };
    Ok(EnginePlan {
        name,
        kind: EngineKind::MonteCarlo(parameters),
        clearance: clearance(written, scheme),
        weights: boundaries::weights(&format!("engine.{name}"), written.weights.as_ref())?,
    })
}

/// Returns whether walls and obstacles act on the centre or on the surface of particles, in a Monte
/// Carlo engine in cells.
fn clearance(written: &MonteCarloSpec, scheme: Scheme) -> WallClearance {
    match written.wall_contact {
        Some(WallsActOn::Centre) => WallClearance::Centre,
        Some(WallsActOn::Radius) => WallClearance::Radius,
        None => scheme.properties().clearance,
    }
}

/// Returns the largest wall clearance of the engines of a case: the surface of particles if any
/// engine keeps surfaces out of walls and obstacles, else the centre.
pub(super) fn widest_clearance(case: &Case) -> WallClearance {
    let by_radius = |format: &SchemeFormat| {
        let engine = (format.table)(&case.engine)
            .as_ref()
            .zip(scheme_of(format.engine));
        engine.is_some_and(|(written, scheme)| clearance(written, scheme) == WallClearance::Radius)
    };
    if SCHEMES.iter().any(by_radius) || case.engine.ed.is_some() {
        WallClearance::Radius
    } else {
        WallClearance::Centre
    }
}

impl CasePlan {
    /// Returns the mean radius of the particles \[length\].
    pub fn mean_radius(&self) -> f64 {
        if let [one] = &self.gas.species[..] {
            return one.radius;
        }
        let sum: f64 = (self.gas.species.iter())
            .map(|one| one.count as f64 * one.radius)
            .sum();
        sum / self.count() as f64
    }

    /// Returns true if the box is wider than the critical length of shear waves in a cooling gas.
    pub fn has_unstable_modes(&self) -> bool {
        let widest = self.gas.lengths[0].max(self.gas.lengths[1]);
        self.is_disk_fluid()
            && self.gas.restitution < 1.0
            && self.case.bath().is_none()
            && widest > self.critical_length()
    }

    /// Computes the critical length of shear waves: the shortest that grow while the gas cools
    /// \[length\].
    pub fn critical_length(&self) -> f64 {
        transport::critical_length(
            self.gas.packing_fraction,
            self.gas.contact_value,
            self.gas.restitution,
        )
    }

    /// Returns true if the sets of simulators of an engine are copies of one start, moved and
    /// turned at random, as in a smooth uniform gas. In other gases each set is placed anew.
    pub fn starts_from_copies(&self) -> bool {
        self.is_uniform_box() && !self.is_rough() && self.case.start.region.is_none()
    }

    /// Returns true if the simulators of an engine start independently of each other, so that they
    /// can be made one after the other: particles do not exclude each other, none comes from a file
    /// or is a copy, and weights are uniform.
    pub(crate) fn has_independent_start(&self, engine: &EnginePlan) -> bool {
        engine.parameters().is_some()
            && !self.keeps_apart()
            && self.gas.file.is_none()
            && (engine.copies() == 1 || !self.starts_from_copies())
            && engine.weights.factors().is_empty()
    }

    /// Computes the mean free path of the uniform flow at the collision rate of a Monte Carlo
    /// scheme \[length\].
    pub fn flow_path(&self, scheme: Scheme) -> f64 {
        let densest = if self.gas.dimension == 2 { 0.6 } else { 0.5 };
        let packing = self.gas.packing_fraction.min(densest);
        let chi = if scheme.is_dilute() {
            1.0
        } else {
            in_space!(self.gas.dimension, S => S::contact_value(packing))
        };
        self.dilute_mean_free_path() / chi
    }

    /// Returns the cell side that resolves the mean free path of the uniform flow \[length\]: half
    /// of it, and at least two diameters for dense schemes.
    fn resolving_cell(&self, scheme: Scheme) -> f64 {
        let half = 0.5 * self.flow_path(scheme);
        if scheme.is_dilute() {
            half
        } else {
            let radii = self.gas.species.iter().map(|one| one.radius);
            half.max(4.0 * radii.fold(0.0, f64::max))
        }
    }

    /// Returns the number of simulators per particle in a flow with which a cell of a given side
    /// holds ten, of at most 2^20 in total.
    fn simulators_of_flow(&self, side: f64) -> u32 {
        let count = self.count().max(1) as f64;
        let per_cell = count * side.powi(self.gas.dimension as i32) / self.gas.volume;
        // A cell that holds ten but for rounding holds ten.
        let wanted = (TEN / per_cell * (1.0 - 1e-9)).ceil();
        wanted.clamp(1.0, (MOST_SIMULATORS / count).floor().max(1.0)) as u32
    }

    /// Returns the cell side in a flow \[length\]: one that resolves the mean free path, and is
    /// large enough to hold ten simulators.
    fn cell_of_flow(&self, scheme: Scheme, simulators_per_particle: u32) -> f64 {
        let simulators = self.count() as f64 * f64::from(simulators_per_particle);
        let ten = (TEN * self.gas.volume / simulators).powf(1.0 / self.gas.dimension as f64);
        self.resolving_cell(scheme).max(ten)
    }

    /// Returns the number of simulators per particle at which errors of few simulators are
    /// negligible: a power of two, at most 1000 and at most 2^20 in total. In flows the cells are
    /// chosen to hold enough.
    fn enough_simulators(&self, one: &Parameters) -> u32 {
        const MOST: f64 = 1024.0;
        const MOST_IN_ALL: f64 = (1 << 20) as f64;
        let each = self.simulators_per_cell(one) / f64::from(one.simulators_per_particle);
        let wanted = match one.scheme.partners() {
            _ if !self.is_uniform() => 1.0,
            PartnerSelection::ContactCell => ENOUGH_FOR_ESMC,
            PartnerSelection::WithinCell => ENOUGH_IN_A_CELL / each,
            _ => 1.0,
        };
        let most = (MOST_IN_ALL / self.count() as f64).clamp(1.0, MOST);
        let exponent = wanted.max(1.0).log2().ceil().min(most.log2().floor());
        2_u32.pow(exponent as u32)
    }

    /// Returns the sides of a Monte Carlo cell \[length\]; zero beyond the dimension.
    pub fn cell(&self, parameters: &Parameters) -> [f64; 3] {
        let diameter = 2.0 * self.mean_radius();
        let counts = in_space!(self.gas.dimension, S => cells::<S>(parameters, self, diameter));
        [0, 1, 2].map(|axis| self.gas.lengths[axis] / counts[axis] as f64)
    }

    /// Returns the mean number of simulators in a Monte Carlo cell.
    pub fn simulators_per_cell(&self, parameters: &Parameters) -> f64 {
        let cell: f64 = self.cell(parameters)[..self.gas.dimension].iter().product();
        let share = cell / self.gas.volume;
        share * self.count() as f64 * f64::from(parameters.simulators_per_particle)
    }

    /// Returns the radius around the point of contact within which partners are drawn \[length\].
    pub fn partner_radius(&self, parameters: &Parameters) -> f64 {
        let (packing, diameter) = (self.gas.packing_fraction, 2.0 * self.mean_radius());
        in_space!(self.gas.dimension, S => parameters.partner_radius::<S>(packing, diameter))
    }

    /// Computes the mean free path at the collision rate of a Monte Carlo scheme \[length\].
    pub fn scheme_path(&self, parameters: &Parameters) -> f64 {
        let (packing, diameter) = (self.gas.packing_fraction, 2.0 * self.mean_radius());
        in_space!(self.gas.dimension, S => parameters.mean_free_path::<S>(packing, diameter))
    }
}

fn cells<S: Space>(parameters: &Parameters, plan: &CasePlan, diameter: f64) -> [usize; 3] {
    let lengths = S::from_components(|axis| plan.gas.lengths[axis]);
    // The sides are positive, or the plan would not be.
    stosszahl_model::Domain::<S>::periodic(lengths).map_or([1; 3], |domain| {
        parameters.cells(&domain, plan.gas.packing_fraction, diameter)
    })
}
