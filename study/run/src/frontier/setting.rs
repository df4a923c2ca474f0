//! Settings of a frontier: numerical parameters of the engines, varied one at a time around a case.
//!
//! Replicas are not varied: n of them lower the noise by √n and leave the bias, so their error
//! follows from that of one (see [`stosszahl_analysis::accuracy`]).

use stosszahl_case::format::{SCHEMES, SchemeFormat};
use stosszahl_dsmc::{
    Neighbourhood, Parameters, PartnerDisplacement, Scheme, SimulatorStart, SimulatorWeights,
    WallClearance,
};
use stosszahl_model::equation_of_state;
use stosszahl_results::engine_title;

use crate::plan::{CasePlan, EngineKind, EnginePlan};

/// Place of a setting in a sequence whose error falls, by theory, as a power of a parameter h.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Refinement {
    /// Name of the sequence: the refined parameter, and the scheme.
    pub sequence: &'static str,
    /// Refined parameter h of the setting, with which the error vanishes.
    pub h: f64,
    /// Order of convergence: power of h by which the error vanishes, by theory.
    pub order: f64,
}

/// Numerical setting of a run: engine, its parameters and system size.
#[derive(Clone, Debug)]
pub(crate) struct RunSetting {
    /// Engine with its numerical parameters.
    pub engine: EnginePlan,
    /// Number of disks; the box follows from the packing fraction.
    pub disks: usize,
    /// Sequences of refinement that the setting belongs to.
    pub refinements: Vec<Refinement>,
}

/// Numbers of simulators per disk of the settings, from coarse to fine.
pub(super) const SIMULATORS: [u32; 7] = [1, 2, 4, 8, 16, 32, 64];
/// Smallest number of disks of a smaller system.
const FEWEST: usize = 64;

/// Creates the plan of an engine in a periodic box.
pub(super) fn engine(kind: EngineKind) -> EnginePlan {
    let name = match &kind {
        EngineKind::EventDriven { .. } => "ed",
        EngineKind::Homogeneous(_) => "dsmc-homogeneous",
        EngineKind::MonteCarlo(parameters) => {
            let name = parameters.scheme.name();
            let of_scheme =
                |format: &&SchemeFormat| format.engine.strip_prefix("dsmc-") == Some(name);
            let format = SCHEMES.iter().find(of_scheme).unwrap_or(&SCHEMES[0]);
            format.engine
        }
    };
    EnginePlan {
        name,
        kind,
        clearance: WallClearance::Radius,
        weights: SimulatorWeights::uniform(),
    }
}

fn event_driven(contact_time: f64) -> EngineKind {
    EngineKind::EventDriven {
        contact_time,
        collision_limit: None,
        collision_rate_limit: None,
    }
}

impl RunSetting {
    /// Creates the setting of exact dynamics without the contact time of the TC model, which is an
    /// approximation.
    pub(crate) fn exact(disks: usize) -> Self {
        Self {
            engine: engine(event_driven(0.0)),
            disks,
            refinements: Vec::new(),
        }
    }

    /// Returns true if the setting's engine is event-driven.
    pub(crate) fn is_event_driven(&self) -> bool {
        matches!(self.engine.kind, EngineKind::EventDriven { .. })
    }

    /// Returns true if the setting is exact dynamics of a gas with the full number of disks of the
    /// case.
    pub(crate) fn is_reference(&self, disks: usize) -> bool {
        self.engine.kind == event_driven(0.0) && self.disks == disks
    }

