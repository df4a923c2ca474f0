//! Creation of engines from the plan of a case and a start or checkpoint.

pub(crate) mod rank_group;

use std::borrow::Cow;
use std::sync::Arc;
use std::{iter, slice};

use stosszahl_case::format::{EnergyPart, FirstTest, SelectionSpec};
use stosszahl_dsmc::homogeneous::{
    AggregationRule, EnergyLimit, EnergyLoss, HomogeneousSettings, PairCorrelationFactor,
    PairSelection, TestOrder, Threshold,
};
use stosszahl_dsmc::{
    BoundaryConditions, CellGas, CheckpointSource, DomainStart, ExpectedGas, Parameters, Ranks,
    Scheme, ShardLocation, StartStream,
};
use stosszahl_ed::DissipationRule;
use stosszahl_model::random::Streams;
use stosszahl_model::{Interrupt, Particles, Simulation, Volume};
use stosszahl_results::format_number;
use stosszahl_theory::ContactValues;

use crate::engines::rank_group::RankGroup;
use crate::measure::Needs;
use crate::measures;
use crate::plan::{CasePlan, EngineKind, EnginePlan, PlanError, threads_each};
use crate::start;
use crate::start::error::StartError;
use crate::start::stream::IndependentStart;

/// Branch of the random streams for Monte Carlo in the units of the case: with walls, gravity or
/// spinning particles. It differs from that of exact dynamics.
const IN_UNITS_OF_CASE: u64 = 2;

