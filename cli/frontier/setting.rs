//! The settings of a sweep: what buys accuracy, varied around a case one choice at a time.
//!
//! Replicas are not varied: n of them lower the noise by √n and leave the bias, so their error follows from that of one
//! (see [`stosszahl_analysis::accuracy`]).

use crate::case::{Bodies, Displacement, Dsmc, Engine, EventDriven, Neighbourhood, Scheme};
use crate::case::{Case, Copies};
use crate::setup::Setup;

/// One step of a sequence of settings whose error theory says to fall as a power of h.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Refinement {
    /// What is refined, and of what.
    pub(crate) sequence: &'static str,
    /// The small quantity.
    pub(crate) h: f64,
    /// The power.
    pub(crate) order: f64,
}

/// Numerical choices of one run.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Setting {
    /// The engine with its choices.
    pub(crate) engine: Engine,
    /// Number of disks; the box is as large as the packing fraction says.
    pub(crate) disks: usize,
    /// The sequences that it belongs to.
    pub(crate) refinements: Vec<Refinement>,
}

/// Fewest disks of a smaller system.
const FEWEST: usize = 64;

impl Setting {
    /// Its engine as tables name it.
    pub(crate) fn engine_name(&self) -> &'static str {
        self.engine.name()
    }

    /// Whether it is exact dynamics.
    pub(crate) fn is_exact(&self) -> bool {
        matches!(self.engine, Engine::Ed(_))
    }

    /// The choices in words; `disks` are those of the case.
    pub(crate) fn label(&self, disks: usize) -> String {
        let mut parts = Vec::new();
        match &self.engine {
            Engine::Ed(ed) => {
                parts.push("ed".to_owned());
                if ed.contact_time > 0.0 {
                    parts.push(format!("contact time {} t0", ed.contact_time));
                }
            }
            Engine::Dsmc(dsmc) => {
                let name = dsmc.scheme.name();
                parts.push(name.strip_prefix("dsmc-").unwrap_or(name).to_owned());
                parts.extend(scheme_choices(&dsmc.scheme));
                if let Some(copies) = dsmc.simulators_per_disk {
                    parts.push(format!("{copies} per disk"));
                }
                if let Some(size) = dsmc.cell_size {
                    parts.push(format!("cell {size} d"));
                }
                parts.push(format!("{} steps", dsmc.steps_per_crossing));
            }
        }
        if self.disks != disks {
            parts.push(format!("{} disks", self.disks));
        }
        parts.join(", ")
    }

    /// Rough seconds of one run with its start, from counts of work alone: the plan must not depend on a clock.
    pub(crate) fn nominal_seconds(&self, setup: &Setup) -> f64 {
        /// Seconds for a pair collision of exact dynamics, and to place a disk.
        const EXACT: f64 = 6e-7;
        const PLACED: f64 = 1e-5;
        /// Seconds for a simulator and step: flight and sorting alone, with collisions within cells, with partners from the
        /// cell of the point of contact, with pairs that overlap.
        const FLIGHT: f64 = 5e-8;
        const WITHIN: f64 = 2.5e-8;
        const ESMC: f64 = 4e-7;
        const OVERLAP: f64 = 2.5e-7;
        /// Seconds for a pair collision with a partner around the point of contact.
        const AROUND: f64 = 3e-6;
        let disks = self.disks as f64;
        let collisions = 0.5 * disks * setup.expected_collisions(setup.case.run.until);
        let start = 0.5 * disks * setup.case.start.collisions_per_particle;
        let run = match &self.engine {
            Engine::Ed(_) => EXACT * collisions,
            Engine::Dsmc(dsmc) => {
                let steps = setup.expected_steps(dsmc) * disks * setup.copies(dsmc);
                match dsmc.scheme {
                    Scheme::Boltzmann { .. }
                    | Scheme::FreeVolume { .. }
                    | Scheme::Enskog { .. } => WITHIN * steps,
                    Scheme::Esmc { .. } => ESMC * steps,
                    Scheme::StochasticDisks { .. } => OVERLAP * steps,
                    Scheme::ContactPoint { .. } => {
                        FLIGHT * steps + AROUND * collisions * setup.copies(dsmc)
                    }
                }
            }
        };
        run + EXACT * start.max(2e4) + PLACED * disks
    }
}

