//! Choice of simulators and time step of the Monte Carlo engines for a requested accuracy, by short
//! pilot runs (`[accuracy] target`).
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
use stosszahl_case::format::{self, PlacementSpec, StartSpec};
use stosszahl_case::{Case, CaseFile};
use stosszahl_dsmc::Parameters;
use stosszahl_model::{Interrupt, Particles, transport};
use stosszahl_results::format_percent;

use crate::check::Planned;
use crate::follow::PartError;
use crate::measure::Measure;
use crate::plan::{CasePlan, EngineKind, EnginePlan, PlanError};
use crate::run::error::RunError;
use crate::run::options::RunOptions;
use crate::unsaved::{InMemoryRun, collision_rate, energies, measures, resized};

/// Largest number of disks in the pilot runs that choose the Monte Carlo resolution.
const MOST_DISKS: usize = 400;
/// Smallest number of disks in the pilot runs that choose the Monte Carlo resolution.
const FEWEST_DISKS: usize = 24;
/// Side of the pilot's box over the shortest wavelength at which shear modes grow. Below 1 the gas
/// stays uniform.
const STABLE: f64 = 0.7;
/// Number of pilot runs for each candidate resolution.
const RUNS: u64 = 200;
/// Numbers of simulators per disk that pilot runs try, in this order.
const SIMULATORS: [u32; 7] = [1, 2, 4, 8, 16, 32, 64];
/// First replica number of the pilot runs. No replica of a case has such a large number, so random
/// streams never coincide.
const FIRST: u64 = 1 << 34;
/// Duration of a pilot run of a cooling gas \[Haff times `t_0`\].
const COOLING: f64 = 1.0;
/// Duration of a pilot run of an elastic gas \[mean free times\].
const ELASTIC: f64 = 20.0;

/// Chooses simulators and time step for each point whose case sets `[accuracy] target`, by pilot
/// runs.
///
/// # Errors
/// [`RunError`] if the pilot fails or is stopped.
pub fn choose_resolution<'a>(
    file: &CaseFile,
    planned: Vec<Planned<'a>>,
    options: &RunOptions<'_>,
    threads: usize,
) -> Result<Vec<Planned<'a>>, RunError> {
    if planned.iter().all(|one| one.plan.case.accuracy.is_none()) {
        return Ok(planned);
    }
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()?;
    let one = |one: Planned<'a>| {
        let target = one.plan.case.accuracy.as_ref();
        let Some(target) = target.and_then(format::AccuracySpec::parse_share) else {
            return Ok(one);
        };
        options
            .progress
            .show_note("a pilot chooses simulators and time steps for accuracy.target");
        let found = pool.install(|| choose(&one.plan, target, options.stop));
        let (case, choices) = found.map_err(RunError::Pilot)?;
        let mut settled = Planned::plan_point(file, one.point, &case, options.free_memory())?;
        settled.plan.notes.choices.extend(choices);
        Ok(settled)
    };
    planned.into_iter().map(one).collect()
}

/// Chooses the Monte Carlo resolution of one point by pilot runs. Returns the case with the chosen
/// values, and the reasons as text.
fn choose(
    plan: &CasePlan,
    target: f64,
    stop: &Interrupt,
) -> Result<(Case, Vec<String>), PartError> {
    let small = CasePlan::new(&pilot(plan), &plan.folder)?;
    let measures = measures(&["energy", "impact_parameters"]);
    let run = |replica| InMemoryRun {
        plan: &small,
        measures: &measures,
        replica,
        stop,
    };
    let starts = (FIRST..FIRST + RUNS).into_par_iter();
    let search = Search {
        plan: &small,
        measures: &measures,
        stop,
        starts: starts
            .map(|replica| run(replica).make_start())
            .collect::<Result<_, _>>()?,
        target,
    };
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
        words.push(choice.words(engine.name, &small, target));
    }
    Ok((case, words))
}