    /// Describes the parameters of the setting in words.
    pub(crate) fn label(&self, plan: &CasePlan) -> String {
        let mut parts = Vec::new();
        match &self.engine.kind {
            EngineKind::EventDriven { contact_time, .. } => {
                parts.push(engine_title(self.engine.name).to_owned());
                if *contact_time > 0.0 {
                    // Twelve digits, for units of time are no round numbers.
                    let time = format!("{:.11e}", contact_time / plan.clock.time);
                    let time: f64 = time.parse().unwrap_or(*contact_time);
                    parts.push(format!("contact time {time} t0"));
                }
            }
            EngineKind::MonteCarlo(parameters) => {
                parts.push(engine_title(self.engine.name).to_owned());
                parts.extend(scheme_choices(parameters, plan, self.disks));
                parts.push(format!("{} per disk", parameters.simulators_per_particle));
                if let Some(size) = parameters.cell_size {
                    parts.push(format!("cell {size} d"));
                }
                parts.push(format!("{} steps", parameters.steps_per_cell_crossing));
            }
            EngineKind::Homogeneous(_) => parts.push(engine_title(self.engine.name).to_owned()),
        }
        if self.disks != plan.count() {
            parts.push(format!("{} disks", self.disks));
        }
        parts.join(", ")
    }

    /// Estimates the computing time of one run with its start \[s\] at nominal speeds, since the
    /// division of a budget must not depend on a clock.
    pub(crate) fn nominal_seconds(&self, plan: &CasePlan) -> f64 {
        let share = self.disks as f64 / plan.count() as f64;
        share * (plan.seconds(&self.engine) + plan.start_seconds())
    }
}

/// Describes the parameters of a scheme that differ from its defaults.
fn scheme_choices(parameters: &Parameters, plan: &CasePlan, disks: usize) -> Vec<String> {
    let displaced = match parameters.displacement {
        PartnerDisplacement::None => "not displaced",
        PartnerDisplacement::Diameter => "displaced",
        PartnerDisplacement::Inelastic => "displaced inelastically",
    };
    let mean = |around| (around == Neighbourhood::Mean).then_some("mean density".to_owned());
    let displaced = Some(displaced.to_owned());
    let words = match parameters.scheme {
        Scheme::Collisionless => [Some("no collisions".to_owned()), None],
        Scheme::Boltzmann | Scheme::FreeVolume => [displaced, None],
        Scheme::Enskog(around) => [mean(around), displaced],
        Scheme::Esmc(around) => [mean(around), None],
        Scheme::StochasticDisks { stiffness } => [Some(format!("stiffness {stiffness}")), None],
        Scheme::ContactPoint { radius } => {
            let copies = (parameters.copies != copies(plan, disks)).then(|| {
                let word = match parameters.copies {
                    SimulatorStart::Independent => "independent copies",
                    SimulatorStart::Coherent => "coherent copies",
                };
                word.to_owned()
            });
            [radius.map(|radius| format!("radius {radius} d")), copies]
        }
    };
    words.into_iter().flatten().collect()
}

/// Returns the default start of several sets of simulators: coherent, with the long density waves
/// of the start, if such waves grow.
fn copies(plan: &CasePlan, disks: usize) -> SimulatorStart {
    let widest = plan.gas.lengths[0].max(plan.gas.lengths[1]);
    let width = widest * (disks as f64 / plan.count() as f64).sqrt();
    let cools = plan.gas.restitution < 1.0 && plan.case.bath().is_none();
    if cools && width > plan.critical_length() {
        SimulatorStart::Coherent
    } else {
        SimulatorStart::Independent
    }
}

/// List of settings without duplicates; a repeated setting only gets one more refinement.
struct List<'a> {
    plan: &'a CasePlan,
    all: Vec<RunSetting>,
}

impl List<'_> {
    fn add(&mut self, kind: EngineKind, disks: usize, refinement: Option<Refinement>) {
        let mut known = self.all.iter_mut();
        let known = known.find(|known| known.engine.kind == kind && known.disks == disks);
        match known {
            Some(known) => known.refinements.extend(refinement),
            None => self.all.push(RunSetting {
                engine: engine(kind),
                disks,
                refinements: refinement.into_iter().collect(),
            }),
        }
    }

    /// Adds a sequence of Monte Carlo settings to the list; `steps` yields the parameter h and the
    /// settings' parameters.
    fn sequence(
        &mut self,
        sequence: &'static str,
        order: f64,
        steps: impl IntoIterator<Item = (f64, Parameters)>,
    ) {
        for (h, parameters) in steps {
            let refinement = Refinement { sequence, h, order };
            let kind = EngineKind::MonteCarlo(parameters);
            self.add(kind, self.plan.count(), Some(refinement));
        }
    }

    /// Adds a Monte Carlo setting to the list.
    fn one(&mut self, parameters: Parameters) {
        self.add(EngineKind::MonteCarlo(parameters), self.plan.count(), None);
    }
}