/// Choices of a scheme that are not its default.
fn scheme_choices(scheme: &Scheme) -> Vec<String> {
    let displaced = |displacement: &Displacement| match displacement {
        Displacement::None => "not displaced".to_owned(),
        Displacement::Diameter => "displaced".to_owned(),
        Displacement::Inelastic => "displaced inelastically".to_owned(),
    };
    let around = |neighbourhood: &Neighbourhood| match neighbourhood {
        Neighbourhood::Mean => Some("mean density".to_owned()),
        Neighbourhood::Cells(_) => None,
    };
    match scheme {
        Scheme::Boltzmann { displacement } | Scheme::FreeVolume { displacement, .. } => {
            vec![displaced(displacement)]
        }
        Scheme::Enskog {
            displacement,
            neighbourhood,
            ..
        } => around(neighbourhood)
            .into_iter()
            .chain([displaced(displacement)])
            .collect(),
        Scheme::Esmc { neighbourhood, .. } => around(neighbourhood).into_iter().collect(),
        Scheme::StochasticDisks { stiffness } => vec![format!("stiffness {stiffness}")],
        Scheme::ContactPoint {
            partner_radius,
            copies,
            ..
        } => {
            let radius = partner_radius.map(|radius| format!("radius {radius} d"));
            let copies = copies.map(|copies| match copies {
                Copies::Independent => "independent copies".to_owned(),
                Copies::Coherent => "coherent copies".to_owned(),
            });
            radius.into_iter().chain(copies).collect()
        }
    }
}

/// Settings without repetition: one that comes again only gets one more refinement.
#[derive(Default)]
struct List(Vec<Setting>);

impl List {
    fn add(&mut self, engine: Engine, disks: usize, refinement: Option<Refinement>) {
        let known = self
            .0
            .iter_mut()
            .find(|known| known.engine == engine && known.disks == disks);
        match known {
            Some(known) => known.refinements.extend(refinement),
            None => self.0.push(Setting {
                engine,
                disks,
                refinements: refinement.into_iter().collect(),
            }),
        }
    }

    /// Adds a sequence of Monte Carlo settings, with h and the choice that it stands for.
    fn sequence(
        &mut self,
        sequence: &'static str,
        order: f64,
        disks: usize,
        steps: impl IntoIterator<Item = (f64, Dsmc)>,
    ) {
        for (h, dsmc) in steps {
            let refinement = Refinement { sequence, h, order };
            self.add(Engine::Dsmc(dsmc), disks, Some(refinement));
        }
    }
}

/// Exact dynamics as the case wants it: without the contact time of the TC model, which is an approximation.
pub(crate) const EXACT: Engine = Engine::Ed(EventDriven {
    contact_time: 0.0,
    collision_limit: None,
});

/// A Monte Carlo engine with the choices that sweeps begin from.
fn dsmc(scheme: Scheme, simulators_per_disk: u32, cell_size: Option<f64>, steps: f64) -> Dsmc {
    Dsmc {
        scheme,
        cell_size,
        simulators_per_disk: Some(simulators_per_disk),
        steps_per_crossing: steps,
    }
}

/// All settings around a case: its own engines first, then exact dynamics, then each Monte Carlo scheme.
pub(crate) fn around(setup: &Setup) -> Vec<Setting> {
    let mut list = List::default();
    for engine in &setup.case.engines {
        list.add(engine.clone(), setup.disks, None);
    }
    exact(&mut list, setup);
    contact_point(&mut list, setup);
    within_cells(&mut list, setup);
    across(&mut list, setup);
    list.0
}

