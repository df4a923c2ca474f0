//! A gas without positions as a job.

use std::collections::BTreeMap;
use std::path::Path;

use stosszahl_model::snapshot::Fingerprint;

use super::CommandError;
use super::job::{self, Job, PointRun};
use crate::homogeneous::case::Case;
use crate::homogeneous::export::Tables;
use crate::homogeneous::manifest::Manifest;
use crate::homogeneous::plan::Plan;
use crate::homogeneous::run::{self, Finished};
use crate::homogeneous::tables::{CheckRow, GasRow, SampleRow};
use crate::homogeneous::{outline, verdicts, warnings};
use crate::manifest::{FORMAT, MANIFEST_FILE, Verdict};
use crate::run::Place;
use crate::tables::Row;

impl Job for Case {
    type Plan = Plan;

    const FILES: &'static [&'static str] =
        &[GasRow::FILE, CheckRow::FILE, SampleRow::FILE, MANIFEST_FILE];

    fn title(&self) -> &str {
        &self.title
    }

    fn plan(&self, file: &Path) -> Result<Plan, CommandError> {
        Plan::new(self).map_err(|source| CommandError::Plan {
            path: file.to_owned(),
            source,
        })
    }

    fn outline(plan: &Plan) -> String {
        outline(plan)
    }

    fn jobs(plan: &Plan) -> usize {
        plan.case.replicas
    }

    fn fingerprint(plan: &Plan) -> Fingerprint {
        let mut hash = blake3::Hasher::new();
        hash.update(env!("CARGO_PKG_VERSION").as_bytes());
        // Neither the title, nor how often the run is saved, nor what counts as agreement.
        let mut case = plan.case.clone();
        case.title.clear();
        case.run.checkpoint_seconds = 0.0;
        case.tolerance = 0.0;
        hash.update(&serde_json::to_vec(&case).unwrap_or_default());
        hash.finalize().into()
    }

    fn run(run: &PointRun<'_, Self>, place: Place<'_>) -> Result<Vec<Verdict>, CommandError> {
        let (plan, folder) = (run.plan, place.folder);
        let runs = run::run(plan, place).map_err(|source| CommandError::Run {
            folder: folder.to_owned(),
            source: Box::new(source),
        })?;
        let tables = Tables::new(plan, &runs).map_err(|source| CommandError::Plan {
            path: run.file.path.clone(),
            source: source.into(),
        })?;
        tables.write(plan, folder)?;
        let manifest = Manifest {
            format: FORMAT,
            kind: crate::case::Kind::Homogeneous,
            program: job::program(),
            title: plan.case.title.clone(),
            case_text: run.file.source_text.clone(),
            case: serde_json::to_value(&plan.case).unwrap_or_default(),
            derived: plan.derived().into_iter().collect(),
            machine: job::machine(),
            seed: plan.case.seed,
            replicas: plan.case.replicas as u64,
            wall_seconds: run.began.elapsed().as_secs_f64(),
            work: work(&runs),
            verdicts: verdicts(plan, &runs, &tables),
            warnings: warnings(plan),
        };
        job::write_json(&folder.join(MANIFEST_FILE), &manifest)?;
        Ok(manifest.verdicts)
    }
}

/// Work of one replica, on average.
fn work(runs: &[Finished]) -> BTreeMap<String, f64> {
    let mean = |value: &dyn Fn(&Finished) -> f64| {
        runs.iter().map(value).sum::<f64>() / runs.len().max(1) as f64
    };
    let collisions = mean(&|run| run.tally.collisions as f64);
    let seconds = mean(&|run| run.seconds);
    let each = |count: f64| {
        if collisions > 0.0 {
            count / collisions
        } else {
            0.0
        }
    };
    let numbers = [
        ("collisions", collisions),
        (
            "proposals_per_collision",
            each(mean(&|run| run.tally.proposals as f64)),
        ),
        (
            "pairs_looked_at_per_collision",
            each(mean(&|run| run.tally.trials as f64)),
        ),
        ("fits_of_bounds", mean(&|run| run.tally.rebuilds as f64)),
        (
            "energy_at_the_end",
            mean(&|run| run.record.samples.last().map_or(f64::NAN, |s| s.energy)),
        ),
        ("bytes", mean(&|run| run.bytes as f64)),
        ("seconds", seconds),
        (
            "collisions_per_second",
            if seconds > 0.0 {
                collisions / seconds
            } else {
                0.0
            },
        ),
    ];
    numbers
        .into_iter()
        .map(|(name, value)| (name.to_owned(), value))
        .collect()
}
