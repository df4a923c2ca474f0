//! The paired case as a job: engines from one initial state.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::Path;
use std::thread;

use stosszahl_model::Sizes;
use stosszahl_model::snapshot::Fingerprint;

use super::CommandError;
use super::job::{self, Job, PointRun};
use crate::accuracy;
use crate::case::{self, Case, CaseFile, Engine, Units};
use crate::export::Tables;
use crate::manifest::{self, Manifest, Verdict};
use crate::progress::duration;
use crate::run::{self, Place, Replica, SNAPSHOTS};
use crate::setup::{Setup, TimeUnit};
use crate::tables::{
    ComparisonRow, DissipationRow, EnergyRow, ImpactParameterRow, ImpactSummaryRow,
    PairCorrelationRow, ReplicaRow, Row, StructureFactorRow,
};
use crate::verdicts::verdicts;

impl Job for Case {
    type Plan = Setup;

    const FILES: &'static [&'static str] = &[
        EnergyRow::FILE,
        ComparisonRow::FILE,
        ImpactParameterRow::FILE,
        ImpactSummaryRow::FILE,
        StructureFactorRow::FILE,
        PairCorrelationRow::FILE,
        DissipationRow::FILE,
        ReplicaRow::FILE,
        manifest::MANIFEST_FILE,
    ];

    fn title(&self) -> &str {
        &self.title
    }

    fn plan(&self, file: &Path) -> Result<Setup, CommandError> {
        Setup::new(self).map_err(|source| CommandError::Setup {
            path: file.to_owned(),
            source,
        })
    }

    fn settle(setup: Setup) -> Result<Setup, CommandError> {
        Ok(accuracy::resolved(setup)?)
    }

    fn choices(setup: &Setup) -> Vec<String> {
        setup.choices.clone()
    }

    fn outline(setup: &Setup) -> String {
        outline(setup)
    }

    fn jobs(setup: &Setup) -> usize {
        setup.case.replicas * setup.case.engines.len()
    }

    fn fingerprint(setup: &Setup) -> Fingerprint {
        fingerprint(setup)
    }

    fn inputs(setup: &Setup) -> Vec<&Path> {
        match &setup.case.start.bodies {
            case::Bodies::File(start) => vec![&start.path],
            _ => Vec::new(),
        }
    }

    fn run(run: &PointRun<'_, Self>, place: Place<'_>) -> Result<Vec<Verdict>, CommandError> {
        let (setup, folder) = (run.plan, place.folder);
        let replicas = run::run(setup, place).map_err(|source| CommandError::Run {
            folder: folder.to_owned(),
            source: Box::new(source),
        })?;
        let tables = Tables::new(setup, &replicas);
        tables.write(setup, folder)?;
        let seconds = run.began.elapsed().as_secs_f64();
        let manifest = describe(run.file, setup, &replicas, &tables, seconds);
        job::write_json(&folder.join(manifest::MANIFEST_FILE), &manifest)?;
        Ok(manifest.verdicts)
    }
}

/// What follows from a case, in lines.
fn outline(setup: &Setup) -> String {
    let mut text = String::new();
    // Writing to a string cannot fail.
    for (name, value) in setup.derived() {
        let _ = writeln!(text, "  {name:<44} {value:>14.6}");
    }
    let (seconds, bytes) = estimate(setup);
    let threads = thread::available_parallelism().map_or(1, usize::from);
    let parallel = threads.min(setup.case.replicas * setup.case.engines.len()) as f64;
    let _ = writeln!(
        text,
        "  {:<44} {:>14.1}",
        "memory_of_one_engine_in_mebibytes",
        bytes / 1_048_576.0
    );
    let _ = writeln!(
        text,
        "  {} replicas of {} engines on {threads} threads: roughly {}",
        setup.case.replicas,
        setup.case.engines.len(),
        duration(seconds / parallel)
    );
    for warning in setup.warnings() {
        let _ = writeln!(text, "  warning: {warning}");
    }
    text
}

/// Collisions and simulator steps a second that the estimate of the time assumes; a rough guide.
const COLLISIONS_PER_SECOND: f64 = 4e5;
const SIMULATOR_STEPS_PER_SECOND: f64 = 1.5e7;

/// Collisions of simulators with partners across cells, in a second.
const COLLISIONS_ACROSS_PER_SECOND: f64 = 1e6;

/// Seconds of one core for all replicas, and bytes of the largest engine.
fn estimate(setup: &Setup) -> (f64, f64) {
    let disks = setup.disks as f64;
    let until = setup.case.run.until;
    let start = setup.case.start.collisions_per_particle;
    let exact = 0.5 * disks * (setup.expected_collisions(until) + start);
    let (mut seconds, mut bytes) = (0.5 * disks * start / COLLISIONS_PER_SECOND, 0.0_f64);
    for engine in &setup.case.engines {
        match engine {
            Engine::Ed(_) => {
                seconds += exact / COLLISIONS_PER_SECOND;
                bytes = bytes.max(220.0 * disks);
            }
            Engine::Dsmc(dsmc) => {
                let copies = setup.copies(dsmc);
                let simulators = disks * copies;
                if !dsmc.scheme.within_cells() {
                    seconds += copies * exact / COLLISIONS_ACROSS_PER_SECOND;
                }
                let steps = setup.expected_steps(dsmc);
                seconds += steps * simulators / SIMULATOR_STEPS_PER_SECOND;
                bytes = bytes.max(100.0 * simulators);
            }
        }
    }
    (seconds * setup.case.replicas as f64, bytes)
}