/// Smaller systems of the same density; none of a start that comes from a file.
fn smaller(setup: &Setup) -> impl Iterator<Item = usize> + use<> {
    let (disks, placed) = (setup.disks, setup.file.is_none());
    [4, 16]
        .into_iter()
        .map(move |part| disks / part)
        .filter(move |&few| placed && few >= FEWEST)
}

/// System size, and the contact time of the TC model, whose error is of first order (2 ω `t_c` of the collisions do not
/// dissipate).
fn exact(list: &mut List, setup: &Setup) {
    list.add(EXACT, setup.disks, None);
    for disks in smaller(setup) {
        list.add(EXACT, disks, None);
    }
    for contact_time in [1e-4, 1e-3, 1e-2, 1e-1] {
        let refinement = Refinement {
            sequence: "contact time of ed",
            h: contact_time,
            order: 1.0,
        };
        let engine = Engine::Ed(EventDriven {
            contact_time,
            collision_limit: None,
        });
        list.add(engine, setup.disks, Some(refinement));
    }
}

/// Simulators for each disk, step, partner radius, copies and size of the scheme with partners around the point of contact.
fn contact_point(list: &mut List, setup: &Setup) {
    let scheme = |partner_radius, copies| Scheme::ContactPoint {
        partner_radius,
        copies,
        largest: 100.0,
    };
    let plain = |copies| dsmc(scheme(None, None), copies, None, 8.0);
    let simulators =
        [1, 2, 4, 8, 16, 32, 64].map(|copies| (f64::from(copies).recip(), plain(copies)));
    list.sequence("simulators of contact-point", 1.0, setup.disks, simulators);
    let steps = [1.0, 2.0, 4.0, 8.0, 16.0].map(|steps: f64| {
        let dsmc = dsmc(scheme(None, None), 4, None, steps);
        (steps.recip(), dsmc)
    });
    list.sequence("step of contact-point", 2.0, setup.disks, steps);
    let radii = [0.0, 0.25, 1.0, 1.5, 2.0]
        .map(|radius| (radius, dsmc(scheme(Some(radius), None), 4, None, 8.0)));
    list.sequence("radius of contact-point", 2.0, setup.disks, radii);
    for copies in [4, 16] {
        let independent = dsmc(scheme(None, Some(Copies::Independent)), copies, None, 8.0);
        list.add(Engine::Dsmc(independent), setup.disks, None);
    }
    for disks in smaller(setup) {
        list.add(Engine::Dsmc(plain(4)), disks, None);
    }
}

/// Simulators, cells and steps of the schemes within cells.
fn within_cells(list: &mut List, setup: &Setup) {
    /// Limit on the contact value.
    const LARGEST: f64 = 10.0;
    let path =
        stosszahl_model::kinetic::mean_free_path(setup.packing_fraction, setup.contact_value);
    // Rounded, for labels that can be read.
    let cell = (0.5 * path).max(2.0).round();
    let enskog = |displacement, neighbourhood| Scheme::Enskog {
        displacement,
        neighbourhood,
        largest: LARGEST,
    };
    let displaced = enskog(Displacement::Diameter, Neighbourhood::Cells(2));
    let plain = enskog(Displacement::None, Neighbourhood::Mean);
    let disks = setup.disks;
    let many = [1, 4, 16, 64];
    let simulators = |scheme, counts: &[u32]| -> Vec<(f64, Dsmc)> {
        let one = |&copies: &u32| {
            (
                f64::from(copies).recip(),
                dsmc(scheme, copies, Some(cell), 4.0),
            )
        };
        counts.iter().map(one).collect()
    };
    list.sequence(
        "simulators of displaced enskog",
        1.0,
        disks,
        simulators(displaced, &many),
    );
    list.sequence("simulators of enskog", 1.0, disks, simulators(plain, &many));
    let cells = [0.5, 1.0, 2.0, 4.0].map(|factor| {
        let size = factor * cell;
        (size, dsmc(plain, 16, Some(size), 4.0))
    });
    list.sequence("cell of enskog", 2.0, disks, cells);
    let steps =
        [1.0, 2.0, 4.0, 8.0].map(|steps: f64| (steps.recip(), dsmc(plain, 16, Some(cell), steps)));
    list.sequence("step of enskog", 2.0, disks, steps);
    let free = Scheme::FreeVolume {
        displacement: Displacement::Diameter,
        largest: LARGEST,
    };
    list.sequence(
        "simulators of free-volume",
        1.0,
        disks,
        simulators(free, &many[..3]),
    );
    let boltzmann = Scheme::Boltzmann {
        displacement: Displacement::None,
    };
    list.add(
        Engine::Dsmc(dsmc(boltzmann, 4, Some(cell), 4.0)),
        disks,
        None,
    );
}