/// Returns the parameters of a Monte Carlo scheme from which sequences of settings begin.
fn dsmc(scheme: Scheme, simulators: u32, cell_size: Option<f64>, steps: f64) -> Parameters {
    Parameters {
        cell_size,
        simulators_per_particle: simulators,
        steps_per_cell_crossing: steps,
        displacement: PartnerDisplacement::None,
        max_contact_value: 10.0,
        ..Parameters::for_scheme(scheme)
    }
}

/// Returns all settings around a case: the case's own engines first, then exact dynamics, then each
/// Monte Carlo scheme.
pub(crate) fn settings_around(plan: &CasePlan) -> Vec<RunSetting> {
    let mut list = List {
        plan,
        all: Vec::new(),
    };
    for engine in &plan.engines {
        let kind = match &engine.kind {
            EngineKind::EventDriven { contact_time, .. } => event_driven(*contact_time),
            other => other.clone(),
        };
        list.add(kind, plan.count(), None);
    }
    exact(&mut list);
    contact_point(&mut list);
    within_cells(&mut list);
    cross_cell_settings(&mut list);
    list.all
}

/// Returns the numbers of disks of smaller systems at equal density; none if the start comes from a
/// file or the gas has several species.
fn smaller_systems(plan: &CasePlan) -> impl Iterator<Item = usize> + use<> {
    let (disks, placed) = (
        plan.count(),
        plan.gas.file.is_none() && plan.gas.species.len() == 1,
    );
    [4, 16]
        .into_iter()
        .map(move |part| disks / part)
        .filter(move |&few| placed && few >= FEWEST)
}

/// Adds settings of exact dynamics: system sizes, and contact times of the TC model, whose error is
/// of first order (2 ω `t_c` of the collisions do not dissipate).
fn exact(list: &mut List<'_>) {
    let plan = list.plan;
    list.add(event_driven(0.0), plan.count(), None);
    for disks in smaller_systems(plan) {
        list.add(event_driven(0.0), disks, None);
    }
    for h in [1e-4, 1e-3, 1e-2, 1e-1] {
        let refinement = Refinement {
            sequence: "contact time of ed",
            h,
            order: 1.0,
        };
        list.add(
            event_driven(h * plan.clock.time),
            plan.count(),
            Some(refinement),
        );
    }
}

/// Adds settings of the contact-point scheme: simulators per disk, time step, partner radius, start
/// of simulators, and system size.
fn contact_point(list: &mut List<'_>) {
    let plan = list.plan;
    let point = |radius, simulators, steps, disks| Parameters {
        copies: copies(plan, disks),
        max_contact_value: 100.0,
        ..dsmc(Scheme::ContactPoint { radius }, simulators, None, steps)
    };
    let disks = plan.count();
    let simulators = SIMULATORS.map(|copies| {
        let h = f64::from(copies).recip();
        (h, point(None, copies, 8.0, disks))
    });
    list.sequence("simulators of contact-point", 1.0, simulators);
    let steps =
        [1.0, 2.0, 4.0, 8.0, 16.0].map(|steps: f64| (steps.recip(), point(None, 4, steps, disks)));
    list.sequence("step of contact-point", 2.0, steps);
    let radii =
        [0.0, 0.25, 1.0, 1.5, 2.0].map(|radius| (radius, point(Some(radius), 4, 8.0, disks)));
    list.sequence("radius of contact-point", 2.0, radii);
    for simulators in [4, 16] {
        list.one(Parameters {
            copies: SimulatorStart::Independent,
            ..point(None, simulators, 8.0, disks)
        });
    }
    for disks in smaller_systems(plan) {
        let kind = EngineKind::MonteCarlo(point(None, 4, 8.0, disks));
        list.add(kind, disks, None);
    }
}

