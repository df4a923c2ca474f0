//! Pilot runs that choose simulators and time step of the Monte Carlo engines for a requested
//! accuracy (`[accuracy] target`).
//!
//! The pilot is a box of the gas that is too small for growing shear waves, run to `t_0`. Theory is
//! exact there: Haff's law with the relaxation of a2 for the energy of a cooling gas, Enskog's
//! collision rate for an elastic one. For each engine, simulators per disk are doubled until the
//! energy (or rate) is surely within the target. The number of time steps is then halved while this
//! holds. Runs have fixed seeds and a fixed order of work, so the choice does not depend on the
//! machine.
//!
//! The target bounds the error of the scheme against Enskog's theory. The difference to exact
//! disks, which violate molecular chaos, is not included.

use rayon::prelude::*;
use stosszahl_analysis::accuracy::{Known, SettingAccuracy};
use stosszahl_case::Case;
use stosszahl_case::format::{PlacementSpec, StartSpec};
use stosszahl_dsmc::Parameters;
use stosszahl_model::{Interrupt, Particles};
use stosszahl_results::format_percent;

use super::quantity::{
    FrontierQuantity, QuantityKind, measured, observe, quantities, uniform_theory,
};
use super::setting::SIMULATORS;
use crate::engine_run::PartError;
use crate::engine_run::in_memory::{InMemoryRun, measures, resized};
use crate::judge;
use crate::measure::Measure;
use crate::plan::{CasePlan, EngineKind, EnginePlan, PlanError};

/// Largest number of disks in the pilot runs that choose the Monte Carlo resolution.
const MOST_DISKS: usize = 400;
/// Smallest number of disks in the pilot runs that choose the Monte Carlo resolution.
const FEWEST_DISKS: usize = 24;
/// Side of the pilot's box over the shortest wavelength at which shear modes grow. Below 1 the gas
/// stays uniform.
const STABLE: f64 = 0.7;
/// Number of pilot runs for each candidate resolution.
const RUNS: u64 = 200;
/// First replica number of the pilot runs. No replica of a case has such a large number, so random
/// streams never coincide.
const FIRST: u64 = 1 << 34;
/// Duration of a pilot run of a cooling gas \[Haff times `t_0`\].
const COOLING: f64 = 1.0;
/// Duration of a pilot run of an elastic gas \[mean free times\].
const ELASTIC: f64 = 20.0;

/// Chooses the Monte Carlo resolution of one point by pilot runs on the threads of the current pool.
/// Returns the case with the chosen values, and the reasons as text.
///
/// # Errors
/// [`PartError`] if the pilot fails or is stopped.
pub(crate) fn choose_resolution(
    plan: &CasePlan,
    target: f64,
    stop: &Interrupt,
) -> Result<(Case, Vec<String>), PartError> {
    let small = CasePlan::new(&pilot_case(plan), &plan.folder)?;
    let search = PilotSearch::new(&small, target, stop)?;
    let (mut case, mut words) = (plan.case.clone(), Vec::new());
    for engine in &small.engines {
        let (Some(asked), Some(written)) = (
            engine.parameters(),
            case.engine.monte_carlo_mut(engine.name),
        ) else {
            continue;
        };
        let choice = search.choose(engine, *asked)?;
        written.simulators_per_particle =
            Some(u64::from(choice.parameters.simulators_per_particle));
        let steps = Some(choice.parameters.steps_per_cell_crossing);
        if choice.parameters.scheme.is_cross_cell() {
            written.steps_per_mean_free_time = steps;
        } else {
            written.steps_per_cell_crossing = steps;
        }
        words.push(choice.words(engine.name, &search));
    }
    Ok((case, words))
}

/// Returns the case of the pilot: a small uniform box of the gas, for one Haff time or 20 mean free
/// times.
fn pilot_case(plan: &CasePlan) -> Case {
    let density = plan.gas.packing_fraction / std::f64::consts::FRAC_PI_4;
    let side = STABLE * plan.critical_length();
    let stable = (density * side * side).min(MOST_DISKS as f64);
    let disks = (stable as usize).clamp(FEWEST_DISKS, plan.count().max(FEWEST_DISKS));
    let mut case = plan.case.clone();
    if case.start.placement == PlacementSpec::File {
        // A start file fixes the positions of all disks, not of fewer.
        case.start = StartSpec {
            equilibration: case.start.equilibration,
            longest_equilibration: case.start.longest_equilibration,
            ..StartSpec::default()
        };
        case.gas.number = Some(disks as u64);
    }
    let mut case = resized(&case, disks, plan.gas.packing_fraction);
    case.engine.ed = None;
    case.run.until = if plan.gas.law.is_elastic() {
        ELASTIC
    } else {
        COOLING
    };
    case.run.time_unit = None;
    measured(&case)
}

/// Candidate resolution of a Monte Carlo engine, with the accuracy that its pilot runs found.
struct Candidate {
    parameters: Parameters,
    found: SettingAccuracy,
    met: bool,
}

