//! `[accuracy] target`: the resolution of the Monte Carlo engines, chosen from a pilot.
//!
//! The pilot is a small box of the same gas, too small for growing waves of shear, followed to `t_0`. There theory is exact:
//! Haff's law with the relaxation of a2 for the energy of a gas that cools, Enskog's rate for the collisions of an elastic
//! one. For each engine simulators per disk are doubled until the energy (or rate) is sure to be within the target, then steps
//! are halved as long as it stays so. Runs have fixed seeds and the choice follows from their values and from the order of
//! the work alone, so it is the same on any machine.
//!
//! What is bounded is the error of the scheme against Enskog's theory, not the difference to exact disks, which break chaos.

use rayon::prelude::*;
use stosszahl_analysis::accuracy::{Accuracy, Known};
use stosszahl_model::{State, kinetic, transport};

use crate::case::{Case, Dsmc, Engine};
use crate::dispatch::{Planar, Visit, with_scene};
use crate::frontier::resized;
use crate::run::{RunError, Unsaved};
use crate::setup::{Setup, SetupError, TimeUnit};
use crate::words::percent;

/// Most and fewest disks of the pilot, and the side of its box over the shortest growing wave.
const MOST_DISKS: usize = 400;
const FEWEST_DISKS: usize = 24;
const STABLE: f64 = 0.7;
/// Runs of each candidate.
const RUNS: u64 = 200;
/// Simulators for each disk that are tried, in turn.
const SIMULATORS: [u32; 7] = [1, 2, 4, 8, 16, 32, 64];
/// First replica of the pilot: none that a run has.
const FIRST: u64 = 1 << 34;
/// When the pilot ends, in units of `t_0`: mean free times of an elastic gas.
const COOLING: f64 = 1.0;
const ELASTIC: f64 = 20.0;

/// Why no resolution can be chosen.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum AccuracyError {
    /// There is no theory to choose by.
    #[error(
        "accuracy.target: {found}; allowed are equal disks with one coefficient of restitution, cooling freely or elastic"
    )]
    NoTheory {
        /// What the case has.
        found: &'static str,
    },
    /// The pilot cannot be set up.
    #[error("pilot: {0}")]
    Setup(#[from] SetupError),
    /// A run of the pilot failed.
    #[error("pilot: {0}")]
    Run(#[from] RunError),
}

/// A case with the resolution of its Monte Carlo engines chosen; as it is if it asks for no accuracy.
///
/// # Errors
/// [`AccuracyError`] if there is no theory to choose by, or the pilot fails.
pub fn resolved(setup: Setup) -> Result<Setup, AccuracyError> {
    let Some(target) = setup.case.accuracy else {
        return Ok(setup);
    };
    if !setup.has_theory() {
        let found = "unlike disks, or a restitution that depends on the speed";
        return Err(AccuracyError::NoTheory { found });
    }
    if setup.case.drive.is_some() {
        let found = "a driven gas";
        return Err(AccuracyError::NoTheory { found });
    }
    let small = Setup::new(&pilot(&setup))?;
    let engines = setup.case.engines.iter().filter_map(|engine| match engine {
        Engine::Dsmc(dsmc) => Some(*dsmc),
        Engine::Ed(_) => None,
    });
    let search = All {
        small: &small,
        engines: engines.collect(),
        target,
    };
    let found = with_scene(&small, search)?;
    let mut case = setup.case.clone();
    let monte_carlo = case.engines.iter_mut().filter_map(|engine| match engine {
        Engine::Dsmc(dsmc) => Some(dsmc),
        Engine::Ed(_) => None,
    });
    for (dsmc, choice) in monte_carlo.zip(&found) {
        *dsmc = choice.dsmc;
    }
    let mut chosen = Setup::new(&case)?;
    chosen.choices = found
        .iter()
        .map(|choice| choice.words(target, &small))
        .collect();
    Ok(chosen)
}

/// The small box.
fn pilot(setup: &Setup) -> Case {
    let density = setup.packing_fraction / std::f64::consts::FRAC_PI_4;
    let side = STABLE
        * transport::critical_length(
            setup.packing_fraction,
            setup.contact_value,
            setup.restitution,
        );
    let stable = (density * side * side).min(MOST_DISKS as f64);
    let disks = (stable as usize).clamp(FEWEST_DISKS, setup.disks.max(FEWEST_DISKS));
    let mut case = resized(&setup.case, disks);
    case.run.until = match setup.time_unit {
        TimeUnit::Haff => COOLING,
        TimeUnit::MeanFreeTime => ELASTIC,
    };
    case.run.first_sample = 0.5 * case.run.until;
    case.run.samples_per_decade = 1;
    case.measure.impact_windows = vec![[0.0, case.run.until]];
    case.measure.structure.times.clear();
    case.measure.snapshot_times.clear();
    case.measure.displacement_start = None;
    case
}

/// A resolution with what the pilot found of it.
struct Choice {
    dsmc: Dsmc,
    found: Accuracy,
    met: bool,
}

impl Choice {
    fn words(&self, target: f64, small: &Setup) -> String {
        let engine = self.dsmc.scheme.name();
        let what = match small.time_unit {
            TimeUnit::Haff => "K at t0 over Haff's law",
            TimeUnit::MeanFreeTime => "the collision rate over Enskog's",
        };
        let simulators = self.dsmc.simulators_per_disk.unwrap_or(1);
        let pilot = format!(
            "{engine}: {simulators} simulators per disk and {} steps, because a pilot of {} disks and {RUNS} runs found an error of \
             {} ± {} in {what}",
            self.dsmc.steps_per_crossing,
            small.disks,
            percent(self.found.systematic),
            percent(self.found.systematic_error),
        );
        if self.met {
            format!(
                "{pilot}, sure to be within {} and the cheapest that is",
                percent(target)
            )
        } else {
            format!(
                "{pilot}; no resolution that was tried is sure to keep {}, and this one errs least",
                percent(target)
            )
        }
    }
}

/// The search for all engines of a case.
struct All<'a> {
    small: &'a Setup,
    engines: Vec<Dsmc>,
    target: f64,
}