/// What decides the numbers of a run.
pub(crate) fn fingerprint(setup: &Setup) -> Fingerprint {
    let mut hash = blake3::Hasher::new();
    hash.update(env!("CARGO_PKG_VERSION").as_bytes());
    // Neither the title nor how often the run is saved.
    let mut case = setup.case.clone();
    case.title.clear();
    case.run.checkpoint_seconds = 0.0;
    hash.update(&serde_json::to_vec(&case).unwrap_or_default());
    if let Some(file) = &setup.file {
        for vector in file
            .positions
            .iter()
            .chain(file.velocities.iter().flatten())
        {
            hash.update(&vector[0].to_le_bytes())
                .update(&vector[1].to_le_bytes());
        }
    }
    if let Some(sizes) = &setup.sizes {
        for index in 0..setup.disks {
            let tag = sizes.tag(index);
            hash.update(&sizes.radius(tag).to_le_bytes())
                .update(&sizes.mass(tag).to_le_bytes());
        }
    }
    hash.finalize().into()
}

fn describe(
    file: &CaseFile,
    setup: &Setup,
    replicas: &[Replica],
    tables: &Tables,
    seconds: f64,
) -> Manifest {
    let case = &setup.case;
    let engines = case.engines.iter().enumerate().map(|(index, engine)| {
        let runs: Vec<_> = replicas
            .iter()
            .map(|replica| &replica.engines[index])
            .collect();
        let mut work: BTreeMap<String, f64> = BTreeMap::new();
        for run in &runs {
            for (name, number) in &run.work.numbers {
                *work.entry(name.clone()).or_default() += number / runs.len() as f64;
            }
        }
        manifest::EngineWork {
            engine: engine.name().to_owned(),
            wall_seconds: runs.iter().map(|run| run.seconds).sum(),
            collisions: runs.iter().map(|run| run.work.collisions).sum(),
            work,
        }
    });
    let engines: Vec<manifest::EngineWork> = engines.collect();
    let suspicions = warnings(setup, &engines);
    let snapshots = case.engines.iter().flat_map(|engine| {
        case.measure
            .snapshot_times
            .iter()
            .enumerate()
            .map(move |(index, &time)| manifest::Snapshot {
                engine: engine.name().to_owned(),
                time_over_t0: time,
                file: format!("{SNAPSHOTS}/{}-{index}.xyz", engine.name()),
            })
    });
    let start = replicas
        .iter()
        .enumerate()
        .map(|(replica, known)| manifest::Start {
            replica: replica as u64,
            placement: known.start.placement.clone(),
            collisions_per_particle: known.start.collisions_per_particle,
            equilibrated: known.start.equilibrated,
            tests: known
                .start
                .tests
                .iter()
                .map(|test| manifest::StartTest {
                    name: test.name.clone(),
                    statistic: test.statistic,
                    p_value: test.p_value,
                    passed: test.passed,
                    detail: test.detail.clone(),
                })
                .collect(),
        });
    Manifest {
        format: manifest::FORMAT,
        program: job::program(),
        title: case.title.clone(),
        case_text: file.source_text.clone(),
        case: serde_json::to_value(case).unwrap_or_default(),
        units: match case.units {
            Units::Reduced => manifest::Units::Reduced,
            Units::Si => manifest::Units::Si,
        },
        t0: manifest::ReferenceTime {
            seconds_or_units: setup.time * setup.scale.time(),
            definition: match setup.time_unit {
                TimeUnit::Haff => manifest::TimeDefinition::Haff,
                TimeUnit::MeanFreeTime => manifest::TimeDefinition::MeanFreeTime,
            },
        },
        derived: setup.derived().into_iter().collect(),
        machine: job::machine(),
        seed: case.seed,
        replicas: case.replicas as u64,
        wall_seconds: seconds,
        start: start.collect(),
        engines,
        verdicts: verdicts(setup, replicas, tables),
        choices: setup.choices.clone(),
        warnings: suspicions,
        snapshots: snapshots.collect(),
    }
}

/// What deserves a second look, before and after the run.
fn warnings(setup: &Setup, engines: &[manifest::EngineWork]) -> Vec<String> {
    /// Share of collisions in cells with a limited contact value from which it is named.
    const MANY: f64 = 0.1;
    let mut list = setup.warnings();
    for engine in engines {
        let share = engine
            .work
            .get("share_of_collisions_in_limited_cells")
            .copied()
            .unwrap_or(0.0);
        if share > MANY {
            list.push(format!(
                "{}: {:.0} % of the collisions were in cells whose contact value was limited by largest_contact_value; the rate \
                 there is the limit's, not the density's",
                engine.engine,
                100.0 * share
            ));
        }
    }
    list
}
