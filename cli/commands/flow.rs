//! A flow as a job.

use std::collections::BTreeMap;
use std::path::Path;

use stosszahl_model::snapshot::Fingerprint;
use stosszahl_model::{Plane, Volume};

use super::CommandError;
use super::job::{self, Job, PointRun};
use crate::case::Kind;
use crate::flow::case::Flow;
use crate::flow::export::Tables;
use crate::flow::manifest::Manifest;
use crate::flow::plan::Plan;
use crate::flow::run::{self, Record, Replica};
use crate::flow::tables::{BoundaryRow, FieldRow, ProfileRow, SeriesRow};
use crate::flow::theory::Theory;
use crate::flow::{FlowError, obstacles, outline, verdicts, warnings};
use crate::manifest::{EngineWork, FORMAT, MANIFEST_FILE, Verdict};
use crate::run::Place;
use crate::tables::Row;

impl Job for Flow {
    type Plan = (Plan, Theory);

    const FILES: &'static [&'static str] = &[
        SeriesRow::FILE,
        FieldRow::FILE,
        ProfileRow::FILE,
        BoundaryRow::FILE,
        MANIFEST_FILE,
    ];

    fn title(&self) -> &str {
        &self.title
    }

    fn plan(&self, file: &Path) -> Result<Self::Plan, CommandError> {
        plan(self).map_err(|source| CommandError::Flow {
            path: file.to_owned(),
            source,
        })
    }

    fn outline((plan, _): &Self::Plan) -> String {
        outline(plan)
    }

    fn jobs((plan, _): &Self::Plan) -> usize {
        plan.flow.replicas as usize * plan.engines().len()
    }

    fn fingerprint((plan, _): &Self::Plan) -> Fingerprint {
        let mut hash = blake3::Hasher::new();
        hash.update(env!("CARGO_PKG_VERSION").as_bytes());
        // Neither the title, nor how often the run is saved, nor how it is judged.
        let mut flow = plan.flow.clone();
        flow.title.clear();
        flow.run.checkpoint_seconds = 0.0;
        flow.verdict.false_alarm = 0.0;
        flow.fields.windows.clear();
        hash.update(&serde_json::to_vec(&flow).unwrap_or_default());
        hash.finalize().into()
    }

    fn run(run: &PointRun<'_, Self>, place: Place<'_>) -> Result<Vec<Verdict>, CommandError> {
        let ((plan, theory), folder) = (run.plan, place.folder);
        let replicas = run::run(plan, place).map_err(|source| CommandError::Run {
            folder: folder.to_owned(),
            source: Box::new(source),
        })?;
        let tables = Tables::new(plan, theory, &replicas);
        tables.write(folder)?;
        let manifest = Manifest {
            format: FORMAT,
            kind: Kind::Flow,
            program: job::program(),
            title: plan.flow.title.clone(),
            case_text: run.file.source_text.clone(),
            case: serde_json::to_value(&plan.flow).unwrap_or_default(),
            derived: (plan.derived().into_iter())
                .map(|(name, value)| (name.to_owned(), value))
                .collect(),
            machine: job::machine(),
            seed: plan.flow.seed,
            replicas: plan.flow.replicas,
            wall_seconds: run.began.elapsed().as_secs_f64(),
            size: plan.flow.domain.size.clone(),
            cells: plan.flow.fields.cells,
            engines: work(plan, &replicas),
            verdicts: verdicts(plan, theory, &replicas, &tables),
            warnings: warnings(plan),
        };
        job::write_json(&folder.join(MANIFEST_FILE), &manifest)?;
        Ok(manifest.verdicts)
    }
}

/// The plan of a case and its theory, and whether walls and obstacles have a meaning.
fn plan(flow: &Flow) -> Result<(Plan, Theory), FlowError> {
    let plan = Plan::new(flow)?;
    if flow.dimension() == 2 {
        plan.walls::<Plane>()?;
    } else {
        plan.walls::<Volume>()?;
    }
    obstacles::of(flow)?;
    let theory = Theory::new(&plan)?;
    Ok((plan, theory))
}

/// Work of each engine; named numbers are those of a replica, on average.
fn work(plan: &Plan, replicas: &[Replica]) -> Vec<EngineWork> {
    let one = |(index, name): (usize, &'static str)| {
        let runs: Vec<&Record> = replicas.iter().map(|r| &r.engines[index]).collect();
        let mut work: BTreeMap<String, f64> = BTreeMap::new();
        for run in &runs {
            for (name, number) in &run.work {
                *work.entry(name.clone()).or_default() += number / runs.len() as f64;
            }
        }
        EngineWork {
            engine: name.to_owned(),
            wall_seconds: runs.iter().map(|run| run.seconds).sum(),
            collisions: runs.iter().map(|run| run.collisions).sum(),
            work,
        }
    };
    plan.engines().into_iter().enumerate().map(one).collect()
}