/// The two other schemes with partners across cells.
fn across(list: &mut List, setup: &Setup) {
    let esmc = Scheme::Esmc {
        neighbourhood: Neighbourhood::Cells(2),
        largest: 10.0,
    };
    let simulators = [4, 16].map(|copies| {
        (
            f64::from(copies).recip(),
            dsmc(esmc, copies, Some(1.0), 8.0),
        )
    });
    list.sequence("simulators of esmc", 1.0, setup.disks, simulators);
    for (stiffness, steps) in [(1.0, 20.0), (4.0, 40.0)] {
        let scheme = Scheme::StochasticDisks { stiffness };
        list.add(
            Engine::Dsmc(dsmc(scheme, 1, None, steps)),
            setup.disks,
            None,
        );
    }
}

/// The case with so many disks.
pub(crate) fn resized(case: &Case, count: usize) -> Case {
    let mut case = case.clone();
    match &mut case.start.bodies {
        Bodies::Disordered { disks, .. }
        | Bodies::Square { disks, .. }
        | Bodies::Hexagonal { disks, .. } => *disks = count,
        Bodies::File(_) => {}
    }
    case
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::case::CaseFile;

    fn setup(disks: usize) -> Setup {
        let text = format!(
            "format = 1\ntitle = \"t\"\n[gas]\ndisks = {disks}\npacking_fraction = 0.25\nrestitution = 0.8\n\
             [run]\nuntil = 10\n[engine.ed]\n[engine.dsmc-free-volume]\ncell_size = 2.0\n"
        );
        let file = CaseFile::from_text(Path::new("t.toml"), &text, &[]).expect("a case");
        Setup::new(&file.points[0].case).expect("a setup")
    }

    #[test]
    fn settings_are_many_and_no_two_alike() {
        let settings = around(&setup(10_000));
        assert!(settings.len() >= 40, "{}", settings.len());
        let mut labels: Vec<_> = settings.iter().map(|s| s.label(10_000)).collect();
        labels.sort();
        labels.dedup();
        assert_eq!(labels.len(), settings.len());
    }

    #[test]
    fn sequences_can_be_fitted() {
        let settings = around(&setup(10_000));
        let mut count = std::collections::BTreeMap::new();
        for refinement in settings.iter().flat_map(|s| &s.refinements) {
            *count.entry(refinement.sequence).or_insert(0) += 1;
        }
        assert!(count.len() >= 8);
        // Two settings give no order, but the sweep of esmc is too costly for more.
        assert!(
            count
                .iter()
                .all(|(name, &n)| n >= 3 || name.ends_with("esmc")),
            "{count:?}"
        );
    }

    /// The rough seconds rise with simulators, steps and disks.
    #[test]
    fn nominal_cost_rises_with_work() {
        let setup = setup(10_000);
        let cost = |engine| {
            let setting = Setting {
                engine,
                disks: 10_000,
                refinements: Vec::new(),
            };
            setting.nominal_seconds(&setup)
        };
        let scheme = Scheme::ContactPoint {
            partner_radius: None,
            copies: None,
            largest: 100.0,
        };
        let at = |copies, steps| cost(Engine::Dsmc(dsmc(scheme, copies, None, steps)));
        assert!(cost(EXACT) < at(1, 8.0));
        assert!(at(1, 8.0) < at(2, 8.0) && at(2, 8.0) < at(2, 16.0));
    }
}
