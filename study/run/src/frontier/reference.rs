//! Reference values of a frontier: theory where it is exact, and a large ensemble of exact dynamics
//! elsewhere.
//!
//! The ensemble has replicas of its own, which no setting runs. It is kept in a file with its
//! provenance, so that another sweep of the same case need not make it again; a file of another
//! case, seed or version, or one that was changed, is refused.

use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use stosszahl_analysis::accuracy::Known;
use stosszahl_analysis::statistics::Estimate;
use stosszahl_case::format::EnginesSpec;
use stosszahl_model::snapshot::{self, Fingerprint, SnapshotError};

use super::FrontierError;
use super::measure::{REFERENCE, Task, Workshop};
use super::quantity::{FrontierQuantity, theory};
use super::run_record::RunResult;
use super::setting::RunSetting;
use crate::plan::CasePlan;

/// Number of ensemble runs between two writes of the ensemble file.
const BATCH: usize = 64;

/// Reference value of a quantity, with its origin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Reference {
    /// Reference value and standard error, in the unit of the quantity.
    pub known: Known,
    /// True if the reference value is from an ensemble of exact dynamics; false if it is from exact
    /// theory.
    pub is_ensemble: bool,
}

/// File of the runs of a reference ensemble, with a fingerprint of its case.
pub(crate) struct Cache {
    /// Path of the ensemble file.
    pub path: PathBuf,
    fingerprint: Fingerprint,
}

impl Cache {
    /// Returns the file, inside a folder, of the reference ensemble of a case.
    pub(crate) fn ensemble_file(plan: &CasePlan, folder: &Path) -> Self {
        let mut case = plan.case.clone();
        case.engine = EnginesSpec::default();
        case.replicas = 1;
        case.title.clear();
        let mut hasher = blake3::Hasher::new();
        hasher.update(env!("CARGO_PKG_VERSION").as_bytes());
        let text = serde_json::to_string(&case).expect("a case has keys of text only");
        hasher.update(text.as_bytes());
        // Numbers of a start file, independent of its name.
        let lists = plan
            .gas
            .file
            .iter()
            .flat_map(|file| [&file.positions, &file.velocities]);
        for number in lists.flatten().flatten().flatten() {
            hasher.update(&number.to_le_bytes());
        }
        if plan.gas.file.is_some() {
            for (radius, mass) in plan.radii_and_masses() {
                hasher.update(&radius.to_le_bytes());
                hasher.update(&mass.to_le_bytes());
            }
        }
        let hash = hasher.finalize();
        Self {
            path: folder.join(format!("reference-{}.snapshot", &hash.to_hex()[..16])),
            fingerprint: *hash.as_bytes(),
        }
    }

    /// Returns a hash of the case with its seed and the program version, in hexadecimal.
    pub(crate) fn fingerprint(&self) -> String {
        blake3::Hash::from_bytes(self.fingerprint).to_hex()[..16].to_owned()
    }

    fn read_cached(&self) -> Result<Vec<RunResult>, FrontierError> {
        match snapshot::read_snapshot(&self.path, &self.fingerprint) {
            Ok(runs) => Ok(runs),
            Err(SnapshotError::File { source, .. }) if source.kind() == ErrorKind::NotFound => {
                Ok(Vec::new())
            }
            Err(error) => Err(FrontierError::Kept(error)),
        }
    }
}

/// Reference values of all quantities, with the number of ensemble runs behind them.
pub(crate) struct References {
    /// Reference values in the order of the quantities.
    pub values: Vec<Reference>,
    /// Number of runs in the reference ensemble; 0 if theory is exact for all quantities.
    pub runs: usize,
    /// Number of runs of the reference ensemble that had to be made now.
    pub made: usize,
}

/// Finds the reference values of all quantities. Where theory is not exact, an ensemble of `count`
/// runs is made or completed.
///
/// # Errors
/// [`FrontierError`] if the kept ensemble is not of this case or damaged, or a run fails.
pub(crate) fn find_references(
    workshop: &Workshop<'_>,
    quantities: &[FrontierQuantity],
    count: usize,
    cache: &Cache,
) -> Result<References, FrontierError> {
    let exact = quantities.iter().map(|&one| theory(workshop.plan, one));
    let exact: Vec<Option<Known>> = exact.collect();
    let what = "no reference";
    let failed = |reason| FrontierError::Runs { what, reason };
    let (mut runs, mut made) = (Vec::new(), 0);
    if exact.iter().any(Option::is_none) {
        runs = cache.read_cached()?;
        made = count.saturating_sub(runs.len());
        // In batches, so that little is lost where it is stopped.
        while runs.len() < count {
            let end = count.min(runs.len() + BATCH);
            let task = Task {
                setting: RunSetting::exact(workshop.plan.count()),
                replicas: REFERENCE + runs.len() as u64..REFERENCE + end as u64,
            };
            let more = workshop.one(task)?;
            runs.extend(more.map_err(failed)?);
            workshop.kept.require_same()?;
            snapshot::write_snapshot(&cache.path, &cache.fingerprint, &runs)?;
        }
        // The requested number, even if more are kept, so that one sweep gives one table.
        runs.truncate(count);
    }
    let one = |(index, (quantity, exact)): (usize, (&FrontierQuantity, Option<Known>))| {
        let of_runs = || {
            let values: Vec<f64> = runs.iter().map(|run| run.values[index]).collect();
            let estimate = Estimate::over_replicas(&values)?;
            let known = Known {
                value: estimate.value,
                standard_error: estimate.standard_error?,
            };
            (known.value.is_finite() && known.standard_error.is_finite()).then_some(known)
        };
        let is_ensemble = exact.is_none();
        let known = exact.or_else(of_runs);
        let known = known.map(|known| Reference { known, is_ensemble });
        known.ok_or_else(|| failed(format!("{} is no number in some run", quantity.kind.name())))
    };
    let values = quantities.iter().zip(exact).enumerate().map(one);
    Ok(References {
        values: values.collect::<Result<_, _>>()?,
        runs: runs.len(),
        made,
    })
}