/// Returns the case of the pilot: a small uniform box of the gas, for one Haff time or 20 mean free
/// times.
fn pilot(plan: &CasePlan) -> Case {
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
    case.accuracy = None;
    case.measure.clear();
    case.engine.ed = None;
    case.run.until = if plan.gas.law.is_elastic() {
        ELASTIC
    } else {
        COOLING
    };
    case.run.time_unit = None;
    case.run.first_sample = Some(0.5 * case.run.until);
    case.run.samples_per_decade = Some(1);
    case.run.samples = None;
    let window = toml::Value::from(vec![toml::Value::from(vec![0.0, case.run.until])]);
    let windows = toml::Table::from_iter([("windows".to_owned(), window)]);
    case.measure.insert("impact_parameters".into(), windows);
    case
}

/// Candidate resolution of a Monte Carlo engine, with the accuracy that its pilot runs found.
struct Choice {
    parameters: Parameters,
    found: SettingAccuracy,
    met: bool,
}

impl Choice {
    fn words(&self, engine: &str, small: &CasePlan, target: f64) -> String {
        let what = if small.gas.law.is_elastic() {
            "the collision rate over Enskog's"
        } else {
            "K at t0 over Haff's law"
        };
        let target = format_percent(target);
        let reason = if self.met {
            format!("sure to be within {target} and the cheapest that is")
        } else {
            format!(
                "no resolution that was tried is sure to keep {target}, and this one errs least"
            )
        };
        format!(
            "{engine}: {} simulators per particle and {} steps, because a pilot of {} disks and {RUNS} runs found an error of \
             {} ± {} in {what}; {reason}",
            self.parameters.simulators_per_particle,
            self.parameters.steps_per_cell_crossing,
            small.count(),
            format_percent(self.found.systematic),
            format_percent(self.found.systematic_error),
        )
    }
}

/// Search for the cheapest resolution of one Monte Carlo engine whose error is within the target.
struct Search<'a> {
    plan: &'a CasePlan,
    measures: &'a [&'static dyn Measure],
    stop: &'a Interrupt,
    starts: Vec<Particles>,
    target: f64,
}

impl Search<'_> {
    fn measure(&self, engine: &EnginePlan, parameters: Parameters) -> Result<Choice, PartError> {
        let plan = self.plan;
        let elastic = plan.gas.law.is_elastic();
        let reference = if elastic {
            (1.0 - 1.0 / plan.count() as f64).sqrt()
        } else {
            transport::relaxing_haff_law(plan.gas.restitution, COOLING)
        };
        let engine = EnginePlan {
            kind: EngineKind::MonteCarlo(parameters),
            ..engine.clone()
        };
        let value = |(index, start): (usize, &Particles)| {
            let run = InMemoryRun {
                plan,
                measures: self.measures,
                replica: FIRST + index as u64,
                stop: self.stop,
            };
            let done = run.run_engine(&engine, start)?;
            Ok::<_, PartError>(if elastic {
                collision_rate(plan, &done)
            } else {
                energies(&done).last().copied().unwrap_or(f64::NAN)
            })
        };
        let values = self.starts.par_iter().enumerate().map(value);
        let values: Vec<f64> = values.collect::<Result<_, _>>()?;
        let known = Known {
            value: reference,
            standard_error: 0.0,
        };
        let failed = "a pilot whose values are no numbers";
        let found = SettingAccuracy::new(&values, known, reference)
            .ok_or_else(|| PlanError::new("accuracy.target", failed, "numbers"))?;
        Ok(Choice {
            parameters,
            found,
            // The whole upper limit of the bias counts, at 99 %.
            met: found.assured(u64::MAX) <= self.target,
        })
    }

    fn choose(&self, engine: &EnginePlan, asked: Parameters) -> Result<Choice, PartError> {
        let mut best: Option<Choice> = None;
        for simulators_per_particle in SIMULATORS {
            let parameters = Parameters {
                simulators_per_particle,
                ..asked
            };
            let choice = self.measure(engine, parameters)?;
            if choice.met {
                return self.fewer_steps(engine, choice);
            }
            let size = |choice: &Choice| choice.found.systematic.abs();
            if (best.as_ref()).is_none_or(|known| size(&choice) < size(known)) {
                best = Some(choice);
            }
        }
        best.map_or_else(|| self.measure(engine, asked), Ok)
    }

    /// Halves the number of time steps per cell crossing as long as the error stays within the
    /// target.
    fn fewer_steps(&self, engine: &EnginePlan, mut choice: Choice) -> Result<Choice, PartError> {
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