impl Candidate {
    fn words(&self, engine: &str, search: &PilotSearch<'_>) -> String {
        let what = match search.quantity.kind {
            QuantityKind::CollisionRate => "the collision rate over Enskog's",
            _ => "K at t0 over Haff's law",
        };
        let target = format_percent(search.target);
        let reason = if self.met {
            format!("sure to be within {target} and the cheapest that is")
        } else {
            format!(
                "no resolution that was tried is sure to keep {target}, and this one errs least"
            )
        };
        let plural = |count: f64, noun: &str| {
            let ending = if count == 1.0 { "" } else { "s" };
            format!("{count} {noun}{ending}")
        };
        format!(
            "{engine}: {} per particle and {}, because a pilot of {} disks and {RUNS} runs found an error of {} in {what}; {reason}",
            plural(
                f64::from(self.parameters.simulators_per_particle),
                "simulator"
            ),
            plural(self.parameters.steps_per_cell_crossing, "step"),
            search.plan.count(),
            judge::format_deviation(self.found.systematic, Some(self.found.systematic_error)),
        )
    }
}

/// Search for the cheapest resolution of one Monte Carlo engine whose error is within the target.
struct PilotSearch<'a> {
    plan: &'a CasePlan,
    measures: Vec<&'static dyn Measure>,
    stop: &'a Interrupt,
    starts: Vec<Particles>,
    /// Quantity at the end of the pilot whose error is to be within the target.
    quantity: FrontierQuantity,
    known: Known,
    target: f64,
}

impl<'a> PilotSearch<'a> {
    fn new(plan: &'a CasePlan, target: f64, stop: &'a Interrupt) -> Result<Self, PartError> {
        let kind = if plan.gas.law.is_elastic() {
            QuantityKind::CollisionRate
        } else {
            QuantityKind::Energy
        };
        let time = plan.case.run.until;
        let quantity = FrontierQuantity { kind, time };
        let known = uniform_theory(plan, quantity).ok_or_else(|| {
            let found = "a gas whose cooling has no theory";
            PlanError::new("accuracy.target", found, "equal smooth disks")
        })?;
        let mut search = Self {
            plan,
            // The structure factor would be computed for nothing.
            measures: measures(&["energy", "impact_parameters"]),
            stop,
            starts: Vec::new(),
            quantity,
            known,
            target,
        };
        let starts = (FIRST..FIRST + RUNS).into_par_iter();
        search.starts = starts
            .map(|replica| search.run(replica).make_start())
            .collect::<Result<_, _>>()?;
        Ok(search)
    }

    fn run(&self, replica: u64) -> InMemoryRun<'_> {
        InMemoryRun {
            plan: self.plan,
            measures: &self.measures,
            replica,
            stop: self.stop,
        }
    }

    fn measure(&self, engine: &EnginePlan, parameters: Parameters) -> Result<Candidate, PartError> {
        let engine = EnginePlan {
            kind: EngineKind::MonteCarlo(parameters),
            ..engine.clone()
        };
        let place = quantities(self.plan)
            .iter()
            .position(|one| *one == self.quantity);
        let value = |(index, start): (usize, &Particles)| {
            let done = self.run(FIRST + index as u64).run_engine(&engine, start)?;
            let values = observe(self.plan, &engine, &done, true);
            Ok::<_, PartError>(
                place
                    .and_then(|place| values.get(place).copied())
                    .unwrap_or(f64::NAN),
            )
        };
        let values = self.starts.par_iter().enumerate().map(value);
        let values: Vec<f64> = values.collect::<Result<_, _>>()?;
        let failed = "a pilot whose values are no numbers";
        let unit = self.quantity.kind.unit(self.known.value);
        let found = SettingAccuracy::new(&values, self.known, unit)
            .ok_or_else(|| PlanError::new("accuracy.target", failed, "numbers"))?;
        Ok(Candidate {
            parameters,
            found,
            // The whole upper limit of the bias counts, at 99 %.
            met: found.assured(u64::MAX) <= self.target,
        })
    }

    fn choose(&self, engine: &EnginePlan, asked: Parameters) -> Result<Candidate, PartError> {
        let mut best: Option<Candidate> = None;
        for simulators_per_particle in SIMULATORS {
            let parameters = Parameters {
                simulators_per_particle,
                ..asked
            };
            let choice = self.measure(engine, parameters)?;
            if choice.met {
                return self.fewer_steps(engine, choice);
            }
            let size = |choice: &Candidate| choice.found.systematic.abs();
            if (best.as_ref()).is_none_or(|known| size(&choice) < size(known)) {
                best = Some(choice);
            }
        }
        best.map_or_else(|| self.measure(engine, asked), Ok)
    }

    /// Halves the number of time steps per cell crossing as long as the error stays within the
    /// target.
    fn fewer_steps(
        &self,
        engine: &EnginePlan,
        mut choice: Candidate,
    ) -> Result<Candidate, PartError> {
        while choice.parameters.steps_per_cell_crossing >= 2.0 {
            let steps_per_cell_crossing = 0.5 * choice.parameters.steps_per_cell_crossing;
            let parameters = Parameters {
                steps_per_cell_crossing,
                ..choice.parameters
            };
            let coarser = self.measure(engine, parameters)?;
            if !coarser.met {
                break;
            }
            choice = coarser;
        }
        Ok(choice)
    }
}