/// Error with which an engine cannot start.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum BeginError {
    /// The plan does not allow the engine.
    #[error(transparent)]
    Plan(#[from] PlanError),
    /// A set of simulators cannot be placed.
    #[error(transparent)]
    Start(#[from] StartError),
    /// Exact event-driven dynamics refuses the gas.
    #[error(transparent)]
    EventDriven(#[from] stosszahl_ed::EventDrivenError),
    /// Monte Carlo in cells refuses the gas.
    #[error(transparent)]
    MonteCarlo(#[from] stosszahl_dsmc::DsmcError),
    /// Monte Carlo of a gas without positions refuses the gas.
    #[error(transparent)]
    Homogeneous(#[from] stosszahl_dsmc::homogeneous::HomogeneousError),
}

impl BeginError {
    /// Converts numbers in the error of an engine to the units of the case.
    fn in_units(self, plan: &CasePlan) -> Self {
        let units = plan.message_units();
        match self {
            Self::EventDriven(error) => Self::EventDriven(error.in_units(&units)),
            Self::MonteCarlo(error) => Self::MonteCarlo(error.in_units(&units)),
            Self::Start(error) => Self::Start(error.in_units(plan)),
            Self::Plan(_) | Self::Homogeneous(_) => self,
        }
    }
}

impl BeginError {
    /// Returns true if the case cannot be run as it is; false for a damaged checkpoint or a fault
    /// of another process or the machine.
    pub(crate) fn is_refusal(&self) -> bool {
        match self {
            Self::Plan(_) | Self::Homogeneous(_) => true,
            Self::Start(error) => error.is_refusal(),
            Self::EventDriven(error) => {
                !matches!(error, stosszahl_ed::EventDrivenError::Checkpoint(_))
            }
            Self::MonteCarlo(error) => !matches!(
                error,
                stosszahl_dsmc::DsmcError::Checkpoint(_)
                    | stosszahl_dsmc::DsmcError::Shard { .. }
                    | stosszahl_dsmc::DsmcError::Elsewhere { .. }
                    | stosszahl_dsmc::DsmcError::OneProcess
                    | stosszahl_dsmc::DsmcError::UnequalParts { .. }
            ),
        }
    }
}

/// Largest expected number of cell crossings between two collisions for exact dynamics. The engine
/// gives up after 1e7, and one in `e^20` of all waits is twenty times the mean.
const MOST_CROSSINGS: f64 = 1e7 / 20.0;

/// Checks everything for which an engine would refuse the case, except positions of particles.
///
/// # Errors
/// [`PlanError`] names the engine.
pub fn check_start(plan: &CasePlan) -> Result<(), PlanError> {
    let units = plan.message_units();
    for engine in &plan.engines {
        let refuse =
            |error: String| PlanError::of_message(format!("engine.{}", engine.name), &error);
        match &engine.kind {
            EngineKind::EventDriven { .. } => {
                let boundaries = plan.exact_boundaries(Streams::new(plan.case.seed, 0))?;
                let nothing = Particles {
                    time: 0.0,
                    dimension: plan.gas.dimension,
                    lengths: plan.gas.lengths,
                    periodic: [0, 1, 2].map(|axis| plan.is_periodic_along(axis)),
                    all: Vec::new(),
                };
                let made = stosszahl_ed::simulate(
                    &plan.gas.particles,
                    DissipationRule::Scene,
                    &boundaries,
                    &nothing,
                );
                made.map_err(|error| refuse(error.in_units(&units).to_string()))?;
                let crossings = plan.crossings_per_collision();
                if crossings > MOST_CROSSINGS {
                    return Err(refuse(format!(
                        "disks cross some {} cells between two collisions, and exact dynamics gives up after 1e7; allowed: \
                         dsmc-boltzmann for a gas so thin, or fewer, larger disks",
                        format_number(crossings.round())
                    )));
                }
            }
            EngineKind::MonteCarlo(parameters) => {
                let boundaries = plan.boundaries::<Volume>(engine)?;
                let gas = CellGas {
                    grains: &plan.gas.particles,
                    parameters: *parameters,
                    boundaries: &boundaries,
                    streams: Streams::new(plan.case.seed, 0),
                    displacements: false,
                };
                let expected = ExpectedGas {
                    lengths: plan.gas.lengths,
                    mean_radius: plan.mean_radius(),
                    packing_fraction: plan.gas.packing_fraction,
                };
                stosszahl_dsmc::check_gas(&gas, &expected)
                    .map_err(|error| refuse(error.in_units(&units).to_string()))?;
            }
            EngineKind::Homogeneous(_) => {}
        }
    }
    Ok(())
}

/// Source from which an engine begins: an initial state or a checkpoint.
#[derive(Clone, Copy)]
pub enum From<'a> {
    /// Initial state of the replica; `None` without positions.
    Start(Option<&'a Particles>),
    /// Checkpoint: bytes of [`Simulation::save_checkpoint`], and the location of its shards if
    /// there are any.
    Checkpoint(&'a [u8], Option<&'a ShardLocation>),
}

/// Starts or resumes an engine of a replica with the given random streams. An interrupt ends the
/// start early. Monte Carlo in cells is decomposed over the processes of `group`, if given.
///
/// # Errors
/// [`BeginError`] if the engine cannot start.
pub fn begin(
    plan: &CasePlan,
    engine: &EnginePlan,
    streams: Streams,
    needs: Needs,
    from: From<'_>,
    interrupt: &Interrupt,
    group: Option<(&RankGroup, u64)>,
) -> Result<Box<dyn Simulation>, BeginError> {
    let made = made(plan, engine, streams, needs, from, interrupt, group);
    let mut gas = made.map_err(|error| error.in_units(plan))?;
    gas.set_stop_flag(interrupt);
    gas.use_threads(threads_each(
        plan.engines.len() * plan.case.replicas as usize,
    ));
    Ok(gas)
}

/// Holds this process's subdomain of a decomposed gas that the root process begins, until the root
/// ends it.
///
/// # Errors
/// [`BeginError`] if the gas cannot start here.
pub(crate) fn hold(
    plan: &CasePlan,
    engine: &EnginePlan,
    streams: Streams,
    needs: Needs,
    interrupt: &Interrupt,
    ranks: &Arc<dyn Ranks>,
) -> Result<(), BeginError> {
    let EngineKind::MonteCarlo(parameters) = &engine.kind else {
        return Ok(());
    };
    let boundaries = plan.boundaries::<Volume>(engine)?;
    let gas = in_cells(plan, *parameters, &boundaries, streams, needs);
    let (count, lengths) = (plan.count(), plan.gas.lengths);
    let start = IndependentStart::new(plan, engine, streams, interrupt);
    let start = start.as_ref().map(|start| -> &dyn StartStream { start });
    Ok(stosszahl_dsmc::serve_domain(
        &gas,
        count,
        lengths,
        start,
        ranks,
        interrupt,
        measures::sum,
    )?)
}

/// Returns the description of Monte Carlo in cells without its initial state.
fn in_cells<'a>(
    plan: &'a CasePlan,
    parameters: Parameters,
    boundaries: &'a BoundaryConditions<Volume>,
    streams: Streams,
    needs: Needs,
) -> CellGas<'a> {
    CellGas {
        grains: &plan.gas.particles,
        parameters,
        boundaries,
        streams: streams.branch(scheme_branch(plan, parameters.scheme)),
        displacements: needs.displacements,
    }
}

fn made(
    plan: &CasePlan,
    engine: &EnginePlan,
    streams: Streams,
    needs: Needs,
    from: From<'_>,
    interrupt: &Interrupt,
    group: Option<(&RankGroup, u64)>,
) -> Result<Box<dyn Simulation>, BeginError> {
    // Not before this process has all that it needs, or the others would wait for it.
    let call = || group.map(|(all, replica)| all.call(replica, engine));
    match &engine.kind {
        EngineKind::EventDriven { contact_time, .. } => {
            let dissipation = if *contact_time > 0.0 {
                DissipationRule::ContactTime(*contact_time)
            } else {
                DissipationRule::Scene
            };
            let boundaries = plan.exact_boundaries(streams)?;
            Ok(match from {
                From::Start(start) => {
                    let start = initial_states(plan, start, 1, streams, interrupt)?;
                    stosszahl_ed::simulate(
                        &plan.gas.particles,
                        dissipation,
                        &boundaries,
                        &start[0],
                    )?
                }
                From::Checkpoint(bytes, _) => {
                    let count = plan.count();
                    stosszahl_ed::resume(
                        &plan.gas.particles,
                        count,
                        dissipation,
                        &boundaries,
                        bytes,
                        interrupt,
                    )?
                }
            })
        }
        EngineKind::MonteCarlo(parameters) => {
            let boundaries = plan.boundaries::<Volume>(engine)?;
            let gas = in_cells(plan, *parameters, &boundaries, streams, needs);
            begin_in_cells(plan, engine, &gas, streams, from, interrupt, &call)
        }
        EngineKind::Homogeneous(selection) => {
            let temperatures = plan.kind_temperatures();
            let groups = plan.groups();
            let gas = HomogeneousSettings {
                dimension: plan.gas.dimension,
                grains: &plan.gas.particles,
                count: plan.count(),
                volume: plan.gas.volume,
                contact: match plan.contact() {
                    ContactValues::Dilute => PairCorrelationFactor::Dilute,
                    ContactValues::Enskog => PairCorrelationFactor::Enskog,
                },
                temperatures: &temperatures,
                velocities: plan.gas.velocities,
                pick: match selection {
                    SelectionSpec::AliasTables => PairSelection::AliasTables,
                    SelectionSpec::LowRank => PairSelection::LowRank,
                    SelectionSpec::SingleMajorant => PairSelection::SingleMajorant,
                },
                tracer: plan
                    .gas
                    .species
                    .iter()
                    .position(|one| one.tracer)
                    .map(|one| one as u32),
                sticking: aggregation_rule(plan),
                displacements: needs.displacements,
                paths: (needs.trajectories, &groups),
                streams,
            };
            Ok(match from {
                From::Start(_) => gas.simulate()?,
                From::Checkpoint(bytes, _) => gas.resume(bytes)?,
            })
        }
    }
}

/// Starts or resumes Monte Carlo in cells. `call` calls the other processes that hold the gas, if
/// there are any, and returns the transport to them.
fn begin_in_cells<'r>(
    plan: &CasePlan,
    engine: &EnginePlan,
    gas: &CellGas<'_>,
    streams: Streams,
    from: From<'_>,
    interrupt: &Interrupt,
    call: &dyn Fn() -> Option<&'r Arc<dyn Ranks>>,
) -> Result<Box<dyn Simulation>, BeginError> {
    let start = match from {
        From::Start(start) => start,
        From::Checkpoint(checkpoint, beside) => {
            let left = CheckpointSource {
                count: plan.count(),
                lengths: plan.gas.lengths,
                checkpoint,
                beside,
            };
            return Ok(match call() {
                Some(ranks) => stosszahl_dsmc::resume_distributed(gas, left, ranks)?,
                None => stosszahl_dsmc::resume(gas, left)?,
            });
        }
    };
    let stream = IndependentStart::new(plan, engine, streams, interrupt);
    if let (None, Some(stream)) = (start, stream) {
        let made = match call() {
            Some(ranks) => {
                stosszahl_dsmc::simulate_distributed(gas, DomainStart::Stream(&stream), ranks)
            }
            None => stosszahl_dsmc::simulate_stream(gas, &stream),
        };
        return match stream.take_failure() {
            Some(failure) => Err(failure.into()),
            None => Ok(made?),
        };
    }
    let sets = if plan.starts_from_copies() {
        1
    } else {
        engine.copies() as u64
    };
    let sets = initial_states(plan, start, sets, streams, interrupt)?;
    Ok(match call() {
        Some(ranks) => {
            stosszahl_dsmc::simulate_distributed(gas, DomainStart::States(&sets), ranks)?
        }
        None => stosszahl_dsmc::simulate(gas, &sets)?,
    })
}

/// Returns the initial states of `sets` sets of simulators: the prepared one, or new ones. A single
/// prepared state is not copied.
fn initial_states<'a>(
    plan: &CasePlan,
    prepared: Option<&'a Particles>,
    sets: u64,
    streams: Streams,
    interrupt: &Interrupt,
) -> Result<Cow<'a, [Particles]>, StartError> {
    let made = |set| Ok(start::placed(plan, set, streams, interrupt)?.0);
    let first = match prepared {
        Some(start) if sets == 1 => return Ok(Cow::Borrowed(slice::from_ref(start))),
        Some(start) => Ok(start.clone()),
        None => made(0),
    };
    let all = iter::once(first).chain((1..sets).map(made));
    all.collect::<Result<_, _>>().map(Cow::Owned)
}