impl Visit for All<'_> {
    type Output = Result<Vec<Choice>, AccuracyError>;

    fn visit<P: Planar>(self, scene: P) -> Self::Output {
        let starts = (FIRST..FIRST + RUNS).into_par_iter().map(|replica| {
            let run = Unsaved {
                setup: self.small,
                replica,
            };
            run.start(&scene)
        });
        let search = Search {
            small: self.small,
            scene: &scene,
            starts: starts.collect::<Result<_, _>>()?,
            target: self.target,
        };
        self.engines
            .into_iter()
            .map(|engine| search.choose(engine))
            .collect()
    }
}

/// Looks for the cheapest resolution of one engine.
struct Search<'a, P: Planar> {
    small: &'a Setup,
    scene: &'a P,
    starts: Vec<State<P>>,
    target: f64,
}

impl<P: Planar> Search<'_, P> {
    fn measure(&self, dsmc: Dsmc) -> Result<Choice, AccuracyError> {
        let small = self.small;
        let reference = match small.time_unit {
            TimeUnit::Haff => transport::relaxing_haff_law(small.restitution, COOLING),
            TimeUnit::MeanFreeTime => (1.0 - 1.0 / small.disks as f64).sqrt(),
        };
        let known = Known {
            value: reference,
            standard_error: 0.0,
        };
        let values = self.values(&Engine::Dsmc(dsmc))?;
        let found = Accuracy::new(&values, known, reference).ok_or(AccuracyError::NoTheory {
            found: "a pilot whose values are no numbers",
        })?;
        // All of what is not known of the bias, at 99 %.
        let met = found.assured(u64::MAX) <= self.target;
        Ok(Choice { dsmc, found, met })
    }

    /// The energy at the end, or the collision rate, of all runs.
    fn values(&self, engine: &Engine) -> Result<Vec<f64>, RunError> {
        let small = self.small;
        let enskog = kinetic::collision_rate(small.packing_fraction, small.contact_value, 0.0);
        let value = |(index, start): (usize, &State<P>)| {
            let run = Unsaved {
                setup: small,
                replica: FIRST + index as u64,
            };
            let done = run.run(self.scene, engine, start)?.record;
            let window = done.windows.windows.first();
            Ok(match small.time_unit {
                TimeUnit::Haff => done.energy_ratio(done.energies.len() - 1),
                TimeUnit::MeanFreeTime => window
                    .and_then(|window| window.dissipation(enskog, small.disks))
                    .map_or(f64::NAN, |found| found.rate),
            })
        };
        self.starts.par_iter().enumerate().map(value).collect()
    }

    fn choose(&self, asked: Dsmc) -> Result<Choice, AccuracyError> {
        let mut best: Option<Choice> = None;
        for simulators in SIMULATORS {
            let dsmc = Dsmc {
                simulators_per_disk: Some(simulators),
                ..asked
            };
            let choice = self.measure(dsmc)?;
            if choice.met {
                return self.fewer_steps(choice);
            }
            let better =
                |known: &Choice| choice.found.systematic.abs() < known.found.systematic.abs();
            if best.as_ref().is_none_or(better) {
                best = Some(choice);
            }
        }
        best.ok_or(AccuracyError::NoTheory {
            found: "no resolution to try",
        })
    }

    /// Halves the steps while the target is kept.
    fn fewer_steps(&self, mut choice: Choice) -> Result<Choice, AccuracyError> {
        loop {
            let steps = 0.5 * choice.dsmc.steps_per_crossing;
            if steps < 1.0 {
                return Ok(choice);
            }
            let coarser = self.measure(Dsmc {
                steps_per_crossing: steps,
                ..choice.dsmc
            })?;
            if !coarser.met {
                return Ok(choice);
            }
            choice = coarser;
        }
    }
}