/// Adds settings of Monte Carlo schemes with partners in the same cell: by number of simulators,
/// cell size and number of steps.
fn within_cells(list: &mut List<'_>) {
    let plan = list.plan;
    let path = equation_of_state::mean_free_path(plan.gas.packing_fraction, plan.gas.contact_value);
    // Rounded, for labels that can be read.
    let cell = (0.5 * path).max(2.0).round();
    let plain = |simulators, cell, steps| {
        dsmc(
            Scheme::Enskog(Neighbourhood::Mean),
            simulators,
            Some(cell),
            steps,
        )
    };
    let displaced = |scheme, simulators| Parameters {
        displacement: PartnerDisplacement::Diameter,
        ..dsmc(scheme, simulators, Some(cell), 4.0)
    };
    let over = |simulators: u32| f64::from(simulators).recip();
    let many = [1, 4, 16, 64];
    let enskog = Scheme::Enskog(Neighbourhood::Cells(2));
    let steps = many.map(|n| (over(n), displaced(enskog, n)));
    list.sequence("simulators of displaced enskog", 1.0, steps);
    list.sequence(
        "simulators of enskog",
        1.0,
        many.map(|n| (over(n), plain(n, cell, 4.0))),
    );
    let cells = [0.5, 1.0, 2.0, 4.0].map(|factor| {
        let size = factor * cell;
        (size, plain(16, size, 4.0))
    });
    list.sequence("cell of enskog", 2.0, cells);
    let steps = [1.0, 2.0, 4.0, 8.0].map(|steps: f64| (steps.recip(), plain(16, cell, steps)));
    list.sequence("step of enskog", 2.0, steps);
    let free = [1, 4, 16].map(|n| (over(n), displaced(Scheme::FreeVolume, n)));
    list.sequence("simulators of free-volume", 1.0, free);
    list.one(dsmc(Scheme::Boltzmann, 4, Some(cell), 4.0));
}

/// Adds settings of the Monte Carlo schemes with partners across cells, other than the
/// contact-point scheme.
fn cross_cell_settings(list: &mut List<'_>) {
    let esmc = Scheme::Esmc(Neighbourhood::Cells(2));
    let simulators = [4, 16].map(|copies| {
        let h = f64::from(copies).recip();
        (h, dsmc(esmc, copies, Some(1.0), 8.0))
    });
    list.sequence("simulators of esmc", 1.0, simulators);
    for (stiffness, steps) in [(1.0, 20.0), (4.0, 40.0)] {
        list.one(dsmc(Scheme::StochasticDisks { stiffness }, 1, None, steps));
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;
    use std::path::Path;

    use stosszahl_case::CaseFile;

    use super::*;

    fn plan(disks: usize) -> CasePlan {
        let text = format!(
            "format = 2\ntitle = \"t\"\n[gas]\nnumber = {disks}\nrestitution = 0.8\n[box]\npacking_fraction = 0.25\n\
             [run]\nuntil = 10\n[engine.ed]\n[engine.dsmc-free-volume]\ncell_size = 2.0\n"
        );
        let file = CaseFile::from_text(Path::new("t.toml"), &text, &[]).expect("a case");
        CasePlan::new(&file.points[0].case, Path::new("")).expect("a plan")
    }

    #[test]
    fn settings_are_many_no_two_alike_and_sequences_can_be_fitted() {
        let plan = plan(10_000);
        let settings = settings_around(&plan);
        assert!(settings.len() >= 40, "{}", settings.len());
        let mut labels: Vec<_> = settings.iter().map(|s| s.label(&plan)).collect();
        labels.sort();
        labels.dedup();
        assert_eq!(labels.len(), settings.len());
        assert!(
            labels.contains(&"ED (exact), contact time 0.001 t0".to_owned()),
            "{labels:?}"
        );
        let mut count = BTreeMap::new();
        for refinement in settings.iter().flat_map(|s| &s.refinements) {
            *count.entry(refinement.sequence).or_insert(0) += 1;
        }
        assert!(count.len() >= 8);
        // Two settings give no order, but the sweep of esmc is too costly for more.
        let enough = |(name, &n): (&&str, &i32)| n >= 3 || name.ends_with("esmc");
        assert!(count.iter().all(enough), "{count:?}");
    }
}