/// Returns the branch of the random streams for a scheme, so that schemes of one replica draw
/// different numbers.
fn scheme_branch(plan: &CasePlan, scheme: Scheme) -> u64 {
    if !plan.has_thermal_units() {
        return IN_UNITS_OF_CASE;
    }
    scheme.properties().random_branch
}

/// Returns the rule of aggregation and fragmentation of the case; `None` without one.
fn aggregation_rule(plan: &CasePlan) -> Option<AggregationRule> {
    let written = plan.case.aggregation.as_ref()?;
    let threshold = |energy: Option<f64>, speed: Option<f64>, part| Threshold {
        limit: match speed {
            Some(speed) => EnergyLimit::Speed(speed),
            None => EnergyLimit::Energy(energy.unwrap_or(f64::INFINITY)),
        },
        part: match part {
            EnergyPart::Full => EnergyLoss::Full,
            EnergyPart::Normal => EnergyLoss::Normal,
        },
    };
    Some(AggregationRule {
        stick: threshold(
            written.aggregate_below,
            written.aggregate_below_speed,
            written.aggregate_energy_part,
        ),
        shatter: threshold(
            written.fragment_above,
            written.fragment_above_speed,
            written.fragment_energy_part,
        ),
        order: match written.check_first {
            FirstTest::Aggregation => TestOrder::StickFirst,
            FirstTest::Fragmentation => TestOrder::BreakFirst,
        },
        retained: written.fragment_speed_factor,
        // The number of monomers never exceeds that of the start.
        most: plan.count(),
    })
}
