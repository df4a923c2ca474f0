//! What errors are measured against: theory where it is exact, and a large ensemble of exact dynamics elsewhere.
//!
//! The ensemble has replicas of its own, which no setting runs. It is kept in a file with its provenance, so that another
//! sweep of the same case need not make it again; a file of another case, seed or version, or one that was changed, is
//! refused.

use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use serde::Serialize;
use stosszahl_analysis::accuracy::Known;
use stosszahl_analysis::statistics::Estimate;
use stosszahl_model::snapshot::{self, Fingerprint, SnapshotError};

use super::FrontierError;
use super::measure::{Sample, Task, Workshop};
use super::quantity::{Quantity, theory};
use super::setting::{EXACT, Setting};
use crate::setup::Setup;

/// First replica of the ensemble; settings begin at zero.
const FIRST: u64 = 1 << 32;

/// Where a reference comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Source {
    /// Exact theory.
    Theory,
    /// An ensemble of exact dynamics.
    Ensemble,
}

/// A value that errors are measured against.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Reference {
    /// The value with its error.
    pub(crate) known: Known,
    /// Where it is from.
    pub(crate) source: Source,
}

/// Where the runs of an ensemble are kept: a snapshot, which knows the case that it belongs to and whether it was changed.
pub(crate) struct Cache {
    path: PathBuf,
    fingerprint: Fingerprint,
}

impl Cache {
    /// The place of the ensemble of a measured case in a folder.
    pub(crate) fn of(setup: &Setup, folder: &Path) -> Self {
        let mut exact = setup.clone();
        exact.case.engines = vec![EXACT];
        exact.case.replicas = 1;
        let fingerprint = crate::commands::paired::fingerprint(&exact);
        let name = blake3::Hash::from_bytes(fingerprint).to_hex();
        let path = folder.join(format!("reference-{}.snapshot", &name[..16]));
        Self { path, fingerprint }
    }

    /// The file.
    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    /// Identifies the case with its seed and the version of the program, in hexadecimal.
    pub(crate) fn fingerprint(&self) -> String {
        blake3::Hash::from_bytes(self.fingerprint)
            .to_hex()
            .to_string()
    }

    fn read(&self) -> Result<Vec<Sample>, FrontierError> {
        match snapshot::read(&self.path, &self.fingerprint) {
            Ok(runs) => Ok(runs),
            Err(SnapshotError::File { source, .. }) if source.kind() == ErrorKind::NotFound => {
                Ok(Vec::new())
            }
            Err(error) => Err(FrontierError::Kept(error)),
        }
    }

    fn write(&self, runs: &Vec<Sample>) -> Result<(), FrontierError> {
        Ok(snapshot::write(&self.path, &self.fingerprint, runs)?)
    }
}

/// The references of all quantities, and how many runs of exact dynamics are behind them and were made now.
pub(crate) struct References {
    /// In the order of the quantities.
    pub(crate) values: Vec<Reference>,
    /// Runs of the ensemble; none where theory knows everything.
    pub(crate) runs: usize,
    /// Those of them that were not found on disk.
    pub(crate) made: usize,
}

/// Finds the references; an ensemble of `count` runs is made or continued where theory is not exact.
///
/// # Errors
/// [`FrontierError`] if the kept ensemble is not of this case or damaged, or a run fails.
pub(crate) fn find(
    workshop: &Workshop<'_>,
    quantities: &[Quantity],
    count: usize,
    cache: &Cache,
) -> Result<References, FrontierError> {
    let setup = workshop.setup;
    let exact: Vec<Option<Known>> = quantities.iter().map(|&one| theory(setup, one)).collect();
    if exact.iter().all(Option::is_some) {
        let source = Source::Theory;
        let values = exact.into_iter().flatten();
        return Ok(References {
            values: values.map(|known| Reference { known, source }).collect(),
            runs: 0,
            made: 0,
        });
    }
    let mut runs = cache.read()?;
    let found = runs.len();
    if found < count {
        let task = Task {
            setting: Setting {
                engine: EXACT,
                disks: setup.disks,
                refinements: Vec::new(),
            },
            replicas: FIRST + found as u64..FIRST + count as u64,
        };
        let more = workshop
            .run(&[task])?
            .pop()
            .unwrap_or_else(|| Ok(Vec::new()));
        runs.extend(more.map_err(|reason| FrontierError::NoReference { reason })?);
        cache.write(&runs)?;
    }
    // As many as asked for, whatever is kept: the same sweep gives the same table.
    runs.truncate(count);
    let values = quantities
        .iter()
        .zip(exact)
        .enumerate()
        .map(|(index, (quantity, exact))| {
            if let Some(known) = exact {
                let source = Source::Theory;
                return Ok(Reference { known, source });
            }
            let values: Vec<f64> = runs.iter().map(|run| run.values[index]).collect();
            let estimate = Estimate::over_replicas(&values);
            let known = estimate.and_then(|estimate| {
                Some(Known {
                    value: estimate.value,
                    standard_error: estimate.standard_error?,
                })
            });
            let known =
                known.filter(|known| known.value.is_finite() && known.standard_error.is_finite());
            let source = Source::Ensemble;
            known
                .map(|known| Reference { known, source })
                .ok_or_else(|| FrontierError::NoReference {
                    reason: format!("{} is no number in some run", quantity.kind.name()),
                })
        });
    Ok(References {
        values: values.collect::<Result<_, _>>()?,
        runs: runs.len(),
        made: count.saturating_sub(found),
    })
}
